"""The pytest plugin: options, and one test for each check.

    pytest --pyargs glmref.conformance --glmref-adapter package.module:Adapter

Nothing is imported here but what pytest has loaded already; the package, numpy and the adapter
come in when the option (or ``$GLMREF_ADAPTER``) is given.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import pytest

from ..errors import GlmrefError
from .adapter import load_adapter
from .expected_failures import read_known_failures
from .subject import Subject

if TYPE_CHECKING:
    from .checks import Check, Suite

VARIABLE = "GLMREF_ADAPTER"
_SUITE = pytest.StashKey["Session"]()


class Session:
    """The suite of the adapter under test, and the failures that are known."""

    def __init__(self, suite: Suite, known: dict[str, str]) -> None:
        self.suite, self.known = suite, known


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("glmref", "conformance of integrators (glmref)")
    group.addoption(
        "--glmref-adapter",
        metavar="ADAPTER",
        help=f"package.module:Name, cmd:program, or a shipped adapter; by default ${VARIABLE}",
    )
    group.addoption(
        "--glmref-known-failures",
        metavar="FILE",
        help="lines `id: reason`; these checks must fail, all others must not",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Load the adapter, so that a bad one is one line and exit code 4."""
    named = config.getoption("--glmref-adapter")
    known = config.getoption("--glmref-known-failures")
    if named is None and (known is not None or _ours(config)):
        # the variable alone does not touch anybody's tests: it is read for a run of ours
        named = os.environ.get(VARIABLE)
        if not named:
            raise pytest.UsageError(
                f"give the integrator: --glmref-adapter package.module:Adapter (or ${VARIABLE})"
            )
    if named is not None:
        config.stash[_SUITE] = _session(named, known)


def _ours(config: pytest.Config) -> bool:
    """Return whether the run names this package."""
    return any(str(x).startswith("glmref.conformance") for x in config.args)


def _session(named: str, known: str | None) -> Session:
    from .checks import Suite

    try:
        suite = Suite(Subject(load_adapter(named), f"the adapter {named!r}"))
        ids = [check.id for check in suite.checks]
        return Session(suite, {} if known is None else read_known_failures(known, ids))
    except GlmrefError as error:
        raise pytest.UsageError(" ".join(str(error).split())) from None


def pytest_unconfigure(config: pytest.Config) -> None:
    """End what the adapter has running."""
    session = config.stash.get(_SUITE, None)
    if session is not None:
        session.suite.subject.close()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Make a test of every check for functions that ask for ``glmref_check``."""
    if "glmref_check" not in metafunc.fixturenames:
        return
    session = metafunc.config.stash.get(_SUITE, None)
    asked = [] if session is None else [_parameter(session, x) for x in session.suite.checks]
    metafunc.parametrize("glmref_check", asked)


def _parameter(session: Session, check: Check) -> Any:
    reason = session.known.get(check.id)
    marks = [] if reason is None else [pytest.mark.xfail(reason=reason, strict=True)]
    return pytest.param(Asked(session, check), id=check.id, marks=marks)


class Asked:
    """One check, ready to be carried out by a test."""

    def __init__(self, session: Session, check: Check) -> None:
        self.session, self.check = session, check

    def __call__(self) -> None:
        """Fail with the sentence of the finding, or skip what cannot be judged."""
        finding = self.session.suite.finding(self.check)
        if str(finding.verdict) == "fails":
            pytest.fail(f"{self.check.id}: {finding.witness}", pytrace=False)
        if str(finding.verdict) == "open":
            pytest.skip(finding.witness)
