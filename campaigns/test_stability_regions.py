"""Stability regions as polygons: right on known ones, and stored as they are measured."""

import json
import math

import pytest

from campaigns.driver import fingerprint
from campaigns.stability_regions import (
    FAR,
    FORMAT,
    NEARNESS,
    main,
    names_with_region,
    row,
    simplified,
)
from glmref.catalogue.lookup import data_root, load
from glmref.measure.stability import GRID

FILE = data_root() / "measurements" / "stability.json"
STORED = json.loads(FILE.read_text(encoding="utf-8"))
RENEW = f"python -m campaigns.stability_regions data/measurements/{FILE.name}"


def points(text):
    return [tuple(map(float, pair.split(","))) for pair in text.split()]


def distances_to_a_circle(ring, middle, radius):
    return [abs(math.hypot(x - middle, y) - radius) for x, y in ring]


def test_the_region_of_euler_is_a_disc():
    found = row(load("euler"))
    (ring,) = map(points, found["rings"])
    assert ring[0] == ring[-1] and len(ring) > 20
    # vertices are bisected to a cell/2^12 and written to four digits; a side between two of them
    # is within NEARNESS of the boundary where these are on it
    assert max(distances_to_a_circle(ring, -1, 1)) < 1e-3
    sides = zip(ring, ring[1:], strict=False)
    middles = [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in sides]
    assert max(distances_to_a_circle(middles, -1, 1)) < 2 * NEARNESS * found["reach"]
    assert max(distances_to_a_circle(ring, -1.05, 1)) > 0.04  # another disc is not it
    assert (found["imaginary"], found["real"]) == (0.0, 2.0)


@pytest.mark.slow
def test_ends_of_the_stable_axes_are_the_known_ones():
    rk4 = row(load("rk4"))
    assert (rk4["imaginary"], rk4["real"]) == (2.828, 2.785)  # 2 sqrt 2, and the root of R = 1
    gauss = row(load("gauss-2"))
    assert (gauss["imaginary"], gauss["real"]) == (FAR, FAR)
    # the left half of the box, up to half a cell at the axis
    (ring,) = map(points, gauss["rings"])
    assert max(x for x, _ in ring) == pytest.approx(0, abs=gauss["reach"] / GRID)
    assert min(x for x, _ in ring) == -gauss["reach"]


def test_a_g_symplectic_method_has_a_piece_of_the_axis_and_no_area():
    found = row(load("gsymplectic-n"))
    assert found["rings"] == [] and found["real"] == 0.0
    assert found["imaginary"] == pytest.approx(2.06, abs=0.01)


def test_a_pair_has_moduli_and_the_end_of_its_stable_part():
    found = row(load("stormer-verlet"))
    assert found["oscillation"] == 2.0
    curves = [points(text) for text in found["moduli"]]
    inside = [y for curve in curves for x, y in curve if x < 2]
    assert all(y == pytest.approx(1, abs=1e-3) for y in inside)
    assert max(y for curve in curves for _, y in curve) > 1.5


def test_a_line_is_kept_to_the_nearness_that_is_asked_for():
    wave = [(0.01 * k, math.sin(0.01 * k)) for k in range(629)]
    for near, most in ((0.1, 12), (0.001, 80)):
        kept = simplified(wave, near)
        assert kept[0] == wave[0] and kept[-1] == wave[-1] and len(kept) < most
        for x, y in wave:
            (a, b), (c, d) = next(
                (p, q) for p, q in zip(kept, kept[1:], strict=False) if p[0] <= x <= q[0]
            )
            assert abs(b + (d - b) * (x - a) / (c - a) - y) <= 1.5 * near
    assert len(simplified(wave, 0.001)) > len(simplified(wave, 0.1))


def test_every_method_is_stored_for_the_coefficients_as_they_are():
    assert STORED["format"] == FORMAT
    stored = {name: one["fingerprint"] for name, one in STORED["methods"].items()}
    assert stored == {name: fingerprint(name) for name in names_with_region()}, RENEW


SAMPLE = ("euler", "rk4", "bdf-3", "gsymplectic-n", "dimsim-2-type-1", "stormer-verlet", "pair-4-4")


def numbers(found):
    """Return all numbers of a row, in order."""
    texts = [x for value in found.values() if isinstance(value, list) for x in value]
    flat = [value for text in texts for point in points(text) for value in point]
    return [*flat, *(x for x in found.values() if isinstance(x, float))]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", SAMPLE)
def test_what_is_stored_is_what_is_measured(name):
    found, stored = row(load(name)), dict(STORED["methods"][name])
    del stored["fingerprint"]
    # four digits; another processor may round the last one the other way
    assert numbers(found) == pytest.approx(numbers(stored), rel=2e-3, abs=2e-3)
    other = STORED["methods"]["ab-4"]
    assert len(numbers(found)) != len(numbers(other)) or numbers(found) != pytest.approx(
        numbers(other), rel=2e-3, abs=2e-3
    )


def test_only_what_has_changed_is_measured_again(tmp_path, monkeypatch):
    import campaigns.stability_regions as module

    monkeypatch.setattr(module, "names", lambda kind: ["euler", "heun-2"])
    rows = {name: dict(STORED["methods"][name]) for name in ("euler", "heun-2")}
    rows["euler"] |= {"fingerprint": "of another tableau", "rings": []}
    path = tmp_path / "stability.json"
    path.write_text(json.dumps({"methods": rows}), encoding="utf-8")
    assert main(path) == 1 and main(path) == 0
    found = json.loads(path.read_text("utf-8"))["methods"]
    assert found["heun-2"] == STORED["methods"]["heun-2"] and found["euler"]["rings"]
