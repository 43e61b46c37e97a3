"""Eigenvalues of modulus one and power-boundedness of a matrix, decided exactly."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from fractions import Fraction
from functools import cmp_to_key
from math import pi

from ..errors import ExactnessError
from ..exact import Exact, Scalar, exact, linalg, root_of_unity
from ..exact.judging import asked
from ..exact.linalg import Matrix, Vector
from . import polynomials as poly
from .polynomials import Polynomial

#: Roots of unity of these orders are tried whatever the field, others where p is rational.
USUAL_ORDERS = (1, 2, 3, 4, 5, 6, 8, 10, 12)
MAX_ORDER = 90
#: An approximate root so near to the unit circle may lie on it.
NEAR = 1e-4

_is_unbounded = asked("polynomials.is_unbounded")
_space_of = asked("rules_growth.space_of")


@dataclass(frozen=True)
class Eigenvalue:
    """An eigenvalue of modulus one and its algebraic multiplicity."""

    value: Exact
    multiplicity: int


@dataclass(frozen=True)
class Boundedness:
    """Whether all powers of a matrix stay below one bound."""

    holds: bool | None  #: The decision, ``None`` where balls leave it open.
    witness: str  #: One sentence on what decides.


def _require_exact(V: Matrix) -> None:
    if not all(isinstance(x, Exact) for row in V for x in row):
        raise ExactnessError(
            "the eigenvalues of V are decided for exact entries only; write V with sqrt() or exp()"
        )


def _cyclotomic_part(p: Polynomial) -> tuple[list[Eigenvalue], Polynomial]:
    """Divide out the roots of unity: found roots, and what is left of the polynomial."""
    rational = all(isinstance(a, Exact) and a.as_fraction() is not None for a in p)
    found: list[Eigenvalue] = []
    for w in _near_circle(p):
        turn = Fraction(cmath.phase(w) / (2 * pi)).limit_denominator(MAX_ORDER) % 1
        near = abs(w - cmath.exp(2j * pi * turn)) < NEAR**2
        if near and (rational or turn.denominator in USUAL_ORDERS):
            root = root_of_unity(turn.numerator, turn.denominator)
            multiplicity, p = _divided_out(p, root)
            if multiplicity:
                found.append(Eigenvalue(root, multiplicity))
    return found, p


def _near_circle(p: Polynomial) -> list[complex]:
    return [w for w in poly.approximate_roots(p) if abs(abs(w) - 1) < NEAR]


def _quadratic_roots(p: Polynomial) -> list[Scalar]:
    c, b, a = p
    root = (b * b - 4 * a * c).sqrt()
    return [(root - b) / (2 * a), (-root - b) / (2 * a)]


def _solve_unimodular(p: Polynomial) -> list[Scalar]:
    """Return roots of a squarefree polynomial that is its own mirror image, by square roots.

    Real coefficients allow ``x + 1/x`` as the unknown, of half the degree.

    Raises
    ------
    ExactnessError
        When the degree is too high for square roots.
    """
    degree = len(p) - 1
    if degree == 1:
        return [-p[0] / p[1]]
    if degree == 2:
        return _quadratic_roots(p)
    palindromic = all((a - b).is_zero() is True for a, b in zip(p, reversed(p), strict=True))
    if degree == 4 and palindromic:
        sums = _quadratic_roots((p[2] - 2 * p[0], p[1], p[0]))  # a t^2 + b t + (c - 2 a) = 0
        return [x for t in sums for x in _quadratic_roots((exact(1), -t, exact(1)))]
    raise ExactnessError(
        f"V has {degree} eigenvalues of modulus 1 that are neither roots of unity nor given by "
        f"square roots"
    )


def _compare_arguments(x: Exact, y: Exact) -> int:
    def half(z: Exact) -> int:
        side = z.imag.sign()
        return 0 if side > 0 or (side == 0 and z.real.sign() > 0) else 1

    first, second = half(x), half(y)
    if first != second:
        return first - second
    turn = x.real * y.imag - x.imag * y.real  # positive when y lies ahead of x
    return -exact(turn).sign()


#: Sort key: argument in [0, 2 pi).
argument_key = cmp_to_key(_compare_arguments)


def unimodular_eigenvalues(V: Matrix) -> tuple[Eigenvalue, ...]:
    """Return eigenvalues of modulus 1, their multiplicities, by argument in [0, 2 pi).

    Roots of unity are divided out of the characteristic polynomial. What is left and its mirror
    image in the unit circle share the other unimodular roots, which are then found by square roots.

    Raises
    ------
    ExactnessError
        For balls, or for eigenvalues that square roots do not give.
    """
    _require_exact(V)
    found, rest = _cyclotomic_part(poly.characteristic(V))
    if not poly.is_schur(rest):
        # what rest shares with its mirror image: roots on the circle, or in pairs beside it
        common = poly.squarefree(poly.gcd(rest, poly.mirror(rest)))
        if _near_circle(common):
            found += _multiplicities(rest, _solve_unimodular(common))
    order = sorted(range(len(found)), key=lambda i: argument_key(found[i].value))
    return tuple(found[i] for i in order)


def _multiplicities(p: Polynomial, roots: list[Scalar]) -> list[Eigenvalue]:
    """Return those of the roots that have the modulus 1."""
    result: list[Eigenvalue] = []
    for root in map(exact, roots):  # type: ignore[arg-type]
        if root * root.conjugate() == 1:
            result.append(Eigenvalue(root, _divided_out(p, root)[0]))
    return result


def _divided_out(p: Polynomial, root: Exact) -> tuple[int, Polynomial]:
    """Return the multiplicity of a root, and the polynomial without it."""
    multiplicity = 0
    while len(p) > 1:
        quotient, rest = poly.divide(p, (-root, exact(1)))
        if rest:
            break
        p, multiplicity = quotient, multiplicity + 1
    return multiplicity, p


def eigenvectors(V: Matrix, zeta: Scalar) -> tuple[list[Vector], list[Vector]]:
    """Return left and right eigenvectors of V for an eigenvalue, ``w_i v_j = delta_ij``.

    Returns
    -------
    tuple[list[Vector], list[Vector]]
        Rows w_i and columns v_j, as many as the geometric multiplicity.

    Raises
    ------
    ExactnessError
        When the eigenvalue is defective, so that no such scaling exists.
    """
    _, left, right = _space_of(V, zeta)
    return list(left), list(linalg.transpose(right))


def power_bounded(V: Matrix) -> Boundedness:
    """Return whether the powers of V are bounded, which the judge decides, and why not.

    References: Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section 51;
    Hairer, Nørsett and Wanner, "Solving Ordinary Differential Equations I" (1993), section III.3.
    """
    try:
        _require_exact(V)
    except ExactnessError:
        return Boundedness(None, "V holds published decimals: its eigenvalues are not decided")
    if not _is_unbounded(V):
        return Boundedness(True, "")
    p = poly.characteristic(V)
    return Boundedness(False, _defective(V) if poly.in_disc(p) else _outside(p))


def _outside(p: Polynomial) -> str:
    size = max((abs(x) for x in poly.approximate_roots(p)), default=0.0)
    return f"V has an eigenvalue outside the unit circle, of modulus about {size:.6g}"


def _defective(V: Matrix) -> str:
    try:
        found = unimodular_eigenvalues(V)
    except ExactnessError:
        found = ()
    for eigenvalue in found:
        shifted = linalg.sub(V, linalg.scale(eigenvalue.value, linalg.identity(len(V))))
        independent = len(V) - linalg.rank(shifted)
        if independent < eigenvalue.multiplicity:
            return (
                f"the eigenvalue {brief(eigenvalue.value)} of V on the unit circle has "
                f"multiplicity {eigenvalue.multiplicity} and {independent} eigenvector"
                f"{'s' if independent > 1 else ''}"
            )
    return "a multiple eigenvalue of V on the unit circle lacks eigenvectors"


def brief(x: Exact) -> str:
    """Return a number in a sentence: a rational one as it is."""
    fraction: Fraction | None = x.as_fraction()
    return str(fraction) if fraction is not None else f"{complex(x):.6g}"
