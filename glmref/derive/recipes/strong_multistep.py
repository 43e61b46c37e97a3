"""Explicit linear multistep methods for any system, strongly stable, nearly without dissipation.

Options: ``name`` one shipped method (all of them by default); or ``order``, even, 8 by default, and
``pairs``, the numbers a b of each factor z^2 - a z + b of rho, and ``reals``, the m of each z + m,
fractions separated by blanks, and ``constant``, the error constant, free from order + 2 steps on.
The other factor of rho is z - 1.

Everything but these numbers follows exactly (:mod:`glmref.derive.strong_multistep`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import UsageError
from ...findings import Proof
from ...method.lasting import lasting
from ..strong_multistep import StrongFormula, strong_document
from .derivation import (
    Derivation,
    Progress,
    Statement,
    chosen,
    complete_exactly,
    completed,
    rational_option,
)
from .multistep import CLAIMS
from .sources import derived_source

OPTIONS: Mapping[str, str] = {"name": "", "order": "", "pairs": "", "reals": "", "constant": ""}

_PAGE = "docs/nonseparable.md"
#: A note that says by which power of h the energy drifts, and one for runs that are watched.
_DRIFTS = "On Hamiltonian systems the energy drifts with h^{}, see " + _PAGE + "."
_WATCHED = "A run that is being lost has a notice."


@dataclass(frozen=True)
class Shipped:
    """The numbers of a formula, as the options have them."""

    pairs: str
    reals: str
    constant: str = ""
    order: str = ""

    def formula(self) -> StrongFormula:
        """Return the formula.

        Raises
        ------
        UsageError
            For text that is not numbers, or numbers that no such formula has.
        """
        pairs, reals, constant, order = (
            [rational_option(key, x) for x in getattr(self, key).split()]
            for key in ("pairs", "reals", "constant", "order")
        )
        if len(pairs) % 2:
            raise UsageError("`pairs` must be an even number of fractions, a b for each factor")
        if len(constant) > 1 or len(order) > 1 or any(x.denominator > 1 for x in order):
            raise UsageError("`order` must be one whole number, and `constant` one fraction")
        both = tuple(zip(pairs[::2], pairs[1::2], strict=True))
        return StrongFormula(int(order[0]) if order else 8, both, tuple(reals), *constant)


SHIPPED: Mapping[str, Shipped] = {
    "multistep-strong-8": Shipped(
        "153/100 19/20 73/50 93/100 113/100 87/100 11/50 19/25 -31/50 1/10", "", "-1/80"
    ),
    "multistep-strong-8b": Shipped("5/4 29/30 9/10 9/10 1/10 3/4", "3/5 1/5"),
}


def _complete(name: str, numbers: Shipped, where: str) -> tuple[dict[str, Any], list[Statement]]:
    """Build a document and prove its claims.

    Raises
    ------
    ExactnessError
        When a claim is not proved.
    """
    formula = numbers.formula()
    order, (C, *rest) = formula.order, formula.error_constants
    first = next((n for n in (1, 3) if rest[n - 1]), 5)
    title = f"Explicit linear multistep method of order {order}, strongly stable"
    document = strong_document(name, formula, title)
    claims = {
        "order": order,
        "order-identity": order,
        "stage-order": order,
        "starting-order": order,
        **{key: value for key, value in CLAIMS.items() if key != "reducible"},
        "symmetric": False,
    }
    watched = lasting(np.linalg.eigvals(np.array(formula.V, dtype=float)))
    notes = [_DRIFTS.format(order + first), *[_WATCHED] * bool(watched)]
    complete_exactly(document, claims, derived_source(where, "strong-multistep", _PAGE), notes)
    text = (
        f"{name}: order {order} on all systems with {formula.steps} steps, every parasitic root "
        f"inside the unit circle; the error constant is {float(C):.4g}, and the energy drifts with "
        f"h^{order + first}"
    )
    return document, [Statement(text, Proof.EXACT)]


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Build and prove the shipped methods, or the one with given roots.

    Raises
    ------
    UsageError
        For a name that is not shipped, or numbers that cannot be read.
    """
    given = {key: options[key] for key in ("pairs", "reals", "constant", "order")}
    if any(given.values()):
        if options["name"]:
            raise UsageError("`name` is that of a shipped method, which takes no other options")
        if not given["pairs"] and not given["reals"]:
            raise UsageError("`order` and `constant` need the roots: give `pairs` or `reals`")
        made = {"multistep-strong-found": Shipped(**given)}
        where = "; ".join(f"{key} {text}" for key, text in given.items() if text)
    else:
        made, where = dict(chosen(options["name"], SHIPPED)), ""
    return completed("strong-multistep", made, _complete, progress, where)
