"""The Kepler problem, for any eccentricity below one, with its exact flow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..errors import UsageError
from .formula import Formula
from .loops import QuadraticForm
from .model import Problem
from .precision import Flow
from .ranges import number


def kepler(eccentricity: object = "3/5") -> Problem:
    """Two bodies, unit semi-major axis and period 2 pi, started at the pericentre.

    H = (p1**2 + p2**2)/2 - 1/sqrt(q1**2 + q2**2), with HLW's initial value
    (1 - e, 0, 0, sqrt((1 + e)/(1 - e))).
    """
    e = number(eccentricity, "eccentricity", least=0, below=1)
    parameters = {"eccentricity": e}
    force = Formula(
        common=(("r2", "q[0]*q[0] + q[1]*q[1]"), ("w", "-1/(r2*sqrt(r2))")),
        outputs=("w*q[0]", "w*q[1]"),
        variables=("q",),
    )
    axis = "({0}*(y[0]*y[3] - y[1]*y[2]) - y[{1}]/sqrt(y[0]*y[0] + y[1]*y[1]))"
    return Problem(
        name="kepler",
        source="HLW, section I.2.2, equations (2.2) and (2.11)",
        parameters=parameters,
        force=force,
        y0=("1 - eccentricity", 0, 0, "sqrt((1 + eccentricity)/(1 - eccentricity))"),
        t_span=(0.0, 62.83185307179586),
        hamiltonian="(y[2]*y[2] + y[3]*y[3])/2 - 1/sqrt(y[0]*y[0] + y[1]*y[1])",
        quadratic={"angular momentum": QuadraticForm({(0, 3): 1, (1, 2): -1}, 4)},
        invariants={
            "Laplace-Runge-Lenz x": axis.format("y[3]", 0),
            "Laplace-Runge-Lenz y": axis.format("-y[2]", 1),
        },
        canonical=True,
        exact=Flow(kepler_flow, parameters),
        scales={"period": 6.283185307179586, "time": float((1 - e) ** 1.5), "length": float(1 - e)},
    )


def kepler_flow(t: Any, y0: Sequence[Any], _: Mapping[str, Any], ctx: Any) -> list[Any]:
    """Advance any elliptic start (q, p) by time t through Kepler's equation.

    The functions f and g of the start and their derivatives, with the change of the eccentric
    anomaly: no special case for circles, pericentres or straight lines.

    Raises
    ------
    UsageError
        When the start does not lie on an ellipse.
    """
    q, p = y0[:2], y0[2:]
    r0 = ctx.hypot(*q)
    if not r0:
        raise UsageError("the exact Kepler flow needs bodies apart, got q = 0")
    inverse = 2 / r0 - (p[0] * p[0] + p[1] * p[1])
    if inverse <= 0:
        raise UsageError("the exact Kepler flow needs negative energy, that is, an ellipse")
    a = 1 / inverse
    e_sin, e_cos = (q[0] * p[0] + q[1] * p[1]) / ctx.sqrt(a), 1 - r0 / a
    e, start = ctx.hypot(e_sin, e_cos), ctx.atan2(e_sin, e_cos)
    end = eccentric_anomaly(start - e_sin + t / (a * ctx.sqrt(a)), e, ctx)
    r, c, s = a * (1 - e * ctx.cos(end)), ctx.cos(end - start), ctx.sin(end - start)
    f = 1 - a / r0 * (1 - c)
    g = ctx.sqrt(a) * (r0 * s + a * e_sin * (1 - c))
    df = -ctx.sqrt(a) * s / (r * r0)
    dg = 1 - a / r * (1 - c)
    return [f * x + g * v for x, v in zip(q, p, strict=True)] + [
        df * x + dg * v for x, v in zip(q, p, strict=True)
    ]


def eccentric_anomaly(mean: Any, e: Any, ctx: Any) -> Any:
    """Solve Kepler's equation E - e sin E = mean (mod 2 pi), 0 <= e <= 1, to the last digit.

    The left side increases, and |E - mean| <= e, so Newton's method inside a bracket that only
    shrinks cannot fail, whatever the eccentricity.
    """
    turn = 2 * ctx.pi
    mean -= turn * ctx.floor(mean / turn + ctx.mpf(1) / 2)
    low, high = mean - e, mean + e
    anomaly = mean + e * ctx.sin(mean)
    while True:
        residual = anomaly - e * ctx.sin(anomaly) - mean
        # the residual itself is rounded to about 2 eps |E|
        if abs(residual) <= 4 * ctx.eps * abs(anomaly):
            return anomaly
        if residual > 0:
            high = anomaly
        else:
            low = anomaly
        slope = 1 - e * ctx.cos(anomaly)
        improved = anomaly - residual / slope if slope > 0 else low
        anomaly = improved if low < improved < high else (low + high) / 2
