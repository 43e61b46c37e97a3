"""Verdicts: what the judge says about the certificate of what was found.

A finder proposes whether a claim is true (:mod:`.kernel`), a certificate is written of it
(:mod:`.certificate`), and the judge decides (:mod:`glmref.judge`, over FLINT's numbers): a claim
``holds`` or ``fails`` where it accepts the certificate, and is ``open`` where it does not, or where
no certificate could be written.

The orders of plain documents, each at least what is said, are the exception: no statement of the
format is about them. Their conditions are evaluated on schemes (:func:`reaches`).
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import InitVar, dataclass, replace
from typing import Any

from ..exact import Exact, Scalar
from ..exact.judging import verdict as judges_verdict
from ..findings import Finding, Proof, Verdict
from .kernel import Found
from .schemes import Reach

_SEAL = object()


@dataclass(frozen=True)
class Judgement(Found):
    """A verdict about what was found; only this module can make one.

    Attributes
    ----------
    verdict : Verdict
        What was decided. ``open`` has the proof that a decision over these numbers would have had.
    certificate : Mapping[str, Any] or str
        What the judge accepted, or why there is none.
    seal : object
        That of this module.
    """

    verdict: Verdict
    certificate: Mapping[str, Any] | str
    seal: InitVar[object]

    def __post_init__(self, seal: object) -> None:
        """Refuse one that is made elsewhere."""
        if seal is not _SEAL:
            raise TypeError("only the judge's answers are judgements")

    def finding(self, method: str, claim: str, declared: object) -> Finding:
        """Return this verdict as the finding about one claim of a method."""
        return Finding(
            method=method, claim=claim, declared=declared, verdict=self.verdict, value=self.value,
            proof=self.proof, residual=self.residual, witness=self.reason,
        )  # fmt: skip


def _answer(verdict: Verdict, found: Found, certificate: Mapping[str, Any] | str) -> Judgement:
    return Judgement(**vars(found), verdict=verdict, certificate=certificate, seal=_SEAL)


def judged(found: Found, certificates: Iterable[Mapping[str, Any] | str]) -> Judgement:
    """Return the judge's verdict about what was found.

    Parameters
    ----------
    found : Found
        Whether the claim is true, as a finder has it.
    certificates : Iterable[Mapping[str, Any] or str]
        Certificates of it, of which the first that is accepted decides, or why there is none.
    """
    if found.truth is None:
        return _answer(Verdict.OPEN, found, "the claim is open")
    missing = refused = ""
    for certificate in certificates:
        if isinstance(certificate, str):
            missing = certificate
            continue
        plain = json.loads(json.dumps(certificate))  # texts with their values become plain ones
        accepted, sentence = judges_verdict(plain)
        if accepted:
            found = replace(found, proof=Proof(plain["statement"]["proof"]))
            verdict = Verdict.HOLDS if found.truth else Verdict.FAILS
            return _answer(verdict, found, plain)
        refused = refused or f"the judge refuses the certificate: {sentence}"
    if isinstance(found.value, bool):  # a proposal that was not accepted
        found = replace(found, value=None)
    if not missing:
        return _answer(Verdict.OPEN, replace(found, reason=refused), refused)
    why = f"no certificate is written: {missing}"
    reason = "; ".join(x for x in (found.reason, why) if x)
    return _answer(Verdict.OPEN, replace(found, reason=reason), missing)


def explained(judgement: Judgement, reason: str, residual: float) -> Judgement:
    """Return a judgement with the sentence that explains it, and the size of what decides."""
    return replace(judgement, residual=residual, reason=reason, seal=_SEAL)


def refuted(judgement: Judgement, *, reason: str = "", as_expected: bool = True) -> Judgement:
    """Return the judgement of "this claim fails": what was ``fails`` holds, and the other way.

    Parameters
    ----------
    judgement : Judgement
        Of the claim.
    as_expected : bool
        Whether it fails for the reason that was announced.
    reason : str
        Another sentence.
    """
    swap = {Verdict.FAILS: Verdict.HOLDS, Verdict.HOLDS: Verdict.FAILS}
    verdict = swap.get(judgement.verdict, Verdict.OPEN)
    if verdict is Verdict.HOLDS and not as_expected:
        verdict = Verdict.FAILS
    return replace(judgement, verdict=verdict, reason=reason or judgement.reason, seal=_SEAL)


def reaches(found: Reach, order: int, reason: str) -> Judgement:
    """Judge whether an order is reached, or more."""
    truth = True if found.proved >= order else None
    if found.refuted is not None and found.refuted <= order:
        truth = False
    value = found.proved if found.refuted is None else found.refuted - 1
    residual = 0.0 if truth else found.size(min(order, len(found.sizes)))
    return _of_conditions(truth, value, residual, reason, exact=found.exact)


def vanishing(x: Scalar, reason: str) -> Judgement:
    """Judge whether a number is zero."""
    truth = x.is_zero()
    residual = 0.0 if truth else x.magnitude()
    exact = isinstance(x, Exact)
    return _of_conditions(truth, residual, residual, reason, exact=exact)


def _of_conditions(
    truth: bool | None, value: object, residual: float, reason: str, *, exact: bool
) -> Judgement:
    """Return the verdict about a statement that has no certificate."""
    verdict = Verdict.OPEN if truth is None else Verdict.HOLDS if truth else Verdict.FAILS
    if truth is None and not reason:
        reason = "no rule decides it" if exact else "the published digits do not decide it"
    found = Found(truth, Proof.EXACT if exact else Proof.ENCLOSED, value, residual, reason)
    return _answer(verdict, found, "the order of a plain document")
