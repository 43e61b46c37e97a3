"""What a user's file asks is answered in time, also where one operation never returns."""

import ctypes
import json
import os
import signal
import sys
import time
from collections import deque
from collections.abc import Callable
from importlib import import_module
from itertools import repeat
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
from flint import fmpq

from glmref.catalogue import lookup
from glmref.cli import main
from glmref.cli.certifying import write_certificates
from glmref.errors import DataError
from glmref.exact.field import MINIMAL
from glmref.prove import analysis, verifier
from glmref.system import process
from glmref.system.process import OVER, Say, apart
from tests.build import SOURCE

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that fork")

SPENT = "the budget of 0.05 s of processor time is spent within one operation"


def computes(*_: object) -> Any:
    deque(repeat(0), maxlen=0)  # as an operation of a library: it hears no signal


def sleeps(*_: object) -> Any:
    ctypes.PyDLL(None).sleep(1000)  # holds the interpreter, and takes no processor time


@pytest.fixture(autouse=True)
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "EXCESS", 0.1)
    monkeypatch.setattr(process, "CLOCK", 40.0)  # of a machine with many other processes


def written(folder: Path, **keys: object) -> str:
    doc = {
        "format": "glmref-method-1", "name": "heun", "class": "rk",
        "A": [["0", "0"], ["1", "0"]], "b": ["1/2", "1/2"],
        "claims": {"order": 2, "symplectic": True, "explicit": True},
        "source": SOURCE, **keys,
    }  # fmt: skip
    path = folder / "heun.json"
    path.write_text(json.dumps(doc))
    return str(path)


# --- a program apart ------------------------------------------------------------------------------


def test_what_a_program_says_apart_is_heard() -> None:
    here = os.getpid()

    def program(say: Say) -> None:
        for message in (None, {"x": [1, "é\ud800", float("inf")]}, os.getpid() == here):
            say(message, None)

    said = apart(program, 60)
    assert said.messages == [None, {"x": [1, "é\ud800", float("inf")]}, False]
    assert said.ended == ""


@pytest.mark.parametrize(("what", "clock"), [(computes, 40.0), (sleeps, 2.0)])
def test_an_operation_that_does_not_return_is_ended(what, clock, monkeypatch):
    monkeypatch.setattr(process, "CLOCK", clock)

    def program(say: Say) -> None:
        say("begun", 0.05)
        what()

    said = apart(program, 60)
    assert (said.messages, said.ended) == (["begun"], OVER)
    assert str(said.error(0.05)) == SPENT


def test_an_operation_of_flint_is_ended() -> None:
    """The minimal polynomial of a sum of roots, of degree 2520, which takes hours."""
    first, *roots = [MINIMAL(p) ** fmpq(1, n) for p, n in ((2, 5), (3, 7), (5, 8), (7, 9))]

    def program(_: Say) -> None:
        total = first
        for root in roots:
            total = total + root

    assert apart(program, 0.1).ended == OVER


_ON_A_TERMINAL = """
import os, sys, termios
from glmref.system.process import apart
state = termios.tcgetattr(2)
state[3] |= termios.TOSTOP  # as `stty tostop`
termios.tcsetattr(2, termios.TCSANOW, state)
said = apart(lambda say: say(os.write(2, b"working"), None), 5)
os._exit(said.messages != [7])
"""


def test_a_program_apart_may_write_on_a_terminal_that_stops_others() -> None:
    import pty

    child, terminal = pty.fork()
    if not child:
        os.execv(sys.executable, [sys.executable, "-c", _ON_A_TERMINAL])
    try:
        for _ in range(100):
            pid, status = os.waitpid(child, os.WNOHANG)
            if pid:
                break
            time.sleep(0.1)
        else:
            pytest.fail("it waits for ever")
        assert os.waitstatus_to_exitcode(status) == 0
    finally:
        os.close(terminal)  # ends what is left


def test_a_process_that_crashes_is_named() -> None:
    said = apart(lambda _: os.kill(os.getpid(), signal.SIGKILL), 60)
    assert (said.messages, said.ended) == ([], "SIGKILL")
    assert str(said.error(1)) == "the process of the proof was ended by SIGKILL"


def test_a_process_that_ends_by_itself_is_named() -> None:
    """As where the memory does not suffice for an exception."""
    said = apart(lambda _: os._exit(7), 60)
    assert (said.messages, said.ended) == ([], "exit code 7")


class Unsendable(Exception):
    """An error that another process cannot receive."""

    def __reduce__(self) -> Any:
        raise TypeError


@pytest.mark.parametrize(
    ("raised", "kind", "text"),
    [(DataError("no"), DataError, "no"), (MemoryError(), MemoryError, ""),
     (KeyError("x"), KeyError, "'x'"), (Unsendable("y"), RuntimeError, "Unsendable: y")],
)  # fmt: skip
def test_an_exception_apart_is_that_of_the_caller(raised, kind, text):
    def program(_: Say) -> None:
        raise raised

    with pytest.raises(kind) as caught:
        apart(program, 60)
    assert str(caught.value) == text
    if kind is not RuntimeError:
        assert "in program" in caught.value.__notes__[0]


def test_a_program_apart_ends_with_the_work_of_its_caller(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[int] = []
    fork = os.fork

    def noted() -> int:
        started.append(fork())
        return started[-1]

    monkeypatch.setattr(os, "fork", noted)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, interrupted)
    try:

        def program(_: Say) -> None:
            os.kill(os.getppid(), signal.SIGINT)
            computes()

        with pytest.raises(KeyboardInterrupt):
            apart(program, 60)
        with pytest.raises(ProcessLookupError):
            os.kill(started[0], 0)
    finally:
        signal.signal(signal.SIGINT, before)


def test_without_a_process_a_program_runs_here(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused() -> int:
        raise BlockingIOError("no process is to be had")

    monkeypatch.setattr(os, "fork", refused)
    assert apart(lambda say: say(os.getpid(), 1.0), 60) == ([os.getpid()], "", 0.0)


def test_the_processor_time_of_a_program_apart_is_known() -> None:
    def program(_: Say) -> None:
        until = time.process_time() + 0.3
        while time.process_time() < until:
            pass

    assert 0.25 < apart(program, 60).seconds < 2


def test_a_program_apart_has_a_thread_as_caller() -> None:
    found: list[object] = []
    thread = Thread(target=lambda: found.append(apart(lambda say: say(1, 1.0), 60).messages))
    thread.start()
    thread.join(60)  # seen once under 3.13.0: join waited for a thread that had ended
    assert found == [[1]]


# --- what the commands say ------------------------------------------------------------------------


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("what", "why"),
    [
        (computes, f"{SPENT}; a larger --budget may decide it"),
        (lambda: os.kill(os.getpid(), signal.SIGKILL),
         "the process of the proof was ended by SIGKILL"),
    ],
)  # fmt: skip
def test_verify_says_what_was_decided_before_and_that_the_rest_is_open(
    what: Callable[[], object],
    why: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    judged = verifier._check

    def check(facts: Any, claim: str, declared: object, accepted: Any) -> Any:
        return what() if claim == "symplectic" else judged(facts, claim, declared, accepted)

    monkeypatch.setattr(verifier, "_check", check)
    path = written(tmp_path)
    arguments = ["verify", path, "rk4", "--only", "order", "--only", "symplectic"]
    assert main([*arguments, "--budget", "0.05", "--format", "json"]) == 3
    found = json.loads(capsys.readouterr().out)["findings"]
    assert [(x["method"], x["claim"], x["verdict"]) for x in found[:2]] == [
        ("heun", "order", "holds"), ("heun", "symplectic", "open"),
    ]  # fmt: skip
    assert found[1]["witness"] == why
    assert found[2]["method"] == "rk4"


def test_a_refutation_that_does_not_return_is_open(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(verifier, "_refute", computes)
    path = written(
        tmp_path, broken={"claim": "symplectic", "why": "it is explicit", "flag": "", "found": ""}
    )
    assert main(["verify", path, "--budget", "0.05"]) == 3
    assert "OPEN   exact     refutes symplectic" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["verify", "analyze"])
def test_entries_that_are_not_read_in_time_are_refused(command, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(lookup, "load_document", lambda *_, **__: computes())
    monkeypatch.setattr("glmref.cli.parallel.READING", 0.05)
    monkeypatch.setattr(analysis, "READING", 0.05)
    assert main([command, written(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith("glmref: heun.json: the entries take more than 2 s")


@pytest.mark.slow
def test_an_analysis_goes_on_with_the_next_question(tmp_path, monkeypatch, cli):
    path = written(tmp_path)
    whole = json.loads(cli("analyze", path, "--format", "json").out)
    monkeypatch.setattr(process, "EXCESS", 0.5)  # the measurement after the record takes no more
    monkeypatch.setattr(verifier, "PROVING", 4.0)
    monkeypatch.setattr(analysis, "SHARES", 80)
    monkeypatch.setattr(analysis, "STABILITY", 0.05)
    monkeypatch.setattr(analysis, "staircase", computes)
    monkeypatch.setattr(analysis, "real_interval", computes)
    found = json.loads(cli("analyze", path, "--format", "json").out)
    undecided = found.pop("undecided")
    assert set(undecided) == {"staircase", "real interval"}
    assert all("s of processor time is spent within one operation" in x for x in undecided.values())
    assert found.pop("stability_measured")["real"] == pytest.approx(2, abs=1e-6)
    assert found["stability"].pop("real") is None
    assert whole["stability"].pop("real") == 2
    assert found == whole


@pytest.mark.slow
def test_an_analysis_of_questions_without_answers_ends_when_all_is_spent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(verifier, "PROVING", 0.2)
    monkeypatch.setattr(analysis.Facts, "kernel", property(computes))
    assert main(["analyze", written(tmp_path), "--format", "json"]) == 3
    undecided = json.loads(capsys.readouterr().out)["undecided"]
    assert undecided["order"] == SPENT
    assert undecided["abscissae"] == "the budget of 0.2 s of processor time is spent"


def test_check_says_that_nothing_was_decided(tmp_path, monkeypatch, capsys, cli):
    path = tmp_path / "tableau.json"
    path.write_text(json.dumps({"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"], "order": 2}))
    assert main(["check", str(path)]) == 0
    monkeypatch.setattr(import_module("glmref.audit.check"), "examine", computes)
    monkeypatch.setattr("glmref.system.budget.PROVING", 0.05)
    capsys.readouterr()
    assert "within one operation, and nothing was decided" in cli("check", path, code=3).err


@pytest.mark.slow
def test_certificates_of_a_proof_that_does_not_return_are_said_to_be_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cli
) -> None:
    path = written(tmp_path)
    lines = cli("certify", path).out.splitlines()
    assert [json.loads(x)["statement"]["claim"] for x in lines] == [
        "order", "symplectic", "explicit",
    ]  # fmt: skip
    facts_for = verifier.facts_for
    monkeypatch.setattr(
        verifier, "facts_for", lambda x: computes() if x.name == "heun" else facts_for(x)
    )
    monkeypatch.setattr(verifier, "PROVING", 0.05)
    out, err = cli("certify", path, code=3)
    assert (out, err) == ("", f"glmref: {path}: {SPENT}, and no certificate was written\n")
    count, missing = write_certificates([path, "rk4"], tmp_path)
    assert count and missing[0] == f"{path}: {SPENT}"


def test_certificates_of_a_file_that_refutes_what_it_does_not_claim_are_refused(tmp_path, capsys):
    broken = {"claim": "a-stable", "why": "it is explicit", "flag": "", "found": ""}
    assert main(["certify", written(tmp_path, broken=broken)]) == 2
    assert "`broken.claim` names 'a-stable', which is not among" in capsys.readouterr().err
