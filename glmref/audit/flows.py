"""Splittings written as flows one after another: ``drift(c1*h); kick(d1*h)``, ``q += c1*h*p``.

A call whose argument is a multiple of the step, or such a sum added to a name, moves one flow on.
Two flows in turn whose multiples have the same sum n are n steps of a splitting. Nothing is run;
multiples with other names in them, and branches between flows, are said to be unread.
"""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations, groupby

from ..exact import Exact
from .collecting import Block, Collector, _equal, _partner
from .lexer import Token
from .steps import ACCIDENTS, BRANCHES, Form, Names, calls, form
from .table import ZERO, Table, as_composition, of_weights
from .values import Number, Unread

#: Names of a step.
_STEP = re.compile(
    r"(?:.*[._])?(?:\w{0,9}_?d_?(?:t|tau|s|l)\w{0,4}|h|hh|h0|dh|eps(?:ilon)?|\w*step\w*|tau|length|"
    r"l|delta\w*|d[xz])(?:\(\)|\[\])?",
    re.IGNORECASE,
)
#: How far apart the sums of both flows may be, as a part of one, for a defect; for a method.
_APART, _SAME = 0.05, 1e-9
#: How far from 1 and 0 the sums of weights and of their cubes may be, where these are found.
_LOOSE = 4e-3
#: Most names of flows in one function.
_MOST = 12
#: Multiples of Störmer's method and of Euler's, which are no numbers of a method.
_PLAIN = frozenset((0.0, 0.25, 0.5, 1.0, 2.0))
#: Names of symmetric methods of order 2.
_SECOND = re.compile(r"verlet|leap.?frog|strang|st(?:ö|oe)rmer|s2(?!\d)", re.IGNORECASE)
_NAMES = "the coefficients of a splitting have names that are not read"


@dataclass(frozen=True)
class Moved:
    """One flow moved on: its name, the numbers by which it may be, and where."""

    flow: str
    by: list[Number | None]
    line: int
    text: str

    @property
    def called(self) -> bool:
        """Whether it is a call."""
        return self.flow.endswith("()")


@dataclass
class _Moves(Names):
    """A function carried out for the flows that it moves on."""

    moved: list[Moved] = field(default_factory=list)

    def take(self, row: list[Token]) -> None:
        """Carry out a statement; ``q, p = kick(q, p, h)`` moves a flow on."""
        equal = _equal(row)
        if equal is not None and row[equal].text == "=":
            given, said = row[equal + 1 :], {x.text for x in row[:equal]}
            made = next((x for x in calls(given) if not x.valued), None)
            whole = made is not None and _partner(given, made.at + 1) == len(given) - 1
            if made and whole and any(len(x) == 1 and x[0].text in said for x in made.arguments):
                self._end(given)
                return
        super().take(row)

    def _end(self, row: Sequence[Token]) -> None:
        made = calls(row)
        if len(made) != 1 or made[0].valued or "axpy" in made[0].name:  # it adds to any vector
            return
        by: list[Number | None] = []
        for part in made[0].arguments:
            try:
                x = self.fold(part)
            except (Unread, *ACCIDENTS):
                x = None
            by.append(x if isinstance(x, Number) else None)
        self._note(f"{made[0].name}()", by, row)

    def _note(self, flow: str, by: list[Number | None], row: Sequence[Token]) -> None:
        said = " ".join(y.text for y in row)[:80]
        self.moved.append(Moved(flow, by, row[0].line, said))

    def _set(self, name: str, row: Sequence[Token], sign: str) -> None:
        if sign in ("+=", "-=", "=") and not isinstance(self.values.get(name), Number):
            try:
                x = self.fold(row)
                own = form(x).terms.get((name,))
                if own == 1 or sign != "=":
                    less = Form({(name,): Exact(1)}) if sign == "=" else Form({})
                    value = form(x) - less
                    x = x.of(-value if sign == "-=" else value)  # type: ignore[arg-type]
                    if value.terms and all(len(key) > 1 for key in value.terms):
                        self._note(name, [x], row)
                    return
            except (Unread, *ACCIDENTS):
                pass
        super()._set(name, row, sign)


def _multiples(moves: Sequence[Moved]) -> dict[str, list[Number]]:
    """Return the multiples of each name of a step by which all moves of one flow are."""
    found: dict[str, list[Number]] = {}
    for k in range(min(len(x.by) for x in moves)):
        column = [x.by[k] for x in moves]
        given = [x for x in column if x is not None and form(x).terms]
        if len(given) < len(column):
            continue
        keys = [set(key) for x in given for key in form(x).terms]
        for name in set.intersection(*keys):
            made = [x.of(_without(form(x), name)) for x in given]  # type: ignore[arg-type]
            more = name not in found or _values(made) > _values(found[name])
            if more and _STEP.fullmatch(name):
                found[name] = made
    return found


def _values(given: Sequence[Number]) -> int:
    return len({str(sorted(map(str, form(x).terms.items()))) for x in given})


def _without(x: Form, name: str) -> Form:
    made: dict[tuple[str, ...], Exact] = {}
    for key, v in x.terms.items():
        rest = list(key)
        rest.remove(name)
        made[tuple(rest)] = v
    return Form(made)


def _first_components(moves: list[Moved]) -> list[Moved]:
    """Leave out updates of further components: ``y += c*h*py`` after ``x += c*h*px``."""
    kept: list[Moved] = []
    further: set[str] = set()
    for x in moves:
        before = kept[-1] if kept else None
        if before is not None and not x.called and not before.called and x.flow != before.flow:
            p, q = form(x.by[0]).terms, form(before.by[0]).terms
            names = [{y for key in z for y in key} for z in (p, q)]
            same = sorted(map(str, p.values())) == sorted(map(str, q.values()))
            if same and x.flow not in names[1] and before.flow not in names[0]:
                further.add(x.flow)
        if x.flow not in further:
            kept.append(x)
    return kept


def _pairs(moves: list[Moved]) -> Iterator[tuple[list[Moved], list[Number]]]:
    """Yield the moves of two flows in turn and their multiples of one step."""
    given: dict[str, dict[str, list[Number]]] = {}
    for flow in sorted({x.flow for x in moves}):
        multiples = _multiples([x for x in moves if x.flow == flow])
        if multiples:
            given[flow] = multiples
    mine = given if len(given) <= _MOST else {}
    for p, q in combinations(sorted(mine), 2):
        both = [x for x in moves if x.flow in (p, q)]
        for name in sorted(given[p].keys() & given[q].keys()):
            at = {flow: iter(given[flow][name]) for flow in (p, q)}
            values = [next(at[x.flow]) for x in both]
            if len(list(groupby(x.flow for x in both))) > 2:
                yield both, values
                break


def _composed(moves: list[Moved]) -> Iterator[Table]:
    """Yield weights by which one flow alone moves on, a symmetric method of order 2 composed.

    The sum of the cubes says so: it is not 0 where the flow has a higher order.
    """
    for flow in sorted({x.flow for x in moves}):
        mine = [x for x in moves if x.flow == flow and x.called]
        for values in _multiples(mine).values() if len(mine) > 2 else ():
            forms = [form(x).terms for x in values]
            if any(x.keys() - {()} for x in forms):
                continue
            made = [x.of(y.get((), Exact(0))) for x, y in zip(values, forms, strict=True)]
            for x, move in zip(made, mine, strict=True):
                x.place = (move.line, move.text)
            sizes = [complex(x.value).real for x in made]
            gaps = abs(sum(sizes) - 1), abs(sum(x**3 for x in sizes))
            even = max(abs(x - y) for x, y in zip(sizes, sizes[::-1], strict=True)) < _SAME
            known = even and gaps[0] < _SAME and gaps[1] < 0.9 and _SECOND.search(flow) is not None
            if (max(gaps) < _LOOSE or known) and min(sizes) < 0:
                table = of_weights("", mine[0].line, made)
                table.general, table.sure, table.last = True, gaps[1] > _LOOSE, mine[-1].line
                yield table


def flows_of(block: Block, row: Sequence[Token], collector: Collector) -> Iterator[Table]:
    """Yield the splittings that a function of flat tokens carries out, unread if not understood."""
    if sum(x.kind == "name" and _STEP.fullmatch(x.text) is not None for x in row) < 3:
        return
    found = _flows_in(block, row, collector)
    if all(x.unread for x in found):
        found = next((y for x in _chosen(row) if (y := _flows_in(block, x, collector))
                      and not all(z.unread for z in y)), found)  # fmt: skip
    for table in found:
        table.name = block.own or block.name
        yield table


def _chosen(row: Sequence[Token]) -> Iterator[list[Token]]:
    """Yield the tokens of one step where a choice at its end says whether another one follows.

    ``if (k < n) kick(2*h) else kick(h)``: the same part of each choice is taken.
    """
    row = [x for x in row if x.kind != "line"] if any(x.text == "{" for x in row) else list(row)
    for last in (True, False):
        made: list[Token] = []
        k = several = 0
        while k < len(row):
            if row[k].text == "if" and [x.text for x in row[k + 1 : k + 2]] == ["("]:
                first = _partner(row, k + 1) + 1
                middle = _partner(row, first) if first < len(row) and row[first].text == "{" else 0
                words = [x.text for x in row[middle + 1 : middle + 3]]
                if middle and words == ["else", "{"]:
                    end = _partner(row, middle + 2)
                    made += row[middle + 3 : end] if last else row[first + 1 : middle]
                    k, several = end + 1, several + 1
                    continue
            made.append(row[k])
            k += 1
        if several:
            yield made


def _flows_in(block: Block, row: Sequence[Token], collector: Collector) -> list[Table]:
    """Return the splittings of flat tokens, those that are unread with the reason."""
    step = _Moves(block, collector, "", 0, -1, set())
    step.follow(row)
    moves = _first_components(step.moved)
    branches = sorted({x.line for x in row if x.text in BRANCHES or x.text == "if"})
    parts = [list(x) for _, x in groupby(moves, lambda x: bisect(branches, x.line))]
    found = [made for x in parts for pair in _pairs(x) if (made := _table(*pair)) is not None]
    found = found or list(_composed(moves))
    if len(parts) > 1 and all(x.unread for x in found):
        whole = [made for pair in _pairs(moves) if (made := _table(*pair)) is not None]
        found = (whole or found)[:1]
        for x in found:
            if not x.unread.startswith(_NAMES):
                x.unread = "a splitting with a branch between its flows"
    elif len(parts) > 1:
        found = [x for x in found if not x.unread]
    return found


def _table(moves: list[Moved], values: list[Number]) -> Table | None:
    """Return the splitting of two flows in turn; ``None`` where no numbers stand there."""
    kinds = {flow: {key for x, y in zip(moves, values, strict=True) if x.flow == flow
                    for key in form(y).terms} for flow in {x.flow for x in moves}}  # fmt: skip
    table = Table("", moves[0].line, "splitting", general=True, sure=False, last=moves[-1].line)
    names = sorted({" ".join(key) for flow, keys in kinds.items() for key in keys
                    if len(keys) > 1 or flow.endswith("()")} - {""})  # fmt: skip
    if names:
        table.unread = f"{_NAMES}: {', '.join(names[:3])}"
        return table if len(moves) > 3 else None
    rows: dict[str, list[Number]] = {}
    for flow, group in groupby(zip(moves, values, strict=True), lambda x: x[0].flow):
        given = list(group)
        number = given[0][1]
        total = sum((sum(form(y).terms.values(), Exact(0)) for _, y in given), Exact(0))
        made = number.of(total, min((y for _, y in given), key=lambda y: y.places or 99))
        made.place = (given[0][0].line, given[0][0].text)
        rows.setdefault(flow, []).append(made)
    if all(abs(complex(x.value).real) in _PLAIN for row in rows.values() for x in row):
        return None
    sums = [sum((x.value for x in row), Exact(0)) for row in rows.values()]
    signs = [-1 if complex(x).real < 0 else 1 for x in sums]  # p -= h*grad is the flow of -grad
    sums = [x * k for x, k in zip(sums, signs, strict=True)]
    p, q = (complex(x).real for x in sums)
    apart = abs(p - q) / max(abs(p), abs(q), 1e-300)
    if (apart > _APART or abs(p) < _APART) and sum(map(len, rows.values())) < 5:
        return None
    n = round(p) if round(p) and abs(p / round(p) - 1) < _APART else 0
    n = n or sums[0]
    if apart > _SAME or abs(p) < _APART:
        table.unread = f"two flows in turn, whose multiples sum to {p:.12g} and {q:.12g}"
        return table
    size = max(map(len, rows.values()))
    for row, sign in zip(rows.values(), signs, strict=True):
        made = [x.of(x.value / (n * sign)) for x in row]
        for x, y in zip(made, row, strict=True):
            x.place = y.place
        table.b.append([*made, *([ZERO] * (size - len(made)))])
    first, second = (x[: len(row)] for x, row in zip(table.b, rows.values(), strict=True))
    composed = as_composition(first, second) or as_composition(second, first)
    if composed is not None:
        table.kind, table.b = composed.kind, composed.b
    return table
