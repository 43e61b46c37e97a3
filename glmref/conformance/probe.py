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

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from ..engine.reference import stepper
from ..errors import UsageError
from ..method import GLM, PartitionedGLM
from ..problems import Problem
from .readings import (
    MARKERS,
    MORE_MARKERS,
    Box,
    Reading,
    Watch,
    best,
    chain,
    clean,
    largest_step,
    needed,
    noted,
    slope_at,
    values_of,
)
from .subject import AdapterError, NotOffered, Subject


def read_glm(box: Box, r: int, *, t: float = 0.0) -> Reading:
    """Read A, U, B, V of an integrator that carries r values and calls f(t, y).

    Raises
    ------
    UsageError
        When it cannot be read: f is not called, or at too many points.
    """
    found = _read_with(box, Watch(), r, t)
    if found.evaluations < 2 * found.points:  # no stage equations are iterated
        again = _read_with(box, Watch(markers=MORE_MARKERS), r, t)
        if again.points > found.points and again.unexplained <= found.unexplained:
            return again
    return found


def _read_with(box: Box, watch: Watch, r: int, t: float) -> Reading:
    _watched(box, watch, r, 0, t, 1.0)
    if not watch.points:
        raise UsageError("f(t, y) was not called in a step: the integrator does not use problem.f")
    return best(lambda slope: _read_glm(box, watch, r, t, slope))


def _read_glm(box: Box, watch: Watch, r: int, t: float, slope: float) -> Reading:
    tags, second = len(watch.points), watch.again()
    out = _watched(box, second, r, tags, t, slope)
    m = watch.markers
    units, tag = slice(m, m + r), slice(m + r, None)
    if len(second.arguments) < tags:
        raise UsageError("f is called at other points when it is read a second time")
    seen = np.array(second.arguments)
    A, U = seen[:, tag] / slope, seen[:, units]
    B, V = out[:, tag] / slope, out[:, units]
    kept = needed(A, B)
    notes = []
    if second.strangers:
        notes.append(f"{second.strangers} calls of f at points that the first reading did not show")
    if not kept:
        notes.append("the result does not depend on f")
    c = clean((np.array(second.times) - t)[kept])
    reading = Reading(
        clean(A[np.ix_(kept, kept)]), clean(U[kept]), clean(B[:, kept]), clean(V), c,
        second.calls, tags, 0.0,
    )  # fmt: skip
    return noted(reading, largest_step(lambda h: _unexplained(box, reading, h)), notes)


def _watched(box: Box, watch: Watch, r: int, tags: int, t: float, slope: float) -> np.ndarray:
    """Take one step of size 1 while the calls of f are watched."""
    m = watch.markers
    size, h = m + r + tags, 1.0

    def f(time: float, y: np.ndarray) -> np.ndarray:
        y = np.asarray(y, dtype=float)
        marker = y[:m]
        return slope_at(marker, watch.see(float(time), y, marker), r, tags, slope)

    problem = Problem(
        name="probe", f=f, jacobian=lambda time, y: chain(size, m), y0=[0.0] * size,
        t_span=(t, t + h),
    )  # fmt: skip
    return box(problem, t, values_of(r, tags, m), h)


def read_pair(box: Box, r: int, *, t: float = 0.0) -> Reading:
    """Read both methods of an integrator for q' = dq(p), p' = dp(q) that carries r values of each.

    Raises
    ------
    UsageError
        When dq or dp is not called.
    """
    first, second = Watch(), Watch()
    _watched_pair(box, first, second, r, 0, t, 1.0)
    if not first.points or not second.points:
        raise UsageError("dq(p) and dp(q) were not both called in a step")
    return best(lambda slope: _read_pair(box, first, second, r, t, slope))


def _read_pair(box: Box, first: Watch, second: Watch, r: int, t: float, slope: float) -> Reading:
    tags = max(len(first.points), len(second.points))
    at_p, at_q = first.again(), second.again()
    out = _watched_pair(box, at_p, at_q, r, tags, t, slope)
    half = MARKERS + r + tags
    units, tag = slice(MARKERS, MARKERS + r), slice(MARKERS + r, None)
    q_end, p_end = out[:, :half], out[:, half:]
    Q, P = np.array(at_q.arguments), np.array(at_p.arguments)
    n_q, n_p = len(Q), len(P)
    A, A_hat = Q[:, tag][:, :n_p] / slope, P[:, tag][:, :n_q] / slope
    B, B_hat = q_end[:, tag][:, :n_p] / slope, p_end[:, tag][:, :n_q] / slope
    joint = np.zeros((n_q + n_p, n_q + n_p))
    joint[:n_q, n_q:], joint[n_q:, :n_q] = A, A_hat
    results = np.zeros((2 * r, n_q + n_p))
    results[:r, n_q:], results[r:, :n_q] = B, B_hat
    kept = needed(joint, results)
    q, p = [i for i in kept if i < n_q], [i - n_q for i in kept if i >= n_q]
    reading = Reading(
        clean(A[np.ix_(q, p)]), clean(Q[:, units][q]), clean(B[:, p]), clean(q_end[:, units]),
        None, at_p.calls + at_q.calls, n_q + n_p, 0.0,
        hat=(
            clean(A_hat[np.ix_(p, q)]), clean(P[:, units][p]), clean(B_hat[:, q]),
            clean(p_end[:, units]),
        ),
    )  # fmt: skip
    notes = []
    if at_p.strangers + at_q.strangers:
        notes.append("dq or dp was called at points that the first reading did not show")
    gap = largest_step(lambda h: _unexplained_pair(box, reading, h))
    return noted(reading, gap, notes)


def _watched_pair(
    box: Box, at_p: Watch, at_q: Watch, r: int, tags: int, t: float, slope: float
) -> np.ndarray:
    half, h = MARKERS + r + tags, 1.0

    def watched(watch: Watch) -> Callable[[np.ndarray], np.ndarray]:
        def function(x: np.ndarray) -> np.ndarray:
            x = np.asarray(x, dtype=float)
            marker = x[:MARKERS]
            return slope_at(marker, watch.see(t, x, marker), r, tags, slope)

        return function

    values = np.hstack([values_of(r, tags), values_of(r, tags)])
    values[:, half] += 0.125  # the markers of p are not those of q
    dq, dp = watched(at_p), watched(at_q)
    problem = Problem(name="probe", dq=dq, dp=dp, y0=[0.0] * (2 * half), t_span=(t, t + h))
    return box(problem, t, values, h)


# --- prediction ---------------------------------------------------------------------------------


def _test_field(t: float, y: np.ndarray) -> np.ndarray:
    """Nonlinear, coupled, dependent on time; its derivative stays below 2."""
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
    """The coefficients that were read, as a method."""

    def exactly(matrix: np.ndarray) -> list[list[Fraction]]:
        return [[Fraction(float(x)) for x in row] for row in matrix]

    A, U, B, V = reading.A, reading.U, reading.B, reading.V
    r = len(V)
    if reading.hat is None:
        if not len(A):  # no stage matters: one that nothing reads stands for them
            A, U, B = np.zeros((1, 1)), np.ones((1, r)), np.zeros((r, 1))
        return GLM(exactly(A), exactly(U), exactly(B), exactly(V))
    A_hat, U_hat, B_hat, V_hat = reading.hat
    if not len(A):
        A, A_hat = np.zeros((1, len(U_hat))), np.zeros((len(U_hat), 1))
        U, B_hat = np.ones((1, r)), np.zeros((r, 1))
    if not len(A_hat):
        A, A_hat = np.zeros((len(U), 1)), np.zeros((1, len(U)))
        U_hat, B = np.ones((1, r)), np.zeros((r, 1))
    q, p = [[exactly(x) for x in half] for half in ((A, U, B, V), (A_hat, U_hat, B_hat, V_hat))]
    return PartitionedGLM(q[0], q[1], q[2], q[3], p[0], p[1], p[2], p[3], separable=True)


def rebuilt_step(
    reading: Reading, f: Callable[[float, np.ndarray], np.ndarray], t: float,
    values: np.ndarray, h: float,
) -> np.ndarray:  # fmt: skip
    """Take a step with the coefficients that were read, at the times that were read."""
    problem = Problem(name="probe-step", f=f, y0=values[0], t_span=(t, t + h))
    engine = stepper(method_of(reading), problem)
    if reading.c is not None and len(reading.c):
        engine.c = reading.c
    return engine.step(t, values, h).values


def _unexplained(box: Box, reading: Reading, h: float) -> float:
    r, t = len(reading.V), 0.25
    problem = Problem(
        name="probe-test", f=_test_field, jacobian=_test_jacobian, y0=[0.0] * 3, t_span=(t, t + h)
    )
    values = np.array([[0.5 - 0.25 * k, 0.75 + 0.125 * k, 0.375 * (k + 1)] for k in range(r)])
    found = box(problem, t, values, h)
    expected = rebuilt_step(reading, _test_field, t, values, h)
    return float(np.abs(found - expected).max() / (1 + np.abs(expected).max()))


def _unexplained_pair(box: Box, reading: Reading, h: float) -> float:
    r = len(reading.V)

    def dq(p: np.ndarray) -> np.ndarray:
        return np.array([np.sin(p[0]) + 0.25 * p[1], p[1] - 0.125 * p[0] * p[1]])

    def dp(q: np.ndarray) -> np.ndarray:
        return np.array([-np.sin(q[0]) + 0.5 * q[1], 0.25 * np.cos(q[0]) - q[1]])

    problem = Problem(name="probe-test", dq=dq, dp=dp, y0=[0.0] * 4, t_span=(0.0, h))
    values = np.array([[0.5 - 0.25 * k, 0.75, 0.375 * (k + 1), 0.625] for k in range(r)])
    found = box(problem, 0.0, values, h)
    expected = stepper(method_of(reading), problem).step(0.0, values, h).values
    return float(np.abs(found - expected).max() / (1 + np.abs(expected).max()))


# --- boxes --------------------------------------------------------------------------------------


def box_of(subject: Subject, method: str) -> Box:
    """One step of an adapter's method: by ``step``, or by ``solve`` with one step."""
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
