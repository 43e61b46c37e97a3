"""Runs of many steps in 60 digits: numbers are whole multiples of 2^-256, five words each.

The stages of a step are found in doubles first. Newton's method with the matrix in doubles then
gains fifteen digits with each evaluation of the right-hand side, three in all. Tableau and step
size are rounded once. A step takes 10 to 150 microseconds, one of the reference engine 10 to 70
milliseconds.
"""

from __future__ import annotations

import ast
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from math import factorial
from typing import Any

import mpmath
import numpy as np
from llvmlite import ir
from numba import float64, int64, njit
from numba.core import cgutils, types
from numba.extending import intrinsic

from glmref.engine.reference import Stepper
from glmref.errors import UsageError
from glmref.problems.derivative import differentiated
from glmref.problems.formula import Formula, functions
from glmref.problems.model import Problem
from glmref.problems.tracing import recorded

WORDS, BITS = 5, 256
DIGITS = 77
#: Order of the differences that show a parasitic part.
DIFFERENCES = 40
_WIDE = types.UniTuple(types.int64, WORDS)
Words = tuple[int, ...]


def words(x: int) -> Words:
    """Return a whole number of units as signed words, the lowest first."""
    low = [(x >> 64 * k) & (2**64 - 1) for k in range(WORDS)]
    return tuple(w - (w >> 63 << 64) for w in low)


def units(given: Any) -> int:
    """Return the whole number of units that words make."""
    *low, top = (int(w) for w in given)
    return sum((w & (2**64 - 1)) << 64 * k for k, w in enumerate(low)) + (top << 64 * (WORDS - 1))


def rounded(x: Any) -> int:
    """Round a number of a tableau, a fraction or an mpmath number to units."""
    if isinstance(x, int | Fraction):
        return round(Fraction(x) * 2**BITS)
    with mpmath.workdps(DIGITS + 10):
        number = x.to_mpf() if hasattr(x, "to_mpf") else mpmath.mpf(x)
        return int(mpmath.nint(number * 2**BITS))


def number(x: int) -> Any:
    """Return so many units as an mpmath number, in the precision that holds."""
    return mpmath.ldexp(mpmath.mpf(x), -BITS)


def _array(table: Any) -> np.ndarray:
    """Return numbers as words: one axis more."""
    flat = np.array([words(x) for x in np.ravel(np.array(table, dtype=object))], dtype=np.int64)
    return flat.reshape(*np.shape(table), WORDS)


# -- arithmetic ------------------------------------------------------------------------------------


def _binary(combine: Any) -> Any:
    """Return an operation on two numbers of five words from one on their LLVM integers."""

    @intrinsic
    def operation(typingctx, a, b):
        def codegen(context, builder, signature, args):
            wide = ir.IntType(64 * WORDS)
            given = [[builder.extract_value(x, k) for k in range(WORDS)] for x in args]
            whole = [
                reduce(
                    builder.or_,
                    [builder.shl(builder.zext(w, wide), wide(64 * k)) for k, w in enumerate(x)],
                )
                for x in given
            ]
            found = combine(builder, given, whole, wide)
            word = ir.IntType(64)
            parts = [builder.trunc(builder.lshr(found, wide(64 * k)), word) for k in range(WORDS)]
            return cgutils.pack_array(builder, parts)

        return _WIDE(_WIDE, _WIDE), codegen

    return operation


def _product(builder: Any, given: Any, whole: Any, wide: Any) -> Any:
    """Multiply column by column; two columns below the last unit are left out."""
    double, sums = ir.IntType(128), ir.IntType(192)
    (a, b), total, found = given, sums(0), wide(0)
    for column in range(2, 2 * WORDS - 1):
        for i in range(max(0, column - WORDS + 1), min(column, WORDS - 1) + 1):
            one = builder.mul(builder.zext(a[i], double), builder.zext(b[column - i], double))
            total = builder.add(total, builder.zext(one, sums))
        if column >= WORDS - 1:
            word = builder.zext(builder.trunc(total, ir.IntType(64)), wide)
            found = builder.or_(found, builder.shl(word, wide(64 * (column - WORDS + 1))))
        total = builder.lshr(total, sums(64))
    for x, other in (whole, whole[::-1]):  # a negative factor was read as itself plus 2^320
        negative = builder.icmp_signed("<", x, wide(0))
        excess = builder.select(negative, builder.shl(other, wide(64)), wide(0))
        found = builder.sub(found, excess)
    return found


_add = _binary(lambda builder, given, whole, wide: builder.add(*whole))
_sub = _binary(lambda builder, given, whole, wide: builder.sub(*whole))
_mul = _binary(_product)

_ZERO, _ONE, _TWO, _THREE, _FOUR, _HALF = (
    words(rounded(Fraction(x))) for x in (0, 1, 2, 3, 4, Fraction(1, 2))
)
_SIN = _array([rounded(Fraction((-1) ** k, factorial(2 * k + 1))) for k in range(22)])
_EXP = _array([rounded(Fraction(1, factorial(k))) for k in range(32)])
_PART, _BINARY = words(rounded(Fraction(1, 81))), words(rounded(Fraction(1, 256)))


@njit
def add(a, b):
    """Return a + b."""
    return _add(a, b)


@njit
def sub(a, b):
    """Return a - b."""
    return _sub(a, b)


@njit
def mul(a, b):
    """Return a b."""
    return _mul(a, b)


@njit
def load(x, k):
    """Return an entry of an array of words."""
    return (x[k, 0], x[k, 1], x[k, 2], x[k, 3], x[k, 4])


@njit
def store(x, k, a):
    """Set an entry of an array of words."""
    x[k, 0], x[k, 1], x[k, 2], x[k, 3], x[k, 4] = a


@njit
def to_double(a):
    """Return the double next to a number, small ones with all their digits."""
    negative = a[4] < 0
    if negative:
        a = sub(_ZERO, a)
    found = 0.0
    for k in range(4, -1, -1):
        found += float64(np.uint64(a[k])) * 2.0 ** (64 * (k - 4))
    return -found if negative else found


@njit
def from_double(x):
    """Return a double as it is, to the last unit."""
    rest, scale = abs(x), 1.0
    found = np.zeros((1, 5), np.int64)
    for k in range(4, -1, -1):
        whole = np.floor(rest * scale)
        # halves, since words are signed
        high = int64(np.floor(whole / 4294967296.0))
        found[0, k] = (high << 32) | int64(whole - high * 4294967296.0)
        rest -= whole / scale
        scale *= 18446744073709551616.0
    a = load(found, 0)
    return sub(_ZERO, a) if x < 0 else a


@njit
def div(a, b):
    """Return a / b."""
    y = from_double(1.0 / to_double(b))
    for _ in range(4):
        y = add(y, mul(y, sub(_ONE, mul(b, y))))
    return mul(a, y)


@njit
def sqrt(a):
    """Return the square root."""
    y = from_double(1.0 / np.sqrt(to_double(a)))
    for _ in range(4):
        y = add(y, mul(mul(y, _HALF), sub(_ONE, mul(a, mul(y, y)))))
    return mul(a, y)


@njit
def _horner(table, x):
    total = load(table, len(table) - 1)
    for k in range(len(table) - 2, -1, -1):
        total = add(load(table, k), mul(total, x))
    return total


@njit
def sin(a):
    """Return the sine, of a third of a third.. first."""
    x = mul(a, _PART)
    s = mul(x, _horner(_SIN, mul(x, x)))
    for _ in range(4):
        s = mul(s, sub(_THREE, mul(_FOUR, mul(s, s))))
    return s


@njit
def exp(a):
    """Return the exponential, of a half of a half.. first."""
    e = _horner(_EXP, mul(a, _BINARY))
    for _ in range(8):
        e = mul(e, e)
    return e


_CALLS: dict[Any, str] = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "div"}
_KNOWN = {x.__name__: x for x in (add, sub, mul, div, sqrt, sin, exp, load, store)}


class _Calls(ast.NodeTransformer):
    """Writes calls in place of operators, and names in place of numbers."""

    def __init__(self) -> None:
        self.numbers: dict[str, Words] = {"zero": _ZERO}

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        left = self.visit(node.left)
        if isinstance(node.op, ast.Pow):
            power = ast.literal_eval(node.right)
            product = "mul(" * (power - 1) + ast.unparse(left)
            return ast.parse(product + f", {ast.unparse(left)})" * (power - 1), mode="eval").body
        return ast.Call(ast.Name(_CALLS[type(node.op)]), [left, self.visit(node.right)], [])

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        return ast.Call(ast.Name("sub"), [ast.Name("zero"), self.visit(node.operand)], [])

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return ast.Call(ast.Name("load"), [node.value, node.slice], [])

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        name = f"number_{len(self.numbers)}"
        self.numbers[name] = words(rounded(Fraction(repr(node.value))))
        return ast.Name(name)


#: By the text of a formula: a function takes seconds to compile.
_COMPILED: dict[tuple[str, bool], Any] = {}


def compiled(formula: Formula, *, wide: bool = True) -> Any:
    """Return ``function(t, y, out)`` on arrays of words, (d, 5), or of doubles, for a formula."""
    key = repr(formula), wide
    if key not in _COMPILED:
        _COMPILED[key] = njit(_function(formula, wide))
    return _COMPILED[key]


def _function(formula: Formula, wide: bool) -> Any:
    common, outputs = formula.trees
    calls = _Calls()

    def text(tree: ast.expr) -> str:
        return ast.unparse(calls.visit(ast.parse(ast.unparse(tree), mode="eval")) if wide else tree)

    lines = [f"{name} = {text(tree)}" for name, tree in common]
    put = "store(out, {}, {})" if wide else "out[{}] = {}"
    lines += [put.format(i, text(tree)) for i, tree in enumerate(outputs)]
    number = (lambda x: words(rounded(Fraction(x)))) if wide else float
    space: dict[str, Any] = {k: number(v) for k, v in formula.parameters.items()}
    space |= {**_KNOWN, **calls.numbers} if wide else functions()
    arguments = ", ".join((*formula.variables, "out"))
    exec("\n    ".join([f"def function({arguments}):", *lines]), space)
    return space["function"]


# -- steps -----------------------------------------------------------------------------------------


@njit
def _sums(table, x, part, total):
    """Add to ``total[i, j]`` the sum over k of ``table[part[j], i, k] x[k, j]``."""
    for i in range(total.shape[0]):
        for j in range(total.shape[1]):
            some = load(total[i], j)
            for k in range(x.shape[0]):
                a = load(table[part[j], i], k)
                if a != _ZERO:
                    some = add(some, mul(a, load(x[k], j)))
            store(total[i], j, some)


@njit
def _inverse(m):
    """Return the inverse of a matrix near to the identity."""
    n = len(m)
    both = np.concatenate((m, np.eye(n)), axis=1)
    for k in range(n):
        both[k] /= both[k, k]
        for i in range(n):
            factor = both[i, k]
            if i != k and factor != 0.0:
                both[i] -= factor * both[k]
    return both[:, n:].copy()


@njit
def _times(matrix, x):
    """Return the product of a matrix with stages (s, d) in a row."""
    flat, found = x.ravel(), np.zeros(x.size)
    for i in range(len(flat)):
        for k in range(len(flat)):
            found[i] += matrix[i, k] * flat[k]
    return found.reshape(x.shape)


@njit
def _near(f, A, part, known, near, matrix):
    """Find the stages in doubles, in place, with the matrix of the step before."""
    F, r = np.empty_like(near), np.empty_like(near)
    for _ in range(60):
        for i in range(len(near)):
            f(0.0, near[i], F[i])
        for i, j in np.ndindex(near.shape):
            r[i, j] = to_double(load(known[i], j)) - near[i, j]
            for k in range(len(near)):
                r[i, j] += A[part[j], i, k] * F[k, j]
        change = _times(matrix, r)
        near += change
        if np.max(np.abs(change)) < 1e-14:
            break


@njit
def _linear(slopes_of, A, part, near):
    """Return the derivatives of f at the stages and the inverse of Newton's matrix."""
    s, d = near.shape
    J, system = np.empty((s, d * d)), np.eye(s * d)
    for k in range(s):
        slopes_of(0.0, near[k], J[k])
        for i, j in np.ndindex(s, d):
            a = A[part[j], i, k]
            if a != 0.0:
                system[i * d + j, k * d : (k + 1) * d] -= a * J[k, j * d : (j + 1) * d]
    return J, _inverse(system)


@njit
def _settle(f, A, part, known, Y, F, J, matrix):
    """Find the stages Y and their slopes F, in place; return the evaluations, 0 for none found."""
    s, d = Y.shape[:2]
    r = np.empty((s, d))
    for turn in range(12):
        for i in range(s):
            f(_ZERO, Y[i], F[i])
        want = known.copy()
        _sums(A, F, part, want)
        for i, j in np.ndindex(s, d):
            r[i, j] = to_double(sub(load(want[i], j), load(Y[i], j)))
        change = _times(matrix, r)
        for i, j in np.ndindex(s, d):
            store(Y[i], j, add(load(Y[i], j), from_double(change[i, j])))
        if np.max(np.abs(change)) < 1e-45:  # it leaves sixteen digits less
            for i, j in np.ndindex(s, d):
                more = 0.0
                for k in range(d):
                    more += J[i, j * d + k] * change[i, k]
                store(F[i], j, add(load(F[i], j), from_double(more)))
            return turn + 1
    return 0


@njit
def _advance(f, f_double, slopes_of, table, doubles, part, y, near, count):
    """Take steps from the values y, (r, d, 5), in place; ``near``, (s, d), are stages in doubles.

    Returns the largest number of evaluations of a step, 0 where stages were not found.
    """
    A, U, B, V = table
    matrix, most = np.eye(near.size), 0
    F, Y = np.empty((*near.shape, 5), np.int64), np.empty((*near.shape, 5), np.int64)
    for _ in range(count):
        known, new = np.zeros_like(Y), np.zeros_like(y)
        _sums(U, y, part, known)
        _near(f_double, doubles, part, known, near, matrix)
        J, matrix = _linear(slopes_of, doubles, part, near)
        for i, j in np.ndindex(near.shape):
            store(Y[i], j, from_double(near[i, j]))
        found = _settle(f, A, part, known, Y, F, J, matrix)
        if found == 0:
            return 0
        most = max(most, found)
        _sums(B, F, part, new)
        _sums(V, y, part, new)
        y[:] = new
    return most


class Run:
    """A method on a problem of expressions in y alone, from given values with one step size.

    Attributes
    ----------
    values : np.ndarray
        (r, d) whole numbers of units.
    evaluations : int
        The largest number of evaluations of the right-hand side at a stage in one step.
    """

    def __init__(self, engine: Stepper, h: Fraction, values: np.ndarray) -> None:
        method, (r, d) = engine.method, engine.shape
        stages = max(len(c.A) for c in method.components)
        self.part = np.zeros(d, dtype=np.int64)
        tables: list[list[Any]] = [[], [], [], []]
        self._filter = np.zeros((len(engine.parts), r, r), dtype=object)
        for n, (c, columns) in enumerate(zip(method.components, engine.parts, strict=True)):
            self.part[columns] = n
            scales, shapes = (h, 1, h, 1), ((stages, stages), (stages, r), (r, stages), (r, r))
            for table, m, scale, shape in zip(tables, c.matrices, scales, shapes, strict=True):
                full = np.zeros(shape, dtype=object)
                for i, row in enumerate(m):
                    full[i, : len(row)] = [
                        rounded(x) * scale.numerator // scale.denominator for x in row
                    ]
                if len(m) and shape[0] == stages:  # a stage too few is the last one again
                    full[len(m) :] = full[len(m) - 1]
                table.append(full)
            self._filter[n, : len(c.V), : len(c.V)] = _filter(np.array(c.V, dtype=float))
        self.A = np.array(tables[0], dtype=float) / 2.0**BITS
        self.tables = tuple(_array(np.array(x)) for x in tables)
        formula = _formula(engine.problem)
        slopes = differentiated(formula, d)
        doubles = (compiled(x, wide=False) for x in (formula, slopes))
        self.functions = compiled(formula), *doubles
        self.values, self.evaluations = values, 0
        output = np.array(engine.solution(values), dtype=float) / 2.0**BITS
        self.near = np.tile(output, (stages, 1))

    def advance(self, count: int) -> None:
        """Take steps.

        Raises
        ------
        UsageError
            Where stages are not found.
        """
        y = _array(self.values)
        f, f_double, slopes = self.functions
        most = _advance(f, f_double, slopes, self.tables, self.A, self.part, y, self.near, count)
        if not most:
            raise UsageError("the stages of a step were not found; use a smaller h")
        self.evaluations = max(most, self.evaluations)
        rows = [[units(x) for x in row] for row in y]
        self.values = np.array(rows, dtype=object)

    def parasitic(self) -> np.ndarray:
        """Return the parasitic part of the values, (r, d): what differences of high order leave.

        They make a part at zeta larger by (zeta - 1)^k and the smooth values smaller by O(h^k).
        """
        kept = self.values.copy(), self.near.copy()
        rows = [kept[0]]
        for _ in range(DIFFERENCES):
            self.advance(1)
            rows.append(self.values.copy())
        self.values, self.near = kept
        for _ in range(DIFFERENCES):
            rows = [b - a for a, b in pairwise(rows)]
        found = np.zeros_like(self.values)
        for j, n in enumerate(self.part):
            found[:, j] = self._filter[n].dot(rows[0][:, j]) >> BITS
        return found

    def purify(self, passes: int = 60) -> None:
        """Subtract the parasitic part, so often that what couples the parts in a step goes too."""
        for _ in range(passes):
            self.values = self.values - self.parasitic()


def _filter(V: np.ndarray) -> np.ndarray:
    """Return the function of V that is 0 at 1 and (zeta - 1)^-k at other eigenvalues, in units."""
    zetas, vectors = np.linalg.eig(V)
    far = np.abs(zetas - 1) > 1e-6
    gains = np.where(far, np.where(far, zetas - 1, 1) ** -float(DIFFERENCES), 0)
    real = np.real(vectors @ np.diag(gains) @ np.linalg.inv(vectors))
    return np.array([[rounded(Fraction(float(x))) for x in row] for row in real], dtype=object)


def _formula(problem: Problem) -> Formula:
    """Return f as expressions; of a force written as a loop these are its operations."""
    if isinstance(problem.f, Formula):
        return problem.f
    body, constants, half = problem.dp.body, problem.dp.constants, problem.dimension // 2

    def f(t, y):
        force = [0] * half
        body(y[:half], constants, force)
        return [*y[half:], *force]

    operations = recorded(f, ("t", "y"), problem.dimension)
    if operations is None:
        raise UsageError(f"{problem.name} is not given by expressions")
    common, outputs = operations
    return Formula(outputs, common)
