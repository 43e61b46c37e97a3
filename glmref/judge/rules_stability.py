"""Rules for linear stability (section 5)."""

from itertools import product

from .arithmetic import Fraction
from .grammar import rational
from .linalg import (
    characteristic,
    combine,
    identity,
    inverse_matrix,
    minus,
    multiples,
    scale,
    times,
    transpose,
)
from .numbers import conj, vanishes
from .polynomials import (
    OnAxis,
    divide,
    gcd,
    horner,
    in_disc,
    interpolate,
    is_schur,
    is_unbounded,
    margins,
    multiply,
    no_root_but_zero,
    nowhere_negative,
    plus,
    trim,
)
from .refusals import not_covered, require
from .rule import Bounded


def stability(m):
    """Return det(I - z A), nodes z where it is not 0, and its values and M(z) there."""
    below, nodes, found, z = characteristic(m.A)[::-1], [], [], Fraction(0)
    while len(nodes) <= len(m.A):
        value = horner(below, z)
        if bool(value):
            back = inverse_matrix(minus(identity(len(m.A)), scale(z, m.A)))
            nodes.append(z)
            found.append((value, combine(m.V, scale(z, times(m.B, back, m.U)))))
        z += 1
    return below, nodes, found


def stability_polynomial(m):
    """Return P(w, z) = det(w I - M(z)) det(I - z A): for each power of w a polynomial in z."""
    _, nodes, found = stability(m)
    columns = transpose([multiples(value, characteristic(M)) for value, M in found])
    return [interpolate(nodes, column) for column in columns]


def poles(m):
    """Return det(I - z A) without what it shares with all entries of M(z) det(I - z A)."""
    below, nodes, found = stability(m)
    common = below = trim(below)
    for i, j in product(range(m.r), range(m.r)):
        entry = interpolate(nodes, [value * M[i][j] for value, M in found])
        common = gcd(common, entry) if entry else common
    return divide(below, common)[0]


def poles_lie_right(m):
    """Rule a-stable (2): all poles have Re z > 0."""
    d = poles(m)
    n, q = len(d) - 1, []
    for k, c in enumerate(d):  # z = (x + 1) / (x - 1): Re z > 0 is |x| > 1
        term = [c]
        for factor in [[Fraction(1), Fraction(1)]] * k + [[Fraction(-1), Fraction(1)]] * (n - k):
            term = multiply(term, factor)
        q = plus(q, term)
    backwards = (q + [Fraction(0)] * (n + 1 - len(q)))[::-1]
    return bool(backwards[-1]) and is_schur(backwards)  # a pole at z = -1 makes the last one 0


def at_infinity(P):
    """Return the coefficient of the highest power of z in P, a polynomial in w."""
    high = max(len(p) for p in P) - 1
    return trim([p[high] if len(p) > high else Fraction(0) for p in P])


def on_imaginary_axis(P):
    """Return the differences of Schur and Cohn of P(w, i y) as polynomials in y.

    None stands for a step of Cohn that fails; a difference that is 0 for all y is [].
    """
    real_ = all(conj(c) == c for p in P for c in p)
    require(real_, "not covered: linear stability of complex methods")
    found = list(margins(map(OnAxis, P)))
    # a difference is its own conjugate: even in i y
    return [None if x is None else [c * (-1) ** (k // 2) for k, c in enumerate(x.p)] for x in found]


def discriminant(P):
    """Return the resultant of P(w, z) and its derivative by w, a polynomial in z."""
    n = len(P) - 1
    degree = (2 * n - 1) * max(len(p) - 1 for p in P)
    nodes = [Fraction(k) for k in range(degree + 1)]
    values = []
    for z in nodes:
        p = [horner(c, z) if c else Fraction(0) for c in P]
        q = [k * c for k, c in enumerate(p)][1:]
        none = [Fraction(0)]
        rows = [none * k + p[::-1] + none * (n - 2 - k) for k in range(n - 1)]
        rows += [none * k + q[::-1] + none * (n - 1 - k) for k in range(n)]
        values.append(characteristic(rows)[0] * (-1) ** len(rows))  # the determinant
    return trim(interpolate(nodes, values))


def never_meet(P):
    """Tell whether the eigenvalues other than fixed zeros are different at all y but 0 (5).

    The real and the imaginary part of the discriminant at i y have no common root but 0.
    """
    while P and not trim(P[0]):
        P = P[1:]
    if len(P) < 3:
        return True
    found = discriminant(P)
    if not found:
        return False
    even = trim([c * (-1) ** (k // 2) if k % 2 == 0 else Fraction(0) for k, c in enumerate(found)])
    odd = trim([c * (-1) ** (k // 2) if k % 2 else Fraction(0) for k, c in enumerate(found)])
    return no_root_but_zero(gcd(even, odd) if even and odd else even or odd)


def a_stable(proof, w):
    """Rule a-stable; `bounded` for V is another part."""
    m = proof.method.single()
    require(proof.all_shown(Bounded), "bounded is not part of the certificate")
    P = stability_polynomial(m)
    require(poles_lie_right(m), "(2): a pole does not lie in Re z > 0")
    last = at_infinity(P)
    require(len(last) == m.r + 1 and in_disc(last), "(3): an eigenvalue at infinity")
    found = on_imaginary_axis(P)
    require(None not in found, "(4): a step of Cohn fails")
    fine = all(not x or nowhere_negative(x) for x in found)
    require(fine, "(4): a difference is negative somewhere")
    # where a difference is 0 eigenvalues of modulus 1 may meet; [] is 0 everywhere
    apart_ = m.r == 1 or all(x and no_root_but_zero(x) for x in found) or never_meet(P)
    if not apart_:
        not_covered("(5): eigenvalues that meet on the imaginary axis")


def at_imaginary(m, y):
    """Return M(i y) of a real method as a real matrix of twice the size, i as [[0, -1], [1, 0]]."""

    def twice(M, real_part):
        require(all(conj(x) == x for row in M for x in row), "not covered: a complex method")
        zero = [[Fraction(0)] * len(M[0]) for _ in M]
        first, second = (M, zero) if real_part else (zero, scale(y, M))
        above = [[*a, *(-x for x in b)] for a, b in zip(first, second, strict=True)]
        return above + [[*b, *a] for a, b in zip(first, second, strict=True)]

    A, B = twice(m.A, False), twice(m.B, False)
    back = inverse_matrix(minus(identity(len(A)), A))
    return combine(twice(m.V, True), times(B, back, twice(m.U, True)))


def not_a_stable(proof, w):
    """Rule not-a-stable."""
    require(isinstance(w, dict) and len(w) == 1, "one reason is given")
    ((reason, value),) = w.items()
    m = proof.method.single()
    if reason == "y":
        require(is_unbounded(at_imaginary(m, rational(value))), "M(i y) is power-bounded")
        return
    require(reason in ("infinity", "pole", "axis", "start") and value is True, "no such reason")
    if reason == "infinity":
        last = at_infinity(stability_polynomial(m))
        require(len(last) < m.r + 1 or not in_disc(last), "(3) holds")
    elif reason == "pole":
        require(not poles_lie_right(m), "(2) holds")
    elif reason == "axis":
        found = on_imaginary_axis(stability_polynomial(m))
        out = any(x is None or (x and not nowhere_negative(x)) for x in found)
        require(out, "no difference is negative")
    else:
        require("unbounded" in proof.rules, "unbounded is not part of the certificate")


def l_limit(proof, w, wanted=True):
    """Rules l-limit and not-l-limit."""
    m = proof.method.single()
    last = at_infinity(stability_polynomial(m))
    zero = len(last) == m.r + 1 and vanishes(last[:-1])
    if not wanted and len(last) == m.r + 1:
        zero = not any(map(bool, last[:-1]))
    require(zero == wanted, "the limit is (not) a multiple of w^r")
