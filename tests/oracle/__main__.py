"""``python -m tests.oracle --count N --seed S``: draw statements, and compare three opinions on them.

What the kernel finds, the judge's verdict and its answer to the certificates in both directions, and
the oracle may leave a statement open, but never contradict each other.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections import Counter
from collections.abc import Iterator
from typing import Any

from glmref.catalogue.claims import CLAIMS
from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.findings import Verdict
from glmref.prove.verifier import facts_for
from glmref.system.budget import limited
from tests.adversary.both_ways import accepted, contradicts
from tests.build import SOURCE

from .claims import Oracle
from .draw import Draw, claims_of
from .numbers import Undecided

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


def run(count: int, seed: int, tell: bool = True,
        seconds: float = float("inf")) -> tuple[Counter[str], list[str]]:  # fmt: skip
    """Draw documents until so many statements were compared; return counts and contradictions.

    The last document is drawn before `seconds` of processor time have passed.
    """
    totals: Counter[str] = Counter()
    against: list[str] = []
    number, end = 0, time.process_time() + seconds
    while totals["statements"] < count and number < count and time.process_time() < end:
        rng = random.Random(f"{seed} {number}")
        document = Draw(rng).document()
        for text in compared(document, claims_of(document, rng), totals):
            against.append(f"{text}\n  {json.dumps(document)}")
            if tell:
                print(f"seed {seed}, document {number}: {against[-1]}", flush=True)
        number += 1
        if tell and number % 500 == 0:
            print(
                number, "documents,", len(against), "contradictions:", dict(totals), file=sys.stderr
            )
    return totals, against


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison; the exit code is 1 where there is a contradiction."""
    parser = argparse.ArgumentParser(prog="python -m tests.oracle", description=__doc__)
    parser.add_argument("--count", type=int, default=30_000, help="statements")
    parser.add_argument("--seed", type=int, default=1, help="seed of the documents")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="processor time")
    totals, against = run(**vars(parser.parse_args(arguments)))
    for key, n in [*totals.most_common(), ("contradictions", len(against))]:
        print(f"{n:8} {key}")
    return int(bool(against))


if __name__ == "__main__":
    sys.exit(main())
