"""Methods that are no matrix with weights: IMKG, Rosenbrock, low storage, splittings, multistep.

They are looked for before matrices, so that a part of one is not taken for a Runge-Kutta method.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import pairwise
from math import isqrt
from typing import Any

from ..exact import Exact
from ..prove.schemes import reach
from ..prove.wrong_entry import Trial
from .collecting import Block
from .entries import LOOSE, Array, Found, Words, bare_name, last_letter, role_of
from .folding import flattened
from .multistep import MULTISTEP, multistep
from .table import ZERO, Rows, Table, as_composition, of_weights
from .values import Number, Unread, size, whole_number

_SPLITTING = Words(
    "symplectic splitting drift kick yoshida mclachlan hamiltonian",
    {"leap": "leap.?frog", "ruth": "ruth(?<![a-z]ruth)", "hoover": "nos[eé].?hoover"},
)
_STORAGE = Words("williamson carpenter runge", {"storage": "low.?storage", "2n": r"\b2n\b"})
#: Names of the first and second steps of a splitting.
_FLOWS = (("a", "b"), ("c", "d"), ("a", "ahat"), ("drift", "kick"), ("drifts", "kicks"))
#: A call of this name has a matrix of one row, which is no list of steps.
_BUTCHER = re.compile(r"butcher", re.IGNORECASE)
#: Names of states: steps only where both sum to 1, or the name says that these are coefficients.
_STATES = (("x", "v"), ("x", "p"), ("q", "p"), ("r", "v"), ("pos", "vel"), ("t", "v"))
#: Steps under a letter and a number, ``A4`` or ``ruth_c3``.
_NUMBERED = re.compile(r"(|.*_)([a-z])_?(\d+)")


def only_numbers(*arrays: Array) -> None:
    """Raise the reason why an entry of arrays is not a number."""
    for x in arrays:
        if x.lost:
            raise Unread(f"completed at run time: {x.lost}")
        for y in flattened(x.value):
            if not isinstance(y, Number):
                at = f" (line {y.line})" if isinstance(y, Unread) and y.line else ""
                raise Unread(f"an entry of {x.name or 'an array'} is not read: {y}{at}")


def _stem(x: Array) -> str:
    said = bare_name(x)
    return said[: len(said) - len(last_letter(x))].lower()


def others(block: Block, made: list[Array], *, text: str) -> list[Found]:
    """Return the tables of a block that are of these kinds.

    Parameters
    ----------
    block : Block
    made : list of Array
        The arrays of the block.
    text : str
        The source, whose words say what it is about.
    """
    found: list[Found] = []
    matrices = [x for x in made if not x.flat]
    vectors = [x for x in made if x.flat]
    nystrom = partial(_nystrom, text=text)
    for rule in (_imkg, _general_linear, _rosenbrock, _transformed, _shu_osher, nystrom, _dense):
        found += rule(block, matrices, vectors)
    steps = [x for x in matrices if len(x.value) > 2 and {*map(_length, x.value)} == {2}]
    if _SPLITTING.search(text) and not any(x.role == "b" for x in made):
        steps += [x for x in matrices if _timed(x)]
    pairs = [y for x in steps for y in _columns(x)]
    vectors += pairs if len(steps) == len(matrices) else []
    three = list(_registers(vectors, matrices))
    if three:
        return three
    if {"a0", "a1", "b0", "b1"} <= {x.name.lower() for x in matrices}:
        table = Table("", matrices[0].line, general=True, last=matrices[-1].last)
        table.unread = "a method for stochastic equations, which is not read"
        return [Found(table, made)]
    if len(matrices) == len(steps):
        found += _two_slopes(vectors)
        found += [x for x in _low_storage(vectors) if x.table.loose > 1 or _STORAGE.search(text)]
        steps = [] if found or _BUTCHER.search(block.called) else list(_splitting(vectors))
        for x in steps:
            good = x.table.loose > 1 or _SPLITTING.search(text)
            x.table.sure = good
            found += [x] if good or _go_back(x.arrays) else []
        if vectors and not found and (_SPLITTING.search(text) or _WEIGHTS.search(text)):
            found += list(_mirrored(vectors, text)) or _compositions(block, vectors, text)
    elif not found and _SPLITTING.search(text):  # lists of pairs beside others
        found += _splitting(pairs)
    if not found:
        found += multistep(block, made, text)
    return found


def _go_back(steps: Sequence[Array]) -> bool:
    """Return whether steps of two lists both go back, and those of one sum to 1, to the digit."""
    gaps = [abs(sum(map(size, x.value)) - 1) for x in steps]
    back = all(len(x.value) > 2 and min(map(size, x.value)) < 0 for x in steps)
    return back and min(gaps) < 1e-9 and max(gaps) < 0.5 and len({x.at for x in steps}) > 1


def _length(row: Any) -> int:
    return len(row) if isinstance(row, list) else 0


def _columns(x: Array) -> list[Array]:
    """Return the steps of two flows that a list of pairs holds."""
    return [
        Array(f"{x.name}_{letter}", [row[k] for row in x.value], x.line, x.last, x.at, x.lost)
        for k, letter in enumerate("ab", _length(x.value[0]) - 2)
    ]


def _timed(x: Array) -> bool:
    """Return whether rows have the steps of two flows, each with the sum 1, behind a time."""
    if len(x.value) < 3 or {*map(_length, x.value)} != {3}:
        return False
    if any(size(row[1]) and size(row[2]) for row in x.value):  # of three flows
        return False
    return all(_one(sum(map(size, column))) for column in list(zip(*x.value, strict=True))[1:])


def _square(x: Array, *, strict: bool = False) -> Rows | None:
    """Return a lower triangular matrix (s, s), padded with zeros."""
    rows, s = x.value, len(x.value)
    if any(not isinstance(r, list) or len(r) > s or any(isinstance(y, list) for y in r)
           for r in rows):  # fmt: skip
        return None
    full = [[*r, *([ZERO] * (s - len(r)))] for r in rows]
    above = all(size(y) == 0 for i, r in enumerate(full) for y in r[i + (not strict) :])
    return full if above and s > 1 else None


def _guarded(name: str, line: int, arrays: list[Array], make: Any) -> Iterator[Found]:
    table = Table(name, line, general=True, last=max(x.last for x in arrays))
    try:
        only_numbers(*arrays)
        make(table)
    except Unread as error:
        table.unread = str(error)
    else:
        reached = reach(Trial(table).scheme(), 3, stop=1.0)
        table.loose = reached.to(LOOSE)
    yield Found(table, arrays)


# --- additive methods by rows of numbers ----------------------------------------------------------


def imkg(rows: list[list[Any]]) -> tuple[list[Rows], list[list[Any]]]:
    """Return the explicit and the implicit A (s, s) of an IMKG method, and b: their last rows.

    Its numbers are a and a^ below the diagonals, d^ on that of the implicit part, and, where it is
    given, b in the first columns: Steyer et al. (2019), "Efficient IMEX Runge-Kutta methods for
    nonhydrostatic dynamics".
    """
    below, hat, diagonal = rows[:3]
    s = len(hat) + 1
    first = rows[3] if len(rows) == 4 else [ZERO] * (s - 2)
    parts = []
    for entries, own in ((below, []), (hat, diagonal)):
        A = [[ZERO] * s for _ in range(s)]
        for i in range(1, s):
            if i > 1:
                A[i][0] = first[i - 2]
            if i <= len(own):
                A[i][i] = own[i - 1]
            A[i][i - 1] = entries[i - 1]
        parts.append(A)
    return parts, [A[-1] for A in parts]


def _imkg(block: Block, matrices: list[Array], vectors: list[Array]) -> Iterator[Found]:
    """Yield the method of a call of that name with its three or four rows."""
    rows = [x.value for x in vectors]
    s = len(rows[0]) + 1 if rows else 0
    given = "imkg" in block.called.lower() and not matrices and len(rows) in (3, 4)
    if not given or len(rows[1]) != s - 1 or len(rows[2]) >= s or len(rows[-1]) < s - 2:
        return

    def make(table: Table) -> None:
        table.kind, (table.A, table.b), table.c = "additive", imkg(rows), [None, None]

    name = next((x for x in reversed(block.path()) if x != block.called), block.called)
    yield from _guarded(name, vectors[0].line, vectors, make)


# --- general linear methods -----------------------------------------------------------------------


def _general_linear(block: Block, matrices: list[Array], vectors: list[Array]) -> Iterator[Found]:
    """Yield A, B, U, V of a method that carries more than one value: Butcher (2016), section 50."""
    named: dict[str, list[Array]] = {}
    for x in matrices:
        named.setdefault(x.name.lower(), []).append(x)
    if not {"a", "b", "u", "v"} <= named.keys():
        return
    for four in zip(*(named[x] for x in "abuv"), strict=False):
        A, B, U, V = (len(x.value) for x in four)
        if (A, B) == (U, V):
            table = Table("", four[0].line, "glm", general=True, last=max(x.last for x in four))
            table.unread = "a general linear method; its first and last values are not read"
            yield Found(table, list(four))


# --- Rosenbrock -----------------------------------------------------------------------------------


def _near(anchor: Array, pool: Sequence[Array], role: str, s: int) -> Array | None:
    fits = [x for x in pool if x.role == role and len(x.value) == s and x is not anchor]
    return _nearest(anchor, fits)


def _nearest(anchor: Array, pool: Sequence[Array]) -> Array | None:
    return min(pool, key=lambda x: abs(x.at - anchor.at), default=None)


def _rosenbrock(block: Block, matrices: list[Array], vectors: list[Array]) -> Iterator[Found]:
    """Return A, Gamma and b of Hairer and Wanner (1996), IV.7."""
    for x in matrices:
        gamma = _square(x) if x.role == "gamma" else None
        if gamma is None:
            continue
        s = len(gamma)
        diagonal = [y.value for y in block.items
                    if y.name.lower() in _GAMMAS and isinstance(y.value, Number)]  # fmt: skip
        if diagonal and not any(size(row[i]) for i, row in enumerate(gamma)):  # it stands apart
            gamma = [[*row[:i], diagonal[0], *row[i + 1 :]] for i, row in enumerate(gamma)]
        alphas = [y for y in matrices if y.role in ("A", "c") and len(y.value) == s]
        other = _nearest(x, alphas)
        b = _near(x, vectors, "b", s)
        alpha = _square(other, strict=True) if other is not None else None
        if other is None or b is None or alpha is None:
            continue
        low = _near(x, vectors, "embedded", s)

        def make(table: Table, alpha: Any = alpha, gamma: Any = gamma, b: Array = b,
                 low: Array | None = low) -> None:  # fmt: skip
            table.kind, table.A, table.b, table.c = (
                "rosenbrock", [alpha, gamma], [b.value], [None])  # fmt: skip
            if low is not None and abs(sum(map(size, low.value)) - 1) < LOOSE:
                table.rows = [(low.name, low.value, None)]

        arrays = [other, x, b, *([low] if low else [])]
        yield from _guarded("", min(y.line for y in arrays), arrays, make)


#: Names of the number on the diagonal of Gamma.
_GAMMAS = ("gamma", "γ", "g", "gam", "gama")


def _packed(x: Array, s: int) -> Rows | None:
    """Return a strictly lower triangular matrix (s, s) from rows or from one list."""
    if not x.flat:
        if x.named and len(x.value) == s - 1:  # the last stage takes the slope of the one before
            x = replace(x, value=[*x.value, x.value[-1]])
        return _square(x, strict=True) if len(x.value) == s else None
    given = [*x.value, *([ZERO] * (s * (s - 1) // 2 - len(x.value)))]
    if len(given) != s * (s - 1) // 2 or (isqrt(8 * len(x.value) + 1) + 1) // 2 > s:
        return None
    return [
        [*given[i * (i - 1) // 2 : i * (i - 1) // 2 + i], *([ZERO] * (s - i))] for i in range(s)
    ]


def _transformed(block: Block, matrices: list[Array], vectors: list[Array]) -> Iterator[Found]:
    """Return A, C, m and gamma of the transformed form."""
    for m in vectors:
        if not (last_letter(m) in ("m", "b") and len(m.value) > 1):
            continue
        pool = [x for x in (*vectors, *matrices) if _stem(x) == _stem(m) and x is not m]
        gamma = _in_its_list(block)
        if gamma:
            m, pool = _without_room(m, pool)
        s = len(m.value)
        given = {last_letter(x): x for x in pool if last_letter(x) in ("a", "c", "e", "btilde")}
        if last_letter(m) == "m":  # ra and rc beside ros_m
            both = [(x, y) for x in matrices for y in matrices
                    if (x.name[-1:], y.name) == ("a", f"{x.name[:-1]}c")]  # fmt: skip
            given = {**(dict(zip("ac", both[0], strict=True)) if len(both) == 1 else {}), **given}
        gammas = [x.value[0] for x in pool if x.role == "gamma" and x.flat] + [
            x.value for x in block.items
            if x.name.lower() in _GAMMAS and isinstance(x.value, Number)
        ]  # fmt: skip
        if {"a", "c"} <= given.keys() and "e" in given and not gammas:
            gammas = gamma
        if not ({"a", "c"} <= given.keys() and gammas):
            continue
        A, C = _packed(given["a"], s), _packed(given["c"], s)
        if A is None or C is None or not any(size(y) for row in C for y in row):
            continue
        error = given.get("e") or given.get("btilde")
        lower = [whole_number(x.value) for x in block.items if re.fullmatch("ros_?ELO", x.name)]
        low_order = lower[0] - 1 if lower and lower[0] and lower[0] > 1 else None

        def make(table: Table, A: Rows = A, C: Rows = C, m: Array = m, g: Any = gammas[0],
                 error: Array | None = error, least: int | None = low_order) -> None:  # fmt: skip
            low = list(error.value) if error is not None else None
            low = [*low, *([ZERO] * (len(m.value) - len(low)))] if low else None
            made = transformed(table.name, table.line, g, A, C, m.value, low)
            if abs(sum(map(size, made.b[0])) - 1) > 0.5 and not _begin(made.A[0], vectors):
                raise Unread("the coefficients of a Rosenbrock method, in a form that is not read")
            table.kind, table.A, table.b, table.c = made.kind, made.A, made.b, made.c
            table.rows = [(name, row, least) for name, row, _ in made.rows]
            table.identities = list(_sums_said(table.A, vectors))

        arrays = [given["a"], given["c"], m, *([error] if error else [])]
        yield from _guarded("", min(y.line for y in arrays), arrays, make)


def _sums_said(parts: Sequence[Rows], vectors: list[Array]) -> Iterator[tuple[str, float]]:
    """Yield how far vectors called alpha or gamma are from the sums of rows, if most are sums."""
    for x in vectors:
        part = {"alpha": 0, "α": 0, "gamma": 1, "γ": 1}.get(last_letter(x))
        if part is None or len(x.value) < len(parts[part]) or x.lost:
            continue
        pairs = list(zip(parts[part], x.value, strict=False))
        if not all(isinstance(y, Number) for _, y in pairs) or len(pairs) < 3:
            continue
        gaps = [abs(sum(map(size, row)) - size(y)) for row, y in pairs]
        if 2 * sum(gap < LOOSE for gap in gaps) >= len(gaps):
            k = gaps.index(max(gaps))
            at = pairs[k][1].place
            line = f" (line {at[0]})" if at else ""
            yield f"the sum of row {k + 1} is {x.name}[{k + 1}]{line}, which", gaps[k]


def _without_room(m: Array, pool: Sequence[Array]) -> tuple[Array, list[Array]]:
    """Return weights and what stands beside them without the room for further stages.

    Matrices given as one list of n^2 entries, n the number of weights, are rows.
    """
    n = len(m.value)
    pool = [
        replace(x, value=[x.value[i * n : i * n + n] for i in range(n)]).with_role(x.role)
        if x.flat and n > 1 and len(x.value) == n * n else x for x in pool
    ]  # fmt: skip
    s = max((k for k, x in enumerate(m.value, 1) if size(x)), default=n)
    own = [x for x in pool if last_letter(x) in ("a", "c", "e")]
    if any(size(y) for x in own for r in x.value[s:] for y in (r if isinstance(r, list) else [r])):
        return m, pool
    found = [
        replace(x, value=[r[:s] if isinstance(r, list) else r for r in x.value[:s]])
        .with_role(x.role) if x in own and len(x.value) == n else x for x in pool
    ]  # fmt: skip
    return replace(m, value=m.value[:s]).with_role(m.role), found


def _in_its_list(block: Block) -> list[Any]:
    """Return the only number that is not whole of the list with which a name begins.

    As in ``Coefficients k{"ROS3", 3, 3, 2, 0.4358}; k.m << ..``, where it is gamma.
    """
    items = block.parent.items if block.parent else []
    given = [x.value for x in items if x.name == block.name and isinstance(x.value, list)]
    broken = [y for x in given for y in x if isinstance(y, Number) and size(y) % 1]
    return broken if len(broken) == 1 and 0 < size(broken[0]) < 2 else []


def _begin(A: Rows, vectors: list[Array]) -> bool:
    """Return whether nodes, three or more, are the sums of the first rows."""
    sums = [sum(map(size, row)) for row in A]
    given = [[size(v) for v in x.value] for x in vectors if x.role == "c" and len(x.value) > 2]
    return any(all(abs(p - q) < LOOSE for p, q in zip(sums, c, strict=False)) for c in given)


def transformed(
    name: str, line: int, g: Number, A: Rows, C: Rows, m: list[Number], e: list[Number] | None
) -> Table:
    """Return the method of gamma, A, C (s, s), m and the estimate e: Hairer, Wanner (1996), IV.7.

    C = diag(1 / gamma) - Gamma^-1, alpha = A Gamma, b = m Gamma.
    """
    s = len(m)
    inverse = [
        [C[i][j].of(-C[i][j].value) if i != j else g.of(Exact(1) / g.value) for j in range(s)]
        for i in range(s)
    ]
    gamma = [[ZERO] * s for _ in range(s)]
    for j in range(s):  # forward substitution in the columns of the inverse
        for i in range(j, s):
            total = Exact(int(i == j))
            for k in range(j, i):
                total = total - inverse[i][k].value * gamma[k][j].value
            gamma[i][j] = g.of(total * g.value)

    def product_of(x: list[Number]) -> list[Number]:
        found = []
        for j in range(s):
            total = sum((x[k].value * gamma[k][j].value for k in range(s)), Exact(0))
            found.append(g.of(total, next((y for y in x if y.places is not None), g)))
        return found

    rows = [[product_of(x) for x in A], gamma]
    table = Table(name, line, "rosenbrock", rows, [product_of(m)], [None])
    if e is not None:
        embedded = product_of([x.of(x.value - y.value, y) for x, y in zip(m, e, strict=True)])
        table.rows = [("m - E", embedded, None)]
    return table


# --- Nystrom --------------------------------------------------------------------------------------


_PRIME = re.compile(r"(?:p|prime|dot|d|v|ʹ|')$")


def _half_squares(A: Rows, c: Sequence[Any], least: int = 2) -> bool:
    """Return whether most rows sum to half of the squares of nodes, and few to the nodes.

    So do as many as `least`; of two rows that are said to be of a Nystrom method it is one.
    """
    s = len(A)
    sums, times = [sum(map(size, row)) for row in A], [size(x) for x in c]
    if len(times) == s - 1:
        times = [0.0, *times]
    if len(times) != s or s < 3:
        return False
    live = [(x, y) for x, y in zip(sums, times, strict=True) if x or y]
    good = sum(abs(x - y * y / 2) < LOOSE for x, y in live)
    return good >= least and good >= min(least / 2, 0.6) * len(live) and sum(
        abs(x - y) < LOOSE for x, y in live
    ) < 0.6 * len(live)  # fmt: skip


_NYSTROM = Words("rkn", {"nystr": "nystr[oöø]m"})


def _nystrom(
    block: Block, matrices: list[Array], vectors: list[Array], *, text: str
) -> Iterator[Found]:
    """Return A, b, b' and c of q'' = g(q), and A' of q'' = g(q, q')."""
    for x in matrices:
        A = _square(x, strict=True)
        least = 1 if x.named and len(x.value) == 3 and _NYSTROM.search(text) else 2
        times = [y for y in vectors if A is not None and _half_squares(A, y.value, least)]
        c = next((y for y in times if y.role == "c"), None)
        if A is None or c is None:
            continue
        s = len(A)
        rows = [y for y in vectors if len(y.value) == s and y not in times
                and not re.search(r"tilde|hat|err|low|embed|^[de]", y.name)
                and role_of(re.sub("prime|p|dot", "", y.name))[1] != "embedded"]  # fmt: skip
        ends = [y for y in rows if abs(sum(map(size, y.value)) - 1) < LOOSE]
        halves = [y for y in rows if abs(sum(map(size, y.value)) - 0.5) < LOOSE]
        ends = ends or [y for y in rows if _PRIME.search(y.name)]
        halves = halves or [y for y in rows if y.role == "b" and not _PRIME.search(y.name)]
        velocity = [y for y in matrices if y is not x and _sums_to(_square(y, strict=True), c)]

        def make(table: Table, A: Rows = A, c: Array = c, ends: Any = ends, halves: Any = halves,
                 velocity: Any = velocity) -> None:  # fmt: skip
            if len(ends) != 1 or len(halves) != 1 or len(velocity) > 1:
                raise Unread("the coefficients of a Nystrom method, in a form that is not read")
            table.kind, table.A = "nystrom", [A, *(_square(y, strict=True) or [] for y in velocity)]
            table.b = [halves[0].value, ends[0].value]
            table.c = [[ZERO, *c.value] if len(c.value) < len(A) else c.value]

        yield from _guarded("", x.line, [x, c, *ends, *halves, *velocity], make)


def _sums_to(A: Rows | None, c: Array) -> bool:
    values = [size(x) for x in c.value]
    if A is None or len(A) - len(values) not in (0, 1):
        return False
    sums = [sum(map(size, row)) for row in A]
    return all(abs(x - y) < LOOSE for x, y in zip(sums[-len(values) :], values, strict=True))


_DENSE = re.compile(r"dense|interp|contin", re.IGNORECASE)


def _dense(block: Block, matrices: list[Array], vectors: list[Array]) -> Iterator[Found]:
    """Yield b_i(theta) of a dense output without its method: the weights of stages sum to theta."""
    for x in matrices if not any(y.role == "A" for y in matrices) else ():
        rows, width = x.value, _length(x.value[0])
        said = _DENSE.search(" ".join([*block.path(), x.name]))
        if not said or min(len(rows), width) < 3 or {*map(_length, rows)} != {width}:
            continue
        turned = len(rows) < width
        sums = [sum(map(size, r)) for r in (rows if turned else zip(*rows, strict=True))]
        wanted = [1, *([0] * (len(sums) - 1))]  # of theta, theta^2, ..
        gaps = [y - z for y, z in zip(sums, wanted if _one(sums[0]) else wanted[::-1], strict=True)]
        off = [k for k, y in enumerate(gaps) if not abs(y) < LOOSE]
        table = Table("", x.line, general=True, last=x.last)
        table.unread = "a dense output whose weights sum to theta; more of it is not read"
        for k in off:
            at = f"{'row' if turned else 'column'} {k + 1} of {x.name} sums to {gaps[k]:.4g}, not 0"
            table.unread = f"question: {at}: the weights of a dense output sum to theta"
        if len(off) < 2 and (_one(sums[0]) or _one(sums[-1])):
            yield Found(table, [x])


def _one(x: float) -> bool:
    return abs(x - 1) < LOOSE


# --- Shu-Osher and low storage --------------------------------------------------------------------


def _stages(x: Array) -> Rows | None:
    """Return the rows (s, s) of y_1, .., y_s from a matrix with or without one for y_0."""
    value = [r if isinstance(r, list) else [r] for r in x.value]
    if all(size(y) == 0 for y in value[0]) and len(value) > 1:
        value = value[1:]
    s = len(value)
    if any(isinstance(y, list) for r in value for y in r):
        return None
    if any(size(y) != 0 for i, r in enumerate(value) for y in r[i + 1 :]):
        return None
    return [[*r[:s], *([ZERO] * (s - len(r)))] for r in value]


def _shu_osher(block: Block, matrices: list[Array], vectors: list[Array]) -> Iterator[Found]:
    """Return alpha and beta whose rows of alpha sum to 1."""
    for x in matrices:
        if last_letter(x) != "alpha":
            continue
        beta = _nearest(x, [y for y in matrices if last_letter(y) == "beta"])
        alpha, other = _stages(x), _stages(beta) if beta is not None else None
        if beta is None or alpha is None or other is None or len(alpha) != len(other):
            continue
        sums = [abs(sum(map(size, r)) - 1) < LOOSE for r in alpha]
        if len(alpha) < 2 or sum(sums) < 0.6 * len(sums):
            continue

        def make(table: Table, alpha: Rows = alpha, other: Rows = other) -> None:
            table.kind, table.A, table.c = "shu-osher", [alpha, other], [None]
            table.b = [[ZERO] * len(alpha)]
            gaps = [abs(complex(sum((y.value for y in r), Exact(0))) - 1) for r in alpha]
            table.identities = [(f"sum of row {k} of alpha = 1", g) for k, g in enumerate(gaps, 1)]

        yield from _guarded("", x.line, [x, beta], make)


def in_one_form(x: Table) -> Table:
    """Return ``y_i = sum alpha_ij y_j + h beta_ij f(y_j)`` as A and b: Shu, Osher (1988)."""
    s = len(x.A[0])
    rows: list[list[Number]] = [[ZERO] * s]
    for alpha, beta in zip(*x.A, strict=True):
        row = list(beta)
        for a, before in zip(alpha, rows, strict=False):
            row = [y.of(y.value + a.value * z.value, a) for y, z in zip(row, before, strict=True)]
        rows.append(row)
    return replace(x, kind="rk", A=[rows[:s]], b=[rows[s]], c=[None], identities=[])


def _low_storage(vectors: list[Array]) -> Iterator[Found]:
    """Yield a and B of dU = A dU + h f(U), U = U + B dU: Williamson (1980).

    Codes with -A are known by the nodes, or by the conditions, and so is the form in which a is the
    entry before the diagonal and b, before it, are the weights: Kennedy, Carpenter, Lewis (2000).
    """
    for x in vectors:
        if last_letter(x) != "a":
            continue
        same = [y for y in vectors if _stem(y) == _stem(x)]
        b = _nearest(x, [y for y in same if last_letter(y) == "b"])
        if b is None or len(b.value) < 3 or len(b.value) - len(x.value) not in (0, 1):
            continue
        A = [ZERO, *x.value] if len(x.value) < len(b.value) else x.value
        if size(A[0]) != 0 or not 0 < size(b.value[0]) < 1:
            continue
        nodes = [y for y in same if last_letter(y) == "c" and len(A) - len(y.value) in (0, 1)]
        c = _nearest(x, nodes)
        given = [x, b, *([c] if c else [])]
        down = sum(size(y) < 0 for y in A[1:])

        def make(
            table: Table, A: list[Any], b: Array = b, c: Array | None = c, form: str = ""
        ) -> None:
            times = [ZERO, *c.value][-len(A) :] if c is not None else None
            table.kind, table.b, table.c = "low-storage", [A, b.value], [times]
            if form == "registers":
                rows = enumerate(A)
                table.kind, table.b = "rk", [b.value]
                table.A = [[[*b.value[: i - 1], y, *([ZERO] * (len(A) - i))][: len(A)] if i else
                            [ZERO] * len(A) for i, y in rows]]  # fmt: skip
            elif c is not None and _keeps_nodes(table):
                pairs = zip(_stages_of(A, b.value), table.c[0] or (), strict=True)
                gaps = [abs(sum(map(size, r)) - size(y)) for r, y in pairs]
                first = next((k for k, x in enumerate(gaps) if x > 1e-6), 0)
                table.identities = [(f"stage {first + 1} at c[{first + 1}]", gaps[first])]

        if down >= 0.8 * len(A[1:]):
            yield from _guarded("", x.line, given, partial(make, A=A))
            continue
        if down and any(not isinstance(y, Number) for y in A):
            continue
        turned = [y.of(-y.value, y) if isinstance(y, Number) else y for y in A]
        for form, values in (("registers", A), ("", turned)):
            (found,) = _guarded("", x.line, given, partial(make, A=values, form=form))
            if found.table.loose > 1 or _keeps_nodes(found.table):
                yield found
                break


def _registers(vectors: list[Array], matrices: list[Array]) -> Iterator[Found]:
    """Yield methods with delta, beta, and gamma_1, gamma_2, maybe gamma_3, or a matrix of them.

    S2 += delta S1, S1 = gamma_1 S1 + gamma_2 S2 + gamma_3 y + beta h f(S1), from S1 = y and S2 = 0:
    the methods 2S and 3S* of Ketcheson (2010), "Runge-Kutta methods with minimum storage
    implementations". Rows that are left for the index 0 are zeros.
    """
    named = {re.sub(r"[\W_]|ma", "", re.sub("_values$", "", x.name.lower())): x for x in vectors}
    columns = sorted(x for x in named if re.fullmatch(r"gam\d", x))
    wide = [x for x in matrices if x.role == "gamma" and {*map(_length, x.value)} == {3}]
    if not {"delta", "beta"} <= named.keys() or not (len(columns) in (2, 3) or len(wide) == 1):
        return
    own = [named[x] for x in columns] if len(columns) in (2, 3) else wide
    given = [named["delta"], *own, named["beta"]]
    gammas = [list(x) for x in zip(*(x.value for x in own), strict=False)]
    gammas = [list(x) for x in wide[0].value] if own is wide else gammas
    delta, beta = named["delta"].value, list(named["beta"].value)
    if len(gammas) == len(beta) > 1 and not any(map(size, gammas[0])) and size(beta[0]) == 0:
        gammas, beta = gammas[1:], beta[1:]
    s = len(beta)
    if len(gammas) != s or len(delta) < s or s < 2:
        return

    def make(table: Table) -> None:
        zero = [Exact(0)] * (s + 1)  # of y and of the slopes
        first = [Exact(1), *zero[1:]]
        S1, S2, rows = first, zero, []
        for k, (d, given, rate) in enumerate(zip(delta, gammas, beta, strict=False)):
            p, q, r = (y.value for y in (*given, ZERO)[:3])
            rows.append(S1)
            S2 = [x + d.value * y for x, y in zip(S2, S1, strict=True)]
            S1 = [p * y + q * x + r * z for x, y, z in zip(S2, S1, first, strict=True)]
            S1[k + 1] = S1[k + 1] + rate.value
        rows.append(S1)
        made = [[beta[-1].of(x) for x in row[1:]] for row in rows]
        table.A, table.b, table.c = [made[:-1]], [made[-1]], [None]
        gaps = [abs(complex(row[0]) - 1) for row in rows]
        table.identities = [(f"the values of stage {k} keep the sum 1", g)
                            for k, g in enumerate(gaps)]  # fmt: skip

    yield from _guarded("", named["beta"].line, given, make)


def _two_slopes(vectors: list[Array]) -> Iterator[Found]:
    """Yield gamma and zeta of ``y += h (gamma_m f_m + zeta_m f_(m-1))``, with zeta_1 = 0.

    Wray (1986), in Spalart, Moser, Rogers (1991), "Spectral methods for the Navier-Stokes
    equations with one infinite and two periodic directions", appendix.
    """
    for x in vectors:
        rest = [y for y in vectors if last_letter(y) in ("zeta", "ζ")
                and len(x.value) - len(y.value) in (0, 1)]  # fmt: skip
        if last_letter(x) not in ("gamma", "γ") or len(rest) != 1 or len(x.value) < 3:
            continue
        zeta = [ZERO, *rest[0].value][-len(x.value) :]
        if size(zeta[0]) or abs(sum(map(size, [*x.value, *zeta])) - 1) > LOOSE:
            continue

        def make(table: Table, x: Array = x, zeta: list[Any] = zeta) -> None:
            rows = [[ZERO] * len(x.value)]
            for m, (p, q) in enumerate(zip(x.value, zeta, strict=True)):
                row = list(rows[-1])
                row[m] = p
                if m:
                    row[m - 1] = q.of(row[m - 1].value + q.value, q)
                    row[m - 1].place = q.place
                rows.append(row)
            table.A, table.b, table.c = [rows[:-1]], [rows[-1]], [None]

        yield from _guarded("", x.line, [x, *rest], make)


def _keeps_nodes(table: Table) -> bool:
    """Return whether the stages of a low-storage method are at most of its nodes."""
    if table.c[0] is None:
        return False
    rows = table.A[0] if table.kind == "rk" else _stages_of(*table.b)
    good = [abs(sum(map(size, r)) - size(y)) < LOOSE for r, y in zip(rows, table.c[0], strict=True)]
    return 2 * sum(good[1:]) >= len(good[1:])


def _stages_of(A: list[Any], b: list[Any]) -> Iterator[list[Number]]:
    """Yield what the slopes before each stage of a 2N method add to it, each as one number."""
    slope, at = 0.0, 0.0
    for x, y in zip(A, b, strict=True):
        yield [Number(Exact(Fraction(at)))]
        slope = size(x) * slope + 1
        at += size(y) * slope


# --- splittings -----------------------------------------------------------------------------------


def _splitting(vectors: list[Array]) -> Iterator[Found]:
    """Yield steps of two flows that each sum to 1."""
    names = [_NUMBERED.fullmatch(bare_name(x).lower()) for x in vectors]
    ends = [(m[2], m[1] + m[3]) if m else (last_letter(x), _stem(x))
            for m, x in zip(names, vectors, strict=True)]  # fmt: skip
    for x, (letter, stem) in zip(vectors, ends, strict=True):
        others = {(q, stem) for p, q in (*_FLOWS, *_STATES) if letter == p}
        y = next((z for z, end in zip(vectors, ends, strict=True) if end in others), None)
        if y is None or abs(len(x.value) - len(y.value)) > 1 or len(x.value) + len(y.value) < 3:
            continue
        x, y = _whole(x, y)
        if len(x.value) + len(y.value) < 4:
            continue
        good = [abs(sum(map(size, z.value)) - 1) < LOOSE for z in (x, y)]
        whole = all(size(v) % 1 == 0 for v in (*x.value, *y.value))
        sure = letter in dict(_FLOWS) or bare_name(x) != x.name.rstrip("_")
        if not (any(good) if sure else all(good)) or whole:
            continue

        def make(table: Table, x: Array = x, y: Array = y) -> None:
            first, second = (x, y) if len(x.value) >= len(y.value) else (y, x)
            n = len(first.value)
            table.kind = "splitting"
            table.b = [first.value, [*second.value, *([ZERO] * (n - len(second.value)))]]
            if n > 3 and size(table.b[1][-1]) == 0 and as_composition(
                    first.value, table.b[1][:-1]) is not None:  # fmt: skip
                table.kind = "composition"

        pairs = x.at == y.at and x.name[:-1] == y.name[:-1]  # columns of a list of pairs
        name = x.name[:-2] if pairs else ""
        yield from _guarded(name, min(x.line, y.line), [x, y], make)


def _whole(x: Array, y: Array) -> tuple[Array, Array]:
    """Return the steps of a symmetric splitting whose first half is given, with its middle step.

    The list that ends in the middle step sums to 1 if its other entries count twice, the other one
    to 1/2; lists that are whole are as they are.
    """
    for p, q in ((x, y), (y, x)):
        twice = 2 * sum(map(size, p.value)) - size(p.value[-1]), 2 * sum(map(size, q.value))
        if len(p.value) >= len(q.value) and all(abs(v - 1) < LOOSE for v in twice):
            whole = replace(p, value=[*p.value, *p.value[-2::-1]])
            other = replace(q, value=[*q.value, *q.value[::-1]])
            return (whole, other) if p is x else (other, whole)
    return x, y


def _mirrored(vectors: list[Array], text: str) -> Iterator[Found]:
    """Yield steps of a method and its adjoint in turn, of which the second half is the first's.

    They are those of a splitting whose flows move on by the sums of neighbours: McLachlan (1995),
    "On the numerical integration of ordinary differential equations by symmetric composition
    methods", section 3.
    """
    for x in vectors:
        own = re.escape(x.name or " ")
        turned = rf"(?:flip|reverse)\w*\(\s*{own}\s*\)|\b{own}\s*\[::-1\]"
        half = abs(2 * sum(map(size, x.value)) - 1) < LOOSE
        if not half or len(x.value) < 2 or not re.search(turned, text):
            continue

        def make(table: Table, x: Array = x) -> None:
            steps = [ZERO, *x.value, *x.value[::-1], ZERO]
            sums = [p.of(p.value + q.value, q) for p, q in pairwise(steps)]
            table.kind, table.b, table.sure = "splitting", [sums[::2], [*sums[1::2], ZERO]], False

        yield from _guarded("", x.line, [x], make)


def _compositions(block: Block, vectors: list[Array], text: str) -> Iterator[Found]:
    """Yield weights of a composition that read the same backwards, or half of them.

    They are known by their sum and that of their cubes, 1 and 0, which a list of other numbers has
    not; with a word, or half of them with the number of steps beside them, by one of the two.
    """
    steps = {whole_number(x.value) for x in block.items if re.search("stage|step", x.name)}
    for x in vectors:
        word = _WEIGHTS.search(" ".join([*block.path(), x.name]))
        values = [size(y) for y in x.value]
        if x.named and any(set(values) <= set(map(size, y.value)) for y in vectors if y is not x):
            continue  # the names of the numbers of another list
        same = [abs(p - q) < LOOSE for p, q in zip(values, reversed(values), strict=True)]
        full = len(values) > 2 and len(values) % 2 == 1 and last_letter(x) not in ("b", "c", "d")
        n = max((k for k, y in enumerate(values, 1) if y), default=0)
        half = [*values[:n], *values[: max(0, n - 1)][::-1]]
        exact = n > 1 and max(abs(sum(half) - 1), abs(sum(y**3 for y in half))) < LOOSE
        given: list[Any] = []
        sure = True
        if word and full and sum(same) >= len(same) - 2 and min(values) <= 0:
            given = x.value if abs(sum(values) - 1) <= LOOSE or all(same) else []
        elif full and sum(same) >= len(same) - 2 and min(values) < 0:
            gaps = abs(sum(values) - 1), abs(sum(y**3 for y in values))
            likely = (
                max(gaps) < 0.9
                and not exact
                and _WEIGHTS.search(text)
                and not _other_flow(x, vectors)
            )
            middle = values[len(values) // 2]  # no filter goes back in the middle
            known = likely and gaps[0] < 1e-9 and middle == min(values) and middle % 1 != 0
            sure = all(same) and (max(gaps) < LOOSE or known)
            given = x.value if sure or likely else []
        if not given and n > 1 and min(half) < 0 < max(half):
            gaps = abs(sum(half) - 1), abs(sum(y**3 for y in half))
            known = (word or 2 * n - 1 in steps) and max(gaps) < 0.5
            broken = any(y % 1 for y in half) and not MULTISTEP.search(" ".join(block.path()))
            if broken and (exact or (known and min(gaps) < LOOSE)):
                given = [*x.value[:n], *x.value[: n - 1][::-1]]
        if not given and word and n > 1 and all(isinstance(y, Number) for y in x.value[:n]):
            middle = 1 - 2 * sum(values[:n])  # which codes compute
            if abs(middle**3 + 2 * sum(y**3 for y in values[:n])) < LOOSE:
                first = x.value[0]
                total = sum((y.value for y in x.value[:n]), Exact(0))
                rest = x.value[:n][:: 1 if middle * values[n - 1] < 0 else -1]
                given = [*rest, first.of(Exact(1) - total - total, first), *rest[::-1]]
        if not given:
            continue

        def make(table: Table, given: list[Any] = given, sure: bool = sure) -> None:
            made = of_weights("", 0, given)
            table.kind, table.b, table.sure = made.kind, made.b, table.sure and sure

        yield from _guarded("", x.line, [x], make)


def _other_flow(x: Array, vectors: list[Array]) -> bool:
    """Return whether steps of another flow stand beside steps: one more or less, with sum 1."""
    return any(
        abs(len(y.value) - len(x.value)) == 1 and abs(sum(map(size, y.value)) - 1) < LOOSE
        for y in vectors
    )


_WEIGHTS = Words(
    "suzuki",
    {
        "yosh": "yosh(?:ida)?(?![a-z])",
        "composition": "composition(?<!decomposition)",
        "sy_": "sy_(?<![a-z]sy_)",
        "ys_": "ys_(?<![a-z]ys_)",
    },
)
