"""Rules for starts and finishes (section 4)."""

from fractions import Fraction

from .document import reading
from .linalg import apply, dot, equal, less, times, transpose
from .numbers import apart, is_nil, total, vanishes
from .refusals import keys, require, whole
from .rules_orders import known_order, named_tree
from .series import Series, path_orders
from .trees import LEAF, PATHS, cuts, show, size, through


def check_start_along_paths(method, start, p, nystrom):
    """Refuse unless the values of a start use stages that are the solution far enough (4)."""
    if "starting" not in method.document:
        return  # its values are 0 on a tree where eta is: there and on the path of the same order
    (A, B), (A_hat, B_hat) = ((start.part(c).A, start.part(c).B) for c in "fk")
    if nystrom:
        links = {"f": (times(A, A_hat), "f", 2)}
        used = [(B_hat, "f", p - 1), (times(B, A_hat), "f", p - 2)]
    else:
        links = {"f": (A, "k", 1), "k": (A_hat, "f", 1)}
        used = [(B, "k", p - 1), (B_hat, "f", p - 1)]
    orders = {c: path_orders(method, start, c, p) for c in links}
    before = None
    while before != orders:
        before = {c: list(x) for c, x in orders.items()}
        for c, (M, other, gain) in links.items():
            for i, row_ in enumerate(M):
                least = [orders[other][j] + gain for j, x in enumerate(row_) if not is_nil(x)]
                orders[c][i] = min([orders[c][i], *least])
    fine = all(is_nil(x) or orders[c][j] >= least
               for M, c, least in used for row_ in M for j, x in enumerate(row_))  # fmt: skip
    require(fine, "a value of the start uses a stage that is not the solution")


def start_of(method):
    """Return the series of the file's start; a pair without one has (y0, 0, ..)."""
    table = method.document.get("starting")
    if table is None:
        require(method.pair, "the file has no start")
        zero = [[Fraction(0)]]
        tables = {c: (zero, zero * m.r) for c, m in method.parts.items()}
        u = {c: [Fraction(int(k == 0)) for k in range(m.r)] for c, m in method.parts.items()}
        return Series.of_tables(tables, u)
    hats = {"o": ""} if not method.pair else {"f": "", "k": "_hat"}
    keys(table, " ".join(f"A{h} B{h} u{h}" for h in hats.values()), "name kind order", "start")
    tables = {c: (method.matrix("A" + h, table), method.matrix("B" + h, table))
              for c, h in hats.items()}  # fmt: skip
    u = {c: method.list("u" + h, table) for c, h in hats.items()}
    for c, (_, B) in tables.items():
        require(len(B) == len(u[c]) == method.part(c).r, "the start has another number of values")
    return Series.of_tables(tables, u)


def start_gap(proof, order, p, nystrom):
    """Return the function that gives start(t) - eta(t) through an order.

    Of one method eta is moved along the flow, so that it agrees with the start in what is read at
    the single vertex, and at order p it may be moved by eigenvectors N beta.
    """
    method, start = proof.method, start_of(proof.method)
    free = not method.pair
    require(not free or not method.system, "a start of a Rosenbrock method")
    series = proof.series(not free, nystrom, order, filled=True)
    if nystrom in PATHS:
        check_start_along_paths(method, start, p, nystrom == "nystrom-paths")

    def gap(tree):
        found = less(start.value(tree), series.eta_of(tree))
        if free:
            found = less(found, series.shift(tree, sigma))
        if free and size(tree) == p:
            W, N = series.W["o"], series.N["o"]
            return less(found, apply(transpose(N), apply(W, found)))
        return found

    sigma = Fraction(0)
    if free and order:
        single = less(start.value(LEAF), series.eta_of(LEAF))
        sigma = dot(reading(method, "o", series.u["o"]), single)
    return start, series, gap


def start_at_least(proof, w):
    """Rule start-at-least."""
    q = whole(w["q"])
    require(proof.low and proof.low == proof.high and q <= proof.low[0], "the order is open")
    p, _, nystrom = proof.low
    start, series, gap = start_gap(proof, q, p, nystrom)
    for c, u in series.u.items() if q else ():
        equal(start.u[c], u, "u of the start")
    for tree in through(proof.method, q, nystrom):
        require(vanishes(gap(tree)), f"the start at tree {show(tree)}")
    return q


def start_at_most(proof, w):
    """Rule start-at-most: a tree at which the start is wrong, or q is the order."""
    q, nystrom = whole(w["q"]), proof.low[2] if proof.low else proof.mode()[1]
    p = known_order(proof, q)
    if q == p:
        require(proof.high, "the order is not part of the certificate")
        return q
    require(proof.high or q == 0 or proof.method.pair, "the order is not known")
    start, series, gap = start_gap(proof, min(q + 1, p), p if proof.high else q + 2, nystrom)
    require(not series.loose, "other principal parts may be right")
    if w["tree"] == "":
        gaps = [x - y for c, u in series.u.items() for x, y in zip(start.u[c], u, strict=True)]
        require(q == 0, "u belongs to order 0")
    else:
        gaps = gap(named_tree(proof, w, q + 1, nystrom))
    require(any(map(apart, gaps)), "the start may be right at the tree")
    return q


def finish_defect(proof, tree):
    """Return (a b)(t), a the first value of the start and b the finish."""
    method = proof.method
    require(not method.pair, "pairs have no finish")
    require(not method.declared, "not covered: a finish of a method that declares an output")
    start, table = start_of(method), method.document.get("finishing")
    require(start.u["o"][0] == 1, "the first value of the start is not y0")
    keys(table, "A b", "name kind order", "finish")
    A, b = method.matrix("A", table), [method.list("b", table)]
    finish = Series.of_tables({"o": (A, b)})

    def first(t):
        return start.value(t)[0]

    return first(tree) + total(w * finish.value(s)[0] for s, w in cuts(tree, first).items())


def finish_at_least(proof, w):
    """Rule finish-at-least."""
    require(proof.low and whole(w["q"]) <= proof.low[0], "the finish is above the order")
    for tree in through(proof.method, w["q"], False):
        require(vanishes(finish_defect(proof, tree)), f"the finish is wrong at {show(tree)}")
    return w["q"]


def finish_at_most(proof, w):
    """Rule finish-at-most: a tree, or the order of the method."""
    q = whole(w["q"], 0, 14)
    if "tree" in w:
        gap = finish_defect(proof, named_tree(proof, w, q + 1, False))
        require(bool(gap), "the finish is right at the tree")
    else:
        require(proof.high and q == known_order(proof, q), "the finish has another order")
    return q
