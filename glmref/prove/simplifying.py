"""Runge-Kutta and Rosenbrock methods within the digits of a file: equations, and D(1).

A file of class ``rk`` or ``rosenbrock`` with an ``enclosure`` names as many equations as it has
unknowns. With ``Phi(t) = b . prod A Phi`` the elementary weight of a tree (c = A 1):

    order T             Phi(T) = 1 / gamma(T)
    embedded NAME T     the same with the weights of the row NAME of ``embedded``
    column J            sum_i b_i a_ij = b_j (1 - c_j), the simplifying assumption D(1) at J
    stage I K           sum_j a_Ij c_j^(K-1) = c_I^K / K, the simplifying assumption C(K) at I

The trees of a Rosenbrock method have two colours (:mod:`glmref.method.rosenbrock`): alpha stands
below a vertex 1 and alpha + gamma below a vertex 2, so that the colour of a leaf makes no
difference. It has no ``column``: every condition is an equation, or another leaf of one.

Equations that hold for all values of the unknowns, decided where the entries are affine in them,
need not be named.

**Theorem.** Let D(1) hold at every column, and let t = [u] with u = [t_1 .. t_k]. Then ``Phi(t) =
b A x = b (1 - C) x = Phi(u) - Phi([o t_1 .. t_k])`` with x the product of the A Phi(t_i), and
1 / gamma satisfies the same relation: the condition of t follows from two others, of u and of a
tree whose root has one child more. For t = [o] it reads 2 Phi([o]) = Phi(o). So the trees whose
root has two children or more, and o, are enough (Butcher, "Numerical Methods for Ordinary
Differential Equations" (2016), section 321; Hairer, Norsett, Wanner 1993, II.1 and II.5).

**Theorem** (Butcher 1964). Let B(2s) hold, ``sum b_j c_j^(k-1) = 1/k`` through k = 2s, and C(s) at
every stage. Then the c_i differ, since no quadrature with fewer than s nodes is exact on the square
of the product of all x - c_i; that product is orthogonal to all polynomials of degree below s, so
that the c_i are the zeros of the shifted Legendre polynomial, and the method is the Gauss method:
of order 2s and stage order s, symplectic (Sanz-Serna 1988), symmetric and A-stable (Ehle 1969).
Where ``a_(s+1-i),(s+1-j) = b_j - a_ij`` and ``b_(s+1-j) = b_j`` for all values of the
unknowns, c_(s+1-i) = 1 - c_i by B(1), and with p(x) = (1 - x)^(k-1) ``sum_j (b_j - a_ij) p(c_j)``
is the integral of p from c_i to 1: by B(k) and C(k) at the stage i, C(k) holds at s + 1 - i. At the
middle stage it says so of odd k by itself, of what holds below k. B(k) of even k follows from those
below, since ``sum b_j (c_j - 1/2)^(k-1) = 0``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..errors import DataError, ExactnessError
from ..exact import Exact, ball, linalg
from ..method.component import ROOTED, Palette
from ..theory.trees import MAX_ORDER, Tree, parse_tree, single, stands, tree, trees
from .enclosure import WIDTH, root_of
from .krawczyk import Krawczyk
from .system import Affine, row_reader

_FORMS = {
    "order": r"(?P<tree>\S+)",
    "embedded": r"(?P<row>.+) (?P<tree>\S+)",
    "column": r"(?P<number>[1-9]\d{0,2})",
    "stage": r"(?P<number>[1-9]\d{0,2}) (?P<power>[1-9]\d{0,2})",
}
#: By colour, the matrix that stands below a vertex.
Below = Mapping[str, Any]
_EXAMPLES = "'order [o[o]]', 'embedded NAME [o]', 'column 2' or 'stage 1 2'"
#: Order through which the conditions of a Gauss method, all implied, are enclosed once more.
_CHECKED = 8


@dataclass(frozen=True)
class _Equation:
    """One named equation: at a tree with b or the weights of a row, a column or a stage from 0."""

    text: str
    row: str = ""
    tree: Tree | None = None
    number: int = 0
    power: int = 0  # K of ``stage I K``

    @classmethod
    def read(cls, text: str) -> _Equation:
        kind, _, rest = text.partition(" ")
        match = re.fullmatch(_FORMS.get(kind, r"(?!)"), rest)
        if match is None:
            raise DataError(f"the equation {text[:60]!r} is unknown; write {_EXAMPLES}")
        found = match.groupdict()
        if kind in ("column", "stage"):
            return cls(text, number=int(found["number"]) - 1, power=int(found.get("power") or 0))
        return cls(text, found.get("row") or "", parse_tree(found["tree"]))


class RungeKuttaSystem:
    """The unknowns and equations of one document of class ``rk`` or ``rosenbrock``.

    Parameters
    ----------
    document : Mapping[str, Any]
        The parsed JSON object.

    Attributes
    ----------
    unknowns, equations
        In the order of the file.
    rows : Mapping[str, Sequence[str]]
        Texts of the weights by name, b under ``""``.

    Raises
    ------
    DataError
        For equations without a meaning, and for a file that gives ``c`` or a start.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        for key in ("c", "dense", "starting", "finishing"):
            if key in document:
                raise DataError(f"`{key}` has no meaning beside an `enclosure` of class 'rk'")
        self.document = document
        self.unknowns: tuple[str, ...] = tuple(document.get("unknowns", {}))
        self.rows: dict[str, Sequence[str]] = {"": document["b"]}
        for row in document.get("embedded", ()):
            if "b" not in row:
                raise DataError("beside an `enclosure`, rows of `embedded` are given by their `b`")
            self.rows[row["name"]] = row["b"]
        self.rosenbrock = document["class"] == "rosenbrock"
        texts = document.get("enclosure", {}).get("equations", ())
        self.equations = tuple(map(_Equation.read, texts))
        for e in self.equations:
            if e.row not in self.rows:
                raise DataError(f"{e.text!r} must name a row of `embedded`")
            if e.tree is None and (e.number >= self.s or self.rosenbrock):
                kind = "stage" if e.power else "column"
                raise DataError(f"{e.text!r} must name a {kind} from 1 to {self.s} of class 'rk'")
            if e.power > self.s:
                raise DataError(f"{e.text!r} must name a power from 1 to {self.s}")
            if e.tree is not None and e.tree.colour not in self.palette:
                raise DataError(f"{e.text!r} must name a tree of {', '.join(self.palette)}")

    @property
    def s(self) -> int:
        """Number of stages."""
        return len(self.rows[""])

    @property
    def palette(self) -> Palette:
        """The colours of the trees with those of their children."""
        return {"1": "12", "2": "12"} if self.rosenbrock else ROOTED

    def read(self, values: Mapping[str, Any]) -> tuple[Below, dict[str, Sequence[Any]]]:
        """Return what stands below a vertex of each colour, and the rows, at given unknowns."""
        row = row_reader(self.document, values)

        def matrix(key: str) -> tuple[Any, ...]:
            return tuple(row(x) for x in self.document[key])

        rows: dict[str, Sequence[Any]] = {name: row(x) for name, x in self.rows.items()}
        if not self.rosenbrock:
            return {"o": matrix("A")}, rows
        alpha = matrix("alpha")
        return {"1": alpha, "2": linalg.add(alpha, matrix("gamma"))}, rows

    def residuals(self, values: Sequence[Any]) -> list[Any]:
        """Return the left minus right side of every equation, in the order of the file."""
        below, rows = self.read(dict(zip(self.unknowns, values, strict=True)))
        weight = _weights(below)

        def residual(e: _Equation) -> Any:
            if e.tree is not None:
                return linalg.dot(rows[e.row], weight(e.tree)) - Exact(1) / e.tree.density
            if e.power:
                c_to_k = weight(_bush(e.power + 1))[e.number]
                return (
                    linalg.dot(below["o"][e.number], weight(_bush(e.power)))
                    - Exact(1) / e.power * c_to_k
                )
            return _column(below["o"], rows[""], e.number)

        return [residual(e) for e in self.equations]

    @cached_property
    def _affine(self) -> tuple[Below, dict[str, Sequence[Any]]] | None:
        """The entries as affine expressions in the unknowns, ``None`` where they are not."""
        try:
            return self.read({name: Affine.unknown(name) for name in self.unknowns})
        except DataError:
            return None

    @cached_property
    def has_columns(self) -> bool:
        """Whether D(1) is given at every column, by an equation or for all values."""
        named = {e.number for e in self.equations if e.tree is None and not e.power}
        return all(j in named or self._vanishes(j) for j in range(self.s))

    def _vanishes(self, j: int) -> bool:
        if self._affine is None or self.rosenbrock:
            return False
        below, rows = self._affine
        try:
            residual = _column(below["o"], rows[""], j)
        except DataError:  # a product of two unknowns
            return False
        return Affine.of(residual).is_identically_zero()

    @cached_property
    def _is_mirrored(self) -> bool:
        """Whether ``a_i'j' = b_j - a_ij`` and ``b_j' = b_j``, i' = s + 1 - i, identically."""
        if self._affine is None or self.rosenbrock:
            return False
        A, b = self._affine[0]["o"], self._affine[1][""]
        gaps = [x - y for x, y in zip(b, reversed(b), strict=True)]
        for row, other in zip(A, reversed(A), strict=True):
            gaps += [x + y - z for x, y, z in zip(row, reversed(other), b, strict=True)]
        return all(Affine.of(x).is_identically_zero() for x in gaps)

    def _has_stage(self, i: int, k: int) -> bool:
        """Return whether C(k) is given at a stage, where it is so below k and with B(k)."""
        named, mirror = {(e.number, e.power) for e in self.equations if e.power}, self.s - 1 - i
        if k == 1 or (i, k) in named:
            return True
        return self._is_mirrored and ((mirror, k) in named or (i == mirror and k % 2 == 1))

    @cached_property
    def is_gauss(self) -> bool:
        """Whether B(2s), and C(s) at every stage, are given."""
        orders, stages = range(1, 2 * self.s + 1), range(self.s)
        if self.rosenbrock or not all(
            (k % 2 == 0 and self._is_mirrored) or self._names(_bush(k), "") for k in orders
        ):
            return False
        return all(self._has_stage(i, k) for k in range(1, self.s + 1) for i in stages)

    def _names(self, t: Tree, row: str) -> bool:
        """Return whether the condition of a tree is an equation, of the single one an identity."""
        if any(e.tree and _plain(e.tree) == t and e.row == row for e in self.equations):
            return True
        if t.order > 1 or self._affine is None:
            return False
        total = sum(self._affine[1][row], Affine.of(Exact(-1)))
        return Affine.of(total).is_identically_zero()

    def given(self, t: Tree, row: str = "") -> bool:
        """Return whether the equations give the condition of a tree with the weights of a row."""
        t = _plain(t)
        if self._names(t, row):
            return True
        if row or len(t.children) != 1 or not self.has_columns:
            return False
        below = t.children[0].children
        if not below:
            return self.given(single())
        return self.given(tree(below)) and self.given(tree([single(), *below]))

    def counted(self, n: int, *, jacobian: bool = True) -> list[Tree]:
        """Return the trees of an order that count; for a Rosenbrock method with J exact or any."""
        found = list(trees(n, self.palette))
        if not self.rosenbrock:
            return found

        def counts(t: Tree) -> bool:
            kept = stands("rosenbrock" if jacobian else "w", t.colour, len(t.children))
            return kept and all(map(counts, t.children))

        return list(filter(counts, found))

    def order(self, row: str = "", *, jacobian: bool = True) -> int:
        """Return the largest order all of whose conditions the equations give."""
        if self.is_gauss and not row:
            return 2 * self.s
        n = 0
        while n < MAX_ORDER and all(
            self.given(t, row) for t in self.counted(n + 1, jacobian=jacobian)
        ):
            n += 1
        return n


def _plain(t: Tree) -> Tree:
    """Return the tree with leaves of the colour 1, where there are two colours."""
    if not t.children:
        return single("1") if t.colour == "2" else t
    return tree(map(_plain, t.children), t.colour)


def _bush(n: int) -> Tree:
    """Return the tree of n vertices whose root has n - 1 leaves; for a stage, ``c^(n-1)``."""
    return tree([single()] * (n - 1)) if n > 1 else single()


def _weights(below: Below) -> Callable[[Tree], tuple[Any, ...]]:
    """Return by tree, for each stage, the product over its children of a matrix times theirs."""
    known: dict[Tree, tuple[Any, ...]] = {}

    def at(t: Tree) -> tuple[Any, ...]:
        if t not in known:
            M = below[t.colour]
            value: tuple[Any, ...] = (Exact(1),) * len(M)
            for child in t.children:
                stages = linalg.matvec(M, at(child))
                value = tuple(x * y for x, y in zip(value, stages, strict=True))
            known[t] = value
        return known[t]

    return at


def _column(A: Sequence[Sequence[Any]], b: Sequence[Any], j: int) -> Any:
    """Return ``sum_i b_i a_ij - b_j (1 - c_j)``."""
    rest = Exact(1) - sum(A[j][1:], A[j][0])
    return sum((x * row[j] for x, row in zip(b, A, strict=True)), -(rest * b[j]))


@dataclass(frozen=True)
class Proved:
    """What the equations of a file of class ``rk`` or ``rosenbrock`` give.

    Attributes
    ----------
    orders : dict[str, int]
        By row of weights, b under ``""``, the order of the one method within the digits.
    any_matrix : int
        Of a Rosenbrock method the order with any matrix in the place of the Jacobian, else 0.
    gauss : int
        s where it is the Gauss method with s stages, else 0.
    system : RungeKuttaSystem or None
        The equations.
    root : Krawczyk or None
        Their interval test.
    """

    orders: dict[str, int]
    any_matrix: int = 0
    gauss: int = 0
    system: RungeKuttaSystem | None = None
    root: Krawczyk | None = None


def prove_runge_kutta(document: Mapping[str, Any]) -> Proved:
    """Prove the orders that the equations of a file give.

    Parameters
    ----------
    document : Mapping[str, Any]
        The parsed JSON object, of class ``rk`` or ``rosenbrock``.

    Returns
    -------
    Proved
        Of the one method within the digits.

    Raises
    ------
    DataError
        When the equations do not give order 1.
    ExactnessError
        When the interval test does not find exactly one root near the digits.
    """
    system = RungeKuttaSystem(document)
    orders = {row: system.order(row) for row in system.rows}
    any_matrix = system.order(jacobian=False) if system.rosenbrock else 0
    if not orders[""]:
        raise DataError("the equations of the file do not give the condition of the single vertex")
    root = root_of(document, system)
    below, rows = system.read(dict(zip(system.unknowns, root.box, strict=True)))
    weight = _weights(below)
    most = _CHECKED if system.is_gauss else MAX_ORDER
    wanted = [(row, t) for row, p in orders.items() for n in range(1, min(p, most) + 1)
              for t in system.counted(n)]  # fmt: skip
    wanted += [("", t) for n in range(1, any_matrix + 1) for t in system.counted(n, jacobian=False)]
    for row, t in wanted:
        x = ball(linalg.dot(rows[row], weight(t)) - Exact(1) / t.density)
        if not x.contains_zero() or not x.magnitude() < WIDTH:
            raise ExactnessError(
                f"a redundant condition is not enclosed: {t} has residual {x.magnitude():.3g}, "
                f"and it must be a ball around zero below {WIDTH}"
            )
    return Proved(orders, any_matrix, system.s if system.is_gauss else 0, system, root)
