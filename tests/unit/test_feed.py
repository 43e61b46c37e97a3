"""The feed: valid, the same bytes twice, and readable by a client written from its page."""

import json
import os
import re
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.canonical import canonical, checksums
from glmref.catalogue.files import data_root, names
from glmref.errors import DataError
from glmref.exchange.feed import VERSION, output_folder, write_feed

DOCS = Path(__file__).parents[2] / "docs"
CHOSEN = ("dormand-prince-5-4", "gauss-2", "gauss-2-seven-digits", "tsitouras-5-4")


@pytest.fixture(scope="module")
def feed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("feed")
    write_feed(output_folder(folder), CHOSEN)
    return folder


def read(path: Path) -> Any:
    def no_float(text: str) -> None:
        raise AssertionError(f"{path.name}: the number {text} is a float")

    return json.loads(path.read_text(encoding="utf-8"), parse_float=no_float)


def invalid(root: Path, *names: str) -> list[str]:
    """What is not valid against the schema of its format: in all files, or in those named."""
    validator = pytest.importorskip("jsonschema").Draft202012Validator
    found, schemas = [], {}
    for path in sorted((root / "schema").iterdir()):
        schema = read(path)
        schemas[path.name.removesuffix(".schema.json")] = validator(schema)
    for path in [root / name for name in names] or sorted(root.rglob("*.json")):
        document = read(path)
        form = document.get("format", "")
        if form.startswith("glmref-feed-"):
            form = "glmref-feed-1"
        elif form.startswith("glmref-vector"):
            form = "glmref-vectors-1"
        if form in schemas:
            found += [
                f"{path.name}: {x.message[:200]}" for x in schemas[form].iter_errors(document)
            ]
        if form == "glmref-feed-1" and "document" in document:
            inner = document["document"]
            found += [
                f"{path.name}: {x.message}" for x in schemas[inner["format"]].iter_errors(inner)
            ]
    return found


@pytest.mark.slow
def test_every_file_is_valid_and_listed_with_its_hash(feed: Path) -> None:
    root = feed / VERSION
    files = ("index.json", "methods/gauss-2.json", "problems/kepler.json", "problems/index.json")
    assert invalid(root, *files) == []
    sums = (root / "SHA256SUMS").read_text()
    assert sums == checksums(root)
    listed = {line.split("  ")[1] for line in sums.splitlines()}
    everything = {x.relative_to(root).as_posix() for x in root.rglob("*") if x.is_file()}
    assert listed == everything - {"SHA256SUMS"}
    for row in read(root / "index.json")["methods"]:
        assert f"{row['sha256']}  {row['path']}\n" in sums


@pytest.mark.slow
def test_the_schema_refuses_what_is_wrong(feed: Path, tmp_path: Path) -> None:
    shutil.copytree(feed / VERSION, tmp_path / "v1")
    index = tmp_path / "v1" / "index.json"
    document = read(index)
    document["methods"][0]["verdicts"]["order"] = "true"
    del document["methods"][1]["sha256"]
    index.write_text(canonical(document))
    (said,) = invalid(tmp_path / "v1", "index.json")
    assert said.startswith("index.json: ")


def test_exact_text_decimals_and_doubles_are_one_number(feed: Path) -> None:
    block = read(feed / VERSION / "methods" / "dormand-prince-5-4.json")["blocks"]["A"]
    for exact, decimal, double in zip(*block.values(), strict=True):
        exact, decimal, double = (block[key][5] for key in ("exact", "decimal", "double"))
        for a, b, c in zip(exact, decimal, double, strict=True):
            value = Fraction(a)
            assert abs(Fraction(b) - value) <= abs(value) / 10**39 / 2
            assert float.fromhex(c) == float(value)


def test_no_digit_is_written_that_is_not_known(feed: Path) -> None:
    root = feed / VERSION
    rows = {row["name"]: row for row in read(root / "index.json")["methods"]}
    vague = rows["gauss-2-seven-digits"]
    assert not vague["exact"] and vague["known"] < 16
    block = read(root / vague["path"])["blocks"]["A"]
    assert max(len(x.lstrip("-0.")) for row in block["decimal"] for x in row) < 17
    assert rows["gauss-2"]["exact"] and rows["gauss-2"]["known"] == 40


def client(feed: Path, folder: Path) -> str:
    (code,) = re.findall(r"^```py\n(.*?)^```$", (DOCS / "feed.md").read_text(), re.M | re.S)
    assert len(code.splitlines()) <= 60
    (folder / "client.py").write_text(code)
    command = [sys.executable, "-I", "client.py", str(feed)]
    return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout


def test_a_client_written_from_the_page_lists_pairs_with_their_defects(feed, tmp_path):
    lines = client(feed, tmp_path).splitlines()
    assert "dormand-prince-5-4: 7 stages, embedded of order 4" in lines
    at = lines.index("tsitouras-5-4: 7 stages, embedded of order 4")
    assert "  torchdiffeq torchdiffeq/_impl/tsit5.py:6 _TSITOURAS_TABLEAU" in lines[at:]
    assert lines[at + 2] == "    order 4, not 5"
    assert not any("gauss" in line for line in lines)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "--output"),
        (["--output", ".", "--methods", "x.json"], "the feed has shipped methods only"),
        (["--output", "there"], "there/v1 is there already; remove it"),
    ],
)
def test_bad_input_is_one_sentence(words, said, tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there" / "v1").mkdir(parents=True)
    assert said in cli("feed", *words, code=2).err


def test_a_certificate_that_states_another_verdict_is_an_error(tmp_path: Path) -> None:
    root = output_folder(tmp_path)
    (root / "certificates").mkdir()
    wrong = {"statement": {"verdict": "fails"}}
    (root / "certificates" / "rk4.order.json").write_text(json.dumps(wrong))
    with pytest.raises(DataError, match=r"rk4\.order\.json: the certificate states that the claim"):
        write_feed(root, ["rk4"])


@pytest.mark.slow
def test_the_same_bytes_on_another_machine(tmp_path: Path) -> None:
    """Another order of sets, language, time zone and set of instructions of the linear algebra."""
    chosen = ("g6245", "gauss-3", "bdf-2", "rk4")
    machines = [
        {"PYTHONHASHSEED": "1", "TZ": "UTC", "LC_ALL": "C", "OPENBLAS_CORETYPE": "Haswell"},
        {
            "PYTHONHASHSEED": "2",
            "TZ": "Asia/Tokyo",
            "LC_ALL": "C.UTF-8",
            "OPENBLAS_CORETYPE": "Prescott",
        },
    ]
    sums = []
    for n, machine in enumerate(machines):
        command = [sys.executable, "-m", "glmref", "feed", "--output", str(tmp_path / str(n))]
        options = [word for name in chosen for word in ("--methods", name)]
        subprocess.run([*command, *options], check=True, env={**os.environ, **machine})
        sums.append((tmp_path / str(n) / VERSION / "SHA256SUMS").read_text())
    assert sums[0] == sums[1] and "certificates/gauss-3.order.json" in sums[0]
    root = tmp_path / "0" / VERSION
    assert (
        invalid(root, *(f"certificates/{x.name}" for x in (root / "certificates").iterdir())) == []
    )


@pytest.mark.slow
def test_the_whole_feed_is_valid_and_the_client_finds_what_the_audits_say(tmp_path: Path) -> None:
    root = output_folder(tmp_path)
    assert write_feed(root) == len(names("all"))
    files = sorted(x.relative_to(root).as_posix() for x in root.rglob("*.json"))
    assert invalid(root, *files[::7], "index.json", "audits.json", "problems/trees.json") == []
    said = client(tmp_path, tmp_path)
    rows = json.loads((data_root() / "measurements" / "verification.json").read_bytes())["findings"]
    found: dict[str, dict[str, Any]] = {}
    for row in rows:
        found.setdefault(row["method"], {})[row["claim"]] = row["value"]
    pairs = {x for x in names() if found[x].get("order") == 5 and found[x].get("embedded-order")}
    assert len(pairs) > 5 and pairs == set(re.findall(r"^(\S+): \d+ stages", said, re.M))
    wrong = [
        table
        for path in sorted((data_root() / "audits").glob("*.json"))
        for table in read(path)["tables"]
        if table["status"] == "wrong" and table.get("nearest", {}).get("method") in pairs
    ]
    for path in (root / "schema").iterdir():
        pytest.importorskip("jsonschema").Draft202012Validator.check_schema(read(path))
    assert wrong
    assert all(f"{x['path']}:{x['line']}" in said for x in wrong)
