"""Strongly stable multistep methods: evaluations, ten million steps without renewal, and time.

    python -m campaigns.partitioned.strong data/measurements/strong-multistep.json

The problems are those of ``nonseparable.json``, whose rivals are not measured again: named ones,
and systems that were written down after other methods had been fixed.
"""

import json
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import ode

from campaigns.driver import TIMED, arguments, carried_out, complete, three_digits
from campaigns.pages import Pages, markdown, measured
from campaigns.partitioned.nonseparable import (
    _DOCS,
    LONG,
    LOST,
    TOLERANCES,
    count_of,
    ends,
    growth,
    long_run,
    long_table,
    needed,
    step_of,
)
from campaigns.partitioned.work import crossing
from glmref import Problem, solve
from glmref.catalogue.lookup import load
from glmref.derive.recipes.strong_multistep import SHIPPED
from glmref.engine.outcome import StartFailed
from glmref.measure.peers import measure_peer, runner
from glmref.measure.timing import circumstances
from glmref.measure.work_precision import Reference, energy_deviation, reference_state, state_error
from glmref.method import Method
from glmref.problems import problem
from glmref.problems.sundman import time_transformed
from tools.measure.timing import interleaved

#: What is timed against what, the first of its numbers of steps, and steps by rounds.
FAST, _RIVAL, _COARSE = "multistep-strong-8", "gauss-4", 20
TIMES = {100_000: 25, 1_000_000: 7}
#: By problem a rate of its time with few operations, dt = rate ds, and the s that the time of the
#: other runs is nearest to. It is the time of a free fall or the turn of a charge where an orbit
#: comes close, a radius or a sine where only coordinates are singular. On the hyperbolic plane
#: nothing is won.
_DISTANCES = "(((x + mass)**2 + y**2)*((x - 1 + mass)**2 + y**2))**(1/2)"
RATES: Mapping[str, tuple[str, float]] = {
    "kepler-polar": ("r**(3/2)", 14.70),
    "post-newtonian-binary": ("(qx**2 + qy**2)**(3/4)", 36.38),
    "rotating-three-body": (_DISTANCES, 41.58),
    "hill-moon": ("(x**2 + y**2)**(3/4)", 29.00),
    "swinging-atwood": ("qr", 14.98),
    "sphere-pendulum": ("sin(a)", 27.64),
    "heavy-top": ("sin(qn)", 22.38),
    "dipole-charge": ("(x**2 + y**2 + z**2)**(3/2)", 55.36),
    "magnetic-bottle": ("1/(field + z**2)", 54.84),
    "hyperbolic-plane": ("1/y", 20.46),
}
#: The numbers of steps of the scenes.
_COUNTS = np.unique(np.geomspace(20, 4000, 28).round().astype(int)).tolist()


def written_down() -> dict[str, Mapping[str, Any]]:
    """Return the systems that are in the record only, by name."""
    return {x["problem"]: x for x in measured("nonseparable")["afterwards"]}


def problem_of(name: str) -> Problem:
    """Return a problem of the record."""
    given = written_down().get(name)
    if given is None:
        return problem(name)
    names = {key: given[key].split() for key in ("coordinates", "momenta")}
    return Problem.from_hamiltonian(given["H"], given["y0"], name=name, **names)


def _counted(
    one: Problem, method: Method, end: float, error: Callable[[np.ndarray], float]
) -> tuple[dict[str, int | None], float | None]:
    """Return the evaluations by tolerance, and the step size of the smallest one."""
    curve: list[tuple[int, float]] = []
    start = 0
    for steps in _COUNTS:
        try:
            found = solve(one, method, h=end / steps, steps=steps, every=steps)
        except StartFailed:
            curve.append((steps, math.inf))
            continue
        start = found.start_evaluations
        size = error(found.y[-1]) if found.completed else math.inf
        curve.append((found.evaluations + start, size))
    counts = {f"{x:g}": needed(curve, x) for x in TOLERANCES}
    least = counts[f"{TOLERANCES[-1]:g}"]
    return counts, float(f"{end / (least - start):.3g}") if least else None


def _measured(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the evaluations by tolerance, and a long run at the step of the smallest one."""
    one, name = problem_of(case["problem"]), case["method"]
    end = ends().get(one.name, 20.0)
    exact = reference_state(one, end)
    counts, h = _counted(one, load(name), end, lambda y: state_error(y, exact))
    row = {**case, "evaluations": counts}
    if h:
        row |= {"h": h, "steps": LONG, **long_run(name, one, h, LONG)}
        if row["reported"] is not None:
            row["growth"] = growth(one, name, h, row["reported"], 0)
    return row


def transformed(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same in a transformed time; errors are of the orbit at the time of the run."""
    plain, (rate, end) = problem_of(case["problem"]), RATES[case["problem"]]
    one = time_transformed(plain, rate)
    at, exact = one.labels.index("t"), reference_state(one, end).state
    own = [k for k in range(plain.dimension + 1) if k != at]

    def error(y: np.ndarray) -> float:
        # to first order in the error of the time
        right = exact[own] + (y[at] - exact[at]) * plain.f(exact[at], exact[own])
        return state_error(y[own], Reference(right, 0.0, "moved"))

    counts, h = _counted(one, load(case["method"]), end, error)
    row = {**case, "rate": rate, "evaluations": counts}
    if h:
        found = solve(one, case["method"], h=h, steps=LONG, every=LONG // 1000)
        states = np.vstack([plain.y0, found.y[:, own]])
        size = float(energy_deviation(plain, states).max()) if found.completed else None
        row |= {"h": h, "steps": LONG, "energy": size and float(f"{size:.2g}")}
        row["reported"] = found.suspect
    return row


def adams(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the evaluations of the Adams methods of VODE, orders to 12, by tolerance."""
    one, evaluations = problem_of(case["problem"]), 0

    def f(t: float, y: np.ndarray) -> np.ndarray:
        nonlocal evaluations
        evaluations += 1
        return one.f(t, y)

    end, curve = ends().get(one.name, 20.0), []
    exact = reference_state(one, end)
    for tolerance in 10.0 ** -np.arange(6, 14.1, 0.5):
        evaluations = 0
        code = ode(f).set_integrator("vode", method="adams", rtol=tolerance, atol=tolerance / 10,
                                     nsteps=10**6, order=12)  # fmt: skip
        code.set_initial_value(one.y0, 0.0)
        state = code.integrate(end)
        curve.append((evaluations, state_error(state, exact)))
    found = {f"{x:g}": crossing(curve, x) for x in TOLERANCES}
    return {**case, "evaluations": {k: n and round(n) for k, n in found.items()}}


def _least(ways: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float | None]:
    """Return the least processor time of each way over rounds in which they take turns."""
    return {way: three_digits(min(x)) for way, x in interleaved(ways, rounds).items()}


def times(case: Mapping[str, Any]) -> dict[str, Any]:
    """Time whole runs at the step sizes of 1e-9: the least of many, which take turns."""
    one = problem_of(case["problem"])
    found = step_of(load(_RIVAL), one, _COARSE)
    assert found is not None
    row: dict[str, Any] = {**case, "rival_h": found[0], "seconds": {}}
    for steps, rounds in TIMES.items():
        rival = {"method": _RIVAL, "h": found[0], "steps": round(steps * case["h"] / found[0])}
        ways = {
            "own": partial(solve, one, FAST, h=case["h"], steps=steps),
            "rival": partial(solve, one, **rival),
        }
        row["seconds"][str(steps)] = _least(ways, rounds)
    return row


def taylor(case: Mapping[str, Any]) -> dict[str, Any]:
    """Time 100,000 steps against heyoka's Taylor method at the tolerance that gives 1e-9."""
    one, h = problem_of(case["problem"]), case["h"]
    end, steps = ends().get(one.name, 20.0), min(TIMES)

    def gives(tolerance: float) -> bool:
        found = measure_peer("heyoka", one, tolerance=tolerance, t_end=end, repeats=1)
        return found.get("state_error", math.inf) < TOLERANCES[-1]

    tolerance = next(x for x in (1e-8, 1e-9, 1e-10, 1e-11, 1e-12) if gives(x))
    at = np.array([h * steps])
    rival = runner("heyoka", one, tolerance=tolerance, times=at)
    ways = {"own": partial(solve, one, FAST, h=h, steps=steps), "heyoka": rival}
    return {**case, "tolerance": tolerance, "seconds": _least(ways, TIMES[steps])}


def kept(runs: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the step sizes of the long runs that are neither lost nor reported, by problem."""
    return {
        x["problem"]: x["h"] for x in runs
        if x["method"] == FAST and "h" in x and x["reported"] is None and x["energy"] < LOST
    }  # fmt: skip


def ratios(rows: Sequence[Mapping[str, Any]], steps: int) -> list[float]:
    """Return the times over that of the rival, in increasing order."""
    found = [x["seconds"][str(steps)] for x in rows]
    return sorted(x["own"] / x["rival"] for x in found)


def main(path: Path) -> None:
    """Measure all, and write the record."""
    record = json.loads(path.read_text(encoding="utf-8"))
    names = dict.fromkeys(
        [*(x["problem"] for x in measured("nonseparable")["long"]), *written_down()]
    )
    cases = [{"problem": x, "method": m} for x in names for m in SHIPPED]
    record["runs"] = carried_out(_measured, cases, beside=path)
    cases = [{"problem": x, "method": m} for x in RATES for m in SHIPPED]
    record["transformed"] = carried_out(transformed, cases, beside=path)
    semi = {x["problem"] for x in measured("nonseparable")["semi-separable"]["evaluations"]}
    cases = [{"problem": x} for x in names if rivals(x, TOLERANCES[-1])]
    record["adams"] = carried_out(adams, cases, beside=path)
    cases = [{"problem": x, "method": m} for x in sorted(semi - names.keys()) for m in SHIPPED]
    record["velocities"] = carried_out(_measured, cases, beside=path)
    timed = [{"problem": name, "h": h} for name, h in kept(record["runs"]).items()]
    rows = carried_out(times, timed, beside=path, limits=TIMED)
    record["times"] = {"where": circumstances(), "rows": rows}
    rows = carried_out(taylor, timed, beside=path, limits=TIMED)
    record["heyoka"] = {"where": circumstances(), "rows": rows}
    complete(path, record)


def rivals(name: str, tolerance: float) -> dict[str, int]:
    """Return the evaluations that the record of the other methods has, by method."""
    if (given := written_down().get(name)) is not None:
        found = given["evaluations"][f"{tolerance:g}"]
    else:
        rows = measured("nonseparable")["evaluations"]
        found = next(
            (x["methods"] for x in rows if (x["problem"], x["tolerance"]) == (name, tolerance)), {}
        )
    return {k: n for k, n in found.items() if n}


def best_gauss(counts: Mapping[str, int]) -> int:
    """Return the fewest evaluations of a Gauss method."""
    return min(n for name, n in counts.items() if name.startswith("gauss"))


def by_problem() -> dict[str, dict[str, Any]]:
    """Return the measurements by problem and method."""
    found: dict[str, dict[str, Any]] = {}
    for x in measured("strong-multistep")["runs"]:
        found.setdefault(x["problem"], {})[x["method"]] = x
    return found


def table(tolerance: float = TOLERANCES[-1]) -> str:
    """Return the evaluations on the problems held out that have rivals in the record."""
    lines = []
    for name, own in by_problem().items():
        if name not in written_down() and (counts := rivals(name, tolerance)):
            shown = [own[m]["evaluations"][f"{tolerance:g}"] for m in SHIPPED]
            shown += [counts["multistep-general-8b"], best_gauss(counts), counts["scipy-dop853"]]
            lines.append([name, *(f"{n:,}" for n in shown)])
    heads = ["problem", *(f"`{m}`" for m in SHIPPED), "`multistep-general-8b`"]
    return markdown([*heads, "best Gauss", "DOP853"], lines)


def _rivals(name: str) -> tuple[int | None, int | None]:
    """Return the evaluations at 1e-9 of the best Gauss method and of DOP853, where measured."""
    rows = measured("nonseparable")["semi-separable"]["evaluations"]
    found = rivals(name, TOLERANCES[-1]) or next(
        (x["methods"] for x in rows if (x["problem"], x["tolerance"]) == (name, TOLERANCES[-1])), {}
    )
    known = {k: n for k, n in found.items() if n}
    return (best_gauss(known) if known else None), known.get("scipy-dop853")


def fixed() -> dict[tuple[str, str], dict[str, Any]]:
    """Return all measurements with a fixed step, by problem and method."""
    record = measured("strong-multistep")
    return {(x["problem"], x["method"]): x for x in [*record["runs"], *record["velocities"]]}


def transformed_table() -> str:
    """Return the runs in a transformed time: evaluations before and after, and the energy."""
    lines = []
    for x in measured("strong-multistep")["transformed"]:
        if x["method"] == FAST:
            before = fixed()[x["problem"], FAST]
            counts = [y["evaluations"]["1e-09"] for y in (before, x)]
            shown = [count_of(n) for n in (*counts, *_rivals(x["problem"]))]
            lines.append([x["problem"], f"`{x['rate']}`", *shown, f"{x['energy']:.1e}"])
    heads = ["problem", "rate", "fixed", "transformed", "best Gauss", "DOP853", "energy"]
    return markdown(heads, lines)


#: What the table of long runs has beside: a pair without renewal, and one with.
_PAIRS = (("multistep-general-8", 0), ("multistep-general-8c", 1000))


def long_rows() -> list[dict[str, Any]]:
    """Return the long runs of the table, by problem, method and ``renew``."""
    record = measured("nonseparable")
    runs = [{**x, "renew": 0} for x in measured("strong-multistep")["runs"]]
    runs += record["long"]
    runs += [{**x, "problem": one["problem"]} for one in record["afterwards"] for x in one["long"]]
    columns = [*((m, 0) for m in SHIPPED), *_PAIRS]
    return [x for x in runs if (x["method"], x["renew"]) in columns]


def _long_table() -> str:
    return long_table(long_rows(), [*((m, 0) for m in SHIPPED), *_PAIRS], LOST)


PAGES: Pages = {
    _DOCS / "nonseparable.md": {"strong": table},
    _DOCS / "close-encounters.md": {"strong-transformed": transformed_table},
    _DOCS / "nonseparable" / "long-runs.md": {"strong-long": _long_table},
}


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
