"""Starting and finishing methods as kernels of rows."""

import time

import numpy as np
import pytest

from glmref import Problem, load, problem, solve
from glmref.engine import maps
from glmref.engine.maps import Map, map_of
from glmref.engine.outcome import Outcome
from glmref.engine.reference import apply_start, stepper
from glmref.engine.shape import shape_of


@pytest.mark.parametrize(  # explicit and implicit finish
    "name", ["s5i2-w3", pytest.param("order8-s5-w3", marks=pytest.mark.slow)]
)
def test_rows_are_finished_as_by_the_reference(name):
    options = {"h": 0.05, "renew": 6}
    run = solve("kepler", name, every=3, steps=20, **options)
    reference = solve("kepler", name, every=3, steps=20, engine="reference", **options)
    assert np.abs(run.y - reference.y).max() < 1e-13
    assert run.renewals == reference.renewals == 3 and run.finish_evaluations > 0
    # each row by itself, whatever the others
    picked = solve("kepler", name, times=run.t[[2, 5, 7]].tolist(), **options)
    np.testing.assert_array_equal(picked.y, run.y[[2, 5, 7]])
    interpreted = solve("kepler", name, every=3, steps=20, engine="interpreted", **options)
    np.testing.assert_array_equal(interpreted.y, run.y)


def test_many_rows_of_a_finished_method_cost_no_more_than_its_steps():
    solve("kepler", "s5i2-w3", h=0.01, steps=10, every=1)
    begin = time.process_time()
    solve("kepler", "s5i2-w3", h=0.01, steps=20_000, every=1)
    assert time.process_time() - begin < 1  # 4 s when each row was finished in Python


@pytest.mark.parametrize(
    ("name", "of"),
    [
        ("multistep-general-8", "uneven-plane"),  # both halves at one point
        ("multistep-kinetic-6", "magnetic-bottle"),  # q' = f(p)
        ("multistep-8", "henon-heiles"),  # q and p at points of their own
        ("s5i2-w3", "kepler"),
    ],
)
def test_a_start_by_a_kernel_has_the_bits_of_the_reference(name, of):
    method, system = load(name), problem(of)
    y0, h = np.array(system.y0, dtype=float), 0.03125
    wanted, cost = apply_start(method.starting, stepper(method, system), 0.0, y0, h)
    for interpreted in (False, True):
        kernel = map_of(method.starting, system, interpreted=interpreted)
        rows = np.zeros((1, *wanted.shape))
        rows[0, 0] = y0
        assert kernel(rows, 0.0, h) == (1, cost)
        np.testing.assert_array_equal(rows[0], wanted)


def test_a_run_with_many_renewals_compiles_their_start(monkeypatch):
    options = {"h": 0.02, "steps": 4000, "every": 500}
    compiled = []
    monkeypatch.setattr(
        "glmref.engine.run.map_of",
        lambda one, *given, **how: compiled.append(one) or map_of(one, *given, **how),
    )
    monkeypatch.setattr("glmref.engine.run._MANY", 40)
    few = solve("uneven-plane", "multistep-general-8", renew=100, **options)
    assert compiled == [None]  # no finish
    monkeypatch.setattr("glmref.engine.run._MANY", 39)
    many = solve("uneven-plane", "multistep-general-8", renew=100, **options)
    assert compiled[2] is not None
    assert many.renewals == few.renewals == 39
    assert many.start_evaluations == few.start_evaluations == 40 * 24
    np.testing.assert_array_equal(many.y, few.y)


@pytest.mark.parametrize(
    ("name", "of", "h"),
    [
        ("multistep-general-8b", "uneven-plane", 0.02),
        ("multistep-general-6", "discrete-schroedinger", 0.022),  # lost, with a notice
        ("multistep-kinetic-8", "dipole-charge", 0.02),  # its steps remember a slope
    ],
)
@pytest.mark.parametrize("how", [{"every": 7}, {"times": [40, 63, 66]}, {"history": True}])
def test_renewals_between_compiled_steps_are_those_of_python(name, of, h, how, monkeypatch):
    """Also where rows and ends of pieces are on renewals; the interpreter returns to Python."""
    if "times" in how:
        how = {"times": [n * h * 50 for n in how["times"]]}
    else:
        how = how | {"steps": 3300}
    monkeypatch.setattr("glmref.engine.kernel._FIRST_CHUNK", 150)
    with_, without = (
        solve(of, name, h=h, renew=150, engine=engine, **how)
        for engine in ("compiled", "interpreted")
    )
    for key in ("y", "values", "t"):
        np.testing.assert_array_equal(getattr(with_, key), getattr(without, key))
    if with_.history is not None:
        np.testing.assert_array_equal(with_.history, without.history)
    for key in ("outcome", "evaluations", "start_evaluations", "renewals", "suspect", "notices"):
        assert getattr(with_, key) == getattr(without, key)
    assert with_.renewals == 21


def test_a_renewal_between_compiled_steps_that_fails_ends_the_run_by_name():
    rows = {"q": "p*(1 + q*q)", "p": "-q + sqrt(2 - t)*(1 + p*p)/10"}
    ends = Problem.from_equations(rows, {"q": 1, "p": 0})  # no number from t = 2 on
    found = [
        solve(ends, "multistep-general-6", h=0.001, steps=4000, renew=40, engine=engine)
        for engine in ("compiled", "interpreted")
    ]
    assert found[0].outcome is found[1].outcome is Outcome.NOT_FINITE
    assert "in renewing the values: the values are not finite" in found[0].message
    for key in ("steps", "message", "start_evaluations", "renewals", "suspect"):
        assert getattr(found[0], key) == getattr(found[1], key)
    np.testing.assert_array_equal(found[0].y, found[1].y)


def test_a_run_with_renewals_is_cancelled():
    asked = []
    run = solve(
        "uneven-plane", "multistep-general-8", h=0.02, steps=3_000_000, renew=1000,
        cancel=lambda: len(asked) > 20 or bool(asked.append(1)),
    )  # fmt: skip
    assert run.outcome.name == "CANCELLED"


def test_what_needs_python_has_no_kernel():
    def branches(t, y):
        return -y if y[0] > 0 else y

    opaque = Problem(f=branches, y0=(1.0,), name="opaque")
    assert map_of(load("s5i2-w3").finishing, opaque) is None
    assert map_of(None, problem("kepler")) is None
    assert map_of(load("s5i2-w3").finishing, problem("kepler")) is not None


def test_the_source_of_a_map_is_written_once(monkeypatch, tmp_path):
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))
    finish, shape = load("s5i2-w3").finishing, shape_of(problem("kepler"))
    ends = []
    for _ in range(2):  # the second one as in a later process
        row = np.array(problem("kepler").y0, dtype=float)[None, None]
        assert Map(finish, shape, interpreted=False)(row, 0.0, 0.01)[0] == 1
        ends.append(row)
        monkeypatch.setattr(maps._MapBuilder, "kernel", None)
    np.testing.assert_array_equal(*ends)


@pytest.mark.slow
def test_a_guess_of_zeros_is_not_computed(monkeypatch, tmp_path):
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))
    monkeypatch.setattr("glmref.engine.stages.lagrange_weights", None)  # dear for coupled stages
    finish = load("order8-s3-w3-i").finishing
    assert finish is not None and len(finish.stage_blocks()) == 1
    assert Map(finish, shape_of(problem("kepler")), interpreted=False).work_size > 0
