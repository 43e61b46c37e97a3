"""Explicit steps whose numbers stand in their arithmetic, read as the linear forms they compute.

A function that calls another one several times, ``k2 = f(t + h/2, y + h*k1/2)`` or
``f(tmp, k2, t + h/2)``, makes stages: the form of the argument in the state, the step and the
slopes before it is a row of A, and what is left in the state at the end holds the weights. Nothing
is run; a function of which one statement that matters is not folded gives no table.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from ..errors import GlmrefError
from ..exact import Exact
from .collecting import Block, Collector, _equal, _partner, _parts
from .folding import ARITHMETIC, Folder, plain
from .inline import ends
from .lexer import Language, Token
from .table import ZERO, Table
from .values import Number, Unread, pairwise

_ONE, _ZERO = Exact(1), Exact(0)
#: How far from 1 the sum of the weights of a further row may be.
_SUM = 0.1
#: Calls that are no right-hand side.
_OTHER = re.compile(
    r"(?:.*\.)?(?:\w*sqrt|a?(?:sin|cos|tan)h?|exp|log\w*|f?abs|\w*max|\w*min|pow|print\w*|range|len|"
    r"size|zeros\w*|ones\w*|array|append|push\w*|\w*alloc|mem\w+|copy\w*|if|for|while|switch|"
    r"return|function|subroutine|def|sizeof|static_cast|assert\w*|norm\w*|dot|sum|all|any|int|float|"
    r"double|real|dble|abs|mod|floor|ceil|enumerate|zip|isinstance|super|str|format|begin|end|at|"
    r"and|or|not|similar|write|is\w*|tuple|list|fill)",
    re.IGNORECASE,
)
#: Names of a step, a time and a state, whatever number they begin with.
_LOOSE = re.compile(
    r"h|hh|dt|step|step_?size|delta_?t|deltat|tau|t|t0|time|[xyu](?:0|n|_n|_?old|in)?|state|[yu]i",
    re.IGNORECASE,
)
EULER = re.compile(r"^(?!.*(?:backward|implicit|symplectic|semi|modified|improved|heun)).*euler",
                   re.IGNORECASE)  # fmt: skip
#: Most calls of a right-hand side in one step.
STAGES = 64
ACCIDENTS = (KeyError, IndexError, ValueError, TypeError, AttributeError, RecursionError)
_UNREAD = "the numbers of a step stand in its arithmetic, in a form that is not read"
BRANCHES = frozenset("else elif elseif elsif case switch match".split())
#: Calls that add an entry to a vector.
_APPENDS = frozenset("Add add append push push_back emplace_back".split())
_LOOPS = frozenset(("for", "do", "DO"))
_OWN = ("self", "this", "me")
#: What the index of an entry is made of where each has a thread.
_THREADS = frozenset("blockIdx threadIdx get_global_id".split())


class Form:
    """A sum of products of names with exact coefficients, as the value of a number."""

    def __init__(self, terms: dict[tuple[str, ...], Exact]) -> None:
        self.terms = {k: v for k, v in terms.items() if v != 0}

    @staticmethod
    def of(x: Any) -> Form:
        """Return a form, or an exact number as one."""
        return x if isinstance(x, Form) else Form({(): x})

    def __add__(self, other: Any) -> Form:
        total = dict(self.terms)
        for k, v in Form.of(other).terms.items():
            total[k] = total.get(k, _ZERO) + v
        return Form(total)

    __radd__ = __add__

    def __neg__(self) -> Form:
        return Form({k: -v for k, v in self.terms.items()})

    def __sub__(self, other: Any) -> Form:
        return self + -Form.of(other)

    def __rsub__(self, other: Any) -> Form:
        return -self + other

    def __mul__(self, other: Any) -> Form:
        total: dict[tuple[str, ...], Exact] = {}
        for j, a in self.terms.items():
            for k, b in Form.of(other).terms.items():
                key = tuple(sorted(j + k))
                if len(key) > 3:
                    raise Unread("a product of many names is not read")
                total[key] = total.get(key, _ZERO) + a * b
        return Form(total)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Form:
        x = Form.of(other)
        if not x.terms:
            raise Unread("a quotient has the divisor 0")
        if set(x.terms) != {()}:
            raise Unread("a quotient by a name is not read")
        return Form({k: v / x.terms[()] for k, v in self.terms.items()})

    def __rtruediv__(self, other: Any) -> Form:
        return Form.of(other) / self

    def as_fraction(self) -> None:
        """Return nothing: no form is a number."""

    def sqrt(self) -> Exact:
        """Raise: a root of names is not read."""
        raise Unread("a root of a name is not read")

    __pow__ = root = sqrt


def atom(name: str) -> Number:
    """Return a name as a value."""
    return Number(Form({(name,): _ONE}))  # type: ignore[arg-type]


def _sum(x: Number, other: Form) -> Number:
    return Number(other + x.value, x.places, x.size)  # type: ignore[arg-type]


def form(x: Any) -> Form:
    """Return the form of a number; :class:`~.values.Unread` is raised for anything else."""
    if not isinstance(x, Number):
        raise x if isinstance(x, Unread) else Unread("a number is expected")
    return Form.of(x.value)


# --- tokens ---------------------------------------------------------------------------------------


def _loops(row: Sequence[Token]) -> set[str]:
    """Return the names that loops count with."""
    found: set[str] = set()
    for k, x in enumerate(row):
        if x.text in _THREADS:
            found |= {row[k - 2].text} if k > 1 and row[k - 1].text == "=" else set()
        if x.text in _LOOPS:
            for y, z in zip(row[k + 1 : k + 7], row[k + 2 : k + 8], strict=False):
                if y.kind == "name" and z.text in ("=", "in", "∈", ",", ":="):
                    found.add(y.text)
                if y.text in ("in", "∈", ";"):
                    break
    return found


def _elementwise(row: list[Token], counts: set[str]) -> list[Token]:
    """Return tokens in which what is done to each entry of vectors is done to them.

    ``[a + h*b for a, b in zip(y, k)]`` and ``y.map((a, i) => a + h*k[i])`` become ``(y + h*k)``;
    names of indices are added to `counts`.
    """
    found: list[Token] = []
    k = 0
    while k < len(row):
        x, k = row[k], k + 1
        end = _partner(row, k - 1) if x.text in ("[", "(") else k
        inside = row[k:end]
        words = [y.text for y in inside]
        made: list[Token] | None = None
        if x.text == "[" and "for" in words and "in" in words[words.index("for") :]:
            loop = words.index("for")
            over = words.index("in", loop)
            source = inside[over + 1 :]
            zipped = words[over + 1 : over + 3] == ["zip", "("]
            values = _parts(source[2:-1]) if zipped else [source]
            made = _renamed(inside[:loop], inside[loop + 1 : over], values, counts)
        elif "=>" in words and [y.text for y in found[-2:]] == [".", "map"] and len(found) > 2:
            arrow = words.index("=>")
            if words[arrow + 1 : arrow + 2] != ["{"]:
                made = _renamed(inside[arrow + 1 :], inside[:arrow], [[found[-3]]], counts)
                found[-3:] = []
        if made is None:
            found.append(x)
            continue
        found += [x._replace(text="("), *_elementwise(made, counts), x._replace(text=")")]
        k = end + 1
    return found


def _renamed(
    row: Sequence[Token], names: Sequence[Token], values: Sequence[list[Token]], counts: set[str]
) -> list[Token]:
    """Return tokens with vectors for the names of their entries; further names are indices."""
    given = [x.text for x in names if x.kind == "name"]
    vectors = {x: y[0] for x, y in zip(given, values, strict=False) if len(y) == 1}
    counts |= {x for x in given if x not in vectors}
    return [vectors.get(x.text, x) for x in row]


def flat(given: Sequence[Token], language: Language) -> list[Token]:
    """Return tokens in which ``k[0][i]`` is the name ``k[0]``, ``f.(`` and ``f!(`` are ``f(``."""
    row = [x for x in given if x.text != "self" or language.name != "rust"]
    counts = _loops(row)
    if any(x.text in ("for", "=>") for x in row):
        row = _elementwise(row, counts)
    between = counts | {",", ":", ".", "end", "-", "+"}

    def plain(text: str) -> bool:
        return text.isdigit() or text in between

    found: list[Token] = []
    k = 0
    while k < len(row):
        x = row[k]
        nxt = row[k + 1].text if k + 1 < len(row) else ""
        if (x.text == "." and nxt in ("=", "+=", "-=", "(")) or (
            x.text == "!" and nxt == "(" and found and found[-1].kind == "name"
        ):
            k += 1
            continue
        if x.text == "<<" and nxt == "<":  # a launch f<<<blocks, threads>>>(
            k = next((j for j in range(k, len(row)) if row[j].text == "("
                      and row[j - 1].text.endswith(">")), len(row))  # fmt: skip
            continue
        if x.text == "(" and [y.text for y in row[k + 1 : k + 2]] == ["*"] and [
            y.text for y in row[k + 3 : k + 5]] == [")", "("]:  # fmt: skip
            found.append(row[k + 2])  # (*f)(
            k += 4
            continue
        found.append(x)
        k += 1
        opens = ("[", "(") if language.calls_index else ("[",)
        while x.kind == "name" and k < len(row) and row[k].text in opens:
            # not up to the partner, which may be far away in brackets that are nested
            end = next((j for j in range(k + 1, len(row)) if not plain(row[j].text)), len(row))
            inside = row[k + 1 : end]
            if not inside or end == len(row) or row[end].text not in ("]", ")"):
                break
            index = [y.text for y in inside if y.text.isdigit()]
            if row[k].text == "(" and not any(y.text == ":" or y.text in counts for y in inside):
                break  # a call
            if index:
                found[-1] = found[-1]._replace(text=f"{found[-1].text}[{','.join(index)}]")
            k = end + 1
    return found


def statements(row: Sequence[Token], language: Language) -> Iterator[list[Token]]:
    """Yield the statements of a function without their ends."""
    by_line = not language.braces or language.by_line
    start, depth = 0, 0
    for k, x in enumerate(row):
        if x.kind == "mark":
            depth += (x.text in ("(", "[")) - (x.text in (")", "]"))
        line = x.kind == "line" and by_line and depth <= 0 and ends(row, k)
        if (depth <= 0 and x.text in (";", "{", "}")) or line:
            said = [y for y in row[start:k] if y.kind != "line"]
            if said:
                yield said
            start, depth = k + 1, 0
    said = [y for y in row[start:] if y.kind != "line"]
    if said:
        yield said


def _headless(row: list[Token]) -> list[Token]:
    """Return a statement without ``for (..)``, ``if (..)`` and ``call`` before it."""
    while row:
        word = row[0].text.lower()
        if word in ("for", "if", "while") and len(row) > 1 and row[1].text == "(":
            row = row[_partner(row, 1) + 1 :]
        elif word in ("for", "if", "while", "do", "elif", "with", "def", "function", "subroutine"):
            return []
        elif word in ("call", "@", "await", "mut", "let", "const", "auto", "var"):
            row = row[1:]
        else:
            return row
    return row


#: Parameters and statements of functions, by their names.
Functions = dict[str, tuple[list[str], list[list[Token]]]]


def functions(blocks: Sequence[Block], collector: Collector) -> Functions:
    """Return the functions that set what they are given, call nothing and choose nothing."""
    found: Functions = {}
    lines = [x.line for x in collector.tokens]
    for block in blocks if collector.language.braces else ():
        if block.kind != "code" or block.parent is None or block.name in BRANCHES | _LOOPS:
            continue
        low, high = bisect_left(lines, block.line), bisect_right(lines, block.last)
        row = flat(collector.tokens[low:high], collector.language)
        at = next((k for k, x in enumerate(row) if x.text == "("), 0)
        end = _partner(row, at)
        parts = _parts(row[at + 1 : end])
        names = [y.text for x in parts for y in [z for z in x if z.kind == "name"][-1:]]
        every = list(statements(row[end + 1 :], collector.language))
        said = [x for x in every if _equal(x)]
        sets = any(x[e - 1].text in names for x in said if (e := _equal(x)))
        known = {"return", *_loops(collector.tokens[low:high])}  # no choice but of entries
        chosen = any(x[0].text in {"if", *BRANCHES} and not known & {y.text for y in x}
                     for x in every)  # fmt: skip
        if at and sets and not chosen and not calls(row[end + 1 :]):
            found[row[at - 1].text] = names, said
    return found


def followed(row: Sequence[Token], known: Functions) -> list[Token]:
    """Return tokens in which a statement that calls a known function is what that one does."""
    found: list[Token] = []
    k = 0
    while k < len(row):
        x, k = row[k], k + 1
        begins = not found or found[-1].kind == "line" or found[-1].text in (";", "{", "}")
        function = known.get(x.text) if begins else None
        end = _partner(row, k) if function and [y.text for y in row[k : k + 1]] == ["("] else k
        given = _parts(row[k + 1 : end])
        names, said = function or ([], [])
        if not names or len(given) != len(names):
            found.append(x)
            continue
        held = {
            name: [x._replace(kind="mark", text="("), *part, x._replace(kind="mark", text=")")]
            if {"+", "-"} & {y.text for y in part} else [y for y in part if y.text != "&"]
            for name, part in zip(names, given, strict=True)
        }  # fmt: skip
        for statement in said:
            found += [z for y in statement for z in held.get(y.text, [y])]
            found.append(x._replace(kind="mark", text=";"))
        k = end + 1
    return found


@dataclass
class _Call:
    """A call: the index of its name, its arguments, and whether its value is used."""

    name: str
    at: int
    arguments: list[list[Token]]
    valued: bool


def calls(row: Sequence[Token]) -> list[_Call]:
    """Return the calls of what may be a right-hand side: of no more stages than a method has."""
    found: list[tuple[str, int, bool]] = []
    for k in range(len(row) - 1):
        if row[k].kind != "name" or row[k + 1].text != "(":
            continue
        name, first = row[k].text, k
        while (
            first >= 2
            and row[first - 1].text in (".", "->", "::")
            and row[first - 2].kind == "name"
        ):
            first -= 2
            name = f"{row[first].text}.{name}"
        if _OTHER.fullmatch(name) or name.rpartition(".")[2].lower() in ARITHMETIC:
            continue
        before = row[first - 1] if first else None
        plain_call = before is None or before.kind == "line" or before.text in (";", "{", "}", ")",
                                                                               "call")  # fmt: skip
        if before is not None and before.kind == "name" and before.text not in ("call", "return"):
            continue  # a declaration
        found.append((name, k, not plain_call))
    many = Counter(name for name, *_ in found)
    return [
        _Call(name, k, _parts(row[k + 2 : _partner(row, k + 1)]), valued)
        for name, k, valued in found
        if many[name] <= STAGES
    ]


def _lone(part: Sequence[Token]) -> str:
    """Return the name that an argument is, or ``""``."""
    names = [x.text for x in part if x.text not in ("&", "*", "mut", ".", "->")]
    return names[-1] if names and all(
        x.kind == "name" or x.text in ("&", "*", ".", "->") for x in part) else ""  # fmt: skip


# --- a step ---------------------------------------------------------------------------------------


class StepFolder(Folder):
    """A folder in which one name is the right-hand side."""

    step: Step

    def _known(self, name: str) -> bool:
        return name in self.step.values

    def _call(self, name: str, t: Token) -> Any:
        if self.step.is_slope(name, self):
            return self.step.stage(self._arguments()[0])
        owner, _, last = name.rpartition(".")
        sign = ARITHMETIC.get(last.lower())
        if sign:
            given = [x for _, x in self._arguments()[0]]
            given = [self.look(owner), *given] if owner and len(given) == 1 else given
            if len(given) != 2 or not all(isinstance(x, Number) for x in given):
                raise Unread(f"the function {name[:40]!r} is not read", t.line)
            return pairwise(sign, *given)
        return super()._call(name, t)


@dataclass
class Step:
    """A function carried out with one callee as the right-hand side."""

    block: Block
    collector: Collector
    callee: str
    count: int  #: Number of the arguments of a call.
    output: int  #: Place of the argument that takes the slope, -1 where the call returns it.
    again: set[str]  #: Names that are assigned to twice.
    values: dict[str, Any] = field(default_factory=dict)
    order: list[str] = field(default_factory=list)  #: Names in the order of their assignments.
    places: list[list[Number | None]] = field(default_factory=list)
    clock: Number | None = None  #: Time in the last call of another function, as of a field.
    clocks: list[Number | None] = field(default_factory=list)  #: Of each stage.
    used: set[int] = field(default_factory=set)  #: What has been the argument of a stage.
    returned: Any = None
    out: set[str] = field(default_factory=set)
    trouble: bool = False  #: Whether a sum of slopes has a name in it that is not read.
    lost: bool = False  #: Whether slopes go to a call, or to a statement, that is not followed.
    why: str = ""  #: What the first statement that is not read says.

    def look(self, name: str) -> Any:
        """Return what a name holds; a name that holds nothing stands for itself."""
        for word in _OWN:
            name = name.removeprefix(f"{word}.")
        if name in self.values:
            x = self.values[name]
            if isinstance(x, Unread):
                raise x
            return x
        base, _, index = name.partition("[")
        if index and isinstance(self.values.get(base), list):
            return self._part(self.values[base], index)
        if not _LOOSE.fullmatch(name.rpartition(".")[2]) and name not in self.again:
            try:
                x = self._part(Collector._look(self.block)(base), index)
                if isinstance(x, Number):
                    return plain(x)
            except (Unread, LookupError, TypeError):
                pass
        return atom(name)

    def _part(self, x: Any, index: str) -> Any:
        """Return the entry of nested lists at the numbers of ``2,1]``."""
        for k in re.findall(r"\d+", index):
            x = x[int(k) - self.collector.language.base]
        return x

    def is_slope(self, name: str, folder: Folder) -> bool:
        """Return whether a call gives a slope: of the callee, or of one that is called alike."""
        if name == self.callee:
            return True
        if self.output < 0 or _OTHER.fullmatch(name):
            return False
        end = _partner(folder.tokens, folder.at)
        parts = _parts(list(folder.tokens[folder.at + 1 : end]))
        if len(parts) != self.count:
            return False
        given = _lone(parts[self.output])
        return given in self.out and given not in self.values

    def stage(self, given: Sequence[tuple[str, Any]]) -> Number:
        """Note a stage and return its slope."""
        places: list[Number | None] = []
        for k, (label, x) in enumerate(given):
            if k != self.output:
                held = self.values.get(label)
                if isinstance(x, Number) and isinstance(held, Number) and held.place:
                    x.place = held.place
                self.used.add(id(x.value) if isinstance(x, Number) else 0)
                places.append(x if isinstance(x, Number) else None)
        self.places.append(places)
        self.clocks.append(self.clock)
        slope = atom(f"#{len(self.places)}")
        if self.output >= 0:
            name = given[self.output][0]
            self.values[name] = slope
        return slope

    def fold(self, row: Sequence[Token], reader: type[StepFolder] = StepFolder) -> Any:
        """Return the value of an expression."""
        folder = reader(row, self.collector.language, self.look)
        folder.step = self
        x = folder.expression()
        rest = folder.peek()
        if rest is not None and rest.text not in (",", ":"):
            raise Unread(f"{rest.text!r} is not read here", rest.line)
        if isinstance(x, list) and x and all(isinstance(y, Number) for y in x[:1]):
            return x[0] if len(x) == 1 else x
        return x

    def take(self, row: list[Token]) -> None:
        """Carry out a statement."""
        if row[0].text.lower() == "associate":
            for part in _parts(row[2 : _partner(row, 1)]):
                if len(part) > 2 and part[1].text == "=>" and part[0].text not in self.out:
                    self._set(part[0].text, part[2:], "=")
            return
        row = _headless(row)
        if not row:
            return
        if row[0].text == "return":
            self._end(row[1:] or row)
            return
        equal = _equal(row)
        if (
            equal is None
            and [x.text in _APPENDS for x in row[2:3]] == [True]
            and row[1].text == "."
        ):
            self._set(row[0].text, row[4 : _partner(row, 3)], "=")  # each entry, by a loop
            return
        if equal is None:
            before, returned = len(self.places), self.returned
            self._end(row)
            if any(not x.valued for x in calls(row)) and len(self.places) == before:
                self.lost |= self._adds(row)
                self.returned = returned
            return
        left = row[:equal]
        mark = next((k for k, x in enumerate(left) if x.text in ("::", ":")), None)
        if mark is not None and left[mark].text == ":":
            left = left[:mark]
        elif mark is not None and self.collector.language.name == "fortran":
            left = left[mark + 1 :]
        if not left or left[-1].kind != "name":
            return
        self._note_time(row[equal + 1 :])
        targets, given = _parts(left), _parts(row[equal + 1 :])
        if len(targets) > 1:
            self._set_at_once(targets, given)
            return
        first = len(left) - 1
        while first >= 2 and left[first - 1].text in (".", "->") and left[first - 2].kind == "name":
            first -= 2
        owner = [x.text for x in left[first:-1:2] if x.text not in _OWN]
        self._set(".".join([*owner, left[-1].text]), row[equal + 1 :], row[equal].text)

    def _note_time(self, row: Sequence[Token]) -> None:
        """Note the time that another function is given: ``e = field(E, y, t0 + 3*h/10)``."""
        for part in (y for x in calls(row) if x.name != self.callee for y in x.arguments):
            if {"t", "t0", "time", "T"} & {y.text for y in part} and len(part) < 16:
                with suppress(GlmrefError, Unread, *ACCIDENTS):
                    x = self.fold(part)
                    if isinstance(x, Number) and not _slopes(x):
                        self.clock = x.of(form(x))  # type: ignore[arg-type]
                        self.clock.place = (part[0].line, " ".join(y.text for y in part)[:80])

    def _adds(self, row: Sequence[Token]) -> bool:
        """Return whether a call, which is no stage, may add slopes to what it is given.

        Not to a slope itself, and no more to an estimate where the new value has been set.
        """
        given = row[2:] if [x.text for x in row[1:2]] == ["."] else row
        stored = [self.values.get(_lone(y)) for x in calls(row) for y in x.arguments]
        if len(stored) == 1 and _slopes(stored[0]) and len(form(stored[0]).terms) > 2:
            return False  # the new value is kept: set_state(y)
        held = [x for x in map(self.values.get, (y.text for y in given)) if _slopes(x)]
        new = [x for x in self.values.values() if _slopes(x) and id(x.value) not in self.used
               and any(len(k) == 1 and k[0][0] != "#" for k in form(x).terms)]  # fmt: skip
        return any(len(form(x).terms) == 1 or not new or x in new for x in held)

    def _set_at_once(
        self, targets: Sequence[Sequence[Token]], given: Sequence[Sequence[Token]]
    ) -> None:
        """Set several names to numbers; one that is set to a sum of others is not followed."""
        if len(given) == 1 < len(targets):  # k, d = COEFFICIENTS
            with suppress(Unread):
                held = Collector._look(self.block)("".join(x.text for x in given[0]))
                if isinstance(held, list) and len(held) == len(targets):
                    self.values |= {y[-1].text: x for y, x in zip(targets, held, strict=True)}
                    return
        for k, target in enumerate(targets):
            try:
                x = self.fold(given[k]) if len(given) == len(targets) else None
            except Unread:
                x = None
            number = isinstance(x, Number) and not set(form(x).terms) - {()}
            name = "".join(y.text for y in target)
            if number and (name in self.again or _LOOSE.fullmatch(name)):
                x = atom(name)
            self.values[name] = x if number else Unread("several names are set at once")

    def _end(self, row: Sequence[Token]) -> None:
        """Note what is returned, by that word or by an expression at the end."""
        try:
            x = self.fold(row)
        except Unread as error:
            x = error
        if isinstance(x, Number) and _slopes(x) and len(row) > 1:  # a name has its own
            x.place = (row[0].line, " ".join(y.text for y in row)[:80])
        if isinstance(x, list) or (_slopes(x) and len(form(x).terms) > 1):
            self.returned = x

    def _set(self, name: str, row: Sequence[Token], sign: str) -> None:
        if {"nan", "quiet_nan", "inf", "infinity"} & {x.text.lower() for x in row}:
            return  # where a step fails
        try:
            x = self.fold(row)
            if isinstance(x, list) or not isinstance(x, Number):
                raise Unread(f"what {name} is set to is not read")
            if sign in ("+=", "-="):
                old = self.look(name)
                value = old.value + x.value if sign == "+=" else old.value - x.value
                x = old.of(value, x)
            elif sign not in ("=", ":="):
                raise Unread(f"the operator {sign} is not read")
            constant = not isinstance(x.value, Form) or not set(x.value.terms) - {()}
            if constant and (name in self.again or _LOOSE.fullmatch(name)):
                x = atom(name)
            x.place = (row[0].line, " ".join(y.text for y in row)[:80])
        except Unread as error:
            self.why = self.why or str(error)
            self.trouble |= any(_slopes(self.values.get(y.text)) for y in row) and any(
                isinstance(self.values.get(y.text), Unread) for y in row
            )
            begins = not self.places and (name in self.again or _LOOSE.fullmatch(name))
            x = atom(name) if begins else error
        self.values[name] = x
        if name in self.order:
            self.order.remove(name)
        self.order.append(name)

    # --- what it is ---------------------------------------------------------------------------

    def finished(self) -> Table | None:
        """Return the table, or ``None`` where it is no step that is understood."""
        width = min(map(len, self.places), default=0)
        at = [k for k in range(width) if any(_slopes(x[k]) for x in self.places)]
        if not at and len(self.places) == 1:  # of one stage
            values = [form(x).terms for x in self.values.values() if isinstance(x, Number)]
            at = [k for k in range(width) if any(
                (_name_of(self.places[0][k]),) in x and len(x) > 1 for x in values)]  # fmt: skip
        forms = [x[at[0]] for x in self.places] if len(at) == 1 else [None]
        read = [x for x in forms if x is not None]
        if len(read) < len(forms):
            return None
        given = self._first_slope(read)
        terms = [key for x in read for key in form(x).terms]
        states = {key[0] for key in terms if len(key) == 1 and not key[0].startswith("#")}
        if len(states) != 1:
            return None
        (state,) = states
        if given:
            read.insert(0, atom(state))
        slopes = [*([given] if given else []), *(f"#{k + 1}" for k in range(len(self.places)))]
        names = {name: k for k, name in enumerate(slopes)}
        step = self._step_of(read, set(names))
        A = [_row(x, state, step, names) for x in read] if step is not None else [None]
        rows = [x for x in A if x is not None]
        found = self._weights(state, step or (), names) if len(rows) == len(A) else None
        if found is None:
            numbers = [v for x in read for k, v in form(x).terms.items() if v not in (1, -1)]
            why = f"{_UNREAD}: {self.why}" if self.why else _UNREAD
            return Table("", 0, unread=why, general=True) if numbers or self.trouble else None
        b, more, errors, guessed = found
        table = Table("", 0, A=[rows], b=[b], rows=more, errors=errors, general=True)
        table.guessed, table.sure, table.followed = guessed, False, not self.lost
        table.c = [self._times(at[0], step or (), bool(given))]
        _drop(table)
        return table

    @staticmethod
    def _first_slope(places: Sequence[Number]) -> str:
        """Return the name of a slope at the start that no call gives, as ``dydx`` of a function."""
        products = [key for x in places for key in form(x).terms if len(key) > 1]
        steps = {y for key in products if any(z.startswith("#") for z in key) for y in key}
        others = {y for key in products for y in key if y not in steps and not y.startswith("#")}
        return others.pop() if len(others) == 1 and steps else ""

    def _step_of(self, places: Sequence[Number], slopes: set[str]) -> tuple[str, ...] | None:
        """Return the names by which all slopes are multiplied."""
        values = [*places, *(self.values[x] for x in self.order[-1:] if len(places) == 1)]
        found = {tuple(y for y in key if y not in slopes) for x in values for key in form(x).terms
                 if set(key) & slopes}  # fmt: skip
        return found.pop() if len(found) == 1 else None

    def _weights(self, state: str, step: tuple[str, ...], names: Mapping[str, int]) -> Any:
        """Return b, further rows, error weights, and whether b is a guess; or ``None``."""
        done: list[tuple[str, Number, list[Number]]] = []
        errors: list[list[Number]] = []
        unit = Form({(state,): _ONE})
        for name in self.order:
            x = self.values.get(name)
            if not isinstance(x, Number) or not isinstance(x.value, Form):
                continue
            row = _row(x, state, step, names)
            row = row if row is not None else _row(x, name, step, names)  # y beside its copy y0
            if row is not None and any(y.value != 0 for y in row):
                done.append((name, x, row))
                continue
            row = _row(_sum(x, unit), state, step, names)
            if row is not None and sum(y.value != 0 for y in row) > 1:
                total = abs(complex(sum((y.value for y in row), _ZERO)))
                errors += [row] if total < 0.5 else []
        free = [x for x in done if id(x[1].value) not in self.used]
        full = [x for x in free if abs(complex(sum((y.value for y in x[2]), _ZERO)) - 1) < _SUM]
        values = self.returned if isinstance(self.returned, list) else [self.returned]
        for x in values:
            if isinstance(x, Number) and _slopes(x):
                rows = [_row(x, state, step, names)]
                rows += [_row(_sum(x, unit), state, k, names) for k in (step, ())]
                row = next((y for y in rows if y is not None), None)
                if row is None:
                    return None
                return row, [(n, r, None) for n, y, r in full if r != row and y is not x], errors, 0
        own = [x for x in done if x[0] == state or (x[0],) in form(x[1]).terms]
        off = [x for x in full if abs(complex(sum((y.value for y in x[2]), _ZERO)) - 1) > 1e-6]
        last = own[-1:] or (off if len(full) > 1 else [])[:1] or (free or done)[-1:]
        if not last:
            return None
        rest = [(n, r, None) for n, _, r in full if n != last[0][0]]
        return last[0][2], rest, errors, bool(rest) and not own

    def _times(self, at: int, step: tuple[str, ...], given: bool) -> list[Number] | None:
        """Return the nodes, where an argument of all stages is a time and a part of the step."""
        for k in range(-1, len(self.places[0])):
            column = [x[k] if k < len(x) else None for x in self.places] if k >= 0 else self.clocks
            read = [x for x in column if x is not None]
            if k == at or not step or len(read) < len(column):
                continue
            terms = [form(x).terms for x in read]
            names = {key for x in terms for key in x if key not in (step, ())}
            if len(names) > 1 or not all(len(x) == 1 for x in names):
                continue
            if any(step in x for x in terms):
                rows = [x.of(y.get(step, _ZERO)) for x, y in zip(read, terms, strict=True)]
                for x, y in zip(rows, read, strict=True):
                    x.place = y.place
                return [ZERO, *rows] if given else rows
        return None


class Atoms(StepFolder):
    """A folder in which a call that is not known stands for its value."""

    def _call(self, name: str, t: Token) -> Any:
        start = self.at
        try:
            found = super()._call(name, t)
            if isinstance(found, Number):
                return found
        except Unread:
            pass
        self.at = self.partner(start) + 1
        return atom(f"{name}()")


class Names(Step):
    """A function carried out with names and calls that are not read standing for themselves."""

    def follow(self, row: Sequence[Token]) -> None:
        """Carry out the statements of a function; those that are not read are passed over."""
        for statement in statements(row, self.collector.language):
            with suppress(GlmrefError, Unread, *ACCIDENTS):
                self.take(statement)

    def look(self, name: str) -> Any:
        """Return what a name holds; what is not read stands for itself."""
        try:
            return super().look(name)
        except Unread:
            return atom(name)

    def fold(self, row: Sequence[Token], reader: type[StepFolder] = Atoms) -> Any:
        """Return the value of an expression."""
        return super().fold(row, reader)


def _slopes(x: Any) -> bool:
    return isinstance(x, Number) and any(y.startswith("#") for key in form(x).terms for y in key)


def _name_of(x: Number | None) -> str:
    """Return the name that a value is, or ``""``."""
    terms = form(x).terms if x is not None else {}
    ((key, v),) = terms.items() if len(terms) == 1 else (((), 0),)
    return key[0] if len(key) == 1 and v == 1 else ""


def _row(
    x: Number, state: str, step: tuple[str, ...], names: Mapping[str, int]
) -> list[Number] | None:
    """Return the coefficients of the slopes in a value that holds the state once, in order."""
    terms = form(x).terms
    row = [ZERO] * len(names)
    once = terms.get((state,))
    if once is None or abs(complex(once) - 1) > 1e-9:
        return None
    for key, v in terms.items():
        if key == (state,):
            continue
        rest = [y for y in key if y in names]
        if len(rest) != 1 or tuple(y for y in key if y not in names) != step:
            return None
        row[names[rest[0]]] = number = x.of(v)
        number.place = x.place
    return row


def _drop(table: Table) -> None:
    """Leave out stages that nothing uses.

    In a step of order 1 one may have been meant to be used, if it is no slope at the new value.
    """
    A, b, c = table.A[0], table.b[0], table.c[0]
    rows = [*A, b, *table.errors, *(r for _, r, _ in table.rows)]
    moment = sum((x.value * y.value for x, row in zip(b, A, strict=True) for y in row), _ZERO)
    low = abs(complex(moment) - 0.5) > _SUM / 10
    keep = [
        j
        for j in range(len(b))
        if any(r[j].value != 0 for r in rows)
        or (
            low
            and any(x.value != 0 for x in A[j])
            and any(x.value != y.value for x, y in zip(A[j], b, strict=True))
        )
    ] or [0]
    table.A = [[[A[i][j] for j in keep] for i in keep]]
    table.b = [[b[j] for j in keep]]
    table.c = [[c[j] for j in keep] if c is not None else None]
    table.errors = [[r[j] for j in keep] for r in table.errors]
    table.rows = [(n, [r[j] for j in keep], p) for n, r, p in table.rows]


def _is_flag(row: Sequence[Token], made: Sequence[_Call], said: Sequence[list[Token]]) -> bool:
    """Return whether what calls return goes to one name that no sum uses: ``s = f(t, y, k)``."""
    names = {row[x.at - 2].text if row[x.at - 1].text == "=" else "" for x in made}
    return len(names) == 1 and "" not in names and not any(
        y.text in names for s in said if (e := _equal(s)) is not None for y in s[e + 1 :]
    )  # fmt: skip


def _depends(made: Sequence[_Call], said: Sequence[list[Token]], output: int) -> bool:
    """Return whether a call may be given what one of them gave: else they are no stages.

    That stands in a name that takes the slope, in one that is set to a value with such a name or
    call in it, or in the argument itself; statements are carried out once, in their order.
    """

    def names(row: Sequence[Token]) -> set[str]:
        return {x.text.partition("[")[0] for x in row if x.kind == "name"}

    held = {x.name.rpartition(".")[2] for x in made}
    held |= {
        name for x in made for part in x.arguments[output : output + 1] for name in names(part)
    }
    for row in said:
        equal = _equal(row)
        if row[0].text.lower() == "associate":
            held |= names(row)
        elif equal is not None and held & names(row[equal:]):
            held |= names(row[:equal]) - {*_OWN}
    given = (part for x in made for k, part in enumerate(x.arguments) if k != output)
    return any(held & names(part) for part in given)


def steps_of(block: Block, row: Sequence[Token], collector: Collector) -> Iterator[Table]:
    """Yield the steps that a function of flat tokens makes, one for each right-hand side."""
    language = collector.language
    every = calls(row)
    groups: dict[tuple[str, int], list[_Call]] = {}
    for x in every:
        groups.setdefault((x.name, len(x.arguments)), []).append(x)
    wanted = [x for x in groups.items() if 1 <= x[0][1] <= 8 and len(x[1]) > 1]
    if EULER.search(block.name):
        wanted += [x for x in groups.items() if x[0][1] < 5 and len(x[1]) == 1]
    if not wanted:
        return
    said = list(statements(row, language))
    assigned = [(n, s[e - 1].text) for n, s in enumerate(said)
            if (e := _equal(s)) and s[e].text in ("=", ":=")]  # fmt: skip
    targets = Counter(name for _, name in assigned)
    rights = Counter(y.text for s in said for y in s[(_equal(s) or -1) + 1 :] if y.kind == "name")
    for (name, count), made in sorted(wanted, key=lambda x: -len(x[1]))[:4]:
        output, begin = -1, row[made[0].at]
        first = next((n for n, s in enumerate(said) if any(y is begin for y in s)), 0)
        later = {name for n, name in assigned if n >= first}
        if not all(x.valued for x in made) or _is_flag(row, made, said):
            places = []
            for k in range(count):
                outs = [_lone(x.arguments[k]) for x in made]
                used = sum(rights[y] > outs.count(y) for y in outs)  # the last may be for later
                if used and used >= len(outs) - 1 and all(y and y not in later for y in outs):
                    places.append((len(set(outs)), k))
            if not places:
                continue
            output = max(places)[1]
        alike = (
            made
            if output < 0
            else [x for x in every if len(x.arguments) == count and x.valued == made[0].valued]
        )
        begin = row[min(x.at for x in alike)]
        first = next((n for n, s in enumerate(said) if any(y is begin for y in s)), 0)
        if len(made) > 1 and not _depends(alike, said[first:], output):
            continue
        first, last = made[0].at, made[-1].at
        if any(x.text in BRANCHES for x in row[first:last]):
            continue
        step = Step(block, collector, name, count, output,
                     {x for x, n in targets.items() if n > 1})  # fmt: skip
        step.out = {_lone(x.arguments[output]) for x in alike if output >= 0}
        for statement in said:
            try:
                step.take(statement)
            except (GlmrefError, Unread, *ACCIDENTS):
                step.lost = True
                break
        try:
            found = step.finished()
        except Unread:  # one of its values is no number
            found = None
        if found is not None:
            found.line, found.last = row[first].line, row[last].line
            yield found
