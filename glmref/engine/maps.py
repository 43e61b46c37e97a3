"""Starting and finishing methods as kernels: one value in, some values out, for many rows at once.

On right-hand sides that need no Python, and where the fixed point solves what is implicit: what
else there is stays with :mod:`.reference`, which takes some 10 microseconds for a stage where a
kernel takes nanoseconds. Explicit stages and the values that they make are summed term by term,
``y + h (a_1 F_1 + a_2 F_2 + ..)``, as the reference sums them. Implicit ones begin from slopes of
zero in every row, so that a row does not depend, to the last bit, on those before it.
"""

from __future__ import annotations

from collections.abc import Sequence
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
from .forms import Rows, StepForm, float_rows, floats
from .kept import expressed, recalled
from .native import Tuning
from .options import Options
from .reference import palette_of
from .shape import Shape, shape_of
from .stages import StageWriter
from .updates import Term, linear


class _MapBuilder(Builder):
    """Writes a kernel that replaces each row of ``out`` by what a tableau makes of it.

    Rows are r values long, of which the first one comes in. ``first`` and ``last`` count rows; row
    n belongs to step ``n * every``, but no later one than ``mark``.
    """

    @property
    def direct(self) -> bool:
        """See :class:`.explicit.ExplicitWriter`: products of h and coefficients are not formed."""
        return False

    @property
    def ordered(self) -> bool:
        """Whether slopes are summed before they are multiplied by h: L is f, and not h f."""
        return not self.form.implicit_stages

    def _prediction(self, i: int, block: Sequence[int]) -> list[tuple[int, bool, float]]:
        """See :meth:`.StageWriter._prediction`: there is no row before, so its slopes are zero."""
        first = self.form.blocks[0].stages
        return [] if block[0] in first else super()._prediction(i, block)

    def _named(
        self, i: int, big: list[Term], small: list[Term], part: tuple[int, int]
    ) -> tuple[str, str]:
        z, a = super()._named(i, big, small, part)
        return z, f"h*{a if a[1:].isidentifier() else f'({a})'}" if self.ordered and small else a

    def _explicit(self, i: int, base: tuple[str, str], slope: str = "") -> None:
        StageWriter._explicit(self, i, base, slope)  # there is no force of a step before

    def _increment(self, i: int, slope: str) -> None:
        if self.ordered:
            side, _ = self.form.place(i)
            self.t.vec([f"@L{i} = @{slope}"], self.sides[-1 - side].part)
        else:
            super()._increment(i, slope)

    def _values(self) -> list[str]:
        """Write the values n{k}, and return the sums that are numbers where all of them are."""
        checks = [f"check{k or ''}" for k in range(len(self.sides))]
        for values, increments, check in zip(self.sides, self.moving, checks, strict=True):
            if self.ordered:
                rows = zip(values.V, values.R, strict=True)
                for k, ((u, *_), row) in enumerate(rows):
                    moved = linear(list(zip(row, increments, strict=True)))
                    terms = [(1.0, f"h*({moved})")] if any(row) else []
                    self.t.vec([f"@n{k} = {linear([*terms, (u, '@y0')])}"], values.part)
            else:
                values.finish(increments)
            values.check(check)
        return checks

    def kernel(self) -> None:
        """Write the function ``kernel``."""
        w, d, r = self.w, self.shape.dimension, self.form.rows
        w("", "@compiled_with_signature")
        with w.block(f"def kernel({', '.join(ARGUMENTS)}):"):
            self._preamble()
            self._declare()
            w("n = first", "evaluations = 0", "velocities = 0", "outcome = 0", "iterations = 0")
            with w.block("while n < last:"), self._guard():
                w(f"place = n*{d * r}")
                w("taken = n*every if n*every < mark else mark", "start = t0 + taken*h")
                self._moved("@y0 = {}", 0, self.all)
                if not self.ordered:
                    self.t.vec([f"@L{i} = 0.0" for i in range(self.form.s)])
                self._begin()
                self._blocks()
                self._finite(" + ".join(self._values()))
                for values in self.sides:
                    for k in range(values.r):
                        self._moved(f"{{}} = @n{k}", k, values.part)
                w("n += 1")
            w("tally[0] += evaluations", "tally[1] += velocities", "tally[4] = n")
            w("return outcome")

    def _moved(self, template: str, k: int, part: tuple[int, int]) -> None:
        """Write a statement for the entries of value k in the current row."""
        d = self.shape.dimension
        if isinstance(self.t, ScalarTarget):
            for c in range(*part):
                self.w(self.t.substitute(template.format(f"out[place + {k * d + c}]"), c))
        else:
            self.t.vec([template.format(f"out[place + {k * d} + component]")], part)


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


class Map:
    """A tableau with one value coming in, compiled on a problem.

    ``palette`` says whether the two components of a pair have stages of their own.
    """

    def __init__(
        self, method: Method, shape: Shape, *, palette: Palette | None = None, interpreted: bool,
        seldom: bool = False,
    ) -> None:  # fmt: skip
        form = _map_form(method, method.palette if palette is None else palette)
        self.values = form.rows
        options = Options(compensated=False, interpreted=interpreted)
        kind = choose_kind(form.s, shape, options)

        def written() -> tuple[str, int]:
            writer = Writer()
            target = TARGETS[kind](shape, writer)
            _MapBuilder(form, shape, options, target).kernel()
            head = '"""Generated kernel: a map of rows."""\n\n' + header(shape, kind, newton=False)
            return head + writer.text, target.work_size

        about = repr((form, replace(shape, values=shape.values.tolist()), options))
        text, self.work_size = recalled("map", about, written, tuple, list)
        self.shape = shape
        if interpreted:
            self.built = kernel_cache.interpret(text, {}, "")
        else:
            self.built = kernel_cache.build(
                text, ARGUMENTS, tuning=Tuning(pack=kind == "array", seldom=seldom)
            )

    def __call__(
        self, rows: np.ndarray, t0: float, h: float, *, every: int = 1, last: int = 0
    ) -> tuple[int, int]:
        """Replace contiguous rows (m, r, d) in place; of each the first value is given.

        Row n belongs to step ``min(n every, last)``, step 0 to ``t0``. Returns how many rows became
        numbers, and the evaluations.
        """
        tally, work = np.zeros(6, dtype=np.int64), native.aligned_zeros(self.work_size)
        numbers = (t0, h, 0, len(rows), last, every)
        self.built.kernel(work, self.shape.par, *numbers, rows.reshape(-1), 0, tally)
        return int(tally[4]), int(tally[0])


def map_of(
    method: Method | None, problem: Problem, *, interpreted: bool = False, seldom: bool = False
) -> Map | None:
    """Return the kernel of a starting or finishing method, ``None`` where the reference has to do.

    ``seldom``: of one that takes one row now and then, so that compiling it has to be quick.
    """
    return None if method is None else _kept_map(method, expressed(problem), interpreted, seldom)


@lru_cache(maxsize=256)
def _kept_map(method: Method, problem: Problem, interpreted: bool, seldom: bool) -> Map | None:
    shape, palette = shape_of(problem), palette_of(method, problem)
    real = all(
        x.is_real() for c in method.components for m in (c.A, c.B, c.V) for r in m for x in r
    )
    blocks = method.stage_blocks(palette)
    one = method.parts == 1 or not any(block.implicit for block in blocks)
    if not blocks or not real or not one or shape.opaque or method.additive:
        return None
    found = Map(method, shape, palette=palette, interpreted=interpreted, seldom=seldom)
    return None if found.built.engine == "numba" else found
