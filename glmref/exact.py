"""Exact numbers: a thin wrapper over python-flint; the only module that imports it.

Two number types share one set of operations, so that the theory is written once:

* :class:`Exact`, an algebraic number (real or complex). Zero is decidable; there is no tolerance.
* :class:`Ball`, a complex interval of :data:`BALL_BITS` bits, for published decimals and for
  enclosures. ``is_zero`` is ``False`` when zero is excluded and ``None`` when it is not.

Mixing the two gives a ball. A Python int or Fraction mixes with both; a float never does.
Reading and writing the text form is the business of :mod:`glmref.expression`.
"""

from __future__ import annotations

import operator
import re
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from flint.types import _gr  # pyright: ignore[reportAttributeAccessIssue]

from .claims import ExactnessError

__all__ = ["BALL_BITS", "Ball", "Exact", "Scalar", "ball", "exact", "root_of_unity"]

#: Working precision of balls, in bits: 75 published digits and their proofs fit several times over.
BALL_BITS = 512

#: Sign and magnitude of a nonzero number are found by doubling the precision up to this many bits.
_MAX_BITS = 1 << 16

_FIELD = _gr.gr_complex_algebraic_ca_ctx.new()
_MINIMAL = _gr.gr_complex_qqbar_ctx.new()  # the same numbers by their minimal polynomials
_TERM = re.compile(r"(?P<sign>[+-]?)(?:(?P<c>\d+)\*?)?(?P<a>a(?:\^(?P<n>\d+))?)?")
_NUMBER = r"(?:\[[^\]]*\]|[-+]?[0-9][0-9.]*(?:e[-+]?[0-9]+)?)"
_BALL_TEXT = re.compile(
    # the lookahead keeps a purely imaginary number from being split into a real part and the rest
    rf"\(?(?:(?P<re>{_NUMBER})(?=\)?$| [+-] ))?(?:(?P<sign> [+-] )?(?P<im>{_NUMBER})\*I)?\)?$",
)
_RATIONAL_TEXT = re.compile(r"\{(-?\d+(?:/\d+)?)\}$|^(-?\d+)$")

flint.ctx.prec = BALL_BITS


@lru_cache(maxsize=32)
def _ball_field(bits: int) -> Any:
    return _gr.gr_complex_acb_ctx.new(bits)


def _enclose(value: Any, bits: int) -> flint.acb:
    """Return a ball of the working precision around an element of the algebraic field."""
    text = repr(_ball_field(bits)(value))
    match = _BALL_TEXT.match(text)
    if match is None:  # pragma: no cover - a change in flint's printing would show here
        raise ExactnessError(f"flint printed a ball as {text!r}, which is not understood")
    imaginary = flint.arb(match["im"] or 0)
    if match["sign"] == " - ":
        imaginary = -imaginary
    return flint.acb(flint.arb(match["re"] or 0), imaginary)


class _Arithmetic:
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
        result: Any = Exact(1)
        for _ in range(exponent):
            result = result * self
        return result


class Exact(_Arithmetic):
    """An algebraic number with decidable zero.

    Args:
        value: an int, a Fraction, or (internally) an element of flint's algebraic field.

    Raises
    ------
        ExactnessError: for a float or any other type whose value is not exact.
    """

    __slots__ = ("_gr", "_q")
    _q: flint.fmpq | None
    _gr: Any

    def __init__(self, value: int | Fraction | flint.fmpq | Exact = 0) -> None:
        if isinstance(value, Exact):
            self._q, self._gr = value._q, value._gr
        elif isinstance(value, bool) or not isinstance(value, int | Fraction | flint.fmpq):
            raise ExactnessError(
                f"an exact number must be an integer, a Fraction or an expression string, "
                f"got {value!r} of type {type(value).__name__}"
            )
        else:
            self._q = _as_fmpq(value)
            self._gr = None

    @classmethod
    def _wrap(cls, element: Any) -> Exact:
        """Wrap a field element; whether it is rational is found only when asked: `_settle`."""
        self = cls.__new__(cls)
        self._q, self._gr = None, element
        return self

    def _settle(self) -> None:
        """Notice a rational value. It costs a printing, ten operations: never in arithmetic."""
        if self._q is None:
            match = _RATIONAL_TEXT.search(repr(self._gr))
            if match is not None:
                numerator, _, denominator = (match[1] or match[2]).partition("/")
                self._q = flint.fmpq(int(numerator), int(denominator or 1))

    @property
    def _element(self) -> Any:
        if self._gr is None:
            self._gr = _FIELD(self._q)
        return self._gr

    def _binary(self, other: object, operation: Any) -> Any:
        if not isinstance(other, Exact):
            if isinstance(other, bool) or not isinstance(other, int | Fraction):
                return NotImplemented
            other = Exact(other)
        if self._q is not None and other._q is not None:
            result = Exact.__new__(Exact)
            result._q, result._gr = operation(self._q, other._q), None
            return result
        try:
            return Exact._wrap(operation(self._element, other._element))
        except AssertionError:  # flint's way to say that there is no quotient
            raise ZeroDivisionError("division by an exact zero") from None

    def __truediv__(self, other: object) -> Any:
        if isinstance(other, Exact) and other._q is None:
            return self * other._reciprocal()
        return self._binary(other, operator.truediv)

    def __rtruediv__(self, other: object) -> Any:
        if isinstance(other, int | Fraction) and not isinstance(other, bool):
            return Exact(other) * self._reciprocal()
        return NotImplemented

    def _reciprocal(self) -> Exact:
        """1/x as a polynomial in the roots, never a fraction of two.

        flint does not clear roots from denominators of fields with several of them; such fractions
        grow until zero cannot be decided. From the minimal polynomial p of x,
        ``1/x = -(p(x) - p(0)) / (x p(0))``.

        Raises
        ------
            ZeroDivisionError: for zero.
        """
        plain = Exact(1)._binary(self, operator.truediv)
        if not re.search("[a-z]", repr(plain._element).partition(" where ")[0].partition("/")[2]):
            return plain
        try:
            text = repr(_MINIMAL(self._element)).partition(" of ")[2]
        except AssertionError:  # the degree is beyond what flint converts
            return plain
        coefficients: dict[int, int] = {}
        for term in _TERM.finditer(text):
            if term[0]:
                degree = int(term["n"] or 1) if term["a"] else 0
                coefficients[degree] = int(term["sign"] + (term["c"] or "1"))
        if 0 not in coefficients:  # a printed form that is not understood
            return plain
        value = Exact(0)
        for degree in range(max(coefficients), 0, -1):
            value = value * self + coefficients.get(degree, 0)
        return value * Fraction(-1, coefficients[0])

    def is_zero(self) -> bool:
        """Decide whether this number is zero, exactly.

        Raises
        ------
            ExactnessError: when flint cannot decide (never seen for the degrees met here).
        """
        if self._q is not None:
            return self._q == 0
        answer = self._gr.is_zero()
        if answer is None:
            raise ExactnessError(f"flint could not decide whether {self!r} is zero")
        return bool(answer)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Exact | int | Fraction) and not isinstance(other, bool):
            return (self - other).is_zero()
        return NotImplemented

    __hash__ = None  # type: ignore[assignment]  # equal numbers may have unequal representations

    def __bool__(self) -> bool:
        return not self.is_zero()

    @property
    def real(self) -> Exact:
        """Real part."""
        if self._q is not None:
            return self
        # flint's own Re() is a new generator of the field, on which zero may stay undecided
        element = self._element
        return Exact._wrap((element + element.conjugate()) / 2)

    @property
    def imag(self) -> Exact:
        """Imaginary part."""
        if self._q is not None:
            return Exact(0)
        element = self._element
        return Exact._wrap((element - element.conjugate()) / (2 * _FIELD(-1).sqrt()))

    def conjugate(self) -> Exact:
        """Complex conjugate."""
        return self if self._q is not None else Exact._wrap(self._element.conjugate())

    def is_real(self) -> bool:
        """Decide whether the imaginary part is zero."""
        return self._q is not None or self.imag.is_zero()

    def sqrt(self) -> Exact:
        """Principal square root."""
        return Exact._wrap(self._element.sqrt())

    def root(self, degree: int) -> Exact:
        """Positive root of a positive number."""
        return Exact._wrap(self._element ** flint.fmpq(1, degree))

    def as_fraction(self) -> Fraction | None:
        """Return the value as a Fraction, or ``None`` when it is irrational."""
        self._settle()
        if self._q is None:
            return None
        return Fraction(int(self._q.p), int(self._q.q))

    def sign(self) -> int:
        """Return -1, 0 or 1.

        Raises
        ------
            ExactnessError: for a number that is not real.
        """
        if self.is_zero():
            return 0
        if not self.is_real():
            raise ExactnessError(f"only a real number has a sign, got {self!r}")
        bits = 64
        while bits <= _MAX_BITS:
            part = _enclose(self._element, bits).real
            if part > 0:
                return 1
            if part < 0:
                return -1
            bits *= 2
        raise ExactnessError(f"the sign of {self!r} needs more than {_MAX_BITS} bits")

    def ball(self, bits: int = BALL_BITS) -> Ball:
        """Return a ball that contains this number, of relative width about ``2**-bits``."""
        if self._q is not None and bits == BALL_BITS:
            return Ball._wrap(flint.acb(self._q))
        enclosed = _enclose(self._element, bits)
        if not enclosed.imag == 0 and self.is_real():  # a real number written with roots of unity
            enclosed = flint.acb(enclosed.real)
        return Ball._wrap(enclosed)

    def to_mpf(self) -> Any:
        """Return the mpmath number nearest in its current working precision."""
        return self.ball().to_mpf()

    def __complex__(self) -> complex:
        return complex(self.ball())

    def __float__(self) -> float:
        if not self.is_real():
            raise ExactnessError(f"a complex number has no float value: {self!r}")
        return float(self.ball())

    def magnitude(self) -> float:
        """Absolute value as a float, for residuals and reports."""
        return abs(complex(self))

    def description(self) -> str:
        """Return flint's own text: a value and the field it lives in."""
        return repr(self._element)

    def __repr__(self) -> str:
        return f"Exact({self._q})" if self._q is not None else f"Exact<{self.description()}>"


class Ball(_Arithmetic):
    """A complex interval: a midpoint and a radius that is never lost in an operation."""

    __slots__ = ("_acb",)
    _acb: flint.acb

    @classmethod
    def _wrap(cls, value: flint.acb) -> Ball:
        self = cls.__new__(cls)
        self._acb = value
        return self

    @classmethod
    def decimal(cls, text: str, digits: int) -> Ball:
        """Ball of a published decimal: radius one unit of the last of ``digits`` places."""
        radius = flint.arb(flint.fmpq(1, 10**digits)).upper()
        midpoint = flint.arb(_as_fmpq(Fraction(text)))
        return cls._wrap(flint.acb(midpoint + radius.union(-radius)))

    @classmethod
    def around(cls, midpoint: Ball, radius: Fraction) -> Ball:
        """Real ball with the midpoint of a given ball and a given radius."""
        spread = flint.arb(_as_fmpq(radius)).upper()
        return cls._wrap(flint.acb(midpoint._acb.real.mid() + spread.union(-spread)))

    def _binary(self, other: object, operation: Any) -> Any:
        if isinstance(other, Ball):
            return Ball._wrap(operation(self._acb, other._acb))
        if isinstance(other, Exact):
            return Ball._wrap(operation(self._acb, other.ball()._acb))
        if isinstance(other, int | Fraction) and not isinstance(other, bool):
            return Ball._wrap(operation(self._acb, flint.acb(_as_fmpq(other))))
        return NotImplemented

    def is_zero(self) -> bool | None:
        """``False`` when zero is excluded, ``True`` for the exact zero, else ``None``."""
        if not self._acb.contains(0):
            return False
        return True if self._acb == 0 else None

    def contains_zero(self) -> bool:
        """Whether zero lies in the ball."""
        return bool(self._acb.contains(0))

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
            ExactnessError: when the ball contains zero, so that the sign is not known.
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


Scalar = Exact | Ball


def exact(value: int | Fraction | Exact) -> Exact:
    """Turn an int or a Fraction into an :class:`Exact`; pass an Exact through."""
    return value if isinstance(value, Exact) else Exact(value)


def ball(value: int | Fraction | Scalar) -> Ball:
    """Turn any number of this module into a :class:`Ball`."""
    return value if isinstance(value, Ball) else exact(value).ball()


@lru_cache(maxsize=256)
def root_of_unity(numerator: int, denominator: int) -> Exact:
    """Return exp(2 pi i numerator / denominator).

    Denominators 1, 2, 3, 4, 6, 8 and 12 come in square roots, so that they share a field with the
    tableaux they are used with; others as a power of -1.
    """
    turn = Fraction(numerator, denominator) % 1
    half, i = Exact(Fraction(1, 2)), Exact(-1).sqrt()
    first = {
        1: Exact(1),
        2: Exact(-1),
        3: (i * Exact(3).sqrt() - 1) * half,
        4: i,
        6: (i * Exact(3).sqrt() + 1) * half,
        8: (i + 1) * Exact(2).sqrt() * half,
        12: (i + Exact(3).sqrt()) * half,
    }.get(turn.denominator)
    if first is not None:
        return first**turn.numerator
    return Exact._wrap(_FIELD(-1) ** flint.fmpq(2 * turn.numerator, turn.denominator))


def _as_fmpq(value: int | Fraction | flint.fmpq) -> flint.fmpq:
    if isinstance(value, Fraction):
        return flint.fmpq(value.numerator, value.denominator)
    return flint.fmpq(value)
