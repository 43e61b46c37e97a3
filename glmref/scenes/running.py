"""Carry out the tasks of a plan, one after another; whatever happens, a task ends in a record."""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue.lookup import load
from ..compute import Done, Executor, Limits, Records
from ..compute.child import MEMORY
from ..compute.executors import Here
from ..compute.records import in_json, made
from ..engine.outcome import Outcome, StartFailed
from ..errors import GlmrefError
from ..measure.law import fit_law, samples_of
from ..measure.limits import stable_step
from ..measure.longtime import energy_deviation, follow, quantities, watch
from ..measure.orbit import orbit
from ..measure.parasitic import loss, modes, parasitic_size, solution_direction
from ..measure.peers import measure_peer
from ..measure.prediction import LOST as EXPECTED_LOSS
from ..measure.prediction import SATURATES, predict
from ..measure.timing import circumstances, machine
from ..measure.work_precision import (
    judged_state,
    measure,
    of_run,
    timed_runs,
)
from ..problems.model import Problem
from ..problems.user_functions import FunctionFailed
from .model import TIMED, Scene, subject_of
from .planning import SAMPLED, Plan, plan

#: The engine's, which a right-hand side that fails at the very start has here too.
FUNCTION_FAILED = str(Outcome.FUNCTION_FAILED)
#: Outcomes a scene adds to those of the engine.
BUDGET_SPENT = "budget spent"
FAILED = "internal error"
LOST = "lost"
NOT_APPLICABLE = "not applicable"
#: Not enough memory, a library that cannot be loaded: the task may end otherwise elsewhere.
SYSTEM_REFUSED = "system refused"
START_FAILED = "start failed"

#: Seconds that a task may take besides its runs: to compile, to compute a reference.
PATIENCE = 600.0
#: Points kept of a curve over time.
POINTS = 60
#: Values of a curve at the most: a deviation beyond it says nothing more.
BEYOND = 1e6


def run(
    scene: Scene | Plan,
    store: Records | None = None,
    *,
    advance: Callable[[Mapping[str, Any], Mapping[str, Any]], None] | None = None,
    on: Executor | None = None,
) -> list[dict[str, Any]]:
    """Measure what the store does not hold yet, and return the records of all tasks in order.

    ``advance`` is called after each new record with the task and the record. Each record is on the
    disk before it counts, so that a killed run loses the tasks that run. While tasks are missing
    the store's lock is held: a second run of the same scene into the same folder is refused. A task
    that the system refuses (no memory, a library that cannot be loaded) has a record in memory
    only, and is tried again by the next run. Where the scene asks for run times, each task of other
    processes has a core of its own.

    Raises
    ------
    UsageError
        Where another process measures the same, or a record cannot be written.
    """
    todo = scene if isinstance(scene, Plan) else plan(scene)
    store = Records(None) if store is None else store
    if any(True for _ in store.missing(todo.tasks)):
        with store.exclusive():
            missing = list(store.missing(todo.tasks))
            for results in (on or Here()).run(perform, missing, limits_of(todo.scene)):
                for task, record in _kept(store, results):
                    if advance is not None:
                        advance(task, record)
    found = (store.find(task) for task in todo.tasks)
    return [record for record in found if record is not None]


def limits_of(scene: Scene) -> Limits:
    """Return the limits of a task; it ends by itself unless a function of the user hangs."""
    patient = PATIENCE + 20 * scene.budget * scene.repeats
    return Limits(seconds=patient, pinned=scene.answer.kind in TIMED)


def mixed_machines(scene: Scene, records: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the sentence on run times taken on several kinds of machines, if they were."""
    kinds = Counter(
        machine(x["where"])
        for x in records
        if "seconds" in x and isinstance(x.get("where"), Mapping)
    )
    if len(kinds) < 2 or scene.answer.kind not in TIMED:
        return []
    listed = "; ".join(f"{count} on {kind}" for kind, count in kinds.most_common())
    sentence = (
        f"the run times are not of one kind of machine ({listed}), so that they do not compare; "
        f"move the records away to measure all of them on one"
    )
    return [sentence]


def _kept(
    store: Records, results: Iterable[tuple[Mapping[str, Any], Done]]
) -> Iterator[tuple[Mapping[str, Any], dict[str, Any]]]:
    """Keep what tasks gave, in memory alone where another machine could do better."""
    rows = [(task, _record(done)) for task, done in results]
    lasting = [row for row in rows if row[1]["outcome"] != SYSTEM_REFUSED]
    yield from zip([task for task, _ in lasting], store.append_all(lasting), strict=True)
    for task, measured in rows:
        if measured["outcome"] == SYSTEM_REFUSED:
            record = made(task, measured)
            store.remember(record)
            yield task, record


def _record(done: Done) -> dict[str, Any]:
    record = done.as_record()
    return record | {"outcome": SYSTEM_REFUSED} if done.failure == MEMORY else record


def perform(task: Mapping[str, Any]) -> dict[str, Any]:
    """Carry out one task; errors become outcomes with one sentence.

    Raises
    ------
    KeyboardInterrupt
        When the user stops the run, and nothing else.
    """
    file = task.get("file")
    if file and not Path(file).is_file():
        message = f"there is no file {file} where the task runs; a cluster needs a shared folder"
        return {"outcome": SYSTEM_REFUSED, "message": message, "where": circumstances()}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # overflow in a run that blows up is an outcome
            measured = _peer(task) if task["kind"] == "peer" else _method(task)
    except FunctionFailed as error:
        measured = {"outcome": FUNCTION_FAILED, "message": str(error)}
    except StartFailed as error:
        measured = {"outcome": START_FAILED, "message": str(error)}
    except GlmrefError as error:
        measured = {"outcome": NOT_APPLICABLE, "message": str(error)}
    except MemoryError:
        measured = {"outcome": SYSTEM_REFUSED, "message": "the memory did not suffice"}
    except Exception as error:
        message = f"{type(error).__name__}: {error}"
        outcome = SYSTEM_REFUSED if isinstance(error, OSError | ImportError) else FAILED
        measured = {
            # what a Python function of the user's does is not ours to answer for
            "outcome": FUNCTION_FAILED if _given_by_user(_subject(task)) else outcome,
            "message": message,
        }
    return {**measured, "where": circumstances()}


def _given_by_user(problem: Problem) -> bool:
    """Return whether a right-hand side or Jacobian is a Python function."""
    functions = (problem.f, problem.dq, problem.dp, problem.jacobian)
    return any(f is not None and not hasattr(f, "on") for f in functions)


def _check_function(problem: Problem) -> None:
    """Evaluate f once where it is a Python function: it must return d real numbers.

    Raises
    ------
    TypeError, ValueError
        For a result that is none.
    """
    if not _given_by_user(problem):
        return
    slope = np.asarray(problem.f(float(problem.t_span[0]), np.array(problem.y0, dtype=float)))
    if slope.dtype.kind not in "fiub":
        raise TypeError(f"f must return real numbers, got an array of {slope.dtype}")
    if slope.shape != (problem.dimension,):
        raise ValueError(
            f"f must return an array of shape {(problem.dimension,)}, got {slope.shape}"
        )


def _method(task: Mapping[str, Any]) -> dict[str, Any]:
    method = load(task["file"] or task["method"])
    subject = _subject(task)
    _check_function(subject)
    questions = set(task["ask"])
    record = (_long if SAMPLED & questions else _short)(task, method, subject)
    if "orbit" in questions:
        record |= _orbit(task, method, subject, record)
    if "limit" in questions:
        limit = stable_step(subject, method, t_end=task["t_end"])
        if limit is not None:
            record["limit"] = "none" if math.isinf(limit) else limit
    return record


def _orbit(
    task: Mapping[str, Any], method: Any, subject: Any, record: Mapping[str, Any]
) -> dict[str, Any]:
    """Take the steps once more, as many as there were, for the path: it is never timed."""
    if not record["steps"]:
        return {}
    path = orbit(
        subject,
        method,
        steps=record["steps"],
        **_taken(task),
    )
    block = path.as_json()
    if block["ended"] is None and record["outcome"] != "completed":
        block["ended"] = f"{record['outcome']} after t = {record['t_end']:.6g}"
    return {"orbit": block}


def _short(task: Mapping[str, Any], method: Any, subject: Any) -> dict[str, Any]:
    """Return one run, timed, that answers about the error of the state and of the energy."""
    work = measure(
        subject,
        method,
        steps=task["steps"],
        **_taken(task),
        **_asked(task),
    )
    return _spent(work.as_json(), task)


def _taken(task: Mapping[str, Any]) -> dict[str, Any]:
    """Return how the steps of a task are taken, as arguments of what follows or measures a run."""
    return {"h": task["h"], "start": task["start"], "renew": task.get("renew", 0)}


def _asked(task: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is asked of a timed run, as arguments of what measures it."""
    ask = [q for q in task["ask"] if q in ("state", "energy")]
    return {"ask": ask, "repeats": task["repeats"], "budget": task["budget"]}


def _subject(task: Mapping[str, Any]) -> Any:
    return subject_of(task["problem"], task["parameters"], task.get("definition"))


def _spent(record: dict[str, Any], task: Mapping[str, Any]) -> dict[str, Any]:
    """Name a run that its budget ended."""
    if record["outcome"] == "cancelled":
        record["outcome"] = BUDGET_SPENT
        record["message"] = (
            f"stopped after {task['budget']:g} s at step {record['steps']} of {task['steps']}; "
            f"raise `budget` or ask for fewer steps"
        )
    return record


def _long(task: Mapping[str, Any], method: Any, subject: Any) -> dict[str, Any]:
    """Return one sampled run that answers about invariants and parasitic parts."""
    u, asked = solution_direction(method), set(task["ask"])
    solution, record = _sampled(task, method, subject, u)
    if "invariants" in asked:
        G = _form(method)
        drifts = watch(subject, solution, G=G)
        record["drifts"] = [one.as_json() for one in drifts]
        record["series"] = _kept_series(subject, solution, G)
    if "energy" in asked and subject.hamiltonian is not None:
        deviation = energy_deviation(subject, np.real(np.asarray(solution.y)).astype(float))
        record["energy_error"] = in_json(float(np.max(deviation)))
    if "state" in asked and solution.completed and solution.steps == task["steps"]:
        notices = record.get("notices", ())
        record |= judged_state(subject, solution.y[-1], float(solution.t[-1]), notices)
    if "law" in asked:
        record |= _law(method, subject, solution)
    if "parasitic" in asked:
        record |= _parasitic(task, method, subject, solution, u)
    return _spent(record, task)


def _sampled(
    task: Mapping[str, Any], method: Any, subject: Any, u: Any
) -> tuple[Any, dict[str, Any]]:
    """Run as often as asked: a solution, with samples, and what every record has."""
    parasitic = "parasitic" in task["ask"]
    stop = (lambda part: loss(subject, part, u).time is not None) if parasitic else None
    solution, timing = timed_runs(
        lambda deadline: follow(
            subject, method, steps=task["steps"], **_taken(task), cancel=deadline, lost=stop
        ),
        task["repeats"],
        task["budget"],
    )
    record = of_run(method, subject, task["h"], solution) | {"seconds": timing}
    return solution, in_json(record)


def _law(method: Any, subject: Any, solution: Any) -> dict[str, Any]:
    """Return the law by which the first conserved quantity deviates, and how far over time."""
    known = ("energy",) if subject.hamiltonian is not None else ()
    quantity = (*known, *subject.quadratic, *subject.invariants)[0]
    deviation = samples_of(subject, method, solution, quantity)
    t = np.asarray(solution.t, dtype=float)
    law = fit_law(t, deviation, ended=not solution.completed)
    return {
        "law": {"quantity": quantity, **law.as_json()},
        "series": _thinned(t, np.abs(deviation)),
    }


def _form(method: Any) -> Any:
    """Return the form G of a GLM with several values as floats, or ``None``.

    The form of a pair is another one.
    """
    return method.to_float().G if len(method.components) == 1 and method.r > 1 else None


def _parasitic(
    task: Mapping[str, Any], method: Any, subject: Any, solution: Any, u: Any
) -> dict[str, Any]:
    """Return when the run was lost, when that is predicted, and the size of the rest over time."""
    found = loss(subject, solution, u)
    size = parasitic_size(solution, u) / (float(np.linalg.norm(solution.y[0])) or 1.0)
    record: dict[str, Any] = {
        "lost": found.time,
        "reason": found.reason,
        "largest": found.largest if math.isfinite(found.largest) else None,
        "series": _thinned(np.asarray(solution.t, dtype=float), size),
    }
    if found.time is not None:
        record["outcome"] = LOST
        record["message"] = f"lost at t = {found.time:.6g}: {found.reason}"
    if not task.get("renew"):
        said = predict(method, subject, task["h"], task["t_end"], start=task["start"])
        record["predicted"] = said.time if said.verdict == EXPECTED_LOSS else None
        if said.verdict == SATURATES:
            record["saturates"] = said.level
    if len(method.components) == 1:
        record["growth"] = [
            {"zeta": [m.zeta.real, m.zeta.imag], "mu": [m.mu.real, m.mu.imag]}
            for m in modes(method)
        ]
    return record


def _thinned(t: Any, values: Any) -> list[list[float]]:
    """Return the running maximum at points spread over log t, while positive and below BEYOND."""
    with np.errstate(invalid="ignore"):
        inside = (t > 0) & (np.maximum.accumulate(values) <= BEYOND)
    t, values = t[inside], np.maximum.accumulate(values[inside]) if inside.any() else values[inside]
    if not len(t):
        return []
    marks = np.unique(np.searchsorted(t, np.geomspace(t[0], t[-1], POINTS)).clip(max=len(t) - 1))
    return [[float(t[k]), float(values[k])] for k in marks if values[k] > 0]


def _kept_series(subject: Any, solution: Any, G: Any) -> list[list[float]]:
    """Return the largest relative deviation of what the method should keep, over time."""
    kind = ("quadratic" if G is None else "form") if subject.quadratic else "hamiltonian"
    t = np.asarray(solution.t, dtype=float)
    worst = np.zeros(len(t))
    for _, which, values, scale in quantities(subject, solution, G=G):
        if which == kind:
            worst = np.maximum(worst, np.abs(values - values[0]) / (scale or 1.0))
    return _thinned(t, worst)


def _peer(task: Mapping[str, Any]) -> dict[str, Any]:
    subject = _subject(task)
    return measure_peer(
        task["peer"],
        subject,
        tolerance=task["tolerance"],
        t_end=task["t_end"],
        **_asked(task),
    )
