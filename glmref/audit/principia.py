"""Methods of Principia: C++ structs whose members are the orders and the arrays."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from .code import bare, evaluated
from .table import ZERO, Rows, Table, vector
from .values import Number, Scope, Unread

_STRUCT = re.compile(
    r"^struct\s+([^\s:{]+)\s*:\s*([^\s{]+)\s*\{(.*?)^\};", re.DOTALL | re.MULTILINE
)
_MEMBER = re.compile(
    r"static\s+constexpr\s+(?:int|double|auto|Fixed\w+<[^;={]*?>)\s+(?:const\s+)?([^\s={]+)\s*=?\s*"
    r"([^;]+);"
)
_HAT, _PRIME = "\N{COMBINING CIRCUMFLEX ACCENT}", "\N{MODIFIER LETTER PRIME}"


def structs(text: str) -> Iterator[Table]:
    """Yield tables of a header.

    Yields
    ------
    Table
        One for each struct; of an embedded Nystrom method a second one for the lower order.
    """
    text = bare(text)
    text = re.sub(r"(?<=\d)'(?=\d)", "", text)
    for found in _STRUCT.finditer(text):
        name, base, body = found.groups()
        line = text.count("\n", 0, found.start()) + 1
        scope = _members(body)
        if base == "not_constructible" or not scope:
            continue
        try:
            yield from _tables(name, line, base, scope)
        except Unread as error:
            yield Table(name, line, unread=str(error))


def _members(body: str) -> Scope:
    scope: Scope = {}
    for key, value in _MEMBER.findall(body):
        try:
            value = re.sub(r"Fixed\w+<[^<>]*>(?=\s*\{)", "", value)
            value = re.sub(r"\{[\s{]*", "{", re.sub(r"\}[\s}]*", "}", value))
            scope[key] = evaluated(value, scope)
        except Unread as error:
            scope[key] = error
    return scope


def _array(scope: Scope, key: str) -> list[Number]:
    value = scope.get(key, Unread(f"there is no member {key}"))
    if isinstance(value, Unread):
        raise value
    return vector(value)


def _order(scope: Scope, key: str) -> int | None:
    value = scope.get(key)
    return value.whole() if isinstance(value, Number) else None


def _lower(scope: Scope, key: str, s: int) -> Rows:
    """Return a strictly lower triangle, row after row."""
    flat = _array(scope, key)
    if len(flat) != s * (s - 1) // 2:
        raise Unread(f"{key} has {len(flat)} entries, and {s} stages need {s * (s - 1) // 2}")
    rows: Rows = []
    for i in range(s):
        at = i * (i - 1) // 2
        rows.append([*flat[at : at + i], *([ZERO] * (s - i))])
    return rows


def _tables(name: str, line: int, base: str, scope: Scope) -> Iterator[Table]:
    if "Multistep" in base:
        raise Unread("a linear multistep method is no tableau")
    order: Any = _order(scope, "order")
    if base.startswith("Symplectic"):
        a, b = _array(scope, "a"), _array(scope, "b")
        yield Table(name, line, "splitting", [], [a, b], order=order)
        return
    if "RungeKutta" not in base:
        raise Unread(f"methods of the kind {base} are not read")
    c = _array(scope, "c")
    A = _lower(scope, "a", len(c))
    if base == "ExplicitRungeKutta":
        yield Table(name, line, A=[A], b=[_array(scope, "b")], c=[c], order=order)
        return
    high, low = _order(scope, "higher_order"), _order(scope, "lower_order")
    b, hat = _array(scope, "b"), _array(scope, "b" + _HAT)
    if "Nystr" not in base:
        yield Table(name, line, A=[A], b=[hat], c=[c], order=high, rows=[("b", b, low)])
        return
    inner = "a" + _PRIME
    velocity = [_lower(scope, inner, len(c))] if inner in scope else []
    for title, order, row, key in (
        (name, high, hat, "b" + _HAT + _PRIME),
        (f"{name}, lower order", low, b, "b" + _PRIME),
    ):
        weights = [row, _array(scope, key)]
        yield Table(title, line, "nystrom", [A, *velocity], weights, [c], order)
