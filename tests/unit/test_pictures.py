"""Pictures: every drawn name is there, labels do not overlap, axes are equal."""

import re
import xml.etree.ElementTree as ElementTree
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.catalogue.lookup import load
from glmref.cli import main
from glmref.system.shown import DARK
from glmref.views.axes import log_ticks
from glmref.views.chart import Series, place_labels, svg, text
from glmref.views.portrait import portrait

SVG = "{http://www.w3.org/2000/svg}"
WORDS = {"x_label": "seconds", "y_label": "relative error"}


def drawn(series, title="a title"):
    return ElementTree.fromstring(svg(series, title=title, **WORDS))


def test_a_curve_of_many_points_has_few_markers():
    line = Series("long", tuple((1.0 + k, 1e-9 + k) for k in range(1000)))
    assert len(list(drawn([line]).iter(f"{SVG}g"))) < 40


@given(st.lists(st.floats(-200, 900), min_size=1, max_size=25))
def test_labels_are_apart_and_keep_their_order(wanted):
    placed = place_labels(wanted, 46.0, 400.0)
    order = sorted(range(len(wanted)), key=lambda k: wanted[k])
    rows = [placed[k] for k in order]
    assert all(b - a >= 15.0 - 1e-9 for a, b in pairwise(rows))
    assert rows[0] >= 46.0 - 1e-9


@given(
    st.lists(
        st.tuples(
            st.floats(allow_nan=True, allow_infinity=True),
            st.floats(allow_nan=True, allow_infinity=True),
        ),
        max_size=8,
    )
)
def test_any_numbers_give_well_formed_pictures(points):
    line = [Series("any", tuple(points))]
    root = drawn(line)
    assert "nan" not in ElementTree.tostring(root, encoding="unicode").replace("any", "")
    assert text(line, **WORDS)


@given(st.floats(-300, 300), st.floats(0.5, 300))
def test_there_are_always_two_ticks_or_more(low, width):
    found = log_ticks(low, low + width).at
    assert len(found) >= 2
    assert all(low - 1e-6 <= t <= low + width + 1e-6 for t in found)


# -- the picture of a method shows what is there: the region's size, its axis, the tableau's zeros


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
