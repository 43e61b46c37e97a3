"""Campaigns of ``glmref run``: many tasks from a file, on this machine or on a cluster."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import click

from ..catalogue import canonical
from ..errors import UsageError
from ..system.files import make_folder
from ..views.tables import Style, columns, json_text, one_line
from .output import (
    HOLDS,
    INTERNAL,
    Progress,
    complain,
    said_when_interrupted,
    say,
)

if TYPE_CHECKING:
    from ..compute import Done, Executor, Records
    from ..scenes.campaign import Campaign

#: Tasks of a pilot, and seconds that each of them may take.
PILOT, PILOT_SECONDS = 3, 20.0
_FAILURES = ("internal error", "process killed")


def listing() -> str:
    """Return the shipped campaigns as a table."""
    from ..scenes.campaign import campaign_names, load_campaign

    found = [load_campaign(x) for x in campaign_names()]
    rows = [[x.name, f"{len(x):,} tasks", x.question] for x in found]
    return columns(rows, style=Style.of(sys.stdout), head=("campaign", "size", "question"))


def run_campaign(
    name: str, planned: bool, pages: bool, output: Path, form: str, on: str | None
) -> int:
    """Carry out a campaign, or show its plan, or make its pages; return the exit code."""
    from ..compute import Records, executor
    from ..scenes.campaign import load_campaign

    wanted = load_campaign(name)
    folder = output / wanted.name
    store = Records(folder / "records.sqlite")
    if planned:
        _show_plan(wanted, store, form)
        return HOLDS
    outcomes: Counter[str] = Counter()
    spent, number = 0.0, 0
    if not pages:
        make_folder(output)
        with executor(on) as where:
            if where.dashboard:
                click.echo(f"note: the cluster shows what it does at {where.dashboard}", err=True)
            number, spent = _carry_out(wanted, store, where, outcomes)
    for notice in store.notices:
        click.echo(f"note: {one_line(notice)}", err=True)
    store = Records(folder / "records.sqlite")
    written = _write(wanted, store, make_folder(folder))
    summary = {
        "format": "glmref-campaign-run-1",
        "campaign": wanted.name,
        "tasks": len(wanted),
        "carried_out": number,
        "records": len(store),
        "seconds": round(spent, 3),
        "outcomes": dict(sorted(outcomes.items())),
        "written": [str(path) for path in written],
    }
    if form == "json":
        say(json_text(summary))
    elif form == "jsonl":
        for record in store:
            say(canonical.compact(record).decode())
    else:
        said = ", ".join(f"{n} {x}" for x, n in outcomes.most_common()) or "nothing was missing"
        say(f"{number:,} tasks in {spent:,.0f} s of processes: {said}")
        left = len(wanted) - len(store)
        if left > 0 and not pages:
            say(f"{left:,} of {len(wanted):,} tasks are left; the same command goes on")
        say(f"wrote {', '.join(one_line(path) for path in written)}")
    return INTERNAL if any(outcomes[x] for x in _FAILURES) else HOLDS


def _carry_out(
    wanted: Campaign, store: Records, where: Executor, outcomes: Counter[str]
) -> tuple[int, float]:
    """Carry out what is missing within the budget; return how many tasks, and their seconds."""
    from ..compute import measure

    spent = 0.0

    def record(task: Mapping[str, Any], done: Done) -> Mapping[str, Any]:
        nonlocal spent
        spent += done.seconds
        return done.as_record()

    with Progress(len(wanted) - len(store), wanted.name, "task") as progress:

        def advance(task: Mapping[str, Any], one: Mapping[str, Any]) -> None:
            outcomes[str(one["outcome"])] += 1
            progress.threads = where.threads
            progress.advance(failed=str(one["outcome"]) in _FAILURES)

        def stop() -> bool:
            progress.out += 1
            return spent >= wanted.budget

        with said_when_interrupted(store, len(wanted), "tasks"):
            number = measure(
                wanted.kind.function, wanted.tasks(), store, where,
                wanted.limits, record=record, advance=advance, stop=stop,
            )  # fmt: skip
    if spent >= wanted.budget:
        complain(f"the budget of {wanted.budget:g} s is spent; the same command spends another one")
    return number, spent


def _write(wanted: Campaign, store: Records, folder: Path) -> list[Path]:
    """Write the page and the table; return what was written."""
    from ..report.campaigns import campaign_page, write_parquet

    page, table = folder / "index.html", folder / "results.parquet"
    campaign_page(wanted, iter(store), page)
    written = [page]
    if len(store):
        try:
            write_parquet(iter(store), iter(store), table)
            written.append(table)
        except UsageError as error:
            click.echo(f"note: {error}", err=True)
    return written


def _show_plan(wanted: Campaign, store: Records, form: str) -> None:
    """Say what there is to do, and what it costs by a few tasks that are carried out for it."""
    from ..compute.child import cores, physical_cores
    from ..compute.executors import Local

    pilot = list({id(x): x for x in wanted.spread(PILOT)}.values())
    limits = replace(wanted.limits, seconds=PILOT_SECONDS, pinned=False)
    begun = monotonic()
    results = [x for part in Local(1).run(wanted.kind.function, pilot, limits) for x in part]
    seconds = sum(done.seconds for _, done in results) / len(results)
    stopped = sum(done.failure == "time limit" for _, done in results)
    left = len(wanted) - len(store)
    usable = len(physical_cores() if wanted.limits.pinned else cores())
    document = {
        "format": "glmref-campaign-plan-1",
        "campaign": wanted.name,
        "question": wanted.question,
        "kind": wanted.kind.name,
        "tasks": len(wanted),
        "left": left,
        "axes": {k: len(x) for k, x in wanted.grid.items()},
        "sampled": {"axes": sorted(wanted.sample), "count": wanted.count, "draw": wanted.draw},
        "seed": wanted.seed,
        "budget": None if wanted.budget == float("inf") else wanted.budget,
        "pilot": {"tasks": len(results), "seconds": seconds, "stopped": stopped},
        "core_seconds": seconds * left,
    }
    if form == "json":
        say(json_text(document))
        return
    least = "at least " if stopped else "about "
    grid = " x ".join(f"{len(x):,} {k}" for k, x in wanted.grid.items())
    drawn = f"{wanted.count:,} points of {', '.join(wanted.sample)} ({wanted.draw})"
    hours = seconds * left / 3600
    each = len(wanted) // wanted.points
    lines = [
        ("question", one_line(wanted.question)),
        ("tasks", f"{len(wanted):,} of the kind {wanted.kind.name}, {left:,} of them left"),
        ("grid", (grid or "none") + (f", {each:,} tasks for each" if each > 1 else "")),
        ("sample", drawn if wanted.sample else "none"),
        ("timed", "yes: a core for each task" if wanted.limits.pinned else "no"),
        ("limits", f"{wanted.limits.seconds:g} s a task, {wanted.limits.retries} retries"),
        ("budget", "none" if document["budget"] is None else f"{wanted.budget:,.0f} s of cores"),
        ("pilot", f"{len(results)} tasks in {monotonic() - begun:.1f} s, {seconds:.3g} s a task"),
        ("cost", f"{least}{hours:,.3g} core hours; {hours / usable:,.3g} hours on {usable} cores"),
    ]
    say(columns(lines, style=Style.of(sys.stdout)))
