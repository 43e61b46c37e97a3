r"""Methods for semi-separable systems: those on the front, and the long runs of those shipped.

    python -m campaigns.partitioned.semi_separable data/measurements/nonseparable.json

The roots of :data:`FOUND` are by covariance matrix adaptation (Hansen, Ostermeier 2001) of their
angles: fewest evaluations at 1e-9 on :data:`SEARCHED` and two problems that are not in the record,
without growth in 20,000 steps there, with an interval of at least 0.10 and residues of p below 1.6.
On the other problems of the record nothing was chosen.

*Interval.* The largest h omega_1 up to which a charge with the frequencies omega_1 and r omega_1,

    q' = p,  p' = i (omega_1 + r omega_1) p + r omega_1^2 q,

is stable for every r of :data:`RATIOS`.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, complete
from campaigns.partitioned.extended import ends
from campaigns.partitioned.long_runs import three_digits
from campaigns.partitioned.work import crossing
from glmref import solve
from glmref.catalogue.reader import load_document
from glmref.derive.general_multistep import general_document
from glmref.derive.halves import GeneralHalf
from glmref.derive.recipes.general_multistep import SHIPPED, half_of
from glmref.engine.outcome import Solution
from glmref.engine.parasites import over_both, step_matrix
from glmref.measure.work_precision import energy_error, reference_state, state_error
from glmref.method import Method
from glmref.problems import problem
from glmref.problems.model import Problem

#: The roots of q and p that the search found, by the name in the record.
FOUND = {
    "found-10": ("37/100 -7/25 -73/100 -1", "39/50 33/50 47/100 -1/50 -49/50"),
}
#: What is measured.
FRONT = ("multistep-kinetic-8", "multistep-kinetic-10", "multistep-kinetic-12", *FOUND)
#: The problems of the record that the search used.
SEARCHED = ("magnetic-trap", "penning-trap", "relativistic-charge", "rotating-three-body")
#: Ratios of the two frequencies; near 0 and 1 two of the roots are one.
RATIOS = (-1.0, -0.8, -0.6, -0.4, -0.2, -0.05, 0.05, 0.2, 0.4, 0.6)
TOLERANCE = 1e-9
#: Where the time of a notice changes with the last bits.
CHAOTIC = "magnetic-bottle"
#: Methods, problems, steps at which every gyration is stable, and how many of them are taken.
BELOW = (
    ("multistep-kinetic-12", "dipole-charge", 0.0016, 500_000),
    ("multistep-kinetic-10", "magnetic-bottle", 0.0008, 1_500_000),
)
#: Steps of the first run, most steps, factor between two runs, and steps of a long run.
_FIRST, _MOST, _FACTOR, _LONG = 100, 4_000, 1.08, 1_000_000
#: Step of h omega_1, and what rounding may add to an eigenvalue of modulus 1.
_GRID, _UNIT = 0.005, 1e-7


@dataclass(frozen=True)
class Pair:
    """Both halves of a method."""

    q: GeneralHalf  #: Implicit.
    p: GeneralHalf  #: Explicit.

    @staticmethod
    def of(name: str) -> Pair:
        """Return a pair by its name in the record."""
        roots = FOUND.get(name) or (SHIPPED[name].q, SHIPPED[name].p)
        return Pair(*(half_of(x, key, semi=True) for x, key in zip(roots, "qp", strict=True)))

    @property
    def method(self) -> Method:
        """The method with its start, without proofs."""
        document = general_document("found", self.q, self.p, title="found")
        source = {"citation": "-", "where": "-", "status": "derived"}
        return load_document({**document, "source": source, "claims": {"order": self.q.order}})

    @cached_property
    def interval(self) -> float:
        """The largest h omega_1 on a grid up to which the charge is stable for every ratio."""
        return interval(self.q, self.p, [charge(r) for r in RATIOS])


def on_plane(matrix: np.ndarray) -> np.ndarray:
    """Return a complex matrix (n, n) as a real one (2 n, 2 n), on real and imaginary parts."""
    i = np.array([[0.0, -1.0], [1.0, 0.0]])
    return np.kron(np.real(matrix), np.eye(2)) + np.kron(np.imag(matrix), i)


def charge(ratio: float) -> np.ndarray:
    """Return the matrix (4, 4) of a charge whose second frequency is a ratio of the first, 1."""
    return on_plane(np.array([[0, 1], [ratio, 1j * (1 + ratio)]]))


def arrays(q: GeneralHalf, p: GeneralHalf) -> tuple[np.ndarray, ...]:
    """Return A, U, B and V of both halves."""
    return over_both(*([half.block()[key] for key in "AUBV"] for half in (q, p)))


def interval(q: GeneralHalf, p: GeneralHalf, systems: Sequence[np.ndarray]) -> float:
    """Return the largest h on a grid up to which a pair is stable on y' = J y for every J."""
    pair = arrays(q, p)

    def stable(h: float) -> bool:
        steps = (step_matrix(pair, J, h) for J in systems)
        return all(np.abs(np.linalg.eigvals(step)).max() < 1 + _UNIT for step in steps)

    k = 1
    while stable(k * _GRID):
        k += 1
    return round((k - 1) * _GRID, 3)


def end_of(one: Problem) -> float:
    """Return the time at which the error counts: the end of the problem's scene, or 20."""
    return ends().get(one.name, 20.0)


def _errors(method: Method, one: Problem, steps: int) -> Iterator[tuple[int, int, float]]:
    """Yield steps, evaluations and the error of the last state, coarse to fine."""
    end = end_of(one)
    exact = reference_state(one, end)
    while steps <= _MOST:
        found = solve(one, method, h=end / steps, steps=steps, every=steps)
        error = state_error(found.y[-1], exact) if found.completed else math.inf
        yield steps, found.evaluations + found.start_evaluations, error
        steps = math.ceil(steps * _FACTOR)


def needed(
    method: Method, one: Problem, tolerance: float = TOLERANCE, *, steps: int = _FIRST
) -> tuple[int, int] | None:
    """Return steps and evaluations, start included, for the tolerance at two step sizes on end.

    The first run has so many ``steps``.
    """
    curve: list[tuple[int, float]] = []
    first = 0  # steps of the first run of those that are below without a break
    for now, count, error in _errors(method, one, steps):
        curve.append((count, error))
        if not error < tolerance:
            first = 0
        elif first:
            evaluations = crossing(curve, tolerance)
            assert evaluations is not None
            return first, round(evaluations)
        else:
            first = now
    return None


def _reported(found: Solution) -> float | None:
    """Return the time of the notice."""
    return None if found.suspect is None else float(f"{found.suspect:.6g}")


def step_of(method: Method, one: Problem) -> tuple[float, int] | None:
    """Return the step size of the tolerance, and the evaluations for it, start included."""
    found = needed(method, one)
    return found and (float(f"{end_of(one) / found[0]:.3g}"), found[1])


def long_run(
    method: Method | str, one: Problem, h: float, steps: int, renew: int = 0
) -> dict[str, Any]:
    """Return the largest relative error of the energy over 1,000 samples, and the notice's time."""
    found = solve(one, method, h=h, steps=steps, every=steps // 1000, renew=renew)
    energy = energy_error(one, found) if found.completed else math.nan
    return {
        "energy": float(f"{energy:.2g}") if math.isfinite(energy) else None,
        "reported": _reported(found),
    }


def moved(method: str, name: str, h: float, steps: int) -> dict[str, Any]:
    """Return the times of the notice for starts that differ by 0 to 3e-15 in the first value."""
    one, times = problem(name), []
    for k in range(4):
        y0 = [Fraction(x) for x in one.y0]
        y0[0] += Fraction(k, 10**15)
        found = solve(replace(one, y0=tuple(y0)), method, h=h, steps=steps, every=1000)
        times.append(_reported(found))
    return {"problem": name, "method": method, "h": h, "reported": times}


def row(name: str, gauss: Mapping[str, int]) -> dict[str, Any]:
    """Return what the record has of one method, with the evaluations over the best Gauss."""
    pair = Pair.of(name)
    method, cases = pair.method, []
    for x, best in gauss.items():
        case: dict[str, Any] = {"problem": x, "evaluations": None}
        if (found := step_of(method, problem(x))) is not None:
            h, count = found
            case |= {"evaluations": count, "over_gauss": three_digits(count / best), "h": h}
            case |= long_run(method, problem(x), h, _LONG)
        cases.append(case)
    return {
        "method": name,
        "q": [str(c) for c in (*pair.q.cosines, *[-1] * pair.q.minus_one)],
        "p": [str(c) for c in (*pair.p.cosines, *[-1] * pair.p.minus_one)],
        "order": pair.q.order,
        "error_constants": [three_digits(float(x.error_constant)) for x in (pair.q, pair.p)],
        "residue": three_digits(max(abs(float(x)) for x in pair.p.residues)),
        "interval": pair.interval,
        "cases": cases,
    }


def main(path: Path) -> None:
    """Measure the methods of the front, repeat the long runs, and write both into the record."""
    record = json.loads(path.read_text(encoding="utf-8"))
    semi = record["semi-separable"]
    gauss = {
        x["problem"]: min(n for k, n in x["methods"].items() if k.startswith("gauss") and n)
        for x in semi["evaluations"]
        if x["tolerance"] == TOLERANCE
    }
    semi["front"] = [row(name, gauss) for name in FRONT]
    semi["long"] = [
        x | long_run(x["method"], problem(x["problem"]), x["h"], x["steps"]) for x in semi["long"]
    ]
    lost = [x for x in semi["long"] if x["problem"] == CHAOTIC and x["method"] in FRONT]
    semi["moved"] = [moved(x["method"], CHAOTIC, x["h"], 160_000) for x in lost]
    semi["moved"] += [moved(*x) for x in BELOW]
    complete(path, record)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
