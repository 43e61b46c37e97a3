"""Rules for what the equations of an enclosure imply (section 6)."""

from .enclosed_sweep import Sweep
from .linalg import equal
from .numbers import vanishes
from .refusals import require


def implied(proof, w):
    """Rule implied: what holds at the root of an enclosure."""
    root, claim = proof.root(), proof.claim
    if claim in ("growth", "parasitism-free"):
        count = root.zero_growths()
        require(count is not None, "an eigenvalue has no equation")
        if claim == "growth":
            declared = proof.claimed(proof.declared)
            same = len(declared) == count and vanishes(declared)
            require(same == proof.holds, "the parameters are all 0")
    elif claim == "abscissae":
        require(isinstance(root, Sweep), "the abscissae of pairs")
        found = root.abscissae()
        require(found is not None, "an abscissa is not fixed")
        equal(found, proof.claimed(proof.declared), "the list of abscissae")
    else:
        require(root.implies(claim), f"{claim} does not follow")
