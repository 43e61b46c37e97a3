"""Claims, findings, verdicts and kinds of proof.

A *claim* is what a data file says about a method. A *finding* is what was found when the claim was
recomputed, and how: see :class:`Proof`. A finding never says more than its proof does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


class Verdict(StrEnum):
    """Outcome of checking one claim."""

    HOLDS = "holds"
    FAILS = "fails"
    OPEN = "open"


class Proof(StrEnum):
    """How a verdict was reached, strongest first.

    ``exact``: arithmetic in the field of algebraic numbers, where zero is decidable.
    ``enclosed``: ball arithmetic, and an interval Newton (Krawczyk) test for existence.
    ``measured``: numerics with a derived bound.
    """

    EXACT = "exact"
    ENCLOSED = "enclosed"
    MEASURED = "measured"


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found when one claim of one method was recomputed.

    Attributes
    ----------
    method : str
        Name of the method, as its file gives it.
    claim : str
        The claim's key, for example ``"order"`` or ``"g-symplectic"``.
    declared : object
        The value the file claims (JSON-ready), or ``None`` where nothing was claimed.
    verdict : Verdict
        Whether the recomputed value agrees.
    value : object
        The recomputed value (JSON-ready).
    proof : Proof
        How the verdict was reached.
    residual : float
        Size of the largest violated identity, 0.0 when all hold exactly.
    witness : str
        One sentence naming the tree, entry or equation that decides, or ``""``.
    """

    method: str
    claim: str
    declared: object
    verdict: Verdict
    value: object = None
    proof: Proof = Proof.EXACT
    residual: float = 0.0
    witness: str = field(default="")

    def as_json(self) -> dict[str, object]:
        """Return the row of the ``glmref-findings-1`` format for this finding."""
        return {
            "method": self.method,
            "claim": self.claim,
            "declared": self.declared,
            "verdict": str(self.verdict),
            "value": self.value,
            "proof": str(self.proof),
            "residual": self.residual,
            "witness": self.witness,
        }

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Finding:
        """Return the finding that :meth:`as_json` wrote.

        Raises
        ------
        TypeError, ValueError, KeyError
            For a row of another form.
        """
        return cls(**{**row, "verdict": Verdict(row["verdict"]), "proof": Proof(row["proof"])})


def summarize(findings: list[Finding]) -> dict[str, int]:
    """Count the verdicts: ``{"holds": ..., "fails": ..., "open": ...}``."""
    return {str(v): sum(f.verdict is v for f in findings) for v in Verdict}
