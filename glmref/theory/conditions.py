"""Order conditions of general linear methods, tree by tree, in any number of colours.

This module only computes: blocks, starting series, residuals. What follows from them is decided in
:mod:`glmref.theory.order`, where the public names are.

Every colour c of vertices has a block (A, U, B, V): ``X = h A F + U x``, ``x+ = h B F + V x``. A
single method has the one colour ``o``; a pair has ``f`` (the method for q) and ``k`` (for p).
For a tree t = [t1 .. tm] with root colour c and eta(empty) = u_c, V u = u, U u = 1::

    xiD(t) = xi(t1) ... xi(tm)                      stage by stage
    R(t)   = B xiD(t) - ((E eta)(t) - eta(t))       known from trees of lower order
    (I - V) eta(t) = R(t)        xi(t) = A xiD(t) + U eta(t)

so t has a condition, ``w R(t) = 0`` for the left eigenvectors ``w V = w``, and a free principal
part: eta(t) may be changed by any ``N beta(t)``, N the eigenvectors of V.

The principal parts
-------------------
*They enter linearly, one order later.* Changing beta on the trees of order k changes the condition
of a tree t of order k + 1 by ``(L beta)(t) = K beta(t1) [only if t = [t1]] - sum n(s, t) beta(s)``,
the sum over the trees s left when a leaf of t is removed, n(s, t) counting the leaves; K = w B U N
is 1 for a simple eigenvalue (then K = w B 1 = w u, by the condition of order 1).

*They are unique.* L is injective for k >= 2: among the trees where a beta in its kernel is not zero
take s with the most children, and among those with the most leaves of one colour x at the root. Let
t be s with one more such leaf at the root. It has two children or more, so K plays no part.
Removing from t a leaf that is not a child of the root leaves more children at the root than s has;
removing a leaf of another colour there leaves more leaves x. So beta is zero on all the trees in
the sum but s, hence n(s, t) beta(s) = 0, and n(s, t) > 0. The same proof is an algorithm: the
conditions of the trees with such a leaf at the root determine beta by back substitution; the
conditions of the other trees remain, and they decide. No matrix is factorised and only integers
divide.

*At k = 1 one parameter is left, and it does not matter.* L maps beta(single nodes) to the trees of
order 2; its kernel holds the multiples of u, because S E^c (follow the flow for c h, then start) is
a starting method whenever S is: M S E^c = S E E^c = S E^c E. These shifts act on all starting
series, and reach every value of the parameter. So a solution with the parameter normalised to zero
exists whenever any solution exists. For one or two colours with simple eigenvalues the kernel is
exactly that (for two colours the tree [x] with root y says beta_x - beta_y = known).

Hence deciding order by order is complete, though the conditions are not linear as a whole: at each
order at most one choice of the principal parts is left, up to the shift. In the language of
Butcher (1969): the method's underlying one-step method Phi satisfies Phi beta = beta E; beta is
unique up to the centraliser of E, and that is the flow itself. An eigenvalue 1 of V that is
multiple is treated in the same way when it is semisimple and the kernel at k = 1 is
one-dimensional; otherwise an order that is reached is proved, an order that is not reached is
reported as undecided.

References
----------
Butcher, "The effective order of Runge-Kutta methods" (1969), Lecture Notes in Math. 109.
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 389, 535.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from math import factorial
from typing import Any

from ..exact import Exact
from ..method.component import Palette
from ..system.budget import spend
from .blocks import Block, as_scalar, equal, kernel, present, seen, tidy
from .coefficients import apply, is_zero, plus, times, weighted
from .trees import Tree, pruned, single, tree, trees

#: A product of stage vectors, by their numbers, ascending.
_Monomial = tuple[int, ...]


@lru_cache(maxsize=4096)
def _weight(ways: int, size: int) -> Exact:
    """``- ways / size``, kept because its ball is."""
    return Exact(Fraction(-ways, size))


class Conditions:
    """The conditions of one method or one pair, order by order.

    Each call of :meth:`advance` handles the trees of the next order and returns their residuals.
    It never stops at a residual that is not zero: the next order is then what the formulas give,
    which is what a solver needs that drives residuals to zero.

    Parameters
    ----------
    blocks : Mapping[str, Block]
        The prepared method of every colour of the palette.
    palette : Palette
        Colours of the trees.
    principal : str
        ``"free"``, or ``"identity"`` for a principal part that is the identity.

    Attributes
    ----------
    order
        Trees up to this order have been handled.
    eta
        Starting series, by tree; zero entries are the int 0, vectors of zeros are left out.
        Principal parts of the last order are zero: only the next order would determine them.
    determined
        Trees of the last order whose conditions were used for principal parts.
    last_free
        Eta on the trees one order below, before their principal parts were found.
    complete
        Whether a condition that fails excludes every starting series.
    """

    def __init__(self, blocks: Mapping[str, Block], palette: Palette, principal: str) -> None:
        self.blocks, self.palette, self.free = dict(blocks), palette, principal == "free"
        self.simple = all(len(b.N) == 1 and b.semisimple for b in blocks.values())
        self.complete = all(b.semisimple for b in blocks.values()) and (
            self.simple or len(blocks) == 1
        )
        self.order = 0
        self.eta: dict[Tree, tuple[Any, ...]] = {}
        self.determined: frozenset[Tree] = frozenset()
        self.last_free: dict[Tree, tuple[Any, ...]] = {}
        self._bases: list[tuple[Any, ...]] = []  # stage vectors xi that are not monomials in others
        self._stage: dict[Tree, tuple[Fraction, _Monomial]] = {}  # xi(t) = ratio * monomial
        self._shared: dict[tuple[str, _Monomial], tuple[Fraction, _Monomial]] = {}
        self._images: dict[tuple[str, _Monomial], tuple[tuple[Any, ...], tuple[Any, ...]]] = {}
        self._power: dict[str, int] = {}  # base that holds the abscissae of a colour

    # -- stages --------------------------------------------------------------------------------

    def _vector(self, colour: str, monomial: _Monomial) -> tuple[Any, ...]:
        """Product of stage vectors."""
        if not monomial:
            return (1,) * self.blocks[colour].slopes
        result = self._bases[monomial[0]]
        for base in monomial[1:]:
            result = tuple(times(x, y) for x, y in zip(result, self._bases[base], strict=True))
        return result

    def _image(self, colour: str, monomial: _Monomial) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """A and B applied to a product of stage vectors, computed once for each product."""
        key = (colour, monomial)
        if key not in self._images:
            block, vector = self.blocks[colour], self._vector(colour, monomial)
            self._images[key] = (apply(block.A, vector), apply(block.B, vector))
        return self._images[key]

    def _slope(self, t: Tree) -> tuple[Fraction, _Monomial]:
        """xiD(t) as a rational multiple of a product of stage vectors."""
        ratio, factors = Fraction(1), []
        for child in t.children:
            factor, monomial = self._stage[child]
            ratio *= factor
            factors += monomial
        return ratio, tuple(sorted(factors))

    def _settle_stage(self, t: Tree) -> None:
        """Find xi(t) = A xiD(t) + U eta(t).

        Where it is c^|t| / gamma(t), or was met before, nothing new is stored: trees that a stage
        order makes alike cost one computation.
        """
        colour, (ratio, monomial), value = t.colour, self._slope(t), self.eta.get(t)
        if value is None:
            if ratio == 0:
                self._stage[t] = (ratio, ())
                return
            key = (colour, monomial)
            if key not in self._shared:
                weight = 1 / (t.density * ratio)
                self._shared[key] = self._recognise(t, self._image(*key)[0], weight)
            factor, found = self._shared[key]
            self._stage[t] = (ratio * factor, found)
            return
        vector = self.stage_vector(t, value)
        self._stage[t] = self._recognise(t, vector, Fraction(1, t.density))

    def stage_vector(self, t: Tree, value: Sequence[Any]) -> tuple[Any, ...]:
        """xi(t) from its definition, with eta(t) = value; its subtrees are settled."""
        ratio, monomial = self._slope(t)
        vector = times(ratio, self._image(t.colour, monomial)[0])
        return plus(vector, apply(self.blocks[t.colour].U, value))

    def _recognise(
        self, t: Tree, vector: tuple[Any, ...], weight: Fraction
    ) -> tuple[Fraction, _Monomial]:
        """Write a stage vector as zero, as ``weight * c^|t|``, or as a new base."""
        vector = tidy(vector)
        if not present(vector):
            return Fraction(0), ()
        power = self._power.get(t.colour)
        if power is not None:
            monomial = (power,) * t.order
            expected = self._bases[power]
            for _ in range(t.order - 1):
                expected = tuple(map(times, expected, self._bases[power]))
            if equal(vector, times(weight, expected)):
                return weight, monomial
        self._bases.append(vector)
        if t.order == 1:
            self._power[t.colour] = len(self._bases) - 1
        return Fraction(1), (len(self._bases) - 1,)

    def stage_defect(self, t: Tree, value: Sequence[Any], c: Sequence[Any]) -> tuple[Any, ...]:
        """Return ``xi(t) - c^|t| / gamma(t)``, stage by stage, where eta(t) is ``value``."""
        expected = times(Fraction(1, t.density), tuple(c))
        for _ in range(t.order - 1):
            expected = tuple(map(times, expected, c))
        return plus(self.stage_vector(t, value), times(-1, expected))

    # -- one order -----------------------------------------------------------------------------

    def _right_side(self, t: Tree) -> tuple[Any, ...]:
        """R(t) = B xiD(t) - (E eta - eta)(t)."""
        ratio, monomial = self._slope(t)
        terms = [(Exact(ratio), self._image(t.colour, monomial)[1])] if ratio else []
        terms.append((_weight(1, t.density), self.blocks[t.colour].u))
        for kept, ways in pruned(t).items() if self.eta else ():
            value = self.eta.get(kept)
            if value is not None:
                terms.append((_weight(ways, factorial(t.order - kept.order)), value))
        weights = list(enumerate(weight for weight, _ in terms))
        columns = zip(*(vector for _, vector in terms), strict=True)
        return tuple([weighted(weights, column) for column in columns])

    def _residual(self, t: Tree, right: tuple[Any, ...]) -> tuple[Any, ...]:
        return apply(self.blocks[t.colour].W, right)

    def advance(self) -> dict[Tree, tuple[Any, ...]]:
        """Handle the trees of the next order.

        Returns
        -------
        dict[Tree, tuple[Any, ...]]
            Residual of every tree, a tuple with one entry for each left eigenvector of V to 1. With
            a free principal part those conditions that determine it are zero by definition.
        """
        n = self.order + 1
        level = trees(n, self.palette)
        self.last_free = {t: x for t, x in self.eta.items() if t.order == n - 1}
        right: dict[Tree, tuple[Any, ...]] = {}
        if n == 2:
            self._settle_first()
        elif n > 2 and (self.free or not self.simple):
            right = self._settle_principal(n)
        self.determined = frozenset(right) if self.free else frozenset()
        for t in trees(n - 1, self.palette) if n > 1 else ():
            if t not in self._stage:
                self._settle_stage(t)
        residuals: dict[Tree, tuple[Any, ...]] = {}
        for t in level:
            spend()
            if t not in right:
                right[t] = self._right_side(t)
            block = self.blocks[t.colour]
            residuals[t] = (
                (0,) * len(block.N) if t in self.determined else self._residual(t, right[t])
            )
        for t in level:
            self._set_eta(t, apply(self.blocks[t.colour].lift, right[t]))
        self.order = n
        return residuals

    def principal_part(self, colour: str, value: Sequence[Any]) -> Any:
        """The principal part of a vector: what the output functional sees of it."""
        return seen(self.blocks[colour], value)

    def _set_eta(self, t: Tree, value: tuple[Any, ...]) -> None:
        value = tidy(value)
        if present(value):
            self.eta[t] = value
        else:
            self.eta.pop(t, None)

    # -- principal parts -----------------------------------------------------------------------

    def _settle_first(self) -> None:
        """Principal parts at the single nodes, normalised so that the output of the first is 0."""
        colours = list(self.palette)
        if not self.simple:
            if self.complete:
                self._settle_first_multiple(colours[0])
            return
        if not self.free:
            return
        start = single(colours[0])
        self._settle_stage(start)
        for colour in colours[1:]:
            # the tree [x] with root y: residual + beta_x - beta_y = 0, and beta_x = 0
            pair = tree([start], colour)
            (beta,) = self._residual(pair, self._right_side(pair))
            node, block = single(colour), self.blocks[colour]
            before = self.eta.get(node, (0,) * len(block.u))
            self._set_eta(node, plus(before, times(beta, block.u)))

    def _settle_first_multiple(self, colour: str) -> None:
        """The same for one colour when the eigenvalue 1 is multiple and semisimple.

        The tree [o] gives ``(K - I) beta = -residual``, ``K = w B U N``. When the kernel of K - I
        is larger than the span of u, parameters are left that later orders do not see linearly.
        """
        block, node = self.blocks[colour], single(colour)
        before = self.eta.get(node, (0,) * len(block.u))
        right = plus(apply(block.B, self.stage_vector(node, before)), times(-1, before))
        residual = apply(block.W, plus(right, times(Fraction(-1, 2), block.u)))
        columns = [apply(block.W, apply(block.B, apply(block.U, x))) for x in block.N]
        rows = [
            [plus(column[i], -int(i == j)) for j, column in enumerate(columns)]
            for i in range(len(columns))
        ]
        square = tuple(tuple(map(as_scalar, row)) for row in rows)
        wide = tuple((*row, as_scalar(x)) for row, x in zip(square, residual, strict=True))
        fixed, sure = kernel(square)
        solutions, certain = kernel(wide)
        self.complete = sure and certain and len(fixed) == 1
        solution = next((x for x in solutions if is_zero(x[-1]) is False), None)
        if solution is not None:
            beta = tuple(x / solution[-1] for x in solution[:-1])
            self._set_eta(node, plus(before, self._principal(block, beta)))

    def _principal(self, block: Block, beta: tuple[Any, ...], *, whole: bool = False) -> Any:
        """N beta, without the part along u that the output sees unless ``whole``."""
        total: Any = (0,) * len(block.u)
        for factor, vector in zip(beta, block.N, strict=True):
            total = plus(total, times(factor, vector))
        if whole:
            return total
        return plus(total, times(-1, times(seen(block, total), block.u)))

    def _settle_principal(self, n: int) -> dict[Tree, tuple[Any, ...]]:
        """Determine the principal parts of order n - 1 >= 2 from the conditions of order n.

        Returns
        -------
        dict[Tree, tuple[Any, ...]]
            R(t) for the trees t that were used: every tree of order n - 1 with one more leaf, of
            the first colour allowed there, at its root. See the module docstring for the proof.
        """
        if not (self.simple or self.complete):
            return {}
        smaller = trees(n - 1, self.palette)
        leaf = {colour: single(self.palette[colour][0]) for colour in self.palette}
        larger = {s: tree((*s.children, leaf[s.colour]), s.colour) for s in smaller}
        right = {t: self._right_side(t) for t in larger.values()}
        residual = {t: tidy(self._residual(t, x)) for t, x in right.items()}
        if not any(map(present, residual.values())):
            return right
        below = {t: [(s, n) for s, n in pruned(t).items() if s.order == t.order - 1] for t in right}
        ranked = sorted(
            smaller, key=lambda s: (-len(s.children), -s.children.count(leaf[s.colour]))
        )
        beta: dict[Tree, tuple[Any, ...]] = {}
        for s in ranked:
            t, ways = larger[s], 0
            value: Any = residual[t]
            for kept, count in below[t]:
                if kept is s:
                    ways = count
                elif kept in beta:
                    value = plus(value, times(-count, beta[kept]))
            value = tidy(times(Fraction(1, ways), value))
            if present(value):
                beta[s] = value
        moved = {
            s: self._principal(self.blocks[s.colour], x, whole=self.free) for s, x in beta.items()
        }
        for s, shift in moved.items():
            before = self.eta.get(s)
            self._set_eta(s, shift if before is None else plus(before, shift))
        for t in right:
            for kept, count in below[t]:
                if kept in moved:
                    right[t] = plus(right[t], times(-count, moved[kept]))
        return right
