"""Settings that every test shares: the profile of hypothesis, and what is quick of a family."""

import gc
import os
import shutil
import signal
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Any
from zlib import crc32

import pytest
from hypothesis import HealthCheck, settings

#: Examples of a property in the quick run, of a hundred in the whole one; see `examples.py`.
QUICK = 10

#: Cases of a family that are run at all where its mark does not say how many.
WHOLE = 12

#: Seconds after which a test that waits for something is failed where it stands.
PATIENCE = 900

BEGUN = time.monotonic()

#: Processes that the whole suite runs on where the machine has as many cores.
PROCESSES = 4


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Run the whole suite on several processes; with paths, ``-n`` or ``--pdb`` as they say.

    The values in an assertion that fails are shown where the test is run by its path.
    """
    option = config.option
    if (
        config.args_source is config.ArgsSource.TESTPATHS
        and getattr(option, "numprocesses", 0) is None
        and "PYTEST_XDIST_WORKER" not in os.environ  # these are asked here, too
        and not (option.usepdb or option.collectonly)
    ):
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
        option.numprocesses = min(PROCESSES, cores or 1) if cores != 1 else None
    if getattr(option, "numprocesses", None) and "PYTEST_XDIST_WORKER" not in os.environ:
        if option.dist == "no" and "not slow" in option.markexpr:
            option.dist = "loadfile"  # what the tests of a file share is made once
        if config.args_source is config.ArgsSource.TESTPATHS:
            option.assertmode = "plain"  # each process would rewrite all files
    if sys.dont_write_bytecode and "PYTEST_XDIST_WORKER" not in os.environ:
        compile_once(config)


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say where the values of an assertion that failed are shown."""
    if terminalreporter.stats.get("failed") and config.option.assertmode == "plain":
        terminalreporter.write_line("A failed test that is run by its path shows the values.")


def compile_once(config: pytest.Config) -> None:
    """Keep byte code in a temporary folder, where none is to be written beside the sources.

    Tests start hundreds of programs, and each would compile the whole package.
    """
    folder = tempfile.mkdtemp(prefix="glmref-bytecode-")
    config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["PYTHONPYCACHEPREFIX"] = folder


def pytest_configure(config: pytest.Config) -> None:
    """Choose the profile of hypothesis, and keep no verdicts.

    Tests change the program while it runs: what it finds then must not be kept for the next run.

    The package brings a plugin, and pytest would rewrite the assertions in all modules of such a
    package, which takes longer than to import them.

    Machines are shared and slow at times: no example is failed for its duration. In CI the examples
    are the same in every run, so that a failure there can be repeated; elsewhere they are random.

    What a shell starts in the background ignores Ctrl-C, and so does what it starts itself, and with
    nohup the end of the terminal; tests send both to programs.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    gc.disable()
    # with --assert=plain nothing is rewritten, and the hook holds no names
    getattr(config.pluginmanager.rewrite_hook, "_must_rewrite", set()).discard("glmref")
    from glmref.prove import verdict_cache as kept  # its assertions are not to be rewritten

    kept.private_folder = lambda name: None
    whole = "not slow" not in config.option.markexpr
    settings.register_profile(
        "glmref",
        deadline=None,
        suppress_health_check=[HealthCheck.too_slow],
        print_blob=True,
        derandomize=bool(os.environ.get("CI")),
        max_examples=100 if whole else QUICK,
    )
    settings.load_profile("glmref")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol() -> Iterator[None]:
    """End a test that hangs, so that the report names it and says where it stood."""

    def late(number: int, frame: object) -> None:
        raise TimeoutError(f"the test had not ended after {PATIENCE} s")

    if not hasattr(signal, "SIGALRM"):
        return (yield)
    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(PATIENCE)
    try:
        return (yield)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def pytest_runtest_setup() -> None:
    """Skip what is left when ``GLMREF_SECONDS`` are over: a slow machine shows less, not nothing."""
    if BEGUN + float(os.environ.get("GLMREF_SECONDS", "inf")) < time.monotonic():
        pytest.skip("the time that GLMREF_SECONDS allows is over")


def pytest_collection_finish() -> None:
    """Leave all that was made up to here, and stays, out of the search for cycles."""
    gc.freeze()
    gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark as slow what goes beyond the sample of a test that is marked ``sampled(n)``.

    The sample is drawn by a hash of the names of the cases: it is the same in every run, and a case
    that is added moves no other one but the last. Cases with a name that contains one of ``besides``
    take long and are not quick before all others are. Of a family only 12 cases are run at all, or
    m where it has ``whole=m``, the quick ones among them, unless ``GLMREF_LONG`` is set or cases are
    asked for by name.
    """
    families: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sampled"):
            families[item.nodeid.partition("[")[0]].append(item)
    by_name = config.option.keyword or any("::" in x for x in config.args)
    everything = by_name or "GLMREF_LONG" in os.environ
    left_out = set()
    for family in families.values():
        mark = family[0].get_closest_marker("sampled")
        assert mark is not None
        family.sort(key=lambda item: crc32(item.name.encode()))
        long = mark.kwargs.get("besides", ())
        quick = [item for item in family if not item.get_closest_marker("slow")]
        quick.sort(key=lambda item: any(x in item.name for x in long))
        for item in quick[mark.args[0] :]:
            item.add_marker(pytest.mark.slow)
        if not everything:
            family.sort(key=lambda item: bool(item.get_closest_marker("slow")))
            left_out.update(family[mark.kwargs.get("whole", max(WHOLE, mark.args[0])) :])
    if left_out:
        config.hook.pytest_deselected(items=[item for item in items if item in left_out])
        items[:] = [item for item in items if item not in left_out]


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    """Run a command line of these words, which ends with ``code``; return what it writes."""
    from glmref.cli import main

    def run(*words: object, code: int = 0) -> Any:
        capsys.readouterr()
        assert main([str(x) for x in words]) == code
        return capsys.readouterr()

    return run
