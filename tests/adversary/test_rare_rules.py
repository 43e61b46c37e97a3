"""Files that reach branches of the rules which no shipped file reaches, each with its verdict."""

from __future__ import annotations

from typing import Any

import pytest

from glmref.findings import Verdict

from .deceive import doc, findings, texts

HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN


def glm(A: Any, U: Any, B: Any, V: Any, **more: Any) -> dict[str, Any]:
    return {"kind": "glm", "A": texts(A), "U": texts(U), "B": texts(B), "V": texts(V), **more}


def eye(n: int) -> list[list[int]]:
    return [[int(i == j) for j in range(n)] for i in range(n)]


def zeros(n: int) -> list[list[int]]:
    return [[0] * n for _ in range(n)]


#: With A = 0, U = V = 1 the growth matrix of the eigenvalue 1 is B.
NILPOTENT = [[0, 1], [0, 0]]
PRINCIPAL_AND_NILPOTENT = [[1, 0, 0], [0, 0, 1], [0, 0, 0]]
PRINCIPAL = [[1, 0, 0], [0, 0, 0], [0, 0, 0]]
DECIMAL = {
    "kind": "glm", "digits": 3, "A": texts(zeros(2)), "U": texts(eye(2)), "V": texts(eye(2)),
    "B": [["1.000", "0"], ["0", "0"]],
}  # fmt: skip
ONE = [["1"]]
DOUBLE = {"A": texts(zeros(2)), "U": texts(eye(2)), "B": texts(eye(2)), "V": texts(eye(2))}
EULER = {"kind": "rk", "A": [["0"]], "b": ["1"]}

ROWS: tuple[tuple[str, dict[str, Any], str, Any, Verdict], ...] = (
    # V = 1: B U has the eigenvalue 1 once, and otherwise nothing at all
    ("no principal", glm(zeros(2), eye(2), NILPOTENT, eye(2)), "parasitism-free", True, FAILS),
    ("no principal, said", glm(zeros(2), eye(2), NILPOTENT, eye(2)), "parasitism-free", False,
     HOLDS),
    ("nilpotent", glm(zeros(3), eye(3), PRINCIPAL_AND_NILPOTENT, eye(3)), "parasitism-free", True,
     FAILS),
    ("nilpotent, numbers", glm(zeros(3), eye(3), PRINCIPAL_AND_NILPOTENT, eye(3)), "growth",
     ["0", "0"], HOLDS),
    ("principal", glm(zeros(3), eye(3), PRINCIPAL, eye(3)), "parasitism-free", True, HOLDS),
    ("decimals", DECIMAL, "parasitism-free", True, OPEN),
    ("pair, double 1", {"kind": "partitioned", "q": DOUBLE, "p": DOUBLE, "separable": True},
     "parasitism-free", True, OPEN),
    # forms
    ("U not 1", glm([[0]], [[2]], [[1]], [[1]]), "symplectic", True, OPEN),
    ("V not 1", glm([[0]], [[1]], [[1]], [["1/2"]]), "g-symplectic", True, FAILS),
    ("decimals, no form", {"kind": "rk", "digits": 3, "A": [["0.500"]], "b": ["1.000"]},
     "g-symplectic", True, OPEN),
    # starts and finishes that are not there
    ("no start", EULER, "starting-order", 1, FAILS),
    ("no finish", EULER, "finishing-order", 1, FAILS),
    # entries that may be zero, lists of another length, no error constant
    ("may be zero", {"kind": "rk", "digits": 3, "A": [["0.001"]], "b": ["1"]}, "explicit", True,
     OPEN),
    ("two abscissae", EULER, "abscissae", ["0", "1"], FAILS),
    ("sigma 0", {"kind": "lmm", "alpha": ["-1", "1"], "beta": ["-1", "1"]}, "error-constant", "1",
     FAILS),
    ("not consistent", glm([[0]], [[1]], [[2]], [[1]], format="glmref-method-2",
                           embedded=[{"name": "e", "b": ["1"], "v": ["1"]}]),
     "embedded-difference", True, FAILS),
    ("order 0", glm([[0]], [[1]], [[2]], [[1]]), "stage-order", 1, FAILS),
    ("order 0, said", glm([[0]], [[1]], [[2]], [[1]]), "stage-order", 0, HOLDS),
)  # fmt: skip


@pytest.mark.parametrize(("name", "keys", "claim", "declared", "verdict"), ROWS)
def test_a_rare_file_has_its_verdict(
    name: str, keys: dict[str, Any], claim: str, declared: Any, verdict: Verdict
) -> None:
    keys = dict(keys)
    found = findings({**doc(keys.pop("kind"), {claim: declared}), **keys})[claim]
    assert found.verdict is verdict, (name, found.witness)
