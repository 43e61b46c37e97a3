"""What a kernel needs to know of a problem: which functions, given how, on which components.

A right-hand side is given in one of three ways, and each part of a separable one in its own:
expressions (pasted into the kernel), a plain loop body (pasted as a function), or any Python
callable (compiled by numba where it can be).
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import UsageError
from ..problems.canonical import taken, timed
from ..problems.derivative import Jacobian
from ..problems.formula import Formula, subscripts
from ..problems.loops import Loops, PhaseSpace
from ..problems.model import Problem
from .band import Band, band_of, formula_structure, loop_structure, stays_within, written
from .unroll import unrolled

_STRAIGHT_UP_TO = 500  # statements of a loop body without its loops
_STRAIGHT_SIZE = 40  # components up to which it is tried
#: Powers with whole exponents up to this, of either sign, become products, and those with a half
#: besides products and a square root: the same bits in C, numba and Python, where those of ``pow``
#: are the C library's.
_EXPAND_UP_TO = 8


@dataclass(frozen=True)
class Part:
    """One function of a right-hand side."""

    role: str  #: ``"full"`` for f(t, y), ``"force"`` for dp(q), ``"velocity"`` for dq(p).
    #: Components of y that it fills.
    start: int
    stop: int
    #: Components of y that it reads are ``range(source, source_stop)``.
    source: int
    source_stop: int
    formula: Formula | None = None  #: Its expressions, or ``None``.
    body: str = ""  #: Source text of a plain loop body, or ``None``.
    body_name: str = ""  #: Name of that body.
    straight: str = ""  #: The body for this size without its loops, or ``""`` where that is long.
    function: Callable[..., Any] | None = None  #: A Python callable, where neither is there.
    identity: bool = False  #: q' = p.

    @property
    def timed(self) -> bool:
        """Whether the function is called with t."""
        return self.role == "full"

    @property
    def uses_time(self) -> bool:
        """Whether the value can depend on t."""
        if self.role != "full":
            return False
        if self.formula is None:
            return True
        return timed(self.formula)


@dataclass(frozen=True)
class Shape:
    """A problem as code generation sees it; two problems of one shape share a kernel."""

    dimension: int
    halved: bool  #: Whether q and p parts are evaluated apart (separable).
    parts: tuple[Part, ...]  #: The full right-hand side, or (velocity, force).
    jacobian: Formula | None  #: Formula of the Jacobian (d, d), or ``None``.
    parameters: tuple[str, ...]  #: Names handed to expressions.
    values: np.ndarray  #: Their values, then the constants of a loop body: the kernel's ``par``.
    #: Source and name of a loop body for it, or ``""``.
    jacobian_body: str = ""
    jacobian_name: str = ""
    #: Order of the unknowns of Newton's method in which their matrix has few diagonals, or
    #: ``None``.
    band: Band | None = None

    @cached_property
    def par(self) -> np.ndarray:
        """What a kernel is called with: the values, then positions and order of a band."""
        if self.band is None:
            return self.values
        return np.concatenate([self.values, self.band.places, self.band.order])

    @property
    def differenced(self) -> bool:
        """Whether the Jacobian is formed by differences: it is not given, or not as a band."""
        if self.jacobian is not None:
            return False
        return not self.jacobian_body or (self.band is not None and not self.banded_body)

    @cached_property
    def banded_body(self) -> str:
        """The body of the Jacobian, writing into diagonals; ``""`` where it cannot."""
        if self.band is None or self.halved or not self.jacobian_body:
            return ""
        params = self.values[len(self.parameters) :].tolist()
        if not stays_within(self.jacobian_body, self.jacobian_name, self.band, params):
            return ""
        upper, step = self.band.upper, self.band.width - 1
        place = f"int(places[{{1}}])*{step} + {upper} + int(places[{{0}}])"
        return written(self.jacobian_body, place.format)

    @property
    def half(self) -> int:
        """Number of positions of a separable problem."""
        return self.dimension // 2

    @property
    def opaque(self) -> bool:
        """Whether a Python callable, neither expressions nor a loop body, is among the parts."""
        return any(part.function is not None for part in self.parts)

    @property
    def loops(self) -> bool:
        """Whether a part is a loop body or a callable, which works on arrays."""
        return any(part.formula is None and not part.identity for part in self.parts)

    @property
    def arrays(self) -> bool:
        """Whether a part can be called on arrays only: a long loop body, or a callable."""
        parts = (part for part in self.parts if part.formula is None and not part.identity)
        return any(not part.straight for part in parts)

    @property
    def pairwise(self) -> bool:
        """Whether a body has a loop inside a loop: many operations for each component."""
        nodes = [x for part in self.parts for x in ast.walk(ast.parse(part.body))]
        bodies = [line for node in nodes if isinstance(node, ast.For) for line in node.body]
        return any(isinstance(x, ast.For) for line in bodies for x in ast.walk(line))

    @property
    def uses_time(self) -> bool:
        """Whether the right-hand side depends on t."""
        return any(part.uses_time for part in self.parts)

    @property
    def counted(self) -> Part:
        """The part whose evaluations are counted first: f, or the force."""
        return self.parts[-1]


def shape_of(problem: Problem, *, split: bool | None = None, first: bool = False) -> Shape:
    """Read the shape of a problem.

    ``split`` asks for separate parts (``True``), for f as a whole (``False``), or for what the
    problem gives; ``first`` says of f as a whole whether q' = f(p) is evaluated before the rest.

    Raises
    ------
    UsageError
        When separate parts are requested and there are none.
    """
    d = problem.dimension
    if split and not problem.separable:
        raise UsageError(f"{problem.name} is not separable; it gives no `dq` and `dp`")
    halved = problem.separable if split is None else split
    if halved:
        m = d // 2
        force = problem.force if problem.force is not None else problem.dp
        parts: tuple[Part, ...] = (
            _part("velocity", 0, m, m, d, problem.dq, plain=problem.second_order),
            _part("force", m, d, 0, m, force),
        )
    elif first:
        m, whole, start = d // 2, problem.f, 0
        if isinstance(whole, Formula):
            whole, start = taken(whole, whole.outputs[m:]), m
        parts = (
            _part("velocity", 0, m, m, d, problem.velocity, plain=problem.second_order),
            _part("full", start, d, 0, d, whole),
        )
    else:
        parts = (_part("full", 0, d, 0, d, problem.f),)
    parts = tuple(_straightened(part, len(problem.params)) for part in parts)
    jacobian: Any = problem.jacobian
    known = jacobian.formula if isinstance(jacobian, Jacobian) else jacobian
    formulas = [*(part.formula for part in parts), known if isinstance(known, Formula) else None]
    parameters = {k: float(v) for f in formulas if f for k, v in f.parameters.items()}
    values = [*parameters.values(), *problem.params]
    loop = isinstance(jacobian, Loops)
    body, name = (_source(jacobian.body), jacobian.body.__name__) if loop else ("", "")
    return Shape(
        d, halved, parts, known if isinstance(known, Formula) else None, tuple(parameters),
        np.array(values, dtype=float), body, name,
    )  # fmt: skip


def _straightened(part: Part, params: int) -> Part:
    """Return a part with its loop body unrolled, where that is short."""
    if not part.body or part.source_stop > _STRAIGHT_SIZE:
        return part
    sizes = part.source_stop - part.source, params, part.stop - part.start
    return replace(part, straight=unrolled(part.body, sizes, _STRAIGHT_UP_TO))


def banded(shape: Shape) -> Shape:
    """Return the shape with the band of its Newton matrices, where there is one.

    Positions of a separable problem with q' = p and a force of few neighbours, or all components
    of one whose right-hand side has few.
    """
    if shape.halved and not shape.parts[0].identity:
        return shape  # K J_f has the structure of neither
    part = shape.counted
    size, count = part.source_stop - part.source, part.stop - part.start
    if part.formula is not None:
        structure = formula_structure(part.formula)
    elif part.body:
        params = shape.values[len(shape.parameters) :].tolist()
        structure = loop_structure(part.body, part.body_name, size, count, params, timed=part.timed)
    else:
        return shape
    band = None if structure is None else band_of(structure)
    return shape if band is None else replace(shape, band=band)


def _part(
    role: str, start: int, stop: int, source: int, source_stop: int, function: Any, *,
    plain: bool = False,
) -> Part:  # fmt: skip
    place = (role, start, stop, source, source_stop)
    if isinstance(function, Formula):
        identity = role == "velocity" and function.outputs == tuple(
            f"p[{i}]" for i in range(len(function.outputs))
        )
        return Part(*place, formula=function, identity=identity)
    if isinstance(function, Loops):
        text = _source(function.body)
        if text:
            return Part(*place, body=text, body_name=function.body.__name__)
        return Part(*place, function=function)
    if plain and role == "velocity":
        return Part(*place, identity=True)
    if isinstance(function, PhaseSpace) and function.dq is None and isinstance(function.dp, Loops):
        text = _source(function.dp.body)
        if text:
            return Part(*place, body=_joined(text, function.dp.body.__name__), body_name="f_into")
    return Part(*place, function=function)


def _joined(force: str, name: str) -> str:
    """Write f_into(t, y, params, out) around a force's body, as PhaseSpace.compiled does."""
    whole = f"""
        def f_into(t, y, params, out):
            half = len(y) // 2
            for i in range(half):
                out[i] = y[half + i]
            {name}(y[:half], params, out[half:])
    """
    return force + "\n\n@compiled" + textwrap.dedent(whole).rstrip()


def _source(body: Callable[..., Any]) -> str:
    """Return source text of a top-level function without annotations and docstring, or ``""``."""
    try:
        # a body written by .problems.sums carries its source
        text = getattr(body, "source", None) or inspect.getsource(body)
        tree = ast.parse(textwrap.dedent(text))
    except (OSError, TypeError, SyntaxError):
        return ""
    function = tree.body[0]
    if not isinstance(function, ast.FunctionDef) or function.decorator_list:
        return ""
    function.returns = None
    for argument in function.args.args:
        argument.annotation = None
    if ast.get_docstring(function) is not None:
        function.body = function.body[1:]
    return ast.unparse(function)


class _Inline(ast.NodeTransformer):
    """Rewrites one expression: components, names of common subexpressions, powers."""

    def __init__(self, component: Callable[[int], str], names: dict[str, str], prefix: str) -> None:
        self.component, self.names, self.prefix = component, names, prefix
        self.hoisted: list[tuple[str, str]] = []
        self.count = 0

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        ((_, index),) = subscripts(node)
        return ast.parse(self.component(index), mode="eval").body

    def visit_Name(self, node: ast.Name) -> ast.Name:
        return ast.Name(self.names.get(node.id, node.id), ast.Load())

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        twice = _twice(node.right) if isinstance(node.op, ast.Pow) else None
        if twice is None or twice in (0, 2):
            return node
        n, half = divmod(abs(twice), 2)
        base = node.left
        if not isinstance(base, ast.Name):
            name = f"{self.prefix}power_{self.count}"
            self.count += 1
            self.hoisted.append((name, ast.unparse(base)))
            base = ast.Name(name, ast.Load())
        factors: list[ast.expr] = [base] * n
        if half:  # x**1.5 is x*sqrt(x), to an ulp and a half
            factors.append(ast.Call(ast.Name("sqrt", ast.Load()), [base], []))
        product = factors[0]
        for factor in factors[1:]:
            product = ast.BinOp(product, ast.Mult(), factor)
        return product if twice > 0 else ast.BinOp(ast.Constant(1), ast.Div(), product)


def _twice(exponent: ast.expr) -> int | None:
    """Return twice a written exponent, where that is whole and small; else ``None``."""
    sign = 1
    while isinstance(exponent, ast.UnaryOp) and isinstance(exponent.op, ast.USub):
        sign, exponent = -sign, exponent.operand
    if isinstance(exponent, ast.BinOp) and isinstance(exponent.op, ast.Div):
        above, below = _twice(exponent.left), _twice(exponent.right)
        if above is None or not below or 2 * above % below:
            return None
        twice: float = 2 * above // below
    elif isinstance(exponent, ast.Constant) and isinstance(exponent.value, int | float):
        twice = 2 * exponent.value
    else:
        return None
    return sign * int(twice) if twice == int(twice) and abs(twice) <= 2 * _EXPAND_UP_TO else None


def inlined(
    formula: Formula, component: Callable[[int], str], names: dict[str, str], prefix: str
) -> tuple[list[str], list[str]]:
    """Return assignments of the common subexpressions and the outputs, as kernel source.

    ``component`` names component i of the vector argument, ``names`` the parameters, ``t`` and
    ``pi`` in the kernel; ``prefix`` comes before the names of common subexpressions.
    """
    rewrite = _Inline(component, dict(names), prefix)
    lines: list[str] = []

    def text(tree: ast.expr) -> str:
        fresh = ast.parse(ast.unparse(tree), mode="eval").body
        result = ast.unparse(rewrite.visit(fresh))
        lines.extend(f"{name} = {x}" for name, x in rewrite.hoisted)
        rewrite.hoisted.clear()
        return result

    common, outputs = formula.trees
    for name, tree in common:
        value = text(tree)
        rewrite.names[name] = prefix + name
        lines.append(f"{prefix}{name} = {value}")
    return lines, [text(tree) for tree in outputs]


def jacobian_block(shape: Shape, rows: range, columns: range) -> Formula:
    """Return a block of the Jacobian as a formula, with only the subexpressions it needs."""
    assert shape.jacobian is not None
    d = shape.dimension
    entries = tuple(shape.jacobian.outputs[i * d + j] for i in rows for j in columns)
    return replace(
        shape.jacobian,
        outputs=entries,
        common=_needed(shape.jacobian.common, entries),
        shape=(len(rows), len(columns)),
    )


def _needed(
    common: Sequence[tuple[str, str]], outputs: Sequence[str]
) -> tuple[tuple[str, str], ...]:
    """Return the common subexpressions that the outputs need, in order."""

    def names(text: str) -> set[str]:
        return {n.id for n in ast.walk(ast.parse(text, mode="eval")) if isinstance(n, ast.Name)}

    wanted = set().union(*(names(text) for text in outputs))
    kept = []
    for name, text in reversed(common):
        if name in wanted:
            wanted |= names(text)
            kept.append((name, text))
    return tuple(kept[::-1])


def parameter_names(shape: Shape) -> dict[str, str]:
    """Return names of parameters inside a kernel, and of t and pi."""
    return {name: f"par_{name}" for name in shape.parameters} | {"t": "time", "pi": repr(np.pi)}


def used_parameters(shape: Shape) -> Sequence[int]:
    """Return indices of the parameters that some expression of the right-hand side uses."""
    used: set[str] = set()
    if not shape.parameters:
        return []
    formulas = [part.formula for part in shape.parts] + [shape.jacobian]
    for formula in formulas:
        if formula is not None:
            common, outputs = formula.trees
            for tree in (*(x for _, x in common), *outputs):
                used |= {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}
    return [i for i, name in enumerate(shape.parameters) if name in used]
