"""By which law an error grows, and what makes it grow.

The law is read from the root mean square of the deviation over dyadic stretches of time: exponent 0
is bounded, 1/2 a random walk, 1 linear, 2 quadratic; a run whose deviation reaches its own unit, or
ends early, has blown up.

Three runs show the cause: with h, with h/2, and with h at a higher precision. What the higher
precision removes was round-off. What is left belongs to the method: parasitism where the values
beyond the solution outgrow it, a drift otherwise, whose order in h the run with h/2 shows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..compute.records import in_json
from ..engine.outcome import Solution
from ..engine.solve import solve
from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from .longtime import along, energy_scale, exponent, g_form
from .parasitic import parasitic_size, solution_direction

#: Laws, and the exponents up to which they are taken: halfway to the next one.
KINDS = {"bounded": 0.25, "random walk": 0.75, "linear": 1.5, "quadratic": 2.5}
BLOW_UP = "blow-up"
#: Relative deviation at which a run has blown up.
LOST = 1.0
#: Part of the deviation that must go at a higher precision for round-off to be its cause.
REMOVED = 0.5
#: Growth of the values beyond the solution that counts as parasitic.
OUTGROWN = 10.0
#: Deviation below which what is seen is the rounding of the sample itself: a few units of 2^-53.
ONE_ROUNDING = 2.0**-50
#: Samples of each run.
SAMPLES = 2048


@dataclass(frozen=True)
class Law:
    """How a deviation grew."""

    kind: str  #: One of :data:`KINDS` or ``"blow-up"``.
    exponent: float  #: Slope of log rms against log t; NaN where there is nothing to fit.
    largest: float  #: Largest deviation.
    last: float  #: Root mean square over the last half of the time.
    time: float  #: Length of the run; of a blow-up, when the deviation reached :data:`LOST`.

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types."""
        return in_json(self)


@dataclass(frozen=True)
class Diagnosis:
    """A law and its cause."""

    #: What was watched.
    method: str
    problem: str
    quantity: str
    #: Of the first run.
    h: float
    steps: int
    law: Law  #: With h.
    half: Law  #: With h/2 over the same time.
    precise: Law  #: With h at ``digits`` digits, over ``precise_steps`` steps.
    precise_steps: int
    digits: int
    compared: float  #: Rms of the first run over those steps.
    order: float  #: Order of the deviation in h, from the first two; NaN where it means nothing.
    cause: str  #: none, round-off, drift, parasitism or bounded truncation.

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types."""
        return in_json(self)


def fit_law(t: np.ndarray, deviation: np.ndarray, *, ended: bool = False) -> Law:
    """Fit the law of relative deviations (m,), the first of them zero, at times (m,).

    ``ended`` says whether the run ended before its time.
    """
    elapsed = np.abs(np.asarray(t, dtype=float) - float(t[0]))
    sizes = np.abs(np.asarray(deviation, dtype=float))
    over = np.flatnonzero(~(sizes < LOST))
    if len(over) or ended:
        time = float(elapsed[over[0]]) if len(over) else float(elapsed[-1])
        good = sizes[np.isfinite(sizes)]
        return Law(BLOW_UP, math.nan, float(np.max(good, initial=0.0)), math.nan, time)
    found = exponent(elapsed, sizes)
    late = sizes[elapsed > elapsed[-1] / 2]
    rms = float(np.sqrt(np.mean(late**2))) if len(late) else 0.0
    kind = "bounded"
    if not math.isnan(found):
        kind = next((name for name, most in KINDS.items() if found < most), BLOW_UP)
    return Law(kind, found, float(np.max(sizes)), rms, float(elapsed[-1]))


def samples_of(problem: Problem, method: Method, solution: Solution, quantity: str) -> np.ndarray:
    """Return the relative deviation of one conserved quantity along a solution, (m,).

    It is ``"energy"``, the name of an invariant, or ``"form of NAME"``: the form G of all values of
    a quadratic invariant.

    Raises
    ------
    UsageError
        For a quantity that the problem, or the method, does not have.
    """
    with np.errstate(all="ignore"):
        if quantity.startswith("form of "):
            form = problem.quadratic.get(quantity.removeprefix("form of "))
            if form is None or len(method.components) > 1 or method.G is None:
                raise UsageError(f"{method.name} on {problem.name} has no {quantity!r}")
            G = np.array([[complex(x) for x in row] for row in method.G])
            values = g_form(np.asarray(solution.history), G, form.matrix)
        else:
            known = {"energy": problem.hamiltonian, **problem.quadratic, **problem.invariants}
            function = known.get(quantity)
            if function is None:
                listed = ", ".join(k for k, v in known.items() if v is not None)
                raise UsageError(f"{problem.name} conserves no {quantity!r}; it has {listed}")
            y = np.real(np.asarray(solution.y)).astype(float)
            values = along(function, y)
            if function is problem.hamiltonian:
                return (values - values[0]) / energy_scale(problem, y[0])
        return (values - values[0]) / (abs(values[0]) or 1.0)


def diagnose(
    problem: Problem,
    method: Method,
    *,
    h: float,
    steps: int,
    quantity: str = "energy",
    digits: int = 30,
    precise_steps: int | None = None,
    **options: Any,
) -> Diagnosis:
    """Tell by which law a conserved quantity (see :func:`samples_of`) deviates, and why.

    The precise run, of all steps by default, is taken by the reference engine: slowly. The options
    are those of :func:`glmref.solve` for the runs in double precision.

    Raises
    ------
    UsageError
        As :func:`samples_of`.
    """
    short = min(steps, steps if precise_steps is None else precise_steps)
    history = method.parts == 1 and method.carried > 1
    common = {"history": history or quantity.startswith("form"), **options}
    first = solve(problem, method, h=h, steps=steps, every=max(1, steps // SAMPLES), **common)
    half = solve(
        problem, method, h=h / 2, steps=2 * steps, every=max(1, 2 * steps // SAMPLES), **common
    )
    exact = solve(
        problem, method, h=h, steps=short, every=max(1, short // SAMPLES), engine="reference",
        digits=digits, history=bool(common["history"]),
    )  # fmt: skip
    exact_y = np.array(exact.y, dtype=complex if np.iscomplexobj(exact.y) else float)
    laws, kept = [], []
    for run in (first, half, exact):
        times = np.asarray(run.t, dtype=float)
        deviation = samples_of(problem, method, _in_doubles(run, exact_y), quantity)
        laws.append(fit_law(times, deviation, ended=not run.completed))
        kept.append((times, deviation))
    early = np.abs(kept[0][0] - kept[0][0][0]) <= abs(h) * short * (1 + 1e-12)
    compared = fit_law(kept[0][0][early], kept[0][1][early])
    ratio = laws[0].last / laws[1].last if laws[1].last else math.nan
    return Diagnosis(
        method=method.name,
        problem=problem.name,
        quantity=quantity,
        h=h,
        steps=steps,
        law=laws[0],
        half=laws[1],
        precise=laws[2],
        precise_steps=short,
        digits=digits,
        compared=compared.last,
        order=math.log2(ratio) if ratio > 0 else math.nan,
        cause=_cause(method, first, laws, compared),
    )


def _in_doubles(run: Solution, y: np.ndarray) -> Solution:
    """Return the run itself, or the precise one rounded to doubles."""
    if np.asarray(run.y).dtype != object:
        return run
    history = None if run.history is None else np.array(run.history).astype(complex)
    return replace(run, y=y, history=history)


def _cause(method: Method, first: Solution, laws: list[Law], compared: Law) -> str:
    law, _, precise = laws
    if law.largest == 0.0:
        return "none"
    if law.largest < ONE_ROUNDING:
        return "round-off"
    if compared.kind != BLOW_UP and precise.last < REMOVED * compared.last:
        return "round-off"
    if _outgrown(method, first):
        return "parasitism"
    return "bounded truncation" if law.kind == "bounded" else "drift"


def _outgrown(method: Method, run: Solution) -> bool:
    """Return whether the values beyond the solution ended larger than they began."""
    if run.history is None:
        return False
    sizes = parasitic_size(run, solution_direction(method))
    early = float(np.max(sizes[: max(2, len(sizes) // 64)]))
    late = float(np.max(sizes[len(sizes) // 2 :][np.isfinite(sizes[len(sizes) // 2 :])], initial=0))
    return late > OUTGROWN * early or not bool(np.isfinite(sizes).all())
