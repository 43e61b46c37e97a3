"""Stage permutations by backtracking."""

import random
from itertools import permutations
from time import process_time

import pytest

from glmref.errors import BudgetError
from glmref.exact import Ball, exact
from glmref.exact.linalg import zeros
from glmref.system.budget import limited
from glmref.theory.involutions import Relation, involutions


def M(*rows):
    return tuple(tuple(exact(x) for x in row) for row in rows)


def test_without_relations_all_involutions_come_and_the_reversal_first():
    found = list(involutions([], (0, 0, 0, 0)))
    assert found[0] == (3, 2, 1, 0)
    expected = {p for p in permutations(range(4)) if all(p[p[i]] == i for i in range(4))}
    assert set(found) == expected and len(found) == len(expected)


def test_kinds_are_not_mixed():
    assert set(involutions([], (0, 1, 1))) == {(0, 1, 2), (0, 2, 1)}


def test_relation_selects_the_permutation():
    A = M([1, 0, 0], [0, 2, 0], [0, 0, 3])
    target = M([3, 0, 0], [0, 3, 0], [0, 0, 6])  # 1 + 2, 2 + 1, 3 + 3
    assert list(involutions([Relation(A, target, 0, 0)], (0, 0, 0))) == [(1, 0, 2)]
    assert list(involutions([Relation(A, zeros(3, 3), 0, 0)], (0, 0, 0))) == []


@pytest.mark.parametrize("kinds", [(0, 0, 0, 0), (0, 0, 1, 1), (0, 1, 0, 1, 0)])
def test_involutions_are_those_of_a_search_of_all_permutations(kinds):
    draw, n = random.Random(3), len(kinds)
    every = [
        p for p in permutations(range(n)) if all(kinds[k] == kinds[i] for i, k in enumerate(p))
    ]
    for entries in ((0, 1), (1, 1, 1, 2), (5,)):
        A = M(*([draw.choice(entries) for _ in range(n)] for _ in range(n)))
        P = draw.choice([p for p in every if all(p[p[i]] == i for i in range(n))])
        target = tuple(tuple(A[i][j] + A[P[i]][P[j]] for j in range(n)) for i in range(n))
        found = list(involutions([Relation(A, target, 0, 0)], kinds))
        expected = {
            p for p in every if all(p[p[i]] == i for i in range(n))
            and all(A[i][j] + A[p[i]][p[j]] == target[i][j] for i in range(n) for j in range(n))
        }  # fmt: skip
        assert set(found) == expected and len(found) == len(expected) and P in expected


def test_a_relation_of_a_part_looks_at_its_own_stages_only():
    A, target = M([1, 2]), M([4, 6])  # row 2, columns 0 and 1 of the stages 0, 1, 2
    assert list(involutions([Relation(A, M([2, 4]), 2, 0)], (0, 0, 1))) == [(0, 1, 2)]
    assert list(involutions([Relation(A, M([3, 3]), 2, 0)], (0, 0, 1))) == [(1, 0, 2)]
    assert list(involutions([Relation(A, target, 2, 0)], (0, 0, 1))) == []
    wide = ((Ball.decimal("1.0", 1), Ball.decimal("2.0", 1)),)
    opened = list(involutions([Relation(wide, M([2, 4]), 2, 0)], (0, 0, 1)))
    assert opened == [(0, 1, 2)]


@pytest.mark.slow
def test_the_search_ends_with_its_budget() -> None:
    """Two hundred equal stages that no exchange respects but for the last entry."""
    n = 200
    A = tuple(tuple(exact(int((i, j) == (0, 1))) for j in range(n)) for i in range(n))
    target = tuple(tuple(exact(0) for _ in range(n)) for _ in range(n))
    begun = process_time()
    with pytest.raises(BudgetError), limited(0.2):
        list(involutions([Relation(A, target, 0, 0)] * 3, [0] * n))
    assert process_time() - begun < 3
