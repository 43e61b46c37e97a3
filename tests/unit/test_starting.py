"""Starting and finishing methods: through which order, and where they differ first."""

from fractions import Fraction as F

import pytest

from glmref.catalogue.lookup import load
from glmref.errors import UsageError
from glmref.exact import Ball
from glmref.findings import Proof
from glmref.method import GLM, FinishingMethod, StartingMethod, as_matrix, as_vector
from glmref.theory.order import order_of
from glmref.theory.starting import (
    exact_start_series,
    finishing_order,
    finishing_series,
    starting_order,
    starting_series,
)
from glmref.theory.trees import parse_tree

A_36 = "(3-sqrt(3))/6"
W_36 = "(1+sqrt(3))/8"


def start(A, B, u):
    return StartingMethod(A=as_matrix(A, "A"), B=as_matrix(B, "B"), u=as_vector(u, "u"))


def thesis_3_6(a21, a22):
    return start([[A_36, 0], [a21, a22]], [[0, 0], [f"-{W_36}", W_36]], [1, 0])


def full_start_of_n():
    """Seven evaluations, odd in h: order 4 (checked here, derived from the eight conditions)."""
    b2, b3 = "(1+sqrt(3))/4", "(24-12*sqrt(3))/11"
    rest = f"1/2-{b2}", f"1-{b3}"
    rows = [["0"] * 7 for _ in range(7)]
    for sign, first in (("", 1), ("-", 2)):
        rows[first][0] = f"{sign}(1/2)"
        rows[first + 2][0], rows[first + 2][first] = f"{sign}({rest[0]})", f"{sign}({b2})"
        rows[first + 4][0], rows[first + 4][first + 2] = f"{sign}({rest[1]})", f"{sign}({b3})"
    weights = ["5/3-32*sqrt(3)/27", "-5/3+sqrt(3)", "11*sqrt(3)/216"]
    second = ["0", *(f"{sign}({w})" for w in weights for sign in ("", "-"))]
    return start(rows, [["0"] * 7, second], [1, 0])


@pytest.mark.parametrize("name", ["gsymplectic-n", "gsymplectic-p", "thesis-3-8", "s4-symmetric"])
@pytest.mark.parametrize("principal", ["free", "identity"])
def test_starters_of_the_thesis_methods_are_exact_through_order_3(name, principal):
    method = load(name)
    result = starting_order(method, method.starting, principal=principal)
    assert (result.order, str(result.failing_tree), result.component) == (3, "[ooo]", 2)
    assert result.proof is Proof.EXACT
    assert result.shift == 0
    assert "[ooo]" in result.witness


def test_printed_start_3_6_is_right_through_h_squared_only():
    n = load("gsymplectic-n")
    printed = starting_order(n, thesis_3_6("-(3-sqrt(3))/3", A_36))
    assert (printed.order, str(printed.failing_tree), printed.component) == (2, "[[o]]", 2)
    corrected = starting_order(n, thesis_3_6("0", f"-{A_36}"))
    assert (corrected.order, str(corrected.failing_tree)) == (3, "[ooo]")


def test_the_seven_stage_start_of_n_has_order_4():
    n = load("gsymplectic-n")
    result = starting_order(n, full_start_of_n())
    assert (result.order, result.failing_tree, result.method_order) == (4, None, 4)
    assert "agrees" in result.witness
    assert starting_order(n, full_start_of_n(), known=order_of(n)).order == 4
    # the sign of one weight wrong: only the trees of order 1 are left
    wrong = full_start_of_n()
    rows = [list(row) for row in wrong.B]
    rows[1][1] = -rows[1][1]
    assert starting_order(n, start(wrong.A, rows, wrong.u)).order == 0


def test_zero_starting_values_agree_as_far_as_the_series_is_zero():
    n, g = load("gsymplectic-n"), load("g6245-w3")
    assert starting_order(n, start([[0]], [[0], [0]], [1, 0])).order == 1
    result = starting_order(g, start([[0]], [[0]] * 4, [1, 0, 0, 0]))
    assert (result.order, result.failing_tree.order) == (2, 3)


def test_a_start_with_the_wrong_multiples_of_y_agrees_nowhere():
    result = starting_order(load("gsymplectic-n"), start([[0]], [[0], [0]], [1, 1]))
    assert (result.order, result.failing_tree, result.component) == (-1, None, 2)
    assert "multiple of y" in result.witness


def test_a_start_for_another_number_of_values_is_refused():
    with pytest.raises(UsageError, match="for 2 values"):
        starting_order(load("gsymplectic-n"), start([[0]], [[0]], [1]))


def test_published_digits_of_3_9_are_enclosed():
    # the printed eight decimals, one unit of the last in doubt
    method = load("thesis-3-8")
    exact_start = method.starting
    rounded = [
        [x if x == 0 else Ball.decimal(f"{float(x):.8f}", 8) for x in row] for row in exact_start.B
    ]
    result = starting_order(method, start(exact_start.A, rounded, exact_start.u))
    assert (result.order, result.proof) == (3, Proof.ENCLOSED)
    # four weights, each rounded by at most half a unit and in doubt by one; abscissae at most 1
    assert 0 < result.largest_residual <= 4 * 1.5e-8 * (1 + 1e-6)


def conjugated_rk4():
    """Euler with step h/3 backwards, RK4, Euler with step h/3 forwards, as one tableau."""
    half, b = F(1, 2), [F(1, 6), F(1, 3), F(1, 3), F(1, 6)]
    rk = [[0, 0, 0, 0], [half, 0, 0, 0], [0, half, 0, 0], [0, 0, 1, 0]]
    rows = [[F(-1, 3), 0, 0, 0, 0, 0]]
    rows += [[F(-1, 3), *row, 0] for row in rk]
    rows += [[F(-1, 3), *b, 0]]
    return GLM(A=rows, U=[[1]] * 6, B=[[F(-1, 3), *b, F(1, 3)]], V=[[1]])


def test_a_conjugated_method_is_started_and_finished_by_its_conjugation():
    method = conjugated_rk4()
    forwards = start([[0]], [["1/3"]], [1])
    backwards = FinishingMethod(A=as_matrix([["-1/3"]], "A"), b=as_vector(["-1/3"], "b"))
    result = starting_order(method, forwards)
    assert result.order == 4
    assert result.shift == F(1, 3)  # Euler's step of h/3 runs ahead by h/3
    assert finishing_order(method, backwards, starting=forwards).order == 4
    assert finishing_order(method, backwards).order == 4
    assert finishing_order(method, backwards).shift == F(1, 3)
    # near misses: no conjugation at all, and half of it
    nothing = start([[0]], [[0]], [1])
    assert starting_order(method, nothing).order == 1
    identity = starting_order(method, nothing, principal="identity")
    assert (identity.order, identity.method_order) == (2, 2)
    half = FinishingMethod(A=as_matrix([["-1/6"]], "A"), b=as_vector(["-1/6"], "b"))
    assert finishing_order(method, half, starting=forwards).order == 0
    assert finishing_order(method, half).order == 1


def test_finishing_begins_from_the_output_wherever_it_stands():
    # Nordsieck-like order of values: the solution second
    method = load("g4123")
    turned = method.transform([[0, 1], [1, 0]])
    assert turned.starting is not None and turned.finishing is method.finishing
    orders = [
        finishing_order(m, m.finishing, starting=start).order
        for m in (method, turned)
        for start in (None, m.starting)
    ]
    assert orders == [4, 3, 4, 3]  # the file claims 3 for its own start and finish
    # near miss: the start of the values in their old order gives no multiple of y to finish
    with pytest.raises(UsageError, match="w u = 1"):
        finishing_order(turned, turned.finishing, starting=method.starting)


def test_series_of_starting_and_finishing_methods():
    s = starting_series(full_start_of_n(), 4)
    assert s.empty() == (1, 0)
    assert s[parse_tree("o")][0] == 0
    f = finishing_series(FinishingMethod(A=as_matrix([[0]], "A"), b=as_vector([1], "b")), 3)
    assert (f[parse_tree("o")], f[parse_tree("[o]")]) == (1, 0)


def test_the_exact_series_goes_as_far_as_the_order():
    n = load("gsymplectic-n")
    assert exact_start_series(n, 4).order == 4
    assert exact_start_series(n, 2) == exact_start_series(n, 4).truncate(2)
    with pytest.raises(UsageError, match="order is 4"):
        exact_start_series(n, 5)
    with pytest.raises(UsageError, match="order is 2"):
        exact_start_series(load("g4123"), 3, principal="identity")


def test_an_order_that_is_known_is_taken_and_not_computed_again():
    method = load("g4123")
    blocks = method.finishing, method.starting
    alone = finishing_order(method, blocks[0], starting=blocks[1])
    known = finishing_order(method, blocks[0], starting=blocks[1], known=order_of(method))
    assert (known.order, known.witness) == (alone.order, alone.witness)
    less = order_of(method, max_order=2)
    assert finishing_order(method, blocks[0], starting=blocks[1], known=less).order == 2
    assert alone.order > 2
