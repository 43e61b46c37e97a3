"""README is true: its commands and examples run; the table of all families is computed."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from glmref.catalogue.lookup import data_root, document, names

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
INDEX = ROOT / "docs" / "index.md"
FAMILIES = {
    "rk": "Runge-Kutta",
    "lmm": "linear multistep and one-leg",
    "glm": "general linear, multivalue",
    "partitioned": "partitioned pairs",
    "additive": "additive (implicit-explicit)",
    "nystrom": "Runge-Kutta-Nystrom",
    "rosenbrock": "Rosenbrock",
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
        printed = [c.get("order-to-digits", {"b": [None]})["b"][0] for c in claims]
        proved = [c.get("order", c.get("nystrom-order")) for c in claims]
        orders = [y if x is None else x for x, y in zip(proved, printed, strict=True)]
        orders = [x for x in orders if x is not None]
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
    page = INDEX.read_text(encoding="utf-8")
    shown = page[page.index(start) + len(start) : page.index(end)]
    assert shown == verified_table(), "run python tests/repo/test_readme.py"


def test_the_readme_is_short() -> None:
    assert len(README.splitlines()) <= 90


def test_the_misprint_of_the_example_is_named_as_shown(tmp_path, monkeypatch, cli):
    block = re.search(r"```json\n(.*?)```", README, re.DOTALL)
    shown = re.search(r"^\$ glmref verify tableau.json\n(.*?)```", README, re.DOTALL | re.MULTILINE)
    assert block is not None and shown is not None
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tableau.json").write_text(block[1], encoding="utf-8")
    assert cli("verify", "tableau.json", code=1).out == shown[1]


def test_the_python_example_runs() -> None:
    block = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    done = subprocess.run(
        [sys.executable, "-c", block[1]], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "2"


COMMANDS = re.findall(r"^\$ (glmref .*)$", README.partition("## Where to go next")[2], re.MULTILINE)


def test_the_commands_are_found() -> None:
    assert len(COMMANDS) >= 6


# --- the four promises, from a clone in a folder called glmref --------------------------------------


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a newcomer has: a clone in a folder named as git names it."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("no git checkout")
    folder = tmp_path_factory.mktemp("newcomer") / "glmref"
    command = ["git", "clone", "--quiet", "--local", str(ROOT), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    if done.returncode:
        pytest.skip(f"git clone: {done.stderr.strip()}")
    return folder


def in_clone(clone: Path, *words: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command of the clone's package, from another folder."""
    return subprocess.run(
        [sys.executable, *words],
        capture_output=True, text=True, check=False, timeout=300, cwd=cwd or clone.parent,
        env={**os.environ, "PYTHONPATH": str(clone), "NUMBA_CACHE_DIR": str(clone.parent / "cache")},
    )  # fmt: skip


MY_HEUN = {
    "format": "glmref-method-1", "name": "my-heun", "class": "rk",
    "A": [["0", "0"], ["1", "0"]], "b": ["1/2", "1/2"],
    "claims": {"order": 2},
    "source": {"citation": "my notebook", "where": "page 1", "status": "derived"},
}  # fmt: skip
BARE = '{"A": [["0", "0"], ["1", "0"]], "b": ["1/2", "1/2"]}'


def test_the_clone_is_what_runs(clone: Path) -> None:
    done = in_clone(clone, "-c", "import glmref; print(glmref.__file__)")
    assert done.stdout.strip() == str(clone / "glmref" / "__init__.py"), done.stderr


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["verify", "g6245-w3"], 0, "0 fail, 0 open"),  # a name
        (["verify", "my-heun.json"], 0, "1 claim of 1 file: 1 hold"),  # one's own file
        (["verify", "my-slip.json"], 1, "declared 3, found 2"),
        (["analyze", "bare.json"], 0, "order with the identity"),  # no claims
        (["analyze", "noclaims.json"], 0, "order with the identity"),
        (["verify", "bare.json"], 2, "nothing to verify"),
        (["show", "bare.json"], 0, "1/2"),  # show and cite
        (["show", "rk4"], 0, "1/6"),
        (["cite", "rk4"], 0, "@"),
        (["cite", "my-heun.json"], 0, "my notebook"),
        (["cite", "bare.json"], 2, "has no source to cite"),
        (["solve"], 2, "there is no command"),
        (["verify", "gaus-2"], 2, "did you mean gauss-2"),
    ],
)
def test_the_promises_hold_from_a_clone_called_glmref(clone, tmp_path, words, code, said):
    files = {
        "my-heun": MY_HEUN, "my-slip": {**MY_HEUN, "name": "my-slip", "claims": {"order": 3}},
        "noclaims": {k: x for k, x in MY_HEUN.items() if k not in ("claims", "source")},
        "bare": json.loads(BARE),
    }  # fmt: skip
    for name, content in files.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(content), encoding="utf-8")
    done = in_clone(clone, "-m", "glmref", *words, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert said in done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert code != 2 or (done.stdout == "" and len(done.stderr.splitlines()) == 1)


@pytest.mark.sampled(3, besides=("derive", "conformance"))
@pytest.mark.parametrize("line", COMMANDS)
def test_the_commands_of_the_readme_run_from_the_clone(clone, tmp_path, line):
    words = line.partition("#")[0].split()[1:]
    done = in_clone(clone, "-m", "glmref", *words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def test_analyze_of_a_bare_tableau_in_python(clone: Path, tmp_path: Path) -> None:
    (tmp_path / "bare.json").write_text(BARE, encoding="utf-8")
    code = "import glmref; print(glmref.analyze(glmref.load('bare.json')).order)"
    done = in_clone(clone, "-c", code, cwd=tmp_path)
    assert done.stdout == "2\n", done.stderr


@pytest.mark.slow
def test_the_tests_that_name_places_in_files_pass_in_the_clone(clone: Path) -> None:
    """Frames were once dropped by the word glmref in a path: in such a folder all of them."""
    file = "tests/suite/test_conformance_adapters.py"
    words = ["-m", "pytest", "-q", "-p", "no:cacheprovider", file]
    done = in_clone(clone, *words, "-k", "cannot_be_used or place_of_an_error", cwd=clone)
    assert done.returncode == 0, done.stdout[-2000:]


def test_ci_runs_the_two_commands_before_anything_else_is_installed() -> None:
    block = re.search(r"## Two commands\n.*?```console\n(.*?)```", README, re.DOTALL)
    assert block is not None
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    reading = re.search(r"^mapfile -t commands < <\((.*)\)$", ci, re.MULTILINE)
    found = subprocess.run(
        ["bash", "-c", reading[1]], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert found.stdout.splitlines() == block[1].splitlines()
    before, running, after = ci.partition("  bash -euc")
    assert running and "bin/pip" not in before and 'pip" install' in after


if __name__ == "__main__":  # write the computed table into docs/index.md
    start, end = "<!-- table: verified -->\n", "<!-- end of table -->"
    before, _, rest = INDEX.read_text(encoding="utf-8").partition(start)
    text = before + start + verified_table() + "\n" + end + rest.partition(end)[2]
    INDEX.write_text(text, encoding="utf-8")
