"""Write the pages into a folder, or as one file."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from .. import __version__
from ..catalogue.canonical import canonical
from ..catalogue.lookup import names, path_of
from ..errors import UsageError
from ..system.files import make_folder, printable, reason, write_bytes, write_text
from .line_styles import looks
from .markup import Page, Site
from .measurements import measurement_pages
from .methods import by_class, is_shipped_name, method_page, overview
from .runs import run_page
from .searching import search_page
from .side_pages import audits_page, errata_page, measured_page
from .store import MARK, Results

_SAID = "Pages of `glmref report`. This folder is rewritten; keep nothing else in it.\n"


def pages_of(
    site: Site, results: Results, methods: Sequence[str], *, catalogue: bool
) -> list[Page]:
    """Return every page, in the order of the bar."""
    known = frozenset(methods)
    front = [overview(site, results, methods, catalogue=catalogue)]
    front += [run_page(site, run, known) for run in results.runs]
    front += measurement_pages(results)
    if catalogue:
        front += [audits_page(site), errata_page(site, known)]
    front.append(measured_page(results, __version__))
    if methods:
        front.append(search_page(site, results, by_class(results, methods), catalogue=catalogue))
    return front + [method_page(site, results, name) for name in by_class(results, methods)]


def build(
    results: Results, output: Path, *, single: bool = False, methods: Sequence[str] | None = None,
    docs: str = "",
) -> list[Path]:  # fmt: skip
    """Write the report of what :func:`.store.read` found.

    Into a folder, new, empty or of an earlier report; with ``single`` on one page in a file.
    ``methods`` of the catalogue get a page, with the overview of them and the errata; by default
    only those that the results say something about. ``docs`` is where the documentation lies, a
    folder seen from the pages or an address of the web.

    Raises
    ------
    UsageError
        For a folder with other things in it, or a file where a folder must be.
    """
    scheme, colon, _ = docs.partition(":")
    if colon and scheme not in ("http", "https"):
        raise UsageError(f"the documentation is a folder or an address of the web, got {docs!r}")
    site = Site(single, docs.rstrip("/"))
    shipped = names("methods")
    told = {*results.findings, *results.portraits, *results.regions}
    chosen = [x for x in shipped if x in told] if methods is None else list(methods)
    chosen += [name for name in results.of_others() if name not in chosen]
    pages = pages_of(site, results, chosen, catalogue=methods is not None)
    drawn = [lines for page in pages for lines in page.pictures]
    site = replace(site, looks=looks(drawn, frozenset({*shipped, *chosen})))
    if single:
        if os.path.isdir(output):
            raise UsageError(f"{printable(output)} is a folder; with a single file, name a file")
        make_folder(output.parent)
        write_text(output, site.document("glmref report", pages, pages))
        return [output]
    _clear(output)
    written = []
    for page in pages:
        path = output / f"{page.name}.html"
        write_text(path, site.document(page.title, [page], pages), sync=False)
        written.append(path)
        if page.name.startswith("method-"):
            name = page.name.removeprefix("method-")
            if name in results.own:
                content = canonical(results.own[name]).encode()
            elif is_shipped_name(name):
                content = path_of(name).read_bytes()
            else:  # findings alone were given
                continue
            write_bytes(output / "data" / f"{name}.json", content, sync=False)
    return written


def _clear(output: Path) -> None:
    """Make an empty folder of pages."""
    try:
        if output.is_file():
            raise UsageError(
                f"{printable(output)} is a file; name a folder, or ask for a single file"
            )
        if output.is_dir() and any(output.iterdir()) and not (output / MARK).is_file():
            raise UsageError(
                f"the folder {printable(output)} holds something that is no report; name another, "
                f"new one"
            )
        for inner in output.iterdir() if output.is_dir() else ():
            if inner.is_dir() and not inner.is_symlink():
                shutil.rmtree(inner)
            elif inner.name != MARK:  # by which a folder half done is known, too
                inner.unlink()
    except OSError as error:
        raise UsageError(
            f"the folder {printable(output)} cannot be rewritten ({reason(error)}); name another"
        ) from None
    make_folder(output / "data")
    write_text(output / MARK, _SAID)
