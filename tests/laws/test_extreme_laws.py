"""Any method on any input ends in a name: no traceback, no hang, no silent NaN, no warning.

Methods are drawn at random, most of them nonsense, some from the catalogue; problems and step sizes
are extreme. A budget of right-hand-side evaluations stands for time.
"""

import math
import os
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from glmref.catalogue.lookup import load
from glmref.catalogue.lookup import names as method_names
from glmref.errors import GlmrefError
from glmref.measure.attempt import FUNCTION_FAILED, OUTCOMES, REFUSED, attempt
from glmref.method import GLM, PartitionedGLM
from glmref.problems import Problem, problem
from glmref.problems.extreme import PRESETS
from glmref.problems.formula import Formula

#: Evaluations of the steps and of both solvers; a run that takes more has ignored its budget.
BUDGET = 20_000
#: The enhanced start takes at most 2^8 - 1 steps of its own.
START_STEPS = 255

ENTRIES = ("0", "1", "-1", "1/2", "1/4", "-1/3", "2", "1/1000000", "-1000000", "sqrt(2)/2")
SIZES = (
    1e-320, 1e-300, 1e-15, 1e-8, 1e-3, 0.1, 0.5, 1.0, 2.0, math.pi, 10.0, 1e3, 1e8, 1e100, 1e300,
)  # fmt: skip


@st.composite
def matrices(draw, rows, columns, *, lower=False):
    """Exact entries; a strictly lower, lower or full pattern."""
    entries = st.sampled_from(ENTRIES)
    pattern = draw(st.sampled_from(("strict", "lower", "full"))) if lower else "full"
    reach = {"strict": 0, "lower": 1, "full": columns}[pattern]
    return [
        [draw(entries) if j < i + reach or pattern == "full" else "0" for j in range(columns)]
        for i in range(rows)
    ]


@st.composite
def random_glms(draw):
    s, r = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    return GLM(
        A=draw(matrices(s, s, lower=True)), U=draw(matrices(s, r)),
        B=draw(matrices(r, s)), V=draw(matrices(r, r)), name="random",
    )  # fmt: skip


@st.composite
def random_pairs(draw):
    s, r = draw(st.integers(1, 2)), draw(st.integers(1, 2))
    blocks = {
        letter + hat: draw(matrices(n, m, lower=letter == "A"))
        for hat in ("", "_hat")
        for letter, n, m in (("A", s, s), ("U", s, r), ("B", r, s), ("V", r, r))
    }
    return PartitionedGLM(**blocks, name="random pair")


SHIPPED = [
    name
    for name in method_names("methods")
    if "complex" not in name and not name.startswith("ars-")
]
# names, not methods: the library prints what it draws
shipped = st.sampled_from(SHIPPED)


def plain(f, dimension=2, **rest):
    return Problem(f=f, y0=[1.0] * dimension, name="user", **rest)


def raises(t, y):
    raise ZeroDivisionError("by design")


def jacobian(entry):
    return Formula((entry,), variables=("t", "y"), shape=(1, 1))


USERS = {
    "none": lambda: plain(lambda t, y: None),
    "text": lambda: plain(lambda t, y: "no number"),
    "short": lambda: plain(lambda t, y: y[:1]),
    "long": lambda: plain(lambda t, y: np.append(y, 0.0)),
    "number": lambda: plain(lambda t, y: 1.0),
    "complex": lambda: plain(lambda t, y: 1j * y),
    "nan": lambda: plain(lambda t, y: y * math.nan),
    "infinity": lambda: plain(lambda t, y: y + math.inf),
    "raises": lambda: plain(raises),
    "raises later": lambda: plain(lambda t, y: y if t == 0.0 else raises(t, y)),
}
EXPRESSIONS = {
    "root of a negative number": lambda: plain(("-sqrt(y[0] - 2)", "log(y[0])")),
    "division by zero": lambda: plain(("1/(y[0] - 1)", "y[1]")),
    "tower": lambda: plain(("exp(exp(y[0]*y[0]))", "y[0]")),
    "singular Jacobian": lambda: plain(("y[0]*0", "1")),
    "wrong Jacobian": lambda: plain(("-1000000*y[0]",), 1, jacobian=jacobian("1000000")),
    "Jacobian of zeros": lambda: plain(("-1000000*y[0]",), 1, jacobian=jacobian("0")),
    "Jacobian that is infinite": lambda: plain(
        ("-1000000*y[0]",), 1, jacobian=jacobian("1/(y[0] - y[0])")
    ),
    "separable with a pole": lambda: Problem(
        force=("1/q[0]",), y0=[1.0, -1.0], name="user", hamiltonian="y[1]*y[1]/2 - log(y[0])"
    ),
}
SMALL_PRESETS = [case for case in PRESETS if case != "many components"]


@lru_cache(maxsize=64)
def subject(kind, case):
    if kind == "preset":
        name, parameters = PRESETS[case]
        return problem(name, **parameters)
    if kind == "fault":
        return problem(case)
    return (USERS if kind == "user" else EXPRESSIONS)[case]()


FAULTS = ("fault-infinity", "fault-jacobian", "fault-jacobian-nan", "fault-nan", "blow-up")
subjects = st.one_of(
    st.tuples(st.just("preset"), st.sampled_from(SMALL_PRESETS)),
    st.tuples(st.just("expressions"), st.sampled_from(sorted(EXPRESSIONS))),
    st.tuples(st.just("fault"), st.sampled_from(FAULTS)),
    st.tuples(st.just("user"), st.sampled_from(sorted(USERS))),
)
methods = st.one_of(random_glms(), random_pairs(), shipped)


@st.composite
def runs(draw):
    kind, case = draw(subjects)
    # functions in Python go through numba when compiled, seconds for each method: not here
    engines = ["interpreted"] * 4 + ["reference"] * 2 + ["compiled"] * (kind != "user")
    engine = draw(st.sampled_from(engines))
    options = {"engine": engine}
    if engine != "reference":
        options["arithmetic"] = draw(st.sampled_from(("strict", "fused", "compensated", "naive")))
        options["solver"] = draw(st.sampled_from(("auto", "auto", "fixed-point", "newton")))
    options["start"] = draw(st.sampled_from((None, None, "zero", "enhanced")))
    options["every"] = draw(st.sampled_from((0, 1, 3)))
    options["history"] = draw(st.booleans())
    sign = draw(st.sampled_from((1, 1, -1)))
    h = sign * draw(st.sampled_from(SIZES))
    return (kind, case), draw(methods), h, draw(st.sampled_from((1, 2, 5, 40))), options


def check(run):
    (kind, case), method, h, steps, options = run
    method = load(method) if isinstance(method, str) else method
    found = attempt(subject(kind, case), method, h=h, steps=steps, evaluations=BUDGET, **options)
    assert found.outcome in OUTCOMES
    assert found.message.strip() and "\n" not in found.message
    if found.outcome == FUNCTION_FAILED:
        assert kind in ("user", "fault"), found.message
    if found.solution is None:
        assert found.outcome in (REFUSED, FUNCTION_FAILED)
        return
    s = method.s if isinstance(method, GLM) else method.n_Q + method.n_P
    assert found.solution.evaluations <= BUDGET + s * 402
    assert found.solution.start_evaluations <= START_STEPS * s * 402 + 1000
    if found.solution.completed:
        assert np.isfinite(found.solution.y).all()
        assert np.isfinite(found.solution.values).all()
        assert found.solution.steps == steps


COMMON = {
    "deadline": None,
    "derandomize": True,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large],
}


@pytest.mark.slow
@settings(max_examples=60, **COMMON)
@given(runs())
def test_any_method_on_extreme_inputs_ends_in_a_name(run):
    check(run)


@pytest.mark.slow
@settings(max_examples=int(os.environ.get("GLMREF_EXTREME_CASES", "2000")), **COMMON)
@given(runs())
def test_2000_methods_on_extreme_inputs_end_in_a_name(run):
    check(run)


def test_the_law_has_teeth():
    """A run that returns NaN as completed, a message of two lines, or an unknown name is caught."""
    (kind, case), method, h = ("preset", "no field"), load("rk4"), 0.1
    good = attempt(subject(kind, case), method, h=h, steps=2, evaluations=BUDGET)
    assert good.outcome == "completed" and good.solution is not None
    assert np.isfinite(good.solution.y).all()
    with pytest.raises(ZeroDivisionError):
        raises(0.0, np.ones(1))
    refused = attempt(subject(kind, case), method, h=math.nan, steps=2)
    assert refused.outcome == REFUSED and "`h` must be finite" in refused.message
    failed = attempt(subject("user", "short"), method, h=h, steps=2)
    assert failed.outcome == FUNCTION_FAILED and "shape (2,)" in failed.message


def test_defects_of_the_engine_are_not_hidden(monkeypatch):
    import glmref.measure.attempt as module

    def broken(*args, **options):
        raise KeyError("a defect")

    monkeypatch.setattr(module, "solve", broken)
    with pytest.raises(KeyError, match="a defect"):
        attempt(subject("preset", "no field"), load("rk4"), h=0.1, steps=1)
    assert issubclass(GlmrefError, Exception)
