"""Expressions in the sources of eleven languages folded to exact numbers and nested lists.

One precedence parser for all. What it does not know is :class:`~.values.Unread` with a reason; an
entry of a list that is not folded stays in the list as such, so that the list keeps its shape and
nothing becomes 0.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ..catalogue.keys import MAX_SIZE
from ..errors import ExactnessError
from ..exact import Exact
from .lexer import LANGUAGES, Language, Token, tokens
from .values import (
    PARTED,
    Number,
    Unread,
    accident,
    bounded,
    filled,
    literal,
    pairwise,
    power,
    whole_number,
)

#: Calls that leave one number as it is; so do names of types, which begin with a capital.
_CASTS = frozenset(
    "array asarray tensor big float float64 float32 double real dble dbl constexpr number convert "
    "map tuple list vec collect copy from_list sympify mpf parse tparse value_type scalar_type "
    "scalar realtype sunrealtype static_cast as_tensor ascontiguousarray constant vector matrix "
    "cast val one_ toreal deepcopy to_array as_array freeze mat row vcat hcat from from_slice "
    "from_row_slice from_column_slice from_vec".split()
)
#: Calls that make a list of their arguments.
_LISTS = frozenset("svector mvector tuple vector array list of listof arrayof make_array".split())
#: Those of Kotlin, Scala and R, with any number of arguments of any kind.
_LISTS_OF_ANY = {
    LANGUAGES["kotlin"]: frozenset(
        "arrayof doublearrayof floatarrayof listof emptyarray array list seq vector".split()
    ),
    LANGUAGES["r"]: frozenset("c rbind".split()),
}
_QUOTIENTS = frozenset(("fraction", "rational", "frac", "rat"))
_NOTHING = frozenset("None NULL nullptr nothing null undefined nil PETSC_NULLPTR".split())
_WORDS = frozenset(
    "for if else while lambda in return and or not is async await end do then".split()
)
_BINARY = {"+": 1, "-": 1, ".+": 1, ".-": 1, "*": 2, "/": 2, "//": 2, ".*": 2, "./": 2, "%": 2,
           "\\": 2}  # fmt: skip
_POWERS = frozenset(("**", "^", ".^"))
_OPEN = {"(": ")", "[": "]", "{": "}", "(/": "/)"}
_CLOSE = frozenset(_OPEN.values())
#: Functions of two numbers or vectors, and methods of one, that return what their names say.
ARITHMETIC = {
    **dict.fromkeys("add plus vadd addvec addvectors vecadd".split(), "+"),
    **dict.fromkeys("sub subtract minus".split(), "-"),
    **dict.fromkeys(
        "scale mul mult multiply times smul scalevec scalarmultiply multipliedby mapmultiply"
        .split(), "*"),
    **dict.fromkeys("div divide dividedby".split(), "/"),
}  # fmt: skip
#: Members that are the value itself in another type.
_COPIES = frozenset(
    "tolist astype to clone to_vec copy double into value flatten numpy item getReal "
    "newInstance".split()
)


class Integer(Number):
    """A whole number of a language in which 1/2 is 0."""

    __slots__ = ()


@dataclass
class Record:
    """What a call with several arguments, or a braced list of names and values, holds."""

    name: str
    line: int
    fields: dict[str, Any] = field(default_factory=dict)
    #: Values without names, each with the name that stood there, if it is only a name.
    values: list[tuple[str, Any]] = field(default_factory=list)


class Frame(list[Any]):
    """An array of zeros that is to be filled."""


class Entries(dict[tuple[int, ...], Any]):
    """Entries of an array that are given one by one."""

    cleared = False  #: Whether it was zeros before.


Lookup = Callable[[str], Any]


def _apply(sign: str, x: Any, y: Any, language: Language) -> Any:
    sign = sign.lstrip(".") or sign
    if sign == "//" and language.name == "python" and isinstance(x, Number):
        return Number(Exact(x.whole() // number(y).whole()))
    if sign == "%" or sign == "\\" or (sign == "//" and language.name not in ("julia", "fortran")):
        raise Unread(f"the operator {sign} is not read")
    both = isinstance(x, Integer) and isinstance(y, Integer)
    if both and sign == "/" and language.truncates:
        quotient = (x.value / y.value).as_fraction()
        if quotient is None or quotient.denominator != 1:
            raise Unread(f"{x.value}/{y.value} is a quotient of whole numbers, which is cut")
        return Integer(Exact(quotient), None, x.size + y.size)
    found = pairwise("/" if sign == "//" else sign, x, y)
    if both and isinstance(found, Number) and language.truncates:
        return Integer(found.value, None, found.size)
    return found


def negative(x: Any) -> Any:
    """Return -x of a number or nested lists."""
    if isinstance(x, list):
        return [negative(y) for y in x]
    if not isinstance(x, Number):
        raise x if isinstance(x, Unread) else Unread("a number is expected")
    found = x.of(-x.value)
    return Integer(found.value, None, x.size) if isinstance(x, Integer) else found


def transposed(x: Any) -> Any:
    """Return the transpose of a matrix; a vector is as it is."""
    if isinstance(x, list) and x and all(isinstance(y, list) for y in x):
        if len({len(y) for y in x}) > 1:
            raise Unread("the rows of a transposed matrix differ in length")
        return [list(y) for y in zip(*x, strict=True)]
    return x


class Folder:
    """A reader of the expressions in a list of tokens.

    Parameters
    ----------
    tokens : sequence of Token
        With their ends of lines.
    language : Language
    look : callable
        Value of a name; raises :class:`~.values.Unread` for one that is not known.
    """

    def __init__(self, tokens: Sequence[Token], language: Language, look: Lookup) -> None:
        self.tokens, self.language, self.look = tokens, language, look
        self.at, self.end = 0, len(tokens)
        self.blanks = False  # whether blanks part entries
        self.depth = 0

    # --- tokens -----------------------------------------------------------------------------------

    def skip(self) -> None:
        """Pass ends of lines."""
        while self.at < self.end and self.tokens[self.at].kind == "line":
            self.at += 1

    def peek(self) -> Token | None:
        """Return the next token."""
        x = self.tokens[self.at] if self.at < self.end else None
        if x is None or self.blanks or x.kind != "line":
            return x
        self.skip()
        return self.tokens[self.at] if self.at < self.end else None

    def sees(self, *texts: str) -> bool:
        """Return whether the next token is one of these marks."""
        x = self.peek()
        return x is not None and x.kind in ("mark", "name") and x.text in texts

    def take(self, text: str = "") -> Token:
        """Return the next token and pass it."""
        x = self.peek()
        if x is None or (text and x.text != text):
            raise Unread(f"{text or 'a value'} is expected")
        self.at += 1
        return x

    def partner(self, at: int) -> int:
        """Return the index of the bracket that closes the one at an index."""
        depth = 0
        for k in range(at, self.end):
            x = self.tokens[k]
            if x.kind == "mark":
                depth += (x.text in _OPEN) - (x.text in _CLOSE)
                if depth <= 0:
                    return k
        raise Unread("a bracket is not closed")

    def to_comma(self, ends: Sequence[str]) -> None:
        """Pass the rest of an entry that is not understood."""
        depth = 0
        while self.at < self.end:
            x = self.tokens[self.at]
            if x.kind == "mark":
                if depth == 0 and (x.text in (",", ";") or x.text in ends):
                    return
                depth += (x.text in _OPEN) - (x.text in _CLOSE)
                if depth < 0:
                    return
            self.at += 1

    # --- expressions ------------------------------------------------------------------------------

    def expression(self, least: int = 0) -> Any:
        """Read an expression; :class:`~.values.Unread` is raised for what is not folded."""
        self.depth += 1
        if self.depth > 120:
            raise Unread("an expression is nested too deep")
        try:
            return self._expression(least)
        except (ZeroDivisionError, ExactnessError, IndexError, ValueError) as error:
            raise Unread(accident(error)) from None
        finally:
            self.depth -= 1

    def _expression(self, least: int) -> Any:
        x = self._unary()
        while True:
            t = self.peek()
            if t is None or t.kind not in ("mark", "name"):
                return x
            if t.kind == "name":
                if t.text == "as" and self.language.name == "rust":  # x as f64
                    self.at += 1
                    self.take()
                    continue
                return x
            if t.text in _POWERS:
                self.at += 1
                self.skip()
                x = power(x, self._unary(tight=True))
                continue
            rank = _BINARY.get(t.text)
            if rank is None or rank <= least:
                if t.text == "?":
                    raise Unread("a choice is not read")
                return x
            after = self.tokens[self.at + 1] if self.at + 1 < self.end else None
            sign = rank == 1 and self.blanks and t.spaced
            if sign and after is not None and not after.spaced and after.kind != "line":
                return x  # in a matrix it is the sign of the next entry
            self.at += 1
            self.skip()
            x = _apply(t.text, x, self.expression(rank), self.language)

    def _unary(self, *, tight: bool = False) -> Any:
        t = self.peek()
        if t is not None and t.kind == "mark":
            if t.text in ("-", "+", ".-"):
                self.at += 1
                x = self._unary() if tight else self.expression(1)
                return x if t.text == "+" else negative(x)
            if t.text in ("&", "@") or (t.text == "*" and not tight):
                self.at += 1
                if t.text == "@":  # a macro
                    while self.sees("."):
                        self.at += 1
                    self.take()
                    if self.blanks:
                        pass
                elif self.sees("mut"):
                    self.at += 1
                return self._unary()
            if t.text == "√":
                self.at += 1
                return _rooted(self._postfix(self._primary()))
        x = self._postfix(self._primary())
        t = self.peek()
        if t is not None and t.text in _POWERS:
            self.at += 1
            self.skip()
            return power(x, self._unary(tight=True))
        return x

    def _primary(self) -> Any:
        t = self.take()
        if t.kind == "number":
            return self._numeral(t)
        if t.kind == "string":
            return t.text
        if t.kind == "name":
            return self._named(t)
        if t.text == "[":
            return self._square(t)
        if t.text == "(/":
            return self.items("/)")
        if t.text == "{":
            return self._braced("", t.line)
        if t.text == "(":
            return self._round()
        raise Unread(f"{t.text!r} is not read here")

    def _numeral(self, t: Token) -> Any:
        x = self._literal(t.text)
        after = self.tokens[self.at] if self.at < self.end else None
        if after is None or after.spaced or self.language.name != "julia":
            return x
        if (after.kind == "name" and after.text not in _WORDS) or after.text in ("(", "√"):
            y = self._unary(tight=True)  # 2c and 2(a + b)
            return _apply("*", x, y, self.language)
        return x

    def _literal(self, text: str) -> Number:
        x = literal(text)
        if self.language.truncates and text.translate(PARTED).isdigit():
            return Integer(x.value, None, x.size)
        return x

    def _round(self) -> Any:
        """Read a bracketed expression, a tuple with or without names, or a cast."""
        close = self.partner(self.at - 1)
        inside = self.tokens[self.at : close]
        first = [x for x in inside if x.kind != "line" and x.text != ";"][:2]
        if self.language.name == "julia" and [x.text for x in first[1:]] == ["="]:
            self.at -= 1
            values, words = self._arguments()
            return Record("", first[0].line, words, values)
        after = self.tokens[close + 1] if close + 1 < self.end else None
        typed = inside and all(
            x.kind == "name" or x.text in ("*", "::", "<", ">", "&", "[", "]") for x in inside
        )
        if typed and after is not None and self.language.name in ("c", "java"):
            known = len(inside) == 1 and self._known(inside[0].text)
            if not known and (after.kind in ("number", "name") or after.text in ("(", "{", "-")):
                self.at = close + 1
                return plain(self._unary(tight=True))  # of the first factor alone
        blanks, self.blanks = self.blanks, False
        try:
            items = self.items(")", keep=True)
        finally:
            self.blanks = blanks
        if len(items) == 1 and self._outside(",", inside) is None:
            if isinstance(items[0], Unread):
                raise items[0]
            return items[0]
        return items

    @staticmethod
    def _outside(mark: str, tokens: Sequence[Token]) -> int | None:
        """Return the index of the first such mark outside of brackets."""
        depth = 0
        for k, x in enumerate(tokens):
            if x.kind == "mark":
                if depth == 0 and x.text == mark:
                    return k
                depth += (x.text in _OPEN) - (x.text in _CLOSE)
        return None

    def _known(self, name: str) -> bool:
        try:
            self.look(name)
        except Unread:
            return False
        return True

    def _entry(self, ends: Sequence[str]) -> Any:
        """Read an entry of a list with its place; what is not folded is returned as unread."""
        self.skip()
        start = self.at
        first = self.tokens[start] if start < self.end else None
        try:
            x = self.expression()
            t = self.peek()
            if t is not None and not (t.text in (",", ";") or t.text in ends or self.blanks):
                raise Unread(f"{t.text!r} is not read here", t.line)
        except Unread as error:
            self.to_comma(ends)
            error.line = error.line or (first.line if first else 0)
            return error
        if isinstance(x, Number) and first is not None:
            said = " ".join(y.text for y in self.tokens[start : self.at] if y.kind != "line")
            found = Number(x.value, x.places, x.size)
            found.place = (first.line, said[:80])
            return found
        return x

    def _unquoted(self, x: Any) -> Any:
        """Return the number that a string in a list is, as ``'3/32'``."""
        quoted = isinstance(x, str) and re.fullmatch(r"""["']\s*-?[\d.]+(?:/\d+)?\s*["']""", x)
        if not quoted:
            return x
        found = plain(self._literal_text(x))
        found.place = (self.tokens[self.at - 1].line, x[:80])
        return found

    def items(self, close: str, *, keep: bool = False) -> list[Any]:
        """Read entries parted by commas, through the closing bracket."""
        found: list[Any] = []
        if close == "/)" or close == "]":
            self._type_before()
        while not self.sees(close):
            if self.peek() is None:
                raise Unread("a bracket is not closed")
            found.append(self._unquoted(self._entry((close,))))
            if self.sees(",", ";"):
                self.at += 1
            elif not self.sees(close):
                raise Unread("a comma is expected")
        self.take(close)
        if found[:1] == [None] and all(isinstance(x, Number) for x in found[1:]):
            found[0] = Number(Exact(0))  # null for the first node
        return list(found) if keep else bounded(found)

    def _type_before(self) -> None:
        """Pass ``real(wp) ::`` at the head of an array of Fortran."""
        if self.language.name != "fortran":
            return
        for k in range(self.at, min(self.end, self.at + 12)):
            if self.tokens[k].text in (",", "]", "/)"):
                return
            if self.tokens[k].text == "::":
                self.at = k + 1
                return

    def _square(self, opened: Token) -> Any:
        """Read a list or matrix after its bracket; of Go and Java also what types begin."""
        close = self.partner(self.at - 1)
        if self.language.name == "go":
            return self._of_go(close)
        inside = self.tokens[self.at : close]
        if any(x.kind == "name" and x.text == "for" for x in inside):
            raise Unread("a loop is not read", opened.line)
        if self.language.blanks:
            return self._matrix(close)
        if self.language.name == "rust" and self._outside(";", inside) is not None:  # [x; n]
            x = self.expression()
            self.take(";")
            n = number(self.expression()).whole()
            self.take("]")
            return repeated(x, n)
        return self.items("]")

    def _of_go(self, close: int) -> Any:
        self.at = close + 1
        while self.sees("[") or (
            (t := self.peek()) is not None and t.kind == "name" and not self.sees("{")
        ):
            if self.sees("["):
                self.at = self.partner(self.at) + 1
            else:
                self.take()
        self.take("{")
        return self._braced("", 0)

    def _matrix(self, close: int) -> Any:
        """Read ``[a b; c d]``, ``[a, b]`` or ``[a; b]``."""
        rows: list[list[Any]] = [[]]
        blanks, self.blanks = self.blanks, True
        comma = False
        try:
            while self.at < close:
                t = self.tokens[self.at]
                if t.kind == "line" or t.text == ";":
                    self.at += 1
                    if rows[-1] and not (comma and t.kind == "line"):
                        rows.append([])
                    continue
                if t.text == ",":
                    self.at, comma = self.at + 1, True
                    continue
                comma = False
                before = self.at
                rows[-1].append(self._entry(("]", "line")))
                if self.at == before:
                    raise Unread("a matrix is not understood", t.line)
        finally:
            self.blanks = blanks
        self.at = close + 1
        rows = [x for x in rows if x]
        if all(len(row) == 1 for row in rows):
            return bounded(row[0] for row in rows)
        return bounded(rows[0] if len(rows) == 1 else rows)

    def _braced(self, name: str, line: int) -> Any:
        """Read ``{..}`` after its bracket: a list, or names with values."""
        found: list[Any] = []
        record = Record(name, line)
        while not self.sees("}"):
            t = self.peek()
            if t is None:
                raise Unread("a bracket is not closed")
            label = self._label()
            place = self._place()
            x = self._entry(("}",))
            if label:
                record.fields[label] = x
            else:
                found += [Number(Exact(0)) if isinstance(x, Number) else []
                          for _ in range(len(found), place)]  # fmt: skip
                found.append(self._unquoted(x))
            if self.sees(",", ";"):
                self.at += 1
            elif not self.sees("}"):
                raise Unread("a comma is expected", t.line)
        self.take("}")
        if not record.fields:
            while (
                len(found) == 1
                and isinstance(found[0], list)
                and found[0]
                and all(isinstance(x, list) for x in found[0])
            ):
                found = found[0]  # {{{..}, {..}}}
            return bounded(found)
        records = any(isinstance(x, Record) for x in record.fields.values())
        if _is_numbered(record.fields) and not records:
            return _numbered(record.fields)
        record.values = [("", x) for x in found]
        return record

    def _place(self) -> int:
        """Pass ``2:`` before an entry of an array of Go, and return the place it names, or 0."""
        t = self.peek()
        follows = self.tokens[self.at + 1 : self.at + 2]
        if self.language.name != "go" or t is None or t.kind != "number" or not follows:
            return 0
        if follows[0].text != ":" or not t.text.isdigit() or int(t.text) > MAX_SIZE:
            return 0
        self.at += 2
        return int(t.text)

    def _label(self) -> str:
        """Pass ``name:``, ``"name":`` or ``.name =`` before a value and return the name."""
        dot = self.sees(".")
        k = self.at + dot
        if k + 1 >= self.end:
            return ""
        x, y = self.tokens[k], self.tokens[k + 1]
        number = self.language.name in ("python", "javascript")
        keys = ("name", "string", "number") if number else ("name", "string")
        words = [y.text for y in self.tokens[k : k + 6]]
        if number and len(words) == 6 and [words[i] for i in (0, 2, 4, 5)] == ["(", ",", ")", ":"]:
            self.at = k + 6  # (2, 1): of a dictionary
            return f"{words[1]},{words[3]}"
        if x.kind in keys and y.text in (":", "=", "=>"):
            if y.text == "=" and self.language.name == "fortran":
                return ""
            self.at = k + 2
            return x.text.strip("\"'")
        return ""

    # --- names and calls --------------------------------------------------------------------------

    def _named(self, t: Token) -> Any:
        name, language = t.text, self.language.name
        if name in _NOTHING:
            return None
        if name == "new":
            return self._new()
        if name == "map" and language == "go" and self.sees("["):
            self.take()
            return self._of_go(self.partner(self.at - 1))
        if name in _WORDS and (name != "lambda" or language == "python"):
            raise Unread(f"{name!r} is not read here", t.line)
        after = self.tokens[self.at] if self.at < self.end else None
        if after is not None and after.kind == "string" and not after.spaced:
            self.at += 1
            return self._literal_text(after.text) if name == "big" else after.text
        if name in ("vec", "array", "svec") and after is not None and after.text == "!":
            self.at += 1  # vec![..]
            return self._primary()
        sizes: list[int] = []
        while self.sees(".", "->", "::") and self.at + 1 < self.end:
            nxt = self.tokens[self.at + 1]
            if nxt.text == "<" and language == "rust":  # SMatrix::<f64, 2, 2>::new
                self.at, start = self.at + 1, self.at + 1
                self._template()
                inside = self.tokens[start : self.at]
                sizes = [int(x.text) for x in inside if x.kind == "number" and x.text.isdigit()]
                continue
            if nxt.kind != "name":
                break
            members = ("sqrt", "reshape", "T", "transpose", "at", *_COPIES)
            known = nxt.text in members or nxt.text.lower() in ARITHMETIC
            if known and self._known(name):
                break
            self.at += 2
            name = f"{name}.{nxt.text}"
        if self.sees("<") and language in ("c", "java", "rust"):
            self._template()
        if self.sees("{") and language == "julia":  # a parameter of a type
            self.at = self.partner(self.at) + 1
        if self.sees("[") and self.language is LANGUAGES["kotlin"]:  # Array[Double](..)
            end = self.partner(self.at)
            typed = [x.text for x in self.tokens[end + 1 : end + 2]] == ["("]
            self.at = end + 1 if typed and not self._known(name) else self.at
        t2 = self.peek()
        if t2 is not None and not (self.blanks and t2.spaced):
            if t2.text == "(" and sizes:
                return self._of_sizes(name, sizes)
            if t2.text == "(":
                return self._call(name, t)
            if t2.text == "{" and language in ("c", "java", "rust", "go"):
                self.take()
                x = self._braced(name, t.line)
                return (
                    x[0] if isinstance(x, list) and len(x) == 1 and isinstance(x[0], Number) else x
                )
            if t2.text == "[" and language == "julia" and not self._known(name):
                self.take()
                return self._square(t)
        root = re.fullmatch(r"(?:\w+\.)*SQRT_(\d+)", name)
        if root and not self._known(name):
            return _rooted(literal(root[1]))
        return self.look(name)

    def _literal_text(self, text: str) -> Any:
        said = text.strip("\"' ")
        top, slash, below = said.partition("/")
        x = self._literal(top.strip().lstrip("+-"))
        x = Number(-x.value, x.places, x.size) if top.strip().startswith("-") else plain(x)
        return _apply("/", x, plain(self._literal(below.strip())), self.language) if slash else x

    def _new(self) -> Any:
        """Read ``new double[][] {..}``, ``new double[4]`` or ``new Type(..)``."""
        t = self.take() if not self.sees("[") else self.tokens[self.at - 1]
        while self.sees("."):
            self.at += 1
            self.take()
        sizes: list[int] = []
        while self.sees("["):
            self.take()
            while not self.sees("]"):  # double[3, 2] and double[,] of C#
                open_ = self.sees(",")
                sizes.append(-1 if open_ else number(self.expression()).whole())
                self.at += self.sees(",")
            sizes += [] if sizes else [-1]
            self.take("]")
        if self.sees("{"):
            self.take()
            return self._braced("", t.line)
        if self.sees("("):
            array, end = t.text.endswith("Array"), self.partner(self.at)
            if array and end == self.at + 1:  # new Float64Array()
                self.at = end + 1
                return []
            x = self._call(t.text, t)
            zeros = array and isinstance(x, Number)
            return Frame(filled([x.whole()], Number(Exact(0)))) if zeros else x
        if sizes and -1 not in sizes:
            return Frame(filled(sizes, Number(Exact(0))))
        raise Unread("the size of an array is not known")

    def _template(self) -> None:
        """Pass the parameters of a template before a bracket."""
        depth = 0
        for k in range(self.at, min(self.end, self.at + 60)):
            x = self.tokens[k].text
            depth += (x == "<") - (x == ">") - 2 * (x == ">>")
            if x in (";", "{", "}"):
                return
            if depth <= 0:
                after = self.tokens[k + 1].text if k + 1 < self.end else ""
                if after in ("(", "{", "::"):
                    self.at = k + 1
                return

    def _arguments(self) -> tuple[list[tuple[str, Any]], dict[str, Any]]:
        """Read the arguments of a call, each with its name where it is only that."""
        self.take("(")
        blanks, self.blanks = self.blanks, False
        values: list[tuple[str, Any]] = []
        words: dict[str, Any] = {}
        try:
            while not self.sees(")"):
                t = self.peek()
                if t is None:
                    raise Unread("a bracket is not closed")
                if self.sees(";", ","):
                    self.at += 1
                    continue
                label = ""
                nxt = self.tokens[self.at + 1] if self.at + 1 < self.end else None
                if nxt is not None and (nxt.text == "=>" or (t.kind == "name" and nxt.text == "=")):
                    label, self.at = t.text.strip("\"'"), self.at + 2
                start = self.at
                x = self._entry((")",))
                part = [y for y in self.tokens[start : self.at] if y.kind != "line"]
                alone = all(y.kind == "name" or y.text in (".", "::", "->", "&", "[", "0", "]")
                            for y in part)  # fmt: skip
                names = [y.text for y in part if y.kind == "name"]
                if label:
                    words[label] = x
                else:
                    values.append((names[-1] if alone and names else "", x))
        finally:
            self.blanks = blanks
        self.take(")")
        return values, words

    def _call(self, name: str, t: Token) -> Any:
        last = name.rpartition(".")[2]
        low = last.lower()
        if self.language.calls_index or self.language.name == "c":
            held = self.look(name) if self._known(name) else None
            if isinstance(held, list | Entries):
                self.take("(")
                return self._taken(held, self.indices(")"))
        start = self.at
        values, words = self._arguments()
        given = [x for _, x in values]
        if low == "loads" and given and isinstance(given[0], str):
            lines = [x.line for x in self.tokens[start : self.at] if x.kind == "string"]
            return self._of_json(given[0], lines[0] if lines else t.line)
        if low == "dict" and words and _is_numbered(words):
            return _numbered(words)
        owner = name[: -len(last) - 1]
        if low == "sum" and owner and self._known(owner):
            given = [self.look(owner), *given]
        found = self._function(low, given, words)
        if found is not _NOT_KNOWN:
            return found
        if low in _LISTS_OF_ANY.get(self.language, ()) and not words:
            return bounded([plain(x) for x in given])
        upper = last[:1].isupper() or low in _CASTS or last.endswith("_")
        if upper and len(given) == 1 and not (words.keys() - {"dtype", "kind", "device"}):
            x = given[0]
            if isinstance(x, Unread):
                raise x
            if isinstance(x, str):
                return self._literal_text(x)
            if isinstance(x, Number | list):
                return plain(x)
        if low in _LISTS and len(given) > 1 and all(isinstance(x, Number) for x in given):
            return [plain(x) for x in given]
        if low in _CASTS and given:
            lists = [x for x in given if isinstance(x, list)]
            if len(lists) == 1:
                return lists[0]
            if isinstance(given[-1], Number) and low in (
                "convert",
                "map",
                "parse",
                "real",
                "tparse",
            ):
                return given[0] if low == "real" else given[-1]
            if isinstance(given[-1], str) and low in ("parse", "tparse"):
                return self._literal_text(given[-1])
        if (
            words
            or sum(isinstance(x, list | Number | Unread) for x in given) > 1
            or (given and isinstance(given[0], list))
        ):
            return Record(name, t.line, words, values)
        if len(given) == 1 and isinstance(given[0], Record) and not words:
            return given[0]  # a call that looks at what another one returns
        raise Unread(f"the function {name[:40]!r} is not read", t.line)

    def _of_sizes(self, name: str, sizes: list[int]) -> Any:
        """Return a vector or matrix of given sizes from its entries, by rows or by columns."""
        flat = [plain(x) for x in flattened([x for _, x in self._arguments()[0]])]
        if len(flat) != math.prod(sizes) or len(sizes) > 2:
            raise Unread(f"{name[:40]!r} has not as many entries as its sizes say")
        if len(sizes) == 1:
            return bounded(flat)
        m, n = sizes
        if "column" in name:
            return [flat[i::m] for i in range(m)]
        return [flat[i * n : (i + 1) * n] for i in range(m)]

    def _of_json(self, text: str, line: int) -> Any:
        """Return what a text of JSON in a source holds."""
        inside, language = text.strip("\"'"), LANGUAGES["javascript"]
        found = [x._replace(line=x.line + line - 1) for x in tokens(inside, language)[0]]
        return Folder(found, language, self.look).expression()

    def _function(self, low: str, given: list[Any], words: Mapping[str, Any]) -> Any:
        """Return the value of a function that is known by its name, or a mark."""
        if low in _QUOTIENTS and given:
            if len(given) == 1 and isinstance(given[0], str):
                return self._literal_text(given[0])
            if len(given) == 1:
                return plain(given[0])
            return _apply("/", plain(given[-2]), plain(given[-1]), self.language)
        if low.endswith("sqrt") and len(given) >= 1:
            return _rooted(given[0])
        if low in ("cbrt", "cube_root", "cuberoot", "thirdroot") and len(given) == 1:
            return power(given[0], Number(Exact(Fraction(1, 3))))
        if low.endswith(("pow", "power", "powerr")) and len(given) == 2:
            return power(given[0], given[1])
        if low in ("sqr", "petscsqr", "square") and len(given) == 1:
            return power(given[0], Number(Exact(2)))
        if low == "inv" and len(given) == 1:
            return power(given[0], Number(Exact(-1)))
        plain_one = low in ("zero", "one") and not any(isinstance(x, Number | list) for x in given)
        if plain_one or low in ("one", "getone", "getzero"):
            return Number(Exact(int(low.endswith("one"))))
        if low in ("zeros", "zero", "ones", "fill", "empty", "zeros_like", "buildarray") and given:
            return self._filled(low, given)
        if low == "getfield" and not given:
            return "field"
        if low in ("transpose", "permutedims"):
            return transposed(given[0])
        if low in ("vcat", "concatenate", "hstack", "cat", "concat") and given:
            parts = given if low == "vcat" else given[0]
            if not isinstance(parts, list) or not all(isinstance(x, list) for x in parts):
                raise Unread("parts of an array are not lists")
            return bounded(x for part in parts for x in part)
        if low == "matrix" and self.language is LANGUAGES["r"] and isinstance(given[0], list):
            return self._matrix_of_r(given, words)
        if low == "reshape" and given and len(given) + ("shape" in words) >= 2:
            dims = [*given[1:2], *([words["shape"]] if "shape" in words else [])]
            places = [whole_number(x) for x in flattened([words.get("order", [])])]
            if places == [2, 1] and isinstance(dims[0], list):  # rows first
                return transposed(self._reshaped(given[0], [dims[0][::-1]]))
            return self._reshaped(given[0], dims if len(given) < 3 else given[1:])
        if low in _OF_LISTS and given and isinstance(given[0], list):
            return self._of_list(low, given, words)
        if low in ("exp", "log", "sin", "cos", "tan", "abs", "min", "max", "sum", "len", "diag"):
            raise Unread(f"the function {low!r} is not read")
        return _NOT_KNOWN

    def _of_list(self, low: str, given: list[Any], words: Mapping[str, Any]) -> Any:
        more = [*given[1:], *words.values()]
        if not more:
            return _OF_LISTS[low](given[0])
        rows = all(isinstance(x, list) for x in given[0])
        if low == "sum" and rows and whole_number(more[0]) in (1 + self.language.base, -1):
            return [total(row) for row in given[0]]
        return _NOT_KNOWN

    def _filled(self, low: str, given: list[Any]) -> Any:
        if low == "fill":
            value, given = given[0], given[1:]
        else:
            value = Number(Exact(int(low == "ones")))
        dims: list[int] = []
        for x in given:
            if isinstance(x, Number):
                dims.append(x.whole())
            elif isinstance(x, list) and all(isinstance(y, Number) for y in x):
                dims += [y.whole() for y in x]
        if not dims or not all(0 <= n <= 100 for n in dims):
            raise Unread("the size of an array is not known")
        return Frame(filled(dims, value))

    def _matrix_of_r(self, given: list[Any], words: Mapping[str, Any]) -> Any:
        """Return ``matrix(c(..), nrow, ncol, byrow)``, by columns where nothing else is said."""
        flat = flattened(given[0])
        m, n = (whole_number(words.get(key, x)) for key, x in
                zip(("nrow", "ncol"), [*given[1:3], None, None], strict=False))  # fmt: skip
        if not (m or n):
            raise Unread("the size of a matrix is not known")
        m, n = m or len(flat) // (n or 1), n or len(flat) // (m or 1)
        by_row = "byrow" in words and not str(words["byrow"]).startswith("the name 'F")
        dims = [Number(Exact(x)) for x in ((n, m) if by_row else (m, n))]
        found = self._reshaped(flat, [dims])
        return transposed(found) if by_row else found

    def _reshaped(self, x: Any, dims: list[Any]) -> Any:
        sizes = [
            y for d in dims for y in (d if isinstance(d, list) else [d]) if isinstance(y, Number)
        ]
        flat = flattened(x)
        n = [y.whole() for y in sizes]
        if len(n) == 2 and n[0] * n[1] == len(flat):
            if self.language.base:  # columns first
                return [[flat[i + j * n[0]] for j in range(n[1])] for i in range(n[0])]
            return [flat[i * n[1] : (i + 1) * n[1]] for i in range(n[0])]
        if len(n) == 1:
            return flat
        raise Unread("an array is given a shape that is not read")

    # --- what follows a value ---------------------------------------------------------------------

    def _postfix(self, x: Any) -> Any:
        while True:
            t = self.peek()
            if t is None or t.kind != "mark" or (self.blanks and t.spaced):
                return x
            if t.text == "[" and isinstance(x, list):
                self.take()
                x = self._taken(x, self.indices("]"))
            elif t.text == "[" and isinstance(x, Entries):
                index: list[Any] = []
                while self.sees("["):
                    self.take()
                    index += self.indices("]")
                x = self._taken(x, index)
            elif t.text == "(" and isinstance(x, list) and self.language.calls_index:
                self.take()
                x = self._taken(x, self.indices(")"))
            elif t.text in ("'", ".'") and self.language.blanks and not t.spaced:
                self.take()
                x = transposed(x)
            elif (
                t.text == "." and self.at + 1 < self.end and self.tokens[self.at + 1].kind == "name"
            ):
                self.at += 1
                x = self._member(x, self.take())
            else:
                return x

    def _member(self, x: Any, t: Token) -> Any:
        name = t.text
        called = self.sees("(")
        values, words = self._arguments() if called else ([], {})
        given = [y for _, y in values]
        if name == "sqrt":
            return _rooted(x)
        if name.lower() in ARITHMETIC and len(given) == 1:
            return _apply(ARITHMETIC[name.lower()], x, given[0], self.language)
        if name == "at" and given and isinstance(x, list | Entries):
            return self._taken(x, given)
        if name == "negate":
            return negative(x)
        if name in ("getOne", "getZero"):
            return Number(Exact(int(name == "getOne")))
        if name in ("T", "transpose") and not given:
            return transposed(x)
        if name == "reshape":
            return self._reshaped(x, given)
        if name == "sum" and called and isinstance(x, list):
            return self._function(name, [x, *given], words)
        if name in _COPIES:
            return given[0] if name == "newInstance" and given else x
        raise Unread(f"{name!r} of a value is not read", t.line)

    def indices(self, close: str) -> list[Any]:
        """Read indices and ranges through the closing bracket."""
        found: list[Any] = []
        while not self.sees(close):
            if self.sees(","):
                self.at += 1
                continue
            bounds: list[Any] = [None]
            while not self.sees(",", close):
                if self.sees(":"):
                    self.at += 1
                    bounds.append(None)
                elif self.sees("end"):
                    self.at += 1
                    bounds[-1] = "end"
                else:
                    bounds[-1] = self.expression()
            found.append(bounds[0] if len(bounds) == 1 else tuple(bounds))
        self.take(close)
        return found

    def _taken(self, x: Any, index: list[Any]) -> Any:
        if isinstance(x, Entries) and len(index) == 2 and index[1] == (None, None):
            i = number(index[0]).whole()  # a row of a matrix whose entries are given one by one
            top = max((k[1] for k in x if len(k) == 2 and k[0] == i), default=0)
            zero = Number(Exact(0))
            return [x.get((i, j), zero) for j in range(self.language.base, top + 1)]
        if isinstance(x, Entries):
            place = tuple(number(k).whole() for k in index)
            if place not in x and x.cleared:
                return Number(Exact(0))
            if not isinstance(x.get(place), Number):
                held = x.get(place)
                raise held if isinstance(held, Unread) else Unread("an entry is not given")
            return x[place]
        for k, at in enumerate(index):
            if not isinstance(x, list):
                raise x if isinstance(x, Unread) else Unread("an index into a number")
            if isinstance(at, tuple):
                if len(at) == 3 and at[:2] == (None, None) and number(at[2]).whole() == -1:
                    x = x[::-1]
                    continue
                low, high = at[:2]
                start = 0 if low is None else number(low).whole() - self.language.base
                stop = None if high in (None, "end") else number(high).whole()
                part = x[start:stop]
                rest = index[k + 1 :]
                return [self._taken(y, rest) for y in part] if rest else part
            n = -1 if at == "end" else number(at).whole()
            n = n if n < 0 else n - self.language.base
            if not -len(x) <= n < len(x):
                raise Unread("an index lies outside of its array")
            x = x[n]
        if isinstance(x, Unread):
            raise x
        return x


_NOT_KNOWN = object()


def _is_numbered(fields: Mapping[str, Any]) -> bool:
    """Return whether keys are places of entries, or of rows that follow one another and grow."""
    if not all(re.fullmatch(r"\d+(?:,\d+)*", x) for x in fields):
        return False
    if not any(isinstance(x, list) for x in fields.values()):
        return True
    sizes = [len(x) if isinstance(x, list) else 1 for x in fields.values()]
    short = [k - x for k, x in enumerate(sizes, sizes[0])]  # zeros at the ends are left out
    grow = min(short) >= 0 and sum(map(bool, short)) < 3
    return grow or (len(set(sizes)) == 1 and sizes[0] == len(sizes))


def _numbered(fields: Mapping[str, Any]) -> Entries:
    """Return an array from a dictionary whose keys are the numbers of its entries, or its rows."""
    found = Entries()
    for key, x in fields.items():
        place = tuple(map(int, key.split(",")))
        if isinstance(x, Entries):
            found |= {(*place, *k): y for k, y in x.items()}
        else:
            found[place] = Number(Exact(0)) if x is None else plain(x)
    return found


def number(x: Any) -> Number:
    """Return x, which must be a number."""
    if isinstance(x, Unread):
        raise x
    if not isinstance(x, Number):
        raise Unread("a number is expected")
    return x


def total(x: Sequence[Any]) -> Number:
    """Return the sum of a list of numbers."""
    found = Number(Exact(0))
    for y in x:
        found = found.of(found.value + number(y).value, y)
    return found


#: Functions of one list.
_OF_LISTS: Mapping[str, Callable[[list[Any]], Any]] = {
    **dict.fromkeys("flip flipud fliplr reverse reversed".split(), lambda x: x[::-1]),
    "sum": total,
    "vec": lambda x: x,
    "diff": lambda x: [pairwise("-", q, p) for p, q in itertools.pairwise(x)],
}


def plain(x: Any) -> Any:
    """Return a value whose quotients are not cut."""
    if isinstance(x, Integer):
        found = Number(x.value, x.places, x.size)
        found.place = x.place
        return found
    if isinstance(x, Frame):
        return x
    return [plain(y) for y in x] if isinstance(x, list) else x


def repeated(x: Any, n: int) -> Frame:
    """Return n copies of a value."""
    if not 0 <= n <= 100:
        raise Unread("an array is too large")
    return Frame(bounded([list(x) if isinstance(x, list) else x for _ in range(n)]))


def flattened(x: Any) -> list[Any]:
    """Return the entries of nested lists, row by row."""
    return [z for y in x for z in flattened(y)] if isinstance(x, list) else [x]


def _rooted(x: Any) -> Any:
    if isinstance(x, list):
        return [_rooted(y) for y in x]
    n = number(x)
    return n.of(n.value.sqrt())
