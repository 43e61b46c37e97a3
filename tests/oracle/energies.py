"""Symplecticity and energy of one-step methods by definition: steps of one Hamiltonian system.

A step with h and one with h / 2 give the power of h of a defect: of J in the Jacobian of the step,
and of the change of H.
"""

from collections.abc import Callable

import numpy as np
from mpmath import mp

from .methods import Part
from .numbers import Array, Number, Undecided, array

#: H = sum of c x^k over monomials in (q1, q2, p1, p2), with no symmetry: c, k.
MONOMIALS = tuple((c, np.array(k, dtype=object)) for c, k in (
    (1, (0, 0, 2, 0)), (2, (0, 0, 0, 2)), (3, (2, 0, 0, 0)), (1, (0, 3, 0, 0)), (2, (1, 1, 1, 0)),
    (1, (2, 0, 0, 1)), (-1, (0, 1, 1, 1)), (1, (1, 0, 2, 1)), (2, (0, 2, 0, 2)), (-3, (1, 2, 1, 0)),
))  # fmt: skip
UNITS = np.eye(4, dtype=object)
STATE = ("0.7", "-0.4", "0.3", "0.9")
DIGITS, STEP, SMALL = 140, mp.mpf(10) ** -8, mp.mpf(10) ** -40


def energy(y: Array) -> Number:
    return sum(c * mp.fprod(y**k) for c, k in MONOMIALS)


def field(y: Array) -> Array:
    """Return J^-1 grad H."""
    H_q, I_q, H_p, I_p = (
        sum(c * k[i] * mp.fprod(y ** (k - e)) for c, k in MONOMIALS if k[i])
        for i, e in enumerate(UNITS)
    )
    return array([H_p, I_p, -H_q, -I_q])


def step(method: Part, y: Array, h: Number) -> Array:
    """Return the step of a Runge-Kutta method."""
    slopes = array([field(y)] * len(method.A))
    for _ in range(20):
        before, slopes = slopes, array([field(x) for x in y + method.A @ slopes * h])
        if (slopes == before).all():
            break
    return y + (method.B @ slopes)[0] * h


def symplectic_defect(method: Part, y: Array, h: Number) -> Number:
    """Return entry (q1, p2) of M^T J M - J, M the Jacobian of a step by central differences."""
    ends = [[step(method, y + x * e, h) for e in (SMALL, -SMALL)] for x in UNITS[[0, 3]]]
    u, v = ((a - b) / (2 * SMALL) for a, b in ends)
    return u[:2] @ v[2:] - u[2:] @ v[:2]


def energy_defect(method: Part, y: Array, h: Number) -> Number:
    """Return the change of H in a step."""
    return energy(step(method, y, h)) - energy(y)


def power(defect: Callable[[Part, Array, Number], Number], method: Part) -> int | None:
    """Return n where the defect of a step is of the order h^(n + 1), ``None`` where it vanishes."""
    with mp.workdps(DIGITS):
        y = array([mp.mpf(x) for x in STATE])
        one, half = (abs(defect(method, y, h)) for h in (STEP, STEP / 2))
        if max(one, half) < SMALL**2 * 10**5:
            return None
        n = mp.log(one / half, 2)
        if abs(n - round(n)) > mp.mpf("0.01"):
            raise Undecided("no power of h")
        return round(n) - 1
