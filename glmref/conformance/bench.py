"""A method on the bench: its engines at several precisions, its inputs, its coefficients."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from ..catalogue.claims import ORDER, ORDER_IDENTITY
from ..engine.reference import Stepper, apply_finish, apply_start, stepper
from ..engine.starting_values import enhanced_start
from ..errors import GlmrefError, UsageError
from ..exact import Ball, Exact
from ..exact.linalg import Matrix
from ..method import GLM, Method, PartitionedGLM
from ..method.preconsistency import outputs, preconsistency_vector, stage_times, unit_place
from ..problems.formula import to_number
from ..prove.facts import facts_of
from .faults import reversal
from .numbers import decimal_text, decimals, upper_text
from .scheme import error_bound, error_field
from .vector_problems import TestProblem

#: Digits of the computation, of the numbers shown, and of the computation of wrong results.
DIGITS, SHOWN, FAULT_DIGITS = 60, 40, 25
#: Sums may be taken in another order, and a fused operation rounds once instead of twice.
SAFETY = 4
#: Digits of starting values that are given.
_START_SHOWN = 20
#: 1/10 and t0 = 7/10 are no dyadic numbers: a clock or step size in single precision shows.
_STEP_SIZE = {"kepler": "0.0625", "forced": "0.1"}


class Bench:
    """One method, ready to step any problem.

    L is the involution of a symmetric method, G the form of a conserving one, ``None`` where not.
    """

    def __init__(self, method: GLM | PartitionedGLM, name: str) -> None:
        self.method, self.name = method, name
        self.pair, self.r = method.parts == 2, method.carried
        self.facts = facts_of(method)
        self.L = self._involution()
        self.G = self._form()
        self.engines: dict[tuple[str, int], Stepper] = {}

    def _form(self) -> Matrix | None:
        try:
            found = self.facts.g_symplecticity
            one_step: Matrix = ((Exact(1),),)
            form = one_step if self.r == 1 else found.G
            # decimals of 70 digits leave the identities open, and hold them to more than is shown
            holds = found.holds or (found.holds is None and found.residual < 10.0**-SHOWN)
            if form is None or not holds or len(form) != self.r:
                return None
            # y_i^T C y_j joins q_i with p_j and p_i with q_j: both are conserved where G = G^T
            return None if self.pair and not _is_symmetric(form) else form
        except GlmrefError:
            return None

    def _involution(self) -> Matrix | None:
        try:
            found = reversal(self.method)
            # symmetry is decided after values that are not needed were left out
            return found if found is not None and len(found) == self.r else None
        except GlmrefError:
            return None

    @cached_property
    def doubt(self) -> Fraction:
        """Largest radius of a coefficient; 0 where all are algebraic numbers or decimals."""
        parts = [self.method, *(getattr(self.method, x, None) for x in ("starting", "finishing"))]
        found = [x.radius() for part in parts for x in _numbers_of(part) if isinstance(x, Ball)]
        return Fraction(max(found, default=0.0))

    def coefficients(self) -> dict[str, Any]:
        """Return every coefficient as a decimal, so that no reader of expressions is needed."""

        def shown(matrix: Matrix) -> list[list[str]]:
            return [[decimal_text(x, SHOWN) for x in row] for row in matrix]

        m = self.method
        found: dict[str, Any] = {}
        blocks = [dict(zip("AUBV", map(shown, c.matrices), strict=True)) for c in m.components]
        if self.pair:
            found |= zip("qp", blocks, strict=True)
            if self.r > 1 and self.G is not None:
                found["G"] = shown(self.G)
            return found
        found |= blocks[0]
        found["c"] = shown((stage_times(m),))[0]
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

    def size(self, task: TestProblem) -> Fraction:
        """Return the step size of a problem's cases."""
        return Fraction(_STEP_SIZE.get(task.name, "0.125"))

    def engine(self, task: TestProblem, digits: int = DIGITS) -> Stepper:
        """Return the stepper of the method on a problem."""
        key = (task.name, digits)
        if key not in self.engines:
            self.engines[key] = stepper(self.method, task.problem, digits=digits)
        return self.engines[key]

    def values(self, task: TestProblem) -> list[list[Fraction]]:
        """Return values that hide nothing: no component is 0, none is what a start would give."""
        y0 = [Fraction(x) for x in task.y0]
        u = [1] * self.r
        if not self.pair and self.r > 1:
            found = preconsistency_vector(self.method.components[0])
            u = [round(float(x)) for x in found or ()]
        return [
            [u[k] * y + (Fraction((7 * k + 5 * i) % 11 - 5, 64) + Fraction(1, 128)) * (k > 0)
             for i, y in enumerate(y0)]
            for k in range(self.r)
        ]  # fmt: skip

    def numbers(self, engine: Stepper, rows: Sequence[Sequence[Fraction]]) -> np.ndarray:
        """Return rows of fractions in the arithmetic of an engine."""
        context = engine.arithmetic.context
        return np.array([[to_number(x, context) for x in row] for row in rows], dtype=object)

    def rounding(
        self, method: Method, task: TestProblem, t: Fraction, rows: Any, h: Fraction, stages: Any
    ) -> str:
        """Return the largest error, in units of round-off, of rounding in stages and output."""
        engine = self.engine(task)
        context, values = engine.arithmetic.context, list(self.numbers(engine, rows))
        field, time, size = (
            error_field(task.expressions, context),
            *self.numbers(engine, [[t, h]])[0],
        )
        found = error_bound(method, field, time, values, size, stages, context)
        return upper_text(SAFETY * max(x.error for part in found for row in part for x in row))

    def begin(
        self, task: TestProblem, h: Fraction, digits: int
    ) -> tuple[Stepper, np.ndarray, list[list[str]] | None]:
        """Return engine, starting values, and these as decimals where the method has no start."""
        engine, y0 = self.engine(task, digits), [[Fraction(x) for x in task.y0]]
        if self.r == 1:
            return engine, self.numbers(engine, y0), None
        own = None if self.pair else self.method.starting
        coarse = engine if own is not None else self.engine(task, FAULT_DIGITS)
        ((t, size),) = self.numbers(coarse, [[Fraction(task.t0), h]])
        (first,) = self.numbers(coarse, y0)
        if own is not None:
            return engine, apply_start(own, engine, t, first, size)[0], None
        # an error O(h^p) at the start leaves the order p of the run, as for the starts of the data
        passes = max(1, min(5, self.facts.kernel.range(ORDER.key).value - 1))
        shown = decimals(enhanced_start(coarse, t, first, size, passes)[0], _START_SHOWN)
        given = [[Fraction(x) for x in row] for row in shown]
        return engine, self.numbers(engine, given), shown

    def shown_order(self) -> int:
        """Return the order that a run shows, with the start and finish of the data, if any."""
        started = getattr(self.method, "starting", None) is not None
        return self.facts.kernel.range((ORDER if started else ORDER_IDENTITY).key).value

    def inner_stages(
        self, A: Matrix, task: TestProblem, t: Any, y: np.ndarray, h: Any
    ) -> Sequence[Sequence[Any]]:
        """Return stages (m, d) of ``Y = y + h A f(Y)``, of a start or a finish.

        There are none where it is explicit.
        """
        if all(x.is_zero() is True for i, row in enumerate(A) for x in row[i:]):
            return []
        one, zero = Exact(1), Exact(0)
        inner = GLM(A=A, U=((one,),) * len(A), B=((zero,) * len(A),), V=((one,),))
        return stepper(inner, task.problem, digits=DIGITS).step(t, y[None, :], h).stages

    def solution(self, engine: Stepper, values: np.ndarray, t: Any, h: Any) -> np.ndarray:
        """Return the solution (d,) of the values, finished where the method has a finish."""
        finishing, y = getattr(self.method, "finishing", None), engine.solution(values)
        return y if finishing is None else apply_finish(finishing, engine, t, y, h)[0]

    def read_off(self, rows: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """Return the solution among values of any number type, as one row.

        Raises
        ------
        UsageError
            For a method whose solution combines several values: its vectors would need the error
            of that sum, which is not followed here.
        """
        out: list[Any] = []
        half = len(rows[0]) // 2
        columns = (slice(0, half), slice(half, None)) if self.pair else (slice(None),)
        for w, part in zip(outputs(self.method.components), columns, strict=True):
            place = unit_place(w)
            if place is None:
                raise UsageError(
                    f"test vectors need a solution that is one of the values, and the output of "
                    f"{self.name} combines several; transform the values first"
                )
            out += rows[place][part]
        return [out]


def _is_symmetric(matrix: Matrix) -> bool:
    return all(
        (x - matrix[j][i]).is_zero() is True
        for i, row in enumerate(matrix)
        for j, x in enumerate(row)
    )


def _numbers_of(part: Any) -> Iterator[Any]:
    """Yield every coefficient of a method, a start or a finish."""
    for c in part.components if part is not None else ():
        yield from (x for matrix in c.matrices for row in matrix for x in row)
