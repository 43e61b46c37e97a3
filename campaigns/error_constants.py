"""Error constants of all methods: ``data/measurements/error-constants.json``.

    python -m campaigns.error_constants data/measurements/error-constants.json

The local error of a method of order p is ``h^(p+1)`` times a sum over the trees of order p + 1:
residual over symmetry, times the elementary differential (Hairer, Norsett, Wanner (1993), II.1).
The residuals are computed in the arithmetic of the proofs and stored as rounded numbers, for pages
that compute nothing; what the file lacks is computed anew.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from campaigns.driver import arguments, fingerprint, renew
from glmref.catalogue.lookup import load, names
from glmref.prove.facts import facts_of
from glmref.theory.error_constants import error_norm
from glmref.theory.order import OrderResult, highest_order, order_of
from glmref.theory.trees import MAX_ORDER

#: So many trees are named, those with the largest residuals.
LARGEST = 8


def row(case: Mapping[str, Any]) -> dict[str, Any]:
    """Error constants of one method.

    Returns
    -------
    dict[str, Any]
        ``order`` p; ``trees``, those of order p + 1, and ``nonzero``, how many have a residual;
        ``norm``, Euclidean, of residual over symmetry; ``largest``, pairs of a tree and its
        residual (its modulus where it is complex). Of a pair with an order of its own on
        second-order systems, ``nystrom`` has the same on the trees that count there, where all
        trees of order p + 1 are compared. Trees of an order above 13, of implicit pairs for all
        systems above 8, are not: ``trees`` is 0.
    """
    facts = facts_of(load(case["method"]))
    method, claims = facts.method, facts.method.claims
    result = facts.classical_order
    wide = method.parts == 2 and method.shared and not method.is_explicit
    most = highest_order(method.palette) if wide else MAX_ORDER
    if result.at_least and claims["order"] >= most:
        empty = {"trees": 0, "nonzero": 0, "norm": 0.0, "largest": []}
        return {"order": int(claims["order"]), **empty}
    if result.at_least:  # trees are compared up to an order by default, and none fails there
        result = order_of(method, max_order=int(claims["order"]) + 1, principal="identity")
    found = _constants(result)
    if claims.get("nystrom-order", highest_order(method.palette)) < highest_order(method.palette):
        found["nystrom"] = _constants(facts.nystrom_order)
    return found


def _constants(result: OrderResult) -> dict[str, Any]:
    sized = [(x.magnitude(), str(t), x) for t, x in result.residuals.items()]
    there = [item for item in sized if item[2].is_zero() is False]
    ranked = sorted(there, key=lambda item: (-item[0], item[1]))[:LARGEST]
    return {
        "order": result.order,
        "trees": len(sized),
        "nonzero": len(there),
        "norm": _short(error_norm(result.residuals)),
        "largest": [
            [tree, _short(complex(x).real if x.is_real() else size)] for size, tree, x in ranked
        ],
    }


def _short(value: float) -> float:
    return float(f"{value:.6g}")


def main(path: Path) -> int:
    """Bring the file up to date and return how many methods were computed."""
    return renew(
        path,
        {
            "format": "glmref-measurement-1",
            "name": "error-constants",
            "title": "Error constants: residuals of the trees one order beyond",
            "how": "python -m campaigns.error_constants FILE",
            "measured": "Computed exactly or in balls, rounded to six digits. norm: Euclidean, of "
            "residual over symmetry. Where the principal part is free, it is chosen so that trees "
            "with a leaf at the root have no residual.",
        },
        "methods",
        ({"method": name, "fingerprint": fingerprint(name)} for name in names("methods")),
        row,
    )


if __name__ == "__main__":
    sys.stdout.write(f"computed {main(Path(arguments(sys.argv[1:])[0]))}\n")
