"""Reference states: computed twice at different precision, stored with the digits that agree."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue.strict_json import read_json
from ..errors import DataError

FORMAT = "glmref-solution-1"


@dataclass(frozen=True)
class Reference:
    """The state of a problem at one time."""

    t: Fraction  #: Time, as an exact fraction.
    #: (d,) decimal strings; each component has the digits on which two computations agree.
    state: tuple[str, ...]
    agreement: float  #: Largest difference of the two, relative to the largest component.
    generator: str  #: How it was computed.
    source: str = ""  #: Citation of published digits that it confirms, or ``""``.

    def rounded(self) -> np.ndarray:
        """Return the state rounded to double precision, shape (d,)."""
        return np.array([float(x) for x in self.state])


def references_of(name: str, parameters: Mapping[str, Any]) -> tuple[Reference, ...]:
    """Return the shipped references of a problem with these parameters, sorted by time."""
    from ..catalogue.lookup import data_root

    path = data_root() / "solutions" / f"{name}.json"
    if not path.is_file():
        return ()
    wanted = {k: float(v) for k, v in parameters.items()}
    found = [reference for given, reference in read_references(path) if given == wanted]
    return tuple(sorted(found, key=lambda reference: reference.t))


@cache
def read_references(path: Path) -> tuple[tuple[dict[str, float], Reference], ...]:
    """Read a file of the format ``glmref-solution-1``: pairs (parameters, reference).

    Raises
    ------
    DataError
        For a file that is not what it must be.
    """
    document = read_json(path)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise DataError(f"{path.name}: `format` must be {FORMAT!r}")
    if document.get("problem") != path.stem:
        raise DataError(f"{path.name}: `problem` must be the file's name {path.stem!r}")
    try:
        return tuple(_entry(entry) for entry in document["solutions"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DataError(
            f"{path.name}: a solution is incomplete or not a number ({error})"
        ) from None


def _entry(entry: Mapping[str, Any]) -> tuple[dict[str, float], Reference]:
    parameters = {k: float(Fraction(v)) for k, v in entry["parameters"].items()}
    for digits in entry["state"]:
        Fraction(digits)
    reference = Reference(
        t=Fraction(entry["t"]),
        state=tuple(entry["state"]),
        agreement=float(entry["agreement"]),
        generator=entry["generator"],
        source=entry.get("source", ""),
    )
    return parameters, reference
