"""Generated source for Newton's method on the stage equations L = h w f(Y(L)).

Two kinds. *Inline*, for one stage at a time with at most :data:`INLINE_LIMIT` unknowns: the matrix
I - h w M J is written out entry by entry and evaluated afresh at the predicted stage. *Factored*:
the Jacobian is evaluated once, the matrices of all blocks are factored (equal ones share), and they
are kept from step to step until a solve needs more than :data:`REFRESH_ROUNDS` rounds. On a
separable problem the unknown is the p part of L and J is the product K J_f of the two halves. The
stages of a block that depend on each other are separated by the eigenvectors of their coupling: one
real or complex matrix of the size of J for each eigenvalue. Where J is a narrow band in some order
of the unknowns (:mod:`.band`), so are the matrices and their factors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .emit import ScalarTarget, Target, Writer
from .forms import StepForm
from .options import Options
from .shape import Shape, inlined, jacobian_block, parameter_names
from .updates import linear

INLINE_LIMIT = 3
REFRESH_ROUNDS = 5

#: Elimination with partial pivoting. Entry (i, j) is a[offset + j*stride + i]: a dense matrix by
#: columns (stride n, offset 0), or its diagonals with room for those that pivoting fills (stride
#: 2 lower + upper, offset lower + upper), as LAPACK's gbtrf keeps them. Every inner loop runs along
#: memory, and no sum has to be reordered to be fast. The diagonal holds reciprocals. Zeros stand
#: around a ``padded`` band and its vectors, so that every inner loop has the same length.
HELPERS = """
@compiled
def factor(a, pivots, n, lower, upper, stride, offset, padded):
    for k in range(n):
        column = offset + k*stride
        end = k + lower + 1 if padded == 1 else n
        p = k
        for i in range(k + 1, end):
            if abs(a[column + i]) > abs(a[column + p]):
                p = i
        pivots[k] = p
        reach = k + lower + upper + 1 if padded == 1 else n
        if p != k:
            for j in range(k, reach):
                held = a[offset + j*stride + k]
                a[offset + j*stride + k] = a[offset + j*stride + p]
                a[offset + j*stride + p] = held
        a[column + k] = 1.0 / a[column + k]
        for i in range(k + 1, end):
            a[column + i] = a[column + i] * a[column + k]
        for j in range(k + 1, reach):
            other = offset + j*stride
            ratio = a[other + k]
            if ratio != 0.0:
                for i in range(k + 1, end):
                    a[other + i] -= a[column + i] * ratio


@compiled
def eliminate(a, pivots, b, n, lower, upper, stride, offset, padded):
    shift = lower + upper if padded == 1 else 0
    for k in range(n):
        p = int(pivots[k])
        known = b[shift + p]
        b[shift + p] = b[shift + k]
        b[shift + k] = known
        column = offset + k*stride
        end = k + lower + 1 if padded == 1 else n
        for i in range(k + 1, end):
            b[shift + i] -= a[column + i] * known
    for j in range(n - 1, -1, -1):
        column = offset + j*stride
        known = b[shift + j] * a[column + j]
        b[shift + j] = known
        first = j - lower - upper if padded == 1 else 0
        for i in range(first, j):
            b[shift + i] -= a[column + i] * known
"""

#: The same for a + i b, with the unknown c + i d.
COMPLEX_HELPERS = """
@compiled
def complex_factor(a, b, pivots, n, lower, upper, stride, offset, padded):
    for k in range(n):
        column = offset + k*stride
        end = k + lower + 1 if padded == 1 else n
        p = k
        largest = abs(a[column + k]) + abs(b[column + k])
        for i in range(k + 1, end):
            size = abs(a[column + i]) + abs(b[column + i])
            if size > largest:
                largest = size
                p = i
        pivots[k] = p
        reach = k + lower + upper + 1 if padded == 1 else n
        if p != k:
            for j in range(k, reach):
                here = offset + j*stride
                held = a[here + k]
                a[here + k] = a[here + p]
                a[here + p] = held
                held = b[here + k]
                b[here + k] = b[here + p]
                b[here + p] = held
        real = a[column + k]
        imaginary = b[column + k]
        norm = real*real + imaginary*imaginary
        real = real/norm
        imaginary = -imaginary/norm
        a[column + k] = real
        b[column + k] = imaginary
        for i in range(k + 1, end):
            held = a[column + i]*real - b[column + i]*imaginary
            b[column + i] = a[column + i]*imaginary + b[column + i]*real
            a[column + i] = held
        for j in range(k + 1, reach):
            other = offset + j*stride
            real = a[other + k]
            imaginary = b[other + k]
            if real != 0.0 or imaginary != 0.0:
                for i in range(k + 1, end):
                    a[other + i] -= a[column + i]*real - b[column + i]*imaginary
                    b[other + i] -= a[column + i]*imaginary + b[column + i]*real


@compiled
def complex_eliminate(a, b, pivots, c, d, n, lower, upper, stride, offset, padded):
    shift = lower + upper if padded == 1 else 0
    for k in range(n):
        p = int(pivots[k])
        real = c[shift + p]
        imaginary = d[shift + p]
        c[shift + p] = c[shift + k]
        d[shift + p] = d[shift + k]
        c[shift + k] = real
        d[shift + k] = imaginary
        column = offset + k*stride
        end = k + lower + 1 if padded == 1 else n
        for i in range(k + 1, end):
            c[shift + i] -= a[column + i]*real - b[column + i]*imaginary
            d[shift + i] -= a[column + i]*imaginary + b[column + i]*real
    for j in range(n - 1, -1, -1):
        column = offset + j*stride
        real = c[shift + j]*a[column + j] - d[shift + j]*b[column + j]
        imaginary = c[shift + j]*b[column + j] + d[shift + j]*a[column + j]
        c[shift + j] = real
        d[shift + j] = imaginary
        first = j - lower - upper if padded == 1 else 0
        for i in range(first, j):
            c[shift + i] -= a[column + i]*real - b[column + i]*imaginary
            d[shift + i] -= a[column + i]*imaginary + b[column + i]*real
"""


#: Condition of the eigenvectors of a block beyond which its stages are solved for as one system.
_WORST_CONDITION = 1e6


@dataclass(frozen=True)
class Split:
    """A coupling of stages C = T diag(values) T^-1; of conjugate pairs one is kept.

    With it the equations (I - C x J) L = R of a block become one of the size of J for each value:
    real ones, and a complex one for each conjugate pair (Butcher, On the implementation of implicit
    Runge-Kutta methods, BIT 16 (1976)).
    """

    values: tuple[complex, ...]
    into: tuple[tuple[complex, ...], ...]  #: Rows of T^-1 that belong to the values.
    #: Columns of T, twice as large for a value that stands for a pair.
    back: tuple[tuple[complex, ...], ...]


def split_of(coupling: Sequence[Sequence[float]]) -> Split | None:
    """Return eigenvalues and vectors of the coupling of a block.

    The result is ``None`` where they are too close.
    """
    if len(coupling) == 1:
        return Split((complex(coupling[0][0]),), ((1.0,),), ((1.0,),))
    values, T = np.linalg.eig(np.array(coupling))
    if not np.linalg.cond(T) < _WORST_CONDITION:
        return None
    inverse = np.linalg.inv(T)
    kept = [k for k, value in enumerate(values) if value.imag >= 0]
    twice = [2.0 if values[k].imag else 1.0 for k in kept]
    return Split(
        tuple(complex(values[k]) for k in kept),
        tuple(tuple(complex(x) for x in inverse[k]) for k in kept),
        tuple(
            tuple(complex(x) * factor for x in T[:, k])
            for k, factor in zip(kept, twice, strict=True)
        ),
    )


@dataclass(frozen=True)
class System:
    """One of the matrices that Newton's method factors, and where its entries are."""

    name: str  #: Of its place in the work array; equal matrices share one.
    #: The matrix is I - value h J (h^2 K J_f on a separable problem); of a whole block: nan.
    value: complex
    #: Rows, and diagonals.
    size: int
    lower: int
    upper: int
    #: Entry (i, j) is ``offset + j*stride + i``, below ``length``.
    stride: int
    offset: int
    length: int
    padded: bool = False  #: Whether zeros stand around it, as :data:`HELPERS` asks for.

    @property
    def numbers(self) -> str:
        """Last arguments of :data:`HELPERS`."""
        given = (self.size, self.lower, self.upper, self.stride, self.offset, int(self.padded))
        return ", ".join(map(str, given))

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the real part and, if there is one, of the imaginary part."""
        return (self.name, f"{self.name}_i") if self.value.imag else (self.name,)

    @property
    def doubles(self) -> int:
        """Numbers kept for it, pivots included."""
        return self.length * len(self.parts) + self.size


def written_out(form: StepForm, shape: Shape) -> bool:
    """Return whether stages stand alone, with matrices that are small enough to be written out."""
    single = all(len(block.stages) == 1 for block in form.blocks if block.implicit)
    unknowns = shape.half if shape.halved else shape.dimension
    return single and unknowns <= INLINE_LIMIT and shape.jacobian is not None


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
        """Set ``time`` to that of stage i."""
        if self.shape.uses_time:
            self.w(f"time = start + hc{i}" if self.form.c[i] else "time = start")
        elif any(part.timed and part.formula is None for part in self.shape.parts):
            self.w("time = t0")

    @property
    def inline_newton(self) -> bool:
        """Whether the Newton matrix of a single stage is written out."""
        return (
            self.options.solver == "newton"
            and isinstance(self.t, ScalarTarget)
            and written_out(self.form, self.shape)
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
        """Return the factors of the reduced Jacobian in a Newton matrix, as (number, h power).

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
        """Write entries m{row}{column} of I - factor J at the predicted stage, 1 / determinant."""
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
        """Refuse an infinite Jacobian: its inverse 0 would move nothing, which is no solution."""
        with self.w.block("if inverse == 0.0:"):
            self.w("outcome = 1", "break")

    def _newton_names(self) -> list[str]:
        """Return local variables of the inline matrix, set in the first round of a solve."""
        if not self.inline_newton:
            return []
        n = range(self.unknowns)
        letters = "mk" if self.unknowns == 3 else "m"
        return ["inverse", *(f"{x}{a}{b}" for x in letters for a in n for b in n)]

    def _reduced_entries(self, i: int) -> list[list[str]]:
        """Return entries of J, or of K J_f, at Y_i as expressions; ``"0"`` where they vanish."""
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
        """Write L += (I - factor J)^-1 (h w f - L)."""
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

    def _systems(self, stages: Sequence[int]) -> list[System]:
        """Return matrices to be factored for a block; equal couplings share one.

        Couplings are products of rounded numbers: equal diagonals give them equal to a few units of
        the last place only, and a matrix for the one serves the other.
        """
        coupling = [[x for x, _ in row] for row in self._coupling(stages)]
        split, n, band = split_of(coupling), self.unknowns, self.shape.band
        if split is None:
            key, size = "_".join(f"{x:.12g}" for row in coupling for x in row), len(stages) * n
            whole = (size - 1, size - 1, size, 0, size * size)
            return [System(f"lu_{key}", complex(math.nan), size, *whole)]
        found = []
        for x in split.values:
            key = f"{x.real:.12g}" + (f"_{x.imag:.12g}" if x.imag else "")
            where = (n - 1, n - 1, n, 0, n * n)
            if band is not None:
                low, up = band.lower, band.upper
                length = (n + low + up) * (2 * low + up + 1)
                where = (low, up, 2 * low + up, low + up, length)
            found.append(System(f"lu_{key}", x, n, *where, padded=band is not None))
        return found

    def systems(self) -> dict[str, System]:
        """Return all matrices of a step by name."""
        blocks = [block.stages for block in self.form.blocks if block.implicit]
        return {one.name: one for stages in blocks for one in self._systems(stages)}

    def _view(self, name: str, size: int) -> str:
        """Return the source of a vector in the work array."""
        start = self.t.reserve(name, size)
        return f"x[{start}:{start + size}]"

    def _matrix(self, one: System) -> str:
        """Return the source of a matrix and its pivots, as arguments of :data:`HELPERS`."""
        views = [self._view(name, one.length) for name in one.parts]
        return ", ".join((*views, self._view(f"{one.name}_pivots", one.size)))

    def _factored_update(self, stages: Sequence[int]) -> None:
        systems, n = self._systems(stages), self.unknowns
        start = self.t.reserve("residual", self._largest_block() * n)
        for k, i in enumerate(stages):
            self._packed(start + k * n, f"hw{i}*@F{i} - @L{i}", f"L{i}", put=True)
        (first,) = systems if len(systems) == 1 else (None,)
        if first is not None and self.shape.band is None and not first.value.imag:
            # nothing to transform: one stage, or a block as a whole
            end = start + first.size
            self.w(f"eliminate({self._matrix(first)}, x[{start}:{end}], {first.numbers})")
        else:
            self._transformed(stages, systems, start)
        for k, i in enumerate(stages):
            self._packed(start + k * n, "", f"L{i}", put=False)

    def _transformed(self, stages: Sequence[int], systems: Sequence[System], start: int) -> None:
        """Write T (I - diag x J)^-1 T^-1 of the residuals of a block, in place."""
        split = split_of([[x for x, _ in row] for row in self._coupling(stages)])
        assert split is not None
        w, n, count, band = self.w, self.unknowns, range(len(stages)), self.shape.band
        before, after = (0, 0) if band is None else (band.lower + band.upper, band.lower)
        vectors = [
            [self.t.reserve(f"r{part}{m}", before + n + after) for part in range(len(one.parts))]
            for m, one in enumerate(systems)
        ]
        place = f"{before} + int(par[{len(self.shape.values)} + c])" if band else "c"
        with w.block(f"for c in range({n}):"):
            w(f"place = {place}", *(f"r{k} = x[{start + k * n} + c]" for k in count))
            for row, places in zip(split.into, vectors, strict=True):
                real = linear([(complex(x).real, f"r{k}") for k, x in enumerate(row)])
                imaginary = linear([(complex(x).imag, f"r{k}") for k, x in enumerate(row)])
                for at, text in zip(places, (real, imaginary), strict=False):
                    w(f"x[{at} + place] = {text}")
        for one, places in zip(systems, vectors, strict=True):
            given = ", ".join(f"x[{at}:{at + before + n + after}]" for at in places)
            name = "complex_eliminate" if one.value.imag else "eliminate"
            w(f"{name}({self._matrix(one)}, {given}, {one.numbers})")
        with w.block(f"for c in range({n}):"):
            w(f"place = {place}")
            for k in count:
                terms = []
                for column, places in zip(split.back, vectors, strict=True):
                    x = complex(column[k])
                    signed = (x.real, -x.imag)
                    terms += [
                        (f, f"x[{at} + place]") for f, at in zip(signed, places, strict=False)
                    ]
                w(f"x[{start + k * n} + c] = {linear(terms)}")

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
        """Write, for stale matrices, the Jacobian at this stage and the factors of all of them."""
        w = self.w
        flag = self.t.reserve("fresh", 1)
        with w.block(f"if x[{flag}] == 0.0:"):
            w(f"x[{flag}] = 1.0", "factorisations += 1")
            jacobian = self.t.reserve("jacobian", self.jacobian_size)
            self._jacobian_at(stages[0], jacobian)
            w("spread = 0.0")
            with w.block(f"for k in range({self.jacobian_size}):"):
                w(f"spread += abs(x[{jacobian} + k])")
            with w.block("if not (spread < 1e300):"):
                w("outcome = 1", "break")
            seen: set[str] = set()
            for block in self.form.blocks:
                for one in self._systems(block.stages) if block.implicit else ():
                    if one.name not in seen:
                        seen.add(one.name)
                        self._assemble(one, block.stages, jacobian)

    @property
    def jacobian_size(self) -> int:
        """Numbers kept of the Jacobian: all entries, or its diagonals."""
        band, d = self.shape.band, self.shape.dimension
        return d * d if band is None else self.unknowns * band.width

    def _jacobian_at(self, i: int, place: int) -> None:
        """Write df/dy at stage i into the work array, by its formula or by differences."""
        w, d, band = self.w, self.shape.dimension, self.shape.band
        source = self.t.reserve("point", d)
        slopes = self.t.reserve("slopes", (2 if band is None else 3) * d)
        # on a separable problem both halves of Y are known here: P was formed before Q
        for c in range(d) if isinstance(self.t, ScalarTarget) else ():
            w(f"x[{source + c}] = {self.t.ref(f'Y{i}', c)}")
        if not isinstance(self.t, ScalarTarget):
            self.t.vec([f"x[{source} + component] = @Y{i}"])
        self._time(i)
        time = "time" if any(part.timed for part in self.shape.parts) else "t0"
        if self.shape.uses_time is False:
            time = "t0"
        size = len(self.shape.par)
        out = f"x[{place}:{place + self.jacobian_size}]"
        if band is None:
            out += f".reshape(({d}, {d}))"
        w(
            f"jacobian_into({time}, x[{source}:{source + d}], par[0:{size}], "
            f"{out}, x[{slopes}:{slopes + (2 if band is None else 3) * d}])"
        )
        if self.shape.differenced:
            read = self.shape.counted.source_stop - self.shape.counted.source
            w(f"evaluations += {(read if band is None else band.width) + 1}")

    def _assemble(self, one: System, stages: Sequence[int], jacobian: int) -> None:
        """Write I - factor J into a matrix, factored."""
        w, n, band = self.w, self.unknowns, self.shape.band
        d, half = self.shape.dimension, self.shape.half
        power = self._coupling(stages)[0][0][1]
        starts = [self.t.reserve(name, one.length) for name in one.parts]

        def entries(place: str) -> None:
            for start, factor, unit in zip(
                starts, (one.value.real, one.value.imag), ("one - ", "-"), strict=False
            ):
                w(f"x[{start} + {place}] = {unit}{factor!r}*({power})*entry")

        if band is not None:
            for start in starts:
                with w.block(f"for k in range({one.length}):"):
                    w(f"x[{start} + k] = 0.0")
            with w.block(f"for b in range({n}):"):
                w(f"low = b - {band.upper} if b > {band.upper} else 0")
                w(f"high = b + {band.lower + 1} if b + {band.lower + 1} < {n} else {n}")
                with w.block("for a in range(low, high):"):
                    w(f"entry = x[{jacobian + band.upper} + b*{band.width - 1} + a]")
                    w("one = 1.0 if a == b else 0.0")
                    entries(f"{one.offset} + b*{one.stride} + a")
        else:
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
                if math.isnan(one.value.real):
                    self._whole_block(one, stages, starts[0])
                else:
                    entries(f"b*{n} + a")
        name = "complex_factor" if one.value.imag else "factor"
        w(f"{name}({self._matrix(one)}, {one.numbers})")

    def _whole_block(self, one: System, stages: Sequence[int], start: int) -> None:
        """Write entry (a, b) of every pair of stages of a block that is not split."""
        coupling, n = self._coupling(stages), self.unknowns
        for i in range(len(stages)):
            for j in range(len(stages)):
                factor, power = coupling[i][j]
                place = f"x[{start} + ({j * n} + b)*{one.size} + {i * n} + a]"
                unit = "one - " if i == j else "-"
                self.w(f"{place} = {unit}{factor!r}*({power})*entry")
