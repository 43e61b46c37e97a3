"""Starts and finishes with parity: their form is checked, their digits are proved."""

import copy
import re
from fractions import Fraction
from typing import Any

import pytest

from glmref.catalogue.canonical import canonical
from glmref.catalogue.lookup import document, load
from glmref.derive.linear_start import linear_start, tableau
from glmref.derive.parity_start import starting_block
from glmref.derive.recipes.solved import rough_starts
from glmref.errors import DataError, ExactnessError
from glmref.exact import Exact
from glmref.exact.judging import Fraction as rational
from glmref.exact.judging import as_numbers, as_scalar, fast_judge
from glmref.judge.refusals import Refused
from glmref.method import as_matrix
from glmref.prove import starting
from glmref.prove.enclosure import prove
from glmref.theory.trees import trees
from tests.bseries import elementary_weights
from tests.build import refused

NAME = "t115-i"


def without_start(name: str) -> dict[str, Any]:
    doc = copy.deepcopy(document(name))
    del doc["starting"], doc["finishing"]
    return doc


def with_target(name: str) -> tuple[dict[str, Any], starting.Target]:
    """Return a document, and what its start aims at."""
    doc = without_start(name)
    return document(name), starting.Target.of(doc, prove(doc).root.record)


@pytest.fixture(scope="module")
def target() -> starting.Target:
    return with_target(NAME)[1]


def proved(target: starting.Target, block: Any, **more: Any) -> starting.Blocks:
    return starting.prove_blocks(target.of_document({"starting": block, **more}))


def test_a_series_with_parity_is_that_of_the_tableau() -> None:
    block = starting_block(
        2, ["1/2", "1", "1/3", "1/4", *("1/5", "1/6"), *("1/7", "1/8", "1/9"), *("1", "2", "3")],
        root="i", free=False, last_even=False,
    )  # fmt: skip
    A, B = as_matrix(block["A"], "A"), as_matrix(block["B"], "B")
    expected = elementary_weights(A, B, 6, u=(0,) * 4)
    stages, dot_of = fast_judge().parity.stage_series(as_numbers(A), 1), fast_judge().linalg.dot
    for n in range(1, 7):
        for t in trees(n):
            found = [dot_of(row, stages.derivative(t.judged)) for row in as_numbers(B)]
            assert [as_scalar(x) for x in found] == list(expected[t])
            # y_2 + y_3 is even and y_2 - y_3 odd for z = i; y_4 is odd
            assert not (found[1] - found[2] if n % 2 == 0 else found[1] + found[2])
            assert n % 2 == 1 or not found[3]


def test_a_shipped_start_and_finish_are_proved(target: starting.Target) -> None:
    doc = document(NAME)
    found = proved(target, doc["starting"], finishing=doc["finishing"])
    assert found.orders == {"starting-order": 6, "finishing-order": 6}
    # 5 + 25 conditions at even trees, 12 + 12 at odd ones
    assert [len(x["centre"]) for x in found.proofs.values()] == [54, 25]


def test_a_start_for_another_method_is_refused(target: starting.Target) -> None:
    with pytest.raises(ExactnessError, match="no root within the digits"):
        proved(target, document("s5i1-i")["starting"])


def test_a_changed_rational_entry_is_refused(target: starting.Target) -> None:
    block = copy.deepcopy(document(NAME)["starting"])
    i, j = next((i, j) for i, row in enumerate(block["A"]) for j, x in enumerate(row) if "/" in x)
    value = Fraction(block["A"][i][j]) + Fraction(1, 1000)
    partner = fast_judge().parity.partner
    block["A"][i][j], block["A"][partner(i)][partner(j)] = str(value), str(-value)
    refused(ExactnessError, "no root within the digits", proved, target, block)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda x: x["A"][1].__setitem__(0, "1/2"), "no parity"),
        (lambda x: x["B"][2].__setitem__(1, "1/2"), "no parity"),
        (lambda x: x.__setitem__("u", ["1", "1", "0", "0"]), "u of the start"),
        (lambda x: x["B"].pop(), "shapes of the start"),
        (lambda x: [x.pop() for x in (x["A"], *x["A"], *x["B"])], "odd number of stages"),
        (lambda x: x["A"][1].__setitem__(0, "0.125"), "few places"),
    ],
)
def test_a_start_of_another_form_is_refused(
    target: starting.Target, change: Any, said: str
) -> None:
    block = copy.deepcopy(document(NAME)["starting"])
    change(block)
    refused(DataError, said, proved, target, block)


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        (lambda x: x["A"][1].__setitem__(0, "1/2"), DataError, "no parity"),
        (lambda x: [x.pop() for x in (x["A"], *x["A"], x["b"])], DataError, "odd number"),
        (lambda x: x["A"][1].pop(), DataError, "other lengths"),
        (lambda x: x.__setitem__("b", [y.replace("1", "2", 1) for y in x["b"]]),
         (DataError, ExactnessError), "finishing"),
    ],
)  # fmt: skip
def test_a_finish_of_another_form_is_refused(target, change, error, said):
    doc = document(NAME)
    closing = copy.deepcopy(doc["finishing"])
    change(closing)
    refused(error, said, proved, target, doc["starting"], finishing=closing)


def test_conditions_are_as_many_as_unknowns(target: starting.Target) -> None:
    block = copy.deepcopy(document(NAME)["starting"])
    long = max((x for row in block["B"] for x in row), key=len)
    text = re.search(r"[0-9.]{30,}", long)
    assert text is not None
    rows = [[x.replace(text[0], "1/3") for x in row] for row in block["B"]]
    refused(DataError, "54 conditions in 53 unknowns", proved, target, {**block, "B": rows})


def test_every_conjugation_method_has_a_start_and_a_finish() -> None:
    for name, record in rough_starts().items():
        if "linear" in record or "finish" not in record:
            continue
        method = load(name)
        assert method.starting is not None and method.finishing is not None
        assert method.starting.stages == 2 * record["start"]["pairs"] + 1 <= 21
        assert method.finishing.stages == 2 * record["finish"]["pairs"] + 1 <= 15


@pytest.mark.parametrize("moments", [2, 3])
def test_rational_tableaux_have_parity_and_their_stage_order(moments: int) -> None:
    rows = tableau([{"c": "3/5", "3": "1/4"}, {"c": "-1/3", "7": "1/2", "4": "2"}], moments=moments)
    A = tuple(tuple(Exact(x) for x in row) for row in rows)
    assert fast_judge().parity.simplifies(as_numbers(A), 5) == moments
    swap = [0] + [k + 1 if k % 2 else k - 1 for k in range(1, len(A))]
    for i in range(len(A)):
        for j in range(len(A)):
            assert A[swap[i]][swap[j]] == -A[i][j]


def test_the_inverse_finish_is_recognised_and_a_changed_one_is_not() -> None:
    doc, target = with_target("order8-s3-w3-i")
    opening, closing = doc["starting"], copy.deepcopy(doc["finishing"])
    undoes, numbers = fast_judge().parity.undoes, target.record.exact
    assert undoes(numbers, opening, closing)
    assert canonical({**starting.inverse_block(opening), "order": 8}) == canonical(closing)
    closing["A"][0][0] += "+1/1000"
    assert not undoes(numbers, opening, closing)


@pytest.mark.slow
def test_the_start_of_order_8_is_proved_at_classes_of_trees() -> None:
    doc, target = with_target("order8-s3-w3-i")
    start = target.of_document({"starting": doc["starting"]}).start
    assert start.q == 3
    # y_1, two even values, three odd ones
    assert (
        len(starting.conditions_of("starting", start)) == len(start.unknowns) == 6 + 2 * 22 + 3 * 12
    )
    changed = copy.deepcopy(doc["starting"])
    changed["A"][8][3], changed["A"][7][4] = "1/7", "-1/7"
    refused((DataError, ExactnessError), "", proved, target, changed)


def test_too_few_stages_are_reported() -> None:
    doc = without_start("order8-s3-w3-i")
    record = prove(doc)
    target = starting.Target.of(doc, record.root.record)
    with pytest.raises(ExactnessError, match="add pairs"):
        linear_start([{"c": "1/2"}], target, record.involution, first=4)


@pytest.mark.parametrize("unknown", ["first", "second"])
def test_only_a_condition_of_the_first_value_is_left_out_where_it_always_holds(unknown):
    """One unknown, and two conditions, of which one holds whatever it is."""
    digits = "0.125" + "0" * 72
    first, second = (digits, "1/2") if unknown == "first" else ("0", digits)
    block = {"u": ["1", "0"], "A": [["0"] * 3, ["0", "1/2", "0"], ["0", "0", "-1/2"]],
             "B": [["0", first, f"-{first}"], ["0", second, second]]}  # fmt: skip
    judge, (zero, one) = fast_judge(), (rational(0), rational(1))
    zeta = {
        "o": [zero, one if unknown == "first" else one / 4],
        "[o]": [one / 8 if unknown == "first" else zero, zero],
    }
    start = judge.parity.OddStart(
        judge.fields.Numbers({"kind": "rational"}), {"starting": block},
        lambda t: zeta[judge.trees.show(t)], [[one, zero], [zero, -one]], 3, 1,
    )  # fmt: skip
    start.wanted = [x for x in start.wanted if judge.trees.size(x[1]) < 3]
    if unknown == "second":
        start.root(starting.proposed("starting", start))
    else:
        refused(DataError, "2 conditions in 1 unknowns", starting.proposed, "starting", start)


@pytest.mark.parametrize("place", [1, 2])
def test_an_involution_that_mixes_the_first_value_with_others_is_refused(place: int) -> None:
    """L_1k = 2 makes e_1 + e_k the functional that L keeps."""
    parts_of = fast_judge().parity.parts_of
    L = [[rational((1, -1, -1)[i] * (i == j)) for j in range(3)] for i in range(3)]
    assert parts_of(L)[0] == ([1, 0, 0], 1)
    L[0][place] = rational(2)
    refused(Refused, "does not keep the first value apart", parts_of, L)
