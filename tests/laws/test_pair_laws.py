"""Laws of explicit pairs in floating point: what the form between their halves keeps in runs.

The systems are random: linear forms, sines and random matrices, drawn by hypothesis.
"""

import copy
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.catalogue.lookup import document, load, names
from glmref.catalogue.reader import load_document
from glmref.engine.solve import solve
from glmref.errors import GlmrefError
from glmref.findings import Verdict
from glmref.measure.linearised import step_derivatives
from glmref.problems.model import Problem
from glmref.prove.verifier import verify
from tests.build import floats
from tests.shipped import shipped

PAIRS = [x for x in names("methods") if shipped(x)["class"] == "pair-sweep"]
SPLITTINGS = ["symplectic-euler-a", "stormer-verlet", "ruth-3", "forest-ruth-4", "suzuki-verlet-4"]
EPSILON = 2.0**-52
SEEDS = st.integers(0, 2**32 - 1)


def form_of(method):
    return floats(method.G) if method.G is not None else np.eye(1)


def with_invariant(rng, d):
    """S, and q' = f(p), p' = k(q) with f(p)^T S p = 0 and q^T S k(q) = 0: q^T S p is conserved."""
    S = rng.normal(size=(d, d))

    def rotating(S):
        A, a = rng.normal(size=(2, d, d)), rng.normal(size=(2, d))

        def slope(x):
            K = A[0] * np.sin(a[0] @ x) + A[1] * np.cos(a[1] @ x)
            return 0.3 * (K - K.T) @ (S @ x)

        return slope

    return S, Problem(dq=rotating(S), dp=rotating(S.T), y0=(1.0,) * (2 * d))


def units(method, of, S, start, h=0.01):
    """Change of sum G_ij q_i^T S p_j over 1000 steps, in units of rounding of its terms."""
    run = solve(of, method, h=h, steps=1000, every=0, start=start, engine="interpreted")
    assert run.completed
    G, d = form_of(method), start.shape[1] // 2

    def form(values, G, S):
        return np.sum(G * (values[:, :d] @ S @ values[:, d:].T))

    terms = form(np.maximum(np.abs(start), np.abs(run.values)), np.abs(G), np.abs(S))
    return abs(form(run.values, G, S) - form(start, G, S)) / (EPSILON * terms)


def values(rng, r, d):
    """Values of q and p side by side; the whole vector counts, not the first value alone."""
    return rng.normal(size=(r, 2 * d)) * 0.1 ** (np.arange(r) > 0)[:, None]


@pytest.mark.sampled(3, besides=("pair-rkn-8", "pair-8-24"))
@pytest.mark.parametrize("name", [*SPLITTINGS, *PAIRS])
@settings(max_examples=2, deadline=None)
@given(seed=SEEDS)
def test_a_bilinear_invariant_is_kept_to_round_off_over_1000_steps(name, seed):
    rng, method = np.random.default_rng(seed), load(name)
    d = int(rng.integers(2, 5))
    S, of = with_invariant(rng, d)
    assert units(method, of, S, values(rng, method.r, d)) < 16  # 0.4 is the largest that was seen


def near_miss(letter):
    """pair-4-4 with a stage of one half that reads a value with a coefficient off by 1e-5."""
    good = load("pair-4-4")
    rows = [list(row) for row in getattr(good, letter)]
    rows[0][1] += Fraction(1, 10**5)
    return replace(good, **{letter: rows}, D_P=None, D_Q=None)


@pytest.mark.parametrize("letter", ["U", "U_hat"])
def test_a_near_miss_loses_the_bilinear_invariant(letter):
    rng = np.random.default_rng(5)
    S, of = with_invariant(rng, 3)
    assert units(near_miss(letter), of, S, values(rng, 2, 3)) > 1e4


@pytest.mark.sampled(0, besides=("pair-rkn-8", "pair-8-24"))
@pytest.mark.parametrize("name", PAIRS)
def test_an_invariant_whose_halves_do_not_vanish_is_kept_too(name):
    """H = ln p + ln q: f(p) p = 1, q k(q) = -1, and 0 lies in neither domain."""
    method, of = load(name), Problem(dq=("1/p[0]",), dp=("-1/q[0]",), y0=(1, 1))
    start = np.array([[1.0, 1.0], [0.02, -0.01]])
    heavier = replace(method, B_hat=[[x * Fraction(1001, 1000) for x in row] for row in method.B_hat],
                      D_P=None, D_Q=None)  # fmt: skip
    assert units(method, of, np.eye(1), start, 1 / 512) < 16
    assert units(heavier, of, np.eye(1), start, 1 / 512) > 1e4


@pytest.mark.parametrize("name", [*PAIRS, "gsymplectic-n-pair"])
def test_the_weights_of_a_consistent_method_have_equal_sums(name):
    """sum D_P = sum D_Q = u^T G u_hat, see docs/pairs-theory.md, in the exact field or within the digits."""
    pair = load(name)
    first, second = (sum(row[1:], row[0]) for row in (pair.D_P, pair.D_Q))
    assert (first - second).is_zero() is not False
    assert (first - second + pair.D_Q[-1]).is_zero() is False  # the last weight left out


def two_form_defect(method, seed, h=0.2):
    """Largest entry of J^T Omega J - Omega for the Jacobian J of a step, relative to its terms."""
    rng = np.random.default_rng(seed)
    d, r = int(rng.integers(1, 4)), method.r

    def cosines(letter):
        terms = (" + ".join(f"({a})*{letter}{i}" for i, a in enumerate(rng.normal(size=d)))
                 for _ in range(d + 2))  # fmt: skip
        return " + ".join(f"({rng.normal()})*cos({x} + ({rng.normal()}))" for x in terms)

    at_rest = {f"{letter}{i}": 0 for letter in "qp" for i in range(d)}
    of = Problem.from_hamiltonian(f"{cosines('q')} + {cosines('p')}", at_rest)
    J = step_derivatives(method, of, h, rng.normal(size=(1, r, 2 * d)))[0]
    half = np.kron(form_of(method), np.kron([[0, 1], [0, 0]], np.eye(d)))
    omega = half - half.T
    scale = (np.abs(J).T @ np.abs(omega) @ np.abs(J)).max()
    return np.abs(J.T @ omega @ J - omega).max() / scale


@pytest.mark.sampled(2, besides=("pair-rkn-8", "pair-8-24"))
@pytest.mark.parametrize("name", PAIRS)
@settings(max_examples=3, deadline=None)
@given(seed=SEEDS)
def test_the_jacobian_of_a_step_keeps_the_weighted_two_form(name, seed):
    assert two_form_defect(load(name), seed) < 16 * EPSILON


@pytest.mark.parametrize("letter", ["U", "U_hat"])
def test_a_column_that_is_not_read_as_it_is_written_breaks_the_two_form(letter):
    assert two_form_defect(near_miss(letter), 3) > 1e-8


def failing(doc):
    """Claims of a document that do not hold, or the error that says so."""
    try:
        findings = verify(load_document(doc))
    except GlmrefError as error:
        return [type(error).__name__]
    return [x.claim for x in findings if x.verdict is not Verdict.HOLDS]


def refuted(doc):
    """Claims of a document that are proved to be false."""
    found = verify(load_document(doc, where="test"))
    return [x.claim for x in found if x.verdict is Verdict.FAILS]


def planted(doc, key, change):
    """The document with one entry of a row changed and its enclosure left out."""
    wrong = copy.deepcopy(doc)
    wrong.pop("enclosure", None)
    row = wrong[key][0] if key in ("w", "v") else wrong[key]
    at = next(i for i, x in enumerate(row) if x != "0")
    row[at] = change(row[at])
    return wrong


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["pair-4-4", "pair-6-7"])
@pytest.mark.parametrize("key", ["b", "w", "c", "v"])
def test_an_error_in_one_component_only_is_caught(name, key):
    doc = document(name)
    good = {k: v for k, v in doc.items() if k != "enclosure"}
    assert refuted(good) == []  # without its enclosure a claim may be open, and none fails
    for change in (lambda x: f"{x}+1/1000000", lambda x: f"-({x})"):
        assert "order" in refuted(planted(doc, key, change)), (key, change("x"))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["pair-4-4", "pair-6-7"])
@pytest.mark.parametrize("place", [3, 20, 70])
def test_a_wrong_digit_of_p_alone_is_caught_by_the_enclosure(name, place):
    doc = copy.deepcopy(document(name))
    key = next(x for x in doc["unknowns"] if x.startswith("v"))
    text = doc["unknowns"][key]
    at = text.index(".") + place
    doc["unknowns"][key] = text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1 :]
    assert failing(doc) == ["ExactnessError"]
