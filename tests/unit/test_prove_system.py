"""What follows from the equations of a file for all values of its unknowns; bounds of orders."""

import copy
import itertools
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

from glmref import DataError
from glmref.errors import ExactnessError
from glmref.exact import Ball, Exact, ball
from glmref.exact.expression import parse
from glmref.exact.judging import fast_judge
from glmref.judge.trees import read_tree, show, size
from glmref.prove import implications, starting
from glmref.prove.enclosure import conditions_of, equations_of, members_of, radius_of
from glmref.theory.starting_series import NotPreconsistent, component
from tests.adversary.deceive import shipped
from tests.build import refused

SWEEP = {
    "class": "sweep", "unknowns": {"a": "1/3"}, "constants": {},
    "V": [["1", "0"], ["0", "-1"]], "G": ["1", "-1"],
    "D": ["1/2", "1/2"], "X": [["1", "1"], ["a", "a"]], "claims": {},
    "enclosure": {"equations": []},
}  # fmt: skip


def system(**changes: Any) -> Any:
    return conditions_of({**copy.deepcopy(SWEEP), **changes})


def test_signs_are_those_of_the_rows_that_are_their_mirror_images() -> None:
    assert system().signs == {"o": [1, 1]}
    assert system(X=[["1", "1"], ["a", "-a"]]).signs == {"o": [1, -1]}
    assert system(X=[["1", "1"], ["a", "2*a"]]).signs is None, "no mirror image"
    assert system(D=["1/3", "2/3"]).signs is None, "the weights are none"
    # rows of opposite signs that G couples
    V, G = [["1", "0", "0"], ["0", "-1", "0"], ["0", "0", "-1"]], [["1", "0", "0"], ["0", "0", "1"],
                                                                   ["0", "1", "0"]]  # fmt: skip
    same = [["1", "1"], ["a", "a"], ["2*a", "2*a"]]
    assert system(V=V, G=G, X=same).signs == {"o": [1, 1, 1]}
    assert system(V=V, G=G, X=[*same[:2], ["2*a", "-2*a"]]).signs is None
    # a rotation is turned back by a change of one sign alone
    V = [["1", "0", "0"], ["0", "3/5", "-4/5"], ["0", "4/5", "3/5"]]
    turned = [["1", "1"], ["a", "a"], ["2*a", "-2*a"]]
    assert system(V=V, G=["1", "-1", "-1"], X=turned).signs == {"o": [1, 1, -1]}
    assert system(V=V, G=["1", "-1", "-1"], X=same).signs is None
    # L = V^-1 E keeps the second value, or changes its sign
    kept, turned = system(X=[["1", "1"], ["a", "-a"]]), system()
    assert kept.reversal()["o"][1][1] == 1 and turned.reversal()["o"][1][1] == -1


def test_stage_orders_follow_from_the_equations_of_the_first_half() -> None:
    d = shipped("s3i1-w3")

    def found(*equations: str) -> Any:
        return conditions_of({**d, "enclosure": {**d["enclosure"], "equations": equations}})

    whole = conditions_of(d)
    assert (whole.q, whole.order, whole.s) == (2, 5, 3)
    assert whole.signs == {"o": [1, -1, 1, 1]} and sorted(whole.explicit) == [0, 2]
    assert found("defect 1").q == 1, "the tree [o] is even: the middle stage needs its equation"
    assert found("defect 1", "defect 2", "defect 1 [oo]").q == 3, "and not for [oo]"
    assert found("defect 1", "defect 2", "defect 2 [oo]").q == 2
    assert (found("defect 1 [oo]").order, found().order) == (4, 2)
    # a series ends where no residual needs it
    series = whole.series(whole.published, 4)
    assert max(map(size, series.eta)) == 3 and series.condition(read_tree("[ooo]"))


@pytest.mark.parametrize(
    ("equation", "message"),
    [
        ("growth 2", "not simple"), ("explicit 4", "names another stage"),
        ("start 5", "names another stage"), ("start 0", "names another stage"),
        ("order f[k]", "names another tree"), ("abscissa 1 = sqrt(3)", "rational"),
        ("9" * 4000, "is no equation"), ("column " + "9" * 4000, "is no equation"),
        ("nothing", "is no equation"), ("abscissa 1", "an equation"), ("order o = 1", "an equation"),
    ],
)  # fmt: skip
def test_equations_without_a_meaning_are_refused_in_a_sentence(equation: str, message: str) -> None:
    d = shipped("s3i1-w3")
    d["enclosure"]["equations"] = [equation]
    found = refused(DataError, message, conditions_of, d)
    assert len(found) < 300


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [("s3i1-w3", "order [oo]", ("order", None, "[oo]")),
     ("s3i1-w3", "start 3", ("start", 2, "o")),
     ("s3i1-w3", "start 2 [o]", ("start", 1, "[o]")),
     ("s3i1-w3", "explicit 3", ("explicit", 2, None)),
     ("s3i1-w3", "defect 2", ("defect", 1, "[o]")),
     ("pair-6-7", "order f[kk]", ("order", "f[kk]")),
     ("pair-6-7", "start f[k] 2", ("start", "f[k]", 1))],
)  # fmt: skip
def test_what_the_name_of_an_equation_says(name: str, text: str, expected: Any) -> None:
    d = shipped(name)
    d["enclosure"] = {"equations": [text]}
    (found,) = conditions_of(d).equations
    assert tuple(show(x) if isinstance(x, tuple) else x for x in found) == expected


def test_growths_and_abscissae_are_read_with_their_numbers() -> None:
    d = shipped("s3i1-w3")
    d["enclosure"] = {"equations": ["growth -1", "abscissa 1 = 1/3"]}
    growth, abscissa = conditions_of(d).equations
    assert growth[:2] == ("growth", None) and growth[2][:2] == ("o", -1)
    assert abscissa[:2] == ("abscissa", 0) and str(abscissa[2]) == "1/3"


def test_blocks_that_the_theorems_do_not_speak_of_are_refused() -> None:
    refused(DataError, "first row and column of V or G", system, G=["2", "-1"])
    for V in ([["1", "1"], ["0", "-1"]], [["1", "0"], ["0", "-2"]]):
        refused(DataError, r"V\^T G V = G", system, V=V)
    refused(DataError, "I - V is not regular", system, V=[["1", "0"], ["0", "1"]])


def test_the_order_that_equations_give_ends_where_trees_are_compared(monkeypatch):
    found = equations_of(shipped("tsitouras-5-4"), {})
    assert implications.order_given(found) == 5
    for most in (5, 4, 2):
        monkeypatch.setattr(implications, "MAX_ORDER", most)
        assert implications.order_given(found) == most


def test_the_proof_of_a_method_names_what_is_free() -> None:
    def proof(name: str) -> dict[str, Any]:
        return members_of(shipped(name))

    free = proof("yoshida-6-midpoint")["free"]
    assert free["4"] == ["[ooo]"] and free.keys() == {"4", "6"}
    assert "free" not in proof("mclachlan-ss5-4")
    assert proof("mclachlan-ss5-4")["trees"] == "all"


def test_the_first_stage_begins_at_0_where_it_is_explicit_and_starts_at_order_two() -> None:
    """Each of the two equations alone says nothing, nor do they about another stage."""
    said = ("explicit 1", "explicit 2", "start 2 o", "abscissa 2 = 1/3")
    unknowns = dict.fromkeys("abcd", "0." + "5" * 75)
    for k in range(len(said) + 1):
        for equations in itertools.combinations(said, k):
            texts = [*equations, *["order [oo]"] * (4 - k)]
            doc = {**copy.deepcopy(SWEEP), "enclosure": {"equations": texts}, "unknowns": unknowns}
            fixed = equations_of(doc, {"free": {}}).abscissae()
            found = fixed and [Fraction(str(x)) for x in fixed]
            if "abscissa 2 = 1/3" in equations:
                both = {"explicit 1", "start 2 o"} <= set(equations)
                assert found == ([0, Fraction(1, 3)] if both else [Fraction(2, 3), Fraction(1, 3)])
            else:
                assert found == ([0, 1] if {"explicit 1", "start 2 o"} <= set(equations) else None)


@pytest.mark.parametrize(
    ("start", "nystrom", "fine"), [(4, 6, True), (6, 8, True), (7, 0, False), (6, 9, False)]
)
def test_a_start_has_the_orders_that_are_claimed_and_none_above_the_pair(start, nystrom, fine):
    record: Any = SimpleNamespace(method=SimpleNamespace(parts={"f": None, "k": None}))
    claims = {"order": 6, "nystrom-order": 8, "nystrom-starting-order": nystrom}
    for document in ({"claims": {**claims, "starting-order": start}, "starting": {"order": 1}},
                     {"claims": claims, "starting": {"order": start}}):  # fmt: skip
        if fine:
            found = starting.Target.of(document, record)
            assert (found.order, found.nystrom) == (start, nystrom)
        else:
            with pytest.raises(DataError, match="no higher order than the pair"):
                starting.Target.of(document, record)


@pytest.mark.parametrize(
    ("radius", "said"),
    [("1e-60", None), ("1e-999", None), ("0", "positive"), ("0e-60", "positive"),
     ("1.1e-60", "at most"), ("1e-59", "at most"), ("-1e-70", "a number such as"),
     (1, "a number such as")],
)  # fmt: skip
def test_radii_of_boxes(radius: Any, said: str | None) -> None:
    document = {"enclosure": {"radius": radius}}
    if said is None:
        assert radius_of(document) == Fraction(radius)
    else:
        refused(DataError, said, radius_of, document)


def matrices(*found: Any) -> list[Any]:
    return [tuple(tuple(map(Exact, row)) for row in x) for x in found]


def test_why_a_component_has_no_u() -> None:
    A, B, V = matrices([[0], [0]], [[1, 0]], [[1]])
    half, zero, unit = Fraction(1, 2), ((Exact(0),), (Exact(0),)), Fraction(1)
    refused(NotPreconsistent, "has U u = 0", component, A, zero, B, V)
    near = Ball.around(ball(0), Fraction(1, 10**9))
    refused(ExactnessError, "not decided within the digits", component, A, ((near,), (near,)), B, V)
    for second, shown in ((Exact(half), "0.5"), (Exact(unit) + parse("i"), "1\\+1j"),
                          (parse("i"), "0\\+1j")):  # fmt: skip
        with pytest.raises(NotPreconsistent, match=f"row 2 of U u is {shown} instead of 1"):
            component(A, ((Exact(1),), (second,)), B, V)


def test_an_enclosed_finish_is_proved_and_an_exact_one_is_left(monkeypatch):
    """Only what is enclosed has a proof: a start in decimals, and a finish that is."""
    digits = "0.14433756729740644112728719512548936391"
    monkeypatch.setattr(starting, "proposed", lambda key, block: {})
    monkeypatch.setattr(starting, "accepted", lambda *given: None)
    A = [["0", "0"], ["1/2", "0"]]
    opening = {"A": A, "B": [["0", "0"], ["0", digits]], "u": ["1", "0"]}

    def found(**blocks: Any) -> tuple[Any, list[str]]:
        numbers = fast_judge().fields.Numbers({"kind": "rational"})
        record = SimpleNamespace(
            document=blocks, finish=lambda *given: None,
            undoes=lambda: fast_judge().parity.undoes(numbers, *blocks.values()),
        )  # fmt: skip
        blocks_of: Any = SimpleNamespace(record=record, order=4, nystrom=None, start=None)
        made = starting.prove_blocks(blocks_of)
        return made.orders, list(made.proofs)

    begun, both = {"starting-order": 4}, {"starting-order": 4, "finishing-order": 4}
    alone, tested = ["starting"], ["starting", "finishing"]
    assert found(starting=opening) == (begun, alone)
    assert found(starting=opening, finishing={"A": [["0"]], "b": ["1/3"]}) == (begun, alone)
    opening["B"][0] = ["0", digits]
    assert found(starting=opening, finishing={"A": A, "b": ["0", digits]}) == (both, tested)
    inverse = starting.inverse_block(opening)
    assert found(starting=opening, finishing=inverse) == (both, alone)
    opening["B"] = [["0", "0"], ["0", "1/3"]]
    assert found(starting=opening) == ({}, [])
