"""Closed forms: guess one from digits, then prove it exactly or say that none was found.

A guess is made with integer relations (PSLQ, in mpmath); it counts only when exact arithmetic or
the interval test confirms it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from ..errors import ExactnessError
from ..exact import Ball, Exact
from ..exact.expression import parse, to_text

MAX_DENOMINATOR = 10**6


def _near_fraction(value: Any) -> Fraction:
    ball = value.ball() if isinstance(value, Exact) else value
    return Fraction(ball.decimal_text(60)).limit_denominator(MAX_DENOMINATOR)


def exact_text(value: Exact) -> str:
    """Write a real algebraic number shortly: rational, one square root, or the field's form.

    Raises
    ------
    ExactnessError
        When it has none of these forms.
    """
    near = _near_fraction(value)
    if value == near:
        return str(near)
    square = _near_fraction(value * value)
    if value * value == square:
        return root_text(square, negative=value.sign() < 0)
    guess = surd(value.ball(), digits=100)
    if guess is not None and parse(guess) == value:
        return guess
    return to_text(value)


def square_free(square: Fraction, below: int) -> tuple[int, int]:
    """Return n, m with square = n m^2/q^2, q its denominator; no square below ``below`` in n."""
    inside, outside, divisor = square.numerator * square.denominator, 1, 2
    while divisor * divisor <= inside and divisor < below:
        while inside % divisor**2 == 0:
            inside //= divisor**2
            outside *= divisor
        divisor += 1
    return inside, outside


def root_text(square: Fraction, *, negative: bool) -> str:
    """Return the text of +-sqrt(p/q) as k*sqrt(n)/m with n free of small squares."""
    inside, outside = square_free(square, 10_000)
    factor = Fraction(outside, square.denominator)
    text = f"sqrt({inside})" if inside != 1 else "1"
    if factor.numerator != 1:
        text = f"{factor.numerator}*{text}"
    if factor.denominator != 1:
        text = f"{text}/{factor.denominator}"
    return f"-{text}" if negative else text


def minimal_polynomial(
    value: Ball, *, degree: int = 8, digits: int = 70, height: int = 10**9
) -> list[int] | None:
    """Return the integer polynomial (constant last) of the digits, ``None`` where PSLQ finds none.

    A relation of degree d with coefficients of c digits is found by chance once (d + 1) c comes
    near the digits used; the search stops 12 digits before that.
    """
    import mpmath

    with mpmath.workdps(digits):
        x = value.to_mpf()
        tolerance = mpmath.mpf(10) ** -(digits - 8)
        for d in range(1, degree + 1):
            if (d + 1) * len(str(height)) > digits - 12:
                return None
            powers = [x**k for k in range(d + 1)]
            found = mpmath.pslq(powers, maxcoeff=height, maxsteps=10_000, tol=tolerance)
            if found is not None and found[d] != 0:
                sign = 1 if found[d] > 0 else -1
                return [sign * int(c) for c in reversed(found)]
    return None


def surd(value: Ball, *, digits: int = 70) -> str | None:
    """Return closed form by square roots of degree at most 4, or ``None``: a guess, not a proof.

    Rational, ``p + q sqrt(n)``, or ``sqrt`` of such a number.
    """
    if value.magnitude() < 10.0**-digits:
        return "0"
    for outer in (False, True):
        target = value * value if outer else value
        polynomial = minimal_polynomial(target, degree=2, digits=digits)
        if polynomial is None:
            continue
        text = _quadratic_text(polynomial, target)
        if not outer:
            return text
        return f"sqrt({text})" if float(value) > 0 else f"-sqrt({text})"
    return None


def _quadratic_text(polynomial: Sequence[int], value: Ball) -> str:
    """Return the text of the root of a polynomial of degree 1 or 2 that lies nearest to a value."""
    if len(polynomial) == 2:
        return str(Fraction(-polynomial[1], polynomial[0]))
    a, b, c = polynomial
    middle = Fraction(-b, 2 * a)
    half = Fraction(b * b - 4 * a * c, 4 * a * a)
    root = root_text(half, negative=float(value) < float(middle))
    if middle == 0:
        return root
    return f"{middle}{root}" if root.startswith("-") else f"{middle}+{root}"


def surds(values: Mapping[str, Ball], *, digits: int = 70) -> dict[str, str]:
    """Return closed forms of unknowns that have one (see :func:`surd`), checked in all digits."""
    found: dict[str, str] = {}
    for name, value in values.items():
        text = surd(value, digits=digits)
        if text is None:
            continue
        closed = parse(text)
        if not isinstance(closed, Exact):  # pragma: no cover - surd writes no decimals
            raise ExactnessError(f"{text!r} is not exact")
        if (closed.ball() - value).magnitude() < 10.0 ** -(digits - 5):
            found[name] = text
    return found
