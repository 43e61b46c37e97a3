"""The tables of docs/results.md, from the files in data/measurements."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from campaigns.order6.tables import fastest
from campaigns.pages import Pages, measured, row, table
from campaigns.partitioned import held_out
from campaigns.partitioned.tables import GROUPS, PAIRS, best
from campaigns.partitioned.work import mean
from glmref.catalogue.advice import ADVICE, long_runs
from glmref.catalogue.claims import G_SYMPLECTIC
from glmref.catalogue.lookup import document, load

PAGE = Path(__file__).parents[1] / "docs" / "results.md"
#: Tolerances of the records, as they are written there, and on the page.
TOLERANCES = {"1e-06": "1e-6", "1e-09": "1e-9", "1e-12": "1e-12"}
#: Kind of the advice -> what its methods are compared with.
CLASSICAL = {
    "second order": "splitting", "separable": "splitting", "Hamiltonian": "Gauss",
    "semi-separable": "Gauss",
}  # fmt: skip
#: Classes of general linear methods of one component with several values.
SEVERAL = ("glm", "sweep")

Costs = Mapping[str, float]


def costs(kind: str, tolerance: str) -> Iterator[Costs]:
    """Yield, problem by problem, the evaluations of each method that reaches a tolerance.

    Kinds are the keys of :data:`CLASSICAL`, tolerances those of :data:`TOLERANCES`.
    """
    if CLASSICAL[kind] == "splitting":
        for case in measured("held-out-digits")["cases"]:
            if held_out.quadratic(case["case"]) == (kind == "second order"):
                found = {x["method"]: x["needed"].get(tolerance) for x in case["methods"]}
                yield {name: n for name, n in found.items() if n}
        return
    record = measured("nonseparable")
    rows = record["evaluations"] if kind == "Hamiltonian" else record[kind]["evaluations"]
    strong = {
        (x["problem"], x["method"]): x["evaluations"].get(tolerance)
        for x in measured("strong-multistep")["runs"]
    }
    for case in rows:
        if case["tolerance"] == float(tolerance):
            own = {m: n for (problem, m), n in strong.items() if problem == case["problem"]}
            yield {name: n for name, n in (case["methods"] | own).items() if n}


def is_classical(kind: str, name: str) -> bool:
    """Return whether a method is one of those that a kind of problem is compared with."""
    if CLASSICAL[kind] == "Gauss":
        return name.startswith("gauss")
    return name in held_out.GROUPS[kind == "second order"]["splitting"]


def shares(kind: str, tolerance: str) -> tuple[dict[str, float], int]:
    """Return what methods need, as parts of the best classical method of each problem.

    That is the geometric mean over the problems, of the methods that reach the tolerance on all of
    them, without codes of others, which are not in the catalogue; and the number of problems: those
    on which a classical and another method reach the tolerance.
    """
    problems = []
    for found in costs(kind, tolerance):
        ours = {x: n for x, n in found.items() if "scipy" not in x}
        known = [n for x, n in ours.items() if is_classical(kind, x)]
        if 0 < len(known) < len(ours):
            problems.append({x: n / min(known) for x, n in ours.items()})
    names = set.intersection(*map(set, problems)) if problems else set()
    return {x: mean([one[x] for one in problems]) for x in names}, len(problems)


def cheapest(kind: str, found: Costs) -> str:
    """Return the method that needs the least of those that are not classical."""
    return min((x for x in found if not is_classical(kind, x)), key=lambda name: found[name])


def published() -> list[float]:
    """Return the least shares of published multistep methods on second-order systems."""
    names = held_out.GROUPS[True]["published multistep"]
    every = (shares("second order", tolerance)[0] for tolerance in TOLERANCES)
    return [min(found[x] for x in names if x in found) for found in every]


def explicit() -> str:
    """Return the best explicit method for each kind of system and each error."""
    rows = []
    for one in ADVICE:
        if one.kind not in CLASSICAL:
            continue
        for tolerance, shown in TOLERANCES.items():
            found, count = shares(one.kind, tolerance)
            if not found:
                continue
            least, advised = cheapest(one.kind, found), one.take[0]
            said = f"`{advised}`, {found[advised]:.2f}" if advised in found else "-"
            rows.append(
                row(one.need, shown, f"`{least}`", f"{found[least]:.2f}", ends(least), said, count)
            )
    heads = ("system", "error", "fewest evaluations", "share", "long runs", "advised, share")
    return table([*heads, "problems"], rows)


def ends(name: str) -> str:
    """Return what the file of a method says of long runs."""
    return long_runs(load(name), document(name).get("notes", []))


# --- G-symplectic general linear methods ----------------------------------------------------------


def lost() -> tuple[int, int]:
    """Return how many implicit methods stayed bounded on all three Kepler orbits, and of how many.

    The methods are the G-symplectic general linear ones of the record; ten million steps each.
    """
    runs: dict[str, list[bool]] = {}
    for run in measured("kepler-long")["runs"]:
        file = document(run["method"])
        if file["class"] in SEVERAL and file["claims"].get(G_SYMPLECTIC.key) is True:
            runs.setdefault(run["method"], []).append(run["bounded"])
    return sum(map(all, runs.values())), len(runs)


def renewed() -> tuple[int, int]:
    """Return how many runs that grew or were lost stay bounded with renewal, and of how many.

    Of ten million steps, of the methods whose growth parameters are zero.
    """
    ends_ = [
        run["verdict"] == "bounded"
        for x in measured("long-survey")["rows"]
        if x["steps"] == 10**7 and not x["method"].startswith(("gsymplectic", "milne"))
        for run in x["runs"]
        if run["renew"]
    ]
    return sum(ends_), len(ends_)


def pairs() -> tuple[int, int]:
    """Return on how many problems a pair needs less than every splitting at 1e-9, of how many."""
    others = [name for names in GROUPS.values() for name in names]
    found = []
    for case in measured("pairs")["cases"]:
        ours, theirs = best(case, PAIRS, "1e-09"), best(case, others, "1e-09")
        if ours and theirs:
            found.append(ours[1] < theirs[1])
    return sum(found), len(found)


def slower(case: str) -> tuple[str, float]:
    """Return the fastest G-symplectic method of a case at 1e-9, and its time over Gauss-4's."""
    (one,) = (x for x in measured("order6")["cases"] if x["case"] == case)
    times = {name: at["seconds"] for name, at in fastest(one, "1e-09", "").items()}
    ours = {x: t for x, t in times.items() if document(x)["class"] in SEVERAL}
    name = min(ours, key=lambda x: ours[x])
    return name, ours[name] / times["gauss-4"]


def form() -> tuple[float, int]:
    """Return the deviation of the form of g6245 after the last of the steps, and how many."""
    wanted = ("g6245", "exact form, compensated")
    rows = measured("roundoff")["rows"]
    (one,) = (x for x in rows if (x["method"], x["variant"]) == wanted)
    return one["rms"][-1], one["steps"][-1]


def stiff() -> tuple[str, float]:
    """Return how g6245 ends over the jump of Van der Pol's equation, and the error of Radau IIA."""
    rows = {x["method"]: x for x in measured("stiff-cost")["rows"] if x["h"] == 1e-6}
    return rows["g6245"]["outcome"], rows["radau-iia-3"]["state_error"]


def gsymplectic() -> str:
    """Return what G-symplectic general linear methods are good for, and what not."""
    size, steps = form()
    kept, of = lost()
    again, tried = renewed()
    fewer, cases = pairs()
    end, radau = stiff()
    lines: Sequence[tuple[str, str, str]] = (
        ("quadratic forms of all values", f"kept to {size:.1e} over {steps:,} steps", "roundoff"),
        ("few evaluations, explicit, to 100,000 steps",
         f"a pair needs fewer than ten splittings on {fewer} of {cases} problems", "pairs"),
        ("long runs with renewal", f"{again} of {tried} runs stay bounded", "long-survey"),
        ("**not**: long runs without renewal",
         f"{kept} of {of} implicit methods keep all three Kepler orbits", "kepler-long"),
        *((f"**not**: time, {name}", "`{}` takes {:.1f} times the time of `gauss-4`".format(
            *slower(case)), "order6")
          for case, name in (("henon-heiles", "Hénon-Heiles"), ("kepler-0.6", "Kepler"))),
        ("**not**: stiff problems",
         f"`g6245`: {end}; `radau-iia-3` has the error {radau:.0e}", "stiff-cost"),
    )  # fmt: skip
    rows = [row(what, said, f"`{name}.json`") for what, said, name in lines]
    return table(["use", "figure", "record"], rows)


def commands() -> str:
    """Return the command that measures each record of the page again."""
    names = (
        *("held-out-digits", "nonseparable", "roundoff", "pairs", "long-survey", "kepler-long"),
        *("order6", "stiff-cost"),
    )
    rows = []
    for name in names:
        record = measured(name)
        command = str(record.get("how", record.get("command"))).partition("; ")[0]
        command, _, commit = command.partition(", in commit ")
        where = f", in commit `{commit}`" if commit else ""
        rows.append(row(f"`{name}.json`", f"`{command}`{where}"))
    return table(["record", "command"], rows)


#: Page -> name of a table -> what writes it.
PAGES: Pages = {PAGE: {"explicit": explicit, "gsymplectic": gsymplectic, "commands": commands}}
