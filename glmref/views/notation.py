"""Expressions of the data's grammar in another notation: LaTeX here, MathML for pages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..exact.expression import syntax_tree
from ..judge.grammar import (
    Exponential,
    Expression,
    Name,
    Negative,
    Numeral,
    Product,
    Root,
    Sum,
)


@dataclass(frozen=True)
class Notation:
    """How a notation writes what an expression is made of; ``{}`` stand for the parts."""

    #: What stands for a numeral and for a name.
    number: Callable[[str], str]
    name: Callable[[str], str]
    plus: str
    minus: str
    #: Between factors that would be read as one without a dot, and between others.
    dot: str
    times: str
    group: str
    fraction: str
    square_root: str
    root: str
    exponential: str

    def of(self, text: str) -> str:
        """Write an expression.

        Raises
        ------
        DataError
            For a text that is no expression.
        """
        return self._written(syntax_tree(text, exponents=True))

    def _written(self, node: Expression) -> str:
        match node:
            case Numeral(text):
                return self.number(text)
            case Name(name):
                return self.name(name)
            case Negative(operand):
                return self.minus + self._factor(operand)
            case Sum(terms):
                (_, first), *others = terms
                signs = {"+": self.plus, "-": self.minus}
                rest = (signs[sign] + self._factor(x) for sign, x in others)
                return self._written(first) + "".join(rest)
            case Product(factors):
                return self._product(factors)
            case Root(radicand, "2"):
                return self.square_root.format(self._written(radicand))
            case Root(radicand, degree):
                return self.root.format(self._written(radicand), degree)
            case Exponential(angle):
                return self.exponential.format(self._written(angle))
        raise AssertionError(node)

    def _product(self, factors: tuple[tuple[str, Expression], ...]) -> str:
        """Write factors from the left; the sign of the first stands before all of them."""
        (_, first), *others = factors
        sign, first = (self.minus, first.operand) if isinstance(first, Negative) else ("", first)
        written = self._written(first) if others[0][0] == "/" else self._factor(first)
        for operator, factor in others:
            if operator == "/":
                written = self.fraction.format(written, self._written(factor))
            else:
                dot = self.dot if isinstance(factor, Numeral | Product) else self.times
                written += dot + self._factor(factor)
        return sign + written

    def _factor(self, node: Expression) -> str:
        written = self._written(node)
        return self.group.format(written) if isinstance(node, Sum | Negative) else written


def _power_of_ten(text: str) -> str:
    mantissa, _, power = text.lower().partition("e")
    return rf"{mantissa}\cdot 10^{{{int(power)}}}" if power else text


#: As in ``\\frac{3-\\sqrt{3}}{6}``.
LATEX = Notation(
    number=_power_of_ten,
    name=lambda name: r"\pi" if name == "pi" else name,
    plus="+",
    minus="-",
    dot=r"\cdot ",
    times=" ",
    group=r"\left({}\right)",
    fraction=r"\frac{{{}}}{{{}}}",
    square_root=r"\sqrt{{{}}}",
    root=r"\sqrt[{1}]{{{0}}}",
    exponential="e^{{{}}}",
)
