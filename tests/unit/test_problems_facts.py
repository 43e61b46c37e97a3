"""Shipped problems: closed forms, invariants, faults and transformed times are what they say."""

import math
from fractions import Fraction
from random import Random

import flint
import numpy as np
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.catalogue.lookup import load
from glmref.conformance.taylor import series_context, taylor_states, vector, working
from glmref.engine.solve import solve
from glmref.measure.law import samples_of
from glmref.problems import Problem, names, problem
from glmref.problems.flows import eccentric_anomaly
from glmref.problems.sundman import time_transformed
from glmref.problems.user_functions import FunctionFailed
from tests.build import high

CASES = [(name, {}) for name in names() if problem(name).exact and name != "long-chain"] + [
    ("kepler", {"eccentricity": 0}),
    ("kepler", {"eccentricity": "999/1000"}),
    ("pendulum", {"q0": 0, "p0": "3"}),
    ("pendulum", {"q0": 1, "p0": "-5/2"}),
    ("pendulum", {"q0": 8, "p0": "1/2"}),
    ("pendulum", {"q0": 0, "p0": 2}),
    ("pendulum", {"q0": 0, "p0": -2}),
    ("pendulum", {"q0": 0, "p0": 0}),
    ("dahlquist", {"real": "-1/10", "imaginary": 2}),
    ("prothero-robinson", {"stiffness": 3}),
    ("kaps", {"epsilon": 1}),
    ("linear-field", {"dimension": 3, "seed": 4}),
    ("long-chain", {"sites": 6, "mode": 3}),
]
DIGITS = 60


def size(y):
    return max(abs(x) for x in y)


@pytest.mark.sampled(10)
@pytest.mark.parametrize(("name", "parameters"), CASES)
def test_exact_solution_solves_the_equation(name, parameters):
    context = high(DIGITS)
    p = problem(name, **parameters).on(context)
    for t in ("0.3", "-0.7"):
        t = context.mpf(t)
        if name == "prothero-robinson" and t < 0:
            continue
        y, step = p.solution(t), context.mpf(10) ** -20
        slope = (p.exact(t + step, p.y0) - p.exact(t - step, p.y0)) / (2 * step)
        f = p.f(t, y)
        # step**2 times the third derivative: (1e6)**3 on the way out of the stiff layer, over
        # r**3.5 = 1e10 for e = 0.999; rounding 1e-60/1e-20 of |y| times the stiffness
        assert size(slope - f) <= 1e-20 * (size(f) + size(y))


@pytest.mark.parametrize(("name", "parameters"), CASES)
def test_exact_solution_starts_at_y0(name, parameters):
    p = problem(name, **parameters)
    # the start is rounded to double, as the result is
    assert p.solution(0.0) == pytest.approx(p.y0, rel=4e-16, abs=1e-16 * size(p.y0))


# the others depend on the time, or are known from special starts only
AUTONOMOUS = [case for case in CASES if case[0] not in ("prothero-robinson", "kaps")]


@pytest.mark.parametrize(("name", "parameters"), AUTONOMOUS)
def test_exact_solution_is_a_flow(name, parameters):
    context = high(DIGITS)
    p = problem(name, **parameters).on(context)
    s, t = context.mpf("1.3"), context.mpf("-2.1")
    if name == "blow-up":
        s = context.mpf("0.3")
    twice, once = p.exact(t, p.exact(s, p.y0)), p.exact(s + t, p.y0)
    # e = 0.999 magnifies the rounding of the middle by some (1 - e)**-3
    assert size(twice - once) <= 1e-45 * (1 + size(once))


def test_exact_solution_in_double_is_rounded_once():
    p, context = problem("kepler"), high(DIGITS)
    mine = p.exact(1000.0, p.y0)
    fine = p.on(context).exact(context.mpf(1000), [context.mpf(float(x)) for x in p.y0])
    assert mine.tolist() == [float(x) for x in fine]


@pytest.mark.parametrize("parameters", [{"q0": 0, "p0": 3}, {"q0": 8, "p0": "1/2"}, {}])
def test_pendulum_closed_form_agrees_with_taylor(parameters):
    p = problem("pendulum", **parameters)
    series = taylor_states(p, [5], digits=25)[0]
    exact = p.on(high(DIGITS)).solution(5)
    assert size(series - exact) < 1e-22


@pytest.mark.parametrize("e", ["0", "0.1", "0.9", "0.999", "0.999999999", "1"])
def test_keplers_equation_is_solved_to_the_last_digit(e):
    context = high(DIGITS)
    e = context.mpf(e)
    for mean in ("0", "1e-50", "1e-9", "0.001", "0.5", "3.14", "-3", "1e6"):
        anomaly = eccentric_anomaly(context.mpf(mean), e, context)
        turns = context.mpf(mean) / (2 * context.pi)
        rest = 2 * context.pi * (turns - context.floor(turns + 0.5))
        residual = anomaly - e * context.sin(anomaly) - rest
        # rounding of the three terms, and of the reduction by whole turns
        assert abs(residual) <= 10 * context.eps * (abs(anomaly) + abs(context.mpf(mean)))


@pytest.mark.slow
def test_long_chain_has_100000_components_and_returns_with_its_mode():
    p = problem("long-chain")
    assert p.dimension == 100_000
    # f = (p, -omega**2 q) for a normal mode; the phases, up to 2 pi, are rounded three times, which
    # the second difference magnifies by 4
    omega = 2 * np.sin(np.pi * 10_000 / (2 * 50_001))
    assert p.f(0.0, p.y0)[50_000:] == pytest.approx(-(omega**2) * p.y0[:50_000], abs=1e-14)


# -- judges judged: energies, quadratic forms and other invariants are constant along f


SMALL = {
    "fput": {"sites": 5, "beta": "1/2"},
    "nonseparable-chain": {"sites": 5},
    "long-chain": {"sites": 5, "mode": 2},
    "toda": {"sites": 5},
    "n-body": {"bodies": 3},
}
VARIANTS = [(name, SMALL.get(name, {})) for name in names() if not name.startswith("fault")] + [
    ("henon-heiles", {"cubic": "1/3"}),
    ("kepler", {"eccentricity": "999/1000"}),
    ("skew-quadratic", {"dimension": 7, "seed": 5}),
    ("dahlquist", {"real": 0, "imaginary": 3}),
    ("fput-stiff", {"springs": 5, "omega": 5000}),
    ("scaled-kepler", {"length": "1000"}),
]


def at_random(name, parameters, seed):
    """A problem in double precision, and a random point near its start as exact numbers."""
    context = high(DIGITS)
    p = problem(name, **parameters)
    y0 = p.on(context).y0
    random = Random(seed)
    size = max(abs(x) for x in y0) or 1
    shift = [size * context.mpf(random.randrange(-1000, 1001)) / 10000 for _ in y0]
    return p, y0 + np.array(shift, dtype=object), context


def slope_along(function, y, direction):
    """Derivative of a function along a direction, a ball: that of a first order Taylor series."""
    flint.ctx.cap = 2
    series = [flint.arb_series([arb(x), slope]) for x, slope in zip(y, direction, strict=True)]
    return function.on(series_context())(vector(series))[1]


def field_of(p, y):
    """The right-hand side at a point, as balls."""
    return p.on(series_context()).f(arb(0), np.array([arb(x) for x in y]))


@pytest.mark.sampled(14)
@pytest.mark.parametrize(("name", "parameters"), VARIANTS)
@working(DIGITS)
def test_every_invariant_is_constant_along_f(name, parameters):
    for seed in (1, 2):
        p, y, _ = at_random(name, parameters, seed)
        f = field_of(p, y)
        for key, function in {**p.invariants, **p.quadratic, "H": p.hamiltonian}.items():
            if function is not None:
                assert 0 in slope_along(function, y, f), key


@pytest.mark.sampled(10)
@pytest.mark.parametrize(("name", "parameters"), VARIANTS)
@working(DIGITS)
def test_an_invariant_off_by_a_billionth_is_noticed(name, parameters):
    # near miss: f with one component changed by 1e-9 of itself
    p, y, _ = at_random(name, parameters, 1)
    conserved = {**p.invariants, **p.quadratic, "H": p.hamiltonian}
    f = field_of(p, y)
    largest = int(np.argmax([float(abs(x)) for x in f]))
    f[largest] *= 1 + arb("1e-9")
    caught = []
    for function in conserved.values():
        if function is not None:
            caught.append(0 not in slope_along(function, y, f))
    assert any(caught) or not caught


CANONICAL = [(n, k) for n, k in VARIANTS if problem(n, **k).canonical]


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("name", "parameters"), CANONICAL)
@working(DIGITS)
def test_canonical_problems_are_j_times_the_gradient_of_h(name, parameters):
    p, y, _ = at_random(name, parameters, 3)
    f, half = field_of(p, y), len(y) // 2
    for i in range(len(y)):
        unit = [arb(int(i == j)) for j in range(len(y))]
        partner = -f[i + half] if i < half else f[i - half]
        assert 0 in slope_along(p.hamiltonian, y, unit) - partner


def test_only_canonical_problems_say_so():
    names_said = {name for name, _ in CANONICAL}
    assert "outer-solar-system" not in names_said and "rigid-body" not in names_said
    assert {"kepler", "pendulum", "henon-heiles", "double-pendulum", "figure-eight"} <= names_said


def test_quadratic_forms_equal_their_matrices():
    for name, parameters in VARIANTS:
        p = problem(name, **parameters)
        for form in p.quadratic.values():
            y = np.linspace(-1, 2, p.dimension)
            assert form(y) == pytest.approx(y @ form.matrix @ y, rel=1e-13)
            assert (form.matrix == form.matrix.T).all()


def test_skew_quadratic_form_is_positive_definite():
    for d in (2, 5, 12):
        form = problem("skew-quadratic", dimension=d, seed=d).quadratic["C"]
        assert np.linalg.eigvalsh(form.matrix).min() > 0.5


# -- extreme and faulty problems do what they say


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        *(("kepler", {"eccentricity": e}) for e in ("9/10", "99/100", "999/1000")),
        *(("harmonic-oscillator", {"q0": q0}) for q0 in ("1e-150", "1e150", "1e-310")),
        *(("scaled-kepler", {"length": size}) for size in ("1e-150", "1e150", "1e-170")),
        ("pendulum", {"q0": "3.1415926535", "p0": 0}),
        *((name, {}) for name in ("pythagorean", "dahlquist", "long-chain", "zero-field")),
        *((name, {}) for name in ("linear-field", "henon-heiles")),
    ],
)
def test_extreme_parameters_are_in_range(name, parameters):
    p = problem(name, **parameters)
    with np.errstate(all="ignore"):
        p.f(0.0, p.y0)


@pytest.mark.parametrize("length", ["1e-150", "1", "1e150"])
def test_scaled_orbits_are_orbits_of_another_size(length):
    p, unit = problem("scaled-kepler", length=length), problem("scaled-kepler", length=1)
    size = float(length)
    # five roundings
    assert p.f(0.0, p.y0) / size == pytest.approx(unit.f(0.0, unit.y0), rel=2e-15)
    assert p.solution(1.0) / size == pytest.approx(unit.solution(1.0), rel=2e-15)
    assert p.hamiltonian(p.y0) == pytest.approx(-0.5, abs=2e-15)


def test_orbits_below_the_range_have_a_field_that_is_not_finite():
    p = problem("scaled-kepler", length="1e-170")
    with np.errstate(all="ignore"):
        assert not np.isfinite(p.f(0.0, p.y0)).all()
    assert np.isfinite(p.solution(1.0)).all()


def test_faults_show_after_their_time():
    with np.errstate(all="ignore"):
        assert np.isfinite(problem("fault-nan").f(0.9, np.ones(1))).all()
        assert np.isnan(problem("fault-nan").f(1.1, np.ones(1))).all()
        assert np.isinf(problem("fault-infinity").f(8.0, np.ones(1))).all()
    with pytest.raises(FunctionFailed, match=r"raised RuntimeError: .* does not hold"):
        problem("fault-raises").f(1.1, np.ones(2))
    with pytest.raises(FunctionFailed, match=r"must return shape \(2,\), got \(3,\)"):
        problem("fault-shape").f(0.0, np.ones(2))
    assert problem("fault-jacobian").jacobian(0.0, np.ones(1)) == [[1e6]]
    assert np.isnan(problem("fault-jacobian-nan").jacobian(0.0, np.ones(1))).all()


# -- the transformed time keeps the Hamiltonian form, and its orbits are those of the problem


RADIUS = "sqrt(y[0]*y[0] + y[1]*y[1])"


def symplectic_defect(p, y):
    """Largest entry of J S + (J S)^T with S = J^-1 f'(y): zero where f is Hamiltonian."""
    m = p.dimension // 2
    J = np.block([[np.zeros((m, m)), np.eye(m)], [-np.eye(m), np.zeros((m, m))]])
    S = J.T @ np.asarray(p.jacobian(0.0, y))
    return np.max(np.abs(S - S.T)) / np.max(np.abs(S))


@pytest.mark.parametrize("e", ["0", "9/10", "999/1000"])
def test_the_orbit_is_that_of_kepler_at_the_time_it_says(e):
    p, plain = problem("kepler-sundman", eccentricity=e), problem("kepler", eccentricity=e)
    context = high(40)
    fine, reference = p.on(context), plain.on(context)
    for s in (0.3, 2.0, 7.5):
        y = fine.exact(context.mpf(s), fine.y0)
        z = reference.exact(y[2], reference.y0)
        assert max(abs(y[i] - z[i]) for i in (0, 1)) < 1e-30
        assert max(abs(y[3 + i] - z[2 + i]) for i in (0, 1)) < 1e-28
    # s is the eccentric anomaly: a turn takes the period
    assert abs(fine.exact(2 * context.pi, fine.y0)[2] - 2 * context.pi) < 1e-35


def test_the_general_transformation_gives_the_same_equations():
    p = problem("kepler-sundman", eccentricity="9/10")
    general = time_transformed(problem("kepler", eccentricity="9/10"), RADIUS)
    assert general.y0.tolist() == pytest.approx(p.y0.tolist(), rel=1e-15)
    y = np.array([0.3, -0.2, 5.0, 0.4, 1.1, 0.6])
    # r times (H + w) against its expansion: a few roundings of terms of size one
    assert general.f(0.0, y) == pytest.approx(p.f(0.0, y), rel=1e-14, abs=1e-15)
    assert general.hamiltonian(y) == pytest.approx(p.hamiltonian(y), abs=1e-14)
    assert general.conserved(general.y0) == pytest.approx(-p.y0[5], abs=1e-14)
    assert general.labels == ("q[0]", "q[1]", "t", "p[0]", "p[1]", "p_t")
    assert general.quadratic["angular momentum"](y) == p.quadratic["angular momentum"](y)


@pytest.mark.parametrize(
    ("name", "rate"),
    [("kepler", RADIUS), ("henon-heiles", "1 + y[0]*y[0]"), ("pendulum", "1/(2 + y[1]*y[1])")],
)
def test_transformed_equations_are_hamiltonian_again(name, rate):
    p = time_transformed(problem(name), rate)
    y = np.array(p.y0) + 0.01 * np.arange(1, p.dimension + 1)
    # differences of a few roundings of the derivatives
    assert symplectic_defect(p, y) < 1e-13


def test_equations_scaled_alone_are_not():
    # near miss: g f instead of J grad (g (H + w))
    plain = problem("pendulum")
    assert plain.expressions is not None
    rate = "(2 + y[0]*y[0])"
    scaled = Problem(f=tuple(f"{rate}*({x})" for x in plain.expressions), y0=plain.y0)
    assert symplectic_defect(scaled, np.array([0.7, 0.4])) > 1e-3


@pytest.mark.slow
def test_a_constant_step_keeps_a_sharp_orbit():
    """At e = 0.99, 800 steps a period: right to 1e-6 in s, and nothing in t."""
    method, steps = load("g6245-w3"), 8000
    ends = []
    for name in ("kepler-sundman", "kepler"):
        p = problem(name, eccentricity="99/100")
        found = solve(p, method, h=20 * math.pi / steps, steps=steps)
        assert found.completed
        right = p.solution(20 * math.pi)[:2]
        ends.append(float(np.linalg.norm(found.y[-1][:2] - right) / np.linalg.norm(right)))
    assert ends[0] < 1e-9 < 1e-1 < ends[1]


@pytest.mark.slow
def test_the_angular_momentum_is_kept_to_round_off_by_a_symplectic_method():
    p = problem("kepler-sundman", eccentricity="99/100")
    found = solve(p, load("gauss-3"), h=0.02, steps=3000, every=50)
    form = p.quadratic["angular momentum"]
    values = np.array([form(y) for y in found.y])
    # a random walk of 3000 steps with a rounding each in terms of size 10
    assert np.max(np.abs(values - values[0])) < 3000 * 10 * 2.0**-53


@settings(deadline=None, max_examples=30)
@given(
    name=st.sampled_from(["kepler", "swinging-atwood", "hill-moon", "henon-heiles", "rigid-body"]),
    a=st.floats(0.1, 3.0), b=st.floats(0.1, 3.0), k=st.integers(0, 2),
)  # fmt: skip
def test_a_transformed_orbit_has_the_same_direction(name, a, b, k):
    """At the energy of the start dy/ds = r f and dt/ds = r, whatever r is."""
    plain = problem(name)
    y = np.asarray(plain.y0, dtype=float)
    rate, value = f"{a!r} + {b!r}*{plain.labels[k]}**2", a + b * y[k] ** 2
    moved = time_transformed(plain, rate)
    at = moved.labels.index("t")
    slope = np.asarray(moved.f(0.0, np.asarray(moved.y0, dtype=float)))
    own = [i for i in range(plain.dimension + 1) if i != at]
    assert slope[at] == pytest.approx(value, rel=1e-15)
    right = value * np.asarray(plain.f(0.0, y))
    # terms of size one cancel in H + p_t, times the gradient of r
    assert slope[own] == pytest.approx(right, rel=1e-13, abs=1e-13 * (1 + b))
    assert moved.canonical == plain.canonical
    assert slope[len(own) + 1 :] == pytest.approx(0.0, abs=0)


def test_a_time_that_occurs_in_equations_is_that_of_the_clock():
    plain = Problem.from_equations({"x": "v", "v": "cos(t) - x"}, {"x": 1, "v": 0}, t0=2)
    moved = time_transformed(plain, "1 + x**2")
    assert moved.labels == ("x", "v", "t") and moved.y0.tolist() == [1, 0, 2]
    y = np.array([0.5, 0.25, 7.0])
    assert moved.f(99.0, y) == pytest.approx([1.25 * 0.25, 1.25 * (math.cos(7) - 0.5), 1.25])


def test_a_transformed_run_passes_where_the_plain_one_does():
    plain = problem("hill-moon")
    moved = time_transformed(plain, "(x**2 + y**2)**(3/4)")
    found = solve(moved, load("gauss-4"), h=0.01, steps=500)
    x, y, u, v, t = found.y[-1]
    right = solve(plain, load("gauss-4"), h=t / 4000, steps=4000).y[-1]
    # of order 8, at the distances of the orbit 1e-12 and less in both
    assert np.abs(right - [x, y, u, v]).max() < 1e-10
    energy = moved.hamiltonian(found.y[-1])
    assert energy == pytest.approx(plain.hamiltonian(plain.y0), abs=1e-11)


def test_a_time_is_transformed_again():
    """Errors of the energy stay those of H, which K = 0 would hide."""
    once = time_transformed(problem("hyperbolic-oscillator"), "1 + qx**2")
    twice = time_transformed(once, "1/(1 + qx**2)")
    plain = problem("hyperbolic-oscillator")
    y = np.asarray(twice.y0, dtype=float)
    assert twice.conserved(y) == pytest.approx(plain.hamiltonian(np.asarray(plain.y0)), rel=1e-15)
    slope = twice.f(0.0, y)
    half = plain.dimension // 2
    right = plain.f(0.0, np.asarray(plain.y0, dtype=float))
    # dt/ds = 1: the plain equations again, to a few roundings of the products
    assert slope[:half] == pytest.approx(right[:half], rel=1e-14, abs=1e-14)
    assert slope[half + 2 : 2 * half + 2] == pytest.approx(right[half:], rel=1e-14, abs=1e-14)


@pytest.mark.parametrize("y0", [[Fraction(1, 3), 0.1], np.array([0.1, 0.7]), ["1/10 + 2**2", "3"]])
def test_a_start_of_any_kind_is_taken_at_its_exact_value(y0):
    moved = time_transformed(Problem.from_hamiltonian("p**2/2 + q**4/4", y0), "1 + q**2")
    fine = moved.on(high(40))
    # K = 0 to the working precision, which it is not where p_t is of other numbers than q and p
    assert abs(fine.hamiltonian(fine.y0)) < 1e-38


def test_a_false_capture_in_a_transformed_time_has_a_notice():
    """The error of K, with the rate as a factor, is small where the orbit is wrong most."""
    H = "(px**2 + py**2)/2 - 1/sqrt(qx**2 + qy**2) - qx**2/(100*(qx**2 + qy**2)**(3/2))"
    y0 = {"qx": 0.625, "qy": -0.255, "px": 0.063, "py": 0.23}
    moved = time_transformed(Problem.from_hamiltonian(H, y0), "(qx**2 + qy**2)**(3/4)")
    found = solve(moved, load("multistep-strong-8"), h=0.05, steps=30_000, every=100)
    energy = np.array([moved.conserved(y) for y in found.y])
    assert abs(energy[-1] / energy[0] - 1) > 1
    assert found.suspect is not None
    followed = samples_of(moved, load("multistep-strong-8"), found, "energy")
    # the same quotient, with one rounding less
    assert followed == pytest.approx((energy - energy[0]) / abs(energy[0]), rel=1e-12, abs=1e-14)
