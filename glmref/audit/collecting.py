"""Named values of a source: which name gets which numbers, in which block, on which line.

Statements are carried out in the order of the file, none of them runs. A block is a function, a
class, a struct, a call with named arguments, or an object whose fields get values.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from ..exact import Exact
from ..system.budget import spend
from .folding import Entries, Folder, Frame, Record, flattened, plain
from .lexer import Language, Token, tokens
from .values import Number, Unread, literal, whole_number

_TYPES_OF_INTEGERS = frozenset(
    "int auto let const var static constexpr unsigned size_t long short uint integer PetscInt mut "
    "parameter final".split()
)
_HEADS = frozenset(
    "struct class namespace enum union interface impl trait extern fn func function mod if for "
    "while do else try catch switch match unsafe loop template module".split()
)
#: Words of a choice that begin a statement with what its subject is: ``elif name == "RK4":``.
_CHOSEN = frozenset("if elif elseif else case otherwise".split())
#: Words before a block that is no function, class or object.
CHOICES = frozenset("if else for while switch match".split())
_OWN = frozenset("self this Self cls".split())
#: Other names of quotients: ``Fraction as F``, ``Q = Rational``, ``#define Q(a, b) (1.0*(a)/(b))``.
_ALIAS = re.compile(
    r"\b(?:Fraction|Rational)\s+as\s+(\w+)|^\s*(\w+)\s*=\s*(?:\w+\.)?(?:Fraction|Rational)\s*$"
    r"|^[ \t]*#[ \t]*define[ \t]+(\w+)\(\w+, ?\w+\)[ \t]*\(?[^\n/]*\w\)?[ \t]*/[^\n/]*$",
    re.MULTILINE,
)
#: Numbers in words, which come from another module where they have no value.
_SPELT = {x: Exact(k) for k, x in enumerate(
    "zero one two three four five six seven eight nine ten".split())}  # fmt: skip
_SPELT["half"] = Exact(1) / 2
#: Brackets that are not paired, or one pair in another, and ends of statements.
_UNPAIRED = re.compile(r"^[^()\[\]{};]*(?:\([^()\[\]{};]*\)[^()\[\]{};]*)*[()\[\]{};]")
#: A list in a text that is compiled at run time.
_DECLARED = re.compile(r"[A-Za-z_]\w*\[\w*\] *= *\{[-+\w., ]*\}")
#: What makes an array of another one, entries of which are set later.
_ARITHMETIC = frozenset("sum dot matmul @ *".split())
_CONTINUES = frozenset("+ - * / // ** ^ = , ( [ { && || \\ :: ? .".split())


@dataclass
class Item:
    """A value under a name."""

    name: str
    value: Any
    line: int
    at: int  #: Number of its statement.
    #: Reason why its value is not that of the source, or ``""``.
    lost: str = ""
    last: int = 0  #: Line of the last entry.
    index: int | None = None  #: Which of several objects it is a field of.


@dataclass
class Block:
    """A function, class, call or object with its items."""

    name: str
    line: int
    parent: Block | None = None
    kind: str = "code"  #: ``"code"``, ``"record"`` or ``"case"``.
    indent: int = -1
    last: int = 0  #: Last line.
    items: list[Item] = field(default_factory=list)
    names: dict[str, Any] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)
    #: Names and whole numbers among the arguments of a call, by their places.
    called: str = ""
    label: str = ""  #: What a call calls its table.
    arguments: list[tuple[str, int | None]] = field(default_factory=list)
    user: Block | None = None  #: The block that has this one as a value.
    depth: int = 0  # of round brackets around a block in a macro
    own: str = ""  #: What a method that is defined outside of its class is called.
    subject: str = ""  #: Name of what a choice is about.
    #: Numbers of names of other files, where this is the outermost block.
    beyond: Mapping[str, str] = field(default_factory=dict)
    #: Names that the file declares, each with the numbers that functions give it.
    declared: dict[str, list[Number]] = field(default_factory=dict)

    def path(self) -> list[str]:
        """Return names from the outermost block to this one."""
        above = self.parent.path() if self.parent else []
        return [*above, self.name] if self.name else above


class Collector:
    """The blocks of one source.

    Parameters
    ----------
    text : str
    language : Language
    fixed : bool
        Whether it is Fortran in fixed form.
    lines : set of int, optional
        Lines of which the statements of functions and classes are carried out, by default all.
    beyond : Mapping of str to str, optional
        Numbers that other files give names.
    """

    def __init__(
        self, text: str, language: Language, *, fixed: bool = False, lines: set[int] | None = None,
        beyond: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        self.text, self.language, self.lines = text, language, lines
        given, self.remarks = tokens(text, language, fixed=fixed)
        self.tokens = [*given]
        if language.name == "fortran":
            self.tokens = [x._replace(text=".") if x.text == "%" else x for x in self.tokens]
        said = [x for x in text.split("\n") if "Fraction" in x or "Rational" in x or "define" in x]
        quotients = {x for pair in _ALIAS.findall("\n".join(said)) for x in pair if x}
        if quotients:
            self.tokens = [x._replace(text="Fraction") if x.text in quotients else x
                           for x in self.tokens]  # fmt: skip
        self.top = Block("", 1, beyond=beyond or {})
        self.block = self.top
        self.count = 0
        self.failed: list[tuple[Block, Item, Sequence[Token]]] = []
        self.calls: list[Block] = []
        self.frames: dict[int, Item] = {}
        self.fields: dict[str, list[str]] = {}  #: Of classes: ``b::Vector``, in their order.

    def blocks(self) -> list[Block]:
        """Carry out all statements and return every block; the outermost is the first."""
        if self.language.braces:
            self._braces()
        else:
            self._lines()
        last = self.tokens[-1].line if self.tokens else 1
        self._again()
        found: list[Block] = []

        def walk(block: Block) -> None:
            block.last = block.last or last
            found.append(block)
            for x in block.blocks:
                walk(x)

        walk(self.top)
        return found

    # --- statements -------------------------------------------------------------------------------

    def _matched(self) -> tuple[dict[int, int], set[int]]:
        """Return the partner of each bracket, and the braces that hold statements."""
        partner: dict[int, int] = {}
        holding: set[int] = set()
        stack: list[int] = []
        for k, x in enumerate(self.tokens):
            if x.kind != "mark":
                continue
            if x.text in ("(", "[", "{"):
                stack.append(k)
            elif x.text in (")", "]", "}"):
                while (
                    stack and {"(": ")", "[": "]", "{": "}"}[self.tokens[stack[-1]].text] != x.text
                ):
                    stack.pop()
                if stack:
                    partner[stack.pop()] = k
            elif x.text == ";" and stack and self.tokens[stack[-1]].text == "{":
                holding.add(stack[-1])
        return partner, holding

    def _braces(self) -> None:
        partner, holding = self._matched()
        toks, start, depth, k = self.tokens, 0, 0, 0
        by_line = self.language.by_line
        group: list[Token] = []  # ``const`` before the bracket around several of Go
        ends_group = -1
        while k < len(toks):
            x = toks[k]
            if x.kind == "line":
                before = toks[k - 1] if k else x
                after = toks[k + 1] if k + 1 < len(toks) else x
                ends = before.text not in _CONTINUES and after.text not in (
                    ".",
                    "?",
                    ":",
                    "{",
                    "+",
                    "-",
                    "*",
                    "/",
                )
                if by_line and depth == 0 and ends:
                    self._statement([*group, *toks[start:k]])
                    start = k + 1
            elif x.kind == "mark":
                if (
                    x.text == "#"
                    and (k == 0 or toks[k - 1].kind == "line")
                    and self.language.name == "c"
                ):
                    end = next(
                        (j for j in range(k, len(toks)) if toks[j].kind == "line"), len(toks)
                    )
                    self._define(toks[k + 1 : end])
                    if not [t for t in toks[start:k] if t.kind != "line"]:
                        start = end
                        k = end
                        continue
                    said = "".join(t.text for t in toks[k:end])
                    toks[k:end] = [t._replace(kind="line", text="\n") for t in toks[k:end]]
                    if _UNPAIRED.search(said):
                        partner, holding = self._matched()
                    k = end
                    continue
                head = [t for t in toks[start:k] if t.kind != "line"] if x.text == "(" else []
                if [t.text for t in head] in (["const"], ["var"]) and self.language.name == "go":
                    group, ends_group, start = head, partner.get(k, -1), k + 1
                elif k == ends_group:
                    self._statement([*group, *toks[start:k]])
                    group, start = [], k + 1
                elif x.text in ("(", "["):
                    depth += 1
                elif x.text in (")", "]"):
                    depth = max(0, depth - 1)
                elif x.text == "{":
                    head = [t for t in toks[start:k] if t.kind != "line"]
                    end = partner.get(k, -1)
                    if end > 0 and not self._opens(head, k, end, k in holding, depth):
                        k = end + 1
                        if self.language.name == "rust" and k < len(toks) and toks[k].text == "}":
                            self._statement(toks[start:k])
                            start = k
                        continue
                    self._open(head, x.line, depth)
                    depth, start = 0, k + 1
                elif x.text == "}":
                    self._statement(toks[start:k], tail=True)
                    depth = self.block.depth
                    self._close(x.line)
                    start = k + 1
                elif x.text == ";" and depth == 0:
                    self._statement(toks[start:k])
                    start = k + 1
            k += 1
        self._statement(toks[start:])

    def _opens(self, head: Sequence[Token], k: int, end: int, holds: bool, depth: int) -> bool:
        """Return whether the brace at k, closed at ``end``, begins a block of statements."""
        words = {t.text for t in head if t.kind == "name"}
        before = head[-1].text if head else ""
        if (holds and before != "=") or (before == "=>" and self.language.by_line):
            return True
        if before in ("=", ",", "(", "]", "return", "{") or depth:
            return False
        if "return" in words and head[-1].kind == "name" and not words & _HEADS:
            return False  # ``return &T{..}``
        if not head or words & _HEADS or before == ")":
            return not (before == ")" and "=" in {t.text for t in head} and "fn" not in words)
        after = next((t for t in self.tokens[k + 1 : k + 4] if t.kind != "line"), None)
        if after is not None and (after.kind == "number" or after.text in ("{", "-", "[", "}")):
            return not head
        ends = [t.text for t in self.tokens[end + 1 : end + 2]] == [";"]
        if ends and head[-1].kind == "name":  # ``array<T, 2> b{T(1) / 2, 0.5};``
            return False
        return not any(t.text == "=" for t in head) and self.language.name != "rust"

    def _open(self, head: Sequence[Token], line: int, depth: int) -> None:
        head = self._unlabelled(head)
        name = _named(head)
        first = head[0].line if head else line
        block = Block(name, first, self.block, depth=depth)
        marks = [x.text for x in head]
        if "(" in marks and marks[: marks.index("(")][-2:-1] == ["::"]:
            block.own = marks[marks.index("(") - 1]
        if marks[:1] == ["switch"]:
            block.name, block.subject = "switch", _last_name(head[1:])
        self.block.blocks.append(block)
        self.block = block
        pairs = [x.text + y.text for x, y in pairwise(head)]
        close = pairs.index("):") if "):" in pairs else None
        if close is not None:
            self._members(head[close + 2 :])

    def _members(self, rest: Sequence[Token]) -> None:
        """Read ``: a({1, 2}), b{3}`` of a constructor."""
        k = 0
        while k + 1 < len(rest):
            if rest[k].kind == "name" and rest[k + 1].text in ("(", "{"):
                end = _partner(rest, k + 1)
                inside = rest[k + 2 : end]
                if rest[k + 1].text == "{":
                    inside = rest[k + 1 : end + 1]
                if inside:
                    self._bind(rest[k].text, inside, rest[k].line)
                k = end
            k += 1

    def _unlabelled(self, row: Sequence[Token]) -> Sequence[Token]:
        """Return a statement without ``case 3:`` before it, in the block of that case."""
        if not row or row[0].text not in ("case", "default"):
            return row
        end = next((k for k, x in enumerate(row) if x.text == ":"), -1)
        if end > 0 and (self.block.kind == "case" or self.block.name == "switch"):
            self._case(row[1:end], row[0].line)
        return row[end + 1 :]

    def _case(self, label: Sequence[Token], line: int) -> None:
        """Begin what a choice does in one case, where its subject has the value of the label."""
        if self.block.kind == "case":
            self._leave(line - 1)
        name = label[0].text.strip("\"'") if label[:1] and label[0].kind == "string" else ""
        inner = Block(name or _last_name(label), line, self.block, "case", depth=self.block.depth)
        self.block.blocks.append(inner)
        if self.block.subject and len(label) == 1 and label[0].kind == "number":
            value = self._folder(label).expression()
            inner.items.append(Item(self.block.subject, plain(value), line, self.count))
        self.block = inner

    def _close(self, line: int) -> None:
        if self.block.kind == "case":
            self._leave(line)
        self._leave(line)

    def _leave(self, line: int) -> None:
        self.block.last = line
        if self.block.parent is not None:
            self.block = self.block.parent

    def _define(self, row: Sequence[Token]) -> None:
        if len(row) > 2 and row[0].text == "define" and row[1].kind == "name":
            called = row[2].text == "(" and not row[2].spaced
            if not called:
                self._bind(row[1].text, row[2:], row[1].line)

    def _lines(self) -> None:
        start, depth = 0, 0
        toks = self.tokens
        for k, x in enumerate(toks):
            if x.kind == "mark":
                if x.text in ("(", "[", "{", "(/"):
                    depth += 1
                elif x.text in (")", "]", "}", "/)"):
                    depth = max(0, depth - 1)
                elif x.text == ";" and depth == 0:
                    self._row(toks[start:k])
                    start = k + 1
            elif x.kind == "line" and depth == 0:
                before = toks[k - 1].text if k > start else ""
                if (
                    before in _CONTINUES
                    and before not in ("?", ":")
                    and self.language.name != "matlab"
                ):
                    continue
                self._row(toks[start:k])
                start = k + 1
        self._row(toks[start:])

    def _row(self, given: Sequence[Token]) -> None:
        row = [x for x in given if x.kind != "line"] if not self.language.blanks else list(given)
        while row and row[0].kind == "line":
            row = row[1:]
        if not row:
            return
        first = row[0]
        column = first.start - (self.text.rfind("\n", 0, first.start) + 1)
        name = self.language.name
        words = [x.text.lower() for x in row[:6]]
        if name != "fortran" and words[0] in _CHOSEN:
            self._choice(row, column)
            return
        if name == "python":
            while self.block.parent is not None and column <= self.block.indent:
                self._close(first.line - 1)
            if words[0] in ("class", "def", "async"):
                self._python_head(row, column)
                return
        elif name == "fortran":
            if self._fortran_head(words, row):
                return
        elif words[0] == "end":
            if self.block.parent is not None and column <= self.block.indent:
                self._close(first.line)
            return
        else:
            while words and words[0] == "@" and len(row) > 2:
                row = row[2:]
                words = [x.text for x in row[:6]]
            if words and words[0] in (
                "function",
                "struct",
                "mutable",
                "module",
                "classdef",
                "macro",
            ):
                self._headed(row, column)
                return
        self._statement(row)

    def _begin(self, name: str, line: int, indent: int) -> None:
        block = Block(name, line, self.block, indent=indent)
        self.block.blocks.append(block)
        self.block = block

    def _choice(self, row: Sequence[Token], column: int) -> None:
        """Begin what is done where a name has the value of a string: a block of that name."""
        while self.block.parent is not None and column <= self.block.indent:
            self._leave(row[0].line - 1)
        ends = (":",) if self.language.name == "python" else ("line", ",", "then")
        depth, end = 0, len(row)
        for k, x in enumerate(row):
            depth += (x.text in ("(", "[", "{")) - (x.text in (")", "]", "}"))
            if depth == 0 and (x.text in ends or x.kind in ends):
                end = k
                break
        said = [x.text.strip("\"'") for x in row[1:end] if x.kind == "string"]
        if said and not said[0].startswith("__"):
            self._begin(said[0], row[0].line, column)
            self.block.kind = "case"
        if row[end + 1 :]:
            self._statement(row[end + 1 :])

    def _python_head(self, row: Sequence[Token], column: int) -> None:
        k = 2 if row[0].text == "async" else 1
        self._begin(row[k].text if k < len(row) else "", row[0].line, column)
        depth = 0
        for j, x in enumerate(row):
            depth += (x.text in ("(", "[", "{")) - (x.text in (")", "]", "}"))
            if x.text == ":" and depth == 0:
                if row[j + 1 :]:
                    self._statement(row[j + 1 :])
                return

    def _headed(self, row: Sequence[Token], column: int) -> None:
        if self.language.name == "matlab":
            while self.block.parent is not None and column <= self.block.indent:
                self._close(row[0].line - 1)
            equal = next((k for k, x in enumerate(row) if x.text == "="), 0)
            name = row[equal + 1].text if equal + 1 < len(row) else ""
        else:
            k = 2 if row[0].text == "mutable" else 1
            name = "".join(x.text for x in row[k : k + 1])
            while k + 2 < len(row) and row[k + 1].text == ".":
                k += 2
                name = row[k].text
            typed = [
                row[j + 1].text for j in range(k, min(len(row) - 1, k + 8)) if row[j].text == "::"
            ]
            if name in ("RKTableau", "IMEXTableau", "ExplicitTableau", "tableau") and typed:
                name = typed[0]
        self._begin(name, row[0].line, column)
        words = [x.text for x in row[:12]]
        if self.language.name == "julia" and "(" in words:
            at = words.index("(") + 1
            if words[at : at + 1] == ["::"]:  # an argument that is only a type
                self.block.own = words[at + 1]
        if self.language.name == "julia" and len(row) > 2 and row[-1].text == "end":
            self._close(row[-1].line)

    def _fortran_head(self, words: Sequence[str], row: Sequence[Token]) -> bool:
        kinds = ("subroutine", "function", "procedure", "module", "program", "type")
        if words[0] == "select":
            self._begin("switch", row[0].line, 0)
            self.block.subject = _last_name(row[2:])
            return True
        if words[0] == "case" and (self.block.kind == "case" or self.block.name == "switch"):
            self._case([x for x in row[1:] if x.text not in ("(", ")")], row[0].line)
            return True
        if words[0].startswith("end"):
            rest = words[0][3:] or (words[1] if len(words) > 1 else "")
            if (rest in (*kinds, "select") or not rest) and self.block.parent is not None:
                self._close(row[0].line)
            return True
        if words[0] == "type" and words[1:2] in ([","], ["::"]):
            self._begin(_last_name(row), row[0].line, 0)
            return True
        for k, word in enumerate(words):
            if word in ("::", "=", ","):
                break
            if word in kinds and k + 1 < len(row) and row[k + 1].kind == "name":
                if word == "module" and row[k + 1].text.lower() in kinds:
                    continue
                self._begin(row[k + 1].text, row[0].line, 0)
                return True
        return False

    # --- one statement ----------------------------------------------------------------------------

    def _statement(self, given: Sequence[Token], *, tail: bool = False) -> None:
        row = [x for x in given if x.kind != "line"] if not self.language.blanks else list(given)
        while row and row[0].kind == "line":
            row = row[1:]
        if not row or (self.block is not self.top and not (
                self.lines is None or row[0].line in self.lines)):  # fmt: skip
            return
        spend()
        self.count += 1
        row = self._unlabelled(row)
        if not row:
            return
        for x in row if self.language.name == "c" else ():
            for inside in _DECLARED.findall(x.text) if x.kind == "string" else ():
                made, _ = tokens(inside, self.language)
                self._statement([y._replace(line=x.line) for y in made])
        if self.block.name == "match":
            arms = [x for x in _parts(row) if any(y.text == "=>" for y in x)]
            for arm in arms:
                self._returned(arm[[x.text for x in arm].index("=>") + 1 :])
            if arms:
                return
        if row[0].text == "return" or (tail and self.language.name == "rust"):
            self._returned(row[1:] if row[0].text == "return" else row)
            return
        if row[0].text in ("typedef", "using", "import", "from", "use", "package"):
            return
        if row[0].text.lower() == "data" and self.language.name == "fortran":
            self._data(row[1:])
            return
        equal = _equal(row)
        arrow = next((k for k, x in enumerate(row) if x.text == "=>"), 0)
        if equal is None and arrow and self.language.name == "java" and "(" not in {
                x.text for x in row[:arrow]}:  # fmt: skip
            row, equal = list(row), arrow  # int Order => 4 of C#
            row[arrow] = row[arrow]._replace(text="=")
        if equal is None and self.language.name == "c":
            row, equal = _comma_initialised(row)
        if equal is None:
            self._expression(row)
            return
        self._assign(row, equal)

    def _data(self, row: Sequence[Token]) -> None:
        """Read ``a(2,1), a(3,1) / 0.5, 0.25 /`` of Fortran."""
        slashes = [k for k, x in enumerate(row) if x.text == "/"]
        for start, (low, high) in zip(
            [0, *(k + 1 for k in slashes[1::2])], zip(slashes[::2], slashes[1::2], strict=False),
            strict=False,
        ):  # fmt: skip
            end = Token("mark", ")", row[low].line, 0, 0, False)
            targets = _parts(row[start:low])
            try:
                values = self._folder([*row[low + 1 : high], end]).items(")")
            except Unread:
                values = []
            if len(targets) == 1 < len(values):
                values = [values]
            for k, target in enumerate(targets):
                found = _target(target, self.language)
                if found is not None and len(values) == len(targets):
                    self._store(found[0], found[1], "", plain(values[k]), target[0].line, target)
                elif found is not None:
                    self._lose(found[0], "a DATA statement is not understood", target[0].line)

    def _assign(self, row: Sequence[Token], equal: int) -> None:
        if equal > 1 and row[equal - 1].text == "." and self.language.name == "julia":
            row, equal = [*row[: equal - 1], *row[equal:]], equal - 1  # a[4, :] .= b
        if self._several(row, equal):
            return
        target = _target(row[:equal], self.language)
        if row[equal].text not in ("=", ":="):  # such as +=
            if target is not None and not self._moved(target, row, equal):
                self._lose(target[0], f"{target[0]} is changed after it is set", row[equal].line)
            return
        if target is None:
            return
        name, subscripts, owner, typed, which = target
        if (
            self.language.name == "julia"
            and subscripts
            and not owner
            and _is_definition(row, equal)
        ):
            self._begin(name, row[0].line, 10_000)
            words = [x.text for x in row[:equal]]
            if words[-3:-1:2] == ["::"] and "," not in words:  # the type of the one argument
                self.block.own = words[-2]
            self._expression(row[equal + 1 :])
            self._close(row[-1].line)
            return
        folder = self._folder(row[equal + 1 :])
        try:
            value: Any = folder.expression()
            after = folder.peek()
            if after is not None and after.text not in (",", "=", ":"):
                raise Unread(f"{after.text!r} is not read here", after.line)
        except Unread as error:
            error.line = error.line or row[equal].line
            value = error
            folder.to_comma(())
        if not (typed & _TYPES_OF_INTEGERS) or typed - _TYPES_OF_INTEGERS:
            value = plain(value)
        self._store(name, subscripts, owner, value, row[0].line, row[equal + 1 :],
                    typed=bool(typed), which=which)  # fmt: skip
        rest = row[equal + 1 + folder.at :]
        if rest and rest[0].text in (",", "="):
            more = _equal(rest[1:])
            if rest[0].text == "=":
                self._assign(row[equal + 1 :], folder.at)
            elif more is not None:
                if typed:
                    rest = [
                        Token("name", x, rest[0].line, 0, 0, True) for x in sorted(typed)
                    ] + list(rest[1:])
                    more += len(typed)
                    self._assign(rest, more)
                else:
                    self._assign(rest[1:], more)

    def _moved(self, target: Any, row: Sequence[Token], equal: int) -> bool:
        """Carry out ``E3[8] -= 0.0220588`` on a list; return whether it was understood."""
        name, subscripts, owner, *_ = target
        index = self._index(subscripts) if subscripts and not owner else None
        held = self.block.names.get(name)
        if index is None or len(index) != 1 or not isinstance(held, list):
            return False
        k, x = index[0] - self.language.base, self._folded(row[equal + 1 :])
        old = held[k] if 0 <= k < len(held) else None
        sign = {"+=": 1, "-=": -1}.get(row[equal].text)
        if sign is None or not isinstance(old, Number) or not isinstance(x, Number):
            return False
        found = old.of(old.value + sign * x.value, x)
        found.place = (row[0].line, " ".join(y.text for y in row)[:80])
        held[k] = found
        return True

    def _several(self, row: Sequence[Token], equal: int) -> bool:
        """Carry out ``a21, a31 = 1 / 5, 3 / 40``; return whether it is one."""
        if self.language.name not in ("go", "python", "julia", "javascript"):
            return False
        word = [x for x in row[:1] if x.text in ("const", "var", "let")]
        targets = _parts(row[len(word) : equal])
        if len(targets) < 2:
            return False
        values = _parts([x for x in row[equal + 1 :] if x.kind != "line"])
        if len(targets) != len(values):
            return False
        for target, value in zip(targets, values, strict=True):
            if _equal([*target, *value]) is not None:  # let a = 1, b = 2
                return False
        for target, value in zip(targets, values, strict=True):
            self._assign([*word, *target, row[equal], *value], len(word) + len(target))
        return True

    def _folder(self, row: Sequence[Token]) -> Folder:
        return Folder(row, self.language, self._look(self.block))

    def _folded(self, row: Sequence[Token]) -> Any:
        """Return the value of an expression, ``None`` where it is not read."""
        try:
            return self._folder(row).expression()
        except Unread:
            return None

    @staticmethod
    def _look(block: Block) -> Any:
        def look(name: str) -> Any:
            owner, _, last = name.rpartition(".")
            keys = [name, last] if owner else [name]
            beyond: Mapping[str, str] = {}
            declared: Mapping[str, list[Number]] = {}
            for key in keys:
                at: Block | None = block
                while at is not None:
                    beyond, declared = at.beyond, at.declared
                    if key in at.names:
                        value = at.names[key]
                        if isinstance(value, Unread):
                            raise Unread(str(value), value.line)
                        return value
                    for x in at.blocks if owner and key == last else ():
                        if x.kind == "record" and x.name == owner and last in x.names:
                            return x.names[last]
                    at = at.parent
            if name in _SPELT:
                return Number(_SPELT[name])
            if len(declared.get(name, ())) == 1:
                return declared[name][0]
            if keys[-1] in beyond:
                return _written(beyond[keys[-1]])
            raise Unread(f"the name {name!r} is not known")

        return look

    def _bind(self, name: str, row: Sequence[Token], line: int) -> None:
        folder = self._folder(row)
        try:
            value: Any = folder.expression()
            if folder.peek() is not None:
                raise Unread("what follows the value is not read")
        except Unread as error:
            error.line = error.line or line
            value = error
        self._store(name, [], "", value, line, row)

    def _store(
        self, name: str, subscripts: list[Sequence[Token]], owner: str, value: Any, line: int,
        row: Sequence[Token], *, typed: bool = True, which: int | None = None,
    ) -> None:  # fmt: skip
        if isinstance(value, Record):
            self._record(value, name, line)
            return
        if isinstance(value, list) and any(isinstance(x, Record) for x in value):
            for x in value:  # a list of objects
                if isinstance(x, Record):
                    self._record(x, x.name or name, x.line or line)
            return
        block = self.block
        if owner and owner not in _OWN:
            block = self._object(owner, line)
        if name == "this":
            while block.parent is not None and block.name == block.parent.name:
                block = block.parent
            name, block = block.name, block.parent or block
        if not subscripts or isinstance(value, list):
            if subscripts and not (self._declares(subscripts) and (
                    typed or not self._is_part(subscripts))):  # fmt: skip
                if isinstance(value, list) and self._part(block, name, subscripts[0], value, line):
                    return
                index = self._index(subscripts)
                if index is not None and len(index) == 1:
                    self._entry(block, name, index, value, line)  # a row
                    return
                self._lose(name, "a part of it is set by a loop or slice", line)
                return
            item = Item(name, value, line, self.count, last=row[-1].line if row else line,
                        index=which)  # fmt: skip
            if isinstance(block.names.get(name), Frame) and _is_empty(block.names[name]):
                block.items = [x for x in block.items if x.value is not block.names[name]]
            if isinstance(value, Unread):
                self.failed.append((block, item, row))
                value.computed = bool(_ARITHMETIC & {x.text for x in row}) and any(
                    isinstance(block.names.get(x.text), list) for x in row
                )
            block.items.append(item)
            block.names[name] = value
            if name in self.top.declared and isinstance(value, Number) and not typed:
                value.place = value.place or (line, "")
                self.top.declared[name].append(value)
            if isinstance(value, list):
                self.frames[id(value)] = item
            return
        index = self._index(subscripts)
        if self.language.name == "fortran" and [x.text for x in subscripts[0]].count(":") == 2 and (
                whole_number(value) == 0):  # fmt: skip
            self._begun(block, name, line).cleared = True
            return
        if index is None:
            self._lose(name, "an entry is set at run time", line)
            return
        self._entry(block, name, index, value, line)

    def _is_part(self, subscripts: list[Sequence[Token]]) -> bool:
        """Return whether subscripts of Fortran are a part of a row, as ``A(2, 1:2)``."""
        first = next((x.text for x in subscripts[0] if x.text in ",:"), "")
        return self.language.name == "fortran" and first == ","

    def _part(
        self, block: Block, name: str, subscripts: Sequence[Token], value: list[Any], line: int
    ) -> bool:
        """Set a part of a row, as ``A[2, :2] = [..]``; return whether it was understood."""
        held, at = None, block
        while at is not None and held is None:
            held, at = at.names.get(name), at.parent
        end = Token("mark", "]", line, 0, 0, False)
        try:
            *index, last = self._folder([*subscripts, end]).indices("]")
            if held is None or isinstance(held, Entries):
                low = self.language.base if last[0] is None else last[0].whole()
                for k, x in enumerate(value, low):
                    self._entry(block, name, (*(y.whole() for y in index), k), x, line)
                return True
            if isinstance(held, list) and index == [(None, None)] and isinstance(last, Number):
                k = last.whole() - self.language.base
                for row, x in zip(held, plain(value), strict=True):  # a column
                    row[k] = x
                return True
            for k in index:
                held = held[k.whole() - self.language.base] if isinstance(held, list) else None
            if not (isinstance(held, list) and isinstance(last, tuple) and len(last) == 2):
                return False
            low = 0 if last[0] is None else last[0].whole() - self.language.base
            high = len(held) if last[1] in (None, "end") else last[1].whole()
        except (Unread, AttributeError, IndexError, TypeError, ValueError):
            return False
        high += len(held) if high < 0 else 0
        if low < 0 or high > len(held) or high - low != len(value):
            return False
        held[low:high] = plain(value)
        return True

    def _declares(self, subscripts: list[Sequence[Token]]) -> bool:
        """Return whether subscripts are the sizes of a declaration."""
        return self.language.name in ("c", "java", "go", "fortran") and bool(subscripts)

    def _index(self, subscripts: list[Sequence[Token]]) -> tuple[int, ...] | None:
        found: list[int] = []
        if len(subscripts) == 1 and (place := _in_row(subscripts[0])):
            return place
        for part in subscripts:
            folder = self._folder(part)
            while folder.peek() is not None:
                try:
                    x = folder.expression()
                    after = folder.peek()
                    if after is not None and after.text == ":" and len(found) == 1:
                        return None
                    if not isinstance(x, Number):
                        return None
                    found.append(x.whole())
                except Unread:
                    return None
                if folder.sees(","):
                    folder.take()
                    if folder.sees(":") and folder.at + 1 == folder.end:  # a[2, :] is a row
                        break
                elif folder.peek() is not None:
                    return None
        return tuple(found)

    def _entry(
        self, block: Block, name: str, index: tuple[int, ...], value: Any, line: int
    ) -> None:
        """Set one entry; one that is set twice begins another array."""
        if isinstance(value, Number):
            place = value.place
            value = Number(value.value, value.places, value.size)
            value.place = place or (line, "")
        held = None
        at: Block | None = block
        while at is not None and held is None:
            held = at.names.get(name)
            at = at.parent
        if isinstance(held, list) and held:
            part: Any = held
            base = self.language.base
            try:
                for k in index[:-1]:
                    part = part[k - base]
                if not isinstance(part, list) or index[-1] - base < 0:
                    raise IndexError
                part[index[-1] - base] = value
                if id(held) in self.frames:
                    self.frames[id(held)].last = line
            except (IndexError, TypeError):
                self._lose(name, f"an entry of {name} lies outside of it", line)
            return
        own = block.names.get(name)
        if isinstance(own, Unread) and own.computed:  # its other entries are computed from an array
            return
        if not isinstance(own, Entries) or index in own:
            own = self._begun(block, name, line)
            own.cleared = "alloc" in block.called.lower()  # as the other entries of the object are
        own[index] = value
        self.frames[id(own)].last = line

    def _begun(self, block: Block, name: str, line: int) -> Entries:
        """Return the entries of a name, none so far."""
        own = Entries()
        block.names[name] = own
        item = Item(name, own, line, self.count)
        block.items.append(item)
        self.frames[id(own)] = item
        return own

    def _lose(self, name: str, why: str, line: int) -> None:
        """Mark the array of a name, if it is one: what it holds is not what the code uses."""
        at: Block | None = self.block
        while at is not None:
            held = at.names.get(name)
            if held is not None:
                for item in reversed(at.items):
                    if item.name == name:
                        item.lost = item.lost or f"{why} (line {line})"
                        break
                if isinstance(held, Number):
                    at.names[name] = Unread(why, line)
                return
            at = at.parent

    def _object(self, owner: str, line: int) -> Block:
        for x in self.block.blocks:
            if x.kind == "record" and x.name == owner:
                x.last = line
                return x
        block = Block(owner, line, self.block, "record", last=line)
        self.block.blocks.append(block)
        return block

    def _record(self, record: Record, target: str, line: int) -> None:
        block = Block(target or record.name, line, self.block, "record", last=record.line)
        block.called = record.name.rpartition(".")[2]
        self.block.blocks.append(block)
        self._fill(block, record, line)
        if target:  # what is set to this name later refers to the block
            self.block.names[target] = block
        self.calls.append(block)

    def _fill(self, block: Block, record: Record, line: int) -> None:
        last = line
        for name, value in record.fields.items():
            last = max(last, self._field(block, name, value, line))
        fields = self.fields.get(block.called, []) if not record.fields else []
        fields = fields if len(fields) == len(record.values) else [""] * len(record.values)
        for own, (name, value) in zip(fields, record.values, strict=True):
            whole = whole_number(
                value[0] if value and isinstance(value, list) and len(value) < 3 else value
            )
            block.arguments.append((name, whole))
            if isinstance(value, Record | list) or (own and isinstance(value, Number)):
                last = max(last, self._field(block, own or name, value, line))
            elif not block.label and len(block.arguments) < 3:
                if isinstance(value, str):
                    block.label = value.strip("\"'")
                elif isinstance(value, Unread) and name.isupper():
                    block.label = name
                block.name = block.name or block.label
        block.last = max(block.last, last)

    def _field(self, block: Block, name: str, value: Any, line: int) -> int:
        if isinstance(value, Record):
            inner = Block(name or value.name, value.line or line, block, "record", last=line)
            inner.called = value.name.rpartition(".")[2]
            block.blocks.append(inner)
            self._fill(inner, value, line)
            self.calls.append(inner)
            return inner.last
        at = _first_line(value) or line
        if name in block.names and name:
            return at
        block.items.append(Item(name, plain(value), at, self.count, last=_last_line(value) or at))
        block.names[name] = value
        return _last_line(value) or at

    def _returned(self, row: Sequence[Token]) -> None:
        if not row:
            return
        block = self.block
        while (
            (block.name in CHOICES or block.kind == "case")
            and block.parent is not None
            and block.parent.parent is not None
        ):
            block = block.parent
        held = block.names.get(row[0].text) if len(row) == 1 else None
        if isinstance(held, Entries) and block.parent is not None:
            item = next(x for x in reversed(block.items) if x.value is held)
            block.parent.items.append(Item(block.name, held, item.line, self.count, last=item.last))
            return
        value = self._folded(row)
        if isinstance(value, Record):
            self._record(value, value.name or block.name, row[0].line)
            return
        alone = all(x.kind == "name" or x.text in (",", "(", ")", ".", "&") for x in row)
        named = len([x for x in row if x.kind == "name"]) == 1 and alone
        if isinstance(value, Number | list) and block.parent is not None and (named or not alone):
            item = Item(block.own or block.name, plain(value), row[0].line, self.count,
                        last=_last_line(value) or row[-1].line)  # fmt: skip
            block.parent.items.append(item)

    def _expression(self, row: Sequence[Token]) -> None:
        """Read a call, an object, a field or a declaration such as ``Matrix a{..}``."""
        marks = {x.text for x in row}
        if self.language.name == "c" and self.block is self.top and "," in marks:
            self.top.declared |= {x.text: [] for x in row[1:] if x.kind == "name"}
        sign = {"python": ":", "julia": "::"}.get(self.language.name)
        if self.block.name and [x.text for x in row[1:2]] == [sign]:
            self.fields.setdefault(self.block.name, []).append(row[0].text)
            return
        if not marks & {"(", "{"} or row[0].kind not in ("name", "mark"):
            return
        declared = next(
            (
                k
                for k in range(1, len(row) - 1)
                if row[k].kind == "name"
                and row[k + 1].text in ("{", "(")
                and (row[k - 1].kind == "name" or row[k - 1].text in (">", "&"))
            ),
            None,
        )
        if (
            declared is not None
            and self.language.name == "c"
            and row[0].text not in ("return", "else")
        ):
            end = _partner(row, declared + 1)
            inside = row[declared + 2 : end]
            if inside and end == len(row) - 1:
                if row[declared + 1].text == "{":
                    inside = row[declared + 1 : end + 1]
                self._bind(row[declared].text, inside, row[declared].line)
                return
        self._collect(row)

    def _collect(self, row: Sequence[Token]) -> None:
        value = self._folded(row)
        if isinstance(value, Record):
            typed = self.language.name == "julia" and not value.name
            self._record(value, self.block.own if typed else "", row[0].line)

    # --- forward references -----------------------------------------------------------------------

    def _again(self) -> None:
        """Fold once more what failed, with the names that were read after it."""
        for block, item, row in self.failed:
            folder = Folder(row, self.language, self._look(block))
            try:
                value = folder.expression()
            except Unread:
                continue
            if folder.peek() is not None and folder.tokens[folder.at].text != ",":
                continue
            if isinstance(value, Number | list) and isinstance(item.value, Unread):
                item.value = plain(value)
                if isinstance(block.names.get(item.name), Unread):
                    block.names[item.name] = item.value


def _written(text: str) -> Number:
    """Return a number that another file holds."""
    top, _, below = text.partition("@")[0].lstrip("-+").partition("/")
    x = literal(top)
    x = x.of(x.value / literal(below).value) if below else x
    return x.of(-x.value) if text.startswith("-") else x


def _in_row(subscript: Sequence[Token]) -> tuple[int, int] | None:
    """Return row and column of ``a[2 * 7 + 1]``, an entry of a matrix in one list."""
    words = [x.text for x in subscript]
    marks, numbers = words[1::2], words[::2]
    if marks != ["*", "+"] or not all(x.isdigit() for x in numbers):
        return None
    i, width, j = map(int, numbers)
    return (i, j) if j < width else None


def _is_empty(frame: Frame) -> bool:
    """Return whether nothing was put into an array of zeros."""
    return all(isinstance(x, Number) and x.value == 0 for x in flattened(frame))


def _last_name(row: Sequence[Token]) -> str:
    return next((x.text for x in reversed(row) if x.kind == "name"), "")


def _places(x: Any) -> Iterator[int]:
    for y in flattened(x) if isinstance(x, list) else [x]:
        if isinstance(y, Number) and y.place:
            yield y.place[0]


def _first_line(x: Any) -> int:
    return min(_places(x), default=0)


def _last_line(x: Any) -> int:
    return max(_places(x), default=0)


def _parts(row: Sequence[Token]) -> list[list[Token]]:
    """Return what stands between the commas outside of brackets."""
    found: list[list[Token]] = [[]]
    depth = 0
    for x in row:
        depth += (x.text in ("(", "[", "{")) - (x.text in (")", "]", "}"))
        if x.text == "," and depth == 0:
            found.append([])
        else:
            found[-1].append(x)
    return [x for x in found if x]


def _partner(row: Sequence[Token], at: int) -> int:
    depth = 0
    for k in range(at, len(row)):
        depth += (row[k].text in ("(", "[", "{", "(/")) - (row[k].text in (")", "]", "}", "/)"))
        if depth == 0:
            return k
    return len(row)


def _angle(row: Sequence[Token]) -> int:
    """Return the index after the parameters of a template."""
    depth = 0
    for k, x in enumerate(row):
        depth += x.text.count("<") - (x.text.count(">") if x.text != "->" else 0)
        if depth == 0 and k:
            return k + 1
    return 0


def _equal(row: Sequence[Token]) -> int | None:
    """Return the index of the sign of an assignment outside of all brackets."""
    depth = 0
    for k, x in enumerate(row):
        if x.kind == "mark":
            if x.text in ("(", "[", "{", "(/"):
                depth += 1
            elif x.text in (")", "]", "}", "/)"):
                depth -= 1
            elif depth == 0 and x.text in ("=", ":=", "+=", "-=", "*=", "/="):
                return k
    return None


def _comma_initialised(row: Sequence[Token]) -> tuple[Sequence[Token], int | None]:
    """Return ``A << 0, 0, 1, 0`` of a matrix of C++ as ``A = {0, 0, 1, 0}``, with its sign."""
    at = next((k for k, x in enumerate(row) if x.text == "<<"), len(row))
    rest = row[at + 1 :]
    if not rest or any(x.text in ("<<", ">>") or x.kind == "string" for x in rest):
        return row, None
    marks = [rest[k]._replace(kind="mark", text=x) for k, x in ((0, "="), (0, "{"), (-1, "}"))]
    return [*row[:at], *marks[:2], *rest, marks[2]], at


def _is_definition(row: Sequence[Token], equal: int) -> bool:
    """Return whether ``f(x) = ..`` of Julia defines a function."""
    before = [x.text for x in row[:equal]]
    return before[-1:] == [")"] or "where" in before


def _named(head: Sequence[Token]) -> str:
    """Return the name of the block that words before a brace begin."""
    if head and head[0].text == "template":  # its parameters are classes, too
        head = head[_angle(head) :]
    if head and head[0].text in CHOICES:  # of Go and Rust, without brackets
        return head[0].text
    own = _given_to(head)
    if own:
        return own
    for word in ("class", "struct", "namespace", "enum", "union", "interface", "impl", "trait",
                 "mod",
                 "fn", "func", "function"):  # fmt: skip
        for k, x in enumerate(head):
            if x.text == "(" and word in ("struct", "enum", "union"):
                break  # of an argument
            if x.text == word and k + 1 < len(head):
                j = k + 1
                if word == "func" and head[j].text == "(":  # a receiver of Go
                    j = _partner(head, j) + 1
                if j < len(head) and head[j].kind == "name":
                    while (
                        j + 1 < len(head)
                        and head[j + 1].kind == "name"
                        and word in ("class", "struct")
                        and head[j + 1].text not in ("extends", "implements", "final")
                    ):
                        j += 1
                    return head[j].text
    for k, x in enumerate(head):
        if x.text == "(" and k and head[k - 1].kind == "name":
            inside = head[k + 1] if k + 1 < len(head) else None
            macro = head[-1].text == "," and head[k - 1].text.isupper()
            if k > 2 and head[k - 2].text == "::":
                at = k - 3
                while at > 0 and head[k - 3].text == ">" and head[at].text != "<":
                    at -= 1
                at -= head[at].text == "<"
                if head[at].kind == "name":
                    return head[at].text  # of a method its class
            return inside.text if macro and inside is not None else head[k - 1].text
    return next((x.text for x in reversed(head) if x.kind == "name"), "")


def _given_to(head: Sequence[Token]) -> str:
    """Return the name that a function without one is given: ``f = function (x)``, ``f: x =>``."""
    words = [x.text for x in head]
    sign = next((k for k, x in enumerate(words) if x in ("=", ":", ":=")), 0)
    rest = words[sign + 1 :]
    alone = rest[:2] in (["function", "("], ["async", "function"], ["func", "("])
    if not sign or head[sign - 1].kind != "name" or not (alone or words[-1] == "=>"):
        return ""
    return words[sign - 1]


def _without_type(row: list[Token], language: Language) -> tuple[list[Token], set[str]]:
    """Return what stands before a sign of an assignment without its type, and the type's words."""
    typed: set[str] = set()
    if language.name in ("rust", "python", "javascript"):
        depth = 0
        for k, x in enumerate(row):
            depth += (x.text in ("(", "[", "{", "<")) - (x.text in (")", "]", "}", ">"))
            if x.text == ":" and depth == 0:
                typed = {y.text for y in row[k + 1 :] if y.kind == "name"}
                row = row[:k]
                break
    if language.name == "fortran":
        k = next((k for k, x in enumerate(row) if x.text == "::"), None)
        if k is not None:
            typed = {y.text for y in row[:k] if y.kind == "name"}
            row = row[k + 1 :]
    if language.name == "julia":
        k = next((k for k, x in enumerate(row) if x.text == "::"), None)
        if k is not None and row[k - 1].text != "(":
            row = row[:k] if not any(x.text == "(" for x in row[:k]) else row
    if language.name == "go" and len(row) > 1 and row[0].text in ("var", "const"):
        typed, row = {"var"}, row[:2]
    return row, typed


def _target(
    row: Sequence[Token], language: Language
) -> tuple[str, list[Sequence[Token]], str, set[str], int | None] | None:
    """Return the name that is assigned to, its subscripts, its owner, and the words of its type.

    The last is which of several owners it is a field of, as the 1 of ``weights[1].beta``.
    """
    row, typed = _without_type([x for x in row if x.kind != "line"], language)
    subscripts: list[Sequence[Token]] = []
    end = len(row)
    while end and row[end - 1].text in ("]", ")"):
        depth, k = 0, end - 1
        while k >= 0:
            depth += (row[k].text in (")", "]", "}")) - (row[k].text in ("(", "[", "{"))
            if depth == 0:
                break
            k -= 1
        if k < 0:
            return None
        inside = row[k + 1 : end - 1]
        if [x.text for x in inside] == ["*", "this"]:
            return "this", subscripts, "", typed, None
        if row[end - 1].text == ")" and language.name in ("python", "java", "rust", "go"):
            return None
        subscripts.insert(0, inside)
        end = k
        if [x.text for x in row[max(0, end - 2) : end]] in ([".", "at"], ["->", "at"]):
            end -= 2  # a.at(1)
    if not end or row[end - 1].kind != "name":
        return None
    name, k, owner, which = row[end - 1].text, end - 1, [], None
    while k >= 2 and row[k - 1].text in (".", "->", "::"):
        step = k - 2
        if row[step].text == "]":
            which = int(row[step - 1].text) if row[step - 1].text.isdigit() else None
            while step >= 0 and row[step].text != "[":
                step -= 1
            step -= 1
        if step < 0 or row[step].kind != "name":
            break
        owner.insert(0, row[step].text)
        k = step
    strings = [x for part in subscripts for x in part if x.kind == "string"]
    if strings:  # tables["rk4"]["A"]
        words = [x.text.strip("\"'") for x in strings]
        owner, name = [*owner, name, *words[:-1]], words[-1]
        subscripts = [x for x in subscripts if not any(y.kind == "string" for y in x)]
    typed |= {x.text for x in row[:k] if x.kind == "name"}
    if language.name in ("python", "julia", "matlab") and k and row[k - 1].text == ",":
        return None
    owner = [x for x in owner if x not in _OWN]
    return name, [x for x in subscripts if x], ".".join(owner), typed, which
