"""Khan (2018), sections 2.1, 2.2 and 2.4: one-step and multistep methods, as printed."""

from fractions import Fraction

import pytest

from glmref.exact import exact, linalg
from glmref.method import GLM

from .exactly import (
    dot,
    grid,
    matrix,
    order,
    step_matrix,
    symplectic_defect,
    symplectic_matrix,
    vanishes,
    vector,
)
from .thesis import gauss2, method_n, midpoint, one_value, rk4


def test_explicit_means_that_a_vanishes_on_and_above_the_diagonal() -> None:
    for method in (rk4(), gauss2(), midpoint(), method_n()):
        zero = all(x.is_zero() for i, j, x in linalg.entries(method.A) if i <= j)
        assert method.is_explicit is zero
    assert rk4().is_explicit
    assert not rk4(a44="1").is_explicit


def test_classical_method_has_order_exactly_4_and_is_not_symplectic() -> None:
    assert order(rk4()) == 4
    assert order(rk4(a44="1")) < 4
    assert not vanishes(symplectic_matrix(rk4().A, rk4().B[0]))


def test_printed_classical_stage_lines_are_the_tableau() -> None:
    # k_2 = y + h/2 f(k_1), ... on y' = y with h = 1: the lines give the row sums and 65/24.
    k1 = Fraction(1)
    k2, half = 1 + k1 / 2, Fraction(1, 2)
    k3 = 1 + half * k2
    k4 = 1 + k3
    y = 1 + k1 / 6 + k2 / 3 + k3 / 3 + k4 / 6
    assert y == Fraction(65, 24)
    assert step_matrix(rk4(), ["1"] * 4)[0][0] == y
    assert step_matrix(rk4(a44="1/2"), ["1"] * 4)[0][0] != y


def test_printed_gauss_2_has_order_exactly_1_and_is_not_symplectic() -> None:
    printed = gauss2(a12="1/4+sqrt(3)/6")
    assert order(printed) == 1
    assert not vanishes(symplectic_matrix(printed.A, printed.B[0]))
    # its first row does not even sum to the abscissa printed beside it
    assert printed.A[0][0] + printed.A[0][1] != vector(["1/2-sqrt(3)/6"])[0]


def test_corrected_gauss_2_has_order_exactly_4_and_is_symplectic() -> None:
    right = gauss2()
    assert order(right) == 4
    assert vanishes(symplectic_matrix(right.A, right.B[0]))
    assert right.A[0][0] + right.A[0][1] == vector(["1/2-sqrt(3)/6"])[0]


def adams(steps: int, *, implicit: bool) -> tuple[Fraction, ...]:
    """Weights b_0, b_1, ... of the Adams method of greatest order, by comparing Taylor series."""
    count = steps + implicit
    moments = [[Fraction(m) ** k for m in range(count)] for k in range(count)]
    exact_values = [
        [Fraction(steps ** (k + 1) - (steps - 1) ** (k + 1), k + 1)] for k in range(count)
    ]
    solution = linalg.solve(matrix(moments), matrix(exact_values))
    return tuple(row[0].as_fraction() for row in solution)


def multistep_order(alpha: list[Fraction], beta: list[Fraction]) -> int:
    """Order of sum alpha_m y_{n+m} = h sum beta_m f_{n+m} by its Taylor conditions."""
    if sum(alpha) != 0:
        return -1
    k = 1
    while sum(a * m**k for m, a in enumerate(alpha)) == k * sum(
        b * Fraction(m) ** (k - 1) for m, b in enumerate(beta)
    ):
        k += 1
    return k - 1


@pytest.mark.parametrize("steps", [1, 2, 3, 4])
def test_adams_bashforth_sums_to_s_minus_1_and_the_sum_to_s_is_adams_moulton(steps: int) -> None:
    alpha = [Fraction(0)] * (steps - 1) + [Fraction(-1), Fraction(1)]
    explicit, implicit = adams(steps, implicit=False), adams(steps, implicit=True)
    assert multistep_order(alpha, [*explicit, Fraction(0)]) == steps
    assert multistep_order(alpha, list(implicit)) == steps + 1
    assert implicit[-1] != 0


def test_adams_bashforth_1_and_2_have_the_printed_weights_and_orders() -> None:
    assert adams(1, implicit=False) == (1,)
    assert adams(2, implicit=False) == (Fraction(-1, 2), Fraction(3, 2))
    zero, one = Fraction(0), Fraction(1)
    assert multistep_order([-one, one], [one, zero]) == 1
    assert multistep_order([zero, -one, one], [Fraction(-1, 2), Fraction(3, 2), zero]) == 2
    assert multistep_order([zero, -one, one], [Fraction(1, 2), Fraction(3, 2), zero]) == 0


def test_printed_adams_moulton_example_is_explicit_of_order_1() -> None:
    half, zero, one = Fraction(1, 2), Fraction(0), Fraction(1)
    assert multistep_order([zero, -one, one], [half, half, zero]) == 1
    printed = GLM(A=[["0"]], U=[["1", "0"]], B=[["1/2"], ["1"]], V=[["1", "1/2"], ["0", "0"]])
    assert printed.is_explicit
    assert order(printed) == 1


def test_one_step_adams_moulton_is_the_trapezoidal_rule_of_order_2() -> None:
    assert adams(1, implicit=True) == (Fraction(1, 2), Fraction(1, 2))
    assert order(one_value([["0", "0"], ["1/2", "1/2"]], ["1/2", "1/2"])) == 2


def test_square_of_the_output_carries_the_weights_in_every_sum() -> None:
    # (2.14): <y1, y1> = <y0, y0> + 2 h sum b_i <y0, F_i> + h^2 sum b_i b_j <F_i, F_j>.
    # As printed the first sum has no b_i; degree 2 in each number here.
    b1, b2, disagreements = Fraction(1, 3), Fraction(2, 3), 0
    for h, y, f1, f2 in grid(4, 2):
        square = (y + h * (b1 * f1 + b2 * f2)) ** 2
        first = h * (b1 * y * f1 + b2 * y * f2)
        last = h * h * (b1 * f1 + b2 * f2) ** 2
        assert square == y * y + 2 * first + last
        disagreements += square != y * y + h * (y * f1 + y * f2) + first + last
    assert disagreements > 0


def test_symplectic_derivation_ends_in_the_right_identity() -> None:
    # After substituting (2.13): |y1|^2 - |y0|^2 = 2 h sum b_i <Y_i, F_i> - h^2 sum M_ij <F_i, F_j>.
    for method in (gauss2(), rk4()):
        A, b, s = method.A, method.B[0], method.s
        M = symplectic_matrix(A, b)
        y0, F = exact(3), vector([Fraction((-1) ** i * (i + 2), i + 1) for i in range(s)])
        for h in (Fraction(1, 2), Fraction(2)):
            stages = [y0 + dot(row, F) * h for row in A]
            y1 = y0 + dot(b, F) * h
            production = dot([w * Y for w, Y in zip(b, stages, strict=True)], F) * 2 * h
            assert y1 * y1 - y0 * y0 == production - dot(linalg.matvec(M, F), F) * h * h


def test_conserved_square_is_that_of_the_previous_value() -> None:
    # Midpoint rule on the oscillator: |y_n|^2 = |y_{n-1}|^2; subtracting 1 from y_n breaks it.
    h = Fraction(1, 2)
    scale = 1 / (1 + h * h / 4)
    c, s = (1 - h * h / 4) * scale, h * scale
    p, q = Fraction(2), Fraction(1)
    p1, q1 = c * p - s * q, s * p + c * q
    assert p1**2 + q1**2 == p**2 + q**2
    assert p1**2 + q1**2 != (p1 - 1) ** 2 + (q1 - 1) ** 2


def test_printed_symplectic_euler_is_not_consistent_with_the_printed_equations() -> None:
    # y' = a y, w' = b w is of the printed form. Scheme (2.15), (2.16): w1 = w + h a y,
    # y1 = y + h a w1, whose derivative in h at 0 is (a w, a y), not (a y, b w).
    a, b, y, w = Fraction(2), Fraction(-3), Fraction(5), Fraction(7)
    assert (a * w, a * y) != (a * y, b * w)
    # y' = a w, w' = b y with w1 = w + h b y, y1 = y + h a w1: the derivative is the field.
    h = Fraction(1, 1000)
    w1 = w + h * b * y
    y1 = y + h * a * w1
    assert (y1 - y) / h == a * w + h * a * b * y
    assert (w1 - w) / h == b * y


def test_corrected_symplectic_euler_is_symplectic_and_the_printed_one_turns_the_wrong_way() -> None:
    for h, df, dg in grid(3, 4):  # y+ = y + h f(w+), w+ = w + h g(y), on (w, y)
        step = matrix([[1, h * dg], [h * df, 1 + h * h * df * dg]])
        assert vanishes(symplectic_defect(step))
    # (2.15), (2.16) use f twice: for the oscillator, f' = 1, the trace 2 + h^2 exceeds 2 and the
    # step is hyperbolic; with g' = -1 it is 2 - h^2 and the step is a rotation.
    h = Fraction(1, 10)
    assert 2 + h * h > 2
    assert abs(2 - h * h) < 2


def test_trapezoidal_rule_is_a_multistep_method_that_is_not_symplectic() -> None:
    # An instance of 2.4.3: M_11 = -1/4.
    M = symplectic_matrix(matrix([["0", "0"], ["1/2", "1/2"]]), vector(["1/2", "1/2"]))
    assert M[0][0] == Fraction(-1, 4)


def test_first_value_of_n_does_not_keep_a_quadratic_invariant_and_the_whole_vector_does() -> None:
    # An instance of 2.4.4 on y' = i y: |y_1| changes, |y_1|^2 + g |y_2|^2 does not.
    n = method_n()
    i = exact(-1).sqrt()
    step = step_matrix(n, [i / 2, i / 2])
    start = vector(["1", "1/10"])
    after = linalg.matvec(step, start)
    g = n.G[1][1]

    def squares(y: linalg.Vector) -> tuple[object, object]:
        first, second = (x * x.conjugate() for x in y)
        return first, first + g * second

    assert squares(after)[0] != squares(start)[0]
    assert squares(after)[1] == squares(start)[1]
