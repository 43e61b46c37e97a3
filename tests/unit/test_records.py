"""Records survive: keys depend on content, torn lines are dropped, others are refused."""

import json
import math
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.compute.records import RecordFile, checksum, finite, key_of, read_records
from glmref.errors import DataError, UsageError

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
