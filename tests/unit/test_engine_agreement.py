"""The generated kernels and the reference engine agree to the bits that reordering allows.

The bound follows the numbers through one step. Let ``size`` be what the magnitudes of all terms of a
sum add up to. A sum of at most s + r terms, whose coefficients and products are rounded as well, is
off by at most ``(s + r + 8) eps size``, in either engine. So

    stages   dY = n eps (u X + h a T) + h a c eps T,      n = 2 (s + r + 8)
    slopes   dF = 2 L dY + c eps T
    values   e+ = (v + 2 h L b u) e + h b dF + n eps (v X + h b T)

with X the largest value, T the largest term of the right-hand side, L its Lipschitz constant, c the
operations in it, and u, a, b, v the row sums of the magnitudes of the coefficients, of A, U, B, V and
of the form that the kernel steps in, whichever is larger. 2 stands for 1/(1 - h L a), as h L a <= 1/2.
An iteration that ends when its change does not decrease any more has, with contraction 1/2 and
rounding errors dY in each round, an error of at most 2 dY/(1 - 1/2)^2: eight times dY.
"""

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import pytest

from glmref import Problem, load, names, problem
from glmref.engine import compiled
from glmref.engine.codegen import Options, kernel_source
from glmref.engine.kernel import Kernel, prepare
from glmref.engine.pairs import pair_source
from glmref.engine.reference import pair_blocks, stepper
from glmref.engine.start import zero_start
from glmref.engine.tableau import stage_blocks
from glmref.method import PartitionedGLM

EPS = 2.0**-52
STEPS = 4
H = 1 / 32
T, OPERATIONS = 4.0, 24  # no term of the problems below exceeds T near their initial values

DRIVEN = Problem(
    f=("y[1]", "-sin(y[0]) + cos(t)/2 - y[1]/8"), y0=("6/5", "-1/3"), name="driven"
)
PROBLEMS = {
    "pendulum": problem("pendulum"),
    "rigid-body": problem("rigid-body"),
    "kepler": problem("kepler", eccentricity="1/5"),
    "lotka-volterra-logarithmic": problem("lotka-volterra-logarithmic"),
    "driven": DRIVEN,
}
SEPARABLE = ("pendulum", "kepler", "lotka-volterra-logarithmic")
QUICK = ("pendulum", "rigid-body")


def is_pair(name):
    return isinstance(load(name), PartitionedGLM)


def real(name):
    method = load(name)
    return isinstance(method, PartitionedGLM) or method.is_real


METHODS = [name for name in names("methods") if real(name)]


def absolute(matrix):
    return np.abs(np.array([[float(x) for x in row] for row in matrix])).reshape(len(matrix), -1)


def rows(matrix):
    return float(matrix.sum(axis=1).max()) if matrix.size else 0.0


@dataclass
class Sizes:
    """Row sums of magnitudes: u, a, b, v of the module's docstring, and of the change of basis."""

    u: float
    a: float
    b: float
    v: float
    basis: float = 1.0

    def __or__(self, other):
        return Sizes(*(max(x, y) for x, y in zip(vars(self).values(), vars(other).values())))


def of_tableau(A, U, B, V):
    return Sizes(rows(absolute(U)), rows(absolute(A)), rows(absolute(B)), rows(absolute(V)))


def of_form(U, M, R, V, weights, running, to_form, from_form):
    """Sizes in the method's basis of Y = U x + M L (+ U R L where running), y+ = V x + R L."""
    U, M, R, V = (absolute(x) for x in (U, M, R, V))
    to_form, from_form, weights = absolute(to_form), absolute(from_form), np.abs(weights)
    inner = M + U @ R if running else M
    return Sizes(
        u=rows(U @ V @ to_form if running else U @ to_form), a=rows(inner * weights),
        b=rows(from_form @ R * weights), v=rows(from_form @ V @ to_form),
        basis=rows(from_form @ to_form),
    )  # fmt: skip


def sizes(method, form):
    """The larger of the sizes of the tableau and of the form."""
    if isinstance(method, PartitionedGLM):
        q, p = form.Q, form.P
        options = (form.running, form.to_form[0], form.from_form[0])
        hats = (form.running, form.to_form[1], form.from_form[1])
        return (
            of_tableau(method.A, method.U, method.B, method.V)
            | of_tableau(method.A_hat, method.U_hat, method.B_hat, method.V_hat)
            | of_form(q.U, q.M, p.R, form.V, p.weights, *options)
            | of_form(p.U, p.M, q.R, form.V_hat, q.weights, *hats)
        )
    return of_tableau(method.A, method.U, method.B, method.V) | of_form(
        form.U, form.M, form.R, form.V, form.weights, form.running, form.to_form, form.from_form
    )


def lipschitz(of, values):
    """Twice the norm of the Jacobian at the first value: the way travelled is short."""
    y = values[0]
    columns = [
        (np.asarray(of.f(0.0, y + d)) - np.asarray(of.f(0.0, y - d))) / 2e-6
        for d in 1e-6 * np.eye(len(y))
    ]
    return 2 * np.abs(np.stack(columns, axis=1)).sum(axis=1).max()


def implicit(method):
    if isinstance(method, PartitionedGLM):
        return any(block.implicit for block in pair_blocks(method))
    return any(block.implicit for block in stage_blocks(method.A))


def bound(method, form, of, values):
    """Largest difference that rounding explains after STEPS steps; see the module's docstring."""
    x, r = sizes(method, form), len(values)
    stages = method.n_Q + method.n_P if isinstance(method, PartitionedGLM) else method.s
    n, L = 2 * (stages + r + 8), lipschitz(of, values)
    assert H * L * x.a <= 0.5 or not implicit(method), "the step is too large for the bound"
    largest = np.abs(values).max()
    error = n * EPS * x.basis * largest
    for _ in range(STEPS):
        stage = n * EPS * (x.u * largest + H * x.a * T) + H * x.a * OPERATIONS * EPS * T
        stage *= 8 if implicit(method) else 1
        slope = 2 * L * stage + OPERATIONS * EPS * T
        growth = x.v + 2 * H * L * x.b * x.u
        error = growth * error + H * x.b * slope + n * EPS * (x.v * largest + H * x.b * T)
    return x.basis * error


def start(method, of):
    """Values with every component in play: the zero start and something small in each."""
    zero = zero_start(stepper(method, of), of.y0)
    random = np.random.default_rng(11).uniform(-1, 1, zero.shape)
    values = zero + 0.01 * random
    if isinstance(method, PartitionedGLM):  # values that one half does not carry stay zero
        half = zero.shape[1] // 2
        values[method.r :, :half] = values[method.r_hat :, half:] = 0.0
    return values


def by_reference(method, of, values):
    engine, t = stepper(method, of), 0.0
    for n in range(STEPS):
        taken = engine.step(t + n * H, values, H)
        assert taken.converged
        values = taken.values
    return values


def by_kernel(kernel, of, values):
    state = kernel.state(values, np.asarray(of.f(0.0, values[0])), H)
    out = np.zeros((1, 1, of.dimension))
    outcome, _ = kernel.advance(state, STEPS, t0=0.0, h=H, every=0, out=out)
    assert outcome == "completed"
    return kernel.values(state)


def differ(method, of, **options):
    """(largest difference between kernel and reference, what rounding explains)."""
    values = start(method, of)
    kernel = prepare(method, of, h=H, **{"interpreted": True, **options})
    difference = np.abs(by_kernel(kernel, of, values) - by_reference(method, of, values)).max()
    return difference, bound(method, kernel.form, of, values)


def cases():
    for of in PROBLEMS:
        for name in METHODS:
            if of in SEPARABLE or not is_pair(name):
                marks = () if of in QUICK else pytest.mark.slow
                yield pytest.param(name, of, marks=marks, id=f"{of}-{name}")


@pytest.mark.parametrize(("name", "of"), cases())
def test_every_method_agrees_with_the_reference(name, of):
    difference, explained = differ(load(name), PROBLEMS[of])
    assert difference <= explained
