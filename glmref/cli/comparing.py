"""``glmref problems`` and ``glmref compare``: the problems there are, and a method for one."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from ..errors import UsageError
from ..system.files import make_folder, write_text
from ..system.shown import Drawing
from ..system.terminal import saying
from ..views.tables import Style, columns, csv_text, json_text, one_line
from .output import HOLDS, complete_problem, format_option, say, say_rows


@click.command(short_help="List the shipped problems, with formulas.")
@click.argument("names", nargs=-1, metavar="[NAME|FILE]...", shell_complete=complete_problem)
@format_option(
    ("table", "json", "csv", "c"),
    "Format of the output; c: the right-hand side of one problem for `glmref convert --to c`.",
)
def problems(names: tuple[str, ...], form: str) -> int:
    """List the shipped problems, or show the formulas of some.

    A FILE is a problem of your own: a table with `H`, `f` or `file` in TOML, or a scene.
    """
    from .. import problems as collection
    from ..views.problem_page import c_source, described, kind_of, page

    if form == "c" and len(names) != 1:
        raise UsageError("--format c writes one problem; name one")
    chosen = [_found(name) for name in names] or [_found(name) for name in collection.names()]
    if form == "c":
        say(c_source(chosen[0][0]))
    elif form == "json":
        listed = [described(problem, about) for problem, about in chosen]
        say(json_text({"format": "glmref-problems-1", "problems": listed}))
    elif names and form == "table":
        style = Style.of(sys.stdout)
        say("\n\n".join(columns(page(*one), style=style) for one in chosen))
    else:
        rows = [[p.name, str(p.dimension), kind_of(p), about] for p, about in chosen]
        say_rows(form, ("name", "dimension", "kind", "about"), rows)
    return HOLDS


def _found(name: str) -> tuple[Any, str]:
    """Return a problem by name or file, and one line on it."""
    from .. import problems as collection

    if name.endswith(".toml"):
        return collection.from_path(name), ""
    return collection.problem(name), collection.about(name)


@click.command(short_help="Measure methods on a problem, recommend one.")
@click.argument("problem", metavar="PROBLEM|FILE", shell_complete=complete_problem)
@click.option("--methods", metavar="NAME,NAME,...", help="These methods instead of the usual ones.")
@click.option("--tolerance", type=float, default=1e-9, show_default=True, help="Relative error.")
@click.option("--t-end", metavar="TIME", help="End of the runs, such as 50 or '20*pi'.")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for the pictures and the numbers.",
)
@format_option()
def compare(
    problem: str,
    methods: str | None,
    tolerance: float,
    t_end: str | None,
    output: Path | None,
    form: str,
) -> int:
    """Measure error against run time on a PROBLEM and recommend one method.

    A FILE is a problem of your own in TOML: `H = "p**2/2 - cos(q)"` and `y0 = { q = 1, p = 0 }`, or
    `f`, or `file = "mine.py:make"`, which is executed. Takes less than a minute.
    """
    from ..problems.from_expressions import time_of
    from ..scenes.comparing import compare as measure

    chosen = None if methods is None else [x.strip() for x in methods.split(",") if x.strip()]
    end = None if t_end is None else time_of(_number(t_end), "--t-end")
    with saying(f"comparing methods on {problem} ..."):
        found = measure(problem, methods=chosen, tolerance=tolerance, t_end=end)
    written: list[str] = []
    if output is not None:
        make_folder(output)
        stem = output / found.problem.replace("/", "-")
        for suffix, against in (("", "seconds"), ("-evaluations", "evaluations")):
            path = stem.with_name(f"{stem.name}{suffix}.svg")
            written.append(Drawing(found.svg(against=against)).save(path).name)
        path = stem.with_name(f"{stem.name}.json")
        write_text(path, json_text(found.as_json()) + "\n")
        written.append(path.name)
    if form == "json":
        say(json_text(found.as_json()))
    elif form == "csv":
        head = ("method", "order", "h", "steps", "error", "evaluations", "seconds", "long_runs")
        say(csv_text([head, *([getattr(one, k) for k in head] for one in found.candidates)]))
    else:
        say(found.table(Style.of(sys.stdout)))
        if written:
            say(f"\nwrote {', '.join(written)} in {one_line(output)}")
    return HOLDS


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
