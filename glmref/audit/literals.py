"""The one number of a source that, changed, gives a table the order that is declared.

A number may stand in several entries, as a constant with a name or in the arithmetic of a step, so
that no single entry explains the defect. The source is read again with another number in its place,
and that it has the order is seen in the source's own form.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import combinations
from time import process_time

from ..errors import GlmrefError
from ..prove.schemes import reach
from ..prove.wrong_entry import Trial
from .lexer import Language, Token, tokens
from .table import STEP, Table
from .values import Unread

#: Seconds of processor time for one table, and for one reading of its source.
_SECONDS, _ONE = 12.0, 0.25
#: Steps of the secant method, and how near a whole number must be.
_STEPS, _WHOLE = 12, 1e-6
#: Numbers with more characters may be exchanged with others of their line.
_DIGITS = 6
#: A decimal, and its power of ten, as that of ``1.5d0``.
_PLAIN = re.compile(r"(\d*\.?\d+|\d+\.)((?:[eEdD][-+]?\d{1,3})?)")
#: What stands before a name whose sign may be wrong.
_BEFORE = frozenset("= ( [ { ,".split())

#: Residuals of conditions by their trees, and how large those of a right table are.
Residuals = tuple[dict[str, float], float]


def mended(
    text: str, language: Language, table: Table, again: Callable[..., Table | None],
    beyond: Mapping[str, str],
) -> list[dict[str, str | int]]:  # fmt: skip
    """Return the numbers with another value of as many digits that give the declared order.

    Parameters
    ----------
    text : str
        The source.
    language : Language
    table : Table
        With a declared order, which it has not.
    again : callable
        Reads the same table in another text, with other numbers of names of other files.
    beyond : Mapping of str to str
        These numbers, with the places where they stand.

    Returns
    -------
    list of dict
        At most three, as the corrections of :func:`~.table_verdicts.judge`; those that have the
        digits of the source in another order alone, if there are any.
    """
    begin = process_time()
    start = _residuals(again(text))
    if start is None or process_time() > begin + _ONE:
        return []
    first, last, block = table.line, max(table.last, table.line), table.block
    if block is not None and block.parent is not None:
        first, last = min(first, block.line), max(last, block.last if table.source == STEP else 0)
    every = tokens(text, language)[0]
    places = {x.place[0] for M in (*table.A, table.b) for row in M for x in row if x.place}
    inside = [k for k, x in enumerate(every) if first <= x.line <= last or x.line in places]
    long = [x for x in (every[k] for k in inside) if x.kind == "number" and len(x.text) > _DIGITS]
    for x, y in combinations(long, 2):
        turned = f"{y.text}{text[x.end : y.start]}{x.text}"
        if x.line == y.line and x.text != y.text and process_time() < begin + _SECONDS and _good(
                _residuals(again(text[: x.start] + turned + text[y.end :]))):  # fmt: skip
            return [{"entry": f"the numbers {x.text} and {y.text}", "is": f"{x.text}, {y.text}",
                     "should be": f"{y.text}, {x.text}", "line": x.line, "text": ""}]  # fmt: skip
    for turned, one, two in _exchanged(text, first, last):
        if process_time() > begin + _SECONDS / 4:
            break
        if _good(_residuals(again(turned))):
            said = [x["is"] for x in (one, two)]
            return [{**one, "should be": said[1]}, {**two, "should be": said[0]}]
    found: list[dict[str, str | int]] = []
    for k in inside:
        x = every[k]
        if process_time() > begin + _SECONDS:
            break
        new = next(
            (
                said
                for said in _values(every, k, start, lambda said, x=x: _residuals(
                    again(text[: x.start] + said + text[x.start + len(x.text) :])))
            ),
            "",
        )  # fmt: skip
        if new:
            found.append({"entry": f"the number {x.text}", "is": x.text, "should be": new,
                          "line": x.line, "text": x.text})  # fmt: skip
    for name in sorted(beyond.keys() & {every[k].text for k in inside}):
        said, _, place = beyond[name].partition("@")
        plain = _PLAIN.fullmatch(said.lstrip("-"))
        if plain is None or process_time() > begin + _SECONDS:
            continue

        def with_value(value: str, name: str = name) -> Residuals | None:
            return _residuals(again(text, {**beyond, name: value.strip("()").replace("--", "")}))

        sign = "-" if said.startswith("-") else ""
        new = _root(
            plain[1], plain[2], start[0], lambda x, sign=sign: with_value(f"{sign}{x.strip('()')}")
        )
        if new and new != plain[0] and _good(with_value(f"{sign}{new}")):
            path, _, line = place.rpartition(":")
            found.append({"entry": f"the number {plain[0]} of {name} ({path})", "is": plain[0],
                          "should be": new, "line": int(line), "text": said})  # fmt: skip
    alike = [x for x in found if sorted(str(x["is"])) == sorted(str(x["should be"]).strip("-"))]
    return (alike or found)[:3]


#: ``b2 = 3 // 4`` and what ends it.
_SET = re.compile(r"(.*?([\w.\]\[(), ]+?)\s*=\s*)([^=,;]*\d[^=,;]*?)(\s*[;,]?\s*)$")
#: An entry of a list on a line of its own.
_ALONE = re.compile(r"(\s*()(?:[A-Za-z]\w*\[)?)([-+\w./* ()]*\d[-+\w./* ()]*?)(\s*[,\]]*\s*)$")
#: Lines of which values of names may be exchanged.
_LINES = 24


def _exchanged(
    text: str, first: int, last: int
) -> Iterator[tuple[str, dict[str, str | int], dict[str, str | int]]]:
    """Yield the text with the values of two names exchanged, and both as entries with lines."""
    rows = text.split("\n")
    lines = range(first - 1, min(last, len(rows)))
    given = [(k, m) for k in lines if (m := _SET.match(rows[k]) or _ALONE.match(rows[k]))]
    pairs = sorted(combinations(given, 2), key=lambda x: x[1][0] - x[0][0])  # neighbours first
    for (j, x), (k, y) in pairs if len(given) <= _LINES else ():
        if x[3] == y[3] or any(z[3].count(p) != z[3].count(q) for z in (x, y)
                               for p, q in ("()", "[]", "{}")):  # fmt: skip
            continue
        turned = list(rows)
        turned[j], turned[k] = x[1] + y[3] + x[4], y[1] + x[3] + y[4]
        one, two = (
            {"entry": m[2].strip() or f"the number {said}", "is": said, "should be": "",
             "line": n + 1, "text": said}
            for n, m in ((j, x), (k, y)) if (said := m[3].strip())
        )  # fmt: skip
        yield "\n".join(turned), one, two


def _residuals(table: Table | None) -> Residuals | None:
    """Return the residuals of the conditions through the declared order."""
    if table is None or table.unread or table.order is None:
        return None
    with suppress(GlmrefError, Unread, ArithmeticError, LookupError, ValueError):
        method = Trial(table)
        levels = reach(method.scheme(), table.order).residuals
        return {t: complex(x).real for level in levels for t, x in level.items()}, method.coarse
    return None


def _good(found: Residuals | None) -> bool:
    return found is not None and all(abs(x) <= found[1] for x in found[0].values())


def _values(
    row: Sequence[Token], k: int, start: Residuals, residuals: Callable[[str], Residuals | None]
) -> Iterator[str]:
    """Yield what a token should be: the other sign, the root of a condition, a small number."""
    x = row[k]
    if x.kind == "name":
        if row[k + 1 : k + 2] and row[k + 1].text in (".", "::", "("):
            return
        if k and row[k - 1].text in _BEFORE and _good(residuals(f"(-{x.text})")):
            yield f"-{x.text}"
        return
    plain = _PLAIN.fullmatch(x.text) if x.kind == "number" else None
    if plain is None or float(plain[1]) == 0:
        return
    if _good(residuals(f"(-{x.text})")):
        yield f"-{x.text}"
    new = _root(plain[1], plain[2], start[0], residuals)
    if new and new != x.text and _good(residuals(f"({new})")):
        yield new
    if not plain[2] and float(x.text) % 1 == 0 and float(x.text) < 10:
        for n in range(1, 10):
            new = f"{n}{x.text.partition('.')[1]}{x.text.partition('.')[2]}"
            if new != x.text and _good(residuals(new)):
                yield new


def _root(
    said: str, power: str, start: dict[str, float], residuals: Callable[[str], Residuals | None]
) -> str:  # fmt: skip
    """Return the value, to the digits of a number, at which its worst condition holds."""
    old, places = float(said), min(15, len(said.partition(".")[2]))
    tree = max(start, key=lambda t: abs(start[t]), default="")
    before, last, value = old, start.get(tree, 0.0), old + max(abs(old), 0.5) / 64
    for _ in range(_STEPS):
        found = residuals(
            f"({value!r}{power})" if "e" not in repr(value) else f"({value:.25f}{power})"
        )
        now = None if found is None else found[0].get(tree)
        if now is None or now == last or not abs(value) < 1e6 * (1 + abs(old)):
            return ""
        before, last, value = value, now, value - now * (value - before) / (now - last)
        if abs(value - before) < 1e-15 * (1 + abs(value)):
            break
    if places == 0 and abs(value - round(value)) > _WHOLE:
        return ""
    return f"{value:.{places}f}" + ("." if said.endswith(".") else "") + power
