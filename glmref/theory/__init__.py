"""Exact theory: trees, series, order, starting methods, and what is proved from the coefficients.

Nothing here knows numpy or a step size; numbers are those of :mod:`glmref.exact`.
"""
