"""Search for methods of an ansatz given as a TOML file, from many random starts.

Options: ``ansatz`` the file, ``seed`` and ``starts`` of the search, ``wanted`` how many methods to
complete, ``scale`` the spread of the random starts, ``state`` a file of records that keeps what was
run: with the same file, ansatz and seed, a search that was stopped goes on where it was; ``on``
where starts run, as in ``glmref run --on``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...compute import Records, executor, measure
from ...errors import UsageError
from ..ansatz import Ansatz
from ..parameters import fix_parameters
from ..search import Found
from ..search_tasks import carry_out, ends_of, tasks_of
from .derivation import Derivation, Progress, Statement, searched
from .solved import Rough, finish

OPTIONS: Mapping[str, str] = {
    "ansatz": "",
    "seed": "1",
    "starts": "128",
    "wanted": "1",
    "scale": "0.7",
    "state": "",
    "on": "",
}


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Search, fix free parameters rationally, polish, prove.

    Raises
    ------
    UsageError
        For an option that cannot be read.
    DataError
        For an ansatz file that cannot be read.
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

    def make(found: Found) -> tuple[dict[str, Any], Sequence[Statement]]:
        square, point = fix_parameters(ansatz, found.point)
        named = replace(square, name=f"{ansatz.name}-{found.number}" if wanted > 1 else ansatz.name)
        start = " ".join(map(repr, point))
        return finish(Rough(named, start, f"search, seed {seed}, start {found.number}"))

    ends = _ends(ansatz, options, seed, starts, scale, progress)
    return searched("search", ends, make, wanted=wanted)


def _ends(
    ansatz: Ansatz,
    options: Mapping[str, str],
    seed: int,
    starts: int,
    scale: float,
    progress: Progress,
) -> Iterator[Found]:
    """Yield ends of all starts in order; those that the state lacks are computed first."""
    store = Records(Path(options["state"]) if options["state"] else None)
    tasks = list(tasks_of(ansatz, seed=seed, starts=starts, scale=scale))
    done = sum(task["starts"] for task in tasks if store.find(task))

    def advance(task: Mapping[str, object], record: Mapping[str, object]) -> None:
        nonlocal done
        done += int(str(task["starts"]))
        progress("starts", done, starts)

    if any(True for _ in store.missing(tasks)):
        with executor(options["on"]) as where:
            measure(carry_out, tasks, store, where, advance=advance)
    for task in tasks:
        record = store.find(task)
        if record is None or "ends" not in record:
            why = f" ({record['message']})" if record else ""
            raise UsageError(f"the starts from number {task['first']} on were not run{why}")
        yield from ends_of(record)
