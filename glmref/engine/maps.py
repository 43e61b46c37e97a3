"""Starting and finishing methods as kernels: one value in, some values out, for many rows at once.

On right-hand sides that need no Python, and where the fixed point solves what is implicit: what
else there is stays with :mod:`.reference`, which takes some 7 microseconds for a stage where a
kernel takes nanoseconds. Implicit stages begin from slopes of zero in every row, so that a row does
not depend, to the last bit, on those before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..method import Method
from ..problems.model import Problem
from . import kernel_cache, native
from .codegen import ARGUMENTS, Builder, choose_kind, header
from .emit import TARGETS, ScalarTarget, Writer
from .forms import Rows, StepForm, float_rows, floats
from .kept import expressed, recalled
from .native import Tuning
from .options import Options
from .shape import Shape, shape_of


class _MapBuilder(Builder):
    """Writes a kernel that replaces each row of ``out`` by what a tableau makes of it.

    Rows are r values long, of which the first one comes in. ``first`` and ``last`` count rows; row
    n belongs to step ``n * every``, but no later one than ``mark``.
    """

    def _prediction(self, i: int, block: Sequence[int]) -> list[tuple[int, bool, float]]:
        """See :meth:`.StageWriter._prediction`: there is no row before, so its slopes are zero."""
        first = self.form.blocks[0].stages
        return [] if block[0] in first else super()._prediction(i, block)

    def kernel(self) -> None:
        """Write the function ``kernel``."""
        w, d, r = self.w, self.shape.dimension, self.form.r
        w("", "@compiled_with_signature")
        with w.block(f"def kernel({', '.join(ARGUMENTS)}):"):
            self._preamble()
            self._declare()
            w("n = first", "evaluations = 0", "velocities = 0", "outcome = 0", "iterations = 0")
            with w.block("while n < last:"), self._guard():
                w(f"place = n*{d * r}")
                w("taken = n*every if n*every < mark else mark", "start = t0 + taken*h")
                self._moved("@y0 = {}", 0)
                increments = [f"@L{i}" for i in range(self.form.s)]
                if not self.direct:
                    self.t.vec([f"{name} = 0.0" for name in increments])
                self._begin()
                self._blocks()
                if self.direct:
                    self._direct_values()
                else:
                    self.values.finish(increments)
                self.values.check("check")
                self._finite("check")
                for k in range(r):
                    self._moved(f"{{}} = @n{k}", k)
                w("n += 1")
            w("tally[0] += evaluations", "tally[1] += velocities", "tally[4] = n")
            w("return outcome")

    def _moved(self, template: str, k: int) -> None:
        """Write a statement for the entries of value k in the current row."""
        d = self.shape.dimension
        if isinstance(self.t, ScalarTarget):
            for c in range(d):
                self.w(self.t.substitute(template.format(f"out[place + {k * d + c}]"), c))
        else:
            self.t.vec([template.format(f"out[place + {k * d} + component]")])


class Map:
    """A tableau with one value coming in, compiled on a problem."""

    def __init__(self, method: Any, shape: Shape, *, interpreted: bool) -> None:
        (component,) = method.components
        A, B, V = component.A, component.B, component.V
        s, r = len(A), len(V)
        zero = ((0.0,) * s,) * r
        rows = Rows(
            U=((1.0,),) * s, M=float_rows(A), weights=(1.0,) * s, V=float_rows(V),
            R=float_rows(B) if s else zero, R_residue=zero,
            large=tuple(bool(x) for (x,) in float_rows(V)), to_form=(), from_form=(),
        )  # fmt: skip
        times = floats(method.times[0])
        form = StepForm("standard", False, (rows,), method.stage_blocks(), times)
        options = Options(compensated=False, interpreted=interpreted)
        kind = choose_kind(s, shape, options)

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
            self.built = kernel_cache.build(text, ARGUMENTS, tuning=Tuning(pack=kind == "array"))

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


def map_of(method: Method | None, problem: Problem, *, interpreted: bool = False) -> Map | None:
    """Return the kernel of a starting or finishing method.

    ``None`` for what the reference has to do.
    """
    if method is None or method.parts != 1:
        return None
    return _kept_map(method, expressed(problem), interpreted)


@lru_cache(maxsize=256)
def _kept_map(method: Any, problem: Problem, interpreted: bool) -> Map | None:
    (c,), shape = method.components, shape_of(problem)
    real = all(x.is_real() for m in (c.A, c.B, c.V) for row in m for x in row)
    if not c.A or not real or shape.opaque:
        return None
    found = Map(method, shape, interpreted=interpreted)
    return None if found.built.engine == "numba" else found
