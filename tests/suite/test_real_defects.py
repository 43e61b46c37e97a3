"""Tables that are wrong in published code: each is caught under its claim, and said where."""

import json
from pathlib import Path

import numpy as np
import pytest

from glmref.catalogue.lookup import path_of
from glmref.catalogue.reader import load_document
from glmref.conformance.checks import Suite
from glmref.conformance.probe import read
from glmref.conformance.read_orders import first_defect
from glmref.conformance.subject import Subject
from glmref.errors import UsageError
from glmref.findings import Finding, Verdict
from glmref.prove.verifier import verify

from .real_defects import DEFECTS, mended, number, published

#: Name -> the claim that fails, and what the messages say: the order seen or the condition missed.
CAUGHT = {name: entry["caught"] for name, entry in DEFECTS.items()}
#: Those that take less than a second stay in the quick tests; the runs of the others are long.
QUICK = {"diffrax-kencarp5", "sciml-mcate42", "petsc-glee25i", "nodepy-ssp53",
         "rklib-rks5", "tudat-rkf89", "desolver-babs9o7h"}  # fmt: skip
MARKED = [x if x in QUICK else pytest.param(x, marks=pytest.mark.slow) for x in CAUGHT]


def findings(adapter: object) -> list[Finding]:
    return Suite(Subject(adapter)).findings()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", MARKED)
def test_a_table_that_was_published_wrong_is_caught_under_its_claim(name: str) -> None:
    claim, *words = CAUGHT[name]
    failing = [x for x in findings(published(name)) if x.verdict is Verdict.FAILS]
    assert {x.claim.partition("/")[0].rstrip("0123456789") for x in failing} == {claim}, failing
    messages = " | ".join(x.witness for x in failing)
    assert all(word in messages for word in words), messages


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", [
    x if x in QUICK else pytest.param(x, marks=pytest.mark.slow)
    for x in CAUGHT if DEFECTS[x]["right"]
])  # fmt: skip
def test_the_right_table_passes(name: str) -> None:
    found = findings(mended(name))
    assert not [x for x in found if x.verdict is Verdict.FAILS], found
    assert any(x.claim.startswith("order") and x.verdict is Verdict.HOLDS for x in found)


def test_every_defect_has_a_test_and_a_source() -> None:
    assert {x["id"] for x in DEFECTS.values()} == {None, *range(1, 19)}
    for entry in DEFECTS.values():
        assert Path(entry["where"].split(", ")[1]).suffix and len(entry["commit"]) >= 7


def test_a_label_that_denies_stability_is_refuted() -> None:
    """SUNDIALS labels TRBDF2_3_3_2 as neither A- nor L-stable; the propagated row is both."""
    document = json.loads(path_of("tr-bdf2").read_text())
    document["claims"] = {"a-stable": False, "l-stable": False}
    found = verify(load_document(document))
    assert {x.claim: x.verdict for x in found} == dict.fromkeys(document["claims"], Verdict.FAILS)


def test_a_claim_of_abscissae_must_be_a_list_of_numbers() -> None:
    adapter = published("petsc-grk4t")
    for wrong in ([], "0, 1", [float("nan")], [True], 1):
        adapter.methods = {"mine": {"abscissae": wrong}}
        with pytest.raises(UsageError, match="must be a list of numbers"):
            Subject(adapter)


@pytest.mark.slow
def test_an_abscissa_at_which_f_is_not_called_is_said() -> None:
    adapter = mended("petsc-grk4t")
    adapter.methods["petsc-grk4t"]["abscissae"].append(0.75)
    (found,) = (x for x in findings(adapter) if x.claim.startswith("abscissae"))
    assert found.verdict is Verdict.FAILS and "f is not called at t +0.75 h" in found.witness


def test_stages_of_a_high_stage_order_are_told_apart() -> None:
    name = "sciml-feagin12"  # eight markers of 1/k! took two pairs of its stages for one
    reading = read(Subject(published(name)), name, 1)
    assert reading.blocks["A"].shape == (25, 25) and reading.unexplained < 1e-10
    entries = {(i - 1, j - 1): number(x) for i, j, x in DEFECTS[name]["table"]["A"]}
    right = np.array([[entries.get((i, j), 0.0) for j in range(25)] for i in range(25)])
    assert np.abs(reading.blocks["A"] - right).max() < 1e-13
    defect = first_defect(reading, 12, 2.0**-53)
    assert defect is not None and defect.times and defect.order == 1
