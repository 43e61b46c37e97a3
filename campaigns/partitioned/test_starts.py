"""Starts of pairs: observed orders and runs on record, against the claims and notes of the files.

A start of order p with parity errs by O(h^(p+2)) in the values carried. The alternating terms in
the first values are smaller by h^2 where one of the equations `start` fails, by h^4 where both
hold (docs/pairs-order.md, Starting methods). Observed orders at h = 1/32 and 1/64 agree with these to 0.1: the
next term is smaller by h^2 times the ratio of the constants, 1e-3 times some ten.
"""

import pytest

from campaigns.pages import measured
from glmref.catalogue.lookup import document, names

CLOSE = 0.1


def started_pairs():
    """Return names of the explicit pairs whose files give a starting method."""
    pairs = [x for x in names("methods") if document(x)["class"] == "pair-sweep"]
    return [x for x in pairs if "starting" in document(x)]


def expected(name):
    """Return the orders of (carried from zero, from the start, first from zero, from it)."""
    doc = document(name)
    claims, equations = doc["claims"], doc["enclosure"]["equations"]
    both = {"start f[k] 2", "start k[f] 2"} <= set(equations)
    order = claims.get("nystrom-order", claims["order"])
    below = 4 if both else 2
    return below, order + 2, below + (4 if both else 2), order + 2 + (4 if both else 2)


@pytest.mark.slow
def test_the_stored_orders_are_those_of_the_claims():
    rows = measured("pairs-starts")["starts"]
    assert [x["method"] for x in rows] == started_pairs()
    for row in rows:
        orders = [row[what][x]["order"] for what in ("carried", "first") for x in ("zero", "own")]
        # carried values: exactly these orders; first values: at least, a symmetry may give more
        assert orders[:2] == pytest.approx(expected(row["method"])[:2], abs=CLOSE), row
        least = expected(row["method"])[2:]
        assert all(x > y - CLOSE for x, y in zip(orders[2:], least, strict=True)), row


@pytest.mark.slow
def test_every_pair_with_a_start_is_measured():
    record = measured("pairs-starts")
    pairs = {x for x in names("methods") if document(x)["class"] == "pair-sweep"}
    assert {x["method"] for x in record["runs"]} == set(started_pairs()) <= pairs
    assert len(record["runs"]) == 2 * len(started_pairs())


def test_a_file_says_so_exactly_where_its_start_stops_the_growth():
    zero = measured("pairs-long")["runs"]
    own = {(x["method"], x["problem"]): x["bounded"] for x in measured("pairs-starts")["runs"]}
    for name in started_pairs():
        growing = [x["problem"] for x in zero if x["method"] == name and not x["bounded"]]
        notes = " ".join(document(name).get("notes", []))
        stopped = bool(growing) and all(own[name, x] for x in growing)
        assert ("the starting method of this file they stay bounded" in notes) is stopped, name
    assert not all(own.values())  # no start stops it everywhere


def later(record):
    """Return pair -> problems on which a run of a hundred million steps is not bounded."""
    found = {}
    for x in record["further"]:
        if not x["bounded"]:
            found.setdefault(x["method"], []).append(x["problem"])
    return found


@pytest.mark.slow
def test_a_file_says_so_exactly_where_a_hundred_million_steps_show_growth():
    labelled = {}
    for name in started_pairs():
        for note in document(name).get("notes", []):
            if "hundred million" in note and "pairs-starts.json" in note:
                labelled[name] = note.partition("grow on ")[2].partition(", see")[0].split(" and ")
    record = measured("pairs-starts")
    assert labelled == later(record)
    record["further"][0]["bounded"] = not record["further"][0]["bounded"]
    assert labelled != later(record)
