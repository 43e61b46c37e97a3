"""The record every engine and experiment reads: an initial value problem, and what is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType, SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from ..errors import UsageError
from ..system.arguments import flag, number, shown
from ..system.shown import Shown
from .canonical import taken, timed
from .derivative import Jacobian
from .formula import Formula, Number, exact_number, functions, to_number
from .from_expressions import MOST_LABELS, equation_entries, hamiltonian_entries
from .loops import Loops, QuadraticForm, join
from .precision import on_context
from .reference import Reference, references_of
from .user_functions import UserFunction, plain, raised


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Problem(Shown):
    """An initial value problem y' = f(t, y), y(t0) = y0; only ``f`` and ``y0`` are required.

    Every function may be given as a Python callable or as expressions (a string, or a tuple with
    one string per component, in the names below and those of ``parameters``). Expressions work at
    every precision, are differentiated where a Jacobian is asked, and compile into kernels;
    callables work wherever their own code does. A state of Hamiltonian or second-order form is
    y = (q, p), or (q, v), with dim q = dim p = d/2.

    Attributes
    ----------
    f : Any
        ``f(t, y)`` -> (d,). May be left out where ``dp`` or ``force`` is given.
    y0 : Any
        Initial value, (d,): numbers, expressions in the parameters, or a function that gets the
        namespace sin, sqrt, pi ... and returns the numbers.
    name, source : str
        What it is and where it comes from.
    parameters : Mapping[str, Number]
        Name -> exact number (int, Fraction, or a float taken at its exact value).
    t_span : tuple[float, float]
        (t0, t_end) of the problem's usual test.
    jacobian : Any
        ``jacobian(t, y)`` -> (d, d); derived from f where f is expressions.
    dq, dp : Any
        The separable parts, q' = dq(p) and p' = dp(q), in ``p[0]``... and ``q[0]``... Of q' =
        f(p), p' = g(t, q, p) give ``f`` as a whole and ``dq``, which expressions need not.
    force : Any
        g of q'' = g(q), in ``q[0]``...; then dq(p) = p and dp = force.
    terms : Sequence[Any]
        f_1, f_2, .. of ``y' = f_1(t, y) + f_2(t, y) + ..``, for additive (IMEX) methods; f is their
        sum where it is not given.
    hamiltonian : Any
        ``hamiltonian(y)``, conserved; in ``y[0]``...
    energy : Any
        ``energy(y)``, of which errors of the energy are, where it is not ``hamiltonian``: in a
        transformed time H is, and not K = r (H + p_t), which hides its errors where r is small.
    quadratic : Mapping[str, Any]
        Name -> symmetric C with y^T C y conserved, as a :class:`.loops.QuadraticForm`.
    invariants : Mapping[str, Any]
        Name -> ``I(y)``, other conserved functions.
    observables : Mapping[str, Any]
        Name -> ``O(y)``, functions worth watching that are not conserved exactly.
    canonical : bool
        Whether f = J grad H in the coordinates y = (q, p).
    names : Sequence[str]
        (d,) what the components are called; by default q and p of separable and of Hamiltonian
        systems, y of others, see :attr:`labels`.
    bodies : int
        How many bodies' positions q lists one after another, each with as many components.
    clocked : Mapping[str, Any]
        Of q' = f(p, t), p' = k(q, t) the parts ``dq`` and ``dp``, or ``force``, whose last
        component is time; :meth:`from_hamiltonian` sets it, and :attr:`extended` is made of it.
    exact : Any
        ``exact(t, y0)`` -> (d,), in closed form: the solution at t that starts at t_span[0].
    scales : Mapping[str, float]
        Typical sizes: ``"time"``, ``"length"``, and ``"period"`` where periodic.
    context : Any
        The mpmath context of :meth:`on`, ``None`` in double precision.
    initial : Any
        y0 as it was given, from which :meth:`on` computes it; set here, whatever is passed.

    Raises
    ------
    UsageError
        One sentence on the first entry that does not fit.
    """

    f: Any = None
    y0: Any
    name: str = "user problem"
    source: str = ""
    parameters: Mapping[str, Number] = field(default_factory=dict)
    t_span: tuple[float, float] = (0.0, 10.0)
    jacobian: Any = None
    dq: Any = None
    dp: Any = None
    force: Any = None
    terms: Sequence[Any] = ()
    hamiltonian: Any = None
    energy: Any = None
    quadratic: Mapping[str, Any] = field(default_factory=dict)
    invariants: Mapping[str, Any] = field(default_factory=dict)
    observables: Mapping[str, Any] = field(default_factory=dict)
    canonical: bool = False
    names: Sequence[str] = ()
    bodies: int = 1
    clocked: Mapping[str, Any] = field(default_factory=dict)
    exact: Any = None
    scales: Mapping[str, float] = field(default_factory=dict)
    context: Any = None
    initial: Any = None

    _VECTORS: ClassVar = {"f": ("t", "y"), "dq": ("p",), "dp": ("q",), "force": ("q",)}

    def __post_init__(self) -> None:
        if self.context is not None:
            if self.initial is None:
                raise UsageError("`context` is set by `Problem.on`; leave it out and call that")
            return
        for key in ("name", "source"):
            if not isinstance(getattr(self, key), str):
                raise UsageError(f"`{key}` must be a text, got {shown(getattr(self, key))}")
        self._set("canonical", flag("canonical", self.canonical))
        for key in ("parameters", "quadratic", "invariants", "observables", "scales"):
            if not isinstance(getattr(self, key), Mapping):
                raise UsageError(f"`{key}` must be a mapping, got {shown(getattr(self, key))}")
        if isinstance(self.terms, str) or not isinstance(self.terms, Sequence):
            raise UsageError(f"`terms` must be a sequence, got {shown(self.terms)}")
        values = {k: exact_number(v, k) for k, v in self.parameters.items()}
        self._set("parameters", MappingProxyType(values))
        self._set("initial", self.y0)
        self._set("y0", _initial_value(self.y0, values, None))
        for key, variables in self._VECTORS.items():
            self._set(key, self._function(key, getattr(self, key), variables))
        terms = [
            self._function(f"terms[{n}]", term, ("t", "y")) for n, term in enumerate(self.terms, 1)
        ]
        self._set("terms", tuple(terms))
        for key in ("jacobian", "exact"):
            if getattr(self, key) is not None:
                if not callable(getattr(self, key)):
                    raise UsageError(f"`{key}` must be a function, got {shown(getattr(self, key))}")
                self._set(key, self._function(key, getattr(self, key), ()))
        for key in ("hamiltonian", "energy"):
            self._set(key, self._scalar(key, getattr(self, key)))
        for key in ("invariants", "observables"):
            scalars = {k: self._scalar(k, v) for k, v in getattr(self, key).items()}
            self._set(key, MappingProxyType(scalars))
        d = self.dimension
        forms = {
            k: v if isinstance(v, QuadraticForm) else QuadraticForm.of(v, d)
            for k, v in self.quadratic.items()
        }
        self._set("quadratic", MappingProxyType(forms))
        scales = {k: number(f"scales[{shown(k)}]", v) for k, v in self.scales.items()}
        if not all(size > 0 for size in scales.values()):
            raise UsageError(f"`scales` must be positive, got {shown(scales)}")
        self._set("scales", MappingProxyType(scales))
        self._assemble()
        self._check()

    def _set(self, key: str, value: Any) -> None:
        object.__setattr__(self, key, value)

    def _function(self, key: str, value: Any, variables: tuple[str, ...]) -> Any:
        """Read a function-valued entry: a callable, or expressions."""
        if value is None:
            return None
        if callable(value):
            size = self.dimension // 2 if key in ("dq", "dp", "force") else self.dimension
            shape = (size, size) if key == "jacobian" else (size,)
            return _protected(value, key, size, shape)
        texts = (value,) if isinstance(value, str) else value
        if isinstance(texts, Sequence) and texts and all(isinstance(x, str) for x in texts):
            return Formula(tuple(texts), variables=variables, parameters=self.parameters)
        raise UsageError(
            f"`{key}` must be a function or a tuple of expressions, got {shown(value)}"
        )

    def _scalar(self, key: str, value: Any) -> Any:
        """Read a conserved function: a callable, or one expression."""
        if value is None:
            return None
        if callable(value):
            return _protected(value, key, self.dimension, ())
        if isinstance(value, str):
            return Formula((value,), variables=("y",), parameters=self.parameters, shape=())
        raise UsageError(f"`{key}` must be a function or one expression, got {shown(value)}")

    def _assemble(self) -> None:
        """Derive f, dq, dp and the Jacobian from the parts that define them."""
        half = self.dimension // 2
        if self.force is not None:
            if isinstance(self.force, Formula):
                names = tuple(f"p[{i}]" for i in range(half))
                self._set("dq", self.dq or Formula(names, variables=("p",)))
            self._set("dq", self.dq or _identity)
            self._set("dp", self.dp or self.force)
        if self.f is None and self.dp is not None and self.dq is not None:
            plain = self.force is not None and not isinstance(self.force, Formula)
            self._set("f", join(None if plain else self.dq, self.dp, half))
        if self.f is None and self.terms:
            self._set("f", _sum_of(self.terms, self.parameters))
        if self.jacobian is None and isinstance(self.f, Formula):
            self._set("jacobian", Jacobian(self.f, self.dimension))

    def _check(self) -> None:
        """Refuse entries that do not fit together, before any step is taken."""
        d = self.dimension
        if self.f is None:
            raise UsageError(
                "`f` is missing; give f, or dq and dp, or force, or terms, or let "
                "`Problem.from_hamiltonian` derive them from the text of H"
            )
        if d % 2 and (self.dq or self.dp or self.force):
            raise UsageError(f"y = (q, p) must have an even number of components, got {d}")
        sizes = {"f": d, "dq": d // 2, "dp": d // 2, "force": d // 2}
        functions = [(key, getattr(self, key), size) for key, size in sizes.items()]
        functions += [(f"terms[{n}]", term, d) for n, term in enumerate(self.terms, 1)]
        for key, function, size in functions:
            if isinstance(function, Formula) and len(function.outputs) != size:
                raise UsageError(f"`{key}` must have {size} entries, got {len(function.outputs)}")
        scalars = {
            "hamiltonian": self.hamiltonian,
            "energy": self.energy,
            **self.invariants,
            **self.observables,
        }
        functions += [(key, scalar, d) for key, scalar in scalars.items()]
        for key, function, size in functions:
            if not isinstance(function, Formula):
                continue
            beyond = [i for i in function.indices if not 0 <= i < size]
            if beyond:
                raise UsageError(f"`{key}` uses component {beyond[0]}, but there are {size}")
        if len(self.names) not in (0, d) or isinstance(self.names, str):
            raise UsageError(f"`names` must be {d} names, got {shown(self.names)}")
        n = self.bodies
        if not isinstance(n, int) or (n != 1 and (n < 1 or d % (2 * n) or self.dp is None)):
            raise UsageError(f"`bodies` must divide the components of q, got {shown(n)}")
        try:
            start, end = self.t_span
            for time in (start, end):
                number("t_span", time)
        except Exception:  # no pair, or whatever a class of the user raises
            raise UsageError(
                f"`t_span` must be two finite times, got {shown(self.t_span)}"
            ) from None

    @staticmethod
    def from_hamiltonian(H: str, y0: Any, **options: Any) -> Problem:
        """Return Hamilton's equations of H, see :func:`.from_expressions.hamiltonian_entries`.

        Parameters
        ----------
        H : str
            Such as ``"p**2/2 - cos(q)"``.
        y0 : mapping or sequence
            Initial value: ``{"q": "5/2", "p": 0}``.
        **options :
            ``parameters``, ``t_end``, ``invariants``, ``coordinates``, ``momenta``, ``name`` ...
        """
        return Problem(**hamiltonian_entries(H, y0, **options))

    @staticmethod
    def from_equations(f: Any, y0: Any, **options: Any) -> Problem:
        """Return y' = f from expressions in names, see :func:`.from_expressions.equation_entries`.

        Parameters
        ----------
        f : mapping or sequence
            Such as ``{"x": "v", "v": "-sin(x)"}``.
        y0 : mapping or sequence
            Initial value, by the same names.
        **options :
            ``parameters``, ``t_end``, ``invariants``, ``name`` ...
        """
        return Problem(**equation_entries(f, y0, **options))

    def __repr__(self) -> str:
        given = "".join(f", {key}={value}" for key, value in self.parameters.items())
        return f"<Problem {self.name}{given}, dimension {self.dimension}>"

    def slope_at(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return df/dy at one state (d,): by its formula, or by differences, (d, d)."""
        if self.jacobian is not None:
            return np.asarray(self.jacobian(t, y), dtype=float)
        base, columns = np.asarray(self.f(t, y), dtype=float), []
        sizes = 2.0**-26 * (np.abs(y) + 2.0**-10 * (np.abs(y).max() or 1.0))
        for k, size in enumerate(sizes):
            moved = y.copy()
            moved[k] += size
            slope = np.asarray(self.f(t, moved), dtype=float)
            columns.append((slope - base) / (moved[k] - y[k]))
        return np.stack(columns, axis=1)

    @property
    def dimension(self) -> int:
        """Number d of components."""
        return len(self.y0)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names (d,) of the components, none of large systems.

        Those given, else q and p, numbered where several, or y.
        """
        d, half = self.dimension, self.dimension // 2
        if self.names or d > MOST_LABELS:
            return tuple(self.names)
        if d % 2 or not (self.canonical or self.separable):
            return tuple(f"y[{k}]" for k in range(d))
        if half == 1:
            return ("q", "p")
        return tuple(f"{x}[{k}]" for x in "qp" for k in range(half))

    @property
    def conserved(self) -> Any:
        """The function of which errors of the energy are: ``energy``, else ``hamiltonian``."""
        return self.hamiltonian if self.energy is None else self.energy

    @property
    def separable(self) -> bool:
        """Whether q' = dq(p) and p' = dp(q)."""
        return self.dq is not None and self.dp is not None

    @cached_property
    def velocity(self) -> Any:
        """The function f(p) of q' = f(p), p' = g(t, q, p), or ``None`` where q' is not one.

        Where f is expressions it is found there; beside a callable f it is what ``dq`` gives.
        """
        m = self.dimension // 2
        if self.dq is not None or self.dimension % 2 or not isinstance(self.f, Formula):
            return self.dq
        first = taken(self.f, self.f.outputs[:m])
        if timed(first) or any(i < m for i in first.indices):
            return None
        return replace(first.substituted("y", "p", -m), variables=("p",))

    @property
    def semi_separable(self) -> bool:
        """Whether q' = f(p), p' = g(t, q, p), as for charges and in rotating frames in velocities.

        Separable problems are not called so.
        """
        return self.velocity is not None and not self.separable

    @property
    def second_order(self) -> bool:
        """Whether q'' = force(q)."""
        return self.force is not None

    @cached_property
    def extended(self) -> Problem | None:
        """The same motion as an autonomous separable problem in y = (q, s, p, sigma), or None.

        Both clocks s and sigma start at t0; s is time in p' = k(q, s), sigma in q' = f(p, sigma).
        Where q' = p, sigma is the constant velocity 1 of s.
        """
        if not self.clocked:
            return None
        half, begin = self.dimension // 2, self.t_span[0]
        start = self.y0.tolist() if callable(self.initial) else list(self.initial)
        last = 1 if "force" in self.clocked else begin
        found = Problem(
            **self.clocked,
            y0=(*start[:half], begin, *start[half:], last),
            name=self.name,
            source=self.source,
            parameters=self.parameters,
            t_span=self.t_span,
            scales=self.scales,
        )
        return found if self.context is None else found.on(self.context)

    @property
    def references(self) -> tuple[Reference, ...]:
        """Reference states shipped for this problem with these parameters, by time."""
        return references_of(self.name, self.parameters)

    def on(self, context: Any) -> Problem:
        """Return the problem in an mpmath context: y0, parameters and functions at its precision.

        States become numpy arrays of ``context.mpf`` (dtype object), so that ``y + h * f(t, y)``
        reads as in double precision. Use a context of your own, ``mpmath.MPContext()``: the global
        one is not thread safe.
        """
        if self.context is not None:
            raise UsageError("the problem is already in an mpmath context; use the double one")
        if not callable(getattr(context, "mpf", None)):
            raise UsageError(f"`context` must be mpmath.MPContext(), got {shown(context)}")
        functions = ("f", "jacobian", "dq", "dp", "force", "hamiltonian", "energy", "exact")
        return replace(
            self,
            **{key: on_context(getattr(self, key), context) for key in functions},
            terms=tuple(on_context(term, context) for term in self.terms),
            y0=_initial_value(self.initial, self.parameters, context),
            quadratic={k: v.on(context) for k, v in self.quadratic.items()},
            invariants={k: on_context(v, context) for k, v in self.invariants.items()},
            observables={k: on_context(v, context) for k, v in self.observables.items()},
            context=context,
        )

    def solution(self, t: Any) -> np.ndarray:
        """Return the exact solution at time t from this problem's y0.

        Raises
        ------
        UsageError
            When no closed form is known.
        """
        if self.exact is None:
            raise UsageError(f"{self.name} has no solution in closed form; see its references")
        return self.exact(t if self.context is not None else number("t", t), self.y0)

    # What a kernel generator reads. Expressions are Python source in t, y[i] (or q[i], p[i]), the
    # names of `parameters`, pi and the functions of formula.FUNCTIONS; bodies of loops are plain.

    @property
    def expressions(self) -> tuple[str, ...] | None:
        """Right-hand side f_0 ... f_{d-1} as expressions, or ``None``."""
        return self.f.outputs if isinstance(self.f, Formula) else None

    @property
    def params(self) -> np.ndarray:
        """The float64 array handed to the bodies as ``params``; empty where there are none."""
        for function in (self.f, self.force, self.dp, self.dq):
            if isinstance(function, Loops):
                return function.params
        return np.zeros(0)


def _protected(value: Any, name: str, size: int, shape: tuple[int, ...]) -> Any:
    """Wrap a callable of the user: it is called on copies, and its results are checked."""
    if value is _identity or hasattr(value, "on"):
        return value
    return UserFunction(plain(value), name, size, shape)


def _identity(p: Any) -> Any:
    """Return p, for q' = p."""
    return np.asarray(p)


def _initial_value(entries: Any, parameters: Mapping[str, Number], context: Any) -> np.ndarray:
    """Evaluate y0, whose entries are numbers or expressions, in doubles or in a context."""
    convert = float if context is None else context.mpf
    if callable(entries):
        start: Any = entries
        try:
            values = [convert(x) for x in start(SimpleNamespace(**functions(context)))]
        except Exception as error:
            raise raised("y0", error) from error
    else:
        given = entries.tolist() if isinstance(entries, np.ndarray) else entries
        if isinstance(given, str) or not isinstance(given, Sequence):
            raise UsageError(f"`y0` must be a vector of numbers, shape (d,), got {shown(entries)}")
        values = [_initial_entry(i, x, parameters, context) for i, x in enumerate(given)]
    if not values:
        raise UsageError("`y0` must have at least one component, got none")
    result = np.array(values, dtype=float if context is None else object)
    if context is None and not np.isfinite(result).all():
        raise UsageError(f"`y0` must be finite, got {shown(values)}")
    result.setflags(write=False)
    return result


def _initial_entry(i: int, x: Any, parameters: Mapping[str, Number], context: Any) -> Any:
    if isinstance(x, complex | np.complexfloating):
        raise UsageError(
            f"`y0[{i}]` is complex; states are real: make real and imaginary parts components"
        )
    if not isinstance(x, str):
        return to_number(exact_number(x, f"y0[{i}]"), context)
    return Formula((x,), parameters=parameters, shape=()).on(context)(0, ())


def _sum_of(terms: Sequence[Any], parameters: Mapping[str, Number]) -> Any:
    """Sum the terms to a right-hand side, as expressions where all of them are."""
    if all(isinstance(term, Formula) and not term.common for term in terms):
        rows = zip(*(term.outputs for term in terms), strict=True)
        texts = tuple(" + ".join(f"({x})" for x in row) for row in rows)
        return Formula(texts, variables=("t", "y"), parameters=parameters)

    def f(t: Any, y: Any) -> Any:
        total = np.asarray(terms[0](t, y))
        for term in terms[1:]:
            total = total + np.asarray(term(t, y))
        return total

    return f
