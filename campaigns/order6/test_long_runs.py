"""What the page recommends for long runs follows from the ten million steps on record."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.lookup import data_root, document

Record = Mapping[str, Any]

LONG_RUNS = json.loads(
    (data_root() / "measurements" / "long-runs.json").read_text(encoding="utf-8")
)
RECORD = LONG_RUNS["runs"]
PAGE = " ".join((Path(__file__).parent / "README.md").read_text(encoding="utf-8").split())
PENDULUM = "pendulum-2.3"
#: What two million steps can tell from no growth: the page says so.
SEEN = 1.5e-6


def recorded(name: str, run: str) -> Record:
    return next(r for r in RECORD if r["method"] == name and r["run"] == run)


def recommended(record: Sequence[Record]) -> list[str]:
    """Return methods without growth by three in any run, whose rate is not seen in any."""
    safe: dict[str, bool] = {}
    for x in record:
        calm = x["bounded"] and x["parasitic"] <= 3 * x["parasitic_early"] and x["rate"] < SEEN
        safe[x["method"]] = safe.get(x["method"], True) and calm
    return [name for name, calm in safe.items() if calm]


def steady(record: Sequence[Record]) -> list[str]:
    """Return methods of order 6 that stay within 15 per cent and grow when nudged."""
    return [
        x["method"]
        for x in record
        if x["run"] == PENDULUM
        and document(x["method"])["claims"]["order"] == 6
        and x["parasitic"] <= 1.15 * x["parasitic_early"]
        and x["rate"] >= SEEN
    ]


def named(before: str, after: str) -> list[str]:
    """Return the methods between two phrases of the page, in order."""
    found = re.search(rf"{before}(.*?){after}", PAGE, re.DOTALL)
    assert found is not None, f"the page lacks a sentence between {before!r} and {after!r}"
    return re.findall(r"`([^`]+)`", found[1])


def test_the_page_recommends_what_the_data_say() -> None:
    assert named("Recommended for long runs on this pendulum:", "whose rate") == recommended(RECORD)
    assert named("Of order 6,", "stayed") == steady(RECORD)
    rates = re.search(r"grows when perturbed \(rates (.*?)\)", PAGE, re.DOTALL)
    assert rates is not None
    said = [float(x) for x in re.findall(r"\d\.\de-\d", rates[1])]
    measured = [recorded(name, PENDULUM)["rate"] for name in steady(RECORD)]
    assert said == pytest.approx(measured, rel=0.05)  # two digits
    assert f"below {SEEN:g}," in PAGE.replace("e-6,", "e-06,")


@pytest.mark.parametrize(
    ("name", "run", "change"),
    [
        ("order8-s5-w3", PENDULUM, {"rate": 2e-6}),
        ("order8-s5-w3", "henon-heiles", {"bounded": False}),
        ("order8-s5-w3", PENDULUM, {"parasitic": 1e-8}),
        ("t115-w3", PENDULUM, {"rate": 1e-6}),
    ],
)
def test_other_data_would_recommend_others(name: str, run: str, change: Record) -> None:
    other = [{**x, **change} if (x["method"], x["run"]) == (name, run) else x for x in RECORD]
    assert recommended(other) != recommended(RECORD)
