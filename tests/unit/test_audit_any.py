"""``glmref audit`` with no format: tables in eleven languages, and traps that are no tables."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from glmref.audit.lexer import ENDINGS, LANGUAGES, language_of
from glmref.audit.readers import read
from glmref.audit.recognising import size, tables
from glmref.audit.sources import audit
from glmref.audit.table import Table
from glmref.audit.table_verdicts import judge
from glmref.cli import main
from tests.build import source


def _one(text: str, language: str) -> Table:
    (table,) = tables(text, LANGUAGES[language])
    return table


CLASSES = """
# Runge-Kutta methods
class Heun3(Solver):
    order = 3
    A = np.array([[0, 0, 0], [1 / 3, 0, 0], [0, 2 / 3, 0]])
    b = np.array([1 / 4, 0, 3 / 4])
    c = np.array([0, 1 / 3, 2 / 3])
"""


def test_the_order_of_a_class_is_that_of_its_table() -> None:
    record = judge(_one(CLASSES, "python"))
    assert (record["declared"], record["found"], record["status"]) == (3, 3, "right")


def test_a_wrong_entry_is_named_with_its_line() -> None:
    """One row differs from its node, and one entry gives the declared order."""
    text = CLASSES.replace("[0, 2 / 3, 0]]", "[0, 2 / 5, 0]]")
    record = judge(_one(text, "python"))
    assert record["status"] == "wrong"
    (x,) = record["correction"]
    assert (x["entry"], x["line"], x["text"]) == ("a[3][2]", 5, "2 / 5")


def test_an_order_that_a_comment_gives_is_asked_about() -> None:
    text = CLASSES.replace("    order = 3\n", "    # a third-order method\n").replace(
        "3 / 4])", "4 / 5])"
    )
    record = judge(_one(text, "python"))
    assert record["declared"] == 3
    assert record["status"] == "question"


def test_nodes_that_are_exchanged_are_asked_about() -> None:
    text = CLASSES.replace("    order = 3\n", "").replace("[0, 1 / 3, 2 / 3]", "[0, 2 / 3, 1 / 3]")
    record = judge(_one(text, "python"))
    assert record["status"] == "question" and "c[2] and c[3] are exchanged" in record["remarks"]


def test_a_table_without_an_order_whose_row_is_wrong_is_a_question() -> None:
    text = CLASSES.replace("    order = 3\n", "").replace("[0, 2 / 3, 0]]", "[0, 2 / 5, 0]]")
    record = judge(_one(text, "python"))
    assert record["status"] == "question"
    assert record["correction"][0]["entry"] == "a[3][2]"


SCALARS = """
// Runge-Kutta of Bogacki and Shampine
class RK32 {
  int order() const { return 3; }
  static constexpr double a21 = 1.0/2, a31 = 0.0, a32 = 3.0/4,
    a41 = 2.0/9, a42 = 1.0/3, a43 = 4.0/9;
  static constexpr double b1 = a41, b2 = a42, b3 = a43, b4 = 0;
  static constexpr double c2 = 1.0/2, c3 = 3.0/4, c4 = 1.0;
  static constexpr double e1 = 5.0/72, e2 = -1.0/12, e3 = -1.0/9, e4 = 1.0/8;
};
"""


def test_names_with_numbers_are_the_entries() -> None:
    table = _one(SCALARS, "c")
    record = judge(table)
    assert (record["declared"], record["found"], record["status"]) == (3, 3, "right")
    assert len(table.errors) == 1


#: What must make a table unread: the text, its language, a part of the reason.
UNREAD = [
    (CLASSES.replace("2 / 3, 0]]", "magic(3), 0]]"), "python", "magic"),
    (CLASSES + "    A[2, 1] = omega * h\n", "python", "A"),
    (SCALARS.replace("a32 = 3.0/4", "a32 = 3/4"), "c", "quotient of whole numbers"),
    (CLASSES.replace("c = np", "nodes = foo(b)\n    c = np") + "    A += 1\n", "python", "changed"),
    (CLASSES + "    for i in range(3):\n        b[i] = g(i)\n", "python", "run time"),
]


@pytest.mark.parametrize(("text", "language", "why"), UNREAD)
def test_what_is_not_folded_makes_a_table_unread(text: str, language: str, why: str) -> None:
    found = tables(text, LANGUAGES[language])
    assert [x for x in found if x.unread and why in x.unread], [x.unread for x in found]
    assert all(x.unread for x in found)


#: What is no table, though it has numbers, and words of the subject.
NOT_TABLES = [
    (
        (
            "// a Runge-Kutta solver\n"
            "double A[3][3] = {{2.5, 1.25, 0.5}, {1.25, 3.5, 0.75}, {0.5, 0.75, 4.25}};\n"
            "double x[3] = {1.5, 2.5, 3.25};"
        ),
        "c",
    ),
    (
        (
            "# integrator\nrotation = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]]\n"
            "weights = [0.2, 0.3, 0.5]\n"
        ),
        "python",
    ),
    (
        (
            "# ODE solver\n"
            "kernel = [[0.0625, 0.125, 0.0625], [0.125, 0.25, 0.125], [0.0625, 0.125, 0.0625]]\n"
        ),
        "python",
    ),
    ("x = 'Butcher'\n", "python"),
    (  # coefficients of the noise of a stochastic method
        (
            "# stochastic Runge-Kutta\n_coeffs_hh = GeneralCoeffs(a=(np.array([1.0]), "
            "np.array([1.0, 0.0])), b_sol=np.array([0.0, 1.2, -1.2]))\norder = 2\n"
        ),
        "python",
    ),
    (  # three lists of limits
        (
            "// ODE solver\ndouble a[3] = {-0.5, 0, -1}, b[3] = {0, 1, -0.5};\n"
            "double c[3] = {1.5, 0.25, 2};"
        ),
        "c",
    ),
    ("// a solver: arrays that kick\nint a[2] = {0, 1}; long b[2] = {1, 0};", "c"),
    ("// a solver: the truth\ndouble a[2] = {0.5, 0.5}, b[2] = {1, 0};", "c"),
    ("class AdamsTest { double[] absolute = { 1.0e-5, 1.0e-7 }; }", "java"),
    (  # 1, -1, 1 sums to 1, and "decomposition" is no composition
        "// symplectic eigenvectors\nclass Decomposition { double[] v = {1.0, -1.0, 0.0}; }",
        "java",
    ),
    ("// symplectic\nstruct Lmm { int steps = 3; double alpha[3] = {1.0, -1.0, 0.0}; };", "c"),
    ("# Adams method\nadams = [limit, 0.25, 0.5]\n", "python"),  # one of no known value
]


@pytest.mark.parametrize(("text", "language"), NOT_TABLES)
def test_other_matrices_are_no_tables(text: str, language: str) -> None:
    assert tables(text, LANGUAGES[language]) == []


#: A method whose weights have a sum of squares of 1/2, as if b b were order 2, and a dense output.
DENSE = """
order = 2  # Runge-Kutta
a = [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
b = [2 / 3, 1 / 6, 1 / 6]
c = [0, 1, 2]
bi = [[1, -1 / 3], [0, 1 / 6], [0, 1 / 6]]
"""
#: The matrices a and b of an implicit and an explicit part, and nodes c, whose last is to fill in.
PAIR = """
class IMEXRK222:
    def stages(self):
        g = (2 - 2**0.5) / 2
        d = 1 - 1 / (2 * g)
        a = [[0, 0, 0], [0, g, 0], [0, 1 - g, g]]
        b = [[0, 0, 0], [g, 0, 0], [d, 1 - d, 0]]
        c = (0, g, {})
"""
#: Kutta's method under names, with an abscissa to fill in.
NODES = (
    "// Runge-Kutta\nconst int order = 4;\ndouble a21 = 1.0/3.0, a31 = -1.0/3.0, a32 = 1.0, "
    "a41 = 1.0, a42 = -1.0, a43 = 1.0, b1 = 0.125, b2 = 0.375, b3 = 0.375, b4 = 0.125, "
    "c2 = {}, c4 = 1.0, c5 = 0.5;"
)
#: Stages and outputs of a method of two values; its order is that of the first value alone.
GENERAL = (
    "// general linear methods beside Runge-Kutta, order 2\nvoid f() {{ double c[2] = {{0.3, 1}}, "
    "a[2][2] = {{{{0.3, 0}}, {{0.7, 0.3}}}}, b[2][2] = {{{{0.7, 0.3}}, {{0, 1}}}}; {} }}"
)
#: Low-storage coefficients in five digits; their order is 2 but for rounding (Bernardini 2009).
ROUNDED = (
    "# low-storage Runge-Kutta\nfunction ORK()\n    order = 2\n"
    "    A2 = -1.0; A3 = -1.55798; A4 = -1.0; A5 = -0.45031\n"
    "    B1 = 0.2; B2 = 0.83204; B3 = {}; B4 = 0.35394; B5 = 0.2\nend\n"
)
#: Weights of the cases of a choice, under the name of the function.
CASES = (
    "std::vector<double> Chain::suzukiWeights(int n) {{ switch (n) {{ case 3: return {{{0}, {1}, "
    "{0}}}; default: return {{0.2967324292201065, 0.2967324292201065, -0.186929716880426, "
    "0.2967324292201065, 0.2967324292201065}}; }} }}"
)
#: Steps with their numbers in them.
INLINE = (
    "# Runge-Kutta\ndef step(f, y, h):\n    k1 = f(y)\n    k2 = f(y + h / 2 * k1)\n"
    "    k3 = f(y + h / 2 * k2)\n    k4 = f(y + h * k3)\n    return y + {} * ({})\n"
)
OUTPUTS = (
    "void step() {{ rhs(t, y, k1); for (i = 0; i < n; i++) z[i] = y[i] + 2*h/3*k1[i];\n"
    "rhs(t + 2*h/3, z, k2); for (i = 0; i < n; i++) y[i] += h*{}; }}"
)
#: A class for each row, whose entries its constructor sets.
ROW_BY_ROW = (
    "// Runge-Kutta\n"
    "struct rk4_a1 {{ rk4_a1() {{ (*this)[0] = 1. / 2; }} }};\n"
    "struct rk4_a2 {{ rk4_a2() {{ (*this)[0] = 0.; (*this)[1] = 1. / {}; }} }};\n"
    "struct rk4_a3 {{ rk4_a3() {{ (*this)[0] = 0.; (*this)[1] = 0.; (*this)[2] = 1.; }} }};\n"
    "struct rk4_b {{ rk4_b() {{ (*this)[0] = 1. / 6; (*this)[1] = 1. / 3; (*this)[2] = 1. / 3; "
    "(*this)[3] = 1. / 6; }} }};\n"
    "struct rk4_c {{ rk4_c() {{ (*this)[0] = 0.; (*this)[1] = 0.5; (*this)[2] = 0.5; "
    "(*this)[3] = 1.; }} }};\n"
)
#: Names that are used again after other arrays, methods that calls name, and copies.
AGAIN = (
    "# Runge-Kutta\ndef load():\n    b = [1.]\n    one = 1\n"
    "    A = [[0, 0], [{} * one, 0]]\n    b = [1 / 2, 1 / 2]\n    RK['RK2'] = RKMethod(A=A, b=b)\n"
    "    A = np.zeros((3, 3))\n    b = np.zeros(3)\n    A[1, 0] = 1\n    A[2, 0] = 1 / 4\n"
    "    A[2, 1] = 1 / 4\n    b[0] = 1 / 6\n    b[1] = 1 / 6\n    b[2] = 2 / 3\n"
    "    RK['SSP33'] = RKMethod(A.astype('float64'), b.astype('float64'))\n"
    "    A = [[0, 0, 0, 0], [1 / 2, 0, 0, 0], [0, 1 / 2, 0, 0], [0, 0, 1, 0]]\n"
    "    b = [1 / 6, {} / 6, 1 / 3, 1 / 6]\n    RK['RK4'] = RKMethod(A, b)\n"
)
DIAGONAL = (
    "// diagonally implicit Runge-Kutta\nconst int order = 2; double gamma = 0.25, a11 = 0.25, "
    "a21 = 0.5, a22 = 0.25, a31 = 0.25, a32 = 0.25, {} = 0.25, b1 = 0.5, b2 = 0.25, b3 = 0.25, "
    "c1 = 0.25, c2 = 0.75, c3 = 0.75;"
)
ESTIMATE = (
    "# Runge-Kutta\nclass Pair:\n    order = 2\n    A = [[0, 0, 0], [1.0, 0, 0], [0.25, 0.5, 0]]\n"
    "    bhat = [{}, 0]\n    c = [0, 1.0, 0.75]\n"
)
ROSENBROCK = (
    "// Rosenbrock\nconst int order = 2; double gamma = 0.25, a21 = 4.0, c2 = 1.0, c21 = -8.0, "
    "b1 = {}.0, b2 = 2.0;"
)
GAUSS = (
    "! Runge-Kutta\nsubroutine gauss\ninteger, parameter :: order = 4\n"
    "real :: gam(0:2), a(2,2), b(2), c(2)\ngam(0) = 0.5\ngam(1) = 0.25\n"
    "a(1,1) = 1.0/4\na(1,2) = 1.0/4 - sqrt(3.0)/6\na(2,1) = 1.0/4 + sqrt(3.0)/6\na(2,2) = 1.0/4\n"
    "b(1) = 0.5\nb(2) = 0.5\nc(1) = 1.0/2 - sqrt(3.0)*{0}.0\nc(2) = 1.0/2 + sqrt(3.0)/6\n"
    "end subroutine\n"
)
#: Heun's method of order 3 in three forms of Go, and in C with comments, without an order.
GO_NAMES = (
    "// Runge-Kutta\nconst (\n\torder = 3\n\ta21 = 1.0 / 3\n\ta31 = 0\n\ta32 = {}\n\tb1 = 0.25\n"
    "\tb2 = 0\n\tb3 = 0.75\n\tc2 = 1.0 / 3\n\tc3 = 2.0 / 3\n)\n"
)
GO_PAIRS = (
    "// Runge-Kutta\nconst order = 3\nconst c20, c21 = 1. / 3., 1. / 3.\n"
    "const c30, c31, c32 = 2. / 3., 0., 2. / 3.\nconst b1, b2, b3 = 0.25, 0., {}\n"
)
GO_PLACES = (
    "// Runge-Kutta\nconst order = 3\nvar a = [3][2]float64{{1: {{0: 1. / 3.}}, {{1: {}}}}}\n"
    "var b, c = [3]float64{{0.25, 2: 0.75}}, [3]float64{{0, 1. / 3., 2. / 3.}}\n"
)
HEUN = (
    "// {}\ndouble a[3][3] = {{{{0}}, {{1./3}}, {{0, {}}}}}, b[3] = {{0.25, 0, 0.75}}, "
    "c[3] = {{0, 1./3, {}}};"
)
#: Half of the weights of a composition (Suzuki 1990), and the number of all.
HALF = (
    "// symplectic\nstatic struct scheme s = {{ .order = 4, .gamma = {{ {}, "
    "0.41449077179437573714, -0.65796308717750294857, 0, 0 }}, .stages = {} }};"
)
#: Kutta's 3/8 rule; a last row, or weights, with an entry to fill in.
CLOSING = (
    "// Runge-Kutta\nconst int order = 4; double a21 = 1.0/3, a31 = {}, a32 = 1, a41 = 1, a42 = -1, "
    "a43 = 1, a51 = 0.125, a52 = 0.375, a53 = {}, a54 = 0.125, c2 = 1.0/3, c3 = 2.0/3, c4 = 1.0, "
    "e1 = 0, e2 = 1.0/24, e3 = {}, e4 = 1.0/24, e5 = 0;"
)
TWICE = (
    "// Runge-Kutta\nconst ORDER: usize = 4; const RK_A: [[f64; 4]; 5] = [[0., 0., 0., 0.], "
    "[0.5, 0., 0., 0.], [0., 0.5, 0., 0.], [0., 0., 1., 0.], [1. / 6., 1. / 3., 1. / 3., 1. / 6.]];\n"
    "const RK_B: [f64; 5] = [1. / 6., 1. / 3., {}, 1. / 6., 0.];\n"
    "const RK_C: [f64; 5] = [0., 0.5, 0.5, 1., 1.];\n"
)
#: Nodes of two arrays whose names differ in a bar, or one that is set twice.
BARRED = (
    "// Runge-Kutta\nconst int order = 3; double a21 = 1.0/3, a31 = 0.0, a32 = 2.0/3, b1 = 0.25, "
    "b2 = 0.0, b3 = 0.75, c2 = 1.0/3, c3 = 2.0/3, {}2 = 0.5, {}3 = 0.5;"
)
#: Two stages by rows with their diagonal, which are not three without.
PACKED = (
    "struct Euler {{ int order = 2; double a[3] = {{0, {}, 0}}, b[2] = {{0.5, 0.5}}, "
    "c[2] = {{0, 1}}; }}; // Runge-Kutta"
)
#: Weights of five stages, of which the last are 0 and not written, beside nodes under any name.
FEWER = (
    "// Runge-Kutta\nint order = 3; double a[5][5] = {{{{0}}, {{1./3}}, {{0, {}}}, {{0.5, 0.5}}, "
    "{{0, 0, 0, 1}}}}, b[5] = {{0.25, 0, 0.75}}, t[5] = {{0, 1./3, 2./3, 1, 1}};"
)
#: Two methods under one name of a variable; their own names say stages and order, SSP33 and RK21.
NAMED = (
    "# Runge-Kutta\nA = [[0, 0, 0], [1, 0, 0], [1 / 4, 1 / 4, 0]]\nb = [1 / 6, {}, 2 / 3]\n"
    "RK['SSP33'] = Method(A, b)\nA = [[0, 0, 0], [1 / 3, 0, 0], [0, 2 / 3, 0]]\n"
    "b = [1 / 4, 0, 3 / 4]\nRK[f(3)] = Method(A, b)\nA = [[0, 0], [1, 0]]\nb = [1 / 2, 1 / 2]\n"
    "RK['other'] = Method(A, b)\n"
)
#: What was accused though it is right, or not read, with its language and its status.
READ = [
    (  # weights that a function returns, and not the last row of A
        (
            "# Runge-Kutta\norder = 4\nA = [[0, 0, 0], [0.25, 0.25, 0], [0, 1, 0]]\n"
            "t = Tableau('A3', 4, A, weights(3))"
        ),
        "python",
        "unread unread",
    ),
    (  # a matrix by columns, as in code that was translated from Fortran
        (
            "// Runge-Kutta\nvoid f() { rkA[0][0] = 0.25; rkA[0][1] = 0.5; rkA[1][1] = 0.25;"
            "rkB[0] = 0.5; rkB[1] = 0.5; rkC[0] = 0.25; rkC[1] = 0.75; }"
        ),
        "c",
        "found",
    ),
    (  # a diagonal with one name
        (
            "# sdirk\norder = 2\ngamma = 0.25\na21 = 0.5\na31 = 0.25\na32 = 0.25\n"
            "b1 = 0.25\nb2 = 0.25\nb3 = 0.5\nc1 = 0.25\nc2 = 0.75\nc3 = 0.75\n"
        ),
        "python",
        "unread",
    ),
    (  # the explicit part of an implicit method is zero
        (
            "# imex\ndef f():\n    Ai = zeros(3, 3)\n    Ai[1, 0] = 0.5\n    Ai[1, 1] = 0.5\n"
            "    Ai[2, 0] = 0.25\n    Ai[2, 2] = 0.75\n    Ae = zeros(3, 3)\n"
            "    bi = [0.25, 0, 0.75]\n    be = [0.0, 0, 0]\n    c = [0, 1, 1]\n"
            "    return IMEXTableau(Ai, bi, Ae, be, c)\n"
        ),
        "python",
        "found",
    ),
    (  # two methods with the same entries
        (
            "/* Runge-Kutta */\n"
            "void one() { double a[2][2] = {{0, 0}, {0.5, 0}}, b[2] = {0, 1}; }\n"
            "void two() { double a[2][2] = {{0, 0}, {0.5, 0}}, b[2] = {0, 1}; }"
        ),
        "c",
        "found found",
    ),
    ("# Runge-Kutta\nclass Mid:\n    order = 2\n    A = [0.5]\n    b = [1]\n", "python", "right"),
    (
        (
            "class EulerIntegrator { double[] getC() { return new double[0]; } double[][] getA() "
            "{ return new double[0][]; } double[] getB() { return new double[] { 1 }; } }"
        ),
        "java",
        "found",
    ),
    (  # two parts without weights: the last row of the implicit one
        (
            "/* imex */\nvoid f() { double A[3][3] = {{0, 0, 0}, {0.5, 0, 0}, {0.5, 0.5, 0}},\n"
            "At[3][3] = {{0, 0, 0}, {0.25, 0.25, 0}, {1./3, 1./3, 1./3}}; }"
        ),
        "c",
        "found",
    ),
    (NODES.format("1.0/3.0"), "c", "right"),  # c3 has no name, and c5 is one of a dense output
    (NODES.format("1.0/4.0"), "c", "wrong"),
    (
        GENERAL.format("double u[2][2] = {{1, 0}, {1, 0}}, v[2][2] = {{1, 0}, {0, 0}};"),
        "c",
        "unread",
    ),
    (GENERAL.format(""), "c", "question"),
    (ROUNDED.format("0.6"), "julia", "digits"),
    (ROUNDED.format("0.61"), "julia", "wrong"),
    (DIAGONAL.format("a33"), "c", "right"),
    (DIAGONAL.format("x33"), "c", "unread"),  # `gamma` may be the entry without a name
    (ESTIMATE.format("0.5, 0.5"), "python", "right"),
    (ESTIMATE.format("0.6, 0.4"), "python", "unread"),  # no row is called weights
    (ROSENBROCK.format(6), "c", "right"),  # c21 is an entry of C, c2 an abscissa
    (ROSENBROCK.format(5), "c", "wrong"),
    (GAUSS.format("1/6"), "fortran", "right"),  # one array begins at 0, the others at 1
    (GAUSS.format("1/7"), "fortran", "wrong"),
    (NAMED.format("1 / 6"), "python", "right found found"),
    (NAMED.format("1 / 8"), "python", "question found found"),
    (  # two rows, of which one is not its node: nothing says which method is meant
        "# Runge-Kutta\nA = [[], [1], [0.5, 0.5]]\nb = [1 / 3, 1 / 3, 1 / 3]\nc = [0, 0.5, 1]\n",
        "python",
        "found",
    ),
    (CLOSING.format("-1.0/3", "0.375", "-1.0/12"), "c", "right"),
    (CLOSING.format("1.0/3", "0.375", "-1.0/12"), "c", "question"),  # a31
    (CLOSING.format("-1.0/3", "0.375", "1.0/12"), "c", "question"),  # the estimate
    (CLOSING.format("-1.0/3", "0.735", "-1.0/12"), "c", "unread"),  # nothing says weights
    (TWICE.format("1. / 3."), "rust", "right"),
    (TWICE.format("1. / 4."), "rust", "wrong"),  # and the last row of A is not what is used
    (BARRED.format("c_", "c_"), "c", "right"),
    (BARRED.format("c", "c"), "c", "unread"),
    (HALF.format("0.41449077179437573714", 5), "c", "right"),
    (HALF.format("0.41449077179437573714", 4), "c", "right"),  # sum and cubes say it, too
    (HALF.format("0.41449977179437573714", 5), "c", "wrong"),
    (HALF.format("0.44149077179437573714", 4), "c", "unread"),  # neither the sum nor the cubes
    (GO_NAMES.format("2.0 / 3"), "go", "right"),
    (GO_NAMES.format("2.0 / 5"), "go", "wrong"),
    (GO_PAIRS.format("0.75"), "go", "right"),
    (GO_PAIRS.format("0.57"), "go", "wrong"),
    (GO_PLACES.format("2. / 3."), "go", "right"),
    (GO_PLACES.format("1. / 3."), "go", "wrong"),
    (PACKED.format("1"), "c", "right"),
    (PACKED.format("0.5"), "c", "wrong"),
    (FEWER.format("2./3"), "c", "right"),
    (FEWER.format("1./3"), "c", "wrong"),
    (HEUN.format("Heun, order 3(2), dense output of order 2", "2./3", "2./3"), "c", "right"),
    (HEUN.format("Heun, order 3(2), dense output of order 2", "2./5", "2./3"), "c", "question"),
    (HEUN.format("Runge-Kutta", "2./3", "2./3"), "c", "found"),
    (HEUN.format("Runge-Kutta", "2./3", "0"), "c", "question"),  # the sum of the row gives order 3
    (CASES.format("0.828981543588751", "-0.657963087177502"), "c", "question question"),
    (CASES.format("1.3512071919596578", "-1.7024143839193156"), "c", "found question"),
    (ROW_BY_ROW.format("2"), "c", "found"),
    (ROW_BY_ROW.format("3"), "c", "question"),
    (AGAIN.format("1", "2"), "python", "right right right"),
    (AGAIN.format("1", "3"), "python", "right right question"),
    (INLINE.format("h / 6", "k1 + 2 * k2 + 2 * k3 + k4"), "python", "found"),
    (INLINE.format("h", "b[0] * k1 + b[1] * k2"), "python", "unread"),
    (INLINE.format("h / 6", "u[0] + 2 * u[1] + 2 * u[2]"), "python", "unread"),
    (INLINE.format("h / 6", "k1"), "python", "unread"),
    ("call f(t, x, f1)\ncall f(t + h, x + h*f1, f2)\nx = x + h*(f1 + f2)/2", "fortran", "found"),
    (OUTPUTS.format("(k1[i] + 3*k2[i])/4"), "c", "found"),
    (OUTPUTS.format("k2[i]"), "c", "found"),
    (DENSE, "python", "right"),
    (  # the rows of a sum to the weights, too, and it is the matrix
        (
            "order = 2  # Runge-Kutta\n"
            "a = [[2 / 3, 0, 0], [0, 1 / 6, 0], [0, 0, 1 / 6]]\nb = [2 / 3, 1 / 6, 1 / 6]\n"
        ),
        "python",
        "right",
    ),
    (PAIR.format("1"), "python", "found found"),
    (PAIR.format("1 / 2"), "python", ""),  # c is neither the nodes of b nor weights
    (  # alpha and beta of Shu and Osher under names of a tableau
        (
            "# This is the second-order, strong-stability-preserving Runge-Kutta scheme.\n"
            "RKA = [1.0 0.0; 1 // 2 1 // 2]\nRKB = [1.0, 1 // 2]\nRKC = [0.0, 1.0]\n"
        ),
        "julia",
        "unread",
    ),
    (  # the weights do not sum to 1, and nothing declares an order
        "// symplectic\ndouble a[2] = {0.5, 0.5}, b[2] = {0.25, 0.5};",
        "c",
        "unread",
    ),
]


@pytest.mark.parametrize(("text", "language", "states"), READ)
def test_what_was_accused_or_missed_is_read(text: str, language: str, states: str) -> None:
    found = [judge(x)["status"] for x in tables(text, LANGUAGES[language], about=True)]
    assert found == states.split()


def test_the_parameters_of_a_template_are_not_its_name() -> None:
    text = "template <class T, int N = 2>\nstruct Heun { T A[2][2] = {{0, 0}, {1, 0}}, b[2] = {0.5, 0.5}; };"
    assert [x.name for x in tables(text, LANGUAGES["c"], about=True)] == ["Heun"]


def test_tables_of_an_explicit_and_an_implicit_part_are_one_method() -> None:
    text = (
        "# Runge-Kutta\nmy_explicit_t = Table(A=[[0, 0], [{}, 0]], b=[1 / 2, 1 / 2], c=[0, 1])\n"
        "my_implicit_t = Table(A=[[0, 0], [1 / 2, 1 / 2]], b=[1 / 2, 1 / 2], c=[0, 1])\n"
    )
    for entry, order in (("1", 2), ("1 / 2", 1)):
        found = {x.name: x for x in tables(text.format(entry), LANGUAGES["python"])}
        assert judge(found["my_explicit_t with my_implicit_t"])["found"] == order


@pytest.mark.parametrize(("entry", "order"), [("1 / 2", 2), ("1 / 3", 1)])
def test_an_additive_method_is_read_by_its_four_rows(entry: str, order: int) -> None:
    """IMKG232a of Steyer et al. (2019), and one entry changed."""
    text = (
        "# IMEX Runge-Kutta\nfunction IMEXTableau(::Own)\n    IMKGTableau((1 / 2, {}, 1), "
        "(0, -1 / 2 + √2 / 2, 1), (1 - √2 / 2, 1 - √2 / 2))\nend\n"
    )
    table = _one(text.format(entry), "julia")
    assert (table.name, table.kind, judge(table)["found"]) == ("Own", "additive", order)


def test_two_stages_of_whole_numbers_are_a_method_in_a_call_that_says_so() -> None:
    text = "# Runge-Kutta\nx = {}(; a_exp = [0 0; 1 0], a_imp = [0 0; 0 1])\n"
    assert [x.kind for x in tables(text.format("IMEXTableau"), LANGUAGES["julia"])] == ["additive"]
    assert tables(text.format("Matrices"), LANGUAGES["julia"]) == []


def test_a_name_that_is_used_again_begins_another_table() -> None:
    text = """
    # Runge-Kutta methods
    A = [[0, 0, 0], [1 / 2, 0, 0], [-1, 2, 0]]
    b = [1 / 6, 2 / 3, 1 / 6]
    A = [[0, 0, 0], [1 / 3, 0, 0], [0, 2 / 3, 0]]
    b = [1 / 4, 0, 3 / 4]
    """
    found = tables(text, LANGUAGES["python"])
    assert [judge(x)["found"] for x in found] == [3, 3]


def test_every_ending_has_a_language() -> None:
    assert set(ENDINGS.values()) == set(LANGUAGES)
    assert language_of(Path("a.unknown")) is None


def test_the_command_needs_no_format(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Several paths, one with a wrong table; without any table nothing is green."""
    right, wrong = tmp_path / "right.py", tmp_path / "wrong.py"
    right.write_text(CLASSES, "utf-8")
    wrong.write_text(CLASSES.replace("[0, 2 / 3, 0]]", "[0, 2 / 5, 0]]"), "utf-8")
    assert main(["audit", str(right), "--all"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "right"
    assert main(["audit", str(right), str(wrong)]) == 1
    (record,) = map(json.loads, capsys.readouterr().out.splitlines())
    assert (record["path"], record["name"]) == ("wrong.py", "Heun3")
    other = tmp_path / "other"
    other.mkdir()
    (other / "nothing.py").write_text("x = 1\n", "utf-8")
    assert main(["audit", str(other)]) == 2
    assert list(audit(other)) == []


#: Samples of the formats, with their language and the tables that both readers see.
SAMPLES = [
    (source("petsc.c"), "petsc", "c", 1),
    (source("julia.jl"), "julia", "julia", 3),
    (source("named-b.cpp"), "constants", "c", 1),
    (source("matlode.m"), "matlode", "matlab", 1),
]


@pytest.mark.parametrize(("text", "form", "language", "count"), SAMPLES)
def test_both_readers_see_the_same_numbers(text: str, form: str, language: str, count: int) -> None:
    """The reader of a format and the one of all sources, where both read a table."""

    def numbers(found: Any) -> set[tuple[float, ...]]:
        kinds = ("rk", "additive")
        return {
            tuple(float(f"{size(x):.9g}") for row in (*A, b) for x in row)
            for table in found
            if table.kind in kinds
            for A, b in zip(table.A, table.b, strict=True)
        }

    remark = {"python": "#", "julia": "#", "matlab": "%"}.get(language, "//")
    general = tables(f"{remark} Runge-Kutta\n{text}", LANGUAGES[language])
    assert len(numbers(read(text, form, {})) & numbers(general)) >= count


_RK3 = '"A": [[0, 0, 0], [1/2, 0, 0], [-1, 2, 0]], "order": 3, "b": [1/6, 2/3,'


@pytest.mark.parametrize(
    ("name", "text", "states"),
    [
        ("own.c", "double A[2][2] = {{0, 0}, {0.5, 0}}, b[2] = {0, 1}, c[2] = {0, 0.5};", ["found"]),
        ("own.jl", "A = [0 0 0; 1//2 0 0; -1 2 0]\nb = [1//6, 2//3, 1//6]", ["found"]),
        ("own.jl", "A = [0 0 0; 1//2 0 0; -1 2 0]\nb = [1//6, 2//3, 1//3]", ["wrong"]),
        ("own.py", f"RK3 = {{{_RK3} 1/6]}}\nBAD = {{{_RK3} 1/3]}}", ["right", "wrong"]),
    ],
)  # fmt: skip
def test_a_file_that_is_given_needs_no_word_of_the_subject(tmp_path, name, text, states):
    """A file of two arrays was no table, and weights with another sum were passed over."""
    (tmp_path / name).write_text(text)
    assert [x["status"] for x in audit(tmp_path / name)] == states
    (tmp_path / "A.jl").write_text(
        "A = [0 1//2; 1//3 1//7]\nb = [1//6, 2//3]"
    )  # of another subject
    assert [x["path"] for x in audit(tmp_path) if x["path"] == "A.jl"] == []


def test_a_folder_with_one_file_needs_no_word_of_the_subject(tmp_path: Path) -> None:
    """The names A, b and c and sums of rows that are c say what no word says."""
    text = (
        "A = [[0, 0, 0, 0], [1/2, 0, 0, 0], [0, 3/4, 0, 0], [2/9, 1/3, 4/7, 0]]\n"
        "b = [2/9, 1/3, 4/9, 0]\nc = [0, 1/2, 3/4, 1]\norder = 3\n"
    )
    (tmp_path / "bs.py").write_text(text)
    (record,) = audit(tmp_path)
    assert record["status"] in ("wrong", "question")
    assert record["remarks"][0].startswith("c[4] differs from the sum of row 4 of A")


def test_a_position_and_a_momentum_are_no_orders(tmp_path: Path) -> None:
    """An object with `q` and `p` that are no whole numbers ended the audit of a checkout."""
    (tmp_path / "s.py").write_text("# Runge-Kutta\nstate = State(q=0.5, p=1.5)\n")
    assert list(audit(tmp_path)) == []


def test_kicks_of_a_splitting_are_no_composition(tmp_path: Path) -> None:
    """They sum to 1 and read the same backwards, and were asked for the sum of their cubes."""
    (tmp_path / "m.hpp").write_text(
        "struct Strang2 : SymplecticPartitionedRungeKutta {\n  static constexpr int order = 2;\n"
        "  static constexpr Kind kind = SUZUKI_1990;\n"
        "  static constexpr FixedVector<double, 3> a{{{0.5, 0.5, 0.0}}};\n"
        "  static constexpr FixedVector<double, 3> b{{{0.25, 0.5, 0.25}}};\n};\n"
    )
    assert {x["status"] for x in audit(tmp_path)} == {"right"}


def test_the_number_of_the_weights_of_a_composition_is_not_their_order() -> None:
    """The order of a palindrome is even; codes call the length of the list an order."""
    text = (
        "// Suzuki-Yoshida\nconst int suzukiOrder = {0};\n"
        "double suzukiWeights[5] = {{0.3, 0.3, -0.2, 0.3, 0.3}};"
    )
    five, four = (judge(_one(text.format(n), "c")) for n in (5, 4))
    assert (five["declared"], four["declared"]) == (None, 4)
    assert "the sum of the cubes of the weights is 0.1" in five["remarks"][0]


HEUN_AND_KUTTA = """/* Runge-Kutta */
static const double heun_A[2][2] = {{0,0},{1,0}}; static const double heun_b[2] = {.5,.5};
static const int %s = %s;
void kutta(void) {
  const double b[3] = {1./6,2./3,1./6}; const double A[3][3] = {{0,0,0},{.5,0,0},{0,1,0}};
  register_rk("kutta3", 3, 3, A, b);
}
"""


ADJOINT = """# Runge-Kutta
KUTTA = Tableau(c=[0, .5, 1], A=[[0, 0, 0], [.5, 0, 0], [-1, 2, 0]], b=[1/6, 2/3, 1/6])
BACK = Tableau(c=[1, .5, 0], A=[[0, 0, 0], [.5, 0, 0], [2, -1, 0]], b=[1/6, 2/3, 1/6])
class Solver:
    order = 3
    tableau = KUTTA
    adjoint = BACK
"""


def test_the_order_of_a_class_is_that_of_the_first_table_it_names() -> None:
    assert [x.order for x in tables(ADJOINT, LANGUAGES["python"])] == [3, None]


def test_nodes_from_1_to_0_are_not_those_of_a_step() -> None:
    text = ADJOINT.replace("KUTTA", "BACK2").replace("c=[0, .5, 1]", "c=[1, .5, 0]")
    first = judge(tables(text, LANGUAGES["python"])[0])
    assert (first["declared"], first["status"]) == (3, "unread")


@pytest.mark.parametrize(
    ("name", "order", "declared"),
    [
        ("heun_order", 2, None),
        ("DEFAULT_ORDER", 4, None),
        ("method_order", 3, 3),
        ("kutta_order", 3, 3),
    ],
)
def test_the_order_of_one_table_of_a_file_is_not_that_of_another(
    name: str, order: int, declared: int | None
) -> None:
    found = tables(HEUN_AND_KUTTA % (name, order), LANGUAGES["c"])
    (kutta,) = (x for x in found if x.name == "kutta3")
    assert kutta.order == declared
