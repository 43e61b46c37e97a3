"""Laws of structure: what a change of values or an order of stages must not change.

And: methods built from the sweep identities are G-symplectic, and stop being so when disturbed.
"""

from dataclasses import FrozenInstanceError, fields
from fractions import Fraction

import pytest
from hypothesis import assume, given, reject, settings
from hypothesis import strategies as st

import glmref
from glmref import PartitionedGLM
from glmref.errors import DataError
from glmref.exact import Exact, exact, linalg
from glmref.method import GLM, as_matrix
from glmref.method.families import linear_multistep
from glmref.prove.facts import facts_of
from glmref.theory.consistency import consistency
from glmref.theory.equivalence import reduce
from glmref.theory.order import order_of
from glmref.theory.parasitism import growth
from glmref.theory.periodicity import periodicity
from glmref.theory.reduction import reduction
from glmref.theory.spectrum import power_bounded
from glmref.theory.stability import stability_polynomial
from glmref.theory.stability_interval import real_interval
from glmref.theory.symmetry import symmetry
from glmref.theory.symplectic import find_forms, form_identities, g_symplectic
from tests.build import invertible, refused, same
from tests.examples import examples, law

SMALL = st.integers(-3, 3)
LAWS = settings(max_examples=8, deadline=None)
METHODS = ["gsymplectic-n", "gsymplectic-p", "g4123", "s4-symmetric", "thesis-3-8", "leapfrog"]


@law(METHODS, LAWS, 2, besides=("s4-symmetric",))
def test_structure_does_not_depend_on_values_or_order_of_stages(name, data):
    m = glmref.load(name).bare()
    T = data.draw(invertible(m.r, 3))
    order = data.draw(st.permutations(range(m.s)))
    other = m.transform(T).permute_stages(order)
    assert g_symplectic(other).holds is g_symplectic(m).holds
    assert symmetry(other).holds is symmetry(m).holds
    assert power_bounded(other.V).holds is power_bounded(m.V).holds is True
    assert [g.mu for g in growth(other).growths] == [g.mu for g in growth(m).growths]
    assert stability_polynomial(other) == stability_polynomial(m)


@law(METHODS, LAWS, 1)
def test_forms_and_involutions_move_with_the_values(name, data):
    m = glmref.load(name).bare()
    T = data.draw(invertible(m.r, 3))
    other = m.transform(T)
    G = g_symplectic(m).G
    back = linalg.inverse(T)
    assert same(g_symplectic(other).G, linalg.matmul(linalg.transpose(back), G, back))
    assert g_symplectic(other).D == g_symplectic(m).D
    assert consistency(other).u == linalg.matvec(T, consistency(m).u)
    L = symmetry(m).L
    if symmetry(m).holds:
        assert same(symmetry(other).L, linalg.matmul(T, L, back))


@st.composite
def g_symplectic_method(draw):
    """Random exact G-symplectic, preconsistent method of the sweep form with V^T G V = G."""
    kind = draw(st.sampled_from(["signs", "quarter turn", "third of a turn"]))
    g = exact(draw(st.sampled_from([Fraction(1), Fraction(-1), Fraction(-2, 3)])))
    if kind == "signs":
        V, G = as_matrix([[1, 0], [0, -1]], "V"), linalg.diagonal([exact(1), g])
    elif kind == "quarter turn":
        V = as_matrix([[1, 0, 0], [0, 0, -1], [0, 1, 0]], "V")
        G = linalg.diagonal([exact(1), g, g])
    else:
        V = as_matrix([[1, 0, 0], [0, 0, -1], [0, 1, -1]], "V")
        G = linalg.block_diagonal(
            as_matrix([[1]], "G"), linalg.scale(g, as_matrix([[2, -1], [-1, 2]], "G"))
        )
    r, s = len(V), draw(st.integers(1, 3))
    rational = st.sampled_from([Fraction(n, d) for n in (-3, -2, -1, 1, 2, 3) for d in (1, 2, 5)])
    D = [exact(draw(rational)) for _ in range(s)]
    X = [[exact(1)] * s] + [[exact(draw(SMALL)) for _ in range(s)] for _ in range(r - 1)]
    B = tuple(tuple(x * d for x, d in zip(row, D, strict=True)) for row in X)
    S = linalg.matmul(linalg.transpose(B), G, B)
    U = linalg.matmul(linalg.transpose(tuple(map(tuple, X))), G, V)
    zero = Exact(0)
    A = tuple(
        tuple(
            S[i][j] / D[i] * Fraction(1, 2 if i == j else 1) if j <= i else zero for j in range(s)
        )
        for i in range(s)
    )
    return GLM(A=A, U=U, B=B, V=V, G=G, D=D)


@given(m=g_symplectic_method())
@examples(40)
def test_methods_of_the_sweep_form_are_g_symplectic(m):
    assert all(x == 0 for _, part in form_identities(m, m.G, m.D) for row in part for x in row)
    assert g_symplectic(m).holds is True
    found = g_symplectic(m.bare())
    assert found.holds is True
    space = find_forms(m)
    if len(space.forms) == 1:
        assert same(found.G, m.G) and found.D == m.D


@given(m=g_symplectic_method(), data=st.data())
@examples(40)
def test_disturbed_methods_do_not_conserve_the_form(m, data):
    letter = data.draw(st.sampled_from("AUBV"))
    rows = [list(row) for row in getattr(m, letter)]
    i = data.draw(st.integers(0, len(rows) - 1))
    j = data.draw(st.integers(0, len(rows[0]) - 1))
    rows[i][j] = rows[i][j] + Fraction(1, 7 * 10**20)
    other = m.bare(**{letter: rows}, G=m.G, D=m.D)
    found = g_symplectic(other)
    assert found.holds is False and 0 < found.residual < 1e-15 and "entry" in found.witness


@pytest.mark.slow
@given(m=g_symplectic_method())
@examples(15)
def test_eigenvalues_of_g_symplectic_methods_never_leave_at_once_where_v_has_simple_ones(m):
    # V has simple eigenvalues of modulus one and M(iy) conserves G: mirrored in the circle they
    # cannot leave it before two of them meet
    found = periodicity(m)
    assert found.infinite or found.end is None or float(found.end) > 0


@given(alpha=st.lists(SMALL, min_size=2, max_size=4), beta=st.lists(SMALL, min_size=2, max_size=4))
@examples(60)
def test_reduced_multistep_methods_have_the_same_stability_polynomial_but_for_zeros(alpha, beta):
    k = min(len(alpha), len(beta))
    alpha, beta = alpha[:k], beta[:k]
    assume(alpha[-1] != 0 and any(beta))
    try:
        m = linear_multistep(alpha, beta)
    except DataError:  # consistent in reversed order only
        reject()
    w_rho_sigma = stability_polynomial(m)
    # det(w I - M(z)) det(I - z A) = w^shift (rho(w) - z sigma(w)) / alpha_k, up to carried zeros
    lead = exact(alpha[-1])
    expected = [(exact(a) / lead, -exact(b) / lead) for a, b in zip(alpha, beta, strict=True)]
    rows = [tuple(p[j] if j < len(p) else Exact(0) for j in range(2)) for p in w_rho_sigma]
    while rows and all(x == 0 for x in rows[0]):
        rows = rows[1:]
    while expected and all(x == 0 for x in expected[0]):
        expected = expected[1:]
    assert rows == expected
    small = reduce(m)
    assert small.r <= m.r and small.s <= m.s


@pytest.mark.parametrize("name", ["gsymplectic-n", "gauss-2", "pair-4-4"])
def test_what_was_found_cannot_be_changed(name):
    m = glmref.load(name)
    found = [order_of(m), symmetry(m), growth(m), g_symplectic(m), reduction(m), find_forms(m)]
    if isinstance(m, GLM):
        found += [consistency(m), power_bounded(m.V), real_interval(m)]
        found += growth(m).growths
    for result in found:
        for field in fields(result):
            refused(FrozenInstanceError, "", setattr, result, field.name, None)


# --- pairs of one method --------------------------------------------------------------------------


def test_one_method_as_a_pair_with_equal_blocks_gives_the_same_verdicts():
    for name in ("rk4", "gauss-2", "gsymplectic-n", "radau-iia-2"):
        m = glmref.load(name)
        pair = PartitionedGLM(*[getattr(m, x) for x in "AUBV"] * 2)
        single, double = facts_of(m.bare()), facts_of(pair)
        assert (
            single.kernel.range("order-identity").value
            == double.kernel.range("order-identity").value
        )
        for claim in ("preconsistent", "consistent", "zero-stable", "explicit", "symmetric"):
            assert single.truth(claim) is double.truth(claim), (name, claim)
        assert single.truth("g-symplectic") is double.truth("g-symplectic"), name
