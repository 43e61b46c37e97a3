"""``glmref conformance`` and ``glmref probe``: is this code the method, and which method is it."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..findings import Verdict
from ..views.tables import FORMATS, Style, columns, counted, json_text, one_line, shown_value
from .output import FAILED, HOLDS, INTERNAL, Progress, complain, format_option, say

if TYPE_CHECKING:
    from ..conformance.identify import Probe


@click.command(short_help="Test that an integrator implements its method.")
@click.argument("adapter", metavar="ADAPTER")
@click.option(
    "--known-failures", metavar="FILE", help="Lines `id: reason` of the expected failures."
)
@format_option(FORMATS)
@click.option("--list", "ids", is_flag=True, help="Write the ids of the checks and stop.")
def conformance(adapter: str, known_failures: str | None, form: str, ids: bool) -> int:
    """Run the conformance suite on an integrator.

    ADAPTER is package.module:Name, cmd:program, or a shipped adapter such as scipy. Exit codes: 0
    every check holds, 1 one fails, 2 the adapter or an option is bad; under pytest the codes are
    pytest's.
    """
    from ..conformance.suite_findings import findings_of, ids_of, text_of

    # what the adapter prints goes to stderr, so that stdout holds the findings and nothing else
    with redirect_stdout(sys.stderr):
        listed = ids_of(adapter) if ids else []
        found = [] if ids else findings_of(adapter, known_failures)
    say("\n".join(listed) if ids else text_of(found, form, Style.of(sys.stdout)))
    return FAILED if any(x.verdict is Verdict.FAILS for x in found) else HOLDS


@click.command(short_help="Identify the method of an integrator.")
@click.argument("adapter", metavar="ADAPTER")
@click.option("--method", metavar="NAME", help="This one of the adapter's methods only.")
@format_option(("table", "json"))
def probe(adapter: str, method: str | None, form: str) -> int:
    """Read the coefficients out of a running integrator, name the method, and analyze it.

    ADAPTER is package.module:Name, cmd:program, or a shipped adapter such as scipy. Exit code 3
    when something could not be determined; the output says what.
    """
    from ..conformance.identify import FORMAT, identify
    from ..conformance.suite_findings import loaded

    # what the adapter prints goes to stderr
    with redirect_stdout(sys.stderr), loaded(adapter) as subject:
        found = identify(subject, method)
    if form == "json":
        say(json_text({"format": FORMAT, "probes": [x.as_json() for x in found]}))
    else:
        style = Style.of(sys.stdout)
        say("\n\n".join(_page(x, style) for x in found))
    return INTERNAL if any(x.reading is None or x.notes for x in found) else HOLDS


@click.command(short_help="Run the conformance suite on many integrators: one page.")
@click.argument("adapters", nargs=-1, metavar="[ADAPTER]...")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("board"),
    help="Folder of the page and of the runs; board by default.",
)
@click.option(
    "--seconds",
    type=click.FloatRange(1, 10**6),
    default=600,
    help="Time limit of each integrator; 600 by default.",
)
@click.option("--recipe", metavar="ADAPTER", help="Write its container recipe and stop.")
def board(adapters: tuple[str, ...], output: Path, seconds: float, recipe: str | None) -> int:
    """Run the conformance suite on integrators, and write a page: integrator by property.

    An ADAPTER is written as for `glmref conformance`; by default all that are shipped, except for
    the engines of glmref. What is not installed is grey, with the reason. Exit code 1 when a check
    fails, or when the adapter that is wrong on purpose passes.
    """
    from ..conformance import board as suite
    from ..report.board import build_board

    if recipe is not None:
        say(suite.recipe(recipe).rstrip())
        return HOLDS
    runs = []
    with Progress(len(adapters or suite.DEFAULT), "board", "adapter") as progress:
        for run in suite.board(adapters, seconds):
            runs.append(run)
            progress.advance(run.name)
    place = build_board(runs, output)
    rows = [row for run in runs for row in run.rows]
    absent = sum(bool(run.reason) for run in runs)
    say(
        f"{counted(len(rows), 'method')} of {counted(len(runs) - absent, 'integrator')}, "
        f"{absent} did not run; open {one_line(place)}"
    )
    wrong = [run for run in runs if not run.reason and not run.as_it_should_be]
    for run in wrong:
        complain(f"{run.name}: {'passes' if run.name == suite.PLANTED else 'a check fails'}")
    return FAILED if wrong else HOLDS


def _page(found: Probe, style: Style) -> str:
    """Return one method as lines of name and value."""
    rows: list[tuple[str, str]] = []
    reading = found.reading
    wrong = found.wrong_times
    if wrong is not None:
        rows.append(("is", f"not {wrong.name}: its coefficients, with f at other times"))
        rows.append(("", f"those of {wrong.name}: c = {_numbers(wrong.times)}"))
    elif found.matches:
        names = ", ".join(m.name for m in found.matches)
        rows.append(("is", f"{names} (to {max(m.difference for m in found.matches):.2g})"))
        if not found.matches[0].same_basis:
            rows.append(("", "after a change of the values that are carried"))
    elif reading is not None:
        rows.append(("is", "no method of the catalogue"))
    if reading is not None:
        blocks = {letter: getattr(reading, letter) for letter in "AUBV"}
        if reading.hat is not None:
            blocks |= {f"{x}^": matrix for x, matrix in zip("AUBV", reading.hat, strict=True)}
        elif len(reading.V) == 1:
            blocks = {"A": reading.A, "b": reading.B}
        for name, matrix in blocks.items():
            for i, row in enumerate(matrix):
                rows.append((name if i == 0 else "", "  ".join(f"{x:.15g}" for x in row)))
        if reading.c is not None:
            rows.append(("c", _numbers(reading.c)))
        rows.append(("calls of f", str(reading.evaluations)))
        rows.append(("unexplained", f"{reading.unexplained:.2g} of a nonlinear step"))
    rows += _analysis(found)
    rows += [("not seen" if i == 0 else "", one_line(x)) for i, x in enumerate(found.notes)]
    head = one_line(found.method)
    if wrong is not None:
        head += " with wrong stage times"
    return "\n".join([style.paint(head, "bold"), columns(rows, style=style)])


def _numbers(values: Iterable[float]) -> str:
    return "  ".join(f"{x:.15g}" for x in values)


def _analysis(found: Probe) -> list[tuple[str, str]]:
    if found.analysis is None:
        return []
    record: dict[str, Any] = found.analysis.as_json()
    basis = "of the method it is" if found.matches else "of the closed forms of its numbers"
    if found.wrong_times is not None:
        basis = f"of {found.wrong_times.name}, which this is on autonomous systems only"
    if not (found.matches or found.recognised):
        basis = "of its numbers with the digits that were read"
    return [
        ("order", f"{record['order']}; {record['order_witness']}"),
        ("G-symplectic", shown_value(record["g_symplectic"]["holds"])),
        ("symmetric", shown_value(record["symmetric"]["holds"])),
        ("parasitism free", shown_value(record["parasitism_free"])),
        ("proof", f"{record['proof']}, {basis}"),
    ]
