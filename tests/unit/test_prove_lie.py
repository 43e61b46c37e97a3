"""Two-coloured trees up to the position of the root, and the rule for products of flows."""

from fractions import Fraction
from itertools import combinations

import pytest

from glmref.catalogue.lookup import document
from glmref.method.component import SEPARABLE
from glmref.method.families import splitting
from glmref.prove.classes import Family, attach, free_tree, moves, representatives, second_order
from glmref.prove.lie import (
    SPLITTING,
    VERLET_F,
    VERLET_K,
    bracket,
    images,
    lie_basis,
    spans,
    verlet_logarithm,
    words,
)
from glmref.theory.trees import parse_tree, trees
from tests.bseries import order_residuals


def test_moving_the_root_changes_its_colour():
    t = parse_tree("f[kk[f]]")
    for rest, branch, other in moves(t):
        assert (rest.colour, branch.colour, other.colour) == ("f", "k", "k")
        assert attach(rest, branch) is t
        assert attach(branch, rest) is other


def test_the_numbers_of_free_trees_with_two_colours():
    assert [len(representatives(n, 1, Family.SEPARABLE)) for n in range(1, 8)] == [
        2,
        1,
        2,
        3,
        6,
        10,
        22,
    ]
    of_second_order = [len(representatives(n, 1, Family.SECOND_ORDER)) for n in range(1, 8)]
    assert of_second_order == [2, 1, 2, 2, 4, 5, 10]


def test_free_trees_divide_the_rooted_ones():
    for n in range(1, 7):
        versions = [v for t in representatives(n, 1, Family.SEPARABLE) for v in free_tree(t)]
        assert sorted(map(str, versions)) == sorted(map(str, trees(n, SEPARABLE)))
        assert all(second_order(v) == second_order(free_tree(v)[0]) for v in versions)


def test_words_count_the_orders_with_children_first():
    assert words(parse_tree("f[kk[f]]")) == {"kfkf": 1, "fkkf": 2}
    for n in range(1, 6):
        assert all(sum(words(t).values()) == t.extensions for t in trees(n, SEPARABLE))


def test_dimensions_of_the_lie_algebras():
    # necklace polynomials for two letters; Yoshida (1990) for compositions: 1, 1, 2, 4
    assert [len(lie_basis(n, SPLITTING)) for n in range(1, 8)] == [2, 1, 2, 3, 6, 9, 18]
    assert [len(lie_basis(n, VERLET_F)) for n in (1, 3, 5, 7)] == [1, 1, 2, 4]


def test_the_logarithm_of_a_verlet_step():
    third = {w: a for w, a in verlet_logarithm(3).items() if len(w) == 3}
    # A + B - [A, [A, B]]/24 - [B, [A, B]]/12 + ..
    assert (third["ffk"], third["kkf"]) == (Fraction(-1, 24), Fraction(1, 12))
    assert all(len(w) % 2 for w in verlet_logarithm(6))  # symmetric: odd degrees only
    swapped = {w.translate(str.maketrans("fk", "kf")): a for w, a in verlet_logarithm(5).items()}
    assert swapped == verlet_logarithm(5, "k")


@pytest.mark.parametrize(("order", "needed"), [(3, 2), (5, 6), (7, 18)])
def test_residuals_of_a_splitting_lie_in_the_image_of_the_lie_algebra(order, needed):
    rows = list(images(order, SPLITTING).values())
    assert len(rows) >= needed
    all_trees = list(images(order, SPLITTING))
    assert spans(order, all_trees, SPLITTING)
    if order < 7:
        assert not any(
            spans(order, [t for t in all_trees if t is not left], SPLITTING) for left in all_trees
        )


def test_the_residuals_of_a_verlet_step_are_the_image_of_its_logarithm():
    verlet = splitting(["1/2", "1/2"], [1])
    found = {t: x for t, x in order_residuals(verlet, 3).items() if t.order == 3}
    logarithm = {w: a for w, a in verlet_logarithm(3).items() if len(w) == 3}
    for t in trees(3, SEPARABLE):
        image = sum((n * logarithm.get(w, 0) for w, n in words(t).items()), Fraction(0))
        assert found[t] == image, t


@pytest.mark.parametrize(("order", "needed"), [(3, 1), (5, 2)])
@pytest.mark.parametrize("kind", [VERLET_F, VERLET_K])
def test_compositions_of_verlet_need_1_and_2_conditions(order, needed, kind):
    candidates = list(representatives(order, 1, Family.SEPARABLE))
    assert any(spans(order, x, kind) for x in combinations(candidates, needed))
    assert not any(spans(order, x, kind) for x in combinations(candidates, needed - 1))


def test_compositions_of_verlet_need_4_conditions_of_order_7():
    texts = [x.split()[1] for x in document("kahan-li-8")["enclosure"]["equations"]]
    chosen = [t for t in map(parse_tree, texts) if t.order == 7]
    assert len(chosen) == 4
    assert spans(7, chosen, VERLET_F)
    assert not any(spans(7, [t for t in chosen if t is not left], VERLET_F) for left in chosen)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("kind", [SPLITTING, VERLET_F, VERLET_K])
def test_images_are_sums_over_the_words_of_a_tree(order, kind):
    for t, row in images(order, kind).items():
        counted = dict(words(t))
        expected = [
            sum((x * counted[w] for w, x in element.items() if w in counted), Fraction(0))
            for element in lie_basis(order, kind)
        ]
        assert list(row) == expected


def test_a_bracket_is_the_difference_of_both_products():
    x, y = {"f": Fraction(2), "fk": Fraction(1)}, {"k": Fraction(3)}
    assert bracket(x, y) == {"fk": 6, "kf": -6, "fkk": 3, "kfk": -3}
    assert bracket(x, x) == {} and bracket(x, {}) == {}
