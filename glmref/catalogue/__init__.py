"""Data files: their keys, how they are read and written, and how they are found by name."""
