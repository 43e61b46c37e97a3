"""What a file may say and open: exact JSON only, and files beside it only."""

import json
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from glmref.catalogue.lookup import path_of
from glmref.catalogue.strict_json import MAX_BYTES, MAX_NESTING, read_json
from glmref.cli import main
from glmref.errors import DataError, UsageError
from glmref.problems import from_path
from glmref.scenes.campaign import load_campaign
from glmref.scenes.reading import load_scene
from glmref.system.files import named_in
from tests.build import refused, scene_text
from tools.measured_json import write_json

#: It leaves a mark when it is executed.
EVIL = """
from pathlib import Path
Path(__file__).with_name("executed").touch()
def make():
    return {"H": "p**2/2 - cos(q)", "y0": {"q": 1.0, "p": 0.0}}
"""
SCENE = scene_text(
    "small", "PROBLEM", 'kind = "fastest"\nat = 1e-3', methods=["rk4", "METHOD"], ask=["state"],
    t_end=1, steps=[8],
)  # fmt: skip
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
        path.write_text(SCENE.replace("PROBLEM", problem).replace("METHOD", "heun-2"))
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
        path.write_text(text.replace('"METHOD"', json.dumps(name)))
        refused(DataError, "must lie in the folder", load_scene, path)
    (inner / "own.json").write_text((inner.parent / "mine.json").read_text())
    path.write_text(text.replace("METHOD", "own.json"))
    assert load_scene(path).methods[1] == str(inner / "own.json")
    path.write_text(text.replace('"METHOD"', json.dumps(str(path_of("gauss-2")))))
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
    main(["audit", str(inner), "--from", "json", "--all"])
    rows = {x["path"]: x for x in map(json.loads, capsys.readouterr().out.splitlines())}
    assert rows["link.json"]["status"] == "unread"
    assert "leads out of the checkout" in rows["link.json"]["remarks"][0]
    assert rows["good.json"]["status"] != "unread"
    # the near miss: the link itself is named on the command line
    main(["audit", str(inner / "link.json"), "--from", "json", "--all"])
    assert json.loads(capsys.readouterr().out.splitlines()[0])["status"] != "unread"


# -- strict_json.py: what is no exact JSON is refused by place, quickly, without recursion


@pytest.fixture
def reading(tmp_path: Path):
    def read(content: str | bytes) -> object:
        path = tmp_path / "file.json"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_json(path)

    return read


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe", "byte 0 is not UTF-8"),
        (b"\xef\xbb\xbf{}", "begins with a byte order mark"),
        ("[" * (MAX_NESTING + 1) + "]" * (MAX_NESTING + 1), "nested deeper than 40"),
        ('{"a":' * (MAX_NESTING + 1) + "1" + "}" * (MAX_NESTING + 1), "nested deeper than 40"),
    ],
)
def test_what_is_no_exact_json_is_refused(reading, content: str, message: str) -> None:
    caught = refused(DataError, "", reading, content)
    assert caught.startswith("file.json: ")
    assert message in caught


def test_brackets_inside_strings_are_not_nesting(reading) -> None:
    text = "[" * 500
    assert reading(f'["{text}", "\\"[[[[", "\\\\"]') == [text, '"[[[[', "\\"]
    assert reading("[" * MAX_NESTING + "]" * MAX_NESTING)


def test_numbers_inside_strings_are_not_numbers(reading) -> None:
    assert reading('["0.25", "NaN"]') == ["0.25", "NaN"]


@pytest.mark.parametrize("piece", ['\\"', "[", '{"', "\\", '"\\', '["'])
def test_a_file_of_the_largest_size_is_refused_within_a_second(reading, piece: str) -> None:
    content = (piece * MAX_BYTES)[: MAX_BYTES - 1]
    started = time.process_time()
    refused(DataError, "", reading, content)
    assert time.process_time() - started < 1.0  # about 0.1 s; quadratic searches take minutes


def test_a_file_above_the_largest_size_is_not_read(reading) -> None:
    with pytest.raises(DataError, match=f"{MAX_BYTES + 1} bytes and at most {MAX_BYTES}"):
        reading(b" " * (MAX_BYTES + 1))


def test_a_missing_file_is_a_data_error(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"nothing.json: the file cannot be read \(No such file"):
        read_json(tmp_path / "nothing.json")


def test_a_document_is_written_where_there_is_no_folder_yet(tmp_path: Path) -> None:
    path = tmp_path / "new" / "it.json"
    write_json(path, {"name": "Hénon", "rows": [0.5]})
    assert path.read_bytes() == '{"name": "Hénon", "rows": [0.5]}\n'.encode()


def test_a_long_document_has_a_row_on_each_line(tmp_path: Path) -> None:
    path, row = tmp_path / "it.json", {"h": 0.5, "marks": [10, 100], "verdict": "bounded"}
    document = {"name": "Hénon", "rows": [row] * 9, "none": [], "long": "x" * 300}
    write_json(path, document)
    text = path.read_text(encoding="utf-8")
    assert json.loads(text) == document
    assert text.count('\n  {"h": 0.5, "marks": [10, 100], "verdict": "bounded"}') == 9
    assert max(map(len, text.splitlines()[:-2])) < 200


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_json_has_not_is_not_written_and_the_old_file_stays(tmp_path, value):
    path = tmp_path / "it.json"
    path.write_text("old")
    refused(ValueError, "not JSON compliant", write_json, path, [value])
    assert path.read_text() == "old"


def test_brackets_that_were_closed_do_not_count(reading) -> None:
    many = ", ".join(["[[]]"] * 60)
    deep = "[" * (MAX_NESTING + 5) + "]" * (MAX_NESTING + 5)
    assert len(reading('{"x": [' + many + "]}")["x"]) == 60
    refused(DataError, "nested", reading, '{"x": [' + many + ", " + deep + "]}")


@pytest.mark.parametrize("zeros", [0, 16, 17])
def test_a_short_float_is_told_as_the_fraction_it_is(reading, zeros: int) -> None:
    text = f"0.5{'0' * zeros}"
    refused(DataError, "exact string such as '1/2'", reading, f"[{text}]")
    refused(DataError, "exact string such as '1/4'", reading, f"[0.5{'0' * 18}]")


def test_integers_are_read_up_to_20_digits(reading) -> None:
    assert reading(f"[{'9' * 20}]") == [10**20 - 1]
    refused(DataError, r"999999999999\.\.\. is too long", reading, f"[{'9' * 21}]")
