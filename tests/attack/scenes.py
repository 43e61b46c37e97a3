"""Mutated scene files: each is read, or refused with a sentence that names the file and the place.

A shipped scene is mutated once to four times: bytes flipped, lines deleted, doubled, swapped or
cut, keys renamed, values replaced by hostile ones. What is read is planned as well.
"""

import copy
import json
import math
import random
import re
import tempfile
import tomllib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from glmref import names, problems
from glmref.catalogue.lookup import data_root
from glmref.errors import DataError
from glmref.scenes import load_scene, plan

CASES = "scenes"
COUNT = 2000
SECONDS = 3.0

VALUES = (
    "0", "-1", "1e308", "1e-320", "1e999", "nan", "inf", "-inf", "true", "[]", "{}", "''", '""',
    "9" * 400, "9" * 5000, "1979-05-27", "1979-05-27T07:32:00Z", "07:32:00", "0x7fffffffffffffff",
    "0b1", "1_000", '"9**9**9**9"', '"1e400"', '"pi/0"', '"sqrt(-1)"', '"' + "(" * 5000 + '"',
    '"' + "-" * 20000 + '1"', '"' + "1+" * 20000 + '1"', '"__import__(1)"', '"1/3"', '"0/0"',
    '"\\u0000"', '"\\u001b]0;x\\u0007"', '"\\u202e"', '"<script>alert(1)</script>"',
    '"=cmd|\' /C calc\'!A0"', '"../../../etc/passwd"', '"/dev/zero"', '"/dev/stdin"', '"."', '"/"',
    '"rk4.json"', '"x.json"', '"' + "a" * 5000 + '"', '"' + "a-" * 3000 + 'a"',
    "[" * 200 + "]" * 200, "[" * 20000, "[[1], [2]]", "[1, 1]", '["rk4", "rk4"]', '["rk4", 1]',
    "[" + ",".join(str(n) for n in range(1, 30000)) + "]", "{ x = { x = { x = 1 } } }",
    '{ name = "fput", sites = 1000000000 }', '{ name = "kepler", eccentricity = "9/9" }',
    '{ name = "kepler", self = 1 }', '{ name = "kepler", "" = 1 }', '{ name = ["kepler"] }',
    '{ name = "kepler", eccentricity = "1e-999999999" }', '{ name = "fput", sites = 0 }',
    '"""\n[ x ]\n"""', "'''\n[" + " " * 2000 + "\n'''", '["state", "state"]', '["law", "orbit"]',
)  # fmt: skip
KEYS = (
    "name", "title", "question", "methods", "classes", "h", "steps", "t_end", "ask", "answer",
    "repeats", "budget", "start", "peers", "tolerances", "quick", "problem", "problem.name",
    "answer.kind", "answer.at", "answer.error", "format", "''", '"\\u001b"', "__class__", "a.b.c",
)  # fmt: skip

#: Values in place of those of a sound document.
OBJECTS: tuple[Any, ...] = (
    0, 1, -1, 2, 10**9, 10**18, 10**400, 0.5, -0.0, 1e-320, 1e308, math.inf, math.nan, True, "",
    "x", "1", "pi", "20*pi", "1/0", "9**9**9", "1e400", "-(-(-1))", "(" * 99, "sqrt(sqrt(2))",
    "../x", "/dev/zero", "rk4", "gauss-2", "gauss-5", "forest-ruth", "x.json", "kepler", "pendulum",
    "fput", "n-body", "scipy-dop853", "explicit", "symplectic", "g-symplectic", "lost", "fastest",
    "law", "orbit", "state", "energy", "picture", "zero", "enhanced", "\x1b]0;x\x07", "\u202e", "=1+1",
    "<b>", "\0", "a" * 5000, [], {}, [[]], [{}], ["state"], ["law", "state"], ["rk4", "euler"],
    [1, 2, 4], [0.1], ["pi/10"], list(range(1, 2000)), [1] * 3, {"name": "kepler"},
    {"name": "pendulum", "g": "1/2"}, {"name": "fput", "sites": 10**9},
    {"name": "fput", "sites": 10**5}, {"name": "fput", "sites": -1}, {"name": "kepler", "q": 1},
    {"name": "kepler", "eccentricity": "2"}, {"name": "kepler", "eccentricity": "1e-200"},
    {"name": "heat", "cells": 10**7}, {"kind": "fastest", "at": 0}, {"kind": "lost"},
    {"kind": "order"}, {"kind": "accurate", "at": "1e-3", "error": "energy"},
)  # fmt: skip

Mutation = Callable[[random.Random, str], str]


def flip(chance: random.Random, text: str) -> str:
    content = bytearray(text.encode("utf-8", "surrogateescape"))
    for _ in range(chance.randrange(1, 4)):
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    return bytes(content).decode("utf-8", "surrogateescape")


def replaced(chance: random.Random, text: str, change: Callable[[str, str], str]) -> str:
    """The text with one of its assignments changed."""
    lines = text.split("\n")
    at = [k for k, line in enumerate(lines) if "=" in line]
    if at:
        k = chance.choice(at)
        key, _, value = lines[k].partition("=")
        lines[k] = change(key, value)
    return "\n".join(lines)


def replace_value(chance: random.Random, text: str) -> str:
    return replaced(chance, text, lambda key, _: f"{key}= {chance.choice(VALUES)}")


def replace_key(chance: random.Random, text: str) -> str:
    return replaced(chance, text, lambda _, value: f"{chance.choice(KEYS)} ={value}")


def insert(chance: random.Random, text: str) -> str:
    lines = text.split("\n")
    line = f"{chance.choice(KEYS)} = {chance.choice(VALUES)}"
    if chance.random() < 0.2:
        line = chance.choice(["[quick]", "[problem]", "[[answer]]", "[a.b]", "[ ", "\0", "\ufeff"])
    lines.insert(chance.randrange(len(lines) + 1), line)
    return "\n".join(lines)


def disorder(chance: random.Random, text: str) -> str:
    lines = text.split("\n")
    k = chance.randrange(len(lines))
    kind = chance.randrange(4)
    if kind == 0:
        del lines[k]
    elif kind == 1:
        lines.insert(k, lines[chance.randrange(len(lines))])
    elif kind == 2:
        chance.shuffle(lines)
    else:
        lines = lines[:k]
    return "\n".join(lines)


def change(chance: random.Random, text: str) -> str:
    """Change a value, drop it, or add one, in the document itself: it stays TOML."""
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError):
        return text
    for _ in range(chance.choice([1, 1, 2, 3])):
        tables = [document, *(x for x in document.values() if isinstance(x, dict))]
        table = chance.choice(tables)
        key = chance.choice([*table, *KEYS[:23], "kind", "at", "eccentricity", "sites"])
        if chance.random() < 0.15:
            table.pop(key, None)
        elif isinstance(table.get(key), list) and table[key] and chance.random() < 0.5:
            table[key][chance.randrange(len(table[key]))] = chance.choice(OBJECTS)
        else:
            alike = [x for x in OBJECTS if type(x) is type(table.get(key))]
            chosen = alike if alike and chance.random() < 0.7 else OBJECTS
            table[key] = copy.deepcopy(chance.choice(chosen))
    return toml(document)


#: Values that a scene may well have, by key; at the edge of what it can mean.
LIKELY: dict[str, tuple[Any, ...]] = {
    "t_end": (0.1, 1, "pi", "20*pi", 1e-3, -1, 0.3, 1e6, 1e-300, "1/3"),
    "h": ([0.1], [0.1, 0.05], ["pi/10"], [-0.1], [1e-9], [1e300], [0.3, 0.3000000001], [5e-324]),
    "steps": ([1], [1, 2, 3], [10, 7], [10**6], [2**62], [100, 50, 25], [0], [7] * 2),
    "repeats": (1, 2, 100, 10**6), "budget": (1e-9, 0.1, 10**6, 1e300), "start": ("zero", "enhanced"),
    "ask": (["state"], ["energy"], ["state", "energy", "orbit"], ["law"], ["order"], ["picture"]),
    "tolerances": ([1e-3], [1e-3, 1e-16], [1e-300], [0.5, 2.0]), "classes": (["explicit"], ["symplectic"]),
    "kind": ("fastest", "lost", "ended", "order", "law", "accurate", "conserved"), "at": (1e-6, "1e-300", 1),
    "error": ("state", "energy"), "peers": (["scipy-dop853"], []), "eccentricity": ("1/2", "0", "999/1000", "1"),
    "sites": (2, 3, 8, 64, 1), "title": ("Another title",), "question": ("Which one?",),
}  # fmt: skip


def likely(chance: random.Random, text: str) -> str:
    """Other methods, problem, step sizes, times, answers: most of it can be planned."""
    document = tomllib.loads(text)
    for _ in range(chance.choice([1, 2, 3, 5])):
        table = chance.choice([document, *(x for x in document.values() if isinstance(x, dict))])
        keys = [x for x in table if x in LIKELY or x in ("methods", "name")]
        if table is document:
            keys += ["methods", "h", "steps", "t_end", "repeats", "budget", "start", "ask"]
        key = chance.choice(keys or ["eccentricity"])
        if key == "methods":
            found = chance.choices(sorted(names()), k=chance.choice([1, 2, 5, 40]))
            table[key] = sorted(set(found))
        elif key == "name" and table is not document:
            table.clear()
            table[key] = chance.choice(problems.names())
        elif key in LIKELY:
            table[key] = copy.deepcopy(chance.choice(LIKELY[key]))
            table.pop({"h": "steps", "steps": "h"}.get(key, ""), None)
    return toml(document)


def toml(document: dict[str, Any]) -> str:
    """A document as TOML, values that are tables on one line."""
    return "".join(f"{json.dumps(key)} = {_value(x)}\n" for key, x in document.items())


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_value(x)}" for k, x in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def cut(chance: random.Random, text: str) -> str:
    return text[: chance.randrange(len(text) + 1)]


def enlarge(chance: random.Random, text: str) -> str:
    k = chance.randrange(len(text) + 1)
    piece = chance.choice(["#", " ", "\n", "a.", "[", "x=1\n", "\\", '"', "'''", "é", "\t"])
    return text[:k] + piece * chance.choice([10, 1000, 50_000, 150_000]) + text[k:]


MUTATIONS: tuple[Mutation, ...] = (
    replace_value, replace_value, replace_key, insert, insert, disorder, flip, cut, enlarge,
)  # fmt: skip


def mutated(chance: random.Random) -> bytes:
    """A shipped scene, mutated."""
    paths = sorted((data_root() / "scenes").glob("*.toml"))
    text = chance.choice(paths).read_text(encoding="utf-8")
    how = chance.random()
    if how < 0.4:
        return likely(chance, text).encode("utf-8", "surrogateescape")
    if how < 0.8:
        return change(chance, text).encode("utf-8", "surrogateescape")
    for _ in range(chance.choice([1, 1, 1, 2, 4])):
        text = chance.choice(MUTATIONS)(chance, text or "x")
    return text.encode("utf-8", "surrogateescape")


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Read and plan one mutated scene."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "mutated.toml"
        path.write_bytes(mutated(draw))
        try:
            scene = load_scene(path)
        except DataError as error:
            text = str(error)
            named = text.startswith(f"{path.name}: ")
            placed = re.search(r"line \d|column \d|byte \d|bytes|end of document|nested", text)
            if named and placed:
                raise
            return "refused", [f"file or place is missing: {text[:200]!r}"]
        plan(scene)
    return "planned", ()
