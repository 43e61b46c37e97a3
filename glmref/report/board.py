"""The board of integrators as one page, with the runs behind it."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from .. import __version__
from ..conformance.adapter import SHIPPED
from ..conformance.board import CLAIMS, PLANTED, Run, recipe
from ..conformance.checks import claim_of
from ..system.files import make_folder, write_text
from ..views.tables import findings_json
from .markup import Page, Site, render


def build_board(runs: Sequence[Run], output: Path, today: str = "") -> Path:
    """Write the page, the findings of each run, and the container recipes; return the page.

    The folder has ``index.html``, ``runs/N-NAME.json``, ``recipes/NAME.Dockerfile``, and the page a
    date.
    """
    make_folder(output / "runs")
    make_folder(output / "recipes")
    files = {}
    for number, run in enumerate(runs):
        word = "".join(c if c.isalnum() else "-" for c in run.name)[:40]
        files[run.name] = f"runs/{number}-{word}.json"
        listed = [x for row in run.rows for x in row.findings]
        write_text(output / files[run.name], findings_json(listed) + "\n")
        if run.name in SHIPPED:
            write_text(output / "recipes" / f"{run.name}.Dockerfile", recipe(run.name))
    known = {claim_of(x.claim) for run in runs for row in run.rows for x in row.findings}
    body = render(
        "board.html", runs=runs, claims=[x for x in CLAIMS if x in known], files=files,
        shipped=SHIPPED, planted=PLANTED,
        version=__version__, today=today or datetime.now(UTC).date().isoformat(),
        claim_of=claim_of,
    )  # fmt: skip
    page = Page("board", "Integrators by property", body, "board")
    place = output / "index.html"
    write_text(place, Site(single=True).document("Integrators by property", [page], [page]))
    return place
