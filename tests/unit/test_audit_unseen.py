"""Sources that no reader was written for: the right twin is accused of nothing, the wrong one is.

Each defect is one of those that a code can have: a digit, two entries exchanged, a row of another
method, the weights of an error estimate in place of embedded ones.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from glmref.audit.sources import audit
from tests.build import source


class Case(NamedTuple):
    """A file, what makes it wrong, and the entry, or the words, that must be said."""

    path: str
    text: str
    right: str
    wrong: str
    said: str
    more: tuple[tuple[str, str], ...] = ()
    compare: bool = False  #: Whether a method of the catalogue is what says it.


ZONNEVELD = source("zonneveld.c")
FEHLBERG = source("fehlberg.f90")
RALSTON = source("ralston.jl")
BUTCHER5 = source("butcher5.txt")
LOWSTORE = source("lowstore.rs")
SSP = source("ssp.java")
ADAMS = source("adams.go")
FOREST = source("forest.js")
RODAS = source("rodas.m")
NYSTROM = source("nystrom.txt")
BOGACKI = source("bogacki.hpp")
SUZUKI = source("suzuki.txt")
ELSEWHERE = source("elsewhere.cpp")
GAUSS = source("gauss.txt")
CASH_KARP = source("cash_karp.hpp")
SUFFIXES = source("suffixes.f90")
WEIGHTS = source("weights.java")
BASHFORTH = source("bashforth.rs")
CLASSICAL = source("classical.m")
RUTH = source("ruth.txt")
THERMOSTAT = source("thermostat.txt")
SYMPLECTIC = source("symplectic.rs")
PEFRL = source("pefrl.txt")
CHAIN = source("thermostat-classes.txt")
CHOICES = source("lsrk-cases.f90")
SWITCH = source("symplectic-cases.cpp")
REGISTERS = source("registers.jl")
HATS = source("ars.txt")
BDF = source("bdf.js")
DENSE = source("dense.txt")
FEW = source("few-registers.h")
STIFF = source("stiffly-accurate.f90")
TRIPLE = (
    "/* Yoshida's composition of leapfrog, of order 4 */\n"
    "void jump(double dt) {\n  const double cut = pow(2.0, 1.0/3.0);\n"
    "  const double yoshida[3] = {1/(2 - cut), -cut/(2 - cut), 1/(2 - cut)};\n}\n"
)
TUPLE = (
    "# Kutta's Runge-Kutta method of order 3\n"
    "const kutta3 = (order = 3, A = [0 0 0; 1//2 0 0; -1 2 0], b = [1//6, 2//3, 1//6],\n"
    "    c = [0, 1//2, 1])\n"
)
HALVES = (
    "function tab = imex_ssp2()  % IMEX Runge-Kutta method of Pareschi and Russo\n"
    "  g = 1 - 1/sqrt(2);\n  tab.order = 2;\n"
    "  tab.A_ex = [0 0; 1 0];\n  tab.A_im = [g 0; 1-2*g g];\n"
    "  tab.b_ex = [1/2 1/2];\n  tab.b_im = [1/2 1/2];\n"
    "  tab.c_ex = [0; 1];\n  tab.c_im = [g; 1-g];\nend\n"
)
ATELA = (
    "/* fourth-order symplectic integrator of McLachlan and Atela */\n"
    "const double %s_coef[] = {0.1344961992774310892, -0.2248198030794208058,\n"
    "    0.7563200005156682911, 0.3340036032863214255};\n"
    "const double %s_coef[] = {0.5153528374311229364, -0.085782019412973646,\n"
    "    0.4415830236164665242, 0.1288461583653841854};\n"
)
#: The weights are the last row of A, as only those of the embedded row have a name.
LAST = (
    "//! Runge-Kutta pair of Bogacki and Shampine\npub const ORDER: u32 = 3;\n"
    "pub const C: [f64; 4] = [0.0, 1.0 / 2.0, 3.0 / 4.0, 1.0];\n"
    "pub const A: [[f64; 4]; 4] = [[0.0; 4], [1.0 / 2.0, 0.0, 0.0, 0.0],\n"
    "    [0.0, 3.0 / 4.0, 0.0, 0.0], [2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0, 0.0]];\n"
    "pub const B_HAT: [f64; 4] = [7.0 / 24.0, 1.0 / 4.0, 1.0 / 3.0, 1.0 / 8.0];\n"
)
MERSON = (
    "// Runge-Kutta methods: rows of c and A, and b\nconst merson = { order: 4, tableau: [\n"
    "  [0],\n  [1/3, 1/3],\n  [1/3, 1/6, 1/6],\n  [1/2, 1/8, 0, 3/8],\n"
    "  [1, 1/2, 0, -3/2, 2],\n  [1/6, 0, 0, 2/3, 1/6] ] };\n"
)
DIFFERENCES = (
    "package pde\nvar bdfRows = [][]float64{\n  {1, -1},\n  {3.0 / 2, -2, 1.0 / 2},\n"
    "  {11.0 / 6, -3, 3.0 / 2, -1.0 / 3},\n  {25.0 / 12, -4, 3, -4.0 / 3, 1.0 / 4},\n}\n"
)
DRIFT = (
    "! Ruth (1983)\ninteger, parameter :: iorder = 3\n"
    "real, parameter :: cdrift(3) = (/ 7.0/24.0, 3.0/4.0, -1.0/24.0 /)\n"
    "real, parameter :: ckick(3) = (/ 2.0/3.0, -2.0/3.0, 1.0 /)\n"
)
STORAGE = (
    "! 2N-storage scheme, 3 stages, order 3\n"
    "real, parameter :: RKA(3) = (/ 0.0, -5.0/9.0, -153.0/128.0 /)\n"
    "real, parameter :: RKB(3) = (/ 1.0/3.0, 15.0/16.0, 8.0/15.0 /)\n"
)
DISPATCH = (
    "# symplectic methods\nstruct Ruth <: Method end\norder(::Ruth) = 3\n"
    "coefficients(::Ruth) = (\n    c = (7 / 24, 3 / 4, -1 / 24),\n    d = (2 / 3, -2 / 3, 1.0),\n)\n"
)
CASES = {
    "order of a type": Case("r.jl", DISPATCH, "order(::Ruth) = 3", "order(::Ruth) = 4", "order"),
    "drift and kick": Case("t.c", ATELA % ("kick", "drift"), ATELA % ("kick", "drift"),
                           ATELA % ("drift", "kick"), "exchanged", (), True),
    "last row": Case("b.rs", LAST, "3.0 / 4.0, 0.0, 0.0]", "3.0 / 5.0, 0.0, 0.0]", "row 3 of A"),
    "c before rows": Case("m.js", MERSON, "-3/2, 2]", "-2/3, 2]", "a[5][3]"),
    "rows of BDF": Case("b.go", DIFFERENCES, "-4.0 / 3", "-3.0 / 4", "should be -4/3 (line 6)"),
    "names of flows": Case("r.f90", DRIFT, "7.0/24", "7.0/42", "a[1]"),
    "2N, no name": Case("l.f90", STORAGE, "153.0", "135.0", "A[3]"),
    "Julia named tuple": Case("k.jl", TUPLE, "-1 2 0", "1 2 0", "a[3][1]"),
    "MATLAB explicit half": Case("t.m", HALVES, "[0 0; 1 0]", "[0 0; -1 0]", "a[2][1]"),
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
                        "w[5]"),
    "order elsewhere": Case(
        "t.cpp", ELSEWHERE, "{0, 0.5}, {0, 0, 1}", "{0, 0.25}, {0, 0, 1}", "a[3][2]",
        (("reg.cpp", "// orders\nint classic_order() { return 4; }\n"),),
    ),
    "two stages": Case("g.py", GAUSS, "1 / 4 + np", "1 / 4 - np", "a[2][1]"),
    "C++ braces": Case("ck.hpp", CASH_KARP, "253)/4096", "253)/4069", "a[6][5]"),
    "Fortran suffixes": Case("g.f90", SUFFIXES, "s15/15.0_dp, &", "s15/51.0_dp, &", "a[3][2]"),
    "Java weights": Case("w.java", WEIGHTS, "0.4144907717943757}", "0.4149407717943757}", "w[5]"),
    "Rust Adams": Case("ab.rs", BASHFORTH, "1274.0", "1247.0", "entry 4"),
    "MATLAB step": Case("rk4.m", CLASSICAL, "k4)", "k3)", "b[4]", (), True),
    "drifts and kicks": Case("fr.py", RUTH, "[w1, w0, w1]", "[w1, w1, w0]", "forest-ruth-4", (), True),
    "one list of several": Case("nhc.py", THERMOSTAT, "0.65796308", "0.65769308", "w[3]"),
    "pairs of steps": Case("s.rs", SYMPLECTIC, "7.0/24", "7.0/42", "b[3]"),
    "steps with a number": Case("s.rs", SYMPLECTIC, "0.7563200005", "0.7536200005", "b[3]"),
    "flows in turn": Case("pef.py", PEFRL, "= -0.2123418310", "= -0.2132418310", "omelyan-pefrl-4",
                          (), True),
    "an exponent of the wrong sign": Case(
        "ys.py", CHAIN, "1.3512071919596578, -1.7024143839193155, 1.3512071919596578",
        "0.828981543588751, -0.657963087177502, 0.828981543588751", "0.855"),
    "2N in a choice": Case("l.f90", CHOICES, "-153._dp/128", "-135._dp/128", "A[3]"),
    "2N in ranges": Case("l.f90", CHOICES, "153._dp/128._dp /)", "135._dp/128._dp /)", "A[3]"),
    "a splitting in a choice": Case("s.cpp", SWITCH, "b_[1] = 0.75", "b_[1] = 0.57", "b[2]"),
    "2N with the other sign": Case("r.jl", REGISTERS, "15 / 16", "16 / 15", "B[2]"),
    "two registers": Case("r.jl", REGISTERS, "5 / 12)", "5 / 21)", "a[3][2]"),
    "hats": Case("a.py", HATS, "[d, 1 - d]", "[d, 1 + d]", "a[3][2]"),
    "BDF": Case("b.js", BDF, "9 / 11", "8 / 11", "9/11 (line 4)"),
    "dense output": Case("d.py", DENSE, "-8 / 9", "-7 / 9", "row 3 of P"),
    "names of few registers": Case("f.h", FEW, "5. / 12", "5. / 21", "a[3][2]"),
    "names of the last row": Case("s.f90", STIFF, "- 20._dp", "- 21._dp", "weights do not sum"),
    "a root": Case("t.c", TRIPLE, "(2.0, 1.0", "(2.0, -1.0", "cubes"),
    "one stage": Case("g.py", GAUSS, "A = [[0.5]]", "A = [[0.25]]", "a[1][1]"),
}  # fmt: skip


def _audited(folder: Path, case: Case, text: str) -> list[dict]:
    folder.mkdir(parents=True)
    for name, other in case.more:
        (folder / name).write_text(other, "utf-8")
    (folder / case.path).write_text(text, "utf-8")
    return list(audit(folder, compare=case.compare))


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


#: The classical method as steps: its text, and what is changed in the third stage or the weights.
STEPS = {
    "r.c": (
        ("/* Runge-Kutta, 4th order */\n"
        "void rk4(double t, double h, double *y, int n) {\n  f(t, y, k1);\n"
        "  for (int i = 0; i < n; i++) tmp[i] = y[i] + 0.5*h*k1[i];\n  f(t + 0.5*h, tmp, k2);\n"
        "  for (int i = 0; i < n; i++) tmp[i] = y[i] + 0.5*h*k2[i];\n  f(t + 0.5*h, tmp, k3);\n"
        "  for (int i = 0; i < n; i++) tmp[i] = y[i] + h*k3[i];\n  f(t + h, tmp, k4);\n"
        "  for (int i = 0; i < n; i++) y[i] += h*(k1[i] + 2.*k2[i] + 2.*k3[i] + k4[i])/6.;\n}\n"),
        ("0.5*h*k2", "0.25*h*k2"), ("2.*k3", "3.*k3"),
    ),
    "r.go": (
        ("// Runge-Kutta of order 4\nfunc rk4(f Rhs, t float64, y []float64, h float64) []float64 {\n"
        "  tmp := make([]float64, n)\n  k1 := f(t, y)\n"
        "  for i := range y {\n    tmp[i] = y[i] + 0.5*h*k1[i]\n  }\n  k2 := f(t+0.5*h, tmp)\n"
        "  for i := range y {\n    tmp[i] = y[i] + 0.5*h*k2[i]\n  }\n  k3 := f(t+0.5*h, tmp)\n"
        "  for i := range y {\n    tmp[i] = y[i] + h*k3[i]\n  }\n  k4 := f(t+h, tmp)\n"
        "  for i := range y {\n    y[i] += h/6*(k1[i]+2*k2[i]+2*k3[i]+k4[i])\n  }\n"
        "  return y\n}\n"),
        ("0.5*h*k2", "0.25*h*k2"), ("2*k3", "3*k3"),
    ),
    "r.js": (
        ("// Runge-Kutta of order 4\nfunction rk4(y, t, h, f) {\n  const k1 = f(t, y);\n"
        "  const k2 = f(t + h / 2, add(y, scale(k1, h / 2)));\n"
        "  const k3 = f(t + h / 2, add(y, scale(k2, h / 2)));\n"
        "  const k4 = f(t + h, add(y, scale(k3, h)));\n"
        "  return add(y, scale(add(add(k1, scale(k2, 2)), add(scale(k3, 2), k4)), h / 6));\n}\n"),
        ("scale(k2, h / 2)", "scale(k2, h / 3)"), ("scale(k3, 2)", "scale(k3, 3)"),
    ),
    "r.jl": (
        ("# Runge-Kutta of order 4\nfunction rk4(f, y, t, h)\n    k1 = h * f(t, y)\n"
        "    k2 = h * f(t + 0.5h, y + 0.5k1)\n    k3 = h * f(t + 0.5h, y + 0.5k2)\n"
        "    k4 = h * f(t + h, y + k3)\n"
        "    return y .+ (k1 .+ 2 .* k2 .+ 2 .* k3 .+ k4) ./ 6\nend\n"),
        ("0.5k2", "0.2k2"), ("2 .* k3", "3 .* k3"),
    ),
    "r.py": (
        ("# Runge-Kutta of order 4\nt, h = 0.0, 0.1\ny = np.array([1.0, 0.0])\nwhile t < 1:\n"
        "    k1 = f(t, y)\n    k2 = f(t + h/2, y + h*k1/2)\n    k3 = f(t + h/2, y + h*k2/2)\n"
        "    k4 = f(t + h, y + h*k3)\n    y = y + h*(k1 + 2*k2 + 2*k3 + k4)/6\n    t = t + h\n"),
        ("h*k2/2", "h*k2/3"), ("2*k3", "3*k3"),
    ),
    "r.cpp": (
        ("// Runge-Kutta of order 4, the slope at the start given\n"
        "void rk4(Vec &y, Vec &dydx, double x, double h, Vec &yout) {\n"
        "  double hh = h*0.5; double h6 = h/6.0; double xh = x+hh;\n"
        "  for (int i=0;i<n;i++) yt[i]=y[i]+hh*dydx[i];\n  derivs(xh,yt,dyt);\n"
        "  for (int i=0;i<n;i++) yt[i]=y[i]+hh*dyt[i];\n  derivs(xh,yt,dym);\n"
        "  for (int i=0;i<n;i++) { yt[i]=y[i]+h*dym[i]; dym[i] += dyt[i]; }\n"
        "  derivs(x+h,yt,dyt);\n"
        "  for (int i=0;i<n;i++) yout[i]=y[i]+h6*(dydx[i]+dyt[i]+2.0*dym[i]);\n}\n"),
        ("yt[i]=y[i]+hh*dyt[i]", "yt[i]=y[i]+h*dyt[i]"), ("dydx[i]+dyt", "2.0*dydx[i]+dyt"),
    ),
    "R.java": (
        ("// Runge-Kutta\nclass RK4 { int order = 4;\n"
        "  double step(double t, double y, double h) {\n    double k1 = f(t, y);\n"
        "    double k2 = f(t + h / 2, y + h * k1 / 2);\n"
        "    double k3 = f(t + h / 2, y + h * k2 / 2);\n    double k4 = f(t + h, y + h * k3);\n"
        "    return y + h * (k1 + 2 * k2 + 2 * k3 + k4) / 6;\n  }\n}\n"),
        ("h * k2 / 2", "h * k2 / 3"), ("2 * k3", "3 * k3"),
    ),
    "r.rs": (
        ("// Runge-Kutta 4\nfn rk4(f: &dyn Fn(f64, f64) -> f64, t: f64, y: f64, h: f64) -> f64 {\n"
        "    let k1 = f(t, y);\n    let k2 = f(t + h / 2.0, y + h * k1 / 2.0);\n"
        "    let k3 = f(t + h / 2.0, y + h * k2 / 2.0);\n    let k4 = f(t + h, y + h * k3);\n"
        "    y + h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0\n}\n"),
        ("h * k2 / 2.0", "h * k2 / 3.0"), ("2.0 * k3", "3.0 * k3"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", [
    pytest.param(x, marks=pytest.mark.slow) for x in STEPS
])  # fmt: skip
def test_a_step_in_its_arithmetic_is_read(name: str, tmp_path: Path) -> None:
    """A wrong factor in a stage or in the weights is asked for, with the line; the twin is right."""
    text, *changes = STEPS[name]
    for k, (right, wrong) in enumerate((("", ""), *changes)):
        folder = tmp_path / str(k)
        folder.mkdir()
        changed = text.replace(right, wrong, 1) if right else text
        assert right == "" or changed != text
        (folder / name).write_text(changed, "utf-8")
        (record,) = audit(folder, compare=False)
        assert record["status"] == ("question" if k else "right"), record
        assert record["declared"] == 4
        if k and name != "r.cpp":
            (entry,) = record["correction"]
            lines = [n for n, x in enumerate(changed.splitlines(), 1) if wrong in x]
            assert entry["entry"] == ("a[3][2]", "b[3]")[k - 1] and entry["line"] in lines


def test_two_steps_of_gradient_descent_are_no_method(tmp_path: Path) -> None:
    (tmp_path / "g.py").write_text(
        "# Runge-Kutta is not used here\ndef descend(x, rate):\n    for k in range(9):\n"
        "        x = x - rate * gradient(x)\n    return x - rate * gradient(x)\n", "utf-8"
    )  # fmt: skip
    assert all(x["status"] == "unread" for x in audit(tmp_path, compare=False))


def test_a_step_with_a_branch_is_not_read(tmp_path: Path) -> None:
    """Which of two arguments the stage has is not known, so that no order is said."""
    (tmp_path / "b.py").write_text(
        "# Runge-Kutta\ndef step(f, t, y, h, heun):\n    k1 = f(t, y)\n    if heun:\n"
        "        z = y + h*k1\n    else:\n        z = y + h*k1/2\n    k2 = f(t + h, z)\n"
        "    return y + h*(k1 + k2)/2\n", "utf-8"
    )  # fmt: skip
    assert [x["status"] for x in audit(tmp_path, compare=False)] == ["unread"]


#: Steps as of the GNU Scientific Library: calls return a flag, slopes are fields of an object.
FLAGS = """/* Runge-Kutta, order 3 */
static const double b3[] = { -1.0, 2.0 };
static int rk_apply (state_t *state, double t, double h, double y[], double yerr[], size_t n)
{
  double *const k1 = state->k1;
  double *const k2 = state->k2;
  double *const k3 = state->k3;
  double *const ytmp = state->ytmp;
  { int s = EVAL (sys, t, y, k1); if (s != SUCCESS) { return s; } }
  for (i = 0; i < n; i++) { ytmp[i] = y[i] + 0.5 * h * k1[i]; }
  { int s = EVAL (sys, t + 0.5 * h, ytmp, k2); if (s != SUCCESS) { return s; } }
  for (i = 0; i < n; i++) { ytmp[i] = y[i] + h * (b3[0] * k1[i] + b3[1] * k2[i]); }
  { int s = EVAL (sys, t + h, ytmp, k3); if (s != SUCCESS) { return s; } }
  for (i = 0; i < n; i++)
    {
      const double d_i = (k1[i] + 4.0 * k2[i] + k3[i]) / 6.0;
      y[i] += h * d_i;
      yerr[i] = h * (d_i - k2[i]);
    }
  return SUCCESS;
}
"""
#: One field for all slopes, the first of them given, and the new value beside a copy of the old.
ONE_SLOPE = """/* Runge-Kutta, order 4 */
static int rk4_step (double *y, state_t *state, double h, double t, size_t n)
{
  const double *y0 = state->y0;
  double *k = state->k;
  for (i = 0; i < n; i++) { y[i] += h / 6.0 * k[i]; ytmp[i] = y0[i] + 0.5 * h * k[i]; }
  { int s = EVAL (sys, t + 0.5 * h, ytmp, k); if (s != SUCCESS) { return s; } }
  for (i = 0; i < n; i++) { y[i] += h / 3.0 * k[i]; ytmp[i] = y0[i] + 0.5 * h * k[i]; }
  { int s = EVAL (sys, t + 0.5 * h, ytmp, k); if (s != SUCCESS) { return s; } }
  for (i = 0; i < n; i++) { y[i] += h / 3.0 * k[i]; ytmp[i] = y0[i] + h * k[i]; }
  { int s = EVAL (sys, t + h, ytmp, k); if (s != SUCCESS) { return s; } }
  for (i = 0; i < n; i++) { y[i] += h / 6.0 * k[i]; }
  return SUCCESS;
}
"""


@pytest.mark.parametrize(
    ("text", "right", "wrong", "said"),
    [
        pytest.param(FLAGS, "4.0 * k2", "3.0 * k2", "b[2]", marks=pytest.mark.slow),
        (FLAGS, "d_i - k2", "d_i - 1.25 * k2", "sum to"),
        pytest.param(
            ONE_SLOPE, "y0[i] + h * k", "y0[i] + 2.0 * h * k", "a[4][3]", marks=pytest.mark.slow
        ),
    ],
)
def test_slopes_in_fields_and_flags_of_calls_are_followed(
    text: str, right: str, wrong: str, said: str, tmp_path: Path
) -> None:
    for name, changed in (("right", text), ("wrong", text.replace(right, wrong))):
        (tmp_path / name).mkdir()
        (tmp_path / name / "rk.c").write_text(changed, "utf-8")
        (record,) = audit(tmp_path / name, compare=False)
        assert (record["status"] == "right") is (name == "right"), record
    assert said in str(record)


#: A pair as an example of Geant4 has it, with the three entries that are wrong there.
FEHLBERG_STEP = """// based on the page on the method of Runge-Kutta-Fehlberg
double ODESolver::RungeKutta_Fehlberg(Rhs func, std::vector<double> &y, double t, double h)
{
  const int nk=6;
  double CH[nk]={47./450.,0,12./25.,32./255.,1./30.,6./25.};
  double A[nk]={0.,2./9.,1./3.,3./4.,1.,5./6.};
  double B21=2./9., B31=1./12., B41=69./128., B51=-17./12., B61=65./432.;
  double B32=1./4., B42=-243./128., B52=27./5., B62=13./16.;
  double B43=135./64., B53=-27./5., B63=13./16.;
  double B54=16./15., B64=4./27.;
  double B65=5./144.;
  std::vector<double> k1 = func(t+A[0]*h,y)*h;
  std::vector<double> k2 = func(t+A[1]*h,y + k1*B21)*h;
  std::vector<double> k3 = func(t+A[2]*h,y + k1*B31 + k2*B32)*h;
  std::vector<double> k4 = func(t+A[3]*h,y + k1*B41 + k2*B42 + k3*B43)*h;
  std::vector<double> k5 = func(t+A[4]*h,y + k1*B51 + k2*B52 + k3*B53 + k4*B54)*h;
  std::vector<double> k6 = func(t+A[5]*h,y + k1*B61 + k2*B62 + k3*B63 + k4*B64 + k5*B65)*h;
  y = y + k1*CH[0] + k2*CH[1] + k3*CH[2] + k4*CH[3] + k5*CH[4] + k6*CH[5];
}
"""


def test_a_step_whose_weights_do_not_sum_to_1_is_asked_about(tmp_path: Path) -> None:
    """Most of its rows sum to the times of its stages, so that it is one, whatever its order."""
    right = FEHLBERG_STEP.replace("32./255.", "32./225.").replace("B52=27./5.", "B52=27./4.")
    texts = {"wrong": FEHLBERG_STEP, "right": right.replace("B62=13./16.", "B62=-5./16.")}
    found = {}
    for name, text in texts.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "ODESolver.cc").write_text(text, "utf-8")
        (found[name],) = audit(tmp_path / name, compare=False)
    assert (found["wrong"]["status"], found["wrong"]["found"]) == ("question", 0)
    assert (found["right"]["status"], found["right"]["found"]) == ("found", 5)


#: A step of order 4 whose last sum, and the argument of whose third stage, calls complete.
COMPLETED = """
def rk4(f, t, y, h):
    k1 = f(t, y)
    k2 = f(t + h / 2, y + h / 2 * k1)
    k3 = f(t + h / 2, y + h / 2 * k2)
    k4 = f(t + h, y + h * k3)
    z = y + h / 6 * k1 + h / 3 * k2
    {}
    return z
"""


@pytest.mark.parametrize(
    "call", ["z.add_(h / 3 * k3 + h / 6 * k4)", "axpy(h / 3, k3, z); axpy(h / 6, k4, z)"]
)
def test_a_right_step_that_a_call_completes_is_not_accused(call: str, tmp_path: Path) -> None:
    path = tmp_path / "rk4.py"
    path.write_text(COMPLETED.format(call))
    (found,) = audit(path, compare=False)
    assert found["status"] == "unread" and "not followed" in found["remarks"][-1]
    path.write_text(COMPLETED.format("z = z + h / 3 * k3 + h / 6 * k4"))
    (found,) = audit(path, compare=False)
    assert (found["status"], found["found"]) == ("right", 4)
    path.write_text(COMPLETED.format("z = z + h / 3 * k3 + h / 3 * k4"))
    (found,) = audit(path, compare=False)
    assert found["status"] in ("wrong", "question")


#: Weights, nodes and one of two matrices of a Nystrom method in a form of its own.
NYSTROM_BESIDE = """
class Verlet(RungeKuttaNystrom):
    order = 2
    nodes = np.array([1.0, 1.0])
    weights = np.array([1 / 2, 0])
    matrix = np.zeros([2, 2])
    matrix[1, 1] = 1
    weights_bar = np.array([1 / 2, 0])
    matrix_bar = np.zeros([2, 2])
"""
#: A method, and the step of another one whose weights are ones, too.
CHOICE = """
class RungeKuttaMidpoint:
    def __init__(self, order):
        self.order = order
        if self.order == 1:
            self.A = np.array([[0, 0], [0, 0.5]])
            self.A_hat = np.array([[0, 0], [0.5, 0]])
            self.b = np.array([0, 1])
            self.b_hat = np.array([0, 1])

class RungeKuttaSplit:
    def step(self, y, h):
        k1 = self.f_slow(y)
        k2 = self.f_slow(y + h / 3 * k1)
        k3 = self.f_slow(y + h / 2 * k2)
        return y + h * k1 + h * k3
"""


@pytest.mark.parametrize("text", [NYSTROM_BESIDE, CHOICE])
def test_what_may_be_no_tableau_is_not_accused(text: str, tmp_path: Path) -> None:
    (tmp_path / "methods.py").write_text(f"import numpy as np\n{text}")
    found = audit(tmp_path, compare=False)
    assert not [x for x in found if x["status"] in ("wrong", "question")]


#: Expansions through an order of methods of lower ones, and one method that is declared of it.
SERIES = """# Runge-Kutta methods
order = 5
A = [[0, 0], [1 / 2, 0]]
b = [0, 1]
c = [0, 1 / 2]
left = expand(A, b, c, order)
A = [[0, 0], [1, 0]]
b = [1 / 2, 1 / 2]
c = [0, 1]
right = expand(A, b, c, order)
"""
#: A pair whose steps are those of lower order.
PAIR = """
scheme = AdaptiveRungeKutta(largest_order=3, A=[[0, 0, 0], [1 / 2, 0, 0], [-1, 2, 0]],
                            b=[0, 1, 0], b_star=[1 / 6, 2 / 3, 1 / 6], c=[0, 1 / 2, 1])
"""
#: A method with noise, whose A1 and B1 alone are those of a method of order 1.
NOISE = """
def order(): return 2
RUNGE_KUTTA = dict(weights=[1 / 6, 2 / 3, 1 / 6], A0=[[0, 0, 0], [1 / 2, 0, 0], [-1, 2, 0]],
    B0=[[0, 0, 0], [1 / 3, 0, 0], [1, 0, 0]], A1=[[0, 0, 0], [1 / 4, 0, 0], [1 / 4, 0, 0]],
    B1=[[0, 0, 0], [1 / 2, 0, 0], [-1 / 2, 0, 0]])
"""
#: An Adams method whose step subtracts the second slope.
SIGNS = "# Adams and Bashforth\nab3w1 = 23 / 12\nab3w2 = 16 / 12\nab3w3 = 5 / 12\n"


@pytest.mark.parametrize(
    ("text", "right", "wrong"),
    [
        (SERIES, SERIES[SERIES.index("A = [[0, 0], [1, 0]]") :], ""),
        (PAIR, "largest_order", "order"),
        (NOISE, "A0=", "A="),
        (SIGNS, "16 / 12", "-61 / 12"),
    ],
)
def test_what_is_said_of_another_table_or_by_the_step_accuses_none(
    text: str, right: str, wrong: str, tmp_path: Path
) -> None:
    path = tmp_path / "methods.py"
    path.write_text(text)
    found = audit(tmp_path, compare=False)
    assert not [x for x in found if x["status"] in ("wrong", "question")], found
    path.write_text(text.replace(right, wrong))
    assert [x for x in audit(tmp_path, compare=False) if x["status"] in ("wrong", "question")]


SMOOTHED = (
    "# Yoshida's integrators, and what smooths their output\n"
    "FILTER = [-3/35, 12/35, 17/35, 12/35, -3/35]\n"
    "class Splitting:\n"
    "    moves = [0.0792036964311957, 0.353172906049774, -0.0420650803577195, 0.2193769557534996,\n"
    "             -0.0420650803577195, 0.353172906049774, 0.0792036964311957]\n"
    "    pushes = [0.209515106613362, -0.143851773179818, 0.434336666566456, 0.434336666566456,\n"
    "              -0.143851773179818, 0.209515106613362]\n"
    "POINTS = [(0.1127, 5/18), (0.5, 4/9), (0.8873, 5/18)]\n"
)


def test_other_lists_with_a_palindrome_and_the_sum_1_are_no_weights(tmp_path: Path) -> None:
    """A filter of Savitzky and Golay, the kicks of a splitting, and weights of a quadrature."""
    (tmp_path / "yoshida.py").write_text(SMOOTHED)
    found = [x for x in audit(tmp_path, compare=False) if x["status"] in ("wrong", "question")]
    assert not found
