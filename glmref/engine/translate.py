"""Translate generated source to LLVM's assembly, statement by statement.

The part of Python that generated kernels and the loop bodies of problems use: arithmetic on floats
and integers, entries and slices of arrays of doubles, ``if``, ``while``, ``for`` over ``range``,
calls of ``abs``, ``sqrt``, ``sin`` and their like and of other functions of the module. Anything
else raises :class:`Unsupported`, and the source goes to numba.

The same source becomes one for lanes where an array of the kernel has the kind ``v*``: each of its
entries is a vector with one number for each lane, and so is all that is computed from them. A
choice ``a if c else b`` is then made in each lane; a branch on such a condition is unsupported.

A function is translated once for each combination of argument kinds it is called with. Every
variable is a stack slot, which LLVM turns into registers. Arrays that are arguments of one call do
not overlap; generated calls and loop bodies keep to that.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from typing import Any

from .expressions import Array, Expressions, Unsupported, is_slice


def translated(
    source: str, arguments: Mapping[str, str], *, fuse: bool = False, lanes: int = 0
) -> str:
    """Return LLVM assembly of a module's function ``kernel`` and of what it calls.

    ``arguments`` are names with kinds: ``d*``, ``i*`` or ``v*`` for arrays, ``d`` or ``i`` for
    numbers; ``v`` is a vector of so many ``lanes``. With ``fuse`` a product and a sum may become
    one operation.
    """
    tree = ast.parse(source)
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    if "kernel" not in functions:
        raise Unsupported("there is no kernel")
    module = _Module(functions, ("contract",) if fuse else (), lanes)
    names = [argument.arg for argument in functions["kernel"].args.args]
    if names != list(arguments):
        raise Unsupported(f"arguments {names}")
    _Function(module, "kernel", functions["kernel"], tuple(arguments.values()))
    return str(module.module)


class _Module:
    """The module that is being built, and the functions translated so far."""

    def __init__(
        self, functions: Mapping[str, ast.FunctionDef], flags: tuple[str, ...], lanes: int
    ) -> None:
        from llvmlite import ir

        self.ir, self.module, self.functions = ir, ir.Module("glmref"), functions
        self.double, self.integer, self.bit = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
        self.flags = flags  # of operations on doubles
        self.vector = ir.VectorType(self.double, lanes) if lanes else None
        self.bits = ir.VectorType(self.bit, lanes) if lanes else None
        self.done: dict[tuple[str, tuple[str, ...]], Any] = {}

    def function(self, name: str, kinds: tuple[str, ...]) -> Any:
        """Return a function of the module for arguments of these kinds."""
        if (name, kinds) not in self.done:
            unique = f"{name}.{len(self.done)}"
            made = _Function(self, unique, self.functions[name], kinds)
            made.function.linkage = "internal"
            self.done[name, kinds] = made.function
        return self.done[name, kinds]


class _Function(Expressions):
    """Translates one function; kinds ``d1``, ``v2`` .. are arrays passed with their shape."""

    def __init__(
        self, module: _Module, name: str, node: ast.FunctionDef, kinds: tuple[str, ...]
    ) -> None:
        self.m, self.ir = module, module.ir
        self.double, self.integer, self.bit = module.double, module.integer, module.bit
        types, names = [], [argument.arg for argument in node.args.args]
        if len(names) != len(kinds):
            raise Unsupported(f"{name} takes {len(names)} arguments")
        numbers = {"d": self.double, "i": self.integer, "v": module.vector}
        for kind in kinds:
            number, sizes = numbers[kind[0]], int(kind[1:].strip("*") or 0)
            types.append(number.as_pointer() if kind[1:] else number)
            types += [self.integer] * sizes
        self.function = self.ir.Function(
            module.module, self.ir.FunctionType(self.integer, types), name=name
        )
        self.entry = self.function.append_basic_block("entry")
        first = self.function.append_basic_block("body")
        self.b = self.ir.IRBuilder(first)
        self.slots: dict[str, Any] = {}
        given_wide = [x for x, kind in zip(names, kinds, strict=True) if kind[0] == "v"]
        self.wide = _reached(node.body, given_wide)
        self.arrays: dict[str, Array] = {}
        self.exits: list[Any] = []
        given = iter(self.function.args)
        for argument, kind in zip(names, kinds, strict=True):
            value = next(given)
            if not kind[1:]:
                self._assign(argument, value)
                continue
            value.add_attribute("noalias")
            sizes = int(kind[1]) if kind[1].isdigit() else 0
            self.arrays[argument] = Array(value, tuple(next(given) for _ in range(sizes)))
        self._statements(node.body)
        if not self.b.block.is_terminated:
            self.b.ret(self.integer(0))
        self.ir.IRBuilder(self.entry).branch(first)

    # --- statements -----------------------------------------------------------------------------

    def _statements(self, body: Sequence[ast.stmt]) -> None:
        for node in body:
            if self.b.block.is_terminated:
                return
            method = getattr(self, f"_{type(node).__name__}", None)
            if method is None:
                raise Unsupported(type(node).__name__)
            method(node)

    def _Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call):
            self._value(node.value)
        elif not isinstance(node.value, ast.Constant):
            raise Unsupported(ast.unparse(node))

    def _Assign(self, node: ast.Assign) -> None:
        (target,) = node.targets
        if isinstance(target, ast.Name) and is_slice(node.value):
            self.arrays[target.id] = self._array(node.value)
            return
        self._store(target, self._value(node.value))

    def _store(self, target: ast.expr, value: Any) -> None:
        if isinstance(target, ast.Name):
            self._assign(target.id, value)
        elif isinstance(target, ast.Subscript):
            place = self._place(target)
            value = self._as(value, place.type.pointee)
            self.b.store(value, place, align=self._alignment(place))
        else:
            raise Unsupported(ast.unparse(target))

    def _AugAssign(self, node: ast.AugAssign) -> None:
        load = ast.parse(ast.unparse(node.target), mode="eval").body
        self._store(node.target, self._binary(node.op, self._value(load), self._value(node.value)))

    def _If(self, node: ast.If) -> None:
        condition = self._truth(node.test)
        then, other, after = self._blocks("then", "else", "after")
        self.b.cbranch(condition, then, other)
        for block, body in ((then, node.body), (other, node.orelse)):
            self.b.position_at_end(block)
            self._statements(body)
            if not self.b.block.is_terminated:
                self.b.branch(after)
        self.b.position_at_end(after)

    def _While(self, node: ast.While) -> None:
        head, body, after = self._blocks("loop", "in", "out")
        self._enter(head)
        if isinstance(node.test, ast.Constant) and node.test.value is True:
            self.b.branch(body)
        else:
            self.b.cbranch(self._truth(node.test), body, after)
        self._inside(body, node.body, head, after)
        self.b.position_at_end(after)

    def _blocks(self, *names: str) -> list[Any]:
        return [self.function.append_basic_block(name) for name in names]

    def _enter(self, block: Any) -> None:
        self.b.branch(block)
        self.b.position_at_end(block)

    def _inside(self, block: Any, body: Sequence[ast.stmt], again: Any, after: Any) -> None:
        self.exits.append(after)
        self.b.position_at_end(block)
        self._statements(body)
        if not self.b.block.is_terminated:
            self.b.branch(again)
        self.exits.pop()

    def _For(self, node: ast.For) -> None:
        call = node.iter
        if not (isinstance(call, ast.Call) and isinstance(node.target, ast.Name)):
            raise Unsupported(ast.unparse(node.iter))
        if ast.unparse(call.func) != "range":
            raise Unsupported(ast.unparse(node.iter))
        limits = [self._as(self._value(x), self.integer) for x in call.args]
        start, stop = (self.integer(0), limits[0]) if len(limits) == 1 else limits[:2]
        step = ast.literal_eval(call.args[2]) if len(limits) == 3 else 1
        name = node.target.id
        # the counter is its own, so that the loop variable may be assigned to
        counter = self.ir.IRBuilder(self.entry).alloca(self.integer, name=f"{name}.count")
        self.b.store(start, counter)
        head, body, more, after = self._blocks("for", "each", "next", "done")
        self._enter(head)
        value = self.b.load(counter)
        self.b.cbranch(self.b.icmp_signed("<" if step > 0 else ">", value, stop), body, after)
        self.b.position_at_end(body)
        self._assign(name, value)
        self._inside(self.b.block, node.body, more, after)
        self.b.position_at_end(more)
        self.b.store(self.b.add(self.b.load(counter), self.integer(step), flags=("nsw",)), counter)
        self.b.branch(head)
        self.b.position_at_end(after)

    def _Break(self, _: ast.Break) -> None:
        self.b.branch(self.exits[-1])

    def _Return(self, node: ast.Return) -> None:
        value = self.integer(0) if node.value is None else self._value(node.value)
        self.b.ret(self._as(value, self.integer))


def _reached(body: Sequence[ast.stmt], names: Sequence[str]) -> set[str]:
    """Return the variables computed from these, these included: from their entries, lanes."""

    def read(node: ast.AST) -> set[str]:
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("len", "lanes_with"):
            return set()
        own = {node.id} if isinstance(node, ast.Name) else set()
        return own.union(*(read(child) for child in ast.iter_child_nodes(node)))

    steps = [
        (target.id, read(node.value))
        for statement in body
        for node in ast.walk(statement)
        if isinstance(node, ast.Assign | ast.AugAssign)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        if isinstance(target, ast.Name)
    ]
    found, before = set(names), -1
    while names and len(found) > before:
        before = len(found)
        found |= {name for name, sources in steps if sources & found}
    return found
