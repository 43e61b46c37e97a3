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
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..catalogue.claims import ORDER
from ..exact import linalg
from ..exact.linalg import Vector
from ..method import Component, Method
from ..method.lasting import lasting
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
_ENERGY, EARLY, _SAMPLES = 20.0, 3 * WINDOW, 8
#: The growth that suffices where the parasitic part is larger than the truncation error, too.
_ENERGY_TOO = 8.0
#: The part of the truncation error that the parasitic part then has to be.
_VISIBLE = 0.01
#: The part of the solution at which the parasitic part is reported whatever the energy does.
_OF_SOLUTION = 0.1
#: The error of the energy that is reported whatever the parasitic part is, which may have been
#: renewed away: where it has grown so often, or is as large over what halving the state changes.
_OF_ENERGY, _GROWN = 0.1, 3.0
#: Of one formula, whose parasitic parts decay: the error of the energy below which nothing is lost,
#: over :data:`_ENERGY`, as a window need not resolve a close encounter, and the error that is
#: reported without a parasitic part, which has gone again, where it has grown so often.
_FLOOR, _ALONE = 1e-9, 1e-3
#: Numbers of coefficients of the polynomials.
_SIZES = range(12, 32, 2)
#: Rounding in the amplitude of a root is at most one over this; sizes that amplify it more are out.
_SEPARATE = 1e-3
#: x at which the error constant is read off: the terms dropped and rounding are below a tenth.
_SMALL = 0.25
#: The part of h at which growth is of first order; so much a step an eigenvalue may be off.
_PART, _OFF = 64, 2e-6
#: Most rows of the matrix of a step of which eigenvalues are taken.
_MOST_ROWS = 200
#: Units in the last place by which solutions are rounded, and by which rounding in n steps may
#: have moved them, over sqrt(n).
_ROUNDING, _WALK = 8.0, 0.25
#: Columns up to which a product of matrices is too small for threads, which wait for each other.
_COLUMNS = 16
_EPSILON, _TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class _Fit:
    """Maps from the window (WINDOW, d) of one half, for each number of coefficients.

    The truncation error, C times the p-th differences; at each root a cosine part, then a sine
    part; what neither polynomials nor roots describe. Rows of zeros stand for missing roots.
    """

    rows: np.ndarray  #: (sizes, all of these, WINDOW).
    ends: tuple[int, ...]  #: Where the first three of them end.
    refused: np.ndarray  #: (sizes, roots), infinite where a root is near the polynomials.


def _fit(roots: tuple[float, ...], most: int, order: int, constant: float) -> _Fit:
    """Return the maps for roots exp(i angle), 0 < angle <= pi, at ``most`` of a half."""
    n, angles = np.arange(WINDOW), np.array(roots)
    x = (2 * n + 1) / WINDOW - 1
    waves = np.concatenate([np.cos(np.outer(n, angles)), np.sin(np.outer(n, angles))], axis=1)
    k = len(angles)
    waves[:, k:][:, angles > math.pi - 1e-9] = 0.0
    truncation = np.zeros((WINDOW // 2 - order, WINDOW))
    rows = np.zeros((len(_SIZES), len(truncation) + 2 * most + WINDOW, WINDOW))
    ends = tuple(len(truncation) + part * most for part in range(3))
    refused = np.zeros((len(_SIZES), most))
    for size, row, near in zip(_SIZES, rows, refused, strict=True):
        basis = np.polynomial.legendre.legvander(x, size - 1)
        found = np.linalg.pinv(np.concatenate([basis, waves], axis=1), rcond=1e-9)
        cosine, sine = found[size:].reshape(2, k, WINDOW)
        row[ends[0] : ends[0] + k], row[ends[1] : ends[1] + k] = cosine, sine
        row[ends[2] :] = np.eye(WINDOW) - basis @ found[:size] - waves @ found[size:]
        norms = np.sqrt(np.square(cosine).sum(axis=1) + np.square(sine).sum(axis=1))
        near[:k][norms * math.sqrt(WINDOW) * _SEPARATE >= 1] = np.inf
        if not near.any() or size == _SIZES[0]:
            smooth = constant * np.diff(basis @ found[:size], n=order, axis=0)
            truncation = smooth[WINDOW // 4 : -WINDOW // 4]
    rows[:, : ends[0]] = truncation
    return _Fit(rows, ends, refused)


def _half(m: Component, times: Vector, order: int) -> tuple[tuple[float, ...], float]:
    """Return the roots and the error constant of a half, whose stages are the solution at times."""
    B, V = (np.array([[float(x) for x in row] for row in M]) for M in (m.B, m.V))
    roots = tuple(sorted({float(a) for a in np.angle(lasting(np.linalg.eigvals(V))) if a > 0}))
    slopes = B @ np.exp([_SMALL * float(c) for c in times])
    values = np.linalg.solve(math.exp(_SMALL) * np.eye(len(V)) - V, slopes)
    transfer = np.array([float(x) for x in output(m)]) @ values
    return roots, float(abs(transfer - 1 / _SMALL) / _SMALL ** (order - 1))


@lru_cache(maxsize=32)
def _fits(method: Method) -> tuple[_Fit, ...]:
    """Return the maps of the halves of a method, made once for all its runs."""
    order = method.claims[ORDER.key]
    assert isinstance(order, int)
    halves = [_half(c, method.times[0], order) for c in method.carriers]
    most = max(len(roots) for roots, _ in halves)
    return tuple(_fit(roots, most, order, constant) for roots, constant in halves)


@lru_cache(maxsize=64)
def _best(method: Method, *sizes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the maps (2, rows, WINDOW) of both halves with these sizes, and what is refused."""
    fits = list(zip(_fits(method), sizes, strict=True))
    refused = [fit.refused[n].max(initial=0.0) for fit, n in fits]
    return np.stack([fit.rows[n] for fit, n in fits]), np.array(refused)


@lru_cache(maxsize=32)
def _formula(method: Method) -> bool:
    """Return whether a method is one explicit multistep formula, with roots but 0 and 1."""
    (m,) = method.carriers
    if not method.is_explicit or m.U != (output(m),):
        return False
    return bool(lasting(np.linalg.eigvals([[float(x) for x in row] for row in m.V])))


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


def _others(method: Method, J: np.ndarray, h: float) -> float:
    """Return the largest eigenvalue of a step on y' = J y but those nearest to the solution's."""
    roots = np.linalg.eigvals(step_matrix(_blocks(method), J, h, method.parts))
    for z in h * np.linalg.eigvals(J):
        roots = np.delete(roots, np.abs(roots - np.exp(min(z.real, 700.0) + 1j * z.imag)).argmin())
    return float(np.abs(roots).max())


def stable_up_to(method: Method, J: np.ndarray, h: float) -> float | None:
    """Return the h up to which a method is stable on y' = J y, where it is not at ``h``.

    ``None`` where it is, and where it grows in proportion to h, as the solution itself may. Of one
    formula whose roots but 1 are inside the unit circle only these count.
    """
    if method.parts == 1 and _others(method, J, 0.0) < 1 - _OFF:
        fine = [_others(method, J, h * k / _PART) <= 1 + _OFF for k in range(1, _PART + 1)]
        return None if all(fine) else h * fine.index(False) / _PART

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


def _larger(some: list[float], others: list[float]) -> list[float]:
    return list(map(max, some, others))


def _above(found: list[float], least: list[float]) -> bool:
    """Return whether it is larger in one half at least."""
    return any(map(operator.gt, found, least))


class Watch:
    """The parasitic part and the truncation error over the windows of one run."""

    def __init__(self, method: Method, problem: Problem) -> None:
        self.method, self.fits = method, _fits(method)
        self.scale = [0.0] * len(self.fits)  #: The largest truncation error of each half.
        self.best = [0] * len(self.fits)  #: Number of the degree that was the best one last.
        self.first: list[float] = []  #: The parasitic part of the first window.
        self.hamiltonian, self.y0 = problem.conserved, np.array(problem.y0, dtype=float)
        self.canonical = problem.canonical
        self.page = "nonseparable" if method.is_explicit else "velocities"
        self.growing = method.parts > 1  #: Whether parasitic parts can grow at any step size.
        #: Of the first steps, and the median of the first window.
        self.energy_error, self.middle = 0.0, 0.0
        #: Of one formula, whether steps after the first ones were looked at: taken again where
        #: these were lost, the first ones may be, too.
        self.later = False
        self.energy_scale = self._energy_scale()
        self.alarm = 0.0  #: The error of the energy that was the last reason to look.
        #: The step at which the energy error had grown as the energy alone asks for, whatever
        #: floor a notice has, where it has not come back to that of the first steps since.
        self.grown: int | None = None

    def parasitic(self, halves: np.ndarray) -> list[float]:
        """Return the size of the parasitic part in both halves (2, WINDOW, m) of a window."""
        found = []
        for n, (fit, y) in enumerate(zip(self.fits, halves, strict=True)):
            squares = np.square(fit.rows @ y).sum(axis=2)
            first, second, third = fit.ends
            sizes = np.sqrt(squares[:, first:second] + squares[:, second:third]) + fit.refused
            rest = np.sqrt(squares[:, third:].sum(axis=1) * (2 / WINDOW))
            self.best[n] = int(np.maximum(sizes.max(axis=1), rest).argmin())
            found.append(max(float(sizes.min(axis=0).max()), float(rest.min())))
        return found

    def _sizes(self, halves: np.ndarray) -> np.ndarray:
        """Return truncation error, a bound of the parasitic part, and size: (3, w, 2) of w windows.

        The bound is the parasitic part by the degree that was the best one last. ``halves`` are
        (2, WINDOW, w, m).
        """
        rows, refused = _best(self.method, *self.best)
        columns, (n, _, *shape) = halves.reshape(len(halves), WINDOW, -1), halves.shape
        parts = [
            rows @ columns[..., k : k + _COLUMNS] for k in range(0, columns.shape[-1], _COLUMNS)
        ]
        found = np.concatenate(parts, axis=-1).reshape(n, -1, *shape)
        squares = np.einsum("njwd,njwd->jwn", found, found)
        first, second, third = self.fits[0].ends
        waves = (squares[first:second] + squares[second:third]).max(axis=0)
        bound = np.maximum(waves, squares[third:].sum(axis=0) * (2 / WINDOW)) + refused
        whole = np.einsum("njwd,njwd->jwn", halves, halves).max(axis=0)
        return np.sqrt(np.stack([squares[:first].max(axis=0), bound, whole]))

    def _energy_scale(self) -> float:
        """Return how the energy changes where the state is halved or doubled, relative, at least 1.

        So an energy that is nearly 0 by cancellation is no measure of its error.
        """
        if self.hamiltonian is None:
            return math.inf
        try:
            with np.errstate(all="ignore"):
                found = self._errors_of_energy(np.stack([2 * self.y0, self.y0 / 2]))
        except (ArithmeticError, ValueError):
            return math.inf
        return max([1.0, *found[np.isfinite(found)].tolist()])

    def _errors_of_energy(self, solutions: np.ndarray) -> np.ndarray:
        """Return the errors (n,) of the energy at solutions (n, d), relative."""
        given, energy = np.concatenate([self.y0[None], solutions]), self.hamiltonian
        if isinstance(energy, Formula):
            found = energy(given.T) * np.ones(len(given))  # also of a constant
        else:
            found = np.array([float(energy(y)) for y in given])
        return np.abs(found[1:] - found[0]) / max(abs(found[0]), _TINY)

    def large(self, solutions: np.ndarray, step: int) -> bool:
        """Return whether :meth:`first_large` finds one window (WINDOW, d) large."""
        return self.first_large([solutions], [step]) is not None

    def first_large(self, windows: Sequence[np.ndarray], steps: Sequence[int]) -> int | None:
        """Return the first of windows in which the parasitic part is large, or energy lost.

        It is large against the truncation error. A window (WINDOW, d) has the solutions of
        successive steps, the last with the number in ``steps``. What is after the first large
        window is not looked at.
        """
        finite = [bool(np.isfinite(x).all()) for x in windows]
        until = finite.index(False) if not all(finite) else len(windows)
        if not until:
            return 0 if windows else None
        whole = np.stack(windows[:until])
        halves = whole.reshape(until, WINDOW, len(self.fits), -1).transpose(2, 1, 0, 3)
        if not self.first:  # what the start leaves is in the error from the beginning
            self.first = self.parasitic(halves[:, :, 0])
            self.scale = _larger(self.scale, self.first)
        sizes, errors = self._sizes(halves).tolist(), self._errors_in(whole, steps)
        for k, one in enumerate(zip(*sizes, strict=True)):
            if self._is_large(halves[:, :, k], one, errors[k], steps[k]):
                return k
        return until if until < len(windows) else None

    def _errors_in(self, whole: np.ndarray, steps: Sequence[int]) -> list[np.ndarray]:
        """Return errors of the energy in windows (w, WINDOW, d), at more steps of early ones."""
        if self.hamiltonian is None:
            return [np.zeros(0)] * len(whole)
        each = [WINDOW // (_SAMPLES * (4 if n <= EARLY else 1)) for n in steps[: len(whole)]]
        taken = [one[::n] for one, n in zip(whole, each, strict=True)]
        ends = np.cumsum([len(x) for x in taken])[:-1]
        return np.split(self._errors_of_energy(np.concatenate(taken)), ends)

    def _is_large(
        self, halves: np.ndarray, sizes: Sequence[list[float]], errors: np.ndarray, step: int
    ) -> bool:
        """Return whether a window is large, given :meth:`_sizes` and energies of it."""
        truncation, bound, size = sizes
        unit = _unit(step)
        now = [max(x, unit * y) for x, y in zip(truncation, size, strict=True)]
        self.scale = _larger(self.scale, now)
        visible = [FACTOR * x for x in self.scale]
        if self.hamiltonian is None:
            return _above(bound, visible) and _above(self.parasitic(halves), visible)
        # at a close encounter the largest error is large for a moment, also of a sound orbit
        ordered = np.sort(errors).tolist()
        middle = (ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2]) / 2
        error = math.nan if math.isnan(ordered[-1]) else middle
        if step <= EARLY:
            if not self.later:
                self.energy_error = float(np.fmax.reduce(errors, initial=self.energy_error))
                self.middle = error if step <= WINDOW else self.middle
            return False
        self.later = not self.growing
        if not error > (first := max(self.energy_error, unit)):
            self.grown = None
        elif self.grown is None and error > _ENERGY * first:
            self.grown = step
        if error > self._lost():
            return True
        enough = [
            max(FACTOR * x, FACTOR * unit * y, _VISIBLE * z)
            for x, y, z in zip(self.first, size, self.scale, strict=True)
        ]
        # the energy is not in every direction a measure
        whatever = [
            max(x, _OF_SOLUTION * y) if self.growing else math.inf
            for x, y in zip(enough, size, strict=True)
        ]
        known = max(self.energy_error, unit if self.growing else _FLOOR)
        # a bound decides for less
        if not _above(bound, enough if error > _ENERGY_TOO * known else whatever):
            return False
        found = self.parasitic(halves)
        if _above(found, whatever) or not _above(found, enough):
            return _above(found, whatever)
        return error > (_ENERGY_TOO if _above(found, visible) else _ENERGY) * known

    def _lost(self) -> float:
        """Return the error of the energy beyond which an orbit is lost whatever else is seen."""
        least = max(_OF_ENERGY, _GROWN * self.energy_error)
        if not self.growing:
            least = min(least, max(_ALONE, _ENERGY * self.middle))
        return min(least, _OF_ENERGY * self.energy_scale)

    def alarming(self, solutions: np.ndarray, steps: Sequence[int]) -> list[int]:
        """Return at which solutions (n, d) the energy says that the steps before be looked at.

        So it does where its error has grown as much as :meth:`large` asks for at least, of one
        formula where that is large without a parasitic part, and has doubled since it last did.
        The numbers are those of the solutions.
        """
        found: list[int] = []
        if self.hamiltonian is None or not len(solutions):
            return found
        errors = self._errors_of_energy(solutions)
        known = max(_ENERGY_TOO * self.energy_error, 0.0 if self.growing else _ALONE)
        for k in np.flatnonzero(errors > max(known, 2 * self.alarm)).tolist():
            error, least = errors[k], _ENERGY_TOO * _unit(steps[k])
            if steps[k] > EARLY and error > max(least, 2 * self.alarm):
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
            f"{cures}a smaller h, a transformed time (docs/close-encounters.md), or an implicit "
            f"method such as gauss-4, see docs/{self.page}.md"
        )
