"""Exchanges of stages by backtracking: those that the judge tries are those that finders propose."""

import random
from itertools import permutations
from threading import Thread
from time import thread_time
from types import SimpleNamespace

import pytest

from glmref.errors import BudgetError
from glmref.exact import Ball, exact
from glmref.exact.judging import as_numbers, consulted
from glmref.exact.linalg import identity, zeros
from glmref.system.budget import limited


def M(*rows):
    return tuple(tuple(exact(x) for x in row) for row in rows)


def involutions(*blocks):
    """Return all P with A + P A P = target; of two blocks those of stages Q and P in one list."""
    with consulted() as judge:
        parts = {
            colour: judge.document.Component(
                *map(as_numbers, (A, identity(len(A)), target, identity(len(A))))
            )
            for colour, (A, target) in zip("o" if len(blocks) == 1 else "fk", blocks, strict=True)
        }
        method = SimpleNamespace(parts=parts, separable=len(blocks) > 1)
        return list(map(tuple, judge.rules_symmetry.Search(method).found()))


def is_own_inverse(p):
    return all(p[x] == i for i, x in enumerate(p))


def test_where_all_stages_are_equal_all_involutions_come():
    found = involutions((zeros(4, 4), zeros(4, 4)))
    expected = set(filter(is_own_inverse, permutations(range(4))))
    assert set(found) == expected and len(found) == len(expected)


def test_the_mirror_image_is_tried_first_and_no_two_places_are_compared_twice(monkeypatch):
    assert involutions((zeros(5, 5), zeros(5, 5)))[0] == (4, 3, 2, 1, 0)
    nil = (zeros(3, 3), zeros(3, 3))
    assert involutions(nil, nil)[0] == (2, 1, 0, 5, 4, 3)
    with consulted() as judge:
        asked = []
        may_vanish = judge.rules_symmetry.may_vanish
        monkeypatch.setattr(
            judge.rules_symmetry, "may_vanish", lambda x: asked.append(x) or may_vanish(x)
        )
    involutions((zeros(6, 6), zeros(6, 6)))
    assert len(asked) <= 6**4


def test_a_search_of_places_that_are_known_ends_with_its_budget():
    told = []

    def search():  # in a thread, where no signal ends it
        try:
            with limited(0.2):
                involutions((zeros(16, 16), zeros(16, 16)))
        except BudgetError:
            told.append(thread_time())

    thread = Thread(target=search)
    thread.start()
    thread.join()
    assert told and told[0] < 1


def test_stages_of_the_halves_of_a_separable_pair_are_not_mixed():
    nil = (zeros(2, 2), zeros(2, 2))
    assert set(involutions(nil, nil)) == {(0, 1, 2, 3), (1, 0, 2, 3), (0, 1, 3, 2), (1, 0, 3, 2)}


def test_a_relation_selects_the_permutation():
    A = M([1, 0, 0], [0, 2, 0], [0, 0, 3])
    assert involutions((A, M([3, 0, 0], [0, 3, 0], [0, 0, 6]))) == [
        (1, 0, 2)
    ]  # 1 + 2, 2 + 1, 3 + 3
    assert involutions((A, zeros(3, 3))) == []


@pytest.mark.parametrize("n", [3, 4, 5])
def test_involutions_are_those_of_a_search_of_all_permutations(n):
    draw = random.Random(n)
    every = list(filter(is_own_inverse, permutations(range(n))))
    for entries in ((0, 1), (1, 1, 1, 2), (5,)):
        A = M(*([draw.choice(entries) for _ in range(n)] for _ in range(n)))
        P = draw.choice(every)
        target = tuple(tuple(A[i][j] + A[P[i]][P[j]] for j in range(n)) for i in range(n))
        found = involutions((A, target))
        expected = {
            p for p in every
            if all(A[i][j] + A[p[i]][p[j]] == target[i][j] for i in range(n) for j in range(n))
        }  # fmt: skip
        assert set(found) == expected and len(found) == len(expected) and P in expected


def test_what_decimals_leave_open_is_not_excluded():
    wide = ((Ball.decimal("1.0", 1), exact(0)), (exact(0), Ball.decimal("2.0", 1)))
    assert involutions((wide, M([2, 0], [0, 4]))) == [(0, 1)]
    assert involutions((wide, M([3, 0], [0, 3]))) == [(1, 0)]
