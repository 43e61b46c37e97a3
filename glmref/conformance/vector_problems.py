"""The problems of the vectors, and how a file of ``data/vectors`` is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue.lookup import data_root
from ..catalogue.strict_json import read_json
from ..errors import DataError
from ..problems import Problem

FORMAT, PROBLEMS_FORMAT = "glmref-vectors-1", "glmref-vector-problems-1"


@dataclass(frozen=True, eq=False)
class TestProblem:
    """A problem of the vectors."""

    name: str
    #: ``{"f": [..]}`` and, where separable, ``"dq"`` and ``"dp"``.
    expressions: Mapping[str, Sequence[str]]
    #: Exact decimals.
    t0: str
    y0: Sequence[str]
    #: Symmetric matrix of a conserved quadratic form, or ``None``.
    quadratic: Sequence[Sequence[str]] | None
    problem: Problem  #: The same as a :class:`glmref.Problem`.

    @property
    def separable(self) -> bool:
        """Whether it has the two halves that pairs need."""
        return "dq" in self.expressions

    @property
    def autonomous(self) -> bool:
        """Whether f does not depend on t."""
        return not any("t" in text.replace("sqrt", "") for text in self.expressions["f"])


def folder() -> Path:
    """Return where the vector files lie."""
    return data_root() / "vectors"


@cache
def problems() -> Mapping[str, TestProblem]:
    """Return every problem of the vectors, by name."""
    document = document_in(folder() / "problems.json", PROBLEMS_FORMAT)
    found = {}
    for entry in document["problems"]:
        halves = {k: tuple(entry[k]) for k in ("f", "dq", "dp") if k in entry}
        t0 = float(entry["t0"])
        problem = Problem(
            name=entry["name"],
            y0=tuple(entry["y0"]),
            t_span=(t0, t0 + 1.0),
            f=halves["f"],
            dq=halves.get("dq"),
            dp=halves.get("dp"),
        )
        found[entry["name"]] = TestProblem(
            entry["name"], halves, entry["t0"], entry["y0"], entry.get("quadratic"), problem
        )
    return found


def document_in(path: Path, form: str) -> dict[str, Any]:
    """Read a document of this format."""
    value = read_json(path)
    if not isinstance(value, dict) or value.get("format") != form:
        raise DataError(f"{path.name}: the file must be a {form} document")
    return value


def array(numbers: Any) -> np.ndarray:
    """Round decimals, nested to any depth, to doubles."""
    if isinstance(numbers, str):
        return np.float64(numbers)  # type: ignore[return-value]
    return np.array([array(x) for x in numbers])
