"""What one process keeps between runs: methods and problems by name, steppers, formulas.

Methods and problems are immutable and compared by identity, so that a run with the same objects, or
with the same names, finds everything that the one before it has made. A file is read again when it
has changed. A user's Python function is recorded again at every run (:mod:`..problems.tracing`):
what it computes may have changed with what it reads, and then it is another kernel.
"""

from __future__ import annotations

import hashlib
import sys
from collections import OrderedDict
from collections.abc import Callable, Hashable
from contextlib import suppress
from dataclasses import asdict, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..catalogue.lookup import load, path_of
from ..method import Method
from ..method.stage_order import StageBlock
from ..problems import problem
from ..problems.formula import Formula
from ..problems.model import Problem
from ..problems.tracing import Recorded, recorded, traced
from ..problems.user_functions import NoValue, UserFunction
from ..system.cache import cache_folder, read_value, sources, write_value
from .forms import Rows, StepForm
from .reference import stepper
from .sweep import step_form

T = TypeVar("T")

_MOST = 256  # objects of each kind
_MOST_FUNCTIONS = 64

#: How the arguments of the functions of a problem are called in a formula.
_ARGUMENTS = {"f": ("t", "y"), "dq": ("p",), "dp": ("q",), "force": ("q",)}


def problem_of(name: str) -> Problem:
    """Return a shipped problem with its default parameters, or one of a file."""
    return problem(name) if name.endswith(".toml") else _shipped(name)


_shipped = lru_cache(maxsize=_MOST)(problem)


def method_of(name: str | Path) -> Method:
    """Return a method by name or file, read again where the file has changed."""
    path = path_of(name)
    about = path.stat()
    return _read(path, about.st_mtime_ns, about.st_size)


@lru_cache(maxsize=_MOST)
def _read(path: Path, changed: int, size: int) -> Method:
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    method = load(path)
    if len(_origins) >= 2 * _MOST:
        _origins.clear()
    _origins[id(method)] = method, digest
    return method


#: Methods that came from a file, by identity -> the method and the checksum of its file.
_origins: dict[int, tuple[Method, str]] = {}


@lru_cache(maxsize=_MOST)
def form_of_method(method: Method, form: str) -> StepForm:
    """Return the coefficients a kernel steps with, kept on disk for a method that came from a file.

    Roundings for which a quadratic form is conserved are searched for, which takes up to a second;
    what was found depends on the file and on the code alone, and both are in the name of the entry.
    """
    known, digest = _origins.get(id(method), (None, ""))
    if known is not method:
        return step_form(method, form)
    compute: Callable[[], StepForm] = lambda: step_form(method, form)  # noqa: E731
    return recalled("form", f"{digest} {form}", compute, _form_read, asdict)


class ByIdentity:
    """Results kept by the identity of what they were made from, which is kept with them."""

    def __init__(self) -> None:
        self.known: dict[tuple[Any, ...], tuple[Any, Any]] = {}

    def __call__(self, given: tuple[Any, ...], rest: Hashable, compute: Callable[[], T]) -> T:
        """Return what ``compute`` gave for these objects and this."""
        key = (*map(id, given), rest)
        if key not in self.known:
            if len(self.known) >= _MOST:
                self.known.clear()
            self.known[key] = given, compute()
        return self.known[key][1]


def recalled(
    kind: str,
    key: str,
    compute: Callable[[], T],
    read: Callable[[Any], T],
    write: Callable[[T], Any],
) -> T:
    """Return what was computed, by this process or by one before it.

    ``kind`` is part of the name of its file in the cache; ``key`` is everything it depends on
    besides the modules of :func:`_code`; ``read`` and ``write`` turn from and to what JSON holds.
    """
    folder = cache_folder()
    if folder is None:
        return compute()
    name = hashlib.sha256(f"{key} {_code()}".encode()).hexdigest()[:24]
    path = folder / f"glmref_{kind}_{name}.json"
    with suppress(ValueError, KeyError, TypeError):  # none
        return read(read_value(path))
    found = compute()
    write_value(path, write(found))
    return found


def _form_read(fields: dict[str, Any]) -> StepForm:
    """Return a form as JSON holds it."""
    fields["blocks"] = [StageBlock(tuple(x["stages"]), x["implicit"]) for x in fields["blocks"]]
    rows = [Rows(**{k: _tuples(v) for k, v in x.items()}) for x in fields["components"]]
    return StepForm(**{k: _tuples(v) for k, v in {**fields, "components": rows}.items()})


def _tuples(value: Any) -> Any:
    return tuple(_tuples(x) for x in value) if isinstance(value, list) else value


@cache
def _code() -> str:
    """Return what is recalled depends on: modules, and what they compute with."""
    # exact numbers are computed by a library that only glmref.exact imports
    flint = getattr(sys.modules.get("flint"), "__version__", "")
    code = sources("exact", "method", "problems", "engine")
    return f"{flint} {np.__version__} {sys.version} {code}"


#: The stepper in double precision: it keeps rounded coefficients and nothing of a run.
stepper_of = lru_cache(maxsize=_MOST)(stepper)


#: Problem, by identity -> the problem, what its functions were seen to do, and it in formulas.
_formulas: OrderedDict[int, tuple[Problem, dict[str, Recorded], Problem]] = OrderedDict()


def expressed(problem: Problem) -> Problem:
    """Return a problem in formulas where its right-hand side is Python that can be recorded.

    It is the same object as long as the functions compute the same; else the problem itself.
    """
    given = {
        key: value
        for key in _ARGUMENTS
        if isinstance(value := getattr(problem, key), UserFunction)
        and not (key == "dp" and value is problem.force)
    }
    if not given:
        return problem
    seen: dict[str, Recorded] = {}
    for key, function in given.items():
        found = recorded(function.function, _ARGUMENTS[key], function.size)
        if found is None:
            return problem
        seen[key] = found
    known = _formulas.get(id(problem))
    if known is not None and known[0] is problem and known[1] == seen:
        _formulas.move_to_end(id(problem))
        return known[2]
    result = _in_formulas(problem, given, seen)
    _formulas[id(problem)] = problem, seen, result
    while len(_formulas) > _MOST_FUNCTIONS:
        _formulas.popitem(last=False)
    return result


def _in_formulas(
    problem: Problem, given: dict[str, UserFunction], seen: dict[str, Recorded]
) -> Problem:
    if isinstance(problem.jacobian, UserFunction):
        # the formula is differentiated instead; a function that is none is refused all the same
        with suppress(NoValue):
            problem.jacobian(float(problem.t_span[0]), np.array(problem.y0, dtype=float))
    t, y, m = float(problem.t_span[0]), np.array(problem.y0, dtype=float), problem.dimension // 2
    states = [(t, y), (t + 0.125, y * 1.0625 + 0.03125), (t - 0.25, y * 0.96875 - 0.0625)]
    formulas: dict[str, Any] = {}
    for key, function in given.items():
        points: dict[str, list[tuple[Any, ...]]] = {
            "f": [(time, state) for time, state in states],
            "dq": [(state[m:],) for _, state in states],
            "dp": [(state[:m],) for _, state in states],
        }
        at = points["dp" if key == "force" else key]
        found = traced(function.function, _ARGUMENTS[key], at, seen[key])
        if found is None:
            return problem
        formulas[key] = found
    # what a problem puts together from its parts, it puts together again
    parts: dict[str, Any] = dict.fromkeys(("f", "dq", "dp", "jacobian")) | formulas
    if problem.force is None:
        parts |= {key: getattr(problem, key) for key in ("dq", "dp") if key not in formulas}
    if not problem.separable or isinstance(problem.f, Formula):
        parts["f"] = formulas.get("f", problem.f)
    return replace(problem, **parts, y0=problem.initial)
