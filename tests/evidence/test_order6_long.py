"""A million steps with the methods of order 6 and 8 that ten million steps leave bounded.

``data/measurements/long-runs.json`` holds the ten million; here the same code runs a tenth of it
for the methods recommended in docs/order6.md, and one that is known to grow at second order in h.
"""

from __future__ import annotations

import json

import pytest

from glmref.catalogue import data_root
from glmref.experiments.long_order6 import RUNS, growth_rate, long_run

RECORD = json.loads((data_root() / "measurements" / "long-runs.json").read_text(encoding="utf-8"))[
    "runs"
]
RECOMMENDED = ("order8-s5-w3", "s5t-w3", "s5i2-w3")


def recorded(name: str, run: str) -> dict:
    return next(r for r in RECORD if r["method"] == name and r["run"] == run)


@pytest.mark.slow
@pytest.mark.parametrize("run", RUNS)
@pytest.mark.parametrize("name", RECOMMENDED)
def test_a_recommended_method_is_bounded(name: str, run: str) -> None:
    assert recorded(name, run)["bounded"]
    found = long_run(name, run, steps=1_000_000)
    assert found.bounded, found
    # the record is that of a longer run on the same path: its largest error is no smaller, but
    # for the samples at which it was looked for
    assert found.energy < 2 * recorded(name, run)["energy"]


@pytest.mark.slow
def test_growth_at_second_order_is_seen_and_goes_with_the_square_of_h() -> None:
    """G6245 with z = exp(2 pi i/3) on the pendulum: exp(c h^2 t) with c near 1e-3.

    Halving h divides the rate by four; runs of 2e5 and 4e5 steps give each rate to some twenty per
    cent, because the second half of a run holds two or three factors of e of growth.
    """
    coarse = growth_rate("g6245-w3", "pendulum-2.3", h=0.2, steps=400_000)
    fine = growth_rate("g6245-w3", "pendulum-2.3", h=0.1, steps=2_000_000)
    assert coarse > 2e-5
    assert 2.5 < coarse / fine < 6.0
