"""Sources in many languages, the tables that are read in them, and what is said of each.

The cases are data, ``tests/sources/*.toml``: a case has its text, what is said of its tables, and
twins with a defect, of which something else is said.
"""

import tomllib
from pathlib import Path
from typing import Any

import pytest

from glmref.audit.lexer import LANGUAGES
from glmref.audit.readers import declared_orders, read
from glmref.audit.recognising import tables
from glmref.audit.sources import audit
from glmref.audit.table_verdicts import judge
from tests.build import SOURCES, source

Case = dict[str, Any]


def _listed(name: str, key: str) -> list[Case]:
    return tomllib.loads((SOURCES / f"{name}.toml").read_text(encoding="utf-8"))[key]


def _audited(folder: Path, case: Case, text: str) -> list[Case]:
    """Return the records of a folder with one file, and perhaps another beside it."""
    folder.mkdir(parents=True)
    for name, other in (case["beside"],) if "beside" in case else ():
        (folder / name).write_text(other, "utf-8")
    (folder / case["path"]).write_text(text, "utf-8")
    return list(audit(folder, compare=case.get("compare", False)))


def _records(case: Case, text: str, folder: Path) -> list[Case]:
    if "path" in case:
        return _audited(folder, case, text)
    orders = declared_orders(text)
    if "format" in case:
        return [judge(x) for x in read(text, case["format"], orders)]
    about, fixed = case.get("given", True), case.get("fixed", False)
    language = LANGUAGES[case["language"]]
    return [judge(x) for x in tables(text, language, about=about, declared=orders, fixed=fixed)]


def _matches(record: Case, expected: Case) -> None:
    """A remark has these words in it, an entry is corrected, the other keys are those expected."""
    for key, value in expected.items():
        if key == "remark":
            assert value in " ".join(record["remarks"])
        elif key == "entry":
            corrections = [
                f"{x['entry']} is {x['is']}, should be {x['should be']}"
                + (f" (line {x['line']}: {x['text']})" if "(line" in value else "")
                for x in record["correction"]
            ]
            assert value in corrections
        elif key == "corrected":
            assert value in [x["entry"] for x in record["correction"]]
        else:
            assert (value == "none" and record[key] is None) or record[key] == value


def _said(records: list[Case], expected: Case) -> None:
    if "states" in expected:
        assert [x["status"] for x in records] == expected["states"].split()
    if "accused" in expected:
        accused = [x for x in records if x["status"] in ("wrong", "question")]
        assert bool(accused) is expected["accused"], accused
    found = expected.get("tables", [])
    if isinstance(found, dict):
        by_name = {x["name"]: x for x in records}
        for name, one in found.items():
            _matches(by_name[name], one)
    elif "tables" in expected:
        for record, one in zip(records, found, strict=True):
            _matches(record, one)


def _texts(case: Case) -> list[tuple[str, Case]]:
    """Return each text of a case with what is said of it."""
    text = case["text"] if "text" in case else source(case["file"])
    if "rows" in case:
        filled = []
        for *values, states in case["rows"]:
            one = text
            for k, value in enumerate(values, 1):
                one = one.replace(f"@{k}", value)
            filled.append((one, {"states": states}))
        return filled
    made = [(text, case)]
    for twin in case.get("twins", []):
        other = text
        for old, new in zip(twin["change"][::2], twin["change"][1::2], strict=True):
            assert old in other, old
            other = other.replace(old, new)
        made.append((other, twin))
    return made


CASES = [
    pytest.param(
        text, said, case, id=f"{name}: {case.get('about') or case['language']}, {k}",
        marks=[pytest.mark.slow] if case.get("slow") or said.get("slow") else [],
    )
    for name in ("tables", "flows", "formats", "steps", "languages")
    for case in _listed(name, "case")
    for k, (text, said) in enumerate(_texts(case))
]  # fmt: skip


@pytest.mark.parametrize(("text", "said", "case"), CASES)
def test_what_is_read_in_a_source_is_judged(text, said, case, tmp_path):
    _said(_records(case, text, tmp_path / "in"), said)


#: Cases whose corrections are found soon.
QUICK = {
    "sum of slopes",
    "arms of a match",
    "Java Shu-Osher",
    "JavaScript splitting",
    "Go Adams",
    "order elsewhere",
    "one stage",
}


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("case", "defect"),
    [
        pytest.param(case, defect, id=name, marks=[] if name in QUICK else [pytest.mark.slow])
        for case in _listed("defects", "source")
        for name, *defect in case["defects"]
    ],
)
def test_a_defect_is_found_and_its_right_twin_is_not_accused(case, defect, tmp_path):
    old, new, said = defect
    text = case["text"] if "text" in case else source(case["file"])
    right = _audited(tmp_path / "right", case, text)
    read = [x for x in right if "multistep" not in str(x["remarks"])]
    assert right and {x["status"] for x in read} <= {"right", "digits", "found"}, right
    _said(right, {"accused": False})
    assert old in text
    found = _audited(tmp_path / "wrong", case, text.replace(old, new, 1))
    accused = [x for x in found if x["status"] in ("wrong", "question")]
    assert said in str(accused), found


@pytest.mark.slow
@pytest.mark.parametrize("case", _listed("defects", "step"), ids=lambda x: x["path"])
def test_a_step_in_its_arithmetic_is_read(case: Case, tmp_path: Path) -> None:
    """A wrong factor in a stage or in the weights is asked for, with the line; the twin is right."""
    (right,) = _audited(tmp_path / "right", case, case["text"])
    assert (right["status"], right["declared"]) == ("right", 4), right
    for key, entry in (("stage", "a[3][2]"), ("weight", "b[3]")):
        old, new = case[key]
        assert old in case["text"]
        changed = case["text"].replace(old, new, 1)
        (record,) = _audited(tmp_path / key, case, changed)
        assert (record["status"], record["declared"]) == ("question", 4), record
        if case["path"] != "r.cpp":
            (named,) = record["correction"]
            lines = [n for n, x in enumerate(changed.splitlines(), 1) if new in x]
            assert named["entry"] == entry and named["line"] in lines
