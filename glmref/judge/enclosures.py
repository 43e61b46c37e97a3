"""What all documents with an enclosure have in common (section 6.1)."""

from .arithmetic import Fraction
from .document import Method
from .grammar import published_decimal
from .krawczyk import Linear, only_root
from .linalg import (
    apply,
    diagonal,
    dot,
    equal,
    identity,
    inverse_matrix,
    kernel,
    minus,
    rank,
    times,
    transpose,
)
from .numbers import as_real, conj, inverse, real, squared, total, vanishes
from .refusals import SIZE, as_object, keys, require, whole
from .trees import read_tree


def palindrome(row):
    """Return 1 or -1 where a row is its own mirror image up to this sign, else None."""
    for s in (1, -1):
        if all(x == y * s for x, y in zip(row, reversed(row), strict=True)):
            return s
    return None


def eigenvector(M, z):
    """Return the eigenvector of a simple eigenvalue."""
    basis = kernel(minus(M, diagonal([z] * len(M))))
    require(len(basis) == 1, "an eigenvalue of an equation is not simple")
    return basis[0]


def parasitic_form(v, other, seen):
    """Return H, Re(seen seen^*) / v^* other: a growth parameter is sum d_i x_i^T H x_i."""
    norm = dot([conj(x) for x in v], other)
    require(bool(norm) and conj(norm) == norm, "v^* G v is 0 or not real")
    unit = inverse(norm)
    return [[as_real(real(a * conj(b)) * unit) for b in seen] for a in seen]


def parameter(H, weights, rows):
    """Return the growth parameter of weights d_i and columns x_i of the rows."""
    return total(d * dot(x, apply(H, x)) for d, x in zip(weights, transpose(rows), strict=True))


def circle_is_named(V, named):
    """Return how many eigenvalues of modulus 1 but 1 are named, where these and 1 are all."""
    found = []
    for z in named:
        for x in (z, conj(z)):
            if bool(x - 1) and all(bool(x - y) for y in found):
                found.append(x)
    simple = all(squared(z) == 1 and rank(minus(V, diagonal([z] * len(V)))) == len(V) - 1
                 for z in found)  # fmt: skip
    return len(found) if simple and len(found) == len(V) - 1 else None


class Enclosed:
    """What sweeps and pairs have in common: the document, its unknowns, and the root.

    `halves` has by colour the weights and the rows that stand beside them.
    """

    halves, explicit_now = {}, frozenset()

    def __init__(self, document, numbers, proof):
        self.document, self.proof = document, proof
        keys(proof, "radius centre inverse", "free trees", "proof of the method")
        block = document.get("enclosure")
        keys(block, "equations", "radius xi", "enclosure")
        require("starting" not in block, "enclosure")
        self.unknowns = list(as_object(document.get("unknowns", {})))
        require(0 < len(self.unknowns) <= SIZE, "the unknowns")
        require(
            block.get("radius", "1e-60") == proof["radius"], "the radius is not that of the file"
        )
        self.digits = whole(document.get("digits", 75), 20, 400)
        symbols = {name: Linear({k: Fraction(1)}) for k, name in enumerate(self.unknowns)}
        self.numbers = numbers.changed(unknowns=symbols)
        self.exact = numbers
        self.texts = block["equations"]
        require(isinstance(self.texts, list) and len(self.texts) == len(self.unknowns), "equations")
        self.xi = {read_tree(t): self.numbers.entry(x, document)
                   for t, x in as_object(block.get("xi", {})).items()}  # fmt: skip
        self.prepare()
        published = [published_decimal(document["unknowns"][x], self.digits) for x in self.unknowns]
        self.root = only_root(self.residuals, published, self.digits, proof)

    def matrix(self, key):
        """Return a matrix of the document, in the unknowns; a form may be its diagonal."""
        read = self.numbers.form if key == "G" else self.numbers.matrix
        return read(self.document[key], self.document)

    def number(self, text):
        """Return an exact number in the text of an equation."""
        return self.exact.entry(text, {})

    def at(self, values):
        """Return the method at values of the unknowns."""
        values = dict(zip(self.unknowns, values, strict=True))
        return Method(
            self.document, self.exact.changed(unknowns=values, explicit=self.explicit_now)
        )

    def suppose(self, names):
        """Read G and the V of these names, by colour; check what the theorems suppose of them."""
        self.V = {c: self.matrix(name) for c, name in names.items()}
        self.G = self.matrix("G")
        for M in (self.G, *self.V.values()):
            fixed = not any(isinstance(x, Linear) for row in M for x in row)
            require(fixed and all(conj(x) == x for row in M for x in row), "V or G is not real")
        self.first, self.last = self.V[min(names)], self.V[max(names)]
        equal(times(transpose(self.first), self.G, self.last), self.G, "V^T G V = G")
        for M in (self.G, *self.V.values()):
            border = [M[0][0] - 1, *M[0][1:], *(row[0] for row in M[1:])]
            require(vanishes(border), "the first row and column of V or G are not 1, 0, .., 0")
        for V in self.V.values():
            regular = rank(minus(V, identity(len(V)))) == len(V) - 1
            require(regular, "I - V is not regular on the values 2 to r")

    def find_signs(self):
        """Return the diagonals of E by colour, after the checks of theorem 3, or None."""
        found = {c: [palindrome(row) for row in X] for c, (_, X) in self.halves.items()}
        mirrored = all(palindrome(weights) == 1 for weights, _ in self.halves.values())
        if not mirrored or any(None in x for x in found.values()):
            return None
        E = {c: diagonal([Fraction(x) for x in signs]) for c, signs in found.items()}
        pairs = [(times(E[min(E)], self.G, E[max(E)]), self.G)]
        pairs += [(times(E[c], inverse_matrix(V), E[c]), V) for c, V in self.V.items()]
        return found if all(vanishes(minus(M, N)) for M, N in pairs) else None

    def reversal(self):
        """Return L = V^-1 E of each component."""
        require(self.signs is not None, "the method is not symmetric")
        return {c: times(inverse_matrix(V), diagonal([Fraction(x) for x in self.signs[c]]))
                for c, V in self.V.items()}  # fmt: skip

    def growth_form(self, text, colour):
        """Return (colour, z, H): the growth parameter of z is sum d_i x_i^T H x_i."""
        z = self.number(text)
        v, w = eigenvector(self.first, z), eigenvector(self.last, z)
        seen = apply(self.G, w) if colour == min(self.V) else apply(transpose(self.G), v)
        return colour, z, parasitic_form(v, apply(self.G, w), seen)

    def zero_growths(self):
        """Return how many growth parameters there are, all 0, or None."""
        named = [e[2] for e in self.equations if e[0] == "growth"]
        counts = {circle_is_named(V, [z for half, z, _ in named if half == c])
                  for c, V in self.V.items()}  # fmt: skip
        return counts.pop() * len(self.V) if len(counts) == 1 and None not in counts else None
