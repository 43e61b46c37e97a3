"""Each class of document becomes the method it stands for, in both formats."""

import copy
import json
import math
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import glmref
from glmref import judge
from glmref.catalogue.claims import CLAIMS
from glmref.catalogue.entries import Entries
from glmref.catalogue.keys import MAX_SIZE, PAIRS, needed_keys, without_meaning
from glmref.catalogue.lookup import data_root, document, load, names
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.exact import Ball, exact
from glmref.exact.expression import Text
from glmref.method import GLM, AdditiveGLM, PartitionedGLM
from glmref.prove.analysis import analyze
from glmref.prove.verifier import claims_of, facts_for, verify
from tests.build import SOURCE, refused

SOURCE_BLOCK = {"citation": "Nobody (1900)", "where": "p. 1", "status": "derived"}


def doc(kind: str, **members: Any) -> dict[str, Any]:
    head = {"format": "glmref-method-1", "name": "it", "class": kind}
    return {**head, "claims": {"order": 1}, "source": SOURCE_BLOCK, **members}


def glm(**members: Any) -> GLM:
    method = load_document(doc(**members))
    assert isinstance(method, GLM)
    return method


@pytest.mark.slow
def test_every_shipped_file_loads_as_what_its_class_says() -> None:
    for name in names("all"):
        method = load(name)
        kind = document(name)["class"]
        sums = ("additive", "rosenbrock")
        expected = PartitionedGLM if kind in PAIRS else AdditiveGLM if kind in sums else GLM
        assert isinstance(method, expected), name
        assert method.name == name
        assert method.document == document(name)


def test_constants_may_use_those_above_them() -> None:
    constants = {"a": "sqrt(2)", "b": "a*a"}
    method = glm(kind="rk", constants=constants, A=[["b-2"]], b=["b/2"])
    assert method.A[0][0] == 0
    assert method.B[0][0] == 1
    with pytest.raises(DataError, match="the name 'b' is not known"):
        glm(kind="rk", constants={"a": "b", "b": "1"}, A=[["a"]], b=["1"])


def test_claimed_expressions_keep_text_and_value() -> None:
    claims = {"abscissae": ["c"], "order": 1, "explicit": False}
    method = glm(kind="rk", constants={"c": "1/2"}, A=[["c"]], b=["1"], claims=claims)
    (text,) = method.claims["abscissae"]
    assert isinstance(text, Text)
    assert text == "c"
    assert (text.value * 2) == 1
    assert method.claims["order"] == 1
    assert method.claims["explicit"] is False


def test_each_claim_is_refused_with_a_value_of_another_kind() -> None:
    wrong = {int: True, bool: 1, list: "1", str: ["1"], dict: ["1"]}
    for claim, spec in CLAIMS.items():
        classes = {"rk": "rk4", "splitting": "stormer-verlet", "rosenbrock": "ros3p"}
        base = next(x for kind, x in classes.items() if claim not in without_meaning(kind))
        with pytest.raises(DataError, match=f"the claim '{claim}' must be"):
            load_document({**document(base), "claims": {claim: wrong[spec.type]}})


def test_claims_of_one_method_and_of_a_pair_are_refused_for_the_other() -> None:
    for base, kind, right in (("rk4", "rk", 0), ("stormer-verlet", "splitting", 1)):
        assert without_meaning(kind)
        for claim in without_meaning(kind):
            values = {int: 1, bool: True, list: ["1"], str: "1", dict: {"b": 1}}
            with pytest.raises(DataError, match="has no meaning for"):
                load_document({**document(base), "claims": {claim: values[CLAIMS[claim].type]}})
        other = without_meaning(("splitting", "rk")[right])
        # but for what is said of Rosenbrock methods only
        assert without_meaning(kind) & other == {"w-order"}


@pytest.mark.parametrize(
    ("kind", "can", "cannot"),
    [
        ("rk", "row-sums embedded-order starting-order", "w-order reducible nystrom-order"),
        ("lmm", "error-constant finishing-order", "row-sums dense-order embedded-order w-order"),
        (
            "splitting",
            "starting-order reducible",
            "embedded-order row-sums finishing-order w-order",
        ),
        ("partitioned", "nystrom-order", "embedded-difference dense-end abscissae energy-order"),
        ("nystrom", "row-sums embedded-order starting-order", "dense-order a-stable w-order"),
        ("pair-sweep", "starting-order", "row-sums embedded-order error-constant"),
        ("additive", "abscissae order-to-digits", "starting-order row-sums a-stable w-order"),
        ("rosenbrock", "w-order a-stable", "stage-order starting-order symmetric"),
    ],
)
def test_a_class_can_make_the_claims_that_have_a_meaning(kind: str, can: str, cannot: str) -> None:
    assert not without_meaning(kind) & set(can.split())
    assert without_meaning(kind) >= set(cannot.split())


def test_a_real_tableau_with_a_complex_entry_must_say_so() -> None:
    refused(DataError, r"`A\[1\]\[1\]` is complex", glm, kind="rk", A=[["i/2"]], b=["1"])
    assert not glm(kind="rk", A=[["i/2"]], b=["1"], field="complex").is_real
    assert glm(kind="rk", A=[["i*i"]], b=["1"]).is_real


def test_documents_of_python_values_are_checked_like_files() -> None:
    refused(DataError, r"`A\[1\]\[1\]` must be a string", glm, kind="rk", A=[[0.5]], b=["1"])


def test_a_constant_that_stands_nowhere_is_refused() -> None:
    members = {**document("gauss-2"), "constants": {"g": "sqrt(3)"}}
    refused(DataError, "the constant 'g' is never used", load_document, members)
    assert load_document({**members, "b": ["g/g/2", "1/2"]}).r == 1


def test_a_file_says_which_functional_of_its_values_is_the_solution():
    found = dict(document("gsymplectic-n"))
    for key in ("starting", "finishing", "enclosure"):
        found.pop(key, None)
    found |= {"claims": {"order": 4}, "output": ["1", "3"]}
    method = load_document(found)
    assert method.output == (1, 3)
    with pytest.raises(DataError, match=r"`output` must read the solution off the values.*got 0"):
        load_document(found | {"output": ["0", "1"]})
    refused(DataError, "`output` must have 2 entries", load_document, found | {"output": ["1"]})
    refused(DataError, r"`output\[1\]` must be a string", load_document, found | {"output": [1, 0]})


def test_a_pair_says_it_for_each_of_its_halves():
    found = dict(document("gsymplectic-n-pair"))
    q, p = dict(found["q"]) | {"output": ["1", "0"]}, dict(found["p"]) | {"output": ["1", "1/2"]}
    method = load_document(found | {"q": q, "p": p})
    assert (method.output, method.output_hat) == ((1, 0), (1, exact(Fraction(1, 2))))
    with pytest.raises(DataError, match="`output_hat` must have 2 entries"):
        load_document(found | {"p": dict(found["p"]) | {"output": ["1"]}})


def test_every_key_that_a_class_needs_is_asked_for() -> None:
    for name in (
        "t115-i",
        "rk4",
        "yoshida-4",
        "pair-6-8",
        "nystrom-rkn-5",
        "gsymplectic-n",
        "ab-2",
    ):
        doc = document(name)
        for key in sorted(needed_keys(doc["class"]) | {"name", "source"}):
            if key in doc:
                with pytest.raises(DataError, match=f"the key '{key}' is missing"):
                    load_document({x: y for x, y in doc.items() if x != key})


def test_lists_are_read_up_to_their_largest_size() -> None:
    entries = Entries({}, "it.json")
    most, more = ["1"] * MAX_SIZE, ["1"] * (MAX_SIZE + 1)
    assert (
        len(entries.vector(most, "b")) == len(entries.matrix([["1"]] * MAX_SIZE, "A")) == MAX_SIZE
    )
    with pytest.raises(DataError, match=f"`b` has {MAX_SIZE + 1} entries and at most {MAX_SIZE}"):
        entries.vector(more, "b")
    with pytest.raises(DataError, match=f"`A` has {MAX_SIZE + 1} entries and at most {MAX_SIZE}"):
        entries.matrix([["1"]] * (MAX_SIZE + 1), "A")
    with pytest.raises(DataError, match="row 2 is 1 long and row 1 is 2 long"):
        entries.matrix([["1", "2"], ["1"]], "A")
    claims = doc("rk", A=[["0"]], b=["1"], claims={"order": 1})
    assert load_document(claims).name == "it"


@pytest.mark.parametrize(
    ("digits", "fault"),
    [(0, "whole number from 1 to 150"), (151, "whole number from 1 to 150"), (True, "whole number"),
     ("3", "whole number"), (1, ""), (150, "")],
)  # fmt: skip
def test_digits_are_a_whole_number_from_1_to_150(digits: Any, fault: str) -> None:
    entries = Entries({"digits": digits}, "it.json")
    if fault:
        refused(DataError, fault, entries.read_constants)
    else:
        entries.read_constants()
        assert entries.digits == digits


def test_a_decimal_has_the_digits_that_its_file_declares() -> None:
    """Two more may be given; one with fewer is known to less than `digits` says."""

    def read(entry: str) -> GLM:
        return glm(kind="rk", A=[["0"]], b=[entry], digits=5)

    for entry in ("0.50000", "0.5000000", "1/2", "0.0", ".00", "1/3+0.50000"):
        read(entry)
    sentence = (
        r"`b\[1\]`: the decimal '0\.5' has 1 of the 5 digits after the point that `digits` "
        r"declares; write all of them, or 1/2 if it is exact$"
    )
    for entry in ("0.5", "-0.5", "1/3+0.5"):
        refused(DataError, sentence, read, entry)
    refused(DataError, r"'0\.5000' has 4 of the 5 digits", read, "0.5000")
    plain = load_document({"A": [[0]], "b": [0.5], "digits": 5})  # the plain dialect fills up
    assert isinstance(plain, GLM) and isinstance(plain.B[0][0], Ball)


def test_unknowns_and_constants_have_one_table_of_names() -> None:
    entries = Entries({"unknowns": {"x": "2"}, "constants": {"y": "x*x"}}, "it.json")
    entries.read_constants()
    assert entries.constants["y"] == 4 and entries.weights["y"].length == 3
    for wrong, fault in (
        ({"constants": ["x"]}, "`constants` must be an object"),
        ({"unknowns": {"x": "1"}, "constants": {"x": "1"}}, "the constant 'x' occurs twice"),
        ({"constants": {"pi": "1"}}, 'has the name "pi", which cannot be used'),
        ({"constants": {"1x": "1"}}, 'has the name "1x", which cannot be used'),
    ):
        refused(DataError, fault, Entries(wrong, "it.json").read_constants)


def test_a_complex_entry_of_a_vector_is_named_by_its_place() -> None:
    gsymplectic, additive = document("gsymplectic-n"), partial(doc, "additive")
    for key, value, place in (("D", ["i", "1"], "`D[1]`"), ("D", ["1", "i"], "`D[2]`"),
                              ("output", ["1", "i"], "`output[2]`")):  # fmt: skip
        with pytest.raises(DataError) as error:
            load_document(
                {**gsymplectic, key: [*value, *["1"] * (len(gsymplectic.get(key, value)) - 2)]}
            )
        assert f"{place} is complex (0+1j) in a real tableau" in str(error.value)
    parts = [
        {"A": [["0", "0"], ["i", "0"]], "b": ["0", "1"]},
        {"A": [["0", "0"]] * 2, "b": ["0", "1"]},
    ]
    for order, n in ((parts, 1), (parts[::-1], 2)):
        with pytest.raises(
            DataError, match=rf"the entry A\^{n}\[2\]\[1\] of the general linear form"
        ):
            load_document(additive(parts=order))
    pair = document("stormer-verlet")
    refused(DataError, "is complex", load_document, {**pair, "a": ["i", *pair["a"][1:]]})


def test_claimed_lists_are_read_up_to_the_largest_size() -> None:
    values = {"order": 1, "abscissae": ["0"] * MAX_SIZE}
    euler = {"A": [["0"]], "b": ["1"]}
    assert len(load_document(doc("rk", claims=values, **euler)).claims["abscissae"]) == MAX_SIZE
    values["abscissae"] = ["0"] * (MAX_SIZE + 1)
    with pytest.raises(DataError, match=f"has {MAX_SIZE + 1} entries and at most {MAX_SIZE}"):
        load_document(doc("rk", claims=values, **euler))


@pytest.mark.parametrize("n", [1, 2, 3])
def test_rows_and_parts_are_counted_from_1_in_messages(n: int) -> None:
    heun = {"A": [["0", "0"], ["1", "0"]], "b": ["1/2", "1/2"]}
    rows: list[Any] = [{"name": f"row {k}", "b": ["1", "0"]} for k in (1, 2, 3)]
    for wrong in (3, {"name": "it"}, {"name": "it", "b": ["x", "0"]}):
        rows[n - 1] = wrong
        with pytest.raises(DataError) as said:
            load_document(doc("rk", **heun, embedded=rows, format="glmref-method-2"))
        assert f"embedded[{n}]" in str(said.value)
    for wrong in ({**heun, "c": []}, {**heun, "A": [["x"]]}):
        parts = [heun] * 3
        parts[n - 1] = wrong
        with pytest.raises(DataError) as said:
            load_document(doc("additive", parts=parts))
        assert f"parts[{n}]" in str(said.value)


# -- ``glmref-method-2``: embedded rows, c apart, dense output, Nystrom and Rosenbrock methods


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


def test_a_method_with_rows_is_saved_whole(tmp_path: Path) -> None:
    """Also where it was changed, so that it no longer is what its file says."""
    method = glmref.load("bogacki-shampine-3-2").permute_stages([3, 2, 1, 0])
    again = glmref.load(method.save(tmp_path / "moved.json"))
    assert again.embedded == method.embedded
    assert again.dense == method.dense
    assert {str(x.verdict) for x in verify(again)} == {"holds"}
