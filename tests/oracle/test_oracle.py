"""The oracle agrees with the catalogue, and contradicts neither the kernel nor the judge."""

from typing import Any

import pytest

from glmref.catalogue.lookup import document, names
from tests.adversary.both_ways import written
from tests.attack.oracle import attack
from tests.shipped import HOSTILE

from .claims import Oracle, opinion

FALSE = [row for row in HOSTILE if "truth" not in row]
TRUE = [row for row in HOSTILE if row.get("truth") is True]


def oracle_of(name: str) -> Oracle:
    d = document(name)
    return Oracle(d, document(d["base"]) if "base" in d else None)


@pytest.mark.sampled(1, whole=30)
@pytest.mark.parametrize("name", names())
def test_every_claim_of_the_catalogue_is_true_or_open(name: str) -> None:
    oracle = oracle_of(name)
    wrong = [
        claim for claim, x in oracle.document["claims"].items() if oracle.judge(claim, x) is False
    ]
    assert not wrong


@pytest.mark.sampled(8, whole=40)
@pytest.mark.parametrize("name", names("broken"))
def test_the_claim_of_a_broken_file_is_false_or_open(name: str) -> None:
    oracle = oracle_of(name)
    claim = oracle.document["broken"]["claim"]
    assert oracle.judge(claim, oracle.document["claims"][claim]) is not True


@pytest.mark.slow
def test_the_oracle_has_an_opinion() -> None:
    """Of the quick methods it leaves less than one claim in ten open."""
    answers = []
    for name in (
        "rk4",
        "gauss-2",
        "gsymplectic-n",
        "bdf-3",
        "stormer-verlet",
        "ars-4-4-3",
        "rodas3",
        "pair-4-5",
    ):
        oracle = oracle_of(name)
        answers += [oracle.judge(claim, x) for claim, x in oracle.document["claims"].items()]
    assert answers.count(True) > 0.9 * len(answers)
    assert False not in answers


def believed(row: dict[str, Any]) -> bool | None:
    """Return whether the oracle takes the statement of a row for true, ``None`` if it cannot say."""
    statement = row["statement"]
    says = opinion(row["document"], statement["claim"], statement["declared"], row.get("base"))
    return None if says is None else says is (statement["verdict"] == "holds")


@pytest.mark.sampled(40, whole=40)
@pytest.mark.parametrize("row", FALSE, ids=lambda row: row["name"])
def test_the_oracle_does_not_believe_a_hostile_statement(row: dict[str, Any]) -> None:
    assert believed(row) is not True


@pytest.mark.parametrize("row", TRUE, ids=lambda row: row["name"])
def test_the_oracle_does_not_deny_a_true_statement_with_a_wrong_proof(row: dict[str, Any]) -> None:
    assert believed(row) is not False


@pytest.mark.slow
def test_the_oracle_has_an_opinion_of_hostile_statements() -> None:
    """It believes none, denies more than four in five of the false ones, more than ninety in all."""
    says = [believed(row) for row in FALSE]
    assert not [row["name"] for row, said in zip(FALSE, says, strict=True) if said]
    assert says.count(False) > max(90, 0.8 * len(FALSE))


NEARLY = {
    "zero-stable": ([["0"]], [["1", "0"]], [["1"], ["0"]], [["1", "1/1" + "0" * 55], ["0", "1"]]),
    "l-stable": (
        [["1/2", "0"], ["1/2", "1"]],
        [["1"]] * 2,
        [["1/2-1/1" + "0" * 55, "1/2"]],
        [["1"]],
    ),
}


@pytest.mark.parametrize("claim", NEARLY)
def test_what_is_nearly_true_is_not_believed(claim: str) -> None:
    glm = {"class": "glm", **dict(zip("AUBV", NEARLY[claim], strict=True))}
    assert opinion(glm, claim, True) is not True


def test_a_pair_whose_values_do_not_begin_with_y_and_0_has_no_start() -> None:
    half = {"A": [["1/2"]], "U": [["2/3", "1/3"]], "B": [["1"], ["1"]], "V": [["1/2", "1/2"]] * 2}
    pair = {"class": "partitioned", "q": half, "p": half, "separable": False}
    for order, verdict in ((0, "holds"), (2, "fails")):
        (certificate,) = written(pair, {"starting-order": order})
        assert certificate["statement"]["verdict"] == verdict
        assert opinion(pair, "starting-order", order) is (verdict == "holds")


@pytest.mark.slow
def test_drawn_statements_are_never_contradicted() -> None:
    tally = attack(60, 5)
    assert not tally.violations and tally.outcomes["both decide"] > 30
