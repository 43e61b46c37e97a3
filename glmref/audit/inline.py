"""Steps whose numbers stand in their arithmetic, as ``y + h*(k1 + 2*k2 + 2*k3 + k4)/6``.

Such a method has no table that could be read; that it is there is said.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from .lexer import Token

_NUMBERED = re.compile(r"([^\W\d]+)_?(\d{1,2})(?:_?[a-z]{1,3})?", re.ASCII | re.IGNORECASE)
_GOES_ON = frozenset("+ - * / ** ^ , ( [ { & = .* ./ .+ .-".split())
#: Names of slopes, without their numbers.
_SLOPE = re.compile(r"k|f|slope|stage|d[a-z]*dt", re.IGNORECASE)
#: Other names beside the slopes in a sum: the state, the step, an index, a result.
_MOST_NAMES = 5


def inline_sums(tokens: Sequence[Token]) -> Iterator[int]:
    """Yield the lines of sums of slopes in which a number is a factor of one or of all of them.

    A slope is a name with a number, as k1 or k[0], that a call gives or takes.
    """
    slopes = _slopes(tokens)
    if len(slopes) < 2:
        return
    for row in _right_sides(tokens):
        used = {name for k in range(len(row)) if (name := _name_at(row, k)) in slopes}
        stems = sorted({_stem(x) for x in used})
        sums = any(x.text in ("+", "-", ".+", ".-") for x in row)
        if len(used) < 2 or len(stems) > 1 or not sums or not _SLOPE.fullmatch(stems[0].strip("_")):
            continue
        names = {x.text for x in row if x.kind == "name"} - {x.partition("[")[0] for x in used}
        if len(names) <= _MOST_NAMES and any(_is_factor(row, k) for k in range(len(row))):
            yield row[0].line


#: Products of the step and a quotient: ``-845 * h / 4104.``, ``17./36. * stepsize``.
_MULTIPLE = re.compile(
    r"(?<!\d)(\d+)\.?0*\s*\*\s*(?:h|dt|\w*step\w*)\s*/\s*(\d+)"
    r"|(?<!\d)(\d+)\.?0*\s*/\s*(\d+)\.?0*\s*\*\s*(?:h|dt|\w*step\w*)\b"
)


def multiples(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of products of the step and a quotient, each with its quotient."""
    for found in _MULTIPLE.finditer(text):
        yield text.count("\n", 0, found.start()) + 1, "/".join(x for x in found.groups() if x)


def _stem(name: str) -> str:
    found = _NUMBERED.fullmatch(name.partition("[")[0])
    return found[1] if found and "[" not in name else name.partition("[")[0]


def _name_at(row: Sequence[Token], k: int) -> str:
    """Return the numbered name that begins at a token, as ``k1`` or ``k[0]``, or ``""``."""
    if row[k].kind != "name":
        return ""
    if _NUMBERED.fullmatch(row[k].text):
        return row[k].text
    after = row[k + 1 : k + 4]
    if (
        len(after) == 3
        and after[0].text == "["
        and after[1].text.isdigit()
        and after[2].text == "]"
    ):
        return f"{row[k].text}[{after[1].text}]"
    return ""


def _slopes(tokens: Sequence[Token]) -> set[str]:
    found: set[str] = set()
    for k in range(len(tokens)):
        name = _name_at(tokens, k)
        if not name:
            continue
        end = k + (4 if name.endswith("]") else 1)
        before = tokens[k - 1].text if k else ""
        after = tokens[end].text if end < len(tokens) else ""
        given = before in ("(", ",", "&", "mut") and after in (",", ")")
        called = after == "=" and any(
            x.kind == "name" and y.text in ("(", ".")
            for x, y in zip(tokens[end + 1 : end + 9], tokens[end + 2 : end + 10], strict=False)
        )
        if given or called:
            found.add(name)
    return found


def ends(tokens: Sequence[Token], k: int) -> bool:
    """Return whether a statement outside of brackets ends with a line."""
    return k == 0 or tokens[k - 1].text not in _GOES_ON


def _right_sides(tokens: Sequence[Token]) -> Iterator[Sequence[Token]]:
    """Yield what stands after the sign of an assignment or ``return``, to the end of it."""
    start, depth = -1, 0
    for k, x in enumerate(tokens):
        if start < 0:
            begins = x.text == "return" or (x.kind == "mark" and x.text in ("=", "+=", ".=", ".+="))
            start, depth = (k + 1, 0) if begins else (start, depth)
            continue
        if x.kind == "mark":
            depth += (x.text in ("(", "[", "{")) - (x.text in (")", "]", "}"))
        if depth < 0 or x.text == ";" or (x.kind == "line" and depth <= 0 and ends(tokens, k)):
            row = [y for y in tokens[start:k] if y.kind != "line"]
            if row:
                yield row
            start = -1
    if start >= 0:
        yield [y for y in tokens[start:] if y.kind != "line"]


def _is_factor(row: Sequence[Token], k: int) -> bool:
    """Return whether a token is a number that multiplies or divides."""
    if row[k].kind != "number":
        return False
    before, after = row[max(0, k - 1) : k], row[k + 1 : k + 2]
    return any(x.text in ("*", "/", ".*", "./") for x in (*before, *after))
