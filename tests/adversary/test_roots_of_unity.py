"""Files in roots of unity of several orders: what is zero is written so that no single field shows it."""

from pathlib import Path
from typing import Any

import pytest

from glmref.findings import Verdict
from tests.adversary.deceive import doc, findings, shipped
from tests.adversary.test_verdicts_have_certificates import without_a_certificate

HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN
TINY = "+1/1" + "0" * 80
#: Zeros, each of another field.
ZEROS = (
    "1+" + "+".join(f"exp({2 * k}*pi*i/7)" for k in range(1, 7)),
    "exp(2*pi*i/5)+exp(-2*pi*i/5)-(sqrt(5)-1)/2",
    "root(2,3)*root(4,3)*exp(2*pi*i/7)*exp(12*pi*i/7)-2",
    "exp(2*pi*i/9)+exp(8*pi*i/9)+exp(14*pi*i/9)",
    "exp(2*pi*i/7)+exp(4*pi*i/7)+exp(8*pi*i/7)-(i*sqrt(7)-1)/2",
    "exp(2*pi*i/5)*exp(2*pi*i/7)*exp(-2*pi*i/5)-exp(2*pi*i/7)",
)


def diagonal(*entries: str) -> list[list[str]]:
    return [[x if i == j else "0" for j in range(len(entries))] for i, x in enumerate(entries)]


def judged(claims: dict[str, Any], tmp_path: Path, **keys: Any) -> dict[str, Verdict]:
    """The verdicts; each must have a certificate that the checker accepts."""
    d = doc("glm", claims, field="complex", **keys)
    found = {claim: x.verdict for claim, x in findings(d).items()}
    assert without_a_certificate(d, tmp_path) == []
    return found


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "zero", [*ZEROS[:3], *(pytest.param(x, marks=pytest.mark.slow) for x in ZEROS[3:])]
)
def test_a_growth_parameter_that_is_zero_and_one_that_nearly_is(zero: str, tmp_path: Path) -> None:
    for add, free in (("", True), (TINY, False)):
        keys: dict[str, Any] = {
            "A": [["1/2"]], "U": [["1", "1"]], "B": [["1"], [zero + add]], "V": diagonal("1", "-1"),
        }  # fmt: skip
        claims = {"order": 2 if free else 1, "parasitism-free": free, "zero-stable": True}
        assert set(judged(claims, tmp_path, **keys).values()) == {HOLDS}


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("first", "second", "bounded"),
    [
        ("exp(2*pi*i/5)", "exp(2*pi*i/15)*exp(4*pi*i/15)", False),
        ("exp(2*pi*i/5)", "exp(2*pi*i/15)*exp(4*pi*i/15)*exp(2*pi*i/29)", True),
        ("exp(2*pi*i/7)", "exp(2*pi*i/21)*exp(4*pi*i/21)", False),
        ("exp(2*pi*i/7)", "exp(2*pi*i/5)", True),
        ("exp(2*pi*i/9)*exp(4*pi*i/9)", "(i*sqrt(3)-1)/2", False),
        ("exp(2*pi*i/7)", "exp(2*pi*i/7)+1/1" + "0" * 80, False),  # its modulus is above 1
    ],
)
def test_equal_eigenvalues_written_in_two_ways(first, second, bounded, tmp_path):
    V = diagonal("1", first, second)
    V[1][2] = "1"
    keys: dict[str, Any] = {
        "A": [["1/2"]],
        "U": [["1", "0", "0"]],
        "B": [["1"], ["0"], ["0"]],
        "V": V,
    }
    for claim in (True, False):
        d = doc("glm", {"zero-stable": claim}, field="complex", **keys)
        found = findings(d)["zero-stable"]
        if "degree" in found.witness:  # of a field that no certificate writes out
            assert found.verdict is OPEN and "29" in second
            continue
        assert found.verdict is (HOLDS if claim is bounded else FAILS)


@pytest.mark.parametrize("times", [1, 2])
def test_seventh_roots_of_unity_of_a_multistep_method_once_and_twice(times: int) -> None:
    """rho = z^7 - 1 and (z^7 - 1)^2; sigma with sigma(1) = rho'(1), for which it is consistent."""
    rho = ["-1", *["0"] * 6, "1"] if times == 1 else ["1", *["0"] * 6, "-2", *["0"] * 6, "1"]
    d = doc("lmm", {"zero-stable": True}, alpha=rho, beta=[*["0"] * (len(rho) - 2), "7", "0"])
    assert findings(d)["zero-stable"].verdict is (HOLDS if times == 1 else FAILS)


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    "name", ["lobatto-iiia-4", "lobatto-iiib-4", "lobatto-iiic-4", "ralston-4"]
)
def test_a_square_root_as_a_sum_of_roots_of_unity(name: str) -> None:
    """sqrt(5) is Gauss's sum of order 5; 1e-80 beside it is no order."""
    gauss = "(1+2*exp(2*pi*i/5)+2*exp(8*pi*i/5)%s)"
    plain = {claim: x.verdict for claim, x in findings(shipped(name)).items()}
    for add in ("", TINY):
        d = shipped(name)
        for key in ("A", "b"):
            d[key] = [
                [x.replace("sqrt(5)", gauss % add) for x in row] if isinstance(row, list)
                else row.replace("sqrt(5)", gauss % add) for row in d[key]
            ]  # fmt: skip
        found = {claim: x.verdict for claim, x in findings(d).items()}
        if add:
            assert found["order"] is FAILS
        else:
            assert found == plain
