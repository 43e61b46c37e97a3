"""Usual bugs of integrators, carried out: the wrong result that each of them gives.

Where a usual bug gives another result than the right one, the wrong result is stored in the vector
beside the right one, so that an integrator that returns it can be told its defect by name.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..engine.reference import Coupled, Stepper, apply_finish, apply_start, stepper
from ..exact import Exact
from ..exact.linalg import Matrix, matmul, transpose
from ..method import GLM, Method, PartitionedGLM
from ..problems import Problem
from ..prove.facts import facts_of

#: flag -> (the bug, what it does): the ``notes`` of the vector files.
NOTES: Mapping[str, tuple[str, str]] = {
    flag: (bug, effect)
    for flag, (bug, effect) in json.loads(
        Path(__file__).with_suffix(".json").read_text(encoding="utf-8")
    ).items()
}


@dataclass(frozen=True, eq=False)
class Wrong:
    """What a bug returns: ``values`` of a step or a start (r, d), ``solution`` (d,) of a run."""

    flag: str
    values: np.ndarray


def _variant(engine: Stepper, method: GLM | PartitionedGLM, problem: Problem) -> Stepper:
    """Return the stepper of a changed method that evaluates f at the times of the right one."""
    changed = stepper(method, problem, digits=engine.arithmetic.digits)
    if method.parts == 1:
        changed.c = engine.c
    return changed


def wrong_steps(
    engine: Stepper, method: GLM | PartitionedGLM, problem: Problem,
    t: Any, values: np.ndarray, h: Any,
) -> Iterator[Wrong]:  # fmt: skip
    """Carry out every bug that one step of this method can have; some may give the right end."""
    right = engine.step(t, values, h).values
    if isinstance(method, PartitionedGLM):
        variants = _pair_variants(method)
    else:
        variants = _variants(method)
        yield from _wrong_times(engine, t, values, h)
        yield from _unsolved(engine, t, values, h)
        if method.r > 1:
            yield Wrong("ValuesSwapped", right[[1, 0, *range(2, method.r)]])
    for flag, changed in variants:
        yield Wrong(flag, _variant(engine, changed, problem).step(t, values, h).values)
    if h < 0:
        yield Wrong("StepSignLost", engine.step(t, values, -h).values)


def _variants(m: GLM) -> Iterator[tuple[str, GLM]]:
    reversed_B = tuple(tuple(reversed(row)) for row in m.B)
    zero = Exact(0)
    if m.s > 1:
        lower = m.is_diagonally_implicit
        A = tuple(
            (*reversed(row[:i]), *row[i:]) if lower else tuple(reversed(row))
            for i, row in enumerate(m.A)
        )
        yield "StagesReordered", m.bare(A=A, B=reversed_B)
        if lower:
            diagonal = tuple(
                tuple(x if i == j else zero for j, x in enumerate(row)) for i, row in enumerate(m.A)
            )
            yield "StagesOutOfOrder", m.bare(A=diagonal)
    if m.r > 1:
        if m.s == m.r:
            yield "BlocksSwapped", m.bare(U=m.V, V=m.U)
        yield "Transposed", m.bare(V=transpose(m.V))
        lost: Matrix = tuple(row if k == 0 else (zero,) * m.r for k, row in enumerate(m.V))
        yield "ParasiticDropped", m.bare(V=lost)


def _pair_variants(m: PartitionedGLM) -> Iterator[tuple[str, PartitionedGLM]]:
    def nothing(matrix: Matrix) -> Matrix:
        return tuple(tuple(Exact(0) for _ in row) for row in matrix)

    yield "PartnerStale", m.bare(A=nothing(m.A), A_hat=nothing(m.A_hat))
    yield "PartnerNotUpdated", m.bare(B=nothing(m.B))
    changed: dict[str, Any] = {x: getattr(m, f"{x}_hat") for x in "AUBV"}
    changed |= {f"{x}_hat": getattr(m, x) for x in "AUBV"}
    yield "UpdatesExchanged", m.bare(**changed)


def _wrong_times(engine: Stepper, t: Any, values: np.ndarray, h: Any) -> Iterator[Wrong]:
    right = engine.c
    for flag, value in (("AbscissaeIgnored", 0), ("AbscissaeOne", 1)):
        engine.c = np.array([value * (x * 0 + 1) for x in right])
        try:
            yield Wrong(flag, engine.step(t, values, h).values)
        finally:
            engine.c = right


def _unsolved(engine: Stepper, t: Any, values: np.ndarray, h: Any) -> Iterator[Wrong]:
    """Return results of stage equations solved badly: after 0, 1, 2, 3 iterations from ``U y``."""
    if not any(block.implicit for block in engine.blocks):
        return
    for rounds in range(4):
        yield Wrong("IterationStopped", _stopped(engine, t, values, h, _fixed_point(rounds)))
    yield Wrong("NewtonStopped", _stopped(engine, t, values, h, _newton))


Iteration = Callable[[Stepper, Callable[..., Any], np.ndarray, Coupled], np.ndarray]


def _stopped(engine: Stepper, t: Any, values: np.ndarray, h: Any, iterate: Iteration) -> np.ndarray:
    """Return a step whose implicit blocks are settled by ``iterate`` instead of solved."""
    return engine.step(t, values, h, settle=partial(iterate, engine)).values


def _fixed_point(rounds: int) -> Iteration:
    def iterate(engine: Stepper, rhs: Callable[..., Any], x: np.ndarray, _: Coupled) -> np.ndarray:
        for _round in range(rounds):
            x = rhs(x)
        return x

    return iterate


def _newton(
    engine: Stepper, rhs: Callable[..., Any], x: np.ndarray, coupled: Coupled
) -> np.ndarray:
    """Return one iteration from the slopes at ``U y``, the Jacobian at the same place."""
    h, inner, times, base = coupled
    m, d = x.shape
    at = base + h * inner.dot(x)
    blocks = [engine.problem.jacobian(s, y) for s, y in zip(times, at, strict=True)]
    matrix = engine.arithmetic.zeros((m * d, m * d))
    for i in range(m):
        for j in range(m):
            matrix[i * d : i * d + d, j * d : j * d + d] = -h * inner[i, j] * blocks[i]
    for k in range(m * d):
        matrix[k, k] = matrix[k, k] + 1
    change = engine.arithmetic.solve(matrix, (rhs(x) - x).ravel())
    return x + change.reshape(x.shape)


def wrong_runs(
    engine: Stepper, method: GLM | PartitionedGLM, problem: Problem,
    t0: Any, values: np.ndarray, h: Any, steps: int,
) -> Iterator[Wrong]:  # fmt: skip
    """Carry out the bugs of a run of several steps; ``values`` holds the solution (1, d)."""

    def run(
        count: int, size: Any = h, start: np.ndarray = values, *, still: bool = False
    ) -> np.ndarray:
        y = start
        for n in range(count):
            y = engine.step(t0 if still else t0 + n * size, y, size).values
        return y

    def solution(y: np.ndarray, n: int = steps) -> np.ndarray:
        finishing, found = getattr(method, "finishing", None), engine.solution(y)
        if finishing is not None:
            found = apply_finish(finishing, engine, t0 + n * h, found, h)[0]
        return found[None, :]

    yield Wrong("StepMissing", solution(run(steps - 1), steps - 1))
    yield Wrong("StepExtra", solution(run(steps + 1), steps + 1))
    yield Wrong("TimeNotAdvanced", solution(run(steps, still=True)))
    if getattr(method, "finishing", None) is not None:
        yield Wrong("FinishSkipped", engine.solution(run(steps))[None, :])
    if method.parts == 2 or method.r == 1:
        yield Wrong("StepHalved", solution(run(2 * steps, h / 2)))
        return
    if method.starting is not None:
        zeroed = values.copy()
        zeroed[1:] = 0 * zeroed[1:]
        yield Wrong("StartZeroed", solution(run(steps, start=zeroed)))
    dropped = tuple(row if k == 0 else (Exact(0),) * method.r for k, row in enumerate(method.V))
    changed = _variant(engine, method.bare(V=dropped), problem)
    y = values
    for n in range(steps):
        y = changed.step(t0 + n * h, y, h).values
    yield Wrong("ParasiticDropped", solution(y))


def wrong_start(method: Method, engine: Stepper, t: Any, y0: np.ndarray, h: Any) -> Iterator[Wrong]:
    """Carry out the bugs of a start."""
    assert method.starting is not None
    right = apply_start(method.starting, engine, t, y0, h)[0]
    zeroed = right.copy()
    zeroed[1:] = 0 * zeroed[1:]
    yield Wrong("StartZeroed", zeroed)


def reversal(method: GLM | PartitionedGLM) -> Matrix | None:
    """Return the involution L of a symmetric method, ``None`` for others and for pairs."""
    if method.parts == 2:
        return None
    symmetry = facts_of(method).symmetry
    if not symmetry.holds or symmetry.L is None:
        return None
    L = symmetry.L
    assert all(x.is_zero() is not False for x in _minus_identity(matmul(L, L)))
    return L


def _minus_identity(matrix: Matrix) -> list[Any]:
    return [x - int(i == j) for i, row in enumerate(matrix) for j, x in enumerate(row)]
