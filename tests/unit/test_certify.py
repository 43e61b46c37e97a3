"""Certificates: what they hold, and how the command line writes them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from click.testing import CliRunner

from checker import glmref_check
from glmref.catalogue.lookup import data_root
from glmref.cli.certifying import certify, write_certificates
from glmref.prove.field import Tower, radicals_of
from tests.adversary.deceive import shipped

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


def contrary(value: Any) -> Any:
    """A value of a claim that is another one."""
    match value:
        case bool():
            return not value
        case int():
            return value + 1
        case dict():
            return {k: contrary(x) for k, x in value.items()}
        case [str() as first, *others]:
            return [f"({first})+1", *others]
    return value


@pytest.mark.parametrize(
    "name",
    [
        *("leapfrog", "gsymplectic-n", "g4123", "milne-simpson", "radau-iia-2", "bdf-2", "euler"),
        *("stormer-verlet", "forest-ruth-4", "bogacki-shampine-3-2", "ars-2-2-2", "nystrom-rkn-4"),
        *("qin-zhang-2", "am-1", "ark-4-v-preconsistent", "explicit-2-step-order-3"),
        *("ros2", "symplectic-euler-b", "butcher-effective-5", "lobatto-iiic-2", "ab-2-one-leg"),
    ],
)
def test_claims_and_their_contraries_have_certificates_that_pass(name: str, tmp_path: Path) -> None:
    d = shipped(name)
    d.pop("broken", None)
    said: dict[str, Any] = {}
    for kind in ("as-it-is", "contrary"):
        (tmp_path / "x.json").write_text(json.dumps({**d, "name": kind}), encoding="utf-8")
        _, missing = write_certificates([str(tmp_path / "x.json")], tmp_path / kind)
        assert not missing
        d["claims"] = {k: contrary(x) for k, x in d["claims"].items()}
        for part in ("starting", "finishing"):  # the same number in two places
            if "order" in d.get(part, {}):
                d[part]["order"] = d["claims"][f"{part}-order"]
        for path in (tmp_path / kind).iterdir():
            certificate = json.loads(path.read_text(encoding="utf-8"))
            accepted, why = glmref_check.verdict(certificate)
            assert accepted, (kind, path.name, why)
            statement = certificate["statement"]
            said.setdefault(statement["claim"], []).append(statement["verdict"])
    assert set(said) == set(d["claims"])
    changed = {k for k, x in d["claims"].items() if contrary(x) != x}
    assert all(set(said[x]) == {"holds", "fails"} for x in changed if "embedded" not in x), said


@pytest.mark.parametrize(
    ("name", "otherwise"),
    [
        ("mclachlan-ss5-4", {"explicit", "consistent", "symplectic", "symmetric"}),
        ("yoshida-6-midpoint", {"explicit", "stage-order", "symplectic", "symmetric"}),
        (
            "tsitouras-5-4",
            {"explicit", "symplectic", "symmetric", "order", "stage-order", "embedded-order",
             "embedded-difference"},
        ),
        ("ros34pw2", {"order", "w-order", "embedded-difference"}),
        (
            "pair-4-4",
            {"order-identity", "preconsistent", "consistent", "zero-stable", "explicit",
             "g-symplectic", "symmetric", "parasitism-free", "reducible", "growth"},
        ),
    ],
)  # fmt: skip
def test_enclosed_methods_have_certificates_that_pass(
    name: str, otherwise: set[str], tmp_path: Path
) -> None:
    """Of what the files claim, and of less: an order below the one that the equations give."""

    def less(x: Any) -> Any:
        if isinstance(x, dict):
            return {k: less(v) for k, v in x.items()}
        return x - 1 if type(x) is int else contrary(x)

    d = shipped(name)
    claims = {k: less(x) if k in otherwise else x for k, x in d["claims"].items()}
    document = {**d, "name": "x", "claims": claims}
    (tmp_path / "x.json").write_text(json.dumps(document), encoding="utf-8")
    _, missing = write_certificates([str(tmp_path / "x.json")], tmp_path / "c")
    found = [json.loads(x.read_text(encoding="utf-8")) for x in (tmp_path / "c").iterdir()]
    assert not missing and {x["statement"]["claim"] for x in found} == set(d["claims"])
    for x in found:
        accepted, why = glmref_check.verdict(x)
        assert accepted, (x["statement"], why)
        fails = x["statement"]["claim"] in otherwise
        assert x["statement"]["verdict"] == ("fails" if fails else "holds")


ONE = {"U": [["1"]], "V": [["1"]]}
TWO = {"A": [["1"]], "U": [["1", "0"]], "B": [["1"], ["0"]]}
STABILITY: dict[str, tuple[dict[str, Any], list[Any], list[Any]]] = {
    "backward Euler": ({**ONE, "A": [["1"]], "B": [["1"]]},
                       ["bounded", "a-stable"], ["bounded", "a-stable", "l-limit"]),
    "midpoint rule": ({**ONE, "A": [["1/2"]], "B": [["1"]]},
                      ["bounded", "a-stable"], ["not-l-limit"]),
    "grows at infinity": ({**ONE, "A": [["-1/2"]], "B": [["1"]]},
                          [{"infinity": True}], ["not-l-limit"]),
    "1/(1 + z)": ({**ONE, "A": [["-1"]], "B": [["-1"]]}, [{"pole": True}], [{"pole": True}]),
    "grows by itself": ({**TWO, "V": [["1", "0"], ["0", "2"]]},
                        ["unbounded", {"start": True}], ["not-l-limit"]),
    "a Jordan block at 0": ({**TWO, "V": [["1", "1"], ["0", "1"]]},
                            ["unbounded", {"start": True}], ["not-l-limit"]),
    "a Jordan block at i": (
        {"A": [["1/2", "0"], ["0", "1/2"]], "U": [["1", "0"], ["0", "1"]],
         "B": [["1", "0"], ["1", "1"]], "V": [["1", "0"], ["0", "1"]]},
        [{"defect": "1"}], ["not-l-limit"],
    ),
    "three steps": (
        {**shipped("bdf-3")}, [{"y": "1"}], [{"y": "1"}],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", STABILITY)
def test_each_way_of_losing_stability_has_its_certificate(name: str, tmp_path: Path) -> None:
    d, *wanted = STABILITY[name]
    head = {"format": "glmref-method-1", "class": "glm",
            "source": {"citation": "made", "where": "here", "status": "derived"}}  # fmt: skip
    (tmp_path / "x.json").write_text(
        json.dumps({**head, **d, "name": "x", "claims": {"a-stable": True, "l-stable": True}})
    )
    _, missing = write_certificates([str(tmp_path / "x.json")], tmp_path / "c")
    assert not missing
    for claim, steps in zip(("a-stable", "l-stable"), wanted, strict=True):
        (path,) = (tmp_path / "c").glob(f"*{claim}*")
        found = json.loads(path.read_text(encoding="utf-8"))
        said = [x["witness"] if x["rule"] == "not-a-stable" else x["rule"] for x in found["parts"]]
        assert said == steps
        holds = "a-stable" in said and (claim == "a-stable" or "l-limit" in said)
        assert found["statement"]["verdict"] == ("holds" if holds else "fails")
        assert glmref_check.verdict(found)[0]


def changed(name: str, claim: str, place: tuple[Any, ...], value: Any) -> dict[str, Any]:
    d = shipped(name)
    *inner, last = place
    at = d
    for key in inner:
        at = at[key]
    at[last] = value
    return {**d, "claims": {claim: True}}


@pytest.mark.parametrize(
    ("document", "rule"),
    [
        (changed("fehlberg-2-1", "row-sums", ("c", 1), "1/3"), "no-row-sums"),
        (changed("bogacki-shampine-3-2", "dense-end", ("dense", 3, 2), "2"), "no-dense-end"),
        (changed("g4123", "g-symplectic", ("G", 1, 1), "5"), "given-form-fails"),
        (changed("gsymplectic-n-pair", "g-symplectic", ("G", 1, 1), "5"), "given-form-fails"),
    ],
    ids=["row sums", "dense output", "form", "form of a pair"],
)
def test_what_a_changed_entry_breaks_has_its_certificate(
    document: dict[str, Any], rule: str, tmp_path: Path
) -> None:
    (tmp_path / "x.json").write_text(json.dumps({**document, "name": "x"}), encoding="utf-8")
    _, missing = write_certificates([str(tmp_path / "x.json")], tmp_path / "c")
    (claim,) = document["claims"]
    (path,) = (tmp_path / "c").glob(f"*{claim}*")
    found = json.loads(path.read_text(encoding="utf-8"))
    assert not missing and glmref_check.verdict(found)[0]
    assert found["statement"]["verdict"] == "fails"
    assert rule in [x["rule"] for x in found["parts"]]


@pytest.mark.parametrize(
    ("below", "U", "B"),
    [
        ("1/3", [["1", "1/3"], ["1", "1"]], [["1/2", "1/2"], ["0", "0"]]),
        ("1/3", [["1", "-1"], ["1/2", "-1"]], [["1", "-1"], ["-1", "0"]]),
        ("0", [["1/2", "1/2"], ["-1", "1"]], [["1/2", "0"], ["1/2", "1"]]),
    ],
)
@pytest.mark.parametrize("order", [1, 2])
def test_order_2_is_refuted_where_values_may_be_exchanged(
    below: str, U: Any, B: Any, order: int, tmp_path: Path
) -> None:
    """Two values that V keeps both: the series has an unknown more, and one vector sees [o]."""
    d = {"format": "glmref-method-1", "class": "glm", "name": "x", "claims": {"order": order},
         "A": [["0", "0"], [below, "0"]], "U": U, "B": B, "V": [["1", "0"], ["0", "1"]],
         "source": {"citation": "made", "where": "here", "status": "derived"}}  # fmt: skip
    (tmp_path / "x.json").write_text(json.dumps(d), encoding="utf-8")
    _, missing = write_certificates([str(tmp_path / "x.json")], tmp_path / "c")
    (path,) = (tmp_path / "c").iterdir()
    found = json.loads(path.read_text(encoding="utf-8"))
    accepted, why = glmref_check.verdict(found)
    assert accepted and not missing, why
    assert found["statement"]["verdict"] == ("holds" if order == 1 else "fails")
    assert set(found["parts"][-1]["witness"]["n"]) == {"[o]"}
