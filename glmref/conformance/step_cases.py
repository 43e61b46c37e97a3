"""Cases of one step: forward, with time, backward, the way back; starts and finishes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from ..engine.reference import Stepper, apply_finish, apply_start
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
        values, ((time, size),) = (self.bench.numbers(engine, x) for x in (given, [[t, h]]))
        taken = engine.step(time, values, size)
        stages = taken.stages if self.bench.pair else (taken.stages,)
        case = self._case(claim, "step", task, self.method, t, h, given, taken.values, stages)
        case["stages"] = dict(zip("QP", case["stages"], strict=True)) if self.bench.pair else (
            case["stages"][0]
        )  # fmt: skip
        return case

    def _case(
        self, claim: str, kind: str, task: TestProblem, method: Method, t: Fraction, h: Fraction,
        given: Sequence[Sequence[Fraction]], output: np.ndarray, stages: Sequence[Any],
    ) -> dict[str, Any]:  # fmt: skip
        """Return the case of a step, or of a starting or finishing method, with what bounds it.

        ``stages`` (.., s, d) are those of each half; only a step shows them.
        """
        shown, flat = decimals(output, SHOWN), [row for part in stages for row in part]
        parts = [decimals(part, SHOWN) for part in stages]
        guesses = [[ball(fraction_of(x)) for x in row] for row in flat]
        enclosed = enclosed_step(method, ball_field(task.expressions), t, given, h, guesses)
        printed = [[row for part in parts for row in part], shown]
        if kind != "step":
            enclosed, printed = ([], enclosed[1]), [[], shown]
        return {
            "id": f"{claim}/{self.name}/{task.name}",
            "kind": kind,
            "problem": task.name,
            "t": exact_decimal(t),
            "h": exact_decimal(h),
            "input": [[exact_decimal(x) for x in row] for row in given],
            **({"stages": parts} if kind == "step" else {}),
            "output": shown,
            "bound": bound_of(enclosed, printed, self.bench.doubt),
            "rounding": self.bench.rounding(method, task, t, given, h, flat),
            "flags": [],
        }

    def _trap(self, case: dict[str, Any], task: TestProblem) -> None:
        """Add to a step what usual bugs make of it."""
        engine = self.bench.engine(task, FAULT_DIGITS)
        given = [[Fraction(x) for x in row] for row in case["input"]]
        times = [[Fraction(case["t"]), Fraction(case["h"])]]
        values, ((t, h),) = (self.bench.numbers(engine, x) for x in (given, times))
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
        output = [[Fraction(x) for x in row] for row in forward["output"]]
        values = self.bench.numbers(engine, output)
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
        starting = self.method.starting
        assert starting is not None
        engine, t, h, ((time, size),) = self._at(task)
        rows = [[Fraction(x) for x in task.y0]]
        (y0,) = self.bench.numbers(engine, rows)
        values, _ = apply_start(starting, engine, time, y0, size)
        stages = self.bench.inner_stages(starting.A, task, time, y0, size)
        case = self._case("start", "start", task, starting, t, h, rows, values, [stages])
        case["y0"] = list(task.y0)
        del case["input"]
        add_wrong(case, wrong_start(self.method, engine, time, y0, size))
        return case

    def finish(self, task: TestProblem) -> dict[str, Any]:
        """Return the solution that the method's own finishing method makes of the values."""
        finishing, given = self.method.finishing, self.bench.values(task)
        assert finishing is not None
        engine, t, h, ((time, size),) = self._at(task)
        output = engine.solution(self.bench.numbers(engine, given))
        solution, _ = apply_finish(finishing, engine, time, output, size)
        stages = self.bench.inner_stages(finishing.A, task, time, output, size)
        rows = self.bench.read_off(given)
        case = self._case(
            "finish", "finish", task, finishing, t, h, rows, solution[None, :], [stages]
        )
        case["input"] = [[exact_decimal(x) for x in row] for row in given]
        add_wrong(case, [Wrong("FinishSkipped", output[None, :])])
        return case

    def _at(self, task: TestProblem) -> tuple[Stepper, Fraction, Fraction, np.ndarray]:
        """Return the engine, time and step size of a problem, and these two as its numbers."""
        engine, t, h = self.bench.engine(task), Fraction(task.t0), self.bench.size(task)
        return engine, t, h, self.bench.numbers(engine, [[t, h]])
