"""A small scene, run as a program of its own under faults, and what its records must be.

Records are compared bit for bit but for what depends on the clock: run times, the time to build a
kernel, and the checksum, which is over them.
"""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from glmref.compute import Records
from tests.build import scene_text

ROOT = Path(__file__).resolve().parents[2]

SCENE = scene_text(
    "tiny", methods=["heun-2", "rk4", "stormer-verlet"], steps=[200000, 400000, 600000, 800000],
    t_end="2*pi", ask=["state", "energy"], repeats=1,
)  # fmt: skip
TASKS = 12
#: What depends on the clock.
TIMES = ("seconds", "build_seconds", "start_seconds", "sha256")


class Runs:
    """A folder in which a scene is run, with a cache of kernels that is filled."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.scene = folder / "tiny.toml"
        self.scene.write_text(SCENE, encoding="utf-8")
        done = self.run("undisturbed")
        assert done.returncode == 0, done.stderr
        self.right = self.records("undisturbed")
        assert len(self.right) == TASKS

    def command(self, name: str, *options: str) -> list[str]:
        program = [sys.executable, "-m", "glmref", "run", str(self.scene)]
        return [*program, "--output", str(self.folder / name), *options]

    def environment(self, **changes: str) -> dict[str, str]:
        cache = str(self.folder / "cache")
        return {**os.environ, "PYTHONPATH": str(ROOT), "GLMREF_CACHE": cache, **changes}

    def start(self, name: str, *options: str, **popen: Any) -> subprocess.Popen[str]:
        """Start a run; it goes on while the caller does what it has in mind."""
        return self.popen(self.command(name, *options), **popen)

    def popen(self, command: list[str], **popen: Any) -> subprocess.Popen[str]:
        """Start a program in the folder, with the surroundings of the runs."""
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        environment = popen.pop("env", None) or self.environment()
        return subprocess.Popen(command, cwd=self.folder, env=environment, **{**streams, **popen})

    def run(self, name: str, *options: str, **popen: Any) -> subprocess.CompletedProcess[str]:
        """Run to the end."""
        process = self.start(name, *options, **popen)
        out, err = process.communicate(timeout=120)
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def path(self, name: str) -> Path:
        return self.folder / name / "tiny.sqlite"

    def records(self, name: str) -> list[dict[str, Any]]:
        """Records of a run without what depends on the clock; the file must be sound."""
        return [
            {key: value for key, value in record.items() if key not in TIMES}
            for record in Records(self.path(name))
        ]

    def check(self, name: str) -> None:
        """Assert that nothing is lost, nothing is there twice, and every bit is right."""
        keys = [record["key"] for record in self.records(name)]
        assert len(keys) == len(set(keys)) == TASKS
        assert self.records(name) == self.right
        # the lock of a run that is killed after its last record stays, and keeps nobody out; so does
        # a hidden file that was about to be given its name
        files = (path.name for path in (self.folder / name).iterdir())
        left = sorted(
            x for x in files if not x.startswith((".tiny.sqlite.lock", ".tiny.run.json."))
        )
        assert left == ["tiny.run.json", "tiny.sqlite"], left


def sentence(done: subprocess.CompletedProcess[str]) -> str:
    """The one line on stderr; no traceback."""
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("glmref: "), done.stderr
    return lines[0]
