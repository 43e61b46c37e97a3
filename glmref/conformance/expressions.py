"""Right-hand sides as expressions, evaluated over any numbers: floats, mpmath, balls, foreign ones.

The expressions are those of ``data/vectors/problems.json``: whole numbers, + - * /, ``sqrt``,
``sin``, and the names t, y[i], q[i], p[i]. Whole numbers become Fractions, which mix with every
number type used here.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from ..errors import DataError
from ..exact import Ball, ball

_OPERATIONS: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
}


def evaluate(
    texts: Sequence[str],
    names: Mapping[str, Any],
    functions: Mapping[str, Callable[[Any], Any]],
    *,
    number: Callable[[Fraction], Any] = lambda x: x,
) -> list[Any]:
    """Evaluate expressions, one for each component.

    ``names`` holds the values of ``t`` and of the vectors ``y``, ``q``, ``p``, ``functions`` are
    ``sqrt`` and ``sin`` of the number type, and ``number`` turns a Fraction into that type where it
    does not mix with Fractions.

    Raises
    ------
    DataError
        For anything but arithmetic in these names.
    """

    def value(node: ast.expr) -> Any:
        if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
            return _OPERATIONS[type(node.op)](value(node.left), value(node.right))
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return -value(node.operand)
        if isinstance(node, ast.Constant) and type(node.value) is int:
            return number(Fraction(node.value))
        if isinstance(node, ast.Name) and node.id in names:
            return names[node.id]
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
            index = node.slice
            if node.value.id in names and isinstance(index, ast.Constant):
                return names[node.value.id][index.value]
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            function = functions.get(node.func.id)
            if function is not None and len(node.args) == 1:
                return function(value(node.args[0]))
        raise DataError(f"the expression {ast.unparse(node)!r} is not arithmetic in {list(names)}")

    return [value(ast.parse(text, mode="eval").body) for text in texts]


def _ball_sine(x: Any) -> Any:
    """Return the sine of a real ball by its Taylor polynomial, the remainder enclosed.

    After the term of degree n < m the rest is below ``|x|^m / m!``.
    """
    x = ball(x)
    size = Fraction(x.magnitude()).limit_denominator(10**6) + Fraction(1, 10**6)
    term, total, n = x, x, 1
    bound = size
    while bound > Fraction(1, 1 << 500):
        term = term * x * x * Fraction(-1, (n + 1) * (n + 2))
        bound = bound * size * size / ((n + 1) * (n + 2))
        total, n = total + term, n + 2
    return total + Ball.around(ball(0), bound)


BALL_FUNCTIONS: Mapping[str, Callable[[Any], Any]] = {
    "sqrt": lambda x: ball(x).sqrt(),
    "sin": _ball_sine,
}


class Bounded:
    """A number with a first-order bound of its rounding error, in units of the round-off u.

    The error bounds ``|computed - value| / u``.
    """

    __slots__ = ("error", "value")

    def __init__(self, value: Any, error: Any) -> None:
        self.value, self.error = value, error

    @staticmethod
    def of(x: Any) -> Bounded:
        """Return a number; one that is given carries one rounding."""
        return x if isinstance(x, Bounded) else Bounded(x, abs(x))

    @staticmethod
    def _rounded(value: Any, error: Any) -> Bounded:
        return Bounded(value, error + abs(value))

    def __add__(self, other: Any) -> Bounded:
        other = Bounded.of(other)
        return self._rounded(self.value + other.value, self.error + other.error)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Bounded:
        other = Bounded.of(other)
        return self._rounded(self.value - other.value, self.error + other.error)

    def __rsub__(self, other: Any) -> Bounded:
        return Bounded.of(other) - self

    def __mul__(self, other: Any) -> Bounded:
        other = Bounded.of(other)
        error = abs(self.value) * other.error + abs(other.value) * self.error
        return self._rounded(self.value * other.value, error)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Bounded:
        other = Bounded.of(other)
        value = self.value / other.value
        error = self.error / abs(other.value) + abs(value / other.value) * other.error
        return self._rounded(value, error)

    def __rtruediv__(self, other: Any) -> Bounded:
        return Bounded.of(other) / self

    def __neg__(self) -> Bounded:
        return Bounded(-self.value, self.error)


def bounded_functions(context: Any) -> dict[str, Callable[[Any], Any]]:
    """Return ``sqrt`` and ``sin`` of :class:`Bounded` numbers over an mpmath context."""

    def sqrt(x: Bounded) -> Bounded:
        root = context.sqrt(x.value)
        return Bounded(root, x.error / (2 * root) + root)

    def sin(x: Bounded) -> Bounded:
        value = context.sin(x.value)
        return Bounded(value, abs(context.cos(x.value)) * x.error + abs(value))

    return {"sqrt": sqrt, "sin": sin}
