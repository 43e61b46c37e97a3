"""Sums of products, where proofs spend their time.

They are what loops over the operators would give, in fewer steps; the enclosures are as narrow.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import flint

from ..system.budget import spend
from .number import Ball, Exact

_NIL = flint.fmpq(0)
_ZERO = Exact(0)


def sum_of_products(pairs: Sequence[tuple[Any, Any]]) -> Any:
    """Return the sum of ``x * y`` over numbers of any kind.

    Returns
    -------
    Any
        Exact where no ball took part, else a ball.
    """
    spend()
    rational, exactly, total = _NIL, None, None
    for x, y in pairs:
        first, second = type(x), type(y)
        if second is Ball:
            if first is Ball:
                product = x._acb * y._acb
            elif first is Exact:
                product = (x._ball or x.ball())._acb * y._acb
            else:
                return _sum_of_others(pairs)
            total = product if total is None else total + product
        elif second is Exact:
            if first is Exact:
                if x._q is not None and y._q is not None:
                    rational += x._q * y._q
                else:
                    exactly = x * y if exactly is None else exactly + x * y
            elif first is Ball:
                product = x._acb * (y._ball or y.ball())._acb
                total = product if total is None else total + product
            else:
                return _sum_of_others(pairs)
        else:
            return _sum_of_others(pairs)
    if exactly is not None:
        rest: Any = exactly + Exact._of(rational)
    elif total is None or rational:
        rest = Exact._of(rational)
    else:
        return Ball._wrap(total)
    return rest if total is None else Ball._wrap(total) + rest


def _sum_of_others(pairs: Sequence[tuple[Any, Any]]) -> Any:
    """Return the same where a number takes part that is neither exact nor a ball."""
    total: Any = _ZERO
    for x, y in pairs:
        total = total + x * y
    return total
