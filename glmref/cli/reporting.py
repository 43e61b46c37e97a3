"""``glmref report``: stored results as pages."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import UsageError
from ..views.tables import one_line
from .output import HOLDS, complain, say

#: What is read when nothing is named: what `glmref run` writes.
PLACE = Path("report")


@click.command(short_help="Write stored results as HTML pages.")
@click.argument("results", nargs=-1, type=click.Path(path_type=Path), metavar="[RESULTS]...")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    help="Folder of the pages, report/pages by default; with --single-file the file.",
)
@click.option("--single-file", "single", is_flag=True, help="Everything on one page.")
@click.option(
    "--all", "every", is_flag=True,
    help="The catalogue too: every method, the errata, the measurements that come with the data.",
)  # fmt: skip
@click.option(
    "--docs",
    default="",
    metavar="PLACE",
    help="Where the documentation lies: a folder seen from the pages, such as .., or an address.",
)
def report(
    results: tuple[Path, ...], output: Path | None, single: bool, every: bool, docs: str
) -> int:
    """Write HTML pages of stored results: runs, methods, measurements; nothing is computed.

    RESULTS are files and folders: scenes of your own that have been run into the folder report,
    records of `glmref run`, findings of `glmref verify --format json` and of the conformance suite,
    portraits NAME.svg of `glmref show NAME --plot`, method files of your own, which get a page
    each. By default the folder report. Pages are written of these only; with --all also those of
    the catalogue, with the measurements that come with the data (verdicts, observed orders,
    stability regions).
    """
    from ..catalogue.files import data_root
    from ..catalogue.lookup import names
    from ..report import build, read
    from ..report.markup import counted

    shipped = data_root() / "measurements"
    places = [x for given in results for x in _places(given)] if results else [PLACE]
    places = [x for x in places if results or x.exists()]
    if every and shipped.is_dir():
        places.append(shipped)
    found = read(places, names("methods"))
    for where, why in found.odd:
        complain(f"not shown: {where}: {why}")
    if found.is_empty and not every:
        where = ", ".join(one_line(x) for x in results or [PLACE])
        raise UsageError(
            f"there are no results in {where}; write some with `glmref run SCENE`, or give --all "
            "for the pages of the catalogue"
        )
    if output is None:
        output = Path("report", "pages.html") if single else Path("report", "pages")
    written = build(
        found, output, single=single, docs=docs, methods=names("methods") if every else None
    )
    records = sum(len(run.records) for run in found.runs)
    files, place = counted(len(written), "file"), one_line(written[0])
    say(f"{files} with {counted(records, 'record')}; open {place}")
    return HOLDS


def _places(given: Path) -> list[Path]:
    """Return what is read for an argument: of a scene, the files that `glmref run` wrote of it.

    Raises
    ------
    UsageError
        For a scene that has not been run.
    """
    if given.suffix != ".toml" or not given.is_file():
        return [given]
    from ..compute.records import SUFFIX
    from ..report.store import ABOUT_SUFFIX
    from ..scenes import load_scene

    name = load_scene(given).name
    ends = [f"{quick}{end}" for quick in ("", "-quick") for end in (SUFFIX, f"{ABOUT_SUFFIX}.json")]
    found = [x for end in ends if (x := PLACE / f"{name}{end}").is_file()]
    if not found:
        raise UsageError(
            f"there are no results of {one_line(given)} in {PLACE}; run "
            f"`glmref run {one_line(given)}`, then this command again"
        )
    return found
