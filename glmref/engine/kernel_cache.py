"""Build kernels from generated source, as machine code that is kept on disk or as plain Python.

Plain kernels go through :mod:`.native`; kernels that call functions on arrays go through numba.
numba caches what it compiled beside the source file it came from, so the generated module is
written to a folder of its own, under a name that is a hash of the source, of the versions of the
compilers, and of the processor. A second process finds it and compiles nothing.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import platform
import sys
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..problems.formula import RealPowers, real_power
from ..problems.tracing import fingerprint
from ..problems.user_functions import UserFunction, plain
from ..system.cache import cache_folder
from ..system.files import replace_whole
from ..system.terminal import saying
from . import native
from .expressions import Unsupported
from .native import PLAIN, Tuning

#: What the kinds of :data:`.native.KINDS` are called in a numba signature.
_NUMBA_TYPES = {"d*": "float64[::1]", "i*": "int64[::1]", "d": "float64", "i": "int64"}

_NUMBA_HEAD = """\
import numba

_options = {{
    "error_model": "numpy", "boundscheck": False, "nogil": True, "cache": {cache},
    "fastmath": {flags!r},
}}
compiled = numba.njit(**_options)
compiled_with_signature = numba.njit({signature!r}, **_options)

"""
_PLAIN_HEAD = """\


def compiled(function):
    return function


compiled_with_signature = compiled

"""


def _numba_head(signature: str, *, cache: bool, fuse: bool) -> str:
    flags = {"contract"} if fuse else False
    return _NUMBA_HEAD.format(cache=cache, signature=signature, flags=flags)


@dataclass(frozen=True)
class Built:
    """A kernel ready to be called."""

    kernel: Callable[..., int]  #: The function, with the arguments of :mod:`.codegen`.
    engine: str  #: ``"native"`` (llvmlite), ``"numba"`` or ``"python"``.
    path: Path | None = None  #: Machine code on disk, or ``None`` where none was written.
    notice: str = ""  #: Why the interpreter runs it, or ``""``.
    #: A user's functions as numba compiled them, by the names the source calls.
    functions: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    #: Arithmetic and value errors that ended a call of an interpreted kernel.
    trouble: list[Exception] = field(default_factory=list)


def build(
    source: str,
    arguments: Mapping[str, str],
    functions: Mapping[str, Callable[..., Any]] | None = None,
    tuning: Tuning = PLAIN,
) -> Built:
    """Compile the ``kernel`` of a module: by the translator, by numba, or not at all.

    ``arguments`` are names and kinds (:data:`.native.KINDS`); ``functions`` are Python callables
    the source calls by name, cached on disk where it is known what they read
    (:func:`~glmref.problems.tracing.fingerprint`). Of what ``tuning`` allows numba knows ``fuse``
    only.

    Raises
    ------
    ImportError, Unsupported
        Where vectors of lanes are requested and cannot be had: nothing else makes them.
    """
    if not functions:
        try:
            return _native(source, tuple(arguments.items()), tuning)
        except (ImportError, Unsupported):
            if tuning.lanes:
                raise
    types = ", ".join(_NUMBA_TYPES[kind] for kind in arguments.values())
    return _build_around(source, f"int64({types})", functions or {}, tuning.fuse)


@lru_cache(maxsize=256)
def _native(source: str, arguments: tuple[tuple[str, str], ...], tuning: Tuning) -> Built:
    import llvmlite

    key = "\n".join(
        (source, repr(tuning), llvmlite.__version__, native.target_name(), platform.machine())
    )
    folder = cache_folder()
    name = f"glmref_kernel_{hashlib.sha256(key.encode()).hexdigest()[:24]}.o"
    path = None if folder is None else folder / name
    kernel = native.compile_kernel(source, dict(arguments), path, tuning)
    return Built(kernel, "native", path)


def _module_file(text: str, about: str = "") -> Path:
    """Return the file of a generated module, named after all that its machine code depends on.

    ``about`` says what the functions are that the module calls and does not define.

    Raises
    ------
    OSError
        Where no file can be kept.
    """
    import numba
    from llvmlite import binding

    versions = (numba.__version__, np.__version__, sys.version, platform.machine())
    key = "\n".join((text, about, *versions, binding.get_host_cpu_name()))
    folder = cache_folder()
    if folder is None:
        raise OSError("no folder for compiled kernels can be written")
    path = folder / f"glmref_kernel_{hashlib.sha256(key.encode()).hexdigest()[:24]}.py"
    if not path.exists():
        replace_whole(path, text.encode(), umask=0o077)
    return path


def _imported(path: Path, given: Mapping[str, Any]) -> ModuleType:
    """Run a generated module, which may use the names given; numba finds or fills its cache."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    vars(module).update(given)
    sys.modules[path.stem] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[path.stem]
        raise
    return module


def _build_around(
    source: str, signature: str, functions: Mapping[str, Callable[..., Any]], fuse: bool
) -> Built:
    """Compile with a user's functions among the callees; kept for functions that read the same."""
    given = tuple(map(plain, functions.values()))
    refused = (source, signature, *map(id, given))
    if refused in _refused:
        return interpret(source, functions, _refused[refused][1])
    marks = [fingerprint(function) for function in given]
    key = None if None in marks else repr((source, signature, fuse, tuple(functions), marks))
    known = None if key is None else _around.get(key)
    if known is not None:
        return known
    built = _compiled_around(source, signature, functions, fuse, key)
    if built.engine == "python":
        if len(_refused) >= _MOST_AROUND:
            _refused.clear()
        _refused[refused] = given, built.notice
    elif key is not None:
        if len(_around) >= _MOST_AROUND:
            _around.clear()
        _around[key] = built
    return built


#: Kernels compiled around a user's functions, by source and by what the functions are and read.
_around: dict[str, Built] = {}
#: Functions, by source and identity, that could not be compiled, and why: to find it takes seconds.
_refused: dict[tuple[Any, ...], tuple[tuple[Any, ...], str]] = {}
_MOST_AROUND = 128


def _compiled_around(
    source: str,
    signature: str,
    functions: Mapping[str, Callable[..., Any]],
    fuse: bool,
    key: str | None,
) -> Built:
    try:
        import numba
    except ImportError as error:
        says = f"numba cannot be imported ({error}); the kernel is interpreted"
        return interpret(source, functions, says)
    names = ", ".join(getattr(f, "__name__", "a function") for f in functions.values())
    own: dict[str, Any] = {}
    called = "".join(_CALLED[name] for name in functions)
    try:
        for name, function in functions.items():
            given = plain(function)
            jitted = hasattr(given, "py_func")
            own[f"own_{name}"] = given if jitted else numba.njit(error_model="numpy")(given)
        with saying(f"compiling {names or 'a kernel'} with numba, which takes seconds, once ..."):
            kept = None if key is None else _kept_around(signature, called + source, fuse, own, key)
            if kept is not None:
                return Built(kept["kernel"], "numba", functions={k: kept[k] for k in functions})
            namespace = dict(own)
            text = _numba_head(signature, cache=False, fuse=fuse) + called + source
            exec(compile(text, "<glmref kernel>", "exec"), namespace)
    except Exception as error:  # numba has errors of its own, and passes on those of its parts
        # numba's first line names its pipeline, the next one what it cannot do
        lines = [x for x in str(error).splitlines() if x.strip() and not x.startswith("Failed in")]
        reason = lines[0] if lines else type(error).__name__
        return interpret(
            source,
            functions,
            f"numba cannot compile {names or 'the kernel'} ({reason.strip()}); the kernel is "
            f"interpreted, about 30 times slower",
        )
    return Built(namespace["kernel"], "numba", functions={k: namespace[k] for k in functions})


#: A user's functions by the names that the source calls: of the generated module, so that their
#: code is kept with it.
_CALLED = {
    "full": "@compiled\ndef full(time, v):\n    return own_full(time, v)\n\n\n",
    "velocity": "@compiled\ndef velocity(v):\n    return own_velocity(v)\n\n\n",
    "force": "@compiled\ndef force(v):\n    return own_force(v)\n\n\n",
}


def _kept_around(
    signature: str, source: str, fuse: bool, own: Mapping[str, Any], key: str
) -> Mapping[str, Any] | None:
    """Return the module from the cache on disk, or compiled into it; ``None`` where that cannot be.

    Numba itself looks at the text of a module alone, so the fingerprints of the functions it calls
    are in the name of the file.
    """
    from numba.core.errors import NumbaError, NumbaWarning

    with warnings.catch_warnings():
        # code around addresses of this process is not kept, and is compiled all the same
        warnings.filterwarnings("ignore", "Cannot cache", NumbaWarning)
        try:
            path = _module_file(_numba_head(signature, cache=True, fuse=fuse) + source, key)
            return vars(_imported(path, own))
        except NumbaError:
            raise
        except Exception:  # no folder, a full disk, a damaged entry
            return None


def interpret(source: str, functions: Mapping[str, Callable[..., Any]], notice: str = "") -> Built:
    """Run the source in the interpreter."""
    # Python numbers, not those of numpy: the kernel computes with them, ten times as fast
    called = {k: f.listed if isinstance(f, UserFunction) else f for k, f in functions.items()}
    trouble: list[Exception] = []
    namespace: dict[str, Any] = {**called, "array": np.array, "trouble": trouble}
    namespace["real_power"] = real_power
    tree = ast.fix_missing_locations(RealPowers().visit(ast.parse(_PLAIN_HEAD + source)))
    exec(compile(tree, "<glmref kernel>", "exec"), namespace)
    return Built(namespace["kernel"], "python", None, notice, trouble=trouble)
