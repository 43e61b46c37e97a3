"""Tables in any source, recognised by what they are.

A matrix is that of a method if its rows sum to given nodes, or if weights beside it satisfy order
conditions. Recognition is loose, so that a table with one wrong row is still one; the judge is
strict; and what a name forbids, numbers do not allow. See :mod:`.collecting` for what is read.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_left, bisect_right
from collections import Counter, deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import permutations, product
from math import isqrt
from typing import Any

from ..catalogue.keys import MAX_SIZE
from ..exact import Exact
from .collecting import CHOICES, Block, Collector
from .entries import LOOSE, NAMES, OF_FLOWS, Array, Words, arrays, of_subject, role_of
from .flows import flows_of
from .folding import Entries, flattened
from .inline import inline_sums, multiples
from .kinds import only_numbers, others
from .lexer import Language, Remark, Token
from .multistep import MULTISTEP, sums_of
from .readers import ORDINALS, by_name
from .steps import EULER, calls, flat, followed, functions, steps_of
from .table import STEP, ZERO, Rows, Table
from .values import Number, Unread, size, whole_number

#: Part of the rows whose sums must be the nodes.
MOST_ROWS = 0.6
_PLAIN = ("unge", "UNGE", "utcher", "UTCHER", "ableau", "osenbrock")
#: So many numerals stand so near one another where there is a table.
_NUMERALS, _WITHIN = 4, 600
#: A number with many digits, or a root of which weights of a composition are made.
_LONG = re.compile(r"\b\d?\.\d{6}|cbrt\s*\(|(?:\b[Pp]ow\b|\*\*|\^).{0,20}1\.?0*\s*/\s*[1-9]")
#: Two of the products in a sum of slopes, or whole numbers over a denominator.
_PRODUCTS = re.compile(
    r"[\[{(] ?-?\d+(?:\.0)?(?:, ?-?\d+(?:\.0)?){2}"
    r"|\d\.?\w* ?\* ?[A-Za-z][^;\n]{0,40}[-+] *\d[\w./]* ?\* ?[A-Za-z]"
)
_NUMERAL = re.compile(r"(?=[\d.b])(?:\d\.\d{2,}|\d[\w.)]*\s*//?\s*[\w.(]*\d|0?\.\d*[1-9]|big\")")
#: What follows a name that gets a list or an entry: ``[1][0] =``, ``= (``, ``: {``, ``<<``, ``{{``.
_GETS = (
    r"[\"']?(?:(?:\s*[\[(][^\n=;]{0,40}[\])])+\s*:?=(?!=)"
    r"|\s*(?::=|=(?!=)|:|<<)\s*[\w.:<>&\s]{0,60}[\[({]|\s*<<|\s*[({\[]\s*[\[({\-\d.])"
)
_FRACTION = r"(?:\d\.\d*[1-9]|\d\.?0?\s*//?\s*[\w.(]*\d|(?<!\d)\.\d*[1-9])"
#: A matrix or an argument of this name with a fraction in it, not an article.
_MATRIX = re.compile(rf"(?<![\w.\\])[Aa]\b{_GETS}[^;]{{0,300}}?{_FRACTION}")
#: Weights and nodes, by any of their names, with a number; one of both has a fraction.
_VECTORS, _BROKEN = (
    [
        re.compile(rf"(?<![^\W_])(?i:k?(?:{'|'.join(NAMES[x])}))(?:_?\d+|_\w+)?\b{_GETS}{number}")
        for x in "bc"
    ]
    for number in (r"[^;]{0,40}?\d", rf"[^;]{{0,60}}?{_FRACTION}")
)
#: So far from its matrix weights and nodes may begin, before and after it.
_BEFORE, _AFTER = 3000, 4500


def _named_places(text: str) -> Iterator[tuple[int, int]]:
    """Yield where a matrix A has weights and nodes beside it, by their names.

    In a file without a word of the subject nothing else says what a matrix is (:func:`_says`).
    """
    last = 0
    for matrix in _MATRIX.finditer(text):
        at = matrix.start()
        if at >= last:
            last = at + _AFTER // 3  # what stands beside the next one stands mostly beside this one
            first, end = max(0, at - _BEFORE), at + _AFTER
            near = text[first:end]
            named = all(vector.search(near) for vector in _VECTORS)
            if named and any(vector.search(near) for vector in _BROKEN):
                yield first, end


def _numerals(text: str) -> bool:
    """Return whether numerals stand so near one another as in a table."""
    last: deque[int] = deque(maxlen=_NUMERALS)
    for numeral in _NUMERAL.finditer(text):
        last.append(numeral.start())
        if len(last) == _NUMERALS and last[-1] - last[0] < _WITHIN:
            return True
    return False


def may_hold(text: str, where: str = "") -> bool:
    """Return whether a text has the numerals and the words of a file with tables.

    What is cheap to look for, and most files lack, is looked for first: no text is split into
    tokens that could hold no table.
    """
    if any(x in text for x in _PLAIN):
        return True
    if _numerals(text) and (of_subject(text) or of_subject(where) or any(_named_places(text))):
        return True
    if _PRODUCTS.search(text) and (
        _STRONG.search(text) or _STRONG.search(where) or (
            MULTISTEP.search(text) and of_subject(text))):  # fmt: skip
        return True
    return OF_FLOWS.search(text) and _LONG.search(text) is not None


# --- readings -------------------------------------------------------------------------------------


@dataclass
class Reading:
    """A matrix (s, s) as an array may be meant, with nodes and weights that stand in it."""

    A: Rows
    c: list[Any] | None = None
    b: list[Any] | None = None
    cost: int = 0  #: How unusual it is.
    order: int | None = None  #: In the corner of c, A and b.
    sums: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.sums = [sum(map(size, row)) for row in self.A]


def _padded(rows: Sequence[Sequence[Any]], s: int) -> Rows | None:
    if len(rows) != s or not all(isinstance(x, list) and len(x) <= s for x in rows):
        return None
    if {*map(len, rows)} - {0} == {2} and s > 3:  # pairs
        return None
    return [[*x, *([ZERO] * (s - len(x)))] for x in rows]


def readings(array: Array) -> Iterator[Reading]:
    """Yield the matrices that an array may stand for."""
    value = array.value
    if array.flat:
        if len(value) == 1 and array.role == "A":
            yield Reading([list(value)])
            yield Reading([[ZERO, ZERO], [*value, ZERO]], cost=1)  # a row for the second stage
        if len(value) == 2 and array.role == "A":  # c | A of one stage
            yield Reading([[value[1]]], [value[0]], cost=3)
        yield from _of_flat(value)
        return
    if not all(isinstance(x, list) and not any(isinstance(y, list) for y in x) for x in value):
        return
    n, lengths = len(value), [len(x) for x in value]
    width = max(lengths)
    for rows, cost in ((value, 0), ([[], *value], 1)):
        if array.named and cost:  # the names say which row is the first
            break
        made = _padded(rows, len(rows)) if width <= len(rows) else None
        if made is not None and (cost == 0 or _strict(made)):
            yield Reading(made, cost=cost)
    if n > 1 and n - 1 <= width <= n and all(x <= k for k, x in enumerate(lengths, 1)):
        made = _padded([[], *value[:-1]], n)  # rows of the stages from the second, and b
        if made is not None and _strict(made) and 2 * lengths[-1] >= n:
            yield Reading(made, b=[*value[-1], *([ZERO] * (n - lengths[-1]))], cost=2)
    if n > 1 and width == n - 1:  # A over b
        made = _padded(value[:-1], n - 1)
        if made is not None and lengths[-1] == n - 1:
            yield Reading(made, b=list(value[-1]), cost=2)
    upper = all(size(x) == 0 for i in range(n) for x in value[i][:i])
    if upper and min(lengths) == width and n - width in (0, 1):  # by columns, the first left out
        columns = [list(x) for x in zip(*value, strict=True)]
        yield Reading([*[[ZERO] * n] * (n - width), *columns], cost=3)
        if n == width and any(size(value[i][i]) for i in range(n)):  # of the stages from the second
            yield Reading([[ZERO] * (n + 1), *([*x, ZERO] for x in columns)], cost=3)
    if 2 < n == lengths[-1] + 1 and all(1 < x < k + 2 for k, x in enumerate(lengths[1:-1], 1)):
        A = _padded([row[1:] for row in value[:-1]], n - 1)  # c | A over b, in rows of any length
        if A is not None and _strict(A):
            yield Reading(A, [row[0] for row in value[:-1]], list(value[-1]), 3)
    if min(lengths) == width == n + 1:  # c | A
        yield Reading([row[1:] for row in value], [row[0] for row in value], cost=1)
    if min(lengths) == width == n and n > 2:  # c | A over 0 | b, or over its order
        corner = whole_number(value[-1][0])
        order = corner if corner in range(2, 15) else None
        yield Reading([row[1:] for row in value[:-1]], [row[0] for row in value[:-1]],
                      list(value[-1][1:]), 3, order)  # fmt: skip


def _strict(A: Rows) -> bool:
    return all(size(x) == 0 for i, row in enumerate(A) for x in row[i:])


def _of_flat(value: list[Any]) -> Iterator[Reading]:
    n = len(value)
    s = isqrt(n)
    if s * s == n and s > 1:
        yield Reading([value[i * s : i * s + s] for i in range(s)], cost=1)
        if s > 2:
            yield Reading([value[i::s] for i in range(s)], cost=4)
    for diagonal in (0, 1):
        s = (isqrt(8 * n + 1) + 1) // 2 - diagonal
        if s > 1 and n == s * (s - 1) // 2 + diagonal * s:
            rows, at = [], 0
            for i in range(s):
                rows.append([*value[at : at + i + diagonal], *([ZERO] * (s - i - diagonal))])
                at += i + diagonal
            yield Reading(rows, cost=2)


# --- evidence -------------------------------------------------------------------------------------


def _near(x: float, y: float) -> bool:
    return abs(x - y) < LOOSE * max(1.0, abs(y))


def times_of(x: Array, reading: Reading) -> list[Any] | None:
    """Return nodes (s,), of which the first, 0, or any without a name may be left out.

    Those of further stages, of a dense output, are left out; one without a name is its row's sum.
    """
    s, value = len(reading.A), x.value
    if x.named and len(value) > 1 and size(value[0]) == 0:
        given = {k for k in range(min(s, len(value))) if k not in x.absent}
        if x.role != "c" and 2 * len(given) < s:
            return None  # a few names alone are no evidence
        value = [
            value[k]
            if k in given
            else Number(sum((y.value for y in row if isinstance(y, Number)), Exact(0)))
            for k, row in enumerate(reading.A)
        ]
    elif len(value) == s - 1:
        value = [ZERO, *value]
    elif len(value) > s and x.role == "c":
        value = value[:s]
    return value if len(value) == s else None


def nodes_in(reading: Reading, x: Sequence[Any] | None, power: int = 1) -> float:
    """Return the part of the rows whose sums are nodes, or half of their squares."""
    s = len(reading.A)
    values = [size(v) for v in x or ()]
    if len(values) != s:
        return 0.0
    if s == 1:
        return float(_near(reading.sums[0], values[0]))
    wanted = [v if power == 1 else v * v / 2 for v in values]
    rows = list(zip(reading.sums, wanted, strict=True))
    live = [(p, q) for p, q in rows if not (p == 0 and q == 0)]
    good = sum(_near(p, q) for p, q in live)
    if good < min(2, s - 1, len(live)) or len(live) == 0:
        return 0.0
    return good / len(live)


def order_in(reading: Reading, b: Sequence[Any]) -> int:
    """Return the order through 3 that weights have, loosely."""
    w = [size(x) for x in b]
    c, A = reading.sums, [[size(x) for x in row] for row in reading.A]
    if len(w) != len(c):
        return 0

    def dot(u: Sequence[float], v: Sequence[float]) -> float:
        return sum(p * q for p, q in zip(u, v, strict=True))

    conditions = (
        (sum(w) - 1,),
        (dot(w, c) - 1 / 2,),
        (dot(w, [x * x for x in c]) - 1 / 3, dot(w, [dot(row, c) for row in A]) - 1 / 6),
    )
    for k, level in enumerate(conditions):
        if not all(abs(x) < LOOSE for x in level):
            return k
    return 3


def _quadrature(c: Sequence[float], b: Sequence[Any]) -> int:
    """Return the order of a quadrature through 6, loosely; no entry of A matters to it."""
    sums = (sum(size(w) * x**q for w, x in zip(b, c, strict=True)) for q in range(6))
    return next((q for q, x in enumerate(sums) if abs(x - 1 / (q + 1)) > LOOSE), 6)


def _fitted(x: Sequence[Any], s: int) -> list[Any] | None:
    """Return weights (s,), of which trailing ones that are zero may be left out."""
    if len(x) == s:
        return list(x)
    return [*x, ZERO] if len(x) == s - 1 and s > 2 else None


@dataclass
class Candidate:
    """A matrix with its nodes and weights."""

    array: Array
    reading: Reading
    c: Array | None
    b: Array | None
    weights: list[Any]
    order: int
    match: float
    score: float


def _stems(x: Array, y: Array) -> bool:
    """Return whether two names may belong together."""
    return x.stem == y.stem or not x.stem or not y.stem


def candidates(array: Array, others: list[Array]) -> Candidate | None:
    """Return the best reading of an array as the matrix of a method."""
    same = [x for x in others if x.stem == array.stem]
    pool = (
        same
        if array.stem and any(x.role == "b" for x in same)
        else [x for x in others if _stems(x, array)]
    )
    vectors = _twins(array, [x for x in pool if x.flat])
    best: Candidate | None = None
    if array.role in ("b", "c") and not array.flat:  # matrix b or c, weights c or b, nodes a
        other = {"b": "c", "c": "b"}[array.role]
        swapped = {other: "b", "A": "c"}
        if any(x.role == "A" and not x.flat for x in pool):  # a pair of matrices, nodes c
            swapped = {other: "c"}
        vectors = [x.with_role(swapped.get(x.role, x.role)) for x in vectors]
        array = array.with_role("A")
    elif array.role == "beta":
        array = array.with_role("A")
    for reading in _all_readings(array, vectors):
        found = _evaluated(array, reading, vectors)
        if found is not None and (best is None or found.score > best.score):
            best = found
    return best


def _twins(array: Array, vectors: list[Array]) -> list[Array]:
    """Return vectors, of which those that differ from a matrix in its letter alone are its own.

    Beside ``A_hat`` the weights are ``b_hat``, and ``b`` are those of another matrix.
    """
    at = [k for k, x in enumerate(array.name) if x in "Aa"]
    own = {array.name[:k] + y + array.name[k + 1 :]: y.lower() for k in at for y in "bcBC"}
    roles = {x.role for x in vectors if own.get(x.name) == "b"}
    if array.role != "A" or not roles or "b" in roles:
        return vectors
    return [x.with_role(own[x.name]) if x.name in own else x.with_role("") for x in vectors]


def _all_readings(array: Array, vectors: list[Array]) -> Iterator[Reading]:
    """Yield readings, with a diagonal that stands apart and without stages of a dense output."""
    weights = {len(x.value) for x in vectors if x.role == "b"}
    diagonals = [x for x in vectors if x.role == "diagonal"]
    for reading in readings(array):
        yield reading
        s = len(reading.A)
        for x in diagonals:
            if len(x.value) in (s, s - 1) and _strict(reading.A):
                values = [*([ZERO] * (s - len(x.value))), *x.value]
                rows = enumerate(reading.A)
                yield Reading([[*row[:i], values[i], *row[i + 1 :]] for i, row in rows],
                              cost=reading.cost)  # fmt: skip
        for x in vectors if array.named and _strict(reading.A) else ():
            if x.role == "b" and len(x.value) == s:
                A = _registers(reading.A, x.value)
                yield from [Reading(A, cost=reading.cost + 1)] if A != reading.A else []
        for n in weights:
            if n == s - 1 and any(x.role == "c" and len(x.value) == s for x in vectors):
                continue  # a stage without a weight, such as first same as last
            if 2 < n < s and all(size(y) == 0 for row in reading.A[:n] for y in row[n:]):
                yield Reading([row[:n] for row in reading.A[:n]], cost=reading.cost + 1)


def _registers(A: Rows, b: Sequence[Any]) -> Rows:
    """Return A (s, s) whose entries without a name, at the left of the others, are weights.

    So are those of a method of few registers: Kennedy, Carpenter, Lewis (2000), tables 1 and 2.
    """
    first = [next((j for j, y in enumerate(row[:i]) if y is not ZERO), 0)
             for i, row in enumerate(A)]  # fmt: skip
    return [[*b[:j], *row[j:]] for j, row in zip(first, A, strict=True)]


def _evaluated(array: Array, reading: Reading, vectors: list[Array]) -> Candidate | None:
    s = len(reading.A)
    if s > MAX_SIZE or (s < 2 and array.role != "A"):
        return None
    match, node = 0.0, None
    if reading.c is not None:
        match = nodes_in(reading, reading.c)
        if match < (MOST_ROWS if s > 2 else 0.5):
            return None
    else:
        for x in vectors:
            if x.role in ("b", "embedded", "error") or x is array:
                continue
            m = nodes_in(reading, times_of(x, reading)) + 0.01 * (x.role == "c")
            if m > match:
                match, node = m, x
        if match < MOST_ROWS:
            node = None
            named = [x for x in vectors if x.role == "c" and len(x.value) in (s, s - 1)]
            match = 0.0
            node = named[0] if len(named) == 1 and array.role == "A" else None
    weight, row, order = _weights(array, reading, vectors, node, match)
    if row is None:
        return None
    score = 3 * match + order + (weight is not None and weight.role == "b") - 0.3 * reading.cost
    apart = any(x.role == "b" and len(x.value) in (s, s + 1) for x in vectors)
    score -= 3 * (apart and reading.b is not None)  # weights that have a name are meant
    if weight is not None:  # rows without a weight may be no stages
        score -= (0.0, 0.2, 1.2)[min(2, max(0, s - len(weight.value)))]
    return Candidate(array, reading, node, weight, row, order, match, score)


def _weights(
    array: Array, reading: Reading, vectors: list[Array], node: Array | None, match: float
) -> tuple[Array | None, list[Any] | None, int]:
    """Return the weights beside a matrix: their array, themselves, and their order."""
    s = len(reading.A)
    if reading.b is not None:
        order = order_in(reading, reading.b)
        return None, (reading.b if order else None), order
    best: tuple[float, Array, list[Any], int] | None = None
    for x in vectors:
        row = _fitted(x.value, s)
        if reading.c is not None and len(x.value) == s + 1 and size(x.value[0]) == 0:
            row = list(x.value[1:])  # 0 | b under c | A
        if row is None and x.role == "b" and 2 < len(x.value) < s:  # of an array of s entries
            row = [*x.value, *([ZERO] * (s - len(x.value)))]
            row = row if order_in(reading, row) > 0 else None
        last = reading.A[-1]
        if row is not None and x.named and len(x.value) < s and order_in(reading, row) == 0:
            same = [size(y) for y in row[:-1]] == [size(y) for y in last[:-1]]
            row = list(last) if same else row  # names of the row b = (b1, b2, gamma), which is A's
        if row is None or x is node or x is array or x.role in ("error", "gamma", "diagonal"):
            continue
        if x.role == "c":
            if node is None or node.name.lower() not in ("c", "cc", "getc"):
                continue
            x = x.with_role("b")  # c beside alpha
        order = order_in(reading, row)
        again = node is not None and node.role != "c" and x.value == node.value
        if order == 0 and (x.role != "b" or again):
            continue  # nodes under the name of weights, too
        rank = 10 * (x.role == "b") - 5 * (x.role == "embedded") + order - (len(x.value) < s)
        rank -= 0.001 * abs(x.at - array.at)
        if best is None or rank > best[0]:
            best = (rank, x, row, order)
    last = list(reading.A[-1])
    order = order_in(reading, last)
    if best is not None and best[1].role == "embedded" and s > 3 and order and not size(last[-1]):
        given = times_of(node, reading) if node else None
        times = list(map(size, given)) if given else reading.sums
        if _quadrature(times, last) >= _quadrature(times, best[2]):
            best = None  # the new value is that of the last stage
    if best is not None:
        return best[1], best[2], best[3]
    least = 1 if match >= MOST_ROWS and s > 3 else 2  # most rows say that it is one
    if array.role == "A" and order >= least and s > 2:
        return None, last, order
    return None, None, 0


# --- tables ---------------------------------------------------------------------------------------

#: Words of a text in which a matrix A is that of a method.
_STRONG = Words(
    "runge butcher tableau dopri dormand fehlberg",
    {"rk": r"rk(?<![a-z]rk)(?:f|ck|dp)?\d", "karp": "cash.?karp"},
)
#: Names of the parts of an additive method.
_HALF = re.compile(r"exp(?:licit)?|imp(?:licit)?|_(?:ex|im)(?![a-z])", re.IGNORECASE)


def tables(
    text: str,
    language: Language,
    *,
    fixed: bool = False,
    about: bool = False,
    declared: Mapping[str, int] | None = None,
    where: str = "",
    beyond: Mapping[str, str] | None = None,
) -> list[Table]:
    """Return the tables of a source.

    Parameters
    ----------
    text : str
    language : Language
    fixed : bool
        Whether it is Fortran in fixed form.
    about : bool
        Whether the source is known to hold tables; otherwise a word of the subject must say so.
    declared : Mapping of str to int, optional
        Orders that other files declare, by the name of the method.
    where : str, optional
        Path of the file, which may say what it is about.
    beyond : Mapping of str to str, optional
        Numbers that other files give names, see :func:`~.constants.constants_of`.
    """
    about = about or of_subject(text) or of_subject(where)
    strong = _STRONG.search(text)
    lines = None if about or "uler" in text or "EULER" in text else _named_lines(text)
    collector, everything, found = _matrices(
        text, language, fixed=fixed, about=about, strong=strong, lines=lines, beyond=beyond
    )
    if found and lines is not None:  # where names say of one table what it is, there may be others
        collector, everything, found = _matrices(
            text, language, fixed=fixed, about=about, strong=strong, beyond=beyond
        )
    if about:
        found = _with_steps(found, everything, collector)
    found = [x for x in _distinct(found) if not (x.unread.endswith(_ELSEWHERE) and any(
             not y.unread and y.source == x.source and y.block.parent is x.block
             for y in found))]  # fmt: skip
    found.sort(key=lambda x: x.line)
    _called_with(found, collector.calls)
    for table in found:
        for name in (table.name, *reversed(path_of(table)), _SUFFIX.sub("", table.name)):
            if declared and name in declared and not table.unread:
                table.order, table.sure = declared[name], True
                break
    _used_by(found, everything, collector)
    _estimated_by(found, text)
    declare(found, collector.remarks)
    found += _in_two_tables(found)
    if about:
        found += _of_arithmetic(found, everything, collector)
    if about and not found:
        found += _by_function(collector.top)
    if about:
        found += _not_folded(list(found), everything, language)
    if strong or _STORED.search(text):
        found += _left_over(list(found), everything, language)
    if about:
        found += _called_a_method(list(found), everything, collector)
    for table in found:
        if table.kind == "composition" and (table.order or 0) % 2:
            table.order = None  # a palindrome has an even order; this is the number of its weights
    return [x for x in found if x.unread or x.order is not None or any(x.c) or len(x.b[0]) > 1]


def _named_lines(text: str) -> set[int] | None:
    """Return the lines beside the names A, b, c of a text without a word of the subject.

    There stands the first of its tables, if it has any (:func:`_says`). It is ``None``, for all
    lines, where neither these names nor words of flows are the reason to read it.
    """
    if _STORED.search(text):
        return None
    places = list(_named_places(text))
    if not (places or OF_FLOWS.search(text)):
        return None
    ends = ((text.count("\n", 0, x) + 1, text.count("\n", 0, y) + 1) for x, y in places)
    return {line for first, last in ends for line in range(first, last + 1)}


def _matrices(
    text: str, language: Language, *, fixed: bool, about: bool, strong: bool,
    lines: set[int] | None = None, beyond: Mapping[str, str] | None = None,
) -> tuple[Collector, list[Block], list[Table]]:  # fmt: skip
    """Return the blocks of a source, and the tables of each that are arrays beside each other."""
    collector = Collector(text, language, fixed=fixed, lines=lines, beyond=beyond)
    everything = collector.blocks()
    for block in everything:
        named = [x.value for x in block.items if isinstance(x.value, Block)]
        for used in {x.called: x for x in reversed(named)}.values():  # others may be of an adjoint
            used.user = used.user or block
    found: list[Table] = []
    own = {id(block): arrays(block, language) for block in everything}
    for several in _methods_of_classes(everything):
        roles = [{y.role for y in own[id(x)]} for x in several]
        every = set.union(*roles)
        if max(map(len, roles)) < 2 and ({"A", "b"} <= every or {"gamma", "beta"} <= every):
            own[id(several[0])] = [y for x in several for y in own[id(x)]]
            own |= {id(x): [] for x in several[1:]}
    for block in everything:
        made = list(own[id(block)])
        if block.parent is not None and made and not any(x.role == "b" for x in made):
            taken, around = {x.name for x in made}, own[id(block.parent)]
            fills = any(x.name in taken and x.role == "A" and _empty(x) for x in around)
            made += [x for x in around if x.name not in taken and (fills or (
                     block.kind == "record" and block.line <= x.line <= block.last))]  # fmt: skip
        found += _of_block(block, made, text, about=about, strong=strong)
        found += _euler(block, made)
    return collector, everything, found


def _methods_of_classes(blocks: Sequence[Block]) -> list[list[Block]]:
    """Return the methods of each class that are defined outside of it: ``void T::set_a() {``."""
    found: dict[tuple[int, str], list[Block]] = {}
    for x in blocks:
        if x.own and x.kind == "code":
            found.setdefault((id(x.parent), x.name), []).append(x)
    return [x for x in found.values() if len(x) > 1]


#: Blocks that are a part of the function around them.
_PLAIN_BLOCKS = CHOICES | {"", "do", "try", "unsafe"}


def _own_part(block: Block, collector: Collector) -> tuple[list[Block], set[int], list[Token]]:
    """Return the functions in a block, and its lines and tokens without those of them."""
    inner = [x for x in block.blocks if x.kind == "code" and x.name not in _PLAIN_BLOCKS]
    own = set(range(block.line, block.last + 1))
    own = own.difference(n for x in inner for n in range(x.line, x.last + 1))
    low, high = (f(collector.tokens, y, key=lambda x: x.line)
                 for f, y in ((bisect_left, block.line), (bisect_right, block.last)))  # fmt: skip
    return inner, own, [x for x in collector.tokens[low:high] if x.line in own]


def _with_steps(found: list[Table], blocks: list[Block], collector: Collector) -> list[Table]:
    """Add the steps that functions make; what is computed says more than names do."""
    flows = OF_FLOWS.search(collector.text)
    steps = MULTISTEP.search(collector.text)
    known = functions(blocks, collector)
    for block in blocks:
        if block.kind != "code" or (block.parent and block.name in _PLAIN_BLOCKS):
            continue
        inner, own, said = _own_part(block, collector)
        given = flat(said, collector.language)
        made = list(steps_of(block, given, collector))
        if known and all(x.unread or not x.followed for x in made):
            more = steps_of(block, followed(given, known), collector)
            made = [x for x in more if not x.unread] or made
        for table in made:
            table.block, table.name = block, (block.own or block.name) if block.parent else "step"
            table.order, table.key, table.source = _own_order(block), key_of(table.A), STEP
            table.computed = True
        unread, made = [x for x in made if x.unread], [x for x in made if not x.unread]
        if not (made or unread or inner) and _calls_again(given) and _RUNGE.search(
                block.own or block.name):  # fmt: skip
            unread = [Table(block.name, block.line, unread=_BY_NAME, general=True, last=block.last,
                            block=block)]  # fmt: skip
        if unread and not made and not any(x.line in own for x in found):
            found = [*found, unread[0]]
        # ones alone are the weights of many methods
        weights = {key for x in made if set(key := key_of(x.b)) - {0.0, 1.0}}
        named = [x for x in found if (x.line in own and (x.named or x.unread))
                 or (not x.unread and x.source != STEP and key_of(x.b) in weights)]  # fmt: skip
        read = [x for x in named if not x.unread]
        for x, y in product(made, read):  # the same method: what is said of it is kept
            if key_of(x.b) == key_of(y.b) and key_of(x.b) in weights:
                x.name, x.line, x.sure, y.computed = y.name, y.line, y.sure, True
                x.order = y.order if y.order is not None else x.order
        made = [x for x in made if not (x.guessed and read)
                and not any(_holds_step(y, x) for y in read)]  # fmt: skip
        if made:  # what names say is something else
            found = [x for x in found if all(x is not y for y in named)] + made
        if steps and not any(x.line in own for x in found):
            for table in sums_of(block, given, collector):
                table.block, table.source = block, STEP
                found = [*found, table]
        for table in flows_of(block, given, collector) if flows else ():
            found = [x for x in found if not (x.source == STEP and x.unread and x.line in own)]
            table.block, table.order, table.source = block, _own_order(block), STEP
            table.key = key_of(table.b)
            read = [x for x in found if not x.unread]
            if not any(x.line in own if table.unread else x.key == table.key or key_of(x.b)
                       == table.key for x in read):  # fmt: skip
                found = [*found, table]
    return found


#: Names of functions that make a step.
_RUNGE = re.compile(r"RK_?\d|(?:(?<![A-Za-z])|ssp_?)rk_?\d|[Rr]unge")
_BY_NAME = "its name says that this is a step of a Runge-Kutta method, in a form that is not read"


def _calls_again(given: Sequence[Token]) -> bool:
    """Return whether a function of time and state is called three times or more in a step."""
    count = Counter(x.name for x in calls(given) if len(x.arguments) > 2)
    return max(count.values(), default=0) > 2 and _steps_in(given, ("*", "/", ",", ")"))


def _holds_step(table: Table, step: Table) -> bool:
    """Return whether a table has all that a step has: entries, nodes and further rows."""
    entries = Counter(key_of(step.A)) - Counter(key_of(table.A))
    more = len(step.errors + step.rows) > len(table.errors + table.rows)
    more = more or (any(step.c) and not any(table.c))
    return key_of(table.b) == key_of(step.b) and not entries and not more


#: So many quotients times a step stand in no formula but that of a method.
_FEW = 4


def _of_arithmetic(
    found: list[Table], blocks: list[Block], collector: Collector
) -> Iterator[Table]:
    """Yield as unread each function without a table whose step has its numbers in it."""
    seen: set[int] = set()
    code = [x for x in blocks if x.kind == "code" and x.name not in CHOICES]

    def innermost(line: int) -> Block | None:
        around = [x for x in code if x.line <= line <= x.last]
        return max(around, key=lambda x: x.line, default=None)

    quotients: dict[int, set[str]] = {}  # of a function; a few are those of many formulas
    lines = list(inline_sums(collector.tokens))
    for line, quotient in multiples(collector.text):
        own = quotients.setdefault(id(innermost(line)), set())
        own.add(quotient)
        lines += [line] if len(own) == _FEW else []
    for line in lines:
        block = innermost(line)
        if block is None or id(block) in seen:
            continue
        if any(block.line <= x.line <= block.last for x in found):
            continue
        seen.add(id(block))
        name = (block.own or block.name) if block.parent is not None else "step"
        yield Table(name, line, unread="the numbers of a step stand in its arithmetic",
                    general=True, last=line, block=block)  # fmt: skip


#: What a function that takes steps of a method is called, or called in a comment near its head.
_METHOD = re.compile(
    r"runge.?kutta|(?<![a-z])(?:ssp_?|ls|low_?storage_?|e|imex_?)?rk(?:f|ck|dp|ls|ssp)?_?\d|e?s?dirk"
    r"|adams.?(?:bashforth|moulton)|(?<![a-z])(?:ab|am|bdf)_?\d(?![a-z\d])|(?:low|2n).?storage"
    r"|dormand.?prince|fehlberg|cash.?karp|bogacki|tsitouras|yoshida|forest.?ruth|omelyan"
    r"|(?<![a-z])(?:heun|ralston|butcher|rk)(?![a-z])",
    re.IGNORECASE,
)
#: Lines before a function, and of it, in which a comment says what it is; lines of a function that
#: has one purpose; different coefficients of a step.
_ABOVE, _LINES, _DIFFERENT = 4, 200, 2
#: Characters of a number that is no other one by chance.
_MANY = 10
#: Names of the size of a step, of which a step has products.
_STEP_SIZE = re.compile(
    r"(?:\w*_)?(?:hh?|dt|tau|eps|epsilon|delta_?t|[δΔ]t|(?:time_?)?step(?:_?size)?)(?:_[a-z]*|\d*)"
    r"|\w*(?-i:Dt|DT|DeltaT|Step|StepSize)",
    re.IGNORECASE,
)


def _steps_in(row: Sequence[Token], marks: Collection[str] = ("*", "/", ".*", "./")) -> bool:
    """Return whether the size of a step stands beside one of some marks, as in a product."""
    return any(
        x.kind == "name" and {y.text, z.text} & {*marks} and _STEP_SIZE.fullmatch(x.text)
        for y, x, z in zip([row[-1], *row], row, [*row[1:], row[0]], strict=False)
    )  # fmt: skip


def _called_a_method(
    found: list[Table], blocks: list[Block], collector: Collector
) -> Iterator[Table]:
    """Yield as unread each step that is called a method and has coefficients in products.

    It, or the class around it, is called so, and nothing of either has been read, or said to be
    unread, so that no method is passed over in silence.
    """
    code = [x for x in blocks if x.kind == "code" and x.parent is not None
            and x.last - x.line < _LINES and x.name not in _PLAIN_BLOCKS]  # fmt: skip
    taken = [(x.line, max(x.line, x.last)) for x in found]

    def called(block: Block) -> re.Match[str] | None:
        near = (x.text for x in collector.remarks
                if block.line - _ABOVE <= x.last and x.line <= block.line + _ABOVE)  # fmt: skip
        said = _METHOD.search(block.own or block.name) or _METHOD.search(" ".join(near))
        free = not any(a <= block.last and block.line <= b for a, b in taken)
        return said if free else None

    for block in sorted(code, key=lambda x: x.last - x.line):
        around = [x for x in (block, block.parent) if x in code]
        said, which = next(((y, x) for x in around if (y := called(x))), (None, block))
        if said is None or any(a <= block.last and block.line <= b for a, b in taken):
            continue
        row = [x for x in _own_part(block, collector)[2] if x.kind != "line"]
        given = list(_coefficients_in(row))
        why = f"it is called {said[0]!r} and has coefficients in its arithmetic, which are not read"
        if len({x for x, _ in given}) < _DIFFERENT or not _steps_in(row):
            given = [(x.text, x.line) for x in row if x.kind == "number" and len(x.text) > _MANY]
            why = f"it is called {said[0]!r} and has numbers of many digits, which are not read"
            roots = [
                x
                for x, *y in zip(row, row[1:], row[2:], strict=False)
                if x.text in ("**", "pow", "cbrt", "^") and "1" in {z.text for z in y}
            ]
            if len({x for x, _ in given}) <= _DIFFERENT and roots and _steps_in(row):
                given = [("", roots[0].line)]
                why = f"it is called {said[0]!r} and computes its coefficients with a root"
            elif len({x for x, _ in given}) <= _DIFFERENT:
                continue
        taken.append((which.line, which.last))
        yield Table(block.own or block.name, given[0][1], unread=why, general=True,
                    last=block.last, block=block)  # fmt: skip


def _coefficients_in(row: Sequence[Token]) -> Iterator[tuple[str, int]]:
    """Yield fractions in products and quotients, or given to a call, with their lines."""
    none = Token("line", "", 0, 0, 0, False)
    padded = [none, none, none, *row, none]
    called: list[bool] = []  # of each bracket around
    for k, x in enumerate(row, 3):
        before, after = padded[k - 1], padded[k + 1]
        if x.text in ("(", "[", "{"):
            called.append(x.text == "(" and before.kind == "name")
        elif x.text in (")", "]", "}") and called:
            called.pop()
        if x.kind == "number" and before.text in ("/", "//"):
            top = padded[k - 2] if padded[k - 2].kind == "number" else none
            product = "*" in (padded[k - 3].text, after.text) or (called and called[-1])
            if top is none or product:
                yield f"{top.text}/{x.text}", x.line
        fraction = x.text.partition(".")[2].strip("0fFdDe_") if x.kind == "number" else ""
        if fraction and "*" in (before.text, after.text) and before.text not in ("/", "//"):
            yield x.text, x.line


#: Words of a text in which lists under the names of coefficients are those of a method.
_STORED = Words("williamson carpenter", {"storage": "(?:low|2n).?storage", "ssp": "ssp.?rk"})


def _left_over(given: list[Table], blocks: list[Block], language: Language) -> Iterator[Table]:
    """Yield as unread two lists or more, as long as one another, that no table of a block has.

    Both are called as coefficients are, alpha and beta or a and c, and have fractions; those of one
    are at most 1 in size, as nodes, rows of alpha and factors of registers are.
    """
    found, read = given, [y for y in given if not y.unread]
    seen = {key_of(z) for y in read for z in (*y.b, *y.c, *(w for _, w, _ in y.rows)) if z}
    for block in blocks:
        if block.parent is not None and any(block.line <= y.line <= block.last for y in given):
            continue
        lists = [x for x in arrays(block, language) if x.flat and x.role in _COEFFICIENTS
                 and 1 < len(x.value) <= MAX_SIZE
                 and sum(size(y) % 1 > 0 for y in x.value) > 1]  # fmt: skip
        for x in lists:
            near = [y for y in lists if y.name != x.name and abs(y.line - x.last) < 6
                    and abs(len(y.value) - len(x.value)) < 2]  # fmt: skip
            low, high = (f(y.line for y in (x, *near)) for f in (min, max))
            taken = any(y.line <= high + 1 and low <= max(y.line, y.last) for y in found)
            key = key_of([y.value for y in (x, *near)])
            bounded = any(max(map(abs, map(size, y.value))) <= 1 for y in (x, *near))
            if near and bounded and not taken and not {key, key_of(x.value)} & seen:
                seen.add(key)
                names = " and ".join(dict.fromkeys(y.name for y in (x, *near)))
                table = Table(_title(block, x), x.line, general=True, last=high, block=block)
                table.unread = (
                    f"{names} are called as coefficients are; no method that has them is read"
                )
                found = [*found, table]
                yield table


#: Names of matrices of which more than one letter says so, or a capital: A, A_implicit, aim.
_CALLED_A = re.compile(r"(?:^|_|(?<=[a-z0-9]))A(?![A-Z])|^a_?(?:ex|im)", re.ASCII)


def _not_folded(given: list[Table], blocks: list[Block], language: Language) -> Iterator[Table]:
    """Yield as unread each matrix A beside weights that is computed in a way that is not read."""
    for block in blocks:
        rows: list[tuple[str, int, str, list[Block]]] = [
            (x.name, x.line, "it is the value of a call", [block])
            for x in block.blocks if x.kind == "record"
        ]  # fmt: skip
        for x in block.items:
            entries = flattened(list(x.value.values())) if isinstance(x.value, Entries) else []
            why = next((str(y) for y in (x.value, *entries) if isinstance(y, Unread)), "")
            around = [block, *([block.parent] if entries and block.parent else [])]
            rows += [(x.name, x.line, why, around)] if why else []
        for name, line, why, around in sorted(rows, key=lambda x: x[1]):
            if role_of(name)[1] != "A" or not _CALLED_A.search(name):
                continue
            weights = any(
                y.flat and y.role in ("b", "embedded") and len(y.value) > 1
                and _near(sum(map(size, y.value)), 1)
                for at in around for y in arrays(at, language)
            )  # fmt: skip
            if weights and not any(y.line <= line <= max(y.line, y.last) or (
                    y.source == name and y.block in around) for y in given):  # fmt: skip
                why = f"the matrix `{name}` is not read: {why}"
                yield Table(name, line, unread=why, general=True, last=line, block=block)
                break  # others are made of it, or are its other part


#: Roles of lists that are coefficients of a method where another one stands beside.
_COEFFICIENTS = frozenset(("A", "b", "c", "beta", "gamma"))


def _by_function(top: Block) -> Iterator[Table]:
    """Yield as unread the method that functions NAME_order and NAME_apply say is here."""
    names = {x.name: x for x in top.blocks if x.kind == "code"}
    for name, block in names.items():
        stem = name.removesuffix("_order")
        if stem != name and {f"{stem}_apply", f"{stem}_step"} & names.keys():
            why = "the coefficients are computed, or stand in the arithmetic of the step"
            yield Table(stem, block.line, unread=why, general=True, last=block.last, block=block)


def _in_two_tables(found: list[Table]) -> list[Table]:
    """Return the additive methods whose parts are tables that differ in the word explicit."""
    made = []
    read = [x for x in found if not x.unread and x.kind == "rk" and _HALF.search(x.name)]
    for x, y in permutations(read, 2):
        words = [_HALF.findall(z.name)[0].lower().strip("_")[0] for z in (x, y)]
        same = len({_HALF.sub("", z.name) for z in (x, y)}) == 1 and len(x.b[0]) == len(y.b[0])
        blocks = [z.block.parent if z.block.kind == "record" else z.block for z in (x, y)]
        if words == ["e", "i"] and same and blocks[0] is blocks[1]:
            table = Table(f"{x.name} with {y.name}", max(x.line, y.line), "additive",
                          [x.A[0], y.A[0]], [x.b[0], y.b[0]], [x.c[0], y.c[0]],
                          x.order if x.order is not None else y.order, general=True)  # fmt: skip
            table.sure, table.last, table.block = x.sure and y.sure, max(x.last, y.last), x.block
            table.doubt = x.doubt or y.doubt
            made.append(table)
    return made


def _used_by(found: list[Table], blocks: list[Block], collector: Collector) -> None:
    """Give tables the order of the blocks that name them first, where those agree.

    A table that a block names after another one may be that of an adjoint, or of a dense output.
    """
    orders = [(x, order) for x in blocks if x.parent and (order := _own_order(x, above=False))]
    names = {path[0] for x in found if (path := path_of(x))}
    tokens = [x for x in collector.tokens if x.kind == "name" and x.text in names]
    for table in found:
        path = path_of(table)
        if table.unread or table.order is not None or not path:
            continue
        used = {order for x, order in orders
                if next((y.text for y in tokens if x.line <= y.line <= x.last), "") == path[0]
                and not x.line <= table.line <= x.last}  # fmt: skip
        if len(used) == 1:
            table.order = used.pop()


def _estimated_by(found: list[Table], text: str) -> None:
    """Make rows that sum to 1 those of error estimates where the size of their sum alone is taken.

    So is ``abs(e1*k1 + e3*k3 + ..)``, which no state enters, of the difference of two rows.
    """
    lines = text.splitlines()
    for table in (x for x in found if x.block is not None and x.named):
        part = "\n".join(lines[table.line - 1 : table.block.last])
        for row in [x for x in table.rows if role_of(x[0])[1] == "error" and x[2] is None]:
            name = re.escape(row[0])
            if re.search(rf"\b(?:f?abs|norm)\s*\(\s*{name}_?\d+\s*\*[^;\n]*{name}_?\d+\s*\*", part):
                table.rows.remove(row)
                table.errors.append(row[1])


def _euler(block: Block, made: list[Array]) -> Iterator[Table]:
    """Yield the method of Euler where its name and the weight 1 are all that is written."""
    name = next((x for x in reversed(block.path()) if EULER.search(x)), "")
    if name and not any(x.role == "A" for x in made):
        for x in made:
            if x.role == "b" and [size(y) for y in x.value] == [1.0]:
                table = Table(name, x.line, general=True, last=x.last, block=block, loose=1)
                table.A, table.b, table.c = [[[ZERO]]], [x.value], [[ZERO]]
                table.order = _own_order(block)
                yield table


#: Words at the end of a name that are not that of the method.
_SUFFIX = re.compile(r"(?:ESDIRKIMEX|IMEX|Rodas)?(?:Constant|Constants|Cache|Tableau|Tab)+$")


def numbers_of(table: Table) -> tuple[float, ...]:
    """Return the entries of A and b to nine digits: what two readings of a table share."""
    return tuple(round(size(x), 9) for x in flattened([*table.A, *table.b]))


def _distinct(found: list[Table]) -> list[Table]:
    """Return tables without those that stand there twice, as an array and as an argument."""
    seen: list[tuple[tuple[float, ...], Table]] = []
    for table in found:
        key = numbers_of(table)
        path = path_of(table)
        other = next((x for k, x in seen if k == key
                      and (abs(x.line - table.line) < 100 or x.block is table.block)
                      and all(map(str.__eq__, path, path_of(x)))), None)  # fmt: skip
        if other is None or table.unread:
            seen.append((key, table))
        elif other.order is None and table.order is not None:
            other.order, other.sure = table.order, table.sure
    kept = [x for _, x in seen]
    read = [x for x in kept if not x.unread]

    def repeats(x: Table) -> bool:
        return bool(x.unread) and any(
            y is not x and abs(y.line - x.line) < 60 and y.key == x.key and x.key for y in read
        )

    return [x for x in kept if not repeats(x)]


def path_of(table: Table) -> list[str]:
    """Return the names of the blocks around a table."""
    return table.block.path() if table.block is not None else []


def _called_with(found: list[Table], calls: list[Block]) -> None:
    """Take the order from calls that are given a matrix, its name and small whole numbers.

    Which of the numbers is the order is what most calls of one function agree on.
    """
    given: dict[str, list[tuple[Table, Block]]] = {}
    for table in found:
        if table.unread:
            continue
        keys = {table.key, *map(key_of, table.A)} - {()}
        again = min((x.line for x in found if x.source == table.source and x.line > table.last),
                    default=table.last + 26)  # fmt: skip
        for call in calls:
            near = table.last <= call.line < min(again, table.last + 26)
            near = near or call.line <= table.line <= call.last
            if not (call.called and near):
                continue
            takes = any(name == table.source for name, _ in call.arguments if name) or any(
                isinstance(x.value, list) and key_of(x.value) in keys for x in call.items
            )
            if takes or call is table.block:
                word = not call.label.isupper() or takes
                own = call.name.rpartition(".")[2] != call.called
                label = call.label or (call.name if own else "")  # what the call is assigned to
                if label and word and table.name in (table.source, *path_of(table)):
                    table.name = label
                given.setdefault(call.called, []).append((table, call))
                break
    for pairs in given.values():
        width = max(len(call.arguments) for _, call in pairs)
        best: tuple[float, int] = (0.0, -1)
        for k in range(width):
            values = [(t, call.arguments[k][1]) for t, call in pairs if k < len(call.arguments)]
            held = [(t, n) for t, n in values if n is not None]
            if len(held) < len(values) or not all(1 <= n <= 14 for _, n in held):
                continue
            good = sum(min(3, n) == t.loose for t, n in held) / len(held)
            if good > best[0]:
                best = (good, k)
        if best[0] < 0.6:
            continue
        others = sum(call.arguments[best[1]][1] != len(t.b[0]) for t, call in pairs
                     if best[1] < len(call.arguments))  # fmt: skip
        clear = best[0] > 0.9 and others > 2  # the column is not the number of stages
        for table, call in pairs:
            if best[1] < len(call.arguments) and table.order is None:
                numbers = {n for _, n in call.arguments if n is not None and 1 <= n <= 14}
                same = call.arguments[best[1]][1] == len(table.b[0])
                many = len(table.b[0]) > 4 and not others  # no method has so high an order
                if same and (len(numbers) > 1 or many) and not clear:
                    continue  # this may be the number of stages, and another one the order
                table.order = call.arguments[best[1]][1]
                table.sure = table.sure and len(pairs) > 2


def _closing(made: list[Array]) -> list[Array]:
    """Return weights of two parts that stand in the last rows of their matrices.

    Both parts have the last row of the implicit one where that of the explicit one has less order.
    """
    matrices = [x for x in made if x.role == "A" and not x.flat]
    if len(matrices) != 2 or any(x.role == "b" for x in made):
        return []
    parts = [_padded(x.value, len(x.value)) for x in matrices]
    if None in parts or len(matrices[0].value) != len(matrices[1].value):
        return []
    pair = sorted(zip(matrices, parts, strict=True), key=lambda x: not _strict(x[1] or []))
    (explicit, A), (implicit, At) = [(x, Reading(y or [])) for x, y in pair]
    last = At.A[-1]
    own = A.A[-1] if order_in(A, A.A[-1]) >= order_in(A, last) else last
    if not _strict(A.A) or _strict(At.A) or min(order_in(A, own), order_in(At, last)) < 1:
        return []
    return [
        Array("b" + x.name[1:], list(row), x.line, x.last, x.at, x.lost, guessed=True)
        for x, row in ((explicit, own), (implicit, last))
    ]


def _windows(array: Array, made: list[Array]) -> list[Array]:
    """Return the arrays that may belong to a matrix where names are used again and again."""
    same = [x for x in made if x.name == array.name and x.flat == array.flat]
    if len(same) < 2:
        return made
    k = same.index(array)
    ends = [-1, *(x.at for x in same), 10**9]
    before, after = (
        sum(_weighed(x, made, *ends[j + shift : j + shift + 2]) for j, x in enumerate(same))
        for shift in (0, 1)
    )
    if before == after:  # by what stands before the first and after the last of them
        others = [x.at for x in made if x.name != array.name]
        before += min(others, default=0) < same[0].at
        if before > after and max(others, default=0) >= same[-1].at:
            return [x for x in made if ends[k] < x.at < ends[k + 2]]
    if before > after:  # weights come before their matrix
        return [x for x in made if ends[k] < x.at <= array.at]
    return [x for x in made if array.at <= x.at < ends[k + 2]]


def _weighed(array: Array, made: list[Array], low: int, high: int) -> bool:
    """Return whether weights, as many as a matrix has rows, stand in a part of a block."""
    return any(
        x.flat and x.role == "b" and len(x.value) == len(array.value)
        for x in made
        if low < x.at < high
    )


def _latest(made: list[Array], at: int) -> list[Array]:
    """Keep of arrays with one name the one that stands nearest."""
    best: dict[tuple[str, str, bool], Array] = {}
    for x in made:
        key = (x.name or str(id(x)), x.role, x.flat)
        if key not in best or abs(x.at - at) < abs(best[key].at - at):
            best[key] = x
    return list(best.values())


#: Matrices that are no stages: predictors, dense output, inverses and eigenvectors.
_GUESSES = re.compile(
    r"predict|dense|interp|extrap|inverse|(?:^|_)inv|part_inv|inv$|eigen|transf|(?:^|_)d?T(?:_|$)",
    re.IGNORECASE,
)


def _of_block(
    block: Block, made: list[Array], text: str, *, about: bool, strong: bool
) -> list[Table]:
    found: list[tuple[Candidate, list[Array]]] = []
    unread: list[Table] = []
    halves: list[tuple[Candidate, list[Array]]] = []
    used: set[int] = set()
    made = [x.with_role("embedded") if _is_embedded(x, made, text) else x for x in made]
    other = others(block, made, text=text) if about else []
    for x in other:
        anchor, table = x.arrays[0], x.table
        table.name = table.name or _title(block, anchor)
        table.block, table.source = block, anchor.name
        table.key = key_of([y.value for y in x.arrays])
        table.order = _own_order(block)
        used |= {id(y) for y in x.arrays}
    for array in [x for x in made if id(x) not in used]:
        if array.flat and array.role not in ("A", "beta"):
            continue
        if (
            array.role in ("b", "error", "embedded", "c")
            and not array.flat
            and len(array.value) < 3
        ):
            continue
        if _GUESSES.search(array.name) or _is_dense(array, made):
            continue
        near = _latest(_windows(array, made), array.at)
        near = [x for x in near if x is not array] + _closing(made)
        best = candidates(array, near)
        if best is None or _is_explicit_part(best, made):
            continue
        if array.role == "beta" and len(array.value) > 1 and best.match < MOST_ROWS and (
                best.order < 2):  # fmt: skip
            continue
        if _is_table(best, about=about, call=block.called):
            found.append((best, near))
            used.add(id(array))
        elif _HALF.search(array.name):
            halves.append((best, near))
    found = [x for x in found if not _is_beside(x[0], [y for y, _ in found])]
    found = [(_completed(x, [y for y, _ in found]), near) for x, near in found]
    for half in halves:  # named so beside a table, it is its other half, however wrong
        if any(_HALF.search(y.array.name) and _additive(half[0], y) for y, _ in found):
            found.append(half)
            used.add(id(half[0].array))
    for array in made:
        if (
            id(array) not in used
            and strong
            and (array.role == "A" or (_STRONG.search(array.name) and _HALF.search(array.name)))
            and not _GUESSES.search(array.name)
        ):
            why = _looks_like(array, made)
            if why:
                table = Table(_title(block, array), array.line, unread=why)
                table.key = key_of(array.value)
                unread.append(table)
    built = _built(block, found)
    return [*(x.table for x in other), *built, *_passed_over(block, made, built), *unread]


def _completed(x: Candidate, others: Sequence[Candidate]) -> Candidate:
    """Return a candidate with the weights of another one where names of its own lack the last."""
    if x.b is None or not x.b.named or x.order or len(x.b.value) == len(x.weights):
        return x
    n, own = len(x.b.value), [size(y) for y in x.weights]
    same = [y for y in others if y.order and len(y.weights) == len(own)
            and [size(z) for z in y.weights[:n]] == own[:n]]  # fmt: skip
    if not same:
        return x
    return replace(x, weights=same[0].weights, order=order_in(x.reading, same[0].weights))


def _is_embedded(x: Array, made: Sequence[Array], text: str) -> bool:
    """Return whether a row ``E`` without another one is of embedded weights: by its sum, or use.

    Those of an error estimate sum to 0; what is assigned to an error is meant as such.
    """
    if not (x.flat and x.role == "error" and _E.search(x.name)):
        return False
    alone = not any(y.flat and y.role == "embedded" for y in made)
    total = sum(map(size, x.value))
    use = rf"\b\w*err\w*[^=\n]*=(?!=)[^;\n]*\b{re.escape(x.name)}\b(?![\[\w\]]* *-)"
    return alone and abs(total - 1) < 0.5 and not re.search(use, text, re.IGNORECASE)


def _is_beside(x: Candidate, others: Sequence[Candidate]) -> bool:
    """Return whether another matrix with the same weights is the method, and this one is not."""
    if x.b is None or x.match >= MOST_ROWS or x.order > 1:
        return False
    return any(
        y.b is not None and y.b.at == x.b.at and y.b.name == x.b.name and y.order > x.order
        and y.match >= MOST_ROWS for y in others
    )  # fmt: skip


def _is_dense(array: Array, made: Sequence[Array]) -> bool:
    """Return whether the rows of a matrix without the name A sum to the weights b beside it."""
    if array.flat or array.role == "A" or not all(isinstance(x, list) for x in array.value):
        return False
    sums = [sum(map(size, row)) for row in array.value]
    return any(
        y.flat and y.role == "b" and 2 < len(y.value) <= len(sums)
        and all(_near(p, size(q)) for p, q in zip(sums, y.value, strict=False)) for y in made
    )  # fmt: skip


def _is_explicit_part(x: Candidate, made: Sequence[Array]) -> bool:
    """Return whether a matrix of zeros stands beside another one of its shape."""
    if len(x.reading.A) == 1 or any(size(y) for row in x.reading.A for y in row):
        return False
    return any(
        y is not x.array and y.flat == x.array.flat and len(y.value) == len(x.array.value)
        and isinstance(y.value[0], list) == isinstance(x.array.value[0], list) for y in made
    )  # fmt: skip


def _is_table(x: Candidate, *, about: bool, call: str) -> bool:
    """Return whether a candidate is a table and no other matrix.

    It may stand in a call of this name, which may be one of a tableau.
    """
    called, told = call != "" and x.array.name == "", _STRONG.search(call)
    s = len(x.reading.A)
    entries = [size(y) for row in (*x.reading.A, x.weights) for y in row]
    broken = sum(y != 0 and y == y and y != round(y) for y in entries)
    named = x.array.role == "A" and (x.b is None or x.b.role in ("A", "b", "embedded"))
    lower = s > 2 and _strict(x.reading.A) and x.match >= MOST_ROWS and x.order > 0
    named = named or (called and x.b is not None and (x.match >= 1 or lower))
    node = x.c is not None and x.c.role == "c"
    about, other = about or _says(x), call != "" and not of_subject(call)
    if x.match < MOST_ROWS and abs(sum(map(size, x.weights)) - 1) > 0.5:
        return False  # weights of an estimate, or of noise
    if told and named and x.b is not None and x.order > 0 and s > 1:
        return about
    if x.array.order is not None and x.reading.b is not None and s > 1:
        return about  # an empty corner and an order say so
    if s == 1:  # tables() requires a declared order or abscissae, too
        given = node or x.reading.c is not None or (x.b is not None and x.b.role == "b")
        return about and x.array.role in ("A", "beta") and given and x.order > 0 and not other
    if not broken and s < 4 and not (named and node and x.b is not None):
        return False
    if s == 2 and x.array.role == "A" and node and x.match >= 1 and x.order >= 2:
        return about
    if s == 2:
        known = node or x.reading.c is not None or x.order >= 2
        return named and x.b is not None and known and about
    if x.order == 0:
        known = x.match >= MOST_ROWS and (node or s > 3)
        strict = x.b is not None and not x.array.flat and _strict(x.reading.A)
        return named and about and (known or strict)
    if named and x.b is not None:
        weights = x.order > 0 and x.b.role == "b" and x.b.stem == x.array.stem
        return about and (x.order >= 2 or x.match >= MOST_ROWS or node or (weights and s > 2))
    if x.array.name == "" and x.b is not None and x.b.name == "" and not about:
        return False
    whole = x.reading.b is not None and x.reading.c is not None and _strict(x.reading.A)
    if x.order == 1 and (named or whole):  # weights in the last row, of a method with a wrong row
        return about and x.match >= MOST_ROWS and (node or whole) and s > 3
    if x.order >= 3:
        return about and (x.match >= MOST_ROWS or s > 3 or x.array.role == "A")
    return about and x.order == 2 and x.match >= MOST_ROWS and (x.array.role == "A" or s > 3)


def _says(x: Candidate) -> bool:
    """Return whether the names A, b, c and the sums of the rows say what no word says."""
    if x.b is None or x.c is None or (x.array.role, x.b.role, x.c.role) != ("A", "b", "c"):
        return False
    least = MOST_ROWS if _strict(x.reading.A) and len(x.reading.A) > 2 else 1
    return x.match >= least and (x.order > 0 or least < 1)


def _looks_like(array: Array, made: list[Array]) -> str:
    """Return why an array that looks like the matrix of a method is not read, or ``""``."""
    if array.flat or len(array.value) < 2:
        return ""
    lengths = [len(x) for x in array.value if isinstance(x, list)]
    n = len(array.value)
    left = max(0, max(lengths, default=0) - n)  # rows before the first, of an explicit stage
    square = len(lengths) == n and n - 1 <= max(lengths) <= n + 1
    lower = square and all(size(x) in (0.0,) or x is ZERO for i, row in enumerate(array.value)
                           for x in row[i + 1 + left :])  # fmt: skip
    broken = sum(bool(size(x) % 1) for x in flattened(array.value) if math.isfinite(size(x)))
    if not lower or broken < 2 or n < 3:
        return ""
    others = sorted({x.name for x in made if x is not array and x.name})[:6]
    beside = f"; beside it stand {', '.join(others)}" if others else ""
    if any(x.role == "gamma" and not x.flat for x in made):
        return "the coefficients of a Rosenbrock method, in a form that is not read"
    return f"`{array.name}` looks like the matrix of a method; its weights are not found{beside}"


def key_of(value: Any) -> tuple[float, ...]:
    """Return the entries of an array that are not zero."""
    return tuple(round(size(x), 9) for x in flattened(value) if size(x) != 0)


def _title(block: Block, array: Array) -> str:
    path = [x for x in block.path() if x not in CHOICES | {"__init__", "namespace"}]
    base = path[-1] if path else ""
    if block.kind == "record" and len(base) < 3 and len(path) > 1:  # B->A of a function
        base = path[-2]
    if array.stem not in ("", "rk", "ros") and array.stem.lower() not in base.lower():
        return array.name if not base or not block.parent else f"{base}.{array.name}"
    return base or array.name or "table"


def _lost(x: Candidate) -> str:
    """Return the reason why a table is not what the code uses, or ``""``."""
    try:
        only_numbers(*(y for y in (x.array, x.b, x.c) if y is not None))
    except Unread as error:
        return str(error)
    empty = x.c is not None and not _empty(x.c) and _empty(x.array)
    return f"all entries of {x.array.name} {_ELSEWHERE}" if empty else ""


_ELSEWHERE = "are 0, and set elsewhere"


def _empty(x: Array) -> bool:
    return not any(map(size, flattened(x.value)))


def _built(block: Block, found: list[tuple[Candidate, list[Array]]]) -> list[Table]:
    made: list[Table] = []
    done: set[int] = set()
    for k, (x, near) in enumerate(found):
        if k in done:
            continue
        pair = next((j for j in range(k + 1, len(found)) if j not in done
                     and _additive(x, found[j][0])), None)  # fmt: skip
        if pair is not None:
            done.add(pair)
            made.append(_together_of(block, x, found[pair][0], near))
        else:
            made.append(_single(block, x, near))
    return made


def _additive(x: Candidate, y: Candidate) -> bool:
    """Return whether two matrices are the explicit and the implicit part of one method."""
    if x.array.name == y.array.name or not _stems(x.array, y.array):
        return False
    s, r = (len(z.reading.A) for z in (x, y))
    rows = len(x.array.value) == len(y.array.value)  # the first of the explicit part is left out
    if s != r and not (rows and abs(s - r) == 1):
        return False
    if {x.array.role, y.array.role} != {"A"}:
        return False
    explicit = [_strict(z.reading.A) for z in (x, y)]
    said = all(_HALF.search(z.array.name) for z in (x, y))
    if sorted(explicit) != [False, True] or any(
        z.match < MOST_ROWS and z.order < 2 - said for z in (x, y)
    ):
        return False
    stems = [re.sub("(?i)hat|tilde|[_ ]", "", _HALF.sub("", z.array.name)) for z in (x, y)]
    return stems[0][:1].lower() == stems[1][:1].lower()


def _single(block: Block, x: Candidate, near: list[Array]) -> Table:
    table = Table(_title(block, x.array), x.array.line, general=True)
    table.last = max(y.last for y in (x.array, *([x.b] if x.b else []), *([x.c] if x.c else [])))
    table.block, table.source, table.key = block, x.array.name, key_of(x.array.value)
    table.loose = x.order
    lost = _lost(x)
    rows = enumerate(x.reading.A)
    own = [size(row[i]) for i, row in rows]
    some = x.match < 1 or any(own)  # c may be complete, or the sums of rows
    if x.array.named and some and not lost and 0 in own[x.match >= 1 :]:
        diagonal = [y for y in block.items if y.name in ("γ", "gamma", "gam")]
        lost = f"the diagonal of {x.array.name} may be {diagonal[0].name}" if diagonal else ""
    if any(y.name.lower() in _STEPS and (whole_number(y.value) or 0) > 1 for y in block.items):
        lost = lost or "a Runge-Kutta method of several steps, which is not read"
    if lost:
        table.unread = lost
        return table
    times = x.reading.c
    if x.c is not None:
        times = times_of(x.c, x.reading)
    if _is_nystrom(x, near):
        table.unread = "the coefficients of a Nystrom method, in a form that is not read"
        return table
    table.A, table.b, table.c = [x.reading.A], [x.weights], [times]
    table.named = x.array.named
    order = x.array.order if x.array.order is not None else x.reading.order
    order = order if order is not None else _own_order(block)
    table.order, table.sure, table.pair = order, True, _two_orders(block)
    table.guessed = x.reading.b is None
    if x.b is not None:
        table.guessed = x.b.guessed or role_of(x.b.name)[1] == "embedded"
    if not x.reading.order and (x.array.role != "A" or (x.b is not None and x.b.role != "b")):
        table.sure = False
    alone = x.match < MOST_ROWS and x.c is None and x.reading.c is None
    if x.order == 1 and alone and not _strict(x.reading.A):
        table.sure = False  # the names alone say what it is
    _further(table, x, near)
    return table


def _is_nystrom(x: Candidate, near: list[Array]) -> bool:
    """Return whether rows, more than one, sum to half of the squares of nodes."""
    if x.match >= MOST_ROWS or len(x.reading.A) < 3:
        return False
    return any(
        nodes_in(x.reading, times_of(y, x.reading), 2) >= MOST_ROWS
        for y in near
        if y.flat and y.role not in ("b", "embedded", "error") and y is not x.b
    )


#: Names of the number of steps that a method looks at.
_STEPS = frozenset(("steps", "nsteps", "n_steps", "num_steps"))
#: Names that embedded weights do not have.
_ESTIMATE = re.compile(r"(?:^|_)(?:rk_?)?E(?:rr\w*)?$")
#: The letter of weights of either kind; after ``rk`` or ``ros`` it is that of an estimate.
_E = re.compile(r"(?:^|(?<!rk)(?<!ros)_)E$")
#: Names that weights of an error estimate do not have.
_EMBEDDED = re.compile(r"(?:^|_)b_?(?:hat|star|emb\w*|low\w*)$", re.IGNORECASE)


def _further(table: Table, x: Candidate, near: list[Array]) -> None:
    """Add embedded rows and the weights of error estimates."""
    s = len(x.weights)
    lower = _lower_order(table.block)
    for y in near:
        own = _DENSE.split(y.name)[0].strip("_").lower()  # RK45 of RK45_P
        foreign = own and x.array.stem and own != x.array.stem
        if not y.flat and _DENSE.search(y.name) and not y.lost and not foreign:
            table.dense += _of_dense_output(y, x.weights)
        if not y.flat or y is x.b or y is x.c or not _stems(y, x.array) or y.lost:
            continue
        if any(not isinstance(v, Number) for v in y.value):
            continue
        row = _fitted(y.value, s)
        total = sum(map(size, y.value))
        if row is None and len(y.value) == s + 1 and y.role == "error":
            row = list(y.value)
        elif row is None and len(y.value) == s + 1 and x.reading.c and size(y.value[0]) == 0:
            row = list(y.value[1:])  # 0 | b under c | A
        if row is None:
            continue
        if y.role == "error" and len(y.value) >= s:
            explicit = _strict(x.reading.A)  # others may estimate in transformed variables
            if len({*map(size, row)}) == 1:
                continue  # a stand-in: no estimate has equal weights
            if abs(total) < (0.5 if explicit else LOOSE):
                table.errors.append(row)
            elif explicit and _ESTIMATE.search(y.name) and _near(total, 1):
                table.errors.append(row)  # embedded weights in their place
            elif _near(total, 1) and len(row) == s:
                table.rows.append((y.name, row, None))
            elif explicit and y.named and x.array.named and len(row) > 3:
                table.errors.append(row)  # judged where one weight makes the sum 0
        elif y.role in ("", "b") and len(row) == s and abs(total - 1) < 0.5 and _sibling(y, x.b):
            table.rows.append((y.name, row, None))
        elif y.role == "embedded" and len(row) == s:
            named = role_of(y.name)[1] in ("embedded", "error")
            if y.named and len(y.value) < s and not _near(total, 1):
                continue  # an entry has no name
            if abs(total) < LOOSE and not _EMBEDDED.search(y.name):
                table.errors.append(row)
            elif (
                _near(total, 1)
                or _beside(y, x.b)
                or (named and (abs(total - 1) < 0.5 or abs(total) < LOOSE))
            ):
                table.rows.append((y.name, row, lower))


def _sibling(x: Array, b: Array | None) -> bool:
    """Return whether two names of weights differ in digits, or a letter said again: b4, b5, bb."""
    if b is None or not x.name or x.name == b.name or b.named or x.named:
        return False
    names = (re.sub(r"\d+|([a-zA-Z])(?=\1)", "", y.name).lower() for y in (x, b))
    return len(set(names)) == 1


def _beside(x: Array, b: Array | None) -> bool:
    """Return whether weights stand in one list with those of a method."""
    return b is not None and (x.name, x.at) == (b.name, b.at)


_DENSE = re.compile(r"^P$|_P$|dense|interp|contin", re.IGNORECASE)


def _of_dense_output(y: Array, weights: Sequence[Any]) -> list[tuple[str, Rows]]:
    """Return a matrix (s, d) of b_i(theta), by stages, whose rows, or columns, may be ragged.

    Most of its rows sum to the weights, or all columns but one to 1 (of theta) and 0 (of theta^2,
    ..); where all rows do and some columns do not, its functions of theta are others.
    """
    s, value = len(weights), [x if isinstance(x, list) else [x] for x in y.value]
    if any(not isinstance(v, Number) for r in value for v in r):
        return []
    width = max(map(len, value))
    rows = [[*r, *([ZERO] * (width - len(r)))] for r in value]
    for given in (rows, [list(r) for r in zip(*rows, strict=True)]):
        given += [[ZERO] * len(given[0])] * (len(given) == s - 1)
        live = [k for k, column in enumerate(zip(*given, strict=True)) if any(map(size, column))]
        made = [r[live[0] : live[-1] + 1] for r in given] if live else given  # not 1 = theta^0
        good = sum(abs(sum(map(size, r)) - size(w)) < 1e-6
                   for r, w in zip(made, weights, strict=False))  # fmt: skip
        sums = [sum(map(size, r)) for r in zip(*made, strict=True)]
        off = min(
            sum(abs(x - (k == at)) > LOOSE for k, x in enumerate(sums)) for at in (0, len(sums) - 1)
        )
        most = good > 2 and good >= MOST_ROWS * s
        if len(made) >= s and (off < 2 or (most and good < s)):
            return [(y.name, made if _near(sums[0], 1) else [r[::-1] for r in made])]
    return []


def _passed_over(block: Block, made: Sequence[Array], found: Sequence[Table]) -> Iterator[Table]:
    """Yield as unread what is called a dense output beside a method, and is none of its powers."""
    given = [x for x in found if not x.unread and x.kind == "rk"]
    read = {name for x in given for name, _ in x.dense} | {x.source for x in given}
    sizes = {n for x in given for n in (len(x.b[0]) - 1, len(x.b[0]))}
    for y in made if given else ():
        shape = {len(y.value), max((len(r) for r in y.value if isinstance(r, list)), default=0)}
        if not y.flat and _DENSE.search(y.name) and y.name not in read and shape & sizes:
            why = f"`{y.name}` is called as a dense output is; powers of theta do not have its sums"
            yield Table(_title(block, y), y.line, unread=y.lost or why, last=y.last)


def _lower_order(block: Block) -> int | None:
    """Return the order that a block declares for its embedded weights."""
    word = re.compile(r"(?:low|emb\w*|second\w*)_?order|order_?(?:low|emb|bt)\w*", re.IGNORECASE)
    items = [x for at in (block, *block.blocks) for x in at.items]
    given = [x.value for x in items if word.search(x.name) and isinstance(x.value, Number)]
    values = {x.value.as_fraction() for x in given}
    return next((n for n in range(1, 15) if values == {n}), None)


def _after_a_stage(x: Candidate) -> Candidate:
    """Return the implicit part of a method whose first stage, the value itself, is left out."""
    rows = [[ZERO] * (len(x.weights) + 1), *([ZERO, *row] for row in x.reading.A)]
    nodes = x.c if x.c is None else replace(x.c, value=[ZERO, *x.c.value])
    return replace(x, reading=Reading(rows), c=nodes, weights=[ZERO, *x.weights])


def _together_of(block: Block, x: Candidate, y: Candidate, near: list[Array]) -> Table:
    explicit, implicit = (x, y) if _strict(x.reading.A) else (y, x)
    if len(implicit.reading.A) < len(explicit.reading.A):
        implicit = _after_a_stage(implicit)
    table = _single(block, explicit, near)
    why = table.unread or _lost(implicit)
    if why:
        table.unread = why
        return table
    s = len(table.b[0])
    own = [z for z in near if z.flat and z.role == "b" and len(z.value) == s]
    parts = []
    for z in (explicit, implicit):
        mine = [v for v in own if v.name[1:] == z.array.name[1:]]
        parts.append(list(mine[0].value) if mine and z in (x, y) else z.weights)
    table.kind, table.A, table.b = "additive", [explicit.reading.A, implicit.reading.A], parts
    times = [z.c.value if z.c is not None and z.match >= MOST_ROWS else None
             for z in (explicit, implicit)]  # fmt: skip
    table.c = [[ZERO, *t] if t is not None and len(t) == s - 1 else t for t in times]
    table.rows, table.errors = [], []
    table.line, table.last = min(x.array.line, y.array.line), max(x.array.last, y.array.last)
    return table


# --- declared orders ------------------------------------------------------------------------------

_ORDER_NAME = re.compile(r"order", re.IGNORECASE)
_NOT_ORDER = re.compile(
    r"low|emb|err|stage|dense|interp|min|max|largest|border|record|num|bt|second|adaptive|reorder|weak|"
    r"contin|dim|deriv|hat|alt",
    re.IGNORECASE,
)
_SAID = re.compile(
    r"\b(\d{1,2})(?:st|nd|rd|th)?[- ]order\b"
    r"|\border(?: of accuracy)?[ :=]+(?:is )?(\d{1,2})\b"
    r"|\b(first|second|third|fourth|fifth|sixth|seventh|eighth|ninth|tenth)[- ]order\b",
    re.IGNORECASE,
)
#: ``primary order 4``, and of a pair ``order 8(5, 3)``, ``Dormand-Prince 5(4)``.
_PRIMARY = re.compile(
    r"\b(?:primary|main) order[ :=]+(\d{1,2})\b"
    r"|\b(?:order|prince|fehlberg|shampine|karp|verner)(?: of)?[ :=]+(\d{1,2}) ?\((?:order )?\d",
    re.IGNORECASE,
)


#: What a name of an order may say besides, whichever method of a file it is of.
_ANY_METHOD = set(
    "rk rungekutta method scheme solver integrator stepper ode tableau table formula main primary "
    "global accuracy approximation convergence consistency p n k i get my the of this".split()
)


def _of_another(name: str, path: list[str]) -> bool:
    """Tell whether the order of a file is that of another method, by its name: ``heun_order``."""
    said = _ORDER_NAME.sub(" ", name).lower().replace("runge_kutta", "rungekutta")
    words = {x for x in re.split("[^a-z]+", said) if x}
    around = [x.lower() for x in path if len(x) > 2]  # a letter or two are in every word
    return not words <= _ANY_METHOD and not any(x in y or y in x for x in words for y in around)


def _own_order(block: Block, *, above: bool = True) -> int | None:
    """Return the order that a variable or function of a block, or of one around it, declares."""
    at: Block | None = block
    while at is not None:
        if above and at.user is not None and (order := _own_order(at.user)) is not None:
            return order
        own = {x.name: whole_number(x.value) for x in at.items if x.name in ("q", "p", "stages")}
        if at.kind == "record" and len(own) > 1 and own.get("q") in range(1, 15):
            return own["q"]  # p is that of the embedded weights
        found: set[int] = set()
        said = 0
        inner = [x for x in at.blocks if x.kind == "record" and x is not block]
        below = [y for x in inner for y in x.items] if at.parent else []
        for item in [*at.items, *below]:
            if not isinstance(item.value, Number):
                continue
            name = item.name.rpartition(".")[2]
            if not _ORDER_NAME.search(name) or _NOT_ORDER.search(name):
                continue
            if at is not block and at.parent is None and item.line > block.last + _LINES:
                continue  # far behind a function: of something else
            if at is not block and at.parent is None and _of_another(name, block.path()):
                continue
            value = item.value.value.as_fraction()
            if value is not None and value.denominator == 1 and 1 <= value <= 14:
                found.add(int(value))
                said += 1
        names = Counter(x.name for x in at.items if isinstance(x.value, list))
        many = max((n for x, n in names.items() if role_of(x)[1] == "A"), default=0)
        if len(found) == 1 and many <= said:  # else it is not said of which of many tables
            return found.pop()
        if found or not above:
            return None
        at = at.parent
    return None


def _two_orders(block: Block) -> tuple[int, int] | None:
    """Return a lower and a higher order that a block declares, of which row is not said."""
    found: dict[str, set[int]] = {"low": set(), "high": set()}
    for at in (block, *block.blocks):
        for item in at.items:
            word = re.search(r"(low|high)er_?order", item.name, re.IGNORECASE)
            if word and isinstance(item.value, Number):
                value = item.value.value.as_fraction()
                if value is not None and value.denominator == 1:
                    found[word[1].lower()].add(int(value))
    low, high = found["low"], found["high"]
    return (low.pop(), high.pop()) if len(low) == len(high) == 1 else None


#: Names of classes with one step.
_STEP_CLASS = re.compile(r"\w*(?:[Rr]unge_?[Kk]utta|RK)_?\d")


def declare(found: list[Table], remarks: Sequence[Remark]) -> None:
    """Give tables without a declared order the one that a comment above them or their name says.

    Such an order is doubtful; a table that does not have it is a question.
    """
    last = 0
    lines = {n for x in remarks for n in range(x.line, x.last + 1)}
    for table in found:
        if not table.unread and table.order is None:
            block = table.block
            first = table.line
            if block is not None and block.parent is not None:
                first = min(first, block.line)
            low = first - 1
            while low in lines:  # a comment of many lines
                low -= 1
            low = max(last, min(low, first - 14))
            near = [x for x in remarks if low < x.last and x.line <= table.line]
            said = [m for x in near for m in _SAID.finditer(x.text)]
            primary = [m for x in near for m in _PRIMARY.finditer(x.text)]
            orders = (
                {int(m[1]) for m in primary if m[1]}
                or {int(m[2]) for m in primary if m[2]}
                or {int(m[1] or m[2] or ORDINALS[m[3].lower()]) for m in said}
            )
            pair = bool(table.rows or table.errors)
            name = by_name(table.name, table.b[0], pair=pair)
            around = block.parent if block is not None and block.kind == "code" else None
            if around is not None and _STEP_CLASS.fullmatch(around.name) and (
                    table.source == STEP) and not (
                    name or any(x is not table and x.block is not None and x.block.parent is around
                                for x in found)):  # fmt: skip
                name = by_name(around.name, table.b[0], pair=pair)  # of a class with one step
            if len(orders) == 1 or name:
                said_by = "a comment" if len(orders) == 1 else "the name"
                table.order = orders.pop() if len(orders) == 1 else name
                table.sure, table.doubt = False, f"the order is read from {said_by}"
        last = max(last, table.last)
