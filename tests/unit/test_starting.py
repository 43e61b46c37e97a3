"""Starting and finishing methods: through which order, and where they differ first."""

from dataclasses import replace

import pytest

from glmref.catalogue.lookup import load
from glmref.errors import ExactnessError
from glmref.exact import Ball
from glmref.method import FinishingMethod, StartingMethod, as_matrix, as_vector
from glmref.prove.kernel import Kernel
from glmref.theory.trees import parse_tree
from tests.bseries import elementary_weights, values_series
from tests.build import conjugated_rk4

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


def started(method, starting):
    """What the kernel knows of a start."""
    return Kernel(replace(method, starting=starting, finishing=None)).range("starting-order")


def finished(method, starting, finishing):
    """What the kernel knows of a finish after a start."""
    both = replace(method, starting=starting, finishing=finishing)
    return Kernel(both).range("finishing-order")


@pytest.mark.parametrize("name", ["gsymplectic-n", "gsymplectic-p", "thesis-3-8", "s4-symmetric"])
def test_starters_of_the_thesis_methods_are_exact_through_order_3(name):
    method = load(name)
    found = started(method, method.starting)
    assert (found.lower, found.upper, found.exact) == (3, 3, True)
    assert found.reason.startswith("tree [ooo] ") and found.reason.endswith("in value 2")


def test_printed_start_3_6_is_right_through_h_squared_only():
    n = load("gsymplectic-n")
    printed = started(n, thesis_3_6("-(3-sqrt(3))/3", A_36))
    assert (printed.lower, printed.upper) == (2, 2) and printed.reason.startswith("tree [[o]] ")
    corrected = started(n, thesis_3_6("0", f"-{A_36}"))
    assert (corrected.lower, corrected.upper) == (3, 3)
    assert corrected.reason.startswith("tree [ooo] ")


def test_the_seven_stage_start_of_n_has_order_4():
    n = load("gsymplectic-n")
    found = started(n, full_start_of_n())
    assert (found.lower, found.upper) == (4, 4) and "agrees" in found.reason
    # the sign of one weight wrong: only the trees of order 1 are left
    wrong = full_start_of_n()
    rows = [list(row) for row in wrong.B]
    rows[1][1] = -rows[1][1]
    assert started(n, start(wrong.A, rows, wrong.u)).upper == 0


def test_zero_starting_values_agree_as_far_as_the_series_is_zero():
    n, g = load("gsymplectic-n"), load("g6245-w3")
    assert started(n, start([[0]], [[0], [0]], [1, 0])).upper == 1
    found = started(g, start([[0]], [[0]] * 4, [1, 0, 0, 0]))
    assert (found.lower, found.upper) == (2, 2)


def test_a_start_with_the_wrong_multiples_of_y_agrees_nowhere():
    found = started(load("gsymplectic-n"), start([[0]], [[0], [0]], [1, 1]))
    assert (found.lower, found.upper) == (0, 0)
    assert found.reason.startswith("the multiple of y differs") and "value 2" in found.reason


def test_published_digits_of_3_9_are_enclosed():
    # the printed eight decimals, one unit of the last in doubt: nothing refutes order 3, and
    # digits alone prove nothing
    method = load("thesis-3-8")
    exact_start = method.starting
    rounded = [
        [x if x == 0 else Ball.decimal(f"{float(x):.8f}", 8) for x in row] for row in exact_start.B
    ]
    found = started(method, start(exact_start.A, rounded, exact_start.u))
    assert (found.value, found.upper, found.exact) == (3, 3, False)
    assert found.lower < 3


def test_a_conjugated_method_is_started_and_finished_by_its_conjugation():
    method = conjugated_rk4()
    forwards = start([[0]], [["1/3"]], [1])
    backwards = FinishingMethod(A=as_matrix([["-1/3"]], "A"), b=as_vector(["-1/3"], "b"))
    assert started(method, forwards).lower == 4
    assert finished(method, forwards, backwards).lower == 4
    # near misses: no conjugation at all, and half of it
    assert started(method, start([[0]], [[0]], [1])).upper == 1
    half = FinishingMethod(A=as_matrix([["-1/6"]], "A"), b=as_vector(["-1/6"], "b"))
    assert finished(method, forwards, half).upper == 0


def test_finishing_begins_from_the_output_wherever_it_stands():
    # Nordsieck-like order of values: the solution second
    method = load("g4123")
    turned = method.transform([[0, 1], [1, 0]])
    assert turned.starting is not None and turned.finishing is method.finishing
    for m in (method, turned):  # the file claims 3 for its own start and finish
        assert finished(m, m.starting, m.finishing).upper == 3
    # near miss: the start of the values in their old order gives no multiple of y to finish
    with pytest.raises(ExactnessError, match="starts from y itself"):
        finished(turned, method.starting, method.finishing)


def test_series_of_starting_and_finishing_methods():
    s = values_series(full_start_of_n(), 4)
    assert s.empty() == (1, 0)
    assert s[parse_tree("o")][0] == 0
    f = elementary_weights(as_matrix([[0]], "A"), as_vector([1], "b"), 3)
    assert (f[parse_tree("o")], f[parse_tree("[o]")]) == (1, 0)
