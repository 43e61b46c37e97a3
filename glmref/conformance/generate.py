"""Make the vectors: mpmath at 60 digits, confirmed in ball arithmetic, wrong results beside them.

``python -m glmref.conformance.generate`` writes ``data/vectors`` anew; with names, these files
only. The result depends on nothing but the method files, the problems and this package: the same
bytes come out on every machine, and a test makes them again.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np

from ..claims import DataError, GlmrefError
from ..engine.reference import Stepper, apply_finish, apply_start, stepper
from ..engine.start import enhanced_start
from ..engine.tableau import method_abscissae, preconsistency
from ..exact import Exact, ball
from ..facts import facts_of
from ..linalg import Matrix
from ..method import GLM, PartitionedGLM
from .numbers import (
    decimal_of,
    decimal_text,
    decimals,
    exact_decimal,
    fraction_of,
    rounded_up,
)
from .scheme import Scheme, ball_field, enclosed_step, error_bound, error_field
from .traps import NOTES, Wrong, reversal, wrong_runs, wrong_start, wrong_steps
from .vectors import FORMAT, TestProblem, problems

__all__ = ["METHODS", "document_of", "layout", "write"]

#: Methods with a vector file.
METHODS = (
    *("rk4", "dormand-prince-5", "gauss-2", "gauss-3", "sdirk-3", "radau-iia-2", "radau-iia-3"),
    *("ab-2", "bdf-2", "leapfrog", "gsymplectic-n", "gsymplectic-p", "thesis-3-8"),
    *("s4-symmetric", "g6245", "g6245-w3", "g4123"),
    *("symplectic-euler-a", "stormer-verlet", "forest-ruth-4", "lobatto-iiia-iiib-3"),
)
DIGITS, SHOWN, WRONG_SHOWN = 60, 40, 17
_TRAP_DIGITS, _START_SHOWN = 25, 20
#: A wrong result is kept when it is off by this many rounding errors of double precision.
_VISIBLE = 10**6
#: Sums may be taken in another order, and a fused operation rounds once instead of twice.
_SAFETY = 4
_STEP_SIZE = {"kepler": "0.0625"}
_RUN_STEPS, _ORDER_STEPS, _ORDER_TIME = 8, (4, 8, 16, 32), 2


def document_of(method: GLM | PartitionedGLM, name: str) -> dict[str, Any]:
    """Return the vector document of a method.

    Raises
    ------
        DataError: for a method whose vectors cannot be made: complex, or not pre-consistent.
    """
    if isinstance(method, GLM) and not method.is_real:
        raise DataError(f"{name}: vectors are made for real methods; take its real form")
    if isinstance(method, GLM) and preconsistency(method.U, method.V) is None:
        raise DataError(f"{name}: the method is not pre-consistent, so nothing can be started")
    maker = _Maker(method, name)
    cases = list(maker.cases())
    used = [flag for flag in NOTES if any(flag in case["flags"] for case in cases)]
    return {
        "format": FORMAT,
        "method": name,
        "generator": {"module": "glmref.conformance.generate", "digits": DIGITS, "version": 1},
        "digits": SHOWN,
        "values": maker.r,
        "coefficients": maker.coefficients(),
        "notes": {flag: dict(zip(("bug", "effect"), NOTES[flag], strict=True)) for flag in used},
        "cases": cases,
    }


class _Maker:
    """Makes the cases of one method."""

    def __init__(self, method: GLM | PartitionedGLM, name: str) -> None:
        self.method, self.name = method, name
        self.pair = isinstance(method, PartitionedGLM)
        self.r = max(method.r, method.r_hat) if isinstance(method, PartitionedGLM) else method.r
        self.scheme = Scheme.of(method)
        self.facts = facts_of(method)
        self.L = self._involution()
        self.G = self._form()
        self.engines: dict[tuple[str, int], Stepper] = {}

    def _form(self) -> Matrix | None:
        try:
            found = self.facts.g_symplecticity
            one_step: Matrix = ((Exact(1),),)
            return None if not found.holds else one_step if self.r == 1 else found.G
        except GlmrefError:
            return None

    def _involution(self) -> Matrix | None:
        try:
            return reversal(self.method)
        except GlmrefError:
            return None

    # --- coefficients ---------------------------------------------------------------------------

    def coefficients(self) -> dict[str, Any]:
        """Every coefficient as a decimal, so that nobody has to read expressions."""

        def shown(matrix: Matrix) -> list[list[str]]:
            return [[decimal_of(x, SHOWN) for x in row] for row in matrix]

        m, found = self.method, {}
        if isinstance(m, PartitionedGLM):
            for part, hat in (("q", ""), ("p", "_hat")):
                found[part] = {x: shown(getattr(m, x + hat)) for x in "AUBV"}
            return found
        found = {x: shown(getattr(m, x)) for x in "AUBV"}
        found["c"] = shown((method_abscissae(m),))[0]
        if self.G is not None:
            found["G"] = shown(self.G)
        if self.L is not None:
            found["L"] = shown(self.L)
        if m.starting is not None:
            start = m.starting
            found["starting"] = {
                "A": shown(start.A), "B": shown(start.B), "u": shown((start.u,))[0]
            }  # fmt: skip
        if m.finishing is not None:
            found["finishing"] = {"A": shown(m.finishing.A), "b": shown((m.finishing.b,))[0]}
        return found

    # --- cases ----------------------------------------------------------------------------------

    def cases(self) -> Iterator[dict[str, Any]]:
        """Every case of the file, in order."""
        usable = [x for x in problems().values() if x.separable or not self.pair]
        for task in usable:
            yield self._step("step" if task.autonomous else "abscissae", task, self._size(task))
        cubic = problems()["cubic"]
        yield self._step("backward", cubic, -self._size(cubic))
        if self.L is not None or (self.pair and self.facts.symmetry.holds):
            yield self._reversed(cubic)
        for task in (problems()["pendulum"], problems()["forced"]):
            if isinstance(self.method, GLM) and self.method.starting is not None:
                yield self._start(task)
            if isinstance(self.method, GLM) and self.method.finishing is not None:
                yield self._finish(task)
        for name in ("pendulum", "kepler", "forced"):
            if problems()[name] in usable:
                yield self._trajectory(problems()[name])
        yield self._order(problems()["pendulum"])

    def _size(self, task: TestProblem) -> Fraction:
        return Fraction(_STEP_SIZE.get(task.name, "0.125"))

    def _engine(self, task: TestProblem, digits: int = DIGITS) -> Stepper:
        key = (task.name, digits)
        if key not in self.engines:
            self.engines[key] = stepper(self.method, task.problem, digits=digits)
        return self.engines[key]

    def _values(self, task: TestProblem) -> list[list[Fraction]]:
        """Values that hide nothing: no component is zero, none is what a start would give."""
        y0 = [Fraction(x) for x in task.y0]
        u = [1] * self.r
        if isinstance(self.method, GLM) and self.r > 1:
            found = preconsistency(self.method.U, self.method.V)
            u = [round(float(x)) for x in found or ()]
        return [
            [u[k] * y + (Fraction((7 * k + 5 * i) % 11 - 5, 64) + Fraction(1, 128)) * (k > 0)
             for i, y in enumerate(y0)]
            for k in range(self.r)
        ]  # fmt: skip

    def _numbers(self, engine: Stepper, rows: Sequence[Sequence[Fraction]]) -> np.ndarray:
        context = engine.arithmetic.context
        out = engine.arithmetic.zeros((len(rows), len(rows[0])))
        for k, row in enumerate(rows):
            out[k, :] = [context.mpf(x.numerator) / x.denominator for x in row]
        return out

    def _step(self, claim: str, task: TestProblem, h: Fraction) -> dict[str, Any]:
        case = self._one_step(claim, task, Fraction(task.t0), self._values(task), h)
        if self.G is not None and claim == "step" and task.quadratic is not None:
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
        engine = self._engine(task)
        values, context = self._numbers(engine, given), engine.arithmetic.context
        size, time = (context.mpf(x.numerator) / x.denominator for x in (h, t))
        taken = engine.step(time, values, size)
        stages = taken.stages if self.pair else (taken.stages,)
        shown = [decimals(part, SHOWN) for part in stages]
        output = decimals(taken.values, SHOWN)
        flat = [row for part in stages for row in part]
        guesses = [[ball(fraction_of(x)) for x in row] for row in flat]
        enclosed = enclosed_step(self.scheme, ball_field(task.expressions), t, given, h, guesses)
        printed = [[row for part in shown for row in part], output]
        rounding = self._rounding(self.scheme, task, time, values, size, flat)
        return {
            "id": f"{claim}/{self.name}/{task.name}",
            "kind": "step",
            "problem": task.name,
            "t": exact_decimal(t),
            "h": exact_decimal(h),
            "input": [[exact_decimal(x) for x in row] for row in given],
            "stages": {"Q": shown[0], "P": shown[1]} if self.pair else shown[0],
            "output": output,
            "bound": _bound(enclosed, printed),
            "rounding": rounding,
            "flags": [],
        }

    def _rounding(
        self, scheme: Scheme, task: TestProblem, t: Any, values: Any, h: Any, stages: Any
    ) -> str:
        """Largest error, in units of the round-off, that rounding makes in stages and output."""
        context = self._engine(task).arithmetic.context
        field = error_field(task.expressions, context)
        rows = error_bound(scheme, field, t, list(values), h, stages, context)
        return rounded_up(_SAFETY * max(x.error for part in rows for row in part for x in row))

    def _trap(self, case: dict[str, Any], task: TestProblem) -> None:
        """Add to a step what usual bugs make of it."""
        engine = self._engine(task, _TRAP_DIGITS)
        given = [[Fraction(x) for x in row] for row in case["input"]]
        values, context = self._numbers(engine, given), engine.arithmetic.context
        t, h = context.mpf(case["t"]), context.mpf(case["h"])
        found = wrong_steps(engine, self.method, task.problem, t, values, h)
        wanted = {"abscissae": ("Abscissae",), "backward": ("StepSign",)}.get(
            case["id"].split("/")[0]
        )
        _add_wrong(case, (x for x in found if wanted is None or x.flag.startswith(wanted)))

    def _reversed(self, task: TestProblem) -> dict[str, Any]:
        """The way back: from L times the output of a step, with -h, to L times its input."""
        forward = self._one_step(
            "step", task, Fraction(task.t0), self._values(task), self._size(task)
        )
        engine = self._engine(task)
        context = engine.arithmetic.context
        values = np.array([[context.mpf(x) for x in row] for row in forward["output"]])
        if self.L is not None:
            values = engine.arithmetic.array(self.L).dot(values)
        given = [[Fraction(x) for x in row] for row in decimals(values, SHOWN)]
        case = self._one_step("symmetric", task, Fraction(task.t0), given, -self._size(task))
        case["input"] = decimals(values, SHOWN)
        case["of"] = f"step/{self.name}/{task.name}"
        return case

    def _conserved(self, task: TestProblem, case: Mapping[str, Any]) -> str | None:
        """Value of ``sum G_ij y_i^T C y_j``, proved equal before and after the step."""
        assert self.G is not None and task.quadratic is not None
        C = [[Fraction(x) for x in row] for row in task.quadratic]
        half = len(C) // 2
        if self.pair and any(
            C[i][j] for i in range(len(C)) for j in range(len(C)) if (i < half) == (j < half)
        ):
            return None  # a pair conserves forms that join q and p only
        ends = [[[Fraction(x) for x in row] for row in case[key]] for key in ("input", "output")]
        values = [_form(self.G, C, rows) for rows in ends]
        size = (values[0] - values[1]).magnitude()
        if size > 1e-36:
            raise DataError(f"{case['id']}: the conserved form changes by {size:g}")
        return decimal_of(values[0], SHOWN)

    def _start(self, task: TestProblem) -> dict[str, Any]:
        assert isinstance(self.method, GLM) and self.method.starting is not None
        engine, h = self._engine(task), self._size(task)
        context = engine.arithmetic.context
        t = context.mpf(task.t0)
        y0 = np.array(engine.problem.y0)
        size = context.mpf(h.numerator) / h.denominator
        values, _ = apply_start(self.method.starting, engine, t, y0, size)
        scheme = Scheme.of_start(self.method.starting)
        case = self._ends("start", task, scheme, h, [list(task.y0)], values)
        case["y0"] = list(task.y0)
        del case["input"]
        _add_wrong(case, wrong_start(self.method, engine, t, y0, size))
        return case

    def _finish(self, task: TestProblem) -> dict[str, Any]:
        assert isinstance(self.method, GLM) and self.method.finishing is not None
        engine, h = self._engine(task), self._size(task)
        context = engine.arithmetic.context
        values = self._numbers(engine, self._values(task))
        size = context.mpf(h.numerator) / h.denominator
        solution, _ = apply_finish(
            self.method.finishing, engine, context.mpf(task.t0), values[0], size
        )
        scheme = Scheme.of_finish(self.method.finishing)
        first = [exact_decimal(x) for x in self._values(task)[0]]
        case = self._ends("finish", task, scheme, h, [first], solution[None, :])
        case["input"] = [[exact_decimal(x) for x in row] for row in self._values(task)]
        _add_wrong(case, [Wrong("FinishSkipped", values[:1])])
        return case

    def _ends(
        self, claim: str, task: TestProblem, scheme: Scheme, h: Fraction, given: list[list[str]],
        output: np.ndarray,
    ) -> dict[str, Any]:  # fmt: skip
        """A case of a starting or finishing method."""
        rows = [[Fraction(x) for x in row] for row in given]
        engine = self._engine(task)
        context, shown = engine.arithmetic.context, decimals(output, SHOWN)
        enclosed = enclosed_step(
            scheme, ball_field(task.expressions), Fraction(task.t0), rows, h, self._guesses(scheme)
        )
        values = self._numbers(engine, rows)
        time, size = context.mpf(task.t0), context.mpf(h.numerator) / h.denominator
        return {
            "id": f"{claim}/{self.name}/{task.name}",
            "kind": claim,
            "problem": task.name,
            "t": task.t0,
            "h": exact_decimal(h),
            "input": given,
            "output": shown,
            "bound": _bound(([], enclosed[1]), [[], shown]),
            "rounding": self._rounding(scheme, task, time, values, size, []),
            "flags": [],
        }

    def _guesses(self, scheme: Scheme) -> list[list[Any]]:
        if any(block.implicit for block in scheme.blocks):
            raise DataError(f"{self.name}: vectors of implicit starting methods are not made")
        return [[] for _ in scheme.stages]

    # --- runs -----------------------------------------------------------------------------------

    def _begin(
        self, task: TestProblem, h: Fraction, digits: int
    ) -> tuple[Stepper, np.ndarray, list[list[str]] | None]:
        """Engine, starting values, and these as decimals where the method has no start."""
        engine = self._engine(task, digits)
        context = engine.arithmetic.context
        y0, t = np.array(engine.problem.y0), context.mpf(task.t0)
        size = context.mpf(h.numerator) / h.denominator
        if self.pair or self.r == 1:
            return engine, y0[None, :], None
        assert isinstance(self.method, GLM)
        if self.method.starting is not None:
            return engine, apply_start(self.method.starting, engine, t, y0, size)[0], None
        coarse = self._engine(task, _TRAP_DIGITS)
        # an error O(h^p) at the start leaves the order p of the run, as for the starts of the data
        passes = max(1, min(5, self.facts.order.order - 1))
        first = np.array(coarse.problem.y0)
        small = coarse.arithmetic.context
        values, _ = enhanced_start(
            coarse, small.mpf(task.t0), first, small.mpf(h.numerator) / h.denominator, passes
        )
        shown = decimals(values, _START_SHOWN)
        return engine, np.array([[context.mpf(x) for x in row] for row in shown]), shown

    def _trajectory(self, task: TestProblem) -> dict[str, Any]:
        h = self._size(task)
        engine, values, given = self._begin(task, h, DIGITS)
        run = _Run(self, task, engine, values, given, h)
        for _ in range(_RUN_STEPS):
            run.advance()
        case = {
            "id": f"trajectory/{self.name}/{task.name}",
            "kind": "trajectory",
            "problem": task.name,
            "t": task.t0,
            "h": exact_decimal(h),
            "steps": _RUN_STEPS,
            "y0": list(task.y0),
            **({} if given is None else {"input": given}),
            "solution": run.shown,
            "output": decimals(run.values, SHOWN),
            "bound": rounded_up(run.distance, 1),
            "rounding": rounded_up(_SAFETY * run.error),
            "flags": [],
        }
        coarse, values, _ = self._begin(task, h, _TRAP_DIGITS)
        context = coarse.arithmetic.context
        t0, size = context.mpf(task.t0), context.mpf(h.numerator) / h.denominator
        if task.name != "kepler":
            found = wrong_runs(coarse, self.method, task.problem, t0, values, size, _RUN_STEPS)
            if task.name == "forced":
                found = (x for x in found if x.flag == "TimeNotAdvanced")
            _add_wrong(case, found, right=run.shown[-1:])
        return case

    def _order(self, task: TestProblem) -> dict[str, Any]:
        """Errors at t = 2 for steps 1/2 to 1/16, against the exact solution."""
        exact_end = _pendulum_end(task)
        rows = []
        for steps in _ORDER_STEPS:
            h = Fraction(_ORDER_TIME, steps)
            engine, values, given = self._begin(task, h, _TRAP_DIGITS)
            context = engine.arithmetic.context
            size = context.mpf(h.numerator) / h.denominator
            for n in range(steps):
                values = engine.step(n * size, values, size).values
            y = self._solution(engine, values, context.mpf(_ORDER_TIME), size)
            error = max(abs(a - context.mpf(b)) for a, b in zip(y, exact_end, strict=True))
            rows.append(
                {
                    "steps": steps,
                    **({} if given is None else {"input": given}),
                    "error": decimal_text(error, 6),
                }
            )
        order = self._claimed_order()
        return {
            "id": f"order{order}/{self.name}/{task.name}",
            "kind": "order",
            "problem": task.name,
            "t": task.t0,
            "t_end": str(_ORDER_TIME),
            "y0": list(task.y0),
            "order": order,
            "exact": list(exact_end),
            "rows": rows,
            "bound": "1e-40",
            "flags": [],
        }

    def _claimed_order(self) -> int:
        """Order that a run shows: with the start and finish of the data where they are there."""
        started = getattr(self.method, "starting", None) is not None
        facts = self.facts
        return facts.classical_order.order if started else facts.order_identity.order

    def _solution(self, engine: Stepper, values: np.ndarray, t: Any, h: Any) -> np.ndarray:
        finishing = getattr(self.method, "finishing", None)
        return (
            values[0] if finishing is None else apply_finish(finishing, engine, t, values[0], h)[0]
        )


class _Run:
    """A run in mpmath, followed by balls and by error bounds."""

    def __init__(
        self, maker: _Maker, task: TestProblem, engine: Stepper, values: np.ndarray,
        given: list[list[str]] | None, h: Fraction,
    ) -> None:  # fmt: skip
        self.maker, self.task, self.engine, self.values, self.h = maker, task, engine, values, h
        self.context = engine.arithmetic.context
        self.size = self.context.mpf(h.numerator) / h.denominator
        self.n = 0
        self.balls_field = ball_field(task.expressions)
        self.errors_field = error_field(task.expressions, self.context)
        rows = [list(task.y0)] if given is None else given
        self.balls: list[list[Any]] = [[ball(Fraction(x)) for x in row] for row in rows]
        self.errors: list[list[Any]] = self._numbers(rows)
        starting = getattr(maker.method, "starting", None)
        if given is None and starting is not None:
            scheme = Scheme.of_start(starting)
            self.balls, self.errors = self._both(scheme, self.balls, self.errors, [])
        self.shown: list[list[str]] = []
        self.distance, self.error = Fraction(0), self.context.mpf(0)
        self._show()

    def _numbers(self, rows: Sequence[Sequence[str]]) -> list[list[Any]]:
        return [[self.context.mpf(x) for x in row] for row in rows]

    def _both(
        self, scheme: Scheme, balls: Any, errors: Any, stages: Any
    ) -> tuple[list[list[Any]], list[list[Any]]]:
        t = Fraction(self.task.t0) + self.n * self.h
        time = self.context.mpf(self.task.t0) + self.n * self.size
        guesses = [[ball(fraction_of(x)) for x in row] for row in stages] or [
            [] for _ in scheme.stages
        ]
        _, new = enclosed_step(scheme, self.balls_field, t, balls, self.h, guesses)
        _, bounds = error_bound(
            scheme, self.errors_field, time, errors, self.size, stages, self.context
        )
        return new, bounds

    def advance(self) -> None:
        """Take one step and show the solution after it."""
        time = self.context.mpf(self.task.t0) + self.n * self.size
        taken = self.engine.step(time, self.values, self.size)
        stages = [row for part in taken.stages for row in part] if self.maker.pair else taken.stages
        self.balls, self.errors = self._both(self.maker.scheme, self.balls, self.errors, stages)
        self.values, self.n = taken.values, self.n + 1
        self._show()

    def _show(self) -> None:
        """Print the solution (finished), and measure how far it is from the enclosure."""
        first, errors = self.balls[:1], self.errors[:1]
        finishing = getattr(self.maker.method, "finishing", None)
        if finishing is not None:
            first, errors = self._both(Scheme.of_finish(finishing), first, errors, [])
        time = self.context.mpf(self.task.t0) + self.n * self.size
        solution = self.maker._solution(self.engine, self.values, time, self.size)
        self.shown.append(decimals(solution, SHOWN))
        rows = [(first[0], self.shown[-1])]
        rows += list(zip(self.balls, decimals(self.values, SHOWN), strict=True))
        for enclosed, printed in rows:
            self.distance = max(self.distance, _distance(enclosed, printed))
        parts = [x for row in (*errors, *self.errors) for x in row]
        self.error = max([self.error, *(x.error for x in parts if hasattr(x, "error"))])


def _distance(enclosed: Iterable[Any], printed: Iterable[str]) -> Fraction:
    """Proved bound of the distance between the true numbers and the printed ones."""
    return max(
        Fraction((ball(x) - Fraction(text)).magnitude())
        for x, text in zip(enclosed, printed, strict=True)
    )


def _bound(enclosed: Any, printed: Any) -> str:
    distance = max(
        _distance(row, texts)
        for part, shown in zip(enclosed, printed, strict=True)
        for row, texts in zip(part, shown, strict=True)
    )
    if distance > Fraction(1, 10**30):
        raise DataError(f"mpmath and the enclosure differ by {float(distance):g}")
    return rounded_up(distance, 1)


def _form(G: Matrix, C: Sequence[Sequence[Fraction]], rows: Sequence[Sequence[Fraction]]) -> Any:
    total: Any = Exact(0)
    for g_row, left in zip(G, rows, strict=True):
        for g, right in zip(g_row, rows, strict=True):
            value = sum(
                (a * c * b for a, c_row in zip(left, C, strict=True)
                 for c, b in zip(c_row, right, strict=True)),
                Fraction(0),
            )  # fmt: skip
            total = total + g.ball() * value
    return total


def _add_wrong(
    case: dict[str, Any], found: Iterable[Wrong], right: Sequence[Sequence[str]] | None = None
) -> None:
    """Keep the wrong results that can be told from the right one and from each other."""
    right = case["output"] if right is None else right
    tolerance = _VISIBLE * Fraction(case["rounding"]) / 2**53
    kept: list[dict[str, Any]] = []
    for wrong in found:
        shown = decimals(wrong.values, WRONG_SHOWN)
        if all(_apart(shown, other, tolerance) for other in (right, *(x["output"] for x in kept))):
            kept.append({"flag": wrong.flag, "output": shown})
    if kept:
        case["wrong"] = kept
        case["flags"] = list(dict.fromkeys(x["flag"] for x in kept))


def _apart(a: Sequence[Sequence[str]], b: Sequence[Sequence[str]], tolerance: Fraction) -> bool:
    return any(
        abs(Fraction(x) - Fraction(y)) > tolerance
        for row, other in zip(a, b, strict=True)
        for x, y in zip(row, other, strict=True)
    )


@cache
def _pendulum_end(task: TestProblem) -> list[str]:
    """Solution of the pendulum at the end of the order runs.

    By Jacobi's elliptic functions, confirmed by a Taylor series of another module.
    """
    from ..problems import problem
    from ..problems.taylor import taylor_states

    known = problem("pendulum", q0=task.y0[0], p0=task.y0[1])
    context = mpmath.MPContext()
    context.dps = DIGITS
    end = known.on(context).solution(context.mpf(_ORDER_TIME))
    (other,) = taylor_states(task.problem, [_ORDER_TIME], digits=SHOWN + 10)
    shown, again = decimals(end, SHOWN), decimals(other, SHOWN)
    if any(
        abs(Fraction(a) - Fraction(b)) > Fraction(1, 10**SHOWN)
        for a, b in zip(shown, again, strict=True)
    ):
        raise DataError(f"two ways to the end of the pendulum differ: {shown} and {again}")
    return shown


# --- files --------------------------------------------------------------------------------------


def layout(document: Mapping[str, Any]) -> str:
    """Text of a vector document: keys in the order given, a row of numbers on a line."""
    return _write(document, "") + "\n"


def _write(value: Any, margin: str) -> str:
    deeper = margin + " "
    if isinstance(value, Mapping) and value:
        rows = [f"{json.dumps(key)}: {_write(x, deeper)}" for key, x in value.items()]
        return "{\n" + ",\n".join(deeper + row for row in rows) + f"\n{margin}}}"
    if isinstance(value, list) and any(isinstance(x, list | Mapping) for x in value):
        return "[\n" + ",\n".join(deeper + _write(x, deeper) for x in value) + f"\n{margin}]"
    return json.dumps(value)


def checksums(folder: Path) -> str:
    """Return the text of SHA256SUMS for the JSON files of a folder."""
    paths = sorted(folder.glob("*.json"))
    return "".join(
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in paths
    )


def write(folder: Path, names: Sequence[str] = METHODS) -> None:
    """Make the files of these methods anew, and the list of hashes."""
    from ..catalogue import load

    for name in names:
        text = layout(document_of(load(name), name))
        (folder / f"{name}.json").write_text(text, encoding="utf-8")
    (folder / "SHA256SUMS").write_text(checksums(folder), encoding="utf-8")


if __name__ == "__main__":
    from .vectors import folder as home

    write(home(), sys.argv[1:] or METHODS)
