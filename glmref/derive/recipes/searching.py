"""Search for methods of an ansatz given as a TOML file, from many random starts.

Options: ``ansatz`` the file, ``seed`` and ``starts`` of the search, ``wanted`` how many methods to
complete, ``scale`` the spread of the random starts, ``state`` a file that keeps what was run: with
the same file, ansatz and seed, a search that was stopped goes on where it was.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from ...errors import GlmrefError, UsageError
from ...findings import Proof
from ...prove.system import SweepSystem
from ...system.files import printable, reason
from ..ansatz import Ansatz
from ..parameters import fix_parameters
from ..search import Found, search
from .record import Derivation, Progress, Statement
from .solved import Rough, finish

__all__ = ["OPTIONS", "derive"]

OPTIONS: Mapping[str, str] = {
    "ansatz": "",
    "seed": "1",
    "starts": "128",
    "wanted": "1",
    "scale": "0.7",
    "state": "",
}

#: Largest residual in double precision of an end that is taken for a solution.
SOLVED = 1e-10


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Search, fix free parameters rationally, polish, prove.

    Raises
    ------
        UsageError: for an option that cannot be read.
        DataError: for an ansatz file that cannot be read.
    """
    if not options["ansatz"]:
        raise UsageError("`ansatz` must name a TOML file, see glmref.derive.ansatz")
    path = Path(options["ansatz"])
    ansatz = Ansatz.from_toml(path)
    try:
        seed, starts, wanted = (int(options[x]) for x in ("seed", "starts", "wanted"))
        scale = float(options["scale"])
    except ValueError as error:
        raise UsageError(
            f"`seed`, `starts`, `wanted` and `scale` must be numbers ({error})"
        ) from None
    state = _State(Path(options["state"])) if options["state"] else None
    key = hashlib.sha256(f"{path.read_bytes()!r} {seed} {scale}".encode()).hexdigest()[:16]
    documents, statements = [], list[Statement]()
    best, count = float("inf"), 0
    for found in _ends(ansatz, seed, starts, scale, progress, state, key):
        best, count = min(best, found.residual), count + 1
        if found.residual > SOLVED or len(documents) >= wanted:
            continue
        try:
            square, point = fix_parameters(ansatz, found.point)
            named = replace(
                square, name=f"{ansatz.name}-{found.number}" if wanted > 1 else ansatz.name
            )
            start = [repr(x) for x in point]
            rough = Rough(named, start, f"search, seed {seed}, start {found.number}")
            document, _, proved = finish(rough)
        except GlmrefError as error:
            statements.append(Statement(f"start {found.number}: {error}", Proof.MEASURED))
            continue
        documents.append(document)
        statements += proved
    text = f"{count} starts, smallest residual {best:.3g}, {len(documents)} methods completed"
    statements.append(Statement(text, Proof.MEASURED))
    return Derivation("search", documents, statements)


def _ends(
    ansatz: Ansatz,
    seed: int,
    starts: int,
    scale: float,
    progress: Progress,
    state: _State | None,
    key: str,
) -> Iterator[Found]:
    """Ends of all starts: those kept in the state first, then new ones."""
    kept = state.read(key) if state else []
    yield from kept[:starts]
    if len(kept) >= starts:
        return
    system = SweepSystem(ansatz.document())
    size = len(system.unknowns)

    def draw(generator: np.random.Generator) -> np.ndarray:
        return generator.normal(size=size) * scale

    done = len(kept)
    for found in search(
        system.residuals,
        draw,
        seed=seed,
        starts=starts - done,
        first=done,
        progress=lambda k, total: progress("starts", done + k, done + total),
    ):
        if state:
            state.append(key, found)
        yield found


class _State:
    """One line of JSON for each start that was run."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def read(self, key: str) -> list[Found]:
        """The ends of starts 0, 1, .. as far as they are there without a gap."""
        if not self.path.is_file():
            return []
        rows: dict[int, Found] = {}
        for line in self.path.read_text(encoding="utf-8").splitlines():
            try:
                row = json.loads(line)
                if row.pop("search") == key:
                    rows[row["number"]] = Found(row["number"], tuple(row["point"]), row["residual"])
            except (ValueError, KeyError, TypeError):
                continue  # a line cut off when the run was stopped
        result: list[Found] = []
        while len(result) in rows:
            result.append(rows[len(result)])
        return result

    def append(self, key: str, found: Found) -> None:
        """Keep one end."""
        line = json.dumps({"search": key, **asdict(found)}).encode() + b"\n"
        try:
            with self.path.open("a+b") as file:
                if file.tell():
                    file.seek(-1, os.SEEK_END)
                    # a run that was stopped in the middle of a line spoils no other one
                    line = line if file.read(1) == b"\n" else b"\n" + line
                file.write(line)
        except OSError as error:
            raise UsageError(
                f"the state {printable(self.path)} cannot be written ({reason(error)}); make room "
                f"there, or name another file"
            ) from None
