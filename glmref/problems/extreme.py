"""Problems at the edge: no field, huge or tiny states, near collisions, faulty functions.

Each has a known right outcome; many of them are an honest failure with a name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from random import Random
from typing import Any

import numpy as np

from .chains import fput_energy, fput_force_into
from .loops import Loops
from .model import Problem
from .precision import Flow
from .ranges import count


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
