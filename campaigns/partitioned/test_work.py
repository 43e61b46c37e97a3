"""What methods need for an accuracy: crossings of error curves, and the labels of pairs."""

import math

import pytest

from campaigns.pages import measured
from campaigns.partitioned.tables import PAIRS
from campaigns.partitioned.work import crossing
from glmref.catalogue.lookup import document

DIP = [(10, 1e-6), (12, 1e-10), (20, 1e-7), (40, 1e-10)]


@pytest.mark.parametrize(
    ("curve", "evaluations"),
    [
        ([(10, 1e-6), (100, 1e-12)], 10**1.5),  # error = n^-6: interpolated in logarithms
        (DIP, 20 * 2 ** (2 / 3)),  # a lucky dip does not count: 1e-7 falls by 1e-3 in an octave
        ([*DIP, (80, math.nan)], None),
        ([(10, 1e-6)], None),
        ([(10, 1e-10)], 10.0),
        ([(10, math.inf), (20, 1e-10)], 20.0),
    ],
)
def test_the_evaluations_needed_are_those_of_the_last_crossing(curve, evaluations):
    assert crossing(curve, 1e-9) == (evaluations and pytest.approx(evaluations))


def test_a_pair_is_labelled_exactly_where_ten_million_steps_show_growth():
    runs = measured("pairs-long")["runs"]
    assert {x["method"] for x in runs} == set(PAIRS)
    for run in runs:
        notes = [x for x in document(run["method"]).get("notes", []) if "pairs-long.json" in x]
        assert (f"grow on {run['problem']}," in " ".join(notes)) is not run["bounded"], run
        assert run["steps"] == 10**7 or (run["outcome"] == "not finite" and not run["bounded"])
