"""What goes wrong around the commands ends in a sentence and an exit code, and loses no result."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace

import pytest

from glmref.cli import main
from glmref.cli.parallel import Checked, check, check_all
from glmref.findings import Finding, Verdict
from glmref.prove import verifier as verification
from glmref.system import process
from glmref.system.process import within

COMMAND = [sys.executable, "-m", "glmref"]
posix = pytest.mark.skipif(os.name != "posix", reason="uses POSIX signals and devices")


def shell(script: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["sh", "-c", script.replace("glmref", " ".join(COMMAND))],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env={**os.environ, **environment},
    )


def broken(name: str, **options: object) -> list[Finding]:
    if name == "euler":
        raise RuntimeError("the\nsky\x1b fell")
    return [Finding(name, "order", 4, Verdict.HOLDS, 4)]


def test_an_unexpected_exception_is_one_sentence_and_exit_3(monkeypatch, cli):
    monkeypatch.setattr(verification, "verify_file", broken)
    out, err = cli("verify", "rk4", "euler", "gauss-2", "--format", "json", code=3)
    assert [f["method"] for f in json.loads(out)["findings"]] == ["rk4", "gauss-2"]
    assert err.count("\n") == 1
    assert err.startswith("glmref: internal error while checking euler (RuntimeError: the sky")
    assert "please report it" in err
    monkeypatch.setenv("GLMREF_DEBUG", "1")
    assert "Traceback" in cli("verify", "euler", code=3).err


def test_an_exception_outside_any_file_is_one_sentence_too(monkeypatch, cli):
    from glmref.catalogue import lookup as catalogue

    def fail(name: object) -> None:
        raise ZeroDivisionError("of the program")

    monkeypatch.setattr(catalogue, "load", fail)
    err = cli("show", "rk4", code=3).err
    assert err.count("\n") == 1
    assert "internal error (ZeroDivisionError: of the program)" in err
    monkeypatch.setenv("GLMREF_DEBUG", "1")
    assert "Traceback" in cli("show", "rk4", code=3).err


@pytest.mark.slow
@posix
def test_a_reader_that_goes_away_is_no_error() -> None:
    done = shell("glmref list | head -n 1")
    assert done.returncode == 0
    assert done.stderr == ""
    assert done.stdout.startswith("name")
    status = shell("{ glmref list --format json; echo $? >&2; } | head -c 10").stderr
    assert status.strip() in ("0", "141")


@pytest.mark.slow
@posix
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_one_sentence() -> None:
    done = shell("glmref list > /dev/full")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("glmref: the system refused (No space left on device)")


@pytest.mark.slow
@posix
def test_closed_streams_do_no_harm() -> None:
    assert shell("glmref list >&-").returncode == 0
    done = shell("glmref check - <&-")  # was an internal error
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "the standard input is empty" in done.stderr
    assert shell("glmref verify nothing 2>&-").returncode == 2


@pytest.mark.slow
def test_an_ascii_terminal_gets_ascii_rules_and_no_encoding_error() -> None:
    done = shell("glmref show stormer-verlet", PYTHONIOENCODING="ascii", PYTHONUTF8="0")
    assert done.returncode == 0
    assert done.stdout.isascii()
    assert " ---+--" in done.stdout


@pytest.mark.slow
@posix
def test_a_folder_that_is_gone_is_said_where_processes_are_asked_for(tmp_path: Path) -> None:
    done = shell(f"mkdir {tmp_path}/x; cd {tmp_path}/x; rmdir ../x; glmref verify rk4 --on local:1")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "the current folder, and that cannot be entered" in done.stderr


@pytest.mark.sampled(1)
@posix
@pytest.mark.parametrize("encoding", ["ascii", "utf-16"])
def test_the_standard_input_is_utf_8_whatever_the_terminal_has(encoding: str) -> None:
    table = r'{"name": "Störmer", "A": [[0]], "b": [1], "order": 1}'
    done = shell(
        f"echo '{table}' | glmref check - > /dev/null", PYTHONIOENCODING=encoding, PYTHONUTF8="0"
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("form", ["json", "junit", "csv", "table"])
def test_interruption_keeps_what_was_found_and_leaves_with_130(form, monkeypatch, cli):
    def interrupted(name: str, **options: object) -> list[Finding]:
        if name == "gauss-2":
            raise KeyboardInterrupt
        return [Finding(name, "order", 4, Verdict.HOLDS, 4)]

    monkeypatch.setattr(verification, "verify_file", interrupted)
    out, err = cli("verify", "rk4", "euler", "gauss-2", "rk38", "--format", form, code=130)
    assert err == "glmref: interrupted after 2 of 4 files\n"
    assert "rk4" in out
    assert "euler" in out
    assert "rk38" not in out
    if form == "json":
        assert json.loads(out)["summary"]["holds"] == 2


def test_ctrl_c_is_heard_where_there_are_no_other_signals(monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    monkeypatch.setattr(process, "os", SimpleNamespace(name="nt"))
    try:
        with pytest.raises(KeyboardInterrupt), process.signals("glmref"):
            signal.raise_signal(signal.SIGINT)
        assert not heard
        signal.raise_signal(signal.SIGINT)
        assert heard == [signal.SIGINT]
    finally:
        process._received.clear()
        signal.signal(signal.SIGINT, before)


@pytest.mark.slow
@posix
def test_a_caller_that_ignores_its_children_changes_nothing() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "glmref", "--time-limit", "60", "list"],
        preexec_fn=lambda: signal.signal(signal.SIGCHLD, signal.SIG_IGN),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow
@posix
def test_ctrl_c_reaches_the_program_once_and_no_child_complains() -> None:
    process = subprocess.Popen(
        [*COMMAND, "verify", "--no-cache"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # so that the signal reaches the children, as Ctrl-C does
    )
    first = process.stdout.readline()  # the whole takes some 5 s more
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert first.startswith("  holds")
    assert err.startswith("glmref: interrupted after ")
    assert err.count("\n") == 1
    assert "0 fail, 0 open" in out


#: The program that is limited; it says itself that its time is over, as on any machine.
LIMITED = """
import atexit, os, signal, sys, time
from collections import deque
from itertools import repeat
from glmref.system import process
from glmref.system.process import guarded, limited_by_parent

process.GRACE = 0.4

def over():
    print("found", flush=True)
    os.kill(os.getppid(), signal.SIGUSR1)

def endless():
    over()
    deque(repeat(0), maxlen=0)  # no handler runs, and no other thread meanwhile

def slow():
    over()
    time.sleep(60)

def lingering():  # the interpreter takes long to end
    atexit.register(time.sleep, 60)
    slow()

assert limited_by_parent()
sys.exit(guarded("glmref", {program}, 2))
"""
#: The program that limits it.
LIMITS = """
import signal, subprocess, sys
from glmref.system import process

process.GRACE = 0.4
wait = subprocess.Popen.wait

def over(number, frame):
    raise subprocess.TimeoutExpired("it", 900)

def waited(child, timeout=None):
    if timeout == 900:
        signal.signal(signal.SIGUSR1, over)
    return wait(child, timeout)

subprocess.Popen.wait = waited
signal.signal(signal.SIGUSR1, signal.SIG_IGN)
sys.exit(process.within("glmref", 900, [sys.executable, "-c", sys.argv[1]]))
"""


def limited(program: str, parent: str = LIMITS) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", parent, LIMITED.replace("{program}", program)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


@pytest.mark.sampled(1)
@posix
@pytest.mark.parametrize("program", ["endless", "slow", "lingering"])
def test_a_time_limit_ends_what_cannot_be_stopped_in_one_sentence(program: str) -> None:
    done = limited(program)
    assert (done.returncode, done.stdout, done.stderr) == (
        2, "found\n", "glmref: the time limit is over; what was finished is printed or kept\n",
    )  # fmt: skip


@posix
def test_a_signal_before_the_program_is_waited_for_is_passed_on() -> None:
    early = LIMITS.replace(
        "sys.exit(",
        "start = subprocess.Popen.__init__\n"
        "def late(*given, **more):\n"
        "    signal.raise_signal(signal.SIGTERM)\n    start(*given, **more)\n"
        "subprocess.Popen.__init__ = late\n"
        "sys.exit(",
    )
    assert limited("slow", early).returncode == 143


@pytest.mark.slow
@posix
def test_a_program_whose_parent_is_killed_ends_all_the_same() -> None:
    """Also one that reacts to no signal."""
    environment = {**os.environ, process.LIMITED: "0.1"}
    begun = time.monotonic()
    script = LIMITED.replace("{program}", "lambda: deque(repeat(0), maxlen=0)")
    done = subprocess.run([sys.executable, "-c", script], env=environment, check=False, timeout=60)
    assert done.returncode == 1 and time.monotonic() - begun > 1.2


@pytest.mark.slow
@posix
def test_a_time_limit_changes_nothing_else(capfd: pytest.CaptureFixture[str]) -> None:
    assert within("glmref", 60, [sys.executable, "-c", "raise SystemExit(3)"]) == 3
    script = LIMITED.replace("{program}", "slow").replace("SIGUSR1", "SIGTERM")
    assert within("glmref", 60, [sys.executable, "-c", script]) == 143
    assert capfd.readouterr() == ("found\n", "glmref: ended by SIGTERM\n")
    assert main(["--time-limit", "60", "verify", "rk4", "--no-cache"]) == 0
    assert "10 hold" in capfd.readouterr().out
    for wrong in ("0", "x", "nan", "1e3"):
        assert main(["--time-limit", wrong, "verify", "rk4"]) == 2
    assert capfd.readouterr().err.count("'--time-limit'") == 4


@pytest.mark.slow
def test_no_progress_and_no_colour_off_a_terminal() -> None:
    done = shell("glmref verify euler rk4 rk38 heun-2 heun-3 ab-1 ab-2 ab-3 am-1 am-2 bdf-1")
    assert done.returncode == 0
    assert done.stderr == ""
    assert "\x1b" not in done.stdout


@pytest.mark.slow
@posix
def test_a_terminal_gets_colour_and_progress_and_no_color_is_respected() -> None:
    import fcntl
    import pty
    import struct
    import termios

    def seen(**environment: str) -> bytes:
        parent, child = pty.openpty()
        fcntl.ioctl(child, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        names = ["euler", "rk4", "rk38", "heun-2", "heun-3", "ab-1", "ab-2", "ab-3", "am-1"]
        process = subprocess.Popen(
            [*COMMAND, "verify", *names],
            stdout=child,
            stderr=child,
            env={**os.environ, "TERM": "xterm", **environment},
        )
        os.close(child)
        parts = []
        while True:
            try:
                part = os.read(parent, 4096)
            except OSError:  # how Linux ends a terminal
                break
            if not part:
                break
            parts.append(part)
        assert process.wait(timeout=30) == 0
        os.close(parent)
        return b"".join(parts)

    assert b"\x1b[32mholds" in seen(NO_COLOR="")
    text = seen(NO_COLOR="1")
    assert b"\x1b[32m" not in text
    assert b"/9 [" in text  # the bar


@pytest.mark.slow
def test_results_come_in_order_whether_in_one_process_or_in_several(monkeypatch):
    from glmref.cli import parallel

    names = ["euler", "no-such-method", "rk4", "gauss-2", "ab-2", "rkf45-3554"]
    alone = list(check_all(names, on="here"))
    monkeypatch.setattr(parallel, "STARTUP", 0.0)  # processes pay at once
    monkeypatch.setattr(parallel, "cores", lambda: [0, 1])
    spread = list(check_all(names))
    assert [c.name for c in spread] == names
    assert [c.error for c in spread] == [c.error for c in alone]
    for x, y in zip(spread, alone, strict=True):
        assert [f.as_json() for f in x.findings] == [f.as_json() for f in y.findings]


def killed(task: Mapping[str, str]) -> Checked:
    if task["name"] == "rk4":
        os.kill(os.getpid(), signal.SIGKILL)
    return check(task["name"])


@pytest.mark.slow
def test_a_file_that_kills_its_process_costs_only_its_own_result() -> None:
    names = ["euler", "ab-2", "rk4", "gauss-2"]
    results = list(check_all(names, on="local:2", function=killed))
    assert [c.name for c in results] == names
    assert [c.internal for c in results] == [False, False, True, False]
    assert "internal error while checking rk4" in results[2].error


@posix
@pytest.mark.slow
def test_tests_that_run_in_the_background_can_interrupt_programs(tmp_path: Path) -> None:
    """A shell has what it starts with ``&`` ignore Ctrl-C, and then no program was interrupted."""
    test = tmp_path / "test_signal.py"
    test.write_text(
        "import signal\n"
        "def test(): assert signal.getsignal(signal.SIGINT) is signal.default_int_handler\n"
    )
    conftest = Path(__file__).parents[1] / "conftest.py"
    (tmp_path / "conftest.py").write_text(conftest.read_text(encoding="utf-8"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(test)],
        capture_output=True, text=True, timeout=60, check=False, cwd=tmp_path,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
