"""Long runs on eight problems: the record, its verdicts, and what the page says of it."""

from collections import Counter

import pytest

from campaigns import long_survey
from campaigns.pages import measured
from campaigns.partitioned.test_kepler_long import labels
from glmref.derive.recipes.multistep import SHIPPED
from glmref.derive.recipes.sources import GROWS_IN_SURVEY, survey_notes

ROWS = measured("long-survey")["rows"]


@pytest.mark.slow
def test_the_record_holds_what_it_says():
    assert {x["method"] for x in ROWS} <= set(long_survey.surveyed())
    assert {x["method"] for x in ROWS} >= set(long_survey.ONE_VALUE)
    assert set(Counter((x["method"], x["steps"]) for x in ROWS).values()) == {
        len(long_survey.PROBLEMS)
    }
    carried = {name: long_survey.loaded(name).carried for name in {x["method"] for x in ROWS}}
    for row in ROWS:
        never = [run["h"] for run in row["runs"] if not run["renew"]]
        assert tuple(never) == long_survey.step_sizes(row["method"], row["problem"])
        again = [run["h"] for run in row["runs"] if run["renew"] == long_survey.RENEW]
        grown = [run["h"] for run in row["runs"] if run["verdict"] in ("grows", "lost")]
        assert set(again) <= set(never)
        if carried[row["method"]] > 1:
            assert {h for h in grown if h not in again} == set()
        assert all(run["verdict"] == long_survey.verdict(run) for run in row["runs"])


def test_recommended_methods_stay_on_every_problem_at_every_step_size():
    kept = [
        (x["steps"], run["verdict"])
        for x in ROWS
        if x["method"] in long_survey.ONE_VALUE
        for run in x["runs"]
    ]
    each = 3 * len(long_survey.PROBLEMS) * len(long_survey.ONE_VALUE)
    assert Counter(kept) == {(10**6, "bounded"): each, (10**7, "bounded"): each}


@pytest.mark.slow
def test_a_file_is_labelled_exactly_where_ten_million_steps_are_not_bounded():
    where = {}
    for x in ROWS:
        ends = [run["verdict"] for run in x["runs"] if not run["renew"]]
        if x["steps"] == 10**7 and ("lost" in ends or "grows" in ends):
            said = x["problem"] + (" (lost)" if "lost" in ends else "")
            where.setdefault(x["method"], []).append(said)
    assert labels("long-survey.json") == {
        name: [GROWS_IN_SURVEY.format("; ".join(x))] for name, x in where.items()
    }
    assert {name: survey_notes(name) for name in where} == labels(
        "long-survey.json"
    )  # what recipes write
    assert survey_notes("gauss-3") == []


@pytest.mark.slow
def test_a_run_repeats_its_first_hundred_thousand_steps():
    row = next(x for x in ROWS if x["method"] == "pair-6-7" and x["problem"] == "lattice")
    run = row["runs"][0]
    found = long_survey.followed("pair-6-7", "lattice", run["h"], 100_000, 0)
    assert found["energy"] == pytest.approx(run["energy"][:2], rel=0.05)


@pytest.mark.parametrize(
    ("energy", "outcome", "said"),
    [
        ([1e-9, 2e-9, 3e-9], "completed", "bounded"),
        ([1e-9, 9e-7, 3e-6], "completed", "bounded"),  # four samples at first
        ([1e-9, 2e-9, 9e-8], "completed", "grows"),
        ([1e-9, 2e-6, 2e-6], "completed", "grows"),
        ([1e-9, 2e-9, 0.5], "completed", "lost"),
        ([1e-9, None, None], "completed", "lost"),
        ([1e-9], "not finite", "lost"),
        ([0.1, 0.2, 0.3], "completed", "too coarse"),
    ],
)
def test_verdicts(energy, outcome, said):
    assert long_survey.verdict({"outcome": outcome, "energy": energy}) == said


def test_the_sentences_of_the_pages_are_those_of_the_record():
    choose, notes = (" ".join(x.read_text(encoding="utf-8").split()) for x in long_survey.PAGES)
    long = [x for x in ROWS if x["steps"] == 10**7]
    never = [(x["method"], run["verdict"]) for x in long for run in x["runs"] if not run["renew"]]
    always = {name for name, _ in never} - {name for name, end in never if end != "bounded"}
    multistep = {x for x in SHIPPED if x != "multistep-rkn-12"}
    assert (
        always == set(long_survey.ONE_VALUE) | multistep | {"s3z", "s5z-w3"} and len(SHIPPED) == 7
    )
    assert (
        "the recommended methods, six of the seven multistep methods and two general linear ones, "
        "`s3z` and `s5z-w3`, stayed bounded in all; no other method did"
    ) in choose
    again = [
        run["verdict"] for x in long if not x["method"].startswith(("gsymplectic", "milne"))
        for run in x["runs"] if run["renew"]
    ]  # fmt: skip
    said = f"{again.count('bounded')} of the {len(again)} runs"
    assert said in choose and said in notes
