"""Ten million steps: whether the energy error and the values carried stay bounded.

The step size is scaled with the number of stages, so that all pairs take equally many force
evaluations in a unit of time. Pairs start from zero values, so that the carried values q_2 and p_2
begin with what the start leaves out: nothing is tuned away. Recorded are the largest energy error
and the largest carried value up to 10^4, 10^5, 10^6 and 10^7 steps.

    python -m campaigns.partitioned.long_runs data/measurements/pairs-long.json
    python -m campaigns.partitioned.long_runs kepler data/measurements/kepler-long.json

The second form runs Kepler's problem with three eccentricities, each method from its default start:
all explicit partitioned methods, the general linear methods of order 6 and 8, Gauss methods and
splittings.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, record_of
from campaigns.order6.compare import METHODS
from campaigns.pages import markdown
from glmref.catalogue.lookup import document, load, names
from glmref.derive.recipes.sources import LOST, in_words
from glmref.engine.outcome import Solution
from glmref.engine.reference import Stepper, apply_finish, apply_start, stepper
from glmref.engine.solve import solve
from glmref.errors import GlmrefError
from glmref.measure.longtime import along
from glmref.method import Method, PartitionedGLM
from glmref.problems import problem
from glmref.problems.model import Problem

STEPS = 10_000_000
#: Steps between samples: no divisor of a period in view.
EVERY = 2503
#: The growth from 10^5 steps to the end that still counts as bounded. A random walk of round-off
#: or a slow beat of the carried values gives a factor of this size; growth in proportion to the
#: time, the slowest that a drift gives, 100.
BOUNDED = 10.0


@dataclass(frozen=True)
class Case:
    """A problem and the time step that belongs to one force evaluation."""

    problem: str
    per_evaluation: float
    parameters: tuple[tuple[str, str], ...] = ()


CASES = (Case("pendulum", 1 / 64, (("q0", "23/10"),)), Case("henon-heiles", 1 / 64))

#: Kepler's problem at step sizes with a relative energy error between 1e-13 and 1e-5 at first.
KEPLER = tuple(
    Case("kepler", per_evaluation, (("eccentricity", eccentricity),))
    for eccentricity, per_evaluation in (("1/10", 0.025), ("3/10", 0.015), ("3/5", 0.006))
)
#: Methods that carry one value, which the others are compared with on Kepler's problem.
ONE_VALUE = (
    *("gauss-3", "gauss-4", "gauss-5", "blanes-moan-rkn-6-11", "blanes-moan-rkn-6-14"),
    *("blanes-moan-6", "kahan-li-8", "suzuki-umeno-8", "yoshida-verlet-6"),
)
#: Step size in units of a case's `per_evaluation`. Explicit methods that are not named have their
#: number of evaluations here, implicit ones 4, so that energy errors are comparable at first.
UNITS: Mapping[str, float] = {
    "gauss-4": 8,
    "gauss-5": 12,
    "blanes-moan-rkn-6-14": 10.4,
    "pair-8-24": 12,
}
#: Steps between new starts, in the runs that start again and again from the solution.
RESTART = 10_000
#: Methods of which such runs are recorded.
RESTARTED = (
    *("pair-6-8", "pair-6-9", "pair-rkn-6-7", "pair-rkn-6-7b", "pair-rkn-6-8b", "pair-rkn-6-9"),
    "g6245-w3",
)
#: Methods that are run ten times as long besides: all their shorter runs are bounded.
FURTHER = ("pair-6-10", "blanes-moan-rkn-6-14", "gauss-3")
#: The parasitic part of a general linear method is formed at the first four samples and then at one
#: of LOOK, because it takes a start in the interpreter; the second is for those of many stages.
LOOK = (10, 100)
MANY = 30


@dataclass(frozen=True)
class Long:
    """One long run."""

    #: What was run.
    pair: str
    problem: str
    h: float
    steps: int
    outcome: str  #: How it ended.
    marks: tuple[int, ...]  #: Numbers of steps.
    #: Largest relative energy error and largest absolute entry of the values 2..r up to each.
    energy: tuple[float, ...]
    carried: tuple[float, ...]

    @property
    def bounded(self) -> bool:
        """Whether neither grew by more than :data:`BOUNDED` in the last two decades.

        Energy errors within a hundred roundings of zero count as round-off; an orbit that is lost
        (:data:`LOST`) before these decades is not bounded.
        """
        if self.steps < self.marks[-1] or not self.energy[-1] <= LOST:
            return False
        floor = 100 * 2.0**-52
        rows = (self.energy, self.carried)
        return all(row[-1] <= BOUNDED * max(row[-3:][0], floor) for row in rows if row)

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types, three digits; ``None`` for what is not finite."""
        rows = {key: [three_digits(x) for x in getattr(self, key)] for key in ("energy", "carried")}
        return {
            "method": self.pair,
            "problem": self.problem,
            "h": self.h,
            "steps": self.steps,
            "outcome": self.outcome,
            "marks": list(self.marks),
            "bounded": self.bounded,
            **rows,
        }


def three_digits(x: float) -> float | None:
    """Round to three digits; ``None`` for what is not finite."""
    return float(f"{x:.2e}") if math.isfinite(x) else None


def pair_names() -> list[str]:
    """Return names of the explicit pairs of the catalogue that carry values."""
    return [x for x in names("methods") if document(x)["class"] == "pair-sweep"]


def step_size(name: str, case: Case) -> float:
    """Return the step size of a method on a case, see :data:`UNITS`."""
    method = load(name)
    own = method.n_Q if isinstance(method, PartitionedGLM) else 4
    return float(f"{case.per_evaluation * UNITS.get(name, own):.6g}")


def follow_pair(name: str, case: Case, steps: int = STEPS, *, start: str | None = "zero") -> Long:
    """Run a pair and record energy and carried values."""
    h = case.per_evaluation * load(name).n_Q  # type: ignore[union-attr]
    return _followed(name, case, h, steps, start=start)


def follow_method(name: str, case: Case, steps: int = STEPS, *, restart: int = 0) -> Long:
    """Run any method from its default start and record energy and carried values.

    The number of steps is a power of ten from 10^4 on, the step size in :data:`UNITS`. With
    ``restart``, a divisor of it, the solution is taken as a new initial value, from which the
    method starts anew, every so many steps. ``carried`` is empty for methods that carry one value,
    and the norm of the parasitic part (:func:`parasitic_size`) for
    general linear methods.
    """
    return _followed(name, case, step_size(name, case), steps, restart=restart)


def follow_at(name: str, case: Case, h: float, steps: int = STEPS, *, restart: int = 0) -> Long:
    """Run a method from its default start at a given step size: :func:`follow_method` else."""
    return _followed(name, case, h, steps, restart=restart)


def _followed(
    name: str, case: Case, h: float, steps: int, *, start: str | None = None, restart: int = 0
) -> Long:
    """Run a method in stretches of `restart` steps, or in one."""
    method, target = load(name), problem(case.problem, **dict(case.parameters))
    length, every = restart or steps, min(EVERY, (restart or steps // 50) // 4)
    taken, energy, carried, done = [], [], [], 0
    part, first = None, None
    while done < steps and (part is None or part.completed):
        here = target if part is None else replace(target, y0=tuple(map(float, part.y[-1])))
        part = solve(here, method, h=h, steps=length, every=every, history=True, start=start)
        energies = along(target.hamiltonian, part.y)  # type: ignore[arg-type]
        first = float(energies[0]) if first is None else first
        taken.append(done + np.round((part.t - target.t_span[0]) / h))
        energy.append(np.abs(energies - first) / abs(first))
        carried.append(_beyond(method, target, part, h))
        done += part.steps
    assert part is not None
    marks = tuple(10**k for k in range(4, 20) if 10**k <= steps)
    at = np.concatenate(taken)
    rows = [
        tuple(float(np.max(np.nan_to_num(row[at <= n], nan=np.inf))) for n in marks)
        for row in (np.concatenate(energy), np.concatenate(carried))
    ]
    if method.r == 1:
        rows[1] = ()
    return Long(name, case.problem, h, done, str(part.outcome), marks, rows[0], rows[1])


def parasitic_size(engine: Stepper, values: np.ndarray, h: float) -> float:
    """Return the norm of ``values - S(F(y_1))`` for values (r, d), start S and finish F."""
    method = engine.method
    y = engine.solution(values)
    with np.errstate(all="ignore"):
        try:
            if method.finishing is not None:
                y, _ = apply_finish(method.finishing, engine, 0.0, y, h)
            assert method.starting is not None
            ideal, _ = apply_start(method.starting, engine, 0.0, y, h)
        except (ArithmeticError, GlmrefError):  # coupled stages without solution: far from all
            return math.inf
        size = float(np.linalg.norm(values[1:] - ideal[1:]))
    return size if math.isfinite(size) else math.inf


def _beyond(method: Method, target: Problem, part: Solution, h: float) -> np.ndarray:
    """Return the size of the values beyond the solution at each sample, (m,); 0 if not formed."""
    history = np.asarray(part.history)
    if isinstance(method, PartitionedGLM) or method.is_one_step:
        return np.abs(history[:, 1:]).max(axis=(1, 2), initial=0.0)
    engine, sizes = stepper(method, target), np.zeros(len(history))
    assert method.starting is not None
    last, look = len(history) - 1, LOOK[len(method.starting.A) > MANY]
    for k in {*range(min(5, last)), *range(0, last, look), last}:
        sizes[k] = parasitic_size(engine, history[k], h)
    return sizes


def pair_row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Carry out :func:`follow_pair` for a task in JSON."""
    return follow_pair(task["method"], case_of(task), task["steps"], start=task["start"]).as_json()


def method_row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Carry out :func:`follow_method` for a task in JSON."""
    return follow_method(
        task["method"], case_of(task), task["steps"], restart=task["restart"]
    ).as_json()


def case_of(task: Mapping[str, Any]) -> Case:
    """Return the case of a task: the fields of :class:`Case` among others."""
    parameters = tuple((str(name), str(value)) for name, value in task["parameters"])
    return Case(task["problem"], task["per_evaluation"], parameters)


NOTE = (
    "Largest relative energy error and largest entry of q_2 and p_2 up to each mark, sampled every "
    f"{EVERY} steps; start from zero values; h = (force evaluations a step)/64; bounded: neither "
    f"grows by more than a factor {BOUNDED:g} from 10^5 to 10^7 steps."
)


def main(path: Path, cases: Sequence[Case] = CASES, steps: int = STEPS) -> None:
    """Measure all pairs on all cases and write the file."""
    tasks = (
        {"method": name, "steps": steps, "start": "zero", **asdict(case)}
        for name in pair_names()
        for case in cases
    )
    runs = carried_out(pair_row, tasks, beside=path)
    title = "Explicit pairs over ten million steps"
    complete(path, record_of("partitioned.long_runs", "pairs-long", title, NOTE, runs=runs))


KEPLER_NOTE = (
    "Largest relative energy error up to each mark, sampled every "
    f"{EVERY} steps; carried: largest entry of q_2 and p_2, for general linear methods the norm of "
    "what the values carried lack to the start of their own solution; each method from its default "
    f"start; bounded: neither grows by more than a factor {BOUNDED:g} in the last two decades of "
    f"steps, and the energy error stays below {LOST:g}. "
    f"restarted: the same, started again from the solution every {RESTART:,} steps. further: ten "
    "times as long."
)


def kepler_methods() -> list[str]:
    """Return names of the methods that are run on Kepler's problem."""
    groups = ("order 6, general linear", "order 8, general linear")
    return [*pair_names(), *(x for group in groups for x in METHODS[group]), *ONE_VALUE]


def labels(record: str) -> dict[str, list[str]]:
    """Return notes of the method files that name a record, by method."""
    found: dict[str, list[str]] = {}
    for name in names("methods"):
        notes = document(name).get("notes", [])
        for note in [notes] if isinstance(notes, str) else notes:
            if record in note:
                found.setdefault(name, []).append(note)
    return found


def kepler(path: Path, cases: Sequence[Case] = KEPLER, steps: int = STEPS) -> None:
    """Run every method of the plan on Kepler's problem, and write the file."""
    plan = [("runs", name, 0, steps) for name in kepler_methods()]
    plan += [("restarted", name, RESTART, steps) for name in RESTARTED]
    plan += [("further", name, 0, 10 * steps) for name in FURTHER]
    tasks = (
        {"method": name, "steps": length, "restart": restart, **asdict(case)}
        for _, name, restart, length in plan
        for case in cases
    )
    found = iter(carried_out(method_row, tasks, beside=path))
    title = "Kepler's problem over ten million steps"
    rows: dict[str, list[dict[str, Any]]] = {key: [] for key, *_ in plan}
    for key, *_ in plan:
        for case in cases:
            eccentricity = str(float(Fraction(dict(case.parameters)["eccentricity"])))
            rows[key].append({"eccentricity": eccentricity, **next(found)})
    command = "partitioned.long_runs kepler"
    complete(path, record_of(command, "kepler-long", title, KEPLER_NOTE, **rows))


def kepler_table(runs: Sequence[Mapping[str, Any]], methods: Sequence[str]) -> str:
    """Return energy errors after 10^5, 10^6, .. steps, one line for each method, in Markdown."""
    orbits = list(dict.fromkeys(run["eccentricity"] for run in runs))
    marks = [n for n in runs[0]["marks"] if n >= 100_000]
    shown = ", ".join(f"$10^{len(str(n)) - 1}$" for n in marks)
    heads = ["method", *(f"e = {e}: {shown}" for e in orbits), "bounded"]
    known, rows = {(run["method"], run["eccentricity"]): run for run in runs}, []
    for name in methods:
        mine = [known[name, e] for e in orbits]
        cells = [", ".join(shown_error(x) for x in run["energy"][-len(marks) :]) for run in mine]
        where = [run["eccentricity"] for run in mine if run["bounded"]]
        verdict = "yes" if len(where) == len(orbits) else f"at {in_words(where)}" if where else "no"
        rows.append([f"`{name}`", *cells, verdict])
    return markdown(heads, rows)


def shown_error(x: float | None) -> str:
    """Return an error in a cell of a table."""
    return "not finite" if x is None else f"{x:.1e}"


if __name__ == "__main__":
    words = arguments(sys.argv[1:])
    if words[0] == "kepler":
        kepler(Path(words[1]))
    else:
        main(Path(words[0]))
