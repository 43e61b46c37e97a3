"""Order: holds at p, fails at p + 1 with the tree named; free and identity principal parts."""

import time
from fractions import Fraction as F
from typing import Any

import pytest

from glmref.catalogue.lookup import load
from glmref.errors import ExactnessError
from glmref.exact import Ball
from glmref.exact.expression import parse
from glmref.exact.linalg import block_diagonal
from glmref.findings import Proof
from glmref.method import GLM
from glmref.method.component import GENERAL, ROOTED, SEPARABLE
from glmref.prove.kernel import Kernel
from glmref.theory.order import highest_order, order_of
from glmref.theory.series import compose, flow
from glmref.theory.starting_series import StartingSeries
from glmref.theory.trees import parse_tree
from tests.literature.exactly import after_step, first_difference

# name, order and failing tree with a free principal part, then with the identity, stage order
SHARP = [
    ("gsymplectic-n", 4, "[[ooo]]", 4, "[oooo]", 2),
    ("gsymplectic-p", 4, "[[ooo]]", 4, "[oooo]", 2),
    ("thesis-3-8", 4, "[[o][o]]", 4, "[oooo]", 1),
    ("s4-symmetric", 4, "[[o][o]]", 4, "[oooo]", 1),
    ("g6245-w3", 6, "[[oo][oo]]", 6, "[oooooo]", 2),
    ("g6245", 6, "[[oo][oo]]", 6, "[oooooo]", 2),
    ("g4123", 4, "[[o][o]]", 2, "[oo]", 1),
    ("rk4", 4, "[[o][o]]", 4, "[oooo]", 1),
    ("gauss-2", 4, "[[ooo]]", 4, "[oooo]", 2),
    ("gauss-4", 8, "[[ooooooo]]", 8, "[oooooooo]", 4),
    ("butcher-effective-5", 5, "[[oooo]]", 4, "[oooo]", 1),
    ("ab-2", 2, "[[o]]", 2, "[oo]", 2),
    ("leapfrog", 2, "[[o]]", 2, "[oo]", 2),
    ("bdf-3", 3, "[[oo]]", 3, "[ooo]", 3),
    ("milne-simpson-one-leg", 4, "[[ooo]]", 2, "[oo]", 4),
    ("dimsim-2-type-2", 2, "[[o]]", 2, "[oo]", 2),
]


@pytest.mark.sampled(8)
@pytest.mark.parametrize(("name", "order", "tree", "identity", "tree_i", "stage"), SHARP)
def test_order_holds_and_the_next_fails(name, order, tree, identity, tree_i, stage):
    method = load(name)
    free = order_of(method)
    assert (free.order, str(free.failing_tree)) == (order, tree)
    assert Kernel(method).range("stage-order").value == stage
    assert free.decided
    assert free.proof is Proof.EXACT
    assert free.largest_residual == 0.0
    assert not free.residual.is_zero()
    fixed = order_of(method, principal="identity")
    assert (fixed.order, str(fixed.failing_tree)) == (identity, tree_i)


def test_order_6_methods_take_less_than_2_seconds_with_error_constants():
    # measured 0.05 s each; the bound is the promise
    for name in ("g6245-w3", "g6245"):
        method = load(name)
        start = time.process_time()
        result = order_of(method, principal="identity")
        assert time.process_time() - start < 2.0
        assert len(result.residuals) == 48
        assert max(x.magnitude() for x in result.residuals.values()) == pytest.approx(
            F(5, 7560), rel=1e-12
        )


def test_starting_series_of_n_is_the_printed_one():
    # values of the second component, derived from (3.5) by hand for the first trees
    eta = order_of(load("gsymplectic-n")).eta
    assert eta is not None
    expected = {
        "o": "0", "[o]": "-sqrt(3)/12", "[oo]": "0", "[[o]]": "0", "[ooo]": "sqrt(3)/18",
        "[o[o]]": "sqrt(3)/36", "[[oo]]": "1/12-sqrt(3)/36", "[[[o]]]": "1/24-sqrt(3)/72",
    }  # fmt: skip
    for text, value in expected.items():
        assert eta[parse_tree(text)] == (0, parse(value))


def test_starting_series_of_g4123_is_that_of_the_literature():
    # Butcher and Imran (2015), both components: the first is a conjugation
    eta = order_of(load("g4123")).eta
    assert eta is not None
    first = {"o": "0", "[o]": "-1/32", "[oo]": "-7/4320", "[[o]]": "149/8640"}
    second = {"o": "1/4", "[o]": "-1/16", "[oo]": "-49/960", "[[o]]": "-13/384"}
    for text, value in first.items():
        assert eta[parse_tree(text)] == (parse(value), parse(second[text]))


def test_the_starting_series_satisfies_the_definition():
    # M S = S E, with M applied by another module
    method = load("g4123")
    result = order_of(method)
    after, moved = after_step(method, result.eta), compose(flow(result.order), result.eta)
    assert [first_difference(after, moved, k) for k in range(method.r)] == [result.order + 1] * 2


def test_published_digits_are_enclosed():
    def d(text):
        return Ball.decimal(text, 10)

    rk = GLM(
        A=[[0, 0, 0, 0], [d("0.5"), 0, 0, 0], [0, d("0.5"), 0, 0], [0, 0, 1, 0]],
        U=[[1]] * 4,
        B=[[d("0.1666666667"), d("0.3333333333"), d("0.3333333333"), d("0.1666666667")]],
        V=[[1]],
    )
    result = order_of(rk)
    assert (result.order, result.proof, result.decided) == (4, Proof.ENCLOSED, True)
    assert parse_tree("o") in result.undecided
    # radii are 1e-10; 8 trees of at most 4 factors below 1 cannot add up to more than 1e-8
    assert 0 < result.largest_residual < 1e-8
    wrong = rk.bare(B=[[d("0.1666666668"), *rk.B[0][1:3], d("0.1666666668")]])
    assert order_of(wrong).order == 4  # inside the radii: it cannot be told apart
    wrong = rk.bare(B=[[d("0.1666666767"), *rk.B[0][1:]]])
    assert order_of(wrong).order == 0


def test_an_eigenvalue_that_balls_leave_open_is_said():
    third, two = Ball.decimal("0.3333333333", 10), Ball.decimal("0.6666666667", 10)
    method = GLM(A=[[0]], U=[[1, 0]], B=[[1], [1]], V=[[third, two], [third, two]])
    result = order_of(method)
    assert (result.order, result.decided) == (0, False)
    assert result.proof is Proof.ENCLOSED
    assert "whether 1 is an eigenvalue is open" in result.reason


def test_a_multiple_eigenvalue_that_is_harmless_is_decided():
    # two copies of one sum, averaged by the stages: u = (1, 1) is fixed by consistency
    rk4 = load("rk4")
    twin = GLM(A=rk4.A, U=[["1/2", "1/2"]] * 4, B=[rk4.B[0]] * 2, V=[[1, 0], [0, 1]])
    result = order_of(twin)
    assert (result.order, result.decided, result.multiplicity) == (4, True, 2)
    # a second sum with the weights of Euler's method along Heun's: it has the order of Heun, since
    # a sum of f differs from the integral by its ends
    pair = GLM(A=[[0, 0], [1, 0]], U=[[1, 0]] * 2, B=[["1/2", "1/2"], [1, 0]], V=[[1, 0], [0, 1]])
    result = order_of(pair)
    assert (result.order, result.decided) == (2, True)


def test_a_multiple_eigenvalue_with_more_freedom_is_reported_as_undecided():
    rk4 = load("rk4")
    apart = GLM(
        A=block_diagonal(rk4.A, rk4.A),
        U=[[1, 0]] * 4 + [[0, 1]] * 4,
        B=block_diagonal(rk4.B, rk4.B),
        V=[[1, 0], [0, 1]],
    )
    result = order_of(apart)
    assert result.order == 4
    assert not result.decided
    assert "not decided" in result.reason
    # a defective eigenvalue 1: the difference of Euler's method with itself one step back
    twice = GLM(A=[[0]], U=[[1, 0, 0]], B=[[1], [0], [1]], V=[[2, -1, -1], [1, 0, 0], [0, 0, 0]])
    assert not order_of(twice).decided


def test_trees_are_compared_as_far_as_their_number_allows():
    three, four = (dict.fromkeys("123", "123"), dict.fromkeys("1234", "1234"))
    found = [highest_order(x) for x in (ROOTED, GENERAL, three, four, SEPARABLE)]
    assert found == [12, 8, 6, 5, 9]


def test_an_order_that_could_not_be_looked_for_is_not_decided(monkeypatch):
    def too_large(*_: Any, **__: Any) -> Any:
        raise ExactnessError("too large")

    for place, name in ((StartingSeries, "advance"), (StartingSeries, "of")):
        with monkeypatch.context() as changed:
            changed.setattr(place, name, too_large)
            found = order_of(load("euler"))
        assert found.order == 0 and not found.decided and found.reason == "too large"
