"""Generate the source of a kernel: one tableau, one problem shape, a loop over steps.

The source is plain Python on numbers and arrays. numba compiles it as it stands; without numba the
same source runs in the interpreter. Zeros of the tableau cost nothing, ones cost no multiplication,
explicit stages are evaluated once, and the stages of a block that depend on each other are solved
together.

Stage equations L = h w f(z + a + M L) are iterated until the change of L is zero, or is round-off
and no longer decreases; a loose tolerance would show up as drift of the invariants. On a separable
problem one round is Q -> p'(Q) -> P -> q'(P) -> Q, which squares the contraction of a plain fixed
point and evaluates the expensive half once (the *halved form*).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from ..problems.formula import Formula
from .band import Band
from .emit import TARGETS, ScalarTarget, Writer, length_check
from .forms import StepForm
from .kicks import KickWriter
from .newton import COMPLEX_HELPERS, HELPERS
from .options import Options
from .shape import Part, Shape, inlined, jacobian_block, parameter_names, used_parameters
from .updates import balanced, linear

#: Arguments of every generated kernel, in order; see :mod:`.kernel_cache` for their types.
ARGUMENTS = {
    "x": "d*", "par": "d*", "t0": "d", "h": "d", "first": "i", "last": "i", "mark": "i",
    "every": "i", "out": "d*", "row": "i", "tally": "i*",
}  # fmt: skip

#: Systems up to this dimension live in local variables, larger ones in arrays.
SCALAR_LIMIT = 20
SCALAR_STAGE_LIMIT = 256  # and at most this many stage components


@dataclass(frozen=True)
class KernelSource:
    """A generated kernel."""

    text: str  #: Module source; defines ``kernel``.
    #: Length of the work array ``x``. Its head is the state that lasts from step to step, see
    #: :meth:`.forms.StepForm.names`.
    work_size: int
    target: str  #: ``"scalar"`` or ``"array"``.
    #: Stages of the largest block that is solved together, or values that a step turns.
    side_by_side: int = 1


def choose_kind(stages: int, shape: Shape, options: Options) -> str:
    """Return the local variables for small systems, arrays for large ones and for loop bodies."""
    if options.target != "auto":
        return options.target
    if options.interpreted and not any(part.body and not part.straight for part in shape.parts):
        return "scalar"
    small = shape.dimension <= SCALAR_LIMIT and stages * shape.dimension <= SCALAR_STAGE_LIMIT
    return "scalar" if small and not shape.arrays else "array"


def kernel_source(form: StepForm, shape: Shape, options: Options) -> KernelSource:
    """Generate the module for one form, shape and set of options."""
    kind = choose_kind(form.s, shape, options)
    writer = Writer()
    target = TARGETS[kind](shape, writer)
    builder = Builder(form, shape, options, target)
    builder.kernel()
    head = header(shape, kind, newton=builder.factored_newton)
    title = (
        f'"""Generated kernel: {form.kind} form, {form.s} stages, {form.rows} values, '
        f'd = {shape.dimension}."""\n\n'
    )
    if len(form.components) == 1 and not form.formula:
        widest = max((len(block.stages) for block in form.blocks), default=1)
    else:  # values of a multistep method turn independently of each other: vectors fit them
        several = shape.dimension > 2 and (form.together or form.formula)
        widest = form.rows if len(form.kick) > 1 or several else 1
    return KernelSource(title + head + writer.text, target.work_size, kind, widest)


def header(shape: Shape, kind: str, *, newton: bool) -> str:
    """Return imports and the functions that a kernel calls."""
    w = Writer()
    w("from math import atan2, cos, exp, log, sin, sqrt, tan", "")
    # a Jacobian by differences calls the parts as functions, whatever the target
    differenced = newton and shape.differenced
    for part in shape.parts if kind != "scalar" or newton else ():
        if part.body:
            w(
                "",
                "@compiled",
                *((kind != "vector" and part.straight) or part.body).splitlines(),
                "",
            )
        elif part.formula is not None and not part.identity and (kind != "scalar" or differenced):
            w("", "@compiled")
            with w.block(f"def {part.role}({'time, ' if part.timed else ''}v, par, out):"):
                _formula_body(w, shape, part.formula, lambda c: f"out[{c}]")
            w("")
    if newton:
        w(*HELPERS.splitlines(), "", *COMPLEX_HELPERS.splitlines(), "")
        _jacobian_function(w, shape)
    return w.text


def _formula_body(w: Writer, shape: Shape, formula: Formula, entry: Callable[[int], str]) -> None:
    """Write the body of a function of ``v``: parameters, common subexpressions, outputs."""
    for i in used_parameters(shape):
        w(f"par_{shape.parameters[i]} = par[{i}]")
    lines, outputs = inlined(formula, lambda i: f"v[{i}]", parameter_names(shape), "c_")
    places = ((entry(c), text) for c, text in enumerate(outputs) if text != "0")
    written = [f"{place} = {text}" for place, text in places if place]
    w(*lines, *(written or ["return"]))  # a field that vanishes has nothing to write


def _jacobian_function(w: Writer, shape: Shape) -> None:
    """Write ``jacobian_into(time, v, par, out, scratch)`` from a formula, a loop or differences."""
    d, first, size = shape.dimension, len(shape.parameters), len(shape.values)
    body, band = shape.banded_body or shape.jacobian_body, shape.band
    if body and not shape.differenced:
        w("", "@compiled", *body.splitlines(), "")
    w("", "@compiled")
    with w.block("def jacobian_into(time, v, par, out, scratch):"):
        if band is not None:
            with w.block(f"for i in range({len(band.order) * band.width}):"):
                w("out[i] = 0.0")
        else:
            with w.block(f"for i in range({d}):"), w.block(f"for j in range({d}):"):
                w("out[i, j] = 0.0")
        if shape.jacobian is not None:
            rows, columns = range(d), range(d)
            if band is not None and shape.halved:
                rows, columns = range(shape.half, d), range(shape.half)
            formula = jacobian_block(shape, rows, columns)
            _formula_body(w, shape, formula, lambda c: _entry(shape, *divmod(c, len(columns))))
        elif shape.differenced and band is not None:
            _band_differences(w, shape, band)
        elif shape.differenced:
            _differences(w, shape)
        else:
            places = "" if band is None else f", par[{size}:{size + len(band.order)}]"
            w(f"{shape.jacobian_name}(time, v, par[{first}:{size}], out{places})")
    w("")


def _entry(shape: Shape, i: int, j: int) -> str:
    """Return the source of entry (i, j) of the Jacobian, ``""`` beyond the diagonals of a band."""
    band = shape.band
    if band is None:
        return f"out[{i}, {j}]"
    row, column = int(band.places[i]), int(band.places[j])
    if not -band.upper <= row - column <= band.lower:
        return ""
    return f"out[{column * (band.width - 1) + band.upper + row}]"


def _called(w: Writer, shape: Shape, part: Part, place: str) -> None:
    """Write a part of the right-hand side at ``v``, into ``scratch`` from ``place`` on."""
    first, count = len(shape.parameters), part.stop - part.start
    time = "time, " if part.timed else ""
    where = f"v[{part.source}:{part.source_stop}]"
    if part.function is not None:
        w(f"found = {part.role}({time}{where}.copy())", *length_check(part))
        with w.block(f"for c in range({count}):"):
            w(f"scratch[{place} + c] = found[c]")
    elif part.body:
        values = f"par[{first}:{len(shape.values)}]"
        w(f"{part.body_name}({time}{where}, {values}, scratch[{place}:{place} + {count}])")
    else:
        w(f"{part.role}({time}{where}, par, scratch[{place}:{place} + {count}])")


def _band_differences(w: Writer, shape: Shape, band: Band) -> None:
    """Write difference quotients of a band: columns a width apart have no row in common."""
    d, n, part = shape.dimension, len(band.order), shape.counted
    order = len(shape.values) + n
    _called(w, shape, part, "0")
    with w.block(f"for first in range({band.width}):"):
        with w.block(f"for k in range(first, {n}, {band.width}):"):
            w(f"c = {part.source} + int(par[{order} + k])", f"scratch[{2 * d} + k] = v[c]")
            w("v[c] = v[c] + 1.4901161193847656e-08*(abs(v[c]) + 1.0)")
        _called(w, shape, part, str(d))
        with w.block(f"for k in range(first, {n}, {band.width}):"):
            w(f"c = {part.source} + int(par[{order} + k])", f"held = scratch[{2 * d} + k]")
            w("step = v[c] - held", "v[c] = held")
            w(f"low = k - {band.upper} if k > {band.upper} else 0")
            w(f"high = k + {band.lower + 1} if k + {band.lower + 1} < {n} else {n}")
            with w.block("for i in range(low, high):"):
                w(f"row = int(par[{order} + i])")
                w(f"change = scratch[{d} + row] - scratch[row]")
                w(f"out[k*{band.width - 1} + {band.upper} + i] = change/step")


def _differences(w: Writer, shape: Shape) -> None:
    """Write columns of the Jacobian by difference quotients, part by part."""
    d = shape.dimension
    for part in shape.parts:
        if part.identity:
            with w.block(f"for c in range({part.stop - part.start}):"):
                w(f"out[{part.start} + c, {part.source} + c] = 1.0")
            continue
        low, high = part.source, part.source_stop
        with w.block(f"for k in range({low - 1}, {high}):"):
            w(f"place = 0 if k == {low - 1} else {d}")
            w("held = v[k]")
            with w.block(f"if k >= {low}:"):
                w("step = 1.4901161193847656e-08*(abs(held) + 1.0)", "v[k] = held + step")
            count = part.stop - part.start
            _called(w, shape, part, "place")
            with w.block(f"if k >= {low}:"):
                w("v[k] = held")
                with w.block(f"for c in range({count}):"):
                    w(f"out[{part.start} + c, k] = (scratch[{d} + c] - scratch[c])/step")


class Builder(KickWriter):
    """Writes one kernel: the loop over steps and what happens to the values."""

    # --- skeleton -------------------------------------------------------------------------------

    def kernel(self) -> None:
        """Write the function ``kernel``."""
        w = self.w
        w("", "@compiled_with_signature")
        with w.block(f"def kernel({', '.join(ARGUMENTS)}):"):
            self._preamble()
            self.t.load(self._state())
            self._declare()
            w("n = first", "evaluations = 0", "velocities = 0", "iterations = 0")
            w("factorisations = 0", "outcome = 0")
            with w.block("while n < last:"), self._guard():
                if self.shape.uses_time:
                    w("start = t0 + n*h")
                self._begin()
                self._blocks()
                self._commit()
                w("n += 1")
                with w.block("if n == mark:"):
                    self._record()
                    w("row += 1", "mark += every")
            self.t.store(self._state())
            names = ("evaluations", "velocities", "iterations", "factorisations")
            w(*(f"tally[{i}] += {name}" for i, name in enumerate(names)))
            w("tally[4] = n", "tally[5] = row", "return outcome")

    def _preamble(self) -> None:
        """Write what is formed once a call."""
        self.t.parameters()
        if self.shape.loops:
            size = len(self.shape.values)
            self.w(f"constants = par[{len(self.shape.parameters)}:{size}]")
        self._scaled_weights()

    def _blocks(self) -> None:
        """Write all stages of a step."""
        if self.direct or self.leaps:
            (self._direct_stages if self.direct else self._leap)()
            return
        if self.form.together or self.form.ahead:
            self._shared_stages()
            return
        if self.factored_newton:
            self.w("slow = False")
        for block in self.form.blocks:
            self._block(block.stages, block.implicit)
        if self.factored_newton:
            with self.w.block("if slow:"):
                self.w(f"x[{self.t.reserve('fresh', 1)}] = 0.0")

    @contextmanager
    def _guard(self) -> Iterator[None]:
        """End the run at overflow or division by zero in the interpreter, as inf does elsewhere."""
        if not self.options.interpreted:
            yield
            return
        with self.w.block("try:"):
            yield
        with self.w.block("except (ArithmeticError, ValueError) as error:"):
            self.w("trouble.append(error)", "outcome = 2", "break")

    def _scaled_weights(self) -> None:
        if self.direct:
            self._direct_coefficients()
        weights = [w for one in self.form.components for w in one.weights]
        for i, weight in enumerate(weights if not self.direct else ()):
            self.w(f"hw{i} = h" if weight == 1.0 else f"hw{i} = h*{weight!r}")
        if self.rounds is not None:
            self.rounds.coefficients(self._guesses)
        recorded = self.form.kick if self.options.history else self.form.kick[:1]
        self.w(*(f"hk{k} = {kick!r}*h" for k, kick in enumerate(recorded) if kick))
        if self.shape.uses_time:
            for i, c in enumerate(self.form.c):
                if c:
                    self.w(f"hc{i} = h*{c!r}")

    def _declare(self) -> None:
        """Give a value to local variables that the first round of a solver reads."""
        if isinstance(self.t, ScalarTarget):
            implicit = [i for b in self.form.blocks if b.implicit for i in b.stages]
            implicit = self._at(self.shape.counted, implicit)
            names = [self.t.ref(f"Y{i}", c) for i in implicit for c in range(*self.watched)]
            self.w(*(f"{name} = 0.0" for name in names + self._newton_names()))

    def _state(self) -> list[str]:
        """Return vectors that last from call to call, in their order at the head of ``x``."""
        return self.form.names(compensated=self.options.compensated)

    def _record(self) -> None:
        for one, values in zip(self.form.components, self.sides, strict=True):
            for k in range(values.r if self.options.history else 1):
                text = linear([(x, f"@y{j}") for j, x in enumerate(one.from_form[k])])
                if values is not self.values and self.form.kick and self.form.kick[k]:
                    text = f"@y{k} + ({f'@e{k} - ' if values.kept[k] else '-'}hk{k}*@G)"
                self._output(k, text, values.part)

    def _output(self, k: int, text: str, part: tuple[int, int]) -> None:
        """Write value k to the current row of ``out``, an array (rows, values, d) laid flat."""
        d = self.shape.dimension
        size = d * (self.form.rows if self.options.history else 1)
        if isinstance(self.t, ScalarTarget):
            for c in range(*part):
                place = f"out[row*{size} + {k * d + c}]"
                self.w(f"{place} = {self.t.substitute(text, c)}")
        else:
            self.t.vec([f"out[row*{size} + {k * d} + component] = {text}"], part)

    # --- values ---------------------------------------------------------------------------------

    def _begin(self) -> None:
        """Start a step: the values that stages read, and what the predictor needs."""
        for values in self.sides if not self.leaps else ():
            values.begin()
        copies = [f"@K{j} = @L{j}" for j in self._remembered()]
        if copies:
            self.t.vec(copies, self.inner)

    def _commit(self) -> None:
        """Write the new values, their rounding errors, and the check that they are numbers."""
        if self.leaps or self.in_place or self.one_pass:
            self._commit_kicks()
            return
        if self.direct:
            self._direct_values()
        elif self.positions is not None:
            half, values = self.shape.half, self.values
            values.shift()
            self.positions.commit()
            self.t.vec(values.finishing([f"@L{i}" for i in range(self.form.s)]), (half, 2 * half))
        else:
            for values, increments in zip(self.sides, self.moving, strict=True):
                values.finish(increments)
        checks = [f"check{k or ''}" for k in range(len(self.sides))]
        for k, (values, check) in enumerate(zip(self.sides, checks, strict=True)):
            if self.form.ahead:
                self._next_point(k)
                self.t.total(check, "(@P + @F0)", values.part)
            else:
                values.check(check)
        self._finite(" + ".join(checks))
        for values in self.sides:
            self._take(self._pairs(values), [], values.part)

    def _next_point(self, k: int) -> None:
        """Write the part of component k of the next point; what waits for L comes last."""
        one, values = self.form.components[k], self.sides[k]
        factors, last = self.form.coming(k)
        big = [(u, f"@n{j}") for j, u in enumerate(one.U[0]) if one.large[j]]
        before = balanced([(x, f"@y{j}") for j, x in enumerate(factors)])
        moved = linear([(1.0, f"({before})"), (last, self.moving[k][0])])
        self.t.vec([f"@nP = {linear(big)} + ({moved})"], values.part)
