"""Generated source for methods of two components whose force is kept from step to step.

The last kick of a step and the first one of the next are one (:func:`.sweep.merged`), or the force
at the end of a step is that at the beginning of the next. With arrays the passes over memory are
what a step costs; new values are made where they are checked.
"""

from __future__ import annotations

from collections.abc import Sequence

from .emit import INFINITE, ArrayTarget, Target
from .explicit import ExplicitWriter
from .forms import StepForm
from .options import Options
from .shape import Shape
from .updates import Values


class KickWriter(ExplicitWriter):
    """Writes what a kept force and kicks that are put together change in a step.

    y{k} holds q_k in its left and p_k in its right half, and so do L of a stage P and of a stage Q.
    """

    def __init__(self, form: StepForm, shape: Shape, options: Options, target: Target) -> None:
        super().__init__(form, shape, options, target)
        two, names = len(self.sides) > 1, [f"@L{i}" for i in range(form.s)]
        Q, P = names[: len(form.U)], names[len(form.U) :]
        #: The increments that move each component.
        self.moving = (P, Q) if two else (Q,)
        arrays = isinstance(target, ArrayTarget)
        #: Multistep methods with arrays: whether all values of p are made in one pass.
        self.one_pass = arrays and len(form.kick) > 1
        #: Stages Q whose increments no stage P reads: with one pass they are made there.
        self.late = [i for i, _ in enumerate(Q) if not any(row[i] for row in form.components[-1].M)]
        #: Whether new values are written where the old ones were.
        self.in_place = arrays and two and form.running
        #: Whether the method is Störmer and Verlet's, and the system q'' = g(q).
        self.leaps = form.leaps and shape.parts[0].identity
        if isinstance(target, ArrayTarget) and self.one_pass:
            target.passing |= {f"L{i}" for i in self.late} | {f"a{i}" for i in range(form.s)}
            target.passing |= {f"{x}{k}" for x in "xunr" for k in range(form.rows)}
        if isinstance(target, ArrayTarget) and self.in_place:
            # what a stage sees and its increment serve the values at once, and nothing later
            target.passing |= {f"{x}{i}" for x in "aL" for i in range(form.s)}
            target.passing |= {f"{x}{k}" for x in "nr" for k in range(form.rows)}
        if isinstance(target, ArrayTarget) and self.leaps:
            target.passing = {"u0", "n0", "r0"}

    def _finite(self, total: str) -> None:
        with self.w.block(f"if not (abs({total}) < {INFINITE}):"):
            self.w("outcome = 2", "break")

    def _taking(self, pairs: Sequence[tuple[str, str]], condition: str = "good") -> list[str]:
        """Return statements by which old becomes new; in lanes, where the condition holds."""
        return [f"{old} = {new}" for old, new in pairs]

    def _explicit(self, i: int, base: tuple[str, str], slope: str = "") -> None:
        """Keep the force as G: known at the first stage, evaluated again at the last one.

        Kicked values need that of the last good step, so that it becomes G together with them.
        """
        first, last = self.form.blocks[0].stages[0], self.form.blocks[-1].stages[0]
        known = self.form.reuses_force and not self.form.kick
        if known and i == first:
            self._increment(i, "G")
        else:
            super()._explicit(i, base, "G" if known and i == last else "")

    def _increment(self, i: int, slope: str) -> None:
        """See :class:`.stages.StageWriter`; what is made in one pass is made at its end."""
        if not (self.one_pass and i in self.late):
            super()._increment(i, slope)

    def _leap(self) -> None:
        """Write a step of Störmer and Verlet's method on q'' = g(q).

        In the left half of G is what q moves by, formed at the end of the step before as
        (e + h p) + h (h g): from a force to the next position there are two products and two sums,
        where the new p as an intermediate result would take a product and four sums. The product
        with a rounded h^2 would move q to one side at every step, a drift of the momentum.
        """
        q = self.values.part
        self.t.local |= {"Y0": range(*self.all), "S": range(*q), "T": range(*q)}
        self.t.call(self.shape.parts[0], "y0", "S", "")
        lost = "(@G - (@Y0 - @y0)) + " if self.options.compensated else ""
        self.t.vec(["@Y0 = @y0 + @G", f"@a0 = {lost}hw1*@S"], q)
        self.t.call(self.shape.parts[1], "Y0", "F0", "s0")
        self._count([0])

    def _landed(self) -> None:
        """Write the values after :meth:`_leap`, if they are numbers."""
        (q, p), kept = (values.part for values in self.sides), self.options.compensated
        self.t.call(self.shape.parts[0], "F0", "T", "")
        # the velocity that q has been moved by is in Y0
        self.t.total("check", "(@Y0 + @T)", q)
        self._finite("check")
        self._take([("@y0", "@Y0"), ("@G", "@a0 + hw1*(hw0*@T)")], [], q)
        new = [f"@u0 = {'@e0 + ' if kept else ''}hw0*@F0", "@n0 = @y0 + @u0"]
        pairs = [("@y0", "@n0"), ("@G", "@F0")]
        if kept:
            new += ["@r0 = @u0 - (@n0 - @y0)"]
            pairs += [("@e0", "@r0")]
        self._take(pairs, new, p)

    def _pairs(self, values: Values) -> list[tuple[str, str]]:
        """Return what an accepted step replaces: the values and the force that kicks them."""
        if not self.form.kick or values is self.values:
            return values.pairs() + [("@P", "@nP")] * self.form.ahead
        return [*values.pairs(), ("@G", f"@F{self.form.blocks[-1].stages[0]}")]

    def _take(self, pairs: list[tuple[str, str]], before: list[str], part: tuple[int, int]) -> None:
        """Write the replacements of an accepted step, after what makes the new values."""
        self.t.vec(before + self._taking(pairs), part)

    def _commit_kicks(self) -> None:
        """Write the values after a leap, or after a step that passes over its arrays once."""
        if self.leaps:
            self._landed()
        elif self.in_place:
            self._commit_in_place()
        else:
            self._commit_in_one_pass()

    def _commit_in_place(self) -> None:
        """Check the sum first: then new values go where the old ones were, in one pass."""
        whole = self.sides[0].coming() == self.sides[1].coming()
        for values, check in zip(self.sides, ("check_q", "check_p"), strict=True):
            if check == "check_q" or not whole:
                self.t.total(check, f"({values.coming()})", self.all if whole else values.part)
        self._finite("check_q" if whole else "check_q + check_p")
        for values, increments in zip(self.sides, self.moving, strict=True):
            self._take(self._pairs(values), values.finishing(increments), values.part)

    def _commit_in_one_pass(self) -> None:
        """Check the new position and the forces that new values are made of; then the same."""
        q, p = self.sides
        last, stages = self.form.blocks[-1].stages[0], range(len(self.form.U))
        if self.shape.parts[0].identity:  # one pass: the forces, read as positions
            for i in stages:
                self.t.call(self.shape.parts[0], f"F{i}", f"T{i}", "")
            self.t.total("check", f"(@Y{last} + {' + '.join(f'@T{i}' for i in stages)})", q.part)
            self._finite("check")
        else:
            self.t.total("check_q", f"@Y{last}", q.part)
            self.t.total("check_p", f"({' + '.join(f'@F{i}' for i in stages)})", p.part)
            self._finite("check_q + check_p")
        self.t.vec([f"@L{i} = hw{i}*@F{i}" for i in self.late], p.part)
        for values, increments in zip((p, q), self.moving[::-1], strict=True):
            values.shift()
            self._take(self._pairs(values), values.finishing(increments), values.part)
