"""Test the judges: every planted fault is caught, under the right claim, by name, and no other."""

import pytest

from glmref.conformance.adapters.reference import Adapter as Reference
from glmref.conformance.checks import Suite
from glmref.conformance.faults import NOTES
from glmref.conformance.subject import Subject
from glmref.findings import Verdict

from .planted import PLANTED, Foreign


@pytest.mark.slow
@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", sorted(PLANTED))
def test_a_planted_fault_is_caught_under_its_claim_and_named(name: str) -> None:
    fault = PLANTED[name]
    suite = Suite(Subject(fault()))
    failing = [(c.claim, suite.finding(c).witness) for c in suite.checks
               if suite.finding(c).verdict is Verdict.FAILS]  # fmt: skip
    assert {claim for claim, _ in failing} == {fault.claim}, failing
    messages = " | ".join(text for _, text in failing)
    assert all(word in messages for word in fault.words), messages
    assert {flag for flag in NOTES if f"({flag})" in messages} <= set(fault.words), messages
    assert ("single precision" in messages) == name.startswith("SinglePrecision"), messages


def test_there_are_at_least_60_planted_faults_over_every_claim_they_can_break() -> None:
    assert len(PLANTED) >= 60
    claims = {fault.claim for fault in PLANTED.values()}
    assert claims >= {
        "answer", "repeatable", "stages", "step", "abscissae", "backward", "start", "finish",
        "trajectory", "order", "symmetric", "symplectic",
    }  # fmt: skip


@pytest.mark.slow
def test_the_integrators_that_were_spoiled_are_right_unspoiled() -> None:
    methods = {m for fault in PLANTED.values() for m in fault.planted_methods} - {"mine"}
    assert all(
        f.verdict is Verdict.HOLDS for f in Suite(Subject(Reference(sorted(methods)))).findings()
    )

    class Honest(Foreign):
        methods = {"mine": {"order": 4}}  # noqa: RUF012

    assert all(f.verdict is Verdict.HOLDS for f in Suite(Subject(Honest())).findings())
