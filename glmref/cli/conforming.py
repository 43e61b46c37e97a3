"""``glmref conformance``: is this code the method, and which method is it."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import UsageError
from ..findings import Verdict
from ..views.tables import FORMATS, Style, columns, counted, json_text, one_line, shown_value
from .output import FAILED, HOLDS, INTERNAL, Progress, complain, format_option, say

if TYPE_CHECKING:
    from ..conformance.identify import Probe


@click.command(short_help="Test integrators, or find out which method they are.")
@click.argument("adapters", nargs=-1, metavar="[ADAPTER]...")
@click.option(
    "--known-failures", metavar="FILE", help="Lines `id: reason` of the expected failures."
)
@format_option(FORMATS)
@click.option("--list", "ids", is_flag=True, help="Write the ids of the checks and stop.")
@click.option(
    "--identify", "named", is_flag=True,
    help="Read the coefficients out of the running integrator, name its methods, analyze them.",
)  # fmt: skip
@click.option("--method", metavar="NAME", help="With --identify: this one of its methods only.")
@click.option(
    "--board", "page", is_flag=True,
    help="Test many integrators, by default all that are shipped but for the engines of glmref, "
    "and write a page: integrator by property.",
)  # fmt: skip
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    help="With --board: the folder of the page and of the runs; board by default.",
)
@click.option(
    "--seconds",
    type=click.FloatRange(1, 10**6),
    metavar="SECONDS",
    help="With --board: time limit of each integrator; 600 by default.",
)
@click.option("--recipe", metavar="ADAPTER", help="Write its container recipe and stop.")
def conformance(
    adapters: tuple[str, ...],
    known_failures: str | None,
    form: str,
    ids: bool,
    named: bool,
    method: str | None,
    page: bool,
    output: Path | None,
    seconds: float | None,
    recipe: str | None,
) -> int:
    """Run the conformance suite on an integrator.

    ADAPTER is package.module:Name, cmd:program, or a shipped adapter such as scipy. Exit codes: 0
    every check holds, 1 one fails, 2 the adapter or an option is bad; with --identify 3 when
    something could not be determined, which the output says; with --board 1 also when the adapter
    that is wrong on purpose passes, and what is not installed is grey, with the reason. Under
    pytest the codes are pytest's.
    """
    if recipe is not None:
        from ..conformance.board import recipe as recipe_of

        say(recipe_of(recipe).rstrip())
        return HOLDS
    if (method and not named) or ((output or seconds) and not page):
        raise UsageError("--method is for --identify, --output and --seconds are for --board")
    others = ids or known_failures
    if (named and (page or others or form not in ("table", "json"))) or (page and others):
        raise UsageError("--identify and --board stand alone; --identify writes a table or json")
    if page:
        return _board(adapters, output or Path("board"), seconds or 600)
    if len(adapters) != 1:
        raise UsageError("name one adapter, as in `glmref conformance scipy`; --board takes many")
    if named:
        return _identify(adapters[0], method, form)
    from ..conformance.suite_findings import findings_of, ids_of, text_of

    # what the adapter prints goes to stderr, so that stdout holds the findings and nothing else
    with redirect_stdout(sys.stderr):
        listed = ids_of(adapters[0]) if ids else []
        found = [] if ids else findings_of(adapters[0], known_failures)
    say("\n".join(listed) if ids else text_of(found, form, Style.of(sys.stdout)))
    return FAILED if any(x.verdict is Verdict.FAILS for x in found) else HOLDS


def _identify(adapter: str, method: str | None, form: str) -> int:
    """Say which methods an integrator is, and return the exit code."""
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


def _board(adapters: tuple[str, ...], output: Path, seconds: float) -> int:
    """Write the page of many integrators, and return the exit code."""
    from ..conformance import board as suite
    from ..report.board import build_board

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
        blocks = {name.replace("_hat", "^"): matrix for name, matrix in reading.blocks.items()}
        if reading.single and reading.values == 1:
            blocks = {"A": blocks["A"], "b": blocks["B"]}
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
