"""Files of rare kinds: what ``verify``, ``analyze``, a certificate and the checker say of each is the same.

Idle values, several u, poles on the axis and in stages that nothing uses, c apart, additive and
Rosenbrock methods with their parts exchanged, embedded rows alike, starts that are right but for
1e-50, integers of hundreds of digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.reader import load_document
from glmref.findings import Verdict
from glmref.prove.analysis import analyze

from .deceive import doc, findings, shipped
from .test_verdicts_have_certificates import without_a_certificate

TINY = f"1/1{'0' * 50}"
ONE = [["1", "0"], ["0", "1"]]
HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN
#: Claim -> what an analysis calls it.
SHOWN = {"explicit": "explicit", "preconsistent": "preconsistent", "consistent": "consistent",
         "zero-stable": "zero_stable", "order": "order", "w-order": "order_w"}  # fmt: skip


def glm(A: Any, U: Any, B: Any, V: Any, **keys: Any) -> dict[str, Any]:
    return doc("glm", {}, A=A, U=U, B=B, V=V, **keys)


def block(A: Any, U: Any, B: Any, V: Any) -> dict[str, Any]:
    return {"A": A, "U": U, "B": B, "V": V}


def changed(name: str, **keys: Any) -> dict[str, Any]:
    return {**shipped(name), "name": "deceiver", "format": "glmref-method-2", **keys}


def files() -> Iterator[tuple[str, dict[str, Any], dict[str, tuple[Any, Verdict]]]]:
    """Name, document, claim -> what is declared and the verdict."""
    double = glm([["0"]], [["1", "0"]], [["1"], ["1"]],
                 [["1", "0.50000000000000000000"], ["0", "0.99999999999999999999"]], digits=20)  # fmt: skip
    yield "a second eigenvalue within the digits of 1", double, {"zero-stable": (True, OPEN)}
    gap = glm([["0"]], [["1", "0"]], [["1"], ["0"]], [["1", "1/2"], ["0", f"1-{TINY}"]])
    yield "a second eigenvalue beside 1", gap, {"zero-stable": (True, HOLDS)}
    surd = glm([["0"]], [["1", "0"]], [["1"], ["0"]], [["1", "1"], ["0", "sqrt(2)*sqrt(2)/2"]])
    yield "a second eigenvalue 1 in surds", surd, {"zero-stable": (True, FAILS)}
    idle = glm([["0"]], [["1", "0", "0"]], [["1"], ["0"], ["0"]],
               [["1", "0", "0"], ["0", "-1", "0"], ["0", "0", "-1"]])  # fmt: skip
    yield "idle values", idle, {"zero-stable": (True, HOLDS), "order": (1, HOLDS),
                                "growth": ([], FAILS), "parasitism-free": (True, HOLDS)}  # fmt: skip
    twice = glm([["1/2"]], [["1/2", "1/2"]], [["1"], ["1"]], ONE)
    yield (
        "the midpoint rule carried twice",
        twice,
        {"order": (2, HOLDS), "symmetric": (True, HOLDS)},
    )
    poles = doc("rk", {}, A=[["0", "-1"], ["1", "0"]], b=["1/2", "1/2"])
    yield "poles at i and -i", poles, {"a-stable": (True, FAILS), "order": (1, HOLDS)}
    unused = [["1/2", "0", "0"], ["0", "0", "-1"], ["0", "1", "0"]]
    yield "poles of stages that are not used", doc("rk", {}, A=unused, b=["1", "0", "0"]), {
        "a-stable": (True, HOLDS), "l-stable": (True, FAILS), "order": (2, HOLDS),
    }  # fmt: skip
    for theta, stable in ((f"1/2-{TINY}", FAILS), (f"1/2+{TINY}", HOLDS)):
        claims = {"a-stable": (True, stable), "l-stable": (True, FAILS), "order": (1, HOLDS)}
        yield f"theta = {theta[:4]}", doc("rk", {}, A=[[theta]], b=["1"]), claims
    copied = glm([["1/2"]], [["1", "0"]], [["1"], ["1"]], ONE)
    yield "1 as an eigenvalue of every M(z)", copied, {"a-stable": (True, HOLDS)}
    chain = glm([["1/2", "0"], ["0", "1/2"]], ONE, [["1", "0"], ["1", "1"]], ONE)
    yield "M(z) defective for all z but 0", chain, {"zero-stable": (True, HOLDS),
                                                    "a-stable": (True, FAILS)}  # fmt: skip
    apart = changed("rk4", c=["0", "1/2", f"1/2+{TINY}", "1"])
    yield "c apart", apart, {"order": (4, FAILS), "row-sums": (True, FAILS)}
    parts = shipped("ars-2-2-2")["parts"]
    nine = doc("additive", {}, parts=[parts[0]] * 9)
    yield "nine equal parts", nine, {"order": (2, HOLDS), "explicit": (True, HOLDS)}
    swapped = [{"A": parts[0]["A"], "b": parts[1]["b"]}, {"A": parts[1]["A"], "b": parts[0]["b"]}]
    yield (
        "weights of the parts exchanged",
        doc("additive", {}, parts=swapped),
        {"order": (2, HOLDS)},
    )
    rows = [{"name": "x", "b": ["1/6", "1/3", "1/3", "1/6"]},
            {"name": "y", "error": ["0", "0", "0", TINY]}]  # fmt: skip
    yield "a row like b, and an estimate of 1e-50", changed("rk4", embedded=rows), {
        "embedded-order": ({"x": 4, "y": 4}, FAILS), "embedded-difference": (True, FAILS),
    }  # fmt: skip
    yield "Rosenbrock without gamma", changed("ros2", gamma=[["0", "0"], ["0", "0"]]), {
        "order": (2, HOLDS), "w-order": (2, HOLDS), "a-stable": (True, FAILS),
    }  # fmt: skip
    start = {"A": [["0"]], "B": [[TINY]], "u": ["1"]}
    yield "a start that is 1e-50 late", changed("gauss-2", starting=start), {
        "order": (4, HOLDS), "starting-order": (4, FAILS),
    }  # fmt: skip
    huge = ["1/6", "1/3", "1/3", f"1/6+1/{'9' * 900}"]
    yield "a denominator of 900 digits", changed("rk4", b=huge), {"order": (4, FAILS)}
    q = block([["0"]], [["1", "1"]], [["1"], ["1"]], [["1", "0"], ["0", "-1"]])
    for name, p, free in (
        ("fed", block([["1/2"]], [["1", "1"]], [["1"], ["1"]], q["V"]), FAILS),
        ("idle in one half", block([["1/2"]], [["1", "0"]], [["1"], ["0"]], q["V"]), HOLDS),
    ):
        pair = doc("partitioned", {}, q=q, p=p, separable=True)
        claims = {"parasitism-free": (True, free), "zero-stable": (True, HOLDS)}
        yield f"an eigenvalue -1 of both halves, {name}", pair, claims


FILES = {name: (d, claims) for name, d, claims in files()}


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", FILES)
def test_all_say_the_same_of_a_rare_file(name: str, tmp_path: Path) -> None:
    d, claims = FILES[name]
    d = {**d, "claims": {claim: declared for claim, (declared, _) in claims.items()}}
    found, shown = findings(d), analyze(load_document(d))
    assert {c: x.verdict for c, x in found.items()} == {c: x for c, (_, x) in claims.items()}
    for claim in claims.keys() & SHOWN.keys():
        if found[claim].verdict is not OPEN:
            value = found[claim].value
            # decimals of 50 places count as rounded: what holds of the numbers themselves is said, too
            within = claim == "order" and f"order {value} exactly" in str(shown.order_witness)
            assert getattr(shown, SHOWN[claim]) == value or within, claim
    assert without_a_certificate(d, tmp_path) == []
