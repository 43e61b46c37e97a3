"""What methods need for an accuracy: crossings of error curves, counts, and their tables."""

import json
import math
from pathlib import Path

import pytest

from campaigns.pages import measured
from campaigns.partitioned import work as pair_needs
from campaigns.partitioned.tables import best, needs_table, time_table
from campaigns.partitioned.work import (
    CASES,
    DENSITY,
    LEFT_OUT,
    METHODS,
    NOTE,
    PAIRS,
    TOLERANCES,
    Case,
    _settled,
    crossing,
    needs,
    per_step,
    timed,
    write,
)
from glmref.catalogue.lookup import document
from glmref.problems import names, problem

ROOT = Path(__file__).resolve().parents[2]
SHORT = Case("short", "harmonic-oscillator", 6.0, 40, timed=True)


def test_a_crossing_is_interpolated_in_logarithms():
    # error = n^-6: 1e-9 at n = 10^1.5
    curve = [(10, 1e-6), (100, 1e-12)]
    assert crossing(curve, 1e-9) == pytest.approx(10**1.5)


def test_a_lucky_dip_of_the_error_does_not_count():
    curve = [(10, 1e-6), (12, 1e-10), (20, 1e-7), (40, 1e-10)]
    found = crossing(curve, 1e-9)
    assert found is not None
    assert 20 < found < 40
    assert crossing([*curve, (80, math.nan)], 1e-9) is None
    assert crossing([(10, 1e-6)], 1e-9) is None
    assert crossing([(10, 1e-10)], 1e-9) == 10.0
    assert crossing([(10, math.inf), (20, 1e-10)], 1e-9) == 20.0


def test_a_curve_ends_an_octave_below_the_sharpest_tolerance():
    low, high = (10, 4e-10), (10, 6e-10)
    assert not _settled([]) and not _settled([low]) and not _settled([low] * (DENSITY - 1))
    assert _settled([high, *[low] * DENSITY])
    assert not _settled([high, *[low] * (DENSITY - 1)])
    assert not _settled([low, low, (10, math.nan)])
    # a run of its own stops there: the last octave is below, the point before it is not
    (need,) = needs(SHORT, ["blanes-moan-6"])
    assert max(e for _, e in need.curve[-DENSITY:]) < 5e-10 <= need.curve[-DENSITY - 1][1]
    assert need.curve[-1][0] < 10_000


def test_no_count_of_the_stored_curves_lies_behind_the_point_where_a_curve_ends():
    record = measured("pairs")
    ended = 0
    for row in (row for case in record["cases"] for row in case["methods"]):
        curve = [(n, math.nan if e is None else e) for n, e in row["curve"]]
        short = next((curve[:k] for k in range(len(curve)) if _settled(curve[:k])), curve)
        ended += len(short) < len(curve)
        for tolerance in TOLERANCES:
            assert crossing(curve, tolerance) == crossing(short, tolerance)
    assert ended > 100


def test_the_texts_say_how_dense_the_grid_is():
    assert DENSITY == 3 and "a third of an octave" in NOTE
    page = " ".join((Path(__file__).parent / "README.md").read_text(encoding="utf-8").split())
    for text in (pair_needs.__doc__ or "", page):
        assert "a third of an octave" in text and "quarter of an octave" not in text


@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", METHODS)
def test_the_evaluations_of_a_step_are_those_the_engine_counts(name):
    from glmref.engine.solve import solve

    taken = solve("kepler", name, h=0.01, steps=100, start="zero")
    # one more where the first force of a run is not the last of a step before
    assert taken.evaluations - 100 * per_step(name) in (0, 1)


def test_every_separable_problem_is_measured_or_left_out_with_a_reason():
    # a problem without a time to end is no problem to measure: only the separable ones count
    separable = {name for name in names() if problem(name).separable}
    assert separable == {case.problem for case in CASES} | set(LEFT_OUT)


def test_the_need_of_a_method_of_order_6_is_below_that_of_order_2(tmp_path):
    found = timed(SHORT, needs(SHORT, ["forest-ruth-4", "pair-rkn-6-8b"]), rounds=1)
    by_name = {(x.method, x.start): x for x in found}
    pair, four = by_name["pair-rkn-6-8b", "zero"], by_name["forest-ruth-4", ""]
    assert pair.needed[1e-9] < four.needed[1e-9]
    assert pair.start_evaluations == 0
    assert by_name["pair-rkn-6-8b", "enhanced"].start_evaluations == 7 * 8
    assert pair.seconds[1e-9] > 0
    write(tmp_path / "pairs.json", {SHORT: found})
    record = json.loads((tmp_path / "pairs.json").read_text())
    assert best(record["cases"][0], ["forest-ruth-4"], "1e-09") is not None
    assert "(rkn-6-8b)" in needs_table(record, "1e-09")
    assert "| short |" in time_table(record, "1e-09")


def test_a_pair_is_labelled_exactly_where_ten_million_steps_show_growth():
    runs = measured("pairs-long")["runs"]
    assert {x["method"] for x in runs} == set(PAIRS)
    for run in runs:
        notes = [x for x in document(run["method"]).get("notes", []) if "pairs-long.json" in x]
        notes = " ".join(notes)
        assert (f"grow on {run['problem']}," in notes) is not run["bounded"], run
        assert run["steps"] == 10**7 or (run["outcome"] == "not finite" and not run["bounded"])


@pytest.mark.slow
def test_the_file_holds_every_case_and_every_method():
    record = measured("pairs")
    assert [x["case"] for x in record["cases"]] == [case.name for case in CASES]
    for case in record["cases"]:
        assert {row["method"] for row in case["methods"]} == set(METHODS)
