"""Long runs on eight problems at three step sizes, of every method with several values.

Orbits of three eccentricities, a lattice, a chain, an orbit in the logarithmic potential of a
galaxy, the pendulum and Hénon and Heiles' problem. The methods are those of order 4 or more that
carry several values and claim to be G-symplectic or symmetric, and next to them those with one
value that are recommended for long runs. A method whose energy error grows is run again with its
values made anew every :data:`RENEW` steps.

    python -m campaigns.long_survey data/measurements/long-survey.json
    python -m campaigns.long_survey data/measurements/long-survey.json 10000000 METHOD ...

The first form takes 10^6 steps of every method, the second adds longer runs of the methods named.
Runs are carried out where ``--on`` or ``GLMREF_EXECUTOR`` says; those that the file has are kept.
"""

import json
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import Case, arguments, fingerprint, head_of, renew, three_digits
from campaigns.pages import ROOT, Pages, markdown, measured
from glmref.catalogue.advice import ADVICE, SHORT
from glmref.catalogue.claims import G_SYMPLECTIC, NYSTROM_ORDER, ORDER, SYMMETRIC
from glmref.catalogue.lookup import load, names
from glmref.derive.recipes.sources import LOST
from glmref.engine.solve import solve
from glmref.errors import GlmrefError
from glmref.measure.longtime import energy_deviation
from glmref.method import PartitionedGLM
from glmref.problems import problem
from glmref.problems.model import Problem

STEPS = 1_000_000
#: Steps between samples.
EVERY = 2500
#: Steps between renewals.
RENEW = 10_000
#: Step sizes, in units of a problem's step for one evaluation and of the method's evaluations.
SIZES = (1.0, 0.8, 0.5)
#: The growth of the energy error in a decade of steps that still counts as bounded: an orbit comes
#: to other parts of its energy surface, and round-off walks. In the first decade, from 10^4 steps
#: on, it may be more, because the first 10^4 steps have four samples only.
BOUNDED, FIRST = 30.0, 1000.0
#: What a row is known by.
KEYS = ("method", "problem", "steps", "fingerprint")
#: Energy errors below it are round-off.
FLOOR = 100 * 2.0**-52
#: Energy error of the first hundredth above which a step size is too large to be of use.
USEFUL = 1e-2


def galaxy() -> Problem:
    """Return an orbit in the logarithmic potential, core radius 1/3 and axis ratio 9/10.

    Binney and Tremaine, Galactic Dynamics, 2nd ed., Princeton 2008, section 3.3.1.
    """
    inside = "(1/9 + q[0]**2 + q[1]**2*100/81)"
    return Problem(
        name="logarithmic-potential",
        y0=(0.6, 0.1, 0.2, 0.9),
        force=(f"-q[0]/{inside}", f"-(q[1]*100/81)/{inside}"),
        hamiltonian="(y[2]**2 + y[3]**2)/2 + log(1/9 + y[0]**2 + y[1]**2*100/81)/2",
    )


#: Methods that carry one value, which the others are compared with.
ONE_VALUE = (
    *("gauss-3", "gauss-4", "gauss-5", "blanes-moan-rkn-6-11", "blanes-moan-rkn-6-14"),
    *("blanes-moan-6", "kahan-li-8", "suzuki-umeno-8", "yoshida-verlet-6"),
)
#: Evaluations of a step in whose unit its size is given. Explicit methods that are not named have
#: their own number here, implicit ones 4, so that energy errors are comparable at first.
UNITS: Mapping[str, float] = {
    "gauss-4": 8,
    "gauss-5": 12,
    "blanes-moan-rkn-6-14": 10.4,
    "pair-8-24": 12,
}
#: Name -> problem, and the step that belongs to one force evaluation.
PROBLEMS: Mapping[str, tuple[Callable[[], Problem], float]] = {
    "kepler, e = 1/10": (lambda: problem("kepler", eccentricity="1/10"), 0.025),
    "kepler, e = 3/10": (lambda: problem("kepler", eccentricity="3/10"), 0.015),
    "kepler, e = 3/5": (lambda: problem("kepler", eccentricity="3/5"), 0.006),
    "lattice": (lambda: problem("fput", sites=8), 1 / 32),
    "chain": (lambda: problem("toda"), 1 / 32),
    "galaxy": (galaxy, 1 / 64),
    "pendulum": (lambda: problem("pendulum", q0="23/10"), 1 / 64),
    "henon-heiles": (lambda: problem("henon-heiles"), 1 / 64),
}


@cache
def _built(name: str) -> Problem:
    return PROBLEMS[name][0]()


def surveyed() -> list[str]:
    """Return names of the methods: the recommended ones with one value, then those with several."""
    found = []
    for name in names("methods"):
        method = loaded(name)
        claims = method.claims
        orders = [x for x in map(claims.get, (ORDER.key, NYSTROM_ORDER.key)) if isinstance(x, int)]
        kept = claims.get(G_SYMPLECTIC.key) is True or claims.get(SYMMETRIC.key) is True
        if method.carried > 1 and max(orders, default=0) >= 4 and kept and method.is_real:
            found.append(name)
    return [*ONE_VALUE, *sorted(found, key=lambda name: not name.startswith("pair"))]


#: A method by name, read once.
loaded = cache(load)


@cache
def _evaluations(name: str) -> float:
    """Return evaluations of a step in whose unit its size is given."""
    method = loaded(name)
    return UNITS.get(name, method.n_Q if isinstance(method, PartitionedGLM) else 4)


def step_sizes(name: str, on: str) -> tuple[float, ...]:
    """Return the three step sizes of a method on a problem."""
    whole = PROBLEMS[on][1] * _evaluations(name)
    return tuple(float(f"{whole * size:.6g}") for size in SIZES)


def followed(name: str, on: str, h: float, steps: int, renewed: int) -> dict[str, Any]:
    """Return one run: the largest energy error up to 10^4, 10^5, .. steps."""
    target, method = _built(on), load(name)
    marks = [10**k for k in range(4, 20) if 10**k <= steps]
    try:
        run = solve(target, method, h=h, steps=steps, every=EVERY, renew=renewed)
    except GlmrefError as error:
        return {"h": h, "renew": renewed, "outcome": "not run", "message": str(error)}
    error = np.nan_to_num(energy_deviation(target, np.real(run.y)), nan=math.inf)
    at = np.round((run.t - float(target.t_span[0])) / h)
    energy = [float(error[at <= n].max()) for n in marks if n <= run.steps or n == steps]
    found = {"h": h, "renew": renewed, "outcome": str(run.outcome), "steps": int(run.steps)}
    return found | {"marks": marks, "energy": [three_digits(x) for x in energy]}


def verdict(run: Mapping[str, Any]) -> str:
    """Return ``bounded``, ``grows`` or ``lost``; else ``too coarse`` or ``not run``."""
    if run["outcome"] == "not run":
        return "not run"
    energy = [math.inf if x is None else x for x in run["energy"]]
    if not energy or energy[0] > USEFUL:
        return "too coarse"
    if run["outcome"] != "completed" or energy[-1] > LOST:
        return "lost"
    allowed = [FIRST, *[BOUNDED] * len(energy)]
    decades = zip(energy, energy[1:], allowed, strict=False)
    steady = all(after <= most * max(before, FLOOR) for before, after, most in decades)
    return "bounded" if steady else "grows"


def row(case: Case) -> dict[str, Any]:
    """Return all runs of a method on a problem."""
    name, on, steps = case["method"], case["problem"], case["steps"]
    several, runs = loaded(name).carried > 1, []
    for h in step_sizes(name, on):
        run = followed(name, on, h, steps, 0)
        runs.append(run | {"verdict": verdict(run)})
        if several and runs[-1]["verdict"] in ("grows", "lost"):
            run = followed(name, on, h, steps, RENEW)
            runs.append(run | {"verdict": verdict(run)})
    return {"runs": runs}


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return how many runs of each method ended how, in Markdown.

    Renewed runs are those that did not stay bounded.
    """
    kinds = ("bounded", "grows", "lost")
    heads = ["method", "steps", *kinds, "where", "renewed: bounded", "grows or lost"]
    lines = []
    for name, steps in dict.fromkeys((x["method"], x["steps"]) for x in rows):
        mine = [x for x in rows if (x["method"], x["steps"]) == (name, steps)]
        runs = [(x["problem"], run) for x in mine for run in x["runs"]]
        never = [(on, run["verdict"]) for on, run in runs if not run["renew"]]
        again = [run["verdict"] for _, run in runs if run["renew"]]
        where = dict.fromkeys(on for on, verdict in never if verdict in kinds[1:])
        cells = [str(sum(verdict == kind for _, verdict in never)) for kind in kinds]
        kept = again.count("bounded")
        ends = [str(kept), str(len(again) - kept)] if again else ["", ""]
        cells = [f"`{name}`", f"{steps:,}", *cells, "; ".join(where), *ends]
        lines.append(cells)
    return markdown(heads, lines)


NOTE = (
    f"Largest relative energy error up to each mark of steps, sampled every {EVERY} steps; each "
    f"method from its default start; h: {', '.join(map(str, SIZES))} times the problem's step for "
    "one evaluation, times the evaluations of a step (four for implicit methods). bounded: the "
    f"error grows by no more than a factor {BOUNDED:g} in each decade of steps, and {FIRST:g} in "
    f"the first, from 10^4 steps on, which have four samples; lost: it passes {LOST:g}; too "
    f"coarse: it passes {USEFUL:g} in the first 10^4 steps. A method that grows or is lost is run "
    f"again with its values made anew every {RENEW:,} steps."
)
HEAD = head_of(
    "long_survey",
    "long-survey",
    "Long runs on eight problems at three step sizes",
    how="python -m campaigns.long_survey FILE [STEPS METHOD ..]",
    notes=[NOTE],
)


def advice() -> str:
    """Return the table of what to take first."""
    rows = ([x.need, f"`{x.take[0]}`", x.why] for x in ADVICE)
    return markdown(["your problem", "take", "why"], rows)


def also() -> str:
    """Return what else to take, a list."""
    lines = []
    for one in ADVICE:
        others = [f"`{x}`{f' (up to {SHORT:,} steps)' * one.limited(x)}" for x in one.take[1:]]
        lines.append(f"* *{one.need}*: {', '.join(others)}. {one.more}")
    return "\n".join(lines)


PAGES: Pages = {
    ROOT / "docs" / "choose.md": {"advice": advice, "also": also},
    ROOT / "campaigns" / "long_survey.md": {
        "long-survey": lambda: table(measured("long-survey")["rows"])
    },
}


def main(path: Path, steps: int = STEPS, methods: Sequence[str] | None = None) -> None:
    """Run what the file lacks, and write it."""
    rows = json.loads(path.read_text(encoding="utf-8"))["rows"] if path.is_file() else []
    cases = {(x["method"], x["problem"], x["steps"]): x["fingerprint"] for x in rows}
    for name in surveyed() if methods is None else methods:
        cases |= {(name, on, steps): fingerprint(name) for on in PROBLEMS}
    todo: list[dict[str, Any]] = [
        dict(zip(KEYS, (*case, mark), strict=True)) for case, mark in cases.items()
    ]
    renew(path, HEAD, "rows", todo, row)


if __name__ == "__main__":
    file, *words = arguments(sys.argv[1:])
    main(Path(file), int(words[0]) if words else STEPS, words[1:] or None)
