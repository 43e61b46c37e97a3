"""One table of claims: what is written from it is up to date, and nothing spells a key again."""

import ast
import re
from dataclasses import replace
from pathlib import Path

import pytest

import glmref
from glmref.catalogue.canonical import KEY_ORDER
from glmref.catalogue.claims import CLAIMS
from glmref.errors import DataError
from glmref.exact import Exact
from glmref.exact.expression import Text
from glmref.findings import Verdict
from glmref.judge.claims import concerns
from glmref.method import families
from glmref.prove.beside import BESIDE
from glmref.prove.facts import facts_of
from glmref.prove.kernel import KINDS, Kernel
from glmref.prove.verifier import verify
from tests.build import refused
from tests.sources import PACKAGE, SOURCES, nodes, text
from tools.method_schema import CONTRACT, SCHEMA, SECOND, second_schema, with_claims, with_table

RUN = "run `python -m tools.method_schema`"
#: Derivations write method files, key by key as they stand in them; the reader refuses unknown keys.
#: The judge imports nothing of glmref: it has a table of claims with the same keys.
APART = ("derive/", "judge/")
#: Modules with vocabularies of their own that share words: the rules of certificates, JSON of
#: `analyze`, and what the terminal shows of it.
SAME_WORDS = {
    *("prove/certificate.py", "prove/analysis.py"),
    *("cli/describing.py", "views/facts.py"),
}
#: Keys that are no words of another vocabulary: these can be looked for in the source.
OWN = frozenset(key for key in CLAIMS if "-" in key) | {"preconsistent"}
SPELLED = re.compile(rf"[\"']({'|'.join(OWN)})[\"']")


def test_the_schema_and_the_contract_are_those_of_the_table() -> None:
    for path, generated in ((SCHEMA, with_claims), (CONTRACT, with_table)):
        text = path.read_text(encoding="utf-8")
        assert generated(text) == text, f"{path.name}: {RUN}"
    assert SECOND.read_text(encoding="utf-8") == second_schema(SCHEMA.read_text("utf-8")), RUN


def test_a_changed_schema_or_contract_is_noticed() -> None:
    schema, contract = (path.read_text(encoding="utf-8") for path in (SCHEMA, CONTRACT))
    for old, new in (('"a-stable": {"type": "boolean"}', '"a-stable": {}'), ('"growth"', '"grow"')):
        assert with_claims(schema.replace(old, new)) == schema != schema.replace(old, new)
    first, second, *_ = (x for x in contract.splitlines(True) if x.startswith("| `order"))
    changed = contract.replace(first + second, second + first)
    assert with_table(changed) == contract != changed
    for other, said in (
        (first + first, "those twice"),
        ("", "'order'"),
        ("| `ordre` |\n", "'ordre'"),
    ):
        refused(ValueError, said, with_table, contract.replace(first, other))
    refused(ValueError, "found 0 times", with_table, contract.replace("<!-- table: claims -->", ""))


def test_keys_stand_in_canonical_order_and_once() -> None:
    first = KEY_ORDER.index("claims") + 1
    assert KEY_ORDER[first : first + len(CLAIMS)] == tuple(CLAIMS)
    assert len(set(KEY_ORDER)) == len(KEY_ORDER)


@pytest.mark.parametrize("key", CLAIMS)
def test_every_claim_is_decided_by_a_rule_of_its_own(key: str) -> None:
    spec = CLAIMS[key]
    # of others the judge decides what the writer proposes
    if spec.type in (int, dict) and key not in KINDS:
        rule = getattr(Kernel, "_" + key.replace("-", "_"))
        assert callable(rule) == (spec.type is not int)
    values = {int: 0, bool: True, list: [Text("7", Exact(7))], dict: {"hat": 1}}
    declared = values.get(spec.type, Text("7", Exact(7)))
    names = {"lmm": "bdf-2", "splitting": "stormer-verlet", "rosenbrock": "ros3p"}
    names = [name for kind, name in names.items() if concerns(key, kind)]
    if key in BESIDE:  # of classes whose files may have it
        names = ["rk4"]
    assert names
    for name in names:
        facts = facts_of(glmref.load(name))
        if spec.type in (int, dict):
            found = facts.kernel.find(key, declared)
            assert found.truth in (True, False), (name, found.reason)
        else:
            judged = facts.judge(key, declared)
            assert judged.verdict is not Verdict.OPEN, (name, judged.reason)


def test_a_claim_that_is_unknown_is_refused_by_name() -> None:
    method = replace(families.runge_kutta([["0"]], ["1"], name="euler"), claims={"ordre": 1})
    refused(DataError, "the claim 'ordre' of 'euler' is unknown; known are a-st", verify, method)


def spelled(path: Path) -> set[str]:
    """Keys of claims that stand in a module as strings."""
    if not SPELLED.search(text(path)):
        return set()
    return {x.value for x in nodes(path) if isinstance(x, ast.Constant) and x.value in OWN}


@pytest.mark.slow
def test_a_key_is_spelled_in_one_module() -> None:
    found = {
        path.relative_to(PACKAGE).as_posix(): keys for path in SOURCES if (keys := spelled(path))
    }
    assert found.pop("catalogue/claims.py") == found.pop("judge/claims.py") == OWN
    assert {x for x in found if not x.startswith(APART)} == SAME_WORDS
