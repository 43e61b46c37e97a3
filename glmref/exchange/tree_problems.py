"""Problems whose error of order p is one elementary differential: a convergence test by trees.

For a rooted tree t each distinct subtree s is a component, ``y_s' = product of y_w`` over the
children w of s, with ``y_s(0) = 0`` and the solution ``x^|s| / gamma(s)``. Where a tree u has as
many vertices as t, the component of t in the elementary differential F(u) vanishes unless u = t, at
every state; where u has fewer, it vanishes unless u is t with branches cut off. So the first
step of a method with the elementary weight ``Phi(t)`` changes that component by
``(Phi(t) - 1/gamma(t)) h^|t|`` more than the solution does, if the conditions of the trees that are
left when branches are cut off hold; and the error of N such steps is N times that. A problem of
lower order does not see t, nor does another one of the same order.

References
----------
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section 314 (independence
of the elementary differentials).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..errors import UsageError
from ..method.component import SEPARABLE
from ..problems.model import Problem
from ..system.arguments import one_of
from ..theory.trees import Tree, parse_tree, trees

#: Largest order of the trees of the shipped set.
ORDER = 6
#: Rate at which a stiff component goes to the time, which it follows.
RATE = 1000
_LEAF = parse_tree("o")
KINDS = ("autonomous", "timed", "stiff", "separable")


@dataclass(frozen=True)
class TreeProblem:
    """A problem that shows one tree.

    Parameters
    ----------
    tree : Tree
        The tree of the elementary differential: of one colour, or of ``f`` and ``k`` for
        separable problems.
    kind : str
        ``autonomous``; ``timed``, where leaves are the time itself, so that the abscissae count;
        ``stiff``, where the time is followed by a component ``z' = 1 - 1000 (z - t)``, whose
        stages are exact for every method with c = A 1; or ``separable``.
    components : tuple of Tree
        The subtree that each component stands for, that of the tree itself first; of a separable
        problem those with root ``f`` are q and those with root ``k`` are p.
    f : tuple of str
        Right-hand side, an expression in ``y[0]``, .. and ``t`` for each component; of a separable
        problem q, then p, each filled up with components that stay 0.
    """

    tree: Tree
    kind: str
    components: tuple[Tree | None, ...]
    f: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name, such as ``autonomous-[o[o]]``."""
        return f"{self.kind}-{self.tree}"

    @property
    def shows(self) -> int:
        """The component in which the error of the tree is."""
        return self.components.index(self.tree)

    @property
    def linear(self) -> bool:
        """Whether the right-hand side is linear in the state."""
        return all(text.count("y[") <= 1 for text in self.f)

    def solution(self, t: Fraction) -> tuple[Fraction, ...]:
        """Return the exact state (d,) at a time."""
        return tuple(Fraction(0) if s is None else t**s.order / s.density for s in self.components)

    @property
    def problem(self) -> Problem:
        """The problem as :func:`glmref.solve` takes it, over one unit of time."""
        about: dict[str, Any] = {
            "name": self.name, "y0": (0,) * len(self.f), "t_span": (0.0, 1.0),
            "source": "Butcher 2016, section 314",
        }  # fmt: skip
        if self.kind != "separable":
            return Problem(f=self.f, **about)
        half = len(self.f) // 2
        q, p = self.f[:half], self.f[half:]
        for k in range(half):
            q = tuple(x.replace(f"y[{half + k}]", f"p[{k}]") for x in q)
        return Problem(dq=q, dp=tuple(x.replace("y[", "q[") for x in p), **about)

    def as_json(self) -> dict[str, Any]:
        """Return the problem as plain data, with the state at t = 1."""
        return {
            "name": self.name,
            "kind": self.kind,
            "tree": str(self.tree),
            "order": self.tree.order,
            "density": self.tree.density,
            "autonomous": self.kind in ("autonomous", "separable"),
            "linear": self.linear,
            "separable": self.kind == "separable",
            "stiff": self.kind == "stiff",
            "f": list(self.f),
            "t0": "0",
            "y0": ["0"] * len(self.f),
            "component": self.shows,
            "t_end": "1",
            "state": [str(x) for x in self.solution(Fraction(1))],
        }


def tree_problem(tree: Tree | str, kind: str = "autonomous") -> TreeProblem:
    """Return the problem of one kind that shows a tree.

    Raises
    ------
    UsageError
        For another kind, a text that is not a tree, and a tree whose colours are not those of the
        kind: alternating ``f`` and ``k`` for separable problems, ``o`` for the others.
    """
    t = parse_tree(tree) if isinstance(tree, str) else tree
    one_of("kind", kind, KINDS)
    found = list(dict.fromkeys(_subtrees(t)))
    if kind == "separable":
        return _separable(t, found)
    if any(s.colour != "o" for s in found):
        raise UsageError(f"a problem of kind {kind} takes a tree of one colour, got '{t}'")
    if kind != "autonomous" and t is _LEAF:
        raise UsageError(f"a problem of kind {kind} takes a tree of two vertices or more")
    kept = [s for s in found if not (kind == "timed" and s is _LEAF)]
    names = {s: f"y[{k}]" for k, s in enumerate(kept)}
    follows = {_LEAF: f"1-{RATE}*({names[_LEAF]}-t)"} if kind == "stiff" else {}
    f = tuple(follows.get(s) or _product(s, names) for s in kept)
    return TreeProblem(t, kind, tuple(kept), f)


def _separable(t: Tree, found: Sequence[Tree]) -> TreeProblem:
    """Return the problem with the subtrees of root f in q, and those of root k in p."""
    if any(s.colour not in "fk" or s.colour in {x.colour for x in s.children} for s in found):
        raise UsageError(f"a separable problem takes a tree of alternating f and k, got '{t}'")
    sides = [[s for s in found if s.colour == colour] for colour in "fk"]
    half = max(map(len, sides))
    components = tuple(s for side in sides for s in (*side, *[None] * (half - len(side))))
    names = {s: f"y[{k}]" for k, s in enumerate(components) if s is not None}
    f = tuple("0" if s is None else _product(s, names) for s in components)
    return TreeProblem(t, "separable", components, f)


def tree_problems(order: int = ORDER) -> Iterator[TreeProblem]:
    """Yield the problems of every kind and tree up to an order."""
    for kind in KINDS:
        for n in range(1, order + 1):
            for t in trees(n, SEPARABLE) if kind == "separable" else trees(n):
                if t is not _LEAF or kind == "autonomous":
                    yield tree_problem(t, kind)


def _subtrees(t: Tree) -> Iterator[Tree]:
    yield t
    for child in t.children:
        yield from _subtrees(child)


def _product(s: Tree, names: Mapping[Tree, str]) -> str:
    """Return the product of the components of the children; the time for those without one."""
    return "*".join(names.get(child, "t") for child in s.children) or "1"
