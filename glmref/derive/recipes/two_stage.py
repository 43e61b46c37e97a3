"""The two-stage family of section 3.2: N and P fall out, and no growth is impossible there.

Two stages, two values, V = diag(1, -1), A lower triangular, G-symplectic: by
:mod:`glmref.method.sweep` the method is D = (b1, b2), X = [[1, 1], [x1, x2]], G = diag(1, g). Only
p = g x1^2, q = g x1 x2 and r = g x2^2 matter, p r = q^2. Order 1 is b1 + b2 = 1, and then the
only condition of order 3 and 4 (theorem 1 of :mod:`glmref.prove.equations`; a conjugation
removes the one of order 4 that theorem 2 leaves) is

    4 R([oo]) = b1 b2 (1 + q^2) - b1^2 p - b2^2 r - 1/3 = 0.                                  (*)

*The family of section 3.2* has b1 = b2 and x2 = -x1, so p = r = -q = w: (*) reads w^2 - 2 w - 1/3
= 0, with the two solutions w = 1 - 2/sqrt(3) (method N, g < 0) and w = 1 + 2/sqrt(3) (method P, g
> 0). The growth parameter at -1 is b1 p + b2 r = w, not zero for either.

*No growth is impossible for every two-stage method of this kind.* Suppose b1 p + b2 r = 0. With y
= b2 r: b1 p = -y, b1 b2 q^2 = (b1 p)(b2 r) = -y^2, and (*) becomes ``y^2 + (b2 - b1) y + 1/3 - b1
b2 = 0``, with discriminant ``(b2 - b1)^2 - 4/3 + 4 b1 b2 = (b1 + b2)^2 - 4/3 = -1/3``: no real y.

The identity (*) is proved here by evaluating both sides exactly on a grid of more points in each
variable than its degree.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from ...errors import ExactnessError
from ...exact import Exact
from ...findings import Proof
from ...prove.enclosure import gaps_of
from .derivation import Derivation, Progress, Statement
from .sources import thesis_source

OPTIONS: Mapping[str, str] = {}

#: At least the degree of R([oo]) in each of b1, x1, x2: eta(o) has degree 1 in b1 and 2 in each x;
#: it is squared and multiplied by a weight, and zeta_1([o]) has no higher degree.
DEGREE = 5


def condition(b1: Fraction, x1: Fraction, x2: Fraction, g: int) -> Exact:
    """Return 4 R([oo]) of the two-stage method, from its tableau."""
    (residual,) = _residual(g)([Exact(b1), Exact(x1), Exact(x2)])
    return residual * 4


@cache
def _residual(g: int) -> Callable[[Sequence[Any]], list[Any]]:
    """Return R([oo]) in b1, x1 and x2."""
    return gaps_of(
        {
            "class": "sweep",
            "unknowns": {"b1": "", "x1": "", "x2": ""},
            "D": ["b1", "1-b1"],
            "X": [["1", "1"], ["x1", "x2"]],
            "V": [["1", "0"], ["0", "-1"]],
            "G": ["1", str(g)],
            "enclosure": {"equations": ["order [oo]"]},
        }
    )


def _check_identity(progress: Progress) -> None:
    """Prove (*) on a grid: two polynomials that agree there are equal.

    Raises
    ------
    ExactnessError
        When they differ, which would be an error of this module.
    """
    points = [Fraction(k) for k in range(-2, DEGREE - 1)]
    for k, b1 in enumerate(points):
        progress("identity", k, len(points))
        for x1 in points:
            for x2 in points:
                for g in (1, -1):
                    b2 = 1 - b1
                    p, q, r = g * x1 * x1, g * x1 * x2, g * x2 * x2
                    right = b1 * b2 * (1 + q * q) - b1**2 * p - b2**2 * r - Fraction(1, 3)
                    if condition(b1, x1, x2, g) != right:
                        raise ExactnessError(f"(*) fails at b1 = {b1}, x1 = {x1}, x2 = {x2}")


def _document(name: str, sign: str) -> dict[str, Any]:
    """Return N (sign ``-``) or P (sign ``+``) in the sweep form."""
    w = f"(3{sign}2*sqrt(3))/3"
    mu = f"1{sign}2/sqrt(3)"
    return {
        "format": "glmref-method-1",
        "name": name,
        "title": f"G-symplectic method {name[-1].upper()} of order 4 with two stages",
        "class": "sweep",
        "D": ["1/2", "1/2"],
        "X": [["1", "1"], ["1", "-1"]],
        "V": [["1", "0"], ["0", "-1"]],
        "G": [["1", "0"], ["0", w]],
        "claims": {
            "order": 4,
            "order-identity": 4,
            "stage-order": 2,
            "g-symplectic": True,
            "symmetric": True,
            "parasitism-free": False,
            "growth": [mu],
        },
        "source": thesis_source("section 3.2, equation (3.5) in the sweep form", "derived"),
    }


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Derive N and P and prove that no growth is impossible."""
    _check_identity(progress)
    documents = [_document("gsymplectic-n", "-"), _document("gsymplectic-p", "+")]
    root = Exact(3).sqrt()
    lines = []
    for name, w in (("N", 1 - 2 / root), ("P", 1 + 2 / root)):
        if w * w - 2 * w - Fraction(1, 3) != 0:  # pragma: no cover - elementary
            raise ExactnessError(f"{name} does not solve w^2 - 2 w - 1/3 = 0")
        lines.append(f"{name}: w = g x^2 = growth parameter at -1 = {float(w):.12g}, not zero")
    lines.append(
        "no growth would need y^2 + (b2 - b1) y + 1/3 - b1 b2 = 0, whose discriminant is "
        "(b1 + b2)^2 - 4/3 = -1/3: impossible with two stages and two values"
    )
    progress("done", 1, 1)
    return Derivation("two-stage", documents, [Statement(x, Proof.EXACT) for x in lines])
