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
from functools import cached_property
from itertools import islice
from math import floor
from typing import TYPE_CHECKING, Any

from ..catalogue.claims import SOLUTION
from ..errors import ExactnessError
from ..exact import Exact, rounded_decimal
from ..exact.judging import Fraction as rational
from ..exact.judging import fast_judge
from ..exact.linalg import Vector
from ..judge.grammar import two_digits
from ..system.budget import spend
from ..theory.starting_series import within_limits
from ..theory.trees import from_judged

if TYPE_CHECKING:
    from .kernel import Found

#: A tree as the judge writes it: the colour, and the trees of the children in order.
Plain = tuple[str, tuple[Any, ...]]
#: A condition of the next order has a residual above so many times the one declared.
GAP = 1000
#: Trees with one branch that are tried before all trees of an order are listed.
ONE_BRANCH = 100
#: The last order of which all residuals are computed exactly, to say that they are 0.
LISTED = 8
#: Larger residuals are no roundings; where an order has more than so many trees, the second.
LARGE, ROUNDING, MANY = Fraction(1, 1000), Fraction(1, 10**9), 1500
#: A step of a staircase is a jump of the residuals by this factor.
JUMP = 100
#: The exponent of the smallest residuals that are distinguished from 0 where none is declared.
SMALLEST = 120


def rounded_up(x: Fraction) -> str:
    """Return a positive number rounded up to two digits, such as ``2.7e-83``; ``0`` of zero."""
    return f"{rounded_decimal(x, 2, ROUND_CEILING):.1e}" if x else "0"


def staircase_of(sizes: Sequence[Fraction], proved: int) -> list[str]:
    """Return orders beyond the proved one, with the largest residual through each, rounded up.

    Parameters
    ----------
    sizes : Sequence[Fraction]
        The largest residual through each order from 0; of the last nothing beyond is known.
    proved : int
        The order that holds exactly.
    """
    return [f"order {n} to {rounded_up(sizes[n])}" for n in range(len(sizes) - 2, proved, -1)
            if 0 < sizes[n] < LARGE and sizes[n + 1] > JUMP * sizes[n]]  # fmt: skip


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


def _rational(values: Sequence[Any]) -> tuple[Any, ...]:
    """Return rational numbers as the judge's."""
    found = []
    for x in values:
        fraction = x.as_fraction() if isinstance(x, Exact) else None
        if fraction is None:
            said = "the coefficients are not all rational numbers"
            if not isinstance(x, Exact):
                said = "`digits` makes each decimal an interval, and the claim is about the "
                said += "decimals themselves: leave `digits` out"
            raise ExactnessError(said)
        found.append(rational(fraction.numerator, fraction.denominator))
    return tuple(found)


class _Residuals:
    """Conditions of coloured stages in the fixed point of the judge, which keeps what it finds.

    Parameters
    ----------
    kernel : Kernel
        Of a method that carries one value.
    exponent : int
        The residuals are near ``10^-exponent``.
    nystrom : bool
        Whether the conditions are those of second-order systems.
    """

    def __init__(self, kernel: Any, exponent: int, nystrom: bool) -> None:
        self.palette = tuple(kernel.palette.items())
        tables = ((c, tuple(map(_rational, A))) for c, (A, *_) in kernel.blocks.items())
        self.found = fast_judge().fixed_point.sizes_of(
            tuple(tables), self.palette, kernel.method.system, nystrom, exponent
        )
        self.one = self.found.one

    def weights(self, b: Mapping[str, Any]) -> dict[str, Any]:
        """Return weights by colour, with what is known of their residuals."""
        return {c: self.found.weights(_rational(row)) for c, row in b.items()}

    def residual(self, t: Plain, b: Mapping[str, Any]) -> tuple[int, int]:
        """Return bounds of ``|b Phi(t) - 1 / gamma(t)|``, in units."""
        spend()
        low, high = self.found.residual(t, b[t[0]])
        return int(low), int(high)

    def exactly(self, t: Plain, b: Mapping[str, Any]) -> Fraction:
        """Return ``|b Phi(t) - 1 / gamma(t)|`` itself, in units."""
        found = self.found.exactly(t, b[t[0]])
        return Fraction(int(found.p), int(found.q))

    def above(self, order: int, b: Mapping[str, Any], low: int, limit: int) -> Iterator[Plain]:
        """Yield trees through an order that may have a residual above `limit`, or above `low`.

        Of the latter, which rises from order to order, those that others surely exceed are left.
        """
        for n in range(1, order + 1):
            level = self.found.level(n)
            if n < order - 1:
                self.found.prepare(level)
            sure = (max(map(abs, x.gaps)) - x.error for x in self.found.groups(n, b))
            low = max(low, *(int(x) - 1 for x in sure))
            yield from self.found.above(n, b, min(low, limit))

    def judged(self, weights: Mapping[str, Any], order: int, size: str) -> Sized:
        """Compare the residuals of the weights by colour with what is declared."""
        b = self.weights(weights)
        most, least = (x * self.one for x in two_digits(size))
        limit, step = floor(most), floor(least)
        low: int | Fraction = 0
        high: int | Fraction = 0
        largest: Plain | None = None
        for t in self.above(order, b, -1, limit):
            x: int | Fraction
            y: int | Fraction
            x, y = self.residual(t, b)
            if x <= limit < y or x <= step < y:  # it may be that number itself
                x = y = self.exactly(t, b)
            if x > limit and x > most:
                if rounded_up(Fraction(x, self.one)) != rounded_up(Fraction(y, self.one)):
                    y = self.exactly(t, b)
                found, tree = rounded_up(Fraction(y, self.one)), from_judged(t)
                reason = f"tree {tree} of order {tree.order} has residual {found}"
                return Sized(False, reason, str(tree))
            if x > low:
                low, largest = x, t
            high = max(high, y)
        if largest is None or not low > least:
            if low == 0 and order <= LISTED and self.vanish(b, order):
                reason = f"the residuals through order {order} are 0: claim the order without size"
                return Sized(False, reason, order=order)
            if low and rounded_up(Fraction(low, self.one)) != rounded_up(Fraction(high, self.one)):
                unsure = self.above(order, b, floor(low) - 1, limit)
                high = max(low, *(self.exactly(t, b) for t in unsure))
            shown = rounded_up(Fraction(high, self.one))
            reason = f"the residuals through order {order} are at most {shown}"
            return Sized(False, reason, order=order)
        assert high <= most, "a residual that may be larger was computed exactly"
        for t in self.beyond(order + 1):
            if self.residual(t, b)[1] > GAP * most and self.exactly(t, b) > GAP * most:
                return Sized(True, "", str(from_judged(largest)), str(from_judged(t)))
        reason = f"no condition of order {order + 1} has a residual above {GAP} times {size}"
        return Sized(False, reason, order=order + 1)

    def vanish(self, b: Mapping[str, Any], order: int) -> bool:
        """Return whether all conditions through an order hold exactly."""
        return all(
            self.exactly(t, b) == 0 for n in range(1, order + 1) for t in self.found.level(n)
        )

    def sizes(self, weights: Mapping[str, Any], most: int) -> list[Fraction]:
        """Return the largest residual through each order, last the first that is no rounding."""
        b = self.weights(weights)
        found = [Fraction(0)]
        for n in range(1, most + 1):
            largest, conditions = found[-1], 0
            for t in self.found.level(n):
                conditions += 1
                x, y = (Fraction(z, self.one) for z in self.residual(t, b))
                if y > largest:
                    sure = rounded_up(x) == rounded_up(y)
                    largest = y if sure else max(largest, self.exactly(t, b) / self.one)
            found.append(largest)
            if largest > (LARGE if conditions <= MANY else ROUNDING):
                return found
        beyond = islice(self.beyond(most + 1), ONE_BRANCH)
        last = max((self.residual(t, b)[1] for t in beyond), default=self.one)
        return [*found, max(found[-1], Fraction(last, self.one))]

    def beyond(self, order: int) -> Iterator[Plain]:
        """Yield trees of an order: first those with one branch.

        Of one method without a system of its own every tree counts, and those with one child need
        no list of the trees of their order.
        """
        if len(self.palette) == 1:
            for t in islice(self.found.level(order - 1), ONE_BRANCH + 2):
                yield self.palette[0][0], (t,)
        yield from self.found.level(order)


def _carries_on(A: Any, U: Any, B: Any, V: Any) -> bool:
    """Return whether U = 1 and V = 1: the value carried is the solution."""
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
        """Return the weights by name, b first, each as a row for each colour."""
        kernels = {SOLUTION: self, **dict(self.row_kernels)}
        return {
            name: {c: B[0] for c, (_, _, B, _) in x.timed.blocks.items()}
            for name, x in kernels.items()
        }

    def to_digits(self, declared: Mapping[str, Any]) -> dict[str, Sized]:
        """Return what is known of each of the declared orders, by the names of the weights."""
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
        found = _Residuals(self.timed, exponent, self._is_nystrom)
        with within_limits():
            return {name: found.judged(weights, *sized[name]) for name, weights in rows.items()}

    @cached_property
    def sizes_to_digits(self) -> dict[str, list[Fraction]]:
        """Largest residual through each order, by the names of the weights, at most.

        Each list ends with the first order whose residual is large.

        Raises
        ------
        ExactnessError
            Where several values are carried, or entries are not rational.
        """
        self._check_one_value()
        residuals = _Residuals(self.timed, SMALLEST, self._is_nystrom)
        most, rows = self._most(nystrom=self._is_nystrom), self._rows_of_weights()
        with within_limits():
            return {name: residuals.sizes(weights, most) for name, weights in rows.items()}

    def _check_one_value(self) -> None:
        kernels = (self, *(x for _, x in self.row_kernels)) if self.one_step else ()
        if not kernels or not all(_carries_on(*b) for x in kernels for b in x.blocks.values()):
            raise ExactnessError("only methods that carry one value are judged to digits")

    def _order_to_digits(self, declared: Mapping[str, Any]) -> Found:
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
