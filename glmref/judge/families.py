"""From the numbers of a family of methods to its matrices (section 1): numbers of any kind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from .arithmetic import Fraction
from .linalg import identity, multiples
from .numbers import total


class Component(NamedTuple):
    """Matrices A (stages, slopes), U, B, V; those that a series of a start has not are empty."""

    A: list
    U: list
    B: list
    V: list

    @property
    def r(self) -> int:
        """Number of values."""
        return len(self.V)


def runge_kutta(A: Sequence, b: Sequence) -> Component:
    """Return A, U = 1, B = b, V = 1."""
    return Component([*A], [[Fraction(1)] for _ in A], [[*b]], [[Fraction(1)]])


def composition(base: Sequence, b: Sequence, gamma: Sequence) -> Component:
    """Return the method (A, b) = (base, b) with steps gamma_1 h, gamma_2 h, .. as one."""
    zero, A, left = [Fraction(0)], [], []
    for k, g in enumerate(gamma, 1):
        right = zero * (len(b) * (len(gamma) - k))
        A += [left + multiples(g, row) + right for row in base]
        left = left + multiples(g, b)
    return runge_kutta(A, left)


def linear_multistep(a: Sequence, b: Sequence) -> Component:
    """Return the form with one stage and the values y and f that are needed; a_k = 1."""
    k, implicit = len(a) - 1, bool(b[-1])
    low = next((m for m in range(k) if a[m]), k - 1)
    ys = list(range(k - 1, low - 1, -1))
    first = next((m for m in range(k + 1) if b[m]), k)
    fs = list(range(k - 1 if implicit else k - 2, first - 1, -1))
    r, e = len(ys) + len(fs), identity(len(ys) + len(fs))
    new = [-a[m] for m in ys] + [b[m] for m in fs]
    V = [new, *e[: len(ys) - 1]]
    B = [b[k] if implicit else b[k - 1]] + [Fraction(0)] * (len(ys) - 1)
    if fs:
        V += [[Fraction(0)] * r, *e[len(ys) : r - 1]]
        B += [Fraction(1)] + [Fraction(0)] * (len(fs) - 1)
    return Component([[b[k]]], [new if implicit else e[0]], [[x] for x in B], V)


def one_leg(a: Sequence, leg: Sequence, unit) -> Component:
    """Return the form with the values y; a_k = 1, the unit is 1 / alpha_k, beta is not divided."""
    k = len(a) - 1
    back = range(k - 1, -1, -1)
    V = [[-a[m] for m in back], *identity(k)[: k - 1]]
    U = [leg[m] - x for m, x in zip(back, multiples(leg[k], a[-2::-1]), strict=True)]
    B = [[unit]] + [[Fraction(0)] for _ in range(k - 1)]
    return Component([[unit * leg[k]]], [U], B, V)


def splitting(a: Sequence, b: Sequence, first: str) -> tuple[Component, Component]:
    """Return the pair of a splitting: P stages from a, Q stages from b."""
    early, zero = int(first == "q"), Fraction(0)  # stage Q_j has seen a_0 .. a_(j-1+early)
    A = [[x if i < j + early else zero for i, x in enumerate(a)] for j in range(len(b))]
    A_hat = [[x if j + early <= i else zero for j, x in enumerate(b)] for i in range(len(a))]
    return runge_kutta(A, a), runge_kutta(A_hat, b)


def nystrom(
    A: Sequence, c: Sequence, inner: Sequence | None, weights: Sequence
) -> tuple[Component, Component]:
    """Return the pair q' = p, p' = k: the stages p and p + h k_l, from which Q is combined."""
    s, zero = len(c), Fraction(0)
    below_q = [[x - total(row), *row] for x, row in zip(c, A, strict=True)]
    below_p = [[zero] * s, *identity(s)]
    if inner is not None:
        below_q = [[zero] * (2 * s + 1)] * (s + 1) + [row + [zero] * s for row in below_q]
        below_p = [[zero] * (s + 1) + [*row] for row in (*below_p, *inner)]
    return runge_kutta(below_q, weights[0]), runge_kutta(below_p, weights[1])


def nystrom_weights(b: Sequence, b_prime: Sequence, shared: bool) -> list[list]:
    """Return weights of q on the stages P and of p on the stages Q, which may be `shared`."""
    none = [Fraction(0)] * (len(b) if shared else 0)
    return [[1 - total(b), *b, *none], none + [Fraction(0)] * shared + list(b_prime)]


def rosenbrock(alpha: Sequence, beta: Sequence, b: Sequence) -> tuple[Component, Component]:
    """Return f - J with alpha and J with beta, alpha + gamma, below it, on two sets of stages."""
    rows, weights, none = [*alpha, *beta], rosenbrock_weights(b), [Fraction(0)] * len(b)
    return (runge_kutta([[*x, *none] for x in rows], weights[0]),
            runge_kutta([[*none, *x] for x in rows], weights[1]))  # fmt: skip


def rosenbrock_weights(b: Sequence) -> list[list]:
    """Return the weights of both sets of stages."""
    none = [Fraction(0)] * len(b)
    return [[*b, *none], [*none, *b]]
