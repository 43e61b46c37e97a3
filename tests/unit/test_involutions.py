"""Stage permutations by backtracking."""

from itertools import permutations

from glmref.exact import exact
from glmref.exact.linalg import zeros
from glmref.theory.involutions import Relation, involutions, matchings


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


def test_matchings_carry_one_matrix_to_another():
    first = M([1, 2, 3], [4, 5, 6], [7, 8, 9])
    order = (2, 0, 1)
    second = tuple(tuple(first[i][j] for j in order) for i in order)
    assert list(matchings([(first, second)], 3)) == [order]
