"""Statements of C sources, as Python statements with their lines."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from .values import Scope, Unread, evaluate

#: One that is not closed goes to the end: else the search for its end would be quadratic.
_COMMENTS = {
    # a text may hold the address of a page
    "c": r'/\*.*?(?:\*/|\Z)|//[^\n]*|"(?:\\.|[^"\\\n]){0,1000}+"',
    "julia": r'#=.*?(?:=#|\Z)|"""(?s:.*?)(?:"""|\Z)|#[^\n]*',
}
#: A number with a point or an exponent, in any of the languages.
_FLOAT = re.compile(
    r"(?<![\w.\"'])((?:\d+\.\d*|\.\d+|\d+(?=[eEdD][-+]?\d))(?:[eEdD][-+]?\d+)?)(?:_\w+|[fFlLqQ](?!\w))?"
    r"(?![\w\"'.])"
)


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


def quoted(text: str) -> str:
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


def c_statements(text: str) -> Iterator[Statement]:
    """Yield the statements of C."""
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
    return [rewritten(f"{kind[0]}{x}") for x in split(text[kind.end() :], ",")]


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
    return quoted(text)


def evaluated(text: str, scope: Scope) -> Any:
    """Return the value of an expression of C.

    Raises
    ------
    Unread
        For one that is not understood.
    """
    try:
        node = ast.parse(rewritten(" ".join(text.split())).strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise Unread(f"{text[:40]!r} is not understood") from None
    return evaluate(node, scope)


def split(text: str, marks: str) -> list[str]:
    """Split at marks outside of brackets; empty parts are left out."""
    parts, depth, start = [], 0, 0
    for k, x in enumerate(text):
        depth += (x in "([{") - (x in ")]}")
        if x in marks and depth == 0:
            parts.append(text[start:k])
            start = k + 1
    return [x.strip() for x in (*parts, text[start:]) if x.strip()]
