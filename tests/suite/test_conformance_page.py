"""The pages on the suite are true: their adapters pass, the slip is named, the protocol is ours."""

import importlib
import json
import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from glmref.cli import main as glmref_main
from glmref.conformance.adapter import SHIPPED
from glmref.conformance.checks import RESTS_ON
from glmref.conformance.subject import OPERATIONS
from glmref.conformance.vector_problems import problems

PAGES = [Path(__file__).parents[2] / "docs" / f"{x}.md" for x in ("conformance", "adapters")]
if not PAGES[0].is_file():
    pytest.skip("the documentation is not part of this copy", allow_module_level=True)
TEXT = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
#: The files of the pages: a block of Python behind its name.
FILES = dict(re.findall(r"`(\w+\.py)`:\n\n```python\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL))
assert FILES.keys() == {"mine.py", "method_n.py", "midpoint.py"}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with the files of the pages."""
    for name, block in FILES.items():
        (tmp_path / name).write_text(block, encoding="utf-8")
        monkeypatch.delitem(sys.modules, Path(name).stem, raising=False)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    importlib.invalidate_caches()
    yield tmp_path
    for name in FILES:
        sys.modules.pop(Path(name).stem, None)


def commands() -> list[tuple[list[str], int, str]]:
    """Words, exit code and output of each command that is shown with its output."""
    found = []
    for _, block in BLOCKS:
        line, _, shown = block.partition("\n")
        if line.startswith("$ ") and shown:
            words, _, remark = line[2:].partition("#")
            code = re.search(r"exit (\d)", remark)
            found.append((shlex.split(words), int(code[1]) if code else 0, shown))
    return found


@pytest.mark.slow
@pytest.mark.sampled(1, besides=("9 of 24",))
@pytest.mark.parametrize(("words", "code", "shown"), commands(), ids=lambda x: str(x)[:60])
def test_a_command_does_what_the_page_shows(here, capsys, words, code, shown):
    if words[:3] == ["python", "-m", "glmref.conformance"]:
        words = ["conformance", *words[3:]]
    else:
        words = words[1:]
    words = [x.replace("cmd:python", f"cmd:{shlex.quote(sys.executable)}") for x in words]
    assert glmref_main(words) == code
    pattern = re.escape(shown.rstrip("\n")).replace(re.escape("..."), ".*?")
    assert re.fullmatch(pattern, capsys.readouterr().out.rstrip("\n"), re.DOTALL)


@pytest.mark.slow
def test_the_smallest_adapter_passes_and_is_read_as_what_it_is(here: Path, capsys) -> None:
    assert glmref_main(["conformance", "mine:RungeKutta4"]) == 0
    assert "13 of 13 hold" in capsys.readouterr().out
    assert glmref_main(["conformance", "mine:RungeKutta4", "--identify", "--format", "json"]) == 0
    (probe,) = json.loads(capsys.readouterr().out)["probes"]
    assert [x["name"] for x in probe["matches"]] == ["rk4"]


def test_the_tables_name_every_operation_claim_problem_and_shipped_adapter() -> None:
    quoted = set(re.findall(r"`([\w+-]+)[`(]", TEXT))
    assert {*OPERATIONS, *SHIPPED, *problems()} - {"rigid-body"} <= quoted
    claims = TEXT.partition("## What is checked")[2].partition("\n## ")[0]
    rows = {
        name
        for line in claims.splitlines()
        if line.startswith("| `")
        for name in re.findall(r"`(\w+)`", line.split("|")[1])
    }
    assert {x.rstrip("P") for x in rows} == set(RESTS_ON)


def test_the_numbers_of_the_dialogue_are_right() -> None:
    """One step of the explicit midpoint rule on the cubic oscillator, in doubles."""
    (dialogue,) = [block for _, block in BLOCKS if block.startswith('> {"ask": "describe"}')]
    lines = re.sub(r",\n +", ", ", dialogue).splitlines()
    said = [json.loads(line[2:]) for line in lines]
    step, first, slope, second, other, answer = said[2:]
    cubic, y, h = problems()["cubic"].problem, np.array(step["values"]), step["h"]
    assert first == {"ask": "f", "t": step["t"], "y": step["values"]}
    assert slope["values"] == cubic.f(0.0, y).tolist()
    half = y + h / 2 * np.array(slope["values"])
    assert second == {"ask": "f", "t": h / 2, "y": half.tolist()}
    assert other["values"] == cubic.f(h / 2, half).tolist()
    assert answer["values"] == (y + h * np.array(other["values"])).tolist()
