"""Sums of products of roots of unity and of real roots of rationals, where zero is decided at once.

A number is kept as ``sum c_M M`` over products M of powers ``p^e`` of primes, ``0 < e < 1/2``. The
coefficients c_M lie in the cyclotomic field Q(zeta_n), n the least common multiple of the orders
met: they are polynomials modulo the n-th cyclotomic one. Square roots of primes are sums of roots
of unity (Gauss).

It is zero only where every coefficient is. For the products M are linearly independent over the
union Q^ab of the cyclotomic fields: a positive rational a is an n-th power there only where a^2 is
one of a rational (Schinzel, Acta Arith. 32 (1977) 245), so that the M stand for different elements
of Q^ab* M / Q^ab*, and then Kummer theory applies, all roots of unity being at hand.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import lru_cache
from itertools import product
from math import gcd, lcm, prod
from typing import Any

import flint

from ..errors import ExactnessError
from ..system.budget import spend
from .field import FIELD, MAX_BITS, as_fmpq

#: Largest degree of a cyclotomic field.
MAX_DEGREE = 600
#: Largest radicand whose primes are looked for, and longest text of a number that is converted.
MAX_RADICAND, MAX_TEXT = 10**12, 2000
#: Largest degree times bits of a number that is inverted: FLINT is not interrupted meanwhile.
MAX_INVERSE = 40_000

Monomial = tuple[tuple[int, Fraction], ...]
#: A generator of a field as flint prints it, and a minimal polynomial of a radical.
GENERATOR = re.compile(
    r"(?P<name>[a-z]\d*) = (?P<size>[^\[]*)\[(?:Sqrt\([^{]*\{(?P<radicand>[^}]*)\}\)"
    r"|(?:Sqrt|Pow)\((?:[^{,]*\{)?(?P<base>[^},)]*)\}?(?:, [^{]*\{(?P<part>-?\d+/\d+)\})?\)"
    r"|Conjugate\([^{]*\{(?P<conjugate>[^}]*)\}\)|(?P<minpoly>[^\]]*)=0)\]"
)
RADICAL = re.compile(r"(?:(?P<a>\d+)\*)?[a-z]\d*\^(?P<n>\d+)-(?P<c>\d+)")


class BeyondError(Exception):
    """A number that is not of this kind, or in too large a field."""


@lru_cache(maxsize=256)
def _modulus(n: int) -> flint.fmpq_poly:
    """Return the n-th cyclotomic polynomial."""
    if int(flint.fmpz(n).euler_phi()) > MAX_DEGREE:
        raise BeyondError
    return flint.fmpq_poly(flint.fmpz_poly.cyclotomic(n))


def _raised(coefficient: flint.fmpq_poly, step: int, n: int) -> flint.fmpq_poly:
    """Return a polynomial in ``zeta_n^step``, reduced."""
    spread = [flint.fmpq(0)] * n
    for k, x in enumerate(coefficient.coeffs()):
        spread[k * step % n] += x
    return flint.fmpq_poly(spread) % _modulus(n)


class Roots:
    """A number of this kind.

    Parameters
    ----------
    order : int
        n of the cyclotomic field.
    terms : mapping
        Product of powers of primes -> coefficient, reduced and not zero.
    """

    __slots__ = ("order", "terms")

    def __init__(self, order: int, terms: Mapping[Monomial, flint.fmpq_poly]) -> None:
        self.order = order
        self.terms = {m: c for m, c in terms.items() if c}

    @classmethod
    def rational(cls, q: flint.fmpq) -> Roots:
        """Return a rational number."""
        return cls(1, {(): flint.fmpq_poly([q])})

    @classmethod
    def of_unity(cls, turn: Fraction) -> Roots:
        """Return ``exp(2 pi i turn)``."""
        n = turn.denominator
        return cls(n, {(): _raised(flint.fmpq_poly([0, 1]), turn.numerator % n, n)})

    @classmethod
    def power(cls, base: Fraction, exponent: Fraction) -> Roots:
        """Return the positive power of a positive rational, or the principal one of -1."""
        if base == -1:
            return cls.of_unity(exponent / 2)
        if base <= 0 or max(base.numerator, base.denominator) > MAX_RADICAND:
            raise BeyondError
        found = _ONE
        for number, sign in ((base.numerator, 1), (base.denominator, -1)):
            for p, k in flint.fmpz(number).factor():
                found = found * _prime_power(int(p), sign * int(k) * exponent)
        return found

    # -- arithmetic --------------------------------------------------------------------------------

    def _lifted(self, n: int) -> dict[Monomial, flint.fmpq_poly]:
        if n == self.order:
            return self.terms
        step = n // self.order
        return {m: _raised(c, step, n) for m, c in self.terms.items()}

    def _joined(self, other: Roots, operation: Any) -> Roots:
        n = lcm(self.order, other.order)
        _modulus(n)
        terms = dict(self._lifted(n))
        for m, c in other._lifted(n).items():
            terms[m] = operation(terms.get(m, _NIL), c)
        return Roots(n, terms)

    def __add__(self, other: Roots) -> Roots:
        return self._joined(other, operator.add)

    def __sub__(self, other: Roots) -> Roots:
        return self._joined(other, operator.sub)

    def __mul__(self, other: Roots) -> Roots:
        n = lcm(self.order, other.order)
        modulus = _modulus(n)
        terms: dict[Monomial, flint.fmpq_poly] = {}
        total = Roots(n, terms)
        right = other._lifted(n)
        for a, x in self._lifted(n).items():
            spend()
            for b, y in right.items():
                c = x * y % modulus
                if not a or not b:
                    terms[a or b] = terms.get(a or b, _NIL) + c
                    continue
                monomial, factor = _product(a, b)
                total = total + Roots(n, {monomial: c})._times_coefficient(factor)
        return total + Roots(n, terms) if total.terms else Roots(n, terms)

    def _times_coefficient(self, factor: Roots) -> Roots:
        """Return the product with a cyclotomic number."""
        n = lcm(self.order, factor.order)
        modulus, (other,) = _modulus(n), factor._lifted(n).values()
        return Roots(n, {m: c * other % modulus for m, c in self._lifted(n).items()})

    def inverse(self) -> Roots:
        """Return 1/x, from the product of its conjugates over the cyclotomic field.

        Raises
        ------
        ExactnessError
            Where it would take more than some tenths of a second.
        ZeroDivisionError
            For zero.
        """
        if not self.terms:
            raise ZeroDivisionError("division by an exact zero")
        if len(self.terms) == 1:
            ((monomial, c),) = self.terms.items()
            bits = c.numer().height_bits() + int(c.denom()).bit_length()
            if bits * c.degree() > MAX_INVERSE:
                raise ExactnessError(
                    f"a sum of {c.degree() + 1} roots of unity with numbers of {bits} bits "
                    f"is not divided by; shorten the numbers"
                )
            common, s, _ = c.xgcd(_modulus(self.order))
            found = Roots(self.order, {(): s / common[0]})
            for p, e in monomial:
                found = found * _prime_power(p, -e)
            return found
        first, *others = self._conjugates()
        rest = _ONE
        for x in others:
            spend()
            rest = rest * x
        return rest * (first * rest).inverse()

    def _conjugates(self) -> Iterator[Roots]:
        """Return the products of powers in which every p^(1/m) takes another of its values."""
        depth: dict[int, int] = {}
        for monomial in self.terms:
            for p, e in monomial:
                depth[p] = lcm(depth.get(p, 1), e.denominator)
        values = {p: m if m % 2 else m // 2 for p, m in depth.items()}  # sqrt(p) is kept
        if prod(values.values()) > MAX_DEGREE:
            raise BeyondError
        for turns in product(*(range(x) for x in values.values())):
            turned = dict(zip(depth, turns, strict=True))
            total = _NOTHING
            for monomial, c in self.terms.items():
                turn = Fraction(0)
                for p, e in monomial:
                    turn += e * depth[p] * Fraction(turned[p], values[p])
                total = total + Roots(self.order, {monomial: c}) * Roots.of_unity(turn)
            yield total

    def conjugate(self) -> Roots:
        """Return the complex conjugate: the products of primes are real."""
        n = self.order
        return Roots(n, {m: _raised(c, n - 1, n) for m, c in self.terms.items()})

    # -- what it is --------------------------------------------------------------------------------

    def as_rational(self) -> flint.fmpq | None:
        """Return the number where it is rational, else ``None``."""
        if not self.terms:
            return flint.fmpq(0)
        c = self.terms.get((), _NIL) if len(self.terms) == 1 else _NIL
        return c[0] if c.degree() == 0 else None

    def enclosed(self, bits: int) -> flint.acb:
        """Return a ball of relative width about ``2**-bits``."""
        before, precision = flint.ctx.prec, bits + 64
        try:
            while True:
                flint.ctx.prec = precision
                zeta = flint.acb(flint.fmpq(2, self.order)).exp_pi_i()
                total = flint.acb(0)
                for monomial, c in self.terms.items():
                    value = flint.acb_poly(c.coeffs())(zeta)
                    for p, e in monomial:
                        value *= flint.arb(p) ** flint.arb(as_fmpq(e))
                    total += value
                size = total.abs_lower()
                width = total.real.rad() + total.imag.rad()
                if not self.terms or width * flint.arb(2) ** bits < size or precision > MAX_BITS:
                    return total
                precision *= 2
        finally:
            flint.ctx.prec = before

    def element(self) -> Any:
        """Return the same number in flint's field, of square roots where it can be.

        flint knows no relation between a root of unity and its conjugate: a number of both is
        long, and is compared by its minimal polynomial, which takes hours.
        """
        zeta = FIELD(-1) ** flint.fmpq(2, self.order)
        total = FIELD(0)
        for monomial, c in self.terms.items():
            value = FIELD(0)
            weights = Roots(self.order, {(): c})._square_roots()
            for x in reversed(c.coeffs()) if weights is None else ():
                value = value * zeta + FIELD(x)
            for d, weight in (weights or {}).items():
                turned = FIELD(-1).sqrt() if d < 0 else FIELD(1)
                value = value + FIELD(weight) * FIELD(abs(d)).sqrt() * turned
            for p, e in monomial:
                value = value * FIELD(p) ** as_fmpq(e)
            total = total + value
        return total

    # -- text --------------------------------------------------------------------------------------

    def text(self) -> str | None:
        """Return the number in the grammar of entries; ``None`` if that lacks a root of its order.

        Coefficients are sums of square roots where they can be, else sums of roots of unity.
        """
        try:
            return self._text()
        except BeyondError:
            return None

    def _text(self) -> str | None:
        terms = []
        for monomial, c in sorted(self.terms.items()):
            part = Roots(self.order, {(): c})
            for p, e in monomial:  # 2^(1/6) sqrt(2) is 2^(2/3)
                if (e + Fraction(1, 2)).denominator % 2:
                    part = part * _square_root(p) * Roots.rational(flint.fmpq(1, p))
            inner = part._in_square_roots() or part._in_roots_of_unity()
            if inner is None:
                return None
            powers = [(p, max(e, e + Fraction(1, 2), key=lambda x: x.denominator % 2))
                      for p, e in monomial]  # fmt: skip
            names = [f"root({p**e.numerator},{e.denominator})" for p, e in powers]
            whole = _factor(inner) if names else inner
            terms.append("*".join([whole, *names]).removeprefix("1*"))
        return "+".join(terms).replace("+-", "-") or "0"

    def _square_roots(self) -> dict[int, flint.fmpq] | None:
        """Return weights of square roots of d, where it is their sum.

        The roots are orthogonal for ``Tr(x conj(y))``.
        """
        n = self.order
        roots = [1, *([-1] if n % 4 == 0 else []), *([2] if n % 8 == 0 else [])]
        roots += [p if p % 4 == 1 else -p for p in map(int, dict(flint.fmpz(n).factor())) if p > 2]
        chosen = {prod(x) for x in product(*((1, d) for d in roots))}
        found, weights = _NOTHING, {}
        for d in sorted(chosen, key=lambda d: (abs(d), -d)):
            root = Roots.power(Fraction(abs(d)), Fraction(1, 2))
            if d < 0:
                root = root * Roots.power(Fraction(-1), Fraction(1, 2))
            try:
                weight = (self * root.conjugate())._trace() / abs(d)
            except BeyondError:  # both together are in too large a field
                return None
            if weight:
                found = found + root * Roots.rational(weight)
                weights[d] = weight
        return weights if not (found - self).terms else None

    def _in_square_roots(self) -> str | None:
        """Return the number as a rational combination of square roots."""
        weights = self._square_roots()
        if weights is None:
            return None
        terms = []
        for d, weight in weights.items():
            names = ([f"sqrt({abs(d)})"] if abs(d) > 1 else []) + (["i"] if d < 0 else [])
            terms.append(_times(weight, names))
        return _sum(terms)

    def _trace(self) -> flint.fmpq:
        """Return the trace of a cyclotomic number divided by the degree of its field."""
        total = flint.fmpq(0)
        for k, x in enumerate(self.terms.get((), _NIL).coeffs()):
            m = self.order // gcd(self.order, k)
            total += x * flint.fmpq(flint.fmpz(m).moebius_mu(), flint.fmpz(m).euler_phi())
        return total

    def _in_roots_of_unity(self) -> str | None:
        """Return a sum of products of roots of unity of orders that entries may have."""
        n, coefficients = self.order, self.terms[()].coeffs()
        for turn in (Fraction(k, n) for k in range(n)):
            q = None
            if turn.denominator <= MAX_TURN:
                q = (self * Roots.of_unity(-turn)).as_rational()
            if q is not None:
                return _times(q, [f"exp({2 * turn.numerator}*pi*i/{turn.denominator})"])
        orders = [(int(p), int(p) ** int(k)) for p, k in flint.fmpz(n).factor()]
        inner = prod(q for _, q in orders if 24 % q == 0)  # of degree 2 over each other
        orders = [(p, q) for p, q in orders if 24 % q]
        if any(q > MAX_TURN for _, q in orders):
            return None
        # products of powers of roots of unity of prime power orders, each reduced
        products: dict[tuple[int, ...], Roots] = {}
        for k, x in enumerate(coefficients):
            key = tuple(k * pow(n // q, -1, q) % q for _, q in orders)
            turn = Fraction(k * pow(n // inner, -1, inner), inner)
            part = Roots.of_unity(turn) * Roots.rational(x)
            products[key] = products.get(key, _NOTHING) + part
        for at, (p, q) in enumerate(orders):
            reduced: dict[tuple[int, ...], Roots] = {}
            for powers, x in products.items():
                k = powers[at]
                high = k >= q - q // p
                for m in [k - j * (q // p) for j in range(1, p)] if high else [k]:
                    key = (*powers[:at], m, *powers[at + 1 :])
                    before = reduced.get(key, _NOTHING)
                    reduced[key] = before - x if high else before + x
            products = reduced
        terms = []
        for key, x in sorted(products.items()):
            names = [f"exp({2 * k}*pi*i/{q})" for k, (_, q) in zip(key, orders, strict=True) if k]
            q = x.as_rational()
            if q is not None:
                terms += [_times(q, names)] if q else []
            else:
                inside = x._in_square_roots()
                terms.append("*".join([_factor(str(inside)), *names] if names else [str(inside)]))
        return _sum(terms)


def _times(weight: flint.fmpq, names: list[str]) -> str:
    p, q = int(weight.p), int(weight.q)
    over = f"/{q}" if q > 1 else ""
    if not names:
        return f"{p}{over}"
    return "-" * (p < 0) + "*".join(([str(abs(p))] if abs(p) > 1 else []) + names) + over


def _factor(text: str) -> str:
    """Return a text as a factor: in parentheses where it is a sum."""
    return f"({text})" if re.search("[-+]", text[1:]) else text


def _sum(terms: list[str]) -> str:
    return "+".join(terms).replace("+-", "-")


#: Largest denominator of a turn in the text of an entry.
MAX_TURN = 30
_NIL = flint.fmpq_poly([])
_ONE, _NOTHING = Roots.rational(flint.fmpq(1)), Roots(1, {})


@lru_cache(maxsize=1024)
def _prime_power(p: int, exponent: Fraction) -> Roots:
    """Return ``p^exponent``: a rational, perhaps with sqrt(p), and the rest as a product."""
    whole, half = divmod(exponent, Fraction(1, 2))
    q = flint.fmpq(p) ** (whole // 2)
    plain = Roots.rational(q) * _square_root(p) if whole % 2 else Roots.rational(q)
    return Roots(plain.order, {((p, half),): plain.terms[()]}) if half else plain


@lru_cache(maxsize=4096)
def _product(a: Monomial, b: Monomial) -> tuple[Monomial, Roots]:
    """Multiply two products of powers: return one with exponents below 1/2, and its coefficient."""
    exponents, factor = dict(a), _ONE
    for p, e in b:
        exponents[p] = exponents.get(p, Fraction(0)) + e
    rest = []
    for p, e in sorted(exponents.items()):
        whole, half = divmod(e, Fraction(1, 2))
        factor = factor * _prime_power(p, Fraction(whole, 2))
        rest += [(p, half)] if half else []
    return tuple(rest), factor


@lru_cache(maxsize=256)
def _square_root(p: int) -> Roots:
    """Return the positive square root of a prime, by Gauss's sum."""
    if p == 2:
        eighth = Roots.of_unity(Fraction(1, 8))
        return eighth + eighth.conjugate()
    _modulus(p)  # refuses what is too large
    squares = {k * k % p for k in range(1, p)}
    weights = [0, *(1 if k in squares else -1 for k in range(1, p))]
    gauss = Roots(p, {(): _raised(flint.fmpq_poly(weights), 1, p)})
    return gauss if p % 4 == 1 else gauss * Roots.of_unity(Fraction(-1, 4))


def roots_of(text: str) -> Roots | None:
    """Return the number that flint prints as a text, or ``None`` where it is none of this kind."""
    if len(text) > MAX_TEXT or "{" not in text:
        return None
    body, _, where = text[text.index("{") + 1 : -1].partition(" where ")
    names: dict[str, Roots] = {}
    try:
        for match in reversed(list(GENERATOR.finditer(where))):
            names[match["name"]] = _generator(match, names)
        return _value(ast.parse(body.replace("^", "**"), mode="eval").body, names)
    except (BeyondError, KeyError):
        return None


def _rational(text: str, names: Mapping[str, Roots]) -> Fraction:
    q = _value(ast.parse(text.replace("^", "**"), mode="eval").body, names).as_rational()
    if q is None:
        raise BeyondError
    return Fraction(int(q.p), int(q.q))


def _generator(match: re.Match[str], names: Mapping[str, Roots]) -> Roots:
    if match["conjugate"] is not None:
        return names[match["conjugate"]].conjugate()
    radicand = match["radicand"] or match["base"]
    if radicand is not None:
        q, exponent = _rational(radicand, names), Fraction(match["part"] or "1/2")
        if q < 0:
            return Roots.power(-q, exponent) * Roots.power(Fraction(-1), exponent)
        return Roots.power(q, exponent)
    size = complex(match["size"].replace(" ", "").replace("*I", "j").replace("I", "1j"))
    radical = RADICAL.fullmatch(match["minpoly"])
    if radical is not None and size.imag == 0 and size.real > 0:
        a, n, c = (int(x or 1) for x in radical.group("a", "n", "c"))
        return Roots.power(Fraction(c, a), Fraction(1, n))
    a, b, c = _polynomial(match["minpoly"], match["name"])
    q = b * b - 4 * a * c
    root = Roots.power(abs(q), Fraction(1, 2))
    if q < 0:
        root = root * Roots.power(Fraction(-1), Fraction(1, 2))
    first = (Roots.rational(as_fmpq(-b)) + root) * Roots.rational(as_fmpq(1 / (2 * a)))
    # which of the two roots: the sign before the square root, from the size that flint shows
    if (size.imag if q < 0 else size.real + float(b / (2 * a))) < 0:
        return first - root * Roots.rational(as_fmpq(1 / a))
    return first


def _polynomial(text: str, name: str) -> tuple[Fraction, Fraction, Fraction]:
    """Return the coefficients of a quadratic polynomial, the leading one first."""
    found = [Fraction(0)] * 3
    for sign, weight, power in re.findall(
        rf"([-+]?)(\d*)\*?((?:{name}(?:\^\d+)?)?)", text
    ):  # fmt: skip
        if not weight and not power:
            continue
        degree = 0 if not power else int(power.partition("^")[2] or 1)
        if degree > 2:
            raise BeyondError
        found[2 - degree] += Fraction(f"{sign}{weight or 1}")
    return found[0], found[1], found[2]


_OPERATIONS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul}


def _value(node: ast.AST, names: Mapping[str, Roots]) -> Roots:
    """Return the number of a sum of products of powers; one loop for a sum, which may be long."""
    match node:
        case ast.Constant(value=int() as n):
            return Roots.rational(flint.fmpq(n))
        case ast.Name(id=name):
            return names[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return _NOTHING - _value(operand, names)
        case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=int() as n)):
            base, found = _value(left, names), _ONE
            for _ in range(n):
                found = found * base
            return found
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return _value(left, names) * _value(right, names).inverse()
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATIONS:
            return _OPERATIONS[type(op)](_value(left, names), _value(right, names))
    raise BeyondError
