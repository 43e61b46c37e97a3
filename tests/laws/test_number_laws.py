"""Exact numbers are a field, balls contain them, texts stand for them, matrices obey algebra."""

from fractions import Fraction

from hypothesis import assume, given
from hypothesis import strategies as st

from glmref.errors import ExactnessError
from glmref.exact import Ball, Exact, exact, linalg
from glmref.exact.expression import parse, to_text
from glmref.exact.linalg import Matrix
from tests.build import refused, same
from tests.examples import examples

LAWS = examples(60)
fractions = st.fractions(min_value=-4, max_value=4, max_denominator=12)
square_free = st.sampled_from([2, 3, 5, 6, 7])


@st.composite
def surds(draw: st.DrawFn, *, real: bool = False) -> Exact:
    """a + b sqrt(m), or a + b sqrt(c + sqrt(m)), or with i: what tableaux are made of."""
    a, b = exact(draw(fractions)), exact(draw(fractions))
    root = exact(draw(square_free)).sqrt()
    kind = draw(st.sampled_from(["rational", "plain", "nested", "imaginary"]))
    if kind == "rational":
        return a
    if kind == "nested":
        return a + b * (root + draw(st.integers(0, 5))).sqrt()
    if kind == "imaginary" and not real:
        return a + b * root + exact(draw(fractions)) * exact(-1).sqrt()
    return a + b * root


real_surds = surds(real=True)


@LAWS
@given(surds(), surds(), surds())
def test_addition_and_multiplication_are_those_of_a_commutative_ring(x, y, z):
    assert (x + y) + z == x + (y + z)
    assert (x * y) * z == x * (y * z)
    assert x * (y + z) == x * y + x * z
    assert x + y == y + x
    assert x * y == y * x
    assert x - x == 0
    assert x * 1 == x
    assert -x == 0 - x


@LAWS
@given(surds(), surds())
def test_division_undoes_multiplication(x: Exact, y: Exact) -> None:
    assume(not y.is_zero())
    assert x / y * y == x
    assert y * (1 / y) == 1
    assert (x / y).is_zero() == x.is_zero()


@LAWS
@given(surds())
def test_the_principal_root_squares_back_and_lies_in_the_right_half_plane(x: Exact) -> None:
    root = x.sqrt()
    assert root * root == x
    assert complex(root).real >= -1e-300


@LAWS
@given(surds(), surds())
def test_conjugation_is_a_field_automorphism(x: Exact, y: Exact) -> None:
    assert (x * y).conjugate() == x.conjugate() * y.conjugate()
    assert (x + y).conjugate() == x.conjugate() + y.conjugate()
    assert x.conjugate().conjugate() == x
    assert (x + x.conjugate()) / 2 == x.real
    assert (x * x.conjugate()).is_real()


@LAWS
@given(real_surds, real_surds)
def test_signs_order_the_real_numbers(x: Exact, y: Exact) -> None:
    assert (x * y).sign() == x.sign() * y.sign()
    assert (-x).sign() == -x.sign()
    if x.sign() == y.sign():
        assert (x + y).sign() == x.sign()
    assert (x - y).sign() == -(y - x).sign()
    if abs(float(x) - float(y)) > 1e-12:  # far above the rounding of numbers of this size
        assert (x - y).sign() == (1 if float(x) > float(y) else -1)


@LAWS
@given(fractions, fractions)
def test_rational_numbers_agree_with_fractions(p: Fraction, q: Fraction) -> None:
    assert (exact(p) + exact(q)).as_fraction() == p + q
    assert (exact(p) * exact(q)).as_fraction() == p * q
    assert (exact(p) == exact(q)) == (p == q)
    if q:
        assert (exact(p) / q).as_fraction() == p / q
    assert float(exact(p)) == float(p)


@LAWS
@given(surds(), surds())
def test_the_ball_of_a_result_meets_the_result_of_the_balls(x: Exact, y: Exact) -> None:
    a, b = x.ball(), y.ball()
    assert (a + b).overlaps(x + y)
    assert (a - b).overlaps(x - y)
    assert (a * b).overlaps(x * y)
    if not y.is_zero():
        assert (a / b).overlaps(x / y)
        assert (1 / b).radius() < 1e-100
    assert isinstance(a + y, Ball)  # mixing the two kinds gives a ball


@LAWS
@given(real_surds, real_surds, st.integers(2, 12))
def test_a_wide_ball_contains_every_exact_result(x: Exact, y: Exact, digits: int) -> None:
    width = Fraction(1, 10**digits)
    a, b = Ball.around(x.ball(), width), Ball.around(y.ball(), width)
    assert a.contains(x)
    assert not a.contains(x + 2 * width)
    assert (a + b).contains(x + y)
    assert (a - b).contains(x - y)
    assert (a * b).contains(x * y)
    if b.is_zero() is False:
        assert (a / b).contains(x / y)
    if a.is_zero() is False and x.sign() > 0:
        assert a.sqrt().contains(x.sqrt())
    assert (x - y).is_zero() or not (a - b).is_zero()  # nothing but zero is called zero


@LAWS
@given(real_surds, st.integers(1, 12))
def test_the_ball_of_a_rounded_decimal_contains_the_number(x: Exact, digits: int) -> None:
    rounded = Fraction(round(Fraction(float(x)) * 10**digits), 10**digits)
    sign = "-" if rounded < 0 else ""
    whole, rest = divmod(abs(rounded) * 10**digits, 10**digits)
    decimal = parse(f"{sign}{whole}.{int(rest):0{digits}d}", digits=digits)
    if not rounded:
        assert decimal == Exact(0)  # a printed zero is zero
        return
    # half a unit from rounding, and the error of float(x), far below the other half: 12 digits
    assert decimal.contains(x)
    far = exact(Fraction(3, 2 * 10**digits)) + rounded
    assert not decimal.contains(far)


@LAWS
@given(surds())
def test_printing_and_parsing_give_the_number_back(x: Exact) -> None:
    try:
        text = to_text(x)
    except ExactnessError:
        assume(False)  # no square-root form is a permitted answer, a wrong one is not
    assert parse(text) == x
    assert parse(to_text(parse(text))) == x


#: Of each kind what flint keeps as a root of its own polynomial, a power or a root of unity.
ATOMS = st.sampled_from(
    "i sqrt(-3) sqrt(-7) sqrt(-3/4) sqrt(2) sqrt(12) sqrt(-1/3) sqrt(i) sqrt(1+i) root(5,4) root(2,3) "
    "exp(2*pi*i/3) exp(2*pi*i/5) exp(-4*pi*i/7) exp(pi*i/8) sqrt(sqrt(-3)) sqrt(2+sqrt(-3)) "
    "sqrt(-sqrt(2)) sqrt(3-sqrt(5)) exp(pi*i/6)".split()
)


@LAWS
@given(fractions, fractions, fractions, ATOMS, ATOMS)
def test_every_text_of_the_grammar_is_written_again(p, q, r, first, second) -> None:
    value = parse(f"{p}+({q})*{first}+({r})*{second}")
    assert parse(to_text(value)) == value


@st.composite
def expressions(draw: st.DrawFn, depth: int = 3) -> tuple[str, Exact]:
    """An expression and the value its tree has, computed beside the parser."""
    if depth == 0 or draw(st.booleans()):
        number = draw(st.integers(0, 40))
        return str(number), exact(number)
    kind = draw(st.sampled_from("+-*/s~"))
    left, x = draw(expressions(depth - 1))
    if kind == "s":
        radicand = draw(st.integers(0, 12))
        return f"sqrt({radicand})", exact(radicand).sqrt()
    if kind == "~":
        return f"(-({left}))", -x
    right, y = draw(expressions(depth - 1))
    if kind == "/":
        assume(not y.is_zero())
    value = {"+": x + y, "-": x - y, "*": x * y, "/": x / y if kind == "/" else x}[kind]
    space = draw(st.sampled_from(["", " ", "\t"]))
    return f"({left}){space}{kind}{space}({right})", exact(value)


@LAWS
@given(expressions())
def test_the_parser_computes_what_the_tree_of_the_expression_says(case: tuple[str, Exact]) -> None:
    text, value = case
    assert parse(text) == value
    assert parse(f"0-({text})") == -value


@st.composite
def several(draw: st.DrawFn, *shapes: tuple[int, int]) -> tuple[Matrix, ...]:
    """Matrices over one field Q(sqrt m), as those of a tableau are; every third entry is zero."""
    root = exact(draw(square_free)).sqrt()
    zero = st.just(exact(0))
    entry = st.builds(lambda p, q: p + q * root, fractions, fractions)
    kind = draw(st.sampled_from([fractions.map(exact), zero | entry | entry]))
    return tuple(
        tuple(tuple(draw(kind) for _ in range(columns)) for _ in range(rows))
        for rows, columns in shapes
    )


@examples(25)
@given(several((2, 3), (3, 2), (2, 2)))
def test_matrix_products_are_associative_and_transpose_in_reverse(m: tuple[Matrix, ...]) -> None:
    a, b, c = m
    assert same(linalg.matmul(linalg.matmul(a, b), c), linalg.matmul(a, linalg.matmul(b, c)))
    assert same(
        linalg.transpose(linalg.matmul(a, b)),
        linalg.matmul(linalg.transpose(b), linalg.transpose(a)),
    )


@examples(25)
@given(several((3, 3)))
def test_an_inverse_is_one_from_both_sides_or_does_not_exist(m: tuple[Matrix]) -> None:
    (a,) = m
    try:
        back = linalg.inverse(a)
    except ExactnessError:
        assert linalg.rank(a) < 3
        assert linalg.nullspace(a)
        return
    assert linalg.rank(a) == 3
    assert linalg.nullspace(a) == []
    assert same(linalg.matmul(a, back), linalg.identity(3))
    assert same(linalg.matmul(back, a), linalg.identity(3))


@examples(25)
@given(several((3, 2), (2, 4)))
def test_rank_and_nullity_add_up_and_the_nullspace_is_mapped_to_zero(m: tuple[Matrix, ...]) -> None:
    product = linalg.matmul(*m)  # of rank 2 at most
    kernel = linalg.nullspace(product)
    assert linalg.rank(product) <= 2
    assert linalg.rank(product) + len(kernel) == 4
    for vector in kernel:
        assert all(x.is_zero() for x in linalg.matvec(product, vector))
    if kernel:
        assert linalg.rank(tuple(kernel)) == len(kernel)


@examples(25)
@given(several((3, 3), (3, 1)))
def test_a_solution_solves(m: tuple[Matrix, ...]) -> None:
    a, right = m
    assume(linalg.rank(a) == 3)
    assert same(linalg.matmul(a, linalg.solve(a, right)), right)


def test_a_nearly_singular_matrix_is_inverted_and_a_singular_one_is_not() -> None:
    tiny = exact(Fraction(1, 10**40))
    root = exact(2).sqrt()
    singular = ((root, exact(2)), (exact(1), root))
    refused(ExactnessError, "rank 1 cannot be inverted", linalg.inverse, singular)
    near = ((root, exact(2)), (exact(1), root + tiny))
    assert same(linalg.matmul(near, linalg.inverse(near)), linalg.identity(2))
