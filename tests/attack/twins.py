"""Random methods with twins: a verdict about digits must be true of every method within them.

Each method is drawn near a boundary (Jordan blocks, eigenvalues on the circle, multiple eigenvalues
1, starts that go ahead). It is verified three times: as it is, with one entry off by 1e-80, and in
decimals whose digits hold both. Where the decimals get a verdict, both exact twins must get the
same one or be open; a label ``exact`` needs exact entries. What holds or fails is held against the
oracle. Verdicts without a certificate that the checker accepts are counted.
"""

import json
import random
import tempfile
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.findings import Proof, Verdict
from glmref.prove.verifier import verify
from glmref.system.budget import limited
from tests.adversary.test_verdicts_have_certificates import without_a_certificate
from tests.build import SOURCE
from tests.oracle.claims import opinion
from tests.oracle.draw import Draw, claims_of

from .tally import Tally

COUNT = 500
SECONDS = 5.0
#: Claims of an underlying one-step method, which take long.
LONG = {"hamiltonian-to-order", "conjugate-symplectic-order", "energy-order", "second-order-growth"}


def drawn(draw: random.Random) -> dict[str, Any]:
    """One document of exact entries."""
    found = Draw(draw, near=0).document(["glm", "glm", "partitioned"])
    claims = {x: y for x, y in claims_of(found, draw).items() if x not in LONG}
    if found.get("separable") is True:
        claims["nystrom-order"] = draw.randint(1, 2)
    return {**found, "name": "twin", "source": SOURCE, "claims": claims}


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
    """Three decimals, right to one unit of the last."""
    x = int(Fraction(text) * 1000)
    sign = "-" if x < 0 else ""
    return f"{sign}{abs(x) // 1000}.{abs(x) % 1000:03d}" if x else "0.001-0.001"


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
        for claim, found in rounded.items():
            own, wrong = exact[claim], []
            for twin in (own, beside[claim]):
                if {found.verdict, twin.verdict} == {Verdict.HOLDS, Verdict.FAILS}:
                    wrong.append(f"{found.verdict} in digits, {twin.verdict} of a method in them")
            tally.outcomes[f"{found.verdict}, in digits"] += 1
            tally.outcomes[f"{own.verdict}"] += 1
            says = opinion(document, claim, document["claims"][claim])
            if says is not None and own.verdict is (Verdict.FAILS if says else Verdict.HOLDS):
                wrong.append(f"{own.verdict}, and the oracle says {says}")
            if own.verdict is not Verdict.OPEN and own.proof is not Proof.EXACT:
                wrong.append(f"of exact entries is {own.proof}")
            tally.violations += [f"{number}: {claim} {text}: {document}" for text in wrong]
        with tempfile.TemporaryDirectory() as folder:
            for one in (document, digits):
                for text in without_a_certificate({**one, "name": "deceiver"}, Path(folder)):
                    kind = "in digits" if "digits" in one else "of exact entries"
                    tally.outcomes[f"no certificate {kind}: {text}"] += 1
    return tally


def main(count: int, seed: int) -> int:
    """Attack with twins and print what came of it."""
    return attack(count, seed).printed()
