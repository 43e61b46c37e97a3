"""Rows of ``refusals.toml`` and ``values.toml``: what is refused, and what expressions are worth."""

import re
import shlex
import tomllib
from functools import cache, reduce
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from glmref import errors
from tests.build import refused

ROWS, WORTH = (
    tomllib.loads(Path(__file__).with_name(f"{x}.toml").read_text(encoding="utf-8"))
    for x in ("refusals", "values")
)


def _filled(given: Any, values: list[Any]) -> Any:
    """Return what is given with @1, @2, .. replaced by the values of a row, and @none by None."""
    if isinstance(given, list):
        return [_filled(x, values) for x in given]
    if isinstance(given, dict):
        return {key: _filled(x, values) for key, x in given.items()}
    if given == "@none":
        return None
    if isinstance(given, str) and re.fullmatch("@[1-9]", given):
        return _filled(values[int(given[1:]) - 1], [])
    return given


def _named(path: str) -> Any:
    """Return a module, or what it has, a function of a class too, by its whole name."""
    module, _, name = path.partition(":")
    return reduce(getattr, filter(None, name.split(".")), import_module(module))


def _error(group: dict[str, Any]) -> type[Exception]:
    name = group.get("error", "UsageError")
    return _named(name if ":" in name else f"glmref.errors:{name}")


CALLS = [
    pytest.param(group, row[:-1], row[-1], engine, id=f"{group['about']}, {k}{engine}")
    for group in ROWS["call"]
    for k, row in enumerate(group["rows"], 1)
    for engine in group.get("engines", [""])
]


@pytest.mark.parametrize(("group", "values", "words", "engine"), CALLS)
def test_a_call_is_refused_in_one_sentence(group, values, words, engine):
    call = _named(group["call"])
    arguments = _filled(group.get("arguments", []), values)
    keywords = _filled(group.get("defaults", {}), []) | _filled(group.get("keywords", {}), values)
    if "made" in group:  # the first argument is made by this
        arguments[0] = _named(group["made"])(**arguments[0])
    if "then" in group:  # what is made is called
        call, arguments = call(*arguments), group["then"]
    if engine:
        keywords["engine"] = engine
    sentence = refused(_error(group), re.escape(words), call, *arguments, **keywords)
    assert sentence.startswith(group.get("begins", ""))
    assert sentence == words or not group.get("whole", False)


EXPRESSIONS = [
    pytest.param(
        group, *(x.replace("@", value) for x in (text, words)), id=f"{group['about']}, {k}, {n}"
    )
    for group in ROWS["expression"]
    for k, (text, words, *values) in enumerate(group["rows"], 1)
    for n, value in enumerate(values[0] if values else ["@"], 1)
]


@cache
def _names() -> dict[str, Any]:
    """Return what the expressions of both files may name."""
    return {name: _named(path) for x in (ROWS, WORTH) for name, path in x["names"].items()}


@pytest.mark.parametrize(("group", "text", "words"), EXPRESSIONS)
def test_an_expression_is_refused_in_one_sentence(group, text, words):
    refused(_error(group), re.escape(words), eval, text, dict(_names()))


VALUES = [
    pytest.param(group.get("of", "@").replace("@", text), value, id=f"{group['about']}, {k}")
    for group in WORTH["value"]
    for k, (text, value) in enumerate(group["rows"], 1)
]


@pytest.mark.parametrize(("text", "value"), VALUES)
def test_an_expression_has_its_value(text, value):
    found, known = (eval(x, dict(_names())) for x in (text, value))
    assert found == known


FILES = [
    pytest.param(group, *row, id=f"{group['about']}, {k}")
    for group in ROWS["file"]
    for k, row in enumerate(group["rows"], 1)
]


@pytest.mark.parametrize(("group", "old", "new", "words"), FILES)
def test_a_file_is_refused_in_one_sentence(group, old, new, words, tmp_path):
    text, path = group.get("text", ""), tmp_path / group["name"]
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    sentence = refused(errors.DataError, re.escape(words), _named(group["call"]), path)
    assert sentence.startswith(group["begins"]) and len(sentence) < 900


@pytest.mark.parametrize(("line", "words"), ROWS["command"]["rows"])
def test_a_command_line_is_refused_with_2_and_one_sentence(line, words, cli):
    out, err = cli(*shlex.split(line), code=2)
    assert words in err and err.startswith("glmref: ") and (out, err.count("\n")) == ("", 1)
    assert err[:-1].isprintable() and len(err) < 1000
