"""flint's field of algebraic numbers, its balls, and the operators both number types share."""

from __future__ import annotations

import operator
import re
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from flint.types import _gr  # pyright: ignore[reportAttributeAccessIssue]

from ..errors import ExactnessError, UndecidedError

#: Working precision of balls, in bits: 75 published digits and their proofs fit several times over.
BALL_BITS = 512

#: Sign and magnitude of a nonzero number are found by doubling the precision up to this many bits.
MAX_BITS = 1 << 16

#: Versions of the library that computes: of its Python package and of its own.
LIBRARY = f"python-flint {flint.__version__}, FLINT {flint.__FLINT_VERSION__}"

FIELD = _gr.gr_complex_algebraic_ca_ctx.new()
MINIMAL = _gr.gr_complex_qqbar_ctx.new()  # the same numbers by their minimal polynomials
TERM = re.compile(r"(?P<sign>[+-]?)(?:(?P<c>\d+)\*?)?(?P<a>a(?:\^(?P<n>\d+))?)?")
_NUMBER = r"(?:\[[^\]]*\]|[-+]?[0-9][0-9.]*(?:e[-+]?[0-9]+)?)"
_BALL_TEXT = re.compile(
    # the lookahead keeps a purely imaginary number from being split into a real part and the rest
    rf"\(?(?:(?P<re>{_NUMBER})(?=\)?$| [+-] ))?(?:(?P<sign> [+-] )?(?P<im>{_NUMBER})\*I)?\)?$",
)
RATIONAL_TEXT = re.compile(r"\{(-?\d+(?:/\d+)?)\}$|^(-?\d+)$")

flint.ctx.prec = BALL_BITS


@lru_cache(maxsize=32)
def _ball_field(bits: int) -> Any:
    return _gr.gr_complex_acb_ctx.new(bits)


def enclose(value: Any, bits: int) -> flint.acb:
    """Return a ball of the working precision around an element of the algebraic field.

    flint works with 4096 bits at the most, or twice those asked for; a quotient whose denominator
    needs more for a size is computed again with more.

    Raises
    ------
    UndecidedError
        When :data:`MAX_BITS` do not suffice.
    """
    text = repr(_ball_field(bits)(value))
    if "nan" in text:
        if bits >= MAX_BITS:
            raise UndecidedError(f"the size of a quotient needs more than {MAX_BITS} bits")
        return enclose(value, 2 * bits)
    match = _BALL_TEXT.match(text)
    if match is None:  # pragma: no cover - a change in flint's printing would show here
        raise ExactnessError(f"flint printed a ball as {text!r}, which is not understood")
    imaginary = flint.arb(match["im"] or 0)
    if match["sign"] == " - ":
        imaginary = -imaginary
    return flint.acb(flint.arb(match["re"] or 0), imaginary)


class Arithmetic:
    """The operators, for both number types, in terms of ``_binary(other, operation)``."""

    __slots__ = ()

    def _binary(self, other: object, operation: Any) -> Any:
        raise NotImplementedError

    def __add__(self, other: object) -> Any:
        return self._binary(other, operator.add)

    __radd__ = __add__

    def __sub__(self, other: object) -> Any:
        return self._binary(other, operator.sub)

    def __rsub__(self, other: object) -> Any:
        return self._binary(other, lambda a, b: b - a)

    def __mul__(self, other: object) -> Any:
        return self._binary(other, operator.mul)

    __rmul__ = __mul__

    def __truediv__(self, other: object) -> Any:
        return self._binary(other, operator.truediv)

    def __rtruediv__(self, other: object) -> Any:
        return self._binary(other, lambda a, b: b / a)

    def __neg__(self) -> Any:
        return self * -1

    def __pos__(self) -> Any:
        return self

    def __pow__(self, exponent: int) -> Any:
        if exponent < 0:
            return 1 / self ** (-exponent)
        result: Any = self * 0 + 1
        for _ in range(exponent):
            result = result * self
        return result


def as_fmpq(value: int | Fraction | flint.fmpq) -> flint.fmpq:
    """Convert to flint's rational type."""
    if type(value) is not int and isinstance(value, Fraction):
        return flint.fmpq(value.numerator, value.denominator)
    return flint.fmpq(value)
