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
