"""Embedded rows of methods that carry several values: weights of the stages and of the values."""

import copy
import json
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.catalogue.claims import EMBEDDED_DIFFERENCE, EMBEDDED_ORDER, ORDER_TO_DIGITS
from glmref.catalogue.lookup import document, load
from glmref.catalogue.reader import load_document
from glmref.exact import exact, linalg
from glmref.exchange.export import export
from glmref.findings import Verdict
from glmref.judge import verdict
from glmref.method import GLM
from glmref.method.embedded import EmbeddedRow
from glmref.prove.verifier import facts_for
from tests.adversary.deceive import doc

KEY = EMBEDDED_ORDER.key
TO_DIGITS = ORDER_TO_DIGITS.key
DIFFERENCE = EMBEDDED_DIFFERENCE.key
NAME = "dimsim-2-type-1"


def changed(**row: Any) -> dict[str, Any]:
    doc = copy.deepcopy(dict(document(NAME)))
    doc["embedded"][0].update(row)
    return doc


def judged(doc: dict[str, Any], declared: Any = None) -> tuple[Any, Any]:
    """The verdict on the orders of the rows, and what the checker says of its certificate."""
    declared = doc["claims"][KEY] if declared is None else declared
    doc = {**doc, "claims": {KEY: declared}}
    facts = facts_for(load_document(doc))
    found = facts.judge(KEY, declared)
    certificate = found.certificate
    assert isinstance(certificate, dict), certificate
    return found, verdict(json.loads(json.dumps(certificate)))


def test_in_a_run_the_row_less_the_solution_is_the_local_error() -> None:
    """y' = y^2: three steps, then the row, the solution, and the flow from the value before."""
    m = load(NAME)
    assert isinstance(m, GLM) and m.embedded[0].values is not None
    A, U, B, V = ([[complex(x).real for x in r] for r in M] for M in (m.A, m.U, m.B, m.V))
    d, w = ([complex(x).real for x in r] for r in (m.embedded[0].weights[0],
                                                  m.embedded[0].values))  # fmt: skip

    def combined(h: float, weights: Any, values: Any, slopes: Any, y: Any) -> float:
        inner = sum(b * f for b, f in zip(weights, slopes, strict=False))
        return h * inner + sum(v * x for v, x in zip(values, y, strict=True))

    ratios = []
    for h in (1 / 32, 1 / 64):
        y = [1.0, 1 / (1 + h)]
        for _ in range(4):
            slopes: list[float] = []
            for i in range(2):
                slopes.append(combined(h, A[i], U[i], slopes, y) ** 2)
            row = combined(h, d, w, slopes, y)
            before, y = y[0], [combined(h, B[i], V[i], slopes, y) for i in range(2)]
        flow = before / (1 - h * before)
        ratios.append((row - y[0]) / (flow - y[0]))
    assert abs(ratios[0] - 1) < 0.15 and abs(ratios[1] - 1) < 0.6 * abs(ratios[0] - 1)


def test_a_row_is_that_of_the_output_whatever_the_values() -> None:
    doc = {**changed(b=["1", "0"], v=["1/2", "1/2"]), "output": ["1/2", "1/2"]}
    found, (accepted, said) = judged(doc, {"estimate": 1})
    assert found.verdict is not Verdict.OPEN and accepted, said
    own = load_document({**changed(), "output": ["1/2", "1/2"]})
    values = linalg.matmul(((exact(Fraction(1, 2)),) * 2,), own.V)[0]
    weights = linalg.matmul(((exact(Fraction(1, 2)),) * 2,), own.B)[0]
    same = own.with_row(EmbeddedRow("own", (weights,), values=values))
    assert isinstance(same, GLM) and (same.B, same.V) == (own.B, own.V)


#: The midpoint rule, rounded, and Euler's, for one value.
MIDPOINT: dict[str, Any] = {
    "A": [["0", "0"], ["500001/1000000", "0"]], "U": [["1"], ["1"]], "B": [["0", "1"]], "V": [["1"]],
}  # fmt: skip


@pytest.mark.parametrize(("v", "expected"), [("1", Verdict.HOLDS), ("2", Verdict.OPEN)])
def test_a_row_that_doubles_the_solution_has_no_order_to_digits(v: str, expected: Verdict) -> None:
    row = {"name": "other", "b": ["1000000001/1000000000", "0"], "v": [v]}
    claims = {TO_DIGITS: {"b": [2, "1.0e-6"], "other": [1, "1.0e-9"]}}
    d = doc("glm", claims, **MIDPOINT, embedded=[row]) | {"format": "glmref-method-2"}
    facts = facts_for(load_document(d))
    found = facts.judge(TO_DIGITS, claims[TO_DIGITS])
    assert found.verdict is expected
    if expected is Verdict.HOLDS:
        good = found.certificate
        assert isinstance(good, dict) and verdict(json.loads(json.dumps(good)))[0]
        good["document"]["embedded"][0]["v"] = ["2"]
        accepts, why = verdict(json.loads(json.dumps(good)))
        assert not accepts and why.endswith("with each row of weights, is the solution")


def difference(d: dict[str, Any]) -> tuple[Verdict, str, bool]:
    """Whether the estimates are differences, why not, and whether the checker accepts the proof."""
    accepted = []
    facts = facts_for(load_document({**d, "claims": {}}))
    for declared in (True, False):
        d = {**d, "claims": {DIFFERENCE: declared}}
        found = facts_for(load_document(d)).judge(DIFFERENCE, declared)
        if found.verdict is Verdict.OPEN:
            continue
        good = found.certificate
        assert isinstance(good, dict), good
        accepted.append(verdict(json.loads(json.dumps(good))))
    found = facts.judge(DIFFERENCE, True)
    assert len(accepted) == (0 if found.verdict is Verdict.OPEN else 2)
    return found.verdict, found.reason, all(x for x, _ in accepted)


@pytest.mark.parametrize(
    ("claim", "declared", "wrong"),
    [
        (KEY, {"estimate": 3}, [("v", ["4/5", "1/5"]), ("b", ["3/4", "2/5"]), ("v", ["9/10"]),
                                ("name", "b")]),
        (DIFFERENCE, True, [("v", ["2/3", "1/3"]), ("b", ["3/4", "2/5"]), ("v", ["1"])]),
    ],
)  # fmt: skip
def test_a_forged_certificate_is_refused(claim: str, declared: Any, wrong: list[Any]) -> None:
    facts = facts_for(load_document({**changed(), "claims": {claim: declared}}))
    good = facts.judge(claim, declared).certificate
    for key, value in wrong:
        bad = json.loads(json.dumps(good))
        bad["document"]["embedded"][0][key] = value
        assert not verdict(bad)[0]
    other = json.loads(json.dumps(good))
    other["parts"] = [{"rule": "no-differences", "witness": {}}]
    assert not verdict(other)[0]


@given(st.integers(1, 3), st.data())
def test_a_row_with_an_order_and_no_other_gives_a_difference(r: int, data: st.DataObject) -> None:
    """Random consistent methods with random rows: a difference exactly where the row has order 1.

    V = u w + N with w N = 0 and N nilpotent, u = e_1 in other values; then the estimate is summed
    up for y' = 1 from values that are exact, too.
    """
    number = st.integers(-3, 3).map(lambda n: Fraction(n, 2))

    def matrix(rows: int, columns: int) -> list[list[Fraction]]:
        return [[data.draw(number) for _ in range(columns)] for _ in range(rows)]

    A, B, extra = matrix(2, 2), matrix(r, 2), matrix(2, r - 1)
    U = [[Fraction(1), *row] for row in extra]
    B[0][1] = 1 - B[0][0]
    V = [[Fraction(int(i == 0 and j == 0)) if j <= i else data.draw(number) for j in range(r)]
         for i in range(r)]  # fmt: skip
    V[0][1:] = [Fraction(0)] * (r - 1)
    # v = B 1 + V v - u with v_1 = 0: N is nilpotent, so that it ends
    v = [Fraction(0)] * r
    for _ in range(r):
        v = [Fraction(0)] + [sum(B[i]) + sum(V[i][j] * v[j] for j in range(r)) for i in range(1, r)]
    b, w = [data.draw(number) for _ in range(2)], [data.draw(number) for _ in range(r)]
    kind = data.draw(st.sampled_from(["as drawn", "u", "u and slope"]))
    if kind != "as drawn":
        w[0] = Fraction(1)
    if kind == "u and slope":
        b[1] += 1 - sum(b) - sum(x * y for x, y in zip(w, v, strict=True))
    right = w[0] == 1 and sum(b) + sum(x * y for x, y in zip(w, v, strict=True)) == 1

    def shown(M: list[list[Fraction]]) -> list[list[str]]:
        return [[str(x) for x in row] for row in M]

    row = {"name": "other", "b": [str(x) for x in b], "v": [str(x) for x in w]}
    d = doc("glm", {}, A=shown(A), U=shown(U), B=shown(B), V=shown(V), embedded=[row])
    d |= {"format": "glmref-method-2"}
    found, why, accepted = difference(d)
    assert accepted and (found is Verdict.HOLDS) == right, (why, d)
    assert found is not Verdict.OPEN
    moved = load_document({**d, "claims": {}}).transform(  # type: ignore[union-attr]
        [[int(i == j) + int(j > i) for j in range(r)] for i in range(r)]
    )
    assert facts_for(moved).judge(DIFFERENCE, True).verdict is found


def test_rows_follow_a_change_of_values_and_of_stages() -> None:
    method = load(NAME)
    scaled = method.transform([["1", "0"], ["1", "2"]])
    assert scaled.embedded[0].values == (exact(Fraction(3, 4)), exact(Fraction(1, 12)))
    turned = method.permute_stages([1, 0])
    assert turned.embedded[0].weights[0] == (exact(Fraction(5, 12)), exact(Fraction(3, 4)))
    mixed = method.transform([["1", "1"], ["1", "-2"]])
    for other in (scaled, turned, mixed):
        kernels = dict(facts_for(other).kernel.row_kernels)
        assert kernels["estimate"].range("order-identity").value == 3


def test_rows_are_exported_and_read_again() -> None:
    (row,) = load_document(json.loads(export(NAME, to="json", digits=20))).embedded
    (own,) = load(NAME).embedded
    assert (row.name, row.difference) == (own.name, own.difference) and row.values and own.values
    pairs = zip((*row.weights[0], *row.values), (*own.weights[0], *own.values), strict=True)
    assert all((x - y).is_zero() is not False for x, y in pairs)


def test_the_values_are_moved_along_u_until_the_output_is_the_row() -> None:
    method = load(NAME)
    row, other = method.embedded[0], method.with_row(method.embedded[0])
    assert isinstance(other, GLM) and other.B[0] == row.weights[0] and other.V[0] == row.values
    first, second = linalg.sub(other.V, method.V)
    assert first == second and (other.A, other.U) == (method.A, method.U)
