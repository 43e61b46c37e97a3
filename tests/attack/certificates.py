"""Mutated certificates: the checker says yes or no, and yes to nothing that is false.

What is accepted after a mutation is held against the package: it must find the same verdict for the
method of the certificate.
"""

import json
import random
import tempfile
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

from glmref.catalogue.reader import load_document
from glmref.cli.certifying import write_certificates
from glmref.errors import GlmrefError
from glmref.judge import command
from glmref.judge.refusals import Unreadable
from glmref.prove.verifier import verify
from tests.build import SOURCE

from .texts import mutated

CASES = "certificates"
COUNT = 2000
SECONDS = 10.0
LIMIT = 2 * SECONDS
NAMES = ("rk4", "heun-2", "gauss-2", "leapfrog", "gsymplectic-n", "stormer-verlet", "ab-2")


@lru_cache
def sound() -> tuple[dict[str, Any], ...]:
    """Certificates as the package writes them."""
    with tempfile.TemporaryDirectory() as name:
        write_certificates(list(NAMES), Path(name))
        paths = sorted(Path(name).rglob("*.json"))
        return tuple(json.loads(p.read_text(encoding="utf-8")) for p in paths)


def prepare() -> None:
    """Read what all cases need."""
    sound()


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Mutate one certificate and have it checked."""
    content = mutated(draw, draw.choice(sound()))
    with tempfile.TemporaryDirectory() as name, patch.object(command, "SECONDS", int(SECONDS)):
        path = Path(name) / "x.json"
        path.write_bytes(content)
        try:
            (text,) = command.read(str(path))
            accepted, sentence = command.check(text)
        except Unreadable as error:
            return "unreadable", _sentence(str(error))
    if not accepted:
        return "no", _sentence(sentence)
    return "yes", _false(json.loads(content))


def _sentence(said: str) -> Iterable[str]:
    if not said.strip() or "\n" in said or len(said) > 3000:
        yield f"says {said[:200]!r}"


def _false(certificate: dict[str, Any]) -> Iterable[str]:
    """What the package says against a certificate that is accepted."""
    statement = certificate["statement"]
    document = {**certificate["document"], "claims": {statement["claim"]: statement["declared"]}}
    document.pop("broken", None)
    document.setdefault("source", SOURCE)
    try:
        findings = verify(load_document(document, where="x"), budget=SECONDS / 2)
    except GlmrefError:
        return  # a part of the file that this statement does not need is no longer sound
    (found,) = (x for x in findings if x.claim == statement["claim"])
    if str(found.verdict) not in (statement["verdict"], "open"):
        yield f"accepted as {statement['verdict']}, and it {found.verdict}: {statement}"
