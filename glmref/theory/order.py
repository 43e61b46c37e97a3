"""Order of a general linear method: the existence of a starting series, decided exactly.

A method has order p when there is a starting series eta with ``M S = S E + O(h^(p+1))``. With
``principal="free"`` any series will do (for r = 1 this is Butcher's effective order); with
``principal="identity"`` the output must be the solution itself, ``w eta(t) = 0`` for every tree
(w = (1, 0, ..) where a method declares no other, see :mod:`glmref.method.preconsistency`), so that
no finishing method is needed. A method of k components has a starting series for each, over trees
in k colours: a tree with root ``f`` belongs to q, one with root ``k`` to p, and one with root ``1``
to the first right-hand side of an additive method. With ``principal="free"`` symplectic Euler has
order 2 on separable systems, being conjugate to Störmer-Verlet there. The treatment is complete:
see :mod:`glmref.theory.starting_series` for the conditions and the proof that deciding order by
order, with at most one choice of the principal parts left each time, loses no starting series.

References
----------
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 389, 531-535.
Khan, MS thesis, COMSATS University Islamabad, Lahore (2018), section 2.3.3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt
from typing import Literal

from ..errors import ExactnessError, UsageError
from ..exact import Scalar
from ..exact.linalg import Vector
from ..findings import Proof
from ..method import Method
from ..method.component import Palette
from ..method.stage_order import is_shared
from .coefficients import first_nonzero, is_zero
from .series import Series
from .starting_series import NotPreconsistent, StartingSeries
from .trees import MAX_ORDER, Tree, counted, trees_up_to

Principal = Literal["free", "identity"]

#: Characters of the reason that an undecided number gives: such numbers print at any length.
_LONGEST_REASON = 200
#: Why no order above the one found is excluded.
MANY_STARTS = (
    "the eigenvalue 1 of V is multiple, and whether other principal parts reach a higher order is "
    "not decided"
)


@dataclass(frozen=True, eq=False)
class OrderResult:
    """What is known about the order of a method or a pair."""

    order: int  #: The order p; 0 for a method that is not consistent (``reason`` says why).
    principal: Principal  #: ``"free"`` or ``"identity"``.
    #: First tree of order p + 1 whose condition fails, or ``None``.
    failing_tree: Tree | None = None
    #: Its residual ``w R(t)`` (w the left eigenvector, w u = 1), or ``None``.
    residual: Scalar | None = None
    #: Residuals of all trees of order p + 1, the error constants. For a method that needs no
    #: finishing these are the coefficients of the local error, by tree. With a free principal part
    #: the parts of order p are chosen so that the trees with a leaf at the root have none.
    residuals: Mapping[Tree, Scalar] = field(default_factory=dict)
    #: The starting series through order p, vectors with r entries; ``None`` at order 0. Principal
    #: parts of order p are free, and are zero here.
    eta: Series | None = None
    #: The functional that reads the solution off the values, by root colour; empty for a method
    #: that is not preconsistent.
    outputs: Mapping[str, Vector] = field(default_factory=dict)
    #: c = A 1 + U v by root colour (``"o"``; ``"f"`` for Q and ``"k"`` for P); empty at order 0.
    abscissae: Mapping[str, Vector] = field(default_factory=dict)
    proof: Proof = Proof.EXACT  #: Exact, or enclosed where balls took part.
    #: Upper bound of the residuals of all trees of order <= p; 0.0 when exact.
    largest_residual: float = 0.0
    #: Trees of order <= p whose residual is a ball that contains zero.
    undecided: tuple[Tree, ...] = ()
    decided: bool = True  #: Whether failing at order p + 1 excludes every starting series.
    at_least: bool = False  #: Whether the search ended at ``max_order`` without a failing tree.
    reason: str = ""  #: One sentence for what is not the usual case, or ``""``.
    #: Number of eigenvectors of V to the eigenvalue 1, 0 where there is none.
    multiplicity: int = 0

    @property
    def witness(self) -> str:
        """One sentence: what decides the order."""
        if self.failing_tree is None or self.residual is None:
            bound = f"no tree of order {self.order} or less fails" if self.at_least else ""
            return "; ".join(x for x in (bound, self.reason) if x)
        size = self.residual.magnitude()
        fails = f"tree {self.failing_tree} of order {self.order + 1} has residual {size:.6g}"
        return f"{fails}; {self.reason}" if self.reason else fails


def highest_order(palette: Palette) -> int:
    """Order up to which trees are compared: in two colours there are 19,000 of order 8 alone."""
    if len(palette) == 1:
        return 12
    return {2: 8, 3: 6}.get(len(palette), 5) if is_shared(palette) else 9


def order_of(
    method: Method,
    *,
    max_order: int | None = None,
    principal: Principal = "free",
    counts: Callable[[Tree], bool] | None = None,
) -> OrderResult:
    """Decide the order of a method, over all trees that its systems have.

    Parameters
    ----------
    method : Method
        The method; entries may be exact or balls.
    max_order : int or None
        Largest order looked at; by default :func:`highest_order`.
    principal : Principal
        ``"free"``, or ``"identity"`` where the output must be the solution itself.
    counts : Callable[[Tree], bool] or None
        Which trees count, a set closed under subtrees and cuts; by default those that the systems
        of the method have.

    Returns
    -------
    OrderResult
        The order with its witness; order 0 with the reason for a method that is not consistent.
        With several colours the principal parts at the single nodes are zero for the first.

    Raises
    ------
    UsageError
        For another ``principal`` or a ``max_order`` for which trees are not listed.
    """
    method = method.in_time
    counts = counts or counted(method.system)
    most = highest_order(method.palette) if max_order is None else max_order
    _check_arguments(most, principal)
    proof = Proof.EXACT if method.is_exact else Proof.ENCLOSED
    free = principal == "free"
    try:
        # free principal parts are determined by trees that may not count
        kept = (lambda t: True) if free else counts
        series = StartingSeries.of(method, free=free, counts=kept)
    except NotPreconsistent as reason:
        return OrderResult(0, principal, proof=proof, reason=f"not preconsistent: {reason}")
    except ExactnessError as reason:
        return OrderResult(0, principal, proof=proof, decided=False, reason=str(reason))
    result = OrderResult(
        0,
        principal,
        proof=proof,
        multiplicity=max(len(c.N) for c in series.components.values()),
        outputs={colour: c.output for colour, c in series.components.items()},
    )
    return _search(series, result, most, counts)


def _check_arguments(order: int, principal: str) -> None:
    if principal not in ("free", "identity"):
        raise UsageError(f"`principal` must be 'free' or 'identity', got {principal!r}")
    if not isinstance(order, int) or not 1 <= order <= MAX_ORDER:
        raise UsageError(f"the order must be an integer from 1 to {MAX_ORDER}, got {order!r}")


def _search(
    series: StartingSeries, result: OrderResult, max_order: int, counts: Callable[[Tree], bool]
) -> OrderResult:
    """Advance until a tree that counts fails or ``max_order`` is reached."""
    largest, undecided = 0.0, []
    for n in range(1, max_order + 1):
        try:
            level = {t: first_nonzero(series.residual(t)) for t in series.advance() if counts(t)}
            answers = {t: is_zero(x) for t, x in level.items()}
        except ExactnessError as reason:  # a number too large to be told from zero
            return replace(
                result,
                order=n - 1,
                largest_residual=largest,
                undecided=tuple(undecided),
                decided=False,
                reason=str(reason)[:_LONGEST_REASON],
            )
        failing = next((t for t, answer in answers.items() if answer is False), None)
        if failing is not None:
            result = replace(result, failing_tree=failing, residual=level[failing], residuals=level)
            return _finish(series, result, n - 1, largest, undecided)
        undecided += [t for t, answer in answers.items() if answer is None]
        largest = max([largest, *(level[t].magnitude() for t, a in answers.items() if a is None)])
    return _finish(series, replace(result, at_least=True), max_order, largest, undecided)


def _finish(
    series: StartingSeries,
    result: OrderResult,
    order: int,
    largest: float,
    undecided: Sequence[Tree],
) -> OrderResult:
    """Add to a result what follows once the order is known."""
    complete = series.complete or result.at_least
    result = replace(
        result,
        order=order,
        largest_residual=largest,
        undecided=tuple(undecided),
        decided=complete,
        reason="" if complete else MANY_STARTS,
    )
    if not order:
        return result
    # of the last order principal parts are free, whatever the next one would determine
    values = {
        t: series.plain(t) if t.order == order else series.value(t)
        for t in trees_up_to(order, series.palette)
        if series.counts(t)
    }
    empty = {colour: c.u for colour, c in series.components.items()}
    eta = Series(values, empty, order, series.palette)
    c = {x: series.abscissae(x) for x in series.palette}
    return replace(result, eta=eta, abscissae=c)


def error_norm(residuals: Mapping[Tree, Scalar]) -> float:
    """Return euclidean norm of ``residual / sigma`` over the trees of order p + 1.

    The local error is ``h^(p+1)`` times the sum of ``residual / sigma`` times the elementary
    differential, so this is the usual principal error norm (Hairer, Norsett, Wanner (1993), II.1).

    Parameters
    ----------
    residuals : Mapping[Tree, Scalar]
        Of an :class:`OrderResult`.
    """
    sizes = [x.magnitude() / t.symmetry for t, x in residuals.items()]
    return sqrt(sum(x * x for x in sizes))  # a square that is beyond doubles is infinite
