"""Refusals, and readers of small JSON values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NoReturn, TypeAlias, TypeVar

T = TypeVar("T")

#: An object of a certificate, not read yet.
Document: TypeAlias = Mapping[str, object]

SIZE = 200  # rows and columns of a matrix of the document


class Refused(Exception):
    """The certificate proves nothing: the answer is no."""

    def __str__(self) -> str:
        text = self.sentence()
        return text if len(text) <= 200 else f"{text[:200]}..."

    def sentence(self) -> str:
        """Return what is refused, of any length."""
        return str(self.args[0]) if self.args else "refused"


class NotShown(Refused):
    """Something that a rule needs does not hold."""


class Undecided(Refused):
    """Something that a rule needs may hold or not: an interval holds 0."""


class NotCovered(Refused):
    """The judge does not decide statements of this kind."""


class Beyond(Refused):
    """The certificate needs more time or space than the limits allow."""


class Malformed(Refused):
    """A member of the certificate is missing, unknown or of another type."""


class NoCertificate(Malformed):
    """The value does not have the members of a certificate: the exit code is 2."""


class Unreadable(Exception):
    """The file is not JSON, or its value is no certificate: the exit code is 2."""


def require(truth: object, why: str) -> None:
    """Refuse unless `truth`."""
    if not truth:
        raise NotShown(why)


def shown(value: T | None, why: str) -> T:
    """Return a value that is not None; refuse None."""
    if value is None:
        raise NotShown(why)
    return value


def matched(pattern: str | re.Pattern[str], text: object, why: str) -> re.Match[str]:
    """Return the match of a whole text; refuse another one, and what is no text."""
    return shown(re.fullmatch(pattern, text) if isinstance(text, str) else None, why)


def not_covered(what: str) -> NoReturn:
    """Refuse what the judge does not decide."""
    raise NotCovered(f"not covered: {what}")


def beyond(_number: object = None, _frame: object = None) -> NoReturn:
    """Refuse what takes too long."""
    raise Beyond("beyond the limits of this checker")


def keys(thing: object, needed: str, optional: str = "", where: str = "witness") -> None:
    """Refuse an object whose keys are not the `needed` ones and some `optional` ones."""
    if not isinstance(thing, dict):
        raise Malformed(f"the {where} is no object")
    for key in needed.split():
        if key not in thing:
            raise Malformed(f"the {where} has no key {key!r}")
    for key in thing:
        if key not in needed.split() + optional.split():
            raise Malformed(f"the {where} has an unknown key {key!r}")


def whole(value: object, low: int = 0, high: int = 20) -> int:
    """Return an integer within bounds."""
    if type(value) is not int or not low <= value <= high:
        raise Malformed(f"{value!r} is no whole number in bounds")
    return value


def as_object(value: object, why: str = "an object is missing") -> Document:
    """Return an object of the certificate."""
    if not isinstance(value, dict):
        raise Malformed(why)
    return value


def as_list(value: object, why: str = "a list is missing") -> list:
    """Return a list of the certificate."""
    if not isinstance(value, list):
        raise Malformed(why)
    return value


def as_text(value: object, why: str = "a text is missing") -> str:
    """Return a text of the certificate."""
    if not isinstance(value, str):
        raise Malformed(why)
    return value
