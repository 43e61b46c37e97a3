"""Files made to deceive, in ``deceivers.json``: ``verify``, ``analyze`` and certificates agree on each.

Each turns on a condition of a rule that no shipped file does, or is a twin of one that does: idle
values, several u, poles on the axis and in stages that nothing uses, halves alike, starts that are
right but for 1e-50. Where a verdict of these changes, a rule has changed: mutants of the kernel
(``python -m campaigns.mutation --subpackages kernel``) are noticed here.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.prove.analysis import analyze
from glmref.prove.verifier import _refute, verify

from .test_verdicts_have_certificates import without_a_certificate

FILES = json.loads(Path(__file__).with_name("deceivers.json").read_text(encoding="utf-8"))["files"]
DECEIVERS: dict[str, dict[str, Any]] = {x["name"]: x for x in FILES}
#: Those whose claims are all decided; of a broken file one is.
DECIDED = [
    x["name"] for x in FILES if isinstance(x["found"], dict) and "broken" not in x["document"]
]
#: Claim -> what an analysis calls it.
SHOWN = {"explicit": "explicit", "preconsistent": "preconsistent", "consistent": "consistent",
         "zero-stable": "zero_stable", "order": "order", "w-order": "order_w"}  # fmt: skip


def plain(value: object) -> object:
    """A truth, an order, or the orders of rows; what else there is has more than one text."""
    orders = isinstance(value, dict) and all(isinstance(x, int) for x in value.values())
    return value if orders or isinstance(value, bool | int) else None


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


@pytest.mark.sampled(4, whole=60)
@pytest.mark.parametrize("name", DECIDED)
def test_analysis_and_certificates_say_the_same(name: str, tmp_path: Path) -> None:
    document = DECEIVERS[name]["document"]
    shown = analyze(load_document(document))
    for claim, (verdict, _, value) in DECEIVERS[name]["found"].items():
        if claim in SHOWN and verdict != "open":
            # decimals of 50 places count as rounded: what holds of the numbers themselves is said, too
            within = claim == "order" and f"order {value} exactly" in str(shown.order_witness)
            assert getattr(shown, SHOWN[claim]) == value or within, claim
    assert without_a_certificate(document, tmp_path) == []
