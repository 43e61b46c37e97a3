"""Steppers of Boost.odeint: a file each, with the coefficients in structs beside it."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping

from ..exact import Exact
from .code import bare, evaluated
from .table import ZERO, Rows, Table, vector
from .values import Number, Scope, Sparse, Unread, assign


def _guarded(
    make: Callable[[str], Table | None], text: str, name: str, line: int
) -> Iterator[Table]:
    try:
        table = make(text)
    except Unread as error:
        table = Table(name, line, unread=str(error))
    if table is not None:
        table.name, table.line = name, line
        yield table


def _triangle(rows: Mapping[int, list[Number]], s: int) -> Rows:
    """Return rows 2 to s below the diagonal."""
    for i in range(2, s + 1):
        if len(rows.get(i, [])) != i - 1:
            raise Unread(f"row {i} of A is not an array of {i - 1} numbers")
    return [[*rows.get(i, []), *([ZERO] * (s - len(rows.get(i, []))))] for i in range(1, s + 1)]


# --- Boost.odeint ---------------------------------------------------------------------------------

_ARRAY = re.compile(
    r"struct\s+(?:(\w+)_coefficients_(a\d+|b|db|c)|coef_([ab])_type)\b([^;].*?)\n\s*\};", re.DOTALL
)
_BASE = re.compile(
    r"(\w+_(?:generic_rk|stepper_base|fsal_base))\s*<\s*((?:[\w:]+\s*<[^<>]*>|[^<>])*)"
)


def odeint(text: str) -> Iterator[Table]:
    """Yield the table of a stepper: one struct for each row, or constants with a name each.

    Yields
    ------
    Table
        Nothing for a header that defines no coefficients.
    """
    text = re.sub(r"\bstatic_cast\s*<\s*\w+\s*>", "", bare(text))
    text = re.sub(r"(?<=\d)LL\b", "", text).replace("(*this)", "this")
    made = re.search(r"^class\s+(\w+)(?!\s*[,=>\w])", text, re.M)  # no parameter of a template
    if made is None:
        return
    name, line = made[1], text.count("\n", 0, made.start()) + 1
    if _ARRAY.search(text):
        yield from _guarded(_of_structs, text, name, line)
    elif re.search(r"const value_type b21\b", text):
        yield from _guarded(_of_constants, text, name, line)


def _declared(text: str) -> int | None:
    """Return the order among the arguments of the base: stages and order, or order first."""
    for base, said in _BASE.findall(text):
        whole = [int(x) for x in re.findall(r"(?<![\w.])\d+(?![\w.])", said)]
        if "generic" in base or "nystroem" in base:
            if len(whole) > 1:
                return whole[1]
        elif whole:
            return whole[0]
    return None


def _of_structs(text: str) -> Table:
    found: dict[str, list[Number]] = {}
    for _, key, half, body in _ARRAY.findall(text):
        scope: Scope = {"this": Sparse()}
        for target, value in re.findall(r"(this\[\d+\])\s*=([^;]+);", body):
            item = vector(evaluated(value, scope))
            assign(ast.parse(target, mode="eval").body, item[0], scope)
        entries = scope["this"].entries
        found[key or half.upper()] = [entries[x] for x in sorted(entries)]
    if "A" in found:
        return Table("", 0, "splitting", [], [found["A"], found["B"]], order=_declared(text))
    s = len(found.get("b", []))
    rows = {int(k[1:]) + 1: x for k, x in found.items() if k[1:].isdigit()}
    if not s or len(found.get("c", [])) != s:
        raise Unread("there are no arrays b and c of one length")
    table = Table("", 0, A=[_triangle(rows, s)], b=[found["b"]], c=[found["c"]])
    table.order = _declared(text)
    if "db" in found:
        table.errors = [found["db"]]
    return table


def _of_constants(text: str) -> Table:
    """Read a pair whose last stage is the new value: a2, b21, c1, dc1 are c, A, b and the error."""
    scope: Scope = {}
    for key, value in re.findall(r"const value_type ((?:a|b\d|d?c)\d)\s*=([^;]+);", text):
        if key not in scope:
            scope[key] = vector(evaluated(value, scope))[0]
    last = max(int(k[1]) for k in scope if k[0] == "b")
    s = last + (f"dc{last + 1}" in scope)  # the new value is a stage where the error uses it

    def row(key: str, n: int) -> list[Number]:
        return [scope.get(f"{key}{k}", ZERO) for k in range(1, n + 1)]

    rows = {i: row(f"b{i}", i - 1) for i in range(2, last + 1)} | {last + 1: row("c", last)}
    times = row("a", last)
    if f"a{last}" not in scope:  # a stage at the end of the step has no name
        times[-1] = Number(Exact(1))
    table = Table("", 0, A=[_triangle(rows, s)], b=[row("c", s)])
    table.c = [[*times, Number(Exact(1))][:s]]
    table.errors = [row("dc", s)]
    table.order = _declared(text)
    return table
