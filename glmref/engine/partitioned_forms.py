"""Coefficients of partitioned pairs for q' = dq(p), p' = dp(q), ready for code generation.

Stages Q are where dp is evaluated, stages P where dq is. With L = h d k(Q) and L = h d f(P) the
*sweep* of a G-symplectic pair

    x = V q;  z = V^ p;   at Q_j:  z += w^_j L, L from Q_j = w^_j . x
                          at P_i:  x += w_i L,  L from P_i = w_i . z

in a basis where the bilinear form is the identity changes <x, z> by exactly Q . L or L . P for any
rounded w, w^; it needs neither A nor U. Pairs without G and D, or whose stages have to be solved
for, are stepped with their own A and U.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from ..exact import ball, exact, linalg
from ..exact.linalg import Matrix
from ..method import PartitionedGLM
from ..method.component import SEPARABLE
from ..method.rounding import split_float
from ..method.solution_value import preconsistency_vector
from ..method.stage_order import StageBlock
from .forms import Row, all_vanish, changed_basis, float_rows, floats, large, vanishes
from .sweep import integral_basis
from .tableau import as_balls

__all__ = ["Half", "PairForm", "pair_form"]


@dataclass(frozen=True)
class Half:
    """One half of a pair in double precision: its own stages and values.

    Attributes
    ----------
        letter: ``"Q"`` for the stages Q, with the updates of p; ``"P"`` for P, with those of q.
        n: number of stages. r: number of values they are read from.
        U: (n, r) from those values; M: (n, n') from the increments of the other half.
        R: (r', n) updates of the other values; R_residue what its rounding lost.
        weights: (n,).
    """

    letter: str
    n: int
    r: int
    U: tuple[Row, ...]
    M: tuple[Row, ...]
    R: tuple[Row, ...]
    R_residue: tuple[Row, ...]
    weights: Row


@dataclass(frozen=True)
class PairForm:
    """Coefficients of a pair, ready for code generation; see :class:`.sweep.StepForm`.

    Attributes
    ----------
        Q, P: the two halves.
        V, V_hat: (r, r) and (r^, r^).
        blocks: nodes in the order of computation, Q stages 0..n_Q-1, then P stages.
    """

    kind: str
    running: bool
    r: int
    r_hat: int
    Q: Half
    P: Half
    V: tuple[Row, ...]
    V_hat: tuple[Row, ...]
    blocks: tuple[StageBlock, ...]
    large: tuple[bool, ...]
    large_hat: tuple[bool, ...]
    to_form: tuple[tuple[Row, ...], tuple[Row, ...]]
    from_form: tuple[tuple[Row, ...], tuple[Row, ...]]

    @property
    def implicit_stages(self) -> int:
        """Number of stages that need an equation solved."""
        return sum(len(block.stages) for block in self.blocks if block.implicit)

    @property
    def reuses_force(self) -> bool:
        """Whether the first stage Q of a step is the last one of the step before.

        So it is for one value each where a step begins and ends with an update of p.
        """
        n = self.Q.n
        ends = self.blocks[0].stages[0], self.blocks[-1].stages[0]
        one = self.r == self.r_hat == 1 and self.running and n > 1
        if not one or max(ends) >= n or not self.V == self.V_hat == ((1.0,),):
            return False
        return all(self.Q.U[j] == (1.0,) for j in ends)

    @property
    def memory(self) -> tuple[tuple[str, float | None], ...]:
        """What is kept from step to step: increments and weights, or a force (weight ``None``)."""
        if self.reuses_force:
            return (("G", None),)
        if not self.implicit_stages:
            return ()
        return tuple((f"L{i}", w) for i, w in enumerate(self.Q.weights + self.P.weights))

    def into(self, values: np.ndarray) -> np.ndarray:
        """Values of the method, q in the left half of the columns, in the basis of this form."""
        return self._moved(values, self.to_form)

    def back(self, x: np.ndarray) -> np.ndarray:
        """Values of this form in the basis of the method."""
        return self._moved(x, self.from_form)

    def _moved(self, values: np.ndarray, bases: Sequence[tuple[Row, ...]]) -> np.ndarray:
        m, out = values.shape[-1] // 2, np.zeros_like(values, dtype=float)
        for basis, columns in zip(bases, (slice(0, m), slice(m, None)), strict=True):
            rows = len(basis)
            out[..., :rows, columns] = changed_basis(basis, values[..., :rows, columns])
        return out


def pair_form(pair: PartitionedGLM, form: str = "auto") -> PairForm:
    """Sweep where the pair is G-symplectic and explicit, else A, U, B, V as given.

    Args:
        form: ``"auto"``, ``"sweep"`` or ``"standard"``.

    Raises
    ------
        UsageError: for complex coefficients, or a form that does not apply.
    """
    name = pair.name or "the pair"
    matrices = [getattr(pair, x + y) for x in "AUBV" for y in ("", "_hat")]
    if not all(x.is_real() for matrix in matrices for row in matrix for x in row):
        raise UsageError(f'{name} has complex coefficients; use engine="reference"')
    if form not in ("auto", "sweep", "standard"):
        raise UsageError(f"`form` of a pair must be auto, sweep or standard, got {form!r}")
    blocks = pair.stage_blocks(SEPARABLE)
    if form != "standard":
        reason = _obstacle(pair, blocks)
        if not reason:
            return _sweep(pair, blocks)
        if form == "sweep":
            raise UsageError(f"{name} has no sweep form: {reason}")
    return _standard(pair, blocks)


def _bilinear(pair: PartitionedGLM) -> tuple[Matrix, Sequence, Sequence] | None:
    """(G, D_P, D_Q) of the pair: as given, or (1, b, b^) for one value each."""
    if pair.G is not None and pair.D_P is not None and pair.D_Q is not None:
        return pair.G, pair.D_P, pair.D_Q
    if pair.r == pair.r_hat == 1:
        return ((exact(1),),), pair.B[0], pair.B_hat[0]
    return None


def _obstacle(pair: PartitionedGLM, blocks: tuple[StageBlock, ...]) -> str:
    """Return why there is no sweep, or ``""``; identities in ball arithmetic."""
    if any(block.implicit for block in blocks):
        return "its stages depend on each other"
    found = _bilinear(pair)
    if found is None:
        return "G, D_P and D_Q are not given"
    G, D_P, D_Q = as_balls(found[0]), [ball(x) for x in found[1]], [ball(x) for x in found[2]]
    if pair.r != pair.r_hat:
        return "the numbers of values of q and p differ"
    if any(vanishes(x) for x in (*D_P, *D_Q)):
        return "D has a zero"
    names = [x + y for x in "AUBV" for y in ("", "_hat")]
    A, A_, U, U_, B, B_, V, V_ = (as_balls(getattr(pair, name)) for name in names)
    T, product = linalg.transpose, linalg.matmul

    def scaled(D: Sequence, matrix: Matrix) -> Matrix:
        return tuple(tuple(d * x for x in row) for d, row in zip(D, matrix, strict=True))

    left = linalg.add(scaled(D_P, A_), T(scaled(D_Q, A)))
    checks = {
        "V^T G V^ = G": linalg.sub(product(T(V), G, V_), G),
        "D_P U^ = B^T G V^": linalg.sub(scaled(D_P, U_), product(T(B), G, V_)),
        "D_Q U = B^^T G^T V": linalg.sub(scaled(D_Q, U), product(T(B_), T(G), V)),
        "D_P A^ + A^T D_Q = B^T G B^": linalg.sub(left, product(T(B), G, B_)),
    }
    failed = [name for name, defect in checks.items() if not all_vanish(defect)]
    return f"{failed[0]} does not hold" if failed else ""


def _sweep(pair: PartitionedGLM, blocks: tuple[StageBlock, ...]) -> PairForm:
    found = _bilinear(pair)
    assert found is not None
    G, D_P, D_Q = as_balls(found[0]), [ball(x) for x in found[1]], [ball(x) for x in found[2]]
    # q in a basis where V is integral (unscaled: the form pairs q with p), p in the dual one
    back = integral_basis(as_balls(pair.V), linalg.identity(pair.r))
    to_q = linalg.inverse(back)
    to_p = linalg.matmul(linalg.transpose(back), G)
    B = linalg.matmul(to_q, as_balls(pair.B))
    B_ = linalg.matmul(to_p, as_balls(pair.B_hat))
    omega = float_rows(tuple(tuple(x / d for x, d in zip(row, D_P, strict=True)) for row in B))
    omega_ = float_rows(tuple(tuple(x / d for x, d in zip(row, D_Q, strict=True)) for row in B_))
    n_q, n_p, r = pair.n_Q, pair.n_P, pair.r

    def half(letter: str, n: int, rows: tuple[Row, ...], D: Sequence, other: int) -> Half:
        U = tuple(zip(*rows, strict=True))
        zero = ((0.0,) * n,) * r
        return Half(letter, n, r, U, ((0.0,) * other,) * n, rows, zero, floats(D))

    u, u_ = map(preconsistency_vector, pair.components)
    V, V_ = as_balls(pair.V), as_balls(pair.V_hat)
    back_p = linalg.inverse(to_p)
    return PairForm(
        kind="sweep", running=True, r=r, r_hat=r,
        Q=half("Q", n_q, omega_, D_Q, n_p), P=half("P", n_p, omega, D_P, n_q),
        V=float_rows(linalg.matmul(to_q, V, back)),
        V_hat=float_rows(linalg.matmul(to_p, V_, back_p)),
        blocks=blocks,
        large=large(None if u is None else linalg.matvec(to_q, u), r),
        large_hat=large(None if u_ is None else linalg.matvec(to_p, u_), r),
        to_form=(float_rows(to_q), float_rows(to_p)),
        from_form=(float_rows(back), float_rows(back_p)),
    )  # fmt: skip


def _standard(pair: PartitionedGLM, blocks: tuple[StageBlock, ...]) -> PairForm:
    def half(letter: str, U: Matrix, A: Matrix, B: Matrix) -> Half:
        pairs = [[split_float(x) for x in row] for row in B]
        R = tuple(tuple(x for x, _ in row) for row in pairs)
        residue = tuple(tuple(x for _, x in row) for row in pairs)
        n = len(U)
        return Half(letter, n, len(U[0]), float_rows(U), float_rows(A), R, residue, (1.0,) * n)

    u, u_ = map(preconsistency_vector, pair.components)
    ones = (float_rows(linalg.identity(pair.r)), float_rows(linalg.identity(pair.r_hat)))
    return PairForm(
        kind="standard", running=False, r=pair.r, r_hat=pair.r_hat,
        Q=half("Q", pair.U, pair.A, pair.B_hat), P=half("P", pair.U_hat, pair.A_hat, pair.B),
        V=float_rows(pair.V), V_hat=float_rows(pair.V_hat), blocks=blocks,
        large=large(u, pair.r),
        large_hat=large(u_, pair.r_hat),
        to_form=ones, from_form=ones,
    )  # fmt: skip
