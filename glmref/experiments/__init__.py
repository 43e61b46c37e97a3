"""Measurements: each function returns a record; tests, ``verify`` and scenes judge.

This room never imports :mod:`glmref.theory`: it is the second witness.
"""
