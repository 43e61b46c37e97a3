"""Hamilton's equations from H alone: q' = dH/dp, p' = -dH/dq, and what of them is separable.

The gradient comes from :func:`.derivative.differentiated`; expressions that occur more than once in
it are computed once. H = T(p) + V(q) is recognised from the variables in dH/dp and in dH/dq, and
T = p^T p / 2, for which q'' = -V'(q), from a second derivative that is the identity. Parts of
H = T(p, t) + V(q, t) are kept with time as their last component, see ``Problem.clocked``.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from math import gcd
from typing import Any

from .derivative import differentiated
from .formula import Formula, kept


def equations(H: Formula, half: int) -> dict[str, Any]:
    """Return Hamilton's equations in 2 ``half`` components as entries of :class:`.model.Problem`.

    ``force`` where H = p^T p / 2 + V(q), else ``dq`` and ``dp`` where H = T(p) + V(q), else ``f``.
    Where H depends on t ``f``, and as ``clocked`` the parts of T(p, t) + V(q, t).
    """
    slope = shared(differentiated(shared(H), 2 * half))
    by_p, by_q = slope.outputs[half:], tuple(_minus(text) for text in slope.outputs[:half])
    # names of their own: f has the common subexpressions of both
    velocity, force = taken(slope, by_p, "v"), taken(slope, by_q)
    whole: dict[str, Any] = {"f": replace(taken(slope, by_p + by_q), variables=("t", "y"))}
    if any(i < half for i in velocity.indices) or any(i >= half for i in force.indices):
        return whole
    dp = force.substituted("y", "q", 0)
    matrix = constant_matrix(velocity, half, half)
    if matrix == _identity(half) and _vanishes_at_zero(velocity):
        if timed(H):
            return whole | {"clocked": {"force": _clocked(dp, "q", half, "0")}}
        return {"force": replace(dp, variables=("q",))}
    dq = velocity.substituted("y", "p", -half)
    if timed(H):
        parts = {"dq": _clocked(dq, "p", half, "1"), "dp": _clocked(dp, "q", half, "1")}
        return whole | {"clocked": parts}
    return {"dq": replace(dq, variables=("p",)), "dp": replace(dp, variables=("q",))}


def _identity(half: int) -> list[list[Fraction | None]]:
    return [[Fraction(i == j) for j in range(half)] for i in range(half)]


def _vanishes_at_zero(formula: Formula) -> bool:
    """Return whether a formula is 0 where its vector is: p + 1 has the derivative of p, too."""
    common, outputs = formula.rewritten(lambda vector, index: "0").trees
    values: dict[str, Fraction | None] = {k: Fraction(v) for k, v in formula.parameters.items()}
    for name, tree in common:
        values[name] = _exact(tree, values)
    return all(_exact(tree, values) == 0 for tree in outputs)


def _clocked(part: Formula, vector: str, half: int, slope: str) -> Formula:
    """Return a part with t written as one more component of its vector, of the slope given."""
    found = part.rewritten(kept, {"t": f"{vector}[{half}]"})
    return replace(found, outputs=(*found.outputs, slope), variables=(vector,), shape=(half + 1,))


def timed(formula: Formula) -> bool:
    """Return whether t occurs in a formula."""
    common, outputs = formula.trees
    trees = (*(tree for _, tree in common), *outputs)
    return any(isinstance(n, ast.Name) and n.id == "t" for x in trees for n in ast.walk(x))


def _minus(text: str) -> str:
    tree = ast.parse(text, mode="eval").body
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
        return ast.unparse(tree.operand)
    return "0" if text == "0" else ast.unparse(ast.UnaryOp(ast.USub(), tree))


def taken(formula: Formula, outputs: tuple[str, ...], letter: str = "e") -> Formula:
    """Return the formula with other outputs and only the common subexpressions they need."""
    return shared(replace(formula, outputs=outputs, shape=(len(outputs),)), letter)


def constant_matrix(
    formula: Formula, first: int, columns: int
) -> list[list[Fraction | None]] | None:
    """Return the derivative of a formula by components first, first + 1 ... where it is constant.

    An entry that is constant and not rational (a square root, say) is ``None``, and so is the
    result where some entry is not constant.
    """
    d = first + columns
    jacobian = shared(differentiated(formula, d))
    if jacobian.indices or timed(jacobian):
        return None
    values: dict[str, Fraction | None] = {k: Fraction(v) for k, v in jacobian.parameters.items()}
    for name, tree in jacobian.trees[0]:
        values[name] = _exact(tree, values)
    entries = [_exact(tree, values) for tree in jacobian.trees[1]]
    return [entries[i * d + first : (i + 1) * d] for i in range(len(formula.outputs))]


def rational(formula: Formula) -> Fraction | None:
    """Return the value of an expression in its parameters, ``None`` where it is not rational."""
    values: dict[str, Fraction | None] = {k: Fraction(v) for k, v in formula.parameters.items()}
    return _exact(formula.trees[1][0], values)


def _exact(tree: ast.AST, values: Mapping[str, Fraction | None]) -> Fraction | None:
    """Return the value of a constant expression, ``None`` where it is not rational."""
    if isinstance(tree, ast.Constant):
        return Fraction(repr(tree.value))
    if isinstance(tree, ast.Name):
        return values.get(tree.id)
    if isinstance(tree, ast.UnaryOp):
        inner = _exact(tree.operand, values)
        return None if inner is None else -inner
    if not isinstance(tree, ast.BinOp):
        return None
    left, right = _exact(tree.left, values), _exact(tree.right, values)
    if left is None or right is None:
        return None
    if isinstance(tree.op, ast.Pow):
        return left**right.numerator if right.denominator == 1 and (left or right > 0) else None
    if isinstance(tree.op, ast.Div):
        return left / right if right else None
    return {ast.Add: left + right, ast.Sub: left - right, ast.Mult: left * right}[type(tree.op)]


# --- common subexpressions ------------------------------------------------------------------------


def shared(formula: Formula, letter: str = "e") -> Formula:
    """Return the same function with every repeated subexpression computed once.

    Expressions are numbered by value, so that two that read alike are one; a factor in front of a
    quotient of whole numbers is cancelled, as differentiation leaves ``2*x/2`` for ``x``. Names of
    what is computed once begin with ``letter``.
    """
    numbers = _Numbered(letter)
    common, outputs = formula.trees
    for name, tree in common:
        numbers.names[name] = numbers.of(tree)
    found = [numbers.of(tree) for tree in outputs]
    numbers.count(found)
    texts = [numbers.text(k) for k in found]
    return replace(formula, outputs=tuple(texts), common=tuple(numbers.common))


class _Numbered:
    """Expressions by value number."""

    def __init__(self, letter: str) -> None:
        self.letter = letter
        self.trees: list[ast.expr] = []
        self.parts: list[tuple[int, ...]] = []
        self.known: dict[Any, int] = {}
        self.names: dict[str, int] = {}
        self.uses: dict[int, int] = {}
        self.common: list[tuple[str, str]] = []
        self.written: dict[int, ast.expr] = {}

    def of(self, tree: ast.expr) -> int:
        """Return the number of an expression's value."""
        if isinstance(tree, ast.Name) and tree.id in self.names:
            return self.names[tree.id]
        if isinstance(tree, ast.Name | ast.Constant | ast.Subscript):
            return self._number(ast.dump(tree), tree, ())
        if isinstance(tree, ast.UnaryOp):
            parts: tuple[int, ...] = (self.of(tree.operand),)
            return self._number(("-", parts), tree, parts)
        if isinstance(tree, ast.Call):
            parts = tuple(self.of(x) for x in tree.args)
            return self._number((ast.unparse(tree.func), parts), tree, parts)
        assert isinstance(tree, ast.BinOp)
        if isinstance(tree.op, ast.Div):
            tree = _cancelled(tree)
            if not isinstance(tree, ast.BinOp):
                return self.of(tree)
        parts = (self.of(tree.left), self.of(tree.right))
        return self._number((type(tree.op).__name__, parts), tree, parts)

    def _number(self, key: Any, tree: ast.expr, parts: tuple[int, ...]) -> int:
        if key not in self.known:
            self.known[key] = len(self.trees)
            self.trees.append(tree)
            self.parts.append(parts)
        return self.known[key]

    def count(self, outputs: list[int]) -> None:
        """Count how often each value is used by other values and by the outputs."""
        todo = list(outputs)
        while todo:
            k = todo.pop()
            self.uses[k] = self.uses.get(k, 0) + 1
            if self.uses[k] == 1:
                todo.extend(self.parts[k])

    def text(self, k: int) -> str:
        """Return the expression of a value, with names for those used more than once."""
        return ast.unparse(self._tree(k))

    def _tree(self, k: int) -> ast.expr:
        if k in self.written:
            return self.written[k]
        tree, parts = self.trees[k], [self._tree(j) for j in self.parts[k]]
        if isinstance(tree, ast.UnaryOp):
            tree = ast.UnaryOp(tree.op, parts[0])
        elif isinstance(tree, ast.Call):
            tree = ast.Call(tree.func, parts, [])
        elif isinstance(tree, ast.BinOp):
            tree = ast.BinOp(parts[0], tree.op, parts[1])
        if self.uses.get(k, 0) > 1 and isinstance(tree, ast.BinOp | ast.Call):
            name = f"{self.letter}{len(self.common)}_"
            self.common.append((name, ast.unparse(tree)))
            tree = ast.Name(name, ast.Load())
        self.written[k] = tree
        return tree


def _cancelled(tree: ast.BinOp) -> ast.expr:
    """``m*x*y/n`` for whole numbers m and n in lowest terms."""
    right, factors, left = tree.right, [], tree.left
    while isinstance(left, ast.BinOp) and isinstance(left.op, ast.Mult):
        factors.append(left.right)
        left = left.left
    if not all(isinstance(x, ast.Constant) and isinstance(x.value, int) for x in (left, right)):
        return tree
    assert isinstance(left, ast.Constant) and isinstance(right, ast.Constant)
    m, n = left.value, right.value
    assert isinstance(m, int) and isinstance(n, int)
    if not factors or n <= 0 or gcd(m, n) == 1:
        return tree
    m, n = m // gcd(m, n), n // gcd(m, n)
    top: ast.expr = ast.Constant(m) if m != 1 else factors.pop()
    while factors:
        top = ast.BinOp(top, ast.Mult(), factors.pop())
    return top if n == 1 else ast.BinOp(top, ast.Div(), ast.Constant(n))
