"""Drift of H and of the modified energies as h is halved, in 60 digits.

The function that the outputs conserve, taken over trees through order n, drifts by C h^n on an
orbit, by C h^(n + 1) where its next term is zero too, as with symmetric methods and odd n. Runs
begin with the values on which a method acts as its one-step method, so that parasitic parts stay
below what is measured; what differences of high order show of these is subtracted until they are
gone.

    python -m campaigns.modified_slopes data/measurements/modified-slopes.json
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np

from campaigns.driver import Case, arguments, fingerprint, head_of, renew
from campaigns.fixed_point import Run, number, rounded
from glmref import modified
from glmref.catalogue.lookup import load
from glmref.engine.reference import stepper
from glmref.problems import problem
from glmref.problems.model import Problem
from glmref.scenes.modified import Modified

METHODS = ("gauss-2", "gsymplectic-n", "s4-symmetric", "s5z-w3", "stormer-verlet", "pair-4-4")
#: Problem, and the larger of two step sizes as a reciprocal: small, since parasitic parts grow. At
#: its usual start the orbit of Hénon and Heiles is chaotic, so that two runs part.
PROBLEMS: Mapping[str, tuple[Callable[[], Problem], int]] = {
    "pendulum": (lambda: problem("pendulum"), 100),
    "henon-heiles, half the start": (
        lambda: problem("henon-heiles", q2="3/20", p1="9/50", p2="11/100"),
        100,
    ),
    "kepler, e = 1/10": (lambda: problem("kepler", eccentricity="1/10"), 200),
    "lotka-volterra-logarithmic": (lambda: problem("lotka-volterra-logarithmic"), 200),
    "toda, 3 sites": (lambda: problem("toda", sites=3), 200),
}
#: Steps of the larger size, after how many parts of them the energies are looked at, and digits.
STEPS, SAMPLES, DIGITS = 100_000, 10, 60
#: Trees are taken through these orders; order 1 is H itself.
ORDERS = (1, 5, 7, 9)


@cache
def _modified(name: str, order: int = ORDERS[-1] + 2) -> Modified:
    return modified(load(name), order)


def drifts(name: str, on: str, halvings: int) -> tuple[list[float], float]:
    """Return the largest drift of the modified energy of each order over the samples of a run.

    Then the largest parasitic part that the values carry at the end.
    """
    make, parts = PROBLEMS[on]
    found, target = _modified(name), make()
    engine = stepper(load(name), target, digits=DIGITS)
    with mpmath.workdps(DIGITS):
        h = mpmath.mpf(1) / (parts << halvings)
        start = _modified(name, 3).start_at(target, engine.problem.y0, h, digits=DIGITS)
        run = Run(engine, Fraction(1, parts << halvings), np.vectorize(rounded, "O")(start))
        run.purify()
        energies = []
        for n in range(SAMPLES + 1):
            if n:
                run.advance((STEPS << halvings) // SAMPLES)
            y = engine.solution(np.vectorize(number, "O")(run.values))
            energies.append([found.energy_at(target, y, h, order=k, digits=DIGITS) for k in ORDERS])
        left = float(max(abs(number(x)) for x in run.parasitic().ravel()))
        drift = [max(abs(x - some[0]) for x in some) for some in zip(*energies, strict=True)]
        return [float(x) for x in drift], left


def row(case: Case) -> dict[str, Any]:
    """Measure one method on one problem with both step sizes."""
    pairs = (drifts(case["method"], case["problem"], k) for k in (0, 1))
    found, left = zip(*pairs, strict=True)
    return {"drifts": list(found), "parasitic": list(left)}


def slopes(x: Mapping[str, Any]) -> list[float]:
    """Return by which powers of h the drifts of a row fall, one for each of :data:`ORDERS`."""
    coarse, fine = x["drifts"]
    return [math.log2(a / b) for a, b in zip(coarse, fine, strict=True)]


def expected(name: str) -> list[int]:
    """Return the powers of h of the first term that is left out, for each of :data:`ORDERS`.

    What is zero within 30 digits counts as zero: the coefficients of some methods are rounded.
    """
    known = _modified(name).invariant_terms.items()
    terms = [free.root.order for free, x in known if abs(complex(x)) > 1e-30]
    return [min(k for k in terms if k > n) - 1 for n in ORDERS]


def cases() -> list[dict[str, Any]]:
    """List the runs."""
    return [
        {
            "method": name,
            "problem": on,
            "fingerprint": fingerprint(name),
            "steps": STEPS,
            "h": 1 / parts,
        }
        for name in METHODS
        for on, (_, parts) in PROBLEMS.items()
    ]


NOTE = (
    f"drifts: largest change of the modified energy over trees through order {ORDERS} at "
    f"{SAMPLES + 1} states of a run in {DIGITS} digits, with the step size h and so many steps, "
    "then with half of it and twice as many. parasitic: largest entry of the parasitic part of the "
    "values at the end of both."
)
HEAD = head_of(
    "modified_slopes",
    "modified-slopes",
    "Drift of the energy and of modified energies as the step size is halved",
    notes=[NOTE],
)

if __name__ == "__main__":
    path = Path(arguments(sys.argv[1:])[0])
    renew(path, HEAD, "rows", cases(), row)
