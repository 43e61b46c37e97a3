r"""Explicit linear multistep methods, strongly stable, with hardly any dissipation, exactly.

The formula ``rho(E) y_n = h sigma(E) f(y_n)`` has

    rho(z) = (z - 1) prod_j (z^2 - a_j z + b_j) prod_j (z + m_j),

all roots but 1 inside the unit circle, and sigma of a lower degree than rho. A parasitic part of
the solution then decays by a factor in every step, where that of a symmetric formula, with its
roots on the circle, grows with ``exp(mu_zeta f_y t)`` on some systems.

*Order.* With t = z - 1 and ``rho(z)/log z = sum s_j t^j``, order p means ``sigma = sum_{j < p} s_j
t^j + sum_{j >= p} (s_j + e_j) t^j``. Of k steps, k = p to p + 3 are used: e_j = -s_j from j = k on,
and the k - p others are free.

*Dissipation.* With z = exp(x), the smooth part of the solution of y' = f(y) obeys ``y' = g(h D)
f(y)``,

    g = x sigma/rho = 1 + C_p x^p + C_{p+1} x^{p+1} + ..,

to which e_j adds ``e_j x t^j/rho``. Where g is even and f = J grad H, the equation is variational,
and the smooth part keeps an energy near H to every order: for p even the energy drifts by the odd
C_{p+1}, C_{p+3}, .. only. With k = p + 1 and more C_{p+1} = 0 is chosen, and the drift begins at
h^{p+3}; with k = p + 3 also C_{p+3} = 0, and it begins at h^{p+5}. From k = p + 2 on C_p is free.

*Values.* As in :mod:`.halves`, with other blocks: v <- a v - b v' + h f, v' <- v for a pair of
roots, x <- -(m x + h f) for the root -m.

References
----------
    Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I" (1993), section III.2;
    Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), section XV.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, reduce
from typing import Any

from ..errors import UsageError
from ..judge.polynomials import multiply, plus
from .general_multistep import picard_start
from .halves import Series, dot, exponential, quotient, series_product, solve
from .multistep import written

_ZERO, _ONE = Fraction(0), Fraction(1)
#: The largest even order of a start in a file.
MOST_ORDER = 18
#: Terms of the series g from x^p on that may be chosen, or are the first that are not.
_TERMS = 4


def _shifted(p: Sequence[Fraction], by: Fraction) -> list[Fraction]:
    """Return the coefficients of p(x + by), the constant one first."""
    found: list[Fraction] = []
    for c in reversed(p):
        found = plus(multiply(found, [by, _ONE]), [c])
    return [*found, *[_ZERO] * len(p)][: len(p)]


@dataclass(frozen=True)
class StrongFormula:
    """A formula given by its roots.

    Raises
    ------
    UsageError
        For roots on or outside the unit circle, equal ones, or too few or many for the order.
    """

    order: int  #: The order p, even.
    pairs: tuple[tuple[Fraction, Fraction], ...]  #: (a_j, b_j).
    reals: tuple[Fraction, ...]  #: m_j of the roots -m_j.
    constant: Fraction | None = None  #: C_p, where k > p + 1.

    def __post_init__(self) -> None:
        factors = [*self.pairs, *((-m, _ZERO) for m in self.reals)]
        if len(set(factors)) < len(factors) or any(a * a == 4 * b for a, b in self.pairs):
            raise UsageError("the roots must be different")
        if any(not abs(b) < 1 or not abs(a) < 1 + b for a, b in factors):
            raise UsageError("the roots must lie inside the unit circle")
        free = self.steps - self.order
        if not 2 <= self.order <= MOST_ORDER:
            raise UsageError(f"the order must be from 2 to {MOST_ORDER}, got {self.order}")
        if self.order % 2 or not 0 <= free <= 3:
            raise UsageError(
                f"{self.steps} steps do not have an even order of {self.order}: give {self.order} "
                f"to {self.order + 3} roots with 1"
            )
        if (self.constant is None) == (free > 1):
            raise UsageError(
                f"the error constant is free from {self.order + 2} steps on, and must be given "
                "there only"
            )

    @property
    def steps(self) -> int:
        """The steps k."""
        return 1 + 2 * len(self.pairs) + len(self.reals)

    def _others(self, leave: int = -1) -> list[Fraction]:
        """Return rho/(z - 1) without the block of one number, pairs first."""
        blocks = [[b, -a, _ONE] for a, b in self.pairs] + [[m, _ONE] for m in self.reals]
        return reduce(multiply, (x for i, x in enumerate(blocks) if i != leave), [_ONE])

    @cached_property
    def rho(self) -> list[Fraction]:
        """The coefficients, the constant one first."""
        return multiply([-_ONE, _ONE], self._others())

    @cached_property
    def _parts(self) -> list[Series]:
        """x^p, .., x^{p+3} in ``x t^j/rho``, for j = p, .., p + 3: (4, 4)."""
        t = exponential(_ONE, _TERMS + 1)[1:]  # over x
        ratio, power = [_ZERO] * _TERMS, [_ONE, *[_ZERO] * (_TERMS - 1)]
        for i, c in enumerate(_shifted(self.rho, _ONE)[1 : _TERMS + 1]):
            ratio = [x + c * y for x, y in zip(ratio, [*[_ZERO] * i, *power], strict=False)]
            power = series_product(power, t)
        power = reduce(series_product, [t] * (self.order - 1), [_ONE, *[_ZERO] * (_TERMS - 1)])
        found = []
        for i in range(_TERMS):
            found.append([*[_ZERO] * i, *quotient(power, ratio)][:_TERMS])
            power = series_product(power, t)
        return found

    @cached_property
    def _series(self) -> tuple[Series, Series]:
        """s_j for j below p + 4, and e_j from p on."""
        p, free, n = self.order, self.steps - self.order, self.order + _TERMS
        over_t = [*_shifted(self.rho, _ONE)[1:], *[_ZERO] * n][:n]
        s = quotient(over_t, [Fraction((-1) ** j, j + 1) for j in range(n)])
        known = [-x for x in s[p + free :]]
        wanted = ((), (1,), (0, 1), (0, 1, 3))[free]
        right = [
            (self.constant or _ZERO) * (m == 0)
            - dot(known, [part[m] for part in self._parts[free:]])
            for m in wanted
        ]
        return s, solve([[part[m] for part in self._parts[:free]] for m in wanted], right) + known

    @cached_property
    def sigma(self) -> list[Fraction]:
        """The coefficients, of degree k - 1."""
        s, e = self._series
        both = [*s[: self.order], *(x + y for x, y in zip(s[self.order :], e, strict=True))]
        return _shifted(both[: self.steps], -_ONE)

    @property
    def error_constants(self) -> Series:
        """C_p, .., C_{p+3}."""
        _, e = self._series
        return [dot(e, [part[m] for part in self._parts]) for m in range(_TERMS)]

    @property
    def U(self) -> list[Fraction]:
        """The stage, and the solution, from the values: (k,)."""
        k, columns = self.steps, list[list[Fraction]]()
        for i in range(len(self.pairs)):
            rest = multiply([-_ONE, _ONE], self._others(i))
            columns += [[_ZERO, *rest], [*rest, _ZERO]]
        for i in range(len(self.pairs), len(self.pairs) + len(self.reals)):
            columns.append([-x for x in multiply([-_ONE, _ONE], self._others(i))])
        columns.insert(0, self._others())
        return solve([[column[i] for column in columns] for i in range(k)], self.sigma)

    @property
    def entry(self) -> list[Fraction]:
        """What an evaluation is added to: (k,)."""
        return [_ONE, *[_ONE, _ZERO] * len(self.pairs), *[-_ONE] * len(self.reals)]

    @property
    def V(self) -> list[list[Fraction]]:
        """(k, k), 1 and a block for each pair and real root."""
        k = self.steps
        V = [[_ZERO] * k for _ in range(k)]
        V[0][0] = _ONE
        for j, (a, b) in enumerate(self.pairs):
            i = 2 * j + 1
            V[i][i], V[i][i + 1], V[i + 1][i] = a, -b, _ONE
        for i, m in enumerate(self.reals, 2 * len(self.pairs) + 1):
            V[i][i] = -m
        return V

    def values(self, length: int) -> list[Series]:
        """Return the values but the first as series in x = h D, times h y'."""
        one = [_ONE, *[_ZERO] * (length - 1)]
        z, square = (exponential(Fraction(n), length) for n in (1, 2))
        rows = []
        for a, b in self.pairs:
            block = [x - a * y + b * c for x, y, c in zip(square, z, one, strict=True)]
            rows += [quotient(z, block), quotient(one, block)]
        minus = [-c for c in one]
        rows += [quotient(minus, [x + m * c for x, c in zip(z, one, strict=True)])
                 for m in self.reals]  # fmt: skip
        return rows


def strong_document(name: str, formula: StrongFormula, title: str) -> dict[str, Any]:
    """Build the method and its start of the same order, exact, without claims and source."""
    return written({
        "format": "glmref-method-1",
        "name": name,
        "title": title,
        "class": "glm",
        "A": [[_ZERO]],
        "U": [formula.U],
        "B": [[x] for x in formula.entry],
        "V": formula.V,
        "output": formula.U,
        "starting": {**picard_start(formula, order=formula.order), "order": formula.order},
    })  # fmt: skip
