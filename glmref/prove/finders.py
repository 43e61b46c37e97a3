"""Finders: from what theory computes to what certificates are written of. Nothing is trusted.

One function for each claim that needs a witness, and the sentences that explain a verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from ..catalogue.claims import (
    A_STABLE,
    ABSCISSAE,
    CONJUGATE_SYMPLECTIC,
    CONJUGATE_SYMPLECTIC_ORDER,
    CONSISTENT,
    ERROR_CONSTANT,
    EXPLICIT,
    G_SYMPLECTIC,
    GROWTH,
    L_STABLE,
    PARASITISM_FREE,
    PRECONSISTENT,
    REDUCIBLE,
    SECOND_ORDER_GROWTH,
    SYMMETRIC,
    SYMMETRIC_REDUCED,
    SYMPLECTIC,
    ZERO_STABLE,
)
from ..errors import ExactnessError
from ..exact import Exact
from ..exact.expression import parse, shown_number
from ..theory import polynomials as poly
from ..theory.stability import seems_a_stable, why_not_a_stable
from ..theory.symmetry import Symmetry, symmetry_as_given
from .beside import BESIDE, known_beside
from .ranges import Known

#: :class:`glmref.prove.facts.Facts`, which imports the kernel.
Facts = Any


#: From a truth value and its certificate to a sentence and the size of what decides.
Explain = Callable[[bool, Any], tuple[str, float]]


@dataclass(frozen=True)
class Proposal:
    """What is said of a claim: words and numbers to show.

    Attributes
    ----------
    value : object
        Of a list, what to show.
    explain : Explain
        What is said of a claim that is no order, when the judge has decided it.
    likely : Callable[[], bool]
        A guess whether the claim is true; what is likely is put to the judge first.
    """

    value: object = None
    explain: Explain = lambda truth, certificate: ("", 0.0)
    likely: Callable[[], bool] = lambda: True


def proposal_for(facts: Facts, claim: str) -> Proposal:
    """Return what to hand to the kernel for one claim of one method."""
    return _FINDERS.get(claim, _nothing)(facts)


def _nothing(facts: Facts) -> Proposal:
    return Proposal()


def _told(results: Callable[[], Any]) -> Explain:
    """Return sentence and residual of theory's records, where the claim was not proved true."""

    def explain(truth: bool, certificate: object) -> tuple[str, float]:
        if truth:
            return "", 0.0
        try:
            found = results()
        except ExactnessError as error:
            return str(error), 0.0
        parts = found if isinstance(found, tuple) else (found,)
        size = max((getattr(x, "residual", 0.0) for x in parts), default=0.0)
        return "; ".join(x.witness for x in parts if x.witness), size

    return explain


def _beside(claim: str) -> Callable[[Facts], Proposal]:
    """Return what is said of a claim about what stands beside a tableau, where it is not true."""

    def propose(facts: Facts) -> Proposal:
        def explain(truth: bool, certificate: object) -> tuple[str, float]:
            known = Known(True) if truth else known_beside(facts, claim)
            return known.reason, known.residual

        return Proposal(explain=explain)

    return propose


def _recorded(of: Callable[[Facts], Any]) -> Callable[[Facts], Proposal]:
    """Return what theory's records say of a claim."""
    return lambda facts: Proposal(explain=_told(lambda: of(facts)))


def _explicit(facts: Facts) -> Proposal:
    def explain(truth: bool, certificate: object) -> tuple[str, float]:
        known = "every stage is a known vector when its turn comes"
        return (known if truth else "an implicit stage needs an equation solved"), 0.0

    return Proposal(explain=explain, likely=lambda: bool(facts.method.is_explicit))


def _stable(facts: Facts) -> Proposal:
    def explain(truth: bool, certificate: Mapping[str, Any]) -> tuple[str, float]:
        rule, witness = certificate["parts"][-1].values()
        if truth:
            return "", 0.0
        if rule == "not-l-limit":
            return "the eigenvalues of M(z) do not all tend to 0 as z goes to infinity", 0.0
        return why_not_a_stable(facts.linear, witness), 0.0

    return Proposal(explain=explain, likely=lambda: seems_a_stable(facts.linear))


def _symplectic(facts: Facts) -> Proposal:
    if not facts.is_one_step:
        several = "a method that carries several values has no symplectic step"
        return Proposal(explain=lambda truth, certificate: (several, 0.0))
    return Proposal(explain=_told(lambda: facts.g_symplecticity))


def _conjugate_symplectic(facts: Facts) -> Proposal:
    def explain(truth: bool, certificate: object) -> tuple[str, float]:
        key = CONJUGATE_SYMPLECTIC_ORDER.key
        return ("" if truth else facts.kernel.range(key).sentence), 0.0

    return Proposal(explain=explain)


def _as_given(facts: Facts) -> Symmetry:
    """Return the symmetry of the method itself, not of that without idle values."""
    return symmetry_as_given(facts.method) if facts.symmetry.reduced else facts.symmetry


def _parasitism(facts: Facts) -> Proposal:
    told = _told(lambda: facts.parasitism)

    def explain(truth: bool, certificate: Mapping[str, Any]) -> tuple[str, float]:
        if certificate["parts"][0]["rule"] == "unbounded":
            return "V is not power-bounded: parasitic components grow anyway", 0.0
        return told(truth, certificate)

    return Proposal(explain=explain)


def _listed(what: str, values: Callable[[], Any], shown: list[str] | None = None) -> Explain:
    """Return how numbers that were found differ from those declared."""

    def explain(truth: bool, certificate: Mapping[str, Any]) -> tuple[str, float]:
        if truth:
            return "", 0.0
        if certificate["parts"][0]["rule"] == "unbounded":
            return f"V is not power-bounded: {what} are not defined", 0.0
        declared, found = certificate["statement"]["declared"], values()
        texts = declared if isinstance(declared, list) else [declared]
        if found is None:
            return f"the method has no {what}", 0.0
        count = len(found) if shown is None else len(shown)
        counted = certificate["parts"][-1]["witness"].get("part", -1) < 0
        if count != len(texts) and counted:
            return f"{count} {what} found, {len(texts)} declared", 0.0
        if count != len(found) or count != len(texts):
            return f"the growth matrix has the eigenvalues {', '.join(shown or ())}", 0.0
        gaps = [x - parse(text) for x, text in zip(found, texts, strict=True)]
        at = next((k for k, x in enumerate(gaps) if x.is_zero() is False), None)
        if at is None:
            return "", 0.0
        size = max(x.magnitude() for x in gaps if x.is_zero() is not True)
        number = shown_number(found[at])
        return f"number {at + 1} of the {what} is {number}, declared is {texts[at]}", size

    return explain


def _growth(facts: Facts) -> Proposal:
    shown = _shown_growth(facts)
    explain = _listed("growth parameters", lambda: facts.growth_parameters, shown)
    return Proposal(shown, explain)


def _shown_growth(facts: Facts) -> list[str]:
    """Return the numbers to show, approximate for a multiple eigenvalue without exact ones."""
    shown = []
    for g in facts.parasitism.growths if facts.is_single else ():
        if g.mu is None:
            roots = poly.approximate_roots(poly.characteristic(g.matrix))
            roots = sorted(roots, key=lambda x: abs(x - 1))
            shown += [f"{x.real:.12g}" if abs(x.imag) < 1e-12 else f"{x:.12g}" for x in roots]
        else:
            shown.append(shown_number(g.mu))
    return shown or [shown_number(x) for x in facts.growth_parameters]


def _second_order_growth(facts: Facts) -> Proposal:
    shown = None
    with suppress(ExactnessError):  # the kernel says why
        shown = [shown_number(x) for x in facts.kernel.invariants]
    explain = _listed("invariants of second order", lambda: facts.kernel.invariants)
    return Proposal(shown, explain)


def _abscissae(facts: Facts) -> Proposal:
    c = facts.abscissae
    shown = None if c is None else [shown_number(x) for x in c]
    return Proposal(value=shown, explain=_listed("abscissae", lambda: c))


def _error_constant(facts: Facts) -> Proposal:
    found, multistep = facts.quadrature_error, getattr(facts.method, "multistep", None)
    if multistep is not None and sum(multistep[1], Exact(0)).is_zero() is not False:
        found = None
    shown = None if found is None else [shown_number(x) for x in found]
    return Proposal(value=shown, explain=_listed("error constant", lambda: found))


def _reducible(facts: Facts) -> Proposal:
    def explain(truth: bool, certificate: object) -> tuple[str, float]:
        return facts.reduction.witness, 0.0

    return Proposal(explain=explain)


_FINDERS: Mapping[str, Callable[[Facts], Proposal]] = {
    PRECONSISTENT.key: _recorded(lambda facts: facts.consistencies),
    CONSISTENT.key: _recorded(lambda facts: facts.consistencies),
    ZERO_STABLE.key: _recorded(lambda facts: facts.zero_stabilities),
    EXPLICIT.key: _explicit,
    SYMPLECTIC.key: _symplectic,
    G_SYMPLECTIC.key: _recorded(lambda facts: facts.g_symplecticity),
    CONJUGATE_SYMPLECTIC.key: _conjugate_symplectic,
    SYMMETRIC.key: _recorded(_as_given),
    SYMMETRIC_REDUCED.key: _recorded(lambda facts: symmetry_as_given(facts.reduced)),
    PARASITISM_FREE.key: _parasitism,
    GROWTH.key: _growth,
    SECOND_ORDER_GROWTH.key: _second_order_growth,
    ABSCISSAE.key: _abscissae,
    ERROR_CONSTANT.key: _error_constant,
    REDUCIBLE.key: _reducible,
    A_STABLE.key: _stable,
    L_STABLE.key: _stable,
    **{key: _beside(key) for key in BESIDE},
}
