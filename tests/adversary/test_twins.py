"""A small attack with twins: see :mod:`tests.attack.twins`."""

import pytest

from tests.attack import twins


@pytest.mark.slow
@pytest.mark.parametrize(("count", "seed"), [(5, 3), (20, 4)])
def test_a_verdict_about_digits_is_true_of_every_method_in_them(count: int, seed: int) -> None:
    tally = twins.attack(count, seed)
    assert not tally.violations, tally.text()
    assert tally.outcomes["fails"] and tally.outcomes["open, in digits"]
