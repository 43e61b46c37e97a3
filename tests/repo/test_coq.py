"""Machine-checked proofs: a few methods through Coq, and certificates with a changed digit refused.

The whole list is proved by `python checker/coq/check.py`.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from glmref.prove.coq import file_stem, to_coq

ROOT = Path(__file__).parents[2]
LIBRARY = ("Trees", "Field", "GLM", "Symplectic", "NotOrder", "Explicit")

needs_coq = pytest.mark.skipif(
    shutil.which("coqc") is None, reason="coqc is missing: install the Debian package coq"
)


def _compile(folder: Path, name: str, text: str) -> tuple[bool, str]:
    (folder / f"{name}.v").write_text(text, encoding="utf-8")
    run = subprocess.run(
        ["coqc", "-Q", str(folder), "Glmref", str(folder / f"{name}.v")],
        capture_output=True,
        text=True,
        check=False,
    )
    return run.returncode == 0, run.stdout + run.stderr


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("coq")
    for name in LIBRARY:
        text = (ROOT / "checker" / "coq" / f"{name}.v").read_text(encoding="utf-8")
        good, printed = _compile(folder, name, text)
        assert good, printed
        assert set(printed.splitlines()) <= {"Closed under the global context"}  # no axiom
    return folder


def test_library_assumes_nothing() -> None:
    for file in (ROOT / "checker" / "coq").glob("*.v"):
        text = re.sub(r"\(\*.*?\*\)", "", file.read_text(encoding="utf-8"), flags=re.S)
        assert not re.search(r"\b(Axiom|Admitted|admit|Parameter|Conjecture)\b", text), file.name


def test_every_theorem_is_followed_by_its_assumptions() -> None:
    text = to_coq("gsymplectic-n")
    theorems = re.findall(r"^Theorem (\w+)", text, re.M)
    assert theorems
    assert set(theorems) == set(re.findall(r"^Print Assumptions (\w+)\.", text, re.M))


@needs_coq
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "theorems"),
    [
        ("rk4", ["order_4", "not_order_5"]),
        ("gauss-2", ["order_4", "not_order_5", "symplectic", "symmetric"]),
        (
            "gsymplectic-n",
            ["order_identity_4", "order_4", "not_order_identity_5", "g_symplectic", "symmetric"],
        ),
        ("gsymplectic-p", ["order_identity_4", "order_4", "g_symplectic", "symmetric"]),
        ("s4-symmetric", ["order_identity_4", "g_symplectic", "symmetric", "no_growth"]),
        ("stormer-verlet", ["order_2", "not_order_identity_3", "g_symplectic"]),
    ],
)
def test_claims_are_proved_without_axioms(library: Path, name: str, theorems: list[str]) -> None:
    text = to_coq(name)
    found = re.findall(rf"^Theorem {file_stem(name)}_(\w+)", text, re.M)
    assert set(theorems) <= set(found)
    good, printed = _compile(library, file_stem(name), text)
    assert good, printed
    assert printed.count("Closed under the global context") == len(found)


@needs_coq
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("rk4", "Rat (1#6)", "Rat (1#7)"),  # a digit of b
        ("gauss-2", "Rat (-1#6)", "Rat (-1#5)"),  # a digit of A
        ("gauss-2", "T : tower := [(2, Rat (3#1))]", "T : tower := [(2, Rat (2#1))]"),
        ("gsymplectic-n", "Ext (Rat 0) (Rat (1#18))", "Ext (Rat 0) (Rat (1#19))"),  # eta
        ("gsymplectic-n", "[Rat 0; Rat (-1#1)]", "[Rat 0; Rat (-2#1)]"),  # V
        ("stormer-verlet", "u eta Z a F x H\n  2", "u eta Z a F x H\n  1"),  # a lower order fails
        (
            "abm-4-pece",
            "Definition a : rooted -> list num :=\n    fun c => [Rat (1#1)",
            "Definition a : rooted -> list num :=\n    fun c => [Rat (2#1)",
        ),
        (
            "rk4",
            "rk_order (matrix F x a) (vector F x b) 4",
            "rk_order (matrix F x a) (vector F x b) 5",
        ),
    ],
)
def test_a_changed_certificate_is_refused(library: Path, name: str, old: str, new: str) -> None:
    text = to_coq(name)
    assert old in text
    good, printed = _compile(library, "changed", text.replace(old, new))
    assert not good
    assert "Unable to unify" in printed or "Error" in printed


@needs_coq
@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("explicit : nth (length roots) beta 0 = 0", "explicit : True"),  # the implicit midpoint
        ("symmetric : rev beta = beta", "symmetric : True"),  # Adams and Bashforth's methods
    ],
)
def test_without_a_hypothesis_the_theorem_on_explicit_halves_is_not_proved(library, old, new):
    text = (library / "Explicit.v").read_text(encoding="utf-8")
    assert text.count(old) == 1
    assert not _compile(library, "weaker", text.replace(old, new))[0]


def test_the_command_writes_a_file(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "glmref.prove.coq", "euler", "--output", str(tmp_path)]
    assert subprocess.run(command, check=False).returncode == 0
    assert "Theorem m_euler_order_1" in (tmp_path / "m_euler.v").read_text(encoding="utf-8")


def test_a_method_with_decimals_is_refused_in_one_sentence(capsys):
    from glmref.prove.coq import main

    assert main(["s3-w3"]) == 2
    assert "decimal coefficients" in capsys.readouterr().err
