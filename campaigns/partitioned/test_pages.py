"""The tables and the sentences of the pages about pairs are those of the data."""

import copy
import re

import pytest

from campaigns.long_survey import also
from campaigns.partitioned import tables
from campaigns.partitioned.tables import PAGES, RECOMMENDED, measured, shipped_table
from campaigns.partitioned.test_starts import started_pairs

README, SHORT, *_ = PAGES


def text(page):
    return page.read_text(encoding="utf-8")


def test_the_recommended_pairs_are_those_of_the_page_of_choice():
    rows = also().splitlines()
    assert set(re.findall(r"`(pair-[^`]+)`", "".join(rows[:2]))) == set(RECOMMENDED)
    assert set(re.findall(r"\*\*`(pair-[^`]+)`\*\*", text(SHORT))) == set(RECOMMENDED)
    first = text(SHORT).split("## ")[0]
    assert set(re.findall(r"`(pair-[^`]+)`", first)) == set(RECOMMENDED)


def counted(records):
    """Return the numbers of the short page: pairs that grow on Kepler's problem, renewed ones."""
    kepler = records["kepler-long"]
    pairs = {x["method"] for x in records["pairs-long"]["runs"]}
    grow = {x["method"] for x in kepler["runs"] if not x["bounded"]} & pairs
    lost = {
        x["method"] for x in kepler["runs"] if not x["bounded"] and not x["energy"][-1] <= 0.1
    } & pairs
    renewed = {x["method"] for x in kepler["restarted"] if x["bounded"]} & pairs
    return len(pairs), len(grow), len(lost), len(renewed)


@pytest.mark.slow
def test_the_sentences_of_the_short_page_are_those_of_the_data():
    records = {x: measured(x) for x in ("pairs", "pairs-long", "pairs-starts", "kepler-long")}
    page = " ".join(text(SHORT).split())
    assert counted(records) == (14, 11, 8, 6)
    assert "eleven of the fourteen pairs grow, and eight lose the orbit" in page
    assert "the six pairs that were tried stayed bounded over ten million steps" in page
    assert set(started_pairs()) == {x["method"] for x in records["pairs-long"]["runs"]} - {
        "pair-8-24"
    }
    rows = records["pairs"]["cases"]
    ratio = [_best(row) for row in rows]
    assert sum(x < 1 for x in ratio) == 17 and len(ratio) == 19
    assert "on 17 of 19 problems, by a factor of 1.3 to 3" in page
    wins = sorted(1 / x for x in ratio if x < 1)
    assert round(wins[0], 1) == 1.3 and round(wins[-1]) == 3
    rows = [x for x in shipped_table(records).splitlines() if "`pair-4-" in x]
    least, most = (f(float(x.split("|")[5]) for x in rows) for f in (min, max))
    assert f"The three pairs of order 4 need {least:.1f} to {most:.1f} times" in page
    assert len(rows) == 3
    # a record in which a pair stays bounded everywhere would show: the column would be empty
    other = copy.deepcopy(records)
    for run in other["kepler-long"]["runs"]:
        run["bounded"] |= run["method"] == "pair-rkn-6-8b"
    assert shipped_table(other) != shipped_table(records)


def _best(row):
    others = [name for group in tables.GROUPS.values() for name in group]
    ours = tables.best(row, tables.PAIRS, "1e-09")
    theirs = tables.best(row, others, "1e-09")
    assert ours is not None and theirs is not None
    return ours[1] / theirs[1]


def test_times_and_renewed_runs_of_the_short_page_are_those_of_the_data():
    page = " ".join(text(SHORT).split())
    cases = [x for x in measured("world")["cases"] if x["case"].startswith(("henon", "pendulum"))]
    spent = [{x["method"]: x["seconds"] for x in case["methods"]} for case in cases]
    ratio = [x["pair-rkn-6-8b"] / x["blanes-moan-rkn-6-14"] for x in spent]
    said = f"`pair-rkn-6-8b` takes {min(ratio):.2f} to {max(ratio):.2f} times the time"
    assert said in page and len(cases) == 4
    survey = measured("long-survey")["rows"]
    renewed = [
        (row["method"], run["verdict"])
        for row in survey
        if row["method"].startswith("pair-") and row["steps"] == 10_000_000
        for run in row["runs"]
        if run["renew"]
    ]
    assert len(renewed) > 60
    assert [x for x in renewed if x[1] != "bounded"] == [("pair-rkn-8-16", "lost")]
    assert "then stayed bounded, except one of `pair-rkn-8-16`" in page
