"""A step over any numbers: mpmath, balls, numbers with an error bound.

A GLM, a partitioned pair, a starting method and a finishing method are all one thing here: stages,
each a sum of given rows and of slopes of stages, and rows that come out. This is not the engine's
code, so that the engine's numbers can be confirmed by it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..exact import Ball, Exact, Scalar, ball
from ..exact.linalg import Matrix
from ..method import GLM, FinishingMethod, PartitionedGLM, StartingMethod
from ..method.solution_value import stage_times
from ..method.stage_order import StageBlock, dependency_blocks
from .expressions import BALL_FUNCTIONS, Bounded, bounded_functions, evaluate

__all__ = ["Field", "Scheme", "ball_field", "enclosed_step", "error_bound", "error_field"]

#: slope of a stage: ``field(kind, time, stage vector)``, kind one of "f", "dq", "dp"
Field = Callable[[str, Any, Sequence[Any]], list[Any]]
Rows = Sequence[Sequence[Any]]
Terms = tuple[tuple[int, Scalar], ...]
#: Rounds of inflation, each by this factor. A map that contracts by a factor near 1 needs many.
_ROUNDS, _INFLATION = 60, Fraction(11, 10)


@dataclass(frozen=True)
class Stage:
    """One stage: which rows and slopes it sums, and where its slope comes from.

    Attributes
    ----------
        part: half of the components it lives in: 0 all, 1 the first (q), 2 the second (p).
        rows, slopes: (index, coefficient) of the terms that are not zero.
        kind: the function evaluated at it. c: its abscissa.
    """

    part: int
    rows: Terms
    slopes: Terms
    kind: str
    c: Scalar


@dataclass(frozen=True)
class Scheme:
    """Stages, and for each part of the components the rows that come out."""

    stages: tuple[Stage, ...]
    outputs: tuple[tuple[int, tuple[tuple[Terms, Terms], ...]], ...]

    @property
    def blocks(self) -> tuple[StageBlock, ...]:
        """Stages in an order in which they can be computed."""
        needs = [{j for j, _ in stage.slopes} for stage in self.stages]
        return dependency_blocks(len(self.stages), lambda i, j: j in needs[i])

    @classmethod
    def of(cls, method: GLM | PartitionedGLM) -> Scheme:
        """One step of a method; of a pair, the stages Q come before the stages P."""
        if isinstance(method, GLM):
            c = stage_times(method)
            return cls._plain(method.A, method.U, method.B, method.V, c)
        n_q, zero = method.n_Q, Exact(0)
        q = tuple(
            Stage(1, _terms(u), _terms(a, n_q), "dp", zero)
            for a, u in zip(method.A, method.U, strict=True)
        )
        p = tuple(
            Stage(2, _terms(u), _terms(a), "dq", zero)
            for a, u in zip(method.A_hat, method.U_hat, strict=True)
        )
        rows_q = tuple((_terms(v), _terms(b, n_q)) for v, b in zip(method.V, method.B, strict=True))
        rows_p = tuple(
            (_terms(v), _terms(b)) for v, b in zip(method.V_hat, method.B_hat, strict=True)
        )
        return cls((*q, *p), ((1, rows_q), (2, rows_p)))

    @classmethod
    def of_start(cls, start: StartingMethod) -> Scheme:
        """From y0, one row, to the starting values."""
        return cls._plain(start.A, _ones(start.A), start.B, tuple((x,) for x in start.u))

    @classmethod
    def of_finish(cls, finish: FinishingMethod) -> Scheme:
        """From the output of the method, one row, to the solution."""
        return cls._plain(finish.A, _ones(finish.A), (finish.b,), ((Exact(1),),))

    @classmethod
    def _plain(
        cls, A: Matrix, U: Matrix, B: Matrix, V: Matrix, c: Sequence[Scalar] | None = None
    ) -> Scheme:
        c = [sum(row, Exact(0)) for row in A] if c is None else c
        stages = tuple(
            Stage(0, _terms(u), _terms(a), "f", x) for a, u, x in zip(A, U, c, strict=True)
        )
        rows = tuple((_terms(v), _terms(b)) for v, b in zip(V, B, strict=True))
        return cls(stages, ((0, rows),))

    def step(
        self, field: Field, t: Any, values: Rows, h: Any, number: Callable[[Any], Any],
        solve: Callable[..., Rows],
    ) -> tuple[Rows, Rows]:  # fmt: skip
        """Take one step.

        Args:
            number: turns a coefficient into the number type.
            solve: ``solve(indices, update)`` settles stages that depend on each other;
                ``update(stages)`` returns what the right-hand sides make of given stage vectors.

        Returns
        -------
            Stage vectors, and the rows after the step.
        """
        size = len(values[0])
        stages: list[Sequence[Any]] = [[] for _ in self.stages]
        slopes: list[Sequence[Any]] = [[] for _ in self.stages]

        def total(part: int, rows: Terms, of: Terms) -> list[Any]:
            low, high = _columns(part, size)
            sums: list[Any] = [None] * (high - low)
            for k, x in rows:
                sums = [
                    _plus(s, number(x) * v) for s, v in zip(sums, values[k][low:high], strict=True)
                ]
            for j, x in of:
                sums = [_plus(s, h * number(x) * v) for s, v in zip(sums, slopes[j], strict=True)]
            return [number(0) if s is None else s for s in sums]

        def evaluate_at(i: int, where: Sequence[Any]) -> None:
            stage = self.stages[i]
            stages[i] = where
            slopes[i] = field(stage.kind, t + number(stage.c) * h, where)

        for block in self.blocks:
            index = block.stages
            if block.implicit:

                def update(given: Rows, index: tuple[int, ...] = index) -> Rows:
                    for i, where in zip(index, given, strict=True):
                        evaluate_at(i, where)
                    return [
                        total(self.stages[i].part, self.stages[i].rows, self.stages[i].slopes)
                        for i in index
                    ]

                settled = solve(index, update)
                for i, where in zip(index, settled, strict=True):
                    evaluate_at(i, where)
            else:
                stage = self.stages[index[0]]
                evaluate_at(index[0], total(stage.part, stage.rows, stage.slopes))
        count = max(len(rows) for _, rows in self.outputs)
        out: list[list[Any]] = [[] for _ in range(count)]
        for part, rows in self.outputs:
            for k in range(count):
                low, high = _columns(part, size)
                out[k] += total(part, *rows[k]) if k < len(rows) else [number(0)] * (high - low)
        return stages, out


def _columns(part: int, size: int) -> tuple[int, int]:
    return ((0, size), (0, size // 2), (size // 2, size))[part]


def _plus(a: Any, b: Any) -> Any:
    return b if a is None else a + b


def _terms(row: Sequence[Scalar], shift: int = 0) -> Terms:
    return tuple((j + shift, x) for j, x in enumerate(row) if x.is_zero() is not True)


def _ones(A: Matrix) -> Matrix:
    return tuple((Exact(1),) for _ in A)


def _field(texts: Any, functions: Any, number: Any) -> Field:
    """Field of a problem's expressions ``{"f": [..], "dq": [..], "dp": [..]}``."""
    names = {"f": "y", "dq": "p", "dp": "q"}

    def field(kind: str, t: Any, where: Sequence[Any]) -> list[Any]:
        return evaluate(texts[kind], {"t": t, names[kind]: where}, functions, number=number)

    return field


def ball_field(texts: Any) -> Field:
    """Right-hand side over balls."""
    return _field(texts, BALL_FUNCTIONS, ball)


def error_field(texts: Any, context: Any) -> Field:
    """Right-hand side over :class:`Bounded` numbers."""

    def number(x: Fraction) -> Bounded:
        return Bounded(context.mpf(x.numerator) / x.denominator, 0)

    return _field(texts, bounded_functions(context), number)


class Unproved(ArithmeticError):
    """A block of stages whose enclosure could not be shown to contain a solution."""


def enclosed_step(
    scheme: Scheme, field: Field, t: Any, values: Rows, h: Any, guesses: Sequence[Sequence[Any]]
) -> tuple[Rows, Rows]:
    """One step in ball arithmetic, with proof that the stage equations have a solution there.

    A box X around the guesses of a block with ``F(X)`` in its interior, F the right-hand side of
    ``Y = h A f(Y) + U y``, contains a solution by Brouwer's theorem, and so does F(X). When the
    first box is not mapped into itself, the next one is F(X), a little larger: its sides take the
    proportions that F asks for (epsilon inflation: Rump, Acta Numerica 19 (2010), section 10.4).

    Args:
        guesses: stage vectors as balls, good to 50 digits.

    Raises
    ------
        Unproved: when F(X) does not lie inside X.
    """
    known = max((x.radius() for row in values for x in map(ball, row)), default=0.0)

    def solve(index: Sequence[int], update: Callable[[Rows], Rows]) -> Rows:
        # ten times what the rows that are given carry, and room for the guess
        radius = Fraction(1, 10**50) + 10 * Fraction(known)
        box = [[Ball.around(x, radius) for x in guesses[i]] for i in index]
        for _ in range(_ROUNDS):
            image = update(box)
            if all(
                b.contains_interior(x)
                for row, other in zip(box, image, strict=True)
                for b, x in zip(row, other, strict=True)
            ):
                return image
            box = [
                [Ball.around(x, _INFLATION * Fraction((y - x).magnitude()))
                 for x, y in zip(guesses[i], row, strict=True)]
                for i, row in zip(index, image, strict=True)
            ]  # fmt: skip
        raise Unproved(f"stages {[i + 1 for i in index]}: no box around the guess maps into itself")

    given = [[ball(x) for x in row] for row in values]
    return scheme.step(field, ball(t), given, ball(h), _to_ball, solve)


def _to_ball(x: Any) -> Ball:
    return x if isinstance(x, Ball) else x.ball() if isinstance(x, Exact) else ball(x)


def error_bound(
    scheme: Scheme, field: Field, t: Any, values: Rows, h: Any, stages: Rows, context: Any
) -> tuple[Rows, Rows]:
    """One step over :class:`Bounded` numbers: what rounding does to it, to first order.

    Each input, coefficient and operation carries a relative error u. Implicit stages: the error
    solves ``e = |h A| |f'| e + local``, iterated with the values held at the stages given.
    """

    def number(x: Any) -> Bounded:
        if isinstance(x, Bounded):
            return x
        return Bounded.of(context.convert(x.to_mpf()) if hasattr(x, "to_mpf") else context.mpf(x))

    def solve(index: Sequence[int], update: Callable[[Rows], Rows]) -> Rows:
        at = [[Bounded(x, 0 * x) for x in stages[i]] for i in index]
        for _ in range(200):
            new = update(at)
            changed = [
                [Bounded(x.value, y.error) for x, y in zip(row, other, strict=True)]
                for row, other in zip(at, new, strict=True)
            ]
            growth = max(
                y.error - x.error
                for row, other in zip(at, changed, strict=True)
                for x, y in zip(row, other, strict=True)
            )
            at = changed
            if growth <= context.mpf(1) / 1000 * max(x.error for row in at for x in row):
                return at
        raise Unproved("the error bound of the stages does not settle; h is too large")

    given = [[Bounded.of(x) for x in row] for row in values]
    return scheme.step(field, Bounded.of(t), given, Bounded.of(h), number, solve)
