"""Linear algebra of proofs: blocks of values, bounded powers."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest

from glmref.exact import Ball, ball, exact
from glmref.prove.algebra import bounded, diagonal_values

SMALL = Ball.around(ball(0), Fraction(1, 10**20))


def reached(V: Any) -> list[set[int]]:
    found = [{i} | {j for j, x in enumerate(row) if x != 0} for i, row in enumerate(V)]
    while True:
        wider = [set().union(*(found[j] for j in x)) for x in found]
        if wider == found:
            return found
        found = wider


@pytest.mark.parametrize("seed", range(12))
def test_each_value_stands_in_one_block_with_those_it_exchanges_with(seed: int) -> None:
    draw = random.Random(seed)
    r = draw.randint(1, 7)
    V = [[exact(draw.choice((0, 0, 0, 1))) for _ in range(r)] for _ in range(r)]
    found, reach = diagonal_values(V), reached(V)  # type: ignore[arg-type]
    assert sorted(i for group in found for i in group) == list(range(r))
    for group in found:
        for i in group:
            assert set(group) == {j for j in range(r) if j in reach[i] and i in reach[j]}


@pytest.mark.parametrize(
    ("block", "expected"),
    [([[0, 1], [1, 0]], True), ([[0, 1], [-1, 0]], True), ([[1, 1], [0, 1]], None),
     ([[1, 1], [1, 1]], False), ([[0, 0, 1], [1, 0, 0], [0, 1, 0]], True)],
)  # fmt: skip
def test_one_exact_block_on_the_circle_beside_rounded_ones_inside(
    block: list[list[int]], expected: bool | None
) -> None:
    n = len(block)
    V = [[exact(x) for x in row] + [exact(0)] for row in block]
    V.append([exact(0)] * n + [SMALL + Fraction(1, 2)])
    assert bounded(tuple(map(tuple, V))) is expected
    V[n][n] = SMALL + 2
    assert bounded(tuple(map(tuple, V))) is False
