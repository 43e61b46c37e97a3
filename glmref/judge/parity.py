"""Starts and finishes in decimals, whose values have a parity (section 6.7)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TypeAlias

from .arithmetic import Fraction, Number
from .classes import classes
from .document import Component
from .enclosed_pair import ALTERNATING, Pair
from .fields import Numbers
from .grammar import published_decimal
from .krawczyk import Linear, at_values, only_root
from .linalg import apply, diagonal, dot, equal, identity, kernel, minus, transpose
from .numbers import as_reals, is_nil, total, vanishes
from .refusals import SIZE, Document, as_list, as_object, keys, require, whole
from .series import Series
from .trees import Tree, is_nystrom, read_tree, trees

#: The row and the tree of a condition, and the function that gives how far conditions fail.
Label: TypeAlias = tuple[int, Tree]
Gaps: TypeAlias = Callable[[list[Label], list], list]


class Block:
    """A start or finish whose decimals are unknowns, equal decimals one unknown, with its proof."""

    def __init__(
        self, numbers: Numbers, document: Document, proof: object = None, more: str = ""
    ) -> None:
        self.unknowns, self.numbers = {}, numbers.changed(decimal=self.unknown, unknowns={})
        self.digits, self.proof = document.get("digits", 75), proof
        if proof is not None:
            keys(proof, "radius centre inverse conditions" + more, where="proof")

    def unknown(self, text: str, digits: int) -> Linear:
        """Return the unknown that a decimal stands for."""
        require(len(text.partition(".")[2]) >= 20, "a decimal of a start has few places")
        return Linear({self.unknowns.setdefault(text, len(self.unknowns)): Fraction(1)})

    def matrix(self, rows: object) -> list:
        """Return the entries, expressions in the unknowns."""
        return self.numbers.matrix(rows, {"digits": 75})

    def finish(self, table: Document) -> tuple[list, list]:
        """Return A and b of a finish."""
        A, b = self.matrix(table["A"]), self.matrix([table["b"]])[0]
        require(len(A) == len(A[0]) == len(b), "shapes of the finish")
        return A, b

    def root(
        self,
        gaps: Gaps,
        wanted: list[Label],
        may_lack: Callable[[Label], bool] = lambda label: False,
    ) -> list:
        """Return intervals around the one root of the conditions, in the order of the proof.

        They are all that are `wanted`, less some that hold exactly, where these may be missing.
        """
        proof = as_object(self.proof)
        labels = [(whole(k, 0, SIZE), read_tree(t)) for k, t in as_list(proof["conditions"])]
        left = [x for x in wanted if x not in set(labels)]
        fine = len(set(labels)) == len(labels) == len(wanted) - len(left)
        require(fine and all(map(may_lack, left)), "the conditions are other ones")
        digits = whole(self.digits, 20, 400)
        published = [published_decimal(text, digits) for text in self.unknowns]
        root = only_root(lambda values: gaps(labels, values), published, digits, proof)
        require(all(map(is_nil, gaps(left, root))), "a condition is missing")
        return root


def partner(i: int) -> int:
    """Return the stage that h -> -h exchanges with stage i: 0 alone, then (1, 2), (3, 4), .."""
    return 0 if i == 0 else i + 1 if i % 2 else i - 1


def opposite(rows: list, images: list) -> None:
    """Refuse unless entry [i][partner j] of rows is minus entry [i][j] of images."""
    for row, image in zip(rows, images, strict=True):
        require(len(row) % 2 == 1, "a start with parity has an odd number of stages")
        fine = all(is_nil(row[partner(j)] + x) for j, x in enumerate(image))
        require(fine, "the stages have no parity")


def stage_series(A: list, q: int, base: Callable[[Tree], Number] | None = None) -> Series:
    """Return the series of Y_i = S + h sum A_ij f(Y_j) by classes, S with the series `base`."""
    U = [[Fraction(1)] if base else []] * len(A)
    found = Series({"o": Component(A, U, [], [])}.__getitem__, {},
                   lambda t: [base(t)] if base else [])  # fmt: skip
    found.q = q
    return found


def simplifies(A: list, most: int) -> int:
    """Return the largest q <= most with A c^(k-1) = c^k / k for k = 2..q, c = A 1."""
    c, q = [total(row) for row in A], 1
    while q < most and vanishes([x - y**(q + 1) * Fraction(1, q + 1) for x, y in
                                 zip(apply(A, [y**q for y in c]), c, strict=True)]):  # fmt: skip
        q += 1
    return q


def parts_of(L: list) -> list[tuple[list, int]]:
    """Return the rows f with f L = f or f L = -f, with the sign; e_1 comes first."""
    found = []
    for s in (1, -1):
        found += [(f, s) for f in kernel(minus(transpose(L), diagonal([Fraction(s)] * len(L))))]
    first = [x for x in found if bool(x[0][0])]
    fine = len(found) == len(L) and len(first) == 1 and vanishes(first[0][0][1:])
    require(fine and first[0][1] == 1, "L does not keep the first value apart")
    return first + [x for x in found if x is not first[0]]


def first_is_solution(numbers: Numbers, texts: object, r: int) -> None:
    """Refuse a start whose multiples of y are not 1, 0, .., 0."""
    require(numbers.vector(texts) == [Fraction(int(k == 0)) for k in range(r)], "u of the start")


def start_with_parity(
    proof: Document,
    numbers: Numbers,
    document: Document,
    series: Callable[[Tree], list],
    L: list,
    order: int,
    q_most: int,
) -> tuple[Block, list, list]:
    """Return (block, root, rows) of the start; `series` gives zeta(t) for any tree (6.7)."""
    table, block, r = as_object(document["starting"]), Block(numbers, document, proof), len(L)
    keys(table, "A B u", "name kind order", "start")
    first_is_solution(numbers, table["u"], r)
    A, B = block.matrix(table["A"]), block.matrix(table["B"])
    n = len(A)
    require(len(A[0]) == len(B[0]) == n and len(B) == r, "shapes of the start")
    opposite(A, [A[partner(i)] for i in range(n)])
    images = [[dot(row, [b[j] for b in B]) for j in range(n)] for row in L]
    opposite(B, images)
    known = not any(isinstance(x, Linear) for row in A for x in row)
    q = simplifies(A, q_most) if known else 1
    rows = [(as_reals(f), s) for f, s in parts_of(L)]
    wanted = [(k, t) for k, (_, s) in enumerate(rows) for m in range(1, order + (k > 0))
              if (m % 2 == 0) == (s > 0) for t in classes(m, q)]  # fmt: skip
    fixed = stage_series(as_reals(A), q) if known else None

    def gaps(labels: list[Label], values: list) -> list:
        stages = fixed or stage_series(at_values(A, values), q)
        weights, slopes = transpose(at_values(B, values)), cache(stages.derivative)
        seen = {k: [dot(rows[k][0], column) for column in weights] for k, _ in labels}
        return [dot(seen[k], slopes(t)) - dot(rows[k][0], series(t)) for k, t in labels]

    root = block.root(gaps, wanted, lambda label: label[0] == 0)
    return block, at_values(A, root), at_values(B, root)


def undoes(numbers: Numbers, opening: Document, closing: Document) -> bool:
    """Tell whether the finish undoes the first value of the start for all values of the digits."""
    block = Block(numbers, {})
    A, b = block.matrix(opening["A"]), block.matrix(opening["B"])[0]
    C, d = block.finish(closing)
    require(len(A) == len(A[0]) == len(b), "shapes of the start")
    needed = {j for j, x in enumerate(b) if not is_nil(x)}
    while True:
        more = {j for i in needed for j, x in enumerate(A[i]) if not is_nil(x)} | needed
        if more == needed:
            break
        needed = more
    stages = sorted(needed)
    if len(C) != len(stages):
        return False
    return all(is_nil(y + b[j]) for y, j in zip(d, stages, strict=True)) and all(
        is_nil(C[k][m] - (A[i][j] - b[j]))
        for k, i in enumerate(stages) for m, j in enumerate(stages))  # fmt: skip


def finish_with_parity(
    proof: Document, numbers: Numbers, document: Document, A: list, b: list, order: int
) -> None:
    """Refuse unless the finish has the order, after the start with stages A and weights b."""
    first, block = stage_series(A, 1), Block(numbers, document, proof)
    C, d = block.finish(as_object(document["finishing"]))
    opposite(C, [C[partner(i)] for i in range(len(C))])
    opposite([d], [d])
    wanted = [(0, t) for m in range(2, order + 1, 2) for t in classes(m, 1)]
    base = cache(lambda t: dot(b, first.derivative(t)))

    def gaps(labels: list[Label], values: list) -> list:
        stages, weights = stage_series(at_values(C, values), 1, base), at_values(d, values)
        return [dot(weights, stages.derivative(t)) + base(t) for _, t in labels]

    block.root(gaps, wanted)


def even_start(
    proof: Document, pair: Pair, numbers: Numbers, document: Document
) -> tuple[int, int]:
    """Return the orders (all trees, second-order systems) of the start of a pair (6.7)."""
    table, block = as_object(document["starting"]), Block(numbers, document, proof, " orders")
    most, nystrom = (whole(x, 0, 12) for x in as_list(proof["orders"], "orders"))
    for L in pair.reversal().values():
        equal(L, identity(len(L)), "L = I")
    zeta = {}
    for order, kind in ((most, False), (nystrom, True)):
        if order:
            require(pair.identity_through(order - 1, kind), "a principal part is not shown to be 0")
            series = pair.series(pair.root, order, kind)
            series.fill()
            zeta.update(series.eta)
    keys(table, "A B u A_hat B_hat u_hat", "name kind order", "start")
    tables = {}
    for c, hat in (("f", ""), ("k", "_hat")):
        first_is_solution(numbers, table["u" + hat], len(pair.V[c]))
        tables[c] = block.matrix(table["A" + hat]), block.matrix(table["B" + hat])
    sizes = {"f": len(tables["f"][0]), "k": len(tables["k"][0])}
    for c, other in (("f", "k"), ("k", "f")):
        A, B = tables[c]
        require(len(A[0]) == len(B[0]) == sizes[other] and len(B) == len(pair.V[c]), "shapes")
        require(all(map(is_nil, A[0] + B[0])), "the first stage and value are the solution")
        opposite(A, [A[partner(i)] for i in range(len(A))])
        opposite(B, B)
    wanted = [(k, t) for n in range(2, max(most, nystrom) + 1, 2) for t in trees(ALTERNATING, n)
              if n <= most or (n <= nystrom and is_nystrom(t))
              for k in range(1, len(pair.V[t[0]]))]  # fmt: skip

    def gaps(labels: list[Label], values: list) -> list:
        start = Series.of_tables({c: (at_values(A, values), at_values(B, values))
                                  for c, (A, B) in tables.items()})  # fmt: skip
        slopes = cache(start.derivative)
        return [dot(start.part(t[0]).B[k], slopes(t)) - zeta[t][k] for k, t in labels]

    block.root(gaps, wanted)
    return most, max(most, nystrom)
