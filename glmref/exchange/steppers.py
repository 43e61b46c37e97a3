"""Steppers as source files: one template for each language, filled with a method's tableaux.

A template (``templates/stepper.*.in``) is the source file with marks of jinja2: ``@{name}`` is
replaced, and a part between the lines ``@% if WORD %@``, ``@% elif WORD %@``, ``@% else %@`` and
``@% endif %@`` stays where the word holds:

    pair      f and k are given separately      implicit  some stage needs an equation solved
    newton    implicit, and not a pair          started   the method has a starting method
    enhanced  it needs the enhanced start       plain     it starts from the solution
    finish    it has a finishing method         headed    values that are the solution are picked
    renewed   long runs renew the values

How a language writes arguments and calls for a pair and for y' = f(t, y) stands at its head, and
the tables where they are declared.
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

    environment = Environment(
        loader=PackageLoader("glmref.exchange"), undefined=StrictUndefined,
        block_start_string="@%", block_end_string="%@", trim_blocks=True, lstrip_blocks=True,
        variable_start_string="@{", variable_end_string="}", keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters.update(_FILTERS)
    return environment


def filled(template: str, words: Iterable[str], values: Mapping[str, object]) -> str:
    """Fill a template of the folder ``templates``: see the module's docstring."""
    said = dict.fromkeys(_WORDS, False) | dict.fromkeys(words, True)
    return _templates().get_template(template).render({**said, **values})


@dataclass(frozen=True)
class Language:
    """What differs from language to language besides the template."""

    template: str
    comment: Comment  #: How a comment is written.


@dataclass(frozen=True)
class Numbers:
    """How a coefficient is written."""

    digits: int | None  #: Significant digits, ``None`` for the shortest decimals of doubles.

    def of(self, x: Scalar) -> str:
        """Return one coefficient."""
        return rounded(x, self.digits)

    def residue(self, x: Scalar) -> str:
        """Return its rounding residual to six digits, which is all that can matter."""
        value = lost(x, rounded(x, self.digits))
        return repr(float(f"{value:.5e}")) if value else "0.0"

    def matrix(self, rows: Matrix) -> list[list[str]]:
        """Return a matrix."""
        return [[self.of(x) for x in row] for row in rows]

    def residues(self, rows: Matrix) -> list[list[str]]:
        """Return the rounding residual of a matrix."""
        return [[self.residue(x) for x in row] for row in rows]

    def table(self, name: str, table: Table) -> dict[str, Any]:
        """Return what a template asks of a tableau: s, n and m, its arrays, c as one row."""
        return {
            "name": name,
            "sizes": [table.s, len(table.V[0]), len(table.V)],
            "blocks": list(table.blocks),
            "half": list(table.half),
            "arrays": {
                "A": self.matrix(table.A),
                "U": self.matrix(table.U),
                "B": self.matrix(table.B),
                "L": self.residues(table.B),
                "V": self.matrix(table.V),
                "c": self.matrix((table.c,)),
            },
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
    scheme, chosen, numbers = scheme_of(method), LANGUAGES[language], Numbers(digits)
    name = identifier(method.name)
    used = [x for _, t in scheme.tables for m in (t.A, t.U, t.B, t.V) for row in m for x in row]
    remark = f"Coefficients differ from the exact ones by at most {worst(used, digits):.2g}; "
    remark += "the rounding residual of B is added back (L)."
    values = {
        "name": name,
        "header": header(method, language, chosen.comment, remark),
        "tables": [numbers.table(key, table) for key, table in scheme.tables],
        "zero": numbers.matrix(scheme.zero),
        "correct": numbers.matrix(scheme.correct),
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


# --- arrays --------------------------------------------------------------------------------------


def _flat(rows: Iterable[Iterable[str]]) -> list[str]:
    return [x for row in rows for x in row]


def _joined(items: Sequence[object], indent: str, end: str = "") -> str:
    """See :func:`wrapped`."""
    return "\n".join(wrapped([str(x) for x in items], indent, end))


def _prefixed(names: Iterable[str], prefix: str) -> list[str]:
    return [prefix + name for name in names]


def _braces(items: Sequence[object], declared: str) -> str:
    """Return an array of C, on one line where it is short."""
    short = f"{declared}[] = {{{', '.join(map(str, items))}}};"
    if len(short) < _WIDTH:
        return short
    return f"{declared}[] = {{\n{_joined(items, '  ')}}};"


def _rust_list(items: Sequence[object], name: str) -> str:
    text = _joined(items, "        ")
    inside = f"\n{text},\n    " if "\n" in text else text.strip()
    return f"    {name}: &[{inside}],"


def _fortran_rows(rows: Sequence[Sequence[str]], name: str) -> str:
    """Return a DATA statement for each row, within the limits on lines and continuations."""
    lines: list[str] = []
    for i, row in enumerate(rows):
        double = [x.replace("e", "d") if "e" in x else f"{x}d0" for x in row]
        lines.append(f"    data ({name}({i + 1}, j), j = 1, {len(row)}) / &")
        lines.append(f"{_joined(double, '      ', ' &')} /")
    return "\n".join(lines)


def _python_rows(rows: Sequence[Sequence[str]], indent: str) -> str:
    lines: list[str] = []
    for row in rows:
        text = _joined(row, indent + "    ")
        inside = f"\n{text}\n{indent}" if "\n" in text else text.strip()
        lines.append(f"{indent}[{inside}],")
    return "\n".join(lines)


def _julia_matrix(rows: Sequence[Sequence[str]]) -> str:
    """Return a matrix from its rows; the layout is that of columns, so it is transposed."""
    inside = _joined(_flat(rows), "        ")
    return f"permutedims(reshape([\n{inside}\n    ], {len(rows[0])}, {len(rows)}))"


#: How templates write lists of numbers.
_FILTERS: Mapping[str, Callable[..., Any]] = {
    "flat": _flat,
    "wrapped": _joined,
    "prefixed": _prefixed,
    "braces": _braces,
    "rust_list": _rust_list,
    "fortran_rows": _fortran_rows,
    "python_rows": _python_rows,
    "julia_matrix": _julia_matrix,
}


_LINES = Comment("", "// ", "")
_HASH = Comment("", "# ", "")

LANGUAGES: Mapping[str, Language] = {
    "c": Language("stepper.c.in", Comment("/*", " * ", " */")),
    "c++": Language("stepper.cpp.in", _LINES),
    "fortran": Language("stepper.f90.in", Comment("", "! ", "")),
    "julia": Language("stepper.jl.in", _HASH),
    "rust": Language("stepper.rs.in", _LINES),
    "python": Language("stepper.py.in", _HASH),
    "jax": Language("stepper.jax.in", _HASH),
}
