"""Losses of the long survey: at which step, and what is predicted.

The survey (:mod:`campaigns.long_survey`) has energy errors at 10^4, 10^5, .. steps. Here its runs
of 10^7 steps that were lost are run again, for the step at which the energy error first passes each
power of ten. What becomes of these and, at the largest step size of a method, of the bounded ones
says :func:`glmref.predict`.

    python -m campaigns.parasitic_losses data/measurements/parasitic-losses.json

Runs are carried out where ``--on`` or ``GLMREF_EXECUTOR`` says; those that the file has are kept.
"""

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import Case, arguments, head_of, renew, three_digits
from campaigns.long_survey import PROBLEMS, loaded
from campaigns.pages import ROOT, Pages, markdown, measured
from glmref import predict
from glmref.engine.outcome import Solution
from glmref.measure.longtime import energy_deviation, follow
from glmref.measure.prediction import BOUNDED, LOST, OPEN, SATURATES
from glmref.problems.model import Problem

STEPS = 10_000_000
#: Problems whose bounded runs are taken.
QUIET = tuple(on for on in PROBLEMS if on not in ("kepler, e = 3/5", "lattice", "chain"))
#: Energy errors whose first step is recorded; the survey calls a run lost beyond the last.
LEVELS = tuple(10.0**-k for k in range(12, 0, -1))
#: A run saturated if its error took so many times the steps from 1e-3 to 1e-1 as from 1e-5 to 1e-3.
SLOWER = 5
#: Fewest steps after which growth is told from the error of the steps themselves.
EARLY = 1000
#: Prediction and loss agree within this factor, and prediction and departure.
FACTOR, CLOSE = 2, 1.5
#: Growth parameters of a method, as its file claims.
FREE = "parasitism-free"
Row = Mapping[str, Any]


def _errors(target: Problem, run: Solution) -> np.ndarray:
    error = energy_deviation(target, np.real(np.asarray(run.y)))
    return np.nan_to_num(error, nan=math.inf)


def seen(case: Case) -> list[int | None]:
    """Return the steps at which the energy error of a run first passes each of :data:`LEVELS`.

    A run that breaks off passes all of them there.
    """
    target, h = PROBLEMS[case["problem"]][0](), case["h"]
    run = follow(
        target,
        loaded(case["method"]),
        h=h,
        steps=STEPS,
        lost=lambda part: bool((_errors(target, part) > LEVELS[-1]).any()),
    )
    errors = _errors(target, run)
    at = np.round((np.asarray(run.t, dtype=float) - float(target.t_span[0])) / h)
    if not run.completed:
        errors[-1] = math.inf
    passed = [np.flatnonzero(errors > level) for level in LEVELS]
    return [int(at[over[0]]) if len(over) else None for over in passed]


def expected(case: Case) -> dict[str, Any]:
    """Predict a run: verdict, step (``None``: never, or open), level, and departure."""
    target, h = PROBLEMS[case["problem"]][0](), case["h"]
    found = predict(loaded(case["method"]), target, h, float(target.t_span[0]) + STEPS * h)
    return {
        "verdict": found.verdict,
        "steps": None if found.steps is None else three_digits(found.steps),
        "level": None if found.level is None else three_digits(found.level),
        "departure": None if found.departure is None else [*map(three_digits, found.departure)],
    }


def row(case: Case) -> dict[str, Any]:
    """Measure a run: seen, where it was lost, and predicted."""
    passed = seen(case) if case["survey"] == LOST else None
    return {"passed": passed, "predicted": expected(case)}


def cases() -> list[dict[str, Any]]:
    """List the runs, each with what the survey says of it."""
    found = []
    for x in measured("long-survey")["rows"]:
        on = x["problem"]
        if x["steps"] != STEPS or loaded(x["method"]).carried < 2:
            continue
        runs = [run for run in x["runs"] if not run["renew"]]
        for run in runs:
            bounded = run["verdict"] == BOUNDED and run is runs[0] and on in QUIET
            if run["verdict"] == LOST or bounded:
                known = {key: x[key] for key in ("method", "problem", "fingerprint")}
                found.append(known | {"h": run["h"], "survey": run["verdict"]})
    return found


def lost_at(x: Row) -> int:
    """Return the step at which a lost run was lost; in the survey it was by its last step."""
    step: int | None = x["passed"][-1]
    return STEPS if step is None else step


def saturated(x: Row) -> bool:
    """Tell whether the growth of a lost run stopped for long before it was lost."""
    first, second = x["passed"][LEVELS.index(1e-5)], x["passed"][LEVELS.index(1e-3)]
    if first is None or second is None or first < EARLY:
        return False
    return bool(lost_at(x) - second > SLOWER * (second - first))


def agrees(x: Row) -> bool:
    """Tell whether the predicted step of loss, within the run or not, is that within FACTOR."""
    said, at = x["predicted"], lost_at(x)
    known = said["verdict"] in (LOST, BOUNDED) and said["steps"] is not None
    return known and at / FACTOR <= said["steps"] <= at * FACTOR


def departs(x: Row) -> bool:
    """Tell whether the energy leaves its early level at the step predicted, within CLOSE."""
    if x["predicted"]["departure"] is None:
        return False
    level, steps = x["predicted"]["departure"]
    at = dict(zip(range(-len(LEVELS), 0), x["passed"], strict=True)).get(round(math.log10(level)))
    return steps is not None and at is not None and at / CLOSE <= steps <= at * CLOSE


@cache
def _free(name: str) -> bool:
    return loaded(name).claims.get(FREE) is True


#: Rows of the table that say when a run is predicted to be lost.
WITHIN, ELSE = f"{LOST} at the step seen, within a factor {FACTOR}", f"{LOST} at another step"
LEAVES = f"energy error above its early level at the step seen, within a factor {CLOSE}"
#: Kinds of runs: heading, and which.
KINDS: Mapping[str, Callable[[Row], bool]] = {
    "lost, $\\mu = 0$": lambda x: x["survey"] == LOST and _free(x["method"]),
    "lost, $\\mu \\ne 0$": lambda x: x["survey"] == LOST and not _free(x["method"]),
    "bounded": lambda x: x["survey"] == BOUNDED,
}


def counts(rows: Sequence[Row]) -> dict[str, int]:
    """Count the runs of one kind by what is predicted."""
    lost = [x for x in rows if x["survey"] == LOST]
    rest = [x["predicted"]["verdict"] for x in rows if x not in lost or not agrees(x)]
    return {
        "runs": len(rows),
        LEAVES: sum(map(departs, lost)),
        WITHIN: len(rows) - len(rest),
        ELSE: rest.count(LOST),
        SATURATES: rest.count(SATURATES),
        BOUNDED: rest.count(BOUNDED),
        OPEN: rest.count(OPEN),
        "seen to saturate before the loss": sum(map(saturated, lost)),
        "seen and predicted to saturate": sum(
            saturated(x) and x["predicted"]["verdict"] == SATURATES for x in lost
        ),
    }


def table() -> str:
    """Return predictions by kind of run, in Markdown."""
    rows = measured("parasitic-losses")["rows"]
    found = [counts([x for x in rows if kind(x)]) for kind in KINDS.values()]
    lines = [[key, *(x[key] for x in found)] for key in found[0]]
    return markdown(["predicted of 10,000,000 steps", *KINDS], lines)


NOTE = (
    "Runs of 10^7 steps of the long survey that were lost, and, but for e = 3/5, lattice and "
    "chain, those that stayed bounded at the largest step size of a method; survey: its verdict. "
    "passed: the first step whose relative energy error is above 1e-12, 1e-11, .., 1e-1; a run "
    "that breaks off passes all of them there; times are known to a thousandth. predicted: "
    "verdict, step and level of glmref.predict, and departure: the first power of ten at least ten "
    "times the early energy errors, and the step by which the energy error passes it."
)
HEAD = head_of(
    "parasitic_losses",
    "parasitic-losses",
    "Losses of long runs to their parasitic parts, seen and predicted",
    notes=[NOTE],
)
PAGE = ROOT / "campaigns" / "long_survey.md"
PAGES: Pages = {PAGE: {"parasitic-losses": table}}


if __name__ == "__main__":
    (file,) = arguments(sys.argv[1:])
    renew(Path(file), HEAD, "rows", cases(), row)
