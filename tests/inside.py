"""Places inside JSON documents: the paths to everything below a value, and what is there."""

import copy
from collections.abc import Iterator
from typing import Any

Path = tuple[Any, ...]


def places(value: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the path to a value and to everything below it."""
    yield path
    inner = value.items() if isinstance(value, dict) else ()
    for key, x in enumerate(value) if isinstance(value, list) else inner:
        yield from places(x, (*path, key))


def texts(value: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the path to every string below a value, after ``path``."""
    yield from (path + x for x in places(value) if isinstance(at(value, x), str))


def at(value: Any, path: Path) -> Any:
    """Return what is at a place."""
    for key in path:
        value = value[key]
    return value


def put(value: Any, path: Path, new: Any) -> Any:
    """Put something into a place, and return the whole."""
    if not path:
        return new
    at(value, path[:-1])[path[-1]] = new
    return value


def changed(value: Any, path: Path, new: Any) -> Any:
    """Return a copy with something else at a place."""
    return put(copy.deepcopy(value), path, new)
