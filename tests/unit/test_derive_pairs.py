"""From an ansatz to a proved pair: equations, free parameters, recipes and the search."""

import os

import pytest

from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.derive import recipes
from glmref.derive.parameters import fix_parameters
from glmref.derive.partitioned import PairAnsatz, complete_pair, search_pairs
from glmref.derive.recipes.shipped_pairs import SHIPPED
from glmref.errors import DataError, UsageError
from glmref.prove.enclosure import conditions_of
from glmref.theory.stability import parasitic_curvature
from tests.build import SOURCE, refused


def test_an_ansatz_says_its_stages_rows_and_equations():
    doc = PairAnsatz("x", 4, 4).document()
    assert doc["stages"] == "PQPQPQPQP"
    assert doc["b"] == ["b1", "b2", "b3", "b2", "b1"]
    assert doc["w"] == [["w1", "w2", "0", "-w2", "-w1"]]
    assert doc["v"] == [["v1", "v2", "-v2", "-v1"]]
    assert doc["constants"] == {"b3": "1-2*b1-2*b2", "c2": "(1-2*c1)/2"}
    assert doc["enclosure"]["equations"][:2] == ["order f[kk]", "order f[k[f]]"]
    assert PairAnsatz("x", 3, 4, outer="Q").stages == "QPQPQ"


@pytest.mark.parametrize(
    ("order", "nystrom", "equations"),
    [(4, False, 4), (6, False, 10), (6, True, 8), (8, False, 32), (8, True, 18)],
)
def test_the_number_of_equations(order, nystrom, equations):
    # one for each free tree of orders 3, 5, .. and two growth parameters
    assert len(PairAnsatz("x", 9, order, nystrom=nystrom).equations()) == equations


def test_palindromes_hold_for_all_values_of_the_unknowns():
    for ansatz in (PairAnsatz("x", 5, 6, starts="qp"), PairAnsatz("x", 4, 4, outer="Q", g=-1)):
        assert conditions_of(ansatz.document()).signs == {"f": [1, -1], "k": [1, -1]}


def test_an_ansatz_whose_principal_parts_are_not_zero_is_refused_before_it_is_searched():
    with pytest.raises(DataError, match="a principal part is not 0"):
        next(search_pairs(PairAnsatz("x", 5, 6), seed=1, starts=1))


def test_an_ansatz_fixes_only_what_it_has():
    document = PairAnsatz("x", 4, 4, fixed={"z1": "1"}).document
    refused(UsageError, "`fixed` names 'z1'", document)


@pytest.mark.slow
def test_a_search_is_reproducible_and_ends_in_a_proved_pair():
    ansatz = PairAnsatz("found", 4, 4)
    first, second = (list(search_pairs(ansatz, seed=3, starts=16)) for _ in range(2))
    assert first == second
    found = next(x for x in first if x.residual < 1e-10)
    square, start = fix_parameters(ansatz, found.point)
    assert len(square.fixed) == 3  # 7 unknowns, 4 equations
    doc, proof = complete_pair(square, [repr(x) for x in start], source=SOURCE)
    assert (proof.order, proof.identity) == (4, True)
    assert doc["claims"]["reducible"] is False


@pytest.mark.slow
def test_the_recipe_reproduces_a_shipped_pair():
    derivation = recipes.run("pairs", {"name": "pair-6-7"})
    assert [dict(x) for x in derivation.documents] == [document("pair-6-7")]
    assert "order 6" in derivation.statements[0].text


@pytest.mark.slow
@pytest.mark.sampled(1, whole=4)
@pytest.mark.parametrize(  # a minute each those of order 8
    "name",
    [x for x in SHIPPED if x != "pair-6-7" and ("8-" not in x or "GLMREF_LONG" in os.environ)],
)
def test_the_recipe_reproduces_the_other_shipped_pairs(name):
    assert [dict(x) for x in recipes.run("pairs", {"name": name}).documents] == [document(name)]


@pytest.mark.slow
def test_the_search_of_the_recipe_completes_a_pair_or_says_how_near_it_came():
    options = {"n": "4", "order": "4", "starts": "", "seed": "3", "tries": "16"}
    derivation = recipes.run("pairs", options)
    assert len(derivation.documents) == 1
    assert "16 starts" in derivation.statements[-1].text
    for wrong in (
        {"n": "x"},
        {"n": "4", "nystrom": "maybe"},
        {"n": "4", "circle": "maybe"},
        {"name": "pair-5-5"},
    ):
        refused(UsageError, "", recipes.run, "pairs", wrong)


@pytest.mark.slow
def test_a_search_passes_over_pairs_that_leave_the_unit_circle():
    options = {"n": "5", "order": "4", "starts": "", "seed": "3", "tries": "32", "wanted": "99"}
    free = recipes.run("pairs", options).documents
    kept = recipes.run("pairs", {**options, "circle": "yes"})
    signs = {x["name"]: parasitic_curvature(load_document(x)).real.sign() for x in free}
    assert set(signs.values()) == {1, -1}
    assert {x["name"] for x in kept.documents} == {name for name, s in signs.items() if s > 0}
    left = [x for x in kept.statements if "leave the unit circle" in x.text]
    assert len(left) == sum(1 for s in signs.values() if s < 0)


def test_without_a_start_on_record_the_claim_is_the_one_the_equations_give():
    for name, expected in (("pair-4-4", 1), ("pair-6-7", 1), ("pair-rkn-6-7", 3)):
        shipped = SHIPPED[name]
        doc, _ = complete_pair(shipped.ansatz, shipped.start.split(), source=SOURCE)
        assert doc["claims"]["starting-order"] == expected
        assert "starting" not in doc
