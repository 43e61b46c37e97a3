"""Arguments of wrong kinds: one short sentence of the package, whatever their class does."""

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from itertools import count
from typing import Any

import mpmath
import numpy as np
import pytest

import glmref
from glmref import GlmrefError, Problem, UsageError, load, solve
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.outcome import Outcome
from glmref.problems import problem
from glmref.system.arguments import flag, number, one_of, shown, whole
from tests.attack.odd import ODD, Hostile, Long
from tests.build import refused

ARGUMENTS = (
    "method h t_end steps every times start renew engine arithmetic form solver history digits "
    "step_limit cancel progress"
).split()


def _refusal(call: Callable[[], Any]) -> str:
    found = refused(GlmrefError, "", call)
    text = found
    assert text.isprintable() and len(text) < 500
    return text


@pytest.mark.parametrize("argument", ARGUMENTS)
def test_odd_arguments_of_a_run_are_refused(argument: str) -> None:
    spring = Problem(f=("y[1]", "-y[0]"), y0=(1, 0))
    for engine in ("reference", "interpreted"):
        for odd, value in ODD.items():
            if (odd, argument) in FITS:
                continue
            given = {"method": "rk4", "h": 0.1, "steps": 3, "engine": engine, argument: value()}
            if argument in ("t_end", "times"):
                del given["steps"]
            _refusal(lambda given=given: solve(spring, given.pop("method"), **given))


@pytest.mark.parametrize(
    "argument", ["initial", "solver", "arithmetic", "threads", "width", "start", "cancel"]
)
def test_odd_arguments_of_an_ensemble_are_refused(argument: str) -> None:
    spring = Problem(f=("y[1]", "-y[0]"), y0=(1, 0))
    for odd, value in ODD.items():
        if argument == "initial" and hasattr(value(), "__array__") and odd == "matrix":
            continue  # mpmath 1.4 makes an array of it, and one of the right shape
        given = {"initial": np.ones((3, 2)), "h": 0.1, "steps": 3, argument: value()}
        _refusal(lambda given=given: solve_ensemble(spring, "rk4", given.pop("initial"), **given))


METHOD = load("gsymplectic-n")
START = {"A": [["0"]], "B": [["0"], ["1"]], "u": ["1", "0"]}
CALLS: dict[str, tuple[Callable[..., Any], dict[str, Any], str]] = {
    "from_rk": (glmref.from_rk, {"A": [["0"]], "b": ["1"]}, "A b name"),
    "from_lmm": (glmref.from_lmm, {"alpha": [-1, 1], "beta": [1, 0]}, "alpha beta name"),
    "from_splitting": (glmref.from_splitting, {"a": [1], "b": [1]}, "a b first name"),
    "GLM": (
        glmref.GLM, {key: getattr(METHOD, key) for key in "AUBV"},
        "A U B V name G D starting finishing claims source document output embedded abscissae_given dense",
    ),
    "StartingMethod": (glmref.StartingMethod, START, "A B u name kind claims"),
    "FinishingMethod": (glmref.FinishingMethod, {"A": [["0"]], "b": ["1"]}, "A b name claims"),
    "AdditiveGLM": (
        glmref.AdditiveGLM, {"A": [[["0"]], [["0"]]], "B": [[["1"]], [["1"]]]}, "A B U V name claims",
    ),
    "check": (glmref.check, {"A": [["0"]], "b": ["1"]}, "A b c order digits embedded"),
    "problem": (problem, {}, "name"),
    "names": (glmref.names, {}, "folder"),
    "load": (glmref.load, {}, "name"),
    "save": (METHOD.save, {}, "path"),
    "from_hamiltonian": (
        Problem.from_hamiltonian, {"H": "q**2 + p**2", "y0": {"q": 1, "p": 0}},
        "H y0 parameters invariants coordinates name t_end",
    ),
    "from_equations": (
        Problem.from_equations, {"f": {"x": "-x"}, "y0": {"x": 1}}, "f y0 parameters invariants name",
    ),
    "export": (glmref.export, {"method": "rk4", "to": "c"}, "method to digits"),
    "show": (glmref.show, {"method": "rk4"}, "method decimal style"),
    "analyze": (glmref.analyze, {"method": METHOD}, "method budget"),
    "verify": (glmref.verify, {"method": "rk4"}, "method only budget"),
    "compare": (glmref.compare, {"problem": "kepler"}, "problem tolerance t_end budget"),
    "Problem": (Problem, {"f": ("-y[0]",), "y0": (1,)}, "f y0 parameters t_span quadratic bodies"),
    "solution": (problem("harmonic-oscillator").solution, {"t": 1}, "t"),
    "on": (problem("harmonic-oscillator").on, {"context": mpmath.MPContext()}, "context"),
}  # fmt: skip
#: What fits all the same: a name may be any text, a mapping of claims any mapping...
FITS = {
    ("text", "name"), ("surrogate", "name"), ("surrogate", "path"), ("text", "kind"), ("surrogate", "kind"),
    ("dict", "claims"), ("dict", "source"), ("dict", "document"), ("record", "B"), ("record", "dense"), ("dict", "parameters"),
}  # fmt: skip


@pytest.mark.parametrize("name", CALLS)
def test_odd_arguments_of_other_functions_are_refused(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, given, arguments = CALLS[name]
    for argument in arguments.split():
        for odd, value in ODD.items():
            if (odd, argument) not in FITS or name in ("load", "problem"):
                _refusal(lambda a=argument, x=value: function(**{**given, a: x()}))


def test_values_are_shown_in_a_line() -> None:
    assert shown([1, "a"]) == "[1, 'a']"
    assert shown(np.zeros((2, 2))) == "array([[0., 0.], [0., 0.]])"
    assert shown("z" * 100) == "'" + "z" * 39 + "... (102 characters)"
    assert shown(Hostile()) == "a Hostile"
    assert shown(10**5000) == "a whole number with thousands of digits"
    assert shown(Long()).startswith("one ?[31mone")


def test_numbers_of_every_class_are_read() -> None:
    for value in (
        0.5,
        Fraction(1, 2),
        Decimal("0.5"),
        mpmath.mpf("0.5"),
        np.float32(0.5),
        np.array(0.5),
        "0.5",
    ):
        assert number("h", value) == 0.5
    assert number("h", np.int8(3)) == 3.0
    assert whole("n", np.uint8(7)) == 7 and whole("n", np.array(7), 7, 7) == 7
    assert one_of("form", np.str_("mu"), ("mu",)) == "mu"
    assert flag("history", np.bool_(True)) is True
    for wrong in (True, np.bool_(True), 1.0, "1"):
        refused(UsageError, r"`n` must be a whole number >= 0, got", whole, "n", wrong)
    for n in (-1, 3):
        with pytest.raises(UsageError, match=rf"`n` must be a whole number from 0 to 2, got {n}"):
            whole("n", n, 0, 2)
    refused(UsageError, "`history` must be True or False, got 1", flag, "history", 1)


def test_a_start_that_raises_is_named() -> None:
    for start in (lambda: 1, lambda problem, h: 1 / 0, lambda problem, h: "soon"):
        _refusal(lambda start=start: solve("kepler", "g6245", h=0.1, steps=1, start=start))
    with pytest.raises(UsageError, match="`start` raised ZeroDivisionError: division by zero"):
        solve("kepler", "g6245", h=0.1, steps=1, start=lambda problem, h: 1 / 0)


@pytest.mark.parametrize("engine", ["reference", "interpreted", "compiled"])
@pytest.mark.parametrize("name", ["cancel", "progress"])
@pytest.mark.parametrize("error", [ValueError("a\nb"), KeyError(1)])
def test_a_callback_that_raises_ends_the_run_and_is_named(name, engine, error):
    calls = count()

    def called(*_: int) -> bool:
        if next(calls) > 1:
            raise error
        return False

    given: dict[str, Any] = {name: called}
    found = solve("kepler", "rk4", h=1e-4, steps=10**6, every=1, engine=engine, **given)
    assert found.outcome is Outcome.CANCELLED and 0 < found.steps < 10**6
    assert len(found.y) == found.steps + 1 and np.isfinite(found.y).all()
    assert any(x.startswith(f"`{name}` raised {type(error).__name__}") for x in found.notices)


def test_a_callback_of_an_ensemble_that_raises_ends_it() -> None:
    def cancel() -> bool:
        raise ValueError("no")

    found = solve_ensemble(
        "kepler", "rk4", [problem("kepler").y0] * 3, h=0.01, steps=9, cancel=cancel
    )
    assert set(found.outcomes) == {Outcome.CANCELLED}
    assert found.notices == ("`cancel` raised ValueError: no",)


@pytest.mark.parametrize("engine", ["reference", "interpreted"])
def test_an_error_of_the_package_in_a_function_keeps_the_good_part(engine: str) -> None:
    def f(t: float, y: np.ndarray) -> np.ndarray:
        if t > 0.5:
            solve("kepler", "no-such-method", h=0.1)
        return -y

    found = solve(Problem(f=f, y0=(1.0,)), "rk4", h=0.1, steps=10, every=1, engine=engine)
    assert found.outcome is Outcome.FUNCTION_FAILED and len(found.y) == found.steps + 1 > 3
    assert "`f` raised UsageError: there is no method" in found.message


def test_a_start_and_a_finish_of_texts_are_read() -> None:
    start, finish = glmref.StartingMethod(**START), glmref.FinishingMethod(A=[["0"]], b=["0"])
    own = glmref.GLM(
        **{key: getattr(METHOD, key) for key in "AUBV"}, starting=start, finishing=finish
    )
    assert solve("kepler", own, h=0.01, steps=2, engine="reference").completed
    pair = {"A_hat": [["0"]], "B_hat": [["0"], ["1"]], "u_hat": ["1", "0"]}
    assert glmref.PairStartingMethod(**START, **pair).stages == (1, 1)
    for changed in ({"A": [["0", "0"]]}, {"B": [["0"]]}, {"u": ["1"]}, {"B": [["0", "0"]] * 2}):
        assert "must have" in _refusal(lambda x=changed: glmref.StartingMethod(**{**START, **x}))
