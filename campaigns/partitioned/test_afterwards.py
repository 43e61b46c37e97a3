"""Systems written down after the last method was chosen: the page says what the record has."""

import math
from pathlib import Path

import pytest

from campaigns.pages import measured
from campaigns.partitioned.afterwards import METHODS, rival, row, system
from campaigns.partitioned.semi_separable import needed
from glmref.catalogue.lookup import load

ROWS = measured("nonseparable")["afterwards"]
PAGE = " ".join((Path(__file__).parents[2] / "docs" / "nonseparable.md").read_text("utf-8").split())


def test_the_page_says_what_they_need_and_what_is_lost() -> None:
    means = []
    for name in METHODS:
        logs = []
        for x in ROWS:
            counts = x["evaluations"]["1e-09"]
            gauss = min(n for key, n in counts.items() if key.startswith("gauss") and n)
            logs.append(math.log(counts[name] / gauss))
        means.append(f"{math.exp(sum(logs) / len(logs)):.2f}")
    assert len(ROWS) == 11
    assert f"it is {means[0]}, {means[1]} and {means[2]}, and no renewed run" in PAGE
    runs = [x for row_ in ROWS for x in row_["long"]]
    assert len(runs) == 2 * 3 * 11
    assert all(x["energy"] and x["energy"] < 1e-3 for x in runs if x["renew"])
    lost = [x for x in runs if not (x["energy"] and x["energy"] < 1e-3)]
    assert lost
    assert all(x["reported"] is not None for x in lost)


def test_what_is_stored_is_what_is_measured() -> None:
    (x,) = (x for x in ROWS if x["problem"] == "quartic-mix")
    one, counts = system(x), x["evaluations"]["1e-06"]
    assert (needed(load(METHODS[1]), one, 1e-6, steps=20) or (0, 0))[1] == counts[METHODS[1]]
    assert abs((rival(one)[1e-6] or 0) / counts["scipy-dop853"] - 1) < 0.05  # of another version


@pytest.mark.slow
def test_a_row_is_measured_anew() -> None:
    (x,) = (x for x in ROWS if x["problem"] == "mass-2d")
    assert row({key: x[key] for key in ("problem", "H", "coordinates", "momenta", "y0")}) == x
