"""The generated kernels and the reference engine agree to the bits that reordering allows.

Both add the same terms of a step in another order and with rounded coefficients, so that a step of
values of one size may differ by a few units of rounding of the largest one.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from glmref import Problem, load, names, problem, solve
from glmref.engine.codegen import kernel_source
from glmref.engine.kernel import Kernel, prepare
from glmref.engine.kernel_cache import interpret
from glmref.engine.reference import stepper
from glmref.engine.starting_values import zero_start
from glmref.method import PartitionedGLM
from tests.shipped import shipped

EPS = 2.0**-52
STEPS, H = 4, 1 / 128
#: Allowed difference, in units of rounding of the largest value; of all methods the largest is 12.
UNITS = 32
DRIVEN = Problem(f=("y[1]", "-sin(y[0]) + cos(t)/2 - y[1]/8"), y0=("6/5", "-1/3"), name="driven")
PROBLEMS = {
    "pendulum": problem("pendulum"),
    "rigid-body": problem("rigid-body"),
    "driven": DRIVEN,
    "kepler": problem("kepler", eccentricity="1/5"),
    "lotka-volterra-logarithmic": problem("lotka-volterra-logarithmic"),
}
SEPARABLE = ("pendulum", "kepler", "lotka-volterra-logarithmic")
#: At least one of each form, kind of stages and number of values.
QUICK = (
    "rk4", "gauss-3", "sdirk-3", "lobatto-iiia-3", "ab-3", "bdf-2", "gsymplectic-n", "g6245",
    "thesis-3-8", "stormer-verlet", "lobatto-iiia-iiib-3", "gsymplectic-n-pair", "pair-4-4",
)  # fmt: skip
METHODS = [
    name
    for name in names("methods")
    if name != "g6245-w3-complex" and shipped(name)["class"] not in ("additive", "rosenbrock")
]

method_of = lru_cache(maxsize=None)(load)


def is_pair(name):
    return isinstance(method_of(name), PartitionedGLM)


def start(method, of):
    """Values with every component in play: the zero start and something small in each."""
    zero = zero_start(stepper(method, of), of.y0)
    values = zero + 0.01 * np.random.default_rng(11).uniform(-1, 1, zero.shape)
    if isinstance(method, PartitionedGLM):  # what one half does not carry stays zero
        half = zero.shape[1] // 2
        values[method.r :, :half] = values[method.r_hat :, half:] = 0.0
    return values


def by_reference(method, of, values):
    """Values after STEPS steps."""
    engine = stepper(method, of)
    for n in range(STEPS):
        taken = engine.step(n * H, values, H)
        assert taken.converged
        values = taken.values
    return values


def by_kernel(kernel, of, values, method):
    solution = stepper(method, of).solution(values)
    state = kernel.state(values, np.asarray(of.f(0.0, solution)), H)
    out = np.zeros((1, 1, of.dimension))
    outcome, _ = kernel.advance(state, STEPS, t0=0.0, h=H, every=0, out=out)
    assert outcome == "completed"
    return kernel.values(state)


def units(found, expected):
    """Largest difference in units of rounding of the largest value."""
    return np.abs(found - expected).max() / (EPS * np.abs(expected).max())


def differ(method, of, **options):
    """Difference between kernel and reference, in such units."""
    values = start(method, of)
    kernel = prepare(method, of, h=H, **{"interpreted": True, **options})
    return units(by_kernel(kernel, of, values, method), by_reference(method, of, values))


def applicable(name):
    return [of for of in PROBLEMS if of in SEPARABLE or not is_pair(name)]


def marked(quick):
    marks = [() if name in quick else pytest.mark.slow for name in METHODS]
    return [pytest.param(name, marks=m) for name, m in zip(METHODS, marks, strict=True)]


@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", marked(QUICK))
def test_kernels_of_every_method_agree_with_the_reference(name):
    for of in applicable(name):
        assert differ(method_of(name), PROBLEMS[of]) <= UNITS, of


@pytest.mark.sampled(10)
@pytest.mark.parametrize("arithmetic", ["compensated", "naive"])
@pytest.mark.parametrize("name", QUICK)
def test_so_do_the_other_arithmetics(name, arithmetic):
    for of in applicable(name)[:2]:
        assert differ(method_of(name), PROBLEMS[of], arithmetic=arithmetic) <= UNITS, of


@pytest.mark.parametrize("name", ["g6245", "gauss-3", "sdirk-3", "s4-symmetric"])
def test_so_does_newton(name):
    for of in ("pendulum", "rigid-body", "driven"):
        assert differ(method_of(name), PROBLEMS[of], solver="newton") <= UNITS, of


def changed(record, field, place, factor):
    """The record with one number of one of its fields multiplied by a factor."""
    value = getattr(record, field)
    if len(place) == 1:
        (i,) = place
        new = (*value[:i], value[i] * factor, *value[i + 1 :])
    else:
        i, j = place
        row = (*value[i][:j], value[i][j] * factor, *value[i][j + 1 :])
        new = (*value[:i], row, *value[i + 1 :])
    return replace(record, **{field: new})


def coefficients(form):
    """Every coefficient that is not zero: (component, field, place)."""
    for k, record in enumerate(form.components):
        for field in ("U", "M", "R", "V"):
            for i, row in enumerate(getattr(record, field)):
                yield from ((k, field, (i, j)) for j, x in enumerate(row) if x)
        yield from ((k, "weights", (i,)) for i, x in enumerate(record.weights) if x)


def planted(form, half, field, place, factor):
    components = list(form.components)
    components[half] = changed(components[half], field, place, factor)
    return replace(form, components=tuple(components))


@pytest.mark.sampled(1, besides=("g6245",))
@pytest.mark.parametrize("name", QUICK)
def test_any_one_coefficient_that_is_changed_is_caught(name):
    method, of = method_of(name), PROBLEMS["pendulum"]
    values = start(method, of)
    kernel = prepare(method, of, h=H, interpreted=True)
    expected = by_reference(method, of, values)
    options = replace(kernel.options, solver="fixed-point")
    for half, field, place in coefficients(kernel.form):
        form = planted(kernel.form, half, field, place, 1 + 1e-5)
        source = kernel_source(form, kernel.shape, options)
        other = Kernel(form, kernel.shape, options, source, interpret(source.text, {}), 0.0)
        # into and out of the form as before: only the step is changed
        assert units(by_kernel(other, of, values, method), expected) > UNITS, (half, field, place)


def same_bits(name, of, **options):
    values = start(method_of(name), PROBLEMS[of])
    ends = [
        by_kernel(prepare(method_of(name), PROBLEMS[of], h=H, interpreted=x, **options),
                  PROBLEMS[of], values, method_of(name))
        for x in (False, True)
    ]  # fmt: skip
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize("name", ["rk4", "gauss-3", "g6245", "stormer-verlet", "sdirk-3"])
def test_machine_code_and_interpreter_have_the_same_bits(name):
    same_bits(name, "pendulum")


@pytest.mark.sampled(0)
@pytest.mark.slow
@pytest.mark.parametrize("name", METHODS)
def test_machine_code_and_interpreter_have_the_same_bits_for_every_method(name):
    same_bits(name, "kepler")


STIFF_METHODS = ["lobatto-iiic-2", "lobatto-iiic-3", "lobatto-iiic-5", "radau-iia-3"]


@pytest.mark.sampled(3)
@pytest.mark.parametrize("rate", [1e10, 1e13])
@pytest.mark.parametrize("method", STIFF_METHODS)
def test_stages_of_a_stiff_equation_are_solved_by_every_engine(method: str, rate: float) -> None:
    """y' = -rate (y - cos t): the reference gave up, with a matrix of differences of rounding.

    Each stage lies on cos t to about 1/rate (Prothero and Robinson 1974), and y is the last one.
    """
    stiff = Problem(f=(f"-{rate!r}*(y[0] - cos(t))",), y0=(1.0,), t_span=(0, 3))
    for options in ({"engine": "reference"}, {"engine": "interpreted"}, {"engine": "compiled"}):
        run = solve(stiff, method, h=0.3, steps=10, **options)
        assert run.completed, (options, run.message)
        assert abs(run.y[-1][0] - np.cos(run.t[-1])) < 10 / rate + 1e-15, options
    run = solve(stiff, method, h=0.3, steps=2, engine="reference", digits=30)
    assert run.completed and abs(float(run.y[-1][0]) - np.cos(0.6)) < 10 / rate + 1e-15


@pytest.mark.parametrize("size", [1e300, 1.2e308])
@pytest.mark.parametrize("method", ["rk4", "gauss-2", "stormer-verlet"])
def test_a_state_is_finite_up_to_the_largest_double_in_every_engine(method, size):
    """Generated steps ended as not finite from 1e300 on; the reference went on to infinity."""
    drift = Problem(f=("y[1]", "0*y[0]"), dq=("p[0]",), dp=("0*q[0]",), y0=(size, size / 1e3))
    for engine in ("reference", "interpreted", "compiled"):
        run = solve(drift, method, h=0.125, steps=3, engine=engine)
        assert run.completed, (engine, run.message)
        assert run.y[-1][0] == pytest.approx(size * (1 + 0.375e-3), rel=1e-15)
        gone = solve(drift, method, h=1e9, steps=900, engine=engine)
        assert gone.outcome == "not finite", engine
        assert np.isfinite(gone.y).all()
