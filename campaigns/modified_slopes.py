"""Drift of H and of the modified energies as h is halved, in 60 digits.

The function that the outputs conserve, taken over trees through order n, drifts by C h^n on an
orbit, by C h^(n + 1) where its next term is zero too, as with symmetric methods and odd n. Runs
begin with the values on which a method acts as its one-step method, so that parasitic parts stay
below what is measured; of long runs what differences of high order show of parasitic parts is
subtracted until they are gone.

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

from campaigns.driver import Case, arguments, fingerprint, renew
from campaigns.fixed_point import Run, number, rounded
from glmref import modified
from glmref.catalogue.lookup import load
from glmref.engine.reference import stepper
from glmref.problems import problem
from glmref.problems.model import Problem
from glmref.scenes.modified import Modified

METHODS = ("gauss-2", "gsymplectic-n", "s4-symmetric", "s5z-w3", "stormer-verlet", "pair-4-4")
#: Problem, larger of two step sizes as a reciprocal, and steps of that size.
PROBLEMS: Mapping[str, tuple[Callable[[], Problem], int, int]] = {
    "pendulum": (lambda: problem("pendulum"), 10, 200),
    "henon-heiles": (lambda: problem("henon-heiles"), 10, 200),
    "kepler, e = 1/10": (lambda: problem("kepler", eccentricity="1/10"), 20, 200),
    "lotka-volterra-logarithmic": (lambda: problem("lotka-volterra-logarithmic"), 40, 240),
    "toda, 3 sites": (lambda: problem("toda", sites=3), 20, 200),
}
#: The same of long runs. Parasitic parts grow, so that h is small, and at its usual start the orbit
#: of Hénon and Heiles is chaotic, so that two runs part.
LONG: Mapping[str, tuple[Callable[[], Problem], int, int]] = {
    "pendulum": (PROBLEMS["pendulum"][0], 100, 100_000),
    "henon-heiles, half the start": (
        lambda: problem("henon-heiles", q2="3/20", p1="9/50", p2="11/100"),
        100,
        100_000,
    ),
    "kepler, e = 1/10": (PROBLEMS["kepler, e = 1/10"][0], 200, 100_000),
    "lotka-volterra-logarithmic": (PROBLEMS["lotka-volterra-logarithmic"][0], 200, 100_000),
    "toda, 3 sites": (PROBLEMS["toda, 3 sites"][0], 200, 100_000),
}
#: Trees are taken through these orders; order 1 is H itself.
ORDERS = (1, 5, 7, 9)
#: States looked at after the first, in a short and in a long run.
DIGITS, SAMPLES = 60, (20, 10)


@cache
def _modified(name: str, order: int = ORDERS[-1] + 2) -> Modified:
    return modified(load(name), order)


def drifts(name: str, on: str, halvings: int, *, long: bool) -> tuple[list[float], float]:
    """Return the largest drift of the modified energy of each order over the samples of a run.

    Then the largest parasitic part that the values carry at the end.
    """
    make, parts, steps = (LONG if long else PROBLEMS)[on]
    found, target, samples = _modified(name), make(), SAMPLES[long]
    engine = stepper(load(name), target, digits=DIGITS)
    with mpmath.workdps(DIGITS):
        h = mpmath.mpf(1) / (parts << halvings)
        series = _modified(name, 3) if long else found
        start = series.start_at(target, engine.problem.y0, h, digits=DIGITS)
        run = Run(engine, Fraction(1, parts << halvings), np.vectorize(rounded, "O")(start))
        if long:
            run.purify()
        energies = []
        for n in range(samples + 1):
            if n:
                run.advance((steps << halvings) // samples)
            y = engine.solution(np.vectorize(number, "O")(run.values))
            energies.append([found.energy_at(target, y, h, order=k, digits=DIGITS) for k in ORDERS])
        left = float(max(abs(number(x)) for x in run.parasitic().ravel()))
        drift = [max(abs(x - some[0]) for x in some) for some in zip(*energies, strict=True)]
        return [float(x) for x in drift], left


def row(case: Case) -> dict[str, Any]:
    """Measure one method on one problem with both step sizes."""
    name, on, long = case["method"], case["problem"], case["steps"] > 1000
    found, left = zip(*(drifts(name, on, k, long=long) for k in (0, 1)), strict=True)
    return {"drifts": list(found)} | ({"parasitic": list(left)} if long else {})


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
    chosen = [(name, problems) for problems in (PROBLEMS, LONG) for name in METHODS]
    return [
        {
            "method": name,
            "problem": on,
            "fingerprint": fingerprint(name),
            "steps": steps,
            "h": 1 / p,
        }
        for name, problems in chosen
        for on, (_, p, steps) in problems.items()
    ]


NOTE = (
    f"drifts: largest change of the modified energy over trees through order {ORDERS} at "
    f"{SAMPLES[0] + 1} states of a run in {DIGITS} digits, {SAMPLES[1] + 1} in runs of "
    "100,000 steps, with the step size h and so many steps, then with half of it and twice as "
    "many. parasitic: largest entry of the parasitic part of the values at the end of both."
)
HEAD = {
    "format": "glmref-measurement-1",
    "name": "modified-slopes",
    "title": "Drift of the energy and of modified energies as the step size is halved",
    "how": "python -m campaigns.modified_slopes FILE",
    "notes": [NOTE],
}

if __name__ == "__main__":
    path = Path(arguments(sys.argv[1:])[0])
    renew(path, HEAD, "rows", cases(), row)
