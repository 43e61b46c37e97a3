"""The mutants of ``campaigns.mutation``, and how they take the place of what is imported."""

from pathlib import Path
from typing import Any

import pytest

from campaigns.mutation.bench import Bench, forget
from campaigns.mutation.mutants import mutants
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
def test_what_is_kept_by_identity_is_forgotten(tmp_path, monkeypatch):
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))
    kept, given = ByIdentity(), object()
    assert kept((given,), None, lambda: 1) == kept((given,), None, lambda: 2) == 1
    forget()
    assert kept((given,), None, lambda: 2) == 2


@pytest.mark.slow
def test_a_mutant_is_run_by_the_tests_that_call_it_in_a_copy_of_the_tree(tmp_path):
    module, test = Path("glmref/derive/recognise.py"), "tests/unit/test_derive_search.py"
    bench = Bench(tmp_path, [test], [module], None)
    wrong = {(x.function, x.after): x for x in mutants(module.read_text(encoding="utf-8"))}
    outcome, first, seconds = bench.judged(module, wrong["root_text", "(inside == 1)"])
    assert (outcome, first.partition("::")[0], seconds > 0) == ("killed", test, True)
    # a limit that no number of these tests comes near
    assert bench.judged(module, wrong["square_free", "(divisor <= below)"])[0] == "survived"
    assert (bench.tree / module).read_text() == module.read_text()


def test_a_function_that_is_called_on_import_alone_is_tested_by_all_that_call_the_module():
    module = Path("glmref/theory/trees.py")
    bench: Any = Bench.__new__(Bench)
    row = {"seconds": 1.0, "failed": False, "calls": {str(module): ["density"]}}
    bench.calls = {"a": row, "b": {**row, "calls": {}}}
    for function in ("", "_make_single", "density"):
        assert bench.tests(module, function) == ["a"]
