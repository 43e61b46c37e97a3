"""Linear systems of the reference engine with more digits than doubles have, and sums in order."""

import numpy as np
import pytest

from glmref.engine.arithmetic import Arithmetic, in_order

SMALL = "1e-60"


@pytest.mark.parametrize("rows", [
    [["0", "1"], ["1", "0"]], [[SMALL, "1"], ["1", "1"]], [["1", "2", "3"], ["2", "4", "1"], ["3", "1", "1"]],
    [["0", "0", "1"], ["0", "0.25", "1"], ["2", "1", "1"]],
])  # fmt: skip
def test_systems_that_need_an_exchange_of_rows_are_solved(rows):
    arithmetic = Arithmetic(40)
    context = arithmetic.context
    a = np.array([[context.mpf(x) for x in row] for row in rows], dtype=object)
    wanted = np.array([context.mpf(k + 2) / 7 for k in range(len(rows))], dtype=object)
    many = np.stack([wanted, 3 * wanted], axis=1)
    for x in (wanted, many):
        found = arithmetic.solve(a, a.dot(x))
        assert np.abs(found - x).max() < context.mpf(10) ** -37
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        arithmetic.solve(a * 0, wanted)


@pytest.mark.parametrize("columns", [1, 2, 7])
def test_terms_are_added_one_after_the_other_however_many_are_summed_at_once(columns):
    generator = np.random.default_rng(columns)
    weights, rows = generator.normal(size=17), generator.normal(size=(17, columns, 5))
    weights[[2, 11]] = 0
    expected = np.zeros((columns, 5))
    for w, row in zip(weights, rows, strict=True):
        expected = expected + w * row
    assert np.array_equal(in_order(weights, rows), expected)
    for k in range(5):
        assert np.array_equal(in_order(weights, rows[..., k]), expected[:, k])
    assert np.array_equal(in_order(0 * weights, rows[..., 0]), np.zeros(columns))
    # a sum by pairs, or with two sums at a time, has other bits
    assert not np.array_equal((weights[:, None] * rows[:, 0]).T.copy().sum(axis=1), expected[0])
