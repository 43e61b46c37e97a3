"""The pytest face of the suite, and the face without pytest: the same checks, the same verdicts."""

import json
import subprocess
import sys
import textwrap
import zipfile
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest

import glmref

# the runs below happen in this process, and numpy cannot be loaded a second time
import glmref.conformance.checks
import glmref.conformance.generate
import glmref.conformance.pipe
from glmref.conformance import adapter

pytest_plugins = ["pytester"]

PACKAGE = Path(glmref.__file__).parent
INSTALLED = any(x.value == "glmref.conformance.plugin" for x in entry_points(group="pytest11"))
PLUGIN = [] if INSTALLED else ["-p", "glmref.conformance.plugin"]
SUITE = ["--pyargs", "glmref.conformance", "-p", "no:cacheprovider"]

#: What `glmref.conformance.adapter` shows its reader; the second class has one fault.
ADAPTERS = (
    textwrap.dedent(str(adapter.__doc__).partition("::\n")[2])
    + """

class TimeForgotten(Adapter):
    def step(self, method, problem, t, y, h):
        class Frozen:
            f = staticmethod(lambda s, x: problem.f(t, x))

        return super().step(method, Frozen, t, y, h)


class Chatty(Adapter):
    def step(self, method, problem, t, y, h):
        print("a step of", h)
        return super().step(method, problem, t, y, h)


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
)


@pytest.fixture
def here(pytester: pytest.Pytester) -> pytest.Pytester:
    """A folder with a module of adapters, as a user has it."""
    pytester.makepyfile(mine=ADAPTERS)
    return pytester


def run(here: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    return here.runpytest_inprocess(*PLUGIN, *SUITE, *arguments)


@pytest.mark.slow
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
        ("mine.py:Adapter", "not a file: write mine:Adapter"),
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


@pytest.mark.slow
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
    unmatched.stderr.fnmatch_lines(["*no check has the id*did you mean abscissae/rk4/forced*"])
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


def wheel(folder: Path) -> Path:
    """Build the wheel of this repository."""
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(folder)]
    if find_spec("hatchling") is not None:
        command.append("--no-build-isolation")
    subprocess.run([*command, str(PACKAGE.parent)], check=True)
    (built,) = folder.glob("glmref-*.whl")
    return built


@pytest.mark.slow
def test_it_runs_from_an_installed_wheel_with_xdist_and_strict_options(here, monkeypatch) -> None:
    pytest.importorskip("xdist")
    if find_spec("pip") is None or not (PACKAGE.parent / "pyproject.toml").is_file():
        pytest.skip("a wheel is built with pip from a checkout")
    site = here.path / "site"
    with zipfile.ZipFile(wheel(here.path / "dist")) as archive:
        archive.extractall(site)
    inside = {x.relative_to(PACKAGE) for x in PACKAGE.rglob("*.*") if "__pycache__" not in x.parts}
    assert [x for x in sorted(inside) if not (site / "glmref" / x).is_file()] == []
    monkeypatch.setenv("PYTHONPATH", str(site))
    shown = here.run(sys.executable, "-c", "import glmref; print(glmref.__file__)")
    assert shown.outlines == [str(site / "glmref" / "__init__.py")]
    # the plugin is found by the wheel's own entry point
    arguments = ["--pyargs", "glmref.conformance", "--glmref-adapter", "mine:Adapter"]
    strict = ["-W", "error", "--strict-markers", "-n", "2", "--junitxml", "found.xml"]
    done = here.run(sys.executable, "-m", "pytest", *arguments, *strict)
    assert done.ret == 0
    assert done.parseoutcomes()["passed"] >= 12
    cases = ElementTree.parse(here.path / "found.xml").iter("testcase")
    assert "test_integrator[order4/rk4/pendulum]" in [case.get("name") for case in cases]


def module(here: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    return here.run(sys.executable, "-m", "glmref.conformance", *arguments)


@pytest.mark.slow
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


@pytest.mark.slow
def test_the_face_without_pytest_says_a_bad_adapter_in_one_line(here, monkeypatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(PACKAGE.parent))
    done = module(here, "mine:Neither")
    assert done.ret == 2 and len(done.errlines) == 1


@pytest.mark.slow
def test_the_page_without_pytest_shows_the_defect_and_counts_what_rests_on_it(here, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(PACKAGE.parent))
    done = module(here, "mine:TimeForgotten")
    assert done.ret == 1
    done.stdout.fnmatch_lines(
        [
            "rk4: 8 of 13 hold",
            "  FAILS  abscissae/rk4 (forced):*(AbscissaeIgnored)*",
            "  4 more are not judged: they rest on these",
            "8 holds, 1 fails, 4 open",
        ],
        consecutive=True,
    )


@pytest.mark.slow
def test_what_an_adapter_prints_stays_out_of_the_findings(here, monkeypatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(PACKAGE.parent))
    done = module(here, "mine:Chatty", "--format", "json")
    assert json.loads(done.stdout.str())["summary"]["holds"] == 13
    assert "a step of 0.125" in done.stderr.str()


@pytest.mark.slow
def test_the_ids_and_a_junit_file_come_out_without_pytest(here, monkeypatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(PACKAGE.parent))
    ids = module(here, "mine:Adapter", "--list").outlines
    assert len(ids) == len(set(ids)) == 13 and "order4/rk4/pendulum" in ids
    document = module(here, "mine:TimeForgotten", "--format", "junit").stdout.str()
    (suite,) = ElementTree.fromstring(document).iter("testsuite")
    assert suite.get("tests") == "13" and suite.get("failures") == "1"
