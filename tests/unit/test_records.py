"""Records survive: keys depend on content, damage is seen, what is sound is kept and not lost."""

import json
import math
import os
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.compute import measure
from glmref.compute.records import Records, checksum, key_of, lines_of, locked, made
from glmref.errors import DataError, UsageError
from tests.build import refused

posix = pytest.mark.skipif(os.name != "posix", reason="links, pipes and locks of POSIX")
ROOT = Path(__file__).resolve().parents[2]
TASKS = [{"method": "a", "h": h} for h in (0.1, 0.2, 0.3)]
DONE = {"outcome": "completed"}


def three(path):
    store = Records(path)
    for n, task in enumerate(TASKS):
        store.append(task, {**DONE, "state_error": 1.5e-9 * n, "notices": ["é"]})
    return list(Records(path))


def lines(path, *records):
    path.write_text("".join(json.dumps(x, separators=(",", ":")) + "\n" for x in records), "utf-8")


def test_a_key_depends_on_content_not_on_order():
    assert key_of({"a": 1, "b": [2.5]}) == key_of({"b": [2.5], "a": 1})
    assert key_of({"a": 1, "b": [2.5]}) != key_of({"a": 1, "b": [2.50000001]})
    assert len(key_of({})) == 16


@given(st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False) | st.integers()))
def test_a_key_survives_a_round_trip_through_json(task):
    assert key_of(json.loads(json.dumps(task))) == key_of(task)


def test_a_record_that_json_cannot_hold_is_refused_and_not_written(tmp_path):
    store = Records(tmp_path / "records.sqlite")
    refused(ValueError, "", store.append_all, [(TASKS[0], DONE), (TASKS[1], {"error": math.inf})])
    assert list(store) == [] and list(tmp_path.iterdir()) == []


def test_a_store_that_is_only_read_changes_nothing(tmp_path):
    path = tmp_path / "records.sqlite"
    right = three(path)
    whole = path.read_bytes()
    store = Records(path)
    assert list(store) == right and not list(store.missing(TASKS))
    store.close()
    assert path.read_bytes() == whole
    assert list(tmp_path.iterdir()) == [path]  # no log and no lock at rest


def test_a_file_that_cannot_be_written_is_read(tmp_path):
    path = tmp_path / "records.sqlite"
    right = three(path)
    path.chmod(0o400)
    tmp_path.chmod(0o500)
    try:
        assert list(Records(path)) == right
    finally:
        tmp_path.chmod(0o700)


KILLED = """
import os, signal, sys
from pathlib import Path
from glmref.compute import Records
store = Records(Path(sys.argv[1]))
with store.exclusive():
    store.append({"n": 1}, {"outcome": "completed"})
    with store._file:
        store._file.execute("INSERT INTO record VALUES ('half', 'written')")
        os.kill(os.getpid(), signal.SIGKILL)
"""


@posix
def test_a_writer_that_is_killed_in_a_transaction_loses_that_and_nothing_else(tmp_path):
    path = tmp_path / "records.sqlite"
    three(path)
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(path)],
        env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False,
    )  # fmt: skip
    assert done.returncode == -9
    assert [x["task"] for x in Records(path)] == [*TASKS, {"n": 1}]  # its log is read
    store = Records(path)
    store.append({"n": 2}, DONE)  # its lock has ended with it
    assert len(store) == 5 and store.notices == []
    store.close()
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.sampled(1)
@posix
@pytest.mark.parametrize("room", [0, 20_000, 60_000])
def test_a_disk_that_fills_costs_no_record_that_was_there(tmp_path, room):
    path = tmp_path / "records.sqlite"
    right = three(path)
    script = (
        "import resource, sys\nfrom pathlib import Path\nfrom glmref.compute import Records\n"
        "from glmref.errors import UsageError\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({room}, {room}))\n"
        "store = Records(Path(sys.argv[1]))\n"
        "try:\n    for n in range(50): store.append({'n': n}, {'message': 'x' * 3000})\n"
        "except UsageError as error: print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(path)], capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, check=True,
    )  # fmt: skip
    assert "cannot be written (" in done.stdout, (done.stdout, done.stderr)
    found = list(Records(path))
    assert found[:3] == right
    assert f"the {len(found)} records before" in done.stdout or room < 40_000
    assert [x["task"]["n"] for x in found[3:]] == list(range(len(found) - 3))
    Records(path).append({"n": 99}, DONE)
    assert len(Records(path)) == len(found) + 1


def flips(path, right, bits):
    """Flip bits of a file, one at a time; a record is right or measured again, or the file refused."""
    whole = path.read_bytes()
    refused = 0
    for bit in bits:
        content = bytearray(whole)
        content[bit // 8] ^= 1 << bit % 8
        path.write_bytes(bytes(content))
        try:
            store = Records(path)
            assert all(x in right for x in store), bit
            lost = list(store.missing(TASKS))
            with store.exclusive():
                for task in store.missing(TASKS):
                    store.append(task, DONE)
        except (DataError, UsageError) as error:
            assert "move it away" in str(error) or "a readonly database" in str(error), bit
            refused += 1
        else:
            assert not lost or store.notices, bit
            assert sorted(x["key"] for x in store) == sorted(x["key"] for x in right), bit
        finally:
            for other in path.parent.iterdir():
                other.unlink()
    return refused


def test_a_bit_of_a_record_that_flips_costs_that_record(tmp_path):
    path = tmp_path / "records.sqlite"
    right = three(path)
    content = path.read_bytes()
    begin = content.find(b'{"format"')
    assert flips(path, right, range(8 * begin, 8 * begin + 800, 23)) == 0


@pytest.mark.slow
def test_no_bit_of_a_file_flips_unseen(tmp_path):
    path = tmp_path / "records.sqlite"
    right = three(path)
    size = 8 * path.stat().st_size
    bits = [*range(0, 8 * 600, 61), *range(8 * 600, size, 401)]
    refused = flips(path, right, bits)
    assert refused < len(bits) / 10  # the head of the file and its table of contents


def test_a_damaged_file_is_refused_and_left_as_it_is(tmp_path):
    path = tmp_path / "records.sqlite"
    store = Records(path)
    store.append_all([({"n": n}, {**DONE, "message": "x" * 200}) for n in range(200)])
    store.close()
    content = bytearray(path.read_bytes())
    page = content.find(b'"task":{"n":100}') // 4096  # a page of records in the middle
    content[page * 4096 : page * 4096 + 1000] = b"\xff" * 1000
    path.write_bytes(bytes(content))
    with pytest.raises(DataError, match=r"records.sqlite is damaged \(.*move it away to measure"):
        measure(_squares, [{"n": n} for n in range(200)], Records(path))
    refused(DataError, "is damaged", list, Records(path))
    assert path.read_bytes() == content


@pytest.mark.parametrize(
    ("content", "why"),
    [(b"of somebody" * 99, "file is not a database"), (None, "it has other tables")],
)
def test_a_file_of_another_kind_is_refused_and_left_as_it_is(tmp_path, content, why):
    path = tmp_path / "records.sqlite"
    if content is None:
        with sqlite3.connect(path) as other:
            other.execute("CREATE VIEW record AS SELECT 'k' AS key, 'x' AS record")
        other.close()
    else:
        path.write_bytes(content)
    before = path.read_bytes()
    refused(DataError, rf"records.sqlite is not a file of records \({why}\)", Records, path)
    assert path.read_bytes() == before


@posix
def test_a_link_called_as_the_lock_is_not_followed(tmp_path):
    precious = tmp_path / "precious"
    for content in ("mine", None):
        precious.unlink(missing_ok=True)
        if content:
            precious.write_text(content, encoding="utf-8")
        (tmp_path / ".records.sqlite.lock").unlink(missing_ok=True)
        (tmp_path / ".records.sqlite.lock").symlink_to(precious)
        with pytest.raises(UsageError, match="cannot be written"):
            Records(tmp_path / "records.sqlite").append(TASKS[0], DONE)
        assert not content or precious.read_text(encoding="utf-8") == "mine"
        assert precious.exists() == bool(content)


@posix
def test_a_file_has_one_lock_whatever_links_lead_to_it(tmp_path):
    path, link = tmp_path / "a" / "records.sqlite", tmp_path / "b" / "linked.sqlite"
    Records(path).append(TASKS[0], DONE)
    link.parent.mkdir()
    link.symlink_to(path)
    with Records(link).exclusive(), pytest.raises(UsageError, match="is in use by"):
        Records(path).append(TASKS[1], DONE)


HOLD = """
import sys
from pathlib import Path
from glmref.compute import Records
with Records(Path(sys.argv[1])).exclusive():
    print("held", flush=True)
    sys.stdin.read()
"""


@posix
@pytest.mark.parametrize("end", ["kill", "close"])
def test_a_lock_ends_with_its_holder(tmp_path, end):
    path = tmp_path / "records.sqlite"
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert holder.stdin is not None and holder.stdout is not None
    assert holder.stdout.readline() == b"held\n"
    with pytest.raises(UsageError, match="is in use by another process; wait until"):
        Records(path).append(TASKS[0], DONE)
    assert list(Records(path)) == []  # it can be read meanwhile
    if end == "kill":
        holder.kill()
    holder.stdin.close()
    holder.wait()
    holder.stdout.close()
    Records(path).append(TASKS[0], DONE)
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_another_program_moves_is_not_written_on(tmp_path):
    path = tmp_path / "records.sqlite"
    store = Records(path)
    with store.exclusive():
        store.append(TASKS[0], DONE)
        path.unlink()
        refused(UsageError, "moved or deleted", store.append, TASKS[1], DONE)
    assert not path.exists()


# --- files of earlier versions: a record a line ----------------------------------------------------


def test_records_in_lines_are_taken_over_and_their_file_is_left(tmp_path):
    right = [made(task, DONE) for task in TASKS]
    old = [{k: x for k, x in right[0].items() if k != "sha256"}, *right[1:]]  # of version 0.1.0
    lines(tmp_path / "records.jsonl", *old)
    before = (tmp_path / "records.jsonl").read_bytes()
    store = Records(tmp_path / "records.sqlite")
    assert not list(store.missing(TASKS)) and len(store) == 3
    assert list(tmp_path.iterdir()) == [tmp_path / "records.jsonl"]  # reading writes nothing
    store.append({"n": 1}, DONE)
    assert list(Records(tmp_path / "records.sqlite")) == [*right, made({"n": 1}, DONE)]
    assert (tmp_path / "records.jsonl").read_bytes() == before


def test_damage_of_lines_costs_the_lines_it_hit(tmp_path):
    path = tmp_path / "records.jsonl"
    lines(path, *(made(task, DONE) for task in TASKS))
    first, second, third = path.read_bytes().splitlines(keepends=True)
    other = b'{"format": "of another program"}\n\xff\xfe\x00\n'
    joined = second.rstrip() + third  # a line end that was lost
    path.write_bytes(b"not a record\n" + 2 * first + second.replace(b"0.2", b"0.7") + other + joined
                     + third[:-9])  # fmt: skip
    store = Records(tmp_path / "records.sqlite")
    assert [x["task"] for x in store] == TASKS[:1] and list(store.missing(TASKS)) == TASKS[1:]
    (said,) = store.notices
    assert said == (
        "records.jsonl: line 1: it is not JSON, and 5 lines more; what cannot be read is measured "
        "again"
    )


@pytest.mark.parametrize("text", ["[]", "7", "null", '{"format": 2}', '{"something": "else"}',
                                  '{"format": "glmref-record-1"}'])  # fmt: skip
def test_a_file_of_lines_that_are_no_records_is_refused(tmp_path, text):
    path = tmp_path / "records.jsonl"
    path.write_text(text + "\n", encoding="utf-8")
    with pytest.raises(DataError, match=r"records.jsonl: line 1: it.*; move the file away"):
        Records(tmp_path / "records.sqlite")


def test_records_of_another_version_are_refused_in_one_sentence(tmp_path):
    record = made(TASKS[0], DONE)
    record["format"] = "glmref-record-2"
    lines(tmp_path / "records.jsonl", {**record, "sha256": checksum(record)})
    caught = refused(DataError, "", Records, tmp_path / "records.sqlite")
    assert caught == (
        "records.jsonl: line 1: its format is 'glmref-record-2', and this version reads "
        "'glmref-record-1'; move the file away to measure again"
    )


@pytest.mark.slow
def test_each_bit_of_a_line_that_flips_is_seen(tmp_path):
    path = tmp_path / "records.jsonl"
    lines(path, made(TASKS[0], {"error": 1.2345e-08, "seconds": 0.0019999999999999914, **DONE}))
    content = path.read_bytes()
    ((_, right, _),) = lines_of(path)
    name = content.index(b'"sha256"')  # a line without a checksum is read, too
    for k in {*range(8 * (len(content) - 1))} - {*range(8 * name + 8, 8 * name + 56)}:
        changed = bytearray(content)
        changed[k // 8] ^= 1 << k % 8
        path.write_bytes(changed)
        found = [(record, why) for _, record, why in lines_of(path)]
        assert all(record is None and why for record, why in found), (k, bytes(changed), right)


@pytest.mark.parametrize("piece", [b'{"format":"', b'{"format":"x","a":', b"[", b"9"])
def test_a_long_line_is_read_in_linear_time(tmp_path, piece):
    path = tmp_path / "records.jsonl"
    path.write_bytes(piece * 100_000)
    begun = time.process_time()
    assert [record for _, record, _ in lines_of(path)] == [None]
    assert time.process_time() - begun < 2


def _squares(task):
    return {"outcome": "completed", "square": task["n"] ** 2}


def test_a_lock_that_is_given_back_leaves_no_file(tmp_path: Path) -> None:
    with locked(tmp_path / "records.sqlite"):
        assert list(tmp_path.iterdir())
    assert not list(tmp_path.iterdir())


#: Begins to change a file of records, until pages are written, and ends without taking it back.
ABANDONED = """
import os, sqlite3, sys
file = sqlite3.connect(sys.argv[1])
file.execute("PRAGMA cache_size = 1")
file.execute("BEGIN")
rows = [(f"{n:016x}", "x" * 2000) for n in range(200)]
file.executemany("INSERT INTO record VALUES (?, ?)", rows)
os._exit(9)
"""


def test_what_a_killed_process_had_begun_is_taken_back(tmp_path):
    """SQLite cannot do so for a reader that may not write."""
    path = tmp_path / "records.sqlite"
    right = three(path)
    subprocess.run([sys.executable, "-c", ABANDONED, str(path)], check=False)
    assert path.with_name(f"{path.name}-journal").exists()
    assert list(Records(path)) == right
