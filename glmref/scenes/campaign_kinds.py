"""What a task of a campaign is: a run, a parcel of a search, or a cell of a resonance map.

A kind makes tasks from one combination of the axes, and names the function that carries one out.
The tasks hold all that they depend on, so that a record is found again by its content.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from .. import __version__
from ..catalogue.lookup import document, load
from ..compute.child import Function, Task
from ..compute.records import key_of
from ..derive.partitioned import PairAnsatz
from ..derive.search_tasks import PARCEL, carry_out, tasks_of
from ..measure.longtime import follow
from ..measure.parasitic import parasitic_size, solution_direction
from ..problems import Problem, problem
from ..system.arguments import whole
from .model import Answer, Scene
from .planning import task_of
from .running import perform

Values = Mapping[str, Any]


@dataclass(frozen=True)
class CampaignKind:
    """A kind of task."""

    name: str  #: As files call it.
    #: Axes that a campaign must give, and may give.
    needed: tuple[str, ...]
    optional: tuple[str, ...]
    #: From the values of all axes and a seed to the tasks of that combination.
    tasks: Callable[[Values, int], Iterator[dict[str, Any]]]
    function: Function  #: Carries out one of them.
    #: From the fixed values to the number of tasks of a combination.
    each: Callable[[Values], int] = lambda fixed: 1
    #: From the fixed values: whether run times are requested.
    timed: Callable[[Values], bool] = lambda fixed: False
    in_fixed: tuple[str, ...] = ()  #: Keys that are the same for all tasks.


# --- runs -----------------------------------------------------------------------------------------


def _run_tasks(values: Values, seed: int) -> Iterator[dict[str, Any]]:
    """Yield a run of a method on a problem with its own parameters; nothing in it is random."""
    steps = whole("steps", values["steps"], 1)
    scene = _scene(
        values["problem"], values.get("t_end"), tuple(values.get("ask", ("state", "energy"))),
        bool(values.get("timed", False)), int(values.get("repeats", 5)),
        float(values.get("run_budget", 10.0)), int(values.get("renew", 0)),
    )  # fmt: skip
    name = values["method"]
    title, fingerprint = _method(name)
    yield task_of(scene, name, title, fingerprint, scene.t_end / steps, steps)


@lru_cache(maxsize=64)
def _scene(
    name: str,
    t_end: float | None,
    ask: tuple[str, ...],
    timed: bool,
    repeats: int,
    budget: float,
    renew: int,
) -> Scene:
    first, last = (float(t) for t in problem(name).t_span)
    return Scene(
        name="campaign", title="", question="", problem=name, methods=(), ask=ask,
        t_end=last - first if t_end is None else float(t_end), budget=budget, repeats=repeats,
        answer=Answer("fastest" if timed else "ended"), renew=renew,
    )  # fmt: skip


@lru_cache(maxsize=1024)
def _method(name: str) -> tuple[str, str]:
    doc = document(name)
    return doc["name"], key_of({"document": doc})


# --- searches -------------------------------------------------------------------------------------


def _survey_tasks(values: Values, seed: int) -> Iterator[dict[str, Any]]:
    """Yield parcels of a search for explicit symmetric partitioned methods."""
    keys = ("n", "order", "nystrom", "outer", "g", "starts")
    ansatz = PairAnsatz("campaign", **{key: values[key] for key in keys if key in values})
    for task in tasks_of(ansatz, seed=seed, starts=int(values["tries"])):
        yield {**task, "kind": "survey", "solved": float(values.get("solved", 1e-10))}


def survey(task: Task) -> dict[str, Any]:
    """Run a parcel of a search, and keep of it the solutions and how near the others came.

    ``smallest`` is the least residual, ``solved`` how many starts ended in a solution with no
    coefficient above ten, ``solutions`` their ends.
    """
    ends = carry_out(task)["ends"]
    sizes = [x["residual"] for x in ends if x["residual"] is not None]
    good = [
        x
        for x in ends
        if x["point"] and x["residual"] < task["solved"] and max(map(abs, x["point"])) < 10
    ]
    return {
        "outcome": "completed",
        "starts": len(ends),
        "smallest": min(sizes, default=None),
        "solved": len(good),
        "solutions": good,
    }


# --- resonances -----------------------------------------------------------------------------------


def _resonance_tasks(values: Values, seed: int) -> Iterator[dict[str, Any]]:
    name = values["method"]
    title, fingerprint = _method(name)
    yield {
        "kind": "resonance",
        "version": __version__,
        "method": title,
        "file": name if name.endswith(".json") else None,
        "fingerprint": fingerprint,
        "h": float(values["h"]),
        "frequency": float(values["frequency"]),
        "coupling": float(values.get("coupling", 0.1)),
        "steps": int(values["steps"]),
        **({"renew": int(values["renew"])} if values.get("renew") else {}),
    }


def two_frequencies(frequency: float, coupling: float) -> Problem:
    """Return two oscillators of frequencies 1 and omega with the potential energy ``k q1^2 q2``.

    The frequency and k are components that rest, so that one compiled right-hand side serves all:
    ``y = (q1, q2, omega, k, p1, p2, 0, 0)``.
    """
    force_1, force_2 = "-q[0] - 2*q[3]*q[0]*q[1]", "-q[2]**2*q[1] - q[3]*q[0]**2"
    f = [x.replace("q[", "y[") for x in (force_1, force_2)]
    return Problem(
        name="two-frequencies",
        y0=(1.0, 0.25, frequency, coupling, 0.0, 0.0, 0.0, 0.0),
        t_span=(0.0, 1.0),
        f=("y[4]", "y[5]", "0*y[0]", "0*y[0]", *f, "0*y[0]", "0*y[0]"),
        dq=("p[0]", "p[1]", "0*p[0]", "0*p[0]"),
        dp=(force_1, force_2, "0*q[0]", "0*q[0]"),
    )


def resonance(task: Task) -> dict[str, Any]:
    """Follow two coupled oscillators and see whether the values beyond the solution stay small.

    ``growth`` is the largest size of these values over their size in the first hundredth of the
    run, ``largest`` their size over that of the initial value, ``energy_error`` is relative. A run
    that leaves all bounds has the outcome ``lost`` and the ``step`` at which it did.
    """
    method = load(task["file"] or task["method"])
    subject = two_frequencies(task["frequency"], task["coupling"])
    run = follow(
        subject, method, h=task["h"], steps=task["steps"], renew=task.get("renew", 0),
        lost=lambda part: not bool(np.abs(part.y).max() < 100),
    )  # fmt: skip
    y = np.real(np.asarray(run.y)).astype(float)
    q1, q2, w, k, p1, p2 = y.T[:6]
    with np.errstate(all="ignore"):
        energy = (p1**2 + p2**2 + q1**2 + w**2 * q2**2) / 2 + k * q1**2 * q2
        error = float(np.abs(energy / energy[0] - 1).max())
        several = method.carried > 1
        size = parasitic_size(run, solution_direction(method)) if several else np.zeros(len(y))
        early = size[1 : max(2, len(size) // 100)].max(initial=0.0)
        growth = float(size.max() / early) if early > 0 else 1.0
    lost = not (run.completed and np.abs(y).max() < 100)
    return {
        "outcome": "lost" if lost else "completed",
        "steps": int(run.steps),
        "growth": _finite(growth),
        "largest": _finite(float(size.max())),
        "energy_error": _finite(error),
        "evaluations": int(run.evaluations),
    }


def _finite(x: float) -> float | None:
    return x if math.isfinite(x) else None


CAMPAIGN_KINDS: Mapping[str, CampaignKind] = {
    kind.name: kind
    for kind in (
        CampaignKind(
            "run",
            ("method", "problem", "steps"),
            ("t_end", "ask", "timed", "repeats", "run_budget", "renew"),
            _run_tasks,
            perform,
            timed=lambda fixed: bool(fixed.get("timed", False)),
            in_fixed=("timed",),
        ),
        CampaignKind(
            "search",
            ("n", "order", "tries"),
            ("nystrom", "outer", "g", "starts", "solved"),
            _survey_tasks,
            survey,
            each=lambda fixed: math.ceil(int(fixed.get("tries", PARCEL)) / PARCEL),
            in_fixed=("tries",),
        ),
        CampaignKind(
            "resonance",
            ("method", "h", "frequency", "steps"),
            ("coupling", "renew"),
            _resonance_tasks,
            resonance,
        ),
    )
}
