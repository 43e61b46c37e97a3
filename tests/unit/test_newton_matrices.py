"""Newton's matrices of a compiled kernel are as small and as few as they can be."""

import re

import pytest

from glmref.catalogue.lookup import load
from glmref.engine.kernel import prepare
from glmref.engine.solve import solve
from glmref.method import GLM
from glmref.problems import problem

DIAGONALLY_IMPLICIT = (
    "sdirk-2", "sdirk-3", "sdirk-4", "tr-bdf2", "dimsim-2-type-2", "dimsim-2-type-4",
    "gsymplectic-p", "gsymplectic-n", "s4-symmetric", "g6245", "g6245-w3", "bdf-2",
)  # fmt: skip
TWO_DIAGONALS = GLM(A=[["1/4", "0"], ["1/2", "1/3"]], U=[["1"]] * 2, B=[["1/2", "1/2"]], V=[["1"]])


def matrices_of(method, subject, h=0.05):
    """Return the rows of each matrix that is factored for a Jacobian, from the generated source."""
    text = prepare(method, subject, h=h, solver="newton").source.text
    places = re.findall(r"^ *(?:complex_)?factor\(.*\], \d+,.*", text, re.MULTILINE)
    assert set(re.findall(r"^ *(\w*factor)\(", text, re.M)) <= {"factor", "complex_factor"}
    # after the arrays come the size, the numbers of diagonals and how the array is laid out
    return [int(x.rpartition("],")[2].split(",")[0]) for x in dict.fromkeys(map(str.strip, places))]


@pytest.mark.slow
@pytest.mark.sampled(2, whole=5)
@pytest.mark.parametrize("name", DIAGONALLY_IMPLICIT)
def test_diagonally_implicit_methods_factor_one_small_matrix_for_each_diagonal(name):
    method, diagonals = load(name), []
    for i in range(method.s):
        x = method.A[i][i]
        if x.is_zero() is not True and not any((x - y).is_zero() is True for y in diagonals):
            diagonals.append(x)
    assert matrices_of(method, problem("hires")) == [8] * len(diagonals)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("method", "count"),
    # one matrix for each real eigenvalue and each complex pair, or each diagonal entry
    [("gauss-2", 1), ("gauss-3", 2), ("radau-iia-3", 2), (TWO_DIAGONALS, 2)],
)
def test_coupled_stages_are_separated_by_the_eigenvalues_of_a(method, count):
    found = load(method) if isinstance(method, str) else method
    assert matrices_of(found, problem("hires")) == [8] * count


@pytest.mark.slow
def test_of_a_separable_problem_only_half_the_components_are_unknown():
    subject = problem("fput-stiff", omega=5000)
    assert set(matrices_of(load("sdirk-4"), subject, 0.01)) == {subject.dimension // 2}


def test_small_systems_write_their_matrix_out():
    assert matrices_of(load("sdirk-4"), problem("van-der-pol"), 1e-3) == []


@pytest.mark.slow
def test_matrices_are_kept_from_step_to_step():
    linear, stiff = problem("linear-field", dimension=8), problem("fput-stiff", omega=5000)
    # one Jacobian serves a linear problem for ever
    assert solve(linear, "sdirk-4", h=0.1, steps=50, solver="newton").factorisations == 1
    smooth = solve(stiff, "sdirk-4", h=0.01, steps=10, solver="newton")
    assert smooth.completed and smooth.factorisations <= 10
