"""Two-coloured trees up to the position of the root, and the rule for products of flows."""

from fractions import Fraction
from itertools import combinations
from math import factorial

import pytest

from glmref.catalogue.lookup import document
from glmref.judge import lie
from glmref.judge.enclosed_pair import ALTERNATING, all_follow, listed, second_order
from glmref.judge.trees import read_tree, show, versions
from glmref.judge.trees import trees as judged_trees
from glmref.method.component import SEPARABLE
from glmref.method.families import splitting
from glmref.prove import equations
from glmref.theory.trees import free_tree, halves, parse_tree, trees
from tests.bseries import order_residuals


def follows(order, given, kind):
    return all_follow(order, False, frozenset(given), kind)


def one_of_each(order):
    """Return one version of each free tree."""
    return sorted(min(free) for free in {versions(t) for t in listed(order, False)})


def test_moving_the_root_changes_its_colour():
    t = parse_tree("f[kk[f]]")
    for rest, branch in halves(t):
        assert (rest.colour, branch.colour, (branch * rest).colour) == ("f", "k", "k")
        assert rest * branch is t


def test_the_numbers_of_free_trees_with_two_colours():
    numbers = [len(equations.one_of_each(n)) for n in range(1, 8)]
    assert numbers == [2, 1, 2, 3, 6, 10, 22] == [len(one_of_each(n)) for n in range(1, 8)]
    of_second_order = [len(equations.one_of_each(n, nystrom=True)) for n in range(1, 8)]
    assert of_second_order == [2, 1, 2, 2, 4, 5, 10]


def test_free_trees_divide_the_rooted_ones():
    for n in range(1, 7):
        chosen = map(parse_tree, equations.one_of_each(n))
        rooted = [read_tree(str(v)) for t in chosen for v in free_tree(t).signs]
        assert sorted(rooted) == sorted(read_tree(str(t)) for t in trees(n, SEPARABLE))
        assert all(len({second_order(v) for v in versions(t)}) == 1 for t in rooted)


def test_words_count_the_orders_with_children_first():
    assert lie.colour_words(read_tree("f[kk[f]]")) == {"kfkf": 1, "fkkf": 2}
    for t in (t for n in range(1, 6) for t in judged_trees(ALTERNATING, n)):
        one = parse_tree(show(t))
        assert sum(lie.colour_words(t).values()) == factorial(one.order) // one.density


def test_the_logarithm_of_a_verlet_step():
    third = {w: a for w, a in lie.verlet_logarithm(3, "f").items() if len(w) == 3}
    # A + B - [A, [A, B]]/24 - [B, [A, B]]/12 + ..
    assert (third["ffk"], third["kkf"]) == (Fraction(-1, 24), Fraction(1, 12))
    assert all(len(w) % 2 for w in lie.verlet_logarithm(6, "f"))  # symmetric: odd degrees only
    swap = str.maketrans("fk", "kf")
    swapped = {w.translate(swap): a for w, a in lie.verlet_logarithm(5, "f").items()}
    assert swapped == lie.verlet_logarithm(5, "k")


@pytest.mark.parametrize(("order", "needed"), [(3, 2), (5, 6), (7, 18)])
def test_residuals_of_a_splitting_lie_in_the_image_of_the_lie_algebra(order, needed):
    every = one_of_each(order)
    assert len(every) >= needed
    assert follows(order, every, "splitting")
    if order < 7:
        assert not any(follows(order, set(every) - {t}, "splitting") for t in every)


def test_the_residuals_of_a_verlet_step_are_the_image_of_its_logarithm():
    verlet = splitting(["1/2", "1/2"], [1])
    found = {t: x for t, x in order_residuals(verlet, 3).items() if t.order == 3}
    logarithm = {w: a for w, a in lie.verlet_logarithm(3, "f").items() if len(w) == 3}
    for t in trees(3, SEPARABLE):
        words = lie.colour_words(read_tree(str(t)))
        assert found[t] == sum(n * logarithm.get(w, 0) for w, n in words.items()), t


@pytest.mark.parametrize(("order", "needed"), [(3, 1), (5, 2)])
@pytest.mark.parametrize("kind", ["f", "k"])
def test_compositions_of_verlet_need_1_and_2_conditions(order, needed, kind):
    every = one_of_each(order)
    assert any(follows(order, x, kind) for x in combinations(every, needed))
    assert not any(follows(order, x, kind) for x in combinations(every, needed - 1))


def test_compositions_of_verlet_need_4_conditions_of_order_7():
    texts = [x.split()[1] for x in document("kahan-li-8")["enclosure"]["equations"]]
    chosen = {t for t in map(read_tree, texts) if parse_tree(show(t)).order == 7}
    assert len(chosen) == 4
    assert follows(7, chosen, "f")
    assert not any(follows(7, chosen - {t}, "f") for t in chosen)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("kind", ["splitting", "f", "k"])
def test_images_are_sums_over_the_words_of_a_tree(order, kind):
    for t in one_of_each(order):
        words = lie.colour_words(t)
        elements = lie.lie_elements(order, kind)
        sums = [sum(x * words.get(w, 0) for w, x in element.items()) for element in elements]
        assert lie.lie_images(t, kind) == sums


def test_a_bracket_is_the_difference_of_both_products():
    x, y = {"f": Fraction(2), "fk": Fraction(1)}, {"k": Fraction(3)}

    def bracket(x, y):
        return lie.word_sum(lie.word_product(x, y, 4), lie.word_product(y, x, 4), -1)

    assert bracket(x, y) == {"fk": 6, "kf": -6, "fkk": 3, "kfk": -3}
    assert bracket(x, x) == {} and bracket(x, {}) == {}
