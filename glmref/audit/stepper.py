"""Explicit steps written out in Fortran, read as the linear forms that they compute.

``call me%f(t+c*h, x+h*(..), f2)`` is a stage: the form of its argument in t, h, x and the slopes
before it gives a row of A, and its time the entry of c. The last value of ``xf`` gives the weights,
that of ``xerr`` the weights of the error estimate.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from typing import Any

from ..exact import Exact
from .code import statements
from .values import Number, Scope, Unread, evaluate

_ZERO, _ONE = Number(Exact(0)), Number(Exact(1))
Form = dict[str, Number]
Rows = list[list[Number]]
Read = tuple[Rows, list[Number], list[Number], list[Number]]


def procedures(text: str) -> Iterator[tuple[str, int, Read | Unread]]:
    """Name, line, and A, b, c and error weights of each procedure that makes stages."""
    step: _Step | None = None
    for statement in _joined(text):
        if statement.kind == "open":
            step = _Step(statement.text.removeprefix("procedure "), statement.line)
        elif statement.kind == "close":
            if step is not None and step.stages:
                yield step.name, step.line, step.finished()
            step = None
        elif step is not None:
            step.take(statement.text, statement.line)


def _joined(text: str) -> Iterator[Any]:
    """Yield statements with their continuation lines put together."""
    rows = text.split("\n")
    out: list[str] = []
    k = 0
    while k < len(rows):
        row, count = rows[k].partition("!")[0].rstrip(), 0
        while row.endswith("&") and k + count + 1 < len(rows):
            count += 1
            row = row[:-1] + rows[k + count].partition("!")[0].strip().lstrip("&")
            row = row.rstrip()
        out += [row, *([""] * count)]
        k += count + 1
    return statements("\n".join(out), "fortran")


class _Step:
    """One procedure."""

    def __init__(self, name: str, line: int) -> None:
        self.name, self.line = name, line
        self.scope: Scope = {"1-based": 1}
        self.forms: dict[str, Form] = {x: {x: _ONE} for x in "thx"}
        self.stages: list[tuple[Form, Form]] = []
        self.trouble: Unread | None = None

    def take(self, text: str, line: int) -> None:
        """Carry out a statement."""
        text = text.strip().replace("%", ".")
        try:
            if text.startswith("associate"):
                self._associate(text)
            elif re.match(r"call me\.(?:f|check_fsal_cache|set_fsal_cache)\(", text):
                time, place, slope = self._arguments(text)
                self._stage(time, place, slope)
            elif "=" in text and not text.startswith(("call", "if", "use", "real", "integer")):
                self._assign(text)
        except Unread as error:
            error.line = line
            self.trouble = self.trouble or error

    def _arguments(self, text: str) -> tuple[ast.expr, ast.expr, str]:
        call = _parsed(text.removeprefix("call "))
        if not isinstance(call, ast.Call) or len(call.args) != 3:
            raise Unread("a call of the right-hand side is not understood")
        return call.args[0], call.args[1], ast.unparse(call.args[2])

    def _stage(self, time: ast.expr, place: ast.expr, slope: str) -> None:
        self.stages.append((self._form(time), self._form(place)))
        self.forms[slope] = {f"f{len(self.stages)}": _ONE}

    def _associate(self, text: str) -> None:
        inner = text.partition("(")[2].rstrip()[:-1]
        for part in _parts(inner):
            name, _, value = part.partition("=>")
            if "me." not in value:
                self.forms[name.strip()] = self._form(_parsed(value.strip()))

    def _assign(self, text: str) -> None:
        name, _, value = (x.strip() for x in text.partition("="))
        node = _parsed(value)
        try:
            self.scope[name] = evaluate(node, self.scope)
        except Unread:
            self.forms[name] = self._form(node)

    def _form(self, node: ast.expr) -> Form:
        if isinstance(node, ast.Name | ast.Attribute):
            name = ast.unparse(node)
            if name in self.forms:
                return self.forms[name]
        if isinstance(node, ast.UnaryOp):
            form = self._form(node.operand)
            if isinstance(node.op, ast.USub):
                return {k: x.of(-x.value) for k, x in form.items()}
            return form
        if isinstance(node, ast.BinOp):
            x, y = self._form(node.left), self._form(node.right)
            if isinstance(node.op, ast.Add | ast.Sub):
                sign = 1 if isinstance(node.op, ast.Add) else -1
                total = dict(x)
                for k, v in y.items():
                    old = total.get(k, _ZERO)
                    total[k] = old.of(old.value + sign * v.value, v)
                return total
            if isinstance(node.op, ast.Mult):
                return _product(x, y)
            if isinstance(node.op, ast.Div) and set(y) == {"1"}:
                if y["1"].value == 0:
                    raise Unread("a quotient has the divisor 0")
                return {k: v.of(v.value / y["1"].value, y["1"]) for k, v in x.items()}
            raise Unread("an operator is not read")
        return {"1": evaluate(node, self.scope)}

    def finished(self) -> Read | Unread:
        """Return the tableau, or what was not understood."""
        if self.trouble is not None:
            return self.trouble
        s = len(self.stages)
        try:
            A = [_row(place, s) for _, place in self.stages]
            c = [time.get("h", _ZERO) for time, _ in self.stages]
            b = _row(self.forms["xf"], s)
            error = self.forms.get("xerr")
            weights = _row({**error, "x": _ONE}, s) if error is not None else []
        except KeyError:
            return Unread("there is no value `xf`", self.line)
        except Unread as trouble:
            return trouble
        used = [any(complex(row[j].value) for row in (*A, b, *([weights] if weights else [])))
                for j in range(s)]  # fmt: skip
        keep = [j for j in range(s) if used[j]] or [0]
        return (
            [[A[i][j] for j in keep] for i in keep],
            [b[j] for j in keep],
            [c[j] for j in keep],
            [weights[j] for j in keep] if weights else [],
        )


def _row(form: Mapping[str, Number], s: int) -> list[Number]:
    row = [_ZERO] * s
    for k, v in form.items():
        if k.startswith("h*f"):
            row[int(k[3:]) - 1] = v
        elif k == "x":
            if abs(complex(v.value) - 1) > 1e-9:
                raise Unread(f"a value holds {complex(v.value).real:.6g} times x")
        elif complex(v.value) != 0:
            raise Unread(f"a value holds the term {k}")
    return row


def _product(x: Form, y: Form) -> Form:
    total: Form = {}
    for j, a in x.items():
        for k, b in y.items():
            if "1" in (j, k):
                key = k if j == "1" else j
            elif "h" in (j, k) and (k if j == "h" else j).startswith("f"):
                key = "h*" + (k if j == "h" else j)
            else:
                raise Unread(f"a product of {j} and {k} is not read")
            old = total.get(key, _ZERO)
            total[key] = old.of(old.value + a.value * b.value, a.of(a.value, b))
    return total


def _parsed(text: str) -> ast.expr:
    try:
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise Unread(f"{text[:60]!r} is not understood") from None


def _parts(text: str) -> list[str]:
    parts, depth, start = [], 0, 0
    for k, x in enumerate(text):
        depth += (x in "([") - (x in ")]")
        if x == "," and depth == 0:
            parts.append(text[start:k])
            start = k + 1
    return [x for x in (*parts, text[start:]) if "=>" in x]
