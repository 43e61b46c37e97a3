"""From an ansatz and a rough solution to a complete, proved document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ...claims import Proof
from ...exact import ball
from ..ansatz import Ansatz
from ..enclosure import Enclosure, prove
from ..newton import polish
from ..system import SweepSystem
from ..write import fill
from .record import Statement, derived_source

__all__ = ["Rough", "finish"]


@dataclass(frozen=True)
class Rough:
    """An ansatz with a solution to about ten digits.

    Attributes
    ----------
        ansatz: what is solved. start: value of each unknown, in the order of the document.
        where: what the method is, for its source record. claims: claims besides the usual ones.
    """

    ansatz: Ansatz
    start: Sequence[str]
    where: str
    claims: Mapping[str, Any] = field(default_factory=dict)


def finish(rough: Rough) -> tuple[dict[str, Any], Enclosure, list[Statement]]:
    """Polish, prove and complete one method.

    Raises
    ------
        ConvergenceError, ExactnessError: when the start leads to no root, or the proof fails.
    """
    document = rough.ansatz.document()
    start = [ball(Fraction(x)) for x in rough.start]
    document = fill(document, polish(SweepSystem(document).residuals, start))
    enclosure = prove(document)
    r = len(document["V"])
    document["claims"] = {
        "order": enclosure.order,
        "stage-order": SweepSystem(document).stage_order,
        **rough.claims,
        "preconsistent": True,
        "consistent": True,
        "zero-stable": True,
        "explicit": False,
        "g-symplectic": True,
        "symmetric": True,
        "parasitism-free": True,
        "growth": ["0"] * (r - 1),
    }
    document["source"] = derived_source(rough.where)
    return document, enclosure, [_statement(document, enclosure)]


def _statement(document: Mapping[str, Any], enclosure: Enclosure) -> Statement:
    text = (
        f"{document['name']}: exactly one solution within 1e-60 of the digits (contraction "
        f"{enclosure.contraction:.1e}); order {enclosure.order}, G-symplectic, symmetric and "
        f"parasitism-free there; redundant conditions enclosed to {enclosure.width:.1e}; order "
        f"{enclosure.order + 1} refuted by {enclosure.next_order:.2e}"
    )
    return Statement(text, Proof.ENCLOSED)
