"""Statements of C, Julia and Fortran sources, as Python statements with their lines."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass

from ..errors import DataError

#: One that is not closed goes to the end: else the search for its end would be quadratic.
_COMMENTS = {
    # a text may hold the address of a page
    "c": r'/\*.*?(?:\*/|\Z)|//[^\n]*|"(?:\\.|[^"\\\n]){0,1000}+"',
    "julia": r'#=.*?(?:=#|\Z)|"""(?s:.*?)(?:"""|\Z)|#[^\n]*',
    "fortran": r"![^\n]*",
}
#: A number with a point or an exponent, in any of the languages.
_FLOAT = re.compile(
    r"(?<![\w.\"'])((?:\d+\.\d*|\.\d+|\d+(?=[eEdD][-+]?\d))(?:[eEdD][-+]?\d+)?)(?:_\w+|[fFlLqQ](?!\w))?"
    r"(?![\w\"'.])"
)
_MOST = 60_000_000  # characters of a source


@dataclass(frozen=True)
class Statement:
    """One statement."""

    text: str  #: As Python, where it could be rewritten; of a header the words before its block.
    line: int  #: Where it begins.
    #: ``"do"``, ``"open"`` and ``"close"`` of a block with braces or ``function .. end``.
    kind: str = "do"

    def parsed(self) -> ast.stmt | None:
        """Return the statement, or ``None`` where it is no Python."""
        try:
            tree = ast.parse(self.text)
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            return None
        return tree.body[0] if len(tree.body) == 1 else None


def statements(text: str, language: str) -> Iterator[Statement]:
    """Split a source into statements; comments are left out, lines are kept."""
    if len(text) > _MOST:
        raise DataError(f"the file has {len(text)} characters; at most {_MOST} are read")
    text = bare(text, language)
    if language == "fortran":
        text = re.sub(r"&[ \t]*\n[ \t]*&?", lambda m: " \n", text)  # joined below
        yield from _fortran(text)
    elif language == "c":
        yield from _c(text)
    else:
        yield from _julia(text)


def bare(text: str, language: str = "c") -> str:
    """Return the text with blanks for its comments, its lines kept."""
    return re.sub(_COMMENTS[language], _blanked, text, flags=re.DOTALL)


def _blanked(m: re.Match[str]) -> str:
    """Return a comment as blanks; a long string as an empty one, so that an assignment of it ends.

    Other strings stay.
    """
    if m[0].startswith('"') and not m[0].startswith('"""'):
        return m[0]
    blank = re.sub(r"[^\n]", " ", m[0])
    return '""' + blank[2:] if m[0].startswith('"""') else blank


def _quoted(text: str) -> str:
    """Return numbers with a point as strings, so that no digit is lost."""
    text = re.sub(r"(?<!\w)\d[\d_]*\.?[\d_]*", lambda m: m[0].replace("_", ""), text)
    return _FLOAT.sub(lambda m: "'" + re.sub("[dD]", "e", m[1]) + "'", text)


# --- C and C++ ------------------------------------------------------------------------------------

_CASTS = re.compile(
    r"\(\s*(?:const\s+)?(?:PetscReal|sunrealtype|realtype|double|float|long double)\s*\)"
)
_DECLARED = re.compile(
    r"^(?:(?:static|const|constexpr|inline|auto|double|float|long|int|PetscReal|PetscInt|PetscScalar"
    r"|sunrealtype|realtype|modelica_real|ARKodeButcherTable|std::array<[^>]*>|size_t|unsigned"
    r"|static_assert|Value|value_type|T|Real|RT)\b[\s*&]*)+"
)


def _c(text: str) -> Iterator[Statement]:
    start, depth, inside, quote = 0, 0, 0, ""
    line = 1
    first = 1
    head = 0  # where the statement begins
    blank = True  # whether nothing of a statement has been seen; its text is not looked at again
    k = 0
    while k < len(text):
        x = text[k]
        if quote:
            if x == "\\":
                k += 1
            elif x == quote:
                quote = ""
        elif x in "\"'":
            quote = x
        elif x == "(":
            depth += 1
        elif x == ")":
            depth = max(0, depth - 1)
        elif x == "{":
            before = "" if inside else text[start:k].rstrip()
            if inside or (
                before.endswith(("=", "(", ",", "]", "return")) and "ARK_BUTCHER" not in before
            ):
                inside += 1
            else:
                yield Statement(" ".join(before.split()), first, "open")
                start, depth = k + 1, 0
        elif x == "}":
            if inside:
                inside -= 1
            else:
                yield Statement("", line, "close")
                start, depth = k + 1, 0
        elif x == "\n":
            line += 1
            if not blank and text[head] == "#":
                row = text[head:k].rstrip()
                made = re.fullmatch(r"#\s*define\s+(\w+)\s+(\(?.*[\d(].*)", row)
                if made:
                    yield Statement(rewritten(f"{made[1]} = {made[2]}"), line - 1)
                start = k + 1
        if x == ";" and not quote and not inside and depth == 0:
            yield from (Statement(x, first) for x in _declarations(text[start:k]))
            start = k + 1
        if blank and not x.isspace():
            head = k
        blank = k < start or (blank and x.isspace())
        if blank:
            first = line
        k += 1


def _declarations(text: str) -> list[str]:
    """Write ``double a[2] = {..}, b[2] = {..}`` as two statements, others as they are."""
    text = " ".join(text.split())
    kind = _DECLARED.match(text)
    if kind is None:
        return [rewritten(text)]
    return [rewritten(f"{kind[0]}{x}") for x in _split(text[kind.end() :], ",")]


def rewritten(text: str) -> str:
    """Return a statement or expression of C as Python."""
    text = " ".join(text.split()).replace("->", ".").replace("::", ".")
    text = re.sub(r"(?<!&)&(\w+)(?:\[\w+\])*", r"\1", _CASTS.sub("", text))
    head, equal, value = text.partition("=")
    if equal and not value.startswith("=") and head[-1:] not in "<>!+-*/":
        name = _DECLARED.sub("", head.strip()).strip()
        if re.fullmatch(r"\w+(?:\s*\[[^\]]*\])+", name) and value.lstrip().startswith("{"):
            name = name.partition("[")[0].strip()
        name = re.sub(r"^([\w.]+)\s*\(([\s\w,+-]*)\)$", r"\1[\2]", name)
        text = f"{name} = {value.strip()}"
    text = text.replace("{", "[").replace("}", "]")
    return _quoted(text)


# --- Fortran --------------------------------------------------------------------------------------


def _fortran(text: str) -> Iterator[Statement]:
    for number, row in enumerate(text.split("\n"), 1):
        row = row.strip()
        row = re.sub(r"^(\w+)\s*\(([\s\w,]*)\)\s*=(?!=)", r"\1[\2] =", row.rstrip(";"))
        opened = re.match(r"(?:module procedure|subroutine|function)\s+(\w+)", row, re.IGNORECASE)
        if opened:
            yield Statement(f"procedure {opened[1]}", number, "open")
        elif re.match(r"end (?:procedure|subroutine|function)", row, re.IGNORECASE):
            yield Statement("", number, "close")
        elif row:
            declared = re.match(r"real\s*\(\w+\)\s*,\s*parameter\s*::\s*(.*)$", row, re.IGNORECASE)
            body = declared[1] if declared else row
            yield Statement(_quoted(re.sub(r"(?<=\d)_(?:wp|dp)\b", "", body)), number)


# --- Julia ----------------------------------------------------------------------------------------

_TYPED = re.compile(r"\b(?:T2?|BigFloat|Float64|Float32|SA|FT|RT|Rational\{\w+\}|Rational)\[")


def _julia(text: str) -> Iterator[Statement]:
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
    return _quoted(_brackets(text))


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


def _split(text: str, marks: str) -> list[str]:
    parts, depth, start = [], 0, 0
    for k, x in enumerate(text):
        depth += (x in "([{") - (x in ")]}")
        if x in marks and depth == 0:
            parts.append(text[start:k])
            start = k + 1
    return [x.strip() for x in (*parts, text[start:]) if x.strip()]


def _matrix(inner: str) -> str:
    if re.search(r"\bfor \w+ in span\(", inner):  # a comprehension
        return "[" + _brackets(inner) + "]"
    if len(_split(inner, ",")) > 1 or inner.rstrip().endswith(","):
        return "[" + ", ".join(_brackets(x) for x in _split(inner, ",;")) + "]"
    rows = [_blanks(row) for row in _split(inner, ";\n")]
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
