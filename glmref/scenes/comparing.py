"""One problem, the best candidates for its kind, and which of them to take.

For each method the step size is sought at which the error at the end of the run reaches the
tolerance; every run on the way is a point of the picture. What is measured is
:func:`..measure.work_precision.measure`; nothing is measured here.

The recommendation is the fastest method that reaches the tolerance, among those whose file records
no growth on long runs; on a Hamiltonian problem the symplectic ones come first.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..catalogue.advice import (
    BOUNDED,
    DRIFTS,
    GROWS,
    LOST,
    MEANINGS,
    OBSERVED,
    PREDICTED,
    RECORDED,
    UNKNOWN,
    WATCHED,
    candidates,
    long_runs,
)
from ..catalogue.claims import NYSTROM_ORDER, stated_orders
from ..catalogue.lookup import document, is_broken, load, names
from ..engine.kept import expressed
from ..engine.outcome import Outcome
from ..engine.parasites import watched
from ..engine.solve import solve
from ..engine.starting_values import renewal_of
from ..errors import GlmrefError, UsageError
from ..measure.prediction import BOUNDED as EXPECTED_BOUND
from ..measure.prediction import LOST as EXPECTED_LOSS
from ..measure.prediction import SATURATES, predict
from ..measure.work_precision import measure, reference_state
from ..method import Method
from ..problems import Problem, from_path
from ..problems import problem as shipped_problem
from ..problems.canonical import constant_matrix
from ..problems.formula import Formula
from ..system.arguments import number, one_of
from ..system.terminal import saying
from ..views.chart import Series, svg
from ..views.tables import Style, columns
from .answers import duration, seconds_at

if TYPE_CHECKING:
    from ..measure.work_precision import Work

_WORDS = {
    "second order": "Hamiltonian with quadratic kinetic energy",
    "separable": "separable Hamiltonian",
    "Hamiltonian": "Hamiltonian, not separable",
    "semi-separable": "q' = f(p), p' = g(q, p), where forces only turn velocities",
    "general": "not Hamiltonian",
}

#: Runs of one method at the most, and the factor by which the number of steps grows between two.
MOST_RUNS = 9
_LEAST_FACTOR, _MOST_FACTOR = 1.5, 4.0
#: Steps of the first run per typical time of the problem.
_FIRST, _MOST_FIRST = 4, 100_000
_MOST_STEPS = 20_000_000
#: Steps of the long runs that the labels are about.
MOST_PREDICTED = 10_000_000
#: Steps over which a run is watched, a fraction of a second, where nothing can be predicted.
MOST_WATCHED = 1_000_000
_KEPT = (RECORDED, PREDICTED, OBSERVED)
#: Of products of a few sums of doubles, over the largest factors.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Candidate:
    """One method of a comparison."""

    method: str
    order: int | None  #: As claimed; of Nyström kind where the kinetic energy is quadratic.
    #: ``"bounded"``: one value, symplectic; ``"lost"`` and ``"predicted as bounded"``:
    #: :func:`glmref.predict` says so at h; ``"lost"`` and ``"observed as bounded"``: a notice of a
    #: watched run of a million steps, or none; ``"lost"``, ``"grows"``, ``"watched"`` and
    #: ``"recorded as bounded"``: the file records it; ``"drifts"``: not symplectic; ``"not
    #: recorded"``.
    long_runs: str
    #: Of the cheapest run that reaches the tolerance; ``None`` where none does.
    h: float | None = None
    steps: int | None = None
    error: float | None = None
    energy_error: float | None = None
    seconds: float | None = None
    evaluations: int | None = None
    message: str = ""  #: Why there is none.
    works: tuple[Work, ...] = ()  #: All runs, coarsest first.
    #: Steps after which these runs renewed the values, 0 for never: see :func:`glmref.solve`.
    renew: int = 0

    @property
    def reached(self) -> bool:
        """Whether some run reaches the tolerance."""
        return self.seconds is not None

    @property
    def fit_for_long_runs(self) -> bool:
        """Whether neither prediction nor the file of the method says that it grows."""
        return self.long_runs not in (LOST, GROWS)


@dataclass(frozen=True)
class Comparison:
    """Error against run time of several methods on one problem, and a recommendation.

    Attributes
    ----------
    problem, kind : str
        What was solved, and which of its structure is used.
    t_end, tolerance : float
        End of the runs, and the relative error to reach.
    error : str
        ``"state"``: at the end; ``"energy"``: the largest of H, where no reference is good enough.
    reference : str
        What the error was measured against, with its bound.
    candidates : tuple of Candidate
        Fastest first; those that miss the tolerance last.
    recommended : str or None
        The method to take.
    reason : str
        Why, in one or two sentences.
    """

    problem: str
    kind: str
    t_end: float
    tolerance: float
    error: str
    reference: str
    candidates: tuple[Candidate, ...]
    recommended: str | None
    reason: str

    def __repr__(self) -> str:
        return self.table()

    def table(self, style: Style | None = None) -> str:
        """Return the comparison as a text table with the recommendation below."""
        best = next((c.seconds for c in self.candidates if c.seconds is not None), None)
        rows = []
        for one in self.candidates:
            order = "-" if one.order is None else str(one.order)
            if one.seconds is None or one.error is None or best is None:
                rows.append([one.method, order, *["-"] * 5, one.long_runs])
                continue
            cells = [f"{one.h:.4g}", f"{one.error:.1e}", f"{one.evaluations:,}"]
            cells += [duration(one.seconds), f"{one.seconds / best:.2f}"]
            rows.append([one.method, order, *cells, one.long_runs])
        head = ("method", "order", "h", "error", "evaluations", "time", "ratio", "long runs")
        title = (
            f"{self.problem} ({self.kind}), t to {self.t_end:g}: relative error in the "
            f"{self.error}, tolerance {self.tolerance:g}; {self.reference}"
        )
        lines = [
            title,
            "",
            columns(rows, style=style or Style(), head=head),
        ]
        missed = [one for one in self.candidates if not one.reached]
        lines += [f"{one.method}: {one.message}" for one in missed]
        lines += ["", *self._legend()]
        return "\n".join([*lines, "", f"take {self.recommended or 'none of these'}: {self.reason}"])

    def _legend(self) -> list[str]:
        """Return what the words of the last column mean, as far as they occur."""
        met = dict.fromkeys(one.long_runs for one in self.candidates)
        told = [f"{word}: {MEANINGS[word]}" for word in met if word in MEANINGS]
        renewed = sorted({one.renew for one in self.candidates if one.renew})
        told += [
            f"renew={steps}: the values carried are computed from the solution again after every "
            f"{steps:,} steps, glmref.solve(..., renew={steps}); see docs/choose.md"
            for steps in renewed
        ]
        return told

    @property
    def series(self) -> tuple[Series, ...]:
        """Error against seconds, one line for each method."""
        return self._lines(lambda work: work.seconds.median)

    @property
    def evaluation_series(self) -> tuple[Series, ...]:
        """Error against right-hand-side evaluations, one line for each method."""
        return self._lines(lambda work: float(work.evaluations))

    def _lines(self, cost: Callable[[Work], float]) -> tuple[Series, ...]:
        return tuple(
            Series(
                one.method,
                tuple((cost(work), _error(work, self.error) or 0.0) for work in one.works),
                tuple(f"h = {work.h:.4g}" for work in one.works),
            )
            for one in self.candidates
            if one.works
        )

    def svg(self, *, against: str = "seconds") -> str:
        """Return the picture: error against ``"seconds"`` or ``"evaluations"``."""
        one_of("against", against, ("seconds", "evaluations"))
        label = "seconds" if against == "seconds" else "right-hand-side evaluations"
        return svg(
            self.series if against == "seconds" else self.evaluation_series,
            title=f"{self.problem}, t to {self.t_end:g}", x_label=label,
            y_label=f"relative error in the {self.error}",
        )  # fmt: skip

    def _repr_html_(self) -> str:
        return f"<pre>{self.table()}</pre>{self.svg()}"

    def as_json(self) -> dict[str, Any]:
        """Return everything in JSON's types."""
        keys = ("problem", "kind", "t_end", "tolerance", "error", "reference", "recommended")
        record: dict[str, Any] = {"format": "glmref-compare-1"}
        record |= {key: getattr(self, key) for key in (*keys, "reason")}
        record["candidates"] = [
            {k: getattr(one, k) for k in one.__dataclass_fields__ if k != "works"}
            | {"works": [work.as_json() for work in one.works]}
            for one in self.candidates
        ]
        return record


def kind_of(problem: Problem) -> str:
    """Return which candidates fit a problem: a ``kind`` of :data:`..catalogue.advice.ADVICE`."""
    split = problem if problem.separable else problem.extended
    if split is not None and split.second_order:
        return "second order"
    if split is not None:
        half = split.dimension // 2
        linear = isinstance(split.dq, Formula) and constant_matrix(split.dq, 0, half)
        return "second order" if linear else "separable"
    if problem.canonical:
        return "Hamiltonian"
    return "semi-separable" if _turns(expressed(problem)) else "general"


def _turns(problem: Problem) -> bool:
    """Return whether a system is q' = f(p), p' = g(t, q, p) with f_p^T g_p skew near the start.

    So it is for magnetic and Coriolis forces, also with f(p) = p/gamma: forces that depend on p do
    no work. The equation is exact, so that at eight states it holds to rounding or not at all.
    """
    if not problem.semi_separable or problem.jacobian is None:
        return False
    m, y0 = problem.dimension // 2, np.asarray(problem.y0, dtype=float)
    states = y0 + 0.1 * np.abs(y0).max() * np.random.default_rng(1).normal(size=(8, 2 * m))
    with np.errstate(all="ignore"):
        J = np.array([problem.jacobian(float(problem.t_span[0]), y) for y in states], dtype=float)
    J = J[np.isfinite(J).all(axis=(1, 2))]
    f_p, g_p = J[:, :m, m:], J[:, m:, m:]
    work = np.swapaxes(f_p, 1, 2) @ g_p
    scale = np.abs(f_p).max(initial=0.0) * np.abs(g_p).max(initial=0.0)
    return len(J) > 0 and bool(np.abs(work + np.swapaxes(work, 1, 2)).max() <= _ROUNDING * scale)


def compare(
    problem: Problem | str | Path, *, methods: Sequence[Any] | None = None,
    tolerance: float = 1e-9, t_end: float | None = None, budget: float = 45.0,
) -> Comparison:  # fmt: skip
    """Measure error against run time on a problem and recommend a method.

    Parameters
    ----------
    problem : Problem, str or Path
        A problem, the name of a shipped one, or a TOML file with one.
    methods : sequence, optional
        Methods by name, file or as objects; by default those of :mod:`glmref.catalogue.advice`.
    tolerance : float
        Relative error to reach.
    t_end : float, optional
        End of the runs, by default that of the problem.
    budget : float
        Seconds for all runs together, compilation included.

    Raises
    ------
    UsageError
        For a problem, a method or a number that does not fit.
    """
    # a problem's file may be executed: after what can be refused without it
    own = None if methods is None else list(_methods(methods))
    if not 1e-14 <= (tolerance := number("tolerance", tolerance)) < 1:
        raise UsageError(f"`tolerance` must lie between 1e-14 and 1, got {tolerance!r}")
    budget = number("budget", budget)
    subject = _subject(problem)
    begin, end = map(float, subject.t_span)
    end = end if t_end is None else number("t_end", t_end)
    if end == begin:
        raise UsageError(f"`t_end` must be another time than {begin:g}, got {end!r}")
    kind = kind_of(subject)
    chosen = list(_methods(candidates(kind))) if own is None else own
    deadline = perf_counter() + budget
    error, reference = _judge(subject, end, tolerance)
    found = []
    for k, (method, notes) in enumerate(chosen):
        left = (deadline - perf_counter()) / (len(chosen) - k)
        search = _Search(subject, method, end, error, tolerance, perf_counter() + max(left, 0.5))
        with saying(f"measuring {method.name} on {subject.name} ..."):
            found.append(search.candidate(kind, notes))
    ranked = sorted(found, key=lambda one: math.inf if one.seconds is None else one.seconds)
    recommended, reason = _recommended(ranked, kind, tolerance, error)
    return Comparison(
        subject.name, _WORDS[kind], end, tolerance, error, reference, tuple(ranked), recommended,
        reason,
    )  # fmt: skip


def _subject(problem: Any) -> Problem:
    if isinstance(problem, Problem):
        return problem
    text = os.fspath(problem) if isinstance(problem, str | os.PathLike) else ""
    if not isinstance(text, str) or not text:
        raise UsageError(
            f"`problem` must be a Problem, its name or a TOML file, got {type(problem).__name__}"
        )
    return from_path(text) if text.endswith(".toml") else shipped_problem(text)


def _methods(given: Sequence[Any]) -> Iterable[tuple[Any, list[str]]]:
    """Return the methods and the notes of their files."""
    if isinstance(given, str | Method):
        given = [given]
    if not given:
        raise UsageError("`methods` is empty; name one or more, or leave it out")
    shipped = set(names("methods"))
    for one in given:
        if isinstance(one, Method):
            yield one, document(one.name).get("notes", []) if one.name in shipped else []
            continue
        if is_broken(one):
            raise UsageError(f"the method {one!r} is wrong on purpose; it is not compared")
        yield load(one), document(one).get("notes", [])


def _judge(subject: Problem, end: float, tolerance: float) -> tuple[str, str]:
    """Return which error is measured, and against what."""
    why = ""
    try:
        found = reference_state(subject, end)
        if found.error <= tolerance / 3:
            words = {"exact": "closed form", "stored": "stored reference",
                     "computed": "reference by gauss-5 with h halved"}  # fmt: skip
            return "state", f"{words[found.kind]}, good to {found.error:.0e}"
        why = f"the reference at t = {end:g} is good to {found.error:.0e} only"
    except UsageError as error:
        why = str(error)
    if subject.hamiltonian is None:
        raise UsageError(f"{why}; shorten `t_end`, or raise the tolerance")
    return "energy", f"largest error of H over 64 samples, because {why}"


def _error(work: Work, which: str) -> float | None:
    return work.state_error if which == "state" else work.energy_error


class _Search:
    """Runs of one method, with ever more steps until the tolerance is reached."""

    def __init__(
        self, subject: Problem, method: Any, end: float, error: str, tolerance: float,
        deadline: float,
    ) -> None:  # fmt: skip
        self.subject, self.method, self.error, self.tolerance = subject, method, error, tolerance
        self.length, self.deadline = end - float(subject.t_span[0]), deadline
        self.renew, self.watched = renewal_of(method), watched(method, expressed(subject))
        self.works: list[Work] = []
        self.failed = 0
        self.message = ""

    def candidate(self, kind: str, notes: Sequence[str]) -> Candidate:
        """Carry out the runs and sum them up."""
        claims = self.method.claims
        order = stated_orders(claims).get("b")
        if kind == "second order":
            order = claims.get(NYSTROM_ORDER.key, order)
        order = order if isinstance(order, int) else None
        try:
            self._runs(order or 2)
        except GlmrefError as error:
            self.message = str(error)
        good = [w for w in self.works if w.completed and _error(w, self.error) is not None]
        records = [
            {"outcome": w.outcome, f"{self.error}_error": _error(w, self.error),
             "seconds": {"median": w.seconds.median}, "h": w.h} for w in good
        ]  # fmt: skip
        reached = [w for w in good if (_error(w, self.error) or 0.0) <= self.tolerance]
        label = long_runs(self.method, notes)
        if kind == "general" and label in (DRIFTS, UNKNOWN, WATCHED):
            label = "-"  # there is no energy to drift
        if not reached:
            least = min((_error(w, self.error) or 0.0 for w in good), default=None)
            missed = "" if least is None else f"not below {least:.1e} within the time given"
            return Candidate(
                self.method.name,
                order,
                label,
                message=self.message or missed,
                works=tuple(good),
                renew=self.renew,
            )
        best = min(reached, key=lambda work: work.evaluations)
        seconds = seconds_at(records, self.error, self.tolerance)
        if kind in ("Hamiltonian", "semi-separable") and self.watched:
            label = self._observed(best.h, label)
        elif kind != "general" and self.renew:
            label = self._predicted(best.h, label)
        return Candidate(
            self.method.name, order, label, best.h, best.steps, _error(best, self.error),
            best.energy_error, seconds, best.evaluations, works=tuple(good), renew=self.renew,
        )  # fmt: skip

    def _predicted(self, h: float, label: str) -> str:
        """Return the label of long runs at a step size where a prediction adds to the file."""
        end = float(self.subject.t_span[0]) + MOST_PREDICTED * h
        try:
            verdict = predict(self.method, self.subject, h, end).verdict
        except GlmrefError:
            return label
        known = {EXPECTED_LOSS: LOST, SATURATES: GROWS, EXPECTED_BOUND: PREDICTED}
        return known.get(verdict, label)

    def _observed(self, h: float, label: str) -> str:
        """Return the label of long runs at a step size, from a long run that is watched."""
        run = solve(
            self.subject, self.method, h=h, steps=MOST_WATCHED,
            cancel=lambda: perf_counter() > self.deadline,
        )  # fmt: skip
        if run.suspect is not None or run.outcome is Outcome.NOT_FINITE:
            return LOST
        return OBSERVED if run.completed else label

    def _runs(self, order: int) -> None:
        scale = float(self.subject.scales.get("time", 1.0))
        steps = min(max(8, math.ceil(abs(self.length) / scale * _FIRST)), _MOST_FIRST)
        coarser, before = True, 0
        while len(self.works) < MOST_RUNS + self.failed:
            work = self._run(steps)
            self.failed += not work.completed
            reached = _error(work, self.error) if work.completed else None
            if reached is not None and reached <= self.tolerance:
                if not coarser or steps <= 8:
                    return
                before, steps = (
                    steps,
                    max(8, steps // 2),
                )  # the first run was fine enough: how coarse may it be
                continue
            if steps < before:
                return  # the run before was fine enough, and this one is too coarse
            coarser = False
            factor = _MOST_FACTOR
            self.message = work.message
            if reached is not None:
                # somewhat beyond the tolerance, so that it lies between two points
                wanted = (1.6 * reached / self.tolerance) ** (1 / order)
                factor = min(_MOST_FACTOR, max(_LEAST_FACTOR, wanted))
            steps = math.ceil(steps * factor)
            slow = 2 * factor * max(work.seconds.median, 0.0) > self.deadline - perf_counter()
            if steps > _MOST_STEPS or slow or perf_counter() > self.deadline:
                return

    def _run(self, steps: int) -> Work:
        energy = ("energy",) if self.subject.hamiltonian is not None else ()
        ask = ("state", *energy) if self.error == "state" else energy
        left = max(0.2, self.deadline - perf_counter())
        work = measure(
            self.subject, self.method, h=self.length / steps, steps=steps, ask=ask, repeats=5,
            budget=min(left, 10.0), renew=self.renew,
        )  # fmt: skip
        self.works.append(work)
        return work


def _recommended(
    ranked: Sequence[Candidate], kind: str, tolerance: float, error: str
) -> tuple[str | None, str]:
    reached = [one for one in ranked if one.reached]
    if not reached:
        return None, (
            f"no method reached {tolerance:g} in the {error} within the time given, at constant "
            f"step sizes; raise the tolerance or shorten the run"
        )
    fit = [one for one in reached if one.fit_for_long_runs]
    bounded = [one for one in fit if one.long_runs in (BOUNDED, *_KEPT)]
    choice = (bounded or fit) if kind != "general" else fit
    if not choice:
        names = ", ".join(one.method for one in reached)
        return None, f"{names} reached the tolerance, but grow on long runs"
    best = choice[0]
    assert best.seconds is not None
    first = (
        f"it reaches {tolerance:g} in the {error} in {duration(best.seconds)} with "
        f"{best.evaluations:,} evaluations at h = {best.h:.4g}"
    )
    sentences = [first]
    if best.renew and best.long_runs not in _KEPT:
        sentences.append(f"long runs need `renew={best.renew}`, see docs/choose.md")
    others = [one for one in choice[1:] if one.seconds is not None]
    if others:
        ratio = (others[0].seconds or 0.0) / best.seconds
        sentences[0] += f", {others[0].method} takes {ratio:.2f} times that"
    if kind != "general":
        known = best.long_runs in (BOUNDED, *_KEPT)
        meaning = "not symplectic: its energy error is that of this run only"
        sentences.append(f"it is {MEANINGS[best.long_runs] if known else meaning}")
    for one in reached[: reached.index(best)]:
        part = (one.seconds or 0.0) / best.seconds
        why = "its long runs grow or are lost"
        if one.fit_for_long_runs:
            why = f"its long runs: {one.long_runs}"
        elif one.renew:
            why += f" without `renew={one.renew}`"
        sentences.append(f"{one.method} takes {part:.2f} times its time, but {why}")
    fewest = min(choice, key=lambda one: one.evaluations or math.inf)
    if fewest.evaluations != best.evaluations:
        sentences.append(
            f"where the right-hand side is expensive, {fewest.method} needs the fewest "
            f"evaluations of these, {fewest.evaluations:,}"
        )
    return best.method, "; ".join(sentences)
