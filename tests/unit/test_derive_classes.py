"""Trees up to stage order, and the theorems on which conditions follow."""

import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import pytest

from glmref.errors import DataError
from glmref.exact.judging import Fraction as rational
from glmref.exact.judging import consulted, fast_judge
from glmref.judge.classes import conditions_follow, cut_classes, pairs_of, plan, reduced
from glmref.judge.refusals import Refused
from glmref.judge.trees import attach, read_tree
from glmref.prove.enclosure import conditions_of
from glmref.prove.equations import free_trees, representatives
from glmref.theory.trees import Tree, free_tree, halves, tree, trees
from tests.build import refused


def follows(order: int, q: int, given: Sequence[str]) -> bool:
    """What the judge says of the conditions of an odd order, with the free trees of the finder."""
    free = {n: tuple(map(read_tree, free_trees(n, q))) for n in range(2, order, 2)}
    return conditions_follow(order, q, set(map(read_tree, given)), free)


def versions_of(t: Tree) -> tuple[Tree, ...]:
    """All rooted versions of the free tree under a rooted tree, in ascending order."""
    return tuple(sorted(free_tree(t).signs, key=lambda x: x.key))


def free_trees_of(order: int) -> list[tuple[Tree, ...]]:
    """The free trees of an order, each as the tuple of its rooted versions."""
    return list(dict.fromkeys(versions_of(t) for t in trees(order)))


def test_free_trees_are_counted() -> None:
    # Otter (1948): 1, 1, 1, 2, 3, 6, 11, 23 free trees.
    assert [len(free_trees_of(n)) for n in range(1, 9)] == [1, 1, 1, 2, 3, 6, 11, 23]


def test_numbers_of_conditions_are_those_of_the_table() -> None:
    table = {1: [1, 1, 3, 11], 2: [1, 0, 1, 3], 3: [1, 0, 1, 1], 4: [1, 0, 0, 1]}
    for q, counts in table.items():
        assert [len(representatives(n, q)) for n in (1, 3, 5, 7)] == counts


def test_at_stage_order_1_each_free_tree_needs_one_condition() -> None:
    for n in (3, 5, 7):
        assert len(representatives(n, 1)) == len(free_trees_of(n))
        chosen = [str(versions[-1]) for versions in free_trees_of(n)]  # any version will do
        assert follows(n, 1, chosen)
        assert not follows(n, 1, chosen[1:])


def test_free_principal_parts_belong_to_free_trees_that_are_not_superfluous() -> None:
    for n, superfluous in ((2, 1), (4, 1), (6, 2)):
        free = free_trees(n, 1)
        assert len(free) == len(free_trees_of(n)) - superfluous
        assert not plan(n, 1, tuple(map(read_tree, free)))[1], "a pair is left over"


def test_at_stage_order_3_one_tree_of_order_7_is_enough() -> None:
    assert follows(7, 3, ["[oooooo]"])
    assert not follows(7, 3, [])
    assert not follows(7, 2, ["[oooooo]"])


def test_a_principal_part_that_follows_cannot_be_given() -> None:
    # [o[o]] is superfluous: half of a square
    for q, text in ((1, "[o[o]]"), (2, "[ooo]")):
        assert text not in free_trees(4, q, (text,))
        refused(Refused, "not free", plan, 4, q, (read_tree(text),))
    document = sweep_of(1, symmetric=True)
    document["enclosure"]["xi"] = {"[o[o]]": "1/2"}
    refused(DataError, "not free", conditions_of, document)


# The theorems on random methods, exactly.

_HALF = Fraction(1, 2)


def sweep_of(seed: int, *, symmetric: bool) -> dict[str, Any]:
    """A consistent G-symplectic method of four stages and rational entries; x = 1/7 is unknown."""
    numbers = random.Random(seed)

    def number() -> Fraction:
        return Fraction(numbers.randint(-6, 6) or 1, 6)

    b = [number(), number()]
    D = [b[0], _HALF - b[0], _HALF - b[0], b[0]]
    if not symmetric:
        D = [b[0], b[1], number(), Fraction(0)]
        D[3] = 1 - sum(D, Fraction(0))
    rows = []
    for parity in (-1, 1, 1):
        u, v = number(), number()
        rows.append([u, v, parity * v, parity * u] if symmetric else [u, v, number(), number()])
    texts = [[str(x) for x in row] for row in rows]
    texts[0][0] += "+7*x-1"
    return {
        "class": "sweep", "unknowns": {"x": ""}, "D": list(map(str, D)), "X": [["1"] * 4, *texts],
        "V": [["1", "0", "0", "0"], ["0", "0", "-1", "0"], ["0", "1", "0", "0"],
              ["0", "0", "0", "-1"]],
        "G": ["1", "-1", "-1", "1"], "enclosure": {"equations": []}, "claims": {"order": 6},
    }  # fmt: skip


def series_of(document: dict[str, Any], order: int, change: int = 0) -> Any:
    """Its series through the residuals of an order; one entry of A may be another."""
    equations = conditions_of(document)
    with consulted() as judge:
        found = judge.enclosed_sweep.ByClasses(equations, [rational(1, 7)])
        found.parts["o"].A[1][0] += change
        found.advance(order)
    return found


def residual(series: Any, t: Any) -> Any:
    """R(t) of a tree or its text."""
    (found,) = series.condition(read_tree(t) if isinstance(t, str) else t)
    return found


def test_moving_the_root_changes_the_sign_of_the_residual() -> None:
    # Order 3 of a method of order 1: R(t*u) + R(u*t) = (E Q)(t, u) - Q(t, u), with Q(o, o) = 0.
    for seed in range(6):
        series = series_of(sweep_of(seed, symmetric=False), 3)
        assert residual(series, "o") == residual(series, "[o]") == 0  # the latter is superfluous
        assert residual(series, "[oo]") == -residual(series, "[[o]]") != 0


def test_zeta_1_makes_every_pair_defect_zero() -> None:
    dot, apply = fast_judge().linalg.dot, fast_judge().linalg.apply
    for seed in range(3):
        series = series_of(sweep_of(seed, symmetric=True), 6)
        for n in (2, 4):
            for t, u in pairs_of(n, 1):
                both = series.eta[attach(t, u)][0] + series.eta[attach(u, t)][0]
                assert dot(series.eta[t], apply(series.G, series.eta[u])) == both


def test_identity_of_order_3_holds_for_symmetric_methods() -> None:
    for seed in range(4):
        series = series_of(sweep_of(seed, symmetric=True), 4)
        for t, u in pairs_of(3, 1):
            assert residual(series, attach(t, u)) == -residual(series, attach(u, t))
        assert residual(series, "[o]") == 0


def test_without_g_symplecticity_the_conditions_are_independent() -> None:
    # The near miss: one entry of A changed, and moving the root no longer helps.
    series = series_of(sweep_of(1, symmetric=False), 3, change=1)
    assert residual(series, "[o]") != 0
    assert residual(series, "[oo]") != -residual(series, "[[o]]")


def test_neighbouring_roots_are_mutual() -> None:
    for n in range(2, 7):
        for version in trees(n):
            for t, u in halves(version):
                assert t * u is version
                assert any(w * v is version for v, w in halves(u * t))


def test_cutting_respects_the_relations_of_stage_order() -> None:
    # [o] - oo/2 goes to itself: what makes the reduction legitimate.
    for q, low, leaves, factor in ((2, "[o]", "oo", _HALF), (3, "[oo]", "ooo", Fraction(1, 3))):
        left, right = (cut_classes(read_tree(f"[o{x}]"), q) for x in (low, leaves))
        assert left == {t: x * factor for t, x in right.items()}


def weights_of_cuts(t: Tree, q: int) -> dict[Any, Fraction]:
    """Sum of the product of 1 / gamma over what is cut off, by the class of what is kept."""

    def kept_with(child: Tree) -> dict[Tree | None, Fraction]:
        found: dict[Tree | None, Fraction] = {None: Fraction(1, child.density)}
        return found | grown(child)  # type: ignore[operator]

    def grown(t: Tree) -> dict[Tree, Fraction]:
        ways: dict[tuple[Tree, ...], Fraction] = {(): Fraction(1)}
        for child in t.children:
            wider: dict[tuple[Tree, ...], Fraction] = {}
            for kept, weight in ways.items():
                for more, factor in kept_with(child).items():
                    key = kept if more is None else (*kept, more)
                    wider[key] = wider.get(key, Fraction(0)) + weight * factor
            ways = wider
        found: dict[Tree, Fraction] = {}
        for kept, weight in ways.items():
            whole = tree(kept, t.colour)
            found[whole] = found.get(whole, Fraction(0)) + weight
        return found

    classed: dict[Any, Fraction] = {}
    for kept, weight in grown(t).items():
        below, factor = reduced(read_tree(str(kept)), q)
        classed[below] = classed.get(below, Fraction(0)) + weight * factor
    return classed


@pytest.mark.parametrize("q", [1, 2, 3])
def test_what_a_cut_leaves_weighs_what_the_flow_does_with_the_rest(q: int) -> None:
    for n in range(1, 6):
        for t in trees(n):
            assert cut_classes(read_tree(str(t)), q) == weights_of_cuts(t, q), t


def test_a_condition_that_is_given_twice_counts_once() -> None:
    for n, q in ((5, 1), (5, 2), (7, 2)):
        chosen = list(representatives(n, q))
        assert follows(n, q, [*chosen, *chosen[:1]])
        assert not follows(n, q, [*chosen[1:], *chosen[1:2]])
