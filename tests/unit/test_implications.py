"""Each hypothesis of the table of implications is asked for: without it nothing follows."""

import sys
from fractions import Fraction
from types import SimpleNamespace

import pytest

from glmref.catalogue.claims import EMBEDDED_DIFFERENCE, ORDER, STAGE_ORDER, W_ORDER
from glmref.catalogue.files import document
from glmref.errors import DataError
from glmref.exact import Exact, linalg
from glmref.prove import implications
from glmref.prove.classes import Family, classes
from glmref.prove.enclosure import Enclosure
from glmref.prove.implications import (
    _all_growths,
    _check_regular,
    _orders,
    _zero_growths,
    _zero_start,
    implied_by,
)
from glmref.prove.simplifying import Proved
from glmref.prove.system import Equation, SweepSystem


def pair(L, signs, *, zero=()):
    """What `_zero_start` asks of a pair whose halves have the involution L and the signs E."""
    L = tuple(tuple(Exact(Fraction(x)) for x in row) for row in L)
    V = linalg.matmul(linalg.diagonal([Exact(x) for x in signs]), L)  # L = V^-1 E, and L^2 = 1
    system = SweepSystem.__new__(SweepSystem)
    system.V = {"f": V, "k": V}
    system.signs = lambda: (signs, signs)
    system.equations = tuple(Equation(f"start {t} {k + 1}", "start", t, k) for t, k in zero)
    return system


def trees(n, family=Family.SEPARABLE):
    return classes(n, 1, family)


def test_a_value_that_parity_does_not_settle_needs_an_equation():
    even, odd = pair([[1, 0], [0, -1]], (1, 1)), pair([[1, 0], [0, 1]], (1, -1))
    assert _zero_start(even, 4, Family.SEPARABLE) == 0
    assert _zero_start(odd, 4, Family.SEPARABLE) == 1
    named = [(t, 1) for t in trees(2)]
    odd = pair([[1, 0], [0, 1]], (1, -1), zero=named)
    assert _zero_start(odd, 4, Family.SEPARABLE) == 3
    assert _zero_start(odd, 3, Family.SEPARABLE) == 3
    for missing in range(len(named)):
        odd = pair([[1, 0], [0, 1]], (1, -1), zero=named[:missing] + named[missing + 1 :])
        assert _zero_start(odd, 4, Family.SEPARABLE) == 1


@pytest.mark.parametrize("mixed", ["0", "1/3"])
def test_a_value_that_the_involution_mixes_with_another_has_no_parity(mixed):
    rest = [(t, 2) for t in trees(1)]
    system = pair([[1, 0, 0], [0, 1, mixed], [0, 0, -1]], (1, 1, 1), zero=rest)
    assert _zero_start(system, 4, Family.SEPARABLE) == (1 if mixed == "0" else 0)


def test_an_order_of_the_identity_needs_first_values_that_are_the_solution(monkeypatch):
    doc = document("mclachlan-atela-4")

    def orders():
        implied = implied_by(doc, None)
        assert implied is not None
        return {k: x for k, x in implied.at_least.items() if k.endswith(("order", "identity"))}

    assert orders() == {
        "order": 3, "effective-order": 3, "order-identity": 3, "nystrom-order": 4,
        "starting-order": 3, "nystrom-starting-order": 4,
    }  # fmt: skip
    monkeypatch.setattr(
        SweepSystem, "identity_through", lambda self, n, family: family is Family.SEPARABLE
    )
    assert orders()["nystrom-order"] == orders()["order-identity"] == 3
    monkeypatch.setattr(SweepSystem, "identity_through", lambda self, n, family: False)
    assert orders().keys() == {
        "order",
        "effective-order",
        "starting-order",
        "nystrom-starting-order",
    }
    assert orders()["starting-order"] == orders()["nystrom-starting-order"] == 0


@pytest.mark.parametrize(
    ("at", "follows"), [((), True), ((5,), False), ((2, 4), False), ((6,), True)]
)
def test_an_order_with_the_identity_needs_every_first_value_below_it_zero(at, follows):
    system = SweepSystem(document("t115-i"))
    zeta = {
        t: (Exact(int(n in at)), Exact(1)) for n in range(1, 7) for t in trees(n, Family.ROOTED)
    }
    made = SimpleNamespace(
        families=system.families, series=lambda *_, **__: SimpleNamespace(zeta=zeta)
    )
    given = SimpleNamespace(system=made, form=None, principal=None)
    record = SimpleNamespace(order=6, identity=Enclosure.identity.func(given))
    found = _orders(system, record)  # type: ignore[arg-type]
    assert found["order"] == 6
    assert found.get("order-identity") == (6 if follows else None)


IN_DECIMALS, EXACTLY = SimpleNamespace(is_exact=False), SimpleNamespace(is_exact=True)


@pytest.mark.parametrize(
    ("components", "exact", "starting", "proved"),
    [
        (1, True, IN_DECIMALS, True),
        (2, True, IN_DECIMALS, False),
        (1, False, IN_DECIMALS, False),
        (1, True, EXACTLY, False),
        (1, True, None, False),
    ],
)
def test_a_start_in_decimals_is_proved_of_one_exact_method(
    components, exact, starting, proved, monkeypatch
):
    method = SimpleNamespace(components=[None] * components, is_exact=exact, starting=starting)
    asked = []
    monkeypatch.setattr("glmref.prove.implications.target_of", asked.append)
    monkeypatch.setattr("glmref.prove.implications.prove_blocks", lambda *given: sys.exit())
    if proved:
        with pytest.raises(SystemExit):
            implied_by({}, method)
    else:
        assert implied_by({}, method) is None
    assert bool(asked) is proved


@pytest.mark.parametrize(("halves", "zeros"), [("qp", 2), ("q", None), ("p", None), ("", None)])
def test_growth_vanishes_where_both_halves_have_their_equations(halves, zeros):
    V = linalg.diagonal([Exact(1), Exact(-1)])
    system = SweepSystem.__new__(SweepSystem)
    system.V = {"f": V, "k": V}
    system.equations = tuple(
        Equation(f"growth {half} -1", "growth", colour=colour, value="-1")
        for half, colour in zip("qp", "fk", strict=True)
        if half in halves
    )
    assert _all_growths(system) == zeros


@pytest.mark.parametrize(
    ("diagonal", "named", "zeros"),
    [
        (["1", "-1"], ["-1"], 1),
        (["1", "1/2"], ["1/2"], None),  # an eigenvalue inside the circle
        (["1", "-1", "-1"], ["i"], None),  # no eigenvalue, with its conjugate
        (["1", "-1", "-1"], ["-1"], None),  # not simple
        (["1", "-1", "1/2"], ["-1"], None),  # not all of them
        (["1", "-1"], ["-1", "1"], 1),  # 1 is the principal one
    ],
)
def test_growth_equations_name_every_eigenvalue_as_a_simple_one_of_modulus_one(
    diagonal, named, zeros
):
    V = linalg.diagonal([Exact(Fraction(x)) for x in diagonal])
    assert _zero_growths(V, named) == zeros


def test_1_is_a_simple_eigenvalue_of_v():
    _check_regular(linalg.diagonal([Exact(1), Exact(-1)]), "V")
    with pytest.raises(DataError, match="multiple eigenvalue"):
        _check_regular(linalg.diagonal([Exact(1), Exact(1)]), "V")


@pytest.mark.parametrize("name", ["yoshida-6-midpoint", "t115-i"])
def test_one_method_without_a_start_has_no_order_of_a_start_or_of_second_order_systems(name):
    doc = {k: v for k, v in document(name).items() if k not in ("starting", "finishing")}
    implied = implied_by(doc, None)
    assert implied is not None
    orders = {"starting-order", "nystrom-starting-order", "nystrom-order"}
    assert not orders & implied.at_least.keys()


def test_the_sentence_about_the_first_row_names_no_component_of_one_method():
    doc = {**document("yoshida-6-midpoint")}
    doc["X"] = [["1+1/1" + "0" * 80, *doc["X"][0][1:]], *doc["X"][1:]]
    with pytest.raises(DataError, match="the first row of `X` must be 1"):
        implied_by(doc, None)


@pytest.mark.parametrize(
    ("orders", "difference"),
    [({"": 5}, False), ({"": 5, "x": 1, "y": 0}, False), ({"": 5, "x": 1, "y": 2}, True)],
)
@pytest.mark.parametrize("kind", ["rk", "rosenbrock"])
def test_estimates_sum_to_zero_where_every_row_is_consistent(kind, orders, difference, monkeypatch):
    """An order 0 of a row says that no equation is about its sum."""
    monkeypatch.setattr(implications, "prove_runge_kutta", lambda document: Proved(orders, 3))
    found = implications.implied_by({"class": kind, "enclosure": {}, "claims": {"order": 5}}, None)
    assert found is not None
    assert (EMBEDDED_DIFFERENCE.key in found.true) == difference
    assert found.of_row("y").at_least == {ORDER.key: orders.get("y", 0)}
    assert found.at_least.get(W_ORDER.key) == (3 if kind == "rosenbrock" else None)
    assert found.at_least.get(STAGE_ORDER.key) == (1 if kind == "rk" else None)
