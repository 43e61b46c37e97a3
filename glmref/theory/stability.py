"""Linear stability, exactly: the polynomial of M(z), A- and L-stability, behaviour at infinity.

For y' = lambda y, z = h lambda, one step is ``M(z) = V + z B (I - z A)^-1 U``. Its eigenvalues w
are the roots of ``P(w, z) = det(w I - M(z)) det(I - z A)``, a polynomial in both. A-stability is
decided on P: no pole of M in the left half-plane (signs of Schur and Cohn after a Moebius
transformation), and all roots in the closed unit disc along the imaginary axis (Schur-Cohn with
polynomials in y as coefficients; each must nowhere be negative, which Sturm's theorem decides).

Public names::

    stability_polynomial(m) -> tuple[Polynomial, ...]   coefficient of w^k as a polynomial in z
    stability_matrix(m, z) -> Matrix                    M(z)
    stability_function(m) -> (N, D)                     R = N/D of a one-step method
    at_infinity(m) -> AtInfinity                        eigenvalues of M(z) as z grows
    a_stability(m) -> Decision                          l_stability(m) -> Decision
    is_a_stable(m), is_l_stable(m) -> bool | None
    oscillator(pair) -> GLM                             a pair on q' = p, p' = -q

The periodicity interval is in :mod:`glmref.theory.periodicity`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from .. import linalg
from ..claims import ExactnessError, UsageError
from ..exact import Exact, Scalar, exact
from ..linalg import Matrix
from ..method import GLM, PartitionedGLM
from . import polynomials as poly
from .polynomials import Polynomial

__all__ = [
    "AtInfinity",
    "Decision",
    "a_stability",
    "at_infinity",
    "axis_polynomial",
    "is_a_stable",
    "is_l_stable",
    "l_stability",
    "on_imaginary_axis",
    "oscillator",
    "stability_function",
    "stability_matrix",
    "stability_polynomial",
]

_ZERO, _ONE = Exact(0), Exact(1)
_I = Exact(-1).sqrt()

#: P(w, z) as the coefficients of 1, w, .., w^r, each a polynomial in z (or in y).
Bivariate = tuple[Polynomial, ...]

#: Points of the imaginary axis tried before the full proof; one bad point decides.
SAMPLES = tuple(Fraction(x) for x in ("1", "3", "1/3", "10", "1/10", "50", "1/50", "2", "6"))


@dataclass(frozen=True)
class Decision:
    """A yes, a no, or ``None`` with the reason in ``witness``."""

    holds: bool | None
    witness: str = ""


@dataclass(frozen=True, eq=False)
class AtInfinity:
    """What the eigenvalues of M(z) tend to as z grows.

    Attributes
    ----------
        polynomial: coefficients of the polynomial whose roots are the finite limits.
        unbounded: number of eigenvalues that grow without bound.
        matrix: the limit V - B A^-1 U of M(z), or ``None`` for singular A.
        nilpotent: whether all limits are zero.
    """

    polynomial: Polynomial
    unbounded: int
    matrix: Matrix | None
    nilpotent: bool | None


def stability_matrix(m: GLM, z: Scalar | int | Fraction) -> Matrix:
    """Stability matrix M(z) = V + z B (I - z A)^-1 U, (r, r).

    Raises
    ------
        ExactnessError: where I - z A is singular.

    References: Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section
    520.
    """
    at = exact(z) if isinstance(z, int | Fraction) else z
    shifted = linalg.sub(linalg.identity(m.s), linalg.scale(at, m.A))
    stages = linalg.solve(shifted, m.U)
    return linalg.add(m.V, linalg.scale(at, linalg.matmul(m.B, stages)))


def stability_polynomial(m: GLM) -> Bivariate:
    """``P(w, z) = det(w I - M(z)) det(I - z A)``: coefficients of 1, w, .., w^r, polynomials in z.

    One-step methods with triangular A: stage by stage, without any division. Else, few stages:
    ``P = det(w I - V) det(I - z (A + U (w I - V)^-1 B))`` at r + 1 points w; many stages: M(z) at
    s + 1 points z. Interpolation is exact.
    """
    if m.r == 1 and m.is_diagonally_implicit:
        return _stage_by_stage(m)
    return _through_stages(m) if m.s <= max(6, m.r) else _through_values(m)


def _stage_by_stage(m: GLM) -> Bivariate:
    """``w D - N`` of a one-step method: each stage is N_k / D_k, D_k the product of its poles."""
    factors = [poly.trim((_ONE, -m.A[k][k])) for k in range(m.s)]
    numerators: list[Polynomial] = []
    for k in range(m.s + 1):  # the last row is the output, which has no pole of its own
        weights = m.A[k][:k] if k < m.s else m.B[0]
        total: Polynomial = ()
        for x, factor, numerator in zip(weights, factors, numerators, strict=False):
            # Horner's rule over the stages: what is there gets the pole of the next stage
            total = poly.mul(total, factor)
            if x.is_zero() is not True:
                total = poly.add(total, poly.scale(x, numerator))
        start: Polynomial = (m.U[k][0] if k < m.s else m.V[0][0],)
        for factor in factors[:k]:
            start = poly.mul(start, factor)
        numerators.append(poly.add(poly.trim(start), poly.mul((_ZERO, _ONE), total)))
    denominator: Polynomial = (_ONE,)
    for factor in factors:
        denominator = poly.mul(denominator, factor)
    return poly.scale(-1, numerators[-1]), denominator


def _through_stages(m: GLM) -> Bivariate:
    characteristic = poly.characteristic_polynomial(m.V)
    points: list[int] = []
    tables: list[Polynomial] = []
    w = 2  # beyond the unit circle, where V of a stable method has no eigenvalue
    while len(points) <= m.r:
        factor = poly.evaluate(characteristic, w)
        if factor.is_zero() is False:
            shifted = linalg.sub(linalg.scale(w, linalg.identity(m.r)), m.V)
            inner = linalg.add(m.A, linalg.matmul(m.U, linalg.solve(shifted, m.B)))
            reversed_ = poly.characteristic_polynomial(inner)[::-1]  # det(I - z T), from z^0 up
            points.append(w)
            tables.append(tuple(factor * x for x in reversed_))
        w += 1
    by_z = [poly.interpolate(points, [t[k] for t in tables]) for k in range(m.s + 1)]
    return tuple(poly.trim([p[k] if k < len(p) else _ZERO for p in by_z]) for k in range(m.r + 1))


def _through_values(m: GLM) -> Bivariate:
    if m.is_diagonally_implicit:
        denominator: Polynomial = (_ONE,)
        for i in range(m.s):
            denominator = poly.mul(denominator, poly.trim((_ONE, -m.A[i][i])))
    else:
        denominator = poly.trim(poly.characteristic_polynomial(m.A)[::-1])
    points: list[int] = []
    tables: list[Polynomial] = []
    candidate = 0
    while len(points) <= m.s:
        factor = poly.evaluate(denominator, candidate)
        if factor.is_zero() is False:
            table = poly.characteristic_polynomial(stability_matrix(m, candidate))
            points.append(candidate)
            tables.append(tuple(factor * x for x in table))
        candidate = -candidate if candidate > 0 else 1 - candidate  # 0, 1, -1, 2, -2, ..
    return tuple(poly.interpolate(points, [t[k] for t in tables]) for k in range(m.r + 1))


def stability_function(m: GLM) -> tuple[Polynomial, Polynomial]:
    """Stability function R = N/D of a one-step method: N and D without common factor, D(0) = 1.

    Raises
    ------
        UsageError: for a method that carries more than one value.

    References: Hairer and Wanner, "Solving Ordinary Differential Equations II" (1996), (IV.3.3).
    """
    if m.r != 1:
        raise UsageError(f"only a one-step method has a stability function; this one has r = {m.r}")
    numerator, denominator = _without_content(m, stability_polynomial(m))
    unit = 1 / denominator[0]
    return poly.scale(-unit, numerator), poly.scale(unit, denominator)


def _without_content(m: GLM, P: Bivariate) -> Bivariate:
    """Divide out the polynomial in z that all coefficients share: poles that cancel.

    It divides det(I - z A), whose zeros are known where A is lower triangular.
    """
    if not m.is_diagonally_implicit:
        parts = sorted((p for p in P if p), key=len)
        content = parts[0]
        for p in parts[1:]:
            if len(content) == 1:
                return P
            content = poly.gcd(content, p)
        return P if len(content) == 1 else _divided(P, content)
    for i in m.implicit_stages:
        a = m.A[i - 1][i - 1]
        if all(_vanishes_at_inverse(p, a) for p in P):
            P = _divided(P, (_ONE, -a))
    return P


def _vanishes_at_inverse(p: Polynomial, a: Scalar) -> bool:
    """Whether p(1/a) = 0, without the division."""
    return poly.evaluate(tuple(reversed(p)), a).is_zero() is True


def on_imaginary_axis(P: Bivariate) -> Bivariate:
    """``P(w, i y)`` as coefficients of the powers of w, polynomials in y."""
    powers = (_ONE, _I, exact(-1), -_I)
    return tuple(tuple(x * powers[k % 4] for k, x in enumerate(p)) for p in P)


def at_infinity(m: GLM) -> AtInfinity:
    """Limits of the eigenvalues of M(z) as z grows without bound, in any direction."""
    leading, unbounded = _leading_part(stability_polynomial(m))
    try:
        feed = linalg.matmul(m.B, linalg.solve(m.A, m.U))
        matrix: Matrix | None = linalg.sub(m.V, feed)
    except ExactnessError:
        matrix = None
    return AtInfinity(leading, unbounded, matrix, _only_zeros(leading, unbounded))


def _leading_part(P: Bivariate) -> tuple[Polynomial, int]:
    """Coefficient of the highest power of z, a polynomial in w, and how many w are unbounded."""
    degree = max(len(p) for p in P)
    leading = poly.trim([p[degree - 1] if len(p) == degree else _ZERO for p in P])
    return leading, len(P) - len(leading)


def _only_zeros(leading: Polynomial, unbounded: int) -> bool:
    return unbounded == 0 and all(x.is_zero() is True for x in leading[:-1])


def a_stability(m: GLM) -> Decision:
    """Decide A-stability: M(z) power-bounded for every z with negative real part.

    Returns
    -------
        holds ``True`` or ``False`` by proof, or ``None`` with the reason: for methods with
        published decimals, and for a repeated eigenvalue of modulus one that z does not move.

    References: Dahlquist, BIT 3 (1963) 27; Hairer and Wanner (1996), section IV.3; Marden,
    "Geometry of Polynomials" (1966), sections 42 and 45.
    """
    if not m.is_exact:
        return Decision(None, "published decimals: A-stability is decided for exact methods only")
    P = stability_polynomial(m)
    quick = _quick_refusal(m, P)
    if quick is not None:
        return quick
    P = _without_content(m, P)
    if not _poles_in_right_half(P[-1]):
        return Decision(False, "M(z) has a pole in the left half-plane or on the imaginary axis")
    fixed = _fixed_part(P)
    if len(poly.squarefree(fixed)) < len(fixed) and poly.unimodular_roots(fixed):
        return Decision(None, "M(z) has a repeated eigenvalue of modulus 1 that z does not move")
    failure = _leaves_disc(on_imaginary_axis(P))
    return Decision(failure is None, failure or "")


def _quick_refusal(m: GLM, P: Bivariate) -> Decision | None:
    leading, unbounded = _leading_part(P)
    if unbounded:
        return Decision(False, "an eigenvalue of M(z) grows without bound as z goes to infinity")
    if not poly.in_closed_disc(leading):
        return Decision(False, _escape(leading, "as z goes to infinity"))
    if m.is_diagonally_implicit:
        for i in m.implicit_stages:
            a = m.A[i - 1][i - 1]
            if a.real.sign() < 0 and not all(_vanishes_at_inverse(p, a) for p in P):
                return Decision(False, f"M(z) has the pole z = {1 / float(a.real):.6g}")
    axis = on_imaginary_axis(P)
    for y in SAMPLES:
        p = poly.trim([poly.evaluate(c, y) for c in axis])
        if p and (len(p) <= m.r or not poly.in_closed_disc(p)):
            return Decision(False, _escape(p, f"at z = {y} i"))
    return None


def _escape(p: Polynomial, where: str) -> str:
    size = max((abs(x) for x in poly.approximate_roots(p)), default=float("inf"))
    return f"M(z) has an eigenvalue of modulus {size:.10g} {where}"


def _poles_in_right_half(denominator: Polynomial) -> bool:
    """Whether all zeros have positive real part: z = (x + 1)/(x - 1) takes that to |x| > 1."""
    moved = poly.compose_moebius(denominator, 1, 1, 1, -1)
    padded = (*moved, *((_ZERO,) * (len(denominator) - len(moved))))
    return poly.is_schur(poly.trim(padded[::-1]))


def _fixed_part(P: Bivariate) -> Polynomial:
    """Factor of P that does not depend on z, a polynomial in w."""
    degree = max(len(p) for p in P)
    common: Polynomial = ()
    for k in range(degree):
        layer = poly.trim([p[k] if k < len(p) else _ZERO for p in P])
        common = poly.gcd(common, layer) if common else layer
        if len(common) == 1:
            break
    return common


def _conjugate(p: Polynomial) -> Polynomial:
    return tuple(x.conjugate() for x in p)


def _leaves_disc(q: Bivariate) -> str | None:
    """Say why some root leaves the closed disc for some real y, or ``None``.

    Schur-Cohn with polynomials in y: the difference of the outer coefficients' squared moduli must
    be non-negative for all y at every stage. Where it vanishes identically the polynomial must be
    its own mirror image, and its derivative by w takes its place (Cohn).
    """
    previous: Polynomial = (_ONE,)
    while len(q) > 1:
        low, high = q[0], q[-1]
        if not low:
            q = q[1:]
            continue
        difference = poly.sub(poly.mul(high, _conjugate(high)), poly.mul(low, _conjugate(low)))
        difference = tuple(x.real for x in difference)
        if not difference:
            if not _is_mirror_image(q):
                return "the eigenvalues of M(iy) are not mirrored in the unit circle and leave it"
            if len(q) == 2:
                return None
            q = tuple(poly.scale(k, p) for k, p in enumerate(q))[1:]
            previous = (_ONE,)
            continue
        if not poly.is_nonnegative(difference):
            return "for some y an eigenvalue of M(iy) lies outside the unit circle"
        reduced = tuple(
            poly.sub(poly.mul(_conjugate(high), q[k + 1]), poly.mul(low, _conjugate(q[-2 - k])))
            for k in range(len(q) - 1)
        )
        q, previous = _divided(reduced, previous), high
    return None


def _is_mirror_image(q: Bivariate) -> bool:
    low, high = q[0], q[-1]
    return all(
        not poly.sub(poly.mul(p, _conjugate(low)), poly.mul(_conjugate(other), high))
        for p, other in zip(q, reversed(q), strict=True)
    )


def _divided(q: Bivariate, factor: Polynomial) -> Bivariate:
    """Divide by a polynomial where it divides all coefficients: it keeps the degrees down."""
    if len(factor) <= 1:
        return q
    results = [poly.divide(p, factor) for p in q]
    return q if any(rest for _, rest in results) else tuple(quotient for quotient, _ in results)


def l_stability(m: GLM) -> Decision:
    """Decide L-stability: A-stable, and all eigenvalues of M(z) tend to 0 as z goes to infinity.

    References: Ehle (1969); Hairer and Wanner (1996), Definition IV.3.7.
    """
    if not m.is_exact:
        return Decision(None, "published decimals: L-stability is decided for exact methods only")
    if not _only_zeros(*_leading_part(stability_polynomial(m))):
        return Decision(False, "the eigenvalues of M(z) do not all tend to 0 as z goes to infinity")
    return a_stability(m)


def is_a_stable(m: GLM) -> bool | None:
    """Whether the method is A-stable; ``None`` where that is not decided."""
    return a_stability(m).holds


def is_l_stable(m: GLM) -> bool | None:
    """Whether the method is L-stable; ``None`` where that is not decided."""
    return l_stability(m).holds


def oscillator(pair: PartitionedGLM) -> GLM:
    """One method whose M(y), y = h omega real, is a pair's step for q' = omega p, p' = -omega q.

    The values are those of q and then those of p, the stages Q and then P.
    """

    def side(left: Matrix, right: Matrix) -> Matrix:
        return tuple((*a, *b) for a, b in zip(left, right, strict=True))

    def off_diagonal(upper: Matrix, lower: Matrix) -> Matrix:
        """[[0, upper], [-lower, 0]]: stages P drive q, stages Q drive p."""
        top = side(linalg.zeros(len(upper), len(lower[0])), upper)
        return (*top, *side(linalg.scale(-1, lower), linalg.zeros(len(lower), len(upper[0]))))

    return GLM(
        A=off_diagonal(pair.A, pair.A_hat),
        U=linalg.block_diagonal(pair.U, pair.U_hat),
        B=off_diagonal(pair.B, pair.B_hat),
        V=linalg.block_diagonal(pair.V, pair.V_hat),
        name=pair.name,
    )


def axis_polynomial(m: GLM | PartitionedGLM) -> Sequence[Polynomial]:
    """``P(w, i y)`` of a method, or ``P(w, y)`` of a pair's oscillator, by powers of w."""
    if isinstance(m, PartitionedGLM):
        return stability_polynomial(oscillator(m))
    return on_imaginary_axis(stability_polynomial(m))
