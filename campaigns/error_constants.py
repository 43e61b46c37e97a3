"""Error constants of all methods: ``data/measurements/error-constants.json``.

    python -m campaigns.error_constants data/measurements/error-constants.json

The local error of a method of order p is ``h^(p+1)`` times a sum over the trees of order p + 1:
residual over symmetry, times the elementary differential (Hairer, Norsett, Wanner (1993), II.1).
The residuals are computed in the arithmetic of the proofs and stored as rounded numbers, for pages
that compute nothing; what the file lacks is computed anew.
"""

import math
import sys
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from campaigns.driver import arguments, fingerprint, head_of, renew
from glmref.catalogue.lookup import load, names
from glmref.method import Method
from glmref.theory.coefficients import first_nonzero
from glmref.theory.order import OrderResult, error_norm, highest_order, order_of
from glmref.theory.residues import residues
from glmref.theory.starting_series import StartingSeries
from glmref.theory.trees import MAX_ORDER, counted

#: So many trees are named, those with the largest residuals.
LARGEST = 8


def row(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return error constants of one method.

    ``order`` is p; ``trees``, those of order p + 1, and ``nonzero``, how many have a residual;
    ``norm``, Euclidean, of residual over symmetry; ``largest``, pairs of a tree and its residual
    (its modulus where it is complex). Of a pair with an order of its own on second-order systems,
    ``nystrom`` has the same on the trees that count there, where all trees of order p + 1 are
    compared. Trees of an order above 13 are not: ``trees`` is 0. Of implicit multistep pairs for
    all systems the residuals of order 9 and above come from :func:`along_paths`.
    """
    method = load(case["method"])
    claims = method.claims
    wide = method.parts == 2 and method.shared and not method.is_explicit
    most = highest_order(method.palette) if wide else MAX_ORDER
    if wide and claims["order"] >= most and residues(method) is not None:
        return along_paths(method, claims["order"])
    result = order_of(method, principal="identity")
    if not method.is_one_step:  # as Facts.local_error: with a start, where the identity costs one
        free = order_of(method, principal="free")
        result = result if result.order == free.order else free
    if result.at_least and claims["order"] >= most:
        empty = {"trees": 0, "nonzero": 0, "norm": 0.0, "largest": []}
        return {"order": int(claims["order"]), **empty}
    if result.at_least:  # trees are compared up to an order by default, and none fails there
        result = order_of(method, max_order=int(claims["order"]) + 1, principal="identity")
    found = _constants(result)
    if claims.get("nystrom-order", highest_order(method.palette)) < highest_order(method.palette):
        found["nystrom"] = _constants(
            order_of(method, max_order=9, principal="identity", counts=counted("nystrom"))
        )
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


def along_paths(method: Method, order: int) -> dict[str, Any]:
    """Return the constants of a pair whose stages are the solution, from trees without branches.

    The pair, of multistep formulas of one evaluation, is for systems of two colours that may follow
    in any order, and has a proved order p of at least :data:`LARGEST`, so that the largest
    residuals are those of trees whose root has leaves only. The residual of a tree t of order n = p
    + 1 is n! / gamma(t) R, where R is that of the tree without branches with its root (see
    ``_along_paths`` of :mod:`glmref.prove.kernel`).
    """
    series = StartingSeries.of(method, free=False, along_paths=True)
    n, level = order + 1, {}
    while series.order < n:
        level = {t: first_nonzero(series.residual(t)) for t in series.advance()}
        series.settle()
    size = {t.colour: complex(x).real * math.factorial(n - 1) for t, x in level.items()}
    bushy = [
        (size[root], f"{root}[{'f' * (order - k)}{'k' * k}]")
        for root in sorted(size)
        for k in range(n)
    ]
    squares, count = forest_sums(n, 1)[-1], int(forest_sums(n, 0)[-1])
    return {
        "order": order,
        "trees": 2 * count,
        "nonzero": count * sum(x != 0 for x in size.values()),
        "norm": _short(n * math.sqrt(sum(x * x for x in size.values()) * squares)),
        "largest": [
            [tree, _short(x)] for x, tree in sorted(bushy, key=lambda one: (-abs(one[0]), one[1]))
        ][:LARGEST],
    }


def forest_sums(n: int, j: int) -> list[Fraction]:
    """Return the sums of ``(gamma sigma)^(-2 j)`` over trees of order 1 .. n with a given root.

    The trees have two colours. With weights w the forests are the product over trees of
    ``sum_k (w z^|t|)^k / k!^(2 j)``, of which the logarithm needs the sums for i j, i = 1 .. n.
    """
    forests, found = [Fraction(1)] + [Fraction(0)] * n, list[Fraction]()
    logarithm = [Fraction(0)] * (n + 1)
    series = [Fraction(1, math.factorial(k) ** (2 * j)) for k in range(n)]
    a = [Fraction(0)]  # of log(sum_k u^k / k!^(2 j)), by n c_n = sum_k k a_k c_(n - k)
    for k in range(1, n):
        a.append(series[k] - sum((i * a[i] * series[k - i] for i in range(1, k)), Fraction(0)) / k)
    powers = {i: forest_sums((n - 1) // i, i * j) for i in range(2, n)}
    for m in range(1, n + 1):
        found.append(forests[m - 1] / Fraction(m) ** (2 * j))
        if m == n:
            break
        divisors = [i for i in range(1, m + 1) if m % i == 0]
        known = {1: found, **powers}
        logarithm[m] = sum((2 * a[i] * known[i][m // i - 1] for i in divisors), Fraction(0))
        terms = (k * logarithm[k] * forests[m - k] for k in range(1, m + 1))
        forests[m] = sum(terms, Fraction(0)) / m
    return found


def _short(value: float) -> float:
    return float(f"{value:.6g}")


def main(path: Path) -> int:
    """Bring the file up to date and return how many methods were computed."""
    return renew(
        path,
        head_of(
            "error_constants",
            "error-constants",
            "Error constants: residuals of the trees one order beyond",
            measured="Computed exactly or in balls, rounded to six digits. norm: Euclidean, of "
            "residual over symmetry. Where the principal part is free, it is chosen so that trees "
            "with a leaf at the root have no residual.",
        ),
        "methods",
        ({"method": name, "fingerprint": fingerprint(name)} for name in names("methods")),
        row,
    )


if __name__ == "__main__":
    sys.stdout.write(f"computed {main(Path(arguments(sys.argv[1:])[0]))}\n")
