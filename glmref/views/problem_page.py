"""A problem as formulas: for a terminal and as JSON.

Formulas are those that are integrated, with common subexpressions named. A problem of many
particles is given by loops, and the formula is that of its Hamiltonian as the source states it.
"""

from __future__ import annotations

import ast
import inspect
import math
from collections.abc import Mapping
from typing import Any

from ..errors import UsageError
from ..problems.formula import Formula
from ..problems.loops import Loops
from ..problems.model import Problem


def kind_of(problem: Problem) -> str:
    """Return what of its structure a method can use, in words."""
    if problem.second_order:
        return "second order, q'' = g(q)"
    if problem.separable:
        return "separable, q' = dq(p), p' = dp(q)"
    if problem.extended is not None:
        return "separable with time: " + (
            "q'' = g(q, t)" if problem.extended.second_order else "q' = dq(p, t), p' = dp(q, t)"
        )
    if problem.canonical:
        return "Hamiltonian, not separable"
    if problem.semi_separable:
        return "semi-separable, q' = f(p), p' = g(t, q, p)"
    return "y' = f(t, y)"


def described(problem: Problem, about: str = "") -> dict[str, Any]:
    """Return everything about a problem that JSON can hold.

    ``formulas`` are name -> list of expressions, of loops the body's name. Long vectors are cut
    after 12 entries.
    """
    formulas: dict[str, list[str]] = {}
    for key in ("hamiltonian", "force", "dq", "dp", "f"):
        derived = problem.second_order and key in ("dq", "dp")
        if not derived and not (key == "f" and problem.separable):
            function = getattr(problem, key)
            if function is not None:
                formulas[key] = formula_lines(function)
    return {
        "name": problem.name,
        "about": about,
        "kind": kind_of(problem),
        "dimension": problem.dimension,
        "parameters": {k: str(v) for k, v in problem.parameters.items()},
        "t_span": list(map(float, problem.t_span)),
        "y0": [float(x) for x in problem.y0[:12]],
        "formulas": formulas,
        "invariants": [*problem.quadratic, *problem.invariants],
        "solution": "closed form" if problem.exact else "stored" if problem.references else "",
        "source": problem.source,
    }


def formula_lines(function: Any) -> list[str]:
    """Return the expressions of a function, those of common parts first; of loops their name."""
    if isinstance(function, Formula):
        named = [f"{name} = {text}" for name, text in function.common]
        return [*named, *function.outputs]
    if isinstance(function, Loops):
        said = (inspect.getdoc(function.body) or "").partition("\n")[0]
        return [f"loop {function.body.__name__}" + (f": {said}" if said else "")]
    return [f"Python function {getattr(function, '__name__', type(function).__name__)}"]


def page(problem: Problem, about: str = "") -> list[tuple[str, str]]:
    """Return rows (what, text) of a terminal's page.

    Parts that the problem has not are left out.
    """
    data: Mapping[str, Any] = described(problem, about)
    rows = [("problem", data["name"]), ("", data["about"]), ("kind", data["kind"])]
    rows.append(("dimension", str(data["dimension"])))
    if data["parameters"]:
        given = ", ".join(f"{k} = {v}" for k, v in data["parameters"].items())
        rows.append(("parameters", given))
    heads = {
        "hamiltonian": "H", "force": "q'' = g(q)", "dq": "q' =", "dp": "p' =", "f": "y' =",
    }  # fmt: skip
    for key, lines in data["formulas"].items():
        shown = lines if len(lines) <= 12 else [*lines[:12], f"... {len(lines) - 12} more"]
        rows += [(heads[key] if k == 0 else "", line) for k, line in enumerate(shown)]
    dots = ", ..." if data["dimension"] > 12 else ""
    rows.append(("y0", ", ".join(f"{x:.6g}" for x in data["y0"]) + dots))
    rows.append(("time", f"{data['t_span'][0]:g} to {data['t_span'][1]:g}"))
    if data["invariants"]:
        rows.append(("also conserved", ", ".join(data["invariants"])))
    if data["solution"]:
        rows.append(("solution", data["solution"]))
    if data["source"]:
        rows.append(("source", data["source"]))
    return [row for row in rows if row[1]]


def c_source(problem: Problem) -> str:
    """Return the right-hand side as C, as the steppers of ``glmref convert --to c`` call it.

    It has ``dimension``, ``initial`` and ``rhs(t, y, out, data)``; of a separable problem ``dq(p,
    out, data)`` and ``dp(q, out, data)`` too.

    Raises
    ------
    UsageError
        For loops and Python functions.
    """
    d = problem.dimension
    numbers = ", ".join(repr(float(x)) for x in problem.y0)
    title = " ".join(problem.name.split()).replace("*/", "")
    lines = [f"/* {title}: what is integrated, and from where. */"]
    lines += ["#include <math.h>", "", f"enum {{ dimension = {d} }};"]
    lines += [f"static const double initial[{d}] = {{{numbers}}};", ""]
    parts: list[tuple[str, str, Any]] = [("rhs", "double t, const double *y", problem.f)]
    if problem.separable:
        parts.append(("dq", "const double *p", problem.dq))
        parts.append(("dp", "const double *q", problem.dp))
    for name, arguments, function in parts:
        if not isinstance(function, Formula):
            raise UsageError(
                f"{problem.name} is not given by expressions; write {name} in C by hand"
            )
        lines.append(f"static void {name}({arguments}, double *out, void *data) {{")
        lines.append("  (void)data;" + (" (void)t;" if name == "rhs" else ""))
        common, outputs = function.trees
        write = _C({k: float(v) for k, v in function.parameters.items()})
        lines += [f"  const double {key} = {write(tree)};" for key, tree in common]
        lines += [f"  out[{k}] = {write(tree)};" for k, tree in enumerate(outputs)]
        lines += ["}", ""]
    return "\n".join(lines)


class _C:
    """Expressions as C: every number is a double, small powers are products."""

    def __init__(self, parameters: Mapping[str, float]) -> None:
        self.parameters = parameters

    def __call__(self, tree: ast.expr) -> str:
        if isinstance(tree, ast.Constant):
            return self._number(float(tree.value))  # type: ignore[arg-type]
        if isinstance(tree, ast.Name):
            known = self.parameters.get(tree.id)
            if tree.id == "pi":
                known = math.pi
            return tree.id if known is None else self._number(known)
        if isinstance(tree, ast.Subscript):
            return ast.unparse(tree)
        if isinstance(tree, ast.UnaryOp):
            return f"(-{self(tree.operand)})"
        if isinstance(tree, ast.Call):
            return f"{ast.unparse(tree.func)}({', '.join(map(self, tree.args))})"
        assert isinstance(tree, ast.BinOp)
        left = self(tree.left)
        if isinstance(tree.op, ast.Pow):
            n = tree.right.value if isinstance(tree.right, ast.Constant) else None
            if isinstance(n, int) and 2 <= n <= 4:
                return "(" + "*".join([left] * n) + ")"
            return f"pow({left}, {self(tree.right)})"
        sign = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}[type(tree.op)]
        return f"({left} {sign} {self(tree.right)})"

    @staticmethod
    def _number(x: float) -> str:
        return repr(x) if x >= 0 else f"({x!r})"
