"""Run the judge on files of certificates: ``python -m glmref.judge FILE...``."""

import sys

from .command import main

if __name__ == "__main__":
    sys.exit(main())
