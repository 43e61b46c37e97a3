"""A number that carries its gradient, so that code written for scalars yields Jacobians.

A :class:`Jet` has the operations of :mod:`glmref.exact` and nothing else: any function written for
exact numbers or balls, fed jets over balls, returns an enclosure of its value and of its first
derivatives (Moore, Kearfott, Cloud 2009, "Introduction to Interval Analysis", chapter 6).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from ..exact import Ball, Exact, Scalar

__all__ = ["Jet", "jets", "lift"]

_ZERO = Exact(0)


class Jet:
    """A value and its partial derivatives with respect to n unknowns.

    Attributes
    ----------
        value: the number.
        gradient: (n,) derivatives; exact zeros where nothing depends on the unknown.
    """

    __slots__ = ("gradient", "value")

    def __init__(self, value: Scalar, gradient: tuple[Scalar, ...]) -> None:
        self.value, self.gradient = value, gradient

    def __add__(self, other: object) -> Any:
        if isinstance(other, Jet):
            return Jet(
                self.value + other.value,
                _merge(self.gradient, other.gradient, lambda a, b: a + b),
            )
        if isinstance(other, Exact | Ball | int | Fraction):
            return Jet(self.value + other, self.gradient)
        return NotImplemented

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet(-self.value, tuple(x if x.is_zero() is True else -x for x in self.gradient))

    def __pos__(self) -> Jet:
        return self

    def __sub__(self, other: object) -> Any:
        return (
            self + (-other)
            if isinstance(other, Jet | Exact | Ball | int | Fraction)
            else NotImplemented
        )  # type: ignore[operator]

    def __rsub__(self, other: object) -> Any:
        return (-self) + other

    def __mul__(self, other: object) -> Any:
        if isinstance(other, Jet):
            left, right = self.value, other.value
            return Jet(
                left * right,
                tuple(
                    _term(a, right) + _term(b, left)
                    if not (a.is_zero() is True or b.is_zero() is True)
                    else (_term(a, right) if b.is_zero() is True else _term(b, left))
                    for a, b in zip(self.gradient, other.gradient, strict=True)
                ),
            )
        if isinstance(other, Exact | Ball | int | Fraction):
            return Jet(
                self.value * other,
                tuple(x if x.is_zero() is True else x * other for x in self.gradient),
            )
        return NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other: object) -> Any:
        if isinstance(other, Jet):
            quotient = self.value / other.value
            gradient = _merge(
                self.gradient,
                tuple(x if x.is_zero() is True else -(x * quotient) for x in other.gradient),
                lambda a, b: a + b,
            )
            return Jet(
                quotient,
                tuple(x if x.is_zero() is True else x / other.value for x in gradient),
            )
        if isinstance(other, Exact | Ball | int | Fraction):
            return Jet(
                self.value / other,
                tuple(x if x.is_zero() is True else x / other for x in self.gradient),
            )
        return NotImplemented

    def __rtruediv__(self, other: object) -> Any:
        if not isinstance(other, Exact | Ball | int | Fraction):
            return NotImplemented
        return Jet(_ZERO + other, (_ZERO,) * len(self.gradient)) / self

    def sqrt(self) -> Jet:
        """Principal square root."""
        root = self.value.sqrt()
        return Jet(root, tuple(x if x.is_zero() is True else x / (root * 2) for x in self.gradient))

    def conjugate(self) -> Jet:
        """Complex conjugate (the unknowns are real)."""
        return Jet(self.value.conjugate(), tuple(x.conjugate() for x in self.gradient))

    def is_zero(self) -> bool | None:
        """``True`` only where the value and every derivative are exact zeros."""
        answer = self.value.is_zero()
        if answer is True and all(x.is_zero() is True for x in self.gradient):
            return True
        return False if answer is False else None

    def is_real(self) -> bool:
        """Whether the value and its derivatives are real."""
        return self.value.is_real() and all(x.is_real() for x in self.gradient)

    def __repr__(self) -> str:
        return f"Jet({self.value!r}, n={len(self.gradient)})"


def _term(derivative: Scalar, factor: Scalar) -> Scalar:
    return derivative if derivative.is_zero() is True else derivative * factor


def _merge(
    left: tuple[Scalar, ...],
    right: tuple[Scalar, ...],
    operation: Callable[[Scalar, Scalar], Scalar],
) -> tuple[Scalar, ...]:
    """Combine two gradients, leaving exact zeros alone: they are many."""
    return tuple(
        b if a.is_zero() is True else a if b.is_zero() is True else operation(a, b)
        for a, b in zip(left, right, strict=True)
    )


def jets(values: Sequence[Scalar]) -> list[Jet]:
    """Turn values into the coordinates of their space: jet i has the i-th unit gradient."""
    size = len(values)
    one = Exact(1)
    return [
        Jet(x, tuple(one if i == j else _ZERO for j in range(size))) for i, x in enumerate(values)
    ]


def lift(value: Any, size: int) -> Jet:
    """Turn a constant into a jet of ``size`` unknowns; a jet is returned as it is."""
    return value if isinstance(value, Jet) else Jet(_ZERO + value, (_ZERO,) * size)
