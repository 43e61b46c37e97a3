"""Which parts prove which statement, and the answer to a certificate (section 7)."""

from __future__ import annotations

from threading import RLock

from .claims import (
    AS_EXACT,
    MODIFIED,
    ORDERS,
    SECOND,
    VALUES,
    alternatives,
    concerns,
    lacks_block,
)
from .document import rows_of
from .proof import Proof, record_of
from .refusals import Beyond, Malformed, Refused, as_object, require, whole
from .rule import Bound, Bounded, RowOrder, Rule
from .rules_digits import DIGIT_RULES
from .rules_enclosed import ENCLOSED_RULES
from .rules_growth import GROWTH_RULES
from .rules_modified import MODIFIED_RULES
from .rules_orders import ORDER_RULES
from .rules_residues import RESIDUE_RULES
from .rules_rows import ROW_RULES, check_rows
from .rules_second_growth import SECOND_RULES
from .rules_stability import STABILITY_RULES
from .rules_starts import START_RULES
from .rules_structure import STRUCTURE_RULES
from .rules_symmetry import SYMMETRY_RULES
from .rules_symplectic import FORM_RULES

#: The rules by name.
RULES: dict[str, Rule] = {
    rule.name: rule
    for family in (
        ORDER_RULES, START_RULES, GROWTH_RULES, RESIDUE_RULES, FORM_RULES, SYMMETRY_RULES,
        STRUCTURE_RULES, STABILITY_RULES, ROW_RULES, DIGIT_RULES, ENCLOSED_RULES,
        MODIFIED_RULES, SECOND_RULES,
    )
    for rule in family
}  # fmt: skip

#: What is kept for the next certificate is completed by one thread at a time.
ONE_THREAD = RLock()


def has_meaning(proof: Proof) -> bool:
    """Tell whether the claim has a meaning for the class of the file."""
    kind = proof.record.method.kind
    return concerns(proof.claim, kind) and not lacks_block(proof.claim, kind)


def check_declared(proof: Proof) -> None:
    """Refuse a declared value of another type than the claim has."""
    claim, declared = proof.claim, proof.declared
    if claim in (*ORDERS, *SECOND, "dense-order"):
        whole(declared)
    elif claim == "embedded-order":
        for order in as_object(declared).values():
            whole(order)
    elif claim in VALUES:  # order-to-digits is read by its rules
        kind = {"error-constant": str, "order-to-digits": dict}.get(claim, list)
        texts = not isinstance(declared, list) or all(isinstance(x, str) for x in declared)
        require(type(declared) is kind and texts, "the declared value is of another type")
    elif type(declared) is not bool:
        raise Malformed("the claim is true or false")


def fits(proof: Proof) -> bool:
    """Tell whether the parts are such as prove statements of this kind."""
    claim, rules, truth = proof.claim, proof.rules, proof.holds
    if claim in (*ORDERS, *SECOND):
        return fits_order(proof)
    if claim not in (*VALUES, "dense-order"):
        truth = proof.declared == proof.holds
    exact = proof.kind in ("rational", "tower")
    more = "|implied" if not exact and (truth or claim == "growth") else ""
    often = {"*": len(proof.method.parts), "+": len(rows_of(proof.method.document))}
    return rules in alternatives(claim if exact or claim in AS_EXACT else "", truth, often, more)


def fits_order(proof: Proof) -> bool:
    """Tell whether the parts are about orders: what they show is compared with the claim."""
    rules, name = proof.rules, SECOND.get(proof.claim, "order")
    names = {f"{name}-at-least", f"{name}-at-most"}
    if proof.claim not in MODIFIED:  # those of the modified equation may exceed the order
        names |= {"order-at-least", "implied-order", "order-at-most", "no-order-1",
                  "not-preconsistent", "symmetric", f"implied-{name}"}  # fmt: skip
    known = "order-at-most" in rules or not any(x.startswith("implied") for x in rules)
    return set(rules) <= names and len(set(rules)) == len(rules) and (known or not proof.holds)


def decide_order(proof: Proof, quantity: str) -> None:
    """Refuse bounds that do not decide the declared order; no order is below 0."""
    bound = proof.known.get(quantity, Bound(quantity))
    low, high, p = bound.low or 0, bound.high, whole(proof.declared)
    if proof.rules == ["order-at-most"]:  # no order is above that of the method
        high = proof.known["order"].high
    if {"no-order-1", "not-preconsistent"} & set(proof.rules):
        low = high = 0
    decided = low == p == high if proof.holds else p < low or (high is not None and high < p)
    require(decided, f"the parts show {low} <= order <= {high}")
    for shown in proof.known.values() if quantity != "dense-order" else ():
        found = shown.identity, shown.trees in (True, "nystrom-paths")
        require(found == proof.mode(), "principal or trees are not those of the claim")


def decide(proof: Proof) -> None:
    """Check that the parts are those of the statement, and each of them, and what they show."""
    claim = proof.claim
    require(has_meaning(proof), f"{claim} has no meaning for the class of the file")
    check_declared(proof)
    fine = proof.rules == ["absent"] or fits(proof)
    require(fine, f"these parts do not prove {claim}: {proof.rules}")
    for part in proof.parts:
        proof.apply(part)
    if proof.rules == ["absent"]:
        return
    if claim == "embedded-order":
        rows = set(proof.method.rows())
        check_rows(proof.holds, as_object(proof.declared), rows, proof.all_shown(RowOrder))
    elif claim in (*ORDERS, *SECOND, "dense-order"):
        decide_order(proof, SECOND.get(claim, "dense-order" if claim == "dense-order" else "order"))
    if claim == "zero-stable" and "bounded" in proof.rules:
        fine = {x.colour for x in proof.all_shown(Bounded)} == set(proof.method.parts)
        require(fine, "V of one component is missing")


def judged(certificate: object) -> str:
    """Return the sentence of a certificate that proves its statement.

    Raises
    ------
    Refused
        If it proves nothing: the class says why, the text is one sentence.
    """
    proof = Proof(certificate, RULES)
    decide(proof)
    name, claim = str(proof.method.document["name"])[:100], proof.claim_text[:300]
    word = "holds" if proof.holds else "fails"
    return f"{name}: {claim} {word} ({', '.join(proof.rules)})"


def verdict(certificate: object) -> tuple[bool, str]:
    """Return (accepted, sentence) for the value of one JSON file, whatever it holds."""
    with ONE_THREAD:
        return answer(certificate)


def answer(certificate: object) -> tuple[bool, str]:
    """Return (accepted, sentence); forget the record where something may be left half made."""
    try:
        return True, judged(certificate)
    except Beyond as error:  # the end of the time may come anywhere
        record_of.cache_clear()
        return False, str(error)
    except Refused as error:
        return False, str(error)
    except (ArithmeticError, MemoryError, RecursionError):
        record_of.cache_clear()
        return False, "beyond the limits of this checker"
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        record_of.cache_clear()
        return False, f"a part has another shape ({type(error).__name__})"
    except BaseException:  # Ctrl-C, or the end of a budget
        record_of.cache_clear()
        raise
