"""``python -m glmref``, and the program ``glmref``: the command line."""

import os
import signal
import sys
from types import FrameType


def _stop(number: int, frame: FrameType | None) -> None:
    """End at once: before and after a command there is nothing to lose and nothing to say."""
    os._exit(128 + number)


def main() -> int:
    """Run the command line; a signal before or after it ends the process without a traceback."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, _stop)
    if hasattr(signal, "SIGCHLD"):
        # a caller that ignores it hands that on, and no child could be waited for
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    from .cli import main as run

    code = run()
    if code > 128:  # ended by a signal: what is said is said, and no thread or child is waited for
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
