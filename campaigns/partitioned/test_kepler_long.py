"""Ten million steps of Kepler's problem: the labels of the files and what pages recommend."""

import re
from pathlib import Path

import pytest

from campaigns.long_survey import advice, also
from campaigns.pages import measured
from campaigns.partitioned.tables import PAIRS, RECOMMENDED
from glmref.catalogue.lookup import document, load, names
from glmref.derive.recipes.sources import (
    GROWS_LATER_ON_KEPLER,
    GROWS_ON_KEPLER,
    grown,
    kepler_notes,
)

ROOT = Path(__file__).resolve().parents[2]
CHOOSE = ROOT / "docs" / "choose.md"
PAGE, ORDER6 = (ROOT / "campaigns" / x / "README.md" for x in ("partitioned", "order6"))
LIMIT = "100,000 steps"


def changed(method, eccentricity, key="runs", **values):
    """Return the record with one run changed."""
    other = measured("kepler-long")
    found = [x for x in other[key] if (x["method"], x["eccentricity"]) == (method, eccentricity)]
    assert len(found) == 1
    found[0].update(values)
    return other


def bounded(runs):
    """Return the methods all of whose runs are bounded."""
    return [x for x in dict.fromkeys(r["method"] for r in runs) if x not in grown(runs)]


def expected_labels(stored):
    found = {}
    for text, key in ((GROWS_ON_KEPLER, "runs"), (GROWS_LATER_ON_KEPLER, "further")):
        for name, where in grown(stored[key]).items():
            found.setdefault(name, []).append(text.format(where))
    return found


@pytest.mark.slow
def test_a_file_is_labelled_exactly_where_a_run_is_not_bounded():
    assert labels("kepler-long.json") == expected_labels(measured("kepler-long"))
    found = labels("kepler-long.json")
    assert {name: kepler_notes(name) for name in found} == found  # what recipes write
    assert kepler_notes("gauss-3") == []


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("method", "eccentricity", "values"),
    [
        ("pair-6-10", "0.3", {"bounded": False}),  # would grow, no note
        ("pair-6-9", "0.6", {"bounded": True}),  # a note, would not grow
        ("pair-rkn-6-7b", "0.3", {"energy": [1e-9, 1e-9, 1e-9, 0.5]}),  # would be lost
    ],
)
def test_a_label_that_differs_from_the_data_is_seen(method, eccentricity, values):
    assert labels("kepler-long.json") != expected_labels(changed(method, eccentricity, **values))


def labels(record):
    """Return notes of the method files that name a record, by method."""
    found = {}
    for name in names("methods"):
        notes = document(name).get("notes", [])
        for note in [notes] if isinstance(notes, str) else notes:
            if record in note:
                found.setdefault(name, []).append(note)
    return found


def words(path):
    """Return the text of a page, wherever its lines break."""
    return " ".join(path.read_text(encoding="utf-8").split())


def named(path, before, after):
    """Return the methods between two phrases of a page, in order."""
    found = re.search(rf"{before}(.*?){after}", words(path))
    assert found is not None, f"{path.name} lacks a sentence between {before!r} and {after!r}"
    return re.findall(r"`([^`]+)`", found[1])


def recommended(stored):
    """Return the methods with one value whose runs, the longer ones too, are all bounded."""
    safe = bounded(stored["runs"])
    longer = {x["method"] for x in stored["further"]} - set(bounded(stored["further"]))
    return sorted(x for x in safe if load(x).r == 1 and x not in longer)


def steady_pairs(stored):
    """Return pairs bounded on Kepler's problem; of these, those bounded in all long runs."""
    every = PAIRS
    pairs = [x for x in bounded(stored["runs"]) if x in every]
    starts = measured("pairs-starts")
    others = measured("pairs-long")["runs"] + starts["runs"] + starts["further"]
    own = starts["runs"] + starts["further"] + stored["further"]
    unsteady = {x["method"] for x in own if not x["bounded"]}
    assert {x["method"] for x in others} >= set(pairs)
    return pairs, [x for x in pairs if x not in unsteady]


@pytest.mark.slow
def test_what_is_recommended_for_long_runs_survived_all_of_them():
    stored = measured("kepler-long")
    page = named(CHOOSE, f"Recommended for more than {LIMIT}:", r"They carry one value")
    assert sorted(page) == recommended(stored)
    pairs, all_problems = steady_pairs(stored)
    found = named(CHOOSE, "Of the explicit pairs", "stayed bounded on Kepler")
    assert sorted(found) == sorted(pairs)
    assert all_problems == []
    assert "No pair is recommended for more than 100,000 steps." in words(CHOOSE)
    assert "No pair is bounded over a hundred million steps on all problems" in words(PAGE)


@pytest.mark.slow
def test_a_pair_that_stayed_bounded_everywhere_would_be_named():
    stored = measured("kepler-long")
    for x in stored["further"]:
        x["bounded"] = True
    assert steady_pairs(stored)[1] == ["pair-6-10"]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("method", "key"),
    [("kahan-li-8", "runs"), ("gauss-3", "further"), ("blanes-moan-rkn-6-14", "runs")],
)
def test_other_data_would_recommend_others(method, key):
    assert recommended(changed(method, "0.1", key, bounded=False)) != recommended(
        measured("kepler-long")
    )


def test_no_page_recommends_a_growing_method_without_a_limit():
    """Each method of the table that grows in some run stands with a limit that it survived."""
    stored = measured("kepler-long")
    grows = grown(stored["runs"])
    limited = set()
    for row in [*advice().splitlines()[2:], *also().splitlines()]:
        take, _, more = row.partition(". ")
        named = re.findall(rf"`([^`]+)`( \(up to {LIMIT}\))?", take)
        named += [
            x[::-1]
            for x in re.findall(rf"(for up to {LIMIT} )?also (?:take )?`([^`]+)`", more, re.I)
        ]
        assert not {name for name, limit in named if not limit} & set(grows), row
        limited |= {name for name, limit in named if limit}
    assert limited == set(RECOMMENDED)
    for x in stored["runs"]:
        if x["method"] in limited:
            assert x["energy"][x["marks"].index(100_000)] < 1e-6, x


@pytest.mark.slow
def test_the_counts_of_the_pages_are_those_of_the_data():
    stored = measured("kepler-long")
    texts, pairs = grown(stored["runs"]), PAIRS
    grows = [x for x in pairs if x in texts]
    lost = [x for x in grows if "lost" in texts[x]]
    page = words(PAGE)
    assert (len(grows), len(pairs), len(lost)) == (11, 14, 8)
    assert "Eleven of the fourteen pairs grow in at least one of these runs, and eight lose" in page
    several = {
        x["method"] for x in stored["runs"] if x["method"] not in pairs and load(x["method"]).r > 1
    }
    kept = several - texts.keys()
    assert (len(several), kept) == (22, {"s3z", "s5z-w3"})
    assert all("lost at 0.1" in texts[x] for x in several - kept)
    stalled = {
        x["method"]
        for x in stored["runs"]
        if x["method"] in several and x["eccentricity"] == "0.1" and x["outcome"] != "completed"
    }
    said = (
        "at eccentricity 0.1 each other loses the orbit, or its stage equations can no longer be "
        "solved"
    )
    assert set(named(CHOOSE, said, r"\)")) == stalled
    early = {
        x["method"]
        for x in stored["runs"]
        if x["method"] in several and not x["energy"][x["marks"].index(100_000)] < 1e-5
    }
    assert set(named(ORDER6, "the energy error of all but", "stays below 1e-5")) == early


def test_new_starts_keep_every_run_bounded_but_those_the_page_names():
    stored = measured("kepler-long")
    runs = stored["restarted"]
    assert bounded(runs) == list(dict.fromkeys(x["method"] for x in runs))
    assert not set(bounded(stored["runs"])) & {x["method"] for x in runs} - {"pair-6-10"}
