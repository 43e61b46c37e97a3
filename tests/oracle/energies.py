"""Symplecticity and energy of one-step methods by definition: steps of one Hamiltonian system.

A step with h and one with h / 2 give the power of h of a defect: of J in the Jacobian of the step,
and of the change of H.
"""

from __future__ import annotations

from collections.abc import Callable

from mpmath import mp

from .methods import Part
from .numbers import Number, Undecided, Vector

#: H = sum of c x^k over monomials in (q1, q2, p1, p2), with no symmetry.
MONOMIALS = (
    (1, (0, 0, 2, 0)), (2, (0, 0, 0, 2)), (3, (2, 0, 0, 0)), (1, (0, 3, 0, 0)), (2, (1, 1, 1, 0)),
    (1, (2, 0, 0, 1)), (-1, (0, 1, 1, 1)), (1, (1, 0, 2, 1)), (2, (0, 2, 0, 2)), (-3, (1, 2, 1, 0)),
)  # fmt: skip
STATE = ("0.7", "-0.4", "0.3", "0.9")
DIGITS, STEP, SMALL = 140, mp.mpf(10) ** -8, mp.mpf(10) ** -40


def energy(y: Vector) -> Number:
    """Return H."""
    return sum(c * mp.fprod(x**k for x, k in zip(y, powers, strict=True))
               for c, powers in MONOMIALS)  # fmt: skip


def field(y: Vector) -> Vector:
    """Return J^-1 grad H."""
    grad = [sum(c * powers[i] * y[i] ** (powers[i] - 1) *
                mp.fprod(y[j] ** k for j, k in enumerate(powers) if j != i)
                for c, powers in MONOMIALS if powers[i]) for i in range(4)]  # fmt: skip
    return [grad[2], grad[3], -grad[0], -grad[1]]


def step(method: Part, y: Vector, h: Number) -> Vector:
    """Return the step of a Runge-Kutta method."""
    slopes = [field(y)] * len(method.A)
    for _ in range(20):
        before, slopes = slopes, [field([x + h * sum(a * k[n] for a, k in zip(row, slopes, strict=True))
                                         for n, x in enumerate(y)]) for row in method.A]  # fmt: skip
        if slopes == before:
            break
    return [x + h * sum(b * k[n] for b, k in zip(method.B[0], slopes, strict=True))
            for n, x in enumerate(y)]  # fmt: skip


def symplectic_defect(method: Part, y: Vector, h: Number) -> Number:
    """Return entry (q1, p2) of M^T J M - J, M the Jacobian of a step by central differences."""
    columns = []
    for j in (0, 3):
        ends = [step(method, [x + e * (i == j) for i, x in enumerate(y)], h)
                for e in (SMALL, -SMALL)]  # fmt: skip
        columns.append([(a - b) / (2 * SMALL) for a, b in zip(*ends, strict=True)])
    u, v = columns
    return u[0] * v[2] + u[1] * v[3] - u[2] * v[0] - u[3] * v[1]


def energy_defect(method: Part, y: Vector, h: Number) -> Number:
    """Return the change of H in a step."""
    return energy(step(method, y, h)) - energy(y)


def power(defect: Callable[[Part, Vector, Number], Number], method: Part) -> int | None:
    """Return n where the defect of a step is of the order h^(n + 1), ``None`` where it vanishes."""
    with mp.workdps(DIGITS):
        y = [mp.mpf(x) for x in STATE]
        one, half = (abs(defect(method, y, h)) for h in (STEP, STEP / 2))
        if max(one, half) < SMALL**2 * 10**5:
            return None
        n = mp.log(one / half, 2)
        if half == 0 or abs(n - round(n)) > mp.mpf("0.01"):
            raise Undecided("no power of h")
        return round(n) - 1
