"""The two types of numbers: algebraic ones with decidable zero, and complex balls."""

from __future__ import annotations

import operator
import re
from collections.abc import Sequence
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any, ClassVar

import flint

from ..errors import ExactnessError, UndecidedError
from ..system.budget import spend
from .field import (
    BALL_BITS,
    FIELD,
    MAX_BITS,
    MINIMAL,
    RATIONAL_TEXT,
    TERM,
    Arithmetic,
    as_fmpq,
    enclose,
)
from .roots import MAX_TEXT, BeyondError, Roots, roots_of

_NIL = flint.acb(0)
_new = object.__new__
_RATIONAL = (int, Fraction)
_FOREIGN = (Arithmetic, bool)  # numbers that take part by their own operators, or not at all
LONG_RADICAND = 64  # bits; none of fewer than 122 was seen to keep flint


@cache
def _last_place(digits: int, _precision: int) -> flint.arb:
    """Return an interval around zero: one unit of the last place, at a working precision."""
    radius = flint.arb(flint.fmpq(1, 10**digits)).upper()
    return radius.union(-radius)


class Ball(Arithmetic):
    """A complex interval: a midpoint and a radius that is never lost in an operation."""

    __slots__ = ("_acb",)
    _acb: flint.acb

    @classmethod
    def of_real(cls, value: flint.arb) -> Ball:
        """Return a real ball of FLINT as a number."""
        return cls._wrap(flint.acb(value))

    @classmethod
    def of_parts(cls, real: flint.arb, imag: flint.arb) -> Ball:
        """Return the ball with these real balls of FLINT as parts."""
        return cls._wrap(flint.acb(real, imag))

    def parts(self) -> tuple[flint.arb, flint.arb]:
        """Return the real and the imaginary part as balls of FLINT."""
        return self._acb.real, self._acb.imag

    @classmethod
    def _wrap(cls, value: flint.acb) -> Ball:
        self = _new(cls)
        self._acb = value
        return self

    @classmethod
    def decimal(cls, text: str, digits: int) -> Ball:
        """Return the ball of a published decimal, or of a fraction: radius 1 in the last place."""
        if any(x in text for x in "eE/"):
            value = as_fmpq(Fraction(text))
        else:  # the short way: most numbers of most files
            whole, _, places = text.partition(".")
            value = flint.fmpq(int(whole + places), 10 ** len(places))
        return cls._wrap(flint.acb(flint.arb(value) + _last_place(digits, flint.ctx.prec)))

    @classmethod
    def around(cls, midpoint: Ball, radius: Fraction) -> Ball:
        """Return a real ball with the midpoint of a given ball and a given radius."""
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
        """Return ``False`` when zero is excluded, ``True`` for the exact zero, else ``None``."""
        if not self._acb.contains(_NIL):
            return False
        return True if self._acb == _NIL else None

    def vanishes(self) -> bool:
        """Return whether it is the exact zero: ``is_zero() is True`` at a fraction of the cost."""
        return self._acb == _NIL

    def contains_zero(self) -> bool:
        """Return whether zero lies in the ball."""
        return bool(self._acb.contains(_NIL))

    def contains(self, other: Ball | Exact | int | Fraction) -> bool:
        """Return whether the whole of another number lies in this ball."""
        return bool(self._acb.contains(ball(other)._acb))

    def contains_interior(self, other: Ball) -> bool:
        """Return whether a real ball lies in the interior of this real ball."""
        return bool(self._acb.real.contains_interior(other._acb.real))

    def overlaps(self, other: Ball | Exact | int | Fraction) -> bool:
        """Return whether the two balls share a point."""
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
        """Return the complex conjugate."""
        return Ball._wrap(flint.acb(self._acb.real, -self._acb.imag))

    def is_real(self) -> bool:
        """Return whether the imaginary part is the exact zero."""
        return bool(self._acb.imag == 0)

    def sqrt(self) -> Ball:
        """Return the principal square root."""
        if self.is_real() and not self._acb.real < 0:
            return Ball._wrap(flint.acb(self._acb.real.sqrt()))
        return Ball._wrap(self._acb.sqrt())

    def root(self, degree: int) -> Ball:
        """Return the positive root of a positive ball."""
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
        """Return the midpoint as a ball of radius zero."""
        return Ball._wrap(flint.acb(self._acb.real.mid(), self._acb.imag.mid()))

    def radius(self) -> float:
        """Return an upper bound of the distance from the midpoint, as a float."""
        return max(float(self._acb.real.rad().upper()), float(self._acb.imag.rad().upper()))

    def magnitude(self) -> float:
        """Return an upper bound of the absolute value, as a float."""
        return float(self._acb.abs_upper())

    def lower_magnitude(self) -> float:
        """Return a lower bound of the absolute value, as a float."""
        return float(self._acb.abs_lower())

    def ball(self, bits: int = BALL_BITS) -> Ball:
        """Return the ball itself (``bits`` is there for symmetry with :class:`Exact`)."""
        return self

    def decimal_text(self, digits: int) -> str:
        """Return the midpoint of the real part as a decimal with ``digits`` significant digits."""
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


class Exact(Arithmetic):
    """An algebraic number with decidable zero.

    Parameters
    ----------
    value : int or Fraction or flint.fmpq or Exact
        An int, a Fraction, or (internally) an element of flint's algebraic field.

    Raises
    ------
    ExactnessError
        For a float or any other type whose value is not exact.
    """

    __slots__ = ("_ball", "_gr", "_q", "_roots")
    _q: flint.fmpq | None
    _gr: Any
    _roots: Roots | bool | None  # as one made of roots; ``False`` where that was not asked yet
    _ball: Ball | None  # of the working precision, once it was requested

    def __init__(self, value: int | Fraction | flint.fmpq | Exact = 0) -> None:
        self._ball, self._roots = None, False
        if type(value) is int:
            self._q, self._gr = flint.fmpq(value), None
        elif isinstance(value, Exact):
            self._q, self._gr, self._roots = value._q, value._gr, value._roots
        elif isinstance(value, bool) or not isinstance(value, int | Fraction | flint.fmpq):
            raise ExactnessError(
                f"an exact number must be an integer, a Fraction or an expression string, "
                f"got {value!r} of type {type(value).__name__}"
            )
        else:
            self._q = as_fmpq(value)
            self._gr = None

    @classmethod
    def _wrap(cls, element: Any) -> Exact:
        """Wrap a field element; whether it is rational is found only when asked: `_settle`."""
        self = _new(cls)
        self._q, self._gr, self._ball, self._roots = None, element, None, False
        return self

    @classmethod
    def _made(cls, roots: Roots) -> Exact:
        """Wrap a number made of roots; flint's element is made on request."""
        q = roots.as_rational()
        if q is not None:
            return cls._of(q)
        self = _new(cls)
        self._q, self._gr, self._ball, self._roots = None, None, None, roots
        return self

    @classmethod
    def _of(cls, value: flint.fmpq) -> Exact:
        """Wrap a rational."""
        self = _new(cls)
        self._q, self._gr, self._ball, self._roots = value, None, None, False
        return self

    def _settle(self) -> None:
        """Notice a rational value. It costs a printing, ten operations: never in arithmetic."""
        if self._q is None and not self._roots:
            match = RATIONAL_TEXT.search(repr(self._gr))
            if match is not None:
                numerator, _, denominator = (match[1] or match[2]).partition("/")
                # flint reads the digits: int() refuses more than 4300 of them
                self._q = flint.fmpq(flint.fmpz(numerator), flint.fmpz(denominator or "1"))
                self._ball = None

    @property
    def _element(self) -> Any:
        if self._gr is None:
            self._gr = self._roots.element() if isinstance(self._roots, Roots) else FIELD(self._q)
        return self._gr

    def _as_roots(self) -> Roots | None:
        """Return the number as one made of roots, where it is one."""
        if isinstance(self._roots, bool):
            self._roots = roots_of(repr(self._gr)) if self._q is None else Roots.rational(self._q)
        return self._roots

    def _among_roots(self, other: Exact, operation: Any) -> Exact | None:
        """Return the operation among numbers made of roots, where one of them is kept so."""
        if not (isinstance(self._roots, Roots) and self._q is None) and not (
            isinstance(other._roots, Roots) and other._q is None
        ):
            return None
        first, second = self._as_roots(), other._as_roots()
        if first is None or second is None:
            return None
        try:
            if operation is operator.truediv:
                return Exact._made(first * second.inverse())
            return Exact._made(operation(first, second))
        except BeyondError:
            return None

    def _binary(self, other: object, operation: Any) -> Any:
        if not isinstance(other, Exact):
            if isinstance(other, _FOREIGN) or not isinstance(other, _RATIONAL):
                return NotImplemented
            other = Exact(other)
        if self._q is not None and other._q is not None:
            return Exact._of(operation(self._q, other._q))
        spend()
        found = self._among_roots(other, operation)
        if found is not None:
            return found
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
        """Return 1/x as a polynomial in the roots, never a fraction of two.

        flint does not clear roots from denominators of fields with several of them; such fractions
        grow until zero cannot be decided. From the minimal polynomial p of x,
        ``1/x = -(p(x) - p(0)) / (x p(0))``.

        Raises
        ------
        ZeroDivisionError
            For zero.
        """
        plain = Exact(1)._binary(self, operator.truediv)
        if isinstance(plain._roots, Roots):
            return plain
        if not re.search("[a-z]", repr(plain._element).partition(" where ")[0].partition("/")[2]):
            return plain
        if len(repr(self._element)) > MAX_TEXT:
            return plain  # of a degree beyond what flint converts, which it finds out in hours
        try:
            text = repr(MINIMAL(self._element)).partition(" of ")[2]
            coefficients: dict[int, int] = {}
            for term in TERM.finditer(text):
                if term[0]:
                    degree = int(term["n"] or 1) if term["a"] else 0
                    coefficients[degree] = int(term["sign"] + (term["c"] or "1"))
        except (AssertionError, ValueError):
            # the degree is beyond what flint converts, or the digits beyond what Python does
            return plain
        if 0 not in coefficients:  # a printed form that is not understood
            return plain
        value = Exact(0)
        for degree in range(max(coefficients), 0, -1):
            value = value * self + coefficients.get(degree, 0)
        return value * Fraction(-1, coefficients[0])

    def __copy__(self) -> Exact:
        return self

    def __deepcopy__(self, memo: object) -> Exact:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """Send a rational to another process, without its ball."""
        if self._q is None:
            raise TypeError(f"{self!r} cannot leave its process: send its text")
        return Exact, (Fraction(int(self._q.p), int(self._q.q)),)

    def is_zero(self) -> bool:
        """Decide whether this number is zero, exactly.

        Raises
        ------
        UndecidedError
            When flint cannot decide, as among many roots of unity.
        """
        if self._q is not None:
            return not self._q
        if isinstance(self._roots, Roots):
            return not self._roots.terms
        spend()
        answer = self._gr.is_zero()
        if answer is None:
            roots = self._as_roots()
            answer = None if roots is None else not roots.terms
        if answer is None:
            raise UndecidedError(f"flint could not decide whether {self._brief()} is zero")
        return bool(answer)

    vanishes = is_zero

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Exact | int | Fraction) and not isinstance(other, bool):
            return (self - other).is_zero()
        return NotImplemented

    __hash__: ClassVar[None] = None  # type: ignore[assignment]  # equal numbers may have unequal representations

    def __bool__(self) -> bool:
        return not self.is_zero()

    @property
    def real(self) -> Exact:
        """Real part."""
        # flint's own Re() is a new generator of the field, on which zero may stay undecided
        other = self.conjugate()
        return self if other is self else (self + other) * Fraction(1, 2)

    @property
    def imag(self) -> Exact:
        """Imaginary part."""
        other = self.conjugate()
        if other is self:
            return Exact(0)
        if isinstance(self._roots, Roots):
            turned = Exact._made(Roots.of_unity(Fraction(-1, 4)))
            return (self - other) * turned * Fraction(1, 2)
        return Exact._wrap((self._element - other._element) / (2 * FIELD(-1).sqrt()))

    def conjugate(self) -> Exact:
        """Return the complex conjugate; a number that is shown to be real is returned itself.

        flint's ball is an enclosure (`ca_get_acb`), so that an imaginary part of exactly zero
        proves that the number is real. That of a real number with complex generators, as
        ``sqrt(2+i) sqrt(2-i)``, surrounds zero and proves nothing. flint then asks the minimal
        polynomial, which may take hours; a number made of roots decides at once.
        """
        if self._q is not None:
            return self
        if isinstance(self._roots, Roots):
            return Exact._made(self._roots.conjugate())
        part = enclose(self._gr, 64).imag
        if part.is_zero():
            return self
        if part.contains(0):
            roots = roots_of(repr(self._gr))
            if roots is not None and not (roots - roots.conjugate()).terms:
                return self
        return Exact._wrap(self._gr.conjugate())

    def is_real(self) -> bool:
        """Decide whether the imaginary part is zero."""
        return self._q is not None or self.imag.is_zero()

    def sqrt(self) -> Exact:
        """Return the principal square root."""
        found = Exact._wrap(self._element.sqrt())
        size = 0 if self._q is None else int(self._q.p).bit_length() + int(self._q.q).bit_length()
        if size > LONG_RADICAND:
            # flint keeps the sharpest ball of a generator. It refines a coarse one without end
            # (arb_fmpz_poly_refine_root_arb) where the root is next to a short dyadic number
            enclose(found._element, 4 * size)
        return found

    def root(self, degree: int) -> Exact:
        """Return the positive root of a positive number."""
        if self._q is not None and degree == 2:
            return self.sqrt()
        part = flint.fmpq(1, degree)
        if self._q is not None:
            # by its minimal polynomial: the powers of a power are not reduced, and numbers grow
            # until a division takes seconds and zero cannot be decided
            return Exact._wrap(FIELD(MINIMAL(self._q) ** part))
        return Exact._wrap(self._element**part)

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
        ExactnessError
            For a number that is not real.
        """
        if self.is_zero():
            return 0
        if not self.is_real():
            raise ExactnessError(f"only a real number has a sign, got {self._brief()}")
        bits = 64
        while bits <= MAX_BITS:
            part = self._acb(bits).real
            if part > 0:
                return 1
            if part < 0:
                return -1
            bits *= 2
        raise UndecidedError(f"the sign of {self._brief()} needs more than {MAX_BITS} bits")

    def ball(self, bits: int = BALL_BITS) -> Ball:
        """Return a ball that contains this number, of relative width about ``2**-bits``."""
        if bits == BALL_BITS:
            if self._ball is None:
                self._ball = self._enclosed(bits)
            return self._ball
        return self._enclosed(bits)

    def _enclosed(self, bits: int) -> Ball:
        if self._q is not None and bits == BALL_BITS:
            return Ball._wrap(flint.acb(self._q))
        enclosed = self._acb(bits)
        if not enclosed.imag.is_zero() and self.is_real():  # written with roots of unity
            enclosed = flint.acb(enclosed.real)
        return Ball._wrap(enclosed)

    def _acb(self, bits: int) -> flint.acb:
        if isinstance(self._roots, Roots) and self._q is None:
            return self._roots.enclosed(bits)
        return enclose(self._element, bits)

    def to_mpf(self) -> Any:
        """Return the mpmath number nearest in its current working precision."""
        return self.ball().to_mpf()

    def __complex__(self) -> complex:
        return complex(self.ball())

    def __float__(self) -> float:
        if not self.is_real():
            raise ExactnessError(f"a complex number has no float value: {self._brief()}")
        return float(self.ball())

    def magnitude(self) -> float:
        """Return the absolute value as a float, for residuals and reports."""
        return abs(complex(self))

    @property
    def cyclotomic_order(self) -> int | None:
        """Some n for which it lies in Q(zeta_n), but for real roots; ``None``: not known."""
        roots = self._as_roots()
        return None if roots is None else roots.order

    def text_of_roots(self) -> str | None:
        """Return an entry for a number that is kept as one made of roots, where there is one."""
        return self._roots.text() if isinstance(self._roots, Roots) and self._q is None else None

    def description(self) -> str:
        """Return flint's own text: a value and the field it lives in."""
        return repr(self._element)

    def _brief(self) -> str:
        """Return the number in a message, however long its text is."""
        text = repr(self)
        return text if len(text) <= 100 else f"{text[:80]}... ({len(text)} characters)"

    def __repr__(self) -> str:
        return f"Exact({self._q})" if self._q is not None else f"Exact<{self.description()}>"


def exact(value: int | Fraction | Exact) -> Exact:
    """Turn an int or a Fraction into an :class:`Exact`; pass an Exact through."""
    return value if isinstance(value, Exact) else Exact(value)


def ball(value: int | Fraction | Exact | Ball) -> Ball:
    """Turn any number of this module into a :class:`Ball`."""
    return value if isinstance(value, Ball) else exact(value).ball()


def isolated_roots(coefficients: Sequence[Exact | Ball]) -> list[Ball] | None:
    """Return balls around all roots of a polynomial, constant term first, one in each.

    ``None`` where they are not isolated: for multiple roots, or wide balls. The leading coefficient
    is not zero.
    """
    whole = flint.acb_poly([x.ball()._acb for x in coefficients])
    try:
        return [Ball._wrap(x) for x in whole.roots(tol=2.0**-80)]
    except ValueError:
        return None


def root_of_unity(numerator: int, denominator: int) -> Exact:
    """Return exp(2 pi i numerator / denominator).

    Denominators 1, 2, 3, 4, 6, 8 and 12 come in square roots, so that they share a field with the
    tableaux they are used with; others as a power of -1. Each call returns an object of its own:
    what one proof finds out about it does not change how another one spells it.
    """
    return Exact(_root_of_unity(numerator, denominator))


@lru_cache(maxsize=256)
def _root_of_unity(numerator: int, denominator: int) -> Exact:
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
    return Exact._made(Roots.of_unity(turn))
