"""What the starting method of a pair changes: misses, their orders, and ten million steps.

Two starts are compared: zero values, (y0, 0), and the starting method of the file. In 50 digits, on
the pendulum: by how much the values carried differ from the exact starting values (computed by
iteration, :mod:`glmref.measure.underlying`, no series), and by how much that makes the first values
differ after a unit of time. Differences are even in h, as starts and pairs are; an observed order
is log2 of the ratio between h = 1/32 and 1/64. In double precision: the runs of :mod:`.long_runs`
again, from the starting method.

    python -m campaigns.partitioned.starts data/measurements/pairs-starts.json
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, record_of
from campaigns.pages import markdown
from campaigns.partitioned.long_runs import (
    CASES,
    STEPS,
    Case,
    pair_names,
    pair_row,
    shown_error,
    three_digits,
)
from glmref.catalogue.lookup import load
from glmref.engine.reference import stepper
from glmref.engine.starting_values import zero_start
from glmref.measure.underlying import Underlying
from glmref.method import PartitionedGLM
from glmref.problems import problem

DIGITS = 50
#: Where orders are observed, by problem: the first is measured, the second a further witness.
SUBJECTS: Mapping[str, Mapping[str, str]] = {
    "pendulum": {"q0": "3/2", "p0": "3/10"},
    "kepler": {"eccentricity": "1/5"},
}
SIZES = (Fraction(1, 32), Fraction(1, 64))
#: How many times longer a run is taken that is bounded: slow growth shows late.
FURTHER = 10


@dataclass(frozen=True)
class Misses:
    """Largest differences to the run from exact starting values."""

    carried: tuple[float, float]  #: Of the values 2..r at the start.
    #: Of the first values at the end, over the last two steps. Each for the zero start and for that
    #: of the file.
    first: tuple[float, float]
    evaluations: tuple[int, int]  #: Of k and of f by the start of the file.


def misses(name: str, h: Fraction, *, of: str = "pendulum", end: int = 1) -> Misses:
    """Compare both starts with exact starting values, see the module docstring.

    Of one of :data:`SUBJECTS`; ``end / h`` is a whole number of steps.
    """
    pair = load(name)
    assert isinstance(pair, PartitionedGLM) and pair.starting is not None
    engine = stepper(pair, problem(of, **SUBJECTS[of]), digits=DIGITS)
    number = engine.arithmetic.number
    zero, size = number(0), number(h.numerator) / h.denominator
    y0 = np.array(engine.problem.y0)
    # beyond the even order above that of the start, so that what is seen is the start's own error
    passes = 6 + max(pair.claims[x] for x in ("order", "nystrom-order") if x in pair.claims)
    underlying = Underlying(engine)
    exact = underlying.start(zero, y0, size, order=passes)
    taken = engine.of(pair.starting).step(zero, y0[None, :], size)
    own, cost = taken.values, [taken.evaluations, taken.velocity_evaluations]
    begun = (exact, zero_start(engine, y0), own)
    steps = int(end / h) - 1
    ends = []
    for values in begun:
        last = underlying.run(zero, values, size, steps)
        ends.append(np.stack([last[0], underlying.run(zero, last, size, 1)[0]]))
    carried = [_largest(x[1:] - exact[1:]) for x in begun[1:]]
    first = [_largest(x - ends[0]) for x in ends[1:]]
    return Misses((carried[0], carried[1]), (first[0], first[1]), (cost[0], cost[1]))


def _largest(difference: np.ndarray) -> float:
    return float(max(abs(x) for x in difference.ravel()))


def observed(name: str, of: str = "pendulum") -> dict[str, Any]:
    """Return what :func:`misses` finds at the smaller step size, with the observed orders."""
    coarse, fine = (misses(name, h, of=of) for h in SIZES)

    def order(what: str, kind: int) -> float:
        ratio = getattr(coarse, what)[kind] / getattr(fine, what)[kind]
        return round(math.log2(ratio), 2)

    return {
        "method": name,
        "evaluations": list(fine.evaluations),
        "carried": {
            start: {"size": three_digits(fine.carried[kind]), "order": order("carried", kind)}
            for kind, start in enumerate(("zero", "own"))
        },
        "first": {
            start: {"size": three_digits(fine.first[kind]), "order": order("first", kind)}
            for kind, start in enumerate(("zero", "own"))
        },
    }


def start_row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Carry out :func:`observed` for a task in JSON."""
    return observed(task["method"])


def started_pairs() -> list[str]:
    """Return names of the explicit pairs whose files give a starting method."""
    return [x for x in pair_names() if load(x).starting is not None]


NOTE = (
    "starts: pendulum (1.5, 0.3), 50 digits, h = 1/64. carried: largest difference of q_2, p_2 to "
    "the exact starting values; first: largest difference of q_1, p_1 at t = 1 to the run from "
    "exact starting values, over two steps; order: log2 of the ratio to h = 1/32. evaluations: of "
    "k and of f by the starting method of the file. runs: as in pairs-long.json, from the starting "
    "method of the file instead of zero values. further: those of them that are bounded, ten times "
    "as long; bounded: no growth by more than a factor 10 in the last two decades of steps."
)


def main(path: Path, cases: Sequence[Case] = CASES, steps: int = STEPS) -> None:
    """Measure all pairs that have a starting method and write the file."""
    pairs = started_pairs()
    tasks = [
        {"method": name, "steps": steps, "start": None, **asdict(case)}
        for name in pairs
        for case in cases
    ]
    runs = carried_out(pair_row, tasks, beside=path)
    further = [
        {**task, "steps": FURTHER * steps}
        for task, run in zip(tasks, runs, strict=True)
        if run["bounded"]
    ]
    title = "What the starting method of an explicit pair changes"
    record = record_of("partitioned.starts", "pairs-starts", title, NOTE)
    record["starts"] = carried_out(start_row, ({"method": name} for name in pairs), beside=path)
    record["runs"], record["further"] = runs, carried_out(pair_row, further, beside=path)
    complete(path, record)


def starts_table(document: Mapping[str, Any]) -> str:
    """Return misses of both starts and their orders, in Markdown."""
    rows = []
    for row in document["starts"]:
        cells = [
            f"{row[what][start]['size']:.1e} ({row[what][start]['order']:.1f})"
            for what in ("carried", "first")
            for start in ("zero", "own")
        ]
        k, f = row["evaluations"]
        rows.append([row["method"], f"{k}, {f}", *cells])
    head = "pair; evaluations of k, f; carried: zero; own; first: zero; own"
    return markdown(head.split("; "), rows)


def runs_table(document: Mapping[str, Any], zero: Mapping[str, Any]) -> str:
    """Tabulate ten million steps from both starts: energy error and carried values."""
    rows = []
    known = {(x["method"], x["problem"]): x for x in zero["runs"]}
    for own in document["runs"]:
        other = known[own["method"], own["problem"]]
        cells = [shown_error(x[what][-1]) for what in ("energy", "carried") for x in (other, own)]
        cells += ["yes" if x["bounded"] else "no" for x in (other, own)]
        rows.append([own["method"], own["problem"], *cells])
    head = "pair; problem; energy: zero; own; carried: zero; own; bounded: zero; own"
    return markdown(head.split("; "), rows)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
