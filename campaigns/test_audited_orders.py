"""The orders that tables of the audit show in runs, and their place in docs/audit/tables.md."""

import pytest

from campaigns.audited_orders import PAGE, STEPS, errors_of, observed
from campaigns.pages import measured
from glmref.conformance.vector_problems import problems
from tests.suite.real_defects import DEFECTS, mended, published

ROWS = {row["table"]: row for row in measured("audit-orders")["rows"]}
#: Tables whose defect is no larger than the errors of a run: exact conditions only show it.
HIDDEN = {"diffrax-kencarp5", "sciml-sir54", "tudat-rkf89", "rklib-rks5", "nodepy-ssp53",
          "petsc-glee25i", "rklib-rk8-10"}  # fmt: skip
#: Their order is the declared one; what is wrong are the times of their stages.
TIMES = {"petsc-4l", "petsc-grk4t", "petsc-shamp4", "petsc-veldd4"}


def test_the_sentence_of_the_page_is_that_of_the_record():
    page = PAGE.read_text("utf-8")
    assert set(ROWS) == set(DEFECTS)
    at = STEPS.index(16)
    more = [ROWS[x]["shipped"][at] / ROWS[x]["corrected"][at] for x in TIMES]
    assert round(max(more)) == 5
    assert "have the order 4 for any a2, and at h = 1/16 errors up to five times as large" in page


@pytest.mark.parametrize("name", sorted(set(DEFECTS) - HIDDEN - TIMES))
def test_a_run_shows_the_order_that_the_conditions_say(name):
    row, entry = ROWS[name], DEFECTS[name]
    seen = observed(row["shipped"])
    assert seen is not None and seen < float(entry["declared"]) - 0.5
    assert abs(seen - entry["found"]) < 0.7
    if "corrected" in row:
        right = observed(row["corrected"])
        assert right is None or right > float(entry["declared"]) - 0.5


@pytest.mark.parametrize("name", ["petsc-bpr3", "nodepy-lambert65"])
def test_the_record_can_be_measured_again(name):
    row = ROWS[name]
    problem = problems()[row["problem"]].problem
    for integrator, key in ((published(name), "shipped"), (mended(name), "corrected")):
        found = errors_of(integrator, name, problem)
        assert found == pytest.approx(row[key], rel=1e-3, abs=1e-14)


def test_the_order_is_observed_above_round_off_only():
    assert observed([1.0, 0.5, 0.25]) == pytest.approx(1)
    assert observed([8e-12, 1e-12, 1e-15]) == pytest.approx(3)
    assert observed([1e-3, 1e-15]) is None
    assert observed([float("inf"), 1e-2, 1e-4]) == pytest.approx(6.6439, abs=1e-4)
    assert len(STEPS) == len(ROWS["petsc-bpr3"]["shipped"])
