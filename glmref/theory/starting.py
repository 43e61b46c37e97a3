"""Starting and finishing methods against the exact starting series.

Public names::

    starting_order(method, starting, *, max_order=None, principal="free", known=None)
        -> StartingResult
    zero_start_order(result) -> (int, str)
    finishing_order(method, finishing, *, starting=None, max_order=None) -> StartingResult
    exact_start_series(method, order, *, principal="free") -> Series     (vectors of r entries)
    starting_series(starting, order) -> Series                          (vectors of r entries)
    finishing_series(finishing, order) -> Series                        (scalar)
    StartingResult                                                      frozen record

A method of order p has a family of starting series: one eta with principal parts zero at order p,
every ``eta(t) + beta(t) u`` at ``|t| = p``, and each of these after the exact flow of any duration
(:mod:`glmref.theory.conditions` proves that there are no others). A starting method has order q
when it agrees with a member of the family on all trees of order <= q. Then, for q = p, errors in
all values are O(h^(p+1)) after the start; the output may be a shifted or conjugated solution,
which the finishing method has to undo. The components of a partitioned or an additive method have
a starting series each, over trees in their colours; no finishing method follows there, and so the
principal parts are zero. On second-order systems (:mod:`glmref.theory.nystrom`) only the trees
count in which no vertex f has two children.

References
----------
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 530-535.
Khan, MS thesis, COMSATS University Islamabad, Lahore (2018), equations (3.6) and (3.9).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from ..errors import UsageError
from ..exact import Exact, Scalar, linalg
from ..findings import Proof
from ..method import GLM, FinishingMethod, Method, StartingMethod
from .blocks import apply, as_scalar, sparse
from .coefficients import is_zero, plus, times
from .order import OrderResult, Principal, order_of
from .series import Series, compose, elementary_weights, shift, values_series
from .trees import MAX_ORDER, Tree, single, trees

__all__ = [
    "StartingResult",
    "exact_start_series",
    "finishing_order",
    "finishing_series",
    "starting_order",
    "starting_series",
    "zero_start_order",
]


@dataclass(frozen=True, eq=False)
class StartingResult:
    """What is known about the order of a starting or a finishing method.

    Attributes
    ----------
    order : int
        Largest order through which it agrees; -1 when already the multiples of y differ.
    failing_tree : Tree or None
        First tree on which it differs, ``None`` when none was found.
    component : int
        Value, counted from 1, in which it differs there; 0 when none. The root of the tree says of
        which component.
    residual : Scalar or None
        By how much, or ``None``.
    shift : Scalar
        Duration, in steps, by which the start runs ahead of the solution (0 is usual).
    proof : Proof
        Exact, or enclosed where balls took part.
    largest_residual : float
        Upper bound of the differences through ``order``; 0.0 when exact.
    method_order : int
        Order p of the method, which is the largest order that has a meaning.
    compared : str
        Which trees were compared, in words.
    """

    order: int
    failing_tree: Tree | None = None
    component: int = 0
    residual: Scalar | None = None
    shift: Scalar = field(default_factory=Exact)
    proof: Proof = Proof.EXACT
    largest_residual: float = 0.0
    method_order: int = 0
    compared: str = "all trees"

    @property
    def witness(self) -> str:
        """One sentence: what decides the order."""
        if self.residual is None:
            return f"agrees on {self.compared} of order {self.order} or less"
        if not self.component:
            return "the method has no starting series to agree with"
        where = "the multiple of y" if self.failing_tree is None else f"tree {self.failing_tree}"
        size = self.residual.magnitude()
        return f"{where} differs by {size:.6g} in value {self.component}"


def starting_series(starting: Method, order: int, *, like: Method | None = None) -> Series:
    """Return the vector-valued series of a starting method, through the given order.

    Parameters
    ----------
    like : Method or None
        The method that is started, whose colours are taken.
    """
    return values_series(starting, order, None if like is None else like.palette)


def finishing_series(finishing: FinishingMethod, order: int) -> Series:
    """Return the scalar series of a finishing method, through the given order."""
    return elementary_weights(finishing.A, finishing.b, order)


def exact_start_series(method: Method, order: int, *, principal: Principal = "free") -> Series:
    """Return the exact starting series of a method through the given order.

    With a free principal part the member of the family that is returned has, in the output, no
    shift in time, and zero principal parts at the order of the method.

    Raises
    ------
    UsageError
        When the method's order is lower.
    """
    result = order_of(method, max_order=max(order, 1), principal=principal)
    if result.order < order or result.eta is None:
        raise UsageError(
            f"{method.name or 'the method'!r} has no starting series through order {order}: its "
            f"order is {result.order} ({result.witness})"
        )
    if result.order > order:
        return result.eta.truncate(order)
    return result.eta


def starting_order(
    method: Method,
    starting: Method,
    *,
    max_order: int | None = None,
    principal: Principal | None = None,
    known: OrderResult | None = None,
    counts: Callable[[Tree], bool] = lambda t: True,
    compared: str = "all trees",
) -> StartingResult:
    """Decide through which order a starting method agrees with the exact starting series.

    Parameters
    ----------
    method : Method
        The method that is started.
    starting : Method
        The starting method; its ``B`` has one row for each value of the component.
    max_order : int or None
        Largest order looked at; the order of the method when ``None``.
    principal : Principal or None
        ``"free"``: any member of the family will do; ``"identity"``: the output must be the
        solution itself. By default free for one component; the outputs of several are the solution,
        since no finishing method follows.
    known : OrderResult or None
        What :func:`order_of` returned for the method, so that it is not computed again; its kind of
        principal part is taken.
    counts : Callable[[Tree], bool]
        Which trees are compared.
    compared : str
        The same in words.

    Raises
    ------
    UsageError
        When the number of values differs.
    """
    wanted = tuple(len(c.V) for c in method.components)
    given = tuple(len(c.V) for c in starting.components)
    if given != wanted or any(len(c.B) != len(c.V) for c in starting.components):
        raise UsageError(
            f"a starting method for {' and '.join(map(str, wanted))} values must have as many rows "
            f"in `B` and entries in `u`, got {' and '.join(map(str, given))}"
        )
    principal = principal or ("free" if len(wanted) == 1 else "identity")
    result = known or order_of(method, max_order=max_order, principal=principal)
    exact = result.proof is Proof.EXACT and starting.is_exact
    proof = Proof.EXACT if exact else Proof.ENCLOSED
    if result.eta is None:
        return StartingResult(-1, residual=Exact(1), proof=proof)
    series = starting_series(starting, result.order, like=method)
    found = _compare(result, series, proof, counts)
    return replace(found, compared=compared)


def _compare(
    result: OrderResult, series: Series, proof: Proof, counts: Callable[[Tree], bool]
) -> StartingResult:
    """Compare a vector-valued series with the family of starting series, order by order."""
    eta, p, free = result.eta, result.order, result.principal == "free"
    assert eta is not None
    output = {colour: sparse((w,)) for colour, w in result.outputs.items()}
    ahead: Any = 0
    if free:
        first = next(iter(eta.palette))
        (ahead,) = apply(output[first], _difference(series, eta, single(first)))
        if is_zero(ahead) is not True:
            eta = shift(eta, ahead)
    known: dict[str, Any] = {"proof": proof, "method_order": p, "shift": as_scalar(ahead)}
    largest = 0.0
    for colour in eta.palette:
        start = plus(series.empty(colour), times(-1, eta.empty(colour)))
        place = _first_nonzero(start)
        if place is not None:
            known.update(component=place + 1, residual=as_scalar(start[place]))
            return StartingResult(-1, **known)
    for q in range(1, p + 1):
        for t in filter(counts, trees(q, eta.palette)):
            difference = _difference(series, eta, t)
            if q == p and free:
                (along,) = apply(output[t.colour], difference)
                principal = times(along, eta.empty(t.colour))
                difference = plus(difference, times(-1, principal))
            place = _first_nonzero(difference)
            if place is not None:
                known.update(component=place + 1, residual=as_scalar(difference[place]))
                return StartingResult(q - 1, failing_tree=t, largest_residual=largest, **known)
            largest = max(largest, *(as_scalar(x).magnitude() for x in difference))
    return StartingResult(p, largest_residual=largest, **known)


def zero_start_order(result: OrderResult) -> tuple[int, str]:
    """To which order the start u y_0, (y_0, 0, ..) as a rule, agrees with the starting series.

    Parameters
    ----------
    result : OrderResult
        Its order with ``principal="identity"``, with the starting series.

    Returns
    -------
    tuple[int, str]
        The largest q, not above the order, with zeta(t) = 0 for 0 < |t| <= q; and one sentence that
        names the first tree where it is not.
    """
    for t in sorted(result.eta or {}, key=lambda t: t.order):
        values = () if result.eta is None else result.eta[t]
        if t.order and is_zero(values) is False:
            return t.order - 1, f"a carried value starts with a term of {t}"
    return result.order, "every carried value starts with zero"


def _difference(series: Series, eta: Series, t: Tree) -> tuple[Any, ...]:
    return tuple(plus(x, times(-1, y)) for x, y in zip(series[t], eta[t], strict=True))


def _first_nonzero(vector: tuple[Any, ...]) -> int | None:
    return next((i for i, x in enumerate(vector) if is_zero(x) is False), None)


def finishing_order(
    method: GLM,
    finishing: FinishingMethod,
    *,
    starting: StartingMethod | None = None,
    max_order: int | None = None,
    known: OrderResult | None = None,
) -> StartingResult:
    """Decide through which order a finishing method undoes the start in the output.

    Parameters
    ----------
    method : GLM
        The method that is finished.
    finishing : FinishingMethod
        Acts on the output.
    starting : StartingMethod or None
        The starting method used with it: finishing right after it must give y back. When ``None``,
        the exact starting series is taken, any member of its family.
    max_order : int or None
        Largest order looked at; the order of the method when ``None``.
    known : OrderResult or None
        What :func:`order_of` returned for the method with a free principal part, so that it is not
        computed again.

    Raises
    ------
    UsageError
        When the output of the starting method is not y, so that there is nothing to finish.
    """
    result = known or order_of(method, max_order=max_order or MAX_ORDER - 1)
    enclosed = result.proof is Proof.ENCLOSED or not finishing.is_exact
    if result.eta is None:
        return StartingResult(-1, residual=Exact(1))
    p, output = result.order, result.outputs["o"]
    row = sparse((output,))
    if starting is None:
        first = result.eta.map(lambda x: apply(row, x)[0])
    else:
        enclosed = enclosed or not starting.is_exact
        weights = linalg.vecmat(output, starting.B)
        first = elementary_weights(starting.A, weights, p, u=linalg.dot(output, starting.u))
    if is_zero(plus(first.empty(), -1)) is False:
        raise UsageError(
            "a finishing method needs an output that starts from y itself, w u = 1 for the u of "
            "the starting method"
        )
    first = Series(dict(first), 1, p)
    finish = finishing_series(finishing, p)
    ahead: Any = 0
    if starting is None:  # the member of the family that runs ahead by what the finish goes back
        ahead = times(-1, plus(first[single()], finish[single()]))
        first = shift(first, ahead)
    both = compose(first, finish)
    proof = Proof.ENCLOSED if enclosed else Proof.EXACT
    record: dict[str, Any] = {"proof": proof, "method_order": p, "shift": as_scalar(ahead)}
    largest = 0.0
    for t in both:
        if t.order == p and starting is None:
            continue  # the free principal part makes up for any difference
        if is_zero(both[t]) is False:
            record.update(component=1, residual=as_scalar(both[t]), largest_residual=largest)
            return StartingResult(t.order - 1, failing_tree=t, **record)
        largest = max(largest, as_scalar(both[t]).magnitude())
    return StartingResult(p, largest_residual=largest, **record)
