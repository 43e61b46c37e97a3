"""Measurements behind pages of the documentation, one file of `data/measurements` each."""
