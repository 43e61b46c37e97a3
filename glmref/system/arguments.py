"""Arguments of public functions: read, or refused in one sentence that names them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from operator import index
from pathlib import Path
from typing import Any

from ..errors import GlmrefError, UsageError, did_you_mean, shortened

#: Makes an error of its sentence: a class of errors, or what adds the place to the sentence.
Refusal = Callable[[str], GlmrefError]


def shown(value: object, write: Callable[[Any], str] = repr, most: int = 60) -> str:
    """Write any value in one short line: also one that is long, or cannot be written.

    What is longer than ``most`` characters ends in dots and its length.
    """
    try:
        text = " ".join(write(value).split())
    except Exception:  # such as a whole number of thousands of digits
        kind = type(value).__name__
        return "a whole number with thousands of digits" if kind == "int" else f"a {kind}"
    return "".join(x if x.isprintable() else "?" for x in shortened(text, most))


def one_of(name: str, value: Any, known: Collection[str], error: Refusal = UsageError) -> str:
    """Return a word that is one of those known.

    Raises
    ------
    GlmrefError
        Of ``error``, for anything else.
    """
    if not isinstance(value, str) or value not in known:
        near = did_you_mean(shown(value, str), known, "; ")
        raise error(f"`{name}` must be one of {', '.join(known)}, got {shown(value)}{near}")
    return str(value)


def no_such(kind: str, name: object, known: Collection[str], otherwise: str = "") -> UsageError:
    """Return the refusal of a name: it proposes the nearest ones known, or else what is said."""
    otherwise = otherwise or f"there are {', '.join(known)}"
    hint = did_you_mean(shown(name, str, 80), known, otherwise=otherwise)
    return UsageError(f"there is no {kind} named {shown(name)}; {hint}")


def unknown_key(
    given: Iterable[object], allowed: Collection[str], where: str = "", kind: str = "key"
) -> str:
    """Return a sentence on the first key that is not allowed, an empty text where there is none."""
    for key in given:
        if key not in allowed:
            near = did_you_mean(shown(key, str, 80), allowed, "; ")
            known = ", ".join(allowed) or "none"
            return f"the {kind} {shown(key)} is unknown{where}; allowed are {known}{near}"
    return ""


def listed(
    name: str, value: Any, what: str = "a list of numbers", error: Refusal = UsageError
) -> Collection[Any]:
    """Return a list, or what has a length and is gone through as one; not a text, nor a mapping.

    ``what`` says in the refusal what is required.

    Raises
    ------
    GlmrefError
        Of ``error``, for anything else, such as a generator, which may have no end.
    """
    try:
        if isinstance(value, str | bytes | bytearray | Mapping):
            raise TypeError
        _ = len(value), iter(value)
    except Exception:  # whatever a class of the user raises
        raise error(f"`{name}` must be {what}, got {shown(value)}") from None
    return value


def whole(
    name: str, value: Any, least: int = 0, most: int | None = None,
    error: Refusal = UsageError,
) -> int:  # fmt: skip
    """Return a whole number within limits, of Python or of numpy.

    Raises
    ------
    GlmrefError
        Of ``error``, for anything else; ``True`` is no number.
    """
    try:
        found = None if isinstance(value, bool) else index(value)
    except Exception:  # whatever a class of the user raises
        found = None
    if found is None or found < least or (most is not None and found > most):
        limits = f">= {least}" if most is None else f"from {least} to {most}"
        raise error(f"`{name}` must be a whole number {limits}, got {shown(value)}")
    return found


def number(name: str, value: Any, error: Refusal = UsageError) -> float:
    """Return a finite real number as a double: also of a Fraction, a Decimal, a decimal in a text.

    Raises
    ------
    GlmrefError
        Of ``error``, for anything else; complex numbers and ``True`` are none.
    """
    kind = getattr(getattr(value, "dtype", None), "kind", "f")
    try:
        # numpy drops imaginary parts, and makes numbers of lengths of time
        if isinstance(value, bool | bytes | bytearray) or kind not in "fiuO":
            raise TypeError
        found = float(value)
    except OverflowError:
        raise error(f"`{name}` must be finite, got a number beyond double precision") from None
    except Exception:  # whatever a class of the user raises
        raise error(f"`{name}` must be a number, got {shown(value)}") from None
    if not math.isfinite(found):
        raise error(f"`{name}` must be finite, got {shown(value)}")
    return found


def flag(name: str, value: Any) -> bool:
    """Return True or False, of Python or of numpy; a :class:`UsageError` for anything else."""
    kind = getattr(getattr(value, "dtype", None), "kind", "")
    if isinstance(value, bool) or (kind == "b" and value.shape == ()):
        return bool(value)
    raise UsageError(f"`{name}` must be True or False, got {shown(value)}")


def place(name: str, value: Any) -> Path:
    """Return where a file is or will be; a :class:`UsageError` for neither a text nor a path."""
    if not isinstance(value, str | Path):
        raise UsageError(f"`{name}` must be a file, got {shown(value)}")
    return Path(value)
