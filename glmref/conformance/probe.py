"""What method is this code really? Read the coefficients out of a running integrator.

The integrator gets right-hand sides made for the purpose, and is watched while it calls them. Some
components are *markers*: ``m_0' = 1, m_1' = m_0, m_2' = m_1, ...``, from generic values. Whatever
the solver of the stage equations is, the markers of a stage come out right after a few iterations,
and they tell the stages apart. Other components are *units*: they do not change, so that a stage
shows its row of U and the result shows V. The rest are *tags*: the slope of a tag is constant at
one stage and 0 elsewhere, so that a stage shows its row of A and the result shows B. Nothing is
fitted; every number is read off an argument of f or off the result.

At the end the coefficients predict a step on a nonlinear, time-dependent problem. What the
prediction misses was not seen, and is said.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from ..engine.reference import stepper
from ..errors import UsageError
from ..method import GLM, PartitionedGLM
from ..problems import Problem
from .readings import (
    MORE_MARKERS,
    Box,
    Reading,
    Watch,
    best,
    chain,
    clean,
    largest_step,
    noted,
    slope_at,
    values_of,
    without_idle,
)
from .subject import AdapterError, NotOffered, Subject


def read_glm(box: Box, r: int) -> Reading:
    """Read A, U, B, V of an integrator that carries r values and calls f(t, y).

    Raises
    ------
    UsageError
        When it cannot be read: f is not called, or at too many points.
    """
    found = _read_with(box, (Watch(),), r)
    if found.evaluations < 2 * found.points:  # no stage equations are iterated
        again = _read_with(box, (Watch(markers=MORE_MARKERS),), r)
        if again.points > found.points and again.unexplained <= found.unexplained:
            return again
    return found


def read_pair(box: Box, r: int) -> Reading:
    """Read both methods of an integrator for q' = dq(p), p' = dp(q) that carries r values of each.

    Raises
    ------
    UsageError
        When dq or dp is not called.
    """
    return _read_with(box, (Watch(), Watch()), r)


def _read_with(box: Box, watches: Sequence[Watch], r: int) -> Reading:
    """Read with one watch on f, or with one at the stages Q, on dp, and one at P, on dq."""
    _watched(box, watches, r, 0, 1.0)
    if not all(watch.points for watch in watches):
        raise UsageError(
            "f(t, y) was not called in a step: the integrator does not use problem.f"
            if len(watches) == 1
            else "dq(p) and dp(q) were not both called in a step"
        )
    return best(lambda slope: _read(box, watches, r, slope))


def _read(box: Box, watches: Sequence[Watch], r: int, slope: float) -> Reading:
    tags, seconds = max(len(x.points) for x in watches), [x.again() for x in watches]
    out = _watched(box, seconds, r, tags, slope)
    single, m = len(watches) == 1, watches[0].markers
    units, tag = slice(m, m + r), slice(m + r, None)
    if single and len(seconds[0].arguments) < tags:
        raise UsageError("f is called at other points when it is read a second time")
    stages = [np.array(x.arguments) for x in seconds]
    ends = np.split(out, len(watches), axis=1)
    sizes = [len(x) for x in stages]
    halves = [
        (x[:, tag][:, :n] / slope, x[:, units], end[:, tag][:, :n] / slope, end[:, units])
        for x, end, n in zip(stages, ends, sizes[::-1], strict=True)
    ]
    left, rows = without_idle(halves)
    cleaned = tuple((clean(A), clean(U), clean(B), clean(V)) for A, U, B, V in left)
    notes, unexpected = [], sum(x.unexpected for x in seconds)
    if unexpected and single:
        notes.append(f"{unexpected} calls of f at points that the first reading did not show")
    elif unexpected:
        notes.append("dq or dp was called at points that the first reading did not show")
    if single and not len(rows[0]):
        notes.append("the result does not depend on f")
    c = clean(np.array(seconds[0].times)[rows[0]]) if single else None
    reading = Reading(cleaned, c, sum(x.calls for x in seconds), sum(sizes), 0.0)
    return noted(reading, largest_step(lambda h: _unexplained(box, reading, h)), notes)


def _watched(box: Box, watches: Sequence[Watch], r: int, tags: int, slope: float) -> np.ndarray:
    """Take one step of size 1 from time 0 while the calls of the right-hand sides are watched."""
    m = watches[0].markers
    size = m + r + tags
    values = np.hstack([values_of(r, tags, m)] * len(watches))

    def seen(watch: Watch, time: float, x: np.ndarray) -> np.ndarray:
        x = np.asarray(x, dtype=float)
        return slope_at(x[:m], watch.see(time, x, x[:m]), r, tags, slope)

    if len(watches) == 1:
        problem = Problem(
            name="probe", f=lambda time, y: seen(watches[0], float(time), y),
            jacobian=lambda time, y: chain(size, m), y0=[0.0] * size, t_span=(0.0, 1.0),
        )  # fmt: skip
    else:
        values[:, size] += 0.125  # the markers of p are not those of q
        problem = Problem(
            name="probe", dq=lambda p: seen(watches[1], 0.0, p),
            dp=lambda q: seen(watches[0], 0.0, q), y0=[0.0] * (2 * size), t_span=(0.0, 1.0),
        )  # fmt: skip
    return box(problem, 0.0, values, 1.0)


# --- prediction ---------------------------------------------------------------------------------


def _test_field(t: float, y: np.ndarray) -> np.ndarray:
    """Evaluate a nonlinear, coupled field that depends on time; its derivative stays below 2."""
    return np.array(
        [
            np.sin(y[1]) + 0.5 * t,
            -np.sin(y[0]) + 0.25 * y[2] * y[1],
            0.5 * np.cos(y[0] + t) - 0.25 * y[2],
        ]
    )


def _test_jacobian(t: float, y: np.ndarray) -> np.ndarray:
    return np.array(
        [
            [0.0, np.cos(y[1]), 0.0],
            [-np.cos(y[0]), 0.25 * y[2], 0.25 * y[1]],
            [-0.5 * np.sin(y[0] + t), 0.0, -0.25],
        ]
    )


def method_of(reading: Reading) -> GLM | PartitionedGLM:
    """Return the coefficients that were read, as a method."""

    def exactly(matrix: np.ndarray) -> list[list[Fraction]]:
        return [[Fraction(float(x)) for x in row] for row in matrix]

    def half(A: np.ndarray, U: np.ndarray, B: np.ndarray, V: np.ndarray) -> Iterator[Any]:
        # where no stage matters, one that nothing reads stands for them
        rows, columns = (max(1, n) for n in A.shape)
        yield exactly(A if A.size else np.zeros((rows, columns)))
        yield exactly(U if len(U) else np.ones((1, len(V))))
        yield exactly(B if B.size else np.zeros((len(V), columns)))
        yield exactly(V)

    blocks = [x for one in reading.halves for x in half(*one)]
    return GLM(*blocks) if reading.single else PartitionedGLM(*blocks, separable=True)


def _unexplained(box: Box, reading: Reading, h: float) -> float:
    """Return the relative difference of a nonlinear step from what the coefficients make of it."""
    r, t = reading.values, 0.25 if reading.single else 0.0
    if reading.single:
        problem = Problem(
            name="probe-test", f=_test_field, jacobian=_test_jacobian, y0=[0.0] * 3,
            t_span=(t, t + h),
        )  # fmt: skip
        values = np.array([[0.5 - 0.25 * k, 0.75 + 0.125 * k, 0.375 * (k + 1)] for k in range(r)])
    else:
        problem = Problem(
            name="probe-test", y0=[0.0] * 4, t_span=(t, t + h),
            dq=lambda p: np.array([np.sin(p[0]) + 0.25 * p[1], p[1] - 0.125 * p[0] * p[1]]),
            dp=lambda q: np.array([-np.sin(q[0]) + 0.5 * q[1], 0.25 * np.cos(q[0]) - q[1]]),
        )  # fmt: skip
        values = np.array([[0.5 - 0.25 * k, 0.75, 0.375 * (k + 1), 0.625] for k in range(r)])
    found = box(problem, t, values, h)
    engine = stepper(method_of(reading), problem)
    if reading.c is not None and len(reading.c):
        engine.c = reading.c  # the times that were read
    expected = engine.step(t, values, h).values
    return float(np.abs(found - expected).max() / (1 + np.abs(expected).max()))


# --- boxes --------------------------------------------------------------------------------------


def box_of(subject: Subject, method: str) -> Box:
    """Take one step of an adapter's method: by ``step``, or by ``solve`` with one step."""
    if "step" in subject.offers:
        return lambda problem, t, values, h: subject.step(method, problem, t, values, h)

    def box(problem: Problem, t: float, values: np.ndarray, h: float) -> np.ndarray:
        if len(values) != 1:
            raise UsageError("`solve` shows no values: a method that carries several needs `step`")
        moved = replace(problem, y0=values[0].tolist(), t_span=(t, t + h))
        return subject.solve(method, moved, h, 1)[-1:]

    return box


def read(subject: Subject, method: str, r: int) -> Reading:
    """Read a method of an adapter, as a GLM or, where f is not called, as a pair.

    Raises
    ------
    UsageError
        One sentence on why it cannot be read.
    """
    box, said = box_of(subject, method), []
    readers: Sequence[Callable[[Box, int], Reading]] = (read_glm, read_pair)
    for reader in readers:
        try:
            return reader(box, r)
        except (AdapterError, NotOffered, UsageError) as error:
            said.append(str(error))
    raise UsageError(f"{method} cannot be read: {said[0]}; as a pair: {said[1]}")
