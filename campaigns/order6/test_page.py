"""The tables and the sentences of the pages about order 6 and 8 are those of the data."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import pytest

from campaigns.order6 import tables
from campaigns.order6.tables import BASE, PAGES, SMALL_MATRICES, fastest, measured
from campaigns.pages import filled
from glmref.catalogue.advice import ADVICE

README, SHORT = PAGES
TABLES = [(page, name) for page, names in PAGES.items() for name in names]


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def other(found: Any) -> Any:
    """Return the record with every number that is not whole a tenth larger."""
    if isinstance(found, dict):
        return {key: other(x) for key, x in found.items()}
    if isinstance(found, list):
        return [other(x) for x in found]
    return 1.1 * found if isinstance(found, float) else found


@pytest.mark.parametrize(("page", "name"), TABLES)
def test_other_data_give_another_table(
    page: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def changed(record: str) -> dict[str, Any]:
        found = copy.deepcopy(measured(record))
        if record == "order6":  # times stand beside those of the base, which stay
            for track in (t for case in found["cases"] for t in case["tracks"]):
                if track["method"] != BASE:
                    track["at"] = other(track["at"])
            return found
        new: dict[str, Any] = other(found)
        return new

    monkeypatch.setattr(tables, "measured", changed)
    assert filled(text(page), {name: PAGES[page][name]}) != text(page)


def test_every_method_of_order_6_and_8_is_in_every_table() -> None:
    names = {m["name"] for m in measured("order6-methods")["methods"] if m["values"] > 1}
    assert len(names) >= 18
    assert names == {r["method"] for r in measured("long-runs")["runs"]}
    for case in measured("order6")["cases"]:
        orbit = case["case"] in ("kepler-0.6", "henon-heiles")
        compared = {t["method"] for t in case["tracks"]}
        assert BASE in compared
        assert names <= compared if orbit else len(names & compared) >= 6


@pytest.mark.parametrize(
    "name", ["order6", "order6-methods", "long-runs", "starts", "order8-search"]
)
def test_a_measurement_says_how_it_is_made_again(name: str) -> None:
    record = measured(name)
    assert record["format"] == "glmref-measurement-1"
    assert record["name"] == name
    assert record["how"].startswith("python -m campaigns.")
    command, _, commit = record["how"].partition(", in commit ")
    assert f"`{command}`" + (f", in commit `{commit}`" if commit else "") in text(README)


def shares(case: str) -> dict[str, list[float]]:
    """Return the time of the methods with small matrices by that of Gauss, by Newton's method."""
    (found,) = (x for x in measured("order6")["cases"] if x["case"] == case)
    best = [fastest(found, target, "newton") for target in tables.TARGETS]
    return {
        name: [x[name]["seconds"] / x[BASE]["seconds"] for x in best] for name in SMALL_MATRICES
    }


def test_the_first_sentences_are_those_of_the_data() -> None:
    first = " ".join(text(SHORT).split("<!-- table")[0].split())
    assert set(re.findall(r"`([^`]+)`", first)) == {"gauss-4", "s3z", "s5z-w3", *SMALL_MATRICES}
    assert "`s5i1-w3` takes about 0.7 and `s5i2-w3` 0.9 of the time of Gauss" in first
    assert "they take 1.0 to 1.3 times its time" in first
    chain, stiff = shares("nonseparable-chain-40"), shares("fput-stiff-80")
    assert {f"{x:.1f}" for x in chain["s5i1-w3"]} == {"0.7"}
    assert {f"{x:.1f}" for x in chain["s5i2-w3"]} == {"0.9"}
    ends = [x for found in stiff.values() for x in found]
    assert (f"{min(ends):.1f}", f"{max(ends):.1f}") == ("1.0", "1.3")
    (advice,) = (x for x in ADVICE if "stages that require Newton's method" in x.need)
    assert set(re.findall(r"`(s5[^`]+)`", advice.more)) == set(SMALL_MATRICES)


def test_a_gauss_method_is_the_fastest_on_both_orbits() -> None:
    for case in measured("order6")["cases"][:2]:
        for target in tables.TARGETS:
            best = fastest(case, target, "")
            quickest = min(best, key=lambda name: best[name]["seconds"])
            assert quickest.startswith("gauss-")
