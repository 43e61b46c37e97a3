"""Ten million steps of every explicit pair: whether energy and carried values stay bounded.

The step size is scaled with the number of stages, so that all pairs take equally many force
evaluations in a unit of time. Pairs start from zero values, so that the carried values q_2 and p_2
begin with what the start leaves out: nothing is tuned away. Recorded are the largest energy error
and the largest carried value up to 10^4, 10^5, 10^6 and 10^7 steps.

    python -m campaigns.partitioned.long_runs data/measurements/pairs-long.json
    python -m campaigns.partitioned.long_runs data/measurements/pairs-long.json PAIR

The second form runs one pair and keeps the runs of the others.

Public names::

    follow_pair(name, case, steps) -> Long          CASES, main(path), add(path, pair)
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from glmref.catalogue.lookup import document, load, names
from glmref.catalogue.strict_json import write_json
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.measure.longtime import along
from glmref.measure.timing import circumstances
from glmref.problems import problem

__all__ = ["CASES", "Case", "Long", "add", "follow_pair", "main", "pair_names", "three_digits"]

STEPS = 10_000_000
#: Steps between samples: no divisor of a period in view.
EVERY = 2503
#: The growth from 10^5 steps to the end that still counts as bounded. A random walk of round-off
#: or a slow beat of the carried values gives a factor of this size; growth in proportion to the
#: time, the slowest that a drift gives, 100.
BOUNDED = 10.0


@dataclass(frozen=True)
class Case:
    """A problem and the time step that belongs to one force evaluation."""

    problem: str
    per_evaluation: float
    parameters: tuple[tuple[str, str], ...] = ()


CASES = (
    Case("pendulum", 1 / 64, (("q0", "23/10"),)),
    Case("henon-heiles", 1 / 64),
)


@dataclass(frozen=True)
class Long:
    """One long run.

    Attributes
    ----------
        pair, problem, h, steps: what was run. outcome: how it ended.
        marks: numbers of steps. energy, carried: largest relative energy error and largest
            absolute entry of the values 2..r up to each.
    """

    pair: str
    problem: str
    h: float
    steps: int
    outcome: str
    marks: tuple[int, ...]
    energy: tuple[float, ...]
    carried: tuple[float, ...]

    @property
    def bounded(self) -> bool:
        """Whether neither grew by more than :data:`BOUNDED` in the last two decades.

        Energy errors within a hundred roundings of zero count as round-off.
        """
        if self.steps < self.marks[-1]:
            return False
        floor = 100 * 2.0**-52
        rows = (self.energy, self.carried)
        return all(row[-1] <= BOUNDED * max(row[-3:][0], floor) for row in rows)

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types, three digits; ``None`` for what is not finite."""
        rows = {key: [three_digits(x) for x in getattr(self, key)] for key in ("energy", "carried")}
        return {
            "method": self.pair,
            "problem": self.problem,
            "h": self.h,
            "steps": self.steps,
            "outcome": self.outcome,
            "marks": list(self.marks),
            "bounded": self.bounded,
            **rows,
        }


def three_digits(x: float) -> float | None:
    """Round to three digits; ``None`` for what is not finite."""
    return float(f"{x:.2e}") if math.isfinite(x) else None


def pair_names() -> list[str]:
    """Names of the explicit pairs of the catalogue that carry values."""
    return [x for x in names("methods") if document(x)["class"] == "pair-sweep"]


def follow_pair(name: str, case: Case, steps: int = STEPS, *, start: str | None = "zero") -> Long:
    """Run a pair and record energy and carried values.

    Args:
        steps: a power of ten from 10^4 on. start: ``"zero"`` values, or ``None`` for the starting
            method of the file.
    """
    pair, target = load(name), problem(case.problem, **dict(case.parameters))
    h = case.per_evaluation * pair.n_Q  # type: ignore[union-attr]
    solution = solve(
        target, pair, h=h, steps=steps, every=min(EVERY, steps // 200), history=True, start=start
    )
    assert solution.history is not None
    taken = np.round((solution.t - target.t_span[0]) / h)
    first = float(along(target.hamiltonian, np.array([target.y0], dtype=float))[0])
    error = np.abs(along(target.hamiltonian, solution.y) - first) / abs(first)
    carried = np.abs(np.asarray(solution.history)[:, 1:]).max(axis=(1, 2))
    marks = tuple(10**k for k in range(4, 20) if 10**k <= steps)
    largest = [
        [float(np.max(np.nan_to_num(row[taken <= n], nan=np.inf))) for n in marks]
        for row in (error, carried)
    ]
    return Long(
        name, case.problem, h, solution.steps, str(solution.outcome), marks,
        tuple(largest[0]), tuple(largest[1]),
    )  # fmt: skip


NOTE = (
    "Largest relative energy error and largest entry of q_2 and p_2 up to each mark, sampled every "
    f"{EVERY} steps; start from zero values; h = (force evaluations a step)/64; bounded: neither "
    f"grows by more than a factor {BOUNDED:g} from 10^5 to 10^7 steps."
)


def main(path: Path, cases: Sequence[Case] = CASES, steps: int = STEPS) -> None:
    """Measure all pairs on all cases and write the file."""
    runs = [follow_pair(name, case, steps).as_json() for name in pair_names() for case in cases]
    record = {
        "format": "glmref-measurement-1",
        "name": "pairs-long",
        "title": "Explicit pairs over ten million steps",
        "how": "python -m campaigns.partitioned.long_runs FILE",
        "notes": [NOTE],
        "circumstances": circumstances(),
        "runs": runs,
    }
    write_json(path, record)


def add(path: Path, name: str, cases: Sequence[Case] = CASES, steps: int = STEPS) -> None:
    """Measure one pair and put its runs into a file, in the place of those that are there.

    Raises
    ------
        UsageError: when the catalogue has no such explicit pair.
    """
    order = pair_names()
    if name not in order:
        raise UsageError(f"the pair must be one of {', '.join(order)}, got {name!r}")
    record = json.loads(path.read_text(encoding="utf-8"))
    runs = [x for x in record["runs"] if x["method"] != name]
    runs += [follow_pair(name, case, steps).as_json() for case in cases]
    record["runs"] = sorted(runs, key=lambda x: order.index(x["method"]))
    write_json(path, record)


if __name__ == "__main__":
    if len(sys.argv) > 2:
        add(Path(sys.argv[1]), sys.argv[2])
    else:
        main(Path(sys.argv[1]))
