"""Rules for orders and stage orders (section 4)."""

from fractions import Fraction

from .linalg import apply, equal, is_exact, kernel, less, ones
from .numbers import apart, total, vanishes
from .refusals import require, whole
from .series import path_orders
from .trees import (
    PATHS,
    gamma,
    is_coloured,
    is_nystrom,
    mode,
    paths,
    pool_of,
    read_tree,
    show,
    size,
    stands,
    through,
)


def preconsistent(proof, w, consistent=False):
    """Rules preconsistent and consistent."""
    for c in proof.method.parts:
        require(proof.method.vectors_to_one(c, consistent)[0] is not None, "u does not exist")


def not_preconsistent(proof, w, consistent=False):
    """Rules not-preconsistent and no-order-1."""
    require(proof.method.vectors_to_one(w["colour"], consistent)[0] is None, "u may exist")


def asked(proof, w):
    """Return (order, identity?, which trees) of a witness."""
    identity_mode, nystrom = mode(w)
    return whole(w["order"], 0, 20), identity_mode, nystrom


def order_at_least(proof, w):
    """Rule order-at-least: U u = 1, and W R(t) = 0 for every tree through the order."""
    p, identity_mode, nystrom = asked(proof, w)
    series = proof.series(identity_mode, nystrom, p)
    for c, u in series.u.items():
        m = proof.method.part(c)
        equal(apply(m.U, u), ones(len(m.U)), f"U u = 1 ({c})")
    for tree in through(proof.method, p, nystrom):
        require(vanishes(series.condition(tree)), f"the condition of tree {show(tree)}")
    if nystrom in PATHS:  # stages are the solution on the paths below the order
        require(proof.method.separable and series.simple, "paths decide for separable pairs")
        for colour in PATHS[nystrom] if p > 1 else "":
            reached = min(path_orders(proof.method, series, colour, p - 1))
            require(reached >= p - 1, f"a stage of {colour} is not the solution")
    proof.low = p, identity_mode, nystrom


def order_at_most(proof, w):
    """Rule order-at-most: W R(t) is not 0 for a tree of order p + 1."""
    p, identity_mode, nystrom = asked(proof, w)
    series = proof.series(identity_mode, nystrom, p + 1)
    if nystrom in PATHS:
        require(proof.low == (p, identity_mode, nystrom), "paths prove both bounds, or none")
        gaps = [x for t in pool_of(proof.method, p + 1, nystrom) for x in series.condition(t)]
        gaps = gaps if identity_mode else [total(gaps)]  # beta may be added to one, and taken away
    elif not series.simple and p:
        require(series.last == p and not series.loose, "the next order may hold")
        gaps = [1]
    else:
        gaps = series.condition(named_tree(proof, w, p + 1, nystrom))
    require(any(map(apart, gaps)), "the conditions of the next order may hold")
    proof.high = p, identity_mode, nystrom


def named_tree(proof, w, order, nystrom):
    """Return the tree of a witness, which must be one of this order."""
    tree, method = read_tree(w.get("tree")), proof.method
    fine = size(tree) == order and (
        tree in paths(method.palette, order)
        if nystrom in PATHS
        else is_coloured(tree, method.palette)
        and stands(tree, method.system)
        and (not nystrom or is_nystrom(tree))
    )
    require(fine, "the tree has another order")
    return tree


def known_order(proof, q):
    """Return the order that the series of a bound q rests on; without one, an order above it."""
    require(not proof.high or proof.low == proof.high, "the order is not enclosed")
    p = proof.high[0] if proof.high else q + 1
    require(q <= p, "the bound is above the order")
    return p


def stage_defect(series, tree, last):
    """Return xi(t) - c^|t| / gamma(t), z times it at the `last` order: U N beta may be added there.

    z are the rows with z U N = 0.
    """
    c, method = series.stages((tree[0], ())), series.method
    gap = less(series.stages(tree), [x ** size(tree) * Fraction(1, gamma(tree)) for x in c])
    if not last or not series.free or all(m.r == 1 for m in method.parts.values()):
        return gap
    N, U = series.N[tree[0]], method.part(tree[0]).U
    moved = [apply(U, n) for n in N] if len(N) > 1 else [ones(len(U))]  # U u = 1
    require(is_exact(moved), "not covered: decimals in U where the eigenvalue 1 of V is multiple")
    return apply(kernel(moved), gap)


def stage_order_at_least(proof, w):
    """Rule stage-order-at-least; c is what the stages are at the single vertices."""
    q = whole(w["q"])
    require(proof.low and q <= proof.low[0], "the stage order is above the order")
    p, *kind = proof.low
    known = proof.low == proof.high or (proof.high and q < p) or (proof.low[1] and proof.mode()[0])
    require(known, "the order is not enclosed")
    series = proof.series(*kind, q, filled=True)
    for tree in through(proof.method, q, kind[1]):
        fine = size(tree) == 1 or vanishes(stage_defect(series, tree, size(tree) == p))
        require(fine, f"the stages are wrong at tree {show(tree)}")
    return q


def stage_order_at_most(proof, w):
    """Rule stage-order-at-most: where the order is not known, a multiple of ones is free."""
    q, kind = whole(w["q"]), proof.mode()
    p = known_order(proof, q)
    if q == p:
        require(proof.high, "the order is not part of the certificate")
        return q
    tree, series = named_tree(proof, w, q + 1, kind[1]), proof.series(*kind, q + 1, filled=True)
    require(not series.loose, "other principal parts may be right")
    gap = stage_defect(series, tree, q + 1 == p)
    require(any(map(apart, gap)), "the stages may be right at the tree")
    return q
