"""Starts and finishes with parity: their form is checked, their digits are proved."""

from __future__ import annotations

import copy
from fractions import Fraction
from typing import Any

import pytest

from glmref.catalogue.canonical import canonical
from glmref.catalogue.lookup import document, load
from glmref.derive.linear_start import collocation, linear_start, tableau
from glmref.derive.parity_start import finishing_block, starting_block
from glmref.derive.recipes.solved import rough_starts
from glmref.errors import DataError, ExactnessError
from glmref.exact import Exact
from glmref.method import as_matrix
from glmref.prove.enclosure import prove
from glmref.prove.krawczyk import Outcome
from glmref.prove.starting import (
    StartingSystem,
    Target,
    first_value,
    functionals,
    inverse_block,
    is_inverse,
    needed_stages,
    prove_finishing,
    prove_starting,
    starting_system,
)
from glmref.prove.tableau_series import stage_order, weights
from glmref.theory.trees import parse_tree, trees
from tests.bseries import elementary_weights

NAME = "t115-i"


def without_start(name: str) -> dict[str, Any]:
    doc = copy.deepcopy(document(name))
    del doc["starting"], doc["finishing"]
    return doc


@pytest.fixture(scope="module")
def target() -> Target:
    doc = without_start(NAME)
    record = prove(doc)
    return Target.of(doc, record.system, record.series)


def test_weights_are_the_elementary_weights() -> None:
    A = as_matrix([["0", "0", "0"], ["1/3", "0", "0"], ["-1/2", "1/5", "0"]], "A")
    rows = as_matrix([["1", "2", "3"], ["0", "-1", "1/2"]], "B")
    found = weights(A, rows, 5)
    expected = elementary_weights(A, rows, 5, u=(0, 0))
    for n in range(1, 6):
        for t in trees(n):
            assert [x[t] for x in found] == list(expected[t])


def test_parity_halves_the_work_and_changes_nothing() -> None:
    block = starting_block(
        2, ["1/2", "1", "1/3", "1/4", *("1/5", "1/6"), *("1/7", "1/8", "1/9"), *("1", "2", "3")],
        root="i", free=False, last_even=False,
    )  # fmt: skip
    A, B = as_matrix(block["A"], "A"), as_matrix(block["B"], "B")
    plain, short = weights(A, B, 6), weights(A, B, 6, parity=True)
    for n in range(1, 7):
        for t in trees(n):
            assert [x[t] for x in plain] == [x[t] for x in short]
    # y_2 + y_3 is even and y_2 - y_3 odd for z = i; y_4 is odd.
    for n in range(1, 7):
        for t in trees(n):
            even, odd = plain[1][t] + plain[2][t], plain[1][t] - plain[2][t]
            assert (odd if n % 2 == 0 else even).is_zero()
            assert n % 2 == 1 or plain[3][t].is_zero()


def test_a_shipped_start_and_finish_are_proved(target: Target) -> None:
    doc = document(NAME)
    start = prove_starting(doc["starting"], target)
    assert start.outcome is Outcome.UNIQUE
    assert len(start.box) == 54  # 5 + 25 conditions at even trees, 12 + 12 at odd ones
    assert start.contraction < 1e-40
    base = first_value(doc["starting"], start.box, 6)
    finish = prove_finishing(doc["finishing"], base, 6)
    assert len(finish.box) == 25


def test_a_start_for_another_method_is_refused(target: Target) -> None:
    other = document("s5i1-i")["starting"]
    with pytest.raises(ExactnessError, match="interval test"):
        prove_starting(other, target)


def test_a_changed_rational_entry_is_refused(target: Target) -> None:
    block = copy.deepcopy(document(NAME)["starting"])
    for i, row in enumerate(block["A"]):
        for j, text in enumerate(row):
            if "/" in text:
                mirror = (i + 1 if i % 2 else i - 1), (j and (j + 1 if j % 2 else j - 1))
                value = Fraction(text) + Fraction(1, 1000)
                block["A"][i][j], block["A"][mirror[0]][mirror[1]] = str(value), str(-value)
                with pytest.raises(ExactnessError):
                    prove_starting(block, target)
                return
    raise AssertionError("no rational entry found")


def test_a_start_without_parity_is_refused(target: Target) -> None:
    block = copy.deepcopy(document(NAME)["starting"])
    block["A"][1][0] = "1/2"
    with pytest.raises(DataError, match="no parity"):
        prove_starting(block, target)


def test_a_start_from_another_multiple_of_y0_is_refused(target: Target) -> None:
    block = {**document(NAME)["starting"], "u": ["1", "1", "0", "0"]}
    with pytest.raises(DataError, match=r"`starting\.u`"):
        prove_starting(block, target)


def test_an_even_number_of_stages_is_refused() -> None:
    block = {"A": [["0", "0"], ["1/2", "0"]], "b": ["0", "1"]}
    with pytest.raises(DataError, match="odd number"):
        prove_finishing(block, {}, 6)


def test_decimals_are_unknowns_and_rationals_are_not() -> None:
    long = "0." + "12345" * 15
    system = StartingSystem([["1/2", f"-{long}"], [f"{long}*sqrt(3)+1/4", "0.5"[:1]]])
    assert system.unknowns == (long,)
    assert system.read([Exact(2)])[1][0] == Exact(3).sqrt() * 2 + Fraction(1, 4)


def test_every_conjugation_method_has_a_start_and_a_finish() -> None:
    for name, record in rough_starts().items():
        if "linear" in record or "finish" not in record:
            continue
        method = load(name)
        assert method.starting is not None and method.finishing is not None
        assert method.starting.stages == 2 * record["start"]["pairs"] + 1 <= 21
        assert method.finishing.stages == 2 * record["finish"]["pairs"] + 1 <= 15


def test_collocation_integrates_polynomials() -> None:
    nodes = [Fraction(0), Fraction(1, 2), Fraction(1)]
    rows = collocation(nodes)
    for k in range(3):
        for row, c in zip(rows, nodes, strict=True):
            assert sum(a * x**k for a, x in zip(row, nodes, strict=True)) == c ** (k + 1) / (k + 1)


@pytest.mark.parametrize("moments", [2, 3])
def test_rational_tableaux_have_parity_and_their_stage_order(moments: int) -> None:
    rows = tableau([{"c": "3/5", "3": "1/4"}, {"c": "-1/3", "7": "1/2", "4": "2"}], moments=moments)
    A = tuple(tuple(Exact(x) for x in row) for row in rows)
    assert stage_order(A, most=5) == moments
    swap = [0] + [k + 1 if k % 2 else k - 1 for k in range(1, len(A))]
    for i in range(len(A)):
        for j in range(len(A)):
            assert A[swap[i]][swap[j]] == -A[i][j]


@pytest.mark.slow
def test_the_inverse_finish_is_recognised_and_a_changed_one_is_not() -> None:
    doc = document("order8-s3-w3-i")
    opening, closing = doc["starting"], copy.deepcopy(doc["finishing"])
    assert is_inverse(opening, closing)
    assert canonical({**inverse_block(opening), "order": 8}) == canonical(closing)
    closing["A"][0][0] += "+1/1000"
    assert not is_inverse(opening, closing)


def with_target(name):
    """Return a document, and what its start aims at."""
    doc = document(name)
    bare = {k: v for k, v in doc.items() if k not in ("starting", "finishing")}
    record = prove(bare)
    return doc, Target.of(bare, record.system, record.series)


@pytest.mark.slow
def test_the_start_of_order_8_is_proved_at_classes_of_trees() -> None:
    doc, target = with_target("order8-s3-w3-i")
    start = prove_starting(doc["starting"], target)
    assert target.stage_order == 3
    assert len(start.box) == 6 + 2 * 22 + 3 * 12  # y_1, two even values, three odd ones
    changed = copy.deepcopy(doc["starting"])
    changed["A"][8][3], changed["A"][7][4] = "1/7", "-1/7"
    with pytest.raises((DataError, ExactnessError)):
        prove_starting(changed, target)


def test_too_few_stages_are_reported() -> None:
    _, target = with_target("order8-s3-w3-i")
    with pytest.raises(ExactnessError, match="add pairs"):
        linear_start([{"c": "1/2"}], target, first=4)


@pytest.mark.parametrize("unknown", ["first", "second"])
def test_only_a_condition_of_the_first_value_is_left_out_where_it_always_holds(
    unknown: str,
) -> None:
    """One unknown, and two conditions, of which one holds whatever it is."""
    digits = "0.125" + "0" * 72
    first, second = (digits, "1/2") if unknown == "first" else ("0", digits)
    block = {"u": ["1", "0"], "A": [["0"] * 3, ["0", "1/2", "0"], ["0", "0", "-1/2"]],
             "B": [["0", first, f"-{first}"], ["0", second, second]]}  # fmt: skip
    eighth, zero, one = Exact(1) / 8, Exact(0), Exact(1)
    zeta = {
        parse_tree("o"): (zero, one if unknown == "first" else eighth * 2),
        parse_tree("[o]"): (eighth if unknown == "first" else zero, zero),
    }
    target = Target(zeta, {"o": ((one, zero), (zero, -one))}, 3)
    if unknown == "second":
        assert prove_starting(block, target).outcome is Outcome.UNIQUE
    else:
        with pytest.raises(DataError, match="2 equations in 1 unknowns"):
            prove_starting(block, target)


@pytest.mark.parametrize("place", [1, 2])
def test_an_involution_that_mixes_the_first_value_with_others_is_refused(place: int) -> None:
    """L_1k = 2 makes e_1 + e_k the functional that L keeps."""
    L = [[Exact((1, -1, -1)[i] * (i == j)) for j in range(3)] for i in range(3)]
    assert functionals(tuple(map(tuple, L)))[0] == ((Exact(1), Exact(0), Exact(0)), 1)
    L[0][place] = Exact(2)
    with pytest.raises(DataError, match="does not keep the first value apart"):
        functionals(tuple(map(tuple, L)))


def test_a_finish_block_has_the_form_it_needs() -> None:
    block = finishing_block(1, ["1/2", "1/3"])
    assert block["A"] == [["0", "0", "0"], ["1/2", "0", "0"], ["-1/2", "0", "0"]]
    assert block["b"] == ["0", "1/3", "-1/3"]
    assert not starting_system({"A": block["A"], "B": [block["b"]]}).unknowns


def test_enclosure_records_name_the_start() -> None:
    record = prove(document(NAME))
    assert {"starting-order", "finishing-order"} <= set(record.started)


def test_the_stages_that_a_row_needs_are_those_it_reads_and_those_they_read():
    A = [["0", "0", "0", "0"], ["1", "0", "0", "0"], ["1", "1", "0", "0"], ["0", "1", "0", "0"]]
    assert needed_stages(A, ["0", "0", "0", "1/2"]) == [0, 1, 3]
    assert needed_stages(A, ["1", "0", "0", "0"]) == [0]
    assert needed_stages(A, ["0"] * 4) == []
