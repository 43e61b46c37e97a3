"""Each hypothesis of the implications is asked for: without it nothing follows."""

import sys
from fractions import Fraction
from types import SimpleNamespace

import pytest

from glmref.catalogue.files import document
from glmref.errors import DataError
from glmref.exact.judging import fast_judge
from glmref.judge.enclosed_pair import Pair, listed
from glmref.judge.enclosed_rk import RungeKutta
from glmref.judge.enclosed_sweep import Sweep
from glmref.judge.enclosures import circle_is_named
from glmref.judge.fields import Numbers
from glmref.judge.linalg import diagonal
from glmref.judge.refusals import Refused
from glmref.prove.field import tower_of
from glmref.prove.implications import _orders, implied_by
from tests.build import refused


def pair(L, signs, *, zero=()):
    """What is asked of a pair whose halves have the involution L and the signs E."""
    L = [[Fraction(x) for x in row] for row in L]
    V = [[s * x for x in row] for s, row in zip(signs, L, strict=True)]  # L = V^-1 E, and L^2 = 1
    made = Pair.__new__(Pair)
    made.V, made.signs, made.one_step = {"f": V, "k": V}, {"f": signs, "k": signs}, False
    made.equations = [("start", t, k) for t, k in zero]
    return made


def start(made, most):
    """The largest order through which the start is 0."""
    return next(q for q in range(most, -1, -1) if made.zero_start_holds(q, False))


def test_a_value_that_parity_does_not_settle_needs_an_equation():
    even, odd = pair([[1, 0], [0, -1]], (1, 1)), pair([[1, 0], [0, 1]], (1, -1))
    assert start(even, 4) == 0
    assert start(odd, 4) == 1
    named = [(t, 1) for t in listed(2, False)]
    odd = pair([[1, 0], [0, 1]], (1, -1), zero=named)
    assert (start(odd, 4), start(odd, 3)) == (3, 3)
    for missing in range(len(named)):
        odd = pair([[1, 0], [0, 1]], (1, -1), zero=named[:missing] + named[missing + 1 :])
        assert start(odd, 4) == 1


@pytest.mark.parametrize("mixed", ["0", "1/3"])
def test_a_value_that_the_involution_mixes_with_another_has_no_parity(mixed):
    rest = [(t, 2) for t in listed(1, False)]
    made = pair([[1, 0, 0], [0, 1, mixed], [0, 0, -1]], (1, 1, 1), zero=rest)
    assert start(made, 4) == (1 if mixed == "0" else 0)


def test_an_order_of_the_identity_needs_first_values_that_are_the_solution(monkeypatch):
    doc = document("mclachlan-atela-4")

    def orders():
        implied = implied_by(doc, None)
        return {k: x for k, x in implied.at_least.items() if k.endswith(("order", "identity"))}

    assert orders() == {
        "order": 3, "effective-order": 3, "order-identity": 3, "nystrom-order": 4,
        "starting-order": 3, "nystrom-starting-order": 4,
    }  # fmt: skip
    kind = fast_judge().enclosed_pair.Pair
    monkeypatch.setattr(kind, "principal_is_zero", lambda self, p, identity, nystrom: not nystrom)
    assert orders()["nystrom-order"] == orders()["order-identity"] == 3
    monkeypatch.setattr(kind, "principal_is_zero", lambda self, p, identity, nystrom: False)
    assert orders().keys() == {
        "order", "effective-order", "starting-order", "nystrom-starting-order",
    }  # fmt: skip
    assert orders()["starting-order"] == orders()["nystrom-starting-order"] == 0


@pytest.mark.parametrize(
    ("at", "follows"), [((), True), ((5,), False), ((2, 4), False), ((6,), True)]
)
def test_an_order_with_the_identity_needs_every_first_value_below_it_zero(at, follows):
    made = Sweep.__new__(Sweep)
    made.root, made.q = [], 1
    made.series = lambda values, order: SimpleNamespace(
        eta={n: [Fraction(n in at), Fraction(1)] for n in range(1, order)}
    )
    root = SimpleNamespace(enclosed=made)
    record = SimpleNamespace(orders=[(6, False)], is_partitioned=False, root=root, order=6)
    found = _orders(record)  # type: ignore[arg-type]
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
    monkeypatch.setattr("glmref.prove.implications.target_of", lambda *x: asked.append(x))
    monkeypatch.setattr("glmref.prove.implications.prove_blocks", lambda *given: sys.exit())
    if proved:
        refused(SystemExit, "", implied_by, {}, method)
    else:
        assert implied_by({}, method) is None
    assert bool(asked) is proved


@pytest.mark.parametrize(("halves", "zeros"), [("fk", 2), ("f", None), ("k", None), ("", None)])
def test_growth_vanishes_where_both_halves_have_their_equations(halves, zeros):
    made = pair([[1, 0], [0, -1]], (1, 1))
    made.equations = [("growth", None, (half, Fraction(-1), [])) for half in halves]
    assert made.zero_growths() == zeros


@pytest.mark.parametrize(
    ("entries", "named", "zeros"),
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
    entries, named, zeros
):
    numbers = Numbers(tower_of(tuple(x for x in named if x == "i")).as_json())
    found = [numbers.entry(x, {}) for x in named]
    assert circle_is_named(diagonal([Fraction(x) for x in entries]), found) == zeros


def test_1_is_a_simple_eigenvalue_of_v():
    made = Sweep.__new__(Sweep)
    made.numbers = Numbers({"kind": "rational"})
    for entry, fine in (("-1", True), ("1", False)):
        V = [["1", "0"], ["0", entry]]
        made.document = {"V": V, "G": V}
        if fine:
            made.suppose({"o": "V"})
        else:
            refused(Refused, "not regular on the values 2 to r", made.suppose, {"o": "V"})


@pytest.mark.parametrize("name", ["yoshida-6-midpoint", "t115-i"])
def test_one_method_without_a_start_has_no_order_of_a_start_or_of_second_order_systems(name):
    doc = {k: v for k, v in document(name).items() if k not in ("starting", "finishing")}
    implied = implied_by(doc, None)
    assert implied is not None
    orders = {"starting-order", "nystrom-starting-order", "nystrom-order"}
    assert not orders & implied.at_least.keys()


def test_the_first_row_is_1_for_all_values_of_the_unknowns():
    doc = {**document("yoshida-6-midpoint")}
    row, more = list(doc["X"][0]), "1+1/1" + "0" * 80
    doc["X"] = [[more, *row[1:-1], more], *doc["X"][1:]]
    refused(DataError, "the first row of X is not 1", implied_by, doc, None)


@pytest.mark.parametrize(("without", "difference"), [((), True), (("y",), False), ((None,), False)])
def test_estimates_sum_to_zero_where_every_row_is_consistent(without, difference):
    """No equation is about the sum of a row that is not consistent."""
    made = RungeKutta.__new__(RungeKutta)
    made.rows = {row: [] for row in (None, "x", "y")}
    made.given = lambda tree, row: row not in without
    assert made.implies("embedded-difference") is difference
    made.rows = {None: []}
    assert not made.implies("embedded-difference")
