"""One tableau in many source forms: it is read back, and a wrong one is never passed over.

Each form writes order, A, b and c (and embedded weights, where it has them) as some code does. A
defect is a digit, two entries or two weights exchanged, the row of another stage, or error weights
in place of embedded ones; it must be accused, asked about, or said to be unread.
"""

from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.audit.lexer import language_of
from glmref.audit.recognising import tables
from glmref.audit.sources import audit

Row = list[Fraction]


class Tableau(NamedTuple):
    """Order, A (s, s), b (s,), c (s,) and embedded weights (s,)."""

    order: int
    A: list[Row]
    b: Row
    c: Row
    low: Row


def _made(order: int, A: str, b: str, low: str) -> Tableau:
    rows = [[Fraction(x) for x in row.split()] for row in A.split(";")]
    return Tableau(order, rows, *([Fraction(x) for x in v.split()] if isinstance(v, str) else v
                                  for v in (b, [sum(x) for x in rows], low)))  # fmt: skip


RK4 = _made(4, "0 0 0 0; 1/2 0 0 0; 0 1/2 0 0; 0 0 1 0", "1/6 1/3 1/3 1/6", "")
BOGACKI = _made(3, "0 0 0 0; 1/2 0 0 0; 0 3/4 0 0; 2/9 1/3 4/9 0", "2/9 1/3 4/9 0",
                "7/24 1/4 1/3 1/8")  # fmt: skip


def _row(row: Row, form: str = "{0}.0/{1}.0", sep: str = ", ") -> str:
    return sep.join(form.format(x.numerator, x.denominator) for x in row)


def _rows(A: list[Row], form: str = "{0}.0/{1}.0", ends: str = "{}") -> str:
    return ",\n  ".join(ends[0] + _row(row, form) + ends[1] for row in A)


def _below(A: list[Row]) -> Iterator[tuple[int, int, Fraction]]:
    return ((i, j, A[i][j]) for i in range(len(A)) for j in range(i) if A[i][j])


def c_arrays(t: Tableau) -> str:
    s = len(t.b)
    low = f"static const double bhat[{s}] = {{{_row(t.low)}}};\n" if t.low else ""
    return (
        f"/* Runge-Kutta */\n#define ORDER {t.order}\nstatic const double A[{s}][{s}] = {{\n"
        f"{_rows(t.A)}\n}};\nstatic const double b[{s}] = {{{_row(t.b)}}};\n"
        f"static const double c[{s}] = {{{_row(t.c)}}};\n{low}"
    )


def c_struct(t: Tableau) -> str:
    return (
        f"/* Runge-Kutta */\nstatic const Tableau T = {{\n  .order = {t.order},\n"
        f"  .A = {{{_rows(t.A)}}},\n  .b = {{{_row(t.b)}}},\n  .c = {{{_row(t.c)}}}\n}};\n"
    )


def _defines(t: Tableau, base: int) -> str:
    made = [(f"A{i + base}{j + base}", x) for i, j, x in _below(t.A)]
    made += [(f"{word}{k + base}", x) for word, row in (("B", t.b), ("C", t.c))
             for k, x in enumerate(row) if x]  # fmt: skip
    lines = "".join(f"#define {name} ({_row([x])})\n" for name, x in made)
    return f"/* Runge-Kutta */\n#define ORDER {t.order}\n{lines}"


def c_define(t: Tableau) -> str:
    return _defines(t, 1)


def c_define_from_0(t: Tableau) -> str:
    return _defines(t, 0)


def f_parameter(t: Tableau) -> str:
    made = [(f"a{i + 1}{j + 1}", x) for i, j, x in _below(t.A)]
    made += [(f"{word}{k}", x) for word, row in (("b", t.b), ("c", t.c))
             for k, x in enumerate(row, 1)]  # fmt: skip
    form = "{0}.0d0/{1}.0d0"
    lines = "".join(f"  real(8), parameter :: {n} = {_row([x], form)}\n" for n, x in made)
    return f"! Runge-Kutta\nmodule rk\n  integer, parameter :: order = {t.order}\n{lines}end module"


def f_array(t: Tableau) -> str:
    s, form = len(t.b), "{0}.0d0/{1}.0d0"
    rows = ", &\n".join(_row(row, form) for row in t.A)
    return (
        f"! Runge-Kutta\nmodule rk\n  integer, parameter :: order = {t.order}\n"
        f"  real(8), parameter :: a({s},{s}) = transpose(reshape([ &\n{rows}], [{s},{s}]))\n"
        f"  real(8), parameter :: b({s}) = [{_row(t.b, form)}]\n"
        f"  real(8), parameter :: c({s}) = [{_row(t.c, form)}]\nend module\n"
    )


def f_columns(t: Tableau) -> str:
    s, form = len(t.b), "{0}.0d0/{1}.0d0"
    rows = ", &\n".join(_row(row, form) for row in (*zip(*t.A, strict=True),))
    weights = ", &\n".join(_row(row, form) for row in (t.b, t.low) if row)
    return (
        f"! Runge-Kutta\nmodule rk\n  integer, parameter :: order = {t.order}\n"
        f"  real(8), parameter :: a({s},{s}) = reshape([ &\n{rows}], [{s},{s}])\n"
        f"  real(8), parameter :: b({s},m) = reshape([{weights}], [{s},{1 + bool(t.low)}])\n"
        f"  real(8), parameter :: c({s}) = [{_row(t.c, form)}]\nend module\n"
    )


def f_parts(t: Tableau) -> str:
    s, form = len(t.b), "{0}.0d0/{1}.0d0"
    rows = "".join(f"  rk%A({i + 1},1:{i}) = (/ {_row(row[:i], form)} /)\n"
                   for i, row in enumerate(t.A) if i)  # fmt: skip
    return (
        f"! Runge-Kutta\nsubroutine fill(rk)\n  rk%order = {t.order}\n"
        f"  rk%A(1:{s},1:{s}) = 0.d0\n{rows}  rk%c(1:{s}) = (/ {_row(t.c, form)} /)\n"
        f"  rk%b(1:{s}) = (/ {_row(t.b, form)} /)\nend subroutine\n"
    )


def julia(t: Tableau) -> str:
    form = "{0}//{1}"
    rows = ";\n     ".join(_row(row, form, " ") for row in t.A)
    low = f"bhat = [{_row(t.low, form)}]\n" if t.low else ""
    return (
        f"# Runge-Kutta\norder = {t.order}\nA = [{rows}]\nb = [{_row(t.b, form)}]\n"
        f"c = [{_row(t.c, form)}]\n{low}"
    )


PY = "{0}/{1}"


def py_lists(t: Tableau) -> str:
    low = f"    bhat = [{_row(t.low, PY)}]\n" if t.low else ""
    return (
        f"# Runge-Kutta\nclass M:\n    order = {t.order}\n    A = [{_rows(t.A, PY, '[]')}]\n"
        f"    b = [{_row(t.b, PY)}]\n    c = [{_row(t.c, PY)}]\n{low}"
    )


def py_dict(t: Tableau) -> str:
    return (
        f'# Runge-Kutta\nT = {{"order": {t.order}, "A": [{_rows(t.A, PY, "[]")}],\n'
        f'  "b": [{_row(t.b, PY)}], "c": [{_row(t.c, PY)}]}}\n'
    )


def _keyed(row: Row) -> str:
    return "{" + ", ".join(f"{k}: {_row([x], PY)}" for k, x in enumerate(row, 1)) + "}"


def py_number_keys(t: Tableau) -> str:
    rows = ",\n  ".join(f"{i + 1}: {_keyed(row[:i])}" for i, row in enumerate(t.A) if i)
    return (
        f"# Runge-Kutta\norder = {t.order}\nA = {{{rows}}}\nb = {_keyed(t.b)}\nc = {_keyed(t.c)}\n"
    )


def py_pair_keys(t: Tableau) -> str:
    entries = ", ".join(f"({i}, {j}): {_row([x], PY)}" for i, j, x in _below(t.A))
    return (
        f"# Runge-Kutta\norder = {t.order}\nA = {{{entries}}}\nb = [{_row(t.b, PY)}]\n"
        f"c = [{_row(t.c, PY)}]\n"
    )


def numpy(t: Tableau) -> str:
    s = len(t.b)
    lines = "".join(f"A[{i}, {j}] = {_row([x], PY)}\n" for i, j, x in _below(t.A))
    return (
        f"# Runge-Kutta\nimport numpy as np\norder = {t.order}\nA = np.zeros(({s}, {s}))\n{lines}"
        f"b = np.array([{_row(t.b, PY)}])\nc = np.array([{_row(t.c, PY)}])\n"
    )


def matlab(t: Tableau) -> str:
    rows = "; ...\n  ".join(_row(row, PY, " ") for row in t.A)
    return (
        f"% Runge-Kutta\norder = {t.order};\nA = [{rows}];\nb = [{_row(t.b, PY, ' ')}];\n"
        f"c = [{_row(t.c, PY, ' ')}];\n"
    )


def rust(t: Tableau) -> str:
    s = len(t.b)
    return (
        f"// Runge-Kutta\npub const ORDER: usize = {t.order};\n"
        f"pub const A: [[f64; {s}]; {s}] = [{_rows(t.A, ends='[]')}];\n"
        f"pub const B: [f64; {s}] = [{_row(t.b)}];\npub const C: [f64; {s}] = [{_row(t.c)}];\n"
    )


def java(t: Tableau) -> str:
    return (
        f"// Runge-Kutta\npublic class Rk {{\n  static final int ORDER = {t.order};\n"
        f"  static final double[][] A = {{{_rows(t.A)}}};\n"
        f"  static final double[] B = {{{_row(t.b)}}};\n"
        f"  static final double[] C = {{{_row(t.c)}}};\n}}\n"
    )


def go(t: Tableau) -> str:
    rows = "".join("\t\t{" + _row(row) + "},\n" for row in t.A)
    return (
        f"package ode\n// Runge-Kutta\nvar rk = Tableau{{\n\tOrder: {t.order},\n"
        f"\tA: [][]float64{{\n{rows}\t}},\n\tB: []float64{{{_row(t.b)}}},\n"
        f"\tC: []float64{{{_row(t.c)}}},\n}}\n"
    )


def javascript(t: Tableau) -> str:
    return (
        f"// Runge-Kutta\nexport const rk = {{\n  order: {t.order},\n"
        f"  A: [{_rows(t.A, PY, '[]')}],\n  b: [{_row(t.b, PY)}],\n  c: [{_row(t.c, PY)}],\n}}\n"
    )


def cpp_rows(t: Tableau) -> str:
    s = len(t.b)
    rows = "".join(f"  double a{i + 1}[{i}] = {{{_row(row[:i])}}};\n"
                   for i, row in enumerate(t.A) if i)  # fmt: skip
    return (
        f"// Runge-Kutta\nclass Rk {{ public:\n  static const int order = {t.order};\n{rows}"
        f"  double b[{s}] = {{{_row(t.b)}}};\n  double c[{s}] = {{{_row(t.c)}}};\n}};\n"
    )


def cpp_places(t: Tableau) -> str:
    rows = ", ".join("{" + _row(row[:i]) + "}" for i, row in enumerate(t.A) if i)
    low = f", {{{_row(t.low)}}}" if t.low else ""
    return (
        f"// Runge-Kutta\nint order() {{ return {t.order}; }}\nTableau make() {{\n"
        f"  static const Tableau tableau{{{{{_row(t.c[1:])}}}, {{{rows}}}, {{{_row(t.b)}}}{low}}};\n"
        f"  return tableau;\n}}\n"
    )


def cpp_at(t: Tableau) -> str:
    rows = "".join(f"  k.A.at({i}).at({j}) = {_row([x])};\n" for i, j, x in _below(t.A))
    rest = "".join(f"  k.{word}.at({i}) = {_row([x])};\n"
                   for word, row in (("b", t.b), ("c", t.c), ("bHat", t.low))
                   for i, x in enumerate(row))  # fmt: skip
    return f"// Runge-Kutta\nint order = {t.order};\nvoid fill() {{\n{rows}{rest}}}\n"


def c_step(t: Tableau) -> str:
    text = f"/* Runge-Kutta */\nstatic const int order = {t.order};\nvoid step(double *y) {{\n"
    for i, row in enumerate(t.A):
        sums = "".join(f" + h*({_row([x])})*k{j}[i]" for j, x in enumerate(row) if x)
        text += (
            f"  for (i = 0; i < n; i++) w[i] = y[i]{sums};\n"
            f"  rhs(t + ({_row([t.c[i]])})*h, w, k{i});\n"
        )
    sums = " + ".join(f"({_row([x])})*k{j}[i]" for j, x in enumerate(t.b) if x)
    return text + f"  for (i = 0; i < n; i++) y[i] += h*({sums});\n}}\n"


FORMS: dict[Callable[[Tableau], str], str] = {
    c_arrays: "a.c", c_struct: "a.c", c_define: "a.h", c_define_from_0: "a.h",
    f_parameter: "a.f90", f_array: "a.f90", julia: "a.jl", py_lists: "a.py", py_dict: "a.py",
    py_number_keys: "a.py", py_pair_keys: "a.py", numpy: "a.py", matlab: "a.m", rust: "a.rs",
    java: "A.java", go: "a.go", javascript: "a.js", cpp_rows: "a.hpp", c_step: "a.c",
    f_columns: "a.f90", f_parts: "a.f90", cpp_places: "a.cpp", cpp_at: "a.cpp",
}  # fmt: skip


def _defects(t: Tableau) -> dict[str, Tableau]:
    """Return tables that are wrong in entries which b, or the embedded weights, see."""
    A = [list(row) for row in t.A]
    A[2][1] += Fraction(1, 8)
    stages = [list(row) for row in t.A]
    stages[2] = list(t.A[1])
    swapped = [list(row) for row in t.A]
    swapped[2][:2] = reversed(swapped[2][:2])
    found = {}
    if not t.low:  # once is enough
        found["digit"] = t._replace(A=A)
        found["row"] = t._replace(A=stages)
        found["entries"] = t._replace(A=swapped)
        found["weights"] = t._replace(b=[t.b[1], t.b[0], *t.b[2:]])
    else:
        found["error weights"] = t._replace(low=[x - y for x, y in zip(t.b, t.low, strict=True)])
        found["embedded"] = t._replace(low=[t.low[1], t.low[0], *t.low[2:]])
        last = [list(row) for row in t.A]
        last[3][:2] = reversed(last[3][:2])
        found["last row"] = t._replace(A=last)
    return found


#: Forms that leave zeros out, so that a table with zeros is not the only one of its text.
SPARSE = (c_define, c_define_from_0, f_parameter, py_pair_keys, cpp_at, c_step)


@st.composite
def tableaux(draw: st.DrawFn, zeros: bool) -> Tableau:
    """A tableau of 3 to 5 stages whose weights sum to 1 and satisfy the condition of order 2."""
    top = st.integers(-40, 40)
    fractions = st.builds(Fraction, top if zeros else top.filter(bool), st.integers(1, 40))
    s = draw(st.integers(3, 5))
    A = [[draw(fractions) if j < i else Fraction(0) for j in range(s)] for i in range(s)]
    A[1][0] = Fraction(draw(st.integers(1, 30)), 31)
    c = [sum(row, Fraction(0)) for row in A]
    b = [draw(fractions) for _ in range(s)]
    rest = sum((x * y for x, y in zip(b[2:], c[2:], strict=True)), Fraction(0))
    b[1] = (Fraction(1, 2) - rest) / c[1]
    b[0] = 1 - sum(b[1:], Fraction(0))
    return Tableau(2, A, b, c, [])


@pytest.mark.parametrize("form", FORMS, ids=lambda x: x.__name__)
@settings(max_examples=4, deadline=None)
@given(st.data())
def test_a_table_is_read_back_as_it_was_written(form, data):
    def exact(row: Any) -> Row:
        return [x.value.as_fraction() for x in row]

    given = data.draw(tableaux(zeros=form not in SPARSE))
    text, language = form(given), language_of(Path(FORMS[form]))
    assert language
    (table,) = tables(text, language)
    assert not table.unread, table.unread
    found = [exact(x) for x in table.A[0]], exact(table.b[0]), exact(table.c[0] or [])
    assert found == given[1:4], text


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS, ids=lambda x: x.__name__)
def test_no_defect_is_silent_in_any_form(form: Callable[[Tableau], str], tmp_path: Path) -> None:
    def states(name: str, text: str) -> set[tuple[str, int]]:
        path = tmp_path / name / FORMS[form]
        path.parent.mkdir(parents=True)
        path.write_text(text, "utf-8")
        return {(x["status"], x.get("declared")) for x in audit(path, compare=False)}

    for right in (RK4, BOGACKI):
        assert states(f"{right.order}", form(right)) == {("right", right.order)}
        for name, wrong in _defects(right).items():
            text = form(wrong)
            if text == form(right) or (name == "last row" and form is c_step):
                continue  # the form has no embedded weights, or the step does not use that stage
            if name == "error weights" and form in (cpp_places, f_columns):
                continue  # no name says which of the two are meant
            found = {x for x, _ in states(f"{name}-{right.order}", text)}
            assert found & {"wrong", "question", "unread"}, name
