"""Gauss methods on q'' = g(q): rounds on the positions, and what rounding lost put back."""

from fractions import Fraction

import numpy as np
import pytest

from glmref import load, problem, solve
from glmref.engine.forms import StepForm
from glmref.engine.kernel import prepare
from glmref.method import GLM
from tests.build import floats


def _prologue(name: str, h: float) -> dict[str, float]:
    """Coefficients as the kernel computes them before its loop."""
    source = prepare(load(name), problem("kepler"), h=h, solver="fixed-point").source.text
    lines = [x.strip() for x in source.split("def kernel")[1].splitlines()[1:]]
    values: dict = {"h": h}
    exec("\n".join(lines[: next(k for k, x in enumerate(lines) if x.startswith("y0_0"))]), values)
    return values


@pytest.mark.parametrize("name", ["gauss-2", "gauss-3", "gauss-5"])
def test_coefficients_and_what_they_lost_are_those_of_the_mu_form(name: str) -> None:
    h = 0.07
    form, found = prepare(load(name), problem("kepler"), h=h).form, _prologue(name, h)
    assert isinstance(form, StepForm)
    s, mu = range(form.s), [[Fraction(x) for x in row] for row in form.M]
    step = [Fraction(found[f"hw{k}"]) for k in s]  # h b_k as it is, rounded
    for i, row in enumerate([*mu, [Fraction(1)] * form.s]):
        velocity = sum(x * y for x, y in zip(row, step, strict=True))
        assert abs(velocity - Fraction(found[f"hc{i}"]) - Fraction(found[f"m{i}"])) < 1e-33
        for j in s:
            exact = step[j] * sum(row[k] * step[k] * mu[k][j] for k in s)
            lost = exact - Fraction(found[f"hd{i}_{j}"])
            assert abs(lost - Fraction(found[f"m{i}_{j}"])) < 1e-33
            assert abs(lost) < 2 * abs(exact) * Fraction(2) ** -52


@pytest.mark.parametrize("eccentricity", ["1/10", "1/5"])
def test_angular_momentum_does_not_drift(eccentricity: str) -> None:
    """A million steps: a walk of round-off reaches 5e-15, a drift of the coefficients 8e-14."""
    kepler = problem("kepler", eccentricity=eccentricity)
    y = solve(kepler, "gauss-3", h=0.07, steps=1_000_000, every=2000, solver="fixed-point").y
    momentum = y[:, 0] * y[:, 3] - y[:, 1] * y[:, 2]
    assert np.abs(momentum / momentum[0] - 1).max() < 3e-14


def test_other_systems_keep_their_rounds() -> None:
    def source(name: str, solver: str = "fixed-point") -> str:
        return prepare(load("gauss-2"), problem(name), h=0.01, solver=solver).source.text

    assert "m0_0 = " in source("henon-heiles")
    assert "m0_0 = " not in source("henon-heiles", "newton")
    assert "m0_0 = " not in source("rigid-body")
    assert "m0_0 = " not in source("lotka-volterra-logarithmic")  # q' = f(p), f not the identity


@pytest.mark.sampled(1, besides=("g6245",))
@pytest.mark.parametrize("name", ["yoshida-6-midpoint", "g6245-w3"])
def test_single_stages_keep_the_momentum_of_their_form(name: str) -> None:
    """The sum of G_ij q_i x p_j: a walk of round-off reaches 1e-14."""
    method = load(name)
    kepler, numbers = problem("kepler", eccentricity="1/5"), {"h": 0.07, "solver": "fixed-point"}
    y = solve(kepler, method, steps=200_000, every=2000, history=True, **numbers).history
    assert y is not None
    assert isinstance(method, GLM) and method.G is not None
    G = floats(method.G)
    terms = (np.einsum("ij,ni,nj->n", G, y[:, :, a], y[:, :, b]) for a, b in ((0, 3), (1, 2)))
    momentum = np.subtract(*terms)
    assert np.abs(momentum / momentum[0] - 1).max() < 2e-14


@pytest.mark.slow
def test_a_round_of_a_single_stage_is_a_product_and_a_sum() -> None:
    def source(name: str, on: str = "kepler", solver: str = "fixed-point") -> str:
        return prepare(load(name), problem(on), h=0.01, solver=solver).source.text

    text = source("g6245-w3")
    assert "N1_0 = b1_0 + k1*" in text
    form = prepare(load("g6245-w3"), problem("kepler"), h=0.01, solver="fixed-point").form
    assert isinstance(form, StepForm)
    assert f"k1 = ({form.M[1][1]!r}*hw1)*({form.M[1][1]!r}*hw1)" in text
    assert "k1 = " not in source("g6245-w3", solver="newton")
    assert "k1 = " not in source("g6245-w3", "rigid-body")
    assert "k1 = " not in source("g6245-w3", "lotka-volterra-logarithmic")
    assert "k1 = " not in source("gauss-3")
