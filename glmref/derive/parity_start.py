"""Build a start or finish with parity from its parameters, and polish it.

Stages: Y0 = y0, then pairs ``Y+-_i = y0 +- h (a_i f(Y0) + sum_j (p_ij f(Y+-_j) + q_ij
f(Y-+_j)))``, j < i. An even value weighs ``v_i (f(Y+_i) - f(Y-_i))``, an odd one ``u_0 f(Y0) +
u_i (f(Y+_i) + f(Y-_i))``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from ..catalogue.claims import NYSTROM_ORDER, NYSTROM_STARTING_ORDER, ORDER, STARTING_ORDER
from ..catalogue.writer import DIGITS, decimal
from ..errors import ExactnessError
from ..exact import ball
from ..exact.judging import as_scalar, fast_judge
from ..prove.enclosure import Enclosure
from ..prove.starting import (
    DECIMAL,
    Target,
    conditions_of,
    made,
    proposed,
    prove_blocks,
)
from .polish import polish


def _text(value: str) -> str:
    """Return a rational as it is, and an unknown, a rough decimal, with all its places."""
    if "." not in value and "e" not in value:
        return value
    return decimal(ball(Fraction(value)))


def negated(text: str) -> str:
    """Return the text of the negative of one number."""
    if text == "0":
        return text
    return text[1:] if text.startswith("-") else f"-{text}"


def _sum(*terms: tuple[str, str]) -> str:
    """Return the text of a sum of products (number, factor), with zeros left out."""
    result = ""
    for number, factor in terms:
        if number == "0":
            continue
        term = f"{number}{factor}"
        result += term if not result or term.startswith("-") else f"+{term}"
    return result or "0"


def add_terms(terms: Sequence[tuple[str, str]]) -> str:
    """Return a sum of decimals times exact factors as text, without zeros and factors 1."""
    result = ""
    for number, factor in terms:
        if number == "0":
            continue
        if any(x in factor[1:] for x in "+-"):
            factor = f"({factor})"
        elif factor.startswith("-"):
            number, factor = negated(number), factor[1:]
        term = number if factor == "1" else f"{number}*{factor}"
        result += term if not result or term.startswith("-") else f"+{term}"
    return result or "0"


class _Parameters:
    """The numbers of a start in the order a, p, q, then the weights of each value."""

    def __init__(self, pairs: int, values: Sequence[str]) -> None:
        self.pairs, self._values = pairs, [_text(x) for x in values]
        self._place = 0

    def take(self, count: int) -> list[str]:
        """Return the next numbers."""
        found = self._values[self._place : self._place + count]
        self._place += count
        return found

    def stages(self) -> list[list[str]]:
        """Return A, row by row."""
        n = self.pairs
        a = self.take(n)
        p, q = self.take(n * (n - 1) // 2), self.take(n * (n - 1) // 2)
        size = 2 * n + 1
        rows = [["0"] * size]
        for i in range(n):
            first = i * (i - 1) // 2
            plus, minus = [a[i]], [negated(a[i])]
            for j in range(i):
                x, y = p[first + j], q[first + j]
                plus += [x, y]
                minus += [negated(y), negated(x)]
            rows += [row + ["0"] * (size - len(row)) for row in (plus, minus)]
        return rows

    def even(self) -> list[tuple[str, str]]:
        """Return weights (on f(Y+), on f(Y-)) of an even value, with f(Y0) in front."""
        return [("0", "0"), *((x, negated(x)) for x in self.take(self.pairs))]

    def odd(self) -> list[tuple[str, str]]:
        """Return weights of an odd value."""
        pairs, (first,) = self.take(self.pairs), self.take(1)
        return [(first, first), *((x, x) for x in pairs)]


def _flat(weights: Sequence[tuple[str, str]]) -> list[str]:
    return [weights[0][0], *(x for pair in weights[1:] for x in pair)]


def starting_block(
    pairs: int, values: Sequence[str], *, root: str, free: bool, last_even: bool
) -> dict[str, Any]:
    """Return the start for four values with V = diag(1, z, conj z, -1), from its parameters.

    Parameters
    ----------
    pairs : int
        n; there are 2 n + 1 stages.
    values : Sequence[str]
        a, p, q and the weights, rationals or rough decimals.
    root : str
        ``"w3"`` or ``"i"``: L exchanges y_2 and y_3 as z asks, and with e even, o odd ``y_2 =
        sqrt(3) e + o, y_3 = e - sqrt(3) o`` or ``y_2 = e + o, y_3 = e - o``.
    free : bool
        Whether the first value needs weights (a principal start that is no identity).
    last_even : bool
        Whether the fourth value is even.
    """
    parameters = _Parameters(pairs, values)
    A = parameters.stages()
    first = _flat(parameters.even()) if free else ["0"] * len(A)
    e, o = _flat(parameters.even()), _flat(parameters.odd())
    last = _flat(parameters.even() if last_even else parameters.odd())
    factor = "*sqrt(3)" if root == "w3" else ""
    second = [_sum((x, factor), (y, "")) for x, y in zip(e, o, strict=True)]
    third = [_sum((x, ""), (negated(y), factor)) for x, y in zip(e, o, strict=True)]
    return {
        "name": f"explicit start of {len(A)} stages, symmetric under reversal of h",
        "kind": "runge-kutta",
        "A": A,
        "B": [first, second, third, last],
        "u": ["1", "0", "0", "0"],
    }


def finishing_block(pairs: int, values: Sequence[str]) -> dict[str, Any]:
    """Return the tableau of a finish from its parameters a, p, q, v."""
    parameters = _Parameters(pairs, values)
    A = parameters.stages()
    return {
        "name": f"explicit finish of {len(A)} stages, symmetric under reversal of h",
        "kind": "runge-kutta",
        "A": A,
        "b": _flat(parameters.even()),
    }


def expanded(half: Mapping[str, Sequence[Sequence[str]]]) -> dict[str, Any]:
    """Return the block of a start from one stage of each pair.

    "A" and "A_hat" of ``half`` are rows of the stages 1, 3, ..; "B" and "B_hat" for each value
    beyond the first the weights of the stages 1, 3, ... Rationals, or decimals of any length for
    the unknowns: equal decimals are one unknown.
    """
    block: dict[str, Any] = {}
    for name in ("A", "A_hat"):
        rows = [[_text(x) for x in row] for row in half[name]]
        full, partner = [["0"] * len(rows[0])], fast_judge().parity.partner
        for row in rows:
            full += [row, [negated(row[partner(j)]) for j in range(len(row))]]
        block[name] = full
    for name in ("B", "B_hat"):
        rows = [[_text(x) for x in row] for row in half[name]]
        flat = [["0", *(y for x in row for y in (x, negated(x)))] for row in rows]
        block[name] = [["0"] * len(flat[0]), *flat]
    block["u"] = ["1"] + ["0"] * len(half["B"])
    block["u_hat"] = ["1"] + ["0"] * len(half["B_hat"])
    q, p = len(block["A"]), len(block["A_hat"])
    name = f"explicit start of {q} stages Q and {p} stages P, even in h"
    return {"name": name, "kind": "runge-kutta", **block}


def with_partitioned_start(
    document: Mapping[str, Any], enclosure: Enclosure, half: Mapping[str, Any]
) -> dict[str, Any]:
    """Add a start of the order of a pair, and of its order on second-order systems.

    Raises
    ------
    ConvergenceError, ExactnessError
        When the digits lead to no exact start.
    """
    claims = dict(document["claims"])
    claims[STARTING_ORDER.key] = claims[ORDER.key]
    if NYSTROM_ORDER.key in claims:
        claims[NYSTROM_STARTING_ORDER.key] = claims[NYSTROM_ORDER.key]
    changed = {**document, "claims": claims}
    target = Target.of(changed, enclosure.root.record)
    return {**changed, "starting": complete(expanded(half), None, target)[0]}


def _polished(key: str, texts: Mapping[str, Any], block: Any) -> dict[str, Any]:
    """Return a start or finish with its rough decimals replaced by those of the root.

    A sign that has changed is carried along.
    """
    conditions = conditions_of(key, block)
    point = [as_scalar(x) for x in block.published]
    found = polish(lambda values: block.gaps(conditions, values), point, digits=90)
    new = {old: decimal(x) for old, x in zip(block.unknowns, found, strict=True)}
    if any(x.startswith("-") for x in new.values()):
        raise ExactnessError("a parameter changed its sign while it was polished")

    def replaced(rows: Any) -> Any:
        if isinstance(rows, str):
            return DECIMAL.sub(lambda m: new[m[0]], rows)
        return [replaced(x) for x in rows]

    names = {"A", "B", "A_hat", "B_hat", "b"} & texts.keys()
    return {**texts, **{x: replaced(texts[x]) for x in names}}


def complete(
    start: Mapping[str, Any], finish: Mapping[str, Any] | None, target: Target
) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """Polish a start and a finish to :data:`~glmref.catalogue.writer.DIGITS` digits and prove them.

    Raises
    ------
    ConvergenceError, ExactnessError
        When a rough tableau leads to no exact one.
    """
    blocks = {"starting": {**start, "order": target.order}}
    if finish is not None:
        blocks["finishing"] = {**finish, "order": target.order}

    def begun() -> Target:
        return target.of_document({"digits": DIGITS, **blocks})

    block = made("starting", lambda: begun().start)
    blocks["starting"] = _polished("starting", blocks["starting"], block)
    if finish is not None:
        found = begun()
        first = proposed("starting", found.start)
        block = made("finishing", lambda: found.record.finish(found.start, first, target.order))
        blocks["finishing"] = _polished("finishing", blocks["finishing"], block)
    prove_blocks(begun())
    return blocks["starting"], blocks.get("finishing")
