"""Name what was read: the method of the catalogue it equals, closed forms, the analysis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import isqrt, sqrt
from typing import Any

import numpy as np

from ..catalogue.lookup import load, names
from ..errors import DataError, ExactnessError, UsageError, did_you_mean
from ..exact import Ball
from ..exact.expression import parse
from ..method import GLM, Method, PartitionedGLM
from ..method.preconsistency import stage_times
from ..method.rounding import float_arrays
from ..prove.analysis import analyze
from .probe import read
from .readings import Half, Reading, clean, needed, without_idle
from .subject import Subject

FORMAT = "glmref-probe-1"

#: Two methods are the same when their coefficients, in one order of the stages, differ by less.
SAME = 1e-10
#: Digits after the point that a number read from doubles is given where it has no closed form.
DIGITS = 13
_DENOMINATOR, _ROOTS = 20_000, (2, 3, 5, 6, 7, 10, 15, 21, 30, 35)
#: Closed forms p + q sqrt(n): denominators of p and q, and the factors q that are tried.
_LARGEST_PART = 60
_FACTORS = np.array(
    [
        sign * a / b
        for b in (*range(1, 13), 15, 18, 20, 24, 30, 36, 48, 60)
        for a in range(1, 13)
        for sign in (1, -1)
    ]
)


@dataclass(frozen=True)
class Match:
    """A method of the catalogue with the coefficients that were read."""

    name: str  #: Its name.
    difference: float  #: Largest difference of A and of U V^k B, k < r.
    same_basis: bool  #: Whether U, B and V agree as well, without a change of values.
    #: Abscissae of the method where f is evaluated at others, else empty: such a code is the method
    #: on autonomous systems only.
    times: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Probe:
    """Everything that is known of one integrator."""

    method: str  #: What the adapter calls it.
    reading: Reading | None  #: The coefficients, or ``None`` where they could not be read.
    matches: tuple[Match, ...] = ()  #: Methods of the catalogue it equals, nearest first.
    #: Whether every coefficient has a short closed form; then ``analysis`` is exact for these
    #: forms.
    recognised: bool = False
    analysis: Any = None  #: The record of :func:`glmref.analyze`, or ``None``.
    notes: tuple[str, ...] = ()  #: What could not be seen, and why.

    def as_json(self) -> dict[str, Any]:
        """Return the record as JSON-ready values."""
        row: dict[str, Any] = {"method": self.method, "read": self.reading is not None}
        if self.reading is not None:
            row |= {name: matrix.tolist() for name, matrix in self.reading.blocks.items()}
            c = self.reading.c
            row |= {
                "c": None if c is None else c.tolist(),
                "evaluations": self.reading.evaluations,
                "unexplained": self.reading.unexplained,
            }
        row["matches"] = [
            {
                "name": m.name,
                "difference": m.difference,
                "same_basis": m.same_basis,
                "same_times": not m.times,
            }
            for m in self.matches
        ]
        row["recognised"] = self.recognised
        row["analysis"] = None if self.analysis is None else self.analysis.as_json()
        row["notes"] = list(self.notes)
        return row

    @property
    def wrong_times(self) -> Match | None:
        """The nearest method it would be if f were evaluated at the right times, else ``None``."""
        if not self.matches or not all(m.times for m in self.matches):
            return None
        return self.matches[0]


def identify(subject: Subject, method: str | None = None) -> list[Probe]:
    """Read one method of an adapter, or all of them, and say what they are.

    Raises
    ------
    UsageError
        When the adapter has no such method.
    """
    if method is not None and method not in subject.methods:
        raise UsageError(
            f"{subject.name} has no method {method!r}, only {', '.join(subject.methods)}"
            f"{did_you_mean(method, subject.methods, '; ')}"
        )
    return [_identify(subject, name) for name in ([method] if method else subject.methods)]


def values_carried(subject: Subject, method: str) -> int:
    """Return the number of values r: that of the data file, or what the adapter says, or one."""
    claims = subject.methods[method]
    if claims:
        return int(claims.get("values", 1))
    return load(method).carried


def _identify(subject: Subject, name: str) -> Probe:
    try:
        reading = read(subject, name, values_carried(subject, name))
    except UsageError as error:
        return Probe(name, None, notes=(str(error),))
    found = tuple(matches(reading))
    notes = list(reading.notes)
    if found:
        said = any("at times other than" in note for note in notes)
        if all(m.times for m in found) and not said:
            notes.append(
                f"f is evaluated at times other than t + c_i h with the c of {found[0].name}"
            )
        return Probe(
            name, reading, found, True, _analysis(load(found[0].name), notes), tuple(notes)
        )
    method, recognised = as_method(reading, name)
    analysis = _analysis(method, notes)
    return Probe(name, reading, (), recognised, analysis, tuple(notes))


def _analysis(method: Method, notes: list[str]) -> Any:
    try:
        return analyze(method)
    except (ExactnessError, DataError) as error:
        notes.append(f"the coefficients could not be analyzed: {error}")
        return None


# --- closed forms -------------------------------------------------------------------------------


def recognised(x: float) -> str | None:
    """Return closed form of a number: a fraction, or p + q sqrt(n) with small p and q, or ``None``.

    The forms tried have some 1e8 values in the unit interval and a hit must be within 4e-16, so
    that chance makes one in a million numbers look like a closed form. It is a guess, and is called
    so.
    """
    allowed = 4e-16 * max(1.0, abs(x))
    near = Fraction(x).limit_denominator(_DENOMINATOR)
    if abs(float(near) - x) <= allowed:
        return str(near)
    wholes = np.arange(1, _LARGEST_PART + 1)
    for n in _ROOTS:
        rests = x - _FACTORS[:, None] * sqrt(n)
        gaps = np.abs(rests - np.round(rests * wholes) / wholes)
        for row, column in np.argwhere(gaps <= allowed):
            q = Fraction(float(_FACTORS[row])).limit_denominator(_LARGEST_PART)
            p = Fraction(round(float(rests[row, 0] * wholes[column])), int(wholes[column]))
            return _surd(p, q, n)
    return None


def _surd(p: Fraction, q: Fraction, n: int) -> str:
    assert isqrt(n) ** 2 != n
    term = f"{'-' if q < 0 else '+'}{abs(q)}*sqrt({n})"
    return term.lstrip("+") if p == 0 else f"{p}{term}"


def as_method(reading: Reading, name: str = "read") -> tuple[Method, bool]:
    """Make a method of what was read.

    Numbers with a closed form become exact, the others balls of :data:`DIGITS` digits.
    """
    complete = True

    def entry(x: float) -> Any:
        nonlocal complete
        text = recognised(float(x))
        if text is not None:
            return parse(text)
        complete = False
        return Ball.decimal(f"{x:.20f}", DIGITS)

    def matrix(values: np.ndarray) -> Any:
        return tuple(tuple(entry(x) for x in row) for row in values)

    blocks = {letter: matrix(values) for letter, values in reading.blocks.items()}
    if reading.single:
        return GLM(**blocks, name=name), complete
    return PartitionedGLM(**blocks, name=name, separable=True), complete


# --- the catalogue ------------------------------------------------------------------------------


def matches(reading: Reading) -> list[Match]:
    """Return methods of the catalogue that are this one up to order of stages and change of values.

    A change of values ``T y`` leaves A and ``U V^k B`` alone; both are compared to :data:`SAME`.
    Stages on which nothing depends are not compared: they cannot be seen.
    """
    found = [_match(reading, name, _arrays(name)) for name in names("methods")]
    known = [match for match in found if match is not None]
    return sorted(known, key=lambda m: (not m.same_basis, m.difference, m.name))


@cache
def _arrays(name: str) -> tuple[Half, ...]:
    """Return coefficients of a method as doubles, without stages on which nothing depends.

    Nothing of a method that is complex, or additive: right-hand sides that are summed are not told
    apart by a step.
    """
    method = load(name)
    if method.additive or not method.is_real:
        return ()
    halves = [[float_arrays(x)[0] for x in c.matrices] for c in method.components]
    left, _ = without_idle([(A, U, B, V) for A, U, B, V in halves])
    return tuple(left)


def _invariants(halves: Sequence[Half]) -> list[list[np.ndarray]]:
    """Return of each half A and ``U V^k B``, k <= r, which a change of values leaves alone."""
    found = []
    for A, U, B, V in halves:
        found.append([A])
        for _ in range(len(V) + 1):
            found[-1].append(U @ B)
            U = U @ V
    return found


def _match(reading: Reading, name: str, other: Sequence[Half]) -> Match | None:
    shapes = [[x.shape for half in halves for x in half] for halves in (reading.halves, other)]
    if shapes[0] != shapes[1]:
        return None
    mine, theirs = _invariants(reading.halves), _invariants(other)
    for orders in _orders(mine, theirs):
        turned = tuple(zip(orders, orders[::-1], strict=True))
        gap = max(
            np.abs(x - y[np.ix_(*rows)]).max(initial=0.0)
            for left, right, rows in zip(mine, theirs, turned, strict=True)
            for x, y in zip(left, right, strict=True)
        )
        if gap < SAME:
            same = all(
                np.abs(x - y).max(initial=0.0) < SAME
                for half, (_, U, B, V), (own, others) in zip(
                    reading.halves, other, turned, strict=True
                )
                for x, y in zip(half[1:], (U[own], B[:, others], V), strict=True)
            )
            return Match(name, float(gap), same, _other_times(reading, name, orders[0], same))
    return None


def _other_times(
    reading: Reading, name: str, order: Sequence[int], same_basis: bool
) -> tuple[float, ...]:
    """Return abscissae of a method, in the order of the reading, where those that were read differ.

    After a change of values the times are not compared: where the values carried belong to other
    times, so may the stages.
    """
    if reading.c is None or not (same_basis or reading.values == 1):
        return ()
    right = _abscissae(name)[list(order)]
    if np.abs(right - reading.c).max(initial=0.0) <= SAME:
        return ()
    return tuple(clean(right).tolist())


@cache
def _abscissae(name: str) -> np.ndarray:
    """Return the abscissae of a method as doubles, without stages on which nothing depends."""
    (block,) = load(name).components
    blocks = [float_arrays(m)[0] for m in (block.A, block.B)]
    c = np.array([complex(x).real for x in stage_times(block)])
    return c[needed(*blocks)]


def _orders(
    mine: Sequence[Sequence[np.ndarray]], theirs: Sequence[Sequence[np.ndarray]]
) -> Iterator[list[list[int]]]:
    """Return the orders of stages to try, of each half: as they are, then by what tells them apart.

    That is what does not depend on the order of the others: sums of rows and of columns.
    """
    yield [list(range(len(half[0]))) for half in mine]
    yield [
        _nearest(left, right)
        for left, right in zip(_signatures(mine), _signatures(theirs), strict=True)
    ]


def _nearest(left: np.ndarray, right: np.ndarray) -> list[int]:
    """Return for each row of ``left`` the number of the nearest row of ``right`` that is free."""
    order: list[int] = []
    for row in left:
        free = [j for j in range(len(right)) if j not in order]
        order.append(min(free, key=lambda j: float(np.abs(row - right[j]).max())))
    return order


def _signatures(halves: Sequence[Sequence[np.ndarray]]) -> list[np.ndarray]:
    """Return numbers of each stage of a half that do not depend on the order of the others."""
    found = []
    for half, other in zip(halves, halves[::-1], strict=True):
        columns = []
        for x, y in zip(half, other, strict=True):
            product = x @ y
            columns += [x.sum(axis=1), y.sum(axis=0), product.sum(axis=1), np.diag(product)]
        found.append(np.stack(columns, axis=1))
    return found
