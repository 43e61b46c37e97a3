"""Steps of a method linearised at many values at once, stage by stage, from Jacobians of f.

The derivatives of a step follow from those of its stages, ``dY = U dx + h A f'(Y) dY``: a stage
that is explicit is summed, those that are solved together are the solution of a linear system, also
that of Newton's method for the stages themselves. Jacobians are formulas where the problem has
them, and central differences else. So a right-hand side in Python is called some dozen times a
stage, and not for a step in each direction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..engine.kept import expressed, stepper_of
from ..engine.reference import Stepper
from ..engine.runners import rows_at, slopes_at
from ..method import Method
from ..problems.model import Problem
from ..problems.user_functions import UserFunction

#: Part of a value by which it is moved for a central difference: its square and the inverse times
#: 1e-16 are the errors, 1e-10 and 1e-11.
NUDGE = 1e-5
#: Iterations for stages, each with the Jacobian of every eighth, and the last change of a stage.
ROUNDS, REFRESHED, SETTLED = 48, 8, 1e-14
Function = Callable[[np.ndarray], np.ndarray]


def jacobians(problem: Problem, y: np.ndarray) -> np.ndarray:
    """Return df/dy of an autonomous problem at states (N, d): (N, d, d)."""
    J = problem.jacobian
    if J is not None and not isinstance(J, UserFunction):
        found = np.asarray(J(0.0, y.T), dtype=float)
        if found.shape == (y.shape[1], *y.shape[::-1]):
            return np.moveaxis(found, -1, 0)
    return _differences(lambda x: slopes_at(problem, 0.0, x), y)


def _differences(function: Function, y: np.ndarray) -> np.ndarray:
    """Return derivatives (N, e, d) of a function of (N, d) with values (N, e)."""
    nudges, columns = nudges_of(y), []
    for k, nudge in enumerate(nudges):
        move = nudge * np.eye(len(nudges))[k]
        columns.append((function(y + move) - function(y - move)) / (2 * nudge))
    return np.stack(columns, axis=2)


def nudges_of(values: np.ndarray) -> np.ndarray:
    """Return by how much each of d numbers is moved for a central difference, from (.., d)."""
    sizes = np.max(np.abs(values), axis=tuple(range(values.ndim - 1)))
    return NUDGE * np.where(sizes > 0, sizes, max(float(np.max(sizes)), 1e-300))


@dataclass(frozen=True, eq=False)
class _Node:
    """A stage: what makes it, and what is evaluated there."""

    carried: Sequence[tuple[int, int, slice]]  #: Component, row of U, and columns of the stage.
    driven: Sequence[tuple[int, int, slice]]  #: Component, row of A, and columns of the stage.
    gives: Sequence[tuple[int, int, slice]]  #: Component, number of the slope, its columns of f.
    function: Function
    derivative: Function
    width: int


def _nodes(engine: Stepper, problem: Problem) -> list[_Node]:
    """Return the stages of a step in the order of the engine's."""
    d = problem.dimension
    every, half, found = slice(0, d), slice(0, d // 2), []
    for whose, i in engine.nodes:
        own = [(n, i, engine.components[n].columns) for n in whose]
        if engine.method.additive:
            function, derivative = _terms(problem)
            among = range(len(engine.components))
            driven = [(n, i, every) for n in among]
            gives = [(n, i, slice(n * d, n * d + d)) for n in among]
            found.append(_Node(own, driven, gives, function, derivative, d))
        elif engine.joint:
            function, derivative = partial(slopes_at, problem, 0.0), partial(jacobians, problem)
            found.append(_Node(own, own, own, function, derivative, d))
        else:
            (n,) = whose
            rows = [(n, i, half)]
            found.append(_Node(rows, rows, [(1 - n, i, half)], *_half(problem, n), d // 2))
    return found


def _terms(problem: Problem) -> tuple[Function, Function]:
    """Return all terms of a right-hand side, one after the other, and their derivatives."""

    def slopes(y: np.ndarray) -> np.ndarray:
        terms = [partial(term, 0.0) for term in problem.terms]
        return np.concatenate([rows_at(term, y) for term in terms], axis=1)

    return slopes, partial(_differences, slopes)


def _half(problem: Problem, n: int) -> tuple[Function, Function]:
    """Return dp of positions, n = 0, or dq of momenta, and its derivatives."""
    half = problem.dimension // 2
    slopes = partial(rows_at, (problem.dp, problem.dq)[n])
    if problem.jacobian is None or isinstance(problem.jacobian, UserFunction):
        return slopes, partial(_differences, slopes)
    here, there = (slice(0, half), slice(half, None))[:: -1 if n else 1]

    def derivative(y: np.ndarray) -> np.ndarray:
        states = np.tile(np.array(problem.y0, dtype=float), (len(y), 1))
        states[:, here] = y
        return jacobians(problem, states)[:, there, here]

    return slopes, derivative


def step_derivatives(method: Method, problem: Problem, h: float, values: np.ndarray) -> np.ndarray:
    """Differentiate a step of an autonomous problem at many values.

    Parameters
    ----------
    method, problem, h
        What is stepped.
    values : np.ndarray
        (N, r, d) values.

    Returns
    -------
    np.ndarray
        (N, r d, r d), NaN where the stages could not be solved.
    """
    problem = expressed(problem)
    return _Linearised(stepper_of(method, problem), problem, h, values).step()


class _Linearised:
    """Steps on their way: slopes of each component so far, and their derivatives."""

    def __init__(self, engine: Stepper, problem: Problem, h: float, values: np.ndarray) -> None:
        self.engine, self.h, self.values = engine, h, values
        self.nodes = _nodes(engine, problem)
        count, r, d = values.shape
        self.places = np.eye(r * d).reshape(r, d, r * d)
        widths = [len(range(d)[c.columns]) for c in engine.components]
        self.slopes, self.moved = [], []
        for c, w in zip(engine.components, widths, strict=True):
            self.slopes.append(np.zeros((count, c.B.shape[1], w)))
            self.moved.append(np.zeros((count, c.B.shape[1], w, r * d)))

    def step(self) -> np.ndarray:
        """Return the derivatives of the step, (N, r d, r d)."""
        for block in self.engine.blocks:
            self._settle([self.nodes[k] for k in block.stages], implicit=block.implicit)
        count, r, d = self.values.shape
        found = np.zeros((count, r, d, r * d))
        for n, c in enumerate(self.engine.components):
            rows, columns = len(c.V), np.arange(d)[c.columns]
            m = self.moved[n]
            part = self.h * (c.B @ m.reshape(count, m.shape[1], -1))
            found[:, :rows, columns] += part.reshape(count, rows, len(columns), r * d)
            if not (self.engine.method.additive and n):
                carried = self.places[: c.V.shape[1], columns]
                found[:, :rows, columns] += np.tensordot(c.V, carried, 1)
        return found.reshape(count, r * d, r * d)

    def _settle(self, nodes: Sequence[_Node], *, implicit: bool) -> None:
        """Find stages that are computed together, and what their slopes are."""
        ends = np.cumsum([node.width for node in nodes])
        cuts = [slice(end - node.width, end) for node, end in zip(nodes, ends, strict=True)]
        Y = self._sums(nodes)
        good = np.ones(len(Y), dtype=bool)
        if implicit:
            inverse = np.zeros(0)
            for k in range(ROUNDS):
                if k % REFRESHED == 0:
                    inverse = np.linalg.inv(self._system(nodes, cuts, Y))
                self._evaluate(nodes, cuts, Y)
                change = (inverse @ (self._sums(nodes) - Y)[..., None])[..., 0]
                Y = Y + change
                size = np.abs(self.values).max(axis=(1, 2)) + np.abs(Y).max(axis=1)
                good = np.abs(change).max(axis=1) <= SETTLED * size
                if good.all():
                    break
            Y[~good] = np.nan
        self._evaluate(nodes, cuts, Y)
        base = self._sums(nodes, derivatives=True)
        if implicit:
            base = np.linalg.solve(self._system(nodes, cuts, Y), base)
        for node, cut in zip(nodes, cuts, strict=True):
            moved = node.derivative(Y[:, cut]) @ base[:, cut]
            for n, i, rows in node.gives:
                self.moved[n][:, i] = moved[:, rows]

    def _evaluate(self, nodes: Sequence[_Node], cuts: Sequence[slice], Y: np.ndarray) -> None:
        for node, cut in zip(nodes, cuts, strict=True):
            slopes = node.function(Y[:, cut])
            for n, i, columns in node.gives:
                self.slopes[n][:, i] = slopes[:, columns]

    def _sums(self, nodes: Sequence[_Node], *, derivatives: bool = False) -> np.ndarray:
        """Return the stages that the slopes as they are make, (N, w), or their derivatives."""
        count, r, d = self.values.shape
        found = []
        for node in nodes:
            more = (r * d,) if derivatives else ()
            one = np.zeros((count, node.width, *more))
            for n, i, columns in node.carried:
                c = self.engine.components[n]
                if derivatives:
                    given = self.places[: c.U.shape[1], c.columns]
                    one[:, columns] += np.tensordot(c.U[i], given, 1)
                else:
                    one[:, columns] += c.U[i] @ self.values[:, : c.U.shape[1], c.columns]
            for n, i, columns in node.driven:
                k = self.moved[n] if derivatives else self.slopes[n]
                part = self.engine.components[n].A[i] @ k.reshape(count, k.shape[1], -1)
                one[:, columns] += self.h * part.reshape(count, *k.shape[2:])
            found.append(one)
        return np.concatenate(found, axis=1)

    def _system(self, nodes: Sequence[_Node], cuts: Sequence[slice], Y: np.ndarray) -> np.ndarray:
        """Return 1 - h A f'(Y) of stages that are solved together, (N, w, w)."""
        size = sum(node.width for node in nodes)
        found = np.tile(np.eye(size), (len(Y), 1, 1))
        for other, there in zip(nodes, cuts, strict=True):
            J = other.derivative(Y[:, there])
            for node, here in zip(nodes, cuts, strict=True):
                rows = np.arange(size)[here]
                for n, i, columns in node.driven:
                    for m, j, slopes in other.gives:
                        if m == n and (a := self.engine.components[n].A[i, j]):
                            found[:, rows[columns], there] -= self.h * a * J[:, slopes]
        return found
