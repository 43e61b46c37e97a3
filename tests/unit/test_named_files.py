"""Which files a scene, a problem, a campaign or a checkout can make glmref open: those beside it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from glmref.catalogue.lookup import path_of
from glmref.cli import main
from glmref.errors import DataError, UsageError
from glmref.problems import from_path
from glmref.scenes.campaign import load_campaign
from glmref.scenes.reading import load_scene
from glmref.system.files import named_in
from tests.build import refused

#: It leaves a mark when it is executed.
EVIL = """
from pathlib import Path
Path(__file__).with_name("executed").touch()
def make():
    return {"H": "p**2/2 - cos(q)", "y0": {"q": 1.0, "p": 0.0}}
"""
SCENE = """
format = "glmref-scene-1"
name = "small"
title = "A scene"
question = "Which file?"
methods = ["rk4", METHOD]
ask = ["state"]
answer = { kind = "fastest", at = 1e-3 }
t_end = 1
steps = [8]
problem = { PROBLEM }
"""
CAMPAIGN = """
format = "glmref-campaign-1"
name = "small"
title = "A campaign"
question = "Which file?"
kind = "run"
[fixed]
FIXED
[grid]
steps = [10]
GRID
"""


@pytest.fixture
def inner(tmp_path: Path) -> Path:
    """A folder beside files that documents in it must not reach."""
    (tmp_path / "evil.py").write_text(EVIL)
    (tmp_path / "evil.toml").write_text('file = "evil.py:make"')
    (tmp_path / "mine.json").write_text(path_of("rk4").read_text().replace('"rk4"', '"mine"'))
    folder = tmp_path / "inner"
    folder.mkdir()
    (folder / "link.py").symlink_to(tmp_path / "evil.py")
    (folder / "link.json").symlink_to(tmp_path / "mine.json")
    return folder


def ways_out(inner: Path, name: str) -> list[str]:
    """Names that lead out of a folder: upward, absolute, and by a link."""
    suffix = Path(name).suffix
    return [f"../{name}", str(inner.parent / name), f"sub/../../{name}", f"link{suffix}"]


def test_a_name_leads_into_the_folder_or_nowhere(inner: Path) -> None:
    (inner / "below").mkdir()
    (inner / "below" / "x.py").touch()
    assert named_in(inner, "below/x.py", "file") == (inner / "below" / "x.py").resolve()
    assert named_in(inner, "below/../y", "file") == (inner / "y").resolve()
    (inner / "loop").symlink_to(inner / "loop")
    for name in (*ways_out(inner, "evil.py"), "..", "/", "x\0y", "loop/../../evil.py"):
        refused(UsageError, "`file` must lie in the folder", named_in, inner, name, "file")


@pytest.mark.parametrize("command", ["run", "problems", "compare"])
def test_a_python_file_elsewhere_is_not_executed(command: str, inner: Path, cli) -> None:
    """`problems` and `compare` executed it; only `run` refused."""
    path = inner / "scene.toml"
    for name in ways_out(inner, "evil.py"):
        problem = f'file = "{name}:make"'
        path.write_text(SCENE.replace("PROBLEM", problem).replace("METHOD", '"heun-2"'))
        err = cli(command, path, code=2).err
        assert "must lie in the folder of" in err and "file" in err and err.count("\n") == 1
        refused((DataError, UsageError), "must lie in the folder", from_path, path)
    assert not (inner.parent / "executed").exists()


def test_what_can_be_refused_is_refused_before_a_file_is_executed(inner: Path, cli) -> None:
    path = str(inner.parent / "evil.toml")
    for options in (["--tolerance", "2"], ["--methods", "rk5000"], ["--t-end", "x"]):
        assert main(["compare", path, *options]) == 2
    cli("problems", path, path, "--format", "c", code=2)
    assert not (inner.parent / "executed").exists()
    assert main(["problems", path]) == 0  # the near miss: named on the command line
    assert (inner.parent / "executed").exists()


def test_a_method_file_lies_beside_the_scene_or_is_shipped(inner: Path) -> None:
    path = inner / "scene.toml"
    text = SCENE.replace("PROBLEM", 'name = "pendulum"')
    for name in ways_out(inner, "mine.json"):
        path.write_text(text.replace("METHOD", json.dumps(name)))
        refused(DataError, "must lie in the folder", load_scene, path)
    (inner / "own.json").write_text((inner.parent / "mine.json").read_text())
    path.write_text(text.replace("METHOD", '"own.json"'))
    assert load_scene(path).methods[1] == str(inner / "own.json")
    path.write_text(text.replace("METHOD", json.dumps(str(path_of("gauss-2")))))
    assert load_scene(path).methods[1] == str(path_of("gauss-2"))


@pytest.mark.parametrize("table", ["FIXED", "GRID"])
def test_a_campaign_names_shipped_problems_and_methods_or_files_beside_it(table, inner):
    """In [fixed] nothing was looked at, and a problem there could be any file."""
    write: Callable[[str, str], str] = (
        (lambda method, problem: f"method = {method}\nproblem = {problem}")
        if table == "FIXED"
        else (lambda method, problem: f"method = [{method}]\nproblem = [{problem}]")
    )
    path = inner / "small.toml"
    text = CAMPAIGN.replace("FIXED" if table == "GRID" else "GRID", "")
    for name in ways_out(inner, "mine.json"):
        path.write_text(text.replace(table, write(json.dumps(name), '"pendulum"')))
        refused(DataError, "must lie in the folder", load_campaign, str(path))
    path.write_text(text.replace(table, write('"rk4"', json.dumps("../evil.toml"))))
    refused(DataError, "must be one of", load_campaign, str(path))
    assert not (inner.parent / "executed").exists()
    (inner / "own.json").write_text((inner.parent / "mine.json").read_text())
    path.write_text(text.replace(table, write('"own.json"', '"pendulum"')))
    (task,) = load_campaign(str(path)).tasks()
    assert task["file"] == str(inner / "own.json")


@pytest.mark.slow
def test_a_link_of_a_checkout_that_leads_out_is_unread(inner, capsys):
    (inner / "good.json").write_text('{"A": [["0"]], "b": ["1"], "order": 1}')
    (inner.parent / "secret.json").write_text('{"A": [["0"]], "b": ["2"], "order": 1}')
    (inner / "link.json").unlink()
    (inner / "link.json").symlink_to(inner.parent / "secret.json")
    main(["audit", str(inner), "--format", "json", "--all"])
    rows = {x["path"]: x for x in map(json.loads, capsys.readouterr().out.splitlines())}
    assert rows["link.json"]["status"] == "unread"
    assert "leads out of the checkout" in rows["link.json"]["remarks"][0]
    assert rows["good.json"]["status"] != "unread"
    # the near miss: the link itself is named on the command line
    main(["audit", str(inner / "link.json"), "--format", "json", "--all"])
    assert json.loads(capsys.readouterr().out.splitlines()[0])["status"] != "unread"
