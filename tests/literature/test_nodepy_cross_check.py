"""Every Runge-Kutta method that nodepy ships gets the same order from us.

nodepy (Ketcheson, Ranocha, Parsani, bin Waheed and Hadjimichael, "NodePy: A package for the
analysis of numerical ODE solvers", JOSS 5 (2020) 2515) has its own order conditions, so that the
two agree only where both are right. Its tables are exact (sympy) or doubles; exact ones are
compared exactly.
"""

import re
from typing import Any

import pytest

from glmref.exact import Ball, Scalar
from glmref.exact.expression import parse
from glmref.method import GLM
from glmref.method.families import runge_kutta
from glmref.theory.order import order_of

pytestmark = pytest.mark.peers

#: Doubles carry 15 digits; the published decimals behind some of them have 13.
DIGITS, TOLERANCE = 13, 1e-11


def tables() -> dict[str, Any]:
    rk = pytest.importorskip("nodepy").rk
    return rk.loadRKM()


def is_double(x: Any) -> bool:
    """Whether an entry is a floating-point number, of numpy or of sympy."""
    return isinstance(x, float) or bool(getattr(x, "is_Float", False))


def scalar(x: Any, *, doubles: bool) -> Scalar:
    """Entry of a nodepy table as one of our numbers."""
    text = str(x).replace(" ", "")
    if doubles:
        return Ball.decimal(f"{float(x):.16f}", DIGITS)
    if re.fullmatch(r"(?:[-+*/()0-9]|sqrt)+", text) and "**" not in text:
        return parse(text)
    return Ball.decimal(str(x.evalf(45)), 40)


def ours(table: Any) -> GLM:
    """Our method: exact, unless one entry of the table is a double; then all are taken as such.

    A fraction beside doubles is an approximation too: the weights of CMR6 sum to 1 within 1e-17 and
    not exactly, so that its order, taken literally, is 0.
    """
    entries = [x for row in table.A for x in row] + list(table.b)
    doubles = any(is_double(x) for x in entries)
    A = [[scalar(x, doubles=doubles) for x in row] for row in table.A]
    return runge_kutta(A, [scalar(x, doubles=doubles) for x in table.b])


@pytest.mark.slow
def test_every_runge_kutta_method_of_nodepy_gets_the_same_order_from_us() -> None:
    different = {}
    exact = 0
    for name, table in tables().items():
        method = ours(table)
        exact += method.is_exact
        found = order_of(method, principal="identity").order
        theirs = table.__num__().order(tol=TOLERANCE)
        if found != theirs:
            different[name] = (found, theirs)
    assert different == {}
    assert exact >= 30


@pytest.mark.slow
def test_a_changed_entry_changes_both_orders() -> None:
    table = tables()["RK44"]
    table.b = table.b.copy()
    table.b[0], table.b[3] = table.b[0] * 2, table.b[3] * 0
    assert order_of(ours(table), principal="identity").order == table.__num__().order() < 4
