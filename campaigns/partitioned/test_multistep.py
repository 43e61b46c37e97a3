"""Multistep methods: records, error constants, sentences of pages, and labels of files."""

import math
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned import error_front, held_out
from campaigns.partitioned.error_front import SYMMETRIC, angles_of, error_constant
from campaigns.partitioned.multistep_tables import (
    long_answer,
    multistep_shipped,
    winners,
    world_table,
)
from campaigns.partitioned.work import PROBLEMS, mean, needed, quadratic
from glmref.catalogue.lookup import document, load
from glmref.derive.halves import even_odd, pair_series, quotient
from glmref.derive.multistep import Half
from glmref.derive.recipes.multistep import SHIPPED
from glmref.derive.recipes.sources import survey_notes
from glmref.theory.periodicity import periodicity

ROOT = Path(__file__).resolve().parents[2]
PAGE, NOTES = ROOT / "docs" / "multivalue.md", Path(__file__).with_name("multistep.md")
FRONT = measured("error-front")


def test_the_sentences_of_the_page_are_those_of_the_records():
    page = " ".join(PAGE.read_text(encoding="utf-8").split())
    rows = [[y.strip() for y in x.strip("|").split("|")] for x in long_answer().splitlines()[2:]]
    ratios = {(x[0], x[2]): [y.split()[0] for y in x[3:]] for x in rows}
    published, splitting, *_ = ratios["quadratic", "evaluations, $10^{-9}$"]
    other = ratios["other", "evaluations, $10^{-9}$"][1]
    assert (
        f"needs {splitting} of the evaluations of the best splitting ({other} where $T$ is not "
        f"quadratic). Of those of the best published symmetric multistep method it needs {published}."
        in page
    )
    assert f"they save {100 * (1 - float(published)):.0f} %" in page
    assert max(float(ratios[x, "evaluations, $10^{-9}$"][1]) for x in ("quadratic", "other")) < 0.5
    time, other = (ratios[x, "time, $10^{-9}$"][1] for x in ("quadratic", "other"))
    assert (
        f"{time} of the best splitting where $T$ is quadratic, and {other} where it is not" in page
    )
    singles = {
        x.split("`")[1]: [float(y.split()[0]) for y in x.split("|")[2:-1]]
        for x in held_out.singles(measured("held-out")).splitlines()[2:]
    }
    best = min((x for x in singles if x in SYMMETRIC), key=lambda x: singles[x][3])
    ratio = singles["multistep-rkn-10"][3] / singles[best][3]
    assert (
        f"`multistep-rkn-10`: {ratio:.2f} of the evaluations of `{best}`, the best single" in page
    )
    assert min(singles, key=lambda x: singles[x][0]) == "multivalue-rkn-10"
    short = [
        x for x in measured("held-out")["cases"]
        if x["measure"] == "state" and quadratic(x["case"])
    ]  # fmt: skip
    wins = [sum(held_out.best(x, "new", tol)[0] == name for x in short) for name, tol in (
        ("multivalue-rkn-12", "1e-09"), ("multivalue-rkn-10", "1e-06"))]  # fmt: skip
    assert wins == [8, 9] and len(short) == 31
    assert "`multivalue-rkn-12` is the best new method on eight of 31 problems at $10^{-9}$" in page
    assert "`multivalue-rkn-10` on nine at $10^{-6}$" in page
    won = winners(measured("world"))
    assert (sum(won.values()), sum(won.get(x, 0) for x in SHIPPED)) == (16, 12)
    assert "of sixteen cases new methods for second-order systems are the fastest in twelve" in page
    first = min(float(x.split("|")[6]) for x in multistep_shipped().splitlines()[2:])
    assert 0.09 < first and "Keep $h \\omega$ below 0.09" in page


def test_the_survey_of_long_runs_is_that_of_the_page():
    verdicts = [
        (row["method"], run["verdict"])
        for row in measured("long-survey")["rows"]
        for run in row["runs"]
        if row["steps"] == 10**7 and row["method"] in SHIPPED and not run["renew"]
    ]
    assert len(verdicts) == 24 * len(SHIPPED)
    assert [x for x, verdict in verdicts if verdict != "bounded"] == ["multistep-rkn-12"]


def test_every_shipped_method_is_measured():
    assert set(SHIPPED) <= {x["method"] for x in measured("multistep-long")["runs"]}
    for entry in measured("multistep")["cases"]:
        assert set(SHIPPED) <= {x["method"] for x in entry["methods"]}


def test_every_held_out_problem_is_measured_with_methods_of_every_group():
    document = measured("held-out")
    found = {x["case"]: [m["method"] for m in x["methods"]] for x in document["cases"]}
    missing = document["not measured"]
    wanted = [x for name in PROBLEMS for x in (name, f"{name}, long") if x not in missing]
    assert list(found) == wanted
    page = NOTES.read_text(encoding="utf-8")
    assert all(f"`{x.removesuffix(', long')}`" in page for x in missing)
    for case, methods in found.items():
        groups = {k: x for k, x in held_out.GROUPS[quadratic(case)].items() if x}
        assert all(set(x) & set(methods) for x in groups.values())
        assert set(methods) <= {name for x in groups.values() for name in x}
    assert len(PROBLEMS) == 40 and sum(map(quadratic, PROBLEMS)) == 31


def test_what_counts_on_held_out_problems_is_the_best_of_each_group_in_each_case():
    def entry(case, **needed):
        rows = [{"method": k, "needed": {"1e-09": v}} for k, v in needed.items()]
        return {"case": case, "measure": "state", "methods": rows}

    first = entry("morse", **{"multistep-rkn-8": 90, "multistep-rkn-10": 80, "quinlan-8a": 100})
    second = entry("kepler 0.1", **{"multistep-rkn-8": 125, "quinlan-8b": 100, "kahan-li-8": 250})
    assert held_out.best(first, "new", "1e-09") == ("multistep-rkn-10", 80)
    lines = held_out.summary({"cases": [first, second]}).splitlines()
    assert (
        "| quadratic | short | evaluations, $10^{-9}$ | 1.00 (1 of 2) | 0.50 (1 of 1) | - | - |"
        in lines
    )


def test_files_say_where_they_grow():
    grown = {x["method"] for x in measured("multistep-long")["runs"] if not x["bounded"]}
    for name, shipped in SHIPPED.items():
        (said,) = shipped.notes
        assert ("grow on" if name in grown else "stays bounded") in said
        assert document(name)["notes"] == [*shipped.notes, *survey_notes(name)]


def test_the_best_of_some_is_found():
    entry = {"methods": [{"method": "a", "needed": {"1e-09": 7}}, {"method": "b", "needed": {}}]}
    assert needed(entry, ["a", "b"], "1e-09") == ("a", 7)


def test_the_fastest_of_a_case_stands_out_and_what_was_not_reached_is_named():
    rows = [
        {"method": "heyoka", "evaluations": None, "seconds": 2e-3},
        {"method": "multistep-8", "evaluations": 1200, "seconds": 1e-3},
        {"method": "cvode-adams", "evaluations": None, "seconds": None},
    ]
    document = {"cases": [{"case": "toy", "methods": rows}]}
    assert winners(document) == {"multistep-8": 1}
    line = world_table(document).splitlines()[-1]
    assert "**1** (1,200)" in line and "| 2 |" in line and "not reached" in line


# Error constants: against their series, their bound, the record.
def test_the_coefficients_are_those_of_cowell():
    # Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), III.10
    assert error_front.cowell(4) == (1, Fraction(1, 12), Fraction(-1, 240), Fraction(31, 60480))


@pytest.mark.parametrize("name", ["multistep-rkn-8", "multistep-rkn-10", "multistep-rkn-12"])
def test_the_error_constant_is_what_the_weights_leave(name):
    cosines = SHIPPED[name].p
    half, m = Half(tuple(cosines), second=True), len(cosines)
    # the drift of the formula and of the solution, both in forces exp(x t), times x
    x = 0.05
    drift = 1 / (2 * math.sinh(x / 2))
    for alpha, c in zip(half.stage[1::2], cosines, strict=True):
        drift += float(alpha) * 2 * math.sinh(x / 2) / (2 * math.cosh(x) - 2 * float(c))
    exact = 2 * math.sinh(x / 2) / x**2
    left = (exact / drift - 1) / x ** (2 * m + 2)
    assert m > 3 or left == pytest.approx(error_constant(angles_of(name)), rel=0.02)
    # exactly, from the series
    n = 2 * m + 4
    target, one = even_odd(Fraction(1, 2), n + 1, 1)[1:], [Fraction(1), *[Fraction(0)] * (n - 1)]
    series = quotient(one, target)[2 * m + 2] + sum(
        a * quotient(even_odd(Fraction(1, 2), n, 1), pair_series(c, n))[2 * m + 1]
        for a, c in zip(half.stage[1::2], cosines, strict=True)
    )
    constant = target[2 * m + 2] - series
    assert float(constant) == pytest.approx(error_constant(angles_of(name)), rel=1e-9)


def test_the_slopes_are_the_constants_of_the_other_roots_and_the_bound_is_below():
    angles = np.array([1.2, 1.9, 2.7])
    first = 1 / (2 - 2 * math.cos(1.2))
    moved = np.array([math.acos(1 - 1 / (2 * (first + 1e-3))), 1.9, 2.7])
    slope = (error_constant(moved) - error_constant(angles)) / 1e-3
    assert slope == pytest.approx(error_constant(angles[1:]), rel=1e-6)
    assert [error_front.least(m) for m in range(3)] == [
        Fraction(1, 12),
        Fraction(1, 60),
        Fraction(11, 3024),
    ]
    assert all(error_front.least(m) > 0 for m in range(8))
    near = np.array([3.1, 3.12, 3.13])
    assert float(error_front.least(3)) < error_constant(near) < error_constant(angles)
    assert error_constant(near) == pytest.approx(float(error_front.least(3)), rel=2e-3)


@pytest.mark.parametrize("name", ["multistep-rkn-8", "multistep-rkn-10", "quinlan-8b"])
def test_the_interval_is_the_proved_one(name):
    assert error_front.end(angles_of(name)) == pytest.approx(
        periodicity(load(name)).value, abs=0.006
    )


def gap(angles: np.ndarray) -> float:
    """Return the least distance of two roots on the circle, in degrees."""
    ordered = np.sort(np.degrees(angles))
    return float(min([*np.diff(ordered), 2 * (180 - ordered[-1])]))


def test_the_record_of_the_front_is_of_these_methods_and_tasks():
    assert FRONT["least"] == {str(2 * m + 2): str(error_front.least(m)) for m in error_front.PAIRS}
    for x in FRONT["methods"]:
        angles = angles_of(x["method"])
        assert x["constant"] == pytest.approx(error_constant(angles), rel=1e-3)
        assert x["end"] == pytest.approx(error_front.end(angles)) and x["apart"] == round(
            gap(angles), 1
        )
    for x in FRONT["descents"]:
        if x["constant"] is not None:
            angles = np.radians(x["angles"])
            assert x["constant"] == pytest.approx(error_constant(angles), rel=3e-3)
            assert gap(angles) >= x["apart"] - 0.02


def test_the_table_of_the_front_shows_the_share():
    (line,) = (x for x in error_front.table(FRONT).splitlines() if "`quinlan-8b`" in x)
    assert f"| {error_front.share(error_constant(angles_of('quinlan-8b')), 3):.2f} |" in line
    assert "1.21" in line


def test_what_zeros_in_the_band_gain_is_that_of_the_record():
    text = " ".join(NOTES.read_text(encoding="utf-8").split())
    record, entries = measured("off-origin-zeros"), measured("held-out")["cases"]
    known = {x["case"]: x for x in entries}
    shipped = [x["method"] for x in record["methods"] if x["method"].startswith("z")]

    def share(long: bool, tolerance: str, names: Sequence[str]) -> str:
        ratios = []
        for x in record["cases"]:
            published = held_out.best(known[x["case"]], "published multistep", tolerance)[1]
            if x["case"].endswith("long") == long and math.isfinite(published):
                counts = [x["needed"][name][tolerance] for name in names]
                best = held_out.best(known[x["case"]], "new", tolerance)[1]
                ratios.append(min([best, *(n for n in counts if n)]) / published)
        assert len(ratios) == 21
        return f"{mean(ratios):.2f}"

    every = [x["method"] for x in record["methods"]]
    for long, words in ((True, "long"), (False, "short")):
        few, more, all_ = (
            [share(long, t, names) for t in ("1e-09", "1e-06")] for names in ((), shipped, every)
        )
        assert f"from {few[0]} and {few[1]} to {more[0]} and {more[1]} ({words})" in text
        assert " and ".join(all_) in text

    def extremes(names: Sequence[str], cases: Sequence[str]) -> list[str]:
        found = [
            n / held_out.best(known[x["case"]], "published multistep", "1e-09")[1]
            for x in record["cases"] if x["case"] in cases
            for name in names if (n := x["needed"][name]["1e-09"])
        ]  # fmt: skip
        return [f"{edge(found):.2f}" for edge in (min, max)]

    centres = [x for name in ("cluster 16", "logarithmic", "miyamoto-nagai")
               for x in (name, f"{name}, long")]  # fmt: skip
    orbits = [x for x in known if x.startswith("kepler") and x.endswith("long")]
    assert "`r3`, without zeros, needs {} to {} of".format(*extremes(["r3"], centres)) in text
    searched = [x for x in every if x not in shipped]
    assert "all need {} to {} on long".format(*extremes(searched, orbits)) in text
