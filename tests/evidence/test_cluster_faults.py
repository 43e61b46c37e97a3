"""Faults of a Dask cluster whose workers are processes: each becomes a result or a sentence."""

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from glmref.compute import Limits, Records, executor, in_order, measure
from glmref.compute.child import FAILED, KILLED, MEMORY, TIME_LIMIT
from glmref.errors import UsageError
from tests.evidence.test_cluster_kills import Cluster
from tests.unit.faulty_tasks import behave

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("distributed") is None, reason="dask is not installed"),
]

ROOT = Path(__file__).parents[2]
TASKS = [{"n": k, "how": "sleep", "seconds": 0.02} for k in range(40)]


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    made = Cluster(tmp_path, patience="5s")
    yield made
    made.kill()


def test_tasks_that_hang_eat_die_and_fail_cost_no_other_task(cluster: Cluster) -> None:
    faults = [
        {"n": 101, "how": "hang"},
        {"n": 102, "how": "die"},
        {"n": 103, "how": "eat", "bytes": 10**10},
        {"n": 104, "how": "fail"},
    ]
    tasks = TASKS[:10] + faults + TASKS[10:20]
    limits = Limits(seconds=3.0, memory=2**30, retries=1)
    with executor(f"dask:{cluster.file}") as on:
        done = [x for _, x in in_order(on.run(behave, tasks, limits), tasks)]
    assert [x.failure for x in done[10:14]] == [TIME_LIMIT, KILLED, MEMORY, FAILED]
    assert [x.value["square"] for x in done[:10] + done[14:]] == [k * k for k in range(20)]


def test_a_worker_that_falls_silent_costs_no_task(cluster: Cluster, tmp_path: Path) -> None:
    """SIGSTOP, as where a network is cut: the scheduler gives its tasks to the other worker."""
    store = Records(tmp_path / "records" / "records.sqlite")
    stopped: list[int] = []

    def advance(task: object, record: object) -> None:
        if not stopped:
            stopped.append(cluster.workers[0].pid)
            os.kill(stopped[0], signal.SIGSTOP)

    with executor(f"dask:{cluster.file}") as on:
        while len(on.client.nthreads()) < 2:  # type: ignore[attr-defined]
            time.sleep(0.1)
        number = measure(behave, TASKS, store, on, advance=advance)
    assert stopped and number == 40
    records = list(store)
    assert len({x["key"] for x in records}) == len(records) == 40
    assert sorted(x["square"] for x in records) == [k * k for k in range(40)]


class Wire:
    """A proxy before a scheduler; when it is cut, every connection through it ends."""

    def __init__(self, host: str, port: int) -> None:
        self.target, self.open = (host, port), [socket.create_server(("127.0.0.1", 0))]
        self.address = f"tcp://127.0.0.1:{self.open[0].getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        try:
            while True:
                near, _ = self.open[0].accept()
                far = socket.create_connection(self.target)
                self.open += [near, far]
                for pair in ((near, far), (far, near)):
                    threading.Thread(target=self._carry, args=pair, daemon=True).start()
        except OSError:
            return

    @staticmethod
    def _carry(source: socket.socket, target: socket.socket) -> None:
        try:
            while data := source.recv(1 << 16):
                target.sendall(data)
        except OSError:
            return

    def cut(self) -> None:
        for one in self.open:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()


CUT = """
import sys
from pathlib import Path
from glmref.compute import Records, executor, measure
from glmref.errors import UsageError
from tests.evidence.test_cluster_faults import TASKS, Wire
from tests.unit.faulty_tasks import behave

if __name__ == "__main__":
    folder, host, port = sys.argv[1:]
    wire = Wire(host, int(port))
    done = []

    def advance(task, record):
        done.append(task)
        if len(done) == 10:
            wire.cut()

    try:
        with executor(f"dask:{wire.address}") as on:
            measure(behave, TASKS, Records(Path(folder) / "records.sqlite"), on, advance=advance)
    except UsageError as error:
        sys.stderr.write(f"Error: {error}\\n")
        sys.exit(2)
"""


def test_a_cut_network_ends_with_a_sentence_and_the_same_command_does_the_rest(cluster, tmp_path):
    script, folder = tmp_path / "cut.py", tmp_path / "records"
    script.write_text(CUT, encoding="utf-8")
    with executor(f"dask:{cluster.file}") as on:
        host, _, port = on.client.scheduler.address.rpartition("/")[2].partition(":")  # type: ignore[attr-defined]
    environment = cluster.environment
    command = [sys.executable, str(script), str(folder), host, port]
    cut = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    assert cut.returncode == 2, cut.stderr
    assert "the connection to the scheduler of the Dask cluster was lost" in cut.stderr
    kept = len(Records(folder / "records.sqlite"))
    assert 10 <= kept < 40
    with executor(f"dask:{cluster.file}") as on:
        assert measure(behave, TASKS, Records(folder / "records.sqlite"), on) == 40 - kept
    assert sorted(x["square"] for x in Records(folder / "records.sqlite")) == [
        k * k for k in range(40)
    ]


def test_a_worker_with_other_sources_is_refused_in_a_sentence(tmp_path: Path) -> None:
    """The worker runs a copy of the package with one comment more."""
    copy = tmp_path / "other"
    for name in ("glmref", "data"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "tests" / "unit", copy / "tests" / "unit")
    with (copy / "glmref" / "errors.py").open("a", encoding="utf-8") as stream:
        stream.write("# another version\n")
    made = Cluster(tmp_path, root=copy)
    try:
        with (
            pytest.raises(UsageError, match="for the sources of glmref and the client"),
            executor(f"dask:{made.file}") as on,
        ):
            list(on.run(behave, TASKS))
    finally:
        made.kill()


def test_a_script_without_a_main_is_told_so(tmp_path: Path) -> None:
    script = tmp_path / "bare.py"
    script.write_text(
        "from glmref.compute import executor\nwith executor('dask:1') as on:\n    print(on.name)\n",
        encoding="utf-8",
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, str(script)],
        env=environment, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert "needs `if __name__ == '__main__':`" in done.stderr.strip().splitlines()[-1]
