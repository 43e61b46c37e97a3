"""Rounded coefficients, taken as they stand: how large the residuals of their conditions are.

A table of 16 or 90 printed digits is a rational method of order 0 or 1. What users ask of it is to
how many digits it has the order that its authors meant. Here every condition is evaluated in fixed
point, integers over ``2^bits``, with a radius that bounds all roundings, so that the answers are
proved; the numbers themselves are exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING
from fractions import Fraction
from itertools import islice
from operator import mul
from typing import TYPE_CHECKING, Any

from ..catalogue.claims import SOLUTION
from ..errors import ExactnessError
from ..exact import Exact, linalg, rounded_decimal
from ..exact.linalg import Vector
from ..method.component import Palette
from ..system.budget import spend
from ..theory.trees import Tree, tree, trees

if TYPE_CHECKING:
    from .kernel import Found, Proposal

#: A condition of the next order has a residual above so many times the one declared.
GAP = 1000
#: Bits beyond four for each digit.
SPARE = 192
#: Trees with one branch that are tried before all trees of an order are listed.
ONE_BRANCH = 100
#: The last order of which all residuals are computed exactly, to say that they are 0.
LISTED = 8
#: Residuals above this are no roundings; where an order has thousands of trees, above the second.
LARGE, ROUNDING, MANY = Fraction(1, 1000), Fraction(1, 10**9), 10
#: The exponent of the smallest residuals that are told from 0 where none is declared.
SMALLEST = 120


def step_below(size: str) -> Fraction:
    """The number of two digits before one: 2.6e-83 of 2.7e-83, and 9.9e-84 of 1.0e-83."""
    digits, exponent = size.split("e")
    unit = Fraction(10) ** (int(exponent) - 1)
    tens = int(digits.replace(".", ""))
    return (tens - 1) * unit if tens > 10 else 99 * unit / 10


def rounded_up(x: Fraction) -> str:
    """A positive number rounded up to two digits, such as ``2.7e-83``; ``0`` of zero."""
    return f"{rounded_decimal(x, 2, ROUND_CEILING):.1e}" if x else "0"


@dataclass(frozen=True)
class Sized:
    """Whether an order holds to the size declared, why not, and the trees that show it.

    Attributes
    ----------
    truth : bool
        What the interval of a residual leaves undecided is computed exactly.
    reason : str
        One sentence, empty where it holds.
    largest : str
        The tree with the largest residual through the order; where it fails, one with a larger one.
    beyond : str
        A tree of the next order with a residual above :data:`GAP` times the size.
    order : int
        Where it fails and no tree shows it: the declared order, through which all residuals are
        smaller than declared, or the next, whose residuals are all that small.
    """

    truth: bool
    reason: str
    largest: str = ""
    beyond: str = ""
    order: int = 0


#: Colour of the root, trees above it, density.
Shape = tuple[str, Sequence[Tree], int]


class _Vector:
    """Numbers in units, each with an error of at most ``radius``; ``size`` is the largest."""

    __slots__ = ("radius", "size", "values")

    def __init__(self, values: list[int], radius: int) -> None:
        self.values, self.radius = values, radius
        self.size = max(map(abs, values))


class _Fixed:
    """Conditions of coloured stages in fixed point.

    Parameters
    ----------
    kernel : Kernel
        Of a method that carries one value.
    bits : int
        Numbers are integers over ``2^bits``.
    """

    def __init__(self, kernel: Any, bits: int) -> None:
        self.bits, self.one = bits, 1 << bits
        self.palette: Palette = kernel.palette
        #: by colour the entries (j, a_ij) of each row that are not zero, and |a|_inf
        self.rows: dict[str, list[list[tuple[int, int]]]] = {}
        self.norm: dict[str, int] = {}
        for colour, (A, *_) in kernel.blocks.items():
            dense = [self.scaled(row) for row in A]
            self.rows[colour] = [[(j, x) for j, x in enumerate(row) if x] for row in dense]
            self.norm[colour] = max(sum(map(abs, row)) + len(row) for row in dense)
        self.matrices = {c: A for c, (A, *_) in kernel.blocks.items()}
        self.columns = {c: len(A[0]) for c, (A, *_) in kernel.blocks.items()}
        self._weights: dict[Tree, _Vector] = {}
        self._below: dict[Tree, _Vector] = {}

    def scaled(self, values: Sequence[Any]) -> list[int]:
        """Rational numbers, each less than one unit too small."""
        found = []
        for x in values:
            fraction = x.as_fraction() if isinstance(x, Exact) else None
            if fraction is None:
                said = "the coefficients are not all rational numbers"
                if not isinstance(x, Exact):
                    said = "`digits` makes each decimal an interval, and the claim is about the "
                    said += "decimals themselves: leave `digits` out"
                raise ExactnessError(said)
            found.append(fraction.numerator * self.one // fraction.denominator)
        return found

    def weights(self, t: Tree) -> _Vector:
        """Phi(t) at the slopes of the colour of its root."""
        if t not in self._weights:
            if t.children:
                self._weights[t] = _Vector(*self.product(t))
            else:
                self._weights[t] = _Vector([self.one] * self.columns[t.colour], 0)
        return self._weights[t]

    def product(self, t: Tree) -> tuple[list[int], int]:
        """Phi of a tree with children: the product for the tree without the last one, and A Phi."""
        spend()
        x = self.weights(tree(t.children[:-1], t.colour))
        y = self.below(t.children[-1])
        # |(x + d)(y + e) - x y| <= |x| ry + |y| rx + rx ry; the shift loses less than 1
        error = x.size * y.radius + y.size * x.radius + x.radius * y.radius
        bits = self.bits
        found = [u * v >> bits for u, v in zip(x.values, y.values, strict=True)]
        return found, (error >> bits) + 2

    def below(self, t: Tree) -> _Vector:
        """A Phi(t), A that of the colour of its root."""
        if t not in self._below:
            colour = t.colour
            w = self.weights(t)
            v, bits = w.values, self.bits
            # each entry of A is less than 1 too small, which weighs |v|_1 + s r at most
            error = self.norm[colour] * w.radius + len(v) * (w.size + w.radius)
            rows = [sum([a * v[j] for j, a in row]) >> bits for row in self.rows[colour]]
            self._below[t] = _Vector(rows, (error >> bits) + 2)
        return self._below[t]

    def residual(self, t: Tree, b: _Vector) -> tuple[int, int]:
        """Bounds of ``|b Phi(t) - 1 / gamma(t)|``, in units."""
        if t in self._weights or not t.children:
            w = self.weights(t)
            return self.gap(b, w.values, w.radius, t.density)
        return self.gap(b, *self.product(t), t.density)

    def gap(self, b: _Vector, v: Sequence[int], r: int, density: int) -> tuple[int, int]:
        """Bounds of ``|b v - 1 / density|``; each entry of b is less than 1 too small."""
        size = max(map(abs, v))
        radius = ((len(v) * (b.size * r + size + r)) >> self.bits) + 3
        found = abs((sum(map(mul, b.values, v)) >> self.bits) - self.one // density)
        return max(found - radius, 0), found + radius

    def exactly(self, shape: Shape, b: Mapping[str, Any]) -> Fraction:
        """``|b Phi(t) - 1 / gamma(t)|`` itself, in units."""

        def phi(colour: str, below: Sequence[Tree]) -> Vector:
            spend()
            value: Vector = (Exact(1),) * self.columns[colour]
            for child in below:
                inner = phi(child.colour, child.children)
                inner = linalg.matvec(self.matrices[child.colour], inner)
                value = tuple(x * y for x, y in zip(value, inner, strict=True))
            return value

        root, below, density = shape
        gap = (linalg.dot(tuple(b[root]), phi(root, below)) - Exact(1) / density).as_fraction()
        return abs(gap) * self.one

    @staticmethod
    def shape(t: Tree) -> Shape:
        """Colour of the root, trees above it, and density of a tree."""
        return t.colour, t.children, t.density

    def level(self, n: int, counts: Callable[[Tree], bool]) -> Iterator[Tree]:
        """Trees of an order that are conditions."""
        return filter(counts, trees(n, self.palette))

    def judged(
        self, b: Mapping[str, Any], order: int, size: str, counts: Callable[[Tree], bool]
    ) -> Sized:
        """Compare the residuals of the weights b by colour with what is declared."""
        scaled = {c: _Vector(self.scaled(row), 1) for c, row in b.items()}
        most, least = Fraction(size) * self.one, step_below(size) * self.one
        low, high = Fraction(0), Fraction(0)
        largest = ""
        for n in range(1, order + 1):
            for t in self.level(n, counts):
                if n < order:
                    self.weights(t)  # kept: of the last order they serve nothing else
                x, y = self.residual(t, scaled[t.colour])
                if x <= most < y or x <= least < y:  # it may be that number itself
                    x = y = self.exactly(self.shape(t), b)
                if x > most:
                    if rounded_up(Fraction(x, self.one)) != rounded_up(Fraction(y, self.one)):
                        y = self.exactly(self.shape(t), b)
                    found = rounded_up(Fraction(y, self.one))
                    reason = f"tree {t} of order {n} has residual {found}"
                    return Sized(False, reason, str(t))
                if x > low:
                    low, largest = Fraction(x), str(t)
                high = max(high, Fraction(y))
        if not low > least:
            if low == 0 and order <= LISTED and self.vanish(b, order, counts):
                reason = f"the residuals through order {order} are 0: claim the order without size"
                return Sized(False, reason, order=order)
            if low and rounded_up(low / self.one) != rounded_up(high / self.one):
                every = (t for n in range(1, order + 1) for t in self.level(n, counts))
                unsure = (t for t in every if self.residual(t, scaled[t.colour])[1] > low)
                high = max(low, *(self.exactly(self.shape(t), b) for t in unsure))
            shown = rounded_up(high / self.one)
            reason = f"the residuals through order {order} are at most {shown}"
            return Sized(False, reason, order=order)
        assert high <= most, "a residual that may be larger was computed exactly"
        for text, shape, (_, y) in self.beyond(order + 1, scaled, counts):
            if y > GAP * most and self.exactly(shape, b) > GAP * most:
                return Sized(True, "", largest, text)
        reason = f"no condition of order {order + 1} has a residual above {GAP} times {size}"
        return Sized(False, reason, order=order + 1)

    def vanish(self, b: Mapping[str, Any], order: int, counts: Callable[[Tree], bool]) -> bool:
        """Whether all conditions through an order hold exactly."""
        return all(
            self.exactly(self.shape(t), b) == 0
            for n in range(1, order + 1)
            for t in self.level(n, counts)
        )

    def sizes(
        self, b: Mapping[str, Any], most: int, counts: Callable[[Tree], bool]
    ) -> list[Fraction]:
        """Largest residual through each order, at most, and last the first that is no rounding."""
        scaled = {c: _Vector(self.scaled(row), 1) for c, row in b.items()}
        found = [Fraction(0)]
        for n in range(1, most + 1):
            largest = found[-1]
            for t in self.level(n, counts):
                x, y = (Fraction(z, self.one) for z in self.residual(t, scaled[t.colour]))
                if y > largest:
                    sure = rounded_up(x) == rounded_up(y)
                    largest = y if sure else max(largest, self.exactly(self.shape(t), b) / self.one)
            found.append(largest)
            if found[-1] > (LARGE if n <= MANY else ROUNDING):
                return found
        last = max((y for *_, (_, y) in islice(self.beyond(most + 1, scaled, counts), ONE_BRANCH)),
                   default=self.one)  # fmt: skip
        return [*found, max(found[-1], Fraction(last, self.one))]

    def beyond(
        self, order: int, b: Mapping[str, _Vector], counts: Callable[[Tree], bool]
    ) -> Iterator[tuple[str, Shape, tuple[int, int]]]:
        """Trees of an order with bounds of their residuals: first those with one branch.

        Of one method without a system of its own every tree counts, and those with one child need
        no list of the trees of their order.
        """
        if len(self.palette) == 1:
            (weights,) = b.values()
            for t in islice(trees(order - 1, self.palette), ONE_BRANCH + 2):
                y = self.below(t)
                density = order * t.density
                bounds = self.gap(weights, y.values, y.radius, density)
                yield f"[{t}]", (t.colour, (t,), density), bounds
        for t in self.level(order, counts):
            yield str(t), self.shape(t), self.residual(t, b[t.colour])


def _carries_on(A: Any, U: Any, B: Any, V: Any) -> bool:
    """Whether U = 1 and V = 1: the value carried is the solution."""
    return all((x - 1).is_zero() is True for row in (*U, *V) for x in row)


class DigitRules:
    """A part of :class:`~glmref.prove.kernel.Kernel`."""

    if TYPE_CHECKING:
        blocks: Any
        method: Any
        one_step: bool
        row_kernels: Any
        timed: Any
        sized: dict[tuple[Any, ...], dict[str, Sized]]
        _made: Any
        _most: Callable[..., int]

    @property
    def _is_nystrom(self) -> bool:
        """Whether the conditions are those of second-order systems."""
        return (self.method.document or {}).get("class") == "nystrom"

    def _rows_of_weights(self) -> dict[str, dict[str, Vector]]:
        """By the names of the weights, b first, each as a row for each colour."""
        kernels = {SOLUTION: self, **dict(self.row_kernels)}
        return {
            name: {c: B[0] for c, (_, _, B, _) in x.timed.blocks.items()}
            for name, x in kernels.items()
        }

    def _counted(self) -> Callable[[Tree], bool]:
        """Which trees are conditions."""
        return self.timed._counts(nystrom=self._is_nystrom)

    def to_digits(self, declared: Mapping[str, Any]) -> dict[str, Sized]:
        """What is known of each of the declared orders, by the names of the weights."""
        rows = self._rows_of_weights()
        if set(declared) != set(rows):
            raise ExactnessError("the weights of the method are others")
        sized = {name: (int(p), str(e)) for name, (p, e) in declared.items()}
        key = tuple(sized.items())
        if key not in self.sized:
            self.sized[key] = self._to_digits(rows, sized)
        return self.sized[key]

    def _to_digits(self, rows: Any, sized: Mapping[str, tuple[int, str]]) -> dict[str, Sized]:
        most = self._most(nystrom=self._is_nystrom)
        if max(p for p, _ in sized.values()) > most:
            raise ExactnessError(f"trees are compared through order {most} here")
        exponent = max(-int(e.partition("e")[2]) for _, e in sized.values())
        fixed = _Fixed(self.timed, SPARE + 4 * exponent)
        counts = self._counted()
        return {name: fixed.judged(weights, *sized[name], counts) for name, weights in rows.items()}

    def sizes_to_digits(self) -> dict[str, list[Fraction]]:
        """Largest residual through each order, by the names of the weights, at most.

        Each list ends with the first order whose residual is large.

        Raises
        ------
        ExactnessError
            Where several values are carried, or entries are not rational.
        """
        self._check_one_value()
        fixed = _Fixed(self.timed, SPARE + 4 * SMALLEST)
        counts, most = self._counted(), self._most(nystrom=self._is_nystrom)
        rows = self._rows_of_weights()
        return {name: fixed.sizes(weights, most, counts) for name, weights in rows.items()}

    def _check_one_value(self) -> None:
        kernels = (self, *(x for _, x in self.row_kernels)) if self.one_step else ()
        if not kernels or not all(_carries_on(*b) for x in kernels for b in x.blocks.values()):
            raise ExactnessError("only methods that carry one value are judged to digits")

    def _order_to_digits(self, declared: Mapping[str, Any], proposal: Proposal) -> Found:
        """Judge the orders that rounded coefficients have to a size of their residuals."""
        names = [SOLUTION, *(row.name for row in self.method.embedded)]
        if set(declared) != set(names):
            reason = f"the weights are {', '.join(names)}"
            return self._made(False, exact=True, value=None, residual=0.0, reason=reason)
        self._check_one_value()
        found = self.to_digits(declared)
        truth = all(x.truth for x in found.values())
        name, reason = next(((k, x.reason) for k, x in found.items() if not x.truth), ("", ""))
        return self._made(
            truth,
            exact=True,
            value={k: list(x) for k, x in declared.items()} if truth else None,
            residual=max(float(e) for _, e in declared.values()),
            reason=f"row {name}: {reason}" if name and len(found) > 1 else reason,
        )
