"""Weights of compositions: lists that sum to 1, read the same backwards, beside words that say so.

A step h of a symmetric method of order 2 is replaced by steps w_1 h, .., w_m h. With the sum 1 and
a palindrome the composition has order 4 exactly if the sum of the w_i^3 is 0 (Suzuki 1990; Yoshida
1990). The base method of each code is another one; it is represented by Störmer's method, on which
the order conditions are those of any symmetric base of order 2.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise

from ..exact import Exact
from .table import Table
from .values import Number, literal

#: What names such weights, at most :data:`_ABOVE` lines above them.
_WORDS = re.compile(r"suzuki|yoshida|(?<![a-z])(?:sy|ys)_|composition_?weights", re.IGNORECASE)
_ABOVE = 14
_NAME = re.compile(r"(?:\w*(?:suzuki|yoshida)\w*|\b(?:sy|ys)_\w+|\w+_(?:sy|ys)_\w+)", re.IGNORECASE)
_NUMBER = r"[-+]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d{1,4})?"
_LIST = re.compile(rf"[\[{{]\s*({_NUMBER}(?:\s*,\s*{_NUMBER})+)\s*,?\s*[\]}}]")
#: Digits of printed weights that sum to 1.
_SUM = 1e-9


def compositions(text: str) -> Iterator[Table]:
    """Yield each list of three weights or more as a splitting, with the line where it begins."""
    lines = text.splitlines()
    lists: list[tuple[int, list[Number], list[float]]] = []
    for found in _LIST.finditer(text):
        weights = [literal(x) for x in re.findall(_NUMBER, found[1])]
        values = [complex(x.value).real for x in weights]
        palindrome = all(abs(x - y) < _SUM for x, y in zip(values, reversed(values), strict=True))
        if len(values) >= 3 and palindrome and abs(sum(values) - 1) <= _SUM:
            lists.append((text.count("\n", 0, found.start()) + 1, weights, values))
    tables = [of_weights("", line, weights) for line, weights, _ in lists]
    drifts = [[complex(x.value).real for x in made.b[0]] for made in tables]  # listed, too
    for table, own, (line, _, values) in zip(tables, drifts, lists, strict=True):
        if any(_alike(values, x) for x in drifts):
            continue
        beside = [
            x for n, _, x in lists if abs(n - line) < _ABOVE and abs(len(x) - len(values)) == 1
        ]
        if any(not _alike(x, own) for x in beside):  # steps of two flows
            continue
        near = lines[max(0, line - 1 - _ABOVE) : line]
        if not any(map(_WORDS.search, near)):
            continue
        names = [x for row in reversed(near) for x in _NAME.findall(row)]
        table.name = f"{names[0] if names else 'weights'}, {len(values)}"
        yield table


def _alike(x: list[float], y: list[float]) -> bool:
    return len(x) == len(y) and all(abs(u - v) < _SUM for u, v in zip(x, y, strict=True))


def of_weights(name: str, line: int, weights: list[Number]) -> Table:
    """Return Störmer's method composed with weights: half a drift, a kick, half a drift each."""
    half = [weights[0].of(x.value / 2, x) for x in weights]
    drifts = [half[0], *(x.of(x.value + y.value, y) for x, y in pairwise(half)), half[-1]]
    kicks = [*weights, Number(Exact(0))]
    return Table(name, line, "composition", b=[drifts, kicks])
