"""The text form of exact numbers, in the grammar of :mod:`glmref.judge.grammar`.

A decimal is read only where the file declares its digits, and gives a ball. A name is ``i`` or a
constant the file declares. ``root(x, n)`` is the positive n-th root of a positive real number. The
argument of ``exp`` is a rational multiple of ``pi*i``, as in ``exp(2*pi*i/3)``.

:func:`syntax_tree` reads a text; what is made of a tree is written in one place each: its number
here, LaTeX and MathML in :mod:`glmref.views.notation`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from math import isfinite, isqrt, prod
from operator import truediv
from typing import Any, NamedTuple

from ..errors import DataError, ExactnessError
from ..judge.grammar import (
    NUMERAL,
    TOKEN,
    Exponential,
    Expression,
    Name,
    Negative,
    Numeral,
    Product,
    Reader,
    Root,
    Sum,
    tokens,
    value_of,
)
from ..judge.refusals import NotShown
from ..system.budget import spend
from . import Ball, Exact, Scalar, root_of_unity
from .roots import GENERATOR, RADICAL

MAX_LENGTH = 4000  # characters of one entry, its constants written out; published ones have 200
MAX_DEPTH = 40  # nested parentheses and signs
MAX_INTEGER_DIGITS = 1000
MAX_BITS = 3 * MAX_LENGTH  # of a numerator or denominator that comes as a number
MAX_TURN_DENOMINATOR = 30  # of a root of unity exp(2*pi*i*k/n), whose degree is up to n - 1
MAX_ROOT = 12  # n of root(x, n)
MAX_RADICALS = 40  # in one entry, its constants written out: each may double the field's degree
MAX_DEGREE = 1024  # of the field its different roots generate
MAX_HEIGHT = 20_000  # digits of the coefficients, as estimated
MAX_RADICAL_DEPTH = 4  # sqrt inside sqrt, constants written out

_RATIONAL = re.compile(r"(-?[0-9]{1,40})(?:/([0-9]{1,40}))?", re.ASCII)  # most entries
_DECIMAL = re.compile(r"-?[0-9]{0,40}\.[0-9]{1,200}", re.ASCII)  # most of published digits
#: Tokens of shown numbers, which may have an exponent, as in ``1.5e-8``; those of files have none.
_SHOWN = tokens(rf"(?:{NUMERAL})(?:[eE][-+]?[0-9]+)?")


class Weight(NamedTuple):
    """Size of an entry when its constants are written out: what its arithmetic may cost.

    A file may build constants from constants; a square of a square of a square costs more than
    memory has, however short its text.
    """

    length: int
    radicals: int
    depth: int
    height: int = 1  # estimates the digits of the coefficients in the field of its roots
    roots: frozenset[tuple[str, int]] = frozenset()  # different roots, and the degree of each

    @property
    def degree(self) -> int:
        """Bound of the degree of the field its roots generate."""
        return prod(degree for _, degree in self.roots)


class Text(str):
    """An entry as it is written, with the number it stands for.

    Claims are kept this way: the text is what a reader sees, the value what is compared. Constants
    of the file are already in the value.
    """

    __slots__ = ("value",)
    value: Scalar

    def __new__(cls, text: str, value: Scalar) -> Text:
        """Attach a value to a text."""
        self = super().__new__(cls, text)
        self.value = value
        return self

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        """Leave the value behind in a copy that is sent to another process: plain text goes."""
        return str, (str(self),)


def weigh(text: str, weights: Mapping[str, Weight]) -> Weight:
    """Add up the size of an entry whose constants have the given sizes, before it is computed.

    Raises
    ------
    DataError
        When it is more than this module computes.
    """
    if _RATIONAL.fullmatch(text) or _DECIMAL.fullmatch(text):
        return Weight(len(text), 0, 0, len(text))
    if len(text) > MAX_LENGTH:
        raise DataError(
            f"an entry has {len(text)} characters and at most {MAX_LENGTH} are read: "
            f"{text[:30]!r}...; declare a constant for the repeated part"
        )
    length = radicals = depth = height = 0
    open_roots: list[bool] = []
    opened: list[tuple[str, int]] = []  # what each parenthesis belongs to, and where that begins
    roots: set[tuple[str, int]] = set()
    divided = False
    before, place = "", 0
    for match in TOKEN.finditer(text):
        token = match[1] or match[2] or match[3]
        if token == "(":
            open_roots.append(before in ("sqrt", "root"))
            opened.append((before, place))
            radicals += open_roots[-1]
            depth = max(depth, sum(open_roots))
        elif token == ")" and open_roots:
            open_roots.pop()
            kind, start = opened.pop()
            roots |= _generator(kind, text[start : match.end()])
        elif token == "i":
            roots.add(("i", 2))
        divided |= before == "/" and not token[0].isdigit()
        inner = weights.get(token)
        height += len(token) if inner is None else inner.height
        length += len(token) if inner is None else inner.length
        if inner is not None:
            roots |= inner.roots
            radicals += inner.radicals
            depth = max(depth, sum(open_roots) + inner.depth)
        before, place = token, match.start()
    found = Weight(length, radicals, depth, height, frozenset(roots))
    if divided:  # a quotient in a field of degree n has coefficients n times as long
        found = found._replace(height=height * found.degree)
    if length > MAX_LENGTH or radicals > MAX_RADICALS or depth > MAX_RADICAL_DEPTH:
        raise DataError(
            f"the entry {_shortened(text)} stands for {length} characters and {radicals} roots "
            f"nested {depth} deep when its constants are written out, and at most {MAX_LENGTH}, "
            f"{MAX_RADICALS} and {MAX_RADICAL_DEPTH} are computed; simplify it"
        )
    if found.degree > MAX_DEGREE or found.height > MAX_HEIGHT:
        raise DataError(
            f"the entry {_shortened(text)} stands for a number in a field of degree up to "
            f"{found.degree} with coefficients of up to {found.height} digits, and at most "
            f"{MAX_DEGREE} and {MAX_HEIGHT} are computed; simplify it"
        )
    return found


def _generator(kind: str, text: str) -> set[tuple[str, int]]:
    """Return the root that a function with its argument stands for, with its degree."""
    if kind == "sqrt":
        return {(text.strip(), 2)}
    if kind in ("root", "exp"):
        numbers = re.findall("[0-9]+", text)
        last = numbers[-1] if numbers else "1"
        degree = min(int(last[:4]), MAX_TURN_DENOMINATOR)  # larger ones are refused
        return {(f"exp/{last}" if kind == "exp" else text.strip(), max(1, degree))}
    return set()


def _shortened(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "...")


def parse(
    text: str,
    *,
    constants: Mapping[str, Scalar] | None = None,
    digits: int | None = None,
) -> Scalar:
    """Read one entry.

    Parameters
    ----------
    text : str
        The expression, for example ``"(3-sqrt(3))/6"``.
    constants : Mapping[str, Scalar] or None
        Names the entry may use, with their values.
    digits : int or None
        Digits after the point that published decimals of this file carry; ``None`` where decimals
        are not allowed.

    Returns
    -------
    Scalar
        An :class:`Exact`, or a :class:`Ball` where a decimal took part.

    Raises
    ------
    DataError
        With one sentence that names the entry and what to do.
    """
    number = rational(text)
    if number is not None:
        return number
    evaluator = _Evaluator(text, constants or {}, digits)
    if _DECIMAL.fullmatch(text):
        size = evaluator.value(Numeral(text.removeprefix("-")))
        return -size if text[0] == "-" else size
    tree = syntax_tree(text)
    try:
        value = evaluator.value(tree)
    except ZeroDivisionError:
        raise _error(text, "there is a division by zero") from None
    except ExactnessError as error:
        raise _error(text, f"{error}, so there is no exact value") from None
    if isinstance(value, Ball) and not isfinite(value.magnitude()):
        raise _error(text, "the decimals do not bound a quotient, a root or a size")
    return value


@lru_cache(maxsize=1 << 14)
def rational(text: str) -> Exact | None:
    """Return a number or fraction, the same object each time, so that its ball is found once."""
    found = _RATIONAL.fullmatch(text)
    if found is None or (found[2] is not None and not int(found[2])):
        return None
    return Exact(int(found[1])) / Exact(int(found[2] or 1))


@lru_cache(maxsize=1 << 12)
def syntax_tree(text: str, *, exponents: bool = False) -> Expression:
    """Read an expression; its names may be any.

    Parameters
    ----------
    text : str
        The expression.
    exponents : bool
        Whether a number may have an exponent, as in ``1.5e-8``. Files have none; shown numbers may.

    Raises
    ------
    DataError
        With one sentence that names the entry and what to do.
    """
    weigh(text, {})
    try:
        return Reader(text, _SHOWN if exponents else TOKEN, MAX_DEPTH).read()
    except NotShown as refusal:
        raise _error(text, str(refusal)) from None


def _error(text: str, what: str) -> DataError:
    return DataError(
        f"{what} in the entry {_shortened(text)}; write integers, + - * / ( ), sqrt(), "
        f"root(x,n), i, exp(2*pi*i/n) or a declared constant"
    )


class _Evaluator:
    """The number that a tree stands for."""

    def __init__(self, text: str, constants: Mapping[str, Scalar], digits: int | None) -> None:
        self.text, self.constants, self.digits = text, constants, digits

    def _error(self, what: str) -> DataError:
        return _error(self.text, what)

    def value(self, node: Expression) -> Scalar:
        found: Any = value_of(node, self._leaf, truediv)
        return found

    def _leaf(self, node: Expression) -> Any:
        match node:
            case Numeral(token):
                return self._number(token)
            case Name(name):
                return self._name(name)
            case Root(radicand, degree):
                return self._root(self.value(radicand), degree)
            case Exponential(angle):
                return self._exponential(angle)
        raise AssertionError(node)

    def _name(self, name: str) -> Scalar:
        if name in self.constants:
            return self.constants[name]
        if name == "i":
            return Exact(-1).sqrt()
        raise self._error(f"the name {name!r} is not known")

    def _root(self, radicand: Scalar, degree: str) -> Scalar:
        if not degree.isdigit() or not 2 <= int(degree) <= MAX_ROOT:
            raise self._error(
                f"root(x, n) takes a whole number n from 2 to {MAX_ROOT}, not {degree!r},"
            )
        if degree == "2":
            return radicand.sqrt()
        if not radicand.is_real() or radicand.sign() <= 0:
            raise self._error("root(x, n) needs a positive real x")
        return radicand.root(int(degree))

    def _number(self, token: str) -> Scalar:
        if len(token) > MAX_INTEGER_DIGITS:
            raise self._error(f"a number has more than {MAX_INTEGER_DIGITS} digits")
        if "." not in token:
            return Exact(int(token))
        if self.digits is None:
            raise self._error(
                f"the decimal {token!r} is not exact (write a fraction, "
                f"or declare `digits` for published decimals)"
            )
        places = len(token.partition(".")[2])
        if places > self.digits + 2:
            raise self._error(
                f"the decimal {token!r} has more digits than the declared {self.digits}"
            )
        if not token.strip("0."):
            return Exact(0)  # a zero of a table is printed with as many digits as its neighbours
        if places < self.digits:
            raise DataError(
                f"the decimal {token!r} has {places} of the {self.digits} digits after the point "
                f"that `digits` declares; write all of them, or {Fraction(token)} if it is exact"
            )
        return Ball.decimal(token, self.digits)

    def _exponential(self, argument: Expression) -> Scalar:
        """Read exp of a rational multiple of pi*i: the angle is read with ``pi`` as the unit."""
        angle = _Evaluator(self.text, {"pi": Exact(1)}, self.digits).value(argument)
        turns = (angle / (Exact(-1).sqrt() * 2)) if isinstance(angle, Exact) else None
        fraction = turns.as_fraction() if turns is not None else None
        if fraction and _powers_of_pi(argument) != {1}:
            fraction = None
        if fraction is None or fraction.denominator > MAX_TURN_DENOMINATOR:
            raise self._error(
                f"exp() takes a rational multiple of pi*i with denominator at most "
                f"{MAX_TURN_DENOMINATOR}, as exp(2*pi*i/3),"
            )
        return root_of_unity(fraction.numerator, fraction.denominator)


def _powers_of_pi(node: Expression) -> set[Fraction]:
    """Return powers of pi in an expression; where there is one, it is a number times this power."""
    match node:
        case Name("pi"):
            return {Fraction(1)}
        case Negative(inner):
            return _powers_of_pi(inner)
        case Sum(terms):
            return {n for _, x in terms for n in _powers_of_pi(x)}
        case Product(factors):
            found = {Fraction(0)}
            for sign, factor in factors:
                own = _powers_of_pi(factor)
                found = {m + n if sign == "*" else m - n for m in found for n in own}
            return found
        case Root(radicand, degree):
            return {n / int(degree) for n in _powers_of_pi(radicand)}
        case _:
            return {Fraction(0)}


_QUADRATIC = re.compile(
    r"(?:(?P<a>\d+)\*)?(?P<name>[a-z]\d*)\^2"
    r"(?:(?P<sign>[-+])(?:(?P<b>\d+)\*)?(?P=name))?(?P<c>[-+]\d+)$"
)
_POWER = re.compile(r"([a-z]\d*)\^(\d+)")


def writable(value: int | Fraction) -> bool:
    """Return whether a number is short enough to be computed with, and to be written out."""
    return max(value.numerator.bit_length(), value.denominator.bit_length()) <= MAX_BITS


def to_text(value: Scalar) -> str:
    """Write a number in the grammar of :func:`parse`, so that parsing it gives the same number.

    Raises
    ------
    ExactnessError
        For a ball, and for an algebraic number without square-root form.
    """
    if isinstance(value, Ball):
        raise ExactnessError("a ball has no exact text; write its decimals and declare `digits`")
    spend()
    fraction = value.as_fraction()
    if fraction is not None:
        if not writable(fraction):
            raise ExactnessError(
                f"a fraction with more than {MAX_LENGTH} digits is not written out"
            )
        return str(fraction)
    text = value.text_of_roots()
    if text is not None and _stands_for(text, value):
        return text
    description = value.description()
    body, _, where = description[description.index("{") + 1 : -1].partition(" where ")
    complex_root = re.fullmatch(r"[^,\[]*\[[^\],]*\^2[-+](?:\d+\*)?[a-z]\+\d+=0\]", where)
    if complex_root and (text := _rational_and_root(value)) is not None:
        return text
    names: dict[str, str] = {}
    for match in reversed(list(GENERATOR.finditer(where))):
        names[match["name"]] = _generator_text(match, names, value)
    text = _tidy(_substitute(body, names, value))
    if not _stands_for(text, value):  # e.g. the other root of the generator's polynomial
        raise ExactnessError(f"no square-root form found for {value!r}")
    return text


def _rational_and_root(value: Exact) -> str | None:
    """Write ``p + sqrt(q)`` with rational p and negative q, where the number has that form.

    It serves the reader only: without it :func:`to_text` finds a longer text of the same number.
    """
    real = value.real.as_fraction()
    square = None if real is None else ((value - real) * (value - real)).as_fraction()
    if square is None:
        return None
    below = square.denominator
    whole = isqrt(below) ** 2 == below
    root = f"sqrt({square.numerator if whole else square.numerator * below})"
    root += f"/{isqrt(below) if whole else below}" if below > 1 else ""
    sign = "-" if value.imag.sign() < 0 else "+" if real else ""
    return f"{real or ''}{sign}{root}"


def shown_number(x: Scalar) -> str:
    """Return a number as an exact expression where it has one, else as a decimal."""
    try:
        text = to_text(x) if isinstance(x, Exact) else ""
        if text and not ("exp(" in text and x.is_real()):  # decimals say more of a real number
            return text
    except (ExactnessError, DataError):
        pass
    z = complex(x)
    return f"{z.real:.17g}" if z.imag == 0 or isinstance(x, Ball) else f"{z:.17g}"


def _tidy(text: str) -> str:
    """Write ``(-sqrt(3)+3)/6`` as ``(3-sqrt(3))/6`` and ``(-sqrt(3))/2`` as ``-sqrt(3)/2``."""
    over = re.fullmatch(r"\((.*)\)(/\d+)", text)
    body, rest = (over[1], over[2]) if over else (text, "")
    terms: list[str] = [""]
    depth = 0
    for character in body:
        depth += {"(": 1, ")": -1}.get(character, 0)
        if depth < 0:  # the first parenthesis is not the one that closes last
            return text
        if character in "+-" and depth == 0 and terms[-1]:
            terms.append("")
        terms[-1] += character
    if len(terms) > 1 and re.fullmatch(r"\+[\d/]+", terms[-1]):
        terms = [terms[-1][1:], *(x if x[0] in "+-" else f"+{x}" for x in terms[:-1])]
    joined = "".join(terms)
    return f"({joined}){rest}" if rest and len(terms) > 1 else joined + rest


def _stands_for(text: str, value: Exact) -> bool:
    try:
        return parse(text) == value
    except DataError:  # longer or deeper than this module reads
        return False


def _generator_text(match: re.Match[str], names: Mapping[str, str], value: Exact) -> str:
    if match["radicand"] is not None:
        return f"sqrt({_substitute(match['radicand'], names, value)})"
    if match["base"] is not None:
        base = _substitute(match["base"], names, value)
        part, _, degree = (match["part"] or "1/2").partition("/")
        if base == "-1":  # a root of unity
            return f"exp({part}*pi*i/{degree})".replace("(1*", "(")
        power = "*".join([f"root({base},{degree})"] * abs(int(part)))
        return power if int(part) > 0 else f"(1/({power}))"
    if match["conjugate"] is not None and value.imag.is_zero() is not True:  # of a root of unity
        return f"(1/({_substitute(match['conjugate'], names, value)}))"
    radical = RADICAL.fullmatch(match["minpoly"] or "")
    if radical is not None and int(radical["n"]) > 2:
        below = f"/{radical['a']}" if radical["a"] else ""
        return f"root({radical['c']}{below},{radical['n']})"
    quadratic = _QUADRATIC.match(match["minpoly"] or "")
    if quadratic is None or quadratic["name"] != match["name"]:
        raise ExactnessError(f"no square-root form found for {value!r}")
    a, b = int(quadratic["a"] or 1), int(f"{quadratic['sign'] or '+'}{quadratic['b'] or 1}")
    b, c = b if quadratic["sign"] else 0, int(quadratic["c"])
    # flint's generator is the root with the plus; whether it is, `to_text` asks of the whole number
    if b == 0 and a == 1:
        return "i" if c == 1 else f"sqrt({-c})" if c < 0 else f"(i*sqrt({c}))"
    return f"(({-b}+sqrt({b * b - 4 * a * c}))/{2 * a})"


def _substitute(body: str, names: Mapping[str, str], value: Exact) -> str:
    expanded = _POWER.sub(lambda m: "*".join([m[1]] * int(m[2])), body)

    def generator(match: re.Match[str]) -> str:
        if match[0] not in names:
            raise ExactnessError(f"no square-root form found for {value!r}")
        return names[match[0]]

    return re.sub(r"(?<![A-Za-z_])[a-z]\d*(?![A-Za-z_(])", generator, expanded)
