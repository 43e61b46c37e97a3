"""Differentiate formulas: the Jacobian comes from the right-hand side, never from a second copy.

Forward mode over the common subexpressions: each of them gets one new common subexpression per
component it depends on, so the cost of the Jacobian stays a small multiple of that of f.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from .formula import Formula

Tree = ast.expr
_ZERO: Tree = ast.Constant(0)
_ONE: Tree = ast.Constant(1)


@dataclass(frozen=True)
class Jacobian:
    """The matrix df_i/dy_j of a formula for f, differentiated on first use."""

    of: Formula
    dimension: int  #: Number of components of y.

    def __call__(self, *arguments: Any) -> Any:
        """Return df/dy at (t, y), shape (d, d)."""
        return self.formula(*arguments)

    def on(self, context: Any) -> Jacobian:
        """Return the same matrix evaluated in an mpmath context."""
        return replace(self, of=self.of.on(context))

    @cached_property
    def formula(self) -> Formula:
        """The derivative as a formula of shape (d, d), row by row."""
        return differentiated(self.of, self.dimension)


def differentiated(formula: Formula, dimension: int) -> Formula:
    """Return the formula of all derivatives by the components of the last variable.

    Its shape is (n, d), or (d,) for the gradient of a scalar.
    """
    common, outputs = formula.trees
    chain: dict[str, dict[int, Tree]] = {}
    new_common: list[tuple[str, str]] = []
    for name, tree in common:
        new_common.append((name, ast.unparse(tree)))
        chain[name] = {}
        for j in range(dimension):
            slope = _derivative(tree, j, chain)
            if slope is _ZERO:
                continue
            bare = slope.operand if isinstance(slope, ast.UnaryOp) else slope
            if not isinstance(bare, ast.Constant):
                new_common.append((f"{name}_{j}", ast.unparse(slope)))
                slope = ast.Name(f"{name}_{j}", ast.Load())
            chain[name][j] = slope
    entries = [ast.unparse(_derivative(x, j, chain)) for x in outputs for j in range(dimension)]
    assert formula.shape is not None
    return replace(
        formula,
        outputs=tuple(entries),
        common=tuple(_used(new_common, entries)),
        shape=(*formula.shape, dimension),
    )


def _used(common: list[tuple[str, str]], outputs: list[str]) -> list[tuple[str, str]]:
    """Drop the common subexpressions that no output needs."""
    needed = {node.id for text in {*outputs} for node in _names(text)}
    kept = []
    for name, text in reversed(common):
        if name in needed:
            needed |= {node.id for node in _names(text)}
            kept.append((name, text))
    return kept[::-1]


def _names(text: str) -> list[ast.Name]:
    return [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)]


def _derivative(tree: Tree, j: int, chain: Mapping[str, Mapping[int, Tree]]) -> Tree:
    """Return the derivative of a checked tree by component j.

    It is ``_ZERO`` itself where it vanishes.
    """
    if isinstance(tree, ast.Constant):
        return _ZERO
    if isinstance(tree, ast.Name):
        return chain.get(tree.id, {}).get(j, _ZERO)
    if isinstance(tree, ast.Subscript):
        assert isinstance(tree.slice, ast.Constant)
        return _ONE if tree.slice.value == j else _ZERO
    if isinstance(tree, ast.UnaryOp):
        return _negative(_derivative(tree.operand, j, chain))
    if isinstance(tree, ast.Call):
        return _call(tree, j, chain)
    assert isinstance(tree, ast.BinOp)
    left, right = tree.left, tree.right
    d_left, d_right = _derivative(left, j, chain), _derivative(right, j, chain)
    if isinstance(tree.op, ast.Add):
        return _sum(d_left, d_right)
    if isinstance(tree.op, ast.Sub):
        return _difference(d_left, d_right)
    if isinstance(tree.op, ast.Mult):
        return _sum(_product(d_left, right), _product(left, d_right))
    if isinstance(tree.op, ast.Div):
        return _difference(_quotient(d_left, right), _quotient(_product(tree, d_right), right))
    return _power(tree, d_left, d_right)


def _power(tree: ast.BinOp, d_base: Tree, d_exponent: Tree) -> Tree:
    """Return the derivative of base**exponent."""
    base, exponent = tree.left, tree.right
    if isinstance(exponent, ast.Constant):
        value = exponent.value
        assert isinstance(value, int | float)
        # decimals as decimals: 2.3 - 1 must be 1.3
        less = value - 1 if isinstance(value, int) else float(Fraction(repr(value)) - 1)
        lower = base if value == 2 else _binary(base, ast.Pow(), ast.Constant(less))
        return _product(_product(ast.Constant(value), lower), d_base)
    lower = _binary(base, ast.Pow(), _binary(exponent, ast.Sub(), _ONE))
    through_base = _product(_product(exponent, lower), d_base)
    through_exponent = _product(_product(tree, _function("log", base)), d_exponent)
    return _sum(through_base, through_exponent)


def _call(tree: ast.Call, j: int, chain: Mapping[str, Mapping[int, Tree]]) -> Tree:
    """Return the derivative of a function of the whitelist."""
    assert isinstance(tree.func, ast.Name)
    name, x = tree.func.id, tree.args[0]
    dx = _derivative(x, j, chain)
    if name == "atan2":
        u = tree.args[1]
        du = _derivative(u, j, chain)
        norm = _sum(_product(x, x), _product(u, u))
        return _quotient(_difference(_product(u, dx), _product(x, du)), norm)
    if dx is _ZERO:
        return _ZERO
    if name == "sqrt":
        return _quotient(dx, _product(ast.Constant(2), tree))
    if name == "log":
        return _quotient(dx, x)
    if name == "tan":
        return _product(_sum(_ONE, _product(tree, tree)), dx)
    if name == "cos":
        return _negative(_product(_function("sin", x), dx))
    return _product(_function({"sin": "cos", "exp": "exp"}[name], x), dx)


def _binary(left: Tree, operation: ast.operator, right: Tree) -> Tree:
    return ast.BinOp(left, operation, right)


def _function(name: str, argument: Tree) -> Tree:
    return ast.Call(ast.Name(name, ast.Load()), [argument], [])


def _negative(x: Tree) -> Tree:
    if x is _ZERO:
        return _ZERO
    if isinstance(x, ast.UnaryOp):
        return x.operand
    return ast.UnaryOp(ast.USub(), x)


def _sum(a: Tree, b: Tree) -> Tree:
    if a is _ZERO:
        return b
    if b is _ZERO:
        return a
    if isinstance(b, ast.UnaryOp):
        return _binary(a, ast.Sub(), b.operand)
    return _binary(a, ast.Add(), b)


def _difference(a: Tree, b: Tree) -> Tree:
    return _sum(a, _negative(b))


def _product(a: Tree, b: Tree) -> Tree:
    if a is _ZERO or b is _ZERO:
        return _ZERO
    if a is _ONE:
        return b
    if b is _ONE:
        return a
    if isinstance(a, ast.UnaryOp):
        return _negative(_product(a.operand, b))
    if isinstance(b, ast.UnaryOp):
        return _negative(_product(a, b.operand))
    return _binary(a, ast.Mult(), b)


def _quotient(a: Tree, b: Tree) -> Tree:
    if a is _ZERO:
        return _ZERO
    if isinstance(a, ast.UnaryOp):
        return _negative(_quotient(a.operand, b))
    return _binary(a, ast.Div(), b)
