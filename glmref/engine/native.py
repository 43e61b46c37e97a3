"""Compile generated source to machine code with llvmlite, keeping the object code on disk.

:mod:`.translate` turns the source into LLVM's assembly, in a tenth of the time numba needs. No
floating point operation is reordered, nor contracted unless asked for: the result has the bits of
the interpreter.
"""

from __future__ import annotations

import contextlib
import ctypes
import ctypes.util
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..system.cache import read_entry, write_entry
from ..system.terminal import saying
from .expressions import CACHE_LINE, LIBRARY
from .translate import translated

#: Kinds of arguments: arrays of doubles, integers, vectors of doubles; double, integer.
KINDS = {"d*": ctypes.c_void_p, "i*": ctypes.c_void_p, "d": ctypes.c_double, "i": ctypes.c_int64,
         "v*": ctypes.c_void_p}  # fmt: skip


def aligned_zeros(size: int) -> np.ndarray:
    """Return zeros, shape (size,), that begin on a cache line: what a kernel works on."""
    raw = np.zeros(size + CACHE_LINE // 8)
    skip = -raw.ctypes.data % CACHE_LINE // 8
    return raw[skip : skip + size]


@cache
def target_name() -> str:
    """Return processor and its features, as part of a cache key."""
    from llvmlite import binding

    return f"{binding.get_host_cpu_name()} {binding.get_host_cpu_features().flatten()}"


@dataclass(frozen=True)
class Tuning:
    """What the compiler may do."""

    #: Whether independent operations of straight-line code are packed into vectors. That helps
    #: where several stages go side by side and hurts a single chain of operations.
    pack: bool = False
    #: Whether loops may use the widest vectors of the processor, which LLVM avoids by default where
    #: short bursts of them do not pay; loops over lanes are no short bursts.
    wide: bool = False
    #: Whether a product and a sum may become one operation with one rounding. The bits then depend
    #: on the processor.
    fuse: bool = False
    lanes: int = 0  #: Numbers in a vector of the kind ``v*``.


PLAIN = Tuning()


def compile_kernel(
    source: str, arguments: Mapping[str, str], cached: Path | None, tuning: Tuning = PLAIN
) -> Callable[..., int]:
    """Compile the function ``kernel`` of a module whose arguments have these kinds, in order.

    The object code is read from the file ``cached`` where that exists, else written there. The
    result takes numpy arrays and numbers, returns an integer, and holds no lock while it runs.

    Raises
    ------
    Unsupported
        When the source cannot be translated.
    """
    engine = _engine(source, arguments, cached, tuning)
    address = engine.get_function_address("kernel")
    kinds = arguments.values()
    raw = ctypes.CFUNCTYPE(ctypes.c_int64, *(KINDS[k] for k in kinds))(address)
    arrays = [n for n, kind in enumerate(kinds) if kind.endswith("*")]

    def kernel(*given: Any) -> int:
        passed = list(given)
        for n in arrays:
            passed[n] = given[n].__array_interface__["data"][0]  # a third of the time of .ctypes
        return raw(*passed)

    kernel.engine = engine  # type: ignore[attr-defined]  # the code lives as long as its engine
    kernel.address = address  # type: ignore[attr-defined]
    return kernel


def _engine(source: str, arguments: Mapping[str, str], cached: Path | None, tuning: Tuning) -> Any:
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    features = binding.get_host_cpu_features().flatten()
    if tuning.wide and "+avx512f" in features:
        features += ",-prefer-256-bit"
    machine = binding.Target.from_default_triple().create_target_machine(
        cpu=binding.get_host_cpu_name(), features=features, opt=3
    )
    _resolve_symbols(source)
    code = None if cached is None else read_entry(cached)
    if code is not None:
        engine = binding.create_mcjit_compiler(binding.parse_assembly(""), machine)
        engine.add_object_file(binding.ObjectFileRef.from_data(code))
        engine.finalize_object()
        return engine
    with saying("compiling a kernel ..."):
        return _compiled(source, arguments, cached, tuning, machine)


def _compiled(
    source: str, arguments: Mapping[str, str], cached: Path | None, tuning: Tuning, machine: Any
) -> Any:
    """Translate, optimize and keep the object code."""
    from llvmlite import binding

    module = binding.parse_assembly(
        translated(source, arguments, fuse=tuning.fuse, lanes=tuning.lanes)
    )
    module.verify()
    options = binding.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = True
    # operations on vectors of lanes wait for nothing that more of them in a row would hide
    options.loop_unrolling = not tuning.lanes
    options.slp_vectorization = tuning.pack
    builder = binding.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    if cached is not None:
        write_entry(cached, machine.emit_object(module))
    engine = binding.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return engine


def _resolve_symbols(source: str) -> None:
    """Make sure that the functions of the C library can be found."""
    from llvmlite import binding

    for name in LIBRARY:
        if f"{name}(" in source and binding.address_of_symbol(name) is None:
            library = _mathematics()
            address = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
            binding.add_symbol(name, address)


@cache
def _mathematics() -> ctypes.CDLL:
    """Return the mathematical part of the C library."""
    with contextlib.suppress(OSError):
        return ctypes.CDLL("libm.so.6")  # to search for it takes two processes
    return ctypes.CDLL(ctypes.util.find_library("m") or "msvcrt")
