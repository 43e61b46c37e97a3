"""Trees up to stage order, and the theorems on which conditions follow."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import pytest

from glmref.errors import DataError
from glmref.exact import Exact, linalg
from glmref.exact.linalg import Matrix
from glmref.judge import trees as judge_trees
from glmref.judge.classes import conditions_follow
from glmref.method.component import Component
from glmref.method.sweep import SweepForm
from glmref.prove.classes import (
    Family,
    _cuts,
    _identities,
    classes,
    pairs,
    plan,
    reduce_tree,
    representatives,
)
from glmref.prove.equations import Series, starting_series
from glmref.theory.trees import Tree, free_tree, halves, parse_tree, pruned, tree, trees


def follows(order: int, q: int, given: Sequence[Tree]) -> bool:
    """What the judge says of the conditions of an odd order, with the free trees of the finder."""
    read = judge_trees.read_tree
    free = {n: tuple(read(str(t)) for t in plan(n, q).free) for n in range(2, order, 2)}
    return conditions_follow(order, q, {read(str(t)) for t in given}, free)


def versions_of(t: Tree) -> tuple[Tree, ...]:
    """All rooted versions of the free tree under a rooted tree, in ascending order."""
    return tuple(sorted(free_tree(t).signs, key=lambda x: x.key))


def free_trees(order: int) -> list[tuple[Tree, ...]]:
    """The free trees of an order, each as the tuple of its rooted versions."""
    return list(dict.fromkeys(versions_of(t) for t in trees(order)))


def test_free_trees_are_counted() -> None:
    # Otter (1948): 1, 1, 1, 2, 3, 6, 11, 23 free trees.
    assert [len(free_trees(n)) for n in range(1, 9)] == [1, 1, 1, 2, 3, 6, 11, 23]


def test_numbers_of_conditions_are_those_of_the_table() -> None:
    table = {1: [1, 1, 3, 11], 2: [1, 0, 1, 3], 3: [1, 0, 1, 1], 4: [1, 0, 0, 1]}
    for q, counts in table.items():
        assert [len(representatives(n, q)) for n in (1, 3, 5, 7)] == counts


def test_at_stage_order_1_each_free_tree_needs_one_condition() -> None:
    for n in (3, 5, 7):
        assert len(representatives(n, 1)) == len(free_trees(n))
        chosen = [versions[-1] for versions in free_trees(n)]  # any version will do
        assert follows(n, 1, chosen)
        assert not follows(n, 1, chosen[1:])


def test_free_principal_parts_belong_to_free_trees_that_are_not_superfluous() -> None:
    for n, superfluous in ((2, 1), (4, 1), (6, 2)):
        assert len(plan(n, 1).free) == len(free_trees(n)) - superfluous
        assert not plan(n, 1).leftover


def test_at_stage_order_3_one_tree_of_order_7_is_enough() -> None:
    assert follows(7, 3, [parse_tree("[oooooo]")])
    assert not follows(7, 3, [])
    assert not follows(7, 2, [parse_tree("[oooooo]")])


@pytest.mark.parametrize(
    ("text", "q", "reduced", "factor"),
    [
        ("[o[o]]", 1, "[o[o]]", Fraction(1)),
        ("[o[o]]", 2, "[ooo]", Fraction(1, 2)),
        ("[o]", 2, "[o]", Fraction(1)),  # the root itself is kept
        ("[[[o]]]", 2, "[[oo]]", Fraction(1, 2)),
        ("[[[o]]]", 3, "[ooo]", Fraction(1, 6)),
        ("[[o][oo]]", 3, "[ooooo]", Fraction(1, 6)),
    ],
)
def test_classes_and_factors(text: str, q: int, reduced: str, factor: Fraction) -> None:
    assert reduce_tree(parse_tree(text), q) == (parse_tree(reduced), factor)


def test_every_tree_is_its_own_class_at_stage_order_1() -> None:
    for n in range(1, 7):
        assert classes(n, 1) == trees(n)


def test_a_principal_part_that_follows_cannot_be_given() -> None:
    with pytest.raises(DataError, match="not free"):
        plan(4, 1, (parse_tree("[o[o]]"),))  # superfluous: half of a square
    with pytest.raises(DataError, match="not free"):
        plan(4, 2, (parse_tree("[ooo]"),))


# The theorems on random methods, exactly.

_HALF = Fraction(1, 2)
_ROTATION: Matrix = tuple(
    tuple(Exact(x) for x in row)
    for row in ((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, -1))
)
_G = linalg.diagonal([Exact(1), Exact(-1), Exact(-1), Exact(1)])


def random_method(seed: int, *, symmetric: bool) -> Component:
    """A consistent G-symplectic method with four stages and rational entries."""
    numbers = random.Random(seed)

    def number() -> Fraction:
        return Fraction(numbers.randint(-6, 6) or 1, 6)

    b = [number(), number()]
    D = [b[0], _HALF - b[0], _HALF - b[0], b[0]]
    if not symmetric:
        D = [b[0], b[1], number(), Fraction(0)]
        D[3] = 1 - sum(D, Fraction(0))
    rows = [[Fraction(1)] * 4]
    for parity in (-1, 1, 1):
        u, v = number(), number()
        rows.append([u, v, parity * v, parity * u] if symmetric else [u, v, number(), number()])
    X = tuple(tuple(Exact(x) for x in row) for row in rows)
    weights = [Exact(x) for x in D]
    word = [("o", i) for i in range(4)]
    (block,) = SweepForm({"o": weights}, {"o": X}, {"o": _ROTATION}, _G, word).blocks
    return block


def series_of(method: Component, order: int) -> Series:
    """Its starting series and residuals."""
    return starting_series([method], _G, order)


def form(series: Series, t: Tree, u: Tree) -> Exact:
    """Q(t, u)."""
    value = linalg.dot(series.zeta[t], linalg.matvec(_G, series.zeta[u]))
    return value - series.zeta[t * u][0] - series.zeta[u * t][0]


def test_moving_the_root_changes_the_sign_of_the_residual() -> None:
    # Order 3 of a method of order 1: R(t*u) + R(u*t) = (E Q)(t, u) - Q(t, u), with Q(o, o) = 0.
    for seed in range(6):
        residual = series_of(random_method(seed, symmetric=False), 3).residual
        assert residual[parse_tree("o")].is_zero()
        assert residual[parse_tree("[o]")].is_zero()  # superfluous
        total = residual[parse_tree("[oo]")] + residual[parse_tree("[[o]]")]
        assert total.is_zero()
        assert not residual[parse_tree("[oo]")].is_zero()


def test_zeta_1_makes_every_pair_defect_zero() -> None:
    for seed in range(3):
        series = series_of(random_method(seed, symmetric=True), 6)
        for n in (2, 4):
            for t, u in pairs(n, 1):
                assert form(series, t, u).is_zero()


def test_identity_of_order_5_holds_with_its_lower_terms() -> None:
    # A symmetric method of order 2: lower residuals do not vanish, so only the pairs whose lower
    # terms do are compared; at order 3 all are.
    for seed in range(4):
        residual = series_of(random_method(seed, symmetric=True), 4).residual
        for t, u in pairs(3, 1):
            assert (residual[t * u] + residual[u * t]).is_zero()
        assert residual[parse_tree("[o]")].is_zero()


def test_without_g_symplecticity_the_conditions_are_independent() -> None:
    # The near miss: one entry of A changed, and moving the root no longer helps.
    blocks = random_method(1, symmetric=False)
    first = (blocks.A[1][0] + 1, *blocks.A[1][1:])
    broken = replace(blocks, A=(blocks.A[0], first, *blocks.A[2:]))
    residual = series_of(broken, 3).residual
    assert not residual[parse_tree("[o]")].is_zero()
    assert not (residual[parse_tree("[oo]")] + residual[parse_tree("[[o]]")]).is_zero()


def test_neighbouring_roots_are_mutual() -> None:
    for n in range(2, 7):
        for version in trees(n):
            for t, u in halves(version):
                assert t * u is version
                assert any(w * v is version for v, w in halves(u * t))


def test_cutting_respects_the_relations_of_stage_order() -> None:
    # [o] - oo/2 goes to itself: what makes the reduction legitimate.
    for q, low, leaves, factor in ((2, "[o]", "oo", _HALF), (3, "[oo]", "ooo", Fraction(1, 3))):
        left, right = parse_tree(f"[o{low}]"), parse_tree(f"[o{leaves}]")
        total: dict[Tree, Fraction] = {}
        for grown, sign in ((left, Fraction(1)), (right, -factor)):
            for kept, ways in pruned(grown).items():
                reduced, times = reduce_tree(kept, q)
                size = grown.order - kept.order
                weight = sign * times * Fraction(ways, _factorial(size))
                total[reduced] = total.get(reduced, Fraction(0)) + weight
        assert all(x == 0 for x in total.values())


def _factorial(n: int) -> int:
    return 1 if n < 2 else n * _factorial(n - 1)


def weights_of_cuts(t: Tree, q: int) -> dict[Tree, Fraction]:
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

    classed: dict[Tree, Fraction] = {}
    for kept, weight in grown(t).items():
        reduced, factor = reduce_tree(kept, q)
        classed[reduced] = classed.get(reduced, Fraction(0)) + weight * factor
    return classed


@pytest.mark.parametrize("q", [1, 2, 3])
def test_what_a_cut_leaves_weighs_what_the_flow_does_with_the_rest(q: int) -> None:
    for n in range(1, 6):
        for t in trees(n):
            assert dict(_cuts(t, q)) == weights_of_cuts(t, q), t


def test_a_condition_that_is_given_twice_counts_once() -> None:
    for n, q in ((5, 1), (5, 2), (7, 2)):
        chosen = list(representatives(n, q))
        assert follows(n, q, [*chosen, *chosen[:1]])
        assert not follows(n, q, [*chosen[1:], *chosen[1:2]])


def without_a_leaf(t: Tree) -> list[Tree]:
    """What is left where one leaf is taken away, once for each leaf; of one vertex nothing."""
    found = []
    for i, child in enumerate(t.children):
        others = (*t.children[:i], *t.children[i + 1 :])
        left = [()] if child.order == 1 else [(x,) for x in without_a_leaf(child)]
        found += [tree((*others, *x)) for x in left]
    return found


@pytest.mark.parametrize(("order", "q"), [(5, 3), (5, 4), (7, 4)])
def test_identities_hold_the_defects_of_pairs_that_lack_a_leaf(order: int, q: int) -> None:
    """(E Q)(t, u) - Q(t, u) one order below: from t or u one vertex is cut, which is a leaf."""
    index, rows = _identities(order, q, Family.ROOTED)
    leftover = [x for x in index if isinstance(x, tuple)]
    assert leftover
    for (t, u), row in zip(pairs(order, q, Family.ROOTED), rows, strict=True):
        expected = dict.fromkeys(leftover, Fraction(0))
        for cut, whole in ((t, u), (u, t)):
            for left in without_a_leaf(cut):
                reduced, factor = reduce_tree(left, q)
                for x in {(reduced, whole), (whole, reduced)} & expected.keys():
                    expected[x] += factor
        assert [-row[index[x]] for x in leftover] == list(expected.values()), (t, u)
