"""Find data files: shipped ones by name, the user's by path; read them as JSON, no more."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, cast

from ..errors import DataError, UsageError
from ..system.arguments import no_such, one_of
from ..system.files import given_file, read_text
from .keys import is_plain
from .strict_json import MAX_BYTES, Double, parse_json, read_json, shown
from .strict_toml import loads

EXAMPLE = 'write {"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"], "order": 2}'
FOLDERS = ("methods", "broken")


@cache
def data_root() -> Path:
    """Return the folder that holds methods/, broken/, schema/ ...: in a clone or in a wheel.

    Raises
    ------
    DataError
        When neither is there, that is, when the installation is incomplete.
    """
    package = Path(__file__).parents[1]
    for candidate in (package / "data", package.parent / "data"):
        if (candidate / "methods").is_dir():
            return candidate
    raise DataError(f"the data folder is missing beside {package}; install glmref again")


@cache
def _index(root: Path) -> Mapping[str, tuple[str, str]]:
    """Name -> its folder of :data:`FOLDERS` and its path.

    Text, since this goes before the first answer of every process.
    """
    found: dict[str, tuple[str, str]] = {}
    for folder in FOLDERS:
        for place, _, inside in sorted(os.walk(root / folder)):
            for file in sorted(inside):
                if file.endswith(".json"):
                    found[file[:-5]] = folder, os.path.join(place, file)
    return found


def names(folder: str = "methods") -> list[str]:
    """Return names of the shipped files, sorted.

    Parameters
    ----------
    folder : {"methods", "broken", "all"}
        The methods; the files that are wrong on purpose, which are never listed unless asked for;
        or both.

    Raises
    ------
    UsageError
        For another word.
    """
    one_of("folder", folder, (*FOLDERS, "all"))
    return sorted(k for k, (where, _) in _index(data_root()).items() if folder in ("all", where))


def is_broken(name: str | Path) -> bool:
    """Return whether this is the name of a shipped file that is wrong on purpose."""
    return _index(data_root()).get(str(name), ("",))[0] == "broken"


def path_of(name: str | Path) -> Path:
    """Return the path of a shipped method's file, or of the user's file.

    Raises
    ------
    UsageError
        When there is neither, naming the nearest shipped names.
    """
    if not isinstance(name, str | Path):
        raise UsageError(f"`name` must be a name or a file, got {shown(name)}")
    text = str(name)
    known = _index(data_root())
    if text in known:
        return Path(known[text][1])
    found = given_file(text, ".json", shown(text), "a method file or a name of `glmref list`")
    if found is not None:
        return found
    # what is wrong on purpose is not proposed to somebody who did not ask for it
    raise no_such("method", text, names("methods"), "see `glmref list`")


def tables_of(kind: str) -> list[str]:
    """Return names of the shipped files in TOML of a kind, ``"scene"`` or ``"campaign"``."""
    return sorted(path.stem for path in (data_root() / f"{kind}s").glob("*.toml"))


def table_path(kind: str, name: str) -> Path:
    """Return the path of a shipped scene or campaign, or of the user's file.

    Raises
    ------
    UsageError
        When there is neither, naming the nearest shipped names.
    """
    shipped = tables_of(kind)
    if name in shipped:
        return data_root() / f"{kind}s" / f"{name}.toml"
    found = given_file(name, ".toml", shown(name), f"a {kind} file or one of {', '.join(shipped)}")
    if found is None:
        raise no_such(kind, name, shipped)
    return found


def document(name: str | Path) -> dict[str, Any]:
    """Return the document of a method file, checked for syntax only.

    A file of the format is strict JSON; one in the plain dialect may be TOML and have floats.
    """
    path = path_of(name)
    if path.suffix == ".toml":
        return plain_document(read_text(path, MAX_BYTES), path.name)
    value = parse_json(read_text(path, MAX_BYTES), path.name, Double)
    if not isinstance(value, dict):
        raise DataError(f"{path.name}: a method file must hold one JSON object, got {shown(value)}")
    return value if is_plain(value) else cast("dict[str, Any]", read_json(path))


def plain_document(text: str, where: str) -> dict[str, Any]:
    """Return the document in a text of JSON or TOML, whatever its dialect.

    Raises
    ------
    DataError
        For a text that is neither, or holds no object.
    """
    text = text.removeprefix("\ufeff")  # a mark that some shells and editors write first
    if not text.strip():
        raise DataError(f"{where} is empty; {EXAMPLE}")
    if text.lstrip()[:1] in "{[" and not where.endswith(".toml"):
        value = parse_json(text, where, Double)
    else:
        try:
            value = loads(text, parse_float=Double)
        except (ValueError, RecursionError) as error:
            said = str(error).splitlines()[0] if str(error) else "brackets nested too deep"
            raise DataError(
                f"{where} is neither a JSON object nor TOML ({said}); {EXAMPLE}"
            ) from None
    if not isinstance(value, dict):
        raise DataError(f"{where} must hold one object with A and b")
    return value
