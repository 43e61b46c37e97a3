"""Chains of particles: Fermi-Pasta-Ulam-Tsingou, Toda, and a chain that is not separable.

References
----------
HLW: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., Springer 2006.
M. Tao, Explicit symplectic approximation of nonseparable Hamiltonians, Phys. Rev. E 94 (2016)
043303, for the non-separable oscillator.
"""

from __future__ import annotations

from math import exp
from typing import Any

from .formula import Formula
from .loops import Loops
from .model import Problem
from .ranges import count, number


def fput_force_into(q, params, out):  # type: ignore[no-untyped-def]
    """Force on particles between fixed walls; a spring stretched by u pulls u + a u**2 + b u**3."""
    n = len(q)
    left = q[0] + params[0] * q[0] * q[0] + params[1] * q[0] * q[0] * q[0]
    for i in range(n):
        u = -q[i]
        if i + 1 < n:
            u = q[i + 1] - q[i]
        right = u + params[0] * u * u + params[1] * u * u * u
        out[i] = right - left
        left = right


def fput_jacobian_into(t, y, params, out):  # type: ignore[no-untyped-def]
    """df/dy of the chain for y = (q, p); ``out`` is zero on entry."""
    n = len(y) // 2
    for i in range(n):
        out[i, n + i] = 1 + 0 * y[i]
    for i in range(n + 1):
        u = 0 * y[0]
        if i < n:
            u += y[i]
        if i > 0:
            u -= y[i - 1]
        slope = 1 + 2 * params[0] * u + 3 * params[1] * u * u
        if i < n:
            out[n + i, i] -= slope
        if i > 0:
            out[n + i - 1, i - 1] -= slope
        if 0 < i < n:
            out[n + i, i - 1] += slope
            out[n + i - 1, i] += slope


def fput_energy(y, params):  # type: ignore[no-untyped-def]
    """H = sum p**2/2 + sum u**2/2 + a u**3/3 + b u**4/4."""
    n = len(y) // 2
    total = 0 * y[0]
    before = 0 * y[0]
    for i in range(n):
        u = y[i] - before
        before = y[i]
        total += y[n + i] * y[n + i] / 2
        total += u * u / 2 + params[0] * u * u * u / 3 + params[1] * u * u * u * u / 4
    u = -before
    total += u * u / 2 + params[0] * u * u * u / 3 + params[1] * u * u * u * u / 4
    return total


def fput(sites: object = 32, alpha: object = "1/4", beta: object = 0) -> Problem:
    """The chain of Fermi, Pasta, Ulam and Tsingou, started in its lowest mode."""
    n = count(sites, "sites", least=1, most=10**6)
    constants = (number(alpha, "alpha"), number(beta, "beta"))

    def start(of: Any) -> list[Any]:
        return [of.sin(of.pi * (i + 1) / (n + 1)) for i in range(n)] + [0] * n

    return Problem(
        name="fput",
        source="Fermi, Pasta, Ulam, Los Alamos report LA-1940 (1955)",
        parameters={"sites": n, "alpha": constants[0], "beta": constants[1]},
        force=Loops(fput_force_into, (n,), constants),
        jacobian=Loops(fput_jacobian_into, (2 * n, 2 * n), constants),
        y0=start,
        t_span=(0.0, 1000.0),
        hamiltonian=Loops(fput_energy, (), constants),
        canonical=True,
        scales={"time": 1.0, "period": 3.141592653589793 * (n + 1)},
    )


def fput_stiff(omega: object = 50, springs: object = 3) -> Problem:
    """Soft nonlinear and stiff linear springs in turn, in the slow and fast variables of HLW.

    q = (x_{0,1}, ..., x_{0,m}, x_{1,1}, ..., x_{1,m}); the oscillatory energies are adiabatic
    invariants: they are observed, not conserved.
    """
    m = count(springs, "springs", least=2, most=20)
    w = number(omega, "omega", above=0)
    ends = [f"y[0] - y[{m}]"]
    ends += [f"y[{i + 1}] - y[{m + i + 1}] - y[{i}] - y[{m + i}]" for i in range(m - 1)]
    ends += [f"y[{m - 1}] + y[{2 * m - 1}]"]
    stretch = [text.replace("y[", "q[") for text in ends]
    names = [f"u{i}" for i in range(m + 1)]
    common = [*zip(names, stretch, strict=True)]
    common += [(f"c{i}", f"u{i}*u{i}*u{i}") for i in range(m + 1)]
    slow = [f"c{i + 1} - c{i}" for i in range(m)]
    fast = [f"c{i} + c{i + 1} - omega*omega*q[{m + i}]" for i in range(m)]
    # the last stretch enters with the sign of a wall
    slow[-1] = f"-c{m} - c{m - 1}"
    fast[-1] = f"c{m - 1} - c{m} - omega*omega*q[{2 * m - 1}]"
    parameters = {"omega": w, "springs": m}
    kinetic = " + ".join(f"y[{2 * m + i}]**2" for i in range(2 * m))
    oscillation = [f"(y[{3 * m + i}]**2 + omega*omega*y[{m + i}]**2)/2" for i in range(m)]
    potential = " + ".join(f"omega*omega*y[{m + i}]**2" for i in range(m))
    quartic = " + ".join(f"({text})**4" for text in ends)
    observables = {f"oscillatory energy {i + 1}": text for i, text in enumerate(oscillation)}
    observables["oscillatory energy"] = " + ".join(oscillation)
    return Problem(
        name="fput-stiff",
        source="HLW, section I.5.1, equations (5.1) to (5.4)",
        parameters=parameters,
        force=Formula(tuple(slow + fast), tuple(common), ("q",), parameters),
        y0=[1, *[0] * (m - 1), "1/omega", *[0] * (m - 1)] + [1, *[0] * (m - 1)] * 2,
        t_span=(0.0, 200.0),
        hamiltonian=f"({kinetic} + {potential})/2 + ({quartic})/4",
        observables=observables,
        canonical=True,
        scales={"time": 1 / float(w)},
    )


def toda_force_into(q, params, out):  # type: ignore[no-untyped-def]
    """p_i' = exp(q_{i-1} - q_i) - exp(q_i - q_{i+1}) on a ring."""
    n = len(q)
    before = exp(q[n - 1] - q[0])
    for i in range(n):
        after = exp(q[i] - q[(i + 1) % n])
        out[i] = before - after
        before = after


def toda_energy(y, params):  # type: ignore[no-untyped-def]
    """H = sum p**2/2 + exp(q_i - q_{i+1})."""
    n = len(y) // 2
    total = 0 * y[0]
    for i in range(n):
        total += y[n + i] * y[n + i] / 2 + exp(y[i] - y[(i + 1) % n])
    return total


def toda_momentum(y, params):  # type: ignore[no-untyped-def]
    """Sum of p."""
    total = 0 * y[0]
    for i in range(len(y) // 2, len(y)):
        total += y[i]
    return total


def toda_third(y, params):  # type: ignore[no-untyped-def]
    """Hénon's third integral, sum p_i**3/3 + (p_i + p_{i+1}) exp(q_i - q_{i+1})."""
    n = len(y) // 2
    total = 0 * y[0]
    for i in range(n):
        j = (i + 1) % n
        total += y[n + i] * y[n + i] * y[n + i] / 3
        total += (y[n + i] + y[n + j]) * exp(y[i] - y[j])
    return total


def toda(sites: object = 8) -> Problem:
    """The periodic Toda lattice, integrable: energy, momentum and Hénon's integral are given."""
    n = count(sites, "sites", least=3, most=10**6)

    def start(of: Any) -> list[Any]:
        phases = [2 * of.pi * i / n for i in range(n)]
        return [0] * n + [of.sin(x) + of.cos(2 * x) / 2 for x in phases]

    return Problem(
        name="toda",
        source="Toda, J. Phys. Soc. Japan 22 (1967) 431; Hénon, Phys. Rev. B 9 (1974) 1921",
        parameters={"sites": n},
        force=Loops(toda_force_into, (n,)),
        y0=start,
        t_span=(0.0, 100.0),
        hamiltonian=Loops(toda_energy, ()),
        invariants={"momentum": Loops(toda_momentum, ()), "third": Loops(toda_third, ())},
        canonical=True,
        scales={"time": 1.0},
    )


def nonseparable_into(t, y, params, out):  # type: ignore[no-untyped-def]
    """Hamilton's equations of the non-separable chain; params = (coupling,)."""
    n = len(y) // 2
    for i in range(n):
        q = y[i]
        p = y[n + i]
        pull = -2 * q
        if i > 0:
            pull += y[i - 1]
        if i + 1 < n:
            pull += y[i + 1]
        out[i] = p * (1 + q * q)
        out[n + i] = params[0] * pull - q * (1 + p * p)


def nonseparable_jacobian_into(t, y, params, out):  # type: ignore[no-untyped-def]
    """df/dy of the non-separable chain; ``out`` is zero on entry."""
    n = len(y) // 2
    for i in range(n):
        q = y[i]
        p = y[n + i]
        out[i, i] = 2 * p * q
        out[i, n + i] = 1 + q * q
        out[n + i, i] = -2 * params[0] - (1 + p * p)
        out[n + i, n + i] = -2 * q * p
        if i > 0:
            out[n + i, i - 1] = params[0]
        if i + 1 < n:
            out[n + i, i + 1] = params[0]


def nonseparable_energy(y, params):  # type: ignore[no-untyped-def]
    """H = sum (1 + q**2)(1 + p**2)/2 + coupling/2 sum (q_{i+1} - q_i)**2, walls at both ends."""
    n = len(y) // 2
    total = 0 * y[0]
    before = 0 * y[0]
    for i in range(n):
        q = y[i]
        p = y[n + i]
        total += (1 + q * q) * (1 + p * p) / 2 + params[0] * (q - before) * (q - before) / 2
        before = q
    return total + params[0] * before * before / 2


def nonseparable_chain(sites: object = 20, coupling: object = 10) -> Problem:
    """Coupled oscillators with H = (1 + q**2)(1 + p**2)/2 each: Newton's method has work to do."""
    n = count(sites, "sites", least=1, most=10**6)
    constants = (number(coupling, "coupling"),)

    def start(of: Any) -> list[Any]:
        return [of.sin(3 * of.pi * (i + 1) / (n + 1)) / 2 for i in range(n)] + [0] * n

    return Problem(
        name="nonseparable-chain",
        source="the oscillator of Tao, Phys. Rev. E 94 (2016) 043303, coupled by springs",
        parameters={"sites": n, "coupling": constants[0]},
        f=Loops(nonseparable_into, (2 * n,), constants),
        jacobian=Loops(nonseparable_jacobian_into, (2 * n, 2 * n), constants),
        y0=start,
        t_span=(0.0, 10.0),
        hamiltonian=Loops(nonseparable_energy, (), constants),
        canonical=True,
        scales={"time": 0.1},
    )
