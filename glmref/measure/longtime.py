"""Drift of what should be conserved: energy, quadratic invariants, and the G-form of all values.

A G-symplectic method carries every quadratic invariant Q of the equations exactly as the form
``sum g_ij Q(y_i, y_j)`` of *all* the values; the invariant of the solution y_1 alone, and the
Hamiltonian, only stay near. So the three are watched apart.

The law by which a deviation grows is found from its root mean square over longer and longer
stretches: an exponent near 0 is bounded, 1/2 a random walk of round-off, 1 a drift, 2 a quadratic
one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..compute.records import in_json
from ..engine.clocks import solved_form, without_clocks
from ..engine.outcome import Solution
from ..engine.solve import solve
from ..errors import UsageError
from ..method import Method
from ..problems.canonical import timed
from ..problems.formula import Formula
from ..problems.model import Problem

#: Fewest samples from which an exponent is read.
FEWEST = 32
#: Rows kept of each stretch of a long run; stretches double, so times are known to 1/ROWS.
ROWS = 1000


@dataclass(frozen=True, slots=True)
class Drift:
    """How far one conserved quantity went from its first value."""

    quantity: str  #: Its name, as the problem gives it.
    #: ``"hamiltonian"``, ``"quadratic"`` or ``"invariant"`` of the solution, or ``"form"``: the
    #: G-form, of a quadratic invariant, of all values.
    kind: str
    start: float  #: The value at the first sample.
    scale: float  #: What deviations are measured against: |start|, or the size of its largest term.
    largest: float  #: Largest deviation over the samples, relative to ``scale``.
    last: float  #: Deviation of the last sample, relative to ``scale``, with its sign.
    slope: float  #: Least squares slope of the relative deviation, per time unit of the problem.
    #: Exponent of growth of the root mean square with time; NaN where it is all zero.
    exponent: float

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types."""
        return in_json(self)


def along(function: Callable[[Any], Any], y: np.ndarray) -> np.ndarray:
    """Evaluate a function of the state at every row of y, shape (m, d) -> (m,).

    The functions of shipped problems take states in columns; a user's may not, and is then called
    row by row.
    """
    with np.errstate(all="ignore"):
        try:
            values = np.asarray(function(y.T), dtype=float)
            if values.shape == (len(y),) and len(y) != y.shape[1]:
                return values
        except Exception:
            pass
        return np.array([float(function(row)) for row in y])


def energy_scale(problem: Problem, y: np.ndarray) -> float:
    """Return the size of the energy of a state (d,).

    Where that is zero but for rounding, of its terms.

    An energy that cancels at a state, as in a transformed time, does not where the state is a
    little larger: ``y . grad H`` stands for its terms.
    """
    assert problem.conserved is not None
    step = 2.0**-20
    energy, more = along(problem.conserved, np.array([y, (1 + step) * np.asarray(y)]))
    terms = abs(more - energy) / step
    return float(abs(energy) if not abs(energy) <= 1e-9 * terms else terms) or 1.0


def energy_deviation(problem: Problem, y: np.ndarray) -> np.ndarray:
    """Return the relative deviation of the energy of each row of y, (m, d), from the first."""
    assert problem.conserved is not None
    energy = along(problem.conserved, y)
    with np.errstate(all="ignore"):
        return np.abs(energy - energy[0]) / energy_scale(problem, y[0])


def follow(
    problem: Problem,
    method: Method,
    *,
    h: float,
    steps: int,
    start: Any = None,
    renew: int = 0,
    engine: str = "compiled",
    cancel: Callable[[], bool] | None = None,
    lost: Callable[[Solution], bool] | None = None,
) -> Solution:
    """Run for long, with samples that thin out as time goes: memory grows with log(steps) only.

    The run is taken in stretches, each as long as all before it; :data:`ROWS` samples are kept of
    each, so that the time of an event is known to a thousandth of itself. With ``renew`` a stretch
    is a multiple of so many steps, and starts from the solution, as every renewal does. A stretch
    of a problem whose formulas contain t begins at its own time. ``lost`` is called with each
    finished stretch, and ends the run where it is true; the other options are those of
    :func:`glmref.solve`. The solution has its history; its counts and seconds are those of the
    whole run.
    """
    solved = solved_form(problem, method)
    if solved is not problem:  # whose time is a component, so that stretches may restart the clock
        found = follow(
            solved, method, h=h, steps=steps, start=start, renew=renew, engine=engine,
            cancel=cancel, lost=lost and (lambda part: lost(without_clocks(part, problem))),
        )  # fmt: skip
        return without_clocks(found, problem)
    renew = renew if method.carried > 1 else 0
    done, length = 0, min(steps, renew or ROWS)
    clocked = isinstance(problem.f, Formula) and timed(problem.f)
    t0, end = map(float, problem.t_span)
    rows: list[Solution] = []
    while True:
        every = max(1, length // ROWS)
        part = solve(
            problem, method, h=h, steps=length, every=every, start=start, renew=renew,
            engine=engine, history=True, cancel=cancel,
        )  # fmt: skip
        shift = 0.0 if clocked else done * h
        rows.append(replace(part, t=np.asarray(part.t, dtype=float) + shift))
        done += part.steps
        if not part.completed or done >= steps or (lost is not None and lost(rows[-1])):
            break
        begin = (t0 + done * h, end) if clocked else problem.t_span
        if renew or clocked:
            problem = replace(problem, y0=tuple(part.y[-1].tolist()), t_span=begin)
        if not renew:
            values = part.values
            start = lambda _problem, _h, values=values: values  # noqa: E731
        length = min(done, steps - done)
    return _joined(rows, done, renewed=renew > 0)


def _joined(rows: list[Solution], steps: int, *, renewed: bool) -> Solution:
    """Put stretches together; the first row of each but the first repeats the one before."""
    keep = [part if k == 0 else replace(part, t=part.t[1:]) for k, part in enumerate(rows)]
    counted = ("evaluations", "velocity_evaluations", "iterations", "factorisations", "seconds")
    return replace(
        rows[-1],
        t=np.concatenate([part.t for part in keep]),
        y=np.concatenate([p.y if k == 0 else p.y[1:] for k, p in enumerate(rows)]),
        history=np.concatenate([np.asarray(p.history)[min(k, 1) :] for k, p in enumerate(rows)]),
        steps=steps,
        start_evaluations=sum(part.start_evaluations for part in (rows if renewed else rows[:1])),
        renewals=sum(part.renewals for part in rows) + renewed * (len(rows) - 1),
        build_seconds=rows[0].build_seconds,
        notices=tuple(dict.fromkeys(n for part in rows for n in part.notices)),
        **{key: sum(getattr(part, key) for part in rows) for key in counted},
    )


def drift(
    quantity: str,
    t: np.ndarray,
    values: np.ndarray,
    *,
    kind: str = "invariant",
    scale: float | None = None,
) -> Drift:
    """Summarize a conserved quantity sampled at times t, with the first sample as the reference.

    ``scale`` is the unit of the deviations; by default |values[0]|, or 1 where that is zero.
    """
    if len(t) != len(values) or not len(t):
        raise UsageError(f"`values` must have as many samples as `t`, {len(t)}, got {len(values)}")
    start = float(values[0])
    unit = abs(start) if scale is None else float(scale)
    unit = unit if unit > 0 and math.isfinite(unit) else 1.0
    deviation = (np.asarray(values, dtype=float) - start) / unit
    elapsed = np.asarray(t, dtype=float) - float(t[0])
    with np.errstate(all="ignore"):
        square = float(elapsed @ elapsed)
        slope = float(elapsed @ deviation) / square if square else math.nan
    return Drift(
        quantity=quantity,
        kind=kind,
        start=start,
        scale=unit,
        largest=float(np.max(np.abs(deviation))),
        last=float(deviation[-1]),
        slope=slope,
        exponent=exponent(elapsed, deviation),
    )


def exponent(elapsed: np.ndarray, deviation: np.ndarray) -> float:
    """Return the growth exponent of a deviation: slope of log rms over dyadic stretches of time.

    Stretch k covers ``T/2^(k+1) < t <= T/2^k``; a fit through the last five of them weighs every
    stretch equally. NaN where there are too few samples or where the deviation vanishes.
    """
    if len(elapsed) < FEWEST or not np.all(np.isfinite(deviation)):
        return math.nan
    end = abs(float(elapsed[-1]))
    points: list[tuple[float, float]] = []
    for k in range(5):
        inside = (np.abs(elapsed) <= end / 2**k) & (np.abs(elapsed) > end / 2 ** (k + 1))
        if inside.sum() < 4:
            break
        rms = float(np.sqrt(np.mean(deviation[inside] ** 2)))
        if rms > 0:
            points.append((-k * math.log(2.0), math.log(rms)))
    return slope(points)


def slope(points: Sequence[tuple[float, float]]) -> float:
    """Return the slope of the line of least squares through points; NaN through less than three."""
    if len(points) < 3:
        return math.nan
    x, y = np.array(points).T
    x = x - x.mean()
    return float(x @ y / (x @ x))


def g_form(history: np.ndarray, G: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Return ``sum_ij g_ij y_i^* C y_j``, G Hermitian and C symmetric, at samples (m, r, d).

    The sum is formed with compensation of its rounding: one evaluation then errs by a few units of
    the last place of its largest term, and what is seen over a long run is the method's.
    """
    products = np.einsum("mid,de,mje->mij", history.conj(), C, history)
    terms = (products * G).reshape(len(history), -1).real
    return np.array([math.fsum(row) for row in terms])


def _g_scale(first: np.ndarray, G: np.ndarray, C: np.ndarray) -> float:
    """Return the size of the largest terms of the form at the start, (r, d) values."""
    products = np.abs(np.einsum("id,de,je->ij", np.abs(first), np.abs(C), np.abs(first)))
    return float(np.sum(products * np.abs(G)))


def quantities(
    problem: Problem, solution: Solution, *, G: np.ndarray | None = None
) -> Iterator[tuple[str, str, np.ndarray, float | None]]:
    """Yield what a problem conserves along a solution, one by one: see :class:`Drift`.

    Name, kind, values (m,) and scale of each; ``None`` stands for the first value.

    Parameters
    ----------
    problem : Problem
        The problem that was solved.
    solution : Solution
        With several rows; with ``history`` where the G-form is wanted.
    G : np.ndarray or None
        (r, r) form of the method; ``None`` leaves the G-forms out.
    """
    y = np.real(np.asarray(solution.y)).astype(float)
    if problem.conserved is not None:
        scale = energy_scale(problem, y[0])
        yield "energy", "hamiltonian", along(problem.conserved, y), scale
    for name, form in problem.quadratic.items():
        scale = float(np.abs(y[0]) @ np.abs(form.matrix) @ np.abs(y[0]))
        yield name, "quadratic", along(form, y), scale
    for name, function in problem.invariants.items():
        yield name, "invariant", along(function, y), None
    if G is not None:
        if solution.history is None:
            raise UsageError("the G-form needs all values; solve with history=True")
        history = np.asarray(solution.history)
        for name, form in problem.quadratic.items():
            values = g_form(history, G, form.matrix)
            yield name, "form", values, _g_scale(history[0], G, form.matrix)


def watch(problem: Problem, solution: Solution, *, G: np.ndarray | None = None) -> list[Drift]:
    """Return drifts of what a problem conserves along a solution; see :func:`quantities`."""
    t = np.asarray(solution.t, dtype=float)
    if not len(t):
        return []
    found = quantities(problem, solution, G=G)
    return [drift(name, t, values, kind=kind, scale=scale) for name, kind, values, scale in found]
