"""What `glmref verify` keeps: the same words with it and without, and no word for anything else."""

import json
import os
import shutil
from pathlib import Path

import pytest

from glmref.catalogue.files import path_of
from glmref.cli import main, parallel
from glmref.findings import Finding, Verdict
from glmref.prove import verdict_cache as kept
from glmref.prove.verifier import verify_file
from glmref.system import cache

NAMES = ["rk4", "suzuki-4", "rkf45-3554"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.setattr(kept, "private_folder", cache.private_folder)
    return tmp_path / "cache" / "verdicts"


@pytest.fixture
def own(tmp_path):
    """A file of one's own, which may be changed."""
    return Path(shutil.copy(path_of("rk4"), tmp_path / "mine.json"))


def asked(path, only=(), budget=None):
    found = kept.question(path, only, budget)
    assert found is not None
    return found


def checked(path) -> list[Finding]:
    """Check a file with the cache, as `glmref verify` does."""
    return parallel.check(str(path), keep=True).findings


def unanswered(*arguments, **more):
    raise AssertionError("it was computed")


@pytest.mark.sampled(1)
@pytest.mark.parametrize("form", ["table", "json", "csv", "junit"])
def test_the_output_is_the_same_with_the_cache_and_without(form, folder, own, capsys, monkeypatch):
    names = [*NAMES, str(own)]

    def output(*options):
        code = main(["verify", *names, "--format", form, *options])
        return code, capsys.readouterr()

    without = output("--no-cache")
    assert not folder.exists()
    first = output()
    assert len(list(folder.iterdir())) == len(names)
    monkeypatch.setattr("glmref.prove.verifier.verify_file", unanswered)
    assert without == first == output()
    assert output("--only", "order") != first  # another question


def test_no_cache_reads_nothing_that_was_kept(folder, own, monkeypatch, cli):
    checked(own)
    monkeypatch.setattr("glmref.prove.verifier.verify_file", unanswered)
    assert "it was computed" in cli("verify", own, "--no-cache", code=3).err


def test_an_entry_answers_for_its_bytes_its_name_its_claims_and_its_budget_alone(folder, own):
    found = checked(own)
    assert kept.look_up(asked(own)) == found
    (entry,) = folder.iterdir()
    renamed = Path(shutil.copy(own, own.with_name("other.json")))
    changed = own.with_name("changed.json")
    changed.write_text(own.read_text().replace('"1/6"', '"1/7"'))
    for question in (
        asked(renamed), asked(changed), asked(own, ["order"]), asked(own, budget=1.0),
    ):  # fmt: skip
        assert kept.look_up(question) is None
        # an entry put where the answer to another question is looked for
        assert question.entry is not None
        shutil.copy(entry, question.entry)
        assert kept.look_up(question) is None
    own.write_text(changed.read_text())
    assert [x.verdict for x in checked(own)] != [x.verdict for x in found]


def test_another_code_and_other_libraries_answer_for_themselves(folder, own, monkeypatch):
    checked(own)
    monkeypatch.setattr(kept, "LIBRARY", "FLINT 4")
    assert kept.look_up(asked(own)) is None
    monkeypatch.undo()
    assert cache.cache_folder() != folder.parent  # the environment is the test's again


def test_code_that_changes_asks_another_question(own, monkeypatch):
    before = asked(own).asked["code"]
    monkeypatch.setattr(kept, "SUBPACKAGES", kept.SUBPACKAGES[1:])
    assert asked(own).asked["code"] != before


def test_an_entry_with_any_byte_changed_says_nothing(folder, own):
    checked(own)
    (entry,) = folder.iterdir()
    whole = entry.read_bytes()
    for at in range(0, len(whole), 7):
        entry.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        assert kept.look_up(asked(own)) is None
    for damaged in (b"", whole[: len(whole) // 2], whole + b" ", b"\xff\n" * 9):
        entry.write_bytes(damaged)
        assert kept.look_up(asked(own)) is None
    entry.write_bytes(whole)
    assert kept.look_up(asked(own)) is not None


def rewritten(entry: Path, **changes) -> None:
    """Change what an entry says, and its checksum with it."""
    document = json.loads(entry.read_bytes()[32:]) | changes
    text = json.dumps(document).encode()
    entry.write_bytes(kept.hashlib.sha256(text).digest() + text)


@pytest.mark.parametrize(
    "changes",
    [
        {"format": "glmref-kept-findings-0"},
        {"read": {"/no/such/file": "0" * 64}},
        {"read": []},
        {"findings": [{"verdict": "holds"}]},
        {"findings": [{"verdict": "true", "proof": "exact"}]},
        {"findings": None},
    ],
    ids=str,
)
def test_an_entry_of_another_form_says_nothing(changes, folder, own):
    checked(own)
    (entry,) = folder.iterdir()
    rewritten(entry)
    assert kept.look_up(asked(own)) is not None
    rewritten(entry, **changes)
    assert kept.look_up(asked(own)) is None


def test_an_entry_of_somebody_else_says_nothing(folder, own, monkeypatch):
    checked(own)
    (entry,) = folder.iterdir()
    folder.chmod(0o777)  # anybody could put one there
    assert kept.look_up(asked(own)) is None
    folder.chmod(0o700)
    assert kept.look_up(asked(own)) is not None
    mine = os.getuid()
    monkeypatch.setattr("os.getuid", lambda: mine + 1)
    monkeypatch.setattr(kept, "private_folder", lambda name: folder)
    assert kept.look_up(asked(own)) is None


def test_what_a_composition_is_made_of_counts(folder):
    path = path_of("suzuki-4")
    base = path_of(json.loads(path.read_text())["base"])
    found = [x for x in checked(path) if x.claim]
    (entry,) = folder.iterdir()
    read = json.loads(entry.read_bytes()[32:])["read"]
    assert list(read) == [str(base)]
    assert kept.look_up(asked(path)) == found
    rewritten(entry, read={str(base): "0" * 64})
    assert kept.look_up(asked(path)) is None


def test_a_file_that_changes_while_it_is_checked_is_not_kept(folder, own, monkeypatch):
    def changing(name, **more):
        text = own.read_text()
        own.write_text(text.replace('"1/6"', '"1/7"'))
        found = verify_file(name, **more)
        own.write_text(text)
        return found

    monkeypatch.setattr("glmref.prove.verifier.verify_file", changing)
    assert any(x.verdict is Verdict.FAILS for x in checked(own))
    assert not list(folder.iterdir())


def test_what_is_open_is_not_kept(folder, own):
    found = parallel.check(str(own), budget=1e-9, keep=True).findings
    assert Verdict.OPEN in {x.verdict for x in found}
    assert not list(folder.iterdir())


def test_a_cache_that_cannot_be_written_costs_the_cache_alone(tmp_path, own, monkeypatch):
    monkeypatch.setattr(kept, "private_folder", cache.private_folder)
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(blocked / "below"))
    assert {x.verdict for x in checked(own)} == {Verdict.HOLDS}

    def full(*arguments, **more):
        raise OSError(28, "No space left on device")

    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.setattr(cache, "replace_whole", full)
    assert {x.verdict for x in checked(own)} == {Verdict.HOLDS}


def test_code_that_moves_to_another_module_is_other_code(tmp_path, monkeypatch):
    """The same bytes one after another, in modules of other names or lengths."""
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "system" / "cache.py"))
    (tmp_path / "exact").mkdir()
    (tmp_path / "lone.py").write_text("z")
    found = set()
    for texts in ({"a": "x", "b": "y"}, {"a": "xy", "b": ""}, {"a": "x", "c": "y"}, {"a": "xy"}):
        for path in (tmp_path / "exact").iterdir():
            path.unlink()
        for name, text in texts.items():
            (tmp_path / "exact" / f"{name}.py").write_text(text)
        found.add(cache.sources.__wrapped__("exact", "lone.py"))
    assert len(found) == 4


def test_a_table_that_the_package_reads_is_part_of_its_code(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "system" / "cache.py"))
    found = set()
    for place in ("", "problems/named.toml", "data/methods/euler.json", "problems/note.txt"):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        if place:
            (tmp_path / place).write_text("x")
        found.add(cache.sources.__wrapped__())
    assert len(found) == 2, "the catalogue and notes are no code"
