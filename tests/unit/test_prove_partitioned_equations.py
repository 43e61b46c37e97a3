"""The series of pairs agree with the theory's; which of their conditions are needed."""

from fractions import Fraction

import pytest

from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.exact import exact
from glmref.exact.judging import as_scalar, consulted
from glmref.judge.trees import read_tree
from glmref.method.component import SEPARABLE
from glmref.prove.enclosure import conditions_of, equations_of, gaps_of
from glmref.theory.trees import halves, trees
from tests.bseries import order_residuals


def cut(name):
    """Return short fractions near the unknowns of a shipped pair: symmetric, of order 2."""
    unknowns = document(name)["unknowns"]
    return {k: Fraction(v).limit_denominator(50) for k, v in unknowns.items()}


def residuals_of(doc, values, order):
    """Return R at all trees through an order, from the judge's series."""
    with consulted() as judge:
        numbers = [judge.arithmetic.Fraction(x.numerator, x.denominator) for x in values.values()]
        series = conditions_of(doc).series(numbers, order, False)
        return {
            t: as_scalar(series.condition(read_tree(str(t)))[0])
            for n in range(1, order + 1)
            for t in trees(n, SEPARABLE)
        }


@pytest.mark.parametrize("name", ["pair-4-4", "pair-6-7"])
def test_residuals_agree_with_the_theory_where_principal_parts_are_zero(name):
    doc, values = document(name), cut(name)
    found = residuals_of(doc, values, 3)
    without = ("unknowns", "enclosure", "digits", "starting")
    rest = {k: v for k, v in doc.items() if k not in without}
    constants = {**{k: str(x) for k, x in values.items()}, **doc["constants"]}
    known = order_residuals(load_document({**rest, "constants": constants, "claims": {}}), 3)
    assert all(found[t] == known[t] for t in found)
    assert any(not x.is_zero() for x in known.values())  # they are not all zero by themselves


def test_moving_the_root_changes_the_sign_of_a_residual():
    residual = residuals_of(document("pair-4-4"), cut("pair-4-4"), 3)
    # consistent and symmetric: order 2
    assert all(x.is_zero() for t, x in residual.items() if t.order < 3)
    pairs = [(t, v * u) for t in trees(3, SEPARABLE) for u, v in halves(t)]
    assert len(pairs) == 4
    for t, other in pairs:
        assert residual[t] == -residual[other]


def test_a_pair_that_is_not_symmetric_has_residuals_of_even_order():
    doc = {**document("pair-4-4"), "enclosure": {"equations": []}}
    doc["w"], doc["v"] = [["w1", "w2", "1/3", "w2", "w1"]], [["v1", "v2", "v2", "v1/2"]]
    assert conditions_of(doc).signs is None
    residual = residuals_of(doc, cut("pair-4-4"), 4)
    assert any(not x.is_zero() for t, x in residual.items() if t.order % 2 == 0)


def test_the_shipped_systems_vanish_at_their_digits():
    for name in ("pair-4-5", "pair-6-7", "kahan-li-6", "blanes-moan-rkn-6-11"):
        doc = document(name)
        gaps = gaps_of(doc)
        values = [exact(Fraction(x)) for x in doc["unknowns"].values()]
        assert max(abs(float(x)) for x in gaps(values)) < 1e-70
        wrong = [values[0] + exact(Fraction(1, 10**6)), *values[1:]]
        assert max(abs(float(x)) for x in gaps(wrong)) > 1e-9


def test_what_kind_of_flow_a_file_is():
    for name, flow in (
        ("yoshida-verlet-8", "f"),
        ("blanes-moan-6", "splitting"),
        ("pair-6-7", None),
    ):
        assert equations_of(document(name), {"trees": "all"}).flow() == flow


def test_principal_parts_are_zero_only_where_the_starts_say_so():
    doc = document("pair-6-7")
    assert conditions_of(doc).identity_through(5, False)
    equations = [x for x in doc["enclosure"]["equations"] if not x.startswith("start")]
    with pytest.raises(DataError, match="a principal part is not 0"):
        conditions_of({**doc, "enclosure": {"equations": equations}})
    without = conditions_of({**doc, "enclosure": {"equations": equations[:2]}})
    assert without.identity_through(3, False)
    assert not without.identity_through(4, False)


@pytest.mark.parametrize(
    "text",
    ["order", "order [oo]", "order f[f]", "growth -1", "start f[k]", "start f[k] 3",
     "abscissa 1 = 0", f"order f[{'f' * 1500}]", "growth q 2"],
)  # fmt: skip
def test_equations_without_meaning_are_refused(text):
    doc = {**document("pair-6-7"), "enclosure": {"equations": [text]}}
    with pytest.raises(DataError, match=r"no equation|another|tree|not simple") as found:
        conditions_of(doc)
    assert len(str(found.value)) < 300
