"""Starts of pairs: their form, their conditions, the interval test, and what is refused."""

import copy

import pytest

from glmref.catalogue.lookup import document, load, names
from glmref.catalogue.reader import load_document
from glmref.derive.parity_start import expanded
from glmref.errors import DataError, ExactnessError
from glmref.exact import Exact
from glmref.exact.judging import fast_judge
from glmref.findings import Proof, Verdict
from glmref.judge.refusals import Refused
from glmref.method.component import SEPARABLE
from glmref.prove.enclosure import prove
from glmref.prove.kernel import Kernel
from glmref.prove.starting import Target, prove_blocks
from glmref.prove.verifier import verify
from glmref.theory.trees import trees
from tests.bseries import values_series
from tests.build import refused
from tests.shipped import shipped

STARTED = [
    x for x in names("methods") if shipped(x)["class"] == "pair-sweep" and "starting" in shipped(x)
]
QUICK = ["pair-4-4", "pair-6-8", "pair-rkn-6-7b"]
RATIONAL = {
    "A": [["1/2", "0", "0"]],
    "A_hat": [["-1/3", "1/5", "2/7"]],
    "B": [["3/4"]],
    "B_hat": [["-5/6"]],
}


def target_of(name):
    doc = document(name)
    record = prove({k: v for k, v in doc.items() if k != "starting"})
    return Target.of(doc, record.root.record)


def proved(target, block):
    return prove_blocks(target.of_document({"starting": block}))


def blocks(name, **changes):
    block = copy.deepcopy(document(name)["starting"])
    for key, change in changes.items():
        change(block[key])
    return block


def test_every_pair_of_the_sweep_form_but_one_has_a_start():
    pairs = {x for x in names("methods") if shipped(x)["class"] == "pair-sweep"}
    assert set(QUICK) < set(STARTED)
    # order 8 on all separable systems asks for more than its starts are worth: docs/pairs-order.md
    assert pairs - set(STARTED) == {"pair-8-24"}


@pytest.mark.parametrize("name", STARTED)
def test_a_start_has_the_order_of_its_pair_few_stages_and_small_coefficients(name):
    claims, start = document(name)["claims"], load(name).starting
    assert claims["starting-order"] == claims["order"]
    assert claims.get("nystrom-starting-order") == claims.get("nystrom-order")
    assert sum(start.stages) <= 42
    assert (
        max(
            abs(float(x))
            for c in start.components
            for rows in (c.A, c.B)
            for row in rows
            for x in row
        )
        <= 1.0
    )


@pytest.mark.sampled(2, besides=("pair-6",))
@pytest.mark.parametrize(
    ("name", "count"), [("pair-4-4", 5 + 5), ("pair-6-8", 25 + 25), ("pair-rkn-6-7b", 9 + 14 + 3)]
)
def test_there_are_as_many_conditions_as_unknowns(name, count):
    # even trees by root: one f[k] and four of order 4, twenty of order 6; on second-order systems
    # 1 + 2 + 6 and 1 + 3 + 10, and of order 4 the other 2 + 1 besides
    target = target_of(name)
    target = target.of_document({"starting": document(name)["starting"]})
    assert len(target.start.wanted) == len(target.start.unknowns) == count
    assert prove_blocks(target).proofs["starting"]["orders"] == [target.order, target.nystrom]
    (box,) = target.start.roots.values()
    assert all(x.as_ball().radius() < 1e-90 for x in box)


@pytest.mark.parametrize("unit", [1, -1])
def test_one_unit_of_the_last_digit_beside_the_start_is_refused(unit):
    block, target = blocks("pair-4-4"), target_of("pair-4-4")
    proved(target, block)
    (old, *_) = target.of_document({"starting": block}).start.unknowns
    digits = str(int(old.replace("0.", "")) + unit).zfill(len(old) - 2)
    for name in ("A", "B", "A_hat", "B_hat"):
        block[name] = [[x.replace(old, f"0.{digits}") for x in row] for row in block[name]]
    refused(ExactnessError, "not those of the root", proved, target, block)


def test_an_order_that_the_block_alone_names_is_proved_too():
    doc = copy.deepcopy(dict(document("pair-4-4")))
    del doc["claims"]["starting-order"]
    found = {x.claim: x for x in verify(load_document(doc), only=["starting-order"])}
    assert found["starting-order"].verdict is Verdict.HOLDS
    assert found["starting-order"].proof is Proof.ENCLOSED


def test_the_series_of_a_start_with_parity_is_even():
    doc = {**document("pair-4-4"), "starting": {**expanded(RATIONAL), "order": 4}}
    series = values_series(load_document(doc).starting, 6)
    odd = [x for n in (1, 3, 5) for t in trees(n, SEPARABLE) for x in series[t]]
    assert all((Exact(0) + x).is_zero() for x in odd)
    assert any(not (Exact(0) + series[t][1]).is_zero() for t in trees(4, SEPARABLE))


def digit(rows):
    """The last digit but five of one entry, everywhere it stands: parity is kept."""
    old = next(x for row in rows for x in row if len(x) > 30).removeprefix("-")
    new = old[:-6] + str((int(old[-6]) + 1) % 10) + old[-5:]
    for row in rows:
        row[:] = [x.replace(old, new) for x in row]


@pytest.mark.parametrize("key", ["A", "B", "A_hat", "B_hat"])
def test_one_digit_more_or_less_is_refused(key):
    with pytest.raises(ExactnessError, match="`starting`: "):
        proved(target_of("pair-4-4"), blocks("pair-4-4", **{key: digit}))


def test_the_start_of_another_pair_is_refused():
    with pytest.raises(ExactnessError, match="no root within the digits"):
        proved(target_of("pair-6-8"), document("pair-6-9")["starting"])


def one_entry(rows):
    row = next(row for row in rows[1:] if any(len(x) > 30 for x in row))
    at = next(j for j, x in enumerate(row) if len(x) > 30)
    row[at] = row[at].removeprefix("-") if row[at].startswith("-") else f"-{row[at]}"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"A": one_entry}, "the stages have no parity"),
        ({"B_hat": one_entry}, "the stages have no parity"),
        ({"B": lambda x: x[0].__setitem__(1, "1/2")}, "the first stage and value"),
        ({"A_hat": lambda x: x[0].__setitem__(1, "1/2")}, "the first stage and value"),
        ({"u_hat": lambda x: x.__setitem__(1, "1")}, "u of the start"),
        ({"A": lambda x: [row.pop() for row in x]}, "shapes"),
    ],
)
def test_a_start_of_another_form_is_refused(changes, message):
    refused(DataError, message, proved, target_of("pair-4-4"), blocks("pair-4-4", **changes))


def test_a_start_needs_an_even_series_and_the_solution_in_front():
    record, judge = target_of("pair-6-8").record, fast_judge()
    for change, said in (
        ({"signs": None}, "not symmetric"),
        ({"identity_through": lambda n, kind: n < 5 + 2 * kind}, "principal part"),
    ):
        pair = copy.copy(record.root)
        vars(pair).update(change)
        with pytest.raises(Refused, match=said):
            judge.parity.EvenStart(record.exact, document("pair-6-8"), pair, (6, 8))


def test_a_wrong_start_of_p_alone_is_seen():
    doc = copy.deepcopy(document("pair-4-4"))
    row = doc["starting"]["B_hat"][1]
    row[1], row[2] = row[2], row[1]
    method = load_document(doc)
    found = Kernel(method).range("starting-order")
    assert found.upper == 1 and found.reason.startswith("tree k[")
    assert found.reason.endswith("in value 2")
    refused(ExactnessError, "`starting`", verify, method)


def test_a_start_that_misses_the_solution_has_no_order():
    doc = copy.deepcopy(document("gsymplectic-n-pair"))
    doc["starting"]["u_hat"] = ["1", "1/2"]
    found = Kernel(load_document(doc)).range("starting-order")
    assert (found.lower, found.upper, found.exact) == (0, 0, True)
    assert found.reason == "the multiple of y differs by 0.5 in value 2"


def test_shared_stages_are_compared_on_all_two_coloured_trees():
    # one weight of q alone: on separable systems it would meet trees f[k..] only
    doc = copy.deepcopy(document("gsymplectic-n-pair"))
    right = Kernel(load_document(doc)).range("starting-order")
    assert (right.lower, right.upper) == (3, 3)
    doc["starting"]["A"][1][0] = "1/4"
    wrong = Kernel(load_document(doc)).range("starting-order")
    assert (wrong.lower, wrong.upper) == (1, 1) and wrong.reason.startswith("tree f[f] ")
