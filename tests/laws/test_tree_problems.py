"""A method that is wrong at exactly one tree is wrong on the problem of that tree, and only there.

Everything is exact: the right-hand sides are polynomials with whole coefficients, the methods and
steps are fractions.
"""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import glmref
from glmref.exchange.tree_problems import KINDS, TreeProblem, tree_problem, tree_problems
from glmref.method.component import SEPARABLE
from glmref.theory.trees import Tree, trees, trees_up_to
from tests.examples import examples

ORDER = 4
Row = list[Fraction]


@cache
def of_order(kind: str, n: int) -> list[TreeProblem]:
    return [x for x in tree_problems(n) if x.kind == kind and x.tree.order == n]


def stage_weights(t: Tree, blocks: dict[str, list[Row]]) -> Row:
    """The product over the children of the rows of their colour times their stage weights, (s,)."""
    found = [Fraction(1)] * len(blocks["o"])
    for child in t.children:
        inner = stage_weights(child, blocks)
        for i, row in enumerate(blocks[child.colour]):
            found[i] *= sum(a * w for a, w in zip(row, inner, strict=True))
    return found


def solved(rows: list[Row], right: Row) -> Row | None:
    """The solution with zeros where the rows leave a choice, or None where there is none."""
    rows, pivots = [[*row, x] for row, x in zip(rows, right, strict=True)], []
    for n, row in enumerate(rows):
        j = next((j for j, x in enumerate(row[:-1]) if x), None)
        if j is None:
            return None
        pivots.append(j)
        rows[n] = row = [x / row[j] for x in row]
        for m, other in enumerate(rows):
            if m != n and other[j]:
                rows[m] = [x - other[j] * y for x, y in zip(other, row, strict=True)]
    found = [Fraction(0)] * len(right if not rows else rows[0][:-1])
    for j, row in zip(pivots, rows, strict=True):
        found[j] = row[-1]
    return found


def run(A: dict[str, list[Row]], b: dict[str, Row], problem: TreeProblem, steps: int) -> Row:
    """The state at t = 1 after explicit steps; the components of each colour have their own A, b."""
    code = [compile(text, "f", "eval") for text in problem.f]
    d, s, h = len(code), len(b["o"]), Fraction(1, steps)
    half = d // 2
    colour = ["o" if problem.kind != "separable" else "f" if k < half else "k" for k in range(d)]
    y = [Fraction(0)] * d
    for n in range(steps):
        slopes: list[Row] = []
        for i in range(s):
            moved = [
                y[k]
                + h * sum(A[colour[k]][i][j] * slopes[j][k] for j in range(i) if A[colour[k]][i][j])
                for k in range(d)
            ]
            t = h * n + h * sum(A["o"][i])
            slopes.append([Fraction(eval(x, {"y": moved, "t": t})) for x in code])
        y = [y[k] + h * sum(b[colour[k]][i] * slopes[i][k] for i in range(s)) for k in range(d)]
    return y


def error(A: dict[str, list[Row]], b: dict[str, Row], problem: TreeProblem, steps: int) -> Row:
    exact = problem.solution(Fraction(1))
    return [x - z for x, z in zip(run(A, b, problem, steps), exact, strict=True)]


def lower_triangle(data: st.DataObject, s: int) -> list[Row]:
    entry = st.integers(-6, 6).map(lambda x: Fraction(x, 4))
    return [[data.draw(entry) if j < i else Fraction(0) for j in range(s)] for i in range(s)]


def with_weights(
    listed: list[Tree], blocks: dict[str, list[Row]], wrong: Tree, by: Fraction
) -> Row:
    """Weights b right at all the trees, but for one, where the elementary weight is off."""
    rows = [stage_weights(t, blocks) for t in listed]
    right = [Fraction(1, t.density) + (by if t is wrong else 0) for t in listed]
    found = solved(rows, right)
    assume(found is not None)
    assert found is not None
    return found


def assert_shown_by_its_own(
    problem: TreeProblem, wrong: Tree, by: Fraction,
    A: dict[str, list[Row]], b: dict[str, Row], steps: int,
) -> None:  # fmt: skip
    """The problem of the tree that is wrong has its error in one place, the others have none."""
    once, more = (error(A, b, problem, n) for n in (1, steps))
    if problem.tree is wrong:
        # order 3 in place of 4: the error of n steps is n (1/n)^4 times that of the tree
        assert (once[problem.shows], more[problem.shows]) == (by, by / steps**3)
        once[problem.shows] = more[problem.shows] = Fraction(0)
    assert not any(once) and not any(more), problem.name


@given(data=st.data())
@examples(15)
def test_a_method_wrong_at_one_tree_shows_it_on_that_problem_only(data: st.DataObject) -> None:
    wrong = data.draw(st.sampled_from(trees(ORDER)))
    by = Fraction(data.draw(st.integers(1, 5)), 7)
    A = {"o": lower_triangle(data, 9)}
    b = {"o": with_weights(list(trees_up_to(ORDER)), A, wrong, by)}
    for kind in ("autonomous", "timed", "stiff"):
        for problem in of_order(kind, ORDER):
            assert_shown_by_its_own(problem, wrong, by, A, b, 4)


@given(data=st.data())
@examples(10)
def test_a_pair_wrong_at_one_tree_shows_it_on_that_problem_only(data: st.DataObject) -> None:
    wrong = data.draw(st.sampled_from(trees(ORDER, SEPARABLE)))
    by = Fraction(data.draw(st.integers(1, 5)), 7)
    A = {"f": lower_triangle(data, 9), "k": lower_triangle(data, 9)}
    A["o"] = A["f"]
    listed = trees_up_to(ORDER, SEPARABLE)
    b = {root: with_weights([t for t in listed if t.colour == root], A, wrong, by) for root in "fk"}
    b["o"] = b["f"]
    for problem in of_order("separable", ORDER):
        assert_shown_by_its_own(problem, wrong, by, A, b, 2)


def test_the_set_has_each_tree_in_each_kind() -> None:
    found = list(tree_problems())
    assert len({x.name for x in found}) == len(found) == 37 + 36 + 36 + 2 * 37
    for kind in KINDS:
        assert {x.linear for x in found if x.kind == kind} == {True, False}
    linear = [
        str(x.tree) for x in found if x.linear and x.kind == "autonomous" and x.tree.order == 5
    ]
    assert linear == ["[[[[o]]]]"]  # of an autonomous linear system only the tree without branches


@pytest.mark.slow
@pytest.mark.parametrize("name", ["autonomous-[o[oo]]", "timed-[[[oo]]]", "autonomous-[oooo]"])
def test_rk4_has_order_4_on_the_problems_of_its_residuals(name: str) -> None:
    kind, _, tree = name.partition("-")
    shown = tree_problem(tree, kind)
    method = glmref.load("rk4")
    ends = [glmref.solve(shown.problem, method, h=1 / n, steps=n).y[-1] for n in (4, 8)]
    exact = np.array([float(x) for x in shown.solution(Fraction(1))])
    coarse, fine = (abs(y - exact)[shown.shows] for y in ends)
    assert coarse > 1e-5 and coarse / fine == pytest.approx(16, rel=1e-9)


@pytest.mark.slow
def test_a_separable_problem_is_solved_as_one() -> None:
    shown = tree_problem("f[k[ff]]", "separable")
    assert shown.problem.separable
    end = glmref.solve(shown.problem, "forest-ruth-4", h=1 / 8, steps=8).y[-1]
    assert end == pytest.approx([float(x) for x in shown.solution(Fraction(1))], abs=1e-14)
