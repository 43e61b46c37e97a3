"""A small attack on ``solve`` with a fixed seed, and proof that the attack sees what it looks for."""

import numpy as np
import pytest

from glmref import solve

from . import solves
from .__main__ import main

QUICK = 60


@pytest.mark.slow
def test_random_solves_end_in_a_name():
    tally = solves.attack(QUICK, 20)
    assert not tally.violations, tally.text()
    assert sum(tally.outcomes.values()) == QUICK
    assert tally.outcomes["completed"] > 5 and tally.outcomes["refused"] > 5


@pytest.mark.slow
def test_cases_follow_from_the_seed():
    first, again, other = ([str(x) for x in solves.cases(20, seed)] for seed in (1, 1, 2))
    assert first == again != other


CASE = solves.Case("function", "in place", (1.0, 0.0), 0.0, "rk4", {"h": 0.1, "steps": 60})


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"y": np.array([[np.nan, 0.0]])}, "`y` is not finite"),
        ({"values": np.array([[np.inf, 0.0]])}, "`values` is not finite"),
        ({"t": np.array([5.9])}, "completed at t = "),
        ({"steps": 59}, "completed after 59 of 60 steps"),
        ({"message": "two\nlines"}, "message"),
        ({"values": np.array([[0.5, 0.5]])}, "another result"),
    ],
)
def test_a_wrong_solution_is_a_violation(monkeypatch, change, says):
    from dataclasses import replace

    def broken(problem, *given, **options):
        found = solve(problem, *given, **options)
        return replace(found, **change) if problem.name == "in place" else found

    arguments = {**CASE.arguments, "engine": "interpreted"}
    case = solves.Case(CASE.kind, CASE.what, CASE.state, CASE.t0, CASE.method, arguments)
    assert solves.violations(case) == ("completed", [])
    monkeypatch.setattr(solves, "solve", broken)
    _, wrong = solves.violations(case)
    assert wrong and says in wrong[0]


@pytest.mark.parametrize(
    ("raised", "says"), [(KeyError("x"), "KeyError"), (solves._TooLong(), "took more than")]
)
def test_a_traceback_and_a_hang_are_violations(monkeypatch, raised, says):
    def broken(*given, **options):
        raise raised

    monkeypatch.setattr(solves, "solve", broken)
    _, (wrong,) = solves.violations(CASE)
    assert says in wrong


def test_the_time_limit_ends_a_case():
    def endless():
        while True:
            pass

    with pytest.raises(solves._TooLong), solves._limited(0.05):
        endless()


def test_the_command_prints_counts(capsys):
    assert main(["solves", "--count", "3", "--seed", "5"]) == 0
    assert "3 cases, 0 violations" in capsys.readouterr().out
