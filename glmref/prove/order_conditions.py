"""Whether the equations of a file give all order conditions, with rules beyond the theorems.

By :mod:`glmref.prove.equations` and :func:`glmref.prove.classes.follows` the conditions at a
few trees of odd order are enough. A condition counts as given when it is an equation of the file,
and in these further cases.

*Consistency.* ``sum d_i = 1`` for all values of the unknowns gives the tree of order 1.

*Quadrature.* With D exact, all abscissae c fixed exactly and zeta_1([o]) = zeta_1([ooo]) = 0, the
tree [oo] is ``sum d_i c_i^2 = 1/3`` and [oooo] is ``sum d_i c_i^4 = 1/5``. zeta_1([ooo]) = 0 is
the choice made where the file gives no ``xi``; zeta_1([o]) = zeta(o)^T G zeta(o) / 2 = 0 follows
from the equation of [oo] and the quadrature, or from ``start K``: by symmetry zeta(o) = -L
zeta(o), and where the solutions of that with first component 0 are the multiples of one vector
with nonzero K-th component, zeta_K(o) = 0 gives zeta(o) = 0. (With one such vector zeta_1([o]) is
a square, so that the equation of [oo] would have a double root.) With zeta(o) = 0, ``explicit 1``
also says c_1 = a_11 = 0.

*Pairs.* The judge says what suffices (``enclosed_pair.all_follow``): one version of each free tree,
and of products of flows (r = r^ = 1) fewer, of every order; symmetry plays no part there.

*r = 1, one component.* The method is the composition of s steps of the implicit midpoint rule of
lengths d_i h, palindromic; the logarithm of one step is h f + h^3 alpha_3 + h^5 alpha_5 + ..., so
with sum d_i = 1 and sum d_i^3 = 0 (the condition of order 3) the composition is the flow of ``f +
h^4 (p alpha_5 + q [f, [f, alpha_3]]) + ...`` with two numbers p, q: R on the trees of order 5 lies
in a plane (Yoshida 1990; Hairer, Lubich, Wanner 2006, section V.3), and two of the three free trees
give p = q = 0 where the plane projects regularly on them, which
``tests/unit/test_derive_enclosure.py`` checks exactly.
"""

from __future__ import annotations

from fractions import Fraction

from ..exact import Exact, linalg
from ..exact.expression import parse
from ..exact.judging import fast_judge
from ..theory.trees import Tree, parse_tree, single
from .classes import Family, follows, free_tree
from .system import Affine, SweepSystem

_THIRD, _STAR = parse_tree("[oo]"), parse_tree("[oooo]")
_BUSH, _PATH = parse_tree("[oo[o]]"), parse_tree("[[o][o]]")


def covered(system: SweepSystem, order: int, family: Family | None = None) -> bool:
    """Return whether the equations of a file give all conditions of an order on a family of trees.

    Parameters
    ----------
    system : SweepSystem
        Of the file, symmetric or a product of flows.
    order : int
        Odd, of a product of flows any.
    family : Family or None
        The trees meant; those of the equations where it is ``None``.
    """
    family, given = family or system.family, given_trees(system)
    if not system.is_partitioned:
        return follows(order, system.stage_order, given, family)
    judge = fast_judge()
    named = frozenset(judge.trees.read_tree(str(t)) for t in given if t.order == order)
    second_order = family is Family.SECOND_ORDER
    return judge.enclosed_pair.all_follow(order, second_order, named, system.kind_of_flow())


def given_trees(system: SweepSystem) -> set[Tree]:
    """Return trees whose conditions the equations of a file give directly or by the rules above."""
    given = {e.tree for e in system.equations if e.kind == "order" and e.tree}
    free = {free_tree(t) for t in given}
    for colour, weights in system.affine.D.items():
        if (sum(weights[1:], Affine.of(weights[0])) - 1).is_identically_zero():
            given.add(single(colour))
    if system.is_partitioned:
        return given
    if _starts_at_order_two(system) and _quadrature(system, 2):
        given.add(_THIRD)
    third = free_tree(_THIRD) in free or _THIRD in given
    if third and not system.principal and _quadrature(system, 2) and _quadrature(system, 4):
        given.add(_STAR)
    if system.is_one_step and {free_tree(t) for t in (_THIRD, _STAR, _PATH)} <= free:
        given.add(_BUSH)
    return given


def _starts_at_order_two(system: SweepSystem) -> bool:
    """Return whether ``start K`` gives zeta(o) = 0."""
    if system.is_one_step or not system.involutions:
        return system.is_one_step
    L = system.involutions["o"]
    basis = linalg.nullspace(tuple(row[1:] for row in linalg.add(L, linalg.identity(len(L)))))
    starts = [e.number for e in system.equations if e.kind == "start" and e.tree is single()]
    return len(basis) == 1 and any(k > 0 and not basis[0][k - 1].is_zero() for k in starts)


def abscissae(system: SweepSystem) -> list[Fraction] | None:
    """Return the abscissae if the file fixes all exactly, else ``None`` (two components)."""
    if system.is_partitioned:
        return None
    found: dict[int, Fraction] = {}
    for e in system.equations:
        if e.kind == "abscissa":
            value = parse(e.value)
            fraction = value.as_fraction() if isinstance(value, Exact) else None
            if fraction is not None:
                found[e.number] = fraction
        elif e.kind == "explicit" and e.number == 0 and _starts_at_order_two(system):
            found[0] = Fraction(0)
    for i, x in list(found.items()):
        found.setdefault(system.s - 1 - i, 1 - x)
    if system.s % 2:
        found.setdefault(system.s // 2, Fraction(1, 2))
    return [found[i] for i in range(system.s)] if len(found) == system.s else None


def _quadrature(system: SweepSystem, power: int) -> bool:
    """Return whether ``sum d_i c_i^power = 1 / (power + 1)`` holds exactly."""
    c = abscissae(system)
    if c is None:
        return False
    total = Affine.of(-Fraction(1, power + 1))
    for d, x in zip(system.affine.D["o"], c, strict=True):
        total = total + Affine.of(d) * x**power
    return total.is_identically_zero()
