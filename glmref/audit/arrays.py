"""Steppers of GSL and of Boost.odeint: a file each, with the coefficients in arrays beside it."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping

from ..exact import Exact
from .code import bare, rewritten
from .table import Rows, Table, vector
from .values import Number, Scope, Sparse, Unread, assign, evaluate

_ZERO = Number(Exact(0))


def _value(text: str, scope: Scope) -> list[Number]:
    try:
        node = ast.parse(rewritten(" ".join(text.split())).strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError):
        raise Unread(f"{text[:40]!r} is not understood") from None
    return vector(evaluate(node, scope))


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
    return [[*rows.get(i, []), *([_ZERO] * (s - len(rows.get(i, []))))] for i in range(1, s + 1)]


# --- GSL ------------------------------------------------------------------------------------------

_STATIC = re.compile(r"static\s+const\s+double\s+(\w+)\s*(?:\[\s*\w*\s*\])?\s*=\s*([^;=]+);")


def gsl(text: str) -> Iterator[Table]:
    """Yield the table of a stepper: rows b21, b3, b4, .., weights c1, .. or Abar, abscissae ah.

    Yields
    ------
    Table
        Unread where the coefficients stand in the arithmetic of the step.
    """
    text = bare(text)
    order = r"^(\w+)_order\s*\([^)]{0,400}\)\s*\{.{0,4000}?return\s+(\d+)\s*;"
    made = re.search(order, text, re.DOTALL | re.M)
    stepper = made or re.search(r"^(\w+)_order\s*\(", text, re.M)
    if stepper is None:
        return
    line = text.count("\n", 0, (_STATIC.search(text) or stepper).start()) + 1
    for table in _guarded(_of_gsl, text, stepper[1].removesuffix("_eval"), line):
        table.order = int(made[2]) if made else None
        yield table


def _of_gsl(text: str) -> Table:
    scope: Scope = {key: _value(value, {}) for key, value in _STATIC.findall(text)}
    rows = {int(k[1:]): x for k, x in scope.items() if re.fullmatch(r"b\d+", k) and k != "b21"}
    if not rows:
        raise Unread("the coefficients are computed, or stand in the arithmetic of the step")
    rows[2] = scope.get("b21", scope.get("ah", [])[:1])
    s = max(rows)
    table = Table("", 0, A=[_triangle(rows, s)])
    if "Abar" in scope:
        table.b = [scope["Abar"]]
        low = scope.get("A", [])
        table.rows = [("A", [*low, *([_ZERO] * (s - len(low)))], None)]
    else:
        table.b = [[scope.get(f"c{k}", [_ZERO])[0] for k in range(1, s + 1)]]
    if len(table.b[0]) != s:
        raise Unread(f"there are {len(table.b[0])} weights for {s} stages")
    if "ec" in scope:  # its entry 0 is not used
        table.errors = [scope["ec"][1:]]
    given = [_ZERO, *scope.get("ah", [])]
    given += [Number(Exact(1))] * (s - len(given))  # where it is short, the last stages are at 1
    table.c = [given[:s]]
    return table


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
            item = _value(value, scope)
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
            scope[key] = _value(value, scope)[0]
    last = max(int(k[1]) for k in scope if k[0] == "b")
    s = last + (f"dc{last + 1}" in scope)  # the new value is a stage where the error uses it

    def row(key: str, n: int) -> list[Number]:
        return [scope.get(f"{key}{k}", _ZERO) for k in range(1, n + 1)]

    rows = {i: row(f"b{i}", i - 1) for i in range(2, last + 1)} | {last + 1: row("c", last)}
    times = row("a", last)
    if f"a{last}" not in scope:  # a stage at the end of the step has no name
        times[-1] = Number(Exact(1))
    table = Table("", 0, A=[_triangle(rows, s)], b=[row("c", s)])
    table.c = [[*times, Number(Exact(1))][:s]]
    table.errors = [row("dc", s)]
    table.order = _declared(text)
    return table
