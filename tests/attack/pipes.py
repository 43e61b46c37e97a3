"""Hostile programs at the other end of the pipe of the conformance suite.

Each peer answers some questions rightly and then does one hostile thing, drawn with its place and
its size from the seed. It must end within its limit, with a sentence, and with its process group
gone; no exception but those that have a name may leave the adapter.
"""

import json
import os
import random
import shlex
import sys
import tempfile
import time
from contextlib import redirect_stderr
from pathlib import Path
from typing import Any
from unittest.mock import patch

from glmref import problem
from glmref.conformance import pipe
from glmref.conformance.subject import AdapterError, NotOffered, Subject
from glmref.errors import GlmrefError, UsageError

from .tally import Tally

COUNT = 500
#: Limits while the attack lasts: seconds of silence, of one answer, bytes of a line.
PATIENCE, LONGEST, MAX_LINE = 1.0, 2.0, 2_000_000
#: Seconds that one peer may take in all: describe, three steps, and its end.
LIMIT = 4 * LONGEST + 6.0
#: Outcome of a peer that was stopped before its first line ran.
NOT_BEGUN = "(not begun in time)"

_PEERS = json.loads(Path(__file__).with_name("peers.json").read_text(encoding="utf-8"))
PEER: str = _PEERS["peer"]
#: What a peer does, and words of which one must stand in the sentence ("" for none needed).
DEEDS: dict[str, tuple[str, tuple[str, ...]]] = {
    name: (deed, tuple(words)) for name, (deed, *words) in _PEERS["deeds"].items()
}


def peer(chance: random.Random, folder: Path, deed: str) -> str:
    """Write a peer and return the command that starts it."""
    body, words = DEEDS[deed]
    drawn = {
        "{size}": str(10 ** chance.randrange(1, 6)),
        "{code}": str(chance.choice([0, 1, 3, 77])),
        "{signal}": str(chance.choice([6, 9, 11, 15])),
        "{{": "{",
        "}}": "}",
    }
    for name, value in drawn.items():
        body = body.replace(name, value)
    path = folder / "peer.py"
    turn = chance.randrange(0, 3)
    path.write_text(
        PEER.format(
            pids=str(folder / "pids"), turn=turn, deed=body, then="continue" if words else "pass"
        ),
        encoding="utf-8",
    )
    return f"{shlex.quote(sys.executable)} {shlex.quote(str(path))}"


def meet(command: str) -> str:
    """Ask a peer for what it is and for three steps; return what it came to."""
    subject = None
    told = "answered"
    oscillator = problem("harmonic-oscillator")
    try:
        import numpy as np

        subject = Subject(pipe.PipeAdapter(command))
        for _ in range(3):
            try:
                subject.step("euler", oscillator, 0.0, np.array([[1.0, 0.0]]), 0.125)
            except (AdapterError, NotOffered) as error:
                told = str(error) if told == "answered" else told
    except UsageError as error:
        told = str(error)
    finally:
        if subject is not None:
            subject.close()
    return told


def alive(pid: int) -> bool:
    try:
        status = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return status not in "ZX"


def attack(deed: str, chance: random.Random) -> tuple[str, str]:
    """Meet one peer; return what it came to, and what must not have happened or ``""``."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        command = peer(chance, folder, deed)
        begun = time.monotonic()
        try:
            told = meet(command)
        except GlmrefError as error:
            told = str(error)
        except Exception as error:
            return "", f"{type(error).__name__}: {error}"
        elapsed = time.monotonic() - begun
        note = folder / "pids"
        if not note.exists():  # on a busy machine the interpreter may take longer than PATIENCE
            return NOT_BEGUN, ""
        pids = [int(x) for x in note.read_text().split()]
        words = DEEDS[deed][1]
        if elapsed > LIMIT:
            return told, f"it took {elapsed:.1f} s of {LIMIT:.1f}"
        for _ in range(100):  # the end of a process that was killed takes its time
            if not any(map(alive, pids)):
                break
            time.sleep(0.01)
        if left := [pid for pid in pids if alive(pid)]:
            return told, f"{len(left)} processes are left"
        if len(told) > 1000:
            return told, f"the sentence has {len(told)} characters"
        if (not words) != (told == "answered"):
            return told, f"it came to {told[:200]!r}"
        if words and not any(word in told for word in words):
            return told, f"none of {words} stands in {told[:200]!r}"
    return told, ""


def run(count: int, seed: int) -> Tally:
    """Meet so many peers; count how many of each kind there were."""
    chance = random.Random(seed)
    tally = Tally()
    names = list(DEEDS)
    chance.shuffle(names)
    limits: dict[str, Any] = {"PATIENCE": PATIENCE, "LONGEST": LONGEST, "MAX_LINE": MAX_LINE}
    with patch.multiple(pipe, **limits):
        for k in range(count):
            deed = names[k % len(names)]  # every kind before one comes again
            told, wrong = attack(deed, random.Random(f"{seed} {k}"))
            tally.outcomes[NOT_BEGUN if told == NOT_BEGUN else deed] += 1
            if wrong:
                tally.violations.append(f"case {k}, {deed}: {wrong}")
    return tally


def main(count: int = COUNT, seed: int = 1) -> int:
    """Print counts and violations; 1 where there is a violation."""
    with open(os.devnull, "w") as null, redirect_stderr(null):  # peers flood it
        tally = run(count, seed)
    print(f"{count} peers, seed {seed}")
    return tally.printed()
