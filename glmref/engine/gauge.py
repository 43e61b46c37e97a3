"""Shear the coordinates of a Hamiltonian system so that H_pq has mean zero along the orbit.

For a constant symmetric G the map (q, p) -> (q, p + G q) is canonical. In the new coordinates
H_pq becomes H_pq - H_pp G, by which the parasitic part of an explicit partitioned multistep method
grows at first order in h. G is chosen such that the symmetric part of the mean of this matrix is as
small as it can be; the antisymmetric part only turns the parasitic part. The means are taken along
the first steps of the run itself, weighted by sin(pi n/N)^4, so that those of an oscillation with k
periods in the window are wrong by O(k^-5) and not by O(1/k).

References
----------
    Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), section XV.5, for the
    parasitic equations; Goldstein, Poole, Safko, "Classical Mechanics" (2002), section 9.4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import UsageError
from ..method import Method
from ..problems.formula import Formula
from ..problems.model import Problem

#: Steps of the pilot orbit, and below how many nothing is looked for.
PILOT, FEWEST = 1000, 96
#: The part of the mean rate that has to go before the coordinates are changed.
_ENOUGH = 0.5
#: Rates below this, over the largest entry of H_pq, are rounding and not removed.
_NOTHING = 1e-6
#: Largest denominator of the entries of G, so that simple couplings are met exactly.
_DENOMINATOR = 10**6


@dataclass(frozen=True)
class Gauge:
    """What a shear p -> p + G q changes of the growth of a parasitic part."""

    G: tuple[tuple[float, ...], ...]  #: (m, m), symmetric, the best one that was found.
    #: Largest absolute real part of an eigenvalue of the mean of H_pq, and of H_pq - H_pp G: the
    #: mean rate of growth of a parasitic part, for each unit of its residue and of time.
    before: float
    after: float
    #: Whether the run was done in the new coordinates: where the shear removes half of the rate or
    #: more, in both halves of the pilot orbit.
    taken: bool
    #: Right-hand-side evaluations of the pilot orbit; its derivatives are not counted.
    evaluations: int

    def __str__(self) -> str:
        rates = f"a parasitic part grows at the mean rate {self.before:.3g} times its residue"
        if not self.taken:
            return f"{rates}, of which no shear of the coordinates takes half: none is applied"
        return (
            f"{rates}, and {self.after:.3g} in the coordinates p + G q, in which the run was done"
        )

    def sheared(self, problem: Problem) -> Problem:
        """Return Hamilton's equations, given by expressions, in (q, P), P = p + G q."""
        f, m = problem.f, problem.dimension // 2
        assert isinstance(f, Formula)
        old = {m + i: _sum([f"y[{m + i}]"], row, "y[{}]", -1) for i, row in enumerate(self._exact)}
        inside = f.rewritten(lambda _, i: old.get(i))
        names = [f"f{k}_" for k in range(2 * m)]
        rows = [*names[:m], *(
            _sum([names[m + i]], row, "f{}_", 1) for i, row in enumerate(self._exact)
        )]  # fmt: skip
        whole = replace(
            inside, outputs=tuple(rows),
            common=(*inside.common, *zip(names, inside.outputs, strict=True)),
        )  # fmt: skip
        hamiltonian: Any = problem.hamiltonian
        if isinstance(hamiltonian, Formula):
            hamiltonian = hamiltonian.rewritten(lambda _, i: old.get(i))
        elif hamiltonian is not None:
            given = hamiltonian
            hamiltonian = lambda y: given(self._turned(np.asarray(y), -1.0))  # noqa: E731
        return Problem(
            f=whole, y0=self._turned(np.array(problem.y0, dtype=float), 1.0).tolist(),
            name=problem.name, parameters=problem.parameters, t_span=problem.t_span,
            hamiltonian=hamiltonian, canonical=True, scales=problem.scales,
        )  # fmt: skip

    def original(self, y: np.ndarray) -> np.ndarray:
        """Return states (.., 2 m) in the coordinates of the problem."""
        return self._turned(y, -1.0)

    @property
    def _exact(self) -> list[list[Fraction]]:
        return [[Fraction(x).limit_denominator(_DENOMINATOR) for x in row] for row in self.G]

    def _turned(self, y: np.ndarray, sign: float) -> np.ndarray:
        """Return states (.., 2 m) with p + sign G q in place of p."""
        m = len(self.G)
        out = np.array(y)
        out[..., m:] += sign * (y[..., :m] @ np.array(self.G))
        return out


def _sum(terms: list[str], row: list[Fraction], name: str, sign: int) -> str:
    """Return the text of a sum with the multiples of a row."""
    return " + ".join(
        [*terms, *(f"({sign * x})*" + name.format(j) for j, x in enumerate(row) if x)]
    )


def _best(mixed: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Return the symmetric G (m, m) for which the symmetric part of mixed - mass G is least."""
    m = len(mixed)
    places = [(i, j) for i in range(m) for j in range(i + 1)]
    units = []
    for i, j in places:
        unit = np.zeros((m, m))
        unit[i, j] = unit[j, i] = 1.0
        units.append(_symmetric(mass @ unit).ravel())
    found = np.linalg.lstsq(np.array(units).T, _symmetric(mixed).ravel(), rcond=1e-10)[0]
    G = np.zeros((m, m))
    for (i, j), x in zip(places, found, strict=True):
        G[i, j] = G[j, i] = float(Fraction(float(x)).limit_denominator(_DENOMINATOR))
    return G


def _symmetric(A: np.ndarray) -> np.ndarray:
    return (A + A.T) / 2


def _rate(A: np.ndarray) -> float:
    """Return the largest growth of exp(A t) and exp(-A t): residues have both signs."""
    return float(np.abs(np.linalg.eigvals(A).real).max())


def _mean(J: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the weighted means of H_pq and H_pp from Jacobians (2 m, 2 m, n)."""
    n, m = J.shape[-1], len(J) // 2
    weights = np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 4
    mean = J @ weights / weights.sum()
    return mean[:m, :m], mean[:m, m:]


def gauge_of(
    problem: Problem, written: Problem, method: Method, steps: int,
    pilot: Callable[[int], tuple[np.ndarray, np.ndarray, int]],
) -> tuple[Gauge, Problem]:  # fmt: skip
    """Return the best shear for a run of a pair, and the problem in the coordinates to run in.

    ``written`` is the problem, Hamilton's equations, in expressions (see :func:`.kept.expressed`).
    ``pilot`` takes the first steps: their number -> times (n,), states (n, 2 m) and evaluations; at
    most :data:`PILOT` of ``steps`` are taken for the means.

    Raises
    ------
    UsageError
        For a method with one component, and for a problem that is not Hamiltonian or not in
        expressions.
    """
    if method.parts != 2:
        raise UsageError(
            f"`gauge` changes runs with partitioned methods only; {method.name} gives the same in "
            f"all coordinates p + G q"
        )
    if not problem.canonical or not isinstance(written.f, Formula):
        raise UsageError(
            f"`gauge` needs Hamilton's equations in expressions, which {problem.name} does not "
            f"give; Problem.from_hamiltonian makes them of the text of H"
        )
    m, n = problem.dimension // 2, min(PILOT, steps)
    none = Gauge(((0.0,) * m,) * m, 0.0, 0.0, False, 0)
    if n < FEWEST:
        return none, problem
    t, y, evaluations = pilot(n)
    J = written.jacobian(t, y.T)
    J = J[..., np.isfinite(J).all(axis=(0, 1))]
    if J.shape[-1] < FEWEST:
        return none, problem
    mixed, mass = _mean(J)
    G = _best(mixed, mass)
    # what only one part of the orbit shows is an oscillation, of which a shear would make a mean
    halves = [_mean(part) for part in np.array_split(J, 2, axis=-1)]
    rates = [(_rate(a), _rate(a - b @ G)) for a, b in (*halves, (mixed, mass))]
    noise = _NOTHING * float(np.abs(mixed).max(initial=0.0))
    taken = all(noise < before and after < _ENOUGH * before for before, after in rates)
    found = Gauge(tuple(map(tuple, G.tolist())), *rates[-1], taken, evaluations)
    return found, found.sheared(written) if taken else problem
