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

import numpy as np

from ..errors import UsageError
from ..problems import Problem
from .probe_partitioned import read_pair
from .subject import AdapterError, NotOffered, Subject
from .watch import (
    MARKERS,
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

__all__ = ["Box", "Reading", "read", "read_glm", "read_pair", "rebuilt_step"]


def read_glm(box: Box, r: int, *, t: float = 0.0) -> Reading:
    """Read A, U, B, V of an integrator that carries r values and calls f(t, y).

    Args:
        box: one step of the integrator.
        r: number of values it carries.
        t: time at which it steps.

    Raises
    ------
        UsageError: when it cannot be read: f is not called, or at too many points.
    """
    watch = Watch()
    _watched(box, watch, r, 0, t, 1.0)
    if not watch.points:
        raise UsageError("f(t, y) was not called in a step: the integrator does not use problem.f")
    return best(lambda slope: _read_glm(box, watch, r, t, slope))


def _read_glm(box: Box, watch: Watch, r: int, t: float, slope: float) -> Reading:
    tags, second = len(watch.points), watch.again()
    out = _watched(box, second, r, tags, t, slope)
    units, tag = slice(MARKERS, MARKERS + r), slice(MARKERS + r, None)
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
    size, h = MARKERS + r + tags, 1.0

    def f(time: float, y: np.ndarray) -> np.ndarray:
        y = np.asarray(y, dtype=float)
        marker = y[:MARKERS]
        return slope_at(marker, watch.see(float(time), y, marker), r, tags, slope)

    problem = Problem(
        name="probe", f=f, jacobian=lambda time, y: chain(size), y0=[0.0] * size,
        t_span=(t, t + h),
    )  # fmt: skip
    return box(problem, t, values_of(r, tags), h)


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


def rebuilt_step(
    reading: Reading, f: Callable[[float, np.ndarray], np.ndarray], t: float,
    values: np.ndarray, h: float,
) -> np.ndarray:  # fmt: skip
    """Take a step with the coefficients that were read; the stages by fixed-point iteration."""
    assert reading.c is not None
    base, times = reading.U @ values, t + reading.c * h
    slopes = np.zeros((len(times), values.shape[1]))
    for _ in range(200):
        where = base + h * reading.A @ slopes
        new = np.array([f(s, y) for s, y in zip(times, where, strict=True)]).reshape(slopes.shape)
        change = np.abs(new - slopes).max(initial=0.0)
        slopes = new
        if change < 1e-16:
            break
    return h * reading.B @ slopes + reading.V @ values


def _unexplained(box: Box, reading: Reading, h: float) -> float:
    r, t = len(reading.V), 0.25
    problem = Problem(
        name="probe-test", f=_test_field, jacobian=_test_jacobian, y0=[0.0] * 3, t_span=(t, t + h)
    )
    values = np.array([[0.5 - 0.25 * k, 0.75 + 0.125 * k, 0.375 * (k + 1)] for k in range(r)])
    found = box(problem, t, values, h)
    expected = rebuilt_step(reading, _test_field, t, values, h)
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
        UsageError: one sentence on why it cannot be read.
    """
    box, said = box_of(subject, method), []
    readers: Sequence[Callable[[Box, int], Reading]] = (read_glm, read_pair)
    for reader in readers:
        try:
            return reader(box, r)
        except (AdapterError, NotOffered, UsageError) as error:
            said.append(str(error))
    raise UsageError(f"{method} cannot be read: {said[0]}; as a pair: {said[1]}")
