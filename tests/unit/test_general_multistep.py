"""Explicit multistep methods for systems that are not separable: orders, residues, starts."""

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from glmref.catalogue.canonical import canonical
from glmref.catalogue.lookup import data_root, load, path_of
from glmref.catalogue.reader import load_document
from glmref.derive import general_multistep, recipes
from glmref.derive.halves import GeneralHalf, integrals
from glmref.derive.recipes.general_multistep import SHIPPED
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.findings import Verdict
from glmref.problems import problem
from glmref.prove.facts import facts_of
from glmref.theory.coefficients import first_nonzero
from glmref.theory.residues import both_ways, rates_on_one_sign, residues
from glmref.theory.starting_series import StartingSeries
from tests.build import SOURCE

F = Fraction
#: The shipped methods for all systems.
GENERAL = tuple(name for name, roots in SHIPPED.items() if not roots.semi)
#: Two halves of order 4.
Q4, P4 = GeneralHalf((F(1, 2),), True), GeneralHalf((F(1, 3), F(-1, 4)))


def document(q: GeneralHalf, p: GeneralHalf) -> dict[str, Any]:
    return {**general_multistep.general_document("found", q, p), "title": "found", "source": SOURCE}


def method(q: GeneralHalf, p: GeneralHalf) -> Any:
    return load_document(document(q, p))


cosines = st.fractions(min_value=F(-15, 16), max_value=F(15, 16), max_denominator=16)


@given(st.lists(cosines, min_size=1, max_size=3, unique=True), st.booleans())
def test_a_half_is_explicit_symmetric_and_of_its_order(c: list[Fraction], minus_one: bool) -> None:
    half = GeneralHalf(tuple(c), minus_one)
    m = len(c)
    mu, last = half.residues[:m], half.residues[m:]
    assert 2 * sum(mu) + sum(last) == -1  # the values at z = 0: sigma(0) = 0
    x = 0.01
    found = 0.5 / np.tanh(x / 2) + sum(float(u) for u in last) * np.tanh(x / 2) / 2
    found += sum(
        float(u) * np.sinh(x) / (np.cosh(x) - float(y)) for u, y in zip(mu, c, strict=True)
    )
    # the next term is two powers smaller; its coefficient grows like that of a pole at acos(c)
    pole = min(float(np.arccos(float(max(c)))), 2.0)
    assume(pole > 0.3)
    scale = sum(abs(float(u)) for u in half.residues) + 1
    left = abs(found - 1 / x - float(half.error_constant) * x ** (half.order - 1))
    assert left < 1e-13 / x * scale + 4 * scale * (x / pole) ** (half.order + 1) / pole


@given(st.lists(cosines, min_size=2, max_size=2, unique=True), cosines)
def test_the_error_constant_is_affine_and_can_be_matched(c, other):
    half = GeneralHalf(tuple(c[:1]), True)
    assume(other not in c)
    try:
        found = general_multistep.matching_cosine(half, (other,))
    except UsageError:
        return
    assume(found != other)
    assert GeneralHalf((found, other)).error_constant == half.error_constant


@pytest.mark.slow
def test_the_order_holds_on_all_trees_of_two_colours() -> None:
    """What trees without branches decide at order 7 and above is found here tree by tree."""
    m = method(GeneralHalf((F(1, 2), F(-1, 5)), True), GeneralHalf((F(2, 3), F(1, 7), F(-3, 4))))
    series = StartingSeries.of(m, free=False)
    for _ in range(6):
        assert all(first_nonzero(series.residual(t)).is_zero() for t in series.advance())
        series.settle()
    assert facts_of(m).judge("order-identity", 6).verdict is Verdict.HOLDS
    assert facts_of(m).judge("order", 7).verdict is Verdict.FAILS


def test_paths_need_stages_at_one_time() -> None:
    """Lobatto's abscissae in two orders: every path of order 3 is right, f[fk] is not."""
    sixth, zero = F(1, 6), F(0)
    A = [[zero, zero, zero], [F(-1, 4), F(3, 4), zero], [zero, F(1), zero]]
    b = [sixth, F(2, 3), sixth]
    half = {"U": [["1"]] * 3, "B": [[str(x) for x in b]], "V": [["1"]]}
    q = {"A": [[str(x) for x in row] for row in A], **half}
    p = {"A": [[str(x) for x in row[::-1]] for row in A[::-1]], **half}
    given = {"format": "glmref-method-1", "name": "x", "title": "x", "class": "partitioned",
             "q": q, "p": p, "source": SOURCE}  # fmt: skip
    assert facts_of(load_document(given)).judge("order", 3).verdict is Verdict.FAILS
    assert facts_of(load_document(given)).judge("order", 2).verdict is Verdict.HOLDS


@given(st.lists(st.fractions(min_value=F(-4), max_value=F(4), max_denominator=8), max_size=5),
       st.sampled_from([F(-2), F(-1, 2), F(3, 4), F(1)]))  # fmt: skip
def test_a_gaining_node_gains_the_integral_an_order(x: list[Fraction], c: Fraction) -> None:
    given = sorted({y for y in x if not min(c, 0) < y < max(c, 0)} - {F(0)})
    nodes = [F(0), *given, general_multistep.gaining(given, c)]
    assert min(c, 0) < nodes[-1] < max(c, 0)
    for k in range(len(nodes) + 1):  # one more than the weights ask for
        exact = c ** (k + 1) / (k + 1)
        found = sum(w * y**k for w, y in zip(integrals(nodes, c), nodes, strict=True))
        assert found == exact


def test_a_start_of_each_order_has_so_many_points_and_no_order_more() -> None:
    for order, count in ((2, 2), (4, 6), (6, 13), (8, 24), (10, 39), (12, 58)):
        assert 1 + sum(map(len, general_multistep.start_levels(order))) == count
    doc = {**document(Q4, P4), "claims": {"starting-order": 4}}
    assert len(doc["starting"]["A"]) == 6
    facts = facts_of(load_document(doc))
    assert facts.judge("starting-order", 4).verdict is Verdict.HOLDS
    assert facts.judge("starting-order", 5).verdict is Verdict.FAILS


@pytest.mark.sampled(1, besides=("12",))
@pytest.mark.parametrize("name", SHIPPED)
def test_the_recipe_writes_the_shipped_file(name: str) -> None:
    (found,) = recipes.run("general-multistep", {"name": name}).documents
    assert canonical(found) == path_of(name).read_text(encoding="utf-8")


def test_the_recipe_takes_other_roots() -> None:
    given = {"q": "1/2 -1", "p": "-1/4", "match": "p"}
    (found,) = recipes.run("general-multistep", given).documents
    assert found["claims"]["order"] == 4


def test_the_growth_parameters_are_the_residues() -> None:
    found = residues(method(Q4, P4))
    q = [x.mu.as_fraction() for x in found["f"]]
    p = [x.mu.as_fraction() for x in found["k"]]
    assert q == list(Q4.residues)
    assert p == list(P4.residues)


def test_the_growth_parameters_are_those_of_eigenvectors() -> None:
    m = method(Q4, P4)
    found = residues(m)
    assert found is not None
    for c in m.components:
        V, U, B = (np.array([[complex(x) for x in row] for row in M]) for M in (c.V, c.U, c.B))
        for x, n in both_ways(found[c.colour]):
            zeta = complex(x.eigenvalues[n])
            values, right = np.linalg.eig(V)
            k = int(np.argmin(abs(values - zeta)))
            assert abs(values[k] - zeta) < 1e-12
            w, v = np.linalg.inv(right)[k], right[:, k]
            assert abs((w @ B @ U @ v) / zeta - complex(x.mu)) < 1e-11


@pytest.mark.parametrize("name", GENERAL)
def test_the_parasitic_part_of_a_linear_system_grows_at_the_rate_of_its_residue(name: str) -> None:
    """On H = (p^2 + q^2)/2 + 0.3 p q, log |w| = mu H_pq h for q and -mu H_pq h for p, to O(h^2)."""
    m: Any = load(name)
    h, rate = 0.005, 0.3
    q, p = ([np.array([[complex(x).real for x in row] for row in M]) for M in (c.U, c.B, c.V)]
            for c in m.components)  # fmt: skip
    step = np.block([
        [q[2] + h * rate * q[1] @ q[0], h * q[1] @ p[0]],
        [-h * p[1] @ q[0], p[2] - h * rate * p[1] @ p[0]],
    ])  # fmt: skip
    eigenvalues, found = np.linalg.eigvals(step), residues(m)
    for half, sign in zip(found.values(), (1, -1), strict=True):
        for x, n in both_ways(half):
            nearest = np.abs(eigenvalues - complex(x.eigenvalues[n])).argmin()
            expected = sign * complex(x.mu).real * rate * h
            assert abs(np.log(abs(eigenvalues[nearest])) / expected - 1) < 0.01


def test_every_half_has_a_residue_that_grows() -> None:
    """The sum of the k - 1 residues is -1, so that one is -1/(k - 1) or less."""
    for name in GENERAL:
        found = residues(load(name))
        for half in found.values():
            mu = [complex(x.mu).real for x, _ in both_ways(half)]
            assert abs(sum(mu) + 1) < 1e-12
            assert min(mu) <= -1 / len(mu)
        rates = rates_on_one_sign(found)
        assert min(rates.values()) > 0


@pytest.mark.parametrize("name", GENERAL)
def test_the_error_converges_with_the_order(name: str) -> None:
    m: Any = load(name)
    given = problem("double-pendulum", q1="1/2", q2="3/10")
    exact = solve(given, "gauss-4", h=1 / 160, t_end=5).y[-1]
    errors = []
    for n in (100, 200):
        found = solve(given, m, h=5 / n, steps=n, engine="reference")
        assert found.evaluations == n  # of both functions, once a step
        assert found.start_evaluations == len(m.starting.A)
        errors.append(np.abs(found.y[-1] - exact).max())
    # of order p the error falls at least 2^(p - 1)-fold where it is above rounding
    assert errors[1] < max(errors[0] / 2 ** (facts_of(m).kernel.range("order").value - 1), 1e-11)


def test_the_page_prints_what_is_measured() -> None:
    root = data_root().parent
    page = (root / "docs/nonseparable.md").read_text(encoding="utf-8")
    record = json.loads((data_root() / "measurements/nonseparable.json").read_text("utf-8"))
    names = ("multistep-general-8", "multistep-general-8c", "multistep-general-8b")
    counts = {x["problem"]: x["methods"] for x in record["evaluations"] if x["tolerance"] == 1e-9}
    ratios: dict[str, list[float]] = {}
    for found in counts.values():
        gauss = min(x for k, x in found.items() if k.startswith("gauss"))
        dop853 = found["scipy-dop853"]
        for name in names:
            ratios.setdefault(name, []).append(found[name] / gauss)
            ratios.setdefault(f"{name} dop", []).append(found[name] / dop853)
    means = {k: f"{np.exp(np.mean(np.log(x))):.2f}" for k, x in ratios.items()}
    assert list(means.values()) == ["0.37", "0.79", "0.29", "0.61", "0.26", "0.56"]
    assert "They need 0.37, 0.26 and 0.29 of the best Gauss method" in page
    assert "0.79, 0.56 and 0.61 of DOP853" in page


def test_no_long_run_is_lost_without_a_notice() -> None:
    """No run is lost without a notice; a loss is an energy error beyond 1e-3."""
    whole = json.loads((data_root() / "measurements/nonseparable.json").read_text("utf-8"))["long"]
    record = [x for x in whole if x["h"] is not None and x["method"] != GENERAL[0]]
    lost = [x for x in record if x["energy"] is None or x["energy"] >= 1e-3]
    noticed = [x for x in record if x["reported"] is not None]
    assert all(x in noticed for x in lost)
    assert max(x["growth"] for x in noticed) < 100


def test_the_page_says_what_renewal_costs() -> None:
    page = (data_root().parent / "docs/nonseparable.md").read_text(encoding="utf-8")
    record = json.loads((data_root() / "measurements/nonseparable.json").read_text("utf-8"))
    (x,) = (
        x
        for x in record["renewal"]
        if (x["problem"], x["method"], x["renew"], x["start_order"])
        == ("uneven-plane", "multistep-general-8b", 300, 8)
    )
    assert x["start_evaluations"] == 24 * (1 + 39_999 // 300)
    assert "every 300 steps, at 24 evaluations, 8 % more in all" in page
