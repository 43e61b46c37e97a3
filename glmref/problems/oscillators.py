"""Small Hamiltonian problems: the harmonic oscillator, the pendulum, Hénon-Heiles.

References
----------
Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., Springer 2006 (HLW), chapter I.
Butcher, Habib, Hill, Norton, The control of parasitism in G-symplectic methods, SIAM J. Numer.
Anal. 52 (2014) 2440-2465, for the initial values of the pendulum and of Hénon-Heiles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .model import Problem
from .precision import Flow
from .ranges import number


def harmonic_oscillator(frequency: object = 1, q0: object = 1, p0: object = 0) -> Problem:
    """Oscillator q'' = -frequency**2 q, H = (p**2 + frequency**2 q**2) / 2."""
    omega = number(frequency, "frequency", above=0)
    parameters = {"frequency": omega, "q0": number(q0, "q0"), "p0": number(p0, "p0")}
    return Problem(
        name="harmonic-oscillator",
        source="HLW, section I.1",
        parameters=parameters,
        force=("-frequency*frequency*q[0]",),
        y0=("q0", "p0"),
        t_span=(0.0, 10.0 / float(omega)),
        hamiltonian="(y[1]*y[1] + frequency*frequency*y[0]*y[0])/2",
        quadratic={"energy": [[omega * omega / 2, 0], [0, 0.5]]},
        canonical=True,
        exact=Flow(_harmonic_flow, parameters),
        scales={"period": 6.283185307179586 / float(omega), "time": 1 / float(omega)},
    )


def _harmonic_flow(t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any) -> list[Any]:
    omega = parameters["frequency"]
    (q, p), c, s = y0, ctx.cos(omega * t), ctx.sin(omega * t)
    return [q * c + p * s / omega, p * c - q * omega * s]


def pendulum(q0: object = "5/2", p0: object = 0) -> Problem:
    """H = p**2/2 - cos q; at q0 = 5/2 parasitism shows, at 3/2 it does not for long."""
    parameters = {"q0": number(q0, "q0"), "p0": number(p0, "p0")}
    return Problem(
        name="pendulum",
        source="Butcher, Habib, Hill, Norton 2014; HLW, section I.1.3",
        parameters=parameters,
        force=("-sin(q[0])",),
        y0=("q0", "p0"),
        t_span=(0.0, 100.0),
        hamiltonian="y[1]*y[1]/2 - cos(y[0])",
        canonical=True,
        exact=Flow(_pendulum_flow, parameters),
        scales={"time": 1.0},
    )


def _pendulum_flow(t: Any, y0: Sequence[Any], _: Mapping[str, Any], ctx: Any) -> list[Any]:
    """Solve q'' = -sin q by Jacobi's elliptic functions, with m = (H + 1)/2.

    For m < 1 sin(q/2) = sqrt(m) sn(t + u, m); for m > 1 q/2 = am(sqrt(m) t + u, 1/m).
    """
    q, p = y0
    turns = ctx.floor((q + ctx.pi) / (2 * ctx.pi))
    q -= 2 * ctx.pi * turns
    m = p * p / 4 + ctx.sin(q / 2) ** 2
    k = ctx.sqrt(m)
    if m < 1:
        u = ctx.ellipf(ctx.atan2(ctx.sin(q / 2), p / 2), m) if m else ctx.mpf(0)
        end = [2 * ctx.asin(k * ctx.ellipfun("sn", t + u, m)), 2 * k * ctx.ellipfun("cn", t + u, m)]
    elif m == 1:
        # the separatrix: sin(q/2) = tanh(+-t + u)
        side = 1 if p > 0 else -1
        u = side * t + ctx.atanh(ctx.sin(q / 2)) if p else None
        end = [q, p] if u is None else [2 * ctx.asin(ctx.tanh(u)), side * 2 / ctx.cosh(u)]
    else:
        side = 1 if p > 0 else -1
        u = side * ctx.ellipf(q / 2, 1 / m) + k * t
        half_turns = ctx.floor(u / (2 * ctx.ellipk(1 / m)) + ctx.mpf(1) / 2)
        rest = u - 2 * half_turns * ctx.ellipk(1 / m)
        amplitude = ctx.asin(ctx.ellipfun("sn", rest, 1 / m)) + half_turns * ctx.pi
        end = [side * 2 * amplitude, side * 2 * k * ctx.ellipfun("dn", rest, 1 / m)]
    return [end[0] + 2 * ctx.pi * turns, end[1]]


def henon_heiles(
    cubic: object = "-1/3",
    q1: object = 0,
    q2: object = "3/10",
    p1: object = "9/25",
    p2: object = "11/50",
) -> Problem:
    """H = (p1**2 + p2**2 + q1**2 + q2**2)/2 + q1**2 q2 + cubic q2**3.

    The default ``cubic`` is Hénon and Heiles's, chaotic for some of the energies below 1/6; with
    ``cubic = 1/3`` the problem is integrable and a second invariant is given.
    """
    values = {"cubic": cubic, "q1": q1, "q2": q2, "p1": p1, "p2": p2}
    parameters = {key: number(value, key) for key, value in values.items()}
    integrable = abs(3 * parameters["cubic"] - 1) < 1e-15
    second = "y[2]*y[3] + y[0]*y[1] + y[0]*y[1]*y[1] + y[0]*y[0]*y[0]/3"
    return Problem(
        name="henon-heiles",
        source="HLW, section I.3; initial values of Butcher, Habib, Hill, Norton 2014",
        parameters=parameters,
        force=("-q[0] - 2*q[0]*q[1]", "-q[1] - q[0]*q[0] - 3*cubic*q[1]*q[1]"),
        y0=("q1", "q2", "p1", "p2"),
        t_span=(0.0, 100.0),
        hamiltonian="(y[0]*y[0] + y[1]*y[1] + y[2]*y[2] + y[3]*y[3])/2"
        " + y[0]*y[0]*y[1] + cubic*y[1]*y[1]*y[1]",
        invariants={"second": second} if integrable else {},
        canonical=True,
        scales={"time": 1.0},
    )
