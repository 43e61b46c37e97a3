"""No text of a picture leaves it: the widths of texts, by a bound on the width of a character."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree

import pytest

from glmref.catalogue.lookup import load
from glmref.views import chart, paths
from glmref.views.portrait import portrait

SVG = "{http://www.w3.org/2000/svg}"
#: Width of a character of Helvetica over its size: 0.556 for digits, about 0.5 on average.
WIDE = 0.56


def outside(text: str) -> list[str]:
    """The texts that leave the picture, to the left or to the right."""
    root = ElementTree.fromstring(text)
    width, plain = float(root.get("width", "0")), float(root.get("font-size", "12"))
    found = []
    for label in root.iter(f"{SVG}text"):
        if label.get("x") is None:  # turned
            continue
        words, x = label.text or "", float(label.get("x", "0"))
        long = WIDE * float(label.get("font-size", plain)) * len(words)
        long *= 1.07 if label.get("font-weight") == "bold" else 1
        left = {"end": x - long, "middle": x - long / 2}.get(label.get("text-anchor", ""), x)
        if left < 0 or left + long > width:
            found.append(words)
    return found


@pytest.mark.sampled(1, besides=("g6245",))
@pytest.mark.parametrize(
    "name", ["rk4", "gauss-2", "g6245-w3", "yoshida-4", "kraaijevanger-spijker", "pair-rkn-6-7b"]
)
def test_a_portrait_shows_all_digits_of_its_bound(name: str) -> None:
    text = portrait(load(name))
    assert outside(text) == []
    assert re.search(r">growth below 1e-7 (throughout|up to [0-9.e-]+)<", text)


def test_a_chart_with_long_texts_is_as_wide_as_they_are() -> None:
    series = [chart.Series("a method with a rather long name", ((1.0, 1e-3), (2.0, 1e-5)))]
    lost = [chart.Series(f"method-number-{k}-of-many", ()) for k in range(20)]
    words = {"title": "What is asked " * 12, "x_label": "seconds", "y_label": "error"}
    text = chart.svg([*series, *lost], **words)
    assert outside(text) == []
    assert all(one.name in " ".join(re.findall(r">([^<]*)<", text)) for one in lost)
    usual = ElementTree.fromstring(chart.svg(series, title="t", x_label="x", y_label="y"))
    assert (usual.get("width"), usual.get("height")) == ("820", "460")


def test_the_panels_of_paths_keep_their_texts() -> None:
    clouds = [
        paths.Cloud("triple-jump-6", ((0.02515, 1e-7), (0.02516, 2e-7)), "not finite", 0.02515)
    ]
    assert outside(paths.svg(clouds, title="long " * 30, x_label="q1", y_label="q2")) == []
