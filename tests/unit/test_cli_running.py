"""``glmref run``: tables and formats, files it leaves, and a run that is killed goes on."""

import csv
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from glmref.cli import main
from glmref.cli.running import _narrowed
from glmref.compute import Records
from tests.build import scene_text

ROOT = Path(__file__).resolve().parents[2]

SCENE = scene_text(
    "tiny", answer='kind = "fastest"\nat = 1e-2', methods=["heun-2", "rk4"], steps=[20, 40],
    t_end="2*pi", ask=["state", "picture"], repeats=1,
)  # fmt: skip


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "tiny.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@pytest.mark.slow
def test_a_run_prints_table_picture_and_answer_and_leaves_records(scene, tmp_path, cli):
    out = tmp_path / "out"
    printed = cli("run", scene, "--output", out).out
    for word in ("A tiny scene", "heun-2", "state error", "a heun-2   b rk4", "answer  relative"):
        assert word in printed
    assert len(Records(out / "tiny.sqlite")) == 4
    assert (out / "tiny.svg").read_text("utf-8").startswith("<svg")
    assert (out / "tiny-evaluations.svg").exists()


@pytest.mark.slow
def test_an_orbit_is_a_picture_beside_the_others_and_no_line_more(scene, tmp_path, cli):
    before = cli("run", scene, "--output", tmp_path / "a").out
    scene.write_text(SCENE.replace('"state", ', '"state", "orbit", '), encoding="utf-8")
    after = cli("run", scene, "--output", tmp_path / "b").out
    # what stands above the names of the pictures: run times differ, words and shape do not
    above = [text[: text.index("pictures in")] for text in (before, after)]
    assert above[0].splitlines()[:3] == above[1].splitlines()[:3]
    assert all("orbit" not in text and "right-hand" not in text for text in above)
    assert "tiny-orbit.svg" in after and "tiny-orbit.svg" not in before
    drawn = (tmp_path / "b" / "tiny-orbit.svg").read_text("utf-8")
    assert drawn.count('stroke-linecap="round"') == 2 and ">heun-2, h = 0.3142</text>" in drawn
    assert not (tmp_path / "a" / "tiny-orbit.svg").exists()


@pytest.mark.slow
def test_json_is_one_document_with_the_records(scene, tmp_path, cli):
    document = json.loads(cli("run", scene, "--output", tmp_path, "--format", "json").out)
    assert document["format"] == "glmref-run-1"
    assert (document["measured"], document["resumed"]) == (4, 0)
    assert len(document["records"]) == 4
    again = json.loads(cli("run", scene, "--output", tmp_path, "--format", "json").out)
    assert (again["measured"], again["resumed"]) == (0, 4)
    assert again["records"] == document["records"]


@pytest.mark.slow
def test_csv_has_a_row_for_each_record(scene, tmp_path, capsys):
    assert main(["run", str(scene), "--output", str(tmp_path), "--format", "csv"]) == 0
    table = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert [row["method"] for row in table] == ["heun-2", "heun-2", "rk4", "rk4"]
    assert float(table[-1]["state error"]) < 1e-4


def test_the_plan_runs_nothing_and_writes_nothing(scene, tmp_path, cli):
    out = tmp_path / "out"
    printed = cli("run", scene, "--plan", "--output", out).out
    for word in ("question", "imported", "flint, numpy, mpmath, llvmlite", "about 3.6e+02"):
        assert word in printed
    assert not out.exists()
    assert len(json.loads(cli("run", scene, "--plan", "--format", "json").out)["tasks"]) == 4


def test_shipped_scenes_are_listed_with_their_questions(cli):
    assert "parasitism" in cli("run", "--list").out


@pytest.mark.slow
def test_a_failing_method_makes_code_3_and_no_traceback(scene, tmp_path, cli):
    scene.write_text(
        SCENE.replace('"heun-2"', '"stormer-verlet"').replace("harmonic-oscillator", "rigid-body"),
        encoding="utf-8",
    )
    captured = cli("run", scene, "--output", tmp_path, code=3)
    assert "not applicable" in captured.out and "rk4" in captured.out
    assert "Traceback" not in captured.err


def test_an_output_that_is_a_file_is_refused(scene, cli):
    assert cli("run", scene, "--output", scene, code=2).err.count("\n") >= 1


def glmref(*arguments, **options):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "glmref", *map(str, arguments)]
    return subprocess.Popen(command, env=environment, cwd=ROOT, **options)


@pytest.mark.slow
def test_records_of_another_version_end_with_code_2_and_one_sentence(scene, tmp_path, cli):
    out = tmp_path / "out"
    lines = cli("run", scene, "--output", out, "--format", "jsonl").out.splitlines()
    assert [json.loads(line) for line in lines] == list(Records(out / "tiny.sqlite"))
    (out / "tiny.sqlite").unlink()
    path = out / "tiny.jsonl"
    records = [{**json.loads(line), "format": "glmref-record-0"} for line in lines]
    for record in records:
        del record["sha256"]
    older = "".join(json.dumps(record) + "\n" for record in records)
    path.write_text(older, encoding="utf-8")
    captured = cli("run", scene, "--output", out, code=2)
    assert captured.out == ""
    assert captured.err.count("\n") == 1 and "'glmref-record-0'" in captured.err
    assert path.read_text(encoding="utf-8") == older  # nothing was overwritten


@pytest.mark.slow
def test_the_page_of_a_run_fits_80_columns(scene, tmp_path, cli):
    scene.write_text(SCENE.replace('"heun-2"', '"suzuki-verlet-4"'), encoding="utf-8")
    lines = cli("run", scene, "--output", tmp_path / "out").out.splitlines()
    named = [line for line in lines if str(tmp_path) not in line]  # a path is not broken
    assert max(map(len, named)) <= 80, max(named, key=len)


def test_columns_are_left_out_only_where_there_is_no_room():
    row = {"method": "m" * 20, "outcome": "completed", "state error": "1", "start": "2", "q25": "3"}
    assert _narrowed([row], 80) == ([row], [])
    narrow, left_out = _narrowed([row], 44)
    assert (list(narrow[0]), left_out) == (["method", "outcome", "state error"], ["start", "q25"])
    assert list(_narrowed([row], 25)[0][0]) == ["method", "state"]
    failed = {**row, "outcome": "lost"}  # how a run ended is said wherever it did not complete
    assert "outcome" in _narrowed([row, failed], 10)[0][0]
    assert "outcome" not in _narrowed([row, row], 10)[0][0]
    assert _narrowed([], 80) == ([], [])


LOADED = """
import json, sys
before = set(sys.modules)
from glmref.scenes import load_scene, plan, run
scene = load_scene(sys.argv[1])
todo = plan(scene)
run(todo)
outside = {"flint", "numpy", "mpmath", "numba", "llvmlite", "matplotlib", "scipy", "heyoka", "jax", "rebound",
           "nodepy", "click", "tqdm", "pytest", "jsonschema", "pandas", "IPython"}
loaded = {name.partition(".")[0] for name in sys.modules}
print(json.dumps([sorted(todo.modules), sorted(outside & loaded)]))
"""


@pytest.mark.slow
def test_what_is_imported_is_what_the_plan_says(scene):
    scene.write_text(SCENE.replace(', "picture"', ""), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    found = subprocess.run(
        [sys.executable, "-c", LOADED, str(scene)], env=environment, capture_output=True, check=True
    )
    said, loaded = json.loads(found.stdout)
    assert said == loaded == ["flint", "llvmlite", "mpmath", "numpy"]


def test_commands_are_listed_without_the_rules_of_the_judge_and_numerical_packages():
    code = "import sys, glmref.cli; print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    loaded = found.stdout.split()
    assert "glmref.judge.claims" in loaded and "glmref.judge.statements" not in loaded
    assert not {"numpy", "flint", "mpmath", "numba"} & set(loaded)


def test_an_interruption_says_how_much_is_kept(tmp_path, monkeypatch, capsys):
    """Ctrl-C in the middle of a scene: what was measured counts, and the rest is named."""
    from glmref import scenes

    monkeypatch.chdir(tmp_path)
    run = scenes.run

    def interrupted(plan, store, *, advance, on):
        def stop(task, record):
            advance(task, record)
            if len(store) == 2:
                raise KeyboardInterrupt

        return run(plan, store, advance=stop, on=on)

    monkeypatch.setattr(scenes, "run", interrupted)
    assert main(["run", "denormal", "--quick"]) == 130
    tasks = len(scenes.plan(scenes.load_scene("denormal", quick=True)).tasks)
    first, last = capsys.readouterr().err.splitlines()
    assert first == f"glmref: 2 of {tasks} runs are kept; the same command goes on"
    assert last == "glmref: interrupted"
