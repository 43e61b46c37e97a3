"""Panels of paths: equal axes, one range, nothing hidden without a word."""

import re
from xml.etree import ElementTree

import pytest

from glmref.views.paths import Cloud, box_of, one_each, svg

CIRCLE = tuple((x / 10, y / 10) for x, y in ((10, 0), (0, 10), (-10, 0), (0, -10)))
WORDS = {"title": "Two & more", "x_label": "q_1", "y_label": "q_2"}


def dots(text):
    """Places of the points, one list a panel."""
    found = re.findall(r'<path d="((?:M[-\d.]+ [-\d.]+h0)+)"', text)
    return [
        [tuple(map(float, one)) for one in re.findall(r"M([-\d.]+) ([-\d.]+)h0", path)]
        for path in found
    ]


def test_the_range_is_that_of_paths_followed_to_their_end():
    lost = Cloud("lost", ((0.0, 0.0), (50.0, 0.0)), "lost after t = 3")
    low, high, down, up = box_of([Cloud("a", CIRCLE), lost])
    assert (low, high, down, up) == pytest.approx((-1.08, 1.08, -1.08, 1.08))
    text = svg([Cloud("a", CIRCLE), lost], **WORDS)
    assert [len(panel) for panel in dots(text)] == [4, 1]
    assert "lost after t = 3; 1 of 2 points outside" in text
    far = Cloud("away", ((0.0, 0.0), (50.0, 0.0)))
    assert box_of([Cloud("a", CIRCLE), Cloud("b", CIRCLE), far])[1] == pytest.approx(1.08)
    assert box_of([Cloud("a", CIRCLE), Cloud("b", ((0.0, 0.0), (5.0, 0.0)))])[1] > 5
    # where none was followed to its end, all of it is shown
    assert box_of([lost])[1] > 50


def test_one_path_a_method_of_the_largest_step_that_holds():
    fine, coarse = Cloud("a", CIRCLE, h=0.1), Cloud("a", CIRCLE, h=0.2)
    lost = Cloud("a", CIRCLE[:1], "lost after t = 1", h=0.4)
    assert one_each([lost, coarse, fine, Cloud("b", ())]) == [coarse, Cloud("b", ())]
    # nowhere followed to its end: at the smallest step
    early = Cloud("a", CIRCLE[:2], "lost after t = 2", h=0.3)
    assert one_each([lost, early]) == [early]
    assert [one.title for one in (coarse, Cloud("b", ()))] == ["a, h = 0.2", "b"]


def test_flat_and_empty_paths_have_a_picture():
    for points in ((), ((3.0, 3.0),), ((0.0, 0.0), (1.0, 0.0))):
        low, high, down, up = box_of([Cloud("a", points)])
        assert high > low and up > down
        ElementTree.fromstring(svg([Cloud("a", points)], **WORDS))
    ElementTree.fromstring(svg([], **WORDS))
