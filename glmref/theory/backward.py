"""Backward error analysis: which Hamiltonian a series of vector fields has, and what it conserves.

On y' = f = J^-1 grad H, and on separable systems in two colours, a field ``h f~ = sum of b(t)
h^|t| / sigma(t) F(t)`` is Hamiltonian exactly where

    b(u o v) + b(v o u) = 0        for all u and v (of different colours where there are two),

its Hamiltonian is then ``H~ = sum of b(t) h^(|t| - 1) / (|t| sigma(t)) H(t)`` over the rooted trees
with the elementary Hamiltonians ``H([t1 .. tm]) = H^(m)(F(t1), .., F(tm))``. As ``H(u o v) = -H(v o
u)``, free trees are enough: the coefficient of H(t) is then b(t) divided by the number of
automorphisms of the free tree. The field preserves H exactly where, for each free tree that is not
superfluous, the sum of +-b(t)/sigma(t) over its rooted trees [t] vanishes.

**Conjugate symplecticity.** A map with the field b is conjugate-symplectic to order n if in some
coordinates its field satisfies the conditions above through the trees of order n. The change of
variables is sought as the flow of a field c. If b satisfies them through order n, c may begin with
trees of order n, and changes b at order n + 1 by ``[c, f]``: linear equations with whole numbers. A
field c for which ``[c, f]`` is Hamiltonian is Hamiltonian itself (for the orders of
:data:`LARGEST_CONJUGATE`, shown by the rank of the equations), and conjugation by its flow is
symplectic; so what was chosen at lower orders does not matter, and a failure excludes every change
of variables.

**What the output conserves.** If H~ belongs to the field of ``chi^-1 Phi chi``, then Phi conserves
H~ after chi^-1: elementary Hamiltonians composed with a series are elementary Hamiltonians.

References
----------
Hairer, Lubich, Wanner (2006), sections IX.9 and IX.10, theorem VI.7.4. Hairer, Zbinden, "On
conjugate symplecticity of B-series integrators", IMA J. Numer. Anal. 33 (2013) 57-79. Celledoni,
McLachlan, Owren, Quispel, "Energy-preserving integrators and the structure of B-series", Found.
Comput. Math. 10 (2010) 673-693.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from ..exact import Exact, linalg
from ..exact.linalg import Matrix
from ..method.component import Palette
from .coefficients import combination, is_zero, plus, scalars, times
from .series import Series, compose, conjugated, edge_cuts
from .trees import FreeTree, Tree, free_trees, halves, single, trees

#: Largest order through which a failure excludes every change of variables: the ranks are tested.
LARGEST_CONJUGATE = 8

#: A pair of trees whose coefficients cancel: ``u * v`` and ``v * u``.
Edge = tuple[Tree, Tree]
Colours = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Reach:
    """Through which order a property holds.

    Attributes
    ----------
    order : int
        Through the trees of this order it is not excluded.
    fails : bool
        Whether it is proved to fail at the next order; otherwise no more was computed.
    witness : str
        The tree of the next order that decides, or ``""``.
    residual : float
        Size of the largest number that may be zero within published digits; 0.0: it is proved.
    """

    order: int
    fails: bool
    witness: str = ""
    residual: float = 0.0

    @property
    def text(self) -> str:
        """Such as ``"4, not 5: [oooo]"``."""
        if self.fails:
            found = f"{self.order}, not {self.order + 1}: {self.witness}"
        else:
            found = f"at least {self.order}"
        if self.residual:
            return f"{found}; open within the digits, residuals at most {self.residual:.1e}"
        return found


def _colours(palette: Palette) -> Colours:
    return tuple(palette.items())


@cache
def edges(order: int, colours: Colours) -> tuple[Edge, ...]:
    """Return the pairs (u, v) of the Hamiltonian conditions of an order, each once."""
    return tuple(
        (t, v * u)
        for free in free_trees(order, colours)
        for t in free.signs
        for u, v in halves(t)
        if t.key <= (v * u).key
    )


def _reach(order: int, residuals: Callable[[int], Iterable[tuple[str, Any]]]) -> Reach:
    """Return through which order no residual excludes zero; ``residuals(n)`` are (name, number)."""
    size = 0.0
    for n in range(1, order + 1):
        level = 0.0
        for name, x in residuals(n):
            zero = is_zero(x)
            if zero is False:
                return Reach(n - 1, True, name, size)
            if zero is None:
                level = max(level, x.magnitude())
        size = max(size, level)
    return Reach(order, False, "", size)


def hamiltonian_defects(field: Series, order: int) -> list[tuple[Tree, Any]]:
    """Return ``b(u o v) + b(v o u)`` of an order with the tree u o v."""
    return [(t, plus(field[t], field[s])) for t, s in edges(order, _colours(field.palette))]


def hamiltonian_reach(field: Series) -> Reach:
    """Return through which order a field is Hamiltonian."""
    return _reach(field.order, lambda n: [(str(t), x) for t, x in hamiltonian_defects(field, n)])


def energy_reach(field: Series) -> Reach:
    """Return through which order a field preserves the Hamiltonian."""
    colours = _colours(field.palette)

    def residuals(n: int) -> Iterable[tuple[str, Any]]:
        for free in free_trees(n + 1, colours):
            below = [(t.children[0], sign) for t, sign in free.signs.items()
                     if len(t.children) == 1]  # fmt: skip
            if below and not free.superfluous:
                total: Any = 0
                for t, sign in below:
                    total = plus(total, times(Fraction(sign, t.symmetry), field[t]))
                yield " ".join(str(t) for t, _ in below), total

    return _reach(field.order, residuals)


@cache
def _change_equations(order: int, colours: Colours) -> tuple[tuple[Tree, ...], Matrix, int]:
    """Return unknowns c(t) of an order, the matrix that solves for them, and the rank.

    The rows of the matrix, times the defects of order + 1, are first the unknowns and then what
    must vanish.
    """
    palette = dict(colours)
    unknowns, pairs = trees(order, palette), edges(order + 1, colours)
    at = {t: j for j, t in enumerate(unknowns)}
    rows = []
    for i, pair in enumerate(pairs):
        row = [0] * (len(unknowns) + len(pairs))
        for t in pair:
            for (part, rest), ways in edge_cuts(t).items():
                if part.order == 1:  # f below a vertex of c
                    row[at[rest]] -= ways
                if rest.order == 1:  # c below f
                    row[at[part]] += ways
        row[len(unknowns) + i] = -1
        rows.append(row)
    size = len(unknowns)
    reduced, pivots = linalg.reduced([list(map(Exact, row)) for row in rows], size)
    matrix = tuple(tuple(row[size:]) for row in reduced)
    return tuple(unknowns[j] for j in pivots), matrix, len(pivots)


@dataclass(frozen=True)
class Conjugacy:
    """A change of variables that makes a field Hamiltonian.

    Attributes
    ----------
    reach : Reach
        Through which order it does; where that fails no other change does better.
    field : Series
        In the new variables, through order ``reach.order``.
    change : tuple[Series, ...]
        Fields c_1, c_2, ..: chi is the composition of their flows, the last applied first.
    """

    reach: Reach
    field: Series
    change: tuple[Series, ...]


def conjugacy(field: Series) -> Conjugacy:
    """Find a change of variables in which a field is Hamiltonian to as high an order as possible.

    Parameters
    ----------
    field : Series
        With b = 1 on the single vertices; orders beyond :data:`LARGEST_CONJUGATE` are left out.

    References
    ----------
    Hairer, Zbinden (2013): conjugate symplecticity as linear conditions on b.
    """
    field = field.truncate(LARGEST_CONJUGATE)
    palette, changes = field.palette, []
    for c in palette:
        if is_zero(plus(field[single(c)], -1)) is not True:
            return Conjugacy(Reach(0, True, c), field.truncate(0), ())
    for n in range(1, field.order):
        defects = scalars([x for _, x in hamiltonian_defects(field, n + 1)])
        if all(is_zero(x) is True for x in defects):
            continue
        unknowns, matrix, rank = _change_equations(n, _colours(palette))
        solved = [combination(list(zip(row, defects, strict=True))) for row in matrix]
        if any(is_zero(x) is False for x in solved[rank:]):
            break
        values = dict(zip(unknowns, solved[:rank], strict=True))
        change = Series(values, 0, field.order, palette)
        changes.append(change)
        field = conjugated(field, change)
    reach = hamiltonian_reach(field)
    return Conjugacy(reach, field.truncate(reach.order), tuple(changes))


def elementary_hamiltonians(field: Series) -> Series:
    """Return ``b(t)/|t|``: H~ as a series over rooted trees, ``h H~ = sum e(t) h^|t|/sigma H(t)``.

    Parameters
    ----------
    field : Series
        Hamiltonian through its order.
    """
    values = {t: times(Fraction(1, t.order), field[t]) for t in field}
    return Series(values, 0, field.order, field.palette)


def over_free_trees(hamiltonian: Series) -> dict[FreeTree, Any]:
    """Collect a sum of elementary Hamiltonians by free trees: the coefficients of H(root).

    Returns
    -------
    dict[FreeTree, Any]
        By ascending order; zeros are left out.
    """
    found: dict[FreeTree, Any] = {}
    for n in range(1, hamiltonian.order + 1):
        for free in free_trees(n, _colours(hamiltonian.palette)):
            if free.superfluous:
                continue
            total: Any = 0
            for t, sign in free.signs.items():
                total = plus(total, times(Fraction(sign, t.symmetry), hamiltonian[t]))
            if is_zero(total) is not True:
                found[free] = scalars([total])[0]
    return found


def composed(hamiltonian: Series, change: Series) -> Series:
    """Return the elementary Hamiltonians of a function after a map: ``change`` is applied first."""
    return compose(change, hamiltonian)


def coefficient(found: Mapping[FreeTree, Any], t: Tree) -> Any:
    """Return the coefficient of H(t), t any rooted tree of a free tree, 0 where there is none."""
    for free, x in found.items():
        if t in free.signs:
            return times(free.signs[t], x)
    return 0
