"""What a printed number is worth: its proved distance from the truth, and from wrong results."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import isfinite
from typing import Any

from ..errors import DataError
from ..exact import Exact, ball
from ..exact.linalg import Matrix
from .faults import Wrong
from .numbers import decimals, upper_text

_WRONG_SHOWN = 17
#: A wrong result is kept when it is off by this many rounding errors of double precision.
_VISIBLE = 10**6


def distance(enclosed: Iterable[Any], printed: Iterable[str]) -> Fraction:
    """Return a proved bound of the distance between the true numbers and the printed ones."""
    return max(
        Fraction((ball(x) - Fraction(text)).magnitude())
        for x, text in zip(enclosed, printed, strict=True)
    )


def bound_of(enclosed: Any, printed: Any, doubt: Fraction = Fraction(0)) -> str:
    """Return the bound of a case: the largest distance of its numbers, rounded up to one digit.

    ``doubt`` is the largest radius of a coefficient, which a step may magnify a thousandfold.
    """
    gap = max(
        distance(row, texts)
        for part, shown in zip(enclosed, printed, strict=True)
        for row, texts in zip(part, shown, strict=True)
    )
    if gap > Fraction(1, 10**30) + 1000 * doubt:
        raise DataError(f"mpmath and the enclosure differ by {float(gap):g}")
    return upper_text(gap, 1)


def conserved_form(
    G: Matrix, C: Sequence[Sequence[Fraction]], rows: Sequence[Sequence[Fraction]]
) -> Any:
    """Enclose ``sum G_ij y_i^T C y_j``."""
    total: Any = Exact(0)
    for g_row, left in zip(G, rows, strict=True):
        for g, right in zip(g_row, rows, strict=True):
            value = sum(
                (a * c * b for a, c_row in zip(left, C, strict=True)
                 for c, b in zip(c_row, right, strict=True)),
                Fraction(0),
            )  # fmt: skip
            total = total + g.ball() * value
    return total


def add_wrong(
    case: dict[str, Any], found: Iterable[Wrong], right: Sequence[Sequence[str]] | None = None
) -> None:
    """Keep the wrong results that can be told from the right one and from each other.

    What is beyond double precision is left out: no integrator returns it.
    """
    shown_right: Any = case["output"] if right is None else right
    tolerance = _VISIBLE * Fraction(case["rounding"]) / 2**53
    kept: list[dict[str, Any]] = []
    for wrong in found:
        shown = decimals(wrong.values, _WRONG_SHOWN)
        finite = all(isfinite(float(x)) for row in shown for x in row)
        if finite and all(
            _apart(shown, other, tolerance) for other in (shown_right, *(x["output"] for x in kept))
        ):
            kept.append({"flag": wrong.flag, "output": shown})
    if kept:
        case["wrong"] = kept
        case["flags"] = list(dict.fromkeys(x["flag"] for x in kept))


def _apart(a: Sequence[Sequence[str]], b: Sequence[Sequence[str]], tolerance: Fraction) -> bool:
    return any(
        abs(Fraction(x) - Fraction(y)) > tolerance
        for row, other in zip(a, b, strict=True)
        for x, y in zip(row, other, strict=True)
    )
