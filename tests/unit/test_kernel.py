"""Rules of the kernel that no shipped method reaches: each condition of each is asked for."""

from fractions import Fraction

import pytest

from glmref import load
from glmref.catalogue.reader import load_document
from glmref.exact import Ball, Exact
from glmref.findings import Proof, Verdict
from glmref.method import PartitionedGLM
from glmref.prove.facts import facts_of
from glmref.prove.kernel import Kernel, Reach


def searched(method):
    """The kernel of a method, and the series of the search for its order."""
    kernel = Kernel(load(method) if isinstance(method, str) else method)
    kernel.order_range(free=not kernel.one_step)
    return kernel, kernel.series[not kernel.one_step, False]


def test_the_tree_with_leaves_alone_refutes_an_order_and_proves_none():
    kernel, series = searched("gauss-3")
    assert kernel._beyond(series, 3, 5, [0.0]) is None
    found = kernel._beyond(series, 6, 7, [0.0])
    assert found is not None
    assert (found.lower, found.upper, found.tree, found.exact) == (6, 6, "[oooooo]", True)
    assert found.residual == pytest.approx(1 / 2800)


@pytest.mark.parametrize("name", ["gsymplectic-n", "pair-4-4"])
def test_that_tree_says_nothing_of_several_values(name):
    kernel, series = searched(name)
    assert kernel._bush(series, 7) is None
    assert kernel._beyond(series, 3, 7, [0.0]) is None


def test_of_a_separable_pair_with_one_value_each_colour_has_such_a_tree():
    kernel, series = searched("stormer-verlet")
    assert kernel._bush(series, 7) is None  # what is nearly reached is told of one method only
    found = kernel._beyond(series, 2, 3, [0.0])
    # f[kk]: b (A^ 1)^2 = 1/4, half a step in the middle, misses 1/3 by 1/12
    assert found is not None and (found.lower, found.upper, found.tree) == (2, 2, "f[kk]")
    assert found.residual == pytest.approx(1 / 12)
    assert kernel._beyond(series, 1, 2, [0.0]) is None  # order 2 holds


def runge_kutta(A, b, **more):
    """A Runge-Kutta method from its entries as texts."""
    source = {"citation": "c", "where": "w", "status": "derived"}
    doc = {"format": "glmref-method-1", "name": "one", "title": "t", "source": source}
    return load_document({**doc, "class": "rk", "A": A, "b": b, "claims": {"order": 1}, **more})


def test_the_tree_decides_over_balls_what_it_excludes_and_is_enclosed():
    kernel, series = searched(runge_kutta([["0.50"]], ["1"], digits=2))
    assert kernel._beyond(series, 0, 2, [0.0]) is None  # a ball around zero
    found = kernel._beyond(series, 0, 3, [0.0])
    assert found is not None
    assert (found.upper, found.exact) == (2, False)


@pytest.mark.parametrize(
    ("b", "verdict"), [("1", Verdict.FAILS), ("2", Verdict.HOLDS), ("1+i", Verdict.FAILS)]
)
def test_the_imaginary_parts_of_a_form_count(b, verdict):
    # d = b* g and 2 d Re a = |b|^2 g: with b = 1 + i the real parts alone have a solution
    facts = facts_of(runge_kutta([["1"]], [b], field="complex"))
    assert facts.judge("g-symplectic", True).verdict is verdict


def test_a_form_that_was_found_is_enough_where_decimals_play_no_part():
    # the second stage is used by nobody: its entry of 0.3 +- 0.1 meets the weight 0
    facts = facts_of(runge_kutta([["1/2", "0"], ["0.3", "0"]], ["1", "0"], digits=1))
    found = facts.judge("g-symplectic", True)
    assert (found.verdict, found.proof) == (Verdict.HOLDS, Proof.ENCLOSED)


def test_a_given_form_in_decimals_is_refuted_by_balls():
    # the weight d = b g would have to be 1, and g is 2 within a tenth
    G, D = ((Ball.decimal("2.0", 1),),), ((Exact(1),),)
    known = Kernel(load("gauss-1"))._g_symplectic({"form": (G, D), "given": True})
    assert (known.truth, known.exact) == (False, False)


def growing_pair(last, *, separable):
    """Two values in each half, the second carried along: V = diag(1, -1), V^ = diag(1, last)."""
    zero, one = Exact(0), Exact(1)
    A, U, B = ((zero,),), ((one, zero),), ((one,), (zero,))
    V, V_hat = (((one, zero), (zero, Exact(Fraction(x)))) for x in (-1, last))
    return PartitionedGLM(
        A=A, U=U, B=B, V=V, A_hat=A, U_hat=U, B_hat=B, V_hat=V_hat, separable=separable
    )


def test_eigenvalues_of_one_half_alone_leave_growth_open_where_stages_are_shared():
    for last, separable, verdict in (
        ("-1", False, Verdict.HOLDS),
        ("-1", True, Verdict.HOLDS),
        ("1/2", False, Verdict.OPEN),
        ("1/2", True, Verdict.HOLDS),
    ):
        facts = facts_of(growing_pair(last, separable=separable))
        assert facts.judge("parasitism-free", True).verdict is verdict, (last, separable)


def test_a_step_of_the_staircase_is_a_rounding_and_far_below_the_next():
    def staircase(*sizes, proved=0):
        return Reach(proved, sizes, ("",) * len(sizes), None, exact=True).staircase()

    assert staircase(1e-9, 1e-9, 0.25) == "order 2 to 1e-09, order 0 exactly"
    assert staircase(1e-9, 1.01e-7) == "order 2 to 1e-07, order 1 to 1e-09, order 0 exactly"
    size = 2.0**-30
    assert staircase(size, 100 * size) == "order 2 to 9.3e-08, order 0 exactly"
    assert staircase(1e-3) == "order 0 exactly"  # no rounding
    assert staircase(0.0, 0.0) == "order 0 exactly"  # balls around zero show no step
    assert staircase(0.0, 0.25, proved=1) == "order 1 exactly"
