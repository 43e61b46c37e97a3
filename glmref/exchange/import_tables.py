"""Tables of other packages read back as method documents; nothing in a table is ever executed.

Each reader finds the array literals of its format and the order that the table states. Entries are
expressions of numbers, + - * /, parentheses and square roots, rewritten in the grammar of
:mod:`glmref.exact.expression` and computed exactly. A decimal of up to 11 digits means what it says
(0.25 is 1/4); a longer one is a rounded number, known to its last digit but one: see
:mod:`glmref.exact.decimals`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..audit.code import bare, rewritten, split
from ..audit.values import Number, Unread, evaluate
from ..catalogue.claims import ABSCISSAE, EMBEDDED_ORDER, EXPLICIT, ORDER, PRECONSISTENT
from ..catalogue.files import plain_document
from ..catalogue.keys import FORMATS as FORMATS_OF_METHODS
from ..catalogue.keys import MAX_SIZE, of_second
from ..catalogue.reader import load_document
from ..catalogue.strict_json import MAX_BYTES
from ..catalogue.writer import decimal
from ..errors import BudgetError, DataError, ExactnessError
from ..exact import Scalar
from ..exact.decimals import known_digits
from ..exact.expression import MAX_LENGTH, parse, to_text
from ..system.budget import PROVING, limited, spend
from .cells import from_cells

_MOST_PLACES = 150
_MOST_BLOCK = MAX_SIZE**2  # entries of a block


@dataclass
class Found:
    """What a reader found in a file."""

    #: Rows of entries by the name of the block.
    blocks: dict[str, list[list[str]]] = field(default_factory=dict)
    #: The order that the table states, and that of its embedded weights.
    order: int | None = None
    lower: int | None = None
    about: dict[str, Any] = field(default_factory=dict)  #: Its name, and rows of exact numbers.


def read_table(
    text: str, form: str, *, name: str = "imported", where: str = "table"
) -> dict[str, Any]:
    """Read a table of another package, one of :data:`READ`, as a method document.

    It claims the order and the abscissae that the table states, so that ``glmref verify`` checks
    them, and else whether the method is explicit. ``name`` is that of the method where the table
    gives none, ``where`` that of the file.

    Raises
    ------
    DataError
        For a file that is not such a table, naming the place.
    """
    if form not in READ:
        raise DataError(f"there is no import from {form!r}; one of {', '.join(READ)}")
    if len(text) > MAX_BYTES:
        raise DataError(
            f"{where}: the file has {len(text)} characters; at most {MAX_BYTES} are read"
        )
    try:
        with limited(PROVING):
            if form in FORMATS:
                document = _Writer(FORMATS[form](text), name, where, form).document()
            else:
                document = _complete(text, form, where)
    except (RecursionError, MemoryError):
        raise DataError(f"{where}: brackets are nested too deep for a table") from None
    except (DataError, BudgetError) as error:
        message = str(error)
        raise DataError(message if message.startswith(where) else f"{where}: {message}") from None
    load_document(document, where=where)
    return document


def _complete(text: str, form: str, where: str) -> dict[str, Any]:
    """Return the method file that a tableau in JSON or a table of cells is, with a source."""
    given = dict(plain_document(text, where) if form == "json" else from_cells(text))
    here = {"citation": f"a table in the format {form}", "where": where, "status": "regenerated"}
    source = given.get("source", {})
    if isinstance(source, Mapping):  # what it lacks is said of the table
        given["source"] = here | dict(source)
    method: Any = load_document(given, where=where)
    return dict(method.document)


# --- entries -------------------------------------------------------------------------------------


def _number(text: str) -> Number:
    """Return the number that an entry stands for, read as the audit of codes reads it."""
    if len(text) > MAX_LENGTH:
        raise DataError(f"the entry has {len(text)} characters and at most {MAX_LENGTH} are read")
    why = ""
    try:
        tree = ast.parse(rewritten(re.sub(r'big"([^"]*)"', r"\1", text)), mode="eval")
        value = evaluate(tree.body, {})
    except (Unread, ZeroDivisionError) as error:
        value, why = None, f" ({error})"
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        value = None
    if not isinstance(value, Number):
        shown = text if len(text) < 60 else f"{text[:57]}..."
        raise DataError(f"the entry {shown!r} is no number or quotient that is read here{why}")
    return value


def _written(number: Number, digits: int | None) -> str:
    """Return a number as an entry: exact in lowest terms, or a decimal with the digits declared."""
    if number.places is None or digits is None:
        return to_text(number.value)
    return decimal(number.value, min(max(number.places, digits), digits + 2))


class _Writer:
    """Turns what was found into a method document."""

    def __init__(self, found: Found, name: str, where: str, form: str) -> None:
        self.found, self.name, self.where, self.form = found, name, where, form
        self.digits: int | None = None

    def document(self) -> dict[str, Any]:
        found = self.found
        shapes = self._kind()
        entries = self._entries()
        exact = found.about.pop("exact", {})
        self._take_exact(entries, exact)
        texts = [x for rows in entries.values() for row in rows for x in row]
        weights = [entries.pop(x)[0] for x in ("d", "dt") if x in entries]
        error = entries.pop("e", None)
        document: dict[str, Any] = {"format": "", "name": self._name()}
        document["class"] = shapes
        c = entries.pop("c", None)
        if shapes == "additive":
            self._check_sums(entries, c, entries.pop("ct", None))
            c = None
            document["parts"] = [
                {"A": entries[f"A{mark}"], "b": entries[f"b{mark}"][0]} for mark in ("", "t")
            ]
        elif shapes == "splitting":
            document |= self._unfolded(entries["a"][0], entries["ahat"][0])
        else:
            document |= {"A": entries["A"], "b": entries["b"][0]}
        if any("." in x for x in texts) and self.digits is not None:
            document["digits"] = self.digits
        if weights:
            document["embedded"] = [
                {"name": "embedded", "b": weights if shapes == "additive" else weights[0]}
            ]
        if error is not None and set(error[0]) != {"0"}:
            document["embedded"] = [{"name": "embedded", "error": error[0]}]
        document["format"] = FORMATS_OF_METHODS[bool(of_second(document))]
        document["claims"] = self._claims(entries, c)
        if weights and found.lower:
            document["claims"][EMBEDDED_ORDER.key] = {"embedded": found.lower}
        document["source"] = {
            "citation": f"a table in the format {self.form}", "where": self.where,
            "status": "regenerated",
        }  # fmt: skip
        return document

    def _name(self) -> str:
        text = str(self.found.about.get("name", "")) or self.name
        word = re.sub(r"[^a-z0-9.-]+", "-", text.lower()).strip("-.")[:100]
        return word or "imported"

    def _kind(self) -> str:
        blocks = self.found.blocks
        if {"A", "b", "At", "bt"} <= blocks.keys():
            return "additive"
        if {"a", "ahat"} <= blocks.keys():
            return "splitting"
        if {"A", "b"} <= blocks.keys():
            return "rk"
        there = f"found are {', '.join(sorted(blocks))}" if blocks else "no arrays are found"
        raise DataError(f"a table needs A and b; {there}")

    def _entries(self) -> dict[str, list[list[str]]]:
        """Return every entry in our grammar; where all of it is exact, in lowest terms."""
        numbers: dict[str, list[list[Number]]] = {}
        for block, rows in self.found.blocks.items():
            if sum(map(len, rows)) > _MOST_BLOCK:
                raise DataError(f"`{block}` has more than {_MOST_BLOCK} entries")
            numbers[block] = [[self._at(block, i, j, _number, x) for j, x in enumerate(row)]
                              for i, row in enumerate(rows)]  # fmt: skip
        every = (x for rows in numbers.values() for row in rows for x in row)
        self.digits = known_digits(min(x.places, _MOST_PLACES) for x in every if x.places)
        return {
            block: [[self._at(block, i, j, self._text, x) for j, x in enumerate(row)]
                    for i, row in enumerate(rows)]
            for block, rows in numbers.items()
        }  # fmt: skip

    def _text(self, number: Number) -> str:
        spend()
        return _written(number, self.digits)

    @staticmethod
    def _at(block: str, i: int, j: int, rule: Callable[[Any], Any], x: Any) -> Any:
        """Return what a rule makes of an entry; where it fails its place is named."""
        try:
            return rule(x)
        except (DataError, ExactnessError) as error:
            raise DataError(f"`{block}[{i + 1}][{j + 1}]`: {error}") from None

    def _take_exact(
        self, entries: dict[str, list[list[str]]], exact: Mapping[str, Sequence[Sequence[str]]]
    ) -> None:
        """Put exact expressions of a comment in the place of their decimals, if they agree."""
        for block, rows in exact.items():
            if [len(row) for row in entries.get(block, [])] != [len(row) for row in rows]:
                raise DataError(
                    f"the exact rows of {block} in the comment have another shape than the table; "
                    f"take them out or correct them"
                )
            for i, row in enumerate(rows):
                for j, text in enumerate(row):
                    value, number = parse(text), self._value(entries[block][i][j])
                    if (value - number).is_zero() is False:
                        raise DataError(
                            f"`{block}[{i + 1}][{j + 1}]` is {float(number):.17g} in the table and "
                            f"{text} = {float(value):.17g} in the comment; correct one of them, or "
                            f"take the lines `exact` out"
                        )
                    entries[block][i][j] = text.strip()

    def _value(self, text: str) -> Scalar:
        return parse(text, digits=self.digits)

    def _check_sums(self, entries: Mapping[str, list[list[str]]], *given: Any) -> None:
        """Refuse abscissae other than the row sums: a method file of this class has none."""
        for mark, c in zip(("", "t"), given, strict=True):
            for i, text in enumerate(c[0] if c else ()):
                row = [self._value(x) for x in entries[f"A{mark}"][i]]
                if (sum(row[1:], row[0]) - self._value(text)).is_zero() is False:
                    raise DataError(
                        f"`c{mark}[{i + 1}]` is {text} and no sum of row {i + 1} of A{mark}, at "
                        f"which an additive method evaluates here; correct one of them"
                    )

    def _unfolded(self, a: list[str], ahat: list[str]) -> dict[str, Any]:
        """Return a splitting without a leading kick or trailing drift of weight 0."""
        first = "q" if self._value(ahat[0]).is_zero() is True else "p"
        b = ahat[1:] if first == "q" else ahat
        return {"first": first, "a": a[:-1] if self._value(a[-1]).is_zero() is True else a, "b": b}

    def _claims(self, entries: Mapping[str, Any], c: list[list[str]] | None) -> dict[str, Any]:
        claims: dict[str, Any] = {}
        if self.found.order:
            claims[ORDER.key] = self.found.order
        if c is not None:
            claims[ABSCISSAE.key] = c[0]
        if not claims and "A" in entries and "At" not in entries:
            A = [[self._value(x) for x in row] for row in entries["A"]]
            explicit = all(x.is_zero() is True for i, row in enumerate(A) for x in row[i:])
            claims[EXPLICIT.key] = explicit
        return claims or {PRECONSISTENT.key: True}


# --- formats -------------------------------------------------------------------------------------


def _comment(text: str) -> dict[str, Any]:
    """Name, title, source and exact rows of a file that we wrote."""
    about: dict[str, Any] = {}
    lines = [re.sub(r"^\s*(?:/?\*+/?|#|%|//|!)\s?", "", line) for line in text.splitlines()]
    if any(line.startswith("Generated by glmref ") for line in lines):
        first = next((x for x in lines if x.strip()), "")
        name = first.partition(": ")[0]
        if re.fullmatch(r"[a-z0-9][a-z0-9.-]*", name):
            about["name"] = name
    exact: dict[str, list[list[str]]] = {}
    for line in lines:
        match = re.match(r"exact (\w+): (.*)$", line)
        if match:
            exact.setdefault(match[1], []).append([x.strip() for x in match[2].split(";")])
    if exact:
        about["exact"] = exact
    return about


def _balanced(text: str, at: int) -> str:
    """Return what stands between the bracket at a place and its partner."""
    partner = {"{": "}", "[": "]", "(": ")"}
    waiting = [partner[text[at]]]
    for k in range(at + 1, len(text)):
        if text[k] in partner:
            waiting.append(partner[text[k]])
        elif text[k] in ")]}":
            if text[k] != waiting.pop():
                break
            if not waiting:
                return text[at + 1 : k]
    raise DataError("a bracket is not closed")


def _c_array(text: str, names: Sequence[str]) -> list[str] | None:
    found = [
        m for name in names
        for m in re.finditer(rf"\b{name}\s*(?:\[[^\]=;]{{0,80}}+\]\s*)*=\s*\{{", text)
    ]  # fmt: skip
    if len(found) > 1:
        raise DataError(f"the file holds {len(found)} arrays {names[0]}; keep one table of them")
    if not found:
        return None
    flat = _balanced(text, found[0].end() - 1).replace("{", " ").replace("}", " ")
    return split(flat, ",")


def _c_table(text: str, call: str, numbers: Callable[[list[str]], int]) -> Found:
    """Return arrays A, b, c and the order from a call with its arguments."""
    about = _comment(text)
    body = bare(text)
    found = Found(about=about)
    # both an A and an At: the two parts of an implicit-explicit method
    both = all(_c_array(body, (x,)) for x in ("A", "At", "b", "bt"))
    for mark in ("", "t") if both else ("",):
        names = {x: (f"{x}{mark}",) if both else (x, f"{x}t") for x in "Abc"}
        A, b, c = (_c_array(body, names[x]) for x in "Abc")
        if A is None or b is None:
            raise DataError("there are no arrays `A[] = {...}` and `b[] = {...}`")
        s = len(b)
        if len(A) != s * s:
            raise DataError(
                f"`A{mark}` must have {s} times {s} entries, as `b{mark}` has {s}, got {len(A)}"
            )
        found.blocks[f"A{mark}"] = [A[i * s : i * s + s] for i in range(s)]
        found.blocks[f"b{mark}"] = [b]
        if c is not None:
            found.blocks[f"c{mark}"] = [c]
        d = _c_array(body, (f"d{mark}",))
        if d is not None:
            found.blocks[f"d{mark}"] = [d]
    match = re.search(rf"\b(?:{call})\s*\(", body)
    if match:
        arguments = split(_balanced(body, match.end() - 1), ",")
        found.order = numbers(arguments) or None
        found.lower = _whole(arguments, 2) or None if call.startswith("ARKode") else None
    return found


def _whole(arguments: Sequence[str], at: int) -> int:
    text = arguments[at].strip() if len(arguments) > at else ""
    return int(text) if re.fullmatch(r"\d{1,2}", text) else 0


def _sprk(text: str) -> Found | None:
    """Return a table of SPRKStep: arrays a and ahat, and the order that is put into the table."""
    body = bare(text)
    if not re.search(r"\bARKodeSPRKTable_(?:Alloc|Create)\s*\(", body):
        return None
    a, ahat = (_c_array(body, (x,)) for x in ("a", "ahat"))
    if not a or not ahat or len(a) != len(ahat):
        raise DataError("there are no arrays `a[] = {...}` and `ahat[] = {...}` of one length")
    order = re.search(r"->\s*q\s*=\s*(\d{1,2})\s*;", body)
    call = re.search(r"\bARKodeSPRKTable_Create\s*\(", body)
    told = _whole(split(_balanced(body, call.end() - 1), ","), 1) if call else 0
    return Found({"a": [a], "ahat": [ahat]}, int(order[1]) if order else told or None,
                 about=_comment(text))  # fmt: skip


def _sundials(text: str) -> Found:
    if (found := _sprk(text)) is not None:
        return found
    return _c_table(text, "ARKodeButcherTable_Create", lambda x: _whole(x, 1))


def _petsc(text: str) -> Found:
    call = "TSRKRegister|TSDIRKRegister|TSARKIMEXRegister"
    found = _c_table(text, call, lambda x: _whole(x, 1))
    match = re.search(r'\bTS(?:RK|DIRK|ARKIMEX)Register\s*\(\s*"([^"]+)"', text)
    if match:
        found.about.setdefault("name", match[1])
    return found


def _list_of(node: ast.expr) -> list[ast.expr]:
    """Return the elements of a list, or of ``np.array([...])`` around one."""
    if isinstance(node, ast.Call) and len(node.args) >= 1:
        return _list_of(node.args[0])
    if isinstance(node, ast.List | ast.Tuple):
        return node.elts
    raise DataError(f"line {node.lineno}: a list of numbers is expected here")


def _diffrax(text: str) -> Found:
    about = _comment(text)
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError) as error:
        raise DataError(f"the file is no Python ({error.args[0]})") from None
    calls = [
        node for node in ast.walk(tree)
        if isinstance(node, ast.Call) and ast.unparse(node.func).split(".")[-1] == "ButcherTableau"
    ]  # fmt: skip
    if len(calls) != 1:
        raise DataError(f"there must be one call of ButcherTableau, found are {len(calls)}")
    given = {x.arg: x.value for x in calls[0].keywords if x.arg}
    for key in ("c", "b_sol", "a_lower"):
        if key not in given:
            raise DataError(f"ButcherTableau must be given `{key}`")

    def texts(node: ast.expr) -> list[str]:
        segments = (ast.get_source_segment(text, x) for x in _list_of(node))
        return [x or "" for x in segments]

    rows = [texts(x) for x in _list_of(given["a_lower"])]
    s = len(rows) + 1
    if [len(row) for row in rows] != list(range(1, s)):
        raise DataError("the rows of `a_lower` must have 1, 2, .. entries")
    diagonal = texts(given["a_diagonal"]) if "a_diagonal" in given else ["0"] * s
    if len(diagonal) != s:
        raise DataError(f"`a_diagonal` must have {s} entries, got {len(diagonal)}")
    A = [[*row, diagonal[i], *["0"] * (s - i - 1)] for i, row in enumerate([[], *rows])]
    first = ast.get_source_segment(text, given["c1"]) if "c1" in given else "0"
    found = Found({"A": A, "b": [texts(given["b_sol"])], "c": [[first or "0", *texts(given["c"])]]})
    if "b_error" in given:
        found.blocks["e"] = [texts(given["b_error"])]
    found.about = about
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name == "order":
            values = [x.value for x in ast.walk(node) if isinstance(x, ast.Constant)]
            orders = [x for x in values if isinstance(x, int) and not isinstance(x, bool)]
            found.order = orders[0] if len(orders) == 1 else None
    return found


def _julia_array(text: str, names: str, *, matrix: bool) -> list[list[str]] | None:
    match = re.search(rf"(?<![\w.])(?:{names})\s*=\s*(?:reshape\()?[\w.]*\[", text)
    if match is None:
        return None
    body = _balanced(text, match.end() - 1)
    if not matrix:
        return [split(body, ",;\n")]
    if "," in re.sub(r"\([^)]*\)", "", body):
        raise DataError("a matrix must have blanks between entries and one row a line")
    rows = [line.split() for line in re.split(r"[;\n]", body) if line.strip()]
    return rows


def _julia(text: str, names: Sequence[str], call: str, at: int) -> Found:
    found = Found(about=_comment(text))
    body = bare(text, "julia")
    for block, name in zip("Abcd", names, strict=False):
        rows = _julia_array(body, name, matrix=block == "A")
        if rows is not None:
            found.blocks[block] = rows
    match = re.search(rf"\b(?:{call})(?:\{{\w+\}})?\s*\(", body)
    if match:
        arguments = split(_balanced(body, match.end() - 1), ",")
        found.order = _whole(arguments, at) or None
        named = [x.partition("=")[2] for x in arguments if x.strip().startswith("adaptiveorder")]
        found.lower = _whole(named, 0) or None
        symbol = re.fullmatch(r":(\w+)", arguments[0]) if arguments else None
        if symbol:
            found.about.setdefault("name", symbol[1].replace("_", "-"))
    return found


def _ordinarydiffeq(text: str) -> Found:
    return _julia(text, ("A", "α|b", "c", "αEEst"), "ExplicitRKTableau", 3)


def _rungekutta(text: str) -> Found:
    return _julia(text, ("a", "b", "c"), "Tableau", 1)


FORMATS: Mapping[str, Callable[[str], Found]] = {
    "sundials": _sundials,
    "petsc": _petsc,
    "diffrax": _diffrax,
    "ordinarydiffeq": _ordinarydiffeq,
    "rungekutta.jl": _rungekutta,
}
#: What is read: tables, and tableaux or method files in JSON and as cells.
READ = ("json", "csv", *FORMATS)
