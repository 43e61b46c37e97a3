"""Stiff problems: matrices are as small and as few as they can be, and what a fixed step costs."""

import re

import pytest

from campaigns.pages import measured
from campaigns.stiff import matrices_of, stiff_cost
from glmref.catalogue.lookup import load
from glmref.engine.kernel import prepare
from glmref.problems import problem

DIAGONALLY_IMPLICIT = (
    "sdirk-2", "sdirk-3", "sdirk-4", "tr-bdf2", "dimsim-2-type-2", "dimsim-2-type-4",
    "gsymplectic-p", "gsymplectic-n", "s4-symmetric", "g6245", "g6245-w3", "bdf-2",
)  # fmt: skip


def distinct_diagonals(method):
    """Return the diagonal entries of A that differ, zero left out, decided exactly."""
    found = []
    for i in range(method.s):
        x = method.A[i][i]
        if x.is_zero() is not True and not any((x - y).is_zero() is True for y in found):
            found.append(x)
    return len(found)


@pytest.mark.slow
@pytest.mark.sampled(2, whole=5)
@pytest.mark.parametrize("name", DIAGONALLY_IMPLICIT)
def test_diagonally_implicit_methods_factor_one_small_matrix_for_each_diagonal(name):
    method, subject = load(name), problem("hires")
    found = matrices_of(method, subject, h=0.05)
    assert not found.inline
    assert found.size == subject.dimension
    assert found.distinct == distinct_diagonals(method)


@pytest.mark.slow
def test_of_a_separable_problem_only_half_the_components_are_unknown():
    subject = problem("fput-stiff", omega=5000)
    assert matrices_of(load("sdirk-4"), subject, h=0.01).size == subject.dimension // 2


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("name", "count"), [("gauss-2", 1), ("gauss-3", 2), ("radau-iia-3", 2)])
def test_coupled_stages_are_separated_by_the_eigenvalues_of_a(name, count):
    # one matrix for each real eigenvalue and each complex pair, of the size of the problem
    found = matrices_of(load(name), problem("hires"), h=0.05)
    assert (found.size, found.distinct, found.inline) == (8, count, False)


@pytest.mark.slow
def test_a_second_diagonal_entry_costs_a_second_matrix():
    method = load("sdirk-2")
    rows = [[str(x) for x in row] for row in method.A]
    assert rows[0][0] == rows[1][1]
    from glmref.method import GLM

    other = GLM(A=[["1/4", "0"], ["1/2", "1/3"]], U=[["1"]] * 2, B=[["1/2", "1/2"]], V=[["1"]])
    assert matrices_of(method, problem("hires"), h=0.05).distinct == 1
    assert matrices_of(other, problem("hires"), h=0.05).distinct == 2


def test_small_systems_write_their_matrix_out():
    found = matrices_of(load("sdirk-4"), problem("van-der-pol"), h=1e-3)
    assert found.inline and found.size == 2


@pytest.mark.slow
def test_matrices_are_kept_from_step_to_step():
    linear = problem("linear-field", dimension=8)
    # one Jacobian serves a linear problem for ever
    assert stiff_cost(linear, load("sdirk-4"), h=0.1, steps=50).jacobians == 1
    smooth = stiff_cost(problem("fput-stiff", omega=5000), load("sdirk-4"), h=0.01, steps=10)
    assert smooth.outcome == "completed" and smooth.matrices <= 10


@pytest.mark.slow
def test_the_generated_source_has_no_other_elimination():
    text = prepare(load("g6245"), problem("hires"), h=0.05, solver="newton").source.text
    assert set(re.findall(r"^ *(\w*factor)\(.*\], (\d+),", text, re.MULTILINE)) == {("factor", "8")}


@pytest.mark.slow
def test_the_measured_counts_are_measured_again():
    rows = measured("stiff-cost")["rows"]
    ours = [row for row in rows if row["h"] is not None and row["problem"] == "fput-stiff"]
    assert {row["name"] for row in ours} >= {"g6245", "sdirk-4"}
    row = next(r for r in ours if r["name"] == "g6245" and r["outcome"] == "completed")
    again = stiff_cost(
        problem("fput-stiff", omega=5000), load("g6245"), h=row["h"],
        steps=round(row["t_end"] / row["h"]),
    )  # fmt: skip
    assert again.outcome == row["outcome"]
    # rounds of Newton's method hang on the last bits of a sum; one in a hundred may differ
    assert again.evaluations == pytest.approx(row["evaluations"], rel=0.01)
    assert again.matrices == row["matrices"]
