"""uv.lock is what pyproject.toml asks for, and names public places only."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

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
        assert found is not None
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
