"""Files whose numbers are spelled oddly or in decimals: verdicts, and certificates."""

from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.reader import load_document
from glmref.prove.analysis import analyze

from .deceive import doc, findings, shipped
from .test_verdicts_have_certificates import rounded, without_a_certificate

EULER = {"A": [["0"]], "b": ["1"]}
ONE = (
    "2/2", "-(-1)", "sqrt(1)", "root(8,3)/2", "-i*i", "exp(0)", "-exp(pi*i)", "exp(2*i*pi)", "sqrt(4)/2",
    "exp(2*pi*i/3)+exp(4*pi*i/3)+2", "sqrt(3-2*sqrt(2))+2-sqrt(2)", "root(2,5)*root(16,5)/2",
    "01", "2/002", "\t1", "1\n/1", "sqrt(04)/2", "root(08,03)/2", "exp(02*pi*i/01)", "sqrt(\f2)*sqrt(02)/2",
)  # fmt: skip


@pytest.mark.sampled(5)
@pytest.mark.parametrize("text", ONE)
def test_one_is_one_however_it_is_written(text: str, tmp_path: Path) -> None:
    d = doc("rk", {"order": 1, "consistent": True}, **{**EULER, "b": [text]})
    assert {str(x.verdict) for x in findings(d).values()} == {"holds"}
    assert without_a_certificate(d, tmp_path) == []


@pytest.mark.parametrize(
    ("V", "keys"), [([["1.000"]], {"digits": 3}), ([["1", "1"], ["0", "1"]], {})]
)
def test_an_undecided_eigenvalue_one_is_no_refusal_to_analyze(V: Any, keys: Any) -> None:
    r = len(V)
    U, B = [["1", *["0"] * (r - 1)]], [["1"], *[["0"]] * (r - 1)]
    found = analyze(load_document(doc("glm", {}, A=[["0"]], U=U, B=B, V=V, **keys)))
    assert list(found.order_proved) == [0, None]


@pytest.mark.slow
def test_a_table_with_its_c_in_decimals_says_how_many_digits_hold() -> None:
    d = rounded(shipped("sharp-verner-7-6"), 33)
    d["claims"] = {"order": 7}
    assert "order 7 to 1" in analyze(load_document(d)).order_witness
