"""Kernels for partitioned pairs on separable problems: q' = dq(p), p' = dp(q).

Stages Q (where dp is evaluated) and P (where dq is) come one after another; each function is called
only where its stage is due. With L = h d k(Q) and L = h d f(P) the *sweep* of a G-symplectic pair

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

from .. import linalg
from ..claims import UsageError
from ..exact import ball, exact
from ..linalg import Matrix
from ..method import PartitionedGLM
from ..rounding import split_float
from .codegen import Builder, KernelSource, Options, choose_kind, header
from .emit import ArrayTarget, ScalarTarget, Target, Writer
from .forms import Row, all_vanish, changed_basis, float_rows, floats, large, vanishes
from .reference import pair_blocks
from .shape import Shape
from .sweep import integral_basis
from .tableau import StageBlock, as_balls, preconsistency
from .values import Values, linear

__all__ = ["PairForm", "pair_form", "pair_source"]


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
    def memory_rows(self) -> int:
        """Number of increments kept from step to step."""
        return len(self.memory_weights)

    @property
    def memory_weights(self) -> Row:
        """Weights of the increments kept from step to step, of Q and then of P stages."""
        return self.Q.weights + self.P.weights if self.implicit_stages else ()

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
    blocks = pair_blocks(pair)
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

    u = preconsistency(pair.U, pair.V)
    u_ = preconsistency(pair.U_hat, pair.V_hat)
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

    ones = (float_rows(linalg.identity(pair.r)), float_rows(linalg.identity(pair.r_hat)))
    return PairForm(
        kind="standard", running=False, r=pair.r, r_hat=pair.r_hat,
        Q=half("Q", pair.U, pair.A, pair.B_hat), P=half("P", pair.U_hat, pair.A_hat, pair.B),
        V=float_rows(pair.V), V_hat=float_rows(pair.V_hat), blocks=blocks,
        large=large(preconsistency(pair.U, pair.V), pair.r),
        large_hat=large(preconsistency(pair.U_hat, pair.V_hat), pair.r_hat),
        to_form=ones, from_form=ones,
    )  # fmt: skip


def pair_source(form: PairForm, shape: Shape, options: Options) -> KernelSource:
    """Generate the module for a pair on a separable problem."""
    kind = choose_kind(form.Q.n + form.P.n, shape, options)
    writer = Writer()
    target: Target = (ScalarTarget if kind == "scalar" else ArrayTarget)(shape, writer)
    PairBuilder(form, shape, options, target).kernel()
    title = f'"""Generated kernel: pair, {form.kind} form, {form.P.n} P and {form.Q.n} Q stages."""'
    head = header(shape, kind, newton=False)
    text, rows = title + "\n\n" + head + writer.text, max(form.r, form.r_hat)
    return KernelSource(text, target.work_size, rows, form.memory_rows, kind)


class PairBuilder(Builder):
    """Writes one kernel for a pair; y{k} holds q_k in its left and p_k in its right half.

    Stage vectors are numbered by node: Q_j is j, P_i is n_Q + i. L of a Q stage lives in the right
    half (it updates p), L of a P stage in the left.
    """

    form: PairForm  # type: ignore[assignment]

    def __init__(self, form: PairForm, shape: Shape, options: Options, target: Target) -> None:
        super().__init__(form, shape, options, target)  # type: ignore[arg-type]
        m, d = shape.half, shape.dimension
        kinds = {"running": form.running, "compensated": options.compensated}
        P, Q = form.P, form.Q
        self.sides = (
            Values(target, form.V, P.R, P.R_residue, form.large, (0, m), **kinds),
            Values(target, form.V_hat, Q.R, Q.R_residue, form.large_hat, (m, d), **kinds),
        )

    def _rows(self) -> int:
        return max(self.form.r, self.form.r_hat)

    def _declare(self) -> None:
        if isinstance(self.t, ScalarTarget):
            at_q = [
                j for b in self.form.blocks if b.implicit for j in b.stages if j < self.form.Q.n
            ]
            self.w(*(f"{self.t.ref(f'Y{j}', c)} = 0.0" for j in at_q for c in range(*self.watched)))

    def _state(self) -> list[str]:
        letters = "ye" if self.options.compensated else "y"
        names = [f"{letter}{k}" for letter in letters for k in range(self._rows())]
        return names + [f"L{i}" for i in range(self.form.memory_rows)]

    def _scaled_weights(self) -> None:
        for half, shift in ((self.form.Q, 0), (self.form.P, self.form.Q.n)):
            for i, weight in enumerate(half.weights):
                self.w(f"hw{i + shift} = h" if weight == 1.0 else f"hw{i + shift} = h*{weight!r}")

    def _record(self) -> None:
        for part, basis in zip((0, 1), self.form.from_form, strict=True):
            low, high = ((0, self.shape.half), (self.shape.half, self.shape.dimension))[part]
            for k in range(len(basis)) if self.options.history else range(1):
                terms = [(x, f"@y{j}") for j, x in enumerate(basis[k])]
                self._output(k, terms, (low, high))

    def _begin(self) -> None:
        for values in self.sides:
            values.begin()

    def _blocks(self) -> None:
        done: list[int] = []
        for block in self.form.blocks:
            if block.implicit:
                self._implicit(block.stages, done)
            else:
                self._node(block.stages[0], done)
            done += block.stages
        self._evaluations_of_explicit_stages()

    def _side(self, node: int) -> tuple[Half, int, int]:
        """(half, index within it, side of the values it is read from: 0 for q, 1 for p)."""
        n = self.form.Q.n
        return (self.form.Q, node, 0) if node < n else (self.form.P, node - n, 1)

    def _base_of(self, node: int, done: Sequence[int]) -> tuple[str, str]:
        """z and a of a stage from values and from increments already known."""
        half, i, side = self._side(node)
        big, small = self.sides[side].read(half.U[i])
        if not self.form.running:
            # a Q stage reads increments of P stages, and the other way round
            n = self.form.Q.n
            others = [j for j in done if (j < n) != (node < n)]
            small += [(half.M[i][j if j < n else j - n], f"@L{j}") for j in others]
        return self._named(node, big, small, self.sides[side].part)

    def _node(self, node: int, done: Sequence[int]) -> None:
        """One explicit stage: its value, its function, its increment."""
        _, i, side = self._side(node)
        z, a = self._base_of(node, done)
        text = z if a == "0.0" else f"{z} + {a}"
        self.t.vec([f"@Y{node} = {text}"], self.sides[side].part)
        self._call(node)
        if self.form.running:
            self.sides[1 - side].add(i, f"@L{node}")

    def _call(self, node: int) -> None:
        """L of a stage from its value Y."""
        _, _, side = self._side(node)
        self.t.call(self.shape.parts[1 - side], f"Y{node}", f"F{node}", f"s{node}")
        self.t.vec([f"@L{node} = hw{node}*@F{node}"], self.sides[1 - side].part)

    def _evaluations_of_explicit_stages(self) -> None:
        n = self.form.Q.n
        single = [b.stages[0] for b in self.form.blocks if not b.implicit]
        forces = sum(1 for node in single if node < n)
        self.w(f"evaluations += {forces}")
        if not self.shape.parts[0].identity:
            self.w(f"velocities += {len(single) - forces}")

    def _implicit(self, nodes: Sequence[int], done: Sequence[int]) -> None:
        """Stages that depend on each other: rounds P -> dq -> Q -> dp until Q is settled."""
        w, n = self.w, self.form.Q.n
        at_q, at_p = [j for j in nodes if j < n], [j for j in nodes if j >= n]
        bases = {node: self._base_of(node, done) for node in nodes}

        def values(group: Sequence[int], others: Sequence[int], name: str) -> None:
            for node in group:
                half, i, side = self._side(node)
                z, a = bases[node]
                terms = [(half.M[i][j if j < n else j - n], f"@L{j}") for j in others]
                text = linear(terms if a == "0.0" else [(1.0, a), *terms])
                self.t.vec([f"@{name}{node} = {z} + ({text})"], self.sides[side].part)

        self._sizes(at_p, [bases[j][0] for j in at_q])
        w("last_change = 1e300", "stalls = 0", "rounds = 0")
        with w.block("while True:"):
            values(at_p, at_q, "Y")
            for node in at_p:
                self._call(node)
            values(at_q, at_p, "N")
            self._compare(at_q)
            for node in at_q:
                self._call(node)
        w("iterations += rounds", f"evaluations += {len(at_q)}*rounds")
        if not self.shape.parts[0].identity:
            w(f"velocities += {len(at_p)}*(rounds + 1)")
        with w.block("if outcome != 0:"):
            w("break")

    def _commit(self) -> None:
        n = self.form.Q.n
        names = ([f"@L{n + i}" for i in range(self.form.P.n)], [f"@L{j}" for j in range(n)])
        for values, increments, check in zip(
            self.sides, names, ("check_q", "check_p"), strict=True
        ):
            values.finish(increments)
            values.check(check)
        self._finite("check_q + check_p")
        for values in self.sides:
            self._accept(values)
