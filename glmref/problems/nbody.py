"""Gravitating bodies, any N of them, and the orbits of Arenstorf.

States are y = (positions, velocities), body by body: x1, y1, z1, x2, ... Newton's equations are of
second order, and y is not canonical unless all masses are one; energy and angular momentum are
conserved all the same.

References
----------
HNW: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import sqrt
from random import Random
from typing import Any

from ..errors import UsageError
from .formula import Formula, Number, exact_number
from .loops import Loops, QuadraticForm
from .model import Problem
from .ranges import count, number


def gravity_2_into(q, params, out):  # type: ignore[no-untyped-def]
    """Accelerations of bodies in the plane; params = (G, m_1, ..., m_N)."""
    bodies = len(params) - 1
    for i in range(2 * bodies):
        out[i] = 0 * q[i]
    for i in range(bodies):
        for j in range(i):
            dx = q[2 * i] - q[2 * j]
            dy = q[2 * i + 1] - q[2 * j + 1]
            r2 = dx * dx + dy * dy
            w = params[0] / (r2 * sqrt(r2))
            wi = w * params[1 + i]
            wj = w * params[1 + j]
            out[2 * i] -= wj * dx
            out[2 * i + 1] -= wj * dy
            out[2 * j] += wi * dx
            out[2 * j + 1] += wi * dy


def gravity_3_into(q, params, out):  # type: ignore[no-untyped-def]
    """Accelerations of bodies in space; params = (G, m_1, ..., m_N)."""
    bodies = len(params) - 1
    for i in range(3 * bodies):
        out[i] = 0 * q[i]
    for i in range(bodies):
        for j in range(i):
            dx = q[3 * i] - q[3 * j]
            dy = q[3 * i + 1] - q[3 * j + 1]
            dz = q[3 * i + 2] - q[3 * j + 2]
            r2 = dx * dx + dy * dy + dz * dz
            w = params[0] / (r2 * sqrt(r2))
            wi = w * params[1 + i]
            wj = w * params[1 + j]
            out[3 * i] -= wj * dx
            out[3 * i + 1] -= wj * dy
            out[3 * i + 2] -= wj * dz
            out[3 * j] += wi * dx
            out[3 * j + 1] += wi * dy
            out[3 * j + 2] += wi * dz


def gravity_energy(y, params):  # type: ignore[no-untyped-def]
    """Kinetic plus potential energy of bodies in the plane or in space."""
    bodies = len(params) - 1
    half = len(y) // 2
    space = half // bodies
    total = 0 * y[0]
    for i in range(bodies):
        v2 = 0 * y[0]
        for k in range(space):
            v2 += y[half + space * i + k] * y[half + space * i + k]
        total += params[1 + i] * v2 / 2
        for j in range(i):
            r2 = 0 * y[0]
            for k in range(space):
                d = y[space * i + k] - y[space * j + k]
                r2 += d * d
            total -= params[0] * params[1 + i] * params[1 + j] / sqrt(r2)
    return total


def _angular_momentum(masses: Sequence[Number], space: int) -> dict[str, QuadraticForm]:
    """Components of sum m q x v, as quadratic forms in y."""
    planes = {"z": (0, 1)} if space == 2 else {"x": (1, 2), "y": (2, 0), "z": (0, 1)}
    half = space * len(masses)
    forms = {}
    for axis, (a, b) in planes.items():
        terms: dict[tuple[int, int], Number] = {}
        for i, m in enumerate(masses):
            terms[space * i + a, half + space * i + b] = m
            terms[space * i + b, half + space * i + a] = -m
        forms[f"angular momentum {axis}"] = QuadraticForm(terms, 2 * half)
    return forms


def _momentum(masses: Sequence[Number], space: int) -> dict[str, Formula]:
    """Components of sum m v."""
    half = space * len(masses)
    names = {f"m{i}": m for i, m in enumerate(masses)}
    return {
        f"momentum {'xyz'[k]}": Formula(
            (" + ".join(f"m{i}*y[{half + space * i + k}]" for i in range(len(masses))),),
            variables=("y",),
            parameters=names,
            shape=(),
        )
        for k in range(space)
    }


def gravity(
    masses: Sequence[object],
    positions: Sequence[Any],
    velocities: Sequence[Any],
    *,
    gravitation: object = 1,
    **record: Any,
) -> Problem:
    """Bodies under mutual gravitation, in the plane or in space.

    Positions and velocities are N rows of 2 or 3 entries, numbers or strings such as "3/5";
    ``record`` are further entries of the :class:`.model.Problem`.

    Raises
    ------
    UsageError
        When the numbers of bodies or of coordinates differ.
    """
    m = [exact_number(x, "masses") for x in masses]
    space = len(positions[0]) if positions else 0
    rows = [*positions, *velocities]
    if not 2 <= space <= 3 or len(rows) != 2 * len(m) or any(len(row) != space for row in rows):
        raise UsageError(f"{len(m)} masses need as many positions and velocities of 2 or 3 entries")
    constants = (exact_number(gravitation, "gravitation"), *m)
    force = gravity_2_into if space == 2 else gravity_3_into
    return Problem(
        y0=[exact_number(x, "y0") for row in rows for x in row],
        force=Loops(force, (space * len(m),), constants),
        hamiltonian=Loops(gravity_energy, (), constants),
        quadratic=_angular_momentum(m, space),
        invariants=_momentum(m, space),
        canonical=all(x == 1 for x in m),
        bodies=len(m),
        **record,
    )


def n_body(bodies: object = 5, seed: object = 1) -> Problem:
    """Random bodies in space with total mass one, at rest as a whole; decimals from the seed."""
    n, start = count(bodies, "bodies", least=2, most=2000), count(seed, "seed", least=0)
    random = Random(start)

    def triples(scale: int) -> list[list[Fraction]]:
        def entry() -> Fraction:
            return Fraction(random.randrange(-1000, 1001), scale)

        rows = [[entry(), entry(), entry()] for _ in range(n)]
        means = [sum(column, Fraction(0)) / n for column in zip(*rows, strict=True)]
        return [[x - mean for x, mean in zip(row, means, strict=True)] for row in rows]

    return gravity(
        [Fraction(1, n)] * n,
        triples(1000),
        triples(2000),
        name="n-body",
        source="positions in the unit cube, velocities half as large, from Python's Random(seed)",
        parameters={"bodies": n, "seed": start},
        t_span=(0.0, 1.0),
        scales={"time": 1.0},
    )


_ARENSTORF = {
    # orbit: (y'_2(0), period), with y_1(0) = 0.994
    1: ("-2.00158510637908252240537862224", "17.0652165601579625588917206249"),
    2: ("-2.0317326295573368357302057924", "11.124340337266085134999734047"),
}


def arenstorf(orbit: object = 1) -> Problem:
    """Restricted three-body problem, a periodic orbit of a satellite of earth and moon."""
    which = count(orbit, "orbit", least=1, most=2)
    speed, period = _ARENSTORF[which]
    mu = Fraction("0.012277471")
    f = Formula(
        common=(
            ("a", "y[0] + mu"),
            ("b", "y[0] - (1 - mu)"),
            ("r2", "a*a + y[1]*y[1]"),
            ("s2", "b*b + y[1]*y[1]"),
            ("v", "(1 - mu)/(r2*sqrt(r2))"),
            ("w", "mu/(s2*sqrt(s2))"),
        ),
        outputs=("y[2]", "y[3]", "y[0] + 2*y[3] - v*a - w*b", "y[1] - 2*y[2] - v*y[1] - w*y[1]"),
        parameters={"mu": mu},
    )
    jacobi = (
        "(y[2]*y[2] + y[3]*y[3] - y[0]*y[0] - y[1]*y[1])/2"
        " - (1 - mu)/sqrt((y[0] + mu)**2 + y[1]**2) - mu/sqrt((y[0] - 1 + mu)**2 + y[1]**2)"
    )
    return Problem(
        name="arenstorf",
        source="HNW, section II.0, equations (0.1) and (0.2)",
        parameters={"orbit": which},
        f=f,
        y0=("0.994", 0, 0, Fraction(number(speed, "speed"))),
        t_span=(0.0, float(Fraction(period))),
        invariants={
            "Jacobi": Formula((jacobi,), variables=("y",), parameters={"mu": mu}, shape=())
        },
        scales={"period": float(Fraction(period)), "time": 0.01},
    )
