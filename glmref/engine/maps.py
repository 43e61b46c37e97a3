"""Starting and finishing methods as kernels: one value in, some values out, for many rows at once.

On right-hand sides that need no Python, and where the fixed point solves what is implicit: what
else there is stays with :mod:`.reference`, which takes some 10 microseconds for a stage where a
kernel takes nanoseconds. Explicit stages and the values that they make are summed term by term,
``y + h (a_1 F_1 + a_2 F_2 + ..)``, as the reference sums them. Implicit ones begin from slopes of
zero in every row, so that a row does not depend, to the last bit, on those before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..method import Method
from ..method.component import Palette
from ..method.stage_order import is_shared
from ..problems.model import Problem
from . import kernel_cache, native
from .codegen import ARGUMENTS, Builder, choose_kind, header
from .emit import TARGETS, ScalarTarget, Writer
from .forms import Row, Rows, StepForm, float_rows, floats
from .kept import expressed, recalled
from .native import Tuning
from .options import Options
from .reference import palette_of
from .shape import Shape, shape_of
from .stages import StageWriter


class _MapBuilder(Builder):
    """Writes a kernel that replaces each row of ``out`` by what a tableau makes of it.

    Rows are ``length`` numbers long, of which the first d come in. ``first`` and ``last`` count
    rows; row n belongs to step ``n * every``, but no later one than ``mark``.
    """

    @property
    def direct(self) -> bool:
        """See :class:`.explicit.ExplicitWriter`: products of h and coefficients are not formed."""
        return False

    def _prediction(self, i: int, block: Sequence[int]) -> list[tuple[int, bool, float]]:
        """See :meth:`.StageWriter._prediction`: there is no row before, so its slopes are zero."""
        first = self.form.blocks[0].stages
        return [] if block[0] in first else super()._prediction(i, block)

    def _explicit(self, i: int, base: tuple[str, str], slope: str = "") -> None:
        StageWriter._explicit(self, i, base, slope)  # there is no force of a step before

    def kernel(self) -> None:
        """Write the function ``kernel``."""
        w, by_table = self.w, not self.form.implicit_stages
        w("", "@compiled_with_signature")
        with w.block(f"def kernel({', '.join(ARGUMENTS)}):"):
            if by_table:
                self._heading()
            else:
                self._preamble()
                self._declare()
                w(f"length = {self.shape.dimension * self.form.rows}")
            w("n = first", "evaluations = 0", "velocities = 0", "outcome = 0", "iterations = 0")
            with w.block("while n < last:"), self._guard():
                w("place = n*length")
                w("taken = n*every if n*every < mark else mark", "start = t0 + taken*h")
                self._moved("@y0 = {}", "out", "place", self.all)
                (self._by_table if by_table else self._by_solver)()
                w("n += 1")
            w("tally[0] += evaluations", "tally[1] += velocities", "tally[4] = n")
            w("return outcome")

    def _by_solver(self) -> None:
        """Write stages and values of a row in turn."""
        self.t.vec([f"@L{i} = 0.0" for i in range(self.form.s)])
        self._begin()
        self._blocks()
        checks = [f"check{k or ''}" for k in range(len(self.sides))]
        for values, increments, check in zip(self.sides, self.moving, checks, strict=True):
            values.finish(increments)
            values.check(check)
        self._finite(" + ".join(checks))
        for values in self.sides:
            for k in range(values.r):
                place = f"place + {k * self.shape.dimension}"
                self._moved(f"{{}} = @n{k}", "out", place, values.part)

    # --- coefficients from a table --------------------------------------------------------------

    def _heading(self) -> None:
        """Read how many stages and values there are, see :func:`_table`."""
        self.t.parameters()
        begin = len(self.shape.values)
        if self.shape.loops:
            self.w(f"constants = par[{len(self.shape.parameters)}:{begin}]")
        self.w("time = t0", f"stages = int(par[{begin}])", f"length = int(par[{begin + 1}])")
        for name in ("y0", "S", "Y", "n", *(f"F{k}" for k in range(len(self.sides)))):
            self.t.offset(name)
        # behind the vectors that have names: the values made, and the slopes of all stages
        self.w(f"made = {self.t.used}", "slopes = made + length", f"begin = {begin + 2}")

    def _by_table(self) -> None:
        """Write loops over stages and values: the source does not grow with the tableau."""
        w, d, both = self.w, self.shape.dimension, self.form.together or len(self.sides) == 1
        w("c = begin", "i = 0")
        with w.block("while i < stages:"):
            if self.shape.uses_time:
                w("time = start + h*par[c]")
            w("own = slopes + int(par[c + 1])", "side = par[c + 2]", "c += 3")
            for k, values in enumerate(self.sides):
                with nullcontext() if both else w.block(f"if side == {k}.0:"):
                    self._sum(values.part)
                    self.t.vec(["@Y = @y0 + h*@S"], values.part)
                    if both and k + 1 < len(self.sides):
                        continue
                    stage = 0 if both else k * len(self.form.U)
                    for part in self._due(stage):
                        self.t.call(part, "Y", f"F{k}", f"s{k}")
                        self._moved(f"{{}} = @F{k}", "x", "own", (part.start, part.stop))
                    self._count([stage])
            w("i += 1")
        w("check = 0.0")
        for values in self.sides:
            w("v = made", "end = made + int(par[c])", "c += 1")
            with w.block("while v < end:"):
                w("u = par[c]", "c += 1")
                self._sum(values.part)
                self.t.vec(["@n = h*@S + u*@y0"], values.part)
                self.t.total("one", "@n", values.part)
                self._moved("{} = @n", "x", "v", values.part)
                w("check = check + one", f"v += {d}")
        self._finite("check")
        w("i = 0")
        with w.block("while i < length:"):
            w("out[place + i] = x[made + i]", "i += 1")

    def _sum(self, part: tuple[int, int]) -> None:
        """Write S: slopes by the coefficients that are next in the table, term by term."""
        self.t.vec(["@S = -0.0"], part)
        self.w("stop = c + 1 + 2*int(par[c])", "c += 1")
        with self.w.block("while c < stop:"):
            self.w("a = par[c]", "j = slopes + int(par[c + 1])", "c += 2")
            self._moved("@S = @S + a*{}", "x", "j", part)

    def _moved(self, template: str, array: str, place: str, part: tuple[int, int]) -> None:
        """Write a statement for entries of an array from a place on, that of component 0."""
        if isinstance(self.t, ScalarTarget):
            for c in range(*part):
                self.w(self.t.substitute(template.format(f"{array}[{place} + {c}]"), c))
        else:
            self.t.vec([template.format(f"{array}[{place} + component]")], part)


def _map_form(method: Method, palette: Palette) -> StepForm:
    """Return the stages that are read, and the values, of a start or a finish."""
    components = []
    for c in method.components:
        s, r = len(c.U), len(c.V)
        R = float_rows(c.B) if s else ((),) * r
        components.append(Rows(
            U=((1.0,),) * s, M=float_rows(c.A), weights=(1.0,) * s, V=float_rows(c.V), R=R,
            R_residue=tuple((0.0,) * len(row) for row in R), large=(True,) * r, to_form=(),
            from_form=(),
        ))  # fmt: skip
    read, times = method.read_stages(palette), method.times
    blocks = tuple(b for b in method.stage_blocks(palette) if not read.isdisjoint(b.stages))
    together = method.parts > 1 and is_shared(palette)
    c = floats(times[0]) if method.parts == 1 or together else ()
    return StepForm("standard", False, tuple(components), blocks, c, together=together)


def _is_solution(form: StepForm, i: int) -> bool:
    """Return whether stage i of stages evaluated together is the solution that comes in."""
    first = (i,) == form.blocks[0].stages and (not form.c or form.c[i] == 0.0)
    return form.together and first and not any(any(one.M[i]) for one in form.components)


def _table(form: StepForm, d: int) -> list[float]:
    """Return the coefficients of explicit stages and of the values as a kernel reads them.

    The number of stages, and of doubles in a row. Of each stage its abscissa, the place of its
    slope (..., d), its component, and the sums for the components that it has; of each component d
    times the number of its values, and of each value its factor of the solution, and a sum. A sum
    is the number of its terms, and of each the coefficient and the place of the slope.
    """
    n, both = len(form.U), form.together or len(form.components) == 1

    def total(k: int, row: Row) -> list[float]:
        first = 0 if both or k else n
        terms = [(x, float((first + j) * d)) for j, x in enumerate(row) if x]
        return [float(len(terms)), *(x for term in terms for x in term)]

    table = [float(len(form.blocks)), float(form.rows * d)]
    for (i,) in (block.stages for block in form.blocks):
        side, row = form.place(i)
        table += [form.c[i] if form.c else 0.0, float(i * d), float(side)]
        for k in range(len(form.components)) if both else (side,):
            table += total(k, form.components[k].M[row])
    for k, one in enumerate(form.components):
        table.append(float(len(one.V) * d))
        for (u,), row in zip(one.V, one.R, strict=True):
            table += [u, *total(k, row)]
    return table


class Map:
    """A tableau with one value coming in, compiled on a problem.

    ``palette`` says whether the two components of a pair have stages of their own.
    """

    def __init__(
        self, method: Method, shape: Shape, *, palette: Palette | None = None, interpreted: bool
    ) -> None:
        form = _map_form(method, method.palette if palette is None else palette)
        self.values, self.shape, self.par = form.rows, shape, shape.par
        options = Options(compensated=False, interpreted=interpreted)
        about, stages = [options, replace(shape, values=shape.values.tolist())], 1
        if form.implicit_stages:
            about, stages = [*about, form], form.s
        else:
            about += [form.together, [len(x.U) > 0 for x in form.components]]
            self.par = np.concatenate([self.par, _table(form, shape.dimension)])
        kind = choose_kind(stages, shape, options)

        def written() -> tuple[str, int]:
            writer = Writer()
            target = TARGETS[kind](shape, writer)
            _MapBuilder(form, shape, options, target).kernel()
            head = '"""Generated kernel: a map of rows."""\n\n' + header(shape, kind, newton=False)
            return head + writer.text, target.work_size

        text, size = recalled("map", repr(about), written, tuple, list)
        # behind what the source reserves a table has the values made and the slopes of all stages
        slopes = size + form.rows * shape.dimension
        self.work_size = slopes + form.s * shape.dimension
        #: Whether coefficients are data, and the place in the work array where afterwards the slope
        #: at the solution stands, ``None`` where no stage is the solution.
        self.by_table = not form.implicit_stages
        begins = [i for i in range(len(form.U)) if _is_solution(form, i)]
        self.slope_place = (
            slopes + begins[0] * shape.dimension if begins and self.by_table else None
        )
        if interpreted:
            self.built = kernel_cache.interpret(text, {}, "")
        else:
            self.built = kernel_cache.build(text, ARGUMENTS, tuning=Tuning(pack=kind == "array"))

    def __call__(
        self, rows: np.ndarray, t0: float, h: float, *, every: int = 1, last: int = 0
    ) -> tuple[int, int]:
        """Replace contiguous rows (m, r, d) in place; of each the first value is given.

        Row n belongs to step ``min(n every, last)``, step 0 to ``t0``. Returns how many rows became
        numbers, and the evaluations.
        """
        tally, _ = self._called(rows, t0, h, last, every)
        return int(tally[4]), int(tally[0])

    def of(self, t: float, y: np.ndarray, h: float) -> tuple[np.ndarray | None, int]:
        """Return the values (r, d) made of y, ``None`` where they are no numbers, and the cost."""
        rows = np.zeros((1, self.values, len(y)))
        rows[0, 0] = y
        good, cost = self(rows, t, h)
        return (rows[0] if good else None), cost

    def slope(self, h: float, t: float, y: np.ndarray) -> np.ndarray:
        """Return the right-hand side at (t, y), shape (d,), as this kernel evaluates it."""
        rows = np.zeros((1, self.values, len(y)))
        rows[0, 0] = y
        _, work = self._called(rows, t, h, 0, 1)
        return work[self.slope_place :][: len(y)]

    def _called(
        self, rows: np.ndarray, t0: float, h: float, last: int, every: int
    ) -> tuple[np.ndarray, np.ndarray]:
        tally, work = np.zeros(6, dtype=np.int64), native.aligned_zeros(self.work_size)
        numbers = (t0, h, 0, len(rows), last, every)
        self.built.kernel(work, self.par, *numbers, rows.reshape(-1), 0, tally)
        return tally, work


def map_of(method: Method | None, problem: Problem, *, interpreted: bool = False) -> Map | None:
    """Return the kernel of a start or a finish, ``None`` where the reference has to do."""
    return None if method is None else _kept_map(method, expressed(problem), interpreted)


@lru_cache(maxsize=256)
def _kept_map(method: Method, problem: Problem, interpreted: bool) -> Map | None:
    shape, palette = shape_of(problem), palette_of(method, problem)
    real = all(
        x.is_real() for c in method.components for m in (c.A, c.B, c.V) for r in m for x in r
    )
    blocks = method.stage_blocks(palette)
    one = method.parts == 1 or not any(block.implicit for block in blocks)
    if not blocks or not real or not one or shape.opaque or method.additive:
        return None
    found = Map(method, shape, palette=palette, interpreted=interpreted)
    return None if found.built.engine == "numba" else found
