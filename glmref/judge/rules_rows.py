"""Rules for embedded rows, row sums and dense output (section 5)."""

from .arithmetic import Fraction, Interval
from .claims import ABSENT
from .document import CLASSES, gaps_of_rows
from .linalg import apply, dot, identity, kernel, less, minus, ones, transpose
from .numbers import apart, inverse, total, vanishes
from .refusals import as_object, require, whole
from .rule import Bound
from .series import Series
from .trees import gamma, read_tree, show, size, trees


def row(proof, w):
    """Rule row: the order of the method with the weights of an embedded row; return (name, p)."""
    rows, whole_method = proof.method.rows(), proof.method
    require(w["row"] in rows, "no row of embedded has the name")
    require(isinstance(w["parts"], list), "the parts of a row are a list")
    names = [part["rule"] for part in w["parts"]]
    low, high = ["order-at-least"], ["order-at-most"]
    own = ([["implied-order", *high]] if proof.record.root is not None
           else [low + high, ["no-order-1"]])  # fmt: skip
    own += [high] if proof.holds else [high, low, ["implied-order"]]
    require(names in own, "the parts of a row")
    nystrom = whole_method.kind == "nystrom"
    inner = proof.of_row(w["row"], whole_method.with_row(rows[w["row"]][0]).for_claim("order"))
    for part in w["parts"]:
        inner.apply(part)
    if names == ["no-order-1"]:
        return w["row"], range(1)
    kinds = (True, "nystrom-paths") if nystrom else (False,)
    bound = inner.known["order"]
    require(bound.identity and bound.trees in kinds, "an order of another kind")
    most = 20 if bound.high is None else bound.high  # the largest order that a claim may name
    return w["row"], range(bound.low or 0, most + 1)


def check_rows(proof, found):
    """Refuse orders of rows that do not decide what is declared: of all rows, or of one."""
    orders, declared = dict(found), as_object(proof.declared)
    require(len(orders) == len(found) and set(declared) == set(proof.method.rows()), "rows")
    for p in declared.values():
        whole(p)
    if proof.holds:
        require(set(orders) == set(declared), "a row is missing")
        fits = all(x == range(declared[name], declared[name] + 1) for name, x in found)
        require(fits, "the order of a row is not shown to be this")
    else:
        require(any(declared[name] not in x for name, x in found), "the rows may have the orders")


def differences_of(method):
    """Return the sum of the weights of each estimate; of a Nystrom method those of q' left out.

    Of class glm return what each estimate is for y' = 0 and y' = 1, for all values that are exact.
    """
    require(method.rows(), "no rows are embedded")
    if method.kind == "glm":
        return [
            x for weights, _ in method.rows().values() for x in estimates(method, *weights["o"])
        ]
    return [total(w[1:] if method.kind == "nystrom" and c == "f" else w)
            for _, estimate in method.rows().values() for c, w in estimate.items()]  # fmt: skip


def estimates(method, b, v):
    """Return d u and x e 1 + d v of the row (b, v) for a basis of all (u, v, x).

    e = w B - b, d = w V - v; V u = u, U u = x 1, w u = x, x B 1 + V v = u + v. Return a 1 where no
    x is 1.
    """
    m, w = method.single(), method.declared.get("o")
    shift, nil = minus(m.V, identity(m.r)), [Fraction(0)] * m.r
    require(not any(type(x) is Interval for M in (m.U, m.B, m.V) for row in M for x in row),
            "values in decimals")  # fmt: skip
    outside = [[*row, Fraction(-1)] for row in [*m.U, *([w] if w else [])]]
    constants = kernel([[*row, Fraction(0)] for row in shift] + outside)
    slopes = zip(shift, identity(m.r), apply(m.B, ones(len(m.B[0]))), strict=True)
    both = kernel([[*row, *nil, Fraction(0)] for row in shift]
                  + [[*row[:-1], *nil, row[-1]] for row in outside]
                  + [[*(-x for x in unit), *row, x] for row, unit, x in slopes])  # fmt: skip
    if not any(x[-1] for x in both):
        return [Fraction(1)]
    if w is None:
        k = next(k for k in range(m.r) if any(x[k] for x in constants))
        u = next([y * inverse(x[-1]) for y in x] for x in constants if x[-1])
        require(vanishes([x[k] - u[k] * x[-1] for x in constants]), "the output is not fixed")
        w = [inverse(u[k]) if j == k else Fraction(0) for j in range(m.r)]
    require(len(b) == len(m.A) and len(v) == m.r, "embedded has another length")
    e, d = less(apply(transpose(m.B), w), b), less(apply(transpose(m.V), w), v)
    return [y for x in both
            for y in (dot(d, x[: m.r]), total(e) * x[-1] + dot(d, x[m.r : -1]))]  # fmt: skip


def gaps_of_end(method):
    """Return b(1) - b."""
    ends = [total(x) for x in method.matrix("dense")]
    return less(ends, method.single().B[0])


def all_zero_or_not(gaps, wanted):
    """Return the rule that the numbers are all zero, or that one is not."""

    def rule(proof, w):
        values = gaps(proof.method)
        if wanted:
            require(vanishes(values), "a number is not 0")
        else:
            require(any(apart(x) for x in values), "the numbers are 0")

    return rule


def absent(proof, w):
    """Rule absent: the file has nothing that the claim is about, which settles the claim."""
    require(proof.claim in ABSENT, "the claim is about the method itself")
    key, value = ABSENT[proof.claim]
    document, needed_or_optional = proof.method.document, " ".join(CLASSES[proof.method.kind])
    has_meaning = key in needed_or_optional.split()
    require(has_meaning, f"{proof.claim} has no meaning for the class of the file")
    if proof.claim == "embedded-order":
        rows = set(proof.method.rows()) if key in document else set()
        other = not rows or rows != set(as_object(proof.declared))
        require(other and not proof.holds, "the rows are these")
        return
    require(key not in document, f"the file has {key}")
    require(key != "starting" or not proof.method.pair, "a pair without a start has (y0, 0, ..)")
    same = type(proof.declared) is type(value) and proof.declared == value
    require(same == proof.holds, "the value is another")


def dense(proof, w, reached=True):
    """Rules dense and not-dense: the order of b(theta), power by power of theta, or a bound."""
    p, method = whole(w["order"]), proof.method
    own = reached and "c" in method.document and not vanishes(gaps_of_rows(method))
    require(not own and not method.pair, "c is not A 1")
    m, columns = method.single(), transpose(method.matrix("dense"))
    require(len(columns[0]) == len(m.A), "dense has another length")

    series = Series.of_tables({"o": (m.A, m.B)})

    def gaps(tree):
        n = size(tree)
        found = apply(columns, series.derivative(tree))
        found += [Fraction(0)] * (n - len(found))
        found[n - 1] = found[n - 1] - Fraction(1, gamma(tree))
        return found

    for tree in (t for n in range(1, p + 1 if reached else 1) for t in trees(method.palette, n)):
        require(vanishes(gaps(tree)), f"the condition of tree {show(tree)}")
    tree = read_tree(w["tree"])
    require(size(tree) == p + 1 and tree in trees(method.palette, p + 1), "the tree")
    require(any(apart(x) for x in gaps(tree)), "the next order is reached")
    return Bound("dense-order", p if reached else None, p, True)
