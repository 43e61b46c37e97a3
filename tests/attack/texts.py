"""Mutations of JSON documents that any reader gets, and the loop over cases."""

import copy
import json
import random
import signal
import time
import traceback
from typing import Any

from glmref.errors import GlmrefError
from tests.inside import at, places, put

from .files import SENTENCE, _broken_text, _exchanged, _key, _kind, _ring, _shape, _TooLong
from .tally import Tally


def _digit(draw: random.Random, doc: Any) -> Any:
    """One character of a text, or a number that is another."""
    paths = [p for p in places(doc) if p and isinstance(at(doc, p), str | int | float)]
    if not paths:
        return doc
    path = draw.choice(paths)
    value = at(doc, path)
    if isinstance(value, str) and value:
        k = draw.randrange(len(value))
        new = draw.choice("0123456789+-*/().eE[]y, \x00é")
        return put(doc, path, value[:k] + draw.choice((new, "")) + value[k + 1 :])
    return put(doc, path, draw.choice((0, -1, 1, 10**9, 1e308, 0.5, True, "1")))


def _swapped(draw: random.Random, doc: Any) -> Any:
    """Two parts exchanged."""
    paths = [p for p in places(doc) if p and not isinstance(at(doc, p), dict | list)]
    return _exchanged(draw, doc, paths)


def mutated(draw: random.Random, doc: Any, *, text: float = 0.1) -> bytes:
    """Return a document as bytes after some mutations; with a probability, no good JSON."""
    doc = copy.deepcopy(doc)
    for _ in range(draw.choice((1, 1, 1, 2, 3))):
        if isinstance(doc, dict | list) and doc:
            doc = draw.choice((_digit, _digit, _kind, _key, _swapped, _shape))(draw, doc)
    written = json.dumps(doc)
    return _broken_text(draw, written) if draw.random() < text else written.encode()


def attack(module: Any, count: int, seed: int) -> Tally:
    """Run cases of a module, each within its processor time; count what comes of them.

    ``module.judge(draw)`` carries out one case: its end, and what it violates. ``module.prepare``,
    where it is there, is called once before.
    """
    getattr(module, "prepare", lambda: None)()
    tally, seconds = Tally(), getattr(module, "LIMIT", module.SECONDS)
    before = signal.signal(signal.SIGPROF, _ring)
    try:
        for number in range(1, count + 1):
            started = time.process_time()
            signal.setitimer(signal.ITIMER_PROF, seconds)
            wrong: list[str] = []
            try:
                end, found = module.judge(random.Random(f"{seed}:{number}"))
                wrong += found
            except GlmrefError as error:
                end, said = "refused", str(error)
                if not said.strip() or "\n" in said or len(said) > SENTENCE:
                    wrong.append(f"says {said[:200]!r} in {len(said)} characters")
            except _TooLong as error:
                end = "too long"
                wrong.append(f"takes more than {seconds:g} s{_at_line(error)}")
            except Exception as error:
                end = "exception"
                wrong.append(f"{type(error).__name__}: {str(error)[:200]}{_at_line(error)}")
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
            if time.process_time() - started > 2 * seconds:
                wrong.append(f"took {time.process_time() - started:.1f} s")
            tally.outcomes[end] += 1
            tally.violations += [f"{text} [case {number}, seed {seed}]" for text in wrong]
    finally:
        signal.signal(signal.SIGPROF, before)
    return tally


def _at_line(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)[-3:]
    return " at " + " < ".join(f"{f.filename.rpartition('/')[2]}:{f.lineno}" for f in frames[::-1])


def main(module: Any, count: int, seed: int) -> int:
    """Attack and print counts and violations; 1 where there is a violation."""
    print(f"{count} {module.CASES}, seed {seed}", flush=True)
    return attack(module, count, seed).printed()
