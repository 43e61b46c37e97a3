"""A short C program reads any vector file, runs the methods it says it runs, and takes part."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from glmref.catalogue.lookup import data_root
from glmref.conformance.adapter import load_adapter
from glmref.conformance.checks import Suite
from glmref.conformance.identify import identify
from glmref.conformance.subject import Subject
from glmref.conformance.vectors import file_names, vectors_of
from glmref.errors import UsageError
from glmref.findings import Verdict
from glmref.problems import Problem

SOURCE = Path(__file__).parent / "c_program" / "glm.c"
#: A read or write outside of an array, or a division by zero, ends the program.
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
pytestmark = pytest.mark.compiler
PARTITIONED = "a partitioned method: this program runs single methods"
IMPLICIT = "a stage needs later ones: they are to be solved together"
REFUSED = {
    **dict.fromkeys(("forest-ruth-4", "lobatto-iiia-iiib-3", "pair-4-4"), PARTITIONED),
    **dict.fromkeys(("stormer-verlet", "symplectic-euler-a"), PARTITIONED),
    **dict.fromkeys(("gauss-2", "gauss-3", "radau-iia-2", "radau-iia-3"), IMPLICIT),
}


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler")
    path = tmp_path_factory.mktemp("c") / "glm"
    command = [compiler, "-O1", "-g", "-Wall", "-Wextra", "-Werror", *SANITIZE]
    words = ["-o", str(path), str(SOURCE), "-lm"]
    empty = path.with_name("empty.c")
    empty.write_text("int main(void) { return 0; }\n")
    try_out = [*command, "-o", str(path), str(empty)]
    if subprocess.run(try_out, capture_output=True, check=False).returncode:
        pytest.skip("the C compiler has no sanitizers")
    subprocess.run([*command, *words], check=True)
    return path


def adapter(program: Path, method: str) -> Subject:
    vectors = data_root() / "vectors" / f"{method}.json"
    return Subject(load_adapter(f"cmd:{program} '{vectors}'"))


def test_the_program_is_as_short_as_the_page_says() -> None:
    assert len(SOURCE.read_text(encoding="utf-8").splitlines()) < 130
    page = SOURCE.parents[3] / "docs" / "adapters.md"
    assert "in less than 130 lines" in page.read_text(encoding="utf-8")


def test_what_is_refused_is_what_the_page_says() -> None:
    """Pairs, and methods with an entry of A above the diagonal."""
    for name in file_names():
        blocks = vectors_of(name).document["coefficients"]
        above = [float(x) for i, row in enumerate(blocks.get("A", ())) for x in row[i + 1 :]]
        wanted = PARTITIONED if "q" in blocks else IMPLICIT if any(above) else None
        assert REFUSED.get(name) == wanted, name


@pytest.mark.slow
@pytest.mark.sampled(2)
@pytest.mark.parametrize("method", [x for x in file_names() if x not in REFUSED])
def test_every_check_of_the_method_holds_for_the_program(program: Path, method: str) -> None:
    subject = adapter(program, method)
    try:
        findings = Suite(subject).findings()
    finally:
        subject.close()
    claims = {x.claim.partition("/")[0] for x in findings}
    order = vectors_of(method).method.claims["order"]
    assert [x for x in findings if x.verdict is not Verdict.HOLDS] == []
    assert {"stages", "step", "abscissae", "backward", "trajectory", f"order{order}"} <= claims


@pytest.mark.sampled(1)
@pytest.mark.parametrize("method", REFUSED)
def test_a_method_that_is_not_served_is_refused_with_a_sentence(program: Path, method: str) -> None:
    with pytest.raises(UsageError, match=REFUSED[method]):
        adapter(program, method)


@pytest.mark.sampled(1, besides=("300",))
@pytest.mark.parametrize("steps", [1, 9, 300])
def test_a_method_of_any_size_is_run(program: Path, tmp_path: Path, steps: int) -> None:
    """Euler's method, `steps` times over, as one method; its start has as many stages."""
    A = [["0"] * steps for _ in range(steps)]
    for i in range(steps):
        A[i][:i] = ["1"] * i
    document = {
        "format": "glmref-vectors-1", "method": "euler",
        "coefficients": {
            "A": A, "U": [["1"]] * steps, "B": [["1"] * steps], "V": [["1"]],
            "c": [str(i) for i in range(steps)],
            "starting": {"A": A, "B": [["1"] * steps], "u": ["1"]},
        },
    }  # fmt: skip
    file = tmp_path / "euler.json"
    file.write_text(json.dumps(document, indent=1), encoding="utf-8")
    size = 1000
    problem = Problem(
        name="decay", f=lambda t, y: -y, jacobian=lambda t, y: -np.eye(size),
        y0=[1.0] * size, t_span=(0.0, 1.0),
    )  # fmt: skip
    subject = Subject(load_adapter(f"cmd:{program} {file}"))
    try:
        begun = subject.start("euler", problem, 0.001, (1, size))
        taken = subject.step("euler", problem, 0.0, begun, 0.001)
    finally:
        subject.close()
    assert begun == pytest.approx(0.999**steps, rel=1e-12)
    assert taken == pytest.approx(0.999 ** (2 * steps), rel=1e-12)


@pytest.mark.slow
def test_the_program_is_read_as_the_method_it_runs(program: Path) -> None:
    subject = adapter(program, "thesis-3-8")
    try:
        (probe,) = identify(subject)
    finally:
        subject.close()
    assert probe.matches[0].name == "thesis-3-8" and probe.matches[0].difference < 1e-14


@pytest.mark.sampled(1)
@pytest.mark.parametrize("content", [None, "", "{}", "[1, 2, 3]", '{"c": ["1"], "A": [["0"]]}'])
def test_a_file_that_is_no_vector_file_is_refused(program, tmp_path, content):
    file = tmp_path / "vectors.json"
    if content is not None:
        file.write_text(content, encoding="utf-8")
    with pytest.raises(UsageError, match=r"cannot be read|no vector file of a method"):
        load_adapter(f"cmd:{program} {file}")
