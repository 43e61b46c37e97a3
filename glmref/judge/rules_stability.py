"""Rules for linear stability (section 5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from .arithmetic import Fraction, Number, Ring, tick
from .document import Component
from .grammar import rational
from .linalg import (
    blocks_of,
    characteristic,
    combine,
    dot,
    entries,
    identity,
    inverse_matrix,
    minus,
    multiples,
    scale,
    times,
)
from .numbers import apart, conj, live, vanishes
from .polynomials import (
    OnAxis,
    divide,
    gcd,
    horner,
    in_disc,
    interpolate,
    is_schur,
    is_unbounded,
    margins,
    multiply,
    no_root_but_zero,
    nowhere_negative,
    plus,
    trim,
)
from .rule import Bounded, Case, Flag, NoWitness, Rule, Truth, either_way

STABILITY = (
    "Hairer, Wanner, Solving Ordinary Differential Equations II (1996), V.1 and V.9; "
    "docs/certificates.md, section 5"
)


class PowerSeries(Ring):
    """A series in z through a power; what lies above is left out."""

    __slots__ = ("c",)

    def __init__(self, c: list) -> None:
        self.c = c

    def __bool__(self) -> bool:
        return any(map(live, self.c))

    def __add__(self, other: Number) -> PowerSeries:
        if not isinstance(other, PowerSeries):
            return PowerSeries([self.c[0] + other, *self.c[1:]])
        return PowerSeries([x + y for x, y in zip(self.c, other.c, strict=True)])

    def __mul__(self, other: Number) -> PowerSeries:
        if not isinstance(other, PowerSeries):
            return PowerSeries(multiples(other, self.c))
        tick()
        return PowerSeries([dot(self.c[: k + 1], other.c[k::-1]) for k, _ in enumerate(self.c)])

    __radd__, __rmul__ = __add__, __mul__


def stability(A: list, U: list, B: list, V: list) -> tuple[PowerSeries, list]:
    """Return det(I - z A) and M(z) = V + z B U + z^2 B A U + .. through the power s of z."""
    none, stages, terms = [Fraction(0)] * len(A), U, [V]
    for _ in A:
        terms.append(times(B, stages))
        stages = times(A, stages)
    below = PowerSeries([Fraction(1), *none])
    for block in blocks_of(A):
        below = below * PowerSeries((characteristic(block)[::-1] + none)[: len(A) + 1])
    M = [[PowerSeries([term[i][j] for term in terms]) for j, _ in enumerate(V)]
         for i, _ in enumerate(V)]  # fmt: skip
    return below, M


def stability_polynomial(A: list, U: list, B: list, V: list) -> list:
    """Return P(w, z) = det(w I - M(z)) det(I - z A): for each power of w a polynomial in z.

    Its degree in z is at most s. With few stages and many values the two change places: it is
    w^r z^s P'(1/z, 1/w), P' that of V, B, U, A in the place of A, U, B, V.
    """
    if len(A) < len(V):
        turned = stability_polynomial(V, B, U, A)
        return [[p[len(V) - k] for p in reversed(turned)] for k in range(len(V) + 1)]
    below, M = stability(A, U, B, V)
    return [(below * c).c for c in characteristic(M)]


def poles(m: Component) -> list:
    """Return det(I - z A) without what it shares with all entries of M(z) det(I - z A)."""
    below, M = stability(*m)
    common = trim(below.c)
    for entry in (x for row in M for x in row):
        common = gcd(common, (below * entry).c) if below * entry else common
    return divide(below.c, common)[0]


def poles_lie_right(m: Component) -> bool:
    """Rule a-stable (2): all poles have Re z > 0."""
    d = poles(m)
    n, q = len(d) - 1, []
    for k, c in enumerate(d):  # z = (x + 1) / (x - 1): Re z > 0 is |x| > 1
        term = [c]
        for factor in [[Fraction(1), Fraction(1)]] * k + [[Fraction(-1), Fraction(1)]] * (n - k):
            term = multiply(term, factor)
        q = plus(q, term)
    backwards = (q + [Fraction(0)] * (n + 1 - len(q)))[::-1]
    return bool(backwards[-1]) and is_schur(backwards)  # a pole at z = -1 makes the last one 0


def discriminant(P: list) -> list:
    """Return the resultant of P(w, z) and its derivative by w, a polynomial in z."""
    n = len(P) - 1
    degree = (2 * n - 1) * max(len(p) - 1 for p in P)
    nodes = [Fraction(k) for k in range(degree + 1)]
    values = []
    for z in nodes:
        p = [horner(c, z) if c else Fraction(0) for c in P]
        q = [k * c for k, c in enumerate(p)][1:]
        none = [Fraction(0)]
        rows = [none * k + p[::-1] + none * (n - 2 - k) for k in range(n - 1)]
        rows += [none * k + q[::-1] + none * (n - 1 - k) for k in range(n)]
        values.append(characteristic(rows)[0] * (-1) ** len(rows))  # the determinant
    return trim(interpolate(nodes, values))


def never_meet(P: list) -> bool:
    """Tell whether the eigenvalues other than fixed zeros are different at all y but 0 (5).

    The real and the imaginary part of the discriminant at i y have no common root but 0.
    """
    while P and not trim(P[0]):
        P = P[1:]
    if len(P) < 3:
        return True
    found = discriminant(P)
    if not found:
        return False
    even = trim([c * (-1) ** (k // 2) if k % 2 == 0 else Fraction(0) for k, c in enumerate(found)])
    odd = trim([c * (-1) ** (k // 2) if k % 2 else Fraction(0) for k, c in enumerate(found)])
    return no_root_but_zero(gcd(even, odd) if even and odd else even or odd)


def differences(P: list, lower: Callable[[list, Number], list] | None = None) -> list[list | None]:
    """Return the differences of Schur and Cohn of P(w, i y), None for a step of Cohn that fails.

    They are polynomials in y, of real methods even: a difference is its own conjugate.
    """
    found = margins(map(OnAxis, P), lower)
    return [x if x is None else [c * (-1) ** (k // 2) for k, c in enumerate(x.p)] for x in found]


class Axis(NamedTuple):
    """The differences of Schur and Cohn of P(w, i y), real polynomials in y.

    `outside` says that a step of Cohn fails, so that an eigenvalue is outside for almost every y. A
    difference that is 0 for all y is the empty list: the eigenvalues left are on the circle.
    """

    differences: list
    outside: bool


class StabilityCase(Case):
    """A part about M(z) = V + z B (I - z A)^-1 U."""

    @cached_property
    def m(self) -> Component:
        """Return the component."""
        return self.method.single()

    @cached_property
    def P(self) -> list:
        """Return P(w, z) = det(w I - M(z)) det(I - z A)."""
        return [trim(p) for p in stability_polynomial(*self.m)]

    @cached_property
    def at_infinity(self) -> list:
        """Return the coefficient of the highest power of z in P, a polynomial in w."""
        high = max(len(p) for p in self.P) - 1
        return trim([p[high] if len(p) > high else Fraction(0) for p in self.P])

    @property
    def stays_finite(self) -> bool:
        """Tell whether all eigenvalues have finite limits at infinity."""
        return len(self.at_infinity) == self.m.r + 1

    @cached_property
    def axis(self) -> Axis:
        """Return the differences on the imaginary axis."""
        found = differences(self.P)
        return Axis([x for x in found if x is not None], None in found)

    @property
    def is_negative(self) -> bool:
        """Tell whether a difference is negative somewhere on the imaginary axis."""
        return not all(not x or nowhere_negative(x) for x in self.axis.differences)


def V_is_power_bounded(case: StabilityCase) -> bool:
    """(1) The powers of V are shown by `bounded` to be bounded."""
    return bool(case.proof.all_shown(Bounded))


def method_has_real_entries(case: StabilityCase) -> bool:
    """The method is real: linear stability of complex methods is not covered."""
    return all(conj(x) == x for x in entries(case.m))


def poles_are_on_the_right(case: StabilityCase) -> bool:
    """(2) All poles of M lie in Re z > 0."""
    return poles_lie_right(case.m)


def limits_are_in_the_disc(case: StabilityCase) -> bool:
    """(3) The eigenvalues have limits at infinity, in the closed disc."""
    return case.stays_finite and in_disc(case.at_infinity)


def no_step_of_Cohn_fails(case: StabilityCase) -> bool:
    """(4) No step of Cohn fails on the imaginary axis."""
    return not case.axis.outside


def no_difference_is_negative(case: StabilityCase) -> bool:
    """(4) No difference of Schur and Cohn is negative on the imaginary axis."""
    return not case.is_negative


def eigenvalues_on_the_circle_do_not_meet(case: StabilityCase) -> bool:
    """(5) r = 1, or for y other than 0 no eigenvalue is on the circle, or no two of them meet."""
    inside = all(x and no_root_but_zero(x) for x in case.axis.differences)
    return case.m.r == 1 or inside or never_meet(case.P)


# ---------------------------------------------------------------------------- not stable


@dataclass(frozen=True)
class Reason:
    """One reason why a method is not A-stable: a rational y, or which condition does not hold."""

    y: str | None = None
    infinity: Flag = False
    pole: Flag = False
    axis: Flag = False
    start: Flag = False


class NotStableCase(StabilityCase):
    """A part that names one reason why a method is not A-stable."""

    witness: Reason


def one_reason_is_given(case: NotStableCase) -> bool:
    """One reason is given, with true as its value but for `y`."""
    return sum(x is not None and x is not False for x in vars(case.witness).values()) == 1


def powers_grow_at_y(case: NotStableCase) -> bool:
    """For `y` the powers of M(i y) of a real method are not bounded."""
    y = case.witness.y
    return y is None or (
        method_has_real_entries(case) and is_unbounded(at_imaginary(case.m, rational(y)))
    )


def a_limit_is_outside(case: NotStableCase) -> bool:
    """For `infinity` (3) does not hold."""
    return not (case.witness.infinity and limits_are_in_the_disc(case))


def a_pole_is_on_the_left(case: NotStableCase) -> bool:
    """For `pole` (2) does not hold."""
    return not (case.witness.pole and poles_are_on_the_right(case))


def an_eigenvalue_on_the_axis_is_outside(case: NotStableCase) -> bool:
    """For `axis` (4) does not hold, of a real method."""
    if not case.witness.axis:
        return True
    return method_has_real_entries(case) and (case.axis.outside or case.is_negative)


def powers_of_V_grow(case: NotStableCase) -> bool:
    """For `start` the powers of V are shown by `unbounded` not to be bounded."""
    return not case.witness.start or Truth("zero-stable", False) in case.proof.shown


def at_imaginary(m: Component, y: Number) -> list:
    """Return M(i y) of a real method as a real matrix of twice the size, i as [[0, -1], [1, 0]]."""

    def twice(M: list, real_part: bool) -> list:
        zero = [[Fraction(0)] * len(M[0]) for _ in M]
        first, second = (M, zero) if real_part else (zero, scale(y, M))
        above = [[*a, *(-x for x in b)] for a, b in zip(first, second, strict=True)]
        return above + [[*b, *a] for a, b in zip(first, second, strict=True)]

    A, B = twice(m.A, False), twice(m.B, False)
    back = inverse_matrix(minus(identity(len(A)), A))
    return combine(twice(m.V, True), times(B, back, twice(m.U, True)))


# ---------------------------------------------------------------------------- the limit


def limits_are_0(case: StabilityCase) -> bool:
    """All eigenvalues tend to 0 at infinity."""
    return case.stays_finite and vanishes(case.at_infinity[:-1])


def a_limit_is_not_0(case: StabilityCase) -> bool:
    """An eigenvalue tends to another limit than 0 at infinity, or to none."""
    return not case.stays_finite or any(map(apart, case.at_infinity[:-1]))


STABILITY_RULES = (
    Rule(
        "a-stable", "a-stable", "holds",
        "by the maximum principle the eigenvalues are in the disc for Re z <= 0 when there is no "
        "pole and they are on the axis and at infinity; those on the circle are semisimple when "
        "they are different",
        STABILITY, NoWitness, StabilityCase,
        (V_is_power_bounded, method_has_real_entries, poles_are_on_the_right,
         no_step_of_Cohn_fails, no_difference_is_negative,
         eigenvalues_on_the_circle_do_not_meet),
    ),
    Rule(
        "not-a-stable", "a-stable", "fails",
        "each of (1) to (4) is necessary, and so are bounded powers at every point of the axis",
        STABILITY, Reason, NotStableCase,
        (one_reason_is_given, powers_grow_at_y, a_limit_is_outside, a_pole_is_on_the_left,
         an_eigenvalue_on_the_axis_is_outside, powers_of_V_grow),
    ),
    *either_way(
        "l-limit not-l-limit", "l-stable", "the definition", STABILITY, StabilityCase,
        (limits_are_0,), (a_limit_is_not_0,),
    ),
)  # fmt: skip
