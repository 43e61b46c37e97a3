"""Generated source for the values carried: x = V y, the increments of a step, the new values.

A value is kept as y + e, e its rounding residual (compensated summation). Within a step it is
x + u, u holding e and the increments so far, so that increments are added to each other before
they meet the value. Rows of V that are a signed unit vector cost nothing: they rename. Sums of
several values lose no bits to rounding either (Knuth's TwoSum).
"""

from __future__ import annotations

from collections.abc import Sequence

from .emit import Target
from .forms import Row

Term = tuple[float, str]


def linear(terms: Sequence[Term]) -> str:
    """Return the source of a linear combination: zeros dropped, ones not multiplied."""
    text = ""
    for factor, name in terms:
        if factor == 0.0:
            continue
        sign = "-" if factor < 0 else "+"
        body = name if abs(factor) == 1.0 else f"{abs(factor)!r}*{name}"
        if not text:
            text = body if sign == "+" else f"-{body}"
        else:
            text += f" {sign} {body}"
    return text or "0.0"


def balanced(terms: Sequence[Term]) -> str:
    """Return the same summed by halves: what is computed last is waited for by fewer additions."""
    terms = [term for term in terms if term[0]]
    if len(terms) < 4:
        return linear(terms)
    half = len(terms) // 2
    first, second = terms[:half], terms[half:]
    sign = -1.0 if second[0][0] < 0 else 1.0
    other = balanced([(sign * factor, name) for factor, name in second])
    return f"({balanced(first)}) {'-' if sign < 0 else '+'} ({other})"


def differences(terms: Sequence[Term]) -> list[Term]:
    """Return terms with neighbours of opposite factors put together: a x - a y is a (x - y)."""
    out: list[Term] = []
    for factor, name in terms:
        if out and factor and out[-1][0] == -factor and not out[-1][1].startswith("("):
            out[-1] = (out[-1][0], f"({out[-1][1]} - {name})")
        else:
            out.append((factor, name))
    return out


class Values:
    """The values of one side of a method within the step that is being written.

    Parameters
    ----------
    target : Target
        Where statements go.
    V : tuple[Row, ...]
        (r, r).
    R : tuple[Row, ...]
        (r, n), the update coefficients.
    residue : tuple[Row, ...]
        (r, n), what their rounding lost.
    large : Sequence[bool]
        Which values are multiples of the solution.
    part : tuple[int, int]
        Components of the state that these values are.
    running : bool
        Whether increments are added as they come, to V y.
    kept : Sequence[bool]
        Whether rounding errors are kept, of each.
    ahead : bool
        Whether small values are also kept together with the increments so far, so that a stage
        waits for one sum less; an operation more for each increment.
    """

    def __init__(
        self, target: Target, V: tuple[Row, ...], R: tuple[Row, ...], residue: tuple[Row, ...],
        large: Sequence[bool], part: tuple[int, int], *, running: bool,
        kept: Sequence[bool], ahead: bool = False,
    ) -> None:  # fmt: skip
        self.t, self.V, self.R, self.residue = target, V, R, residue
        self.large, self.part = large, part
        self.running, self.ahead = running, ahead
        self.kept = kept
        self.x: list[Term] = []
        self.u: list[Term | None] = []
        self.grown: set[int] = set()

    @property
    def r(self) -> int:
        """Number of values."""
        return len(self.V)

    def begin(self) -> None:
        """Write the values that stages read: V y, or y itself where increments are added last."""
        self.grown.clear()
        if self.running:
            self.shift()
            return
        self.x = [(1.0, f"@y{k}") for k in range(self.r)]
        self.u = [(1.0, f"@e{k}") if kept else None for k, kept in enumerate(self.kept)]

    def shift(self) -> None:
        """Write x = V y and u = V e."""
        self.x, self.u, lines = [], [], []
        for k, row in enumerate(self.V):
            terms = [(factor, f"@y{j}") for j, factor in enumerate(row) if factor]
            errors = [(factor, f"@e{j}") for j, factor in enumerate(row) if factor]
            if len(terms) == 1 and abs(terms[0][0]) == 1.0:
                self.x.append(terms[0])
                self.u.append(errors[0] if self.kept[k] else None)
                continue
            self.x.append((1.0, f"@x{k}"))
            self.u.append((1.0, f"@u{k}") if self.kept[k] else None)
            if self.kept[k] and all(abs(factor) == 1.0 for factor, _ in terms) and terms:
                lines += _two_sums(f"@x{k}", f"@u{k}", terms, linear(errors))
                continue
            lines.append(f"@x{k} = {linear(terms)}")
            if self.kept[k]:
                lines.append(f"@u{k} = {linear(errors)}")
        if lines:
            self.t.vec(lines, self.part)

    def read(self, factors: Row, *, alone: bool = False) -> tuple[list[Term], list[Term]]:
        """Return terms of ``factors . values`` of a stage: multiples of the solution, small terms.

        ``alone`` says that no increments are added to them. The rounding error of a value without
        increments is then left out: value and error add up to the value, and the next step would
        wait for the error.
        """
        big: list[Term] = []
        small: list[Term] = []
        for k, factor in enumerate(factors):
            sign, name = self.x[k]
            rest = self.u[k]
            if self.large[k]:
                big.append((factor * sign, name))
                if rest is not None and (k in self.grown or not alone):
                    small.append((factor * rest[0], rest[1]))
            elif rest is None or k not in self.grown:
                # e of a small value is below the rounding of the sum it enters
                small.append((factor * sign, name))
            elif self.ahead:
                small.append((factor, f"@d{k}"))
            else:
                small.append((factor, f"({linear([self.x[k], rest])})"))
        return big, small

    def adding(self, column: int, name: str) -> list[str]:
        """Return statements of :meth:`add`."""
        lines = []
        for k, row in enumerate(self.R):
            if not row[column]:
                continue
            rest = self.u[k]
            terms = [(row[column], name)]
            lines.append(f"@u{k} = {linear(terms if rest is None else [rest, *terms])}")
            if self.ahead and not self.large[k]:
                # value and increments in one, so that a stage need not wait for both sums
                value = (1.0, f"@d{k}") if k in self.grown else self.x[k]
                lines.append(f"@d{k} = {linear([value, *terms])}")
            self.u[k] = (1.0, f"@u{k}")
            self.grown.add(k)
        return lines

    def add(self, column: int, name: str) -> None:
        """Write the running forms: u += R L as soon as L is known."""
        lines = self.adding(column, name)
        if lines:
            self.t.vec(lines, self.part)

    def finish(self, names: Sequence[str]) -> None:
        """Write the new values in n{k} and, compensated, their rounding errors in r{k}."""
        if not self.running:
            self.shift()
        self.t.vec(self.finishing(names), self.part)

    def finishing(self, names: Sequence[str]) -> list[str]:
        """Return statements of :meth:`finish`, once the values that the stages read are there."""
        lines = []
        for k, row in enumerate(self.R):
            rest = self.u[k]
            if not self.running:
                terms = list(zip(row, names, strict=True))
                if self.kept[k]:
                    terms = list(zip(self.residue[k], names, strict=True)) + terms
                increments = linear(terms)
                if increments != "0.0":
                    kept = "" if rest is None else f"{linear([rest])} + "
                    lines.append(f"@u{k} = {kept}({increments})")
                    rest = (1.0, f"@u{k}")
            sign, value = self.x[k]
            if rest is None:
                lines.append(f"@n{k} = {linear([self.x[k]])}")
                continue
            lines.append(f"@n{k} = {linear([self.x[k], rest])}")
            if self.kept[k]:
                # Fast2Sum: where |u| > |x| the error kept is itself rounded, which is below the
                # round-off of one step; TwoSum would lengthen the chain from step to step
                lines.append(
                    f"@r{k} = {linear([rest])} - ({linear([(1.0, f'@n{k}'), (-sign, value)])})"
                )
        return lines

    def new(self, k: int, increments: str) -> list[str]:
        """Return statements for new value k, the increments given as source.

        They follow :meth:`shift`.
        """
        (sign, value), rest = self.x[k], self.u[k]
        kept = "" if rest is None else linear([rest])
        total = " + ".join(x for x in (kept, increments) if x) or "0.0"
        lines = [f"@u{k} = {total}", f"@n{k} = {linear([self.x[k]])} + @u{k}"]
        if self.kept[k]:
            lines.append(f"@r{k} = @u{k} - ({linear([(1.0, f'@n{k}'), (-sign, value)])})")
        return lines

    def coming(self) -> str:
        """Write the sum of the new values of running forms, before they are in n{k}."""
        terms = zip(self.x, self.u, strict=True)
        return linear([term for pair in terms for term in pair if term is not None])

    def check(self, name: str) -> None:
        """Assign to ``name`` a sum that is a number only if every new value is."""
        # a value that is another one of the step before, with nothing added and no error kept, was
        # checked there; a step that only renames its values has them all checked
        every = range(self.r)
        new = [k for k in every if self.kept[k] or any(self.R[k]) or self.x[k][1] == f"@x{k}"]
        names = [f"@n{k}" for k in new or every]
        total = " + ".join(names)
        self.t.total(name, f"({total})" if len(names) > 1 else total, self.part)

    def pairs(self) -> list[tuple[str, str]]:
        """Return what becomes what when the step is good."""
        pairs = [(f"@y{k}", f"@n{k}") for k in range(self.r)]
        return pairs + [(f"@e{k}", f"@r{k}") for k in range(self.r) if self.kept[k]]


def _two_sums(value: str, rest: str, terms: list[Term], error: str) -> list[str]:
    """Add the terms one by one, each rounding error going to ``rest`` (Knuth's TwoSum)."""
    lines = [f"held = {linear(terms[:1])}", f"lost = {error}"]
    for term in terms[1:]:
        lines += [
            f"more = {linear([term])}",
            "both = held + more",
            "share = both - held",
            "lost = lost + ((held - (both - share)) + (more - share))",
            "held = both",
        ]
    return [*lines, f"{value} = held", f"{rest} = lost"]
