"""Charts: every drawn name is there, labels do not overlap, odd numbers do no harm."""

import math
import xml.etree.ElementTree as ElementTree
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.views.axes import decades, log_ticks, tick_texts
from glmref.views.chart import Series, place_labels, svg, text, write_figures

SVG = "{http://www.w3.org/2000/svg}"
WORDS = {"x_label": "seconds", "y_label": "relative error"}
LINES = [
    Series("first", ((1e-3, 1e-4), (2e-3, 1e-6), (4e-3, 1e-8)), ("h = 1", "h = 0.5", "h = 0.25")),
    Series("second", ((1e-3, 2e-4), (2e-3, 2e-6))),
]


def drawn(series, title="a title"):
    return ElementTree.fromstring(svg(series, title=title, **WORDS))


def texts(root):
    return [element.text for element in root.iter(f"{SVG}text")]


def test_title_axes_and_names_are_written():
    found = texts(drawn(LINES))
    for word in ("a title", "seconds", "relative error", "first", "second"):
        assert word in found


def test_every_point_has_a_marker_with_its_values_and_note():
    titles = [e.text for e in drawn(LINES).iter(f"{SVG}title")]
    assert "first: 0.002, 1e-06; h = 0.5" in titles
    assert len(titles) == 1 + 5


def test_a_curve_of_many_points_has_few_markers():
    line = Series("long", tuple((1.0 + k, 1e-9 + k) for k in range(1000)))
    assert len(list(drawn([line]).iter(f"{SVG}g"))) < 40


def test_ten_series_differ_in_marker_or_dash_or_colour():
    many = [Series(f"m{k}", ((1.0, 10.0**-k), (2.0, 10.0 ** -(k + 1)))) for k in range(40)]
    root = drawn(many)
    lines = [e for e in root.iter(f"{SVG}polyline") if e.get("stroke-width") == "1.6"]
    shapes = [next(iter(g)).tag + str(len(next(iter(g)).attrib)) for g in root.iter(f"{SVG}g")]
    looks = {
        (line.get("stroke"), line.get("stroke-dasharray"), shape)
        for line, shape in zip(lines, shapes[::2], strict=True)
    }
    assert len({look[:2] for look in looks}) == 35  # seven colours, five dashes
    assert len(looks) == 40


def test_names_never_overlap_and_stay_inside():
    same = [Series(f"method-{k}", ((1.0, 1e-9),)) for k in range(30)]
    root = drawn(same)
    height = float(root.get("height"))
    rows = sorted(
        float(e.get("y")) for e in root.iter(f"{SVG}text") if (e.text or "").startswith("method-")
    )
    assert len(rows) == 30
    assert all(b - a >= 14.9 for a, b in pairwise(rows))
    assert 0 < rows[0] and rows[-1] < height


def test_long_names_lie_inside_the_picture():
    root = drawn([Series("n" * 40, ((1.0, 1.0), (2.0, 3.0)))])
    (label,) = (e for e in root.iter(f"{SVG}text") if (e.text or "").startswith("nn"))
    assert float(label.get("x")) + 6.5 * 40 <= float(root.get("width"))


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


def test_a_series_without_positive_values_is_named_below():
    found = texts(drawn([*LINES, Series("zero", ((1.0, 0.0),)), Series("nan", ((1.0, math.nan),))]))
    assert "not drawn, without a positive value: zero, nan" in found


def test_nothing_at_all_is_said():
    assert "nothing to draw" in texts(drawn([]))
    assert text([], **WORDS) == "nothing to draw"


def test_names_are_escaped():
    root = drawn([Series("<&>\"'", ((1.0, 1.0),))], title='<&>"')
    assert "<&>\"'" in texts(root)
    assert root.get("aria-label") == '<&>"'


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (-9.5, -0.5, [-8, -6, -4, -2]),
        (0.0, 2.2, [0, 1, 2]),
        (-3.0, 3.0, list(range(-3, 4))),
        (-300.0, 0.0, [-266, -228, -190, -152, -114, -76, -38, 0]),
    ],
)
def test_long_ranges_have_powers_of_ten_thinned(low, high, expected):
    assert list(log_ticks(low, high).at) == expected


def test_short_ranges_have_finer_ticks():
    assert log_ticks(math.log10(1.5), math.log10(40)).texts == ("2", "5", "10", "20")
    assert log_ticks(math.log10(1.04e-5), math.log10(3.3e-5)).texts == ("2e-5", "3e-5")


@given(st.floats(-300, 300), st.floats(0.5, 300))
def test_there_are_always_two_ticks_or_more(low, width):
    found = log_ticks(low, low + width).at
    assert len(found) >= 2
    assert all(low - 1e-6 <= t <= low + width + 1e-6 for t in found)


def test_ticks_are_written_in_one_way():
    assert tick_texts([-9.0, -6.0, 0.0, 3.0]) == ["1e-9", "1e-6", "1", "1e3"]
    assert tick_texts([-2.0, 0.0, 2.0]) == ["0.01", "1", "100"]


def test_limits_hold_the_values_and_are_never_equal():
    low, high = decades([5.0])
    assert low < math.log10(5.0) < high
    assert high - low >= 0.5


def test_the_text_chart_shows_each_series_by_its_letter():
    lines = text(LINES, **WORDS, width=40, height=10).splitlines()
    assert lines[0] == "relative error"
    assert lines[-1] == "a first   b second"
    assert lines[-2].strip() == "seconds"
    grid = "".join(line.partition("|")[2] for line in lines)
    assert grid.count("a") == 3 and grid.count("b") == 2
    assert max(map(len, lines)) <= 60


def test_points_of_two_series_on_one_place_become_a_star():
    twice = [Series("x", ((1.0, 1.0),)), Series("y", ((1.0, 1.0),))]
    assert "*" in text(twice, **WORDS)


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
