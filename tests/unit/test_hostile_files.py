"""Named pipes, devices and folders as inputs and outputs: one sentence, at once, and never a hang."""

import json
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from glmref.cli import main
from glmref.conformance.expected_failures import read_known_failures
from glmref.errors import DataError, UsageError
from glmref.judge.command import main as judge_main
from glmref.report import read
from glmref.system.files import read_bytes, write_bytes
from tests.build import refused

pytestmark = pytest.mark.skipif(os.name != "posix", reason="uses named pipes and devices")


@pytest.fixture(autouse=True)
def limit() -> Iterator[None]:
    """Nothing here may wait for a writer or read a device to its end."""

    def hang(number: int, frame: object) -> None:
        raise TimeoutError("it hangs")

    before = signal.signal(signal.SIGALRM, hang)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(params=["pipe", "device", "folder"])
def odd(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Something that is no regular file, under a name that every reader takes."""
    path = tmp_path / "odd.json"
    if request.param == "pipe":
        os.mkfifo(path)
    elif request.param == "folder":
        path.mkdir()
    else:
        path.symlink_to("/dev/zero")
    return path


def test_no_command_reads_what_is_no_file(odd: Path, monkeypatch: pytest.MonkeyPatch, cli) -> None:
    monkeypatch.chdir(odd.parent)
    odd.rename("odd.toml")
    for command in ("verify", "show", "run", "derive"):
        captured = cli(command, "odd.toml", code=2)
        assert captured.out == "" and captured.err.count("\n") == 1 and "odd.toml" in captured.err


@pytest.mark.parametrize("suffix", ["sqlite", "jsonl"])
def test_a_report_passes_over_what_is_no_file(suffix: str, odd: Path, tmp_path: Path) -> None:
    if odd.is_dir():
        pytest.skip("a folder is searched")
    odd.rename(tmp_path / f"odd.{suffix}")
    ((where, why),) = read([tmp_path]).odd
    assert where == f"odd.{suffix}" and "a regular file is needed" in why


def test_links_to_the_folders_above_are_not_followed(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to(".")
    (tmp_path / "b").symlink_to(".")  # 2^40 paths
    (tmp_path / "x.json").symlink_to("x.json")
    ((where, why),) = read([tmp_path]).odd
    assert where == "x.json" and "symbolic links" in why


def test_a_device_is_no_result(tmp_path: Path) -> None:
    ((where, why),) = read([Path("/dev/zero")]).odd
    assert why == "it is neither a file nor a folder"


def test_a_named_pipe_is_no_tableau_and_no_certificate(tmp_path, capsys):
    os.mkfifo(tmp_path / "x")
    (tmp_path / "link").symlink_to("x")
    (tmp_path / "loop").symlink_to("loop")
    for name in ("x", "link", "loop"):
        for read_it, given in ((main, ["check"]), (judge_main, [])):
            assert read_it([*given, str(tmp_path / name)]) == 2
            captured = capsys.readouterr()
            assert captured.out == "" and captured.err.count("\n") == 1
            assert ("named pipe" in captured.err) == (name != "loop")


def test_a_named_pipe_is_no_function_of_a_scene(tmp_path, capsys):
    os.mkfifo(tmp_path / "mine.py")
    (tmp_path / "s.toml").write_text(
        'format = "glmref-scene-1"\nname = "s"\ntitle = "t"\nquestion = "q"\n'
        'methods = ["rk4"]\nsteps = [20]\nt_end = 1\nask = ["state"]\n'
        '[problem]\nfile = "mine.py:make"\n[answer]\nkind = "ended"\n'
    )
    assert main(["run", str(tmp_path / "s.toml"), "--plan"]) == 2
    assert "`problem.file` must be like" in capsys.readouterr().err


def test_known_failures_are_a_file(odd: Path) -> None:
    refused(UsageError, "cannot be read", read_known_failures, odd, ["x"])


@pytest.mark.parametrize("suffix", ["sqlite", "jsonl"])
def test_a_record_file_is_a_file(suffix, tmp_path, capsys):
    os.mkfifo(tmp_path / f"oscillator-quick.{suffix}")
    assert main(["run", "oscillator", "--quick", "--output", str(tmp_path)]) == 2
    assert "it is a named pipe, and a regular file is needed" in capsys.readouterr().err


def test_a_file_that_grows_while_it_is_read_is_bounded(tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(b"x" * 1000)
    assert len(read_bytes(path, 1000)) == 1000
    refused(DataError, "has 1000 bytes and at most 999 are read", read_bytes, path, 999)
    if Path("/proc/kallsyms").exists():  # its size is said to be 0
        refused(DataError, "larger than 100 bytes", read_bytes, Path("/proc/self/maps"), 100)


# --- outputs --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("file", "file"),
        ("file/below", "is a file"),
        ("file/below/it", "is a file"),
        ("/proc/nothing/x", "cannot be made"),
        ("/dev/null/x", "is a device"),
        ("n" * 300, "File name too long"),
    ],
)
@pytest.mark.parametrize("command", ["run", "derive", "report", "report --single-file"])
def test_an_output_that_cannot_be_is_named(
    command: str, place: str, words: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    (tmp_path / "file").write_text("kept", encoding="utf-8")
    (tmp_path / "in").mkdir()
    finding = {"method": "rk4", "claim": "order", "verdict": "holds", "declared": 4}
    findings = {"format": "glmref-findings-1", "findings": [finding]}
    (tmp_path / "in" / "found.json").write_text(json.dumps(findings), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("glmref.cli.reporting.PLACE", Path("in"))
    # a page of each method would take seconds, and none is to be written
    monkeypatch.setattr(sys.modules["glmref.report.build"], "pages_of", lambda *_, **__: [])
    monkeypatch.setattr("glmref.report.markup.Site.document", lambda *_, **__: "new")
    arguments = {
        "run": ["run", "oscillator", "--quick"],
        "derive": ["derive", "two-stage"],
        "report": ["report"],
        "report --single-file": ["report", "--single-file"],
    }[command]
    if command == "report --single-file" and place == "file":
        pytest.skip("a file is what it asks for")
    code = main([*arguments, "--output", place])
    captured = capsys.readouterr()
    assert code == 2, captured
    assert captured.err.count("\n") == 1 and words in captured.err
    named = place.rpartition("/")[0] or place  # a file's folder, or the place itself
    assert named[:40] in captured.err and "Traceback" not in captured.err
    assert (tmp_path / "file").read_text(encoding="utf-8") == "kept"


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_no_device_is_replaced_by_a_file(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "x"
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/null")
    refused(UsageError, "name a regular file to write", write_bytes, path, b"x")
    assert not Path("/dev/null").is_file()


def test_a_file_is_replaced_in_one_piece_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "x"
    path.write_bytes(b"old")
    path.chmod(0o640)
    link = tmp_path / "link"
    link.symlink_to(path)

    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(UsageError, match=r"cannot be written \(No space left on device\)"):
            write_bytes(path, b"new")
    assert path.read_bytes() == b"old"
    write_bytes(link, b"new")
    assert link.is_symlink() and path.read_bytes() == b"new"
    assert path.stat().st_mode & 0o777 == 0o640
    assert sorted(x.name for x in tmp_path.iterdir()) == ["link", "x"]
