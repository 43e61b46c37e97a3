"""Files made to deceive, in ``deceivers.json``: what is found of each, word for word.

Each turns on a condition of a rule that no shipped file does, or is a twin of one that does. Where a
verdict of these changes, a rule has changed: mutants of the kernel (``python -m campaigns.mutation
--subpackages kernel``) are noticed here.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.exact import Exact
from glmref.prove.kernel import Kernel, Proposal
from glmref.prove.verifier import _refute, verify

FILES = json.loads(Path(__file__).with_name("deceivers.json").read_text(encoding="utf-8"))["files"]
DECEIVERS: dict[str, dict[str, Any]] = {x["name"]: x for x in FILES}


def plain(value: object) -> object:
    return value if isinstance(value, bool | int) else None


def found(document: dict[str, Any]) -> object:
    try:
        method = load_document(document)
        broken = document.get("broken")
        findings = verify(method) if broken is None else [_refute(method, broken)]
        return {x.claim: [str(x.verdict), str(x.proof), plain(x.value)] for x in findings}
    except GlmrefError as error:
        return type(error).__name__


@pytest.mark.parametrize("name", DECEIVERS)
def test_what_is_found_of_a_deceiver(name: str) -> None:
    assert found(DECEIVERS[name]["document"]) == DECEIVERS[name]["found"]


@pytest.mark.parametrize(
    ("name", "claim", "known"),
    [
        ("idle value", "symmetric-reduced", (None, True)),
        ("leapfrog in balls", "symmetric-reduced", (None, False)),
        ("double one", "parasitism-free", (None, True)),
        ("idle value", "g-symplectic", (True, True)),
    ],
)
def test_without_a_proposal_a_truth_is_found_by_the_rules_or_open(name, claim, known) -> None:
    answer = Kernel(load_document(DECEIVERS[name]["document"])).known(claim, Proposal())
    assert (answer.truth, answer.exact) == known


def test_what_is_proposed_as_an_eigenvector_must_be_one() -> None:
    """(0, 1, 1) for V = diag(1, -1, 0): it is read rightly by W, and V does not keep it."""
    one, zero = Exact(1), Exact(0)
    parts = ((one, ((one, zero, zero),), ((one, zero, zero),)),
             (-one, ((zero, one, zero),), ((zero, one, one),)))  # fmt: skip
    proposal = Proposal(lambda: {"o": (parts, (zero, one))})
    kernel = Kernel(load_document(DECEIVERS["inner zero"]["document"]))
    answer = kernel.known("parasitism-free", proposal)
    assert (answer.truth, answer.exact) == (None, True)
