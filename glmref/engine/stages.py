"""Generated source for the stages of one step: bases, predictor, fixed point, Newton.

Stage i is Y = z + (a + M L) with L = h w f(Y): z holds multiples of the solution, a the small
terms, added first so that their low digits survive. On a separable problem the unknown is the p
part of L and one round is P -> q'(P) -> Q -> p'(Q).

Newton's method is in :mod:`.newton`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property

from .arithmetic import NOISE
from .emit import Target
from .forms import StepForm
from .newton import REFRESH_ROUNDS, NewtonWriter
from .options import Options
from .positions import Bases, PositionRounds, SingleRounds
from .shape import Part, Shape
from .tableau import lagrange_weights
from .updates import Term, Values, balanced, differences, linear

NOTHING = 2.0**-64  # change of a stage, relative to the state, that cannot matter: 1/2000 ulp
ROUND_OFF = 2.0**-47  # change of a stage, relative to the state, that can be rounding
STALLS = 8  # rounds without decrease after which NOISE takes its place
ROUNDS = 200

PREDICTOR_NODES = 3  # slopes a single stage is extrapolated from
PREDICTOR_GAP = 0.02  # abscissae closer than this count as one node


class StageWriter(NewtonWriter):
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
        two = len(form.components) > 1
        places = ((0, shape.half), (shape.half, shape.dimension)) if two else (self.all,)
        #: The values of each component; those of a single method are also ``values``.
        self.sides = tuple(
            Values(
                target, one.V, one.R, one.R_residue, one.large, part, running=form.running,
                kept=form.kept(k) if options.compensated else (False,) * len(one.V),
                ahead=two,
            )
            for k, (one, part) in enumerate(zip(form.components, places, strict=True))
        )  # fmt: skip
        self.values = self.sides[0]
        #: Rounds on positions alone, where the stages allow it.
        self.rounds: PositionRounds | SingleRounds | None = None
        for kind in (PositionRounds, SingleRounds):
            if self.rounds is None and kind.fits(form, shape, options):
                self.rounds = kind(form, shape, options, target)
        #: The same of stages that are solved together.
        self.positions = self.rounds if isinstance(self.rounds, PositionRounds) else None

    # --- what a stage starts from ---------------------------------------------------------------

    def _due(self, i: int) -> tuple[Part, ...]:
        """Return the parts of the right-hand side that are evaluated at a stage."""
        if len(self.sides) == 1:
            return self.shape.parts
        if self.form.together:  # once for Q and P, and counted at Q
            return () if self.form.place(i)[0] else self.shape.parts
        return (self.shape.parts[1 - self.form.place(i)[0]],)

    def _at(self, part: Part, stages: Sequence[int]) -> list[int]:
        """Return those of some stages at which a part is evaluated."""
        return [i for i in stages if any(part is due for due in self._due(i))]

    def _base(self, i: int, done: Sequence[int]) -> tuple[str, str]:
        """Return references to z and a of stage i, after writing what they need."""
        side, row = self.form.place(i)
        rows, values = self.form.components[side], self.sides[side]
        big, small = values.read(rows.U[row], alone=not any(rows.M[row]))
        small += self.form.increments(i, done)
        if len(self.form.kick) > 1:
            small = differences(small)
        return self._named(i, big, small, values.part)

    def _named(
        self, i: int, big: list[Term], small: list[Term], part: tuple[int, int]
    ) -> tuple[str, str]:
        """Return names for the two sums of a stage; none where a sum is one vector already."""
        lines, names = [], []
        for letter, terms in (("z", big), ("a", small)):
            text = linear(terms)
            if text != "0.0" and not text.lstrip("@").isidentifier():
                lines.append(f"@{letter}{i} = {text}")
                text = f"@{letter}{i}"
            names.append(text)
        if lines:
            self.t.vec(lines, part)
        return names[0], names[1]

    def _with_residue(self, i: int, z: str, a: str) -> tuple[str, str]:
        """Add the rounding residual of M_ii, times the first guess of L_i, to the small terms.

        Sub-round-off, but of one sign at every step: left out, it is a linear drift.
        """
        lost = self.form.M_residue[i] if self.form.M_residue else 0.0
        if not lost:
            return z, a
        terms = [(lost, f"@L{i}")]
        self.t.vec([f"@a{i} = {linear(terms if a == '0.0' else [(1.0, a), *terms])}"])
        return z, f"@a{i}"

    def _stage_values(
        self, stages: Sequence[int], bases: Bases, part: tuple[int, int], name: str = "Y"
    ) -> None:
        """Write Y = z + (a + M L) for stages of the block that has these bases."""
        lines, total = [], balanced if len(self.sides) == 1 else linear
        for i in stages:
            z, a = bases[i]
            terms = self.form.increments(i, list(bases))
            terms = terms if a == "0.0" else [(1.0, a), *terms]
            lines.append(f"@{name}{i} = {z} + ({total(terms)})")
        self.t.vec(lines, part)

    def _evaluate(self, part: Part, stages: Sequence[int], at: str = "") -> None:
        for i in stages:
            if part.timed:
                self._time(i)
            self.t.call(part, at or f"Y{i}", f"F{i}", f"s{i}")

    def _explicit(self, i: int, base: tuple[str, str], slope: str = "") -> None:
        """Write an explicit stage: its value, what is due there (into ``slope``), its increment."""
        z, a = base
        source, slope = z.removeprefix("@"), slope or f"F{i}"
        self.t.local[f"Y{i}"] = range(*self.all)
        if a != "0.0" or source == z or not source.isidentifier():
            source = f"Y{i}"
            text = z if a == "0.0" else f"{z} + {a}"
            self.t.vec([f"@{source} = {text}"], self.sides[self.form.place(i)[0]].part)
        for part in self._due(i):
            if part.timed:
                self._time(i)
            self.t.call(part, source, slope, f"s{i}")
        self._increment(i, slope)
        self._count([i])

    def _shared_stages(self) -> None:
        """Write explicit stages (Q_i, P_i): the point, one evaluation, both increments."""
        *before, part = self.shape.parts
        n, done = len(self.form.U), []
        if self.form.ahead:
            for due in (part,) if self.form.together else self.shape.parts:
                self._evaluate(due, [0], "P")
            for stage in range(0, n * len(self.sides), n):
                self._increment(stage, "F0")
            self._count([0])
            return
        for k, block in enumerate(self.form.blocks):
            (i,) = block.stages
            if k == 0 and self.form.same_point:
                for stage in (i, n + i):
                    self._increment(stage, "G")
                done += [i, n + i]
                continue
            self.t.local[f"Y{i}"] = range(*self.all)
            for stage in (n + i, i) if before else (i, n + i):
                z, a = self._base(stage, done)
                text = z if a == "0.0" else f"{z} + {a}"
                self.t.vec([f"@Y{i} = {text}"], self.sides[self.form.place(stage)[0]].part)
                if before and stage == n + i:  # q' = f(p), which Q_i may need
                    self._evaluate(before[0], [i])
                    self._increment(stage, f"F{i}")
                    done.append(stage)
            self._evaluate(part, [i])
            for stage in (i, n + i) if not before else (i,):
                self._increment(stage, f"F{i}")
            self._count([i])
            done += [i, n + i]
        if self.form.same_point:
            self.t.vec([f"@G = @F{self.form.blocks[-1].stages[0]}"])

    def _increment(self, i: int, slope: str) -> None:
        """Write L of a stage, and what it adds to running values."""
        side, row = self.form.place(i)
        moved = self.sides[-1 - side]
        lines = moved.adding(row, f"@L{i}") if self.form.running else []
        self.t.vec([f"@L{i} = hw{i}*@{slope}", *lines], moved.part)

    def _count(self, stages: Sequence[int], rounds: str = "") -> None:
        """Count evaluations at stages, times the rounds of their solver."""
        first, last = self.shape.parts[0], self.shape.counted
        for name, part in (("evaluations", last), ("velocities", first)):
            n = len(self._at(part, stages))
            if not n or (name == "velocities" and (first is last or first.identity)):
                continue
            factors = [str(n)] if n > 1 or not rounds else []
            extra = f" + {n}" if rounds and part is not last else ""
            self.w(f"{name} += {'*'.join(factors + ([rounds] if rounds else []))}{extra}")

    # --- predictor ------------------------------------------------------------------------------

    @cached_property
    def _abscissae(self) -> tuple[list[int], int]:
        """Abscissae as whole multiples of a power of two, and that power's inverse."""
        exact = [Fraction(x) for x in self.form.c]
        one = max(x.denominator for x in exact)
        return [x.numerator * (one // x.denominator) for x in exact], one

    def _prediction(self, i: int, block: Sequence[int]) -> list[tuple[int, bool, float]]:
        """Return terms (stage, whether of this step, factor) of the first guess of L_i.

        The slopes f nearest in time, of stages already done and of the step before, extrapolated by
        a polynomial. With abscissae that do not separate them: the same stage one step ago.
        """
        c, one = self._abscissae
        flat = [j for b in self.form.blocks for j in b.stages]
        before = flat[: flat.index(block[0])]
        places = [(abs(c[j] - c[i]), 0, j, c[j]) for j in before]
        places += [(abs(c[j] - one - c[i]), 1, j, c[j] - one) for j in range(self.form.s)]
        wanted = PREDICTOR_NODES if len(block) == 1 else len(block)
        gap = int(Fraction(PREDICTOR_GAP) * one)
        nodes: list[tuple[int, int, int]] = []
        for _, age, j, place in sorted(places):
            if all(abs(place - other) > gap for *_, other in nodes):
                nodes.append((age, j, place))
            if len(nodes) == wanted:
                break
        weights = lagrange_weights([Fraction(place) for *_, place in nodes], Fraction(c[i]))
        w = self.form.weights
        return [
            (j, age == 0, float(x) * (w[i] / w[j]))
            for (age, j, _), x in zip(nodes, weights, strict=True)
            if x
        ]

    def _remembered(self) -> list[int]:
        """Return stages whose L of the step before is needed after L has been overwritten."""
        if len(self.sides) > 1:
            return []
        flat = [j for block in self.form.blocks for j in block.stages]
        needed = set()
        for block in self.form.blocks:
            if block.implicit and self.positions is None:
                for i in block.stages:
                    old = [j for j, now, _ in self._prediction(i, block.stages) if not now]
                    late = [
                        j for j in old if flat.index(j) < flat.index(i) or len(block.stages) > 1
                    ]
                    needed.update(late)
        return sorted(needed)

    def _guesses(self) -> list[list[tuple[int, bool, float]]]:
        """Write :meth:`_prediction` of all stages, where they are one block."""
        stages = range(self.form.s)
        return [self._prediction(i, stages) for i in stages]

    def _predict(self, stages: tuple[int, ...]) -> None:
        if len(self.sides) > 1:
            return  # from the increments as they were
        if self.positions is not None:
            self.positions.predict(self._guesses())
            return
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
        if self.form.memory:
            bases = {i: self._with_residue(i, *bases[i]) for i in stages}
        if implicit:
            self._solve(stages, bases)
            for i in stages if self.form.running else ():
                self.values.add(i, f"@L{i}")
        else:
            self._explicit(stages[0], bases[stages[0]])

    def _solve(self, stages: tuple[int, ...], bases: Bases) -> None:
        """Write rounds, Y from L, f at Y, L from f, until Y is settled.

        Before f is evaluated the new Y is compared with that of the round before: equal Y would
        give the same f again, so the last, confirming, evaluation is never made.
        """
        w = self.w
        if self.rounds is not None:
            self.rounds.bases(stages, bases)
        read = self._at(self.shape.counted, stages)
        self._sizes(self._at(self.shape.parts[0], stages), [bases[i][0] for i in read])
        w("last_change = 1e300", "stalls = 0", "rounds = 0")
        with w.block("while True:"):
            for part in self.shape.parts:
                here = (part.source, part.source_stop)
                if part is self.shape.counted:
                    if self.rounds is not None:
                        self.rounds.stage_values(stages, "N", "b")
                    else:
                        self._stage_values(read, bases, here, "N")
                    self._compare(read)
                    if self.options.solver == "newton":
                        with w.block("if rounds == 1:"):
                            self._prepare_newton(stages)
                    self._evaluate(part, read)
                    if self.options.solver == "newton":
                        self._newton_update(stages)
                    else:
                        self.t.vec([f"{x} = {y}" for x, y in self._slopes(read)], self.inner)
                    if self.quick:
                        with w.block("if settled:"):
                            w("break")
                elif self.rounds is None:
                    self._velocities(part, stages, bases)
            if self.positions is not None:
                self.positions.after_first()
        self._settled(stages, bases)
        w("iterations += rounds")
        self._count(stages, "rounds")
        with w.block("if outcome != 0:"):
            w("break")
        if self.factored_newton:
            with w.block(f"if rounds > {REFRESH_ROUNDS}:"):
                w("slow = True")

    def _slopes(self, stages: Sequence[int]) -> list[tuple[str, str]]:
        """Return what a round of the fixed point makes of the slopes F."""
        if self.rounds is not None:
            return [(f"@H{i}", f"@F{i}") for i in stages]
        return [(f"@L{i}", f"hw{i}*@F{i}") for i in stages]

    def _settled(self, stages: Sequence[int], bases: Bases) -> None:
        """Write what rounds on positions leave to the end: increments."""
        if self.rounds is not None:
            self.t.vec([f"@L{i} = hw{i}*@H{i}" for i in stages], self.inner)
            if self.positions is None:
                self._velocities(self.shape.parts[0], stages, bases)

    def _velocities(self, part: Part, stages: Sequence[int], bases: Bases) -> None:
        """Write, of a separable problem: P, the velocities there, and what they add to q."""
        stages = self._at(part, stages)
        self._stage_values(stages, bases, (part.source, part.source_stop))
        self._evaluate(part, stages)
        self.t.vec([f"@L{i} = hw{i}*@F{i}" for i in stages], (part.start, part.stop))

    def _sizes(self, stages: Sequence[int], z: Sequence[str]) -> None:
        """Write what counts as rounding (``tight``, ``loose``) and as no change (``nothing``).

        A change of components near zero that the others do not notice counts as none.
        """
        names = [x for x in dict.fromkeys(z) if x != "0.0"]
        names += ["h*@S"] if self.positions is not None else [f"@L{i}" for i in stages]
        sizes = " + ".join(f"abs({x})" for x in names)
        self.t.total("size", sizes if len(names) == 1 else f"({sizes})", self.watched)
        self.w(f"nothing = {NOTHING!r}*size")

    @property
    def quick(self) -> bool:
        """Whether a round ends the stages that leaves a change below rounding to the next one."""
        return bool(self.options.quick) and self.options.solver == "fixed-point"

    def _compare(self, stages: Sequence[int]) -> None:
        """Leave the loop where Y is settled; else go on from the new Y."""
        w = self.w
        template = " + ".join(f"abs(@N{i} - @Y{i})" for i in stages)
        self.t.total("change", template if len(stages) == 1 else f"({template})", self.watched)
        if self.quick:
            # what is left is the change times its contraction, as the last two changes show it
            w(f"settled = rounds > 1 and change*change < {self.options.quick!r}*size*last_change")
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
