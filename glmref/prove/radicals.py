"""Numbers in a tower of roots: rational polynomials in radicals, reduced by ``root^n = radicand``.

A tower is a field where no root lies in the field below it; here square roots of rational numbers
are kept multiplicatively independent, and other roots are assumed to be new. Where they are not,
identities that hold may fail to be found; no false one is. That is enough for a certificate, whose
checker computes again.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import prod

from ..errors import ExactnessError
from ..exact import Exact
from ..exact.expression import (
    Name,
    Negative,
    Node,
    Number,
    Product,
    Root,
    Sum,
    syntax_tree,
    to_text,
)

#: Exponents of the roots, the first root adjoined first, without zeros at the end.
_Power = tuple[int, ...]


class Element:
    """A number of a tower.

    Attributes
    ----------
    tower : Tower
        The tower it lives in.
    terms : dict[_Power, Fraction]
        Nonzero coefficients by exponents of the roots.
    """

    __slots__ = ("terms", "tower")

    def __init__(self, tower: Tower, terms: dict[_Power, Fraction]) -> None:
        self.tower = tower
        self.terms = {power: x for power, x in terms.items() if x}

    def is_zero(self) -> bool:
        """Whether all coefficients are zero."""
        return not self.terms

    def as_fraction(self) -> Fraction | None:
        """Return the value as a Fraction, or ``None`` where a root takes part."""
        return self.terms.get((), Fraction(0)) if not set(self.terms) - {()} else None

    def _other(self, other: Element | int | Fraction) -> Element:
        return other if isinstance(other, Element) else self.tower.number(other)

    def __add__(self, other: Element | int | Fraction) -> Element:
        terms = dict(self.terms)
        for power, x in self._other(other).terms.items():
            terms[power] = terms.get(power, Fraction(0)) + x
        return Element(self.tower, terms)

    __radd__ = __add__

    def __neg__(self) -> Element:
        return Element(self.tower, {power: -x for power, x in self.terms.items()})

    def __sub__(self, other: Element | int | Fraction) -> Element:
        return self + -self._other(other)

    def __rsub__(self, other: Element | int | Fraction) -> Element:
        return self._other(other) - self

    def __mul__(self, other: Element | int | Fraction) -> Element:
        total: dict[_Power, Fraction] = {}
        for p, x in self.terms.items():
            for q, y in self._other(other).terms.items():
                for power, factor in self.tower.reduce(_sum(p, q)).items():
                    total[power] = total.get(power, Fraction(0)) + x * y * factor
        return Element(self.tower, total)

    __rmul__ = __mul__

    def __truediv__(self, other: Element | int | Fraction) -> Element:
        return self * self._other(other).inverse()

    def __rtruediv__(self, other: Element | int | Fraction) -> Element:
        return self._other(other) / self

    def inverse(self) -> Element:
        """Return 1/x.

        Raises
        ------
        ZeroDivisionError
            For zero, and for a zero divisor where the tower is no field.
        """
        value = self.as_fraction()
        if value is not None:
            return self.tower.number(1 / value)
        level = max(map(len, self.terms))
        degree = self.tower.levels[level - 1][0]
        if degree == 2:  # 1/(a + b x) = (a - b x)/(a^2 - b^2 d)
            other = Element(
                self.tower, {p: -x if len(p) == level else x for p, x in self.terms.items()}
            )
            return other * (self * other).inverse()
        return self._solved(level)

    def _solved(self, level: int) -> Element:
        """Solve x y = 1 for the rational coefficients of y."""
        tower = self.tower
        degrees = [n for n, _ in tower.levels[:level]]
        powers = [_trimmed(p) for p in product(*map(range, degrees))]
        columns = [(self * Element(tower, {p: Fraction(1)})).terms for p in powers]
        rows = [[*(c.get(p, Fraction(0)) for c in columns), Fraction(int(not p))] for p in powers]
        for j in range(len(powers)):
            at = next((i for i in range(j, len(rows)) if rows[i][j]), None)
            if at is None:
                raise ZeroDivisionError("a number of the tower has no inverse")
            rows[j], rows[at] = rows[at], rows[j]
            rows[j] = [x / rows[j][j] for x in rows[j]]
            for i, row in enumerate(rows):
                if i != j and row[j]:
                    rows[i] = [x - row[j] * y for x, y in zip(row, rows[j], strict=True)]
        return Element(tower, {p: rows[j][-1] for j, p in enumerate(powers)})


class Tower:
    """A tower of roots over the rational numbers, which grows as numbers ask for roots."""

    def __init__(self) -> None:
        self.levels: list[tuple[int, Element]] = []
        self._powers: dict[_Power, dict[_Power, Fraction]] = {}

    def root(self, level: int) -> Element:
        """Return the root of a level, from 0."""
        return Element(self, {(*(0,) * level, 1): Fraction(1)})

    def number(self, value: int | Fraction | Exact) -> Element:
        """Turn an exact number into an element, adjoining the roots of its text form.

        Raises
        ------
        ExactnessError
            For a number without a form in square roots and roots.
        """
        if isinstance(value, Exact):
            fraction = value.as_fraction()
            if fraction is None:
                return self._evaluate(syntax_tree(to_text(value)))
            value = fraction
        return Element(self, {(): Fraction(value)})

    def _evaluate(self, node: Node) -> Element:
        match node:
            case Number(text) if text.isdigit():
                return self.number(int(text))
            case Name("i"):
                return self.radical(self.number(-1), 2)
            case Negative(operand):
                return -self._evaluate(operand)
            case Sum(terms):
                (_, first), *others = terms
                total = self._evaluate(first)
                for sign, term in others:
                    operand = self._evaluate(term)
                    total = total + operand if sign == "+" else total - operand
                return total
            case Product(factors):
                (_, first), *others = factors
                result = self._evaluate(first)
                for sign, factor in others:
                    operand = self._evaluate(factor)
                    result = result * operand if sign == "*" else result / operand
                return result
            case Root(radicand, degree):
                return self.radical(self._evaluate(radicand), degree)
        raise ExactnessError(f"no number of a tower: {node}")

    def radical(self, radicand: Element, degree: int) -> Element:
        """Return a root of a number, adjoined where the tower does not have it.

        Which of the roots it is does not matter: identities hold for all of them or for none.
        """
        for level, (n, d) in enumerate(self.levels):
            if n == degree and (d - radicand).is_zero():
                return self.root(level)
        value = radicand.as_fraction()
        if degree == 2 and value is not None:
            return self._square_root(value)
        return self._adjoin(degree, radicand)

    def _adjoin(self, degree: int, radicand: Element) -> Element:
        self.levels.append((degree, radicand))
        return self.root(len(self.levels) - 1)

    def _square_root(self, value: Fraction) -> Element:
        """sqrt(value) as a product of the square roots there are, or of a new one with them."""
        if not value:
            return self.number(0)
        square, free = _square_free(value.numerator * value.denominator)
        scale = Fraction(square, value.denominator)
        known = [
            (i, int(x))
            for i, (n, d) in enumerate(self.levels)
            if n == 2 and (x := d.as_fraction()) is not None
        ]
        for choice in product((0, 1), repeat=len(known)):
            chosen = [x for x, taken in zip(known, choice, strict=True) if taken]
            outer, rest = _square_free(free * prod(d for _, d in chosen))
            if rest == 1:
                result = self.number(scale * outer / prod(d for _, d in chosen))
                for i, _ in chosen:
                    result = result * self.root(i)
                return result
        return self._adjoin(2, self.number(free)) * scale

    def reduce(self, power: _Power) -> dict[_Power, Fraction]:
        """Write a product of roots with exponents below the degrees."""
        found = self._powers.get(power)
        if found is not None:
            return found
        for level in range(len(power) - 1, -1, -1):
            n, d = self.levels[level]
            if power[level] >= n:
                rest = (*power[:level], power[level] - n, *power[level + 1 :])
                value = Element(self, {(): Fraction(1)})
                value = Element(self, self.reduce(_trimmed(rest))) * d
                break
        else:
            value = Element(self, {_trimmed(power): Fraction(1)})
        self._powers[power] = value.terms
        return value.terms


def _trimmed(power: _Power) -> _Power:
    while power and not power[-1]:
        power = power[:-1]
    return power


def _sum(p: _Power, q: _Power) -> _Power:
    if len(p) < len(q):
        p, q = q, p
    return (*(x + y for x, y in zip(p, q, strict=False)), *p[len(q) :])


def _square_free(n: int) -> tuple[int, int]:
    """Return (m, k) with n = m^2 k, as far as trial division finds squares."""
    square, k = 1, 2
    while k * k <= abs(n) and k < 10000:
        while n % (k * k) == 0:
            n //= k * k
            square *= k
        k += 1
    return square, n
