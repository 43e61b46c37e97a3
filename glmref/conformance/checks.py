"""The checks: what an integrator is asked, in which order, and what its answers must be.

Every check has an id such as ``step/gauss-2/pendulum``: claim, method, problem. A claim is judged
only where those it rests on hold, so that one defect is reported once, under the claim it breaks.

Tolerances come from the vectors: ``rounding`` bounds, to first order and with a factor 4 for other
orders of summation, what a relative error u in every input, coefficient and operation does to the
result. With the unit round-off u of the adapter and the relative error v with which it solves stage
equations (``Adapter.tolerance``; 0 where there are none), a result may be off by
``(u + v) rounding + bound``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import UsageError
from ..findings import Finding, Proof, Verdict
from .compare import Comparison
from .measure import Measurement
from .subject import AdapterError, NotOffered, Subject
from .vector_problems import problems
from .vectors import Case, Vectors, vectors_of
from .verdicts import Judgement

#: claim -> claims that must hold before it is judged.
RESTS_ON: Mapping[str, tuple[str, ...]] = {
    "answer": (),
    "repeatable": ("answer",),
    "stages": ("repeatable",),
    "step": ("repeatable", "stages"),
    "abscissae": ("step",),
    "backward": ("step",),
    "symmetric": ("repeatable", "backward"),
    "conserved": ("step",),
    "start": ("repeatable",),
    "finish": ("repeatable",),
    "trajectory": ("step", "abscissae", "start", "finish"),
    "order": ("repeatable", "trajectory"),
    "long": ("answer", "order"),
    "symplectic": ("repeatable",),
    "coefficients": ("repeatable", "order"),
}
#: Judged although what it rests on is open: coefficients show an order that a run does not.
_BESIDE = {("coefficients", "order")}


def claim_of(id_: str) -> str:
    """Return the first word of the id of a check, without the order's number."""
    return id_.partition("/")[0].rstrip("0123456789")


@dataclass(frozen=True, eq=False)
class Check:
    """One question to the integrator."""

    id: str
    method: str
    judge: Callable[[], Judgement]

    @property
    def claim(self) -> str:
        """See :func:`claim_of`."""
        return claim_of(self.id)


class Suite:
    """All checks of one adapter; each is carried out at most once, after those it rests on."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.checks = tuple(self._all())
        self._findings: dict[str, Finding] = {}

    def _all(self) -> Iterator[Check]:
        for name, claims in self.subject.methods.items():
            if claims:
                yield from _measured(self.subject, name, claims)
            else:
                found = tuple(_compared(self.subject, vectors_of(name)))
                if not found:
                    raise UsageError(
                        f"no vector of {name} has a problem that {self.subject.name} can do; "
                        f"its `problems` are {', '.join(self.subject.problems or ())}"
                    )
                yield from found

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
            and not ((check.claim, x.claim) in _BESIDE and self.finding(x).verdict is Verdict.OPEN)
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
    """Yield checks of a method of the catalogue."""
    judge = Comparison(subject, vectors)
    offered = subject.offers
    cases = [
        x for x in vectors.cases if subject.problems is None or x.problem.name in subject.problems
    ]

    def check(case: Case, claim: str, function: Callable[[Case], Judgement]) -> Check:
        name = f"{claim}/{vectors.name}/{case.problem.name}"
        return Check(name, vectors.name, lambda: function(case))

    def first(cases: list[Case], claim: str, function: Callable[[Case], Judgement]) -> Check:
        name = f"{claim}/{vectors.name}/{cases[0].problem.name}"
        return Check(name, vectors.name, lambda: _first_offered(vectors.name, cases, function))

    steps = [x for x in cases if x.kind == "step"]
    if steps and "step" in offered:
        yield first(steps, "answer", judge.answer)
        yield first(steps, "repeatable", judge.repeatable)
    elif "solve" in offered and (runs := [x for x in cases if x.kind == "trajectory"]):
        yield first(runs, "answer", lambda case: Judgement(judge.run(case) is not None))
        yield first(runs, "repeatable", judge.repeatable_run)
    if "stages" in offered:
        yield from (check(x, "stages", judge.stages) for x in steps if x.claim == "step")
    if "step" in offered:
        yield from (check(x, x.claim, judge.step) for x in steps)
        yield from (check(x, "conserved", judge.conserved) for x in steps if "conserved" in x.data)
    for kind in ("start", "finish"):
        if kind in offered:
            yield from (check(x, kind, getattr(judge, kind)) for x in cases if x.kind == kind)
    if "solve" in offered or "step" in offered:
        if not judge.own or int(vectors.document["values"]) == 1:
            yield from (
                check(x, "trajectory", judge.trajectory) for x in cases if x.kind == "trajectory"
            )
        orders = [x for x in cases if x.kind == "order"]
        yield from (check(x, x.claim, judge.order) for x in orders)
    conserving = int(vectors.document["values"]) > 1 and "G" in vectors.coefficients
    if conserving and judge.own:
        tasks = {x.problem.name: x.problem for x in cases}
        if (task := tasks.get("rigid-body")) is not None:
            name = f"long/{vectors.name}/{task.name}"
            yield Check(name, vectors.name, lambda: judge.long(task))


def _first_offered(
    name: str, cases: list[Case], function: Callable[[Case], Judgement]
) -> Judgement:
    """Judge the first case that the adapter offers; an adapter that offers none of them fails."""
    reasons = []
    for case in cases:
        try:
            return function(case)
        except NotOffered as error:
            reasons.append(str(error))
    return Judgement(
        False, f"the adapter lists {name} and offers no step or run of it: {reasons[0]}"
    )


# --- integrators outside the catalogue: their claims are measured -------------------------------


#: Problems on which claims are measured; the last depends on time, and is left out of the forms.
_MEASURED, _TIMED = ("pendulum", "kepler"), "forced"


def _measured(subject: Subject, name: str, claims: Mapping[str, Any]) -> Iterator[Check]:
    """Yield checks of what an adapter claims of a method that the catalogue lacks."""
    order = claims.get("order")
    for task in (problems()[x] for x in subject.problems or (*_MEASURED, _TIMED)):
        judge = Measurement(subject, name, task)
        yield Check(f"answer/{name}/{task.name}", name, judge.answer)
        yield Check(f"repeatable/{name}/{task.name}", name, judge.repeatable)
        if order is not None:
            yield Check(
                f"order{order}/{name}/{task.name}", name, lambda j=judge, p=order: j.order(p)
            )
        if task.name == _TIMED:
            if "abscissae" in claims:
                times = claims["abscissae"]
                yield Check(
                    f"abscissae/{name}/{task.name}", name, lambda j=judge, c=times: j.abscissae(c)
                )
            continue
        for claim in ("symmetric", "symplectic"):
            if claims.get(claim):
                yield Check(f"{claim}/{name}/{task.name}", name, getattr(judge, claim))
    if order is not None:
        yield Check(f"coefficients/{name}/probe", name, lambda: judge.coefficients(order))
