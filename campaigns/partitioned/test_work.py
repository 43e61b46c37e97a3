"""What methods need for an accuracy: crossings of error curves, counts, and their record."""

import math
from pathlib import Path

import pytest

from campaigns.pages import measured
from campaigns.partitioned import work
from campaigns.partitioned import work as pair_needs
from campaigns.partitioned.tables import PAIRS
from glmref.catalogue.lookup import document

RECORD = measured("pairs")
METHODS = list(dict.fromkeys(x["method"] for x in RECORD["cases"][0]["methods"]))


def test_a_crossing_is_interpolated_in_logarithms():
    # error = n^-6: 1e-9 at n = 10^1.5
    curve = [(10, 1e-6), (100, 1e-12)]
    assert work.crossing(curve, 1e-9) == pytest.approx(10**1.5)


def test_a_lucky_dip_of_the_error_does_not_count():
    curve = [(10, 1e-6), (12, 1e-10), (20, 1e-7), (40, 1e-10)]
    found = work.crossing(curve, 1e-9)
    assert found is not None
    assert 20 < found < 40
    assert work.crossing([*curve, (80, math.nan)], 1e-9) is None
    assert work.crossing([(10, 1e-6)], 1e-9) is None
    assert work.crossing([(10, 1e-10)], 1e-9) == 10.0
    assert work.crossing([(10, math.inf), (20, 1e-10)], 1e-9) == 20.0


def test_a_curve_ends_an_octave_below_the_sharpest_tolerance():
    low, high = (10, 4e-10), (10, 6e-10)
    few = [low] * (work.DENSITY - 1)
    for curve in ([], [low], few, [high, *few], [low, low, (10, math.nan)]):
        assert not work._settled(curve, 1e-9)
    assert work._settled([high, low, *few], 1e-9)


def test_no_count_of_the_stored_curves_lies_behind_the_point_where_a_curve_ends():
    ended = 0
    for row in (row for case in RECORD["cases"] for row in case["methods"]):
        curve = [(n, math.nan if e is None else e) for n, e in row["curve"]]
        short = next(
            (curve[:k] for k in range(len(curve)) if work._settled(curve[:k], 1e-9)), curve
        )
        ended += len(short) < len(curve)
        for tolerance in work.TOLERANCES:
            assert work.crossing(curve, tolerance) == work.crossing(short, tolerance)
    assert ended > 100


def test_the_texts_say_how_dense_the_grid_is():
    assert work.DENSITY == 3
    page = " ".join((Path(__file__).parent / "README.md").read_text(encoding="utf-8").split())
    for text in (pair_needs.__doc__ or "", page):
        assert "a third of an octave" in text and "quarter of an octave" not in text


@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", METHODS)
def test_the_evaluations_of_a_step_are_those_the_engine_counts(name):
    from glmref.engine.solve import solve

    taken = solve("kepler", name, h=0.01, steps=100, start="zero")
    # one more where the first force of a run is not the last of a step before
    assert taken.evaluations - 100 * work.per_step(name) in (0, 1)


def test_a_pair_is_labelled_exactly_where_ten_million_steps_show_growth():
    runs = measured("pairs-long")["runs"]
    assert {x["method"] for x in runs} == set(PAIRS)
    for run in runs:
        notes = [x for x in document(run["method"]).get("notes", []) if "pairs-long.json" in x]
        notes = " ".join(notes)
        assert (f"grow on {run['problem']}," in notes) is not run["bounded"], run
        assert run["steps"] == 10**7 or (run["outcome"] == "not finite" and not run["bounded"])


@pytest.mark.parametrize(
    ("name", "t_end", "least", "measure", "within"),
    # the largest error of the energy on a chaotic orbit changes with the last bits
    [
        ("henon-heiles", 50.0, 150, "state", 0),
        ("henon-heiles-long", 5000.0, 10000, "energy", 0.02),
    ],
)
def test_counts_are_those_of_the_record(name, t_end, least, measure, within) -> None:
    (case,) = (x for x in RECORD["cases"] if x["case"] == name)
    assert (case["time"], case["measure"]) == (t_end, measure)
    stored = {x["method"]: x["needed"] for x in case["methods"] if x["start"] != "enhanced"}
    four, pair = work.needs(
        work.Case(name, "henon-heiles", t_end, least, measure=measure),
        ["forest-ruth-4", "pair-rkn-6-8b"],
    )
    for x in (four, pair):
        assert x["needed"] == pytest.approx(stored[x["method"]], rel=within)
        assert x["start_evaluations"] == 0
    assert four["needed"]["1e-06"] > pair["needed"]["1e-06"]
