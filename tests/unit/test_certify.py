"""Certificates: what they hold, and how the command line writes them."""

import json
import random
from fractions import Fraction
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from click.testing import CliRunner

from glmref import judge
from glmref.catalogue.lookup import data_root
from glmref.catalogue.reader import load_document
from glmref.cli.certifying import certify, write_certificates
from glmref.findings import Verdict
from glmref.prove.verifier import facts_for
from glmref.theory.symplectic import GSymplecticity
from tests.adversary.deceive import shipped
from tests.build import SOURCE

SCHEMA = data_root() / "schema" / "glmref-certificate-1.schema.json"


def certificates(name: str, folder: Path) -> dict[str, dict]:
    result = CliRunner().invoke(certify, [name, "--output", str(folder)], standalone_mode=False)
    assert result.exception is None, result.output
    found = [json.loads(p.read_text()) for p in folder.glob("*.json")]
    return {x["statement"]["claim"]: x for x in found}


@pytest.mark.sampled(1, besides=("gsymplectic-n", "leapfrog"))
@pytest.mark.parametrize(
    "name", ["rk4", "gauss-2", "gsymplectic-n", "bdf-7", "leapfrog", "ars-2-2-2"]
)
def test_certificates_follow_their_schema(name: str, tmp_path: Path) -> None:
    schema = json.loads(SCHEMA.read_text())
    found = certificates(name, tmp_path)
    assert found
    for certificate in found.values():
        jsonschema.validate(certificate, schema)


def test_the_order_of_rk4_names_the_tree_that_refutes_the_next(tmp_path: Path) -> None:
    found = certificates("rk4", tmp_path)["order"]
    below, above = (part["witness"] for part in found["parts"])
    assert above == {**below, "tree": "[oooo]"} and below["order"] == 4
    assert found["statement"]["verdict"] == "holds"
    assert certificates("gsymplectic-n", tmp_path / "n")["order"]["field"]["kind"] == "tower"


@pytest.mark.slow
def test_order_10_is_refuted_above_by_one_tree(tmp_path: Path) -> None:
    """Beyond order 10 the trees of the next order are not listed."""
    at_most = certificates("gauss-5", tmp_path)["order"]["parts"][1]["witness"]
    assert (at_most["order"], at_most["tree"]) == (10, f"[{'o' * 10}]")


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


@pytest.mark.sampled(1)
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
            accepted, why = judge.verdict(certificate)
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
def test_enclosed_methods_have_certificates_that_pass(name, otherwise, tmp_path):
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
        accepted, why = judge.verdict(x)
        assert accepted, (x["statement"], why)
        fails = x["statement"]["claim"] in otherwise
        assert x["statement"]["verdict"] == ("fails" if fails else "holds")


def certified(d: dict[str, Any], claim: str, facts: Any = None) -> dict[str, Any]:
    """The certificate of a claim, which the checker accepts."""
    facts = facts or facts_for(load_document(d))
    declared = d["claims"][claim]
    found = facts.judge(claim, declared).certificate
    assert isinstance(found, dict), found
    found = json.loads(json.dumps(found))
    accepted, why = judge.verdict(found)
    assert accepted, why
    return found


def growing_pair(third: str, w: tuple[int, int] = (-2, 2), v: int = 3) -> dict[str, Any]:
    """P Q P, whose value at -1 grows by 4 and 9, and an idle value at another eigenvalue."""
    V = [["1", "0", "0"], ["0", "-1", "0"], ["0", "0", third]]
    q = {"A": [[f"{1 + v * w[0]}/2", "0"]], "U": [["1", str(-v), "0"]], "V": V,
         "B": [["1/2", "1/2"], [f"{w[0]}/2", f"{w[1]}/2"], ["0", "0"]]}  # fmt: skip
    p = {"A": [["0"], [str(1 + w[1] * v)]], "U": [["1", str(-x), "0"] for x in w], "V": V,
         "B": [["1"], [str(v)], ["0"]]}  # fmt: skip
    return {"format": "glmref-method-1", "name": "x", "class": "partitioned", "separable": True,
            "field": "complex", "q": q, "p": p, "source": SOURCE}  # fmt: skip


@pytest.mark.parametrize(("third", "part"), [("i", 1), ("-i", 0), ("1/2", 0)])
@pytest.mark.parametrize("claim", ["growth", "parasitism-free"])
def test_the_eigenvalue_at_which_a_pair_grows_is_named(claim: str, third: str, part: int) -> None:
    zeros = ["0"] * (2 if third == "1/2" else 4)
    d = {**growing_pair(third), "claims": {claim: zeros if claim == "growth" else True}}
    found = certified(d, claim)
    assert found["statement"]["verdict"] == "fails"
    assert found["parts"][-1] == {"rule": "grows", "witness": {"part": part}}
    for other in {0, 1, 2, -1} - {part}:
        found["parts"][-1]["witness"]["part"] = other
        assert not judge.verdict(found)[0], other


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_growth_of_a_pair_with_shared_stages_has_two_numbers_for_each_eigenvalue(count):
    """Those of a half alone are no growth parameters; `parasitism-free` is about them too."""
    half = {k: shipped("g4123")[k] for k in "AUBV"}
    d = {"format": "glmref-method-1", "name": "x", "class": "partitioned", "separable": False,
         "q": half, "p": half, "claims": {"growth": ["0"] * count}, "source": SOURCE}  # fmt: skip
    found = certified(d, "growth")
    holds = count == 2
    assert found["statement"]["verdict"] == ("holds" if holds else "fails")
    found["statement"]["verdict"] = "fails" if holds else "holds"
    if holds:
        found["parts"][-1] = {"rule": "grows", "witness": {"part": -1}}
    else:
        found["parts"][-1] = {"rule": "growth", "witness": {"list": []}}
    assert not judge.verdict(found)[0]


@pytest.mark.parametrize(
    "name", ["gauss-2", "gsymplectic-n", "g4123", "gsymplectic-n-pair", "stormer-verlet", "rk4"]
)
def test_a_form_that_nothing_proposes_is_found_by_elimination(name: str) -> None:
    d = {k: v for k, v in shipped(name).items() if k not in ("G", "D", "D_P", "D_Q")}
    d["claims"] = {"g-symplectic": True}
    facts = facts_for(load_document(d))
    facts.__dict__["g_symplecticity"] = GSymplecticity(None)  # as where the search gives up
    rules = [x["rule"] for x in certified(d, "g-symplectic", facts)["parts"]]
    assert rules == ["preconsistent", "no-form" if name == "rk4" else "form"]


@pytest.mark.parametrize("name", ["gsymplectic-n", "g4123"])
@pytest.mark.parametrize("declared", [True, False])
def test_a_form_without_d_of_a_method_without_u_is_refuted(name: str, declared: bool) -> None:
    d = {**shipped(name), "claims": {"g-symplectic": declared}}
    for key in ("D", "starting", "finishing"):
        d.pop(key, None)
    rules = [x["rule"] for x in certified(d, "g-symplectic")["parts"]]
    assert rules == (["preconsistent", "form"] if declared else rules)
    d["U"][0][0] = "2"
    found = certified(d, "g-symplectic")
    assert [x["rule"] for x in found["parts"]] == ["not-preconsistent"]
    assert found["statement"]["verdict"] == ("fails" if declared else "holds")


def test_a_form_that_ignores_the_solution_is_refuted() -> None:
    """u^* G u is 0: the identities hold, and nothing is conserved."""
    d = {**shipped("gsymplectic-n"), "claims": {"g-symplectic": True}}
    d |= {"G": [["0", "0"], ["0", "0"]], "D": ["0", "0"]}
    d.pop("starting", None)
    found = certified(d, "g-symplectic")
    assert [x["rule"] for x in found["parts"]] == ["given-form-fails"]
    d["G"][0][0] = "1"
    assert [x["rule"] for x in certified(d, "g-symplectic")["parts"]] == ["given-form-fails"]


@pytest.mark.parametrize(("zeta", "mu"), [("1", "2"), ("1", "-1/3"), ("-1", "2"), ("-1", "0")])
def test_growth_of_one_value_is_shown_exactly(zeta: str, mu: str) -> None:
    """Euler's method, and a value that feeds on itself at a simple or at a double eigenvalue."""
    b = str(Fraction(zeta) * Fraction(mu))
    d = {"format": "glmref-method-1", "class": "glm", "name": "x", "A": [["0", "0"]] * 2,
         "U": [["1", "0"], ["1", "1"]], "B": [["1", "0"], [str(-Fraction(b)), b]],
         "V": [["1", "0"], ["0", zeta]], "claims": {}, "source": SOURCE}  # fmt: skip
    found = facts_for(load_document(d)).judge("growth", ["7"])
    assert (found.verdict, found.value) == (Verdict.FAILS, [mu])


def beside_idle_values(seed: int) -> dict[str, Any]:
    """A method of order 2 or 3 with values beside the solution that V = 1 keeps."""
    draw = random.Random(seed)

    def some() -> Fraction:
        return Fraction(draw.choice((-1, 0, 1, 1, 2)), draw.choice((1, 2, 3)))

    x = Fraction(draw.choice((1, 2, 3)), draw.choice((2, 3)))
    A: list[list[Any]] = [[0, 0], [x, 0]]
    b: list[Any] = [1 - 1 / (2 * x), 1 / (2 * x)]
    if draw.choice((True, False)):
        A = [[0, 0, 0], [Fraction(1, 3), 0, 0], [0, Fraction(2, 3), 0]]
        b = [Fraction(1, 4), 0, Fraction(3, 4)]
    r, s = draw.choice((2, 2, 3)), len(b)
    U = [[1, *(some() for _ in range(r - 1))] for _ in range(s)]
    B = [b]
    for _ in range(r - 1):
        m = draw.choice((0, 0, 1)) * some()
        B.append([m, *[0] * (s - 2), -m])
    V = [[int(i == j) for j in range(r)] for i in range(r)]
    blocks = {
        k: [[str(x) for x in row] for row in M] for k, M in zip("AUBV", (A, U, B, V), strict=True)
    }
    return {"format": "glmref-method-1", "class": "glm", "name": "x", **blocks, "source": SOURCE}


@pytest.mark.parametrize("seed", range(16))
def test_what_refutes_an_order_of_several_values_sees_no_unknown(seed: int) -> None:
    """The orders beside the one that is proved are refused."""
    d = {**beside_idle_values(seed), "claims": {"order": 4}}
    found = certified(d, "order")
    assert found["statement"]["verdict"] == "fails"
    order = found["parts"][0]["witness"]["order"]
    found = certified({**d, "claims": {"order": order}}, "order")
    assert found["statement"]["verdict"] == "holds"
    for other in (order - 1, order + 1):
        for part in found["parts"]:
            part["witness"]["order"] = other
        found["statement"]["declared"] = found["document"]["claims"]["order"] = other
        assert not judge.verdict(found)[0], other
