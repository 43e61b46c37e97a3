"""Starts and finishes in decimals, whose values have a parity (section 6.7)."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import cache, cached_property
from typing import TypeAlias

from .arithmetic import Fraction, Number
from .classes import classes
from .document import Component
from .enclosed_pair import ALTERNATING, Pair
from .fields import Numbers
from .grammar import decimal_number, published_decimal
from .krawczyk import Linear, at_values, box_around, only_root
from .linalg import Matrix, apply, diagonal, dot, equal, identity, kernel, minus, transpose
from .numbers import as_reals, is_nil, total, vanishes
from .refusals import SIZE, Document, as_list, as_object, as_text, keys, require, whole
from .series import Series
from .trees import Tree, is_nystrom, read_tree, trees

#: The row and the tree of a condition.
Label: TypeAlias = tuple[int, Tree]


class Block:
    """A start or finish whose decimals are unknowns, and the conditions that they satisfy.

    Equal decimals are one unknown. Each class has its conditions, those `wanted`, and the `gaps` by
    which they fail at values of the unknowns: that is what a finder of the root evaluates.
    """

    members = ""  # of the proof, besides those of every class
    wanted: list[Label]

    def __init__(self, numbers: Numbers, document: Document) -> None:
        self.unknowns, self.numbers = {}, numbers.changed(decimal=self.unknown, unknowns={})
        self.document, self.roots, self.boxes = document, {}, {}

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

    @cached_property
    def digits(self) -> int:
        """The places of the decimals, which are rounded to nearest."""
        return whole(self.document.get("digits", 75), 20, 400)

    @cached_property
    def published(self) -> list[Fraction]:
        """The numbers that the decimals are."""
        return [published_decimal(text, self.digits) for text in self.unknowns]

    def gaps(self, labels: list[Label], values: list) -> list:
        """Return by how much the conditions fail at values of the unknowns."""
        return []

    def over_box(self, labels: list[Label], radius: str) -> list:
        """Return the gaps over the box of a proof, with their derivatives."""
        new = [x for x in labels if (radius, x) not in self.boxes]
        if new:
            box = box_around(self.published, decimal_number(radius))
            found = self.gaps(new, box)
            self.boxes |= {(radius, x): gap for x, gap in zip(new, found, strict=True)}
        return [self.boxes[radius, x] for x in labels]

    def may_lack(self, label: Label) -> bool:
        """Tell whether a condition may be missing in a proof where it holds exactly."""
        return False

    def root(self, proof: Document) -> list:
        """Return intervals around the one root of the conditions, in the order of the proof.

        They are all that are `wanted`, less some that hold exactly, where these may be missing.
        """
        key = json.dumps(proof)
        if key not in self.roots:
            keys(proof, "radius centre inverse conditions" + self.members, where="proof")
            self.roots[key] = self.only_root(as_object(proof))
        return self.roots[key]

    def only_root(self, proof: Document) -> list:
        """Return the root after the checks of its proof."""
        labels = [(whole(k, 0, SIZE), read_tree(t)) for k, t in as_list(proof["conditions"])]
        left = [x for x in self.wanted if x not in set(labels)]
        fine = len(set(labels)) == len(labels) == len(self.wanted) - len(left)
        require(fine and all(map(self.may_lack, left)), "the conditions are other ones")
        radius = as_text(proof["radius"], "the radius")
        root = only_root(lambda values: self.gaps(labels, values), self.published, self.digits,
                         proof, lambda: self.over_box(labels, radius))  # fmt: skip
        require(all(map(is_nil, self.gaps(left, root))), "a condition is missing")
        return root


def partner(i: int) -> int:
    """Return the stage that h -> -h exchanges with stage i: 0 alone, then (1, 2), (3, 4), .."""
    return 0 if i == 0 else i + 1 if i % 2 else i - 1


def opposite(rows: list, images: list | None = None) -> None:
    """Refuse unless entry [i][partner j] of rows is minus entry [i][j] of images.

    The images of the rows of stages are those of their partners.
    """
    for row in rows if images else [*rows, rows]:
        require(len(row) % 2 == 1, "a start with parity has an odd number of stages")
    for row, image in zip(rows, images or [rows[partner(i)] for i in range(len(rows))],
                          strict=True):  # fmt: skip
        fine = all(is_nil(row[partner(j)] + x) for j, x in enumerate(image))
        require(fine, "the stages have no parity")


def stage_series(A: list, q: int, base: Callable[[Tree], Number] | None = None) -> Series:
    """Return the series of Y_i = S + h sum A_ij f(Y_j) by classes, S with the series `base`."""
    U = [[Fraction(1)] if base else []] * len(A)
    found = Series({"o": Component(Matrix(A), U, [], [])}.__getitem__, {},
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


class OddStart(Block):
    """The start of one method, whose stages and values have a parity (6.7).

    It is to agree with `series`, which gives zeta(t) for any tree, through the `order`.
    """

    def __init__(
        self,
        numbers: Numbers,
        document: Document,
        series: Callable[[Tree], list],
        L: list,
        order: int,
        q_most: int,
    ) -> None:
        super().__init__(numbers, document)
        table, r = as_object(document["starting"]), len(L)
        keys(table, "A B u", "name kind order", "start")
        first_is_solution(numbers, table["u"], r)
        self.A, self.B, self.series = self.matrix(table["A"]), self.matrix(table["B"]), series
        n = len(self.A)
        require(len(self.A[0]) == len(self.B[0]) == n and len(self.B) == r, "shapes of the start")
        opposite(self.A)
        opposite(self.B, [[dot(row, [b[j] for b in self.B]) for j in range(n)] for row in L])
        known = not any(isinstance(x, Linear) for row in self.A for x in row)
        self.q = simplifies(self.A, q_most) if known else 1
        parts = parts_of(L)
        self.rows = [as_reals(f) for f, _ in parts]
        self.seen = [[dot(f, [b[j] for b in self.B]) for j in range(n)] for f, _ in parts]
        self.wanted = [(k, t) for k, (_, s) in enumerate(parts)
                       for m in range(1, order + (k > 0))
                       if (m % 2 == 0) == (s > 0) for t in classes(m, self.q)]  # fmt: skip
        self.fixed = stage_series(as_reals(self.A), self.q) if known else None

    def may_lack(self, label: Label) -> bool:
        """Tell whether a condition is one of the first value."""
        return label[0] == 0

    def gaps(self, labels: list[Label], values: list) -> list:
        """Return start - zeta in the parts of the values that L keeps or turns round."""
        stages = self.fixed or stage_series(at_values(self.A, values), self.q)
        slopes = cache(stages.derivative)
        weights = {k: at_values(self.seen[k], values) for k in {k for k, _ in labels}}
        return [dot(weights[k], slopes(t)) - self.aim(k, t) for k, t in labels]

    def aim(self, k: int, t: Tree) -> Number:
        """Return zeta(t) in a part of the values."""
        return dot(self.rows[k], self.series(t))

    def at(self, proof: Document) -> tuple[list, list]:
        """Return A and B at the root."""
        root = self.root(proof)
        return at_values(self.A, root), at_values(self.B, root)


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


class OddFinish(Block):
    """The finish with parity of a method that gives y back after a start with stages A, weights b.

    That is so at the even trees through the `order`; at the odd ones it follows.
    """

    def __init__(self, numbers: Numbers, document: Document, A: list, b: list, order: int) -> None:
        super().__init__(numbers, document)
        self.C, self.d = self.finish(as_object(document["finishing"]))
        opposite(self.C)
        opposite([self.d], [self.d])
        self.wanted = [(0, t) for m in range(2, order + 1, 2) for t in classes(m, 1)]
        first = stage_series(A, 1)
        self.base = cache(lambda t: dot(b, first.derivative(t)))

    def gaps(self, labels: list[Label], values: list) -> list:
        """Return the series of the finish after the start, less y."""
        stages = stage_series(at_values(self.C, values), 1, self.base)
        weights = at_values(self.d, values)
        return [dot(weights, stages.derivative(t)) + self.base(t) for _, t in labels]


class EvenStart(Block):
    """The start of a pair through two orders, on all trees and on second-order systems (6.7)."""

    members = " orders"

    def __init__(
        self, numbers: Numbers, document: Document, pair: Pair, orders: Sequence[int]
    ) -> None:
        super().__init__(numbers, document)
        table, (most, nystrom) = as_object(document["starting"]), orders
        for L in pair.reversal().values():
            equal(L, identity(len(L)), "L = I")
        self.zeta = {}
        for order, kind in ((most, False), (nystrom, True)):
            if order:
                fine = pair.identity_through(order - 1, kind)
                require(fine, "a principal part is not shown to be 0")
                series = pair.series(pair.root, order, kind)
                series.fill()
                self.zeta.update(series.eta)
        keys(table, "A B u A_hat B_hat u_hat", "name kind order", "start")
        self.tables = tables = {}
        for c, hat in (("f", ""), ("k", "_hat")):
            first_is_solution(numbers, table["u" + hat], len(pair.V[c]))
            tables[c] = self.matrix(table["A" + hat]), self.matrix(table["B" + hat])
        sizes = {"f": len(tables["f"][0]), "k": len(tables["k"][0])}
        for c, other in (("f", "k"), ("k", "f")):
            A, B = tables[c]
            require(len(A[0]) == len(B[0]) == sizes[other] and len(B) == len(pair.V[c]), "shapes")
            require(all(map(is_nil, A[0] + B[0])), "the first stage and value are the solution")
            opposite(A)
            opposite(B, B)
        self.wanted = [(k, t) for n in range(2, max(most, nystrom) + 1, 2)
                       for t in trees(ALTERNATING, n)
                       if n <= most or (n <= nystrom and is_nystrom(t))
                       for k in range(1, len(pair.V[t[0]]))]  # fmt: skip

    def gaps(self, labels: list[Label], values: list) -> list:
        """Return start - zeta in the values beyond the first."""
        start = Series.of_tables({c: (at_values(A, values), at_values(B, values))
                                  for c, (A, B) in self.tables.items()})  # fmt: skip
        slopes = cache(start.derivative)
        return [dot(start.part(t[0]).B[k], slopes(t)) - self.zeta[t][k] for k, t in labels]
