"""The grammar of entries (section 1)."""

import ast
import re

from .arithmetic import Fraction, rational_of
from .numbers import inverse
from .refusals import Refused, require

DIGITS = 4000  # characters of an entry


def rational(text):
    """Return a rational number written as a string."""
    found = isinstance(text, str) and re.fullmatch(r"-?[0-9]+(/[0-9]+)?", text)
    require(found and len(text) <= DIGITS, f"{str(text)[:40]!r} is no rational number")
    top, _, bottom = text.partition("/")
    require(int(bottom or 1), "a division by 0")
    return Fraction(int(top), int(bottom or 1))


FUNCTIONS = ("sqrt", "root", "exp")


CHARACTERS = r"[-+*/(),.0-9A-Za-z_]+"


BLANK = r"[ \t\n\r\f\v]"


OPERATIONS = {
    ast.Add: lambda x, y: x + y, ast.Sub: lambda x, y: x - y, ast.Mult: lambda x, y: x * y,
    ast.Div: lambda x, y: x * inverse(y), ast.UAdd: lambda x: x, ast.USub: lambda x: -x,
}  # fmt: skip


def plain(text):
    """Return an entry without blanks and without zeros that begin a number, as in 01."""
    return re.sub(r"(?<![.\w])0+(?=[0-9])", "", re.sub(BLANK, "", text))


def parse(text, name, radical=None, written_out=str, decimal=None):
    """Return the number that an entry stands for (data contract).

    It depends on the number of a name, of the text of a radical with all constants `written_out`,
    and of a decimal.
    """
    require(isinstance(text, str) and 0 < len(text) <= DIGITS, "an entry is no short string")
    require(not re.search(rf"[.\w]{BLANK}+[.\w]", text), "a blank stands inside a number or a name")
    text = plain(text)
    require(re.fullmatch(CHARACTERS, text), f"{text[:40]!r} is no entry")

    def value(node):
        kind, own = type(node), text[node.col_offset : node.end_col_offset]
        if kind is ast.Constant and own.isdigit():
            return Fraction(int(own))
        if kind is ast.Constant and re.fullmatch(r"[0-9]*\.[0-9]*", own):
            require(decimal, "a decimal is no exact number")
            return decimal(own)
        if own == "i" or (kind is ast.Call and getattr(node.func, "id", "") in FUNCTIONS):
            require(radical, "a radical stands where none may")
            return radical(written_out(own))
        if kind is ast.Name:
            found = name(own)
            require(found is not None, f"nothing is called {own[:40]!r}")
            return found
        known = kind in (ast.BinOp, ast.UnaryOp) and type(node.op) in OPERATIONS
        require(known, "an entry breaks the grammar")
        inner = (node.left, node.right) if kind is ast.BinOp else (node.operand,)
        return OPERATIONS[type(node.op)](*map(value, inner))

    try:
        return value(ast.parse(text, mode="eval").body)
    except SyntaxError:
        raise Refused(f"{text[:40]!r} is no entry") from None


def decimal_number(text):
    """Return the rational of a decimal such as -1.25e-3."""
    found = isinstance(text, str) and re.fullmatch(r"-?[0-9]+(\.[0-9]+)?(e-?[0-9]{1,3})?", text)
    require(found and len(text) <= DIGITS, f"{str(text)[:40]!r} is no decimal")
    return rational_of(text)


def published_decimal(text, digits):
    """Return the rational of an unknown that is given with this many places."""
    found = isinstance(text, str) and re.fullmatch(r"-?[0-9]+\.([0-9]+)", text)
    require(found and len(found[1]) == digits, "an unknown has another number of places")
    return rational_of(text)


def two_digits(text):
    """Return the number of two digits and the one before it."""
    require(
        isinstance(text, str) and re.fullmatch(r"[1-9]\.[0-9]e-[1-9][0-9]{0,2}", text), "a size"
    )
    digits, _, power = text.partition("e")
    top, unit = int(digits.replace(".", "")), Fraction(1, 10 ** (1 - int(power)))
    return top * unit, (top - 1) * unit if top > 10 else Fraction(99, 10) * unit
