"""When a long run is lost to its parasitic part, predicted from the method and a pilot orbit.

At each eigenvalue zeta of V of modulus one, zeta != 1, the values carry a parasitic part phi. Along
an orbit of the underlying one-step method, with S(y) its starting map, it obeys

    M'(S(y_n)) T_n = zeta T_(n+1) Psi_n,      phi_(n+1) = zeta Psi_n phi_n,      Psi_n = I + O(h)

T_n = R + C_n with R the eigenvectors of V and L C_n = 0, L R = I. The equation is solved by the
iteration that gives S: a pass gains one order of h,

    C_n <- (V - zeta)^-1 (zeta (C_(n+1) Psi_n - C_n) - (1 - R L)(M' - V)(R + C_n)),

so that Psi holds the growth parameters (h), I1, I2, I3 and kappa (h^3) and what follows, each taken
along the orbit, and no part of the solution's own perturbations, which grow on chaotic orbits.

**Growth.** On a periodic orbit the product of the Psi_n over a period decides (Floquet). On others
the averaged logarithm does where the growth parameters vanish, so that Psi_n is near to I (Hairer,
Lubich and Wanner 2006, sections XIV.3 and XV.5), averaged with smooth weights, which converges fast
on quasi-periodic orbits (Das, Saiki, Sander and Yorke, Nonlinearity 30 (2017) 4111). Else, and
where they show it to be earlier, clear growth in two runs that begin with phi counts
(:mod:`.planted`).

**Size.** phi begins as what the start leaves, read off the pilot run, and at least as round-off,
:data:`ROUND_OFF`. The run is lost where phi reaches :data:`LEVEL` of the solution. Both constants
were fixed before any run was compared; nothing is fitted.

**Saturation.** Nonlinear terms, which Psi does not have, may stop phi before that:
:mod:`.saturation`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..engine.clocks import solved_form
from ..engine.kept import stepper_of
from ..engine.outcome import Solution
from ..engine.plan import check_direction, resolved, step_size
from ..engine.reference import Stepper
from ..engine.solve import solve
from ..method import Method
from ..problems.canonical import timed
from ..problems.formula import Formula
from ..problems.model import Problem
from ..system.arguments import number
from ..system.shown import Shown
from .first_order import along, coupling_of
from .linearised import step_derivatives
from .longtime import energy_deviation
from .planted import BOTH, BUDGET, HALVINGS, LINEAR, NUMBERS, SMALL, follow_part, size_at
from .saturation import TOO_MUCH, saturation
from .underlying import Underlying

#: Size of a parasitic part that the start does not excite, over that of the solution.
ROUND_OFF = 1e-16
#: Part of the size of the solution at which the energy counts as lost.
LEVEL = 0.3
#: Largest |Psi - 1| of a step to which the expansion in h may apply.
FAR = 10.0
#: Passes of the iteration for Psi, each an order of h.
PASSES = 6
#: Steps of the pilot run, in which a period is looked for; of these, steps whose derivatives are
#: taken and whose energy is the early one where there is none, fewer derivatives where they would
#: be more numbers than MOST; and so many as the size of the start is read off.
PILOT, STEPS, LEAST, START, MOST = 5000, 1000, 200, 512, 2_000_000
#: Growth of a parasitic part beyond which its start is not read off, and fewest steps for that.
MUCH, SHORTEST = 1e4, 64
#: Growth in half of a run that is not that of the time itself; and a part of the steps of loss that
#: is clearly fewer.
CLEAR, EARLIER = 3.0, 0.5
#: So many times the smooth part of the values, seen by the eigenvector of a part, is that of their
#: changes, relative to the solution and its changes.
SMOOTH = 3.0
#: The energy has left its early level beyond the first power of ten that is so many times that, or
#: its round-off.
DEPARTED, ROUNDED = 10, 1e-14
#: Parts of the size of the solution: beyond it an orbit has left, within it it has come back.
AWAY, NEAR = 0.1, 1e-3
#: A growth parameter below it is zero but for the digits of the tableau.
NO_GROWTH = 1e-9
#: Steps beyond which no loss is looked for; a loss before so many is at once.
FOR_EVER, AT_ONCE = 1e12, 10
#: Why there is no prediction where growth is slow or the passes for Psi do not converge.
UNRESOLVED = (
    "growth of first order on an orbit that is not periodic, or a resonance of two eigenvalues of V"
)
#: Why where a right-hand side is interpreted, and these runs are too short to decide.
SPENT = f"budget: runs with {BUDGET} evaluations of a function that is interpreted do not show it"
#: How the kernel of a run with such a function is told.
INTERPRETED = "python"
LOST, SATURATES, BOUNDED = "lost", "saturates", "bounded"
NONE, OPEN = "no parasitic part", "open"


@dataclass(frozen=True)
class ParasiticPart:
    """What is predicted of one parasitic part.

    Attributes
    ----------
    zeta : complex
        Eigenvalue of V, of nonnegative imaginary part: its conjugate goes with it.
    start : float
        Size at the start, 0.0 where it is below round-off.
    rate : float
        It grows as exp(rate t) in the long run, per unit of time.
    steps : float
        Step at which it reaches :data:`LEVEL` of the solution; ``inf``: not within 1e12 steps.
    """

    zeta: complex
    start: float
    rate: float
    steps: float


@dataclass(frozen=True, repr=False)
class Prediction(Shown):
    """How long the parasitic parts of a run stay small. Made by :func:`predict`.

    Attributes
    ----------
    method, problem : str
        Names.
    h, t_end : float
        Step size, and the end of the run.
    verdict : str
        ``"lost"``, ``"saturates"`` or ``"bounded"`` up to ``t_end``; ``"no parasitic part"``;
        ``"open"``.
    steps : float or None
        Step at which the run is lost, possibly beyond ``t_end``, ``inf`` for never; that by which a
        part is large in one that saturates, or where it is open which of both; else ``None``.
    zeta : complex or None
        The eigenvalue whose part is the first to be large.
    parts : tuple[ParasiticPart, ...]
        All of them.
    why : str
        Why it is open, or ``""``.
    level : float or None
        Relative energy error that a run that saturates reaches. Later it may be lost all the same.
    departure : tuple[float, float] or None
        Relative energy error, the first power of ten at least ten times that of the early steps,
        and the step by which a part brings it there; ``None`` where that is open.
    """

    method: str
    problem: str
    h: float
    t_end: float
    verdict: str
    steps: float | None = None
    zeta: complex | None = None
    parts: tuple[ParasiticPart, ...] = ()
    why: str = ""
    level: float | None = None
    departure: tuple[float, float] | None = None

    def __repr__(self) -> str:
        return f"<Prediction: {self.text}>"

    @property
    def time(self) -> float | None:
        """Time from the start at which the run is lost or saturates, ``None`` where it is open."""
        return None if self.steps is None else self.steps * abs(self.h)

    @property
    def text(self) -> str:
        """Such as ``"lost after about 1.2e+06 steps, by the part at zeta = -1"``."""
        if self.verdict in (NONE, OPEN) or self.steps is None:
            return f"{self.verdict}: {self.why}" if self.why else self.verdict
        many = f"{self.steps:.2g}"
        about = f"about {many} step{'s' * (many != '1')}"
        part = "" if self.zeta is None else f"the part at zeta = {_text(self.zeta)}"
        if self.verdict == LOST:
            when = "at once" if self.steps < AT_ONCE else f"after {about}"
            return f"lost {when}{part and f', by {part}'}"
        if self.verdict == SATURATES:
            return f"{part} saturates after {about}: the energy error stays near {self.level:.1g}"
        if self.steps > FOR_EVER:
            return "bounded: no parasitic part grows"
        return f"bounded for {about}"


def _text(zeta: complex) -> str:
    return f"{zeta.real:.4g}" if not zeta.imag else f"{zeta.real:.4g}{zeta.imag:+.4g}i"


@dataclass(frozen=True, eq=False)
class _Bundle:
    """Eigenvectors of V on all values of a run, flattened to n = r d numbers."""

    zeta: Any  #: complex, or float where it is real
    right: np.ndarray  #: (n, m)
    left: np.ndarray  #: (m, n), left right = I
    grows: bool  #: Whether a growth parameter is not zero.
    shape: tuple[int, int]  #: (r, d) of the values


def _halves(engine: Stepper) -> list[tuple[Any, np.ndarray, np.ndarray, np.ndarray]]:
    """Return tableau, V, columns of the values and eigenvalues of V of each part."""
    found = []
    for c in engine.components[: len(engine.parts)]:
        matrix = np.array(c.V, dtype=float)
        columns = np.arange(engine.shape[1])[c.columns]
        found.append((c, matrix, columns, np.linalg.eigvals(matrix)))
    return found


def _zetas(engine: Stepper) -> list[complex]:
    """Return eigenvalues of V of modulus one but 1, of nonnegative imaginary part."""
    met: list[complex] = []
    for z in (z for *_, values in _halves(engine) for z in values):
        wanted = abs(abs(z) - 1) < 1e-9 and abs(z - 1) > 1e-9 and z.imag > -1e-9
        if wanted and all(abs(z - x) > 1e-6 for x in met):
            met.append(complex(z))
    return sorted(met, key=lambda z: float(np.angle(z)))


def _on_values(engine: Stepper) -> tuple[np.ndarray, list[_Bundle]]:
    """Return V on the flattened values, (n, n), and its eigenvectors of modulus one but 1."""
    r, d = engine.shape
    V, halves = np.zeros((r, d, r, d)), _halves(engine)
    for _, matrix, columns, _ in halves:
        for j in columns:
            V[: len(matrix), j, : len(matrix), j] = matrix
    return V.reshape(r * d, r * d), [_bundle(z, halves, engine) for z in _zetas(engine)]


def _bundle(z: complex, halves: Sequence[Any], engine: Stepper) -> _Bundle:
    right, left, vectors = [], [], []
    for c, matrix, columns, values in halves:
        count = int(np.sum(np.abs(values - z) < 1e-6))
        # null vectors: V may be defective at other eigenvalues, past values make it so at 0
        u, _, vh = np.linalg.svd(matrix - z * np.eye(len(matrix)))
        x, y = vh[len(vh) - count :].conj().T, u[:, len(vh) - count :].conj().T
        scale = np.max(np.abs(x), initial=0.0)
        x, y = x / scale, np.linalg.solve(y @ x, y) * scale
        vectors.append((c, x, y))
        for k in range(count):
            for j in columns:
                for row, found in ((x[:, k], right), (y[k], left)):
                    full = np.zeros(engine.shape, dtype=complex)
                    full[: len(matrix), j] = row
                    found.append(full.ravel())
    mu = [
        y @ np.array(a.B, dtype=float) @ np.array(b.U, dtype=float) @ x
        for a, _, y in vectors
        for b, x, _ in vectors
        if a is not b or engine.joint
    ]
    grows = any(np.max(np.abs(x), initial=0.0) > NO_GROWTH for x in mu)
    if abs(z.imag) < 1e-9:
        return _Bundle(z.real, np.real(right).T, np.real(left), grows, engine.shape)
    return _Bundle(z, np.array(right).T, np.array(left), grows, engine.shape)


def _propagators(V: np.ndarray, b: _Bundle, steps: np.ndarray) -> list[np.ndarray]:
    """Return Psi_n, (N + 1 - passes, m, m), from the derivatives of N steps.

    That of two passes fewer than :data:`PASSES`, then that of so many.
    """
    n, m = b.right.shape
    here = b.right @ b.left
    inverse = np.linalg.inv(V - b.zeta * np.eye(n) + here) @ (np.eye(n) - here)
    inverse, V = _by_component(inverse, b.shape), _by_component(V, b.shape)
    C = np.zeros((len(steps) + 1, n, m), dtype=b.right.dtype)
    found = []
    for passes in range(PASSES + 1):
        T = b.right + C[: len(steps)]
        after = _times(steps[: len(T)], T)
        psi = b.left @ after / b.zeta
        if passes >= PASSES - 2:
            found.append(psi)
        last = len(C) - 1
        rest = after[:last] - _onto(V, T[:last])
        C = _onto(inverse, b.zeta * (C[1:] @ psi[:last] - C[:last]) - rest)
    return [found[0], found[-1]]


def _by_component(matrix: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the (d, r, r) of a matrix on the values that acts on each component of a state."""
    r, d = shape
    return np.einsum("ajbj->jab", matrix.reshape(r, d, r, d))


def _onto(parts: np.ndarray, many: np.ndarray) -> np.ndarray:
    """Return the products of such a matrix, (d, r, r), with many, (N, r d, m)."""
    d, r, _ = parts.shape
    found = parts @ many.reshape(len(many), r, d, -1).swapaxes(1, 2)
    return found.swapaxes(1, 2).reshape(many.shape)


def _times(real: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return products of real matrices with matrices that may be complex."""
    if x.dtype.kind != "c":
        return real @ x
    both = real @ np.concatenate([np.real(x), np.imag(x)], axis=-1)
    re, im = np.split(both, 2, axis=-1)
    return re + 1j * im


def _weights(count: int) -> np.ndarray:
    """Return smooth weights with sum 1 that vanish at both ends with all derivatives."""
    x = (np.arange(count) + 0.5) / count
    weights = np.exp(-1 / (x * (1 - x)))
    return weights / weights.sum()


def _logarithms(psi: np.ndarray) -> np.ndarray:
    x = psi - np.eye(psi.shape[-1])
    square = x @ x
    return x - square / 2 + square @ x / 3 - square @ square / 4


def _exponential(matrix: np.ndarray) -> np.ndarray:
    """Return the exponential of a matrix of small norm."""
    result = term = np.eye(len(matrix), dtype=matrix.dtype)
    for k in range(1, 16):
        term = term @ matrix / k
        result = result + term
    return result


@dataclass(frozen=True, eq=False)
class _Course:
    """What becomes of a parasitic part in the linear equation."""

    rate: float  #: per step
    steps: float  #: step at which it is large
    late: np.ndarray  #: (m,) phi at the last return before that


#: Nothing is known.
_OPEN = _Course(math.nan, math.nan, np.zeros(0))


class _Growing:
    """One parasitic part along the pilot orbit.

    ``psi`` (N, m, m) are the propagators of the steps, ``products`` (N + 1, m, m) theirs, ``start``
    (m,) is its size at the start, ``least`` that of round-off, and ``period`` the number of steps
    of a period, not whole.
    """

    def __init__(
        self, psi: np.ndarray, products: np.ndarray, start: np.ndarray, least: float,
        period: float | None,
    ) -> None:  # fmt: skip
        self.psi, self.products, self.start, self.least = psi, products, start, least
        self.logarithms = _logarithms(psi)
        moved = np.abs(psi - np.eye(psi.shape[-1])).max()
        self.near = bool(np.isfinite(self.logarithms).all() and moved < FAR)  # else too large
        known = self.near and period is not None and period + 3 < len(psi)
        self.period = period if known else None

    def size(self, products: np.ndarray) -> np.ndarray:
        """Return the size of phi where the product of the propagators is so much, (..., m, m)."""
        finite = np.asarray(np.isfinite(products).all(axis=(-2, -1)))
        known = np.where(finite[..., None, None], products, 0)
        least = self.least * np.linalg.norm(known, 2, axis=(-2, -1))
        return np.where(
            finite, np.maximum(np.linalg.norm(known @ self.start, axis=-1), least), math.inf
        )

    def reaches(self, products: np.ndarray, level: float) -> np.ndarray:
        """Tell where that is no less than a level: (N,) for products (N, m, m).

        Norms of products are computed only where those of Frobenius leave it open.
        """
        finite = np.isfinite(products).all(axis=(1, 2))
        found = ~finite | (np.linalg.norm(products @ self.start, axis=1) >= level)
        bound = self.least * np.linalg.norm(products, axis=(1, 2))
        found |= bound >= 2 * level * math.sqrt(products.shape[-1])
        left = np.flatnonzero(~found & (bound >= level / 2))
        found[left] = self.size(products[left]) >= level
        return found

    def found(self, level: float) -> _Course:
        """Return its course to a size; NaN where steps are too large."""
        if not self.near:
            return _OPEN
        return self.averaged(level) if self.period is None else self.periodic(self.period, level)

    def late(self, product: np.ndarray) -> np.ndarray:
        """Return phi where the product of the propagators is so much, also from round-off."""
        phi = product @ self.start
        if np.linalg.norm(phi) >= self.size(product):
            return phi
        return np.linalg.svd(product)[0][:, 0]

    def averaged(self, level: float) -> _Course:
        """Return the same from the averaged logarithm of the propagators.

        What two thirds of the pilot do not show either is no growth: the latest of three steps.
        Where the pilot itself comes to the size, nothing is averaged.
        """
        over = int(np.argmax(self.reaches(self.products, level)))  # the first, or 0
        if over:
            before, begins = self.products[over - 1], self.size(self.products[0])
            return _Course(math.log(level / begins) / over, float(over), self.late(before))
        logarithms, third, found = self.logarithms, len(self.psi) // 3, []
        for some in (logarithms, logarithms[third:], logarithms[: 2 * third]):
            mean = np.tensordot(_weights(len(some)), some, 1)
            done, before = self._repeated(_exponential(mean), level)
            rate = float(np.max(np.linalg.eigvals(mean).real))
            found.append(_Course(rate, done + 1, self.late(before)))
        return max(found, key=lambda course: course.steps)

    def periodic(self, period: float, level: float) -> _Course:
        """Return the same from the product over a period of so many steps, repeated."""
        whole = int(period)
        part = _inside(self.logarithms[whole - 2 : whole + 3], period - whole)
        once = _exponential(part) @ self.products[whole]
        if not np.isfinite(once).all():
            return _OPEN
        rate = math.log(np.max(np.abs(np.linalg.eigvals(once)))) / period
        done, before = self._repeated(once, level)
        last = 0
        if math.isfinite(done):
            over = np.flatnonzero(self.reaches(self.products[:whole] @ before, level))
            last = int(over[0]) if len(over) else whole
        return _Course(rate, done * period + last, self.late(before))

    def _repeated(self, once: np.ndarray, level: float) -> tuple[float, np.ndarray]:
        """Return how often a product may be taken until phi is large, and what it is then."""
        powers = [once]
        with np.errstate(all="ignore"):
            while not self.reaches(powers[-1][None], level)[0]:
                if 2 ** len(powers) > FOR_EVER:
                    return math.inf, powers[-1]
                powers.append(powers[-1] @ powers[-1])
            total, done = np.eye(len(once), dtype=once.dtype), 0
            for k in reversed(range(len(powers) - 1)):
                further = powers[k] @ total
                if not self.reaches(further[None], level)[0]:
                    total, done = further, done + 2**k
        return done, total


class _Followed:
    """One parasitic part as the runs that begin with it show it.

    ``phi`` (N, m) is the part after ``steps`` (N,), up to a constant and a turn, and ``start`` its
    size at the start, not zero. It is followed while it is larger than ``other`` (N,), what the
    solution's own perturbation may add to it: that grows on chaotic orbits.
    """

    def __init__(self, steps: np.ndarray, phi: np.ndarray, start: float, other: np.ndarray) -> None:
        sizes = np.linalg.norm(phi, axis=1)
        own = sizes > other
        sizes /= sizes[0]
        small = np.logical_and.accumulate(own & (sizes * SMALL < LINEAR))
        self.steps, self.phi, self.sizes, self.start = steps[small], phi[small], sizes[small], start

    def found(self, level: float) -> _Course:
        """Return its course to a size; NaN where it is not reached and growth is not clear."""
        if not len(self.steps):
            return _OPEN
        n, end, needed = self.steps, float(self.steps[-1]), level / self.start
        over = np.flatnonzero(self.sizes >= needed)
        if len(over):
            steps = max(float(n[over[0]]), 1.0)
            return _Course(math.log(self.sizes[over[0]]) / steps, steps, self.phi[-1])
        early, late = (
            self.sizes[(n >= x * end / 4) & (n <= (x + 1) * end / 4)].max(initial=0.0)
            for x in (1, 3)
        )
        if not late > CLEAR * early > 0:
            return _OPEN
        rate = math.log(late / early) / (end / 2)
        return _Course(rate, end + math.log(needed / late) / rate, self.phi[-1])


def _products(psi: np.ndarray) -> np.ndarray:
    """Return the products of no, one, two, .. propagators, (N + 1, m, m)."""
    found = np.empty((len(psi) + 1, *psi.shape[1:]), dtype=psi.dtype)
    found[0] = np.eye(psi.shape[-1])
    with np.errstate(all="ignore"):
        for n, step in enumerate(psi):
            np.matmul(step, found[n], out=found[n + 1])
    return found


def _inside(cells: np.ndarray, x: float) -> np.ndarray:
    """Return integral over [0, x] of the third of five cells, whose integrals are given: (m, m)."""
    edges = np.concatenate([cells[:1] * 0, np.cumsum(cells, axis=0)])
    edges = edges - edges[2]
    found = np.polyfit(np.arange(-2, 4), edges.reshape(6, -1), 5)
    return (x ** np.arange(5, -1, -1) @ found).reshape(cells.shape[1:])


@np.errstate(over="ignore")
def _period(y: np.ndarray) -> float | None:
    """Return the number of steps, not whole, after which an orbit (N, d) is back.

    ``None`` stands for never.
    """
    distance, size = np.linalg.norm(y - y[0], axis=1), float(np.max(np.linalg.norm(y, axis=1)))
    left = np.flatnonzero(distance > AWAY * size)
    if not len(left):
        return None
    inner = distance[1:-1]
    least = 1 + np.flatnonzero((inner <= distance[:-2]) & (inner <= distance[2:]))
    # three steps on both sides are interpolated
    least = least[(least > max(left[0], 2)) & (least < len(y) - 3)]
    least = least[distance[least] < AWAY * size]
    for n in least:
        found = np.polyfit(np.arange(-3, 4), y[n - 3 : n + 4] - y[0], 6)
        slopes = found[:-1] * np.arange(6, 0, -1)[:, None]
        low, high = -1.0, 1.0  # where the distance stops falling
        for _ in range(40):
            x = (low + high) / 2
            at, slope = x ** np.arange(6, -1, -1) @ found, x ** np.arange(5, -1, -1) @ slopes
            low, high = (x, high) if at @ slope < 0 else (low, x)
        if np.linalg.norm(low ** np.arange(6, -1, -1) @ found) < NEAR * size:
            return n + low
    return None


def _start(
    engine: Stepper, b: _Bundle, products: np.ndarray, values: np.ndarray, h: float
) -> np.ndarray:
    """Return phi at step 0, (m,): later steps taken back; what is smooth averages out."""
    grown = np.linalg.norm(products[: START + 1], axis=(1, 2))
    count = int(np.argmax(~(np.append(grown, MUCH) < MUCH))) - 1
    found = []
    if count >= SHORTEST:
        n = np.arange(count)
        seen = values[:count].reshape(count, -1) @ b.left.T * (b.zeta**-n)[:, None]
        with suppress(np.linalg.LinAlgError):  # the later steps have forgotten the start
            found.append(
                _weights(count) @ np.linalg.solve(products[:count], seen[..., None])[..., 0]
            )
    if not found or count < len(grown) - 1:
        first, t = values[0], float(engine.problem.t_span[0])
        found.append(b.left @ Underlying(engine).parasitic(t, first, h, order=10).ravel())
    # too large is what later steps say that have left the orbit, and a series that diverges at h
    return min(found, key=lambda x: float(np.linalg.norm(x)))


@dataclass(frozen=True, eq=False)
class _Known:
    """A part and its course."""

    bundle: _Bundle
    course_to: Callable[[float], _Course]  #: to a size
    course: _Course  #: to that of the loss

    @property
    def open(self) -> bool:
        """Whether that is not known."""
        return math.isnan(self.course.steps)


@dataclass(frozen=True, eq=False)
class _Pilot:
    """The pilot run, and runs that begin as it does with a parasitic part besides."""

    method: Method
    problem: Problem
    h: float
    y: np.ndarray  #: (N, d)
    start: np.ndarray  #: (r, d)
    period: float | None
    most: float  #: Steps of the run.
    limit: float  #: Steps that runs with a part may take.

    @cached_property
    def size(self) -> float:
        """Size of the solution."""
        first = float(np.linalg.norm(self.y[0]))
        return first or float(np.max(np.linalg.norm(self.y, axis=1)))

    def part(self, b: _Bundle, phi: np.ndarray) -> np.ndarray:
        """Return what phi, (m,), and its conjugate add to the values, of the size of the solution.

        Where it is zero round-off excites all directions.
        """
        if np.linalg.norm(phi) <= ROUND_OFF * self.size:
            phi = np.ones(b.right.shape[1])
        found = b.right @ phi * (self.size / np.linalg.norm(phi))
        found = 2 * np.real(found) if np.iscomplexobj(b.right) else np.real(found)
        return found.reshape(self.start.shape)

    def followed(
        self, bundles: Sequence[_Bundle], starts: Sequence[np.ndarray], *, further: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """Follow all parts in one run: steps (N,) and values (N, n)."""
        part = sum(self.part(b, phi) for b, phi in zip(bundles, starts, strict=True))
        return follow_part(
            self.method, self.problem, self.h, self.start, np.asarray(part),
            further=further, limit=self.limit,
        )  # fmt: skip

    def long(self, b: _Bundle, start: np.ndarray, size: float, level: float) -> _Known | None:
        """Return a part as a long orbit shows it, ``None`` where its growth is not clear."""
        engine = stepper_of(self.method, self.problem)
        coupling = coupling_of(engine, b.zeta, b.left, b.right)
        found = along(self.problem, self.h, coupling, start, growth=level / size)

        def course(to: float) -> _Course:
            at = found.reached(to / size) if found is not None else None
            return _OPEN if at is None else _Course(at[1], at[0], at[2])

        one = _Known(b, course, course(level))
        return None if one.open else one

    def end(self, one: _Known) -> tuple[float | None, str, str]:
        """Return the level at which the energy error stays, the verdict, and why that is open."""
        part = self.part(one.bundle, one.course.late)
        level = saturation(
            self.method, self.problem, self.h, self.start, part, one.course.rate, limit=self.limit
        )
        if level is not None and math.isnan(level):
            return None, OPEN, SPENT
        return level, LOST if level is None else SATURATES, ""

    def departure(self, known: Sequence[_Known]) -> tuple[float, float] | None:
        """Return the first level beyond the early energy errors, and the step when it is passed."""
        if self.problem.hamiltonian is None or not known:
            return None
        error = energy_deviation(self.problem, np.real(self.y[: STEPS + 1]))
        level = 10.0 ** math.ceil(math.log10(DEPARTED * max(float(error.max()), ROUNDED)))
        if not level <= TOO_MUCH:
            return None
        times = [math.inf]
        for one in known:
            if math.isfinite(one.course.steps):
                part, rate = self.part(one.bundle, one.course.late), max(one.course.rate, 1e-9)
                steps = math.ceil(min(self.period or STEPS, 1 / rate))
                if (HALVINGS + 1) * steps > self.limit:
                    return None
                size = size_at(
                    self.method, self.problem, self.h, self.start, part, level=level, steps=steps
                )
                if math.isnan(size):
                    return None
                times.append(one.course_to(min(size, LEVEL) * self.size).steps)
        return level, float(min(times))


@np.errstate(all="ignore")  # what is not finite is looked for where it matters
def predict(
    method: Method | str | Path, problem: Problem | str, h: float, t_end: float | None = None,
    *, start: Any = None,
) -> Prediction:  # fmt: skip
    """Predict whether a run is lost to its parasitic part, and when, from the first steps of it.

    Parameters
    ----------
    method : Method or str or Path
        The method, its name or its file.
    problem : Problem or str
        An autonomous problem, or its name.
    h : float
        Step size.
    t_end : float or None
        End of the run, by default that of the problem.
    start : Any
        As for :func:`glmref.solve`.

    Returns
    -------
    Prediction
        ``open`` where the problem depends on time, the derivatives of the step are too large or
        cannot be computed, or the pilot run does not come to its end.

    Raises
    ------
    UsageError
        As :func:`glmref.solve`.

    Examples
    --------
    >>> import glmref
    >>> glmref.predict("g6245-w3", "pendulum", 0.1, t_end=1e5)
    <Prediction: bounded for about 7.2e+06 steps>
    """
    subject, chosen = resolved(problem, method)
    h = step_size(h)
    begin, last = (float(x) for x in subject.t_span)
    end = last if t_end is None else number("t_end", t_end)
    check_direction(end, begin, "t_end", h)
    given = (chosen.name, subject.name, h, end)
    solved = solved_form(subject, chosen)
    engine = stepper_of(chosen, solved)
    if not _zetas(engine):
        return Prediction(*given, NONE, math.inf)
    if solved is not subject or _depends_on_time(subject):
        return Prediction(*given, OPEN, why="the problem depends on time")
    count = math.prod(engine.shape)
    if LEAST > MOST // count**2:
        return Prediction(*given, OPEN, why=f"{count} values a step are too many")
    V, bundles = _on_values(engine)
    run = solve(subject, chosen, h=h, steps=PILOT, every=1, start=start, history=True)
    if run.steps < LEAST:
        return Prediction(*given, LOST, float(run.steps), why=run.message)
    assert run.history is not None
    y = np.asarray(run.y)
    period = _period(y)
    count = STEPS
    if period is not None and period + 4 < MOST // V.size:
        count = max(START, math.ceil(period) + 4)
    count = min(count, MOST // V.size, run.steps - PASSES)
    values = np.asarray(run.history)[: count + PASSES + 1]
    steps = step_derivatives(chosen, subject, h, values[:-1])
    if not np.isfinite(steps).all():
        return Prediction(*given, OPEN, why="the derivatives of the step are not finite")
    most = abs((end - begin) / h)
    pilot = _Pilot(chosen, subject, h, y, values[0], period, most, _limit(run))
    if not pilot.size:
        return Prediction(*given, OPEN, why="the solution is zero")
    large, least = LEVEL * pilot.size, ROUND_OFF * pilot.size

    def expanded(b: _Bundle) -> tuple[_Growing, _Course, float]:
        """Return a part, its course, and the loss; NaN where the passes for Psi do not converge."""
        found = []
        for psi in (x[:count] for x in _propagators(V, b, steps)):
            products = _products(psi)
            begins = _start(engine, b, products, values, h)
            growing = _Growing(psi, products, begins, least, period)
            course = growing.found(large)
            found.append(course.steps)
        unsettled = min(found) <= most and max(found) > 2 * min(found)
        settled = not (unsettled or any(map(math.isnan, found)))
        return growing, course, course.steps if settled else math.nan

    expansions = [expanded(b) for b in bundles]

    @cache
    def followed(further: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return steps, the values that all parts add by then, and the size in the solution."""
        starts = [growing.start for growing, *_ in expansions]
        n, change = pilot.followed(bundles, starts, further=further)
        moved = engine.solution(change.reshape(-1, *engine.shape))
        return n, change, np.linalg.norm(moved, axis=1)

    def shown(b: _Bundle, begins: float, further: bool = False) -> _Known:
        n, change, moved = followed(further)
        smooth = max(float(np.linalg.norm(b.left @ x.ravel())) for x in values[:START])
        other = SMOOTH * smooth / pilot.size * moved
        seen = _Followed(n, change @ b.left.T, begins or least, other).found
        return _Known(b, seen, seen(large))

    every: list[_Known] = []
    starts: list[float] = []
    for b, (growing, course, expected) in zip(bundles, expansions, strict=True):
        begins = float(np.linalg.norm(growing.start))
        begins = begins if begins > least else 0.0
        one = _Known(b, growing.found, course)
        if not begins < pilot.size:  # steps are so large that the start is not known either
            one = _Known(b, growing.found, _OPEN)
        elif growing.period is None or math.isnan(expected):
            seen = shown(b, begins)
            at = seen.course.steps
            within = expected <= count and at <= count  # the pilot's own steps say when
            if (b.grows and not within) or math.isnan(expected) or at < EARLIER * expected:
                one = seen
        starts.append(begins)
        every.append(one)

    def further(k: int) -> _Known:
        return shown(every[k].bundle, starts[k], True)

    def longer(k: int) -> _Known | None:
        return pilot.long(every[k].bundle, expansions[k][0].start, starts[k] or least, large)

    room = NUMBERS < min(BOTH, pilot.limit) * values[0].size
    ways = [further, longer] if room else [longer]
    every = _clearer(every, [x < pilot.size for x in starts], ways)
    return _told(Prediction(*given, OPEN), pilot, every, starts)


def _clearer(
    every: list[_Known], small: Sequence[bool], ways: Sequence[Callable[[int], _Known | None]]
) -> list[_Known]:
    """Return the parts, those that grow as a longer run shows them where theirs is not clear.

    Where no part is clear at all the first way is tried before the last: growth of higher order, in
    a direction of which the start has little, comes late.
    """
    for way in ways if all(one.open for one in every) else ways[-1:]:
        every = [
            (way(k) if start and one.bundle.grows and one.open else None) or one
            for k, (one, start) in enumerate(zip(every, small, strict=True))
        ]
        if not all(one.open for one in every):
            break
    return every


def _told(
    found: Prediction, pilot: _Pilot, every: Sequence[_Known], starts: Sequence[float]
) -> Prediction:
    """Return what follows from the courses of all parts, and their sizes at the start."""
    h = found.h
    parts = tuple(
        ParasiticPart(
            complex(one.bundle.zeta), begins, float(one.course.rate / h), float(one.course.steps)
        )
        for one, begins in zip(every, starts, strict=True)
    )
    known = [one for one in every if not one.open]
    first = min(known, key=lambda one: one.course.steps, default=None)
    found = replace(found, parts=parts, departure=pilot.departure(known))
    if first is not None and first.course.steps <= pilot.most:
        level, verdict, why = pilot.end(first)
        found = replace(found, why=why)
    elif first is None or len(known) < len(parts):
        return replace(found, why=UNRESOLVED if pilot.limit == math.inf else SPENT)
    else:
        level, verdict = None, BOUNDED
    zeta = complex(first.bundle.zeta)
    return replace(found, verdict=verdict, steps=float(first.course.steps), zeta=zeta, level=level)


def _limit(run: Solution) -> float:
    """Return how many steps a right-hand side that is interpreted may be followed further."""
    if not run.kernel.startswith(INTERPRETED):
        return math.inf
    return BUDGET * run.steps / max(run.evaluations + run.velocity_evaluations, 1)


def _depends_on_time(problem: Problem) -> bool:
    if problem.separable:
        return False
    if isinstance(problem.f, Formula):
        return timed(problem.f)
    y, begin, end = np.array(problem.y0, dtype=float), *map(float, problem.t_span)
    return not np.array_equal(problem.f(begin, y), problem.f((begin + end) / 2, y))
