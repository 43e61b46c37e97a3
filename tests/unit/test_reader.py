"""reader.py: each class of document becomes the method it stands for."""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from typing import Any

import pytest

from glmref.catalogue.claims import CLAIMS
from glmref.catalogue.entries import Entries
from glmref.catalogue.keys import (
    MAX_SIZE,
    PAIRS,
    fault_of_texts,
    needed_keys,
    without_meaning,
)
from glmref.catalogue.lookup import document, load, names
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.exact import Ball, exact
from glmref.exact.expression import Text
from glmref.method import GLM, AdditiveGLM, PartitionedGLM
from tests.build import refused

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


def test_of_pairs_a_nystrom_method_alone_claims_its_row_sums() -> None:
    pairs = without_meaning("splitting")
    assert pairs == without_meaning("partitioned-rk") and {"row-sums", "a-stable"} < pairs
    rows = {"row-sums", "embedded-order", "embedded-difference"}
    assert without_meaning("nystrom") == pairs - rows


def test_a_real_tableau_with_a_complex_entry_must_say_so() -> None:
    refused(DataError, r"`A\[1\]\[1\]` is complex", glm, kind="rk", A=[["i/2"]], b=["1"])
    assert not glm(kind="rk", A=[["i/2"]], b=["1"], field="complex").is_real
    assert glm(kind="rk", A=[["i*i"]], b=["1"]).is_real


def test_documents_of_python_values_are_checked_like_files() -> None:
    for value in ({}, [], "x", None, 3):
        refused(DataError, "document: ", load_document, value)
    refused(DataError, r"`A\[1\]\[1\]` must be a string", glm, kind="rk", A=[[0.5]], b=["1"])


def test_a_constant_that_stands_nowhere_is_refused() -> None:
    members = {**document("gauss-2"), "constants": {"g": "sqrt(3)"}}
    refused(DataError, "the constant 'g' is never used", load_document, members)
    assert load_document({**members, "b": ["g/g/2", "1/2"]}).r == 1


def test_a_method_of_one_value_has_no_start_to_read() -> None:
    started = {**document("stormer-verlet"), "starting": document("pair-4-4")["starting"]}
    with pytest.raises(DataError, match="the key 'starting' is unknown for class 'splitting'"):
        load_document(started)


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


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"title": 3}, "`title` must be a string, got 3"),
        ({"title": ["a"]}, '`title` must be a string, got ["a"]'),
        ({"notes": ["a", 1]}, '`notes` must be a string, got ["a", 1]'),
        ({"notes": ["a", "b"], "title": "It"}, ""),
        ({"enclosure": "x"}, '`enclosure` must be an object, got "x"'),
        ({"enclosure": {"box": 1}}, "the key 'box' is unknown in `enclosure`"),
        ({"enclosure": {"equations": "x"}}, "must be a list of strings, got"),
        ({"enclosure": {"equations": ["x", 1]}}, "must be a list of strings, got"),
        ({"enclosure": {"equations": ["x"], "radius": "1", "xi": "1"}}, ""),
        ({"broken": "x"}, "`broken` must be an object"),
        ({"broken": None}, "`broken` must be an object"),
        ({"broken": {"claim": "order"}}, "`broken` must be an object"),
        ({"broken": {"claim": "order", "why": "x", "who": "y"}}, "`broken` must be an object"),
        ({"broken": {"claim": "order", "why": 1}}, "`broken` must be an object"),
        ({"broken": {"claim": "order", "why": "x", "found": "y"}}, ""),
        ({"source": "x"}, '`source` must be an object, got "x"'),
        ({"source": {**SOURCE_BLOCK, "where": " "}}, "`source.where` must be a non-empty string"),
        ({"source": {**SOURCE_BLOCK, "status": 1}}, "`source.status` must be a non-empty string"),
        ({"source": {**SOURCE_BLOCK, "by": "x"}}, "the key 'by' is unknown in `source`"),
        ({"source": {**SOURCE_BLOCK, "errata": "x"}}, "must be a list of sentences, got"),
        ({"source": {**SOURCE_BLOCK, "errata": [1]}}, "must be a list of sentences, got"),
        ({"source": {**SOURCE_BLOCK, "doi": ["x"]}}, "`source.doi` must be a string, got"),
        ({"source": {**SOURCE_BLOCK, "notes": 1}}, "`source.notes` must be a string, got 1"),
        ({"source": {**SOURCE_BLOCK, "errata": ["x"], "notes": ["x"], "doi": "x"}}, ""),
        ({"source": {**SOURCE_BLOCK, "status": "guessed"}}, "must be one of as printed, corrected"),
        ({"source": {}}, "`source.citation` must be a non-empty string"),
        ({"source": {}, "claims": {}}, ""),
        ({"claims": {}}, ""),
    ],
)
def test_texts_and_sources_are_looked_at(changes: dict[str, Any], fault: str) -> None:
    found = fault_of_texts({**doc("rk"), **changes})
    assert fault in found and bool(fault) is bool(found)


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
