"""Numbers that carry a bound of their rounding error, and what steps of a proof compute with."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from ..exact import Ball, ball
from ..problems.formula import FUNCTIONS


def numbers(mpf: Callable[[Any], Any], **known: Callable[[Any], Any]) -> Any:
    """Return the context of a :class:`.Formula`: its numbers, and the functions that it knows."""
    return SimpleNamespace(mpf=mpf, pi=math.nan, **{**dict.fromkeys(FUNCTIONS), **known})


#: Balls as the context of a formula.
BALLS = numbers(
    ball,
    sqrt=lambda x: ball(x).sqrt(),
    sin=lambda x: Ball.of_real(ball(x).parts()[0].sin()),
)


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


def bounded(context: Any) -> Any:
    """Return :class:`Bounded` numbers over an mpmath context as the context of a formula."""

    def sqrt(x: Bounded) -> Bounded:
        root = context.sqrt(x.value)
        return Bounded(root, x.error / (2 * root) + root)

    def sin(x: Bounded) -> Bounded:
        value = context.sin(x.value)
        return Bounded(value, abs(context.cos(x.value)) * x.error + abs(value))

    return numbers(lambda x: Bounded(context.mpf(x), 0), sqrt=sqrt, sin=sin)
