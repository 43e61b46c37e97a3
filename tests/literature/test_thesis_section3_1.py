"""Khan (2018), sections 3.0.5 to 3.2 up to (3.5): G-symplectic methods and N, as printed."""

import random
from fractions import Fraction
from itertools import product

import pytest

from glmref.exact import Exact, exact, linalg, root_of_unity
from glmref.exact.linalg import Matrix, Vector
from glmref.method import GLM

from .exactly import (
    determinant,
    dot,
    g_symplectic_defects,
    grid,
    has_a_form,
    is_g_symplectic,
    matrix,
    order,
    random_matrix,
    same,
    vanishes,
    vector,
)
from .thesis import D_N, G_N, complex_form, method_n, order4, order6, real_form


def test_output_equation_has_r_components_and_stages_have_s() -> None:
    # (3.2) prints Y on the left of the output equation: for (3.8) that is 4 numbers equal to 3.
    method = order4()
    slopes = vector([1] * method.s)
    assert len(linalg.matvec(method.A, slopes)) == method.s == 4
    assert len(linalg.matvec(method.B, slopes)) == method.r == 3


def form(G: Matrix, y: Vector, z: Vector | None = None) -> Exact:
    """<y, z>_G for scalar components."""
    value = dot(y, linalg.matvec(G, z or y))
    assert isinstance(value, Exact)
    return value


@pytest.mark.parametrize("build", [method_n, order4, lambda: real_form(order6())])
def test_g_of_n_of_3_8_and_of_order_6_is_indefinite(build: object) -> None:
    # ||y||_G^2 is <y, y>_G, and it is no norm: it takes both signs, so zero for some y != 0.
    G = build().G
    first, second = ([int(i == k) for i in range(len(G))] for k in (0, 1))
    assert form(G, vector(first)).sign() == 1
    assert form(G, vector(second)).sign() == -1
    scale = (exact(-1) / G[1][1]).sqrt()
    isotropic = (exact(1), scale) + (exact(0),) * (len(G) - 2)
    assert scale.is_real()
    assert form(G, isotropic).is_zero()


def test_g_form_of_p_is_positive_and_so_a_norm() -> None:
    G = method_n(1, -1, 1).G
    assert G[1][1].sign() == 1


def random_g_symplectic(numbers: random.Random) -> GLM:
    """Method built from the theorem: B, D, G and a G-orthogonal V free, U and A from them."""
    s = numbers.randint(1, 4)
    g = Fraction(numbers.choice([-3, -2, 2, 5]), 3)
    G = matrix([[1, 0, 0], [0, g, 0], [0, 0, g]])
    V = matrix([["1", "0", "0"], ["0", "3/5", "-4/5"], ["0", "4/5", "3/5"]])
    B = random_matrix(3, s, numbers)
    D = vector([Fraction(numbers.choice([-4, -1, 2, 3]), 5) for _ in range(s)])
    back = linalg.diagonal([exact(1) / d for d in D])
    U = linalg.matmul(back, linalg.transpose(B), G, V)
    full = linalg.matmul(back, linalg.transpose(B), G, B)
    A = tuple(
        tuple(x if j < i else x / 2 if j == i else exact(0) for j, x in enumerate(row))
        for i, row in enumerate(full)
    )
    return GLM(A=A, U=U, B=B, V=V, G=G, D=D)


def production_gap(method: GLM, y: Vector, slopes: Vector) -> Exact:
    """<y+, y+>_G - <y, y>_G - 2 sum d_i Y_i F_i with h = 1."""
    assert method.G is not None and method.D is not None
    pairs = zip(linalg.matvec(method.A, slopes), linalg.matvec(method.U, y), strict=True)
    stages = tuple(a + b for a, b in pairs)
    pairs = zip(linalg.matvec(method.B, slopes), linalg.matvec(method.V, y), strict=True)
    after = tuple(a + b for a, b in pairs)
    weighted = tuple(d * Y for d, Y in zip(method.D, stages, strict=True))
    gap = form(method.G, after) - form(method.G, y) - dot(weighted, slopes) * 2
    assert isinstance(gap, Exact)
    return gap


def random_vector(size: int, numbers: random.Random) -> Vector:
    return random_matrix(1, size, numbers)[0]


def test_theorem_conditions_give_the_invariant_of_random_real_methods() -> None:
    numbers = random.Random(306)
    for _ in range(20):
        method = random_g_symplectic(numbers)
        assert method.G is not None and method.D is not None
        assert is_g_symplectic(method, method.G, method.D)
        y, slopes = random_vector(3, numbers), random_vector(method.s, numbers)
        assert production_gap(method, y, slopes).is_zero()
        near = method.bare(
            A=linalg.add(method.A, linalg.scale(Fraction(1, 9), linalg.identity(method.s))),
            G=method.G,
            D=method.D,
        )
        assert not is_g_symplectic(near, method.G, method.D)
        assert not production_gap(near, y, slopes).is_zero()


@pytest.mark.parametrize("build", [lambda: complex_form(order4()), order6])
def test_complex_methods_need_the_conjugate_transpose(build: object) -> None:
    method: GLM = build()
    G, D = method.G, method.D
    assert G is not None and D is not None
    assert all(x.is_real() for row in G for x in row) and all(d.is_real() for d in D)
    assert is_g_symplectic(method, G, D)
    plain = linalg.sub(linalg.matmul(linalg.transpose(method.V), G, method.V), G)
    assert not vanishes(plain)


def test_last_line_of_the_proof_needs_the_minus_sign_in_the_first_bracket() -> None:
    # For any GLM, symmetric G and diagonal D the gap is -(G - V^TGV)[y, y] - 2 (DU - B^TGV)[F, y]
    # - (DA + A^TD - B^TGB)[F, F]. Printed: -[G V^TGV], a product.
    numbers = random.Random(42)
    wrong = 0
    for s in (1, 2, 3):
        half = random_matrix(2, 2, numbers)
        G = linalg.add(half, linalg.transpose(half))
        D = random_vector(s, numbers)
        method = GLM(
            A=random_matrix(s, s, numbers),
            U=random_matrix(s, 2, numbers),
            B=random_matrix(2, s, numbers),
            V=random_matrix(2, 2, numbers),
            G=G,
            D=D,
        )
        y, slopes = random_vector(2, numbers), random_vector(s, numbers)
        first, second, third = g_symplectic_defects(method, G, D)
        rest = dot(slopes, linalg.matvec(second, y)) * 2 + form(third, slopes)
        gap = production_gap(method, y, slopes)
        assert gap == form(first, y) - rest
        carried = linalg.matmul(linalg.transpose(method.V), G, method.V)
        wrong += gap != -form(linalg.matmul(G, carried), y) - rest
    assert wrong == 3


def test_printed_first_row_a11_a11_is_not_method_n() -> None:
    n = method_n()
    printed = n.bare(A=((n.A[0][0], n.A[0][0]), n.A[1]))
    assert is_g_symplectic(n, G_N, D_N)
    assert not has_a_form(printed)


def eigenvalue_moves_by(V: Matrix, BU: Matrix, zeta: Exact, mu: Exact) -> bool:
    """Whether V + z BU has the eigenvalue ``zeta (1 + mu z) + O(z^2)``; zeta simple.

    The derivative of det(V - zeta I + z (BU - zeta mu I)) at z = 0, row by row.
    """
    size = len(V)
    K = linalg.sub(V, linalg.scale(zeta, linalg.identity(size)))
    E = linalg.sub(BU, linalg.scale(zeta * mu, linalg.identity(size)))
    total = exact(0)
    for i in range(size):
        total = total + determinant((*K[:i], E[i], *K[i + 1 :]))
    return determinant(K).is_zero() is True and total.is_zero() is True


def test_printed_growth_parameter_is_right_for_the_eigenvalue_minus_1() -> None:
    for n in (method_n(), method_n(1, -1, 1)):
        BU = linalg.matmul(n.B, n.U)
        mu = -dot(n.B[1], [row[1] for row in n.U])
        assert same(BU, linalg.diagonal((exact(1), -mu)))
        assert eigenvalue_moves_by(n.V, BU, exact(-1), mu)
        assert not eigenvalue_moves_by(n.V, BU, exact(-1), mu + 1)


def test_growth_parameter_is_the_diagonal_entry_over_the_eigenvalue() -> None:
    numbers = random.Random(34)
    for turn in (Fraction(1, 3), Fraction(1, 4)):
        zeta = root_of_unity(turn.numerator, turn.denominator)
        V = linalg.diagonal((exact(1), zeta, zeta.conjugate()))
        BU = linalg.matmul(random_matrix(3, 4, numbers), random_matrix(4, 3, numbers))
        assert eigenvalue_moves_by(V, BU, zeta, BU[1][1] / zeta)
        assert not eigenvalue_moves_by(V, BU, zeta, -BU[1][1])  # the printed formula


def test_method_3_8_does_not_grow_although_its_real_block_of_bu_is_not_zero() -> None:
    method = order4()
    BU = linalg.matmul(method.B, method.U)
    assert not BU[1][1].is_zero() and not BU[1][2].is_zero()
    assert (BU[1][1] + BU[2][2]).is_zero() and (BU[1][2] - BU[2][1]).is_zero()
    assert eigenvalue_moves_by(method.V, BU, root_of_unity(1, 3), exact(0))


def test_method_n_has_order_exactly_4_where_order_2_is_printed() -> None:
    assert order(method_n()) == 4
    assert order(method_n(), "identity") == 4


def test_two_stages_cannot_be_free_of_parasitism() -> None:
    # (BU)_22 = -2 g b11 x^2 with g, b11, x nonzero; identity of degree 2 in each number.
    for g, b, x in grid(3, 2):
        B, U = matrix([[b, b], [b * x, -b * x]]), matrix([[1, -g * x], [1, g * x]])
        assert same(linalg.matmul(B, U), matrix([[2 * b, 0], [0, -2 * g * b * x * x]]))


def test_three_stages_are_free_of_parasitism_at_order_exactly_2() -> None:
    # b = (1, -1, 1), x = (1, sqrt(2), 1), V = diag(1, -1), G = diag(1, -1): sum b x^2 = 0.
    b, x = vector(["1", "-1", "1"]), vector(["1", "sqrt(2)", "1"])
    A = [[b[j] * (1 - x[i] * x[j]) if j <= i else exact(0) for j in range(3)] for i in range(3)]
    for i in range(3):
        A[i][i] = A[i][i] / 2
    B = (b, tuple(p * q for p, q in zip(b, x, strict=True)))
    G = matrix([[1, 0], [0, -1]])
    method = GLM(A=A, U=[[1, t] for t in x], B=B, V=[[1, 0], [0, -1]])
    assert is_g_symplectic(method, G, b)
    assert linalg.matmul(B, method.U)[1][1].is_zero()
    assert order(method) == 2


def test_all_four_printed_entries_of_v_g_v_are_wrong() -> None:
    # Against V^T G V; (1, 2) is the entry of the printed product V G V. The entries of V take the
    # values 2, 3, 5, 7 and those of G one unit at a time, g12 and g21 kept apart as printed.
    v11, v12, v21, v22 = (Fraction(k) for k in (2, 3, 5, 7))
    V = matrix([[v11, v12], [v21, v22]])
    agree, untransposed = set(product((1, 2), repeat=2)), set(product((1, 2), repeat=2))
    for k in range(4):
        g11, g12, g21, g22 = (Fraction(i == k) for i in range(4))
        printed = matrix(
            [
                [
                    v11**2 * g11 + v11 * v12 * g21 + v11 * v12 * g12 + v12 * v21 * g22,
                    v11 * v12 * g11 + v12**2 * g21 + v11 * v22 * g12 + v12 * v22 * g22,
                ],
                [
                    v21 * v11 * g11 + v22 * v11 * g21 + v21**2 * g12 + v22 * v21 * g21,
                    v21 * v12 * g11 + v22 * v12 * g12 + v21 * g12 * v22 + v22**2 * g12,
                ],
            ]
        )
        G = matrix([[g11, g12], [g21, g22]])
        right = linalg.matmul(linalg.transpose(V), G, V)
        assert right[0][0] == g11 * v11**2 + (g12 + g21) * v11 * v21 + g22 * v21**2
        for i, j, x in linalg.entries(linalg.sub(printed, right)):
            agree -= set() if x.is_zero() else {(i + 1, j + 1)}
        for i, j, x in linalg.entries(linalg.sub(printed, linalg.matmul(V, G, V))):
            untransposed -= set() if x.is_zero() else {(i + 1, j + 1)}
    assert agree == set()
    assert untransposed == {(1, 2)}


def test_diagonal_v_and_g_satisfy_the_first_condition() -> None:
    for sign in (1, -1):
        V, G = linalg.diagonal(vector([1, sign])), linalg.diagonal(vector(["1", "7/3"]))
        assert same(linalg.matmul(linalg.transpose(V), G, V), G)


def test_printed_structure_of_a_and_u_satisfies_the_theorem_for_every_b_g_and_x() -> None:
    # a11 = a22 = b (1 + g x^2)/2, a21 = b (1 - g x^2), U = [[1, -g x], [1, g x]], D = b I.
    for b, g, x in grid(3, 4):
        a, below = b * (1 + g * x * x) / 2, b * (1 - g * x * x)
        method = GLM(
            A=[[a, 0], [below, a]],
            U=[[1, -g * x], [1, g * x]],
            B=[[b, b], [b * x, -b * x]],
            V=[[1, 0], [0, -1]],
        )
        G, D = matrix([[1, 0], [0, g]]), vector([b, b])
        assert is_g_symplectic(method, G, D)
    swapped = method.bare(A=[[below, 0], [a, below]])
    assert not is_g_symplectic(swapped, G, D)


@pytest.mark.parametrize("sign", [1, -1])
def test_third_order_condition_gives_one_sixth_where_one_third_is_printed(sign: int) -> None:
    c1 = matrix([[f"(3+({sign})*sqrt(3))/6"]])[0][0]
    c2 = 1 - c1
    assert (c1 * c1 + c2 * c2) / 2 == Fraction(1, 3)
    assert (c1 * c1 - c1 + Fraction(1, 6)).is_zero()
    assert c1 * c1 - c1 + Fraction(1, 3) == Fraction(1, 6)


def test_printed_g_x_squared_belongs_to_p_and_not_to_the_chosen_c1() -> None:
    # a11 = c1 = (1 + g x^2)/4 gives g x^2 = 4 c1 - 1.
    for sign, name in ((-1, "N"), (1, "P")):
        c1 = matrix([[f"(3+({sign})*sqrt(3))/6"]])[0][0]
        value = 4 * c1 - 1
        assert value == matrix([[f"(3+({sign})*2*sqrt(3))/3"]])[0][0]
        assert (value == matrix([["(3+2*sqrt(3))/3"]])[0][0]) is (name == "P")


def test_printed_3_5_is_g_symplectic_and_only_n_and_p_of_the_sign_patterns_are() -> None:
    holding = [
        signs
        for signs in product((-1, 1), repeat=3)
        if is_g_symplectic(method_n(*signs), method_n(*signs).G, D_N)
    ]
    assert holding == [(-1, 1, -1), (1, -1, 1)]
    others = set(product((-1, 1), repeat=3)) - set(holding)
    assert not any(has_a_form(method_n(*signs)) for signs in others)  # with no other G and D either


def test_reading_six_for_three_below_the_form_of_n_fails() -> None:
    n, g = method_n(), "(3-2*sqrt(3))/6"
    read = n.bare(U=[["1", f"-({g})"], ["1", g]])
    assert not is_g_symplectic(read, matrix([["1", "0"], ["0", g]]), D_N)
    assert not has_a_form(read)


def test_printed_growth_parameter_of_n_is_right() -> None:
    n, p = method_n(), method_n(1, -1, 1)
    mu = [-linalg.matmul(m.B, m.U)[1][1] for m in (n, p)]
    assert mu[0] == matrix([["1-2/sqrt(3)"]])[0][0]
    assert mu[1] == matrix([["1+2/sqrt(3)"]])[0][0]
    assert (mu[0] + Fraction(154700538379, 10**12)).sign() == -1
    assert (mu[0] + Fraction(154700538380, 10**12)).sign() == 1
