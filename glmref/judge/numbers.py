"""Numbers: elements of towers, intervals, rectangles, intervals with gradients (section 2)."""

import math

from .arithmetic import RATIONAL, Fraction, Interval, Ring, rounded
from .refusals import require


def total(values):
    """Return a sum that starts from an exact zero."""
    return sum(values, Fraction(0))


def floor(x):
    """Return the integer below a rational."""
    return int(x.numerator // x.denominator)


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
    """Return a measure of the least |x|; that of a number that is exact is above all others."""
    return (0, x.least()) if type(x) is Interval else (1, 0)


class Element(Ring):
    """A polynomial in the generators of a tower, reduced; never a rational number.

    ``nums`` are the integer coefficients over ``den`` at the monomials of the basis of the tower,
    without zeros at the end and without a common factor.
    """

    __slots__ = ("den", "nums", "tower")

    def __init__(self, tower, nums, den):
        self.tower, self.nums, self.den = tower, nums, den

    def __add__(self, other):
        if isinstance(other, Element):
            nums, den = other.nums, other.den
        elif type(other) in RATIONAL:
            nums, den = (other.numerator,), other.denominator
        else:
            return NotImplemented
        common = math.gcd(self.den, den)
        m, n = den // common, self.den // common
        found = [m * x for x in self.nums]
        found += [0] * (len(nums) - len(found))
        for k, x in enumerate(nums):
            found[k] += n * x
        return self.tower.number(found, self.den * m)

    def __mul__(self, other):
        if isinstance(other, Element):
            return dot_of_elements([self], [other])
        if type(other) not in RATIONAL:
            return NotImplemented
        n = other.numerator
        return self.tower.number([n * x for x in self.nums], self.den * other.denominator)

    __radd__, __rmul__ = __add__, __mul__

    def __bool__(self):
        """Tell that the number is not 0; what does not reduce to 0 may be, in a ring."""
        box = enclose(self)
        return apart(box.re) or apart(box.im) or inverse(self) is not None

    def interval(self):
        """Return an interval around the number, which must be real."""
        return around(self)

    def conj(self):
        """Return the conjugate: each generator replaced by its own."""
        if all(self.tower.real):
            return self
        value = Fraction(0)
        for k, n in enumerate(self.nums):
            if n:
                value = value + self.tower.mirrored(k) * Fraction(n, self.den)
        return value

    def __eq__(self, other):
        # the same coefficients are another number in another tower
        return getattr(other, "tower", self.tower) is self.tower and vanishes(self - other)

    def __hash__(self):
        return hash((self.nums, self.den))


def dot_of_elements(x, y):
    """Return sum x_i y_i of elements of one tower and rationals, reduced once.

    The products of monomials are summed before they are reduced, apart by denominators.
    """
    tower = next(a.tower for a in (*x, *y) if type(a) is Element)
    codes, width = tower.codes, tower.width
    sums = {}
    for a, b in zip(x, y, strict=True):
        first = a.nums if type(a) is Element else (a.numerator,)
        second = b.nums if type(b) is Element else (b.numerator,)
        if not (first[-1] and second[-1]):
            continue  # a factor is 0
        den = (a.den if type(a) is Element else a.denominator) * (
            b.den if type(b) is Element else b.denominator)  # fmt: skip
        found = sums.get(den)
        if found is None:
            found = sums[den] = [0] * width
        for i, u in enumerate(first):
            if u:
                code = codes[i]
                for j, v in enumerate(second):
                    if v:
                        found[code + codes[j]] += u * v
    if len(sums) > 1:
        den = math.lcm(*sums)
        scaled = [[den // d * u for u in found] for d, found in sums.items()]
        return tower.fold(list(map(sum, zip(*scaled, strict=True))), den)
    for den, found in sums.items():
        return tower.fold(found, den)
    return Fraction(0)


def around(x):
    """Return an interval around an exact number, which must be real."""
    if not isinstance(x, Element):
        return rounded(x)
    balls = x.tower.balls  # kept with the tower: each certificate has its own
    if x not in balls:
        require(conj(x) == x, "a number that must be real is not")
        balls[x] = enclose(x).re
    return balls[x]


def as_interval(x):
    """Return an interval around a number that is real."""
    return x if type(x) is Interval else around(x)


class Box(Ring):
    """A closed rectangle: intervals around the real and the imaginary part."""

    __slots__ = ("im", "re")

    def __init__(self, re, im=0):
        self.re, self.im = as_interval(re), as_interval(im)

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
    for k, n in enumerate(x.nums):
        if n:
            value = value + x.tower.monomial(k) * Fraction(n, x.den)
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
        return x.inverse()
    return 1 / Fraction(x)


def sign(x):
    """Return the sign of a number that is its own conjugate."""
    if isinstance(x, Element):
        require(conj(x) == x, "a sign is asked of a number that is not real")
        x = enclose(x).re
    if type(x) is Interval:
        return 1 if x and x.positive() else -1
    return (x > 0) - (x < 0)


def real(x):
    """Return the real part."""
    return (x + conj(x)) * Fraction(1, 2)


def upper(x):
    """Tell whether the imaginary part is positive; refuse where its interval holds 0 and more."""
    return sign(enclose(x).im) > 0


def squared(x):
    """Return |x|^2."""
    return x * conj(x)


def may_vanish(x):
    """Tell whether a number is 0, or an interval that holds 0."""
    return x.holds_zero() if type(x) is Interval else not x


def apart(x):
    """Tell whether a number is shown not to be 0; an interval around 0 is not."""
    return not x.holds_zero() if type(x) is Interval else bool(x)


def as_real(x):
    """Return numbers, in lists or not, with intervals in place of irrational exact ones."""
    if isinstance(x, list):
        return [as_real(y) for y in x]
    return around(x) if isinstance(x, Element) else x
