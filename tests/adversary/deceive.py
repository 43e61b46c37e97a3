"""Documents made to deceive, and what the verifier says of them."""

import copy
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.errors import DataError, ExactnessError
from glmref.findings import Finding, Proof, Verdict
from glmref.prove.verifier import verify
from tests.build import method_document


def doc(kind: str, claims: Mapping[str, Any], **keys: Any) -> dict[str, Any]:
    return {**method_document(kind, claims, **keys), "name": "deceiver"}


def texts(rows: Sequence[Sequence[Any]]) -> list[list[str]]:
    return [[str(Fraction(x)) if not isinstance(x, str) else x for x in row] for row in rows]


def decimal(x: Fraction | int, digits: int) -> str:
    scaled = round(Fraction(x) * 10**digits)
    sign, scaled = ("-", -scaled) if scaled < 0 else ("", scaled)
    return f"{sign}{scaled // 10**digits}.{scaled % 10**digits:0{digits}d}"


def findings(d: Mapping[str, Any]) -> dict[str, Finding]:
    return {x.claim: x for x in verify(load_document(d))}


def verdicts(d: Mapping[str, Any]) -> dict[str, Verdict]:
    return {claim: x.verdict for claim, x in findings(d).items()}


def shipped(name: str) -> dict[str, Any]:
    return copy.deepcopy(dict(document(name)))


def never_holds(d: Mapping[str, Any], *claims: str) -> None:
    """None of the claims is said to hold: a sentence, ``fails`` or ``open`` instead."""
    try:
        found = verdicts(d)
    except (DataError, ExactnessError) as error:
        assert str(error).count("\n") == 0
        return
    for claim in claims:
        assert found[claim] is not Verdict.HOLDS, claim


__all__ = [
    "Proof", "Verdict", "decimal", "doc", "findings", "never_holds", "shipped", "texts", "verdicts",
]  # fmt: skip
