"""Errors that the package raises on purpose; the text of each is one sentence for the user."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

_LONGEST = 1500  # characters of a sentence; what is longer quotes somebody's data


class GlmrefError(Exception):
    """Base of every error this package raises on purpose; its text is one sentence for the user."""

    def __str__(self) -> str:
        text = super().__str__()
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


class UsageError(GlmrefError):
    """A request that cannot be carried out as asked: unknown name, wrong argument."""


class DataError(GlmrefError):
    """A method, scene or vector file that is not what it must be.

    The message says what is wrong, where, which value, and what to do.
    """


class ExactnessError(GlmrefError):
    """An exact answer was asked for and does not exist in the field of algebraic numbers used."""


class UndecidedError(ExactnessError):
    """A question about algebraic numbers has an answer, and it was not found."""


class BudgetError(GlmrefError):
    """The processor time allowed to a proof is spent; nothing is known of what it would give."""


def did_you_mean(word: object, known: Iterable[str], before: str = "", otherwise: str = "") -> str:
    """Ask for the nearest of some names.

    Returns
    -------
    str
        Such as ``"did you mean rk4 or ark-4?"``.
    """
    text = str(word)[:80].lower()
    near = get_close_matches(text, [*known], n=3)
    return f"{before}did you mean {' or '.join(near)}?" if near else otherwise
