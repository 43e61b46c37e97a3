"""Rounded coefficients: what has to hold for the rounded numbers, exactly."""

from dataclasses import replace
from fractions import Fraction

import pytest

from glmref import UsageError, load
from glmref.engine.forms import standard_form
from glmref.engine.sweep import step_form
from tests.build import refused

SWEPT = [
    "g6245", "g6245-w3", "g4123", "gsymplectic-n", "gsymplectic-p", "s4-symmetric", "thesis-3-8",
    "implicit-midpoint",
]  # fmt: skip


def exactly(row):
    return [Fraction(x) for x in row]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("name", SWEPT)
def test_the_rounded_sweep_keeps_its_quadratic_form(name):
    form = step_form(load(name))
    assert form.kind == "sweep"
    G = [exactly(row) for row in form.G]
    V = [exactly(row) for row in form.V]
    columns = list(zip(*V, strict=True))
    moved = [[dot(a, [dot(g, b) for g in G]) for b in columns] for a in columns]
    assert all(x.denominator == 1 for row in V for x in row)
    assert moved == G, "V^T G V = G must hold in the rounded numbers"
    for i in range(form.s):
        omega = [Fraction(form.R[k][i]) for k in range(form.r)]
        image = [dot(g, omega) for g in G]
        assert image == exactly(form.U[i]), "U = R^T G must be representable"
        # half of <omega, omega> against the coefficient of L_i in its own stage: a difference here
        # is a drift of h^2 |f|^2 times it at every step, in the same direction
        used = Fraction(form.M[i][i]) + Fraction(form.M_residue[i])
        assert abs(dot(image, omega) / 2 - used) < Fraction(1, 2**65)


def test_weights_sum_to_one_exactly_where_the_method_is_consistent():
    for name in ("g6245", "s4-symmetric", "gauss-5", "gauss-3"):
        assert sum(exactly(step_form(load(name)).weights)) == 1, name


@pytest.mark.parametrize("name", ["gauss-2", "gauss-4", "gauss-5", "lobatto-iiie-3"])
def test_the_mu_form_is_symplectic_in_the_rounded_numbers(name):
    form = step_form(load(name))
    assert form.kind == "mu"
    for i in range(form.s):
        for j in range(form.s):
            assert Fraction(form.M[i][j]) + Fraction(form.M[j][i]) == 1


def test_a_rotation_by_120_degrees_becomes_integral():
    form = step_form(load("g6245-w3"))
    assert [row[1:3] for row in form.V[1:3]] == [(0.0, -1.0), (1.0, -1.0)]
    g = [row[1:3] for row in form.G[1:3]]
    assert g[0][0] == g[1][1] == -2 * g[0][1] == -2 * g[1][0]


def test_a_wrong_G_is_never_swept():
    method = load("gsymplectic-n")
    wrong = replace(method, G=(("1", "0"), ("0", "1")))
    assert step_form(method).kind == "sweep"
    assert step_form(wrong).kind == "standard"
    refused(UsageError, "D U = B\\^T G V does not hold", step_form, wrong, "sweep")


def test_the_standard_form_keeps_what_rounding_lost():
    method = load("rk4")
    form = standard_form(method)
    for k, row in enumerate(method.B):
        for i, exact in enumerate(row):
            both = Fraction(form.R[k][i]) + Fraction(form.R_residue[k][i])
            assert abs(exact.as_fraction() - both) < Fraction(1, 2**105)
