"""Every hypothesis of every rule has a hostile certificate that violates it and no other."""

from dataclasses import replace
from typing import Any

import pytest

from glmref.judge import statements
from glmref.judge.proof import Proof
from glmref.judge.refusals import Refused
from glmref.judge.rule import HypothesisFails, Rule

from .test_both_ways import ROWS, subject_of

VIOLATES = {name: tuple(row["violates"]) for name, row in ROWS.items() if "violates" in row}


def certificate_of(row: dict[str, Any]) -> dict[str, Any]:
    """Return the certificate of a row."""
    statement, parts = row["statement"], [(x["rule"], x["witness"]) for x in row["parts"]]
    return subject_of(row).certificate(
        statement["claim"], statement["declared"], statement["verdict"], parts
    )


def failing(certificate: dict[str, Any]) -> tuple[str, str]:
    """Return the rule and the hypothesis that refuse a part of a certificate, empty if none does."""
    try:
        proof = Proof(certificate, statements.RULES)
        for part in proof.parts:
            proof.apply(part)
    except HypothesisFails as error:
        rule, hypothesis, _ = error.args
        return rule, hypothesis.__name__
    except (Refused, ArithmeticError, LookupError, TypeError, ValueError):
        pass  # what the hypothesis keeps away from the conclusion
    return "", ""


@pytest.mark.parametrize("name", VIOLATES)
def test_a_row_violates_one_hypothesis(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    certificate, (rule, hypothesis) = certificate_of(ROWS[name]), VIOLATES[name]
    assert failing(certificate) == (rule, hypothesis)
    record = statements.RULES[rule]
    assert isinstance(record, Rule)
    others = tuple(x for x in record.hypotheses if x.__name__ != hypothesis)
    monkeypatch.setitem(statements.RULES, rule, replace(record, hypotheses=others))
    assert failing(certificate)[0] != rule


@pytest.mark.parametrize("rule", statements.RULES.values(), ids=lambda x: x.name)
def test_each_hypothesis_of_a_rule_has_its_row(rule: Rule) -> None:
    own = [x.__name__ for x in rule.hypotheses]
    assert not [x for x in own if (rule.name, x) not in VIOLATES.values()]


@pytest.mark.parametrize("equation", ["stage 3 1", "stage 1 3", "column 3"])
def test_an_equation_about_a_stage_beyond_the_last_is_told(equation: str) -> None:
    certificate = certificate_of(ROWS["order-5-of-gauss-2"])
    certificate["document"]["enclosure"]["equations"][1] = equation
    with pytest.raises(Refused, match="an equation names another stage"):
        Proof(certificate, statements.RULES).root()
