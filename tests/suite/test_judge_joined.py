"""The judge as one file gives the answers of the package, in an interpreter that has nothing else."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from glmref.judge import command
from glmref.judge.join import Source, joined, ordered
from glmref.judge.refusals import Unreadable

from .test_judge import CERTIFICATES, REFUSED, changed


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("joined") / "judge.py"
    path.write_text(joined(), encoding="utf-8")
    return path


def test_the_modules_join_to_one_program(program: Path) -> None:
    compile(program.read_text(encoding="utf-8"), str(program), "exec")


def is_unreadable(case: object) -> bool:
    try:
        command.check(json.dumps(case))
    except Unreadable:
        return True
    return False


@pytest.mark.slow
def test_the_joined_file_answers_as_the_package_does(program: Path, tmp_path: Path) -> None:
    cases = [*CERTIFICATES.values(), *(changed(*x) for x in REFUSED.values())]
    cases = [case for case in cases if not is_unreadable(case)]
    path = tmp_path / "certificates.jsonl"
    path.write_text("\n".join(map(json.dumps, cases)), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-I", "-S", str(program), str(path)],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (1, "")
    expected = [command.check(json.dumps(case)) for case in cases]
    assert {accepted for accepted, _ in expected} == {True, False}
    assert done.stdout.splitlines() == [
        f"{path}: {'yes' if accepted else 'no'}: {sentence}" for accepted, sentence in expected
    ]


@pytest.mark.slow
def test_it_is_written_by_its_command(program: Path, tmp_path: Path) -> None:
    path = tmp_path / "x.py"
    subprocess.run([sys.executable, "-m", "glmref.judge.join", str(path)], check=True)
    assert path.read_text(encoding="utf-8") == program.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("texts", "sentence"),
    [
        ({"a": '"""A."""\nfrom .b import y\nx = 1', "b": '"""B."""\nfrom .a import x\ny = 1'}, "in a cycle"),
        ({"a": '"""A."""\nx = 1', "b": '"""B."""\ndef x(): ...'}, "x is defined in a and in b"),
        ({"a": '"""A."""\nfrom math import gcd', "b": '"""B."""\ndef gcd(): ...'}, "gcd is defined in an import and in b"),
        ({"a": '"""A."""\nfrom .b import y as z'}, "a, line 2: join needs imports by name"),
        ({"a": '"""A."""\nfrom ..exact import y'}, "a, line 2: join needs imports by name"),
    ],
    ids=["cycle", "twice", "imported", "renamed", "outside"],
)  # fmt: skip
def test_modules_that_cannot_be_joined_are_refused(texts: dict[str, str], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        ordered({name: Source(name, text) for name, text in texts.items()})
