"""The Lie algebra of splittings, and its images at trees (section 6.4)."""

from __future__ import annotations

from functools import cache
from itertools import product
from math import factorial
from typing import TypeAlias

from .arithmetic import Fraction
from .classes import Span
from .trees import Tree, size

#: An element of the free algebra: coefficients by word.
Words: TypeAlias = dict[str, Fraction | int]


@cache
def colour_words(t: Tree) -> dict[str, int]:
    """Return {colours of the vertices, children before parents: number of ways}."""
    found = {"": 1}
    for child in t[1]:
        more = {}
        for (x, m), (y, n) in product(found.items(), colour_words(child).items()):
            for word, count in shuffles(x, y).items():
                more[word] = more.get(word, 0) + m * n * count
        found = more
    return {word + t[0]: n for word, n in found.items()}


@cache
def shuffles(x: str, y: str) -> dict[str, int]:
    """Return the shuffles of two words, counted."""
    if not x or not y:
        return {x + y: 1}
    found = {}
    for rest, last in ((shuffles(x[:-1], y), x[-1]), (shuffles(x, y[:-1]), y[-1])):
        for word, n in rest.items():
            found[word + last] = found.get(word + last, 0) + n
    return found


def word_product(x: Words, y: Words, degree: int) -> Words:
    """Return x y in the free algebra, through a degree."""
    found = {}
    for (u, a), (v, b) in product(x.items(), y.items()):
        if len(u) + len(v) <= degree:
            found[u + v] = found.get(u + v, 0) + a * b
    return {w: a for w, a in found.items() if a}


def word_sum(x: Words, y: Words, factor: Fraction | int = 1) -> Words:
    """Return x + factor y."""
    found = dict(x)
    for w, a in y.items():
        found[w] = found.get(w, 0) + factor * a
    return {w: a for w, a in found.items() if a}


@cache
def verlet_logarithm(degree: int, outer: str) -> Words:
    """Return log(exp(X/2) exp(Y) exp(X/2)) through a degree, X the letter `outer`."""

    def exponential(letter: str, scale_: Fraction) -> Words:
        return {letter * n: scale_**n / factorial(n) for n in range(degree + 1)}

    half = exponential(outer, Fraction(1, 2))
    whole_ = exponential("k" if outer == "f" else "f", Fraction(1))
    step_ = word_product(word_product(half, whole_, degree), half, degree)
    step_.pop("")
    value: Words = {}
    power: Words = {"": Fraction(1)}
    for n in range(1, degree + 1):
        power = word_product(power, step_, degree)
        value = word_sum(value, power, Fraction((-1) ** (n + 1), n))
    return value


@cache
def lie_elements(n: int, kind: str) -> list[Words]:
    """Return elements that span degree n of the Lie algebra of a kind of method (6.4).

    All brackets [letter, element] of smaller degree: the right-nested ones span.
    """
    if kind == "splitting":
        letters: dict[int, list[Words]] = {1: [{"f": Fraction(1)}, {"k": Fraction(1)}]}
    else:
        log = verlet_logarithm(n, kind)
        letters = {m: [{w: a for w, a in log.items() if len(w) == m}] for m in range(1, n + 1, 2)}
    found, span = [], Span()
    for x in letters.get(n, []):
        if span.add(x):
            found.append(x)
    for m, some in letters.items():
        for x, y in product(some, lie_elements(n - m, kind) if m < n else ()):
            z = word_sum(word_product(x, y, n), word_product(y, x, n), -1)
            if span.add(z):
                found.append(z)
    return found


@cache
def lie_images(t: Tree, kind: str) -> list[Fraction | int]:
    """Return the residual of a tree for each element of the Lie algebra."""
    words = colour_words(t)
    return [sum((n * x.get(w, 0) for w, n in words.items()), Fraction(0))
            for x in lie_elements(size(t), kind)]  # fmt: skip
