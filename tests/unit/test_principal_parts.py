"""What free principal parts move, and what they do not: orders of stages, of starts, of conjugates.

Each file here is the smallest that a rule took for another one.
"""

from fractions import Fraction
from typing import Any

import pytest

from glmref.catalogue.reader import load_document
from glmref.findings import Verdict
from glmref.prove import kernel as rules
from glmref.prove.verifier import facts_for
from tests.adversary.deceive import doc, findings, shipped, texts

HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN


def verdict(claim: str, value: Any, kind: str = "glm", **keys: Any) -> Verdict:
    return findings(doc(kind, {claim: value}, **keys))[claim].verdict


def truth(claim: str, value: Any, kind: str = "glm", **keys: Any) -> bool | None:
    """What the kernel finds, also where trees are compared through a low order."""
    method = load_document(doc(kind, {claim: value}, **keys))
    return facts_for(method).find(claim, value).truth


def test_the_start_of_a_pair_has_the_identity_as_principal_part(monkeypatch):
    """Also at the last order that is compared."""
    monkeypatch.setattr(rules, "MAX_ORDER", (1, 1, 1, 1, 1))
    half: dict[str, Any] = {"A": [["1/2"]], "b": ["1"], "A_hat": [["1/2"]], "b_hat": ["1"]}
    assert truth("starting-order", 0, "partitioned-rk", **half) is False


def test_a_start_is_not_right_in_principal_parts_that_are_not_known(monkeypatch):
    """Butcher's method of effective order 5 keeps no start that is the identity at order 4.

    Where trees are compared through order 4 alone, its order is not known, nor that of the start.
    """
    monkeypatch.setattr(rules, "HIGHEST", 4)
    start = {"A": [["0"]], "u": ["1"], "B": [["0"]], "order": 3}
    d = {**shipped("butcher-effective-5"), "starting": start, "claims": {"starting-order": 3}}
    assert findings(d)["starting-order"].verdict is OPEN


def test_of_the_last_order_that_is_compared_no_principal_part_is_free(monkeypatch):
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
def test_below_the_last_order_a_start_is_right_though_the_order_is_open(q, expected, monkeypatch):
    """No tree refutes a coefficient of one digit: of order 1 it is, and so is y0 as a start."""
    monkeypatch.setattr(rules, "HIGHEST", 4)
    start = {"A": [["0"]], "B": [["0"]], "u": ["1"]}
    d = doc("rk", {"order": 2, "starting-order": q}, A=[["0.5"]], b=["1"], digits=1, starting=start)
    facts = facts_for(load_document(d))
    found = [facts.find(x, d["claims"][x]).truth for x in ("order", "starting-order")]
    assert found == [None, expected]
