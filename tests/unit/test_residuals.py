"""Linear systems with any number of rows."""

from glmref.exact import Ball, exact
from glmref.exact.linalg import independent_rows, solve_affine
from glmref.theory.residuals import Residual, verdict_of


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


def test_the_size_of_a_residual_is_that_of_its_largest_entry():
    wide, wider = Ball.decimal("0.00", 2), Ball.decimal("0.0", 1)
    for row in ((wide, wider), (wider, wide)):
        assert verdict_of((row,)).residual == wider.magnitude()
    assert verdict_of(((exact(0), exact(0)),)) == Residual(True, 0.0, None)
    for rows, entry in ((((exact(-3), exact(2)),), (0, 0)), (((exact(1),), (exact(2),)), (1, 0))):
        assert verdict_of(rows).entry == entry


def test_decisions_that_balls_leave_open_are_said():
    wide = Ball.decimal("0.0", 1)
    assert solve_affine(((exact(1),), (wide,)), (exact(2), exact(0))).undecided
    opened = solve_affine(((wide,),), (exact(1),))
    assert opened.undecided and opened.failed is None and opened.point == (0,)
    only = solve_affine(((exact(0),),), (wide,))
    assert only.undecided and only.failed is None
    best = solve_affine(((Ball.decimal("0.5", 1), Ball.decimal("2.0", 1)),), (exact(1),))
    assert best.point[0] == 0 and best.point[1].contains(exact(1) / 2)
    found = solve_affine(M([1, 2], [0, 1], [1, 3]), (exact(1), exact(1), exact(3)))
    assert found.failed == 2 and found.directions == () and found.point == (-1, 1)
