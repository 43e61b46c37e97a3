"""Order conditions of coefficients that were read from an integrator, in double precision.

A run shows a defect only where its error exceeds rounding and the error of the next order; a
residual of 1e-6 in a condition of order 5 does not. The coefficients show it. Weights are compared
with ``1 / gamma(t)`` (Hairer, Norsett, Wanner I, theorem II.2.13; for two colours Hairer, Lubich,
Wanner, theorem III.2.5). The bound of an error is the same weight of the absolute values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..catalogue.lookup import names
from ..method.component import ROOTED, SEPARABLE
from ..theory.trees import Tree, trees
from .identify import _arrays
from .readings import Half, Reading, named

#: Most order that is looked at: 4766 trees have order 12.
HIGHEST = 12
#: Relative errors of a weight: each entry was read with some roundings, and enters some times.
_ROUNDINGS = 16
_SHOWN = 3


@dataclass(frozen=True)
class Defect:
    """The first order condition that coefficients miss."""

    order: int  #: Order that they have.
    tree: Tree  #: Tree of the condition.
    weight: float  #: What they make of it.
    #: Whether the condition holds with ``c = A 1`` and fails at the times of the calls of f.
    times: bool = False

    def __str__(self) -> str:
        gap = abs(self.weight - 1 / self.tree.density)
        at = " at the times at which f is called" if self.times else ""
        return (
            f"its coefficients have order {self.order}: the weight of {self.tree}{at} misses "
            f"1/{self.tree.density} by {gap:.2g}"
        )


class _Weights:
    """Weights of trees; each is computed once, with the bound that its rounding has."""

    def __init__(self, reading: Reading, c: np.ndarray | None = None) -> None:
        (A, _, B, _), (A_hat, _, B_hat, _) = reading.halves[0], reading.halves[-1]
        # of a vertex f stand A_hat (to its children k) and B, of a vertex k A and B_hat
        self.blocks = {"o": A, "f": A_hat, "k": A}
        self.outputs = {"o": B[0], "f": B[0], "k": B_hat[0]}
        self.c = c
        self._known: dict[Tree, tuple[np.ndarray, np.ndarray]] = {}

    def _slope(self, t: Tree) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivative weights of the stages at which the root is evaluated."""
        if t not in self._known:
            A = self.blocks[t.colour]
            value, size = np.ones(len(A)), np.ones(len(A))
            for child in t.children:
                below, bound = self._slope(child)
                if self.c is not None and not child.children:
                    value, size = value * self.c, size * np.abs(self.c)
                else:
                    value, size = value * (A @ below), size * (np.abs(A) @ bound)
            self._known[t] = value, size
        return self._known[t]

    def of(self, t: Tree) -> tuple[float, float]:
        """Weight, and the same of the absolute values."""
        value, size = self._slope(t)
        b = self.outputs[t.colour]
        return float(b @ value), float(np.abs(b) @ size)


def first_defect(reading: Reading, order: int, unit: float) -> Defect | None:
    """Find the first condition up to an order that coefficients of one value miss.

    Conditions up to :data:`HIGHEST` are looked at; ``unit`` is the relative error of the arithmetic
    in which the coefficients were read. ``None`` where all hold within what the reading explains.
    """
    kinds = [_Weights(reading)]
    if reading.c is not None and np.any(reading.halves[0][0].sum(axis=1) != reading.c):
        kinds.append(_Weights(reading, reading.c))
    palette = ROOTED if reading.single else SEPARABLE
    for p in range(1, min(order, HIGHEST) + 1):
        for number, weights in enumerate(kinds):
            gaps = []
            for t in trees(p, palette):
                weight, size = weights.of(t)
                gap, allowed = abs(weight - 1 / t.density), _ROUNDINGS * p * unit * (1 + size)
                if gap > allowed:
                    gaps.append((gap, weight, t))
            if gaps:
                _, weight, t = max(gaps, key=lambda x: x[0])
                return Defect(p - 1, t, weight, bool(number))
    return None


def nearest(reading: Reading) -> str:
    """Name the method of the catalogue that differs at the fewest entries, or ``""``.

    It must agree in more than half of the entries that are not zero.
    """
    mine = _entries(reading.halves)
    best: tuple[int, str, list[str]] | None = None
    for name in names("methods"):
        theirs = _entries(_arrays(name))
        shapes = [{key: x.shape for key, x in blocks.items()} for blocks in (mine, theirs)]
        if shapes[0] != shapes[1]:
            continue
        wrong = [
            f"{x}[{i + 1}][{j + 1}] is {mine[x][i, j]:.6g} and there {theirs[x][i, j]:.6g}"
            for x in mine
            for i, j in np.argwhere(np.abs(mine[x] - theirs[x]) > 1e-9)
        ]
        size = sum(np.count_nonzero((mine[x] != 0) | (theirs[x] != 0)) for x in mine)
        if 2 * len(wrong) < size and wrong and (best is None or len(wrong) < best[0]):
            best = (len(wrong), name, wrong)
    if best is None:
        return ""
    count, name, wrong = best
    more = f", and {count - _SHOWN} more" if count > _SHOWN else ""
    return f"nearest is {name}: {', '.join(wrong[:_SHOWN])}{more}"


def _entries(halves: Sequence[Half]) -> dict[str, np.ndarray]:
    """Return the blocks by which methods of one value differ."""
    return {name: matrix for name, matrix in named(halves).items() if name[0] in "AB"}
