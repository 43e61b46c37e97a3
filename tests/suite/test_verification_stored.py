"""data/measurements/verification.json, which the report shows, says what ``glmref verify`` says.

Here: every claim as it is declared, and some methods of each class word for word;
``test_catalogue``, which recomputes every claim, compares them all.
"""

import pytest

from glmref.catalogue.lookup import document, names
from glmref.prove.verifier import verify_file

from .stored import RENEW, STORED, same, stored

SAMPLE = ("rk4", "gauss-2", "bdf-2", "gsymplectic-n", "stormer-verlet", "pair-4-4", "rk4-a44-one")


@pytest.mark.slow
def test_every_claim_is_stored_as_it_is_declared_and_holds() -> None:
    assert STORED["format"] == "glmref-findings-1"
    held = {"holds": len(STORED["findings"]), "fails": 0, "open": 0}
    assert STORED["summary"] == held, RENEW
    assert {one["method"] for one in STORED["findings"]} == set(names("all")), RENEW
    for name in names("methods"):
        declared = {one["claim"]: one["declared"] for one in stored(name)}
        claims = document(name)["claims"]
        # a starting and a finishing method declare their orders in their own blocks
        orders = {f"{x}-order" for x in ("starting", "finishing") if x in document(name)}
        assert {k: x for k, x in declared.items() if k in claims} == claims, RENEW
        assert set(declared) - set(claims) <= orders, RENEW


def test_what_holds_was_found_as_it_is_declared() -> None:
    for one in STORED["findings"]:
        if isinstance(one["declared"], int) and not one["claim"].startswith("refutes "):
            assert one["value"] == one["declared"], one


@pytest.mark.parametrize("name", SAMPLE)
def test_what_is_stored_is_what_is_found(name: str) -> None:
    found = [one.as_json() for one in verify_file(name)]
    assert same(stored(name), found), RENEW
    residual = 0.5 if found[0]["residual"] == 0 else 0.0
    for wrong in ({"witness": "another tree"}, {"proof": "measured"}, {"residual": residual}):
        assert not same(stored(name), [{**found[0], **wrong}, *found[1:]]), wrong
