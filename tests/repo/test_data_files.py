"""The data keep their contract (data/README.md): layout, schema, hashes, names, sources, shares.

Nothing here recomputes a claim: ``glmref verify`` does. Only the standard library and the layout
function are used, so that the checks see the files as any reader does.
"""

import json
import re
from pathlib import Path

import pytest

from glmref.catalogue.canonical import canonical, checksums, datapackage

DATA = Path(__file__).resolve().parents[2] / "data"
METHODS = sorted((DATA / "methods").rglob("*.json"))
BROKEN = sorted((DATA / "broken").rglob("*.json"))
FILES = METHODS + BROKEN
REFRESH = "run `python -m glmref.catalogue.canonical data`"

FOLDERS = {
    "rk": {"rk", "composition", "sweep"},  # one value: a composition in sweep form
    "lmm": {"lmm", "one-leg"},
    "glm": {"glm", "sweep"},
    "partitioned": {"splitting", "partitioned-rk", "partitioned", "pair-sweep"},
    "additive": {"additive"},
    "nystrom": {"nystrom"},
    "rosenbrock": {"rosenbrock"},
}
FUNCTIONS = {"sqrt", "root", "exp", "pi", "i"}
COEFFICIENTS = {
    *(
        "A", "U", "B", "V", "X", "b", "alpha", "beta", "a", "gamma", "A_hat", "b_hat", "q", "p",
        "parts",
    ),
    *("c", "v", "w", "V_hat", "G", "D", "D_P", "D_Q", "constants", "unknowns"),
}  # fmt: skip


def no_float(text):
    raise AssertionError(f"the number {text} is a float: write a string")


def read(path):
    return json.loads(path.read_text(encoding="utf-8"), parse_float=no_float)


def names(paths):
    return [str(path.relative_to(DATA)) for path in paths]


def leaves(value):
    """Every plain value below a value."""
    if isinstance(value, dict | list):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from leaves(inner)
    else:
        yield value


def faults(document, path):
    """What a file does against the contract, one word for each."""
    found = set()
    if document["name"] != path.stem:
        found.add("name")
    source = document.get("source", {})
    if not all(source.get(key) for key in ("citation", "where", "status")):
        found.add("source")
    if source.get("status") == "corrected" and not source.get("errata"):
        found.add("errata")
    if not document.get("claims"):
        found.add("claims")
    found |= {
        key
        for key in COEFFICIENTS & document.keys()
        if not all(isinstance(x, str) for x in leaves(document[key]))
    }
    claims = {k: v for k, v in document.get("claims", {}).items() if k != "order-to-digits"}
    texts = [x for x in leaves(claims) if isinstance(x, str)]  # a size such as 2.7e-85 is none
    if any(set(re.findall(r"[A-Za-z_]\w*", x)) - FUNCTIONS for x in texts):
        found.add("constant")  # a claim stands by itself
    start = document.get("starting")
    if start and document["claims"].get("starting-order") != start["order"]:
        found.add("starting-order")
    return found


@pytest.mark.parametrize("path", FILES, ids=names(FILES))
def test_a_method_file_keeps_the_contract(path):
    document = read(path)
    assert faults(document, path) == set()
    assert path.read_text(encoding="utf-8") == canonical(document), f"{path.name}: {REFRESH}"


def test_the_contract_check_notices_each_fault():
    path = DATA / "methods" / "glm" / "gsymplectic-n.json"
    good = read(path)
    start = {**good["starting"], "order": 4}
    wrong = {
        "name": {**good, "name": "gsymplectic-m"},
        "source": {**good, "source": {**good["source"], "where": ""}},
        "errata": {**good, "source": {"citation": "x", "where": "y", "status": "corrected"}},
        "claims": {**good, "claims": {}, "starting": None},
        "constant": {**good, "claims": {**good["claims"], "growth": ["w"]}},
        "B": {**good, "B": [["1/2", 1], ["1/2", "-1/2"]]},
        "starting-order": {**good, "starting": start},
    }
    for fault, document in wrong.items():
        assert faults(document, path) == {fault}
    with pytest.raises(AssertionError, match=r"0\.5 is a float"):
        json.loads('{"b": [0.5]}', parse_float=no_float)


def test_every_method_lies_in_the_folder_of_its_class():
    misplaced = [x for x in METHODS if read(x)["class"] not in FOLDERS[x.parent.name]]
    assert misplaced == []
    assert {path.parent for path in BROKEN} == {DATA / "broken"}


def test_names_are_unique():
    stems = [path.stem for path in FILES]
    assert sorted(set(stems)) == sorted(stems)


def test_there_are_at_least_70_methods_and_a_quarter_of_the_files_is_broken():
    assert len(METHODS) >= 70
    assert 4 * len(BROKEN) >= len(FILES)


def test_a_broken_file_names_a_claim_of_its_own_and_only_broken_files_do():
    for path in FILES:
        document = read(path)
        assert ("broken" in document) == (path in BROKEN), path.name
        if path in BROKEN:
            assert document["broken"]["claim"] in document["claims"], path.name
            assert document["broken"]["why"].endswith("."), path.name


def test_the_contract_lists_every_flag_and_every_claim_in_use():
    contract = (DATA / "README.md").read_text(encoding="utf-8")
    flags = {read(path)["broken"]["flag"] for path in BROKEN}
    listed = contract.partition("| `flag` | defect |")[2].partition("\n## ")[0]
    assert flags == set(re.findall(r"\b[A-Z][A-Za-z]+(?=[,| ])", listed)) - {"A", "V"}
    claims = {claim for path in FILES for claim in read(path)["claims"]}
    table = contract.partition("### Claims")[2].partition("###")[0]
    assert claims == set(re.findall(r"^\| `([a-z-]+)` \|", table, re.MULTILINE))


def test_dois_belong_to_one_citation_each():
    citations: dict[str, set[str]] = {}
    for path in FILES:
        source = read(path)["source"]
        if "doi" in source:
            assert f"doi = {{{source['doi']}}}" in source.get("bibtex", ""), path.name
            citations.setdefault(source["doi"], set()).add(source["citation"])
    assert {doi: found for doi, found in citations.items() if len(found) > 1} == {}


def test_sha256sums_and_datapackage_are_up_to_date():
    assert (DATA / "SHA256SUMS").read_text(encoding="utf-8") == checksums(DATA), REFRESH
    package = read(DATA / "datapackage.json")
    assert package == datapackage(DATA, package), REFRESH


@pytest.fixture(scope="module")
def schema():
    validators = pytest.importorskip("jsonschema").Draft202012Validator
    document = read(DATA / "schema" / "glmref-method-1.schema.json")
    validators.check_schema(document)
    return validators(document)


@pytest.mark.slow
def test_every_method_file_is_valid_against_the_schema_of_its_format(schema):
    second = type(schema)(read(DATA / "schema" / "glmref-method-2.schema.json"))
    second.check_schema(second.schema)
    schemas = {"glmref-method-1": schema, "glmref-method-2": second}
    documents = {path.name: read(path) for path in FILES}
    errors = {
        name: [e.message for e in schemas[doc["format"]].iter_errors(doc)]
        for name, doc in documents.items()
    }
    assert {name: found for name, found in errors.items() if found} == {}
    moved = [{**x, "format": "glmref-method-2"} for x in documents.values()]
    assert all(map(second.is_valid, moved)), "what is stated in format 1 is so in format 2"


@pytest.mark.parametrize(
    "change",
    [
        {"A": [[0.25]]},
        {"unknown": 1},
        {"claims": {}},
        {"claims": {"oder": 4}},
        {"class": "erk"},
        {"name": "RK4"},
        {"alpha": ["1"]},
        {"b": ["os.system('x')"]},
        {"source": {"citation": "x", "where": "y", "status": "copied"}},
        {"source": {"citation": "x", "where": "y", "status": "derived", "doi": "doi:10.1/x"}},
        {"constants": {"sqrt": "1"}},
        {"broken": {"claim": "order", "flag": "sign", "why": "x"}},
    ],
)
def test_the_schema_refuses_what_the_contract_forbids(schema, change):
    document = {**read(DATA / "methods" / "rk" / "rk4.json")}
    assert schema.is_valid(document)
    assert not schema.is_valid({**document, **change})


@pytest.mark.parametrize("key", ["format", "title", "A", "claims", "source"])
def test_the_schema_refuses_a_missing_key(schema, key):
    document = read(DATA / "methods" / "rk" / "rk4.json")
    del document[key]
    assert not schema.is_valid(document)


AUDITS = sorted((DATA / "audits").glob("*.json"))


@pytest.mark.parametrize("path", AUDITS, ids=lambda path: path.stem)
def test_an_audit_counts_its_tables_and_names_its_commit(path):
    document = json.loads(path.read_text(encoding="utf-8"))
    assert document["format"] == "glmref-audit-1" and document["name"] == path.stem
    assert re.fullmatch(r"[0-9a-f]{40}", document["source"]["commit"])
    assert document["source"]["licence"] and document["source"]["date"]
    statuses = [table["status"] for table in document["tables"]]
    assert document["counts"] == {x: statuses.count(x) for x in sorted(set(statuses))}
    assert all(
        table["name"] and table["line"] > 0 and table["path"] for table in document["tables"]
    )
    for table in document["tables"]:
        said = table.get("remarks") or table.get("correction") or table.get("nearest")
        assert said or table["status"] not in ("wrong", "question", "unread")
