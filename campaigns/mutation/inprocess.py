"""Tests of mutants in children of one process that has collected every test.

A child puts the code of a mutant in place of that of the functions that exist, wherever they are
bound, and runs the tests that call them, those of the module first, until one fails. Collecting
takes as long as hundreds of such children.
"""

from __future__ import annotations

import ast
import contextlib
import gc
import importlib
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import _lru_cache_wrapper, cache
from itertools import zip_longest
from pathlib import Path
from types import CodeType, FrameType, FunctionType, ModuleType
from typing import Any

import pytest

from glmref.engine.kept import ByIdentity
from glmref.problems.tracing import codes

from .mutants import Mutant

#: Seconds of processor time that the tests of one mutant take at most where nothing is changed,
#: and how many times as long a mutant may take before it counts as one that loops.
MOST, PATIENCE, LEAST = 30.0, 2.0, 10.0
#: Seconds of the tests that are run first, so that what loops is ended soon.
FIRST = 4.0
MEMORY = 6 << 30
#: Whose functions forget what they remember before a test.
PACKAGES = ("glmref", "tests")
REMEMBERED = (
    *("glmref.engine.kept._origins", "glmref.engine.kept._formulas"),
    "glmref.engine.compiled._around",
)
#: The package is a plugin of pytest, which would compile its modules with other asserts: a function
#: that has one would not be found by its code, and its mutants would change nothing.
SILENT = ["-s", "-q", "--tb=no", "--assert=plain", "-p", "no:cacheprovider", "-p", "no:randomly",
          "-p", "no:random_order"]  # fmt: skip
ROOT = Path(__file__).resolve().parents[2]


def _numbered(code: CodeType) -> dict[tuple[str, int], CodeType]:
    """Return qualified name, and number among those of the same name -> code."""
    found: dict[tuple[str, int], CodeType] = {}
    for inner in codes(code):
        number = 0
        while (inner.co_qualname, number) in found:
            number += 1
        found[inner.co_qualname, number] = inner
    return found


def _key(code: CodeType) -> tuple[str, int, bytes]:
    """Return what tells code; code that has run is not equal to itself as compiled anew.

    Two functions of one name begin on the same line only if they are lambdas. The table of lines
    tells those; that of a function with an ``assert`` is another where pytest has rewritten it.
    """
    table = code.co_linetable if code.co_name == "<lambda>" else b""
    return code.co_qualname, code.co_firstlineno, table


class NothingChanged(Exception):
    """No function that exists has the code that a mutant changes."""


def exchange(module: ModuleType, source: str) -> bool:
    """Put the functions and constants of another text of an imported module in place of its own.

    Returns whether the change is wholly in functions, so that nothing computed on import is stale.

    Raises
    ------
    NothingChanged
        Where no function has the code: the module was imported late, or compiled in another
        way.
    """
    path = str(module.__file__)
    right = compile(Path(path).read_text(encoding="utf-8"), path, "exec", dont_inherit=True)
    wrong = compile(source, path, "exec", dont_inherit=True)
    old, new = _numbered(right), _numbered(wrong)
    twin = {_key(old[k]): code for k, code in new.items() if k in old and old[k] != code}
    inside = ast.dump(_frame(right.co_filename, None)) == ast.dump(_frame(path, source))
    changed = 0
    for f in _every(FunctionType):
        if f.__code__.co_filename == path and _key(f.__code__) in twin:
            with contextlib.suppress(ValueError):  # another number of free variables
                f.__code__ = twin[_key(f.__code__)]
                changed += 1
    if inside and not changed:
        raise NothingChanged(path)
    if not inside:
        _rebind(module, wrong)
    return inside


def _frame(path: str, source: str | None) -> ast.Module:
    """Return what a module computes on import: what is left when functions have no bodies."""
    tree = ast.parse(Path(path).read_text(encoding="utf-8") if source is None else source)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            node.body = [ast.Pass()]
    return tree


def _rebind(module: ModuleType, code: CodeType) -> None:
    """Compute a module anew, and bind its new constants wherever the old ones are bound."""
    fresh = ModuleType(module.__name__)
    fresh.__dict__.update(__file__=module.__file__, __package__=module.__package__)
    exec(code, fresh.__dict__)
    for name, value in vars(fresh).items():
        before = vars(module).get(name, value)
        if isinstance(value, FunctionType) and isinstance(before, FunctionType):
            before.__defaults__, before.__kwdefaults__ = value.__defaults__, value.__kwdefaults__
        elif not isinstance(value, type | ModuleType | FunctionType) and name[:2] != "__":
            for other in [x for x in sys.modules.values() if isinstance(x, ModuleType)]:
                if vars(other).get(name) is before:
                    setattr(other, name, value)


@cache
def _every(kind: type) -> list[Any]:
    """Return all functions, or caches of functions; found once, before children are made."""
    gc.unfreeze()  # what is frozen is not listed
    # a proxy of something that is gone cannot be asked by isinstance
    return [x for x in gc.get_objects() if issubclass(type(x), kind)]


def _spelled(module: Path) -> str:
    return ".".join(module.with_suffix("").parts)


def _forget() -> None:
    """Forget what functions of this package and its tests remember, in the process and on disk.

    Compiled kernels stay on the disk: they are named after their text.
    """
    for x in _every(_lru_cache_wrapper):
        if str(getattr(x, "__module__", "")).startswith(PACKAGES):
            x.cache_clear()
    for name in REMEMBERED:
        module, _, variable = name.rpartition(".")
        getattr(sys.modules.get(module), variable, {}).clear()
    for x in _every(ByIdentity):
        x.known.clear()
    for path in Path(os.environ.get("GLMREF_CACHE", os.devnull)).glob("*.json"):
        path.unlink(missing_ok=True)


class Bench:
    """Tests of a session that has collected, what each calls, and how long it takes.

    The modules whose calls are of interest are paths in the tree; in the file ``known`` calls and
    seconds of tests are kept, for a next run.
    """

    def __init__(
        self, session: pytest.Session, modules: Sequence[Path], known: Path | None
    ) -> None:
        self.session = session
        self.items = {item.nodeid: item for item in session.items}
        self.files = {str(ROOT / x): str(x) for x in modules}
        self.calls: dict[str, Any] = {}
        if known is not None and known.exists():
            self.calls = json.loads(known.read_text(encoding="utf-8"))
        new = [x for x in self.items if x not in self.calls]
        with tempfile.TemporaryDirectory() as name:
            kept = Path(name) / "calls.json"
            child(
                lambda: kept.write_text(json.dumps(self._watched(new))),
                36000, Path(name), kernels_too=True,
            )  # fmt: skip
            self.calls |= json.loads(kept.read_text())
        if known is not None:
            known.write_text(json.dumps(self.calls), encoding="utf-8")

    def _run(self, names: Sequence[str]) -> str:
        """Run tests until one fails; its name, or ``""``."""
        items = [self.items[x] for x in names]
        for item, following in zip_longest(items, items[1:]):
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            if self.session.testsfailed:
                return item.nodeid
        return ""

    def _watched(self, names: Sequence[str]) -> dict[str, Any]:
        """Run tests one by one; the functions of the modules that each calls, and its seconds."""
        found: dict[str, Any] = {}
        for name in names:
            _forget()
            seen: set[CodeType] = set()
            begun = time.process_time()
            sys.settrace(lambda frame, event, argument, seen=seen: self._see(frame, seen))
            try:
                failed = self._run([name])
            finally:
                sys.settrace(None)
            self.session.testsfailed = 0
            calls: dict[str, list[str]] = {}
            for code in seen:
                calls.setdefault(self.files[code.co_filename], []).append(code.co_qualname)
            found[name] = {"seconds": round(time.process_time() - begun, 3), "calls": calls,
                           "failed": bool(failed)}  # fmt: skip
        return found

    def _see(self, frame: FrameType, seen: set[CodeType]) -> None:
        if frame.f_code.co_filename in self.files:
            seen.add(frame.f_code)

    def tests(self, module: Path, function: str) -> list[str]:
        """Return tests that call a function, or any of the module for what runs on import.

        The tests of the module itself come first, then the fastest.
        """
        own = (f"/test_{module.stem}.py", f"/test_{module.parent.name}_{module.stem}.py")
        on_import, found = self._on_import(module, function), []
        for name, row in self.calls.items():
            called = row["calls"].get(str(module), ())
            if name in self.items and not row["failed"] and (
                called if on_import else function in called
            ):  # fmt: skip
                found.append((not any(x in name for x in own), row["seconds"], name))
        chosen, spent = [], 0.0
        for _, seconds, name in sorted(found):
            spent += seconds
            if spent <= MOST:
                chosen.append(name)
        return chosen

    def _on_import(self, module: Path, function: str) -> bool:
        """Return whether no test calls it: what is in no function or is called on import."""
        return all(function not in x["calls"].get(str(module), ()) for x in self.calls.values())

    def judged(self, module: Path, mutant: Mutant) -> tuple[str, str, float]:
        """Run the tests of a mutant; what came of it, the first that failed, seconds."""
        if mutant.function and self._on_import(module, mutant.function):
            return "stale", "", 0.0
        tests = self.tests(module, mutant.function)
        spent, soon = 0.0, 0
        while soon < len(tests) and spent < FIRST:
            spent += self.calls[tests[soon]]["seconds"]
            soon += 1
        outcome, first, seconds = self._judged(module, mutant, tests[:soon])
        if outcome == "survived" and soon < len(tests):
            outcome, first, more = self._judged(module, mutant, tests[soon:])
            seconds += more
        return outcome, first, seconds

    def _judged(self, module: Path, mutant: Mutant, tests: Sequence[str]) -> tuple[str, str, float]:
        most = PATIENCE * sum(self.calls[x]["seconds"] for x in tests) + LEAST
        with tempfile.TemporaryDirectory() as name:
            kept = Path(name) / "outcome.json"

            def work() -> None:
                _forget()
                kept.write_text(json.dumps(["stale", ""]))
                try:
                    if exchange(importlib.import_module(_spelled(module)), mutant.source):
                        kept.write_text(json.dumps(["survived", ""]))
                    failed = self._run(tests)
                except NothingChanged:
                    failed = ""  # tested in a copy of the tree
                except Exception as error:
                    failed = f"import: {type(error).__name__}"
                if failed:
                    kept.write_text(json.dumps(["killed", failed]))

            kernels_too = module.parent.name == "engine"
            status, seconds = child(work, most, Path(name), kernels_too=kernels_too)
            if not kept.exists() or status != 0:
                return "time", "", seconds
            outcome, first = json.loads(kept.read_text())
            return outcome, first, seconds


def child(
    work: Callable[[], Any], seconds: float, folder: Path, *, kernels_too: bool = False
) -> tuple[int, float]:
    """Work in a child within so much processor time; return its status and the time it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    sys.stdout.flush()
    number = os.fork()
    if number == 0:
        code = 1
        try:
            os.setpgid(0, 0)
            null = os.open(os.devnull, os.O_RDWR)
            for stream in range(3):
                os.dup2(null, stream)
            resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 2))
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
            kernels = os.environ.get("GLMREF_CACHE")
            if kernels and kernels_too:  # what a mutant generates is for itself alone
                recalled = shutil.ignore_patterns("*.json")
                shutil.copytree(kernels, folder / "kernels", copy_function=os.link, ignore=recalled)
                os.environ["GLMREF_CACHE"] = str(folder / "kernels")
            work()
            code = 0
        finally:
            os._exit(code)
    begun, status = time.monotonic(), None
    while status is None:
        ended, told = os.waitpid(number, os.WNOHANG)
        if ended:
            status = told
        elif time.monotonic() - begun > 20 * seconds:  # it waits for something
            with contextlib.suppress(OSError):
                os.killpg(number, signal.SIGKILL)
            _, status = os.waitpid(number, 0)
        else:
            time.sleep(0.01)
    with contextlib.suppress(OSError):
        os.killpg(number, signal.SIGKILL)  # what it has started
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return status, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def collected(
    tests: Sequence[str], use: Callable[[pytest.Session], None], modules: Sequence[Path]
) -> int:
    """Collect tests, and call a function in the place of running them; modules are imported."""

    class Plugin:
        @pytest.hookimpl(tryfirst=True)
        def pytest_runtestloop(self, session: pytest.Session) -> bool:
            if session.testsfailed:
                raise session.Interrupted("tests cannot be collected")
            for module in modules:
                importlib.import_module(_spelled(module))
            for kind in (FunctionType, _lru_cache_wrapper, ByIdentity):
                _every(kind)
            use(session)
            return True

    return int(pytest.main([*SILENT, *tests], plugins=[Plugin()]))
