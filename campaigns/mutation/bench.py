"""Which tests call a function, and what they make of a mutant in a copy of the tree.

The tests are run once, one by one, and the functions that each of them calls are recorded. A mutant
is written into the copy, and the tests that call what it changes are run there until one fails,
those of the module first.
"""

import gc
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from functools import _lru_cache_wrapper
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

from glmref.engine.kept import ByIdentity

from .mutants import Mutant

#: Seconds of processor time that the tests of one mutant take at most where nothing is changed,
#: and how many times as long a mutant may take before it counts as one that loops.
MOST, PATIENCE, LEAST = 30.0, 2.0, 20.0
MEMORY = 6 << 30
#: Whose functions forget what they remember before a test.
PACKAGES = ("glmref", "tests")
REMEMBERED = (
    *("glmref.engine.kept._origins", "glmref.engine.kept._formulas"),
    "glmref.engine.kernel_cache._around",
)
SILENT = ["-s", "-q", "--tb=no", "--assert=plain", "-p", "no:cacheprovider", "-p", "no:randomly",
          "-p", "no:random_order"]  # fmt: skip
ROOT = Path(__file__).resolve().parents[2]
LEFT_OUT = (".git", "__pycache__", ".pytest_cache", ".ruff_cache", "docs/images", "site")


def forget() -> None:
    """Forget what functions of this package and its tests remember, in the process and on disk.

    Compiled kernels stay on the disk: they are named after their text.
    """
    gc.unfreeze()  # what is frozen is not listed
    for x in gc.get_objects():
        kind = type(x)  # a proxy of something that is gone cannot be asked by isinstance
        if issubclass(kind, _lru_cache_wrapper):
            if str(getattr(x, "__module__", "")).startswith(PACKAGES):
                x.cache_clear()
        elif issubclass(kind, ByIdentity):
            x.known.clear()
    for name in REMEMBERED:
        module, _, variable = name.rpartition(".")
        getattr(sys.modules.get(module), variable, {}).clear()
    for path in Path(os.environ.get("GLMREF_CACHE", os.devnull)).glob("*.json"):
        path.unlink(missing_ok=True)


class Watch:
    """A plugin of pytest: the functions of some modules that each test calls, and its seconds.

    Tests that are known already are not run.
    """

    def __init__(self, modules: Sequence[Path], calls: dict[str, Any]) -> None:
        self.files, self.calls = {str(ROOT / x): str(x) for x in modules}, calls
        self.names: set[str] = set()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out the tests that are known."""
        self.names = {x.nodeid for x in items}
        items[:] = [x for x in items if x.nodeid not in self.calls]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Watch one test."""
        forget()
        seen: set[CodeType] = set()

        def see(frame: FrameType, event: str, argument: object) -> None:
            if frame.f_code.co_filename in self.files:
                seen.add(frame.f_code)

        failed, begun = item.session.testsfailed, time.process_time()
        sys.settrace(see)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            calls: dict[str, list[str]] = {}
            for code in seen:
                calls.setdefault(self.files[code.co_filename], []).append(code.co_qualname)
            self.calls[item.nodeid] = {
                "seconds": round(time.process_time() - begun, 3),
                "calls": calls,
                "failed": item.session.testsfailed > failed,
            }


class Bench:
    """Tests, what each calls, how long it takes, and a copy of the tree in a folder.

    The modules whose calls are of interest are paths in the tree; in the file ``known`` calls and
    seconds of tests are kept, for a next run.
    """

    def __init__(
        self, folder: Path, tests: Sequence[str], modules: Sequence[Path], known: Path | None
    ) -> None:
        self.tree, self.calls = folder / "tree", dict[str, Any]()
        if known is not None and known.exists():
            self.calls = json.loads(known.read_text(encoding="utf-8"))
        watch = Watch(modules, self.calls)
        pytest.main([*SILENT, *tests], plugins=[watch])
        self.calls = {x: row for x, row in self.calls.items() if x in watch.names}
        if known is not None:
            known.write_text(json.dumps(self.calls), encoding="utf-8")
        shutil.copytree(ROOT, self.tree, ignore=shutil.ignore_patterns(*LEFT_OUT))

    def tests(self, module: Path, function: str) -> list[str]:
        """Return tests that call a function, or any of the module for what runs on import.

        The tests of the module itself come first, then the fastest.
        """
        own = (f"/test_{module.stem}.py", f"/test_{module.parent.name}_{module.stem}.py")
        called = {x: row["calls"].get(str(module), ()) for x, row in self.calls.items()}
        on_import = not any(function in functions for functions in called.values())
        found = [
            (not any(x in name for x in own), row["seconds"], name)
            for name, row in self.calls.items()
            if not row["failed"] and (called[name] if on_import else function in called[name])
        ]
        chosen, spent = [], 0.0
        for _, seconds, name in sorted(found):
            spent += seconds
            if spent <= MOST:
                chosen.append(name)
        return chosen

    def judged(self, module: Path, mutant: Mutant) -> tuple[str, str, float]:
        """Run the tests of a mutant; what came of it, the first that failed, seconds."""
        tests = self.tests(module, mutant.function)
        if not tests:
            return "survived", "", 0.0
        place, kernels = self.tree / module, os.environ.get("GLMREF_CACHE")
        right = place.read_text(encoding="utf-8")
        place.write_text(mutant.source, encoding="utf-8")
        begun = resource.getrusage(resource.RUSAGE_CHILDREN)
        with tempfile.TemporaryDirectory() as name:
            environment = {**os.environ, "PYTHONPATH": str(self.tree)}
            if kernels and module.parent.name == "engine":  # what it generates is for itself alone
                own = shutil.copytree(kernels, Path(name) / "kernels", copy_function=os.link)
                environment["GLMREF_CACHE"] = str(own)
            try:
                outcome, first = self._outcome(tests, environment)
            finally:
                place.write_text(right, encoding="utf-8")
        ended = resource.getrusage(resource.RUSAGE_CHILDREN)
        return outcome, first, ended.ru_utime + ended.ru_stime - begun.ru_utime - begun.ru_stime

    def _outcome(self, tests: Sequence[str], environment: dict[str, str]) -> tuple[str, str]:
        most = PATIENCE * sum(self.calls[x]["seconds"] for x in tests) + LEAST
        try:
            done = subprocess.run(
                [sys.executable, "-m", "pytest", "-x", "--no-header", *SILENT[1:], *tests],
                cwd=self.tree, env=environment, capture_output=True, text=True, check=False,
                timeout=20 * most, preexec_fn=_limits(int(most)),
            )  # fmt: skip
        except subprocess.TimeoutExpired:  # it waits for something
            return "time", ""
        if done.returncode < 0:
            return "time", ""
        failed = [x for x in done.stdout.splitlines() if x.startswith(("FAILED", "ERROR"))]
        first = failed[0].split(" - ")[0].partition(" ")[2] if failed else ""
        return "killed" if done.returncode else "survived", first


def _limits(seconds: int) -> Callable[[], None]:
    """Return what limits a process that begins to so much processor time, and its memory."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

    return limit
