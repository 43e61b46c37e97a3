"""From solved unknowns to a method file: decimals, canonical order, one place to write.

A file is written only after :func:`glmref.prove.enclosure.prove` has proved it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from ..exact import Ball, Exact, Scalar
from . import claims
from .canonical import canonical

#: Digits after the point of every published decimal.
DIGITS = 75
#: Claims of every symmetric G-symplectic method without parasitic growth.
SYMMETRIC = {
    x.key: True
    for x in (
        *(claims.PRECONSISTENT, claims.CONSISTENT, claims.ZERO_STABLE),
        *(claims.G_SYMPLECTIC, claims.SYMMETRIC, claims.PARASITISM_FREE),
    )
}


def decimal(value: Scalar, places: int = DIGITS) -> str:
    """Write a number, or a midpoint, with so many digits after the point, rounded to nearest."""
    exact = value.as_fraction() if isinstance(value, Exact) else None
    near = Fraction(value.ball().decimal_text(places + 40)) if exact is None else exact
    scaled = round(near * 10**places)
    digits = str(abs(scaled)).rjust(places + 1, "0")
    return f"{'-' if scaled < 0 else ''}{digits[:-places]}.{digits[-places:]}"


def fill(document: Mapping[str, Any], values: Sequence[Ball]) -> dict[str, Any]:
    """Return the document with its unknowns set to the given values."""
    names = list(document["unknowns"])
    unknowns = {name: decimal(x) for name, x in zip(names, values, strict=True)}
    return {**document, "digits": DIGITS, "unknowns": unknowns}


def write(document: Mapping[str, Any], folder: Path) -> Path:
    """Write a method document in canonical form; the file name is the method's name."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{document['name']}.json"
    path.write_text(canonical(document), encoding="utf-8")
    return path
