"""Expressions of generated source as LLVM instructions; statements are in :mod:`.translate`."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

#: Bytes of a cache line, and of the widest vectors: across its border a load costs two.
CACHE_LINE = 64

#: Functions of the C library: name -> number of arguments.
LIBRARY = {"sin": 1, "cos": 1, "tan": 1, "exp": 1, "log": 1, "atan2": 2, "pow": 2}


class Unsupported(Exception):
    """The source uses more of Python than this translator knows."""


@dataclass(frozen=True)
class Array:
    """A contiguous array: pointer to its first entry and its shape (one or two integers)."""

    pointer: Any
    shape: tuple[Any, ...]


class Expressions:
    """Values of expressions: numbers (double, integer, bit), one for each lane, and arrays.

    Where an operation meets a vector, a number beside it is taken in every lane.
    """

    m: Any  #: The module: its types, its functions.
    ir: Any
    b: Any  #: Where instructions go.
    entry: Any  #: Block of the stack slots.
    double: Any
    integer: Any
    bit: Any
    slots: dict[str, Any]  #: Stack slot of each number variable.
    wide: set[str]  #: Variables that have a number for each lane.
    arrays: dict[str, Array]  #: The array variables.

    def _assign(self, name: str, value: Any) -> None:
        if name not in self.slots:
            place, kind = self.ir.IRBuilder(self.entry), value.type
            if name in self.wide and kind in (self.double, self.integer):
                kind = self.m.vector
            self.slots[name] = place.alloca(kind, name=name)
            # read before it is set only where a branch was not taken
            place.store(self.ir.Constant(kind, None), self.slots[name])
        slot = self.slots[name]
        self.b.store(self._as(value, slot.type.pointee), slot)

    def _as(self, value: Any, kind: Any) -> Any:
        if value.type == kind:
            return value
        if kind == self.double and value.type == self.integer:
            return self.b.sitofp(value, self.double)
        if kind == self.integer and value.type == self.bit:
            return self.b.zext(value, self.integer)
        if kind == self.m.vector and value.type in (self.double, self.integer):
            i32, nothing = self.ir.IntType(32), self.ir.Constant(kind, self.ir.Undefined)
            first = self.b.insert_element(nothing, self._as(value, self.double), i32(0))
            everywhere = self.ir.Constant(self.ir.VectorType(i32, kind.count), None)
            return self.b.shuffle_vector(first, nothing, everywhere)
        raise Unsupported(f"a {value.type} where a {kind} is needed")

    def _floating(self, *values: Any) -> list[Any]:
        """Return values as doubles, or as vectors of them where one is a vector."""
        wide = any(value.type == self.m.vector for value in values)
        return [self._as(value, self.m.vector if wide else self.double) for value in values]

    # --- arrays ---------------------------------------------------------------------------------

    def _array(self, node: ast.expr) -> Array:
        """Return an array: a name, a slice ``a[i:j]``, or ``a[i:j].reshape((m, n))``."""
        if isinstance(node, ast.Name) and node.id in self.arrays:
            return self.arrays[node.id]
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            base, (shape,) = self._array(node.func.value), node.args
            if node.func.attr == "reshape" and isinstance(shape, ast.Tuple):
                return Array(base.pointer, tuple(self._value(x) for x in shape.elts))
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice):
            base, cut = self._array(node.value), node.slice
            low = self.integer(0) if cut.lower is None else self._value(cut.lower)
            if cut.upper is None and len(base.shape) != 1:
                raise Unsupported(ast.unparse(node))
            high = base.shape[0] if cut.upper is None else self._value(cut.upper)
            pointer = self.b.gep(base.pointer, [low], inbounds=True)
            return Array(pointer, (self.b.sub(high, low),))
        raise Unsupported(ast.unparse(node))

    def _place(self, node: ast.Subscript) -> Any:
        array = self._array(node.value)
        index = node.slice
        if isinstance(index, ast.Tuple):
            if len(array.shape) != 2:
                raise Unsupported(ast.unparse(node))
            i, j = (self._as(self._value(x), self.integer) for x in index.elts)
            flat = self.b.add(self.b.mul(i, array.shape[1], flags=("nsw",)), j, flags=("nsw",))
        else:
            flat = self._as(self._value(index), self.integer)
        return self.b.gep(array.pointer, [flat], inbounds=True)

    def _alignment(self, place: Any) -> int | None:
        """Return bytes that the address of an entry is a multiple of; of doubles the usual ones."""
        return CACHE_LINE if place.type.pointee == self.m.vector else None

    # --- expressions ----------------------------------------------------------------------------

    def _value(self, node: ast.expr) -> Any:
        method = getattr(self, f"_value_{type(node).__name__}", None)
        if method is None:
            raise Unsupported(type(node).__name__)
        return method(node)

    def _truth(self, node: ast.expr) -> Any:
        value = self._value(node)
        if value.type != self.bit:
            raise Unsupported(f"the truth of {ast.unparse(node)}")
        return value

    def _value_Constant(self, node: ast.Constant) -> Any:
        if isinstance(node.value, bool):
            return self.bit(int(node.value))
        if isinstance(node.value, int):
            return self.integer(node.value)
        if isinstance(node.value, float):
            return self.double(node.value)
        raise Unsupported(repr(node.value))

    def _value_Name(self, node: ast.Name) -> Any:
        if node.id not in self.slots:
            raise Unsupported(f"the name {node.id}")
        return self.b.load(self.slots[node.id])

    def _value_Subscript(self, node: ast.Subscript) -> Any:
        place = self._place(node)
        return self.b.load(place, align=self._alignment(place))

    def _value_BinOp(self, node: ast.BinOp) -> Any:
        return self._binary(node.op, self._value(node.left), self._value(node.right))

    def _binary(self, operation: ast.operator, left: Any, right: Any) -> Any:
        kind, b = type(operation), self.b
        if left.type == right.type in (self.bit, self.m.bits) and kind in (ast.BitAnd, ast.BitOr):
            return (b.and_ if kind is ast.BitAnd else b.or_)(left, right)
        if left.type == right.type == self.integer and kind not in (ast.Div, ast.Pow):
            if kind in (ast.FloorDiv, ast.Mod):
                # indices: neither side is negative
                return (b.sdiv if kind is ast.FloorDiv else b.srem)(left, right)
            whole = {ast.Add: b.add, ast.Sub: b.sub, ast.Mult: b.mul}
            if kind not in whole:
                raise Unsupported(kind.__name__)
            return whole[kind](left, right, flags=("nsw",))
        left, right = self._floating(left, right)
        if kind is ast.Pow:
            return self._library("pow", [left, right])
        floating = {ast.Add: b.fadd, ast.Sub: b.fsub, ast.Mult: b.fmul, ast.Div: b.fdiv}
        if kind not in floating:
            raise Unsupported(kind.__name__)
        return floating[kind](left, right, flags=self.m.flags)

    def _value_UnaryOp(self, node: ast.UnaryOp) -> Any:
        value = self._value(node.operand)
        if isinstance(node.op, ast.Not) and value.type in (self.bit, self.m.bits):
            return self.b.not_(value)
        if isinstance(node.op, ast.USub):
            return self.b.neg(value) if value.type == self.integer else self.b.fneg(value)
        raise Unsupported(ast.unparse(node))

    def _value_Compare(self, node: ast.Compare) -> Any:
        result, left = None, self._value(node.left)
        for operation, other in zip(node.ops, node.comparators, strict=True):
            right = self._value(other)
            one = self._compared(operation, left, right)
            result = one if result is None else self.b.and_(result, one)
            left = right
        return result

    def _compared(self, operation: ast.cmpop, left: Any, right: Any) -> Any:
        signs = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==",
                 ast.NotEq: "!="}  # fmt: skip
        sign = signs.get(type(operation))
        if sign is None:
            raise Unsupported(type(operation).__name__)
        if left.type == right.type and left.type in (self.integer, self.bit):
            return self.b.icmp_signed(sign, left, right)
        left, right = self._floating(left, right)
        # every comparison with a NaN is false, except !=
        compare = self.b.fcmp_unordered if sign == "!=" else self.b.fcmp_ordered
        return compare(sign, left, right)

    def _value_BoolOp(self, node: ast.BoolOp) -> Any:
        # operands have no side effects, so all of them may be evaluated
        join = self.b.and_ if isinstance(node.op, ast.And) else self.b.or_
        result = self._truth(node.values[0])
        for other in node.values[1:]:
            result = join(result, self._truth(other))
        return result

    def _value_IfExp(self, node: ast.IfExp) -> Any:
        condition = self._value(node.test)
        left, right = self._value(node.body), self._value(node.orelse)
        if condition.type == self.m.bits:  # each lane chooses for itself
            left, right = self._as(left, self.m.vector), self._as(right, self.m.vector)
        elif condition.type != self.bit:
            raise Unsupported(f"the truth of {ast.unparse(node.test)}")
        elif left.type != right.type:
            left, right = self._floating(left, right)
        return self.b.select(condition, left, right)

    def _value_Call(self, node: ast.Call) -> Any:
        name = ast.unparse(node.func)
        if node.keywords:
            raise Unsupported(ast.unparse(node))
        if name in self.m.functions:
            return self._call(name, node.args)
        if name in self.slots:
            return self._call_at(self._as(self._value(node.func), self.integer), node.args)
        if name == "len":
            return self._array(node.args[0]).shape[0]
        if name == "int":
            return self.b.fptosi(self._value(node.args[0]), self.integer)
        if name == "lanes_with":
            (lanes,) = (self._value(x) for x in node.args)
            found = self._intrinsic("vector.reduce.or", self.m.bits, self.bit)
            return self.b.zext(self.b.call(found, [lanes]), self.integer)
        given = self._floating(*(self._value(x) for x in node.args))
        if name in ("abs", "sqrt") and len(given) == 1:
            (kind,) = (x.type for x in given)
            return self.b.call(
                self._intrinsic("fabs" if name == "abs" else "sqrt", kind, kind), given
            )
        if LIBRARY.get(name) != len(given):
            raise Unsupported(f"the function {name}")
        return self._library(name, given)

    def _call(self, name: str, arguments: Sequence[ast.expr]) -> Any:
        """Call another function of the module."""
        kinds, given = [], []
        for node in arguments:
            if isinstance(node, ast.Name) and node.id in self.slots:
                is_array = False
            else:
                is_array = isinstance(node, ast.Name) or is_slice(node)
            if not is_array:
                value = self._value(node)
                kinds.append({self.double: "d", self.m.vector: "v"}.get(value.type, "i"))
                given.append(value)
                continue
            array = self._array(node)
            if len(array.shape) not in (1, 2):
                raise Unsupported(f"the length of {ast.unparse(node)}")
            letter = "d" if array.pointer.type.pointee == self.double else "v"
            kinds.append(f"{letter}{len(array.shape)}")
            given += [array.pointer, *array.shape]
        return self.b.call(self.m.function(name, tuple(kinds)), given)

    def _call_at(self, address: Any, arguments: Sequence[ast.expr]) -> Any:
        """Call a kernel of these arguments by its address; arrays go without their shapes."""
        given = [
            self.arrays[x.id].pointer
            if isinstance(x, ast.Name) and x.id in self.arrays
            else self._value(x)
            for x in arguments
        ]
        kind = self.ir.FunctionType(self.integer, [x.type for x in given])
        return self.b.call(self.b.inttoptr(address, kind.as_pointer()), given)

    def _intrinsic(self, name: str, given: Any, result: Any) -> Any:
        """Return an intrinsic function of LLVM of one argument."""
        lanes = f"v{given.count}" if isinstance(given, self.ir.VectorType) else ""
        kind = "i1" if given == self.m.bits else "f64"
        return self.m.module.declare_intrinsic(
            f"llvm.{name}.{lanes}{kind}", (), self.ir.FunctionType(result, [given])
        )

    def _library(self, name: str, given: list[Any]) -> Any:
        """Call a function of the C library, once for each lane."""
        if given[0].type == self.m.vector:
            result = self.ir.Constant(self.m.vector, self.ir.Undefined)
            for lane in map(self.ir.IntType(32), range(self.m.vector.count)):
                numbers = [self.b.extract_element(x, lane) for x in given]
                result = self.b.insert_element(result, self._library(name, numbers), lane)
            return result
        found = self.m.module.globals.get(name)
        if found is None:
            kind = self.ir.FunctionType(self.double, [self.double] * len(given))
            found = self.ir.Function(self.m.module, kind, name=name)
            found.attributes.add("nounwind")
        return self.b.call(found, given)


def is_slice(node: ast.expr) -> bool:
    """Return whether an expression is a slice or a reshaped slice."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        return node.func.attr == "reshape"
    return isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice)
