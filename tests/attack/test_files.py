"""A small attack with hostile method files, and proof that the attack sees what it looks for."""

import json
import time
from dataclasses import replace

import pytest

from glmref.catalogue.lookup import document, load
from glmref.catalogue.reader import load_document
from glmref.cli import main as glmref
from glmref.errors import BudgetError, DataError
from glmref.exact import Exact
from glmref.exact.expression import parse, weigh
from glmref.findings import Verdict
from glmref.prove.analysis import analyze
from glmref.prove.verifier import budget_of, verify, verify_file
from glmref.system.budget import limited, spend
from tests.build import refused

from . import files

QUICK = 30
PRIMES = files.PRIMES


@pytest.mark.slow
def test_hostile_files_end_in_findings_or_a_sentence(monkeypatch):
    monkeypatch.setattr(files, "BUDGET", 0.1)
    tally = files.attack(QUICK, 7)
    assert not tally.violations, tally.text()
    assert sum(tally.outcomes.values()) == QUICK
    assert tally.outcomes["refused by load"] > 7
    assert any("holds" in x or "fails" in x for x in tally.outcomes)


def test_cases_follow_from_number_and_seed():
    for number in range(1, 20):
        assert files.case(number, 1) == files.case(number, 1)
    assert any(files.case(n, 1).data != files.case(n, 2).data for n in range(1, 5))


def test_additive_methods_of_many_parts_are_drawn():
    drawn = (files.case(n, 1) for n in range(1, 400))
    parts = {len(json.loads(x.data)["parts"]) for x in drawn if x.kinds == ("parts",)}
    assert len(parts) > 3 and max(parts) > 5


@pytest.mark.parametrize(
    ("claim", "declared", "name", "changes", "seen"),
    [
        ("order", 1, "rk4", {"b": ["1/6", "1/3", "1/3", "1/3"]}, True),
        ("order", 2, "euler", {}, True),
        ("order", 3, "heun-2", {}, True),
        ("order", 4, "rk4", {}, False),
        ("symplectic", True, "rk4", {}, True),
        ("a-stable", True, "bdf-3", {}, True),
        ("a-stable", True, "gauss-2", {}, False),
        ("zero-stable", False, "ab-2", {}, True),
        ("zero-stable", True, "ab-2", {}, False),
        ("zero-stable", True, "ab-2", {"alpha": ["-2", "1", "1"], "beta": ["0", "3", "0"]}, True),
        ("preconsistent", True, "gsymplectic-n", {"V": [["2", "0"], ["0", "0"]]}, True),
        ("embedded-order", {"embedded": 3}, "bogacki-shampine-3-2", {}, True),
        ("order", 3, "ros2", {}, True),
    ],
)
def test_a_false_verdict_is_seen(claim, declared, name, changes, seen):
    finding = next(f for f in verify(load(name)) if f.verdict is Verdict.HOLDS)
    false = replace(finding, claim=claim, declared=declared)
    kept = {x: y for x, y in document(name).items() if x not in ("starting", "G", "D")}
    method = load_document({**kept, **changes, "claims": {"order": 1}})
    assert bool(list(files.contradictions(method, [false]))) is seen
    assert not list(files.contradictions(method, [replace(false, verdict=Verdict.OPEN)]))


@pytest.mark.parametrize("raised", [KeyError("x"), files._TooLong(), DataError("two\nlines")])
def test_a_traceback_a_hang_and_two_lines_are_violations(monkeypatch, tmp_path, raised):
    def broken(*given, **options):
        raise raised

    monkeypatch.setattr(files, "verify_file", broken)
    text = json.dumps(document("rk4")).encode()
    _, (wrong,) = files.judged(files.Case(3, (), text), tmp_path / "x.json")
    assert type(raised).__name__ in wrong or "took more" in wrong or "two" in wrong


# --- what the attack found ------------------------------------------------------------------------


def saved(folder, doc, **changes):
    path = folder / "mine.json"
    path.write_text(json.dumps({**doc, **changes}), encoding="utf-8")
    return path


def dear(folder):
    """A composition of thirty times Gauss: a polynomial of degree 90 over a quadratic field."""
    return saved(folder, {"format": "glmref-method-1", "name": "dear", "class": "composition",
                          "base": "gauss-3", "gamma": ["1/30"] * 30, "source": document("rk4")["source"],
                          "claims": {"explicit": False, "symmetric": True, "a-stable": True}})  # fmt: skip


@pytest.mark.slow
def test_a_proof_that_exceeds_its_budget_is_open_with_the_reason(tmp_path):
    path = dear(tmp_path)
    started = time.thread_time()
    found = {f.claim: f for f in verify_file(path, budget=0.3)}
    assert time.thread_time() - started < 3
    assert found["a-stable"].verdict is Verdict.OPEN
    assert "the budget of 0.3 s of processor time is spent" in found["a-stable"].witness
    assert found["explicit"].verdict is Verdict.HOLDS
    undecided = analyze(load(path), budget=0.1).undecided
    assert "the budget of 0.1 s of processor time is spent" in undecided["a-stable"]


@pytest.mark.slow
def test_the_command_has_the_budget(tmp_path, capsys):
    path = dear(tmp_path)
    assert glmref(["verify", str(path), "--budget", "0.3"]) == 3
    assert "the budget of 0.3 s" in capsys.readouterr().out
    assert glmref(["verify", str(path), "--budget", "0"]) == 2
    assert budget_of(path) == 60 and budget_of(path, 5) == 5


def test_a_form_of_many_values_is_not_looked_for(tmp_path):
    r = 100  # the space of forms would take gigabytes
    one = [["1" if i == j else "0" for j in range(r)] for i in range(r)]
    path = saved(tmp_path, {"format": "glmref-method-1", "name": "wide", "class": "glm", "A": [["0"]],
                            "U": [["1"] + ["0"] * (r - 1)], "B": [["1"]] + [["0"]] * (r - 1),
                            "V": one, "source": document("rk4")["source"],
                            "claims": {"g-symplectic": True}})  # fmt: skip
    (finding,) = verify_file(path, budget=20)
    assert finding.verdict is Verdict.OPEN
    assert "10000 unknowns" in finding.witness


def test_a_shipped_file_has_no_budget():
    from glmref.catalogue.lookup import path_of

    assert budget_of(path_of("rk4")) is None and budget_of(path_of("rk4"), 5) == 5


def test_a_budget_within_a_budget_ends_with_the_smaller_one():
    with limited(None):
        spend()
    with limited(0.0), limited(1000.0), pytest.raises(BudgetError, match="budget of 0 s"):
        spend()
    with limited(1000.0):
        with limited(0.0), pytest.raises(BudgetError):
            spend()
        spend()
    spend()


@pytest.mark.parametrize(
    "text",
    [
        "*".join(f"(1+sqrt({p}))" for p in PRIMES),  # took minutes in one product
        "+".join(f"root({p},7)" for p in PRIMES[:4]),
        "exp(2*pi*i/29)+exp(2*pi*i/23)+exp(2*pi*i/19)",
    ],
)
def test_a_field_of_large_degree_is_refused_before_it_is_computed(text, tmp_path):
    started = time.thread_time()
    path = saved(tmp_path, {"A": [["0"]], "b": [text]})
    refused(DataError, "a field of degree up to", load, path)
    assert time.thread_time() - started < 2


def test_nested_quotients_are_refused_before_they_are_computed():
    known = {"k0": weigh("root(3,7)", {})}
    for n in range(1, 4):
        known[f"k{n}"] = weigh(f"1/(1+k{n - 1})", known)
    refused(DataError, "coefficients of up to", weigh, "1/(1+k3)", known)
    assert weigh("1/(1+sqrt(2))", {}).degree == 2
    assert weigh("sqrt(2)*sqrt(2)+sqrt(3)", {}).degree == 4


def test_what_flint_cannot_decide_is_said_in_a_short_sentence():
    x = parse("exp(2*pi*i/29)+exp(-2*pi*i/29)")
    assert len(x._brief()) < 130
    assert Exact(3)._brief() == "Exact(3)"


@pytest.mark.slow
def test_entries_that_cannot_be_decided_are_refused_with_the_name_of_the_file(tmp_path):
    entry = "sqrt(2+exp(2*pi*i/29))*sqrt(2+exp(-2*pi*i/29))"  # neither of roots of unity alone
    with pytest.raises(DataError, match=r"mine\.json: .*could not decide"):
        load(saved(tmp_path, {"A": [["0", "0"], [entry, "0"]], "b": [entry, "1"]}))


def test_reading_has_a_budget(tmp_path, monkeypatch):
    monkeypatch.setattr("glmref.catalogue.lookup.READING", 0.0)
    with pytest.raises(DataError, match="the entries take more than 0 s"):
        load(saved(tmp_path, {"A": [["0"]], "b": ["1"]}))
    load("rk4")


def test_a_bare_tableau_can_be_cited_as_a_file(tmp_path):
    from glmref.views.bibtex import file_entry

    assert "glmref-mine" in file_entry(saved(tmp_path, {"A": [["0"]], "b": ["1"]}))


def test_an_open_claim_says_why():
    for f in verify_file("pair-6-7-v-sign") or verify(load("pair-6-7-v-sign")):
        assert f.witness
    method = replace(load("pair-6-7-v-sign"), claims={"consistent": True})
    (finding,) = verify(method)
    assert finding.verdict is not Verdict.OPEN or finding.witness


@pytest.mark.parametrize("name", ["bogacki-shampine-3-2", "ros3p", "kennedy-carpenter-ark-3-2"])
def test_a_long_name_of_a_row_is_cut_in_a_sentence(name, tmp_path):
    doc = document(name)
    row = doc["embedded"][0]
    row["name"] = "x" * 5000
    row["b"] = [x[:-1] for x in row["b"]] if isinstance(row["b"][0], list) else row["b"][:-1]
    path = tmp_path / "x.json"
    path.write_text(json.dumps(doc))
    caught = refused(DataError, r"`embedded` 'xxx.*\.\.\. must have", load, path)
    assert len(caught) < 200
