"""What may import what: one table of layers; no import cycle among modules; the two witnesses apart.

A *subpackage* is a package directly inside ``glmref``. ``LAYERS`` lists them from the ground up. A subpackage may
import subpackages of the rows above its own, and subpackages to its left in its own row.
"""

import ast
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import glmref
from glmref.prove.verdict_cache import SUBPACKAGES
from tests.sources import PACKAGE, SOURCES, nodes, text

LAYERS = [
    "judge errors findings system", "exact method", "catalogue theory compute", "prove derive",
    "problems engine", "measure views", "scenes audit exchange conformance", "report cli",
    "__main__ __init__",
]  # fmt: skip
HEIGHT = {
    subpackage: (row, column)
    for row, line in enumerate(LAYERS)
    for column, subpackage in enumerate(line.split())
}

#: Subpackages that ask the package for its version, the one import that points up.
VERSION = {"compute", "views", "scenes", "exchange", "report", "cli"}

#: Packages that are not part of Python, and the subpackages that import them.
OUTSIDE: dict[str, str] = {
    "assimulo": "conformance",
    "click": "cli",
    "diffrax": "conformance",
    "extensisq": "conformance",
    "flint": "conformance exact",
    "heyoka": "conformance",
    "jax": "conformance",
    "jinja2": "exchange report",
    "jitcode": "conformance",
    "juliacall": "conformance",
    "llvmlite": "engine",
    "markupsafe": "report",
    "mpmath": "conformance derive engine exact exchange problems",
    "nodepy": "conformance",
    "numba": "engine",
    "numpy": "conformance derive engine measure method problems scenes views",
    "pytest": "conformance",
    "rebound": "conformance",
    "scipy": "conformance",
    "symengine": "conformance",
    "torch": "conformance",
    "torchdiffeq": "conformance",
    "tqdm": "cli",
}

#: What may not be reached from where, at any distance: the two witnesses share nothing.
APART = [
    ("theory", "measure"),
    ("theory", "engine"),
    ("theory", "problems"),
    ("measure", "theory"),
    ("problems", "theory"),
    ("problems", "measure"),
    ("problems", "engine"),
]


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """The imports, conditions and calls of a module."""
    kinds = (ast.Import, ast.ImportFrom, ast.If, ast.Call)
    return tuple(node for node in nodes(path) if isinstance(node, kinds))


def subpackage_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path: Path) -> Iterator[tuple[str, ...]]:
    """Every module a file imports, anywhere in it, as a dotted path in parts."""
    package = ("glmref", *path.relative_to(PACKAGE).parts[:-1])
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = (*base, *(node.module.split(".") if node.module else ()))
            if module == ("glmref",):
                yield from ((*module, alias.name) for alias in node.names)
            else:
                yield module


@cache
def uses() -> tuple[dict[str, set[str]], dict[str, set[str]]]:
    """Subpackages each subpackage imports, and subpackages that import each outside package."""
    inside: dict[str, set[str]] = {}
    outside: dict[str, set[str]] = {}
    subpackages = {subpackage_of(path) for path in SOURCES}
    for path in SOURCES:
        subpackage = subpackage_of(path)
        inside.setdefault(subpackage, set())
        for module in imported(path):
            if module[0] == "glmref":
                target = module[1] if len(module) > 1 and module[1] in subpackages else "__init__"
                if target != subpackage:
                    inside[subpackage].add(target)
            elif module[0] not in sys.stdlib_module_names:
                outside.setdefault(module[0], set()).add(subpackage)
    return inside, outside


def inside() -> dict[str, set[str]]:
    return uses()[0]


@pytest.mark.slow
def test_every_room_stands_in_the_table_and_no_other() -> None:
    assert set(HEIGHT) == set(inside())
    assert len(LAYERS) <= 9
    packages = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    assert len(packages) <= 19


def test_contributing_has_the_table() -> None:
    assert "\n".join(LAYERS) in (PACKAGE.parent / "CONTRIBUTING.md").read_text(encoding="utf-8")


def upward(subpackage: str, targets: set[str]) -> set[str]:
    """What a subpackage imports from its own height or above, its version apart."""
    allowed = {"__init__"} if subpackage in VERSION else set()
    return {x for x in targets - allowed if HEIGHT[x] >= HEIGHT[subpackage]}


@pytest.mark.parametrize("subpackage", HEIGHT)
def test_a_subpackage_imports_from_below_only(subpackage: str) -> None:
    assert upward(subpackage, inside()[subpackage]) == set()


def test_what_decides_a_verdict_is_in_the_checksum_of_those_that_are_kept() -> None:
    subpackages = {x.removesuffix(".py") for x in SUBPACKAGES if "/" not in x}
    assert "prove" in subpackages and all((PACKAGE / x).exists() for x in SUBPACKAGES)
    assert {x: inside()[x] - subpackages for x in subpackages if inside()[x] - subpackages} == {}


def test_the_judge_imports_python_and_itself_only() -> None:
    """It is the lowest layer: what decides does not rest on what it decides about."""
    assert HEIGHT["judge"] == (0, 0)
    modules = [path for path in SOURCES if subpackage_of(path) == "judge"]
    assert len(modules) > 20
    for path in modules:
        inner = {module for module in imported(path) if module[0] == "glmref"}
        assert all(module[:2] == ("glmref", "judge") for module in inner), path
        outer = {module[0] for module in imported(path)} - {"glmref"}
        assert outer <= sys.stdlib_module_names, path


def test_an_import_from_above_is_seen() -> None:
    assert upward("exact", {"errors", "method"}) == {"method"}
    assert upward("cli", {"__init__", "report"}) == set()
    assert upward("theory", {"__init__"}) == {"__init__"}


def test_what_is_asked_of_rooms_above_by_name_stands_in_one_list() -> None:
    """Records draw and save themselves: ``glmref.system.shown`` names what they ask, and nobody else does."""
    from glmref.system import shown

    for module, function in shown.ABOVE:
        path = PACKAGE.joinpath(*module.split(".")).with_suffix(".py")
        assert f"def {function}(" in text(path)
    asking = {
        str(path.relative_to(PACKAGE))
        for path in SOURCES
        if 'import_module(f"glmref.' in text(path)
    }
    assert asking == {"system/shown.py"}


def test_the_top_folder_holds_packages_and_four_modules() -> None:
    modules = {path.stem for path in PACKAGE.glob("*.py")}
    assert modules == {"__init__", "__main__", "errors", "findings"}


#: Imports for annotations that point back, in rooms whose parts are still classes of one chain,
#: and of an element to its tower.
POINTING_BACK = [
    ("glmref.judge.numbers", "glmref.judge.towers"),
    ("glmref.judge.rule", "glmref.judge.proof"),
    ("glmref.prove.digits", "glmref.prove.kernel"),
    ("glmref.prove.find_rows", "glmref.prove.kernel"),
]


def module_graph() -> dict[str, set[str]]:
    """Modules and the modules they import anywhere, in functions and for annotations, too."""
    paths = {
        ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts): path for path in SOURCES
    }
    graph: dict[str, set[str]] = {}
    for name, path in paths.items():
        package = name.split(".")[:-1]
        graph[name] = set()
        for node in nodes_of(path):
            if not isinstance(node, ast.ImportFrom) or not node.level:
                continue
            base = package[: len(package) - node.level + 1]
            module = ".".join([*base, *(node.module.split(".") if node.module else [])])
            for alias in node.names:
                full = f"{module}.{alias.name}"
                graph[name].add(full if full in paths else module)
    return graph


def cycle_in(graph: dict[str, set[str]]) -> list[str]:
    """Return the modules of one import cycle, or nothing."""
    done: set[str] = set()
    for root in graph:
        trail: list[str] = []
        waiting = [(root, False)]
        while waiting:
            name, left = waiting.pop()
            if left:
                trail.pop()
                done.add(name)
            elif name in trail:
                return trail[trail.index(name) :]
            elif name in graph and name not in done:
                trail.append(name)
                waiting += [(name, True), *((x, False) for x in graph[name])]
    return []


def test_there_is_no_import_cycle_open_or_hidden() -> None:
    graph = module_graph()
    for importer, target in POINTING_BACK:
        graph[importer].remove(target)
    assert cycle_in(graph) == []


def abstract(path: Path) -> set[str]:
    """Methods, as Class.name, whose body only raises NotImplementedError."""
    return {
        f"{cls.name}.{f.name}"
        for cls in nodes(path)
        if isinstance(cls, ast.ClassDef)
        for f in cls.body
        if isinstance(f, ast.FunctionDef) and ast.unparse(f.body[-1]) == "raise NotImplementedError"
    }


def defined(path: Path) -> set[str]:
    """Names of the methods with a body, of all classes of a module."""
    return {
        f.name
        for cls in nodes(path)
        if isinstance(cls, ast.ClassDef)
        for f in cls.body
        if isinstance(f, ast.FunctionDef) and f"{cls.name}.{f.name}" not in abstract(path)
    }


#: Interfaces: what every number and every method must offer, whatever file its class is in.
INTERFACES = {"Arithmetic._binary", "Method.weighted"}


@pytest.mark.slow
def test_an_abstract_method_is_defined_in_its_file() -> None:
    found = {
        x for path in SOURCES for x in abstract(path) if x.partition(".")[2] not in defined(path)
    }
    assert found == INTERFACES


def test_a_cycle_is_seen() -> None:
    assert cycle_in({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c"]
    assert cycle_in({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []


def test_an_outside_package_is_imported_by_exactly_its_rooms() -> None:
    assert {x: " ".join(sorted(subpackages)) for x, subpackages in uses()[1].items()} == OUTSIDE


def test_exact_numbers_and_theory_never_see_a_float_array() -> None:
    assert "theory" not in " ".join(OUTSIDE.values())
    assert OUTSIDE["flint"] == "conformance exact"


@pytest.mark.parametrize(("subpackage", "other"), APART)
def test_the_two_witnesses_stay_apart(subpackage: str, other: str) -> None:
    reached, waiting = set(), {subpackage}
    while waiting:
        reached |= waiting
        # the public names of the package are resolved lazily: `glmref` itself leads nowhere
        waiting = {x for y in waiting for x in inside()[y] if y != "__init__"} - reached
    assert other not in reached


def loaded_by(code: str) -> set[str]:
    """Top-level modules that are in memory after some code ran in a fresh interpreter."""
    script = f"{code}\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return {name.partition(".")[0] for name in json.loads(done.stdout.splitlines()[-1])}


HEAVY = {"numpy", "mpmath", "numba", "llvmlite", "flint", "matplotlib", "scipy"}


NUMERICS = {"numpy", "numba", "matplotlib", "scipy", "click"}
KEPLER = "import glmref\np = glmref.problem('kepler')\np.f(0.0, p.y0)\np.jacobian(0.0, p.y0)"


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("code", "needed", "absent"),
    [
        ("import glmref", "glmref", HEAVY | {"click", "tqdm"}),
        ("from glmref.cli import main\nassert main(['--help']) == 0", "click", HEAVY),
        ("import glmref\nglmref.verify(glmref.load('gsymplectic-n'))", "flint", NUMERICS),
        ("import glmref.catalogue.errata as e\ne.load_errata()", "glmref", HEAVY),
        ("import glmref.conformance.plugin", "glmref", HEAVY | {"click"}),
        (KEPLER, "numpy", HEAVY - {"numpy"}),
    ],
    ids=["package", "help", "proofs", "errata", "plugin", "problem"],
)
def test_nothing_is_loaded_that_is_not_needed(code: str, needed: str, absent: set[str]) -> None:
    loaded = loaded_by(code)
    assert not loaded & absent
    assert needed in loaded


def test_every_public_name_is_found_and_every_unknown_one_is_not() -> None:
    for name in glmref.__all__:
        assert getattr(glmref, name) is not None
    assert set(glmref.__all__) <= set(dir(glmref))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = glmref.nothing


def test_benchmarks_need_what_the_package_installs_and_nothing_else() -> None:
    """asv imports all of its folder in an environment that holds the wheel and its dependencies."""
    import tomllib

    root = PACKAGE.parent
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    given = {re.split(r"[^\w-]", x)[0] for x in project["dependencies"]}
    allowed = {"flint" if x == "python-flint" else x for x in given} | {"glmref"}
    waiting = sorted((root / "benchmarks").rglob("*.py"))
    assert {x.name for x in waiting if not x.name.startswith("bench_")} == {"__init__.py"}
    seen: set[Path] = set()
    while waiting:
        path = waiting.pop()
        if path in seen:
            continue
        seen.add(path)
        for node in ast.walk(ast.parse(text(path))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names = [f"{node.module}.{a.name}" for a in node.names]
            for name in names:
                top, *rest = name.split(".")
                if top in ("tools", "campaigns"):
                    found = [root.joinpath(top, *rest[:k]).with_suffix(".py") for k in (1, 2)]
                    waiting += [x for x in found if x.is_file()]
                else:
                    assert top in allowed | sys.stdlib_module_names, f"{path.name} imports {name}"
    assert len(seen) > 6


def test_a_module_lists_names_only_where_it_offers_imports() -> None:
    others = ("campaigns", "tools", "benchmarks", "tests")
    paths = [*SOURCES, *(x for y in others for x in (PACKAGE.parent / y).rglob("*.py"))]
    for path in paths:
        if path.name == "__init__.py" or "\n__all__ = " not in text(path):
            continue
        tree = ast.parse(text(path))
        listed = next(
            ast.literal_eval(x.value)
            for x in tree.body
            if isinstance(x, ast.Assign) and ast.unparse(x.targets[0]) == "__all__"
        )
        imports = [x for x in ast.walk(tree) if isinstance(x, ast.ImportFrom)]
        imported = {a.asname or a.name for x in imports for a in x.names}
        assert imported & set(listed), f"{path} lists what it defines: leave __all__ out"


REFERENCE = re.compile(r":mod:`~?[.]+([\w.]+)`|:\w+:`~?((?:glmref|campaigns)[.][\w.]+)`")


def is_there(at: Path, words: list[str]) -> bool:
    """Whether words lead from a folder to a module, or to one with the next word in its text."""
    while words and (at / words[0]).is_dir():
        at, words = at / words[0], words[1:]
    if words and (at / f"{words[0]}.py").is_file():
        at, words = at / f"{words[0]}.py", words[1:]
    file = at if at.is_file() else at / "__init__.py"
    return not words or (file.is_file() and bool(re.search(rf"\b{words[0]}\b", text(file))))


def unresolved(path: Path, words: str) -> list[str]:
    """References in a text, as it would stand in a file, to what is not there."""
    return [
        relative or whole
        for relative, whole in REFERENCE.findall(words)
        if not any(
            is_there(at, (relative or whole).split("."))
            for at in (path.parents if relative else [PACKAGE.parent])
        )
    ]


def test_references_name_what_is_there() -> None:
    """A module or a name that moved is named by its new place in docstrings and comments too."""
    paths = [*SOURCES, *(PACKAGE.parent / "campaigns").rglob("*.py")]
    wrong = {str(path): found for path in paths if (found := unresolved(path, text(path)))}
    assert not wrong
    named = ":mod:`.field` :class:`~glmref.exact.Exact` :func:`glmref.exact.linalg.solve_affine`"
    assert unresolved(PACKAGE / "exact" / "x.py", named) == []
    assert unresolved(PACKAGE / "cli" / "x.py", f"{named} :data:`glmref.exact.Inexact`") == [
        "field",
        "glmref.exact.Inexact",
    ]


#: Kinds of methods, starts and finishes: code reads components and asks for the kind seldom.
KINDS = {
    *("GLM", "PartitionedGLM", "AdditiveGLM"),
    *("StartingMethod", "PairStartingMethod", "FinishingMethod"),
}


def test_code_seldom_asks_of_what_kind_a_method_is() -> None:
    asked = [
        f"{path.relative_to(PACKAGE)}:{node.lineno}"
        for path in SOURCES
        for node in nodes_of(path)
        if isinstance(node, ast.Call)
        and ast.unparse(node.func) == "isinstance"
        and KINDS & {x.id for x in ast.walk(node.args[1]) if isinstance(x, ast.Name)}
    ]
    assert 0 < len(asked) <= 12, asked


def test_nothing_is_unpickled_and_no_connection_is_opened() -> None:
    """`compute/child.py` binds a local socket to hold a core; `urllib.parse` writes addresses."""
    banned = {
        "pickle", "marshal", "shelve", "socket", "ssl", "http", "ftplib", "smtplib", "requests",
    }  # fmt: skip
    found = {
        (str(path.relative_to(PACKAGE)), module[0])
        for path in SOURCES
        for module in imported(path)
        if module[0] in banned or module[:2] == ("urllib", "request")
    }
    assert found == {("compute/child.py", "socket")}
    child = text(PACKAGE / "compute" / "child.py")
    assert set(re.findall(r"socket\.(\w+)", child)) == {"socket", "AF_UNIX"}
    assert "connect" not in child and "listen" not in child
    loads = [
        ast.unparse(node)
        for path in SOURCES
        for node in nodes_of(path)
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("np.load", "numpy.load")
    ]
    assert loads and all("allow_pickle=False" in x for x in loads)
