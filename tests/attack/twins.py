"""Random methods with twins: a verdict about digits must be true of every method within them.

Each method is drawn with a trap (Jordan blocks, eigenvalues on the circle, poles that cancel, idle
values, multiple eigenvalues 1, starts that go ahead). It is verified three times: as it is, with one
entry off by 1e-80, and in decimals whose digits hold both. Where the decimals get a verdict, both
exact twins must get the same one or be open; a label ``exact`` needs exact entries. What holds is
held against floating point: powers of V, M(z) at points of the left half-plane, the sum of the
weights. Verdicts without a certificate that the checker accepts are counted.
"""

from __future__ import annotations

import itertools
import json
import random
import tempfile
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.findings import Proof, Verdict
from glmref.prove.verifier import verify
from glmref.system.budget import limited
from tests.adversary.test_verdicts_have_certificates import without_a_certificate
from tests.build import SOURCE

from .tally import Tally

COUNT = 500
SECONDS = 5.0
TINY = Fraction(1, 10**80)
#: Last values of V, with the traps that they are: simple, on the circle, a Jordan block, outside.
TRAPS: tuple[list[list[str]], ...] = (
    [], [["0"]], [["-1"]], [["1"]], [["1/2"]], [["9/8"]], [["-1", "1"], ["0", "-1"]],
    [["-1", "0"], ["0", "-1"]], [["1", "1"], ["0", "1"]], [["1", "0"], ["0", "1"]],
    [["0", "-1"], ["1", "0"]], [["1/2", "1"], ["0", "1/2"]], [["0", "1"], ["0", "0"]],
)  # fmt: skip
CLAIMS: dict[str, Any] = {
    "consistent": True, "preconsistent": True, "zero-stable": True, "parasitism-free": True,
    "symmetric": True, "g-symplectic": True, "explicit": True,
}  # fmt: skip


def _entry(draw: random.Random) -> str:
    return draw.choice(("0", "0", "0", "1", "1/2", "-1/2", "1/4", "-1", "2", "3/8", "1/8"))


def _half(
    draw: random.Random, s: int, columns: int, r: int, tail: list[list[str]]
) -> dict[str, Any]:
    """One component whose V is 1 beside a trap, with U u = 1 more often than not."""
    V = [["0"] * r for _ in range(r)]
    V[0][0] = "1"
    for i, row in enumerate(tail, 1):
        V[i][1:] = row
    if draw.random() < 0.2 and r > 1:
        V[draw.randrange(1, r)][0] = _entry(draw)
    U = [["1", *(_entry(draw) for _ in range(r - 1))] for _ in range(s)]
    if draw.random() < 0.1:
        U[0][0] = _entry(draw)
    A = [[_entry(draw) for _ in range(columns)] for _ in range(s)]
    B = [[_entry(draw) for _ in range(columns)] for _ in range(r)]
    if draw.random() < 0.7:  # weights that sum to 1
        rest = sum(map(Fraction, B[0][:-1]), Fraction(0))
        B[0][-1] = str(1 - rest)
    if s == columns and draw.random() < 0.3:  # a midpoint, or the stages of one turned round
        A = [["1/2" if i == j else "0" for j in range(s)] for i in range(s)]
    return {"A": A, "U": U, "B": B, "V": V}


def drawn(draw: random.Random) -> dict[str, Any]:
    """One document of exact entries, every one with at most three decimals."""
    s = draw.choice((1, 1, 2, 2, 3))
    claims = {**CLAIMS, "order": draw.randint(1, 3)}
    document = {"format": "glmref-method-1", "name": "twin", "source": SOURCE, "claims": claims}
    tail = draw.choice(TRAPS)
    if draw.random() < 0.3:
        columns = draw.choice((s, s, 1, 2))
        separable = draw.random() < 0.6
        columns = columns if separable else s
        other = draw.choice((tail, draw.choice(TRAPS)))
        q = _half(draw, s, columns, 1 + len(tail), tail)
        p = _half(draw, columns, s, 1 + len(other), other)
        claims |= {"nystrom-order": draw.randint(1, 2), "reducible": False}
        return {**document, "class": "partitioned", "q": q, "p": p, "separable": separable}
    claims["a-stable"] = True
    if not tail:
        claims |= {"symplectic": True, "l-stable": True}
    single = {**document, "class": "glm", **_half(draw, s, s, 1 + len(tail), tail)}
    if draw.random() < 0.3:
        columns = [_entry(draw) for _ in range(1 + len(tail))]
        claims["starting-order"] = 1
        single["starting"] = {"A": [["0"]], "B": [[x] for x in columns], "order": 1,
                              "u": ["1", *["0"] * len(tail)]}  # fmt: skip
    return single


def blocks(document: dict[str, Any]) -> list[list[list[str]]]:
    """Every matrix of a document."""
    halves = [document[x] for x in ("q", "p") if x in document] or [document]
    return [half[x] for half in halves for x in "AUBV"]


def _with(document: dict[str, Any], places: Any, change: Any) -> dict[str, Any]:
    twin = json.loads(json.dumps(document))
    for m, i, j in places:
        row = blocks(twin)[m][i]
        row[j] = change(row[j])
    return twin


def _decimal(text: str) -> str:
    x = Fraction(text) * 1000
    sign = "-" if x < 0 else ""
    return f"{sign}{abs(x.numerator) // 1000}.{abs(x.numerator) % 1000:03d}" if x else "0.001-0.001"


def cases(count: int, seed: int) -> Iterator[tuple[dict[str, Any], dict[str, Any], dict[str, Any]]]:
    """A method, its twin off by 1e-80 and the digits that hold both."""
    for n in range(count):
        draw = random.Random(f"twins {seed} {n}")
        document = drawn(draw)
        every = [(m, i, j) for m, matrix in enumerate(blocks(document))
                 for i, row in enumerate(matrix) for j in range(len(row))]  # fmt: skip
        inexact = draw.sample(every, draw.choice((1, 1, 2, 4, len(every))) if len(every) > 4 else 1)
        m, i, j = draw.choice(inexact)
        near = _with(document, [(m, i, j)], lambda x: f"{x}+1/1{'0' * 80}")
        rounded = _with(document, inexact, _decimal)
        yield document, near, {**rounded, "digits": 3}


def _floating(document: dict[str, Any]) -> dict[str, bool]:
    """What floating point says clearly: a claim -> False."""
    seen: dict[str, bool] = {}
    matrices = [
        np.array([[float(Fraction(x)) for x in row] for row in m]) for m in blocks(document)
    ]
    for k in range(0, len(matrices), 4):
        A, U, B, V = matrices[k : k + 4]
        power = np.linalg.matrix_power(V, 4000)
        if not np.all(np.isfinite(power)) or np.abs(power).max() > 1000:
            seen["zero-stable"] = seen["a-stable"] = seen["l-stable"] = False
        if len(V) == 1 and abs(B.sum() - 1) > 1e-9 and abs(V[0][0] - 1) < 1e-9:
            seen["order"] = seen["consistent"] = False
        if "q" in document:
            continue
        for x, y in itertools.product((0.0, -1e-3, -1.0, -30.0), (0.0, 0.3, 1.7, 40.0)):
            z = complex(x, y)
            stages = np.eye(len(A)) - z * A
            if abs(np.linalg.det(stages)) > 1e-9:
                M = V + z * B @ np.linalg.solve(stages, U)
                if np.abs(np.linalg.eigvals(M)).max() > 1 + 1e-4:
                    seen["a-stable"] = seen["l-stable"] = False
    return seen


def judged(document: dict[str, Any]) -> dict[str, Any] | str:
    """Findings by claim, or the sentence of a refusal."""
    try:
        with limited(SECONDS):
            return {x.claim: x for x in verify(load_document(document))}
    except GlmrefError as error:
        return str(error)


def attack(count: int, seed: int) -> Tally:
    """Verify every method with its twins."""
    tally = Tally()
    for number, (document, near, digits) in enumerate(cases(count, seed)):
        exact, beside, rounded = map(judged, (document, near, digits))
        if isinstance(exact, str) or isinstance(beside, str) or isinstance(rounded, str):
            tally.outcomes["refused"] += 1
            continue
        no = _floating(document)
        for claim, found in rounded.items():
            for twin in (exact[claim], beside[claim]):
                if (
                    Verdict.OPEN not in (found.verdict, twin.verdict)
                    and found.verdict != twin.verdict
                ):
                    tally.violations.append(f"{number}: {claim} {found.verdict} in digits, "
                                            f"{twin.verdict} of a method in them: {document}")  # fmt: skip
            tally.outcomes[f"{found.verdict}, in digits"] += 1
            tally.outcomes[f"{exact[claim].verdict}"] += 1
            for x in (exact[claim], found):
                if x.verdict is Verdict.HOLDS and x.claim in no:
                    tally.violations.append(f"{number}: {claim} holds and must not: {document}")
            if exact[claim].verdict is not Verdict.OPEN and exact[claim].proof is not Proof.EXACT:
                tally.violations.append(
                    f"{number}: {claim} of exact entries is {exact[claim].proof}"
                )
        with tempfile.TemporaryDirectory() as folder:
            for one in (document, digits):
                for text in without_a_certificate({**one, "name": "deceiver"}, Path(folder)):
                    kind = "in digits" if "digits" in one else "of exact entries"
                    tally.outcomes[f"no certificate {kind}: {text}"] += 1
    return tally


def main(count: int, seed: int) -> int:
    """Attack with twins and print what came of it."""
    return attack(count, seed).printed()
