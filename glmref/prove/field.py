"""Number fields as towers, for certificates and Coq: generators with monic polynomials and boxes.

Square roots of rationals become products of square roots of a few independent whole numbers.
Another radical is first looked for in the field made so far, as a rational combination of its
basis (found by lattice reduction, checked exactly); only where it is not there it becomes a new
generator.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from fractions import Fraction
from functools import lru_cache
from itertools import product
from math import gcd, isqrt
from typing import Any

from ..catalogue.files import document as shipped_document
from ..errors import ExactnessError
from ..exact import Exact, RationalCombinations, box, cyclotomic, factorization
from ..exact.expression import parse
from ..exact.judging import Fraction as rational
from ..exact.judging import as_scalar
from ..exact.relations import BITS
from ..judge.grammar import (
    Exponential,
    Expression,
    Name,
    Negative,
    Product,
    Reader,
    Root,
    Sum,
    written_out,
)
from ..judge.refusals import NotShown

_MAY_HOLD_ONE = re.compile(r"sqrt|root|exp|(?<![A-Za-z_0-9])i(?![A-Za-z_0-9])")
_LARGEST = 64  # degree of a field
#: Members of a document that hold words.
_PROSE = frozenset(
    {"name", "title", "source", "notes", "broken", "claims", "enclosure", "stages", "row"}
)


def radicals_of(text: str) -> list[str]:
    """Return texts of the radicals in an entry, inner ones first; ``i`` outside exp is one."""

    def within(node: Expression) -> Iterator[str]:
        match node:
            case Name("i"):
                yield "i"
            case Negative(operand):
                yield from within(operand)
            case Sum(parts) | Product(parts):
                for _, part in parts:
                    yield from within(part)
            case Root(radicand, _, own):
                yield from within(radicand)
                yield own
            case Exponential(_, own):
                yield own

    return list(dict.fromkeys(within(Reader(text).read())))


@lru_cache(maxsize=256)
def tower_of(texts: tuple[str, ...]) -> Tower:
    """Return the field built from the texts of radicals, once for all files that have these."""
    return Tower(texts)


class Tower:
    """A field built from the texts of radicals.

    Parameters
    ----------
    texts : Iterable[str]
        Of radicals, inner ones before those that hold them.
    conjugates : bool
        Whether the conjugate of every generator is looked for.

    Raises
    ------
    ExactnessError
        For a field of too large a degree.
    """

    def __init__(self, texts: Iterable[str], *, conjugates: bool = True) -> None:
        self._conjugates = conjugates
        self.generators: list[dict[str, Any]] = []
        self.degrees: list[int] = []
        self.values: list[Exact] = []
        self.radicals: dict[str, str] = {}
        self._basis: dict[tuple[int, ...], Exact] = {(): Exact(1)}
        self._lattices: dict[tuple[int, frozenset[int]], RationalCombinations] = {}
        self._primes: dict[int, int] = {}
        texts = list(texts)
        plain = [(t, self._radicand(t)) for t in texts]
        for _, q in plain:
            if q is not None:
                self._prepare(q)
        for text, q in plain:
            self.radicals[text] = self._rational_root(q) if q is not None else self._other(text)

    def as_json(self) -> dict[str, Any]:
        """Return the key ``field`` of a certificate."""
        if not self.radicals:  # sqrt(4) needs no generator
            return {"kind": "rational"}
        return {"kind": "tower", "generators": self.generators, "radicals": self.radicals}

    @staticmethod
    def _radicand(text: str) -> Fraction | None:
        if text == "i":
            return Fraction(-1)
        if not text.startswith("sqrt("):
            return None
        value = parse(text[5:-1])
        assert isinstance(value, Exact)
        return value.as_fraction()

    def _prepare(self, q: Fraction) -> None:
        """Make generators for sqrt(q): of -1, and of a number that is independent of the others.

        It is free of squares where its factors are known.
        """
        if q < 0 and -1 not in self._primes:
            self._primes[-1] = len(self.generators)
            self._add(Exact(-1).sqrt(), [Fraction(1), Fraction(0)], conjugate=True)
        odd = 1
        for p, k in factorization(abs(q.numerator * q.denominator)).items() if q else ():
            odd *= p ** (k % 2)
        if odd > 1 and self._product(odd) is None:
            self._primes[odd] = len(self.generators)
            self._add(Exact(odd).sqrt(), [Fraction(-odd), Fraction(0)])

    def _product(self, n: int) -> list[int] | None:
        """Return radicands of generators whose product is n times a square, or ``None``."""
        known = [m for m in self._primes if m > 0]
        for chosen in product((0, 1), repeat=len(known)):
            total = n
            for m, used in zip(known, chosen, strict=True):
                total *= m**used
            if isqrt(total) ** 2 == total:
                return [m for m, used in zip(known, chosen, strict=True) if used]
        return None

    def _rational_root(self, q: Fraction) -> str:
        if q == 0:
            return "0"
        whole = abs(q.numerator * q.denominator)  # sqrt(q) = sqrt(whole) / denominator
        used = self._product(whole) or []
        total = whole
        for m in used:
            total *= m
        factor = Fraction(isqrt(total), q.denominator)
        names = []
        for m in ([-1] if q < 0 else []) + used:
            factor /= abs(m)
            names.append(self.generators[self._primes[m]]["name"])
        return "*".join([str(factor), *names])

    def _add(
        self, value: Exact, polynomial: list[Any], *, conjugate: bool = False, order: int = 0
    ) -> str:
        """Make a generator: a root of unity where its order is given."""
        degree = len(polynomial)
        total = degree
        for d in self.degrees:
            total *= d
        if total > _LARGEST:
            raise ExactnessError(f"a number field of degree {total} is not written out")
        name = f"g{len(self.generators) + 1}"
        real, imag = box(value)
        entry: dict[str, Any] = {
            "name": name,
            "polynomial": [str(x) for x in polynomial],
            "real": [str(x) for x in real],
            "imag": [str(x) for x in imag],
        }
        self.generators.append(entry)
        self.degrees.append(degree)
        self.values.append(value)
        monomials = dict(self._basis)
        self._basis = {(*x, 0): y for x, y in monomials.items()}
        for k in range(1, degree):
            monomials = {x: y * value for x, y in monomials.items()}
            self._basis |= {(*x, k): y for x, y in monomials.items()}
        self._lattices = {}
        if conjugate and self._conjugates:
            other = self._inverse_root(polynomial, order) or self._inside(value.conjugate())
            if other is None:
                raise ExactnessError("a field that conjugation does not keep is not written out")
            entry["conjugate"] = other
        return name

    def _inverse_root(self, polynomial: list[Any], order: int) -> str:
        """Return the conjugate of the last generator, a root of unity over the rationals."""
        if not order or not all(isinstance(x, int) for x in polynomial):
            return ""
        power = [1] + [0] * (len(polynomial) - 1)
        for _ in range(order - 1):
            last = power[-1]
            power = [x - last * y for x, y in zip([0, *power[:-1]], polynomial, strict=True)]
        others = (0,) * (len(self.degrees) - 1)
        return self._written({(*others, k): Fraction(x) for k, x in enumerate(power)})

    def _other(self, text: str) -> str:
        value = parse(text)
        assert isinstance(value, Exact)
        for entry, x in zip(self.generators, self.values, strict=True):
            if "conjugate" in entry and (value - x.conjugate()).is_zero():
                return entry["conjugate"]
        known = self._inside(value)
        if known is not None:
            return known
        if text.startswith("sqrt("):
            inner = self.element(parse(text[5:-1]))
            return self._add(value, [f"-({inner})", "0"], conjugate=not value.is_real())
        if text.startswith("root("):
            radicand, _, n = text[5:-1].rpartition(",")
            inner = self.element(parse(radicand))
            return self._add(value, [f"-({inner})", *(["0"] * (int(n) - 1))])
        for n in range(1, 61):  # a root of unity
            if (value**n - 1).is_zero():
                return self._add(value, self._least_polynomial(value, n), conjugate=True, order=n)
        raise ExactnessError(f"{text} is not written out")

    def _least_polynomial(self, value: Exact, n: int) -> list[Any]:
        """Return that of a root of unity over the field so far, which may have powers of it."""
        whole = cyclotomic(n)[:-1]
        basis, powers = dict(self._basis), [Exact(1)]
        apart = all(gcd(x.cyclotomic_order or n, n) <= 2 for x in self.values)
        for degree in range(1, 1 if apart else len(whole)):
            powers.append(powers[-1] * value)
            if len(whole) % degree == 0:
                columns = [(k, x) for k in range(degree) for x in basis]
                products = [powers[k] * basis[x] for k, x in columns]
                weights = RationalCombinations(products).weights(powers[degree])
                if weights is not None:
                    found = dict(zip(columns, weights, strict=True))
                    return [self._written({x: -found[k, x] for x in basis}) for k in range(degree)]
        return whole

    def element(self, value: Any) -> str:
        """Return a number of the field as a sum of products of generators.

        Raises
        ------
        ExactnessError
            For a number that is not in the field.
        """
        found = self._inside(value)
        if found is None:
            raise ExactnessError("a number lies outside the field of its certificate")
        return found

    def scalar(self, x: Any) -> Exact:
        """Return a number of the judge, over this field, as one of the package."""
        if type(x) is rational:
            found = as_scalar(x)
            assert isinstance(found, Exact)
            return found
        terms = zip(map(int, x.nums), self._basis.values(), strict=False)
        return sum((y * n for n, y in terms if n), Exact(0)) / int(x.den)

    def coordinates(
        self, value: Exact, radicals: Iterable[str] = ()
    ) -> dict[tuple[int, ...], Fraction]:
        """Return a number of the field: weights of the products of generators, by their exponents.

        Parameters
        ----------
        value : Exact
            The number.
        radicals : Iterable[str]
            Those of which it is made, and what stands in them; all by default.

        Raises
        ------
        ExactnessError
            For a number that is not in the field.
        """
        waiting, used = [self.radicals[x] for x in radicals], set[int]()
        while waiting:
            new = {int(x) - 1 for x in re.findall(r"g(\d+)", waiting.pop())} - used
            used |= new
            waiting += (x for k in new for x in self.generators[k]["polynomial"])
        first = max(BITS, 64 * len(self._basis))  # weights of 15 digits need some 50 bits each
        for bits in (first, 4 * first, 16 * first):
            found = self._coordinates(value, bits, used)
            if found is not None:
                return found
        raise ExactnessError("a number lies outside the field of its certificate")

    def _coordinates(
        self, value: Exact, bits: int, used: Collection[int] = ()
    ) -> dict[tuple[int, ...], Fraction] | None:
        fraction = value.as_fraction()
        if fraction is not None:
            return {(0,) * len(self.degrees): fraction}
        basis = {
            powers: x
            for powers, x in self._basis.items()
            if not used or all(k in used for k, n in enumerate(powers) if n)
        }
        key = bits, frozenset(used)
        if key not in self._lattices:
            self._lattices[key] = RationalCombinations(list(basis.values()), bits)
        weights = self._lattices[key].weights(value)
        return None if weights is None else dict(zip(basis, weights, strict=True))

    def _inside(self, value: Exact) -> str | None:
        found = self._coordinates(value, BITS)
        return None if found is None else self._written(found)

    @staticmethod
    def _written(found: Mapping[tuple[int, ...], Fraction]) -> str:
        """Return the sum of weights times products of generators, by their exponents."""
        terms = []
        for powers in sorted(x for x, w in found.items() if w):
            names = [f"g{i + 1}" for i, k in enumerate(powers) for _ in range(k)]
            terms.append("*".join([f"{found[powers]}", *names]))
        return "+".join(terms).replace("+-", "-") or "0"


class Texts:
    """The radicals in the entries of a document, inner ones first."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.constants = dict(document.get("constants", {}))
        self.radicals: dict[str, None] = {}
        self.add({**document, "constants": {}})
        for name in self.constants:
            self.radicals |= self._in(self.constants[name])

    def add(self, value: object) -> None:
        """Take in the entries below a value."""
        self.radicals = self.with_more(value)

    def with_more(self, value: object) -> dict[str, None]:
        """Return the radicals together with those below a value."""
        found = dict(self.radicals)
        for text in dict.fromkeys(_strings(value)):
            found |= self._in(text)
        return found

    def _in(self, text: str) -> dict[str, None]:
        """Return the radicals of one entry; words such as rules and trees hold none."""
        if self.constants or _MAY_HOLD_ONE.search(text):
            with suppress(NotShown):  # else the judge says so
                return dict.fromkeys(radicals_of(written_out(text, self.constants)))
        return {}


def _strings(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            if key not in _PROSE:
                yield from _strings(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _strings(inner)


def texts_of_decimals(document: Mapping[str, Any], *, exact: bool) -> Texts:
    """Return the exact entries of a document with decimals; without a start where it has those."""
    plain = {k: v for k, v in document.items() if k not in ("unknowns", "claims")}
    if plain.get("class") == "composition":
        plain = {"x": [plain, shipped_document(plain["base"])]}
    elif not exact:
        plain = {k: v for k, v in plain.items() if k not in ("starting", "finishing")}
    found = Texts(plain)
    found.add(equation_numbers(document))
    return found


def field_of_decimals(kind: str, radicals: Iterable[str]) -> dict[str, Any]:
    """Return the field of a statement about decimals, from the radicals beside them."""
    found = tower_of(tuple(radicals)).as_json()
    return {"kind": kind} | {k: found.get(k, x) for k, x in (("generators", []), ("radicals", {}))}


def about(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document as certificates hold it, without words and claims."""
    return {k: v for k, v in document.items() if k not in ("claims", "source", "notes", "title")}


def equation_numbers(document: Mapping[str, Any]) -> list[str]:
    """Return numbers that stand in the names of equations: eigenvalues and abscissae."""
    found = []
    for text in document.get("enclosure", {}).get("equations", ()):
        kind, _, rest = text.partition(" ")
        if kind == "growth":
            found.append(rest.removeprefix("q ").removeprefix("p "))
    return found
