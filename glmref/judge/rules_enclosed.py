"""Rules for what the equations of an enclosure imply (section 6)."""

from .enclosed_pair import Pair
from .enclosed_rk import RungeKutta
from .enclosed_sweep import Sweep
from .linalg import equal
from .numbers import vanishes
from .parity import finish_with_parity, undoes
from .refusals import keys, require, whole
from .trees import PATHS, mode


def implied_order(proof, w):
    """Rule implied-order."""
    identity_mode, nystrom = mode(w)
    p = whole(w["order"], 1, 20)
    require(nystrom not in PATHS, "paths decide for exact pairs")
    root = proof.root()
    more = (proof.row, proof.method) if isinstance(root, RungeKutta) else ()
    root.order_holds(p, identity_mode, nystrom, *more)
    proof.low = (p, identity_mode, nystrom)


def implied_stage_order(proof, w):
    """Rule implied-stage-order."""
    q = whole(w["q"], 1)
    require(proof.low is not None, "the order is not part of the certificate")
    root = proof.root()
    require(not isinstance(root, Pair), "the stage order of pairs")
    root.stage_order_holds(q, proof.low[0])
    return q


def implied_start(proof, w):
    """Rule implied-start."""
    q = whole(w["q"], 1)
    require(proof.low is not None and q <= proof.low[0], "the order is not part of the certificate")
    table = proof.method.document.get("starting")
    if proof.method.pair:
        pair = proof.root()
        if table is None:
            pair.zero_start_holds(q, proof.low[2])
        else:
            orders = proof.even_orders()
            require(q <= orders[proof.low[2]], "the start has a lower order")
        return q
    require(q == proof.low[0] and table is not None, "the start has another order")
    proof.odd_start(q)
    return q


def implied_finish(proof, w):
    """Rule implied-finish."""
    q, document = whole(w["q"], 1), proof.method.document
    require(proof.low is not None and q == proof.low[0], "the order is not part of the certificate")
    opening, closing = document.get("starting"), document.get("finishing")
    require(closing is not None and opening is not None, "the file has no finish")
    keys(closing, "A b", "name kind order", "finish")
    if undoes(proof.method.numbers, opening, closing):
        return q
    A, B = proof.odd_start(q)
    block = proof.blocks.get("finishing")
    require(block is not None, "the proof of the finish is missing")
    finish_with_parity(block, proof.method.numbers, document, A, B[0], q)
    return q


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
