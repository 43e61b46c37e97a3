"""Errors that the package raises on purpose; the text of each is one sentence for the user."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

_LONGEST = 1500  # characters of a sentence; what is longer quotes somebody's data
LONGEST_QUOTE = 120  # characters of a value in a sentence
#: Values in a sentence: texts in quotes and lists. Apostrophes within words begin none.
_QUOTED = re.compile(r"""(?<!\w)'[^']*'|(?<!\w)"[^"]*"|\[[^][]*\]""")


def shortened(text: str, most: int = LONGEST_QUOTE) -> str:
    """Return a text of at most ``most`` characters; what is longer ends in dots and its length."""
    return text if len(text) <= most else f"{text[: most - 20]}... ({len(text)} characters)"


class GlmrefError(Exception):
    """Base of every error this package raises on purpose; its text is one sentence for the user.

    The sentence quotes at most :data:`LONGEST_QUOTE` characters of a value.
    """

    def __str__(self) -> str:
        text = super().__str__()
        if len(text) > LONGEST_QUOTE:
            text = _QUOTED.sub(lambda found: shortened(found[0]), text)
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


class UsageError(GlmrefError):
    """A request that cannot be carried out as asked: unknown name, wrong argument."""


class DataError(GlmrefError):
    """A method, scene or vector file that is not what it must be.

    The message says what is wrong, where, which value, and what to do.
    """


class ExactnessError(GlmrefError):
    """A requested exact answer does not exist in the field of algebraic numbers used."""


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
