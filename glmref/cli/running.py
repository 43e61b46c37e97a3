"""``glmref run``: carry out scenes, keep their records, show tables, pictures and answers."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import click

from ..catalogue.canonical import compact
from ..errors import UsageError
from ..system.files import write_text
from ..system.shown import Drawing
from ..views.tables import Style, columns, counted, csv_text, json_text, one_line
from .campaigning import listing, run_campaign
from .output import (
    BAD_INPUT,
    HOLDS,
    INTERNAL,
    Progress,
    complain,
    complete_scene,
    format_option,
    on_option,
    said_when_interrupted,
    say,
)

if TYPE_CHECKING:
    from ..compute import Executor
    from ..scenes import Plan, Scene

_FAILURES = ("internal error", "not applicable", "process killed")
#: Columns of a table that does not go to a terminal.
WIDTH = 80
#: Columns in the order in which they are left out where there is no room.
DISPENSABLE = ("start", "iterations", "q25", "q75", "outcome", "steps", "evaluations")
#: Heads as a terminal shows them.
SHORT = {"state error": "state", "energy error": "energy", "largest rest": "rest"}


@click.command(short_help="Run scenes: error against run time; and campaigns of many tasks.")
@click.argument(
    "names", nargs=-1, metavar="[SCENE|CAMPAIGN|FILE]...", shell_complete=complete_scene
)
@click.option("--quick", is_flag=True, help="Fewer or shorter runs, as the scene says.")
@click.option(
    "--plan",
    "planned",
    is_flag=True,
    help="Show what would be run, what it costs, and what is predicted.",
)
@click.option("--all", "every", is_flag=True, help="All shipped scenes.")
@click.option("--list", "listed", is_flag=True, help="List the shipped scenes and campaigns.")
@click.option("--pages", is_flag=True, help="Of a campaign: make page and table, and run nothing.")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("report"),
    show_default=True,
    help="Folder for records and pictures.",
)
@format_option(
    ("table", "json", "csv", "jsonl"), "Format of the output: jsonl is one record a line."
)
@on_option
def run(
    names: tuple[str, ...],
    quick: bool,
    planned: bool,
    every: bool,
    listed: bool,
    pages: bool,
    output: Path,
    form: str,
    on: str | None,
) -> int:
    """Run scenes and answer their questions.

    A SCENE is one of `glmref run --list`; a FILE is your own scene. Records are kept in the output
    folder, in one SQLite file a scene: a run that was stopped, or killed, goes on where it was.
    Delete the file to measure again. A CAMPAIGN is carried out in OUTPUT/NAME: what its records
    lack, and no task twice. Exit code 3 when a run ended in an error.
    """
    from .. import scenes as scenery
    from ..compute import executor
    from ..scenes.campaign import is_campaign

    if listed:
        _list(scenery, form)
        return HOLDS
    campaigns = [x for x in names if is_campaign(x)]
    if campaigns:
        if len(names) > 1 or every or quick or form == "csv":
            raise UsageError("a campaign is run by its name, without --all, --quick or csv")
        return run_campaign(campaigns[0], planned, pages, output, form, on)
    if pages:
        raise UsageError("--pages is for a campaign; `glmref report` makes the pages of scenes")
    asked = [*dict.fromkeys(names), *(n for n in scenery.names() if every and n not in names)]
    if not asked:
        raise UsageError(f"name a scene, or --all; the scenes are {', '.join(scenery.names())}")
    loaded = [scenery.load_scene(name, quick=quick) for name in asked]
    plans = [scenery.plan(scene) for scene in loaded]
    if planned:
        _show_plans(plans, form)
        return HOLDS
    documents: list[dict[str, Any]] = []
    told: set[str] = set()
    bad = False
    with executor(on) as where:
        if where.dashboard:
            _note(f"the cluster shows what it does at {where.dashboard}")
        for number, plan in enumerate(plans):
            document = _carry_out(plan, output, where, quick=quick)
            bad |= any(record["outcome"] in _FAILURES for record in document["records"])
            documents.append(document)
            for notice in document["notices"]:
                if notice not in told:
                    _note(notice)
            told |= set(document["notices"])
            if form == "table":
                say(("\n" if number else "") + _page(plan.scene, document, output))
    if form == "json":
        say(json_text(documents[0] if len(documents) == 1 else documents))
    elif form == "csv":
        _write_csv(plans, documents)
    elif form == "jsonl":
        for record in (r for document in documents for r in document["records"]):
            say(compact(record).decode())
    refused = [r for d in documents for r in d["records"] if r["outcome"] == scenery.SYSTEM_REFUSED]
    if refused:
        others = len(refused) - 1
        more = f" (and {counted(others, 'other task')})" if others else ""
        complain(
            f"{_who(refused[0])}{more}: {one_line(refused[0]['message'], limit=200)}; what was "
            f"measured is kept, so see to it and run the same command again"
        )
        return BAD_INPUT
    return INTERNAL if bad else HOLDS


def _list(scenery: Any, form: str) -> None:
    scenes = [scenery.load_scene(name) for name in scenery.names()]
    cells = [[scene.name, scene.question] for scene in scenes]
    if form == "json":
        say(json_text([{"name": name, "question": question} for name, question in cells]))
    elif form == "csv":
        say(csv_text([("name", "question"), *cells]))
    else:
        say(columns(cells, style=Style.of(sys.stdout), head=("scene", "question")))
        say("\n" + listing())


def _show_plans(plans: Sequence[Plan], form: str) -> None:
    from ..scenes.planning import predictions

    documents = [plan.as_json() for plan in plans]
    if form == "json":
        for plan, document in zip(plans, documents, strict=True):
            document["predicted"] = [
                {"method": x.method, "h": x.h, "verdict": x.verdict, "text": x.text}
                for x in predictions(plan.scene)
            ]
        say(json_text(documents[0] if len(documents) == 1 else documents))
        return
    if form == "csv":
        keys = ("kind", "problem", "method", "peer", "h", "tolerance", "steps", "t_end")
        tasks = [task for plan in plans for task in plan.tasks]
        say(csv_text([keys, *([task.get(key) for key in keys] for task in tasks)]))
        return
    style = Style.of(sys.stdout)
    for number, plan in enumerate(plans):
        scene = plan.scene
        grid = ", ".join(f"{h:.4g} ({n:,} steps)" for h, n in scene.grid)
        lines = [
            ("question", one_line(scene.question)),
            ("problem", one_line(f"{scene.problem} {dict(scene.parameters) or ''}")),
            ("methods", ", ".join(map(one_line, scene.methods))),
            ("h", grid),
            ("asked", ", ".join(scene.ask)),
            ("recorded", "; ".join(plan.recorded)),
            ("imported", ", ".join(plan.modules)),
            ("tasks", f"{len(plan.tasks)}, at most {scene.budget:g} s each"),
            ("evaluations", f"about {plan.evaluations:.2g}"),
        ]
        if plan.absent:
            lines.append(("left out", f"{', '.join(plan.absent)}: not installed"))
        for k, one in enumerate(predictions(scene)):
            lines.append(("" if k else "predicted", f"{one.method} h = {one.h:.4g}: {one.text}"))
        say(("\n" if number else "") + style.paint(one_line(scene.name), "bold"))
        say(columns(lines, style=style))


def _carry_out(plan: Plan, output: Path, where: Executor, *, quick: bool) -> dict[str, Any]:
    """Run what is missing, write the pictures, and return everything as one document."""
    from .. import scenes as scenery
    from ..compute import Records

    scene = plan.scene
    stem = scene.name + ("-quick" if quick else "")
    store = Records(output / f"{stem}.sqlite")
    with Progress(len(list(store.missing(plan.tasks))), scene.name, "run") as progress:

        def advance(task: Mapping[str, Any], record: Mapping[str, Any]) -> None:
            progress.advance(_who(record), failed=record["outcome"] in _FAILURES)

        with said_when_interrupted(store, len(plan.tasks), "runs"):
            records = scenery.run(plan, store, advance=advance, on=where)
    missing = progress.done
    notices = [f"{package} is not installed; its runs are left out" for package in plan.absent]
    notices += store.notices
    notices += [text for record in records for text in record.get("notices", ())]
    notices += scenery.mixed_machines(scene, records)
    pictures: list[str] = []
    if "picture" in scene.ask:
        pictures, missed = _draw(scene, records, output, stem)
        notices += missed
    document: dict[str, Any] = {
        "format": "glmref-run-1",
        "scene": scene.name,
        "title": scene.title,
        "question": scene.question,
        "answer": scenery.answer(scene, records),
        "judged": scene.answer.error,
        "measured": missing,
        "resumed": len(records) - missing,
        "pictures": pictures,
        "notices": list(dict.fromkeys(notices)),
    }
    with suppress(UsageError):  # a folder that cannot be written costs this and not the answer
        # what `glmref report` shows above the records
        write_text(output / f"{stem}.run.json", json_text(document) + "\n", sync=False)
    return {**document, "records": records}


def _note(notice: str) -> None:
    """Write one line to stderr: worth knowing, no error."""
    click.echo(f"note: {one_line(notice)}", err=True)


def _draw(
    scene: Scene, records: Sequence[Mapping[str, Any]], output: Path, stem: str
) -> tuple[list[str], list[str]]:
    """Write the pictures; return file names and notices.

    A folder that cannot be written costs the pictures and not the answer.
    """
    from .. import scenes as scenery
    from ..views import chart, paths

    names: list[str] = []
    notices: list[str] = []
    drawn: list[tuple[Any, str, Any, Any]] = [
        (chart, one.suffix, one, one.series) for one in scenery.charts(scene, records)
    ]
    orbits = scenery.orbits(scene, records)
    if orbits is not None:
        drawn.append((paths, "-orbit", orbits, orbits.clouds))
    for module, suffix, one, data in drawn:
        words = {"title": one.title, "x_label": one.x_label, "y_label": one.y_label}
        path = output / f"{stem}{suffix}.svg"
        try:
            names.append(Drawing(module.svg(data, **words)).save(path).name)
        except UsageError as error:
            notices.append(f"no picture: {error}")
    return names, list(dict.fromkeys(notices))


def _page(scene: Scene, document: Mapping[str, Any], output: Path) -> str:
    """Return what a terminal shows of one scene."""
    from .. import scenes as scenery
    from ..views.chart import text

    style = Style.of(sys.stdout)
    records = document["records"]
    width = style.width if sys.stdout.isatty() else WIDTH
    table, left_out = _narrowed(scenery.rows(scene, records), width)
    head = list(table[0]) if table else []
    parts = [
        style.paint(one_line(scene.title), "bold"),
        _wrapped(one_line(scene.question), width),
        "",
        columns(
            [list(row.values()) for row in table], style=replace(style, width=width), head=head
        ),
    ]
    if left_out:
        parts.append(
            _wrapped(f"left out for width, see --format csv: {', '.join(left_out)}", width)
        )
    failed = [r for r in records if r.get("message")]
    parts += [""] if failed else []
    parts += [_wrapped(f"{_who(r)}: {one_line(r['message'])}", width) for r in failed]
    if "picture" in scene.ask:
        for chart in scenery.charts(scene, records)[:1]:
            parts += ["", text(chart.series, x_label=chart.x_label, y_label=chart.y_label)]
        named = ", ".join(document["pictures"]) or "nothing to draw"
        parts += ["", _wrapped(f"pictures in {one_line(output)}: {named}", width)]
    said = _wrapped(f"answer  {one_line(document['answer'])}", width)
    parts += ["", style.paint("answer", "bold") + said.removeprefix("answer")]
    return "\n".join(parts)


def _wrapped(text: str, width: int) -> str:
    """Break prose at blanks only: a name or a path stays whole."""
    return fill(text, width, break_long_words=False, break_on_hyphens=False)


def _narrowed(
    table: Sequence[Mapping[str, str]], width: int
) -> tuple[list[dict[str, str]], list[str]]:
    """Leave out columns, the least wanted first, until the table fits; say which.

    Where that is not enough, the heads that are left get shorter.
    """
    kept = [dict(row) for row in table]
    left_out: list[str] = []
    for key in DISPENSABLE:
        told = {row.get(key) for row in kept}
        if _columns_of(kept) <= width:
            break
        if told == {None} or (key == "outcome" and told != {"completed"}):
            continue
        kept = [{k: text for k, text in row.items() if k != key} for row in kept]
        left_out.append(key)
    if _columns_of(kept) > width:
        kept = [{SHORT.get(key, key): text for key, text in row.items()} for row in kept]
    return kept, left_out


def _columns_of(table: Sequence[Mapping[str, str]]) -> int:
    """Return characters in a line of a table."""
    keys = list(table[0]) if table else []
    widths = [max(len(key), *(len(row[key]) for row in table)) for key in keys]
    return sum(widths) + 2 * max(len(widths) - 1, 0)


def _who(record: Mapping[str, Any]) -> str:
    task = record["task"]
    if task["kind"] == "peer":
        return f"{task['peer']}, tol {task['tolerance']:g}"
    return f"{task['method']}, h = {task['h']:.4g}"


def _write_csv(plans: Sequence[Plan], documents: Sequence[Mapping[str, Any]]) -> None:
    from .. import scenes as scenery

    last: tuple[str, ...] = ()
    for plan, document in zip(plans, documents, strict=True):
        table = scenery.rows(plan.scene, document["records"], raw=True)
        head = ("scene", *table[0]) if table else ()
        lines = [[plan.scene.name, *row.values()] for row in table]
        say(csv_text([*([head] if head != last else []), *lines]))
        last = head
