"""Stiff problems with exact solutions or published reference values.

References
----------
HW: Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996.
Test set: Mazzia, Magherini, Test Set for Initial Value Problem Solvers, release 2.4, Bari 2008.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from ..errors import UsageError
from .formula import Formula
from .model import Problem
from .precision import Flow
from .ranges import number


def dahlquist(real: object = -1, imaginary: object = 0) -> Problem:
    """The test equation y' = lambda y; two real components where lambda is not real."""
    parameters = {"real": number(real, "real"), "imaginary": number(imaginary, "imaginary")}
    a, b = (float(x) for x in parameters.values())
    size = max(abs(a), abs(b))
    circular = a == 0 and b != 0
    return Problem(
        name="dahlquist",
        source="Dahlquist, BIT 3 (1963) 27-43",
        parameters=parameters,
        f=("real*y[0] - imaginary*y[1]", "imaginary*y[0] + real*y[1]") if b else ("real*y[0]",),
        y0=(1, 0) if b else (1,),
        t_span=(0.0, 10 / size if size else 10.0),
        quadratic={"modulus": [[1, 0], [0, 1]]} if circular else {},
        exact=Flow(_dahlquist_flow, parameters),
        scales={"time": 1 / size} if size else {},
    )


def _dahlquist_flow(
    t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any
) -> list[Any]:
    growth, angle = ctx.exp(parameters["real"] * t), parameters["imaginary"] * t
    if len(y0) == 1:
        return [growth * y0[0]]
    c, s = ctx.cos(angle), ctx.sin(angle)
    return [growth * (c * y0[0] - s * y0[1]), growth * (s * y0[0] + c * y0[1])]


def prothero_robinson(stiffness: object = 10**6) -> Problem:
    """Order reduction: y' = stiffness (cos t - y) - sin t has the solution y = cos t.

    Methods lose order down to their stage order here as the stiffness grows.
    """
    parameters = {"stiffness": number(stiffness, "stiffness", least=0)}
    return Problem(
        name="prothero-robinson",
        source="Prothero, Robinson, Math. Comp. 28 (1974) 145-162; HW, section IV.15, (15.1)",
        parameters=parameters,
        f=("stiffness*(cos(t) - y[0]) - sin(t)",),
        y0=(1,),
        t_span=(0.0, 10.0),
        exact=Flow(_prothero_robinson_flow, parameters),
        scales={"time": 1.0},
    )


def _prothero_robinson_flow(
    t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any
) -> list[Any]:
    return [ctx.cos(t) + ctx.exp(-parameters["stiffness"] * t) * (y0[0] - 1)]


def kaps(epsilon: object = "1/100000000") -> Problem:
    """Kaps's problem: y1 = exp(-2t), y2 = exp(-t) for every epsilon, from (1, 1)."""
    parameters = {"epsilon": number(epsilon, "epsilon", above=0)}
    return Problem(
        name="kaps",
        source="Dekker, Verwer, Stability of Runge-Kutta Methods for Stiff Equations, 1984, p. 256",
        parameters=parameters,
        f=("(y[1]*y[1] - y[0])/epsilon - 2*y[0]", "y[0] - y[1] - y[1]*y[1]"),
        y0=(1, 1),
        t_span=(0.0, 1.0),
        exact=Flow(_kaps_flow, parameters),
        scales={"time": 1.0},
    )


def _kaps_flow(t: Any, y0: Sequence[Any], _: Mapping[str, Any], ctx: Any) -> list[Any]:
    c = y0[1]
    # on the slow manifold y1 = y2**2 the solution is known, elsewhere it is not
    if y0[0] != c * c:
        raise UsageError(f"Kaps's problem is solved from y1 = y2**2 only, got {list(map(str, y0))}")
    return [c * c * ctx.exp(-2 * t), c * ctx.exp(-t)]


def stiff_spring_pendulum(stiffness: object = 10**4, stretch: object = "1/100") -> Problem:
    """A unit mass on a stiff spring of length one, g = 1, in Cartesian coordinates.

    H = (p1**2 + p2**2)/2 + stiffness (r - 1)**2/2 + q2, released at the height of the pivot with
    the spring stretched: the solution oscillates fast, and no damping helps.
    """
    values = {"stiffness": number(stiffness, "stiffness", above=0)}
    parameters = {**values, "stretch": number(stretch, "stretch", above=-1)}
    return Problem(
        name="stiff-spring-pendulum",
        source="HLW, section XIV.3, after Rubin, Ungar, Comm. Pure Appl. Math. 10 (1957) 65-87",
        parameters=parameters,
        force=Formula(
            common=(("r", "sqrt(q[0]*q[0] + q[1]*q[1])"), ("w", "stiffness*(1/r - 1)")),
            outputs=("w*q[0]", "w*q[1] - 1"),
            variables=("q",),
            parameters=parameters,
        ),
        y0=("1 + stretch", 0, 0, 0),
        t_span=(0.0, 10.0),
        hamiltonian="(y[2]*y[2] + y[3]*y[3])/2 + y[1]"
        " + stiffness*(sqrt(y[0]*y[0] + y[1]*y[1]) - 1)**2/2",
        canonical=True,
        scales={"time": float(Fraction(values["stiffness"])) ** -0.5},
    )
