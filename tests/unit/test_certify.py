"""Certificates: what they hold, and how the command line writes them."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest
from click.testing import CliRunner

from glmref.catalogue.lookup import data_root
from glmref.cli.certifying import certify
from glmref.prove.field import Tower, radicals_of

SCHEMA = data_root() / "schema" / "glmref-certificate-1.schema.json"


def certificates(name: str, folder: Path) -> dict[str, dict]:
    result = CliRunner().invoke(certify, [name, "--output", str(folder)], standalone_mode=False)
    assert result.exception is None, result.output
    found = [json.loads(p.read_text()) for p in folder.glob("*.json")]
    return {x["statement"]["claim"]: x for x in found}


@pytest.mark.sampled(3, besides=("gsymplectic-n", "leapfrog"))
@pytest.mark.parametrize(
    "name", ["rk4", "gauss-2", "gsymplectic-n", "bdf-7", "leapfrog", "ars-2-2-2"]
)
def test_certificates_follow_their_schema(name: str, tmp_path: Path) -> None:
    schema = json.loads(SCHEMA.read_text())
    found = certificates(name, tmp_path)
    assert found
    for certificate in found.values():
        jsonschema.validate(certificate, schema)


def test_the_order_of_rk4_lists_every_tree_or_says_zero(tmp_path: Path) -> None:
    found = certificates("rk4", tmp_path)["order"]
    below, above = (part["witness"] for part in found["parts"])
    assert (below["order"], below["eta"], above["n"]) == (4, "zero", {"[oooo]": ["1"]})
    assert found["statement"]["verdict"] == "holds"
    series = certificates("gsymplectic-n", tmp_path / "n")["order"]["parts"][0]["witness"]
    assert len(series["eta"]) == 1 + 1 + 2 + 4
    assert certificates("gsymplectic-n", tmp_path / "n")["order"]["field"]["kind"] == "tower"


def test_order_10_is_refuted_above_by_one_tree(tmp_path: Path) -> None:
    """Beyond order 10 the trees of the next order are not listed."""
    at_most = certificates("gauss-5", tmp_path)["order"]["parts"][1]["witness"]
    assert (at_most["order"], at_most["n"]) == (10, {f"[{'o' * 10}]": ["1"]})


def test_dependent_radicals_share_generators() -> None:
    tower = Tower(radicals_of("sqrt(12)+sqrt(27)*sqrt(1/3)+i*sqrt(3)"))
    assert len(tower.generators) == 2
    assert tower.radicals["sqrt(12)"] == "2*g1"
    assert tower.radicals["sqrt(27)"] == "3*g1"


def test_nested_radicals_and_roots_of_unity() -> None:
    tower = Tower(radicals_of("sqrt(3/7+2/7*sqrt(6/5))+exp(2*pi*i/5)"))
    assert [len(x["polynomial"]) for x in tower.generators] == [2, 2, 4]
    assert "conjugate" in tower.generators[-1]
