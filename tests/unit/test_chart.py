"""Charts: every drawn name is there, labels do not overlap, odd numbers do no harm."""

import xml.etree.ElementTree as ElementTree
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.views.axes import log_ticks
from glmref.views.chart import Series, place_labels, svg, text, write_figures

SVG = "{http://www.w3.org/2000/svg}"
WORDS = {"x_label": "seconds", "y_label": "relative error"}
LINES = [
    Series("first", ((1e-3, 1e-4), (2e-3, 1e-6), (4e-3, 1e-8)), ("h = 1", "h = 0.5", "h = 0.25")),
    Series("second", ((1e-3, 2e-4), (2e-3, 2e-6))),
]


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


@pytest.mark.slow
def test_png_and_pdf_are_written_or_the_missing_extra_is_named(tmp_path):
    path = tmp_path / "chart.png"
    notice = write_figures(path, LINES, title="a title", **WORDS)
    if notice is None:
        assert path.read_bytes().startswith(b"\x89PNG")
        printed = path.with_suffix(".pdf").read_bytes()
        assert printed.startswith(b"%PDF")
        assert write_figures(path, LINES, title="a title", **WORDS) is None
        assert path.with_suffix(".pdf").read_bytes() == printed
    else:
        assert "glmref[plots]" in notice
        assert not path.exists()


@pytest.mark.slow
def test_the_limit_of_a_method_has_its_colour_beside_one_that_only_failed(tmp_path, monkeypatch):
    """Behind a method without a point, PNG and PDF drew limits in the colour of the next one."""
    pytest.importorskip("matplotlib")
    figures = []
    monkeypatch.setattr(
        "glmref.views.chart.save_figure", lambda figure, path: figures.append(figure)
    )
    lines = [
        Series("lost", (), failures=((1.0, "not finite"),)),
        Series("rk4", ((0.1, 1e-6),), limit=0.2),
    ]
    write_figures(tmp_path / "chart.png", lines, title="a title", **WORDS)
    colours = {line.get_label(): line.get_color() for line in figures[0].axes[0].lines}
    limit = next(x for x in figures[0].axes[0].lines if x.get_linestyle() == ":")
    assert limit.get_color() == colours["rk4"] != colours["lost (fails)"]
