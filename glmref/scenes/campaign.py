"""Campaigns: many tasks from a grid or a sample, with a question and a budget, as a TOML file.

A campaign is to a cluster what a scene is to one machine. Its file names a *kind* of task
(:mod:`.campaign_kinds`) and the *axes* of what is varied::

    [fixed]                     keys that are the same for all tasks
    t_end = 100

    [grid]                      every combination of these
    method = { having = "g-symplectic" }
    h = { from = 0.01, to = 1, count = 50, spacing = "log" }

    [sample]                    crossed with points that are drawn together, on all these axes
    count = 200
    draw = "halton"
    frequency = { from = 1, to = 10 }

The tasks come one after another, and no list of them is made.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice, product
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue.files import table_path, tables_of
from ..catalogue.lookup import names as method_names
from ..compute import Limits
from ..errors import DataError, GlmrefError, UsageError
from ..problems import names as problem_names
from .campaign_kinds import CAMPAIGN_KINDS, CampaignKind
from .reading import MAX_NAME, Reader, between

FORMAT = "glmref-campaign-1"
#: Values of one axis at the most, and points of a sample.
MOST = 10_000_000
_TEXTS = ("format", "name", "title", "question")
_KEYS = (*_TEXTS, "kind", "seed", "budget", "limits", "fixed", "grid", "sample", "report")
_DRAWS = ("halton", "random")
#: What a picture makes of the numbers that fall on one cell.
REDUCE = {"max": max, "min": min, "sum": math.fsum, "mean": lambda x: math.fsum(x) / len(x)}


@dataclass(frozen=True)
class Picture:
    """What the page of a campaign shows."""

    #: ``"map"``: colours over two axes; ``"front"``: points, and the line that none is below.
    kind: str
    #: Keys of a record, or of its task, for the two axes.
    across: str
    up: str
    value: str = ""  #: Key of what a map shows in colour.
    each: str = ""  #: Key that tells the maps, or the lines of a front, apart; ``""`` for one only.
    page: str = ""  #: Key that tells fronts apart; ``""`` for one only.
    reduce: str = "max"  #: What is made of several records on one cell: one of :data:`REDUCE`.


@dataclass(frozen=True)
class Campaign:
    """A campaign, as its file describes it."""

    #: For the reader.
    name: str
    title: str
    question: str
    kind: CampaignKind  #: What a task is.
    fixed: Mapping[str, Any]  #: Values that all tasks share.
    grid: Mapping[str, tuple[Any, ...]]  #: Axis -> its values, which are crossed.
    sample: Mapping[str, tuple[float, float, str]]  #: Axis -> (from, to, spacing), drawn together.
    #: Points of the sample, and how they are drawn.
    count: int = 1
    draw: str = "halton"
    seed: int = 1  #: Of what is drawn at random.
    #: Seconds of processor time that one command may spend; infinite without a limit.
    budget: float = math.inf
    limits: Limits = field(default_factory=Limits)  #: Of one task.
    picture: Picture | None = None  #: What the page shows besides the table of outcomes.

    def __len__(self) -> int:
        """Return how many tasks there are."""
        return self.points * self.kind.each(self.fixed)

    @property
    def points(self) -> int:
        """How many combinations there are."""
        return math.prod(map(len, self.grid.values())) * self.count

    def tasks(self) -> Iterator[dict[str, Any]]:
        """Yield every task, in the same order each time."""
        for values in product(*self.grid.values()):
            crossed = {**self.fixed, **dict(zip(self.grid, values, strict=True))}
            for drawn in self._drawn():
                yield from self.kind.tasks({**crossed, **drawn}, self.seed)

    def spread(self, number: int) -> list[dict[str, Any]]:
        """Return a few of the tasks, spread over the campaign."""
        whole = len(self)
        return [
            self._at(k)
            for k in sorted({(2 * k + 1) * whole // (2 * number) for k in range(number)})
        ]

    def _at(self, place: int) -> dict[str, Any]:
        """Return the task at a place, without those before it."""
        point, rest = divmod(place, self.kind.each(self.fixed))
        point, drawn = divmod(point, self.count)
        values = {**self.fixed, **next(islice(self._drawn(), drawn, None))}
        for key, axis in reversed(list(self.grid.items())):
            point, k = divmod(point, len(axis))
            values[key] = axis[k]
        return next(islice(self.kind.tasks(values, self.seed), rest, None))

    def _drawn(self) -> Iterator[dict[str, float]]:
        """Yield points of the sample; a single one without axes where there is none."""
        if not self.sample:
            yield {}
            return
        generator = np.random.default_rng(self.seed)
        shift = generator.random(len(self.sample))
        for k in range(self.count):
            if self.draw == "halton":
                unit = [
                    (_radical_inverse(k + 1, prime) + float(x)) % 1.0
                    for prime, x in zip(_PRIMES, shift, strict=False)
                ]
            else:
                unit = [float(x) for x in generator.random(len(self.sample))]
            yield {
                key: between(*bounds, u)
                for (key, bounds), u in zip(self.sample.items(), unit, strict=True)
            }


_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)


def _radical_inverse(number: int, base: int) -> float:
    """Return digits of a number behind the point, in reverse (Halton 1960)."""
    result, digit = 0.0, 1.0 / base
    while number:
        number, rest = divmod(number, base)
        result += rest * digit
        digit /= base
    return result


# --- reading --------------------------------------------------------------------------------------


def campaign_names() -> list[str]:
    """Return names of the shipped campaigns, sorted."""
    return tables_of("campaign")


def is_campaign(name: str) -> bool:
    """Return whether a name is that of a shipped campaign or of a file that says it is one."""
    if name in campaign_names():
        return True
    path = Path(name)
    if path.suffix != ".toml" or not path.is_file():
        return False
    try:
        return _CampaignReader(path).document.get("format") == FORMAT
    except GlmrefError:
        return False  # what is wrong with it is said where it is read as a scene


def load_campaign(name: str) -> Campaign:
    """Load a campaign by name or path.

    Raises
    ------
    UsageError
        For an unknown name or a missing file.
    DataError
        For a file that is not a campaign; the sentence names the line.
    """
    return _CampaignReader(table_path("campaign", name)).campaign()


class _CampaignReader(Reader):
    """Reads one file; every complaint names its line."""

    def campaign(self) -> Campaign:
        """Check everything and return the campaign."""
        given = self.document
        self.known((), given, _KEYS)
        for key in _TEXTS:
            self.text((key,), given.get(key))
        self.choice(("format",), given["format"], (FORMAT,))
        if not given["name"].replace("-", "").isalnum() or len(given["name"]) > MAX_NAME:
            raise self.fail(("name",), "`name` must be letters, digits and hyphens")
        kind = CAMPAIGN_KINDS[self.choice(("kind",), given.get("kind"), tuple(CAMPAIGN_KINDS))]
        grid, sample = self._table("grid"), self._table("sample")
        seed = self.whole(("seed",), given.get("seed", 1), 2**63 - 1)
        budget = given.get("budget")
        count, draw = sample.pop("count", None), sample.pop("draw", "halton")
        if len(sample) > len(_PRIMES):
            raise self.fail(("sample",), f"`sample` has more than {len(_PRIMES)} axes; fix some")
        campaign = Campaign(
            **{key: given[key] for key in ("name", "title", "question")},
            kind=kind,
            fixed={k: self._named(("fixed", k), x) for k, x in self._table("fixed").items()},
            grid={key: self._axis(("grid", key), x) for key, x in grid.items()},
            sample={key: self.range_of(("sample", key), x) for key, x in sample.items()},
            count=self.whole(("sample", "count"), count, MOST) if sample else 1,
            draw=self.choice(("sample", "draw"), draw, _DRAWS),
            seed=seed,
            budget=math.inf if budget is None else self.number(("budget",), budget),
            limits=self._limits(kind.timed(self._table("fixed"))),
            picture=self._picture(),
        )
        self._complete(campaign)
        return campaign

    def _table(self, key: str) -> dict[str, Any]:
        table = self.document.get(key, {})
        if not isinstance(table, dict):
            raise self.must((key,), "a table", table)
        return dict(table)

    def _complete(self, campaign: Campaign) -> None:
        """Refuse axes that the kind does not know, or that it lacks or has twice."""
        kind, tables = campaign.kind, ("fixed", "grid", "sample")
        seen: set[str] = set()
        for key in kind.in_fixed:
            if key in campaign.grid or key in campaign.sample:
                raise self.fail(("grid", key), f"`{key}` belongs in [fixed]")
        for table in tables:
            axes = getattr(campaign, table)
            self.known((table,), axes, (*kind.needed, *kind.optional))
            for key in axes:
                if key in seen:
                    raise self.fail((table, key), f"`{key}` is given twice; delete one")
                seen.add(key)
        for key in kind.needed:
            if key not in seen:
                raise self.fail(
                    ("grid",), f"a campaign of the kind {kind.name!r} needs `{key}` in [grid], "
                    f"[sample] or [fixed]",
                )  # fmt: skip
        try:
            first = campaign.spread(1)
        except (DataError, UsageError) as error:
            raise self.fail(("fixed",), str(error)[:500]) from None
        except (TypeError, ValueError, KeyError, AttributeError) as error:
            raise self.fail(
                ("fixed",),
                f"no task can be made of these values ({type(error).__name__}: {error!s:.300})",
            ) from None
        if not first:
            raise self.fail(("grid",), "the axes give no task")

    def _axis(self, where: tuple[str, ...], value: Any) -> tuple[Any, ...]:
        """Return values of an axis: a list, a range, or the methods with a property."""
        key = where[-1]
        if isinstance(value, dict) and "having" in value:
            return self._methods(where, value["having"])
        if value == "all" and key in ("method", "problem"):
            return tuple(method_names("methods") if key == "method" else problem_names())
        if isinstance(value, dict):
            return self.spread(where, value, MOST)
        values = tuple(self.items(where, value))
        for item in values:
            if not isinstance(item, str | int | float):
                raise self.fail(where, f"`{'.'.join(where)}` must hold texts and numbers")
        return tuple(self._named(where, item) for item in values)

    def _named(self, where: tuple[str, ...], value: Any) -> Any:
        """Return a value; of a method or a problem the name of a shipped one, or a method file."""
        if where[-1] == "method" and isinstance(value, str) and value.endswith(".json"):
            return self.method_file(where, value)
        if where[-1] in ("method", "problem"):
            known = method_names("methods") if where[-1] == "method" else problem_names()
            self.choice(where, value, known)
        return value

    def _methods(self, where: tuple[str, ...], kinds: Any) -> tuple[str, ...]:
        """Return shipped methods of a class or with a property, or with all of several."""
        asked = [kinds] if isinstance(kinds, str) else list(self.items(where, kinds))
        every = [self.having(where, kind) for kind in asked]
        found = tuple(x for x in method_names("methods") if all(x in names for names in every))
        if not found:
            raise self.fail(where, f"no method is {' and '.join(asked)}")
        return found

    def _limits(self, timed: bool) -> Limits:
        table = self._table("limits")
        self.known(("limits",), table, ("seconds", "memory", "retries"))
        memory = table.get("memory")
        retries = table.get("retries", 2)
        if retries != 0:
            retries = self.whole(("limits", "retries"), retries, 100)
        return Limits(
            seconds=self.number(("limits", "seconds"), table.get("seconds", 3600)),
            memory=None if memory is None else int(self.number(("limits", "memory"), memory)),
            retries=retries,
            pinned=timed,
        )

    def _picture(self) -> Picture | None:
        table = self._table("report")
        if not table:
            return None
        self.known(("report",), table, ("picture", *list(Picture.__dataclass_fields__)[1:]))
        kind = self.choice(("report", "picture"), table.get("picture"), ("map", "front"))
        needed = ("across", "up", "value") if kind == "map" else ("across", "up")
        for key in needed:
            self.text(("report", key), table.get(key))
        self.choice(("report", "reduce"), table.get("reduce", "max"), REDUCE)
        return Picture(kind, **{k: v for k, v in table.items() if k != "picture"})
