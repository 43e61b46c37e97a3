"""Linear systems of the reference engine with more digits than doubles have."""

import numpy as np
import pytest

from glmref.engine.arithmetic import Arithmetic

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
