"""The grammar of entries (section 1)."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable

from .arithmetic import Fraction, Number, rational_of
from .numbers import inverse
from .refusals import NotShown, Refused, as_text, matched, require, shown

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


FUNCTIONS = ("sqrt", "root", "exp")

CHARACTERS = r"[-+*/(),.0-9A-Za-z_]+"

BLANK = r"[ \t\n\r\f\v]"

OPERATIONS = {
    ast.Add: lambda x, y: x + y, ast.Sub: lambda x, y: x - y, ast.Mult: lambda x, y: x * y,
    ast.Div: lambda x, y: x * inverse(y), ast.UAdd: lambda x: x, ast.USub: lambda x: -x,
}  # fmt: skip


def plain(text: str) -> str:
    """Return an entry without blanks and without zeros that begin a number, as in 01."""
    return re.sub(r"(?<![.\w])0+(?=[0-9])", "", re.sub(BLANK, "", text))


def parse(
    text: object,
    name: Callable[[str], Number | None],
    radical: Callable[[str], Number] | None = None,
    written_out: Callable[[str], str] = str,
    decimal: Callable[[str], Number] | None = None,
) -> Number:
    """Return the number that an entry stands for (data contract).

    It depends on the number of a name, of the text of a radical with all constants `written_out`,
    and of a decimal.
    """
    given = as_text(text, "an entry is no short string")
    require(0 < len(given) <= DIGITS, "an entry is no short string")
    require(
        not re.search(rf"[.\w]{BLANK}+[.\w]", given), "a blank stands inside a number or a name"
    )
    plainly = plain(given)
    require(re.fullmatch(CHARACTERS, plainly), f"{plainly[:40]!r} is no entry")

    def value(node: ast.expr) -> Number:
        own = plainly[node.col_offset : node.end_col_offset]
        if isinstance(node, ast.Constant) and own.isdigit():
            return Fraction(int(own))
        if isinstance(node, ast.Constant) and re.fullmatch(r"[0-9]*\.[0-9]*", own):
            return shown(decimal, "a decimal is no exact number")(own)
        called = isinstance(node, ast.Call) and getattr(node.func, "id", "") in FUNCTIONS
        if own == "i" or called:
            return shown(radical, "a radical stands where none may")(written_out(own))
        if isinstance(node, ast.Name):
            found = name(own)
            if found is None:
                raise NotShown(f"nothing is called {own[:40]!r}")
            return found
        if not isinstance(node, ast.BinOp | ast.UnaryOp) or type(node.op) not in OPERATIONS:
            raise NotShown("an entry breaks the grammar")
        inner = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.operand,)
        return OPERATIONS[type(node.op)](*map(value, inner))

    try:
        return value(ast.parse(plainly, mode="eval").body)
    except SyntaxError:
        raise Refused(f"{plainly[:40]!r} is no entry") from None


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
