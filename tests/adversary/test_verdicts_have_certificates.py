"""Files with numbers changed by little or much: every verdict has a certificate that passes.

The checker shares no code with the package, so that it is a second opinion on every verdict.
"""

import json
import random
import shutil
from fractions import Fraction
from pathlib import Path as File
from typing import Any

import pytest

from glmref import judge
from glmref.catalogue.claims import CLAIMS
from glmref.cli.certifying import write_certificates
from glmref.errors import DataError, ExactnessError, GlmrefError
from glmref.exact import ball
from glmref.exact.expression import parse
from tests.inside import Path, at, put, texts

from .deceive import Verdict, decimal, findings, shipped

NAMES = (
    "dormand-prince-5", "shampine-4", "nystrom-rkn-4", "ars-4-4-3", "bettis-rkn-5-4", "rodas3",
    "sharp-verner-7-6", "nystrom-rkn-4-velocities", "ros3p", "bogacki-shampine-3", "gsymplectic-n",
    "bdf-3", "gauss-2", "radau-iia-2", "milne-simpson", "lobatto-iiia-iiib-3", "stormer-verlet",
    "leapfrog", "sdirk-2", "ark-4", "multistep-rkn-8", "butcher-effective-5", "kutta-3", "am-4",
    "kennedy-carpenter-ark-4-3", "milne-simpson-one-leg", "pseudo-rk-4", "dimsim-2-type-2",
)  # fmt: skip
#: Keys of a document that hold numbers of the method.
NUMBERS = (
    "A", "b", "b_prime", "c", "A_prime", "alpha", "gamma", "beta", "embedded", "dense", "parts", "U",
    "B", "V", "A_hat", "b_hat", "q", "p", "G", "D",
)  # fmt: skip


def numbers(d: dict[str, Any], *keys: str) -> list[Path]:
    """Return the places of the numbers below keys of a document."""
    found = [path for key in keys if key in d for path in texts(d[key], (key,))]
    return [path for path in found if path[-1] != "name"]


def deceiver(name: str, rng: random.Random) -> dict[str, Any]:
    """A file of the catalogue with one or two numbers and some claims changed."""
    d = shipped(name)
    for path in rng.sample(numbers(d, *NUMBERS), rng.choice((1, 1, 2))):
        text = at(d, path)
        changes = (f"{text}+1/1{'0' * 50}", f"{text}+1/1{'0' * 50}", "0", f"-({text})", f"{text}+1")
        put(d, path, rng.choice(changes))
    for claim, value in d["claims"].items():
        if type(value) is int and rng.random() < 0.4:
            d["claims"][claim] = max(0, value - rng.choice((1, 1, 2)))
        if isinstance(value, bool) and rng.random() < 0.3:
            d["claims"][claim] = not value
        if isinstance(value, dict) and rng.random() < 0.3:
            row = rng.choice(list(value))
            d["claims"][claim] = {**value, row: max(1, value[row] - 1)}
    d["name"] = "deceiver"
    return d


def without_a_certificate(d: dict[str, Any], folder: File) -> list[str]:
    """The verdicts that no accepted certificate stands behind."""
    try:
        decided = {c for c, x in findings(d).items() if x.verdict is not Verdict.OPEN}
    except (DataError, ExactnessError):
        return []
    (folder / "deceiver.json").write_text(json.dumps(d), encoding="utf-8")
    shutil.rmtree(folder / "out", ignore_errors=True)
    write_certificates([str(folder / "deceiver.json")], folder / "out")
    refused = []
    for path in (folder / "out").rglob("*.json"):
        certificate = json.loads(path.read_text(encoding="utf-8"))
        accepted, why = judge.verdict(certificate)
        if accepted:
            decided.discard(certificate["statement"]["claim"])
        else:
            refused.append(why)
    return [*sorted(decided), *refused]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("seed", range(4))
def test_every_verdict_about_a_changed_file_has_a_certificate(seed: int, tmp_path: File) -> None:
    rng = random.Random(seed)
    d = deceiver(rng.choice(NAMES), rng)
    assert without_a_certificate(d, tmp_path) == []


@pytest.mark.slow
def test_every_verdict_about_many_changed_files_has_a_certificate(tmp_path: File) -> None:
    for seed in range(100, 160):
        rng = random.Random(seed)
        name = rng.choice(NAMES)
        assert without_a_certificate(deceiver(name, rng), tmp_path) == [], (seed, name)


def rounded(d: dict[str, Any], digits: int) -> dict[str, Any]:
    """The file with every number but whole ones as a decimal, as tables are printed."""
    constants: dict[str, Any] = {}
    for name, text in d.pop("constants", {}).items():
        constants[name] = parse(text, constants=constants)
    for path in numbers(d, *NUMBERS, "a"):
        value: Any = parse(at(d, path), constants=constants)
        exact = value.as_fraction()
        if exact is None:
            exact = Fraction(ball(value).real.midpoint().decimal_text(60))
        near = decimal(exact, digits) if exact.denominator > 1 else str(exact)
        put(d, path, near if near.strip("-0.") else "0")
    return {**d, "name": "deceiver", "digits": digits}


def opposite(value: Any) -> Any:
    """Another value of a claim, one that is false as a rule."""
    match value:
        case bool():
            return not value
        case int():
            return max(0, value - 1)
        case dict():
            return {name: max(1, p - 1) for name, p in value.items()}
        case list():
            return ["1"] * len(value)
    return "7"


def other_claims(d: dict[str, Any]) -> list[dict[str, Any]]:
    """The claims of the file, their opposites, and claims that the file does not make."""
    for key in ("starting", "finishing"):
        d.get(key, {}).pop("order", None)
    own = d["claims"]
    more: dict[str, Any] = {key: True for key, x in CLAIMS.items() if x.type is bool}
    more |= {key: 2 for key, x in CLAIMS.items() if x.type is int}
    more = {key: x for key, x in more.items() if key not in own}
    single = [{**d, "claims": {key: x}} for key, x in more.items()]
    return [d, {**d, "claims": {k: opposite(x) for k, x in own.items()}}, *single]


def uncertified(name: str, digits: int, folder: File) -> list[str]:
    """The verdicts without a certificate about a table that was rounded, whatever is claimed."""
    found = []
    for k, d in enumerate(other_claims(rounded(shipped(name), digits))):
        try:
            found += without_a_certificate(d, folder)
        except GlmrefError:  # the claim has no meaning for the class
            assert k > 1, "a table is refused with its own claims or their opposites"
    return found


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "name", ["heun-3", "bdf-2", "gsymplectic-n", "ars-2-3-2", "yoshida-4", "stoermer-13"]
)
def test_every_verdict_about_decimals_has_a_certificate(name: str, tmp_path: File) -> None:
    assert uncertified(name, 16, tmp_path) == []


@pytest.mark.slow
@pytest.mark.parametrize("digits", [3, 33])
def test_every_verdict_about_many_decimals_has_a_certificate(digits: int, tmp_path: File) -> None:
    for name in ("nystrom-rkn-4-velocities", "ros3p", "milne-simpson-one-leg", "pseudo-rk-4"):
        assert uncertified(name, digits, tmp_path) == [], name


def with_decimals(**more: Any) -> dict[str, Any]:
    """A Runge-Kutta file of three or ten digits."""
    return {**shipped("rk4"), "format": "glmref-method-2", "name": "deceiver", **more}


CUBE_ROOTS: dict[str, Any] = {
    "class": "one-leg", "digits": 3, "alpha": ["-1", "0", "0", "1"],
    "beta": ["1/2", "0.500", "-1/3", "1/3"],
}  # fmt: skip


def test_bounds_of_two_rows_do_not_refute_their_orders(tmp_path: File) -> None:
    """An upper bound of the order of a row is another statement than the order declared."""
    d = with_decimals(A=[["0", "0"], ["1", "0"]], b=["1/2", "1/2"])
    d["embedded"] = [{"name": x, "b": ["1", "0"]} for x in ("one", "two")]
    d["claims"] = {"embedded-order": {"one": 1, "two": 1}}
    (tmp_path / "deceiver.json").write_text(json.dumps(d), encoding="utf-8")
    write_certificates([str(tmp_path / "deceiver.json")], tmp_path / "out")
    (path,) = (tmp_path / "out").rglob("*.json")
    certificate = json.loads(path.read_text(encoding="utf-8"))
    assert judge.verdict(certificate)[0]
    certificate["statement"]["verdict"] = "fails"
    assert not judge.verdict(certificate)[0]
    bound = {"order": 3, "principal": "identity", "trees": "all", "tree": "[[[o]]]"}
    certificate["parts"][0]["witness"]["parts"] = [{"rule": "order-at-most", "witness": bound}]
    assert judge.verdict(certificate) == (False, "the rows may have the orders")


@pytest.mark.parametrize(
    ("keys", "claims", "reason"),
    [
        (CUBE_ROOTS, {"parasitism-free": False}, "an eigenvalue that is not real"),
    ],
)  # fmt: skip
def test_what_has_no_certificate_is_open_and_says_why(keys, claims, reason, tmp_path):
    d = {"format": "glmref-method-2", "name": "deceiver", "source": shipped("rk4")["source"],
         **keys, "claims": claims}  # fmt: skip
    ((found,),) = [findings(d).values()]
    assert found.verdict is Verdict.OPEN and reason in found.witness
    (tmp_path / "deceiver.json").write_text(json.dumps(d), encoding="utf-8")
    _, (why,) = write_certificates([str(tmp_path / "deceiver.json")], tmp_path / "out")
    assert reason in why
