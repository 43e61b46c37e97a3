"""Peers: refused by name where they are not, right where they are; nothing is imported unasked."""

import importlib
import sys

import numpy as np
import pytest

from glmref.errors import UsageError
from glmref.measure import peers
from glmref.measure.peers import NAMES, Run, measure_peer, package_of, runner
from glmref.problems import Problem, problem
from tests.build import refused

TIMES = np.array([1.0, 2.0])


def installed(name):
    package = package_of(name)
    pytest.importorskip(package)


def test_asking_for_names_imports_no_peer():
    importlib.reload(peers)
    if "scipy" in sys.modules:
        pytest.skip("another test has loaded it")
    assert not {"scipy", "heyoka", "jax", "rebound", "nodepy"} & set(sys.modules)


def test_a_peer_that_is_not_installed_is_refused_by_name(monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(peers, "import_module", missing)
    with pytest.raises(UsageError, match="heyoka is not installed; pip install heyoka"):
        runner("heyoka", problem("pendulum"), tolerance=1e-6, times=TIMES)


def test_rebound_refuses_what_has_no_bodies(monkeypatch):
    monkeypatch.setattr(peers, "import_module", lambda name: None)
    with pytest.raises(UsageError, match="gravitating bodies; pendulum has none"):
        runner("rebound-ias15", problem("pendulum"), tolerance=1e-6, times=TIMES)


def made_of(run):
    return {"toy": ("toy", lambda subject, tolerance, times, method: lambda: run, "toy")}


@pytest.mark.parametrize(
    ("run", "outcome"),
    [
        (Run(np.array([[np.nan, 0.0]])), "not finite"),
        (Run(np.zeros((0, 2)), message="step size too small"), "gave up"),
    ],
)
def test_a_run_that_fails_is_a_named_outcome(monkeypatch, run, outcome):
    monkeypatch.setattr(peers, "_ADAPTERS", made_of(run))
    found = measure_peer("toy", problem("harmonic-oscillator"), tolerance=1e-6, t_end=1.0)
    assert found["outcome"] == outcome
    assert "state_error" not in found


@pytest.mark.sampled(1)
@pytest.mark.peers
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("subject", ["kepler", "pendulum", "outer-solar-system"])
def test_a_peer_solves_the_problem_to_about_its_tolerance(name, subject):
    installed(name)
    chosen = problem(subject)
    if name.startswith("rebound") and subject == "pendulum":
        pytest.skip("no bodies")
    t_end = {"kepler": 6.283185307179586, "pendulum": 5.0, "outer-solar-system": 1000.0}[subject]
    found = measure_peer(
        name, chosen, tolerance=1e-9, t_end=t_end, ask=("state", "energy"), repeats=1
    )
    assert found["outcome"] == "completed", found["message"]
    # global errors exceed local tolerances by what a problem amplifies, and by steps
    assert found["state_error"] < 1e-5
    assert found["energy_error"] < 1e-5


@pytest.mark.slow
@pytest.mark.peers
@pytest.mark.parametrize("name", ["heyoka", "diffrax-dopri8"])
def test_a_right_hand_side_in_python_is_refused_where_symbols_are_needed(name):
    installed(name)
    plain = Problem(f=lambda t, y: -np.asarray(y), y0=(1.0,))
    refused(UsageError, "as expressions or loops", runner, name, plain, tolerance=1e-6, times=TIMES)
