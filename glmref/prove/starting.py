"""Starting and finishing methods with parity, and the proof that their digits stand for one.

A Runge-Kutta-like start has *parity* when its stages are y0 and pairs that are exchanged by h ->
-h: with the permutation sigma of the pairs, ``A_(sigma i)(sigma j) = -A_ij`` and ``B_(k)(sigma j) =
-(L B)_kj``, for each component. Then S(-h) = L S(h), as for the starting series of a symmetric
method, so that in eigenvectors of L each value has conditions at the even trees or at the odd ones
only: 25 or 12 of the 37 up to order 6. The first value needs the even trees below the order only,
because the principal part is free at the order itself. A finish with parity, b_(sigma j) = -b_j,
undoes an even series by an even one: 25 conditions.

The start of a pair is explicit, its first values are the solution itself, and L = L^ = 1: the
series are even. Conditions are left at 5 + 5 of 16 trees up to order 4 and 25 + 25 of 74 up to
order 6, for one value carried beyond the first; on second-order systems at 9 + 14 up to order 6 and
29 + 50 up to order 8.

In a file the decimals of ``starting`` (and of ``finishing``) are the unknowns, as many as
conditions; the other entries are rational. :func:`prove_starting` checks the parity for all
values of the unknowns, and the conditions by the interval test; the starting series of the method
is a parameter, given by balls, and the test holds for every value in them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

from ..catalogue.claims import FINISHING_ORDER, NYSTROM_STARTING_ORDER, STARTING_ORDER
from ..errors import DataError, ExactnessError
from ..exact import Ball, Exact, ball, linalg
from ..exact.expression import parse
from ..exact.linalg import Matrix
from ..method import GLM, Method, PartitionedGLM
from ..theory.order import order_of
from ..theory.symmetry import symmetry
from ..theory.trees import Tree, is_nystrom
from .classes import Family, classes, reduce_tree
from .equations import Series
from .krawczyk import Krawczyk, Outcome, is_rounding, krawczyk
from .system import Affine, SweepSystem
from .tableau_series import TableauSeries, stage_order

Conditions = Callable[[Sequence[Any]], list[Any]]

#: Decimals of a start that are unknowns: entries with fewer places are exact.
_DECIMAL = re.compile(r"\d+\.\d{20,}")
RADIUS = Fraction(1, 10**60)


class StartingSystem:
    """The decimals of a start or finish as unknowns.

    Attributes
    ----------
    unknowns
        Their values as text, without sign, in order of appearance.
    """

    def __init__(self, entries: Sequence[Sequence[str]]) -> None:
        self.entries = entries
        seen = (x for row in entries for text in row for x in _DECIMAL.findall(text))
        self.unknowns: tuple[str, ...] = tuple(dict.fromkeys(seen))
        self._names = {x: f"x{k}" for k, x in enumerate(self.unknowns)}

    @cached_property
    def _named(self) -> list[list[str | Exact]]:
        """The entries: numbers, and expressions in the names of the unknowns."""

        def named(text: str) -> Any:
            changed, count = _DECIMAL.subn(lambda m: self._names[m[0]], text)
            return changed if count else parse(text)

        return [[named(text) for text in row] for row in self.entries]

    def read(self, values: Sequence[Any]) -> Matrix:
        """Evaluate the entries at values of the unknowns."""
        constants = dict(zip(self._names.values(), values, strict=True))
        return tuple(
            tuple(parse(x, constants=constants) if isinstance(x, str) else x for x in row)
            for row in self._named
        )

    def affine(self) -> list[list[Affine]]:
        """Return the entries as affine expressions in the unknowns."""
        return self._affine

    @cached_property
    def _affine(self) -> list[list[Affine]]:
        values = [Affine.unknown(x) for x in self._names.values()]
        return [[Affine.of(x) for x in row] for row in self.read(values)]

    def published(self, digits: int) -> list[Ball]:
        """Return the balls that the digits stand for."""
        return [ball(parse(x, digits=digits)) for x in self.unknowns]


def _hats(block: Mapping[str, Any]) -> Mapping[str, str]:
    """Return colours of the components of a start, with the suffix of A, B and u in its names."""
    return (PartitionedGLM if "A_hat" in block else GLM).LETTERS


def _split(block: Mapping[str, Any], rows: Sequence[Any]) -> dict[str, tuple[Any, Any]]:
    """Return the rows of a :func:`starting_system`: A and B by colour."""
    found, at = {}, 0
    for colour, hat in _hats(block).items():
        middle = at + len(block[f"A{hat}"])
        end = middle + len(block[f"B{hat}"])
        found[colour] = rows[at:middle], rows[middle:end]
        at = end
    return found


def swap(i: int) -> int:
    """Return the partner of a stage: 0 is the point itself, then come pairs (1, 2), (3, 4), .."""
    return 0 if i == 0 else i + 1 if i % 2 else i - 1


def _check_parity(
    rows: Sequence[Sequence[Affine]], mirrored: Sequence[Sequence[Affine]], name: str
) -> None:
    """Check rows against their mirror images for all values of the unknowns.

    Raises
    ------
    DataError
        Naming the entry.
    """
    size = len(rows[0])
    if size % 2 == 0:
        raise DataError(
            f"a start with parity has an odd number of stages, and `{name}` has {size} columns"
        )
    for i, (row, image) in enumerate(zip(rows, mirrored, strict=True)):
        for j, x in enumerate(row):
            if not (image[swap(j)] + x).is_identically_zero():
                raise DataError(
                    f"no parity: `{name}[{i + 1}][{j + 1}]` and its mirror image differ"
                )


def functionals(L: Matrix) -> list[tuple[tuple[Any, ...], int]]:
    """Return rows f with f L = +-f, the first being e_1, with the sign."""
    found: list[tuple[tuple[Any, ...], int]] = []
    for sign in (1, -1):
        shifted = linalg.sub(linalg.transpose(L), linalg.scale(sign, linalg.identity(len(L))))
        found += [(row, sign) for row in linalg.nullspace(shifted)]
    first = [x for x in found if not x[0][0].is_zero()]
    if len(found) != len(L) or len(first) != 1 or any(not y.is_zero() for y in first[0][0][1:]):
        raise DataError("the involution L of the method does not keep the first value apart")
    return first + [x for x in found if x is not first[0]]


@dataclass(frozen=True)
class Target:
    """What a start is to agree with.

    Attributes
    ----------
    zeta : Mapping[Tree, Sequence[Any]]
        Starting series of the method at the trees that count, exact or balls.
    L : Mapping[str, Matrix]
        Involution of the values by colour, first row and column 1, 0, .., 0.
    order : int
        Of the start on all trees.
    stage_order : int
        Of the method: zeta respects it.
    """

    zeta: Mapping[Tree, Sequence[Any]]
    L: Mapping[str, Matrix]
    order: int
    stage_order: int = 1

    @classmethod
    def of(
        cls, document: Mapping[str, Any], system: SweepSystem, series: Sequence[Series]
    ) -> Target:
        """Return the target of a file, from its starting series.

        Raises
        ------
        DataError
            When there is no start with parity for the method; of a pair when the starting series is
            not even, or the first values are not the solution.
        """
        orders = start_orders(document, system)
        if not system.involutions:
            raise DataError("only a symmetric method has a start with parity")
        if system.is_partitioned:
            _check_even(system, orders)
        zeta: dict[Tree, Sequence[Any]] = {}
        for n in range(1, max((n for n, _ in orders), default=0) + 1):
            for family in [family for order, family in orders if n <= order]:
                for t in classes(n, 1, family):
                    if t in zeta or (family is Family.SECOND_ORDER and not is_nystrom(t)):
                        continue
                    found = next((s.zeta[t] for s in series if t in s.zeta), None)
                    if found is None:
                        raise DataError("a start has no higher order than the pair; claim less")
                    zeta[t] = found
        order = next((n for n, family in orders if family is not Family.SECOND_ORDER), 0)
        return cls(zeta, system.involutions, order, system.stage_order)

    def conditions(self, q: int | None = None) -> list[tuple[int, tuple[Any, ...], Tree]]:
        """Return the conditions: value (from 0), its functional, and the tree at which they hold.

        Parameters
        ----------
        q : int or None
            Stage order of the start; as that of the method where it is ``None``. Conditions are at
            classes of trees.
        """
        q = self.stage_order if q is None else q
        return [
            (k, row, t)
            for colour, L in self.L.items()
            for k, (row, sign) in enumerate(functionals(L))
            for t in self.zeta
            if t.colour == colour
            and (t.order % 2 == 0) == (sign > 0)
            and (k > 0 or t.order < self.order)
            and reduce_tree(t, q)[0] is t
        ]


def _check_even(system: SweepSystem, orders: Sequence[tuple[int, Family]]) -> None:
    for c, s in zip(system.V, system.signs() or (), strict=True):
        E = linalg.diagonal([Exact(x) for x in s])
        if any(not x.is_zero() for _, _, x in linalg.entries(linalg.sub(E, system.V[c]))):
            raise DataError(
                "only a symmetric pair with L = L^ = 1, V = E and V^ = E^, has an even start"
            )
    if not all(system.identity_through(n - 1, family) for n, family in orders):
        raise DataError("a start needs first values that are the solution: add equations `start`")


def start_orders(
    document: Mapping[str, Any], system: SweepSystem
) -> tuple[tuple[int, Family], ...]:
    """Return orders of the start of a file, each with the trees that count for it.

    The start of one component has the order of the method. A pair claims orders of its start (or
    the block ``"starting"`` names one), on all trees and on those of second-order systems.
    """
    if not system.is_partitioned:
        return tuple(system.families)
    claims = document.get("claims", {})
    own = document.get("starting", {}).get("order", 0)
    found = (
        (claims.get(STARTING_ORDER.key, own), Family.SEPARABLE),
        (claims.get(NYSTROM_STARTING_ORDER.key, 0), Family.SECOND_ORDER),
    )
    return tuple((n, family) for n, family in found if n)


def target_of(method: Method) -> Target:
    """Return the target of an exact symmetric method whose first value is the solution itself.

    Raises
    ------
    DataError
        When the method is not symmetric.
    """
    found, L = order_of(method, principal="identity"), symmetry(method).L
    if L is None or found.eta is None:
        raise DataError("only a symmetric method has a start with parity")
    series = {t: [ball(x) for x in found.eta[t]] for t in found.eta if t.order <= found.order}
    return Target(series, {"o": L}, found.order)


def starting_system(block: Mapping[str, Any]) -> StartingSystem:
    """Return the unknowns of a block ``"starting"``."""
    rows = [row for hat in _hats(block).values() for x in "AB" for row in block[f"{x}{hat}"]]
    return _system(tuple(map(tuple, rows)))


@lru_cache(maxsize=4)
def _system(entries: tuple[tuple[str, ...], ...]) -> StartingSystem:
    """Return the system of a block, which several proofs of one file ask for."""
    return StartingSystem(entries)


def known_stage_order(block: Mapping[str, Any], target: Target) -> int:
    """Return stage order of a start whose A holds no unknowns, at most that of the method.

    Otherwise the result is 1.
    """
    if target.stage_order == 1:
        return 1
    stages = StartingSystem(block["A"])
    return 1 if stages.unknowns else stage_order(stages.read([]), most=target.stage_order)


def starting_function(block: Mapping[str, Any], target: Target) -> Conditions:
    """Return the conditions of a start as a function of its unknowns.

    Where A holds no unknowns and has a stage order, the conditions at classes of trees are enough.
    Conditions of a first value that hold for all unknowns (a start from y0 itself where the
    principal part is the identity) are left out.
    """
    system, q = starting_system(block), known_stage_order(block, target)
    listed = target.conditions(q)
    wanted = dict.fromkeys(t for _, _, t in listed)
    fixed: TableauSeries | None = None
    tableaux = [StartingSystem(block[f"A{hat}"]) for hat in _hats(block).values()]
    if not any(x.unknowns for x in tableaux):
        A = {c: x.read([]) for c, x in zip(_hats(block), tableaux, strict=True)}
        fixed = TableauSeries(A, parity=True, q=q)

    def conditions(values: Sequence[Any]) -> list[Any]:
        matrices = _split(block, system.read(values))
        known = fixed or TableauSeries({c: A for c, (A, _) in matrices.items()}, parity=True, q=q)
        terms = {
            t: [
                x - y
                for x, y in zip(
                    known.outputs(matrices[t.colour][1], t), target.zeta[t], strict=True
                )
            ]
            for t in wanted
        }
        found = [(k, linalg.dot(row, terms[t])) for k, row, t in listed]
        return [x for k, x in found if k > 0 or x.is_zero() is not True]

    return conditions


def prove_starting(block: Mapping[str, Any], target: Target, *, digits: int = 75) -> Krawczyk:
    """Prove that an exact start lies within the digits of a block ``"starting"``.

    Raises
    ------
    DataError
        When the start does not have the form described above.
    ExactnessError
        When the interval test does not succeed.
    """
    system, hats = starting_system(block), _hats(block)
    for colour, hat in hats.items():
        u = [parse(x) for x in block[f"u{hat}"]]
        if u != [Exact(int(k == 0)) for k in range(len(target.L[colour]))]:
            raise DataError(f"`starting.u{hat}` must be 1, 0, .., 0")
    for colour, (A, B) in _split(block, system.affine()).items():
        for letter, rows, what in (("A", A, "stage"), ("B", B, "value")):
            name = f"starting.{letter}{hats[colour]}"
            if len(hats) > 1 and any(not x.is_identically_zero() for x in rows[0]):
                raise DataError(f"`{name}[1]` must be zero: the first {what} is the solution")
            mirrored = _mirrored(A) if letter == "A" else _images(target.L[colour], B)
            _check_parity(rows, mirrored, name)
    return enclosed_block(system, starting_function(block, target), digits, "starting")


def _mirrored(A: Sequence[Any]) -> Sequence[Any]:
    """Return the rows of A, each in the place of its partner."""
    return [A[swap(i)] for i in range(len(A))] if len(A) % 2 else A


def _images(L: Matrix, B: Sequence[Sequence[Affine]]) -> Sequence[Sequence[Affine]]:
    """Return L B, over affine expressions."""

    def entry(row: Sequence[Any], j: int) -> Affine:
        return Affine.of(sum(b[j] * x for b, x in zip(B, row, strict=True)))

    return [[entry(row, j) for j in range(len(B[0]))] for row in L]


def finishing_system(block: Mapping[str, Any]) -> StartingSystem:
    """Return the unknowns of a block ``"finishing"``."""
    return _system(tuple(map(tuple, [*block["A"], block["b"]])))


def even_trees(order: int) -> list[Tree]:
    """Return the trees where a finish has conditions."""
    return [t for n in range(2, order + 1, 2) for t in classes(n, 1)]


def finishing_function(
    block: Mapping[str, Any], base: Mapping[Tree, Any], order: int
) -> Conditions:
    """Return the conditions that a finish, after the first value of the start, gives y back."""
    system, size = finishing_system(block), len(block["A"])

    def conditions(values: Sequence[Any]) -> list[Any]:
        entries = system.read(values)
        series = TableauSeries({"o": entries[:size]}, base, parity=True)
        return [series.outputs(entries[size:], t)[0] + base[t] for t in even_trees(order)]

    return conditions


def first_value(block: Mapping[str, Any], values: Sequence[Any], order: int) -> Mapping[Tree, Any]:
    """Return series of the first value of a start, at values of its unknowns."""
    matrix, size = starting_system(block).read(values), len(block["A"])
    series = TableauSeries({"o": matrix[:size]})
    listed = [t for n in range(1, order + 1) for t in classes(n, 1)]
    return {t: series.outputs(matrix[size : size + 1], t)[0] for t in listed}


def prove_finishing(
    block: Mapping[str, Any], base: Mapping[Tree, Any], order: int, *, digits: int = 75
) -> Krawczyk:
    """Prove that an exact finish lies within the digits of a block ``"finishing"``.

    Parameters
    ----------
    block : Mapping[str, Any]
        The finish.
    base : Mapping[Tree, Any]
        :func:`first_value` of the start, in balls.
    order : int
        Of the method.
    digits : int
        Of the file.

    Raises
    ------
    DataError
        When the finish does not have the form described above.
    ExactnessError
        When the interval test does not succeed.
    """
    system, size = finishing_system(block), len(block["A"])
    A, b = system.affine()[:size], system.affine()[size:]
    _check_parity(A, _mirrored(A), "finishing.A")
    _check_parity(b, b, "finishing.b")
    return enclosed_block(system, finishing_function(block, base, order), digits, "finishing")


@dataclass(frozen=True)
class Blocks:
    """What is proved about the start and the finish of a document.

    Attributes
    ----------
    orders : Mapping[str, int]
        Claim -> the order that follows.
    target : Target or None
        What the start agrees with.
    start, finish : Krawczyk or None
        The interval tests; ``None`` for a block that needs none.
    """

    orders: Mapping[str, int] = field(default_factory=dict)
    target: Target | None = None
    start: Krawczyk | None = None
    finish: Krawczyk | None = None


def prove_blocks(document: Mapping[str, Any], target: Target) -> Blocks:
    """Prove the start and the finish of a document; name the claims that follow, with their order.

    Blocks without long decimals are exact and are left to exact arithmetic.

    Raises
    ------
    DataError, ExactnessError
        See :func:`prove_starting` and :func:`prove_finishing`.
    """
    opening, closing = document.get("starting"), document.get("finishing")
    if opening is None or not starting_system(opening).unknowns:
        return Blocks()
    digits = document.get("digits", 75)
    start = prove_starting(opening, target, digits=digits)
    found = {STARTING_ORDER.key: target.order}
    if len(target.L) > 1:
        found[NYSTROM_STARTING_ORDER.key] = max((t.order for t in target.zeta), default=0)
    if closing is None:
        return Blocks(found, target, start)
    finish = None
    if not is_inverse(opening, closing):
        if not finishing_system(closing).unknowns:
            return Blocks(found, target, start)
        base = first_value(opening, start.box, target.order)
        finish = prove_finishing(closing, base, target.order, digits=digits)
    return Blocks({**found, FINISHING_ORDER.key: target.order}, target, start, finish)


def enclosed_block(
    system: StartingSystem, conditions: Conditions, digits: int, key: str
) -> Krawczyk:
    """Prove that one exact block lies near the digits of a file, and that these are its rounding.

    Parameters
    ----------
    system : StartingSystem
        Unknowns of the block.
    conditions : Conditions
        What they must make vanish.
    digits : int
        Behind the point.
    key : str
        Name of the block, for messages.

    Raises
    ------
    DataError
        When there are not as many conditions as unknowns.
    ExactnessError
        When the interval test does not succeed, or the digits are others.
    """
    published = system.published(digits)
    result = krawczyk(conditions, published, RADIUS)
    if result.outcome is not Outcome.UNIQUE:
        raise ExactnessError(
            f"`{key}`: the interval test gives {result.outcome!s} near the digits "
            f"({result.witness})"
        )
    for x, y in zip(published, result.box, strict=True):
        if not is_rounding(x, y, digits):
            raise ExactnessError(f"`{key}`: the exact method lies outside the digits")
    return result


# -- the finish that undoes the first value of a start, with the digits of the start


def needed_stages(A: Sequence[Sequence[str]], b: Sequence[str]) -> list[int]:
    """Return stages on which a row of weights depends, ascending."""
    waiting = [j for j, x in enumerate(b) if x != "0"]
    found = set(waiting)
    while waiting:
        for j, x in enumerate(A[waiting.pop()]):
            if x != "0" and j not in found:
                found.add(j)
                waiting.append(j)
    return sorted(found)


def inverse_block(opening: Mapping[str, Any]) -> dict[str, Any]:
    """Return the finish that undoes the first value of a start exactly, with the same digits.

    Solving ``y_1 = y + h b f(Y)``, ``Y = y + h A f(Y)`` for y gives ``Y = y_1 + h (A - 1 b^T)
    f(Y)`` and ``y = y_1 - h b f(Y)``, on the stages that b depends on.
    """
    b = opening["B"][0]
    stages = needed_stages(opening["A"], b)
    rows = [[_difference(opening["A"][i][j], b[j]) for j in stages] for i in stages]
    return {
        "name": f"inverse of the start in the first value, {len(stages)} stages",
        "kind": "runge-kutta",
        "A": rows,
        "b": [_difference("0", b[j]) for j in stages],
    }


def _difference(left: str, right: str) -> str:
    minus = "" if right == "0" else right[1:] if right.startswith("-") else f"-{right}"
    if left == "0" or not minus:
        return minus or left
    return f"{left}{minus}" if minus.startswith("-") else f"{left}+{minus}"


def is_inverse(opening: Mapping[str, Any], closing: Mapping[str, Any]) -> bool:
    """Return whether a finish is :func:`inverse_block` of the start, for all its digits."""
    wanted = inverse_block(opening)
    if len(closing["A"]) != len(wanted["A"]):
        return False
    pairs = [*zip(closing["A"], wanted["A"], strict=True), (closing["b"], wanted["b"])]
    system = StartingSystem([[*left, *right] for left, right in pairs])
    return all(
        (row[k] - row[k + len(row) // 2]).is_identically_zero()
        for row in system.affine()
        for k in range(len(row) // 2)
    )
