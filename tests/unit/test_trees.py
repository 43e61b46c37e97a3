"""Trees: counts, weights, text form, cuts."""

import copy
import pickle
from math import factorial

import pytest

from glmref.errors import UsageError
from glmref.method.component import GENERAL, ROOTED, SEPARABLE
from glmref.theory.trees import (
    Tree,
    parse_tree,
    pruned,
    single,
    tree,
    trees,
    trees_up_to,
)
from tests.build import refused

PALETTES = [ROOTED, GENERAL, SEPARABLE]


def test_numbers_of_rooted_trees_to_order_12():
    # OEIS A000081
    counts = [len(trees(n)) for n in range(1, 13)]
    assert counts == [1, 1, 2, 4, 9, 20, 48, 115, 286, 719, 1842, 4766]
    assert len(trees_up_to(12)) == 7813


def test_numbers_of_two_coloured_trees():
    # OEIS A038055; with alternating colours a tree is its shape and the colour of its root
    assert [len(trees(n, GENERAL)) for n in range(1, 7)] == [2, 4, 14, 52, 214, 916]
    assert [len(trees(n, SEPARABLE)) for n in range(1, 7)] == [2, 2, 4, 8, 18, 40]


def test_order_density_symmetry_of_the_trees_of_order_4():
    # Butcher (2016), table 301(I)
    table = {"[ooo]": (4, 6), "[o[o]]": (8, 1), "[[oo]]": (12, 2), "[[[o]]]": (24, 1)}
    assert [str(t) for t in trees(4)] == list(table)
    assert {str(t): (t.density, t.symmetry) for t in trees(4)} == table


def test_density_of_a_tree_with_equal_branches():
    t = parse_tree("[[oo][oo]o]")
    assert (t.order, t.density, t.symmetry) == (8, 8 * 3 * 3, 2 * 2 * 2)


@pytest.mark.parametrize("n", range(1, 9))
def test_monotone_labellings_add_up(n):
    # vertex m + 1 can hang on any of the m before it
    assert sum(t.labellings for t in trees(n)) == factorial(n - 1)


@pytest.mark.parametrize("palette", PALETTES)
def test_text_form_reads_back_to_the_same_object(palette):
    for t in trees_up_to(5, palette):
        assert parse_tree(str(t)) is t


@pytest.mark.parametrize("palette", PALETTES)
def test_listing_is_sorted_and_has_no_tree_twice(palette):
    for n in range(1, 6):
        level = trees(n, palette)
        assert list(level) == sorted(level, key=lambda t: t.key)
        assert len(set(level)) == len(level)


def test_alternating_colours():
    assert {str(t) for t in trees(3, SEPARABLE)} == {"f[kk]", "f[k[f]]", "k[ff]", "k[f[k]]"}


def test_a_tree_cannot_be_changed_or_made_by_hand():
    with pytest.raises(AttributeError, match="immutable"):
        single().order = 2  # type: ignore[misc]
    with pytest.raises(AttributeError, match="immutable"):
        del single().order
    assert Tree("[[o]o]") is Tree("[o]") * Tree("[o]") is parse_tree("[o[o]]")
    refused(UsageError, "colour", tree, [], "green")


def test_copies_are_the_same_object():
    t = parse_tree("f[k[ff]k]")
    assert copy.copy(t) is t
    assert copy.deepcopy(t) is t
    assert pickle.loads(pickle.dumps(t)) is t


def test_growth_from_the_root_counts_linear_extensions():
    for t in trees_up_to(8):
        assert pruned(t)[single()] == factorial(t.order) // t.density
