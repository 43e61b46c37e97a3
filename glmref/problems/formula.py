"""Functions of a problem as data: one definition for numpy, for any precision and for kernels.

A :class:`Formula` holds Python expressions such as ``"-sin(y[0])"``. They are read through a
whitelist (so a formula may come from a file), evaluated in double precision by numpy or at any
precision in an mpmath context, differentiated by :mod:`.derivative`, and pasted into generated
kernels as they stand. A decimal literal means the decimal: ``0.1`` is 1/10 at every precision.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from ..errors import UsageError, did_you_mean
from ..system.arguments import shown

Number = int | Fraction | float
#: Expression in place of ``vector[index]``; ``None`` where it stays.
Component = Callable[[str, int], str | None]
_NONE: Mapping[str, str] = MappingProxyType({})

FUNCTIONS = ("sqrt", "sin", "cos", "tan", "exp", "log", "atan2")
LARGEST_EXPONENT = 1000
#: What a power of numbers alone may have as a base that is made of powers itself.
LARGEST_BASE = 1e15
_NODES = (
    *(ast.Expression, ast.BinOp, ast.UnaryOp, ast.Call, ast.Subscript, ast.Name, ast.Constant),
    *(ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.USub, ast.Load),
)
_ARITHMETIC: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_NUMPY = {name: getattr(np, name) for name in FUNCTIONS if name != "atan2"}
_NUMPY |= {"atan2": np.arctan2, "pi": math.pi}


def functions(context: Any = None) -> dict[str, Any]:
    """Return the functions (and ``pi``) of numpy, or of an mpmath context."""
    if context is None:
        return dict(_NUMPY)
    return {name: getattr(context, name) for name in FUNCTIONS} | {"pi": +context.pi}


def real_power(base: Any, exponent: Any) -> Any:
    """Return base**exponent; NaN where real numbers have none, as compiled code computes it.

    Python makes a complex number of a negative float to a power that is not whole.
    """
    power = base**exponent
    if isinstance(power, complex) and not isinstance(base, complex):
        return power if isinstance(exponent, complex) else math.nan
    return power


class RealPowers(ast.NodeTransformer):
    """Writes ``real_power(x, y)`` for ``x**y``, unless y is a whole number."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """Replace one power, after those inside it."""
        self.generic_visit(node)
        exponent = node.right.operand if isinstance(node.right, ast.UnaryOp) else node.right
        whole = isinstance(exponent, ast.Constant) and isinstance(exponent.value, int)
        if whole or not isinstance(node.op, ast.Pow):
            return node
        return ast.Call(ast.Name("real_power", ast.Load()), [node.left, node.right], [])


def exact_number(value: object, what: str) -> Number:
    """Read a parameter: int, Fraction, finite float (its exact value), or a string such as "3/5".

    Raises
    ------
    UsageError
        For anything else, naming the parameter ``what``.
    """
    if isinstance(value, np.generic):
        value = value.item()
    number: Number | None = None
    if isinstance(value, str):
        with suppress(ValueError, ZeroDivisionError):
            # beyond this no double is meant, and the whole number would take long to form
            exponent = value.lower().partition("e")[2] or "0"
            number = Fraction(value) if abs(int(exponent)) <= LARGEST_EXPONENT else None
    elif isinstance(value, int | Fraction | float) and not isinstance(value, bool):
        number = value
    if number is not None and _has_double(number):
        return number
    raise UsageError(
        f"`{what}` must be a finite number in the range of double precision or a string such as "
        f"'3/5', got {shown(value)}"
    )


def _has_double(number: Number) -> bool:
    """Return whether the nearest double is finite, and zero for zero alone."""
    try:
        nearest = float(number)
    except OverflowError:
        return False
    return math.isfinite(nearest) and (nearest != 0 or number == 0)


def to_number(value: Number, context: Any = None) -> Any:
    """Convert a parameter to a double, or to a number of an mpmath context."""
    if context is None:
        return float(value)
    if isinstance(value, Fraction):
        return context.mpf(value.numerator) / value.denominator
    return context.mpf(value)


_DOUBLE = np.dtype(float)


@dataclass(frozen=True)
class Formula:
    """A function given by expressions; calling it evaluates them.

    Called with a vector of shape (d,) it returns an array of ``shape``; with (d, m), that is one
    column per state, it returns ``shape + (m,)``.

    Raises
    ------
    UsageError
        For an expression that is not arithmetic in the names given.
    """

    outputs: tuple[str, ...]  #: One expression per component.
    #: Pairs (name, expression) computed first, in this order; each may use those before.
    common: tuple[tuple[str, str], ...] = ()
    #: Names of the arguments. The last one is a vector, written ``y[0]``, ``y[1]``...
    variables: tuple[str, ...] = ("t", "y")
    parameters: Mapping[str, Number] = field(default_factory=dict)  #: Values of other names.
    #: Shape of the result, ``()`` for a scalar; by default one component per output.
    shape: tuple[int, ...] | None = None
    #: ``None`` for numpy in double precision, else an mpmath context.
    context: Any = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        parameters = {k: exact_number(v, k) for k, v in self.parameters.items()}
        shape = (len(self.outputs),) if self.shape is None else tuple(self.shape)
        set_field = object.__setattr__
        set_field(self, "outputs", tuple(self.outputs))
        set_field(self, "common", tuple((name, text) for name, text in self.common))
        set_field(self, "parameters", MappingProxyType(parameters))
        set_field(self, "shape", shape)
        if math.prod(shape) != len(self.outputs):
            raise UsageError(f"a formula of shape {shape} cannot have {len(self.outputs)} outputs")

    def __call__(self, *arguments: Any) -> Any:
        """Evaluate at a state (d,), or at states in columns (d, m)."""
        *others, last = arguments
        if type(last) is np.ndarray and last.dtype == _DOUBLE and self.context is None:
            vector = last
        else:
            dtype = float if self.context is None else object
            vector = np.asarray(last, dtype=None if np.iscomplexobj(last) else dtype)
        assert self.shape is not None
        if not self.shape:
            return self._function(*others, vector)
        out = np.empty((len(self.outputs), *vector.shape[1:]), dtype=vector.dtype)
        self._function(*others, vector, out)
        return out if len(self.shape) == 1 else out.reshape(self.shape + vector.shape[1:])

    def on(self, context: Any) -> Formula:
        """Return this function evaluated in an mpmath context, at that context's precision."""
        return replace(self, context=context)

    @cached_property
    def trees(self) -> tuple[tuple[tuple[str, ast.expr], ...], tuple[ast.expr, ...]]:
        """Syntax trees of ``common`` and ``outputs``, checked."""
        names = {*self.variables, *self.parameters, "pi"}
        common = []
        for name, text in self.common:
            if not name.isidentifier() or name in names or name in FUNCTIONS:
                raise UsageError(f"the common subexpression {name!r} needs a name of its own")
            common.append((name, _checked(text, frozenset(names), self.variables[-1:])))
            names.add(name)
        allowed = frozenset(names)
        return tuple(common), tuple(_checked(x, allowed, self.variables[-1:]) for x in self.outputs)

    @cached_property
    def indices(self) -> frozenset[int]:
        """Components of the vector argument that occur."""
        common, outputs = self.trees
        found = set()
        for tree in (*(tree for _, tree in common), *outputs):
            found |= {i for _, i in subscripts(tree)}
        return frozenset(found)

    @cached_property
    def _function(self) -> Callable[..., Any]:
        """Compile into ``function(*variables)``, with a last argument ``out`` unless scalar."""
        common, outputs = self.trees
        literals = _Literals(self.context)
        lines = [f"{name} = {literals.text(tree)}" for name, tree in common]
        if self.shape:
            # equal outputs are one tree: most entries of a large Jacobian are zero
            texts = {id(tree): literals.text(tree) for tree in {id(x): x for x in outputs}.values()}
            lines += [f"out[{i}] = {texts[id(tree)]}" for i, tree in enumerate(outputs)]
        else:
            lines.append(f"return {literals.text(outputs[0])}")
        arguments = ", ".join((*self.variables, "out") if self.shape else self.variables)
        source = f"def formula({arguments}):\n    " + "\n    ".join(lines)
        namespace: dict[str, Any] = functions(self.context)
        namespace |= {k: to_number(v, self.context) for k, v in self.parameters.items()}
        namespace |= literals.values | {"real_power": real_power}
        exec(compile(source, "<formula>", "exec"), namespace)
        return namespace["formula"]

    def substituted(self, old: str, new: str, shift: int) -> Formula:
        """Return the formula with ``old[i]`` written ``new[i + shift]``."""
        found = self.rewritten(lambda x, i: f"{new}[{i + shift}]" if x == old else None)
        return replace(
            found, variables=tuple(new if name == old else name for name in self.variables)
        )

    def rewritten(self, component: Component, names: Mapping[str, str] = _NONE) -> Formula:
        """Return the formula after :func:`substituted` in each of its expressions."""
        return replace(
            self,
            outputs=tuple(substituted(text, component, names) for text in self.outputs),
            common=tuple((k, substituted(text, component, names)) for k, text in self.common),
        )


class _Literals(ast.NodeTransformer):
    """Binds number literals to numbers of the context, but for indices and whole exponents."""

    def __init__(self, context: Any) -> None:
        self.context = context
        self.values: dict[str, Any] = {}

    def text(self, tree: ast.expr) -> str:
        if self.context is None:
            return ast.unparse(RealPowers().visit(ast.parse(ast.unparse(tree), mode="eval")))
        return ast.unparse(self.visit(ast.parse(ast.unparse(tree), mode="eval")))

    def visit_Subscript(self, node: ast.Subscript) -> ast.Subscript:
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.BinOp:
        node.left = self.visit(node.left)
        whole = isinstance(node.right, ast.Constant) and isinstance(node.right.value, int)
        if not (isinstance(node.op, ast.Pow) and whole):
            node.right = self.visit(node.right)
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.Name:
        exact = node.value
        if not isinstance(exact, int):  # repr gives back the decimal as it was written
            exact = Fraction(repr(exact))
        value = to_number(exact, self.context)
        name = f"number_{len(self.values)}"
        self.values[name] = value
        return ast.Name(name, ast.Load())


def kept(vector: str, index: int) -> str | None:
    """Leave a component as it is."""
    return None


def substituted(text: str, component: Component, names: Mapping[str, str] = _NONE) -> str:
    """Return an expression with others in place of components and names, and in their place too.

    ``component`` gives that of ``vector[index]``, or ``None``; ``names`` those of names.
    """

    class Put(ast.NodeTransformer):
        def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
            ((vector, index),) = subscripts(node)
            new = component(vector, index)
            return node if new is None else ast.parse(new, mode="eval").body

        def visit_Name(self, node: ast.Name) -> ast.expr:
            new = names.get(node.id)
            return node if new is None else self.visit(ast.parse(new, mode="eval").body)

    return ast.unparse(Put().visit(ast.parse(text, mode="eval")))


def subscripts(tree: ast.AST) -> Iterator[tuple[str, int]]:
    """Yield (vector, index) for each component that occurs in a checked tree."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Subscript):
            assert isinstance(node.value, ast.Name) and isinstance(node.slice, ast.Constant)
            yield node.value.id, int(node.slice.value)  # type: ignore[arg-type]


@lru_cache(maxsize=4096)
def _checked(text: str, names: frozenset[str], vectors: tuple[str, ...]) -> ast.expr:
    """Parse one expression, refusing everything but arithmetic in the names given."""
    where = shown(text)
    try:
        tree = ast.parse(text, mode="eval")
    except (SyntaxError, TypeError, ValueError):
        raise UsageError(f"the expression {where} cannot be read") from None
    except (RecursionError, MemoryError):
        raise UsageError(f"the expression {where} is nested too deeply") from None
    calls = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    bases = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Subscript)}
    for node in ast.walk(tree):
        if not isinstance(node, _NODES):
            what = type(node).__name__
            raise UsageError(f"the expression {where} contains {what}; write arithmetic only")
        if isinstance(node, ast.Constant) and type(node.value) not in (int, float):
            raise UsageError(f"the expression {where} contains {shown(node.value)}, not a number")
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            if called not in FUNCTIONS or node.keywords:
                near = "; write sqrt(x**2)" if called == "abs" else ""
                near = near or did_you_mean(called, FUNCTIONS, "; ")
                raise UsageError(
                    f"the expression {where} calls {called[:40]}; known are "
                    f"{', '.join(FUNCTIONS)}{near}"
                )
            arity = 2 if called == "atan2" else 1
            if len(node.args) != arity:
                raise UsageError(f"{called} takes {arity} in {where}, got {len(node.args)}")
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
            _check_power(node, where)
        if isinstance(node, ast.Subscript):
            index = node.slice
            whole = isinstance(index, ast.Constant) and type(index.value) is int
            vector = isinstance(node.value, ast.Name) and node.value.id in vectors
            if not (whole and vector):
                raise UsageError(f"the expression {where} must write components as {vectors[0]}[0]")
        if isinstance(node, ast.Name) and id(node) not in calls:
            if (node.id in vectors) != (id(node) in bases):
                raise UsageError(f"the expression {where} must write components as {vectors[0]}[0]")
            if node.id not in names:
                raise UsageError(
                    f"the expression {where} contains the unknown name {shown(node.id)}; known "
                    f"are {', '.join(sorted(names))}"
                )
    _check_numbers(tree, where)
    return tree.body


def _check_numbers(tree: ast.AST, where: str) -> None:
    """Refuse numbers, and arithmetic of numbers alone, without a real value in double precision.

    Python would go on with a whole number of any size or with a complex number, and its compiler
    computes such parts beforehand, for kernels too.
    """
    values: dict[int, Any] = {}
    for node in reversed(list(ast.walk(tree))):  # operands before what is made of them
        value: Any = None
        with suppress(ZeroDivisionError):  # has no value at any precision, and is said when run
            try:
                value = _value(node, values)
            except OverflowError:
                value = math.inf
        if value is None:
            continue
        if isinstance(value, complex) or not _has_double(value):
            raise UsageError(
                f"the part {shown(ast.unparse(node))} of the expression {where} has no real value "
                f"in the range of double precision"
            )
        values[id(node)] = value


def _value(node: ast.AST, values: Mapping[int, Any]) -> Any:
    """Return the value of a number or of arithmetic of numbers; ``None`` for anything else."""
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name) and node.id == "pi":
        return math.pi
    if isinstance(node, ast.UnaryOp) and id(node.operand) in values:
        return -values[id(node.operand)]
    if not isinstance(node, ast.BinOp) or not {id(node.left), id(node.right)} <= values.keys():
        return None
    operation = _ARITHMETIC[type(node.op)]
    return operation(values[id(node.left)], values[id(node.right)])


def _size(side: ast.expr) -> float:
    """Return the size of an expression of numbers, in floats: towers of powers cost nothing."""
    values: dict[int, Any] = {}
    for node in reversed(list(ast.walk(side))):
        with suppress(ZeroDivisionError, OverflowError):
            value = _value(node, values)
            if value is not None:
                values[id(node)] = 1.0 * value
    return abs(values.get(id(side), math.inf))


def _check_power(node: ast.BinOp, where: str) -> None:
    """Refuse powers that a few characters make astronomically large."""
    literals = [x.value for x in ast.walk(node.right) if isinstance(x, ast.Constant)]
    towers = [
        side
        for side, most in ((node.left, LARGEST_BASE), (node.right, 0))
        if any(isinstance(x, ast.Pow) for x in ast.walk(side))
        and not any(isinstance(x, ast.Name) for x in ast.walk(side))
        and not _size(side) <= most
    ]
    if towers or any(isinstance(x, int | float) and abs(x) > LARGEST_EXPONENT for x in literals):
        raise UsageError(
            f"the exponent of {shown(ast.unparse(node))} in {where} is no number up to "
            f"{LARGEST_EXPONENT}"
        )
