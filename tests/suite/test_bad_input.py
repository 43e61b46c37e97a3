"""Bad input of every kind: one sentence, exit code 2, within two seconds, no traceback."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from glmref import check
from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.cli import main
from glmref.errors import DataError
from tests.build import refused

#: Seconds of processor time until the sentence is there; the slowest kind takes about a tenth of it.
LIMIT = 2.0


def _without(keys: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in keys.items() if value is not None}


def _with(base: str = "gsymplectic-n", /, **changes: Any) -> bytes:
    """A document with some keys changed; ``None`` takes a key out."""
    return json.dumps(_without({**(BASES.get(base) or document(base)), **changes})).encode()


def _content(row: dict[str, Any]) -> bytes:
    """The content of a file of ``refused.json``."""
    base = row.get("of", "gsymplectic-n")
    doc, changes = BASES.get(base) or document(base), dict(row.get("set", {}))
    if "text" in row:
        return row["text"].encode("latin-1")
    if "document" in row:
        return json.dumps(row["document"]).encode()
    if "replace" in row:
        return _replaced(base, *row["replace"])
    if "in" in row:
        changes = {row["in"]: _without({**doc[row["in"]], **changes})}
    if "entry" in row:
        (_, *rest), *rows = doc["A"]
        changes["A"] = [[row["entry"], *rest], *rows]
    return _with(base, **changes)


def _replaced(base: str, old: str, new: str) -> bytes:
    text = json.dumps(document(base))
    assert old in text
    return text.replace(old, new, 1).encode()


_REFUSED = json.loads(Path(__file__).with_name("refused.json").read_text(encoding="utf-8"))
BASES: dict[str, dict[str, Any]] = _REFUSED["bases"]
#: What the reader says of a file, where that is looked at.
SAID: dict[str, str] = {kind: x["said"] for kind, x in _REFUSED["files"].items() if "said" in x}
#: What `glmref.check` is asked about, which takes plain tableaux.
CHECKED = {kind for kind, x in _REFUSED["files"].items() if x.get("by") == "check"}
FILES: dict[str, bytes | Callable[[], bytes]] = {
    **{kind: _content(row) for kind, row in _REFUSED["files"].items()},
    "two-documents": _with() * 2,
    "ten-megabytes": lambda: _with(title="x" * 10_000_000),
    "deep-nesting": b"[" * 100_000 + b"]" * 100_000,
    "deep-nesting-unclosed": b"[" * 3_000_000,
    "quotes-without-end": b"[" + b'\\"' * 1_900_000,
    "long-float": _replaced("gsymplectic-n", '"(3-sqrt(3))/6"', "0." + "3" * 5000),
    "huge-integer": _replaced("gsymplectic-n", '"(3-sqrt(3))/6"', "9" * 5000),
    "matrix-1000-by-1000": lambda: _with(A=[["0"] * 1000] * 1000),
    "row-of-1000": lambda: _with(A=[["0"] * 1000] * 3),
    "matrix-201-rows": lambda: _with(A=[["0"] * 200] * 201),
    "long-entry": _content({"entry": "1+" * 4000 + "1"}),
}

#: Command lines of any length; others are rows of ``tests/unit/refusals.toml``.
ARGUMENTS: dict[str, list[str]] = {
    "name-far-too-long": ["verify", "a" * 100_000],
    "file-name-too-long": ["verify", "a" * 5000 + ".json"],
    "device": ["verify", os.devnull],
}


#: Kinds of files in which only claims, or their proofs, are wrong.
CLAIMED = (
    *("claims-missing", "claims-empty"),  # a bare tableau
    "broken-names-no-claim",
    "enclosure-radius",
    "start-of-another",
    "start-of-fewer",
)


def _spent() -> float:
    """Processor time of this process and those it waited for: other programs change it little."""
    return sum(os.times()[:4])


@pytest.fixture
def one_sentence(capsys: pytest.CaptureFixture[str]) -> Callable[..., None]:
    """Assert that a command of these words says what is wrong in one sentence."""

    def run(*words: str) -> None:
        _assert_one_sentence(main([*words]), *capsys.readouterr())

    return run


def _assert_one_sentence(code: int, out: str, err: str) -> None:
    assert code == 2
    assert out == ""
    assert err.startswith("glmref: ")
    assert err.count("\n") == 1
    assert err.endswith("\n")
    assert all(x.isprintable() for x in err[:-1])
    assert len(err) < 1000
    assert "Traceback" not in err
    assert "internal" not in err


def test_at_least_45_kinds_of_bad_input_are_tried() -> None:
    assert len(FILES) + len(ARGUMENTS) >= 45


@pytest.mark.sampled(10)
@pytest.mark.parametrize("command", ["verify", "show"])
@pytest.mark.parametrize("kind", sorted(FILES.keys() - SAID.keys()))
def test_bad_file_gives_one_sentence_and_exit_2(kind, command, tmp_path, capsys):
    if command == "show" and kind.startswith(CLAIMED):
        pytest.skip("what is claimed plays no part in show")
    content = FILES[kind]
    file = tmp_path / "method.json"
    file.write_bytes(content if isinstance(content, bytes) else content())
    started = _spent()
    code = main([command, str(file)])
    assert _spent() - started < LIMIT
    out, err = capsys.readouterr()
    _assert_one_sentence(code, out, err)
    assert "method.json: " in err


@pytest.mark.parametrize("kind", SAID)
def test_the_reader_says_what_is_wrong(kind: str) -> None:
    content = FILES[kind]
    assert isinstance(content, bytes)
    refused(DataError, SAID[kind], check if kind in CHECKED else load_document, json.loads(content))


@pytest.mark.parametrize("name", BASES)
def test_the_bases_of_files_that_are_refused_are_read(name: str) -> None:
    assert load_document(BASES[name]).components


@pytest.mark.parametrize("kind", ARGUMENTS)
def test_bad_argument_gives_one_sentence_and_exit_2(kind, capsys):
    started = _spent()
    code = main(ARGUMENTS[kind])
    assert _spent() - started < LIMIT
    _assert_one_sentence(code, *capsys.readouterr())


@pytest.mark.sampled(1, besides=("s5t",))
@pytest.mark.parametrize("base", ["gsymplectic-n", "stormer-verlet", "yoshida-4", "s5t-w3", "ab-2"])
def test_the_documents_the_bad_ones_are_made_of_are_good(base: str, tmp_path: Path, cli) -> None:
    file = tmp_path / "method.json"
    file.write_bytes(_with(base))
    assert cli("verify", file).err == ""


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read all")
def test_unreadable_file_gives_one_sentence(tmp_path, one_sentence):
    file = tmp_path / "method.json"
    file.write_bytes(_with())
    file.chmod(0)
    one_sentence("verify", str(file))


def test_link_to_itself_gives_one_sentence(tmp_path, one_sentence):
    link = tmp_path / "method.json"
    link.symlink_to(link)
    one_sentence("verify", str(link))


def test_file_name_with_a_line_end_stays_on_one_line(tmp_path, one_sentence):
    file = tmp_path / "a\n\x1b[2Jb.json"
    file.write_text("{}")
    one_sentence("verify", str(file))


def test_a_bad_file_among_good_ones_costs_only_its_own_result(tmp_path, capsys):
    file = tmp_path / "method.json"
    file.write_bytes(FILES["float"])  # type: ignore[arg-type]
    code = main(["verify", "euler", str(file), "no-such-method", "rk4", "--format", "json"])
    out, err = capsys.readouterr()
    assert code == 2
    assert {f["method"] for f in json.loads(out)["findings"]} == {"euler", "rk4"}
    assert [line.partition(":")[0] for line in err.splitlines()] == ["glmref", "glmref"]


@pytest.mark.sampled(0)
@pytest.mark.parametrize("kind", ["deep-nesting", "code", "squares-of-squares"])
def test_the_program_itself_says_it_in_one_sentence_within_two_seconds(kind, tmp_path):
    content = FILES[kind]
    assert isinstance(content, bytes)
    file = tmp_path / "method.json"
    file.write_bytes(content)
    done = subprocess.run(
        [sys.executable, "-m", "glmref", "verify", str(file)],
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )
    _assert_one_sentence(done.returncode, done.stdout, done.stderr)
