"""Polynomials and where their roots lie: Schur, Cohn, Sturm, Yun (section 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise

from .arithmetic import Fraction, Number, Ring, tick
from .linalg import at_matrix, characteristic, times
from .numbers import conj, inverse, is_enclosure, is_nil, live, sign, squared, vanishes
from .refusals import T, require


def horner(coefficients: list, x: T) -> T:
    """Return the value of a polynomial, constant first."""
    value = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        value = value * x + c
    return value


def derivative(p: list) -> list:
    """Return p' of a list of coefficients, constant first."""
    return [k * c for k, c in enumerate(p)][1:] or [Fraction(0)]


def trim(p: Iterable) -> list:
    """Return p without leading zeros; constant first."""
    p = list(p)
    while p and not p[-1]:
        p.pop()
    return p


def multiply(p: list, q: list) -> list:
    """Return p q."""
    out = [Fraction(0)] * (len(p) + len(q) - 1) if p and q else []
    for i, a in enumerate(p):
        tick()
        for j, b in enumerate(q):
            if not (is_nil(a) or is_nil(b)):
                out[i + j] = out[i + j] + a * b
    return trim(out)


def plus(p: list, q: list, factor: Number = 1) -> list:
    """Return p + factor q."""
    n = max(len(p), len(q))
    p, q = (list(x) + [Fraction(0)] * (n - len(x)) for x in (p, q))
    return trim([a + factor * b for a, b in zip(p, q, strict=True)])


def divide(p: list, q: list) -> tuple[list, list]:
    """Return quotient and remainder."""
    p, q, unit, out = trim(p), trim(q), inverse(trim(q)[-1]), []
    out = [Fraction(0)] * max(len(p) - len(q) + 1, 0)
    while len(p) >= len(q):
        tick()
        shift, factor = len(p) - len(q), p[-1] * unit
        out[shift] = factor
        p = trim([x - factor * q[i - shift] if i >= shift else x for i, x in enumerate(p)][:-1])
    return out, p


def gcd(p: list, q: list) -> list:
    """Return a monic greatest common divisor."""
    p, q = trim(p), trim(q)
    while q:
        p, q = q, divide(p, q)[1]
    return [inverse(p[-1]) * x for x in p]


def mirror(p: list) -> list:
    """Return p~, the coefficients conjugated and reversed."""
    return [conj(x) for x in reversed(p)]


def margins(p: Iterable, lower: Callable[[list, Number], list] | None = None) -> Iterator:
    """Yield |p_n|^2 - |p_0|^2 along the steps of Schur and Cohn, None where Cohn's step fails.

    `lower` may take a factor out of all coefficients, given the leading one of the step before.
    """
    p, last = trim(p), None
    require(p, "a polynomial is 0")
    while len(p) > 1:
        a, b = conj(p[-1]), p[0]
        if not is_enclosure(b) and not b:
            p = p[1:]
            continue
        margin = squared(a) - squared(b)
        yield margin
        if margin:
            head, p = p[-1], [a * x - b * y for x, y in zip(p, mirror(p), strict=True)][1:]
            p, last = p if last is None or lower is None else lower(p, last), head
        elif vanishes([conj(a) * x - conj(b) * y for x, y in zip(mirror(p), p, strict=True)]):
            p, last = derivative(p), None
        else:
            yield None
            return


def is_schur(p: list) -> bool:
    """Tell whether all roots lie inside the circle (Schur, Cohn)."""
    return all(sign(x) > 0 for x in margins(p))


def in_disc(p: list) -> bool:
    """Tell whether all roots lie in the closed disc (Schur, Cohn)."""
    return all(x is not None and sign(x) >= 0 for x in margins(p))


def is_unbounded(M: list) -> bool:
    """Tell whether the powers of M are not bounded: a root outside, or a defective one on it.

    What the characteristic polynomial shares with its mirror image is q, the rest is h.
    """
    p = characteristic(M)
    if not in_disc(p):
        return True
    h, q = p, [Fraction(1)]
    while not live(h[0]):
        h = h[1:]
    inside = p[: len(p) - len(h)]  # the roots 0, which the mirror image has at infinity
    while len(h) > 1 and len(shared := gcd(h, mirror(h))) > 1:
        h, q = divide(h, shared)[0], multiply(q, shared)
    require(is_schur(h), "a root on the circle is left")
    left = at_matrix(divide(q, gcd(q, derivative(q)))[0], M)
    rest = at_matrix(inside + h, M)
    for _ in M:  # rad(q)(M) h(M)^r is 0 where no root of q is defective
        left = times(left, rest)
    return not vanishes(left)


def from_roots(numbers: Iterable) -> list:
    """Return the product of (x - mu)."""
    p = [Fraction(1)]
    for mu in numbers:
        p = plus([Fraction(0), *p], p, -mu)
    return p


def interpolate(nodes: list, values: list) -> list:
    """Return the polynomial with these values at the nodes (Newton)."""
    p, basis, rest = [], [Fraction(1)], list(values)
    for k, node in enumerate(nodes):
        p = plus(p, basis, rest[0])
        basis = multiply(basis, [-node, Fraction(1)])
        steps = [y - x for x, y in zip(nodes, nodes[k + 1 :], strict=False)]
        rest = [(b - a) * (1 / step) for (a, b), step in zip(pairwise(rest), steps, strict=True)]
    return p


class OnAxis(Ring):
    """A polynomial in z = i y with real coefficients; its conjugate has -z in the place of z."""

    __slots__ = ("p",)

    def __init__(self, p: Iterable) -> None:
        self.p = trim(p)

    def __bool__(self) -> bool:
        return bool(self.p)

    def __add__(self, other: OnAxis) -> OnAxis:
        return OnAxis(plus(self.p, other.p))

    def __mul__(self, other: Number) -> OnAxis:
        return OnAxis(multiply(self.p, other.p if isinstance(other, OnAxis) else [other]))

    __rmul__ = __mul__

    def conj(self) -> OnAxis:
        """Return the conjugate."""
        return OnAxis([-c if k % 2 else c for k, c in enumerate(self.p)])


def sturm_chain(p: list) -> list:
    """Return the chain of Sturm of p and p', with leading coefficients 1 or -1 after the first."""
    chain, rest = [trim(p)], trim(derivative(trim(p)))
    while rest:
        unit = inverse(rest[-1])
        chain.append([sign(unit) * unit * x for x in rest])
        rest = [-x for x in divide(chain[-2], chain[-1])[1]]
    return chain


def sign_changes(signs: Iterable[int]) -> int:
    """Return how often the sign changes, zeros left out."""
    return sum(a != b for a, b in pairwise(x for x in signs if x))


def real_roots(p: list) -> int:
    """Return the number of different real roots of p (Sturm)."""
    chain = sturm_chain(p)
    left, right = ([sign(q[-1]) * end ** (len(q) - 1) for q in chain] for end in (-1, 1))
    return sign_changes(left) - sign_changes(right)


def odd_factors(p: list) -> Iterator[list]:
    """Yield the factors of p of odd multiplicity, each once (Yun)."""
    p = trim(p)
    common = gcd(p, derivative(p))
    first, rest, k = divide(p, common)[0], common, 1
    while len(first) > 1:
        shared = gcd(first, rest)
        factor = divide(first, shared)[0]
        if k % 2 and len(factor) > 1:
            yield factor
        first, rest, k = shared, divide(rest, shared)[0], k + 1


def nowhere_negative(p: list) -> bool:
    """Tell whether p(y) >= 0 for all real y: no real root of odd multiplicity, a positive end."""
    p = trim(p)
    if sign(p[-1]) < 0 or len(p) % 2 == 0:
        return False
    return not any(map(real_roots, odd_factors(p)))


def no_root_but_zero(p: list) -> bool:
    """Tell whether p has no real root other than 0."""
    while p and not p[0]:
        p = p[1:]
    return len(p) <= 1 or not real_roots(p)
