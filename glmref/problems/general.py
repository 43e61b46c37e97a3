"""Hamiltonian systems that are not separable, and semi-separable ones q' = f(p), p' = g(q, p).

Each is one expression for H, or one for each component, from which everything else follows. They
are split in two before any of them was run with a method for such systems: :data:`HELD_OUT` are for
measuring only, the others may be used in a search. ``shear`` and ``quartic-shear`` are made to
defeat explicit symmetric multistep methods: H_pq has one sign.

References
----------
Goldstein, Poole, Safko, Classical Mechanics, 3rd ed., Addison Wesley 2002 (GPS).
Blanchet, Living Rev. Relativ. 17 (2014) 2, for post-Newtonian binaries.
Tufillaro, Abbott, Griffiths, Amer. J. Phys. 52 (1984) 895, for the swinging Atwood machine.
Kevrekidis, The Discrete Nonlinear Schrödinger Equation, Springer 2009.
Störmer, Zeitschrift für Astrophysik 1 (1930) 237, for a charge in the field of a dipole.
"""

from __future__ import annotations

from collections.abc import Mapping

from .from_expressions import equation_entries, hamiltonian_entries
from .model import Problem
from .ranges import number

#: Problems that are for measuring only; no method was searched or chosen on them.
HELD_OUT = (
    "dipole-charge",
    "discrete-schroedinger",
    "frame-dragging",
    "hyperbolic-oscillator",
    "post-newtonian-binary",
    "quartic-shear",
    "swinging-atwood",
    "uneven-plane",
)


def _canonical(
    name: str, source: str, H: str, y0: Mapping[str, str], t_end: float,
    given: Mapping[str, object], invariants: Mapping[str, str] | None = None,
) -> Problem:  # fmt: skip
    """Return the problem of one expression for H; all of ``given`` are its parameters."""
    parameters = {key: number(value, key) for key, value in given.items()}
    entries = hamiltonian_entries(
        H, dict(y0), parameters=parameters, t_end=t_end, invariants=invariants, name=name,
        source=source, time=1,
    )  # fmt: skip
    return Problem(**entries)


def _kinetic(
    name: str, source: str, f: Mapping[str, str], y0: Mapping[str, str], t_end: float,
    given: Mapping[str, object], energy: str,
) -> Problem:  # fmt: skip
    """Return a semi-separable problem, positions first, in velocities that are not canonical."""
    parameters = {key: number(value, key) for key, value in given.items()}
    entries = equation_entries(
        f, dict(y0), parameters=parameters, t_end=t_end, invariants={"energy": energy}, name=name,
        source=source, time=1,
    )  # fmt: skip
    entries["hamiltonian"] = entries["invariants"].pop("energy")
    return Problem(**entries)


def shear(coupling: object = "3/10") -> Problem:
    """H = (p**2 + q**2)/2 + coupling q p: an oscillator that a shear makes separable."""
    return _canonical(
        "shear", "GPS, section 9.4, for the canonical transformation",
        "(p**2 + q**2)/2 + coupling*q*p", {"q": "1", "p": "0"}, 30, {"coupling": coupling},
    )  # fmt: skip


def quartic_shear(coupling: object = "1/5") -> Problem:
    """A quartic oscillator with H_pq = coupling (1 + 3 q**2), which is positive everywhere."""
    return _canonical(
        "quartic-shear", "GPS, section 9.4, for the canonical transformation",
        "p**2/2 + q**4/4 + q**2/2 + coupling*q*p*(1 + q**2)", {"q": "1", "p": "0"}, 30,
        {"coupling": coupling},
    )  # fmt: skip


def elastic_pendulum(stiffness: object = 10) -> Problem:
    """A unit mass on a spring of unit length, g = 1, in polar coordinates."""
    return _canonical(
        "elastic-pendulum", "GPS, chapter 1",
        "pr**2/2 + pa**2/(2*qr**2) + stiffness*(qr - 1)**2/2 - qr*cos(qa)",
        {"qr": "11/10", "qa": "1", "pr": "0", "pa": "0"}, 20, {"stiffness": stiffness},
    )  # fmt: skip


def restricted_three_body(mass: object = "1/82") -> Problem:
    """The planar restricted three-body problem in the rotating frame, near the larger body."""
    return _canonical(
        "restricted-three-body", "GPS, section 3.12",
        "(px**2 + py**2)/2 + qy*px - qx*py - (1 - mass)/sqrt((qx + mass)**2 + qy**2)"
        " - mass/sqrt((qx - 1 + mass)**2 + qy**2)",
        {"qx": "1/2", "qy": "0", "px": "0", "py": "7/5"}, 20, {"mass": mass},
    )  # fmt: skip


def heavy_top(gravity: object = 6) -> Problem:
    """A symmetric heavy top in Euler's angles, moments of inertia 1, 1 and 1/2."""
    return _canonical(
        "heavy-top", "GPS, section 5.7",
        "pn**2/2 + (pa - ps*cos(qn))**2/(2*sin(qn)**2) + ps**2 + gravity*cos(qn)",
        {"qn": "1", "qa": "0", "qs": "0", "pn": "0", "pa": "2", "ps": "3/2"}, 20,
        {"gravity": gravity}, {"vertical momentum": "pa", "axial momentum": "ps"},
    )  # fmt: skip


def charge_in_gauge(field: object = 1) -> Problem:
    """A charge in a uniform magnetic field and a trap, canonical momenta in the symmetric gauge."""
    return _canonical(
        "charge-in-gauge", "GPS, section 8.4",
        "((px + field*qy/2)**2 + (py - field*qx/2)**2)/2 + (qx**2 + 2*qy**2)/2 + qx**4/4",
        {"qx": "1", "qy": "0", "px": "0", "py": "1/2"}, 20, {"field": field},
    )  # fmt: skip


def schwarzschild_orbit(energy: object = "49/50") -> Problem:
    """A bound orbit around a black hole of unit mass, of a mass near 1, over proper time."""
    return _canonical(
        "schwarzschild-orbit", "Misner, Thorne, Wheeler, Gravitation, section 25.5",
        "((1 - 2/qr)*pr**2 + pa**2/qr**2 - energy**2/(1 - 2/qr))/2",
        {"qr": "15", "qa": "0", "pr": "0", "pa": "5"}, 400, {"energy": energy},
        {"angular momentum": "pa"},
    )  # fmt: skip


def uneven_plane(slope: object = "3/10") -> Problem:
    """A harmonic oscillator in a plane where its mass is 1 + slope x**2 + y**2/5."""
    return _canonical(
        "uneven-plane", "GPS, chapter 8",
        "(px**2 + py**2)/(2*(1 + slope*qx**2 + qy**2/5)) + (qx**2 + qy**2)/2",
        {"qx": "1", "qy": "1/5", "px": "3/10", "py": "4/5"}, 30, {"slope": slope},
    )  # fmt: skip


def hyperbolic_oscillator(stiffness: object = 1) -> Problem:
    """A particle in Poincaré's half-plane, y**2 (px**2 + py**2)/2, bound to (0, 1)."""
    return _canonical(
        "hyperbolic-oscillator", "GPS, chapter 8",
        "qy**2*(px**2 + py**2)/2 + stiffness*(qx**2 + (qy - 1)**2)/(2*qy)",
        {"qx": "1/2", "qy": "1", "px": "0", "py": "2/5"}, 20, {"stiffness": stiffness},
    )  # fmt: skip


def frame_dragging(spin: object = "1/20") -> Problem:
    """Kepler's orbit with frame dragging: H = p**2/2 - 1/r - spin (x py - y px)/r**3."""
    return _canonical(
        "frame-dragging", "Blanchet, Living Rev. Relativ. 17 (2014) 2, the spin-orbit term",
        "(px**2 + py**2)/2 - 1/sqrt(qx**2 + qy**2)"
        " - spin*(qx*py - qy*px)/(qx**2 + qy**2)**(3/2)",
        {"qx": "2", "qy": "0", "px": "0", "py": "4/5"}, 40, {"spin": spin},
        {"angular momentum": "qx*py - qy*px"},
    )  # fmt: skip


def post_newtonian_binary(epsilon: object = "1/100") -> Problem:
    """The relative motion of two equal-sided bodies at first post-Newtonian order."""
    r = "sqrt(qx**2 + qy**2)"
    return _canonical(
        "post-newtonian-binary", "Blanchet, Living Rev. Relativ. 17 (2014) 2",
        f"(px**2 + py**2)/2 - 1/{r} + epsilon*(-(px**2 + py**2)**2/8"
        f" - (3*(px**2 + py**2) + (qx*px + qy*py)**2/(qx**2 + qy**2))/(2*{r})"
        " + 1/(2*(qx**2 + qy**2)))",
        {"qx": "7/10", "qy": "0", "px": "0", "py": "27/20"}, 30, {"epsilon": epsilon},
        {"angular momentum": "qx*py - qy*px"},
    )  # fmt: skip


def swinging_atwood(ratio: object = 3) -> Problem:
    """Atwood's machine whose lighter mass swings; chaotic for most mass ratios."""
    return _canonical(
        "swinging-atwood", "Tufillaro, Abbott, Griffiths, Amer. J. Phys. 52 (1984) 895",
        "pr**2/(2*(1 + ratio)) + pa**2/(2*qr**2) + qr*(ratio - cos(qa))",
        {"qr": "1", "qa": "3/2", "pr": "0", "pa": "0"}, 10, {"ratio": ratio},
    )  # fmt: skip


def discrete_schroedinger(coupling: object = 1) -> Problem:
    """The discrete nonlinear Schrödinger equation on five sites, psi = q + i p: chaotic."""
    sites = range(1, 6)
    quartic = " + ".join(f"(q{k}**2 + p{k}**2)**2" for k in sites)
    hops = " + ".join(f"q{k}*q{k + 1} + p{k}*p{k + 1}" for k in range(1, 5))
    start = dict.fromkeys([*(f"q{k}" for k in sites), *(f"p{k}" for k in sites)], "0")
    start |= {"q1": "1", "q2": "1/10", "q4": "-1/5", "q5": "1/2", "p3": "1/10"}
    return _canonical(
        "discrete-schroedinger", "Kevrekidis, Springer 2009, chapter 1",
        f"({quartic})/4 - coupling*({hops})", start, 20, {"coupling": coupling},
        {"norm": " + ".join(f"q{k}**2 + p{k}**2" for k in sites)},
    )  # fmt: skip


def magnetic_trap(field: object = 1) -> Problem:
    """A charge in the field field (1 + x**2) and a trap, in velocities: semi-separable."""
    return _kinetic(
        "magnetic-trap", "GPS, section 1.5",
        {"x": "u", "y": "v", "u": "field*(1 + x**2)*v - x", "v": "-field*(1 + x**2)*u - 2*y"},
        {"x": "1", "y": "0", "u": "0", "v": "1/2"}, 20, {"field": field},
        "(u**2 + v**2 + x**2)/2 + y**2",
    )  # fmt: skip


def dipole_charge(strength: object = 1) -> Problem:
    """A charge in the field of a magnetic dipole, in velocities: semi-separable."""
    r5 = "(x**2 + y**2 + z**2)**(5/2)"
    bx, by = f"3*strength*x*z/{r5}", f"3*strength*y*z/{r5}"
    bz = f"strength*(2*z**2 - x**2 - y**2)/{r5}"
    return _kinetic(
        "dipole-charge", "Störmer, Zeitschrift für Astrophysik 1 (1930) 237",
        {
            "x": "u", "y": "v", "z": "w", "u": f"v*{bz} - w*{by}",
            "v": f"w*{bx} - u*{bz}", "w": f"u*{by} - v*{bx}",
        },
        {"x": "1", "y": "0", "z": "1/10", "u": "1/20", "v": "1/20", "w": "1/10"}, 40,
        {"strength": strength}, "(u**2 + v**2 + w**2)/2",
    )  # fmt: skip
