"""No file above 400 lines and no function above 60: what is longer is two things."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILE, FUNCTION = 400, 60


def too_long(text: str, name: str) -> list[str]:
    """What of a module is longer than it may be, one sentence each."""
    lines = len(text.splitlines())
    found = [f"{name}: {lines} lines"] if lines > FILE else []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            length = (node.end_lineno or 0) - node.lineno + 1
            if length > FUNCTION:
                found.append(f"{name}: {node.name} has {length} lines")
    return found


@pytest.mark.parametrize("folder", ["glmref", "benchmarks"])
def test_nothing_is_too_long(folder):
    files = sorted((ROOT / folder).rglob("*.py"))
    assert files
    found = [
        line
        for path in files
        for line in too_long(path.read_text(encoding="utf-8"), str(path.relative_to(ROOT)))
    ]
    assert found == []


def test_the_check_sees_one_line_too_many():
    function = "def f():\n" + "    pass\n" * (FUNCTION - 1)
    assert too_long(function, "m") == []
    assert too_long(function + "    pass\n", "m") == ["m: f has 61 lines"]
    assert too_long("x = 1\n" * FILE, "m") == []
    assert too_long("x = 1\n" * (FILE + 1), "m") == ["m: 401 lines"]
