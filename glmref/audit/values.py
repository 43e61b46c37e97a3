"""Straight-line code of other people evaluated by hand: numbers, arrays, and nothing that runs.

Statements of C and Julia are rewritten as Python expressions, parsed by
:mod:`ast`, and evaluated over exact numbers by a table of arithmetic and of a few functions. What
is not in that table is *unread*, with its line; so is everything that is computed from it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import lru_cache
from math import nan, prod
from typing import Any, NamedTuple

from ..errors import ExactnessError
from ..exact import Exact
from ..exact.decimals import is_rounded
from ..system.budget import spend

_NUMERAL = re.compile(
    r"([-+]?)(?=\.?\d)(\d*)(\.?)(\d*)(?:[eEdDqQfF]([-+]?\d{1,4})?)?"  # 1.d0 and 1.f, too
)
_FORM = re.compile(r"([\d_']*)(\.?)([\d_']*)(.*)")
#: What may stand between digits.
PARTED = str.maketrans("", "", "_'")
_MOST_DIGITS = 2000  # of a number as it is written
_MOST_SIZE = 40_000  # digits of what is computed from numbers, as estimated
_MOST_ITEMS = 100_000  # numbers in an array


class Unread(Exception):
    """A statement or entry that is not understood, with its line."""

    def __init__(self, what: str, line: int = 0) -> None:
        super().__init__(what)
        self.line = line
        self.computed = False  # from an array


class Number:
    """An exact number, and how many digits after the point its roundest decimal has.

    Its size is the sum of those of the numbers that it is made of, an estimate of its digits.
    """

    __slots__ = ("approximate", "place", "places", "size", "value")

    def __init__(self, value: Exact, places: int | None = None, size: int = 1) -> None:
        if size > _MOST_SIZE:
            raise Unread("a number has more digits than are computed")
        self.value, self.places, self.size = value, places, size
        #: Line and text of the entry, where a reader notes them.
        self.place: tuple[int, str] | None = None
        self.approximate: float | None = None

    def of(self, value: Exact, other: Number | None = None) -> Number:
        """Return a result of arithmetic with this number, and maybe another."""
        used = (self,) if other is None else (self, other)
        places = [x.places for x in used if x.places is not None]
        return Number(value, min(places, default=None), sum(x.size for x in used))

    def whole(self) -> int:
        """Return the value as an integer."""
        x = self.value.as_fraction()
        if x is None or x.denominator != 1 or abs(x) > 10_000:
            raise Unread("an index must be a whole number")
        return int(x)

    def __repr__(self) -> str:
        return f"{complex(self.value).real:.17g}"


def whole_number(x: Any) -> int | None:
    """Return the integer that a value is, or ``None``."""
    try:
        return x.whole() if isinstance(x, Number) else None
    except Unread:
        return None


def size(x: Any) -> float:
    """Return a number as a float, nan for what was not folded."""
    if not isinstance(x, Number):
        return nan
    if x.approximate is None:
        x.approximate = complex(x.value).real
    return x.approximate


class Numeral(NamedTuple):
    """A numeral in any of the languages, without the marks that may part its digits."""

    sign: str
    before: str  #: Digits before the point.
    point: str
    after: str  #: Digits after it.
    power: int

    @classmethod
    def of(cls, text: str) -> Numeral | None:
        """Return what a text is as a numeral, ``None`` where it is none or a very long one."""
        found = _NUMERAL.fullmatch(text.translate(PARTED)) if len(text) <= _MOST_DIGITS else None
        return found and cls(found[1], found[2], found[3], found[4], int(found[5] or 0))

    @property
    def unit(self) -> Fraction:
        """Return a unit of its last digit."""
        shift = self.power - len(self.after)
        return Fraction(10**shift) if shift >= 0 else Fraction(1, 10**-shift)

    @property
    def value(self) -> Fraction:
        """Return the number."""
        return int(f"{self.sign}{self.before}{self.after}") * self.unit

    @property
    def digits(self) -> str:
        """Return the digits that say something: no zeros before them, nor alone after a point."""
        return (self.before + (self.after if self.after.strip("0") else "")).lstrip("0")


def literal(text: str) -> Number:
    """Return a number as it is written."""
    return Number(*_literal(text))


@lru_cache(maxsize=4096)
def _literal(text: str) -> tuple[Exact, int | None, int]:
    """Return value, digits after the point and size of a numeral; few stand very often."""
    x = Numeral.of(text)
    if x is None:
        raise Unread(f"{text[:40]!r} is no number")
    places = max(0, len(x.after) - x.power)
    exact = not x.point or not is_rounded(places)
    size = len(x.before + x.point + x.after) + abs(x.power)
    return Exact(x.value), None if exact else places, size


def spelled(text: str, value: Fraction, slack: Fraction = Fraction(0)) -> str:
    """Return a number in the way of a numeral, to as many digits after its point.

    Parameters
    ----------
    text : str
        The numeral, of which point, power of ten and marks between digits are kept.
    value : Fraction
        The number, not below 0.
    slack : Fraction, optional
        How far it may be off; digits that are not known are left out.
    """
    x = Numeral.of(text)
    if x is None:
        return str(value)
    places, unit = len(x.after), x.unit
    while places and unit < 2 * slack:
        places, unit = places - 1, 10 * unit
    digits = str(round(value / unit)).rjust(places + 1, "0")
    before, after = digits[: len(digits) - places], digits[len(digits) - places :]
    if before == "0" and not x.before:
        before = ""
    head, point, form, rest = _FORM.fullmatch(text).groups()  # type: ignore[union-attr]
    return f"{_parted(before[::-1], head[::-1])[::-1]}{point}{_parted(after, form)}{rest}"


def _parted(digits: str, form: str) -> str:
    """Return digits with the marks that a form has between its own."""
    left = iter(digits)
    said = "".join(x if x in "_'" else next(left, "") for x in form)
    return (said + "".join(left)).rstrip("_'")


Scope = dict[str, Any]

_ACCIDENTS = (ZeroDivisionError, RecursionError, IndexError, ValueError, TypeError, AttributeError)

_FIRST = {
    *("array", "tensor", "asarray", "SUN_RCONST", "RCONST", "RC", "PetscRealConstant", "PetscReal"),
    *("big", "BigFloat", "float", "Float64", "T", "T2", "S", "float64", "tuple", "list", "Rat"),
    *("SVector", "SMatrix", "SparseCoeffs", "Integer", "real", "dble", "SMat", "vec", "sympify"),
    *("constexpr", "double", "Tuple", "collect", "Array", "Matrix", "Vector", "copy", "SA", "RT"),
    *("asarray", "ascontiguousarray", "from_list", "one_", "Number", "permutedims_", "RealT"),
    *("BigInt", "Int", "Int64", "Real", "T1"),
}
_LAST = {"convert", "map", "parse", "tparse"}
_DOTTED = re.compile(r"[A-Za-z_\u0080-\uffff][\w.\u0080-\uffff]*")


def accident(error: Exception) -> str:
    """Return what went wrong as an expression was evaluated."""
    if isinstance(error, ZeroDivisionError):
        return "a quotient has the divisor 0"
    if isinstance(error, IndexError | KeyError):
        return "an index or a name lies outside of what is read"
    return str(error) if isinstance(error, ValueError) else "a value of another kind is expected"


def evaluate(node: ast.expr, scope: Mapping[str, Any]) -> Any:
    """Evaluate an expression: a :class:`Number`, nested lists of them, or a string."""
    return _Evaluator(scope).of(node)


class _Evaluator:
    def __init__(self, scope: Mapping[str, Any]) -> None:
        self.scope = scope

    def of(self, node: ast.AST) -> Any:
        spend()
        rule = getattr(self, f"_{type(node).__name__.lower()}", None)
        if rule is None:
            raise Unread(f"a {type(node).__name__} is not read", getattr(node, "lineno", 0))
        try:
            return rule(node)
        except Unread as error:
            error.line = error.line or getattr(node, "lineno", 0)
            raise
        except (*_ACCIDENTS, ExactnessError) as error:
            raise Unread(accident(error), getattr(node, "lineno", 0)) from None

    def _expression(self, node: ast.Expression) -> Any:
        return self.of(node.body)

    def _listcomp(self, node: ast.ListComp) -> list[Any]:
        """Evaluate ``[x[k] for k in span(1, s)]``, which Julia writes with ``1:s``."""
        loop, *more = node.generators
        call, name = loop.iter, loop.target
        if more or loop.ifs or not isinstance(name, ast.Name):
            raise Unread("a loop is not read")
        if not isinstance(call, ast.Call) or ast.unparse(call.func) != "span":
            raise Unread("a loop is not read")
        if len(call.args) != 2 or call.keywords:
            raise Unread("a range with a step is not read")
        first, last = (self.of(x) for x in call.args)
        if not (isinstance(first, Number) and isinstance(last, Number)):
            raise Unread("the ends of a range must be numbers")
        first, last = first.whole(), last.whole()
        if last - first > 200:
            raise Unread("a loop is too long")
        return bounded(
            _Evaluator({**self.scope, name.id: Number(Exact(k))}).of(node.elt)
            for k in range(first, last + 1)
        )

    def _constant(self, node: ast.Constant) -> Any:
        x = node.value
        if isinstance(x, bool) or x is None:
            return x
        if isinstance(x, int):
            return Number(Exact(x), size=1 + x.bit_length() // 3)
        if isinstance(x, str):
            return literal(x) if Numeral.of(x) else x
        raise Unread(f"{x!r} is no number that is read")

    def _list(self, node: ast.List | ast.Tuple) -> Any:
        return bounded(self.of(x) for x in node.elts)

    _tuple = _list

    def _name(self, node: ast.Name) -> Any:
        return self._look(node.id)

    def _look(self, name: str) -> Any:
        if name not in self.scope:
            raise Unread(f"the name {name!r} is not known")
        value = self.scope[name]
        if isinstance(value, Unread):
            raise value
        return value

    def _attribute(self, node: ast.Attribute) -> Any:
        name = ast.unparse(node)
        if name in self.scope:
            return self._look(name)
        raise Unread(f"the name {name[:40]!r} is not known")

    def _unaryop(self, node: ast.UnaryOp) -> Any:
        value = self.of(node.operand)
        if isinstance(node.op, ast.USub):
            return _each(lambda x: x.of(-x.value), value)
        if isinstance(node.op, ast.UAdd):
            return value
        raise Unread("an operator is not read")

    def _binop(self, node: ast.BinOp) -> Any:
        x, y = self.of(node.left), self.of(node.right)
        if isinstance(node.op, ast.Pow):
            return power(x, y)
        rule = _RULES.get(type(node.op))
        if rule is None:
            raise Unread("an operator is not read")
        return pairwise(rule, x, y)

    def _subscript(self, node: ast.Subscript) -> Any:
        base, parts = node.value, self._parts(node)
        while isinstance(base, ast.Subscript):
            base, parts = base.value, [*self._parts(base), *parts]
        value = self.of(base)
        if isinstance(value, Sparse):
            index = tuple(self.of(i).whole() for i in parts)
            return value.entries.get(index, Number(Exact(0)))
        if base is not node.value:
            value = self.of(node.value)
        return _taken(value, self._index(node.slice))

    @staticmethod
    def _parts(node: ast.Subscript) -> list[ast.expr]:
        return node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]

    def _index(self, node: ast.expr) -> list[Any]:
        parts = node.elts if isinstance(node, ast.Tuple) else [node]
        start = int(self.scope.get("1-based", 0))
        found: list[Any] = []
        for part in parts:
            if isinstance(part, ast.Slice):
                low = 0 if part.lower is None else self.of(part.lower).whole() - start
                high = None if part.upper is None else self.of(part.upper).whole()
                found.append(slice(low, high))
            elif isinstance(part, ast.Name) and part.id == "end":
                found.append(-1)
            else:
                k = self.of(part).whole()
                found.append(k if k < 0 else k - start)
        return found

    def _call(self, node: ast.Call) -> Any:
        name = ast.unparse(node.func)
        last = name.rpartition(".")[2]
        if last in _LAST:
            return self.of(node.args[-1])
        if last in ("Matrix", "Vector", "Array") and ast.unparse(node.args[0]) == "undef":
            return filled([self._size(x) for x in node.args[1:]], Number(Exact(0)))
        if last in _FIRST:
            return self.of(node.args[0])
        if last in ("PetscSqr", "sqr"):
            return power(self.of(node.args[0]), Number(Exact(2)))
        if last == "inv" and len(node.args) == 1:
            return power(self.of(node.args[0]), Number(Exact(-1)))
        if "sqrt" in last.lower():
            x = self.of(node.args[0])
            return _each(lambda n: n.of(_root(n)), x)
        if last == "cbrt":
            return power(self.of(node.args[0]), Number(Exact(Fraction(1, 3))))
        return self._call_of_arrays(node, name)

    def _call_of_arrays(self, node: ast.Call, name: str) -> Any:
        """Evaluate a method of a number or an array, or what makes, joins or measures arrays."""
        last = name.rpartition(".")[2]
        if last in ("Zero", "zeros", "ones", "fill"):
            value = Number(Exact(0 if last in ("zeros", "Zero") else 1))
            if last == "fill":
                value, node.args = self.of(node.args[0]), node.args[1:]
            return filled([self._size(x) for x in self._dims(node.args)], value)
        if last == "Rational" and len(node.args) == 2:
            return pairwise(_RULES[ast.Div], self.of(node.args[0]), self.of(node.args[1]))
        if last in ("one", "zero"):
            return Number(Exact(int(last == "one")))
        if last == "vcat":
            return bounded(x for part in node.args for x in self.of(part))
        if last in ("size", "len", "length"):
            return Number(Exact(len(self.of(node.args[0]))))
        raise Unread(f"the function {name[:40]!r} is not read")

    def _dims(self, args: list[ast.expr]) -> list[ast.expr]:
        if args and isinstance(args[0], ast.Tuple | ast.List):
            return list(args[0].elts)
        return [x for x in args if not (isinstance(x, ast.Name) and x.id not in self.scope)]

    def _size(self, node: ast.expr) -> int:
        n = self.of(node).whole()
        if not 0 <= n <= 100:
            raise Unread("an array is too large")
        return n


def power(x: Any, y: Any) -> Any:
    """Return x to the power of y, two numbers."""
    if not isinstance(x, Number) or not isinstance(y, Number):
        raise Unread("a power of arrays is not read")
    exponent = y.value.as_fraction()
    if exponent is None or abs(exponent.numerator) > 40 or exponent.denominator > 6:
        raise Unread("a power is not read")
    base = x.value
    if exponent.denominator > 1:
        base = base.sqrt() if exponent.denominator == 2 else base.root(exponent.denominator)
    size = x.size * max(1, abs(exponent.numerator))
    made = Number(x.value, x.places, size)  # before the power is computed
    power = base ** abs(exponent.numerator)
    return made.of(Exact(1) / power if exponent < 0 else power)


class Sparse:
    """Entries given one by one of an array that was never declared."""

    def __init__(self) -> None:
        self.entries: dict[tuple[int, ...], Number] = {}


def _root(n: Number) -> Exact:
    return n.value.sqrt()


def bounded(parts: Iterable[Any]) -> list[Any]:
    """Return an array that has no more numbers than are read; a part may stand in it many times."""
    found, left = [], _MOST_ITEMS
    for x in parts:
        left -= _items(x)
        if left < 0:
            raise Unread("an array is too large")
        found.append(x)
    return found


def _items(x: Any) -> int:
    return 1 + sum(map(_items, x)) if isinstance(x, list) else 1


def filled(dims: list[int], value: Number) -> list[Any]:
    """Return an array of one value."""
    if prod(dims) > _MOST_ITEMS:
        raise Unread("an array is too large")
    if len(dims) == 1:
        return [value] * dims[0]
    return [filled(dims[1:], value) for _ in range(dims[0])]


def _each(rule: Any, x: Any) -> Any:
    if isinstance(x, list):
        return [_each(rule, y) for y in x]
    if not isinstance(x, Number):
        raise Unread("a number is expected")
    return rule(x)


def pairwise(rule: Any, x: Any, y: Any) -> Any:
    """Apply arithmetic, a rule or its sign, to numbers or to arrays entry by entry."""
    rule = _SIGNS.get(rule, rule)
    if isinstance(x, list) and isinstance(y, list):
        if len(x) != len(y):
            raise Unread("two arrays have different lengths")
        return [pairwise(rule, a, b) for a, b in zip(x, y, strict=True)]
    if isinstance(x, list):
        return [pairwise(rule, a, y) for a in x]
    if isinstance(y, list):
        return [pairwise(rule, x, b) for b in y]
    if not (isinstance(x, Number) and isinstance(y, Number)):
        raise next((z for z in (x, y) if isinstance(z, Unread)), Unread("a number is expected"))
    return x.of(rule(x.value, y.value), y)


_RULES: Mapping[type, Any] = {
    ast.Add: lambda x, y: x + y,
    ast.Sub: lambda x, y: x - y,
    ast.Mult: lambda x, y: x * y,
    ast.Div: lambda x, y: x / y,
    ast.FloorDiv: lambda x, y: x / y,
}


_SIGNS: Mapping[Any, Any] = {
    "+": _RULES[ast.Add], "-": _RULES[ast.Sub], "*": _RULES[ast.Mult], "/": _RULES[ast.Div],
}  # fmt: skip


def _taken(value: Any, index: list[Any]) -> Any:
    for k, at in enumerate(index):
        if not isinstance(value, list):
            raise Unread("an index into a number")
        if isinstance(at, slice):
            part = value[at]
            return [_taken(x, index[k + 1 :]) for x in part] if index[k + 1 :] else part
        value = value[at]
    return value


def assign(target: ast.expr, value: Any, scope: Scope) -> None:
    """Carry out ``target = value``.

    Raises
    ------
    Unread
        Where the target is not a name or an array entry.
    """
    if isinstance(target, ast.Tuple | ast.List) and isinstance(value, list):
        for x, y in zip(target.elts, value, strict=False):
            assign(x, y, scope)
        return
    indices: list[ast.expr] = []
    while isinstance(target, ast.Subscript):
        parts = target.slice.elts if isinstance(target.slice, ast.Tuple) else [target.slice]
        indices, target = [*parts, *indices], target.value
    name = ast.unparse(target)
    if not _DOTTED.fullmatch(name):
        raise Unread(f"an assignment to {name[:40]!r} is not read")
    if not indices:
        scope[name] = value
        return
    held = scope.get(name)
    if isinstance(held, Unread):
        raise held
    if not isinstance(held, list | Sparse):
        held = scope[name] = Sparse()
    evaluator = _Evaluator(scope)
    if isinstance(held, Sparse):
        held.entries[tuple(evaluator.of(x).whole() for x in indices)] = value
        return
    at = evaluator._index(ast.Tuple(indices, ast.Load()))
    if len(at) == 2 and isinstance(at[0], slice) and isinstance(at[1], int):  # a column
        for row, x in zip(held[at[0]], value, strict=True):
            row[at[1]] = x
        return
    for k in at[:-1]:
        if isinstance(k, slice):
            raise Unread("an assignment to a block is not read")
        held = held[k]
    last = at[-1]
    if isinstance(last, slice):
        if not isinstance(value, list):
            value = [value] * len(held[last])
        if len(held[last]) != len(value):
            raise Unread("an assignment changes the length of a row")
    held[last] = value
