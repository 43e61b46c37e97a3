"""Executors: the same results everywhere, limits, faults, records under interruption."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from glmref.compute import Done, Executor, Limits, Records, executor, measure
from glmref.compute.child import (
    FAILED,
    KILLED,
    MEMORY,
    TIME_LIMIT,
    UNLIMITED,
    Child,
    physical_cores,
)
from glmref.compute.executors import Here, Local, in_order
from glmref.compute.identity import difference, identity
from glmref.errors import UsageError
from tests.unit.faulty_tasks import behave, unsendable, where

SQUARES = [{"n": k} for k in range(40)]


@pytest.fixture(scope="module")
def dask() -> Iterator[Executor]:
    """A Dask cluster whose workers are threads of this process: quick to start."""
    distributed = pytest.importorskip("distributed")
    from glmref.compute.cluster import Dask

    made = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=":0"
    )
    with made, distributed.Client(made) as client:
        yield Dask(client, "dask:2")


def run(on: Executor, tasks: list[dict[str, Any]], limits: Limits = UNLIMITED) -> list[Done]:
    return [done for _, done in in_order(on.run(behave, tasks, limits), tasks)]


def client_of(**parts: Any) -> Any:
    """Return what is asked of a client of Dask."""
    given = {"dashboard_link": "", "cancel": lambda _: None} | parts
    return SimpleNamespace(scheduler=SimpleNamespace(ncores=dict), **given)


@pytest.mark.slow
def test_results_do_not_depend_on_the_executor(dask: Executor) -> None:
    here = [done.value for done in run(Here(), SQUARES)]
    assert here == [{"outcome": "completed", "square": k * k} for k in range(40)]
    for on in (Local(2), dask):
        assert [done.value for done in run(on, SQUARES)] == here


def test_few_tasks_are_taken_ahead(dask: Executor) -> None:
    for on in (Here(), Local(2), dask):
        taken = 0

        def tasks() -> Iterator[dict[str, int]]:
            nonlocal taken
            for k in range(10_000):
                taken += 1
                yield {"n": k}

        results = on.run(behave, tasks())
        next(results)
        assert taken <= 8
        results.close()  # type: ignore[attr-defined]


def test_the_scheduler_keeps_nothing_of_a_task_that_has_ended(dask: Executor) -> None:
    scheduler = dask.client.cluster.scheduler  # type: ignore[attr-defined]

    def kept() -> int:
        spans = scheduler.extensions["spans"].spans.values()
        return len(scheduler.tasks) + sum(len(span.groups) for span in spans)

    run(dask, SQUARES)
    before = kept()
    run(dask, SQUARES, Limits(retries=1))
    assert kept() <= before + 4  # a group for the run, and what it has not let go yet


@pytest.mark.slow
def test_a_cluster_whose_workers_all_died_ends_with_a_sentence(monkeypatch):
    from glmref.compute import cluster

    client = client_of(
        cluster="own", sync=lambda ask, **_: ask(),
        submit=lambda *_, key, **__: SimpleNamespace(key=key, add_done_callback=lambda _: None),
    )  # fmt: skip
    monkeypatch.setattr(cluster, "ASK", 0.0)
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    with pytest.raises(UsageError, match="all workers of the Dask cluster died"):
        next(cluster.Dask(client, "dask:2").run(behave, SQUARES))


def test_a_scheduler_that_does_not_answer_is_lost_within_its_patience(monkeypatch):
    """It does not wait once more to cancel what was sent."""
    from glmref.compute import cluster

    monkeypatch.setattr(cluster, "PATIENCE", 0.1)
    asked: list[float] = []
    cancelled: list[Any] = []

    def sync(ask: Any, callback_timeout: float) -> Any:
        asked.append(callback_timeout)
        raise TimeoutError

    client = client_of(sync=sync, cancel=cancelled.append)
    with pytest.raises(UsageError, match="to the scheduler of the Dask cluster was lost"):
        next(cluster.Dask(client, "dask:frozen").run(behave, SQUARES))
    assert (asked, cancelled) == ([0.1], [])


@pytest.mark.parametrize(("pause", "most"), [(60.0, 1), (0.0, len(SQUARES) + 1)])
def test_the_scheduler_is_asked_for_its_threads_once_in_a_while(pause, most, monkeypatch):
    from glmref.compute import cluster

    asked: list[float] = []

    def submit(*_: Any, key: Any, **__: Any) -> Any:
        done = SimpleNamespace(key=key, status="finished", result=lambda timeout: Done(value=1))
        done.add_done_callback = lambda ended: ended(done)
        return done

    client = client_of(
        cluster=None, submit=submit,
        sync=lambda ask, callback_timeout: asked.append(callback_timeout) or {},
    )  # fmt: skip
    monkeypatch.setattr(cluster, "ASK", pause)
    found = list(cluster.Dask(client, "dask:quick").run(behave, SQUARES))
    assert sum(map(len, found)) == len(SQUARES)
    assert 1 <= len(asked) <= most
    assert (len(asked) > 1) is (pause == 0)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are Linux's")
def test_every_fault_is_a_result_and_costs_no_other_task(dask: Executor, tmp_path: Path) -> None:
    faults: list[dict[str, Any]] = [
        {"n": 1, "how": "hang"},
        {"n": 2, "how": "die"},
        {"n": 3, "how": "eat", "bytes": 10**10},
        {"n": 4, "how": "fail"},
        {"n": 5, "how": "die once"},
    ]
    limits = Limits(seconds=1.0, memory=2**30, retries=1)
    for on in (Local(2), dask):
        faults[-1]["mark"] = str(tmp_path / on.name)
        done = run(on, SQUARES[:10] + faults + SQUARES[10:20], limits)
        assert [x.failure for x in done[10:14]] == [TIME_LIMIT, KILLED, MEMORY, FAILED]
        assert [x.attempts for x in done[10:15]] == [1, 2, 1, 1, 2]
        assert done[14].value["square"] == 25
        assert "ValueError: seven" in done[13].trace
        rest = [x.value["square"] for x in done[:10] + done[15:]]
        assert rest == [k * k for k in range(20)]
        assert done[10].as_record() == {
            "outcome": TIME_LIMIT,
            "message": "stopped after 1 s",
            "attempts": 1,
        }


@pytest.mark.skipif(len(physical_cores()) < 2, reason="needs two cores")
def test_timed_tasks_have_a_core_each_and_one_thread() -> None:
    tasks = [{"n": k} for k in range(8)]
    done = [x.value for _, x in in_order(Local(2).run(where, tasks, Limits(pinned=True)), tasks)]
    assert {len(x["cores"]) for x in done} == {1}
    assert {x["threads"] for x in done} == {"1"}
    by_process = {x["process"]: tuple(x["cores"]) for x in done}
    assert len(set(by_process.values())) == len(by_process)
    with pytest.raises(UsageError, match="timed tasks need a core each"):
        next(Local(1 + len(physical_cores())).run(where, tasks, Limits(pinned=True)))


@pytest.mark.skipif(sys.platform != "linux", reason="nothing is pinned here")
def test_a_core_that_another_timed_task_has_is_waited_for_and_refused_in_the_end(monkeypatch):
    from glmref.compute import child

    monkeypatch.setattr(child, "_WAIT", 0.2)
    held: list[socket.socket] = []
    monkeypatch.setattr(child, "_core", held)
    monkeypatch.setattr(os, "getuid", lambda: 10**9)  # no other test holds cores of this user
    before = os.sched_getaffinity(0)
    try:
        for _ in physical_cores():
            assert child._ready(True)
            os.sched_setaffinity(0, before)
        assert not child._ready(True) and child._ready(False)
        held.pop().close()
        assert child._ready(True)
    finally:
        os.sched_setaffinity(0, before)
        for one in held:
            one.close()


def test_a_child_that_ended_is_not_started_again_by_its_task() -> None:
    child = Child(Limits(retries=5))
    child.end()
    assert child.carry_out(behave, {"n": 2, "how": "die"}).attempts == 1
    child.end()


def test_a_child_that_is_ended_while_it_starts_has_no_task() -> None:
    """It was started all the same, and the process waited for its task to end."""
    child = Child(Limits(retries=0))
    threading.Timer(0.01, child.end).start()
    begun = time.monotonic()
    done = child.carry_out(behave, {"n": 2, "how": "sleep", "seconds": 60})
    assert done.failure == KILLED and time.monotonic() - begun < 30


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="has no masks of signals")
def test_a_child_is_deaf_for_ctrl_c_from_its_first_moment_on() -> None:
    """The first one was not: what multiprocessing starts besides it unblocked the signal."""
    code = (
        "import signal\n"
        "from multiprocessing import resource_tracker\n"
        "from glmref.compute.child import _surroundings\n"
        "with _surroundings():\n"
        "    resource_tracker.ensure_running()  # as spawning does\n"
        "    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ())\n"
        "raise SystemExit(signal.SIGINT not in blocked)\n"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.skipif(os.name != "posix", reason="has no semaphores to unlink")
@pytest.mark.parametrize("filters", [None, "default"])
def test_a_process_that_ends_at_once_leaves_its_semaphores_without_a_warning(filters):
    """What a signal ends does so; the tracker of Python wrote two lines to the user."""
    code = (
        "import os\n"
        "from glmref.compute.child import Child, Limits\n"
        "if __name__ == '__main__':\n"
        "    before = dict(os.environ)\n"
        "    child = Child(Limits())\n"
        "    assert child.carry_out(abs, -1).value == 1\n"
        "    os._exit(os.environ != before)\n"
    )
    surroundings = {k: x for k, x in os.environ.items() if k != "PYTHONWARNINGS"}
    surroundings |= {"PYTHONWARNINGS": filters} if filters else {}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=surroundings, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_result_that_cannot_be_sent_is_a_failure_of_its_task() -> None:
    child = Child(UNLIMITED)
    try:
        assert child.carry_out(unsendable, {}).failure == FAILED
        assert child.carry_out(behave, {"n": 2}).value["square"] == 4
    finally:
        child.end()


def test_a_worker_that_is_not_what_the_client_is_is_refused(dask, monkeypatch):
    from glmref.compute import cluster

    mine = identity()
    assert difference(mine, mine) == ""
    monkeypatch.setattr(cluster, "difference", lambda *_: "has 1.0 for numpy and the client 2.0")
    with pytest.raises(UsageError, match=r"a worker of \S+ has 1.0 for numpy"):
        run(dask, SQUARES)
    assert "numpy" in difference({**mine, "numpy": "0"}, mine)
    assert difference({k: x for k, x in mine.items() if k != "numpy"}, mine).startswith("has none")


@pytest.mark.parametrize(
    "text",
    ["cloud", "local:0", "local:x", "local:-1", "here:2", "dask:0", "local:" + "9" * 5000,
     "local:99999", "dask:99999"],
)  # fmt: skip
def test_what_chooses_nothing_is_refused_in_a_sentence(text: str) -> None:
    with pytest.raises(UsageError, match=r"executor|worker or more"), executor(text):
        pass


def test_the_environment_chooses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GLMREF_EXECUTOR", "local:3")
    with executor() as on:
        assert on.name == "local:3"
    with executor("here") as on:
        assert on.name == "here"


def test_without_dask_one_sentence_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"pip install 'glmref\[cluster\]'"), executor("dask"):
        pass


def test_the_example_files_have_settings_and_options_that_dask_knows() -> None:
    distributed, yaml = pytest.importorskip("distributed"), pytest.importorskip("yaml")
    from click.testing import CliRunner

    folder = Path(__file__).parents[2] / "docs" / "campaigns"
    slurm = yaml.safe_load((folder / "slurm.yaml").read_text(encoding="utf-8"))
    known = Path(distributed.__file__).with_name("distributed.yaml").read_text(encoding="utf-8")

    def leaves(tree: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
        for key, value in tree.items():
            name = f"{prefix}{key}"
            yield from leaves(value, f"{name}.") if isinstance(value, dict) else [(name, value)]

    given = dict(leaves({"distributed": slurm["distributed"]}))
    assert set(given) <= set(dict(leaves(yaml.safe_load(known))))
    spec = yaml.safe_load((folder / "kubernetes.yaml").read_text(encoding="utf-8"))["spec"]
    for what, command in (
        ("worker", import_module("distributed.cli.dask_worker").main),
        ("scheduler", import_module("distributed.cli.dask_scheduler").main),
    ):
        program, word, *options = spec[what]["spec"]["containers"][0]["args"]
        assert (program, word) == ("dask", what)
        said = CliRunner().invoke(command, ["--help"]).output
        assert all(x in said for x in options if x.startswith("--"))


@pytest.mark.slow
def test_nothing_of_dask_is_loaded_unless_it_is_asked_for() -> None:
    code = (
        "import sys; import glmref.compute; from glmref.cli import main; main(['list']);"
        "loaded = {'dask', 'distributed', 'tornado', 'pyarrow'} & set(sys.modules); assert not loaded"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


def test_no_scheduler_is_a_sentence(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    from glmref.compute import cluster

    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    with (
        pytest.raises(UsageError, match="no Dask scheduler answers at tcp://127"),
        executor("dask:tcp://127.0.0.1:9"),
    ):
        pass
    with (
        pytest.raises(UsageError, match="there is no file"),
        executor(f"dask:{tmp_path / 'none.json'}"),
    ):
        pass


# --- records --------------------------------------------------------------------------------------


def test_what_is_missing_is_carried_out_and_written_first(tmp_path: Path) -> None:
    path = tmp_path / "r.sqlite"
    assert measure(behave, SQUARES[:10], Records(path)) == 10
    seen: list[int] = []

    def advance(task: Any, record: Any) -> None:
        on_disk = {x["key"] for x in Records(path)}
        assert record["key"] in on_disk
        seen.append(task["n"])

    assert measure(behave, SQUARES, Records(path), Local(2), advance=advance) == 30
    assert sorted(seen) == list(range(10, 40))
    assert len(Records(path)) == 40


def test_records_hold_each_task_once(tmp_path: Path) -> None:
    path = tmp_path / "f" / "records.sqlite"
    assert measure(behave, SQUARES[:30], Records(path)) == 30
    again = Records(path)
    assert len(again) == 30
    assert measure(behave, SQUARES, again) == 10
    assert sorted(x["square"] for x in again) == [k * k for k in range(40)]
    # the near miss: another content is another task
    assert measure(behave, [{"n": 3, "how": "well"}], Records(path)) == 1


def test_a_second_writer_is_refused(tmp_path: Path) -> None:
    store = Records(tmp_path / "records.sqlite")
    with store.exclusive(), pytest.raises(UsageError, match="is in use by"):
        measure(behave, SQUARES, Records(tmp_path / "records.sqlite"))


SCRIPT = """
import sys
from pathlib import Path
from glmref.compute import Records, executor, measure
from tests.unit.faulty_tasks import behave
if __name__ == "__main__":
    tasks = [{"n": k, "how": "sleep", "seconds": 0.01} for k in range(200)]
    with executor("local:2") as on:
        measure(behave, tasks, Records(Path(sys.argv[1]) / "records.sqlite"), on)
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs signals of POSIX")
def test_a_run_that_is_killed_and_run_again_loses_nothing_and_does_nothing_twice(tmp_path):
    """Its processes are killed at random as well; they end with it."""
    root = Path(__file__).parents[2]
    script = tmp_path / "run.py"
    script.write_text(SCRIPT, encoding="utf-8")
    folder = tmp_path / "records"
    command = [sys.executable, str(script), str(folder)]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    first = subprocess.Popen(command, env=environment)
    until = time.monotonic() + 60
    while not len(Records(folder / "records.sqlite")) and time.monotonic() < until:
        time.sleep(0.01)
    first.send_signal(signal.SIGKILL)
    first.wait()
    kept = len(Records(folder / "records.sqlite"))
    assert 0 < kept < 200
    subprocess.run(command, env=environment, check=True)
    records = list(Records(folder / "records.sqlite"))
    assert len(records) == len({x["key"] for x in records}) == 200
    assert sorted(x["square"] for x in records) == [k * k for k in range(200)]
    assert json.loads(json.dumps(records)) == records
