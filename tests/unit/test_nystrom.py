"""Order on second-order systems: fewer trees, and never fewer than there are."""

import pytest

from glmref.catalogue.lookup import load
from glmref.method.component import SEPARABLE
from glmref.method.families import splitting
from glmref.theory.nystrom import is_nystrom, nystrom_order_of, nystrom_trees
from glmref.theory.order import order_of
from glmref.theory.trees import parse_tree, trees


def test_a_vertex_f_with_two_children_does_not_count():
    assert is_nystrom(parse_tree("k[f[k]f]"))
    assert not is_nystrom(parse_tree("f[kk]"))
    assert not is_nystrom(parse_tree("k[f[kk]]"))


def test_there_are_as_many_trees_as_nystrom_series_have():
    # Hairer, Norsett, Wanner (1993), section II.14: conditions for y' at orders 1, 2, ..
    counts = [1, 1, 2, 3, 6, 10, 20]
    by_root = {
        root: [sum(t.colour == root for t in nystrom_trees(n)) for n in range(1, 8)]
        for root in "kf"
    }
    assert by_root["k"] == counts
    assert by_root["f"] == [1, *counts[:-1]]  # f has one child at most
    assert all(len(nystrom_trees(n)) <= len(trees(n, SEPARABLE)) for n in range(1, 9))


def test_the_trees_that_count_are_closed_under_cutting():
    for n in range(2, 7):
        for t in nystrom_trees(n):
            assert all(is_nystrom(child) for child in t.children)


@pytest.mark.parametrize(
    ("name", "general", "nystrom"),
    [
        ("stormer-verlet", 2, 2),
        ("forest-ruth-4", 4, 4),
        ("mclachlan-atela-4", 3, 4),
        ("blanes-moan-rkn-6-11", 4, 6),
        ("blanes-moan-rkn-6-14", 4, 6),
        ("pair-6-7", 6, 6),
    ],
)
def test_orders_on_all_separable_and_on_second_order_systems(name, general, nystrom):
    method = load(name)
    assert order_of(method, principal="identity").order == general
    found = nystrom_order_of(method)
    assert found.order == nystrom
    assert found.failing_tree is not None
    assert found.failing_tree.order == nystrom + 1


def test_one_weight_off_and_the_order_is_lost():
    good = load("forest-ruth-4")
    a, b = list(good.B[0]), list(good.B_hat[0])
    b[0], b[1] = b[1], b[0]
    assert nystrom_order_of(splitting(a, b)).order == 1


def test_shared_stages_and_no_end_of_the_search():
    found = nystrom_order_of(load("lobatto-iiia-iiib-3"))  # q' = p, p' = k(q, p)
    assert (found.order, str(found.failing_tree)) == (4, "f[k[fff]]")
    assert nystrom_order_of(load("stormer-verlet"), max_order=1).at_least
