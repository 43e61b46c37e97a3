"""What the rules of the kernel say in rare cases: bounds, labels and reasons, and not verdicts alone."""

from typing import Any

from glmref import load
from glmref.catalogue.reader import load_document
from glmref.findings import Verdict
from glmref.prove.kernel import Kernel
from tests.adversary.deceive import doc, findings

HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN
ONE = [["1", "0"], ["0", "1"]]


def found(claim: str, value: Any, kind: str = "glm", **keys: Any) -> Any:
    return findings(doc(kind, {claim: value}, **keys))[claim]


def test_a_pair_without_a_start_starts_exactly() -> None:
    """Every value starts as the multiple of y that u says: no decimals take part."""
    known = Kernel(load("stormer-verlet")).range("starting-order")
    assert known.exact


def test_no_growth_parameters_leave_no_residual() -> None:
    told = found("growth", [], "rk", A=[["1/2"]], b=["1"])
    assert (told.verdict, told.residual) == (HOLDS, 0.0)
    told = found("growth", [], A=[["0"]], U=[["1"]], B=[["1"]], V=[["0"]])
    assert (told.verdict, told.residual) == (HOLDS, 0.0)


def test_where_series_are_not_excluded_stages_have_order_1_at_least() -> None:
    two: dict[str, Any] = {"A": [["1/2", "0"], ["0", "1/2"]], "U": ONE, "B": ONE, "V": ONE}
    known = Kernel(load_document(doc("glm", {"order": 2}, **two))).range("stage-order")
    assert (known.lower, known.upper, known.value) == (1, None, 1)
