"""Build a release from the last commit, the same bytes each time, and try its wheel apart.

``python -m tools.release --output DIR`` writes the sdist and the wheel (built twice and compared),
``sbom.cdx.json`` (CycloneDX, from uv.lock), ``notes.md`` (from the changelog) and ``SHA256SUMS``;
with ``--site FOLDER ..`` also an archive of these folders (documentation, report, feed). The wheel
is installed into an empty environment, where verify, solve, report and conformance must work.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from uuid import NAMESPACE_URL, uuid5

ROOT = Path(__file__).resolve().parents[1]
#: A program that uses the wheel: exact order, a run, and the data.
_SOLVE = """
import glmref
run = glmref.solve(glmref.problem("kepler", eccentricity="1/5"), "gauss-2", h=0.01, steps=100)
assert run.completed and glmref.analyze("rk4").order == 4
assert "site-packages" in glmref.__file__
"""
#: What the wheel must do in an empty folder: words after ``glmref``, and the file of the output.
TRIED: tuple[tuple[str, str], ...] = (
    ("verify rk4 gsymplectic-n --format json", "verified.json"),
    ("report verified.json --output pages", "report.txt"),
    ("conformance exported-python", "conformance.txt"),
)


def built(source: Path, output: Path, time: str) -> list[Path]:
    """Build sdist and wheel of a checkout without anything else in it.

    The files in them carry the time, in seconds since 1970.
    """
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-d", str(output)],
        cwd=source, check=True, stdout=subprocess.DEVNULL,
        env={**os.environ, "SOURCE_DATE_EPOCH": time},
    )  # fmt: skip
    return sorted(output.iterdir())


def checkout(commit: str, folder: Path) -> Path:
    """Write the files of a commit into a folder."""
    text = subprocess.run(
        ["git", "archive", "--format=tar", commit], cwd=ROOT, capture_output=True, check=True
    ).stdout
    with tarfile.open(fileobj=io.BytesIO(text)) as archive:
        archive.extractall(folder, filter="data")
    return folder


def sha256(path: Path) -> str:
    """Return the checksum of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def tried(wheel: Path, folder: Path) -> None:
    """Install a wheel into an empty environment and run :data:`TRIED` outside of the checkout."""
    venv, place = folder / "venv", folder / "empty"
    # an own copy of pip would take longer to unpack than all else that is installed
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(venv)], check=True)
    python = venv / ("Scripts" if os.name == "nt" else "bin") / "python"
    subprocess.run([*_installer(python), str(wheel)], check=True)
    clean = {
        k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "GLMREF", "VIRTUAL"))
    }
    place.mkdir()
    runs = [(["-c", _SOLVE], "solve.txt")]
    runs += [(["-m", "glmref", *words.split()], file) for words, file in TRIED]
    for words, file in runs:
        with (place / file).open("w", encoding="utf-8") as output:
            subprocess.run(
                [str(python), "-I", *words], cwd=place, check=True, env=clean, stdout=output
            )
    if not (place / "pages" / "index.html").is_file():
        raise SystemExit("the wheel's `glmref report` wrote no index.html")


def _installer(python: Path) -> list[str]:
    """Return the command that installs into an environment: uv, whose cache is quick, or pip."""
    if uv := shutil.which("uv"):
        return [uv, "pip", "install", "--quiet", "--python", str(python)]
    return [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet"]


def notes(changelog: str, version: str) -> str:
    """Return what the changelog says of a version, or of what is not released yet."""
    parts = re.split(r"^## \[([^\]]+)\].*$", changelog, flags=re.MULTILINE)
    known = dict(zip(parts[1::2], parts[2::2], strict=True))
    for name in (version, "Unreleased"):
        if known.get(name, "").strip():
            return f"# glmref {version}\n\n{known[name].strip()}\n"
    raise SystemExit(f"CHANGELOG.md says nothing of {version}")


def sbom(lock: dict[str, Any], version: str, time: str) -> dict[str, Any]:
    """Return the CycloneDX document of what a user installs: the closure of the dependencies.

    Where the lock holds several versions of a package, for several Pythons, each is a component.
    """
    packages: dict[str, list[dict[str, Any]]] = {}
    for package in lock["package"]:
        packages.setdefault(package["name"], []).append(package)
    needed, waiting = {}, ["glmref"]
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed[name] = packages[name]
            waiting += [x["name"] for row in packages[name] for x in row.get("dependencies", ())]
    own = f"pkg:pypi/glmref@{version}"
    components = [
        {
            "type": "library", "bom-ref": f"pkg:pypi/{name}@{row['version']}", "name": name,
            "version": row["version"], "purl": f"pkg:pypi/{name}@{row['version']}",
            **({"hashes": [{"alg": "SHA-256", "content": row["sdist"]["hash"][7:]}]}
               if "sdist" in row else {}),
        }
        for name, rows in sorted(needed.items()) if name != "glmref" for row in rows
    ]  # fmt: skip
    refs = {
        name: [f"pkg:pypi/{name}@{x['version']}" for x in rows] for name, rows in needed.items()
    }
    refs["glmref"] = [own]
    edges = [
        {
            "ref": ref,
            "dependsOn": sorted({y for x in row.get("dependencies", ()) for y in refs[x["name"]]}),
        }
        for name, rows in sorted(needed.items())
        for ref, row in zip(refs[name], rows, strict=True)
    ]
    main = {"type": "library", "bom-ref": own, "name": "glmref", "version": version, "purl": own}
    return {
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "serialNumber": f"urn:uuid:{uuid5(NAMESPACE_URL, f'{own}?{time}')}",
        "metadata": {"component": {**main, "licenses": [{"expression": _licence()}]}},
        "components": components, "dependencies": edges,
    }  # fmt: skip


def _project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def _licence() -> str:
    return _project()["license"]


def archived(folders: Sequence[Path], output: Path, time: str) -> None:
    """Write folders into one archive whose bytes depend on their files and the time only."""
    with (
        output.open("wb") as stream,
        gzip.GzipFile(filename="", fileobj=stream, mode="wb", mtime=int(time)) as packed,
        tarfile.open(fileobj=packed, mode="w") as archive,
    ):
        for folder in folders:
            for path in sorted(x for x in folder.rglob("*") if x.is_file()):
                entry = tarfile.TarInfo(f"{folder.name}/{path.relative_to(folder).as_posix()}")
                entry.size, entry.mtime, entry.mode = path.stat().st_size, int(time), 0o644
                with path.open("rb") as content:
                    archive.addfile(entry, content)


def main(arguments: Sequence[str] | None = None) -> int:
    """Make a release; what does not hold ends in an error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--commit", default="HEAD")
    parser.add_argument("--site", type=Path, nargs="*", default=[])
    parser.add_argument("--tag", help="must be v and the version")
    asked = parser.parse_args(arguments)
    version = _project()["version"]
    if asked.tag and asked.tag != f"v{version}":
        raise SystemExit(f"the tag is {asked.tag}, and pyproject.toml has version {version}")
    shown = subprocess.run(
        ["git", "log", "-1", "--format=%ct", asked.commit],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    time = shown.stdout.strip()
    asked.output.mkdir(parents=True)
    with TemporaryDirectory() as name:
        place = Path(name)
        first, second = (
            built(checkout(asked.commit, place / x), place / f"{x}-dist", time) for x in "ab"
        )
        different = [a.name for a, b in zip(first, second, strict=True) if sha256(a) != sha256(b)]
        if different:
            raise SystemExit(f"two builds differ: {', '.join(different)}")
        for path in first:
            (asked.output / path.name).write_bytes(path.read_bytes())
        tried(next(x for x in first if x.suffix == ".whl"), place)
    lock = tomllib.loads((ROOT / "uv.lock").read_text(encoding="utf-8"))
    document = json.dumps(sbom(lock, version, time), indent=1) + "\n"
    (asked.output / "sbom.cdx.json").write_text(document, encoding="utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    (asked.output / "notes.md").write_text(notes(changelog, version), encoding="utf-8")
    if asked.site:
        archived(asked.site, asked.output / f"glmref-{version}-site.tar.gz", time)
    sums = [f"{sha256(x)}  {x.name}\n" for x in sorted(asked.output.iterdir())]
    (asked.output / "SHA256SUMS").write_text("".join(sums), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
