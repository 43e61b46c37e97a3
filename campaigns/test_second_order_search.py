"""The search for methods without parasitic growth of second order: its conditions, its record."""

from fractions import Fraction

import numpy as np
import pytest

from campaigns.order8_search import SEED, SOLVED, STARTS, start_of
from campaigns.pages import measured
from campaigns.second_order_search import ANSATZES, attempt_case, second_order
from glmref.derive.ansatz import Ansatz
from glmref.derive.search import search
from glmref.exact import ball
from glmref.exact.judging import as_number, as_scalar, consulted, over_scalars
from glmref.prove.enclosure import conditions_of

RECORD = measured("second-order-search")["ansatzes"]


def test_the_record_has_a_row_for_each_ansatz():
    said = [(x["order"], x["stages"], len(x["eigenvalues"]), x["I1"]) for x in RECORD]
    assert said == [(order, s, len(values), I1) for order, s, values, _, I1 in ANSATZES]


def _growth(equations, point):
    """Largest |coefficient of z^3| in log(lambda/zeta) at the parasitic eigenvalues."""
    with consulted():
        m = equations.at([as_number(ball(Fraction(x))) for x in point]).part("o")
        A, U, B, V = (
            np.array([[float(as_scalar(x)) for x in row] for row in block])
            for block in (m.A, m.U, m.B, m.V)
        )
    z, one = 0.02, np.eye(len(A))

    def logs(z):
        found = np.linalg.eigvals(V + z * B @ np.linalg.solve(one - z * A, U))
        return np.array([np.log(found[np.argmin(abs(found - zeta))] / zeta) for zeta in zetas])

    zetas = [x for x in np.linalg.eigvals(V) if abs(x - 1) > 1e-6]
    return np.max(abs((logs(z) - logs(-z)).real / (2 * z**3)))


@pytest.mark.slow
def test_what_is_solved_has_no_growth_of_second_order():
    order, stages, values, explicit, both = ANSATZES[2]
    equations = conditions_of(Ansatz("x", stages, order, values, explicit=explicit).document())
    more, size = second_order(equations, both=both), len(equations.unknowns)

    def solution(residuals):
        ends = search(over_scalars(residuals), start_of(size), seed=SEED, starts=STARTS)
        return next(x.point for x in ends if x.residual < SOLVED)

    assert _growth(equations, solution(lambda x: [*equations.residuals(x), *more(x)])) < 1e-3
    assert _growth(equations, solution(equations.residuals)) > 1e-2


@pytest.mark.slow
def test_a_row_repeats():
    assert attempt_case({"ansatz": 0}) == RECORD[0]
