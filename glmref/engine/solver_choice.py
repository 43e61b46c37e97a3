"""Fixed point or Newton: the one with the smaller predicted cost for each stage.

With rho the contraction of the fixed point at the initial value and c the cost of one evaluation,
the fixed point takes about ``1 + 10 / -log10(rho)`` rounds from a predictor that is right to six
digits; Newton takes about 2.3 and pays for the matrix. Blocks of several stages and systems of more
than three unknowns use Newton where rho exceeds :data:`POOR`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import UsageError
from ..problems.derivative import Jacobian
from ..problems.formula import Formula
from ..problems.model import Problem
from .forms import StepForm
from .kept import ByIdentity, recalled
from .memory import NEWTON_BYTES, gibibytes
from .newton import NewtonWriter, written_out
from .options import Options
from .positions import SingleRounds
from .shape import Shape, banded, jacobian_block

POOR = 0.25  # a fixed point that contracts less than this per round is slow
_DIFFERENCES_UP_TO = 64  # dimension up to which a missing Jacobian is differenced for the estimate
_DENSE_UP_TO = 256  # dimension up to which a known one is formed for its norm
_NORM_ROUNDS = 2
_BANDED_FROM = 32

#: Rough latencies in units of one addition, for comparing solvers.
_LATENCY = {ast.Add: 1, ast.Sub: 1, ast.Mult: 1, ast.Div: 4, ast.Pow: 10, ast.USub: 0}
_CALL_LATENCY = {"sqrt": 5}
_OTHER_CALL = 15
_ROUND_LATENCY = 12  # forming Y and L around one evaluation, comparing
_LONE_STAGE_SAVES = 6  # on q'' = g(q) two operations lie between force and position, not eight
_INLINE_SOLVE = {1: 6, 2: 14, 3: 40}
_NEWTON_ROUNDS = 2.3

_bands = ByIdentity()


def newton_writer(form: StepForm, shape: Shape) -> NewtonWriter:
    """Return what knows the matrices of Newton's method, without a kernel around it."""
    writer = NewtonWriter()
    writer.form, writer.shape = form, shape
    writer.unknowns = shape.half if shape.halved else shape.dimension
    return writer


def with_band(shape: Shape) -> Shape:
    """Return the shape with the band of its Newton matrices, kept by the identity of the shape."""
    if shape.dimension < _BANDED_FROM or shape.band is not None:
        return shape
    return _bands((shape,), None, lambda: banded(shape))


def contraction(form: StepForm, shape: Shape, problem: Problem, h: float) -> float:
    """Return the contraction per round at the initial value: h rho(w M) |J|, squared if halved.

    Beyond :data:`_DENSE_UP_TO` components the norm is estimated, see :func:`_norm_estimate`.
    rho(w M) is the largest spectral radius of a block of stages that are solved together: the norm
    of a block of Gauss stages would be too pessimistic by an order of magnitude. Zero for an
    explicit method; ``nan`` where the Jacobian is not known and too large to be differenced.
    """
    if not form.implicit_stages:
        return 0.0
    scaled = np.array(form.weights)[:, None] * np.array(form.M)
    radii = [
        np.abs(np.linalg.eigvals(scaled[np.ix_(block.stages, block.stages)])).max()
        for block in form.blocks
        if block.implicit
    ]
    size = abs(h) * float(max(radii))
    if shape.dimension > _DENSE_UP_TO and problem.jacobian is not None:
        norm = _norm_estimate(shape, problem)
        return size * size * norm if shape.halved else size * norm
    norm = _norm(shape, problem)
    return size * size * norm if shape.halved else size * norm


def _norm(shape: Shape, problem: Problem) -> float:
    """Return the row-sum norm of J at the start, of K J_f where the shape is halved; or ``nan``."""

    def computed() -> float:
        matrix, m = _jacobian(problem), shape.half
        if matrix is None:
            return math.nan
        if shape.halved:
            matrix = matrix[m:, :m] @ matrix[:m, m:]
        return float(np.linalg.norm(matrix, ord=np.inf))

    formulas = (problem.f, *([problem.jacobian] if problem.jacobian is not None else []))
    if not all(isinstance(x, Formula | Jacobian) for x in formulas):
        return computed()
    y0 = np.array(problem.y0, dtype=float).tolist()
    about = repr((formulas, shape.halved, float(problem.t_span[0]), y0))
    return recalled("norm", about, computed, float, float)


def _jacobian(problem: Problem) -> np.ndarray | None:
    """Return df/dy at the start; ``None`` where it has no value or takes too many differences."""
    if problem.jacobian is None and problem.dimension > _DIFFERENCES_UP_TO:
        return None
    with np.errstate(all="ignore"):
        try:
            return problem.slope_at(problem.t_span[0], np.array(problem.y0, dtype=float))
        except (ArithmeticError, ValueError):
            return None


def _norm_estimate(shape: Shape, problem: Problem) -> float:
    """Return a lower bound of the row-sum norm of J, of K J_f if separable, without a matrix.

    Every |J v| is one for |v| = 1 in the maximum norm. The first v has random signs: some row of a
    large sparse matrix meets the signs of its entries. Every further v has the signs of J v, as the
    power iteration for this norm takes them. Each round costs a difference of two evaluations;
    ``nan`` where one is no number.
    """
    t, y, m = problem.t_span[0], np.array(problem.y0, dtype=float), shape.half
    maps: list[tuple[Callable[[np.ndarray], Any], np.ndarray]]
    if not shape.halved:
        maps = [(lambda x: problem.f(t, x), y)]
    else:
        assert problem.dq is not None and problem.dp is not None
        velocity, force = problem.dq, problem.dp
        maps = [] if shape.parts[0].identity else [(velocity, y[m:])]
        maps.append((force, y[:m]))
    found, signs = 0.0, np.random.default_rng(1).integers(0, 2, len(maps[0][1])) * 2.0 - 1.0
    try:
        with np.errstate(all="ignore"):
            bases = [np.asarray(function(x), dtype=float) for function, x in maps]
            for _ in range(_NORM_ROUNDS):
                v = signs
                for (function, x), base in zip(maps, bases, strict=True):
                    step = 2.0**-26 * (np.abs(x).max() + 1) / max(np.abs(v).max(), 1e-300)
                    v = (np.asarray(function(x + step * v), dtype=float) - base) / step
                found = float(np.maximum(found, np.abs(v).max()))  # which keeps nan
                signs = np.where(v < 0, -1.0, 1.0)
    except (ArithmeticError, ValueError):
        return math.nan
    return found


def newton_bytes(form: StepForm, shape: Shape) -> int:
    """Return the memory that Newton's method needs for the Jacobian and its factored matrices."""
    writer = newton_writer(form, shape)
    return 8 * (writer.jacobian_size + sum(one.doubles for one in writer.systems().values()))


def choose_solver(
    form: StepForm, shape: Shape, problem: Problem, h: float, solver: str = "auto"
) -> str:
    """Choose fixed point or Newton by predicted cost; see the module's docstring.

    Raises
    ------
    UsageError
        When Newton is requested and its matrices are beyond :data:`NEWTON_BYTES`.
    """
    if not form.implicit_stages or solver == "fixed-point":
        return "fixed-point" if solver == "auto" else solver
    if solver == "newton":
        shape = with_band(shape)
        needed = newton_bytes(form, shape)
        if needed > NEWTON_BYTES:
            raise UsageError(
                f"Newton's method on {shape.dimension} components needs {gibibytes(needed)} for "
                f"its matrices, and at most {gibibytes(NEWTON_BYTES)} are given to it; use "
                f"solver='fixed-point'"
            )
        return solver
    rho = contraction(form, shape, problem, h)
    if rho == 0.0 or not math.isfinite(rho):
        return "fixed-point"
    if not written_out(form, shape) or shape.loops or rho > POOR:
        if rho <= POOR:
            return "fixed-point"
        shape = with_band(shape)
        fits = newton_bytes(form, shape) <= NEWTON_BYTES
        return "newton" if fits and _newton_pays(form, shape, rho) else "fixed-point"
    about = repr(replace(shape, values=[]))
    once, jacobian = recalled("latency", about, lambda: _latencies(shape), tuple, list)
    rounds = 1 + 10 / -math.log10(rho)
    lone = SingleRounds.fits(form, shape, Options())
    fixed = rounds * (once - _LONE_STAGE_SAVES * lone)
    newton = (
        _NEWTON_ROUNDS * once
        + jacobian
        + _INLINE_SOLVE[shape.half if shape.halved else shape.dimension]
    )
    return "newton" if newton < fixed else "fixed-point"


def _newton_pays(form: StepForm, shape: Shape, rho: float) -> bool:
    """Return whether factored matrices of a large system cost less than fixed-point rounds.

    In operations: a round evaluates every stage and forms it from the others; Newton solves with
    every matrix besides, twice its entries, four times as many where it is complex, and factors
    them every so many steps.
    """
    writer = newton_writer(form, shape)
    if writer.unknowns <= _SMALL or rho >= _DIVERGES:
        return True
    stages = form.implicit_stages
    read = _READ * shape.dimension if shape.band is None else 2 * shape.band.entries
    once = stages * (read + (2 * stages + _AROUND) * shape.dimension)
    solves, factors = 0.0, 0.0
    for one in writer.systems().values():
        weight = 4 if one.value.imag else 1
        solves += 2 * weight * one.length
        factors += 2 * weight * one.length * min(one.lower, one.size / 3)
    fixed = (1 + 10 / -math.log10(rho)) * once
    return _NEWTON_ROUNDS_LARGE * (once + solves) + factors / _STEPS_PER_FACTOR < fixed


_SMALL = 64  # unknowns up to which a poor contraction is enough to prefer Newton
_DIVERGES = 0.9
_READ = 8  # operations for one component of a right-hand side whose structure is not known
_AROUND = 10  # operations around one component: residual, comparison, sum
_NEWTON_ROUNDS_LARGE = 4
_STEPS_PER_FACTOR = 10


def _latencies(shape: Shape) -> tuple[int, int]:
    """Return the operations of a fixed-point round and of the Jacobian, weighted by latency."""
    d, m = shape.dimension, shape.half
    once = _ROUND_LATENCY + sum(_latency(p.formula) for p in shape.parts if p.formula)
    if not shape.halved:
        return once, _latency(jacobian_block(shape, range(d), range(d)))
    force = _latency(jacobian_block(shape, range(m, d), range(m)))
    return once, force + _latency(jacobian_block(shape, range(m), range(m, d)))


def _latency(formula: Formula) -> int:
    """Return operations of a formula weighted by their latency.

    Equal expressions are counted once.
    """
    seen: set[str] = set()
    common, outputs = formula.trees
    return sum(_tree_latency(tree, seen) for tree in (*(t for _, t in common), *outputs))


def _tree_latency(tree: ast.AST, seen: set[str]) -> int:
    if isinstance(tree, ast.Constant | ast.Name | ast.Subscript):
        return 0
    text = ast.dump(tree)
    if text in seen:
        return 0
    seen.add(text)
    children: Iterable[ast.AST]
    if isinstance(tree, ast.BinOp):
        own, children = _LATENCY[type(tree.op)], (tree.left, tree.right)
    elif isinstance(tree, ast.UnaryOp):
        own, children = 0, (tree.operand,)
    else:
        assert isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name)
        own, children = _CALL_LATENCY.get(tree.func.id, _OTHER_CALL), tree.args
    return own + sum(_tree_latency(child, seen) for child in children)
