"""The judge accepts certificates of the catalogue; enclosed ones with a changed number do not."""

import copy
import json
import os
import random
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from glmref import judge
from glmref.catalogue.files import names
from glmref.catalogue.lookup import data_root, document
from glmref.catalogue.reader import load_document
from glmref.cli.certifying import write_certificates
from glmref.findings import Verdict
from glmref.judge.arithmetic import Interval
from glmref.judge.document import Method
from glmref.judge.numbers import apart
from glmref.judge.proof import Proof
from glmref.judge.refusals import Refused
from glmref.judge.rule import Bounded
from glmref.judge.statements import RULES
from glmref.prove.verifier import verify

#: One file of each kind: sweeps with one and several values, pairs, splittings, an exact method with
#: a start in decimals; files that are wrong; the reduced method; a matrix search over intervals; an additive method.
SAMPLE = (
    "yoshida-6-midpoint", "t115-i", "pair-4-4", "pair-rkn-6-8b", "kahan-li-6", "mclachlan-atela-4",
    "pair-4-4-p-digit", "pair-4-4-start-p-sign", "pair-4-5-not-palindromic", "am-1",
    "gauss-2-seven-digits", "gauss-2", "rk4", "gsymplectic-n", "stormer-verlet", "ars-4-4-3",
    "multistep-10", "multistep-rkn-8", "tsitouras-5-4", "ros34pw2",
)  # fmt: skip
#: With these each rule occurs that the catalogue uses, and each class with each kind of numbers.
MORE = (
    "ark-4-v-preconsistent", "dimsim-2-type-1-embedded-values", "thesis-order6-printed-a",
    "bogacki-shampine-3-2", "bogacki-shampine-digit", "cash-karp-5-4-abscissa", "ssp3-4-3-3-digit",
    "explicit-2-step-order-3", "pair-idle-value", "am-2-error-constant", "thesis-gx2-sign-clash",
    "ros3-printed", "radau-iia-1", "g4123", "multistep-general-8-growth-sign",
    "explicit-euler-pair-symplectic", "milne-simpson-one-leg-order-4", "saba-3-digit",
    "ars-2-3-3-digit", "fine-rkn-4-3-second-stage", "mclachlan-atela-4-digits-swapped",
    "ros3p-w-order-2", "ros34pw2-sign", "suzuki-4-root-swapped", "gsymplectic-n-p-pair",
    "dormand-prince-rkn-6-4-fd", "milne-predictor", "lobatto-iiia-iiib-4", "g6245", "s3z-k13-sign",
)  # fmt: skip
#: Rules of which the catalogue has no statement; hostile certificates have them.
UNUSED = {"absent", "no-dense-end", "not-dense"}
#: Minutes each: asked for by the environment variable GLMREF_LONG. ``verify --no-cache`` has all
#: statements judged over FLINT's numbers.
LONG = pytest.mark.skipif("GLMREF_LONG" not in os.environ, reason="GLMREF_LONG is not set")
ENCLOSED = (
    "yoshida-6-midpoint", "t115-i", "pair-4-4", "pair-rkn-6-8b", "mclachlan-atela-4",
    "tsitouras-5-4", "ros34pw2",
)  # fmt: skip


def read(folder: Path) -> Iterator[dict[str, Any]]:
    for path in sorted(folder.glob("*.json")):
        yield json.loads(path.read_text(encoding="utf-8"))


def refused(certificates: Iterator[dict[str, Any]]) -> list[str]:
    found = []
    for x in certificates:
        accepted, why = judge.verdict(x)
        if not accepted:
            found.append(f"{x['statement']['method']} {x['statement']['claim']}: {why}")
    return found


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], dict[str, Any]]:
    folder = tmp_path_factory.mktemp("certificates")
    _, missing = write_certificates(list(SAMPLE), folder)
    assert not missing
    return {(x["statement"]["method"], x["statement"]["claim"]): x for x in read(folder)}


def test_every_claim_of_the_sample_is_accepted(sample: dict[Any, dict[str, Any]]) -> None:
    assert not refused(iter(sample.values()))


def test_enclosed_certificates_follow_their_schema(sample: dict[Any, dict[str, Any]]) -> None:
    schema = json.loads((data_root() / "schema" / "glmref-certificate-1.schema.json").read_text())
    for key in (("t115-i", "starting-order"), ("pair-4-4", "starting-order"), ("rk4", "order")):
        jsonschema.validate(sample[key], schema)


def rules_of(parts: list[dict[str, Any]]) -> Iterator[str]:
    for part in parts:
        yield part["rule"]
        yield from rules_of(part["witness"].get("parts", []))


@pytest.mark.slow
def test_claims_of_each_rule_class_and_kind_of_numbers_are_accepted(sample, tmp_path):
    _, missing = write_certificates(list(MORE), tmp_path)
    assert not missing
    more = list(read(tmp_path))
    used = {rule for x in (*sample.values(), *more) for rule in rules_of(x["parts"])}
    assert used == set(RULES) - UNUSED
    assert not refused(iter(more))


@LONG
@pytest.mark.slow
def test_every_claim_of_the_catalogue_is_accepted(tmp_path: Path) -> None:
    _, missing = write_certificates(names("all"), tmp_path)
    assert not missing
    start = time.process_time()
    assert not refused(read(tmp_path))
    assert time.process_time() - start < 300


# ------------------------------------------------------------------------- random changes

Change = Callable[[dict[str, Any], random.Random], None]


def digit(text: str, rng: random.Random) -> str:
    places = [k for k, c in enumerate(text) if c.isdigit()]
    k = rng.choice(places)
    return text[:k] + str((int(text[k]) + rng.randint(1, 8)) % 10) + text[k + 1 :]


def change_unknown(value: dict[str, Any], rng: random.Random) -> None:
    unknowns = value["document"]["unknowns"]
    name = rng.choice(list(unknowns))
    unknowns[name] = digit(unknowns[name], rng)


def change_sign(value: dict[str, Any], rng: random.Random) -> None:
    unknowns = value["document"]["unknowns"]
    name = rng.choice(list(unknowns))
    text = unknowns[name]
    unknowns[name] = text[1:] if text.startswith("-") else f"-{text}"


def change_constant(value: dict[str, Any], rng: random.Random) -> None:
    """One of the method; e1 is a weight of a row, and only claims on the row depend on it."""
    constants = value["document"].get("constants") or value["document"]["unknowns"]
    row = value["statement"]["claim"].startswith("embedded")
    name = rng.choice([x for x in constants if row or x != "e1"])
    constants[name] = digit(constants[name], rng)


def change_centre(value: dict[str, Any], rng: random.Random) -> None:
    """A digit within the published ones: the root is not where the centre is."""
    centre = value["field"]["proofs"]["method"]["centre"]
    k = rng.randrange(len(centre))
    mantissa, e, exponent = centre[k].partition("e")
    centre[k] = digit(mantissa[:60], rng) + mantissa[60:] + e + exponent


def change_inverse(value: dict[str, Any], rng: random.Random) -> None:
    """A row of another sign: the map is no contraction."""
    rows = value["field"]["proofs"]["method"]["inverse"]
    k = rng.randrange(len(rows))
    rows[k] = [x[1:] if x.startswith("-") else f"-{x}" for x in rows[k]]


def change_radius(value: dict[str, Any], rng: random.Random) -> None:
    value["field"]["proofs"]["method"]["radius"] = f"1e-{rng.choice([40, 59, 61, 70])}"


def leave_out(value: dict[str, Any], rng: random.Random) -> None:
    """One equation with its unknown's row: the equations are not as many as the unknowns."""
    equations = value["document"]["enclosure"]["equations"]
    equations.pop(rng.randrange(len(equations)))


def change_equation(value: dict[str, Any], rng: random.Random) -> None:
    """Two equations exchanged: Y belongs to another order."""
    equations = value["document"]["enclosure"]["equations"]
    i, j = rng.sample(range(len(equations)), 2)
    equations[i], equations[j] = equations[j], equations[i]


def change_claim(value: dict[str, Any], rng: random.Random) -> None:
    statement = value["statement"]
    if isinstance(statement["declared"], dict):
        other = {name: order + rng.choice([-1, 1]) for name, order in statement["declared"].items()}
        statement["declared"], value["document"]["claims"] = other, {statement["claim"]: other}
        return
    other = (
        not statement["declared"] if isinstance(statement["declared"], bool)
        else [*statement["declared"][1:], "1/7"] if isinstance(statement["declared"], list)
        else statement["declared"] + rng.choice([-1, 1])
    )  # fmt: skip
    statement["declared"] = other
    value["document"]["claims"] = {statement["claim"]: other}


def change_part(value: dict[str, Any], rng: random.Random) -> None:
    """A part left out or twice."""
    parts = value["parts"]
    k = rng.randrange(len(parts))
    if rng.random() < 0.5:
        parts.pop(k)
    else:
        parts.insert(k, copy.deepcopy(parts[k]))


CHANGES: tuple[Change, ...] = (
    change_unknown, change_unknown, change_sign, change_constant, change_centre, change_inverse,
    change_radius, leave_out, change_equation, change_claim, change_part,
)  # fmt: skip


def changed(sample: dict[Any, dict[str, Any]], count: int, seed: int) -> list[str]:
    """The changed certificates that the checker accepts."""
    rng, accepted = random.Random(seed), []
    keys = sorted(k for k in sample if k[0] in ENCLOSED)
    while count:
        name, change = rng.choice(keys), rng.choice(CHANGES)
        value = copy.deepcopy(sample[name])
        change(value, rng)
        if json.dumps(value) == json.dumps(sample[name]):
            continue
        count -= 1
        if judge.verdict(value)[0]:
            accepted.append(f"{name} {change.__name__}")
    return accepted


@pytest.mark.slow
def test_changes_of_enclosed_certificates_are_refused(sample: dict[Any, dict[str, Any]]) -> None:
    assert not changed(sample, 60, seed=14)


@LONG
@pytest.mark.slow
def test_a_thousand_changes_of_enclosed_certificates_are_refused(sample):
    assert not changed(sample, 1000, seed=20261)


@pytest.mark.slow
def test_a_condition_of_a_start_cannot_be_left_out(sample: dict[Any, dict[str, Any]]) -> None:
    for key in (("t115-i", "starting-order"), ("pair-4-4", "starting-order")):
        value = copy.deepcopy(sample[key])
        value["field"]["proofs"]["starting"]["conditions"].pop()
        assert not judge.verdict(value)[0]


def test_a_changed_entry_of_an_additive_method_is_refused(sample):
    count = len(sample["ars-4-4-3", "order"]["document"]["parts"][0]["b"])
    for part in range(2):
        for i in range(count):
            value = copy.deepcopy(sample["ars-4-4-3", "order"])
            value["document"]["parts"][part]["A"][count - 1][i] += "+1/97"
            assert not judge.verdict(value)[0]
            value = copy.deepcopy(sample["ars-4-4-3", "order"])
            value["document"]["parts"][part]["b"][i] += "+1/97"
            assert not judge.verdict(value)[0]


def test_parts_of_an_additive_method_share_their_stages(sample: dict[Any, dict[str, Any]]) -> None:
    value = copy.deepcopy(sample["ars-4-4-3", "preconsistent"])
    value["document"]["parts"][1] = {"A": [["0"]], "b": ["1"]}
    assert "other stages" in judge.verdict(value)[1]
    value = copy.deepcopy(sample["ars-4-4-3", "preconsistent"])
    value["statement"]["claim"] = "symplectic"
    value["document"]["claims"] = {}
    assert "no meaning" in judge.verdict(value)[1]


def test_a_sweep_that_is_not_preconsistent_is_refused(sample: dict[Any, dict[str, Any]]) -> None:
    """The first row of X must be 1 identically, however little it differs."""
    value = copy.deepcopy(sample["t115-i", "order"])
    value["document"]["X"][0][2] = "1+1/1" + "0" * 80
    accepted, why = judge.verdict(value)
    assert not accepted
    assert "first row" in why


def test_a_truth_that_is_not_decided_is_a_refusal() -> None:
    around_zero = Interval(-1, 1)
    with pytest.raises(Refused):
        bool(around_zero)
    with pytest.raises(Refused):
        _ = around_zero == 0
    assert not apart(around_zero)
    assert apart(Interval(1, 2))


# ------------------------------------------------------------------- orders by trees without branches

ALONG = (
    ("multistep-10", "order"), ("multistep-10", "order-identity"), ("multistep-10", "starting-order"),
    ("multistep-rkn-8", "nystrom-order"), ("multistep-rkn-8", "nystrom-starting-order"),
)  # fmt: skip


@pytest.mark.sampled(1)
@pytest.mark.parametrize("key", ALONG, ids=" ".join)
def test_changes_of_a_certificate_by_paths_are_refused(sample, key):
    rng = random.Random(14)
    for _ in range(25):
        value = copy.deepcopy(sample[key])
        matrix = value["document"][rng.choice("qp")][rng.choice("AUBV")]
        row = rng.choice(matrix)
        k = rng.randrange(len(row))
        row[k] += "+1/10000000000000007"
        assert not judge.verdict(value)[0]
    value = copy.deepcopy(sample[key])
    for part in value["parts"]:  # the words for other trees
        for before, after in (("nystrom-paths", "paths"), ("paths", "nystrom-paths")):
            if part["witness"].get("trees") == before:
                part["witness"]["trees"] = after
                break
    assert not judge.verdict(value)[0]


@pytest.mark.sampled(0)
@pytest.mark.parametrize("key", ALONG[2::2], ids=" ".join)
def test_a_changed_start_is_refused_along_paths(sample, key):
    rng, start = random.Random(15), sample[key]["document"]["starting"]
    used = [(m, i, j) for m in ("A", "A_hat", "B", "B_hat") for i, row in enumerate(start[m])
            for j, x in enumerate(row) if x != "0"]  # fmt: skip
    for m, i, j in rng.sample(used, 12):
        value = copy.deepcopy(sample[key])
        value["document"]["starting"][m][i][j] += "+1/10000000000000007"
        # a late round may use a stage that counts at higher orders only: the claim is still true
        whole = {**document(key[0]), **value["document"]}
        (found,) = (x for x in verify(load_document(whole)) if x.claim == key[1])
        assert judge.verdict(value)[0] == (found.verdict is Verdict.HOLDS), (m, i, j)


def test_pairs_that_share_an_eigenvalue_are_refused(sample: dict[Any, dict[str, Any]]) -> None:
    value = copy.deepcopy(sample["multistep-rkn-8", "parasitism-free"])
    assert [part["rule"] for part in value["parts"]] == ["bounded", "bounded", "unshared"]
    proof = Proof(value, RULES)
    proof.shown += map(Bounded, "fk")
    RULES["unshared"].apply(proof, {})
    for first in ("1", "2"):  # the eigenvalues of the first block: exp(+-i pi/3); 1 twice
        value["document"]["p"]["V"][1][1] = first
        if first == "1":
            value["document"]["q"]["V"] = value["document"]["p"]["V"]
        else:
            value["document"]["q"]["V"] = [["1"]]
        other = Proof(sample["multistep-rkn-8", "parasitism-free"], RULES)
        other.method = Method(value["document"], proof.record.numbers)
        other.shown += map(Bounded, "fk")
        with pytest.raises(Refused):
            RULES["unshared"].apply(other, {})
