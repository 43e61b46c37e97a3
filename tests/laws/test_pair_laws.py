"""Laws of explicit pairs in floating point, with a stepper written here and nowhere else.

The stepper reads b, X, c, Y off a loaded pair and sweeps: it shares no code with the engine. The
systems are random: linear forms, sines and random matrices, drawn by hypothesis.
"""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.catalogue.lookup import document, load, names
from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.findings import Verdict
from glmref.prove.verifier import verify
from tests.shipped import shipped

PAIRS = [x for x in names("methods") if shipped(x)["class"] == "pair-sweep"]
EPSILON = 2.0**-52
SEEDS = st.integers(0, 2**32 - 1)


class Sweep:
    """One step of an explicit pair on values (r, d), from the sweep and nothing else."""

    def __init__(self, name):
        pair, doc = load(name), document(name)
        number = np.vectorize(float)
        self.b, self.c = number(np.array(pair.D_P)), number(np.array(pair.D_Q))
        self.X = number(np.array(pair.B)) / self.b
        self.Y = number(np.array(pair.B_hat)) / self.c
        self.X_read, self.Y_read = self.X.copy(), self.Y.copy()  # what stages read with
        self.V, self.V_hat = number(np.array(pair.V)), number(np.array(pair.V_hat))
        self.G = number(np.array(pair.G))
        seen = {"P": 0, "Q": 0}
        self.word = []
        for letter in doc["stages"]:
            self.word.append((letter, seen[letter]))
            seen[letter] += 1

    def step(self, h, q, p, f, k):
        q, p = self.V @ q, self.V_hat @ p
        for letter, i in self.word:
            if letter == "P":
                P = self.X_read[:, i] @ self.G @ p
                q = q + h * self.b[i] * np.outer(self.X[:, i], f(P))
            else:
                Q = self.Y_read[:, i] @ self.G.T @ q
                p = p + h * self.c[i] * np.outer(self.Y[:, i], k(Q))
        return q, p

    def tangent(self, h, q, p, f, k, df, dk):
        """Values after one step and the Jacobian, variations (r d, 2 r d) swept along."""
        (r, d), size = q.shape, q.size
        unit = np.eye(2 * size)
        dq, dp = unit[:size].reshape(r, d, -1), unit[size:].reshape(r, d, -1)
        turn = lambda V, x: np.tensordot(V, x, axes=(1, 0))  # noqa: E731
        q, p, dq, dp = self.V @ q, self.V_hat @ p, turn(self.V, dq), turn(self.V_hat, dp)
        for letter, i in self.word:
            if letter == "P":
                x, read = self.X[:, i], self.X_read[:, i] @ self.G
                P, dP = read @ p, np.tensordot(read, dp, axes=(0, 0))
                q = q + h * self.b[i] * np.outer(x, f(P))
                dq = dq + h * self.b[i] * np.multiply.outer(x, df(P) @ dP)
            else:
                y, read = self.Y[:, i], self.Y_read[:, i] @ self.G.T
                Q, dQ = read @ q, np.tensordot(read, dq, axes=(0, 0))
                p = p + h * self.c[i] * np.outer(y, k(Q))
                dp = dp + h * self.c[i] * np.multiply.outer(y, dk(Q) @ dQ)
        columns = 2 * size
        return q, p, np.vstack([dq.reshape(size, columns), dp.reshape(size, columns)])


def skew(matrix):
    return matrix - matrix.T


def system_with_invariant(rng, d):
    """S, f, k with f(p)^T S p = 0 and q^T S k(q) = 0: q^T S p is conserved."""
    S = rng.normal(size=(d, d))
    A, B, a, b = rng.normal(size=(2, d, d)), rng.normal(size=(2, d, d)), *rng.normal(size=(2, 2, d))

    def f(p):
        K = skew(A[0] * np.sin(a[0] @ p) + A[1] * np.cos(a[1] @ p))
        return 0.3 * K @ (S @ p)

    def k(q):
        K = skew(B[0] * np.sin(b[0] @ q) + B[1] * np.cos(b[1] @ q))
        return 0.3 * K @ (S.T @ q)

    return S, f, k


@pytest.mark.slow
@pytest.mark.sampled(1, besides=("pair-rkn-8", "pair-8-24"))
@pytest.mark.parametrize("name", PAIRS)
@settings(max_examples=2, deadline=None)
@given(seed=SEEDS)
def test_a_bilinear_invariant_is_kept_to_round_off_over_1000_steps(name, seed):
    rng = np.random.default_rng(seed)
    d = int(rng.integers(2, 5))
    S, f, k = system_with_invariant(rng, d)
    sweep = Sweep(name)
    r = len(sweep.V)
    q, p = np.zeros((r, d)), np.zeros((r, d))
    q[0], p[0] = rng.normal(size=(2, d))
    q[1:], p[1:] = 0.1 * rng.normal(size=(2, r - 1, d))  # the whole vector counts, not only q_1
    before = np.sum(sweep.G * (q @ S @ p.T))
    largest, h = 0.0, 0.01
    for _ in range(1000):
        q, p = sweep.step(h, q, p, f, k)
        largest = max(largest, np.abs(q).sum() * np.abs(S).max() * np.abs(p).sum())
    # each of the stages' additions rounds once, and the couplings multiply: at most
    # 1000 steps * stages * (1 + max |X|)(1 + max |Y|) roundings relative to |q|^T |S| |p|
    size = (1 + np.abs(sweep.X).max()) * (1 + np.abs(sweep.Y).max())
    bound = 1000 * len(sweep.word) * size * EPSILON * largest
    assert abs(np.sum(sweep.G * (q @ S @ p.T)) - before) < bound


@pytest.mark.sampled(0)
@pytest.mark.parametrize("half", ["X_read", "Y_read"])
def test_a_near_miss_loses_the_bilinear_invariant(half):
    S, f, k = system_with_invariant(np.random.default_rng(5), 3)

    def drift(change):
        sweep, rng = Sweep("pair-4-4"), np.random.default_rng(6)
        getattr(sweep, half)[1, 0] += change
        q, p = rng.normal(size=(2, 2, 3))
        before = np.sum(sweep.G * (q @ S @ p.T))
        for _ in range(1000):
            q, p = sweep.step(0.01, q, p, f, k)
        return abs(np.sum(sweep.G * (q @ S @ p.T)) - before)

    # a step changes the form by h b_1 1e-5 times a bilinear form of size one, times 1000 steps of
    # either sign; rounding stays below 1000 * 9 * 2^-52 times that size
    assert drift(0.0) < 1e-10
    assert drift(1e-5) > 1e-8


@pytest.mark.parametrize("name", [*PAIRS, "gsymplectic-n-pair"])
def test_the_weights_of_a_consistent_method_have_equal_sums(name):
    """sum D_P = sum D_Q = u^T G u_hat, see docs/pairs-theory.md, in the exact field or within the digits."""
    pair = load(name)
    first, second = (sum(row[1:], row[0]) for row in (pair.D_P, pair.D_Q))
    assert (first - second).is_zero() is not False
    assert (first - second + pair.D_Q[-1]).is_zero() is False  # the last weight left out


@pytest.mark.sampled(0, besides=("pair-rkn-8", "pair-8-24"))
@pytest.mark.parametrize("name", PAIRS)
def test_an_invariant_whose_halves_do_not_vanish_is_kept_too(name):
    """H = ln p + ln q: f(p) p = 1, q k(q) = -1, and 0 lies in neither domain."""

    def drift(factor):
        sweep, rng = Sweep(name), np.random.default_rng(7)
        sweep.c = factor * sweep.c
        q, p = np.ones((2, 2, 1))
        q[1:], p[1:] = 0.02 * rng.normal(size=(2, 1, 1))
        before, h, largest = np.sum(sweep.G * (q @ p.T)), 1 / 512, 0.0
        for _ in range(1000):
            q, p = sweep.step(h, q, p, lambda x: 1 / x, lambda x: -1 / x)
            largest = max(largest, np.abs(q).sum() * np.abs(p).sum())
        size = (1 + np.abs(sweep.X).max()) * (1 + np.abs(sweep.Y).max())
        bound = 1000 * len(sweep.word) * size * EPSILON * largest
        return abs(np.sum(sweep.G * (q @ p.T)) - before), bound

    kept, bound = drift(1.0)
    assert kept < bound
    # sum e_j larger by 1e-3: the form changes by h 1e-3 in each step, by 2e-3 in all
    assert drift(1.001)[0] > 1e-3


def hamiltonian(rng, d):
    """Gradients and Hessians of a random sum of cosines."""
    m = d + 2
    A, a, b = rng.normal(size=(m, d)), rng.normal(size=m), rng.normal(size=m)
    return (
        lambda x: -A.T @ (a * np.sin(A @ x + b)),
        lambda x: -A.T @ ((a * np.cos(A @ x + b))[:, None] * A),
    )


def symplecticity_defect(sweep, seed, h=0.2):
    """Largest entry of J^T Omega J - Omega, and of |J|^T |Omega| |J| for the scale."""
    rng = np.random.default_rng(seed)
    d, r = int(rng.integers(1, 4)), len(sweep.V)
    f, df = hamiltonian(rng, d)
    minus_k, minus_dk = hamiltonian(rng, d)
    q, p = rng.normal(size=(2, r, d))
    _, _, J = sweep.tangent(h, q, p, f, lambda x: -minus_k(x), df, lambda x: -minus_dk(x))
    G = np.kron(sweep.G, np.eye(d))
    zero = np.zeros_like(G)
    omega = np.block([[zero, G], [-G.T, zero]])
    defect = np.abs(J.T @ omega @ J - omega).max()
    return defect, (np.abs(J).T @ np.abs(omega) @ np.abs(J)).max()


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", PAIRS)
@settings(max_examples=5, deadline=None)
@given(seed=SEEDS)
def test_the_jacobian_of_a_step_keeps_the_weighted_two_form(name, seed):
    sweep = Sweep(name)
    defect, scale = symplecticity_defect(sweep, seed)
    # |J| is the product of the stages' unit triangular factors: a rounding in each
    size = (1 + np.abs(sweep.X).max()) * (1 + np.abs(sweep.Y).max())
    assert defect < 20 * len(sweep.word) * size * EPSILON * scale


@pytest.mark.parametrize("half", ["X_read", "Y_read"])
def test_a_column_that_is_not_read_as_it_is_written_breaks_the_two_form(half):
    sweep = Sweep("pair-4-4")
    good, scale = symplecticity_defect(sweep, 1)
    wrong = getattr(sweep, half).copy()
    wrong[1, 0] += 1e-6  # A and U of one component no longer fit B of the other
    setattr(sweep, half, wrong)
    bad, _ = symplecticity_defect(sweep, 1)
    assert good < 1e-12 * scale
    assert bad > 1e-9


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
