"""Watch the parasitic part of a run with explicit multistep formulas: free, from its solutions.

A parasitic part of the solution is a sum of ``zeta^n a`` over the eigenvalues zeta of V but 1, with
a that changes slowly. Among the solutions of :data:`WINDOW` successive steps it is what no
polynomial describes: each half of the window is fitted by polynomials of a degree below d and the
powers of its roots, and the amplitude of a root is the least one over several d. A small d leaves
parts of the orbit in the amplitudes, a large d amplifies rounding, so that every d gives a bound.

The scale is what the method itself leaves over, the p-th difference of the polynomials times the
error constant C of ``U (z - V)^-1 B = (1 + C x^p + ..)/x``, z = exp(x). Both are displacements of
the solution, by which the energy is wrong in proportion.

Before a run the matrix of a step on the system linearised at the start says whether h is too large:
where roots of the two halves meet, or one that was inside reaches the unit circle, eigenvalues
leave it at once and not in proportion to h, as a solution or a parasitic part that grows at first
order does.

References
----------
    Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), section XV.5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..catalogue.claims import ORDER
from ..exact import linalg
from ..exact.linalg import Vector
from ..method import Component, Method
from ..method.preconsistency import output
from ..problems.formula import Formula
from ..problems.model import Problem
from .forms import explicit_after_velocity, same_point

#: Steps of a window.
WINDOW = 96
#: Steps between two windows of a long run at most: one part in 340 of the steps is looked at.
MOST_BETWEEN = 2**15
#: How often the truncation error the parasitic part is when a notice is given, and how often its
#: size in the first window where the energy decides.
FACTOR = 10.0
#: With a Hamiltonian: growth of the energy error from that of the first steps at which a notice is
#: given, how many these are, and how many solutions of a window it is computed of.
_ENERGY, _EARLY, _SAMPLES = 20.0, 3 * WINDOW, 8
#: The growth that suffices where the parasitic part is larger than the truncation error, too.
_ENERGY_TOO = 8.0
#: The part of the truncation error that the parasitic part then has to be.
_VISIBLE = 0.01
#: The part of the solution at which the parasitic part is reported whatever the energy does.
_OF_SOLUTION = 0.1
#: The error of the energy, small at first, that is reported whatever the parasitic part is: one
#: that had grown may have been renewed away.
_OF_ENERGY = 0.1
#: Numbers of coefficients of the polynomials.
_SIZES = range(12, 32, 2)
#: Rounding in the amplitude of a root is at most one over this; sizes that amplify it more are out.
_SEPARATE = 1e-3
#: Modulus of a root below which a parasitic part is gone in a few steps.
_LEAST = 0.5
#: x at which the error constant is read off: the terms dropped and rounding are below a tenth.
_SMALL = 0.25
#: The part of h at which growth is of first order; so much a step an eigenvalue may be off.
_PART, _OFF = 64, 2e-6
#: Most rows of the matrix of a step of which eigenvalues are taken.
_MOST_ROWS = 200
#: Units in the last place by which solutions are rounded, and by which rounding in n steps may
#: have moved them, over sqrt(n).
_ROUNDING, _WALK = 8.0, 0.25
_EPSILON, _TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class _Fit:
    """Maps from the window (WINDOW, d) of one half."""

    amplitudes: np.ndarray  #: (sizes, k, 2, WINDOW): cosine and sine part at each root.
    allowed: np.ndarray  #: (sizes, k), whether the root is separate from the polynomials.
    rest: np.ndarray  #: (sizes, WINDOW, WINDOW): what neither polynomials nor roots describe.
    truncation: np.ndarray  #: (rows, WINDOW): C times the p-th differences.


@lru_cache(maxsize=32)
def _fit(roots: tuple[float, ...], order: int, constant: float) -> _Fit:
    """Return the maps for roots exp(i angle), 0 < angle <= pi."""
    n, angles = np.arange(WINDOW), np.array(roots)
    x = (2 * n + 1) / WINDOW - 1
    waves = np.concatenate([np.cos(np.outer(n, angles)), np.sin(np.outer(n, angles))], axis=1)
    k = len(angles)
    waves[:, k:][:, angles > math.pi - 1e-9] = 0.0
    parts, allowed, rests, truncation = [], [], [], np.zeros((1, WINDOW))
    for size in _SIZES:
        basis = np.polynomial.legendre.legvander(x, size - 1)
        found = np.linalg.pinv(np.concatenate([basis, waves], axis=1), rcond=1e-9)
        part = found[size:].reshape(2, k, WINDOW).transpose(1, 0, 2)
        separate = np.linalg.norm(part, axis=(1, 2)) * math.sqrt(WINDOW) * _SEPARATE < 1
        parts.append(part)
        allowed.append(separate)
        rests.append(np.eye(WINDOW) - basis @ found[:size] - waves @ found[size:])
        if separate.all() or size == _SIZES[0]:
            smooth = basis @ found[:size]
            truncation = constant * np.diff(smooth, n=order, axis=0)
            truncation = truncation[WINDOW // 4 : -WINDOW // 4]
    return _Fit(np.array(parts), np.array(allowed), np.array(rests), truncation)


def _half(m: Component, times: Vector, order: int) -> _Fit:
    """Return the maps of one half of a pair, whose stages are the solution at some times."""
    B, V = (np.array([[float(x) for x in row] for row in M]) for M in (m.B, m.V))
    found = np.linalg.eigvals(V)
    roots = tuple(sorted({float(a) for a in np.angle(found[abs(found) > _LEAST]) if a > 1e-6}))
    slopes = B @ np.exp([_SMALL * float(c) for c in times])
    values = np.linalg.solve(math.exp(_SMALL) * np.eye(len(V)) - V, slopes)
    transfer = np.array([float(x) for x in output(m)]) @ values
    constant = abs(transfer - 1 / _SMALL) / _SMALL ** (order - 1)
    return _fit(roots, order, float(constant))


@lru_cache(maxsize=32)
def _fits(method: Method) -> tuple[_Fit, ...]:
    """Return the maps of the halves of a method, made once for all its runs."""
    order = method.claims[ORDER.key]
    assert isinstance(order, int)
    return tuple(_half(c, method.times[0], order) for c in method.carriers)


@lru_cache(maxsize=32)
def _formula(method: Method) -> bool:
    """Return whether a method is one explicit multistep formula, with roots but 0 and 1."""
    (m,) = method.carriers
    if not method.is_explicit or m.U != (output(m),):
        return False
    roots = np.linalg.eigvals([[float(x) for x in row] for row in m.V])
    return bool((np.abs(np.angle(roots)[np.abs(roots) > _LEAST]) > 1e-6).any())


def watched(method: Method, problem: Problem) -> bool:
    """Return whether a run is watched: multistep formulas, evaluated at the solution itself."""
    if not isinstance(method.claims.get(ORDER.key), int) or method.carried == 1:
        return False
    if method.parts == 1:
        return problem.hamiltonian is not None and _formula(method)
    if not method.shared or problem.separable:
        return False
    if method.is_explicit:
        return all(len(c.U) == 1 for c in method.carriers)
    return same_point(method) and explicit_after_velocity(method) and problem.semi_separable


def over_all(*parts: Sequence[Any]) -> tuple[np.ndarray, ...]:
    """Return A, U, B and V, block-diagonal, from those of each part of the state."""
    blocks = (linalg.block_diagonal(*each) for each in zip(*parts, strict=True))
    return tuple(np.array(block, dtype=float) for block in blocks)


@lru_cache(maxsize=32)
def _blocks(method: Method) -> tuple[np.ndarray, ...]:
    return over_all(*((c.A, c.U, c.B, c.V) for c in method.carriers))


def step_matrix(blocks: Sequence[np.ndarray], J: np.ndarray, h: float, parts: int) -> np.ndarray:
    """Return the matrix of a step on y' = J y of a method whose parts share their stages.

    ``blocks`` has A, U, B and V of all parts, see :func:`over_all`.
    """
    n, m, s = parts, len(J) // parts, len(blocks[0]) // parts
    A, U, B, V = (np.einsum("ij,kl->ikjl", M, np.eye(m)).reshape(len(M) * m, -1) for M in blocks)
    F = h * np.einsum("ij,akbl->aikbjl", np.eye(s), J.reshape(n, m, n, m)).reshape(n * s * m, -1)
    return V + B @ F @ np.linalg.solve(np.eye(len(F)) - A @ F, U)


def stable_up_to(method: Method, J: np.ndarray, h: float) -> float | None:
    """Return the h up to which a method is stable on y' = J y, where it is not at ``h``.

    ``None`` where it is, and where it grows in proportion to h, as the solution itself may.
    """

    def growth(part: int) -> float:
        step = step_matrix(_blocks(method), J, h * part / _PART, method.parts)
        return max(float(np.abs(np.linalg.eigvals(step)).max()) - 1, _OFF)

    whole = growth(_PART)
    if whole <= 4 * _PART * _OFF or whole <= 4 * _PART * (first := growth(1)):
        return None
    beyond = next(k for k in range(2, _PART + 1) if growth(k) > 4 * k * first)
    return h * (beyond - 1) / _PART


@lru_cache(maxsize=256)
def too_large(method: Method, problem: Problem, h: float) -> tuple[str, ...]:
    """Say up to which h a method is stable on the system linearised at the start, if not at h."""
    rows = problem.dimension // method.parts * sum(len(c.V) for c in method.carriers)
    if not isinstance(problem.f, Formula) or rows > _MOST_ROWS:
        return ()
    J = np.asarray(problem.jacobian(problem.t_span[0], np.array(problem.y0, dtype=float)))
    try:
        bound = stable_up_to(method, J, h)
    except np.linalg.LinAlgError:  # derivatives that are not finite, or near the end of the range
        return ()
    if bound is None:
        return ()
    limit = (
        f"{bound:.3g}, up to which {method.name} is stable on the system linearised at the start"
    )
    return (f"h = {h:g} is beyond {limit}",)


def _unit(steps: int) -> float:
    """Return what rounding may have moved a solution by, relative."""
    return _EPSILON * (_ROUNDING + _WALK * math.sqrt(steps))


def _largest(rows: np.ndarray) -> float:
    """Return the largest norm of a row."""
    return math.sqrt(np.square(rows).sum(axis=1).max())


def windows(steps: int, renew: int) -> list[int]:
    """Return the steps at which windows begin: ever farther apart, each within one renewal."""
    last = steps - WINDOW
    if last < 0 or 0 < renew < WINDOW:
        return []
    if renew:  # the last window may not go over a renewal either
        last -= max(0, last % renew - (renew - WINDOW))
    found = [0]
    while True:
        b = min(2 * found[-1] + WINDOW, found[-1] + MOST_BETWEEN)
        if renew:  # at the end of the steps after a renewal, where the parasitic part is largest
            b += renew - WINDOW - b % renew
            if b < found[-1] + WINDOW:
                b += renew
        if b >= last:
            return found + [last] * (last >= found[-1] + WINDOW)
        found.append(b)


class Watch:
    """The parasitic part and the truncation error over the windows of one run."""

    def __init__(self, method: Method, problem: Problem) -> None:
        self.fits = _fits(method)
        self.scale = np.zeros(len(self.fits))
        self.best = [0] * len(self.fits)  #: Number of the degree that was the best one last.
        self.first: np.ndarray | None = None  #: The parasitic part of the first window.
        self.hamiltonian, self.y0 = problem.hamiltonian, np.array(problem.y0, dtype=float)
        self.canonical = problem.canonical
        self.page = "nonseparable" if method.is_explicit else "velocities"
        self.growing = method.parts > 1  #: Whether parasitic parts can grow at any step size.
        self.energy_error = 0.0  #: Of the first steps.
        self.alarm = 0.0  #: The error of the energy that was the last reason to look.

    def parasitic(self, halves: Sequence[np.ndarray], *, least: bool = True) -> np.ndarray:
        """Return the size (2,) of the parasitic part in each half (WINDOW, d) of a window.

        Not the ``least`` one over all degrees, but of one that was the best: a bound.
        """
        found = []
        for n, (fit, y) in enumerate(zip(self.fits, halves, strict=True)):
            some = slice(None) if least else slice(self.best[n], self.best[n] + 1)
            sizes = np.sqrt(np.square(fit.amplitudes[some] @ y).sum(axis=(2, 3)))
            sizes[~fit.allowed[some]] = np.inf
            rest = np.sqrt(np.square(fit.rest[some] @ y).sum(axis=(1, 2)) * (2 / WINDOW))
            if least:
                self.best[n] = int(np.maximum(sizes.max(axis=1), rest).argmin())
            found.append(max(float(sizes.min(axis=0).max()), float(rest.min())))
        return np.array(found)

    def _above(self, halves: Sequence[np.ndarray], least: np.ndarray) -> np.ndarray | None:
        """Return the parasitic part, ``None`` where none of it is above ``least``."""
        if not (self.parasitic(halves, least=False) > least).any():  # a bound decides for less
            return None
        found = self.parasitic(halves)
        return found if (found > least).any() else None

    def _errors_of_energy(self, solutions: np.ndarray) -> np.ndarray:
        """Return the errors (n,) of the energy at solutions (n, d), relative."""
        given, energy = np.concatenate([self.y0[None], solutions]), self.hamiltonian
        if isinstance(energy, Formula):
            found = energy(given.T) * np.ones(len(given))  # also of a constant
        else:
            found = np.array([float(energy(y)) for y in given])
        return np.abs(found[1:] - found[0]) / max(abs(found[0]), _TINY)

    def large(self, solutions: np.ndarray, step: int) -> bool:
        """Return whether the parasitic part is large against the truncation error, or energy lost.

        ``solutions`` (WINDOW, d) are those of successive steps, the last with number ``step``.
        """
        if not np.isfinite(solutions).all():
            return True
        halves = np.split(solutions, len(self.fits), axis=1)
        truncation = [
            _largest(fit.truncation @ y) for fit, y in zip(self.fits, halves, strict=True)
        ]
        size = np.array([_largest(y) for y in halves])
        unit = _unit(step)
        now = np.maximum(np.array(truncation), unit * size)
        if self.first is None:
            # what the start leaves is in the error from the beginning
            self.first = self.parasitic(halves)
            now = np.maximum(now, self.first)
        self.scale = np.maximum(self.scale, now)
        if self.hamiltonian is None:
            return self._above(halves, FACTOR * self.scale) is not None
        if step <= _EARLY:
            early = self._errors_of_energy(solutions[:: WINDOW // (4 * _SAMPLES)])
            self.energy_error = float(np.fmax.reduce(early, initial=self.energy_error))
            return False
        # at a close encounter the largest error is large for a moment, also of a sound orbit
        errors = self._errors_of_energy(solutions[:: WINDOW // _SAMPLES])
        error = float(np.median(errors))
        if error > _OF_ENERGY > _ENERGY * self.energy_error:
            return True
        enough = np.maximum(FACTOR * np.maximum(self.first, unit * size), _VISIBLE * self.scale)
        # the energy is not in every direction a measure
        whatever = np.maximum(enough, _OF_SOLUTION * size)
        known = max(self.energy_error, unit)
        least = enough if error > _ENERGY_TOO * known else whatever
        found = self._above(halves, least)
        if found is None or (found > whatever).any():
            return found is not None
        factor = _ENERGY_TOO if (found > FACTOR * self.scale).any() else _ENERGY
        return error > factor * known

    def alarming(self, solutions: np.ndarray, steps: Sequence[int]) -> list[int]:
        """Return at which solutions (n, d) the energy says that the steps before be looked at.

        So it does where its error has grown as much as :meth:`large` asks for at least, and has
        doubled since it last did. The numbers are those of the solutions.
        """
        found: list[int] = []
        if self.hamiltonian is None or not len(solutions):
            return found
        for k, error in enumerate(self._errors_of_energy(solutions)):
            least = _ENERGY_TOO * max(self.energy_error, _unit(steps[k]))
            if steps[k] > _EARLY and error > max(least, 2 * self.alarm):
                self.alarm = float(error)
                found.append(k)
        return found

    def notice(self, time: float, step: int) -> str:
        """Return the sentence on what was found at a step."""
        shear = "gauge='auto', " if self.canonical else ""
        cures = f"{shear}renew=1000, " if self.growing else ""
        return (
            f"from t = {time:.6g} (step {step}) the parasitic part of the solution is large "
            f"against the truncation error, or the energy wrong, and the orbit is being lost; give "
            f"{cures}a smaller h, or an implicit method such as gauss-4, see "
            f"docs/{self.page}.md"
        )
