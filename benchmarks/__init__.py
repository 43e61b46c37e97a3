"""Benchmarks for asv: bodies of two or three lines, the work in setup."""
