"""Problems at the edge: no field, huge or tiny states, near collisions, faulty functions.

Each has a known right outcome; many of them are an honest failure with a name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from random import Random
from typing import Any

import numpy as np

from .chains import fput_energy, fput_force_into
from .formula import Formula
from .kepler import kepler_flow
from .loops import Loops
from .model import Problem
from .nbody import gravity
from .precision import Flow
from .ranges import count, number

# name of an extreme case -> the problem and the parameters that make it one
PRESETS: Mapping[str, tuple[str, Mapping[str, object]]] = {
    "eccentric 0.9": ("kepler", {"eccentricity": "9/10"}),
    "eccentric 0.99": ("kepler", {"eccentricity": "99/100"}),
    "eccentric 0.999": ("kepler", {"eccentricity": "999/1000"}),
    "near collision": ("pythagorean", {}),
    "tiny oscillator": ("harmonic-oscillator", {"q0": "1e-150"}),
    "huge oscillator": ("harmonic-oscillator", {"q0": "1e150"}),
    "denormal oscillator": ("harmonic-oscillator", {"q0": "1e-310"}),
    "tiny orbit": ("scaled-kepler", {"length": "1e-150"}),
    "huge orbit": ("scaled-kepler", {"length": "1e150"}),
    "orbit that underflows": ("scaled-kepler", {"length": "1e-170"}),
    "one component": ("dahlquist", {}),
    "many components": ("long-chain", {}),
    "no field": ("zero-field", {}),
    "linear field": ("linear-field", {}),
    "chaos": ("henon-heiles", {}),
    "inverted pendulum": ("pendulum", {"q0": "3.1415926535", "p0": 0}),
}


def zero_field(dimension: object = 3) -> Problem:
    """Field y' = 0: a step must return V^n y exactly, and nothing needs to be evaluated."""
    d = count(dimension, "dimension", most=1000)
    return Problem(
        name="zero-field",
        source="definition",
        parameters={"dimension": d},
        f=("0",) * d,
        y0=[i + 1 for i in range(d)],
        t_span=(0.0, 1.0),
        exact=Flow(lambda t, y0, parameters, ctx: list(y0), {}),
        scales={"time": 1.0},
    )


def linear_field(dimension: object = 4, seed: object = 1) -> Problem:
    """Field y' = A y with a random matrix of small binary fractions; exact by exp(tA)."""
    d = count(dimension, "dimension", most=40)
    start = count(seed, "seed", least=0)
    a = _random_matrix(d, start)
    rows = [" + ".join(f"({x}/16)*y[{j}]" for j, x in enumerate(row)) for row in a]
    parameters = {"dimension": d, "seed": start}
    return Problem(
        name="linear-field",
        source="coefficients from Python's Random(seed)",
        parameters=parameters,
        f=tuple(rows),
        y0=[1] + [0] * (d - 1),
        t_span=(0.0, 5.0),
        exact=Flow(_linear_flow, parameters),
        scales={"time": 1.0},
    )


def _random_matrix(d: int, seed: int) -> list[list[int]]:
    """Sixteen times A: entries -16 ... 16."""
    random = Random(seed)
    return [[random.randrange(-16, 17) for _ in range(d)] for _ in range(d)]


def _linear_flow(t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any) -> list[Any]:
    a = _random_matrix(int(parameters["dimension"]), int(parameters["seed"]))
    return list(ctx.expm(ctx.matrix(a) * (t / 16)) * ctx.matrix(list(y0)))


def long_chain(sites: object = 50_000, mode: object = 10_000) -> Problem:
    """Equal masses and linear springs between walls, in one normal mode: 100,000 components.

    The closed form holds for that mode; rounding y0 adds others, of relative size 1e-16, which it
    leaves out. No Jacobian is given: as a dense matrix it would take 80 GB.
    """
    n = count(sites, "sites", least=1, most=10**7)
    k = count(mode, "mode", least=1, most=n)

    def start(of: Any) -> list[Any]:
        return [of.sin(of.pi * (k * (i + 1) % (2 * n + 2)) / (n + 1)) for i in range(n)] + [0] * n

    parameters = {"sites": n, "mode": k}
    return Problem(
        name="long-chain",
        source="normal modes of a chain; see the linear part of fput",
        parameters=parameters,
        force=Loops(fput_force_into, (n,), (0, 0)),
        y0=start,
        t_span=(0.0, 10.0),
        hamiltonian=Loops(fput_energy, (), (0, 0)),
        canonical=True,
        exact=Flow(_mode_flow, parameters),
        scales={"time": 1.0},
    )


def _mode_flow(t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any) -> list[Any]:
    omega = 2 * ctx.sin(ctx.pi * parameters["mode"] / (2 * parameters["sites"] + 2))
    c, s, half = ctx.cos(omega * t), ctx.sin(omega * t), len(y0) // 2
    pairs = list(zip(y0[:half], y0[half:], strict=True))
    return [q * c + p * s / omega for q, p in pairs] + [p * c - q * s * omega for q, p in pairs]


def pythagorean() -> Problem:
    """Masses 3, 4, 5 at rest in the corners of a right triangle: close encounters, then escape."""
    return gravity(
        (3, 4, 5),
        ((1, 3), (-2, -1), (1, -1)),
        ((0, 0), (0, 0), (0, 0)),
        name="pythagorean",
        source="Burrau 1913; Szebehely, Peters, Astron. J. 72 (1967) 876-883",
        t_span=(0.0, 10.0),
        scales={"time": 1e-3},
    )


def scaled_kepler(length: object = "1e-150", eccentricity: object = "3/5") -> Problem:
    """Kepler's problem with lengths and velocities times ``length``, the period still 2 pi.

    Written so that only the square of the distance can leave the range of double precision: that
    happens below 1e-162 and above 1e154.
    """
    parameters = {
        "length": number(length, "length", above=0),
        "eccentricity": number(eccentricity, "eccentricity", least=0, below=1),
    }
    return Problem(
        name="scaled-kepler",
        source="HLW, section I.2.2, in other units",
        parameters=parameters,
        force=Formula(
            common=(("s", "length/sqrt(q[0]*q[0] + q[1]*q[1])"), ("w", "-s*s*s")),
            outputs=("w*q[0]", "w*q[1]"),
            variables=("q",),
            parameters=parameters,
        ),
        y0=(
            "length*(1 - eccentricity)",
            0,
            0,
            "length*sqrt((1 + eccentricity)/(1 - eccentricity))",
        ),
        t_span=(0.0, 62.83185307179586),
        hamiltonian="((y[2]/length)**2 + (y[3]/length)**2)/2 - length/sqrt(y[0]*y[0] + y[1]*y[1])",
        exact=Flow(_scaled_kepler_flow, parameters),
        scales={"period": 6.283185307179586, "length": float(parameters["length"])},
    )


def _scaled_kepler_flow(
    t: Any, y0: Sequence[Any], parameters: Mapping[str, Any], ctx: Any
) -> list[Any]:
    unit = parameters["length"]
    return [unit * x for x in kepler_flow(t, [x / unit for x in y0], parameters, ctx)]


def blow_up() -> Problem:
    """Field y' = y**2 from 1: the solution 1/(1 - t) ends at t = 1."""
    return Problem(
        name="blow-up",
        source="definition",
        f=("y[0]*y[0]",),
        y0=(1,),
        t_span=(0.0, 2.0),
        exact=Flow(lambda t, y0, parameters, ctx: [y0[0] / (1 - t * y0[0])], {}),
        scales={"time": 1.0},
    )


def fault_nan() -> Problem:
    """Right-hand side that is NaN after t = 1."""
    return Problem(name="fault-nan", source="planted", f=("sqrt(1 - t) - y[0]",), y0=(1,))


def fault_infinity() -> Problem:
    """Right-hand side that overflows after t = 7.1."""
    return Problem(name="fault-infinity", source="planted", f=("exp(100*t) - y[0]",), y0=(1,))


def fault_raises() -> Problem:
    """Plain Python right-hand side that raises after t = 1."""

    def f(t: float, y: np.ndarray) -> np.ndarray:
        if t > 1:
            raise RuntimeError("the model does not hold after t = 1")
        return -y

    return Problem(name="fault-raises", source="planted", f=f, y0=(1, 2))


def fault_shape() -> Problem:
    """Plain Python right-hand side that returns one component too many."""

    def f(t: float, y: np.ndarray) -> np.ndarray:
        return np.append(-y, 0.0)

    return Problem(name="fault-shape", source="planted", f=f, y0=(1, 2))


def fault_jacobian() -> Problem:
    """Stiff decay with a Jacobian of the wrong sign: Newton's method must notice."""
    return _stiff_decay("fault-jacobian", 1e6)


def fault_jacobian_nan() -> Problem:
    """Stiff decay with a Jacobian that is not a number."""
    return _stiff_decay("fault-jacobian-nan", np.nan)


def _stiff_decay(name: str, entry: float) -> Problem:
    def jacobian(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([[entry]])

    f = ("-1000000*(y[0] - cos(t))",)
    return Problem(name=name, source="planted", f=f, y0=(1,), jacobian=jacobian)
