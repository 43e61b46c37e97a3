"""Linear stability, exactly: the polynomial of M(z) and its behaviour at infinity.

For y' = lambda y, z = h lambda, one step is ``M(z) = V + z B (I - z A)^-1 U``. Its eigenvalues w
are the roots of ``P(w, z) = det(w I - M(z)) det(I - z A)``, a polynomial in both.

The periodicity interval is in :mod:`glmref.theory.periodicity`, A- and L-stability in
:mod:`glmref.prove.kernel`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import cast

from ..errors import ExactnessError, UsageError
from ..exact import Exact, Scalar, ball, exact, linalg
from ..exact.judging import asked
from ..exact.linalg import Matrix
from ..method import GLM, Method
from . import polynomials as poly
from .polynomials import Polynomial

_ZERO, _ONE = Exact(0), Exact(1)
_I = Exact(-1).sqrt()

#: Points of the imaginary axis at which a violation of A-stability is looked for.
SAMPLES = ("1", "3", "1/3", "10", "1/10", "50", "1/50", "2", "6")

_polynomial = asked("rules_stability.stability_polynomial")

#: P(w, z) as the coefficients of 1, w, .., w^r, each a polynomial in z (or in y).
Bivariate = tuple[Polynomial, ...]


def stability_matrix(m: GLM, z: Scalar | int | Fraction) -> Matrix:
    """Return the stability matrix M(z) = V + z B (I - z A)^-1 U, (r, r).

    Raises
    ------
    ExactnessError
        Where I - z A is singular.

    References: Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section
    520.
    """
    at = exact(z) if isinstance(z, int | Fraction) else z
    shifted = linalg.sub(linalg.identity(m.s), linalg.scale(at, m.A))
    stages = linalg.solve(shifted, m.U)
    return linalg.add(m.V, linalg.scale(at, linalg.matmul(m.B, stages)))


@lru_cache(maxsize=8)
def stability_polynomial(m: GLM) -> Bivariate:
    """Return ``P(w, z) = det(w I - M(z)) det(I - z A)``: by powers of w, polynomials in z."""
    return tuple(map(poly.trim, _polynomial(m.A, m.U, m.B, m.V)))


def without_content(m: GLM, P: Bivariate) -> Bivariate:
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
        return P if len(content) == 1 else divided(P, content)
    for i in m.implicit_stages:
        a = m.A[i - 1][i - 1]
        if all(vanishes_at_inverse(p, a) for p in P):
            P = divided(P, (_ONE, -a))
    return P


def vanishes_at_inverse(p: Polynomial, a: Scalar) -> bool:
    """Return whether p(1/a) = 0, without the division."""
    return poly.evaluate(tuple(reversed(p)), a).is_zero() is True


def on_imaginary_axis(P: Bivariate) -> Bivariate:
    """Return ``P(w, i y)`` as coefficients of the powers of w, polynomials in y."""
    powers = (_ONE, _I, exact(-1), -_I)
    return tuple(tuple(x * powers[k % 4] for k, x in enumerate(p)) for p in P)


def leading_part(P: Bivariate) -> tuple[Polynomial, int]:
    """Return the coefficient of the highest power of z, and how many w are unbounded."""
    degree = max(len(p) for p in P)
    leading = poly.trim([p[degree - 1] if len(p) == degree else _ZERO for p in P])
    return leading, len(P) - len(leading)


def seems_a_stable(m: GLM) -> bool:
    """Guess by balls whether powers of M(iy) stay small at :data:`SAMPLES`."""
    try:
        for y in SAMPLES:
            M = stability_matrix(m, ball(_I) * Fraction(y))
            for _ in range(12):
                M = linalg.matmul(M, M)
            if not linalg.largest(M) < 1e6:
                return False
    except ExactnessError:  # a pole
        return False
    return True


def why_not_a_stable(m: GLM, witness: Mapping[str, object]) -> str:
    """Return the sentence of a reason that refutes A-stability.

    Parameters
    ----------
    m : GLM
        The method.
    witness : Mapping[str, object]
        ``start``, ``infinity``, ``pole`` or ``axis``, or ``y`` with the text of a rational.
    """
    if "start" in witness:
        return "V = M(0) is not power-bounded"
    P = stability_polynomial(m)
    if "infinity" in witness:
        leading, unbounded = leading_part(P)
        if unbounded:
            return "an eigenvalue of M(z) grows without bound as z goes to infinity"
        return f"{_largest(leading)} as z goes to infinity"
    if "pole" in witness:
        below = (m.A[i - 1][i - 1] for i in m.implicit_stages if m.is_diagonally_implicit)
        at = [
            a for a in below if a.real.sign() < 0 and not all(vanishes_at_inverse(p, a) for p in P)
        ]
        where = (
            f"pole z = {1 / float(at[0].real):.6g}"
            if at
            else "pole in the left half-plane or on the imaginary axis"
        )
        return f"M(z) has {'the' if at else 'a'} {where}"
    if "axis" in witness:
        return "for some y an eigenvalue of M(iy) lies outside the unit circle"
    y = str(witness["y"])
    at_y = poly.trim([poly.evaluate(p, Fraction(y)) for p in on_imaginary_axis(P)])
    inside = poly.in_disc(at_y)
    return f"{'M(z) is not power-bounded' if inside else _largest(at_y)} at z = {y} i"


def _largest(p: Polynomial) -> str:
    """Return the sentence about the largest root."""
    size = max((abs(x) for x in poly.approximate_roots(p)), default=float("inf"))
    return f"M(z) has an eigenvalue of modulus {size:.10g}"


def divided(q: Bivariate, factor: Polynomial) -> Bivariate:
    """Divide by a polynomial where it divides all coefficients: it keeps the degrees down."""
    if len(factor) <= 1:
        return q
    results = [poly.divide(p, factor) for p in q]
    return q if any(rest for _, rest in results) else tuple(quotient for quotient, _ in results)


def oscillator(pair: Method) -> GLM:
    """Return one method whose M(y), y = h omega, is a pair's step for q' = omega p, p' = -omega q.

    The values are those of q and then those of p, the stages Q and then P.
    """

    def side(left: Matrix, right: Matrix) -> Matrix:
        return tuple((*a, *b) for a, b in zip(left, right, strict=True))

    def off_diagonal(upper: Matrix, lower: Matrix) -> Matrix:
        """Return [[0, upper], [-lower, 0]]: stages P drive q, stages Q drive p."""
        top = side(linalg.zeros(len(upper), len(lower[0])), upper)
        return (*top, *side(linalg.scale(-1, lower), linalg.zeros(len(lower), len(upper[0]))))

    f, k = pair.components
    return GLM(
        A=off_diagonal(f.A, k.A),
        U=linalg.block_diagonal(f.U, k.U),
        B=off_diagonal(f.B, k.B),
        V=linalg.block_diagonal(f.V, k.V),
        name=pair.name,
    )


def axis_polynomial(m: Method) -> Sequence[Polynomial]:
    """Return ``P(w, i y)`` of a method, or ``P(w, y)`` of a pair's oscillator, by powers of w."""
    if m.parts == 2:
        return stability_polynomial(oscillator(m))
    return on_imaginary_axis(stability_polynomial(cast("GLM", m)))


def parasitic_curvature(pair: Method) -> Scalar:
    """Return kappa: its sign says whether oscillations of a pair near w = -1 stay bounded.

    With V and V^ of eigenvalues 1 and -1 the step of a pair on q' = p, p' = -q is a matrix M(y),
    y = h, with w = -1 twice at y = 0. For a symmetric G-symplectic pair the eigenvalues come as z,
    1/z: ``det(w - M) = w^2 (s^2 - t s + u - 2)`` with s = w + 1/w, t = tr M and u the sum of the
    principal minors of order two. So ``2 + 2 t + u = det(1 + M) = e(y)`` and, near s = -2,
    ``(s + 2)(4 + t) = e(y) + O((s + 2)^2)`` with t(0) = 0. Without growth to first order e begins
    with y^6, and ``s = -2 + kappa y^6 + ..``, kappa = e_6 / 4: the parasitic eigenvalues stay on
    the unit circle for small y if kappa > 0, and leave it at once, ``|w| - 1 = sqrt(-kappa) y^3``,
    if kappa < 0. Growth parameters that are zero say nothing about the sign.

    Parameters
    ----------
    pair : Method
        Explicit, r = r^ = 2, V and V^ with the eigenvalues 1 and -1.

    Raises
    ------
    UsageError
        For another pair, or one that grows already in the first order.
    """
    if any(len(c.V) != 2 for c in pair.components):
        raise UsageError(f"the pair {pair.name!r} must carry two values of q and two of p")
    by_power = axis_polynomial(pair)
    total: list[Scalar] = [Exact(0)] * max(map(len, by_power))
    for k, coefficients in enumerate(by_power):
        for j, x in enumerate(coefficients):
            total[j] = total[j] + (x if k % 2 == 0 else -x)
    if len(by_power) != 5 or (by_power[4][0] - 1).is_zero() is False or len(by_power[4]) > 1:
        raise UsageError(f"the pair {pair.name!r} must be explicit")
    low = (*total[:6], sum((row[0] for row in by_power if row), Exact(0)))
    if any(x.is_zero() is False for x in low):
        raise UsageError(f"the pair {pair.name!r} has other eigenvalues than 1 and -1, or grows")
    return total[6] / 4 if len(total) > 6 else Exact(0)
