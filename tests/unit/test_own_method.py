"""An own method: given by arrays, numbers, lists; saved, shown, drawn, cited, analyzed, verified."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import glmref
from glmref.errors import DataError, UsageError
from glmref.exact import Exact
from glmref.exact.expression import parse
from glmref.method.rounding import float_arrays
from glmref.system.shown import DARK
from glmref.views.facts import analysis_rows
from glmref.views.show import show
from glmref.views.tables import Style
from tests.build import refused


def heun() -> glmref.GLM:
    return glmref.from_rk(np.array([[0, 0], [1.0, 0]]), [0.5, 0.5], name="heun")


# --- given ----------------------------------------------------------------------------------------


def test_arrays_nested_floats_and_families_make_the_same_method() -> None:
    one = np.ones((1, 1))
    arrays = glmref.GLM(
        A=np.array([[0, 0], [1, 0]]), U=np.ones((2, 1)), B=np.full((1, 2), 0.5), V=one
    )
    floats = glmref.GLM(A=[[0.0, 0.0], [1.0, 0.0]], U=[[1.0], [1.0]], B=[[0.5, 0.5]], V=[[1.0]])
    mixed = glmref.GLM(
        A=[[0, 0], [np.int64(1), 0]], U=[[1], [1]], B=[["1/2", np.float64(0.5)]], V=[[1]]
    )
    for method in (arrays, floats, mixed):
        assert (method.A, method.B) == (heun().A, heun().B)
        assert method.is_exact and glmref.analyze(method).order == 2


def test_a_rounded_tableau_is_told_from_an_exact_one() -> None:
    third = 1 / 3
    with pytest.warns(UserWarning, match="where 2/3 is meant, give the string '2/3'") as seen:
        method = glmref.from_rk([[0, 0], [2 * third, 0]], [0.25, 0.75])
    assert seen[0].filename == __file__
    facts = glmref.analyze(method)
    assert facts.order == 2 and "order 2 to" in facts.order_witness
    assert facts.order_proved == [1, 2] and facts.order_to_digits == "5.0e-17"
    assert glmref.analyze(glmref.from_rk([["0", "0"], ["2/3", "0"]], ["1/4", "3/4"])).order == 2


def test_the_trapezoidal_rule_is_symmetric_however_it_is_written() -> None:
    stages = glmref.from_rk([[0, 0], ["1/2", "1/2"]], ["1/2", "1/2"])
    assert glmref.analyze(stages).symmetric["holds"]
    steps = glmref.from_lmm([-1, 1], ["1/2", "1/2"])
    milne = glmref.load("milne-simpson")
    for method in (steps, milne):
        found = glmref.analyze(method).symmetric
        assert (found["holds"], found["reduced"]) == (False, True)
        assert "alpha_m = -alpha_(k-m)" in found["why"]
        rows = dict(analysis_rows(glmref.analyze(method).as_json()))
        assert rows["symmetric"].startswith("yes (in reduced form): ")
        assert "symmetric L" not in rows
    for method in (glmref.load("ab-2"), glmref.load("bdf-2")):
        assert glmref.analyze(method).symmetric["reduced"] is False


@pytest.mark.slow
def test_a_splitting_with_a_stroke_of_length_0_is_symmetric_in_reduced_form():
    """The usual way to write Störmer-Verlet made "symmetric no" of it."""
    for a, b, first in (("1 1", "2 0", None), ("2 0", "1 1", "p"), ("3 2 2 3", "4 2 4 0", None)):
        rows = [[f"{x}/{sum(map(int, v.split()))}" for x in v.split()] for v in (a, b)]
        found = glmref.analyze(
            glmref.from_splitting(*rows, **({"first": first} if first else {}))
        ).symmetric
        assert (found["holds"], found["reduced"]) == (False, True)
    found = glmref.analyze(glmref.from_splitting(["1", "0"], ["1", "0"])).symmetric
    assert (found["holds"], found["reduced"]) == (False, False)


def test_zero_printed_with_digits_is_zero(tmp_path: Path) -> None:
    assert parse("0.000", digits=3) == 0 and isinstance(parse("0.000", digits=3), Exact)
    assert not isinstance(parse("0.001", digits=3), Exact)
    path = tmp_path / "mine.json"
    decimals = {"digits": 3, "A": [["0.000", "0.000"], ["1.000", "0.000"]], "b": ["0.500", "0.500"]}
    path.write_text(json.dumps(decimals), encoding="utf-8")
    assert glmref.analyze(path).explicit


# --- names, files, objects --------------------------------------------------------------------------


@pytest.mark.slow
def test_every_function_takes_names_files_and_objects(tmp_path: Path) -> None:
    file = glmref.load("rk4").save(tmp_path / "mine.json")
    for given in ("rk4", file, str(file), glmref.load("rk4")):
        assert {str(f.verdict) for f in glmref.verify(given)} == {"holds"}
        assert glmref.analyze(given).order == 4
        assert "1/6" in glmref.show(given)
        assert glmref.plot(given).startswith("<svg")
        assert "kutta" in glmref.cite(given).lower()
        assert "step" in glmref.export(given, to="c")
        assert glmref.solve("kepler", given, h=0.1, steps=2).completed
    for function in (glmref.verify, glmref.analyze, glmref.show, glmref.plot, glmref.cite):
        refused(UsageError, "a method, its name or its file, got int", function, 3)
        refused(UsageError, "did you mean rk4", function, "rk44")
    refused(UsageError, "did you mean order", glmref.verify, "rk4", only=["ordre"])
    refused(DataError, "no source to cite", glmref.cite, heun())


# --- saved ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["rk4", "gauss-2", "g6245-w3", "ab-2", "pair-4-4", "stormer-verlet"]
)
def test_save_and_load_give_the_method_back(name: str, tmp_path: Path) -> None:
    method = glmref.load(name)
    again = glmref.load(method.save(tmp_path / "again.json"))
    assert again.document == method.document
    doubled = method.transform([[2 * (i == j) for j in range(method.r)] for i in range(method.r)])
    again = glmref.load(doubled.save(tmp_path / "doubled.json"))
    assert type(again) is type(doubled) and again.claims.keys() == doubled.claims.keys()
    for one, other in zip(again.components, doubled.components, strict=True):
        for M, N in zip(one.matrices, other.matrices, strict=True):
            assert np.array_equal(float_arrays(M), float_arrays(N))


def test_save_writes_what_the_method_is_and_not_what_its_file_was(tmp_path: Path) -> None:
    from dataclasses import replace

    changed = replace(glmref.load("rk4"), A=heun_like())
    again = glmref.load(changed.save(tmp_path / "changed.json"))
    assert again.A == changed.A != glmref.load("rk4").A
    refused(UsageError, r"mine\.json", heun().save, tmp_path / "missing" / "mine.json")


def heun_like() -> list[list[float]]:
    return [[0.0] * 4, [1.0, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1.0, 0]]


# --- shown ------------------------------------------------------------------------------------------


def test_a_repr_is_one_line_and_a_notebook_shows_the_tableau() -> None:
    solution = glmref.solve("kepler", "rk4", h=0.1, steps=20, every=1)
    facts = glmref.analyze("rk4")
    for record in (glmref.load("rk4"), glmref.load("pair-4-4"), facts, solution, solution.plot()):
        assert "\n" not in repr(record) and len(repr(record)) < 100
    assert repr(glmref.load("rk4")) == "<GLM rk4: s = 4, r = 1>"
    for record, said in (
        (glmref.load("rk4"), "<mfrac><mrow><mn>1</mn></mrow><mrow><mn>6</mn></mrow></mfrac>"),
        (facts, "<th>order</th><td>4</td>"),
        (solution, "<svg"),
    ):
        assert said in record._repr_html_()
    assert "<svg" not in glmref.solve("kepler", "rk4", h=0.1, steps=2)._repr_html_()
    assert "max-width:100%" in solution.plot()._repr_svg_()  # not cut off in a narrow window
    assert repr(glmref.show("rk4")) == str(glmref.show("rk4"))  # as it stands


def test_a_solution_is_drawn_and_saved(tmp_path: Path) -> None:
    solution = glmref.solve("kepler", "rk4", h=0.1, steps=20, every=1)
    drawn = solution.plot(components=[0, 3])
    assert drawn.count("<polyline") == 2 and ">p[1]<" in drawn
    path = drawn.save(tmp_path / "run.svg")
    saved = path.read_text(encoding="utf-8")  # with a style for the dark mode of the desktop
    assert saved.replace(DARK, "") == drawn and "prefers-color-scheme: dark" in saved
    refused(UsageError, r"such as run\.svg", drawn.save, tmp_path / "run.png")
    refused(UsageError, "whole number from 0 to 3", solution.plot, components=[4])
    refused(UsageError, "one point", glmref.solve("kepler", "rk4", h=0.1, steps=2).plot)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("width", [60, 80, 100, 140])
@pytest.mark.parametrize("name", ["g6245-w3", "rk4", "pair-rkn-6-8b", "gauss-3"])
def test_show_wraps_at_the_width_of_the_terminal(name: str, width: int) -> None:
    text = show(name, style=Style(unicode=True, width=width))
    assert max(map(len, text.split("\n"))) <= width
    assert show(name, style=Style(width=100000)).count("columns") == 0


def test_columns_that_are_wrapped_are_all_there() -> None:
    method = glmref.load("g6245-w3")
    narrow, wide = (show(method, decimal=6, style=Style(width=w)) for w in (60, 10000))

    def numbers(text: str) -> list[str]:
        body = text.split("\n\n")[1]
        return sorted(
            x
            for line in body.split("\n")
            if " of " not in line
            for x in line.split()
            if x[-1].isdigit()
        )

    assert numbers(narrow) == numbers(wide)
    assert "columns 1 to " in narrow


# --- analyzed -----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_analyze_tells_stability_and_error_constants(cli) -> None:
    out = cli("analyze", "rk4").out
    for line in (
        "A-stable  no",
        "L-stable  no",
        "implicit stages  none",
        "order proved  exactly 4",
        "real stability interval  [-2.78529356341, 0]",
        "imaginary stability interval  [-2.82842712475 i, 2.82842712475 i]",
        "periodicity interval  none",
        "error constant  0.0145046, norm of residual / symmetry",
    ):
        assert " ".join(line.split()) in " ".join(out.split())
    facts = glmref.analyze("ab-4")
    assert facts.quadrature_constant == pytest.approx(251 / 720)  # Hairer, Norsett, Wanner, III.2
    assert glmref.analyze("gauss-2").stability["A"] is True
    assert glmref.analyze("stormer-verlet").stability == {"periodicity": pytest.approx(2)}
    assert glmref.analyze("pair-rkn-6-8b").order_nystrom == 6
    # the end is known to lie in [0, 1/64] only: neither a length nor that there is none
    assert glmref.analyze("pair-6-7").stability["periodicity"] is None


def test_analyze_names_the_row_that_is_not_consistent(cli, tmp_path: Path) -> None:
    path = tmp_path / "off.json"
    path.write_text(json.dumps({"A": [["0"]], "b": ["9/10"]}), encoding="utf-8")
    out = " ".join(cli("analyze", path).out.split())
    assert "row 1 is off by -0.1" in out and "the others" not in out  # there are none
    two = glmref.GLM(A=[[0]], U=[[1, 0]], B=[[1], [2]], V=[[1, 0], [0, 1]])
    assert "row 2 is off" not in glmref.analyze(two).consistency_witness  # u is chosen for it
    three = glmref.GLM(A=[[0]], U=[[1, 0]], B=[[1], [2]], V=[["1", "0"], ["1", "0"]])
    assert glmref.analyze(three).consistency_witness == ""  # v takes it up


def test_an_additive_method_is_shown_saved_and_refused_in_one_sentence(tmp_path: Path) -> None:
    method = glmref.load("ars-2-2-2")
    assert isinstance(method, glmref.method.AdditiveGLM)
    assert repr(method) == "<AdditiveGLM ars-2-2-2: k = 2, s = 3, r = 1>"
    assert "<msqrt>" in method._repr_html_()
    mine = glmref.method.AdditiveGLM(A=method.A, B=method.B, name="mine")
    again = glmref.load(mine.save(tmp_path / "mine.json"))
    assert isinstance(again, glmref.method.AdditiveGLM) and again.A == method.A
    refused(UsageError, "no stability region of one variable", glmref.plot, method)
    refused(UsageError, "export its parts", glmref.export, method, to="c")
    assert "step" in glmref.export(method.part(1), to="c")


@pytest.mark.parametrize("entry", [0.1, 0.25, 2**0.5, 1e-20, 1e300])
def test_a_number_that_is_meant_as_it_is_is_taken_without_a_word(entry: float) -> None:
    glmref.from_rk(A=[[entry]], b=[1])


def test_a_method_that_is_not_zero_stable_is_run_with_a_notice() -> None:
    unstable = glmref.from_lmm(alpha=[-5, 4, 1], beta=[2, 4, 0], name="dahlquist")
    (notice,) = glmref.solve("kepler", unstable, h=0.01, steps=10).notices
    assert "not zero-stable" in notice and "size 5," in notice
    assert glmref.solve("kepler", "ab-4", h=0.01, steps=10).notices == ()


def test_an_embedded_row_is_given_to_a_runge_kutta_method() -> None:
    A = np.array([[0, 0], [1.0, 0]])
    for given in ((1, 0), np.array([1.0, 0]), {"euler": ["1", "0"]}):
        method = glmref.from_rk(A, [0.5, 0.5], embedded=given)
        (name,) = glmref.analyze(method).order_embedded or {}
        assert glmref.analyze(method).order_embedded == {name: 1}
        assert name == ("euler" if isinstance(given, dict) else "embedded")
    refused(DataError, "must have s = 2", glmref.from_rk, A, [0.5, 0.5], embedded=[1])


@pytest.mark.parametrize(
    ("alpha", "beta"),
    [(["1", "-4/3", "1/3"], ["2/3", 0, 0]), ([1, "-18/11", "9/11", "-2/11"], ["6/11", 0, 0, 0])],
)
def test_descending_coefficients_of_a_multistep_method_are_refused(alpha: Any, beta: Any) -> None:
    """BDF with two and three steps as many books print them: once silently of order 0."""
    refused(DataError, "in reversed order only", glmref.from_lmm, alpha, beta)
    assert glmref.analyze(glmref.from_lmm(alpha[::-1], beta[::-1])).order == len(alpha) - 1
