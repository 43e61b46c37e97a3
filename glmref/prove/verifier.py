"""Recompute what a data file claims; refute what a broken one claims."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from ..catalogue.claims import (
    CLAIMS,
    FINISHING_ORDER,
    NYSTROM_ORDER,
    ORDER,
    STARTING_ORDER,
    PlainClaims,
)
from ..catalogue.lookup import is_shipped, method_of, path_of, read_method
from ..catalogue.reader import load_document
from ..errors import (
    BudgetError,
    DataError,
    GlmrefError,
    UndecidedError,
    UsageError,
    did_you_mean,
)
from ..exact import Ball
from ..exact.judging import fast_judge
from ..findings import Finding, Proof, Verdict
from ..judge.claims import concerns
from ..method import Method
from ..system.arguments import listed, number, shown
from ..system.budget import PROVING, limited
from ..system.shown import ShownList
from .facts import Facts, facts_of
from .implications import implied_by
from .plain_orders import ORDERS, order_findings
from .verdicts import Judgement, refuted
from .wrong_entry import suspected

#: What is given each certificate that the judge accepted.
Accepted = Callable[[Mapping[str, Any]], object]


def ignored(*said: object) -> None:
    """Accept any arguments and do nothing."""


def verify(
    method: Method | str | Path,
    *,
    only: Collection[str] = (),
    budget: float | None = None,
    tell: Callable[[Finding], None] = ignored,
) -> list[Finding]:
    """Check every claim the method carries.

    Parameters
    ----------
    method : Method or str or Path
        A method, with its ``claims``, or its name or its file, as :func:`verify_file`.
    only : Collection[str]
        Keys of the claims to check; all by default.
    budget : float or None
        Seconds of processor time for all of them; by default 60 for a file of the user and no limit
        else. What is not decided when they are spent is open.
    tell : callable
        Is called with every claim as an open finding at the start, then with each finding as soon
        as it is decided.

    Raises
    ------
    DataError
        When the method carries no claims.
    UsageError
        For an unknown name, a missing file, or a claim there is not.
    """
    if budget is not None:
        budget = number("budget", budget)
    unknown = [
        key
        for key in listed("only", only, "a list of claims")
        if not isinstance(key, str) or key not in CLAIMS
    ]
    if unknown:
        known = "a finding of verify(method) has the name of its claim"
        hint = did_you_mean(unknown[0], CLAIMS, otherwise=known)
        raise UsageError(f"there is no claim {shown(unknown[0])}; {hint}")
    if isinstance(method, str | Path):
        return ShownList(verify_file(method, only=only, budget=budget, tell=tell))
    own = _with_own_document(method_of(method))
    return _verified(own, only=only, budget=budget, tell=tell, accepted=ignored)


def _with_own_document(method: Any) -> Any:
    """Return the method without a document that is not its own (`dataclasses.replace` keeps it)."""
    if method.document is None or not method.is_exact:
        return method
    return (
        method if _same(load_document(method.document), method) else replace(method, document=None)
    )


def _same(one: Any, other: Any) -> bool:
    """Tell whether two methods, or parts of methods, have the same numbers."""
    if is_dataclass(one):
        names = (x.name for x in fields(one) if x.name not in ("name", "claims", "document"))
        return type(one) is type(other) and all(
            _same(getattr(one, x), getattr(other, x)) for x in names
        )
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return one.overlaps(other) if isinstance(one, Ball) else one == other


def _verified(
    method: Method,
    *,
    only: Collection[str],
    budget: float | None,
    tell: Callable[[Finding], None],
    accepted: Accepted,
) -> list[Finding]:
    """Check every claim of a method whose document is its own, see :func:`verify`."""
    if not _says_anything(method):
        raise DataError(
            f"the method {method.name or '(unnamed)'!r} carries no claims to verify; "
            f"load it from a file, or use analyze() to see what it is"
        )
    asked = {key: x for key, x in claims_of(method).items() if not only or key in only}
    found: list[Finding] = []
    if isinstance(method.claims, PlainClaims):
        found += _plain_orders(method, only, budget, tell)
        asked = {key: x for key, x in asked.items() if key not in ORDERS}
    if not asked:
        return ShownList(found)
    facts: Facts | None = None
    spent = ""
    for claim, declared in asked.items():
        tell(undecided(method, claim, declared, ""))
    with limited(budget):
        for claim, declared in asked.items():
            if spent:
                found.append(undecided(method, claim, declared, spent))
                continue
            try:
                facts = facts or facts_for(method)
                found.append(_with_correction(method, _check(facts, claim, declared, accepted)))
            except BudgetError as error:
                spent = no_more(error)
                found.append(undecided(method, claim, declared, spent))
            except UndecidedError as error:
                # a search that was left half-way is not to be gone on with
                facts = facts and facts_of(method, implied=facts.implied)
                found.append(undecided(method, claim, declared, str(error)))
            tell(found[-1])
    return ShownList(found)


def _plain_orders(
    method: Method, only: Collection[str], budget: float | None, tell: Callable[[Finding], None]
) -> list[Finding]:
    """Judge what a plain document says of orders: see :mod:`.plain_orders`."""
    claims = method.claims
    assert isinstance(claims, PlainClaims)
    said = [x for x in claims.said if not only or x.claim in only]
    for x in said:
        tell(undecided(method, x.claim, x.order, ""))
    try:
        with limited(budget):
            found = order_findings(method)
    except BudgetError as error:
        return [undecided(method, x.claim, x.order, no_more(error)) for x in said]
    if only:
        found = [x for x in found if x.claim in only]
    for x in found:
        tell(x)
    return found


def no_more(error: BudgetError) -> str:
    """Say that a budget is spent, and what may help."""
    return f"{error}; a larger --budget may decide it"


def _says_anything(method: Method) -> bool:
    return bool(method.claims) or bool(getattr(method.claims, "said", ()))


def undecided(method: Method, claim: str, declared: object, reason: str) -> Finding:
    """Say that a claim was not decided, and why."""
    return Finding(
        method=method.name,
        claim=claim,
        declared=declared,
        verdict=Verdict.OPEN,
        proof=Proof.EXACT if method.is_exact else Proof.MEASURED,
        residual=float("nan"),
        witness=reason,
    )


def claims_of(method: Method) -> Mapping[str, Any]:
    """Add the orders that the starting and finishing blocks of a file declare to its claims.

    Raises
    ------
    DataError
        Where a block and a claim disagree.
    """
    claims = dict(method.claims)
    for kind, claim in (("starting", STARTING_ORDER.key), ("finishing", FINISHING_ORDER.key)):
        block = getattr(method, kind, None)
        if block is None or "order" not in block.claims:
            continue
        order = block.claims["order"]
        if claims.setdefault(claim, order) != order:
            raise DataError(
                f"`{kind}.order` is {order} and the claim `{claim}` {claims[claim]}; "
                f"they must agree"
            )
    return claims


def asked_of(method: Method, broken: Mapping[str, Any] | None) -> Mapping[str, Any]:
    """Return claims that are decided: all of :func:`claims_of`, or the one that must fail.

    Raises
    ------
    DataError
        Where the file does not make that claim, and as :func:`claims_of`.
    """
    claims = claims_of(method)
    if broken is None:
        return claims
    claim = broken["claim"]
    if claim not in claims:
        raise DataError(f"`broken.claim` names {claim!r}, which is not among the claims")
    return {claim: claims[claim]}


def facts_for(method: Method) -> Facts:
    """Return facts of a method together with what its enclosure, if its file has one, proves.

    Raises
    ------
    DataError, ExactnessError
        When the file asks for a proof and it cannot be given.
    """
    return facts_of(method, implied=implied_by(method.document, method))


def _with_correction(method: Method, found: Finding) -> Finding:
    """Add the entry that is wrong to a finding that an order is not reached."""
    if found.verdict is not Verdict.FAILS or found.claim not in (ORDER.key, NYSTROM_ORDER.key):
        return found
    least = found.value if isinstance(found.value, int) else 0
    said = suspected(method, least) if isinstance(found.declared, int) else ""
    return replace(found, witness="; ".join(x for x in (found.witness, said) if x))


def _judged(facts: Facts, claim: str, declared: object) -> Judgement:
    if claim not in CLAIMS:
        raise DataError(
            f"the claim {claim!r} of {facts.method.name!r} is unknown; "
            f"known are {', '.join(sorted(CLAIMS))}"
        )
    method = facts.method
    what, kind = "a pair", "rk" if facts.is_single else "partitioned"
    if method.additive:
        what = "a Rosenbrock method" if method.rosenbrock else "an additive method"
        kind = "rosenbrock" if method.rosenbrock else "additive"
    elif (method.document or {}).get("class") == "nystrom":
        kind = "nystrom"
    if not concerns(claim, kind) and not facts.is_single:
        raise DataError(
            f"the claim {claim!r} of {method.name!r} has no meaning for {what}; remove it"
        )
    return facts.judge(claim, declared)


def _check(facts: Facts, claim: str, declared: object, accepted: Accepted = ignored) -> Finding:
    judgement = _judged(facts, claim, declared)
    if isinstance(judgement.certificate, Mapping):
        accepted(judgement.certificate)
    return judgement.finding(facts.method.name, claim, declared)


def verify_file(
    name: str | Path,
    *,
    only: Collection[str] = (),
    budget: float | None = None,
    tell: Callable[[Finding], None] = ignored,
    accepted: Accepted = ignored,
) -> list[Finding]:
    """Check a data file; for one of ``broken/`` the finding is that the named claim fails.

    Parameters
    ----------
    name : str or Path
        A shipped name or a path.
    only : Collection[str]
        Keys of the claims to check; all by default.
    budget : float or None
        Seconds of processor time for its proofs; by default 60 for a file of the user and no limit
        for a shipped one.
    tell : callable
        See :func:`verify`.
    accepted : callable
        Is given each certificate that the judge accepted.

    Raises
    ------
    UsageError, DataError
        For a name or a file that cannot be read.
    """
    path = path_of(name)
    doc, method = read_method(path)
    fast_judge()  # loaded before the time of the proofs counts
    budget = budget_of(path, budget)
    broken = doc.get("broken")
    if broken is not None and only and broken["claim"] not in only:
        return []
    if not _says_anything(method):
        raise DataError(
            f"{path.name}: there is nothing to verify, since the file makes no claims; "
            f"`glmref analyze {path.name}` says what the method is"
        )
    try:
        if broken is None:
            return _verified(method, only=only, budget=budget, tell=tell, accepted=accepted)
        claim = str(broken["claim"])
        tell(undecided(method, f"refutes {claim}", method.claims.get(claim), ""))
        with limited(budget):
            return [_refute(method, broken, accepted)]
    except (BudgetError, UndecidedError) as error:
        reason = no_more(error) if isinstance(error, BudgetError) else str(error)
        claim = str(broken["claim"]) if broken else ""
        return [undecided(method, f"refutes {claim}", method.claims.get(claim), reason)]
    except GlmrefError as error:
        if path.name in str(error):
            raise
        raise type(error)(f"{path.name}: {error}") from error


def budget_of(path: Path, budget: float | None = None) -> float | None:
    """Return seconds of processor time that the proofs of a file may take."""
    return budget if budget is not None or is_shipped(path) else PROVING


def _refute(method: Method, broken: Mapping[str, Any], accepted: Accepted = ignored) -> Finding:
    """Turn the failure of the named claim into a finding that the refutation holds.

    A file may say in ``broken.found`` which witness the refutation must give, word for word.
    """
    ((claim, declared),) = asked_of(method, broken).items()
    facts = facts_for(method)
    inner = _judged(facts, claim, declared)
    if isinstance(inner.certificate, Mapping):
        accepted(inner.certificate)
    expected = broken.get("found", inner.reason) == inner.reason
    reason = inner.reason
    if inner.verdict is Verdict.FAILS and not expected:
        reason = f"it fails for another reason than `broken.found`: {inner.reason}"
    outcome = refuted(inner, reason=reason, as_expected=expected)
    return outcome.finding(facts.method.name, f"refutes {claim}", declared)
