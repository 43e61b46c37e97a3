"""Single signs, limits and sizes on which verdicts and kernels rest."""

from __future__ import annotations

import time
from typing import Any

import pytest

from glmref import GLM, ExactnessError, solve
from glmref.exact import ball, exact
from glmref.exact.jet import jets
from glmref.theory import order as theory_order
from glmref.theory.starting_series import StartingSeries


def test_the_sign_of_an_exact_zero_is_zero() -> None:
    assert [ball(x).sign() for x in (0, 2, -2)] == [0, 1, -1]


def test_a_zero_with_a_derivative_is_not_called_zero() -> None:
    (x,) = jets([exact(0)])
    assert x.is_zero() is None and (x - x).is_zero() is True and (x + 1).is_zero() is False


def test_an_order_that_could_not_be_looked_for_is_not_decided(monkeypatch):
    def too_large(*_: Any, **__: Any) -> Any:
        raise ExactnessError("too large")

    euler = GLM(A=[["0"]], U=[["1"]], B=[["1"]], V=[["1"]])
    for place, name in ((StartingSeries, "advance"), (StartingSeries, "of")):
        with monkeypatch.context() as changed:
            changed.setattr(place, name, too_large)
            found = theory_order.order_of(euler)
        assert found.order == 0 and not found.decided and found.reason == "too large"
    assert theory_order.order_of(euler).decided


@pytest.mark.parametrize("engine", ["interpreted", "reference"])
def test_the_seconds_of_a_run_are_not_more_than_have_passed(engine: str) -> None:
    begin = time.perf_counter()
    found = solve("pendulum", "rk4", h=0.1, steps=3, engine=engine)
    assert 0 <= found.seconds <= time.perf_counter() - begin
