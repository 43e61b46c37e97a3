"""Read both methods of a partitioned integrator; see :mod:`.probe` for the idea."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import UsageError
from ..problems import Problem
from .watch import (
    MARKERS,
    Box,
    Reading,
    Watch,
    best,
    clean,
    largest_step,
    needed,
    noted,
    slope_at,
    values_of,
)

__all__ = ["read_pair"]


def read_pair(box: Box, r: int, *, t: float = 0.0) -> Reading:
    """Read both methods of an integrator for q' = dq(p), p' = dp(q) that carries r values of each.

    Raises
    ------
        UsageError: when dq or dp is not called.
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


def _unexplained_pair(box: Box, reading: Reading, h: float) -> float:
    assert reading.hat is not None
    r = len(reading.V)
    A_hat, U_hat, B_hat, V_hat = reading.hat

    def dq(p: np.ndarray) -> np.ndarray:
        return np.array([np.sin(p[0]) + 0.25 * p[1], p[1] - 0.125 * p[0] * p[1]])

    def dp(q: np.ndarray) -> np.ndarray:
        return np.array([-np.sin(q[0]) + 0.5 * q[1], 0.25 * np.cos(q[0]) - q[1]])

    problem = Problem(name="probe-test", dq=dq, dp=dp, y0=[0.0] * 4, t_span=(0.0, h))
    values = np.array([[0.5 - 0.25 * k, 0.75, 0.375 * (k + 1), 0.625] for k in range(r)])
    found = box(problem, 0.0, values, h)
    q, p = values[:, :2], values[:, 2:]
    F, K = np.zeros((len(U_hat), 2)), np.zeros((len(reading.U), 2))
    for _ in range(200):
        Q, P = reading.U @ q + h * reading.A @ F, U_hat @ p + h * A_hat @ K
        F_new, K_new = np.array([dq(x) for x in P]), np.array([dp(x) for x in Q])
        change = max(np.abs(F_new - F).max(), np.abs(K_new - K).max())
        F, K = F_new, K_new
        if change < 1e-16:
            break
    expected = np.hstack([reading.V @ q + h * reading.B @ F, V_hat @ p + h * B_hat @ K])
    return float(np.abs(found - expected).max() / (1 + np.abs(expected).max()))
