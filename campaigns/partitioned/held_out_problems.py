"""Forty separable problems on which no method of this project was trained.

Hamiltonians as text, with initial values: orbits and galaxies, wells, molecules, chains, lattices
and bodies up to 64, thirty-one with T = p^T p / 2 or with masses and nine with another T. They were
chosen before any of them was run. Kepler's problem is here with other eccentricities than those
of training, Hénon-Heiles with other energies, and a Toda chain that is closed to a ring.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from glmref.problems import problem
from glmref.problems.model import Problem
from glmref.problems.table import from_table


@dataclass(frozen=True)
class Held:
    """A problem and how far it is solved.

    Attributes
    ----------
    H : str
        The Hamiltonian; empty for Kepler's problem.
    y0 : Mapping[str, Any]
        Initial value, or the parameters of Kepler's problem.
    t_end, longer : float
        The short and the long horizon.
    least : int
        Evaluations at which the grid of the short horizon begins.
    quadratic : bool
        Whether T is quadratic.
    most : int
        No run takes more evaluations.
    parameters : Mapping[str, Any]
        Of H.
    """

    H: str
    y0: Mapping[str, Any]
    t_end: float
    longer: float
    least: int
    quadratic: bool = True
    most: int = 1_000_000
    parameters: Mapping[str, Any] | None = None


def _spread(n: int, size: float, shift: int = 0) -> list[float]:
    """Numbers without order, always the same."""
    return [size * math.sin(1 + 2.3 * (k + shift) ** 2) for k in range(n)]


def _balanced(n: int, size: float) -> list[float]:
    """The same with sum zero."""
    found = _spread(n, size)
    return [x - math.fsum(found) / n for x in found]


def _kepler(e: str, t_end: float, least: int) -> Held:
    return Held("", {"eccentricity": e}, t_end, 30 * t_end, least)


def _flat(rows: Sequence[Sequence[float]]) -> list[float]:
    return [x for row in rows for x in row]


_TURN = 2 * math.pi
_P2 = "(px**2 + py**2)/2"
_P3 = "(px**2 + py**2 + pz**2)/2"
_T = "sum(p[i]**2/2 for i in range(n))"


def _plane(qx: float, qy: float, px: float, py: float) -> dict[str, float]:
    return {"qx": qx, "qy": qy, "px": px, "py": py}


def _space(q: Sequence[float], p: Sequence[float]) -> dict[str, float]:
    return {
        f"{a}{x}": v for a, row in (("q", q), ("p", p)) for x, v in zip("xyz", row, strict=True)
    }


def _planets() -> Held:
    """Sun, Jupiter, Saturn, Uranus in a plane; astronomical units, years, solar masses."""
    m, a, at = [1.0, 9.54e-4, 2.86e-4, 4.4e-5], [0.0, 5.2, 9.54, 19.2], [0.0, 0.0, 2.0, 4.0]
    q = [[r * math.cos(x), r * math.sin(x)] for r, x in zip(a, at, strict=True)]
    v = [1.04 * _TURN / math.sqrt(r) if r else 0.0 for r in a]
    p = [[-k * s * math.sin(x), k * s * math.cos(x)] for k, s, x in zip(m, v, at, strict=True)]
    p[0] = [-math.fsum(x[i] for x in p) for i in (0, 1)]
    return _masses(m, q, p, 4 * math.pi**2, 120.0, 2400.0, 150)


def _triple() -> Held:
    """Two stars around each other and a third one around both, slightly eccentric."""
    m = [0.6, 0.4, 0.3]
    q = [[0.4, 0.0], [-0.6, 0.0], [0.0, 8.0]]
    v = [[0.0, 0.42], [0.0, -0.63], [-0.42, 0.0]]
    p = [[k * x for x in row] for k, row in zip(m, v, strict=True)]
    total = [math.fsum(x[i] for x in p) / math.fsum(m) for i in (0, 1)]
    p = [[x - k * c for x, c in zip(row, total, strict=True)] for k, row in zip(m, p, strict=True)]
    return _masses(m, q, p, 1.0, 60.0, 1800.0, 200)


def _masses(
    m: Sequence[float], q: Sequence[Sequence[float]], p: Sequence[Sequence[float]], g: float,
    t_end: float, longer: float, least: int,
) -> Held:  # fmt: skip
    H = (
        f"sum((p[2*i]**2 + p[2*i+1]**2)/(2*m[i]) for i in range({len(m)}))"
        f" - g*sum(m[i]*m[j]/sqrt((q[2*i] - q[2*j])**2 + (q[2*i+1] - q[2*j+1])**2)"
        f" for i in range({len(m)}) for j in range(i))"
    )
    y0 = {"q": _flat(q), "p": _flat(p)}
    return Held(H, y0, t_end, longer, least, parameters={"m": list(m), "g": g})


def _hexagon() -> list[float]:
    """Seven atoms at the distance of the least energy of two."""
    r = 2 ** (1 / 6)
    around = [[r * math.cos(k * _TURN / 6), r * math.sin(k * _TURN / 6)] for k in range(6)]
    return _flat([[0.0, 0.0], *around])


def _ring(n: int = 64) -> Held:
    """Bodies of mass 1/n on a ring around one of mass 1, softened, slightly displaced."""
    H = (
        f"{_T} - sum(1/sqrt(q[2*i]**2 + q[2*i+1]**2 + 0.01) for i in range({n}))"
        f" - sum(1/sqrt((q[2*i] - q[2*j])**2 + (q[2*i+1] - q[2*j+1])**2 + 0.01)"
        f" for i in range({n}) for j in range(i))/{20 * n}"
    )
    at = [k * _TURN / n + x for k, x in enumerate(_spread(n, 0.02))]
    q = [[math.cos(x), math.sin(x)] for x in at]
    p = [[-1.02 * math.sin(x), 1.02 * math.cos(x)] for x in at]
    return Held(H, {"q": _flat(q), "p": _flat(p)}, 6.0, 60.0, 60, most=20_000)


def _cluster(n: int = 16) -> Held:
    """Softened bodies in space."""
    H = (
        f"{_T} - sum(1/sqrt((q[3*i] - q[3*j])**2 + (q[3*i+1] - q[3*j+1])**2"
        f" + (q[3*i+2] - q[3*j+2])**2 + 0.05) for i in range({n}) for j in range(i))/{n}"
    )
    y0 = {"q": _spread(3 * n, 1.0), "p": _spread(3 * n, 0.4, 100)}
    return Held(H, y0, 4.0, 60.0, 60, most=60_000)


def _chain(V: str, n: int, q: float, p: float, t: float, longer: float, least: int) -> Held:
    y0 = {"q": _balanced(n, q), "p": _balanced(n, p)}
    return Held(f"{_T} + {V}", y0, t, longer, least, most=200_000)


_RING = "(q[(i+1) % n] - q[i])"
_ENDS = "q[0]**2/2 + q[0]**4/4 + q[n-1]**2/2 + q[n-1]**4/4"
_R = "sqrt(qx**2 + qy**2)"
_R3 = "sqrt(qx**2 + qy**2 + qz**2)"
_HH = "(qx**2 + qy**2)/2 + qx**2*qy - qy**3/3"
_LATTICE = (
    "sum((q[i - i%6 + (i+1)%6] - q[i])**2/2 + (q[i - i%6 + (i+1)%6] - q[i])**4/4"
    " + (q[(i+6) % n] - q[i])**2/2 + (q[(i+6) % n] - q[i])**4/4 + q[i]**2/4 for i in range(n))"
)
_LJ = "((q[2*i] - q[2*j])**2 + (q[2*i+1] - q[2*j+1])**2)"

PROBLEMS: Mapping[str, Held] = {
    # orbits
    "kepler 0.1": _kepler("1/10", 10 * _TURN, 300),
    "kepler 0.3": _kepler("3/10", 10 * _TURN, 400),
    "kepler 0.5": _kepler("1/2", 10 * _TURN, 700),
    "kepler 0.7": _kepler("7/10", 10 * _TURN, 1500),
    "kepler 0.9": _kepler("9/10", 10 * _TURN, 8000),
    "oblate planet": Held(
        f"{_P3} - 1/{_R3} + 0.005*(3*qz**2/{_R3}**2 - 1)/{_R3}**3",
        _space((0.8, 0, 0), (0, 0.94, 0.79)), 60, 1800, 350,
    ),
    "two centres": Held(
        f"{_P2} - 1/(2*sqrt((qx - 0.5)**2 + qy**2)) - 1/(2*sqrt((qx + 0.5)**2 + qy**2))",
        _plane(1.5, 0, 0, 0.75), 60, 1800, 200,
    ),
    "sitnikov": Held("p**2/2 - 1/sqrt(q**2 + 0.25)", {"q": 1.2, "p": 0}, 40, 1200, 150),
    "planets": _planets(),
    "triple star": _triple(),
    "cluster 16": _cluster(),
    "ring 64": _ring(),
    # galaxies and fields
    "logarithmic": Held(
        f"{_P2} + log(0.04 + qx**2 + qy**2/0.81)/2", _plane(1, 0.2, 0.2, 0.7), 40, 1200, 150
    ),
    "miyamoto-nagai": Held(
        f"{_P3} - 1/sqrt(qx**2 + qy**2 + (1 + sqrt(qz**2 + 0.04))**2)",
        _space((1.5, 0, 0.1), (0, 0.5, 0.2)), 60, 1800, 150,
    ),
    "isochrone": Held(f"{_P2} - 1/(1 + sqrt(1 + qx**2 + qy**2))", _plane(2, 0, 0.1, 0.3), 100,
                      3000, 100),
    "dipole": Held(
        f"{_P2} + (1/qx - qx/sqrt(qx**2 + qy**2)**3)**2/2", _plane(1, 0, 0.05, 0.15), 60, 1800, 150
    ),
    # wells and molecules
    "henon-heiles 1/12": Held(f"{_P2} + {_HH}", _plane(0, 0.1, 0.384, 0.1), 50, 1500, 120),
    "henon-heiles 1/6": Held(f"{_P2} + {_HH}", _plane(0, -0.15, 0.534, 0.1), 40, 1200, 120),
    "double well": Held("p**2/2 + q**4/4 - q**2/2", {"q": 1.6, "p": 0}, 40, 1200, 120),
    "morse": Held("p**2/2 + (1 - exp(-q))**2", {"q": -0.5, "p": 0.2}, 60, 1800, 120),
    "swinging spring": Held(
        f"{_P2} + 5*({_R} - 1)**2 + qy", _plane(0.4, -1.1, 0, 0.2), 30, 900, 150
    ),
    "lennard-jones 7": Held(
        f"{_T} + 4*sum(1/{_LJ}**6 - 1/{_LJ}**3 for i in range(7) for j in range(i))",
        {"q": _hexagon(), "p": _balanced(14, 0.35)}, 4, 80, 120, most=200_000,
    ),
    "ions 8": Held(
        f"{_T} + sum(0.15*q[2*i]**2 + 0.75*q[2*i+1]**2 for i in range(8))"
        f" + sum(1/sqrt({_LJ}) for i in range(8) for j in range(i))",
        {"q": _flat([[1.3 * (k - 3.5), 0.2 * math.sin(3.0 * k)] for k in range(8)]),
         "p": _spread(16, 0.1)}, 20, 400, 100, most=200_000,
    ),
    # chains and lattices
    "ring polymer 16": _chain(
        f"sum(8*{_RING}**2 + q[i]**4/4 - q[i]**2/2 for i in range(n))", 16, 0.6, 0.8, 15, 300, 200
    ),
    "morse chain 16": Held(
        f"{_T} + sum((1 - exp(q[i] - q[i+1]))**2 for i in range(n-1))",
        {"q": _balanced(16, 0.15), "p": _balanced(16, 0.3)}, 20, 400, 120, most=200_000,
    ),
    "toda ring 16": _chain(f"sum(exp(-{_RING}) for i in range(n))", 16, 0.3, 0.7, 20, 400, 100),
    "fput beta 32": Held(
        f"{_T} + sum((q[i+1] - q[i])**2/2 + (q[i+1] - q[i])**4/4 for i in range(n-1)) + {_ENDS}",
        {"q": [math.sin(5 * math.pi * (i + 1) / 33) for i in range(32)], "p": [0] * 32},
        25, 500, 120, most=200_000,
    ),
    "phi4 chain 64": _chain(
        f"sum({_RING}**2/2 + q[i]**4/4 for i in range(n))", 64, 0.2, 0.6, 20, 300, 120
    ),
    "pendulum chain 24": _chain(
        f"sum(1 - cos(q[i]) + {_RING}**2/4 for i in range(n))", 24, 1.2, 0.3, 25, 500, 100
    ),
    "dna chain 24": _chain(
        f"sum((1 - exp(-q[i]))**2/2 + {_RING}**2/20 for i in range(n))", 24, 0.4, 0.3, 25, 500, 100
    ),
    "lattice 36": _chain(_LATTICE, 36, 0.3, 0.5, 15, 300, 120),
    # T not quadratic
    "relativistic oscillator": Held(
        "sqrt(1 + p**2) + q**2/2", {"q": 1.5, "p": 0}, 60, 1800, 120, quadratic=False
    ),
    "relativistic pendulum": Held(
        "sqrt(1 + p**2) - cos(q)", {"q": 2, "p": 0}, 60, 1800, 120, quadratic=False
    ),
    "relativistic kepler": Held(
        f"sqrt(1 + px**2 + py**2) - 1/(4*{_R})", _plane(1, 0, 0, 0.45), 100, 3000, 200,
        quadratic=False,
    ),
    "relativistic henon-heiles": Held(
        f"sqrt(1 + px**2 + py**2) + {_HH}", _plane(0, 0.1, 0.4, 0.1), 50, 1500, 120,
        quadratic=False,
    ),
    "relativistic chain 32": Held(
        "sum(sqrt(1 + p[i]**2) for i in range(n))"
        f" + sum({_RING}**2/2 + {_RING}**4/4 for i in range(n))",
        {"q": _balanced(32, 0.3), "p": _balanced(32, 0.7)}, 20, 400, 120, quadratic=False,
        most=200_000,
    ),
    "harper": Held(
        "2 - cos(p) - 0.8*cos(q)", {"q": 1.2, "p": 0.8}, 60, 1800, 120, quadratic=False
    ),
    "rotor chain 16": Held(
        f"sum(1 - cos(p[i]) for i in range(n)) + sum(1 - cos({_RING}) for i in range(n))",
        {"q": _balanced(16, 0.5), "p": _balanced(16, 0.9)}, 20, 400, 120, quadratic=False,
        most=200_000,
    ),
    "quartic kinetic": Held(
        "p**2/2 + p**4/4 + q**4/4 - q**2/2", {"q": 1.6, "p": 0}, 40, 1200, 150, quadratic=False
    ),
    "predator and prey": Held(
        "exp(p) - p + exp(q) - q", {"q": 0.8, "p": 0.3}, 60, 1800, 150, quadratic=False
    ),
}  # fmt: skip


@cache
def problem_of(name: str) -> Problem:
    """Build one of the problems."""
    held = PROBLEMS[name]
    if not held.H:
        return problem("kepler", **held.y0)
    table = {"H": held.H, "y0": held.y0, "t_end": held.t_end, "name": name}
    return from_table(table | ({"parameters": held.parameters} if held.parameters else {}))
