"""Systems on which trees of a palette vanish: those of :attr:`glmref.method.Method.system`.

``"time"``: y' = f(t, y) with t' = 1, which has no arguments, so that a vertex k is a leaf and the
trees of t are not asked about. ``"w"``: the sum of f(y) - J y and J y, J linear, where a vertex 2
has at most one child. ``"rosenbrock"``: the same with J = f'(y), where the derivative of the first
part vanishes, so that a vertex 1 has not one child alone.

References
----------
    Hairer, Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.7.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from .trees import Tree

_GOOD: dict[str, Callable[[Tree], bool]] = {
    "": lambda t: True,
    "time": lambda t: t.colour != "k" or not t.children,
    "w": lambda t: t.colour != "2" or len(t.children) < 2,
    "rosenbrock": lambda t: len(t.children) < 2 if t.colour == "2" else len(t.children) != 1,
}


@cache
def counted(system: str) -> Callable[[Tree], bool]:
    """Which trees count on the systems of a method: :attr:`glmref.method.Method.system`."""
    good = _GOOD[system]

    @cache
    def counts(t: Tree) -> bool:
        return good(t) and all(map(counts, t.children))

    return counts
