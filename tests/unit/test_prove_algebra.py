"""Linear algebra of proofs: blocks of values, bounded powers."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest

from glmref.exact import Ball, Exact, ball, exact
from glmref.prove import algebra
from glmref.prove.algebra import bounded, diagonal_values, in_right_half, inside_circle, leaves_disc
from glmref.theory import polynomials as poly

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


def polynomial(roots: list[complex]) -> list[Fraction]:
    """The real polynomial with these roots, from the constant term up; entries that are near."""
    found = [1.0 + 0j]
    for z in roots:
        found = [x - z * y for x, y in zip([0j, *found], [*found, 0j], strict=True)]
    return [Fraction(x.real).limit_denominator(10**9) for x in found]


@pytest.mark.parametrize("seed", range(20))
def test_roots_inside_the_circle_and_in_the_right_half_plane(seed: int) -> None:
    draw = random.Random(seed)
    roots: list[complex] = []
    for _ in range(draw.randint(1, 3)):
        z = complex(draw.choice((0, 1, 2, 3, 5, -3, 9)), draw.choice((0, 1, 2))) / 4
        roots += [z] if z.imag == 0 else [z, z.conjugate()]
    sizes = [abs(z) for z in roots]
    if 1.0 in sizes or 0.0 in (z.real for z in roots):
        roots, sizes = [0.5], [0.5]
    p = tuple(exact(x) for x in polynomial(roots))
    assert in_right_half(p) == all(z.real > 0 for z in roots)
    for q in (p, tuple(ball(x) for x in p)):
        found = inside_circle(q)
        assert found == (max(sizes) < 1) or (found is None and max(sizes) > 1)


@pytest.mark.parametrize("middle", ["0", "1/3", "2"])
def test_where_the_ends_agree_roots_may_lie_on_the_circle(middle: str) -> None:
    for sign in (1, -1):
        p = (exact(sign), SMALL + Fraction(middle), exact(1))
        assert inside_circle(p) is None


@pytest.mark.parametrize(
    ("root", "simple"),
    [
        (((1,), (2,)), True),  # 1/2 for all y
        (((0, 2), (2, 0, 2)), True),  # y/(1 + y^2), of modulus at most 1/2
        (((0, 2), (1, 0, 1)), False),  # 2 y/(1 + y^2), which is 1 at y = 1 and -1 at y = -1
        (((1,), (1, 0, 1)), True),  # 1/(1 + y^2), which is 1 at y = 0 alone
    ],
)
def test_a_double_root_that_touches_the_circle_is_told(root: Any, simple: bool) -> None:
    """(w - root(y))^2, without fractions; y = 0 is left aside."""
    top, bottom = (tuple(map(Exact, x)) for x in root)
    square = poly.mul(bottom, bottom), poly.mul(top, bottom), poly.mul(top, top)
    q = (square[2], tuple(-2 * x for x in square[1]), square[0])
    assert leaves_disc(q) == (None, simple)


@pytest.mark.parametrize(("other", "inside"), [(Fraction(1, 2), True), (Fraction(2), False)])
@pytest.mark.parametrize("zeros", [1, 2])
def test_roots_that_are_0_lie_inside_the_circle(other: Fraction, inside: bool, zeros: int) -> None:
    """x - other, with balls as coefficients, times x or x^2."""
    p = (*[exact(0)] * zeros, ball(-other) + SMALL, ball(1))
    assert inside_circle(p) is inside
    assert inside_circle((*p[:zeros], exact(1))) is True


@pytest.mark.parametrize(
    ("third", "multiple"),
    [
        ((3,), False),
        ((0,), False),
        ((0, 1), True),
        ((11, -1), True),
        ((2, 0, 1), False),
        ((-2, 0, 1), True),
    ],
)
def test_roots_that_meet_on_the_axis_are_told(third: tuple[int, ...], multiple: bool) -> None:
    """1, 2 and a polynomial in y, times 1 + y^2, which makes the resultant as long as it can be."""
    one = (Exact(1),)
    product: list[Any] = [(Exact(1), Exact(0), Exact(1))]
    for root in (one, (Exact(2),), tuple(map(Exact, third))):
        lower = [poly.mul(tuple(-x for x in root), c) for c in product]
        product = [poly.add(x, y) for x, y in zip([*lower, ()], [(), *product], strict=True)]
    assert algebra.multiple_on_axis(product) is multiple
