"""The files of data/solutions, and the Taylor and collocation integrators behind them."""

import json
from fractions import Fraction

import mpmath
import pytest

from glmref.conformance.taylor import taylor_states
from glmref.errors import DataError
from glmref.problems import Problem, problem
from glmref.problems.reference import FORMAT, read_references
from tests.build import high
from tools.collocation import collocation_states, radau_nodes
from tools.reference_solutions import solution_document, solution_entries

GOOD = {
    "parameters": {"q0": "5/2", "p0": "0"},
    "t": "1/2",
    "state": ["0.25", "-1e-3"],
    "agreement": "1e-3",
    "generator": "by hand",
}


def written(tmp_path, document, name="pendulum"):
    path = tmp_path / f"{name}.json"
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({"format": "other"}, "`format` must be"),
        ({"format": FORMAT, "problem": "kepler", "solutions": []}, "must be the file's name"),
        ({"format": FORMAT, "problem": "pendulum"}, "incomplete"),
        ({"format": FORMAT, "problem": "pendulum", "solutions": [{}]}, "incomplete"),
        (solution_document("pendulum", [{**GOOD, "state": ["x"]}]), "incomplete or not a number"),
        (solution_document("pendulum", [{**GOOD, "t": "soon"}]), "incomplete or not a number"),
        ([1], "`format` must be"),
    ],
)
def test_a_wrong_file_is_one_sentence(tmp_path, document, says):
    with pytest.raises(DataError) as error:
        read_references(written(tmp_path, document))
    assert says in str(error.value) and str(error.value).startswith("pendulum.json")


def test_a_float_in_a_file_is_refused(tmp_path):
    with pytest.raises(DataError, match="float"):
        read_references(written(tmp_path, solution_document("pendulum", [{**GOOD, "t": 0.5}])))


def test_regenerated_digits_are_all_right():
    p = problem("pendulum")
    (entry,) = solution_entries(p, ["2"], digits=15)
    context = high(40)
    exact = p.on(context).solution(2)
    for text, value in zip(entry["state"], exact, strict=True):
        digits = len(text.lstrip("-0.").replace(".", ""))
        assert 13 <= digits <= 25
        # the last digit that two computations agree on may be off by one
        assert abs(context.mpf(text) - value) < 2 * abs(value) * 10.0 ** (1 - digits)


@pytest.mark.slow
def test_digits_that_do_not_agree_are_not_written():
    (entry,) = solution_entries(problem("kaps", epsilon=1), ["1"], digits=6, stages=4)
    context = mpmath.MPContext()
    for text, exact in zip(entry["state"], (context.exp(-2), context.exp(-1)), strict=True):
        digits = len(text.lstrip("-0.").replace(".", ""))
        assert digits < 16 and abs(context.mpf(text) / exact - 1) < 2 * 10.0 ** (1 - digits)


# -- the Taylor and collocation integrators behind the reference states


def size(y):
    return float(max(abs(x) for x in y))


@pytest.mark.parametrize("digits", [15, 25, 35])
def test_taylor_error_follows_the_digits_asked(digits):
    p = problem("kepler")
    context = high(60)
    (end,) = taylor_states(p, [3], digits=digits)
    # some 30 steps, each within 10**-digits of |y| <= 2; Kepler's flow stretches by about 20
    assert size(p.on(context).solution(3) - end) < 2000 * 10.0**-digits


def test_taylor_runs_backwards_to_its_start():
    p = problem("henon-heiles")
    there, back = taylor_states(p, [3, 0], digits=25)
    assert size(back - p.on(there[0].context).y0) < 1e-22 < size(there - back)


@pytest.mark.slow
def test_every_operation_has_its_recurrence():
    # y = exp(sin t): y' = cos(t) y, written with all functions there are
    f = (
        "cos(t)*y[0] + log(exp(y[0])) - y[0] + sqrt(y[0]*y[0]) - y[0]"
        " + atan2(sin(t), cos(t)) - t + tan(t) - sin(t)/cos(t) + 2**t - exp(t*log(2))"
        " + y[0]**3 - y[0]*y[0]*y[0] + y[0]**1.5 - y[0]*sqrt(y[0]) + y[0]**t - exp(t*log(y[0]))"
        " + atan2(1, t + 2) - atan2(1/(t + 2), 1) + 1/y[0] - y[0]**(-1)"
    )
    (end,) = taylor_states(Problem(f=(f,), y0=(1,), t_span=(0.0, 1.0)), [1], digits=30)
    context = end[0].context
    assert abs(end[0] - context.exp(context.sin(1))) < 1e-27


@pytest.mark.parametrize("stages", [1, 2, 3, 9, 16])
def test_radau_nodes_are_zeros_that_end_at_one(stages):
    context = high(40)
    nodes = radau_nodes(stages, context)
    assert nodes == sorted(nodes) and len(set(nodes)) == stages and nodes[-1] == 1 and nodes[0] > 0
    for c in nodes:
        x = 2 * c - 1
        value = context.legendre(stages, x) - context.legendre(stages - 1, x)
        # the slope at a zero is at most s**2
        assert abs(value) < 1e-36


def test_radau_nodes_of_two_stages_are_a_third_and_one():
    context = mpmath.MPContext()
    assert abs(radau_nodes(2, context)[0] - context.mpf(1) / 3) < 1e-15


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("name", "parameters", "t"),
    [("kaps", {}, 1), ("prothero-robinson", {}, 2), ("dahlquist", {"real": -1000}, "1/500")],
)
def test_collocation_agrees_with_the_exact_solution_however_stiff(name, parameters, t):
    p = problem(name, **parameters)
    (end,) = collocation_states(p, [t], digits=16, stages=8)
    context = high(40)
    exact = p.on(context).solution(Fraction(t))
    assert size(end - exact) < 1e-15


@pytest.mark.slow
def test_collocation_and_taylor_agree():
    p = problem("van-der-pol", mu=2)
    (implicit,) = collocation_states(p, ["1/2"], digits=16, stages=8)
    (explicit,) = taylor_states(p, ["1/2"], digits=25)
    assert size(implicit - explicit) < 1e-16
