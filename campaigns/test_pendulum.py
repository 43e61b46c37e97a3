"""A hundred million steps of the pendulum: the record is held to the exact motion, to its end.

The runs take minutes, and the study is closed. The states that were kept lie on the exact solution,
an elliptic function, but for a phase that drifts evenly, to the last of the 10^8 steps; and the
laws follow from the samples.
"""

import math

import numpy as np
import pytest
from scipy.special import ellipk, ellipkinc

from campaigns.pages import measured
from glmref.measure.law import KINDS

RUNS = {(r["method"], r["h"]): r for r in measured("pendulum-1e8")["runs"]}


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


def energy_error(checkpoint):
    q, p = checkpoint["values"][0]
    return abs((p * p / 2 - math.cos(q)) / -math.cos(2.3) - 1)


def phase_drift(checkpoint, h):
    """Return (phase - t)/t: with k = sin(q_0/2), sin(q/2) = k sn(t + K), p = 2 k cn(t + K)."""
    (q, p), t, m = checkpoint["values"][0], checkpoint["steps"] * h, math.sin(1.15) ** 2
    quarter = ellipk(m)
    late = ellipkinc(math.atan2(math.sin(q / 2), p / 2), m) - quarter - t
    return ((late + 2 * quarter) % (4 * quarter) - 2 * quarter) / t


@pytest.mark.parametrize(("name", "h"), [("g6245", 0.05), ("gauss-3", 0.1)])
def test_every_checkpoint_lies_on_the_exact_orbit_and_its_phase_drifts_evenly(name, h):
    """A method without drift of the energy has a frequency of its own, and keeps it.

    Rounding walks: an increment errs by 2^-53 h |p| < 1e-17, the energy by 1e-17 * 10^4 = 1e-13
    after 10^8 steps in the worst case of one direction, typically a tenth of it; so the drift of
    the phase, 7e-13 and 2e-11 of the time, is known to a few per cent.
    """
    run = RUNS[name, h]
    states = run["checkpoints"]
    assert [c["steps"] for c in states] == [1000 * 4**k for k in range(9)] + [10**8]
    assert max(map(energy_error, states)) <= run["law"]["largest"] * (1 + 1e-6)
    drifts = [phase_drift(c, h) for c in states if c["steps"] >= 16_000]
    assert max(drifts) < 0 and min(drifts) > -2e-11
    assert min(drifts) == pytest.approx(max(drifts), rel=0.05)


def test_a_state_one_step_off_or_of_a_lost_run_is_not_on_the_orbit():
    last = RUNS["g6245", 0.05]["checkpoints"][-1]
    good = phase_drift(last, 0.05)
    off = phase_drift({**last, "steps": last["steps"] - 1}, 0.05)
    assert abs(off) > 1000 * abs(good)
    lost = RUNS["g6245", 0.1]["checkpoints"]
    assert energy_error(lost[-1]) > 0.1
    assert abs(phase_drift(lost[-1], 0.1)) > 1000 * abs(phase_drift(lost[3], 0.1))


def slope(rows):
    """Return the exponent of the root mean square over the last five doublings of time."""
    t, rms = np.log([[row["t"], row["rms"]] for row in rows[-5:]]).T
    return float(np.polyfit(t, rms, 1)[0])


def kind_of(exponent):
    return next((kind for kind, most in KINDS.items() if exponent < most), "blow-up")


def test_the_laws_follow_from_the_samples():
    for (name, h), run in RUNS.items():
        law, rows = run["law"], run["doublings"]
        if law["exponent"] is None:  # what passed the size of the energy itself is lost at once
            assert law["kind"] == "blow-up" and max(row["largest"] for row in rows) >= 1, name
            continue
        # the same five stretches, the same samples: rounding of the logarithms only
        assert slope(rows) == pytest.approx(law["exponent"], abs=1e-9), (name, h)
        assert kind_of(slope(rows)) == law["kind"], (name, h)
    # the near miss: the same samples with a random walk on top
    rows = RUNS["g6245", 0.05]["doublings"]
    walk = [{**row, "rms": row["rms"] * (1 + row["t"] / 1e6) ** 0.5} for row in rows]
    assert kind_of(slope(walk)) == "random walk"
