"""Starts of pairs with parity: explicit, few stages, and proved from the digits of their file.

A symmetric pair whose involutions L and L^ are the identity has starting series that are even in h
(theorem 3 of :mod:`.pair_series`), and zero in the first values where no finishing is needed. A
start from (q0, p0) has the same *parity* when its stages Q and P are the point itself and pairs
that h -> -h exchanges: with the permutation sigma of the pairs, ``A_(sigma i)(sigma j) = -A_ij``,
``B_(k)(sigma j) = -B_kj``, and likewise for A^ and B^. Conditions are then left at even trees
only: 5 + 5 of 16 up to order 4 and 25 + 25 of 74 up to order 6, for one value carried beyond the
first; on second-order systems 9 + 14 up to order 6 and 29 + 50 up to order 8.

Parity also halves the work: the series of a stage at odd trees changes its sign in the partner and
is the same at even trees, so that stages with number 1, 3, 5, .. are enough.

In a file the decimals of ``starting`` are the unknowns, as many as conditions; the other entries
are rational. :func:`prove_pair_start` checks the parity for all values of the unknowns, and the
conditions by the interval test; the starting series of the pair is given by balls, and the test
holds for every value in them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..catalogue.claims import NYSTROM_ORDER, NYSTROM_STARTING_ORDER, ORDER, STARTING_ORDER
from ..catalogue.writer import DIGITS, decimal
from ..errors import DataError, ExactnessError
from ..exact import Exact, ball, linalg
from ..exact.expression import parse
from ..theory.nystrom import is_nystrom
from ..theory.trees import SEPARABLE, Tree, trees
from .enclosure import Krawczyk
from .newton import polish
from .partitioned_series import PairNumbers, PairSeries
from .partitioned_system import PairSystem
from .starting import StartingSystem, enclosed_block

__all__ = [
    "PairTarget",
    "complete_start",
    "even_weights",
    "expanded",
    "pair_target",
    "prove_pair_start",
    "start_function",
    "start_orders",
    "start_system",
    "with_start",
]

#: The four matrices of a start by the colour of the trees they belong to.
STAGES = {"f": "A", "k": "A_hat"}
WEIGHTS = {"f": "B", "k": "B_hat"}


@dataclass(frozen=True)
class PairTarget:
    """What a start is to agree with.

    Attributes
    ----------
        zeta: starting series of the pair at the even trees that count, exact or balls.
        values: r and r^, the numbers of values of q and of p, by root colour.
    """

    zeta: Mapping[Tree, Sequence[Any]]
    values: Mapping[str, int]


def pair_target(
    system: PairSystem, series: Sequence[PairSeries], orders: tuple[int, int]
) -> PairTarget:
    """Collect the conditions of a start.

    Args:
        system: of the pair. series: starting series that hold all trees needed.
        orders: through which order on all trees, and on those of second-order systems.

    Raises
    ------
        DataError: when the starting series are not even in h, or the first values not the solution.
    """
    signs = system.signs()
    for V, s in zip((system.V, system.V_hat), signs or ((), ()), strict=True):
        E = linalg.diagonal([Exact(x) for x in s])
        if not s or any(not x.is_zero() for _, _, x in linalg.entries(linalg.sub(E, V))):
            raise DataError(
                "only a symmetric pair with L = L^ = 1, V = E and V^ = E^, has an even start"
            )
    order, nystrom = orders
    for wanted, kind in ((order, False), (nystrom, True)):
        if wanted and not system.identity_through(wanted - 1, nystrom=kind):
            raise DataError(
                "a start needs first values that are the solution: add equations `start`"
            )
    zeta: dict[Tree, Sequence[Any]] = {}
    for n in range(2, max(orders) + 1, 2):
        for t in trees(n, SEPARABLE):
            if n <= order or is_nystrom(t):
                found = next((s.zeta[t] for s in series if t in s.zeta), None)
                if found is None:
                    raise DataError("a start has no higher order than the pair; claim less")
                zeta[t] = found
    return PairTarget(zeta, {"f": len(system.V), "k": len(system.V_hat)})


def start_orders(
    claims: Mapping[str, Any], block: Mapping[str, Any] | None = None
) -> tuple[int, int]:
    """Orders of a start that a file names: on all trees, on second-order systems.

    Args:
        claims: of the file. block: its ``"starting"``, whose order is a claim as well.
    """
    own = 0 if block is None else block.get("order", 0)
    return claims.get(STARTING_ORDER.key, own), claims.get(NYSTROM_STARTING_ORDER.key, 0)


def start_system(block: Mapping[str, Any]) -> StartingSystem:
    """The unknowns of a block ``"starting"`` of a pair."""
    return StartingSystem([row for x in ("A", "B", "A_hat", "B_hat") for row in block[x]])


def _split(block: Mapping[str, Any], rows: Sequence[Any]) -> dict[str, Sequence[Any]]:
    """The rows of a :func:`start_system` by the name of their matrix."""
    found, at = {}, 0
    for x in ("A", "B", "A_hat", "B_hat"):
        found[x] = rows[at : at + len(block[x])]
        at += len(block[x])
    return found


def even_weights(
    matrices: Mapping[str, Sequence[Sequence[Any]]], wanted: Sequence[Tree]
) -> dict[Tree, list[Any]]:
    """Series of the values of a start with parity, at even trees, over any scalar.

    Args:
        matrices: A (n_Q, n_P), A_hat (n_P, n_Q), B (r, n_P), B_hat (r^, n_Q), stage 0 the point
            itself and stages 2 i - 1, 2 i exchanged by h -> -h.
        wanted: trees of even order.

    Returns
    -------
        For each tree the coefficient in each value.
    """
    stages: dict[Tree, list[Any]] = {}

    def slopes(t: Tree) -> list[Any] | None:
        found: list[Any] | None = None
        for child in t.children:
            x = stage(child)
            found = x if found is None else [a * b for a, b in zip(found, x, strict=True)]
        return found

    def stage(t: Tree) -> list[Any]:
        if t not in stages:
            below, sign = slopes(t), 1 if t.order % 2 else -1
            rows = matrices[STAGES[t.colour]][1::2]
            stages[t] = [_stage(row, below, sign) for row in rows]
        return stages[t]

    def value(row: Sequence[Any], below: list[Any]) -> Any:
        # the partner has the opposite weight and, at an even tree, the opposite slope
        return linalg.dot(row[1::2], below) * 2

    return {t: [value(r, slopes(t) or []) for r in matrices[WEIGHTS[t.colour]]] for t in wanted}


def _stage(row: Sequence[Any], below: list[Any] | None, sign: int) -> Any:
    """Series of a stage: slopes ``below`` at stages 1, 3, .. and ``sign`` times that at 2, 4, .."""
    total: Any = Exact(0)
    pairs = list(zip(row[1::2], row[2::2], strict=True))
    if below is None:  # a single node: the slope is one everywhere, and the point itself counts
        return sum((x for pair in pairs for x in pair), row[0])
    for (x, y), slope in zip(pairs, below, strict=True):
        factor = x + y if sign > 0 else x - y
        if factor.is_zero() is not True:
            total = total + factor * slope
    return total


def start_function(block: Mapping[str, Any], target: PairTarget) -> Any:
    """The conditions of a start as a function of its unknowns, value by value beyond the first."""
    system, wanted = start_system(block), list(target.zeta)

    def conditions(values: Sequence[Any]) -> list[Any]:
        found = even_weights(_split(block, system.read(values)), wanted)
        return [
            x - y for t in wanted for x, y in zip(found[t][1:], target.zeta[t][1:], strict=True)
        ]

    return conditions


def _swap(i: int) -> int:
    """The partner of a stage: 0 is the point itself, then come pairs (1, 2), (3, 4), .."""
    return 0 if i == 0 else i + 1 if i % 2 else i - 1


def _check_form(block: Mapping[str, Any], target: PairTarget) -> None:
    """First values the solution, the others even in h, for all values of the unknowns.

    Raises
    ------
        DataError: naming the entry.
    """
    for name, colour in (("u", "f"), ("u_hat", "k")):
        wanted = [Exact(int(k == 0)) for k in range(target.values[colour])]
        if [parse(x) for x in block[name]] != wanted:
            raise DataError(f"`starting.{name}` must be 1, 0, .., 0")
    for name, rows in _split(block, start_system(block).affine()).items():
        if len(rows[0]) % 2 == 0:
            raise DataError(
                f"a start with parity has odd numbers of stages, and `starting.{name}` has "
                f"{len(rows[0])} columns"
            )
        if any(not x.is_identically_zero() for x in rows[0]):
            what = "value" if name in WEIGHTS.values() else "stage"
            raise DataError(f"`starting.{name}[1]` must be zero: the first {what} is the solution")
        for i, row in enumerate(rows):
            partner = rows[_swap(i)] if name in STAGES.values() else row
            for j, x in enumerate(row):
                if not (partner[_swap(j)] + x).is_identically_zero():
                    place = f"`starting.{name}[{i + 1}][{j + 1}]`"
                    raise DataError(f"no parity: {place} and its mirror image differ")


def prove_pair_start(
    block: Mapping[str, Any], target: PairTarget, *, digits: int = DIGITS
) -> Krawczyk:
    """Prove that an exact start lies within the digits of a block ``"starting"``.

    Raises
    ------
        DataError: when the start has not the form described above.
        ExactnessError: when the interval test does not succeed.
    """
    _check_form(block, target)
    system = start_system(block)
    asked = sum(len(values) - 1 for values in target.zeta.values())
    if asked != len(system.unknowns):
        raise DataError(
            f"`starting` has {len(system.unknowns)} unknowns, and the orders claimed ask for "
            f"{asked} conditions; there must be as many"
        )
    return enclosed_block(system, start_function(block, target), digits, "starting")


def expanded(half: Mapping[str, Sequence[Sequence[str]]]) -> dict[str, Any]:
    """The block of a start from one stage of each pair.

    Args:
        half: "A" and "A_hat": rows of the stages 1, 3, ..; "B" and "B_hat": for each value beyond
            the first the weights of the stages 1, 3, ... Rationals, or decimals of any length for
            the unknowns: equal decimals are one unknown.
    """
    block: dict[str, Any] = {}
    for name in STAGES.values():
        rows = [[_text(x) for x in row] for row in half[name]]
        full = [["0"] * len(rows[0])]
        for row in rows:
            full += [row, [_negated(row[_swap(j)]) for j in range(len(row))]]
        block[name] = full
    for name in WEIGHTS.values():
        rows = [[_text(x) for x in row] for row in half[name]]
        flat = [["0", *(y for x in row for y in (x, _negated(x)))] for row in rows]
        block[name] = [["0"] * len(flat[0]), *flat]
    block["u"] = ["1"] + ["0"] * len(half["B"])
    block["u_hat"] = ["1"] + ["0"] * len(half["B_hat"])
    q, p = len(block["A"]), len(block["A_hat"])
    name = f"explicit start of {q} stages Q and {p} stages P, even in h"
    return {"name": name, "kind": "runge-kutta", **block}


def _text(value: str) -> str:
    """A rational as it is; a decimal with all its places, to be recognised as an unknown."""
    return decimal(ball(Fraction(value))) if "." in value else value


def _negated(text: str) -> str:
    if text == "0":
        return text
    return text[1:] if text.startswith("-") else f"-{text}"


def complete_start(
    half: Mapping[str, Sequence[Sequence[str]]], target: PairTarget, order: int
) -> tuple[dict[str, Any], Krawczyk]:
    """Polish a start to :data:`~glmref.catalogue.writer.DIGITS` digits and prove it.

    Args:
        half: see :func:`expanded`. target: of the pair. order: for the block.

    Raises
    ------
        ConvergenceError, ExactnessError: when the digits lead to no exact start.
    """
    rough = expanded(half)
    system = start_system(rough)
    found = polish(start_function(rough, target), system.published(DIGITS), digits=90)
    new = dict(zip(system.unknowns, (decimal(x) for x in found), strict=True))
    if any(x.startswith("-") for x in new.values()):
        raise ExactnessError("an entry of the start changed its sign while it was polished")
    block = {**rough, "order": order}
    for name in ("A", "B", "A_hat", "B_hat"):
        block[name] = [[_polished(x, new) for x in row] for row in rough[name]]
    return block, prove_pair_start(block, target)


def with_start(
    document: Mapping[str, Any], numbers: PairNumbers, half: Mapping[str, Any]
) -> dict[str, Any]:
    """Add a start of the order of the pair, and of its order on second-order systems.

    Args:
        document: of a pair whose first values are the solution. numbers: enclosed. half: see
            :func:`expanded`.

    Raises
    ------
        ConvergenceError, ExactnessError: when the digits lead to no exact start.
    """
    claims = dict(document["claims"])
    claims[STARTING_ORDER.key] = claims[ORDER.key]
    if NYSTROM_ORDER.key in claims:
        claims[NYSTROM_STARTING_ORDER.key] = claims[NYSTROM_ORDER.key]
    system, orders = PairSystem(document), start_orders(claims)
    series = [
        system.series(numbers, {}, order, nystrom=nystrom, starts=True)
        for order, nystrom in zip(orders, (False, True), strict=True)
        if order
    ]
    block, _ = complete_start(half, pair_target(system, series, orders), claims[ORDER.key])
    return {**document, "starting": block, "claims": claims}


def _polished(text: str, new: Mapping[str, str]) -> str:
    size = text.removeprefix("-")
    return text.replace(size, new[size]) if size in new else text
