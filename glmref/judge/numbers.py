"""Numbers: elements of towers, intervals, rectangles, intervals with gradients (section 2)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeGuard

from .arithmetic import (
    Fraction,
    Interval,
    Number,
    Ring,
    rounded,
    spread,
    sum_of_spread,
)
from .refusals import Refused, Undecided, require

if TYPE_CHECKING:
    from .towers import Tower


def total(values: Iterable) -> Number:
    """Return a sum that starts from an exact zero."""
    return sum(values, Fraction(0))


def floor(x: Fraction) -> int:
    """Return the integer below a rational."""
    return int(x.numerator // x.denominator)


def is_nil(x: object) -> bool:
    """Tell whether a number is the exact zero."""
    return type(x) is Fraction and not x


def vanishes(thing: list | Number) -> bool:
    """Tell whether a number, vector or matrix reduces to 0."""
    return all(vanishes(x) for x in thing) if isinstance(thing, list) else not thing


def is_enclosure(x: object) -> TypeGuard[Interval | Box]:
    """Tell whether a number is known by an interval or a rectangle around it only."""
    return type(x) in (Interval, Box)


def live(x: Number) -> bool:
    """Tell whether a number does not reduce to the exact zero; an enclosure counts."""
    return type(x) is Element or is_enclosure(x) or bool(x)


def smallest(x: Number) -> tuple:
    """Return a measure of the least |x|; that of a number that is exact is above all others."""
    return (0, x.least()) if is_enclosure(x) else (1, 0)


class Element(Ring):
    """A polynomial in the generators of a tower, reduced; never a rational number.

    ``nums`` are the integer coefficients over ``den`` at the monomials of the basis of the tower,
    without zeros at the end and without a common factor.
    """

    __slots__ = ("den", "nums", "ready", "tower")

    def __init__(self, tower: Tower, nums: tuple[int, ...], den: int) -> None:
        self.tower, self.nums, self.den, self.ready = tower, nums, den, None

    def spread(self) -> list:
        """Return the integers by the codes of their monomials, ready to be multiplied."""
        if self.ready is None:
            self.ready = spread(self.nums, self.tower.codes)
        return self.ready

    def __add__(self, other: Number) -> Number:
        if isinstance(other, Element):
            nums, den = other.nums, other.den
        elif isinstance(other, Ring):
            return narrowest(self) + other if type(other) is Interval else NotImplemented
        else:
            nums, den = (other.numerator,), other.denominator
        common = math.gcd(self.den, den)
        m, n = den // common, self.den // common
        found = [m * x for x in self.nums]
        found += [0] * (len(nums) - len(found))
        for k, x in enumerate(nums):
            found[k] += n * x
        return self.tower.number(found, self.den * m)

    def __mul__(self, other: Number) -> Number:
        if isinstance(other, Element):
            return dot_of_elements([self], [other])
        if isinstance(other, Ring):
            return narrowest(self) * other if type(other) is Interval else NotImplemented
        n = other.numerator
        return self.tower.number([n * x for x in self.nums], self.den * other.denominator)

    __radd__, __rmul__ = __add__, __mul__

    def __bool__(self) -> bool:
        """Tell that the number is not 0; what does not reduce to 0 may be, in a ring."""
        box = enclose(self)
        return apart(box.re) or apart(box.im) or inverse(self) is not None

    def conj(self) -> Number:
        """Return the conjugate: each generator replaced by its own."""
        if all(self.tower.real):
            return self
        value = Fraction(0)
        for k, n in enumerate(self.nums):
            if n:
                value = value + self.tower.mirrored(k) * Fraction(n, self.den)
        return value

    def __eq__(self, other: Number) -> bool:
        # the same coefficients are another number in another tower
        return getattr(other, "tower", self.tower) is self.tower and vanishes(self - other)

    def __hash__(self) -> int:
        return hash((self.nums, self.den))


def dot_of_elements(x: list, y: list) -> Number:
    """Return sum x_i y_i of elements of one tower and rationals, reduced once.

    The products of monomials are summed before they are reduced, apart by denominators.
    """
    tower = next(a.tower for a in (*x, *y) if type(a) is Element)
    terms = [
        (
            (a.den if isinstance(a, Element) else a.denominator)
            * (b.den if isinstance(b, Element) else b.denominator),
            a.spread() if isinstance(a, Element) else spread((a.numerator,), (0,)),
            b.spread() if isinstance(b, Element) else spread((b.numerator,), (0,)),
        )
        for a, b in zip(x, y, strict=True) if live(a) and live(b)
    ]  # fmt: skip
    return tower.fold(*sum_of_spread(terms))


def around(x: Number) -> Interval:
    """Return an interval around an exact number, which must be real."""
    require(type(x) is not Box, "a number that must be real is known by a rectangle only")
    if not isinstance(x, Element):
        return rounded(x)
    balls = x.tower.balls  # kept with the tower: each certificate has its own
    if x not in balls:
        require(conj(x) == x, "a number that must be real is not")
        balls[x] = enclose(x).re
    return balls[x]


def as_interval(x: Number) -> Interval:
    """Return an interval around a number that is real."""
    return x if type(x) is Interval else around(x)


class Box(Ring):
    """A closed rectangle: intervals around the real and the imaginary part.

    As of an interval, its truth value says that it excludes 0, or is a refusal.
    """

    __slots__ = ("im", "re")

    def __init__(self, re: Number, im: Number = 0) -> None:
        self.re, self.im = as_interval(re), as_interval(im)

    def __add__(self, other: Number) -> Box:
        if isinstance(other, Ring) and type(other) not in (Interval, Box, Element):
            return NotImplemented
        other = enclose(other)
        return Box(self.re + other.re, self.im + other.im)

    def __mul__(self, other: Number) -> Box:
        if type(other) is Interval or not isinstance(other, Ring):
            return Box(self.re * other, self.im * other)
        if type(other) not in (Box, Element):
            return NotImplemented
        other = enclose(other)
        (a, b), (c, d) = (self.re, self.im), (other.re, other.im)
        return Box(a * c - b * d, a * d + b * c)

    __radd__, __rmul__ = __add__, __mul__

    def __bool__(self) -> bool:
        if self.holds_zero():
            raise Undecided("a rectangle holds 0: nothing is decided")
        return True

    def __eq__(self, other: object) -> bool:
        raise Refused("rectangles are not compared")

    __hash__ = None  # type: ignore[assignment]

    def holds_zero(self) -> bool:
        """Tell whether 0 lies in the rectangle."""
        return self.re.holds_zero() and self.im.holds_zero()

    def least(self) -> int:
        """Return a measure of the least |x|, to be compared with those of other enclosures."""
        return max(self.re.least(), self.im.least())

    def conj(self) -> Box:
        """Return the rectangle of the conjugates."""
        return Box(self.re, -self.im)

    def middle(self) -> Box:
        """Return the midpoint, a rectangle without width."""
        return Box(self.re.middle(), self.im.middle())

    def inside(self, other: Box) -> bool:
        """Tell whether the rectangle lies in the interior of another."""
        return self.re.inside(other.re) and self.im.inside(other.im)

    def meet(self, other: Box) -> Box:
        """Return the intersection."""
        return Box(self.re.meet(other.re), self.im.meet(other.im))


def enclose(x: Number) -> Box:
    """Return a rectangle around a number."""
    if not isinstance(x, Element):
        return x if type(x) is Box else Box(x)
    value = Box(Fraction(0))
    for k, n in enumerate(x.nums):
        if n:
            value = value + x.tower.monomial(k) * Fraction(n, x.den)
    return value


def narrowest(x: Number) -> Interval | Box:
    """Return an interval around a number that is real, a rectangle around another."""
    return around(x) if conj(x) == x else enclose(x)


def conj(x: Number) -> Number:
    """Return the conjugate of a number."""
    return x.conj() if isinstance(x, Ring) else x


def inverse(x: Number) -> Number:
    """Return 1 / x."""
    if type(x) is Box:
        return x.conj() * inverse(squared(x))
    if isinstance(x, Element):
        return x.tower.inverse(x)
    require(x, "a division by 0")
    return x.inverse() if isinstance(x, Ring) else 1 / Fraction(x)


def sign(x: Number) -> int:
    """Return the sign of a number that is its own conjugate."""
    if type(x) is Box:
        raise Undecided("a rectangle does not show that a number is real")
    if isinstance(x, Element):
        require(conj(x) == x, "a sign is asked of a number that is not real")
        x = enclose(x).re
    if type(x) is Interval:
        return 1 if x and x.positive() else -1
    if isinstance(x, Ring):
        return x.sign()
    return (x > 0) - (x < 0)


def real(x: Number) -> Number:
    """Return the real part."""
    return x.re if type(x) is Box else (x + conj(x)) * Fraction(1, 2)


def upper(x: Number) -> bool:
    """Tell whether the imaginary part is positive; refuse where its interval holds 0 and more."""
    return sign(enclose(x).im) > 0


def squared(x: Number) -> Number:
    """Return |x|^2."""
    return x.re * x.re + x.im * x.im if type(x) is Box else x * conj(x)


def may_vanish(x: Number) -> bool:
    """Tell whether a number is 0, or an enclosure that holds 0."""
    return x.holds_zero() if is_enclosure(x) else not x


def apart(x: Number) -> bool:
    """Tell whether a number is shown not to be 0; an enclosure of 0 is not."""
    return not may_vanish(x)


def as_real(x: Number) -> Number:
    """Return a number, an interval in place of an irrational exact one."""
    return around(x) if isinstance(x, Element) else x


def as_reals(x: list) -> list:
    """Return a vector or matrix with intervals in place of irrational exact numbers."""
    return [as_reals(y) if isinstance(y, list) else as_real(y) for y in x]
