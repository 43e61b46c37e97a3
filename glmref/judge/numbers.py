"""Numbers: elements of towers, intervals, rectangles, intervals with gradients (section 2)."""

from fractions import Fraction
from functools import cache
from itertools import product

from .refusals import Refused, require

PLACES = 448  # binary places of an interval


def total(values):
    """Return a sum that starts from an exact zero."""
    return sum(values, Fraction(0))


def is_nil(x):
    """Tell whether a number is the exact zero."""
    return type(x) is Fraction and not x


def vanishes(thing):
    """Tell whether a number, vector or matrix reduces to 0."""
    return all(vanishes(x) for x in thing) if isinstance(thing, list) else not thing


def live(x):
    """Tell whether a number does not reduce to the exact zero; an interval counts."""
    return type(x) in (Interval, Element) or bool(x)


def smallest(x):
    """Return a bound below |x|, infinity for a number that is exact."""
    return min(abs(x.lo), abs(x.hi)) if type(x) is Interval else float("inf")


class Ring:
    """What follows from sums and products."""

    __slots__ = ()

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __pow__(self, n):
        return self if n == 1 else self * self ** (n - 1) if n else Fraction(1)

    def conj(self):
        """Return the conjugate: the number itself where it is real."""
        return self


class Element(Ring):
    """A polynomial in the generators of a tower, reduced; never a rational number."""

    __slots__ = ("terms", "tower")

    def __init__(self, tower, terms):
        self.tower, self.terms = tower, terms

    def __add__(self, other):
        if not isinstance(other, Element | Fraction | int):
            return NotImplemented
        terms = dict(self.terms)
        for k, x in other.terms.items() if isinstance(other, Element) else ((0, other),):
            terms[k] = terms.get(k, 0) + x
        return self.tower.element(terms)

    def __mul__(self, other):
        if not isinstance(other, Element | Fraction | int):
            return NotImplemented
        if not isinstance(other, Element):
            return self.tower.element({k: x * other for k, x in self.terms.items()})
        terms = {}
        for (i, x), (j, y) in product(self.terms.items(), other.terms.items()):
            for k, z in self.tower.table(i, j):
                terms[k] = terms.get(k, 0) + x * y * z
        return self.tower.element(terms)

    __radd__, __rmul__ = __add__, __mul__

    def __bool__(self):
        """Tell that the number is not 0; what does not reduce to 0 may be, in a ring."""
        box = enclose(self)
        return apart(box.re) or apart(box.im) or inverse(self) is not None

    def conj(self):
        """Return the conjugate: each generator replaced by its own."""
        if all(self.tower.real):
            return self
        value = Fraction(0)
        for k, c in self.terms.items():
            for g, power in enumerate(self.tower.basis[k]):
                if power:
                    c = c * self.tower.conjugate(g) ** power
            value = value + c
        return value

    def __eq__(self, other):
        # the same terms are another number in another tower
        return getattr(other, "tower", self.tower) is self.tower and vanishes(self - other)

    def __hash__(self):
        return hash(frozenset(self.terms.items()))


class Interval(Ring):
    """A closed interval of real numbers with ends that are whole multiples of 2^-PLACES.

    Its truth value says that it excludes 0; where that is not decided the answer is a refusal, so
    that the rules for exact numbers can be used with intervals and prove nothing wrong.
    """

    __slots__ = ("hi", "lo")

    def __init__(self, lo, hi):
        self.lo, self.hi = lo, hi

    @classmethod
    def of(cls, x):
        """Return an interval around a number."""
        return x if type(x) is Interval else around(x)

    @classmethod
    def ends(cls, lo, hi):
        """Return the interval between two rationals, rounded outward."""
        return cls((lo * 2**PLACES).__floor__(), (hi * 2**PLACES).__ceil__())

    def middle(self):
        """Return the midpoint, an interval without width."""
        return Interval((self.lo + self.hi) // 2, (self.lo + self.hi) // 2)

    def inside(self, other):
        """Tell whether the interval lies in the interior of another."""
        return other.lo < self.lo and self.hi < other.hi

    def meet(self, other):
        """Return the intersection."""
        return Interval(max(self.lo, other.lo), min(self.hi, other.hi))

    def __bool__(self):
        require(not self.lo <= 0 <= self.hi, "an interval holds 0: nothing is decided")
        return True

    def __add__(self, other):
        if type(other) is not Interval:
            if isinstance(other, Gradient | Box):
                return NotImplemented
            other = around(other)
        return Interval(self.lo + other.lo, self.hi + other.hi)

    __radd__ = __add__

    def __neg__(self):
        return Interval(-self.hi, -self.lo)

    def __mul__(self, other):
        a, b = self.lo, self.hi
        if type(other) is not Interval:
            if isinstance(other, Gradient | Box):
                return NotImplemented
            if not isinstance(other, Element):
                n, d = other.numerator, other.denominator
                a, b = (a * n, b * n) if n >= 0 else (b * n, a * n)
                return Interval(a // d, -(-b // d))
            other = around(other)
        c, d = other.lo, other.hi
        ends = (a * c, a * d, b * c, b * d)
        return Interval(min(ends) >> PLACES, -(-max(ends) >> PLACES))

    __rmul__ = __mul__

    def __eq__(self, other):
        raise Refused("intervals are not compared")

    __hash__ = None


@cache
def rounded(x):
    """Return an interval around a rational."""
    return Interval.ends(Fraction(x), Fraction(x))


def around(x):
    """Return an interval around an exact number, which must be real."""
    if not isinstance(x, Element):
        return rounded(x)
    balls = x.tower.balls  # kept with the tower: each certificate has its own
    if x not in balls:
        require(conj(x) == x, "a number that must be real is not")
        balls[x] = enclose(x).re
    return balls[x]


class Box(Ring):
    """A closed rectangle: intervals around the real and the imaginary part."""

    __slots__ = ("im", "re")

    def __init__(self, re, im=Fraction(0)):
        self.re, self.im = Interval.of(re), Interval.of(im)

    def __add__(self, other):
        other = other if type(other) is Box else Box(other)
        return Box(self.re + other.re, self.im + other.im)

    def __mul__(self, other):
        if type(other) is not Box:
            return Box(self.re * other, self.im * other)
        (a, b), (c, d) = (self.re, self.im), (other.re, other.im)
        return Box(a * c - b * d, a * d + b * c)

    __radd__, __rmul__ = __add__, __mul__

    def conj(self):
        """Return the rectangle of the conjugates."""
        return Box(self.re, -self.im)

    def middle(self):
        """Return the midpoint, a rectangle without width."""
        return Box(self.re.middle(), self.im.middle())

    def inside(self, other):
        """Tell whether the rectangle lies in the interior of another."""
        return self.re.inside(other.re) and self.im.inside(other.im)

    def meet(self, other):
        """Return the intersection."""
        return Box(self.re.meet(other.re), self.im.meet(other.im))


def enclose(x):
    """Return a rectangle around a number."""
    if not isinstance(x, Element):
        return Box(x)
    value = Box(Fraction(0))
    for k, c in x.terms.items():
        term = Box(c)
        for root, power in zip(x.tower.roots, x.tower.basis[k], strict=True):
            for _ in range(power):
                term = term * root
        value = value + term
    return value


def conj(x):
    """Return the conjugate of a number."""
    return x.conj() if isinstance(x, Ring) else x


def inverse(x):
    """Return 1 / x."""
    if type(x) is Box:
        return x.conj() * inverse(x.re * x.re + x.im * x.im)
    if isinstance(x, Element):
        return x.tower.inverse(x)
    require(x, "a division by 0")
    if type(x) is Interval:
        return Interval(4**PLACES // x.hi, -(-(4**PLACES) // x.lo))
    return 1 / Fraction(x)


def sign(x):
    """Return the sign of a number that is its own conjugate."""
    if isinstance(x, Element):
        require(conj(x) == x, "a sign is asked of a number that is not real")
        x = enclose(x).re
    if type(x) is Interval:
        return 1 if x and x.lo > 0 else -1
    return (x > 0) - (x < 0)


def real(x):
    """Return the real part."""
    return (x + conj(x)) * Fraction(1, 2)


def upper(x):
    """Tell whether the imaginary part is shown to be positive."""
    return enclose(x).im.lo > 0


def squared(x):
    """Return |x|^2."""
    return x * conj(x)


def may_vanish(x):
    """Tell whether a number is 0, or an interval that holds 0."""
    return x.lo <= 0 <= x.hi if type(x) is Interval else not x


def apart(x):
    """Tell whether a number is shown not to be 0; an interval around 0 is not."""
    return not x.lo <= 0 <= x.hi if type(x) is Interval else bool(x)


class Gradient(Ring):
    """An interval with its derivatives by the unknowns, exact zeros left out."""

    __slots__ = ("by", "value")

    def __init__(self, value, by):
        self.value, self.by = value, by

    def __add__(self, other):
        if not isinstance(other, Gradient):
            return Gradient(self.value + other, self.by)
        by = dict(self.by)
        for k, x in other.by.items():
            by[k] = by[k] + x if k in by else x
        return Gradient(self.value + other.value, by)

    def __mul__(self, other):
        if not isinstance(other, Gradient):
            return Gradient(self.value * other, {k: x * other for k, x in self.by.items()})
        by = {k: x * other.value for k, x in self.by.items()}
        for k, x in other.by.items():
            by[k] = by[k] + x * self.value if k in by else x * self.value
        return Gradient(self.value * other.value, by)

    __radd__, __rmul__ = __add__, __mul__


def as_real(x):
    """Return numbers, in lists or not, with intervals in place of irrational exact ones."""
    if isinstance(x, list):
        return [as_real(y) for y in x]
    return around(x) if isinstance(x, Element) else x
