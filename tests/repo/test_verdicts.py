"""Only the judge's answers make verdicts: checked over the source of the whole package."""

import ast
from pathlib import Path

import pytest

from glmref.findings import Proof, Verdict
from glmref.prove.kernel import Found
from glmref.prove.verdicts import Judgement, judged
from tests import sources
from tests.sources import PACKAGE, nodes, text

#: Findings of the conformance suite are measurements of programs, with the proof "measured".
SOURCES = tuple(p for p in sources.SOURCES if p.parent.name != "conformance")
#: What asks the judge, and the tables that colour what is read.
READERS = {"prove/verdicts.py", "views/tables.py"}


FOUND = Found(True, Proof.EXACT, True, 0.0, "")


def _made(tree: ast.AST) -> list[int]:
    """Lines on which HOLDS or FAILS is a value that is handed on, not compared."""
    parents = {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}
    found = []
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Attribute) and node.attr in ("HOLDS", "FAILS")):
            continue
        if not (isinstance(node.value, ast.Name) and node.value.id == "Verdict"):
            continue
        above = parents[node]
        if isinstance(above, ast.Compare):
            continue
        if isinstance(above, ast.Dict) and node in above.keys:  # a table of words for verdicts
            continue
        found.append(node.lineno)
    return found


def calls(path: Path, name: str) -> list[ast.Call]:
    """Calls of a function by its name alone."""
    if f"{name}(" not in text(path):
        return []
    return [x for x in nodes(path) if isinstance(x, ast.Call) and getattr(x.func, "id", "") == name]


def test_no_other_module_makes_a_verdict() -> None:
    for path in SOURCES:
        name = str(path.relative_to(PACKAGE))
        if name not in READERS and ("HOLDS" in text(path) or "FAILS" in text(path)):
            tree = nodes(path)[0]
            assert not _made(tree), f"{name} makes a verdict on lines {_made(tree)}"
        assert not calls(path, "Judgement") or name == "prove/verdicts.py", name
        assert not calls(path, "Implied") or name == "prove/implications.py", name


def test_findings_are_made_from_judgements_only() -> None:
    for path in SOURCES:
        for node in calls(path, "Finding"):
            verdict = next(k.value for k in node.keywords if k.arg == "verdict")
            # what was not decided, because a budget was spent, may be said anywhere
            said = ast.unparse(verdict)
            of_judgement = said == "self.verdict" and path == PACKAGE / "prove" / "verdicts.py"
            assert of_judgement or said in ("row.verdict", "Verdict.OPEN"), path


def test_findings_are_read_back_where_they_are_kept_or_sent_only() -> None:
    readers = [
        str(path.relative_to(PACKAGE))
        for path in SOURCES
        if "from_json" in text(path)
        for node in nodes(path)
        if isinstance(node, ast.Attribute) and node.attr == "from_json"
    ]
    # by the last two from the process that decided them
    assert set(readers) == {"prove/verdict_cache.py", "cli/parallel.py", "cli/auditing.py"}


def test_the_constructors_are_sealed() -> None:
    with pytest.raises(TypeError, match="judge"):
        Judgement(**vars(FOUND), verdict=Verdict.HOLDS, certificate="", seal=object())


def test_nothing_holds_without_a_certificate_that_the_judge_accepts() -> None:
    without = judged(FOUND, ["it is not written"])
    assert (without.verdict, without.certificate) == (Verdict.OPEN, "it is not written")
    assert without.reason == "no certificate is written: it is not written"
    refused = judged(FOUND, [{"format": "glmref-certificate-1"}])
    assert refused.verdict is Verdict.OPEN
    assert refused.reason.startswith("the judge refuses the certificate: ")


def test_the_kernel_imports_no_finder() -> None:
    allowed = {
        "", "errors", "findings", "catalogue.claims", "judge.grammar", "judge.refusals", "exact", "exact.judging", "exact.expression", "exact.linalg",
        "method", "method.preconsistency", "method.stage_order", "theory.reduction", "system.budget", "theory", "theory.polynomials", "theory.coefficients", "theory.residues",
        "theory.stability", "theory.order", "theory.series", "theory.starting_series", "theory.trees", "method.component", "implications", "kernel", "ranges", "find_rows", "digits", "find_modified", "theory.backward", "theory.underlying", "theory.second_order", "theory.spectrum", "theory.symmetry", "theory.symplectic",
    }  # fmt: skip
    rules = ("find_rows", "digits", "find_modified")
    for name in ("kernel", *rules, "ranges"):
        for node in nodes(PACKAGE / "prove" / f"{name}.py"):
            if isinstance(node, ast.ImportFrom) and node.level:
                assert (node.module or "") in allowed, (name, node.module)
            if isinstance(node, ast.ImportFrom) and node.module == "theory":
                assert {x.name for x in node.names} <= {"polynomials"}
