"""What a plain document says of its orders, judged: each is at least what is said.

The conditions are evaluated by the kernel on the schemes of :mod:`.schemes`. Rounded decimals are
numbers known to their digits: within these nothing is proved, and a condition that fails beyond
them refutes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from math import isfinite
from typing import Any

from ..catalogue.claims import (
    DENSE_ORDER,
    EMBEDDED_DIFFERENCE,
    EMBEDDED_ORDER,
    NYSTROM_ORDER,
    ORDER,
    W_ORDER,
    PlainClaims,
    Said,
)
from ..catalogue.plain import as_written
from ..catalogue.reader import load_document
from ..exact import Exact
from ..exact.linalg import Vector
from ..findings import Finding, Verdict
from ..method.digits import digits_of, meant, within_digits
from .digits import rounded_up
from .facts import facts_of
from .schemes import (
    LARGEST,
    Reach,
    Scheme,
    additive,
    further,
    reach,
    runge_kutta,
    scheme_of,
)
from .verdicts import reaches, vanishing
from .wrong_entry import ROUNDING, corrected, row_apart

#: Through which order decimals are looked at as they are written; rounded ones fail before.
_LITERAL = 6
#: Claims that are judged here.
ORDERS = frozenset(x.key for x in (ORDER, NYSTROM_ORDER, W_ORDER, DENSE_ORDER, EMBEDDED_ORDER))


@dataclass(frozen=True)
class _Row:
    """Something that has an order: its name, what is said, and its scheme."""

    claim: str
    declared: int
    scheme: Scheme
    remark: str = ""


def order_findings(method: Any) -> list[Finding]:
    """Judge the orders that a plain document says of its method and of its rows and parts.

    Parameters
    ----------
    method : Method
        With :class:`~glmref.catalogue.claims.PlainClaims`.
    """
    plain = _Orders(method)
    name = method.name
    if method.is_exact:
        digits, near = digits_of(method), within_digits(method)
        literal = None if near is None else plain
        judged = plain if near is None else _Orders(method, near)
    else:
        digits = method.document["digits"]
        written = load_document(as_written({**method.document, "claims": {}}), where=name)
        literal, judged = _Orders(method, written), plain
    findings: list[Finding] = []
    for said in plain.said:
        for row in judged.rows(said):
            if isinstance(row, _Row):
                found = _judged(row, name, digits, partial(_correction, plain, said, row.declared))
                if found.verdict is Verdict.OPEN and literal is not None:
                    found = replace(found, witness=f"{found.witness}; {literal.remark(said, row)}")
            else:
                found = row(name)
            findings.append(found)
    return findings


def _correction(plain: _Orders, said: Said, declared: int) -> str:
    """Name the one entry that is wrong, where one is; ``""`` for what is said of a row."""
    return corrected(plain.method, declared, plain.times) if said.claim == ORDER.key else ""


class _Orders:
    """What is said of a method, with the schemes that decide it.

    Parameters
    ----------
    method : Method
        As it was read.
    numbers : Method, optional
        The same method with other numbers: balls for its decimals, or what these write.
    """

    def __init__(self, method: Any, numbers: Any = None) -> None:
        self.method = method if numbers is None else numbers
        claims: PlainClaims = method.claims
        self.said, self.times = claims.said, claims.times
        self.kind = str((method.document or {}).get("class"))
        one = self.method.is_one_step and all(
            (x - 1).is_zero() is True for c in self.method.components for x in (*c.V[0],)
        )
        self.known = one and self.method.output is None

    def schemes(self, weights: Sequence[Vector]) -> list[tuple[str, Scheme]]:
        """Return schemes with other weights, a row for each component, by what the order is of."""
        m = self.method
        if m.additive and not m.rosenbrock:
            parts = [(c.A, w) for c, w in zip(m.components, weights, strict=True)]
            return [("", additive(parts, self.times or ()))]
        if len(m.components) == 1:
            return [("", runge_kutta(m.A, weights[0], m.abscissae_given))]
        other = m.weighted(tuple((w,) for w in weights))
        if self.kind == "nystrom":
            words = zip(("the position", "the velocity"), "fk", strict=True)
            return [(word, scheme_of(other, roots=root, nystrom=True)) for word, root in words]
        return [("", scheme_of(other))]

    def rows(self, said: Said) -> list[_Row | Callable[[str], Finding]]:
        """Return what decides one thing that is said."""
        m = self.method
        main = [c.B[0] for c in m.components]
        if not self.known:
            return [self.ranged(said)]
        if said.claim == ORDER.key:
            remark = "" if getattr(m, "abscissae_given", None) is None else row_apart(
                m.A, m.abscissae_given)  # fmt: skip
            return [
                _Row(f"order of {what}" if what else "order", said.order, scheme, remark)
                for what, scheme in self.schemes(main)
            ]
        if said.claim == W_ORDER.key:
            return [_Row("W-order", said.order, scheme_of(m.with_any_matrix()))]
        if said.claim == "part":
            c = m.components[said.number - 1]
            times = None if self.times is None else self.times[said.number - 1]
            scheme = runge_kutta(c.A, c.B[0], times)
            return [_Row(f"order of part {said.number}", said.order, scheme)]
        if said.claim == DENSE_ORDER.key:
            scheme = runge_kutta(m.A, m.B[0], m.abscissae_given)
            scheme = replace(scheme, dense=m.dense, autonomous=None)
            return [_Row("order of the dense output", said.order, scheme)]
        k = said.number
        row = m.embedded[k - 1]
        weights = [B[0] for B in row.solution(main)]
        if said.claim == EMBEDDED_ORDER.key:
            return [
                _Row(f"order of {f'{what} of ' if what else ''}embedded row {k}", said.order, x)
                for what, x in self.schemes(weights)
            ]
        assert said.claim == EMBEDDED_DIFFERENCE.key
        parts = [f"{what} of " if what else "" for what, _ in self.schemes(main)]
        sums = zip(parts, main, weights, strict=False)  # of additive methods the first part
        return [_difference(f"{what}row {k}", b, w) for what, b, w in sums]

    def ranged(self, said: Said) -> Callable[[str], Finding]:
        """Judge an order of a method that carries several values by its proved bounds."""
        claim = ORDER.key if said.claim == ORDER.key else said.claim
        if self.kind == "nystrom" and claim == ORDER.key:
            claim = NYSTROM_ORDER.key
        kernel = facts_of(self.method).nominal.kernel
        row = f"embedded row {said.number}"
        if said.number:
            kernel, claim = list(kernel.row_kernels)[said.number - 1][1], kernel.row_claim
        found = kernel.range(claim)
        refuted = None if found.upper is None else found.upper + 1
        reached = Reach(found.lower, found.sizes, ("",) * len(found.sizes), refuted, found.exact)
        more = f"the order is {found.lower}" if found.lower > said.order else found.sentence
        judged = reaches(reached, said.order, more)
        title = f"order of {row}" if said.number else said.claim
        return lambda name: judged.finding(name, title, said.order)

    def remark(self, said: Said, row: _Row) -> str:
        """Say which order the decimals have as they are written."""
        (same,) = [x for x in self.rows(said) if isinstance(x, _Row) and x.claim == row.claim]
        number, near = meant(self.method) or ("", "")
        hint = f'; where {near} is meant, write "{near}" in place of {number}' if near else ""
        return _as_written(same) + hint


def _as_written(row: _Row) -> str:
    """Return the order of decimals taken as exact numbers, with the tree that fails."""
    found = reach(row.scheme, min(row.declared, _LITERAL), stop=0.0)
    if found.refuted is None:
        return f"the decimals as written have order {found.proved} or more"
    n = found.refuted
    tree, size = found.first[n - 1], found.sizes[n - 1]
    return (
        f"the decimals as written have order {n - 1} (tree {tree} has residual {_shown(size, 2)})"
    )


def _shown(size: float, digits: int = 3) -> str:
    """Return a size other than zero, which beyond the range of doubles is infinite, or zero."""
    if not size:
        return "below 1e-308"
    return f"{size:.{digits}g}" if isfinite(size) else "above 1e308"


def _difference(row: str, b: Vector, weights: Vector) -> Callable[[str], Finding]:
    total = sum((x - y for x, y in zip(b, weights, strict=True)), Exact(0))
    said = (
        f"b and the row differ in sum by {_shown(total.magnitude())}" if total.magnitude() else ""
    )
    return lambda name: vanishing(total, said).finding(name, f"error weights of {row} sum to", 0)


def _looked(scheme: Scheme, declared: int) -> Reach:
    """Return what the conditions of a scheme say through the order declared, and a little beyond.

    Trees with leaves for t are looked at through order 8. Where c is A 1 but for rounding, those
    of ``y' = f(y)`` follow beyond: nothing is proved by them, a condition that fails does refute.
    """
    found = _reached(scheme, declared)
    plain, n = scheme.autonomous, len(found.sizes)
    if plain is None or declared <= n or n < LARGEST[2] or found.size(n) > ROUNDING:
        return found
    beyond = _reached(plain, declared)
    return Reach(
        found.proved,
        found.sizes + beyond.sizes[n:],
        found.trees + beyond.trees[n:],
        beyond.refuted if found.refuted is None else found.refuted,
        found.exact,
        found.first + beyond.first[n:],
    )


def _reached(scheme: Scheme, declared: int) -> Reach:
    """Take exact numbers until the first condition fails, then balls: only sizes count."""
    exact = scheme.is_exact
    found = reach(scheme, declared + 2, stop=0.0 if exact else 1.0)
    if not exact or found.refuted is None:
        return further(found, scheme, declared)
    n, scheme = len(found.sizes), scheme.in_balls()
    beyond = further(reach(scheme, declared + 2, stop=1.0), scheme, declared)
    return replace(
        found,
        sizes=found.sizes + beyond.sizes[n:],
        trees=found.trees + beyond.trees[n:],
        first=found.first + beyond.first[n:],
    )


def _judged(row: _Row, name: str, digits: int | None, correction: Callable[[], str]) -> Finding:
    """Return the verdict on an order that is said to be reached."""
    found = _looked(row.scheme, row.declared)
    looked = len(found.sizes)
    parts: list[str] = []
    if found.proved >= row.declared:
        if found.proved == LARGEST.get(len(row.scheme.palette), 4):
            parts = [f"trees of order {found.proved} or less were looked at"]
        elif found.proved > row.declared:
            parts = [f"the order is {found.proved}"]
        parts += [row.remark]
    elif found.refuted is not None and found.refuted <= row.declared:
        n = found.refuted
        tree, size = found.first[n - 1], found.sizes[n - 1]
        parts = [f"tree {tree} of order {n} has residual {_shown(size)}", found.staircase(),
                 row.remark, correction()]  # fmt: skip
    elif looked < row.declared:
        parts = [f"trees of order {looked} or less were looked at, and no condition fails"]
    else:
        size = found.size(row.declared)
        within = f"no condition fails within the {digits} digits"
        parts = [
            f"order {row.declared} to {rounded_up(Fraction(repr(size)))}: {within}",
            row.remark,
        ]
    reason = "; ".join(x for x in parts if x)
    return reaches(found, row.declared, reason).finding(name, row.claim, row.declared)
