"""Runs that are killed, doubled, short of disk: the records are those of an undisturbed run."""

import os
import random
import re
import signal
import subprocess
import sys
import time

import pytest

from glmref.compute import Records
from tests.evidence.faulty_runs import TASKS, Runs, sentence

resource = pytest.importorskip("resource", reason="limits of POSIX")
SEED = 20260

pytestmark = pytest.mark.skipif(os.name != "posix", reason="uses signals and limits of POSIX")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(tmp_path_factory.mktemp("faults"))


def kill_at_random(runs: Runs, count: int, seed: int) -> int:
    """Kill so many runs at random instants and end each by a second run; how many were hit."""
    chance = random.Random(seed)
    begun = time.monotonic()
    runs.run(f"timed-{seed}")
    whole = time.monotonic() - begun
    hit = 0
    for k in range(count):
        name = f"killed-{seed}-{k}"
        process = runs.start(name)
        # most of the time goes into imports: three quarters of the kills come after them
        delay = chance.uniform(0.0, 1.0) if k % 4 == 3 else chance.uniform(0.4, 1.05)
        time.sleep(delay * whole)
        process.kill()
        process.communicate()
        was_hit = process.returncode == -signal.SIGKILL
        hit += was_hit
        whole *= 1.0 if was_hit else 0.85  # the first run, or other work on the machine, was slow
        done = runs.run(name)
        assert done.returncode == 0, done.stderr
        runs.check(name)
    return hit


@pytest.mark.slow
def test_runs_killed_at_random_instants(runs: Runs) -> None:
    # fewer are hit where other work slows the machine
    assert kill_at_random(runs, 6, SEED + 1) > 1


def run_pairs(runs: Runs, count: int) -> int:
    """Run pairs at once; how many times the second was refused."""
    refused = 0
    for k in range(count):
        name = f"pair-{count}-{k}"
        both = [runs.start(name) for _ in range(2)]
        ended = [(*process.communicate(timeout=120), process.returncode) for process in both]
        codes = sorted(code for _, _, code in ended)
        assert codes in ([0, 0], [0, 2]), ended
        for _, err, code in ended:
            if code == 2:
                refused += 1
                assert err.count("\n") == 1 and " is in use by another process" in err, err
        runs.check(name)
    return refused


@pytest.mark.slow
def test_pairs_of_runs_at_once(runs: Runs) -> None:
    assert run_pairs(runs, 2) >= 1


def limited(size: int) -> None:
    """Let no file grow beyond a size: what a full disk or a quota does, without either."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def fill_disk(runs: Runs, places: int, seed: int) -> None:
    chance = random.Random(seed)
    # SQLite keeps an index of its log in memory that is a file of 32 KiB, and a record in the log
    # takes two to four pages of 4 KiB
    whole = 32_768 + TASKS * 8_192
    for k in range(places):
        name = f"full-{places}-{k}"
        size = chance.randrange(whole * k // places, whole * (k + 1) // places)
        done = runs.run(name, preexec_fn=lambda size=size: limited(size))
        assert done.returncode == 2, (size, done.stdout, done.stderr)
        assert "cannot be written (" in sentence(done)
        kept = runs.records(name)
        assert kept == runs.right[: len(kept)]
        done = runs.run(name, "--format", "json")
        assert done.returncode == 0 and f'"resumed": {len(kept)},' in done.stdout
        assert runs.records(name)[: len(kept)] == kept  # nothing was measured again
        runs.check(name)


@pytest.mark.slow
def test_a_disk_that_is_full_at_some_places(runs: Runs) -> None:
    fill_disk(runs, 2, SEED + 1)


@pytest.mark.slow
def test_a_full_disk_costs_the_cache_of_kernels_and_no_run(runs: Runs) -> None:
    cold = runs.environment(GLMREF_CACHE=str(runs.folder / "kernels"))
    done = runs.run("cold", env=cold, preexec_fn=lambda: limited(5_000))
    assert done.returncode == 2 and "record of a task cannot be written" in sentence(done)
    assert not list((runs.folder / "kernels").glob("*.tmp"))
    assert runs.run("cold", env=cold).returncode == 0
    runs.check("cold")


@pytest.mark.slow
@pytest.mark.parametrize(
    "number", [signal.SIGINT, signal.SIGTERM, pytest.param(signal.SIGHUP, marks=pytest.mark.slow)]
)
def test_a_signal_ends_a_run_and_keeps_what_is_done(runs: Runs, number: signal.Signals) -> None:
    name = f"signal-{number.name}"
    process = runs.start(name)
    deadline = time.monotonic() + 60
    while not len(Records(runs.path(name))):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.005)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    word = "interrupted" if number == signal.SIGINT else f"ended by {number.name}"
    kept = r"glmref: (\d+) of (\d+) runs are kept; the same command goes on\n"
    said = re.fullmatch(rf"{kept}glmref: {word}\n", err)
    assert (process.returncode, out) == (128 + number, "") and said, err
    assert 0 < int(said[1]) <= int(said[2])
    assert runs.run(name).returncode == 0
    runs.check(name)


@pytest.mark.slow
@pytest.mark.parametrize("pause", [0.0, 0.01, 0.1])
def test_two_signals_end_a_run_in_processes_as_one_does(runs: Runs, pause: float) -> None:
    """The second interrupted what ended the processes, and their tasks ran to the end."""
    name = f"twice-{pause:g}"
    scene = runs.folder / "long.toml"
    scene.write_text(
        runs.scene.read_text(encoding="utf-8")
        .replace("200000, 400000, 600000, 800000", "400000000, 400000001")
        .replace("repeats = 1", "repeats = 1\nbudget = 60"),
        encoding="utf-8",
    )
    command = [
        sys.executable, "-m", "glmref", "run", str(scene), "--output", str(runs.folder / name),
        "--on", "local:2",
    ]  # fmt: skip
    process = runs.popen(command, start_new_session=True)
    time.sleep(3.0 + 20 * pause)  # while processes start, and while they compute
    process.send_signal(signal.SIGTERM)
    time.sleep(pause)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=40)  # the tasks go on for their budget of 60 s
    assert out == "" and process.returncode in (130, 143)
    said = [line for line in err.splitlines() if "are kept" not in line]
    assert said in (["glmref: ended by SIGTERM"], ["glmref: interrupted"])


@pytest.mark.slow
def test_a_gigabyte_of_address_space_is_enough_or_said_to_be_too_little(runs: Runs) -> None:
    def limit(size: int) -> None:
        resource.setrlimit(resource.RLIMIT_AS, (size, size))

    for megabytes in (1024, 300):
        name = f"memory-{megabytes}"
        done = runs.run(name, preexec_fn=lambda size=megabytes << 20: limit(size))
        assert done.returncode in (0, 2), (done.stdout, done.stderr)
        assert "Traceback" not in done.stderr
        if done.returncode:
            assert "run the same command again" in sentence(done) or "memory" in sentence(done)
        assert runs.run(name).returncode == 0  # with enough memory nothing is missing
        runs.check(name)


@pytest.mark.slow
def test_a_reader_that_goes_away_ends_a_run_quietly(runs: Runs) -> None:
    command = " ".join(f"'{part}'" for part in runs.command("head"))
    done = subprocess.run(
        ["sh", "-c", f"{{ {command}; echo $? >&2; }} | head -n 1"],
        env=runs.environment(), capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.stderr.strip() in ("0", "141")
    assert done.stdout == "A tiny scene\n"
    runs.check("head")


@pytest.mark.slow
@pytest.mark.parametrize(
    "surroundings",
    [
        pytest.param(
            {
                "HOME": None,
                "XDG_CACHE_HOME": None,
                "GLMREF_CACHE": None,
                "LC_ALL": "C",
                "PYTHONUTF8": "0",
                "PYTHONIOENCODING": "ascii",
                "TZ": "XXX-23:59:59",
            },
            id="no home, ASCII, another clock",
        ),
        pytest.param({"HOME": "/proc/nothing", "GLMREF_CACHE": None}, id="a home that is not"),
        pytest.param({"GLMREF_CACHE": "/proc/nothing"}, id="a cache that cannot be written"),
    ],
)
def test_poor_surroundings_do_no_harm(runs: Runs, surroundings: dict[str, str | None]) -> None:
    name = "poor-" + "-".join(sorted(surroundings)).lower()
    given = runs.environment()
    for key, value in surroundings.items():
        given.pop(key, None)
        if value is not None:
            given[key] = value
    done = runs.run(name, env=given)
    assert (done.returncode, done.stderr) == (0, "")
    runs.check(name)


@pytest.mark.slow
@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"])
def test_closed_streams_do_not_reach_the_records(runs: Runs, closed: str) -> None:
    name = f"closed-{len(closed)}-{ord(closed[0])}"
    command = " ".join(f"'{part}'" for part in runs.command(name))
    done = subprocess.run(
        ["sh", "-c", f"{command} {closed}"],
        env=runs.environment(), capture_output=True, timeout=120, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, b"")
    runs.check(name)


@pytest.mark.slow
def test_a_clock_that_jumps_changes_no_record(runs: Runs) -> None:
    # time.time goes back by an hour at each call; durations must not be taken from it
    (runs.folder / "sitecustomize.py").write_text(
        "import itertools, time\n"
        "_left = itertools.count(4e9, -3600)\n"
        "time.time = lambda: next(_left)\n",
        encoding="utf-8",
    )
    given = runs.environment()
    given["PYTHONPATH"] = f"{runs.folder}{os.pathsep}{given['PYTHONPATH']}"
    try:
        done = runs.run("clock", env=given)
    finally:
        (runs.folder / "sitecustomize.py").unlink()
    assert (done.returncode, done.stderr) == (0, "")
    runs.check("clock")


@pytest.mark.slow
def test_damage_costs_the_records_it_hit(runs: Runs) -> None:
    folder = runs.folder / "damaged"
    folder.mkdir()
    content = bytearray(runs.path("undisturbed").read_bytes())
    for n in (1, 6):  # a bit of each of two records
        place = content.find(b'"outcome":"completed"', content.find(runs.right[n]["key"].encode()))
        content[place + 14] ^= 1
    (folder / "tiny.sqlite").write_bytes(content)
    done = runs.run("damaged", "--format", "json")
    assert done.returncode == 0
    assert '"measured": 2,' in done.stdout and f'"resumed": {TASKS - 2},' in done.stdout
    assert done.stderr == ("note: tiny.sqlite: a record is damaged and is measured again\n")
    # the records that were lost stand at the end
    found = sorted(map(str, runs.records("damaged")))
    assert found == sorted(map(str, runs.right))
    again = runs.run("damaged")
    assert (again.returncode, again.stderr) == (0, "")


@pytest.mark.slow
def test_a_lock_left_by_a_crash_does_not_stop_the_next_run(runs: Runs) -> None:
    folder = runs.folder / "stale"
    folder.mkdir()
    (folder / ".tiny.sqlite.lock").touch()
    done = runs.run("stale")
    assert (done.returncode, done.stderr) == (0, "")
    runs.check("stale")
