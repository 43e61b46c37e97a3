"""Trees: counts, weights, text form, cuts."""

from math import factorial

import pytest

from glmref.errors import UsageError
from glmref.method.component import GENERAL, ROOTED, SEPARABLE
from glmref.theory.trees import Tree, parse_tree, pruned, single, tree, trees, trees_up_to
from tests.build import refused

PALETTES = [ROOTED, GENERAL, SEPARABLE]


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


def test_a_tree_cannot_be_changed_or_made_by_hand():
    with pytest.raises(AttributeError, match="immutable"):
        single().order = 2  # type: ignore[misc]
    with pytest.raises(AttributeError, match="immutable"):
        del single().order
    assert Tree("[[o]o]") is Tree("[o]") * Tree("[o]") is parse_tree("[o[o]]")
    refused(UsageError, "colour", tree, [], "green")


def test_growth_from_the_root_counts_linear_extensions():
    for t in trees_up_to(8):
        assert pruned(t)[single()] == factorial(t.order) // t.density
