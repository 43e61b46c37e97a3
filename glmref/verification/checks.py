"""One checker for each claim a data file can make.

A checker reads the method's :class:`~.facts.Facts` and returns an :class:`Outcome`; what
verdict follows is decided in :mod:`.verifier`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import DataError, ExactnessError
from ..exact import Exact, Scalar
from ..exact.expression import Text, parse, to_text
from ..findings import Proof
from ..theory.facts import Facts, GLMFacts, PairFacts

if TYPE_CHECKING:
    from ..theory.order import OrderResult

__all__ = ["CHECKS", "FOR_ONE_METHOD", "Outcome", "all_of", "shown_number"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a checker says about one claim.

    Attributes
    ----------
        holds: whether the claim holds, ``None`` where it could not be decided.
        value: the recomputed value, JSON-ready.
        residual: largest violation of the identities behind the claim.
        witness: the sentence that names what decides.
    """

    holds: bool | None
    value: object
    residual: float = 0.0
    witness: str = ""


#: Largest residual at which an identity over balls counts as holding: it vanishes to within the
#: width of the published digits. That is a measurement; it is the proof of a true zero only for
#: the claims that the enclosure of the file proves (:meth:`.facts.Facts.proof_of`).
CLOSED = 1e-12


def _decision(facts: Facts, holds: bool | None, residual: float) -> bool | None:
    """Close what balls leave open where the identities vanish to within the published digits."""
    if holds is None and facts.proof is not Proof.EXACT and residual <= CLOSED:
        return True
    return holds


def _joined(witnesses: Iterable[str]) -> str:
    return "; ".join(x for x in witnesses if x)


def _compare(found: bool | None, declared: object, residual: float, witness: str) -> Outcome:
    return Outcome(None if found is None else found == declared, found, residual, witness)


def _order(facts: Facts, declared: object, result: OrderResult) -> Outcome:
    """Order exactly as declared: every tree up to it holds and some tree beyond it fails."""
    value: object = result.order
    size = 0.0 if result.residual is None else result.residual.magnitude()
    residual = result.largest_residual if result.order == declared else size
    holds: bool | None = result.order == declared
    if result.undecided and _decision(facts, None, result.largest_residual) is None:
        holds = None
    if not result.decided and result.order != declared:
        holds = None
    if result.at_least:  # nothing fails as far as trees are compared
        holds = None if int(declared) >= result.order else False  # type: ignore[call-overload]
    return Outcome(holds, value, residual, result.witness)


def _check_order(facts: Facts, declared: object) -> Outcome:
    return _order(facts, declared, facts.classical_order)


def _check_order_identity(facts: Facts, declared: object) -> Outcome:
    return _order(facts, declared, facts.order_identity)


def _check_effective_order(facts: Facts, declared: object) -> Outcome:
    return _order(facts, declared, facts.order)


def _check_nystrom_order(facts: PairFacts, declared: object) -> Outcome:
    return _order(facts, declared, facts.nystrom_order)


def _check_reducible(facts: PairFacts, declared: object) -> Outcome:
    found = facts.reduction
    return _compare(found.reducible, declared, 0.0, found.witness)


def _check_stage_order(facts: Facts, declared: object) -> Outcome:
    result = facts.classical_order
    found = result.stage_order
    # over balls a stage condition counts as holding to within the width of the digits
    open_ = facts.proof is not Proof.EXACT and result.largest_residual > CLOSED
    return Outcome(None if open_ else found == declared, found, witness=f"found {found}")


def _check_starting_order(facts: GLMFacts | PairFacts, declared: object) -> Outcome:
    found, witness = facts.starting_order
    return Outcome(found == declared, found, witness=witness)


def _check_nystrom_starting_order(facts: PairFacts, declared: object) -> Outcome:
    found, witness = facts.nystrom_starting_order
    return Outcome(found == declared, found, witness=witness)


def _check_finishing_order(facts: GLMFacts, declared: object) -> Outcome:
    found, witness = facts.finishing_order
    return Outcome(found == declared, found, witness=witness)


def _check_consistent(facts: Facts, declared: object, *, which: str = "consistent") -> Outcome:
    parts = facts.consistencies
    answers = [_decision(facts, getattr(c, which), c.residual) for c in parts]
    residual = max(c.residual for c in parts)
    witness = _joined(c.witness for c in parts)
    return _compare(all_of(answers), declared, residual, witness)


def _check_preconsistent(facts: Facts, declared: object) -> Outcome:
    return _check_consistent(facts, declared, which="preconsistent")


def all_of(answers: Iterable[bool | None]) -> bool | None:
    """Conjunction in three values."""
    seen = list(answers)
    if False in seen:
        return False
    return None if None in seen else True


def _check_zero_stable(facts: Facts, declared: object) -> Outcome:
    parts = facts.zero_stabilities
    return _compare(
        all_of(b.holds for b in parts), declared, 0.0, _joined(b.witness for b in parts)
    )


_ALL_EXPLICIT = "every stage is a known vector when its turn comes"


def _check_explicit(facts: Facts, declared: object) -> Outcome:
    witness = _ALL_EXPLICIT if facts.is_explicit else "an implicit stage needs an equation solved"
    return _compare(facts.is_explicit, declared, 0.0, witness)


def _check_g_symplectic(facts: Facts, declared: object) -> Outcome:
    found = facts.g_symplecticity
    holds = _decision(facts, found.holds, found.residual)
    return _compare(holds, declared, found.residual, found.witness)


def _check_symplectic(facts: Facts, declared: object) -> Outcome:
    if not facts.is_one_step:
        witness = "a method that carries several values has no symplectic step"
        return _compare(False, declared, 0.0, witness)
    return _check_g_symplectic(facts, declared)


def _check_symmetric(facts: Facts, declared: object) -> Outcome:
    found = facts.symmetry
    holds = _decision(facts, found.holds, found.residual)
    return _compare(holds, declared, found.residual, found.witness)


def _check_parasitism_free(facts: Facts, declared: object) -> Outcome:
    found = facts.parasitism
    free = _decision(facts, found.free, found.residual)
    return _compare(free, declared, found.residual, found.witness)


def _values_agree(
    facts: Facts, found: Sequence[Scalar] | None, declared: object, what: str
) -> Outcome:
    """Compare a list of numbers with a declared list of expressions, entry by entry."""
    texts = list(declared) if isinstance(declared, list) else [declared]
    if found is None:
        return Outcome(False, None, witness=f"the method has no {what}")
    value = [shown_number(x) for x in found]
    if len(found) != len(texts):
        return Outcome(False, value, witness=f"{len(found)} {what} found, {len(texts)} declared")
    residual, holds, witness = 0.0, True, ""
    for k, (x, text) in enumerate(zip(found, texts, strict=True)):
        difference = x - (text.value if isinstance(text, Text) else parse(str(text)))
        size = difference.magnitude()
        answer = _decision(facts, difference.is_zero(), size)
        if answer is not True:  # the first that fails is named, or else the first left open
            if not witness or (answer is False and holds is not False):
                witness = f"number {k + 1} of the {what} is {value[k]}, declared is {text}"
            holds = all_of((holds, answer))
        if difference.is_zero() is not True:
            residual = max(residual, size)
    return Outcome(holds, value, residual, "" if holds else witness)


def shown_number(x: Scalar) -> str:
    """Return a number as an exact expression where it has one, else as a decimal."""
    try:
        return to_text(x) if isinstance(x, Exact) else f"{complex(x).real:.17g}"
    except (ExactnessError, DataError):
        z = complex(x)
        return f"{z.real:.17g}" if z.imag == 0 else f"{z:.17g}"


def _check_growth(facts: Facts, declared: object) -> Outcome:
    return _values_agree(facts, facts.growth_parameters, declared, "growth parameters")


def _check_abscissae(facts: GLMFacts, declared: object) -> Outcome:
    return _values_agree(facts, facts.abscissae, declared, "abscissae")


def _check_error_constant(facts: GLMFacts, declared: object) -> Outcome:
    return _values_agree(facts, facts.quadrature_error, [declared], "error constant")


def _check_a_stable(facts: GLMFacts, declared: object) -> Outcome:
    found = facts.a_stability
    return _compare(found.holds, declared, 0.0, found.witness)


def _check_l_stable(facts: GLMFacts, declared: object) -> Outcome:
    found = facts.l_stability
    return _compare(found.holds, declared, 0.0, found.witness)


CHECKS: Mapping[str, Callable[[Any, object], Outcome]] = {
    "order": _check_order,
    "order-identity": _check_order_identity,
    "effective-order": _check_effective_order,
    "nystrom-order": _check_nystrom_order,
    "stage-order": _check_stage_order,
    "starting-order": _check_starting_order,
    "nystrom-starting-order": _check_nystrom_starting_order,
    "finishing-order": _check_finishing_order,
    "preconsistent": _check_preconsistent,
    "consistent": _check_consistent,
    "zero-stable": _check_zero_stable,
    "explicit": _check_explicit,
    "symplectic": _check_symplectic,
    "g-symplectic": _check_g_symplectic,
    "symmetric": _check_symmetric,
    "parasitism-free": _check_parasitism_free,
    "reducible": _check_reducible,
    "growth": _check_growth,
    "abscissae": _check_abscissae,
    "error-constant": _check_error_constant,
    "a-stable": _check_a_stable,
    "l-stable": _check_l_stable,
}

#: Claims that have no meaning for a pair.
FOR_ONE_METHOD = frozenset(
    {"finishing-order", "abscissae", "error-constant", "a-stable", "l-stable"}
)
