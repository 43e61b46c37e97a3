"""Higher derivatives of a problem's functions along given directions, without differences.

f is evaluated at ``y + s_1 a_1 + s_2 a_2 + ..`` with variables s_i of which the powers beyond k_i
are dropped: the coefficient of ``s_1^k_1 s_2^k_2 ..``, times the factorials of the k_i, is the
derivative of f with each a_i k_i times among its arguments, exact but for rounding (Griewank and
Walther, "Evaluating Derivatives", 2nd ed. (2008), chapter 13).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import factorial, prod
from typing import Any

import numpy as np

from ..errors import UsageError
from .precision import on_context

_Exponents = tuple[int, ...]


class Truncation:
    """Polynomials in s_1, s_2, .. truncated at the powers k_1, k_2, ..; stands in for a context.

    Their coefficients are of an mpmath context, of ``mpmath.fp`` for doubles.
    """

    def __init__(self, powers: _Exponents, context: Any) -> None:
        self.powers, self.context = powers, context
        self.mpf, self.pi = context.mpf, context.pi

    def along(self, y: Sequence[Any], directions: Sequence[Any]) -> np.ndarray:
        """Return ``y + sum of s_i a_i``, (d,)."""
        nil = (0,) * len(self.powers)
        units = [(*nil[:i], 1, *nil[i + 1 :]) for i in range(len(nil))]
        moved = np.empty(len(y), dtype=object)
        for j, x in enumerate(y):
            slopes = {e: a[j] for e, a in zip(units, directions, strict=True)}
            moved[j] = Nilpotent(self, {nil: x, **slopes})
        return moved

    def derivative(self, value: Any) -> Any:
        """Return the derivative that a value of a function carries."""
        if not isinstance(value, Nilpotent):
            return self.mpf(0) if any(self.powers) else value
        found = value.terms.get(self.powers, self.mpf(0))
        return found * prod(map(factorial, self.powers))

    def _series(self, x: Any, name: str, rule: Callable[[Any, int], Any]) -> Any:
        """Return g(x) from g and the Taylor coefficients ``rule(x_0, k)`` of g at x_0."""
        if not isinstance(x, Nilpotent):
            return getattr(self.context, name)(x)
        return x.taylor(rule)

    def sin(self, x: Any) -> Any:
        """Sine."""
        c = self.context
        return self._series(
            x, "sin", lambda a, k: (c.sin(a), c.cos(a), -c.sin(a), -c.cos(a))[k % 4] / factorial(k)
        )

    def cos(self, x: Any) -> Any:
        """Cosine."""
        c = self.context
        return self._series(
            x, "cos", lambda a, k: (c.cos(a), -c.sin(a), -c.cos(a), c.sin(a))[k % 4] / factorial(k)
        )

    def tan(self, x: Any) -> Any:
        """Tangent."""
        return self.sin(x) / self.cos(x) if isinstance(x, Nilpotent) else self.context.tan(x)

    def exp(self, x: Any) -> Any:
        """Exponential."""
        return self._series(x, "exp", lambda a, k: self.context.exp(a) / factorial(k))

    def log(self, x: Any) -> Any:
        """Logarithm."""

        def rule(a: Any, k: int) -> Any:
            return (-1) ** (k + 1) / (k * a**k) if k else self.context.log(a)

        return self._series(x, "log", rule)

    def sqrt(self, x: Any) -> Any:
        """Square root."""
        return x ** (self.mpf(1) / 2) if isinstance(x, Nilpotent) else self.context.sqrt(x)

    def atan2(self, u: Any, x: Any) -> Any:
        """Return the angle of the point (x, u): its change is the imaginary part of a logarithm."""
        if not (isinstance(u, Nilpotent) or isinstance(x, Nilpotent)):
            return self.context.atan2(u, x)
        u, x = (v if isinstance(v, Nilpotent) else self._constant(v) for v in (u, x))
        a, b = u.constant, x.constant
        du, dx, square = u - a, x - b, a * a + b * b
        re, im = (dx * b + du * a) / square, (du * b - dx * a) / square
        total, power_re, power_im = im + self.context.atan2(a, b), re, im
        for k in range(2, sum(self.powers) + 1):
            power_re, power_im = power_re * re - power_im * im, power_re * im + power_im * re
            total = total + power_im * self.mpf((-1) ** (k + 1)) / k
        return total

    def _constant(self, value: Any) -> Nilpotent:
        return Nilpotent(self, {(0,) * len(self.powers): self.mpf(value)})


class Nilpotent:
    """A polynomial of a :class:`Truncation`, with the operations of a number."""

    __slots__ = ("of", "terms")

    def __init__(self, of: Truncation, terms: dict[_Exponents, Any]) -> None:
        self.of, self.terms = of, terms

    @property
    def constant(self) -> Any:
        """The coefficient without variables."""
        return self.terms.get((0,) * len(self.of.powers), self.of.mpf(0))

    def taylor(self, rule: Callable[[Any, int], Any]) -> Nilpotent:
        """Return the sum of ``rule(constant, k)`` times the k-th power of the rest."""
        a, rest = self.constant, dict(self.terms)
        rest.pop((0,) * len(self.of.powers), None)
        step = Nilpotent(self.of, rest)
        power, total = self.of._constant(1), self.of._constant(rule(a, 0))
        for k in range(1, sum(self.of.powers) + 1):
            power = power * step
            if not power.terms:
                break
            total = total + power * rule(a, k)
        return total

    def __add__(self, other: Any) -> Any:
        terms = dict(self.terms)
        found = other.terms if isinstance(other, Nilpotent) else self.of._constant(other).terms
        for e, x in found.items():
            terms[e] = terms[e] + x if e in terms else x
        return Nilpotent(self.of, terms)

    __radd__ = __add__

    def __neg__(self) -> Any:
        return Nilpotent(self.of, {e: -x for e, x in self.terms.items()})

    def __pos__(self) -> Any:
        return self

    def __sub__(self, other: Any) -> Any:
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if not isinstance(other, Nilpotent):
            return Nilpotent(self.of, {e: x * other for e, x in self.terms.items()})
        terms: dict[_Exponents, Any] = {}
        for e, x in self.terms.items():
            for f, y in other.terms.items():
                total = tuple([i + j for i, j in zip(e, f, strict=True)])
                if all(i <= k for i, k in zip(total, self.of.powers, strict=True)):
                    terms[total] = terms[total] + x * y if total in terms else x * y
        return Nilpotent(self.of, terms)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self * other**-1 if isinstance(other, Nilpotent) else self * (1 / self.of.mpf(other))

    def __rtruediv__(self, other: Any) -> Any:
        return self**-1 * other

    def __pow__(self, exponent: Any) -> Any:
        if isinstance(exponent, Nilpotent):
            return self.of.exp(exponent * self.of.log(self))
        whole = int(exponent) if exponent == int(exponent) else None
        power = exponent if whole is None else whole

        def rule(a: Any, k: int) -> Any:
            if whole is not None and 0 <= whole < k:
                return self.of.mpf(0)
            binomial = self.of.mpf(1)
            for i in range(k):
                binomial = binomial * (power - i) / (i + 1)
            return binomial * a ** (power - k)

        return self.taylor(rule)

    def __rpow__(self, base: Any) -> Any:
        return self.of.exp(self * self.of.context.log(base))


class Derivatives:
    """Derivatives of every order of one function of a problem at one state (d,).

    The function is of one vector, or of (t, y) if ``timed`` (the time is 0 then), and given by
    expressions; ``context`` is one of mpmath, or ``None`` for doubles.
    """

    def __init__(self, function: Any, y: Any, context: Any, *, timed: bool) -> None:
        import mpmath

        self.context = mpmath.fp if context is None else context
        self.function, self.y, self.timed = function, [self.context.mpf(x) for x in y], timed
        self._in: dict[_Exponents, tuple[Truncation, Any]] = {}

    def along(self, directions: Sequence[tuple[Any, int]]) -> list[Any]:
        """Return ``f^(m)(a_1, .., a_1, a_2, ..)``, each a_i (d,) as often as the number says.

        Raises
        ------
        UsageError
            Where the function does not work on polynomials: it must be given by expressions.
        """
        powers = tuple(k for _, k in directions)
        try:
            if powers not in self._in:
                truncation = Truncation(powers, self.context)
                self._in[powers] = truncation, on_context(self.function, truncation)
            truncation, function = self._in[powers]
            state = truncation.along(self.y, [a for a, _ in directions])
            values = function(self.context.mpf(0), state) if self.timed else function(state)
            found = [truncation.derivative(x) for x in np.atleast_1d(values)]
        except (TypeError, AttributeError, UsageError) as error:
            raise UsageError(
                f"derivatives of every order need the problem's functions as expressions ({error})"
            ) from None
        return found
