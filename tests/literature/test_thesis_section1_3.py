"""Khan (2018), section 1.3: numerical methods for Hamiltonian systems, as printed."""

from fractions import Fraction
from itertools import pairwise

import pytest

from glmref.exact import Exact, exact, linalg
from glmref.exact.linalg import Matrix, Vector

from .exactly import (
    J,
    dot,
    grid,
    matrix,
    same,
    step_matrix,
    symplectic_defect,
    symplectic_matrix,
    vanishes,
    vector,
)
from .thesis import euler, gauss2, midpoint, rk4


def test_symplectic_euler_is_symplectic_for_every_f_and_g() -> None:
    # p+ = p + h f(q), q+ = q + h g(p+): the Jacobian depends on f', g', h only; degree 2 in h.
    # The explicit Euler method evaluates g at the old p and is symplectic only where f' g' = 0.
    for h, df, dg in grid(3, 4):
        semi = matrix([[1, h * df], [h * dg, 1 + h * h * df * dg]])
        explicit = matrix([[1, h * df], [h * dg, 1]])
        assert vanishes(symplectic_defect(semi))
        assert vanishes(symplectic_defect(explicit)) is (h * df * dg == 0)


def symplectic_euler_oscillator(h: Fraction, p: Fraction, q: Fraction) -> tuple[Fraction, Fraction]:
    """One printed step with f(q) = -q and g(p) = p."""
    p = p - h * q
    return p, q + h * p


def test_symplectic_euler_conserves_another_form_and_not_the_energy() -> None:
    for h, p, q in grid(3, 4):
        p1, q1 = symplectic_euler_oscillator(h, p, q)
        assert p1 * p1 + q1 * q1 - h * p1 * q1 == p * p + q * q - h * p * q
    h, p, q = Fraction(1, 10), Fraction(0), Fraction(1)
    p1, q1 = symplectic_euler_oscillator(h, p, q)
    assert (p1**2 + q1**2) / 2 - (p**2 + q**2) / 2 == Fraction(-99, 20000)


def test_symplectic_condition_separates_gauss_from_the_classical_method() -> None:
    assert vanishes(symplectic_matrix(gauss2().A, gauss2().B[0]))
    assert vanishes(symplectic_matrix(midpoint().A, midpoint().B[0]))
    assert not vanishes(symplectic_matrix(rk4().A, rk4().B[0]))


@pytest.mark.parametrize("conserves", [True, False])
def test_symplectic_condition_decides_conservation_of_quadratic_invariants(conserves: bool) -> None:
    # y' = S(t) y with S skew: stage i has the slope i z_i, and |y| is kept when M = 0.
    method = gauss2() if conserves else rk4()
    i = exact(-1).sqrt()
    z = [i * (k + 1) / 3 for k in range(method.s)]
    factor = step_matrix(method, z)[0][0]
    assert (factor * factor.conjugate() == 1) is conserves


def test_no_explicit_runge_kutta_method_is_symplectic() -> None:
    # M_ii = 2 b_i a_ii - b_i^2 = -b_i^2 for explicit methods: M = 0 would need b = 0.
    for method in (euler(), rk4()):
        M, b = symplectic_matrix(method.A, method.B[0]), method.B[0]
        assert all(M[i][i] == -b[i] * b[i] and not b[i].is_zero() for i in range(method.s))


def test_implicit_runge_kutta_method_that_is_not_symplectic() -> None:
    # Backward Euler: M = 2 - 1. It contracts the oscillator: |R(i)|^2 = 1/2.
    backward = matrix([["1"]])
    assert symplectic_matrix(backward, vector(["1"]))[0][0] == 1
    amplification = exact(1) / (exact(1) - exact(-1).sqrt())
    assert amplification * amplification.conjugate() == Fraction(1, 2)


def test_symplectic_midpoint_rule_does_not_conserve_a_cubic_energy() -> None:
    # H = p^2/2 + q^3/3, so p' = -q^2. The stage Q solves the quadratic h^2/4 Q^2 + Q = q + h p/2.
    h, p, q = Fraction(1, 2), exact(0), exact(1)
    Q = (((q + h * p / 2) * h * h + 1).sqrt() - 1) * 2 / (h * h)
    assert (Q * Q * h * h / 4 + Q - q - h * p / 2).is_zero()
    P = p - Q * Q * h / 2
    p1, q1 = p - Q * Q * h, q + P * h
    assert (Q - (q + q1) / 2).is_zero()
    assert (P - (p + p1) / 2).is_zero()

    def energy(p: Exact, q: Exact) -> Exact:
        return p * p / 2 + q * q * q / 3

    assert not (energy(p1, q1) - energy(p, q)).is_zero()


def one_leg_forms(rho: Vector, sigma: Vector) -> tuple[Matrix, Vector]:
    """Linear system for G: form after minus form before = 2 <sigma(E) y, rho(E) y>, section 1.3.

    The unknowns are the k (k + 1)/2 entries g_ij, i <= j; the equations are the coefficients of
    <y_a, y_b>, a <= b, for the k + 1 values y_n, ..., y_{n+k}.
    """
    k = len(rho) - 1
    unknowns = [(i, j) for i in range(k) for j in range(i, k)]
    rows, right = [], []
    for a in range(k + 1):
        for b in range(a, k + 1):
            row = []
            for i, j in unknowns:
                double = 1 if i == j else 2
                row.append(double * (((i + 1, j + 1) == (a, b)) - ((i, j) == (a, b))))
            rows.append(row)
            right.append((rho[a] * sigma[b] + rho[b] * sigma[a]) * (1 if a == b else 2))
    return matrix(rows), tuple(right)


def solvable(a: Matrix, right: Vector) -> bool:
    """Whether ``a x = right`` has a solution: the ranks with and without the right side agree."""
    return linalg.rank(a) == linalg.rank(tuple((*r, x) for r, x in zip(a, right, strict=True)))


ONE_LEG = {
    "midpoint": (["-1", "1"], ["1/2", "1/2"], True),
    "leapfrog": (["-1/2", "0", "1/2"], ["0", "1", "0"], True),
    "bdf2": (["1/2", "-2", "3/2"], ["0", "0", "1"], False),
    "ab2": (["0", "-1", "1"], ["-1/2", "3/2", "0"], False),
}


@pytest.mark.parametrize("name", ONE_LEG)
def test_one_leg_methods_conserve_a_form_only_when_they_are_symmetric(name: str) -> None:
    rho, sigma, conserves = ONE_LEG[name]
    symmetric = [-Fraction(x) for x in rho] == [Fraction(x) for x in reversed(rho)]
    assert symmetric is conserves
    assert solvable(*one_leg_forms(vector(rho), vector(sigma))) is conserves


def test_one_leg_leapfrog_has_exactly_one_form() -> None:
    # y_{n+2} - y_n = 2 h f(y_{n+1}): G = [[0, 1/2], [1/2, 0]] is the form of the last two values.
    rho, sigma, _ = ONE_LEG["leapfrog"]
    system, right = one_leg_forms(vector(rho), vector(sigma))
    assert not linalg.nullspace(system)
    g = vector(["0", "1/2", "0"])
    assert all(x == y for x, y in zip(linalg.matvec(system, g), right, strict=True))
    near = vector(["0", "1/2", "1/100"])
    assert not all(x == y for x, y in zip(linalg.matvec(system, near), right, strict=True))


def test_one_leg_bdf2_loses_half_the_square_of_the_second_difference() -> None:
    # With Dahlquist's G = [[1/2, -1], [-1, 5/2]]: after - before = 2 <y2, rho y> - |y0-2y1+y2|^2/2.
    for y0, y1, y2 in grid(3, 2):
        before = y0 * y0 / 2 - 2 * y0 * y1 + Fraction(5, 2) * y1 * y1
        after = y1 * y1 / 2 - 2 * y1 * y2 + Fraction(5, 2) * y2 * y2
        slope = y0 / 2 - 2 * y1 + Fraction(3, 2) * y2
        assert after - before - 2 * y2 * slope == -((y0 - 2 * y1 + y2) ** 2) / 2


def test_g_norm_of_one_leg_leapfrog_takes_neighbouring_values() -> None:
    # The printed vector (y_1, y_3, ...) skips y_2. On the oscillator <y_n, y_{n+1}> is constant
    # and <y_n, y_{n+2}> is not.
    h = Fraction(1, 4)
    field = linalg.inverse(J(1))
    values = [vector([0, 1]), vector([Fraction(-1, 4), 1])]
    for _ in range(6):
        slope = linalg.matvec(field, values[-1])
        values.append(tuple(a + x * 2 * h for a, x in zip(values[-2], slope, strict=True)))
    neighbours = [dot(a, b) for a, b in pairwise(values)]
    skipping = [dot(a, b) for a, b in zip(values, values[2:], strict=False)]
    assert all(x == neighbours[0] for x in neighbours)
    assert any(x != skipping[0] for x in skipping)
    assert same(field, matrix([[0, -1], [1, 0]]))
