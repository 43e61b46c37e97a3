"""Towers of algebraic numbers over the rationals (section 2)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import cast

from .arithmetic import Fraction, Interval, Number
from .grammar import parse, rational
from .krawczyk import root_in
from .linalg import solve, transpose
from .numbers import Box, Element, conj, enclose, vanishes
from .polynomials import horner
from .refusals import as_list, keys, require, shown

DIMENSION = 64  # of a tower over the rationals


def coefficients(x: Element | Fraction) -> list[tuple[int, Fraction]]:
    """Return (place in the basis, rational) of an element or a rational."""
    if isinstance(x, Element):
        return [(k, Fraction(n, x.den)) for k, n in enumerate(x.nums) if n]
    return [(0, x)]


class Tower:
    """The rationals with generators; arithmetic by reduction, enclosures by bisection (2)."""

    def __init__(self, generators: list) -> None:
        self.names, self.degrees, self.polynomials, self.roots = [], [], [], []
        self.real, self.conjugates, self.inverses, self.starts = [], [], {}, []
        self.basis: list[tuple[int, ...]] = [()]
        self.index: dict[tuple[int, ...], int] = {(): 0}
        self.folded, self.balls = {}, {}
        self.monomials, self.codes, self.width = {}, [0], 1
        for k, entry in enumerate(generators):
            keys(entry, "name polynomial real imag", "conjugate", "generator")
            require(entry["name"] == f"g{k + 1}", "generators are called g1, g2, ..")
            self.adjoin(entry)
        for entry, name in zip(generators, self.names, strict=True):
            self.check_conjugate(entry, name)

    def adjoin(self, entry: Mapping[str, object]) -> None:
        """Add a generator: its polynomial, and a box that is shown to hold one root."""
        polynomial = as_list(entry["polynomial"], "a polynomial is a list")
        degree = len(polynomial)
        require(2 <= degree and degree * len(self.basis) <= DIMENSION, "degrees of the tower")
        self.polynomials.append([self.parse(text) for text in polynomial])
        sides = [as_list(entry[x], "a side of a box is a list") for x in ("real", "imag")]
        ends = [[rational(x) for x in side] for side in sides]
        require(all(len(x) == 2 and x[0] <= x[1] for x in ends), "a box has ends that are ordered")
        real_, p = ends[1] == [0, 0], [enclose(x) for x in [*self.polynomials[-1], Fraction(1)]]
        box = Box(*(Interval.ends(*x) for x in ends))
        if real_:
            fine = all(x.im.is_zero() for x in p)
            require(fine, "the polynomial of a real generator is not real")
            p, box = [x.re for x in p], box.re
        self.starts.append(box)
        box = root_in(p, box)
        self.roots.append(Box(box) if real_ else box)
        self.real.append(real_)
        self.names.append(entry["name"])
        self.degrees.append(degree)
        old = self.basis
        self.basis = [(*e, k) for k in range(degree) for e in old]  # old indices keep their place
        self.index = {e: k for k, e in enumerate(self.basis)}
        self.folded, self.inverses, self.monomials = {}, {}, {}
        self.codes, self.width = [0], 1  # of products of two monomials, whose powers add up
        for n in self.degrees:
            self.codes = [c + k * self.width for k in range(n) for c in self.codes]
            self.width *= 2 * n - 1

    def number(self, nums: Sequence[int], den: int) -> Number:
        """Return the number with these integers over den at the basis: an element or a rational."""
        n = len(nums)
        while n and not nums[n - 1]:
            n -= 1
        if n < 2:
            return Fraction(nums[0], den) if n else Fraction(0)
        common = math.gcd(den, *nums[:n])
        return Element(self, tuple(x // common for x in nums[:n]), den // common)

    def element(self, terms: Mapping[int, Fraction]) -> Number:
        """Return the number with these rational coefficients by place in the basis."""
        den = math.lcm(*(x.denominator for x in terms.values()))
        nums = [0] * (max(terms, default=0) + 1)
        for k, x in terms.items():
            nums[k] = x.numerator * (den // x.denominator)
        return self.number(nums, den)

    def generator(self, k: int) -> Number:
        """Return g_(k+1)."""
        return self.element(
            {self.index[tuple(int(j == k) for j in range(len(self.names)))]: Fraction(1)}
        )

    def fold(self, sums: list[int], den: int) -> Number:
        """Return the number with these integers over den at products of two monomials."""
        nums, bottom = [0] * len(self.basis), 1
        for code, n in enumerate(sums):
            if not n:
                continue
            if code not in self.folded:
                self.folded[code] = self.product(code)
            items, more = self.folded[code]
            if more != bottom:
                common = math.lcm(more, bottom)
                nums = [x * (common // bottom) for x in nums]
                n *= common // more
                bottom = common
            for k, x in items:
                nums[k] += n * x
        return self.number(nums, den * bottom)

    def product(self, code: int) -> tuple[list[tuple[int, int]], int]:
        """Return a product of two monomials: ([(place in the basis, integer)], denominator)."""
        powers = []
        for degree in self.degrees:
            powers.append(code % (2 * degree - 1))
            code //= 2 * degree - 1
        terms = {k: x for k, x in self.reduce(tuple(powers)).items() if x}
        den = math.lcm(*(x.denominator for x in terms.values()))
        return [(k, x.numerator * (den // x.denominator)) for k, x in terms.items()], den

    def monomial(self, k: int) -> Box:
        """Return a rectangle around a monomial of the basis."""
        if k not in self.monomials:
            value = Box(Fraction(1))
            for root, power in zip(self.roots, self.basis[k], strict=True):
                for _ in range(power):
                    value = value * root
            self.monomials[k] = value
        return self.monomials[k]

    def mirrored(self, k: int) -> Number:
        """Return the conjugate of a monomial of the basis."""
        value = Fraction(1)
        for g, power in enumerate(self.basis[k]):
            if power:
                value = value * self.conjugate(g) ** power
        return value

    def reduce(self, powers: tuple[int, ...]) -> dict[int, Fraction]:
        """Return a monomial by the monic polynomials: rational coefficients by place."""
        high = next((k for k in reversed(range(len(powers))) if powers[k] >= self.degrees[k]), None)
        if high is None:
            return {self.index[powers]: Fraction(1)}
        terms, degree = {}, self.degrees[high]
        for k, c in enumerate(self.polynomials[high]):
            for at, x in coefficients(c):
                inner = self.basis[at] + (0,) * (len(powers) - len(self.basis[at]))
                moved = [a + b for a, b in zip(powers, inner, strict=True)]
                moved[high] += k - degree
                for index, y in self.reduce(tuple(moved)).items() if x else ():
                    terms[index] = terms.get(index, 0) - x * y
        return terms

    def inverse(self, x: Element) -> Number:
        """Return y with x y = 1 in the ring."""
        if x not in self.inverses:
            n = len(self.basis)
            columns = []
            for k in range(n):
                column = [Fraction(0)] * n
                image = cast("Element | Fraction", x * self.element({k: Fraction(1)}))
                for i, c in coefficients(image):
                    column[i] = c
                columns.append(column)
            y, _ = solve(transpose(columns), [Fraction(int(i == 0)) for i in range(n)])
            y = shown(y, "a divisor has no inverse in the ring of the tower")
            self.inverses[x] = self.element(dict(enumerate(y)))
        return self.inverses[x]

    def parse(self, text: object, radical: Callable[[str], Number] | None = None) -> Number:
        """Return a number of the certificate: rationals, names of generators, and radicals."""
        names = {name: self.generator(k) for k, name in enumerate(self.names)}
        return parse(text, names.get, radical)

    def conjugate(self, k: int) -> Number:
        """Return the conjugate of a generator."""
        require(self.conjugates[k] is not None, f"the conjugate of g{k + 1} is not given")
        return self.conjugates[k]

    def check_conjugate(self, entry: Mapping[str, object], name: str) -> None:
        """Show that `conjugate` is the root of the conjugate polynomial in the mirrored box."""
        k = self.names.index(name)
        if "conjugate" not in entry:
            self.conjugates.append(self.generator(k) if self.real[k] else None)
            return
        require(not self.real[k], "a real generator is its own conjugate")
        value = self.parse(entry["conjugate"])
        mirrored = [conj(c) for c in self.polynomials[k]] + [Fraction(1)]
        require(vanishes(horner(mirrored, value)), f"the conjugate of {name} is no conjugate root")
        mirror, box = self.starts[k], enclose(value)
        require(box.inside(mirror.conj()), f"the conjugate of {name} is another root")
        self.conjugates.append(value)
