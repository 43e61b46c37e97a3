"""A number that carries its gradient, so that code written for scalars yields Jacobians.

A :class:`Jet` has the operations of exact numbers and balls and nothing else: any function written
for those, fed jets over balls, returns an enclosure of its value and of its first derivatives
(Moore, Kearfott, Cloud 2009, "Introduction to Interval Analysis", chapter 6).

Derivatives are kept by unknown, those that are the exact zero not at all: a system of a hundred
unknowns is made of numbers that depend on a few. They are flint's own numbers: rationals while
they are rational, balls from then on.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

import flint

from .number import Ball, Exact

#: Derivatives by the number of the unknown; never changed once a jet holds them.
_Row = dict[int, flint.fmpq | flint.acb]

_NIL = flint.acb(0)
_ONE = flint.fmpq(1)
_ZERO, _UNIT = Exact(0), Exact(1)


class Jet:
    """A value and its partial derivatives with respect to n unknowns.

    Made by :func:`jets` and :func:`lift`.
    """

    __slots__ = ("_row", "size", "value")
    value: Exact | Ball
    size: int
    _row: _Row

    @classmethod
    def _make(cls, value: Exact | Ball, size: int, row: _Row) -> Jet:
        self = cls.__new__(cls)
        self.value, self.size, self._row = value, size, row
        return self

    @property
    def gradient(self) -> tuple[Exact | Ball, ...]:
        """(n,) derivatives; exact zeros where nothing depends on the unknown."""
        return tuple(_number(self._row[k]) if k in self._row else _ZERO for k in range(self.size))

    def __add__(self, other: object) -> Any:
        if type(other) is Jet:
            row = dict(self._row)
            _add_to(row, other._row, _UNIT)
            return Jet._make(self.value + other.value, self.size, row)
        if isinstance(other, Exact | Ball | int | Fraction):
            return Jet._make(self.value + other, self.size, self._row)
        return NotImplemented

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet._make(-self.value, self.size, {k: -x for k, x in self._row.items()})

    def __sub__(self, other: object) -> Any:
        if isinstance(other, Jet | Exact | Ball | int | Fraction):
            return self + (-other)
        return NotImplemented

    def __rsub__(self, other: object) -> Any:
        return (-self) + other

    def __mul__(self, other: object) -> Any:
        if type(other) is Jet:
            row: _Row = {}
            _add_to(row, self._row, other.value)
            _add_to(row, other._row, self.value)
            return Jet._make(self.value * other.value, self.size, row)
        if isinstance(other, int | Fraction) and not isinstance(other, bool):
            other = Exact(other)
        if isinstance(other, Exact | Ball):
            return Jet._make(self.value * other, self.size, _scaled(self._row, other))
        return NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other: object) -> Any:
        if type(other) is Jet:
            inverse = Exact(1) / other.value
            quotient = self.value / other.value
            row = _scaled(self._row, inverse)
            _add_to(row, other._row, -(quotient * inverse))
            return Jet._make(quotient, self.size, row)
        if isinstance(other, int | Fraction) and not isinstance(other, bool):
            other = Exact(other)
        if isinstance(other, Exact | Ball):
            row = _scaled(self._row, Exact(1) / other)
            return Jet._make(self.value / other, self.size, row)
        return NotImplemented

    def __rtruediv__(self, other: object) -> Any:
        if not isinstance(other, Exact | Ball | int | Fraction):
            return NotImplemented
        return Jet._make(_ZERO + other, self.size, {}) / self

    @staticmethod
    def sum_of_products(pairs: Iterable[tuple[Any, Any]]) -> Jet:
        """Return the sum of ``x * y`` over jets, exact numbers and balls, with one jet at least."""
        value: Any = _ZERO
        row: _Row = {}
        size = 0
        for x, y in pairs:
            a, b = x, y
            if type(x) is Jet:
                size, a = x.size, x.value
            if type(y) is Jet:
                size, b = y.size, y.value
                _add_to(row, y._row, a)
            if type(x) is Jet:
                _add_to(row, x._row, b)
            value = value + a * b
        return Jet._make(value, size, row)

    def sqrt(self) -> Jet:
        """Return the principal square root."""
        root = self.value.sqrt()
        return Jet._make(root, self.size, _scaled(self._row, Exact(1) / (root * 2)))

    def conjugate(self) -> Jet:
        """Return the complex conjugate (the unknowns are real)."""
        row = {
            k: flint.acb(x.real, -x.imag) if isinstance(x, flint.acb) else x
            for k, x in self._row.items()
        }
        return Jet._make(self.value.conjugate(), self.size, row)

    def vanishes(self) -> bool:
        """Return whether the value and every derivative are exact zeros."""
        # "not !=" would not do: balls that overlap are neither equal nor unequal
        return self.value.vanishes() and all(x == _NIL for x in self._row.values())

    def is_zero(self) -> bool | None:
        """Return ``True`` only where the value and every derivative are exact zeros."""
        answer = self.value.is_zero()
        if answer is True and self.vanishes():
            return True
        return False if answer is False else None

    def is_real(self) -> bool:
        """Return whether the value and its derivatives are real."""
        return self.value.is_real() and all(_number(x).is_real() for x in self._row.values())

    def __repr__(self) -> str:
        return f"Jet({self.value!r}, n={self.size})"


def _number(x: flint.fmpq | flint.acb) -> Exact | Ball:
    return Ball._wrap(x) if isinstance(x, flint.acb) else Exact(x)


def _scaled(row: _Row, factor: Exact | Ball) -> _Row:
    """Return the derivatives times a number, as a new dictionary."""
    result: _Row = {}
    _add_to(result, row, factor)
    return result


def _add_to(total: _Row, row: _Row, factor: Exact | Ball) -> None:
    """Add a multiple of derivatives to those of a dictionary that is still one's own."""
    if not row:
        return
    q = factor._q if type(factor) is Exact else None
    if factor is _UNIT or (q is not None and q == 1):
        for k, x in row.items():
            total[k] = total[k] + x if k in total else x
        return
    c = factor.ball()._acb
    if c == _NIL:
        return
    for k, x in row.items():
        if q is not None and type(x) is flint.fmpq:
            y = x * q
        else:
            y = c if x is _ONE else x * c
        total[k] = total[k] + y if k in total else y


def jets(values: Sequence[Exact | Ball]) -> list[Jet]:
    """Turn values into the coordinates of their space: jet i has the i-th unit gradient."""
    size = len(values)
    return [Jet._make(x, size, {i: _ONE}) for i, x in enumerate(values)]


def lift(value: Any, size: int) -> Jet:
    """Turn a constant into a jet of ``size`` unknowns; a jet is returned as it is."""
    return value if isinstance(value, Jet) else Jet._make(_ZERO + value, size, {})
