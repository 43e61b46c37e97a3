"""Numbers of known methods, wherever they stand in a source and in whatever form.

Numbers like 845/4104 or 0.4358665215 stand in one method of the literature and hardly anywhere
else. A source that holds most numbers of a method holds the method, even where its layout is not
read: then it is said to be unread. A number that is one slip of the pen (:func:`_slip`) away from
the only ones that are missing is asked about.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from typing import Any

from ..catalogue.lookup import document, load, names
from ..exact import Ball, Exact, Scalar, linalg
from ..exact.expression import parse
from .entries import OF_FLOWS, of_subject
from .lexer import Language, Token, tokens
from .table import Table
from .values import Numeral, spelled

#: Classes of methods whose numbers codes write down.
_CLASSES = frozenset({"additive", "nystrom", "rk", "rosenbrock", "splitting"})
#: Digits of numerator and denominator together, and of a decimal, that say of which method it is:
#: by chance a file of 10,000 numerals has a decimal of 8 digits once in 10,000.
_SHORT, _LONG = 5, 8
#: Where a word of the subject is, numbers say so together: digits of all those with three or more,
#: and lines for each of them.
_TOGETHER, _LINES = 12, 6
#: Numbers of a method that a source must hold, and the part of those of A and b.
_FEW, _MOST = 4, 0.7
#: Digits together of the numbers of a splitting that a source must hold, two at least: codes
#: compute the others, as 1 - 2 (xi + chi).
_DECIDES = 18
#: Lines from a splitting to a word of flows.
_ABOUT = 40
#: Numbers of a method whose signs agree, where another is asked about because of its sign.
_SIGNS = 6
#: Tokens between numerator and denominator, as in ``F::from(49.0) / F::from(176.0)``.
_BETWEEN = 6
_OVER = frozenset(("/", "//"))
_OPEN, _CLOSE = frozenset(",[{"), frozenset(",]}")
#: Powers of ten and digits of numbers that are looked at; digits of those that do not end.
_POWER, _MOST_DIGITS, _KNOWN = 60, 80, 100
#: Of a decimal, what roundings of the numbers that it was computed from change less.
_ROUNDED = 10**12
#: Lines before the first and after the last number of a method that may belong to it.
_BESIDE = 6
#: Numerals of a text in any language, and the digits of a decimal that are compared.
_WHOLE, _DECIMAL, _PREFIX = re.compile(r"\d+"), re.compile(r"\d*\.\d(?:_?\d){6,}"), 7
#: What a decimal has from its point on; few texts have it, and it is found fast.
_AFTER_POINT = re.compile(r"\.\d(?:_?\d){6}")


@dataclass(frozen=True)
class Constant:
    """A number of a method, without its sign."""

    value: Fraction
    slack: Fraction  #: How far the true number may be from it.
    method: str
    part: str  #: ``""`` of A and b, or the name of further weights.
    sign: int
    times: int  #: How many entries of the part it is.
    plain: bool = False  #: Whether it says of which method it is only together with the others.


@dataclass(frozen=True)
class Figure:
    """A number of a source, or the quotient of two that follow each other."""

    tokens: tuple[Token, ...]  #: One, or numerator and denominator.
    parts: tuple[Numeral, ...]  #: As they are written.
    sign: int
    #: Where no factor nor call has its sign: ``"["`` in a list, or the name that is given it.
    place: str
    value: Fraction = field(init=False)
    unit: Fraction = field(init=False)  #: Of its last digit, 0 of a quotient.

    def __post_init__(self) -> None:
        top, *bottom = self.parts
        value = top.value / bottom[0].value if bottom else top.value
        object.__setattr__(self, "value", value)
        object.__setattr__(self, "unit", top.unit if top.after and not bottom else Fraction(0))

    @property
    def text(self) -> str:
        """Return the number as it stands in the source."""
        return "/".join(x.text for x in self.tokens)

    @property
    def line(self) -> int:
        """Return the line on which it begins."""
        return self.tokens[0].line

    @property
    def tells(self) -> bool:
        """Return whether it has the digits to say of which method it is."""
        digits = sum(len(x.digits) for x in self.parts)
        return digits >= (_LONG if len(self.parts) == 1 else _SHORT)


@dataclass(frozen=True)
class Known:
    """What a source holds of a known method.

    Attributes
    ----------
    method : str
    first, last : int
        Lines of the numbers.
    held, of : int
        How many different numbers the source holds, and how many the method has: those of A and b,
        and of further weights where most are held.
    slips : tuple of (Figure, str)
        Numbers of the source that should be others.
    values : frozenset of float
        What it holds.
    """

    method: str
    first: int
    last: int
    held: int
    of: int
    slips: tuple[tuple[Figure, str], ...]
    values: frozenset[float]


def may_hold_known(text: str) -> bool:
    """Return whether a text has the digits of a few numbers of known methods."""
    fractions, long, prefixes, plain = _written()
    given = _DECIMAL.findall(text) if _AFTER_POINT.search(text) else ()
    decimals = {re.sub(r"[._]", "", x).lstrip("0")[:_PREFIX] for x in given}
    found = len(prefixes & decimals)
    if found >= _FEW or len(_prefixes_of_flows() & decimals) > 1:
        return True
    whole = _WHOLE.findall(text)
    some = {*whole}  # a pair that is not there has two of them
    about = any(len(words - some) < 3 for words, _ in plain) and of_subject(text)
    if found + len(long & some) < _FEW and not about:
        return False
    near = {pair for k in range(1, 6) for pair in zip(whole, whole[k:], strict=False)}
    if about and any(len(x - near) < 2 for _, x in plain):
        return True
    return found + len(fractions & near) >= _FEW


def known(text: str, language: Language, *, fixed: bool = False) -> list[Known]:
    """Return the methods of the catalogue most of whose numbers a source holds.

    Parameters
    ----------
    text : str
        The source.
    language : Language
        That tells comments from numbers.
    fixed : bool
        Whether it is Fortran in fixed form.
    """
    found = list(_numerals(tokens(text, language, fixed=fixed)[0]))
    hits: dict[Constant, list[Figure]] = defaultdict(list)
    about = of_subject(text)
    for x in found:
        for constant in _equal(x):
            if about or not constant.plain:
                hits[constant].append(x)
    methods: dict[str, set[Constant]] = defaultdict(set)
    for constant in hits:
        methods[constant.method].add(constant)
    explained: set[float] = set()
    rows: list[Known] = []
    for name in sorted(methods, key=lambda x: (-len(methods[x]), x)):
        core, every = _core(methods[name]), _core(_constants()[name])
        fresh = {float(x.value) for x in methods[name]} - explained
        if name in _flows():
            if len(fresh) < 2 or _digits(core, hits) < _DECIDES:
                continue
        elif len(core) < max(_FEW, _MOST * len(every)) or len(fresh) < _FEW:
            continue
        if any(x.plain for x in core) and not _together([hits[x] for x in core], len(every)):
            continue
        rows.append(_row(name, {x: hits[x] for x in methods[name]}, found, hits))
        explained |= rows[-1].values
    return rows


def _digits(core: Iterable[Constant], hits: Mapping[Constant, Sequence[Figure]]) -> int:
    """Return how many digits the numbers of a method have in a source, of each at most 15."""
    longest = (max(len(y.parts[0].digits) for y in hits[x]) for x in core)
    return sum(min(15, n) for n in longest)


def _together(hits: Sequence[Sequence[Figure]], of: int) -> bool:
    """Return whether all numbers of a method but one stand near one another."""
    lines = sorted((x.line, k) for k, numerals in enumerate(hits) for x in numerals)
    starts = (line for line, _ in lines)
    near = ({k for n, k in lines if 0 <= n - line <= _LINES * of} for line in starts)
    return any(len(x) >= of - 1 for x in near)


def records(
    text: str, language: Language, tables: Sequence[Table], *, fixed: bool = False
) -> Iterator[dict[str, Any]]:
    """Yield records of known methods that no table of a source explains, and of their slips.

    Parameters
    ----------
    text : str
        The source.
    language : Language
    tables : Sequence of Table
        What was recognised in it, read or not.
    fixed : bool
        Whether it is Fortran in fixed form.

    Yields
    ------
    dict
        A record with the status ``unread``, or ``question`` where a number should be another, which
        has the keys of :func:`~.table_verdicts.judge`.
    """
    read = {
        round(abs(complex(x.value)), 9)
        for table in tables if not table.unread
        for M in (*table.A, table.b, table.errors, [row for _, row, _ in table.rows])
        for row in M for x in row
    }  # fmt: skip
    lines = [(x.line, max(x.line, x.last)) for x in tables if x.unread]
    for one in known(text, language, fixed=fixed):
        held = f"{one.held} of {one.of} distinctive numbers of {one.method}"
        row = {"line": one.first, "name": one.method, "remarks": []}
        if one.slips:
            said = f"the source holds {held}, and in place of another this"
            correction = [
                {"entry": f"the number {x.text}", "is": x.text, "should be": new, "line": x.line,
                 "text": x.tokens[0].text}
                for x, new in one.slips
            ]  # fmt: skip
            yield row | {"status": "question", "remarks": [said], "correction": correction}
            continue
        forms = (one.values, *(() if one.method in _flows() else _forms(one.method)))
        explained = any(2 * sum(round(x, 9) in read for x in form) >= len(form) > 0
                        for form in forms)  # fmt: skip
        near = "\n".join(text.splitlines()[max(0, one.first - _ABOUT) : one.first + _ABOUT])
        said = f"lines {one.first} to {one.last} hold {held}, in a form that is not read"
        if one.method in _flows():
            explained = explained or not OF_FLOWS.search(near)
            said = f"numbers of {one.method} stand here; how they are used is not read"
        if not (explained or any(a <= one.last and one.first <= b for a, b in lines)):
            yield row | {"status": "unread", "remarks": [said]}


# --- numbers of methods ---------------------------------------------------------------------------


def _core(given: Iterable[Constant]) -> set[Constant]:
    return {x for x in given if not x.part}


@cache
def _flows() -> frozenset[str]:
    """Return the names of the splittings, of which codes write a few numbers and compute others."""
    return frozenset(x for x in names() if document(x)["class"] == "splitting")


@cache
def _numbers() -> dict[str, list[tuple[str, Fraction, Fraction]]]:
    """Return the entries of each form of a method: part, value, how far it may be off."""
    made: dict[str, list[tuple[str, Fraction, Fraction]]] = defaultdict(list)
    for name in names():
        given = document(name)
        if given["class"] in _CLASSES:
            for form, part, x in (*_entries(load(name)), *_written_as(given)):
                made[name + form].append((part, *_fraction(x)))
    return made


def _written_as(given: Mapping[str, Any]) -> Iterator[tuple[str, str, Exact | Ball]]:
    """Yield the constants from which the entries of a method are, as those of few registers."""
    values: dict[str, Scalar] = {}
    for name, text in given.get("constants", {}).items() if "digits" not in given else ():
        values[name] = parse(text, constants=values)
        yield ", in the form of its source", "", values[name]


def _forms(name: str) -> Iterator[set[float]]:
    """Yield the numbers of A and b in each form of the method that a name is of."""
    own = name.partition(",")[0]
    for other, rows in _constants().items():
        if other.partition(",")[0] == own:
            yield {float(x.value) for x in _core(rows)}


@cache
def _entered() -> frozenset[float]:
    """Return all entries of known methods, rounded."""
    return frozenset(round(abs(float(x)), 12) for rows in _numbers().values() for _, x, _ in rows)


@cache
def _constants() -> dict[str, set[Constant]]:
    """Return the numbers of each method that say of which method they are."""
    made: dict[str, set[Constant]] = {}
    for name, rows in _numbers().items():
        signs: dict[tuple[str, Fraction], tuple[Fraction, int, int]] = {}
        plain = _plain(rows)
        for part, value, slack in rows:
            if abs(value) in plain if plain else _tells(value):
                key, sign = (part, abs(value)), 1 if value > 0 else -1
                _, before, times = signs.get(key, (slack, sign, 0))
                signs[key] = slack, sign if sign == before else 0, times + 1
        if signs:
            made[name] = {
                Constant(value, slack, name, part, sign, times, bool(plain))
                for (part, value), (slack, sign, times) in signs.items()
            }
    return made


def _entries(method: Any) -> Iterator[tuple[str, str, Exact | Ball]]:
    """Yield the entries of each form in which a method is written, with the part they are of."""
    many = len(method.components) > 1
    for k, component in enumerate(method.components, 1):
        form = f", part {k}" if many else ""
        flows = method.name in _flows()
        yield from ((form, "nodes", sum(row, Exact(0))) for row in component.A if not flows)
        rows = component.B if flows else (*component.A, *component.B)
        yield from (("" if flows else form, "", x) for row in rows for x in row)
        for row in method.embedded:
            own = row.weights[k - 1]
            other = [x - y for x, y in zip(component.B[0], own, strict=True)]
            yield from ((form, row.name, x) for x in own)
            yield from ((form, f"error of {row.name}", x) for x in other)
    for row in getattr(method, "dense", None) or ():
        yield from (("", "dense", x) for x in row)
    if method.rosenbrock:
        form, back, s = ", transformed", linalg.inverse(method.gamma), len(method.b)
        rows = [*linalg.matmul(method.alpha, back), *back, *linalg.matmul((method.b,), back)]
        yield from ((form, "", x) for row in rows for x in row)
        for row in method.embedded:
            other = tuple(x - y for x, y in zip(method.b, row.weights[0][:s], strict=True))
            yield from ((form, row.name, x) for x in linalg.matmul((other,), back)[0])


def _fraction(x: Exact | Ball) -> tuple[Fraction, Fraction]:
    """Return the real part of a number, and how far it may be off."""
    exact = x.as_fraction() if isinstance(x, Exact) else None
    if exact is not None:
        return exact, Fraction(0)
    ball = x.ball() if isinstance(x, Exact) else x
    value = Fraction(ball.decimal_text(_KNOWN))
    return value, Fraction(ball.radius()) + abs(value) / Fraction(10) ** (_KNOWN - 1)


def _plain(rows: Iterable[tuple[str, Fraction, Fraction]]) -> set[Fraction]:
    """Return all fractions of A and b where few of them say of which method they are.

    None where they have not the digits to say so together.
    """
    core = {abs(x) for part, x, _ in rows if not part}
    given = {x for x in core if 2 < x.denominator < 10**_SHORT and x.numerator < 10**_SHORT}
    few = sum(map(_tells, core)) < _FEW < len(given)
    digits = [len(f"{x.numerator}{x.denominator}") for x in given]
    return given if few and sum(x for x in digits if x > 2) >= _TOGETHER else set()


def _tells(x: Fraction) -> bool:
    """Return whether a number of a method is one that hardly any other has."""
    long = len(f"{abs(x.numerator)}{x.denominator}") >= _SHORT and x.denominator > 10
    simple = x.limit_denominator(1000)  # 0.3333333333333333148 is a third in double precision
    return long and (x == simple or abs(x - simple) > 1e-12)


@cache
def _sorted() -> tuple[list[float], list[Constant]]:
    every = sorted((x for rows in _constants().values() for x in rows), key=lambda x: x.value)
    return [float(x.value) for x in every], every


@cache
def _written() -> tuple[
    frozenset[tuple[str, str]], frozenset[str], frozenset[str],
    list[tuple[set[str], set[tuple[str, str]]]],
]:  # fmt: skip
    """Return numerators and denominators, the longer of both, and first digits of decimals.

    Those of methods whose numbers say so only together stand apart, by the method, after the words
    that they are made of.
    """
    values = {x.value for x in _sorted()[1] if not x.plain}
    fractions = {(str(x.numerator), str(x.denominator)) for x in values}
    plain = [{(str(x.value.numerator), str(x.value.denominator)) for x in _core(rows)}
             for rows in _constants().values() if any(x.plain for x in rows)]  # fmt: skip
    decimals = (f"{float(x):.{_PREFIX + 3}e}".replace(".", "") for x in values)
    long = frozenset(max(x, key=len) for x in fractions)
    words = [({y for pair in x for y in pair}, x) for x in plain]
    return frozenset(fractions), long, frozenset(x[:_PREFIX] for x in decimals), words


@cache
def _prefixes_of_flows() -> frozenset[str]:
    """Return the first digits of the numbers of splittings."""
    values = (float(x.value) for name in _flows() for x in _constants().get(name, ()))
    return frozenset(f"{x:.{_PREFIX + 3}e}".replace(".", "")[:_PREFIX] for x in values)


def _equal(x: Figure) -> Iterator[Constant]:
    """Yield the constants that a number of a source is, to its digits and theirs."""
    value = x.value
    if not x.tells and (len(x.parts) == 1 or value.denominator < 3):
        return
    near, every = _sorted()
    for k in range(bisect_left(near, float(value - x.unit) * (1 - 1e-9)), len(every)):
        constant = every[k]
        if near[k] > float(value + x.unit) * (1 + 1e-9):
            return
        rounding = value / _ROUNDED if len(x.tokens) == 1 else 0
        same = abs(constant.value - value) <= x.unit + constant.slack + rounding
        if same and (x.tells or constant.plain):
            yield constant


# --- numbers of a source --------------------------------------------------------------------------


def _short(text: str) -> Numeral | None:
    """Return a number as it is written, ``None`` where no method has one so long or so large."""
    x = Numeral.of(text)
    return x if x and len(x.before + x.after) < _MOST_DIGITS and abs(x.power) <= _POWER else None


_NOTHING = Numeral("", "0", "", "", 0)


def _numerals(row: Sequence[Token]) -> Iterator[Figure]:
    """Yield the numbers of a source, and quotients of two that follow each other."""
    places = [(k, y) for k, x in enumerate(row) if x.kind == "number" and (y := _short(x.text))]
    for (k, x), (other, y) in pairwise([*places, (len(row), _NOTHING)]):
        sign, before = _sign(row, k), _beside(row, k, -1)
        yield Figure((row[k],), (x,), sign, _place(row, k, k))
        between = [z.text for z in row[k + 1 : other]]
        last = _beside(row, other, 1)
        called = before == "(" and between == [","] and last == ")"
        if y.value and len(between) <= _BETWEEN and (called or _OVER & {*between}):
            place = "" if called or len(between) > 1 else _place(row, k, other)
            yield Figure((row[k], row[other]), (x, y), sign, place)


def _place(row: Sequence[Token], first: int, last: int) -> str:
    """Return :attr:`Figure.place` of the number that these tokens are."""
    if _beside(row, first, -1) in _OPEN and _beside(row, last, 1) in _CLOSE:
        return "["
    after = row[last + 1] if last + 1 < len(row) else None
    k = first - 1 - (first > 0 and row[first - 1].text == "-")
    whole = after is None or after.kind == "line" or after.text in (";", ",")
    if not (whole and k > 0 and row[k].text in ("=", ":=")):
        return ""
    k -= 1
    while k > 0 and (row[k].kind == "number" or row[k].text in "()[]"):  # an index
        k -= 1
    return row[k].text.rstrip("0123456789_") if row[k].kind == "name" else ""


def _beside(row: Sequence[Token], k: int, step: int) -> str:
    """Return the token before or after one, without a sign and ends of lines."""
    k += step
    while 0 <= k < len(row) and (row[k].kind == "line" or (step < 0 and row[k].text == "-")):
        k += step
    return row[k].text if 0 <= k < len(row) else ""


def _sign(row: Sequence[Token], k: int) -> int:
    """Return the sign before a token, 0 where it is that of a call around it, as ``-R(5)``."""
    if k and row[k - 1].text == "-":
        return -1
    while k and (row[k - 1].kind == "name" or row[k - 1].text in "(,."):
        k -= 1
    return 0 if k and row[k - 1].text == "-" else 1


# --- slips ----------------------------------------------------------------------------------------


def _row(
    name: str,
    held: dict[Constant, list[Figure]],
    found: Sequence[Figure],
    hits: Collection[Constant],
) -> Known:
    """Return what a source holds of one method, with what is one slip from what is missing."""
    lines = sorted(x.line for rows in held.values() for x in rows)
    first, last = lines[0], lines[-1]
    parts = Counter(x.part for x in held)
    every = _constants()[name]
    sizes = Counter(x.part for x in every)
    missing = [x for x in every - set(held) if parts[x.part] >= _MOST * sizes[x.part]
               or name in _flows()
               or (parts[x.part] >= 3 and sizes[x.part] - parts[x.part] == 1)]  # fmt: skip
    missing += _once_less(held)
    own = {id(y) for x in held.values() for numeral in x for y in numeral.tokens}
    free = [x for x in found if first - _BESIDE <= x.line <= last + _BESIDE
            and not own & {id(y) for y in x.tokens}]  # fmt: skip
    slips = []
    for constant in missing:
        for x in free:
            said = _slip(x, constant)
            if said and round(float(x.value), 12) not in _entered():
                slips.append((x, said))
    if len(slips) > 1 and any(x.plain for x in held):  # short fractions are near many others
        slips = []
    slips += _signs(held, found)
    counted = {x.value for x in every
               if name in _flows() or parts[x.part] >= _MOST * sizes[x.part]}  # fmt: skip
    values = {x.value for x in held}
    return Known(
        name, first, last, len(values & counted), len(counted), tuple(slips),
        frozenset(map(float, values)),
    )  # fmt: skip


def _signs(
    held: dict[Constant, list[Figure]], found: Sequence[Figure]
) -> Iterator[tuple[Figure, str]]:
    """Yield the only number of A and b in lists with another sign, where all the others agree.

    Beside it stands another number of the method. Names to which several numbers of the method are
    assigned are as good as lists.
    """
    both = Counter(x.value for x in held)
    places = Counter(y.place for numerals in held.values() for y in numerals if y.place)
    rows = [
        (x, [y for y in numerals if y.place == "[" or places[y.place] >= _FEW])
        for x, numerals in held.items()
        if not x.part and x.sign and both[x.value] == 1
    ]
    wrong = [(x, y) for x, numerals in rows for y in numerals if y.sign == -x.sign]
    right = sum({y.sign for y in numerals} == {x.sign} for x, numerals in rows)
    if right >= _SIGNS and len(wrong) == 1:
        x, y = wrong[0]
        starts = sorted({z.start for numeral in found for z in numeral.tokens})
        own = {z.start for rows in held.values() for numeral in rows for z in numeral.tokens}
        first, last = (starts.index(z.start) for z in (y.tokens[0], y.tokens[-1]))
        if own & {*starts[max(0, first - 1) : first], *starts[last + 1 : last + 2]}:
            yield y, f"-{y.text}" if x.sign < 0 else y.text


def _once_less(held: dict[Constant, list[Figure]]) -> list[Constant]:
    """Return the number of A and b that a source with copies of the method has once less."""
    counts = {x: len(y) for x, y in held.items() if not x.part and x.times == 1}
    usual, times = Counter(counts.values()).most_common(1)[0] if counts else (0, 0)
    less = [x for x, count in counts.items() if count < usual]
    alone = usual > 1 and times > _FEW and len(less) == 1 and counts[less[0]] == usual - 1
    return less if alone else []


def _slip(x: Figure, constant: Constant) -> str:
    """Return what a number should be that has one digit less, more or other, or two exchanged."""
    if len(x.parts) == 2:
        top, bottom = (y.value for y in x.parts)
        for k, other in ((1, top / constant.value), (0, constant.value * bottom)):
            whole = x.parts[k].digits
            if top and other.denominator == 1 and len(whole) > 1 and _near(whole, str(other)):
                said = [y.text for y in x.tokens]
                said[k] = spelled(said[k], other)
                return "/".join(said)
        return ""
    (one,) = x.parts
    whole = one.digits
    if len(whole) <= _LONG:  # as many are near each other by chance
        return ""
    off = abs(x.value - constant.value)
    moved = _point_moved(x.value, constant.value)
    if moved:
        return spelled(x.text, constant.value, constant.slack)
    whole_gap = abs(off - round(off)) <= x.unit + constant.slack  # as in 1 + a
    if not x.tells or whole_gap or off <= max(100 * x.unit, constant.value / _ROUNDED):
        return ""
    for k, up in product((0, 1, -1), (0, 1)):
        said = str(int(constant.value / one.unit * Fraction(10) ** k) + up)
        if len(said) == len(whole) + k and _near(whole[:-1], said[: len(whole) - 1 + k]):
            return spelled(x.text, constant.value, constant.slack)
    return ""


def _point_moved(x: Fraction, other: Fraction) -> bool:
    """Return whether numbers have the same digits, and the point at another place."""
    return any(abs(x / other * Fraction(10) ** k - 1) < Fraction(1, 10**_LONG)
               for k in (-2, -1, 1, 2)) if other else False  # fmt: skip


def _near(a: str, b: str) -> bool:
    """Return whether two texts differ by one character, or by two neighbours exchanged."""
    if a == b:
        return False
    if len(a) == len(b):
        places = [k for k, (x, y) in enumerate(zip(a, b, strict=True)) if x != y]
        i, j = places[0], places[-1]
        return i == j or (len(places) == 2 and j == i + 1 and (a[i], a[j]) == (b[j], b[i]))
    if abs(len(a) - len(b)) > 1:
        return False
    long, short = (a, b) if len(a) > len(b) else (b, a)
    return any(long[:k] + long[k + 1 :] == short for k in range(len(long)))
