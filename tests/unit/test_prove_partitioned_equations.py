"""The recursion of the few conditions agrees with the theory's, which knows all of them."""

from fractions import Fraction

import pytest

from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.exact import exact
from glmref.method.component import SEPARABLE
from glmref.prove.classes import Family
from glmref.prove.enclosure import equations_of
from glmref.prove.equations import starting_series
from glmref.prove.system import Equation, SweepSystem
from glmref.theory.trees import halves, trees
from tests.bseries import order_residuals


def rational(name):
    """A shipped pair's document with its unknowns cut to short fractions: symmetric, of order 2."""
    doc = document(name)
    cut = {k: str(Fraction(v).limit_denominator(50)) for k, v in doc["unknowns"].items()}
    rest = {
        k: v for k, v in doc.items() if k not in ("unknowns", "enclosure", "digits", "starting")
    }
    return {**rest, "constants": {**cut, **doc["constants"]}, "claims": {"order": 2}}


def form_of(doc):
    system = SweepSystem(doc)
    return system, system.read({})[0]


def series_of(form, order, **more):
    return starting_series(form.blocks, form.G, order, family=Family.SEPARABLE, **more)


@pytest.mark.parametrize("name", ["pair-4-4", "pair-6-7"])
def test_residuals_agree_with_the_theory_where_principal_parts_are_zero(name):
    doc = rational(name)
    _, form = form_of(doc)
    series = series_of(form, 3, identity=True)
    known = order_residuals(load_document(doc), 3)
    for n in (1, 2, 3):
        for t in trees(n, SEPARABLE):
            assert series.residual[t] == known[t], t
    assert any(not x.is_zero() for x in known.values())  # they are not all zero by themselves


def test_moving_the_root_changes_the_sign_of_a_residual():
    doc = rational("pair-4-4")
    _, form = form_of(doc)
    series = series_of(form, 3)
    lower = [x for t, x in series.residual.items() if t.order < 3]
    assert all(x.is_zero() for x in lower)  # consistent and symmetric: order 2
    pairs = [(t, v * u) for t in trees(3, SEPARABLE) for u, v in halves(t)]
    assert len(pairs) == 4
    for t, other in pairs:
        assert series.residual[t] == -series.residual[other]


def test_a_pair_that_is_not_symmetric_has_residuals_of_even_order():
    doc = rational("pair-4-4")
    doc["v"] = [["v1", "v2", "v2", "v1"]]
    system, form = form_of(doc)
    assert system.signs() == ((1, -1), (1, 1)) or system.signs() is None
    doc["w"] = [["w1", "w2", "1/3", "w2", "w1"]]
    doc["v"] = [["v1", "v2", "v2", "v1/2"]]
    system, form = form_of(doc)
    assert system.signs() is None
    residual = series_of(form, 4).residual
    assert any(not x.is_zero() for t, x in residual.items() if t.order % 2 == 0)


def test_the_shipped_systems_vanish_at_their_digits():
    for name in ("pair-4-5", "pair-6-7", "kahan-li-6", "blanes-moan-rkn-6-11"):
        doc = document(name)
        system = SweepSystem(doc)
        values = [exact(Fraction(x)) for x in doc["unknowns"].values()]
        assert max(abs(float(x)) for x in system.residuals(values)) < 1e-70
        wrong = [values[0] + exact(Fraction(1, 10**6)), *values[1:]]
        assert max(abs(float(x)) for x in system.residuals(wrong)) > 1e-9


def test_what_kind_of_flow_a_file_is():
    for name, flow in (
        ("yoshida-verlet-8", "f"),
        ("blanes-moan-6", "splitting"),
        ("pair-6-7", None),
    ):
        assert equations_of(document(name), {"trees": "all"}).flow() == flow


def test_which_orders_the_equations_cover():
    pair = equations_of(document("pair-6-7"), {"trees": "all"})
    assert [pair.covered(n, False) for n in (1, 3, 5, 7)] == [True, True, True, False]
    rkn = equations_of(document("blanes-moan-rkn-6-11"), {"trees": "nystrom"})
    assert [rkn.covered(5, x) for x in (False, True)] == [False, True]


def test_principal_parts_are_zero_only_where_the_starts_say_so():
    doc = document("pair-6-7")
    assert SweepSystem(doc).identity_through(5, Family.SEPARABLE)
    equations = [x for x in doc["enclosure"]["equations"] if not x.startswith("start")]
    without = SweepSystem({**doc, "enclosure": {"equations": equations}})
    assert without.identity_through(3, Family.SEPARABLE)
    assert not without.identity_through(4, Family.SEPARABLE)


@pytest.mark.parametrize(
    "text", ["order", "order [oo]", "order f[f]", "growth -1", "start f[k]", "abscissa 1 = 0"]
)
def test_equations_without_meaning_are_refused(text):
    with pytest.raises((DataError, Exception), match=r"unknown|alternate|tree"):
        Equation.read(text, 2)


def test_other_classes_and_forms_are_refused():
    with pytest.raises(DataError, match="only files of class"):
        SweepSystem(document("gauss-2"))
    with pytest.raises(DataError, match="must preserve"):
        SweepSystem({**document("pair-4-4"), "V": [["1", "0"], ["0", "1"]]})
