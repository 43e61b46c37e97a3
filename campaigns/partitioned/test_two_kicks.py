"""The search for methods with two kicks: its numbers are those of the files."""

import numpy as np
import pytest

from campaigns.partitioned.error_front import angles_of, end
from campaigns.partitioned.two_kicks_search import (
    CASES,
    Unknowns,
    allowed,
    begun,
    counts,
    interval,
    objective,
    rational,
    unknowns,
    weights,
)
from glmref.catalogue.reader import load_document
from glmref.derive.multistep import TwoKicks, two_kick_document
from glmref.derive.recipes.multistep import SHIPPED
from glmref.engine.solve import solve
from glmref.problems import problem

DOUBLED = begun("multistep-rkn-8")
#: Not two steps of a method with one kick.
GIVEN = Unknowns(DOUBLED.angles + 0.05, DOUBLED.phases + np.array([0.1, -0.05, 0.2]), 0.53)
PENDULUM = CASES[4]


@pytest.mark.slow
def test_the_search_steps_the_method_of_the_file():
    found = rational(GIVEN, 512)
    made = weights(unknowns(found))
    method = load_document(two_kick_document("found", found))
    steps = 400
    h = PENDULUM.t_end / steps
    run = solve(problem("pendulum", q0="5/2"), method, h=h, steps=steps, every=8)
    _, error, end = made.run(PENDULUM, h, steps, 8)
    assert end[0] == pytest.approx(run.y[-1][0], abs=1e-8)  # two starts of order 8
    energies = np.array([y[1] ** 2 / 2 - np.cos(y[0]) for y in run.y])
    assert error == pytest.approx(np.abs(energies / energies[0] - 1).max(), rel=1e-2)


def test_unknowns_and_rational_numbers_are_inverse():
    again = unknowns(rational(GIVEN, 2**40))
    for name in ("angles", "phases", "weight"):
        assert getattr(again, name) == pytest.approx(getattr(GIVEN, name), abs=1e-9)


@pytest.mark.slow
def test_two_steps_with_one_kick_have_its_interval_and_counts():
    assert interval(DOUBLED, 100) == pytest.approx(end(angles_of("multistep-rkn-8")), abs=0.01)
    (found,) = counts(weights(DOUBLED), [PENDULUM])
    # data/measurements/multistep.json has 680, on another grid of step sizes
    assert found[1][1] == pytest.approx(680, rel=0.05)


@pytest.mark.parametrize(
    ("name", "angles", "phases", "weight"),
    [
        (
            "multivalue-rkn-10",
            [55.6317, 117.1712, 123.0225, 167.966],
            [76.2585, 60.4838, -40.8165, -44.1281],
            0.50663,
        ),
        (
            "multivalue-rkn-12",
            [51.7714, 106.12, 133.0389, 138.1359, 156.1802],
            [77.558, -27.5259, -33.0816, 55.3666, -36.9587],
            0.48946,
        ),
    ],
)
def test_the_shipped_methods_are_what_the_descents_ended_with(name, angles, phases, weight):
    shipped = SHIPPED[name]
    found = rational(Unknowns(np.radians(angles), np.radians(phases), weight))
    rounded = [*found.cosines, *found.slopes, found.weight]
    assert rounded == [*shipped.p, *shipped.slopes, shipped.weight]


@pytest.mark.slow
def test_at_low_accuracy_the_method_of_order_10_beats_two_steps_with_one_kick():
    numbers = SHIPPED["multivalue-rkn-10"]
    shipped = unknowns(TwoKicks(numbers.p, numbers.slopes, numbers.weight))
    others = [objective(begun(f"multistep-rkn-{order}"), goal="low") for order in (8, 10, 12)]
    assert objective(shipped, goal="low") < min(others) - 0.03


def test_roots_that_meet_are_refused():
    assert allowed(DOUBLED)
    assert not allowed(Unknowns(DOUBLED.angles * 0.1, DOUBLED.phases, 0.5))
