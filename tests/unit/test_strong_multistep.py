"""Explicit multistep methods with all parasitic roots inside the unit circle."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from glmref import Problem
from glmref.catalogue.canonical import canonical
from glmref.catalogue.lookup import load, path_of
from glmref.catalogue.reader import load_document
from glmref.derive import recipes
from glmref.derive.halves import exponential, quotient
from glmref.derive.recipes.strong_multistep import SHIPPED
from glmref.derive.strong_multistep import StrongFormula, strong_document
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.findings import Verdict
from glmref.problems import problem
from glmref.prove.facts import facts_of
from tests.build import SOURCE

F = Fraction


@st.composite
def formulas(draw: Any) -> StrongFormula:
    """Formulas of order 2 and 4 with 0 to 3 more steps, their blocks far enough apart."""
    order, more = draw(st.sampled_from((2, 4))), draw(st.integers(0, 3))
    left = order + more - 1
    pairs = draw(st.integers(0, left // 2))
    numbers = st.fractions(F(-7, 8), F(7, 8), max_denominator=8)
    b = draw(st.lists(numbers, min_size=pairs, max_size=pairs))
    a = [draw(numbers) * (1 + x) for x in b]
    reals = draw(
        st.lists(numbers, min_size=left - 2 * pairs, max_size=left - 2 * pairs, unique=True)
    )
    constant = draw(st.fractions(F(-1), F(1), max_denominator=8)) if more > 1 else None
    try:
        made = StrongFormula(order, tuple(zip(a, b, strict=True)), tuple(reals), constant)
        made.U  # noqa: B018 - roots of two blocks may be equal
    except UsageError:
        assume(False)
    return made


def transfer(formula: StrongFormula, terms: int) -> list[Fraction]:
    """Return x sigma/rho at z = exp(x) as a series, by definition."""
    at = [exponential(F(k), terms + 1) for k in range(formula.steps + 1)]
    rho, sigma = (
        [sum((c * e[i] for c, e in zip(row, at, strict=False)), F(0)) for i in range(terms + 1)]
        for row in (formula.rho, formula.sigma)
    )
    assert rho[0] == 0
    return quotient(sigma[:terms], rho[1:])


@given(formulas())
def test_a_formula_has_its_order_and_constants(formula: StrongFormula) -> None:
    p, constants = formula.order, formula.error_constants
    assert transfer(formula, p + 4) == [1, *[0] * (p - 1), *constants]
    more = formula.steps - p
    assert not (more and constants[1])
    assert not (more == 3 and constants[3])
    assert formula.constant in (None, constants[0])


@given(formulas())
def test_the_one_step_form_is_the_formula(formula: StrongFormula) -> None:
    """U (z - V)^-1 B = sigma/rho, at a z that is no root."""
    z, n = F(3), formula.steps
    U, V, B = formula.U, formula.V, formula.entry
    M = np.array([[float(z * (i == j) - V[i][j]) for j in range(n)] for i in range(n)])
    left = float(np.array(U, dtype=float) @ np.linalg.solve(M, np.array(B, dtype=float)))
    rho, sigma = (
        sum((c * z**k for k, c in enumerate(x)), F(0)) for x in (formula.rho, formula.sigma)
    )
    size = float(np.abs(np.array(U, dtype=float)).sum())
    assert left == pytest.approx(float(sigma / rho), rel=1e-11, abs=1e-13 * size)


@given(formulas())
def test_the_judge_finds_the_order_and_no_growth(formula: StrongFormula) -> None:
    document = strong_document("found", formula, "found") | {"source": SOURCE}
    facts = facts_of(load_document(document | {"claims": {}}))
    for claim, declared in (("order", formula.order), ("zero-stable", True), ("explicit", True),
                            ("parasitism-free", True), ("starting-order", formula.order)):  # fmt: skip
        if claim == "order" and not formula.error_constants[0]:
            continue
        assert facts.judge(claim, declared).verdict == Verdict.HOLDS, claim
    if formula.error_constants[0]:
        assert facts.judge("order", formula.order + 1).verdict == Verdict.FAILS


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", SHIPPED)
def test_the_recipe_writes_the_shipped_file(name: str) -> None:
    (found,) = recipes.run("strong-multistep", {"name": name}).documents
    assert canonical(found) == path_of(name).read_text(encoding="utf-8")


def test_the_recipe_takes_other_roots() -> None:
    given_ = {"order": "4", "pairs": "1/2 1/2 1/3 1/4"}
    found = recipes.run("strong-multistep", given_)
    (document,) = found.documents
    assert document["claims"]["order"] == 4
    assert (
        "the error constant is -0.2142, and the energy drifts with h^7" in found.statements[0].text
    )


def arrays(name: str) -> list[np.ndarray]:
    """Return U, B and V of a method."""
    (m,) = load(name).carriers
    return [np.array([[float(x) for x in row] for row in M]) for M in (m.U, m.B, m.V)]


def rate(name: str, x: float) -> complex:
    """Return log w - i x of the principal root w on y' = i y with step x, for an amplitude of 1."""
    U, B, V = arrays(name)
    roots = np.linalg.eigvals(V + 1j * x * B @ U)
    return complex(np.log(roots[np.argmin(abs(roots - np.exp(1j * x)))]) - 1j * x)


@pytest.mark.parametrize("name", SHIPPED)
def test_the_energy_of_an_oscillator_drifts_two_orders_later_than_its_phase(name: str) -> None:
    """log w = i x (1 + C_p (i x)^p + ..): the real part is of odd constants only."""
    formula = SHIPPED[name].formula()
    p, constants = formula.order, formula.error_constants
    assert constants[1] == 0
    x = 0.1
    first = sum(float(C) * (1j * x) ** (p + m) for m, C in enumerate(constants)) * 1j * x
    found = rate(name, x)
    # the terms that are left out are smaller by x^2, those of products by C x^p
    assert found.imag == pytest.approx(first.imag, rel=0.3)
    # rounding leaves some 1e-15 in the logarithm
    assert abs(found.real) < 0.02 * abs(found.imag) + 1e-14


@pytest.mark.parametrize("name", SHIPPED)
def test_the_error_converges_with_the_order(name: str) -> None:
    one = problem("uneven-plane")
    exact = solve(one, "gauss-8", h=0.005, steps=400, every=400).y[-1]
    errors = [
        float(np.abs(solve(one, name, h=2 / n, steps=n, every=n).y[-1] - exact).max())
        for n in (40, 80)
    ]
    # of order p the error falls at least 2^(p - 1)-fold, above rounding
    assert 1e-13 < errors[1] < errors[0] / 2**7


@pytest.mark.parametrize("name", SHIPPED)
def test_no_root_leaves_the_circle_on_systems_without_a_common_sign(name: str) -> None:
    """H = a p q grows in one half of every symmetric pair at every h; here at none up to 0.05."""
    U, B, V = arrays(name)
    for z in np.linspace(0.001, 0.05, 25):
        for x in (z, -z, 1j * z):
            roots = np.linalg.eigvals(V + x * B @ U)
            others = np.delete(roots, np.argmin(abs(roots - np.exp(x))))
            assert abs(others).max() < 1


def test_a_step_that_is_too_large_later_has_a_notice() -> None:
    found = solve(problem("dipole-charge"), "multistep-strong-8", h=0.0353, steps=4_000, every=40)
    assert found.suspect is not None
    (notice,) = found.notices
    assert "a smaller h" in notice
    assert "renew" not in notice


@pytest.mark.parametrize(
    ("name", "h"), [("restricted-three-body", 0.1), ("kepler", 0.1), ("pendulum", 1.0)]
)
def test_a_step_that_is_too_large_at_once_has_two(name: str, h: float) -> None:
    """The first steps are wrong already, and the system grows at the start."""
    found = solve(problem(name), "multistep-strong-8", h=h, steps=3_000, every=30)
    assert found.suspect is not None
    before, later = found.notices
    assert before.startswith(f"h = {h:g} is beyond") and later.startswith("from t = ")


def test_an_error_of_a_fifth_is_reported_though_the_first_steps_have_some() -> None:
    one = Problem.from_hamiltonian("p**2/(2*(1 + q**2)) + q**2/2", {"q": 1, "p": 0})
    found = solve(one, "multistep-strong-8", h=0.15, steps=3_000, every=30)
    assert found.suspect is not None


def test_close_encounters_of_a_sound_orbit_are_not_reported() -> None:
    found = solve(
        problem("swinging-atwood"), "multistep-strong-8", h=0.005, steps=20_000, every=200
    )
    assert not found.notices


def test_a_formula_that_is_not_watched_does_not_say_so() -> None:
    for reals, watched in (("1/3", False), ("2/3", True)):
        made = recipes.run("strong-multistep", {"order": "2", "reals": reals}).documents
        assert any("has a notice" in x for x in made[0]["notes"]) == watched


@pytest.mark.parametrize("name", ["ab-4", "ab-2"])
def test_formulas_without_parasitic_roots_are_not_watched(name: str) -> None:
    found = solve(problem("shear"), name, h=0.05, steps=4_000, every=40)
    assert found.suspect is None
