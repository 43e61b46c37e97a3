"""The starting method of a pair against the pair's starting series.

Public names::

    pair_starting_series(start, order, palette) -> Series        (vectors of r or r^ entries)
    pair_starting_order(pair, start, known) -> StartingResult
    zero_start_order(known) -> (int, str)

The outputs of a pair are the solution, no finishing method follows, and so a start of order q
agrees on all trees of order <= q with the one starting series whose principal parts are zero
(:mod:`.theory.partitioned`): for separable pairs on the trees whose colours alternate, for others
on all two-coloured trees. On second-order systems (:mod:`glmref.theory.nystrom`) only the trees
count in which no vertex f has two children. For q = p, the order of the pair, errors in all values
are O(h^(p+1)) after the start.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ..errors import UsageError
from ..exact import Ball
from ..findings import Proof
from ..method import PairStartingMethod, PartitionedGLM
from .blocks import as_scalar
from .coefficients import is_zero, plus, times
from .order import OrderResult
from .series import Series
from .starting import StartingResult
from .trees import GENERAL, SEPARABLE, Palette, Tree, trees

__all__ = ["pair_starting_order", "pair_starting_series", "zero_start_order"]


def pair_starting_series(start: PairStartingMethod, order: int, palette: Palette) -> Series:
    """Return the P-series of a start, through the given order.

    Trees with root f give the values of q, those with root k the values of p.
    """
    A = {"f": _sparse(start.A), "k": _sparse(start.A_hat)}
    B = {"f": _sparse(start.B), "k": _sparse(start.B_hat)}
    ones = {"f": (1,) * len(start.A_hat), "k": (1,) * len(start.A)}
    stages: dict[Tree, tuple[Any, ...]] = {}
    values: dict[Tree, tuple[Any, ...]] = {}
    for n in range(1, order + 1):
        for t in trees(n, palette):
            slopes = ones[t.colour]
            for child in t.children:
                slopes = tuple(times(x, y) for x, y in zip(slopes, stages[child], strict=True))
            if n < order:
                stages[t] = tuple(_dot(row, slopes) for row in A[t.colour])
            values[t] = tuple(_dot(row, slopes) for row in B[t.colour])
    return Series(values, {"f": tuple(start.u), "k": tuple(start.u_hat)}, order, palette)


def _sparse(rows: Iterable[Iterable[Any]]) -> list[list[tuple[int, Any]]]:
    return [[(j, x) for j, x in enumerate(row) if is_zero(x) is not True] for row in rows]


def _dot(row: Iterable[tuple[int, Any]], x: tuple[Any, ...]) -> Any:
    total: Any = 0
    for j, factor in row:
        total = plus(total, times(factor, x[j]))
    return total


def pair_starting_order(
    pair: PartitionedGLM,
    start: PairStartingMethod,
    known: OrderResult,
    *,
    counts: Callable[[Tree], bool] = lambda t: True,
    compared: str = "all trees",
) -> StartingResult:
    """Decide through which order a start agrees with the starting series of a pair.

    Args:
        pair: the pair that is started. start: gives r values of q and r^ values of p.
        known: its order with ``principal="identity"``, with the starting series; on second-order
            systems that of :func:`~glmref.theory.nystrom.nystrom_order_of`.
        counts: which trees are compared. compared: the same in words.

    Returns
    -------
        The order, not above that of the pair, and the first tree where they differ; its root says
        whether the value is one of q (f) or of p (k).

    Raises
    ------
        UsageError: when the number of values differs.
    """
    _check_sizes(pair, start)
    enclosed = known.proof is Proof.ENCLOSED or any(
        isinstance(x, Ball) for row in start.rows() for x in row
    )
    proof, p, eta = (Proof.ENCLOSED if enclosed else Proof.EXACT), known.order, known.eta
    if eta is None:
        return StartingResult(-1, proof=proof, residual=as_scalar(1))
    series = pair_starting_series(start, p, SEPARABLE if pair.separable else GENERAL)
    largest = 0.0
    for colour in "fk":
        gap = _difference(series.empty(colour), eta.empty(colour))
        at = _first_nonzero(gap)
        if at is not None:
            return StartingResult(
                -1, component=at + 1, residual=gap[at], proof=proof, method_order=p
            )
    for t in (t for n in range(1, p + 1) for t in trees(n, series.palette) if counts(t)):
        gap = _difference(series[t], eta[t])
        at = _first_nonzero(gap)
        if at is not None:
            return StartingResult(
                t.order - 1,
                failing_tree=t,
                component=at + 1,
                residual=gap[at],
                proof=proof,
                largest_residual=largest,
                method_order=p,
            )
        largest = max(largest, *(x.magnitude() for x in gap))
    return StartingResult(
        p, proof=proof, largest_residual=largest, method_order=p, compared=compared
    )


def _check_sizes(pair: PartitionedGLM, start: PairStartingMethod) -> None:
    if (len(start.u), len(start.u_hat)) != (pair.r, pair.r_hat):
        raise UsageError(
            f"a start of {pair.r} values of q and {pair.r_hat} of p must have as many entries in "
            f"`u` and `u_hat`, got {len(start.u)} and {len(start.u_hat)}"
        )


def _difference(x: Iterable[Any], y: Iterable[Any]) -> tuple[Any, ...]:
    return tuple(as_scalar(plus(a, times(-1, b))) for a, b in zip(x, y, strict=True))


def _first_nonzero(vector: tuple[Any, ...]) -> int | None:
    return next((i for i, x in enumerate(vector) if x.is_zero() is False), None)


def zero_start_order(result: OrderResult) -> tuple[int, str]:
    """To which order the start u y_0, (y_0, 0, ..) as a rule, agrees with the starting series.

    Args:
        result: its order with ``principal="identity"``, with the starting series.

    Returns
    -------
        The largest q, not above the order, with zeta(t) = 0 for 0 < |t| <= q; and one sentence
        that names the first tree where it is not.
    """
    for t in sorted(result.eta or {}, key=lambda t: t.order):
        values = () if result.eta is None else result.eta[t]
        if t.order and any(as_scalar(x).is_zero() is False for x in values):
            return t.order - 1, f"a carried value starts with a term of {t}"
    return result.order, "every carried value starts with zero"
