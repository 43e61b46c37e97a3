"""Compare the answers of an adapter for one method of the catalogue with its vectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ..catalogue.lookup import load
from ..engine.reference import stepper
from ..engine.solve import solve
from .adapters.reference import Adapter
from .diagnosis import known_bug, name_defect, residual_of_stages, stage_order, start_order
from .faults import NOTES, wrong_runs
from .subject import AdapterError, NotOffered, Subject
from .vector_problems import TestProblem, array
from .vectors import Case, Vectors
from .verdicts import Judgement, deviation, errors_of, input_judgement, order_judgement, same


class Comparison:
    """Compares the answers of an adapter for one method with its vectors."""

    def __init__(self, subject: Subject, vectors: Vectors) -> None:
        self.subject, self.vectors, self.name = subject, vectors, vectors.name
        self.pair = vectors.method.parts == 2

    def _allowed(self, case: Case) -> float:
        unit = self.subject.unit(self.name) if self._solves else self.subject.epsilon
        return unit * case.number("rounding") + case.number("bound")

    @cached_property
    def _solves(self) -> bool:
        """Whether stage equations are solved: in a step, a start or a finish."""
        ends = [self.vectors.coefficients.get(x) for x in ("starting", "finishing")]
        implicit = any(np.triu(array(x["A"])).any() for x in ends if x is not None)
        method: Any = self.vectors.method
        return implicit or not method.is_explicit

    def _step(self, case: Case) -> np.ndarray:
        return self.subject.step(
            self.name, case.problem.problem, case.number("t"), case.input, case.number("h")
        )

    def answer(self, case: Case) -> Judgement:
        """Check that a step is finite and of the right shape, and leaves its input alone."""
        self._step(case)
        return input_judgement(
            self.subject.leaves_input(
                self.name, case.problem.problem, case.number("t"), case.input, case.number("h")
            )
        )

    def repeatable(self, case: Case) -> Judgement:
        """Check that the same input gives the same output, whatever was asked between."""
        problem, t, h = case.problem.problem, case.number("t"), case.number("h")

        def other() -> object:
            return self.subject.step(self.name, problem, t + 1, case.input + 0.125, h / 2)

        return same(lambda: self._step(case), other, self._allowed(case), "step")

    def repeatable_run(self, case: Case) -> Judgement:
        """Check that two equal runs with another one between them give the same."""

        def other() -> object:
            h, given = case.number("h") / 2, self._given(case)
            return self.subject.solve(self.name, case.problem.problem, h, 2, given)

        return same(lambda: self.run(case), other, self._allowed(case), "solve")

    def stages(self, case: Case) -> Judgement:
        """Compare the stage values with the vectors."""
        expected = case.stages
        shape: Any = tuple(x.shape for x in expected)
        found = self.subject.stages(
            self.name, case.problem.problem, case.number("t"), case.input, case.number("h"), shape
        )
        allowed = self._allowed(case)
        for part, right, letter in zip(
            found, expected, ("Y", "P") if not self.pair else ("Q", "P"), strict=False
        ):
            gap = float(np.abs(part - right).max())
            if gap <= allowed:
                continue
            said = stage_order(part, right, allowed) or self._stage_defect(case, found)
            i, k = np.unravel_index(np.abs(part - right).argmax(), part.shape)
            where = f"component {k + 1} of stage {letter}_{i + 1}"
            return Judgement(False, deviation(where, part[i, k], right[i, k], allowed, said), gap)
        return Judgement(True)

    def _stage_defect(self, case: Case, found: Sequence[np.ndarray]) -> str:
        """Name what is wrong with stage values: unsolved equations, or a known bug of the step."""
        said = ""
        if "step" in self.subject.offers:
            try:
                end = self._step(case)
                said = name_defect(self.subject, self.vectors, case, end, self._allowed(case))
            except (AdapterError, NotOffered):
                said = ""
        if said:
            return said
        if not self.pair:
            residual = residual_of_stages(self.vectors, case, found)
            if residual > self._allowed(case):
                return f"the stage equations are left with a residual of {residual:.2g}"
        return ""

    def step(self, case: Case) -> Judgement:
        """Compare the values after one step with the vector."""
        return self._agree(case, self._step(case), case["output"], "value")

    def conserved(self, case: Case) -> Judgement:
        """Check that ten steps conserve the quadratic form.

        Values of size m carry relative errors of some (u + v) rounding each step, and the form is
        quadratic in them: its change is below ``10 * 2 |G| |C| m`` times that.
        """
        assert case.problem.quadratic is not None
        blocks = self.vectors.coefficients
        G = array(blocks["G"]) if "G" in blocks else np.ones((1, 1))
        C, values, h = array(case.problem.quadratic), case.input, case.number("h")
        problem, t = case.problem.problem, case.number("t")
        rows = [x for _, x in self.subject.steps(self.name, problem, t, values, h, 10)]
        before, largest = _form(G, C, values), np.abs(rows).max()
        weight = 20 * np.abs(G).sum() * np.abs(C).sum() * largest
        allowed = weight * self._allowed(case)
        gap = abs(_form(G, C, rows[-1]) - before)
        if gap <= allowed:
            return Judgement(True, residual=gap)
        return Judgement(
            False,
            f"the form sum G_ij y_i^T C y_j is {before:.15g} and changes by {gap:.2g} in ten "
            f"steps; rounding explains {allowed:.2g}: the method conserves it, the code does not",
            gap,
        )

    def start(self, case: Case) -> Judgement:
        """Compare the starting values with those of the vector."""
        expected = case["output"]
        found = self.subject.start(
            self.name, case.problem.problem, case.number("h"), expected.shape
        )
        return self._agree(case, found, expected, "starting value")

    def finish(self, case: Case) -> Judgement:
        """Compare the finished solution with the vector."""
        t, h = case.number("t"), case.number("h")
        found = self.subject.finish(self.name, case.problem.problem, t, case.input, h)
        return self._agree(case, found[None, :], case["output"], "finished solution")

    def _agree(self, case: Case, found: np.ndarray, right: np.ndarray, what: str) -> Judgement:
        allowed = self._allowed(case)
        gap = float(np.abs(found - right).max())
        if gap <= allowed:
            return Judgement(True, residual=gap)
        k, i = np.unravel_index(np.abs(found - right).argmax(), found.shape)
        said = name_defect(self.subject, self.vectors, case, found, allowed)
        if not said and case.kind == "start":
            said = start_order(self.subject, self.vectors, case.problem).removeprefix("; ")
        where = f"component {i + 1} of {what} {k + 1}"
        return Judgement(False, deviation(where, found[k, i], right[k, i], allowed, said), gap)

    # --- runs -----------------------------------------------------------------------------------

    @property
    def own(self) -> bool:
        """Whether runs begin from starting values that the adapter makes itself.

        It says so, or its ``solve`` takes no ``start`` where the data give starting values.
        """
        if "solve" not in self.subject.offers:
            return False
        given = any("input" in x.data for x in self.vectors.cases if x.kind == "trajectory")
        return self.subject.starts == "own" or (given and not self.subject.takes_start)

    def _given(self, row: Case | Mapping[str, Any]) -> np.ndarray | None:
        """Return the starting values given to a run; none where the adapter makes its own."""
        if self.own:
            return None
        data = row.data if isinstance(row, Case) else row
        return array(data["input"]) if "input" in data else None

    def run(self, case: Case) -> np.ndarray:
        """Return the solution at every step, or at the end only."""
        return self._solution(
            case.problem, case.number("h"), int(case.data["steps"]), self._given(case)
        )

    def _solution(
        self, task: TestProblem, h: float, steps: int, given: np.ndarray | None
    ) -> np.ndarray:
        subject, problem = self.subject, task.problem
        if "solve" in subject.offers:
            return subject.solve(self.name, problem, h, steps, given)
        begin = self._started(task, h, given)
        rows = subject.steps(self.name, problem, float(task.t0), begin, h, steps)
        return np.array([self._finished(task, t, values, h) for t, values in rows])

    def _started(self, task: TestProblem, h: float, given: np.ndarray | None) -> np.ndarray:
        """Return starting values: given, the adapter's, or ours where it has none."""
        if given is not None:
            return given
        r = int(self.vectors.document["values"])
        y0 = array(task.y0)
        if r == 1:
            return y0[None, :]
        if "start" in self.subject.offers:
            return self.subject.start(self.name, task.problem, h, (r, len(y0)))
        return _ours(self.name).start(self.name, task.problem, h)

    def _finished(self, task: TestProblem, t: float, values: np.ndarray, h: float) -> np.ndarray:
        if getattr(self.vectors.method, "finishing", None) is None:
            return values[0]
        if "finish" in self.subject.offers:
            return self.subject.finish(self.name, task.problem, t, values, h)
        return _ours(self.name).finish(self.name, task.problem, t, values, h)

    def trajectory(self, case: Case) -> Judgement:
        """Compare the solution with the vector at every step that is shown."""
        found, right = self.run(case), case["solution"]
        right = right if len(found) > 1 else right[-1:]
        allowed = self._allowed(case)
        gaps = np.abs(found - right).max(axis=1)
        if gaps.max() <= allowed:
            return Judgement(True, residual=float(gaps.max()))
        said = known_bug(found[-1:], case, allowed) or self._bug_of_run(case, found[-1:], allowed)
        n = int(np.argmax(gaps > allowed))
        said = said or name_defect(self.subject, self.vectors, case, found[-1:], allowed)
        i = int(np.abs(found[n] - right[n]).argmax())
        step = n if len(found) > 1 else int(case.data["steps"])
        where = f"component {i + 1} of the solution after {step} steps"
        message = deviation(where, found[n, i], right[n, i], allowed, said)
        return Judgement(False, message, float(gaps.max()))

    def _bug_of_run(self, case: Case, found: np.ndarray, allowed: float) -> str:
        """Name the usual bug that gives this end of a run, or ``""``.

        The vectors hold the results that differ by a million rounding errors; those of accurate
        methods are nearer, and are computed here.
        """
        method: Any = self.vectors.method  # not additive: those have no vectors
        problem, h = case.problem.problem, case.number("h")
        try:
            values = self._started(case.problem, h, self._given(case))
        except (AdapterError, NotOffered):
            return ""
        t0, steps = float(case.problem.t0), int(case.data["steps"])
        right, engine = case["solution"][-1:], stepper(method, problem)
        for wrong in wrong_runs(engine, method, problem, t0, values, h, steps):
            near = np.abs(wrong.values - found).max() <= 2 * allowed
            if near and np.abs(wrong.values - right).max() > 4 * allowed:
                return f"it is the result of this bug: {NOTES[wrong.flag][0]} ({wrong.flag})"
        return ""

    def order(self, case: Case) -> Judgement:
        """Return the error falls with the order of the method."""
        right, end = int(case.data["order"]), float(case.data["t_end"])
        given = {int(row["steps"]): self._given(row) for row in case.data["rows"]}

        def run(steps: int) -> np.ndarray:
            h = (end - case.number("t")) / steps
            return self._solution(case.problem, h, steps, given[steps])[-1]

        shown_by = {int(row["steps"]): float(row["error"]) for row in case.data["rows"]}

        def judged() -> Judgement:
            steps, errors = errors_of(run, list(given), case["exact"])
            return order_judgement(steps, errors, right, self.subject, self.name, shown_by)

        found = judged()
        if found.holds is None and not any(x is not None for x in given.values()):
            finest = max(given)
            given |= dict.fromkeys((2 * finest, 4 * finest, 8 * finest))
            found = judged()
        if found.holds is False and self.own and self._carried > 1 and isinstance(found.value, int):
            message = (
                f"{found.message}; the run starts by itself: a method of order {right} needs "
                f"starting values of that order, and these give order {found.value}"
            )
            return replace(found, message=message)
        return found

    @property
    def _carried(self) -> int:
        return int(self.vectors.document["values"])

    def long(self, task: TestProblem) -> Judgement:
        """Return a long run from the adapter's own start keeps a quadratic invariant as ours does.

        The form sum G_ij y_i^T C y_j is conserved exactly, so that y^T C y of the solution moves by
        what the other values hold. A start of too low an order leaves something in them for the
        whole run, even where the error at one end still falls with the order of the method. A
        start that is right moves the invariant by O(h^(p+1)) more than ours, which is below the
        drift of the method itself, O(h^p): the ratio of the two drifts tends to 1. It is refused
        above :data:`_DRIFT` at two step sizes.
        """
        assert task.quadratic is not None
        C, ratios, drifts = array(task.quadratic), [], []
        for steps in _LONG:
            h = _TIME / steps
            mine, found = self._sampled(task, h, steps)
            right, moved = _drift(C, mine), _drift(C, found)
            if not right < _LOST:
                continue
            ratios.append(moved / (right + steps * 30 * self.subject.unit(self.name)))
            drifts.append(f"{moved:.2g} at h = {h:g} (ours {right:.2g})")
        if not ratios:
            return Judgement(None, f"not judged: the method itself does not keep {task.name}")
        if min(ratios) <= _DRIFT:
            return Judgement(True, residual=min(ratios))
        return Judgement(
            False,
            f"in {_TIME:g} time units the quadratic invariant moves by {', '.join(drifts)}, "
            f"{min(ratios):.2g} times as much as from starting values of the right order: what the "
            f"own start leaves in values 2 to r stays there{self._start_order(task)}",
            min(ratios),
        )

    def _sampled(self, task: TestProblem, h: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """Return our run and the adapter's: every step, or the beginning and eight ends."""
        mine = _our_run(self.name, task.problem, h, steps)
        found = self.subject.solve(self.name, task.problem, h, steps)
        if len(found) > 1:
            return mine, found
        counts = range(steps - 7, steps)
        ends = [self.subject.solve(self.name, task.problem, h, n)[-1] for n in counts]
        return mine[[0, *counts, steps]], np.array([array(task.y0), *ends, found[0]])

    def _start_order(self, task: TestProblem) -> str:
        """Name the order of starting values that the adapter shows, or ``""``."""
        if "start" not in self.subject.offers:
            return ""
        return start_order(self.subject, self.vectors, task)


#: Long runs: time, numbers of steps, the ratio of drifts that is too much, and a drift that says
#: that the method itself is lost.
_TIME, _LONG, _DRIFT, _LOST = 100.0, (250, 500), 3.0, 0.1


def _drift(C: np.ndarray, rows: np.ndarray) -> float:
    """Return the largest change of y^T C y along a run, relative to the sizes of its terms."""
    values = np.einsum("na,ab,nb->n", rows, C, rows)
    scale = np.einsum("na,ab,nb->n", np.abs(rows), np.abs(C), np.abs(rows)).max()
    return float(np.abs(values - values[0]).max() / scale)


def _our_run(name: str, problem: Any, h: float, steps: int) -> np.ndarray:
    """Return the solution at every step, from the method's own start or the enhanced one."""
    return np.asarray(solve(problem, load(name), h=h, steps=steps, every=1).y, dtype=float)


def _ours(name: str) -> Any:
    """Return our own start and finish, for adapters that have none."""
    return Adapter((name,))


def _form(G: np.ndarray, C: np.ndarray, values: np.ndarray) -> float:
    return float(np.einsum("ij,ia,ab,jb->", G, values, C, values))
