"""Some mutated scenes of ``python -m tests.attack scenes``, and two that were found by it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from glmref.catalogue.lookup import data_root
from glmref.errors import DataError
from glmref.scenes import load_scene

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.skipif(os.name != "posix", reason="uses timers of POSIX")


@pytest.mark.slow
def test_mutated_scenes_are_read_or_refused_with_a_sentence() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.attack", "scenes", "--count", "150", "--seed", "9"],
        cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True,
        timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "150 scenes, seed 9" in done.stdout and "0 violations" in done.stdout


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("x = " + "9" * 5000, "line 1: a value cannot be read"),
        ("a." * 50_000 + "a = 1", "line 1: a key has more than 100 parts"),
        ('"a".' * 40_000 + "a = 1", "line 1: a key has more than 100 parts"),
        ("t_end = " + "9" * 400, "`t_end` must be a positive number"),
        ('t_end = "' + "-" * 20_000 + '1"', "`t_end` must be a positive number"),
        ("t_end = 1\nsteps = [" + ",".join(map(str, range(1, 2000))) + "]", "has 1999 entries"),
        ('title = "' + "a" * 3000 + '"', "has more than 2000 characters"),
        ('name = "' + "a" * 200 + '"', "of at most 100 characters"),
        ('name = "../../x"', "`name` must be lower-case words"),
        ('methods = ["../../../etc/passwd"]', "../../../etc/passwd"),
        ("x = '''\n[" + " " * 100_000 + "\n'''", "the key 'x' is unknown"),
    ],
)  # fmt: skip
def test_tar_pits_are_refused_at_once(tmp_path: Path, line: str, words: str) -> None:
    shipped = (data_root() / "scenes" / "denormal.toml").read_text(encoding="utf-8")
    keys = {part.partition("=")[0].strip() for part in line.split("\n")}
    rest = [part for part in shipped.split("\n") if part.partition("=")[0].strip() not in keys]
    path = tmp_path / "x.toml"
    path.write_text("\n".join([line, *rest]), encoding="utf-8")
    with pytest.raises(DataError) as caught:
        load_scene(path)
    text = str(caught.value)
    assert text.startswith("x.toml: ") and len(text) < 1000
    assert words in text or (words == "is not" and "etc/passwd" in text)
