"""Benchmarks for asv: bodies of two or three lines, the work in setup."""

import sys
from pathlib import Path

# asv imports this folder by its name and not from the checkout, where `tools.measure` lies; last,
# so that glmref is the one that asv has installed
sys.path.append(str(Path(__file__).resolve().parents[1]))
