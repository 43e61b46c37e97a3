"""Read the vectors: inputs with the outputs that are right, and with those that are wrong.

A vector file holds one method; what its keys mean is said in ``data/vectors/README.md``. For a
method without a file :func:`vectors_of` makes the same document on the spot.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue.lookup import data_root, load
from ..catalogue.strict_json import read_json
from ..errors import DataError
from ..method import GLM, PartitionedGLM
from ..problems import Problem

__all__ = [
    "FORMAT",
    "Case",
    "TestProblem",
    "Vectors",
    "file_names",
    "problems",
    "vectors_of",
]

FORMAT, PROBLEMS_FORMAT = "glmref-vectors-1", "glmref-vector-problems-1"


@dataclass(frozen=True, eq=False)
class TestProblem:
    """A problem of the vectors.

    Attributes
    ----------
        expressions: ``{"f": [..]}`` and, where separable, ``"dq"`` and ``"dp"``.
        t0, y0: exact decimals.
        quadratic: symmetric matrix of a conserved quadratic form, or ``None``.
        problem: the same as a :class:`glmref.Problem`.
    """

    name: str
    expressions: Mapping[str, Sequence[str]]
    t0: str
    y0: Sequence[str]
    quadratic: Sequence[Sequence[str]] | None
    problem: Problem

    @property
    def separable(self) -> bool:
        """Whether it has the two halves that pairs need."""
        return "dq" in self.expressions

    @property
    def autonomous(self) -> bool:
        """Whether f does not depend on t."""
        return not any("t" in text.replace("sqrt", "") for text in self.expressions["f"])


def folder() -> Path:
    """Where the vector files lie."""
    return data_root() / "vectors"


@cache
def problems() -> Mapping[str, TestProblem]:
    """Every problem of the vectors, by name."""
    document = _document(folder() / "problems.json", PROBLEMS_FORMAT)
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


def _document(path: Path, form: str) -> dict[str, Any]:
    value = read_json(path)
    if not isinstance(value, dict) or value.get("format") != form:
        raise DataError(f"{path.name}: the file must be a {form} document")
    return value


def array(numbers: Any) -> np.ndarray:
    """Round decimals, nested to any depth, to doubles."""
    if isinstance(numbers, str):
        return np.float64(numbers)  # type: ignore[return-value]
    return np.array([array(x) for x in numbers])


@dataclass(frozen=True, eq=False)
class Case:
    """One vector; ``data`` is its object in the file.

    Attributes
    ----------
        id: claim/method/problem. kind: step, start, finish, trajectory or order.
    """

    id: str
    kind: str
    problem: TestProblem
    data: Mapping[str, Any]

    @property
    def claim(self) -> str:
        """First word of the id."""
        return self.id.partition("/")[0]

    def __getitem__(self, key: str) -> np.ndarray:
        return array(self.data[key])

    def number(self, key: str) -> float:
        """One number of the case as a double."""
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
    """All vectors of one method.

    Attributes
    ----------
        name: the method's name. method: the method itself.
        document: the file. cases: its cases in order.
    """

    name: str
    method: GLM | PartitionedGLM
    document: Mapping[str, Any]
    cases: tuple[Case, ...]

    @property
    def coefficients(self) -> Mapping[str, Any]:
        """Coefficients as decimals."""
        return self.document["coefficients"]

    @property
    def notes(self) -> Mapping[str, Mapping[str, str]]:
        """Flag -> ``{"bug", "effect"}``."""
        return self.document["notes"]


def file_names() -> list[str]:
    """Names of the methods that have a vector file."""
    return sorted(p.stem for p in folder().glob("*.json") if p.stem != "problems")


@cache
def vectors_of(name: str) -> Vectors:
    """Return the vectors of a method, from its file or made now.

    Args:
        name: a name of the catalogue, or the path of a method file.

    Raises
    ------
        UsageError, DataError: for a name or a file that cannot be read.
    """
    method = load(name)
    path = folder() / f"{name}.json"
    if path.parent == folder() and path.is_file():
        document = _document(path, FORMAT)
    else:
        from .generate import document_of

        document = document_of(method, name)
    known = problems()
    cases = tuple(Case(x["id"], x["kind"], known[x["problem"]], x) for x in document["cases"])
    return Vectors(name, method, document, cases)
