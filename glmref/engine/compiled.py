"""Turn generated source into a callable: machine code with a cache on disk, or plain Python.

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
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..problems.formula import RealPowers, real_power
from ..problems.tracing import fingerprint
from ..problems.user import UserFunction, plain
from ..system.cache import cache_folder
from ..system.terminal import saying
from . import native
from .native import PLAIN, Tuning

__all__ = ["Built", "build", "cache_folder", "interpret"]

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
    """A kernel ready to be called.

    Attributes
    ----------
    kernel : Callable[..., int]
        The function, with the arguments of :mod:`.codegen`.
    engine : str
        ``"native"`` (llvmlite), ``"numba"`` or ``"python"``.
    path : Path or None
        The generated module, or ``None`` where it was not written.
    notice : str
        Why the interpreter runs it, or ``""``.
    functions : Mapping[str, Callable[..., Any]]
        A user's functions as numba compiled them, by the names the source calls.
    trouble : list[Exception]
        Arithmetic and value errors that ended a call of an interpreted kernel.
    """

    kernel: Callable[..., int]
    engine: str
    path: Path | None = None
    notice: str = ""
    functions: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    trouble: list[Exception] = field(default_factory=list)


def build(
    source: str,
    arguments: Mapping[str, str],
    functions: Mapping[str, Callable[..., Any]] | None = None,
    tuning: Tuning = PLAIN,
) -> Built:
    """Compile a module: by the translator, by numba, or not at all.

    Parameters
    ----------
    source : str
        Module text that defines ``kernel``.
    arguments : Mapping[str, str]
        Names and kinds of its arguments (:data:`.native.KINDS`).
    functions : Mapping[str, Callable[..., Any]] or None
        Python callables the source calls by name; with any, nothing is cached on disk because their
        code is not part of the source.
    tuning : Tuning
        What the compiler may do; of it numba knows ``fuse`` only.
    """
    types = ", ".join(_NUMBA_TYPES[kind] for kind in arguments.values())
    signature = f"int64({types})"
    if functions:
        return _build_around(source, signature, functions, tuning.fuse)
    try:
        return _native(source, tuple(arguments.items()), tuning)
    except (ImportError, native.Unsupported):
        pass
    try:
        module = _load(source, signature, tuning.fuse)
    except (OSError, RuntimeError):  # no folder for a cache, or a full disk
        return _build_around(source, signature, {}, tuning.fuse)
    except ImportError as error:
        return interpret(
            source, {}, f"numba cannot be imported ({error}); the kernel is interpreted"
        )
    return Built(module.kernel, "numba", Path(str(module.__file__)))


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


@lru_cache(maxsize=256)
def _load(source: str, signature: str, fuse: bool) -> ModuleType:
    """Write the module once, import it, and let numba find or fill its cache."""
    import numba
    from llvmlite import binding

    text = _numba_head(signature, cache=True, fuse=fuse) + source
    key = "\n".join(
        (text, numba.__version__, binding.get_host_cpu_name(), platform.machine(), sys.version)
    )
    name = f"glmref_kernel_{hashlib.sha256(key.encode()).hexdigest()[:24]}"
    folder = cache_folder()
    if folder is None:
        raise OSError("no folder for compiled kernels can be written")
    path = folder / f"{name}.py"
    if not path.exists():
        native.write_whole(path, text.encode())
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _build_around(
    source: str, signature: str, functions: Mapping[str, Callable[..., Any]], fuse: bool
) -> Built:
    """Compile with a user's functions among the callees; kept for functions that read the same."""
    marks = [fingerprint(plain(function)) for function in functions.values()]
    key = (source, signature, fuse, tuple(functions), tuple(marks))
    known = None if None in marks else _around.get(key)
    if known is not None:
        return known
    names = ", ".join(getattr(f, "__name__", "a function") for f in functions.values())
    with saying(f"compiling {names or 'a kernel'} ..."):
        built = _compiled_around(source, signature, functions, fuse)
    if None not in marks and built.engine == "numba":
        if len(_around) >= _MOST_AROUND:
            _around.clear()
        _around[key] = built
    return built


#: Kernels compiled around a user's functions, by source and by what the functions are and read.
_around: dict[Any, Built] = {}
_MOST_AROUND = 128


def _compiled_around(
    source: str, signature: str, functions: Mapping[str, Callable[..., Any]], fuse: bool
) -> Built:
    try:
        import numba
        from numba.core.errors import NumbaError, UnsupportedBytecodeError
    except ImportError as error:
        return interpret(source, functions, f"numba cannot be imported ({error})")
    namespace: dict[str, Any] = {}
    try:
        for name, function in functions.items():
            given = plain(function)
            jitted = hasattr(given, "py_func")
            namespace[name] = given if jitted else numba.njit(error_model="numpy")(given)
        text = _numba_head(signature, cache=False, fuse=fuse) + source
        exec(compile(text, "<glmref kernel>", "exec"), namespace)
    except (
        *(NumbaError, UnsupportedBytecodeError, AssertionError),  # numba's own, of three kinds
        *(TypeError, AttributeError, NotImplementedError),
    ) as error:
        reason = next(
            (line for line in str(error).splitlines() if line.strip()), type(error).__name__
        )
        called = ", ".join(getattr(f, "__name__", repr(f)) for f in functions.values())
        return interpret(
            source,
            functions,
            f"numba cannot compile {called} ({reason.strip()}); the kernel is interpreted, "
            f"about 30 times slower",
        )
    called = {name: namespace[name] for name in functions}
    return Built(namespace["kernel"], "numba", functions=called)


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
