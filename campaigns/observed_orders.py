"""The order that runs show, for every method that claims one: the second witness, stored.

``order`` of a one-step method, and ``order-identity`` of any, is the order of the solution itself;
``order`` of a method with several values whose identity costs order, and ``effective-order``, is
what start and finish can reach, seen where a conjugation drops out (see
:mod:`glmref.measure.convergence`).

    python -m campaigns.observed_orders data/measurements/observed-orders.json

measures what the file lacks: a method that is new, or whose coefficients or orders have changed.
"""

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from campaigns.driver import ORDERS, arguments, fingerprint, head_of, renew
from glmref.catalogue.lookup import document, load, names
from glmref.measure.convergence import ConvergenceRecord, effective_order, isochronous, method_order
from glmref.method import Method, PartitionedGLM
from glmref.problems import problem
from glmref.problems.model import Problem

#: Claims that are seen in runs.
KINDS = ORDERS


@dataclass(frozen=True)
class Case:
    """A method and one of its claims of order."""

    method: str
    claim: str
    order: int


def cases() -> Iterator[Case]:
    """Yield every claim of an order of 1 or more.

    An order with identity that equals it stands once.

    The problems have one right-hand side: additive methods are seen in tests/unit/test_additive.py,
    and no engine steps Rosenbrock methods.
    """
    for name in names("methods"):
        if document(name)["class"] in ("additive", "rosenbrock"):
            continue
        claims = document(name)["claims"]
        for claim in KINDS:
            order = claims.get(claim)
            same = claim == "order-identity" and order == claims.get("order")
            if isinstance(order, int) and order >= 1 and not same:
                yield Case(name, claim, order)


def nonlinear(method: Method) -> Problem:
    """Return the problem on which the order of a solution is seen.

    Both halves of a pair need nonlinear functions, or too many trees vanish.
    """
    pair = isinstance(method, PartitionedGLM)
    return problem("lotka-volterra-logarithmic") if pair else isochronous()


def own_order(method: Method) -> int | None:
    """Return order claimed of the solution itself, or ``None`` where only an effective one is."""
    one_step = method.is_one_step
    found = method.claims["order"] if one_step else method.claims.get("order-identity")
    return found if isinstance(found, int) else None


def observe(case: Case) -> ConvergenceRecord:
    """Measure the order that a claim is about."""
    method = load(case.method)
    solution = case.claim == "order-identity" or (
        case.claim == "order" and own_order(method) == case.order
    )
    if solution:
        return method_order(method, nonlinear(method), expected=case.order)
    return effective_order(method, expected=case.order)


def row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Measure a case: its row of the file but for what says which case it is."""
    order = document(task["method"])["claims"][task["claim"]]
    found = observe(Case(task["method"], task["claim"], order))
    return {
        "proved": order,
        "observed": round(found.order, 4),
        "steps": found.steps[-1],
        "settled": found.settled,
    }


def main(path: Path) -> int:
    """Bring the file up to date and return how many cases were measured."""
    return renew(
        path,
        head_of(
            "observed_orders",
            "observed-orders",
            "Orders seen in runs, beside those that are proved",
            measured="Runs at doubled numbers of steps in extended precision on nonlinear "
            "problems, base-2 logarithms of ratios of differences, Richardson extrapolation until "
            "two agree to 0.01; steps: of the finest run. An order that a start and a finish can "
            "reach is seen after a period of an isochronous problem.",
        ),
        "orders",
        (
            {"method": x.method, "claim": x.claim, "fingerprint": fingerprint(x.method)}
            for x in cases()
        ),
        row,
    )


if __name__ == "__main__":
    sys.stdout.write(f"measured {main(Path(arguments(sys.argv[1:])[0]))}\n")
