"""What the interval test proves of pairs, and what it refuses."""

import copy

import pytest

from glmref.catalogue.lookup import document, names
from glmref.catalogue.reader import load_document
from glmref.errors import DataError, ExactnessError
from glmref.exact import Ball, ball
from glmref.exact.judging import as_scalar, consulted
from glmref.findings import Proof, Verdict
from glmref.prove.enclosure import Enclosure, prove
from glmref.prove.implications import implied_by
from glmref.prove.verifier import verify
from tests.build import refused
from tests.shipped import shipped

ENCLOSED = [x for x in names("methods") if "enclosure" in shipped(x)]
PAIRS = [x for x in ENCLOSED if shipped(x)["class"] in ("pair-sweep", "splitting")]
#: `glmref verify`, which CI runs, proves the others.
QUICK = ["pair-4-4", "pair-6-7", "yoshida-verlet-6", "blanes-moan-rkn-6-11"]


def conditions(proof: Enclosure) -> list[Ball]:
    """The equations and all conditions up to the orders at the root, those too that follow."""
    found = proof.root.enclosed
    with consulted():
        gaps = found.residuals(found.root)
        for order, nystrom in proof.orders:
            series = found.series(found.root, order, nystrom)
            level = [t for n in range(1, order + 1) for t in series.pool(n)]
            gaps += [x for t in level for x in series.condition(t)]
        return [ball(as_scalar(x)) for x in gaps]


def test_every_pair_of_class_pair_sweep_is_enclosed():
    assert set(QUICK) <= set(PAIRS)
    assert all(x in PAIRS for x in names("methods") if shipped(x)["class"] == "pair-sweep")


@pytest.mark.parametrize("name", QUICK)
def test_a_published_pair_is_proved(name):
    doc = document(name)
    proof = prove(doc)
    assert proof.order == doc["claims"]["order"]
    assert proof.nystrom_order == doc["claims"].get("nystrom-order", proof.order)
    assert proof.identity
    assert all(x.contains_zero() and x.magnitude() < 1e-50 for x in conditions(proof))
    implied = implied_by(doc, None)
    assert {"g-symplectic", "symmetric", "consistent"} <= implied.true
    assert ("symplectic" in implied.true) == (doc["class"] == "splitting")
    assert implied.at_least["order"] == implied.at_least["order-identity"] == proof.order


@pytest.mark.parametrize("name", QUICK)
def test_every_finding_on_it_is_enclosed(name):
    findings = verify(load_document(document(name)))
    assert {x.verdict for x in findings} == {Verdict.HOLDS}
    exact = {x.claim for x in findings if x.proof is Proof.EXACT}
    assert exact <= {"explicit", "zero-stable"}  # exact zeros, an exact V
    assert Proof.MEASURED not in {x.proof for x in findings}
    assert all(x.residual < 1e-50 for x in findings)


def changed(name, **changes):
    doc = copy.deepcopy(document(name))
    for key, change in changes.items():
        change(doc[key])
    return doc


def test_a_digit_that_is_wrong_is_refused():
    def last_but_one(unknowns):
        text = unknowns["v2"]
        unknowns["v2"] = text[:-2] + str((int(text[-2]) + 5) % 10) + text[-1]

    with pytest.raises(ExactnessError, match="is not satisfied within the published digits"):
        prove(changed("pair-4-4", unknowns=last_but_one))


def test_equations_that_do_not_give_the_order_are_refused():
    doc = changed("pair-6-7", claims=lambda x: x.update(order=8))
    refused(DataError, "do not give the conditions of order 7", prove, doc)

    def forget(enclosure):
        texts = enclosure["equations"]
        texts[texts.index("order f[kkkk]")] = "order f[kk]"

    with pytest.raises(DataError, match=r"conditions of order 5; those of f\[kkkk\]"):
        prove(changed("pair-6-7", enclosure=forget))
    rkn = changed("blanes-moan-rkn-6-11", claims=lambda x: x.update(order=6))
    refused(DataError, "do not give the conditions of order 5", prove, rkn)


def test_numbers_that_are_not_palindromic_are_refused():
    doc = changed("pair-4-4", v=lambda rows: rows.__setitem__(0, ["v1", "v2", "-v2", "v1"]))
    refused(DataError, "must be palindromic", prove, doc)


def test_the_number_of_equations_and_the_radius_are_checked():
    extra = changed("pair-4-4", enclosure=lambda x: x["equations"].append("start f[k] 2"))
    refused(DataError, r"as many as the unknowns \(4\), got 5", prove, extra)
    wide = changed("pair-4-4", enclosure=lambda x: x.update(radius="1e-20"))
    refused(DataError, "at most 1e-60", prove, wide)


@pytest.mark.parametrize("change", ["-({})", "{}0", "1/3"])
def test_unknowns_of_an_enclosure_that_are_no_decimals_of_its_digits_are_bad_input(change):
    doc = copy.deepcopy(document("omelyan-pefrl-4"))
    doc["unknowns"]["xi"] = change.format(doc["unknowns"]["xi"])
    refused(DataError, "decimals with `digits` digits", prove, doc)
