"""Mutated vector files and problems of vectors: read and judged by, or refused with a sentence."""

from __future__ import annotations

import json
import random
import tempfile
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

from glmref.conformance import vector_problems, vectors
from glmref.conformance.adapters.reference import Adapter
from glmref.conformance.checks import Suite
from glmref.conformance.subject import Subject

from .texts import mutated

CASES = "vector files"
COUNT = 1000
SECONDS = 20.0
NAMES = ("rk4", "ab-2", "stormer-verlet", "gauss-2")


@lru_cache
def sound() -> dict[str, Any]:
    """Vector files of some methods, and the problems."""
    folder = vectors.folder()
    return {x: json.loads((folder / f"{x}.json").read_text()) for x in (*NAMES, "problems")}


def prepare() -> None:
    """Read what all cases need."""
    sound()


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Mutate the file of a method, or the problems, and judge the right integrator by them."""
    name = draw.choice(NAMES)
    hit = name if draw.random() < 0.8 else "problems"
    with tempfile.TemporaryDirectory() as folder:
        for x in (name, "problems"):
            content = mutated(draw, sound()[x]) if x == hit else json.dumps(sound()[x]).encode()
            (Path(folder) / f"{x}.json").write_bytes(content)
        where = [
            patch.object(x, "folder", lambda: Path(folder)) for x in (vector_problems, vectors)
        ]
        with where[0], where[1]:
            try:
                _forget()
                found = Suite(Subject(Adapter((name,)))).findings()
            finally:
                _forget()
    ends = sorted({str(x.verdict) for x in found})
    return "+".join(ends), [f"{x.claim} says nothing" for x in found
                            if str(x.verdict) != "holds" and not x.witness]  # fmt: skip


def _forget() -> None:
    vectors.problems.cache_clear()
    vectors.vectors_of.cache_clear()
