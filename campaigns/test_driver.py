"""The driver: the same rows wherever tasks run, and nothing is measured twice."""

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from campaigns.driver import arguments, carried_out, complete
from glmref.compute import Records
from glmref.compute.executors import ENVIRONMENT
from glmref.errors import UsageError
from tests.unit.faulty_tasks import behave

CASES = [{"n": k} for k in range(6)]
ROOT = Path(__file__).parents[1]


def test_what_has_ended_is_kept_until_the_file_is_complete(tmp_path: Path) -> None:
    file = tmp_path / "rows.json"
    with pytest.raises(UsageError, match=r"'n': 9.*internal error: ValueError: seven"):
        carried_out(behave, [*CASES, {"n": 9, "how": "fail"}], beside=file)
    (kept,) = tmp_path.glob(".rows.*.sqlite")
    before = list(Records(kept))
    assert len(before) == len(CASES)
    # the same again: read, not measured
    rows = carried_out(behave, CASES, beside=file)
    assert [x["square"] for x in rows] == [k * k for k in range(6)]
    assert list(Records(kept)) == before
    complete(file, {"rows": rows})
    assert json.loads(file.read_text(encoding="utf-8")) == {"rows": rows}
    assert list(tmp_path.iterdir()) == [file]


def test_rows_of_other_sources_are_measured_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "rows.json"
    carried_out(behave, CASES, beside=file)
    monkeypatch.setattr("campaigns.driver._sources", lambda: "others")
    carried_out(behave, CASES, beside=file)
    (kept,) = tmp_path.glob(".rows.*.sqlite")
    assert len(Records(kept)) == 2 * len(CASES)


def test_the_word_on_is_taken_out_and_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(ENVIRONMENT, "here")
    assert arguments(["a.json", "--on", "local:2", "b"]) == ["a.json", "b"]
    assert os.environ[ENVIRONMENT] == "local:2"
    assert arguments(["a.json"]) == ["a.json"]
    with pytest.raises(UsageError, match="--on needs a word"):
        arguments(["a.json", "--on"])


SCRIPT = """
import sys
from pathlib import Path
from campaigns import error_constants
from campaigns.driver import arguments
error_constants.names = lambda kind: ["rk4", "gauss-2", "ab-2", "stormer-verlet"]

if __name__ == "__main__":
    error_constants.main(Path(arguments(sys.argv[1:])[0]))
"""


@pytest.mark.slow
def test_a_measurement_is_the_same_wherever_it_is_made(tmp_path: Path) -> None:
    script = tmp_path / "some.py"
    script.write_text(SCRIPT, encoding="utf-8")
    rows = []
    for on in ("here", "local:2", *(["dask:2"] if find_spec("distributed") else [])):
        file = tmp_path / f"{on.partition(':')[0]}.json"
        subprocess.run(
            [sys.executable, str(script), str(file), "--on", on],
            check=True, timeout=300, env={**os.environ, "PYTHONPATH": str(ROOT)},
        )  # fmt: skip
        rows.append(json.loads(file.read_text(encoding="utf-8"))["methods"])
    assert len(rows[0]) == 4
    assert all(x == rows[0] for x in rows)


def test_help_shows_what_a_campaign_says_of_itself() -> None:
    words = [sys.executable, "-m", "campaigns.error_constants", "--help"]
    run = subprocess.run(words, capture_output=True, text=True, cwd=ROOT, check=True)
    assert "python -m campaigns.error_constants data/" in run.stdout
    assert "300" not in run.stderr
