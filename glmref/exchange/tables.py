"""Tables in the syntax of other packages: what they can hold, and the text.

Fractions are written as quotients, which every reader computes without loss but for the last
rounding. Other numbers are decimals; where they have an exact expression it stands in a comment,
one line a row, and :mod:`.import_tables` takes it from there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..catalogue.claims import ORDER, stated_orders
from ..errors import UsageError
from ..exact import Exact, Scalar
from ..exact.linalg import Matrix, Vector
from ..method import GLM, AdditiveGLM, PartitionedGLM
from ..method.embedded import EmbeddedRow
from ..method.families import splitting
from ..method.preconsistency import stage_times
from ..prove.facts import facts_of
from ..views.notation import LATEX
from .documents import expression, is_one
from .header import ONE_ROW, Comment, header, in_comment
from .numbers import decimal_of, is_zero
from .steppers import filled, identifier, wrapped

#: Significant digits of decimals in tables: those of quadruple precision.
DIGITS = 34
#: Numerator and denominator of a fraction that is written as one: both are doubles.
_LARGEST = 2**53

_C = Comment("/*", " * ", " */")
_HASH = Comment("", "# ", "")


@dataclass(frozen=True)
class Butcher:
    """A Runge-Kutta tableau: A (s, s), b (s,), c (s,), and the order that its file claims.

    ``row`` holds the first embedded weights, ``lower`` their order, 0 where there are none.
    """

    A: Matrix
    b: Vector
    c: Vector
    order: int
    row: Vector | None = None
    lower: int = 0

    @property
    def rows(self) -> dict[str, Matrix]:
        """A, b, c and, where there are embedded weights, d, in the letters of SUNDIALS."""
        found: dict[str, Matrix] = {"A": self.A, "b": (self.b,), "c": (self.c,)}
        return found if self.row is None else {**found, "d": (self.row,)}

    @property
    def error(self) -> Vector:
        """Weights of the error estimate; zero where there are no embedded weights."""
        return tuple(x - y for x, y in zip(self.b, self.row or self.b, strict=True))

    @property
    def s(self) -> int:
        """Number of stages."""
        return len(self.b)


def butcher(method: GLM | PartitionedGLM, target: str) -> Butcher:
    """Return the Runge-Kutta tableau of a method.

    Raises
    ------
    UsageError
        When the method is none, or is not real.
    """
    name = method.name or "the method"
    other = "json, csv and latex hold it"
    if method.parts == 2:
        nystrom = (method.document or {}).get("class") == "nystrom"
        kind = "a Runge-Kutta-Nystrom method" if nystrom else "a pair"
        raise UsageError(f"{target} holds Runge-Kutta tableaux and {name} is {kind}; {other}")
    if method.r != 1 or not is_one(method.V[0][0]) or not all(is_one(x) for (x,) in method.U):
        raise UsageError(
            f"{target} holds Runge-Kutta tableaux and {name} carries {method.r} values from step "
            f"to step; {other}"
        )
    if not method.is_real:
        raise UsageError(f"{target} holds real numbers and {name} is complex; {other}")
    c = stage_times(method)
    # the sums themselves where they are exact, so that c = A 1 is kept
    sums = tuple(sum(row[1:], row[0]) for row in method.A)
    if getattr(method, "abscissae_given", None) is None:
        c = sums if all(isinstance(x, Exact) for x in sums) else c
    (row,), lower = _embedded(method) or ((None,), 0)
    return Butcher(method.A, method.B[0], c, _order(method), row, lower)


def _embedded(
    method: GLM | PartitionedGLM | AdditiveGLM,
) -> tuple[tuple[Vector, ...], int] | None:
    """Return weights of the first embedded solution, by parts, and their claimed or found order."""
    if not method.embedded:
        return None
    row = method.embedded[0]
    rows = tuple(x for (x,) in row.solution(method.weights))
    claimed = stated_orders(method.claims)
    if row.name in claimed:
        return rows, claimed[row.name]
    return rows, _order(method.weighted(tuple((x,) for x in rows)))  # pyright: ignore[reportArgumentType]


def _order(method: GLM | PartitionedGLM | AdditiveGLM) -> int:
    order = stated_orders(method.claims).get("b")
    if isinstance(order, int):
        return order
    return facts_of(method).nominal.kernel.range(ORDER.key).value


def _quotient(x: Scalar) -> tuple[int, int] | None:
    fraction = x.as_fraction() if isinstance(x, Exact) else None
    if fraction is None or max(abs(fraction.numerator), fraction.denominator) > _LARGEST:
        return None
    return fraction.numerator, fraction.denominator


def _exact_lines(rows: Mapping[str, Matrix]) -> list[str]:
    """Return lines of a comment with the exact rows, where quotients do not say it all."""
    lines: list[str] = []
    if all(_quotient(x) is not None for m in rows.values() for row in m for x in row):
        return []
    for letter, matrix in rows.items():
        for row in matrix:
            texts = [expression(x) for x in row]
            if any(text is None for text in texts):
                return []
            lines.append(f"exact {letter}: {'; '.join(x or '' for x in texts)}")
    return lines


def _head(
    method: GLM | PartitionedGLM, target: str, tableau: Butcher, comment: Comment, digits: int
) -> str:  # fmt: skip
    remark = f"Numbers that are not quotients have {digits} significant digits."
    rows = {x: m for x, m in tableau.rows.items() if x != "d" or target in ONE_ROW}
    if target == "diffrax" and rows.pop("d", None):
        rows["e"] = (tableau.error,)
    return header(method, target, comment, remark, exact=_exact_lines(rows))


# --- C: SUNDIALS and PETSc -----------------------------------------------------------------------


def _c_number(x: Scalar, digits: int, cast: Callable[[str], str]) -> str:
    quotient = _quotient(x)
    if quotient is None:
        text = decimal_of(x, digits)
        # zeros tell a reader that an exact decimal that ends early is known beyond its end
        whole, point, places = text.partition(".")
        exact = x.as_fraction() if isinstance(x, Exact) else None
        padded = point and "e" not in text and exact == Fraction(text)
        return cast(f"{whole}.{places:0<{digits}}" if padded else text)
    over = "" if quotient[1] == 1 else f"/{cast(f'{quotient[1]}.0')}"
    return cast(f"{quotient[0]}.0") + over


def _c_array(kind: str, name: str, rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [f"  {kind} {name}[] = {{"]
    for k, row in enumerate(rows):
        inner = wrapped(row, "    ")
        lines += [*inner[:-1], inner[-1] + ("," if k + 1 < len(rows) else "")]
    return [*lines, "  };"]


#: How the C of a package calls its real type, and writes a number of it.
_REAL: Mapping[str, tuple[str, Callable[[str], str]]] = {
    "sundials": ("sunrealtype", lambda text: f"SUN_RCONST({text})"),
    "petsc": ("const PetscReal", str),
}


def _c_arrays(rows: Mapping[str, Matrix], target: str, digits: int) -> list[str]:
    kind, cast = _REAL[target]
    lines: list[str] = []
    for letter, matrix in rows.items():
        texts = [[_c_number(x, digits, cast) for x in row] for row in matrix]
        lines += _c_array(kind, letter, texts)
    return lines


def _c_values(
    method: GLM | PartitionedGLM | AdditiveGLM, target: str, does: str, digits: int
) -> dict[str, Any]:
    """Return what a template of C says of a tableau, at most diagonally implicit, or of two."""
    if isinstance(method, AdditiveGLM):
        head, arrays, order, lower = _imex(method, target, digits)
        s, embedded = method.s, bool(method.embedded)
    else:
        tab = butcher(method, target)
        if not method.is_diagonally_implicit:
            raise UsageError(
                f"{target} {does} explicit and diagonally implicit tableaux, and {method.name} is "
                f"fully implicit; rungekutta.jl holds it"
            )
        head, arrays = _head(method, target, tab, _C, digits), _c_arrays(tab.rows, target, digits)
        s, order, lower, embedded = tab.s, tab.order, tab.lower, tab.row is not None
    return {
        "head": head, "arrays": "\n".join(arrays), "name": identifier(method.name), "s": s,
        "order": order, "lower": lower, "embedded": embedded,
    }  # fmt: skip


def _imex(method: AdditiveGLM, target: str, digits: int) -> tuple[str, list[str], int, int]:
    """Return the head, the arrays and the orders of an implicit-explicit Runge-Kutta method.

    The arrays A, b, c belong to the explicit part, which comes first where both are explicit, and
    At, bt, ct to the other, in the letters of PETSc; d and dt hold embedded weights. The second
    order is that of these, 0 where there are none.
    """
    name = method.name or "the method"
    ones = [x for row in (*(method.U or ()), *(method.V or ())) for x in row]
    if method.k != 2 or method.r != 1 or not all(map(is_one, ones)):
        raise UsageError(
            f"{target} holds additive Runge-Kutta methods of two parts and {name} has {method.k} "
            f"parts and {method.r} values; export its parts"
        )
    if not method.is_real:
        raise UsageError(f"{target} holds real numbers and {name} is complex; export its parts")
    order = sorted((0, 1), key=lambda n: not _is_lower(method.A[n], 0))
    e, i = order
    if not (_is_lower(method.A[e], 0) and _is_lower(method.A[i], 1)):
        raise UsageError(
            f"{target} steps an explicit part with a diagonally implicit one, stages in their "
            f"order, and {name} has no such parts; export its parts"
        )
    rows: dict[str, Matrix] = {}
    for n, mark in ((e, ""), (i, "t")):
        c = tuple(sum(row[1:], row[0]) for row in method.A[n])
        rows |= {f"A{mark}": method.A[n], f"b{mark}": method.B[n], f"c{mark}": (c,)}
    lower, found = 0, _embedded(method)
    if found is not None:
        (weights, lower) = found
        rows |= {"d": (weights[e],), "dt": (weights[i],)}
    said = f"A, b, c: part {e + 1}, explicit; At, bt, ct: part {i + 1}, implicit. "
    said += f"Numbers that are not quotients have {digits} significant digits."
    head = header(method, target, _C, said, exact=_exact_lines(rows))
    return head, _c_arrays(rows, target, digits), _order(method), lower


def _is_lower(A: Matrix, above: int) -> bool:
    """Return whether entries beyond the diagonal, or with 0 on it too, are zero."""
    return all(is_zero(x) for i, row in enumerate(A) for x in row[i + above :])


def _sprk(method: GLM | PartitionedGLM, digits: int) -> str | None:
    """Return a splitting as a table of SPRKStep, ``None`` for another pair.

    In each stage p += ahat_i h k(q), then q += a_i h f(p).
    """
    a, b = (c.B[0] for c in method.components)
    for first, zero in (("q", len(a) - len(b)), ("p", len(b) - len(a))):
        if method.is_one_step and method.is_real and zero in (0, 1):
            like = splitting(a, b, first)
            if all(
                is_zero(x - y)
                for c, mine in zip(like.components, method.components, strict=True)
                for matrix, rows in zip(c.matrices, mine.matrices, strict=True)
                for row, own in zip(matrix, rows, strict=True)
                for x, y in zip(row, own, strict=True)
            ):
                break
    else:
        return None
    nothing = (a[0] * 0,)
    ahat = (*nothing, *b) if first == "q" else b
    a = a + nothing * (len(ahat) - len(a))
    rows: dict[str, Matrix] = {"a": (a,), "ahat": (ahat,)}
    remark = f"Numbers that are not quotients have {digits} significant digits. "
    remark += "f1 is the force k(q), f2 the velocity f(p)."
    values = {
        "head": header(method, "sundials", _C, remark, exact=_exact_lines(rows)),
        "arrays": "\n".join(_c_arrays(rows, "sundials", digits)),
        "name": identifier(method.name), "s": len(a), "order": _order(method),
    }  # fmt: skip
    return filled("table.sundials.in", ["sprk"], values)


def _sundials(method: GLM | PartitionedGLM | AdditiveGLM, digits: int) -> str:
    if not isinstance(method, AdditiveGLM) and method.parts == 2:
        found = _sprk(method, digits)
        if found is not None:
            return found
    values = _c_values(method, "sundials", "steps", digits)
    d, dt = ("d", "dt") if values["embedded"] else ("NULL", "NULL")
    words = ["ark"] if method.additive else []
    return filled("table.sundials.in", words, values | {"d": d, "dt": dt})


def _petsc(method: GLM | PartitionedGLM | AdditiveGLM, digits: int) -> str:
    values = _c_values(method, "petsc", "registers", digits)
    rows = ("dt, d", "NULL, NULL") if method.additive else ("d", "NULL")
    more = {
        "title": method.name or identifier(method.name),
        "embedded": rows[0] if values["embedded"] else rows[1],
        "function": "TSRKRegister" if method.is_explicit else "TSDIRKRegister",
    }
    return filled("table.petsc.in", ["ark"] if method.additive else [], values | more)


# --- Python: diffrax -----------------------------------------------------------------------------


def _diffrax(method: GLM | PartitionedGLM, digits: int) -> str:
    tab = butcher(method, "diffrax")
    if not (method.is_explicit and tab.s > 1):
        raise UsageError(
            f"the diffrax tables written here are explicit with two stages or more, and "
            f"{method.name} is not: an implicit one also needs a predictor; jax writes a stepper"
        )
    if not all(is_zero(x) for i, row in enumerate(tab.A) for x in row[i:]):
        raise UsageError(f"diffrax needs stages in their order, and those of {method.name} are not")

    def array(values: Sequence[Scalar]) -> list[str]:
        items = []
        for x in values:
            quotient = _quotient(x)
            over = "" if quotient is None or quotient[1] == 1 else f" / {quotient[1]}"
            items.append(decimal_of(x, digits) if quotient is None else f"{quotient[0]}.0{over}")
        lines = wrapped(items, "            ")
        return ["np.array(", "        [", *lines, "        ]", "    )"]

    lines: list[str] = []
    for key, values in (("c", tab.c[1:]), ("b_sol", tab.b), ("b_error", tab.error)):
        first, *rest = array(values)
        lines += [f"    {key}={first}", *rest[:-1], rest[-1] + ","]
    lines += ["    a_lower=("]
    for i in range(1, tab.s):
        lines += [f"    {x}" for x in array(tab.A[i][:i])]
        lines[-1] += ","
    said = "No embedded method, so no error estimate: use it with ConstantStepSize."
    if tab.row is not None:
        said = f"The error estimate is the difference to a solution of order {tab.lower}."
    return filled("table.diffrax.in", (), {
        "head": _head(method, "diffrax", tab, _HASH, digits),
        "arrays": "\n".join([*lines, "    ),"]),
        "name": "".join(x.capitalize() for x in identifier(method.name).split("_")),
        "said": said, "order": tab.order,
    })  # fmt: skip


# --- Julia ---------------------------------------------------------------------------------------


def _julia_number(x: Scalar, digits: int) -> str:
    quotient = _quotient(x)
    if quotient is None:
        return f'big"{decimal_of(x, digits)}"'
    return str(quotient[0]) if quotient[1] == 1 else f"{quotient[0]}//{quotient[1]}"


def _julia_arrays(tab: Butcher, digits: int, kind: str, names: Sequence[str]) -> list[str]:
    rows = [" ".join(_julia_number(x, digits) for x in row) for row in tab.A]
    first, margin = f"    {names[0]} = {kind}[", "        "
    if tab.s == 1:
        lines = [f"    {names[0]} = reshape({kind}[{rows[0]}], 1, 1)"]
    else:
        lines = [first, *(f"{margin}{row}" for row in rows), "    ]"]
    vectors = (tab.b, tab.c) if tab.row is None else (tab.b, tab.c, tab.row)
    for name, values in zip(names[1:], vectors, strict=False):
        items = wrapped([_julia_number(x, digits) for x in values], margin)
        lines += [f"    {name} = {kind}[", *items, "    ]"]
    return lines


def _ordinarydiffeq(method: GLM | PartitionedGLM, digits: int) -> str:
    tab = butcher(method, "ordinarydiffeq")
    if not method.is_explicit:
        raise UsageError(
            f"ordinarydiffeq takes explicit tableaux (ExplicitRKTableau), and {method.name} is "
            f"implicit; rungekutta.jl holds it"
        )
    name = identifier(method.name)
    lines = [_head(method, "ordinarydiffeq", tab, _HASH, digits), "import DiffEqBase", ""]
    lines += [f"# solve(problem, ExplicitRK(tableau = {name}_tableau()); dt = h, adaptive = false)"]
    lines += [f"function {name}_tableau(T::Type = Float64)"]
    lines += _julia_arrays(tab, digits, "T", ("A", "α", "c", "αEEst"))
    more = "" if tab.row is None else f", αEEst = αEEst, adaptiveorder = {tab.lower}"
    lines += [f"    return DiffEqBase.ExplicitRKTableau(A, c, α, {tab.order}{more})", "end"]
    return "\n".join(lines) + "\n"


def _rungekutta(method: GLM | PartitionedGLM, digits: int) -> str:
    tab = butcher(method, "rungekutta.jl")
    name = identifier(method.name)
    title = "".join(x.capitalize() for x in name.split("_"))
    lines = [_head(method, "rungekutta.jl", tab, _HASH, digits), "using RungeKutta", ""]
    lines += [f"function Tableau{title}(::Type{{T}} = Float64) where {{T}}"]
    lines += _julia_arrays(tab, digits, "BigFloat", ("a", "b", "c"))
    lines += [f"    return Tableau{{T}}(:{name}, {tab.order}, {tab.s}, a, b, c)", "end"]
    return "\n".join(lines) + "\n"


# --- every method: LaTeX --------------------------------------------------------------


def _latex(method: GLM | PartitionedGLM | AdditiveGLM, digits: int | None) -> str:
    def cell(x: Scalar) -> str:
        if digits is None:
            found = expression(x)
            if found is not None:
                return LATEX.of(found)
        if not x.is_real():
            raise UsageError(f"{method.name} is complex and has no decimals in LaTeX here")
        return LATEX.of(decimal_of(x, digits or 10))

    lines = [header(method, "latex", Comment("", "% ", ""))]
    if isinstance(method, GLM) and method.multistep is not None:
        lines += ["", *_multistep_array(*method.multistep, cell)]
    given = getattr(method, "abscissae_given", None)
    for n, x in enumerate(method.components):
        A, U, B, V = x.matrices
        plain = (method.additive or method.parts == 1) and len(V) == 1 and is_one(V[0][0])
        c = (given or stage_times(x)) if plain else None
        more = [
            (x, x.weights[n], (*V[0],) if x.values is None else x.values) for x in method.embedded
        ]
        which = (
            f": {'qp'[n]}" if method.parts == 2 else f": part {n + 1}" if method.additive else ""
        )
        lines += ["", f"% {in_comment(method.name)}{which}"]
        lines += _array(A, U, B, V, c, more, cell)
    return "\n".join(lines) + "\n"


def _multistep_array(alpha: Vector, beta: Vector, cell: Callable[[Scalar], str]) -> list[str]:
    """Return coefficients of a multistep method as in a book, that of the new value last."""
    lines = ["% sum alpha_m y_(n+m) = h sum beta_m f_(n+m); below as a general linear method"]
    lines.append(rf"\begin{{array}}{{c|{'c' * len(alpha)}}}")
    for name, row in ((r"\alpha_m", alpha), (r"\beta_m", beta)):
        lines.append(f"  {name} & " + " & ".join(map(cell, row)) + r" \\")
    return [*lines, r"\end{array}"]


def _array(
    A: Matrix, U: Matrix, B: Matrix, V: Matrix, c: Vector | None,
    more: Sequence[tuple[EmbeddedRow, Vector, Vector]], cell: Callable[[Scalar], str],
) -> list[str]:  # fmt: skip
    """Return one tableau: c | A over b for a Runge-Kutta method, [A U; B V] for others.

    Embedded rows follow.
    """

    def row(*parts: Sequence[Scalar]) -> str:
        return "  " + " & ".join(cell(x) for part in parts for x in part) + r" \\"

    def weights(b: Vector, v: Vector) -> str:
        return row(b, v) if c is None else "  & " + row(b).strip()

    if c is None:
        lines = [rf"\left[\begin{{array}}{{{'c' * len(A[0])}|{'c' * len(U[0])}}}"]
        lines += [row(a, u) for a, u in zip(A, U, strict=True)]
    else:
        lines = [rf"\begin{{array}}{{c|{'c' * len(A)}}}"]
        lines += [row((x,), line) for x, line in zip(c, A, strict=True)]
    lines += [r"  \hline", *(weights(b, v) for b, v in zip(B, V, strict=True))]
    for x, b, v in more:
        what = "weights of the error estimate" if x.difference else "embedded row"
        lines += [r"  \hline", f"  % {what} {in_comment(x.name)}", weights(b, v)]
    return [*lines, r"\end{array}" + (r"\right]" if c is None else "")]


def _with_digits(write: Callable[[Any, int], str]) -> Callable[[Any, int | None], str]:
    return lambda method, digits: write(method, DIGITS if digits is None else digits)


FORMATS: Mapping[str, Callable[[Any, int | None], str]] = {
    "latex": _latex,
    "sundials": _with_digits(_sundials),
    "petsc": _with_digits(_petsc),
    "diffrax": _with_digits(_diffrax),
    "ordinarydiffeq": _with_digits(_ordinarydiffeq),
    "rungekutta.jl": _with_digits(_rungekutta),
}


def table(method: GLM | PartitionedGLM | AdditiveGLM, target: str, digits: int | None) -> str:
    """Return a method as a table of another package, one of :data:`FORMATS`.

    Decimals have :data:`DIGITS` by default; LaTeX has expressions then.

    Raises
    ------
    UsageError
        When the format cannot hold the method.
    """
    return FORMATS[target](method, digits)
