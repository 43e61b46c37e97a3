"""For the record: Khan (2018), section 3.4 with c2 = 1/15 and the equations solved correctly.

The corrected W, A and the order-6 methods they give exist and are G-symplectic, but none of them is
free of parasitism, and (3.22) as printed gives no real method at all.
"""

from fractions import Fraction

import pytest

from glmref.exact import Exact, exact, linalg, root_of_unity
from glmref.exact.linalg import Matrix, Vector
from glmref.method import GLM

from .exactly import determinant, dot, is_g_symplectic, matrix, order, printed, same, vector
from .thesis import B6, C6, ZETA3, a_of, sweep

B, C = B6, C6
C2 = Fraction(1, 15)
HALF = Fraction(1, 2)

W_CORRECTED = printed("""
    1 113/85 1296/85 -9823069/57375 -760043/1445
    113/85 41161/50625 16388/3375 -126839227/2278125 -9823069/57375
    1296/85 16388/3375 -957/1240 16388/3375 1296/85
    -9823069/57375 -126839227/2278125 16388/3375 41161/50625 113/85
    -760043/1445 -9823069/57375 1296/85 113/85 1
""")
A_CORRECTED = printed("""
    0 0 0 0 0
    1/30 1/30 0 0 0
    173/120 -11/8 13/30 0 0
    -352873/20250 13643/675 -19096/10125 1/30 0
    -13598/255 352873/5746 -300328/43095 -675/5746 0
""")


def weights(c2: Fraction | Exact) -> tuple[Vector, Vector]:
    """Abscissae (0, c2, 1/2, 1 - c2, 1) and the symmetric weights with moments 1, 1/3 and 1/5."""
    c = vector([0, c2, HALF, exact(1) - c2, 1])
    rows = []
    for k in (0, 2, 4):
        powers = [x**k for x in c]
        rows.append([powers[0] + powers[4], powers[1] + powers[3], powers[2]])
    right = matrix([["1"], ["1/3"], ["1/5"]])
    b1, b2, b3 = (row[0] for row in linalg.solve(matrix(rows), right))
    return (b1, b2, b3, b2, b1), c


def solve_w(c2: Fraction, a33: Fraction) -> Matrix:
    """The W that (3.18) to (3.20), all of (3.21), a33, (3.23) and (3.24) for i < 5 leave possible.

    (3.23) for i = 5 gives W_51; (3.24) for i = 5 is then a consequence, asserted here.
    """
    b, c = weights(c2)
    W: list[list[Exact | None]] = [[None] * 5 for _ in range(5)]

    def put(i: int, j: int, value: Exact) -> None:
        for row, column in ((i, j), (j, i), (4 - i, 4 - j), (4 - j, 4 - i)):
            W[row][column] = value

    def below(i: int, j: int) -> Exact:
        known = W[i][j]
        assert known is not None
        return b[j] * (1 - known) * (HALF if i == j else 1)

    put(0, 0, exact(1))
    put(0, 1, 1 - exact(c2) / 2 / b[0])
    put(1, 1, 1 - exact(c2) / b[1])
    put(2, 2, 1 - exact(2 * a33) / b[2])
    for i in (2, 3):
        known = range(2, i + 1)
        second = (c[i] * c[i] / 2 - sum((below(i, j) * c[j] for j in known), exact(0))) / c[1]
        first = c[i] - second - sum((below(i, j) for j in known), exact(0))
        put(i, 1, 1 - second / b[1])
        put(i, 0, 1 - first / b[0])
    rest = [below(4, j) for j in (1, 2, 3, 4)]
    put(4, 0, 1 - (c[4] - sum(rest, exact(0))) / b[0])
    assert dot(rest, c[1:]) == HALF
    return matrix(W)


def test_equations_have_the_recorded_w_and_a_as_their_only_solution() -> None:
    W = solve_w(C2, HALF - C2)
    assert all(x == y for x, y in zip(weights(C2)[0], B, strict=True))
    assert same(W, W_CORRECTED)
    assert same(a_of(W), A_CORRECTED)
    assert linalg.rank(W) == 3
    assert all(dot(B, row).is_zero() for row in W)  # b^T W = 0
    assert sum((B[i] * W[i][i] for i in range(5)), exact(0)).is_zero()


def halves(W: Matrix) -> tuple[Matrix, Matrix]:
    """The antisymmetric and the symmetric part of W, 2 x 2 and 3 x 3, called W-hat and W-tilde."""
    hat = tuple(tuple((W[i][j] - W[i][4 - j]) / 2 for j in range(2)) for i in range(2))
    tilde = tuple(
        tuple((W[i][j] + W[i][4 - j]) / 2 if j < 2 else W[i][j] for j in range(3)) for i in range(3)
    )
    return hat, tilde


def split(hat: Matrix, tilde: Matrix) -> tuple[Vector, Vector, Vector]:
    """One alpha, beta, gamma with W = alpha alpha^T + beta beta^T - gamma gamma^T."""
    first = hat[0][0].sqrt()
    alpha2 = hat[0][1] / first
    lead = tilde[0][0].sqrt() if tilde[0][0].sign() > 0 else None
    if lead is not None:  # beta the first column, gamma what the rest leaves
        beta = tuple(x / lead for x in tilde[0])
        left = [[beta[i] * beta[j] - tilde[i][j] for j in range(3)] for i in range(3)]
        second = left[1][1].sqrt()
        gamma = tuple(x / second for x in left[1])
    else:  # gamma the first column
        lead = (-tilde[0][0]).sqrt()
        gamma = tuple(-x / lead for x in tilde[0])
        left = [[gamma[i] * gamma[j] + tilde[i][j] for j in range(3)] for i in range(3)]
        second = left[1][1].sqrt()
        beta = tuple(x / second for x in left[1])

    def mirror(half: Vector, sign: int, middle: Exact) -> Vector:
        return (half[0], half[1], middle, half[1] * sign, half[0] * sign)

    return (
        mirror((first, alpha2), -1, exact(0)),
        mirror(beta[:2], 1, beta[2]),
        mirror(gamma[:2], 1, gamma[2]),
    )


def recorded_method(z: Exact) -> tuple[GLM, Vector]:
    """One real-parameter method of the corrected W, and its gamma."""
    alpha, beta, gamma = split(*halves(W_CORRECTED))
    i = exact(-1).sqrt()
    return sweep(B, tuple(a + i * c for a, c in zip(alpha, beta, strict=True)), gamma, z), gamma


@pytest.mark.parametrize("z", [ZETA3, root_of_unity(1, 4)])
def test_recorded_method_is_real_g_symplectic_and_of_order_exactly_6(z: Exact) -> None:
    method, gamma = recorded_method(z)
    assert same(method.A, A_CORRECTED)
    assert all(x.is_real() for x in gamma)
    assert method.G is not None
    assert is_g_symplectic(method, method.G, B)
    assert order(method) == 6


def test_recorded_method_grows() -> None:
    method, gamma = recorded_method(ZETA3)
    BU = linalg.matmul(method.B, method.U)
    mu = -BU[3][3]
    assert mu == dot(B, [x * x for x in gamma])
    assert BU[1][1] / ZETA3 == mu * Fraction(-1, 2)  # b^T diag(W) = 0 ties the two together
    assert (mu + Fraction(3305, 100)).sign() == -1


def is_negative_semidefinite(a: Matrix) -> bool:
    """Decide it for a symmetric matrix: eliminate on negative pivots until only zeros are left."""
    rows = [list(row) for row in a]
    while rows:
        if any(row[k].sign() > 0 for k, row in enumerate(rows)):
            return False
        pivot = next((k for k, row in enumerate(rows) if row[k].sign() < 0), None)
        if pivot is None:  # zero diagonal: semidefinite only if everything is zero
            return all(x.is_zero() for row in rows for x in row)
        lead = rows[pivot]
        keep = [k for k in range(len(rows)) if k != pivot]
        rows = [[rows[i][j] - lead[i] * lead[j] / lead[pivot] for j in keep] for i in keep]
    return True


def growth_bound_holds(bound: Fraction) -> bool:
    """Whether sum b gamma^2 <= -bound is proved for every real splitting of the corrected W.

    Every gamma of a splitting is W x with x^T W x = -1 (the columns alpha, beta, gamma are
    independent, so some x is orthogonal to alpha and beta and has gamma^T x = -1). Hence, if
    ``W diag(b) W - bound W <= 0``, ``sum b gamma^2 = x^T W diag(b) W x <= bound x^T W x = -bound``.
    """
    W = W_CORRECTED
    form = linalg.matmul(W, linalg.diagonal(B), W)
    return is_negative_semidefinite(linalg.sub(form, linalg.scale(exact(bound), W)))


def test_smallest_growth_at_minus_1_is_33_05_for_every_real_splitting() -> None:
    # |mu| = |sum b gamma^2| >= 33.05 whatever alpha, beta, gamma, symmetric pattern or not.
    assert growth_bound_holds(Fraction(33054, 1000))
    assert not growth_bound_holds(Fraction(33055, 1000))


def test_bound_of_the_growth_is_attained_at_an_eigenvalue_of_w_tilde_times_diag_b() -> None:
    # The extreme values of sum b gamma^2 are minus the eigenvalues of W-tilde diag(2 b1, 2 b2, b3),
    # x^2 - t x + m = 0 besides 0; the larger root lies in (33.05, 33.06).
    _, tilde = halves(W_CORRECTED)
    K = linalg.matmul(tilde, linalg.diagonal((B[0] * 2, B[1] * 2, B[2])))
    assert determinant(K).is_zero()

    def characteristic(x: Fraction) -> int:
        return determinant(linalg.sub(K, linalg.scale(exact(x), linalg.identity(3)))).sign()

    assert characteristic(Fraction(3305, 100)) == -characteristic(Fraction(3306, 100)) != 0


def test_no_real_gamma_has_zero_growth_for_c2_one_fifteenth() -> None:
    assert growth_bound_holds(Fraction(1))
    _, gamma = recorded_method(ZETA3)
    assert dot(B, [x * x for x in gamma]).sign() == -1


def isotropic_directions(b: Vector, tilde: Matrix) -> list[Vector]:
    """Directions in the range of W-tilde where 2 b1 x1^2 + 2 b2 x2^2 + b3 x3^2 vanishes."""
    first, second, doubled = tilde[0], tilde[1], (b[0] * 2, b[1] * 2, b[2])

    def form(x: Vector, y: Vector) -> Exact:
        return sum((w * a * b for w, a, b in zip(doubled, x, y, strict=True)), exact(0))

    p, q, r = form(first, first), form(first, second), form(second, second)
    root = (q * q - p * r).sqrt()
    return [
        tuple((-q + root * sign) * x + p * y for x, y in zip(first, second, strict=True))
        for sign in (1, -1)
    ]


def signs_of_isotropic_gammas(c2: Fraction) -> list[int]:
    """Signs of gamma^T W-tilde^+ gamma at the directions free of growth; [] if they are not real.

    A gamma of a splitting without growth lies along one of them, and needs the sign -1: then its
    length can be chosen to make the form -1, and beta is what W-tilde + gamma gamma^T leaves.
    """
    b, _ = weights(c2)
    _, tilde = halves(solve_w(c2, HALF - c2))
    block = tuple(row[:2] for row in tilde[:2])
    signs = []
    for gamma in isotropic_directions(b, tilde):
        if not all(x.is_real() for x in gamma):
            return []
        # gamma = W-tilde x with x3 = 0, so gamma^T W-tilde^+ gamma = x^T gamma
        x = [row[0] for row in linalg.solve(block, ((gamma[0],), (gamma[1],)))]
        signs.append(dot([*x, exact(0)], gamma).sign())
    return signs


def test_both_isotropic_directions_have_the_wrong_sign_for_c2_one_fifteenth() -> None:
    assert signs_of_isotropic_gammas(C2) == [1, 1]


C2_VALUES = {"1/15": False, "1/5": False, "1/4": False, "276/1000": False} | dict.fromkeys(
    ["277/1000", "3/10", "1/3", "2/5", "499/1000"], True
)


@pytest.mark.parametrize("c2", C2_VALUES)
def test_c2_decides_whether_a_real_method_free_of_parasitism_exists(c2: str) -> None:
    value = Fraction(c2)
    hat, tilde = halves(solve_w(value, HALF - value))
    assert determinant(hat).is_zero() and determinant(tilde).is_zero()  # ranks 1 and 2, as needed
    assert hat[0][0].sign() == 1  # alpha is real
    assert (-1 in signs_of_isotropic_gammas(value)) is C2_VALUES[c2]


def test_weight_b3_vanishes_at_the_lower_end_of_the_interval() -> None:
    end = matrix([["(5-sqrt(5))/10"]])[0][0]
    assert isinstance(end, Exact)
    weight, _ = weights(end)
    assert weight[2].is_zero()
    for c2 in ("1/5", "1/4", "276/1000"):  # positive weights: sum b gamma^2 = 0 only for gamma = 0
        assert all(b.sign() == 1 for b in weights(Fraction(c2))[0])
    for c2 in ("277/1000", "1/3", "499/1000"):
        assert [b.sign() for b in weights(Fraction(c2))[0]] == [1, 1, -1, 1, 1]


def test_3_22_as_printed_leaves_no_real_alpha_with_the_printed_pattern() -> None:
    # a33 = c2/2 = 1/30: W-hat is minus a matrix of rank 1, and alpha alpha^T cannot be negative.
    W = solve_w(C2, C2 / 2)
    hat, _ = halves(W)
    assert a_of(W)[2][2] == Fraction(1, 30)
    assert determinant(hat).is_zero()
    assert is_negative_semidefinite(hat)
    assert not same(hat, linalg.zeros(2, 2))
    assert sum((B[i] * W[i][i] for i in range(5)), exact(0)) == Fraction(4, 5)
