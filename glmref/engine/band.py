"""Which components a right-hand side couples, and an order of them in which that is a narrow band.

The structure is read from the expressions, or by running a loop body on values that remember which
components they came from. What branches on a value has no structure that holds for all states, and
none is given then. The order is that of Cuthill and McKee, reversed (Cuthill and McKee, Reducing
the bandwidth of sparse symmetric matrices, Proc. 24th ACM Nat. Conf., 1969).
"""

from __future__ import annotations

import ast
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..problems.formula import FUNCTIONS, Formula

#: A component that reads more than this fraction of the others is no part of a band.
_WIDEST = 1 / 8

Structure = list[frozenset[int]]


@dataclass(frozen=True)
class Band:
    """An order of the unknowns in which a matrix has few diagonals."""

    order: tuple[int, ...]  #: ``order[k]`` is the unknown at position k.
    #: Diagonals below and above the main one.
    lower: int
    upper: int
    entries: int  #: Entries of the matrix that are not zero.

    @property
    def width(self) -> int:
        """Number of diagonals."""
        return self.lower + self.upper + 1

    @cached_property
    def places(self) -> np.ndarray:
        """Position of each unknown, shape (n,), as doubles."""
        places = np.empty(len(self.order))
        places[list(self.order)] = np.arange(len(self.order))
        return places


def band_of(structure: Structure) -> Band | None:
    """Return the band of a square structure, which has the columns of each row that are not 0.

    ``None`` where a dense matrix is as good.
    """
    n = len(structure)
    neighbours: list[set[int]] = [set() for _ in range(n)]
    for i, row in enumerate(structure):
        for j in row:
            neighbours[i].add(j)
            neighbours[j].add(i)
    order = _reversed_cuthill_mckee(neighbours)
    place = [0] * n
    for k, i in enumerate(order):
        place[i] = k
    offsets = [place[i] - place[j] for i, row in enumerate(structure) for j in row]
    lower, upper = max(0, *offsets, 0), max(0, -min(offsets, default=0))
    if 4 * (2 * lower + upper + 1) > n:
        return None
    return Band(tuple(order), lower, upper, len(offsets))


def _reversed_cuthill_mckee(neighbours: Sequence[set[int]]) -> list[int]:
    """Order breadth first, few neighbours first, from an end of each part; then backwards."""
    seen, order = [False] * len(neighbours), []
    for first in sorted(range(len(neighbours)), key=lambda i: len(neighbours[i])):
        if seen[first]:
            continue
        part = _levels(neighbours, first)
        part = _levels(neighbours, part[-1])
        order += part
        for i in part:
            seen[i] = True
    return order[::-1]


def _levels(neighbours: Sequence[set[int]], first: int) -> list[int]:
    found, seen, waiting = [], {first}, deque([first])
    while waiting:
        i = waiting.popleft()
        found.append(i)
        new = sorted((j for j in neighbours[i] if j not in seen), key=lambda j: len(neighbours[j]))
        seen.update(new)
        waiting.extend(new)
    return found


# --- structure ----------------------------------------------------------------------------------


def formula_structure(formula: Formula) -> Structure:
    """Return components of the vector that each output reads."""
    common, outputs = formula.trees
    known: dict[str, frozenset[int]] = {}

    def read(tree: ast.expr) -> frozenset[int]:
        found: set[int] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
                found.add(int(node.slice.value))  # type: ignore[arg-type]
            elif isinstance(node, ast.Name):
                found |= known.get(node.id, frozenset())
        return frozenset(found)

    for name, tree in common:
        known[name] = read(tree)
    return [read(tree) for tree in outputs]


class _Branches(Exception):
    """What a body computes depends on a value in a way that has no structure."""


class _Value:
    """A number that remembers which components it came from."""

    __slots__ = ("read",)

    def __init__(self, read: frozenset[int]) -> None:
        self.read = read

    def _with(self, other: Any) -> _Value:
        if not isinstance(other, _Value) or other.read <= self.read:
            return self
        return _Value(self.read | other.read)

    def _alone(self, *_: Any) -> _Value:
        return self

    def _unknown(self, *_: Any) -> Any:
        raise _Branches

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _with
    __truediv__ = __rtruediv__ = __pow__ = __rpow__ = _with
    __neg__ = __pos__ = __abs__ = _alone
    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = _unknown  # type: ignore[assignment]
    __bool__ = __float__ = __int__ = __index__ = _unknown
    __hash__ = None  # type: ignore[assignment]


class _Vector(list):  # type: ignore[type-arg]
    """Components; a slice would be a copy, whose changes are lost."""

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            raise _Branches
        return super().__getitem__(index)


def loop_structure(
    text: str, name: str, size: int, count: int, params: Sequence[float], *, timed: bool
) -> Structure | None:
    """Return the components that each of ``count`` results of a loop body reads, if that is known.

    ``text`` is the source of the body ``name(v, params, out)``, or ``name(t, v, params, out)`` if
    ``timed``, with ``size`` components in ``v``.
    """
    out = _Results([0.0] * count)
    out.most = max(8, int(size * _WIDEST))
    if not _run(text, name, size, params, out, timed=timed):
        return None
    return [x.read if isinstance(x, _Value) else _NOTHING for x in out]


_NOTHING: frozenset[int] = frozenset()


class _Results(_Vector):
    """Results of a body, none of which reads more than ``most`` components."""

    most = 0

    def __setitem__(self, index: Any, value: Any) -> None:
        if isinstance(value, _Value) and len(value.read) > self.most:
            raise _Branches
        super().__setitem__(index, value)


def _run(
    text: str, name: str, size: int, params: Sequence[float], out: Any, *, timed: bool
) -> bool:
    """Run a body on values that remember; whether it came to its end."""

    def joined(*given: Any) -> Any:
        values = [x for x in given if isinstance(x, _Value)]
        return _Value(_NOTHING.union(*(x.read for x in values))) if values else 1.0

    names: dict[str, Any] = dict.fromkeys((*FUNCTIONS, "abs"), joined)
    names["compiled"] = lambda function: function
    vector = _Vector(_Value(frozenset((i,))) for i in range(size))
    try:
        exec(compile(text, "<body>", "exec"), names)
        names[name](*((_Value(_NOTHING),) if timed else ()), vector, _Vector(params), out)
    except (_Branches, ArithmeticError, TypeError, ValueError, LookupError, NameError):
        return False
    return True


# --- a Jacobian's body, writing into a band -----------------------------------------------------


class _Entries(ast.NodeTransformer):
    """``out[i, j]`` becomes the place of that entry among the diagonals."""

    def __init__(self, place: Callable[[str, str], str]) -> None:
        self.place, self.others = place, 0

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        self.generic_visit(node)
        if not isinstance(node.value, ast.Name) or node.value.id != "out":
            return node
        if not isinstance(node.slice, ast.Tuple) or len(node.slice.elts) != 2:
            self.others += 1
            return node
        row, column = (ast.unparse(x) for x in node.slice.elts)
        node.slice = ast.parse(self.place(row, column), mode="eval").body
        return node


class _Diagonals:
    """Entries of a Jacobian, refused where they are not among the diagonals of a band."""

    def __init__(self, band: Band) -> None:
        self.band, self.places = band, band.places

    def __getitem__(self, index: Any) -> Any:
        i, j = index
        if not -self.band.upper <= self.places[i] - self.places[j] <= self.band.lower:
            raise _Branches
        return _Value(_NOTHING)

    def __setitem__(self, index: Any, value: Any) -> None:
        self[index]


def stays_within(text: str, name: str, band: Band, params: Sequence[float]) -> bool:
    """Return whether a Jacobian's body writes to the diagonals of a band only, at every state."""
    return _run(text, name, len(band.order), params, _Diagonals(band), timed=True)


def written(text: str, place: Callable[[str, str], str]) -> str:
    """Return a Jacobian's body that writes entry (i, j) to ``out[place(i, j)]`` instead.

    ``""`` for a body that uses ``out`` in another way.
    """
    tree = ast.parse(text)
    function = tree.body[0]
    assert isinstance(function, ast.FunctionDef)
    rewrite = _Entries(place)
    function = rewrite.visit(function)
    names = [x for x in ast.walk(function) if isinstance(x, ast.Name) and x.id == "out"]
    entries = [x for x in ast.walk(function) if isinstance(x, ast.Subscript)]
    used = [x for x in entries if isinstance(x.value, ast.Name) and x.value.id == "out"]
    if rewrite.others or len(names) != len(used):
        return ""
    function.args.args.append(ast.arg("places"))
    return ast.unparse(ast.fix_missing_locations(function))
