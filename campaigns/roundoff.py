"""Brouwer's law: how round-off grows, with the truncation error out of the way.

A quadratic invariant that the method keeps exactly (y^T C y for a symplectic Runge-Kutta method,
``sum g_ij y_i^T C y_j`` for a G-symplectic one) changes by round-off alone. Over several problems
its root mean square tells a random walk, exponent 1/2, from a drift, exponent 1.

``python -m campaigns.roundoff FILE`` measures all variants of :data:`VARIANTS` over ten
million steps and writes them to a file; ``data/measurements/roundoff.json`` was made so.

References
----------
Brouwer, On the accumulation of errors in numerical integration, Astron. J. 46 (1937) 149-153.
Hairer, McLachlan, Razakarivony, Achieving Brouwer's law with implicit Runge-Kutta methods, BIT 48
(2008) 231-243.
"""

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, fingerprint, renew
from glmref.catalogue.lookup import load
from glmref.compute.records import in_json
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.measure.law import samples_of
from glmref.measure.longtime import slope
from glmref.method import GLM
from glmref.problems import problem
from glmref.problems.model import Problem

#: Samples over the run.
SAMPLES = 8192
#: How the same method is computed: structurally exact coefficients (the sweep of a G-symplectic
#: method, the mu-form of a Runge-Kutta method) or A, U, B, V rounded; compensated summation (with
#: the rounding residue of the tableau) or none. Options of :func:`glmref.solve`.
VARIANTS: Mapping[str, Mapping[str, str]] = {
    "exact form, compensated": {"form": "auto", "arithmetic": "strict"},
    "exact form, plain sums": {"form": "exact", "arithmetic": "naive"},
    "rounded tableau, compensated": {"form": "standard", "arithmetic": "compensated"},
    "rounded tableau, plain sums": {"form": "standard", "arithmetic": "naive"},
}
#: Methods of the record: two of order 6 with several values, two Gauss methods.
METHODS = ("g6245", "g6245-w3", "gauss-2", "gauss-3")
#: Step size and length of the record.
SIZE, STEPS = 1 / 16, 10_000_000
#: What the record says of itself.
HEAD: Mapping[str, str] = {
    "format": "glmref-measurement-1",
    "name": "roundoff",
    "question": "By which law does round-off grow in invariants that the method keeps exactly?",
    "command": "python -m campaigns.roundoff data/measurements/roundoff.json",
    "problem": "Free rigid bodies, first moment of inertia 2, 17/8, 18/8, ..",
    "measured": "Relative deviation of both quadratic invariants; for several values, of their "
    "G-form. `rms`: over n/2 .. n steps and all invariants, for n in `steps`. `exponent`: slope of "
    "log rms against log n. `mean`: over the last stretch. `runs`: number of invariants.",
}


@dataclass(frozen=True)
class RoundOff:
    """Growth of the round-off in invariants that are exact but for it."""

    #: What ran.
    method: str
    kernel: str
    h: float
    steps: tuple[int, ...]  #: Numbers of steps n, each twice the one before.
    #: Root mean square of the relative deviations over n/2 .. n steps, over all invariants.
    rms: tuple[float, ...]
    exponent: float  #: Least squares slope of log rms against log n.
    mean: float  #: Mean deviation over the last stretch, with its sign; a drift shows here.
    runs: int  #: How many invariants of how many problems went into it.


def round_off(
    method: GLM,
    problems: Sequence[Problem],
    *,
    h: float,
    steps: int,
    first: int = 10_000,
    **options: Any,
) -> RoundOff:
    """Measure how the round-off in exactly kept quadratic invariants grows from ``first`` steps on.

    The method is symplectic with one value, or has a form G. There are several problems with such
    invariants, because one walk tells little. The options are those of :func:`glmref.solve`.

    Raises
    ------
    UsageError
        For a method without a form, problems without invariants, or a run that fails.
    """
    if method.r > 1 and method.G is None:
        raise UsageError(
            f"{method.name or 'the method'} gives no form G; its round-off is not seen"
        )
    rows, kernel, counts = [], "", np.zeros(0)
    for subject in problems:
        found = solve(
            subject, method, h=h, steps=steps, every=max(1, steps // SAMPLES), history=True,
            **options,
        )  # fmt: skip
        if not found.completed:
            raise UsageError(f"{subject.name}: {found.message}")
        kernel, counts = found.kernel, np.round(np.asarray(found.t, dtype=float) / h)
        watched = [x if method.r == 1 else f"form of {x}" for x in subject.quadratic]
        rows += [samples_of(subject, method, found, x) for x in watched]
    if not rows:
        raise UsageError("the problems have no quadratic invariants; give others")
    square = np.mean(np.array(rows) ** 2, axis=0)
    marks = [steps // 2**k for k in range(64) if steps // 2**k >= max(first, 4)][::-1]
    rms = [
        float(np.sqrt(np.mean(square[(counts > mark / 2) & (counts <= mark)]))) for mark in marks
    ]
    last = counts > steps / 2
    return RoundOff(
        method=method.name,
        kernel=kernel,
        h=h,
        steps=tuple(marks),
        rms=tuple(rms),
        exponent=slope(
            [(math.log(n), math.log(x)) for n, x in zip(marks, rms, strict=True) if x > 0]
        ),
        mean=float(np.mean(np.array(rows)[:, last])),
        runs=len(rows),
    )


def bodies(count: int = 8) -> list[Problem]:
    """Return free rigid bodies with first moments of inertia 2, 17/8, ..: two invariants each."""
    return [problem("rigid-body", inertia1=f"{16 + k}/8") for k in range(count)]


def options_of(method: GLM, variant: str) -> dict[str, Any]:
    """Return options of :func:`glmref.solve` for one of :data:`VARIANTS`."""
    options: dict[str, Any] = {**VARIANTS[variant], "solver": "fixed-point"}
    if options["form"] == "exact":
        options["form"] = "mu" if method.r == 1 else "sweep"
    return options


def cases() -> list[dict[str, Any]]:
    """List the variants of every method."""
    return [
        {"method": name, "variant": variant, "fingerprint": fingerprint(name)}
        for name in METHODS
        for variant in VARIANTS
    ]


def row(case: Mapping[str, Any], steps: int = STEPS) -> dict[str, Any]:
    """Measure a variant of a method.

    The exact form, compensated, is measured on eight bodies, because the exponent of a random walk
    takes many of them; the others, which drift or are far larger, on three.
    """
    method, variant = load(case["method"]), case["variant"]
    if not isinstance(method, GLM):
        raise UsageError(f"{method.name} is a pair of methods; give methods of one kind of value")
    subjects = bodies(8 if VARIANTS[variant]["arithmetic"] == "strict" else 3)
    options = options_of(method, variant)
    return in_json(round_off(method, subjects, h=SIZE, steps=steps, **options))


if __name__ == "__main__":
    (file,) = arguments(sys.argv[1:])
    renew(Path(file), HEAD, "rows", cases(), row)
