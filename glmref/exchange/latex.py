"""Expressions of the data's grammar as LaTeX."""

from __future__ import annotations

import re

__all__ = ["latex"]

_TOKEN = re.compile(r"\s*([0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]+)?|[A-Za-z_]\w*|[-+*/(),])")

_SUM, _PRODUCT, _ATOM = 0, 1, 2


def latex(text: str) -> str:
    r"""Write an expression such as ``(3-sqrt(3))/6`` as LaTeX: ``\frac{3-\sqrt{3}}{6}``."""
    return _Reader(_TOKEN.findall(text)).sum()[0]


class _Reader:
    """Recursive descent; each method returns LaTeX and how tightly it binds."""

    def __init__(self, tokens: list[str]) -> None:
        self.tokens, self.at = tokens, 0

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self) -> str:
        self.at += 1
        return self.tokens[self.at - 1]

    def sum(self) -> tuple[str, int]:
        value, binds = self.product()
        while self.peek() in ("+", "-"):
            value, binds = value + self.take() + self.product()[0], _SUM
        return value, binds

    def product(self) -> tuple[str, int]:
        value, binds = self.factor()
        while self.peek() in ("*", "/"):
            if self.take() == "/":
                below = self.factor()[0]
                sign = "-" if value.startswith("-") and binds != _SUM else ""
                value, binds = rf"{sign}\frac{{{value.removeprefix(sign)}}}{{{below}}}", _PRODUCT
            else:
                right = self.factor()
                value = f"{_in(value, binds)}{_times(right[0])}{_in(*right)}"
                binds = _PRODUCT
        return value, binds

    def factor(self) -> tuple[str, int]:
        if self.peek() in ("+", "-"):
            sign = self.take()
            inner = self.factor()
            return ("-" if sign == "-" else "") + _in(*inner), _PRODUCT
        return self.atom()

    def atom(self) -> tuple[str, int]:
        token = self.take()
        if token == "(":
            value = self.sum()
            self.take()
            return value
        if token in ("sqrt", "root", "exp"):
            self.take()
            inside = self.sum()[0]
            degree = ""
            if self.take() == ",":
                degree = self.take()
                self.take()
            if token == "exp":
                return f"e^{{{inside}}}", _ATOM
            return rf"\sqrt{f'[{degree}]' if degree else ''}{{{inside}}}", _ATOM
        if "e" in token and token[0].isdigit():
            mantissa, _, power = token.partition("e")
            return rf"{mantissa}\cdot 10^{{{int(power)}}}", _PRODUCT
        return (rf"\{token}" if token == "pi" else token), _ATOM


def _in(text: str, binds: int) -> str:
    """A factor, in parentheses where it is a sum."""
    return rf"\left({text}\right)" if binds == _SUM else text


def _times(right: str) -> str:
    """What stands between factors: a dot before a digit or a sign."""
    return r"\cdot " if right[:1].isdigit() or right[:1] == "-" else " "
