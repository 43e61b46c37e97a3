"""Certificates made by hand that prove nothing: the checker refuses every one."""

from fractions import Fraction
from typing import Any

import pytest

from glmref import judge
from glmref.catalogue.reader import load_document
from glmref.findings import Verdict
from glmref.judge.arithmetic import PLACES
from glmref.judge.numbers import around
from glmref.judge.refusals import NotShown
from glmref.judge.series import Solved
from glmref.judge.towers import Tower
from glmref.prove.verifier import facts_for
from tests.build import SOURCE, tower_of_root

HEAD = {"format": "glmref-method-1", "name": "x"}
#: The generator 2 with the polynomial x^2 - 4: g1 - 2 is 0, and does not reduce to 0.
TWO = tower_of_root(4, "1", "3")
NIL = "sqrt(4)-2"
#: g1 = 7 x + 3/100 x^2 - 5 x^3 is real for x = root(2, 4), and has nearly the real part of its value
#: at i x, which stands as its conjugate: sqrt(2) would have the conjugate -sqrt(2).
ASTRAY = {
    "kind": "tower",
    "generators": [
        {
            "name": "g1",
            "polynomial": ["-37399919/25000000", "-594/25", "699991/2500", "0"],
            "real": ["-1/20", "-7/200"],
            "imag": ["0", "0"],
            "conjugate": (
                "-577537125/13613200009+699973/27226400018*g1-4125000/13613200009*g1*g1"
                "+2500/13613200009*g1*g1*g1+3430810261817/408396000270*g2"
                "-5390378949109/27226400018*g1*g2-1224906500/40839600027*g1*g1*g2"
                "-9625247500/13613200009*g1*g1*g1*g2"
            ),
        },
        {
            "name": "g2",
            "polynomial": ["1", "0"],
            "real": ["-1/4", "1/4"],
            "imag": ["3/4", "5/4"],
            "conjugate": "-g2",
        },
    ],
    "radicals": {
        "sqrt(2)": (
            "19251237500/13613200009-34998650/40839600027*g1+137500000/13613200009*g1*g1"
            "-250000/40839600027*g1*g1*g1"
        ),
        "i": "g2",
    },
}
Parts = list[tuple[str, dict[str, Any]]]


def glm(A: Any, U: Any, B: Any, V: Any, **more: Any) -> dict[str, Any]:
    return {"class": "glm", "A": A, "U": U, "B": B, "V": V, **more}


def rk(A: Any, b: Any, **more: Any) -> dict[str, Any]:
    return {"class": "rk", "A": A, "b": b, **more}


def pair(q: dict[str, Any], p: dict[str, Any], separable: bool) -> dict[str, Any]:
    q, p = ({k: x for k, x in d.items() if k != "class"} for d in (q, p))
    return {"class": "partitioned", "separable": separable, "q": q, "p": p}


def certificate(
    d: dict[str, Any], claim: str, declared: Any, verdict: str, parts: Parts
) -> dict[str, Any]:
    fields = {"sqrt(4)": TWO, "sqrt(2)": ASTRAY}
    field = next((x for text, x in fields.items() if text in str(d)), {"kind": "rational"})
    return {
        "format": "glmref-certificate-1",
        "statement": {"method": "x", "claim": claim, "declared": declared, "verdict": verdict,
                      "proof": "exact"},
        "document": {**HEAD, **d, "claims": {claim: declared}},
        "field": field, "identities": [],
        "parts": [{"rule": rule, "witness": witness} for rule, witness in parts],
    }  # fmt: skip


EULER = rk([["0"]], ["1"])
MIDPOINT = rk([[f"1/2+{NIL}"]], ["1"])
LMM = {"class": "lmm", "alpha": ["sqrt(4)-3", "1"], "beta": ["1", "0"]}
#: V has the eigenvalue 1 twice; the second value is seen by the stage.
FREE = glm([["0"]], [["1", "1"]], [["1"], ["0"]], [["1", "0"], ["0", "1"]])
ONE = glm([["1/2"]], [["1"]], [["1"]], [["1"]])
MINUS = glm([["1/2"]], [["1", "1"]], [["1"], ["1"]], [["1", "0"], ["0", "-1"]])
AGAIN = glm([["1/2"]], [["1", "1"]], [["1"], ["1"]], [["1", "0"], ["0", "1"]])
FINISHED = {**EULER, "starting": {"A": [["0"]], "B": [["0"]], "u": ["1"]},
            "finishing": {"A": [["0"]], "b": ["0"]}}  # fmt: skip
APART = rk([["0"]], ["1"], c=["1"], dense=[["1"]], format="glmref-method-2")


def spectra(f: list[str], k: list[str]) -> Parts:
    return [("eigen", {"which": "f", "zeta": f}), ("eigen", {"which": "k", "zeta": k}),
            ("growth", {})]  # fmt: skip


FORGED: dict[str, tuple[dict[str, Any], str, Any, str, Parts]] = {
    "unbounded": (glm([["0"]], [["1", "0"]], [["1"], ["0"]], [["1", NIL], ["0", "1"]]),
                  "zero-stable", True, "fails", [("unbounded", {"which": "o"})]),
    "conjugate": (glm([["0"]], [["1", "0"]], [["1"], ["0"]], [["1", "0"], ["0", "sqrt(2)"]]),
                  "zero-stable", True, "holds", [("bounded", {"which": "o"})]),
    "constant": (LMM, "error-constant", NIL, "holds", [("error-constant", {})]),
    "other constant": (LMM, "error-constant", "1/2", "fails", [("other-error-constant", {})]),
    "implicit": (rk([[NIL]], ["1"]), "explicit", True, "fails", [("implicit", {})]),
    "symmetric": (MIDPOINT, "symmetric", True, "fails", [("not-symmetric", {})]),
    "symplectic": (MIDPOINT, "symplectic", True, "fails", [("not-quadratic", {})]),
    "a-stable": (MIDPOINT, "a-stable", True, "fails", [("not-a-stable", {"axis": True})]),
    "l-stable": (rk([["sqrt(4)-1"]], ["1"]), "l-stable", True, "fails", [("not-l-limit", {})]),
    "finish": (FINISHED, "finishing-order", 1, "fails", [("finish-at-least", {"q": 2})]),
    "finish above": (FINISHED, "finishing-order", 1, "fails", [
        ("order-at-least", {"order": 1, "principal": "identity", "trees": "all"}),
        ("order-at-most", {"order": 1, "principal": "identity", "trees": "all", "tree": "[o]"}),
        ("finish-at-least", {"q": 2})]),
    "c apart": (APART, "dense-order", 1, "holds", [("dense", {"order": 1, "tree": "[o]"})]),
    "abscissae": (FREE, "abscissae", ["1"], "fails", [("other-abscissae", {})]),
    "blank": (rk([["0"]], ["1"], embedded=[{"name": "e", "b": ["1 1"]}],
                 format="glmref-method-2"),
              "embedded-difference", False, "holds", [("no-differences", {})]),
}  # fmt: skip
for claim, value in (("parasitism-free", True), ("growth", [])):
    FORGED |= {
        f"{claim} f": (pair(MINUS, ONE, False), claim, value, "holds", spectra(["1", "-1"], ["1"])),
        f"{claim} k": (pair(ONE, MINUS, False), claim, value, "holds", spectra(["1"], ["1", "-1"])),
        f"{claim} 1 1": (pair(AGAIN, AGAIN, True), claim, value, "holds", spectra(["1"], ["1"])),
        f"{claim} 1 2": (pair(ONE, AGAIN, False), claim, value, "holds", spectra(["1"], ["1"])),
    }


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_certificate_is_refused(name: str) -> None:
    d, claim, declared, verdict, parts = FORGED[name]
    accepted, why = judge.verdict(certificate(d, claim, declared, verdict, parts))
    assert not accepted, why
    if name != "blank":  # no file at all
        facts = facts_for(load_document({**HEAD, "source": SOURCE, **d, "claims": {}}))
        other = Verdict.HOLDS if verdict == "fails" else Verdict.FAILS
        assert facts.judge(claim, declared).verdict in (other, Verdict.OPEN)


def test_a_series_that_a_refusal_left_half_made_is_not_gone_on_with(monkeypatch):
    """Parts may be moved twice when time is up between them; the next certificate starts anew."""
    series = {"order": 1, "principal": "free", "trees": "all"}
    parts = [("order-at-least", series), ("order-at-most", {**series, "tree": "[o]"})]
    true = certificate(EULER, "effective-order", 1, "holds", parts)
    settle, used = Solved.settle, []

    def cut_short(self: Solved) -> None:
        used.append(self)
        settle(self)
        if len(used) == 1:
            raise NotShown("time is up")

    monkeypatch.setattr(Solved, "settle", cut_short)
    assert judge.verdict(true) == (False, "time is up")
    assert judge.verdict(true)[0]
    assert used[0] is not used[1]


def test_stages_of_one_certificate_are_not_those_of_another_start() -> None:
    """A declared output gave eta([o]) a value, and stages of every method with this A with it."""
    table = {"class": "rk", "A": [["0", "0"], ["2/3", "0"]]}
    poison = {"class": "glm", "A": table["A"], "U": [["1"], ["1"]], "B": [["0", "1"]],
              "V": [["1"]], "output": ["1"]}  # fmt: skip
    parts = [("stage-order-at-most", {"q": 1, "tree": "[o]"})]
    assert judge.verdict(certificate(poison, "stage-order", 2, "fails", parts))[0]
    series = {"principal": "identity", "trees": "all", "order": 3}
    below, above = ("order-at-least", series), ("order-at-most", {**series, "tree": "[[[o]]]"})
    second = {**table, "b": ["1/4", "3/4"]}  # b A c = 0
    accepted, why = judge.verdict(certificate(second, "order", 3, "holds", [below, above]))
    assert not accepted and "at tree [[o]]" in why


def test_a_number_of_one_certificate_is_not_taken_for_that_of_another() -> None:
    """g1 is sqrt(2) in one field and sqrt(3) in the next: an interval was kept for both."""
    roots = [
        Tower(
            [{"name": "g1", "polynomial": [f"-{n}", "0"], "real": ["1", "2"], "imag": ["0", "0"]}]
        ).generator(0)
        for n in (2, 3)
    ]
    assert roots[0] != roots[1]
    for root, square in zip(roots, (2, 3), strict=True):
        box = around(root)
        ends = [Fraction(x, 2**PLACES) for x in (box.lo, box.hi)]
        assert ends[0] ** 2 < square < ends[1] ** 2
        assert around(root) is box
