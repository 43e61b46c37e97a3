"""Every public name of ``glmref``, with the members of its classes, has a known type and a docstring."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import glmref

ROOT = Path(__file__).parents[2]
PUBLIC = {name: getattr(glmref, name) for name in glmref.__all__ if name != "__version__"}


@pytest.mark.slow
def test_pyright_knows_the_type_of_every_public_name(tmp_path: Path) -> None:
    # beside the interpreter of the tests, which pyright then asks where packages are
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    pyright = shutil.which("pyright", path=path)
    if pyright is None:
        pytest.skip("pyright is not installed")
    done = subprocess.run(
        [pyright, "--verifytypes", "glmref", "--ignoreexternal", "--outputjson"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT), "PATH": path},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    symbols = json.loads(done.stdout)["typeCompleteness"]["symbols"]
    places = {f"{x.__module__}.{x.__qualname__}" for x in PUBLIC.values()}
    mine = [
        x
        for x in symbols
        if x["name"].removeprefix("glmref.") in PUBLIC
        or any(x["name"] == place or x["name"].startswith(f"{place}.") for place in places)
    ]
    assert {f"glmref.{name}" for name in PUBLIC} <= {x["name"] for x in mine} and len(mine) > 300
    assert [x["name"] for x in mine if not x["isTypeKnown"] or x["isTypeAmbiguous"]] == []


@pytest.mark.parametrize("name", PUBLIC)
def test_help_begins_with_a_sentence_of_ours(name: str) -> None:
    """No signature that dataclasses generate stands in place of a docstring."""
    doc = PUBLIC[name].__doc__
    assert doc and doc.splitlines()[0].rstrip().endswith((".", ":", "::")) and len(doc) >= 20
