"""Judges judged: energies, quadratic forms and other invariants are constant along f."""

from random import Random

import numpy as np
import pytest

from glmref.conformance.taylor import Tape
from glmref.problems import names, problem
from tests.build import high

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
DIGITS = 60


def at_random(name, parameters, seed):
    """A problem in double precision, and a random point near its start as exact numbers."""
    context = high(DIGITS)
    p = problem(name, **parameters)
    y0 = p.on(context).y0
    random = Random(seed)
    size = max(abs(x) for x in y0) or 1
    shift = [size * context.mpf(random.randrange(-1000, 1001)) / 10000 for _ in y0]
    return p, y0 + np.array(shift, dtype=object), context


def slope_along(function, y, direction, context):
    """Derivative of a function along a direction, and a bound of its rounding error.

    The function runs once on first order Taylor series: no step size, no truncation. Each of the
    operations recorded rounds to 10**-60 of its result, and passes errors on magnified by no more
    than the largest coefficient met.
    """
    tape = Tape(context)
    variables = [tape.variable() for _ in y]
    for series, value, slope in zip(variables, y, direction, strict=True):
        series.coefficients[:] = [value, slope]
    result = function.on(tape)(np.array(variables, dtype=object))
    largest = max(abs(x) for x in (*y, *direction))
    for k in (0, 1):
        for node in tape.nodes:
            node.coefficients.append(node.rule(k))
            largest = max(largest, abs(node.coefficients[k]))
    bound = context.mpf(10) ** -DIGITS * len(tape.nodes) * (1 + largest) ** 2
    return result.coefficients[1], bound


@pytest.mark.sampled(14)
@pytest.mark.parametrize(("name", "parameters"), VARIANTS)
def test_every_invariant_is_constant_along_f(name, parameters):
    for seed in (1, 2):
        p, y, context = at_random(name, parameters, seed)
        f = p.on(context).f(context.mpf(0), y)
        for key, function in {**p.invariants, **p.quadratic, "H": p.hamiltonian}.items():
            if function is not None:
                slope, bound = slope_along(function, y, f, context)
                assert abs(slope) <= bound, (key, float(slope), float(bound))


@pytest.mark.sampled(10)
@pytest.mark.parametrize(("name", "parameters"), VARIANTS)
def test_an_invariant_off_by_a_billionth_is_noticed(name, parameters):
    # near miss: f with one component changed by 1e-9 of itself
    p, y, context = at_random(name, parameters, 1)
    conserved = {**p.invariants, **p.quadratic, "H": p.hamiltonian}
    f = p.on(context).f(context.mpf(0), y)
    largest = int(np.argmax([float(abs(x)) for x in f]))
    f[largest] *= 1 + context.mpf("1e-9")
    caught = []
    for function in conserved.values():
        if function is not None:
            slope, bound = slope_along(function, y, f, context)
            caught.append(abs(slope) > bound)
    assert any(caught) or not caught


CANONICAL = [(n, k) for n, k in VARIANTS if problem(n, **k).canonical]


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("name", "parameters"), CANONICAL)
def test_canonical_problems_are_j_times_the_gradient_of_h(name, parameters):
    p, y, context = at_random(name, parameters, 3)
    f, half = p.on(context).f(context.mpf(0), y), len(y) // 2
    for i in range(len(y)):
        unit = [context.mpf(int(i == j)) for j in range(len(y))]
        slope, bound = slope_along(p.hamiltonian, y, unit, context)
        partner = -f[i + half] if i < half else f[i - half]
        assert abs(slope - partner) <= bound * 10


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
