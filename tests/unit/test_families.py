"""Families as general linear methods: the tableau must be the recursion it stands for."""

from fractions import Fraction

import pytest

from glmref.exact import Exact, exact
from glmref.exact.linalg import solve
from glmref.method import families

LAMBDA = Fraction(-2, 3)  # h lambda of the linear problem the recursions are run on


def step(m, y):
    """One step of a method on y' = lambda y with h = 1, exactly."""
    s, r = m.s, m.r
    one_minus = tuple(
        tuple(exact(int(i == j)) - LAMBDA * m.A[i][j] for j in range(s)) for i in range(s)
    )
    right = tuple((sum((m.U[i][k] * y[k] for k in range(r)), Exact(0)),) for i in range(s))
    stages = [row[0] for row in solve(one_minus, right)]
    return [
        sum((m.B[k][j] * stages[j] * LAMBDA for j in range(s)), Exact(0))
        + sum((m.V[k][l] * y[l] for l in range(r)), Exact(0))
        for k in range(r)
    ]


def multistep_values(alpha, beta, start, count):
    """The recursion itself, in Fractions, on y' = lambda y."""
    k = len(alpha) - 1
    y = list(start)
    for n in range(count):
        known = sum((LAMBDA * beta[m] - alpha[m]) * y[n + m] for m in range(k))
        y.append(known / (alpha[k] - LAMBDA * beta[k]))
    return y


CASES = [
    (["0", "-1", "1"], ["-1/2", "3/2", "0"]),  # Adams-Bashforth 2
    (["0", "-1", "1"], ["-1/12", "2/3", "5/12"]),  # Adams-Moulton 2
    (["-1", "0", "1"], ["0", "2", "0"]),  # leapfrog
    (["-1", "0", "1"], ["1/3", "4/3", "1/3"]),  # Milne-Simpson
    (["1/3", "-4/3", "1"], ["0", "0", "2/3"]),  # BDF2
    (["1", "-2", "3", "2"], ["1", "0", "5", "7"]),  # no method at all, but a recursion
    (["0", "0", "-1", "1"], ["2", "0", "0", "0"]),
    (["-1", "1"], ["1", "0"]),
]


def followed(alpha, beta):
    """Return the coefficients and four values after k of the recursion."""
    a, b = [Fraction(x) for x in alpha], [Fraction(x) for x in beta]
    return a, b, multistep_values(a, b, [Fraction(m, 3) for m in range(1, len(a))], 4)


def assert_follows(method, values, y):
    """Steps give the recursion, from values as exact numbers on."""
    for expected in y:
        values = step(method, values)
        assert values[0] == expected


@pytest.mark.parametrize(("alpha", "beta"), CASES)
def test_multistep_glm_reproduces_the_recursion(alpha, beta):
    a, b, y = followed(alpha, beta)
    k = len(a) - 1
    m = families.linear_multistep(alpha, beta)
    implicit = b[k] != 0
    ys = k - min(next(i for i, x in enumerate(a) if x), k - 1)
    fs = m.r - ys
    newest = k - 1 if implicit else k - 2
    carried = [y[k - 1 - j] for j in range(ys)] + [LAMBDA * y[newest - j] for j in range(fs)]
    assert_follows(m, [exact(x) for x in carried], y[k:])


@pytest.mark.parametrize(("alpha", "beta"), CASES)
def test_a_multistep_method_of_balls_carries_no_value_for_a_zero(alpha, beta):
    sharp = families.linear_multistep(alpha, beta)
    balls = families.linear_multistep(
        *([exact(Fraction(x)).ball() for x in row] for row in (alpha, beta))
    )
    assert (balls.r, balls.is_explicit) == (sharp.r, sharp.is_explicit)


@pytest.mark.parametrize(("alpha", "beta"), CASES[:5])
def test_one_leg_glm_reproduces_the_recursion(alpha, beta):
    # on a linear problem f(sum beta y) = sum beta f(y): the twin follows the same recursion
    a, _, y = followed(alpha, beta)
    k = len(a) - 1
    assert_follows(families.one_leg(alpha, beta), [exact(y[k - 1 - j]) for j in range(k)], y[k:])


def test_splitting_is_the_step_it_says():
    pair = families.splitting(["1/2", "1/2"], ["1"], first="q")  # position Verlet
    assert (pair.n_P, pair.n_Q, pair.separable) == (2, 1, True)
    assert pair.A == ((Fraction(1, 2), 0),)
    assert pair.A_hat == ((0,), (1,))
    other = families.splitting(["1"], ["1/2", "1/2"], first="p")  # velocity Verlet
    assert other.A == ((0,), (1,))
    assert other.A_hat == ((Fraction(1, 2), 0),)
