"""Generated source for Newton's method on the stage equations L = h w f(Y(L)).

Two kinds. *Inline*, for one stage at a time with at most :data:`INLINE_LIMIT` unknowns: the matrix
I - h w M J is written out entry by entry and evaluated afresh at the predicted stage. *Factored*:
the Jacobian is evaluated once, the matrices of all blocks are factored (equal ones share), and they
are kept from step to step until a solve needs more than :data:`REFRESH_ROUNDS` rounds. On a
separable problem the unknown is the p part of L and J is the product K J_f of the two halves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .emit import ScalarTarget, Target, Writer
from .forms import StepForm
from .shape import Shape, inlined, jacobian_block, parameter_names

if TYPE_CHECKING:
    from .codegen import Options

__all__ = ["HELPERS", "INLINE_LIMIT", "REFRESH_ROUNDS", "NewtonWriter"]

INLINE_LIMIT = 3
REFRESH_ROUNDS = 5

#: Dense elimination with partial pivoting on the transposed matrix: a[j, i] is entry (i, j), so
#: that every inner loop runs along memory and no sum has to be reordered to be fast. The diagonal
#: holds reciprocals.
HELPERS = """
@compiled
def factor(a, pivots):
    n = len(pivots)
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(a[k, i]) > abs(a[k, p]):
                p = i
        pivots[k] = p
        if p != k:
            for j in range(n):
                held = a[j, k]
                a[j, k] = a[j, p]
                a[j, p] = held
        a[k, k] = 1.0 / a[k, k]
        for i in range(k + 1, n):
            a[k, i] = a[k, i] * a[k, k]
        for j in range(k + 1, n):
            ratio = a[j, k]
            if ratio != 0.0:
                for i in range(k + 1, n):
                    a[j, i] -= a[k, i] * ratio


@compiled
def eliminate(a, pivots, b):
    n = len(pivots)
    for k in range(n):
        p = int(pivots[k])
        held = b[k]
        b[k] = b[p]
        b[p] = held
    for j in range(n):
        known = b[j]
        for i in range(j + 1, n):
            b[i] -= a[j, i] * known
    for j in range(n - 1, -1, -1):
        known = b[j] * a[j, j]
        b[j] = known
        for i in range(j):
            b[i] -= a[j, i] * known
"""


class NewtonWriter:
    """The part of a stage writer that knows Newton's method."""

    form: StepForm
    shape: Shape
    options: Options
    t: Target
    w: Writer
    inner: tuple[int, int]
    unknowns: int

    def _time(self, i: int) -> None:
        raise NotImplementedError

    @property
    def inline_newton(self) -> bool:
        """Whether the Newton matrix of a single stage is written out."""
        return (
            self.options.solver == "newton"
            and isinstance(self.t, ScalarTarget)
            and self.unknowns <= INLINE_LIMIT
            and self.shape.jacobian is not None
            and all(len(block.stages) == 1 for block in self.form.blocks if block.implicit)
        )

    @property
    def factored_newton(self) -> bool:
        """Whether factored matrices are kept in the work array."""
        return (
            self.options.solver == "newton"
            and self.form.implicit_stages > 0
            and not self.inline_newton
        )

    def _coupling(self, stages: Sequence[int]) -> list[list[tuple[float, str]]]:
        """Factors of the reduced Jacobian in the Newton matrix of a block, as (number, h power).

        Full: I - (w_i M_ij) h J. Separable: I - (sum_l w_i M_il w_l M_lj) h^2 K J_f.
        """
        w, M = self.form.weights, self.form.M
        if not self.shape.halved:
            return [[(w[i] * M[i][j], "h") for j in stages] for i in stages]
        return [
            [(sum(w[i] * M[i][k] * w[k] * M[k][j] for k in stages), "h*h") for j in stages]
            for i in stages
        ]

    def _prepare_newton(self, stages: Sequence[int]) -> None:
        if self.inline_newton:
            self._inline_matrix(stages[0])
        else:
            self._factored_matrix(stages)

    def _inline_matrix(self, i: int) -> None:
        """Entries m{row}{column} of I - factor J at the predicted stage, and 1 / determinant."""
        n = self.unknowns
        self._time(i)
        factor, power = self._coupling((i,))[0][0]
        entries = self._reduced_entries(i)
        self.w(f"theta = {factor!r}*({power})")
        for a in range(n):
            for b in range(n):
                text = entries[a][b]
                one = "1.0" if a == b else ""
                if text == "0":
                    self.w(f"m{a}{b} = {one or '0.0'}")
                else:
                    self.w(f"m{a}{b} = {one} - theta*({text})")
        if n == 1:
            self.w("inverse = 1.0/m00")
        elif n == 2:
            self.w("inverse = 1.0/(m00*m11 - m01*m10)")
        else:
            for a in range(3):
                b, c = (a + 1) % 3, (a + 2) % 3
                for k in range(3):
                    m, n_ = (k + 1) % 3, (k + 2) % 3
                    self.w(f"k{a}{k} = m{b}{m}*m{c}{n_} - m{b}{n_}*m{c}{m}")
            self.w("inverse = 1.0/(m00*k00 + m01*k01 + m02*k02)")
        self._refuse_infinite()

    def _refuse_infinite(self) -> None:
        """An infinite Jacobian has the inverse 0: nothing would move, and that is no solution."""
        with self.w.block("if inverse == 0.0:"):
            self.w("outcome = 1", "break")

    def _newton_names(self) -> list[str]:
        """Local variables of the inline matrix, which are set in the first round of a solve."""
        if not self.inline_newton:
            return []
        n = range(self.unknowns)
        letters = "mk" if self.unknowns == 3 else "m"
        return ["inverse", *(f"{x}{a}{b}" for x in letters for a in n for b in n)]

    def _reduced_entries(self, i: int) -> list[list[str]]:
        """Entries of J, or of K J_f, at Y_i as expressions; ``"0"`` where they vanish."""
        n, half, d = self.unknowns, self.shape.half, self.shape.dimension
        rows = range(half, d) if self.shape.halved else range(d)
        columns = range(half) if self.shape.halved else range(d)
        force = self._jacobian_names(i, rows, columns, "K")
        if not self.shape.halved or self.shape.parts[0].identity:
            return force
        velocity = self._jacobian_names(i, range(half), range(half, d), "V")
        return [
            [
                " + ".join(
                    f"{force[a][k]}*{velocity[k][b]}"
                    for k in range(n)
                    if "0" not in (force[a][k], velocity[k][b])
                )
                or "0"
                for b in range(n)
            ]
            for a in range(n)
        ]

    def _jacobian_names(self, i: int, rows: range, columns: range, tag: str) -> list[list[str]]:
        formula = jacobian_block(self.shape, rows, columns)
        names = parameter_names(self.shape)
        lines, outputs = inlined(formula, lambda c: self.t.ref(f"Y{i}", c), names, f"j{tag}_")
        self.w(*lines)
        result, width = [], len(columns)
        for a in range(len(rows)):
            row = []
            for b in range(width):
                text = outputs[a * width + b]
                if text != "0":
                    self.w(f"{tag}{a}{b} = {text}")
                    text = f"{tag}{a}{b}"
                row.append(text)
            result.append(row)
        return result

    def _newton_update(self, stages: Sequence[int]) -> None:
        """L += (I - factor J)^-1 (h w f - L)."""
        if not self.inline_newton:
            self._factored_update(stages)
            return
        (i,) = stages
        self._newton_increments(i, ["new"] * self.unknowns)

    def _newton_increments(self, i: int, accepted: Sequence[str]) -> None:
        """Inline solve; ``accepted[k]`` is assigned to entry k, with its new value in ``new``."""
        low, n = self.inner[0], self.unknowns
        for a in range(n):
            slope, known = self.t.ref(f"F{i}", low + a), self.t.ref(f"L{i}", low + a)
            self.w(f"r{a} = hw{i}*{slope} - {known}")
        if n == 1:
            solved = ["r0"]
        elif n == 2:
            solved = ["m11*r0 - m01*r1", "m00*r1 - m10*r0"]
        else:
            solved = [" + ".join(f"k{k}{a}*r{k}" for k in range(3)) for a in range(3)]
        for a, text in enumerate(solved):
            name = self.t.ref(f"L{i}", low + a)
            self.w(f"known = {name}", f"new = known + inverse*({text})", f"{name} = {accepted[a]}")

    def _matrix_names(self, stages: Sequence[int]) -> tuple[str, int]:
        """Name of the factored matrix of a block and its size; equal couplings share one.

        Couplings are products of rounded numbers: equal diagonals give them equal to a few units of
        the last place only, and a matrix for the one serves the other.
        """
        key = "_".join(f"{x:.12g}" for row in self._coupling(stages) for x, _ in row)
        return f"lu_{key}", len(stages) * self.unknowns

    def _view(self, name: str, size: int) -> tuple[str, str]:
        """Source of a matrix in the work array and of its pivots."""
        a = self.t.reserve(name, size * size)
        p = self.t.reserve(f"{name}_pivots", size)
        return f"x[{a}:{a + size * size}].reshape(({size}, {size}))", f"x[{p}:{p + size}]"

    def _factored_update(self, stages: Sequence[int]) -> None:
        name, size = self._matrix_names(stages)
        start = self.t.reserve("residual", self._largest_block() * self.unknowns)
        for k, i in enumerate(stages):
            place = start + k * self.unknowns
            self._packed(place, f"hw{i}*@F{i} - @L{i}", f"L{i}", put=True)
        matrix, pivots = self._view(name, size)
        self.w(f"eliminate({matrix}, {pivots}, x[{start}:{start + size}])")
        for k, i in enumerate(stages):
            self._packed(start + k * self.unknowns, "", f"L{i}", put=False)

    def _packed(self, place: int, template: str, name: str, *, put: bool) -> None:
        """Write a vector to consecutive entries of x, or add them to a vector."""
        low, high = self.inner
        if isinstance(self.t, ScalarTarget):
            for c in range(low, high):
                entry, ref = f"x[{place + c - low}]", self.t.ref(name, c)
                if put:
                    self.w(f"{entry} = {self.t.substitute(template, c)}")
                else:
                    self.w(f"{ref} = {ref} + {entry}")
        else:
            entry = f"x[{place - low} + component]"
            line = f"{entry} = {template}" if put else f"@{name} = @{name} + {entry}"
            self.t.vec([line], self.inner)

    def _largest_block(self) -> int:
        return max(len(b.stages) for b in self.form.blocks if b.implicit)

    def _factored_matrix(self, stages: Sequence[int]) -> None:
        """Where the kept matrices are stale: Jacobian at this stage, then factor all of them."""
        w, d = self.w, self.shape.dimension
        flag = self.t.reserve("fresh", 1)
        with w.block(f"if x[{flag}] == 0.0:"):
            w(f"x[{flag}] = 1.0", "factorisations += 1")
            jacobian = self.t.reserve("jacobian", d * d)
            self._jacobian_at(stages[0], jacobian)
            w("spread = 0.0")
            with w.block(f"for k in range({d * d}):"):
                w(f"spread += abs(x[{jacobian} + k])")
            with w.block("if not (spread < 1e300):"):
                w("outcome = 1", "break")
            seen = set()
            for block in self.form.blocks:
                name, _ = self._matrix_names(block.stages)
                if block.implicit and name not in seen:
                    seen.add(name)
                    self._assemble(block.stages, jacobian)

    def _jacobian_at(self, i: int, place: int) -> None:
        """df/dy at stage i into the work array, by its formula or by differences."""
        w, d = self.w, self.shape.dimension
        source = self.t.reserve("point", d)
        slopes = self.t.reserve("slopes", 2 * d)
        # on a separable problem both halves of Y are known here: P was formed before Q
        for c in range(d) if isinstance(self.t, ScalarTarget) else ():
            w(f"x[{source + c}] = {self.t.ref(f'Y{i}', c)}")
        if not isinstance(self.t, ScalarTarget):
            self.t.vec([f"x[{source} + component] = @Y{i}"])
        self._time(i)
        time = "time" if any(part.timed for part in self.shape.parts) else "t0"
        if self.shape.uses_time is False:
            time = "t0"
        w(
            f"jacobian_into({time}, x[{source}:{source + d}], par[0:{len(self.shape.values)}], "
            f"x[{place}:{place + d * d}].reshape(({d}, {d})), x[{slopes}:{slopes + 2 * d}])"
        )
        if self.shape.jacobian is None and not self.shape.jacobian_body:
            w(f"evaluations += {self.shape.counted.source_stop - self.shape.counted.source + 1}")

    def _assemble(self, stages: Sequence[int], jacobian: int) -> None:
        """I - factor J of a block into its matrix, factored."""
        w, n, d, half = self.w, self.unknowns, self.shape.dimension, self.shape.half
        name, size = self._matrix_names(stages)
        start = self.t.reserve(name, size * size)
        coupling = self._coupling(stages)
        with w.block(f"for a in range({n}):"), w.block(f"for b in range({n}):"):
            if not self.shape.halved:
                w(f"entry = x[{jacobian} + a*{d} + b]")
            elif self.shape.parts[0].identity:
                w(f"entry = x[{jacobian} + ({half} + a)*{d} + b]")
            else:
                w("entry = 0.0")
                with w.block(f"for k in range({half}):"):
                    w(
                        f"entry += x[{jacobian} + ({half} + a)*{d} + k]"
                        f"*x[{jacobian} + k*{d} + {half} + b]"
                    )
            w("one = 1.0 if a == b else 0.0")
            for i in range(len(stages)):
                for j in range(len(stages)):
                    factor, power = coupling[i][j]
                    place = f"x[{start} + ({j * n} + b)*{size} + {i * n} + a]"
                    one = "one - " if i == j else "-"
                    w(f"{place} = {one}{factor!r}*({power})*entry")
        matrix, pivots = self._view(name, size)
        w(f"factor({matrix}, {pivots})")
