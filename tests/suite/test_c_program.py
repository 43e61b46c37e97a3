"""A C program of under 100 lines reads the vectors, runs the corrected (3.8) and takes part."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from glmref.catalogue.lookup import data_root
from glmref.conformance.adapter import load_adapter
from glmref.conformance.checks import Suite
from glmref.conformance.identify import identify
from glmref.conformance.subject import Subject
from glmref.errors import UsageError
from glmref.findings import Verdict

SOURCE = Path(__file__).parent / "c_program" / "glm.c"
pytestmark = pytest.mark.compiler


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler")
    path = tmp_path_factory.mktemp("c") / "glm"
    command = [compiler, "-O1", "-Wall", "-Wextra", "-o", str(path), str(SOURCE), "-lm"]
    subprocess.run(command, check=True)
    return path


def adapter(program: Path, method: str) -> Subject:
    vectors = data_root() / "vectors" / f"{method}.json"
    return Subject(load_adapter(f"cmd:{program} '{vectors}'"))


def test_the_program_has_less_than_100_lines() -> None:
    assert len(SOURCE.read_text(encoding="utf-8").splitlines()) < 100


@pytest.mark.parametrize("method", ["thesis-3-8", "rk4"])
def test_every_check_of_the_method_holds_for_the_program(program: Path, method: str) -> None:
    subject = adapter(program, method)
    try:
        findings = Suite(subject).findings()
    finally:
        subject.close()
    claims = {x.claim.partition("/")[0] for x in findings}
    assert [x for x in findings if x.verdict is not Verdict.HOLDS] == []
    assert {"stages", "step", "abscissae", "backward", "trajectory", "order4"} <= claims


def test_the_program_is_read_as_the_method_it_runs(program: Path) -> None:
    subject = adapter(program, "thesis-3-8")
    try:
        (probe,) = identify(subject)
    finally:
        subject.close()
    assert probe.matches[0].name == "thesis-3-8" and probe.matches[0].difference < 1e-14


def test_a_program_that_cannot_read_its_file_is_a_bad_adapter(program: Path) -> None:
    with pytest.raises(UsageError, match=r"ended without an answer \(exit code 1\)"):
        load_adapter(f"cmd:{program} /no/such/file")
