"""The modified equation of a method as a user sees it, and the modified energy at a state."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..catalogue.lookup import method_of
from ..engine.arithmetic import Arithmetic
from ..errors import ExactnessError, UsageError
from ..exact.expression import shown_number
from ..method import Method
from ..problems import Problem
from ..problems.nilpotent import Derivatives
from ..system.arguments import number, whole
from ..system.shown import Shown
from ..theory.backward import (
    Reach,
    composed,
    conjugacy,
    elementary_hamiltonians,
    energy_reach,
    hamiltonian_reach,
    over_free_trees,
)
from ..theory.second_order import SecondOrder, second_order
from ..theory.series import Series, exponential, inverse
from ..theory.starting_series import NotPreconsistent
from ..theory.symplectic import g_symplectic
from ..theory.trees import MAX_ORDER, FreeTree, Tree, free_tree, halves
from ..theory.underlying import UnderlyingMethod

if TYPE_CHECKING:
    from ..engine.outcome import Solution


@dataclass(frozen=True, repr=False, eq=False)
class Modified(Shown):
    """Backward error analysis of a method. Made by :func:`modified`.

    Attributes
    ----------
    method : str
        Its name.
    order : int
        Trees up to this order were taken.
    map, field : Series
        The underlying one-step method, which takes one output to the next, and its modified field.
    hamiltonian, conjugate_symplectic, energy : Reach
        Through which order the field is Hamiltonian, the map is conjugate to a symplectic one, and
        the field preserves H. Each includes the orders through which the method is exact.
    form : bool
        Whether the change of variables is that of the form G; otherwise it is solved for.
    conjugate_field : Series
        The Hamiltonian field in the changed variables, through the order that was reached.
    hamiltonian_terms : Mapping[FreeTree, Any]
        Coefficients of ``h^(|t| - 1) H(t)`` in its Hamiltonian.
    invariant_terms : Mapping[FreeTree, Any]
        The same of the function that the outputs conserve.
    underlying : UnderlyingMethod
        The series of the starting method for which no parasitic part is left.
    parasitic : tuple[SecondOrder, ...]
        What a parasitic part obeys to second order in h; empty for pairs and where growth of first
        order is not excluded.
    """

    method: str
    order: int
    map: Series
    field: Series
    hamiltonian: Reach
    conjugate_symplectic: Reach
    energy: Reach
    form: bool
    conjugate_field: Series
    hamiltonian_terms: Mapping[FreeTree, Any]
    invariant_terms: Mapping[FreeTree, Any]
    underlying: UnderlyingMethod
    parasitic: tuple[SecondOrder, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the record: orders, witnesses, and coefficients by tree as text."""
        return {
            "order": self.order,
            "hamiltonian": asdict(self.hamiltonian),
            "conjugate_symplectic": asdict(self.conjugate_symplectic),
            "energy": asdict(self.energy),
            "gauge": "form" if self.form else "solved",
            "hamiltonian_terms": _texts(self.hamiltonian_terms),
            "invariant_terms": _texts(self.invariant_terms),
            "parasitic": [
                {name: shown_number(getattr(x, name)) for name in ("eigenvalue", "I1", "I3")}
                for x in self.parasitic
            ],
        }

    def energy_at(
        self,
        problem: Problem,
        y: Any,
        h: float,
        *,
        order: int | None = None,
        digits: int | None = None,
    ) -> Any:
        """Return the modified energy of a state: what the outputs of the method conserve.

        Parameters
        ----------
        problem : Problem
            Hamiltonian in y = (q, p), given by expressions; separable for a pair.
        y : array
            (d,) output of the method.
        h : float
            Step size.
        order : int or None
            Largest order of a tree; terms of h^order and more are left out. By default all.
        digits : int or None
            Compute with so many digits in place of doubles.

        Raises
        ------
        UsageError
            For a problem that is not Hamiltonian or not given by expressions, or an order beyond
            that through which the method is conjugate-symplectic.
        """
        reached = self.conjugate_field.order
        top = reached if order is None else whole("order", order, 1, reached)
        arithmetic = Arithmetic(digits)
        values = ElementaryHamiltonians(problem, y, self.field.palette, arithmetic.context)
        step = arithmetic.number(h if digits else number("h", h))
        total = values.energy
        for free, x in self.invariant_terms.items():
            if 1 < free.root.order <= top:
                scale = step ** (free.root.order - 1) * arithmetic.number(x)
                total = total + scale * values(free.root)
        return total

    def start_at(self, problem: Problem, y: Any, h: float, *, digits: int | None = None) -> Any:
        """Return the values with the output y on which the method acts as its one-step method.

        Parameters
        ----------
        problem, y, h, digits
            As in :meth:`energy_at`.

        Returns
        -------
        np.ndarray
            (r, d) values; their parasitic part is of the size h^(order + 1).
        """
        arithmetic = Arithmetic(digits)
        series, half = self.underlying, problem.dimension // 2
        at = ElementaryHamiltonians(problem, y, series.palette, arithmetic.context)
        step = arithmetic.number(h if digits else number("h", h))
        columns = dict(zip(series.components, (slice(None, half), slice(half, None)), strict=False))
        if len(series.components) == 1:
            columns = dict.fromkeys(columns, slice(None))
        rows = max(len(c.u) for c in series.components.values())
        values = arithmetic.zeros((rows, problem.dimension))
        state = np.array([arithmetic.number(x) for x in y])
        for colour, c in series.components.items():
            for j, u in enumerate(c.u):
                values[j, columns[colour]] = arithmetic.number(u) * state[columns[colour]]
        for t, eta in series.eta.items():
            scale, slope = step**t.order / t.symmetry, np.array(at.differential(t))
            for j, x in enumerate(eta):
                if not (type(x) is int and x == 0):
                    values[j, columns[t.colour]] += arithmetic.number(x) * scale * slope
        return values

    def oscillation(
        self, problem: Problem, states: Any, h: float, *, order: int | None = None
    ) -> float:
        """Predict the largest change of H along an orbit: H~ stays, so H moves by H - H~.

        Parameters
        ----------
        problem, h, order
            As in :meth:`energy_at`.
        states : array
            (m, d) states of the exact orbit, or of any run.

        Returns
        -------
        float
            The largest ``|H(y) - H(y_0)|`` predicted at the states.
        """
        gaps = []
        for y in np.asarray(states):
            values = problem.hamiltonian(y)
            gaps.append(values - self.energy_at(problem, y, h, order=order))
        return float(np.max(np.abs(np.array(gaps) - gaps[0])))


def modified_energy(solution: Solution, order: int) -> np.ndarray:
    """See :meth:`.outcome.Solution.modified_energy`."""
    if solution.origin is None:
        raise UsageError("a solution that was loaded has no problem; call it on the run itself")
    problem, method = solution.origin
    found = modified(method, order)
    reached = found.conjugate_field.order
    if reached < order:
        raise UsageError(f"{method.name} is conjugate-symplectic to order {reached} only; "
                         f"`order` must be at most {reached}")  # fmt: skip
    rows = np.asarray(solution.y)
    return np.array([found.energy_at(problem, y, solution.h, order=order) for y in rows])


def _texts(terms: Mapping[FreeTree, Any]) -> dict[str, str]:
    return {str(free.root): shown_number(x) for free, x in terms.items()}


def modified(method: Method | str, order: int = 6) -> Modified:
    """Return the modified equation of a method and what it says on long runs.

    Parameters
    ----------
    method : Method or str
        A method with one or two components; a pair is taken on separable systems.
    order : int
        Largest order of a tree, 1 to 14; conjugate symplecticity is looked at through order 8,
        further only with a form G.

    Raises
    ------
    UsageError
        For an additive method, where 1 is not a simple eigenvalue of V or U u = 1 does not hold,
        or for a bad order.
    ExactnessError
        Where V holds published decimals.

    Examples
    --------
    >>> import glmref
    >>> found = glmref.modified("implicit-midpoint", 5)
    >>> found.hamiltonian.text, found.energy.text
    ('at least 5', '2, not 3: [oo]')
    """
    order = whole("order", order, 1, MAX_ORDER)
    found = method_of(method)
    if found.additive:
        raise UsageError(
            f"{found.name} is an additive method; modified equations are for methods of one "
            "component and for pairs"
        )
    try:
        plain = UnderlyingMethod.of_method(found).through(order)
    except NotPreconsistent as error:
        raise UsageError(f"{found.name} has no underlying one-step method: {error}") from None
    form = g_symplectic(found)
    if form.holds is not False and form.G is not None:
        own = UnderlyingMethod.of_method(found, form=form.G).through(order)
        reach = hamiltonian_reach(own.field)
        changed = own.field.truncate(reach.order)
        back = [inverse(own.reading.truncate(reach.order))]
    else:
        conjugate = conjugacy(plain.field)
        reach, changed = conjugate.reach, conjugate.field
        back = [
            exponential(c.truncate(reach.order).map(lambda x: -x))
            for c in reversed(conjugate.change)
        ]
    hamiltonian = elementary_hamiltonians(changed)
    invariant = hamiltonian
    for change in back:
        invariant = composed(invariant, change)
    return Modified(
        method=found.name,
        order=order,
        map=plain.map,
        field=plain.field,
        hamiltonian=hamiltonian_reach(plain.field),
        conjugate_symplectic=reach,
        energy=energy_reach(plain.field),
        form=form.holds is not False and form.G is not None,
        conjugate_field=changed,
        hamiltonian_terms=over_free_trees(hamiltonian),
        invariant_terms=over_free_trees(invariant),
        underlying=plain,
        parasitic=_parasitic(found),
    )


def _parasitic(method: Method) -> tuple[SecondOrder, ...]:
    if len(method.components) > 1 or method.carried == 1:
        return ()
    with suppress(ExactnessError):
        return second_order(method)
    return ()


class ElementaryHamiltonians:
    """Elementary differentials and Hamiltonians of a problem at one state.

    ``H(u o v) = F_q(u) . F_p(v) - F_p(u) . F_q(v)``: both halves of an edge are differentials of
    lower order, which are computed once each.
    """

    def __init__(self, problem: Problem, y: Any, palette: Mapping[str, str], context: Any) -> None:
        half = problem.dimension // 2
        if problem.hamiltonian is None or not problem.canonical:
            raise UsageError(f"{problem.name} is not given as a Hamiltonian problem in y = (q, p)")
        self.half, self.context = half, context
        state = np.asarray(y)
        if state.shape != (problem.dimension,):
            raise UsageError(f"`y` must be a state of {problem.dimension} components")
        if len(palette) == 1:
            parts = {next(iter(palette)): (problem.f, state, True)}
        elif problem.separable:
            parts = {"f": (problem.dq, state[half:], False), "k": (problem.dp, state[:half], False)}
        else:
            raise UsageError(f"{problem.name} is not separable, as the pair needs")
        self._derivatives = {
            colour: Derivatives(function, at, context, timed=timed)
            for colour, (function, at, timed) in parts.items()
        }
        (self.energy,) = Derivatives(problem.hamiltonian, state, context, timed=False).along([])
        self._known: dict[Tree, list[Any]] = {}

    def differential(self, t: Tree) -> list[Any]:
        """Return F(t), (d,), or (d/2,) of the component of its root."""
        if t not in self._known:
            below = Counter(t.children)
            directions = [(self.differential(child), k) for child, k in below.items()]
            self._known[t] = self._derivatives[t.colour].along(directions)
        return self._known[t]

    def __call__(self, t: Tree) -> Any:
        """Return H(t) of a tree of two vertices at least."""
        free = free_tree(t)  # of all edges the one with the smallest halves
        pairs = [(u, v, sign) for s, sign in free.signs.items() for u, v in halves(s)]
        u, v, sign = min(pairs, key=lambda pair: max(pair[0].order, pair[1].order))
        return sign * free.signs[t] * self._product(u, v)

    def _product(self, u: Tree, v: Tree) -> Any:
        a, b, half = self.differential(u), self.differential(v), self.half
        if u.colour == v.colour:
            return _dot(a[:half], b[half:]) - _dot(a[half:], b[:half])
        return _dot(a, b) if u.colour == "f" else -_dot(a, b)


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return sum(x * y for x, y in zip(a, b, strict=True))
