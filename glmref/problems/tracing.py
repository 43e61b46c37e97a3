"""A user's Python function as expressions: it is called once on symbols, and says what it computes.

A function that does arithmetic on t and the components of y, calls sin, sqrt and their like, and
decides nothing by their values does the same operations at every state. Called on symbols it
records them, in its own order, and they are a :class:`.formula.Formula`: compiled in a tenth of the
time, kept on disk, and differentiated. Loops are unrolled up to :data:`MOST_OPERATIONS`.

A function is left alone, and compiled as Python code or interpreted, where symbols cannot show all
that it does: where it branches on a value, changes something outside, imports, catches exceptions,
or reads anything but numbers, arrays, tuples, and functions for which the same holds. The formula
is compared with the function at three states before it is believed.
"""

from __future__ import annotations

import builtins
import dis
import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from .canonical import shared
from .formula import Formula

#: Operations of a function that is unrolled; larger ones stay loops.
MOST_OPERATIONS = 600
_SAME = 1e-10  # relative difference of the formula from the function
_LARGEST = 2**53
_DEEPEST = 20  # functions that call each other

#: What changes something outside a function, or hides what happens in it.
_FORBIDDEN = {
    *("STORE_GLOBAL", "DELETE_GLOBAL", "STORE_ATTR", "DELETE_ATTR", "IMPORT_NAME", "IMPORT_FROM"),
    *("SETUP_FINALLY", "SETUP_WITH", "BEFORE_WITH", "DELETE_DEREF", "PRINT_EXPR"),
}
_BUILTINS = ("range", "len", "sum", "zip", "enumerate", "tuple", "list", "reversed", "abs")
_FUNCTIONS = {"sin": "sin", "cos": "cos", "tan": "tan", "exp": "exp", "log": "log", "sqrt": "sqrt",
              "arctan2": "atan2", "atan2": "atan2"}  # fmt: skip
#: Functions of numpy that work on arrays of symbols as they are.
_ARRAYS = {
    *("concatenate", "stack", "hstack", "vstack", "dot", "sum", "arange", "square", "outer"),
    *("matmul", "roll", "diff", "linspace", "eye", "add", "subtract", "multiply", "divide"),
    *("negative", "power", "newaxis", "pi", "e", "cross", "reshape", "transpose", "ravel"),
}


class Untraceable(BaseException):
    """The function does what symbols cannot show; no ``except Exception`` of its own hides it."""


Recorded = tuple[tuple[tuple[str, str], ...], tuple[str, ...]]


def recorded(function: Any, variables: tuple[str, ...], size: int) -> Recorded | None:
    """Return the operations of a Python function on symbols, or ``None`` where it hides some.

    The function is ``f(t, y)``, or ``dq(p)``, ``dp(q)``; ``variables`` name its arguments in the
    formula, the last of which is the vector of length ``size``, as the result is. Returns the named
    operations in order, and what is returned.
    """
    trace = _Trace()
    *scalars, vector = variables
    state = np.empty(size, dtype=object)
    state[:] = [_Symbol(trace, f"{vector}[{i}]") for i in range(size)]
    try:
        copy = _copied(function, trace, {})
        found = copy(*(_Symbol(trace, name) for name in scalars), state)
        entries = list(found) if isinstance(found, list | tuple | np.ndarray) else []
        outputs = tuple(trace.text(x) for x in entries)
    except (Untraceable, RecursionError):
        return None
    except (Exception, SystemExit):  # whatever it raises on symbols, it may not raise on numbers
        return None
    return (tuple(trace.lines), outputs) if len(outputs) == size else None


def traced(
    function: Any, variables: tuple[str, ...], points: Sequence[tuple[Any, ...]],
    operations: Recorded | None = None,
) -> Formula | None:  # fmt: skip
    """Return the formula of a Python function, or ``None`` where it cannot be had.

    At ``points`` formula and function are compared; ``operations`` are what :func:`recorded` found.
    """
    found = operations or recorded(function, variables, len(points[0][-1]))
    if found is None:
        return None
    common, outputs = found
    try:
        # names of their own: f has the common subexpressions of both halves
        letter = "v" if variables[-1] == "p" else "e"
        formula = shared(Formula(outputs, common, variables), letter)
        return formula if all(_agree(formula, function, point) for point in points) else None
    except (Exception, SystemExit):  # a function that fails is left to tell so itself
        return None


def _agree(formula: Formula, function: Callable[..., Any], point: tuple[Any, ...]) -> bool:
    """Return whether both have the same value at a point, or neither has one."""
    *times, state = point
    with np.errstate(all="ignore"):
        ours = np.asarray(formula(*times, np.array(state)), dtype=float)
        try:
            theirs = np.array(function(*times, np.array(state)), dtype=float)
        except (ArithmeticError, ValueError):
            return not np.isfinite(ours).all()
    if theirs.shape != ours.shape:
        return False
    scale = np.abs(theirs[np.isfinite(theirs)]).max(initial=0.0)
    return bool(np.allclose(ours, theirs, rtol=_SAME, atol=_SAME * scale, equal_nan=True))


class _Trace:
    """What has been recorded: one operation a line, equal ones once."""

    def __init__(self) -> None:
        self.lines: list[tuple[str, str]] = []
        self.known: dict[str, str] = {}

    def operation(self, text: str) -> _Symbol:
        """Record an operation on names and numbers."""
        if text not in self.known:
            if len(self.lines) >= MOST_OPERATIONS:
                raise Untraceable
            self.known[text] = f"o{len(self.lines)}_"
            self.lines.append((self.known[text], text))
        return _Symbol(self, self.known[text])

    def text(self, x: Any) -> str:
        """Return an operand as it stands in a line."""
        if isinstance(x, _Symbol):
            return x.name
        if isinstance(x, np.generic):
            x = x.item()
        if isinstance(x, Fraction):
            x = x.numerator if x.denominator == 1 else float(x)
        if isinstance(x, bool) or not isinstance(x, int | float) or not math.isfinite(x):
            raise Untraceable
        if isinstance(x, int) and abs(x) > _LARGEST:
            raise Untraceable
        return f"({x!r})" if x < 0 else repr(x)


def _operators(sign: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the methods of an operator: with the symbol on the left, and on the right."""
    return (
        lambda self, x: self._binary(self, sign, x),
        lambda self, x: self._binary(x, sign, self),
    )


def _function(name: str) -> Callable[[Any], Any]:
    """Return the method that numpy calls for a function of an array of objects."""
    return lambda self: self._call(name)


class _Symbol:
    """A number that is not known yet."""

    __slots__ = ("name", "trace")

    def __init__(self, trace: _Trace, name: str) -> None:
        self.trace, self.name = trace, name

    def _binary(self, left: Any, sign: str, right: Any) -> Any:
        if isinstance(left, np.ndarray) or isinstance(right, np.ndarray):
            return NotImplemented
        text = self.trace.text
        return self.trace.operation(f"{text(left)} {sign} {text(right)}")

    def _call(self, name: str, *others: Any) -> _Symbol:
        given = ", ".join(self.trace.text(x) for x in (self, *others))
        return self.trace.operation(f"{name}({given})")

    def __add__(self, x: Any) -> Any:
        return self._binary(self, "+", x)

    def __radd__(self, x: Any) -> Any:
        # sum() begins with a whole zero, which changes nothing
        return self if isinstance(x, int) and x == 0 else self._binary(x, "+", self)

    __sub__, __rsub__ = _operators("-")
    __mul__, __rmul__ = _operators("*")
    __truediv__, __rtruediv__ = _operators("/")
    __pow__, __rpow__ = _operators("**")

    def __neg__(self) -> _Symbol:
        return self.trace.operation(f"-{self.name}")

    def __pos__(self) -> _Symbol:
        return self

    def copy(self) -> _Symbol:
        return self

    sin, cos, tan = _function("sin"), _function("cos"), _function("tan")
    exp, log, sqrt = _function("exp"), _function("log"), _function("sqrt")

    def arctan2(self, x: Any) -> _Symbol:
        return self._call("atan2", x)

    def _no(self, *_: Any) -> Any:
        """Refuse what depends on the value."""
        raise Untraceable

    __bool__ = __float__ = __int__ = __index__ = __complex__ = __abs__ = __hash__ = _no
    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = __round__ = __mod__ = _no  # type: ignore[assignment]
    __floordiv__ = __rfloordiv__ = __rmod__ = __divmod__ = __iter__ = __len__ = _no


# --- what the function reads ----------------------------------------------------------------------


def _references(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield global names and closure variables that a function reads, with their values.

    Raises
    ------
    KeyError
        For a name without a value.
    """
    for code in codes(function.__code__):
        for name in code.co_names:
            if name in function.__globals__:
                yield name, function.__globals__[name]
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        try:
            yield name, cell.cell_contents
        except ValueError:
            raise KeyError(name) from None


def codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code and all that is defined in it, in the order of its text."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from codes(constant)


#: Modules whose values do not change; what a function reads from any other is not seen.
_MODULES_KNOWN = frozenset({"cmath", "math", "numba", "numpy"})


def fingerprint(function: Any) -> Any:
    """Return what a function is and reads, hashable; ``None`` where that cannot be said.

    Two functions of one fingerprint compile to the same code: their byte code, defaults, globals
    and closure values are equal, and the options of a function that numba has compiled. It is the
    same in every process.
    """
    try:
        return _mark(function, 0)
    except (Untraceable, KeyError, TypeError, RecursionError):
        return None


def _mark(value: Any, depth: int) -> Any:
    if depth > _DEEPEST:
        raise Untraceable
    if isinstance(value, bool | int | float | complex | str | bytes | np.generic | None):
        return type(value).__name__, repr(value)
    if isinstance(value, tuple):
        return tuple(_mark(x, depth + 1) for x in value)
    if isinstance(value, np.ndarray) and value.dtype.kind in "iufcb":
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, ModuleType):
        if value.__name__.partition(".")[0] not in _MODULES_KNOWN:
            raise Untraceable  # what is read from it is seen nowhere
        return "module", value.__name__
    if isinstance(value, FunctionType):
        reads = tuple((name, _mark(x, depth + 1)) for name, x in _references(value))
        return _code_mark(value.__code__), _mark(value.__defaults__ or (), depth + 1), reads
    module, name = getattr(value, "__module__", None), getattr(value, "__name__", None)
    if isinstance(value, BuiltinFunctionType | np.ufunc) and name:
        return "built in", module, name
    inner = getattr(value, "py_func", None)
    if inner is not None:
        options = getattr(value, "targetoptions", {})
        return "compiled", repr(sorted(options.items())), _mark(inner, depth + 1)
    raise Untraceable


def _code_mark(code: CodeType) -> Any:
    """Return what a code object computes, without file names: equal in every process."""
    constants = tuple(
        _code_mark(x) if isinstance(x, CodeType) else (type(x).__name__, repr(x))
        for x in code.co_consts
        if not isinstance(x, frozenset)
    )
    sets = tuple(sorted(map(repr, x)) for x in code.co_consts if isinstance(x, frozenset))
    return (
        *(code.co_name, code.co_code, code.co_flags, code.co_argcount, code.co_kwonlyargcount),
        *(code.co_posonlyargcount, code.co_names, code.co_varnames, code.co_freevars),
        *(code.co_cellvars, constants, repr(sets), getattr(code, "co_exceptiontable", b"")),
    )


def _copied(function: Any, trace: _Trace, known: dict[int, Any]) -> FunctionType:
    """Return the function with everything that it reads made fit for symbols."""
    if not isinstance(function, FunctionType):
        raise Untraceable
    if id(function) in known:
        return known[id(function)]
    code = function.__code__
    if code.co_flags & (0x04 | 0x08 | 0x20 | 0x80 | 0x100 | 0x200) or function.__kwdefaults__:
        raise Untraceable  # *args, **kwargs, generators and coroutines
    for one in codes(code):
        if getattr(one, "co_exceptiontable", b"") and not one.co_flags & 0x20:
            raise Untraceable
        for step in dis.get_instructions(one):
            nonlocal_ = step.opname == "STORE_DEREF" and step.argval in one.co_freevars
            if step.opname in _FORBIDDEN or nonlocal_:
                raise Untraceable
    names: dict[str, Any] = {"__builtins__": {k: getattr(builtins, k) for k in _BUILTINS}}
    empty = tuple(CellType() for _ in code.co_freevars) or None
    copy = FunctionType(code, names, function.__name__, function.__defaults__, empty)
    known[id(function)] = copy
    cells = dict(zip(code.co_freevars, copy.__closure__ or (), strict=True))
    for name, value in _references(function):
        fit = _fit(value, trace, known)
        if name in cells:
            cells[name].cell_contents = fit
        else:
            names[name] = fit
    for value in function.__defaults__ or ():
        _fit(value, trace, known)
    return copy


def _fit(value: Any, trace: _Trace, known: dict[int, Any]) -> Any:
    """Return a value that the function reads, or what stands for it."""
    if isinstance(value, int | float | np.number | Fraction):
        return value
    if isinstance(value, tuple):
        return tuple(_fit(x, trace, known) for x in value)
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
        view = value.view()
        view.setflags(write=False)
        return view
    if isinstance(value, ModuleType) and value.__name__ in ("numpy", "math"):
        return _Module(value)
    if isinstance(value, ModuleType) and value.__name__ == "numpy.linalg":
        return _Linalg
    name = getattr(value, "__name__", "")
    for module in (np, math):
        if name and getattr(module, name, None) is value:
            return getattr(_Module(module), name)
    return _copied(value, trace, known)


class _Module:
    """Stands for numpy or math: their functions take symbols, arrays hold them."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        numpy = self._module is np
        if name in _FUNCTIONS and hasattr(self._module, name):
            return _elementary(_FUNCTIONS[name], getattr(self._module, name))
        if name in ("pi", "e", "tau") and hasattr(self._module, name):
            return getattr(self._module, name)
        if not numpy:
            raise Untraceable
        if name in _MAKERS:
            return _MAKERS[name]
        if name == "linalg":
            return _Linalg
        if name in _ARRAYS:
            return getattr(np, name)
        raise Untraceable


def _elementary(name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    def called(*given: Any) -> Any:
        if any(isinstance(x, np.ndarray) for x in given):
            return getattr(np, {"atan2": "arctan2"}.get(name, name))(*given)
        symbol = next((x for x in given if isinstance(x, _Symbol)), None)
        if symbol is None:
            return plain(*given)
        trace = symbol.trace
        return trace.operation(f"{name}({', '.join(trace.text(x) for x in given)})")

    return called


def _filled(value: Any) -> Callable[..., np.ndarray]:
    def make(shape: Any, *_: Any, **__: Any) -> np.ndarray:
        like = shape.shape if isinstance(shape, np.ndarray) else shape
        return np.full(like, value, dtype=object)

    return make


def _array(given: Any, dtype: Any = None, **_: Any) -> np.ndarray:
    if dtype not in (None, float, np.float64, object):
        raise Untraceable
    found = np.array(given, dtype=object)
    return found


class _Linalg:
    """Stands for numpy.linalg."""

    @staticmethod
    def norm(x: Any) -> Any:
        """Return the Euclidean norm of a vector."""
        if np.ndim(x) != 1:
            raise Untraceable
        return np.dot(x, x).sqrt()


_MAKERS: dict[str, Callable[..., Any]] = {
    "array": _array, "asarray": _array, "float64": lambda x: x,
    "zeros": _filled(0.0), "empty": _filled(0.0), "ones": _filled(1.0),
    "zeros_like": _filled(0.0), "empty_like": _filled(0.0), "ones_like": _filled(1.0),
    "full": lambda shape, value, *_, **__: _filled(value)(shape), "copy": lambda x: x.copy(),
}  # fmt: skip
