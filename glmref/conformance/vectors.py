"""Read the vectors: inputs with the outputs that are right, and with those that are wrong.

A vector file holds one method; what its keys mean is said in ``data/vectors/README.md``. For a
method without a file :func:`vectors_of` makes the same document on the spot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..catalogue.lookup import load
from ..errors import DataError
from ..method import Method
from .generate import document_of
from .vector_problems import (
    FORMAT,
    TestProblem,
    array,
    document_in,
    folder,
    problems,
)


@dataclass(frozen=True, eq=False)
class Case:
    """One vector; ``data`` is its object in the file."""

    id: str  #: Claim/method/problem.
    kind: str  #: Step, start, finish, trajectory or order.
    problem: TestProblem
    data: Mapping[str, Any]

    @property
    def claim(self) -> str:
        """First word of the id."""
        return self.id.partition("/")[0]

    def __getitem__(self, key: str) -> np.ndarray:
        return array(self.data[key])

    def number(self, key: str) -> float:
        """Return one number of the case as a double."""
        return float(self.data[key])

    @property
    def input(self) -> np.ndarray:
        """Values carried into the step or the run, (r, d)."""
        return self["input"]

    @property
    def stages(self) -> list[np.ndarray]:
        """Stage values: one array, or those of Q and of P."""
        stages = self.data["stages"]
        if isinstance(stages, Mapping):
            return [array(stages["Q"]), array(stages["P"])]
        return [array(stages)]

    @property
    def wrong(self) -> list[tuple[str, np.ndarray]]:
        """(flag, what the bug gives instead of the output)."""
        return [(x["flag"], array(x["output"])) for x in self.data.get("wrong", ())]


@dataclass(frozen=True, eq=False)
class Vectors:
    """All vectors of one method."""

    name: str  #: The method's name.
    method: Method
    document: Mapping[str, Any]  #: The file.
    cases: tuple[Case, ...]  #: Its cases in order.

    @property
    def coefficients(self) -> Mapping[str, Any]:
        """Coefficients as decimals."""
        return self.document["coefficients"]


def file_names() -> list[str]:
    """Return names of the methods that have a vector file."""
    return sorted(p.stem for p in folder().glob("*.json") if p.stem != "problems")


@cache
def vectors_of(name: str) -> Vectors:
    """Return the vectors of a method of the catalogue or a method file, stored or made now.

    Raises
    ------
    UsageError, DataError
        For a name or a file that cannot be read.
    """
    method = load(name)
    if method.additive:
        raise DataError(f"{name}: vectors are made for single and partitioned methods only")
    path = folder() / f"{name}.json"
    if path.parent == folder() and path.is_file():
        document = document_in(path, FORMAT)
    else:
        document = document_of(method, name)
    known = problems()
    cases = tuple(Case(x["id"], x["kind"], known[x["problem"]], x) for x in document["cases"])
    return Vectors(name, method, document, cases)
