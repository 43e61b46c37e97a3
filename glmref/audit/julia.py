"""The parser of Julia sources: their statements as Python statements with their lines."""

from __future__ import annotations

import re
from collections.abc import Iterator

from .code import Statement, quoted, split

_TYPED = re.compile(r"\b(?:T2?|BigFloat|Float64|Float32|SA|FT|RT|Rational\{\w+\}|Rational)\[")


def julia_statements(text: str) -> Iterator[Statement]:
    """Yield the statements of Julia."""
    start, depth, line, first, k = 0, 0, 1, 1, 0
    quote, blank, last = False, True, ""
    while k <= len(text):
        x = text[k] if k < len(text) else "\n"
        last = last if x.isspace() or x == ";" else x
        if quote:
            quote = x not in '"\n'
        elif x == '"':
            quote = True
        elif x in "([{":
            depth += 1
        elif x in ")]}":
            depth = max(0, depth - 1)
        goes_on = x == "\n" and last in tuple("-+*/=,(")
        if x in "\n;" and depth == 0 and not goes_on:
            row = text[start:k].strip()
            if row:
                yield from _julia_row(row, first)
            start, last = k + 1, ""
        if x == "\n":
            line += 1
        blank = k < start or (blank and x.isspace())
        if blank:
            first = line
        k += 1


def _julia_row(row: str, line: int) -> Iterator[Statement]:
    opened = re.match(r"(?:@\w+ )?function\s+([\w.∞γ]+)", row)
    if opened:
        said = (
            re.search(r"::\s*(\w+)", row)
            if opened[1] in ("RKTableau", "IMEXTableau", "ExplicitTableau")
            else None
        )
        yield Statement(f"function {said[1] if said else opened[1]}", line, "open")
    elif row == "end":
        yield Statement("", line, "close")
    else:
        short = re.match(r"([\w.]+)\((?:::(\w+))?[^)=]*\)\s*=\s*(.+)$", row, re.DOTALL)
        if short and re.search(r"IMEXTableau|ExplicitTableau", short[3]):
            yield Statement(f"function {short[2] or short[1]}", line, "open")
            yield Statement(_from_julia(short[3]), line)
            yield Statement("", line, "close")
            return
        yield Statement(_from_julia(row), line)


#: ``2c`` and ``2c^3``, which bind more tightly than a quotient before them.
_JUXTAPOSED = re.compile(
    r"(?<![\w.'])(\d++(?:\.\d*+)?+)(?![eE][-+]?\d)([A-Za-z\u0370-\u03ff_][\w\u0370-\u03ff]*(?:\^\d+)?)(?![\w(])"
)
#: ``2f(`` and ``2(``.
_BEFORE_A_CALL = re.compile(r"(?<![\w.'])(\d++(?:\.\d*+)?+)(?=(?:[A-Za-z_]\w*)?\()(?![eE][-+]?\d)")


def _from_julia(text: str) -> str:
    text = re.sub(r"(?<=\d)_(?=\d)", "", text)
    text = re.sub(r"(//|[-+*/])[ \t]*\n\s*", r"\1 ", text)  # the line goes on
    text = re.sub(r"(?<![\d.])big\"\s*([^\"]*)\"", r"\1", text)
    text = re.sub(r"@[A-Za-z_]\w*\s*", " ", text)
    text = re.sub(r"\\(?!\w)", " ", text)
    text = re.sub(r"(?<=[A-Za-z])\{(?:[^{}]|\{[^{}]*\})*\}", "", text)
    text = re.sub(r"√\s*(\d+|\w+|(?=\())", lambda m: f"sqrt({m[1]})" if m[1] else "sqrt", text)
    text = _TYPED.sub("[", text)
    text = _JUXTAPOSED.sub(r"(\1*\2)", text)
    text = _BEFORE_A_CALL.sub(r"\1*", text)
    text = re.sub(r"\s\.([-+*/])(?=\s)", r" \1", text).replace("^", "**")
    text = re.sub(r"\bfor\s+(\w+)\s+in\s+(\w+):([^\]]+)(?=\])", r"for \1 in span(\2, \3)", text)
    text = re.sub(r"^\s*push!\((\w+),\s*(.*)\)\s*$", r"\1 = vcat(\1, [\2])", text)
    text = re.sub(r"\(\s*;", "(", text)
    text = re.sub(r";([^;\[\]()]*)(?=[()])", _keywords, text)
    text = re.sub(r"^(?:local|const|global)\s+", "", text.strip())
    text = re.sub(r"(?<![:\w]):(\w+)", r"'\1'", text) if "[" not in text.partition("=")[0] else text
    return quoted(_brackets(text))


def _keywords(m: re.Match[str]) -> str:
    """Give x its own value where ``; x, y = 1`` stands in a call."""
    words = [x.strip() for x in m[1].split(",") if x.strip()]
    if not words or not all(re.fullmatch(r"\w+(?:\s*=.*)?", x, re.DOTALL) for x in words):
        return m[0]
    if m.string[m.end()] == "(" and "=" not in words[-1]:  # an entry after a semicolon, a call
        return m[0]
    return "".join(f", {x}={x}" if re.fullmatch(r"\w+", x) else f", {x}" for x in words)


def _brackets(text: str) -> str:
    """Return the matrix literals as nested lists; what is an index stays."""
    out: list[str] = []
    k = 0
    while k < len(text):
        x = text[k]
        if x == "[":
            end = _partner(text, k)
            inner = text[k + 1 : end]
            index = bool(re.search(r"[\w)\]]$", "".join(out)))
            if index:
                out.append("[" + _brackets(inner).replace("\n", " ") + "]")
            else:
                out.append(_matrix(inner))
            k = end + 1
            continue
        out.append(" " if x == "\n" else ("," if x == ";" else x))
        k += 1
    return "".join(out)


def _partner(text: str, at: int) -> int:
    depth = 0
    for k in range(at, len(text)):
        depth += (text[k] in "([{") - (text[k] in ")]}")
        if depth == 0:
            return k
    return len(text)


def _matrix(inner: str) -> str:
    if re.search(r"\bfor \w+ in span\(", inner):  # a comprehension
        return "[" + _brackets(inner) + "]"
    if len(split(inner, ",")) > 1 or inner.rstrip().endswith(","):
        return "[" + ", ".join(_brackets(x) for x in split(inner, ",;")) + "]"
    rows = [_blanks(row) for row in split(inner, ";\n")]
    shown = [[_brackets(x) for x in row] for row in rows]
    if all(len(row) == 1 for row in shown):
        return "[" + ", ".join(row[0] for row in shown) + "]"
    if len(shown) == 1:
        return "[" + ", ".join(shown[0]) + "]"
    return "[" + ", ".join("[" + ", ".join(row) + "]" for row in shown) + "]"


def _blanks(row: str) -> list[str]:
    """Split at blanks as Julia does: a sign with a blank only before it begins an entry."""
    parts: list[str] = []
    depth, current, k = 0, "", 0
    while k < len(row):
        x = row[k]
        depth += (x in "([{") - (x in ")]}")
        if x in " \t" and depth == 0:
            rest = row[k:].lstrip()
            operator = re.match(r"(?://|\*\*|[-+*/])", rest)
            sign = operator and operator[0] in "+-" and not rest[1:2].isspace()
            joined = operator and not sign
            if current and not joined and not re.search(r"(?://|[-+*/])$", current):
                parts.append(current)
                current = ""
            k += len(row[k:]) - len(rest)
            continue
        current += x
        k += 1
    return [*parts, current] if current else parts
