"""Functions of large problems, as plain Python loops that numba can compile as they stand.

A :class:`Loops` wraps a body such as ``gravity(q, params, out)``. The body uses nothing but
arithmetic, ``range``, ``len`` and the functions of :data:`.formula.FUNCTIONS`; so the same body
runs on numpy arrays, on mpmath numbers and, passed through a compiler, on machine numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import FunctionType
from typing import Any

import numpy as np

from ..errors import UsageError
from .formula import Formula, Number, exact_number, functions, to_number
from .precision import on_context


@dataclass(frozen=True)
class Loops:
    """A function given by a plain Python body."""

    #: ``body(*arguments, params, out)`` fills ``out``; with ``shape == ()`` instead
    #: ``body(*arguments, params)`` returns a number. A top-level function, so that its source can
    #: be read and compiled.
    body: Callable[..., Any]
    shape: tuple[int, ...]  #: Shape of the result.
    constants: tuple[Number, ...] = ()  #: Numbers handed to the body as the array ``params``.
    #: ``None`` for numpy in double precision, else an mpmath context.
    context: Any = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        numbers = tuple(exact_number(x, "constants") for x in self.constants)
        object.__setattr__(self, "constants", numbers)

    def __call__(self, *arguments: Any) -> Any:
        """Run the body on a state (d,), or on states in columns (d, m)."""
        *others, last = arguments
        dtype = float if self.context is None else object
        # a copy: a body that writes into its argument must not change the caller's state
        vector = np.array(last, dtype=None if np.iscomplexobj(last) else dtype)
        if not self.shape:
            return self._function(*others, vector, self.params)
        out = np.zeros(self.shape + vector.shape[1:], dtype=vector.dtype)
        self._function(*others, vector, self.params, out)
        return out

    def on(self, context: Any) -> Loops:
        """Return this function evaluated in an mpmath context."""
        return replace(self, context=context)

    @cached_property
    def params(self) -> np.ndarray:
        """The constants as an array of doubles (or of numbers of the context)."""
        dtype = float if self.context is None else object
        return np.array([to_number(x, self.context) for x in self.constants], dtype=dtype)

    @cached_property
    def _function(self) -> Callable[..., Any]:
        """The body with sqrt, sin ... resolved in numpy or in the context."""
        body = self.body
        names = {**body.__globals__, **functions(self.context)}
        return FunctionType(body.__code__, names, body.__name__, body.__defaults__)

    def compiled(self, jit: Callable[..., Any]) -> Callable[..., Any]:
        """Return ``jit(body)``, for example with ``jit = numba.njit``."""
        return jit(self.body)


@dataclass(frozen=True)
class PhaseSpace:
    """The right-hand side (dq(p), dp(q)) of y = (q, p), from its parts."""

    dq: Callable[[Any], Any] | None  #: Function of p, or ``None`` where q' = p.
    dp: Callable[[Any], Any]  #: Function of q.

    def __call__(self, t: Any, y: Any) -> Any:
        """Return f(t, y), shape (d,); (d, m) for states in columns."""
        half = len(y) // 2
        q, p = y[:half], y[half:]
        return np.concatenate([p if self.dq is None else self.dq(p), self.dp(q)])

    def on(self, context: Any) -> PhaseSpace:
        """Return this function evaluated in an mpmath context."""
        return PhaseSpace(on_context(self.dq, context), on_context(self.dp, context))

    def compiled(self, jit: Callable[..., Any]) -> Callable[..., Any]:
        """Return ``jit`` of ``f_into(t, y, params, out)`` around ``jit`` of the force's body.

        Raises
        ------
        UsageError
            When the parts are not plain loops for q'' = g(q).
        """
        if self.dq is not None or not isinstance(self.dp, Loops):
            raise UsageError("only q'' = g(q) with a force written as loops compiles in one piece")
        force = self.dp.compiled(jit)

        def f_into(t, y, params, out):  # type: ignore[no-untyped-def]
            half = len(y) // 2
            for i in range(half):
                out[i] = y[half + i]
            force(y[:half], params, out[half:])

        return jit(f_into)


def join(dq: Callable[..., Any] | None, dp: Callable[..., Any], half: int) -> Callable[..., Any]:
    """Return f(t, y) for y = (q, p) from its parts: one formula where both parts are formulas."""
    if isinstance(dq, Formula) and isinstance(dp, Formula):
        first, second = dq.substituted("p", "y", half), dp.substituted("q", "y", 0)
        return Formula(
            outputs=first.outputs + second.outputs,
            common=first.common + second.common,
            variables=("t", "y"),
            parameters={**first.parameters, **second.parameters},
        )
    return PhaseSpace(dq, dp)


@dataclass(frozen=True)
class QuadraticForm:
    """A conserved quantity y^T C y, C symmetric."""

    terms: Mapping[tuple[int, int], Number]  #: Mapping (i, j) -> coefficient of y_i y_j, i <= j.
    dimension: int  #: Number of components of y.
    #: ``None`` for doubles, else an mpmath context.
    context: Any = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        merged: dict[tuple[int, int], Number] = {}
        for (i, j), value in self.terms.items():
            if not (0 <= i < self.dimension and 0 <= j < self.dimension):
                size = self.dimension
                raise UsageError(f"a quadratic form in {size} components has no entry ({i}, {j})")
            key = (min(i, j), max(i, j))
            merged[key] = merged.get(key, 0) + exact_number(value, f"C[{i}, {j}]")
        object.__setattr__(self, "terms", merged)

    @classmethod
    def of(cls, matrix: Any, dimension: int) -> QuadraticForm:
        """Read a symmetric matrix, shape (d, d).

        Raises
        ------
        UsageError
            For another shape, or a matrix that is not symmetric.
        """
        rows: Sequence[Sequence[Any]] = matrix
        shape = np.shape(np.asarray(rows, dtype=object))
        if shape != (dimension, dimension):
            raise UsageError(f"`C` must have shape {(dimension, dimension)}, got {shape}")
        numbers = [[exact_number(x, "C") for x in row] for row in rows]
        terms: dict[tuple[int, int], Number] = {}
        for i in range(dimension):
            for j in range(i, dimension):
                if numbers[i][j] != numbers[j][i]:
                    raise UsageError(f"`C` must be symmetric, but entries ({i}, {j}) differ")
                if numbers[i][j]:
                    terms[i, j] = numbers[i][j] * (1 if i == j else 2)
        return cls(terms, dimension)

    @cached_property
    def _weights(self) -> list[tuple[int, int, Any]]:
        return [(i, j, to_number(value, self.context)) for (i, j), value in self.terms.items()]

    @cached_property
    def matrix(self) -> np.ndarray:
        """The symmetric matrix C, shape (d, d)."""
        dtype = float if self.context is None else object
        result = np.zeros((self.dimension, self.dimension), dtype=dtype)
        for i, j, value in self._weights:
            result[i, j] += value / 2
            result[j, i] += value / 2
        return result

    def __call__(self, y: Any) -> Any:
        """Return y^T C y; of each column when y has shape (d, m)."""
        return sum(value * y[i] * y[j] for i, j, value in self._weights)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.matrix, dtype=dtype)

    def on(self, context: Any) -> QuadraticForm:
        """Return the form with coefficients in an mpmath context."""
        return replace(self, context=context)
