"""A user's own problem from H, or from expressions for f, with names for the components.

::

    H = "p**2/2 - cos(q)"                f = { x = "v", v = "-sin(x)" }
    y0 = { q = "5/2", p = 0 }            y0 = { x = 1, v = 0 }

Every ``q...`` of ``y0`` goes with the ``p...`` that ends alike (``q1`` and ``p1``, ``qx`` and
``px``), unless ``coordinates`` and ``momenta`` list them. Large systems write ``q[i]`` and ``p[i]``
in sums, see :mod:`.sums`; bodies in a plane ``qx[i]`` and ``qy[i]``. With ``n`` given, an entry of
y0 is a formula in the number i of the site. Expressions are read through the whitelist of
:mod:`.formula`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from keyword import iskeyword
from typing import Any

from ..errors import UsageError, did_you_mean
from ..system.arguments import listed, shown, whole
from .canonical import equations, shared, timed
from .formula import FUNCTIONS, Formula, Number, exact_number
from .sums import FLAT, Layout, hamiltonian_parts

#: Characters of one expression: differentiating takes the square of the number of terms.
LONGEST = 5_000
#: Components that a system without sums may have; sites of one whose start is given by formulas.
MOST_NAMED, MOST_SITES = 100, 100_000
#: Components beyond which those of lists have no names: there would be millions of texts.
MOST_LABELS = 1000

Start = Mapping[str, Any] | Sequence[Any]


def hamiltonian_entries(
    H: str, y0: Start, *, coordinates: Sequence[str] | None = None,
    momenta: Sequence[str] | None = None, parameters: Mapping[str, Any] | None = None,
    t_end: Any = 10, t0: Any = 0, invariants: Mapping[str, str] | None = None,
    observables: Mapping[str, str] | None = None, name: str = "own", source: str = "",
    time: Any = None, n: int | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return entries of a problem q' = dH/dp, p' = -dH/dq, with what is separable of it seen.

    Parameters
    ----------
    H : str
        The Hamiltonian, such as ``"p**2/2 - cos(q)"``; it may depend on ``t`` outside of
        sums, and is then not conserved.
    y0 : mapping or sequence
        Initial value: coordinate -> number or expression, or all of them in order, q before p; or
        lists (or arrays) q and p of one length, or qx, qy, px and py.
    coordinates, momenta : sequence of str, optional
        Names of q and p, in order; by default every ``q...`` of ``y0`` with its ``p...``.
    parameters : mapping, optional
        Name -> number, or a list of numbers used as ``m[i]`` in sums.
    t_end, t0 : number or str
        End and beginning.
    invariants, observables : mapping, optional
        Name -> expression in the coordinates: conserved besides H, or worth watching.
    name, source : str
        What it is and where it comes from.
    time : number, optional
        Typical time of the motion, from which step sizes are guessed.
    n : int, optional
        Length of every list of ``y0``, whose entries are then formulas in ``i`` from 0 to n - 1,
        in ``n`` and the parameters: ``{"q": "sin(pi*i/n)", "p": 0}``.

    Returns
    -------
    dict
        Arguments of :class:`.model.Problem`, with ``force`` where H = p^T p / 2 + V(q), with ``dq``
        and ``dp`` where H = T(p) + V(q), else with ``f``.

    Raises
    ------
    UsageError
        One sentence on what does not fit.
    """
    _several("y0", y0, "numbers")
    for what, given in (("coordinates", coordinates), ("momenta", momenta)):
        if given is not None:
            _several(what, given, "names")
    values = _parameters(parameters)
    y0 = _sites(y0, n) if n is not None else _lists(y0)
    names = _Names.of(y0, coordinates, momenta, values)
    entries: dict[str, Any]
    if "sum" in _text(H, "H") or names.indexed:
        entries = hamiltonian_parts(_text(H, "H"), names.half, values, names.layout)
        if len(names.layout.q) > 1 and "f" not in entries:
            entries["bodies"] = names.half // len(names.layout.q)
        scalars = {k: v for k, v in values.items() if not isinstance(v, tuple)}
    else:
        scalars = names.scalars(values)
        whole = names.scalar("H", H, scalars, ("t", "y"))
        try:
            entries = dict(equations(whole, names.half))
            if not timed(whole):  # else H is not conserved
                entries["hamiltonian"] = replace(whole, variables=("y",))
        except RecursionError:
            raise UsageError("`H` is nested too deep; write sums over i in range(n)") from None
    return {
        **entries, "y0": names.start(y0), "parameters": scalars, "canonical": True,
        "names": names.listed(),
        **names.watched(invariants, observables, scalars), **_rest(name, source, t0, t_end, time),
    }  # fmt: skip


def equation_entries(
    f: Mapping[str, str] | Sequence[str], y0: Start, *, parameters: Mapping[str, Any] | None = None,
    t_end: Any = 10, t0: Any = 0, invariants: Mapping[str, str] | None = None,
    observables: Mapping[str, str] | None = None, name: str = "own", source: str = "",
    time: Any = None, coordinates: Sequence[str] | None = None,
    momenta: Sequence[str] | None = None, n: int | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return entries of a problem y' = f(t, y) from one expression per component.

    Parameters
    ----------
    f : mapping or sequence
        Name of a component -> expression for its derivative in these names, in ``t`` and the
        parameters; or expressions in ``y[0]``, ``y[1]``...
    y0 : mapping or sequence
        Initial value, by the same names or in the same order.
    parameters, t_end, t0, invariants, observables, name, source, time :
        As in :func:`hamiltonian_entries`.
    coordinates, momenta, n :
        Refused: they go with H.

    Raises
    ------
    UsageError
        One sentence on what does not fit.
    """
    if coordinates is not None or momenta is not None:
        raise UsageError("`coordinates` and `momenta` go with `H`; the keys of `f` name components")
    if n is not None:
        raise UsageError("`n` goes with `H`; give every component of `f` its own start in `y0`")
    _several("y0", y0, "numbers")
    if not isinstance(f, str):
        _several("f", f, "expressions")
    values = _parameters(parameters)
    if isinstance(f, Mapping):
        if not f:
            raise UsageError("`f` must have an equation at least")
        names = _Names(tuple(map(str, f)), 0)
        names.check(values)
        if not isinstance(y0, Mapping) and len(y0) != len(f):
            raise UsageError(f"`y0` must have {len(f)} entries as `f` has, got {len(y0)}")
        texts = list(f.values())
    else:
        names, texts = _Names.of_vector(y0), list(f) if not isinstance(f, str) else [f]
    scalars = names.scalars(values)
    outputs = tuple(names.renamed(text, f"f[{k}]") for k, text in enumerate(texts))
    whole = Formula(outputs, variables=("t", "y"), parameters=scalars)
    names.check_formula(whole, "f")
    return {
        "f": shared(whole), "y0": names.start(y0), "names": names.of_y, "parameters": scalars,
        **names.watched(invariants, observables, scalars), **_rest(name, source, t0, t_end, time),
    }  # fmt: skip


def scalar_in(
    what: str, text: Any, names: tuple[str, ...], size: int, parameters: Mapping[str, Number]
) -> Formula:
    """Return an expression in ``size`` components of a problem, by ``names`` or as ``y[0]``, ..

    Raises
    ------
    UsageError
        One sentence on what does not fit.
    """
    return _Names(names, 0, made=size).scalar(what, text, parameters)


# --- parts ----------------------------------------------------------------------------------------


def _text(value: Any, what: str) -> str:
    if not isinstance(value, str) or not value.strip():
        raise UsageError(f"`{what}` must be an expression, got {shown(value)}")
    if len(value) > LONGEST:
        raise UsageError(
            f"`{what}` has more than {LONGEST} characters; write it as sums over i, as in "
            f"sum(p[i]**2/2 for i in range(n))"
        )
    return " ".join(value.split())


def _several(name: str, given: Any, what: str) -> None:
    """Refuse what is neither a list nor a table."""
    if not isinstance(given, Mapping):
        listed(name, given, f"a list or a table of {what}")


def _lists(y0: Start) -> Start:
    """Return a start whose arrays are lists."""
    if not isinstance(y0, Mapping):
        return y0
    for key, value in y0.items():
        if getattr(value, "ndim", 1) > 1:
            raise UsageError(
                f"`y0.{shown(key, str)}` has the shape {value.shape} and must be a list; flatten "
                f"it, or give bodies in a plane as qx, qy, px and py"
            )
    return {k: v.tolist() if hasattr(v, "tolist") else v for k, v in y0.items()}


def _sites(y0: Start, n: Any) -> Start:
    """Return a start given by formulas in the number of the site, written out for every site."""
    n = whole("n", n, 1, MOST_SITES)
    if not isinstance(y0, Mapping):
        raise UsageError("`n` goes with formulas by name, as in y0 = { q = 'sin(pi*i/n)', p = 0 }")
    found: dict[str, list[str]] = {}
    for key, value in y0.items():
        text = value if isinstance(value, str) else str(exact_number(value, f"y0.{key}"))
        try:
            tree = ast.parse(_text(text, f"y0.{key}"), mode="eval")
        except (SyntaxError, ValueError, MemoryError, RecursionError):
            raise UsageError(f"`y0.{shown(key, str)}` cannot be read: {shown(text)}") from None
        code = ast.unparse(tree)
        found[str(key)] = [
            ast.unparse(_AtSite(i, n).visit(ast.parse(code, mode="eval"))) for i in range(n)
        ]
    return found


class _AtSite(ast.NodeTransformer):
    """Writes the numbers of a site and of all sites for ``i`` and ``n``; takes remainders."""

    def __init__(self, i: int, n: int) -> None:
        self.values = {"i": i, "n": n}

    def visit_Name(self, node: ast.Name) -> ast.expr:
        value = self.values.get(node.id)
        return node if value is None else ast.Constant(value)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        sides = (node.left, node.right)
        if not isinstance(node.op, ast.Mod):
            return node
        try:
            left, right = (eval(ast.unparse(side), {"__builtins__": {}}) for side in sides)
            return ast.Constant(left % right)
        except Exception:
            raise UsageError("`y0` takes remainders of whole numbers only, as in i % 2") from None


def _is_free(name: str) -> bool:
    """Return whether a user may give this name; those that end in _ are given to subexpressions."""
    taken = (*FUNCTIONS, "pi", "t", "sum", "range")
    return (
        name.isidentifier() and not iskeyword(name) and not name.endswith("_") and name not in taken
    )


def _why_not(name: str) -> str:
    """Why a name cannot be used, and what to do."""
    if not name.isidentifier() or name.endswith("_"):
        return (
            "which is no name; take letters, digits and _, such as k_N_per_m, and no _ at the end"
        )
    if iskeyword(name):
        return "which is a word of Python; take another name"
    return "which has another meaning in expressions; take another name"


def _parameters(given: Mapping[str, Any] | None) -> dict[str, Number | tuple[Number, ...]]:
    found: dict[str, Number | tuple[Number, ...]] = {}
    if given is not None and not isinstance(given, Mapping):
        raise UsageError(f"`parameters` must be a table of numbers, got {shown(given)}")
    for key, value in (given or {}).items():
        name = str(key)
        if not _is_free(name) or name == "y":
            raise UsageError(f"`parameters` has {shown(name)}, {_why_not(name)}")
        if isinstance(value, list | tuple):
            found[name] = tuple(exact_number(x, f"{name}[{k}]") for k, x in enumerate(value))
        else:
            found[name] = exact_number(value, name)
    return found


def _rest(name: Any, source: Any, t0: Any, t_end: Any, time: Any) -> dict[str, Any]:
    if not isinstance(name, str) or not name.strip() or not isinstance(source, str):
        raise UsageError(f"`name` and `source` must be texts, got {shown(name)}")
    span = (time_of(t0, "t0"), time_of(t_end, "t_end"))
    if span[0] == span[1]:
        raise UsageError(f"`t_end` must differ from `t0`, got {span[1]:g} for both")
    scales = {} if time is None else {"time": time_of(time, "time")}
    return {"name": name, "source": source, "t_span": span, "scales": scales}


def time_of(value: Any, what: str) -> float:
    """Return a number, or an expression in numbers such as ``"20*pi"``."""
    if isinstance(value, str):
        text = _text(value, what)
        try:
            value = float(Formula((text,), variables=("y",), shape=())(()))
        except (ArithmeticError, ValueError, TypeError, UsageError):
            raise UsageError(
                f"`{what}` must be a time such as '20*pi', got {shown(value)}"
            ) from None
    return float(exact_number(value, what))


class _Names:
    """Names of the components of y = (q, p), and how they read in a formula.

    There are none where components are written ``q[i]``, numbered in the lists of the layout, of
    which q and p consist; ``half`` is the number of coordinates, 0 where f is given. ``made`` is
    that of the components of a problem that exists, so that no name can be added, else 0.
    """

    def __init__(
        self, of_y: tuple[str, ...], half: int, layout: Layout = FLAT, made: int = 0
    ) -> None:
        self.of_y, self.half, self.layout, self.made = of_y, half, layout, made

    @property
    def indexed(self) -> bool:
        """Whether components are numbered: only then are there sums over them."""
        return not self.of_y and bool(self.half)

    def listed(self) -> tuple[str, ...]:
        """Return names of all components; those of lists are numbered."""
        if self.of_y or 2 * self.half > MOST_LABELS:
            return self.of_y
        halves, sites = (self.layout.q, self.layout.p), range(self.half // len(self.layout.q))
        return tuple(f"{x}[{i}]" for half in halves for i in sites for x in half)

    @classmethod
    def of_vector(cls, y0: Start) -> _Names:
        """Return components written ``y[k]``."""
        if isinstance(y0, Mapping):
            raise UsageError("`y0` must be a list as `f` is; name the components of both or none")
        return cls((), 0)

    @classmethod
    def of(
        cls, y0: Start, coordinates: Sequence[str] | None, momenta: Sequence[str] | None,
        parameters: Mapping[str, Any],
    ) -> _Names:  # fmt: skip
        """Return names of q and p from what a user gave."""
        if (coordinates is None) != (momenta is None):
            raise UsageError("`coordinates` and `momenta` go together; give both or neither")
        if coordinates is not None and momenta is not None:
            q, p = [shown(x, str) for x in coordinates], [shown(x, str) for x in momenta]
            if len(q) != len(p):
                raise UsageError(f"`momenta` must be {len(q)} names as `coordinates`, got {len(p)}")
        elif isinstance(y0, Mapping):
            q = [str(k) for k in y0 if str(k).startswith("q")]
            p = ["p" + name[1:] for name in q]
            unpaired = [str(k) for k in y0 if str(k) not in (*q, *p)]
            if unpaired or not q:
                odd = shown(", ".join(unpaired) or "no coordinate", str)
                raise UsageError(
                    f"`y0` has {odd}, where every q... needs its p...; or list `coordinates` and "
                    f"`momenta`"
                )
        else:
            half, odd = divmod(len(y0), 2)
            if odd or not half:
                raise UsageError(f"`y0` must list q and then as many p, got {len(y0)} entries")
            if half > 1:
                return cls((), half)
            q, p = ["q"], ["p"]
        if isinstance(y0, Mapping) and any(isinstance(x, list | tuple) for x in y0.values()):
            return cls._of_lists(y0, Layout(tuple(q), tuple(p)), parameters)
        if len(q) > MOST_NAMED:
            raise UsageError(
                f"`y0` has {2 * len(q)} names and at most {2 * MOST_NAMED} are read; number them, "
                f"as in y0 = {{ q = [...], p = [...] }} with sums over q[i]"
            )
        names = cls((*q, *p), len(q))
        names.check(parameters)
        return names

    @classmethod
    def _of_lists(
        cls, y0: Mapping[str, Any], layout: Layout, parameters: Mapping[str, Any]
    ) -> _Names:
        """Return components numbered by site, in lists of one length."""
        wanted = (*layout.q, *layout.p)
        sizes = {len(x) if isinstance(x, list | tuple) else 0 for x in y0.values()}
        if set(y0) != set(wanted) or len(sizes) != 1 or 0 in sizes:
            every = shown(f"{', '.join(wanted[:-1])} and {wanted[-1]}", str)
            raise UsageError(
                f"`y0` must give lists {every} of one length, or a number for each name"
            )
        cls(wanted, 0).check(parameters)
        return cls((), len(layout.q) * sizes.pop(), layout)

    def check(self, parameters: Mapping[str, Any]) -> None:
        """Refuse names that cannot be told apart."""
        seen: set[str] = set()
        for name in self.of_y:
            if not _is_free(name):
                raise UsageError(f"`y0` has {shown(name)}, {_why_not(name)}")
            if name in seen or name in parameters:
                raise UsageError(f"the name {shown(name)} has two meanings; rename one")
            seen.add(name)

    def scalars(self, values: Mapping[str, Any]) -> dict[str, Number]:
        """Return parameters of a problem without sums: single numbers."""
        for key, value in values.items():
            if isinstance(value, tuple):
                raise UsageError(f"`parameters.{key}` is a list, which goes with sums over q[i]")
        return dict(values)

    def renamed(self, text: Any, what: str) -> str:
        """Return an expression with components written as ``y[k]``."""
        text = _text(text, what)
        if "^" in text:
            raise UsageError(f"`{what}` contains ^; write ** for powers")
        try:
            tree = ast.parse(text, mode="eval")
            return ast.unparse(_Rename(self).visit(tree))
        except (SyntaxError, ValueError, MemoryError, RecursionError):
            raise UsageError(f"`{what}` cannot be read: {shown(text)}") from None

    def scalar(
        self, what: str, text: Any, parameters: Mapping[str, Number],
        variables: tuple[str, ...] = ("y",),
    ) -> Formula:  # fmt: skip
        """Return one expression in the components as a formula."""
        formula = Formula(
            (self.renamed(text, what),), variables=variables, parameters=parameters, shape=()
        )
        self.check_formula(formula, what)
        return formula

    def check_formula(self, formula: Formula, what: str) -> None:
        """Say in the user's names what is wrong in an expression."""
        try:
            size = self.made or 2 * self.half
            beyond = [k for k in formula.indices if size and not 0 <= k < size]
        except UsageError as error:
            raise UsageError(self._said(str(error), what, formula.parameters)) from None
        if beyond:
            raise UsageError(f"`{what}` uses component {beyond[0]} of {size}")

    def _said(self, sentence: str, what: str, parameters: Iterable[str]) -> str:
        """Return a complaint of the whitelist in the user's names."""
        for k in range(len(self.of_y) - 1, -1, -1):
            sentence = sentence.replace(f"y[{k}]", self.of_y[k])
        known = re.sub(r"known are [^;]*$", "", sentence).rstrip("; ")
        if known != sentence and "unknown name" in sentence:
            name = re.search(r"unknown name '([^']*)'", sentence)
            near = did_you_mean(name[1], {*self.of_y, *parameters}, "; ") if name else ""
            others = f"known are {', '.join((*self.of_y, *parameters))}"
            advice = others if self.made else "give it in `y0` or in `parameters`"
            return f"`{what}`: {known}; {advice}{near}"
        return f"`{what}`: {sentence}"

    def start(self, y0: Start) -> tuple[Any, ...]:
        """y0 in order; entries are numbers or expressions."""
        if not isinstance(y0, Mapping):
            return tuple(y0)
        if not self.of_y:
            halves = (self.layout.q, self.layout.p)
            sites = (zip(*(y0[k] for k in half), strict=True) for half in halves)
            return tuple(x for half in sites for site in half for x in site)
        missing = [name for name in self.of_y if name not in y0]
        more = [str(name) for name in y0 if name not in self.of_y]
        if missing or more:
            wrong = (
                f"lacks {shown(missing[0], str)}"
                if missing
                else f"has {shown(more[0], str)}, which has no equation"
            )
            raise UsageError(f"`y0` {wrong}; its names are {shown(', '.join(self.of_y), str)}")
        return tuple(y0[name] for name in self.of_y)

    def watched(
        self, invariants: Any, observables: Any, parameters: Mapping[str, Number]
    ) -> dict[str, Any]:
        """Return conserved functions and observables as entries of a problem."""
        found: dict[str, Any] = {}
        for key, given in (("invariants", invariants), ("observables", observables)):
            if given is not None and not isinstance(given, Mapping):
                raise UsageError(f"`{key}` must be a table of expressions, got {shown(given)}")
            found[key] = {
                str(k): self.scalar(f"{key}.{k}", v, parameters) for k, v in (given or {}).items()
            }
        return found


class _Rename(ast.NodeTransformer):
    """Writes components of y for names, and for entries of the vectors q and p."""

    def __init__(self, names: _Names) -> None:
        self.places = {name: k for k, name in enumerate(names.of_y)}
        self.layout, self.half = names.layout, 0 if names.of_y else names.half

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        if (name := ast.unparse(node)) in self.places:
            return _component(self.places[name])
        index, vector = node.slice, node.value.id if isinstance(node.value, ast.Name) else ""
        part = self.layout.half_of(vector) if self.half else ""
        if not part or not isinstance(index, ast.Constant) or type(index.value) is not int:
            return node
        each = len(self.layout.q)
        if not 0 <= index.value < self.half // each:
            raise UsageError(
                f"`{vector}` has {self.half // each} components, from 0 on; there is no {name}"
            )
        k = (self.layout.q if part == "q" else self.layout.p).index(vector)
        return _component(each * index.value + k + (self.half if part == "p" else 0))

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return _component(self.places[node.id]) if node.id in self.places else node


def _component(k: int) -> ast.expr:
    return ast.Subscript(ast.Name("y", ast.Load()), ast.Constant(k), ast.Load())
