"""Tables of coefficients in the sources of public codes, format by format.

A reader goes through a file statement by statement (:mod:`~.code`), evaluates the assignments
(:mod:`~.values`) and makes a :class:`Table` wherever the code hands arrays to what stores or uses
them. What it cannot follow becomes a table that is unread, with the line, and the rest is read on.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from ..catalogue.keys import MAX_SIZE
from ..exact import Exact
from .code import Statement
from .kinds import imkg, transformed
from .named import constants
from .odeint import odeint
from .plain import from_csv, from_json
from .principia import structs
from .source_statements import statements
from .table import ZERO, Rows, Table, vector
from .values import Number, Scope, Sparse, Unread, assign, evaluate, whole_number


def _square(value: Any, s: int, *, base: int = 0) -> Rows:
    """Return a matrix (s, s) from rows, also of growing length, a flat list or single entries."""
    if isinstance(value, Sparse):
        if any(len(k) != 2 or not all(base <= x < s + base for x in k) for k in value.entries):
            raise Unread("entries are given of an array whose size is not known")
        return [[value.entries.get((i + base, j + base), ZERO) for j in range(s)] for i in range(s)]
    if isinstance(value, Number):
        value = [[value]]
    if value and all(isinstance(x, list) for x in value):
        rows = [vector(x) for x in value]
        if len(rows) == s - 1:
            rows = [[], *rows]
        if len(rows) != s or any(len(x) > s for x in rows):
            raise Unread(f"A has {len(rows)} rows where b has {s} entries")
        return [[*x, *([ZERO] * (s - len(x)))] for x in rows]
    flat = vector(value)
    if len(flat) != s * s:
        raise Unread(f"A has {len(flat)} entries where b has {s}")
    return [flat[i * s : i * s + s] for i in range(s)]


def _words(node: ast.expr) -> str:
    """Return what an argument is called."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    return ast.unparse(node).rpartition(".")[2]


class _Run:
    """The statements of a file carried out one after the other."""

    def __init__(self, text: str, language: str) -> None:
        self.text, self.language = text, language
        self.scope: Scope = {
            "NULL": None,
            "nullptr": None,
            "nothing": None,
            "1-based": 1 if language == "julia" else 0,
        }
        self.globals: Scope = dict(self.scope)
        self.header, self.line, self.depth = "", 1, 0

    def steps(self) -> Iterator[tuple[Statement, ast.stmt | None]]:
        """Yield each statement after carrying out its assignment."""
        for step in statements(self.text, self.language):
            if re.match(r"(?:inline )?namespace|extern", step.text) and step.kind == "open":
                continue  # its end leaves the depth at zero
            if step.kind == "open":
                if self.depth == 0:
                    self.globals = {
                        k: v for k, v in self.scope.items() if not isinstance(v, Sparse)
                    }
                    self.scope = dict(self.globals)
                    self.header, self.line = step.text, step.line
                self.depth += 1
                yield step, None
                continue
            if step.kind == "close":
                yield step, None
                if self.depth == 1:
                    self.scope = dict(self.globals)
                self.depth = max(0, self.depth - 1)
                continue
            node = step.parsed()
            if isinstance(node, ast.Assign):
                self._carry_out(node, step)
            elif node is None:
                name = re.match(r"([\w.]+)\s*(?:\[[^=]*\])?\s*=(?!=)", step.text)
                if name:
                    self.scope[name[1]] = Unread("the statement is not understood", step.line)
            yield step, node

    def _carry_out(self, node: ast.Assign, step: Statement) -> None:
        try:
            value = evaluate(node.value, self.scope)
            for target in node.targets:
                assign(target, value, self.scope)
        except Unread as error:
            error.line = step.line
            target = node.targets[0]
            while isinstance(target, ast.Subscript):
                target = target.value
            self.scope[ast.unparse(target)] = error
        except (RecursionError, ValueError, IndexError, TypeError, AttributeError) as error:
            name = ast.unparse(node.targets[0])
            self.scope[name] = Unread(f"{type(error).__name__}: {error}", step.line)

    def value(self, node: ast.expr | None) -> Any:
        """Return an argument; ``None`` for NULL and what is left out."""
        if node is None or (isinstance(node, ast.Name) and node.id in ("NULL", "nothing", "None")):
            return None
        return evaluate(node, self.scope)


def _calls(node: ast.AST | None, names: Sequence[str]) -> Iterator[ast.Call]:
    for x in ast.walk(node) if node is not None else ():
        if isinstance(x, ast.Call) and ast.unparse(x.func).rpartition(".")[2] in names:
            yield x


def _unread(name: str, line: int, error: Unread) -> Table:
    at = f" (line {error.line})" if error.line else ""
    return Table(name, line, unread=f"{error}{at}")


def _keywords(call: ast.Call) -> dict[str, ast.expr]:
    return {x.arg: x.value for x in call.keywords if x.arg}


# --- formats --------------------------------------------------------------------------------------


def _petsc(text: str) -> Iterator[Table]:
    run = _Run(text, "c")
    names = {
        "TSRKRegister": _petsc_rk,
        "TSDIRKRegister": _petsc_rk,
        "TSARKIMEXRegister": _petsc_ark,
        "TSRosWRegister": _petsc_rosw,
        "TSGLEERegister": _petsc_glee,
    }
    for step, node in run.steps():
        for call in _calls(node, [*names, "TSRosWRegisterRos4"]):
            made = ast.unparse(call.func).rpartition(".")[2]
            if not call.args or isinstance(call.args[0], ast.Tuple):
                continue
            title = _words(call.args[0])
            if title == "name":  # the function itself
                continue
            if made == "TSRosWRegisterRos4":
                yield _ros4(run, call, step.line)
                continue
            if len(call.args) < 8:
                continue
            try:
                values = [None if k == 0 else _argument(run, x) for k, x in enumerate(call.args)]
                yield names[made](title, step.line, values)
            except Unread as error:
                yield _unread(title, step.line, error)


def _argument(run: _Run, node: ast.expr) -> Any:
    try:
        return run.value(node)
    except Unread as error:
        return error


def _need(value: Any) -> Any:
    if isinstance(value, Unread):
        raise value
    return value


def _petsc_rk(name: str, line: int, v: list[Any]) -> Table:
    """Read TSRKRegister and TSDIRKRegister: name, order, s, A, b, c, embedded b."""
    s = whole_number(v[2]) or 0
    A = _square(_need(v[3]), s)
    b = A[-1] if _need(v[4]) is None else vector(v[4])
    table = Table(name, line, A=[A], b=[b], order=whole_number(v[1]))
    table.c = [None if _need(v[5]) is None else vector(v[5])]
    if _need(v[6]) is not None:
        table.rows = [("embedded", vector(v[6]), None)]
    return table


def _petsc_ark(name: str, line: int, v: list[Any]) -> Table:
    s = whole_number(v[2]) or 0
    if _need(v[6]) is None:
        return _petsc_rk(name, line, [*v[:6], v[9]])
    At, A = _square(_need(v[3]), s), _square(_need(v[6]), s)
    bt = At[-1] if _need(v[4]) is None else vector(v[4])
    b = bt if _need(v[7]) is None else vector(v[7])
    table = Table(name, line, "additive", [A, At], [b, bt], order=whole_number(v[1]))
    table.c = [None if _need(x) is None else vector(x) for x in (v[8], v[5])]
    low = _need(v[9])
    if low is not None and _need(v[10]) in (None, low):
        table.rows = [("embedded", vector(low), None)]
    return table


def _petsc_rosw(name: str, line: int, v: list[Any]) -> Table:
    s = whole_number(v[2]) or 0
    table = Table(name, line, "rosenbrock", order=whole_number(v[1]))
    table.A = [_square(_need(v[3]), s), _square(_need(v[4]), s)]
    table.b, table.c = [vector(_need(v[5]), s)], [None]
    if _need(v[6]) is not None:
        table.rows = [("embedded", vector(v[6]), None)]
    return table


def _petsc_glee(name: str, line: int, v: list[Any]) -> Table:
    """Return a method (A, U, B, V) that starts with S y and whose solution is F times its values.

    Constantinescu (2016), "Estimating global errors in time stepping", arXiv:1503.05166.
    """
    order, s, r = (whole_number(_need(x)) or 0 for x in v[1:4])
    A = _square(_need(v[5]), s)
    flat = [vector(_need(x)) for x in v[6:11]]
    B, U, V = (
        [x[i * n : i * n + n] for i in range(len(x) // n)]
        for x, n in zip(flat[:3], (s, r, r), strict=True)
    )
    S, F = flat[3:]
    if [len(B), len(U), len(V), len(S), len(F)] != [r, s, r, r, r]:
        raise Unread("the arrays do not have the sizes of s stages and r values")

    def read_by(w: Sequence[Exact]) -> list[Number]:
        return [
            column[0].of(sum((x * y.value for x, y in zip(w, column, strict=True)), Exact(0)),
                         next((y for y in column if y.places is not None), None))
            for column in zip(*B, strict=True)
        ]  # fmt: skip

    solution = [x.value for x in F]
    table = Table(name, line, "glm", [A], [read_by(solution)], [None], order)
    spare = next((k for k, x in enumerate(solution) if complex(x) != 0), 0)
    for k in range(r):  # w = F + e_k - (e_k S) F: w S = 1, and with F they span everything
        if k != spare:
            w = [(Exact(1) - S[k].value) * x for x in solution]
            w[k] = w[k] + 1
            table.b.append(read_by(w))

    def gap(rows: Rows, wanted: Sequence[Exact]) -> float:
        return max(
            abs(
                complex(sum((x.value * y.value for x, y in zip(row, S, strict=True)), Exact(0)) - z)
            )
            for row, z in zip(rows, wanted, strict=True)
        )

    one = Exact(1)
    table.identities = [("F S = 1", gap([F], [one])), ("U S = 1", gap(U, [one] * s)),
                        ("V S = S", gap(V, [x.value for x in S]))]  # fmt: skip
    if _need(v[11]) is not None:
        table.c = [vector(v[11])]
    return table


def _ros4(run: _Run, call: ast.Call, line: int) -> Table:
    """Return a method of order 4 by its parameters; a2 is a number there, never a sentinel.

    Hairer and Wanner (1996), IV.7, table 7.2: for these methods a2 = 2 gamma.
    """
    name, sentinel = _words(call.args[0]), _words(call.args[2])
    said = f"the parameters of {name} are not written out"
    if sentinel.startswith("PETSC_"):
        value = {"PETSC_CURRENT": "-2", "PETSC_DEFAULT": "-2", "PETSC_DETERMINE": "-1"}
        gamma = run.value(call.args[1])
        said = (
            f"question: a2 is the sentinel {sentinel} and is used as the number "
            f"{value.get(sentinel, '')}; the method of that name has a2 = 2 gamma = "
            f"{2 * complex(gamma.value).real:.15g} (Hairer, Wanner 1996, table IV.7.2)"
        )
    return Table(name, line, "rosenbrock", order=4, unread=said)


_ORDER_FUNCTION = re.compile(
    r"\b(\w+)_order\s*\([^(){}]*\)[^(){};]{0,40}\{\s*return\s+(\d{1,2})\s*;"
)
#: What it has behind its name; few texts have it, and it is found fast.
_RETURNS = re.compile(r"_order\s*\([^(){}]*\)[^(){};]{0,40}\{\s*return\s")
#: A dictionary of orders; the literal at its head is found fast.
_ORDERS = [
    re.compile(rf"{x}(?<=\b[Oo]{x})s?\w*\s*(?::[^=\n]{{1,60}})?=\s*\{{([^{{}}]*)\}}")
    for x in ("rder", "RDER")
]
#: A type of Julia and the text above it.
_STRUCT = re.compile(r'"""\s*(?:Base\.@kwdef )?struct ')
_DOCUMENTED = re.compile(r'"""((?:(?!""").)*)"""\s*(?:Base\.@kwdef )?struct (\w+)', re.DOTALL)


def declared_orders(text: str) -> dict[str, int]:
    """Return orders by name: ``alg_order(alg::Name) = n``, ``p%order = n``, "A third-order .."."""
    if "rder" not in text and "RDER" not in text:
        return {}
    places = re.findall(
        r"module procedure (\w+)_properties(?:(?!end procedure).){0,4000}?p%order = (\d+)",
        text,
        re.DOTALL,
    )
    if places:
        return {name: int(n) for name, n in places}
    places = re.findall(
        r"^class (\w+)(?:(?!^class ).)*?IntegratorOrder\(\) const(?: override)? *\{ *return (\d+)",
        text, re.DOTALL | re.MULTILINE) if "IntegratorOrder()" in text else []  # fmt: skip
    if places:
        return {name: int(n) for name, n in places}
    documented = {}
    for doc, name in _DOCUMENTED.findall(text) if _STRUCT.search(text) else ():
        said = re.search(r"\b(\d+)(?:st|nd|rd|th)[- ]order|\b([a-z]+)-order", doc, re.IGNORECASE)
        order = said and (int(said[1]) if said[1] else ORDINALS.get(said[2].lower()))
        if order:
            documented[name] = order
    found = _ORDER_FUNCTION.findall(text) if _RETURNS.search(text) else []
    for inner in (y for x in _ORDERS for y in x.findall(text)):
        found += re.findall(r"[\"']([\w .-]+)[\"']\s*[:=,]\s*(\d{1,2})\b", inner)
    documented |= {name: int(n) for name, n in found}
    found = _ORDER_OF_TYPE.findall(text) if _OF_TYPE.search(text) else []
    return documented | {x.strip(): int(n) for names, n in found for x in names.split(",")}


#: ``alg_order(::Name) = n`` and ``order(x::Name) = n`` of Julia.
_OF_TYPE = re.compile(r"order\(\s*\w*::")
_ORDER_OF_TYPE = re.compile(
    r"(?<!\w)(?:alg_|get_)?order\(\s*\w*::(?:Union\{)?([\w, ]+)\}?\s*\)\s*=\s*(\d+)"
)
#: A step of OrdinaryDiffEq.jl, through its ``end``: the types of its cache, and its statements.
_PERFORM = re.compile(
    r"^(?:@\w+ )*function perform_step!\([^()]*?\bcache::(\w+|Union\{[^{}]*\})(.*?)^end\b",
    re.DOTALL | re.MULTILINE,
)


def completed_entries(text: str) -> dict[str, tuple[str, int]]:
    """Return the entries that a step assigns to after it took them from the table.

    Such a table is completed at run time, as weights that depend on a frequency are.

    Returns
    -------
    dict
        By the type of the cache, which is the name of its table: the first such entry, and its
        line.
    """
    found: dict[str, tuple[str, int]] = {}
    for step in _PERFORM.finditer(text) if "perform_step!" in text else ():
        taken = re.findall(r"\(;([^()]*)\)\s*=\s*cache\b|@unpack ([^=]*)=\s*cache\b", step[2])
        entries = {x for pair in taken for x in re.findall(r"\w+", "".join(pair))}
        for line in re.finditer(r"^\s*(\w+)\s*[-+*/]?=(?!=)", step[2], re.MULTILINE):
            if line[1] in entries and _ENTRY.fullmatch(line[1]):
                at = text.count("\n", 0, step.start(2) + line.start(1)) + 1
                for name in re.findall(r"\w+", step[1].removeprefix("Union")):
                    found.setdefault(name, (line[1], at))
                break
    return found


ORDINALS = {
    x: k
    for k, x in enumerate(
        "first second third fourth fifth sixth seventh eighth ninth tenth".split(), 1
    )
}


def _julia(text: str, declared: Mapping[str, int] | None = None) -> Iterator[Table]:
    run = _Run(text, "julia")
    declared = declared or {}
    made = ("ExplicitRKTableau", "ExplicitTableau", "ImplicitRKTableau", "Tableau", "IMEXTableau",
            "DIRKButcher",
            "IMEXButcher", "SymplecticTableau", "RosenbrockButcher", "RodasTableau",
            "RosenbrockTableau", "ESDIRKIMEXTableau", "IMKGTableau", "NystromVITableau",
            "NystromVDTableau")  # fmt: skip
    top = ("TableauRKExplicit",)
    for _, node in run.steps():
        name = run.header.removeprefix("function ").strip()
        short = re.sub(r"(?:ESDIRKIMEX|IMEX|Rodas)?(?:ConstantCache|Tableau)$", "", name)
        order = declared.get(short)
        for call in _calls(node, top if run.depth == 0 else made):
            kind = ast.unparse(call.func).rpartition(".")[2]
            if kind == name:  # another way to make such a table
                continue
            try:
                table = _of_julia(run, kind, call, name, order)
            except Unread as error:
                table = _unread(name, run.line, error)
            if table is not None:
                table.doubt = _text_says_otherwise(text, name, order)
                yield table
        if isinstance(node, ast.Return) and node.value is not None:
            for call in _calls(node, [name]):
                if name.endswith(("ConstantCache", "Tableau")) and len(call.args) > 2:
                    try:
                        table = _of_names(run, name, order)
                    except Unread as error:
                        table = _unread(name, run.line, error)
                    if table is not None:
                        yield table


def _text_says_otherwise(text: str, name: str, order: int | None) -> str:
    """Return the order in the text above a function, as "2nd order", where it is another one."""
    doc = re.search(rf'"""((?:(?!""").)*)"""\s*function {re.escape(name)}\b', text, re.DOTALL)
    said = re.search(r"\b(\d+)(?:st|nd|rd|th)[- ]order", doc[1]) if doc else None
    return f"its text says {said[0]}" if said and order and int(said[1]) != order else ""


def _of_julia(run: _Run, kind: str, call: ast.Call, name: str, order: int | None) -> Table | None:
    words, line = _keywords(call), run.line
    if kind in ("ExplicitRKTableau", "ImplicitRKTableau"):
        if len(call.args) < 4:
            return None
        A, c, b, n = (run.value(x) for x in call.args[:4])
        s = len(vector(b))
        table = Table(name, line, A=[_square(A, s)], b=[vector(b)], c=[vector(c)])
        table.order = whole_number(n)
        key = next((x for x in words if x in ("αEEst", "aEEst", "bEEst")), "")
        if key:
            low = run.value(words[key])
            least = words.get("adaptiveorder")
            table.rows = [("αEEst", vector(low), whole_number(run.value(least)))]
        return table
    if kind == "TableauRKExplicit":
        if len(call.args) != 6 or not isinstance(call.args[0], ast.Constant):
            return None
        title = _words(call.args[0])
        orders, A, weights, c = (run.value(call.args[k]) for k in (1, 3, 4, 5))
        times = vector(c)
        s = len(times)
        flat = vector(weights)
        rows = [flat[k : k + s] for k in range(0, len(flat), s)]
        known = [whole_number(x) for x in orders]
        table = Table(title, line, A=[_square(A, s)], b=[rows[0]], c=[times], order=known[0])
        table.rows = [("second row", x, n) for x, n in zip(rows[1:], known[1:], strict=True)]
        return table
    if kind == "Tableau":
        if len(call.args) < 5:
            return None
        title = _words(call.args[0])
        n, A, b, c = (run.value(x) for x in call.args[1:5])
        s = len(vector(b))
        return Table(title, line, A=[_square(A, s)], b=[vector(b)], c=[vector(c)],
                     order=whole_number(n))  # fmt: skip
    if kind == "ExplicitTableau" and "a" in words:
        A = run.value(words["a"])
        b = vector(run.value(words["b"])) if "b" in words else vector(A[-1])
        return Table(name, line, A=[_square(A, len(A))], b=[b], c=[None], order=order)
    if kind == "DIRKButcher":
        A, b, c = (run.value(x) for x in call.args[:3])
        s = len(vector(b))
        return Table(name, line, A=[_square(A, s)], b=[vector(b)], c=[vector(c)], order=order)
    if kind == "IMEXButcher":
        A, b, c, A2, b2, c2 = (run.value(x) for x in call.args[:6])
        s = len(vector(b))
        return Table(name, line, "additive", [_square(A, s), _square(A2, s)],
                     [vector(b), vector(b2)], [vector(c), vector(c2)], order)  # fmt: skip
    if kind == "IMEXTableau" and "a_exp" in words:
        A, A2 = (run.value(words[x]) for x in ("a_exp", "a_imp"))
        s = len(A)
        A, A2 = _square(A, s), _square(A2, s)
        b, b2 = (
            vector(run.value(words[k])) if k in words else M[-1]
            for k, M in (("b_exp", A), ("b_imp", A2))
        )
        c = [vector(run.value(words[k])) if k in words else None for k in ("c_exp", "c_imp")]
        return Table(name, line, "additive", [A, A2], [b, b2], c, order)
    if kind in ("NystromVITableau", "NystromVDTableau") and len(call.args) >= 7:
        parts = 1 + kind.startswith("NystromVD")
        return _nystrom(name, line, [run.value(x) for x in call.args[: 5 + parts]], parts, order)
    if kind == "SymplecticTableau" and len(call.args) == 2:
        a, b = (vector(run.value(x)) for x in call.args)
        return Table(name, line, "splitting", [], [a, b], order=order)
    if kind == "ESDIRKIMEXTableau" and len(call.args) >= 9:
        return _esdirk(run, call, name, order)
    if kind == "RodasTableau" and len(call.args) == 8:
        A, C, g, b, e = (run.value(call.args[k]) for k in (0, 1, 2, 6, 7))
        m = vector(b)
        s = len(m)
        if not isinstance(g, Number):
            raise Unread("gamma is no number")
        low = vector(e, s) if e is not None else None
        table = transformed(name, line, g, _wide(A, s), _wide(C, s), m, low)
        table.order = order
        return table
    if kind == "IMKGTableau" and len(call.args) in (3, 4):
        A, b = imkg([vector(run.value(x)) for x in call.args])
        return Table(name, line, "additive", A, b, [None, None], order)
    return None


def _nystrom(name: str, line: int, given: list[Any], parts: int, order: int | None) -> Table:
    """Return A, for two parts also A', b, b', both estimates, and c without its first entry, 0."""
    below = given[:parts]
    b, b_prime, *errors, c = (vector(x) for x in given[parts:])
    s = len(b_prime)
    table = Table(name, line, "nystrom", [_square(A, s) for A in below], [b, b_prime], order=order)
    table.c = [[ZERO, *c]]
    table.errors = [x for x in errors if x]
    return table


def _wide(value: Any, s: int) -> Rows:
    """Return a matrix (s, s) from one whose last columns may be left out where they are zero."""
    if isinstance(value, Sparse):
        return _square(value, s, base=1)
    return [vector(row, s) for row in value]


def _esdirk(run: _Run, call: ast.Call, name: str, order: int | None) -> Table:
    args = call.args[1:] if isinstance(call.args[0], ast.Call) else call.args
    Ai, bi, Ae, be, c, bt, ebt = (run.value(x) for x in args[:7])
    s = len(vector(bi))
    words = _keywords(call)
    given = whole_number(run.value(args[8]))
    if not any(complex(x.value) for x in vector(be)):  # the implicit half alone
        table = Table(name, run.line, A=[_square(Ai, s)], b=[vector(bi)], c=[vector(c)])
    else:
        ce = vector(run.value(words["ce"])) if "ce" in words else vector(c)
        table = Table(name, run.line, "additive", [_square(Ae, s), _square(Ai, s)],
                      [vector(be), vector(bi)], [ce, vector(c)])  # fmt: skip
    table.order = order or given
    table.errors = [vector(x) for x in (bt, ebt) if vector(x)]
    return table


_ENTRY = re.compile(r"(a|b|c|btilde|bhat)_?(\d+)$")


def _stages(number: int) -> int:
    """Return a number of stages, which a name or an index can make as large as it likes.

    Raises
    ------
    Unread
        Beyond what a method file may have.
    """
    if number > MAX_SIZE:
        raise Unread(f"a coefficient of more than {MAX_SIZE} stages, by its name or index")
    return number


def _of_names(run: _Run, name: str, order: int | None) -> Table | None:
    """Read coefficients with names of their own: a21, a0201 or, from 0, a0100, b1, c2, btilde1."""
    if any(re.fullmatch(r"bbar_?\d+", key) for key in run.scope):
        raise Unread("weights `bbar` of a method of two steps are not read")
    found: dict[str, dict[str, Number]] = {}
    for key, value in run.scope.items():
        match = _ENTRY.fullmatch(key)
        if match and isinstance(value, Number):
            found.setdefault(match[1], {})[match[2]] = value
        elif match and isinstance(value, Unread):
            raise value
    if len(found.get("a", {})) < 1 or "γ" in run.scope:  # a diagonal without a name
        return None
    entries: dict[tuple[int, int], Number] = {}
    wide = any(len(x) == 4 for x in found["a"])
    for digits, value in found["a"].items():
        cut = len(digits) - 2 if wide and len(digits) > 3 else len(digits) - 1
        if not wide and len(digits) == 3:
            cut = 2
        if cut < 1:
            return None
        i, j = int(digits[:cut]), int(digits[cut:])
        if j >= i:
            raise Unread("an entry of A on or above the diagonal, by its name")
        entries[i, j] = value
    if any(j == 0 for _, j in entries):  # stages are numbered from 0
        entries = {(i + 1, j + 1): value for (i, j), value in entries.items()}
    b = {int(k): v for k, v in found.get("b", {}).items()}
    s = max(i for i, _ in entries)
    _stages(max([s, *b, *map(int, found.get("btilde", ()))]))
    if any(re.fullmatch(r"(?:α|alpha)_?\d+", key) for key in run.scope):
        raise Unread("weights under the names `α` are not read")
    s = max([s, *b])
    A = [[entries.get((i, j), ZERO) for j in range(1, s + 1)] for i in range(1, s + 1)]
    weights = [b.get(k, ZERO) for k in range(1, s + 1)] if b else A[-1]
    table = Table(name, run.line, A=[A], b=[weights], order=order, named=True)
    given = {int(k): v for k, v in found.get("c", {}).items()}
    sums = [sum((complex(x.value).real for x in row), 0.0) for row in A]
    best: list[Number | None] = []
    worst = 0
    for offset in (0, 1):
        c = [given.get(i - offset) for i in range(1, s + 1)]
        gaps = sum(
            x is not None and abs(complex(x.value).real - y) > 1e-6
            for x, y in zip(c, sums, strict=True)
        )
        if not best or gaps < worst:
            best, worst = c, gaps
    full = [
        x if x is not None else Number(sum((y.value for y in row), Exact(0)))
        for x, row in zip(best, A, strict=True)
    ]
    table.c = [full if given else None]
    for key in ("btilde",):
        if key in found:
            error = {int(k): v for k, v in found[key].items()}
            table.errors = [[error.get(k, ZERO) for k in range(1, max([s, *error]) + 1)]]
    if "bhat" in found and not b:
        return None
    return table


def by_name(name: str, b: Sequence[Number], *, pair: bool) -> int | None:
    """Return the order in names as SSP104, ten stages and order 4, as RK4, and of pairs as BS5."""
    digits = re.search(r"(\d+)$", name)
    if digits is None:
        return None
    if len(digits[1]) > 1 and digits[1][:-1] == str(len(b)):
        return int(digits[1][-1]) or None
    if digits[1] in ("10", "12", "14") and len(b) > int(digits[1]):  # with as many stages at least
        return int(digits[1])
    alone = pair or re.fullmatch(r"(?i)(?:runge_?kutta|e?rk)_?\d", name)
    return int(digits[1]) or None if alone and len(digits[1]) == 1 else None


FORMATS: Mapping[str, Callable[..., Iterator[Table]]] = {
    "json": from_json,
    "csv": from_csv,
    "petsc": _petsc,
    "julia": _julia,
    "constants": constants,
    "principia": structs,
    "odeint": odeint,
}
SUFFIXES: Mapping[str, tuple[str, ...]] = {
    "json": (".json",),
    "csv": (".csv",),
    "petsc": (".c",),
    "julia": (".jl",),
    "constants": (".cc", ".C", ".cpp", ".hh"),
    "principia": (".hpp",),
    "odeint": (".hpp",),
}


def read(text: str, form: str, declared: Mapping[str, int] | None = None) -> Iterator[Table]:
    """Yield tables of one file in the order in which they stand there."""
    if form in ("julia", "constants"):
        yield from FORMATS[form](text, declared)
    else:
        yield from FORMATS[form](text)
