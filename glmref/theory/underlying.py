"""The underlying one-step method of a general linear method, as an exact series.

A method maps values x to M x. Where 1 is a simple eigenvalue of V there is a starting method eta
and a one-step method Phi with ``M eta = eta Phi`` (Kirchgraber 1986; Stoffer 1993): started with
eta(y) the method passes on eta(Phi(y)), eta(Phi(Phi(y))), .. On trees, with w the left and u the
right eigenvector of V to 1, w u = 1, b the modified field of Phi, ``Phi eta = exp(d_b) eta``, and
K(t) the terms of ``(Phi eta)(t) = eta(t) + u b(t) + K(t)`` from lower orders,

    b(t) = w (B xiD(t) - K(t))        (I - V) eta(t) = B xiD(t) - K(t) - u b(t)

eta(t) is determined up to a multiple of u. **The gauge** says which: in the *output gauge* the
output functional gives zero on eta(t), so that Phi takes one output to the next. Any other choice
is ``chi``-conjugate: eta chi goes with ``chi^-1 Phi chi``. No other cuts than those of single edges
are needed, and Phi = exp(d_b) id.

**The symplectic gauge.** Let G be a form that the method conserves, u^* G u = 1. Then Phi conserves
the two-form ``sum g_ij d eta_i ^ d eta_j``, and it is the canonical one where, for all u and v,

    p(u o v) + p(v o u) = <eta(u), eta(v)>_G,        p = w eta

The right-hand side is of lower order, and the equation fixes p(v o u) where p(u o v) is known. The
rooted trees of a free tree, joined where the root moves along an edge, form a tree: so the
equations are solvable, with one free number for each free tree that is not superfluous. Hence a
G-symplectic method is conjugate to a symplectic one: the theorem of D'Ambrosio, Hairer and Zbinden.
The free number is fixed by ``sum of +-p(t)/sigma(t) = 0`` over the rooted trees.

References
----------
Stoffer, "General linear methods: connection to one step methods and invariant curves", Numer. Math.
64 (1993) 395-408. Hairer, Lubich, Wanner (2006), section XV.2. D'Ambrosio, Hairer, Zbinden,
"G-symplecticity implies conjugate-symplecticity of the underlying one-step method", BIT 53 (2013)
867-872.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from ..errors import ExactnessError, UsageError
from ..exact import linalg
from ..exact.linalg import Matrix
from ..method.component import GENERAL, SEPARABLE, Palette
from ..method.model import Method
from ..system.budget import spend
from .coefficients import plus, scalars, tidy, times
from .series import AfterFlow, Series
from .starting_series import Prepared, StartingSeries, component, read
from .symplectic import quadratic_value
from .trees import FreeTree, Tree, free_trees, halves


class UnderlyingMethod(StartingSeries):
    """The starting series eta with ``M eta = eta Phi``, and Phi.

    Made by :meth:`of_method`; ``through(n)`` finds the trees up to order n.

    Attributes
    ----------
    phi : dict[Tree, Any]
        Coefficients of Phi.
    form : Matrix or None
        G of the symplectic gauge; ``None``: the output gauge.
    is_real : bool
        Whether all coefficients of the method are real.
    """

    def __init__(
        self,
        components: dict[str, Prepared],
        palette: Palette,
        form: Matrix | None = None,
        *,
        is_real: bool = True,
    ) -> None:
        super().__init__(components, palette, free=False)
        # eta of a gauge is not zero, and its stages are those of no other series
        self.solved.solved, self.solved.known = False, {}
        self.form: Matrix | None = form
        self.is_real: bool = is_real
        self.phi: dict[Tree, Any] = {}
        self._after = AfterFlow({x: (*c.u, 1) for x, c in components.items()})

    @classmethod
    def of_method(cls, method: Method, *, form: Matrix | None = None) -> UnderlyingMethod:
        """Return the series of a method, before the first order.

        Parameters
        ----------
        method : Method
            A pair is taken on separable systems.
        form : Matrix or None
            G that the method conserves, Hermitian where it is complex: the symplectic gauge.

        Raises
        ------
        UsageError
            Where 1 is a multiple eigenvalue of V: Phi is then not unique.
        NotPreconsistent, ExactnessError
            As :func:`.starting_series.component`.
        """
        components = {}
        for c in method.components:
            prepared = component(*c.matrices, c.output)
            if len(prepared.N) > 1:
                raise UsageError(
                    f"1 is an eigenvalue of V of multiplicity {len(prepared.N)}: the underlying "
                    "one-step method is not unique; it is defined for a simple eigenvalue"
                )
            components[c.colour] = prepared
        if form is not None:
            first, last = (
                components[method.components[0].colour],
                components[method.components[-1].colour],
            )
            total = quadratic_value(form, first.u, last.u)
            if total.is_zero() is not False:
                raise ExactnessError("the form ignores the solution, or that is not decided")
            form = tuple(tuple(x / total for x in row) for row in form)
        return cls(components, series_palette(method), form, is_real=method.is_real)

    def settle(self) -> None:
        """Find eta, Phi and the field at the trees of the last order."""
        if self.solved.filled == self.order:
            return
        self.solved.filled = self.order
        gauge = {} if self.form is None else self._symplectic_gauge(self.order)
        for t in self.level(self.order):
            spend()
            c = self.components[t.colour]
            right: Any = self.output(t)
            beyond: Any = self._after.beyond(t)
            if type(beyond) is tuple:
                right = plus(right, times(-1, beyond[:-1]))
            (slope,) = linalg.matvec(c.W, right)
            value = tidy(linalg.matvec(c.lift, plus(right, times(times(-1, slope), c.u))))
            if t in gauge:
                (seen,) = linalg.matvec(c.W, scalars(value))
                value = tidy(plus(value, times(plus(gauge[t], times(-1, seen)), c.u)))
            self.solved.give(t, value)
            self.phi[t] = plus(slope, beyond[-1]) if type(beyond) is tuple else slope
            self._after.settle(t, (*value, 0), slope)

    def _symplectic_gauge(self, order: int) -> dict[Tree, Any]:
        """Return ``p = w eta`` at the trees of an order."""
        gauge: dict[Tree, Any] = {}
        for free in free_trees(order, tuple(self.palette.items())):
            gauge |= self._gauge_of(free)
        return gauge

    def _gauge_of(self, free: FreeTree) -> dict[Tree, Any]:
        p: dict[Tree, Any] = {free.root: 0}
        if free.superfluous:
            middle, half = next((t, u) for t in free.signs for u, v in halves(t) if u is v)
            p = {middle: times(Fraction(1, 2), self._pairing(half, half))}
        waiting = list(p)
        while waiting:
            t = waiting.pop()
            for u, v in halves(t):
                if v * u not in p:
                    p[v * u] = plus(self._pairing(u, v), times(-1, p[t]))
                    waiting.append(v * u)
        if free.superfluous:
            return p
        weights = {t: Fraction(sign, t.symmetry) for t, sign in free.signs.items()}
        excess: Any = 0
        for t, x in p.items():
            excess = plus(excess, times(weights[t], x))
        part = times(-1 / sum(Fraction(1, t.symmetry) for t in p), excess)
        return {t: plus(x, times(free.signs[t], part)) for t, x in p.items()}

    def _pairing(self, u: Tree, v: Tree) -> Any:
        """Return the real part of ``eta(u)^* G eta(v)``, in a pair u of the first component."""
        assert self.form is not None
        if u.colour != next(iter(self.components)):
            u, v = v, u
        x, y = self.value(u), linalg.matvec(self.form, self.value(v))
        return linalg.dot(x, y) if self.is_real else linalg.dot([z.conjugate() for z in x], y).real

    @property
    def map(self) -> Series:
        """Phi through the last order."""
        return Series(self.phi, 1, self.order, self.palette)

    @property
    def field(self) -> Series:
        """Its modified field b: ``h f~ = sum of b(t) h^|t| / sigma(t) F(t)``."""
        return Series(self._after.field, 0, self.order, self.palette)

    @property
    def reading(self) -> Series:
        """What the output functional reads off eta: the identity in the output gauge."""
        values = {t: read(self.components[t.colour], x) for t, x in self.eta.items()}
        return Series(values, 1, self.order, self.palette)


def series_palette(method: Method) -> Palette:
    """Return the palette of the trees: a pair is taken on separable systems."""
    return SEPARABLE if dict(method.palette) == dict(GENERAL) else method.palette
