"""The adapters that are shipped: ours and scipy's pass; others where their library is there."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import glmref
from glmref.catalogue.lookup import load
from glmref.conformance.adapter import SHIPPED, load_adapter
from glmref.conformance.adapters.compiled import Adapter as Compiled
from glmref.conformance.adapters.reference import Adapter as Reference
from glmref.conformance.checks import Suite
from glmref.conformance.subject import Subject
from glmref.conformance.verdicts import order_judgement
from glmref.engine.reference import stepper
from glmref.engine.solve import solve
from glmref.engine.starting_values import starting_values
from glmref.errors import UsageError
from glmref.findings import Verdict


def all_hold(adapter: Any) -> int:
    findings = Suite(Subject(adapter)).findings()
    # a Taylor method of expressions shows no coefficients
    left = [x for x in findings if x.claim != "coefficients/taylor/probe"]
    assert [x for x in left if x.verdict is not Verdict.HOLDS] == []
    return len(findings)


@pytest.mark.slow
def test_the_reference_engine_passes_every_check_of_every_method() -> None:
    assert all_hold(Reference()) >= 400


@pytest.mark.slow
def test_a_method_without_vectors_is_judged_all_the_same() -> None:
    assert all_hold(Reference(("heun-3", "adams-nordsieck-3", "position-verlet"))) >= 40


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "am-1",  # its reversal acts on fewer values than it carries
        "am-3", "abm-4-pece", "bdf-4", "butcher-effective-5",  # the slopes settle late
        "kraaijevanger-spijker",  # the box of its stages must have unequal sides
        "gsymplectic-n-start-3-6",  # implicit start and finish
        "gsymplectic-n-pair", "pair-6-7", "pair-rkn-6-7",  # pairs that carry several values
    ],
)  # fmt: skip
def test_vectors_of_unusual_methods_are_made_and_hold(name: str) -> None:
    all_hold(Reference((name,)))


@pytest.mark.parametrize(("name", "holds"), [("rk4", True), ("heun-3", False)])
def test_the_order_of_runs_that_start_by_themselves_is_measured(name: str, holds: bool) -> None:
    """A run that only shows its end: RK4 passes as RK4, a method of order 3 sold as RK4 does not."""

    class EndOnly:
        methods, starts = ("rk4",), "own"

        def solve(self, method: str, problem: Any, h: float, steps: int, start: Any = None) -> Any:
            return Reference((name,)).solve(name, problem, h, steps)[-1]

    suite = Suite(Subject(EndOnly()))
    (order,) = [x for x in suite.checks if x.claim == "order"]
    finding = order.judge()
    assert finding.holds is holds
    assert holds or "falls like h^3" in finding.message


@pytest.mark.slow
def test_a_method_of_several_values_outside_the_catalogue_is_run_from_its_own_start() -> None:
    """It was given one value, and its step failed."""

    class TwoValues:
        methods = {"mine": {"order": 2, "values": 2, "symmetric": True}}  # noqa: RUF012

        def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
            slope = problem.f(t, y[0])
            return np.array([y[0] + h * (1.5 * slope - 0.5 * y[1]), slope])

    class Started(TwoValues):
        def start(self, method: str, problem: Any, h: float) -> Any:
            t, y = problem.t_span[0], np.array(problem.y0)
            return np.array([y, problem.f(t - h, y - h * problem.f(t, y))])

        def finish(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
            return y[0]

    found = Suite(Subject(TwoValues())).findings()
    assert {x.verdict for x in found} == {Verdict.OPEN}
    assert all("2 values" in x.witness for x in found)
    found = Suite(Subject(Started())).findings()
    assert {x.claim: x.verdict for x in found}["order2/mine/kepler"] is Verdict.HOLDS
    assert not [x for x in found if x.verdict is Verdict.FAILS], found


class OwnStart:
    """Runs of a method that make their starting values themselves, and take no others."""

    starts = "own"

    def __init__(self, name: str, start: Any, end_only: bool = False) -> None:
        self.methods, self.begin, self.end_only = (name,), start, end_only

    def solve(self, method: str, problem: Any, h: float, steps: int) -> Any:
        found = solve(problem, method, h=h, steps=steps, every=1, start=self.begin)
        return found.y[-1] if self.end_only else found.y

    def start(self, method: str, problem: Any, h: float) -> Any:
        known = load(method)
        engine = stepper(known, problem)
        begin = known.starting if self.begin is None else self.begin
        y0 = np.array(problem.y0)
        return starting_values(engine, begin, t=problem.t_span[0], y0=y0, h=h).values


def failures(adapter: Any) -> dict[str, str]:
    findings = Suite(Subject(adapter)).findings()
    return {x.claim: x.witness for x in findings if x.verdict is Verdict.FAILS}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "end_only"),
    [("gsymplectic-n", False), ("gsymplectic-n", True), ("thesis-3-8", True),
     ("s4-symmetric", False), ("g6245-w3", False)],
)  # fmt: skip
def test_a_zero_start_is_refused_though_its_order_is_that_of_the_method(name, end_only):
    good = Suite(Subject(OwnStart(name, None, end_only))).findings()
    assert [x for x in good if x.verdict is not Verdict.HOLDS] == []
    assert f"long/{name}/rigid-body" in {x.claim for x in good}
    zero = OwnStart(name, "zero", end_only)
    found = failures(zero)
    wrong = found[f"long/{name}/rigid-body"]
    assert not any(x.startswith("order") for x in found)
    assert "times as much as from starting values of the right order" in wrong
    assert wrong.endswith(f"it is a start of order {2 if name == 'g6245-w3' else 1}")
    del_start = type("Runs", (OwnStart,), {"start": None})(name, "zero", end_only)
    assert list(failures(del_start)) == [f"long/{name}/rigid-body"]


@pytest.mark.parametrize(("name", "order"), [("leapfrog", 1), ("ab-2", 1), ("g4123", 2)])
def test_the_order_of_a_bad_own_start_is_named(name: str, order: int) -> None:
    runs = type("Runs", (OwnStart,), {"start": None})
    found = failures(runs(name, "zero"))
    (wrong,) = [text for claim, text in found.items() if claim.startswith("order")]
    assert wrong.endswith(f"and these give order {order}") and "TypeError" not in str(found)
    assert failures(runs(name, None)) == {}


@pytest.mark.parametrize("name", ["leapfrog", "ab-2"])
def test_a_solve_that_takes_no_start_is_judged_as_one_that_starts_by_itself(name: str) -> None:
    """The data give starting values of these methods; they were passed all the same (TypeError)."""
    runs = type("Runs", (OwnStart,), {"start": None, "starts": "file"})
    assert failures(runs(name, None)) == {}
    found = failures(runs(name, "zero"))
    assert [x for x in found if x.startswith("order")] and "TypeError" not in str(found)
    claims = {x.claim for x in Suite(Subject(runs(name, None))).findings()}
    assert not any(x.startswith("trajectory") for x in claims)


@pytest.mark.parametrize(
    ("words", "code"),
    [(["reference", "--list"], 0), (["nothing"], 2), (["tests.suite.planted:Missing"], 2)],
)
def test_the_subcommand_is_the_module(words, code, capsys):
    from glmref.cli import main as command

    module = [sys.executable, "-m", "glmref.conformance", *words]
    done = subprocess.run(module, capture_output=True, text=True, check=False, timeout=60)
    assert command(["conformance", *words]) == code == done.returncode
    assert capsys.readouterr() == (done.stdout, done.stderr) and (done.stdout or done.stderr)


@pytest.mark.parametrize("engine", ["interpreted", "compiled"])
def test_the_generated_code_passes(engine: str) -> None:
    """Both have the same bits, see tests/unit/test_engine_agreement.py."""
    all_hold(Compiled(("ab-2",), engine=engine))


@pytest.mark.slow
def test_compiled_kernels_of_every_method_pass() -> None:
    all_hold(Compiled())


@pytest.mark.slow
def test_scipy_passes() -> None:
    pytest.importorskip("scipy")
    assert all_hold(load_adapter("scipy")) >= 40


@pytest.mark.slow
@pytest.mark.peers
@pytest.mark.parametrize(
    ("name", "library"),
    [("diffrax", "diffrax"), ("heyoka", "heyoka"), ("rebound", "rebound"), ("nodepy", "nodepy")],
)
def test_a_peer_passes(name: str, library: str) -> None:
    pytest.importorskip(library)
    all_hold(load_adapter(name))


def test_every_shipped_adapter_has_a_module() -> None:
    from importlib.util import find_spec

    assert all(find_spec(x.target.partition(":")[0]) for x in SHIPPED.values())


class Plain:
    """The least that is an adapter."""

    methods: Any = ("rk4",)

    def step(self, *_: Any) -> np.ndarray:
        raise NotImplementedError("not today")


class FourComponentsOnly(Reference):
    """Does kepler and nothing else, and says so when it is asked."""

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        if problem.dimension != 4:
            raise NotImplementedError("two bodies only")
        return super().step(method, problem, t, y, h)

    stages = solve = start = finish = None  # type: ignore[assignment]


def test_what_an_adapter_does_not_offer_is_not_judged() -> None:
    found = {x.claim: x for x in Suite(Subject(FourComponentsOnly(("rk4",)))).findings()}
    assert found["answer/rk4/linear"].verdict is Verdict.HOLDS
    assert found["step/rk4/kepler"].verdict is Verdict.HOLDS
    assert found["step/rk4/cubic"].verdict is Verdict.OPEN
    assert found["step/rk4/cubic"].witness == "not offered: two bodies only"


def test_an_adapter_that_offers_nothing_of_what_it_lists_fails() -> None:
    first, *others = Suite(Subject(Plain())).findings()
    assert first.verdict is Verdict.FAILS and "offers no step or run of it" in first.witness
    assert {x.verdict for x in others} == {Verdict.OPEN}


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (None, "got None"),
        (np.array([1j, 0]), "real numbers, got ndarray of complex128"),
        (["1", "2"], "real numbers, got list"),
        ([[1.0], [2.0, 3.0]], "real numbers, got list"),
        ([1.0, float("inf")], "not finite"),
        ([1.0, 2.0, 3.0], "must return shape (1, 2), got (3,)"),
        (SystemExit(3), "step raised SystemExit: 3 (line "),
        (KeyError("radius"), "step raised KeyError: 'radius' (line "),
    ],
)
def test_an_answer_that_cannot_be_used_fails_with_a_sentence(answer: Any, words: str) -> None:
    class Odd(Plain):
        def step(self, *_: Any) -> Any:
            if isinstance(answer, BaseException):
                raise answer
            return answer

    first = Suite(Subject(Odd())).findings()[0]
    assert first.verdict is Verdict.FAILS and words in first.witness


@pytest.mark.parametrize(
    ("file", "words"),
    [
        (
            "/home/me/glmref/mine.py",
            "KeyError: 'radius' (line 3 of mine.py)",
        ),  # a clone of that name
        ("/home/me/my-glmref-adapter.py", "KeyError: 'radius' (line 3 of my-glmref-adapter.py)"),
        (str(Path(glmref.__file__).parent / "mine.py"), "KeyError: 'radius'"),
        ("/usr/lib/python3/site-packages/other/mine.py", "KeyError: 'radius'"),
    ],
)
def test_the_place_of_an_error_is_dropped_by_package_and_not_by_a_word_in_its_path(file, words):
    space: dict[str, Any] = {}
    code = "def step(self, *_):\n    lengths = {}\n    return lengths['radius']\n"
    exec(compile(code, file, "exec"), space)
    odd = type("Odd", (Plain,), {"step": space["step"]})
    first = Suite(Subject(odd())).findings()[0]
    assert first.witness == f"step raised {words}"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"methods": ()}, "`methods`"),
        ({"methods": None}, "`methods`"),
        ({"methods": ("rk5",)}, "no method named"),
        ({"methods": {"mine": {"speed": 3}}}, "claims 'speed'"),
        ({"methods": {"mine": {"order": "four"}}}, "whole number from 1 to 30"),
        ({"methods": {"mine": {"order": -1}}}, "whole number from 1 to 30"),
        ({"methods": {"mine": {"symmetric": 1}}}, "True or False"),
        ({"methods": {"mine": ["order"]}}, "must be a mapping"),
        ({"methods": 4}, "got 4"),
        ({"problems": 5}, "list of names"),
        ({"problems": ()}, "must name some of"),
        ({"problems": ("moon",)}, "must name some of linear"),
        ({"methods": ("stormer-verlet",), "problems": ("forced",)}, "no vector of stormer-verlet"),
        ({"tolerance": 2}, "`tolerance`"),
        ({"tolerance": {"rk4": "small"}}, "`tolerance`"),
        ({"epsilon": True}, "`epsilon`"),
        ({"starts": "somehow"}, "`starts`"),
        ({"step": None}, "`step` or `solve`"),
        ({"methods": {"mine": {"order": 4}}, "problems": ("moon",)}, "must name some of"),
    ],
)
def test_an_adapter_that_is_none_is_refused_with_a_sentence(changes: dict, words: str) -> None:
    cls = type("Bad", (Plain,), changes)
    with pytest.raises(UsageError) as caught:
        Suite(Subject(cls()))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("errors", "holds"),
    [
        # rk8_12 of rklib, of order 8: the slopes 7.40, 7.60 have not settled below 8
        ((0.00619, 1.28e-05, 7.61e-08, 3.91e-10, 1.66e-12), None),
        # its rk8_10, of order 7: 6.83, 6.95
        ((0.00181, 3.68e-05, 3.45e-07, 3.03e-09, 2.45e-11), False),
    ],
)
def test_slopes_that_still_rise_refute_no_order(errors, holds):
    subject = Subject(Reference(("rk4",)))
    steps = [4 << k for k in range(len(errors))]
    assert order_judgement(steps, errors, 8, subject, "rk4").holds is holds
