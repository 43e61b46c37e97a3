"""Enclosed Runge-Kutta and Rosenbrock methods: what D(1) gives, and digits that are not those of the solution."""

import copy
from typing import Any

import pytest

from glmref.catalogue import lookup as catalogue
from glmref.catalogue.lookup import load
from glmref.catalogue.reader import load_document
from glmref.errors import DataError, ExactnessError
from glmref.exact import Exact, linalg
from glmref.findings import Verdict
from glmref.prove.enclosure import equations_of
from glmref.prove.implications import implied_by, order_given
from glmref.prove.verifier import verify
from glmref.theory.trees import single, tree, trees
from tests.build import refused

NAME = "tsitouras-5-4"


def document(**changes: Any) -> dict[str, Any]:
    return {**copy.deepcopy(catalogue.document(NAME)), **changes}


def with_equations(equations: list[str]) -> dict[str, Any]:
    doc = document()
    doc["enclosure"]["equations"] = equations
    return doc


@pytest.mark.parametrize("name", ["rk4", "dormand-prince-5", "butcher-6"])
def test_the_condition_of_a_root_with_one_child_follows_from_two_others(name: str) -> None:
    """The theorem, on exact methods with D(1): defects obey the relation, zero or not."""
    m: Any = load(name)
    b = m.B[0]

    def weight(t: Any) -> Any:
        value = (Exact(1),) * m.s
        for child in t.children:
            stages = linalg.matvec(m.A, weight(child))
            value = tuple(x * y for x, y in zip(value, stages, strict=True))
        return value

    for j, row in enumerate(linalg.transpose(m.A)):
        assert (linalg.dot(b, row) - b[j] * (1 - sum(m.A[j], Exact(0)))).is_zero()

    def defect(t: Any) -> Any:
        return linalg.dot(b, weight(t)) - Exact(1) / t.density

    for u in (u for n in range(1, 7) for u in trees(n)):
        left = defect(tree([u])) - defect(u) + defect(tree([single(), *u.children]))
        assert left.is_zero(), u


def test_every_claim_of_the_pair_holds_and_every_other_order_fails() -> None:
    assert {x.verdict for x in verify(load(NAME))} == {Verdict.HOLDS}
    for claims in ({"order": 4}, {"order": 6}, {"order": 5, "embedded-order": {"embedded": 3}}):
        found = verify(load_document(document(claims=claims)))
        assert Verdict.FAILS in {x.verdict for x in found}, claims


def replaced(doc: dict[str, Any], old: str, new: str) -> Any:
    """The equations of a document with another in the place of one."""
    texts = list(doc["enclosure"]["equations"])
    texts[texts.index(old)] = new
    return equations_of({**doc, "enclosure": {**doc["enclosure"], "equations": texts}}, {})


def test_a_rosenbrock_method_has_its_orders_from_equations_alone() -> None:
    """ROS34PW2: eight equations; with any matrix in the place of J none of the seven may miss."""
    doc = copy.deepcopy(catalogue.document("ros34pw2"))
    system = equations_of(doc, {})
    assert (order_given(system), order_given(system, claim="w-order")) == (3, 3)
    fewer = replaced(doc, "order 1[2[1]]", "order 1[1]")  # alpha (alpha + gamma)
    assert (order_given(fewer), order_given(fewer, claim="w-order")) == (3, 2)
    (found,) = verify(load_document({**catalogue.document("ros34pw2"), "claims": {"order": 4}}))
    assert (found.verdict, found.value) == (Verdict.FAILS, 3)


@pytest.mark.parametrize(
    ("text", "order"), [("order 1[1[2]]", True), ("order o", False), ("column 1", False)]
)
def test_the_colour_of_a_leaf_makes_no_difference(text: str, order: bool) -> None:
    doc = copy.deepcopy(catalogue.document("ros34pw2"))
    texts = doc["enclosure"]["equations"]
    texts[texts.index("order 1[1[1]]")] = text
    if order:
        assert implied_by(doc, load_document(doc)) is not None
        return
    refused(DataError, "", equations_of, doc, {})


def test_the_equations_that_are_given_are_few_and_all_are_needed() -> None:
    system = equations_of(document(), {})
    assert len(system.equations) == len(system.unknowns) == 20
    assert system.columns
    assert (order_given(system), order_given(system, "embedded")) == (5, 4)
    texts = document()["enclosure"]["equations"]
    for text in texts:
        fewer = replaced(document(), text, "stage 1 1")  # says nothing: c = A 1
        assert (order_given(fewer), order_given(fewer, "embedded")) < (5, 4), text
    with pytest.raises(DataError, match="as many as the unknowns"):
        implied_by(doc := with_equations(texts[1:]), load_document(doc))


@pytest.mark.parametrize(
    ("place", "wrong"),
    [
        (("unknowns", "a43"), lambda x: x[:-1] + str((int(x[-1]) + 1) % 10)),
        (("unknowns", "e4"), lambda x: "2" + x[1:]),
        (("constants", "a31"), lambda x: x.replace("327", "328")),
        (("A", 1, 0), lambda _: "162/1000"),
        (("b", 1), lambda _: "1/101"),
        (("embedded", 0, "b", 6), lambda _: "1/67"),
    ],
)
def test_a_number_beside_the_right_one_proves_nothing(place: Any, wrong: Any) -> None:
    doc = document()
    inner: Any = doc
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = wrong(inner[place[-1]])
    refused((DataError, ExactnessError), "", implied_by, doc, load_document(doc))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"c": ["0"] * 7}, "not covered: c or a start"),
        ({"claims": {"symmetric": False}}, "must claim an order"),
    ],
)
def test_what_an_enclosure_cannot_mean_is_refused(changes: dict[str, Any], said: str) -> None:
    doc = document(**changes)
    refused(DataError, said, implied_by, doc, load(NAME))


@pytest.mark.parametrize(
    "text",
    [
        "column 8", "column 0", "stage 8 2", "stage 1 8", "stage 1", "embedded other [o]", "order",
        "defect 1", "embedded [o]",
    ],
)  # fmt: skip
def test_equations_without_a_meaning_are_refused(text: str) -> None:
    refused(DataError, "", replaced, document(), document()["enclosure"]["equations"][0], text)


@pytest.mark.parametrize(
    ("entry", "equations", "order"),
    [
        ("x/2+y", ["order [o]", "stage 1 1"], 2),  # b = 1, linear in the unknowns
        ("x+y", ["order [o]", "order o"], 2),
        ("x+y", ["order o", "stage 1 1"], 1),
    ],
)
def test_an_identity_needs_no_equation(entry: str, equations: list[str], order: int) -> None:
    d = {"name": "x", "class": "rk", "A": [[entry]], "b": ["1"], "digits": 20,
         "unknowns": {"x": "0." + "5" * 20, "y": "0." + "2" * 20},
         "enclosure": {"equations": equations}}  # fmt: skip
    assert order_given(equations_of(d, {})) == order


def gauss(s: int, **changes: Any) -> dict[str, Any]:
    return {**copy.deepcopy(catalogue.document(f"gauss-{s}")), **changes}


@pytest.mark.parametrize("s", [6, 7])
def test_of_a_gauss_method_every_equation_is_needed(s: int) -> None:
    system = equations_of(gauss(s), {})
    assert system.gauss and order_given(system) == 2 * s
    for k in range(len(system.equations)):
        doc = gauss(s)
        doc["enclosure"]["equations"][k] = "stage 1 1"  # says nothing: c = A 1
        assert not equations_of(doc, {}).gauss, k


@pytest.mark.parametrize(("s", "place"), [(6, ("A", 5, 0)), (7, ("A", 3, 4)), (6, ("b", 5))])
def test_half_of_the_equations_say_enough_of_a_mirrored_table_only(s, place):
    doc = gauss(s)
    inner: Any = doc
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = "b2"
    assert not equations_of(doc, {}).gauss


def test_the_stages_of_the_middle_follow_at_odd_powers_only() -> None:
    doc = gauss(7)
    assert all(equations_of(doc, {}).has_stage(3, k) for k in range(1, 8))
    doc["enclosure"]["equations"] = [
        "stage 1 1" if x.startswith("stage 4") else x for x in doc["enclosure"]["equations"]
    ]
    found = equations_of(doc, {})
    assert [k for k in range(1, 8) if found.has_stage(3, k)] == [1, 3, 5, 7]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("s", [6, 7, 8])
def test_a_gauss_method_has_every_property_of_its_kind(s: int) -> None:
    claims = {"order": 2 * s, "stage-order": s, "symplectic": True, "symmetric": True}
    doc = gauss(s, claims={**claims, "a-stable": True})
    assert {x.verdict for x in verify(load_document(doc))} == {Verdict.HOLDS}
    for wrong in ({"order": 2 * s - 1}, {"order": 2 * s + 1}, {"stage-order": s - 1}):
        found = verify(load_document(gauss(s, claims={"order": 2 * s, **wrong})))
        assert Verdict.FAILS in {x.verdict for x in found}, wrong
