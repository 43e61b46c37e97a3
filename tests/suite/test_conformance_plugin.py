"""The pytest face of the suite, and the face without pytest: the same checks, the same verdicts."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import textwrap
from importlib.metadata import entry_points
from pathlib import Path

import pytest

import glmref

# the runs below happen in this process, and numpy cannot be loaded a second time
import glmref.conformance.checks
import glmref.conformance.generate
import glmref.conformance.pipe
from glmref.catalogue import data_root

pytest_plugins = ["pytester"]

PACKAGE = Path(glmref.__file__).parent
INSTALLED = any(x.value == "glmref.conformance.plugin" for x in entry_points(group="pytest11"))
PLUGIN = [] if INSTALLED else ["-p", "glmref.conformance.plugin"]
SUITE = ["--pyargs", "glmref.conformance", "-p", "no:cacheprovider"]

#: What `glmref.conformance.adapter` shows its reader; the second class has one fault.
ADAPTERS = """
class Adapter:
    methods = ("rk4",)

    def step(self, method, problem, t, y, h):
        f = problem.f
        k1 = f(t, y)
        k2 = f(t + h / 2, y + h / 2 * k1)
        k3 = f(t + h / 2, y + h / 2 * k2)
        k4 = f(t + h, y + h * k3)
        return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


class TimeForgotten(Adapter):
    def step(self, method, problem, t, y, h):
        class Frozen:
            f = staticmethod(lambda s, x: problem.f(t, x))

        return super().step(method, Frozen, t, y, h)


class Neither:
    methods = ("rk4",)


class Unknown(Adapter):
    methods = ("rk5",)


class NeedsArguments(Adapter):
    def __init__(self, size):
        self.size = size


def broken():
    raise OSError("no library")
"""


@pytest.fixture
def here(pytester: pytest.Pytester) -> pytest.Pytester:
    """A folder with a module of adapters, as a user has it."""
    pytester.makepyfile(mine=ADAPTERS)
    return pytester


def run(here: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    return here.runpytest_inprocess(*PLUGIN, *SUITE, *arguments)


def test_the_adapter_of_the_documentation_passes_with_warnings_as_errors(here) -> None:
    result = run(here, "--glmref-adapter", "mine:Adapter", "-W", "error", "--strict-markers", "-v")
    assert result.ret == 0
    passed = result.parseoutcomes()["passed"]
    assert passed >= 12
    result.stdout.fnmatch_lines(["*test_integrator?order4/rk4/pendulum? PASSED*"])


def test_the_documented_adapter_is_the_one_tested() -> None:
    from glmref.conformance import adapter

    shown = textwrap.dedent(adapter.__doc__.partition("passes::")[2]).strip()
    assert shown in textwrap.dedent(ADAPTERS).strip()


def test_a_fault_fails_by_name_and_what_rests_on_it_is_not_judged(here) -> None:
    result = run(here, "--glmref-adapter", "mine:TimeForgotten")
    assert result.ret == 1
    outcome = result.parseoutcomes()
    assert outcome["failed"] == 1 and outcome["skipped"] == 4
    result.stdout.fnmatch_lines(["*abscissae/rk4/forced*(AbscissaeIgnored)*"])


@pytest.mark.parametrize(
    ("adapter", "words"),
    [
        ("mine:Neither", "must have a method `step` or `solve`"),
        ("mine:Unknown", "no method named*rk5*did you mean"),
        ("mine:Missing", "has no 'Missing'"),
        ("absent_module:Adapter", "cannot be imported"),
        ("mine:NeedsArguments", "cannot be made without arguments"),
        ("mine:broken", "cannot be made*no library"),
        ("mine", "must be written package.module:Name"),
        ("cmd:/no/such/program", "cannot be started"),
        ("cmd:", "must be followed by a program"),
    ],
)
def test_a_bad_adapter_is_one_line_and_exit_code_4(here, adapter: str, words: str) -> None:
    result = run(here, "--glmref-adapter", adapter)
    assert result.ret == 4
    (line,) = [x for x in result.errlines if x.strip()]
    result.stderr.fnmatch_lines([f"ERROR: *{words}*"])
    assert "Traceback" not in line and result.outlines == []


def test_no_adapter_is_one_line_and_exit_code_4(here, monkeypatch) -> None:
    monkeypatch.delenv("GLMREF_ADAPTER", raising=False)
    result = run(here)
    assert result.ret == 4
    result.stderr.fnmatch_lines(["ERROR: give the integrator: --glmref-adapter*"])


def test_the_adapter_may_come_from_the_environment(here, monkeypatch) -> None:
    monkeypatch.setenv("GLMREF_ADAPTER", "mine:Adapter")
    assert run(here).ret == 0


def test_known_failures_are_strict_and_need_a_reason(here) -> None:
    def known(text: str, adapter: str = "mine:TimeForgotten") -> pytest.RunResult:
        here.path.joinpath("known.txt").write_text(text, encoding="utf-8")
        return run(here, "--glmref-adapter", adapter, "--glmref-known-failures", "known.txt")

    good = known("# ours\n\nabscissae/rk4/forced: time is not passed on, issue 12\n")
    assert good.ret == 0 and good.parseoutcomes()["xfailed"] == 1
    passing = known("abscissae/rk4/forced: fixed long ago\n", "mine:Adapter")
    assert passing.ret == 1
    passing.stdout.fnmatch_lines(["*XPASS(strict)*fixed long ago*"])
    unmatched = known("abscissae/rk4/force: gone\n")
    assert unmatched.ret == 4
    unmatched.stderr.fnmatch_lines(["*no check has the id*the nearest is abscissae/rk4/forced*"])
    for text, words in (
        ("step/rk4/cubic\n", "needs a reason"),
        ("step/rk4/cubic: a\n" * 2, "twice"),
    ):
        bad = known(text)
        assert bad.ret == 4 and words in bad.stderr.str()


def test_known_failures_without_an_adapter_are_a_mistake(here, monkeypatch) -> None:
    monkeypatch.delenv("GLMREF_ADAPTER", raising=False)
    result = here.runpytest_inprocess(*PLUGIN, "--glmref-known-failures", "x")
    assert result.ret == 4


def test_the_plugin_leaves_other_tests_alone(here, monkeypatch) -> None:
    monkeypatch.setenv("GLMREF_ADAPTER", "mine:Adapter")
    here.makepyfile(test_own="def test_one():\n    assert True\n")
    result = here.runpytest_inprocess(*PLUGIN)
    assert result.ret == 0 and result.parseoutcomes() == {"passed": 1}


def test_the_plugin_loads_nothing_heavy() -> None:
    code = (
        "import sys, glmref.conformance.plugin; "
        "print([m for m in ('numpy', 'mpmath', 'flint', 'numba', 'click') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def installed(folder: Path) -> Path:
    """Lay the package out as a wheel does: data inside, nothing of the repository beside it."""
    skip = shutil.ignore_patterns("__pycache__", "data")
    shutil.copytree(PACKAGE, folder / "glmref", ignore=skip)
    shutil.copytree(data_root(), folder / "glmref" / "data")
    return folder


def test_it_runs_from_an_installed_package_with_xdist(here, monkeypatch) -> None:
    pytest.importorskip("xdist")
    site = installed(here.path / "site")
    monkeypatch.setenv("PYTHONPATH", str(site))
    arguments = [*PLUGIN, *SUITE, "--glmref-adapter", "mine:Adapter", "-n", "2", "-W", "error"]
    done = here.run(sys.executable, "-m", "pytest", *arguments)
    assert done.ret == 0
    assert done.parseoutcomes()["passed"] >= 12


def module(here: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    return here.run(sys.executable, "-m", "glmref.conformance", *arguments)


def test_the_face_without_pytest_gives_the_same_findings_as_json(here, monkeypatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(PACKAGE.parent))
    done = module(here, "mine:TimeForgotten", "--format", "json")
    assert done.ret == 1
    document = json.loads(done.stdout.str())
    assert document["format"] == "glmref-findings-1"
    verdicts = {x["claim"]: x["verdict"] for x in document["findings"]}
    assert [k for k, v in verdicts.items() if v == "fails"] == ["abscissae/rk4/forced"]
    assert document["summary"] == {"holds": 8, "fails": 1, "open": 4}
    here.path.joinpath("known.txt").write_text("abscissae/rk4/forced: known\n")
    assert module(here, "mine:TimeForgotten", "--known-failures", "known.txt").ret == 0


def test_the_face_without_pytest_says_a_bad_adapter_in_one_line(here, monkeypatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(PACKAGE.parent))
    done = module(here, "mine:Neither")
    assert done.ret == 4 and len(done.errlines) == 1
