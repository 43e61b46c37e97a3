"""The generated kernels and the reference engine agree to the bits that reordering allows.

The bound follows sizes and errors through the steps, once with the tableau and once with the form the
kernel steps in, and adds the two. With |.| entry by entry, X (r,) the sizes of the values, F (s,) those
of the slopes, L the Lipschitz constant and c the operations of the right-hand side, whose terms are
at most T,

    dY = |U| e + h |A| dF + n eps (|U| X + h |A| F)          n = s + r + 8
    dF = L dY + c eps T
    e+ = |V| e + h |B| dF + n eps (|V| X + h |B| F)

because a sum of s + r terms, with rounded coefficients, rounded products and a compensation that may
be lost, is off by at most n eps times the sum of the magnitudes. An iteration that ends when
its change no longer decreases has, with contraction rho and rounding errors d in each round, an error
of at most 2 d/(1 - rho)^2.
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
OPERATIONS = 24
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


def absolute(matrix):
    return np.abs(np.array([[float(x) for x in row] for row in matrix]))


class Sizes:
    """Magnitudes of A, U, B, V of one way to write a step, in its own basis."""

    def __init__(self, A, U, B, V):
        self.A, self.U, self.B, self.V = A, U, B, V

    def error(self, values, F, L, T, *, iterated):
        """Bound of the error of STEPS steps by rounding in this way of writing them, shape (r,)."""
        A, U, B, V = self.A, self.U, self.B, self.V
        s, r = U.shape
        n = (s + r + 8) * EPS
        X, e = values, n * values
        factor = 1.0
        if iterated:
            rho = H * L * np.abs(np.linalg.eigvals(A)).max()
            assert rho < 0.5, "the step is too large for the bound"
            factor = 2 / (1 - rho) ** 2
        for _ in range(STEPS):
            known = U @ e + factor * (
                n * (U @ X + H * A @ F) + H * A.sum(axis=1) * OPERATIONS * EPS * T
            )
            dY = np.linalg.solve(np.eye(s) - H * L * A, known)
            assert (dY >= 0).all(), "the step is too large for the bound"
            dF = L * dY + OPERATIONS * EPS * T
            e = V @ e + H * B @ dF + n * (V @ X + H * B @ F)
            X = V @ X + H * B @ F
        return e


def tableau(A, U, B, V):
    return Sizes(absolute(A).reshape(len(A), -1), *(absolute(x) for x in (U, B, V)))


def combined(q, p):
    """Sizes of a pair: the stages and values of both halves, one after the other."""

    def corners(a, b):
        return np.block([[np.zeros((len(a), b.shape[1])), a], [b, np.zeros((len(b), a.shape[1]))]])

    def blocks(a, b):
        out = np.zeros((len(a) + len(b), a.shape[1] + b.shape[1]))
        out[: len(a), : a.shape[1]], out[len(a) :, a.shape[1] :] = a, b
        return out

    return Sizes(corners(q.A, p.A), blocks(q.U, p.U), corners(q.B, p.B), blocks(q.V, p.V))


def of_tableau(method):
    if isinstance(method, PartitionedGLM):
        return combined(
            tableau(method.A, method.U, method.B, method.V),
            tableau(method.A_hat, method.U_hat, method.B_hat, method.V_hat),
        )
    return tableau(method.A, method.U, method.B, method.V)


def swept(U, M, R, V, weights, running):
    """Sizes of Y = U x + M L, where running with L added to x = V y as they come; y+ = V x + R L."""
    U, M, R, V, weights = absolute(U), absolute(M), absolute(R), absolute(V), np.abs(weights)
    inner = M + U @ R if running else M
    return Sizes(inner * weights, U @ V if running else U, R * weights, V)


def of_form(form):
    if len(form.components) == 2:
        q, p = form.components
        return combined(
            swept(q.U, q.M, q.R, q.V, p.weights, form.running),
            swept(p.U, p.M, p.R, p.V, q.weights, form.running),
        )
    found = swept(form.U, form.M, form.R, form.V, form.weights, form.running)
    if form.running:  # a stage reads increments of the stages before it
        found.A = np.tril(found.A, -1) + absolute(form.M) * np.abs(form.weights)
    return found


def basis(form):
    """Magnitudes of the change of basis to the form and back, for the values one after the other."""
    if len(form.components) == 2:
        (a, c), (b, d) = ((x.to_form, x.from_form) for x in form.components)
        zero = np.zeros((len(a), len(b)))
        return tuple(
            np.block([[absolute(x), zero], [zero.T, absolute(y)]]) for x, y in ((a, b), (c, d))
        )
    return absolute(form.to_form), absolute(form.from_form)


def lipschitz(of, y):
    """Half as much again as the norm of the Jacobian at y: the way travelled is short."""
    columns = [
        (np.asarray(of.f(0.0, y + d)) - np.asarray(of.f(0.0, y - d))) / 2e-6
        for d in 1e-6 * np.eye(len(y))
    ]
    return 1.5 * np.abs(np.stack(columns, axis=1)).sum(axis=1).max()


def value_sizes(method, values):
    """Largest component of each value; of a pair those of q, then those of p."""
    if not isinstance(method, PartitionedGLM):
        return np.abs(values).max(axis=1)
    half = values.shape[1] // 2
    q, p = np.abs(values[: method.r, :half]), np.abs(values[: method.r_hat, half:])
    return np.concatenate([q.max(axis=1), p.max(axis=1)])


def bound(method, form, of, values, slope):
    """Largest difference that rounding explains; ``slope`` is the largest slope of the run."""
    L, X = lipschitz(of, values[0]), value_sizes(method, values)
    to_form, from_form = basis(form)
    iterated = {"iterated": bool(form.implicit_stages)}
    T = max(4.0, 2 * slope)  # no term of the problems above exceeds 4 near their initial values
    written = of_tableau(method)
    # kicks of two steps put together are those of the tableau, at other steps
    ours = written if getattr(form, "kick", 0.0) else of_form(form)
    F = np.full(len(written.A), slope)
    first = written.error(X, F, L, T, **iterated)
    second = from_form @ ours.error(to_form @ X, F, L, T, **iterated)
    return float((first + second + 2 * EPS * len(X) * (from_form @ to_form @ X)).max())


def start(method, of):
    """Values with every component in play: the zero start and something small in each."""
    zero = zero_start(stepper(method, of), of.y0)
    values = zero + 0.01 * np.random.default_rng(11).uniform(-1, 1, zero.shape)
    if isinstance(method, PartitionedGLM):  # what one half does not carry stays zero
        half = zero.shape[1] // 2
        values[method.r :, :half] = values[method.r_hat :, half:] = 0.0
    return values


def by_reference(method, of, values):
    """Values after STEPS steps, and the largest slope met."""
    engine, largest = stepper(method, of), 0.0
    for n in range(STEPS):
        taken = engine.step(n * H, values, H)
        assert taken.converged
        slopes = taken.slopes if isinstance(taken.slopes, tuple) else (taken.slopes,)
        largest = max(largest, *(float(np.abs(x).max()) for x in slopes))
        values = taken.values
    return values, largest


def by_kernel(kernel, of, values, method):
    solution = stepper(method, of).solution(values)
    state = kernel.state(values, np.asarray(of.f(0.0, solution)), H)
    out = np.zeros((1, 1, of.dimension))
    outcome, _ = kernel.advance(state, STEPS, t0=0.0, h=H, every=0, out=out)
    assert outcome == "completed"
    return kernel.values(state)


def differ(method, of, **options):
    """(largest difference between kernel and reference, what rounding explains)."""
    values = start(method, of)
    kernel = prepare(method, of, h=H, **{"interpreted": True, **options})
    expected, slope = by_reference(method, of, values)
    difference = np.abs(by_kernel(kernel, of, values, method) - expected).max()
    return difference, bound(method, kernel.form, of, values, slope)


def applicable(name):
    return [of for of in PROBLEMS if of in SEPARABLE or not is_pair(name)]


def marked(quick):
    marks = [() if name in quick else pytest.mark.slow for name in METHODS]
    return [pytest.param(name, marks=m) for name, m in zip(METHODS, marks, strict=True)]


@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", marked(QUICK))
def test_kernels_of_every_method_agree_with_the_reference(name):
    for of in applicable(name):
        difference, explained = differ(method_of(name), PROBLEMS[of])
        assert difference <= explained, of


@pytest.mark.sampled(10)
@pytest.mark.parametrize("arithmetic", ["compensated", "naive"])
@pytest.mark.parametrize("name", QUICK)
def test_so_do_the_other_arithmetics(name, arithmetic):
    for of in applicable(name)[:2]:
        difference, explained = differ(method_of(name), PROBLEMS[of], arithmetic=arithmetic)
        assert difference <= explained, of


@pytest.mark.parametrize("name", ["g6245", "gauss-3", "sdirk-3", "s4-symmetric"])
def test_so_does_newton(name):
    for of in ("pendulum", "rigid-body", "driven"):
        difference, explained = differ(method_of(name), PROBLEMS[of], solver="newton")
        assert difference <= explained, of


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
    expected, slope = by_reference(method, of, values)
    explained = bound(method, kernel.form, of, values, slope)
    options = replace(kernel.options, solver="fixed-point")
    for half, field, place in coefficients(kernel.form):
        form = planted(kernel.form, half, field, place, 1 + 1e-5)
        source = kernel_source(form, kernel.shape, options)
        other = Kernel(form, kernel.shape, options, source, interpret(source.text, {}), 0.0)
        # into and out of the form as before: only the step is changed
        difference = np.abs(by_kernel(other, of, values, method) - expected).max()
        assert difference > explained, (half, field, place)


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
