"""Explicit symmetric partitioned multistep methods, one force evaluation a step: the shipped ones.

Option: ``name`` one shipped method (all of them by default); or ``q`` and ``p``, cosines of the
pairs of roots of the two halves, fractions separated by blanks (``q`` empty: for second-order
systems).

The shipped cosines were found by `campaigns.partitioned.multistep_search`; everything else follows
from them exactly (:mod:`glmref.derive.multistep`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ...catalogue.reader import load_document
from ...errors import ExactnessError, UsageError
from ...findings import Proof, Verdict
from ...prove.facts import facts_of
from ..multistep import multistep_document
from .record import Derivation, Progress, Statement

OPTIONS: Mapping[str, str] = {"name": "", "q": "", "p": ""}


@dataclass(frozen=True)
class Shipped:
    """Cosines of the two halves, in units of 1/256, and notes for the file."""

    q: Sequence[int]
    p: Sequence[int]
    notes: Sequence[str] = field(default_factory=tuple)

    def cosines(self) -> tuple[list[Fraction], list[Fraction]]:
        """Those of q and of p."""
        q, p = ([Fraction(x, 256) for x in half] for half in (self.q, self.p))
        return q, p


#: Labels that `campaigns/partitioned/test_multistep.py` compares with the data they name.
_BOUNDED = (
    "Over ten million steps from its starting method its energy error stays bounded, which here is "
    "less than tenfold over the last two decades, on seven orbits of five problems, see "
    "data/measurements/multistep-long.json."
)
_GROWS = (
    "Over ten million steps from its starting method its energy error or its carried values grow "
    "on {}, see data/measurements/multistep-long.json."
)

SHIPPED: Mapping[str, Shipped] = {
    "multistep-8": Shipped((168, 7, -186), (99, -102, -241), notes=(_BOUNDED,)),
    "multistep-10": Shipped(
        (210, 195, 4, -79), (172, 39, 84, -163), notes=(_GROWS.format("henon-heiles and toda"),)
    ),
    "multistep-rkn-8": Shipped((), (20, -71, -224), notes=(_BOUNDED,)),
    "multistep-rkn-10": Shipped(
        (), (-227, -135, 23, 102), notes=(_GROWS.format("toda and outer-solar-system"),)
    ),
    "multistep-rkn-12": Shipped(
        (), (102, 146, 53, -96, -232), notes=(_GROWS.format("toda and kepler at 1/10"),)
    ),
}


def title_of(order: int, *, second: bool) -> str:
    """One line for the file."""
    systems = "second-order" if second else "separable"
    return (
        f"Explicit symmetric partitioned multistep method of order {order} with one force "
        f"evaluation, for {systems} systems"
    )


def claims_of(order: int, *, second: bool) -> dict[str, Any]:
    """Return what the construction promises; :func:`derive` proves it."""
    orders = (
        {
            "order": 2,
            "order-identity": 2,
            "nystrom-order": order,
            "starting-order": 2,
            "nystrom-starting-order": order,
        }
        if second
        else {"order": order, "order-identity": order, "starting-order": order}
    )
    return {
        **orders,
        "preconsistent": True,
        "consistent": True,
        "zero-stable": True,
        "explicit": True,
        "g-symplectic": False,
        "symmetric": True,
        "parasitism-free": True,
        "reducible": False,
    }


def _complete(
    name: str, q: list[Fraction], p: list[Fraction], notes: Sequence[str], where: str
) -> tuple[dict[str, Any], Statement]:
    """Build a document and prove its claims.

    Raises
    ------
    ExactnessError
        When a claim is not proved.
    """
    second, order = not q, 2 * len(p) + 2
    document = multistep_document(name, q, p, title=title_of(order, second=second))
    document["claims"] = claims_of(order, second=second)
    document["source"] = {
        "citation": "glmref, derived by `glmref derive multistep` from the conditions of "
        "docs/multivalue.md",
        "where": where,
        "status": "derived",
    }
    if notes:
        document["notes"] = list(notes)
    facts = facts_of(load_document(document))
    for claim, declared in document["claims"].items():
        if facts.judge(claim, declared).verdict is not Verdict.HOLDS:
            raise ExactnessError(f"{name}: the claim {claim} = {declared} is not proved")
    systems = "second-order" if second else "separable"
    text = (
        f"{name}: order {order} on {systems} systems, start of the same order, symmetric, "
        f"parasitism-free"
    )
    return document, Statement(text, Proof.EXACT)


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Build and prove the shipped methods, or the one with given cosines.

    Raises
    ------
    UsageError
        For a name that is not shipped, or cosines that cannot be read.
    """
    if options["p"]:
        try:
            q, p = ([Fraction(x) for x in options[key].split()] for key in "qp")
        except (ValueError, ZeroDivisionError) as error:
            raise UsageError(
                f"`q` and `p` must be fractions with blanks between ({error})"
            ) from None
        name = f"multistep-{'' if q else 'rkn-'}{2 * len(p) + 2}-found"
        progress(name, 0, 1)
        document, statement = _complete(name, q, p, (), f"cosines {options['q']}; {options['p']}")
        return Derivation("multistep", [document], [statement])
    if options["name"] and options["name"] not in SHIPPED:
        raise UsageError(f"`name` must be one of {', '.join(SHIPPED)}, got {options['name']!r}")
    documents, statements = [], []
    names = [options["name"]] if options["name"] else list(SHIPPED)
    for k, name in enumerate(names):
        progress(name, k, len(names))
        shipped = SHIPPED[name]
        q, p = shipped.cosines()
        document, statement = _complete(
            name, q, p, shipped.notes, f"recipe multistep, name = {name}"
        )
        documents.append(document)
        statements.append(statement)
    progress("done", len(names), len(names))
    return Derivation("multistep", documents, statements)
