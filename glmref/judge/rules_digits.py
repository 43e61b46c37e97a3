"""Rules for orders that hold to the printed digits (section 5)."""

from operator import itemgetter, mul

from .arithmetic import RATIONAL, Fraction
from .grammar import two_digits
from .linalg import dot
from .numbers import floor
from .refusals import NotShown, as_object, keys, require, whole
from .series import Series
from .trees import gamma, is_coloured, is_nystrom, read_tree, show, size, stands, trees


class Sizes:
    """Conditions of a method that carries one value, in integers over 2^bits with their errors."""

    def __init__(self, method, bits):
        self.method, self.bits, self.known = method, bits, {}
        for m in method.parts.values():
            fine = all(x == 1 for row in (*m.U, *m.V) for x in row) and m.r == 1
            require(fine, "the value carried is not the solution")
        self.A = {c: [self.whole(row) for row in m.A] for c, m in method.parts.items()}
        self.sparse = {c: [([x for x in row if x], [j for j, x in enumerate(row) if x])
                           for row in rows] for c, rows in self.A.items()}  # fmt: skip
        self.width = {c: len(rows[0]) for c, rows in self.A.items()}
        self.norm = {c: max(sum(map(abs, x)) + len(x) for x in A) for c, A in self.A.items()}

    def whole(self, row):
        """Return the integers below 2^bits times rational numbers."""
        require(all(type(x) in RATIONAL for x in row), "the entries are not rational")
        return [floor(Fraction(x) * 2**self.bits) for x in row]

    def phi(self, tree, keep=True):
        """Return (values, error) of the product over the children of A Phi(child)."""
        if tree not in self.known:
            found = [1 << self.bits] * self.width[tree[0]], 0
            for n, child in enumerate(tree[1]):
                found = self.product(found, self.below(child)) if n else self.below(child)
            if not keep:
                return found
            self.known[tree] = found
        return self.known[tree]

    def product(self, left, right):
        """Return the product place by place: |dx y + x dy + dx dy|, and 1 for the shift."""
        (x, dx), (y, dy) = left, right
        top = max(map(abs, x)) * dy + max(map(abs, y)) * dx + dx * dy
        return [a * b >> self.bits for a, b in zip(x, y, strict=True)], (top >> self.bits) + 2

    def below(self, tree):
        """Return A Phi(tree), A that of the colour of the root."""
        key = (tree, "below")
        if key not in self.known:
            x, dx = self.phi(tree)
            error = self.norm[tree[0]] * dx + sum(map(abs, x)) + len(x) * dx
            rows = [sum(map(mul, row, itemgetter(*places)(x))) if len(places) > 1
                    else sum(a * x[j] for a, j in zip(row, places, strict=True))
                    for row, places in self.sparse[tree[0]]]  # fmt: skip
            self.known[key] = [y >> self.bits for y in rows], (error >> self.bits) + 2
        return self.known[key]

    def residual(self, tree, b, keep=True):
        """Return bounds of |b Phi(tree) - 1 / gamma(tree)| for integers b."""
        x, dx = self.phi(tree, keep)
        error = sum(map(abs, b)) * dx + sum(map(abs, x)) + len(x) * dx
        gap = sum(map(mul, b, x)) >> self.bits
        gap = abs(gap - (1 << self.bits) // gamma(tree))
        error = (error >> self.bits) + 3
        unit = Fraction(1, 1 << self.bits)
        return (gap - error) * unit, (gap + error) * unit

    def exactly(self, tree, b):
        """Return |b Phi(tree) - 1 / gamma(tree)| itself."""
        parts = {c: (m.A, m.B) for c, m in self.method.parts.items()}
        slopes = Series.of_tables(parts).derivative(tree)
        return abs(dot(b, slopes) - Fraction(1, gamma(tree)))


class ToDigits:
    """The residuals of the rows of weights, and what is declared of them."""

    def __init__(self, proof):
        method, declared = proof.method, as_object(proof.declared)
        rows, self.nystrom = method.rows(), method.kind == "nystrom"
        require("b" not in rows, "a row has the name of the solution")
        require(set(declared) == {"b", *rows}, "other weights are declared")
        self.declared, exponent = {}, 0
        for name, value in declared.items():
            require(isinstance(value, list) and len(value) == 2, "an order and a size are declared")
            self.declared[name] = whole(value[0], 1, 14), *two_digits(value[1])
            exponent = max(exponent, int(value[1].partition("e-")[2]))
        self.base = method.for_claim("order")
        self.sizes, self.b, self.scaled = Sizes(self.base, 256 + 4 * exponent), {}, {}
        for name in declared:
            one = self.base if name == "b" else method.with_row(rows[name][0]).for_claim("order")
            carried = all(x == 1 for m in one.parts.values() for row in m.V for x in row)
            require(carried, "the row does not carry the solution")
            self.b[name] = {c: m.B[0] for c, m in one.parts.items()}
            self.scaled[name] = {c: self.sizes.whole(b) for c, b in self.b[name].items()}

    def counted(self, tree):
        """Tell whether the claim is about the condition of a tree."""
        return stands(tree, self.base.system) and (is_nystrom(tree) or not self.nystrom)

    def trees(self, order):
        """Return the trees of an order whose conditions are meant."""
        return filter(self.counted, trees(self.base.palette, order))

    def read(self, text, low, high):
        """Return a tree of a witness, whose order is one of these."""
        tree = read_tree(text)
        require(low <= size(tree) <= high and is_coloured(tree, self.base.palette), "the tree")
        require(self.counted(tree), "the condition of the tree is not meant")
        return tree

    def residual(self, name, tree, *limits, keep=True):
        """Return bounds of a residual, itself where a limit is between them."""
        low, high = self.sizes.residual(tree, self.scaled[name][tree[0]], keep)
        if any(low <= x < high for x in limits):
            low = high = self.sizes.exactly(tree, self.b[name][tree[0]])
        return low, high


def to_digits(proof, w):
    """Rule to-digits: every residual through an order, the largest one, and one of the next."""
    known, shown = ToDigits(proof), as_object(w["rows"])
    require(set(shown) == set(known.declared), "other weights are shown")
    for name, (order, most, least) in known.declared.items():
        keys(shown[name], "largest beyond")
        largest, seen = known.read(shown[name]["largest"], 1, order), False
        for n in range(1, order + 1):
            for tree in known.trees(n):
                low, high = known.residual(name, tree, most, least, keep=n < order)
                if high > most:
                    raise NotShown(f"the residual of tree {show(tree)}")
                seen = seen or (tree == largest and low > least)
        require(seen, "no residual is as large")
        tree = known.read(shown[name]["beyond"], order + 1, order + 1)
        low, _ = known.residual(name, tree, 1000 * most, keep=False)
        require(low > 1000 * most, "the residual of the tree beyond")


def not_to_digits(proof, w):
    """Rule not-to-digits: one residual is too large, or all are too small, or all of the next."""
    require(("tree" in w) is not ("order" in w), "a tree or an order")
    known, name = ToDigits(proof), w["row"]
    require(name in known.declared, "no row of this name")
    order, most, least = known.declared[name]
    if "tree" in w:
        low, _ = known.residual(name, known.read(w["tree"], 1, order), most)
        require(low > most, "the residual of the tree")
        return
    beyond = whole(w["order"], order, order + 1) > order
    limit = 1000 * most if beyond else least
    for n in range(order + 1 if beyond else 1, w["order"] + 1):
        for tree in known.trees(n):
            _, high = known.residual(name, tree, limit, keep=n < w["order"])
            if high > limit:
                raise NotShown(f"the residual of tree {show(tree)}")
