"""A loop body for one size, without its loops: straight lines that can stand in any kernel.

What depends on sizes, ranges and whole numbers alone is computed here; what is left is arithmetic
on components, in the order in which the loops would do it, so with the same bits. Straight lines
become vector instructions where a loop over pairs does not, and can be written once per lane.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..problems.formula import FUNCTIONS

_WHOLE: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Lt: operator.lt,
    ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}  # fmt: skip


class _NotStraight(Exception):
    """The body does something whose course is not known before it runs, or is too long."""


class _Fold(ast.NodeTransformer):
    """Puts known whole numbers in the place of what computes them."""

    def __init__(self, known: Mapping[str, int], sizes: Mapping[str, int]) -> None:
        self.known, self.sizes = known, sizes

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in self.known and isinstance(node.ctx, ast.Load):
            return ast.Constant(self.known[node.id])
        return ast.Name(node.id, node.ctx)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        left, right = self.visit(node.left), self.visit(node.right)
        if _is_whole(left) and _is_whole(right) and type(node.op) in _WHOLE:
            return ast.Constant(_WHOLE[type(node.op)](left.value, right.value))
        return ast.BinOp(left, node.op, right)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        operand = self.visit(node.operand)
        if isinstance(node.op, ast.USub) and _is_whole(operand):
            return ast.Constant(-operand.value)
        return ast.UnaryOp(node.op, operand)

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        left, *others = (self.visit(x) for x in (node.left, *node.comparators))
        if len(others) == 1 and _is_whole(left) and _is_whole(others[0]):
            return ast.Constant(_WHOLE[type(node.ops[0])](left.value, others[0].value))
        raise _NotStraight

    def visit_Call(self, node: ast.Call) -> ast.expr:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name == "len" and isinstance(node.args[0], ast.Name):
            return ast.Constant(self.sizes[node.args[0].id])
        if name not in (*FUNCTIONS, "abs") or node.keywords:
            raise _NotStraight
        return ast.Call(ast.Name(name, ast.Load()), [self.visit(x) for x in node.args], [])

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        place = self.visit(node.slice)
        if not isinstance(node.value, ast.Name) or not _is_whole(place):
            raise _NotStraight
        if not 0 <= place.value < self.sizes.get(node.value.id, 0):
            raise _NotStraight
        return ast.Subscript(ast.Name(node.value.id, ast.Load()), place, node.ctx)


def _is_whole(node: ast.expr) -> Any:
    return isinstance(node, ast.Constant) and type(node.value) in (int, bool)


def unrolled(text: str, sizes: Sequence[int], longest: int) -> str:
    """Return the source of a body as one function without loops and branches.

    ``text`` is a function of plain loops (:mod:`..problems.loops`), ``sizes`` are the lengths of
    its arguments that are arrays: all but a first ``t``. ``""`` where there is no such function, or
    one of more than ``longest`` statements only.
    """
    tree = ast.parse(text)
    function = tree.body[0]
    if len(tree.body) != 1 or not isinstance(function, ast.FunctionDef):
        return ""
    names = [x.arg for x in function.args.args][-len(sizes) :]
    lengths = dict(zip(names, sizes, strict=True))
    lines: list[ast.stmt] = []
    known: dict[str, int] = {}

    def run(body: Sequence[ast.stmt]) -> None:
        for node in body:
            fold = _Fold(known, lengths)
            if isinstance(node, ast.For):
                call, target = node.iter, node.target
                if not (isinstance(call, ast.Call) and isinstance(target, ast.Name)):
                    raise _NotStraight
                limits = [fold.visit(x) for x in call.args]
                if ast.unparse(call.func) != "range" or not all(map(_is_whole, limits)):
                    raise _NotStraight
                for k in range(*(x.value for x in limits)):
                    known[target.id] = k
                    run(node.body)
            elif isinstance(node, ast.If):
                test = fold.visit(node.test)
                if not _is_whole(test):
                    raise _NotStraight
                run(node.body if test.value else node.orelse)
            elif isinstance(node, ast.Assign | ast.AugAssign):
                assign(node, fold)
            elif not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
                raise _NotStraight
            if len(lines) > longest:
                raise _NotStraight

    def assign(node: ast.Assign | ast.AugAssign, fold: _Fold) -> None:
        target = node.targets[0] if isinstance(node, ast.Assign) else node.target
        value = fold.visit(node.value)
        if isinstance(target, ast.Name):
            if isinstance(node, ast.AugAssign):
                value = fold.visit(ast.BinOp(ast.Name(target.id, ast.Load()), node.op, node.value))
            if _is_whole(value):
                known[target.id] = value.value
                return
            known.pop(target.id, None)
        place = target if isinstance(target, ast.Name) else fold.visit(target)
        if isinstance(node, ast.AugAssign) and not isinstance(target, ast.Name):
            value = ast.BinOp(place, node.op, value)
        lines.append(ast.Assign([place], value))

    try:
        run(function.body)
    except (_NotStraight, KeyError, IndexError, ZeroDivisionError):
        return ""
    function.body = lines or [ast.Pass()]
    return ast.unparse(ast.fix_missing_locations(function))


def placed(
    text: str, component: Callable[[int], str], result: Callable[[int], str],
    parameter: Callable[[int], str], prefix: str,
) -> list[str]:  # fmt: skip
    """Return statements of a body from :func:`unrolled` with other names for its data.

    ``component``, ``result`` and ``parameter`` give the source of entry i of each; ``prefix`` comes
    before its own names.
    """
    function = ast.parse(text).body[0]
    assert isinstance(function, ast.FunctionDef)
    *others, state, params, out = (x.arg for x in function.args.args)
    entries = {state: component, params: parameter, out: result}
    kept = {*FUNCTIONS, "abs"}

    class Rename(ast.NodeTransformer):
        def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
            assert isinstance(node.value, ast.Name) and isinstance(node.slice, ast.Constant)
            name = entries[node.value.id](int(node.slice.value))  # type: ignore[arg-type]
            return ast.parse(name, mode="eval").body

        def visit_Name(self, node: ast.Name) -> ast.expr:
            if node.id in others:
                return ast.Name("time", node.ctx)
            return node if node.id in kept else ast.Name(prefix + node.id, node.ctx)

    return [ast.unparse(Rename().visit(node)) for node in function.body]
