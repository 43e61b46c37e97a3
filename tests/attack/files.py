"""Method files as an enemy or an accident would write them: readers, proofs, pages and citations.

Each case is a shipped or a made file with some mutations: of the text (JSON, encoding, size), of
the structure (types, keys, shapes), of the entries (digits, signs, names, towers of roots), of the
claims or of the enclosure. It must end in findings or in one sentence, within a time limit. A
claim that ``holds`` is held against the oracle (:mod:`tests.oracle`).
"""

import contextlib
import copy
import csv
import io
import json
import os
import pickle
import random
import re
import resource
import select
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from glmref.catalogue.claims import CLAIMS as CLAIMS_OF_FILES
from glmref.catalogue.files import data_root
from glmref.catalogue.lookup import document as document_of
from glmref.catalogue.lookup import load
from glmref.cli import main as command
from glmref.errors import GlmrefError
from glmref.exchange.export import TARGETS, export
from glmref.findings import Finding, Verdict
from glmref.prove.analysis import analyze
from glmref.prove.verifier import verify_file
from glmref.system.budget import READING, limited
from tests.inside import at, places, put
from tests.oracle.claims import opinion
from tests.oracle.draw import Draw, claims_of

from .tally import Tally

COUNT = 5000
#: Seconds of processor time: what proofs get, and what one operation may take beyond that.
BUDGET, GRACE = 0.5, 2.0
#: Seconds for the opinion of the oracle on one file, and entries of A of the largest that is asked.
ORACLE, ENTRIES_JUDGED = 4.0, 64
#: Most characters of a refusal.
SENTENCE = 1500
#: Bytes of address space of the process that reads the files.
MEMORY = 4 << 30
#: Most bytes of a shipped file that is mutated; of each class this many files, whatever their size.
SMALL, FEW = 2500, 6

# --- what is mutated ------------------------------------------------------------------------------


@lru_cache
def bases() -> tuple[str, ...]:
    """Texts of the small shipped files: all classes, and those wrong on purpose."""
    root = data_root()
    paths = [p for x in ("methods", "broken") for p in sorted((root / x).rglob("*.json"))]
    return tuple(p.read_text(encoding="utf-8") for p in paths if p.stat().st_size <= SMALL)


@lru_cache
def by_class() -> dict[str, tuple[str, ...]]:
    """Texts by class, so that the rare ones come as often as Runge-Kutta methods."""
    found: dict[str, list[str]] = {}
    root = data_root()
    for path in (p for x in ("methods", "broken") for p in sorted((root / x).rglob("*.json"))):
        text = path.read_text(encoding="utf-8")
        found.setdefault(json.loads(text)["class"], []).append(text)
    return {
        name: tuple(x for n, x in enumerate(sorted(texts, key=len)) if n < FEW or len(x) <= SMALL)
        for name, texts in sorted(found.items())
    }


@lru_cache
def enclosed() -> tuple[str, ...]:
    """Texts of the smallest shipped files with an enclosure."""
    root = data_root() / "methods"
    found = (p.read_text(encoding="utf-8") for p in sorted(root.rglob("*.json")))
    return tuple(sorted((x for x in found if '"enclosure"' in x), key=len)[:6])


@dataclass(frozen=True)
class Case:
    """One file."""

    number: int  #: Its number, which together with the seed gives it again.
    kinds: tuple[str, ...]  #: Mutations that were made.
    data: bytes  #: Its content.

    def __str__(self) -> str:
        return f"case {self.number}: {', '.join(self.kinds)}"


PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71)
#: Entries of every bad kind; ``{p}`` is a prime.
ENTRIES = (
    "0", "-0", "1", "-1", "1/0", "0/0", "1/(1-1)", "1/(sqrt(2)*sqrt(3)-sqrt(6))", "", " ", "1//2",
    "--1", "1e5", "1E400", "inf", "nan", "NaN", "0x10", "1_000", "１/２", "½", "²", "1/2\x00",
    "\x1b[31m1", "\u202e1", "1;2", "__import__('os')", "a", "A", "i", "pi", "i*i", "2*i", "sqrt", "sqrt(",
    "sqrt()", "sqrt(-1)", "sqrt(0)", "sqrt(sqrt(2)-sqrt(2))", "root(2,0)", "root(2,1)", "root(2,13)",
    "root(-8,3)", "root(0,3)", "root(2,1/2)", "root({p},12)", "root({p},7)+root(3,5)",
    "exp(1)", "exp(2*pi*i/0)", "exp(2*pi*i/29)", "exp(2*pi*i/1000000007)", "exp(i*pi)", "exp(pi)",
    "exp(2*pi*i/29)+exp(-2*pi*i/29)", "exp(2*pi*i/7)+exp(-2*pi*i/7)", "exp(2*pi*i/{p})",
    "0.5", ".5", "5.", "0." + "3" * 10000, "0." + "3" * 150, "9" * 999, "9" * 1001, "1/" + "7" * 998,
    "sqrt({p})", "1/2+sqrt({p})", "1/(1+sqrt({p}))", "sqrt(2+sqrt({p}))", "sqrt(2-sqrt(2+sqrt({p})))",
    "sqrt(2+sqrt(3+sqrt(5+sqrt({p}))))", "sqrt(" * 30 + "2" + ")" * 30, "(" * 50 + "1" + ")" * 50,
    "+".join(f"sqrt({p})" for p in PRIMES), "*".join(f"(1+sqrt({p}))" for p in PRIMES),
    "*".join(f"(1+sqrt({p}))" for p in PRIMES[:8]), "1/(" + "+".join(f"sqrt({p})" for p in PRIMES[:6]) + ")",
    "1/(" + "+".join(f"root({p},7)" for p in PRIMES[:4]) + ")", "+".join(["1/3"] * 900),
    "*".join(["(1+sqrt(2))"] * 300), "*".join(["9" * 300] * 12), "-" * 39 + "1", "-" * 41 + "1",
    "sqrt(5+2*sqrt(6))-sqrt(2)-sqrt(3)", "1/(sqrt(5+2*sqrt(6))-sqrt(2)-sqrt(3))",
    "exp(2*pi*i/1{p})+exp(2*pi*i/2{p})", "1/10000000000000000000000000000000", "100000000000000000000000",
)  # fmt: skip
#: Values of wrong types, for any place.
VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2**63, 10**19, "", "x", "\x1b]0;x\x07", "\ud800", "<script>", "../../x",
    [], {}, [[]], [[[]]], ["1"], [["1"]], [["1", "2"], ["3"]], {"A": [["1"]]}, ["x"] * 300, [["0"] * 3] * 300,
)  # fmt: skip
KEYS = (
    "A", "U", "B", "V", "G", "D", "b", "c", "alpha", "beta", "X", "q", "p", "a", "first", "gamma", "base",
    "A_hat", "b_hat", "w", "v", "V_hat", "stages", "starting", "finishing", "output", "separable",
    "constants", "unknowns", "digits", "enclosure", "broken", "claims", "source", "notes", "title", "field",
    "$schema", "format", "class", "name", "D_P", "D_Q", "zzz", "__proto__", "\x1b[2J", "", "c", "embedded",
    "dense", "parts", "b_prime", "order", "d", "A_prime", "error", "system", "bibtex", "flag",
)  # fmt: skip
CLAIMS = tuple(CLAIMS_OF_FILES)
CLASSES = (
    "glm", "rk", "lmm", "one-leg", "sweep", "composition", "splitting", "partitioned-rk", "partitioned",
    "pair-sweep", "rkn", "nystrom", "rosenbrock", "additive", "",
)  # fmt: skip
DECLARED: tuple[Any, ...] = (
    0, 1, 2, 3, 4, 5, 8, 11, 12, 10**9, -1, True, False, None, "2", "1/2", "sqrt(2)", [], ["0"], ["1", "0"],
    ["1"] * 50, [1], [None], {}, "1/0", "x", {"embedded": 2}, {"embedded": 0}, {"b": 3}, {"x": 1}, {"": 1},
    {"embedded": [2, "1.0e-9"]}, {"b": [4, "1.0e-16"]}, {"b": [0, "9.9e-1"]}, {"embedded": True},
)  # fmt: skip

Mutation = Callable[[random.Random, Any], Any]


def _numbers(doc: Any) -> list[tuple[Any, ...]]:
    """Paths to the entries: strings that are computed with."""
    prose = {"name", "title", "source", "notes", "broken", "format", "class", "$schema", "base"}
    return [
        path
        for path in places(doc)
        if path and path[0] not in prose and isinstance(at(doc, path), str)
    ]


def _entry(draw: random.Random, doc: Any) -> Any:
    """Another entry, or several."""
    for _ in range(draw.choice((1, 1, 1, 2, 5))):
        paths = _numbers(doc)
        if paths:
            text = draw.choice(ENTRIES).replace("{p}", str(draw.choice(PRIMES)))
            put(doc, draw.choice(paths), text)
    return doc


def _slip(draw: random.Random, doc: Any) -> Any:
    """A slip of a pen: one character of an entry."""
    paths = _numbers(doc)
    if not paths:
        return doc
    path = draw.choice(paths)
    text = at(doc, path)
    k = draw.randrange(len(text) + 1)
    new = draw.choice("0123456789+-*/()., sqrti" + "\x00é")
    kept = draw.choice((k, k + 1))
    return put(doc, path, text[:k] + draw.choice((new, "")) + text[kept:])


def _exchange(draw: random.Random, doc: Any) -> Any:
    """Two entries exchanged."""
    return _exchanged(draw, doc, _numbers(doc))


def _exchanged(draw: random.Random, doc: Any, paths: list[tuple[Any, ...]]) -> Any:
    if len(paths) > 1:
        a, b = draw.sample(paths, 2)
        x, y = at(doc, a), at(doc, b)
        put(put(doc, a, y), b, x)
    return doc


def _kind(draw: random.Random, doc: Any) -> Any:
    """Something of another type."""
    path = draw.choice(list(places(doc)))
    return put(doc, path, copy.deepcopy(draw.choice(VALUES)))


def _key(draw: random.Random, doc: Any) -> Any:
    """A key that is missing, new, renamed, or another's."""
    inner = [p for p in places(doc) if isinstance(at(doc, p), dict)]
    block = at(doc, draw.choice(inner)) if inner else {}
    if block and draw.random() < 0.6:
        value = block.pop(draw.choice(list(block)))
        if draw.random() < 0.5:
            block[draw.choice(KEYS)] = value
    else:
        block[draw.choice(KEYS)] = copy.deepcopy(draw.choice(VALUES))
    return doc


def _shape(draw: random.Random, doc: Any) -> Any:
    """A row more, a row less, a row longer; or hundreds of them."""
    lists = [p for p in places(doc) if p and isinstance(at(doc, p), list) and at(doc, p)]
    if not lists:
        return doc
    rows = at(doc, draw.choice(lists))
    how = draw.randrange(4)
    if how == 0:
        rows.pop(draw.randrange(len(rows)))
    elif how == 1:
        rows.append(copy.deepcopy(draw.choice(rows)))
    elif how == 2:
        rows.reverse()
    else:
        rows *= draw.choice((2, 10, 201))
    return doc


def _object(doc: Any, key: str) -> Any:
    """The object under a key, made where there is none."""
    if not isinstance(doc.get(key), dict):
        doc[key] = {}
    return doc[key]


def _claim(draw: random.Random, doc: Any) -> Any:
    """Another claim, or another value of one."""
    claims = _object(doc, "claims")
    for _ in range(draw.choice((1, 1, 3))):
        claims[draw.choice((*CLAIMS, *CLAIMS, "zzz"))] = copy.deepcopy(draw.choice(DECLARED))
    return doc


def _true_claims(draw: random.Random, doc: Any) -> Any:
    """Every claim of yes or no, which the soundness of the answers is seen by."""
    pair = any(x in doc for x in ("q", "A_hat", "w", "first", "stages"))
    claims: dict[str, Any] = {"order": draw.choice((1, 2, 3)), "consistent": True}
    claims |= {"preconsistent": True, "zero-stable": True}
    for name in ("g-symplectic", "symmetric", "parasitism-free", *(() if pair else ("a-stable",))):
        if draw.random() < 0.4:
            claims[name] = draw.random() < 0.5
    doc["claims"] = claims
    doc.pop("broken", None)
    return doc


def _class(draw: random.Random, doc: Any) -> Any:
    doc["class"] = draw.choice(CLASSES)
    return doc


def _constants(draw: random.Random, doc: Any) -> Any:
    """Constants from constants, each larger than the one before."""
    step = draw.choice(
        ("{x}*{x}", "sqrt(1+{x})", "{x}+sqrt({p})", "1/(1+{x})", "({x}+root({p},5))*{x}")
    )
    names = [f"k{n}" for n in range(draw.choice((3, 8, 30, 500)))]
    block = {names[0]: draw.choice(("2", "sqrt(2)", "root(3,7)"))}
    for n, (x, y) in enumerate(zip(names, names[1:], strict=False)):
        block[y] = step.replace("{x}", x).replace("{p}", str(PRIMES[n % len(PRIMES)]))
    doc["constants"] = block
    paths = _numbers(doc)
    if paths:
        put(doc, draw.choice(paths), names[-1])
    return doc


def _enclosure(draw: random.Random, doc: Any) -> Any:
    """Radius, equations and unknowns that do not fit."""
    block = _object(doc, "enclosure")
    what = draw.randrange(4)
    if what == 0:
        block["radius"] = draw.choice(
            ("0", "-1", "1e5", "1e-60", "1e-999", "1e-70", "nan", 1, None)
        )
    elif what == 1:
        equations = block.get("equations")
        if isinstance(equations, list) and equations:
            equations[draw.randrange(len(equations))] = draw.choice(
                ("order [o]", "order o", "order [[[[[[[[[[[[o]]]]]]]]]]]]", "order [", "growth -1",
                 "growth 1/0", "explicit 0", "explicit 10000000000", "defect", "", "zzz", "start 1 o")
            )  # fmt: skip
            if draw.random() < 0.3:
                equations *= draw.choice((2, 50))
        else:
            block["equations"] = ["order o", "order [[o]o]"]
    elif what == 2:
        doc["digits"] = draw.choice((0, 1, 5, 74, 75, 150, 151, 10**9, -1, "75", None))
    else:
        unknowns = doc.setdefault("unknowns", {})
        if isinstance(unknowns, dict):
            unknowns[draw.choice(("x1", "x", "i", "d1", ""))] = draw.choice(
                ("0." + "1" * 75, "1/2", "x1")
            )
    return doc


def _start(draw: random.Random, doc: Any) -> Any:
    """A starting or a finishing block."""
    r = len(doc["V"]) if isinstance(doc.get("V"), list) else 1
    n = draw.choice((1, 2, 3, 30))
    block: dict[str, Any] = {
        "A": [["1/2"] * n] * n, "B": [["1/3"] * n] * r, "u": ["1"] + ["0"] * (r - 1),
        "order": draw.choice((1, 2, 12, -1, None)),
    }  # fmt: skip
    if draw.random() < 0.4:
        block.pop(draw.choice(list(block)))
    doc[draw.choice(("starting", "starting", "finishing"))] = block
    return doc


def _huge(draw: random.Random, doc: Any) -> Any:
    """A method of absurd size, dense, rational or algebraic."""
    s, r = draw.choice(((200, 1), (201, 1), (60, 1), (20, 20), (8, 8), (3, 50), (50, 50), (1, 200)))
    forms = ("0", "1/{n}", "{n}/{m}", "sqrt({p})/{n}", "root({p},5)", "1/({n}+sqrt({p}))", "0.{n}")
    form = draw.choice(forms)

    def entry() -> str:
        n, m, p = draw.randint(1, 99), draw.randint(1, 99), draw.choice(PRIMES[:6])
        return form.replace("{n}", str(n)).replace("{m}", str(m)).replace("{p}", str(p))

    def matrix(rows: int, columns: int) -> list[list[str]]:
        return [[entry() for _ in range(columns)] for _ in range(rows)]

    kept = {x: doc[x] for x in ("format", "name", "claims", "source") if x in doc}
    made: dict[str, Any] = {"A": matrix(s, s)}
    if r == 1:
        made |= {"class": "rk", "b": matrix(1, s)[0]}
        if draw.random() < 0.5:  # weights that sum to 1
            made["b"] = [f"1/{s}"] * s
    else:
        made |= {"class": "glm", "U": matrix(s, r), "B": matrix(r, s), "V": matrix(r, r)}
        if draw.random() < 0.7:  # preconsistent: the first value is the solution
            made["U"] = [["1", *row[1:]] for row in made["U"]]
            made["V"] = [["1", *made["V"][0][1:]], *(["0", *row[1:]] for row in made["V"][1:])]
    if form == "0.{n}":
        made["digits"] = 2
    return {**kept, **made}


def _multistep(draw: random.Random, doc: Any) -> Any:
    k = draw.choice((2, 20, 60, 199, 250))
    kept = {x: doc[x] for x in ("format", "name", "claims", "source") if x in doc}
    alpha = ["1", *(draw.choice(("0", "0", "1/7")) for _ in range(k - 1)), "-1"]
    named = draw.choice(("lmm", "one-leg"))
    return {**kept, "class": named, "alpha": alpha, "beta": [f"1/{k + 1}"] * (k + 1)}


def _rows(draw: random.Random, doc: Any) -> Any:
    """Embedded rows, an error estimate or a dense output, of every length and by every name."""
    s = len(doc["b"]) if isinstance(doc.get("b"), list) else draw.choice((1, 2, 4))
    n = draw.choice((s, s, s, s - 1, s + 1, 300))
    weights = draw.choice(([f"1/{s}"] * n, ["0"] * n, ["1/2", *["0"] * (n - 1)], ["sqrt(2)"] * n))
    row: dict[str, Any] = {
        "name": draw.choice(("embedded", "b", "", "x" * 5000, "\x1b[2J", "a", 1))
    }
    row[draw.choice(("b", "b", "error"))] = weights
    if draw.random() < 0.3 or doc.get("class") == "nystrom":
        row[draw.choice(("b_prime", "v", "d", "zzz"))] = copy.deepcopy(weights)
    doc["embedded"] = [row] * draw.choice((1, 1, 1, 2, 300))
    if draw.random() < 0.3:
        width = draw.choice((1, 3, 0, 50))
        doc["dense"] = [[draw.choice(("1", "0", "-1/2", "x"))] * width for _ in range(n)]
    if draw.random() < 0.8:
        doc["format"] = "glmref-method-2"
    claims = doc.setdefault("claims", {})
    if isinstance(claims, dict):
        claims |= {"embedded-order": {row["name"]: draw.choice((0, 1, 2, 5))}}
        claims |= {"embedded-difference": draw.random() < 0.5}
    return doc


def _kept(doc: Any) -> dict[str, Any]:
    """What is free of the coefficients."""
    kept = {x: doc[x] for x in ("name", "claims", "source") if x in doc}
    return {"format": "glmref-method-2", **kept}


def _drawn(draw: random.Random, doc: Any) -> Any:
    """A small method of any class with claims that may be right, as the oracle draws them."""
    made = Draw(draw).document()
    return {**_kept(doc), **made, "claims": claims_of(made, draw)}


def _parts(draw: random.Random, doc: Any) -> Any:
    """An additive method of one part or many, all of one tableau, or of the parts of the file."""
    parts = doc.get("parts")
    if not isinstance(parts, list) or not parts:
        whole = json.loads(draw.choice(by_class()["rk"]))
        parts = [{x: whole[x] for x in ("A", "b")}]
        constants = {x: whole[x] for x in ("constants", "digits") if x in whole}
        doc = {**_kept(doc), **constants, "class": "additive"}
    n = draw.choice((1, 2, 3, 5, 6, 7, 8, 9, 10))
    doc["parts"] = [copy.deepcopy(parts[k % len(parts)]) for k in range(n)]
    doc["claims"] = {"order": draw.choice((1, 2, 3, 4)), "stage-order": draw.choice((0, 1, 2))}
    return doc


def _letters(draw: random.Random, doc: Any) -> Any:
    """A splitting with its coefficients, or the stages of a pair, in another number or order."""
    if isinstance(doc.get("stages"), str):
        stages = list(doc["stages"])
        draw.shuffle(stages)
        doc["stages"] = "".join(stages) * draw.choice((1, 1, 1, 2, 100)) + draw.choice(
            ("", "R", " ")
        )
        return doc
    n = draw.choice((1, 2, 3, 199, 201, 5000))
    made = {**_kept(doc), "format": "glmref-method-1", "class": "splitting"}
    made |= {"first": draw.choice(("q", "p", "x", ""))}
    return {**made, "a": [f"1/{n}"] * n, "b": [f"1/{n}"] * (n + draw.choice((-1, 0, 0, 1)))}


#: Markup, commands, formulas of spreadsheets, escapes of terminals, marks that turn a line round.
WORDS = (
    "</script><script>alert(1)</script>", "\x1b]0;x\x07", "\u202eevil", "*/ system(1); /*", "=1+1", "@SUM(A1)",
    '"""\nimport os\n"""', "\\input{/etc/passwd}", "%s%n", "]]>", "\x00", "\r\n= 1", "${HOME}", "`id`",
    "end subroutine\n", "{{7*7}}", "../../x", "\ud800", "|x|", "(* *) Admitted. (*", "\\\n", "!\n", "#{x}",
)  # fmt: skip


def _words(draw: random.Random, doc: Any) -> Any:
    """Hostile words where texts are free."""
    source = doc.setdefault("source", {})
    for _ in range(draw.choice((1, 3))):
        word = draw.choice(WORDS)
        key = draw.choice(
            ("title", "name", "notes", "citation", "where", "doi", "bibtex", "status")
        )
        if key in ("title", "name", "notes"):
            doc[key] = [word] if key == "notes" else word
        elif isinstance(source, dict):
            source[key] = word
    return doc


def _composition(draw: random.Random, doc: Any) -> Any:
    kept = {x: doc[x] for x in ("format", "name", "claims", "source") if x in doc}
    base = draw.choice(
        ("gauss-2", "gauss-3", "rk4", "dop853", "../rk4", "g6245", "implicit-midpoint")
    )
    m = draw.choice((1, 5, 30, 101, 200, 300))
    gamma = [draw.choice((f"1/{m}", "sqrt(2)"))] * m
    return {**kept, "class": "composition", "base": base, "gamma": gamma}


MUTATIONS: dict[str, tuple[int, Mutation]] = {
    "entry": (8, _entry), "slip": (8, _slip), "exchange": (4, _exchange), "type": (5, _kind),
    "key": (5, _key), "shape": (4, _shape), "claim": (5, _claim), "true claims": (5, _true_claims),
    "class": (1, _class), "constants": (2, _constants), "enclosure": (3, _enclosure),
    "start": (2, _start), "huge": (1, _huge), "multistep": (1, _multistep),
    "composition": (1, _composition), "rows": (3, _rows), "drawn": (4, _drawn),
    "letters": (1, _letters), "words": (3, _words), "parts": (1, _parts),
}  # fmt: skip


# --- the text of a file ---------------------------------------------------------------------------


def _broken_text(draw: random.Random, text: str) -> bytes:
    """A file whose text is no good JSON, or good JSON of an odd kind."""
    how = draw.randrange(14)
    at = draw.randrange(len(text))
    if how == 0:
        return text[:at].encode()
    if how == 1:
        return text.encode("utf-16")
    if how == 2:
        return b"\xef\xbb\xbf" + text.encode()
    if how == 3:
        return (
            text.encode()[:at] + bytes(draw.randrange(256) for _ in range(3)) + text.encode()[at:]
        )
    if how == 4:
        deep = draw.choice((39, 45, 100_000))
        return text.replace("{", '{"notes": ' + "[" * deep + "]" * deep + ",", 1).encode()
    if how == 5:
        key = draw.choice(re.findall(r'"[\w$-]+":', text) or ['"A":'])
        return text.replace(key, f"{key} 1, {key}", 1).encode()
    if how == 6:
        number = draw.choice(
            ("0.5", "1e400", "NaN", "-Infinity", "9" * 5000, "-0", "1e-5", "01", "+1")
        )
        return re.sub(r'"-?\d+(/\d+)?"', number, text, count=1).encode()
    if how == 7:
        return text.encode() + draw.choice((b"\x00", b"{}", b",", b" " * 5_000_000, b"//"))
    if how == 8:
        return text.replace('"', draw.choice(("'", "\u201c")), 2).encode()
    if how == 9:
        return (text[:at] + draw.choice("\u202e\x1b\x00\x7f\u2028") + text[at:]).encode()
    if how == 10:
        return text.replace(
            "{", '{"notes": "' + "x" * draw.choice((10**5, 10**7)) + '",', 1
        ).encode()
    if how == 11:
        return text.replace("{", "{" + f'"k{at}": 1,' * 20_000, 1).encode()
    if how == 12:
        return text.replace('"', '"\\ud800', 1).encode()
    return draw.choice(
        (b"", b"\n", b"null", b"[]", b'"x"', b"[" * 10**6, b'{"A":' * 10**5, b"\\", b'"')
    )


def case(number: int, seed: int) -> Case:
    """Return one case; the same for the same number and seed."""
    draw = random.Random(f"{seed}:{number}")
    texts = enclosed() if draw.random() < 0.06 else bases()
    if draw.random() < 0.5:
        texts = by_class()[draw.choice(list(by_class()))]
    text = draw.choice(texts)
    doc = json.loads(text)
    kinds: list[str] = []
    for _ in range(draw.choice((1, 1, 2, 2, 3))):
        weights = [weight for weight, _ in MUTATIONS.values()]
        (kind,) = draw.choices(list(MUTATIONS), weights)
        if isinstance(doc, dict):
            kinds.append(kind)
            doc = MUTATIONS[kind][1](draw, doc)
    if isinstance(doc, dict) and draw.random() < 0.05:
        kinds.append("bare")
        doc = {
            x: y for x, y in doc.items() if x in "A U B V b alpha beta q p constants digits".split()
        }
    text = json.dumps(doc, ensure_ascii=draw.random() < 0.5)
    if draw.random() < 0.1:
        kinds.append("text")
        text = text.encode("utf-8", "replace").decode()
        return Case(number, tuple(kinds), _broken_text(draw, text))
    return Case(number, tuple(kinds), text.encode("utf-8", "surrogatepass"))


# --- soundness ------------------------------------------------------------------------------------


def contradictions(method: Any, findings: list[Finding]) -> Iterator[str]:
    """Yield what the oracle says against claims that are said to hold.

    Parameters
    ----------
    method : GLM, PartitionedGLM or AdditiveGLM
        The method of a file.
    findings : list of Finding
        What was found; refutations of files wrong on purpose are no claims.
    """
    document = method.document
    if sum(len(row) for part in method.components for row in part.A) > ENTRIES_JUDGED:
        return
    base = document_of(document["base"]) if "base" in document else None
    signal.setitimer(signal.ITIMER_PROF, ORACLE)
    try:
        for x in findings:
            asked = x.verdict is Verdict.HOLDS and x.claim in CLAIMS_OF_FILES
            if asked and opinion(document, x.claim, x.declared, base) is False:
                yield f"{x.claim} = {x.declared} holds, and the oracle says that it does not"
    except (_TooLong, ArithmeticError, LookupError, TypeError, ValueError):
        return  # it has no opinion of this file
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


# --- one case -------------------------------------------------------------------------------------


class _TooLong(BaseException):
    """A step took longer than its limit."""


def _ring(*_: Any) -> None:
    raise _TooLong


def _steps(path: Path, number: int) -> Iterator[tuple[str, float, Callable[[], Any]]]:
    """What is done with a file, each with the seconds of processor time it may take."""
    yield "load", READING + GRACE, lambda: load(path)
    yield "verify", READING + BUDGET + GRACE, lambda: verify_file(path, budget=BUDGET)
    if number % 5 == 0:
        yield "analyze", BUDGET + GRACE, lambda: analyze(load(path), budget=BUDGET)
    elif number % 5 == 1:
        from glmref.views.show import show

        yield "show", READING + BUDGET + GRACE, lambda: _within_budget(show, path)
    elif number % 5 == 2:
        from glmref.views.bibtex import file_entry

        yield "cite", READING + GRACE, lambda: file_entry(path)
    elif number % 5 == 3:
        yield "export", READING + BUDGET + GRACE, lambda: _exported(path, number)
    else:
        yield "report", 2 * READING + BUDGET + GRACE, lambda: _reported(path, number)


def _exported(path: Path, number: int) -> None:
    """Write the method for another program, where it can hold it; controls stay out."""
    target = TARGETS[number // 5 % len(TARGETS)]
    with limited(BUDGET):
        text = export(load(path), to=target)
    if target in ("python", "jax"):
        compile(text, "x.py", "exec")
    _clean(text, target)


def _reported(path: Path, number: int) -> None:
    """Verify on the command line: its exit code, and that its output is what it says it is."""
    form = ("table", "json", "csv", "junit")[number // 5 % 4]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = command(
            ["verify", str(path), "--format", form, "--no-cache", "--budget", str(BUDGET)]
        )
    if code == 2:
        said = err.getvalue().strip()
        if "\n" in said or len(said) > SENTENCE or not said.startswith("glmref: "):
            raise AssertionError(f"{said[:200]!r} is said")
        return
    if code not in (0, 1, 3):
        raise AssertionError(f"exit code {code}")
    text = out.getvalue()
    if form == "json":
        json.loads(text)
    elif form == "junit":
        ElementTree.fromstring(text)
    elif form == "csv":
        cells = [x for row in csv.reader(io.StringIO(text)) for x in row]
        if any(x[:1] in ("=", "@", "\t", "\r") for x in cells):
            raise AssertionError(f"a formula of spreadsheets in {text[:200]!r}")
    _clean(text, form)


CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def _clean(text: str, name: str) -> None:
    found = CONTROLS.search(text)
    if found:
        raise AssertionError(f"{found[0]!r} is written as {name}")


def _within_budget(action: Callable[[Any], Any], path: Path) -> Any:
    method = load(path)
    with limited(BUDGET):
        return action(method)


def judged(text: Case, path: Path) -> tuple[str, list[str]]:
    """Read, verify and show one file; the name of its end and what it violates."""
    path.write_bytes(text.data)
    end, wrong = "", []
    for name, seconds, action in _steps(path, text.number):
        signal.setitimer(signal.ITIMER_PROF, seconds)
        try:
            found = action()
            signal.setitimer(signal.ITIMER_PROF, 0)
            if name == "verify":
                end = "+".join(sorted({str(f.verdict) for f in found}))
                method = load(path)
                wrong += contradictions(method, found)
                wrong += [f"{f.claim} is open without a reason" for f in found
                          if f.verdict is Verdict.OPEN and not f.witness]  # fmt: skip
        except GlmrefError as error:
            end = end or f"refused by {name}"
            said = str(error)
            if not said.strip() or "\n" in said or len(said) > SENTENCE:
                wrong.append(f"{name} says {said[:300]!r} in {len(said)} characters")
            if name == "load":
                break
        except _TooLong as error:
            wrong.append(f"{name} took more than {seconds:g} s, in {_where(error)}")
            end = "too long"
        except Exception as error:
            wrong.append(f"{name}: {type(error).__name__} in {_where(error)}: {str(error)[:200]}")
            end = "exception"
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
    return end, wrong


def _where(error: BaseException) -> str:
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "glmref/glmref" in f.filename]
    return " < ".join(f"{f.filename.rpartition('/')[2]}:{f.lineno}" for f in frames[::-1][:4])


# --- many cases, in a process of its own ----------------------------------------------------------


def _child(numbers: range, seed: int, folder: Path, write: int) -> None:
    """Judge cases one after the other, and send what came of each."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGPROF, _ring)
    sys.setrecursionlimit(1000)
    for number in numbers:
        text = case(number, seed)
        os.write(write, pickle.dumps(("begin", str(text), [])))
        end, wrong = judged(text, folder / "x.json")
        packed = pickle.dumps((end, str(text), [x[:600] for x in wrong[:5]]))
        os.write(write, packed)


def _results(count: int, seed: int, patience: float) -> Iterator[tuple[str, str, list[str]]]:
    """Results of all cases; a case that ends its process, or is silent, costs its own result."""
    done = 0
    with tempfile.TemporaryDirectory() as name:
        while done < count:
            read, write = os.pipe()
            child = os.fork()
            if child == 0:
                os.close(read)
                try:
                    _child(range(done + 1, count + 1), seed, Path(name), write)
                except BaseException:
                    traceback.print_exc()
                finally:
                    os._exit(0)
            os.close(write)
            at, reason = "", "its process ended"
            with os.fdopen(read, "rb", buffering=0) as stream:
                spent, still = 0.0, 0
                while done < count:
                    ready, _, _ = select.select([stream], [], [], patience)
                    if not ready:
                        # on a busy machine a process that computes is not one that hangs
                        before, spent, still = spent, _processor(child), still + 1
                        if spent - before < patience / 2 and still < 30:
                            continue
                        reason = f"was silent for {spent:.0f} s of processor time"
                        break
                    spent, still = _processor(child), 0
                    try:
                        end, text, wrong = pickle.load(stream)
                    except (EOFError, pickle.UnpicklingError):
                        break
                    if end == "begin":
                        at = text
                        continue
                    done += 1
                    yield end, text, wrong
                os.kill(child, signal.SIGKILL)
                _, status = os.waitpid(child, 0)
            if done < count:
                done += 1
                yield "killed", at, [f"{reason}, status {status}"]


def _processor(child: int) -> float:
    """Seconds of processor time that a process has used; 0 where the system does not say."""
    try:
        fields = Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def attack(count: int, seed: int, say: Callable[[str], None] = lambda _: None) -> Tally:
    """Run cases and count what comes of them."""
    bases(), enclosed(), by_class()  # read once, before processes are made
    return Tally.of(_results(count, seed, patience=60.0), say)
