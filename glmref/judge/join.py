"""Join the modules of the judge to one file that needs nothing but Python.

``python -m glmref.judge.join FILE`` writes it. The modules import each other by name only
(``from .linalg import dot``) and define every name once, so that joining is putting them one
after another in the order of their imports.
"""

import argparse
import ast
import pathlib

FOLDER = pathlib.Path(__file__).parent
HEADER = '''"""The judge of glmref in one file: check certificates of format glmref-certificate-1.

``python FILE CERTIFICATE...`` says yes or no and why for every certificate. It needs Python 3.11
or later and nothing else. Written by ``python -m glmref.judge.join`` from the modules of
``glmref/judge``, where it is easier to read. Exit code: 0 when all certificates are accepted, 1
when one is refused, 2 when a file cannot be read.
"""
'''


class Source:
    """A module of the judge: its title, what it imports, and the text below the imports.

    Parameters
    ----------
    name : str
        Name of the module.
    text : str
        Its source.

    Raises
    ------
    ValueError
        If the module imports in another way than by name.
    """

    def __init__(self, name: str, text: str) -> None:
        tree = ast.parse(text)
        self.name, self.title = name, (ast.get_docstring(tree) or "").partition("\n")[0]
        self.below: set[str] = set()
        self.imports: set[str] = set()
        self.names: set[str] = set()
        last = tree.body[0].end_lineno or 0
        for node in tree.body:
            if isinstance(node, ast.Import | ast.ImportFrom):
                if any(alias.asname for alias in node.names) or getattr(node, "level", 0) > 1:
                    raise ValueError(f"{name}, line {node.lineno}: join needs imports by name")
                if getattr(node, "level", 0):
                    self.below.add(str(getattr(node, "module", None)))
                else:
                    self.imports |= set(map(ast.unparse, single(node)))
                last = node.end_lineno or 0
            elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
                last = node.end_lineno or 0  # annotations: all names are there in the one file
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                self.names.add(node.name)
            elif isinstance(node, ast.Assign | ast.AnnAssign):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                self.names |= {x.id for x in targets if isinstance(x, ast.Name)}
        self.text = "\n".join(text.splitlines()[last:]).strip("\n")


def single(node: ast.Import | ast.ImportFrom) -> list[ast.stmt]:
    """Return an import statement for each of its names."""
    if isinstance(node, ast.Import):
        return [ast.Import([alias]) for alias in node.names]
    return [ast.ImportFrom(node.module, [alias], 0) for alias in node.names]


def ordered(sources: dict[str, Source]) -> list[Source]:
    """Return the sources so that each stands after those it imports.

    Raises
    ------
    ValueError
        If the imports form a cycle, or a name is defined twice, or defined and imported.
    """
    found: list[Source] = []
    outside = {line.split()[-1] for source in sources.values() for line in source.imports}
    names = dict.fromkeys(outside, "an import")
    left = dict(sources)
    while left:
        ready = sorted(x for x, source in left.items() if not source.below & set(left))
        if not ready:
            raise ValueError(f"the modules {', '.join(left)} import each other in a cycle")
        for name in ready:
            source = left.pop(name)
            for twice in source.names & set(names):
                raise ValueError(f"{twice} is defined in {names[twice]} and in {name}")
            names |= dict.fromkeys(source.names, name)
            found.append(source)
    return found


def joined() -> str:
    """Return the text of the one file."""
    sources = {
        path.stem: Source(path.stem, path.read_text(encoding="utf-8"))
        for path in FOLDER.glob("*.py")
        if path.stem not in ("__init__", "join")
    }
    found = ordered(sources)
    imports = set().union(*(source.imports for source in found))
    future = {x for x in imports if x.startswith("from __future__")}
    parts = [HEADER, *sorted(future), *sorted(imports - future)]
    for source in found:
        parts += ["", "", f"# {'-' * 16} {source.name}: {source.title}", "", source.text]
    return "\n".join(parts) + "\n"


def main() -> None:
    """Write the one file."""
    parser = argparse.ArgumentParser(prog="python -m glmref.judge.join", description=main.__doc__)
    parser.add_argument("file", metavar="FILE", help="path of the file to write")
    pathlib.Path(parser.parse_args().file).write_text(joined(), encoding="utf-8")


if __name__ == "__main__":
    main()
