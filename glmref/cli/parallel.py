"""Check many data files, in this process or elsewhere, and lose none to another one's failure."""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from ..catalogue.lookup import path_of, unread
from ..compute import Done, Executor, Limits, executor, in_order
from ..compute.child import Function, cores
from ..compute.executors import ENVIRONMENT, Local
from ..errors import BudgetError, GlmrefError
from ..findings import Finding, Verdict
from ..prove.verdict_cache import Question, keep_findings, look_up, question
from ..system.budget import READING, rarely_collected
from ..system.files import noting
from ..system.process import Say, apart
from ..views.tables import plain
from .certifying import write_certificate
from .output import internal_sentence

#: Seconds that two new processes need before they give a first result (they import the package).
STARTUP = 1.0


@dataclass(frozen=True, slots=True)
class Checked:
    """What became of one data file."""

    name: str  #: Name or path as requested.
    findings: list[Finding] = field(default_factory=list)  #: One for each claim.
    error: str = ""  #: The sentence that says why there are none, or ``""``.
    internal: bool = False  #: Whether that is this program's fault.
    trace: str = ""  #: The traceback of an internal error.


def check(
    name: str,
    only: Sequence[str] = (),
    budget: float | None = None,
    *,
    keep: bool = False,
    certificates: str | None = None,
) -> Checked:
    """Check one data file in a budget of processor time; every outcome is a record.

    With ``keep`` what was found before for the same bytes is taken, and what is found kept; but
    with a folder for the ``certificates`` that the judge accepts nothing found before is taken.
    """
    asked = question(name, only, budget) if keep and certificates is None else None
    known = None if asked is None else look_up(asked)
    if known is not None:
        return Checked(name, known)
    try:
        return Checked(name, _decided(name, only, budget, asked, certificates))
    except GlmrefError as error:
        return Checked(name, error=str(error))
    except Exception as error:
        text = "".join(traceback.format_exception(error))
        return Checked(name, error=internal_sentence(error, name), internal=True, trace=text)


def _decided(
    name: str,
    only: Sequence[str],
    budget: float | None,
    asked: Question | None,
    certificates: str | None,
) -> list[Finding]:
    """Return findings about a file; with a budget in a child, and open where that is ended."""
    from ..prove.verifier import budget_of, ignored, no_more, verify_file

    accepted = ignored if certificates is None else partial(write_certificate, Path(certificates))

    def decide(tell: Callable[[Finding], None]) -> list[Finding]:
        with noting() as read:
            found = verify_file(name, only=only, budget=budget, tell=tell, accepted=accepted)
        found = [_plain(f) for f in found]
        if asked is not None:
            keep_findings(asked, read, found)
        return found

    path = path_of(name)
    seconds = budget_of(path, budget)
    if seconds is None:
        return decide(ignored)

    def program(say: Say) -> None:
        def tell(f: Finding) -> None:
            say(_plain(f).as_json(), seconds if _pending(f) else None)

        for f in decide(tell):
            say(f.as_json(), None)

    said = apart(program, READING)
    found: dict[str, Finding] = {}
    for row in said.messages:  # in the order in which they were decided
        found.pop(row["claim"], None)
        found[row["claim"]] = Finding.from_json(row)
    if not said.ended:
        return [x for x in found.values() if not _pending(x)]
    if not found:
        raise unread(path, said)
    error = said.error(seconds)
    why = no_more(error) if isinstance(error, BudgetError) else str(error)
    decided_first = sorted(found.values(), key=_pending)
    return [replace(x, witness=why) if _pending(x) else x for x in decided_first]


def _pending(found: Finding) -> bool:
    """Return whether a claim is open because it was not decided yet."""
    return found.verdict is Verdict.OPEN and not found.witness


def _plain(found: Finding) -> Finding:
    """Return a finding without the exact numbers behind its values, which stay in their process."""
    return replace(found, declared=plain(found.declared), value=plain(found.value))


def check_task(task: Mapping[str, Any]) -> Checked:
    """Carry out the task of checking one file; proofs leave few cycles to collect."""
    with rarely_collected():
        return check(
            task["name"], task["only"], task["budget"], keep=task["keep"],
            certificates=task["certificates"],
        )  # fmt: skip


def check_all(
    names: Sequence[str],
    only: Sequence[str] = (),
    *,
    on: str | None = None,
    budget: float | None = None,
    keep: bool = False,
    certificates: str | None = None,
    function: Function = check_task,
) -> Iterator[Checked]:
    """Check data files, or some of their claims, in order; the options are those of :func:`check`.

    Where nothing is said about the place (see :mod:`glmref.compute.executors`), they are checked
    here until it is seen that what is left takes longer than starting processes. ``function``
    carries out the task of one file.
    """
    same = {"only": list(only), "budget": budget, "keep": keep, "certificates": certificates}
    tasks = [{"name": x, **same} for x in names]
    if on or os.environ.get(ENVIRONMENT):
        with executor(on) as where:
            yield from _checked(tasks, where, function)
        return
    started = perf_counter()
    for done, task in enumerate(tasks):
        elapsed, left = perf_counter() - started, len(names) - done
        pays = done and elapsed > STARTUP / 2 and elapsed / done * left > 2 * STARTUP
        if len(cores()) > 1 and left > 2 and pays:
            where = Local(min(len(cores()), left))
            yield from _checked(tasks[done:], where, function)
            return
        yield function(task)


def _checked(
    tasks: Sequence[Mapping[str, Any]], where: Executor, function: Function
) -> Iterator[Checked]:
    """Check files elsewhere. A file that kills its process costs its own result, no other."""
    for task, done in in_order(where.run(function, tasks, Limits(retries=1)), tasks):
        yield done.value if not done.failure else _lost(task["name"], done)


def _lost(name: str, done: Done) -> Checked:
    sentence = internal_sentence(f"{done.failure}: {done.message}", name)
    return Checked(name, error=sentence, internal=True, trace=done.trace)
