"""``glmref derive`` on the command line: lists, help, bad input, progress, interruption."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest

from glmref.catalogue.canonical import canonical
from glmref.cli import main
from glmref.compute import Records
from glmref.derive import recipes

ANSATZ = Path(__file__).with_name("three-stages.toml")


def test_without_a_recipe_the_recipes_are_listed(cli) -> None:
    text = cli("derive").out
    assert all(name in text for name in recipes.names())


def test_the_list_of_recipes_comes_as_json_too(cli) -> None:
    found = json.loads(cli("derive", "--format", "json").out)
    assert found["format"] == "glmref-recipes-1"
    assert [x["name"] for x in found["recipes"]] == recipes.names()
    options = {x["name"]: x["options"] for x in found["recipes"]}
    assert options["order6"] == {"c2": "1/3", "z": "exp(2*pi*i/3)", "start": "auto"}


@pytest.mark.parametrize("words", [["order6", "--help"], ["--help", "order6"], ["order6", "-h"]])
def test_help_after_a_recipe_is_that_of_the_recipe(words: list[str], cli) -> None:
    text = cli("derive", *words).out
    assert "glmref derive order6" in text
    assert "--c2" in text and "default: 1/3" in text
    assert ":mod:" not in text


def test_an_ansatz_that_is_not_toml_is_one_sentence(tmp_path: Path, cli) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"stages = \xff")
    assert "a.toml: byte 9 is not UTF-8" in cli("derive", path, code=2).err


def cli(*words: str) -> list[str]:
    return [sys.executable, "-m", "glmref", "derive", *words]


def wait_for_records(state: Path, count: int, process: subprocess.Popen[bytes]) -> None:
    """Wait until the state file has as many records, or the search has ended."""
    until = time.monotonic() + 120
    while process.poll() is None and time.monotonic() < until:
        if len(Records(state)) >= count:
            return
        time.sleep(0.02)
    raise AssertionError("the search ended before it could be stopped")


OPTIONS = {"ansatz": str(ANSATZ), "starts": "96"}


@pytest.fixture(scope="module")
def undisturbed() -> list[str]:
    return [canonical(x) for x in recipes.run("search", OPTIONS).documents]


@pytest.mark.slow
@pytest.mark.parametrize(("how", "code"), [(signal.SIGINT, 130), (signal.SIGKILL, -signal.SIGKILL)])
def test_a_search_that_is_stopped_goes_on_where_it_was(how, code, tmp_path, undisturbed):
    """Interrupted or killed, the second run takes over what the first one kept."""
    state = tmp_path / "state"
    words = [str(ANSATZ), "--starts", "96", "--state", str(state)]
    process = subprocess.Popen(cli(*words), stderr=subprocess.PIPE, stdout=subprocess.PIPE)
    wait_for_records(state, 1, process)
    process.send_signal(how)
    _, complaint = process.communicate()
    assert process.returncode == code
    if how is signal.SIGINT:
        assert f"the same command goes on from {state}".encode() in complaint
    kept = len(Records(state))
    assert kept < 3  # parcels of 32 starts
    ran: list[int] = []
    resumed = recipes.run(
        "search", {**OPTIONS, "state": str(state)}, lambda _, done, total: ran.append(done)
    )
    assert min(ran) == 32 * (kept + 1)
    assert [canonical(x) for x in resumed.documents] == undisturbed


@pytest.mark.slow
def test_progress_is_shown_on_a_terminal_and_nowhere_else() -> None:
    leader, follower = pty.openpty()
    termios.tcsetwinsize(follower, (24, 80))
    run = subprocess.run(cli("yoshida6"), stderr=follower, stdout=subprocess.PIPE, check=True)
    os.close(follower)
    shown = os.read(leader, 100_000).decode()
    os.close(leader)
    assert "A:" in shown and "%" in shown
    assert b'"yoshida-6-midpoint"' in run.stdout
    silent = subprocess.run(cli("yoshida6"), capture_output=True, check=True)
    assert b"%" not in silent.stderr


def test_a_name_of_a_file_is_that_file(tmp_path: Path) -> None:
    path = tmp_path / "new" / "mine.json"
    words = ["derive", "pairs", "--name", "pair-4-4", "--output", str(path)]
    assert main(words) == 0
    assert json.loads(path.read_text(encoding="utf-8"))["name"] == "pair-4-4"


def test_several_methods_go_to_a_folder_whatever_its_name_ends_with(tmp_path: Path) -> None:
    words = ["derive", "two-stage", "--format", "json", "--output", str(tmp_path / "two.json")]
    assert main(words) == 0
    assert len(list((tmp_path / "two").glob("*.json"))) > 1
