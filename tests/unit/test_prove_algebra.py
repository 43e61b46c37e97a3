"""Linear algebra of proofs: blocks of values, bounded powers."""

import random
from contextlib import suppress
from fractions import Fraction
from typing import Any

import pytest

from glmref.judge.arithmetic import Interval
from glmref.judge.linalg import blocks_of, characteristic
from glmref.judge.polynomials import from_roots, is_schur, is_unbounded, multiply, plus
from glmref.judge.refusals import Undecided
from glmref.judge.rules_growth import PowersCase, one_block_is_on_the_circle, powers_are_bounded
from glmref.judge.rules_stability import never_meet

SMALL = Interval.ends(Fraction(-1, 10**20), Fraction(1, 10**20))


@pytest.mark.parametrize("seed", range(12))
def test_the_blocks_have_together_the_eigenvalues_of_the_matrix(seed: int) -> None:
    draw = random.Random(seed)
    r = draw.randint(1, 7)
    V = [[Fraction(draw.choice((0, 0, 0, k))) for k in range(1, r + 1)] for _ in range(r)]
    product = [Fraction(1)]
    for block in blocks_of(V):
        product = multiply(product, characteristic(block))
        # no block comes apart further
        assert len(block) == 1 or len(blocks_of(block)) == 1
    assert product == characteristic(V)


def powers(V: list[list[Any]]) -> bool | None:
    """What the judge shows of the powers of V: bounded, not bounded, or neither."""
    case = PowersCase.__new__(PowersCase)
    case.V = V
    for block in blocks_of(V):
        with suppress(Undecided):
            if is_unbounded(block):
                return False
    return True if one_block_is_on_the_circle(case) and powers_are_bounded(case) else None


@pytest.mark.parametrize(
    ("block", "expected"),
    [([[0, 1], [1, 0]], True), ([[0, 1], [-1, 0]], True), ([[1, 1], [0, 1]], None),
     ([[1, 1], [1, 1]], False), ([[0, 0, 1], [1, 0, 0], [0, 1, 0]], True)],
)  # fmt: skip
def test_one_exact_block_on_the_circle_beside_rounded_ones_inside(block, expected):
    n = len(block)
    V: list[list[Any]] = [[Fraction(x) for x in row] + [Fraction(0)] for row in block]
    V.append([Fraction(0)] * n + [SMALL + Fraction(1, 2)])
    assert powers(V) is expected
    V[n][n] = SMALL + Fraction(2)
    assert powers(V) is False


@pytest.mark.parametrize("seed", range(20))
def test_roots_inside_the_circle_over_rationals_and_intervals(seed: int) -> None:
    draw = random.Random(seed)
    roots = [Fraction(draw.choice((0, 1, 2, 3, 5, -3, 9)), 4) for _ in range(draw.randint(1, 4))]
    p = from_roots(roots)
    inside = max(map(abs, roots)) < 1
    assert is_schur(p) is inside
    assert is_schur([x + SMALL if x else x for x in p]) is inside


@pytest.mark.parametrize("middle", ["0", "1/3", "2"])
def test_where_the_ends_agree_roots_may_lie_on_the_circle(middle: str) -> None:
    for sign in (1, -1):
        with pytest.raises(Undecided):
            is_schur([SMALL + Fraction(sign), SMALL + Fraction(middle), Fraction(1)])


@pytest.mark.parametrize(("other", "inside"), [(Fraction(1, 2), True), (Fraction(2), False)])
@pytest.mark.parametrize("zeros", [1, 2])
def test_roots_that_are_0_lie_inside_the_circle(other: Fraction, inside: bool, zeros: int) -> None:
    """x - other, with intervals as coefficients, times x or x^2."""
    nil = [Fraction(0)] * zeros
    assert is_schur([*nil, SMALL - other, SMALL + Fraction(1)]) is inside
    assert is_schur([*nil, Fraction(1)])


@pytest.mark.parametrize(
    ("third", "meet"),
    [((3,), False), ((-5, 0, 1), False), ((0, 1), False), ((2, 0, 1), True), ((3, 0, 1), True)],
)
def test_roots_that_meet_on_the_axis_are_told(third: tuple[int, ...], meet: bool) -> None:
    """1, 3 / 2 and a polynomial in z = i y, which 1 or 3 / 2 is for no real y but 0, or for some."""
    product = [[Fraction(1)]]
    for root in ([1], [Fraction(3, 2)], list(third)):
        lower = [multiply([-Fraction(x) for x in root], c) for c in product]
        product = [plus(x, y) for x, y in zip([*lower, []], [[], *product], strict=True)]
    assert never_meet(product) is not meet
