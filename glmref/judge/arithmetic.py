"""The arithmetic of the judge: rationals, intervals, intervals with gradients, and their sums.

Every module takes its rationals from here, and long sums of products are formed here, so that
another arithmetic can stand in the place of this one. This one needs Python only: integers,
:class:`fractions.Fraction`, and intervals whose ends are integers over 2^PLACES.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cache
from itertools import zip_longest
from operator import itemgetter, mul
from typing import TypeAlias

from .refusals import NotShown, Refused, Undecided

PLACES = 448  # binary places of an interval

#: A number of any kind; elements of towers and rectangles stand in :mod:`.numbers`.
Number: TypeAlias = "Fraction | int | Ring"


def tick() -> None:
    """Do nothing; another arithmetic may end here what takes too long."""


class Ring:
    """What follows from sums and products, which a subclass defines."""

    __slots__ = ()

    def __add__(self, other: Number) -> Number:
        return NotImplemented

    def __mul__(self, other: Number) -> Number:
        return NotImplemented

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Number:
        return self * -1

    def __sub__(self, other: Number) -> Number:
        return self + -other

    def __rsub__(self, other: Number) -> Number:
        return -self + other

    def __pow__(self, n: int) -> Number:
        return self if n == 1 else self * self ** (n - 1) if n else 1

    def conj(self) -> Ring:
        """Return the conjugate: the number itself where it is real."""
        return self

    def inverse(self) -> Ring:
        """Return 1 / x."""
        raise NotShown("a division by an unknown")

    def sign(self) -> int:
        """Return the sign."""
        raise NotShown("a sign is asked of an unknown")


def product_of_ends(a: int, b: int, c: int, d: int) -> tuple[int, int]:
    """Return the least and the largest product of a number in [a, b] and one in [c, d]."""
    if a >= 0:
        if c >= 0:
            return a * c, b * d
        return (b * c, a * d) if d <= 0 else (b * c, b * d)
    if b <= 0:
        if c >= 0:
            return a * d, b * c
        return (b * d, a * c) if d <= 0 else (a * d, a * c)
    if c >= 0:
        return a * d, b * d
    if d <= 0:
        return b * c, a * c
    return min(a * d, b * c), max(a * c, b * d)


class Interval(Ring):
    """A closed interval of real numbers with ends that are whole multiples of 2^-PLACES.

    Its truth value says that it excludes 0; where that is not decided the answer is a refusal, so
    that the rules for exact numbers can be used with intervals and prove nothing wrong.
    """

    __slots__ = ("hi", "lo")

    def __init__(self, lo: int, hi: int) -> None:
        self.lo, self.hi = lo, hi

    @classmethod
    def ends(cls, lo: Fraction, hi: Fraction) -> Interval:
        """Return the interval between two rationals, rounded outward."""
        return cls((lo * 2**PLACES).__floor__(), (hi * 2**PLACES).__ceil__())

    def middle(self) -> Interval:
        """Return the midpoint, an interval without width."""
        return Interval((self.lo + self.hi) // 2, (self.lo + self.hi) // 2)

    def inside(self, other: Interval) -> bool:
        """Tell whether the interval lies in the interior of another."""
        return other.lo < self.lo and self.hi < other.hi

    def meet(self, other: Interval) -> Interval:
        """Return the intersection."""
        return Interval(max(self.lo, other.lo), min(self.hi, other.hi))

    def positive(self) -> bool:
        """Tell whether all numbers of the interval are positive."""
        return self.lo > 0

    def is_zero(self) -> bool:
        """Tell whether the interval holds 0 only."""
        return self.lo == 0 == self.hi

    def least(self) -> int:
        """Return a measure of the least |x|, to be compared with those of other intervals."""
        return min(abs(self.lo), abs(self.hi))

    def __float__(self) -> float:
        """Return a number near the midpoint."""
        return (self.lo + self.hi) / 2 ** (PLACES + 1)

    def holds_zero(self) -> bool:
        """Tell whether 0 lies in the interval."""
        return self.lo <= 0 <= self.hi

    def inverse(self) -> Interval:
        """Return 1 / x of an interval that excludes 0."""
        return Interval(4**PLACES // self.hi, -(-(4**PLACES) // self.lo))

    def __bool__(self) -> bool:
        if self.lo <= 0 <= self.hi:
            raise Undecided("an interval holds 0: nothing is decided")
        return True

    def __add__(self, other: Number) -> Interval:
        if type(other) is not Interval:
            if isinstance(other, Ring):
                return NotImplemented
            other = rounded(other)
        return Interval(self.lo + other.lo, self.hi + other.hi)

    __radd__ = __add__

    def __neg__(self) -> Interval:
        return Interval(-self.hi, -self.lo)

    def __mul__(self, other: Number) -> Interval:
        if type(other) is not Interval:
            if isinstance(other, Ring):
                return NotImplemented
            n, d = other.numerator, other.denominator
            a, b = (self.lo * n, self.hi * n) if n >= 0 else (self.hi * n, self.lo * n)
            return Interval(a // d, -(-b // d))
        low, high = product_of_ends(self.lo, self.hi, other.lo, other.hi)
        return Interval(low >> PLACES, -(-high >> PLACES))

    __rmul__ = __mul__

    def __eq__(self, other: object) -> bool:
        raise Refused("intervals are not compared")

    __hash__ = None  # type: ignore[assignment]


#: The types of rational numbers.
RATIONAL = (Fraction, int)


def rational_of(text: str) -> Fraction:
    """Return the rational of a decimal such as -1.25e-3."""
    return Fraction(text)


@cache
def rounded(x: Fraction | int) -> Interval:
    """Return an interval around a rational."""
    return Interval.ends(Fraction(x), Fraction(x))


class Gradient(Ring):
    """An interval with its derivatives by the unknowns, exact zeros left out."""

    __slots__ = ("by", "value")

    def __init__(self, value: Interval, by: dict[int, Interval]) -> None:
        self.value, self.by = value, by

    @staticmethod
    def dot(pairs: Iterable[tuple]) -> Gradient:
        """Return sum x_i y_i; another arithmetic has its own."""
        return dot_of_gradients(pairs)

    def __add__(self, other: Number) -> Gradient:
        if not isinstance(other, Gradient):
            return type(self)(self.value + other, self.by)
        by = dict(self.by)
        for k, x in other.by.items():
            by[k] = by[k] + x if k in by else x
        return type(self)(self.value + other.value, by)

    def __mul__(self, other: Number) -> Gradient:
        if not isinstance(other, Gradient):
            return type(self)(self.value * other, {k: x * other for k, x in self.by.items()})
        return self.dot([(self, other)])

    __radd__, __rmul__ = __add__, __mul__


def dot_of_rationals(x: Sequence[Fraction], y: Sequence[Fraction]) -> Fraction:
    """Return sum x_i y_i, reduced once."""
    top, bottom = 0, 1
    for a, b in zip(x, y, strict=True):
        n = a.numerator * b.numerator
        if n:
            d = a.denominator * b.denominator
            if d == bottom:
                top += n
            else:
                common = math.gcd(d, bottom)
                top = top * (d // common) + n * (bottom // common)
                bottom *= d // common
    return Fraction(top, bottom)


def product_of_rationals(M: list, N: list) -> list:
    """Return the product of two matrices."""
    columns = list(zip(*N, strict=True))
    return [[dot_of_rationals(row, column) for column in columns] for row in M]


def over_one_denominator(values: Sequence[Fraction]) -> tuple[list[int], int]:
    """Return integers and the denominator that they have in common."""
    common = math.lcm(*(x.denominator for x in values))
    return [x.numerator * (common // x.denominator) for x in values], common


class Applied:
    """A matrix of rationals and intervals, made ready for many vectors."""

    def __init__(self, rows: list) -> None:
        self.rows, self.whole = rows, []

    def to_rationals(self, x: list) -> list:
        """Return M x, M and x rational: products of integers, each reduced once."""
        if not self.whole:
            self.whole = [over_one_denominator(row) for row in self.rows]
        values, under = over_one_denominator(x)
        return [Fraction(sum(map(mul, row, values)), common * under) for row, common in self.whole]

    def to_intervals(self, x: list) -> list:
        """Return M x of a vector of intervals; where a row is 0, the exact zero."""
        return [dot_of_intervals(row, x) for row in self.rows]


def spread(nums: Sequence[int], codes: Sequence[int]) -> list[tuple[int, int]]:
    """Return a polynomial in generators by the codes of its monomials, as pairs."""
    return [(codes[k], n) for k, n in enumerate(nums) if n]


def sum_of_spread(terms: Iterable[tuple[int, list, list]]) -> tuple[list[int], int]:
    """Return the integers at codes, and the denominator, of a sum of p q / den.

    The terms are (den, p, q), p and q not 0; codes add up where monomials are multiplied.
    """
    sums: dict[int, list[int]] = {}
    for den, first, second in terms:
        found = sums.setdefault(den, [])
        found += [0] * (first[-1][0] + second[-1][0] + 1 - len(found))
        for code, u in first:
            for more, v in second:
                found[code + more] += u * v
    common = math.lcm(*sums)
    scaled = [found if den == common else [common // den * u for u in found]
              for den, found in sums.items()]  # fmt: skip
    return [sum(column) for column in zip_longest(*scaled, fillvalue=0)], common


def products_of_whole(vectors: list[list[int]], A: list[list[int]]) -> list[list[int]]:
    """Return A x for every vector x, all of integers."""
    sparse = [([x for x in row if x], [j for j, x in enumerate(row) if x]) for row in A]
    return [[sum(a * x[j] for a, j in zip(row, places, strict=True)) if len(places) < 2
             else sum(map(mul, row, itemgetter(*places)(x))) for row, places in sparse]
            for x in vectors]  # fmt: skip


def dot_of_intervals(x: Sequence, y: Sequence) -> Interval | Fraction:
    """Return sum x_i y_i of intervals and rationals, rounded outward once."""
    low = high = 0
    exact, some = Fraction(0), False
    for a, b in zip(x, y, strict=True):
        if type(a) is Interval:
            if type(b) is Interval:
                p, q = product_of_ends(a.lo, a.hi, b.lo, b.hi)
                low, high, some = low + p, high + q, True
                continue
        elif type(b) is Interval:
            a, b = b, a
        else:
            exact += a * b
            continue
        n, d = b.numerator, b.denominator
        if n:  # an exact zero stays one
            p, q = (a.lo * n, a.hi * n) if n > 0 else (a.hi * n, a.lo * n)
            low, high, some = low + (p << PLACES) // d, high - (-q << PLACES) // d, True
    if not some:
        return exact
    found = Interval(low >> PLACES, -(-high >> PLACES))
    return found + exact if exact else found


def dot_of_gradients(pairs: Iterable[tuple]) -> Gradient:
    """Return sum x_i y_i of intervals, rationals and gradients, rounded outward once."""
    low = high = 0
    lows: dict[int, int] = {}
    highs: dict[int, int] = {}
    for a, b in pairs:
        sides = []
        for x in (a, b):
            by = ()
            if type(x) is Gradient:
                by, x = x.by.items(), x.value
            sides.append((x if type(x) is Interval else rounded(x), by))
        (u, du), (v, dv) = sides
        p, q = product_of_ends(u.lo, u.hi, v.lo, v.hi)
        low, high = low + p, high + q
        for other, by in ((v, du), (u, dv)):
            c, d = other.lo, other.hi
            for k, g in by:
                p, q = product_of_ends(g.lo, g.hi, c, d)
                lows[k] = lows.get(k, 0) + p
                highs[k] = highs.get(k, 0) + q
    by = {k: Interval(x >> PLACES, -(-highs[k] >> PLACES)) for k, x in lows.items()}
    return Gradient(Interval(low >> PLACES, -(-high >> PLACES)), by)


def newton_sums(Y: list, values: list, gradients: list) -> tuple[list[Fraction], list[Fraction]]:
    """Return rationals above |Y f| and above the row sums of |1 - Y G|, row by row.

    Parameters
    ----------
    Y : list of list of int
        A matrix of integers over 2^80, (n, n).
    values : list of Interval
        f at the centre, (n,).
    gradients : list of dict
        The rows of G: intervals by place, exact zeros left out.

    Returns
    -------
    list of Fraction, list of Fraction
        The bounds of |Y f| and of the row sums.
    """
    n = len(values)
    columns = [[(i, row[j].lo + row[j].hi, row[j].hi - row[j].lo)
                for i, row in enumerate(gradients) if j in row] for j in range(n)]  # fmt: skip
    one, steps, slacks = 1 << (PLACES + 81), [], []
    for i, row in enumerate(Y):
        low = high = slack = 0
        for y, value in zip(row, values, strict=True):
            ends = y * value.lo, y * value.hi
            low, high = low + min(ends), high + max(ends)
        steps.append(Fraction(max(abs(low), abs(high)), 1 << (PLACES + 80)))
        for j, column in enumerate(columns):
            middle, spread = one if i == j else 0, 0
            for k, twice, width in column:
                middle -= row[k] * twice
                spread += abs(row[k]) * width
            slack += abs(middle) + spread
        slacks.append(Fraction(slack, one))
    return steps, slacks
