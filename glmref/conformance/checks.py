"""The checks: what an integrator is asked, in which order, and what its answers must be.

Every check has an id such as ``step/gauss-2/pendulum``: claim, method, problem. A claim is judged
only where those it rests on hold, so that one defect is reported once, under the claim it breaks.

Tolerances come from the vectors: ``rounding`` bounds, to first order and with a factor 4 for other
orders of summation, what a relative error u in every input, coefficient and operation does to the
result. With the unit round-off u of the adapter and the relative error v with which it solves stage
equations (``Adapter.tolerance``), a result may be off by ``(u + v) rounding + bound``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import log2
from typing import Any

import numpy as np

from ..claims import Finding, Proof, UsageError, Verdict
from ..method import PartitionedGLM
from .adapter import AdapterError, NotOffered, Subject
from .diagnosis import known_bug, name_defect, residual_of_stages, stage_order
from .vectors import Case, TestProblem, Vectors, array, problems, vectors_of

__all__ = ["RESTS_ON", "Check", "Suite"]

#: claim -> claims that must hold before it is judged.
RESTS_ON: Mapping[str, tuple[str, ...]] = {
    "answer": (),
    "repeatable": ("answer",),
    "stages": ("repeatable",),
    "step": ("repeatable", "stages"),
    "abscissae": ("step",),
    "backward": ("step",),
    "symmetric": ("answer", "backward"),
    "conserved": ("step",),
    "start": ("repeatable",),
    "finish": ("repeatable",),
    "trajectory": ("step", "abscissae", "start", "finish"),
    "order": ("answer", "trajectory"),
    "symplectic": ("answer",),
}


#: Length of the runs that measure an order.
_TIME = 4.0


@dataclass(frozen=True, slots=True)
class Judgement:
    """Outcome of one check.

    Attributes
    ----------
        holds: ``None`` where it was not judged.
        message: what is wrong, or why it was not judged.
        residual: size of the deviation. declared, value: for claims with a value.
    """

    holds: bool | None
    message: str = ""
    residual: float = 0.0
    declared: object = True
    value: object = None


@dataclass(frozen=True, eq=False)
class Check:
    """One question to the integrator."""

    id: str
    method: str
    judge: Callable[[], Judgement]

    @property
    def claim(self) -> str:
        """First word of the id, without the order's number."""
        return self.id.partition("/")[0].rstrip("0123456789")


class Suite:
    """All checks of one adapter; each is carried out at most once.

    Args:
        subject: the adapter.

    Attributes
    ----------
        checks: in an order in which each comes after those it rests on.
    """

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.checks = tuple(self._all())
        self._findings: dict[str, Finding] = {}

    def _all(self) -> Iterator[Check]:
        for name, claims in self.subject.methods.items():
            if claims:
                yield from _measured(self.subject, name, claims)
            else:
                yield from _compared(self.subject, vectors_of(name))

    def finding(self, check: Check) -> Finding:
        """Carry out a check, or say why it is not judged."""
        if check.id not in self._findings:
            self._findings[check.id] = self._find(check)
        return self._findings[check.id]

    def findings(self) -> list[Finding]:
        """Carry out all checks."""
        return [self.finding(check) for check in self.checks]

    def _find(self, check: Check) -> Finding:
        below = [
            x.id
            for x in self.checks
            if x.method == check.method
            and x.claim in RESTS_ON[check.claim]
            and self.finding(x).verdict is not Verdict.HOLDS
            and not self._not_offered(x)
        ]
        if below:
            result = Judgement(None, f"not judged: it rests on {below[0]}, which does not hold")
        else:
            result = _guarded(check.judge)
        verdict = {True: Verdict.HOLDS, False: Verdict.FAILS, None: Verdict.OPEN}[result.holds]
        return Finding(
            method=check.method, claim=check.id, declared=result.declared, verdict=verdict,
            value=result.holds if result.value is None else result.value,
            proof=Proof.MEASURED, residual=result.residual, witness=result.message,
        )  # fmt: skip

    def _not_offered(self, check: Check) -> bool:
        return self.finding(check).witness.startswith("not offered")


def _guarded(judge: Callable[[], Judgement]) -> Judgement:
    try:
        with np.errstate(all="ignore"):
            return judge()
    except NotOffered as error:
        return Judgement(None, f"not offered: {error}")
    except AdapterError as error:
        return Judgement(False, str(error), float("inf"))


# --- methods of the catalogue: compared with vectors --------------------------------------------


def _compared(subject: Subject, vectors: Vectors) -> Iterator[Check]:
    """Checks of a method of the catalogue."""
    judge = _Judge(subject, vectors)
    offered = subject.offers
    cases = [
        x for x in vectors.cases if subject.problems is None or x.problem.name in subject.problems
    ]

    def check(case: Case, claim: str, function: Callable[[Case], Judgement]) -> Check:
        name = f"{claim}/{vectors.name}/{case.problem.name}"
        return Check(name, vectors.name, lambda: function(case))

    steps = [x for x in cases if x.kind == "step"]
    if steps and "step" in offered:
        yield check(steps[0], "answer", judge.answer)
        yield check(steps[0], "repeatable", judge.repeatable)
    elif "solve" in offered and (runs := [x for x in cases if x.kind == "trajectory"]):
        yield check(runs[0], "answer", lambda case: Judgement(judge._run(case) is not None))
        yield check(runs[0], "repeatable", judge.repeatable_run)
    if "stages" in offered:
        yield from (check(x, "stages", judge.stages) for x in steps if x.claim == "step")
    if "step" in offered:
        yield from (check(x, x.claim, judge.step) for x in steps)
        yield from (check(x, "conserved", judge.conserved) for x in steps if "conserved" in x.data)
    for kind in ("start", "finish"):
        if kind in offered:
            yield from (check(x, kind, getattr(judge, kind)) for x in cases if x.kind == kind)
    if "solve" in offered or "step" in offered:
        if subject.starts == "file" or int(vectors.document["values"]) == 1:
            yield from (
                check(x, "trajectory", judge.trajectory) for x in cases if x.kind == "trajectory"
            )
        orders = [x for x in cases if x.kind == "order"]
        yield from (check(x, x.claim, judge.order) for x in orders)


class _Judge:
    """Compares the answers of an adapter for one method with its vectors."""

    def __init__(self, subject: Subject, vectors: Vectors) -> None:
        self.subject, self.vectors, self.name = subject, vectors, vectors.name
        self.pair = isinstance(vectors.method, PartitionedGLM)

    def _allowed(self, case: Case) -> float:
        unit = self.subject.unit(self.name)
        return unit * case.number("rounding") + case.number("bound")

    def _step(self, case: Case) -> np.ndarray:
        return self.subject.step(
            self.name, case.problem.problem, case.number("t"), case.input, case.number("h")
        )

    def answer(self, case: Case) -> Judgement:
        """A step returns finite numbers of the right shape, and leaves its input alone."""
        given = case.input
        argument = given[0] if len(given) == 1 else given
        kept = argument.copy()
        self._step(case)
        self.subject._call(
            "step", self.name, case.problem.problem, case.number("t"), argument, case.number("h")
        )
        if not np.array_equal(argument, kept):
            return Judgement(False, "step changes the array it is given; it must work on a copy")
        return Judgement(True)

    def repeatable(self, case: Case) -> Judgement:
        """The same input gives the same output, whatever was asked between."""
        problem, t, h = case.problem.problem, case.number("t"), case.number("h")
        first = self._step(case)
        self.subject.step(self.name, problem, t + 1, case.input + 0.125, h / 2)
        return _same(first, self._step(case), self._allowed(case), "step")

    def repeatable_run(self, case: Case) -> Judgement:
        """Two equal runs with another one between them give the same."""
        first = self._run(case)
        self.subject.solve(
            self.name, case.problem.problem, case.number("h") / 2, 2, self._given(case)
        )
        return _same(first, self._run(case), self._allowed(case), "solve")

    def stages(self, case: Case) -> Judgement:
        """Stage values agree with the vectors."""
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
            return Judgement(False, _sentence(where, part[i, k], right[i, k], allowed, said), gap)
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
        """Values after one step agree with the vector."""
        return self._agree(case, self._step(case), case["output"], "value")

    def conserved(self, case: Case) -> Judgement:
        """The quadratic form stays what it is through ten steps.

        Values of size m carry relative errors of some (u + v) rounding each step, and the form is
        quadratic in them: its change is below ``10 * 2 |G| |C| m`` times that.
        """
        assert case.problem.quadratic is not None
        blocks = self.vectors.coefficients
        G = array(blocks["G"]) if "G" in blocks else np.ones((1, 1))
        C, values, h = array(case.problem.quadratic), case.input, case.number("h")
        before, largest = _form(G, C, values), np.abs(values).max()
        for n in range(10):
            values = self.subject.step(
                self.name, case.problem.problem, case.number("t") + n * h, values, h
            )
            largest = max(largest, np.abs(values).max())
        weight = 20 * np.abs(G).sum() * np.abs(C).sum() * largest
        allowed = weight * self._allowed(case)
        gap = abs(_form(G, C, values) - before)
        if gap <= allowed:
            return Judgement(True, residual=gap)
        return Judgement(
            False,
            f"the form sum G_ij y_i^T C y_j is {before:.15g} and changes by {gap:.2g} in ten "
            f"steps; rounding explains {allowed:.2g}: the method conserves it, the code does not",
            gap,
        )

    def start(self, case: Case) -> Judgement:
        """Starting values agree with the vector."""
        expected = case["output"]
        found = self.subject.start(
            self.name, case.problem.problem, case.number("h"), expected.shape
        )
        return self._agree(case, found, expected, "starting value")

    def finish(self, case: Case) -> Judgement:
        """The finished solution agrees with the vector."""
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
        where = f"component {i + 1} of {what} {k + 1}"
        return Judgement(False, _sentence(where, found[k, i], right[k, i], allowed, said), gap)

    # --- runs -----------------------------------------------------------------------------------

    def _given(self, row: Case | Mapping[str, Any]) -> np.ndarray | None:
        data = row.data if isinstance(row, Case) else row
        return array(data["input"]) if "input" in data else None

    def _run(self, case: Case) -> np.ndarray:
        """Solution at every step, or at the end only."""
        return self._solution(
            case.problem, case.number("h"), int(case.data["steps"]), self._given(case)
        )

    def _solution(
        self, task: TestProblem, h: float, steps: int, given: np.ndarray | None
    ) -> np.ndarray:
        subject, problem = self.subject, task.problem
        if "solve" in subject.offers:
            return subject.solve(self.name, problem, h, steps, given)
        values, t0 = self._started(task, h, given), float(task.t0)
        rows = [self._finished(task, t0, values, h)]
        for n in range(steps):
            values = subject.step(self.name, problem, t0 + n * h, values, h)
            rows.append(self._finished(task, t0 + (n + 1) * h, values, h))
        return np.array(rows)

    def _started(self, task: TestProblem, h: float, given: np.ndarray | None) -> np.ndarray:
        """Starting values: given, the adapter's, or ours where it has none."""
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
        """The solution agrees with the vector at every step that is shown."""
        found, right = self._run(case), case["solution"]
        right = right if len(found) > 1 else right[-1:]
        allowed = self._allowed(case)
        gaps = np.abs(found - right).max(axis=1)
        if gaps.max() <= allowed:
            return Judgement(True, residual=float(gaps.max()))
        said = known_bug(found[-1:], case, allowed)
        n = int(np.argmax(gaps > allowed))
        said = said or name_defect(self.subject, self.vectors, case, found[-1:], allowed)
        i = int(np.abs(found[n] - right[n]).argmax())
        step = n if len(found) > 1 else int(case.data["steps"])
        where = f"component {i + 1} of the solution after {step} steps"
        message = _sentence(where, found[n, i], right[n, i], allowed, said)
        return Judgement(False, message, float(gaps.max()))

    def order(self, case: Case) -> Judgement:
        """The error falls with the order of the method."""
        right, end = int(case.data["order"]), float(case.data["t_end"])
        own = self.subject.starts == "own" and "solve" in self.subject.offers
        given = {int(row["steps"]): None if own else self._given(row) for row in case.data["rows"]}

        def run(steps: int) -> np.ndarray:
            h = (end - case.number("t")) / steps
            return self._solution(case.problem, h, steps, given[steps])[-1]

        steps, errors = _errors(run, list(given), case["exact"])
        return _order_judgement(steps, errors, right, self.subject, self.name)


def _ours(name: str) -> Any:
    """Our own start and finish, for adapters that have none."""
    from .adapters.reference import Adapter

    return Adapter((name,))


def _form(G: np.ndarray, C: np.ndarray, values: np.ndarray) -> float:
    return float(np.einsum("ij,ia,ab,jb->", G, values, C, values))


def _same(first: np.ndarray, again: np.ndarray, allowed: float, what: str) -> Judgement:
    gap = float(np.abs(first - again).max())
    if gap <= allowed:
        return Judgement(True, residual=gap)
    return Judgement(
        False,
        f"the same {what} gives another result ({gap:.2g} apart) after a different one was taken: "
        f"the integrator keeps something from call to call",
        gap,
    )


def _sentence(where: str, found: float, right: float, allowed: float, said: str) -> str:
    text = (
        f"{where} is {found:.17g} and must be {right:.17g} "
        f"(off by {abs(found - right):.2g}, rounding explains {allowed:.2g})"
    )
    return f"{text}; {said}" if said else text


# --- integrators outside the catalogue: their claims are measured -------------------------------


def _measured(subject: Subject, name: str, claims: Mapping[str, Any]) -> Iterator[Check]:
    """Checks of what an adapter claims of a method that the catalogue lacks."""
    wanted = subject.problems or ("pendulum", "kepler")
    tasks = [problems()[x] for x in wanted if x in problems()]
    if not tasks:
        raise UsageError(
            f"`problems` of {subject.name} must name some of {', '.join(problems())}, got {wanted}"
        )
    for task in tasks:
        judge = _Measure(subject, name, task)
        yield Check(f"answer/{name}/{task.name}", name, judge.answer)
        if "order" in claims:
            order = int(claims["order"])
            yield Check(
                f"order{order}/{name}/{task.name}", name, lambda j=judge, p=order: j.order(p)
            )
        for claim in ("symmetric", "symplectic"):
            if claims.get(claim) and "step" in subject.offers:
                yield Check(f"{claim}/{name}/{task.name}", name, getattr(judge, claim))


class _Measure:
    """Measures one integrator on one problem."""

    #: Large, so that the smallest violations of symmetry and symplecticity show.
    size = 0.25

    def __init__(self, subject: Subject, name: str, task: TestProblem) -> None:
        self.subject, self.name, self.task = subject, name, task

    def _end(self, steps: int) -> np.ndarray:
        problem, h = self.task.problem, _TIME / steps
        if "solve" in self.subject.offers:
            return self.subject.solve(self.name, problem, h, steps)[-1]
        values = array(self.task.y0)[None, :]
        for n in range(steps):
            values = self.subject.step(self.name, problem, float(self.task.t0) + n * h, values, h)
        return values[0]

    def answer(self) -> Judgement:
        """A short run returns finite numbers of the right shape."""
        return Judgement(self._end(64) is not None)

    def order(self, right: int) -> Judgement:
        """Errors against a Taylor series of 30 digits."""
        exact = _taylor_end(self.task.name, _TIME)
        counts = [2**k for k in range(2, 10)]
        steps, errors = _errors(
            self._end, counts, exact, enough=lambda n, e: e < _floor(self.subject, self.name, n)
        )
        return _order_judgement(steps, errors, right, self.subject, self.name)

    def _step(self, y: np.ndarray, h: float) -> np.ndarray:
        return self.subject.step(self.name, self.task.problem, float(self.task.t0), y[None, :], h)[
            0
        ]

    def symmetric(self) -> Judgement:
        """A step and one back with -h return to the beginning."""
        y = array(self.task.y0)
        gap = float(np.abs(self._step(self._step(y, self.size), -self.size) - y).max())
        # two steps, each off by some hundred roundings as in the vectors
        allowed = 1000 * self.subject.unit(self.name)
        said = f"a step of {self.size} and one back miss the beginning by {gap:.2g}"
        return _measured_claim(gap, allowed, f"{said} (rounding explains {allowed:.2g})")

    def symplectic(self) -> Judgement:
        """The derivative M of a step satisfies ``M^T J M = J``.

        By central differences of fourth order: step 2e-3 leaves 1e-11 of truncation, and rounding
        (u + v) 100 / 2e-3 below 1e-10 in double precision.
        """
        y, d = array(self.task.y0), self.task.problem.dimension
        width = 2e-3
        columns = []
        for k in range(d):
            unit = np.zeros(d)
            unit[k] = width
            ends = [self._step(y + m * unit, self.size) for m in (1, -1, 2, -2)]
            columns.append((8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12 * width))
        M, half = np.stack(columns, axis=1), d // 2
        J = np.block(
            [[np.zeros((half, half)), np.eye(half)], [-np.eye(half), np.zeros((half, half))]]
        )
        gap = float(np.abs(M.T @ J @ M - J).max())
        allowed = 1e-9 + self.subject.unit(self.name) * 1e3 / width
        said = f"M^T J M differs from J by {gap:.2g}, M the derivative of a step of {self.size}"
        return _measured_claim(gap, allowed, f"{said} (allowed {allowed:.2g})")


def _measured_claim(gap: float, allowed: float, said: str) -> Judgement:
    return Judgement(gap <= allowed, "" if gap <= allowed else said, gap)


def _errors(
    run: Callable[[int], np.ndarray], counts: Sequence[int], exact: np.ndarray,
    enough: Callable[[int, float], bool] = lambda n, e: False,
) -> tuple[list[int], list[float]]:  # fmt: skip
    """Errors at the end of runs; the coarsest runs may fail, the others must not."""
    steps: list[int] = []
    errors: list[float] = []
    for n in counts:
        try:
            error = float(np.abs(run(n) - exact).max())
        except AdapterError:
            if steps or n == counts[-1]:
                raise
            continue
        steps.append(n)
        errors.append(error)
        if enough(n, error):
            break
    return steps, errors


def _floor(subject: Subject, name: str, steps: int) -> float:
    """Error of a run from which its slope can be read: rounding changes it by a quarter at most.

    A step carries some 30 roundings, and what is left of the stage equations; slopes are then right
    within ``log2(5/4) < 1/3``.
    """
    return 4 * steps * (30 * subject.epsilon + subject.tolerance(name))


def _order_judgement(
    steps: Sequence[int], errors: Sequence[float], right: int, subject: Subject, name: str
) -> Judgement:
    """Decide an order from errors at halved step sizes.

    The error is ``C h^p (1 + O(h))``, so the slopes ``log2(e(h) / e(h/2))`` tend to an integer. They
    have settled when the last one changes by 1/4 at most and lies within 1/3 of an integer, which
    then decides. Slopes that still change, at the rounding floor, refute the claim only from below.
    """
    shown = ", ".join(f"{e:.3g} at {n} steps" for n, e in zip(steps, errors, strict=True))
    usable = [(n, e) for n, e in zip(steps, errors, strict=True) if e > _floor(subject, name, n)]
    slopes = [log2(a / b) for (n, a), (m, b) in zip(usable, usable[1:], strict=False) if m == 2 * n]
    if not slopes:
        return Judgement(None, f"not judged: too few errors above rounding ({shown})")
    slope, found = slopes[-1], round(slopes[-1])
    steady = len(slopes) > 1 and abs(slope - slopes[-2]) <= 1 / 4
    if steady and abs(slope - found) <= 1 / 3:
        holds: bool | None = found == right
    elif slope >= right - 1 / 3:
        holds, found = True, right
    else:
        holds = False if steady else None
    message = "" if holds else f"the error falls like h^{slope:.2f}, not h^{right} ({shown})"
    return Judgement(holds, message, abs(slope - right), right, found)


@cache
def _taylor_end(name: str, time: float) -> np.ndarray:
    from ..problems.taylor import taylor_states

    task = problems()[name]
    (end,) = taylor_states(task.problem, [float(task.t0) + time], digits=25)
    return np.array([float(x) for x in end])
