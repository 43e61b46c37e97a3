"""Small problems whose components or invariants depend on their parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

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
