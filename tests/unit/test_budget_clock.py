"""A budget reads the clock of the processor no oftener than it can be spent."""

from itertools import count

import pytest

from glmref.catalogue.lookup import load
from glmref.errors import BudgetError
from glmref.measure import stability as measured
from glmref.system import budget
from glmref.theory.stability import stability_polynomial


class Clocks:
    """Time that passes, of which the thread gets a share, by the tick of :meth:`pass_on`."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, share: float) -> None:
        self.now, self.share, self.read = 0.0, share, 0
        monkeypatch.setattr(budget, "monotonic", lambda: self.now)
        monkeypatch.setattr(budget, "thread_time", self.thread_time)

    def thread_time(self) -> float:
        self.read += 1
        return self.now * self.share

    def calls_until_spent(self, seconds: float) -> int:
        with budget.limited(seconds):
            for calls in count():
                try:
                    budget.spend()
                except BudgetError:
                    return calls
                self.now += 0.001
        raise AssertionError


@pytest.mark.parametrize("share", [1.0, 0.5, 0.1])
def test_a_budget_ends_at_its_processor_time_and_reads_the_clock_seldom(monkeypatch, share):
    clocks = Clocks(monkeypatch, share)
    calls = clocks.calls_until_spent(1.0)
    # the first look of which the thread time is above a second: within one tick
    assert abs(calls - 1000 / share) <= 1
    assert clocks.read < 200


def test_an_inner_budget_ends_first_and_the_outer_one_is_not_forgotten(monkeypatch):
    clocks = Clocks(monkeypatch, 1.0)
    with budget.limited(3.0):
        assert abs(clocks.calls_until_spent(1.0) - 1000) <= 1
        with budget.limited(10.0):  # the outer limit stays
            assert budget.left()[1] == 3.0
        clocks.now = 3.1
        with pytest.raises(BudgetError, match="budget of 3 s"):
            budget.spend()


def test_a_tableau_is_rounded_once_for_all_points_of_an_interval(monkeypatch):
    method, calls = load("bdf-2"), []
    found = type(method).to_float
    monkeypatch.setattr(type(method), "to_float", lambda m: calls.append(m) or found(m))
    measured.interval(method)
    assert len(calls) == 1
    assert stability_polynomial(method) is stability_polynomial(method)
