"""``python -m glmref``, and the program ``glmref``: the command line."""

import os
import signal
import sys
from types import FrameType


def _stop(number: int, frame: FrameType | None) -> None:
    """End at once: while modules are imported there is nothing to lose and nothing to say."""
    os._exit(128 + number)


def main() -> int:
    """Run the command line; a signal during its import ends the process without a traceback."""
    before = signal.signal(signal.SIGINT, _stop)
    from .cli import main as run

    signal.signal(signal.SIGINT, before)
    return run()


if __name__ == "__main__":
    sys.exit(main())
