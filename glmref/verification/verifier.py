"""Recompute what a data file claims; refute what a broken one claims."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from ..catalogue.lookup import document, path_of
from ..catalogue.reader import load_document
from ..errors import DataError, ExactnessError, GlmrefError
from ..exact import Exact
from ..exact.linalg import Vector
from ..findings import Finding, Proof, Verdict
from ..method import GLM, FinishingMethod, PairStartingMethod, PartitionedGLM, StartingMethod
from ..theory.facts import Facts, PairFacts, facts_of
from .checks import CHECKS, FOR_ONE_METHOD, Outcome

__all__ = ["claims_of", "proven_claims", "verify", "verify_file"]

Method = GLM | PartitionedGLM
#: What starts or finishes a method.
BLOCKS = StartingMethod | FinishingMethod | PairStartingMethod


def verify(method: Method, *, only: Collection[str] = ()) -> list[Finding]:
    """Check every claim the method carries.

    Args:
        method: a loaded method; its ``claims`` are those of its file.
        only: keys of the claims to check; all by default.

    Returns
    -------
        One finding for each claim, in the order of the file.

    Raises
    ------
        DataError: when the method carries no claims.
    """
    if not method.claims:
        raise DataError(
            f"the method {method.name or '(unnamed)'!r} carries no claims to verify; "
            f"load it from a file, or use analyze() to see what it is"
        )
    asked = {key: x for key, x in claims_of(method).items() if not only or key in only}
    if not asked:
        return []
    facts = facts_of(method, proven=proven_claims(method))
    return [_check(facts, claim, declared) for claim, declared in asked.items()]


def claims_of(method: Method) -> Mapping[str, Any]:
    """Add the orders that the starting and finishing blocks of a file declare to its claims.

    Raises
    ------
        DataError: where a block and a claim disagree.
    """
    claims = dict(method.claims)
    for kind in ("starting", "finishing"):
        block = getattr(method, kind, None)
        if block is None or "order" not in block.claims:
            continue
        order = block.claims["order"]
        if claims.setdefault(f"{kind}-order", order) != order:
            raise DataError(
                f"`{kind}.order` is {order} and the claim `{kind}-order` "
                f"{claims[f'{kind}-order']}; they must agree"
            )
    return claims


def proven_claims(method: Method) -> Collection[str] | None:
    """Prove, from the file alone, that a true method lies within the published digits.

    Returns
    -------
        The claims that hold for that true method, ``None`` for a file without an enclosure.

    Raises
    ------
        DataError, ExactnessError: when the file says so and it cannot be proved.
    """
    if method.document is None or "enclosure" not in method.document:
        return None
    if isinstance(method, PartitionedGLM):
        from ..prove.partitioned_enclosure import prove_pair

        return prove_pair(method.document).proves
    from ..prove.enclosure import prove

    return prove(method.document).proves


def _check(facts: Facts, claim: str, declared: object) -> Finding:
    if claim in FOR_ONE_METHOD and isinstance(facts, PairFacts):
        raise DataError(
            f"the claim {claim!r} of {facts.method.name!r} has no meaning for a pair; remove it"
        )
    try:
        outcome = CHECKS[claim](facts, declared)
    except ExactnessError as error:
        outcome = Outcome(None, None, witness=str(error))
    verdict = {True: Verdict.HOLDS, False: Verdict.FAILS, None: Verdict.OPEN}[outcome.holds]
    return Finding(
        method=facts.method.name,
        claim=claim,
        declared=declared,
        verdict=verdict,
        value=outcome.value,
        proof=_proof(facts, claim),
        residual=outcome.residual,
        witness=outcome.witness,
    )


def _proof(facts: Facts, claim: str) -> Proof:
    """Kind of proof of one claim; a start given by decimals is not as exact as the method."""
    kind = claim.removeprefix("nystrom-").removesuffix("-order")
    block = getattr(facts.method, kind, None)
    if facts.proof is not Proof.EXACT or not isinstance(block, BLOCKS):
        return facts.proof_of(claim)
    if all(isinstance(x, Exact) for row in _rows(block) for x in row):
        return Proof.EXACT
    if isinstance(block, PairStartingMethod):
        return Proof.MEASURED
    from ..prove.starting import start_is_enclosed

    return Proof.ENCLOSED if start_is_enclosed(facts.method) else Proof.MEASURED


def _rows(block: BLOCKS) -> Iterable[Vector]:
    """The coefficients of a block, row by row."""
    if isinstance(block, PairStartingMethod):
        return block.rows()
    return (*block.A, *([block.b] if isinstance(block, FinishingMethod) else block.B))


def verify_file(name: str | Path, *, only: Collection[str] = ()) -> list[Finding]:
    """Check a data file; for one of ``broken/`` the finding is that the named claim fails.

    Args:
        name: a shipped name or a path.
        only: keys of the claims to check; all by default.

    Raises
    ------
        UsageError, DataError: for a name or a file that cannot be read.
    """
    path = path_of(name)
    doc = document(path)
    method = load_document(doc, where=path.name)
    broken = doc.get("broken")
    if broken is not None and only and broken["claim"] not in only:
        return []
    if not method.claims:
        raise DataError(
            f"{path.name}: there is nothing to verify, since the file makes no claims; "
            f"`glmref analyze {path.name}` says what the method is"
        )
    try:
        if broken is None:
            return verify(method, only=only)
        return [_refute(method, broken)]
    except GlmrefError as error:
        if path.name in str(error):
            raise
        raise type(error)(f"{path.name}: {error}") from error


def _refute(method: Method, broken: Mapping[str, Any]) -> Finding:
    """Turn the failure of the named claim into a finding that the refutation holds.

    A file may say in ``broken.found`` which witness the refutation must give, word for word.
    """
    claim = broken["claim"]
    claims = claims_of(method)
    if claim not in claims:
        raise DataError(f"`broken.claim` names {claim!r}, which is not among the claims")
    inner = _check(facts_of(method), claim, claims[claim])
    refuted = {Verdict.FAILS: Verdict.HOLDS, Verdict.HOLDS: Verdict.FAILS}
    verdict, witness = refuted.get(inner.verdict, Verdict.OPEN), inner.witness
    if verdict is Verdict.HOLDS and broken.get("found", witness) != witness:
        verdict = Verdict.FAILS
        witness = f"it fails for another reason than `broken.found`: {witness}"
    return Finding(
        method=inner.method,
        claim=f"refutes {claim}",
        declared=inner.declared,
        verdict=verdict,
        value=inner.value,
        proof=inner.proof,
        residual=inner.residual,
        witness=witness,
    )
