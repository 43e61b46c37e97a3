"""A start from a rational tableau with stage order: only its weights are solved for, linearly.

The first seven stages are collocation at 0, +-1/3, +-2/3, +-1 (one coupled block); each further
pair is explicit and of stage order 2 or 3 by rational moment conditions. For a method of stage
order 3 the conditions are then those of 22 even and 12 odd classes of trees up to order 8 (47 and
23 at stage order 2), linear in the weights, one column for each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from ..catalogue.writer import DIGITS, decimal
from ..errors import ExactnessError
from ..exact import Exact, ball, linalg
from ..exact.judging import as_numbers, as_scalar, consulted
from ..exact.linalg import Matrix
from ..prove.starting import Target, inverse_block, prove_blocks
from .parameters import RankError, pivots
from .parity_start import add_terms, negated
from .recognise import exact_text

NODES = tuple(Fraction(x, 3) for x in (0, 1, -1, 2, -2, 3, -3))


def collocation(nodes: Sequence[Fraction]) -> list[list[Fraction]]:
    """Return ``a_ij``: the integral from 0 to c_i of the j-th Lagrange polynomial."""
    rows: list[list[Fraction]] = [[] for _ in nodes]
    for j, node in enumerate(nodes):
        p = [Fraction(1)]
        for k, other in enumerate(nodes):
            if k != j:
                p = [
                    ((p[m - 1] if m else 0) - (other * p[m] if m < len(p) else 0)) / (node - other)
                    for m in range(len(p) + 1)
                ]
        for i, x in enumerate(nodes):
            rows[i].append(sum((c * x ** (m + 1) / (m + 1) for m, c in enumerate(p)), Fraction(0)))
    return rows


def tableau(pairs: Sequence[Mapping[str, str]], *, moments: int = 3) -> list[list[Fraction]]:
    """Return a with the collocation block and one pair of stages for each record.

    Args:
        pairs: for each pair its abscissa ``"c"`` and coefficients by column, rational; those of the
            columns 0 and 5 (nodes 0 and 1), and 6 (node -1) with three moments, are solved for.
        moments: the stage order of the rows: ``A 1 = c, A c = c^2/2`` and, with 3, ``A c^2 =
        c^3/3``.
    """
    size, block = 7 + 2 * len(pairs), collocation(NODES)
    rows = [row + [Fraction(0)] * (size - 7) for row in block]
    c = list(NODES)
    for record in pairs:
        x = Fraction(record["c"])
        row = [Fraction(0)] * size
        for column, text in record.items():
            if column != "c":
                row[int(column)] = Fraction(text)
        one, two, three = (
            x ** (k + 1) / (k + 1)
            - sum((a * y**k for a, y in zip(row, c, strict=False)), Fraction(0))
            for k in range(3)
        )
        if moments == 3:
            row[5], row[6], row[0] = (three + two) / 2, (three - two) / 2, one - three
        else:
            row[5], row[0] = two, one - two
        mirror = [row[0], *(row[j + 1 if j % 2 else j - 1] for j in range(1, size))]
        rows += [row, [-a for a in mirror]]
        c += [x, -x]
    return rows


def _choose(matrix: Matrix, density: Sequence[int]) -> list[int]:
    """Choose as many columns as rows: the first ones if regular, else by pivoting.

    Raises
    ------
    ExactnessError
        When the columns do not span.
    """
    rows = np.array([[float(x) * y for x in row] for row, y in zip(matrix, density, strict=True)])
    try:
        left_out = pivots(rows, tolerance=1e-9)
    except RankError as error:
        raise ExactnessError(
            f"the stages do not span the conditions ({error}); add pairs"
        ) from None
    return [j for j in range(rows.shape[1]) if j not in left_out]


def linear_start(
    pairs: Sequence[Mapping[str, str]],
    target: Target,
    L: Matrix,
    *,
    first: int,
    moments: int = 3,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Solve for the weights; return the start and the finish that inverts its first value.

    The first value may use the first so many of the pairs, block included: few keep the finish
    short. ``target`` is that of a method with ``moments`` as its stage order, see :func:`tableau`,
    which L reverses.

    Raises
    ------
    ExactnessError
        When the stages do not span the conditions, or the proof fails.
    """
    rows = [[str(x) for x in row] for row in tableau(pairs, moments=moments)]
    count = 3 + len(pairs)
    with consulted() as judge:
        found = judge.parity.parts_of(as_numbers(L))
        forms = [(tuple(map(as_scalar, row)), sign) for row, sign in found]
        idle = _block(rows, [["0"] * (count + 1)] * len(forms), forms)
        start = target.of_document({"starting": {**idle, "order": target.order}}).start
        parts = []
        for k, (_, sign) in enumerate(forms):
            listed = [t for i, t in start.wanted if i == k]
            # a weight on stage 0 counts in odd values only; on a pair it stands twice
            columns = [*([] if sign > 0 else [0]), *range(1, len(rows), 2)]
            columns = columns[:first] if k == 0 else columns
            slopes = [start.fixed.derivative(t) for t in listed]
            matrix = tuple(
                tuple(as_scalar(row[j] * (2 if j else 1)) for j in columns) for row in slopes
            )
            chosen = _choose(matrix, [judge.trees.gamma(t) for t in listed])
            square = tuple(tuple(row[j] for j in chosen) for row in matrix)
            right = tuple((as_scalar(start.aim(k, t)),) for t in listed)
            solved = dict(zip(chosen, (x[0] for x in linalg.solve(square, right)), strict=True))
            texts = {j: decimal(ball(x)) for j, x in solved.items()}
            shift = 1 if sign > 0 else 0
            parts.append([texts.get(j - shift, "0") for j in range(count + 1)])
    block = {**_block(rows, parts, forms), "order": target.order}
    prove_blocks(target.of_document({"digits": DIGITS, "starting": block}))
    return block, {**inverse_block(block), "order": target.order}


def _block(
    A: Sequence[Sequence[str]],
    parts: Sequence[Sequence[str]],
    forms: Sequence[tuple[tuple[Any, ...], int]],
) -> dict[str, Any]:
    """Carry the values in eigenvectors of L back to y: B = (forms)^-1 parts."""
    back = linalg.inverse(tuple(row for row, _ in forms))
    size = len(A)
    flat = []
    for part, (_, sign) in zip(parts, forms, strict=True):
        row = [part[0]]
        for x in part[1:]:
            row += [x, x if sign < 0 else negated(x)]
        flat.append(row)
    B = []
    for line in back:
        texts = [exact_text(x) if isinstance(x, Exact) else "" for x in line]
        B.append(
            [
                add_terms([(flat[k][j], x) for k, x in enumerate(texts) if x != "0"])
                for j in range(size)
            ]
        )
    return {
        "name": f"start of {size} stages, seven of them one collocation block",
        "kind": "runge-kutta",
        "A": A,
        "B": B,
        "u": ["1"] + ["0"] * (len(back) - 1),
    }
