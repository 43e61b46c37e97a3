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
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..exact import Scalar, linalg
from ..exact.linalg import Matrix
from ..method import GLM
from ..method.rounding import split_float
from ..method.solution_value import preconsistency_vector, stage_times
from ..method.stage_order import StageBlock, dependency_blocks
from .tableau import as_balls

#: A number this close to an integer or to zero counts as one in the float engine.
CLOSE = 1e-40

Row = tuple[float, ...]


class Form:
    """What the coefficients of all methods have."""

    blocks: tuple[StageBlock, ...]
    r: int

    @property
    def rows(self) -> int:
        """Rows of values in the state of a kernel."""
        return self.r

    @property
    def implicit_stages(self) -> int:
        """Number of stages that need an equation solved."""
        return sum(len(block.stages) for block in self.blocks if block.implicit)


@dataclass(frozen=True)
class StepForm(Form):
    """Double precision coefficients of one step, ready for code generation.

    Attributes
    ----------
    kind : str
        ``"sweep"``, ``"mu"`` or ``"standard"``.
    s, r : int
        Numbers of stages and values.
    running : bool
        Whether the updates R L are added to x as the stages go (sweep).
    U : tuple[Row, ...]
        (s, r).
    M : tuple[Row, ...]
        (s, s).
    R : tuple[Row, ...]
        (r, s).
    V : tuple[Row, ...]
        (r, r).
    weights : Row
        (s,), the w of the module docstring.
    R_residue : tuple[Row, ...]
        (r, s), exact minus rounded update coefficients (zero in the structural forms).
    M_residue : Row
        (s,), what rounding took from M_ii (sweep; below 1e-20 it is left out).
    c : Row
        (s,) abscissae.
    blocks : tuple[StageBlock, ...]
        Stages in the order of computation.
    large : tuple[bool, ...]
        Values that are multiples of y (u_k != 0); the others are O(h).
    to_form, from_form : tuple[Row, ...]
        (r, r), change of basis: x = to_form @ y and back.
    exact_V : bool
        Whether V is integral, so that V^T G V = G holds without rounding.
    G : tuple[Row, ...] or None
        (r, r) form that a running form conserves, in its basis, or ``None``.
    """

    kind: str
    s: int
    r: int
    running: bool
    U: tuple[Row, ...]
    M: tuple[Row, ...]
    R: tuple[Row, ...]
    V: tuple[Row, ...]
    weights: Row
    R_residue: tuple[Row, ...]
    c: Row
    blocks: tuple[StageBlock, ...]
    large: tuple[bool, ...]
    to_form: tuple[Row, ...]
    from_form: tuple[Row, ...]
    exact_V: bool
    G: tuple[Row, ...] | None = None
    M_residue: Row = ()

    def into(self, values: np.ndarray) -> np.ndarray:
        """(..., r, d) values of the method in the basis of this form."""
        return changed_basis(self.to_form, values)

    def back(self, x: np.ndarray) -> np.ndarray:
        """(..., r, d) values of this form in the basis of the method."""
        return changed_basis(self.from_form, x)

    @property
    def memory(self) -> tuple[tuple[str, float | None], ...]:
        """What the predictor keeps from step to step: names of increments L and their weights."""
        if not self.implicit_stages:
            return ()
        return tuple((f"L{i}", weight) for i, weight in enumerate(self.weights))


def changed_basis(matrix: tuple[Row, ...], values: np.ndarray) -> np.ndarray:
    """``matrix @ values`` over the last two axes, term by term: the same bits for any shape."""
    out = np.zeros_like(values, dtype=float)
    for k, row in enumerate(matrix):
        for j, factor in enumerate(row):
            if factor:
                out[..., k, :] += factor * values[..., j, :]
    return out


def vanishes(x: Scalar) -> bool:
    """Whether nothing speaks against zero: exact zero, or a ball around it."""
    return x.is_zero() is not False


def all_vanish(matrix: Matrix) -> bool:
    """Whether nothing speaks against a zero matrix."""
    return all(vanishes(x) for row in matrix for x in row)


def is_symplectic_rk(method: GLM) -> bool:
    """Whether the method is Runge-Kutta with b_i a_ij + b_j a_ji = b_i b_j and nonzero weights."""
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
    """Symplectic Runge-Kutta with M_ij + M_ji = 1 exactly; see the module's docstring."""
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
    return StepForm(
        kind="mu", s=s, r=1, running=False, U=((1.0,),) * s,
        M=tuple(tuple(row) for row in M), R=((1.0,) * s,), V=((1.0,),), weights=rounded,
        R_residue=((0.0,) * s,), c=floats(stage_times(method)), blocks=blocks,
        large=(True,), to_form=((1.0,),), from_form=((1.0,),), exact_V=True, G=((1.0,),),
    )  # fmt: skip


def standard_form(method: GLM) -> StepForm:
    """A, U, B, V as given, with what rounding B lost."""
    s, r = method.s, method.r
    identity = float_rows(linalg.identity(r))
    R, residue = split_rows(method.B)
    V = float_rows(method.V)
    return StepForm(
        kind="standard", s=s, r=r, running=False, U=float_rows(method.U),
        M=float_rows(method.A), R=R, V=V, weights=(1.0,) * s, R_residue=residue,
        c=floats(stage_times(method)), blocks=method.stage_blocks(),
        large=large(preconsistency_vector(method), r),
        to_form=identity, from_form=identity,
        exact_V=all(x == int(x) for row in V for x in row),
    )  # fmt: skip


def large(u: Sequence[Scalar] | None, r: int) -> tuple[bool, ...]:
    """Which values are multiples of the solution: u_k is not zero (all of them without a u)."""
    if u is None:
        return (True,) * r
    return tuple(x.magnitude() > CLOSE for x in u)


def split_rows(matrix: Matrix) -> tuple[tuple[Row, ...], tuple[Row, ...]]:
    """Round a matrix; and what rounding took from it."""
    pairs = [[split_float(x) for x in row] for row in matrix]
    first, second = (tuple(tuple(pair[k] for pair in row) for row in pairs) for k in (0, 1))
    return first, second


def failing(checks: Mapping[str, Matrix]) -> str:
    """The first of some identities that does not hold, given their defects; or ``""``."""
    failed = [name for name, defect in checks.items() if not all_vanish(defect)]
    return f"{failed[0]} does not hold" if failed else ""


def scaled_rows(factors: Sequence[Scalar], matrix: Matrix) -> Matrix:
    """``diag(factors) matrix``."""
    return tuple(tuple(d * x for x in row) for d, row in zip(factors, matrix, strict=True))


def float_rows(matrix: Matrix) -> tuple[Row, ...]:
    """Round a matrix."""
    return tuple(floats(row) for row in matrix)


def floats(row: Sequence[Scalar]) -> Row:
    """Round; what is zero to :data:`CLOSE` is zero."""
    return tuple(0.0 if x.magnitude() < CLOSE else float(x) for x in row)
