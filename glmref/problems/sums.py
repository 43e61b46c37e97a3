"""Hamiltonians of many particles as sums: the gradient is a loop, whatever the dimension.

``sum(p[i]**2/2 for i in range(n)) + sum((q[i+1] - q[i])**2/2 for i in range(n - 1))`` becomes

* a body that adds up H, and
* a body that goes through the same ranges and adds, to every component that a term names, the
  derivative of the term by it.

Both are plain Python in the sense of :class:`.loops.Loops`, a few lines for any number of bodies.
``n`` is the length of each list of y0; indices are whole-number arithmetic in the variables of the
sum, ``%`` included; a parameter that is a list is read as ``m[i]``. Bodies in a plane have lists
``qx``, ``qy``, ``px`` and ``py``; q then lists the bodies one after another, x before y.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import UsageError
from ..system.arguments import shown
from .canonical import shared
from .derivative import differentiated
from .formula import FUNCTIONS, Formula, Number
from .loops import Loops

_INDEX = (ast.Add, ast.Sub, ast.Mult, ast.Mod)
_HELP = "write sums as sum(p[i]**2/2 for i in range(n))"

Values = Mapping[str, Number | tuple[Number, ...]]


@dataclass(frozen=True)
class Layout:
    """Which lists q and p consist of, entry by entry in turn: ``("q",)``, or ``("qx", "qy")``."""

    q: tuple[str, ...] = ("q",)
    p: tuple[str, ...] = ("p",)

    @property
    def sites(self) -> str:
        """Length n of each list, as source in ``half``, the number of coordinates."""
        return "half" if len(self.q) == 1 else f"(half // {len(self.q)})"

    def half_of(self, vector: str) -> str:
        """Return ``"q"`` for a list of coordinates, ``"p"`` for one of momenta, else ``""``."""
        return "q" if vector in self.q else "p" if vector in self.p else ""

    def place(self, vector: str, index: str) -> str:
        """Return the index in q, or in p, of an entry of a list, as source."""
        k, each = (self.q if vector in self.q else self.p).index(vector), len(self.q)
        return index if each == 1 else f"{each} * ({index}) + {k}"


#: One list q and one list p.
FLAT = Layout()


@dataclass(frozen=True)
class _Term:
    """One term of H: an expression under some loops."""

    #: Variable and range of each loop, outermost first, as source.
    loops: tuple[tuple[str, str], ...]
    formula: Formula  #: The term, of shape () in ``y[0]``, ``y[1]``..., one for each of ``slots``.
    slots: tuple[tuple[str, str], ...]  #: Name of the list and the index as source.
    names: Mapping[str, str]  #: Other names of the formula -> source.


def hamiltonian_parts(H: str, half: int, values: Values, layout: Layout = FLAT) -> dict[str, Any]:
    """Return the equations of a Hamiltonian written with sums, as entries of a problem.

    H is a sum of expressions, and of ``sum(... for i in range(...))`` with a factor in front, in
    ``half`` coordinates, with numbers and lists of numbers as parameters. As :class:`.loops.Loops`
    there are ``hamiltonian`` and ``force``, or ``dq`` and ``dp``, or ``f``.

    Raises
    ------
    UsageError
        For what is no such sum, and for an index beyond the components.
    """
    reader = _Reader(half, values, layout)
    terms = reader.terms(H)
    for term in terms:
        _check_indices(term, half, values, layout)
    write = _Writer(reader.constants, layout)
    moving = [term for term in terms if term.slots]  # a constant is in H and not in its gradient
    kinetic = [term for term in moving if _halves(term, layout) == {"p"}]
    potential = [term for term in moving if _halves(term, layout) == {"q"}]
    bodies = {"hamiltonian": write.energy(terms)}
    if len(kinetic) + len(potential) < len(moving):
        bodies["f"] = write.gradient("f_into", "t, y", "len(y) // 2", moving)
    else:
        bodies["dp"] = write.gradient("force_into", "q", "len(q)", potential)
        if _is_unit(kinetic, layout):
            bodies["force"] = bodies.pop("dp")
        else:
            bodies["dq"] = write.gradient("velocity_into", "p", "len(p)", kinetic)
    constants = tuple(write.constants)
    shapes = {"hamiltonian": (), "f": (2 * half,)}
    return {k: Loops(b, shapes.get(k, (half,)), constants) for k, b in bodies.items()}


def _halves(term: _Term, layout: Layout) -> set[str]:
    """Return which of q and p a term names."""
    return {layout.half_of(vector) for vector, _ in term.slots}


def _is_unit(kinetic: list[_Term], layout: Layout) -> bool:
    """Return whether T is the sum of the squares of all momenta by 2, so that q' = p."""
    named: list[str] = []
    for term in kinetic:
        ((variable, bounds),) = term.loops if len(term.loops) == 1 else (("", ""),)
        slope = shared(differentiated(term.formula, len(term.slots)))
        itself = tuple(f"y[{k}]" for k in range(len(term.slots)))
        everywhere = bounds == f"0, {layout.sites}" and {i for _, i in term.slots} == {variable}
        if not everywhere or slope.outputs != itself:
            return False
        named += [vector for vector, _ in term.slots]
    return sorted(named) == sorted(layout.p)


class _Reader:
    """Reads the expression; what is not understood is refused in one sentence."""

    def __init__(self, half: int, values: Values, layout: Layout) -> None:
        self.half, self.layout = half, layout
        self.whole: dict[str, int] = {}
        self.places: dict[str, str] = {}
        self.lists: dict[str, tuple[int, int]] = {}
        numbers: list[Number] = []
        for name, value in values.items():
            if name == "n":
                raise UsageError("`parameters.n` is the length of each list already; rename it")
            if isinstance(value, tuple):
                self.lists[name] = (len(numbers), len(value))
                numbers += value
                continue
            if isinstance(value, int):
                self.whole[name] = value
            self.places[name] = f"params[{len(numbers)}]"
            numbers.append(value)
        self.places["n"] = layout.sites
        self.constants = numbers

    def terms(self, H: str) -> list[_Term]:
        """Read H into its terms."""
        try:
            tree = ast.parse(H, mode="eval").body
            found: list[_Term] = []
            self._split(tree, [], found)
        except (SyntaxError, ValueError, MemoryError, RecursionError):
            raise UsageError(f"`H` cannot be read: {shown(H)}") from None
        return found

    def _split(self, tree: ast.expr, factors: list[tuple[str, str]], found: list[_Term]) -> None:
        """Take a sum apart; ``factors`` stand around the term, innermost first."""
        if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.Add | ast.Sub):
            self._split(tree.left, factors, found)
            minus = [("-(", ")")] if isinstance(tree.op, ast.Sub) else []
            self._split(tree.right, minus + factors, found)
        elif isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
            self._split(tree.operand, [("-(", ")"), *factors], found)
        elif isinstance(tree, ast.BinOp) and _sums(tree.left) and not _sums(tree.right):
            if not isinstance(tree.op, ast.Mult | ast.Div):
                raise UsageError(f"`H` has {shown(ast.unparse(tree))}; {_HELP}")
            sign = "*" if isinstance(tree.op, ast.Mult) else "/"
            self._refuse_components(tree.right)
            self._split(tree.left, [("(", f"){sign}({ast.unparse(tree.right)})"), *factors], found)
        elif isinstance(tree, ast.BinOp) and _sums(tree.right) and not _sums(tree.left):
            if not isinstance(tree.op, ast.Mult):
                raise UsageError(f"`H` has {shown(ast.unparse(tree))}; {_HELP}")
            self._refuse_components(tree.left)
            self._split(tree.right, [(f"({ast.unparse(tree.left)})*(", ")"), *factors], found)
        else:
            self._term(tree, factors, found)

    def _refuse_components(self, tree: ast.expr) -> None:
        if any(isinstance(x, ast.Subscript) for x in ast.walk(tree)):
            raise UsageError(
                f"`H` multiplies a sum by {shown(ast.unparse(tree))}; a factor of a sum must not "
                f"name components"
            )

    def _term(self, tree: ast.expr, factors: list[tuple[str, str]], found: list[_Term]) -> None:
        loops: list[tuple[str, str]] = []
        if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == "sum":
            if (
                len(tree.args) != 1
                or tree.keywords
                or not isinstance(tree.args[0], ast.GeneratorExp)
            ):
                raise UsageError(f"`H` has {shown(ast.unparse(tree))}; {_HELP}")
            generator = tree.args[0]
            for one in generator.generators:
                loops.append(self._loop(one, [name for name, _ in loops]))
            tree = generator.elt
            if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.Add | ast.Sub):
                # the sum of a sum is two sums: kinetic and potential energy come apart
                left, right = (
                    ast.Call(
                        ast.Name("sum", ast.Load()), [ast.GeneratorExp(x, generator.generators)], []
                    )
                    for x in (tree.left, tree.right)
                )
                self._split(ast.BinOp(left, tree.op, right), factors, found)
                return
        if _sums(tree):
            raise UsageError(f"`H` has a sum inside {shown(ast.unparse(tree))}; {_HELP}")
        text = ast.unparse(tree)
        for before, after in factors:
            text = before + text + after
        variables = tuple(name for name, _ in loops)
        slots = _Slots(self, variables)
        written = ast.unparse(slots.visit(ast.parse(text, mode="eval")))
        names = dict.fromkeys(slots.names, 1)
        formula = Formula((written,), variables=("y",), parameters=names, shape=())
        _ = formula.indices  # refuses what is no arithmetic
        found.append(_Term(tuple(loops), formula, tuple(slots.slots), slots.names))

    def _loop(self, one: ast.comprehension, outer: list[str]) -> tuple[str, str]:
        call = one.iter
        if (
            not isinstance(one.target, ast.Name)
            or one.ifs
            or one.is_async
            or not isinstance(call, ast.Call)
            or ast.unparse(call.func) != "range"
            or not 1 <= len(call.args) <= 2
            or call.keywords
        ):
            raise UsageError(f"`H` loops over {shown(ast.unparse(call))}; {_HELP}")
        name = one.target.id
        if name in outer or name in self.places or name in self.lists or name in FUNCTIONS:
            raise UsageError(
                f"the variable {shown(name)} of a sum in `H` means something else already"
            )
        bounds = [self.index(x, outer) for x in call.args]
        return name, ", ".join(bounds if len(bounds) == 2 else ["0", *bounds])

    def index(self, tree: ast.expr, variables: list[str] | tuple[str, ...]) -> str:
        """Return whole-number arithmetic as source, with parameters by value."""
        if isinstance(tree, ast.Constant) and type(tree.value) is int:
            return str(tree.value)
        if isinstance(tree, ast.Name) and tree.id in variables:
            return tree.id
        if isinstance(tree, ast.Name) and tree.id == "n":
            return self.layout.sites
        if isinstance(tree, ast.Name) and tree.id in self.whole:
            return str(self.whole[tree.id])
        if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
            return f"(-{self.index(tree.operand, variables)})"
        if isinstance(tree, ast.BinOp) and isinstance(tree.op, _INDEX):
            left, right = self.index(tree.left, variables), self.index(tree.right, variables)
            if isinstance(tree.op, ast.Mod):
                # compiled code takes the remainder of the sign of the dividend
                return f"((({left}) % ({right}) + ({right})) % ({right}))"
            sign = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*"}[type(tree.op)]
            return ast.unparse(ast.parse(f"({left}) {sign} ({right})", mode="eval"))
        raise UsageError(
            f"`H` has the index {shown(ast.unparse(tree))}; an index is whole-number arithmetic in "
            f"the variables of its sums, n and whole parameters"
        )


def _sums(tree: ast.AST) -> bool:
    return any(
        isinstance(x, ast.Call) and isinstance(x.func, ast.Name) and x.func.id == "sum"
        for x in ast.walk(tree)
    )


class _Slots(ast.NodeTransformer):
    """Numbers the components that a term names, and renames what else it reads."""

    def __init__(self, reader: _Reader, variables: tuple[str, ...]) -> None:
        self.reader, self.variables = reader, variables
        self.slots: list[tuple[str, str]] = []
        #: What is read besides components: name in the formula -> source.
        self.names: dict[str, str] = {}

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        vector = node.value.id if isinstance(node.value, ast.Name) else ""
        index = self.reader.index(node.slice, self.variables)
        if self.reader.layout.half_of(vector):
            if (vector, index) not in self.slots:
                self.slots.append((vector, index))
            place = self.slots.index((vector, index))
            return ast.Subscript(ast.Name("y", ast.Load()), ast.Constant(place), ast.Load())
        if vector in self.reader.lists:
            return self._named(f"params[{self.reader.lists[vector][0]} + {index}]")
        raise UsageError(f"`H` has {shown(ast.unparse(node))}; components are {self._components}")

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in FUNCTIONS or node.id == "pi":
            return node
        if node.id in self.variables:
            return self._named(f"{node.id}")
        if node.id in self.reader.places:
            return self._named(self.reader.places[node.id])
        if self.reader.layout.half_of(node.id) or node.id in self.reader.lists:
            raise UsageError(f"`H` uses {shown(node.id)} without an index; {_HELP}")
        raise UsageError(
            f"`H` contains the unknown name {shown(node.id)}; give it in `parameters`, or write "
            f"components as {self._components}"
        )

    @property
    def _components(self) -> str:
        layout = self.reader.layout
        *first, last = (f"{name}[i]" for name in (*layout.q, *layout.p))
        return f"{', '.join(first)} and {last}"

    def _named(self, source: str) -> ast.expr:
        for name, known in self.names.items():
            if known == source:
                return ast.Name(name, ast.Load())
        name = f"a{len(self.names)}_"
        self.names[name] = source
        return ast.Name(name, ast.Load())


# --- checking and writing -------------------------------------------------------------------------


def _check_indices(term: _Term, half: int, values: Values, layout: Layout) -> None:
    """Refuse an index beyond the components, or beyond a list of parameters."""
    lists = {k: len(v) for k, v in values.items() if isinstance(v, tuple)}
    offsets, place = {}, 0
    for name, value in values.items():
        offsets[name] = place
        place += len(value) if isinstance(value, tuple) else 1
    checks = [(vector, index, 0, half // len(layout.q)) for vector, index in term.slots]
    for source in term.names.values():
        inside = source.removeprefix("params[").removesuffix("]")
        owner = next((k for k in lists if inside.startswith(f"{offsets[k]} + ")), None)
        if owner is not None:
            checks.append((owner, inside.partition(" + ")[2], 0, lists[owner]))
    for place_of in _places(term.loops, {"half": half}):
        for vector, index, least, size in checks:
            try:
                found = np.asarray(_value(index, place_of))
            except ZeroDivisionError:
                raise UsageError(f"`H` divides by zero in the index {index}") from None
            if found.size and (found.min() < least or found.max() >= size):
                bad = int(found.min() if found.min() < least else found.max())
                said = index.replace(layout.sites, "n")
                raise UsageError(
                    f"`H` uses {vector}[{said}] with the index {bad}; {vector} has {size} "
                    f"entries, from 0 on"
                )


def _value(index: str, places: Mapping[str, Any]) -> Any:
    """Return the value of an index expression, which :meth:`_Reader.index` has written."""
    return eval(index, {"__builtins__": {}}, dict(places))


def _places(
    loops: tuple[tuple[str, str], ...], known: Mapping[str, Any]
) -> Iterator[Mapping[str, Any]]:
    """Yield values of the variables of nested loops; those of the innermost as one array."""
    if not loops:
        yield known
        return
    (name, bounds), *rest = loops
    first, last = _value(f"({bounds})", known)
    if not rest:
        yield {**known, name: np.arange(first, last)}
        return
    for k in range(first, last):
        yield from _places(tuple(rest), {**known, name: k})


class _Writer:
    """Writes loop bodies; their numbers go into one list of constants."""

    def __init__(self, constants: list[Number], layout: Layout) -> None:
        self.constants, self.layout = list(constants), layout

    def energy(self, terms: list[_Term]) -> Callable[..., Any]:
        """Return the body that adds up H."""
        lines = ["def energy(y, params):", "    half = len(y) // 2", "    total = 0 * y[0]"]
        for term in terms:
            inner, (value,) = self._term(term, shared(term.formula), self._in_y)
            lines += _nested(term.loops, [*inner, f"total += {value}"])
        return _made([*lines, "    return total"], "energy")

    def gradient(
        self, name: str, arguments: str, half: str, terms: list[_Term]
    ) -> Callable[..., Any]:
        """Return the body that fills ``out`` with dH/dp, with -dH/dq, or with both."""
        vector = arguments[-1]
        source = (
            self._in_y if vector == "y" else lambda v, i: f"{vector}[{self.layout.place(v, i)}]"
        )
        lines = [f"def {name}({arguments}, params, out):", f"    half = {half}"]
        lines += [f"    for k_ in range(len({vector})):", f"        out[k_] = 0 * {vector}[k_]"]
        for term in terms:
            slope = shared(differentiated(term.formula, len(term.slots)))
            inner, values = self._term(term, slope, source)
            for (which, index), value in zip(term.slots, values, strict=True):
                if value == "0":
                    continue
                place, force = self.layout.place(which, index), which in self.layout.q
                if vector == "y" and force:
                    place = f"half + {place}"
                inner.append(f"out[{place}] {'-' if force else '+'}= {value}")
            lines += _nested(term.loops, inner)
        return _made(lines, name)

    def _in_y(self, vector: str, index: str) -> str:
        """Return the component of y = (q, p) as source."""
        place = self.layout.place(vector, index)
        return f"y[{place}]" if vector in self.layout.q else f"y[half + {place}]"

    def _term(
        self, term: _Term, formula: Formula, source: Callable[[str, str], str]
    ) -> tuple[list[str], list[str]]:
        """Return assignments and outputs of a formula of a term."""
        lines = [f"s{k}_ = {source(v, i)}" for k, (v, i) in enumerate(term.slots)]
        lines += [
            f"{name} = {text if '[' in text else '1.0 * ' + text}"
            for name, text in term.names.items()
        ]
        texts = _Texts(self.constants, lines)
        common, outputs = formula.trees
        for name, tree in common:
            lines.append(f"{name} = {texts.of(tree)}")
        found = [texts.of(tree) for tree in outputs]
        return lines, found


class _Texts(ast.NodeTransformer):
    """Writes an expression: slots by name, numbers as constants, small powers as products."""

    def __init__(self, constants: list[Number], lines: list[str]) -> None:
        self.constants, self.lines, self.count = constants, lines, 0

    def of(self, tree: ast.expr) -> str:
        return ast.unparse(self.visit(ast.parse(ast.unparse(tree), mode="eval").body))

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        assert isinstance(node.slice, ast.Constant)
        return ast.Name(f"s{node.slice.value}_", ast.Load())

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        # whole numbers in front of a product are exact as they are, quotients of them are not
        number = exact_decimal(node.value)
        if number not in self.constants:
            self.constants.append(number)
        return ast.parse(f"params[{self.constants.index(number)}]", mode="eval").body

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        node.left = self.visit(node.left)
        exponent = node.right
        if not (
            isinstance(node.op, ast.Pow)
            and isinstance(exponent, ast.Constant)
            and isinstance(exponent.value, int)
        ):
            node.right = self.visit(node.right)
            return node
        if not 2 <= exponent.value <= 8:
            return node
        base: ast.expr = node.left
        if not isinstance(base, ast.Name):
            self.lines.append(f"b{self.count}_ = {ast.unparse(base)}")
            base = ast.Name(f"b{self.count}_", ast.Load())
            self.count += 1
        product = base
        for _ in range(exponent.value - 1):
            product = ast.BinOp(product, ast.Mult(), base)
        return product


def exact_decimal(value: Any) -> Number:
    """Return a literal as the number it reads as: 0.1 is 1/10."""
    return value if isinstance(value, int) else Fraction(repr(value))


def _nested(loops: tuple[tuple[str, str], ...], inner: list[str]) -> list[str]:
    lines = []
    for depth, (name, bounds) in enumerate(loops):
        lines.append("    " * (depth + 1) + f"for {name} in range({bounds}):")
    return lines + ["    " * (len(loops) + 1) + line for line in inner]


def _made(lines: list[str], name: str) -> Callable[..., Any]:
    """Return the function of a source, which it carries along for the compiler."""
    text = "\n".join(lines) + "\n"
    namespace: dict[str, Any] = {"__name__": __name__}
    exec(compile(text, "<sums>", "exec"), namespace)
    body = namespace[name]
    body.source = text
    return body
