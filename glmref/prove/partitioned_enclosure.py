"""What the interval test proves of a pair, from its file alone.

:func:`prove_pair` applies :func:`~glmref.prove.enclosure.krawczyk` to a file of class
``pair-sweep`` or ``splitting`` that names its equations, and says what follows:

1. *The solution.* The system of the file has exactly one root within ``radius`` of its digits,
   which are that root, rounded to nearest.
2. *G-symplectic* and *explicit* for every value of the unknowns (:mod:`.partitioned_sweep`);
   V^T G V^ = G is exact arithmetic.
3. *Symmetric* for every value of the unknowns: b, c, X and Y are palindromic as affine expressions.
4. *Order*: the equations vanish at the root; with 2 and 3 the theorems of :mod:`.pair_series` carry
   one tree of each free tree of odd order to all two-coloured trees. A splitting method that is
   not symmetric needs one of each free tree of every order (theorem 1; its starting series is
   zero).
5. *Parasitism-free*: mu_q and mu_p at every eigenvalue of V other than 1 are equations.
6. *Start*: :mod:`.pair_start`, where ``starting`` has unknowns of its own.

Redundant to all this, every residual up to the order, on all two-coloured trees, and both growth
parameters are balls around zero of width below :data:`WIDTH` over the enclosure of the root.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..catalogue.writer import DIGITS
from ..errors import DataError, ExactnessError
from ..exact import Ball, ball
from ..exact.expression import parse
from .enclosure import WIDTH, Krawczyk, Outcome, is_rounding, krawczyk, radius_of
from .partitioned_series import PairNumbers
from .partitioned_starting import pair_target, prove_pair_start, start_orders, start_system
from .partitioned_system import PairSystem
from .partitioned_trees import representatives

__all__ = ["PairEnclosure", "prove_pair"]


@dataclass(frozen=True)
class PairEnclosure:
    """A proof record.

    Attributes
    ----------
        values: enclosing ball of every unknown, by name.
        contraction: see :class:`~glmref.prove.enclosure.Krawczyk`.
        order: the order proved (a lower bound). nystrom_order: the same on second-order systems.
        identity: whether the first values are the solution itself, to that order.
        width: largest magnitude over all residuals up to the order and all growth parameters.
    """

    values: Mapping[str, Ball]
    contraction: float
    order: int
    nystrom_order: int
    identity: bool
    width: float
    numbers: PairNumbers = field(repr=False)


def prove_pair(document: Mapping[str, Any]) -> PairEnclosure:
    """Prove what a file of a pair with an ``"enclosure"`` claims, from the file alone.

    Args:
        document: the parsed JSON object.

    Raises
    ------
        DataError: when the file asks for more than its equations give.
        ExactnessError: when the interval test does not find exactly one root near the digits.
    """
    system = PairSystem(document)
    if not system.claimed and not system.claimed_nystrom:
        raise DataError("a file with an `enclosure` must claim an order of at least 1")
    symmetric = system.signs() is not None
    if not symmetric and not system.is_one_step:
        raise DataError(
            "`b`, `c`, `w`, `v` and `stages` must be palindromic, `w` and `v` up to a sign for "
            "each row, with V, V_hat and G to match: only then do the even orders follow"
        )
    wanted = ((system.claimed, False), (system.claimed_nystrom, True))
    for order, nystrom in wanted:
        _check_covered(
            system, range(1, order + 1, 2) if symmetric else range(1, order + 1), nystrom
        )
    root = _root(document, system)
    numbers, principal = system.read(dict(zip(system.unknowns, root.box, strict=True)))
    for name, weights in zip(system.names, (numbers.b, numbers.c), strict=True):
        for i, x in enumerate(weights):
            if ball(x).is_zero() is not False:
                raise ExactnessError(f"`{name}[{i + 1}]` may be zero")
    block = document.get("starting", {})
    started = bool(block) and bool(start_system(block).unknowns)
    all_series = [
        system.series(numbers, principal, order, nystrom=nystrom, starts=started)
        for order, nystrom in wanted
        if order
    ]
    growths = [system.growth(e.half, e.eigenvalue, numbers) for e in system.equations if e.half]
    residuals = [x for series in all_series for x in series.residual.values()]
    small = [ball(x) for x in (*residuals, *growths)]
    width = max(x.magnitude() for x in small)
    if not all(x.contains_zero() and x.magnitude() < WIDTH for x in small):
        raise ExactnessError(
            f"a redundant condition is not enclosed: the largest residual is {width:.3g}, and it "
            f"must be a ball around zero below {WIDTH}"
        )
    identity = all(
        system.identity_through(order - 1, nystrom=nystrom) for order, nystrom in wanted if order
    )
    if started:
        target = pair_target(system, all_series, start_orders(document["claims"], block))
        prove_pair_start(block, target, digits=document.get("digits", DIGITS))
    return PairEnclosure(
        values=dict(zip(system.unknowns, root.box, strict=True)),
        contraction=root.contraction,
        order=system.claimed,
        nystrom_order=max(system.claimed, system.claimed_nystrom),
        identity=identity,
        width=width,
        numbers=numbers,
    )


def _check_covered(system: PairSystem, orders: range, nystrom: bool) -> None:
    """Check that the equations give the conditions of these orders.

    Raises
    ------
        DataError: naming what is missing.
    """
    for n in orders:
        if not system.covered(n, nystrom=nystrom):
            trees = ", ".join(map(str, representatives(n, nystrom=nystrom)))
            raise DataError(
                f"the equations of the file do not give the conditions of order {n}; those of "
                f"{trees} would"
            )


def _root(document: Mapping[str, Any], system: PairSystem) -> Krawczyk:
    """Run the interval test around the digits of the file."""
    radius, digits = radius_of(document), document.get("digits", 75)
    if len(system.equations) != len(system.unknowns):
        raise DataError(
            f"`enclosure.equations` must be as many as the unknowns ({len(system.unknowns)}), "
            f"got {len(system.equations)}"
        )
    texts = [document["unknowns"][name] for name in system.unknowns]
    published = [ball(parse(x, digits=digits)) for x in texts]
    for e, x in zip(system.equations, system.residuals(published), strict=True):
        if ball(x).is_zero() is False:  # cheaper than the test below, which would say so too
            raise ExactnessError(
                f"{document.get('name', 'the file')}: the equation {e.text!r} is not satisfied "
                f"within the published digits"
            )
    result = krawczyk(system.residuals, published, radius)
    if result.outcome is not Outcome.UNIQUE:
        raise ExactnessError(
            f"{document.get('name', 'the file')}: the interval test gives {result.outcome!s} "
            f"within {document.get('enclosure', {}).get('radius')} of the digits ({result.witness})"
        )
    for name, x, y in zip(system.unknowns, published, result.box, strict=True):
        if not is_rounding(x, y, digits):
            raise ExactnessError(
                f"`unknowns.{name}` is not the root rounded to {digits} digits after the point"
            )
    return result
