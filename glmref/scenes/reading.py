"""Read scene files strictly: what is wrong is said in one sentence that names the line."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from tomllib import TOMLDecodeError
from typing import Any

from ..catalogue.files import table_path, tables_of
from ..catalogue.lookup import document, is_broken, is_shipped
from ..catalogue.lookup import names as method_names
from ..catalogue.lookup import path_of as method_path
from ..catalogue.strict_json import shown
from ..catalogue.strict_toml import loads
from ..errors import DataError, UsageError, did_you_mean
from ..measure.peers import NAMES
from ..problems import problem as build
from ..problems.formula import Formula
from ..problems.table import OWN, from_table
from ..system.arguments import unknown_key
from ..system.files import named_in, read_bytes, read_text
from .model import ANSWERS, ASK, FORMAT, JUDGING, KINDS, STARTS, Answer, Scene

_TEXTS = ("format", "name", "title", "question")
_KEYS = (
    *("$schema", *_TEXTS),
    *("problem", "methods", "classes", "h", "steps", "t_end", "ask", "answer", "repeats", "budget"),
    *("start", "renew", "peers", "tolerances", "quick"),
)
_QUICK = (
    "title",
    "question",
    "methods",
    "classes",
    "h",
    "steps",
    "t_end",
    "ask",
    "repeats",
    "budget",
    "peers",
)
_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
_EXPRESSION = re.compile(r"[0-9eE+\-*/(). pisqrt]+")
MAX_BYTES = 200_000
#: Characters of a title or a question, and of a name, which becomes that of a file.
MAX_TEXT, MAX_NAME = 2_000, 100
MOST_LISTED = 40  # words in a sentence on what is none of them
#: Entries of a list, and runs of a scene: the largest shipped one has some hundred.
MOST_ENTRIES, MOST_TASKS = 1_000, 100_000
MOST_STEPS = 10**9
#: Keys of a range, and how its values may be spaced.
RANGE, SPACING = ("from", "to", "count", "spacing"), ("linear", "log")
#: Characters of a line that can hold a key: patterns are not tried on longer ones.
_LONGEST_LINE = 1_000


def names() -> list[str]:
    """Return names of the shipped scenes, sorted."""
    return tables_of("scene")


def load_scene(name: str | Path, *, quick: bool = False) -> Scene:
    """Load a scene by name or path, ``quick`` with the overrides of its table ``[quick]``.

    Raises
    ------
    UsageError
        For an unknown name or a missing file.
    DataError
        For a file that is not a scene, naming the line.
    """
    return Reader(table_path("scene", str(name))).scene(quick=quick)


def _lines(text: str) -> dict[tuple[str, ...], int]:
    """Map every key path of a TOML document to the line it stands on, from 1.

    Only what scene files use is understood: tables, and keys at the start of a line outside of
    brackets and of multi-line strings. It serves messages, never values.
    """
    found: dict[tuple[str, ...], int] = {}
    table: tuple[str, ...] = ()
    depth, quoted = 0, ""
    for number, line in enumerate(text.splitlines(), start=1):
        stripped = line.strip()
        if not depth and not quoted and len(stripped) <= _LONGEST_LINE:
            header = re.match(r"\[\s*([^\[\]]+?)\s*\]\s*(#.*)?$", stripped)
            if header:
                table = tuple(part.strip().strip("\"'") for part in header[1].split("."))
                found.setdefault(table, number)
                continue
            key = re.match(r"([A-Za-z0-9_.\-]+|\"[^\"]*\"|'[^']*')\s*=", stripped)
            if key:
                parts = key[1].split(".") if key[1][0] not in "\"'" else [key[1].strip("\"'")]
                for k in range(1, len(parts) + 1):
                    found.setdefault((*table, *parts[:k]), number)
        for mark in re.findall(r"\"\"\"|'''|#.*|\"(?:\\.|[^\"\\])*\"|'[^']*'|[\[\]{}]", line):
            if mark in ('"""', "'''"):
                quoted = "" if quoted == mark else quoted or mark
            elif not quoted:
                depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(mark, 0)
    return found


class Reader:
    """Reads one file; every complaint names its line."""

    def __init__(self, path: Path) -> None:
        self.path = path
        text = read_text(path, MAX_BYTES)
        try:
            self.document: dict[str, Any] = loads(text)
        except TOMLDecodeError as error:
            raise DataError(
                f"{path.name}: not TOML: {str(error)[:1].lower()}{str(error)[1:]}"
            ) from None
        except RecursionError:
            raise DataError(
                f"{path.name}: brackets are nested too deep; flatten the file"
            ) from None
        except ValueError as error:  # a whole number of thousands of digits, a date that is none
            line = _line_of_digits(text)
            raise DataError(
                f"{path.name}: line {line}: a value cannot be read "
                f"({str(error).partition(';')[0][:200]}); shorten it"
            ) from None
        self.lines = _lines(text)

    def fail(self, where: tuple[str, ...], sentence: str) -> DataError:
        """Return the error for a key path; the nearest known line is named."""
        line = next(
            (self.lines[where[:k]] for k in range(len(where), 0, -1) if where[:k] in self.lines), 1
        )
        return DataError(f"{self.path.name}: line {line}: {sentence}")

    def must(self, where: tuple[str, ...], what: str, value: Any, hint: str = "") -> DataError:
        """Return the error for a value that is not what it must be."""
        return self.fail(where, f"`{'.'.join(where)}` must be {what}, got {shown(value)}{hint}")

    # --- values -----------------------------------------------------------------------------------

    def number(self, where: tuple[str, ...], value: Any, *, positive: bool = True) -> float:
        """Read a finite number, or an expression such as ``"20*pi"``."""
        result = math.nan
        if isinstance(value, str) and len(value) <= 100 and _EXPRESSION.fullmatch(value):
            result = _evaluated(value)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            with contextlib.suppress(OverflowError):
                result = float(value)
        if not math.isfinite(result) or (positive and result <= 0):
            kind = "positive number" if positive else "number"
            raise self.must(where, f"a {kind} or an expression such as '20*pi'", value)
        return result

    def whole(self, where: tuple[str, ...], value: Any, most: int) -> int:
        """Read a positive whole number."""
        if not isinstance(value, int) or isinstance(value, bool) or not 0 < value <= most:
            raise self.must(where, f"a whole number from 1 to {most}", value)
        return value

    def choice(self, where: tuple[str, ...], value: Any, allowed: Any) -> str:
        """Read one of a few words."""
        if not isinstance(value, str) or value not in allowed:
            hint = did_you_mean(value, allowed, "; ")
            some = list(map(repr, allowed))[:MOST_LISTED]
            listed = ", ".join(some) + (", ..." if len(allowed) > MOST_LISTED else "")
            raise self.must(where, f"one of {listed}", value, hint)
        return value

    def having(self, where: tuple[str, ...], kind: Any) -> list[str]:
        """Return shipped methods of a class or with a property."""
        shipped = [document(name) for name in method_names("methods")]
        self.choice(where, kind, (*sorted({d["class"] for d in shipped}), *KINDS))
        return [d["name"] for d in shipped if kind == d["class"] or d["claims"].get(kind) is True]

    def items(self, where: tuple[str, ...], value: Any) -> Iterator[Any]:
        """Read a list without repetitions, of one entry or more."""
        if not isinstance(value, list) or not value:
            raise self.must(where, "a list with entries", value)
        if len(value) > MOST_ENTRIES:
            raise self.fail(
                where,
                f"`{'.'.join(where)}` has {len(value)} entries and at most {MOST_ENTRIES} are "
                f"read; make several scenes of it",
            )
        for k, item in enumerate(value):
            if item in value[:k]:
                raise self.fail(where, f"`{'.'.join(where)}` holds {shown(item)} twice; delete one")
            yield item

    def range_of(
        self, where: tuple[str, ...], value: Any, spacing: str = "linear"
    ) -> tuple[float, float, str]:
        """Read the ends of a range and how it is spaced, by default as ``spacing`` says."""
        if not isinstance(value, dict):
            raise self.fail(where, f"`{'.'.join(where)}` must be a range {{ from = .., to = .. }}")
        spacing = self.choice((*where, "spacing"), value.get("spacing", spacing), SPACING)
        positive = spacing == "log"
        low, high = (
            self.number((*where, end), value.get(end), positive=positive) for end in ("from", "to")
        )
        return low, high, spacing

    def spread(
        self, where: tuple[str, ...], value: Any, most: int, spacing: str = "linear"
    ) -> tuple[float, ...]:
        """Read a range ``{ from = .., to = .., count = .. }`` and return its values."""
        low, high, spacing = self.range_of(where, value, spacing)
        self.known(where, value, RANGE)
        count = self.whole((*where, "count"), value.get("count"), most)
        steps = max(count - 1, 1)
        return tuple(between(low, high, spacing, k / steps) for k in range(count))

    def known(self, where: tuple[str, ...], table: Mapping[str, Any], allowed: Any) -> None:
        """Refuse keys that mean nothing."""
        for key in table:
            if fault := unknown_key([key], allowed, " here"):
                raise self.fail((*where, key), fault)

    def named(self, where: tuple[str, ...], name: Any) -> Path:
        """Return the file that an entry names, of the folder of this file; see `named_in`."""
        try:
            return named_in(self.path.parent, name, ".".join(where), f"the file {self.path.name}")
        except UsageError as error:
            raise self.fail(where, str(error)) from None

    def method_file(self, where: tuple[str, ...], name: str) -> str:
        """Return the path of a method file: a shipped one, or one of the folder of this file."""
        if is_shipped(Path(name)):
            return name
        self.named(where, name)
        return str(self.path.parent / name)

    # --- the scene --------------------------------------------------------------------------------

    def scene(self, *, quick: bool) -> Scene:
        """Check everything and return the scene."""
        given = self.document
        for key in (x for x in OWN if x in given):
            raise self.fail(
                (key,),
                f"{key!r} belongs to a problem, not to a scene: `glmref compare` takes this file, "
                f"and a scene holds such keys under [problem]",
            )
        self.known((), given, _KEYS)
        for key in (x for x in (*_TEXTS, "ask") if x not in given):
            raise self.fail((), f"the key `{key}` is missing")
        for key in (*_TEXTS, *(x for x in ("$schema",) if x in given)):
            self.text((key,), given[key])
        if given["format"] != FORMAT:
            raise self.must(("format",), repr(FORMAT), given["format"])
        if not _NAME.fullmatch(given["name"]) or len(given["name"]) > MAX_NAME:
            what = f"lower-case words with hyphens, of at most {MAX_NAME} characters"
            raise self.must(("name",), what, given["name"])
        overrides = given.get("quick", {})
        if not isinstance(overrides, dict):
            raise self.fail(("quick",), "`quick` must be a table")
        self.known(("quick",), overrides, _QUICK)
        full = self._checked(given, ())
        merged = {k: v for k, v in given.items() if k not in self._replaced(overrides)} | overrides
        if overrides:
            for key in ("title", "question"):
                if key in overrides:
                    self.text(("quick", key), overrides[key])
            merged["title"] = self._quick_title(merged["title"], overrides)
        quickened = self._checked(merged, ("quick",) if overrides else ())
        return quickened if quick else full

    def text(self, where: tuple[str, ...], value: Any) -> None:
        """Refuse what is not a text with a word in it."""
        if not isinstance(value, str) or not value.strip():
            raise self.must(where, "a text", value)
        if len(value) > MAX_TEXT:
            raise self.fail(
                where, f"`{'.'.join(where)}` has more than {MAX_TEXT} characters; shorten it"
            )

    @staticmethod
    def _quick_title(title: str, overrides: Mapping[str, Any]) -> str:
        """Return the title of a quick run: how far it goes where the scene goes further."""
        horizon = "t_end" in overrides and "title" not in overrides
        to = f", to t = {overrides['t_end']}" if horizon else ""
        return f"{title} (quick run{to})"

    @staticmethod
    def _replaced(overrides: Mapping[str, Any]) -> set[str]:
        """Return the keys that an override makes meaningless: h and steps exclude each other."""
        replaced = set()
        for group in (("h", "steps"), ("methods", "classes")):
            if any(key in overrides for key in group):
                replaced |= set(group)
        return replaced

    def _checked(self, given: Mapping[str, Any], quick: tuple[str, ...]) -> Scene:
        def at(key: str) -> tuple[str, ...]:
            return (*quick, key) if (*quick, key) in self.lines else (key,)

        problem, parameters, definition = self._problem(given)
        ask = tuple(self.choice(at("ask"), x, ASK) for x in self._list(at("ask"), given, "ask"))
        answer = self._answer(given, ask)
        end = given.get("t_end")
        if end is None and "t_end" in given["problem"]:
            end = problem.t_span[1] - problem.t_span[0]
        t_end = self.number(at("t_end"), end)
        h, steps = self._grid(given, t_end, at)
        self._answerable(problem, ask, at("ask"))
        tolerances = tuple(
            self.number(at("tolerances"), x)
            for x in self._list(at("tolerances"), given, "tolerances", empty=True)
        )
        start = given.get("start")
        scene = Scene(
            name=given["name"],
            title=given["title"],
            question=given["question"],
            problem=problem.name,
            parameters=parameters,
            definition=definition,
            methods=self._methods(given, at),
            t_end=t_end,
            h=h,
            steps=steps,
            ask=ask,
            answer=answer,
            repeats=self.whole(at("repeats"), given.get("repeats", 3), 1000),
            budget=self.number(at("budget"), given.get("budget", 10)),
            start=None if start is None else self.choice(at("start"), start, STARTS),
            renew=self.whole(("renew",), given["renew"], MOST_STEPS) if "renew" in given else 0,
            peers=self._peers(given, tolerances, at),
            tolerances=tolerances,
            file=str(self.path),
        )
        tasks = len(scene.methods) * len(scene.grid) + len(scene.peers) * len(tolerances)
        if tasks > MOST_TASKS:
            raise self.fail(
                at("steps" if steps else "h"),
                f"the scene has {tasks} runs and at most {MOST_TASKS} are planned; make several "
                f"scenes of it",
            )
        return scene

    def _list(
        self, where: tuple[str, ...], given: Mapping[str, Any], key: str, *, empty: bool = False
    ) -> list[Any]:
        if empty and key not in given:
            return []
        return list(self.items(where, given.get(key)))

    def _problem(
        self, given: Mapping[str, Any]
    ) -> tuple[Any, dict[str, Any], dict[str, Any] | None]:
        """Return the problem and its description: parameters of a shipped one, else its table."""
        table = given.get("problem")
        if isinstance(table, dict) and any(key in table for key in ("H", "f", "file")):
            return self._own(table)
        if not isinstance(table, dict) or not isinstance(table.get("name"), str):
            raise self.fail(
                ("problem",), "`problem` must be a table with a `name`, or with `H`, `f` or `file`"
            )
        parameters = {k: v for k, v in table.items() if k != "name"}
        for key, value in parameters.items():
            if not isinstance(value, int | float | str) or isinstance(value, bool):
                raise self.must(("problem", key), "a number or a text such as '3/5'", value)
        try:
            return build(table["name"], **parameters), parameters, None
        except UsageError as error:
            raise self._at_fault(error, list(parameters), "name") from None

    def _own(self, table: dict[str, Any]) -> tuple[Any, dict[str, Any], dict[str, Any]]:
        """Return a problem that the scene itself describes, or a Python file beside it."""
        folder = self.path.resolve().parent
        definition: dict[str, Any] = {**table, "folder": str(folder)}
        if "file" in table:
            definition["sha256"] = self._digest(table["file"])
        try:
            problem = from_table(table, folder)
            json.dumps(definition)
        except UsageError as error:
            raise self._at_fault(error, list(table), "H") from None
        except TypeError:  # a date
            raise self.fail(
                ("problem",), "`problem` holds a value that is no number, text, list or table"
            ) from None
        return problem, {}, definition

    def _digest(self, where: Any) -> str:
        """Return the checksum of the Python file that the scene executes."""
        inside = self.named(("problem", "file"), str(where).rpartition(":")[0])
        try:
            return hashlib.sha256(read_bytes(inside, MAX_BYTES)).hexdigest()
        except (DataError, ValueError):
            what = "like 'mine.py:make' with a file beside the scene"
            raise self.must(("problem", "file"), what, where) from None

    def _at_fault(self, error: UsageError, keys: list[str], otherwise: str) -> DataError:
        """Return the complaint about a problem, at the line of the key that it names."""
        text = str(error)
        bad = next((k for k in keys if f"{k!r}" in text or f"`{k}" in text), "")
        return self.fail(("problem", bad or otherwise), text)

    def _answerable(self, problem: Any, ask: tuple[str, ...], where: tuple[str, ...]) -> None:
        if "energy" in ask and problem.hamiltonian is None:
            raise self.fail(where, f"the problem {problem.name!r} has no energy to ask for")
        nothing = not (problem.quadratic or problem.invariants or problem.hamiltonian)
        for question in ("invariants", "law"):
            if question in ask and nothing:
                raise self.fail(where, f"the problem {problem.name!r} has no invariants to ask for")
        if "orbit" in ask and problem.dimension < 2:
            raise self.fail(where, f"the problem {problem.name!r} has one component and no orbit")
        if set(ask) <= {"picture"}:
            raise self.fail(where, "a picture alone asks nothing; add 'state' or 'energy'")

    def _answer(self, given: Mapping[str, Any], ask: tuple[str, ...]) -> Answer:
        table = given.get("answer")
        if not isinstance(table, dict):
            raise self.fail(("answer",), "`answer` must be a table with a `kind`")
        self.known(("answer",), table, ("kind", "error", "at"))
        kind = self.choice(("answer", "kind"), table.get("kind"), ANSWERS)
        error = self.choice(("answer", "error"), table.get("error", "state"), ("state", "energy"))
        needed = (error,) if kind in JUDGING else ANSWERS[kind]
        for question in needed:
            if question not in ask:
                raise self.fail(
                    ("answer", "kind"), f"the answer {kind!r} needs {question!r} in `ask`; add it"
                )
        return Answer(kind, error, self.number(("answer", "at"), table.get("at", 1e-9)))

    def _grid(
        self, given: Mapping[str, Any], t_end: float, at: Any
    ) -> tuple[tuple[float, ...], tuple[int, ...]]:
        if ("h" in given) == ("steps" in given):
            both = "both" if "h" in given else "neither"
            raise self.fail(at("h"), f"give `h` or `steps`, one of them; the scene has {both}")
        key = "steps" if "steps" in given else "h"
        if isinstance(given[key], dict):  # each h is rounded to a whole number of steps
            values = self.spread(at(key), given[key], MOST_ENTRIES, "log")
            if not all(x > 0 for x in values):
                raise self.fail(at(key), f"`{key}` must be a range of positive numbers")
            numbers = [x if key == "steps" else t_end / x for x in values]
            whole = [round(min(x, 2.0 * MOST_STEPS)) for x in numbers]
            if not all(0 < n <= MOST_STEPS for n in whole):
                raise self.fail(at(key), f"`{key}` must lead to 1 to {MOST_STEPS:,} steps")
            return (), tuple(dict.fromkeys(whole))
        if "steps" in given:
            steps = self._list(at("steps"), given, "steps")
            return (), tuple(self.whole(at("steps"), n, MOST_STEPS) for n in steps)
        sizes = tuple(self.number(at("h"), x) for x in self._list(at("h"), given, "h"))
        for h in sizes:
            n = round(min(t_end / h, 2.0 * MOST_STEPS))  # the quotient may be infinite
            if not 0 < n <= MOST_STEPS or abs(t_end / h - n) > 1e-9 * n:
                raise self.fail(
                    at("h"),
                    f"h = {h:.6g} does not divide t_end = {t_end:.6g} into whole steps; "
                    f"give `steps` instead",
                )
        return sizes, ()

    def _methods(self, given: Mapping[str, Any], at: Any) -> tuple[str, ...]:
        found: list[str] = []
        for name in self._list(at("methods"), given, "methods", empty="classes" in given):
            if not isinstance(name, str):
                raise self.fail(at("methods"), f"a method must be a text, got {shown(name)}")
            found.append(self._method(name, at("methods")))
        for kind in self._list(at("classes"), given, "classes", empty=True):
            found += self.having(at("classes"), kind)
        return tuple(dict.fromkeys(found))

    def _method(self, name: str, where: tuple[str, ...]) -> str:
        """Return a shipped name, or the path of a file, which may lie beside the scene's."""
        if name.endswith(".json"):
            name = self.method_file(where, name)
        try:
            path = method_path(name)
        except UsageError as error:
            raise self.fail(where, str(error)) from None
        if path.suffix != ".json":
            raise self.fail(where, f"the method {shown(name)} is not a file that ends in .json")
        if is_broken(name):
            raise self.fail(
                where,
                f"the method {name!r} is wrong on purpose; to run it all the same give the path "
                f"of its file, {path}",
            )
        return name

    def _peers(
        self, given: Mapping[str, Any], tolerances: tuple[float, ...], at: Any
    ) -> tuple[str, ...]:
        peers = self._list(at("peers"), given, "peers", empty=True)
        if peers and not tolerances:
            raise self.fail(at("peers"), "peers need `tolerances`, a list such as [1e-6, 1e-9]")
        return tuple(self.choice(at("peers"), x, NAMES) for x in peers)


def between(low: float, high: float, spacing: str, u: float) -> float:
    """Return the value at a place of a range, rounded so that it is short in a record."""
    value = low * (high / low) ** u if spacing == "log" else low + (high - low) * u
    return float(f"{value:.12g}")


def _line_of_digits(text: str) -> int:
    """Return the line of the longest whole number of a file."""
    found = max(re.finditer(r"\d[\d_]*", text), key=lambda one: len(one[0]), default=None)
    return 1 if found is None else text.count("\n", 0, found.start()) + 1


def _evaluated(text: str) -> float:
    """Evaluate an arithmetic expression in numbers, pi and sqrt; NaN where it is none."""
    try:
        value = Formula((text,), variables=("y",), shape=())(())
        return float(value)
    except (UsageError, ArithmeticError, ValueError, TypeError):
        return math.nan
