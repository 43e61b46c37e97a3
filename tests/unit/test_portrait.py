"""The picture of a method shows what is there: the region's size, its axis, the tableau's zeros."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

import glmref
from glmref.catalogue.lookup import load
from glmref.cli import main
from glmref.system.shown import DARK
from glmref.views.portrait import portrait

SVG = "{http://www.w3.org/2000/svg}"


def squares(text: str) -> list[str]:
    """Colours of the squares of the sparsity pattern."""
    root = ElementTree.fromstring(text)
    return [
        fill
        for rect in root.iter(f"{SVG}rect")
        if (fill := rect.get("fill", "")) in ("#0072b2", "#d55e00")
    ]


@pytest.mark.slow
def test_the_interval_on_the_axis_is_that_of_the_method() -> None:
    # Hairer, Wanner (1996), section IV.2: 2 sqrt 2 = 2.828 for the four-stage methods of order 4
    assert "growth below 1e-7 up to 2.828" in portrait(load("rk4"))
    assert "growth below 1e-7 throughout" in portrait(load("gauss-2"))
    assert "growth below 1e-7 up to 2<" in portrait(load("stormer-verlet"))


@pytest.mark.slow
def test_a_square_stands_for_each_entry_that_is_not_zero() -> None:
    # rk4: 3 in A, 4 in U, 4 in B, 1 in V; nothing on or above the diagonal of A
    assert squares(portrait(load("rk4"))) == ["#0072b2"] * 12
    method = load("g6245-w3")
    entries = [
        x for block in (method.A, method.U, method.B, method.V) for row in block for x in row
    ]
    drawn = squares(portrait(method))
    assert len(drawn) == sum(not x.is_zero() for x in entries)
    assert drawn.count("#d55e00") == len(method.implicit_stages) == 3


@pytest.mark.slow
def test_a_symplectic_method_has_no_area_and_an_explicit_one_has() -> None:
    filled = re.compile(r'<path d="M[^"]*z" fill="#9ecae9"')
    assert filled.search(portrait(load("rk4")))
    assert not filled.search(portrait(load("gsymplectic-n")))


@pytest.mark.slow
def test_the_command_writes_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "it.svg"
    assert main(["show", "rk4", "--plot", str(target)]) == 0
    assert target.read_text(encoding="utf-8").replace(DARK, "") == portrait(load("rk4"))
    assert main(["show", "rk4", "--plot", str(tmp_path / "it.png")]) == 2
    assert "give a name such as it.svg" in capsys.readouterr().err
    assert main(["show", "rk4", "--plot", str(tmp_path / "no" / "it.svg")]) == 2


def test_axes_of_a_portrait_are_labelled() -> None:
    text = str(glmref.plot("rk4"))
    assert text.count(">Re z</text>") == 1 and text.count(">Im z</text>") == 2
    assert ">|w|</text>" in text
    assert ">h omega</text>" in str(glmref.plot("stormer-verlet"))


def test_a_notebook_shows_the_formulas_of_a_problem() -> None:
    own = glmref.Problem.from_hamiltonian("p**2/2 - cos(q)", {"q": 1, "p": 0}, name="my <pendulum>")
    shown = own._repr_html_()
    assert "my &lt;pendulum&gt;" in shown and "-sin(q[0])" in shown and "second order" in shown
