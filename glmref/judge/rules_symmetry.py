"""Rules for symmetry (section 5)."""

from itertools import product

from .arithmetic import Fraction
from .linalg import combine, equal, identity, inverse_matrix, minus, rank, solve, times
from .numbers import may_vanish, vanishes
from .refusals import keys, require


def permutation(p, n):
    """Return a 0-based involution of n places."""
    fine = isinstance(p, list) and all(type(x) is int for x in p) and sorted(p) == list(range(n))
    require(fine and all(p[x] == k for k, x in enumerate(p)), "P is no involution")
    return p


def symmetric(proof, w):
    """Rule symmetric: L and P exchange a step with its reversal."""
    method, read = proof.method, proof.method.numbers
    if method.pair:
        keys(w, "L L_hat P_Q P_P")
        L = {"f": read.matrix(w["L"]), "k": read.matrix(w["L_hat"])}
        slopes, places = {"f": w["P_P"], "k": w["P_Q"]}, {"f": w["P_Q"], "k": w["P_P"]}
        require(method.separable or w["P_Q"] == w["P_P"], "P_Q and P_P differ")
    else:
        keys(w, "L P")
        L, slopes, places = {"o": read.matrix(w["L"])}, {"o": w["P"]}, {"o": w["P"]}
    for c, m in method.parts.items():
        J, back = L[c], inverse_matrix(m.V)
        P, R = permutation(slopes[c], len(m.B[0])), permutation(places[c], len(m.A))
        equal(times(J, J), identity(m.r), "L^2 = I")
        equal(times(J, back, J), m.V, "L V^-1 L = V")
        equal([[row[x] for x in P] for row in times(m.V, J, m.B)], m.B, "B = V L B P")
        mirrored = times(m.U, J, m.V)
        equal([mirrored[x] for x in R], m.U, "U = P U L V")
        moved = [[m.A[x][y] for y in P] for x in R]
        equal(combine(m.A, moved), times(m.U, back, m.B), "A + P A P = U V^-1 B")
    proof.reversal = L


def involutions(method):
    """Return all P with A + P A P = U V^-1 B, by backtracking; separable pairs: Q, then P."""
    blocks, kinds = [], None
    for m in method.parts.values():
        blocks.append((m.A, times(m.U, inverse_matrix(m.V), m.B)))
    n = len(blocks[0][0])
    if method.separable:
        (A, M), (A_hat, M_hat) = blocks
        n_P = len(A_hat)
        kinds = [0] * n + [1] * n_P
        blocks = [(corners(A, A_hat), corners(M, M_hat))]
        n += n_P
    found, steps = [], 0

    def place(P):
        nonlocal steps
        steps += 1
        require(steps <= 100_000, "beyond the limits of this checker")
        k = next((i for i, x in enumerate(P) if x is None), None)
        if k is None:
            found.append(list(P))
            return
        for x in range(k, n):
            if P[x] is None and (kinds is None or kinds[x] == kinds[k]):
                P[k], P[x] = x, k
                if fits_all(P, k):
                    place(P)
                P[k] = P[x] = None

    def fits_all(P, k):
        known = [i for i, x in enumerate(P) if x is not None]
        pairs = [(i, j) for e in (k, P[k]) for o in known for i, j in ((e, o), (o, e))]
        return all(
            may_vanish(A[i][j] + A[P[i]][P[j]] - M[i][j]) for A, M in blocks for i, j in pairs
        )

    place([None] * n)
    return found


def corners(M, N):
    """Return the matrix with M right above and N left below."""
    zero = Fraction(0)
    return [[zero] * len(M) + row for row in M] + [row + [zero] * len(M[0]) for row in N]


def not_symmetric(proof, w):
    """Rule not-symmetric: a V is singular, or no P that the stages allow has an L."""
    method = proof.method
    if "singular" in w:
        V = method.part(w["singular"]).V
        require(rank(V) < len(V), "V is regular")
        return
    for P in involutions(method):
        require(any(no_reversal(method, c, P) for c in method.parts), "an involution L exists")


def no_reversal(method, c, P):
    """Tell whether the linear conditions on L contradict or have one solution, no involution."""
    m, back = method.part(c), inverse_matrix(method.part(c).V)
    n_Q = len(method.parts["f"].A) if method.separable else 0
    Q_of, P_of = (P[:n_Q], [x - n_Q for x in P[n_Q:]]) if method.separable else (P, P)
    stages, slopes = (P_of, Q_of) if c == "k" else (Q_of, P_of)
    left, right, r = times(m.U, back), times(back, m.B), m.r
    rows, values = [], []

    def condition(coefficients, value):
        row = [Fraction(0)] * (r * r)
        for (i, j), x in coefficients:
            row[i * r + j] = row[i * r + j] + x
        rows.append(row)
        values.append(value)

    for s, j in product(range(len(m.U)), range(r)):  # U V^-1 = P U L
        condition([((k, j), m.U[stages[s]][k]) for k in range(r)], left[s][j])
    for i, s in product(range(r), range(len(m.B[0]))):  # V^-1 B = L B P
        condition([((i, k), m.B[k][slopes[s]]) for k in range(r)], right[i][s])
    for i, j in product(range(r), range(r)):  # V L = L V^-1
        condition([((k, j), m.V[i][k]) for k in range(r)]
                  + [((i, k), -back[k][j]) for k in range(r)], Fraction(0))  # fmt: skip
    x, unique = solve(rows, values)
    if x is None:
        return True
    L = [x[i * r : i * r + r] for i in range(r)]
    return unique and not vanishes(minus(times(L, L), identity(r)))
