"""A step over balls, and over numbers with an error bound.

The step is that of the reference engine (:class:`glmref.engine.reference.Stepper`), in an
arithmetic that adds term by term and leaves out coefficients that are exact zeros: a proof and a
bound of the rounding errors take no detours. In balls coupled stages are enclosed, not iterated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..engine.arithmetic import Arithmetic
from ..engine.reference import Stepper
from ..exact import Ball, Exact, ball
from ..exact.linalg import Matrix
from ..method import Method
from ..problems.formula import Formula
from .bounded import BALLS, Bounded, bounded

#: slope of a stage: ``field(kind, time, stage vector)``, kind one of "f", "dq", "dp"
Field = Callable[[str, Any, Any], list[Any]]
Rows = Sequence[Sequence[Any]]
#: Rounds of inflation, each by this factor. A map that contracts by a factor near 1 needs many.
_ROUNDS, _INFLATION = 60, Fraction(11, 10)


class _TermByTerm(Arithmetic):
    """Numbers of any type, into which ``convert`` turns a coefficient.

    A coefficient that is exactly zero is the integer 0 and takes no part.
    """

    def __init__(self, convert: Callable[[Any], Any]) -> None:
        super().__init__(None)
        self.convert = convert

    def number(self, x: Any) -> Any:
        """Return a coefficient in the number type."""
        return 0 if isinstance(x, Exact | Ball) and x.is_zero() is True else self.convert(x)

    def array(self, matrix: Matrix) -> np.ndarray:
        """Return a matrix of coefficients."""
        out = np.empty((len(matrix), len(matrix[0]) if matrix else 0), dtype=object)
        for i, row in enumerate(matrix):
            out[i, :] = [self.number(x) for x in row]
        return out

    def zeros(self, shape: tuple[int, ...], like: np.ndarray | None = None) -> np.ndarray:
        """Return zeros of the number type."""
        out = np.empty(shape, dtype=object)
        out[...] = self.convert(0)
        return out

    def localised(self, problem: Any) -> Any:
        """Return the problem, which is in this arithmetic."""
        return problem

    def known(self, U: np.ndarray, values: np.ndarray) -> Sequence[Any]:
        """Return what stages take from the values; ``None`` where it is nothing."""
        return [_added(None, row, values) for row in U]

    def stage(self, known: Any, driving: Sequence[tuple[np.ndarray, np.ndarray]], h: Any) -> Any:
        """Return one stage."""
        for row, slopes in driving:
            known = _added(known, [x if type(x) is int else h * x for x in row], slopes)
        return self.zeros((driving[0][1].shape[1],)) if known is None else known

    def updated(
        self, B: np.ndarray, slopes: np.ndarray, h: Any, V: np.ndarray, values: np.ndarray
    ) -> np.ndarray:
        """Return values after a step."""
        known = self.known(V, values)
        return np.array([self.stage(x, [(b, slopes)], h) for x, b in zip(known, B, strict=True)])


def _added(total: Any, row: Sequence[Any], vectors: np.ndarray) -> Any:
    """Add the vectors times the entries of a row one by one; zeros are left out."""
    for x, vector in zip(row, vectors, strict=True):
        if type(x) is not int:
            total = vector * x if total is None else total + vector * x
    return total


@dataclass(frozen=True)
class _Problem:
    """A right-hand side as the reference engine asks for it."""

    field: Field
    separable: bool
    dimension: int
    name: str = "the problem"
    terms: tuple[Any, ...] = ()

    def f(self, t: Any, y: np.ndarray) -> Any:
        """Return the whole right-hand side."""
        return self.field("f", t, y)

    def dq(self, p: np.ndarray) -> Any:
        """Return the right-hand side of q."""
        return self.field("dq", 0, p)

    def dp(self, q: np.ndarray) -> Any:
        """Return the right-hand side of p."""
        return self.field("dp", 0, q)


def step_over(
    method: Method, field: Field, t: Any, values: Rows, h: Any, convert: Callable[[Any], Any],
    enclose: Callable[..., Rows],
) -> tuple[Rows, Rows]:  # fmt: skip
    """Return one step of a method, a start or a finish: stage vectors (Q before P) and values."""
    problem: Any = _Problem(field, len(method.carriers) > 1, len(values[0]))
    engine = Stepper(method, problem, arithmetic=_TermByTerm(convert))
    taken = engine.step(t, np.array(values, dtype=object), h, enclose=enclose)
    parts = taken.stages if isinstance(taken.stages, tuple) else (taken.stages,)
    return [list(row) for part in parts for row in part], [list(row) for row in taken.values]


def field_over(texts: Mapping[str, Sequence[str]], context: Any) -> Field:
    """Return the field of a problem's expressions ``{"f": [..], "dq": [..], "dp": [..]}``.

    The context is :data:`.bounded.BALLS`, or that of :func:`.bounded.bounded`.
    """
    arguments = {"f": ("t", "y"), "dq": ("p",), "dp": ("q",)}
    known = {k: Formula(tuple(x), variables=arguments[k]).on(context) for k, x in texts.items()}
    return lambda kind, t, where: list(known[kind](*(t, where)[kind != "f" :]))


def ball_field(texts: Mapping[str, Sequence[str]]) -> Field:
    """Return the right-hand side over balls."""
    return field_over(texts, BALLS)


def error_field(texts: Mapping[str, Sequence[str]], context: Any) -> Field:
    """Return the right-hand side over :class:`.Bounded` numbers."""
    return field_over(texts, bounded(context))


class Unproved(ArithmeticError):
    """A block of stages whose enclosure could not be shown to contain a solution."""


def enclosed_step(
    method: Method, field: Field, t: Any, values: Rows, h: Any, guesses: Sequence[Sequence[Any]]
) -> tuple[Rows, Rows]:
    """Take one step in ball arithmetic and prove that the stage equations have a solution there.

    A box X around the guesses of a block (balls, good to 50 digits) with ``F(X)`` in its interior,
    F the right-hand side of ``Y = h A f(Y) + U y``, contains a solution by Brouwer's theorem, and
    so does F(X). When the first box is not mapped into itself, the next one is F(X), a little
    larger: its sides take the proportions that F asks for (epsilon inflation: Rump, Acta Numerica
    19 (2010), section 10.4). The method may be a start or a finish.

    Raises
    ------
    Unproved
        When F(X) does not lie inside X.
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
    return step_over(method, field, ball(t), given, ball(h), _to_ball, solve)


def _to_ball(x: Any) -> Ball:
    return x if isinstance(x, Ball) else x.ball() if isinstance(x, Exact) else ball(x)


def error_bound(
    method: Method, field: Field, t: Any, values: Rows, h: Any, stages: Rows, context: Any
) -> tuple[Rows, Rows]:
    """Return one step over :class:`Bounded` numbers: what rounding does to it, to first order.

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
    return step_over(method, field, Bounded.of(t), given, Bounded.of(h), number, solve)
