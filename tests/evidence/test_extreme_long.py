"""A hundred million steps of the pendulum: what was measured is in the data, and begins the same.

The whole takes minutes; here its first part is run again and must agree with the record.
"""

import json

import pytest

from glmref.catalogue import data_root
from glmref.experiments.long_pendulum import long_run

FILE = data_root() / "measurements" / "pendulum-1e8.json"
RUNS = {(r["method"], r["h"]): r for r in json.loads(FILE.read_text("utf-8"))["runs"]}


def test_the_order_6_method_keeps_the_energy_over_1e8_steps():
    run = RUNS["g6245", 0.05]
    assert run["outcome"] == "completed" and run["steps"] == 10**8
    assert run["law"]["kind"] == "bounded"
    # exponent 0 but for the scatter of an rms over 1000 samples: one part in 30 over five doublings
    assert abs(run["law"]["exponent"]) < 0.02
    # of order six: a few times (h omega)^6 = 1.6e-8 times the error constant
    assert run["law"]["largest"] < 1e-11


def test_memory_is_flat_and_time_is_minutes():
    for run in RUNS.values():
        memory = run["peak_memory_mb"]
        # two more stretches of 1000 samples for each doubling: less than 0.1 MB each
        assert memory["at the end"] - memory["after 1 per cent"] < 5
        assert run["samples"] < 20_000
        assert run["seconds"]["process"] < 300


def test_twice_the_step_is_too_large_for_so_long():
    """The near miss, and a finding: at h = 0.1 the same method is lost after 10^7 steps and more."""
    run = RUNS["g6245", 0.1]
    assert run["law"]["kind"] == "blow-up" and run["law"]["time"] > 1e6
    # the energy was bounded for a million steps and more before
    early = [row for row in run["doublings"] if 1e3 < row["t"] < 1e5]
    assert max(row["rms"] for row in early) / min(row["rms"] for row in early) < 1.1


def test_a_symplectic_method_is_bounded_and_rk4_drifts():
    assert RUNS["gauss-3", 0.1]["law"]["kind"] == "bounded"
    rows = RUNS["rk4", 0.1]["doublings"]
    early = [row for row in rows if row["t"] < 1e5][-3:]
    # linear: twice the time, twice the error
    assert early[-1]["rms"] / early[-2]["rms"] == pytest.approx(2, abs=0.05)


@pytest.mark.parametrize(("name", "h"), [("g6245", 0.05), ("gauss-3", 0.1), ("rk4", 0.1)])
def test_the_first_steps_are_those_of_the_record(name, h):
    again = long_run(name, steps=100_000, h=h)
    assert again["outcome"] == "completed"
    stored = [row for row in RUNS[name, h]["doublings"] if row["t"] <= 100_000 * h]
    reached = again["doublings"][-1]
    near = min(stored, key=lambda row: abs(row["t"] - reached["t"]))
    # the same motion, sampled at other times: rms over a thousand samples scatter by a few per cent
    factor = near["t"] / reached["t"] if name == "rk4" else 1.0
    assert reached["rms"] == pytest.approx(near["rms"] / factor, rel=0.1)
