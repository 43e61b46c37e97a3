"""Step forms: the double precision coefficients a kernel is generated from.

With L_i = h w_i f(Y_i) every form is

    Y_i = sum_k U_ik x_k + sum_j M_ij L_j        x = V y (running) or x = y (not running)
    y+  = V y + R L

*Standard*: A, U, B, V as given, w = 1. *Mu-form* (symplectic Runge-Kutta): w = b,
M_ij = a_ij / b_j with M_ij + M_ji = 1 in floating point. The *sweep* is in :mod:`.sweep`.

References: Hairer, McLachlan, Razakarivony, "Achieving Brouwer's law with implicit Runge-Kutta
methods", BIT 48 (2008), for the mu-form and the compensation of rounded coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix
from ..method import GLM
from ..method.component import SEPARABLE
from ..method.preconsistency import output, preconsistency_vector, stage_times
from ..method.rounding import CLOSE, as_double, split_rows
from ..method.stage_order import StageBlock, dependency_blocks
from .arithmetic import solution_of
from .tableau import as_balls

Row = tuple[float, ...]


@dataclass(frozen=True)
class Rows:
    """One component in double precision: the stages read from its values, and its values."""

    U: tuple[Row, ...]  #: (n, r) of the stages.
    M: tuple[Row, ...]  #: (n, n') from the increments that move the component.
    weights: Row  #: (n,), the w of the module docstring.
    V: tuple[Row, ...]  #: (r, r).
    R: tuple[Row, ...]  #: (r, n') updates of the values; R_residue what their rounding lost.
    R_residue: tuple[Row, ...]
    large: tuple[bool, ...]  #: Values that are multiples of y (u_k != 0); the others are O(h).
    #: (r, r), change of basis: x = to_form @ y and back.
    to_form: tuple[Row, ...]
    from_form: tuple[Row, ...]


def _first(field: str) -> Any:
    """Return a field of the first component, which is the only one of a single method."""
    return property(lambda form: getattr(form.components[0], field))


@dataclass(frozen=True)
class StepForm:
    """Double precision coefficients of one step, ready for code generation.

    Of two components the first is q, moved by the increments of the stages of the second, where
    q' = dq(p) is evaluated; and the other way round.
    """

    kind: str  #: ``"sweep"``, ``"mu"`` or ``"standard"``.
    running: bool  #: Whether the updates R L are added to x as the stages go (sweep).
    #: One, or two; U, M, weights, V, R, R_residue, large, to_form and from_form are the first's.
    components: tuple[Rows, ...]
    #: Stages in the order of computation, numbered through the components.
    blocks: tuple[StageBlock, ...]
    c: Row = ()  #: (s,) abscissae of a single method, or of stages evaluated together.
    #: (r, r) form that a running form conserves, in its basis, or ``None``.
    G: tuple[Row, ...] | None = None
    M_residue: Row = ()  #: (s,), rounding residual of M_ii (sweep; below 1e-20 it is left out).
    #: What is carried in place of value k of p is p_k + kick_k h dp(q), see :func:`.sweep.merged`
    #: and :func:`.sweep.merged_multistep`; empty where values are carried as they are.
    kick: Row = ()
    #: Whether the stages of two components are evaluated together: block i is that of (Q_i, P_i).
    together: bool = False
    #: Whether then the first of a step is the last one of the step before: the solution itself.
    same_point: bool = False

    U, M, weights, V = map(_first, ("U", "M", "weights", "V"))
    R, R_residue, large = map(_first, ("R", "R_residue", "large"))
    to_form, from_form = map(_first, ("to_form", "from_form"))

    @property
    def s(self) -> int:
        """Number of stages of all components."""
        return sum(len(one.U) for one in self.components)

    @property
    def r(self) -> int:
        """Number of values of the first component."""
        return len(self.V)

    @property
    def rows(self) -> int:
        """Rows of values in the state of a kernel: of the longest component."""
        return max(len(one.V) for one in self.components)

    @property
    def implicit_stages(self) -> int:
        """Number of stages that need an equation solved."""
        return sum(len(block.stages) for block in self.blocks if block.implicit)

    @property
    def forces(self) -> int:
        """Forces evaluated in a step by stages that need no equation solved."""
        single = [b.stages[0] for b in self.blocks if not b.implicit]
        reused = self.reuses_force or self.same_point
        return sum(1 for stage in single if stage < len(self.U)) - reused

    @property
    def solved(self) -> list[int]:
        """Forces evaluated in a round of the solver, for each block of stages that needs one."""
        blocks = [block.stages for block in self.blocks if block.implicit]
        return [sum(1 for stage in stages if stage < len(self.U)) for stages in blocks]

    def evaluations(self, steps: int, rounds: int) -> int:
        """Return evaluations of so many steps whose solvers took so many rounds in all.

        A round is taken to be that of the largest block.
        """
        return steps * self.forces + rounds * max(self.solved, default=0)

    @property
    def reuses_force(self) -> bool:
        """Whether the first stage Q of a step is the last one of the step before.

        So it is for one value each where a step begins and ends with an update of p, and for one
        value of q and several of p where the last stage is the new q.
        """
        if len(self.components) == 1 or self.V != ((1.0,),) or self.implicit_stages:
            return False
        q, p = self.components
        first, last = self.blocks[0].stages[0], self.blocks[-1].stages[0]
        if len(q.U) < 2 or max(first, last) >= len(q.U):
            return False
        if not q.U[first] == q.U[last] == (1.0,):
            return False
        if self.running:
            return p.V == ((1.0,),)
        return not any(q.M[first]) and q.M[last] == q.R[0]

    @property
    def keeps_force(self) -> bool:
        """Whether the last force of a step is kept: for the next step, or to read p from it."""
        return bool(self.kick) or self.reuses_force or self.same_point

    @property
    def leaps(self) -> bool:
        """Whether a step is q+ = q + h p, p+ = p + h dp(q+) in the values carried.

        Then, with q' = p, what q moves by in the coming step is kept in the left half of the row
        of the force, see :class:`.kicks.KickWriter`.
        """
        ones = ((1.0,),)
        return len(self.kick) == 1 and all(x.U == x.V == x.R == ones for x in self.components)

    @property
    def memory(self) -> tuple[tuple[str, float | None], ...]:
        """What is kept from step to step: increments and weights, or a force (weight ``None``)."""
        if self.keeps_force:
            return (("G", None),)
        if not self.implicit_stages:
            return ()
        weights = [w for one in self.components for w in one.weights]
        return tuple((f"L{i}", weight) for i, weight in enumerate(weights))

    @property
    def ahead(self) -> bool:
        """Whether the point of a step is formed at the end of the one before, and kept as P.

        Of multistep formulas, which are evaluated at one sum of values: all of this sum but the
        last slope is there before that slope is, so that the next evaluation waits for two sums and
        not for one over all values.
        """
        one = self.formula or (self.together and not self.same_point and len(self.blocks) == 1)
        return one and not any(map(any, (row for x in self.components for row in x.M)))

    @property
    def formula(self) -> bool:
        """Whether it is one multistep formula: its only stage is read from several values alone."""
        one = len(self.components) == 1 and self.s == 1 and self.r > 1
        return one and not self.running and not any(map(any, self.M))

    def coming(self, component: int) -> tuple[Row, float]:
        """Return U y+ of :attr:`ahead`, without multiples of the solution, by y and an increment.

        The factors (r,) of the values y, and that of the increment.
        """
        one = self.components[component]
        (U,) = one.U
        small = [(Fraction(u), k) for k, u in enumerate(U) if u and not one.large[k]]
        columns = zip(*(one.V[k] for _, k in small), strict=True)
        return (
            tuple(float(sum(u * Fraction(x) for (u, _), x in zip(small, column, strict=True)))
                  for column in columns),
            float(sum(u * Fraction(one.R[k][0]) for u, k in small)),
        )  # fmt: skip

    def point(self, values: np.ndarray) -> np.ndarray:
        """Return the point (..., d) of a step of :attr:`ahead` from values (..., r, d)."""
        m = values.shape[-1] // len(self.components)
        parts = [
            solution_of(np.array(one.U[0]), values[..., k * m : (k + 1) * m])
            for k, one in enumerate(self.components)
        ]
        return np.concatenate(parts, axis=-1)

    def place(self, stage: int) -> tuple[int, int]:
        """Return the component that a stage is read from, and its row there."""
        n = len(self.U)
        return (0, stage) if stage < n else (1, stage - n)

    def increments(self, stage: int, among: Sequence[int]) -> list[tuple[float, str]]:
        """Return terms of a stage: those of the given stages' increments that it reads."""
        k, row = self.place(stage)
        moving = len(self.components) - 1 - k
        places = [(j, *self.place(j)) for j in among]
        return [(self.components[k].M[row][i], f"@L{j}") for j, m, i in places if m == moving]

    def kept(self, component: int) -> tuple[bool, ...]:
        """Return which values of a component are kept together with their rounding errors.

        All but those that oscillate in a multistep formula, or a pair of them with merged kicks or
        with stages that are evaluated together. Their sums V y have factors like 2 cos(theta),
        whose products are rounded and not put back, so that the error of the last addition alone is
        not worth its operations; no multiple of the solution is among them, and their errors do not
        add up. Nor do they at the root -1, which is turned by its sign.
        """
        V = self.components[component].V
        sign = 1.0 if self.together else -1.0
        kept = [True] * len(V)
        oscillating = self.together or self.formula or (component and len(self.kick) > 1)
        for k, row in enumerate(V) if oscillating else ():
            before = [j for j, x in enumerate(row) if x]
            kept[k] = all(row[j] in (1.0, sign) and (j == k or kept[j]) for j in before)
        return tuple(kept)

    def kicked(self, p: np.ndarray, force: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
        """Write p + kick h force (..., r^, m) and its rounding residual (Knuth's TwoSum)."""
        more = self._kicks(force, h)
        total = p + more
        share = total - p
        lost = (p - (total - share)) + (more - share)
        return total, np.where(np.array(self.kept(1))[:, None], lost, 0.0)

    def unkicked(
        self, p: np.ndarray, rest: np.ndarray | float, force: np.ndarray, h: float
    ) -> np.ndarray:
        """Take :meth:`kicked` back."""
        return p + (rest - self._kicks(force, h))

    def _kicks(self, force: np.ndarray, h: float) -> np.ndarray:
        return h * np.array(self.kick)[:, None] * force[..., None, :]

    def names(self, *, compensated: bool) -> list[str]:
        """Return the vectors that last from step to step, in their order in a kernel's state.

        Values y, their rounding errors e, what is remembered of the step before.
        """
        names = [f"{x}{k}" for x in ("ye" if compensated else "y") for k in range(self.rows)]
        return [*names, *(name for name, _ in self.memory), *(["P"] if self.ahead else [])]

    def state(
        self, values: np.ndarray, slope: np.ndarray, h: float, *, compensated: bool, moves: bool
    ) -> np.ndarray:
        """Return the vectors of :meth:`names` before the first step, (..., n, d).

        From values (..., r, d) in the method's basis and the right-hand side at the first one,
        (..., d): the force that a pair reuses, or the predictor's first guess (where it is not
        finite: zero). ``moves`` says whether q' = p.
        """
        y, m = self.into(values), values.shape[-1] // 2
        e, memory = np.zeros_like(y), []
        for _, weight in self.memory:
            guess = slope if weight is None else h * weight * slope
            memory.append(guess if weight is None else np.where(np.isfinite(guess), guess, 0.0))
        if self.ahead:
            memory.append(self.point(y))
        if self.kick:
            p = (..., slice(len(self.components[1].V)), slice(m, None))
            y[p], e[p] = self.kicked(y[p], slope[..., m:], h)
            if self.leaps and moves:
                memory[0] = np.concatenate([h * y[..., 0, m:], slope[..., m:]], axis=-1)
        lasting = [y, e] if compensated else [y]
        return np.concatenate([*lasting, *(x[..., None, :] for x in memory)], axis=-2)

    def values(self, state: np.ndarray, h: float, *, compensated: bool) -> np.ndarray:
        """Return the values (..., r, d) in the method's basis of a :meth:`state`."""
        values, m = self.back(state[..., : self.rows, :]), state.shape[-1] // 2
        if self.kick:
            rows = len(self.components[1].V)
            e = state[..., self.rows : self.rows + rows, m:] if compensated else 0.0
            force = state[..., self.rows * (1 + compensated), m:]
            values[..., :rows, m:] = self.unkicked(state[..., :rows, m:], e, force, h)
        return values

    def into(self, values: np.ndarray) -> np.ndarray:
        """Return values of the method in the basis of this form, (..., r, d)."""
        return self._moved(values, "to_form")

    def back(self, x: np.ndarray) -> np.ndarray:
        """Return values of this form in the basis of the method, (..., r, d)."""
        return self._moved(x, "from_form")

    @cached_property
    def own_basis(self) -> bool:
        """Whether the basis of the form is that of the method."""
        return all(
            x == (n == j)
            for one in self.components
            for matrix in (one.to_form, one.from_form)
            for n, row in enumerate(matrix)
            for j, x in enumerate(row)
        )

    @cached_property
    def finite_together(self) -> bool:
        """Whether values of the method are finite where those of the form are.

        So it is where each is one of them, at most, times a factor of magnitude 1 at most.
        """
        return all(
            sum(bool(x) for x in row) <= 1 and all(abs(x) <= 1 for x in row)
            for one in self.components
            for row in one.from_form
        )

    def _moved(self, values: np.ndarray, which: str) -> np.ndarray:
        """Return ``matrix @ values``, term by term: the same bits in any shape."""
        if self.own_basis:
            return np.array(values, dtype=float)
        turned = np.ascontiguousarray(values.T)  # (d, r, ..): sums go along the trajectories
        width, out = len(turned) // len(self.components), np.zeros_like(turned, dtype=float)
        for n, component in enumerate(self.components):
            here = slice(n * width, (n + 1) * width)
            for k, row in enumerate(getattr(component, which)):
                for j, factor in enumerate(row):
                    if factor:
                        out[here, k] += factor * turned[here, j]
        return np.ascontiguousarray(out.T)


def vanishes(x: Scalar) -> bool:
    """Return whether nothing speaks against zero: exact zero, or a ball around it."""
    return x.is_zero() is not False


def all_vanish(matrix: Matrix) -> bool:
    """Return whether nothing speaks against a zero matrix."""
    return all(vanishes(x) for row in matrix for x in row)


def is_symplectic_rk(method: GLM) -> bool:
    """Return whether it is Runge-Kutta with b_i a_ij + b_j a_ji = b_i b_j, weights not 0."""
    if method.r != 1:
        return False
    A, U, B, V = (as_balls(x) for x in (method.A, method.U, method.B, method.V))
    b = B[0]
    ones = [V[0][0] - 1, *(row[0] - 1 for row in U)]
    if any(vanishes(x) for x in b) or not all(vanishes(x) for x in ones):
        return False
    s = range(method.s)
    return all(vanishes(b[i] * A[i][j] + b[j] * A[j][i] - b[i] * b[j]) for i in s for j in s)


def consistent_weights(weights: list[float], first: list[float]) -> Row:
    """Change the last bits of the weights so that they sum to 1 exactly (no drift in the phase).

    Only where the first value receives each L_i once, so that the sum is the length of the step.
    """
    if any(x != 1.0 for x in first):
        return tuple(weights)
    excess = sum((Fraction(w) for w in weights), Fraction(0)) - 1
    if not excess or abs(excess) > Fraction(1, 2**48):
        return tuple(weights)
    single = [i for i, w in enumerate(weights) if weights.count(w) == 1]
    for i in (*single, *range(len(weights))):
        adjusted = Fraction(weights[i]) - excess
        if Fraction(float(adjusted)) == adjusted:
            return tuple(float(adjusted) if j == i else w for j, w in enumerate(weights))
    return tuple(weights)


def mu_form(method: GLM) -> StepForm:
    """Return the symplectic form with M_ij + M_ji = 1 exactly; see the module's docstring."""
    s = method.s
    A, b = as_balls(method.A), as_balls(method.B)[0]
    M = [[0.5 if i == j else 0.0 for j in range(s)] for i in range(s)]
    for i in range(s):
        for j in range(i):
            value = float(A[i][j] / b[j])
            # a grid coarse enough for both value and 1 - value
            unit = math.ulp(max(abs(value), abs(1 - value), 0.5))
            M[i][j] = round(value / unit) * unit
            M[j][i] = 1.0 - M[i][j]
    rounded = consistent_weights([float(x) for x in b], [1.0] * s)
    blocks = dependency_blocks(s, lambda i, j: M[i][j] != 0)
    one = Rows(
        U=((1.0,),) * s, M=tuple(tuple(row) for row in M), weights=rounded, V=((1.0,),),
        R=((1.0,) * s,), R_residue=((0.0,) * s,), large=(True,),
        to_form=((1.0,),), from_form=((1.0,),),
    )  # fmt: skip
    return StepForm("mu", False, (one,), blocks, floats(stage_times(method)), G=((1.0,),))


def standard_form(method: Any) -> StepForm:
    """Return A, U, B, V as given, with the rounding residuals of B."""
    components = []
    for one in method.components:
        R, residue = split_rows(one.B)
        r, identity = len(one.V), float_rows(linalg.identity(len(one.V)))
        components.append(Rows(
            float_rows(one.U), float_rows(one.A), (1.0,) * len(one.U), float_rows(one.V), R,
            residue, large(preconsistency_vector(one), r), identity, identity,
        ))  # fmt: skip
    c = floats(stage_times(method)) if method.parts == 1 else ()
    blocks = method.stage_blocks(SEPARABLE if method.parts > 1 else None)
    return StepForm("standard", False, tuple(components), blocks, c)


def shared_form(method: Any) -> StepForm:
    """Return the same of a pair whose stages are evaluated together: no Q_i without its P_i.

    Where Q_i needs the slope at (Q_i, P_i) and P_i does not, q' = f(p) is known in time, and no
    equation is solved.
    """
    form, c = standard_form(method), floats(method.times[0])
    blocks = tuple(replace(block, implicit=False) for block in method.stage_blocks())
    return replace(form, blocks=blocks, together=True, same_point=same_point(method), c=c)


def explicit_after_velocity(method: Any) -> bool:
    """Return whether a pair solves no equation on q' = f(p), p' = g(q, p).

    So it is where P_i needs no slope of its own stage; Q_i may.
    """
    A = method.components[1].A
    return method.shared and all(
        len(block.stages) == 1 and A[block.stages[0]][block.stages[0]].is_zero() is True
        for block in method.stage_blocks()
    )


def same_point(method: Any) -> bool:
    """Return whether the last point of a step is the first one of the next, the solution."""
    return all(_ends_where_it_begins(one) for one in method.components)


def _ends_where_it_begins(one: Any) -> bool:
    """Return whether the first stage is the solution, and the last one that after the step."""
    if len(one.A) < 2:
        return False
    w = (output(one),)
    ends = (
        (one.A[0], (Exact(0),) * len(one.A[0])), (one.U[0], w[0]),
        (one.A[-1], linalg.matmul(w, one.B)[0]), (one.U[-1], linalg.matmul(w, one.V)[0]),
    )  # fmt: skip
    return all((x - y).is_zero() is True for a, b in ends for x, y in zip(a, b, strict=True))


def large(u: Sequence[Scalar] | None, r: int) -> tuple[bool, ...]:
    """Return which values are multiples of the solution: u_k is not 0 (all without a u)."""
    if u is None:
        return (True,) * r
    return tuple(x.magnitude() > CLOSE for x in u)


def failing(checks: Mapping[str, Matrix]) -> str:
    """Return the first of some identities that does not hold, given their defects; or ``""``."""
    failed = [name for name, defect in checks.items() if not all_vanish(defect)]
    return f"{failed[0]} does not hold" if failed else ""


def scaled_rows(factors: Sequence[Scalar], matrix: Matrix) -> Matrix:
    """Return ``diag(factors) matrix``."""
    return tuple(tuple(d * x for x in row) for d, row in zip(factors, matrix, strict=True))


def float_rows(matrix: Matrix) -> tuple[Row, ...]:
    """Round a matrix."""
    return tuple(floats(row) for row in matrix)


def floats(row: Sequence[Scalar]) -> Row:
    """Round; what is zero to :data:`CLOSE` is zero."""
    return tuple(0.0 if x.magnitude() < CLOSE else as_double(x) for x in row)
