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


def within_digits(method: Any) -> Any:
    """Return the method with a ball for each rounded decimal, or ``None`` where there is none.

    Its order is that of the methods of which the decimals are roundings, as far as the digits tell.

    Parameters
    ----------
    method : Method
        With exact coefficients.
    """
    digits = known_digits(map(_places, _entries(method)))
    if digits is None:
        return None

    def ball(x: Exact) -> Exact | Ball:
        return Ball.decimal(str(x.as_fraction()), digits) if _places(x) else x

    return replace(_mapped(method, ball), document=None, claims=MappingProxyType({}))
