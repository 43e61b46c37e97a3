"""Pictures: every drawn name is there, labels do not overlap, axes are equal, PNG and PDF are the SVG."""

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
from glmref.views import figures
from glmref.views.axes import document, log_ticks
from glmref.views.chart import Series, place_labels, svg, text
from glmref.views.figures import write_figures
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


# -- pNG and PDF are the SVG picture: each shape has its colour where it stands, and nowhere else


#: Shape of 40 px around (50, 60), and a place in px that is blank beside it.
SHAPES = {
    "a rectangle": ('<rect x="30" y="40" width="40" height="40" fill="#d55e00"/>', (75, 60)),
    "a circle": ('<circle cx="50" cy="60" r="20" fill="#d55e00"/>', (32, 42)),
    "a polygon": ('<polygon points="30,80 70,80 50,40" fill="#d55e00"/>', (35, 45)),
    "a line": (
        '<polyline points="30,40 70,80" fill="none" stroke="#d55e00" stroke-width="4"/>',
        (30, 80),
    ),
    "a cross": ('<path d="M30 60h40M50 40v40" stroke="#d55e00" stroke-width="4"/>', (35, 45)),
    "an upright": ('<path d="M50 40V80" stroke="#d55e00" stroke-width="4"/>', (60, 60)),
    "a stroke": (
        '<path d="M30.0,40.0 L70.0,80.0" fill="none" stroke="#d55e00" stroke-width="4"/>',
        (70, 40),
    ),
    "a region": (
        '<path d="M30,40 70,40 70,80 30,80z" fill="#d55e00" fill-rule="evenodd"/>',
        (75, 60),
    ),
    "dots": (
        '<path d="M50.0 60.0h0M90.0 60.0h0" stroke="#d55e00" stroke-width="8" stroke-linecap="round"/>',
        (70, 60),
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_has_its_colour_where_it_stands(name: str, tmp_path: Path) -> None:
    image = pytest.importorskip("matplotlib.image")
    shape, beside = SHAPES[name]
    assert write_figures(tmp_path / "a.svg", document("", 120, 100, [shape])) is None
    pixels = image.imread(tmp_path / "a.png")
    assert pixels.shape[:2] == (200, 240)  # two to a px

    def at(x: int, y: int) -> list[int]:
        return [round(255 * c) for c in pixels[2 * y, 2 * x, :3]]

    assert at(50, 60) == [0xD5, 0x5E, 0x00]
    assert at(*beside) == [255, 255, 255]


def test_figures_are_the_same_every_time_or_the_missing_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = document("a title", 120, 100, [SHAPES["dots"][0]])
    if write_figures(tmp_path / "one.svg", picture) is None:
        write_figures(tmp_path / "two.svg", picture)
        for kind, head in (("png", b"\x89PNG"), ("pdf", b"%PDF")):
            one, two = ((tmp_path / f"{name}.{kind}").read_bytes() for name in ("one", "two"))
            assert one.startswith(head) and one == two
    monkeypatch.setattr(figures, "import_module", lambda name: __import__(f"no_{name}"))
    assert "glmref[plots]" in (write_figures(tmp_path / "three.svg", picture) or "")
    assert not list(tmp_path.glob("three*"))
