"""Rules for powers of V and growth parameters (section 5)."""

from itertools import pairwise

from .arithmetic import Fraction
from .linalg import (
    blocks_of,
    characteristic,
    diagonal,
    inverse_matrix,
    is_exact,
    kernel,
    minus,
    rank,
    scale,
    times,
    transpose,
)
from .numbers import apart, conj, real, sign, squared, upper, vanishes
from .polynomials import derivative, divide, from_roots, gcd, horner, is_schur, is_unbounded, plus
from .refusals import require, whole


def bounded(proof, w):
    """Rule bounded: the powers of V are bounded.

    Where V holds decimals: of its diagonal blocks those with decimals have all eigenvalues inside
    the circle, and so have the exact ones but at most one.
    """
    V = proof.method.part(w["which"]).V
    if not is_exact(V):
        others = [block for block in blocks_of(V) if not is_schur(characteristic(block))]
        require(len(others) < 2, "several blocks have eigenvalues on the circle")
        V = others[0] if others else [[Fraction(0)]]
    require(not is_unbounded(V), "an eigenvalue is outside the circle, or defective on it")
    proof.stable.add(w["which"])


def unbounded(proof, w):
    """Rule unbounded: an eigenvalue outside, or a defective one on the circle, or of a block."""
    V = proof.method.part(w["which"]).V
    if "block" in w:
        blocks = blocks_of(V)
        V = blocks[whole(w["block"], 0, len(blocks) - 1)]
    require(is_unbounded(V), "the powers of V are bounded")


def eigen(proof, w):
    """Rule eigen: all eigenvalues of modulus 1, semisimple; the rest of det(x I - V) is Schur."""
    V, found = proof.method.part(w["which"]).V, []
    h = characteristic(V)
    require(is_exact(V) and isinstance(w["zeta"], list), "the eigenvalues are a list, V is exact")
    for z in map(proof.method.numbers.number, w["zeta"]):
        require(squared(z) == 1, "an eigenvalue is not of modulus 1")
        require(all(bool(z - other) for other, _, _ in found), "an eigenvalue is there twice")
        shift = minus(V, diagonal([z] * len(V)))
        N, W = kernel(shift), kernel(transpose(shift))
        require(N, "an eigenvalue is none")
        W = times(inverse_matrix(times(W, transpose(N))), W)
        for _ in N:
            h, rest = divide(h, [-z, Fraction(1)])
            require(vanishes(rest), "an eigenvalue is none")
        found.append((z, W, transpose(N)))
    require(is_schur(h), "another eigenvalue is not inside the circle")
    require(w["which"] not in proof.eigen, "eigen is there twice")
    proof.eigen[w["which"]] = found


def half_turn(z):
    """Return 0 for arguments in [0, pi), 1 for [pi, 2 pi)."""
    if conj(z) == z:
        return 0 if sign(z) > 0 else 1
    return 0 if upper(z) else 1


def comes_before(y, z):
    """Tell whether arg y < arg z in [0, 2 pi), for numbers of modulus 1."""
    if half_turn(y) != half_turn(z):
        return half_turn(y) < half_turn(z)
    order = sign(real(y) - real(z))
    return order > 0 if half_turn(y) == 0 else order < 0


def growth_groups(proof):
    """Return for each eigenvalue of modulus 1 (zeta, matrices (1/zeta) W B U N).

    Pairs: for each shared eigenvalue but 1 the products of W_f B_f with U_k N_k and the like.
    """
    require(set(proof.eigen) == set(proof.method.parts), "eigen is missing for a component")
    for found in proof.eigen.values():
        for before, after in pairwise(found):
            require(comes_before(before[0], after[0]), "arguments do not increase")
    if not proof.method.pair:
        m = proof.method.single()
        return [(z, [scale(conj(z), times(W, m.B, m.U, N))]) for z, W, N in proof.eigen["o"]]
    groups, m = [], proof.method.parts
    single = all(len(W) == 1 for found in proof.eigen.values() for z, W, _ in found if not z - 1)
    left, right = ([z for z, *_ in proof.eigen[c] if all(z - e[0] for e in proof.eigen[d])]
                    for c, d in ("fk", "kf"))  # fmt: skip
    known = single and (proof.method.separable or not left + right)
    one_grows = proof.claim == "parasitism-free" and "grows" in proof.rules
    require(known or one_grows, "1 is multiple, or other eigenvalues meet in shared stages")
    children = dict(proof.method.palette)
    for z, *_ in proof.eigen["f"]:
        spaces = {c: next((e for e in proof.eigen[c] if not bool(e[0] - z)), None) for c in m}
        if not bool(z - 1) or spaces["k"] is None:
            continue
        simple = all(len(e[1]) == 1 for e in spaces.values())
        require(simple or proof.claim == "parasitism-free", "a shared eigenvalue is not simple")
        groups.append((z, [scale(conj(z), times(spaces[c][1], m[c].B, m[e].U, spaces[e][2]))
                           for c, others in children.items() for e in others
                           if e != c or proof.claim == "parasitism-free"]))  # fmt: skip
    return groups


def unshared(proof, w):
    """Rule unshared: V and V^ of a separable pair share the simple eigenvalue 1 and no other."""
    require(proof.method.separable, "the pair is not separable")
    ends = [characteristic(m.V) for m in proof.method.parts.values()]
    require(gcd(*ends) == [-1, 1], "an eigenvalue other than 1 is shared, or none is")
    simple = all(bool(horner(derivative(p), Fraction(1))) for p in ends)
    require(simple, "the eigenvalue 1 is multiple")
    if proof.claim == "growth":
        none = not proof.claimed(proof.declared)
        require(none == proof.holds, "there are no growth parameters")


def growth(proof, w):
    """Rule growth, for the claims growth and parasitism-free; pairs: all are 0."""
    groups, free = growth_groups(proof), proof.claim == "parasitism-free"
    given = declared_groups(proof, groups)
    for (z, matrices), mine in zip(groups, given, strict=True):
        require(vanishes(growth_gap(proof, z, matrices, mine)), "a parameter is another one")
        if free and not proof.method.pair and (bool(z - 1) or len(matrices[0]) > 1):
            require(rank(matrices[0]) == int(not bool(z - 1)), "a growth matrix is not 0")


def growth_gap(proof, z, matrices, numbers):
    """Return numbers that are all 0 where the parameters at an eigenvalue are these.

    One method: det(x I - M) minus the product of (x - mu), times x - 1 for zeta = 1. Pairs: M.
    """
    if proof.method.pair:
        require(vanishes(numbers), "not covered: growth parameters of pairs that are not 0")
        return [x for M in matrices for row in M for x in row]
    one = [] if bool(z - 1) else [Fraction(1)]
    if one and len(matrices[0]) == 1 and not numbers:
        return []  # a simple eigenvalue 1 has no parasitic component
    return plus(characteristic(matrices[0]), from_roots(numbers + one), -1)


def declared_groups(proof, groups):
    """Return the declared list in groups; for parasitism-free zeros."""
    sizes = [sum(len(M) - int(not bool(z - 1)) for M in Ms) for z, Ms in groups]
    if proof.claim == "parasitism-free":
        return [[Fraction(0)] * n for n in sizes]
    numbers = proof.claimed(proof.declared)
    require(len(numbers) == sum(sizes), "the declared list has another length")
    return [[numbers.pop(0) for _ in range(n)] for n in sizes]


def grows(proof, w):
    """Rule grows: the parameters of one part are other ones than declared."""
    free, single = proof.claim == "parasitism-free", not proof.method.pair
    if w["part"] == -1:
        if single:  # the eigenvalues alone say how many there are
            count = sum(len(W) - int(not bool(z - 1)) for z, W, _ in proof.eigen["o"])
        else:
            count = sum(len(M) for _, Ms in growth_groups(proof) for M in Ms)
        require(not free and len(proof.declared) != count, "the number of parameters is right")
        return
    groups = growth_groups(proof)
    k = whole(w["part"], 0, len(groups) - 1)
    z, matrices = groups[k]
    gaps = growth_gap(proof, z, matrices, declared_groups(proof, groups)[k])
    if free and single:
        if not bool(z - 1):
            require(len(matrices[0]) > 1, "a simple eigenvalue 1 has no parasitic component")
            require(rank(matrices[0]) > 1, "the growth matrix of 1 has rank 1")
            return
        gaps = [x for row in matrices[0] for x in row]
    require(any(map(apart, gaps)), "the growth parameters are as declared")
