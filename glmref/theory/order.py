"""Order of a general linear method: the existence of a starting series, decided exactly.

A method has order p when there is a starting series eta with ``M S = S E + O(h^(p+1))``. With
``principal="free"`` any series will do (for r = 1 this is Butcher's effective order); with
``principal="identity"`` the output must be the solution itself, ``w eta(t) = 0`` for every tree
(w = (1, 0, ..) where a method declares no other, see :mod:`glmref.method.preconsistency`), so that
no finishing method is needed. A method of k components has a starting series for each, over trees
in k colours: a tree with root ``f`` belongs to q, one with root ``k`` to p, and one with root ``1``
to the first right-hand side of an additive method. With ``principal="free"`` symplectic Euler has
order 2 on separable systems, being conjugate to Störmer-Verlet there. The treatment is complete:
see :mod:`glmref.theory.conditions` for the conditions and the proof that deciding order by order,
with at most one choice of the principal parts left each time, loses no starting series.

References
----------
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 389, 531-535.
Khan, MS thesis, COMSATS University Islamabad, Lahore (2018), section 2.3.3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from ..errors import ExactnessError, UsageError
from ..exact import Scalar
from ..exact.linalg import Vector
from ..findings import Proof
from ..method import Method
from ..method.component import Palette
from ..method.stage_order import is_shared
from .blocks import Block, NotPreconsistent, as_scalar, block_of
from .coefficients import is_zero, plus, times
from .conditions import Conditions
from .series import Series
from .trees import MAX_ORDER, Tree, trees
from .vanishing_trees import counted

Principal = Literal["free", "identity"]

#: Characters of the reason that an undecided number gives: such numbers print at any length.
_LONGEST_REASON = 200


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
    #: the parts of order p are chosen so that the trees with a leaf at the root have none: see
    #: :mod:`.error_constants` for the least choice.
    residuals: Mapping[Tree, Scalar] = field(default_factory=dict)
    #: The starting series through order p, vectors with r entries; ``None`` at order 0. Principal
    #: parts of order p are free, and are zero here.
    eta: Series | None = None
    #: The functional that reads the solution off the values, by root colour; empty for a method
    #: that is not preconsistent.
    outputs: Mapping[str, Vector] = field(default_factory=dict)
    #: c = A 1 + U v by root colour (``"o"``; ``"f"`` for Q and ``"k"`` for P); empty at order 0.
    abscissae: Mapping[str, Vector] = field(default_factory=dict)
    #: Largest q <= p such that every stage is the solution at time c_i h, ``xi(t) = c^|t| /
    #: gamma(t)`` for all trees of order <= q, for this starting series (at q = p for some choice of
    #: its free principal parts, where several values are carried).
    stage_order: int = 0
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
    try:
        blocks = {c.colour: block_of(c) for c in method.components}
    except NotPreconsistent as reason:
        return OrderResult(0, principal, proof=proof, reason=f"not preconsistent: {reason}")
    except ExactnessError as reason:
        return OrderResult(0, principal, proof=proof, decided=False, reason=str(reason))
    conditions = Conditions(blocks, method.palette, principal)
    result = OrderResult(
        0,
        principal,
        proof=proof,
        multiplicity=max(len(b.N) for b in blocks.values()),
        outputs={colour: block.output for colour, block in blocks.items()},
    )
    if not all(b.certain for b in blocks.values()):
        reason = "V has the eigenvalue 1 only within the radius of its balls"
        result = replace(result, reason=reason)
    return _search(conditions, result, most, counts)


def order_residuals(
    method: Method, order: int, *, principal: Principal = "identity"
) -> dict[Tree, Scalar]:
    """Return the residuals of all conditions through the given order, decided or not.

    For solvers: works for every number type, and goes on past residuals that are not zero. With a
    free principal part the conditions that only determine it are left out.

    Raises
    ------
    UsageError
        When a component has no u with V u = u and U u = 1.
    """
    _check_arguments(order, principal)
    try:
        blocks = {c.colour: block_of(c) for c in method.components}
    except NotPreconsistent as reason:
        raise UsageError(f"the method {method.name!r} is not preconsistent: {reason}") from None
    return residuals_of(blocks, method.palette, order, principal)


def residuals_of(
    blocks: Mapping[str, Block], palette: Palette, order: int, principal: Principal
) -> dict[Tree, Scalar]:
    """Residuals of all conditions through the given order, of prepared methods."""
    conditions = Conditions(blocks, palette, principal)
    found: dict[Tree, Scalar] = {}
    for _ in range(order):
        level = conditions.advance()
        found.update({t: _one(x) for t, x in level.items() if t not in conditions.determined})
    return found


def _check_arguments(order: int, principal: str) -> None:
    if principal not in ("free", "identity"):
        raise UsageError(f"`principal` must be 'free' or 'identity', got {principal!r}")
    if not isinstance(order, int) or not 1 <= order <= MAX_ORDER:
        raise UsageError(f"the order must be an integer from 1 to {MAX_ORDER}, got {order!r}")


def _one(residual: Sequence[Any]) -> Scalar:
    """The residual of a tree as one number: the first entry that is not certainly zero."""
    value = next((x for x in residual if is_zero(x) is not True), 0)
    return as_scalar(value)


def _search(
    conditions: Conditions, result: OrderResult, max_order: int, counts: Callable[[Tree], bool]
) -> OrderResult:
    """Advance until a tree that counts fails or ``max_order`` is reached."""
    largest, undecided = 0.0, []
    for n in range(1, max_order + 1):
        try:
            level = {t: _one(x) for t, x in conditions.advance().items() if counts(t)}
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
            return _finish(conditions, result, n - 1, largest, undecided, counts)
        undecided += [t for t, answer in answers.items() if answer is None]
        largest = max([largest, *(level[t].magnitude() for t, a in answers.items() if a is None)])
    result = replace(result, at_least=True)
    return _finish(conditions, result, max_order, largest, undecided, counts)


def _finish(
    conditions: Conditions,
    result: OrderResult,
    order: int,
    largest: float,
    undecided: Sequence[Tree],
    counts: Callable[[Tree], bool],
) -> OrderResult:
    """Add to a result what follows once the order is known."""
    complete = conditions.complete or result.at_least
    if not complete:
        more = (
            "the eigenvalue 1 of V is multiple, and whether other principal parts reach a higher "
            "order is not decided"
        )
        result = replace(result, reason="; ".join(x for x in (result.reason, more) if x))
    eta = _starting_series(conditions, order, counts) if order else None
    nodes = [] if eta is None else [(node, eta[node]) for node in trees(1, conditions.palette)]
    c = {node.colour: conditions.stage_vector(node, value) for node, value in nodes}
    return replace(
        result,
        order=order,
        largest_residual=largest,
        undecided=tuple(undecided),
        decided=complete,
        eta=eta,
        abscissae={colour: tuple(map(as_scalar, x)) for colour, x in c.items()},
        stage_order=0 if eta is None else _stage_order(conditions, eta, c, order, counts),
    )


def _starting_series(conditions: Conditions, order: int, counts: Callable[[Tree], bool]) -> Series:
    """The starting series through ``order``, principal parts of that order zero."""
    values = {t: x for t, x in conditions.eta.items() if t.order < order}
    last = conditions.eta if conditions.order == order else conditions.last_free
    values.update({t: x for t, x in last.items() if t.order == order})
    return Series(
        {t: tuple(map(as_scalar, x)) for t, x in values.items() if counts(t)},
        {colour: block.u for colour, block in conditions.blocks.items()},
        order,
        conditions.palette,
    )


def _stage_order(
    conditions: Conditions,
    eta: Series,
    c: Mapping[str, Sequence[Any]],
    order: int,
    counts: Callable[[Tree], bool],
) -> int:
    for q in range(1, order + 1):
        for t in filter(counts, trees(q, conditions.palette)):
            defect = conditions.stage_defect(t, eta[t], c[t.colour])
            if q == order and _adjustable(conditions, eta, t.colour):
                defect = tuple(plus(x, times(-1, defect[0])) for x in defect[1:])
            if is_zero(defect) is False:
                return q - 1
    return order


def _adjustable(conditions: Conditions, eta: Series, colour: str) -> bool:
    """Whether the free principal parts of the highest order are chosen to suit the stages.

    Not for a Runge-Kutta method that starts from the solution itself: its stage order is that of
    the literature, 1 for the midpoint rule.
    """
    if not conditions.free or len(conditions.blocks[colour].u) > 1:
        return conditions.free
    known = (x for t, x in eta.support().items() if t.colour == colour)
    return any(is_zero(conditions.principal_part(colour, x)) is not True for x in known)
