"""Which entry of a table of a public code is wrong, and what would mend it.

A *correction* is one entry, or two of a row, that put right makes all conditions through the
declared order hold; it is found by Gauss-Newton steps on that entry alone, and given only where it
does. Beside it stand mistakes of other kinds: rows that are exchanged, an error that is added where
it is subtracted, an abscissa that is not the sum of its row, a weight of the estimate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, pairwise, product
from typing import Any, Protocol

from ..catalogue.claims import NYSTROM_ORDER, ORDER
from ..catalogue.entries import Entries
from ..errors import BudgetError, DataError
from ..exact import Ball, Exact, Scalar
from ..exact.decimals import SHORT, rounded_places
from ..exact.linalg import Matrix, Vector, row_sums
from ..method.families import splitting
from ..method.nystrom import nystrom
from ..method.rosenbrock import RosenbrockGLM
from ..system.budget import limited
from . import schemes
from .digits import rounded_up
from .schemes import Scheme, reach, scheme_of

#: Residuals: what doubles cannot see, relative to the largest entry; and what is no rounding at
#: all, in tables of decimals and of fractions.
FINE, COARSE, EXACT = 2e-14, 1e-8, 1e-10
#: Decimals of fewer digits are numbers as they stand; those of more may be rounded.
FEWEST = 5
#: Entries beyond this are not those of a method with one slip, and its powers leave doubles.
_LARGE = 1e20
#: A gap or a residual of trees through order 8 that says that c is A 1 but for rounding.
ROUNDING = 1e-9
#: Seconds of processor time for the search of a wrong entry.
SEARCH = 20.0


class Number(Protocol):
    """An entry: an exact number, and its digits after the point where it is a rounded decimal."""

    value: Exact
    places: int | None


@dataclass(frozen=True)
class Entry:
    """An entry of a method."""

    value: Exact
    places: int | None = None


class Table(Protocol):
    """A tableau as :mod:`glmref.audit` and :func:`tableau` give it: blocks by part."""

    kind: str
    A: Any
    b: Any
    c: Any
    order: int | None


@dataclass
class Tableau:
    """The tableau of a method, its blocks as in :class:`glmref.audit.table.Table`."""

    kind: str
    A: list[list[list[Entry]]]
    b: list[list[Entry]]
    c: list[list[Entry] | None]
    order: int | None = None


_Numbers = Sequence[Sequence[Number]]
_Slot = tuple[str, list[Any], int, int | None]


def _is_rounded(x: Number) -> bool:
    """Return whether a number is a decimal of eight digits or more after the point."""
    q = x.value.as_fraction()
    short = q is not None and q.denominator >= 10**7 and 10**SHORT % q.denominator == 0
    return x.places is not None or short


def _places(printed: Sequence[Number]) -> int:
    """Return the digits after the point of the longest decimal; 0 where one does not end."""
    most = 0
    for x in printed:
        q = x.value.as_fraction()
        while q is not None and q.denominator != 1 and most < SHORT:
            if 10**most % q.denominator == 0:
                break
            most += 1
        if q is None or 10**most % q.denominator:
            return 0
    return most


def _ball(x: Number) -> Ball:
    return x.value.ball()


def _matrix(rows: _Numbers) -> Matrix:
    return tuple(tuple(_ball(x) for x in row) for row in rows)


def vector(row: Sequence[Number]) -> Vector:
    """Return a row as balls."""
    return tuple(_ball(x) for x in row)


class Trial:
    """The numbers of a table, as the schemes take them; one entry may be replaced."""

    def __init__(self, table: Table) -> None:
        self.kind = table.kind
        self.A = [[list(row) for row in _matrix(A)] for A in table.A]
        self.b = [list(vector(b)) for b in table.b]
        self.c: list[list[Scalar] | None] = []
        self.gap = 0.0
        self.gap_row = self.gap_part = 0
        for k, given in enumerate(table.c or [None] * len(table.A)):
            c = None if given is None else list(vector(given))
            if c is not None and k < len(self.A) and table.kind not in ("nystrom", "shu-osher"):
                gaps = [
                    abs(complex(sum(row, Exact(0)) - x))
                    for row, x in zip(self.A[k], c, strict=True)
                ]
                if max(gaps) > self.gap:
                    self.gap, self.gap_row, self.gap_part = max(gaps), gaps.index(max(gaps)), k
                if max(gaps) < 1e-12:
                    c = None
            self.c.append(c)
        entries = [x for M in (*self.A, self.b) for row in M for x in row]
        self.scale = max([1.0, *(abs(complex(x)) for x in entries)])
        printed = [x for M in (*table.A, table.b) for row in M for x in row]
        rounded = any(_is_rounded(x) for x in printed)
        self.quadratic = False
        self.kick_first = False  # codes differ in which of a_1 and b_1 is the first step
        if table.kind == "splitting":
            drift = self.reached(table.order or 4)
            self.kick_first = True
            kick = self.reached(table.order or 4)
            self.kick_first = kick.to(COARSE) > drift.to(COARSE)
            if table.order and max(kick.to(COARSE), drift.to(COARSE)) < table.order:
                self.quadratic = True
                self.quadratic = self.reached(table.order).to(COARSE) >= table.order
        self.fine, self.coarse = FINE * self.scale, COARSE if rounded else EXACT
        places = _places(printed)
        if FEWEST <= places < SHORT:  # what the rounding of the last digit explains is no failure
            self.coarse = max(self.coarse, len(self.b[0]) * 10.0**-places)

    def scheme(self, weights: Sequence[Sequence[Scalar]] | None = None) -> Scheme:
        """Return the scheme whose order is requested, with other weights where they are given."""
        A = [tuple(map(tuple, M)) for M in self.A]
        b = [tuple(x) for x in (self.b if weights is None else weights)]
        if self.kind == "additive":
            return schemes.additive(list(zip(A, b, strict=True)), self.c)
        if self.kind == "rosenbrock":
            return scheme_of(RosenbrockGLM.of(A[0], A[1], b[0]))
        if self.kind == "nystrom":
            c = self.c[0]
            if c is None:
                raise DataError("a Nystrom method needs c")
            inner = A[1] if len(A) > 1 else None
            return scheme_of(nystrom(A[0], b[0], b[1], tuple(c), inner), nystrom=True)
        if self.kind == "glm":
            return schemes.general_linear(A[0], b)
        if self.kind == "low-storage":
            return schemes.low_storage(b[0], b[1], self.c[0] if self.c else None)
        if self.kind == "shu-osher":
            return schemes.shu_osher(A[0], A[1], self.c[0] if self.c else None)
        if self.kind in ("splitting", "composition"):
            pair = splitting(b[0], b[1], "p" if self.kick_first else "q")
            return scheme_of(pair, nystrom=self.quadratic)
        return schemes.runge_kutta(A[0], b[0], self.c[0] if self.c else None, apart=True)

    def reached(self, order: int, weights: Sequence[Scalar] | None = None) -> Any:
        """Return how far the conditions hold through an order, with other weights if given."""
        rows = None if weights is None else [weights] * len(self.b)
        return reach(self.scheme(rows), order, stop=0.5 * self.scale)

    def has_order(self, order: int, weights: Sequence[Scalar] | None = None) -> bool:
        """Return whether all conditions through an order hold, but for roundings."""
        got = self.reached(order, weights)
        return len(got.sizes) >= order and got.size(order) <= self.coarse

    def slots(self) -> Iterator[tuple[str, list[Any], int]]:
        """Yield entries that may be wrong: how they are called, where they are, and their index."""
        names = {"rk": ("a",), "additive": ("a", "a_implicit"), "rosenbrock": ("alpha", "gamma"),
                 "nystrom": ("a", "a_prime"), "shu-osher": ("alpha", "beta")}  # fmt: skip
        for name, M in zip(names.get(self.kind, ()), self.A, strict=False):
            for i, row in enumerate(M):
                for j, x in enumerate(row):
                    if complex(x) != 0 or j < i:
                        yield f"{name}[{i + 1}][{j + 1}]", row, j
        if self.kind == "shu-osher":  # the new value is the last row
            return
        words = {
            "splitting": ("a", "b"),
            "nystrom": ("b", "b_prime"),
            "low-storage": ("A", "B"),
        }.get(self.kind, ("b", "b_implicit"))
        for k, b in enumerate(self.b):
            if k and any(b is x for x in self.b[:k]):
                continue
            for j, _ in enumerate(b):
                yield f"{words[min(k, 1)]}[{j + 1}]", b, j


def _pairs(method: Trial) -> Iterator[tuple[str, list[Any], int, int]]:
    """Yield two entries of a row of A that may be wrong with the sum of the row right."""
    names = {"rk": "a", "additive": "a a_implicit", "nystrom": "a a_prime"}.get(method.kind, "")
    if len(method.b[0]) > 8:
        return
    for name, M in zip(names.split(), method.A, strict=False):
        for i, row in enumerate(M, 1):
            for k, j in combinations(range(len(row)), 2):
                if complex(row[j]) != 0 and complex(row[k]) != 0:
                    yield f"{name}[{i}][{k + 1}], {name}[{i}][{j + 1}]", row, j, k


def entry_of(x: Exact) -> Entry:
    """Return an entry with the digits that it has after the point, if it is a rounded decimal."""
    return Entry(x, rounded_places(x.as_fraction() or Fraction(0)))


def tableau(method: Any, order: int | None = None, times: Sequence[Any] | None = None) -> Any:
    """Return the tableau of a method that carries one value, ``None`` for others.

    Parameters
    ----------
    method : Method
        With exact coefficients.
    order : int, optional
        What is declared.
    times : sequence, optional
        Of an additive method where its parts are evaluated.
    """

    def row(values: Any) -> list[Entry]:
        return [entry_of(x) for x in values]

    def rows(matrix: Any) -> list[list[Entry]]:
        return [row(x) for x in matrix]

    if not method.is_exact or not method.is_one_step:
        return None
    if method.rosenbrock:
        return Tableau(
            "rosenbrock", [rows(method.alpha), rows(method.gamma)], [row(method.b)], [None], order
        )
    components = method.components
    A, b = [rows(c.A) for c in components], [row(c.B[0]) for c in components]
    if method.additive:
        c = [None if x is None else row(x) for x in times or [None] * len(A)]
        return Tableau("additive", A, b, c, order)
    document = method.document or {}
    if document.get("class") == "nystrom":
        reader = Entries(document, method.name)
        reader.read_constants()
        A = [rows(reader.matrix(document[x], x)) for x in ("A", "A_prime") if x in document]
        b = [row(reader.vector(document[x], x)) for x in ("b", "b_prime")]
        return Tableau("nystrom", A, b, [row(reader.vector(document["c"], "c"))], order)
    if len(components) > 1:
        return None
    c = method.abscissae_given
    if c is not None and not all(isinstance(x, Exact) for x in c):
        return None
    return Tableau("rk", A, b, [None if c is None else row(c)], order)


def suspected(method: Any, found: int) -> str:
    """Say what is wrong with the coefficients of a method, as far as its file tells.

    The row whose sum is not c, and the entry that gives the order that the file claims, or, where
    it claims none, the highest order.

    Parameters
    ----------
    method : Method
        As it was read.
    found : int
        Its order.
    """
    document, claims = method.document or {}, method.claims
    if "broken" in document or not method.is_exact:
        return ""
    c = getattr(method, "abscissae_given", None)
    said = "" if c is None else row_apart(method.A, c)
    declared = claims.get(NYSTROM_ORDER.key, claims.get(ORDER.key))
    orders = [declared] if declared is not None else list(range(8, found, -1)) if said else []
    entry = next((x for n in orders if n > found and (x := corrected(method, n))), "")
    return "; ".join(x for x in (said, entry) if x)


def corrected(method: Any, declared: int, times: Sequence[Any] | None = None) -> str:
    """Say which entry of a method is wrong and what it should be, ``""`` where none explains it.

    Parameters
    ----------
    method : Method
        Whose order is less than ``declared``.
    declared : int
        The order that it should have.
    times : sequence, optional
        See :func:`tableau`.
    """
    table = tableau(method, declared, times)
    entries = [x.value for part in (table.A if table else ()) for row in part for x in row]
    entries += [x.value for row in (table.b if table else ()) for x in row]
    if table is None or any(x.magnitude() > _LARGE for x in entries):
        return ""
    trial = Trial(table)
    found = at_row(trial, declared) or correction(trial, declared)
    return ", or ".join(f"{x['entry']} is {x['is']} and should be {x['should be']}" for x in found)


def row_apart(A: Matrix, c: Vector) -> str:
    """Say which row of A does not sum to c, ``""`` where all do; the order says what counts."""
    sums = row_sums(A)
    gaps = [abs(complex(x - y)) for x, y in zip(sums, c, strict=True)]
    worst = max(range(len(gaps)), key=gaps.__getitem__)
    if gaps[worst] == 0:
        return ""
    if gaps[worst] < ROUNDING:
        size = rounded_up(Fraction(repr(gaps[worst])))
        return f"row {worst + 1} of A sums to c[{worst + 1}] to {size}"
    return (
        f"row {worst + 1} of A sums to {complex(sums[worst]).real:.12g} and c[{worst + 1}] is "
        f"{complex(c[worst]).real:.12g}: the order is that on y' = f(t, y)"
    )


def at_row(method: Trial, declared: int) -> list[dict[str, str]]:
    """Return the one entry of the row whose sum is not c that gives the declared order."""
    if method.gap < COARSE:
        return []
    return _mended(method, declared, _short, lambda: method.has_order(declared))


def _mended(
    method: Trial, declared: int, text: Callable[[Scalar], str], good: Callable[[], bool]
) -> list[dict[str, str]]:
    """Return the one entry of the row whose sum is not c that gives a good order once it fits c."""
    k, part = method.gap_row, method.gap_part
    given = method.c[part] if method.kind in ("rk", "additive") and method.c else None
    if given is None or declared > 8:
        return []
    row, found = method.A[part][k], []
    for j, x in enumerate(row):
        if complex(x) == 0:
            continue
        row[j] = x + given[k] - sum(row, Exact(0))
        if good():
            name = "a_implicit" if part else "a"
            found.append(
                {"entry": f"{name}[{k + 1}][{j + 1}]", "is": text(x), "should be": text(row[j])}
            )
        row[j] = x
    return found if len(found) == 1 else []


def correction(method: Trial, declared: int) -> list[dict[str, str]]:
    """Return entries each of which, changed alone, gives the declared order.

    Pairs of entries in one row follow.
    """
    if method.kind == "glm":  # its rows of weights are sums of rows of B
        return []
    if method.kind == "composition":
        return weight(method, declared)
    better = abscissa(method, declared)
    if better or declared > 8 or len(method.b[0]) > 16:
        return better
    single = [(name, row, j, None) for name, row, j in method.slots()]
    meant = (method.kick_first, method.quadratic)
    ways = [meant]
    if method.kind == "splitting":  # with a slip in it, no order says how it is meant
        ways += [x for x in product((False, True), (False, True)) if x != meant]
    try:
        with limited(SEARCH):
            for way, slots in product(ways, (single, list(_pairs(method)))):
                method.kick_first, method.quadratic = way
                better += _changed(method, declared, slots)
                if better:
                    break
    except BudgetError:
        pass
    method.kick_first, method.quadratic = meant
    alike = [x for x in better if _entries(x["is"]) == _entries(x["should be"])]  # exchanged
    return (alike or better)[:3]


def _entries(said: str) -> list[str]:
    return sorted(said.split(", "))


def _changed(method: Trial, declared: int, slots: Sequence[_Slot]) -> Iterator[dict[str, str]]:
    """Yield the entries of a list, of those that may matter most, that give the declared order."""
    start = _residuals(method, declared)
    for name, row, j, k in _ranked(method, declared, start, slots)[:14]:
        before = [row[j], *([] if k is None else [row[k]])]
        after = _solved(method, declared, row, j, k)
        if after is not None:
            yield {
                "entry": name,
                "is": ", ".join(map(_short, reversed(before))),
                "should be": ", ".join(map(_short, reversed(after))),
            }


def weight(method: Trial, declared: int) -> list[dict[str, str]]:
    """Return the one weight of a composition that gives the declared order.

    It is the one on the other side of the palindrome, or what makes the sum of all of them 1.
    """
    before, found = method.b, []
    w = before[1][:-1]
    missing = Exact(1) - sum(w, Exact(0))
    for k, x in enumerate(w):
        other = len(w) - 1 - k
        new = x + missing if other == k else w[other]
        if abs(complex(new - x)) <= method.coarse:
            continue
        kicks = [*w[:k], new, *w[k + 1 :], before[1][-1]]
        half = [v / 2 for v in kicks[:-1]]
        method.b = [[half[0], *(u + v for u, v in pairwise(half)), half[-1]], kicks]
        if method.reached(declared).size(declared) <= method.coarse:
            found.append({"entry": f"w[{k + 1}]", "is": _long(x), "should be": _long(new)})
    method.b = before
    return found


def abscissa(method: Trial, declared: int) -> list[dict[str, str]]:
    """Return an abscissa that is not the sum of its row, where the sum gives the declared order."""
    if method.kind != "rk" or not method.c or method.c[0] is None:
        return []
    given, k = method.c[0], method.gap_row
    sums = [sum(row, Exact(0)) for row in method.A[0]]
    wrong = [i for i, x in enumerate(sums) if abs(complex(x - given[i])) > 1e-9]
    if wrong != [k]:
        return []
    method.c[0] = None
    got = method.reached(declared)
    method.c[0] = given
    if got.size(min(declared, len(got.sizes))) > method.coarse:
        return []
    return [{"entry": f"c[{k + 1}]", "is": _short(given[k]), "should be": _short(sums[k])}]


def digit(method: Trial, declared: int, size: float) -> list[dict[str, str]]:
    """Find the one entry of a row whose sum is not c that, corrected, satisfies all conditions.

    That is, their residuals, at most ``size``, shrink to a millionth; of entries of a rounded row
    each one mends the sum, and none the conditions of higher order.
    """
    if len(method.b[0]) > 16:
        return []
    small = 1e-6 * size
    return _mended(method, declared, _long, lambda: method.reached(declared).size(declared) < small)


def beside_weights(method: Trial, k: int) -> list[dict[str, str]]:
    """Return the entry in which a row differs from b, where all others agree: the row is b then."""
    pairs = list(enumerate(zip(method.A[0][k], method.b[0], strict=True)))
    unlike = [(j, x, y) for j, (x, y) in pairs if abs(complex(x - y)) > 1e-9]
    if len(unlike) != 1 or len(pairs) < 3:
        return []
    ((j, x, y),) = unlike
    return [{"entry": f"a[{k + 1}][{j + 1}]", "is": _short(x), "should be": _short(y)}]


def empty_rows(table: Table) -> list[str]:
    """Return rows of A that are zero though their abscissa is not."""
    if table.kind != "rk" or not table.c or table.c[0] is None:
        return []
    bad = [
        i + 1
        for i, (row, x) in enumerate(zip(table.A[0], table.c[0], strict=True))
        if complex(x.value) != 0 and all(complex(y.value) == 0 for y in row)
    ]
    return [f"the rows {bad[0]} to {bad[-1]} of A are zero"] if len(bad) > 2 else []


def enters_nothing(method: Trial, k: int) -> bool:
    """Return whether a stage has no weight and no other stage needs it, as the last one of FSAL."""
    column = [row[k] for i, row in enumerate(method.A[0]) if i != k]
    return method.kind == "rk" and all(complex(x) == 0 for x in (method.b[0][k], *column))


def unordered(method: Trial) -> list[str]:
    """Return whether the last row of A, a stage of the next step, has the weights in another order.

    No condition sees such a row: the stage has no weight (first same as last).
    """
    k = len(method.b[0]) - 1
    if method.kind != "rk" or k < 2 or not enters_nothing(method, k):
        return []
    row, b = ([complex(x).real for x in y[:k]] for y in (method.A[0][k], method.b[0]))

    def near(x: Sequence[float], y: Sequence[float]) -> bool:
        return all(abs(p - q) <= method.coarse for p, q in zip(x, y, strict=True))

    if near(row, b) or not near(sorted(row), sorted(b)):
        return []
    return [f"row {k + 1} of A holds the weights b in another order, and enters nothing else"]


def embedded(method: Trial, row: Sequence[Scalar], order: int, least: int) -> list[str]:
    """Return what gives an embedded row a higher order: two weights exchanged, or an entry of A.

    Nothing declares its order; only where one change gives the next order below that of b, it is
    asked about.
    """
    if method.kind != "rk" or least > 8 or len(row) > 16 or order < 1:
        return []
    said = f"the embedded row has order {order}, and order {least}"
    for i, j in combinations(range(len(row)), 2):
        other = list(row)
        other[i], other[j] = row[j], row[i]
        if complex(row[i]) != complex(row[j]) and method.has_order(least, other):
            return [f"{said} with its entries {i + 1} and {j + 1} exchanged"]
    for k, stage in enumerate(method.A[0]):
        if not enters_nothing(method, k):
            continue  # b has its order with the others
        for i, j in combinations(range(len(stage)), 2):
            if complex(stage[i]) == complex(stage[j]):
                continue
            stage[i], stage[j] = stage[j], stage[i]
            good = method.has_order(least, row)
            stage[i], stage[j] = stage[j], stage[i]
            if good:
                return [f"{said} with a[{k + 1}][{i + 1}] and a[{k + 1}][{j + 1}] exchanged"]
    return []


def one_weight(method: Trial, row: Sequence[Scalar], least: int) -> list[str]:
    """Return the weight of an embedded row that gives its order with the other sign.

    Or with any value, where the order is 3 or more: one number satisfies all its conditions.
    """
    missing, found = Exact(1) - sum(row, Exact(0)), []
    for k, x in enumerate(row):
        turned = abs(complex(x + x + missing)) <= method.coarse  # the sum is 1 then
        order = max(2 if turned else 3, least)
        if method.has_order(order, [*row[:k], x + missing, *row[k + 1 :]]):
            found.append(f"with weight {k + 1} = {_short(x + missing)} in place of {_short(x)} its "
                         f"order is {order}")  # fmt: skip
    return found if len(found) == 1 else []


def one_row_apart(method: Trial) -> bool:
    """Return whether one row of A, not the first, differs from c and all others sum to it.

    Methods that choose c apart from A 1, as Lobatto IIIB, do so in several rows or in the first.
    """
    c = method.c[0] if method.kind == "rk" and method.c else None
    if c is None or method.gap_row == 0 or method.gap <= method.coarse:
        return False
    gaps = [abs(complex(sum(row, Exact(0)) - x)) for row, x in zip(method.A[0], c, strict=True)]
    return sum(x > method.coarse for x in gaps) == 1


def exchanged(method: Trial, error: Sequence[Scalar], declared: int) -> list[str]:
    """Return whether b minus or plus the weights of the error estimate has the declared order."""
    b = method.b[0]
    error = [*error, *([Exact(0)] * (len(b) - len(error)))]
    if len(error) != len(b):
        return []
    for word, sign in (("minus", -1), ("plus", 1)):
        row = [x + sign * y for x, y in zip(b, error, strict=True)]
        if method.has_order(declared, row):
            return [
                f"b {word} the error weights has order {declared}: b holds the embedded weights"
            ]
    return []


def exchanged_weights(method: Trial, error: Sequence[Scalar]) -> list[str]:
    """Return which two of the weights b - e, of an estimate e, are exchanged.

    With all of e they have order 1, and so exchanged 3 or more.
    """
    b = method.b[0]
    row = [x - y for x, y in zip(b, error, strict=False)]
    rest = error[len(b) :]
    if method.kind != "rk" or not 3 < len(row) == len(b) <= 16 or any(map(complex, rest)):
        return []
    if method.reached(2, row).to(method.coarse) != 1:
        return []
    for i, j in combinations(range(len(row)), 2):
        other = list(row)
        other[i], other[j] = row[j], row[i]
        if complex(row[i]) != complex(row[j]) and method.has_order(3, other):
            said = f"with error weights {i + 1} and {j + 1} made of each other's number"
            return [f"{said} the embedded row has order 3, and 1 as they are"]
    return []


def mirrored(method: Trial, row: Sequence[Scalar], declared: int) -> list[str]:
    """Return whether 2 b minus a row has its order: the error was added where it is subtracted."""
    other = [2 * x - y for x, y in zip(method.b[0], row, strict=True)]
    if not method.has_order(declared, other):
        return []
    return [f"2 b minus this row has order {declared}: its difference from b has the wrong sign"]


def estimate(method: Trial, error: list[Scalar]) -> list[str]:
    """Find the error weight that, changed so that the sum is 0, gives the best embedded row."""
    b = method.b[0]
    error += [Exact(0)] * (len(b) - len(error))
    if len(error) != len(b):
        return []
    total = sum(error, Exact(0))
    found: list[tuple[int, int, Scalar]] = []
    for k, x in enumerate(error):
        changed = [*error[:k], x - total, *error[k + 1 :]]
        for sign in (-1, 1):
            row = [p + sign * q for p, q in zip(b, changed, strict=True)]
            found.append((method.reached(5, row).to(method.coarse), k, x - total))
    order, k, value = max(found, key=lambda x: x[0])
    if order < 2 or len({i for n, i, _ in found if n == order}) > 1:
        return []
    said = f"with error weight {k + 1} = {_short(value)} in place of {_short(error[k])}"
    return [f"{said} the sum is 0 and the embedded row has order {order}"]


def _residuals(method: Trial, order: int) -> list[float]:
    got = reach(method.scheme(), order)
    return [complex(x).real for level in got.residuals for x in level.values()]


def _ranked(
    method: Trial, declared: int, start: list[float], slots: Sequence[_Slot]
) -> list[_Slot]:
    """Return slots by what the best step along each leaves of the residuals."""
    size = sum(x * x for x in start)
    found: list[tuple[float, int]] = []
    small = Fraction(1, 1024)
    for n, (_, row, j, k) in enumerate(slots):
        before = list(row)
        _shift(row, j, k, small)
        moved = _residuals(method, declared)
        row[:] = before
        slope = [(y - x) * 1024 for x, y in zip(start, moved, strict=True)]
        norm = sum(x * x for x in slope)
        if norm:
            step = sum(x * y for x, y in zip(start, slope, strict=True)) / norm
            found.append((size - step * step * norm, n))
    return [slots[n] for _, n in sorted(found)]


def _solved(
    method: Trial, declared: int, row: list[Any], j: int, k: int | None
) -> list[Scalar] | None:
    """Find the entries that satisfy all conditions, by secant Gauss-Newton steps along one slot."""
    before = list(row)

    def at(x: Scalar) -> list[float]:
        row[:] = before
        _shift(row, j, k, x)
        return _residuals(method, declared)

    try:
        x0, x1 = Exact(0).ball(), Exact(Fraction(1, 997)).ball()
        r0 = at(x0)
        for _ in range(18):
            r1 = at(x1)
            if max(map(abs, r1)) < 1e-15 * method.scale:
                return [row[j], *([] if k is None else [row[k]])]
            width = complex(x1 - x0).real
            slope = [(b - a) / width for a, b in zip(r0, r1, strict=True)] if width else []
            norm = sum(x * x for x in slope)
            step = sum(a * b for a, b in zip(r1, slope, strict=True)) / norm if norm else 1e9
            if abs(step) > 50 * method.scale:
                return None
            x0, r0 = x1, r1
            x1 = (x1 - Fraction(step)).midpoint()
        return None
    finally:
        row[:] = before


def _shift(row: list[Any], j: int, k: int | None, step: Scalar | Fraction) -> None:
    row[j] = row[j] + step
    if k is not None:
        row[k] = row[k] - step


def _short(x: Scalar) -> str:
    """Return a number as a fraction where a short one is near enough, else as a decimal."""
    value = Fraction(x.ball().decimal_text(60)) if complex(x) else Fraction(0)
    for bound in (100, 10**4, 10**6, 10**9):
        near = value.limit_denominator(bound)
        if abs(near - value) < Fraction(1, 10**15) / max(1, bound // 10**4):
            return str(near)
    return f"{float(value):.16g}"


def _long(x: Scalar) -> str:
    """Return a number with the digits of a double."""
    return f"{complex(x).real:.17g}"
