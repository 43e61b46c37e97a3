"""The page of a campaign: its question, what became of its tasks, and the map or the front.

Records are read once, one file in memory at a time; of each only the numbers of the picture stay.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from ..catalogue.canonical import compact
from ..errors import UsageError
from ..measure.timing import machine
from ..scenes.campaign import REDUCE, Picture
from ..system.files import write_text
from ..views.chart import Series, svg
from ..views.heat import heat_map
from .markup import Column, Page, Site, Table, render

if TYPE_CHECKING:
    from ..scenes.campaign import Campaign

Record = Mapping[str, Any]
#: Rows that are turned into columns at once.
_ROWS = 2_000
#: Pictures of a page at the most, and lines of one.
_PICTURES, _LINES = 60, 24


def campaign_page(campaign: Campaign, records: Iterable[Record], path: Path) -> None:
    """Write the page of a campaign."""
    outcomes: Counter[str] = Counter()
    machines: Counter[str] = Counter()
    messages: dict[str, str] = {}
    points: dict[tuple[Any, Any], dict[tuple[Any, Any], list[float]]] = defaultdict(dict)
    picture = campaign.picture
    for record in records:
        outcome = str(record["outcome"])
        outcomes[outcome] += 1
        if isinstance(record.get("where"), Mapping):
            machines[machine(record["where"])] += 1
        if record.get("message"):
            messages.setdefault(outcome, str(record["message"]))
        if picture is not None:
            _take(picture, record, points)
    cells = [[x, str(n), messages.get(x, "")] for x, n in outcomes.most_common()]
    columns = [Column("outcome", "outcome"), Column("n", "tasks"), Column("why", "the first says")]
    if not messages:
        cells, columns = [row[:2] for row in cells], columns[:2]
    body = render(
        "campaign.html",
        campaign=campaign,
        known=sum(outcomes.values()),
        total=len(campaign),
        machines=machines.most_common(),
        timed=campaign.limits.pinned,
        table=Table("outcomes", "What became of the tasks", columns, cells),
        pictures=[Markup(x) for x in islice(_pictures(picture, points), _PICTURES)],
        asked=[x for x in (picture.across, picture.up, picture.value) if x] if picture else [],
    )
    page = Page(f"campaign-{campaign.name}", campaign.title, body, campaign.name)
    write_text(path, Site(single=True).document(campaign.title, [page], [page]))


def _value(record: Record, key: str) -> Any:
    """Return a number or a text of a record or of its task; keys of keys are joined by a point."""
    for root in (record, record["task"]):
        found: Any = root
        for part in key.split("."):
            found = found.get(part) if isinstance(found, Mapping) else None
        if found is not None and not isinstance(found, Mapping | list):
            return found
    return None


def _take(picture: Picture, record: Record, points: Any) -> None:
    x, y = _value(record, picture.across), _value(record, picture.up)
    value = _value(record, picture.value) if picture.kind == "map" else y
    if str(record["outcome"]) != "completed":
        value = math.inf if picture.kind == "map" else None  # whatever its last number was
    if x is None or y is None or isinstance(value, str) or value is None:
        return
    group = (
        _value(record, picture.page) if picture.page else "",
        _value(record, picture.each) if picture.each else "",
    )
    place = (x, y) if picture.kind == "map" else (float(x), float(y))
    points[group].setdefault(place, []).append(float(value))


def _pictures(picture: Picture | None, points: Any) -> Iterator[str]:
    if picture is None:
        return
    if picture.kind == "map":
        yield from _maps(picture, points)
        return
    for page in sorted({page for page, _ in points}, key=str):
        groups = {each: list(found) for (at, each), found in points.items() if at == page}
        best = _front([x for found in groups.values() for x in found])
        lines = [Series(str(each), tuple(sorted(found))) for each, found in groups.items()]
        # the methods that reach the front first, as long as there is room
        lines.sort(key=lambda line: -len(set(line.points) & set(best)))
        shown = [Series("front", tuple(best)), *lines[:_LINES]]
        title, labels = _said(picture.page, page) or _last(picture.up), (picture.across, picture.up)
        yield svg(shown, title=title, x_label=_last(labels[0]), y_label=_last(labels[1]))


def _maps(picture: Picture, points: Any) -> Iterator[str]:
    reduce = REDUCE[picture.reduce]
    maps = {
        group: {place: float(reduce(values)) for place, values in found.items()}
        for group, found in sorted(points.items(), key=str)
    }
    values = [x for found in maps.values() for x in found.values() if math.isfinite(x)]
    limits = (min(values), max(values)) if values else None
    for (page, each), found in maps.items():
        said = [_said(picture.page, page), _said(picture.each, each)]
        yield heat_map(
            found, title=", ".join(filter(None, said)) or picture.value, limits=limits,
            x_label=_last(picture.across), y_label=_last(picture.up),
            value_label=_last(picture.value),
        )  # fmt: skip


def _said(key: str, value: Any) -> str:
    """Return a text as it is, and of anything else its key as well."""
    return value if isinstance(value, str) else f"{_last(key)} = {value}"


def _last(key: str) -> str:
    """Return the last part of a key of keys."""
    return key.rpartition(".")[2]


def _front(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return points such that no other is at most as large in both coordinates."""
    kept: list[tuple[float, float]] = []
    for x, y in sorted(points):
        if not kept or y < kept[-1][1]:
            kept.append((x, y))
    return kept


# --- columns --------------------------------------------------------------------------------------


def write_parquet(records: Iterable[Record], again: Iterable[Record], path: Path) -> int:
    """Write records as a table in columns.

    A column is a number or a text of a record, or of its task (``task.h``); what is a list or a
    mapping is kept as JSON. The records come twice: first their columns are found, then they are
    written.

    Raises
    ------
    UsageError
        Where pyarrow is not installed, or the file cannot be written.
    """
    try:
        pyarrow = import_module("pyarrow")
        parquet = import_module("pyarrow.parquet")
    except ImportError:
        raise UsageError(
            "no table in Parquet, because pyarrow is not installed; install it with "
            "`pip install 'glmref[cluster]'`"
        ) from None
    kinds: dict[str, type] = {}
    for record in records:
        for key, value in _flat(record):
            known = kinds.get(key, type(value))
            number = {known, type(value)} == {int, float}
            kinds[key] = float if number else known if known is type(value) else str
    arrow = {bool: pyarrow.bool_(), int: pyarrow.int64(), float: pyarrow.float64()}
    schema = pyarrow.schema([(k, arrow.get(x, pyarrow.string())) for k, x in kinds.items()])
    count, rows = 0, iter(again)
    aside = path.with_name(f".{path.name}.tmp")
    try:
        # a name that pyarrow opened could be an address to it, and had to be UTF-8
        with aside.open("wb") as stream, parquet.ParquetWriter(stream, schema) as writer:
            while batch := [dict(_flat(x)) for x in islice(rows, _ROWS)]:
                writer.write_table(pyarrow.Table.from_pylist(
                    [{k: _as(x, kinds[k]) for k, x in row.items()} for row in batch], schema
                ))  # fmt: skip
                count += len(batch)
        aside.replace(path)
    except OSError as error:
        raise UsageError(f"{path.name} cannot be written ({error}); make room there") from None
    finally:
        aside.unlink(missing_ok=True)
    return count


def _flat(record: Record) -> Iterator[tuple[str, Any]]:
    for prefix, table in (("", record), ("task.", record["task"])):
        for key, value in table.items():
            if key == "task" and not prefix:
                continue
            if isinstance(value, Mapping | list):
                yield prefix + key, compact(value, sort_keys=True).decode()
            elif value is not None:
                yield prefix + key, value


def _as(value: Any, kind: type) -> Any:
    return value if isinstance(value, kind) else kind(value)
