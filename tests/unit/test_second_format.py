"""``glmref-method-2``: embedded rows, c apart, dense output, Nystrom and Rosenbrock methods."""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import glmref
from glmref import judge
from glmref.catalogue.files import document
from glmref.catalogue.lookup import data_root
from glmref.catalogue.reader import load_document
from glmref.errors import DataError, UsageError
from glmref.method import PartitionedGLM
from glmref.prove.analysis import analyze
from glmref.prove.verifier import claims_of, facts_for, verify
from glmref.views.show import show
from tests.build import SOURCE, refused

CERTIFICATE = json.loads(
    (data_root() / "schema" / "glmref-certificate-1.schema.json").read_text(encoding="utf-8")
)
G = "1+sqrt(2)/2"
HEAD = {"format": "glmref-method-2", "name": "t", "source": SOURCE}


def made(kind: str, **more: Any) -> dict[str, Any]:
    return {**HEAD, "class": kind, **copy.deepcopy(more)}


def _dormand_prince() -> dict[str, Any]:
    five, four = document("dormand-prince-5"), document("dormand-prince-4")
    return made(
        "rk", A=five["A"], b=five["b"], c=["0", "1/5", "3/10", "4/5", "8/9", "1", "1"],
        embedded=[{"name": "hat", "b": four["b"]}],
        claims={
            "order": 5, "embedded-order": {"hat": 4}, "embedded-difference": True,
            "row-sums": True,
        },
    )  # fmt: skip


MIDPOINT_LATE = made(  # the midpoint rule that asks f at the end of the step: right if f(y)
    "rk", A=[["0", "0"], ["1/2", "0"]], b=["0", "1"], c=["0", "1"],
    claims={"order": 1, "row-sums": False, "explicit": True},
)  # fmt: skip
HEUN = made(
    "rk", A=[["0", "0"], ["1", "0"]], b=["1/2", "1/2"], dense=[["1", "-1/2"], ["0", "1/2"]],
    embedded=[{"name": "euler", "error": ["-1/2", "1/2"]}],
    claims={
        "order": 2, "embedded-order": {"euler": 1}, "dense-order": 2, "dense-end": True,
        "embedded-difference": True,
    },
)  # fmt: skip
NYSTROM = made(  # Hairer, Norsett, Wanner I, II.14: the classical method of order 4 for q'' = g(q)
    "nystrom", A=[["0", "0", "0"], ["1/8", "0", "0"], ["0", "1/2", "0"]], b=["1/6", "1/3", "0"],
    b_prime=["1/6", "2/3", "1/6"], c=["0", "1/2", "1"],
    embedded=[{"name": "low", "b": ["1/2", "0", "0"], "b_prime": ["1", "0", "0"]}],
    claims={"nystrom-order": 4, "embedded-order": {"low": 1}, "explicit": True},
)  # fmt: skip
WITH_VELOCITY = made(  # Nystrom 1925, the same for q'' = g(q, q')
    "nystrom",
    A=[["0"] * 4, ["1/8", "0", "0", "0"], ["1/8", "0", "0", "0"], ["0", "0", "1/2", "0"]],
    A_prime=[["0"] * 4, ["1/2", "0", "0", "0"], ["0", "1/2", "0", "0"], ["0", "0", "1", "0"]],
    b=["1/6", "1/6", "1/6", "0"], b_prime=["1/6", "1/3", "1/3", "1/6"],
    c=["0", "1/2", "1/2", "1"], claims={"nystrom-order": 4},
)  # fmt: skip
ROS2 = made(  # Verwer, Spee, Blom, Hundsdorfer 1999
    "rosenbrock", alpha=[["0", "0"], ["1", "0"]], gamma=[[G, "0"], [f"-2*({G})", G]],
    b=["1/2", "1/2"], embedded=[{"name": "low", "b": ["1", "0"]}],
    claims={
        "order": 2, "w-order": 2, "a-stable": True, "l-stable": True, "embedded-order": {"low": 1},
    },
)  # fmt: skip
ADDITIVE = {
    **{k: v for k, v in document("ars-2-2-2").items() if k not in ("format", "claims")},
    **HEAD,
    "embedded": [{"name": "euler", "b": [["0", "1", "0"], ["0", "0", "1"]]}],
    "claims": {"order": 2, "embedded-order": {"euler": 1}},
}
EVERY = [
    _dormand_prince(), MIDPOINT_LATE, HEUN, NYSTROM, WITH_VELOCITY, ROS2, ADDITIVE
]  # fmt: skip
NAMES = ["pair", "late", "heun", "nystrom", "velocity", "ros2", "additive"]


@pytest.mark.sampled(3)
@pytest.mark.parametrize("doc", EVERY, ids=NAMES)
def test_the_checker_accepts_the_certificate_of_every_claim(doc: dict[str, Any]) -> None:
    """Also of a claim that fails: the order that is one too high, and the truth turned round."""
    other = {
        key: not x if isinstance(x, bool)
        else {name: n + 1 for name, n in x.items()} if isinstance(x, dict) else x + 1
        for key, x in doc["claims"].items()
    }  # fmt: skip
    for claims, verdict in ((doc["claims"], "holds"), (other, "fails")):
        method = load_document({**doc, "claims": claims})
        facts = facts_for(method)
        for claim, declared in claims_of(method).items():
            certificate = facts.judge(claim, declared).certificate
            assert isinstance(certificate, dict), (claim, certificate)
            jsonschema.validate(certificate, CERTIFICATE)
            accepted, sentence = judge.verdict(certificate)
            assert accepted, (claim, sentence)
            assert certificate["statement"]["verdict"] == verdict
            turned = copy.deepcopy(certificate)
            turned["statement"]["verdict"] = {"holds": "fails", "fails": "holds"}[verdict]
            assert not judge.verdict(turned)[0]


def test_a_changed_digit_of_an_embedded_row_fails_its_claims() -> None:
    """The order of the row, and that the estimate is a difference; the method itself stays."""
    doc = _dormand_prince()
    doc["embedded"][0]["b"][2] = "7571/16696"
    found = {x.claim: x for x in verify(load_document(doc))}
    assert str(found["order"].verdict) == "holds"
    assert str(found["embedded-order"].verdict) == "fails"
    assert "row hat: tree o of order 1 has residual" in found["embedded-order"].witness
    assert str(found["embedded-difference"].verdict) == "fails"
    assert "the weights of the estimate hat sum to" in found["embedded-difference"].witness


@pytest.mark.parametrize(
    ("claimed", "value", "witness"),
    [({"hat": 3}, {"hat": 4}, ""), ({"other": 4}, None, "the rows of `embedded` are hat")],
)
def test_a_row_is_claimed_exactly_and_by_the_name_it_has(claimed, value, witness) -> None:
    doc = _dormand_prince()
    doc["claims"]["embedded-order"] = claimed
    (found,) = verify(load_document(doc), only=["embedded-order"])
    assert str(found.verdict) == "fails"
    assert found.value == value if value else found.witness == witness


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("doc", "change", "claim", "witness"),
    [
        (HEUN, ("dense", 0, 1, "-1/3"), "dense-end", "b[1](1) differs from b[1]"),
        (HEUN, ("dense", 0, 1, "-1/3"), "dense-order", "the power 2 of theta is off"),
        (NYSTROM, ("A", 1, 0, "1/7"), "nystrom-order", "k[f[k]] of order 3 has residual"),
        (
            WITH_VELOCITY,
            ("A_prime", 2, 1, "1/3"),
            "nystrom-order",
            "tree k[k] of order 2 has residual",
        ),
        (ROS2, ("gamma", 1, 0, "-2"), "order", "order 2 has residual"),
    ],
)
def test_a_changed_digit_fails(doc, change, claim, witness):
    """One entry of a block that only the second format has."""
    key, i, j, text = change
    doc = copy.deepcopy(doc)
    doc[key][i][j] = text
    (found,) = verify(load_document(doc), only=[claim])
    assert str(found.verdict) == "fails"
    assert witness in found.witness


def test_the_same_row_stands_twice() -> None:
    """Names tell rows apart."""
    doc = _dormand_prince()
    doc["embedded"] *= 2
    refused(DataError, r"has the name .hat. twice", load_document, doc)


def test_nystrom_methods_are_pairs() -> None:
    """A pair with one stage P more than stages Q; with A' the stages are shared."""
    pair = load_document(NYSTROM)
    assert isinstance(pair, PartitionedGLM)
    assert (pair.n_Q, pair.n_P, pair.separable) == (3, 4, True)
    shared = load_document(WITH_VELOCITY)
    assert isinstance(shared, PartitionedGLM)
    assert (shared.n_Q, shared.n_P, shared.separable) == (9, 9, False)
    assert analyze(pair).order_nystrom == analyze(shared).order_nystrom == 4


def test_a_time_that_is_not_the_row_sum_costs_order() -> None:
    """Autonomous the late midpoint rule has order 2, and 1 where time occurs."""
    assert analyze(load_document(MIDPOINT_LATE)).order == 1
    plain = {k: v for k, v in MIDPOINT_LATE.items() if k != "c"}
    plain["claims"] = {"order": 2}
    assert analyze(load_document(plain)).order == 2


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    ("name", "order"), [("dormand-prince-rkn-4-3", 4), ("fine-rkn-4-3", 4), ("nystrom-rkn-5", 5)]
)
@pytest.mark.parametrize("engine", ["compiled", "reference"])
def test_nystrom_methods_are_solved_with_in_their_order(name: str, order: int, engine: str) -> None:
    """Kepler's problem once round: q'' = g(q), also for methods whose g sees the velocities."""
    kepler = glmref.problem("kepler")
    once = 2 * math.pi
    errors = [
        max(abs(x - y) for x, y in zip(found.y[-1], kepler.y0, strict=True))
        for steps in (400, 800)
        for found in [
            glmref.solve(kepler, name, h=once / steps, steps=steps, engine=engine)
        ]
    ]  # fmt: skip
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.6)


def test_rosenbrock_methods_are_not_solved_with() -> None:
    """No engine evaluates a Jacobian."""
    with pytest.raises(UsageError, match="ros3p is a Rosenbrock method, which needs the Jacobian"):
        glmref.solve("kepler", "ros3p", h=0.1, steps=2)


def test_a_page_shows_what_stands_beside_the_tableau() -> None:
    """Embedded rows by name, the dense output, alpha and gamma."""
    shown = str(show("dormand-prince-5-4"))
    assert "embedded row embedded:\n  5179/57600  0  7571/16695" in shown
    assert "b(theta), by powers of theta from 1:" in shown
    assert "alpha | gamma, with b below:" in str(show("ros3p"))
    assert "c | A, with b and b' below:" in str(show("fine-rkn-4-3"))


def test_a_method_with_rows_is_saved_whole(tmp_path: Path) -> None:
    """Also where it was changed, so that it no longer is what its file says."""
    method = glmref.load("bogacki-shampine-3-2").permute_stages([3, 2, 1, 0])
    again = glmref.load(method.save(tmp_path / "moved.json"))
    assert again.embedded == method.embedded
    assert again.dense == method.dense
    assert {str(x.verdict) for x in verify(again)} == {"holds"}
