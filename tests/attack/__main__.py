"""``python -m tests.attack NAME --count N --seed S``: run one attack and print what came of it.

Each module but those that several use is an attack. It offers ``COUNT``, the number of cases in full, and either
``main(count, seed)``, which prints counts and violations and returns the exit code, ``attack(count, seed, say)``, which
returns a :class:`.tally.Tally`, or what :mod:`.texts` runs.
"""

import argparse
import importlib
import sys
from pathlib import Path

from . import texts

FOLDER = Path(__file__).parent


def main(arguments: list[str] | None = None) -> int:
    """Run the attack named; the exit code is 1 where something was violated."""
    others = {"odd", "tally", "texts", "__main__", "__init__"}
    names = sorted(p.stem for p in FOLDER.glob("*.py") if p.stem not in others)
    names = [name for name in names if not name.startswith("test_")]
    parser = argparse.ArgumentParser(prog="python -m tests.attack", description=__doc__)
    parser.add_argument("name", choices=names)
    parser.add_argument("--count", type=int, default=None, help="cases; each attack has its own")
    parser.add_argument("--seed", type=int, default=1, help="seed of the cases")
    given = parser.parse_args(arguments)
    module = importlib.import_module(f".{given.name}", __package__)
    count = module.COUNT if given.count is None else given.count
    if hasattr(module, "main"):
        return int(module.main(count, given.seed) or 0)
    if hasattr(module, "attack"):
        return module.attack(count, given.seed, lambda line: print(line, flush=True)).printed()
    return texts.main(module, count, given.seed)


if __name__ == "__main__":
    sys.exit(main())
