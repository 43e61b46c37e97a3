"""Charts: every drawn name is there, labels do not overlap, odd numbers do no harm."""

import xml.etree.ElementTree as ElementTree
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from glmref.views.axes import log_ticks
from glmref.views.chart import Series, place_labels, svg, text

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
