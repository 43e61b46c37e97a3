"""What the attack with twins has found, and a small one: see :mod:`tests.attack.twins`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.attack import twins

from .deceive import Verdict, doc, verdicts
from .test_verdicts_have_certificates import without_a_certificate

ONE = [["1"]]
DOUBLE = [["1", "0"], ["0", "1"]]


@pytest.mark.slow
@pytest.mark.parametrize(("count", "seed"), [(5, 3), pytest.param(20, 4, marks=pytest.mark.slow)])
def test_a_verdict_about_digits_is_true_of_every_method_in_them(count: int, seed: int) -> None:
    tally = twins.attack(count, seed)
    assert not tally.violations, tally.text()
    assert tally.outcomes["fails"] and tally.outcomes["open, in digits"]


def glm(A: Any, U: Any, B: Any, V: Any, **more: Any) -> dict[str, Any]:
    return {**doc("glm", more.pop("claims"), A=A, U=U, B=B, V=V, **more), "name": "deceiver"}


def test_a_double_eigenvalue_in_decimals_leaves_preconsistency_open() -> None:
    """U u = 1 has the solution (3, -1); the u of order 1 has not U u = 1."""
    claims = {"preconsistent": True, "consistent": True, "g-symplectic": True}
    found = verdicts(
        glm([["0"]], [["0.500", "0.500"]], [["1"], ["0"]], DOUBLE, claims=claims, digits=3)
    )
    assert found["preconsistent"] is Verdict.OPEN
    assert found["g-symplectic"] is Verdict.OPEN


def test_decimals_that_are_not_preconsistent_have_no_form() -> None:
    claims = {"preconsistent": True, "g-symplectic": True}
    two = glm([["0", "0"]] * 2, [["1.000"], ["2.000"]], [["1", "0"]], ONE, claims=claims, digits=3)
    assert set(verdicts(two).values()) == {Verdict.FAILS}


def test_what_an_unknown_u_reaches_is_open() -> None:
    half = {"A": [["0"]], "U": [["0.500", "0.500"]], "B": [["1"], ["0"]], "V": DOUBLE}
    pair = doc("partitioned", {"reducible": False}, q=half, p=half, digits=3)
    assert verdicts(pair)["reducible"] is Verdict.OPEN


@pytest.mark.parametrize(
    ("B", "verdict"), [([["1", "0"]], Verdict.HOLDS), ([["0", "0"]], Verdict.FAILS)]
)
def test_without_a_u_the_stages_decide_what_is_reached(B: Any, verdict: Verdict) -> None:
    half = {"A": [["0", "0"]] * 2, "U": [["1.000"], ["2.000"]], "B": B, "V": ONE}
    pair = doc("partitioned", {"reducible": False}, q=half, p=half, digits=3)
    assert verdicts(pair)["reducible"] is verdict


def test_a_start_with_other_principal_parts_of_a_pair_is_not_refuted() -> None:
    """V = V^ = I: to order 1 the second value may start with any multiple of h f."""
    half = {"A": [["0"]], "U": [["1", "0"]], "B": [["1"], ["1"]], "V": DOUBLE}
    start = {"A": [["0"]], "B": [["0"], ["5"]], "u": ["1", "1"], "order": 1}
    start |= {f"{x}_hat": start[x] for x in "ABu"}
    pair = doc("partitioned", {"order": 1, "starting-order": 1}, q=half, p=half, starting=start)
    assert verdicts(pair)["starting-order"] is Verdict.OPEN


def test_a_form_needs_the_u_that_the_method_determines() -> None:
    claims = {"g-symplectic": True}
    single = glm([["0"]], [["1", "-1"]], [["-1"], ["0"]], DOUBLE, claims=claims)
    assert verdicts(single) == {"g-symplectic": Verdict.OPEN}
    q = {"A": [["0"]], "U": [["1", "-1"]], "B": [["-1"], ["0"]], "V": DOUBLE}
    p = {"A": [["0"]], "U": ONE, "B": ONE, "V": ONE}
    assert verdicts(doc("partitioned", claims, q=q, p=p)) == {"g-symplectic": Verdict.OPEN}


@pytest.mark.parametrize(
    "document",
    [
        glm([["0"]], [["1", "0", "0"]], [["1"], ["0"], ["0"]],
            [["1", "0", "0"], ["0", "-1", "1"], ["0", "0", "-1"]],
            claims={"zero-stable": True, "parasitism-free": True, "a-stable": True}),
        doc("partitioned", {"zero-stable": True}, separable=True,
            q={"A": [["0"]], "U": ONE, "B": ONE, "V": ONE},
            p={"A": [["0"]], "U": [["1", "0"]], "B": [["1"], ["0"]], "V": [["1", "0"], ["0", "2"]]}),
        glm([["0.001-0.001", "0.500"], ["0.500", "0"]], [["1"], ["1"]], [["1", "0"]], ONE, digits=3,
            claims={"explicit": True}),
        glm([["1/2"]], [["1", "0"]], [["1"], ["0"]], [["1", "0"], ["0", "-1"]],
            claims={"a-stable": True}),
    ],
    ids=["defective on the circle", "second half unbounded", "cycle in decimals", "fixed eigenvalue"],
)  # fmt: skip
def test_these_verdicts_have_certificates(document: dict[str, Any], tmp_path: Path) -> None:
    assert without_a_certificate({**document, "name": "deceiver"}, tmp_path) == []
