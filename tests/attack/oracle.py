"""Drawn statements, and three opinions on each: they may leave it open, but never contradict.

What the kernel finds, the judge's verdict and its answer to the certificates in both directions, and
the oracle (:mod:`tests.oracle`).
"""

import json
import random
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from glmref.catalogue.claims import CLAIMS
from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.findings import Verdict
from glmref.prove.verifier import facts_for
from glmref.system.budget import limited
from tests.adversary.both_ways import accepted, contradicts
from tests.build import SOURCE
from tests.oracle.claims import Oracle
from tests.oracle.draw import Draw, claims_of
from tests.oracle.numbers import Undecided

from .tally import Tally

#: Statements.
COUNT = 30_000
WORDS = {Verdict.HOLDS: True, Verdict.FAILS: False}


def compared(document: dict[str, Any], claims: dict[str, Any],
             count: Counter[str]) -> Iterator[str]:  # fmt: skip
    """Yield what one program says against another about the claims of a document."""
    try:
        facts = facts_for(load_document({**document, "source": SOURCE, "claims": claims}))
    except GlmrefError:
        count["documents refused"] += 1
        return
    count["documents"] += 1
    try:
        oracle = Oracle(document)
    except (Undecided, ZeroDivisionError):
        return
    for claim, declared in claims.items():
        try:
            with limited(10):
                judged, seen, other = facts.judge(claim, declared), None, None
                if CLAIMS[claim].type in (int, dict):  # the others are found by the judge itself
                    seen = facts.find(claim, declared).truth
        except GlmrefError:
            count["statements refused"] += 1
            continue
        word, reasons = WORDS.get(judged.verdict), []
        try:
            other = oracle.judge(claim, declared)
        except (IndexError, KeyError, TypeError, ValueError) as error:
            reasons.append(f"the oracle breaks down: {error!r}")
        count["statements"] += 1
        count["found without a verdict"] += seen is not None and word is None
        count["judge decides"] += word is not None
        count["oracle decides"] += other is not None
        count["both decide"] += word is not None and other is not None
        for name, says in (("judge says", word), ("kernel finds", seen)):
            if says is not None and other is not None and says is not other:
                reasons.append(f"the {name} {says}, the oracle {other}")
        if isinstance(judged.certificate, dict):
            if not accepted(judged.certificate):
                reasons.append("refused over fractions, accepted over FLINT")
            reasons += [f"accepted both ways: {x}" for x in contradicts(judged.certificate)]
        yield from (f"{claim} = {declared}: {x}" for x in reasons)


def attack(count: int, seed: int, say: Callable[[str], None] = lambda line: None) -> Tally:
    """Draw documents until so many statements were compared."""
    tally = Tally()
    for number in range(count):
        if tally.outcomes["statements"] >= count:
            break
        rng = random.Random(f"{seed} {number}")
        document = Draw(rng).document()
        for text in compared(document, claims_of(document, rng), tally.outcomes):
            tally.violations.append(f"document {number}: {text}\n  {json.dumps(document)}")
            say(tally.violations[-1])
        if number % 500 == 499:
            say(f"{number + 1} documents: {dict(tally.outcomes)}")
    return tally
