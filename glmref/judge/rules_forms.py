"""Rules for quadratic forms (section 5)."""

from itertools import product

from .arithmetic import Fraction
from .linalg import (
    apply,
    combine,
    diagonal,
    dot,
    entries,
    equal,
    less,
    minus,
    solve,
    star,
    times,
    transpose,
)
from .numbers import apart, conj, vanishes
from .refusals import keys, not_covered, require


def form_defects(method, G, D, star_=star):
    """Return left - right of each identity; D is a list, for pairs (D_P, D_Q)."""
    if not method.pair:
        m = method.parts["o"]
        B, E = star_(m.B), diagonal(D)
        return [minus(G, times(star_(m.V), G, m.V)), minus(times(E, m.U), times(B, G, m.V)),
                minus(combine(times(E, m.A), times(star_(m.A), E)), times(B, G, m.B)),
                minus([D], star_(transpose([D]))),
                minus(G, star_(G))]  # fmt: skip
    q, p, (D_P, D_Q) = method.parts["f"], method.parts["k"], map(diagonal, D)
    shared = [] if method.separable else [[less(*D)]]
    return [minus(times(star_(q.V), G, p.V), G), minus(times(D_P, p.U), times(star_(q.B), G, p.V)),
            minus(times(D_Q, q.U), times(star_(p.B), star_(G), q.V)), *shared,
            minus(combine(times(D_P, p.A), times(star_(q.A), D_Q)), times(star_(q.B), G, p.B)),
            minus([D[0] + D[1]], star_(transpose([D[0] + D[1]])))]  # fmt: skip


def energy(method, G):
    """Return u^* G u, for pairs u^* G u^."""
    first, last = next(iter(method.parts)), list(method.parts)[-1]
    return dot([conj(x) for x in method.u(first)], apply(G, method.u(last)))


def given_form(method):
    """Return (G, {name: D}) of what the file gives; G is None where it gives none."""
    G = method.form() if "G" in method.document else None
    names = () if method.kind == "pair-sweep" else ("D_P", "D_Q") if method.pair else ("D",)
    return G, {name: method.list(name) for name in names if name in method.document}


def form(proof, w):
    """Rule form: G and D satisfy the identities; they are those of the file if it has some."""
    method, read = proof.method, proof.method.numbers
    names = ("D_P", "D_Q") if method.pair else ("D",)
    keys(w, " ".join(("G", *names)))
    G, D = read.matrix(w["G"]), {name: read.vector(w[name]) for name in names}
    own_G, own_D = given_form(method)
    if own_G is not None:
        equal(G, own_G, "the G of the file")
    for name, own in own_D.items():
        equal(D[name], own, f"the {name} of the file")
    defects = form_defects(method, G, tuple(D.values()) if method.pair else D["D"])
    require(vanishes(defects), "an identity of the form does not hold")
    require(bool(energy(method, G)), "u^* G u is 0")


def given_form_fails(proof, w):
    """Rule given-form-fails: with the G and D of the file one identity does not hold.

    A D that is not given is B^* G u, the only one that the second identity times u allows.
    """
    method = proof.method
    G, own = given_form(method)
    require(G is not None, "the file gives no G")
    m, last = method.parts, list(method.parts)[-1]
    first = "D_P" if method.pair else "D"
    if first not in own:
        own[first] = apply(star(next(iter(m.values())).B), apply(G, method.u(last)))
    if method.pair and "D_Q" not in own:
        own["D_Q"] = apply(star(m["k"].B), apply(star(G), method.u("f")))
    D = (own["D_P"], own["D_Q"]) if method.pair else own["D"]
    fails = any(map(apart, entries(form_defects(method, G, D))))
    require(fails or vanishes(energy(method, G)), "the identities may hold")


def no_form(proof, w):
    """Rule no-form, for real methods: every form that satisfies the identities has u^* G u = 0."""
    method = proof.method
    require("G" not in method.document, "the file gives a form")
    if any(conj(x) != x for x in entries(M for m in method.parts.values() for M in m)):
        not_covered("no-form for complex methods")
    units = list(unit_forms(method))
    # a combination of the equations is u^* G u
    combination, _ = solve([entries(form_defects(method, *x)) for x in units],
                           [energy(method, G) for G, _ in units])  # fmt: skip
    require(combination is not None, "there is a form")


def unit_forms(method):
    """Yield (G, D) through a basis: each G with D = 0, then each D with G = 0."""
    m, *others = method.parts.values()
    rows, columns, zero = m.r, (others[0].r if others else m.r), Fraction(0)
    slopes = [len(x.B[0]) for x in method.parts.values()]
    none = tuple([zero] * n for n in slopes)
    for i, j in product(range(rows), range(columns)):
        if others or i <= j:
            G = [[zero] * columns for _ in range(rows)]
            G[i][j] = Fraction(1)
            if not others:
                G[j][i] = Fraction(1)
            yield G, none if others else none[0]
    G = [[zero] * columns for _ in range(rows)]
    shared = method.pair and not method.separable
    for at in range(slopes[0] if not others or shared else sum(slopes)):
        places = (at, at + slopes[0]) if shared else (at,)
        flat = [Fraction(int(k in places)) for k in range(sum(slopes))]
        yield G, (flat[: slopes[0]], flat[slopes[0] :]) if others else flat


def quadratic_defects(method):
    """Return the defects of the form G = 1, D = b of a method with one value (claim symplectic)."""
    for m in method.parts.values():
        require(m.r == 1 and m.V == [[1]] and m.U == [[1]] * len(m.U), "not one value carried")
    D = [m.B[0] for m in method.parts.values()]
    return entries(form_defects(method, [[Fraction(1)]], D if method.pair else D[0], transpose))


def quadratic(proof, w):
    """Rule quadratic."""
    require(vanishes(quadratic_defects(proof.method)), "an identity does not hold")


def not_quadratic(proof, w):
    """Rule not-quadratic."""
    several = any(m.r > 1 for m in proof.method.parts.values())
    require(several or "several-values" not in w, "one value is carried")
    require(several or any(map(apart, quadratic_defects(proof.method))), "the identities may hold")
