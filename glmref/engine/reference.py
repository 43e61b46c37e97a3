"""The step as one reads it in a paper: the yardstick, not the fast path.

    Y = h A f(Y) + U y        y+ = h B f(Y) + V y

for every GLM (explicit, diagonally or fully implicit, real or complex) and every pair, in any
arithmetic: double precision (numpy), any number of digits (mpmath), and what else has the methods
of :class:`.arithmetic.Arithmetic` (the conformance suite steps in balls and in numbers with error
bounds). Stage equations are iterated to round-off: until the change is zero or no longer decreases.
Nothing is rearranged, so that a compiled kernel can be compared with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from ..errors import UsageError
from ..method import Component, FinishingMethod, Method
from ..method.component import GENERAL, SEPARABLE, Palette
from ..method.preconsistency import output, unit_place
from ..method.stage_order import is_shared
from ..problems.formula import Formula
from ..problems.model import Problem
from .arithmetic import Arithmetic, StageSolver, size, solution_of
from .outcome import StartFailed, all_finite


class Reader(NamedTuple):
    """How the solution of one component is read off its values."""

    columns: slice  #: Of the state, those of the component.
    #: Of the value that is the solution, or ``None`` where several values are combined.
    place: int | None
    weights: np.ndarray  #: (r,) output functional in the arithmetic of the run.


@dataclass(frozen=True, eq=False)
class Step:
    """One step and what happened inside it."""

    values: np.ndarray  #: (r, d) values after the step; for a pair see :class:`.outcome.Solution`.
    #: As in :class:`.outcome.Solution`.
    evaluations: int
    velocity_evaluations: int
    iterations: int
    converged: bool  #: Whether every stage equation was solved to round-off.
    inside: _Step  #: What it went through.

    @property
    def stages(self) -> Any:
        """(s, d) the Y_i; for a pair (n_Q, d/2) of Q followed by (n_P, d/2) of P as a tuple."""
        return self.inside.shown()[0]

    @property
    def slopes(self) -> Any:
        """The right-hand side at the stages, in the same shape."""
        return self.inside.shown()[1]


class Coupled(NamedTuple):
    """Equations of m coupled stages: ``Y = base + h inner F``, ``F_i = f(times_i, Y_i)``."""

    h: Any  #: Step size.
    inner: np.ndarray  #: (m, m).
    times: list[Any]  #: (m,).
    base: np.ndarray  #: (m, d).


#: ``settle(rhs, F, coupled)``: slopes (m, d) of coupled stages. ``rhs(F)`` is f at the stages
#: that the slopes F make; the F given are those at ``base``.
Settle = Callable[[Callable[[np.ndarray], np.ndarray], np.ndarray, Coupled], np.ndarray]

#: ``enclose(stages, update)``: coupled stages, by their numbers, where ``update`` makes of given
#: stage vectors those that the right-hand sides there ask for.
Enclose = Callable[[Sequence[int], Callable[[Any], Any]], Any]


def _shaped(found: Any, like: np.ndarray, name: str) -> np.ndarray:
    """Return what a user's function returned, as an array of the shape of its argument."""
    array = np.asarray(found)
    if array.shape != like.shape:
        raise UsageError(f"`{name}` must return shape {like.shape}, got {array.shape}")
    return array


class _Component:
    """The coefficients of one component in the arithmetic of a run, and the columns it moves."""

    def __init__(self, c: Component, number: Arithmetic, columns: slice) -> None:
        self.A, self.U, self.B, self.V = map(number.array, c.matrices)
        slopes = len(c.B[0]) if c.B else 0
        self.A = self.A.reshape(len(c.A), slopes)
        self.U = self.U.reshape(len(c.A), self.V.shape[1])
        self.columns = columns


def _matrix(letter: str) -> property:
    """Return a coefficient matrix of the first component."""
    return property(lambda engine: getattr(engine.components[0], letter))


def palette_of(method: Method, problem: Problem) -> Palette:
    """Return which stages the right-hand sides of a problem join, see :class:`Stepper`."""
    if method.parts == 1:
        return method.palette
    return SEPARABLE if problem.separable else GENERAL


class Stepper:
    """Steps one method on one problem; keeps the coefficients in the arithmetic asked for.

    Every stage is computed once, when those it needs are there, and every right-hand side is
    evaluated only where its stage is due. On a separable problem y = (q, p) the stages Q and P of a
    partitioned method are apart; on another one stage i is the point (Q_i, P_i). The right-hand
    sides of an additive method are the ``terms`` of the problem, all at one stage.

    Parameters
    ----------
    method : Method
        A method of any number of components, or a start or a finish.
    problem : Problem
        In double precision form; it is moved to the arithmetic here.
    digits : int or None
        ``None`` for double precision, else decimal digits of mpmath.
    arithmetic : Arithmetic or None
        Instead of ``digits``, and then the problem is in it already.

    Raises
    ------
    UsageError
        For a problem without the parts that the method needs.
    """

    A, U, B, V = map(_matrix, "AUBV")

    def __init__(
        self, method: Method, problem: Problem, *, digits: int | None = None,
        arithmetic: Arithmetic | None = None,
    ) -> None:  # fmt: skip
        self.arithmetic = arithmetic or Arithmetic(digits)
        self.problem = self.arithmetic.localised(problem)
        _check(method, problem)
        self._take(method)

    def _take(self, method: Method, palette: Palette | None = None) -> None:
        self.method = method
        parts, d = len(method.carriers), self.problem.dimension
        self.parts: tuple[slice, ...] = (
            (slice(None),) if parts == 1 else (slice(0, d // 2), slice(d // 2, d))
        )
        owners = [0] * len(method.components) if parts == 1 else range(parts)
        self.components = [
            _Component(c, self.arithmetic, self.parts[n])
            for c, n in zip(method.components, owners, strict=True)
        ]
        self.palette = palette_of(method, self.problem) if palette is None else palette
        self.joint = is_shared(self.palette)
        sizes = [len(c.U) for c in method.carriers[: 1 if self.joint else parts]]
        #: the stages: the components that live there, and the row
        self.nodes = [
            ([n] if len(sizes) > 1 else list(range(parts)), i)
            for n, size in enumerate(sizes)
            for i in range(size)
        ]
        self.c = np.concatenate(
            [self.arithmetic.array((x,))[0] for x in method.times[: len(sizes)]]
        )
        self.blocks = method.stage_blocks(self.palette)
        #: Whether the halves of a pair have the same stages, evaluated together.
        self.alike = parts == 2 and self.joint and method.components[0].A == method.components[1].A

    @cached_property
    def tableaux(self) -> dict[int, tuple[Method, Stepper]]:
        """Steppers of starts and finishes, by identity: to round one costs more than a step."""
        return {}

    def of(self, tableau: Method) -> Stepper:
        """Return the stepper of a start or a finish on the same problem, which is kept.

        Stages that nothing reads are left out. Explicit ones are summed term by term: a last digit
        of the start decides when a parasitic part is seen.
        """
        known = self.tableaux.get(id(tableau))
        if known is None:
            other = Stepper.__new__(Stepper)
            other.arithmetic, other.problem = self.arithmetic, self.problem
            other._take(tableau, self.palette)
            read = tableau.read_stages(self.palette)
            other.blocks = tuple(b for b in other.blocks if not read.isdisjoint(b.stages))
            if not any(b.implicit for b in other.blocks):
                other.arithmetic = self.arithmetic.ordered
            known = self.tableaux[id(tableau)] = tableau, other
        return known[1]

    @property
    def shape(self) -> tuple[int, int]:
        """Shape (r, d) of the values carried, r the largest of a component."""
        return self.method.carried, self.problem.dimension

    @cached_property
    def readers(self) -> tuple[Reader, ...]:
        """How the solution is read off the values, component by component."""
        return tuple(
            Reader(columns, unit_place(w), self.arithmetic.array((w,))[0])
            for columns, w in zip(self.parts, map(output, self.method.carriers), strict=True)
        )

    @cached_property
    def weights(self) -> np.ndarray:
        """The output functional as weights (r, d) of all numbers of the values."""
        weights = self.arithmetic.zeros(self.shape)
        for reader in self.readers:
            weights[: len(reader.weights), reader.columns] = reader.weights[:, None]
        return weights

    @property
    def first_value(self) -> bool:
        """Whether the solution is the first value itself."""
        return all(reader.place == 0 for reader in self.readers)

    def solution(self, values: np.ndarray) -> np.ndarray:
        """Return the solution among values (r, d) or (n, r, d), before a finishing method.

        Where each component is one of the values these are its very bits.
        """
        if self.first_value:
            return values[..., 0, :]
        parts = [
            solution_of(weights, values[..., columns])
            if place is None
            else values[..., place, columns]
            for columns, place, weights in self.readers
        ]
        return np.ascontiguousarray(np.concatenate(parts, axis=-1))

    def in_range(self, values: np.ndarray) -> bool:
        """Return whether values (r, d) are finite, and the solution that may be a sum of them."""
        return all_finite(values) and (self.first_value or all_finite(self.solution(values)))

    def slope(self, t: Any, y: np.ndarray) -> np.ndarray:
        """Return the right-hand side at (t, y), shape (d,).

        Raises
        ------
        UsageError
            When the function returns another shape.
        """
        return _shaped(self.problem.f(t, y), y, "f")

    def step(
        self, t: Any, values: np.ndarray, h: Any, *, settle: Settle | None = None,
        enclose: Enclose | None = None,
    ) -> Step:  # fmt: skip
        """Take one step of size h from the values at time t.

        ``settle`` finds the slopes of coupled stages, by default by iteration to round-off, for
        methods with one component; ``enclose`` finds coupled stages themselves, in place of
        iteration.
        """
        return _Step(self, t, values, h).taken(settle, enclose)


class _Step:
    """One step on its way: what is known of its stages and slopes."""

    def __init__(self, engine: Stepper, t: Any, values: np.ndarray, h: Any) -> None:
        self.engine, self.t, self.h, self.values = engine, t, h, values
        like = values + engine.V[0, 0]
        zeros, d = engine.arithmetic.zeros, values.shape[1]
        self.additive = engine.method.additive
        self.known, self.slopes = [], []
        for c in engine.components:
            width = len(range(d)[c.columns])
            self.known.append(engine.arithmetic.known(c.U, values[: c.V.shape[1], c.columns]))
            self.slopes.append(zeros((c.B.shape[1], width), like))
        #: Known part and slopes (s, d) of both halves where a stage is one sum over both.
        self.whole: tuple[np.ndarray, np.ndarray] | None = None
        if engine.alike:
            slopes = np.concatenate(self.slopes, axis=1)
            self.whole = np.concatenate(self.known, axis=1), slopes
            self.slopes = [slopes[:, c.columns] for c in engine.components]
        self.where: list[Any] = [None] * len(engine.nodes)
        self.counts = [0, 0]

    def sum_at(self, node: int) -> np.ndarray:
        """Return the stage that the slopes as they are make."""
        engine, (whose, i) = self.engine, self.engine.nodes[node]
        sums = engine.arithmetic.stage
        if self.whole is not None:
            known, slopes = self.whole
            return sums(known[i], ((engine.components[0].A[i], slopes),), self.h)
        if len(whose) == 1 and not self.additive:
            (n,) = whose
            return sums(self.known[n][i], ((engine.components[n].A[i], self.slopes[n]),), self.h)
        among = range(len(engine.components)) if self.additive else whose
        driving = [(engine.components[n].A[i], self.slopes[n]) for n in among]
        if self.additive:
            return sums(self.known[0][i], driving, self.h)
        rows = [sums(self.known[n][i], [x], self.h) for n, x in zip(whose, driving, strict=True)]
        return rows[0] if len(rows) == 1 else np.concatenate(rows)

    def evaluate(self, node: int, y: np.ndarray) -> None:
        """Evaluate at a stage what is due there."""
        engine, (whose, i) = self.engine, self.engine.nodes[node]
        problem = engine.problem
        self.where[node] = y
        time = self.t + engine.c[node] * self.h
        if self.additive:
            self.counts[0] += 1
            for n, term in enumerate(problem.terms):
                self.slopes[n][i] = _shaped(term(time, y), y, "terms")
        elif engine.joint:
            self.counts[0] += 1
            slope = engine.slope(time, y)
            for n in whose:
                self.slopes[n][i] = slope[engine.components[n].columns]
        else:  # f = dq is evaluated at the stages P of the component k, and k = dp at the stages Q
            name = ("dp", "dq")[whose[0]]
            self.counts[whose[0]] += 1
            self.slopes[1 - whose[0]][i] = _shaped(getattr(problem, name)(y), y, name)

    def _formulas(self, nodes: Sequence[int]) -> list[tuple[int, Formula, list[int], Any]]:
        """Return coupled stages that formulas in double precision take as columns, by component.

        Its number, what is evaluated there, the rows of the stages and their coefficients; empty
        where a stage cannot be taken so.
        """
        engine, problem, found = self.engine, self.engine.problem, []
        if engine.joint or self.additive or type(engine.arithmetic) is not Arithmetic:
            return []
        for k, function in enumerate((problem.dp, problem.dq)):
            rows = [i for (n,), i in (engine.nodes[node] for node in nodes) if n == k]
            if not isinstance(function, Formula) or self.slopes[1 - k].dtype != float:
                return []
            if rows:
                found.append((k, function, rows, list(engine.components[k].A[rows])))
        return found

    def update(self, nodes: Sequence[int], given: Sequence[Any]) -> list[np.ndarray]:
        """Evaluate at given stage vectors; return the stages that these slopes make."""
        for node, y in zip(nodes, given, strict=True):
            self.evaluate(node, np.asarray(y))
        return [self.sum_at(node) for node in nodes]

    def taken(self, settle: Settle | None, enclose: Enclose | None) -> Step:
        """Go through the stages, then sum the values."""
        engine, h = self.engine, self.h
        solver = StageSolver(engine.arithmetic)
        for block in engine.blocks:
            nodes = list(block.stages)
            if block.implicit and enclose is not None:
                self.update(nodes, enclose(nodes, partial(self.update, nodes)))
                continue
            bases = [self.sum_at(node) for node in nodes]
            for node, y in zip(nodes, bases, strict=True):
                self.evaluate(node, y)
            if block.implicit:
                self._solve(solver, nodes, bases, settle)
        new = engine.arithmetic.zeros(engine.shape, self.values + engine.V[0, 0])
        for n, c in enumerate(engine.components):
            if self.additive and n:
                new = new + c.B.dot(self.slopes[n]) * h
                continue
            given = self.values[: c.V.shape[1], c.columns]
            part = engine.arithmetic.updated(c.B, self.slopes[n], h, c.V, given)
            new[: len(part), c.columns] = part
        evaluations, velocities = self.counts
        return Step(new, evaluations, velocities, solver.iterations, solver.converged, self)

    def shown(self) -> tuple[Any, Any]:
        """Return stages and slopes: of two parts as tuples."""
        engine = self.engine
        like = self.slopes[0]
        found = [
            engine.arithmetic.zeros((len(x), like.shape[1]), like)
            for x in self.known[: len(engine.parts)]
        ]
        for (whose, i), y in zip(engine.nodes, self.where, strict=True):
            if y is not None:
                for n in whose:
                    found[n][i] = y[engine.components[n].columns] if len(whose) > 1 else y
        if len(engine.parts) == 1:
            return found[0], self.slopes[0] if len(self.slopes) == 1 else tuple(self.slopes)
        return tuple(found), tuple(self.slopes)

    def _solve(
        self, solver: StageSolver, nodes: list[int], bases: list[np.ndarray], settle: Settle | None
    ) -> None:
        """Find the slopes of stages that depend on each other."""
        engine, h, d = self.engine, self.h, self.values.shape[1]
        places: list[tuple[int, int]] = []  # which slopes: component and row
        for whose, i in (engine.nodes[node] for node in nodes):
            among = range(len(self.slopes)) if self.additive else whose
            places += [(n if engine.joint else 1 - n, i) for n in among]

        def read() -> np.ndarray:
            return np.concatenate([self.slopes[n][i] for n, i in places])

        def write(x: np.ndarray) -> None:
            at = 0
            for n, i in places:
                width = self.slopes[n].shape[1]
                self.slopes[n][i] = x[at : at + width]
                at += width

        together = self._formulas(nodes)

        def rhs(x: np.ndarray) -> np.ndarray:
            write(x)
            if not together:
                for node, y in [(node, self.sum_at(node)) for node in nodes]:
                    self.evaluate(node, y)
                return read()
            # row by row, as sum_at does it: a product of matrices rounds otherwise
            sums = [np.array([a.dot(self.slopes[k]) for a in A]) * h for k, _, _, A in together]
            made = {}
            for (k, function, rows, _), total in zip(together, sums, strict=True):
                stages = self.known[k][rows] + total
                self.counts[k] += len(rows)
                self.slopes[1 - k][rows] = function(stages.T.copy()).T
                made |= {(k, i): y for i, y in zip(rows, stages, strict=True)}
            for node in nodes:
                (k,), i = engine.nodes[node]
                self.where[node] = made[k, i]
            return read()

        guess = read()
        if settle is not None:
            inner = engine.A[np.ix_(nodes, nodes)]
            times = [self.t + engine.c[node] * h for node in nodes]
            shape = (len(nodes), -1)
            found = settle(
                lambda x: rhs(x.ravel()).reshape(shape), guess.reshape(shape),
                Coupled(h, inner, times, np.stack(bases)),
            )  # fmt: skip
            write(found.ravel())
            return
        far = max(size(y) for y in bases) / abs(h) if h else 0
        # slopes of one component of the state, at several stages
        alike = [n * d + c for n, i in places for c in range(self.slopes[n].shape[1])]
        write(solver(rhs, guess, size(guess) + far, alike))


def _check(method: Method, problem: Problem) -> None:
    """Refuse a problem without the parts that the method needs.

    Raises
    ------
    UsageError
        Naming what is missing.
    """
    name = method.name or "the method"
    if method.rosenbrock:
        raise UsageError(
            f"{name} is a Rosenbrock method, which needs the Jacobian of the right-hand side, and "
            f"no engine evaluates one; `verify`, `analyze` and `show` read it"
        )
    if method.additive:
        wanted = len(method.components)
        if len(problem.terms) != wanted:
            raise UsageError(
                f"{name} is an additive method of {wanted} parts, and {problem.name} gives "
                f"{len(problem.terms)} `terms`; give the right-hand side as a sum of {wanted}"
            )
    elif method.parts == 2:
        if not problem.separable and not method.shared:
            raise UsageError(
                f"{name if method.name else 'the pair'} is for separable problems; {problem.name} "
                f"gives no `dq` and `dp`"
            )
        if problem.dimension % 2:
            raise UsageError(f"a pair needs y = (q, p), got {problem.dimension} components")


def stepper(method: Method, problem: Problem, *, digits: int | None = None) -> Stepper:
    """Return the stepper for a method on a problem, in double precision or with decimal digits.

    Raises
    ------
    UsageError
        For a problem without the parts that the method needs.
    """
    return Stepper(method, problem, digits=digits)


def apply_start(
    start: Method, engine: Stepper, t: Any, y0: np.ndarray, h: Any
) -> tuple[np.ndarray, int]:
    """Return starting values ``y_k = u_k y0 + h B_k f(Y)`` and the evaluations they cost.

    Evaluations count as in :class:`Step`: of k alone for a pair on a separable problem.

    Raises
    ------
    UsageError
        For a start that gives other numbers of values than the method carries.
    StartFailed
        When implicit stages cannot be solved.
    """
    given = tuple(len(c.V) for c in start.components)
    wanted = tuple(len(c.V) for c in engine.method.components)
    if given != wanted:
        raise UsageError(
            f"the starting method gives {' and '.join(map(str, given))} values, the method carries "
            f"{' and '.join(map(str, wanted))}"
        )
    taken = _applied(start, engine, t, y0, h)
    return taken.values, taken.evaluations


def apply_finish(
    finish: FinishingMethod, engine: Stepper, t: Any, y: np.ndarray, h: Any
) -> tuple[np.ndarray, int]:
    """Return the finished solution ``y + h b f(Y)`` and the evaluations it costs."""
    if not finish.A:
        return y, 0
    taken = _applied(finish, engine, t, y, h)
    return taken.values[0], taken.evaluations


def _applied(tableau: Method, engine: Stepper, t: Any, y: np.ndarray, h: Any) -> Step:
    taken = engine.of(tableau).step(t, y[None, :], h)
    if not taken.converged:
        raise StartFailed(
            "the stages of a starting or finishing method could not be solved; use a smaller h"
        )
    return taken
