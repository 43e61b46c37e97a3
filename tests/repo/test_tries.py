"""The scripts of packaging/TRY.md: at most five commands each, from an empty folder."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PARTS = re.findall(
    r"^## ([^\n]+)\n(.*?)^```sh\n(.*?)^```",
    (ROOT / "packaging" / "TRY.md").read_text(encoding="utf-8"),
    re.MULTILINE | re.DOTALL,
)
#: Programs and packages that a part needs.
NEEDS = {
    "Action": ("bash", "git", "yaml"),
    "Hook": ("git", "yaml", "pre_commit"),
    "Feed": ("sha256sum", "jsonschema"),
    "Checkers in C++ and JavaScript": ("c++", "node"),
}


def test_there_is_a_part_for_each_thing_of_at_most_five_commands() -> None:
    assert [name.split()[0] for name, _, _ in PARTS] == [
        "Action", "Hook", "Feed", "Board", "Browser", "Checkers",
    ]  # fmt: skip
    assert all(0 < len(script.splitlines()) <= 5 for _, _, script in PARTS)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "about", "script"), PARTS, ids=[x[0] for x in PARTS])
def test_a_script_works_in_an_empty_folder(name, about, script, tmp_path):
    for need in NEEDS.get(name, ()):
        if not shutil.which(need):
            pytest.importorskip(need)
    code, said = re.search(r"It ends with (\d) and prints `([^`]+)`", about).groups()  # type: ignore[union-attr]
    clean = {k: v for k, v in os.environ.items() if not k.startswith("GIT_")}
    place = tmp_path / "empty"
    place.mkdir()
    done = subprocess.run(
        ["bash", "-eo", "pipefail", "-c", script], cwd=place, capture_output=True, text=True,
        check=False,
        env=clean | {
            "GLMREF": str(ROOT), "PRE_COMMIT_HOME": str(tmp_path / "home"),
            "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
        },
    )  # fmt: skip
    assert (done.returncode, said in done.stdout) == (int(code), True), done.stdout + done.stderr
