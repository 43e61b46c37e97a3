"""Some hostile peers of ``python -m tests.attack pipes``; hundreds of them are its own business."""

import sys
from pathlib import Path

import pytest

from tests.attack import pipes

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="looks for processes in /proc"
)


@pytest.mark.slow
def test_every_hostile_peer_ends_with_a_sentence(capsys) -> None:
    count = 2 * len(pipes.DEEDS)
    assert pipes.main(count, 11) == 0, capsys.readouterr()
    said = capsys.readouterr().out
    assert f"{count} peers, seed 11" in said and "0 violations" in said


@pytest.mark.slow
def test_the_attack_sees_a_process_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    # without its group and its mark a child that a peer leaves behind runs on: the attack must say so
    monkeypatch.setattr("os.killpg", lambda group, number: None)
    monkeypatch.setattr("glmref.system.process._marked", lambda mark: [])
    monkeypatch.setitem(
        pipes.DEEDS, "leaves a child",
        ("spawn('import time; time.sleep(3)'); os._exit(0)", ("ended without",)),
    )  # fmt: skip
    told, wrong = pipes.attack("leaves a child", pipes.random.Random(1))
    assert "ended without an answer" in told and wrong == "1 processes are left"


def test_a_peer_that_was_stopped_before_its_first_line_is_counted(monkeypatch, capsys) -> None:
    # a busy machine may take longer than the patience of the attack to start an interpreter
    monkeypatch.setattr(pipes, "peer", lambda chance, folder, deed: "false")
    assert pipes.main(2, 7403) == 0
    assert f"2  {pipes.NOT_BEGUN}" in capsys.readouterr().out


def test_an_error_of_the_attack_itself_is_seen(monkeypatch) -> None:
    def fails(count: int, seed: int) -> None:
        sys.stderr.write("what a peer writes is not shown")
        raise RuntimeError("the attack is wrong")

    monkeypatch.setattr(pipes, "run", fails)
    before = sys.stderr
    with pytest.raises(RuntimeError):
        pipes.main(1, 1)
    assert sys.stderr is before
