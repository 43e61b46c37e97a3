"""H = T(p, t) + V(q, t): explicit methods take time at the abscissae of each part."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import glmref
from glmref import Problem, solve
from glmref.engine.ensemble import solve_ensemble
from glmref.measure.longtime import follow
from glmref.measure.work_precision import measure
from glmref.scenes.comparing import kind_of
from glmref.views.problem_page import kind_of as said_kind

BEGIN, LENGTH = 0.5, 2.0
SPAN = {"t0": "1/2", "t_end": "5/2"}
#: q'' + q' + q = 0 with p = exp(t) q' (Caldirola 1941, Kanai 1948): both parts depend on t.
DAMPED = Problem.from_hamiltonian(
    "exp(-t)*p**2/2 + exp(t)*q**2/2", {"q": 1, "p": 0}, name="damped", **SPAN
)
#: q'' = -q + sin(2 t): q'' = g(q, t).
DRIVEN = Problem.from_hamiltonian(
    "p**2/2 + q**2/2 - q*sin(2*t)", {"q": 1, "p": 0}, name="driven", **SPAN
)


def damped(t: float) -> np.ndarray:
    w, s = math.sqrt(3) / 2, t - BEGIN
    q = math.exp(-s / 2) * (math.cos(w * s) + math.sin(w * s) / (2 * w))
    velocity = -math.exp(-s / 2) * math.sin(w * s) * (w + 1 / (4 * w))
    return np.array([q, math.exp(t) * velocity])


def driven(t: float) -> np.ndarray:
    """Solution q = a cos t + b sin t - sin(2 t)/3 through (1, 0) at t = 1/2."""
    c, s = math.cos(BEGIN), math.sin(BEGIN)
    right = np.array([1 + math.sin(2 * BEGIN) / 3, 2 * math.cos(2 * BEGIN) / 3])
    a, b = np.linalg.solve([[c, s], [-s, c]], right)
    q = a * math.cos(t) + b * math.sin(t) - math.sin(2 * t) / 3
    return np.array([q, -a * math.sin(t) + b * math.cos(t) - 2 * math.cos(2 * t) / 3])


def error(problem: Problem, exact: np.ndarray, method: str, n: int) -> float:
    found = solve(problem, method, h=LENGTH / n, steps=n)
    assert found.completed and found.y.shape == (1, 2)
    return float(np.abs(found.y[-1] - exact).max())


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("problem", "method", "order", "n"),
    [
        (DAMPED, "stormer-verlet", 2, 20),
        (DAMPED, "blanes-moan-4", 4, 20),
        (DAMPED, "blanes-moan-6", 6, 10),
        (DAMPED, "kahan-li-8", 8, 3),
        (DAMPED, "pair-6-8", 6, 10),
        (DAMPED, "multistep-8", 8, 20),
        (DAMPED, "lobatto-iiia-iiib-3", 4, 20),
        (DRIVEN, "stormer-verlet", 2, 20),
        (DRIVEN, "blanes-moan-rkn-6-14", 6, 5),
        (DRIVEN, "pair-rkn-6-8b", 6, 10),
        (DRIVEN, "multistep-rkn-8", 8, 20),
        (DRIVEN, "multistep-rkn-10", 10, 18),
    ],
    ids=lambda x: getattr(x, "name", str(x)),
)
def test_methods_keep_their_order_where_time_occurs(problem, method, order, n):
    """A part evaluated at another time than its abscissa would leave order 1."""
    exact = {"damped": damped, "driven": driven}[problem.name](BEGIN + LENGTH)
    coarse, fine = (error(problem, exact, method, k * n) for k in (1, 2))
    assert fine > 1e-14, "the errors must lie above round-off"
    assert math.log2(coarse / fine) == pytest.approx(order, abs=0.45)


@pytest.mark.slow
def test_the_form_with_time_as_a_coordinate_gives_the_same_motion():
    """K = p^2/2 + ps + V(q, qs) is what a user wrote by hand before."""
    by_hand = Problem.from_hamiltonian(
        "p**2/2 + ps + q**2/2 - q*sin(2*qs)", {"q": 1, "qs": "1/2", "p": 0, "ps": 0}, **SPAN
    )
    for method in ("stormer-verlet", "blanes-moan-6", "multistep-8"):
        mine = solve(DRIVEN, method, h=0.1, steps=20).y[-1]
        theirs = solve(by_hand, method, h=0.1, steps=20).y[-1][[0, 2]]
        assert mine == pytest.approx(theirs, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("method", ["blanes-moan-6", "pair-6-8", "lobatto-iiia-iiib-3"])
def test_engines_agree(method):
    same = {"h": 0.1, "steps": 20}
    compiled = solve(DAMPED, method, **same).y[-1]
    for engine in ("reference", "interpreted"):
        other = solve(DAMPED, method, engine=engine, **same).y[-1]
        assert other == pytest.approx(compiled, rel=1e-13)
    digits = solve(DAMPED, method, engine="reference", digits=30, **same)
    assert [float(x) for x in digits.y[-1]] == pytest.approx(compiled, rel=1e-13)


def test_ensembles_histories_and_long_runs_have_no_clocks():
    method = glmref.load("pair-6-8")
    initial = np.array([[1.0, 0.0], [2.0, -0.5], [0.0, 1.0]])
    many = solve_ensemble(DAMPED, method, initial, h=0.1, steps=20)
    assert many.y.shape == (2, 3, 2) or many.y.shape[1:] == (3, 2)
    one = solve(DAMPED, method, h=0.1, steps=20, history=True, every=5)
    assert many.y[-1, 0] == pytest.approx(one.y[-1], rel=1e-14)
    assert one.history.shape == (5, method.carried, 2) and one.values.shape[-1] == 2
    far = follow(DAMPED, method, h=1 / 512, steps=1024)
    assert far.y[-1] == pytest.approx(damped(2.5), rel=1e-11)


def test_a_long_run_of_other_methods_sees_time_go_on():
    """A stretch that restarted the clock would drive with the force of the beginning."""
    far = follow(DRIVEN, glmref.load("rk4"), h=LENGTH / 4000, steps=4000)
    assert far.t[-1] == pytest.approx(BEGIN + LENGTH)
    assert far.y[-1] == pytest.approx(driven(BEGIN + LENGTH), rel=1e-12)


def test_errors_are_measured_and_explicit_methods_offered():
    assert kind_of(DRIVEN) == "second order" and kind_of(DAMPED) == "separable"
    assert "with time" in said_kind(DRIVEN) and "with time" in said_kind(DAMPED)
    work = measure(DRIVEN, glmref.load("blanes-moan-rkn-6-14"), h=0.1, steps=20, ask=("state",))
    assert work.state_error is not None and work.state_error < 1e-10
    found = glmref.compare(DRIVEN, methods=["multistep-rkn-8"], tolerance=1e-6, budget=5)
    assert found.recommended == "multistep-rkn-8"


def test_what_couples_q_and_p_has_no_parts():
    coupled = Problem.from_hamiltonian("p**2/2 + t*q*p", {"q": 1, "p": 0})
    assert coupled.extended is None and kind_of(coupled) == "Hamiltonian"
    with pytest.raises(glmref.UsageError, match="separable"):
        solve(coupled, "stormer-verlet", h=0.1, steps=1)
    free = Problem.from_hamiltonian("p**2/2 - cos(q)", {"q": 1, "p": 0})
    assert free.extended is None and free.second_order


PARTS = st.sampled_from(["{v}**2/2", "cos({v})", "t*{v}", "exp(-t)*{v}**2", "sin(t)", "{v}*{v}/3"])


@settings(max_examples=40, deadline=None)
@given(
    kinetic=st.lists(PARTS, min_size=1, max_size=3),
    potential=st.lists(PARTS, min_size=1, max_size=3),
    point=st.tuples(*[st.floats(-2, 2)] * 3),
)
def test_the_parts_at_one_time_are_the_equations(kinetic, potential, point):
    """The law behind it: q' = f(p, t) and p' = k(q, t), where both clocks show t."""
    H = " + ".join([x.format(v="p") for x in kinetic] + [x.format(v="q") for x in potential])
    own = Problem.from_hamiltonian(H, {"q": 0, "p": 0})
    t, q, p = point
    split = own.extended or own
    clock = [t] if own.extended else []
    slopes = (split.dq(np.array([p, *clock])), split.dp(np.array([q, *clock])))
    together = own.f(t, np.array([q, p]))
    assert [x[0] for x in slopes] == pytest.approx(together.tolist(), rel=1e-13, abs=1e-13)
    assert (own.extended is not None) == ("t" in re.findall(r"\w+", H))
