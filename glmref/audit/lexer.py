"""Tokens of C, Fortran, Go, Java, JavaScript, Julia, MATLAB, Python, Rust and languages like them.

One expression for the numerals of all of them, one for the comments and strings of each.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import NamedTuple

from ..errors import DataError
from ..system.budget import spend

#: Characters of a source that are read.
MOST = 60_000_000

_C = r"/\*.*?(?:\*/|\Z)|//[^\n]*|\\\r?\n"
_QUOTED = "|".join((r'"(?:\\.|[^"\\\n])*"', r"'(?:\\.|[^'\\\n])*'"))
_TRIPLE = (
    r'[rRbBfFuU]{0,2}(?:"""(?:\\.|[^\\])*?(?:"""|\Z)|'
    r"'''(?:\\.|[^\\])*?(?:'''|\Z))"
)


@dataclass(frozen=True)
class Language:
    """What tells the tokens and statements of a language from those of others."""

    name: str
    comments: str
    strings: str = _QUOTED
    #: Whether statements end with a semicolon and blocks are braces; else with the line.
    braces: bool = True
    #: Whether a quotient of whole numbers is a whole number.
    truncates: bool = False
    #: Letters of exponents, suffixes of numerals.
    exponent: str = "eE"
    suffix: str = r"(?:_?[fiu](?:8|16|32|64|128|size)|[fFlLuU]{1,3}|_r|_rt|_[A-Za-z]\w*)(?!\w)"
    #: Whether blanks part the entries of a matrix.
    blanks: bool = False
    #: Index of the first entry.
    base: int = 0
    #: Whether ``a(1, 2)`` may be an entry.
    calls_index: bool = False
    #: Whether statements of blocks in braces may end with the line.
    by_line: bool = False


_STRING, _LETTER = r'"(?:\\.|[^"\\\n])*"', r"'(?:\\.|[^'\\\n])'"
_CHARS = f"{_STRING}|{_LETTER}"  # an apostrophe may be in a numeral
_OF_JULIA = r'"""(?:\\.|[^\\])*?(?:"""|\Z)|"(?:\\.|[^"\\])*"|'
_OF_MATLAB = r"(?<![\w)\]}'.])'(?:[^'\n]|'')*'"
_CONTINUED = r"&[ \t]*(?:![^\n]*)?\n(?:[ \t]*(?:![^\n]*)?\n)*[ \t]*&?"
LANGUAGES = {
    x.name: x
    for x in (
        Language("c", _C, _CHARS, truncates=True),
        Language("java", _C, truncates=True, suffix=r"[fFdDlL](?!\w)"),
        Language("go", _C, rf"{_QUOTED}|`[^`]*(?:`|\Z)", truncates=True, suffix=r"(?!)",
                 by_line=True),
        Language("rust", _C, _CHARS, truncates=True),
        Language("javascript", _C, rf"{_QUOTED}|`[^`]*(?:`|\Z)", suffix=r"n(?!\w)", by_line=True),
        Language("python", r"#[^\n]*|\\\r?\n", rf"{_TRIPLE}|{_QUOTED}", braces=False,
                 suffix=r"(?!)"),
        Language("julia", r"#=.*?(?:=#|\Z)|#[^\n]*",
                 _OF_JULIA + _LETTER,
                 braces=False, exponent="eEf", suffix=r"(?!)", blanks=True, base=1),
        Language("fortran", rf"![^\n]*|{_CONTINUED}", braces=False,
                 truncates=True, exponent="eEdDqQ", suffix=r"_\w+", base=1, calls_index=True),
        Language("matlab", r"%\{.*?(?:%\}|\Z)|%[^\n]*|\.\.\.[^\n]*\n",
                 rf'"(?:[^"\n])*"|{_OF_MATLAB}', braces=False,
                 exponent="eEdD", suffix=r"(?!)", blanks=True, base=1, calls_index=True),
    )
}  # fmt: skip
#: Languages that are read as another one, whose statements and lists they have.
LANGUAGES |= {
    "csharp": replace(LANGUAGES["java"], suffix=r"[fFdDmMlLuU]{1,2}(?!\w)",
                      comments=rf"{_C}|^[ \t]*#(?:region|endregion|pragma|nullable)[^\n]*"),
    "kotlin": replace(LANGUAGES["javascript"], truncates=True, suffix=r"[fFdDL](?!\w)"),
    "swift": replace(LANGUAGES["javascript"], suffix=r"(?!)"),
    "toml": replace(LANGUAGES["javascript"], comments=r"#[^\n]*", suffix=r"(?!)"),
    "r": replace(LANGUAGES["javascript"], comments=r"#[^\n]*", suffix=r"L(?!\w)", base=1),
}  # fmt: skip
#: Language by the ending of a file name.
ENDINGS = {
    **dict.fromkeys(
        ".c .h .cc .hh .cpp .hpp .cxx .hxx .C .H .inl .ipp .tpp .def .cu .cuh .inc .icc".split(),
        "c",
    ),
    **dict.fromkeys(".f .for .f90 .f95 .f03 .f08 .F .F90 .F95 .fpp".split(), "fortran"),
    **dict.fromkeys(".js .ts .mjs .cjs".split(), "javascript"),
    **dict.fromkeys(".py .pyx .pxd".split(), "python"),
    ".java": "java", ".go": "go", ".rs": "rust", ".jl": "julia", ".m": "matlab", ".cs": "csharp",
    ".kt": "kotlin", ".kts": "kotlin", ".scala": "kotlin",
    ".swift": "swift", ".r": "r", ".R": "r",
    ".json": "javascript", ".ipynb": "python", ".toml": "toml", ".yaml": "toml", ".yml": "toml",
}  # fmt: skip
#: Endings of files with rows of numbers, which hold tables only where their names say so.
ROWS = frozenset((".csv", ".dat", ".txt"))


class Token(NamedTuple):
    """A token, where it begins and ends, and whether a blank stands before it."""

    kind: str  #: ``"number"``, ``"name"``, ``"string"``, ``"mark"``, ``"line"`` (an end of line).
    text: str
    line: int
    start: int
    end: int
    spaced: bool


class Remark(NamedTuple):
    """A comment or string of documentation: its text and the lines it takes."""

    text: str
    line: int
    last: int


@cache
def _tokens_of(language: Language) -> re.Pattern[str]:
    numeral = (
        r"(?:0[xXbB]\w+|(?:\d(?:\d|_(?=\d))*(?:'\d{1,3})*(?:\.(?![.\w])|\.(?=\d)|\.(?=[eEdDqQ][-+]?\d)"
        r"|\.(?=[fFlLdD]\b|_[A-Za-z]))?(?:[\d]|_(?=\d))*|\.\d(?:\d|_(?=\d))*)"
        rf"(?:[{language.exponent}][-+]?\d+)?)"
    )
    name = r"[^\W\d][\w\u0300-\u036f]*"
    marks = (
        r"===|!==|<<=|>>=|\*\*=|//=|\.\.\.|\.\.=|==|!=|<=|>=|=>|->|::|:=|\+=|-=|\*=|/=|\^=|//|\*\*"
        r"|\.\*|\./|\.\^|\.\+|\.-|&&|\|\||<<|>>|\(/(?!/)|/\)|\.\.|[^\s\w]|_"
    )
    if language.name != "fortran":
        marks = marks.replace(r"|\(/(?!/)|/\)", "")
    if language.name == "c":  # int division and comments are distinguished
        marks = marks.replace(r"|//=", "")
    return re.compile(
        rf"[^\S\n]*(?:(?P<remark>{language.comments})|(?P<line>\n)"
        rf"|(?P<string>{language.strings})"
        rf"|(?P<number>(?<![\w.]){numeral})(?:{language.suffix})?"
        rf"|(?P<name>{name})|(?P<mark>{marks}))",
        re.DOTALL,
    )


def language_of(path: Path) -> Language | None:
    """Return the language of a file by its ending, ``None`` where it is not one of these."""
    name = ENDINGS.get(path.suffix) or ("python" if path.suffix in ROWS else None)
    return LANGUAGES[name] if name else None


def _fixed_form(text: str) -> str:
    """Turn Fortran 77 into free form: comments by the first column, the sixth continues a line.

    Statements end at column 72, before numbers of lines through 80, where no line has more.
    """
    rows: list[str] = []
    given = text.split("\n")
    code = (x.partition("!")[0].rstrip() for x in given if x[:1] not in "cC*dD!#")
    last = 72 if max(map(len, code), default=0) <= 80 else None
    for row in given:
        if row[:1] in "cC*dD" and row:
            rows.append("!" + row[1:])
        elif len(row) > 5 and row[5] not in " 0\t" and not row[:5].strip():
            at = next((k for k in range(len(rows) - 1, -1, -1)
                       if rows[k].strip() and rows[k].lstrip()[0] != "!"), None)  # fmt: skip
            if at is not None:
                rows[at] = rows[at].partition("!")[0].rstrip() + " &"
            rows.append(" " * 6 + row[6:last])
        else:
            rows.append(row[:last])
    return "\n".join(rows)


#: Digits of names that are raised or lowered.
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹₀₁₂₃₄₅₆₇₈₉", "0123456789" * 2)
#: A statement in the first five columns, which no fixed form has.
_FREE = re.compile(r"(?m)^(?![cCdD]) {0,4}[A-Za-z]")


@lru_cache(maxsize=1)
def tokens(
    text: str, language: Language, *, fixed: bool = False
) -> tuple[Sequence[Token], Sequence[Remark]]:
    """Split a source into tokens and remarks; the last one is kept, as several readers ask for it.

    Raises
    ------
    DataError
        Where the text is larger than :data:`MOST`.
    """
    if len(text) > MOST:
        raise DataError(f"the file has {len(text)} characters; at most {MOST} are read")
    if fixed and not _FREE.search(text):
        text = _fixed_form(text)
    if language.name == "fortran":  # lines of the preprocessor, with marks that are no Fortran
        text = re.sub(r"(?m)^#", "!", text)
    if language is LANGUAGES["r"]:
        text = text.replace("<-", " =")
    found: list[Token] = []
    remarks: list[Remark] = []
    line, spaced = 1, False
    token = partial(tuple.__new__, Token)  # half of the time of Token(..)
    for m in _tokens_of(language).finditer(text):
        kind = m.lastgroup or ""
        said, start = m[kind], m.start(kind)
        spaced = spaced or start > m.start()
        if kind == "remark":
            last = line + said.count("\n")
            if said[0] != "\\" and not said.startswith(("&", "...")):
                remarks.append(Remark(said, line, last))
            line, spaced = last, True
            continue
        if kind == "name" and not said.isascii():  # of γ² the digit
            said = said.translate(_RAISED)
        found.append(token((kind, said, line, start, m.end(), spaced)))
        spaced = False
        if kind == "line":
            line += 1
        elif kind == "string":
            last = line + said.count("\n")
            if last > line or said.startswith(('"""', "'''")):
                remarks.append(Remark(said, line, last))
            line = last
        if not len(found) % 1000:
            spend()
    return found, remarks


#: Endings of Fortran in fixed form.
FIXED = frozenset((".f", ".for", ".F"))
