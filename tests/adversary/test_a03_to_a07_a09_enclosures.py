"""A3 to A7, A9, A12, A14: what an enclosure and its start prove, and what they do not."""

import re

import pytest

from glmref.catalogue.reader import load_document
from glmref.errors import DataError, ExactnessError
from glmref.exact import Exact
from tests.build import refused

from .deceive import Proof, Verdict, doc, findings, never_holds, shipped, verdicts

TINY = ["1/1" + "0" * 80, "-1/1" + "0" * 120, "1/1" + "0" * 30]
SWEEPS = ["s3-w3", "t115-i", "yoshida-6-midpoint"]
PAIRS = ["pair-4-4", "pair-6-7", "blanes-moan-4", "kahan-li-6"]


@pytest.mark.parametrize("name", SWEEPS)
@pytest.mark.parametrize("tiny", TINY)
def test_a3_a_first_row_of_x_other_than_one_is_refused(name: str, tiny: str) -> None:
    for place in (0, -1):
        d = shipped(name)
        row = list(d["X"][0])
        row[place] = f"{row[place]}+{tiny}"
        d["X"][0] = row
        never_holds(d, "order", *({"preconsistent", "consistent"} & d["claims"].keys()))


@pytest.mark.parametrize("name", SWEEPS)
def test_a3_an_unknown_in_the_first_row_is_refused(name: str) -> None:
    d = shipped(name)
    unknown = next(iter(d["unknowns"]))
    value = d["unknowns"][unknown]
    # 1 within the digits, not for all values of the unknown
    d["X"][0] = [f"1+{unknown}-({value})" if "." not in value else f"1+0*{unknown}+1/1{'0' * 90}"
                 for _ in d["X"][0]]  # fmt: skip
    never_holds(d, "order")


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("tiny", TINY)
def test_a4_a_palindrome_that_is_none_is_not_symmetric(name: str, tiny: str) -> None:
    d = shipped(name)
    key = "a" if d["class"] == "splitting" else "b"
    d[key][-1] = f"{d[key][-1]}+{tiny}"
    never_holds(d, "symmetric")


@pytest.mark.parametrize("name", SWEEPS + PAIRS)
def test_a5_a14_an_enclosure_without_an_order_is_refused(name: str) -> None:
    d = shipped(name)
    for kind in ("consistent", "symmetric", "g-symplectic"):
        d["claims"] = {kind: True}
        d.pop("starting", None), d.pop("finishing", None)
        error = refused((DataError, ExactnessError), "", findings, d)
        assert "order" in error and "\n" not in error


@pytest.mark.parametrize("name", ["rk4", "am-1", "gsymplectic-n"])
def test_a14_an_enclosure_in_another_class_is_refused(name: str) -> None:
    d = shipped(name)
    d["enclosure"] = {"equations": ["order o"], "radius": "1e-60"}
    d["digits"] = 75
    refused(DataError, "enclosure", findings, d)


@pytest.mark.parametrize("name", ["pair-4-5", "pair-6-7", "pair-4-4"])
def test_a6_a_ball_around_zero_is_not_a_zero(name: str) -> None:
    """Without the equations the start may be anything within the digits."""
    d = shipped(name)
    d.pop("starting", None)
    d.pop("enclosure")
    order = d["claims"]["order"]
    for claimed in range(1, order + 1):
        d["claims"] = {"starting-order": claimed, "order-identity": order}
        never_holds(d, "starting-order", "order-identity")


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("more", [1, 2, -1])
def test_a6_the_order_of_a_start_is_exact(name: str, more: int) -> None:
    d = shipped(name)
    if "starting-order" not in d["claims"] or "starting" in d:
        d["claims"]["starting-order"] = d["claims"]["order"] + 1
        d.pop("starting", None)
        never_holds(d, "starting-order")
        return
    d["claims"]["starting-order"] += more
    never_holds(d, "starting-order")


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["s3-w3", "t115-w3", "s4-w3"])
def test_a7_a_proved_start_says_nothing_of_the_finish(name: str) -> None:
    d = shipped(name)
    size = 3
    d["finishing"] = {
        "A": [["0"] * size, ["0.5", "0", "0"], ["0.5", "0.5", "0"]],
        "b": ["0.1", "-0.1", "0." + "0" * 40 + "1"],
        "order": d["claims"]["order"],
    }
    d["claims"]["finishing-order"] = d["claims"]["order"]
    never_holds(d, "finishing-order")


@pytest.mark.parametrize(
    ("name", "claim", "steps"),
    [
        *(
            (x, "order-identity", (1, 2))
            for x in ("pair-4-4", "pair-6-7", "t115-i", "order8-s3-w3-i")
        ),
        *((x, "order", (-2, -1, 1, 2)) for x in ("s3-w3", "yoshida-6-midpoint")),
    ],
)
def test_a9_an_order_beside_the_proved_one_is_not_proved(name, claim, steps):
    d = shipped(name)
    order = d["claims"]["order"]
    for step in steps:
        d["claims"] = {"order": order, claim: order + step}
        d.pop("starting", None), d.pop("finishing", None)
        never_holds(d, claim)


@pytest.mark.parametrize("digits", [1, 2, 3, 8])
def test_a12_wide_decimals_prove_no_identity(digits: int) -> None:
    def cut(text: str) -> str:
        whole, point, rest = text.partition(".")
        return f"{whole}{point}{rest[:digits]}"

    start = shipped("gsymplectic-n")
    start["digits"] = digits
    flat = re.compile(r"sqrt\(3\)")
    start["starting"]["B"] = [
        [cut(f"{float(complex(_number(x)).real):.12f}") if flat.search(x) else x for x in row]
        for row in start["starting"]["B"]
    ]
    start["claims"] = {"starting-order": start["starting"]["order"]}
    never_holds(start, "starting-order")
    rk = doc(
        "rk",
        {"order": 4, "stage-order": 1, "symplectic": True},
        A=[["0", "0"], ["0", "0"]],
        b=[cut("0.500000000000"), cut("0.500000000000")],
        digits=digits,
    )
    never_holds(rk, "order", "symplectic")


def _number(text: str) -> Exact:
    from glmref.exact.expression import parse

    value = parse(text)
    assert isinstance(value, Exact)
    return value


@pytest.mark.parametrize("digits", [1, 3])
def test_a12_a_stage_anywhere_has_no_abscissa(digits: int) -> None:
    zero = "0." + "0" * digits
    d = doc(
        "rk",
        {"abscissae": ["0", "1/2"], "explicit": True, "stage-order": 1, "order": 2},
        A=[["0", "0"], [f"0.5{'0' * (digits - 1)}", zero]],
        b=["0", "1"],
        digits=digits,
    )
    # the printed zeros are 0: the method is explicit, whatever 0.5 stands for
    never_holds(d, "abscissae", "order")
    assert verdicts(d)["explicit"] is Verdict.HOLDS


@pytest.mark.parametrize("name", ["blanes-moan-4", "s3-w3", "pair-4-4"])
def test_a_broken_file_proves_its_zeros_too(name: str, tmp_path) -> None:
    """Equations of a file are proved also where it says that a claim fails."""
    import json

    from glmref.prove.verifier import verify_file

    d = shipped(name)
    d["broken"] = {"claim": "symmetric", "why": "it does not", "flag": "SymmetryOverclaimed"}
    path = tmp_path / f"{d['name']}.json"
    path.write_text(json.dumps(d))
    (found,) = verify_file(path)
    assert found.verdict is (Verdict.FAILS if d["claims"].get("symmetric") else Verdict.HOLDS)
    load_document(d)
    assert found.proof in (Proof.ENCLOSED, Proof.EXACT)


@pytest.mark.slow
def test_the_files_themselves_hold() -> None:
    for name in ("s3-w3", "pair-4-4"):
        assert set(verdicts(shipped(name)).values()) == {Verdict.HOLDS}
