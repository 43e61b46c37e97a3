"""The tables of campaigns/order6/README.md and docs/order6.md, from data/measurements."""

from collections.abc import Callable, Collection, Mapping
from typing import Any

from campaigns.pages import ROOT, Pages, markdown, measured
from campaigns.partitioned.tables import kepler_table

TARGETS = ("1e-06", "1e-09")
BASE = "gauss-3"


def number(value: float | None, digits: int = 2) -> str:
    """Return a number with a few digits, or a dash."""
    if value is None:
        return "-"
    return f"{value:.{digits}g}" if 1e-3 <= abs(value) < 1e4 else f"{value:.{digits - 1}e}"


def frequency(x: Mapping[str, float]) -> str:
    """Return c2 and c3 of a complex eigenvalue, c3 of -1."""
    return f"{number(x['c2'])}, {number(x['c3'])}" if x["argument"] < 3.1 else number(x["c3"])


def constants() -> str:
    """Return constants of every method."""
    rows = []
    for m in measured("order6-methods")["methods"]:
        error, c = m["error"], m["parasitic"]
        rows.append(
            (
                f"`{m['name']}`", m["order"], m["stages"],
                " ".join(map(str, m["implicit"])) if len(m["implicit"]) < m["stages"] else "all",
                number(error["identity"]), number(error["after_conjugation"]),
                number(m["largest"]["A"]), number(m["largest"]["U"]),
                "whole axis" if m["periodicity"] is None else f"{m['periodicity']:.3g}",
                "; ".join(frequency(x) for x in c) or "-",
                f"{m['start_stages']}, {m['finish_stages']}" if m["start_stages"] else "-",
            )
        )  # fmt: skip
    head = [
        *("method", "order", "stages", "implicit", "error, identity", "error, conjugated"),
        *("largest A", "largest U", "periodicity", "parasitic", "start, finish"),
    ]
    return markdown(head, rows)


def fastest(case: Mapping[str, Any], target: str, solver: str) -> dict[str, Mapping[str, float]]:
    """Return method -> its fastest track at an error."""
    best: dict[str, Mapping[str, float]] = {}
    for track in case["tracks"]:
        at = track["at"][target]
        if at is None or (solver and track["solver"] != solver):
            continue
        name = track["method"]
        if name not in best or at["seconds"] < best[name]["seconds"]:
            best[name] = at
    return best


def comparison(solver: str, *cases: str) -> str:
    """Return the time at equal error in units of Gauss-3, with evaluations in brackets."""
    shown = [c for c in measured("order6")["cases"] if c["case"] in cases]
    columns = [(c, t, fastest(c, t, solver)) for c in shown for t in TARGETS]
    names = list(dict.fromkeys(t["method"] for c in shown for t in c["tracks"]))
    rows = []
    for name in names:
        cells = []
        for _, _, best in columns:
            at = best.get(name)
            cells.append(
                "-"
                if at is None
                else f"{number(at['seconds'] / best[BASE]['seconds'])} ({at['evaluations']:.0f})"
            )
        rows.append((f"`{name}`", *cells))
    return markdown(["method", *(f"{c['case']}, {t}" for c, t, _ in columns)], rows)


def verdict(run: Mapping[str, Any]) -> str:
    """Return what became of the parasitic part in ten million steps."""
    if not run["bounded"]:
        return f"30-fold at t = {run['lost']:g}"
    return "grows" if run["parasitic"] > 3 * run["parasitic_early"] else "bounded"


def long_runs() -> str:
    """Tabulate ten million steps."""
    rows = []
    for run in measured("long-runs")["runs"]:
        low = "none" if run["bounded"] else "saturated"
        rate = number(run["rate"]) if run["rate"] > 1.5e-6 else low
        rows.append(
            (
                f"`{run['method']}`", run["run"], f"{run['steps']:,}", number(run["energy"]),
                number(run["parasitic_early"]), number(run["parasitic"]), verdict(run),
                rate,
            )
        )  # fmt: skip
    head = ["method", "run", "steps", "energy", "parasitic, early", "largest", "", "rate"]
    return markdown(head, rows)


def rate_scan() -> str:
    """Return rates of one method over h and the size of the nudge."""
    rows = [
        (f"{x['h']:g}", f"{x['steps']:,}", f"{x['nudge']:g}", number(x["rate"], 3),
            number(x["rate"] / x["h"] ** 2, 4))
        for x in measured("long-runs")["scan"]
    ]  # fmt: skip
    return markdown(["h", "steps", "nudge", "rate", "rate / h^2"], rows)


def kepler() -> str:
    """Tabulate ten million steps of Kepler's problem."""
    names = [r["method"] for r in measured("long-runs")["runs"]]
    shown = [*dict.fromkeys(names), BASE]
    return kepler_table(measured("kepler-long")["runs"], shown)


def starts() -> str:
    """Return what a start costs and buys."""
    found = measured("starts")
    rows = [
        (
            f"`{s['method']}`", s["start"], s["evaluations"], number(s["amplitude"][1]),
            s["order"], *(number(x) for x in s["error"]),
        )
        for s in found["starts"]
    ]  # fmt: skip
    head = ["method", "start", "evaluations", "amplitude, h = 0.1", "power of h"]
    return markdown([*head, *(f"error, h = {h:g}" for h in found["h"])], rows)


def losses() -> str:
    """Tabulate when methods with growth are lost."""
    rows = [
        (f"`{x['method']}`", x["start"], "-" if x["lost"] is None else f"{x['lost']:g}")
        for x in measured("starts")["losses"]["runs"]
    ]
    return markdown(["method", "start", "lost at t"], rows)


def searches() -> str:
    """Return the search for order 8."""
    rows = [
        (
            a["stages"], a["values"], a["stage_order"],
            " ".join(map(str, a["explicit"])) or "none",
            "symmetric" if a["parity"] == [1] else "antisymmetric" if a["parity"] else "no -1",
            " ".join("+" if x > 0 else "-" for x in a["signs"]),
            a["unknowns"], a["conditions"], f"{a['solved']} of {a['starts']}",
            number(a["smallest_residual"]),
        )
        for a in measured("order8-search")["ansatzes"]
    ]  # fmt: skip
    head = [
        *("stages", "values", "stage order", "explicit", "gamma", "signs", "unknowns"),
        *("conditions", "starts that reach zero", "smallest residual"),
    ]
    return markdown(head, rows)


def order8_bound() -> str:
    """Tabulate time in units of Gauss-4, evaluations of a stage in a step, and the bound.

    The bound is the share of the time of Gauss-4 that is left with one evaluation for each stage.
    """
    unit_name = "gauss-4"
    stages = {m["name"]: m["stages"] for m in measured("order6-methods")["methods"]}
    cases = [{x["method"]: x for x in one["methods"]} for one in measured("order8-bound")["cases"]]
    rows = []
    for name in cases[0]:
        cells = [f"`{name}`", stages[name]]
        for known in cases:
            found, unit = known[name], known[unit_name]
            time, steps = (found[key] / unit[key] for key in ("seconds", "steps"))
            each = found["evaluations"] / found["steps"] / stages[name]
            cells.append(f"{time:.2g}; {steps:.2g}; {each:.2g}")
            if name == unit_name:
                cells[-1] += f"; {1e3 * unit['seconds']:.3g} ms"
            elif not name.startswith("gauss"):
                cells[-1] += f"; {time / max(each, 1):.2g}"
        rows.append(cells)
    heads = ["method", "stages", *(x["case"] for x in measured("order8-bound")["cases"])]
    return markdown(heads, rows)


TABLES: Mapping[str, Callable[[], str]] = {
    "constants": constants,
    "orbits": lambda: comparison("", "kepler-0.6", "henon-heiles"),
    "newton": lambda: comparison(
        "newton", "nonseparable-chain-40", "fput-stiff-12", "fput-stiff-80"
    ),
    "any-solver": lambda: comparison("", "nonseparable-chain-40", "fput-stiff-12", "fput-stiff-80"),
    "order8-bound": order8_bound,
    "long-runs": long_runs,
    "rate-scan": rate_scan,
    "kepler-long": kepler,
    "starts": starts,
    "losses": losses,
    "searches": searches,
}


#: Methods with few implicit stages, whose matrices are small where Newton's method is used.
SMALL_MATRICES = ("s5i2-w3", "s5i1-w3")


#: What docs/order6.md shows: exact methods of order 6, those two, those without growth of second
#: order, and three of order 8.
SELECTED = (
    *("g6245", "g6245-w3", *SMALL_MATRICES, "s3z", "s5z-w3"),
    *("order8-s5-w3", "order8-s5i1-w3", "order8-s3-w3-i"),
)


def shipped(names: Collection[str] = ()) -> str:
    """Tabulate methods of order 6 and 8, all by default: stages, error, time, long runs."""
    constants = {m["name"]: m for m in measured("order6-methods")["methods"]}
    cases = {case["case"]: case for case in measured("order6")["cases"]}
    columns = [
        fastest(cases[case], "1e-09", solver)
        for case, solver in (("henon-heiles", ""), ("nonseparable-chain-40", "newton"))
    ]
    long = {(run["method"], run["run"]): run for run in measured("long-runs")["runs"]}
    where: dict[str, list[str]] = {}
    for run in measured("kepler-long")["runs"]:
        where.setdefault(run["method"], []).extend([run["eccentricity"]] * run["bounded"])
    rows = []
    for name in dict.fromkeys(name for name, _ in long if not names or name in names):
        m = constants[name]
        implicit = len(m["implicit"])
        times = (
            number(times[name]["seconds"] / times[BASE]["seconds"]) if name in times else "-"
            for times in columns
        )
        rows.append(
            (
                f"`{name}`", m["order"], m["stages"],
                implicit, number(m["error"]["after_conjugation"]), *times,
                f"{m['start_stages']}, {m['finish_stages']}", verdict(long[name, "pendulum-2.3"]),
                f"bounded at {' and '.join(where[name])}" if where[name] else "grows",
            )
        )  # fmt: skip
    head = [
        *("method", "order", "stages", "implicit", "error constant", "time, Hénon-Heiles"),
        *("time, chain, Newton", "start, finish", "pendulum", "Kepler"),
    ]
    return markdown(head, rows)


#: Page -> name of a table -> what writes it.
PAGES: Pages = {
    ROOT / "campaigns" / "order6" / "README.md": {"shipped": shipped, **TABLES},
    ROOT / "docs" / "order6.md": {"selected": lambda: shipped(SELECTED)},
}
