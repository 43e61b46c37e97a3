"""Rules for explicit stages, abscissae, error constants, reducibility (section 5)."""

from copy import copy
from math import factorial

from .arithmetic import Fraction
from .document import Component
from .linalg import apply, dot, equal, kernel, less, multiples, rank, times, transpose
from .numbers import apart, inverse, is_nil, total, vanishes
from .refusals import Refused, require


def needs(method, surely=False):
    """Return {stage: stages it needs}, exact zeros left out; or those that it surely needs."""

    def counts(x):
        return not is_nil(x) and (not surely or apart(x))

    if not method.separable:
        n = len(next(iter(method.parts.values())).A)
        return {i: {j for j in range(n)
                    if any(counts(m.A[i][j]) for m in method.parts.values())}
                for i in range(n)}  # fmt: skip
    q, p = method.parts["f"], method.parts["k"]
    both = (("Q", "P", q.A), ("P", "Q", p.A))
    return {f"{x}{i}": {f"{y}{j}" for j, entry in enumerate(row, 1) if counts(entry)}
            for x, y, A in both for i, row in enumerate(A, 1)}  # fmt: skip


def later(needed):
    """Return the stages left over when one after another is evaluated: each needs one of them."""
    done = set()
    while ready := {stage for stage, x in needed.items() if x <= done} - done:
        done |= ready
    return set(needed) - done


def explicit(proof, w):
    """Rule explicit: each stage needs earlier ones only, in some order."""
    require(not later(needs(proof.method)), "a stage needs a later one")


def implicit(proof, w):
    """Rule implicit: some stages surely need each other."""
    require(later(needs(proof.method, surely=True)), "the stages may be explicit")


def abscissae_of(proof):
    """Return c = A 1 + U v of each part, v with 0 in what is read as the solution.

    Where 1 is a multiple eigenvalue of V, v is known up to N beta, and U v must be the same for all
    that have 0 there.
    """
    require(not proof.method.pair, "the abscissae of pairs")
    series, found = proof.series(True, False, 1, filled=True), []
    for colour, m in proof.method.parts.items():
        leaf, N, w = (colour, ()), series.N[colour], series.w[colour]
        c = series.stages(leaf)
        if len(N) > 1:
            reads = apply(N, w)
            unseen = [apply(m.U, apply(transpose(N), beta)) for beta in kernel([reads])]
            require(vanishes(unseen), "v, and with it c, is not the only one")
            j = next(j for j, x in enumerate(reads) if apart(x))
            factor = dot(w, series.eta_of(leaf)) * inverse(reads[j])
            c = less(c, multiples(factor, apply(m.U, N[j])))
        found += c
    return found


def abscissae(proof, w):
    """Rule abscissae, of a consistent method."""
    exist = (proof.method.vectors_to_one(c, True)[0] is not None for c in proof.method.parts)
    require(all(exist), "u does not exist")
    equal(abscissae_of(proof), proof.claimed(proof.declared), "the list of abscissae")


def other_abscissae(proof, w):
    """Rule other-abscissae: c is the only one there may be, and another one."""
    c, given = abscissae_of(proof), proof.claimed(proof.declared)
    fine = len(c) != len(given) or any(map(apart, less(c, given)))
    require(fine, "the abscissae may be as declared")


def error_constant(proof, w, same=True):
    """Rules error-constant and other-error-constant."""
    require(proof.method.kind in ("lmm", "one-leg"), "only multistep methods have one")
    alpha, beta = proof.method.multistep()
    for q in range(40):
        C = dot(alpha, [Fraction(m**q) for m in range(len(alpha))])
        if q:
            C = C - q * dot(beta, [Fraction(m ** (q - 1)) for m in range(len(beta))])
        if C:
            break
    require(C, "the order is another one")
    if not same and vanishes(total(beta)):
        return  # no error constant
    C = C * Fraction(1, factorial(q)) * inverse(total(beta))
    gap = C - proof.claimed([proof.declared])[0]
    require(vanishes(gap) if same else bool(gap), "the error constant is (not) the declared one")


def ranks_are_less(method, c):
    """Tell whether a value is never seen, and never reached, None where intervals leave it open."""
    m, seen = method.part(c), list(method.part(c).U)
    for _ in range(m.r - 1):
        seen += times(seen[-len(m.U) :], m.V)

    def reached():
        u, _ = method.vectors_to_one(c)  # the difference of two is never seen
        rows = ([u] if u else []) + transpose(m.B)
        for _ in range(m.r - 1):
            rows += [apply(m.V, x) for x in rows[-len(m.B[0]) :]]
        return rows

    for rows in (lambda: seen, reached):
        try:
            yield rank(rows()) < m.r
        except Refused:
            yield None


def reducible(proof, w, wanted=True):
    """Rules reducible and irreducible: whether a value is never reached or never seen."""
    found = {x for c in proof.method.parts for x in ranks_are_less(proof.method, c)}
    require(True in found if wanted else found == {False}, "the method is reducible, or is not")


def equivalent(proof, w):
    """Rule equivalent: the method with the same A and these U, B, V makes the same steps.

    U V^k B agree for k < r + r'. The parts that follow are about this method.
    """
    m, read = proof.method.single(), proof.method.numbers
    U, B, V = (read.matrix(w[key]) for key in "UBV")
    other = copy(proof.method)
    other.parts = {"o": Component(m.A, U, B, V)}
    other.check_shapes()
    left, right = m.U, U
    for _ in range(m.r + len(V)):
        equal(times(left, m.B), times(right, B), "U V^k B")
        left, right = times(left, m.V), times(right, V)
    proof.method = other
