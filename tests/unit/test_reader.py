"""reader.py: each class of document becomes the method it stands for."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest

from glmref.catalogue.claims import CLAIMS
from glmref.catalogue.keys import BLOCKS, PAIRS, SOURCE, without_meaning
from glmref.catalogue.lookup import document, load, names
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.exact import exact
from glmref.exact.expression import Text
from glmref.method import GLM, AdditiveGLM, PartitionedGLM

SOURCE_BLOCK = {"citation": "Nobody (1900)", "where": "p. 1", "status": "derived"}


def doc(kind: str, **members: Any) -> dict[str, Any]:
    head = {"format": "glmref-method-1", "name": "it", "class": kind}
    return {**head, "claims": {"order": 1}, "source": SOURCE_BLOCK, **members}


def glm(**members: Any) -> GLM:
    method = load_document(doc(**members))
    assert isinstance(method, GLM)
    return method


def equal(a: Any, b: Any) -> bool:
    return all(x == y for p, q in zip(a, b, strict=True) for x, y in zip(p, q, strict=True))


def test_runge_kutta_becomes_a_method_with_one_value() -> None:
    method = glm(kind="rk", A=[["0", "0"], ["1/2", "0"]], b=["0", "1"])
    assert (method.s, method.r) == (2, 1)
    assert equal(method.B, ((0, 1),))
    assert equal(method.U, ((1,), (1,)))


def test_composition_is_that_of_its_base() -> None:
    method = glm(kind="composition", base="gauss-1", gamma=["1/3", "2/3"])
    by_hand = glm(kind="rk", A=[["1/6", "0"], ["1/3", "1/3"]], b=["1/3", "2/3"])
    assert equal(method.A, by_hand.A)
    assert equal(method.B, by_hand.B)


def test_every_class_is_read_and_every_class_occurs_in_the_catalogue() -> None:
    seen = {document(name)["class"] for name in names("all")}
    assert seen <= BLOCKS.keys()
    assert {"glm", "rk", "lmm", "one-leg", "composition", "splitting"} <= seen
    assert {"partitioned-rk", "partitioned"} <= seen


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


def test_g_may_be_given_by_its_diagonal() -> None:
    blocks = {x: document("gsymplectic-n")[x] for x in "AUBV"}
    method = glm(kind="glm", **blocks, G=["1", "-1/2"], D=["1/2", "1/2"])
    assert method.G is not None
    assert equal(method.G, ((1, 0), (0, method.G[1][1])))
    assert method.D is not None
    assert [x * 2 for x in method.D] == [1, 1]


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


def test_each_needed_key_is_asked_for_by_name() -> None:
    for kind, base in (("glm", "gsymplectic-n"), ("rk", "rk4"), ("lmm", "ab-2")):
        whole = document(base)
        for key in ("name", "source", *(BLOCKS[kind] & {"A", "V", "b", "alpha"})):
            with pytest.raises(DataError, match=f"the key '{key}' is missing"):
                load_document({k: x for k, x in whole.items() if k != key})


def test_a_real_tableau_with_a_complex_entry_must_say_so() -> None:
    with pytest.raises(DataError, match=r"`A\[1\]\[1\]` is complex"):
        glm(kind="rk", A=[["i/2"]], b=["1"])
    assert not glm(kind="rk", A=[["i/2"]], b=["1"], field="complex").is_real
    assert glm(kind="rk", A=[["i*i"]], b=["1"]).is_real


def test_a_starting_method_is_read_with_its_order() -> None:
    method = load("gsymplectic-n")
    assert isinstance(method, GLM)
    assert method.starting is not None
    assert method.starting.claims["order"] == document("gsymplectic-n")["starting"]["order"]
    assert method.starting.stages == len(document("gsymplectic-n")["starting"]["A"])


def test_documents_of_python_values_are_checked_like_files() -> None:
    for value in ({}, [], "x", None, 3):
        with pytest.raises(DataError, match="document: "):
            load_document(value)  # type: ignore[arg-type]
    with pytest.raises(DataError, match=r"`A\[1\]\[1\]` must be a string"):
        glm(kind="rk", A=[[0.5]], b=["1"])


def test_every_key_of_every_source_is_one_the_format_has() -> None:
    for name in names("all"):
        assert document(name)["source"].keys() <= SOURCE.keys()


def test_a_constant_that_stands_nowhere_is_refused() -> None:
    members = {**document("gauss-2"), "constants": {"g": "sqrt(3)"}}
    with pytest.raises(DataError, match="the constant 'g' is never used"):
        load_document(members)
    assert load_document({**members, "b": ["g/g/2", "1/2"]}).r == 1


def test_the_start_of_a_pair_is_read() -> None:
    method = load("pair-4-4")
    assert isinstance(method, PartitionedGLM)
    assert method.starting is not None
    assert method.starting.stages == (5, 5)
    assert (len(method.starting.B), len(method.starting.B_hat)) == (2, 2)
    assert method.starting.claims["order"] == method.claims["starting-order"] == 4
    assert load("stormer-verlet").starting is None


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("pair-4-4", {"A_hat": None}, "`starting.A_hat` is missing"),
        ("pair-4-4", {"V": [["1"]]}, "`starting` has the unknown key 'V'"),
        (
            "pair-4-4",
            {"A": [["0"] * 4] * 5},
            r"`starting.A` must have shape \(5, 5\).*got \(5, 4\)",
        ),
        ("pair-4-4", {"B_hat": [["0"] * 5]}, r"`starting.B_hat` must have shape \(2, 5\)"),
        ("pair-4-4", {"u_hat": ["1"]}, "`starting.u_hat` must have 2 entries, one for each value"),
        ("pair-4-4", {"order": "4"}, "`starting.order` must be a whole number"),
        (
            "gsymplectic-n-pair",
            {"A": [["0"] * 3], "A_hat": [["0"]] * 3, "B_hat": [["0"]] * 2},
            "`starting` must have as many stages Q as stages P",
        ),
    ],
)
def test_a_start_of_a_pair_with_a_wrong_shape_is_refused(name, changes, message) -> None:
    block = {**document(name)["starting"], **changes}
    kept = {k: v for k, v in block.items() if v is not None}
    with pytest.raises(DataError, match=message):
        load_document({**document(name), "starting": kept})


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
    assert isinstance(method, GLM)
    assert method.output == (1, 3)
    with pytest.raises(DataError, match=r"`output` must read the solution off the values.*got 0"):
        load_document(found | {"output": ["0", "1"]})
    with pytest.raises(DataError, match="`output` must have 2 entries"):
        load_document(found | {"output": ["1"]})
    with pytest.raises(DataError, match=r"`output\[1\]` must be a string"):
        load_document(found | {"output": [1, 0]})


def test_a_pair_says_it_for_each_of_its_halves():
    found = dict(document("gsymplectic-n-pair"))
    q, p = dict(found["q"]) | {"output": ["1", "0"]}, dict(found["p"]) | {"output": ["1", "1/2"]}
    method = load_document(found | {"q": q, "p": p})
    assert isinstance(method, PartitionedGLM)
    assert (method.output, method.output_hat) == ((1, 0), (1, exact(Fraction(1, 2))))
    with pytest.raises(DataError, match="`output_hat` must have 2 entries"):
        load_document(found | {"p": dict(found["p"]) | {"output": ["1"]}})


@pytest.mark.parametrize("wrong", [[], {}, "1", 1, None, True])
def test_a_row_and_a_matrix_are_lists_that_are_not_empty(wrong) -> None:
    doc = document("rk4")
    for key, value in (("b", wrong), ("A", wrong), ("A", [wrong, *doc["A"][1:]])):
        with pytest.raises(DataError, match="must be a list of"):
            load_document({**doc, key: value})


@pytest.mark.parametrize(("i", "j"), [(0, 0), (0, 1), (3, 2)])
def test_a_complex_entry_is_named_by_row_and_column(i, j) -> None:
    doc = document("rk4")
    A = [list(row) for row in doc["A"]]
    A[i][j] = "i"
    with pytest.raises(DataError, match=rf"`A\[{i + 1}\]\[{j + 1}\]` is complex"):
        load_document({**doc, "A": A})


def test_every_key_that_a_class_needs_is_asked_for() -> None:
    from glmref.catalogue.keys import OPTIONAL

    for name in ("t115-i", "rk4", "yoshida-4"):
        doc = document(name)
        for key in sorted(BLOCKS[doc["class"]] - OPTIONAL):
            if key in doc:
                with pytest.raises(DataError, match=f"the key '{key}' is missing"):
                    load_document({x: y for x, y in doc.items() if x != key})
