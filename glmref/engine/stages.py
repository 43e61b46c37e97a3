"""Generated source for the stages of one step: bases, predictor, fixed point, Newton.

Stage i is Y = z + (a + M L) with L = h w f(Y): z holds multiples of the solution, a the small terms,
added first so that their low digits survive. On a separable problem the unknown is the p part of L
and one round is P -> q'(P) -> Q -> p'(Q).

Which solver (:data:`.codegen.Options.solver`):

* *fixed point*: L <- h w f(Y(L));
* *newton*, one stage at a time and at most :data:`INLINE_LIMIT` unknowns: the matrix is written out
  and evaluated afresh at the predicted stage;
* *newton*, otherwise: the matrix of a block is factored once for all stages with an equal diagonal
  and kept from step to step until a solve needs more than :data:`REFRESH_ROUNDS` rounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from .emit import ScalarTarget, Target
from .shape import Part, Shape, inlined, jacobian_block, parameter_names
from .sweep import StepForm
from .tableau import lagrange_weights

if TYPE_CHECKING:
    from .codegen import Options

__all__ = ["HELPERS", "INLINE_LIMIT", "StageWriter", "linear"]

NOTHING = 2.0**-64  # change of a stage, relative to the state, that cannot matter: 1/2000 ulp
ROUND_OFF = 2.0**-47  # change of a stage, relative to the state, that can be rounding
NOISE = 2.0**-30  # the same after STALLS rounds without decrease: a right-hand side that cancels
STALLS = 8
ROUNDS = 200
INLINE_LIMIT = 3
REFRESH_ROUNDS = 5

PREDICTOR_NODES = 3  # slopes a single stage is extrapolated from
PREDICTOR_GAP = 0.02  # abscissae closer than this count as one node

#: Dense elimination with partial pivoting, in the form numba and the interpreter both take.
HELPERS = '''
@compiled
def factor(a, pivots):
    n = len(pivots)
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[p, k]):
                p = i
        pivots[k] = p
        if p != k:
            for j in range(n):
                held = a[k, j]
                a[k, j] = a[p, j]
                a[p, j] = held
        for i in range(k + 1, n):
            ratio = a[i, k] / a[k, k]
            a[i, k] = ratio
            if ratio != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= ratio * a[k, j]


@compiled
def eliminate(a, pivots, b):
    n = len(pivots)
    for k in range(n):
        p = int(pivots[k])
        held = b[k]
        b[k] = b[p]
        b[p] = held
    for i in range(1, n):
        total = b[i]
        for j in range(i):
            total -= a[i, j] * b[j]
        b[i] = total
    for i in range(n - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, n):
            total -= a[i, j] * b[j]
        b[i] = total / a[i, i]
'''


def linear(terms: Sequence[tuple[float, str]]) -> str:
    """Source of a linear combination: zeros dropped, ones not multiplied."""
    text = ""
    for factor, name in terms:
        if factor == 0.0:
            continue
        sign = "-" if factor < 0 else "+"
        body = name if abs(factor) == 1.0 else f"{abs(factor)!r}*{name}"
        if not text:
            text = body if sign == "+" else f"-{body}"
        else:
            text += f" {sign} {body}"
    return text or "0.0"


Bases = dict[int, tuple[str, str]]


class StageWriter:
    """Writes the stages of a step."""

    def __init__(self, form: StepForm, shape: Shape, options: Options, target: Target) -> None:
        self.form, self.shape, self.options, self.t = form, shape, options, target
        self.w = target.w
        self.all = (0, shape.dimension)
        # the components that a stage solver iterates: p of a separable problem, otherwise all
        self.inner = (shape.half, shape.dimension) if shape.halved else self.all
        self.unknowns = self.inner[1] - self.inner[0]
        # the components the counted function reads: those whose change is watched
        self.watched = (shape.counted.source, shape.counted.source_stop)
        self.u_known: set[int] = set()

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

    # --- what a stage starts from ---------------------------------------------------------------

    def _time(self, i: int) -> None:
        """Set ``time`` to that of stage i."""
        if self.shape.uses_time:
            self.w(f"time = start + hc{i}" if self.form.c[i] else "time = start")
        elif any(part.timed and part.formula is None for part in self.shape.parts):
            self.w("time = t0")

    def _base(self, i: int, done: Sequence[int]) -> tuple[str, str]:
        """References to z and a of stage i, after writing what they need."""
        form = self.form
        value = "w" if form.running else "y"
        big: list[tuple[float, str]] = []
        small: list[tuple[float, str]] = []
        for k in range(form.r):
            factor = form.U[i][k]
            if form.large[k]:
                big.append((factor, f"@{value}{k}"))
                if form.running and k in self.u_known:
                    small.append((factor, f"@u{k}"))
                elif not form.running and self.options.compensated:
                    small.append((factor, f"@e{k}"))
            elif form.running and k in self.u_known:
                small.append((factor, f"(@w{k} + @u{k})"))
            else:
                small.append((factor, f"@{value}{k}"))
        small += [(form.M[i][j], f"@L{j}") for j in done]
        lines, z, a = [], linear(big), linear(small)
        if sum(1 for factor, _ in big if factor) != 1 or not z.startswith("@"):
            lines.append(f"@z{i} = {z}")
            z = f"@z{i}"
        if a != "0.0":
            lines.append(f"@a{i} = {a}")
            a = f"@a{i}"
        if lines:
            self.t.vec(lines)
        return z, a

    def _stage_values(
        self, stages: Sequence[int], bases: Bases, part: tuple[int, int], name: str = "Y"
    ) -> None:
        """Y = z + (a + M L) for the stages of a block."""
        lines = []
        for i in stages:
            z, a = bases[i]
            terms = [(self.form.M[i][j], f"@L{j}") for j in stages]
            terms = terms if a == "0.0" else [(1.0, a), *terms]
            lines.append(f"@{name}{i} = {z} + ({linear(terms)})")
        self.t.vec(lines, part)

    def _evaluate(self, part: Part, stages: Sequence[int]) -> None:
        for i in stages:
            if part.timed:
                self._time(i)
            self.t.call(part, f"Y{i}", f"F{i}", f"s{i}")

    def _explicit(self, i: int, base: tuple[str, str]) -> None:
        z, a = base
        self.t.vec([f"@Y{i} = {z}" if a == "0.0" else f"@Y{i} = {z} + {a}"])
        for part in self.shape.parts:
            self._evaluate(part, (i,))
        self.t.vec([f"@L{i} = hw{i}*@F{i}"])
        self._count(1)

    def _count(self, stages: int, rounds: str = "", extra: int = 0) -> None:
        """Count evaluations: the stages of a block, times the rounds of its solver."""
        factors = [str(stages)] if stages > 1 or not rounds else []
        product = "*".join(factors + ([rounds] if rounds else []))
        self.w(f"evaluations += {product}")
        if self.shape.halved and not self.shape.parts[0].identity:
            self.w(f"velocities += {product}" + (f" + {extra}" if extra else ""))

    # --- predictor ------------------------------------------------------------------------------

    def _prediction(self, i: int, block: Sequence[int]) -> list[tuple[int, bool, float]]:
        """Terms (stage, whether of this step, factor) of the first guess of L_i.

        The slopes f nearest in time, of stages already done and of the step before, extrapolated by
        a polynomial. With abscissae that do not separate them: the same stage one step ago.
        """
        c = [Fraction(x) for x in self.form.c]
        flat = [j for b in self.form.blocks for j in b.stages]
        before = flat[: flat.index(block[0])]
        places = [(abs(c[j] - c[i]), 0, j, c[j]) for j in before]
        places += [(abs(c[j] - 1 - c[i]), 1, j, c[j] - 1) for j in range(self.form.s)]
        wanted = PREDICTOR_NODES if len(block) == 1 else len(block)
        nodes: list[tuple[int, int, Fraction]] = []
        for _, age, j, place in sorted(places):
            if all(abs(place - other) > PREDICTOR_GAP for *_, other in nodes):
                nodes.append((age, j, place))
            if len(nodes) == wanted:
                break
        weights = lagrange_weights([place for *_, place in nodes], c[i])
        w = self.form.weights
        return [
            (j, age == 0, float(x) * (w[i] / w[j]))
            for (age, j, _), x in zip(nodes, weights, strict=True)
            if x
        ]

    def _remembered(self) -> list[int]:
        """Stages whose L of the step before is needed after L has been overwritten."""
        flat = [j for block in self.form.blocks for j in block.stages]
        needed = set()
        for block in self.form.blocks:
            if block.implicit:
                for i in block.stages:
                    old = [j for j, now, _ in self._prediction(i, block.stages) if not now]
                    late = [j for j in old if flat.index(j) < flat.index(i) or len(block.stages) > 1]
                    needed.update(late)
        return sorted(needed)

    def _predict(self, stages: tuple[int, ...]) -> None:
        copied = self._remembered()
        lines = []
        for i in stages:
            terms = [
                (x, f"@L{j}" if now or j not in copied else f"@K{j}")
                for j, now, x in self._prediction(i, stages)
            ]
            lines.append(f"@L{i} = {linear(terms)}")
        self.t.vec(lines, self.inner)

    # --- solving --------------------------------------------------------------------------------

    def _block(self, stages: tuple[int, ...], implicit: bool) -> None:
        """Write one block of stages and what it adds to the values."""
        flat = [i for block in self.form.blocks for i in block.stages]
        done = [] if self.form.running else flat[: flat.index(stages[0])]
        bases = {i: self._base(i, done) for i in stages}
        if implicit:
            self._predict(stages)
            self._solve(stages, bases)
        else:
            self._explicit(stages[0], bases[stages[0]])

    def _solve(self, stages: tuple[int, ...], bases: Bases) -> None:
        """Rounds Y from L, f at Y, L from f, until Y is settled.

        Before f is evaluated the new Y is compared with that of the round before: equal Y would
        give the same f again, so the last, confirming, evaluation is never made.
        """
        w = self.w
        self._sizes(stages, [bases[i][0] for i in stages])
        w("last_change = 1e300", "stalls = 0", "rounds = 0")
        with w.block("while True:"):
            for part in self.shape.parts:
                here = (part.source, part.source_stop)
                if part is self.shape.counted:
                    self._stage_values(stages, bases, here, "N")
                    self._compare(stages)
                    if self.options.solver == "newton":
                        with w.block("if rounds == 1:"):
                            self._prepare_newton(stages)
                    self._evaluate(part, stages)
                    if self.options.solver == "newton":
                        self._newton_update(stages)
                    else:
                        self.t.vec([f"@L{i} = hw{i}*@F{i}" for i in stages], self.inner)
                else:
                    self._stage_values(stages, bases, here)
                    self._evaluate(part, stages)
                    outer = (part.start, part.stop)
                    self.t.vec([f"@L{i} = hw{i}*@F{i}" for i in stages], outer)
        w("iterations += rounds")
        self._count(len(stages), "rounds", len(stages))
        with w.block("if outcome != 0:"):
            w("break")
        if self.factored_newton:
            with w.block(f"if rounds > {REFRESH_ROUNDS}:"):
                w("slow = True")

    def _sizes(self, stages: Sequence[int], z: Sequence[str]) -> None:
        """What counts as rounding (``tight``, ``loose``) and as no change at all (``nothing``).

        A change of components near zero that the others do not notice counts as none.
        """
        names = [x for x in dict.fromkeys(z) if x != "0.0"] + [f"@L{i}" for i in stages]
        sizes = " + ".join(f"abs({x})" for x in names)
        self.t.total("size", sizes if len(names) == 1 else f"({sizes})", self.watched)
        self.w(f"nothing = {NOTHING!r}*size")

    def _compare(self, stages: Sequence[int]) -> None:
        """Leave the loop where Y is settled; else go on from the new Y."""
        w = self.w
        template = " + ".join(f"abs(@N{i} - @Y{i})" for i in stages)
        self.t.total("change", template if len(stages) == 1 else f"({template})", self.watched)
        # in the first round there is no Y to compare with
        with w.block("if rounds > 0 and not (nothing < change < last_change):"):
            with w.block(f"if change <= {ROUND_OFF!r}*size:"):
                w("break")
            w("stalls += 1")
            with w.block(f"if stalls > {STALLS} or not (change < 1e300):"):
                with w.block(f"if not (change <= {NOISE!r}*size):"):
                    w("outcome = 1 if rounds > 1 else 2")
                w("break")
        with w.block(f"if rounds >= {ROUNDS}:"):
            w("outcome = 1", "break")
        w("last_change = change if rounds > 0 else 1e300", "rounds += 1")
        self.t.vec([f"@Y{i} = @N{i}" for i in stages], self.watched)

    # --- Newton ---------------------------------------------------------------------------------

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
        """Name of the factored matrix of a block and its size; equal couplings share one."""
        key = "_".join(f"{x:.17g}" for row in self._coupling(stages) for x, _ in row)
        return f"lu_{key}", len(stages) * self.unknowns

    def _view(self, name: str, size: int) -> tuple[str, str]:
        """Source of a matrix in the work array and of its pivots."""
        a = self.t.reserve(name, size * size)
        p = self.t.reserve(f"{name}_pivots", size)
        return f"x[{a}:{a + size * size}].reshape(({size}, {size}))", f"x[{p}:{p + size}]"

    def _factored_update(self, stages: Sequence[int]) -> None:
        low, high = self.inner
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
            f"jacobian_into({time}, x[{source}:{source + d}], par, "
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
                    place = f"x[{start} + ({i * n} + a)*{size} + {j * n} + b]"
                    one = "one - " if i == j else "-"
                    w(f"{place} = {one}{factor!r}*({power})*entry")
        matrix, pivots = self._view(name, size)
        w(f"factor({matrix}, {pivots})")
