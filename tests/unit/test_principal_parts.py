"""What free principal parts move, and what they do not: orders of stages, of starts, of conjugates.

Each file here is the smallest that a rule took for another one.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.reader import load_document
from glmref.findings import Verdict
from glmref.prove import kernel as rules
from glmref.prove.verifier import facts_for
from tests.adversary.deceive import doc, findings, shipped, texts
from tests.adversary.test_verdicts_have_certificates import without_a_certificate

HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN
ONE = [["1", "0"], ["0", "1"]]
#: V = I, K = B U exchanges the values: of order 2, the abscissae (1/2, -1/2) of U eta = (-1, 0).
CROSSED: dict[str, Any] = {
    "A": [["3/2", "0"], ["0", "-1/2"]], "U": [["0", "1"], ["1", "0"]], "B": ONE, "V": ONE,
}  # fmt: skip


def verdict(claim: str, value: Any, kind: str = "glm", **keys: Any) -> Verdict:
    return findings(doc(kind, {claim: value}, **keys))[claim].verdict


def truth(claim: str, value: Any, kind: str = "glm", **keys: Any) -> bool | None:
    """What the kernel finds, also where trees are compared through a low order."""
    method = load_document(doc(kind, {claim: value}, **keys))
    return facts_for(method).find(claim, value).truth


@pytest.mark.parametrize(("q", "expected"), [(1, FAILS), (2, HOLDS), (3, FAILS)])
def test_two_principal_parts_make_each_of_two_stages_right(
    q: int, expected: Verdict, tmp_path: Path
) -> None:
    """At [o] they add (beta_2, beta_1) to the stages, which takes away any defect."""
    d = doc("glm", {"order": 2, "stage-order": q}, **CROSSED)
    assert findings(d)["order"].verdict is HOLDS
    assert findings(d)["stage-order"].verdict is expected
    assert without_a_certificate(d, tmp_path) == []


def test_a_third_stage_that_they_do_not_reach_ends_the_stage_order(tmp_path: Path) -> None:
    """Its abscissa is that of the first, its defect at [o] another: no beta takes both away."""
    wide = {"A": [["3/2", "0", "0"], ["0", "-1/2", "0"], ["0", "1", "1/2"]],
            "U": [*CROSSED["U"], ["0", "1"]], "B": [["1", "0", "0"], ["0", "1", "0"]], "V": ONE}  # fmt: skip
    for q, expected in ((1, HOLDS), (2, FAILS)):
        d = doc("glm", {"order": 2, "stage-order": q}, **wide)
        assert {c: x.verdict for c, x in findings(d).items()} == {
            "order": HOLDS,
            "stage-order": expected,
        }
        assert without_a_certificate(d, tmp_path) == []


def test_below_the_order_principal_parts_are_not_free() -> None:
    """Radau IA, order 3, for two values that the stages read apart: order 3 says what they are at [o]."""
    two: dict[str, Any] = {
        "A": [["1/4", "-1/4"], ["1/4", "5/12"]],
        "U": ONE,
        "B": [["1/4", "3/4"]] * 2,
        "V": ONE,
    }
    for q, expected in ((1, HOLDS), (2, FAILS), (3, FAILS)):
        assert verdict("stage-order", q, **two) is expected


def test_a_series_that_is_not_the_only_one_refutes_no_stage_order() -> None:
    """Radau IIA twice; a stage between the two is right at [o] if one is moved along the flow."""
    A, b, none = [["5/12", "-1/12"], ["3/4", "1/4"]], ["3/4", "1/4"], ["0", "0"]
    rows = [*([*x, *none, "0"] for x in A), *([*none, *x, "0"] for x in A), ["1", *none, *none]]
    two: dict[str, Any] = {"A": rows, "U": [*[ONE[0]] * 2, *[ONE[1]] * 2, ["1/2", "1/2"]],
           "B": [[*b, *none, "0"], [*none, *b, "0"]], "V": ONE}  # fmt: skip
    for q in (1, 2, 3):
        assert verdict("stage-order", q, **two) is OPEN


def test_where_other_series_are_not_excluded_no_stage_order_is_known() -> None:
    """Two midpoint rules beside each other: each may be moved along the flow for itself."""
    two: dict[str, Any] = {"A": [["1/2", "0"], ["0", "1/2"]], "U": ONE, "B": ONE, "V": ONE}
    for q in range(1, 4):
        assert verdict("stage-order", q, **two) is OPEN


@pytest.mark.parametrize("second", [0, 1])
def test_a_start_may_have_any_principal_part_of_the_last_order(second: int, tmp_path: Path) -> None:
    """The second value starts as y - h y' + second h^2 y'' .. : order 2 asks for no h^2."""
    start = {"A": [["0", "0"], ["1", "0"]], "u": ["1", "1"], "order": 2,
             "B": [["0", "0"], [str(-1 - second), str(second)]]}  # fmt: skip
    for q, expected in ((1, FAILS), (2, HOLDS)):
        d = doc("glm", {"starting-order": q}, **CROSSED, starting={**start, "order": q})
        assert findings(d)["starting-order"].verdict is expected
        assert without_a_certificate(d, tmp_path) == []


def test_a_start_agrees_with_no_series_that_may_be_another_one() -> None:
    """Radau IIA twice, each of which may be moved along the flow for itself."""
    (A, b), none = ([["5/12", "-1/12"], ["3/4", "1/4"]], ["3/4", "1/4"]), ["0", "0"]
    two: dict[str, Any] = {"A": [*([*x, *none] for x in A), *([*none, *x] for x in A)],
           "U": [*[ONE[0]] * 2, *[ONE[1]] * 2], "B": [[*b, *none], [*none, *b]], "V": ONE}  # fmt: skip
    start = {"A": [["0"]], "u": ["1", "1"], "B": [["0"], ["0"]], "order": 1}
    assert verdict("starting-order", 1, **two, starting=start) is OPEN


def test_the_start_of_a_pair_has_the_identity_as_principal_part(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Also at the last order that is compared."""
    monkeypatch.setattr(rules, "MAX_ORDER", (1, 1, 1, 1, 1))
    half: dict[str, Any] = {"A": [["1/2"]], "b": ["1"], "A_hat": [["1/2"]], "b_hat": ["1"]}
    assert truth("starting-order", 0, "partitioned-rk", **half) is False


def test_a_start_is_not_right_in_principal_parts_that_are_not_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Butcher's method of effective order 5 keeps no start that is the identity at order 4.

    Where trees are compared through order 4 alone, its order is not known, nor that of the start.
    """
    monkeypatch.setattr(rules, "HIGHEST", 4)
    start = {"A": [["0"]], "u": ["1"], "B": [["0"]], "order": 3}
    d = {**shipped("butcher-effective-5"), "starting": start, "claims": {"starting-order": 3}}
    assert findings(d)["starting-order"].verdict is OPEN


def test_of_the_last_order_that_is_compared_no_principal_part_is_free(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The midpoint rule beside an idle value is right at [o] if one is; order 3 may ask for others."""
    idle: dict[str, Any] = {"A": [["1/2"]], "U": [["1", "0"]], "B": [["1"], ["0"]],
                            "V": [["1", "0"], ["0", "0"]]}  # fmt: skip
    assert verdict("stage-order", 2, **idle) is HOLDS
    monkeypatch.setattr(rules, "MAX_ORDER", (2, 2, 2, 2, 2))
    for q in (1, 2):
        assert verdict("stage-order", q, **idle) is OPEN
    trapezoidal: dict[str, Any] = {"A": [["0", "0"], ["1/2", "1/2"]], "U": [["1", "0"]] * 2,
                                   "B": [["1/2", "1/2"], ["0", "0"]], "V": idle["V"]}  # fmt: skip
    assert truth("stage-order", 1, **trapezoidal) is False


def test_one_stage_in_decimals_leaves_the_stage_order_open() -> None:
    """The implicit trapezoidal rule twice; a stage that nothing uses is rounded in the first part.

    Within the digits its abscissa may be another one in the second part.
    """
    rows = [["0", "0", "0"], ["1/2", "1/2", "0"]]
    parts = [{"A": [*rows, [x, x, "0"]], "b": ["1/2", "1/2", "0"]} for x in ("0.500000", "1/2")]
    for q, expected in ((0, OPEN), (1, OPEN), (2, OPEN), (3, FAILS)):
        assert verdict("stage-order", q, "additive", parts=parts, digits=6) is expected


@pytest.mark.parametrize("c", [["0", "2/5"], ["1/4", "1/2"]])
def test_the_effective_order_of_a_method_with_another_clock_is_open(c: list[str]) -> None:
    """It is 2 at least: of order 2 is the second, and the first where y is y(t - h / 10)."""
    rk = {"format": "glmref-method-2", "A": [["0", "0"], ["1/2", "0"]], "b": ["0", "1"], "c": c}
    for q in (1, 2):
        assert verdict("effective-order", q, "rk", **rk) is OPEN


def collocation(n: int) -> tuple[list[list[Fraction]], list[Fraction]]:
    """A and b of n nodes at equal distances from 0 to 1."""
    nodes = [Fraction(i, n - 1) for i in range(n)]
    columns = []
    for j in range(n):
        basis = [Fraction(1)]
        for x in (x for k, x in enumerate(nodes) if k != j):
            low, high = [*basis, Fraction(0)], [Fraction(0), *basis]
            basis = [(b - x * a) / (nodes[j] - x) for a, b in zip(low, high, strict=True)]
        columns.append(
            [sum(c * x ** (m + 1) / (m + 1) for m, c in enumerate(basis)) for x in nodes]
        )
    A = [list(row) for row in zip(*columns, strict=True)]
    return A, A[-1]


def between_euler_steps(A: list[list[Fraction]], b: list[Fraction]) -> dict[str, Any]:
    """The method after a step of Euler's method, and before the inverse of that step."""
    zero, one = Fraction(0), Fraction(1)
    last = [one, *b, -one]
    rows = [[zero] * len(last), *([one, *row, zero] for row in A), last]
    return {"A": texts(rows), "b": [str(x) for x in last]}


def test_nor_do_those_of_a_pair(monkeypatch: pytest.MonkeyPatch) -> None:
    """The symplectic Euler method is conjugate to that of Stormer and Verlet, of order 2."""
    monkeypatch.setattr(rules, "MAX_ORDER", (2, 1, 1, 1, 1))
    for q in (1, 2):
        d = {**shipped("symplectic-euler-a"), "claims": {"effective-order": q}}
        assert findings(d)["effective-order"].verdict is OPEN


@pytest.mark.slow
def test_the_tree_with_leaves_alone_refutes_no_effective_order() -> None:
    """Eleven nodes have order 12; the order of the conjugate is 1, its effective order the same."""
    assert verdict("effective-order", 12, "rk", **between_euler_steps(*collocation(11))) is HOLDS


def test_the_tree_without_branches_refutes_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """R(z) of five explicit stages is of order 5: with trees through order 4 that is all one knows."""
    monkeypatch.setattr(rules, "HIGHEST", 4)
    for q, expected in ((3, FAILS), (4, OPEN), (5, OPEN), (6, FAILS)):
        d = {**shipped("butcher-effective-5"), "claims": {"effective-order": q}}
        assert findings(d)["effective-order"].verdict is expected


@pytest.mark.slow
def test_the_solution_that_is_twice_the_value_has_the_order() -> None:
    """U = 2 and u = 1/2: the trees with leaves alone count W B c^(n-1), not B c^(n-1)."""
    A, b = collocation(11)
    d = doc(
        "glm", {"order": 12}, A=texts(A), U=[["2"]] * 11, B=texts([[x / 2 for x in b]]), V=[["1"]]
    )
    assert findings(d)["order"].verdict is HOLDS


@pytest.mark.parametrize(("q", "expected"), [(0, False), (1, None), (2, None)])
def test_below_the_last_order_a_start_is_right_though_the_order_is_open(
    q: int, expected: bool | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No tree refutes a coefficient of one digit: of order 1 it is, and so is y0 as a start."""
    monkeypatch.setattr(rules, "HIGHEST", 4)
    start = {"A": [["0"]], "B": [["0"]], "u": ["1"]}
    d = doc("rk", {"order": 2, "starting-order": q}, A=[["0.5"]], b=["1"], digits=1, starting=start)
    facts = facts_for(load_document(d))
    found = [facts.find(x, d["claims"][x]).truth for x in ("order", "starting-order")]
    assert found == [None, expected]


def test_abscissae_are_open_where_it_is_open_whether_there_is_a_solution() -> None:
    """An eigenvalue may be 1 beside the one that is: no starting series was made."""
    V = [["1", "1/2"], ["0", "0.99999999999999999999"]]
    near: dict[str, Any] = {"U": [["1", "0"]], "B": [["1"], ["1"]], "V": V}
    assert verdict("abscissae", ["0"], A=[["0"]], digits=20, **near) is OPEN


@pytest.mark.sampled(1)
@pytest.mark.parametrize("claim", ["order", "order-identity"])
def test_principal_parts_of_higher_order_are_found_where_1_is_a_multiple_eigenvalue(
    claim: str, tmp_path: Path
) -> None:
    """Kutta's method of order 3, beside it h f(y + h f(y)) - h f(y), which starts as h^2 y''."""
    b, end = ["1/6", "2/3", "1/6", "0", "0", "0"], ["1/6", "2/3", "1/6", "1", "0", "0"]
    A = [["0"] * 6, ["1/2", *["0"] * 5], ["-1", "2", *["0"] * 4], b, ["1", *["0"] * 5], end]
    for p in (2, 3, 4):
        d = doc("glm", {claim: p}, A=A, U=[["1", "0"]] * 6, V=ONE,
                B=[b, ["1", "0", "0", "-1", "-1", "1"]])  # fmt: skip
        assert findings(d)[claim].verdict is (HOLDS if p == 3 else FAILS)
        assert without_a_certificate(d, tmp_path) == []
