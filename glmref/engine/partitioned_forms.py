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
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..errors import UsageError
from ..exact import ball, exact, linalg
from ..exact.linalg import Matrix
from ..method import PartitionedGLM
from ..method.component import SEPARABLE
from ..method.solution_value import preconsistency_vector
from ..method.stage_order import StageBlock
from .forms import (
    Form,
    Row,
    all_vanish,
    changed_basis,
    failing,
    float_rows,
    floats,
    large,
    scaled_rows,
    split_rows,
    vanishes,
)
from .sweep import integral_basis
from .tableau import as_balls


@dataclass(frozen=True)
class Half:
    """One half of a pair in double precision: its own stages and values.

    Attributes
    ----------
    letter : str
        ``"Q"`` for the stages Q, with the updates of p; ``"P"`` for P, with those of q.
    n : int
        Number of stages.
    r : int
        Number of values they are read from.
    U : tuple[Row, ...]
        (n, r) from those values.
    M : tuple[Row, ...]
        (n, n') from the increments of the other half.
    R : tuple[Row, ...]
        (r', n) updates of the other values; R_residue what its rounding lost.
    weights : Row
        (n,).
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
class PairForm(Form):
    """Coefficients of a pair, ready for code generation; see :class:`.sweep.StepForm`.

    Attributes
    ----------
    Q, P : Half
        The two halves.
    V, V_hat : tuple[Row, ...]
        (r, r) and (r^, r^).
    blocks : tuple[StageBlock, ...]
        Nodes in the order of computation, Q stages 0..n_Q-1, then P stages.
    kick : Row
        What is carried in place of value k of p is p_k + kick_k h dp(q), see :func:`merged` and
        :func:`_merged_multistep`; empty where values are carried as they are.
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
    kick: Row = ()

    @property
    def rows(self) -> int:
        """See :class:`.forms.Form`: the longer half."""
        return max(self.r, self.r_hat)

    @property
    def reuses_force(self) -> bool:
        """Whether the first stage Q of a step is the last one of the step before.

        So it is for one value each where a step begins and ends with an update of p, and for one
        value of q and several of p where the last stage is the new q.
        """
        n = self.Q.n
        first, last = self.blocks[0].stages[0], self.blocks[-1].stages[0]
        if (
            self.r > 1
            or n < 2
            or max(first, last) >= n
            or self.V != ((1.0,),)
            or self.implicit_stages
        ):
            return False
        if self.Q.U[first] != (1.0,) or self.Q.U[last] != (1.0,):
            return False
        if self.running:
            return self.r_hat == 1 and self.V_hat == ((1.0,),)
        return not any(self.Q.M[first]) and self.Q.M[last] == self.P.R[0]

    @property
    def keeps_force(self) -> bool:
        """Whether the last force of a step is kept: for the next step, or to read p from it."""
        return bool(self.kick) or self.reuses_force

    @property
    def leaps(self) -> bool:
        """Whether a step is q+ = q + h p, p+ = p + h dp(q+) in the values carried.

        Then, with q' = p, what q moves by in the coming step is kept in the left half of the row
        of the force, see :meth:`.partitioned.PairBuilder`.
        """
        ones = ((1.0,),)
        return (
            len(self.kick) == 1
            and self.V == self.V_hat == ones
            and all((half.n, half.U, half.R) == (1, ones, ones) for half in (self.Q, self.P))
        )

    @property
    def forces(self) -> int:
        """Forces evaluated in a step by stages that need no equation solved."""
        single = [b.stages[0] for b in self.blocks if not b.implicit]
        return sum(1 for node in single if node < self.Q.n) - self.reuses_force

    @cached_property
    def kept_hat(self) -> tuple[bool, ...]:
        """Which values of p are kept together with their rounding errors.

        All but those that oscillate in a multistep method with merged kicks. Their sums V y have
        factors like 2 cos(theta), whose products are rounded and not put back, so that the error
        of the last addition alone is not worth its operations; no multiple of the solution is
        among them, and their errors do not add up.
        """
        kept = [True] * self.r_hat
        for k, row in enumerate(self.V_hat) if len(self.kick) > 1 else ():
            before = [j for j, x in enumerate(row) if x]
            kept[k] = all(abs(row[j]) == 1.0 and (j == k or kept[j]) for j in before)
        return tuple(kept)

    def kicked(self, p: np.ndarray, force: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
        """p + kick h force and what its rounding lost (Knuth's TwoSum).

        Parameters
        ----------
        p : np.ndarray
            (..., r^, m) values of p.
        force : np.ndarray
            (..., m).
        """
        more = self._kicks(force, h)
        total = p + more
        share = total - p
        lost = (p - (total - share)) + (more - share)
        return total, np.where(np.array(self.kept_hat)[:, None], lost, 0.0)

    def unkicked(
        self, p: np.ndarray, rest: np.ndarray | float, force: np.ndarray, h: float
    ) -> np.ndarray:
        """Take :meth:`kicked` back."""
        return p + (rest - self._kicks(force, h))

    def _kicks(self, force: np.ndarray, h: float) -> np.ndarray:
        return h * np.array(self.kick)[:, None] * force[..., None, :]

    @property
    def memory(self) -> tuple[tuple[str, float | None], ...]:
        """What is kept from step to step: increments and weights, or a force (weight ``None``)."""
        if self.keeps_force:
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

    Parameters
    ----------
    form : str
        ``"auto"``, ``"sweep"`` or ``"standard"``.

    Raises
    ------
    UsageError
        For complex coefficients, or a form that does not apply.
    """
    name = pair.name or "the pair"
    if not pair.is_real:
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
    (A, U, B, V), (A_, U_, B_, V_) = (map(as_balls, c.matrices) for c in pair.components)
    T, product = linalg.transpose, linalg.matmul
    left = linalg.add(scaled_rows(D_P, A_), T(scaled_rows(D_Q, A)))
    checks = {
        "V^T G V^ = G": linalg.sub(product(T(V), G, V_), G),
        "D_P U^ = B^T G V^": linalg.sub(scaled_rows(D_P, U_), product(T(B), G, V_)),
        "D_Q U = B^^T G^T V": linalg.sub(scaled_rows(D_Q, U), product(T(B_), T(G), V)),
        "D_P A^ + A^T D_Q = B^T G B^": linalg.sub(left, product(T(B), G, B_)),
    }
    return failing(checks)


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
    omega, omega_ = (
        float_rows(tuple(tuple(x / d for x, d in zip(row, D, strict=True)) for row in rows))
        for rows, D in ((B, D_P), (B_, D_Q))
    )
    n_q, n_p, r = pair.n_Q, pair.n_P, pair.r

    def half(letter: str, n: int, rows: tuple[Row, ...], D: Sequence, other: int) -> Half:
        U = tuple(zip(*rows, strict=True))
        zero = ((0.0,) * n,) * r
        return Half(letter, n, r, U, ((0.0,) * other,) * n, rows, zero, floats(D))

    u, u_ = map(preconsistency_vector, pair.components)
    V, V_ = as_balls(pair.V), as_balls(pair.V_hat)
    back_p = linalg.inverse(to_p)
    form = PairForm(
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
    return merged(form)


def merged(form: PairForm) -> PairForm:
    """Put the last update of p of a step and the first one of the next together, where both are.

    The step then begins with an update of q, and what it carries is p + kick h dp(q): one operation
    less for every component, and a shorter chain from step to step. Positions are those of the
    method, up to rounding; p is read by taking the kick back.
    """
    ones = ((1.0,),)
    if not form.reuses_force or form.to_form != (ones, ones) or form.from_form != (ones, ones):
        return form
    first, last = form.blocks[0].stages[0], form.blocks[-1].stages[0]
    kick = form.Q.weights[first]
    if form.Q.weights[last] != kick or first != 0 or set(form.Q.R[0]) != {1.0}:
        return form
    weights = tuple(w + kick if j == last else w for j, w in enumerate(form.Q.weights))
    Q = replace(form.Q, weights=weights)
    return _without_first(replace(form, Q=Q), (kick,))


def _without_first(form: PairForm, kick: Row) -> PairForm:
    """The form without its first stage Q, whose force is in the values that are carried."""
    Q = replace(
        form.Q, n=form.Q.n - 1, U=form.Q.U[1:], M=form.Q.M[1:], weights=form.Q.weights[1:],
        R=tuple(row[1:] for row in form.Q.R),
        R_residue=tuple(row[1:] for row in form.Q.R_residue),
    )  # fmt: skip
    P = replace(form.P, M=tuple(row[1:] for row in form.P.M))
    blocks = tuple(replace(b, stages=tuple(j - 1 for j in b.stages)) for b in form.blocks[1:])
    return replace(form, Q=Q, P=P, blocks=blocks, kick=kick)


def _merged_multistep(form: PairForm, pair: PartitionedGLM) -> PairForm:
    """:func:`merged` for one value of q and several of p, as a symmetric multistep method has them.

    Let k be what the last force adds to the values of p. Where the first one adds V^ k to them, and
    U^ k to every stage P, the values p + k h dp(q) are carried by V^ and 2 k h dp(q) alone, and
    the stages P are read from them as they stand: a step is a rotation and a kick.
    """
    if form.running or form.r_hat == 1 or not form.reuses_force:
        return form
    first, last = form.blocks[0].stages[0], form.blocks[-1].stages[0]
    A, U, B, V = map(as_balls, pair.components[1].matrices)
    k = tuple((row[last],) for row in B)
    begins = linalg.sub(linalg.matmul(V, k), tuple((row[first],) for row in B))
    read = linalg.sub(linalg.matmul(U, k), tuple((row[first],) for row in A))
    kick = tuple(row[last] for row in form.Q.R)
    exactly = not any(row[last] for row in form.Q.R_residue)
    if first != 0 or not exactly or not all_vanish(begins) or not all_vanish(read):
        return form

    def twice(rows: tuple[Row, ...]) -> tuple[Row, ...]:
        return tuple((*row[:last], 2 * row[last], *row[last + 1 :]) for row in rows)

    return _without_first(replace(form, Q=replace(form.Q, R=twice(form.Q.R))), kick)


def _standard(pair: PartitionedGLM, blocks: tuple[StageBlock, ...]) -> PairForm:
    def half(letter: str, U: Matrix, A: Matrix, B: Matrix) -> Half:
        (R, residue), n = split_rows(B), len(U)
        return Half(letter, n, len(U[0]), float_rows(U), float_rows(A), R, residue, (1.0,) * n)

    u, u_ = map(preconsistency_vector, pair.components)
    ones = (float_rows(linalg.identity(pair.r)), float_rows(linalg.identity(pair.r_hat)))
    form = PairForm(
        kind="standard", running=False, r=pair.r, r_hat=pair.r_hat,
        Q=half("Q", pair.U, pair.A, pair.B_hat), P=half("P", pair.U_hat, pair.A_hat, pair.B),
        V=float_rows(pair.V), V_hat=float_rows(pair.V_hat), blocks=blocks,
        large=large(u, pair.r),
        large_hat=large(u_, pair.r_hat),
        to_form=ones, from_form=ones,
    )  # fmt: skip
    return _merged_multistep(form, pair)
