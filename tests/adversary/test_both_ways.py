"""No claim is accepted in both directions, and no hostile certificate at all."""

from typing import Any

import pytest

from glmref.catalogue.lookup import document, names
from glmref.judge.claims import ORDERS, SECOND
from tests.shipped import HOSTILE

from .both_ways import (
    TRUTHS,
    VALUES,
    Subject,
    accepted,
    against_an_order,
    contradicts,
    directions,
    order_bounds,
    written,
)

ROWS = {row["name"]: row for row in HOSTILE}


def subject_of(row: dict[str, Any]) -> Subject:
    return Subject(row["document"], row["field"], row.get("base"), row["statement"]["proof"])


@pytest.mark.parametrize("name", ROWS)
def test_a_hostile_certificate_is_refused(name: str) -> None:
    row = ROWS[name]
    statement, parts = row["statement"], [(x["rule"], x["witness"]) for x in row["parts"]]
    certificate = subject_of(row).certificate(
        statement["claim"], statement["declared"], statement["verdict"], parts
    )
    assert not accepted(certificate), row["why"]


@pytest.mark.sampled(30, whole=len(ROWS))
@pytest.mark.parametrize("name", ROWS)
def test_no_claim_of_a_hostile_document_is_accepted_in_both_directions(name: str) -> None:
    row = ROWS[name]
    subject, statement = subject_of(row), row["statement"]
    claim, declared = statement["claim"], statement["declared"]
    own = [row, *written(row["document"], {claim: declared})]
    if claim in (*ORDERS, *SECOND):
        low, high = order_bounds(subject, claim, 2)
        assert high is None or low <= high
    elif claim in TRUTHS:
        assert len(directions(subject, claim, True, own)) < 2
    elif claim in VALUES:
        assert len(directions(subject, claim, declared, own)) < 2


@pytest.mark.sampled(1, besides=("pair-6-8", "pair-6-9"))
@pytest.mark.parametrize("name", [*names(), *names("broken")])
def test_no_claim_of_the_catalogue_is_accepted_in_both_directions(name: str) -> None:
    d = dict(document(name))
    for certificate in written(d, d["claims"]):
        assert accepted(certificate)
        assert not list(contradicts(certificate))


def test_a_contradiction_would_be_seen() -> None:
    """What is asked for is refused for its content: the true statements are accepted."""
    rk = {"class": "rk", "A": [["1/2"]], "b": ["1"]}
    subject = Subject(rk, {"kind": "rational"})
    assert order_bounds(subject, "order", 3) == (2, 2)
    assert directions(subject, "symplectic", True) == {True}
    assert directions(subject, "explicit", True) == {False}
    certificate = next(x for x in written(rk, {"order": 2}))
    assert not list(against_an_order(certificate, "order", 2))
    certificate["statement"] = {**certificate["statement"], "declared": 3}
    assert list(against_an_order(certificate, "order", 3))
