"""The mutants of ``campaigns.mutation``, and how they take the place of what is imported."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import pytest

from campaigns.mutation.inprocess import Bench, NothingChanged, _every, _forget, exchange
from campaigns.mutation.mutants import Mutant, mutants
from glmref.engine.kept import ByIdentity

SOURCE = '''"""A module."""
from functools import lru_cache

LIMIT = 3


def wrapped(function):
    return lambda *given: function(*given)


class Box:
    @property
    def size(self) -> int:
        return 2 * LIMIT


@wrapped
def below(x: int, most: int = 7) -> bool:
    """Say whether."""
    return x < most and not x == 5
'''


@pytest.fixture
def module(tmp_path, monkeypatch):
    path = tmp_path / "mutated.py"
    path.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location("mutated", path)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    monkeypatch.setitem(sys.modules, "mutated", made)
    _every.cache_clear()
    return made


def test_each_mutant_changes_one_place_and_knows_its_function():
    found = {(x.before, x.after): x for x in mutants(SOURCE)}
    assert found["2 * LIMIT", "(2 + LIMIT)"].function == "Box.size"
    assert found["x < most", "(x <= most)"].function == "below"
    assert found["3", "(4)"].function == found["7", "(8)"].function == ""
    assert not any("module" in before or "int" in before for before, _ in found)
    assert all(x.source != SOURCE for x in found.values())
    ones = [x for x in mutants("y = 1 + 1\n") if x.before == "1"]
    assert sorted((x.column, x.source) for x in ones) == [
        (4, "y = (2) + 1\n"),
        (8, "y = 1 + (2)\n"),
    ]


@pytest.mark.slow
def test_a_mutant_is_seen_wherever_its_function_is_bound(module):
    kept, box = module.below, module.Box()
    wrong = next(x for x in mutants(SOURCE) if x.after == "(x <= most)")
    assert not any(kept(7) for _ in range(100))  # code that has run is specialized
    assert exchange(module, wrong.source)
    assert kept(7) and not kept(8)
    wrong = next(x for x in mutants(SOURCE) if x.after == "(4)")
    assert not exchange(module, wrong.source)
    assert box.size == 8


@pytest.mark.slow
def test_a_function_that_pytest_has_rewritten_is_exchanged_too(module):
    rewritten = SOURCE.replace("    return x < most", "    assert most; return x < most")
    exec(compile(rewritten, module.__file__, "exec"), module.__dict__)
    assert not module.below(7)
    wrong = next(x for x in mutants(SOURCE) if x.after == "(x <= most)")
    assert exchange(module, wrong.source)
    assert module.below(7) and not module.below(8)


@pytest.mark.slow
def test_a_mutant_that_changes_no_function_is_no_survivor(module):
    del module.below
    wrong = next(x for x in mutants(SOURCE) if x.after == "(x <= most)")
    with pytest.raises(NothingChanged):
        exchange(module, wrong.source)


@pytest.mark.slow
def test_what_is_kept_by_identity_is_forgotten(tmp_path, monkeypatch):
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))
    kept, given = ByIdentity(), object()
    _every.cache_clear()
    assert kept((given,), None, lambda: 1) == kept((given,), None, lambda: 2) == 1
    _forget()
    assert kept((given,), None, lambda: 2) == 2


def test_a_function_that_is_called_on_import_alone_is_tested_in_a_copy():
    module = Path("glmref/theory/trees.py")
    bench: Any = Bench.__new__(Bench)
    row = {"seconds": 1.0, "failed": False, "calls": {str(module): ["density"]}}
    bench.items, bench.calls = {"a": None, "b": None}, {"a": row, "b": {**row, "calls": {}}}
    wrong = Mutant(1, 0, "statement", "", "pass", "", "_make_single")
    assert bench.judged(module, wrong) == ("stale", "", 0.0)
    for function in ("", "_make_single", "density"):
        assert bench.tests(module, function) == ["a"]
