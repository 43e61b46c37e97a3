"""Files with numbers changed by little or much: every verdict has a certificate that passes.

The checker shares no code with the package, so that it is a second opinion on every verdict.
"""

from __future__ import annotations

import importlib.util
import json
import random
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from glmref.cli.certifying import write_certificates
from glmref.errors import DataError, ExactnessError

from .deceive import Verdict, findings, shipped

PATH = Path(__file__).resolve().parents[2] / "checker" / "glmref_check.py"
SPEC = importlib.util.spec_from_file_location("glmref_check", PATH)
assert SPEC is not None
assert SPEC.loader is not None
check = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(check)

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


def leaves(value: Any, path: tuple[Any, ...]) -> Iterator[tuple[Any, ...]]:
    """Places of the numbers below a value."""
    if isinstance(value, str):
        if path[-1] != "name":
            yield path
        return
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
        yield from leaves(inner, (*path, key))


def deceiver(name: str, rng: random.Random) -> dict[str, Any]:
    """A file of the catalogue with one or two numbers and some claims changed."""
    d = shipped(name)
    places = [x for key in NUMBERS if key in d for x in leaves(d[key], (key,))]
    for path in rng.sample(places, rng.choice((1, 1, 2))):
        inner = d
        for key in path[:-1]:
            inner = inner[key]
        text = inner[path[-1]]
        changes = (f"{text}+1/1{'0' * 50}", f"{text}+1/1{'0' * 50}", "0", f"-({text})", f"{text}+1")
        inner[path[-1]] = rng.choice(changes)
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


def without_a_certificate(d: dict[str, Any], folder: Path) -> list[str]:
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
        accepted, why = check.verdict(certificate)
        if accepted:
            decided.discard(certificate["statement"]["claim"])
        else:
            refused.append(why)
    return [*sorted(decided), *refused]


@pytest.mark.parametrize("seed", range(4))
def test_every_verdict_about_a_changed_file_has_a_certificate(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    d = deceiver(rng.choice(NAMES), rng)
    assert without_a_certificate(d, tmp_path) == []


@pytest.mark.slow
def test_every_verdict_about_many_changed_files_has_a_certificate(tmp_path: Path) -> None:
    for seed in range(100, 160):
        rng = random.Random(seed)
        name = rng.choice(NAMES)
        assert without_a_certificate(deceiver(name, rng), tmp_path) == [], (seed, name)


@pytest.mark.parametrize("name", ["rk4", "gsymplectic-n", "nystrom-rkn-4", "ars-4-4-3", "bdf-2"])
def test_orders_of_no_rows_are_a_claim_that_fails(name: str) -> None:
    d = shipped(name)
    d["claims"] = {"embedded-order": {}}
    d.pop("embedded", None)
    try:
        assert findings(d)["embedded-order"].verdict is Verdict.FAILS
    except DataError as error:
        assert "embedded" in str(error)


def test_a_simple_eigenvalue_one_has_no_growth_parameter() -> None:
    """Also of a method that is not consistent, where W B U N is not 1."""
    d = shipped("milne-simpson")
    d["beta"][1] = "-" + d["beta"][1]
    found = findings({**d, "claims": {"growth": ["1"], "consistent": False}})
    assert {str(x.verdict) for x in found.values()} == {"holds"}


def test_a_decimal_of_zeros_is_zero_for_the_checker_too(tmp_path: Path) -> None:
    d = shipped("gauss-2-seven-digits")
    d.pop("broken", None)
    d["A"], d["b"] = [["0", "0.0000000"], ["0.5000000", "0"]], ["0", "1"]
    d["claims"] = {"explicit": True}
    assert without_a_certificate({**d, "name": "deceiver"}, tmp_path) == []
