"""Errors that the package raises on purpose; the text of each is one sentence for the user."""

from __future__ import annotations

__all__ = ["DataError", "ExactnessError", "GlmrefError", "UsageError"]


class GlmrefError(Exception):
    """Base of every error this package raises on purpose; its text is one sentence for the user."""


class UsageError(GlmrefError):
    """A request that cannot be carried out as asked: unknown name, wrong argument."""


class DataError(GlmrefError):
    """A method, scene or vector file that is not what it must be.

    The message says what is wrong, where, which value, and what to do.
    """


class ExactnessError(GlmrefError):
    """An exact answer was asked for and does not exist in the field of algebraic numbers used."""
