"""Attacks on the package: seeded, counted, each also runnable as ``python -m tests.attack NAME``."""
