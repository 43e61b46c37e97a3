"""Steppers as source files: one template for each language, filled with a method's tableaux.

A template (``templates/stepper.*.in``) is the source file with marks of jinja2: ``@{name}`` is
replaced, and a part between the lines ``@% if WORD %@``, ``@% elif WORD %@``, ``@% else %@`` and
``@% endif %@`` stays where the word holds:

    pair      f and k are given separately      implicit  some stage needs an equation solved
    newton    implicit, and not a pair          started   the method has a starting method
    enhanced  it needs the enhanced start       plain     it starts from the solution
    finish    it has a finishing method         headed    values that are the solution are picked
    renewed   long runs renew the values

How a language writes arguments and calls for a pair and for y' = f(t, y) stands at its head.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from ..exact import Scalar
from ..exact.linalg import Matrix
from ..method import GLM, PartitionedGLM
from .header import Comment, header
from .numbers import lost, rounded, worst
from .scheme import Scheme, Table, scheme_of

_WIDTH = 96


#: What a namespace of C++, a module of Fortran or of Julia cannot be called: keywords, and names
#: that stand in it.
_TAKEN = frozenset((
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char class "
    "compl concept const consteval constexpr constinit continue decltype default delete "
    "do double else enum explicit export extern false float for friend goto if inline int "
    "long mutable namespace new noexcept not not_eq nullptr operator or or_eq private "
    "protected public register requires return short signed sizeof static std struct "
    "switch template this throw true try typedef typeid typename union unsigned using "
    "virtual void volatile while xor xor_eq apply base bool core correct done finish "
    "float64 heads integrate linear main matrix renew solve start start_table step "
    "step_table"
).split())  # fmt: skip
_LONGEST = 60  # Fortran takes 63 letters


def identifier(name: str) -> str:
    """Return a name that every language takes: letters, digits and underscores, a letter first."""
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_").lower()[:_LONGEST] or "method"
    return word if word[0].isalpha() and len(word) > 1 and word not in _TAKEN else f"m_{word}"


#: What a template can ask for.
_WORDS = (
    *("pair", "implicit", "newton", "started", "enhanced", "plain", "finish", "headed", "renewed"),
    *("ark", "sprk"),
)


@cache
def _templates() -> Any:
    """Return the templates of the folder ``templates``."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader("glmref.exchange"), undefined=StrictUndefined,
        block_start_string="@%", block_end_string="%@", trim_blocks=True, lstrip_blocks=True,
        variable_start_string="@{", variable_end_string="}", keep_trailing_newline=True,
    )  # fmt: skip


def filled(template: str, words: Iterable[str], values: Mapping[str, object]) -> str:
    """Fill a template of the folder ``templates``: see the module's docstring."""
    said = dict.fromkeys(_WORDS, False) | dict.fromkeys(words, True)
    return _templates().get_template(template).render({**said, **values})


@dataclass(frozen=True)
class Language:
    """What differs from language to language besides the template."""

    template: str
    comment: Comment  #: How a comment is written.
    #: Source of the constant tables, from the scheme and its rendered numbers.
    tables: Callable[[Scheme, Numbers], str]


@dataclass(frozen=True)
class Numbers:
    """How a coefficient is written."""

    digits: int | None  #: Significant digits, ``None`` for the shortest decimals of doubles.
    suffix: str = ""  #: What a literal of double precision ends with.

    def of(self, x: Scalar) -> str:
        """Return one coefficient."""
        return rounded(x, self.digits) + self.suffix

    def residue(self, x: Scalar) -> str:
        """Return its rounding residual to six digits, which is all that can matter."""
        value = lost(x, rounded(x, self.digits))
        return (repr(float(f"{value:.5e}")) if value else "0.0") + self.suffix

    def matrix(self, rows: Matrix) -> list[list[str]]:
        """Return a matrix."""
        return [[self.of(x) for x in row] for row in rows]

    def residues(self, rows: Matrix) -> list[list[str]]:
        """Return the rounding residual of a matrix."""
        return [[self.residue(x) for x in row] for row in rows]

    def parts(self, table: Table) -> dict[str, list[list[str]]]:
        """Return the arrays of a tableau by their letters, c as one row."""
        return {
            "A": self.matrix(table.A),
            "U": self.matrix(table.U),
            "B": self.matrix(table.B),
            "L": self.residues(table.B),
            "V": self.matrix(table.V),
            "c": self.matrix((table.c,)),
        }


def wrapped(items: Sequence[str], indent: str, end: str = "") -> list[str]:
    """Join items with commas, in lines of at most :data:`_WIDTH` characters."""
    lines, line = [], indent
    for k, item in enumerate(items):
        piece = item + ("," if k + 1 < len(items) else "")
        if len(line) + len(piece) + 1 + len(end) > _WIDTH and line.strip():
            lines.append(line.rstrip() + end)
            line = indent
        line += piece + " "
    return [*lines, line.rstrip()]


def _flat(rows: Sequence[Sequence[str]]) -> list[str]:
    return [x for row in rows for x in row]


#: Arguments of functions and calls; a pair knows no time.
_TIMED = {
    "calls": "f", "solution_given": "y", "time": "double t, ", "now": "t, ", "next": "t + h, ",
    "at_n": "t + n * h, ", "at_end": "t + steps * h, ", "from_to": " from time t to t + h",
    "at": " at time t",
}  # fmt: skip
_PAIR = {**dict.fromkeys(_TIMED, ""), "calls": "dq, dp", "solution_given": "q, p"}


def stepper(method: GLM | PartitionedGLM, language: str, digits: int | None) -> str:
    """Return the source file of the stepper of a real method with a start, in a language.

    Coefficients have so many significant digits; ``None`` stands for the shortest decimals that
    give the nearest doubles.

    Raises
    ------
    UsageError
        For a method that no stepper is written for, see :func:`.scheme.scheme_of`.
    """
    scheme, chosen = scheme_of(method), LANGUAGES[language]
    name = identifier(method.name)
    used = [x for _, t in scheme.tables for m in (t.A, t.U, t.B, t.V) for row in m for x in row]
    remark = f"Coefficients differ from the exact ones by at most {worst(used, digits):.2g}; "
    remark += "the rounding residual of B is added back (L)."
    values = {
        "name": name,
        "header": header(method, language, chosen.comment, remark),
        "tables": chosen.tables(scheme, Numbers(digits)),
        "r": scheme.r,
        "heads": list(scheme.heads),
        "ordinals": ", ".join(str(k + 1) for k in scheme.heads),
        "passes": scheme.passes,
        "renew": scheme.renew,
        **(_PAIR if scheme.pair else _TIMED),
    }
    return filled(chosen.template, _words(scheme), values)


def _words(scheme: Scheme) -> frozenset[str]:
    held = {
        "pair": scheme.pair,
        "implicit": scheme.implicit,
        "newton": scheme.newton,
        scheme.begins: True,
        "finish": scheme.finish is not None,
        "headed": scheme.finish is None or scheme.begins == "enhanced",
        "renewed": scheme.renew > 0,
    }
    return frozenset(word for word, holds in held.items() if holds)


# --- C and C++ -----------------------------------------------------------------------------------


def _braces(kind: str, name: str, items: Sequence[str]) -> list[str]:
    head = f"static const {kind} {name}[] = {{"
    if sum(map(len, items)) + 2 * len(items) + len(head) < _WIDTH:
        return [head + ", ".join(items) + "};"]
    return [head, *wrapped(items, "  ")[:-1], wrapped(items, "  ")[-1] + "};"]


def _c_tables(scheme: Scheme, numbers: Numbers) -> str:
    lines: list[str] = []
    for name, table in scheme.tables:
        for letter, rows in numbers.parts(table).items():
            lines += _braces("double", f"{name}_{letter}", _flat(rows))
        lines += _braces("int", f"{name}_blocks", [str(x) for x in table.blocks])
        if scheme.pair:
            lines += _braces("int", f"{name}_half", [str(x) for x in table.half])
        letters = [f"{name}_{x}" for x in (*(["half"] if scheme.pair else []), "blocks", *"AUBLVc")]
        sizes = [table.s, len(table.V[0]), len(table.V)]
        head = f"static const tableau {name}_table = {{"
        lines += [head, *wrapped([*map(str, sizes), *letters], "  "), "};"]
    if scheme.finish is None or scheme.begins == "enhanced":
        lines += _braces("int", "head", [str(x) for x in scheme.heads])
    if scheme.begins == "enhanced":
        lines += _braces("double", "zero_V", _flat(numbers.matrix(scheme.zero)))
        lines += _braces("double", "correct_K", _flat(numbers.matrix(scheme.correct)))
    return "\n".join(lines)


def _beside(scheme: Scheme, numbers: Numbers) -> dict[str, list[str]]:
    """Return the arrays that C++ and Rust have beside the tableaux; ``head`` is of integers."""
    found: dict[str, list[str]] = {}
    enhanced = scheme.begins == "enhanced"
    if enhanced or (scheme.pair and scheme.finish is None):
        found["head"] = [str(x) for x in scheme.heads]
    if enhanced:
        found["zero_V"] = _flat(numbers.matrix(scheme.zero))
        found["correct_K"] = _flat(numbers.matrix(scheme.correct))
    return found


def _cpp_tables(scheme: Scheme, numbers: Numbers) -> str:
    lines: list[str] = []
    for name, table in scheme.tables:
        sizes = [table.s, len(table.V[0]), len(table.V)]
        lists = [[str(x) for x in table.half]] if scheme.pair else []
        lists += [[str(x) for x in table.blocks]]
        lists += [_flat(rows) for rows in numbers.parts(table).values()]
        lines += [f"static const Tableau {name}_table{{{', '.join(map(str, sizes))},"]
        for k, items in enumerate(lists):
            inner = wrapped(items, "    ")
            inner[0] = "   {" + inner[0].lstrip()
            lines += [*inner[:-1], inner[-1] + ("}," if k + 1 < len(lists) else "}};")]
    for name, items in _beside(scheme, numbers).items():
        lines += _braces("int" if name == "head" else "double", name, items)
    return "\n".join(lines)


# --- Rust ----------------------------------------------------------------------------------------


def _rust_list(name: str, items: Sequence[str]) -> list[str]:
    lines = wrapped(items, "        ")
    if len(lines) == 1:
        return [f"    {name}: &[{lines[0].strip()}],"]
    return [f"    {name}: &[", *lines[:-1], lines[-1] + ",", "    ],"]


def _rust_static(name: str, kind: str, items: Sequence[str]) -> list[str]:
    return [f"static {name}: [{kind}; {len(items)}] = [", *wrapped(items, "    "), "];"]


def _rust_tables(scheme: Scheme, numbers: Numbers) -> str:
    lines: list[str] = []
    for name, table in scheme.tables:
        lines += [f"static {name.upper()}: Tableau = Tableau {{"]
        lines += [f"    s: {table.s},", f"    inn: {len(table.V[0])},", f"    out: {len(table.V)},"]
        if scheme.pair:
            lines += _rust_list("half", [str(x) for x in table.half])
        lines += _rust_list("blocks", [str(x) for x in table.blocks])
        for letter, rows in numbers.parts(table).items():
            if letter != "c" or not scheme.pair:
                lines += _rust_list(letter.lower(), _flat(rows))
        lines += ["};"]
    for name, items in _beside(scheme, numbers).items():
        lines += _rust_static(name.upper(), "usize" if name == "head" else "f64", items)
    return "\n".join(lines)


# --- Fortran -------------------------------------------------------------------------------------


def _double(text: str) -> str:
    """Return a literal of double precision."""
    return text.replace("e", "d") if "e" in text else f"{text}d0"


def _fortran_rows(name: str, rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a DATA statement for each row, within the limits on lines and continuations."""
    lines: list[str] = []
    for i, row in enumerate(rows):
        head = f"    data ({name}({i + 1}, j), j = 1, {len(row)}) / &"
        body = wrapped([_double(x) for x in row], "      ", " &")
        lines += [head, *body[:-1], body[-1] + " /"]
    return lines


def _fortran_table(name: str, scheme: Scheme, table: Table, numbers: Numbers) -> list[str]:
    s, n, m = table.s, len(table.V[0]), len(table.V)
    integers = {"blocks": table.blocks, **({"half": table.half} if scheme.pair else {})}
    lines = ["", f"  type(tableau) function {name}_table() result(T)", "    integer :: j"]
    lines += [
        f"    real(dp_), save :: A({s},{s}), U({s},{n}), V({m},{n})",
        f"    real(dp_), save :: B({m},{s}), L({m},{s}), c(1,{s})",
    ]
    for letter, rows in numbers.parts(table).items():
        lines += _fortran_rows(letter, rows)
    lines += [f"    allocate(T%{x}, source={x})" for x in "AUBLV"]
    lines.append("    allocate(T%c, source=c(1,:))")
    for key, values in integers.items():
        items = wrapped([str(x) for x in values], "      ", " &")
        lines += [f"    allocate(T%{key}, source=[ &", *items[:-1], items[-1] + "])"]
    return [*lines, "  end function"]


def _fortran_matrix(name: str, rows: Matrix, numbers: Numbers) -> list[str]:
    shape = f"{len(rows)}, {len(rows[0])}"
    lines = ["", f"  function {name}() result(found)", "    integer :: j"]
    lines += [f"    real(dp_) :: found({shape})", f"    real(dp_), save :: M({shape})"]
    lines += _fortran_rows("M", numbers.matrix(rows))
    return [*lines, "    found = M", "  end function"]


def _fortran_tables(scheme: Scheme, numbers: Numbers) -> str:
    lines: list[str] = []
    for name, table in scheme.tables:
        lines += _fortran_table(name, scheme, table, numbers)
    if scheme.begins == "enhanced":
        lines += _fortran_matrix("zero_V", scheme.zero, numbers)
        lines += _fortran_matrix("correct_K", scheme.correct, numbers)
    return "\n".join(lines)


# --- Python and JAX ------------------------------------------------------------------------------


def _python_rows(rows: Sequence[Sequence[str]], indent: str) -> list[str]:
    lines: list[str] = []
    for row in rows:
        inner = wrapped(row, indent + "    ")
        if len(inner) == 1:
            lines.append(f"{indent}[{inner[0].strip()}],")
        else:
            lines += [f"{indent}[", *inner, f"{indent}],"]
    return lines


def _python_tables(scheme: Scheme, numbers: Numbers) -> str:
    lines: list[str] = []
    for name, table in scheme.tables:
        lines += [f"{name.upper()} = {{", f'    "blocks": {list(table.blocks)},']
        if scheme.pair:
            lines.append(f'    "half": {list(table.half)},')
        for letter, rows in numbers.parts(table).items():
            if letter == "c":
                lines += [] if scheme.pair else ['    "c": [', *wrapped(rows[0], " " * 8), "    ],"]
            else:
                lines += [f'    "{letter}": [', *_python_rows(rows, " " * 8), "    ],"]
        lines.append("}")
    if scheme.begins == "enhanced":
        lines += ["ZERO = [", *_python_rows(numbers.matrix(scheme.zero), "    "), "]"]
        lines += ["CORRECT = [", *_python_rows(numbers.matrix(scheme.correct), "    "), "]"]
    return "\n".join(lines)


# --- Julia ---------------------------------------------------------------------------------------


def _julia_matrix(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a matrix from its rows; the layout is that of columns, so it is transposed."""
    shape = f"{len(rows[0])}, {len(rows)}"
    return ["permutedims(reshape([", *wrapped(_flat(rows), "        "), f"    ], {shape}))"]


def _julia_tables(scheme: Scheme, numbers: Numbers) -> str:
    lines: list[str] = []
    for name, table in scheme.tables:
        lines += [f"const {name.upper()} = (", f"    blocks = {list(table.blocks)},"]
        if scheme.pair:
            lines.append(f"    half = {list(table.half)},")
        for letter, rows in numbers.parts(table).items():
            if letter != "c":
                matrix = _julia_matrix(rows)
                lines += [f"    {letter} = {matrix[0]}", *matrix[1:-1], matrix[-1] + ","]
            elif not scheme.pair:
                lines += ["    c = [", *wrapped(rows[0], "        "), "    ],"]
        lines.append(")")
    if scheme.begins == "enhanced":
        for name, rows in (("ZERO", scheme.zero), ("CORRECT", scheme.correct)):
            matrix = _julia_matrix(numbers.matrix(rows))
            lines += [f"const {name} = {matrix[0]}", *matrix[1:]]
    return "\n".join(lines)


_LINES = Comment("", "// ", "")
_HASH = Comment("", "# ", "")

LANGUAGES: Mapping[str, Language] = {
    "c": Language("stepper.c.in", Comment("/*", " * ", " */"), _c_tables),
    "c++": Language("stepper.cpp.in", _LINES, _cpp_tables),
    "fortran": Language("stepper.f90.in", Comment("", "! ", ""), _fortran_tables),
    "julia": Language("stepper.jl.in", _HASH, _julia_tables),
    "rust": Language("stepper.rs.in", _LINES, _rust_tables),
    "python": Language("stepper.py.in", _HASH, _python_tables),
    "jax": Language("stepper.jax.in", _HASH, _python_tables),
}
