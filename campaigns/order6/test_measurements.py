"""Order 6 and 8: tables and sentences of the pages, long runs, notes, and the search for order 8."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from campaigns.order6 import tables
from campaigns.order6.tables import BASE, PAGES, SMALL_MATRICES, fastest
from campaigns.pages import measured
from campaigns.partitioned.test_kepler_long import labels, named, words
from glmref.catalogue.advice import ADVICE
from glmref.catalogue.lookup import document
from glmref.derive.ansatz import Ansatz, Value
from glmref.derive.recipes.sources import GROWS
from glmref.prove.enclosure import conditions_of


def grown(runs: Sequence[Mapping[str, Any]]) -> dict[tuple[str, str], str]:
    """Return (method, run) -> how much the parasitic part grew, where it did."""
    return {
        (x["method"], x["run"]): "threefold" if x["bounded"] else "thirtyfold"
        for x in runs
        if x["parasitic"] > 3 * x["parasitic_early"] or not x["bounded"]
    }


def labelled() -> dict[tuple[str, str], str]:
    """Return (method, run) -> what the notes of the files say."""
    texts = {GROWS.format(word): word for word in ("threefold", "thirtyfold")}
    found = labels("long-runs.json").items()
    return {(name, PENDULUM): texts[note] for name, notes in found for note in notes}


LONG_RUNS = measured("long-runs")
RECORD = LONG_RUNS["runs"]
README, SHORT = PAGES
PENDULUM = "pendulum-2.3"
#: What two million steps can tell from no growth: the page says so.
SEEN = 1.5e-6


def changed(method: str, run: str, change: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the runs with one of them changed."""
    other = [{**x, **change} if (x["method"], x["run"]) == (method, run) else x for x in RECORD]
    assert other != RECORD
    return other


def test_the_rate_of_growth_goes_with_the_square_of_h_and_not_with_the_nudge() -> None:
    """The scan of README.md; that the rates are those of the code, see tests/evidence."""
    scan = LONG_RUNS["scan"]
    rates = {x["h"]: x["rate"] for x in scan if x["nudge"] == LONG_RUNS["nudge"]}
    # exp(c h^2 t + O(h^3) t) with one c: what is left is the sampling of the maxima, which moves
    # the logarithm of 2 or so factors of e by a few thousandths
    c = [rate / h**2 for h, rate in rates.items() if h <= 0.16]
    assert len(c) >= 5 and max(c) < 1.015 * min(c)
    # no other whole power of h: over a factor of 3.2 in h it would spread by that factor
    for power in (1, 3):
        other = [rate / h**power for h, rate in rates.items() if h <= 0.16]
        assert max(other) > 3 * min(other)
    # linear: a nudge a hundred times as large grows alike
    alike = [x["rate"] for x in scan if x["h"] == 0.1]
    assert len(alike) == 3 and max(alike) < 1.01 * min(alike)
    # each run saw its part grow enough for that: more than e in the whole
    assert all(x["rate"] * x["h"] * x["steps"] > 1 for x in scan)


def test_a_file_is_labelled_exactly_where_ten_million_steps_show_growth() -> None:
    assert LONG_RUNS["factor"] == 30
    assert {x["steps"] for x in RECORD if x["outcome"] == "completed"} == {10**7}
    assert labelled() == grown(RECORD)


@pytest.mark.parametrize(
    ("method", "run", "change"),
    [
        ("g6245", PENDULUM, {"parasitic": 3.1 * 3.197e-09}),  # grew, no note
        ("s4-w3", PENDULUM, {"parasitic": 2.9 * 4.8e-09}),  # a note, did not grow
        ("s4-w3", PENDULUM, {"bounded": False}),  # the other note
        ("g6245", "henon-heiles", {"bounded": False}),  # grew where no note speaks of
    ],
)
def test_a_note_that_differs_from_the_data_is_seen(
    method: str, run: str, change: dict[str, Any]
) -> None:
    assert labelled() != grown(changed(method, run, change))


def recommended(record: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return methods without growth by three in any run, whose rate is not seen in any."""
    safe: dict[str, bool] = {}
    for x in record:
        calm = x["bounded"] and x["parasitic"] <= 3 * x["parasitic_early"] and x["rate"] < SEEN
        safe[x["method"]] = safe.get(x["method"], True) and calm
    return [name for name, calm in safe.items() if calm]


def steady(record: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return methods of order 6 that stay within 15 per cent and grow when nudged."""
    return [
        x["method"]
        for x in record
        if x["run"] == PENDULUM
        and document(x["method"])["claims"]["order"] == 6
        and x["parasitic"] <= 1.15 * x["parasitic_early"]
        and x["rate"] >= SEEN
    ]


def test_the_page_recommends_what_the_data_say() -> None:
    assert named(
        README, "Recommended for long runs on this pendulum:", "whose rate"
    ) == recommended(RECORD)
    assert named(README, "Of order 6,", "stayed") == steady(RECORD)
    page = words(README)
    (rates,) = re.findall(r"grows when perturbed \(rates (.*?)\)", page)
    said = [float(x) for x in re.findall(r"\d\.\de-\d", rates)]
    known = {x["method"]: x["rate"] for x in RECORD if x["run"] == PENDULUM}
    assert said == pytest.approx([known[x] for x in steady(RECORD)], rel=0.05)  # two digits
    assert f"below {SEEN:g}," in page.replace("e-6,", "e-06,")


@pytest.mark.parametrize(
    ("name", "run", "change"),
    [
        ("order8-s5-w3", PENDULUM, {"rate": 2e-6}),
        ("order8-s5-w3", "henon-heiles", {"bounded": False}),
        ("order8-s5-w3", PENDULUM, {"parasitic": 1e-8}),
        ("t115-w3", PENDULUM, {"rate": 1e-6}),
    ],
)
def test_other_data_would_recommend_others(name: str, run: str, change: Mapping[str, Any]) -> None:
    assert recommended(changed(name, run, change)) != recommended(RECORD)


def test_the_search_on_record_is_that_of_its_ansatzes() -> None:
    """The ends of the search are stored; what was searched is written out again and counted."""
    record = measured("order8-search")
    assert len(record["ansatzes"]) == 17
    for row in record["ansatzes"]:
        parity = iter(row["parity"])
        pairs = zip(row["eigenvalues"], row["signs"], strict=True)
        values = [Value(x, sign, next(parity) if x == "-1" else 1) for x, sign in pairs]
        options = {key: row[key] for key in ("stage_order", "explicit")}
        found = conditions_of(Ansatz("x", row["stages"], 8, values, **options).document())
        assert row["values"] == len(found.G)
        assert (row["unknowns"], row["conditions"]) == (len(found.unknowns), len(found.equations))
        assert row["starts"] == 128
        assert (row["solved"] > 0) == (row["smallest_residual"] < record["solved_below"])


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


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
