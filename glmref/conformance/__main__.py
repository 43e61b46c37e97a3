"""``python -m glmref.conformance ADAPTER``, and ``glmref conformance``: the suite without pytest.

Exit codes are those of every command of glmref: 0 every check holds, 1 one fails, 2 the adapter or
an option is bad; and as shells count, 130 after Ctrl-C, 143 after SIGTERM, 141 where no one reads
on. Under pytest the codes are pytest's, which has 4 for the last.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from typing import Any

from ..errors import GlmrefError
from ..findings import Finding, Verdict
from ..system.process import guarded
from ..views import tables
from .adapter import load_adapter
from .expected_failures import read_known_failures
from .subject import Subject

HOLDS, FAILED, BAD_ADAPTER = 0, 1, 2
#: Beginning of the witness of a check that was not judged because of another one.
RESTS = "not judged: it rests on"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the checks of one adapter and write what was found."""
    parser = argparse.ArgumentParser(
        prog="python -m glmref.conformance", description="Check an integrator against glmref."
    )
    parser.add_argument("adapter", help="package.module:Name, cmd:program, or a shipped adapter")
    parser.add_argument("--known-failures", metavar="FILE", help="lines `id: reason`")
    parser.add_argument("--format", choices=("table", "json", "csv", "junit"), default="table")
    parser.add_argument("--list", action="store_true", help="write the ids and stop")
    asked = parser.parse_args(arguments)
    return guarded("glmref.conformance", lambda: judge(asked), BAD_ADAPTER)


def judge(asked: argparse.Namespace) -> int:
    """Carry out the request: ``adapter``, ``known_failures``, ``format`` and ``list``."""
    try:
        return _run(asked)
    except GlmrefError as error:
        sys.stderr.write(f"glmref.conformance: {tables.one_line(error)}\n")
        return BAD_ADAPTER


def _run(asked: argparse.Namespace) -> int:
    # what the adapter prints goes to stderr, so that stdout holds the findings and nothing else
    with redirect_stdout(sys.stderr):
        found = _found(asked)
    if asked.list:
        sys.stdout.write("".join(f"{x}\n" for x in found))
        return HOLDS
    _write(found, asked.format)
    return FAILED if any(x.verdict is Verdict.FAILS for x in found) else HOLDS


def _found(asked: argparse.Namespace) -> list[Any]:
    """Return the findings, or the ids where a list was requested."""
    from .checks import Suite

    subject = Subject(load_adapter(asked.adapter), f"the adapter {asked.adapter!r}")
    try:
        suite = Suite(subject)
        ids = [check.id for check in suite.checks]
        if asked.list:
            return ids
        known = {}
        if asked.known_failures:
            known = read_known_failures(asked.known_failures, ids)
        return [_judged(finding, known) for finding in suite.findings()]
    finally:
        subject.close()


def _judged(finding: Finding, known: dict[str, str]) -> Finding:
    """Take known failures into account, strictly: one that does not fail is a failure."""
    reason = known.get(finding.claim)
    if reason is None:
        return finding
    if finding.verdict is Verdict.FAILS:
        witness = f"known failure ({reason}): {finding.witness}"
        return replace(finding, verdict=Verdict.OPEN, witness=witness)
    if finding.verdict is Verdict.HOLDS:
        witness = f"listed as a known failure ({reason}), but it holds: take it off the list"
        return replace(finding, verdict=Verdict.FAILS, witness=witness)
    return finding


def _write(found: list[Finding], form: str) -> None:
    if form == "json":
        text = tables.findings_json(found)
    elif form == "csv":
        text = tables.findings_csv(found)
    elif form == "junit":
        text = tables.findings_junit(found, program="glmref conformance", undecided="skipped")
    else:
        text = _page(found)
    sys.stdout.write(text + "\n")


#: A deviation and, behind it, the name of the defect.
_NAMED = re.compile(r".* \(off by (?P<size>\S+), rounding explains \S+\); (?P<defect>.+)")


def _lines(wrong: list[Finding]) -> list[str]:
    """Return a line for each finding, and one for all checks of a claim with the same defect."""
    lines: dict[tuple[str, str], list[Finding]] = {}
    for finding in wrong:
        named = _NAMED.fullmatch(tables.one_line(finding.witness))
        claim, _, _ = finding.claim.rpartition("/")
        key = (claim, named["defect"]) if named else (finding.claim, "")
        lines.setdefault(key, []).append(finding)
    found = []
    for (claim, defect), group in lines.items():
        said = tables.one_line(group[0].witness)
        if defect:
            places = ", ".join(x.claim.rpartition("/")[2] for x in group)
            claim, size = f"{claim} ({places})", max(x.residual for x in group)
            said = f"{defect}; off by up to {size:.2g}"
        found.append(f"  {str(group[0].verdict).upper()}  {claim}: {said}")
    return found


def _page(found: list[Finding]) -> str:
    """Return what does not hold, method by method; checks that rest on another one are counted."""
    style, parts = tables.Style.of(sys.stdout), []
    for method in dict.fromkeys(finding.method for finding in found):
        mine = [x for x in found if x.method == method]
        wrong = [x for x in mine if x.verdict is not Verdict.HOLDS]
        resting = [x for x in wrong if x.witness.startswith(RESTS)]
        parts.append(f"{style.paint(method, 'bold')}: {len(mine) - len(wrong)} of {len(mine)} hold")
        parts += _lines([x for x in wrong if x not in resting])
        if resting:
            parts.append(f"  {len(resting)} more are not judged: they rest on these")
    counts = {str(v): sum(x.verdict is v for x in found) for v in Verdict}
    parts.append(", ".join(f"{n} {word}" for word, n in counts.items()))
    return "\n".join(parts)


if __name__ == "__main__":
    sys.exit(main())
