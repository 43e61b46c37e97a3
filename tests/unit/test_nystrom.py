"""Order on second-order systems: fewer trees, and never fewer than there are."""

import copy
from typing import Any

import pytest

from glmref.catalogue.lookup import document, load
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.findings import Verdict
from glmref.method.component import SEPARABLE
from glmref.method.families import splitting
from glmref.prove.beside import known_beside
from glmref.prove.verifier import facts_for
from glmref.theory.order import OrderResult, order_of
from glmref.theory.trees import counted, is_nystrom, parse_tree, trees


def nystrom_order_of(pair: Any, most: int = 9) -> OrderResult:
    return order_of(pair, max_order=most, principal="identity", counts=counted("nystrom"))


def test_a_vertex_f_with_two_children_does_not_count():
    assert is_nystrom(parse_tree("k[f[k]f]"))
    assert not is_nystrom(parse_tree("f[kk]"))
    assert not is_nystrom(parse_tree("k[f[kk]]"))


def nystrom_trees(order):
    return [t for t in trees(order, SEPARABLE) if is_nystrom(t)]


def test_there_are_as_many_trees_as_nystrom_series_have():
    # Hairer, Norsett, Wanner (1993), section II.14: conditions for y' at orders 1, 2, ..
    counts = [1, 1, 2, 3, 6, 10, 20]
    by_root = {
        root: [sum(t.colour == root for t in nystrom_trees(n)) for n in range(1, 8)]
        for root in "kf"
    }
    assert by_root["k"] == counts
    assert by_root["f"] == [1, *counts[:-1]]  # f has one child at most


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
    assert found.failing_tree.order == nystrom + 1


def test_one_weight_off_and_the_order_is_lost():
    good = load("forest-ruth-4")
    a, b = list(good.B[0]), list(good.B_hat[0])
    b[0], b[1] = b[1], b[0]
    assert nystrom_order_of(splitting(a, b)).order == 1


def test_shared_stages_and_no_end_of_the_search():
    found = nystrom_order_of(load("lobatto-iiia-iiib-3"))  # q' = p, p' = k(q, p)
    assert (found.order, str(found.failing_tree)) == (4, "f[k[fff]]")
    assert nystrom_order_of(load("stormer-verlet"), 1).at_least


def test_other_pairs_cannot_claim_row_sums():
    doc = copy.deepcopy(dict(document("stormer-verlet")))
    with pytest.raises(DataError, match="row-sums"):
        load_document({**doc, "claims": {"row-sums": True}})
    for name in ("stormer-verlet", "ruth-3", "pair-4-4"):
        method: Any = load(name)
        assert facts_for(method).judge("row-sums", True).verdict is Verdict.OPEN
        assert known_beside(facts_for(method), "row-sums").truth is not False
