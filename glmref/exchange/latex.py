"""Expressions of the data's grammar as LaTeX."""

from __future__ import annotations

from ..exact.expression import (
    Exponential,
    Name,
    Negative,
    Node,
    Number,
    Product,
    Root,
    Sum,
    syntax_tree,
)


def latex(text: str) -> str:
    r"""Write an expression such as ``(3-sqrt(3))/6`` as LaTeX: ``\frac{3-\sqrt{3}}{6}``.

    Raises
    ------
    DataError
        For a text that is no expression.
    """
    return _written(syntax_tree(text, exponents=True))


def _written(node: Node) -> str:
    match node:
        case Number(text):
            mantissa, _, power = text.lower().partition("e")
            return rf"{mantissa}\cdot 10^{{{int(power)}}}" if power else text
        case Name(name):
            return r"\pi" if name == "pi" else name
        case Negative(operand):
            return f"-{_factor(operand)}"
        case Sum(terms):
            written = "".join(
                f"{sign}{_factor(term) if n else _written(term)}"
                for n, (sign, term) in enumerate(terms)
            )
            return written.removeprefix("+")
        case Product(factors):
            return _product(factors)
        case Root(radicand, degree):
            return rf"\sqrt{f'[{degree}]' if degree > 2 else ''}{{{_written(radicand)}}}"
        case Exponential(angle):
            return f"e^{{{_written(angle)}}}"


def _product(factors: tuple[tuple[str, Node], ...]) -> str:
    """Write factors from the left; the sign of the first stands before all of them."""
    (_, first), *others = factors
    sign, first = ("-", first.operand) if isinstance(first, Negative) else ("", first)
    written = _written(first) if others[0][0] == "/" else _factor(first)
    for operator, factor in others:
        if operator == "/":
            written = rf"\frac{{{written}}}{{{_written(factor)}}}"
        else:
            # a dot where two numbers, or a number and a fraction, would be read as one
            dot = r"\cdot " if isinstance(factor, Number | Product) else " "
            written = f"{written}{dot}{_factor(factor)}"
    return sign + written


def _factor(node: Node) -> str:
    return rf"\left({_written(node)}\right)" if isinstance(node, Sum | Negative) else _written(node)
