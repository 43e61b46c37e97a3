"""The tableau of section 3.4 as a function of c2, and when real forms exist.

With t = 1 - 2 c2 the abscissae are (0, (1 - t)/2, 1/2, (1 + t)/2, 1), and b and A are rational in
t. The sweep form (G = diag(1, -1, -1, 1) on 1, alpha, beta, gamma) asks for

    W = alpha alpha^T + beta beta^T - gamma gamma^T,   a_ij = b_j (1 - W_ij), half of it for j = i

with alpha antisymmetric and beta, gamma symmetric under reversal of the stages, so that W has
rank 3, and for no growth: sum b_i gamma_i^2 = 0, sum b_i (alpha_i^2 + beta_i^2) = 0. On symmetric
vectors, given by their first three entries, W is a 3 x 3 matrix S, and b is Q = diag(2 b1, 2 b2,
b3), q(v) = v^T Q v. From b^T W = 0 the kernel of S is spanned by (2 b1, 2 b2, b3), so a vector
gamma = gamma1 (1, rho, sigma) in its range has sigma = -2 (b1 + b2 rho) / b3, and q(gamma) = 0
leaves two directions, rho = (-2 b1 b2 +- sqrt(-b1 b2 b3)) / (b2 (b3 + 2 b2)). That S + gamma
gamma^T = beta beta^T has rank 1 gives gamma1^2 = -(s11 s22 - s12^2) / (s22 - 2 s12 rho + s11
rho^2) and beta1^2 = s11 + gamma1^2: both must be positive. sum b_i W_ii = 0 holds, which is the
other growth parameter.

**How large growth must be.** Let lambda_1, lambda_2 be the nonzero eigenvalues of S Q and
lambda_0 that of the antisymmetric part, alpha^T Q alpha. If they are real, gamma = sum x_k e_k in
eigenvectors with ``e_k^T W^+ e_k = +-1``, and any decomposition W = .. - gamma gamma^T (symmetric
or not) has gamma^T W^+ gamma = -1. With e_2 the one with -1: x_2^2 = 1 + x_1^2 + x_0^2 and ``sum
b gamma^2 = -lambda_2 + (lambda_1 - lambda_2) x_1^2 + (lambda_0 - lambda_2) x_0^2``. Where both
differences have the sign of -lambda_2, no growth parameter of -1 is smaller than |lambda_2|.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt, lcm

from ...errors import UsageError
from ...exact import Exact
from ..recognise import square_free


@dataclass(frozen=True)
class Family:
    """The rational part of the construction at one c2."""

    c2: Fraction  #: Abscissa of the second stage.
    A: tuple[tuple[Fraction, ...], ...]  #: (5, 5).
    b: tuple[Fraction, ...]  #: (5,), as c.
    c: tuple[Fraction, ...]
    W: tuple[tuple[Fraction, ...], ...]  #: (5, 5).

    @property
    def S(self) -> tuple[tuple[Fraction, ...], ...]:
        """Symmetric part of W under reversal, on the first three stages."""
        W = self.W
        return tuple(tuple((W[i][j] + W[i][4 - j]) / 2 for j in range(3)) for i in range(3))


def family(c2: Fraction) -> Family:
    """Return the tableau (A, b, c) and W at one c2.

    Raises
    ------
    UsageError
        Where the formulas have a pole: c2 = 0, 1/2, 1 or a vanishing weight.
    """
    t = 1 - 2 * c2
    poles = (t, t - 1, t + 1, 5 * t * t - 1)
    if any(x == 0 for x in poles):
        raise UsageError(f"`c2` must not be 0, 1/2 or 1, got {c2}: two abscissae coincide")
    b1 = (5 * t**2 - 3) / (30 * (t**2 - 1))
    b2 = 1 / (15 * t**2 * (1 - t**2))
    b3 = 2 * (5 * t**2 - 1) / (15 * t**2)
    e, f = 5 * t**2 - 1, 5 * t**2 - 3
    zero = Fraction(0)
    A = (
        (zero,) * 5,
        (c2 / 2, c2 / 2, zero, zero, zero),
        ((2 * t**2 - 2 * t + 1) / (4 - 4 * t), (1 - 2 * t) / (4 - 4 * t), t / 2, zero, zero),
        (
            e * (4 * t**3 + 2 * t**2 - 2 * t + 1) / (4 * (t - 1)),
            -(t + 1) * (10 * t**3 - 5 * t**2 - t + 1) / (2 * (t - 1)),
            -(t + 1) * (2 * t - 1) * e / 2,
            (1 - t) / 4,
            zero,
        ),
        (
            t * (10 * t**3 + 5 * t**2 - 7 * t + 2) / ((t - 1) * f),
            -e * (4 * t**3 + 2 * t**2 - 2 * t + 1) / (2 * t**2 * (t - 1) * f),
            -(t + 1) * e * (2 * t**2 - 2 * t + 1) / (t**2 * f),
            (t - 1) / (2 * t**2 * f),
            zero,
        ),
    )  # fmt: skip
    b = (b1, b2, b3, b2, b1)
    c = (zero, c2, Fraction(1, 2), 1 - c2, Fraction(1))
    W = [[zero] * 5 for _ in range(5)]
    for i in range(5):
        for j in range(i + 1):
            W[i][j] = W[j][i] = 1 - A[i][j] * (2 if i == j else 1) / b[j]
    return Family(c2, A, b, c, tuple(map(tuple, W)))


@dataclass(frozen=True)
class Quadratic:
    """A number p + q sqrt(n) with one n for all; n = 1 stands for the rationals."""

    p: Fraction
    q: Fraction
    n: int

    def __add__(self, other: Quadratic | Fraction) -> Quadratic:
        other = self._same(other)
        return Quadratic(self.p + other.p, self.q + other.q, self.n)

    def __mul__(self, other: Quadratic | Fraction) -> Quadratic:
        other = self._same(other)
        p = self.p * other.p + self.n * self.q * other.q
        return Quadratic(p, self.p * other.q + self.q * other.p, self.n)

    def __truediv__(self, other: Quadratic | Fraction) -> Quadratic:
        other = self._same(other)
        norm = other.p**2 - self.n * other.q**2
        conjugate = Quadratic(other.p / norm, -other.q / norm, self.n)
        return self * conjugate

    def _same(self, other: Quadratic | Fraction) -> Quadratic:
        return Quadratic(other, Fraction(0), self.n) if isinstance(other, Fraction) else other

    def exact(self) -> Exact:
        """Return the number itself."""
        return Exact(self.n).sqrt() * self.q + self.p

    def sign(self) -> int:
        """Return its sign, decided exactly."""
        return self.exact().sign()

    def quotient_text(self) -> str:
        """Return the text over one denominator, ``(65274*sqrt(330)-347009)/1265902``."""
        common = lcm(self.p.denominator, self.q.denominator)
        top = _sum_text(self.p * common, self.q * common, self.n, root_first=True)
        return top if common == 1 else f"({top})/{common}"

    def factor_text(self, name: str) -> str:
        """Return the product with a name, ``-(218581/423279+2024*sqrt(330)/141093)*beta1``."""
        p, q = self.p, self.q
        if p <= 0 and q <= 0:
            return f"-({_sum_text(-p, -q, self.n, root_first=False)})*{name}"
        return f"({_sum_text(p, q, self.n, root_first=p < 0)})*{name}"


def _sum_text(p: Fraction, q: Fraction, n: int, *, root_first: bool) -> str:
    root = "" if q == 0 else _root_term(q, n)
    if q == 0 or p == 0:
        return root or str(p)
    first, second = (root, str(p)) if root_first and q > 0 else (str(p), root)
    return first + (second if second.startswith("-") else f"+{second}")


def _root_term(q: Fraction, n: int) -> str:
    factor = "" if q.numerator == 1 else "-" if q.numerator == -1 else f"{q.numerator}*"
    return f"{factor}sqrt({n})" + ("" if q.denominator == 1 else f"/{q.denominator}")


def _square_root(value: Fraction) -> tuple[Fraction, int]:
    """Write sqrt(value) as q sqrt(n) with n free of squares."""
    n, outside = square_free(value, 100_000)
    root = isqrt(n)
    if root * root == n:
        outside, n = outside * root, 1
    return Fraction(outside, value.denominator), n


@dataclass(frozen=True)
class Forms:
    """Squares and ratios that give alpha, beta and gamma."""

    alpha_square: Fraction  #: alpha1^2.
    alpha_ratio: Fraction  #: alpha2 / alpha1.
    beta_square: Quadratic  #: beta1^2.
    beta_ratios: tuple[Quadratic, Quadratic]  #: beta2 / beta1, beta3 / beta1.
    gamma_square: Quadratic  #: gamma1^2.
    gamma_ratios: tuple[Quadratic, Quadratic]  #: gamma2 / gamma1, gamma3 / gamma1.

    def is_real(self) -> bool:
        """Return whether alpha1, beta1 and gamma1 are real."""
        squares = (self.beta_square, self.gamma_square)
        return self.alpha_square > 0 and all(x.sign() > 0 for x in squares)


def antisymmetric(member: Family) -> tuple[Fraction, Fraction]:
    """Return alpha1^2 and alpha2 / alpha1."""
    W = member.W
    square = (W[0][0] - W[0][4]) / 2
    return square, (W[0][1] - W[0][3]) / 2 / square


def solve_forms(member: Family) -> list[Forms]:
    """Return the one or two candidates for the forms; none where sqrt(-b1 b2 b3) is not real."""
    b1, b2, b3 = member.b[:3]
    S = member.S
    if -b1 * b2 * b3 < 0:
        return []
    size, n = _square_root(-b1 * b2 * b3)
    alpha_square, alpha_ratio = antisymmetric(member)
    found = []
    for sign in (1, -1):
        below = b2 * (b3 + 2 * b2)
        root = sign * size / below
        p = -2 * b1 * b2 / below
        rho = Quadratic(p + root, Fraction(0), 1) if n == 1 else Quadratic(p, root, n)
        sigma = (rho * b2 + b1) * (-2 / b3)
        along = rho * rho * S[0][0] + rho * (-2 * S[0][1]) + S[1][1]
        minus_determinant = S[0][1] ** 2 - S[0][0] * S[1][1]
        gamma_square = Quadratic(minus_determinant, Fraction(0), rho.n) / along
        beta_square = gamma_square + S[0][0]
        ratios = [
            (gamma_square * x + s) / beta_square for x, s in ((rho, S[0][1]), (sigma, S[0][2]))
        ]
        found.append(
            Forms(
                alpha_square, alpha_ratio, beta_square, (ratios[0], ratios[1]),
                gamma_square, (rho, sigma),
            )
        )  # fmt: skip
    return found


def least_growth(member: Family) -> Exact | None:
    """Return |lambda_2|, below which no real form has its growth of -1; ``None`` if not proved.

    The eigenvalues of S Q are 0 and the roots of ``x^2 - trace x + minors``. The eigenvector of
    lambda in the range of S is S Q v = lambda v, and ``v^T S^+ v = v^T Q v / lambda`` with v = S
    w, any w not in the kernel of the other factor: the sign needed is that of ``(S w)^T Q (S w) /
    lambda``.
    """
    S, b = member.S, member.b
    weights = (2 * b[0], 2 * b[1], b[2])
    M = [[S[i][j] * weights[j] for j in range(3)] for i in range(3)]
    trace = sum(M[i][i] for i in range(3))
    minors = sum(M[i][i] * M[j][j] - M[i][j] * M[j][i] for i in range(3) for j in range(i))
    square = trace**2 - 4 * minors
    if square <= 0:
        return None
    root = Exact(square).sqrt()
    values = [(root * s + trace) / 2 for s in (1, -1)]
    negative = [k for k in range(2) if _norm_sign(M, weights, values[k], values[1 - k]) < 0]
    if len(negative) != 1:
        return None
    second, first = values[negative[0]], values[1 - negative[0]]
    ratio_square, ratio = antisymmetric(member)
    zeroth = ratio_square * (2 * b[0] + 2 * b[1] * ratio**2)
    sign = -second.sign()
    if (first - second).sign() == sign and (Exact(zeroth) - second).sign() == sign:
        return second if second.sign() > 0 else -second
    return None


def _norm_sign(
    M: list[list[Fraction]], weights: tuple[Fraction, ...], value: Exact, other: Exact
) -> int:
    """Return the sign of v^T S^+ v = q(v) / value for the eigenvector v of M to ``value``.

    Columns of (M - other) M are eigenvectors: the range of M without the other eigenvector.
    """
    for j in range(3):
        column = [M[i][j] for i in range(3)]
        v = [
            sum((column[k] * M[i][k] for k in range(3)), Fraction(0)) - other * column[i]
            for i in range(3)
        ]
        norm = sum((x * x * w for x, w in zip(v, weights, strict=True)), Exact(0))
        if not norm.is_zero():
            return norm.sign() * value.sign()
    return 0
