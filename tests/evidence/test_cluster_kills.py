"""A campaign on a Dask cluster whose workers are killed again and again, and whose scheduler is killed."""

import os
import random
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import pytest

from glmref.compute import Records, measure
from tests.unit.faulty_tasks import behave

pytestmark = pytest.mark.skipif(find_spec("distributed") is None, reason="dask is not installed")

ROOT = Path(__file__).parents[2]
SCRIPT = """
import sys
from pathlib import Path
from glmref.cli.output import complain
from glmref.compute import Records, executor, measure
from glmref.errors import UsageError
from tests.unit.faulty_tasks import behave

if __name__ == "__main__":
    folder, scheduler, count = sys.argv[1:]
    tasks = [{"n": k, "how": "sleep", "seconds": 0.03} for k in range(int(count))]
    try:
        with executor(f"dask:{scheduler}") as on:
            measure(behave, tasks, Records(Path(folder) / "records.sqlite"), on)
    except UsageError as error:
        complain(str(error))
        sys.exit(2)
"""


class Cluster:
    """A scheduler and two workers, each a process; who is killed is started again."""

    def __init__(self, folder: Path, *, root: Path = ROOT, patience: str = "5 minutes") -> None:
        self.file, self.root = folder / "scheduler.json", root
        self.environment = {
            **os.environ,
            "PYTHONPATH": str(root),
            "DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": patience,
            "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "5s",
        }
        self.scheduler = self._start("scheduler", "--port", "0", "--no-show")
        until = time.monotonic() + 60
        while not self.file.exists() and time.monotonic() < until:
            time.sleep(0.1)
        self.workers = [self._worker() for _ in range(2)]

    def _start(self, what: str, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "dask", what, "--scheduler-file", str(self.file), *words]
        quiet = subprocess.DEVNULL
        return subprocess.Popen(
            command, cwd=self.root, env=self.environment, stdout=quiet, stderr=quiet
        )

    def _worker(self) -> subprocess.Popen[bytes]:
        return self._start("worker", "--nthreads", "1", "--no-nanny", "--no-dashboard")

    def kill_a_worker(self, number: int) -> None:
        self.workers[number].kill()
        self.workers[number].wait()
        self.workers[number] = self._worker()

    def kill(self) -> None:
        for process in (self.scheduler, *self.workers):
            process.kill()
            process.wait()
        self.file.unlink(missing_ok=True)


def known(folder: Path) -> int:
    return len(Records(folder / "records.sqlite"))


#: Three minutes on two cores: asked for by the environment variable GLMREF_LONG.
LONG = pytest.mark.skipif("GLMREF_LONG" not in os.environ, reason="GLMREF_LONG is not set")


@pytest.mark.slow
@pytest.mark.parametrize(("count", "kills"), [(300, 3), pytest.param(2000, 20, marks=LONG)])
def test_nothing_is_lost_and_nothing_is_done_twice(count: int, kills: int, tmp_path: Path) -> None:
    """`kills` workers die at random times, half of them before the scheduler does and half after."""
    script = tmp_path / "campaign.py"
    script.write_text(SCRIPT, encoding="utf-8")
    folder, draw = tmp_path / "records", random.Random(kills)
    done = 0
    codes = []
    for part in range(2):
        cluster = Cluster(tmp_path)
        command = [sys.executable, str(script), str(folder), str(cluster.file), str(count)]
        process = subprocess.Popen(command, env=cluster.environment, stderr=subprocess.PIPE)
        try:
            share = kills // 2 if part == 0 else kills - kills // 2
            goal = count * 45 // 100 if part == 0 else count * 9 // 10
            start = done
            for k in range(share):
                # the kills are spread over the part, so that each meets tasks that run
                until = time.monotonic() + 120
                while known(folder) < start + (goal - start) * (k + 1) // (share + 1):
                    assert process.poll() is None, process.stderr and process.stderr.read()
                    assert time.monotonic() < until
                    time.sleep(0.02)
                time.sleep(draw.random() / 10)
                cluster.kill_a_worker(draw.randrange(2))
            if part == 0:
                cluster.scheduler.send_signal(signal.SIGKILL)
            _, said = process.communicate(timeout=300)
            codes.append(process.returncode)
            if part == 0:
                assert b"the connection to the scheduler" in said
                done = known(folder)
                assert 0 < done < count
        finally:
            process.kill()
            cluster.kill()
    assert codes == [2, 0]
    records = list(Records(folder / "records.sqlite"))
    assert len(records) == len({x["key"] for x in records}) == count
    own = Records(None)
    measure(behave, [{"n": k, "how": "sleep", "seconds": 0.03} for k in range(count)], own)
    assert {x["key"]: x for x in records} == {x["key"]: x for x in own}
