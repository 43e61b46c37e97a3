"""Search for starts of pairs with parity: all explicit tableaux of a number of stages.

With n pairs of stages Q and n pairs of stages P, in the order Q_1, P_1, Q_2, .., a start of one
value of q and one of p beyond the first has 2 n^2 + 4 n coefficients: 16 for n = 2, where order 4
has 10 conditions, 126 for n = 7, where order 6 has 50. More stages than the count asks for make
solutions easy to find; the free coefficients are then fixed at short fractions near a solution.

The starts of the shipped pairs began so and were thinned out afterwards: stages and coefficients
were weighted more and more in a least-norm solution until they vanished. What is left is on record
in ``recipes/partitioned_starts.json``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from glmref.derive.parameters import pivots
from glmref.derive.parity_start import expanded
from glmref.derive.search import Found, evaluate, search
from glmref.errors import UsageError
from glmref.exact.judging import fast_judge
from glmref.prove.starting import Target, function_of

#: Width of the random coefficients: the solutions found have them between 0.05 and 1.
WIDTH = 0.4


def general_start(pairs: int) -> dict[str, list[list[str]]]:
    """Return one stage of each pair of every explicit start, for :func:`.parity_start.expanded`.

    Raises
    ------
    UsageError
        For a number of pairs out of range.
    """
    if not 1 <= pairs <= 20:
        raise UsageError(f"`pairs` must lie between 1 and 20, got {pairs}")
    names = iter(f"0.{k:020d}" for k in range(1, 10_000))

    def row(reached: int) -> list[str]:
        """Return the point itself and the pairs that come before."""
        known = [next(names) for _ in range(1 + 2 * reached)]
        return known + ["0"] * (2 * (pairs - reached))

    return {
        "A": [row(i) for i in range(pairs)],
        "A_hat": [row(i + 1) for i in range(pairs)],
        "B": [[next(names) for _ in range(pairs)]],
        "B_hat": [[next(names) for _ in range(pairs)]],
    }


def _weighted(pairs: int, target: Target) -> tuple[Any, list[str]]:
    """Return the conditions times the density of their trees, and the names of the unknowns.

    Without the factor high orders would hardly count.
    """
    document = {"digits": 20, "starting": expanded(general_start(pairs))}
    start = target.of_document(document).start
    conditions = function_of(start, start.wanted)
    weights = [fast_judge().trees.gamma(t) for _, t in start.wanted]

    def residuals(values: Sequence[Any]) -> list[Any]:
        return [x * w for x, w in zip(conditions(values), weights, strict=True)]

    return residuals, list(start.unknowns)


def search_start(
    target: Target, pairs: int, *, seed: int, starts: int, iterations: int = 300
) -> Iterator[Found]:
    """Solve the conditions from random coefficients, reproducibly."""
    residuals, names = _weighted(pairs, target)

    def draw(generator: np.random.Generator) -> np.ndarray:
        return generator.normal(size=len(names)) * WIDTH

    return search(residuals, draw, seed=seed, starts=starts, iterations=iterations)


def fixed_start(
    target: Target, pairs: int, point: Sequence[float], *, places: int = 3
) -> dict[str, list[list[str]]]:
    """Fix as many coefficients at short fractions as are free; the others are rough decimals.

    The point is a solution that :func:`search_start` found.
    """
    residuals, order = _weighted(pairs, target)
    _, jacobians = evaluate(residuals, np.array([point], dtype=float))
    free = set(pivots(jacobians[0]))
    half = general_start(pairs)
    texts: Mapping[str, str] = {
        name: str(Fraction(round(x * 10**places), 10**places)) if k in free else f"{x:.14f}"
        for k, (name, x) in enumerate(zip(order, point, strict=True))
    }
    long = {name[:22]: text for name, text in texts.items()}
    return {key: [[long.get(x, x) for x in row] for row in rows] for key, rows in half.items()}
