"""The suite over many adapters, each in a process of its own: integrator by property."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

from ..findings import Finding, Verdict
from ..system.arguments import no_such
from ..views.tables import one_line
from .adapter import SHIPPED
from .checks import RESTS_ON, claim_of
from .verdicts import defect_of

#: The adapter that is wrong on purpose: a board on which it is not red shows nothing.
PLANTED = "planted"
#: Our own engines are run with all methods of the vectors by the tests; they stand on a board where
#: they are named.
DEFAULT = tuple(x for x in SHIPPED if x not in ("reference", "compiled"))
#: Columns of the board.
CLAIMS = tuple(RESTS_ON)


@dataclass(frozen=True)
class Cell:
    """What all checks of one property of one integrator say."""

    #: ``fails`` where one fails, ``open`` where one is open, ``None`` where there is no check.
    verdict: Verdict | None
    said: str  #: The defect, or the reason why it is open; how many hold otherwise.


@dataclass(frozen=True)
class Row:
    """One method of one adapter."""

    method: str
    findings: tuple[Finding, ...]

    @property
    def cells(self) -> dict[str, Cell]:
        """Claim -> cell, for all columns."""
        return {claim: self._cell(claim) for claim in CLAIMS}

    def _cell(self, claim: str) -> Cell:
        mine = [x for x in self.findings if claim_of(x.claim) == claim]
        wrong = [x for x in mine if x.verdict is Verdict.FAILS]
        undecided = [x for x in mine if x.verdict is Verdict.OPEN]
        if not mine:
            return Cell(None, "no check of this kind")
        for found, verdict in ((wrong, Verdict.FAILS), (undecided, Verdict.OPEN)):
            if found:
                said = found[0].witness
                return Cell(verdict, defect_of(said) or one_line(said))
        return Cell(Verdict.HOLDS, f"{len(mine)} of {len(mine)} checks hold")


@dataclass(frozen=True)
class Run:
    """What the suite found of one adapter."""

    name: str  #: Of the adapter.
    release: str  #: Name and version of its library, or ``""``.
    command: str  #: What repeats the run.
    rows: tuple[Row, ...] = ()  #: Nothing where it did not run.
    reason: str = ""  #: Why it did not run, or ``""``.

    @property
    def as_it_should_be(self) -> bool:
        """Whether nothing fails, or, of the adapter that is wrong on purpose, something does."""
        fails = any(x.verdict is Verdict.FAILS for row in self.rows for x in row.findings)
        return fails is (self.name == PLANTED)


def board(names: Sequence[str] = (), seconds: float = 600) -> Iterator[Run]:
    """Run the suite on adapters, one after the other, for at most so many seconds each.

    Adapters are named as for ``glmref conformance``, by default those that are shipped. Each has a
    run, also where its library is not installed.

    Raises
    ------
    UsageError
        For a name that is not shipped and names no module or program.
    """
    for name in names:
        if ":" not in name:
            _check_shipped(name)
    for name in names or DEFAULT:
        command = f"glmref conformance {name} --format json"
        words = [sys.executable, "-m", "glmref", "conformance", name, "--format", "json"]
        try:
            done = subprocess.run(
                words, capture_output=True, text=True, check=False, timeout=seconds,
                stdin=subprocess.DEVNULL, encoding="utf-8", errors="replace",
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            yield Run(name, _release(name), command, reason=f"not done in {seconds:g} s")
            continue
        try:
            listed = [Finding.from_json(x) for x in json.loads(done.stdout)["findings"]]
        except (ValueError, KeyError, TypeError):
            last = (done.stderr.strip() or f"it ended with code {done.returncode}").splitlines()[-1]
            reason = one_line(last.removeprefix("glmref: "))
            yield Run(name, _release(name), command, reason=reason)
            continue
        methods = dict.fromkeys(x.method for x in listed)
        rows = tuple(Row(m, tuple(x for x in listed if x.method == m)) for m in methods)
        yield Run(name, _release(name), command, rows)


def _release(name: str) -> str:
    """Name and version of the library of a shipped adapter."""
    library = (SHIPPED[name].packages.split() if name in SHIPPED else [])[:1]
    try:
        return " ".join(f"{x} {version(x)}" for x in library)
    except PackageNotFoundError:
        return ""


def _check_shipped(name: str) -> None:
    if name not in SHIPPED:
        raise no_such("adapter", name, SHIPPED)


def recipe(name: str) -> str:
    """Return the container recipe in which an adapter runs.

    It is built in a checkout: ``docker build -f Dockerfile -t glmref-NAME CHECKOUT``.

    Raises
    ------
    UsageError
        For a name that is not shipped.
    """
    _check_shipped(name)
    needs = SHIPPED[name]
    system = (
        f"RUN apt-get update && apt-get install -y --no-install-recommends {needs.system} \\\n"
        f" && rm -rf /var/lib/apt/lists/*\n"
        if needs.system
        else ""
    )
    packages = f" {needs.packages}" if needs.packages else ""
    return (
        f"FROM python:3.12-slim-bookworm\n{system}{needs.build}"
        f"COPY . /glmref\nRUN pip install --no-cache-dir /glmref{packages}\n"
        f'CMD ["glmref", "conformance", "{name}", "--format", "json"]\n'
    )
