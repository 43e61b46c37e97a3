"""Tableaux that are in use: one call that checks one, readers of public codes, and the audit."""

from .check import CheckFailed, assert_tableau, check

__all__ = ["CheckFailed", "assert_tableau", "check"]
