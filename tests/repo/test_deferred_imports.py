"""An import inside a function has a reason that can be told.

The reasons: the subpackage loads on demand (``ON_DEMAND`` says why); the import brings in a package from
outside that the module does without until then, which is computed from the files; or a comment at
the line says it.
"""

import ast
import sys
from functools import cache

import pytest

from tests.sources import PACKAGE, SOURCES, nodes, text

ROOT = PACKAGE.parent

#: Subpackages that import inside functions as a rule, and why.
ON_DEMAND = {"cli": "a command loads what it runs, and help nothing"}

FILES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for path in SOURCES
}


def targets(module: str, node: ast.Import | ast.ImportFrom) -> set[str]:
    """Modules that an import statement loads, the packages on the way among them."""
    if isinstance(node, ast.Import):
        found = {alias.name for alias in node.names}
    else:
        here = module.split(".") + ["__init__"] * (FILES[module].name == "__init__.py")
        above = here[: len(here) - node.level] if node.level else []
        base = ".".join([*above, *([node.module] if node.module else [])])
        found = {
            full if (full := f"{base}.{alias.name}") in FILES else base for alias in node.names
        }
    parts = [name.split(".") for name in found]
    return {".".join(x[:n]) for x in parts for n in range(1, len(x) + 1)}


def statements(body: list[ast.stmt]) -> list[ast.Import | ast.ImportFrom]:
    """Imports among statements and their branches, but not those of functions."""
    found: list[ast.Import | ast.ImportFrom] = []
    for node in body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            found.append(node)
        elif isinstance(node, ast.If):
            hints = "TYPE_CHECKING" in ast.unparse(node.test)
            found += statements(node.orelse if hints else node.body + node.orelse)
        elif isinstance(node, ast.Try | ast.With | ast.ClassDef):
            found += statements(node.body)
    return found


@cache
def imports_of(module: str) -> list[ast.Import | ast.ImportFrom]:
    """Imports that run when a module is loaded."""
    tree = nodes(FILES[module])[0]
    assert isinstance(tree, ast.Module)
    return statements(tree.body)


@cache
def loads(module: str) -> frozenset[str]:
    """Packages from outside that are in memory once a module is."""
    seen, waiting = set(), {module}
    while waiting:
        seen |= waiting
        inside = waiting & set(FILES)
        waiting = {
            x for name in inside for node in imports_of(name) for x in targets(name, node)
        } - seen
    top = {name.partition(".")[0] for name in seen}
    return frozenset(top - set(sys.stdlib_module_names) - {"glmref", "__future__"})


def without_reason(module: str) -> list[str]:
    """Lines of a module at which a function imports, and nothing says why."""
    lines = text(FILES[module]).splitlines()
    functions = [x for x in nodes(FILES[module]) if isinstance(x, ast.FunctionDef)]
    found: set[int] = set()
    for function in functions:
        for node in ast.walk(function):
            if not isinstance(node, ast.Import | ast.ImportFrom):
                continue
            brought = frozenset().union(*(loads(x) for x in targets(module, node)))
            told = "#" in lines[node.lineno - 1] or lines[node.lineno - 2].lstrip().startswith("#")
            if not told and not brought - loads(module):
                found.add(node.lineno)
    return [f"{FILES[module].relative_to(ROOT)}:{line}" for line in sorted(found)]


@pytest.mark.slow
def test_an_import_inside_a_function_has_a_reason() -> None:
    found = {
        x: without_reason(x) for x in FILES if x.split(".")[1:2] not in [[y] for y in ON_DEMAND]
    }
    assert not {module: lines for module, lines in found.items() if lines}


@pytest.mark.slow
def test_what_a_module_loads_is_known() -> None:
    assert "numpy" in loads("glmref.engine.reference")
    assert "numpy" not in loads("glmref.theory.order")
    assert loads("glmref.errors") == frozenset()
