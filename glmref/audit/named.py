"""Tables of C++ and Java: a name for each number, and methods that return arrays.

What these have in common is that a name says what an array is: ``a21`` or ``getA()``.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

from ..exact import Exact
from .code import bare, rewritten
from .table import ZERO, Rows, Table, vector
from .values import Number, Scope, Unread, assign, evaluate


def _value(text: str, scope: Scope) -> Any:
    try:
        node = ast.parse(rewritten(" ".join(text.split())).strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise Unread(f"{text[:40]!r} is not understood") from None
    return evaluate(node, scope)


def _guarded(name: str, line: int, make: Callable[[], Table | None]) -> Iterator[Table]:
    try:
        table = make()
    except Unread as error:
        table = Table(name, line, unread=str(error))
    if table is not None:
        table.name, table.line = name, line
        yield table


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


def _leading(value: Any, s: int) -> Rows:
    """Rows of the first s stages; the others belong to a dense output."""
    if not isinstance(value, list) or len(value) < s:
        raise Unread(f"A has not the {s} rows of the weights")
    rows = [vector(x) for x in value[:s]]
    if any(complex(x.value) for row in rows for x in row[s:]):
        raise Unread("a stage needs one that has no weight")
    return [[*row[:s], *([ZERO] * (s - len(row)))] for row in rows]


# --- a name for each number -----------------------------------------------------------------------

_NAMED = re.compile(
    r"(?<![\w.\]])(?:\w+::)?([a-z]+_?)(\d+(?:_\d+)?|)\s*=(?!=)\s*([^;,=]+?)\s*(?=[;,])"
)


#: A number that gets a value, whether the statement ends or not.
_ASSIGNED = re.compile(r"(?<![\w.\]])(?:\w+::)?([abcde]|dc)(\d+(?:_\d+)?)\s*=(?!=)")


def constants(text: str, declared: Mapping[str, int] | None = None) -> Iterator[Table]:
    """The table of a C++ file whose coefficients have a name each.

    Two conventions are known: ``a21, b1, c2`` with ``d1`` (second weights) or ``e1`` (error), and
    ``b21, c1, a2`` with ``dc1`` (error), where without ``c1`` the last row holds the weights.
    """
    text = bare(text)
    first = re.search(r"\b[ab]21\s*=", text)
    if first is None:
        return
    made = re.search(r"(\w+)::(?:a21\b|\1\s*\()", text) or re.search(r"^class\s+(\w+)", text, re.M)
    name = made[1] if made else "constants"
    start, line = first.start(), _line(text, first.start())
    code = text[: text.find("\n}", start) % (len(text) + 1)]  # what follows is another function
    for table in _guarded(name, line, lambda: _of_constants(code)):
        table.order = (declared or {}).get(name)
        yield table


def _of_constants(text: str) -> Table:
    scope: Scope = {}
    found: dict[str, dict[str, Number]] = {}
    for letters, digits, value in _NAMED.findall(text):
        key = letters + digits
        if key in scope or not (digits or letters in ("gam", "gamma")):
            continue
        try:
            number = _value(re.sub(r"\b\w+::(?=[a-z]+\d)", "", value), scope)
        except Unread:
            continue  # a name of the step; where it was an entry, that entry has no name
        if isinstance(number, Number):
            scope[key] = number
            found.setdefault(letters, {})[digits] = number
    ends = {m.start(1) for m in _NAMED.finditer(text)}
    lost = next((m for m in _ASSIGNED.finditer(text) if m.start(1) not in ends), None)
    if lost is not None:
        raise Unread(f"the value of {lost[1]}{lost[2]} has no end: a `;` is missing")
    if found.keys() & {"gam", "gamma"}:
        raise Unread("a Rosenbrock method whose entries have names of their own")
    letter = "a" if "21" in found.get("a", {}) else "b"
    entries = {_pair(k): x for k, x in found[letter].items() if len(k) > 1}
    names = ("b", "c", "e", "d") if letter == "a" else ("c", "a", "dc", "c_")
    if "d" in found:
        found.pop("e", None)  # the second of many further rows
    weights, times, error, second = (
        {int(k): x for k, x in found.get(key, {}).items() if k.isdigit()} for key in names
    )
    s = max([i for i, _ in entries] + list(weights))
    A = [[entries.get((i, j), ZERO) for j in range(1, s + 1)] for i in range(1, s + 1)]

    def row(values: Mapping[int, Number]) -> list[Number]:
        return [values.get(k, ZERO) for k in range(1, s + 1)]

    table = Table("", 0, A=[A], b=[row(weights) if weights else A[-1]], c=[None], named=True)
    if times:
        sums = [sum((x.value for x in r), Exact(0)) for r in A]
        table.c = [[times.get(k + 1, Number(x)) for k, x in enumerate(sums)]]
    if error:
        if max(error) > s:  # the new value is a stage of the error estimate alone
            error = {k: x for k, x in error.items() if k <= s} | {s + 1: error[max(error)]}
        table.errors = [[error.get(k, ZERO) for k in range(1, max(s, *error) + 1)]]
    if second:
        table.rows = [(names[3], row(second), None)]
    return table


def _pair(digits: str) -> tuple[int, int]:
    """Row and column: 21, 101, 1110 or 11_10."""
    if "_" in digits:
        i, _, j = digits.partition("_")
    else:
        cut = 1 if len(digits) == 2 else 2
        i, j = digits[:cut], digits[cut:]
    if not j or int(j) >= int(i):
        raise Unread(f"the entry {digits} of A is not below the diagonal")
    return int(i), int(j)


# --- Java -----------------------------------------------------------------------------------------


def java(text: str, declared: Mapping[str, int] | None = None) -> Iterator[Table]:
    """The table of a class: what ``getA()``, ``getB()`` and ``getC()`` return, or ``STATIC_A``.

    A has no row for the first stage, and c no entry.
    """
    text = bare(text)
    made = re.search(r"^public class (\w+)", text, re.M)
    if made is None or not re.search(r"\[\] *getA\(\)|STATIC_A\b", text):
        return
    line = _line(text, made.start())
    for table in _guarded(made[1], line, lambda: _of_java(text)):
        said = re.search(r"int getOrder\(\)\s*\{\s*return (\d+);", text)
        table.order = int(said[1]) if said else None
        yield table


def _of_java(text: str) -> Table:
    A, b, c = (_java_array(text, key) for key in "ABC")
    weights = vector(b)
    s = len(weights)
    rows = [[], *(vector(x) for x in A)]
    if len(rows) == s - 1:  # the last stage is the new value
        rows.append(weights)
    times = [ZERO, *vector(c)]
    times += [Number(Exact(1))] * (s - len(times))
    table = Table("", 0, A=[_leading(rows, s)], b=[weights], c=[times])
    error = re.search(r"STATIC_E\s*=\s*(\{[^;]*\});", text)
    if error:
        table.errors = [vector(_value(error[1], {}))]
    return table


def _java_array(text: str, key: str) -> Any:
    scope: Scope = {}
    for name, value in re.findall(r"static final double (\w+)\s*=\s*([^;{]+);", text):
        with suppress(Unread):
            scope[name] = _value(value, scope)
    held = re.search(rf"STATIC_{key}\s*=\s*(\{{[^;]*\}});", text)
    if held:
        return _value(held[1], scope)
    body = re.search(rf"\[\] *get{key}\(\)\s*\{{(.*?)\n    \}}", text, re.DOTALL)
    if body is None:
        raise Unread(f"get{key}() is missing")
    code = re.sub(r"\bnew \w+(?:\[\])+\s*(?=\{)", "", body[1])
    code = re.sub(r"\[\s+(\d+)\]", r"[\1]", code)
    code = re.sub(r"[\w.]*\bfraction\((?:\w+(?:\(\))?,\s*)?\s*([^(),]+),\s*([^(),]+)\)",
                  r"(\1 / \2)", code)  # fmt: skip
    code = re.sub(r"\w+(?:\(\))?\.get(One|Zero)\(\)", lambda m: f"({int(m[1] == 'One')})", code)
    code = re.sub(r"\bnew \w+\[0\](?:\[\])?|MathArrays\.buildArray\([\w()]+, 0[^;]*\)", "{}", code)
    for target, value in re.findall(r"([\w\[\]]+)\s*=\s*([^;=]+);", code):
        if "buildArray" not in value and re.fullmatch(r"[A-Za-z]\w*(?:\[\d+\])*", target):
            number = _value(value, scope)
            with suppress(SyntaxError):
                assign(ast.parse(target, mode="eval").body, number, scope)
    returned = re.search(r"return\s+([^;]+);", code)
    if returned is None:
        raise Unread(f"get{key}() returns nothing")
    name = returned[1].strip()
    if name not in scope:
        return _value(name, scope)
    entries = scope[name].entries
    if len(next(iter(entries))) == 1:
        return [entries[k] for k in sorted(entries)]
    rows = sorted({i for i, _ in entries})
    return [[entries[k] for k in sorted(entries) if k[0] == i] for i in rows]
