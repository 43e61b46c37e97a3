"""The measurements of order 6 and 8: long runs, their notes, and the search for order 8."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from campaigns.pages import measured
from glmref.catalogue.lookup import document, names
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
    found = {}
    for name in names("methods"):
        notes = document(name).get("notes", [])
        for note in [notes] if isinstance(notes, str) else notes:
            if "long-runs.json" in note:
                found[name, "pendulum-2.3"] = texts[note]
    return found


LONG_RUNS = measured("long-runs")


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
    assert {x["steps"] for x in LONG_RUNS["runs"] if x["outcome"] == "completed"} == {10**7}
    assert labelled() == grown(LONG_RUNS["runs"])


@pytest.mark.parametrize(
    ("method", "run", "change"),
    [
        ("g6245", "pendulum-2.3", {"parasitic": 3.1 * 3.197e-09}),  # grew, no note
        ("s4-w3", "pendulum-2.3", {"parasitic": 2.9 * 4.8e-09}),  # a note, did not grow
        ("s4-w3", "pendulum-2.3", {"bounded": False}),  # the other note
        ("g6245", "henon-heiles", {"bounded": False}),  # grew where no note speaks of
    ],
)
def test_a_note_that_differs_from_the_data_is_seen(
    method: str, run: str, change: dict[str, Any]
) -> None:
    runs = [
        {**x, **change} if (x["method"], x["run"]) == (method, run) else x
        for x in LONG_RUNS["runs"]
    ]
    assert runs != LONG_RUNS["runs"]
    assert labelled() != grown(runs)


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
