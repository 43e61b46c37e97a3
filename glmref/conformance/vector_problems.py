"""The problems of the vectors, and how every file of ``data/vectors`` is read and checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
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
    path = folder() / "problems.json"
    document = document_in(path, PROBLEMS_FORMAT)
    with as_specified(path):
        return _problems(document)


def _problems(document: Mapping[str, Any]) -> Mapping[str, TestProblem]:
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
        d, quadratic = problem.dimension, entry.get("quadratic")
        if quadratic is not None:
            check_numbers(quadratic, (d, d), f"quadratic of {entry['name']}")
        found[entry["name"]] = TestProblem(
            entry["name"], halves, entry["t0"], entry["y0"], quadratic, problem
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


@contextmanager
def as_specified(path: Path) -> Iterator[None]:
    """Say in one sentence that a file is not what ``data/vectors/README.md`` specifies."""
    try:
        yield
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError) as error:
        what = " ".join(f"{type(error).__name__}: {error}"[:200].split())
        raise DataError(
            f"{path.name}: the file is not as data/vectors/README.md says ({what})"
        ) from None


def check_numbers(given: Any, shape: tuple[int | None, ...], place: str) -> None:
    """Refuse what is no array of finite decimals of a shape; ``None`` is any length but 0."""
    try:
        found = array(given)
    except (TypeError, ValueError):
        raise ValueError(f"{place} is no array of decimals in strings") from None
    fits = len(found.shape) == len(shape) and all(
        n > 0 and n == (n if want is None else want)
        for n, want in zip(found.shape, shape, strict=True)
    )
    if not fits or not np.isfinite(found).all():
        wanted = " x ".join("n" if n is None else str(n) for n in shape)
        raise ValueError(f"{place} must be {wanted} finite decimals")
