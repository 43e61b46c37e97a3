"""What a start costs and what it buys: evaluations, parasitic amplitude, error, time to loss.

``python -m campaigns.order6.starts FILE`` measures and writes ``FILE`` (the one shipped is
``data/measurements/starts.json``).

The starts are *zero* (y0, 0, .., 0); *explicit*, the tableau of the method's file; *enhanced* with
k passes (2^k - 1 steps); *iterated* with k passes along the trajectory (k (k + 1)/2 steps), see
:mod:`glmref.measure.underlying`. The last two need a first value that is the solution itself.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, record_of
from campaigns.order6.compare import four_digits
from glmref.catalogue.lookup import load
from glmref.engine.reference import Stepper, apply_finish, stepper
from glmref.engine.starting_values import enhanced_start, starting_values
from glmref.measure.longtime import follow
from glmref.measure.parasitic import loss, solution_direction
from glmref.measure.underlying import Underlying
from glmref.measure.work_precision import reference_state, state_error
from glmref.method import GLM
from glmref.problems import problem

IDENTITY = ("g6245", "g6245-w3", "c2-3-10-w3")
CONJUGATION = ("s5i1-w3", "s3-w3", "t115a-i")
STEP_SIZES = (0.2, 0.1, 0.05)
#: Amplitudes are formed with so many digits, and to an order where nothing is left of the ideal.
DIGITS, IDEAL = 30, 9
KEPLER = {"eccentricity": "1/5"}
T_END = 20.0


def begin(kind: str, engine: Stepper, y0: np.ndarray, h: Any) -> tuple[np.ndarray, int]:
    """Return starting values (r, d) and the evaluations they cost.

    The kind is ``"zero"``, ``"explicit"``, ``"enhanced k"`` or ``"iterated k"``.
    """
    name, _, passes = kind.partition(" ")
    if name == "enhanced":
        return enhanced_start(engine, engine.arithmetic.number(0), y0, h, int(passes))
    if name == "iterated":
        underlying = Underlying(engine)
        values = underlying.start(engine.arithmetic.number(0), y0, h, order=int(passes))
        return values, underlying.evaluations
    own = engine.method.starting if name == "explicit" else "zero"
    given = starting_values(engine, own, t=engine.arithmetic.number(0), y0=y0, h=h)
    return given.values, given.evaluations


def kinds(name: str) -> list[str]:
    """Return the starts of a method."""
    found = ["zero", "explicit"]
    if name in IDENTITY:
        found += [f"{kind} {k}" for kind in ("enhanced", "iterated") for k in (2, 3, 4, 5)]
    return found


def amplitudes(name: str, kind: str) -> dict[str, Any]:
    """Return the parasitic part a start leaves on Kepler's problem, and its power of h."""
    method = load(name)
    assert isinstance(method, GLM)
    engine = stepper(method, problem("kepler", **KEPLER), digits=DIGITS)
    y0, sizes = np.array(engine.problem.y0), []
    for h in STEP_SIZES:
        step = engine.arithmetic.number(h)
        values, _ = begin(kind, engine, y0, step)
        rest = Underlying(engine).parasitic(engine.arithmetic.number(0), values, step, order=IDEAL)
        sizes.append(float(sum(abs(x) ** 2 for x in rest.ravel()) ** 0.5))
    order = math.log2(sizes[-2] / sizes[-1])
    return {"amplitude": [four_digits(x) for x in sizes], "order": round(order, 2)}


def final_errors(name: str, kind: str) -> dict[str, Any]:
    """Return evaluations of the start, in double precision, and the error at the end of a run."""
    method, subject = load(name), problem("kepler", **KEPLER)
    assert isinstance(method, GLM)
    engine, reference = stepper(method, subject), reference_state(subject, T_END)
    y0, errors, cost = np.array(subject.y0), [], 0
    for h in STEP_SIZES:
        values, cost = begin(kind, engine, y0, h)
        n = round(T_END / h)
        for k in range(n):
            values = engine.step(k * h, values, h).values
        y = engine.solution(values)
        if method.finishing is not None and kind != "zero":
            y, _ = apply_finish(method.finishing, engine, T_END, y, h)
        errors.append(four_digits(state_error(np.asarray(y, dtype=float), reference)))
    return {"evaluations": cost, "error": errors}


def loss_times(name: str, kind: str, *, h: float = 0.1, steps: int = 100_000) -> float | None:
    """Return the time at which a method with growth is lost on the pendulum from 2.3 radians."""
    method, subject = load(name), problem("pendulum", q0="23/10")
    assert isinstance(method, GLM)
    values, _ = begin(kind, stepper(method, subject), np.array(subject.y0, dtype=float), h)
    u = solution_direction(method)
    ended = follow(
        subject, method, h=h, steps=steps, start=values,
        lost=lambda part: loss(subject, part, u).time is not None,
    )  # fmt: skip
    time = loss(subject, ended, u).time
    return None if time is None else four_digits(time)


def start_row(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return errors and parasitic part of a method from a start."""
    given = case["method"], case["start"]
    return {**case, **final_errors(*given), **amplitudes(*given)}


def loss_row(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return when a method is lost that began with a start."""
    return {**case, "lost": loss_times(case["method"], case["start"])}


def main(path: Path) -> None:
    """Measure everything and write the file."""
    cases = (
        {"method": name, "start": kind}
        for name in (*IDENTITY, *CONJUGATION)
        for kind in kinds(name)
    )
    starts = carried_out(start_row, cases, beside=path)
    cases = (
        {"method": name, "start": kind}
        for name in ("gsymplectic-p", "gsymplectic-n")
        for kind in ("zero", "explicit", "enhanced 2", "enhanced 4", "enhanced 8")
    )
    losses = carried_out(loss_row, cases, beside=path)
    record = record_of("order6.starts", "starts", "What a start costs and what it buys")
    record |= {"problem": {"name": "kepler", **KEPLER, "t_end": T_END}, "h": list(STEP_SIZES)}
    record["starts"] = starts
    record["losses"] = {"problem": {"name": "pendulum", "q0": "23/10"}, "h": 0.1, "runs": losses}
    complete(path, record)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
