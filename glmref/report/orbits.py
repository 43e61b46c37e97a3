"""Pictures of paths in a plane, with their numbers, from the orbits that records hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..views.paths import Cloud, one_each, ranging
from .markup import Column, Figure, Table, number
from .store import Record, RunFile, is_number, method_of

#: Runs and points of orbits on one page: with more a page takes longer than a second to load.
MOST = 6000
_BAD = "a stored point is not three numbers"


@dataclass(frozen=True)
class _Orbit:
    """What a record holds: axes, points [t, x, y] of each body, and why they stop early."""

    name: str
    h: float | None
    axes: tuple[str, str]
    paths: list[list[list[float]]]
    ended: str

    @property
    def cloud(self) -> Cloud:
        points = tuple((x, y) for path in self.paths for _, x, y in path)
        return Cloud(self.name, points, self.ended, self.h)


@dataclass(frozen=True)
class Orbits:
    """What a page shows of the orbits of a run."""

    #: Picture of all paths in the plane of the first; none where there are only points.
    figure: Figure | None
    table: Table  #: Its numbers.
    lost: list[tuple[str, str]]  #: Methods lost at every step size, and how.
    left_out: int  #: Methods whose orbits are stored and not drawn.


def orbits(run: RunFile, title: str, far: str = "") -> Orbits | None:
    """Return what a page shows of the orbits of a run; nothing where none is stored."""
    found = [one for one in map(_orbit, run.records) if one is not None]
    room = MOST - len(run.records)
    shown = _fitting(_one_each([x for x in found if x.axes == found[0].axes]), room)
    if not shown:
        return None
    left_out = len({one.name for one in found}) - len(shown)
    across, up = shown[0].axes
    several = any(len(one.paths) > 1 for one in shown)
    cells = [
        [
            *(one.name, number(one.h)),
            *([number(k + 1)] if several else []),
            *map(number, point),
        ]
        for one in shown
        for k, path in enumerate(one.paths)
        for point in path
    ]
    columns = [Column("method", "method"), Column("h", "step size h")]
    columns += [*([Column("body", "body")] if several else []), Column("t", "time t")]
    columns += [Column("x", across, linear=True), Column("y", up, linear=True)]
    table = Table(f"o-{run.name}", f"{up} against {across}", columns, cells)
    setting = {cloud.name for cloud in ranging([one.cloud for one in shown])}
    caption = (
        f"{up} against {across} of each method, at the largest step size at which it is not lost, "
        "at times spread over the whole run; points are not joined, all panels have one range."
        + far
    )
    beyond = [one.name for one in shown if one.name not in setting]
    lost = [(one.name, one.ended) for one in shown if one.ended]
    drawn = any(len(path) > 1 for one in shown for path in one.paths)
    picture = Figure(table.id, ["x"], ["y"], f"orbit, {title}", caption, plane=beyond)
    return Orbits(picture if drawn else None, table, lost, left_out)


def _one_each(found: Sequence[_Orbit]) -> list[_Orbit]:
    """Return one orbit a method, as :func:`..views.paths.one_each` chooses."""
    clouds = [one.cloud for one in found]
    chosen = one_each(clouds)
    return [next(x for x, y in zip(found, clouds, strict=True) if y is cloud) for cloud in chosen]


def _fitting(found: Sequence[_Orbit], room: int) -> list[_Orbit]:
    """Return the first ones that have room together."""
    kept = []
    for one in found:
        room -= sum(map(len, one.paths))
        if room < 0:
            break
        kept.append(one)
    return kept


def _orbit(record: Record) -> _Orbit | None:
    """Return the orbit of a record, up to the first point that cannot be drawn."""
    block = record.get("orbit")
    if not isinstance(block, dict):
        return None
    axes, paths = block.get("axes"), block.get("paths")
    if not (isinstance(axes, list) and len(axes) == 2 and all(isinstance(x, str) for x in axes)):
        return None
    if not (isinstance(paths, list) and paths and all(isinstance(x, list) for x in paths)):
        return None
    good = [path[: _sound(path)] for path in paths]
    torn = any(len(a) < len(b) for a, b in zip(good, paths, strict=True))
    ended = str(block.get("ended") or "") or (_BAD if torn else "")
    h = record["task"].get("h")
    step = float(h) if is_number(h) else None
    return _Orbit(method_of(record), step, (axes[0], axes[1]), good, ended)


def _sound(path: list[Any]) -> int:
    """Return how many points stand before the first that is not three numbers."""
    return next((k for k, point in enumerate(path) if not _is_point(point)), len(path))


def _is_point(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(map(is_number, value))
