"""What was traded: constants of the methods of order 6 and 8, computed from their files.

``python -m campaigns.order6.survey FILE`` writes ``FILE`` (the one shipped is
``data/measurements/order6-methods.json``). For each method:

error
    Euclidean norm of ``residual / sigma`` over the trees of order p + 1: of the first value as it
    is, where that is the solution itself (``identity``), and after the best conjugation.
largest
    largest magnitude of an entry of A and of U in the file's basis.
periodicity
    end of the periodicity interval, proved; ``null`` for the whole axis.
parasitic
    for a simple eigenvalue zeta = exp(i theta) of V the eigenvalue of M(iy) near it is
    ``exp(i (theta + c2 y^2 + c3 y^3 + ..))``; there is no c1, because the growth parameter is 0,
    and the exponent is imaginary, because the method is G-symplectic. c2 and c3 say how fast a
    parasitic component runs through the unit circle as the step grows, towards resonances.
"""

from __future__ import annotations

import cmath
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, record_of
from glmref.catalogue.lookup import document, load, names
from glmref.method import GLM
from glmref.theory.error_constants import conjugate_error, error_norm
from glmref.theory.order import order_of
from glmref.theory.periodicity import periodicity

#: One-step methods that the others are compared with.
NEIGHBOURS = ("gauss-3", "gauss-4", "yoshida-6-midpoint", "triple-jump-6")

#: Points y at which M(iy) is looked at: errors of c2, c3 are O(y^2) times c4, c5, removed by a fit.
POINTS = tuple(k / 100 for k in range(1, 9))


def methods() -> list[str]:
    """Return real general linear methods of order 6 and 8 with several values, by name."""
    found = []
    for name in names("methods"):
        doc = document(name)
        several = doc["class"] in ("glm", "sweep") and len(doc["V"]) > 1
        if several and doc.get("field") != "complex" and doc["claims"].get("order", 0) >= 6:
            found.append(name)
    return found


def frequencies(method: GLM) -> list[dict[str, float]]:
    """Return c2 and c3 of each parasitic eigenvalue, by increasing argument in (0, pi]."""
    four_digits = method.to_float()
    A, U, B, V = four_digits.A, four_digits.U, four_digits.B, four_digits.V
    found = []
    for zeta in np.linalg.eigvals(V):
        theta = cmath.phase(complex(zeta))
        if abs(zeta - 1) < 1e-6 or theta < -1e-6:
            continue
        rows, right = [], []
        for y in (*POINTS, *(-y for y in POINTS)):
            M = V + 1j * y * B @ np.linalg.solve(np.eye(len(A)) - 1j * y * A, U)
            eigenvalues = np.linalg.eigvals(M)
            near = eigenvalues[np.argmin(np.abs(eigenvalues - zeta))]
            rows.append([y**k for k in range(2, 8)])
            right.append(cmath.phase(complex(near / zeta)))
        c = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]
        found.append({"argument": theta % (2 * math.pi), "c2": float(c[0]), "c3": float(c[1])})
    return sorted(found, key=lambda x: x["argument"])


def _errors(method: GLM, order: int) -> dict[str, float | None]:
    own = order_of(method, max_order=order + 1, principal="identity")
    free = order_of(method, max_order=order + 1)
    return {
        "identity": error_norm(own.residuals) if own.order == order else None,
        "after_conjugation": error_norm(conjugate_error(free)),
    }


def _largest(matrix: Sequence[Sequence[Any]]) -> float:
    return max(x.magnitude() for row in matrix for x in row)


def record(name: str) -> dict[str, Any]:
    """Return everything about one method."""
    method = load(name)
    assert isinstance(method, GLM)
    doc, order = document(name), method.claims["order"]
    assert isinstance(order, int)
    implicit = [i for i in range(method.s) if method.A[i][i].is_zero() is not True]
    blocks = {key: len(doc[key]["A"]) for key in ("starting", "finishing") if key in doc}
    axis = periodicity(method, conserving=True)
    return {
        "name": name,
        "order": order,
        "stages": method.s,
        "implicit": [i + 1 for i in implicit],
        "values": method.r,
        "order_identity": "order-identity" in method.claims,
        "start_stages": blocks.get("starting", 0),
        "finish_stages": blocks.get("finishing", 0),
        "error": _errors(method, order),
        "largest": {"A": _largest(method.A), "U": _largest(method.U)},
        "periodicity": None if axis.infinite else axis.value,
        "parasitic": frequencies(method),
    }


def _rounded(value: Any) -> Any:
    """Return the same with floats of four significant digits."""
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, dict):
        return {key: _rounded(x) for key, x in value.items()}
    return [_rounded(x) for x in value] if isinstance(value, list) else value


def row(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the four_digits record of one method."""
    return _rounded(record(case["method"]))


def main(path: Path) -> None:
    """Compute all records and write the file."""
    cases = ({"method": x} for x in (*methods(), *NEIGHBOURS))
    records = carried_out(row, cases, beside=path)
    title = "Constants of the methods of order 6 and 8"
    complete(path, record_of("order6.survey", "order6-methods", title, methods=records))


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
