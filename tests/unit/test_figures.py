"""PNG and PDF are the SVG picture: each shape has its colour where it stands, and nowhere else."""

from pathlib import Path

import pytest

from glmref.views import figures
from glmref.views.axes import document
from glmref.views.figures import write_figures

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
