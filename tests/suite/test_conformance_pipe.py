"""Programs as adapters: JSON lines over a pipe, in both directions."""

import shlex
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glmref import problem
from glmref.conformance.adapter import load_adapter
from glmref.conformance.checks import Suite
from glmref.conformance.subject import AdapterError, Subject
from glmref.errors import UsageError
from glmref.findings import Verdict
from tests.attack.pipes import alive

SERVER = """
import json, sys

def ask(question):
    print(json.dumps(question), flush=True)
    return json.loads(sys.stdin.readline())["values"]

def add(*terms):
    return [sum(c * v[k] for c, v in terms) for k in range(len(terms[0][1]))]

for line in sys.stdin:
    asked = json.loads(line)
    if asked["ask"] == "describe":
        print(json.dumps(DESCRIBE), flush=True)
        continue
    BODY
    print(json.dumps(answer), flush=True)
"""

EULER = """
    n, h, y = asked["columns"] // 2, asked["h"], asked["values"]
    q, p = y[:n], y[n:]
    p = add((1, p), (h, ask({"ask": "dp", "q": q})))
    q = add((1, q), (h, ask({"ask": "dq", "p": p})))
    answer = {"values": q + p}
"""
GAUSS = """
    a = [[1 / 4, 1 / 4 - 3**0.5 / 6], [1 / 4 + 3**0.5 / 6, 1 / 4]]
    t, h, y = asked["t"], asked["h"], asked["values"]
    Y = [y, y]
    for _ in range(60):
        F = [ask({"ask": "f", "t": t + sum(a[i]) * h, "y": Y[i]}) for i in range(2)]
        before, Y = Y, [add((1, y), (h * a[i][0], F[0]), (h * a[i][1], F[1])) for i in range(2)]
        if Y == before:
            break
    end = add((1, y), (h / 2, F[0]), (h / 2, F[1]))
    answer = {"values": end if asked["ask"] == "step" else Y[0] + Y[1]}
"""


def program(folder: Path, describe: dict[str, Any], body: str) -> str:
    path = folder / "server.py"
    text = SERVER.replace("DESCRIBE", repr(describe)).replace("    BODY\n", body)
    path.write_text(text, encoding="utf-8")
    return f"cmd:{shlex.quote(sys.executable)} {shlex.quote(str(path))}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "offers", "body"),
    [("symplectic-euler-a", ["step"], EULER), ("gauss-2", ["step", "stages"], GAUSS)],
)
def test_a_program_that_is_right_passes(tmp_path: Path, method: str, offers: list[str], body: str):
    describe = {"methods": [method], "offers": offers}
    with closing(Subject(load_adapter(program(tmp_path, describe, body)))) as subject:
        findings = Suite(subject).findings()
    assert len(findings) >= 10
    assert [x for x in findings if x.verdict is not Verdict.HOLDS] == []


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("    answer = {'error': 'out of memory'}\n", "out of memory"),
        ("    answer = {'values': [1.0]}\n", "2 numbers were expected"),
        ("    answer = {'value': [1.0]}\n", "must have 'values'"),
        ("    answer = [1.0]\n", "is not a JSON object"),
        ("    print('hello', flush=True); continue\n", "is not JSON"),
        (
            '    print(\'{"values": [1], "values": [2]}\', flush=True); continue\n',
            "gives a key of its answer twice",
        ),
        ("    answer = {'values': ['1.0', '2.0']}\n", "must be a list of numbers"),
        ("    answer = {'values': [True, False]}\n", "must be a list of numbers"),
        ("    ask({'ask': 'f', 't': 0, 'y': ['1', '2']}); answer = {}\n", "cannot be served"),
        ("    sys.exit(3)\n", "exit code 3"),
        ("    ask({'ask': 'hamiltonian'}); answer = {}\n", "may ask f, jacobian, dq or dp"),
        ("    ask({'ask': 'f', 'y': [1.0]}); answer = {}\n", "cannot be served"),
    ],
)
def test_a_program_that_misbehaves_fails_with_a_sentence(tmp_path: Path, body: str, words: str):
    subject = Subject(
        load_adapter(program(tmp_path, {"methods": ["rk4"], "offers": ["step"]}, body))
    )
    try:
        suite = Suite(subject)
        (first,) = [x for x in suite.checks if x.id == "answer/rk4/linear"]
        finding = suite.finding(first)
    finally:
        subject.close()
    assert finding.verdict is Verdict.FAILS and words in finding.witness


CRASHES = """
    if asked["columns"] == 4:
        KEPLER
"""


@pytest.mark.parametrize(
    ("kepler", "words"),
    [
        ("import os; os.abort()", "killed by SIGABRT"),
        ("print('halfway'); sys.exit(0)", "b'halfway' is not JSON; stdout is for answers"),
        ("print('{}{}', flush=True)", "is not JSON"),
        ("print(json.dumps({'values': 'many'}), flush=True)", "must be a list of numbers"),
    ],
)
def test_a_program_that_fails_once_is_started_again_for_the_other_checks(tmp_path, kepler, words):
    describe = {"methods": ["symplectic-euler-a"], "offers": ["step"]}
    body = CRASHES.replace("KEPLER", kepler) + EULER
    with closing(Subject(load_adapter(program(tmp_path, describe, body)))) as subject:
        found = {x.claim: x for x in Suite(subject).findings()}
    failed = [name for name, x in found.items() if x.verdict is Verdict.FAILS]
    assert failed == ["step/symplectic-euler-a/kepler"]
    assert words in found[failed[0]].witness
    assert found["step/symplectic-euler-a/pendulum"].verdict is Verdict.HOLDS


def test_an_answer_that_comes_late_is_not_that_to_the_next_question(tmp_path: Path) -> None:
    body = """
    answer = {"values": [x + 1 for x in asked["values"]]}
    print(json.dumps({"values": [7.0, 7.0]}), flush=True)
    import time; time.sleep(0.1)
"""
    describe = {"methods": ["rk4"], "offers": ["step"]}
    with closing(Subject(load_adapter(program(tmp_path, describe, body)))) as subject:
        told = []
        for _ in range(2):
            try:
                subject.step("rk4", problem("harmonic-oscillator"), 0.0, np.ones((1, 2)), 0.125)
            except AdapterError as error:
                told.append(str(error))
            time.sleep(0.3)
    assert len(told) == 1 and "without being asked" in told[0]


@pytest.mark.slow
def test_a_program_that_hangs_is_ended_and_after_three_times_not_asked_again(tmp_path, monkeypatch):
    describe = {"methods": ["rk4"], "offers": ["step"]}
    adapter = load_adapter(program(tmp_path, describe, "    import time; time.sleep(60)\n"))
    monkeypatch.setattr("glmref.conformance.pipe.PATIENCE", 0.5)
    subject = Subject(adapter)
    messages = []
    try:
        for check in [x for x in Suite(subject).checks if x.claim == "step"]:
            with pytest.raises(AdapterError) as caught:
                check.judge()
            messages.append(str(caught.value))
    finally:
        subject.close()
    assert all("did not answer within 0.5 seconds" in x for x in messages[:3])
    assert "not asked any more: it was silent 3 times" in messages[3]
    assert adapter.process.poll() is not None


@pytest.mark.slow
def test_what_a_program_cannot_do_is_not_judged(tmp_path: Path) -> None:
    body = (
        "    if asked['ask'] == 'stages':\n        answer = {'cannot': 'no stages'}\n"
        "    else:\n" + "".join(f"    {x}\n" for x in GAUSS.splitlines())
    )
    describe = {"methods": ["gauss-2"], "offers": ["step", "stages"]}
    wanted = {"stages/gauss-2/cubic": Verdict.OPEN, "step/gauss-2/cubic": Verdict.HOLDS}
    with closing(Subject(load_adapter(program(tmp_path, describe, body)))) as subject:
        suite = Suite(subject)
        found = {x.id: suite.finding(x).verdict for x in suite.checks if x.id in wanted}
    assert found == wanted


@pytest.mark.parametrize(
    ("describe", "words"),
    [
        ({"offers": ["step"]}, "must have 'methods'"),
        ({"methods": ["rk4"]}, "must have 'offers'"),
        ({"methods": ["rk4"], "offers": ["fly"]}, "got 'fly'"),
    ],
)
def test_a_program_that_does_not_say_what_it_is_is_a_bad_adapter(tmp_path: Path, describe, words):
    with pytest.raises(UsageError, match=words):
        load_adapter(program(tmp_path, describe, "    answer = {}\n"))


def test_a_program_that_is_silent_is_given_up(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("glmref.conformance.pipe.PATIENCE", 0.2)
    with pytest.raises(UsageError, match=r"did not answer within 0\.2 seconds"):
        load_adapter(f"cmd:{shlex.quote(sys.executable)} -c 'import sys; sys.stdin.read()'")


def test_what_a_program_writes_to_its_stderr_is_obeyed_by_no_terminal(tmp_path, capfd):
    body = """
    sys.stderr.write("one\\x1b]0;title\\x07two\\nthree\\r\\x9b2J")
    sys.stderr.flush()
    answer = {"error": "no"}
"""
    about = {"methods": ["rk4"], "offers": ["step"]}
    load_adapter(program(tmp_path, about, body)).close()
    adapter = load_adapter(program(tmp_path, about, body))
    with pytest.raises(Exception, match="no"):
        adapter.step("rk4", problem("pendulum"), 0.0, np.array([[1.0], [0.0]]), 0.1)
    adapter.close()
    err = capfd.readouterr().err
    assert "one\\u001b]0;title\\u0007two\nthree" in err
    assert not set(err) & {"\x1b", "\x07", "\x9b", "\r"}


@pytest.mark.skipif(sys.platform != "linux", reason="the system shows no environments")
def test_what_left_the_group_of_a_program_ends_with_it(tmp_path: Path) -> None:
    """A grandchild that had called setsid lived on, as its group was not the program's."""
    body = """
    if not os.fork():
        os.setsid()
        if os.fork():
            os._exit(0)
        for number in (0, 1, 2):
            os.close(number)
        open("PIDS", "w").write(str(os.getpid()))
        time.sleep(600)
    os.wait()
    answer = {"error": "no"}
""".replace("PIDS", str(tmp_path / "pids"))
    about = {"methods": ["rk4"], "offers": ["step"]}
    adapter = load_adapter(program(tmp_path, about, "    import os, time\n" + body))
    with pytest.raises(Exception, match="no"):
        adapter.step("rk4", problem("pendulum"), 0.0, np.array([[1.0], [0.0]]), 0.1)
    for _ in range(1000):
        if (tmp_path / "pids").exists() and (tmp_path / "pids").read_text():
            break
        time.sleep(0.01)
    stray = int((tmp_path / "pids").read_text())
    assert alive(stray)
    adapter.close()
    for _ in range(1000):  # the end of a process that was killed takes its time
        if not alive(stray):
            break
        time.sleep(0.01)
    assert not alive(stray)
