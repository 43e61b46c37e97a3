"""A problem as a table of plain data: in a scene, in a TOML file of its own, or from Python.

The keys are those of :mod:`.from_expressions`, or ``file = "mine.py:make"`` for a Python file with
a function that makes the problem. That file is executed, and only because its name was given.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from importlib.util import module_from_spec, spec_from_file_location
from inspect import signature
from pathlib import Path
from typing import Any

from ..catalogue.strict_toml import loads
from ..errors import DataError, UsageError
from ..system.arguments import unknown_key
from ..system.files import named_in, read_text
from .from_expressions import equation_entries, hamiltonian_entries, time_of
from .model import Problem
from .sundman import time_transformed

#: Keys that say what the equations are; a table has one of them.
OWN = ("H", "f", "file")
#: Keys of the table.
KEYS = (
    *(*OWN, "y0", "coordinates", "momenta", "parameters", "t_end", "t0"),
    *("invariants", "observables", "name", "source", "time", "n", "rate"),
)
#: Bytes of a file that describes a problem.
MAX_BYTES = 200_000


def from_table(table: Mapping[str, Any], folder: Path | None = None) -> Problem:
    """Build the problem that a table of plain data stands for: keys of :data:`KEYS`.

    A path in ``file`` starts in ``folder`` and must stay there; without, it is any path of the
    caller. With ``rate`` all times, ``t_end`` too, are s with dt = rate ds, see :mod:`.sundman`.

    Raises
    ------
    UsageError
        One sentence on the first entry that does not fit, with the key in backquotes.
    """
    if fault := unknown_key(table, KEYS, " in a problem"):
        raise UsageError(fault)
    given = [key for key in OWN if key in table]
    if len(given) != 1:
        raise UsageError(
            f"`problem` must give one of `H`, `f` and `file` (or the `name` of a shipped problem), "
            f"got {' and '.join(given) or 'none'}"
        )
    if "rate" in table:
        plain = {k: v for k, v in table.items() if k != "rate"}
        return time_transformed(from_table(plain, folder), table["rate"])
    rest = {k: v for k, v in table.items() if k not in given}
    if given == ["file"]:
        return from_file(table["file"], folder=folder, **rest)
    if "y0" not in table:
        raise UsageError("`y0` is missing; give the initial value, as in y0 = { q = 1, p = 0 }")
    entries = hamiltonian_entries if given == ["H"] else equation_entries
    return Problem(**entries(table[given[0]], **rest))


def table_of(path: Path) -> dict[str, Any]:
    """Read a TOML file: the table of a problem, or a scene with such a ``[problem]``.

    Raises
    ------
    DataError
        One sentence on what is wrong, with the name of the file.
    """
    text = read_text(path, MAX_BYTES)
    try:
        table = loads(text)
    except (RecursionError, ValueError) as error:
        raise DataError(f"{path.name}: not TOML: {str(error)[:200]}") from None
    table = table.get("problem", table)
    if not isinstance(table, dict):
        raise DataError(f"{path.name}: `problem` must be a table")
    return table


def from_file(
    where: str, *, folder: Path | None = None, parameters: Mapping[str, Any] | None = None,
    **changes: Any,
) -> Problem:  # fmt: skip
    """Execute a Python file and return the problem that one of its functions makes.

    ``where`` is ``"mine.py:make"``: path and name of a function that returns a :class:`Problem`, or
    the table of one, and takes ``parameters`` as keywords. With the ``folder`` of the document that
    names the file it must lie there, see :func:`~glmref.system.files.named_in`. The ``changes``
    replace entries of the problem: ``t_end``, ``t0`` and ``name``.

    Raises
    ------
    UsageError
        For a missing file or function, one that raises, and one that returns no problem.
    """
    path_text, colon, maker = str(where).rpartition(":")
    if not colon or not maker.isidentifier():
        raise UsageError(f"`file` must be like 'mine.py:make', got {str(where)[:100]!r}")
    # without a folder it is the caller's own code that names the file, and not a document
    path = Path(path_text) if folder is None else named_in(folder, path_text, "file")
    if path.suffix != ".py" or not path.is_file():
        raise UsageError(f"`file` names {str(path)[:200]!r}, which is no Python file there")
    spec = spec_from_file_location(f"glmref_user_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # so that functions find their own source
    try:
        spec.loader.exec_module(module)
        make = getattr(module, maker, None)
        if not callable(make):
            raise UsageError(f"`file`: {path.name} has no function {maker!r}")
        try:
            signature(make).bind(**(parameters or {}))
        except TypeError as error:
            raise UsageError(
                f"`file`: {maker} of {path.name} must return a Problem or its table and take no "
                f"argument that `parameters` does not give: {error}"
            ) from None
        made = make(**(parameters or {}))
    except UsageError:
        raise
    except (Exception, SystemExit) as error:  # which would end the command as if it were done
        said = " ".join(str(error).split())[:200]
        raise UsageError(
            f"`file`: {maker} of {path.name} raised {type(error).__name__}: {said}"
        ) from error
    if isinstance(made, Mapping):
        made = from_table({**made, **changes}, path.parent)
    elif isinstance(made, Problem):
        made = _changed(made, changes)
    else:
        raise UsageError(
            f"`file`: {maker} of {path.name} must return a Problem or its table, "
            f"got {type(made).__name__}"
        )
    return made


def _changed(problem: Problem, changes: Mapping[str, Any]) -> Problem:
    """Return a problem of a file with another name or other times."""
    for key in changes:
        if key not in ("t_end", "t0", "name"):
            raise UsageError(f"`{key}` does not go with `file`; the function of the file gives it")
    begin = time_of(changes.get("t0", problem.t_span[0]), "t0")
    end = time_of(changes.get("t_end", problem.t_span[1]), "t_end")
    name = changes.get("name", problem.name)
    return replace(problem, t_span=(begin, end), name=name, y0=problem.initial)
