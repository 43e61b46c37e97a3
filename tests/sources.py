"""The source of the package as syntax trees, each file parsed and walked once in a process."""

import ast
import gc
from functools import cache
from pathlib import Path

import glmref

PACKAGE = Path(glmref.__file__).parent
SOURCES = tuple(sorted(PACKAGE.rglob("*.py")))


@cache
def text(path: Path) -> str:
    """Return the text of a file."""
    return path.read_text(encoding="utf-8")


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """Return all nodes of the tree of a file, the module first."""
    gc.disable()  # a million nodes that stay would be gone through again and again
    try:
        return tuple(ast.walk(ast.parse(text(path))))
    finally:
        gc.enable()
