"""What the rules of the kernel say in rare cases: bounds, labels and reasons, and not verdicts alone."""

from typing import Any

import pytest

from glmref import load
from glmref.catalogue.reader import load_document
from glmref.findings import Proof, Verdict
from glmref.prove.kernel import Kernel
from tests.adversary.deceive import doc, findings

HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN
ONE = [["1", "0"], ["0", "1"]]


def found(claim: str, value: Any, kind: str = "glm", **keys: Any) -> Any:
    return findings(doc(kind, {claim: value}, **keys))[claim]


@pytest.mark.parametrize("claim", ["starting-order", "finishing-order"])
def test_of_a_start_or_finish_that_is_not_there_the_order_is_0(claim: str) -> None:
    known = Kernel(load("rk4")).range(claim)
    assert (known.lower, known.upper, known.exact) == (0, 0, True)


def test_a_pair_without_a_start_starts_exactly() -> None:
    """Every value starts as the multiple of y that u says: no decimals take part."""
    known = Kernel(load("stormer-verlet")).range("starting-order")
    assert known.exact


def test_abscissae_are_those_of_the_value_that_the_output_reads() -> None:
    """The second value is y(x + 1/2): read it as y and every abscissa is earlier by 1/2."""
    shifted: dict[str, Any] = {
        "A": [["0"]], "U": [["1", "0"]], "B": [["1"], ["3/2"]], "V": [["1", "0"], ["1", "0"]],
    }  # fmt: skip
    for output, c in ((["1", "0"], "0"), (["0", "1"], "-1/2")):
        assert found("abscissae", [c], output=output, **shifted).verdict is HOLDS
        other = "-1/2" if c == "0" else "1/2"
        assert found("abscissae", [other], output=output, **shifted).verdict is FAILS


def test_a_method_that_is_not_consistent_has_no_abscissae_exactly() -> None:
    none: dict[str, Any] = {
        "A": [["0"]], "U": [["1", "0"]], "B": [["0"], ["1"]], "V": [["1", "1"], ["0", "1"]],
    }  # fmt: skip
    told = found("abscissae", ["0"], **none)
    assert (told.verdict, told.proof) == (FAILS, Proof.EXACT)
    assert told.witness == "the method has no abscissae"


def test_abscissae_that_are_not_unique_are_not_refuted() -> None:
    """V = I: each value may be moved along the flow for itself."""
    two: dict[str, Any] = {"A": [["1/2", "0"], ["0", "1/2"]], "U": ONE, "B": ONE, "V": ONE}
    assert found("abscissae", ["1/2", "1/3"], **two).verdict is OPEN


def test_a_formula_without_an_error_constant() -> None:
    """sigma(1) = 0."""
    told = found("error-constant", "0", "lmm", alpha=["-1", "1"], beta=["1", "-1"])
    assert (told.verdict, told.proof) == (FAILS, Proof.EXACT)
    assert told.witness == "the method has no error constant"


def test_no_growth_parameters_leave_no_residual() -> None:
    told = found("growth", [], "rk", A=[["1/2"]], b=["1"])
    assert (told.verdict, told.residual) == (HOLDS, 0.0)
    told = found("growth", [], A=[["0"]], U=[["1"]], B=[["1"]], V=[["0"]])
    assert (told.verdict, told.residual) == (HOLDS, 0.0)


def test_consistency_within_digits_is_enclosed() -> None:
    """B 1 in decimals is 2 and not 1."""
    told = found("consistent", False, "rk", A=[["0.50"]], b=["2.00"], digits=2)
    assert (told.verdict, told.proof) == (HOLDS, Proof.ENCLOSED)


def test_a_pole_that_only_the_last_entry_has_is_a_pole() -> None:
    """M(z) is diagonal: (1 + z/2)/(1 - z/2), 0, and 1/(1 + z), of modulus 1 at most on the axis."""
    A = [["1/2", "0", "0"], ["0", "-1/2", "1/2"], ["0", "1/2", "-1/2"]]
    U = [["1", "0", "0"], ["0", "0", "1"], ["0", "0", "0"]]
    B = [["1", "0", "0"], ["0", "0", "0"], ["0", "-1", "1"]]
    V = [["1", "0", "0"], ["0", "0", "0"], ["0", "0", "1"]]
    told = found("a-stable", False, A=A, U=U, B=B, V=V)
    assert (told.verdict, told.proof) == (HOLDS, Proof.EXACT)
    assert "pole in the left half-plane" in told.witness


def test_where_series_are_not_excluded_stages_have_order_1_at_least() -> None:
    two: dict[str, Any] = {"A": [["1/2", "0"], ["0", "1/2"]], "U": ONE, "B": ONE, "V": ONE}
    known = Kernel(load_document(doc("glm", {"order": 2}, **two))).range("stage-order")
    assert (known.lower, known.upper, known.value) == (1, None, 1)
