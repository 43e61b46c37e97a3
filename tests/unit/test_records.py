"""Records survive: keys depend on content, torn lines are dropped, others are refused."""

import json
import math
import os
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.compute import RecordFolder, measure, records
from glmref.compute.records import RecordFile, checksum, finite, key_of, read_records, scan
from glmref.errors import DataError, UsageError
from glmref.system import files
from glmref.system.files import Lock

posix = pytest.mark.skipif(os.name != "posix", reason="links, pipes and locks of POSIX")
TASKS = [{"method": "a", "h": h} for h in (0.1, 0.2, 0.3)]


def test_a_key_depends_on_content_not_on_order():
    assert key_of({"a": 1, "b": [2.5]}) == key_of({"b": [2.5], "a": 1})
    assert key_of({"a": 1, "b": [2.5]}) != key_of({"a": 1, "b": [2.50000001]})
    assert len(key_of({})) == 16


@given(st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False) | st.integers()))
def test_a_key_survives_a_round_trip_through_json(task):
    assert key_of(json.loads(json.dumps(task))) == key_of(task)


def test_a_task_with_nan_is_refused():
    with pytest.raises(ValueError):
        key_of({"h": math.nan})


def test_nan_and_infinities_become_none():
    assert [finite(x) for x in (1.5, math.nan, math.inf, -math.inf, None)] == [1.5] + [None] * 4


def test_what_was_appended_is_read_back_and_not_missing(tmp_path):
    path = tmp_path / "folder" / "records.jsonl"
    store = RecordFile(path)
    for task in TASKS[:2]:
        store.append(task, {"outcome": "completed"})
    again = RecordFile(path)
    assert [r["task"] for r in again.records] == TASKS[:2]
    assert list(again.missing(TASKS)) == TASKS[2:]
    assert again.find(TASKS[0])["outcome"] == "completed"
    assert again.find(TASKS[2]) is None


def test_a_record_is_on_the_disk_when_append_returns(tmp_path):
    path = tmp_path / "records.jsonl"
    RecordFile(path).append(TASKS[0], {"outcome": "completed"})
    assert path.read_text(encoding="utf-8").endswith("}\n")
    assert len(read_records(path)) == 1


@pytest.mark.parametrize("cut", [1, 10, 60])
def test_a_torn_last_line_costs_that_record_only(tmp_path, cut):
    path = tmp_path / "records.jsonl"
    store = RecordFile(path)
    for task in TASKS:
        store.append(task, {"outcome": "completed"})
    content = path.read_bytes()
    path.write_bytes(content[:-cut])
    again = RecordFile(path)
    # a cut of one byte takes the newline only: the checksum shows that the record is whole
    assert list(again.missing(TASKS)) == (TASKS[2:] if cut > 1 else [])
    again.append(TASKS[2] if cut > 1 else {"method": "b"}, {"outcome": "completed"})
    assert len(read_records(path)) == (3 if cut > 1 else 4)


def test_a_torn_line_in_the_middle_is_refused_with_its_number(tmp_path):
    path = tmp_path / "records.jsonl"
    RecordFile(path).append(TASKS[0], {"outcome": "completed"})
    with path.open("a", encoding="utf-8") as stream:
        stream.write('{"broken\n{}\n')
    with pytest.raises(DataError, match="line 2"):
        read_records(path)


def test_a_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "records.jsonl"
    path.write_text('{"something": "else"}\n', encoding="utf-8")
    with pytest.raises(DataError, match="line 1 is not a record of format"):
        read_records(path)


@pytest.mark.parametrize(
    "text", ["[]", "7", "null", '{"format": 2}', '{"format": "glmref-record-1"}']
)
def test_a_line_that_is_json_but_no_record_is_refused(tmp_path, text):
    path = tmp_path / "records.jsonl"
    path.write_text(text + "\n", encoding="utf-8")
    with pytest.raises(DataError, match="line 1 is not a record"):
        RecordFile(path)


def test_records_of_another_version_are_refused_in_one_sentence(tmp_path):
    path = tmp_path / "records.jsonl"
    record = RecordFile(None).append(TASKS[0], {"outcome": "completed"})
    record["format"] = "glmref-record-2"
    path.write_text(json.dumps({**record, "sha256": checksum(record)}) + "\n", "utf-8")
    with pytest.raises(DataError) as caught:
        RecordFile(path)
    assert str(caught.value) == (
        "records.jsonl: line 1 is a record of format 'glmref-record-2', and this version reads "
        "'glmref-record-1'; move the file away to measure anew"
    )


def test_without_a_path_records_stay_in_memory():
    store = RecordFile(None)
    store.append(TASKS[0], {"outcome": "completed"})
    assert store.find(TASKS[0]) is not None


def test_a_record_that_json_cannot_hold_is_refused_and_not_written(tmp_path):
    path = tmp_path / "records.jsonl"
    store = RecordFile(path)
    with pytest.raises(ValueError):
        store.append(TASKS[0], {"error": math.inf})
    assert store.find(TASKS[0]) is None
    assert read_records(path) == []


def three(path):
    store = RecordFile(path)
    for n, task in enumerate(TASKS):
        store.append(task, {"outcome": "completed", "state_error": 1.5e-9 * n, "notices": ["é"]})
    return path.read_bytes(), store.records


@pytest.mark.slow
def test_no_bit_flips_unseen(tmp_path):
    path = tmp_path / "records.jsonl"
    whole, right = three(path)
    for bit in range(0, 8 * len(whole), 7):  # every byte, and every place in a byte
        content = bytearray(whole)
        content[bit // 8] ^= 1 << bit % 8
        path.write_bytes(bytes(content))
        store = RecordFile(path)
        lost = list(store.missing(TASKS))
        assert len(lost) <= 1, bit
        for record in store.records:  # what is kept is what was written
            assert record in right, bit
        with store.exclusive():  # which repairs the file
            for task in lost:
                store.append(task, {"outcome": "completed"})
        assert bool(lost) <= bool(store.notices), bit
        assert sorted(r["key"] for r in read_records(path)) == sorted(r["key"] for r in right)
        path.with_name("records.jsonl.aside").unlink(missing_ok=True)


@pytest.mark.parametrize("room", [0, 1, 50, 200])
def test_a_disk_that_fills_in_the_middle_of_a_record_leaves_no_part_of_it(
    tmp_path, monkeypatch, room
):
    path = tmp_path / "records.jsonl"
    store = RecordFile(path)
    store.append(TASKS[0], {"outcome": "completed"})
    before = path.read_bytes()
    write = os.write
    left = [room]

    def full(descriptor, content):
        if os.fstat(descriptor).st_size < len(before):
            return write(descriptor, content)  # the lock's
        if not left[0]:
            raise OSError(28, "No space left on device")
        done = write(descriptor, bytes(content)[: left[0]])
        left[0] -= done
        return done

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        with pytest.raises(UsageError) as caught:
            store.append(TASKS[1], {"outcome": "completed", "message": "x" * 300})
    assert "cannot be written (No space left on device); the 1 records before" in str(caught.value)
    assert path.read_bytes() == before
    store.append(TASKS[1], {"outcome": "completed"})
    assert [r["task"] for r in read_records(path)] == TASKS[:2]


def test_records_without_a_checksum_stay_readable(tmp_path):
    path = tmp_path / "records.jsonl"
    _, right = three(path)
    old = [{key: x for key, x in record.items() if key != "sha256"} for record in right]
    path.write_text("".join(json.dumps(record) + "\n" for record in old), encoding="utf-8")
    assert read_records(path) == old
    assert not list(RecordFile(path).missing(TASKS)) and not RecordFile(path).faulty


def test_a_store_that_is_only_read_changes_nothing(tmp_path):
    path = tmp_path / "records.jsonl"
    whole, _ = three(path)
    path.write_bytes(whole[:-20])
    assert len(RecordFile(path).records) == 2
    assert path.read_bytes() == whole[:-20]  # another process may be writing that line
    assert [x.name for x in tmp_path.iterdir()] == [path.name]


@posix
def test_a_link_called_as_the_lock_is_not_followed(tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("mine", encoding="utf-8")
    (tmp_path / ".records.jsonl.lock").symlink_to(precious)
    with pytest.raises(UsageError, match="cannot be written"):
        RecordFile(tmp_path / "records.jsonl").append(TASKS[0], {"outcome": "completed"})
    assert precious.read_text(encoding="utf-8") == "mine"


@posix
def test_a_file_has_one_lock_whatever_links_lead_to_it(tmp_path):
    path, link = tmp_path / "a" / "records.jsonl", tmp_path / "b" / "linked.jsonl"
    RecordFile(path).append(TASKS[0], {"outcome": "completed"})
    link.parent.mkdir()
    link.symlink_to(path)
    with RecordFile(link).exclusive(), pytest.raises(UsageError, match="is in use by process"):
        RecordFile(path).append(TASKS[1], {"outcome": "completed"})


@posix
def test_a_pipe_in_place_of_the_file_for_damaged_lines_is_refused_at_once(tmp_path):
    path = tmp_path / "records.jsonl"
    RecordFile(path).append(TASKS[0], {"outcome": "completed"})
    path.write_bytes(path.read_bytes() + b"damaged\n")
    os.mkfifo(tmp_path / "records.jsonl.aside")
    with pytest.raises(UsageError, match="cannot be written"):
        RecordFile(path).append(TASKS[1], {"outcome": "completed"})


@pytest.mark.parametrize("how", ["deleted", "replaced", "changed"])
def test_a_file_that_another_program_changes_is_not_written_on(tmp_path, how):
    path = tmp_path / "records.jsonl"
    store = RecordFile(path)
    with store.exclusive():
        store.append(TASKS[0], {"outcome": "completed"})
        if how == "changed":
            path.write_bytes(path.read_bytes() + b"x\n")
        else:
            path.unlink()
        if how == "replaced":
            path.write_bytes(b"of somebody\n")
        before = path.read_bytes() if path.exists() else None
        with pytest.raises(UsageError, match="changed, moved or deleted"):
            store.append(TASKS[1], {"outcome": "completed"})
    assert (path.read_bytes() if path.exists() else None) == before


def test_without_locks_of_the_system_an_empty_lock_file_is_respected(tmp_path, monkeypatch):
    """On a full disk the holder cannot write who it is."""
    monkeypatch.setattr(Lock, "_flock", lambda *_: False)
    monkeypatch.setattr(Lock, "_sign", lambda *_: None)
    first, second = (Lock(tmp_path / ".lock", "it") for _ in range(2))
    with (
        first,
        pytest.raises(UsageError, match=r"in use by another process.*delete .*\.locked"),
    ):
        second.acquire()
    assert list(tmp_path.iterdir()) == []
    with Lock(tmp_path / ".lock", "it"):
        pass


def _squares(task):
    return {"outcome": "completed", "square": task["n"] ** 2}


def test_a_folder_whose_first_file_was_deleted_goes_on(tmp_path):
    tasks = [{"n": k} for k in range(10)]
    measure(_squares, tasks[:6], RecordFolder(tmp_path, each=3))
    (tmp_path / "records-000001.jsonl").unlink()
    assert measure(_squares, tasks, RecordFolder(tmp_path, each=3)) == 7  # did not end
    assert sorted(x["square"] for x in RecordFolder(tmp_path).records()) == [
        k * k for k in range(10)
    ]


def test_a_copy_of_a_file_in_a_folder_is_refused(tmp_path):
    measure(_squares, [{"n": k} for k in range(3)], RecordFolder(tmp_path))
    first = tmp_path / "records-000001.jsonl"
    (tmp_path / "records-000002.jsonl").write_bytes(first.read_bytes())
    with pytest.raises(DataError, match=r"records-000002\.jsonl: 3 of its records"):
        RecordFolder(tmp_path)


def test_each_bit_of_a_record_that_flips_is_seen(tmp_path):
    path = tmp_path / "records.jsonl"
    measured = {"error": 1.2345e-08, "seconds": 0.0019999999999999914, "outcome": "completed"}
    RecordFile(path).append(TASKS[0], measured)
    content, right = path.read_bytes(), read_records(path)
    for k in range(8 * (len(content) - 1)):
        changed = bytearray(content)
        changed[k // 8] ^= 1 << k % 8
        path.write_bytes(changed)
        found = scan(path)
        assert found.faults and found.records in ([], right), (k, bytes(changed))


@pytest.mark.parametrize("piece", [b'{"format":"', b'{"format":"x","a":'])
def test_a_long_line_that_begins_as_many_records_is_read_in_linear_time(tmp_path, piece):
    path = tmp_path / "records.jsonl"
    RecordFile(path).append(TASKS[0], {"outcome": "completed"})
    path.write_bytes(path.read_bytes()[:-1] + piece * 100_000)  # took half a minute
    begun = time.process_time()
    assert len(scan(path).records) == 1
    assert time.process_time() - begun < 2


def test_the_ends_of_lines_of_a_file_are_not_changed_on_windows(tmp_path, monkeypatch):
    binary, flags, true_open = 1 << 40, {}, os.open

    def seen(path, given, mode=0o777):
        flags.setdefault(str(path), []).append(given & binary)
        return true_open(path, given & ~binary, mode)

    monkeypatch.setattr(os, "open", seen)
    for module in (files, records):
        monkeypatch.setattr(module, "BINARY", binary)
    path = tmp_path / "records.jsonl"
    measure(lambda task: {"x": 1}, [{"method": "a"}], RecordFile(path))
    files.read_bytes(path, 1000)
    assert flags[str(path)] == [binary] * len(flags[str(path)])
