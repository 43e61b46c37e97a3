"""Backward error analysis: underlying one-step methods, modified equations, conjugacy, H~."""

from dataclasses import replace
from fractions import Fraction as F
from itertools import pairwise
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import glmref
from glmref import GLM, Tree, load, modified
from glmref.catalogue.claims import (
    CONJUGATE_SYMPLECTIC,
    ENERGY_ORDER,
    HAMILTONIAN_TO_ORDER,
    SECOND_ORDER_GROWTH,
)
from glmref.engine.reference import stepper
from glmref.errors import ExactnessError, UsageError
from glmref.exact import exact, linalg
from glmref.exact.expression import parse
from glmref.findings import Verdict
from glmref.judge import rules_modified
from glmref.judge.linalg import kernel
from glmref.method.component import ROOTED, SEPARABLE
from glmref.problems.nilpotent import Derivatives
from glmref.prove.verifier import verify
from glmref.theory.backward import (
    LARGEST_CONJUGATE,
    _change_equations,
    coefficient,
    composed,
    conjugacy,
    elementary_hamiltonians,
    energy_reach,
    hamiltonian_defects,
    hamiltonian_reach,
    over_free_trees,
)
from glmref.theory.coefficients import is_zero
from glmref.theory.order import order_of
from glmref.theory.second_order import second_order
from glmref.theory.series import (
    Series,
    compose,
    conjugated,
    exponential,
    flow,
    inverse,
    modified_equation,
)
from glmref.theory.symplectic import g_symplectic
from glmref.theory.trees import free_trees, halves, trees, trees_up_to
from glmref.theory.underlying import UnderlyingMethod
from tests.build import high, refused
from tests.shipped import shipped

PAGE = Path(__file__).parents[2] / "docs" / "modified.md"

G_SYMPLECTIC = [n for n in glmref.names() if shipped(n).get("claims", {}).get("g-symplectic")]


def _random_field(seed: int, order: int, palette=ROOTED) -> Series:
    values = {
        t: F((seed * 7919 + 31 * i) % 13 - 6, 5) for i, t in enumerate(trees_up_to(order, palette))
    }
    return Series(values, 0, order, palette)


# -- series of maps and fields


@pytest.mark.slow
@given(seed=st.integers(0, 10**6))
@settings(max_examples=10, deadline=None)
def test_laws_of_the_exponential(seed):
    for palette in (ROOTED, SEPARABLE):
        b, c = _random_field(seed, 5, palette), _random_field(seed + 1, 5, palette)
        phi, chi = exponential(b), exponential(c)
        assert modified_equation(phi) == b
        assert exponential(b, chi) == compose(phi, chi)
        minus = Series({t: -x for t, x in b.support().items()}, 0, 5, palette)
        assert exponential(minus) == inverse(phi)
        chosen = conjugated(b, c)
        assert compose(exponential(chosen), chi) == compose(chi, phi) and chosen != b


def test_the_field_of_the_flow_is_that_of_the_problem():
    f = Series({Tree("o"): 1}, 0, 6)
    assert exponential(f) == flow(6) and modified_equation(flow(6)) == f
    other = exponential(_random_field(5, 6))
    assert exponential(f, other) == compose(flow(6), other)


# -- the underlying one-step method


@pytest.mark.parametrize("name", ["gsymplectic-n", "ab-2", "bdf-2", "gsymplectic-n-pair"])
def test_the_definition_holds(name):
    method = load(name)
    for form in (None, g_symplectic(method).G):
        found = UnderlyingMethod.of_method(method, form=form).through(5)
        eta = Series(found.eta, {c: x.u for c, x in found.components.items()}, 5, found.palette)
        right = compose(found.map, eta)
        for t in trees_up_to(5, found.palette):
            V = method.components[list(found.palette).index(t.colour)].V
            left = found.output(t)
            for i, row in enumerate(V):
                value = sum((v * x for v, x in zip(row, found.value(t), strict=True)), left[i])
                assert is_zero(value - right[t][i]) is True


def test_ab2_is_the_recursion_of_its_output():
    # y_2 = y_1 + h (3 f(y_1) - f(y_0)) / 2 along y_k = Phi^k(y): known from the definition alone
    phi = UnderlyingMethod.of_method(load("ab-2")).through(4).map
    slope = Series({Tree("o"): 1}, 0, 5)
    after = Series({t: compose(phi, slope.truncate(4))[t] for t in trees_up_to(4)}, 0, 4)
    twice = compose(phi, phi)
    for t in trees_up_to(4):
        assert twice[t] - phi[t] == F(3, 2) * after[t] - F(1, 2) * slope[t]


# -- which fields are Hamiltonian


def test_the_kernel_of_the_change_equations_is_the_hamiltonian_fields():
    # so a failure excludes every change of variables; the orders beyond are in the slow test
    for palette, most in ((ROOTED, 5), (SEPARABLE, 4)):
        _check_ranks(palette, range(1, most + 1))


@pytest.mark.slow
def test_the_kernel_through_the_largest_order():
    _check_ranks(ROOTED, range(6, LARGEST_CONJUGATE))
    _check_ranks(SEPARABLE, range(5, LARGEST_CONJUGATE))


def test_the_judge_changes_what_is_not_hamiltonian():
    # what it leaves open of a change of variables is Hamiltonian: docs/certificates.md, section 5
    for n in range(1, rules_modified.LARGEST):
        unknowns, rows = rules_modified.change_rows(n)
        for c in (dict(zip(unknowns, x, strict=True)) for x in kernel(rows)):
            assert all(c[t] + c[moved] == 0 for t, moved, _, _ in rules_modified.pairs(n))


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["lobatto-iiia-3", "gsymplectic-n", "ab-2"])
def test_an_order_of_the_modified_equation_is_proved_and_a_near_miss_refuted(name):
    def verdict(claim, value, method):
        (finding,) = verify(replace(method, claims={claim: value}), only=[claim])
        if method.document is not None:
            assert finding.value == claims[claim]  # what is found, whatever is declared
        return finding.verdict

    method = load(name)
    found = modified(name, 7)
    claims = {CONJUGATE_SYMPLECTIC.key: not found.conjugate_symplectic.fails,
              HAMILTONIAN_TO_ORDER.key: found.hamiltonian.order,
              ENERGY_ORDER.key: found.energy.order}  # fmt: skip
    for claim, value in claims.items():
        assert verdict(claim, value, method) is Verdict.HOLDS
        other = value + 1 if type(value) is int else not value
        assert verdict(claim, other, method) is Verdict.FAILS
    # no form is left, and no change of variables
    assert verdict(CONJUGATE_SYMPLECTIC.key, True, _twin(method)) is Verdict.FAILS


def _check_ranks(palette, orders):
    colours = tuple(palette.items())
    for n in orders:
        hamiltonian = sum(not free.superfluous for free in free_trees(n, colours))
        assert _change_equations(n, colours)[2] == len(trees(n, palette)) - hamiltonian


def symplectic_defects(series, order):
    """``a(u o v) + a(v o u) - a(u) a(v)`` of an order with the tree u o v."""
    found = {}
    for t in trees(order, series.palette):
        for u, v in halves(t):
            found[frozenset((t, v * u))] = t, series[t] + series[v * u] - series[u] * series[v]
    return found.values()


def test_a_symplectic_map_has_a_hamiltonian_field():
    for name in ("gauss-3", "stormer-verlet", "symplectic-euler-a"):
        found = UnderlyingMethod.of_method(load(name)).through(7)
        for n in range(1, 8):
            assert all(is_zero(x) is True for _, x in symplectic_defects(found.map, n))
            assert all(is_zero(x) is True for _, x in hamiltonian_defects(found.field, n))
    rk4 = UnderlyingMethod.of_method(load("rk4")).through(6)
    assert [
        any(is_zero(x) is False for _, x in symplectic_defects(rk4.map, n)) for n in (4, 5)
    ] == [False, True]


#: name, order computed, orders reached: Hamiltonian, conjugate-symplectic, preserving H; None: all.
#: Hairer, Zbinden (2013) for those of Runge-Kutta methods.
ORDERS = [
    ("implicit-midpoint", 7, None, None, 2),
    ("trapezoidal", 7, 2, None, 2),
    ("gauss-2", 7, None, None, 4),
    ("rk4", 6, 4, 4, 4),
    ("lobatto-iiia-3", 8, 4, 6, 4),
    ("gsymplectic-n", 7, 4, None, 4),
    ("s4-symmetric", 6, 4, None, 4),
    ("g6245-w3", 8, 6, None, 6),
    ("stormer-verlet", 7, None, None, 2),
    ("symplectic-euler-b", 6, None, None, 1),
]


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("name", "order", "hamiltonian", "conjugate", "energy"), ORDERS)
def test_orders_of_conservation(name, order, hamiltonian, conjugate, energy):
    found = modified(name, order)
    reaches = (found.hamiltonian, found.conjugate_symplectic, found.energy)
    for reach, known in zip(reaches, (hamiltonian, conjugate, energy), strict=True):
        assert (reach.order, reach.fails) == ((order, False) if known is None else (known, True))
        assert reach.residual == 0.0


def test_the_table_of_the_page_is_the_tested_one():
    known = {name: reached for name, _, *reached in ORDERS}
    rows = [line.split("|")[1:-1] for line in PAGE.read_text().splitlines() if "| `" in line]
    assert len(rows) == 7
    for name, *cells in rows:
        shown = [None if "every" in x else int(x.split(",")[0]) for x in cells]
        assert shown == known[name.strip(" `")]
        assert all("not" not in x or f"{n}, not {n + 1}" in x
                   for n, x in zip(shown, cells, strict=True))  # fmt: skip


def test_first_defects_in_the_output_gauge():
    """Largest b(u o v) + b(v o u) of the first order that fails, as found in another program."""
    for name, order, size in (("trapezoidal", 3, 0.25), ("gsymplectic-n", 5, 6.446e-3),
                              ("s4-symmetric", 5, 1.481e-2), ("g6245-w3", 7, 4.168e-4)):  # fmt: skip
        field = UnderlyingMethod.of_method(load(name)).through(order).field
        sizes = [
            abs(complex(x)) for _, x in hamiltonian_defects(field, order) if is_zero(x) is False
        ]
        assert max(sizes) == pytest.approx(size, rel=1e-3)


def test_the_averaged_vector_field_preserves_energy():
    # y_1 = y_0 + h int f((1 - s) y_0 + s y_1) ds: a B-series with a([t1..tm]) = prod a(ti)/(m + 1)
    values: dict[Tree, F] = {}
    for t in trees_up_to(7):
        values[t] = F(1, len(t.children) + 1)
        for child in t.children:
            values[t] *= values[child]
    field = modified_equation(Series(values, 1, 7))
    assert energy_reach(field) == energy_reach(Series({Tree("o"): 1}, 0, 7))
    assert hamiltonian_reach(field).order == 2 and conjugacy(field).reach.order == 4


# -- G-symplecticity implies conjugate symplecticity (D'Ambrosio, Hairer, Zbinden 2013)


def _check_theorem(name, order):
    method = load(name)
    found = UnderlyingMethod.of_method(method, form=g_symplectic(method).G).through(order)
    plain = UnderlyingMethod.of_method(method).through(order)
    for n in range(1, order + 1):
        for _, x in (*symplectic_defects(found.map, n), *hamiltonian_defects(found.field, n)):
            # exact, or within the digits of the file
            assert is_zero(x) is True or (not method.is_exact and x.magnitude() < 1e-12)
    # both gauges are conjugate by what the output reads off the start
    change = found.reading
    moved = compose(compose(change, plain.map), inverse(change))
    assert all(is_zero(moved[t] - found.map[t]) is not False for t in moved)


@pytest.mark.sampled(6, whole=6)
@pytest.mark.parametrize("name", G_SYMPLECTIC)
def test_g_symplectic_methods_are_conjugate_symplectic(name):
    _check_theorem(name, 6)


@pytest.mark.slow
def test_the_form_of_a_complex_method_is_hermitian():
    # G is real and the values are not: without the conjugates it fails first at order 7
    _check_theorem("g6245-w3-complex", 7)


@pytest.mark.slow
@pytest.mark.sampled(0, whole=5)  # GLMREF_LONG: all
@pytest.mark.parametrize("name", G_SYMPLECTIC)
def test_g_symplectic_methods_are_conjugate_symplectic_to_order_8(name):
    _check_theorem(name, 8)


@pytest.mark.sampled(6, whole=20)
@pytest.mark.parametrize("name", G_SYMPLECTIC)
def test_wrong_twins_are_not(name):
    twin = _twin(load(name))
    reach = conjugacy(UnderlyingMethod.of_method(twin).through(4).field).reach
    assert reach.fails and reach.order < 4


def _twin(method):
    """The method with 1/1000 added to an entry of A."""
    return method.bare(A=((method.A[0][0] + F(1, 1000), *method.A[0][1:]), *method.A[1:]))


# -- modified Hamiltonians


@pytest.mark.parametrize(
    ("name", "terms"),
    [
        ("implicit-midpoint", {"[oo]": "-1/24", "[oooo]": "7/5760", "[[[oo]]]": "1/480",
                               "[[o][o]]": "1/160"}),
        ("gauss-2", {"[oo]": "0", "[oooo]": "-1/4320", "[[[oo]]]": "-1/720",
                     "[[o][o]]": "-1/1440"}),
        ("gsymplectic-n", {"[oo]": "0", "[oooo]": "-1/4320", "[[[oo]]]": "(10*sqrt(3)-17)/1440",
                           "[[o][o]]": "(5*sqrt(3)-8)/720"}),
        # logarithm of exp(hT) exp(hU): Baker, Campbell, Hausdorff; H(f[k[f]]) = -U_qq T_p^2
        ("symplectic-euler-a", {"f[kk]": "1/12", "f[k[f]]": "-1/12"}),
        ("symplectic-euler-b", {"f[kk]": "1/12", "f[k[f]]": "-1/12"}),
        # kick, drift, kick: h^2 (U_qq T_p^2/12 - T_pp U_q^2/24); HLW (2006), section IX.9
        ("stormer-verlet", {"f[k]": "0", "f[kk]": "-1/24", "f[k[f]]": "-1/12"}),
        ("position-verlet", {"f[k]": "0", "f[kk]": "1/12", "f[k[f]]": "1/24"}),
    ],
)  # fmt: skip
def test_modified_hamiltonians_that_are_known(name, terms):
    found = modified(name, 5).hamiltonian_terms
    for tree, value in terms.items():
        assert is_zero(coefficient(found, Tree(tree)) - parse(value)) is True


def test_the_free_number_of_the_symplectic_gauge():
    method = load("gsymplectic-n")
    found = UnderlyingMethod.of_method(method, form=g_symplectic(method).G).through(4)
    t = Tree("[o[o]]")
    w, eta = found.components["o"].W[0], found.value(t)
    assert is_zero(linalg.dot(w, eta) + parse("(2*sqrt(3)-3)/288")) is True


def test_a_hamiltonian_of_any_representative_is_wrong():
    # b/sigma of one rooted tree is not the coefficient: [[o[o]]] belongs to the free tree of [[[oo]]]
    field = modified("implicit-midpoint", 5).field
    t = Tree("[[o[o]]]")
    terms = over_free_trees(elementary_hamiltonians(field))
    assert coefficient(terms, t) == F(-1, 480) and field[t] / t.symmetry != F(-1, 480)


def _series(terms, order, palette):
    values = {free.root: x * free.root.symmetry for free, x in terms.items()}
    return Series(values, 0, order, palette)


@pytest.mark.parametrize("name", ["gsymplectic-n", "lobatto-iiia-3", "trapezoidal", "pair-4-4"])
def test_the_outputs_conserve_the_invariant(name):
    found = modified(name, 6)
    order = found.conjugate_field.order
    invariant = _series(found.invariant_terms, order, found.field.palette)
    after = over_free_trees(composed(invariant, found.map.truncate(order)))
    for free, x in found.invariant_terms.items():
        assert abs(complex(x - coefficient(after, free.root))) < 1e-60
    # the Hamiltonian of the changed variables is not conserved by the output
    if name != "pair-4-4":
        other = _series(found.hamiltonian_terms, order, found.field.palette)
        assert over_free_trees(composed(other, found.map.truncate(order))) != over_free_trees(other)


# -- values at a state


def test_derivatives_of_every_function():
    names = ("sin(y[0])", "cos(y[0])", "tan(y[0])", "exp(y[0])", "log(y[0])", "sqrt(y[0])",
             "y[0]**5", "y[0]**-2", "y[0]**1.5", "1/(2 + y[0])", "2**y[0]", "y[0]**y[0]",
             "atan2(y[0], 3 - y[0])", "y[0]/3 - 1")  # fmt: skip
    context = high(60)
    for text in names:
        problem = glmref.Problem(f=(text,), y0=(F(7, 10),))
        slope = problem.on(context).f
        point = context.mpf(7) / 10
        along = Derivatives(problem.f, [point], context, timed=True)
        for m in range(5):
            (found,) = along.along([([context.mpf(2)], m)] if m else [])
            known = 2**m * context.diff(lambda x, f=slope: f(0, [x])[0], point, m)
            assert abs(found - known) < 1e-10 * (1 + abs(known)), (text, m)


def test_derivatives_along_several_directions_are_multilinear():
    problem = glmref.problem("henon-heiles")
    a, b = np.array([1.0, 2, 3, 4]), np.array([-1.0, 0.5, 2, 1])
    at = Derivatives(problem.f, [0.1, 0.2, 0.3, 0.4], None, timed=True)
    both = np.array(at.along([(a + b, 2)]))
    parts = np.array(at.along([(a, 2)])) + np.array(at.along([(b, 2)]))
    parts += 2 * np.array(at.along([(a, 1), (b, 1)]))
    assert np.allclose(both, parts, rtol=1e-14)
    # f is a quadratic polynomial
    assert not np.any(at.along([(a, 3)]))


@pytest.mark.slow
def test_energies_of_the_oscillator_in_closed_form():
    """Every map below turns the ellipse Q by an angle theta: H~ = theta Q / (2 sin theta) there."""
    problem = glmref.problem("harmonic-oscillator")
    h, q, p = mpmath.mpf("0.1"), mpmath.mpf("0.7"), mpmath.mpf("-0.4")
    with mpmath.workdps(40):
        theta = mpmath.acos(1 - h * h / 2)
        scale = theta / (2 * mpmath.sin(theta))
        known = {
            "implicit-midpoint": (q * q + p * p) / h * mpmath.atan(h / 2),
            "symplectic-euler-a": scale * h * (p * p + q * q - h * p * q) / h,
            "symplectic-euler-b": scale * h * (p * p + q * q + h * p * q) / h,
        }
        for name, energy in known.items():
            found = modified(name, 8)
            errors = [
                abs(found.energy_at(problem, [q, p], h, order=n, digits=40) - energy)
                for n in (2, 4, 6, 8)
            ]
            assert errors[-1] < h**8
            assert all(later < h * earlier for earlier, later in pairwise(errors))


def test_problems_that_have_no_modified_energy_are_refused():
    found = modified("stormer-verlet", 3)
    with pytest.raises(UsageError, match="not separable"):
        found.energy_at(glmref.problem("double-pendulum"), [1, 1, 0, 0], 0.1)
    with pytest.raises(UsageError, match="Hamiltonian"):
        found.energy_at(glmref.Problem(f=("-y[0]", "y[1]"), y0=(1, 1)), [1, 1], 0.1)
    refused(UsageError, "state of 2", found.energy_at, glmref.problem("pendulum"), [1, 1, 1], 0.1)
    with pytest.raises(UsageError, match="`order`"):
        found.energy_at(glmref.problem("pendulum"), [1, 1], 0.1, order=4)
    own = glmref.Problem(dq=lambda p: p, dp=lambda q: -abs(q), y0=(1, 1), canonical=True,
                         hamiltonian="y[0]")  # fmt: skip
    refused(UsageError, "expressions", found.energy_at, own, [1, 1], 0.1)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "h", "end"), [("pendulum", 0.05, 20), ("kepler", 0.02, 12)])
@pytest.mark.parametrize(
    "method", ["gauss-2", "gsymplectic-n", "s4-symmetric", "stormer-verlet", "pair-4-4"]
)
def test_the_oscillation_of_the_energy_is_predicted(method, name, h, end):
    problem = glmref.problem(name)
    run = glmref.solve(problem, method, h=h, t_end=end, every=1)
    energies = np.array([problem.hamiltonian(y) for y in run.y])
    measured = np.max(np.abs(energies - energies[0]))
    found = modified(method, 5).oscillation(problem, run.y[::4], h)
    assert found == pytest.approx(measured, rel=0.02)


def test_the_modified_energy_of_a_run_drifts_by_a_higher_power():
    problem, drifts = glmref.problem("pendulum"), []
    for h in (0.2, 0.1):
        run = glmref.solve(problem, "gsymplectic-n", h=h, t_end=10, every=round(1 / h))
        plain = [problem.hamiltonian(y) for y in run.y]
        drifts.append([np.ptp(plain), np.ptp(run.modified_energy(5))])
    assert np.log2(np.divide(*drifts)) == pytest.approx([4, 6], abs=0.3)
    run = glmref.solve(problem, "rk4", h=0.1, t_end=1, every=1)
    refused(UsageError, "to order 4 only", run.modified_energy, 5)


# -- parasitic parts to second order


def test_invariants_of_second_order_that_are_known():
    """I3 of g6245-w3 as found in another program, by a series over trees with a marked leaf."""
    third, half, _ = second_order(load("g6245-w3"))
    assert complex(half.eigenvalue) == -1 and complex(half.I3) == pytest.approx(-0.0138580592)
    assert complex(third.I3) == pytest.approx(0.0115586592)
    assert half.I1.is_zero() is True  # stage order 2
    (g4123,) = second_order(load("g4123"))
    assert g4123.I1 == F(2, 25)
    refused(ExactnessError, "growth parameters zero", second_order, load("gsymplectic-n"))


PARASITIC = [n for n in G_SYMPLECTIC if "w3" in n or n in ("g4123", "g6245", "t115-i", "s5i1-i")]


@pytest.mark.sampled(3, whole=8)
@pytest.mark.parametrize("name", [*PARASITIC, "s4-symmetric", "thesis-3-8"])
def test_the_trace_rule(name):
    # the sum of I3 is (2/3) tr A^3
    method = load(name)
    cube = linalg.matmul(method.A, method.A, method.A)
    total = sum(one.I3 for one in second_order(method)) - F(2, 3) * sum(
        row[i] for i, row in enumerate(cube)
    )
    assert total.is_zero() is True or (total.is_zero() is None and total.magnitude() < 1e-60)


def test_the_trace_rule_needs_its_hypotheses():
    # with another entry of A neither symmetric nor G-symplectic, and of order 1 only
    method = _twin(load("s4-symmetric"))
    V, A, B, U = method.V, method.A, method.B, method.U
    other = linalg.sub(A, linalg.matmul(U, linalg.inverse(V), B))
    cubes = [linalg.matmul(x, x, x) for x in (A, other)]
    traces = [sum(x[i][i] for i in range(len(A))) for x in cubes]
    assert (traces[0] + traces[1]).is_zero() is False


def _three(a, turn=0):
    """Return the method of three symmetric stages with mu = I1 = 0, w = p (1, a, 1), and I3.

    The K of K w = 0 is changed by ``turn``, with the same K 1.
    """
    g, ends = (2 * a - 1) * (a + 1) ** 2 / (3 * a * a), a * a / (2 * (a * a - 1))
    d, w = (ends, 1 - 2 * ends, ends), (F(1), a, F(1))
    t = exact((a * a - 1) / (6 * a)).sqrt() * (ends / (1 - a))
    inner, outer = t + turn, t * -a - turn
    K = ((0, inner, outer), (-inner, 0, inner), (-outer, -inner, 0))
    A = [[K[i][j] / d[i] + (1 + g * w[i] * w[j]) * d[j] / 2 for j in range(3)] for i in range(3)]
    U, B = [[1, -g * x] for x in w], [d, [x * y for x, y in zip(w, d, strict=True)]]
    turned = (inner * a + outer) / ends
    return GLM(A=A, U=U, B=B, V=[[1, 0], [0, -1]]), turned * turned * (-2 * g * ends)


@pytest.mark.parametrize("a", ["2", "3", "-1/5", "-1/3", "-1/2", "-1/10"])
def test_three_symmetric_stages_have_no_growth_of_second_order(a):
    a = F(a)
    method, known = _three(a)
    (found,) = second_order(method)
    assert found.I1 == found.I3 == known == 0
    result = order_of(method, principal="free")
    assert result.order == (6 if a == F(-1, 10) else 4)
    other, more = _three(a, F(1, 9))
    assert second_order(other)[0].I3 == more and more != 0


@pytest.mark.parametrize("name", ["s4-symmetric", "thesis-3-8"])
def test_growth_of_second_order_of_a_pair(name):
    method, g = load(name), (1, F(-1, 4), F(-1, 4))
    d = method.B[0]
    X = [[x / y for x, y in zip(row, d, strict=True)] for row in method.B]
    gram = [[linalg.dot(row, x) for x in X] for row in method.B]
    assert [row[0] for row in gram] == [1, 0, 0]  # m = 0
    total = exact(0)
    for w, products in zip(X[1:], gram[1:], strict=True):
        for i, (row, y) in enumerate(zip(method.A, d, strict=True)):
            half = sum((a * b[i] * c for a, b, c in zip(products, X, g, strict=True)), exact(0)) / 2
            turned = linalg.dot(row, w) - half
            total = total + turned * turned * y
    assert all(one.I3 == total / 8 for one in second_order(method))


def test_the_method_without_growth_of_second_order_is_the_one_of_order_6():
    method, shipped = _three(F(-1, 10))[0], load("s3z")
    assert method.A == shipped.A  # values beyond the first are scaled by 10
    assert [[10 * x for x in row] for row in method.B[1:]] == [list(row) for row in shipped.B[1:]]


def _floquet(method, steps, digits=40):
    """Return the rate per h^2 and unit of time of the part at -1, predicted and of the whole method.

    On the orbit of the pendulum through (1.2, 0), for as many steps as its period has.
    """
    (found,) = second_order(method)
    engine = stepper(method, glmref.problem("pendulum"), digits=digits)
    with mpmath.workdps(digits):
        q, small = mpmath.mpf(6) / 5, mpmath.mpf(10) ** -20
        period = 4 * mpmath.ellipk(mpmath.sin(q / 2) ** 2)
        h = period / steps
        start = modified(method, 4).start_at(glmref.problem("pendulum"), [q, 0], h, digits=digits)
        runs, angles = [start, *(start + small * x.reshape(2, 2) for x in np.eye(4, dtype=int))], []
        for _ in range(steps):
            angles.append(engine.solution(runs[0])[0])
            runs = [engine.step(0, x, h).values for x in runs]
        whole = mpmath.matrix([list(((x - runs[0]) / small).reshape(4)) for x in runs[1:]])
        parts = mpmath.eig(whole, left=False, right=False)
        one = next(x for x in parts if x.real < 0)
        (V2, V22, bent) = (sum(map(f, angles)) / steps for f in (
            mpmath.cos, lambda x: mpmath.cos(x) ** 2, lambda x: mpmath.sin(x) ** 2))  # fmt: skip
        I1, I3 = (found.I1.to_mpf(), found.I3.to_mpf())
        predicted = mpmath.sqrt(I3 * V2 * (I3 * V22 - I1 * bent) * -1)
        return abs(predicted), abs(mpmath.log(-one)) / (h * h * period)


@pytest.mark.slow
def test_a_parasitic_part_turns_as_the_invariants_say():
    coarse, fine = (seen / told for told, seen in (_floquet(load("g4123"), n) for n in (41, 81)))
    limit = fine + (fine - coarse) / ((81 / 41) ** 2 - 1)  # the error is of order h^2
    assert float(limit) == pytest.approx(1, abs=1e-3)


def test_invariants_are_proved_and_near_misses_refuted():
    def verdict(value, method):
        claims = {SECOND_ORDER_GROWTH.key: value}
        (finding,) = verify(replace(method, claims=claims), only=list(claims))
        return finding.verdict

    method = load("s4-symmetric")
    stated = method.claims[SECOND_ORDER_GROWTH.key]
    assert verdict(stated, method) is Verdict.HOLDS
    for other in (
        stated[:2],
        [*stated[:3], "1/97"],
        [stated[0] + "+1/1000000000", *stated[1:]],
        [],
    ):
        assert verdict(other, method) is Verdict.FAILS
    # an entry of A that is wrong by 1/1000 leaves no growth parameter at 0, and order 1
    assert verdict(stated, _twin(method)) is Verdict.OPEN
    # another root: of x^2 + x + 1 in V that of x^2 + 1
    turned = ((F(0), F(-1)), (F(1), F(0)))
    V = tuple(
        tuple(exact(turned[i - 1][j - 1]) if i and j else x for j, x in enumerate(row))
        for i, row in enumerate(method.V)
    )
    assert verdict(stated, replace(method, V=V, document=None)) is not Verdict.HOLDS
    assert verdict(["0", "0"], load("leapfrog")) is Verdict.OPEN  # its growth parameter is not 0
    assert verdict([], load("rk4")) is Verdict.HOLDS
