"""Sources that no reader was written for: the right twin is accused of nothing, the wrong one is.

Each defect is one of those that a code can have: a digit, two entries exchanged, a row of another
method, the weights of an error estimate in place of embedded ones.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from glmref.audit.sources import audit


class Case(NamedTuple):
    """A file, what makes it wrong, and the entry, or the words, that must be said."""

    path: str
    text: str
    right: str
    wrong: str
    said: str
    more: tuple[tuple[str, str], ...] = ()


ZONNEVELD = """/* embedded Runge-Kutta pair, order 4(3) */
#include "ode.h"
typedef struct { int stages, order; double a[10]; double w[5]; double t[5]; double low[5]; } tab_t;
static const tab_t zonneveld = {
  .stages = 5, .order = 4,
  .a = { 0.5,
         0.0, 0.5,
         0.0, 0.0, 1.0,
         5./32, 7./32, 13./32, -1./32 },
  .w = { 1./6, 1./3, 1./3, 1./6, 0.0 },
  .t = { 0.0, 0.5, 0.5, 1.0, 0.75 },
  .low = { -0.5, 7./3, 7./3, 13./6, -16./3 },
};
"""
FEHLBERG = """! Runge-Kutta-Fehlberg, order = 4
module coefs
  implicit none
  integer, parameter :: order = 4
  real(8), dimension(5,5) :: a
  real(8), parameter :: b(5) = (/ 25.d0/216.d0, 0.d0, 1408.d0/2565.d0, 2197.d0/4104.d0, &
                                  -1.d0/5.d0 /)
  real(8), parameter :: c(5) = (/ 0.d0, 0.25d0, 0.375d0, 12.d0/13.d0, 1.d0 /)
  data a(2,1) / 0.25d0 /
  data a(3,1), a(3,2) / 0.09375d0, 0.28125d0 /
  data a(4,1), a(4,2), a(4,3) / 0.87938097405553026d0, -3.2771961766044606d0, 3.3208921256258535d0 /
  data a(5,1), a(5,2), a(5,3), a(5,4) / 2.0324074074074074d0, -8.d0, 7.1734892787524366d0, &
       -0.20589668615984405d0 /
end module
"""
RALSTON = """using StaticArrays
# Runge-Kutta coefficients
struct Method{N, T}
    A::SMatrix{N, N, T}
    b::SVector{N, T}
    c::SVector{N, T}
    order::Int
end
const KUTTA38 = Method(
    SMatrix{4, 4}([0 0 0 0; 1//3 0 0 0; -1//3 1 0 0; 1 -1 1 0]),
    SVector(1//8, 3//8, 3//8, 1//8),
    SVector(0, 1//3, 2//3, 1), 4)
"""
BUTCHER5 = '''from fractions import Fraction as F


class Butcher5:
    """A fifth-order method."""

    order = 5
    stages = [
        [],
        [F(1, 4)],
        [F(1, 8), F(1, 8)],
        [0, F(-1, 2), 1],
        [F(3, 16), 0, 0, F(9, 16)],
        [F(-3, 7), F(2, 7), F(12, 7), F(-12, 7), F(8, 7)],
    ]
    weights = [F(7, 90), 0, F(32, 90), F(12, 90), F(32, 90), F(7, 90)]
    nodes = [0, F(1, 4), F(1, 4), F(1, 2), F(3, 4), 1]
'''
LOWSTORE = """//! Low-storage Runge-Kutta schemes of Carpenter and Kennedy.
/// Five stages, fourth order.
pub const ORDER: usize = 4;
pub const RK_A: [f64; 5] = [
    0.0,
    -567301805773.0 / 1357537059087.0,
    -2404267990393.0 / 2016746695238.0,
    -3550918686646.0 / 2091501179385.0,
    -1275806237668.0 / 842570457699.0,
];
pub const RK_B: [f64; 5] = [
    1432997174477.0 / 9575080441755.0,
    5161836677717.0 / 13612068292357.0,
    1720146321549.0 / 2090206949498.0,
    3134564353537.0 / 4481467310338.0,
    2277821191437.0 / 14882151754819.0,
];
"""
SSP = """package integrator;

/** Strong stability preserving Runge-Kutta method in the form of Shu and Osher. */
public final class Ssp33 {
  private static final int ORDER = 3;
  private static final double[][] ALPHA = {
    {1.0},
    {3.0 / 4, 1.0 / 4},
    {1.0 / 3, 0.0, 2.0 / 3},
  };
  private static final double[][] BETA = {
    {1.0},
    {0.0, 1.0 / 4},
    {0.0, 0.0, 2.0 / 3},
  };
}
"""
ADAMS = """// Package lmm has Adams-Bashforth methods.
package lmm

var adamsBashforth = [][]float64{
	{1},
	{3.0 / 2, -1.0 / 2},
	{23.0 / 12, -16.0 / 12, 5.0 / 12},
	{55.0 / 24, -59.0 / 24, 37.0 / 24, -9.0 / 24},
}
"""
FOREST = """// symplectic integrator of Forest and Ruth
const cbrt2 = 1.2599210498948732;
export const forestRuth = {
  order: 4,
  c: [0.6756035959798289, -0.17560359597982889, -0.17560359597982889, 0.6756035959798289],
  d: [1.3512071919596578, -1.7024143839193155, 1.3512071919596578],
};
"""
RODAS = """% Rosenbrock method with 3 stages
function [A, Gamma, b, order] = ros3p()
  order = 3;
  g = 7.886751345948129e-01;
  A = [0 0 0
       1 0 0
       1 0 0];
  Gamma = [g 0 0
           -1 g 0
           -g 1/2-2*g g];
  b = [2/3 0 1/3];
end
"""
NYSTROM = """# Runge-Kutta-Nystrom methods for q'' = g(q)
class Nystrom5:
    order = 5
    A = np.array([[0, 0, 0, 0], [1 / 50, 0, 0, 0], [-1 / 27, 7 / 27, 0, 0],
                  [3 / 10, -2 / 35, 9 / 35, 0]])
    b = np.array([14 / 336, 100 / 336, 54 / 336, 0])
    bp = np.array([14 / 336, 125 / 336, 162 / 336, 35 / 336])
    c = np.array([0, 1 / 5, 2 / 3, 1])
"""
BOGACKI = """#pragma once
// Coefficients of the Runge-Kutta pair BS23.
template <typename Real>
struct BogackiShampine {
  static constexpr int order = 3;
  static constexpr int low_order = 2;
  static constexpr Real a21 = Real(1) / 2;
  static constexpr Real a31 = 0, a32 = Real(3) / 4;
  static constexpr Real a41 = Real(2) / 9, a42 = Real(1) / 3, a43 = Real(4) / 9;
  static constexpr Real b1 = a41, b2 = a42, b3 = a43, b4 = 0;
  static constexpr Real c1 = 0, c2 = Real(1) / 2, c3 = Real(3) / 4, c4 = 1;
  static constexpr Real bhat1 = Real(7) / 24, bhat2 = Real(1) / 4, bhat3 = Real(1) / 3,
                        bhat4 = Real(1) / 8;
};
"""
SUZUKI = """class YoshidaSix(Integrator):
    # sixth-order composition
    order = 6
    weights = [0.784513610477560, 0.235573213359357, -1.17767998417887, 1.315186320683906,
               -1.17767998417887, 0.235573213359357, 0.784513610477560]
"""
ELSEWHERE = """#include "tableaux.hh"
static const double rk_a[4][4] = {{0}, {0.5}, {0, 0.5}, {0, 0, 1}};
static const double rk_b[4] = {1.0/6, 1.0/3, 1.0/3, 1.0/6};
static const double rk_c[4] = {0, 0.5, 0.5, 1};
ButcherTableau classic() { return ButcherTableau("classic", rk_a, rk_b, rk_c); }
"""
GAUSS = """# Runge-Kutta methods with one stage and two
class ImplicitMidpoint:
    order = 2
    A = [[0.5]]
    b = [1.0]
    c = [0.5]


class Gauss4:
    order = 4
    A = [[1 / 4, 1 / 4 - np.sqrt(3) / 6], [1 / 4 + np.sqrt(3) / 6, 1 / 4]]
    b = [1 / 2, 1 / 2]
    c = [1 / 2 - np.sqrt(3) / 6, 1 / 2 + np.sqrt(3) / 6]
"""
CASES = {
    "C struct, a row": Case("z.c", ZONNEVELD, "-1./32 }", "1./32 }", "row 5 of A"),
    "C struct, a weight": Case("z.c", ZONNEVELD, "{ 1./6, 1./3, 1./3", "{ 1./6, 1./3, 1./6", "b[3]"),
    "Fortran data": Case("f.f90", FEHLBERG, "3.3208921256", "3.3208921526", "a[4][3]"),
    "Fortran weights": Case("f.f90", FEHLBERG, "2197.d0/4104", "2187.d0/4104", "b[4]"),
    "Julia SMatrix": Case("r.jl", RALSTON, "-1//3 1 0 0", "1//3 1 0 0", "a[3][1]"),
    "Python fractions": Case("b.py", BUTCHER5, "F(9, 16)]", "F(9, 61)]", "a[5][4]"),
    "Rust 2N": Case("l.rs", LOWSTORE, "5161836677717", "5168136677717", "B[2]"),
    "Rust 2N, A": Case("l.rs", LOWSTORE, "-567301805773", "-576301805773", "A[2]"),
    "Java Shu-Osher": Case("S.java", SSP, "{0.0, 1.0 / 4},", "{0.0, 1.0 / 2},", "beta[2][2]"),
    "Go Adams": Case("lmm.go", ADAMS, "-59.0 / 24", "-95.0 / 24", "-59/24"),
    "JavaScript splitting": Case(
        "fr.js", FOREST, "-1.7024143839193155", "-1.7042143839193155", "b[2]"
    ),
    "MATLAB Rosenbrock": Case("ros3p.m", RODAS, "1/2-2*g g", "1/2-g g", "gamma[3][2]"),
    "Python Nystrom": Case("n.py", NYSTROM, "162 / 336", "126 / 336", "b_prime[3]"),
    "C++ names": Case("bs.hpp", BOGACKI, "a43 = Real(4) / 9", "a43 = Real(5) / 9", "row 4 of A"),
    "C++ embedded": Case(
        "bs.hpp", BOGACKI, "bhat4 = Real(1) / 8", "bhat4 = Real(-1) / 8", "bhat"
    ),
    "composition": Case("y.py", SUZUKI, "-1.17767998417887, 0.2355", "-1.17767989417887, 0.2355",
                        "the order is 0"),
    "order elsewhere": Case(
        "t.cpp", ELSEWHERE, "{0, 0.5}, {0, 0, 1}", "{0, 0.25}, {0, 0, 1}", "a[3][2]",
        (("reg.cpp", "// orders\nint classic_order() { return 4; }\n"),),
    ),
    "two stages": Case("g.py", GAUSS, "1 / 4 + np", "1 / 4 - np", "a[2][1]"),
    "one stage": Case("g.py", GAUSS, "A = [[0.5]]", "A = [[0.25]]", "a[1][1]"),
}  # fmt: skip


def _audited(folder: Path, case: Case, text: str) -> list[dict]:
    folder.mkdir(parents=True)
    for name, other in case.more:
        (folder / name).write_text(other, "utf-8")
    (folder / case.path).write_text(text, "utf-8")
    return list(audit(folder, compare=False))


#: Cases whose corrections are found soon.
QUICK = {"Java Shu-Osher", "JavaScript splitting", "Go Adams", "order elsewhere", "one stage"}


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "case",
    [pytest.param(x, id=k, marks=[] if k in QUICK else [pytest.mark.slow])
     for k, x in CASES.items()],
)  # fmt: skip
def test_a_defect_is_found_and_its_right_twin_is_not_accused(case: Case, tmp_path: Path) -> None:
    right = _audited(tmp_path / "right", case, case.text)
    read = [x for x in right if "multistep" not in str(x["remarks"])]
    assert right and {x["status"] for x in read} <= {"right", "digits", "found"}, right
    assert not any(x["status"] in ("wrong", "question") for x in right)
    assert case.right in case.text
    found = _audited(tmp_path / "wrong", case, case.text.replace(case.right, case.wrong, 1))
    accused = [x for x in found if x["status"] in ("wrong", "question")]
    assert accused, found
    assert case.said in str(accused), accused
