"""Cases of one step: forward, with time, backward, the way back; starts and finishes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from ..engine.reference import apply_finish, apply_start
from ..errors import DataError
from ..exact import ball
from ..method import Method
from .bench import FAULT_DIGITS, SHOWN, Bench
from .faults import Wrong, wrong_start, wrong_steps
from .numbers import decimal_text, decimals, exact_decimal, fraction_of
from .proof import add_wrong, bound_of, conserved_form
from .scheme import ball_field, enclosed_step
from .vector_problems import TestProblem


class StepCases:
    """Makes the cases of one step of the method on a bench."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.method, self.name = bench, bench.method, bench.name

    def step(self, claim: str, task: TestProblem, h: Fraction) -> dict[str, Any]:
        """Take one step from values that hide nothing."""
        case = self._one_step(claim, task, Fraction(task.t0), self.bench.values(task), h)
        if self.bench.G is not None and claim == "step" and task.quadratic is not None:
            conserved = self._conserved(task, case)
            if conserved is not None:
                case["conserved"] = conserved
        if claim != "step" or task.name == "cubic":
            self._trap(case, task)
        return case

    def _one_step(
        self, claim: str, task: TestProblem, t: Fraction, given: Sequence[Sequence[Fraction]],
        h: Fraction,
    ) -> dict[str, Any]:  # fmt: skip
        engine = self.bench.engine(task)
        values, context = self.bench.numbers(engine, given), engine.arithmetic.context
        size, time = (context.mpf(x.numerator) / x.denominator for x in (h, t))
        taken = engine.step(time, values, size)
        stages = taken.stages if self.bench.pair else (taken.stages,)
        shown = [decimals(part, SHOWN) for part in stages]
        output = decimals(taken.values, SHOWN)
        flat = [row for part in stages for row in part]
        guesses = [[ball(fraction_of(x)) for x in row] for row in flat]
        enclosed = enclosed_step(self.method, ball_field(task.expressions), t, given, h, guesses)
        printed = [[row for part in shown for row in part], output]
        rounding = self.bench.rounding(self.method, task, time, values, size, flat)
        return {
            "id": f"{claim}/{self.name}/{task.name}",
            "kind": "step",
            "problem": task.name,
            "t": exact_decimal(t),
            "h": exact_decimal(h),
            "input": [[exact_decimal(x) for x in row] for row in given],
            "stages": {"Q": shown[0], "P": shown[1]} if self.bench.pair else shown[0],
            "output": output,
            "bound": bound_of(enclosed, printed, self.bench.doubt),
            "rounding": rounding,
            "flags": [],
        }

    def _trap(self, case: dict[str, Any], task: TestProblem) -> None:
        """Add to a step what usual bugs make of it."""
        engine = self.bench.engine(task, FAULT_DIGITS)
        given = [[Fraction(x) for x in row] for row in case["input"]]
        values, context = self.bench.numbers(engine, given), engine.arithmetic.context
        t, h = context.mpf(case["t"]), context.mpf(case["h"])
        found = wrong_steps(engine, self.method, task.problem, t, values, h)
        wanted = {"abscissae": ("Abscissae",), "backward": ("StepSign",)}.get(
            case["id"].split("/")[0]
        )
        add_wrong(case, (x for x in found if wanted is None or x.flag.startswith(wanted)))

    def reversed(self, task: TestProblem) -> dict[str, Any]:
        """Return the way back: from L times the output of a step, with -h, to L times its input."""
        forward = self._one_step(
            "step", task, Fraction(task.t0), self.bench.values(task), self.bench.size(task)
        )
        engine = self.bench.engine(task)
        context = engine.arithmetic.context
        values = np.array([[context.mpf(x) for x in row] for row in forward["output"]])
        if self.bench.L is not None:
            values = engine.arithmetic.array(self.bench.L).dot(values)
        given = [[Fraction(x) for x in row] for row in decimals(values, SHOWN)]
        case = self._one_step("symmetric", task, Fraction(task.t0), given, -self.bench.size(task))
        case["input"] = decimals(values, SHOWN)
        case["of"] = f"step/{self.name}/{task.name}"
        return case

    def _conserved(self, task: TestProblem, case: Mapping[str, Any]) -> str | None:
        """Return the value of ``sum G_ij y_i^T C y_j``, proved equal before and after the step."""
        assert self.bench.G is not None and task.quadratic is not None
        C = [[Fraction(x) for x in row] for row in task.quadratic]
        half = len(C) // 2
        if self.bench.pair and any(
            C[i][j] for i in range(len(C)) for j in range(len(C)) if (i < half) == (j < half)
        ):
            return None  # a pair conserves forms that join q and p only
        ends = [[[Fraction(x) for x in row] for row in case[key]] for key in ("input", "output")]
        values = [conserved_form(self.bench.G, C, rows) for rows in ends]
        size = (values[0] - values[1]).magnitude()
        if size > 1e-36:
            raise DataError(f"{case['id']}: the conserved form changes by {size:g}")
        return decimal_text(values[0], SHOWN)

    def start(self, task: TestProblem) -> dict[str, Any]:
        """Return starting values of the method's own starting method."""
        assert self.method.starting is not None
        engine, h = self.bench.engine(task), self.bench.size(task)
        context = engine.arithmetic.context
        t = context.mpf(task.t0)
        y0 = np.array(engine.problem.y0)
        size = context.mpf(h.numerator) / h.denominator
        values, _ = apply_start(self.method.starting, engine, t, y0, size)
        stages = self.bench.inner_stages(self.method.starting.A, task, t, y0, size)
        case = self._ends("start", task, self.method.starting, h, [list(task.y0)], values, stages)
        case["y0"] = list(task.y0)
        del case["input"]
        add_wrong(case, wrong_start(self.method, engine, t, y0, size))
        return case

    def finish(self, task: TestProblem) -> dict[str, Any]:
        """Return the solution that the method's own finishing method makes of the values."""
        assert self.method.finishing is not None
        engine, h = self.bench.engine(task), self.bench.size(task)
        context = engine.arithmetic.context
        values = self.bench.numbers(engine, self.bench.values(task))
        size = context.mpf(h.numerator) / h.denominator
        finishing, t = self.method.finishing, context.mpf(task.t0)
        output = engine.solution(values)
        solution, _ = apply_finish(finishing, engine, t, output, size)
        stages = self.bench.inner_stages(finishing.A, task, t, output, size)
        (first,) = self.bench.read_off(self.bench.values(task))
        given = [[exact_decimal(x) for x in first]]
        case = self._ends("finish", task, finishing, h, given, solution[None, :], stages)
        case["input"] = [[exact_decimal(x) for x in row] for row in self.bench.values(task)]
        add_wrong(case, [Wrong("FinishSkipped", output[None, :])])
        return case

    def _ends(
        self, claim: str, task: TestProblem, method: Method, h: Fraction, given: list[list[str]],
        output: np.ndarray, stages: Sequence[Sequence[Any]],
    ) -> dict[str, Any]:  # fmt: skip
        """Return a case of a starting or finishing method."""
        rows = [[Fraction(x) for x in row] for row in given]
        engine = self.bench.engine(task)
        context, shown = engine.arithmetic.context, decimals(output, SHOWN)
        guesses = [[ball(fraction_of(x)) for x in row] for row in stages]
        enclosed = enclosed_step(
            method, ball_field(task.expressions), Fraction(task.t0), rows, h, guesses
        )
        values = self.bench.numbers(engine, rows)
        time, size = context.mpf(task.t0), context.mpf(h.numerator) / h.denominator
        return {
            "id": f"{claim}/{self.name}/{task.name}",
            "kind": claim,
            "problem": task.name,
            "t": task.t0,
            "h": exact_decimal(h),
            "input": given,
            "output": shown,
            "bound": bound_of(([], enclosed[1]), [[], shown], self.bench.doubt),
            "rounding": self.bench.rounding(method, task, time, values, size, stages),
            "flags": [],
        }
