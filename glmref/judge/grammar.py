"""The grammar of entries (section 1)."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

from .arithmetic import Fraction, Number, rational_of
from .numbers import inverse
from .refusals import NotShown, as_text, matched, require, shown

DIGITS = 4000  # characters of an entry


def rational(text: object) -> Fraction:
    """Return a rational number written as a string."""
    top, bottom = short(r"(-?[0-9]+)(?:/([0-9]+))?", text, "rational number").groups("1")
    require(int(bottom), "a division by 0")
    return Fraction(int(top), int(bottom))


def short(pattern: str, text: object, what: str) -> re.Match[str]:
    """Return the match of a text of no more than DIGITS characters."""
    found = re.fullmatch(pattern, text) if isinstance(text, str) and len(text) <= DIGITS else None
    if found is None:
        raise NotShown(f"{str(text)[:40]!r} is no {what}")
    return found


BLANK = r"[ \t\n\r\f\v]"
NAME = r"[A-Za-z_][A-Za-z_0-9]*"
NUMERAL = r"[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+"
RESERVED = frozenset({"i", "pi", "sqrt", "root", "exp"})  # names that no constant has


def may_be_declared(name: str) -> bool:
    """Tell whether a constant or unknown may have this name."""
    return re.fullmatch(NAME, name) is not None and name not in RESERVED


def tokens(numeral: str) -> re.Pattern[str]:
    """Return the pattern of a token: a numeral of this pattern, a name, or a sign."""
    return re.compile(rf"{BLANK}*(?:({numeral})|({NAME})|([-+*/(),]))")


TOKEN = tokens(NUMERAL)
DEPTH = 100  # parentheses, signs and functions inside each other


class Numeral(NamedTuple):
    """A whole number or a decimal, as it is written."""

    text: str


class Name(NamedTuple):
    """``i``, ``pi`` or a constant."""

    name: str


class Negative(NamedTuple):
    """Minus an expression."""

    operand: Expression


class Sum(NamedTuple):
    """Two terms or more, each with the sign before it; the first has ``+``."""

    parts: tuple[tuple[str, Expression], ...]


class Product(NamedTuple):
    """Two or more from the left, each with ``*`` or ``/`` before it; the first has ``*``."""

    parts: tuple[tuple[str, Expression], ...]


class Root(NamedTuple):
    """``sqrt(x)``, of degree 2, or ``root(x, n)``, and its text without blanks."""

    radicand: Expression
    degree: str
    text: str


class Exponential(NamedTuple):
    """``exp(angle)``, and its text without blanks."""

    angle: Expression
    text: str


Expression: TypeAlias = "Numeral | Name | Negative | Sum | Product | Root | Exponential"


class Reader:
    """Recursive descent over the tokens of one entry (data contract).

        sum     = product (("+" | "-") product)*
        product = factor (("*" | "/") factor)*
        factor  = ("+" | "-") factor | atom
        atom    = numeral | name | "(" sum ")"
                | "sqrt(" sum ")" | "root(" sum "," numeral ")" | "exp(" sum ")"

    It refuses another text with what is wrong. Other numerals may be in the pattern `token`.
    """

    def __init__(self, text: str, token: re.Pattern[str] = TOKEN, deepest: int = DEPTH) -> None:
        self.tokens, self.place, self.depth, self.deepest = [], 0, 0, deepest
        text, at = text.rstrip(" \t\n\r\f\v"), 0
        require(text, "an empty string is no number")
        while at < len(text):
            match = token.match(text, at)
            if match is None:
                wrong = text[at:].lstrip(" \t\n\r\f\v")[0]
                raise NotShown(f"the character {wrong!r} is not allowed")
            self.tokens.append(match[1] or match[2] or match[3])
            at = match.end()

    def read(self) -> Expression:
        """Return the expression that the whole text is."""
        found = self.sum()
        require(self.place == len(self.tokens), f"{self.next!r} is out of place")
        return found

    @property
    def next(self) -> str:
        """Return the token that comes next, or the empty text."""
        return self.tokens[self.place] if self.place < len(self.tokens) else ""

    def take(self, expected: str = "") -> str:
        """Return the next token, which must be the expected one, and go on."""
        token = self.next
        require(not expected or token == expected, f"{expected!r} is missing")
        require(token, "the expression ends too early")
        self.place += 1
        return token

    def sum(self) -> Expression:
        """Read a sum."""
        parts = [("+", self.product())]
        while self.next in ("+", "-"):
            parts.append((self.take(), self.product()))
        return Sum(tuple(parts)) if len(parts) > 1 else parts[0][1]

    def product(self) -> Expression:
        """Read a product."""
        parts = [("*", self.factor())]
        while self.next in ("*", "/"):
            parts.append((self.take(), self.factor()))
        return Product(tuple(parts)) if len(parts) > 1 else parts[0][1]

    def deeper(self, read: Callable[[], Expression]) -> Expression:
        """Read what stands inside of what was read."""
        self.depth += 1
        why = f"parentheses and signs are nested deeper than {self.deepest}"
        require(self.depth <= self.deepest, why)
        found = read()
        self.depth -= 1
        return found

    def factor(self) -> Expression:
        """Read a factor."""
        if self.next not in ("+", "-"):
            return self.atom()
        sign, inner = self.take(), self.deeper(self.factor)
        return Negative(inner) if sign == "-" else inner

    def atom(self) -> Expression:
        """Read a numeral, a name, what stands in parentheses, or a function."""
        begin, token, degree = self.place, self.take(), "2"
        if token[0].isdigit() or token[0] == ".":
            return Numeral(token)
        if token not in ("(", "sqrt", "root", "exp"):
            require(token[0].isalpha() or token[0] == "_", f"{token!r} is out of place")
            require(self.next != "(", f"the name {token!r} is not known")
            return Name(token)
        if token != "(":
            self.take("(")
        inner = self.deeper(self.sum)
        if token == "root":
            self.take(",")
            degree = self.take()
        self.take(")")
        if token == "(":
            return inner
        text = plain("".join(self.tokens[begin : self.place]))
        return Exponential(inner, text) if token == "exp" else Root(inner, degree, text)


def plain(text: str) -> str:
    """Return an entry without blanks and without zeros that begin a number, as in 01."""
    return re.sub(r"(?<![.\w])0+(?=[0-9])", "", re.sub(BLANK, "", text))


def written_out(text: object, constants: Mapping[str, object]) -> str:
    """Return an entry without blanks, its constants written out in parentheses."""
    found = re.sub(
        NAME,
        lambda m: f"({written_out(constants[m[0]], constants)})" if m[0] in constants else m[0],
        plain(as_text(text, "a constant is no text")),
    )
    require(len(found) <= DIGITS, "beyond the limits of this checker")
    return found


def value_of(
    node: Expression,
    leaf: Callable[[Expression], Number],
    divided: Callable[[Number, Number], Number],
) -> Number:
    """Return the number of an expression, from those of numerals, names and functions."""
    if isinstance(node, Negative):
        return -value_of(node.operand, leaf, divided)
    if not isinstance(node, Sum | Product):
        return leaf(node)
    (_, first), *others = node.parts
    found = value_of(first, leaf, divided)
    for sign, part in others:
        x = value_of(part, leaf, divided)
        if sign == "/":
            found = divided(found, x)
        else:
            found = found * x if sign == "*" else found + x if sign == "+" else found - x
    return found


def parse(
    text: object,
    name: Callable[[str], Number | None],
    radical: Callable[[str], Number] | None = None,
    constants: Mapping[str, object] = MappingProxyType({}),
    decimal: Callable[[str], Number] | None = None,
) -> Number:
    """Return the number that an entry stands for (data contract).

    It depends on the number of a name, of the text of a radical with all `constants` written out,
    and of a decimal.
    """
    given = as_text(text, "an entry is no short string")
    require(len(given) <= DIGITS, "an entry is no short string")

    def leaf(node: Expression) -> Number:
        if isinstance(node, Numeral):
            if "." in node.text:
                return shown(decimal, "a decimal is no exact number")(node.text)
            return Fraction(int(node.text))
        if isinstance(node, Name) and node.name != "i":
            return shown(name(node.name), f"nothing is called {node.name[:40]!r}")
        own = node.text if isinstance(node, Root | Exponential) else "i"
        return shown(radical, "a radical stands where none may")(written_out(own, constants))

    return value_of(Reader(given).read(), leaf, lambda x, y: x * inverse(y))


def decimal_number(text: object) -> Fraction:
    """Return the rational of a decimal such as -1.25e-3."""
    return rational_of(short(r"-?[0-9]+(\.[0-9]+)?(e-?[0-9]{1,3})?", text, "decimal")[0])


def published_decimal(text: object, digits: int) -> Fraction:
    """Return the rational of an unknown that is given with this many places."""
    why = "an unknown has another number of places"
    found = matched(r"-?[0-9]+\.([0-9]+)", text, why)
    require(len(found[1]) == digits, why)
    return rational_of(found[0])


def two_digits(text: object) -> tuple[Fraction, Fraction]:
    """Return the number of two digits and the one before it."""
    found = matched(r"([1-9])\.([0-9])e-([1-9][0-9]{0,2})", text, "a size")
    top, unit = int(found[1] + found[2]), Fraction(1, 10 ** (1 + int(found[3])))
    return top * unit, (top - 1) * unit if top > 10 else Fraction(99, 10) * unit
