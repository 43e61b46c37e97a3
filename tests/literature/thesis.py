"""Tableaux of Khan (2018) for the literature tests: as printed, and as corrected where noted."""

from collections.abc import Sequence
from fractions import Fraction

from glmref.exact import Exact, Scalar, exact, linalg, root_of_unity
from glmref.exact.linalg import Matrix, Vector
from glmref.method import GLM, Entry, StartingMethod

from .exactly import matrix, printed, vector


def one_value(A: Sequence[Sequence[Entry]], b: Sequence[Entry]) -> GLM:
    """Runge-Kutta method as a GLM: U and V are ones, section 2.3."""
    return GLM(A=A, U=[["1"]] * len(b), B=[b], V=[["1"]])


def euler() -> GLM:
    """Euler's method, section 1.1."""
    return one_value([["0"]], ["1"])


def rk4(a44: str = "0") -> GLM:
    """The classical method, section 2.1.1."""
    A = [["0"] * 4, ["1/2", "0", "0", "0"], ["0", "1/2", "0", "0"], ["0", "0", "1", a44]]
    return one_value(A, ["1/6", "1/3", "1/3", "1/6"])


def gauss2(a12: str = "1/4-sqrt(3)/6") -> GLM:
    """Gauss with two stages, section 2.1.2; printed with ``a12 = 1/4+sqrt(3)/6``."""
    return one_value([["1/4", a12], ["1/4+sqrt(3)/6", "1/4"]], ["1/2", "1/2"])


def midpoint() -> GLM:
    """Implicit midpoint rule."""
    return one_value([["1/2"]], ["1"])


def method_n(diagonal: int = -1, below: int = 1, form: int = -1) -> GLM:
    """Tableau (3.5) with the signs of sqrt(3) in ``a11 = a22``, in ``a21``, and in U and G.

    The printed N is (-1, +1, -1); P is (+1, -1, +1).
    """
    a = f"(3+({diagonal})*sqrt(3))/6"
    g = f"(3+({form})*2*sqrt(3))/3"
    return GLM(
        A=[[a, "0"], [f"({below})*sqrt(3)/3", a]],
        U=[["1", f"-({g})"], ["1", g]],
        B=[["1/2", "1/2"], ["1/2", "-1/2"]],
        V=[["1", "0"], ["0", "-1"]],
        G=[["1", "0"], ["0", g]],
        D=["1/2", "1/2"],
    )


G_N: Matrix = matrix([["1", "0"], ["0", "(3-2*sqrt(3))/3"]])
D_N: Vector = vector(["1/2", "1/2"])

#: (3.6): internal stages as printed and corrected, and the weights of y_2.
START_PRINTED = [["(3-sqrt(3))/6", "0"], ["-(3-sqrt(3))/3", "(3-sqrt(3))/6"]]
START_CORRECTED = [["(3-sqrt(3))/6", "0"], ["0", "-(3-sqrt(3))/6"]]


def starter_n(A: Sequence[Sequence[Entry]]) -> StartingMethod:
    """Starting method (3.6) with the given internal stages."""
    weight = "(sqrt(3)+1)/8"
    return StartingMethod(
        A=matrix(A), B=matrix([["0", "0"], [f"-{weight}", weight]]), u=vector(["1", "0"])
    )


_R = "1973/29068-2*sqrt(3)*sqrt(14595)/7267"
_T = "1973*sqrt(3)/29068+2*sqrt(14595)/7267"


def order4(a21: str = "-11/172") -> GLM:
    """Tableau (3.8); printed with ``a21 = -11/72``."""
    return GLM(
        A=[
            ["0", "0", "0", "0"],
            [a21, "1/4", "0", "0"],
            ["-2647/72240", "1009/1680", "1/4", "0"],
            ["-169/1680", "113821/283920", "473/676", "0"],
        ],
        U=[
            ["1", "1/4", "sqrt(3)/4"],
            ["1", f"-({_R})", f"-({_T})"],
            ["1", _R, _T],
            ["1", "-1/4", "-sqrt(3)/4"],
        ],
        B=[
            ["-169/3360", "1849/3360", "1849/3360", "-169/3360"],
            ["-169/1680", "-84839/283920", "84839/283920", "169/1680"],
            ["0", "-43*sqrt(14595)/35490", "43*sqrt(14595)/35490", "0"],
        ],
        V=[["1", "0", "0"], ["0", "-1/2", "-sqrt(3)/2"], ["0", "sqrt(3)/2", "-1/2"]],
        G=[["1", "0", "0"], ["0", "-1/4", "0"], ["0", "0", "-1/4"]],
        D=["-169/3360", "1849/3360", "1849/3360", "-169/3360"],
    )


#: (3.9): weights of y_2 and of y_3 on the stages of the classical method, as printed.
START4_PRINTED = (
    ("-0.203599283611326", "0.093013520189574", "0.079026915254744", "0.031558848167008"),
    ("-0.523240277404552", "0.399628138816171", "0.388537971512798", "-0.264925832924417"),
)


def gamma_matrix(extra: int = 0) -> Matrix:
    """The transformation (3.7), with ``extra`` further values left as they are."""
    block = matrix([["1", "0", "0"], ["0", "1/2", "i/2"], ["0", "1/2", "-i/2"]])
    return linalg.block_diagonal(block, linalg.identity(extra)) if extra else block


def real_form(method: GLM) -> GLM:
    """Carry ``gamma^-1 y`` instead of y: section 3.3 below (3.7)."""
    return method.transform(linalg.inverse(gamma_matrix(method.r - 3)))


def complex_form(method: GLM) -> GLM:
    """Undo :func:`real_form`."""
    return method.transform(gamma_matrix(method.r - 3))


def sweep(b: Vector, omega: Vector, gamma: Vector, z: Scalar) -> GLM:
    """The method of section 3.4: B and V as printed, U from (3.11), A from (3.14) with the half.

    G = diag(1, -1/2, -1/2, 1) and D = diag(b), as chosen there.
    """
    g = linalg.diagonal(vector(["1", "-1/2", "-1/2", "1"]))
    X = (
        tuple(exact(1) for _ in b), omega, tuple(w.conjugate() for w in omega), gamma,
    )  # fmt: skip
    B = tuple(tuple(x * weight for x, weight in zip(row, b, strict=True)) for row in X)
    V = linalg.diagonal((exact(1), z, z.conjugate(), exact(-1)))
    star = linalg.conjugate_transpose
    U = linalg.matmul(star(X), g, V)
    full = linalg.matmul(star(X), g, B)
    A = tuple(
        tuple(x if j < i else x / 2 if j == i else exact(0) for j, x in enumerate(row))
        for i, row in enumerate(full)
    )
    return GLM(A=A, U=U, B=B, V=V, G=g, D=b)


#: Abscissae and weights of the printed order-6 method.
C6 = vector(["0", "1/15", "1/2", "14/15", "1"])
B6 = vector(["-17/168", "3375/9464", "248/507", "3375/9464", "-17/168"])

W6_PRINTED = printed("""
    1 113/85 -5613/85 -466429841/745875 36703237/18785
    113/85 41161/50625 -65239/3375 -466060571/2278125 36946367/57375
    -5613/85 -65239/3375 1071/1240 -65239/3375 -5613/85
    -466429841/745875 -466060571/2278125 -65239/3375 41161/50625 113/85
    36703237/18785 36946367/57375 -5613/85 113/85 1
""")

A6_PRINTED = printed("""
    0 0 0 0 0
    1/30 1/30 0 0 0
    691/105 29/4 1/30 0 0
    -16684847/263250 8363191/114075 100688/10125 1/30 0
    1310159/6630 -658732/2873 1413104/43095 -675/5746 0
""")

W6_HAT_PRINTED = matrix(
    [["-18342226/18785", "-198163/49725"], ["-198163/49725", "233956408/2278125"]]
)
W6_TILDE_PRINTED = printed("""
    18361011/18785 264268/49725 -5613/85
    264268/49725 -232104163/2278125 -65239/3375
    -5613/85 -65239/3375 1071/1240
""")


def a_of(W: Matrix) -> Matrix:
    """A of (3.14) to (3.16), with the half on the diagonal."""
    half = Fraction(1, 2)
    return tuple(
        tuple(
            B6[j] * (1 - W[i][j]) * (half if i == j else 1) if j <= i else exact(0)
            for j in range(5)
        )
        for i in range(5)
    )


ZETA3: Exact = root_of_unity(1, 3)


def order6(z: Scalar = ZETA3) -> GLM:
    """The same construction with c2 = 1/3, where it succeeds (complex form)."""
    x, y = "sqrt((65274*sqrt(330)-347009)/1265902)", "sqrt((5934*sqrt(330)-70541)/115082)"
    beta2 = f"-(70518*sqrt(330)+318613)/(3107214*{x})"
    beta3 = f"-(18285*sqrt(330)+162856)/(460328*{x})"
    gamma2 = f"-(23506*sqrt(330)-462231)/(1035738*{y})"
    gamma3 = f"-(18285*sqrt(330)-423016)/(460328*{y})"
    alpha = vector(["4*sqrt(5)/11", "-4*sqrt(5)/27", "0", "4*sqrt(5)/27", "-4*sqrt(5)/11"])
    beta = vector([x, beta2, beta3, beta2, x])
    gamma = vector([y, gamma2, gamma3, gamma2, y])
    i = exact(-1).sqrt()
    omega = tuple(a + i * c for a, c in zip(alpha, beta, strict=True))
    return sweep(vector(["11/120", "27/40", "-8/15", "27/40", "11/120"]), omega, gamma, z)


def s4() -> GLM:
    """A symmetric method of order 4 with the V and G of (3.8) and no growth; not in the thesis."""
    return GLM(
        A=[
            ["0", "0", "0", "0"],
            ["-1/12", "1/4", "0", "0"],
            ["-1/12", "2/3", "1/4", "0"],
            ["0", "1/2", "1/2", "0"],
        ],
        U=[
            ["1", "-sqrt(3)/4", "1/4"],
            ["1", "(sqrt(5)-sqrt(3))/24", "(1+sqrt(15))/24"],
            ["1", "-(sqrt(5)+sqrt(3))/24", "(1-sqrt(15))/24"],
            ["1", "-sqrt(3)/4", "1/4"],
        ],
        B=[
            ["-1/10", "3/5", "3/5", "-1/10"],
            ["0", "sqrt(5)/5", "-sqrt(5)/5", "0"],
            ["-1/5", "1/5", "1/5", "-1/5"],
        ],
        V=[["1", "0", "0"], ["0", "-1/2", "-sqrt(3)/2"], ["0", "sqrt(3)/2", "-1/2"]],
        G=[["1", "0", "0"], ["0", "-1/4", "0"], ["0", "0", "-1/4"]],
        D=["-1/10", "3/5", "3/5", "-1/10"],
    )
