"""Towers of algebraic numbers over the rationals (section 2)."""

from fractions import Fraction

from .grammar import parse, rational
from .krawczyk import root_in
from .linalg import solve, transpose
from .numbers import Box, Element, Interval, conj, enclose, vanishes
from .polynomials import horner
from .refusals import keys, require

DIMENSION = 64  # of a tower over the rationals


class Tower:
    """The rationals with generators; arithmetic by reduction, enclosures by bisection (2)."""

    def __init__(self, generators=()):
        self.names, self.degrees, self.polynomials, self.roots = [], [], [], []
        self.real, self.conjugates, self.inverses, self.starts = [], [], {}, []
        self.tables, self.basis, self.index, self.balls = {}, [()], {(): 0}, {}
        require(isinstance(generators, list | tuple), "generators are a list")
        for k, entry in enumerate(generators):
            keys(entry, "name polynomial real imag", "conjugate", "generator")
            require(entry["name"] == f"g{k + 1}", "generators are called g1, g2, ..")
            self.adjoin(entry)
        for entry, name in zip(generators, self.names, strict=True):
            self.check_conjugate(entry, name)

    def adjoin(self, entry):
        """Add a generator: its polynomial, and a box that is shown to hold one root."""
        polynomial = entry["polynomial"]
        require(isinstance(polynomial, list) and polynomial, "a polynomial is a list")
        degree = len(polynomial)
        require(2 <= degree and degree * len(self.basis) <= DIMENSION, "degrees of the tower")
        self.polynomials.append([self.parse(text) for text in polynomial])
        ends = [[rational(x) for x in entry[key]] for key in ("real", "imag")]
        require(all(len(x) == 2 and x[0] <= x[1] for x in ends), "a box has ends that are ordered")
        real_, p = ends[1] == [0, 0], [enclose(x) for x in [*self.polynomials[-1], Fraction(1)]]
        box = Box(*(Interval.ends(*x) for x in ends))
        if real_:
            fine = all(x.im.lo == 0 == x.im.hi for x in p)
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
        self.tables, self.inverses = {}, {}

    def element(self, terms):
        """Return a reduced element, as a rational where it is one."""
        terms = {k: x for k, x in terms.items() if x}
        if set(terms) <= {0}:
            return Fraction(terms.get(0, 0))
        return Element(self, terms)

    def generator(self, k):
        """Return g_(k+1)."""
        return self.element({self.index[tuple(int(j == k) for j in range(len(self.names)))]: 1})

    def table(self, i, j):
        """Return the product of two monomials of the basis, reduced."""
        if (i, j) not in self.tables:
            powers = tuple(a + b for a, b in zip(self.basis[i], self.basis[j], strict=True))
            self.tables[i, j] = list(self.reduce(powers).items())
        return self.tables[i, j]

    def reduce(self, powers):
        """Return a monomial by the monic polynomials."""
        high = next((k for k in reversed(range(len(powers))) if powers[k] >= self.degrees[k]), None)
        if high is None:
            return {self.index[powers]: Fraction(1)}
        terms, degree = {}, self.degrees[high]
        for k, c in enumerate(self.polynomials[high]):
            for at, x in c.terms.items() if isinstance(c, Element) else ((0, c),):
                inner = self.basis[at] + (0,) * (len(powers) - len(self.basis[at]))
                moved = [a + b for a, b in zip(powers, inner, strict=True)]
                moved[high] += k - degree
                for index, y in self.reduce(tuple(moved)).items() if x else ():
                    terms[index] = terms.get(index, 0) - x * y
        return terms

    def inverse(self, x):
        """Return y with x y = 1 in the ring."""
        if x not in self.inverses:
            n = len(self.basis)
            columns = []
            for k in range(n):
                y = x * self.element({k: Fraction(1)})
                terms = y.terms if isinstance(y, Element) else {0: y}
                columns.append([terms.get(i, Fraction(0)) for i in range(n)])
            y, _ = solve(transpose(columns), [Fraction(int(i == 0)) for i in range(n)])
            require(y is not None, "a divisor has no inverse in the ring of the tower")
            self.inverses[x] = self.element(dict(enumerate(y)))
        return self.inverses[x]

    def parse(self, text, radical=None):
        """Return a number of the certificate: rationals, names of generators, and radicals."""
        names = {name: self.generator(k) for k, name in enumerate(self.names)}
        return parse(text, names.get, radical)

    def conjugate(self, k):
        """Return the conjugate of a generator."""
        require(self.conjugates[k] is not None, f"the conjugate of g{k + 1} is not given")
        return self.conjugates[k]

    def check_conjugate(self, entry, name):
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
