"""compare: error against run time, one recommended method, and no method that is lost."""

import json
from dataclasses import replace

import pytest

import glmref
from glmref import Problem, UsageError
from glmref.catalogue.advice import ADVICE, long_runs
from glmref.catalogue.lookup import data_root, document
from glmref.cli import main
from glmref.problems import problem
from glmref.scenes import comparing
from glmref.scenes.comparing import Candidate, compare
from tests.build import refused


@pytest.fixture(scope="module")
def pendulum():
    own = Problem.from_hamiltonian("p**2/2 - cos(q)", {"q": 1, "p": 0}, t_end=10, name="mine")
    methods = ["blanes-moan-rkn-6-14", "pair-rkn-6-8b", "stormer-verlet", "rk4"]
    return compare(own, methods=methods, tolerance=1e-6)


@pytest.mark.slow
def test_every_candidate_reaches_the_tolerance_at_the_step_size_that_is_shown(pendulum):
    exact = problem("pendulum", q0=1)
    for one in pendulum.candidates:
        assert one.reached and one.error <= 1e-6
        run = glmref.solve(exact, one.method, h=one.h, steps=one.steps)
        error = abs(run.y[-1] - exact.solution(10.0)).max()
        assert error < 2e-6 and run.evaluations == one.evaluations
    times = [one.seconds for one in pendulum.candidates]
    assert times == sorted(times)
    assert "gauss-5" in pendulum.reference and pendulum.error == "state"


def test_the_recommended_method_is_symplectic_and_its_file_records_no_growth(pendulum):
    labels = {one.method: one.long_runs for one in pendulum.candidates}
    assert labels["pair-rkn-6-8b"] == "predicted as bounded" and labels["rk4"] == "drifts"
    # ranked by evaluations: of methods that take about the same time another one may be the fastest
    ranked = sorted(pendulum.candidates, key=lambda one: one.evaluations)
    name, reason = comparing._recommended(ranked, pendulum.kind, 1e-6, "state")
    assert name in ("blanes-moan-rkn-6-14", "stormer-verlet")
    assert name in reason or "it reaches" in reason
    assert labels[pendulum.recommended] in ("bounded", "predicted as bounded")


def test_a_method_that_is_lost_is_never_recommended_however_fast():
    fast = Candidate("fast", 6, "lost", 0.1, 10, 1e-10, None, 1e-6, 10)
    grows = replace(fast, method="grows", long_runs="grows")
    slow = replace(fast, method="slow", long_runs="drifts", seconds=1.0)
    name, reason = comparing._recommended([fast, grows, slow], "separable", 1e-9, "state")
    assert name == "slow" and "fast takes" in reason
    assert comparing._recommended([fast, grows], "separable", 1e-9, "state")[0] is None
    assert comparing._recommended([fast], "general", 1e-9, "state")[0] is None
    kept = replace(slow, method="kept", long_runs="recorded as bounded", renew=10_000)
    name, reason = comparing._recommended([slow, kept], "separable", 1e-9, "state")
    assert name == "kept" and "ten million steps" in reason and "need" not in reason


@pytest.mark.slow
def test_advice_names_methods_and_those_that_grow_are_labelled():
    for one in ADVICE:
        for name in (*one.take, *one.compared):
            notes = document(name).get("notes", [])
            said, label = " ".join(notes), long_runs(glmref.load(name), notes)
            reports = "has a notice" in said
            assert (label == "watched") == reports
            assert (label in ("lost", "grows")) == (
                ("grow" in said or "lost" in said) and not reports
            )
            assert label != "recorded as bounded" or "stays bounded" in said
            assert one.limited(name) == (label in ("lost", "grows"))
        assert not one.limited(one.take[0])  # the first choice has no limit
        assert len(one.why.split()) <= 20
    kinds = [one.kind for one in ADVICE if one.kind]
    assert sorted(kinds) == sorted({*kinds}) == sorted(comparing._WORDS)


def test_first_choices_stayed_bounded_in_the_records_of_long_runs():
    """Ten million steps on eight orbits at three step sizes: pairs alone grew or were lost."""
    rows = json.loads((data_root() / "measurements" / "long-survey.json").read_text("utf-8"))[
        "rows"
    ]
    far = {x["method"] for x in rows if x["steps"] >= 10_000_000}
    for one in ADVICE[:2]:
        for name in one.take:
            assert name in far
            bad = [
                run
                for x in rows
                if x["method"] == name and x["steps"] >= 10_000_000
                for run in x["runs"]
                if run["verdict"] in ("grows", "lost") and not run["renew"]
            ]
            assert bool(bad) == one.limited(name), name


def test_table_picture_and_numbers(pendulum):
    text = repr(pendulum)
    assert text.count("\n") >= 7 and f"take {pendulum.recommended}: " in text
    assert pendulum.svg().startswith("<svg") and "evaluations" in pendulum.svg(
        against="evaluations"
    )
    record = json.loads(json.dumps(pendulum.as_json()))
    assert record["recommended"] == pendulum.recommended
    assert all(one["works"] for one in record["candidates"])


@pytest.mark.slow
def test_without_a_good_reference_the_energy_judges():
    far = Problem.from_hamiltonian(
        "(p1**2 + p2**2 + q1**2 + q2**2)/2 + q1**2*q2 - q2**3/3",
        {"q1": 0, "q2": "1/10", "p1": "1/2", "p2": 0}, t_end=20, time="1/10",
    )  # fmt: skip
    error, reference = comparing._judge(far, 20.0, 1e-14)
    assert error == "energy" and "because" in reference
    wild = Problem.from_equations(["y[0]*y[0]"], [1], t_end=2)
    refused(UsageError, "shorten `t_end`", compare, wild, methods=["rk4"])


def test_the_command_writes_pictures_and_numbers(tmp_path, capsys, cli):
    path = tmp_path / "mine.toml"
    path.write_text('H = "p**2/2 - cos(q)"\ny0 = { q = 1, p = 0 }\nt_end = 5\n')
    arguments = ["compare", str(path), "--methods", "stormer-verlet,gauss-2"]
    assert "take " in cli(*arguments, "--tolerance", "1e-4", "--output", tmp_path / "out").out
    written = {x.name for x in (tmp_path / "out").iterdir()}
    assert written == {"mine.svg", "mine-evaluations.svg", "mine.json"}
    cli("compare", tmp_path / "none.toml", code=2)
    assert main(["compare", "pendulum", "--t-end", "x"]) == 2
    assert "`--t-end` must be a time such as '20*pi', got 'x'" in capsys.readouterr().err
