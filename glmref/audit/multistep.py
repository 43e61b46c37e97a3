"""Linear multistep methods: lists of alpha and beta, rows of Adams methods, sums of slopes.

Such a method has no tableau; its order, or the one coefficient that gives the full order, is said.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

from ..exact import Exact
from .collecting import Block, Collector, _partner
from .entries import LOOSE, Array, Found, Words, last_letter
from .lexer import Language, Token
from .steps import Atoms, Form, Names, form
from .table import Table
from .values import Number, Unread, size

MULTISTEP = Words(
    "adams bashforth moulton nordsieck",
    {
        "step": r"multi.?step",
        "ab": r"ab(?<![a-z]ab)_?\d",
        "am": r"am(?<![a-z]am)_?\d",
        "bdf": r"bdf(?<![a-z]bdf)",
        "lmm": r"\blmm\b",
        "backward": r"backward.?diff",
    },
)
_ADAMS = re.compile(r"adams|bashforth|moulton|(?<![a-z])(?:ab|am)_?\d", re.IGNORECASE)


def multistep(block: Block, made: list[Array], text: str) -> Iterator[Found]:
    """Return alpha and beta of linear multistep methods, and rows of Adams methods."""
    about = " ".join([*block.path(), block.called])
    pairs = [*_in_pairs(made, about, text), *_nordsieck(made, about, text)]
    if pairs:
        yield from pairs
        return
    made = [_divided(x, block) for x in made]
    named = {last_letter(x): x for x in made if x.flat}
    if {"alpha", "beta"} <= named.keys():
        a, b = named["alpha"], named["beta"]
        if len(a.value) > 2 and abs(sum(map(size, a.value))) < LOOSE and MULTISTEP.search(
            f"{about} {a.name}"
        ):  # fmt: skip
            yield _of_steps(block, [a, b], [(a.value, b.value)], None)
            return
    rate = next((x for x in block.items if x.name in ("beta", "β", "b")
                 and isinstance(x.value, Number)), None)  # fmt: skip
    a = named.get("alpha", named.get("a"))
    if rate is not None and a is not None and MULTISTEP.search(f"{about} {a.name}"):
        yield _of_differences(a, rate.value)
        return
    for x in made:
        if not MULTISTEP.search(f"{about} {x.name}"):
            continue
        rows = [x.value] if x.flat else [r for r in x.value if isinstance(r, list)]
        rows = [_trimmed(r) for r in rows if r]
        adams = _ADAMS.search(f"{about} {x.name}") is not None
        broken = [y for r in rows for y in r if size(y) % 1 != 0]
        small = all(abs(size(y)) < 0.1 for y in broken)  # these may be tolerances
        if len(broken) < 2 or small or any(not isinstance(y, Number) for r in rows for y in r):
            continue
        values = [[size(y) for y in r] for r in rows]
        sums = [abs(sum(r) - 1) < LOOSE or (min(r) > 0 and abs(abs(sum(_alternating(r))) - 1)
                                            < LOOSE) for r in values]  # fmt: skip
        steps = _of_steps(block, [x], [([], r) for r in rows], 1) if adams else None
        one = max(map(len, rows), default=0) > 2  # of two entries one can always be mended
        slopes = [r for r in rows if abs(sum(map(size, r))) < LOOSE]  # h f is a difference
        if steps and (2 * sum(sums) >= len(sums) or (one and "question" in steps.table.unread)):
            yield steps
        elif not adams and 2 * len(slopes) > len(rows) and len(rows[-1]) > 2:
            for row in rows:
                yield _of_differences(replace(x, value=row), Number(Exact(1)))
        elif not adams and len(rows) == 1 and len(rows[0]) > 3 and (
                found := _of_differences(replace(x, value=rows[0]), Number(Exact(1)))
        ).table.unread.startswith("question"):  # fmt: skip
            yield found
        else:
            table = Table(x.name, x.line, last=x.last, general=True)
            table.unread = "the coefficients of a multistep method, in a form that is not read"
            yield Found(table, [x])


def _in_pairs(made: list[Array], about: str, text: str) -> Iterator[Found]:
    """Yield the methods of lists with one slope: rows alpha beside a list beta, or [alpha, beta].

    A source about multistep methods may say so where neither name does.
    """
    for x in made:
        beta = next((y for y in made if y.flat and last_letter(y) == "beta"
                     and len(y.value) == len(x.value)), None)  # fmt: skip
        if MULTISTEP.search(f"{about} {x.name}") and len(x.value) == 2:
            row, rate = x.value
            if isinstance(row, list) and row and isinstance(rate, Number):
                yield _of_differences(replace(x, value=row), rate)
        elif beta is not None and last_letter(x) == "alpha" and MULTISTEP.search(text):
            rows = [_trimmed(r) if isinstance(r, list) else [] for r in x.value]
            if rows[0] and all(len(p) + 1 == len(q) for p, q in pairwise(rows)):
                for row, rate in zip(rows, beta.value, strict=True):
                    yield _of_differences(replace(x, value=row), rate)


_DENOMINATORS = re.compile(r"(.*?)_?den(?:om(?:inator)?)?s?", re.IGNORECASE)


def _divided(x: Array, block: Block) -> Array:
    """Return coefficients over the denominator, or those of their rows, that stand apart."""
    for item in block.items:
        m, below = _DENOMINATORS.fullmatch(item.name), item.value
        if m is None or m[1].lower() not in ("", x.name.lower()):
            continue
        if isinstance(below, Number) and x.flat and size(below) > 1:
            return replace(x, value=[_over(y, below) for y in x.value])
        if isinstance(below, list) and len(below) == len(x.value) and not x.flat:
            pairs = [(r, d) for r, d in zip(x.value, below, strict=True)
                     if isinstance(r, list) and isinstance(d, Number) and size(d) > 0]  # fmt: skip
            return replace(x, value=[[_over(y, d) for y in r] for r, d in pairs])
    return x


def _over(x: Any, below: Number) -> Any:
    """Return an entry whose denominator stands apart."""
    if not isinstance(x, Number):
        return x
    found = x.of(x.value / below.value, below)
    found.place = x.place
    return found


def _nordsieck(made: list[Array], about: str, text: str) -> Iterator[Found]:
    """Yield the vectors l that correct a Nordsieck vector, known by their second entries, 1.

    Where l(x) = sum l_j x^j, the derivative of that of an Adams method is (1 + x) (1 + x/2) ..
    (1 + x/(q - 1)), and its value at 0 the coefficient of the new slope; of a BDF l(x) is
    (1 + x) (1 + x/2) .. (1 + x/q), over its derivative at 0: Gear (1971), chapter 9.
    """
    for x in made:
        rows = [r for r in x.value if isinstance(r, list) and len(r) > 1]
        if len(rows) < 3 or any(size(r[1]) != 1 for r in rows) or "nordsieck" not in text.lower():
            continue
        table = Table(x.name, x.line, last=x.last, general=True)
        wrong: list[str] = []
        known = 0
        for row in rows:
            given = [y.value.as_fraction() if isinstance(y, Number) else None for y in row]
            both = (_vector(len(row) - 1, adams=x) for x in (True, False))
            differ = [[k for k, p in enumerate(given) if p != v[k]] for v in both]
            apart = min(differ, key=len)
            best = _vector(len(row) - 1, adams=apart is differ[0])
            known += not apart
            wrong += [
                f"entry {k + 1} of a row of {len(row)} is {given[k]} and should be {best[k]}"
                + (f" (line {row[k].place[0]})" if row[k].place else "")
                for k in apart
                if len(apart) == 1
            ]
        table.unread = f"multistep: {known} of {len(rows)} vectors are those of Gear"
        if wrong and 2 * known >= len(rows):
            table.unread = f"question: a multistep method: {'; '.join(wrong)}"
        yield Found(table, [x])


def _vector(q: int, *, adams: bool) -> list[Fraction]:
    """Return l_0, .., l_q of an Adams method or of a BDF."""
    products = [[Fraction(1)]]  # (1 + x) .. (1 + x/n)
    for n in range(1, q + 1):
        last = [*products[-1], Fraction(0)]
        products.append([y + (last[k - 1] / n if k else 0) for k, y in enumerate(last)])
    if not adams:
        return [y / products[q][1] for y in products[q]]
    first = sum((-(y * (-1) ** (k + 1)) / (k + 1) for k, y in enumerate(products[q])), Fraction(0))
    return [first, *(y / (k + 1) for k, y in enumerate(products[q - 1]))]


def _of_differences(x: Array, rate: Number) -> Found:
    """Return a method with one slope, at the new step: sum alpha_j y_j = h beta f_n.

    The coefficient 1 of y_n may stand among the others, which may have the other sign.
    """
    table = Table(x.name, x.line, last=x.last, general=True)
    try:
        given, slope = [_fraction(y) for y in x.value], _fraction(rate)
    except Unread as error:
        table.unread = str(error)
        return Found(table, [x])
    forms: list[tuple[tuple[int, bool, int], list[Fraction], list[Fraction]]] = []
    for turned, more, sign in product((False, True), (0, 1), (1, -1)):
        row = [sign * y for y in (given[::-1] if turned else given)]
        alpha = [*row, Fraction(1)] if more else row
        beta = [*([Fraction(0)] * (len(alpha) - 1)), slope]
        good = sum(y == 0 for y in _conditions(alpha, beta, len(alpha) - 1))
        forms.append(((good, alpha[-1] == 1, -more), alpha, beta))
    forms.sort(key=lambda y: y[0], reverse=True)
    _, alpha, beta = forms[0]
    reached = _order(alpha, beta)
    table.unread = f"a linear multistep method; by its conditions of order {reached}"
    if reached >= len(alpha) - 1:
        return Found(table, [x])
    for (_, alpha, beta), k in product(forms, range(len(given))):
        full = len(alpha) - 1
        moved = _conditions([*alpha[:k], alpha[k] + 1, *alpha[k + 1 :]], beta, full)
        steps = [(-v, u - v) for v, u in zip(_conditions(alpha, beta, full), moved, strict=True)]
        found = {v / w for v, w in steps if w}
        if full > 1 and len(found) == 1 and all(v == 0 for v, w in steps if not w):
            at = next((y.place for y, z in zip(x.value, given, strict=True)
                       if abs(z) == abs(alpha[k]) and y.place), None)  # fmt: skip
            line = f" (line {at[0]})" if at else ""
            table.unread = (
                f"question: a multistep method: the coefficient {alpha[k]} of step {k - full} "
                f"should be {alpha[k] + found.pop()}{line}"
            )
            break
    return Found(table, [x])


def _trimmed(row: list[Any]) -> list[Any]:
    live = [k for k, x in enumerate(row) if size(x) != 0] or [0]
    return row[live[0] : live[-1] + 1]


def _conditions(alpha: list[Fraction], beta: list[Fraction], order: int) -> list[Fraction]:
    """Return sum alpha_j j^q - q sum beta_j j^(q-1) for q through an order: Dahlquist (1956)."""
    return [
        sum((x * j**q for j, x in enumerate(alpha)), Fraction(0))
        - q * sum((x * j ** (q - 1) for j, x in enumerate(beta) if q), Fraction(0))
        for q in range(order + 1)
    ]


def _forms(alpha: list[Fraction], beta: list[Fraction]) -> Iterator[tuple[Any, Any]]:
    """Yield alpha and beta from the oldest step on, as a code may mean them."""
    for turned, implicit in product((False, True), (False, True)):
        b = beta[::-1] if turned else beta
        if alpha:
            if not implicit:
                yield (alpha[::-1] if turned else alpha), b
        elif implicit:
            yield [*([Fraction(0)] * (len(b) - 2)), Fraction(-1), Fraction(1)][-len(b) :], b
        else:
            yield [*([Fraction(0)] * (len(b) - 1)), Fraction(-1), Fraction(1)], [*b, Fraction(0)]


def _of_steps(block: Block, arrays: list[Array], rows: Any, least: int | None) -> Found:
    """Return a table without a tableau: its order, or the one entry that gives the full order."""
    table = Table(arrays[0].name, arrays[0].line, last=arrays[-1].last, general=True)
    said: list[str] = []
    wrong: list[str] = []
    for alpha, beta in rows:
        try:
            a, b = ([_fraction(x) for x in v] for v in (alpha, beta))
        except Unread as error:
            table.unread = str(error)
            return Found(table, arrays)
        best = max(_order(p, q) for p, q in _forms(a, b))
        full = len(b) if least else None
        if full and min(b) > 0:  # the signs of an Adams method alternate, and are the step's here
            signed = (_alternating(b), _alternating(b[::-1]))
            best = max(best, *(_order(p, q) for x in signed for p, q in _forms(a, x)))
        said.append(str(best))
        if full and best < full and len(b) > 1:
            found = _entry(a, b, beta, full) or _over_another(a, b, beta, full)
            wrong += [found] if found else []
    table.unread = f"a linear multistep method; by its conditions of order {', '.join(said)}"
    if wrong:
        table.unread = f"question: a multistep method: {'; '.join(wrong)}"
    return Found(table, arrays)


def _alternating(row: list[Any]) -> list[Any]:
    """Return a row of which every other entry has the other sign."""
    return [-x if k % 2 else x for k, x in enumerate(row)]


def _fraction(x: Any) -> Fraction:
    value = x.value.as_fraction() if isinstance(x, Number) else None
    if value is None:
        raise Unread("an entry of a multistep method is no fraction")
    return value


def _order(alpha: list[Fraction], beta: list[Fraction]) -> int:
    gaps = _conditions(alpha, beta, 2 * len(beta) + 1)
    return next((q for q, x in enumerate(gaps) if abs(x) > 1e-9), len(gaps)) - 1


def _over_another(alpha: list[Fraction], beta: list[Fraction], given: Any, full: int) -> str:
    """Say with which sum a row of fractions has the full order, where it is another one."""
    total = sum(beta)
    if not total or total == 1 or all(x.denominator == 1 for x in beta):
        return ""  # whole numbers are divided elsewhere
    row = [x / total for x in beta]
    if max(_order(p, q) for p, q in _forms(alpha, row)) < full or full < 3:
        return ""
    at = given[0].place
    line = f" (line {at[0]})" if at else ""
    return f"the coefficients sum to {total}, not to 1; divided by it their order is {full}{line}"


def _entry(alpha: list[Fraction], beta: list[Fraction], given: Any, full: int) -> str:
    """Name the one entry of beta with which all conditions through an order hold."""
    for k, x in enumerate(beta):
        for turned, implicit in product((False, True), (False, True)):
            if alpha and implicit:
                continue
            shifts = []
            for probe in (Fraction(0), Fraction(1)):
                changed = [*beta[:k], x + probe, *beta[k + 1 :]]
                forms = list(_forms(alpha, changed))
                n = turned if alpha else 2 * turned + implicit
                shifts.append(_conditions(*forms[n], full))
            slopes = [(v, u - v) for v, u in zip(*shifts, strict=True)]
            steps = {-v / w for v, w in slopes if w}
            if len(steps) == 1 and all(v == 0 for v, w in slopes if not w):
                at = given[k].place
                line = f" (line {at[0]})" if at else ""
                return (
                    f"entry {k + 1} of a row of {len(beta)} is {x} and should be "
                    f"{x + steps.pop()}{line}"
                )
    return ""


# --- sums in the arithmetic of a step -------------------------------------------------------------


@dataclass
class _Sums(Names):
    """A function carried out for the sums that it sets names to, or returns."""

    sums: list[Number] = field(default_factory=list)

    def fold(self, row: Sequence[Token], reader: type[Atoms] = Atoms) -> Any:
        """Return the value of an expression, in which ``f[n - 1]`` and ``f(n - 1)`` are names."""
        x = super().fold(_indexed(row, self.collector.language), reader)
        if isinstance(x, Number) and isinstance(x.value, Form) and len(x.value.terms) > 1:
            x.place = (row[0].line, " ".join(y.text for y in row)[:80])
            self.sums.append(x)
        return x


def _indexed(row: Sequence[Token], language: Language) -> list[Token]:
    """Return tokens in which a name with a subscript of names and signs is one name."""
    found: list[Token] = []
    k = 0
    while k < len(row):
        x, k = row[k], k + 1
        opens = ("[", "(") if language.calls_index else ("[",)
        while x.kind == "name" and k < len(row) and row[k].text in opens:
            end = _partner(row, k)
            inside = row[k + 1 : end]
            if len(inside) not in (1, 3) or inside[0].kind != "name":
                break
            x, k = x._replace(text=x.text + "".join(y.text for y in inside)), end + 1
        found.append(x)
    return found


def sums_of(block: Block, row: Sequence[Token], collector: Collector) -> Iterator[Table]:
    """Yield the multistep methods whose numbers stand in sums: ``y + h*(3*f0 - f1)/2``.

    Slopes are what a step multiplies; one of them beside several states is a BDF. Where all their
    coefficients are positive and sum to 1, the sum may be that of a Runge-Kutta method.
    """
    step = _Sums(block, collector, "", 0, -1, set())
    step.follow(row)
    said = MULTISTEP.search(" ".join([*block.path(), block.own]))
    for x in step.sums:
        terms = form(x).terms
        products = [v for key, v in terms.items() if len(key) > 1]
        states = [v for key, v in terms.items() if len(key) == 1]
        names = [set(key) for key in terms if len(key) > 1]
        common = set.intersection(*names) if names else set()
        if not common or () in terms or not x.place:
            continue
        rest = ["".join(sorted(y - common)) for y in names]
        alike = len({re.sub(r"\W|\d|_", "", y)[:1] for y in rest}) < max(2, len(rest) - 1)
        array = Array(block.own or block.name, [], x.place[0], x.place[0], 0)
        array.value = [_placed(Number(v), x) for v in (products if len(products) > 1 else states)]
        values = [size(y) for y in array.value]
        if len(products) > 1 and alike and min(values) < 0 and [complex(y) for y in states] in (
            [], [1]):  # fmt: skip
            found = _of_steps(block, [array], [([], array.value)], 1 if len(values) > 2 else None)
        elif said and len(products) == 1 and len(states) > 1:
            found = _of_differences(array, Number(products[0]))
        else:
            continue
        # a name says that the others are, too; where their weights do not sum to 1, one is wrong
        if (said and len(values) > 2) or not found.table.unread.endswith(" of order 0"):
            yield found.table


def _placed(x: Number, other: Number) -> Number:
    x.place = other.place
    return x
