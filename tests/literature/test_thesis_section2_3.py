"""Khan (2018), section 2.3: general linear methods, their adjoint and symmetry, as printed."""

import random
from collections.abc import Callable
from fractions import Fraction
from functools import cache

import pytest

from glmref.exact import exact, linalg
from glmref.exact.linalg import Matrix
from glmref.method import GLM

from .exactly import grid, matrix, order, random_matrix, same, step_matrix, vector
from .thesis import gauss2, method_n, one_value, order4, order6, real_form, rk4, s4

I2 = linalg.identity(2)


def reversal(s: int) -> Matrix:
    """The printed P (and the printed L): ones on the antidiagonal."""
    return tuple(reversed(linalg.identity(s)))


def test_printed_output_equation_needs_its_step_number_on_the_left() -> None:
    # (2.9) prints y = h B f(Y) + V y^{n-1}. For y' = 0 a method carries y to V y; read with the
    # same y on both sides it would need V y = y, which N does not give.
    n, y = method_n(), vector([1, 1])
    after = linalg.matvec(n.V, y)
    assert (after[0] == y[0], after[1] == y[1]) == (True, False)
    assert all(a == b for a, b in zip(linalg.matvec(step_matrix(n, [0, 0]), y), after, strict=True))


def test_printed_two_stage_equations_are_not_the_printed_tableau() -> None:
    # Y_2 = h a21 f(Y_2) + h a22 f(Y_2) + y_0 and y_1 = h b f + Y_2, with Heun's a21 = 1, a22 = 0:
    # implicit, and the weights sum to 2. The tableau printed below them is right.
    right = one_value([["0", "0"], ["1", "0"]], ["1/2", "1/2"])
    printed = one_value([["0", "0"], ["0", "1"]], ["1/2", "1/2+1"])
    assert right.is_explicit
    assert not printed.is_explicit
    assert sum((x for x in right.B[0]), exact(0)) == 1
    assert sum((x for x in printed.B[0]), exact(0)) == 2
    assert order(right) == 2


def test_printed_tableau_of_a_runge_kutta_method_has_unit_u_and_v() -> None:
    assert same(one_value([["0", "0"], ["1", "0"]], ["1/2", "1/2"]).U, matrix([["1"], ["1"]]))
    assert same(step_matrix(gauss2(), [0, 0]), matrix([["1"]]))


def adjoint(method: GLM, P: Matrix, L: Matrix) -> GLM:
    """The adjoint as corrected."""
    back = linalg.inverse(method.V)
    up = linalg.matmul(method.U, back)
    return GLM(
        A=linalg.matmul(P, linalg.sub(linalg.matmul(up, method.B), method.A), P),
        U=linalg.matmul(P, up, L),
        B=linalg.matmul(L, back, method.B, P),
        V=linalg.matmul(L, back, L),
    )


def printed_adjoint(method: GLM, P: Matrix, L: Matrix) -> GLM:
    """The adjoint as printed, with LPB read as LBP, the only order whose shapes fit."""
    inner = linalg.sub(linalg.matmul(method.U, method.B), method.A)
    return GLM(
        A=linalg.matmul(P, inner, P),
        U=linalg.matmul(P, method.U, linalg.inverse(method.V)),
        B=linalg.matmul(L, method.B, P),
        V=method.V,
    )


def is_inverse_step(candidate: GLM, method: GLM, P: Matrix, L: Matrix, z: list[Fraction]) -> bool:
    """Whether a step of the candidate undoes a step with -h: ``M*(PZP) = L M(-Z)^-1 L``."""
    there = step_matrix(method, [-x for x in z])
    reversed_slopes = linalg.matvec(P, vector(z))
    back = linalg.matmul(L, linalg.inverse(there), L)
    return same(step_matrix(candidate, reversed_slopes), back)


def involution(r: int, numbers: random.Random) -> Matrix:
    """Random L with L^2 = I and both eigenvalues 1 and -1."""
    T = random_matrix(r, r, numbers)
    while linalg.rank(T) < r:
        T = random_matrix(r, r, numbers)
    signs = linalg.diagonal(vector([1, -1] * r)[:r])
    return linalg.matmul(T, signs, linalg.inverse(T))


@cache
def random_methods(count: int) -> list[tuple[GLM, Matrix, Matrix, list[Fraction]]]:
    """Random exact GLMs with L^2 = I and L V^-1 L = V, slopes included.

    V = L K with K another involution, so that L V^-1 L = L K L L = L K = V, as the text assumes.
    """
    numbers = random.Random(20180)
    result = []
    for k in range(count):
        s, r = 2 + k % 3, 2 + k % 2
        L, K = involution(r, numbers), involution(r, numbers)
        method = GLM(
            A=random_matrix(s, s, numbers),
            U=random_matrix(s, r, numbers),
            B=random_matrix(r, s, numbers),
            V=linalg.matmul(L, K),
        )
        z = [Fraction(numbers.randint(1, 9), 97) for _ in range(s)]
        result.append((method, reversal(s), L, z))
    return result


def test_corrected_adjoint_inverts_the_step_of_30_random_methods() -> None:
    assert all(is_inverse_step(adjoint(m, P, L), m, P, L, z) for m, P, L, z in random_methods(30))


def test_printed_adjoint_inverts_the_step_of_none_of_30_random_methods() -> None:
    assert not any(
        is_inverse_step(printed_adjoint(m, P, L), m, P, L, z) for m, P, L, z in random_methods(30)
    )


@pytest.mark.parametrize("part", "AUB")
def test_each_printed_block_of_the_adjoint_is_wrong_by_itself(part: str) -> None:
    for method, P, L, z in random_methods(6):
        right, printed = adjoint(method, P, L), printed_adjoint(method, P, L)
        mixed = right.bare(**{part: getattr(printed, part)})
        assert not is_inverse_step(mixed, method, P, L, z)


def test_printed_product_l_p_b_has_no_shape_when_stages_and_values_differ() -> None:
    method = order4()
    with pytest.raises(ValueError, match="zip"):
        linalg.matmul(linalg.identity(method.r), reversal(method.s), method.B)
    linalg.matmul(linalg.identity(method.r), method.B, reversal(method.s))


def test_the_two_conditions_on_l_say_that_l_v_is_an_involution() -> None:
    # With L^2 = I: L V^-1 L = V exactly when (L V)^2 = I.
    numbers = random.Random(7)
    for k in range(12):
        L = involution(3, numbers)
        V = linalg.matmul(L, involution(3, numbers)) if k % 2 else random_matrix(3, 3, numbers)
        first = same(linalg.matmul(L, linalg.inverse(V), L), V)
        square = linalg.matmul(L, V, L, V)
        assert first is same(square, linalg.identity(3)) is (k % 2 == 1)


def test_printed_example_of_l_fails_for_every_method_of_chapter_3() -> None:
    # "i.e." the antidiagonal L: L V^-1 L = V fails for V = diag(1, -1) and for the V of (3.8).
    for method in (method_n(), order4()):
        L = reversal(method.r)
        assert not same(linalg.matmul(L, linalg.inverse(method.V), L), method.V)


ROTATED = [["1", "0", "0"], ["0", "1/2", "sqrt(3)/2"], ["0", "sqrt(3)/2", "-1/2"]]
SYMMETRIC: dict[str, tuple[Callable[[], GLM], Matrix]] = {
    "gauss-2": (gauss2, matrix([["1"]])),
    "N": (method_n, I2),
    "P": (lambda: method_n(1, -1, 1), I2),
    "S4": (s4, matrix(ROTATED)),
    "order 6": (
        lambda: real_form(order6()),
        linalg.block_diagonal(matrix(ROTATED), matrix([[-1]])),
    ),
}


def conditions(method: GLM, L: Matrix) -> dict[str, bool]:
    """Which identities hold, corrected and printed, with P the reversal."""
    A, U, B, V = method.A, method.U, method.B, method.V
    P, back, mul = reversal(method.s), linalg.inverse(V), linalg.matmul
    both = linalg.add(A, mul(P, A, P))
    return {
        "L": same(mul(L, L), linalg.identity(method.r)) and same(mul(L, back, L), V),
        "B": same(B, mul(V, L, B, P)),
        "U": same(U, mul(P, U, L, V)),
        "A": same(both, mul(U, back, B)),
        "(2.10)": same(B, mul(L, B, P)),
        "(2.10) with VL": same(B, mul(V, L, B, P)),
        "(2.11)": same(both, mul(P, U, B, P)),
        "(2.12)": same(U, mul(P, U, back)),
    }


@pytest.mark.parametrize("name", SYMMETRIC)
def test_symmetric_methods_satisfy_the_corrected_conditions(name: str) -> None:
    build, L = SYMMETRIC[name]
    method = build()
    held = conditions(method, L)
    assert held["L"] and held["B"] and held["U"] and held["A"]
    P = reversal(method.s)
    z = [Fraction(k + 1, 7) for k in range(method.s)]
    assert is_inverse_step(method, method, P, L, z)
    near = method.bare(A=linalg.add(method.A, matrix(_corner(method.s))))
    assert not conditions(near, L)["A"]
    assert not is_inverse_step(near, near, P, L, z)


def _corner(s: int) -> list[list[Fraction]]:
    return [[Fraction(i == s - 1 and j == 0, 1000) for j in range(s)] for i in range(s)]


PRINTED = {
    "(2.10)": {"gauss-2"},  # with the L of the other two conditions
    "(2.11)": {"gauss-2"},
    "(2.12)": {"gauss-2", "N", "P"},
}


@pytest.mark.parametrize("equation", PRINTED)
def test_printed_symmetry_equation_refuses_methods_that_are_symmetric(equation: str) -> None:
    holding = {name for name, (build, L) in SYMMETRIC.items() if conditions(build(), L)[equation]}
    assert holding == PRINTED[equation]


def test_printed_2_10_holds_with_the_output_involution() -> None:
    for build, L in SYMMETRIC.values():
        method = build()
        output = linalg.matmul(method.V, L)
        assert conditions(method, output)["(2.10)"]


def test_2_10_alone_accepts_method_3_8_which_is_not_symmetric() -> None:
    # B = L_o B P holds with L_o = diag(1, -1, -1), and since B has full row rank L_o is the only
    # matrix for which it does. It would be V L, so L = V^-1 L_o; but then L^2 = V, not I.
    method = order4()
    output = linalg.diagonal(vector([1, -1, -1]))
    assert conditions(method, output)["(2.10)"]
    assert linalg.rank(method.B) == 3
    L = linalg.matmul(linalg.inverse(method.V), output)
    held = conditions(method, L)
    assert (held["B"], held["U"], held["A"], held["L"]) == (True, True, True, False)
    assert same(linalg.matmul(L, L), linalg.identity(3)) is False
    z = [Fraction(k + 1, 7) for k in range(method.s)]
    assert not is_inverse_step(method, method, reversal(4), L, z)


def test_preconsistency_carries_u_with_v_and_spreads_it_with_u() -> None:
    # The printed second line y^n = U y^{n-1} needs s = r, and for N it gives (1, 1), not u.
    for method, u in ((method_n(), [1, 0]), (order4(), [1, 0, 0]), (rk4(), [1])):
        values = vector(u)
        assert all(x == 1 for x in linalg.matvec(method.U, values))
        assert all(x == y for x, y in zip(linalg.matvec(method.V, values), values, strict=True))
    assert linalg.matvec(method_n().U, vector([1, 0]))[1] == 1
    wrong = linalg.diagonal(vector([2, -1]))
    assert linalg.matvec(wrong, vector([1, 0]))[0] != 1


def test_consistency_condition_holds_for_every_method_of_chapter_3() -> None:
    # B 1 + V v = u + v with v = 0: the rows of B after the first sum to zero.
    for method in (method_n(), order4(), real_form(order6())):
        sums = linalg.matvec(method.B, vector([1] * method.s))
        assert sums[0] == 1
        assert all(x.is_zero() for x in sums[1:])
    changed = linalg.matvec(method_n().B, vector([1, 2]))
    assert changed[0] != 1


def test_stages_of_a_consistent_method_are_the_sum_of_the_two_printed_terms() -> None:
    # "A1hUy" lacks a plus sign. On y' = 1 the stages of N are c h + y with c = A 1, for every h, y.
    n = method_n()
    c = linalg.matvec(n.A, vector([1, 1]))
    for h, y in grid(2, 2):
        slopes, values = vector([1, 1]), vector([y, 0])
        stages = [
            a * h + b
            for a, b in zip(linalg.matvec(n.A, slopes), linalg.matvec(n.U, values), strict=True)
        ]
        assert all(x * h + y == Y for Y, x in zip(stages, c, strict=True))
    with pytest.raises(ValueError, match="zip"):
        linalg.matmul(matrix([["1"], ["2"]]), matrix([["1"], ["2"]]))
