"""uv.lock and the conda recipe are what pyproject.toml asks for, and name public places only."""

import re
import shutil
import subprocess
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
LOCK = ROOT / "uv.lock"
#: Seconds that the package index has to answer.
PATIENCE = 120
#: What uv says where the index cannot be asked; anything else is about the file.
UNREACHABLE = re.compile(r"fetch|connect|network|offline|dns|tls|certificate|timed? ?out", re.I)


def test_the_lock_names_public_places_only() -> None:
    text = LOCK.read_text(encoding="utf-8")
    hosts = set(re.findall(r"https?://[^/\"]+", text))
    assert hosts == {"https://pypi.org", "https://files.pythonhosted.org"}


def test_the_lock_holds_what_every_extra_asks_for() -> None:
    """Without uv and without a network: every requirement of pyproject.toml is locked."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    locked = tomllib.loads(LOCK.read_text(encoding="utf-8"))["package"]
    names = {package["name"] for package in locked}
    (mine,) = (package for package in locked if package["name"] == "glmref")
    extras = project["optional-dependencies"]
    assert set(mine["optional-dependencies"]) == set(extras)
    for requirement in (*project["dependencies"], *(x for row in extras.values() for x in row)):
        found = re.match(r"([A-Za-z0-9._-]+)(\[[a-z,]+\])?", requirement)
        name = re.sub(r"[-_.]+", "-", found[1]).lower()
        assert name == "glmref" or name in names, requirement
        specifiers = {
            (x["name"], x.get("specifier", "")) for x in mine["metadata"]["requires-dist"]
        }
        if name != "glmref":
            wanted = frozenset(requirement[found.end() :].replace(" ", "").split(","))
            given = {frozenset(spec.split(",")) for other, spec in specifiers if other == name}
            assert wanted in given, requirement


def test_uv_finds_nothing_to_update(tmp_path: Path) -> None:
    uv = shutil.which("uv")
    if uv is None:
        pytest.skip("uv is not installed")
    # a copy: uv must not touch the checkout
    for file in ("pyproject.toml", "uv.lock", "README.md"):
        shutil.copy(ROOT / file, tmp_path / file)
    try:
        done = subprocess.run(
            [uv, "lock", "--check", "--no-progress"],
            cwd=tmp_path, capture_output=True, text=True, check=False, timeout=PATIENCE,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        pytest.skip(f"the package index did not answer in {PATIENCE} seconds")
    stale = "needs to be updated" in done.stderr
    if done.returncode and not stale and UNREACHABLE.search(done.stderr):
        pytest.skip(f"the package index cannot be asked: {done.stderr.splitlines()[0]}")
    assert done.returncode == 0, done.stderr


RECIPE = ROOT / "packaging" / "conda" / "recipe.yaml"


def recipe() -> dict[str, Any]:
    """The recipe, with its one variable put in."""
    yaml = pytest.importorskip("yaml")
    text = RECIPE.read_text(encoding="utf-8")
    version = yaml.safe_load(text)["context"]["version"]
    return yaml.safe_load(text.replace("${{ version }}", version))


def test_the_conda_recipe_is_rendered() -> None:
    rattler_build = pytest.importorskip("rattler_build")
    (variant,) = rattler_build.Stage0Recipe.from_yaml(RECIPE.read_text("utf-8")).render()
    assert (variant.recipe.package.name, variant.recipe.package.version) == tuple(
        recipe()["package"].values()
    )


def bounds(requirements: Iterable[str]) -> dict[str, frozenset[str]]:
    """Name -> bounds."""
    found = (re.fullmatch(r"([A-Za-z0-9._-]+)\s*(.*)", x) for x in requirements)
    return {x[1]: frozenset(x[2].split(",")) for x in found if x is not None}


def test_the_conda_recipe_asks_for_what_the_project_asks_for() -> None:
    file = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project, found = file["project"], recipe()
    python = {"python": frozenset([project["requires-python"]])}
    assert bounds(found["requirements"]["run"]) == bounds(project["dependencies"]) | python
    host = bounds(file["build-system"]["requires"]) | python | {"pip": frozenset([""])}
    assert bounds(found["requirements"]["host"]) == host
    assert found["package"] == {"name": project["name"], "version": project["version"]}
    ((name, target),) = project["scripts"].items()
    assert found["build"]["python"]["entry_points"] == [f"{name} = {target}"]
    assert found["about"]["license"] == project["license"]
    # the wheel holds the data, too
    assert {x.stem for x in (ROOT / "LICENSES").iterdir()} < set(project["license"].split(" AND "))
    assert (ROOT / found["about"]["license_file"]).is_file()
