"""Partitioned multistep methods in one-step form: orders, starts, reversibility, one force a step."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.catalogue.canonical import canonical
from glmref.catalogue.lookup import load, path_of
from glmref.catalogue.reader import load_document
from glmref.derive import recipes
from glmref.derive.multistep import TwoKicks, multistep_document, two_kick_document
from glmref.derive.recipes.multistep import SHIPPED, claims_of
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.findings import Verdict
from glmref.problems import problem
from glmref.prove import kernel
from glmref.prove.facts import Facts, facts_of
from tests.build import SOURCE, refused

#: Two kicks a step, of order 6.
TWO = {"p": "-1/2 1/4", "slopes": "1/2 -2/3", "weight": "3/8"}

Cosines = tuple[Sequence[str], Sequence[str]]

SECOND: Cosines = ((), ("-1/2", "1/4"))
SEPARABLE: Cosines = (("1/4", "-3/4"), ("5/8", "-1/3"))


def document(cosines: Cosines) -> dict[str, Any]:
    q, p = ([Fraction(x) for x in half] for half in cosines)
    found = multistep_document("found", q, p)
    claims = claims_of(2 * len(p) + 2, second=not q)
    return {**found, "title": "found", "claims": claims, "source": SOURCE}


def facts(cosines: Cosines) -> Facts:
    return facts_of(load_document(document(cosines)))


@pytest.mark.parametrize("cosines", [SECOND, SEPARABLE, ((), ("1/3",)), (("0",), ("-1/5",))])
def test_every_claim_of_the_construction_is_proved(cosines: Cosines) -> None:
    found = facts(cosines)
    for claim, value in claims_of(2 * len(cosines[1]) + 2, second=not cosines[0]).items():
        assert found.judge(claim, value).verdict is Verdict.HOLDS, claim


@pytest.mark.parametrize(
    ("cosines", "claim"),
    [(SECOND, "nystrom-order"), (SEPARABLE, "order"), (SEPARABLE, "order-identity")],
)
def test_the_order_is_not_higher(cosines: Cosines, claim: str) -> None:
    assert facts(cosines).judge(claim, 7).verdict is Verdict.FAILS


@pytest.mark.parametrize("claim", ["order", "order-identity", "starting-order"])
def test_trees_without_branches_and_all_trees_agree(monkeypatch, claim):
    # below order 9 all trees are compared: with the bound lowered the paths decide
    monkeypatch.setattr(kernel, "MAX_ORDER", (12, 3, 8, 6, 5))
    found = facts(SEPARABLE)
    assert found.judge(claim, 6).verdict is Verdict.HOLDS
    assert found.judge(claim, 7).verdict is Verdict.FAILS


@pytest.mark.parametrize(("cosines", "claim"), [(SECOND, "nystrom-"), (SEPARABLE, "")])
def test_a_start_with_a_wrong_stage_is_not_proved(monkeypatch, cosines, claim):
    monkeypatch.setattr(kernel, "MAX_ORDER", (12, 3, 8, 6, 5))
    broken = document(cosines)
    row = broken["starting"]["A"][-1]
    row[0] = str(Fraction(row[0]) + Fraction(1, 7))
    found = facts_of(load_document(broken))
    assert found.judge(f"{claim}starting-order", 6).verdict is not Verdict.HOLDS


def test_where_stages_are_not_the_solution_all_trees_are_compared(monkeypatch):
    # a splitting has stages of order 1: its paths alone hold through order 4 and more
    monkeypatch.setattr(kernel, "MAX_ORDER", (12, 3, 8, 6, 5))
    found = facts_of(load("forest-ruth-4")).kernel.order_range(free=False)
    assert found.lower <= 3


def test_rows_of_the_half_that_carries_fewer_values_are_zero() -> None:
    # they were whatever the memory held
    run = solve(
        problem("henon-heiles"), load_document(document(SECOND)), h=0.05, steps=50, every=5,
        history=True,
    )  # fmt: skip
    history = np.asarray(run.history)
    assert not history[1:, 1:, :2].any()


@pytest.mark.sampled(1, besides=("8", "10"))
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_methods_are_reproduced_bit_for_bit(name: str) -> None:
    derived = recipes.run("multistep", {"name": name}).documents[0]
    assert canonical(derived) == path_of(name).read_text(encoding="utf-8")


def test_any_cosines_can_be_derived() -> None:
    found = recipes.run("multistep", {"p": "-1/2 1/4"})
    assert found.documents[0]["name"] == "multistep-rkn-6-found"
    refused(UsageError, "fractions", recipes.run, "multistep", {"p": "x"})
    refused(UsageError, "`name` must be", recipes.run, "multistep", {"name": "multistep-3"})


@given(
    st.sampled_from([("1/3",), ("-1/2", "1/4")]),
    st.fractions(Fraction(-1, 9), Fraction(1, 9), max_denominator=99).filter(bool),
    st.lists(st.fractions(Fraction(-1, 9), Fraction(1, 9), max_denominator=99), max_size=1),
)
def test_an_error_begins_with_the_constant_that_is_given(p, first, more) -> None:
    constants = [*more[: len(p) - 1], first]
    given_ = {"p": " ".join(p), "constants": " ".join(map(str, constants))}
    found = recipes.run("multistep", given_).documents[0]
    order = 2 * (len(p) + 1 - len(constants))
    assert facts_of(load_document(found)).judge("nystrom-order", order + 1).verdict is Verdict.FAILS
    with mpmath.workdps(120):  # k = q'' at both ends, q by the stage p in the middle
        A, U, B, V = (mpmath.matrix(found["p"][key]) for key in "AUBV")
        x = mpmath.mpf(10) ** -15
        added = B * mpmath.matrix([1, mpmath.exp(x)])
        values = mpmath.lu_solve(mpmath.exp(x) * mpmath.eye(V.rows) - V, added)
        error = ((U * values)[0] + A[0, 0]) * x**2 / mpmath.expm1(x) - 1
        # the next coefficient is below 10^3, so that x^2 times it is below the tolerance
        assert abs(error / x**order - mpmath.mpf(first.numerator) / first.denominator) < 1e-24


def test_constants_are_for_second_order_systems_with_one_kick() -> None:
    for more in ({"q": "1/3", "p": "1/2"}, {"p": "1/2", "constants": "1/9 1/9"}, TWO):
        refused(UsageError, "constants", recipes.run, "multistep", {"constants": "1/9", **more})
    last = {"p": "1/2 -1/4", "constants": "1/9 0"}
    refused(UsageError, "must not be 0", recipes.run, "multistep", last)


@pytest.mark.parametrize("option", ["q", "slopes", "weight", "constants"])
def test_numbers_of_a_method_need_its_cosines(option: str) -> None:
    refused(UsageError, "give `p`", recipes.run, "multistep", {option: "1/3"})


def two_kicks() -> dict[str, Any]:
    return dict(recipes.run("multistep", TWO).documents[0])


def test_any_two_kicks_give_a_method_of_the_order_of_the_number_of_pairs() -> None:
    found = two_kicks()  # the recipe proves order, start, symmetry and the rest
    assert found["name"] == "multivalue-rkn-6-found"
    judged = facts_of(load_document(found))
    assert judged.judge("nystrom-order", 7).verdict is Verdict.FAILS
    assert judged.judge("nystrom-starting-order", 7).verdict is Verdict.FAILS


def test_two_steps_with_one_kick_are_one_with_two() -> None:
    c = [Fraction(309, 1000), Fraction(-1, 2)]
    one = load_document(multistep_document("one", [], c))
    twice = TwoKicks([2 * x * x - 1 for x in c], [1 - 2 * x for x in c], Fraction(1, 2))
    two = load_document(two_kick_document("two", twice))
    target = problem("henon-heiles")
    a = solve(target, one, h=0.05, steps=100).y[-1]
    b = solve(target, two, h=0.1, steps=50).y[-1]
    assert np.allclose(a, b, rtol=0, atol=1e-10)  # round-off of the weights of the start
