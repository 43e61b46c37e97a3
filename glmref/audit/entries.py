"""Arrays of a source under their names, and what a name says that an array is."""

from __future__ import annotations

import re
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any

from ..catalogue.keys import MAX_SIZE
from .collecting import Block, Item
from .folding import Entries, flattened
from .lexer import Language
from .table import ZERO, Table
from .values import Number, Unread, size, whole_number

#: How near a sum must be to 1 for a list to be taken for weights.
LOOSE = 4e-3


class Words:
    """Words and phrases that a text may have, in any case of letters.

    Each phrase stands under a literal part of it: a text is searched for a phrase only where it has
    that part, which takes a tenth of the time of one expression for all.

    Parameters
    ----------
    words : str
        Literals, with blanks between them.
    phrases : Mapping of str to str
        Expressions in lower case by the part.
    """

    def __init__(self, words: str, phrases: Mapping[str, str]) -> None:
        self.words = words.split()
        self.phrases = {part: re.compile(phrase) for part, phrase in phrases.items()}

    def search(self, text: str) -> bool:
        """Return whether a text has any of them."""
        return _said(self, text)


@lru_cache(maxsize=64)
def _said(words: Words, text: str) -> bool:
    """Return whether a text has a word; a source is asked again and again."""
    text = text.lower()
    return any(x in text for x in words.words) or any(
        part in text and phrase.search(text) for part, phrase in words.phrases.items()
    )


#: Words of the subject; a file without any of them holds tables only under plain names.
SUBJECT = Words(
    "runge butcher tableau rosenbrock dirk integrator stepper yoshida symplectic adams bashforth "
    "moulton nordsieck suzuki embedded dopri dop853 dormand fehlberg bogacki omelyan",
    {
    "rk": r"rk(?:(?<![a-z]rk)(?:(?:f|ck|dp|n)?\d|[abc]\b)|(?<=ssprk)|(?<=ssp_rk)"
          r"|(?<=lsrk)(?<![a-z]lsrk)|(?<=lserk)(?<![a-z]lserk))",
    "step": r"(?:multi|time).?step",
    "ros": r"ros(?<![a-z]ros)(?!2\b)\d",
    "ode": r"ode(?<!\wode)s?\b",
    "mex": r"\bi?mex\b",
    "bdf": r"bdf(?<!\wbdf)",
    "stability": r"strong.stability",
    "backward": r"backward.?diff",
    "solver": r"(?:ivp|initial.value|differential|evolution).{0,30}solver",
    "karp": r"cash.?karp",
    "ruth": r"ruth(?:(?<![a-z]ruth)(?![a-z])|(?<=forest.ruth)|(?<=forestruth))",
    "split": r"split.?(?:operator|step)"
             r"|splitting(?:.{0,9}(?:method|scheme|parameter|coefficient)"
             r"|(?<=operator.splitting)|(?<=operatorsplitting))",
    "hoover": r"nos[eé].?hoover",
    "storage": r"(?:low|2n).?storage",
    "drift": r"kick.?drift|drift.?kick",
    "collocation": r"collocation.{0,9}(?:method|scheme)",
    "stiffly": r"stiffly.?accurate",
    },
)  # fmt: skip
#: Words of a file in which flows are looked for.
OF_FLOWS = Words(
    "symplectic splitting drift kick yoshida hamilton omelyan strang mclachlan verlet suzuki "
    "integrator",
    {
        "ruth": r"ruth(?<![a-z]ruth)",
        "leap": r"leap.?frog",
        "norm": r"min(?:imum)?.?norm",
        "dynamics": r"molecular.?dynamics",
    },
)


def of_subject(text: str) -> bool:
    """Return whether a text has a word of the subject."""
    return SUBJECT.search(text)


# --- names ----------------------------------------------------------------------------------------

#: Names of arrays by what they are.
NAMES = {role: words.split() for role, words in {
    "A": "a aa amat amatrix acoef acoeffs acoefs acoefficients alower matrix geta rka staticA ai "
         "ae aij aex aim aexp aimp aexplicit aimplicit butcher runge at ahat stages ark "
         "tableauintermediate",
    "b": "b bb bvec weights weight bcoef bcoeffs bcoefs bcoefficients bsol csol getb rkb bi bj "
         "bhigh b1 tableaufinal bex bim bexp bimp bexplicit bimplicit w",
    "c": "c cc cvec nodes node ccoef ccoeffs ccoefs ccoefficients alpha α alphas getc rkc times ci "
         "abscissae abscissa ch ah evalstages",
    "embedded": "bhat bh b2 blow blower bembed bembedded bstar bt bemb embedded d dembedded bp be "
                "embweights low lower bls αEEst aeest bloworder weightshat bht bcap bb2",
    "error": "e er err error berror cerror btilde dc db ec rke ee errweights bdiff be5 ecoef bhh "
             "tr",
    "gamma": "gamma gam γ",
    "beta": "beta β betas",
    "diagonal": "adiagonal adiag diagonal diag",
}.items()}  # fmt: skip
_ROLES = {x.lower(): role for role, names in NAMES.items() for x in names}
_SPLIT = re.compile(r"_|(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z]+)")


def role_of(name: str) -> tuple[str, str]:
    """Return what a name has besides its role, and the role, ``""`` where it has none."""
    if re.match(r"k[A-Z]", name):  # kAlpha, a constant of C++
        name = name[1:]
    name = re.sub(r"_(?:values?|vals?|array|data|[hd]|host|dev|device|[cg]pu)$", "", name)
    if re.fullmatch(r"E\d", name):  # of two estimates
        return "", "error"
    capitals = re.fullmatch(r"([A-Z]{2,}\d*)([abc]{1,2})", name)  # RKa
    if capitals and capitals[2] in _ROLES:
        return capitals[1].lower(), _ROLES[capitals[2]]
    whole = name.replace("_", "").lower()
    if whole in _ROLES or whole in ("explicit", "implicit"):  # as a part of a name it is none
        return "", _ROLES.get(whole, "A")
    parts = [x for x in _SPLIT.split(name) if x]
    for n in (2, 1):
        for stem, said in ((parts[:-n], parts[-n:]), (parts[n:], parts[:n])):
            role = _ROLES.get("".join(said).lower())
            if role and stem:
                return "_".join(stem).lower(), role
    return "", ""


# --- arrays ---------------------------------------------------------------------------------------


@dataclass
class Array:
    """Numbers under a name."""

    name: str
    value: list[Any]
    line: int
    last: int
    at: int
    lost: str = ""
    named: bool = False  #: Whether entries have names of their own.
    absent: frozenset[int] = frozenset()  #: Places of a vector of which no name is there.
    stem: str = ""
    role: str = ""
    guessed: bool = False  #: Whether no name says that these are weights.
    order: int | None = None  #: The order that stands beside it in one list.

    def __post_init__(self) -> None:
        self.stem, self.role = role_of(self.name)
        if self.name.lower() == "bt" and not self.flat:  # a Butcher tableau
            self.role = "A"

    def with_role(self, role: str) -> Array:
        """Return the same with another role."""
        found = copy(self)
        found.role = role
        return found

    @property
    def flat(self) -> bool:
        """Whether it is a vector."""
        return not any(isinstance(x, list) for x in self.value)


_LAST_LETTER = re.compile(
    r"(?:(?:.*[_\d]|rk)?(?=[a-z]$)|.*(?=(?:drift|kick)s?$))([a-z]+)$", re.IGNORECASE
)
#: The letter of ``sC``.
_CAPITAL = re.compile(r"[a-z]+([A-Z])$")


def bare_name(x: Array) -> str:
    """Return a name without what says that it is one of coefficients."""
    said = r"[_ ]?(?:coeffs?|coefs?|coefficients|vals|vec)$"
    return re.sub(said, "", x.name.rstrip("_"), flags=re.IGNORECASE)


def last_letter(x: Array) -> str:
    """Return the letter or word that a name ends with, ``rk4a`` as ``a``."""
    said = bare_name(x)
    last = _LAST_LETTER.match(said) or _CAPITAL.match(said)
    return (last[1] if last else re.split(r"[_.]", said)[-1]).lower()


@dataclass
class Found:
    """A table, and the arrays that it is made of."""

    table: Table
    arrays: list[Array]


_INDEXED = re.compile(r"^(.*?[^\W\d_])_{0,2}(\d+)(?:_(\d+))?_?$")


def arrays(block: Block, language: Language) -> list[Array]:
    """Return the arrays of a block: lists, entries one by one, names with numbers."""
    found: list[Array] = []
    scalars: dict[str, list[tuple[str, str | None, Item]]] = {}
    lists: dict[str, list[tuple[int, Item | Array]]] = {}
    base = _base(block, language)
    for item in _by_object(block.items):
        value = item.value
        match = _INDEXED.match(item.name)
        if isinstance(value, Entries):
            own = language.base == 1 and value and min(min(k) for k in value) > 0
            made = _of_entries(value, item, 1 if own else base)
            if made is not None:
                found.append(made)
                found += _parts(replace(item, value=made.value, last=made.last), block.called)
                if match and not match[3] and made.flat:
                    lists.setdefault(match[1], []).append((int(match[2]), made))
        elif isinstance(value, list):
            if (
                match
                and not match[3]
                and value
                and _numeric(value)
                and not any(isinstance(x, list) for x in value)
            ):
                lists.setdefault(match[1], []).append((int(match[2]), item))
            if tableau := _with_corner(item, value):
                found.append(tableau)
            elif _deep(value) == {True, False}:
                told = of_subject(" ".join([*block.path(), item.name]))
                found += _by_place(item, value, told=told)
            elif value and _numeric(value):
                if len(value) == 1 and isinstance(value[0], list):
                    value = value[0]
                if {*map(_width, value)} == {1} and role_of(item.name)[1] != "A":
                    column = [x for (x,) in value]
                    value = value if _unit(column) else column
                found.append(Array(item.name, value, item.line, item.last or item.line, item.at,
                                   item.lost))  # fmt: skip
                found += _parts(item, block.called)
        elif match and isinstance(value, Number | Unread):
            scalars.setdefault(match[1], []).append((match[2], match[3], item))
    for stem, entries in list(scalars.items()):
        if len({(x, y) for x, y, _ in entries}) < len(entries):  # c13 and c_13 are two arrays
            plain = [x for x in entries if x[2].name.startswith(stem + x[0])]
            if plain and len(plain) < len(entries):
                scalars[stem], scalars[stem + "_"] = plain, [x for x in entries if x not in plain]
    for stem, rows in lists.items():
        found += _of_rows(stem, rows, scalars)
    for stem, entries in scalars.items():
        if stem not in lists or len(entries) > 1:
            found += _of_scalars(stem, entries)
    _suffixed(found)
    _without_zeroth(found)
    return sorted(found, key=lambda x: x.at)


def _without_zeroth(found: list[Array]) -> None:
    """Leave out the empty index 0 of vectors beside a matrix whose rows had one, too."""
    for x in [y for y in found if y.role == "A" and not y.flat and y.value[0] == y.value[0][:1]]:
        wide = [y for y in found if y.flat and len(y.value) == len(x.value) + 2
                and size(y.value[0]) == 0 and abs(y.at - x.at) < 12]  # fmt: skip
        if any(role_of(y.name)[1] == "b" for y in wide) and len(wide) > 1:
            for y in wide:
                y.value = y.value[1:]


def _by_object(items: list[Item]) -> list[Item]:
    """Return items in which ``w[0].beta = 1``, ``w[1].beta = 2`` is one list of a field."""
    groups: dict[str, list[Item]] = {}
    for x in items:
        if x.index is not None and isinstance(x.value, Number):
            groups.setdefault(x.name, []).append(x)
    found = items
    for name, given in groups.items():
        numbers = [x.index for x in given]
        if len(given) > 1 and numbers[0] in (0, 1) and numbers == [
            *range(numbers[0], numbers[0] + len(given))]:  # fmt: skip
            for x in given:
                x.value.place = x.value.place or (x.line, "")
            made = replace(given[0], value=[x.value for x in given], last=given[-1].line)
            found = [x for x in found if x.name != name] + [made]
    return found


def _suffixed(found: list[Array]) -> None:
    """Give ``ag``, ``bg`` and ``cg`` their roles: a matrix and weights that differ in a letter."""
    groups: dict[str, dict[str, Array]] = {}
    for x in found:
        if len(x.name) > 1 and not x.role and x.name[0] in "aAbBcC":
            groups.setdefault(x.name[1:], {}).setdefault(x.name[0].lower(), x)
    for stem, given in groups.items():
        A, b = given.get("a"), given.get("b")
        if A is None or b is None or A.flat or not b.flat or len(A.value) != len(b.value):
            continue
        for letter, x in given.items():
            x.stem, x.role = stem.strip("_").lower(), "A" if letter == "a" else letter


def _base(block: Block, language: Language) -> int:
    """Return the index of the first entries of the arrays of a block."""
    low = [min(min(k) for k in x.value) for x in block.items
           if isinstance(x.value, Entries) and x.value]  # fmt: skip
    if not low or min(low) == 0:
        return 0
    return 1 if language.base == 1 or (min(low) == 1 and len(low) > 1) else 0


def _numeric(value: list[Any]) -> bool:
    flat = flattened(value)
    numbers = sum(isinstance(x, Number) for x in flat)
    return (
        numbers > 0
        and all(isinstance(x, Number | Unread) for x in flat)
        and (2 * numbers >= len(flat))
    )


def _deep(value: list[Any]) -> set[bool]:
    """Return whether the entries of a list that are lists hold lists: True and False for both."""
    return {any(isinstance(y, list) for y in x) for x in value if isinstance(x, list) and x}


def _width(x: Any) -> int:
    """Return how many numbers a row has, 0 for what is none."""
    return len(x) if isinstance(x, list) and not any(isinstance(y, list) for y in x) else 0


def _unit(column: list[Any]) -> bool:
    """Return whether one entry at most is not 0: inputs of a system of states, and no weights."""
    return sum(bool(size(x)) for x in column) < 2


def _with_corner(item: Item, value: list[Any]) -> Array | None:
    """Return c, A over b whose lower left corner is an empty text, maybe with its order behind."""
    order = whole_number(value[1]) if len(value) == 2 else None
    rows = value[0] if order in range(1, 15) and isinstance(value[0], list) else value
    if len(rows) < 2 or not all(isinstance(x, list) and x for x in rows):
        return None
    head, last = rows[:-1], rows[-1]
    if not isinstance(last[0], str) or last[0].strip("\"'") or not _numeric([*head, last[1:]]):
        return None
    found = Array(item.name, [*head, last[1:]], item.line, item.last or item.line, item.at)
    found.order, found.stem, found.role = order, item.name.lower(), "A"
    return found


def _by_place(item: Item, value: list[Any], *, told: bool) -> list[Array]:
    """Return the arrays of a list of a matrix and vectors, as ``{c, A, b}``, by what they are.

    The abscissae are before the matrix, or the sums of its rows; the other vectors are weights, and
    embedded ones; a matrix after the first one is that of a dense output. Without a word of the
    subject (`told`) most sums must be abscissae.
    """
    given = [x for x in value if isinstance(x, list) and x and _numeric(x)]
    first = next((k for k, x in enumerate(given) if any(isinstance(y, list) for y in x)), 0)
    if not given:
        return []
    A, vectors = given[first], [x for x in given if not any(isinstance(y, list) for y in x)]
    sums = [sum(map(size, row)) if isinstance(row, list) else size(row) for row in A][::-1]

    def good(c: list[Any]) -> float:
        pairs = zip(sums, c[::-1], strict=False)
        return sum(abs(p - size(q)) < LOOSE for p, q in pairs) / len(sums)

    nodes = max([x for x in vectors if x in given[:first]] or vectors, key=good, default=[])
    if len(vectors) < 2 or not (told or good(nodes) > 0.5):
        return []
    weights = [x for x in vectors if x is not nodes]
    names = {id(x): y for x, y in zip(weights, ("b", "bhat"), strict=False)}
    names |= {id(x): "e" for x in weights[1:2] if abs(sum(map(size, x))) < LOOSE}
    names |= {id(nodes): "c", **{id(x): "dense" for x in given if x not in vectors}, id(A): "A"}
    found = [Array(f"{item.name}_{names[id(x)]}", x, item.line, item.last or item.line, item.at,
                   item.lost) for x in given if id(x) in names]  # fmt: skip
    next(x for x in found if x.role == "A").name = item.name
    return found


def _parts(item: Item, called: str) -> list[Array]:
    """Return rows, or columns, of a matrix of two or three of them under the name of weights.

    An argument without a name is one in a call that has a word of the subject.
    """
    value, role = item.value, role_of(item.name)[1]
    if not (role in ("b", "c") if item.name else of_subject(called)):
        return []
    if len(value) > 2 and {*map(_width, value)} == {2}:
        value = [list(x) for x in zip(*value, strict=True)]
        if any(map(_unit, value)):
            return []
    if len(value) not in (2, 3):
        return []
    if not all(isinstance(x, list) and len(x) >= len(value) for x in value):
        return []
    if role == "c" and abs(sum(map(size, value[0])) - 1) > 1e-6:  # weights beside a matrix b
        return []
    if any(len(x) == len(value) and abs(sum(map(size, x)) - 1) > 1e-6 for x in value):
        return []
    found = []
    for k, row in enumerate(value):
        part = Array(item.name, row, item.line, item.last or item.line, item.at, item.lost)
        part.role = "b" if k == 0 else "embedded"
        found.append(part)
    return found


def _of_entries(entries: Entries, item: Item, base: int) -> Array | None:
    """Return a dense array from entries that are given one by one."""
    sizes = {len(k) for k in entries}
    if not entries or len(sizes) > 1 or max(max(k) for k in entries) > MAX_SIZE:
        return None
    (n,) = sizes
    if any(isinstance(x, list) for x in entries.values()):
        if n != 1:
            return None
        rows = [
            entries[k] if isinstance(entries[k], list) else [entries[k]] for k in sorted(entries)
        ]
        return Array(item.name, rows, item.line, item.last, item.at, item.lost)
    if n == 1:
        top = max(k[0] for k in entries)
        value: list[Any] = [entries.get((k,), ZERO) for k in range(base, top + 1)]
        return Array(item.name, value, item.line, item.last, item.at, item.lost)
    if n == 2:
        rows_, columns = zip(*entries, strict=True)
        first = (rows_[0], columns[0]) == (base, base)
        if len(set(rows_)) == 1 and rows_[0] == base and (len(columns) > 1 or first):  # a row
            value = [entries.get((rows_[0], k), ZERO) for k in range(base, max(columns) + 1)]
            return Array(item.name, value, item.line, item.last, item.at, item.lost)
        s = max(*rows_, *columns)
        whole = len(entries) == (max(rows_) - base + 1) * (max(columns) - base + 1)
        width = max(columns) if whole and len(set(columns)) == 2 else s  # a list of pairs
        value = [
            [entries.get((i, j), ZERO) for j in range(base, width + 1)] for i in range(base, s + 1)
        ]
        return Array(item.name, value, item.line, item.last, item.at, item.lost)
    return None


def _of_rows(stem: str, rows: list[tuple[int, Item | Array]], scalars: Any) -> list[Array]:
    """Return a matrix from rows of growing length: a2, a3, .. ."""
    rows = sorted(rows, key=lambda x: x[0])
    lengths = [len(item.value) for _, item in rows]
    grows = all(y == x + 1 for x, y in pairwise(lengths))
    follows = all(y == x + 1 for (x, _), (y, _) in pairwise(rows))
    if len(rows) < 2 or not (grows and follows):
        return []
    value = [item.value for _, item in rows]
    if lengths[0] == rows[0][0] == 2 and all(size(x[0]) == 0 for x in value):
        value = [x[1:] for x in value]  # the index 0 is left empty
    elif lengths[0] == 2:  # the first row is one number
        first = next(
            (x for digits, more, x in scalars.get(stem, []) if digits in ("21", "1", "2")), None
        )
        value = [[first.value] if first else [_absent(stem)], *value]
    items = [item for _, item in rows]
    lost = next((x.lost for x in items if x.lost), "")
    return [
        Array(stem, value, items[0].line, max(x.last or x.line for x in items), items[0].at, lost)
    ]


def _absent(stem: str) -> Unread:
    return Unread(f"the first row of {stem} has no name that is read")


def _pair(digits: str, more: str | None) -> list[tuple[int, int]]:
    if more is not None:
        return [(int(digits), int(more))]
    n = len(digits)
    if n == 2:
        return [(int(digits[0]), int(digits[1]))]
    if n == 3:
        return [(int(digits[:2]), int(digits[2])), (int(digits[0]), int(digits[1:]))]
    if n == 4:
        return [(int(digits[:2]), int(digits[2:]))]
    return []


def _of_scalars(stem: str, given: list[tuple[str, str | None, Item]]) -> list[Array]:
    """Return a matrix from a21, a31, .., and a vector from b1, b2, .. ."""
    singles: dict[int, Item] = {}
    doubles: dict[tuple[int, int], Item] = {}
    twice = ""
    words = {digits for digits, more, _ in given if more is None}
    matrix = (
        any(more is not None for _, more, _ in given)
        or (role_of(stem)[1] == "c" and words - {"1", "2"} == {"21"})
        or words == {"21"}
        or bool(words & {"21", "10", "0201", "0100"} and words & {"31", "32", "20", "0301", "0200"})
    )
    pairs = [x for x in words if len(x) == 2]
    below = "21" in words and all("0" < x[1] < x[0] for x in pairs)  # c2, c21: two arrays
    if matrix and (
        any(x[0] == "0" for x in pairs)
        or (role_of(stem)[1] not in ("", "A") and any(len(x) == 1 for x in words) and not below)
    ):
        matrix = False  # b1, b10, b20: a long vector
    wide = any(len(x) == 4 and x[0] == "0" for x in words)
    for digits, more, item in given:
        lone = more is None and (len(digits) == 1 or not matrix or (wide and len(digits) == 2))
        if lone:
            held = singles.setdefault(int(digits), item)
            if size(held.value) != size(item.value) == size(item.value):
                twice = f"{item.name} is set twice (line {item.line})"
            continue
        for i, j in _pair(digits, more):
            if j <= i <= 40 and (i, j) not in doubles:
                doubles[i, j] = item
                break
    for item in (*singles.values(), *doubles.values()):
        if isinstance(item.value, Number) and not item.value.place:
            item.value.place = (item.line, "")
    found: list[Array] = []
    if len(doubles) >= 2 or (doubles and "21" in words):
        base = 0 if any(j == 0 for _, j in doubles) else 1
        s = max(i for i, _ in doubles)
        nodes = all((i, 0) in doubles for i in range(2, s + 1)) and min(doubles)[0] > 1
        value: list[Any] = [
            [doubles[i, j].value if (i, j) in doubles else ZERO for j in range(base, s + 1)]
            for i in range(1 if nodes else base, s + 1)  # c20, c21: the node, and the row
        ]
        found.append(_together(stem, value, list(doubles.values())))
    if len(singles) >= 2 and max(singles) <= 40:
        base = 0 if 0 in singles and 1 in singles else 1
        singles.pop(0, None) if base else None
        line = [singles[k].value if k in singles else ZERO for k in range(base, max(singles) + 1)]
        found.append(_together(stem, line, list(singles.values())))
        found[-1].lost = found[-1].lost or twice
        found[-1].absent = frozenset(k - base for k in range(base, len(line) + base)) - {
            k - base for k in singles
        }
    return found


def _together(stem: str, value: list[Any], items: list[Item]) -> Array:
    lost = next((x.lost for x in items if x.lost), "")
    lines = [x.line for x in items]
    return Array(stem, value, min(lines), max(lines), min(x.at for x in items), lost, named=True)
