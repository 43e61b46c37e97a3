"""Files that are checked by name: of a wrong one the claim that fails, for the reason it says."""

import json
from pathlib import Path
from typing import Any

import pytest

import glmref
from glmref.cli import main
from glmref.errors import DataError
from glmref.findings import Verdict
from glmref.prove import verdicts
from glmref.prove.verifier import verify_file
from tests.adversary.deceive import doc, findings, shipped

WHY = {"flag": "OrderOverclaimed", "why": "It is the classical method."}


def written(folder: Path, **changes: Any) -> Path:
    path = folder / "own.json"
    path.write_text(json.dumps({**shipped("rk4"), "name": "own", **changes}), encoding="utf-8")
    return path


def test_a_shipped_name_is_checked_claim_by_claim() -> None:
    found = verify_file("rk4")
    assert {x.claim for x in found} == set(shipped("rk4")["claims"])
    assert {x.verdict for x in found} == {Verdict.HOLDS}
    assert [x.claim for x in verify_file("rk4", only=("order",))] == ["order"]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("found", "verdict", "reason"),
    [
        ("right", Verdict.HOLDS, ""),
        ("another", Verdict.FAILS, "it fails for another reason than `broken.found`: "),
    ],
)
def test_the_claim_of_a_wrong_file_is_refuted_for_the_reason_it_gives(
    found: str, verdict: Verdict, reason: str, tmp_path: Path
) -> None:
    claims = {"order": 5, "explicit": True}
    (plain,) = verify_file(written(tmp_path, claims={"order": 5}))
    assert plain.verdict is Verdict.FAILS
    found = plain.witness if found == "right" else found
    broken = {"claim": "order", **WHY, "found": found}
    path = written(tmp_path, claims=claims, broken=broken)
    (refuted,) = verify_file(path)
    assert (refuted.claim, refuted.verdict) == ("refutes order", verdict)
    assert refuted.witness == reason + plain.witness
    assert verify_file(path, only=("explicit",)) == []
    assert verify_file(path, only=("order",)) == [refuted]


def test_a_claim_that_holds_is_not_refuted(tmp_path: Path) -> None:
    broken = {"claim": "order", **WHY, "found": ""}
    (found,) = verify_file(written(tmp_path, claims={"order": 4}, broken=broken))
    assert found.verdict is Verdict.FAILS


def test_what_cannot_be_checked_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"own\.json: there is nothing to verify"):
        verify_file(written(tmp_path, claims={}))
    broken = {"claim": "symmetric", **WHY, "found": ""}
    with pytest.raises(DataError, match=r"own\.json.*symmetric"):
        verify_file(written(tmp_path, claims={"order": 4}, broken=broken))


def test_what_has_no_residual_says_none() -> None:
    """The eigenvalue 2 of V refutes stability and measures nothing; B 1 is 2 instead of 1."""
    d = doc("glm", {"zero-stable": True, "consistent": True}, A=[["0"]], U=[["1", "0"]],
            B=[["2"], ["0"]], V=[["1", "0"], ["0", "2"]])  # fmt: skip
    found = findings(d)
    assert {c: (x.verdict, x.residual) for c, x in found.items()} == {
        "zero-stable": (Verdict.FAILS, 0.0),
        "consistent": (Verdict.FAILS, 1.0),
    }


EULER_AND_A_DOUBLE_ROOT: dict[str, Any] = {
    "A": [["0"]], "U": [["1", "0", "0"]], "B": [["1"], ["0"], ["0"]],
    "V": [["1", "0", "0"], ["0", "-1", "1"], ["0", "0", "-1"]],
}  # fmt: skip
INCONSISTENT: dict[str, Any] = {
    "A": [["0"]], "U": [["0", "1"]], "B": [["1"], ["1/2"]], "V": [["1", "0"], ["0", "1"]],
}  # fmt: skip


@pytest.mark.parametrize(
    ("keys", "claim", "declared", "said"),
    [
        (EULER_AND_A_DOUBLE_ROOT, "parasitism-free", False,
         "V is not power-bounded: parasitic components grow anyway"),
        (EULER_AND_A_DOUBLE_ROOT, "a-stable", False, "V = M(0) is not power-bounded"),
        (EULER_AND_A_DOUBLE_ROOT, "symmetric-reduced", False,
         ("no exchange of stages P works; for the reversal "
         "entry (1, 1) of A + P A P - U V^-1 B is 1 in size")),
        (INCONSISTENT, "growth", ["1"], "the growth matrix has the eigenvalues 0.5, 0"),
        (INCONSISTENT, "growth", ["1", "2"], "the growth matrix has the eigenvalues 0.5, 0"),
    ],
)  # fmt: skip
def test_what_is_decided_says_why(keys, claim, declared, said):
    found = findings(doc("glm", {claim: declared}, **keys))[claim]
    assert found.verdict is (Verdict.FAILS if declared else Verdict.HOLDS)
    assert found.witness == said


def test_what_is_open_says_why_it_is_neither_proved_nor_refuted() -> None:
    inconsistent = doc("rk", {"conjugate-symplectic": True}, A=[["0"]], b=["1/2"])
    found = findings(inconsistent)["conjugate-symplectic"]
    assert found.verdict is Verdict.OPEN
    assert "b_i a_ij + b_j a_ji = b_i b_j" in found.witness
    assert "the method is not consistent" in found.witness


def test_a_pair_of_many_stages_is_seen_not_to_be_symmetric() -> None:
    document = shipped("dormand-prince-rkn-12-10-printed")
    del document["broken"]
    refuted = findings({**document, "claims": {"symmetric": True}})["symmetric"]
    assert refuted.verdict is Verdict.FAILS


def test_findings_of_a_method_in_memory_are_a_table_in_a_notebook() -> None:
    """Of a file, of a method and of a plain one."""
    plain = glmref.load("rk4")
    for method in ("rk4", plain):
        assert "<table" in glmref.verify(method)._repr_html_()  # type: ignore[attr-defined]
    unnamed = glmref.check([["1/2"]], [1], order=2)._repr_html_()  # type: ignore[attr-defined]
    assert "tableau</strong>" in unnamed and "no claims" not in unnamed


def test_the_certificates_written_are_those_by_which_the_claims_were_decided(tmp_path, monkeypatch):
    """Each claim is decided once: nothing is found or judged again for the files."""
    judged: list[Any] = []

    def verdict(certificate: Any, judge: Any = verdicts.judges_verdict) -> tuple[bool, str]:
        accepted, sentence = judge(certificate)
        if accepted:
            judged.append(certificate)
        return accepted, sentence

    monkeypatch.setattr(verdicts, "judges_verdict", verdict)
    assert main(["verify", "rk4", "ab-2-sign", "--certificates", str(tmp_path)]) == 0
    written = [json.loads(x.read_text(encoding="utf-8")) for x in tmp_path.iterdir()]

    def key(certificate: dict[str, Any]) -> tuple[str, str]:
        return certificate["statement"]["method"], certificate["statement"]["claim"]

    assert len(written) > 6 and sorted(written, key=key) == sorted(judged, key=key)
