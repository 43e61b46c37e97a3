"""A release: its notes, its list of components, its archive, its workflow; and the whole, slowly."""

import json
import re
import tomllib
from pathlib import Path

import pytest

import glmref
from tools import release

ROOT = Path(__file__).parents[2]
LOCK = tomllib.loads((ROOT / "uv.lock").read_text(encoding="utf-8"))


def test_every_place_has_the_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert project["version"] == glmref.__version__
    assert re.search(r"^version: (.+)$", citation, re.MULTILINE)[1] == glmref.__version__  # type: ignore[index]


def test_notes_are_those_of_the_version_and_else_of_what_is_not_released() -> None:
    text = "# C\n\n## [Unreleased]\n\n- new\n\n## [1.0] - 2026\n\n- old\n"
    assert release.notes(text, "1.0") == "# glmref 1.0\n\n- old\n"
    assert release.notes(text, "2.0") == "# glmref 2.0\n\n- new\n"
    with pytest.raises(SystemExit, match=r"says nothing of 2\.0"):
        release.notes(text.replace("- new", ""), "2.0")


def test_the_components_are_the_closure_of_what_a_user_installs() -> None:
    found = release.sbom(LOCK, "1.0", "0")
    names = {x["name"] for x in found["components"]}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    direct = {re.match(r"[\w-]+", x)[0] for x in project["dependencies"]}  # type: ignore[index]
    assert direct < names and "llvmlite" in names and not names & {"pytest", "scipy", "glmref"}
    refs = {x["bom-ref"] for x in found["components"]} | {"pkg:pypi/glmref@1.0"}
    assert {x["ref"] for x in found["dependencies"]} == refs
    assert {y for x in found["dependencies"] for y in x["dependsOn"]} <= refs
    assert json.dumps(found) == json.dumps(release.sbom(LOCK, "1.0", "0"))


def test_an_archive_depends_on_names_and_contents_only(tmp_path: Path) -> None:
    for place, order in (("a", "xy"), ("b", "yx")):
        folder = tmp_path / place / "site"
        folder.mkdir(parents=True)
        for name in order:
            (folder / name).write_text(name)
        (folder / "x").chmod(0o600 if place == "a" else 0o644)
        release.archived([folder], tmp_path / f"{place}.tar.gz", "1700000000")
    one, two = (tmp_path / f"{x}.tar.gz" for x in "ab")
    assert one.read_bytes() == two.read_bytes()
    (tmp_path / "b" / "site" / "x").write_text("z")
    release.archived([tmp_path / "b" / "site"], two, "1700000000")
    assert one.read_bytes() != two.read_bytes()


def test_a_tag_of_another_version_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="the tag is v0, and"):
        release.main(["--output", str(tmp_path / "out"), "--tag", "v0"])


def test_the_workflow_publishes_without_a_password_what_was_built_and_tried() -> None:
    yaml = pytest.importorskip("yaml")
    flow = yaml.safe_load((ROOT / ".github" / "workflows" / "release.yml").read_text("utf-8"))
    jobs = flow["jobs"]
    assert jobs["pypi"]["needs"] == "build" and jobs["pypi"]["permissions"] == {"id-token": "write"}
    scripts = [x["run"] for job in jobs.values() for x in job["steps"] if "run" in x]
    assert any("tools.release" in x for x in scripts)
    assert all("${{" not in x for x in scripts) and "secrets." not in str(flow)
    page = (ROOT / "packaging" / "RELEASE.md").read_text(encoding="utf-8")
    assert all(f"`{job['environment']}`" in page for job in jobs.values() if "environment" in job)


@pytest.mark.slow
def test_a_release_is_made_twice_with_the_same_bytes_and_its_wheel_works(tmp_path: Path) -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("a release is made of a commit")
    site = tmp_path / "site"
    site.mkdir()
    (site / "index.html").write_text("<title>x</title>")
    out = tmp_path / "release"
    assert release.main(["--output", str(out), "--site", str(site)]) == 0
    names = {x.name for x in out.iterdir()}
    version = glmref.__version__
    assert names == {
        f"glmref-{version}-py3-none-any.whl", f"glmref-{version}.tar.gz", "SHA256SUMS",
        f"glmref-{version}-site.tar.gz", "sbom.cdx.json", "notes.md",
    }  # fmt: skip
    for line in (out / "SHA256SUMS").read_text().splitlines():
        digest, name = line.split("  ")
        assert release.sha256(out / name) == digest
