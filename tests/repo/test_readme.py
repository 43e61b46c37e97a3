"""README is true: its table is computed, its commands and examples run."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from glmref.catalogue.lookup import data_root, document, names
from glmref.catalogue.reader import load_document

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
FAMILIES = {
    "rk": "Runge-Kutta",
    "lmm": "linear multistep and one-leg",
    "glm": "general linear, multivalue",
    "partitioned": "partitioned pairs",
}


def verified_table() -> str:
    """The table of what is verified, from the data files alone."""
    lines = ["| family | methods | orders | claims | G-symplectic | symmetric | parasitism-free |"]
    lines.append("|---|---|---|---|---|---|---|")
    for folder, title in FAMILIES.items():
        claims = [
            document(path.stem)["claims"]
            for path in sorted((data_root() / "methods" / folder).glob("*.json"))
        ]
        orders = [c["order"] for c in claims if "order" in c]
        count: Counter[str] = Counter(k for c in claims for k, v in c.items() if v is True)
        conserving = [c for c in claims if c.get("g-symplectic") or c.get("symplectic")]
        lines.append(
            f"| {title} | {len(claims)} | {min(orders)} to {max(orders)} "
            f"| {sum(map(len, claims))} | {len(conserving)} "
            f"| {count['symmetric']} | {count['parasitism-free']} |"
        )
    lines.append(f"| refuted: wrong on purpose | {len(names('broken'))} | | | | | |")
    return "\n".join(lines)


def test_the_table_of_what_is_verified_is_the_computed_one() -> None:
    start, end = "<!-- table: verified -->\n", "\n<!-- end of table -->"
    shown = README[README.index(start) + len(start) : README.index(end)]
    assert shown == verified_table(), f"put this into README.md:\n{verified_table()}"


def test_the_json_example_loads() -> None:
    block = re.search(r"```json\n(.*?)```", README, re.DOTALL)
    assert block is not None
    assert load_document(json.loads(block[1])).name == "my-heun"


def test_the_python_example_runs() -> None:
    block = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert block is not None
    done = subprocess.run(
        [sys.executable, "-c", block[1]], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "2"


COMMANDS = re.findall(r"^\$ (glmref .*)$", README, re.MULTILINE)


def test_the_commands_are_found() -> None:
    assert len(COMMANDS) >= 11


@pytest.mark.parametrize("line", COMMANDS)
def test_the_commands_exist(line: str, tmp_path: Path) -> None:
    example = re.search(r"```json\n(.*?)```", README, re.DOTALL)
    assert example is not None
    (tmp_path / "my-method.json").write_text(example[1], encoding="utf-8")
    words = line.partition("#")[0].split()[1:]
    done = subprocess.run(
        [sys.executable, "-m", "glmref", *words],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def test_the_two_set_up_commands_are_those_ci_runs() -> None:
    block = re.search(r"## Two commands\n+```console\n(.*?)```", README, re.DOTALL)
    assert block is not None
    first, second = block[1].splitlines()
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for part in (*first.split(" && "), second):
        words = part.replace(".venv/bin/", "").split()
        pattern = r"[^\n]*?".join(map(re.escape, words))  # options may stand between the words
        assert re.search(pattern.replace(r"\.venv", "[^\n]*venv"), ci.replace('"', "")), part


if __name__ == "__main__":  # write the computed table into README.md
    start, end = "<!-- table: verified -->\n", "<!-- end of table -->"
    before, _, rest = README.partition(start)
    text = before + start + verified_table() + "\n" + end + rest.partition(end)[2]
    (ROOT / "README.md").write_text(text, encoding="utf-8")
