"""Parasitic modes, propagators and losses on cases that can be done by hand."""

import math

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.errors import UsageError
from glmref.measure.longtime import follow
from glmref.measure.parasitic import LOST, loss, modes, parasitic_size, solution_direction
from glmref.problems import Problem, problem


def test_n_has_one_mode_with_the_growth_parameter_of_its_file():
    (mode,) = modes(load("gsymplectic-n"))
    assert mode.zeta == pytest.approx(-1)
    assert mode.mu == pytest.approx(1 - 2 / math.sqrt(3), abs=1e-14)
    assert mode.left @ mode.right == pytest.approx(1)


def test_modes_come_by_increasing_argument():
    arguments = [np.angle(mode.zeta) % (2 * math.pi) for mode in modes(load("g6245"))]
    assert arguments == pytest.approx([math.pi / 2, math.pi, 3 * math.pi / 2])


def test_a_one_step_method_and_an_adams_method_have_none():
    assert modes(load("rk4")) == []
    assert modes(load("ab-3")) == []


def test_the_solution_is_the_first_value_or_repeated_in_past_values():
    assert solution_direction(load("g6245")).tolist() == [1, 0, 0, 0]
    assert solution_direction(load("leapfrog")).tolist() == [1, 1]
    assert solution_direction(load("stormer-verlet")).tolist() == [1]


def run(name, steps, **options):
    subject = problem("pendulum", q0="23/10")
    method = load(name)
    found = follow(subject, method, h=0.1, steps=steps, engine="interpreted", **options)
    return subject, method, found, solution_direction(method)


def test_a_run_of_p_is_lost_to_its_parasitic_part():
    subject, _, found, u = run("gsymplectic-p", 200)
    told = loss(subject, found, u)
    assert told.reason == "parasitic"
    assert 13 < told.time < 15
    assert told.largest > LOST


def test_a_good_run_is_not_lost():
    subject, _, found, u = run("g6245", 200)
    told = loss(subject, found, u)
    assert (told.time, told.reason) == (None, "")
    assert told.largest < 1e-4


def test_an_energy_error_of_the_size_of_the_energy_is_a_loss():
    subject = problem("harmonic-oscillator")
    found = follow(subject, load("euler"), h=0.5, steps=100, engine="interpreted")
    told = loss(subject, found, solution_direction(load("euler")))
    assert told.reason == "energy"


def test_a_run_that_ends_early_is_lost_for_the_reason_it_gives():
    explode = Problem(f=("y[0]*y[0]",), y0=(1,))
    found = follow(explode, load("rk4"), h=0.5, steps=100, engine="reference")
    told = loss(explode, found, np.ones(1))
    assert told.reason == "not finite"


def test_the_parasitic_size_needs_all_values():
    from glmref.engine.solve import solve

    found = solve(problem("pendulum"), "rk4", h=0.1, steps=2, engine="reference")
    with pytest.raises(UsageError, match="history=True"):
        parasitic_size(found, np.ones(1))
