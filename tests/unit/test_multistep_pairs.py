"""Multistep methods for q'' = k(q) as pairs: they are what is printed, and their orders."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest

from glmref import verify
from glmref.catalogue.lookup import load
from glmref.exact import Exact
from glmref.prove.kernel import Kernel
from glmref.theory.coefficients import first_nonzero
from glmref.theory.starting_series import StartingSeries
from glmref.theory.trees import is_nystrom

#: First halves of alpha and beta with their denominators: Quinlan and Tremaine (1990), Quinlan
#: (1999), Hairer, Lubich and Wanner (2006), table XV.7.1.
PRINTED = {
    "quinlan-tremaine-8": ([1, -2, 2, -1, 0], [0, 17671, -23622, 61449, -50516], 12096),
    "quinlan-tremaine-10": (
        [1, -1, 1, -1, 1, -2],
        [0, 399187, -485156, 2391436, -2816732, 4651330],
        241920,
    ),
    "quinlan-tremaine-12": (
        [1, -2, 2, -1, 0, 0, 0],
        [0, 90987349, -229596838, 812627169, -1628539944, 2714971338, -3041896548],
        53222400,
    ),
    "quinlan-tremaine-14": (
        [1, -2, 2, -1, 0, 0, 0, 0],
        [
            0, 433489274083, -1364031998256, 5583113380398, -14154444148720, 28630585332045,
            -42056933842656, 48471792742212,
        ],
        237758976000,
    ),
    "quinlan-8a": ([1, -2, 2, -2, 2], [0, 22081, -29418, 75183, -75212], 15120),
    "quinlan-8b": (
        [1, 0, 0, Fraction(-1, 2), -1],
        [0, 192481, 6582, 816783, -156812],
        120960,
    ),
    "symmetric-multistep-8c": ([1, -1, 0, 0, 0], [0, 13207, -8934, 42873, -33812], 8640),
}  # fmt: skip
#: Coefficients of the backward differences in Störmer's method: Hairer, Norsett and Wanner (1993),
#: table III.10.1.
DIFFERENCES = [
    Fraction(x) for x in ("1", "0", "1/12", "1/12", "19/240", "3/40", "863/12096", "275/4032")
]
#: Those in Cowell's implicit one, of the new force: ibid., table III.10.2.
IMPLICIT = [
    Fraction(x)
    for x in ("1", "-1", "1/12", "0", "-1/240", "-1/240", "-221/60480", "-19/6048")
]  # fmt: skip


def steps(name, forces):
    """The q and the positions of the stages of each step, from arbitrary values.

    ``forces`` holds for each step what the force is at each of its stages.
    """
    m: Any = load(name)
    q, p = m.components
    fractions = [[[x.as_fraction() for x in row] for row in M]
                 for M in (q.A, q.U, q.B, q.V, p.A, p.U, p.B, p.V)]  # fmt: skip
    A, U, B, V, A_p, U_p, B_p, V_p = fractions
    assert U == [[1]] * len(U) and V == [[1]]

    def times(M, x):
        return [sum(a * b for a, b in zip(row, x, strict=True)) for row in M]

    y, z = Fraction(3, 7), [Fraction(k + 2, 5 * k + 3) for k in range(len(V_p))]
    for force in forces:
        velocities = [a + b for a, b in zip(times(A_p, force), times(U_p, z), strict=True)]
        places = [y + x for x in times(A, velocities)]
        y += times(B, velocities)[0]
        z = [a + b for a, b in zip(times(B_p, force), times(V_p, z), strict=True)]
        yield y, places


def weighted(coefficients, forces):
    """Sum of coefficients times the backward differences at the last force."""
    row, total = list(forces), Fraction(0)
    for c in coefficients:
        total += c * row[-1]
        row = [b - a for a, b in pairwise(row)]
    return total


def positions(name, forces):
    """The q of a method with one stage of each kind."""
    return [y for y, _ in steps(name, [(x,) for x in forces])]


@pytest.mark.parametrize("name", PRINTED)
def test_the_positions_obey_the_printed_recurrence(name):
    alpha, beta, denominator = PRINTED[name]
    alpha, beta = (half + half[-2::-1] for half in (alpha, beta))
    k = len(alpha) - 1
    forces = [Fraction(n * n + 1, 2 * n + 3) for n in range(3 * k)]
    q = positions(name, forces)
    for n in range(k, len(q) - k):  # behind what the arbitrary values say
        left = sum(a * x for a, x in zip(alpha, q[n:], strict=False))
        right = sum(b * x for b, x in zip(beta, forces[n:], strict=False))
        assert left == right / denominator


def test_the_positions_obey_stoermers_recurrence():
    order = len(DIFFERENCES)
    forces = [Fraction(n * n + 1, 2 * n + 3) for n in range(4 * order)]
    q = positions(f"stoermer-{order}", forces)
    for n in range(2 * order, len(q) - 1):
        right = weighted(DIFFERENCES, forces[n - order + 1 : n + 1])
        assert q[n + 1] - 2 * q[n] + q[n - 1] == right


@pytest.mark.parametrize(
    ("name", "k", "predicts"),
    [("numerov", 4, False), ("cowell-8", 8, False), ("stoermer-cowell-8", 8, True)],
)
def test_the_positions_obey_cowells_recurrence(name, k, predicts):
    """The force at the position predicted, where there is one, is another than that kept."""
    kept = [Fraction(n * n + 1, 2 * n + 3) for n in range(3 * k)]
    guessed = [x + Fraction(1, n + 7) for n, x in enumerate(kept)] if predicts else kept
    forces = list(zip(guessed, kept, strict=True)) if predicts else [(x,) for x in kept]
    found = list(steps(name, forces))
    q = [y for y, _ in found]
    for n in range(k + 1, len(q)):  # behind what the arbitrary values say
        before = 2 * q[n - 1] - q[n - 2]
        past = kept[n - k + 1 : n]
        assert q[n] == before + weighted(IMPLICIT[:k], [*past, guessed[n]])
        assert found[n][1][-1] == q[n]
        if predicts:
            assert found[n][1][0] == before + weighted(DIFFERENCES, kept[n - k : n])


def test_paths_decide_as_all_trees_of_second_order_systems_do():
    kernel = Kernel(load("quinlan-8a"))
    found = kernel.order_range(free=False, nystrom=True)
    assert (found.lower, found.upper) == (8, 8)
    series = StartingSeries(kernel._components, kernel.palette, free=False, counts=is_nystrom)
    levels = [
        {t: first_nonzero(series.residual(t)).is_zero() for t in series.advance()} for _ in range(9)
    ]
    assert [all(level.values()) for level in levels] == [True] * 8 + [False]
    assert found.tree in {str(t) for t, zero in levels[8].items() if not zero}


@pytest.mark.parametrize("name", ["pair-6-7", "ruth-3"])
def test_paths_say_nothing_where_a_stage_is_not_the_solution(name):
    kernel = Kernel(load(name))
    assert kernel._along_paths(kernel._components, free=False, nystrom=True) is None


def test_a_start_whose_stages_are_not_the_solution_is_refuted_by_a_path():
    m: Any = load("quinlan-tremaine-8")
    start = m.starting
    rows = [list(row) for row in start.A]
    rows[3][2] = rows[3][2] + Exact(1)
    rows[3][1] = rows[3][1] - Exact(1)
    wrong = replace(m, starting=replace(start, A=tuple(map(tuple, rows))))
    found = Kernel(wrong).range("nystrom-starting-order")
    assert (found.lower, found.upper) == (0, 2)
    assert Kernel(m).range("nystrom-starting-order").lower == 8


@pytest.mark.sampled(0, besides=("kahan-li-10", "19"))
@pytest.mark.parametrize("name", ["kahan-li-8b", "blanes-casas-rkn-8-19", "kahan-li-10"])
def test_one_tree_bounds_the_order_of_an_enclosed_splitting(name):
    findings = {f.claim: f for f in verify(name)}
    declared: dict[str, Any] = {c: f.declared for c, f in findings.items()}
    claim = max((c for c in declared if c.endswith("order")), key=lambda c: declared[c])
    found, n = findings[claim], declared[claim] + 1
    trees = {f"k[{'f' * (n - 1)}]", f"f[{'k' * (n - 1)}]"}
    assert found.verdict.value == "holds"
    assert found.witness.removeprefix("tree ").split(" of order ")[0] in trees
