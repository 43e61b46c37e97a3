"""A method whose coefficients are rounded decimals, and the methods that round to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from types import MappingProxyType
from typing import Any

from ..exact import Ball, Exact
from ..exact.decimals import known_digits, rounded_places

#: What belongs to a method besides the coefficients of a step.
_KEPT = frozenset(["name", "claims", "source", "document", "starting", "finishing", "multistep"])


_SMALL = 10_000  # denominators of fractions that a rounded number may stand for


def _entries(value: Any) -> Iterator[Exact]:
    if isinstance(value, Exact):
        yield value
    elif isinstance(value, tuple):
        for x in value:
            yield from _entries(x)
    elif is_dataclass(value):
        for x in fields(value):
            if x.name not in _KEPT:
                yield from _entries(getattr(value, x.name))


def _mapped(value: Any, write: Callable[[Exact], Any]) -> Any:
    if isinstance(value, Exact):
        return write(value)
    if isinstance(value, tuple):
        return tuple(_mapped(x, write) for x in value)
    if is_dataclass(value) and not isinstance(value, type):
        new = {x.name: _mapped(getattr(value, x.name), write) for x in fields(value)
               if x.name not in _KEPT}  # fmt: skip
        return replace(value, **new)
    return value


def _places(x: Exact) -> int:
    value = x.as_fraction()
    return 0 if value is None else rounded_places(value) or 0


def digits_of(method: Any) -> int | None:
    """Return the digits after the point to which the decimals of a method are known, if rounded."""
    return known_digits(map(_places, _entries(method)))


def meant(method: Any) -> tuple[str, str] | None:
    """Return the first rounded decimal that is near a short fraction, and the fraction."""
    for x in _entries(method):
        value = x.as_fraction() if _places(x) else None
        if value is not None:
            near = value.limit_denominator(_SMALL)
            if near != value and abs(near - value) <= abs(value) / 10**14:
                return f"{float(value)!r}", str(near)
    return None


def within_digits(method: Any) -> Any:
    """Return the method with a ball for each rounded decimal, or ``None`` where there is none.

    Its order is that of the methods of which the decimals are roundings, as far as the digits tell.
    """
    digits = digits_of(method)
    if digits is None:
        return None

    def ball(x: Exact) -> Exact | Ball:
        return Ball.decimal(str(x.as_fraction()), digits) if _places(x) else x

    return replace(_mapped(method, ball), document=None, claims=MappingProxyType({}))
