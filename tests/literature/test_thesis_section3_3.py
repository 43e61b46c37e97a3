"""Khan (2018), (3.6) to (3.9): starting methods and the order-4 method, as printed."""

from fractions import Fraction
from itertools import permutations

import pytest

from glmref.exact import Exact, exact, linalg, root_of_unity
from glmref.exact.linalg import Matrix, Vector
from glmref.method import GLM, StartingMethod
from glmref.theory.order import order_of
from glmref.theory.series import Series, compose, flow
from tests.bseries import elementary_weights

from .exactly import (
    after_step,
    dot,
    first_difference,
    g_symplectic_defects,
    has_a_form,
    is_g_symplectic,
    matrix,
    order,
    same,
    vanishes,
    vector,
)
from .thesis import (
    START4_PRINTED,
    START_CORRECTED,
    START_PRINTED,
    complex_form,
    gamma_matrix,
    method_n,
    order4,
    rk4,
    s4,
    starter_n,
)

# Weights of the exact flow on the trees t, [t], [t,t], [[t]].
TREES = ("t", "[t]", "[t,t]", "[[t]]")
FLOW = (Fraction(1), Fraction(1, 2), Fraction(1, 3), Fraction(1, 6))


def plus(*terms: Vector) -> Vector:
    """Sum of vectors."""
    return tuple(sum(column[1:], column[0]) for column in zip(*terms, strict=True))


def times(factor: Exact | Fraction | int, x: Vector) -> Vector:
    """Multiple of a vector."""
    return tuple(y * factor for y in x)


def starting_values(method: GLM) -> dict[str, Vector]:
    """Weights of the values y_2, ..., y_r that a step carries on, through order 3.

    Solves eta = B xiD + V eta - (E eta - eta) tree by tree, with y_1 the solution itself.
    The first row is the order condition, asserted on the way.
    """
    u = vector([1] + [0] * (method.r - 1))
    eta: dict[str, Vector] = {}

    def stage(name: str, slopes: Vector) -> Vector:
        return plus(linalg.matvec(method.A, slopes), linalg.matvec(method.U, eta[name]))

    ones = vector([1] * method.s)
    for name in TREES:
        if name == "t":
            slopes, moved = ones, times(FLOW[0], u)
        elif name == "[t]":
            c = stage("t", ones)
            slopes, moved = c, plus(eta["t"], times(FLOW[1], u))
        elif name == "[t,t]":
            slopes = tuple(x * x for x in c)
            moved = plus(times(2, eta["[t]"]), eta["t"], times(FLOW[2], u))
        else:
            slopes = stage("[t]", c)
            moved = plus(eta["[t]"], times(FLOW[1], eta["t"]), times(FLOW[3], u))
        right = plus(linalg.matvec(method.B, slopes), times(-1, moved))
        assert right[0].is_zero(), name
        rest = linalg.sub(linalg.identity(method.r), method.V)
        block = tuple(row[1:] for row in rest[1:])
        tail = linalg.solve(block, tuple((x,) for x in right[1:]))
        eta[name] = (exact(0), *(row[0] for row in tail))
    return eta


def starter_weights(start: StartingMethod, row: int) -> dict[str, Exact]:
    """Weights of one starting value on the four trees."""
    c = linalg.matvec(start.A, vector([1] * start.stages))
    products = (vector([1] * start.stages), c, tuple(x * x for x in c), linalg.matvec(start.A, c))
    return {name: dot(start.B[row], x) for name, x in zip(TREES, products, strict=True)}


def agreement(method: GLM, start: StartingMethod, row: int) -> list[str]:
    """Trees on which a starting value has the weight the method carries on."""
    wanted, got = starting_values(method), starter_weights(start, row)
    return [name for name in TREES if (wanted[name][row] - got[name]).is_zero()]


def test_printed_starter_3_6_is_right_through_the_second_order_only() -> None:
    assert agreement(method_n(), starter_n(START_PRINTED), 1) == ["t", "[t]", "[t,t]"]
    weight = starter_weights(starter_n(START_PRINTED), 1)["[[t]]"]
    assert weight == matrix([["(1-sqrt(3))/12"]])[0][0]
    assert starting_values(method_n())["[[t]]"][1].is_zero()


def test_corrected_starter_3_6_is_exact_through_order_3() -> None:
    assert agreement(method_n(), starter_n(START_CORRECTED), 1) == list(TREES)


def test_explicit_starter_for_n_is_exact_through_order_3() -> None:
    A = matrix([["0", "0", "0"], ["1/2", "0", "0"], ["-1/2", "0", "0"]])
    B = matrix([["0", "0", "0"], ["0", "-sqrt(3)/12", "sqrt(3)/12"]])
    assert agreement(method_n(), StartingMethod(A=A, B=B, u=vector([1, 0])), 1) == list(TREES)


def test_gamma_and_its_inverse() -> None:
    inverse = matrix([["1", "0", "0"], ["0", "1", "1"], ["0", "-i", "i"]])
    assert same(linalg.inverse(gamma_matrix()), inverse)


def test_printed_gamma_star_is_the_inverse_and_not_the_conjugate_transpose() -> None:
    printed = matrix([["1", "0", "0"], ["0", "1", "1"], ["0", "-i", "i"]])
    right = matrix([["1", "0", "0"], ["0", "1/2", "1/2"], ["0", "-i/2", "i/2"]])
    assert same(linalg.conjugate_transpose(gamma_matrix()), right)
    form = linalg.diagonal(vector(["1", "-1/2", "-1/2"]))
    real = linalg.diagonal(vector(["1", "-1/4", "-1/4"]))
    assert same(linalg.matmul(right, form, gamma_matrix()), real)
    assert same(linalg.matmul(printed, form, gamma_matrix()), form)  # it would leave G as it was


def test_printed_a21_of_3_8_fails_the_third_identity_and_has_order_1() -> None:
    printed = order4(a21="-11/72")
    first, second, third = g_symplectic_defects(printed, printed.G, printed.D)
    assert vanishes(first) and vanishes(second)
    assert third[0][1] == third[1][0] == Fraction(-2365, 48384)
    assert [(i, j) for i, j, x in linalg.entries(third) if not x.is_zero()] == [(0, 1), (1, 0)]
    assert not has_a_form(printed)
    assert order(printed) == 1


def test_corrected_3_8_is_g_symplectic_of_order_exactly_4() -> None:
    right = order4()
    assert is_g_symplectic(right, right.G, right.D)
    assert order(right) == 4
    assert order(right, "identity") == 4
    c = linalg.matvec(right.A, vector([1] * 4))
    assert all(x == y for x, y in zip(c, vector(["0", "8/43", "35/43", "1"]), strict=True))


def forced_by_the_theorem(method: GLM, G: Matrix, D: Vector) -> tuple[Matrix, Matrix]:
    """U and lower triangular A that B, V, G and D leave possible."""
    scaled = linalg.matmul(
        linalg.diagonal([exact(1) / d for d in D]), linalg.transpose(method.B), G
    )
    full = linalg.matmul(scaled, method.B)
    A = tuple(
        tuple(x if j < i else x / 2 if j == i else exact(0) for j, x in enumerate(row))
        for i, row in enumerate(full)
    )
    return linalg.matmul(scaled, method.V), A


def test_every_printed_entry_of_a_and_u_but_a21_is_the_forced_one() -> None:
    printed = order4(a21="-11/72")
    assert printed.G is not None and printed.D is not None
    U, A = forced_by_the_theorem(printed, printed.G, printed.D)
    assert same(printed.U, U)
    differing = [(i, j) for i, j, x in linalg.entries(linalg.sub(A, printed.A)) if not x.is_zero()]
    assert differing == [(1, 0)]
    assert A[1][0] == Fraction(-11, 172)


def test_printed_b_row_of_3_8_is_the_quadrature_of_the_corrected_abscissae() -> None:
    method = order4()
    b, c = method.B[0], linalg.matvec(method.A, vector([1] * 4))
    moments = [dot(b, [x**k for x in c]) for k in range(5)]
    assert [m == Fraction(1, k + 1) for k, m in enumerate(moments)] == [True] * 4 + [False]


def test_printed_b_of_3_8_has_no_growth_at_the_complex_eigenvalues() -> None:
    # rows b omega of the complex form: sum b |omega|^2 = 0.
    method = complex_form(order4())
    assert method.V[1][1] == root_of_unity(1, 3)
    b, row = method.B[0], method.B[1]
    assert sum((x * x.conjugate() / w for x, w in zip(row, b, strict=True)), exact(0)).is_zero()
    near = tuple(x * (1 + Fraction(i == 0, 1000)) for i, x in enumerate(row))
    assert not sum(
        (x * x.conjugate() / w for x, w in zip(near, b, strict=True)), exact(0)
    ).is_zero()


def test_printed_g_and_d_of_3_8_are_the_forms_of_the_theorem() -> None:
    method = order4()
    wrong = linalg.diagonal(vector(["1", "-1/2", "-1/2"]))  # the complex G kept in the real form
    assert is_g_symplectic(method, method.G, method.D)
    assert not is_g_symplectic(method, wrong, method.D)
    assert all(d == b for d, b in zip(method.D, method.B[0], strict=True))


SURDS = (
    (
        "-10229/30420+3*sqrt(3)*sqrt(14595)/4732",
        "40777/212940-10523*sqrt(3)*sqrt(14595)/22358700",
        "391/2028-12157*sqrt(3)*sqrt(14595)/22358700",
        "-10229/212940+9*sqrt(3)*sqrt(14595)/23660",
    ),
    (
        "-10229*sqrt(3)/42588-3*sqrt(14595)/3380",
        "391*sqrt(3)/2028+12157*sqrt(14595)/22358700",
        "40777*sqrt(3)/212940+10523*sqrt(14595)/22358700",
        "-10229*sqrt(3)/70980-3*sqrt(14595)/23660",
    ),
)


def starter4(rows: tuple[tuple[str, ...], ...]) -> StartingMethod:
    """Starting method (3.9): the stages of the classical method with the given weights."""
    zero = ("0",) * 4
    return StartingMethod(A=rk4().A, B=matrix([zero, *rows]), u=vector([1, 0, 0]))


def test_starter_3_9_with_exact_weights_is_exact_through_order_3() -> None:
    # Four stages, four trees: the weights are determined, so these surds are the only ones.
    c = linalg.matvec(rk4().A, vector([1] * 4))
    system = (vector([1] * 4), c, tuple(x * x for x in c), linalg.matvec(rk4().A, c))
    wanted = starting_values(order4())
    right = tuple(wanted[name][1:] for name in TREES)
    assert same(linalg.transpose(linalg.solve(system, right)), matrix(SURDS))
    for row in (1, 2):
        assert agreement(order4(), starter4(SURDS), row) == list(TREES)


@pytest.mark.parametrize("row", [0, 1])
def test_printed_decimals_of_3_9_are_the_rounded_surds(row: int) -> None:
    # 15 decimals are printed, so half a unit is 5e-16; the largest difference is below 4.2e-16.
    limit = Fraction(42, 10**17)
    for printed, surd in zip(START4_PRINTED[row], matrix(SURDS)[row], strict=True):
        difference = surd - Fraction(printed)
        assert (difference - limit).sign() == -1
        assert (difference + limit).sign() == 1


def test_a_changed_last_digit_of_3_9_is_seen() -> None:
    changed = Fraction("0.093013520189575") - matrix(SURDS)[0][1]
    assert (changed - Fraction(5, 10**16)).sign() == 1


def exchanges(s: int) -> list[Matrix]:
    """All permutation matrices P with P^2 = I."""
    found = []
    for order_ in permutations(range(s)):
        if all(order_[order_[i]] == i for i in range(s)):
            found.append(
                tuple(tuple(exact(int(order_[i] == j)) for j in range(s)) for i in range(s))
            )
    return found


def involutions_for(method: GLM, P: Matrix) -> list[Matrix]:
    """The L with B = V L B P, L^2 = I, A + PAP = U V^-1 B; at most one, since B has full rank."""
    mul = linalg.matmul
    flat = linalg.transpose(method.B)
    right = mul(flat, linalg.inverse(mul(method.B, flat)))
    back = mul(method.B, P, right)  # (V L)^-1, if there is an L
    if not same(mul(back, method.B), mul(method.B, P)):
        return []
    inverse_v = linalg.inverse(method.V)
    L = mul(inverse_v, linalg.inverse(back))
    both = linalg.add(method.A, mul(P, method.A, P))
    square = same(mul(L, L), linalg.identity(method.r))
    return [L] if square and same(both, mul(method.U, inverse_v, method.B)) else []


def test_method_3_8_is_symmetric_for_no_exchange_of_its_stages() -> None:
    assert len(exchanges(4)) == 10
    assert not any(involutions_for(order4(), P) for P in exchanges(4))
    assert [bool(involutions_for(s4(), P)) for P in exchanges(4)].count(True) == 1


def test_order_with_a_starting_method_is_the_printed_difference() -> None:
    # M S - S E for N: with a starter exact through order 3 it is O(h^5) in y_1 and O(h^4) in y_2;
    # with the full starting series O(h^5) in both, which is order 4; with y_2 = 0, S_4 = (1, 0).
    n = method_n()
    explicit = [["0"] * 3, ["1/2", "0", "0"], ["-1/2", "0", "0"]]
    weights = matrix([["0"] * 3, ["0", "-sqrt(3)/12", "sqrt(3)/12"]])
    u = vector([1, 0])
    short = elementary_weights(matrix(explicit), weights, 5, u=u)
    none = Series({}, u, 5)
    for start, orders in ((short, (5, 4)), (none, (4, 2))):
        after, exact_flow = after_step(n, start), compose(flow(5), start)
        assert tuple(first_difference(after, exact_flow, k) for k in (0, 1)) == orders
    full = order_of(n, principal="identity").eta
    assert full is not None and full.order == 4
    after, exact_flow = after_step(n, full), compose(flow(full.order), full)
    assert [first_difference(after, exact_flow, k) for k in (0, 1)] == [5, 5]
