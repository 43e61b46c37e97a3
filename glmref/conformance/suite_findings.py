"""What `glmref conformance` says: the findings of an adapter, known failures taken into account."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from ..findings import Finding, Verdict
from ..views import tables
from .adapter import load_adapter
from .checks import Suite
from .expected_failures import read_known_failures
from .subject import Subject
from .verdicts import defect_of

#: Beginning of the witness of a check that was not judged because of another one.
RESTS = "not judged: it rests on"


@contextmanager
def loaded(adapter: str) -> Iterator[Subject]:
    """Load an adapter, and end what it has running."""
    subject = Subject(load_adapter(adapter), f"the adapter {adapter!r}")
    try:
        yield subject
    finally:
        subject.close()


def ids_of(adapter: str) -> list[str]:
    """Return the ids of the checks of an adapter."""
    with loaded(adapter) as subject:
        return [check.id for check in Suite(subject).checks]


def findings_of(adapter: str, known_failures: str | None = None) -> list[Finding]:
    """Run the checks of an adapter; a file has lines ``id: reason`` of those expected to fail.

    Raises
    ------
    UsageError
        For an adapter that cannot be loaded, and a file that cannot be read.
    """
    with loaded(adapter) as subject:
        suite = Suite(subject)
        ids = [check.id for check in suite.checks]
        known = read_known_failures(known_failures, ids) if known_failures else {}
        return [_judged(finding, known) for finding in suite.findings()]


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


def text_of(found: list[Finding], form: str, style: tables.Style) -> str:
    """Return findings in a format: one of :data:`glmref.views.tables.FORMATS`."""
    if form == "json":
        return tables.findings_json(found)
    if form == "csv":
        return tables.findings_csv(found)
    if form == "junit":
        return tables.findings_junit(found, program="glmref conformance", undecided="skipped")
    return _page(found, style)


def _lines(wrong: list[Finding]) -> list[str]:
    """Return a line for each finding, and one for all checks of a claim with the same defect."""
    lines: dict[tuple[str, str], list[Finding]] = {}
    for finding in wrong:
        defect = defect_of(finding.witness)
        claim, _, _ = finding.claim.rpartition("/")
        key = (claim, defect) if defect else (finding.claim, "")
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


def _page(found: list[Finding], style: tables.Style) -> str:
    """Return what does not hold, method by method; checks that rest on another one are counted."""
    parts: list[str] = []
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
