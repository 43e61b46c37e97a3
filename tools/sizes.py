"""Report the longest modules and functions of the package: a place to look, not a limit.

``python -m tools.sizes`` prints the totals and the twenty longest of each.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def main() -> None:
    """Print lines of the package, its longest modules and its longest functions."""
    modules, functions = [], []
    for path in sorted((ROOT / "glmref").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(ROOT).as_posix()
        modules.append((len(text.splitlines()), name))
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                length = (node.end_lineno or 0) - node.lineno + 1
                functions.append((length, f"{name}: {node.name}"))
    lines = [f"{sum(n for n, _ in modules)} lines in {len(modules)} modules"]
    for title, rows in (("modules", modules), ("functions", functions)):
        lines += [f"longest {title}:", *(f"{n:6} {name}" for n, name in sorted(rows)[:-21:-1])]
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
