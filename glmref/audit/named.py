"""Tables of C++ in which each number has a name, such as ``a21``."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from ..exact import Exact
from .code import bare, evaluated
from .table import ZERO, Table
from .values import Number, Scope, Unread


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


_NAMED = re.compile(
    r"(?<![\w.\]])(?:\w+::)?([a-z]+_?)(\d+(?:_\d+)?|)\s*=(?!=)\s*([^;,=]+?)\s*(?=[;,])"
)


#: A number that gets a value, whether the statement ends or not.
_ASSIGNED = re.compile(r"(?<![\w.\]])(?:\w+::)?([abcde]|dc)(\d+(?:_\d+)?)\s*=(?!=)")


def constants(text: str, declared: Mapping[str, int] | None = None) -> Iterator[Table]:
    """Yield the table of a C++ file whose coefficients have a name each.

    Two conventions are known: ``a21, b1, c2`` with ``d1`` (second weights) or ``e1`` (error), and
    ``b21, c1, a2`` with ``dc1`` (error), where without ``c1`` the last row holds the weights.
    """
    text = bare(text)
    first = re.search(r"(?<![\w.\]])(?:\w+::)?[ab]21\s*=", text)
    if first is None:
        return
    made = re.search(r"(\w+)::(?:a21\b|\1\s*\()", text) or re.search(r"^class\s+(\w+)", text, re.M)
    name = made[1] if made else "constants"
    start, line = first.start(), _line(text, first.start())
    code = text[: text.find("\n}", start) % (len(text) + 1)]  # what follows is another function
    try:
        table = _of_constants(code)
    except Unread as error:
        table = Table("", 0, unread=str(error))
    table.name, table.line, table.order = name, line, (declared or {}).get(name)
    yield table


def _of_constants(text: str) -> Table:
    scope: Scope = {}
    found: dict[str, dict[str, Number]] = {}
    for letters, digits, value in _NAMED.findall(text):
        key = letters + digits
        if key in scope or not (digits or letters in ("gam", "gamma")):
            continue
        try:
            number = evaluated(re.sub(r"\b\w+::(?=[a-z]+\d)", "", value), scope)
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
    entries = {_pair(k): x for k, x in found.get(letter, {}).items() if len(k) > 1}
    if not entries:
        raise Unread("no entry of A has a value that is read")
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
    """Return the row and column: 21, 101, 1110 or 11_10."""
    if "_" in digits:
        i, _, j = digits.partition("_")
    else:
        cut = 1 if len(digits) == 2 else 2
        i, j = digits[:cut], digits[cut:]
    if not j or int(j) >= int(i):
        raise Unread(f"the entry {digits} of A is not below the diagonal")
    return int(i), int(j)
