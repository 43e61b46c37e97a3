"""Rules for what the equations of an enclosure imply (section 6)."""

from __future__ import annotations

from functools import cached_property

from .enclosed_sweep import Sweep
from .linalg import less
from .numbers import vanishes
from .rule import Case, NoWitness, Rule, Truth


class ImpliedCase(Case):
    """A part about what holds at the root of an enclosure."""

    @property
    def claim(self) -> str:
        """Return the claim."""
        return self.proof.claim

    @cached_property
    def growths(self) -> int | None:
        """Return how many growth parameters are 0 by the equations, None where some may not be."""
        return self.proof.root().zero_growths()

    @cached_property
    def abscissae(self) -> list | None:
        """Return the abscissae that the file fixes, None where it does not; those of a sweep."""
        root = self.proof.root()
        return root.abscissae() if isinstance(root, Sweep) else None


def growth_parameters_are_0(case: ImpliedCase) -> bool:
    """Growth: an equation is named for every eigenvalue of modulus 1 but the simple 1."""
    return case.claim not in ("growth", "parasitism-free") or case.growths is not None


def declared_growth_is_0_where_it_holds(case: ImpliedCase) -> bool:
    """The claim `growth` holds where as many 0 are declared as there are parameters, else fails."""
    if case.claim != "growth":
        return True
    return (len(case.claimed) == case.growths and vanishes(case.claimed)) == case.proof.holds


def abscissae_are_fixed(case: ImpliedCase) -> bool:
    """Abscissae: the sweep fixes all, and they are those declared."""
    if case.claim != "abscissae":
        return True
    found = case.abscissae
    if found is None or len(found) != len(case.claimed):
        return False
    return vanishes(less(found, case.claimed))


def claim_follows_from_the_equations(case: ImpliedCase) -> bool:
    """What is claimed follows from the equations, from symmetry or from the form of the file."""
    if case.claim in ("growth", "parasitism-free", "abscissae"):
        return True
    return case.proof.root().implies(case.claim)


ENCLOSED_RULES = (
    Rule(
        "implied", "any", "holds",
        "the equations, the form of the file and its symmetry give what is claimed at the root",
        "docs/certificates.md, 6.5 and 6.8", NoWitness, ImpliedCase,
        (growth_parameters_are_0, declared_growth_is_0_where_it_holds, abscissae_are_fixed,
         claim_follows_from_the_equations),
        lambda case: Truth(case.claim, case.proof.holds),
    ),
)  # fmt: skip
