"""Long runs: Brouwer's law over ten million steps, bounded energy, and where boundedness ends."""

import json
from pathlib import Path

import numpy as np
import pytest

from campaigns.roundoff import METHODS, SIZE, VARIANTS, bodies, options_of, round_off
from glmref.catalogue.lookup import data_root, load
from glmref.measure.longtime import follow, watch
from glmref.measure.parasitic import parasitic_size, solution_direction
from glmref.problems import problem
from tests.build import floats

RECORD = json.loads((data_root() / "measurements" / "roundoff.json").read_text(encoding="utf-8"))
ROWS = {(row["method"], row["variant"]): row for row in RECORD["rows"]}
EXACT, PLAIN, ROUNDED, NAIVE = VARIANTS


@pytest.mark.parametrize("name", METHODS)
def test_round_off_is_a_random_walk_in_the_exact_form_and_a_drift_in_a_rounded_tableau(name):
    """1/2 is a random walk, 1 a drift; compensation without exact coefficients is not enough."""
    exact, rounded = ROWS[name, EXACT], ROWS[name, ROUNDED]
    assert exact["exponent"] <= 0.6
    assert exact["rms"][-1] < 1e-14
    assert abs(exact["mean"]) < exact["rms"][-1]
    assert rounded["exponent"] > 0.85
    assert rounded["rms"][-1] > 8 * exact["rms"][-1]
    # plain sums walk as well, but with the steps of a value in place of those of its increment
    assert ROWS[name, PLAIN]["rms"][-1] > 10 * exact["rms"][-1]
    assert ROWS[name, NAIVE]["rms"][-1] > 10 * exact["rms"][-1]


@pytest.mark.parametrize("name", METHODS)
def test_the_page_shows_the_record(name):
    page = (Path(__file__).parents[2] / "docs" / "experiments.md").read_text(encoding="utf-8")
    cells = []
    for variant in VARIANTS:
        row = ROWS[name, variant]
        bold = "**" if variant == EXACT else ""
        cells.append(f"{row['rms'][-1]:.1e}, {bold}{row['exponent']:.2f}{bold}")
    assert f"| `{name}` | {' | '.join(cells)} |" in page


@pytest.mark.slow
@pytest.mark.sampled(1, whole=2)
@pytest.mark.parametrize("name", METHODS)
def test_a_shorter_run_shows_what_the_record_says(name):
    """A million steps. The exponent comes from seven stretches of sixteen walks: the logarithm of
    an rms of 16 squares is known to 1/sqrt(32) = 0.18, their slope over a factor of 64 to about
    0.18 sqrt(2)/log(64) = 0.06; three times that is allowed here, the record has a longer lever."""
    exact, rounded = (
        round_off(load(name), bodies(8), h=SIZE, steps=1_000_000, **options_of(load(name), one))
        for one in (EXACT, ROUNDED)
    )
    assert exact.exponent <= 0.5 + 0.18, exact
    assert exact.rms[-1] < 5e-15
    assert rounded.exponent > exact.exponent
    assert rounded.rms[-1] > 2 * exact.rms[-1], (exact, rounded)


@pytest.mark.parametrize(
    ("name", "bound"), [("gauss-2", 5e-6), ("s4-symmetric", 5e-6), ("g6245", 1e-8)]
)
def test_the_energy_error_of_a_good_method_is_bounded(name, bound):
    subject = problem("pendulum")
    found = follow(subject, load(name), h=0.1, steps=50_000)
    (energy,) = watch(subject, found)
    assert energy.largest < bound
    assert abs(energy.exponent) < 0.1


@pytest.mark.parametrize("name", ["gsymplectic-n", "s4-symmetric", "g6245"])
def test_the_form_is_kept_to_round_off_and_the_invariants_of_the_solution_only_stay_near(name):
    steps = 100_000
    method, subject = load(name), problem("rigid-body")
    G = floats(method.G)
    found = follow(subject, method, h=0.1, steps=steps)
    drifts = watch(subject, found, G=G)
    forms = [one for one in drifts if one.kind == "form"]
    own = [one for one in drifts if one.kind == "quadratic"]
    assert len(forms) == len(own) == 2
    for one in forms:  # a random walk with steps of half a unit of the last place
        assert one.largest < 2.0**-53 * steps**0.5, one
    for one in own:  # an error of the method, visible and bounded
        assert 1e-13 < one.largest < 1e-7, one
        assert abs(one.exponent) < 0.1, one


def test_a_method_without_a_form_lets_both_invariants_drift():
    subject = problem("rigid-body")
    found = follow(subject, load("rk4"), h=0.1, steps=100_000)
    drifts = watch(subject, found)
    assert all(one.exponent == pytest.approx(1.0, abs=0.1) for one in drifts)
    assert all(one.largest > 1e-6 for one in drifts)


def test_the_energy_error_of_a_method_that_is_not_symplectic_drifts():
    subject = problem("pendulum")
    found = follow(subject, load("rk4"), h=0.05, steps=50_000)
    (energy,) = watch(subject, found)
    assert energy.exponent == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_parasitism_free_to_first_order_is_not_forever():
    """mu = 0 stops growth of first order in h; what is left needs millions of steps to show.

    The rigid body with moments (23/8, 1, 2/3), h = 1/8: the values beyond the solution of G6245
    stay where they are for four million steps, then grow exponentially; at half the step, ten
    million steps show nothing. The symmetric method of order 4 stays bounded at both.
    """
    subject = problem("rigid-body", inertia1="23/8")

    def largest(name, h, begin, end):
        method = load(name)
        found = follow(subject, method, h=h, steps=end)
        size = parasitic_size(found, solution_direction(method))
        count = found.t / h
        return float(np.max(size[(count >= begin) & (count <= end)]))

    early, late = largest("g6245", 1 / 8, 1_000, 2_000_000), largest("g6245", 1 / 8, 1, 10_000_000)
    assert early < 1e-5
    assert late > 100 * early
    assert largest("g6245", 1 / 16, 1, 10_000_000) < 1e-5
    assert largest("s4-symmetric", 1 / 8, 1, 10_000_000) < 1e-3
