"""Mutated sources and plain tableaux: what ``glmref audit`` and ``glmref check -`` read.

Sources are the small pieces of every syntax of the tests of the audit, and the documents of a plain
tableau those of every kind of method. A source gives records, a document verdicts or one sentence;
what is said to hold of a tableau is held against floating point.
"""

import contextlib
import io
import json
import random
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from unittest.mock import patch

from glmref.audit.sources import audit
from glmref.cli import main as glmref
from tests.build import source

from .files import SENTENCE
from .texts import mutated

CASES = "sources and tableaux"
COUNT = 2000
SECONDS = 10.0
SOURCES = {
    "petsc": source("petsc.c") + source("glee.c"), "julia": source("julia.jl"),
    "": source("python.txt"),
    "principia": source("principia.hpp"),
    "odeint": source("odeint.hpp"),
}  # fmt: skip
#: What stands in a source where it should not.
SPLINTERS = (
    "(" * 300, "[" * 5000, "{" * 300, "9" * 400, "1e999999999", "1e-999999", "0x", "1.0.0", "--", "/0", "%", '"',
    "'''", "/*", "*/", "//", "#", "!", "\\\n", "&\n", "\0", "\u202e", "\x1b[2J", "sqrt(-1)", "sqrt(" * 60, "2**",
    "10**10**10", "9^9^9^9", "A[10^9]", "range(10**12)", "zeros(10**7, 10**7)", "n = 10**9\n", "while True:\n",
    "import os\n", "__import__('os').system('true')", "[0]*10**10", "1//0", "NaN", "Inf", "einsum(", ",,", ";;",
    "for i in range(10**9): b[i] = 1\n", "\n" * 50, "\t", "SUNTRUE", "None", "lambda: 0", "2000000000",
)  # fmt: skip
DOCUMENTS: tuple[dict[str, Any], ...] = (
    {"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"], "order": 2},
    {"A": [[0, 0], [0.5, 0]], "b": [0, 1], "c": [0, 0.5], "order": 2, "embedded": {"b": [1, 0], "order": 1}},
    {"A": [[0.25, -0.0386751346], [0.5386751346, 0.25]], "b": [0.5, 0.5], "order": 4, "digits": 10},
    {"parts": [{"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"]},
               {"A": [["1/2", 0], ["1/2", 0]], "b": ["1/2", "1/2"]}], "order": 2},
    {"A": [[0, 0], ["1/2", 0]], "b": ["1/2", 0], "b_prime": ["1/2", "1/2"], "c": [0, 1], "order": 2},
    {"alpha": [[0, 0], [1, 0]], "gamma": [["1/2", 0], ["-1", "1/2"]], "b": ["1/2", "1/2"], "order": 2},
    {"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"], "dense": [[1, "-1/2"], [0, "1/2"]], "order": 2},
)  # fmt: skip


def _splintered(draw: random.Random, text: str) -> str:
    """A source with splinters, lost and doubled pieces."""
    for _ in range(draw.choice((1, 1, 2, 3))):
        at, to = sorted((draw.randrange(len(text) + 1), draw.randrange(len(text) + 1)))
        how = draw.randrange(5)
        if how == 0:
            text = text[:at] + draw.choice(SPLINTERS) + text[at:]
        elif how == 1:
            text = text[:at] + text[min(to, at + 40) :]
        elif how == 2:
            text = text[:at] + text[at : at + 200] * 2 + text[at + 200 :]
        elif how == 3 and text:
            text = text[:at] + draw.choice("0123456789+-*/()[]{}., \n=") + text[at + 1 :]
        else:
            digits = [k for k, x in enumerate(text) if x.isdigit()]
            if digits:
                k = draw.choice(digits)
                text = text[:k] + draw.choice(SPLINTERS) + text[k + 1 :]
    return text


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Audit one mutated source, or check one mutated document."""
    if draw.random() < 0.5:
        return _checked(draw)
    form = draw.choice(list(SOURCES))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / ("x" if form else "x.py")
        text = _splintered(draw, SOURCES[form])
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        search = draw.random() < 0.2
        records = list(audit(path, form, search=search, compare=False))
    wrong = [f"{x['name']!r} is unread without a remark" for x in records
             if x["status"] == "unread" and not x["remarks"]]  # fmt: skip
    json.dumps(records, default=str)
    return "+".join(sorted({x["status"] for x in records})) or "no table", wrong


def _checked(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Check one mutated document through a pipe."""
    content = mutated(draw, draw.choice(DOCUMENTS))
    out, err = io.StringIO(), io.StringIO()
    given = io.TextIOWrapper(io.BytesIO(content), encoding="utf-8")
    with (patch("sys.stdin", given), contextlib.redirect_stdout(out),
          contextlib.redirect_stderr(err)):  # fmt: skip
        code = glmref(["check", "-", "--format", "json"])
    said = err.getvalue().strip()
    wrong = []
    if code not in (0, 1, 2, 3) or (code == 2) != bool(said):
        wrong.append(f"exit code {code}, and {said[:200]!r} is said")
    if "\n" in said or len(said) > SENTENCE or "internal" in said or "Error:" in said:
        wrong.append(f"says {said[:300]!r} in {len(said)} characters")
    if code == 2:
        return "refused", wrong
    found = json.loads(out.getvalue())["findings"]
    with contextlib.suppress(ValueError):
        wrong += _false(json.loads(content), found)
    return "+".join(sorted({x["verdict"] for x in found})), wrong


def _false(document: dict[str, Any], found: list[dict[str, Any]]) -> Iterable[str]:
    """What floating point says of an order that is said to hold."""
    held = [x["declared"] for x in found if x["claim"] == "order" and x["verdict"] == "holds"]
    if "b" not in document or set(document) & {"parts", "alpha", "b_prime"} or not held:
        return
    b = [_number(x) for x in document["b"]]
    if int(held[0]) >= 1 and abs(sum(b) - 1) > 1e-6 * max(1.0, *map(abs, b)):
        yield f"order {held[0]} holds, and the weights sum to {sum(b)}"


def _number(x: Any) -> float:
    above, _, below = str(x).partition("/")
    return float(above) / float(below or 1)
