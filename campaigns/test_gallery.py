"""The gallery of results and the pictures are those of the records; other records give others."""

import re
from xml.etree import ElementTree

import pytest

from campaigns import gallery, pictures
from campaigns.gallery import CLASSICAL, PAGE, PAGES, TOLERANCES, cheapest, shares
from campaigns.pages import measured
from campaigns.pictures import IMAGES, PICTURES, ROOT
from glmref.catalogue.advice import ADVICE
from glmref.catalogue.files import document
from glmref.system.shown import DARK

TABLES = PAGES[PAGE]
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_shares_are_those_of_the_pages_on_these_systems():
    """Two pages print the same means, each from its own lines of code."""
    general, _ = shares("Hamiltonian", "1e-09")
    kinetic, _ = shares("semi-separable", "1e-09")
    pages = [(ROOT / "docs" / f"{x}.md").read_text("utf-8") for x in ("nonseparable", "velocities")]
    eight, renewed, least = (general[f"multistep-general-{x}"] for x in ("8", "8c", "8b"))
    assert f"need {eight:.2f}, {least:.2f} and {renewed:.2f} of the best Gauss" in pages[0]
    assert f"it needs {general['multistep-strong-8']:.2f} of the evaluations" in pages[0]
    eight, twelve = (kinetic[f"multistep-kinetic-{x}"] for x in ("8", "12"))
    assert (
        f"needs {eight:.2f} and `multistep-kinetic-12` {twelve:.2f} of the best Gauss" in pages[1]
    )


def test_the_sentences_of_the_page_hold():
    said = " ".join(TEXT.split())
    every = [(kind, t, shares(kind, t)[0]) for kind in CLASSICAL for t in TOLERANCES]
    counted = [(kind, t, found) for kind, t, found in every if found]
    least = {(kind, t): cheapest(kind, found) for kind, t, found in counted}
    assert all(x.startswith(("multistep-", "multivalue-")) for x in least.values())
    assert all(found[least[kind, t]] < 1 for kind, t, found in counted)
    runs = [(x["method"], x["bounded"]) for x in measured("multistep-long")["runs"]]
    ends = {
        x: all(end for name, end in runs if name == x) for x in ("multistep-8", "multistep-rkn-8")
    }
    assert set(ends.values()) == {True} and "in every run of ten million steps" in said
    first, second, third = (f"{x:.2f}" for x in gallery.published())
    assert f"their shares are {first}, {second} and {third}" in said
    assert {kind for kind, t, _ in counted if t == "1e-12"} == {"second order", "separable"}
    assert "Twelve digits were not counted on the other systems" in said
    survey = [x for x in measured("long-survey")["rows"] if x["steps"] == 10_000_000]
    failed = {
        x["method"]
        for x in survey
        for r in x["runs"]
        if not r["renew"] and r["verdict"] != "bounded"
    }
    assert not failed & {"multistep-8", "multistep-rkn-8"}
    forms = {x["method"] for x in survey} - failed
    assert {x for x in forms if document(x)["class"] in ("glm", "sweep", "pair-sweep")} == {
        "s3z", "s5z-w3",
    }  # fmt: skip
    kept, of = gallery.lost()
    assert (kept, of) == (2, 22)
    assert "only `s3z` and `s5z-w3` of them stayed bounded in every run" in said
    laws = {(x["method"], x["h"]): x["law"] for x in measured("pendulum-1e8")["runs"]}
    assert laws["gauss-3", 0.1]["kind"] == laws["g6245", 0.05]["kind"] == "bounded"
    assert laws["g6245", 0.1]["kind"] == "blow-up" and laws["g6245", 0.1]["time"] > 1e5


@pytest.mark.slow
def test_the_advised_methods_are_those_of_the_advice():
    rows = [[y.strip() for y in x.strip("|").split("|")] for x in TABLES["explicit"]().split("\n")]
    for one in ADVICE:
        mine = [x for x in rows if x[0] == one.need]
        assert bool(mine) == (one.kind in CLASSICAL)
        for x in mine:
            tolerance = next(key for key, shown in TOLERANCES.items() if shown == x[1])
            found, count = shares(one.kind, tolerance)
            name = one.take[0]
            assert x[5] == (f"`{name}`, {found[name]:.2f}" if name in found else "-")
            assert x[2] == f"`{cheapest(one.kind, found)}`"
            assert int(x[6]) == count and count >= 4


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_drawn_from_its_record(name):
    stored = (IMAGES / f"{name}.svg").read_text(encoding="utf-8")
    assert stored.replace(DARK, "", 1) == PICTURES[name](), "run `python -m campaigns.pictures`"
    root = ElementTree.fromstring(stored)
    assert float(root.attrib["width"]) <= 400  # a phone shows 12 px as 9 px at the least
    sizes = [float(x.attrib.get("font-size", 12)) for x in root.iter() if x.tag.endswith("text")]
    assert min(sizes) * 300 / 400 >= 9


def test_a_table_that_the_audit_does_not_mark_is_not_drawn(monkeypatch):
    monkeypatch.setattr(pictures, "RIGHT", "bpr-3-5-3-petsc")
    with pytest.raises(ValueError, match="not enough values to unpack"):
        pictures.audited()


def test_the_house_has_every_subpackage():
    drawn = set(re.findall(r'middle"[^>]*>(\w+)<', pictures.house()))
    folders = {x.parent.name for x in (ROOT / "glmref").glob("*/__init__.py")}
    assert folders <= drawn


@pytest.mark.slow
def test_parasitic_growth_begins_as_it_is_stored():
    (run, *_) = measured("parasitic-growth")["runs"]
    again = pictures.grown(run["h"], 0.2)
    assert (again["start"], again["rate"]) == pytest.approx((run["start"], run["rate"]), rel=1e-6)
    few = len(again["t"])
    assert few >= 5 and again["size"] == pytest.approx(run["size"][:few], rel=1e-3)


def test_parasitic_growth_is_predicted_within_a_factor_of_three():
    for run in measured("parasitic-growth")["runs"]:
        predicted = [run["start"] * pictures.math.exp(run["rate"] * t) for t in run["t"]]
        ratios = [x / y for x, y in zip(run["size"], predicted, strict=True)]
        assert 1 / 3 < min(ratios) and max(ratios) < 3
        # over a growth by more than four powers of ten
        assert run["size"][-1] > 1e4 * run["size"][0]
