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

from ..catalogue.writer import decimal
from ..errors import ExactnessError
from ..exact import Exact, linalg
from ..exact.linalg import Matrix
from ..prove.classes import classes
from ..prove.starting import Target, functionals, inverse_block, prove_starting
from ..prove.tableau_series import stage_order, weights
from ..theory.trees import Tree
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


def _columns(series: Mapping[Tree, Sequence[Any]], rows: Sequence[Tree], *, even: bool) -> Matrix:
    """Return what a weight on stage 0 (odd values only) or on each pair adds at the given trees."""
    return tuple(
        tuple(
            Exact(0) + (series[t][j] if j == 0 else series[t][j] * 2)
            for j in range(1 if even else 0, len(series[t]), 1)
            if j == 0 or j % 2
        )
        for t in rows
    )


def _choose(matrix: Matrix, trees: Sequence[Tree]) -> list[int]:
    """Choose as many columns as rows: the first ones if regular, else by pivoting.

    Raises
    ------
    ExactnessError
        When the columns do not span.
    """
    rows = np.array(
        [[float(x) * t.density for x in row] for row, t in zip(matrix, trees, strict=True)]
    )
    try:
        left_out = pivots(rows, tolerance=1e-9)
    except RankError as error:
        raise ExactnessError(
            f"the stages do not span the conditions ({error}); add pairs"
        ) from None
    return [j for j in range(rows.shape[1]) if j not in left_out]


def linear_start(
    pairs: Sequence[Mapping[str, str]], target: Target, *, first: int, moments: int = 3
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Solve for the weights; return the start and the finish that inverts its first value.

    The first value may use the first so many of the pairs, block included: few keep the finish
    short. ``target`` is that of a method with ``moments`` as its stage order, see :func:`tableau`.

    Raises
    ------
    ExactnessError
        When the stages do not span the conditions, or the proof fails.
    """
    A = tuple(tuple(Exact(x) for x in row) for row in tableau(pairs, moments=moments))
    q = stage_order(A, most=target.stage_order)
    unit = linalg.identity(len(A))
    found = weights(A, unit, target.order, parity=True, q=q)
    series = {t: [row[t] for row in found] for t in found[0]}
    count = 3 + len(pairs)
    parts: list[list[str]] = []
    forms = functionals(target.L["o"])
    for k, (form, sign) in enumerate(forms):
        order = target.order - (k == 0)
        rows = [t for n in range(2 if sign > 0 else 1, order + 1, 2) for t in classes(n, q)]
        matrix = _columns(series, rows, even=sign > 0)
        if k == 0:
            matrix = tuple(row[:first] for row in matrix)
        chosen = _choose(matrix, rows)
        square = tuple(tuple(row[j] for j in chosen) for row in matrix)
        right = tuple((linalg.dot(form, target.zeta[t]),) for t in rows)
        solved = dict(zip(chosen, (x[0] for x in linalg.solve(square, right)), strict=True))
        texts = {j: decimal(x.ball()) for j, x in solved.items()}
        shift = 1 if sign > 0 else 0
        parts.append([texts.get(j - shift, "0") for j in range(count + 1)])
    block = _block(A, parts, forms)
    block["order"] = target.order
    prove_starting(block, target)
    return block, {**inverse_block(block), "order": target.order}


def _block(
    A: Matrix, parts: Sequence[Sequence[str]], forms: Sequence[tuple[tuple[Any, ...], int]]
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
        "A": [[str(x.as_fraction()) for x in row if isinstance(x, Exact)] for row in A],
        "B": B,
        "u": ["1"] + ["0"] * (len(back) - 1),
    }
