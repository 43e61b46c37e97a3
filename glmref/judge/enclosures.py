"""What all documents with an enclosure have in common (section 6.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from functools import cached_property

from .arithmetic import Fraction, Number
from .document import Method
from .fields import Numbers
from .grammar import decimal_number, published_decimal
from .krawczyk import Linear, box_around, only_root
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
from .refusals import SIZE, Document, as_list, as_object, keys, require, shown, whole
from .trees import read_tree


def palindrome(row: list) -> int:
    """Return 1 or -1 where a row is its own mirror image up to this sign, else 0."""
    for s in (1, -1):
        if all(x == y * s for x, y in zip(row, reversed(row), strict=True)):
            return s
    return 0


def eigenvector(M: list, z: Number) -> list:
    """Return the eigenvector of a simple eigenvalue."""
    basis = kernel(minus(M, diagonal([z] * len(M))))
    require(len(basis) == 1, "an eigenvalue of an equation is not simple")
    return basis[0]


def parasitic_form(v: list, other: list, seen: list) -> list:
    """Return H, Re(seen seen^*) / v^* other: a growth parameter is sum d_i x_i^T H x_i."""
    norm = dot([conj(x) for x in v], other)
    require(bool(norm) and conj(norm) == norm, "v^* G v is 0 or not real")
    unit = inverse(norm)
    return [[as_real(real(a * conj(b)) * unit) for b in seen] for a in seen]


def parameter(H: list, weights: list, rows: list) -> Number:
    """Return the growth parameter of weights d_i and columns x_i of the rows."""
    return total(d * dot(x, apply(H, x)) for d, x in zip(weights, transpose(rows), strict=True))


def circle_is_named(V: list, named: list) -> int | None:
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

    The `root` is known after :meth:`enclosed`; before it only the equations are read, which is what
    a finder of centre and inverse evaluates.

    Each class has its `equations`, read from their texts, and `signs`, the diagonals of E by colour
    where the method is symmetric; `halves` has by colour the weights and the rows beside them.
    """

    halves: Mapping[str, tuple[list, list]] = {}
    explicit_now: frozenset[int] = frozenset()
    equations: list[tuple]
    root: list
    signs: dict[str, list[int]] | None = None
    members = "", ""  # of the proof and of the block, besides those of every class
    prepare: Callable[[], None]  # reads matrices and equations, checks what the theorems suppose
    residuals: Callable[
        [list], list
    ]  # left minus right of every equation at values of the unknowns
    gives_order: Callable[[int, bool | str, str | None, Method], bool]  # all conditions through it
    implies: Callable[[str], bool]  # whether a claim that is true or false holds at the root

    def __init__(self, document: Document, numbers: Numbers, proof: object) -> None:
        values = self.members[1]
        self.document, self.proof = document, as_object(proof)
        block, unknowns = as_object(document.get("enclosure")), document.get("unknowns", {})
        keys(block, "equations", "radius " + values, "enclosure")
        unknowns = as_object(unknowns)
        self.unknowns = list(unknowns)
        require(0 < len(self.unknowns) <= SIZE, "the unknowns")
        radius = block.get("radius", "1e-60")
        require(radius == self.proof.get("radius"), "the radius is not that of the file")
        self.digits = whole(document.get("digits", 75), 20, 400)
        symbols = {name: Linear({k: Fraction(1)}) for k, name in enumerate(self.unknowns)}
        self.numbers = numbers.changed(unknowns=symbols)
        self.exact = numbers
        self.texts = as_list(block["equations"], "equations")
        self.xi = {read_tree(t): self.numbers.entry(x, document)
                   for t, x in as_object(block.get("xi", {})).items()}  # fmt: skip
        self.prepare()

    @cached_property
    def published(self) -> list[Fraction]:
        """Return the published numbers, which a file that is sought has not yet."""
        unknowns = as_object(self.document["unknowns"])
        return [published_decimal(x, self.digits) for x in unknowns.values()]

    @cached_property
    def over_box(self) -> list:
        """Return the residuals over the box of the proof, with their derivatives."""
        radius = decimal_number(self.proof["radius"])
        return self.residuals(box_around(self.published, radius))

    def enclosed(self, proof: Document) -> Enclosed:
        """Return the same equations with their root, or refuse its proof."""
        keys(proof, "radius centre inverse", self.members[0], "proof of the method")
        require(len(self.texts) == len(self.unknowns), "equations")
        other = copy(self)
        other.root = only_root(
            self.residuals, self.published, self.digits, proof, lambda: self.over_box
        )
        return other

    def is_of_the_theorem(self, identity: bool, nystrom: bool | str, row: str | None) -> bool:
        """Tell whether the theorem about orders is about a principal part, trees and a row."""
        return True

    def principal_is_zero(self, p: int, identity: bool, nystrom: bool | str) -> bool:
        """Tell whether principal parts below p are 0, where they must be."""
        return True

    def gives_stage_order(self, q: int) -> bool:
        """Tell whether the equations give the stage order q: of pairs they do not."""
        return False

    def zero_start_holds(self, q: int, nystrom: bool | str) -> bool:
        """Tell whether every value but the first is 0 on all trees through order q, of pairs."""
        return False

    def matrix(self, key: str) -> list:
        """Return a matrix of the document, in the unknowns; a form may be its diagonal."""
        read = self.numbers.form if key == "G" else self.numbers.matrix
        return read(self.document[key], self.document)

    def number(self, text: object) -> Number:
        """Return an exact number in the text of an equation."""
        return self.exact.entry(text, {})

    def at(self, values: list) -> Method:
        """Return the method at values of the unknowns."""
        named = dict(zip(self.unknowns, values, strict=True))
        known = {id(self.document): (self.document, {**self.fixed})}
        numbers = self.exact.changed(unknowns=named, explicit=self.explicit_now, entries=known)
        return Method(self.document, numbers)

    @cached_property
    def fixed(self) -> dict[object, Number]:
        """Return the entries of the document that are the same for all values of the unknowns."""
        _, entries = self.numbers.entries[id(self.document)]
        return {text: x for text, x in entries.items() if not isinstance(x, Linear)}

    def suppose(self, names: Mapping[str, str]) -> None:
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

    def find_signs(self) -> dict[str, list[int]] | None:
        """Return the diagonals of E by colour, after the checks of theorem 3, or None."""
        found = {c: [palindrome(row) for row in X] for c, (_, X) in self.halves.items()}
        mirrored = all(palindrome(weights) == 1 for weights, _ in self.halves.values())
        if not mirrored or any(0 in x for x in found.values()):
            return None
        E = {c: diagonal([Fraction(x) for x in signs]) for c, signs in found.items()}
        pairs = [(times(E[min(E)], self.G, E[max(E)]), self.G)]
        pairs += [(times(E[c], inverse_matrix(V), E[c]), V) for c, V in self.V.items()]
        return found if all(vanishes(minus(M, N)) for M, N in pairs) else None

    def reversal(self) -> dict[str, list]:
        """Return L = V^-1 E of each component."""
        signs = shown(self.signs, "the method is not symmetric")
        return {c: times(inverse_matrix(V), diagonal([Fraction(x) for x in signs[c]]))
                for c, V in self.V.items()}  # fmt: skip

    def growth_form(self, text: str, colour: str) -> tuple[str, Number, list]:
        """Return (colour, z, H): the growth parameter of z is sum d_i x_i^T H x_i."""
        z = self.number(text)
        v, w = eigenvector(self.first, z), eigenvector(self.last, z)
        seen = apply(self.G, w) if colour == min(self.V) else apply(transpose(self.G), v)
        return colour, z, parasitic_form(v, apply(self.G, w), seen)

    def zero_growths(self) -> int | None:
        """Return how many growth parameters there are, all 0, or None."""
        named = [e[2] for e in self.equations if e[0] == "growth"]
        counts = {circle_is_named(V, [z for half, z, _ in named if half == c])
                  for c, V in self.V.items()}  # fmt: skip
        count = counts.pop() if len(counts) == 1 else None
        return None if count is None else count * len(self.V)
