"""``glmref audit --lines``, the GitHub Action and the pre-commit hook, on a repository with one wrong table."""

import json
import os
import re
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from glmref.cli import main

ROOT = Path(__file__).parents[2]
#: A table in the notation of PETSc, whose entry on line 5 is right or wrong.
PETSC = """  {{
    const PetscReal A[2][2] = {{
      {{0, 0}},
      {{{entry}, 0}}
    }};
    const PetscReal b[2] = {{0.25, 0.75}};
    PetscCall(TSRKRegister({name}, 2, 2, &A[0][0], b, NULL, NULL, 0, NULL));
  }}
"""
RIGHT = '{\n  "A": [[0, 0], [1, 0]],\n  "b": ["1/2", "1/2"],\n  "order": 2\n}\n'
WRONG = '{\n  "A": [\n    [0, 0],\n    [1, 0]\n  ],\n  "b": [\n    "1/2",\n    "1/3"\n  ],\n  "order": 2\n}\n'


def petsc(*entries: str) -> str:
    return "".join(PETSC.format(name=f"T{k}", entry=x) for k, x in enumerate(entries))


def git(folder: Path, *words: str) -> str:
    who = ["-c", "user.name=N", "-c", "user.email=n@example.org", "-c", "commit.gpgsign=false"]
    done = subprocess.run(
        ["git", *who, *words], cwd=folder, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with right tables, and in its last commit one wrong entry."""
    folder = tmp_path / "repository"
    (folder / "src").mkdir(parents=True)
    monkeypatch.chdir(folder)
    for key in [key for key in os.environ if key.startswith("GIT_")]:
        monkeypatch.delenv(key)
    git(folder, "init", "--quiet")
    (folder / "package.json").write_text('{"name": "x", "b": true}')
    (folder / "list.json").write_text('[{"A": [], "b": []}]')
    (folder / "right.json").write_text(RIGHT)
    # an old fault beside the new one: only the new one is judged in a pull request
    (folder / "src" / "rk.c").write_text(petsc("1.0 / 5.0", "2.0 / 3.0"))
    git(folder, "add", ".")
    git(folder, "commit", "--quiet", "-m", "right")
    (folder / "src" / "rk.c").write_text(petsc("1.0 / 5.0", "1.0 / 3.0"))
    git(folder, "commit", "--quiet", "-am", "wrong")
    return folder


@pytest.mark.slow
def test_a_wrong_entry_is_named_with_its_line(repository: Path, cli, tmp_path: Path) -> None:
    (repository / "wrong.json").write_text(WRONG)
    sarif, badge = tmp_path / "x.sarif", tmp_path / "badge.json"
    said = cli("audit", "--lines", "--sarif", sarif, "--badge", badge, code=1)
    places = re.findall(r"^(\S+):(\d+): error: ", said.out, re.MULTILINE)
    assert places == [("src/rk.c", "4"), ("src/rk.c", "12"), ("wrong.json", "8")]
    assert "a[2][1] is 1/3 and should be 2/3" in said.out
    assert "4 tables: 3 errors, 0 warnings, 0 notes" in said.err
    (run,) = json.loads(sarif.read_text())["runs"]
    found = [x["locations"][0]["physicalLocation"] for x in run["results"]]
    assert [(x["artifactLocation"]["uri"], x["region"]["startLine"]) for x in found] == [
        (path, int(line)) for path, line in places
    ]
    rules = [x["id"] for x in run["tool"]["driver"]["rules"]]
    assert all(rules[x["ruleIndex"]] == x["ruleId"] for x in run["results"])
    shown = json.loads(badge.read_text())
    assert shown == {"schemaVersion": 1, "label": "tableaux", "message": "3 wrong", "color": "red"}


@pytest.mark.slow
def test_only_tables_with_changed_lines_are_judged(repository: Path, cli) -> None:
    said = cli("audit", "--lines", "--since", "HEAD^", "--format", "github", code=1)
    (line,) = said.out.splitlines()
    assert line.startswith("::error file=src/rk.c,line=12,title=glmref table::T1: order 1")
    assert "1 table: 1 error" in said.err
    assert "0 tables" in cli("audit", "--lines", "--since", "HEAD").err


def test_a_table_of_which_a_line_was_taken_out_is_judged(repository: Path, cli) -> None:
    lines = WRONG.splitlines(keepends=True)
    (repository / "w.json").write_text(WRONG)
    git(repository, "add", ".")
    git(repository, "commit", "--quiet", "-m", "w")
    (repository / "w.json").write_text("".join(lines[:6] + lines[7:]))
    assert cli("audit", "--lines", "--since", "HEAD", code=1).out.startswith("w.json:")


@pytest.mark.parametrize(
    ("name", "content", "code", "words"),
    [
        ("x.json", '{"A": [[0]], "b": [1], "b": [2]}', 1, "x.json:1: error: "),
        ("x.json", '{"A": [[0, 1]], "b": [1], "order": 1}', 1, "error: "),
        ("x.json", '{"A": [[0]], "b": [1]}', 0, "warning: nothing is said"),
        ("x.json", '{"A": "a", "b": [1]}', 2, ""),
        ("x.json", '{"format": "glmref-scene-1"}', 2, ""),
        ("x.toml", 'A = [[0, 0], [1, 0]]\nb = ["1/2", "1/2"]\norder = 3\n', 1, "x.toml:3: error: "),
        ("x.py", "class Table:\n    A = object()\n", 2, ""),
        ("x.csv", "name,b\nx,1\n", 2, ""),
    ],
)
def test_what_is_a_tableau_and_what_is_said_of_it(
    name: str, content: str, code: int, words: str, tmp_path: Path, monkeypatch, capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text(content)
    assert main(["audit", "--lines"]) == code
    out, err = capsys.readouterr()
    assert words in out and bool(out) is bool(words)
    assert ("no table is found in this folder" in err) is (code == 2)
    assert main(["audit", "--lines", "--allow-empty"]) == (code if code == 1 else 0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere"], "no file and no folder"),
        (["--since", "nothing"], "no such commit"),
        (["--since", "--output=x"], "no such commit"),
    ],
)
def test_what_is_not_there_is_refused(words: list[str], said: str, repository: Path, cli) -> None:
    assert said in cli("audit", "--lines", *words, code=2).err


def test_since_outside_of_a_checkout_is_refused(tmp_path: Path, monkeypatch, cli) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    assert "git cannot answer here" in cli("audit", "--lines", "--since", "HEAD", code=2).err


def test_messages_do_not_end_a_workflow_command(repository: Path, capsys) -> None:
    (repository / "a,b:c%.json").write_text(WRONG)
    assert main(["audit", "--lines", "a,b:c%.json", "--format", "github"]) == 1
    assert capsys.readouterr().out.startswith("::error file=a%2Cb%3Ac%25.json,line=8,")


def steps() -> list[dict]:
    yaml = pytest.importorskip("yaml")
    return yaml.safe_load((ROOT / "action.yml").read_text())["runs"]["steps"]


def test_the_workflow_of_the_page_uses_the_action() -> None:
    yaml = pytest.importorskip("yaml")
    workflow = (ROOT / "docs" / "workflows" / "tableau.yml").read_text()
    assert workflow in (ROOT / "docs" / "check.md").read_text()
    (job,) = yaml.safe_load(workflow)["jobs"].values()
    action = yaml.safe_load((ROOT / "action.yml").read_text())
    assert set(job["steps"][-1]["with"]) < set(action["inputs"])


@pytest.mark.slow
@pytest.mark.parametrize(("changed_only", "lines"), [("true", [12]), ("false", [4, 12])])
def test_the_action_annotates_the_line(changed_only, lines, repository, tmp_path):
    """The script of the step is run as the runner does, in a clone without history."""
    (step,) = [x for x in steps() if x.get("id") == "lint"]
    clone, base = tmp_path / "clone", git(repository, "rev-parse", "HEAD^")
    git(repository, "config", "uploadpack.allowAnySHA1InWant", "true")
    git(tmp_path, "clone", "--quiet", "--depth=1", f"file://{repository}", str(clone))
    given = {"paths": ".\n", "changed-only": changed_only, "strict": "false", "badge": "badge.json"}
    values = {f"inputs.{key}": x for key, x in given.items()}
    values["github.event.pull_request.base.sha"] = base
    inputs = {key: values[re.sub(r"\$\{\{ (.*) \}\}", r"\1", x)] for key, x in step["env"].items()}
    bin_ = tmp_path / "bin"
    bin_.mkdir()
    script = f'#!/bin/sh\nexec {sys.executable} "$@"\n'
    (bin_ / "python").write_text(script)
    (bin_ / "python").chmod(0o755)
    places = {"RUNNER_TEMP": str(tmp_path), "GITHUB_OUTPUT": str(tmp_path / "output")}
    path = f"{bin_}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]],
        cwd=clone, env={**os.environ, **inputs, **places, "PATH": path},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert [
        int(x) for x in re.findall(r"^::error file=src/rk.c,line=(\d+),", done.stdout, re.M)
    ] == (lines)
    written = Path((tmp_path / "output").read_text().strip().removeprefix("sarif="))
    assert len(json.loads(written.read_text())["runs"][0]["results"]) == len(lines)
    assert json.loads((clone / "badge.json").read_text())["message"] == f"{len(lines)} wrong"


def test_the_scripts_of_the_action_hold_no_expression() -> None:
    """What a stranger writes into a title or a path must not be executed."""
    assert all("${{" not in x.get("run", "") for x in steps())


@pytest.mark.slow
def test_the_hook_runs_in_pre_commit(repository: Path, tmp_path: Path) -> None:
    """With the entry and the files of the hook, in this environment."""
    yaml = pytest.importorskip("yaml")
    pytest.importorskip("pre_commit")
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    entry = hook["entry"].replace("glmref", f"{sys.executable} -m glmref", 1)
    local = {"repo": "local", "hooks": [{**hook, "entry": entry, "language": "system"}]}
    (repository / ".pre-commit-config.yaml").write_text(json.dumps({"repos": [local]}))
    (repository / "wrong.json").write_text(WRONG)
    git(repository, "add", ".")
    committed = partial(
        subprocess.run, [sys.executable, "-m", "pre_commit", "run"], cwd=repository,
        capture_output=True, text=True, check=False,
        env={**os.environ, "PRE_COMMIT_HOME": str(tmp_path / "home")},
    )  # fmt: skip
    done = committed()
    assert done.returncode == 1 and "wrong.json:8: error: order 2 fails" in done.stdout, done.stdout
    assert "rk.c" not in done.stdout  # it is no part of this commit
    shutil.copy(repository / "right.json", repository / "wrong.json")
    git(repository, "add", ".")
    done = committed()
    assert done.returncode == 0, done.stdout
    git(repository, "commit", "--quiet", "-m", "mended")
    (repository / "plain.py").write_text("x = 1\n")
    git(repository, "add", ".")
    done = committed()
    assert done.returncode == 0 and "Passed" in done.stdout, done.stdout


def test_the_hook_takes_every_ending_that_is_read() -> None:
    from glmref.audit.lexer import ENDINGS

    yaml = pytest.importorskip("yaml")
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    read = {*ENDINGS, ".json", ".toml"}
    assert all(re.search(hook["files"], f"x{ending}") for ending in read)
    assert not re.search(hook["files"], "x.csv")


def test_the_only_file_of_a_folder_is_read_as_when_it_is_named(tmp_path: Path, cli) -> None:
    own = "double A[2][2] = {{0, 0}, {%s, 0}}, b[2] = {0, 1}, c[2] = {0, 0.5};\n"
    (tmp_path / "own.c").write_text(own % "0.5")
    assert "1 table: 0 errors" in cli("audit", "--lines", tmp_path).err
    (tmp_path / "other.c").write_text("int main(void) { return 0; }\n")
    assert "no table is found" in cli("audit", "--lines", tmp_path, code=2).err
