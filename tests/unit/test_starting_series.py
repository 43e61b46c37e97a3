"""Starting series: the linear map behind free principal parts, and agreement with direct formulas."""

from fractions import Fraction as F

import pytest

from glmref.catalogue.lookup import load
from glmref.errors import BudgetError
from glmref.exact import exact
from glmref.exact.judging import fast_judge, kept_whole
from glmref.exact.linalg import matvec, rank
from glmref.judge.refusals import Refused
from glmref.method import GLM
from glmref.method.component import GENERAL, ROOTED, SEPARABLE
from glmref.prove.kernel import Kernel
from glmref.prove.verifier import facts_for
from glmref.theory.series import flow
from glmref.theory.starting_series import StartingSeries
from glmref.theory.trees import pruned, trees
from tests.bseries import elementary_weights, order_residuals


def commutator(order, palette):
    """Matrix of beta -> (beta(t1) if t = [t1]) - sum n(s, t) beta(s), order k to order k + 1."""
    smaller = trees(order, palette)
    rows = []
    for t in trees(order + 1, palette):
        row = {s: -count for s, count in pruned(t).items() if s.order == order}
        if len(t.children) == 1:
            row[t.children[0]] = row.get(t.children[0], 0) + 1
        rows.append(tuple(exact(row.get(s, 0)) for s in smaller))
    return tuple(rows)


@pytest.mark.parametrize(
    ("palette", "orders"), [(ROOTED, range(2, 6)), (SEPARABLE, range(2, 6)), (GENERAL, range(2, 4))]
)
def test_principal_parts_of_order_2_or_more_are_determined(palette, orders):
    # the theorem that makes deciding order by order complete, here by rank
    for k in orders:
        assert rank(commutator(k, palette)) == len(trees(k, palette))


@pytest.mark.parametrize("palette", [ROOTED, SEPARABLE, GENERAL])
def test_at_order_1_only_the_common_shift_in_time_is_left(palette):
    matrix = commutator(1, palette)
    assert rank(matrix) == len(palette) - 1
    assert all(sum(row, start=exact(0)).is_zero() for row in matrix)


def rk4():
    A = [[0, 0, 0, 0], [F(1, 2), 0, 0, 0], [0, F(1, 2), 0, 0], [0, 0, 1, 0]]
    b = [F(1, 6), F(1, 3), F(1, 3), F(1, 6)]
    return A, b


def test_residuals_of_a_runge_kutta_method_are_weights_minus_the_flow():
    A, b = rk4()
    m = GLM(A=A, U=[[1]] * 4, B=[b], V=[[1]])
    weights, exact_flow = elementary_weights(A, b, 7), flow(7)
    for t, residual in order_residuals(m, 7).items():
        assert residual == weights[t] - exact_flow[t]


def test_the_number_of_effective_order_conditions():
    # |T_k+1| - |T_k| conditions are left at order k + 1 >= 3 (Butcher 1969)
    A, b = rk4()
    m = GLM(A=A, U=[[1]] * 4, B=[b], V=[[1]])
    series = StartingSeries.of(m, free=True)
    left = [len(series.advance()) - len(series.determined) for _ in range(7)]
    assert left == [1, 1, 1, 2, 5, 11, 28]


def test_trees_that_a_stage_order_makes_alike_are_computed_once():
    x = "sqrt(15)"
    gauss = GLM(
        A=[
            ["5/36", f"2/9-{x}/15", f"5/36-{x}/30"],
            [f"5/36+{x}/24", "2/9", f"5/36-{x}/24"],
            [f"5/36+{x}/30", f"2/9+{x}/15", "5/36"],
        ],
        U=[[1]] * 3,
        B=[["5/18", "4/9", "5/18"]],
        V=[[1]],
    )
    series = StartingSeries.of(gauss, free=False)
    for _ in range(6):
        assert all(series.residual(t) == (0,) for t in series.advance())
    # 37 trees, but powers of c and what the missing A c^3 = c^4 / 4 adds: [[ooo]] and its like
    assert len(series.solved.known) + len(series.solved.outputs) < 24  # A and B times each


@pytest.mark.parametrize(
    "name", ["gauss-2", "dormand-prince-5", "gsymplectic-n", "dimsim-2-type-1", "stormer-verlet"]
)
def test_the_search_of_orders_goes_on_with_the_series_of_the_judge(name):
    facts = facts_for(load(name))
    kernel, own = facts.kernel, Kernel(facts.method)
    free = not kernel.one_step
    assert kernel.order_range(free=free) == own.order_range(free=free)
    shared = kernel.series[free, False]
    assert kernel.range("stage-order") == own.range("stage-order")
    for (row, x), (_, y) in zip(kernel.row_kernels, own.row_kernels, strict=True):
        assert x.range(kernel.row_claim) == y.range(kernel.row_claim), row
    if not shared.along_paths:
        found = facts.shared.judged(False, free, False)
        assert found is not None
        assert found.series is shared.solved and found.series.order > kernel.range("order").lower
        for t in shared.level(2):
            assert shared.value(t) == own.series[free, False].value(t)
            assert shared.plain(t) == own.series[free, False].plain(t)


@pytest.mark.parametrize("stop", [BudgetError("spent"), KeyboardInterrupt()])
def test_a_series_that_was_left_half_made_is_forgotten(stop):
    keeps = fast_judge().proof.record_of
    keeps.cache_clear()
    facts_for(load("gauss-2")).judge("order", 4)
    assert keeps.cache_info().currsize == 1
    with pytest.raises(type(stop)), kept_whole():
        raise stop
    assert keeps.cache_info().currsize == 0


def test_more_trees_than_the_judge_lists_leave_an_order_open(monkeypatch):
    facts = facts_for(load("gauss-2"))
    judged = facts.shared.judged(False, False, False)
    assert judged is not None
    found = judged.series

    def refuse(order):
        raise Refused("beyond the limits of this checker")

    monkeypatch.setattr(found, "pool", refuse)
    assert "beyond the limits" in facts.find("order", 4).reason
    assert found.filled == 0


def test_the_stages_of_a_method_of_stage_order_two_are_the_solution() -> None:
    m = load("gauss-2")
    series = StartingSeries.of(m).through(2)
    c = series.abscissae("o")
    (t,) = trees(2)
    slopes, values = matvec(m.A, c), matvec(m.U, series.value(t))
    found = [x + y for x, y in zip(slopes, values, strict=True)]
    assert [x - y * y / 2 for x, y in zip(found, c, strict=True)] == [0, 0]
