"""Trees by classes at a stage order, and the plan of the principal parts (sections 6.2, 6.3)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from .arithmetic import Fraction
from .linalg import inverse_matrix
from .refusals import require
from .trees import LEAF, Tree, attach, cut, gamma, show, size, trees


@cache
def reduced(t: Tree, q: int) -> tuple[Tree, Fraction]:
    """Return the class of a tree at stage order q, and its factor."""
    children, factor = [], Fraction(1)
    for child in t[1]:
        if 1 < size(child) <= q:
            children += [LEAF] * size(child)
            factor /= gamma(child)
        else:
            below, times_ = reduced(child, q)
            children.append(below)
            factor *= times_
    return (t[0], tuple(sorted(children))), factor


@cache
def classes(n: int, q: int) -> list[Tree]:
    """Return the trees of an order that are their own class."""
    return [t for t in trees((("o", "o"),), n) if reduced(t, q)[0] == t]


@cache
def pairs_of(n: int, q: int) -> list[tuple[Tree, Tree]]:
    """Return the unordered pairs of classes of total order n."""
    return [(t, u) for m in range(1, n // 2 + 1) for i, t in enumerate(classes(m, q))
            for j, u in enumerate(classes(n - m, q)) if m < n - m or i <= j]  # fmt: skip


def spread_of(t: Tree, u: Tree, q: int) -> dict[Tree, Fraction]:
    """Return the coefficients of x(t * u) + x(u * t) in the values of x at the classes."""
    row = {}
    for grown in (attach(t, u), attach(u, t)):
        below, factor = reduced(grown, q)
        row[below] = row.get(below, 0) + factor
    return row


class Span:
    """Independent rows of rationals, by name of the column."""

    def __init__(self) -> None:
        self.rows = {}

    def add(self, row: Mapping) -> bool:
        """Add a row; return whether it was independent of the others."""
        rest = {k: Fraction(x) for k, x in row.items() if x}
        while rest:
            lead = min(rest, key=repr)
            if lead not in self.rows:
                self.rows[lead] = {k: x / rest[lead] for k, x in rest.items()}
                return True
            factor = rest[lead]
            for k, x in self.rows[lead].items():
                rest[k] = rest.get(k, 0) - factor * x
            rest = {k: x for k, x in rest.items() if x}
        return False


@cache
def plan(n: int, q: int, free: tuple[Tree, ...]) -> tuple[list, list, list]:
    """Return (pairs that define zeta_1 at an even order, pairs left over, inverse matrix)."""
    unknown, span, defining, left, rows = classes(n, q), Span(), [], [], []
    for pair in pairs_of(n, q):
        row = spread_of(*pair, q)
        (defining if span.add(row) else left).append(pair)
    for t, u in defining:
        row = spread_of(t, u, q)
        rows.append([row.get(x, Fraction(0)) for x in unknown])
    for t in free:
        below, factor = reduced(t, q)
        require(span.add({below: factor}), f"zeta_1({show(t)}) is not free")
        rows.append([factor if x == below else Fraction(0) for x in unknown])
    require(len(rows) == len(unknown), f"the free trees of order {n} are not all given")
    return defining, left, inverse_matrix([list(map(Fraction, row)) for row in rows])


def cut_classes(t: Tree, q: int) -> dict[Tree, Fraction]:
    """Return {class: weight} of what is left when branches are cut, t itself included."""
    found = {}
    for s, weight in cut(t):
        below, factor = reduced(s, q)
        found[below] = found.get(below, 0) + weight * factor
    return found


def identities(n: int, q: int, free: tuple[Tree, ...]) -> tuple[Span, int]:
    """Return the identities of an odd order n between R there and what is left over below it (6.3).

    Returned with them is in how many unknowns they are.
    """
    left, span = plan(n - 1, q, free)[1], Span()
    for t, u in pairs_of(n, q):
        row: dict[object, Fraction] = {**spread_of(t, u, q)}
        for a, x in cut_classes(t, q).items():
            for b, y in cut_classes(u, q).items():
                at = (a, b) if (a, b) in left else (b, a)
                if size(a) + size(b) == n - 1 and at in left:
                    row[at] = row.get(at, Fraction(0)) - x * y
        span.add(row)
    return span, len(classes(n, q)) + len(left)


def conditions_follow(
    n: int, q: int, given: set[Tree], free: Mapping[int, tuple[Tree, ...]]
) -> bool:
    """Tell whether R = 0 at the given trees of an odd order n gives R = 0 at all of them (6.3)."""
    if n == 1:
        return LEAF in given
    span, unknowns = identities(n, q, free.get(n - 1, ()))
    for t in given:
        if size(t) == n:
            span.add({reduced(t, q)[0]: 1})
    return len(span.rows) == unknowns
