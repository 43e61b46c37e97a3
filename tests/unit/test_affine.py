"""Linear systems with any number of rows."""

from glmref.exact import Ball, exact
from glmref.theory.affine import independent_rows, solve_affine, verdict_of


def M(*rows):
    return tuple(tuple(exact(x) for x in row) for row in rows)


def test_all_solutions_of_an_underdetermined_system():
    rows = M([1, 1, 0], [0, 0, 1], [1, 1, 1])
    found = solve_affine(rows, (exact(2), exact(3), exact(5)))
    assert found.failed is None and not found.undecided
    assert found.point == (2, 0, 3)
    assert found.directions == ((-1, 1, 0),)


def test_the_contradicting_row_is_named():
    found = solve_affine(M([1, 1], [2, 2], [2, 2]), (exact(1), exact(2), exact(3)))
    assert found.failed == 2


def test_independent_rows_are_the_first_ones():
    assert independent_rows(M([0, 0], [1, 2], [2, 4], [0, 1])) == [1, 3]
    assert independent_rows(M([1, 0], [0, 1], [1, 1]), 1) == [0]


def test_verdict_tells_zero_from_open_from_failed():
    tiny = Ball.decimal("0.0", 20)
    assert verdict_of(((exact(0),),)).holds is True
    opened = verdict_of(((exact(0), tiny),))
    assert opened.holds is None and 0 < opened.residual < 1e-19
    failed = verdict_of(((tiny, exact(0)), (exact(2), exact(-3))))
    assert failed.holds is False and failed.entry == (1, 1) and failed.residual == 3
