"""Starting and finishing methods as frozen records: of one method, and of a pair."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector
from .component import SEPARABLE, Component, Palette
from .entries import as_rows, as_vector, check_fields
from .model import PAIR, Method


class _Start(Method):
    """A method that makes r values of one: u and B, and stages that begin from that one."""

    def __post_init__(self) -> None:
        check_fields(self, kind=str)
        hats = [*self.LETTERS.values()]
        stages = [len(as_rows(self, f"A{hat}")) for hat in hats]
        for hat, rows, columns in zip(hats, stages, reversed(stages), strict=True):
            u = as_vector(getattr(self, f"u{hat}"), f"u{hat}")
            object.__setattr__(self, f"u{hat}", u)
            as_rows(self, f"A{hat}", rows, columns)
            as_rows(self, f"B{hat}", len(u), columns)

    @cached_property
    def components(self) -> tuple[Component, ...]:
        """The components: U is a column of ones, V the column u."""
        one = ((Exact(1),),)
        return tuple(
            Component(colour, A, one * len(A), B, tuple((x,) for x in u))
            for colour, (A, B, u) in zip(
                self.LETTERS,
                ([getattr(self, x + hat) for x in "ABu"] for hat in self.LETTERS.values()),
                strict=True,
            )
        )

    @property
    def times(self) -> tuple[Vector, ...]:
        """A 1: stages begin from the one value that comes in."""
        return tuple(linalg.row_sums(c.A) for c in self.components)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values that each component is given."""
        return tuple(len(c.V) for c in self.components)


@dataclass(frozen=True, eq=False)
class StartingMethod(_Start):
    """Runge-Kutta-like start: ``Y = y0 + h A f(Y)``, ``y^[0]_k = u_k y0 + h B_k f(Y)``.

    Attributes
    ----------
    A : Matrix
        (m, m) internal stages, ``m`` may be 0 (then B has no columns and only ``u`` acts).
    B : Matrix
        (r, m) weights of the r starting values.
    u : Vector
        (r,) multiples of y0.
    name : str
        Where it comes from, for messages.
    kind : str
        ``"runge-kutta"`` for this tableau form.
    claims : Mapping[str, Any]
        What its data says, for example ``{"order": 3}``: agrees with the starting series on all
        trees of that order.
    """

    A: Matrix
    B: Matrix
    u: Vector
    name: str = ""
    kind: str = "runge-kutta"
    claims: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def stages(self) -> int:
        """Number of internal stages (right-hand-side evaluations when explicit)."""
        return len(self.A)

    def transform(self, T: Matrix) -> StartingMethod:
        """Return the start of the same method carrying ``T y``: ``T B`` and ``T u``, T (r, r)."""
        return replace(self, B=linalg.matmul(T, self.B), u=linalg.matvec(T, self.u))


@dataclass(frozen=True, eq=False)
class PairStartingMethod(_Start):
    """Runge-Kutta-like start of a pair, from (q0, p0).

    ``Q = q0 + h A f(P)``, ``P = p0 + h A^ k(Q)``, ``q^[0]_k = u_k q0 + h B_k f(P)`` and
    ``p^[0]_k = u^_k p0 + h B^_k k(Q)``. For a system that is not separable stage i is the point
    (Q_i, P_i), and f and k are evaluated there.

    Attributes
    ----------
    A, A_hat : Matrix
        (n_Q, n_P) and (n_P, n_Q) internal stages.
    B, B_hat : Matrix
        (r, n_P) and (r^, n_Q) weights of the starting values of q and of p.
    u, u_hat : Vector
        (r,) and (r^,) multiples of q0 and of p0.
    name, kind, claims
        As in :class:`StartingMethod`.
    """

    A: Matrix
    B: Matrix
    u: Vector
    A_hat: Matrix
    B_hat: Matrix
    u_hat: Vector
    LETTERS = PAIR
    name: str = ""
    kind: str = "runge-kutta"
    claims: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def stages(self) -> tuple[int, int]:
        """Numbers of stages Q, where k is evaluated, and of stages P, where f is."""
        return len(self.A), len(self.A_hat)

    def transform(self, T: Matrix, T_hat: Matrix) -> PairStartingMethod:
        """Return the start of the same pair carrying ``T q`` and ``T_hat p``."""
        return replace(
            self,
            B=linalg.matmul(T, self.B),
            u=linalg.matvec(T, self.u),
            B_hat=linalg.matmul(T_hat, self.B_hat),
            u_hat=linalg.matvec(T_hat, self.u_hat),
        )

    @property
    def palette(self) -> Palette:
        """Colours as on separable systems; the method that is started says what is meant."""
        return SEPARABLE


@dataclass(frozen=True, eq=False)
class FinishingMethod(Method):
    """Runge-Kutta-like finish on the output z = w y: ``Y = z + h A f(Y)``, ``y = z + h b f(Y)``.

    The output is the first value where the method declares none and the first value is the
    solution; see :mod:`glmref.method.preconsistency`.

    Attributes
    ----------
    A : Matrix
        (m, m) internal stages.
    b : Vector
        (m,) weights.
    """

    A: Matrix
    b: Vector
    name: str = ""
    claims: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "b", as_vector(self.b, "b"))
        as_rows(self, "A", len(self.b), len(self.b))

    @property
    def stages(self) -> int:
        """Number of internal stages."""
        return len(self.A)

    @cached_property
    def components(self) -> tuple[Component, ...]:
        """The one component: U is a column of ones, V is 1."""
        one = ((Exact(1),),)
        return (Component("o", self.A, one * len(self.A), (self.b,), one),)

    @property
    def times(self) -> tuple[Vector, ...]:
        """A 1: stages begin from the output."""
        return (linalg.row_sums(self.A),)
