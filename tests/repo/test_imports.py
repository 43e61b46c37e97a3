"""Which room may import which: one table, checked exactly; an unused permission fails too.

A room is a module or a package directly inside ``glmref``. ``ROOMS`` lists them from the ground
up: each may import only rooms above it in the table, and must import exactly those its row names.
To add a room, add a row after those it uses; to let a room use another, add the name to its row;
the tests say what to write.
"""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import glmref

PACKAGE = Path(glmref.__file__).parent

ROOMS: dict[str, str] = {
    # words and files
    "claims": "",
    "strict_json": "claims",
    "tables": "claims",
    "canonical": "",
    "figures": "",
    "chart": "figures",
    "plane": "chart figures",
    "keys": "strict_json",
    "data_files": "claims strict_json",
    "errata": "claims data_files strict_json",
    "asv_results": "claims",
    # exact numbers and methods
    "exact": "claims",
    "expression": "claims exact",
    "linalg": "claims exact",
    "rounding": "exact linalg",
    "starts": "linalg",
    "method": "claims exact expression linalg rounding starts",
    "classical": "claims exact linalg method",
    "families": "claims classical exact linalg method",
    "sweep_form": "claims exact linalg method",
    "pair_sweep": "claims exact linalg method",
    "entries": "claims exact expression keys linalg strict_json",
    "reader": "claims data_files entries expression families keys linalg method pair_sweep "
    "strict_json sweep_form",
    "catalogue": "data_files method reader",
    # theory and what is decided with it
    "theory": "claims exact linalg method",
    "derive": "canonical catalogue claims exact expression linalg method pair_sweep reader strict_json "
    "sweep_form theory verification",
    "facts": "claims exact linalg method theory",
    "checks": "claims exact expression facts theory",
    "verification": "catalogue checks claims derive exact facts linalg method reader",
    "analysis": "checks claims exact facts linalg method verification",
    # numbers
    "problems": "catalogue claims strict_json",
    "engine": "catalogue claims exact linalg method problems rounding",
    "experiments": "catalogue claims engine linalg method problems strict_json",
    "scenes": "__init__ catalogue chart claims engine experiments method plane problems strict_json",
    "conformance": "analysis catalogue claims engine exact expression facts linalg method problems "
    "strict_json tables",
    # what people see
    "portrait": "experiments linalg method theory",
    "regions": "catalogue experiments method strict_json theory",
    "error_table": "catalogue experiments facts theory",
    "tableau_text": "exact tables",
    "show": "checks exact facts linalg method tableau_text tables theory",
    "bibtex": "__init__ catalogue reader tables",
    "report": "__init__ asv_results bibtex catalogue claims errata method plane scenes show",
    "cli": "__init__ analysis asv_results bibtex canonical catalogue chart claims conformance "
    "data_files derive errata experiments keys plane portrait report scenes show tables verification",
    "__main__": "cli",
    "__init__": "analysis catalogue claims engine method problems verification",
}

#: Imports that point down the table, each with its reason.
BACKWARDS = {
    ("derive", "verification"): "a recipe verifies the file it writes",
    ("scenes", "__init__"): "the version, for the record",
    ("bibtex", "__init__"): "the version, for the entry",
    ("report", "__init__"): "the version, for the page that says how it was made",
    ("cli", "__init__"): "the version, for --version",
}

#: Packages that are not part of Python, and the rooms that import them.
OUTSIDE: dict[str, str] = {
    "click": "cli",
    "diffrax": "conformance",
    "flint": "exact",
    "heyoka": "conformance",
    "jax": "conformance",
    "llvmlite": "engine",
    "mpmath": "conformance derive engine exact problems",
    "nodepy": "conformance",
    "numba": "engine",
    "numpy": "conformance derive engine experiments method portrait problems regions rounding scenes",
    "pytest": "conformance",
    "rebound": "conformance",
    "scipy": "conformance",
    "tqdm": "cli",
}

#: What may not be reached from where, at any distance: the two witnesses share nothing.
APART = [
    ("theory", "experiments"),
    ("theory", "engine"),
    ("theory", "problems"),
    ("experiments", "theory"),
    ("problems", "theory"),
    ("problems", "experiments"),
    ("problems", "engine"),
]


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path: Path) -> Iterator[tuple[str, ...]]:
    """Every module a file imports, anywhere in it, as a dotted path in parts."""
    package = ("glmref", *path.relative_to(PACKAGE).parts[:-1])
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = (*base, *(node.module.split(".") if node.module else ()))
            if module == ("glmref",):
                yield from ((*module, alias.name) for alias in node.names)
            else:
                yield module


def uses() -> tuple[dict[str, set[str]], dict[str, set[str]]]:
    """Rooms each room imports, and rooms that import each outside package."""
    inside: dict[str, set[str]] = {}
    outside: dict[str, set[str]] = {}
    rooms = {room_of(path) for path in PACKAGE.rglob("*.py")}
    for path in PACKAGE.rglob("*.py"):
        room = room_of(path)
        inside.setdefault(room, set())
        for module in imported(path):
            if module[0] == "glmref":
                target = module[1] if len(module) > 1 and module[1] in rooms else "__init__"
                if target != room:
                    inside[room].add(target)
            elif module[0] not in sys.stdlib_module_names:
                outside.setdefault(module[0], set()).add(room)
    return inside, outside


INSIDE, FROM_OUTSIDE = uses()


def test_every_room_stands_in_the_table_and_no_other() -> None:
    assert set(ROOMS) == set(INSIDE)


@pytest.mark.parametrize("room", INSIDE)
def test_a_room_imports_exactly_what_its_row_says(room: str) -> None:
    row = set(ROOMS.get(room, "").split())
    assert INSIDE[room] == row, (
        f"{room}: not allowed {sorted(INSIDE[room] - row)}, allowed in vain "
        f"{sorted(row - INSIDE[room])}; the row would be {' '.join(sorted(INSIDE[room]))!r}"
    )


def test_arrows_point_up_the_table() -> None:
    height = {room: k for k, room in enumerate(ROOMS)}
    down = {
        (room, target)
        for room, row in ROOMS.items()
        for target in row.split()
        if height[target] > height[room]
    }
    assert down == set(BACKWARDS)


@pytest.mark.parametrize("package", sorted({*OUTSIDE, *FROM_OUTSIDE}))
def test_an_outside_package_is_imported_by_exactly_its_rooms(package: str) -> None:
    assert sorted(FROM_OUTSIDE.get(package, ())) == OUTSIDE.get(package, "").split()


def test_exact_numbers_and_theory_never_see_a_float_array() -> None:
    assert "theory" not in " ".join(OUTSIDE.values())
    assert OUTSIDE["flint"] == "exact"


@pytest.mark.parametrize(("room", "other"), APART)
def test_the_two_witnesses_stay_apart(room: str, other: str) -> None:
    reached, waiting = set(), {room}
    while waiting:
        reached |= waiting
        # the public names of the package are resolved lazily: `glmref` itself leads nowhere
        waiting = {x for y in waiting for x in INSIDE[y] if y != "__init__"} - reached
    assert other not in reached


def loaded_by(code: str) -> set[str]:
    """Top-level modules that are in memory after some code ran in a fresh interpreter."""
    script = f"{code}\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return {name.partition(".")[0] for name in json.loads(done.stdout.splitlines()[-1])}


HEAVY = {"numpy", "mpmath", "numba", "llvmlite", "flint", "matplotlib", "scipy"}


def test_importing_the_package_loads_nothing_heavy_and_no_command_line() -> None:
    loaded = loaded_by("import glmref")
    assert not loaded & (HEAVY | {"click", "tqdm"})
    assert "glmref" in loaded


def test_help_loads_nothing_heavy() -> None:
    code = "from glmref.cli import main\nassert main(['--help']) == 0"
    loaded = loaded_by(code)
    assert not loaded & HEAVY
    assert "click" in loaded


def test_proofs_load_no_numerics() -> None:
    code = "import glmref\nglmref.verify(glmref.load('gsymplectic-n'))"
    loaded = loaded_by(code)
    assert not loaded & {"numpy", "numba", "matplotlib", "scipy", "click"}
    assert "flint" in loaded


def test_every_public_name_is_found_and_every_unknown_one_is_not() -> None:
    for name in glmref.__all__:
        assert getattr(glmref, name) is not None
    assert set(glmref.__all__) <= set(dir(glmref))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = glmref.nothing
