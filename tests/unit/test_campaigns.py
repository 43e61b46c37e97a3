"""Campaign files: read strictly, planned, sampled reproducibly, carried out once, shown."""

import json
import math
import os
import sys
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import pytest

from glmref.catalogue.files import data_root
from glmref.cli import main
from glmref.compute import Records
from glmref.compute.records import key_of
from glmref.errors import DataError, UsageError
from glmref.report.campaigns import campaign_page, write_parquet
from glmref.scenes.campaign import campaign_names, load_campaign
from glmref.scenes.campaign_kinds import resonance
from glmref.views.heat import heat_map
from tests.build import refused

SMALL = """\
format = "glmref-campaign-1"
name = "small"
title = "A small campaign"
question = "Does it work?"
kind = "resonance"
seed = 3

[fixed]
steps = 50

[grid]
method = ["leapfrog-one-leg"]
h = { from = 0.1, to = 0.2, count = 2 }

[sample]
count = 3
frequency = { from = 1, to = 4, spacing = "log" }

[limits]
seconds = 60

[report]
picture = "map"
across = "frequency"
up = "h"
value = "largest"
each = "method"
"""
Write = Callable[..., str]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def written(old: str = "", new: str = "") -> str:
        assert old in SMALL
        path = tmp_path / "small.toml"
        path.write_text(SMALL.replace(old, new) if old else SMALL, encoding="utf-8")
        return str(path)

    return written


@pytest.mark.sampled(2, besides=("work",))
@pytest.mark.parametrize("name", campaign_names())
def test_a_shipped_campaign_is_read_and_its_tasks_differ(name: str) -> None:
    campaign = load_campaign(name)
    assert campaign.question.endswith("?")
    keys = [key_of(task) for task in islice(campaign.tasks(), 200)]
    assert len(set(keys)) == 200 <= len(campaign)
    assert len(campaign.spread(3)) == 3
    first = list(islice(campaign.tasks(), 66))  # a search has 64 tasks for each combination
    assert [campaign._at(k) for k in (0, 63, 65)] == [first[k] for k in (0, 63, 65)]


@pytest.mark.parametrize("name", campaign_names())
def test_the_page_of_a_shipped_campaign_has_its_pictures(name: str, tmp_path: Path) -> None:
    campaign = load_campaign(name)
    found = {"largest": 1.0, "smallest": 1.0, "evaluations": 10, "state_error": 0.1}
    rows = [{"outcome": "completed", "task": task, **found} for task in islice(campaign.tasks(), 3)]
    campaign_page(campaign, rows, tmp_path / "p.html")
    assert "<figure" in (tmp_path / "p.html").read_text(encoding="utf-8")
    less = [{"outcome": "completed", "task": row["task"]} for row in rows]
    campaign_page(campaign, less, tmp_path / "p.html")
    page = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert "<figure" not in page and "no record has a number for each of" in page


def test_what_was_lost_has_a_colour_of_its_own_and_no_part_in_the_scale(write, tmp_path):
    campaign = load_campaign(write())
    rows = [
        {"outcome": "completed", "largest": 0.1 * k, "task": task}
        for k, task in enumerate(campaign.tasks(), 1)
    ]
    rows[-1] |= {"outcome": "lost", "largest": 1e152}
    campaign_page(campaign, rows, tmp_path / "p.html")
    page = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert "incomplete" in page and "#b3261e" in page and "e+152" not in page
    assert ">0.5<" in page  # the upper end of the scale


@pytest.mark.slow
def test_the_shipped_campaigns_are_the_three_that_the_page_describes() -> None:
    page = (Path(__file__).parents[2] / "docs" / "campaigns.md").read_text(encoding="utf-8")
    assert campaign_names() == ["order8-partitioned", "resonance-map", "work-precision"]
    for name in campaign_names():
        assert f"| `{name}` | {len(load_campaign(name)):,} |" in page


def test_the_tasks_are_the_grid_crossed_with_the_sample_the_same_each_time(write: Write) -> None:
    campaign = load_campaign(write())
    tasks = list(campaign.tasks())
    assert len(tasks) == len(campaign) == 6
    assert tasks == list(load_campaign(write()).tasks())
    assert load_campaign(write()).spread(6) == tasks  # each by its place
    assert [task["h"] for task in tasks] == [0.1] * 3 + [0.2] * 3
    drawn = [task["frequency"] for task in tasks[:3]]
    assert drawn == [task["frequency"] for task in tasks[3:]]
    assert all(1 <= x <= 4 for x in drawn)
    other = [task["frequency"] for task in load_campaign(write("seed = 3", "seed = 4")).tasks()]
    assert other[:3] != drawn


def test_a_halton_sample_is_more_even_than_a_random_one(write: Write) -> None:
    def gap(draw: str) -> float:
        text = write("count = 3\n", f'count = 256\ndraw = "{draw}"\n')
        values = sorted(
            math.log(t["frequency"], 4) for t in islice(load_campaign(text).tasks(), 256)
        )
        return max(b - a for a, b in zip([0.0, *values], [*values, 1.0], strict=True))

    assert gap("halton") <= 2 / 256 + 1e-9 < gap("random")  # two radical inverses are 1/256 apart


def test_a_long_value_is_cut_in_the_sentence_about_it(tmp_path: Path) -> None:
    shipped = (data_root() / "campaigns" / "order8-partitioned.toml").read_text(encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(shipped.replace("order = 8", f"order = {['0'] * 800}"), encoding="utf-8")
    caught = refused(DataError, "`order` must be 2, 4, 6 or 8", load_campaign, str(path))
    assert len(caught) < 200  # it had 3650 characters


def test_a_campaign_is_carried_out_once_and_shown(write, tmp_path, capsys):
    words = ["campaign", write(), "--output", str(tmp_path), "--format", "json"]
    assert main(words) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["carried_out"], summary["records"]) == (6, 6)
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["carried_out"] == 0
    folder = tmp_path / "small"
    records = list(Records(folder / "records.sqlite"))
    assert len({x["key"] for x in records}) == 6
    page = (folder / "index.html").read_text(encoding="utf-8")
    for words_of_page in ("Does it work?", "6 of 6 tasks", "frequency", "leapfrog-one-leg"):
        assert words_of_page in page
    assert page.count("<title>1") >= 1  # a cell says its values


def test_a_budget_ends_a_campaign_and_the_same_command_goes_on(write, tmp_path, capsys):
    words = ["campaign", write("seed = 3", "seed = 3\nbudget = 1e-9"), "--output", str(tmp_path)]
    for left in (5, 4):
        assert main(words) == 0
        said = capsys.readouterr()
        assert "the budget of 1e-09 s is spent" in said.err
        assert f"{left} of 6 tasks are left" in said.out


def test_the_table_in_columns_has_a_row_for_each_record(write: Write, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    campaign = load_campaign(write())
    records = [
        {"outcome": "completed", "largest": 1, "task": task, "solutions": [{"point": [1.0]}]}
        for task in campaign.tasks()
    ]
    records[2]["largest"] = 0.5
    assert write_parquet(records, records, tmp_path / "r.parquet") == 6
    table = parquet.read_table(tmp_path / "r.parquet").to_pylist()
    assert [row["largest"] for row in table] == [1.0, 1.0, 0.5, 1.0, 1.0, 1.0]
    assert [row["task.h"] for row in table] == [0.1] * 3 + [0.2] * 3
    assert json.loads(table[0]["solutions"]) == [{"point": [1.0]}]


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes on Linux")
def test_the_table_is_written_into_a_folder_of_any_name(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    folder = tmp_path / os.fsdecode(b"mem:\xff")
    folder.mkdir()
    records = [{"task": {"h": 0.1}, "error": 1.0}]
    assert write_parquet(records, records, folder / "x.parquet") == 1


def test_without_pyarrow_a_note_says_how_to_get_the_table(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(UsageError, match=r"pip install 'glmref\[cluster\]'"):
        write_parquet([], [], tmp_path / "r.parquet")


def test_times_of_two_kinds_of_machine_are_told_on_the_page(write: Write, tmp_path: Path) -> None:
    text = write('kind = "resonance"', 'kind = "run"')
    content = Path(text).read_text(encoding="utf-8")
    head = content[: content.index("[fixed]")]
    Path(text).write_text(
        head + "[fixed]\ntimed = true\nsteps = 10\n[grid]\nmethod = ['rk4']\nproblem = ['kepler']\n"
        "[report]\npicture = 'front'\nacross = 'evaluations'\nup = 'state_error'\neach = 'method'\n",
        encoding="utf-8",
    )
    campaign = load_campaign(text)
    assert campaign.limits.pinned
    (task,) = campaign.tasks()
    rows = [
        {"outcome": "completed", "evaluations": 40, "state_error": error, "task": task,
         "where": {"processor": kind, "cores": 2}}
        for kind, error in (("A", 1e-3), ("B", 1e-4))
    ]  # fmt: skip
    page = tmp_path / "p.html"
    campaign_page(campaign, rows, page)
    assert "not of one kind of machine" in page.read_text(encoding="utf-8")
    campaign_page(campaign, rows[:1], page)
    assert "not of one kind of machine" not in page.read_text(encoding="utf-8")


def test_a_resonance_task_may_renew_the_values() -> None:
    task = {"method": "gsymplectic-p", "file": None, "coupling": 0.1, "steps": 2000}
    never = resonance({**task, "h": 0.1, "frequency": 2.0})
    renewed = resonance({**task, "h": 0.1, "frequency": 2.0, "renew": 100})
    assert renewed["largest"] != never["largest"]


def test_a_map_has_a_cell_for_each_value_and_colours_by_size() -> None:
    cells: dict[tuple[float | str, float | str], float] = {
        (x, y): 10.0 ** (x + y) for x in (1.0, 2.0) for y in (0.0, 3.0)
    }
    drawn = heat_map(cells, title="t", x_label="x", y_label="y <", value_label="v")
    assert drawn.count("</rect>") == 4
    assert "y &lt;" in drawn
    assert "#00224e" in drawn and "#fee838" in drawn
    assert "nothing to draw" in heat_map({}, title="", x_label="", y_label="", value_label="")
