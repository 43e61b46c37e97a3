"""Solutions in closed form of the problems of ``named.toml``, for :class:`.precision.Flow`.

Each takes the time since the start, the start, the parameters and an mpmath context.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..errors import UsageError


def harmonic(t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any) -> list[Any]:
    """Turn (q, p) by the frequency."""
    omega = parameters["frequency"]
    (q, p), c, s = y0, ctx.cos(omega * t), ctx.sin(omega * t)
    return [q * c + p * s / omega, p * c - q * omega * s]


def pendulum(t: Any, y0: Sequence[Any], _: Mapping[str, Any], ctx: Any) -> list[Any]:
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


def kepler(t: Any, y0: Sequence[Any], _: Mapping[str, Any], ctx: Any) -> list[Any]:
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


def sundman(s: Any, y0: Sequence[Any], _: Mapping[str, Any], ctx: Any) -> list[Any]:
    """Advance (q, t, p, w) by s: elliptic motion about a centre of strength 1 + K.

    Stumpff's functions for a constant w > 0; see Leimkuhler and Reich, section 9.2, for K = 0.
    """
    q, t, p, w = y0[:2], y0[2], y0[3:5], y0[5]
    r0 = ctx.hypot(*q)
    if not r0 or w <= 0:
        raise UsageError("the exact flow needs bodies apart and w > 0, that is, an ellipse")
    strength = r0 * ((p[0] * p[0] + p[1] * p[1]) / 2 + w)
    b, sigma = ctx.sqrt(2 * w), q[0] * p[0] + q[1] * p[1]
    g0, g1 = ctx.cos(b * s), ctx.sin(b * s) / b
    g2, g3 = (1 - g0) / (2 * w), (s - g1) / (2 * w)
    r = r0 * g0 + sigma * g1 + strength * g2
    f, g = 1 - strength * g2 / r0, r0 * g1 + sigma * g2
    df, dg = -strength * g1 / (r * r0), 1 - strength * g2 / r
    time = t + r0 * g1 + sigma * g2 + strength * g3
    pairs = list(zip(q, p, strict=True))
    moved = [f * x + g * v for x, v in pairs]
    return [*moved, time, *(df * x + dg * v for x, v in pairs), w]


def scaled_kepler(t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any) -> list[Any]:
    """Return :func:`kepler` in units of ``length``."""
    unit = parameters["length"]
    return [unit * x for x in kepler(t, [x / unit for x in y0], parameters, ctx)]


def prothero_robinson(
    t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any
) -> list[Any]:
    """Return the solution of y' = stiffness (cos t - y) - sin t."""
    return [ctx.cos(t) + ctx.exp(-parameters["stiffness"] * t) * (y0[0] - 1)]


def kaps(t: Any, y0: Sequence[Any], _: Mapping[str, Any], ctx: Any) -> list[Any]:
    """Return (exp(-2t), exp(-t)), the solution on the slow manifold.

    Raises
    ------
    UsageError
        From another start.
    """
    c = y0[1]
    # on the slow manifold y1 = y2**2 the solution is known, elsewhere it is not
    if y0[0] != c * c:
        raise UsageError(f"Kaps's problem is solved from y1 = y2**2 only, got {list(map(str, y0))}")
    return [c * c * ctx.exp(-2 * t), c * ctx.exp(-t)]


def isochronous(t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any) -> list[Any]:
    """Turn (z1, z2), of which y1 = z1 + a z2^2, y2 = z2 + b y1^2."""
    a, b = parameters["a"], parameters["b"]
    z2 = y0[1] - b * y0[0] * y0[0]
    z1 = y0[0] - a * z2 * z2
    c, s = ctx.cos(t), ctx.sin(t)
    z1, z2 = z1 * c + z2 * s, z2 * c - z1 * s
    first = z1 + a * z2 * z2
    return [first, z2 + b * first * first]


def blow_up(t: Any, y0: Sequence[Any], _: Mapping[str, Any], ctx: Any) -> list[Any]:
    """Return the solution y0/(1 - t y0) of y' = y**2."""
    return [y0[0] / (1 - t * y0[0])]


#: What a table calls them.
FLOWS: Mapping[str, Callable[..., list[Any]]] = {
    flow.__name__: flow
    for flow in (
        blow_up, harmonic, isochronous, kaps, kepler, pendulum, prothero_robinson, scaled_kepler,
        sundman,
    )
}  # fmt: skip
