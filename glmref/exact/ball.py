"""Complex balls: a midpoint, and a radius that is never lost."""

from __future__ import annotations

import operator
from fractions import Fraction
from functools import cache
from typing import Any

import flint

from ..errors import ExactnessError
from .field import BALL_BITS, Arithmetic, as_fmpq
from .number import Exact, exact

_NIL = flint.acb(0)
_new = object.__new__


@cache
def _last_place(digits: int, _precision: int) -> flint.arb:
    """Interval around zero: one unit of the last of so many places, at a working precision."""
    radius = flint.arb(flint.fmpq(1, 10**digits)).upper()
    return radius.union(-radius)


class Ball(Arithmetic):
    """A complex interval: a midpoint and a radius that is never lost in an operation."""

    __slots__ = ("_acb",)
    _acb: flint.acb

    @classmethod
    def _wrap(cls, value: flint.acb) -> Ball:
        self = _new(cls)
        self._acb = value
        return self

    @classmethod
    def decimal(cls, text: str, digits: int) -> Ball:
        """Ball of a published decimal, or of a fraction: radius one unit of the last place."""
        if any(x in text for x in "eE/"):
            value = as_fmpq(Fraction(text))
        else:  # the short way: most numbers of most files
            whole, _, places = text.partition(".")
            value = flint.fmpq(int(whole + places), 10 ** len(places))
        return cls._wrap(flint.acb(flint.arb(value) + _last_place(digits, flint.ctx.prec)))

    @classmethod
    def around(cls, midpoint: Ball, radius: Fraction) -> Ball:
        """Real ball with the midpoint of a given ball and a given radius."""
        spread = flint.arb(as_fmpq(radius)).upper()
        return cls._wrap(flint.acb(midpoint._acb.real.mid() + spread.union(-spread)))

    def _binary(self, other: object, operation: Any) -> Any:
        kind = type(other)
        if kind is Ball or kind is Exact:
            number = other.ball()._acb  # type: ignore[attr-defined]
        elif kind is int:
            number = other  # flint takes it exactly
        elif isinstance(other, int | Fraction) and kind is not bool:
            number = flint.acb(as_fmpq(other))
        else:
            return NotImplemented
        return Ball._wrap(operation(self._acb, number))

    # sums and products of two balls take a short way: proofs are made of millions of them

    def __add__(self, other: object) -> Any:
        if type(other) is not Ball:
            return self._binary(other, operator.add)
        result = _new(Ball)
        result._acb = self._acb + other._acb
        return result

    __radd__ = __add__

    def __sub__(self, other: object) -> Any:
        if type(other) is not Ball:
            return self._binary(other, operator.sub)
        result = _new(Ball)
        result._acb = self._acb - other._acb
        return result

    def __mul__(self, other: object) -> Any:
        if type(other) is not Ball:
            return self._binary(other, operator.mul)
        result = _new(Ball)
        result._acb = self._acb * other._acb
        return result

    __rmul__ = __mul__

    def is_zero(self) -> bool | None:
        """``False`` when zero is excluded, ``True`` for the exact zero, else ``None``."""
        if not self._acb.contains(_NIL):
            return False
        return True if self._acb == _NIL else None

    def vanishes(self) -> bool:
        """Whether it is the exact zero: ``is_zero() is True`` at a fraction of the cost."""
        return self._acb == _NIL

    def contains_zero(self) -> bool:
        """Whether zero lies in the ball."""
        return bool(self._acb.contains(_NIL))

    def contains(self, other: Ball | Exact | int | Fraction) -> bool:
        """Whether the whole of another number lies in this ball."""
        return bool(self._acb.contains(ball(other)._acb))

    def contains_interior(self, other: Ball) -> bool:
        """Whether a real ball lies in the interior of this real ball."""
        return bool(self._acb.real.contains_interior(other._acb.real))

    def overlaps(self, other: Ball | Exact | int | Fraction) -> bool:
        """Whether the two balls share a point."""
        return bool(self._acb.overlaps(ball(other)._acb))

    @property
    def real(self) -> Ball:
        """Real part."""
        return Ball._wrap(flint.acb(self._acb.real))

    @property
    def imag(self) -> Ball:
        """Imaginary part."""
        return Ball._wrap(flint.acb(self._acb.imag))

    def conjugate(self) -> Ball:
        """Complex conjugate."""
        return Ball._wrap(flint.acb(self._acb.real, -self._acb.imag))

    def is_real(self) -> bool:
        """Whether the imaginary part is the exact zero."""
        return bool(self._acb.imag == 0)

    def sqrt(self) -> Ball:
        """Principal square root."""
        if self.is_real() and not self._acb.real < 0:
            return Ball._wrap(flint.acb(self._acb.real.sqrt()))
        return Ball._wrap(self._acb.sqrt())

    def root(self, degree: int) -> Ball:
        """Positive root of a positive ball."""
        return Ball._wrap(flint.acb(self._acb.real.root(degree)))

    def sign(self) -> int:
        """Return -1 or 1 where the whole ball has that sign, 0 only for the exact zero.

        Raises
        ------
        ExactnessError
            When the ball contains zero, so that the sign is not known.
        """
        part = self._acb.real
        if part > 0:
            return 1
        if part < 0:
            return -1
        if part == 0:
            return 0
        raise ExactnessError(f"the ball {self!r} contains zero: its sign is not known")

    def midpoint(self) -> Ball:
        """The midpoint as a ball of radius zero."""
        return Ball._wrap(flint.acb(self._acb.real.mid(), self._acb.imag.mid()))

    def radius(self) -> float:
        """Upper bound of the distance from the midpoint, as a float."""
        return max(float(self._acb.real.rad().upper()), float(self._acb.imag.rad().upper()))

    def magnitude(self) -> float:
        """Upper bound of the absolute value, as a float."""
        return float(self._acb.abs_upper())

    def lower_magnitude(self) -> float:
        """Lower bound of the absolute value, as a float."""
        return float(self._acb.abs_lower())

    def ball(self, bits: int = BALL_BITS) -> Ball:
        """Return the ball itself (``bits`` is there for symmetry with :class:`Exact`)."""
        return self

    def decimal_text(self, digits: int) -> str:
        """Midpoint of the real part as a decimal with ``digits`` significant digits."""
        return self._acb.real.mid().str(digits, radius=False)

    def to_mpf(self) -> Any:
        """Round the midpoint to mpmath's current working precision."""
        import mpmath

        def part(x: flint.arb) -> Any:
            mantissa, exponent = x.mid().man_exp()
            return mpmath.ldexp(mpmath.mpf(int(mantissa)), int(exponent))

        if self.is_real():
            return part(self._acb.real)
        return mpmath.mpc(part(self._acb.real), part(self._acb.imag))

    def __complex__(self) -> complex:
        return complex(float(self._acb.real.mid()), float(self._acb.imag.mid()))

    def __float__(self) -> float:
        if not self.is_real():
            raise ExactnessError(f"a complex ball has no float value: {self!r}")
        return float(self._acb.real.mid())

    def __repr__(self) -> str:
        return f"Ball({self._acb.str(20)})"


def ball(value: int | Fraction | Exact | Ball) -> Ball:
    """Turn any number of this module into a :class:`Ball`."""
    return value if isinstance(value, Ball) else exact(value).ball()
