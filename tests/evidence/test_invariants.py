"""G-symplectic methods keep quadratic invariants in the sense of G to round-off; others do not.

The problems are random: y' = S(y) C y with S skew and affine in y, C symmetric, so that y^T C y is
the only invariant. Nothing but the property itself can keep it.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.catalogue.keys import PAIRS
from glmref.catalogue.lookup import document, load, names
from glmref.engine.solve import solve
from glmref.measure.longtime import along, g_form
from glmref.problems import problem
from glmref.prove.facts import facts_of
from tests.shipped import claiming, shipped

#: The bound is linear in the number of steps: of few it asks as much of each as of many, and
#: tests/laws/test_engine_laws.py has the long runs.
STEPS = 250
SEEDS = (1, 7, 23)


def refuted():
    """Broken files whose false claim is that they keep the form they give."""
    found = []
    for name in names("broken"):
        doc = shipped(name)
        if doc["broken"]["claim"] not in ("g-symplectic", "symplectic") or doc["class"] in PAIRS:
            continue
        # without G there is no form to test; where D alone is wrong, the form is kept all the same
        one_step = doc["class"] in ("rk", "composition")
        if one_step or ("G" in doc and name != "gsymplectic-n-d-scaled"):
            found.append(name)
    return found


def form_of(method):
    """The form of the file; where it gives none, the one that theory finds."""
    if method.r == 1:
        return np.eye(1)
    G = method.G if method.G is not None else facts_of(method).g_symplecticity.G
    array = np.array([[complex(x) for x in row] for row in G])
    return array.real if np.all(array.imag == 0) else array


def drift(method, seed, h, steps=STEPS, dimension=4):
    """Largest deviation of the G-form over a run, relative to the size of its terms."""
    subject = problem("skew-quadratic", dimension=dimension, seed=seed)
    found = solve(
        subject, method, h=h, steps=steps, every=max(1, steps // 50), history=True,
        engine="reference",
    )  # fmt: skip
    if not found.completed:
        return np.inf  # stage equations without solution: the values left every bound
    (form,) = subject.quadratic.values()
    G = form_of(method)
    if method.r == 1:
        values = along(form, np.real(found.y))
    else:
        values = g_form(np.asarray(found.history), G, form.matrix)
    first = np.asarray(found.history)[0]
    terms = np.einsum("id,de,je->ij", np.abs(first), np.abs(form.matrix), np.abs(first))
    return float(np.max(np.abs(values - values[0]))) / float(np.sum(terms * np.abs(G)))


def bound(method, steps=STEPS):
    """What rounding can do.

    A step of the textbook form rounds about ``n = s (s + r) + r (s + r)`` products, each with a
    relative error of 2^-53 of a term no larger than the largest entry times the values; and the
    rounded tableau misses the identities by 2^-53 of its entries. Both are linear in the number of
    steps at worst; the random part grows like its square root only.
    """
    entries = [
        abs(complex(x)) for m in (method.A, method.U, method.B, method.V) for r in m for x in r
    ]
    products = (method.s + method.r) ** 2
    return steps * 2.0**-53 * products * max(1.0, max(entries)) ** 2


#: Stage equations solved by iteration, weakly unstable: shorter runs keep them in range.
FORMS = claiming("g-symplectic", "symplectic")
FAST = {"gauss-1", "gauss-2", "gsymplectic-n", "gsymplectic-p", "s4-symmetric", "g6245"}


def test_there_are_many_such_methods_and_wrong_ones():
    assert len(FORMS) >= 25
    assert len(refuted()) >= 6


@pytest.mark.sampled(0, besides=("gauss",), whole=20)
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in FAST else pytest.mark.slow) for n in FORMS]
)
def test_a_g_symplectic_method_keeps_its_form_to_round_off(name):
    method = load(name)
    # a method whose parasitic parts grow would leave the range where rounding is all there is
    steps = STEPS if document(name)["claims"].get("parasitism-free", True) else 200
    for seed in SEEDS[:1] if name == "g6245" or name not in FAST else SEEDS:
        assert drift(method, seed, 1 / 16, steps) < bound(method, steps)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(
    st.integers(0, 10**6), st.integers(2, 5), st.floats(-0.1, 0.1).filter(lambda h: abs(h) > 1e-3)
)
def test_the_form_is_kept_for_any_problem_and_any_step(seed, dimension, h):
    method = load("s4-symmetric")
    assert drift(method, seed, h, steps=60, dimension=dimension) < bound(method, 60)


@pytest.mark.sampled(1, besides=("radau", "lobatto", "sdirk", "trapez"))
@pytest.mark.parametrize(
    "name", ["rk4", "lobatto-iiia-3", "radau-iia-2", "trapezoidal", "sdirk-2", "dormand-prince-5"]
)
def test_a_method_that_is_not_symplectic_loses_the_invariant(name):
    method = load(name)
    assert drift(method, 1, 1 / 16) > 1e3 * bound(method)


@pytest.mark.slow
@pytest.mark.sampled(1, besides=("gsymplectic",), whole=6)
@pytest.mark.parametrize("name", refuted())
def test_a_broken_file_that_claims_the_property_does_not_keep_it(name):
    method = load(name)
    lost = max(drift(method, seed, 1 / 4, steps=200) for seed in SEEDS)
    assert lost > 10 * bound(method, 200)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "name", ["stormer-verlet", "symplectic-euler-a", "ruth-3", "forest-ruth-4", "suzuki-verlet-4"]
)
def test_a_symplectic_pair_keeps_bilinear_invariants(name):
    subject = problem("kepler", eccentricity="1/5")
    found = solve(subject, name, h=0.02, steps=1000, every=20, engine="reference")
    momentum = along(subject.quadratic["angular momentum"], found.y)
    # four products of size one each step
    assert np.max(np.abs(momentum - momentum[0])) < 1000 * 16 * 2.0**-53


@pytest.mark.parametrize("name", ["s4-symmetric", "g6245", "gsymplectic-n"])
def test_a_symmetric_method_goes_back_the_way_it_came(name):
    """``M_{-h}(L M_h(x)) = L x``; with L from the exact side, here only its consequence:
    n steps forward, the involution on the values, n steps back end where they began."""
    from glmref.engine.reference import stepper

    method = load(name)
    L = np.array([[float(x) for x in row] for row in facts_of(method).symmetry.L])
    subject = problem("pendulum", q0="6/5")
    engine = stepper(method, subject)
    random = np.random.default_rng(5)
    values = np.vstack([subject.y0, 1e-3 * random.standard_normal((method.r - 1, 2))])
    turned = values
    for _ in range(50):
        turned = engine.step(0.0, turned, 0.1).values
    turned = L @ turned
    for _ in range(50):
        turned = engine.step(0.0, turned, -0.1).values
    assert np.max(np.abs(turned - L @ values)) < 100 * 2.0**-52 * 16


def test_a_method_without_symmetry_does_not():
    from glmref.engine.reference import stepper

    method = load("thesis-3-8")
    subject = problem("pendulum", q0="6/5")
    engine = stepper(method, subject)
    values = np.vstack([subject.y0, 1e-3 * np.ones((2, 2))])
    # the output involution of section 3.3, which passes B = L B P
    L = np.diag([1.0, -1.0, -1.0])
    there = L @ engine.step(0.0, values, 0.1).values
    back = engine.step(0.0, there, -0.1).values
    assert np.max(np.abs(back - L @ values)) > 1e-4
