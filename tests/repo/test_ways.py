"""The ways of docs/ways.md: scripts of at most five commands, run in a clone called glmref; a notebook."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WAYS = sorted((ROOT / "docs" / "ways").glob("*.sh"))
SAID = {
    "analyst": [
        "L-stable", "4 hold, 0 fail, 0 open", "wrote my-method.svg", "open pages/index.html",
    ],
    "author": [
        "13 holds, 0 fails", "its coefficients differ: B[1][2]", "exit code 1", "is rk4 (to 0)",
    ],
    "contributor": ["1 hold, 0 fail", "wrote data/SHA256SUMS", "passed"],
}  # fmt: skip


def commands(script: Path) -> list[str]:
    """Lines of a script that are no remark."""
    lines = script.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def test_each_way_has_five_commands_at_most_and_stands_on_its_page() -> None:
    assert {path.stem for path in WAYS} >= set(SAID)
    page = (ROOT / "docs" / "ways.md").read_text(encoding="utf-8")
    for path in WAYS:
        assert 1 <= len(commands(path)) <= 5, path.name
        assert f"ways/{path.name}" in page or path.stem not in SAID


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A clone in a folder named as git names it, and `glmref` and `python` as in an environment of it."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("no git checkout")
    folder = tmp_path / "glmref"
    command = ["git", "clone", "--quiet", "--local", str(ROOT), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    if done.returncode:
        pytest.skip(f"git clone: {done.stderr.strip()}")
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, words in (("glmref", "-m glmref "), ("python", "")):
        (programs / name).write_text(
            f'#!/bin/sh\nexec "{sys.executable}" {words}"$@"\n', encoding="utf-8"
        )
        (programs / name).chmod(0o755)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("way", sorted(SAID))
def test_a_way_leads_where_it_says(way: str, clone: Path) -> None:
    if way == "author" and shutil.which("cc") is None:
        pytest.skip("no C compiler")
    programs = clone.parent / "bin"
    done = subprocess.run(
        ["sh", "-e", f"docs/ways/{way}.sh"],
        capture_output=True, text=True, check=False, timeout=600, cwd=clone,
        env={
            **os.environ,
            "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(clone),
            "NUMBA_CACHE_DIR": str(clone.parent / "cache"),
        },
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert "Traceback" not in done.stderr
    said = " ".join(done.stdout.split())
    for sentence in SAID[way]:
        assert sentence in said, f"{sentence}\n{done.stdout[-3000:]}"
    if way == "analyst":
        page = clone / "pages" / "method-my-method.html"
        assert "stability region" in page.read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_notebook_runs_and_shows_tableau_table_and_picture(tmp_path: Path) -> None:
    pytest.importorskip("nbconvert", reason="the extra `docs` is not installed")
    pytest.importorskip("ipykernel", reason="the extra `docs` is not installed")
    notebook = ROOT / "docs" / "notebooks" / "own-method.ipynb"
    done = subprocess.run(
        [sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir", str(tmp_path), str(notebook)],
        capture_output=True, text=True, check=False, timeout=300, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    cells = json.loads((tmp_path / notebook.name).read_text(encoding="utf-8"))["cells"]
    shown = [
        "".join("".join(x) for o in c.get("outputs", []) for x in o.get("data", {}).values())
        for c in cells
    ]
    assert "<math" in shown[1] and "GLM midpoint" in shown[1]
    assert re.search(r"<th>order</th><td>2</td>", shown[2])
    assert "<msqrt>" in shown[3]
    assert "<svg" in shown[4] and "time reached" in shown[4]
    assert "stability region" in shown[5]
