"""Runs of many steps in 60 digits: numbers are whole multiples of 2^-256, Python's own.

The stages of a step are found in doubles first. Newton's method with the matrix in doubles then
gains fifteen digits with each evaluation of the right-hand side, three in all. Tableau and step
size are rounded once. A step takes a tenth to half a millisecond, one of the reference engine 10 to
70.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from math import isqrt
from typing import Any

import mpmath
import numpy as np
from mpmath.libmp.libelefun import cos_sin_fixed, exp_fixed

from glmref.engine.reference import Stepper
from glmref.errors import UsageError
from glmref.problems.derivative import differentiated
from glmref.problems.formula import Formula
from glmref.problems.model import Problem
from glmref.problems.tracing import recorded

BITS = 256
DIGITS = 77
#: Order of the differences that show a parasitic part.
DIFFERENCES = 40
_ONE = 1 << BITS


def rounded(x: Any) -> int:
    """Round a number of a tableau, a fraction or an mpmath number to units."""
    if isinstance(x, int | Fraction):
        return round(Fraction(x) * _ONE)
    with mpmath.workdps(DIGITS + 10):
        number = x.to_mpf() if hasattr(x, "to_mpf") else mpmath.mpf(x)
        return int(mpmath.nint(number * _ONE))


def number(x: int) -> Any:
    """Return so many units as an mpmath number, in the precision that holds."""
    return mpmath.ldexp(mpmath.mpf(x), -BITS)


def _units(x: np.ndarray) -> list[list[int]]:
    """Return doubles as they are, to the last unit."""
    return [[int(a * 2.0**BITS) for a in row] for row in x.tolist()]


def _doubles(x: Sequence[Sequence[int]]) -> np.ndarray:
    """Return the doubles next to numbers, small ones with all their digits."""
    return np.array([[a / _ONE for a in row] for row in x])


# -- right-hand sides ------------------------------------------------------------------------------

_FUNCTIONS: dict[str, Callable[[int], int]] = {
    "sqrt": lambda a: isqrt(a << BITS),
    "sin": lambda a: cos_sin_fixed(a, BITS)[1],  # type: ignore[index]
    "exp": lambda a: exp_fixed(a, BITS),
}


class _InUnits(ast.NodeTransformer):
    """Writes products and quotients of units, and units in place of numbers."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        left = ast.unparse(self.visit(node.left))
        if isinstance(node.op, ast.Pow):
            text, power = left, ast.literal_eval(node.right)
            for _ in range(power - 1):
                text = f"({text} * {left} >> {BITS})"
            return ast.parse(text, mode="eval").body
        right = ast.unparse(self.visit(node.right))
        sign = "+" if isinstance(node.op, ast.Add) else "-"
        if isinstance(node.op, ast.Mult):
            text = f"({left}) * ({right}) >> {BITS}"
        elif isinstance(node.op, ast.Div):
            text = f"(({left}) << {BITS}) // ({right})"
        else:
            text = f"({left}) {sign} ({right})"
        return ast.parse(f"({text})", mode="eval").body

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        return ast.Constant(rounded(Fraction(repr(node.value))))


def in_units(formula: Formula) -> Callable[[Sequence[int]], list[int]]:
    """Return the function of y alone that a formula gives, on whole numbers of units."""
    common, outputs = formula.trees

    def text(tree: ast.expr) -> str:
        return ast.unparse(_InUnits().visit(ast.parse(ast.unparse(tree), mode="eval")))

    lines = [f"{name} = {text(tree)}" for name, tree in common]
    lines.append(f"return [{', '.join(map(text, outputs))}]")
    space: dict[str, Any] = {k: rounded(Fraction(v)) for k, v in formula.parameters.items()}
    space |= _FUNCTIONS
    exec("\n    ".join([f"def function({formula.variables[-1]}):", *lines]), space)
    return space["function"]


# -- steps -----------------------------------------------------------------------------------------

#: Of each row of a matrix, the columns that are not zero and their entries.
_Rows = list[list[tuple[int, int]]]


def _combined(table: Sequence[_Rows], x: Sequence[Sequence[int]], to: Sequence[Any]) -> list[Any]:
    """Return ``to[i][j] + sum_k table[j][i, k] x[k][j]``, table j that of component j."""
    return [
        [row[j] + (sum(a * x[k][j] for k, a in table[j][i]) >> BITS) for j in range(len(row))]
        for i, row in enumerate(to)
    ]


def _sum(x: Sequence[Sequence[int]], y: Sequence[Sequence[int]]) -> list[list[int]]:
    return [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(x, y, strict=True)]


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
        sparse, dense = [], []
        self._filter = np.zeros((len(engine.parts), r, r), dtype=object)
        for n, (c, columns) in enumerate(zip(method.components, engine.parts, strict=True)):
            self.part[columns] = n
            full = []
            for m, scale in zip(c.matrices, (h, 1, h, 1), strict=True):
                rows = [[rounded(x) * scale.numerator // scale.denominator for x in y] for y in m]
                full.append(rows)
            for rows in full[:2]:  # a stage too few is the last one again
                rows += [rows[-1]] * (stages - len(rows))
            for rows in full[2:]:
                rows += [[]] * (r - len(rows))
            A = np.zeros((stages, stages))
            A[:, : len(full[0][0])] = _doubles(full[0])
            dense.append(A)
            sparse.append([[[(k, x) for k, x in enumerate(y) if x] for y in rows] for rows in full])
            self._filter[n, : len(c.V), : len(c.V)] = _filter(np.array(c.V, dtype=float))
        self.tables = [[sparse[n][m] for n in self.part] for m in range(4)]
        self.A = np.array([dense[n] for n in self.part])  # (d, s, s)
        formula = _formula(engine.problem).on(None)
        self.f_double, self.slopes_of = formula, differentiated(formula, d)
        self.f = in_units(formula)
        self.values, self.evaluations = values, 0
        output = np.array(engine.solution(values), dtype=float) / 2.0**BITS
        self.near, self.matrix = np.tile(output, (stages, 1)), np.eye(stages * d)

    def advance(self, count: int) -> None:
        """Take steps.

        Raises
        ------
        UsageError
            Where stages are not found.
        """
        y = self.values.tolist()
        for _ in range(count):
            y = self._stepped(y)
        self.values = np.array(y, dtype=object)

    def _stepped(self, y: list[list[int]]) -> list[list[int]]:
        """Return the values after one step."""
        A, U, B, V = self.tables
        nothing = [[0] * self.near.shape[1]]
        known = _combined(U, y, nothing * len(self.near))
        self._approach(_doubles(known))
        F = self._settled(known, A)
        return _combined(V, y, _combined(B, F, nothing * len(y)))

    def _approach(self, known: np.ndarray) -> None:
        """Find the stages in doubles with the matrix of the step before, then their own matrix."""
        near = self.near
        for _ in range(60):
            F = self.f_double(0.0, near.T)
            step = known - near + np.matmul(self.A, F[..., None])[..., 0].T
            change = (self.matrix @ step.ravel()).reshape(near.shape)
            near += change
            if np.abs(change).max() < 1e-14:
                break
        self.J = self.slopes_of(0.0, near.T)  # (d, d, s)
        system = np.einsum("jik,jlk->ijkl", self.A, self.J).reshape(near.size, near.size)
        self.matrix = np.linalg.inv(np.eye(near.size) - system)

    def _settled(self, known: list[list[int]], A: Sequence[_Rows]) -> list[list[int]]:
        """Return the slopes of the stages, from those in doubles."""
        Y = _units(self.near)
        for turn in range(12):
            F = [self.f(x) for x in Y]
            want = _combined(A, F, known)
            gap = _doubles(_sum(want, [[-x for x in row] for row in Y]))
            change = (self.matrix @ gap.ravel()).reshape(gap.shape)
            Y = _sum(Y, _units(change))
            if np.abs(change).max() < 1e-45:  # it leaves sixteen digits less
                self.evaluations = max(turn + 1, self.evaluations)
                return _sum(F, _units(np.einsum("jlk,kl->kj", self.J, change)))
        raise UsageError("the stages of a step were not found; use a smaller h")

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
