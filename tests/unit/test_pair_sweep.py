"""The pure builder of explicit pairs: its theorems for all numbers, and its errors."""

from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.catalogue.lookup import document, load
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.exact import exact, linalg
from glmref.findings import Verdict
from glmref.method import as_matrix, as_vector
from glmref.method.sweep import build_partitioned as build
from glmref.prove.verifier import verify
from glmref.theory.parasitism import growth
from glmref.theory.symmetry import symmetry
from glmref.theory.symplectic import form_identities
from tests.build import refused

SIGNS = as_matrix([["1", "0"], ["0", "-1"]], "V")
FORM = as_matrix([["1", "0"], ["0", "1"]], "G")
numbers = st.fractions(-3, 3, max_denominator=7)


def vectors(size):
    return st.lists(numbers, min_size=size, max_size=size).map(lambda x: as_vector(x, "x"))


def pair(b, w, c, v, stages="PQPQP", V=SIGNS, V_hat=SIGNS, G=FORM):
    return build(
        as_vector(b, "b"), as_vector(c, "c"), w=as_matrix([w], "w"), v=as_matrix([v], "v"),
        V=V, V_hat=V_hat, G=G, stages=stages,
    )  # fmt: skip


def defects(p):
    residuals = form_identities(p, p.G, p.D_P, p.D_Q)
    return [x for _, m in residuals for _, _, x in linalg.entries(m) if not x.is_zero()]


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(b=vectors(3), w=vectors(3), c=vectors(2), v=vectors(2))
def test_the_identities_hold_for_all_numbers(b, w, c, v):
    p = build(b, c, w=(w,), v=(v,), V=SIGNS, V_hat=SIGNS, G=FORM, stages="PQPQP")
    assert defects(p) == []


@settings(max_examples=10, deadline=None)
@given(b=vectors(3), w=vectors(6), c=vectors(2), v=vectors(4))
def test_the_identities_hold_with_three_values_and_any_order_of_stages(b, w, c, v):
    turn = as_matrix([["1", "0", "0"], ["0", "0", "-1"], ["0", "1", "0"]], "V")
    form = linalg.identity(3)
    p = build(b, c, w=(w[:3], w[3:]), v=(v[:2], v[2:]), V=turn, V_hat=turn, G=form, stages="PPQQP")
    assert defects(p) == []


def test_a_changed_entry_breaks_the_identities():
    p = pair([1, 2, 3], [1, 0, 1], ["1/2", "1/2"], [1, 2])
    A_hat = [list(row) for row in p.A_hat]
    A_hat[2][0] = A_hat[2][0] + exact(Fraction(1, 1000))
    assert len(defects(replace(p, A_hat=A_hat))) == 1


@settings(max_examples=10, deadline=None)
@given(b=vectors(2), w=vectors(1), c=vectors(1), v=vectors(1))
def test_palindromic_numbers_give_a_symmetric_pair(b, w, c, v):
    weights, couplings = (b[0], b[1], b[0]), (w[0], exact(0), -w[0])
    p = build(
        weights, (c[0], c[0]), w=(couplings,), v=((v[0], -v[0]),), V=SIGNS, V_hat=SIGNS, G=FORM,
        stages="PQPQP",
    )  # fmt: skip
    assert symmetry(p).holds is True


def test_growth_parameters_are_the_weighted_squares_of_the_couplings():
    p = pair([1, -1, 1], [1, 2, 3], ["1/2", "1/2"], ["1/3", 1], G=as_matrix(
        [["1", "0"], ["0", "-1"]], "G"
    ))  # fmt: skip
    (found,) = growth(p).growths
    assert found.matrices["mu_q"][0][0] == -(1 - 4 + 9)
    assert found.matrices["mu_p"][0][0] == -(Fraction(1, 18) + Fraction(1, 2))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"stages": "PQPPQ"}, None),
        ({"stages": "PQPQQ"}, "one P for each of the 3 entries"),
        ({"stages": "PQxQP"}, "letters P and Q"),
        ({"stages": ""}, "letters P and Q"),
        ({"w": [1, 2]}, r"`w` must have shape \(1, 3\), got \(1, 2\)"),
        ({"V": linalg.identity(3)}, r"`V` must have shape \(2, 2\), got \(3, 3\)"),
        ({"V": linalg.identity(2)}, "must preserve `G` exactly"),
    ],
)
def test_wrong_pieces_are_named(change, message):
    pieces = {"b": [1, 2, 3], "w": [1, 0, 1], "c": [1, 2], "v": [1, 2], **change}
    if message is None:
        assert pair(**pieces).n_P == 3
    else:
        refused(DataError, message, pair, **pieces)


def test_a_file_is_read_into_the_built_pair():
    doc = {k: v for k, v in document("pair-4-4").items() if k != "enclosure"}
    assert load("pair-4-4").n_Q == 4
    with pytest.raises(DataError, match="the key 'G' is missing"):
        load_document({k: v for k, v in doc.items() if k != "G"})
    refused(DataError, "'D' is unknown", load_document, {**doc, "D": ["1"]})
    with pytest.raises(DataError, match="no meaning for a pair"):
        load_document({**doc, "claims": {"a-stable": True}})


def test_a_pair_that_carries_one_value_of_each_has_no_further_rows():
    one = [["1"]]
    given = {"stages": "PQP", "b": ["1/2", "1/2"], "c": ["1"], "V": one, "V_hat": one, "G": one}
    shared = {"format": "glmref-method-1", "name": "leapfrog", "class": "pair-sweep"}
    said = {"citation": "x", "where": "x", "status": "derived"}
    document = {**shared, **given, "claims": {"order": 2, "symmetric": True}, "source": said}
    found = verify(load_document(document))
    assert [x.verdict for x in found] == [Verdict.HOLDS] * 2
