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
from .faults import NOTES
from .generate import document_of
from .vector_problems import (
    FORMAT,
    TestProblem,
    array,
    as_specified,
    check_numbers,
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

    @property
    def notes(self) -> Mapping[str, Mapping[str, str]]:
        """Flag -> ``{"bug", "effect"}``."""
        return self.document["notes"]


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
    with as_specified(path):
        cases = tuple(Case(x["id"], x["kind"], known[x["problem"]], x) for x in document["cases"])
        found = Vectors(name, method, document, cases)
        _check(found)
    return found


#: Kind of a case -> the numbers and the arrays it must have.
_PARTS = {
    "step": ("t h bound rounding", "input output"),
    "start": ("t h bound rounding", "output"),
    "finish": ("t h bound rounding", "input output"),
    "trajectory": ("t h steps bound rounding", "solution output"),
    "order": ("t t_end order bound", "exact"),
}
#: Most steps of a row of an order case; every integrator that is tested takes them one by one.
MOST_STEPS = 10_000
#: Claims of steps; the cases of the other kinds have their kind as the claim.
_STEPS = ("step", "abscissae", "backward", "symmetric")


def _check(vectors: Vectors) -> None:
    """Read every number of a file once."""
    r = int(vectors.document["values"])
    pair = "q" in vectors.coefficients
    blocks = [vectors.coefficients[x] for x in "qp"] if pair else [vectors.coefficients]
    for block, other in zip(blocks, blocks[::-1], strict=True):
        s, slopes = len(block["A"]), len(other["A"])  # a half of a pair has the other's slopes
        shapes: dict[str, tuple[int, ...]] = {} if pair else {"c": (s,)}
        shapes |= {"A": (s, slopes), "U": (s, r), "B": (r, slopes), "V": (r, r)}
        for key, shape in shapes.items():
            check_numbers(block[key], shape, f"{key} of the coefficients")
    if "G" in vectors.coefficients:
        check_numbers(vectors.coefficients["G"], (r, r), "G of the coefficients")
    for case in vectors.cases:
        _check_case(case, r, pair)
        for flag in (*case.data.get("flags", ()), *(flag for flag, _ in case.wrong)):
            if flag not in vectors.notes or flag not in NOTES:
                raise ValueError(f"{case.id} names a bug {flag!r} without a note")


def _check_case(case: Case, r: int, pair: bool) -> None:
    d = case.problem.problem.dimension
    claims = _STEPS if case.kind == "step" else (case.kind,)
    if case.claim.rstrip("0123456789" if case.kind == "order" else "") not in claims:
        raise ValueError(f"the id {case.id!r} begins with no claim of the kind {case.kind}")
    numbers, arrays = _PARTS[case.kind]
    given = [x for x in ("conserved",) if x in case.data]
    if not all(np.isfinite(case.number(x)) for x in (*numbers.split(), *given)):
        raise ValueError(f"a number of {case.id} is not finite")
    if not case.number("h" if "h" in numbers.split() else "t_end"):
        raise ValueError(f"{case.id} has a step of size 0")
    if given and case.problem.quadratic is None:
        raise ValueError(f"{case.id} conserves a form that {case.problem.name} does not have")
    shapes = {"solution": (None, d), "exact": (d,), "input": (r, d), "output": (r, d)}
    if case.kind == "finish":
        shapes["output"] = (1, d)
    for key in arrays.split() + (["input"] if "input" in case.data else []):
        check_numbers(case.data[key], shapes[key], f"{key} of {case.id}")
    if case.kind == "step":
        stages = case.data["stages"]
        for part in (stages["Q"], stages["P"]) if pair else (stages,):
            check_numbers(part, (None, d // 2 if pair else d), f"stages of {case.id}")
    if case.kind == "trajectory" and len(case["solution"]) != int(case.data["steps"]) + 1:
        raise ValueError(f"solution of {case.id} has {len(case['solution'])} rows")
    for row in case.data["rows"] if case.kind == "order" else ():
        if not 1 <= int(row["steps"]) <= MOST_STEPS or not 0 < float(row["error"]) < np.inf:
            raise ValueError(
                f"a row of {case.id} has {row['steps']} steps and the error {row['error']}"
            )
        if "input" in row:
            check_numbers(row["input"], (r, d), f"input of {case.id}")
    for x in case.data.get("wrong", ()):
        shape = (1, d) if case.kind == "trajectory" else shapes["output"]
        check_numbers(x["output"], shape, f"wrong output {x['flag']!r} of {case.id}")
