"""The order-6 method of section 3.4 as printed: its W has rank 5 where 3 is needed.

Khan (2018), section 3.4, prints b, c, A and W for c2 = 1/15. W = alpha alpha^T + beta beta^T -
gamma gamma^T has rank at most 3, over the complex numbers too, so no alpha, beta, gamma belong to
the printed W.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from ...exact import Exact, linalg
from ...findings import Proof
from ...method import as_matrix, as_vector
from .derivation import Derivation, Progress, Statement

OPTIONS: Mapping[str, str] = {}

#: W of section 3.4, as printed.
PRINTED_W = (
    ("1", "113/85", "-5613/85", "-466429841/745875", "36703237/18785"),
    ("113/85", "41161/50625", "-65239/3375", "-466060571/2278125", "36946367/57375"),
    ("-5613/85", "-65239/3375", "1071/1240", "-65239/3375", "-5613/85"),
    ("-466429841/745875", "-466060571/2278125", "-65239/3375", "41161/50625", "113/85"),
    ("36703237/18785", "36946367/57375", "-5613/85", "113/85", "1"),
)
_B = ("-17/168", "3375/9464", "248/507", "3375/9464", "-17/168")
_C = ("0", "1/15", "1/2", "14/15", "1")


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Prove that the printed W belongs to no method."""
    W, b, c = as_matrix(PRINTED_W, "W"), as_vector(_B, "b"), as_vector(_C, "c")
    rank = linalg.rank(W)
    skew = W[3][0] - W[4][1]
    trace = linalg.dot(b, [W[i][i] for i in range(5)])
    lines = [f"the printed W has rank {rank}; a sum of three squares has rank 3 at most"]
    lines.append(f"symmetry asks W41 = W52, and the printed entries differ by {_text(skew)}")
    lines.append(f"growth 0 asks sum b_i W_ii = 0, and the printed W gives {_text(trace)}")
    for k in range(5):
        if sum((x * y**k for x, y in zip(b, c, strict=True)), Exact(0)) != Fraction(1, k + 1):
            break  # pragma: no cover - b and c are right
    else:
        lines.append("the printed b and c are right: sum b_i c_i^k = 1/(k+1) for k = 0..4")
    progress("done", 1, 1)
    return Derivation(
        "thesis-printed", [], [Statement(x, Proof.EXACT) for x in lines], refused=rank > 3
    )


def _text(value: object) -> str:
    fraction = value.as_fraction() if isinstance(value, Exact) else None
    return str(fraction)
