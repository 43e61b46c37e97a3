"""Kernels for partitioned pairs on separable problems: q' = dq(p), p' = dp(q).

Stages Q (where dp is evaluated) and P (where dq is) come one after another; each function is called
only where its stage is due. The coefficients are those of :mod:`.partitioned_forms`.
"""

from __future__ import annotations

from collections.abc import Sequence

from .codegen import Builder, KernelSource, Options, choose_kind, header
from .emit import TARGETS, ArrayTarget, ScalarTarget, Target, Writer
from .partitioned_forms import Half, PairForm
from .shape import Shape
from .updates import Values, differences, linear


def pair_source(form: PairForm, shape: Shape, options: Options) -> KernelSource:
    """Generate the module for a pair on a separable problem."""
    kind = choose_kind(form.Q.n + form.P.n, shape, options)
    writer = Writer()
    target = TARGETS[kind](shape, writer)
    PairBuilder(form, shape, options, target).kernel()
    title = f'"""Generated kernel: pair, {form.kind} form, {form.P.n} P and {form.Q.n} Q stages."""'
    head = header(shape, kind, newton=False)
    text = title + "\n\n" + head + writer.text
    # values of a multistep method turn independently of each other: vectors fit them
    together = form.rows if len(form.kick) > 1 else 1
    return KernelSource(text, target.work_size, form.rows, len(form.memory), kind, together)


class PairBuilder(Builder):
    """Writes one kernel for a pair; y{k} holds q_k in its left and p_k in its right half.

    Stage vectors are numbered by node: Q_j is j, P_i is n_Q + i. L of a Q stage lives in the right
    half (it updates p), L of a P stage in the left.
    """

    form: PairForm  # type: ignore[assignment]

    def __init__(self, form: PairForm, shape: Shape, options: Options, target: Target) -> None:
        super().__init__(form, shape, options, target)  # type: ignore[arg-type]
        m, d = shape.half, shape.dimension
        kinds = {"running": form.running, "ahead": True}
        kept_hat = form.kept_hat if options.compensated else False
        P, Q = form.P, form.Q
        self.in_place = False
        #: Multistep methods with arrays: whether all values of p are made in one pass.
        self.one_pass = False
        if isinstance(target, ArrayTarget) and len(form.kick) > 1 and (Q.n, P.n) == (1, 1):
            self.one_pass = True
            target.passing |= {"L0", *(f"{x}{k}" for x in "xunr" for k in range(form.r_hat))}
        if isinstance(target, ArrayTarget) and form.running:
            self.in_place = True
            # what a stage sees and its increment serve the values at once, and nothing later; new
            # values are written where the old ones were
            target.passing |= {f"{x}{i}" for x in "aL" for i in range(Q.n + P.n)}
            target.passing |= {f"{x}{k}" for x in "nr" for k in range(form.rows)}
        #: Whether the method is Störmer and Verlet's, and the system q'' = g(q).
        self.leaps = form.leaps and shape.parts[0].identity
        if self.leaps and isinstance(target, ArrayTarget):
            target.passing = {"u0", "n0", "r0"}
        self.sides = (
            Values(
                target, form.V, P.R, P.R_residue, form.large, (0, m),
                compensated=options.compensated, **kinds,
            ),
            Values(
                target, form.V_hat, Q.R, Q.R_residue, form.large_hat, (m, d),
                compensated=kept_hat, **kinds,
            ),
        )  # fmt: skip

    def _declare(self) -> None:
        if isinstance(self.t, ScalarTarget):
            at_q = [
                j for b in self.form.blocks if b.implicit for j in b.stages if j < self.form.Q.n
            ]
            self.w(*(f"{self.t.ref(f'Y{j}', c)} = 0.0" for j in at_q for c in range(*self.watched)))

    def _scaled_weights(self) -> None:
        for half, shift in ((self.form.Q, 0), (self.form.P, self.form.Q.n)):
            for i, weight in enumerate(half.weights):
                self.w(f"hw{i + shift} = h" if weight == 1.0 else f"hw{i + shift} = h*{weight!r}")
        recorded = self.form.kick if self.options.history else self.form.kick[:1]
        self.w(*(f"hk{k} = {kick!r}*h" for k, kick in enumerate(recorded) if kick))

    def _record(self) -> None:
        for part, basis in zip((0, 1), self.form.from_form, strict=True):
            low, high = ((0, self.shape.half), (self.shape.half, self.shape.dimension))[part]
            for k in range(len(basis)) if self.options.history else range(1):
                text = linear([(x, f"@y{j}") for j, x in enumerate(basis[k])])
                if part and self.form.kick and self.form.kick[k]:
                    kept = self.options.compensated and self.form.kept_hat[k]
                    text = f"@y{k} + ({f'@e{k} - ' if kept else '-'}hk{k}*@G)"
                self._output(k, text, (low, high))

    def _begin(self) -> None:
        for values in self.sides if not self.leaps else ():
            values.begin()

    def _leap(self) -> None:
        """A step of Störmer and Verlet's method on q'' = g(q).

        In the left half of G is what q moves by, formed at the end of the step before as
        (e + h p) + h (h g): from a force to the next position there are two products and two sums,
        where the new p as an intermediate result would take a product and four sums. The product
        with a rounded h^2 would move q to one side at every step, a drift of the momentum.
        """
        q = self.sides[0].part
        self.t.local |= {"Y0": range(*self.all), "S": range(*q), "T": range(*q)}
        self.t.call(self.shape.parts[0], "y0", "S", "")
        lost = "(@G - (@Y0 - @y0)) + " if self.options.compensated else ""
        self.t.vec(["@Y0 = @y0 + @G", f"@a0 = {lost}hw1*@S"], q)
        self.t.call(self.shape.parts[1], "Y0", "F0", "s0")
        self._evaluations_of_explicit_stages()

    def _landed(self) -> None:
        """The values after :meth:`_leap`, if they are numbers."""
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
        """What becomes what when the step is good: values, and the force they are kicked by."""
        if not self.form.kick or values is self.sides[0]:
            return values.pairs()
        return [*values.pairs(), ("@G", f"@F{self.form.blocks[-1].stages[0]}")]

    def _accept(self, values: Values) -> None:
        self._take(self._pairs(values), [], values.part)

    def _take(self, pairs: list[tuple[str, str]], before: list[str], part: tuple[int, int]) -> None:
        """The step is good: old becomes new, after the statements that make what is new."""
        self.t.vec(before + self._taking(pairs), part)

    def _blocks(self) -> None:
        if self.leaps:
            self._leap()
            return
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

    def _base_of(
        self, node: int, done: Sequence[int], *, implicit: bool = False
    ) -> tuple[str, str]:
        """z and a of a stage from values and from increments already known."""
        half, i, side = self._side(node)
        alone = not implicit and not any(half.M[i])
        big, small = self.sides[side].read(half.U[i], alone=alone)
        if not self.form.running:
            # a Q stage reads increments of P stages, and the other way round
            n = self.form.Q.n
            others = [j for j in done if (j < n) != (node < n)]
            small += [(half.M[i][j if j < n else j - n], f"@L{j}") for j in others]
        if len(self.form.kick) > 1:
            small = differences(small)
        return self._named(node, big, small, self.sides[side].part)

    def _node(self, node: int, done: Sequence[int]) -> None:
        """One explicit stage: its value, its function, its increment.

        A force that is kept from step to step is G: at a first stage Q it is known, at the last one
        it is evaluated anew. Kicked values need that of the last good step, so that it becomes G
        together with them.
        """
        _, i, side = self._side(node)
        self.t.local[f"Y{node}"] = range(*self.all)
        known = self.form.reuses_force and not self.form.kick
        ends = {self.form.blocks[k].stages[0] for k in ((0, -1) if known else ())}
        slope = "G" if node in ends else f"F{node}"
        if slope != "G" or done:
            z, a = self._base_of(node, done)
            source = z.removeprefix("@")
            if a != "0.0" or source == z or not source.isidentifier():
                source = f"Y{node}"
                text = z if a == "0.0" else f"{z} + {a}"
                self.t.vec([f"@{source} = {text}"], self.sides[side].part)
            self.t.call(self.shape.parts[1 - side], source, slope, f"s{node}")
        lines = [f"@L{node} = hw{node}*@{slope}"]
        if self.form.running:
            lines += self.sides[1 - side].adding(i, f"@L{node}")
        if not (self.one_pass and side == 0):
            self.t.vec(lines, self.sides[1 - side].part)

    def _call(self, node: int) -> None:
        """L of a stage from its value Y."""
        _, _, side = self._side(node)
        self.t.call(self.shape.parts[1 - side], f"Y{node}", f"F{node}", f"s{node}")
        self.t.vec([f"@L{node} = hw{node}*@F{node}"], self.sides[1 - side].part)

    def _evaluations_of_explicit_stages(self) -> None:
        n = self.form.Q.n
        single = [b.stages[0] for b in self.form.blocks if not b.implicit]
        self.w(f"evaluations += {self.form.forces}")
        if not self.shape.parts[0].identity:
            self.w(f"velocities += {sum(1 for node in single if node >= n)}")

    def _implicit(self, nodes: Sequence[int], done: Sequence[int]) -> None:
        """Stages that depend on each other: rounds P -> dq -> Q -> dp until Q is settled."""
        w, n = self.w, self.form.Q.n
        at_q, at_p = [j for j in nodes if j < n], [j for j in nodes if j >= n]
        bases = {node: self._base_of(node, done, implicit=True) for node in nodes}

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
        if self.leaps:
            self._landed()
            return
        n = self.form.Q.n
        names = ([f"@L{n + i}" for i in range(self.form.P.n)], [f"@L{j}" for j in range(n)])
        if self.in_place:
            self._commit_in_place(names)
            return
        if self.one_pass:
            self._commit_in_one_pass(names)
            return
        for values, increments, check in zip(
            self.sides, names, ("check_q", "check_p"), strict=True
        ):
            values.finish(increments)
            values.check(check)
        self._finite("check_q + check_p")
        for values in self.sides:
            self._accept(values)

    def _commit_in_place(self, names: tuple[list[str], list[str]]) -> None:
        """Check the sum first: then new values go where the old ones were, in one pass."""
        whole = self.sides[0].coming() == self.sides[1].coming()
        for values, check in zip(self.sides, ("check_q", "check_p"), strict=True):
            if check == "check_q" or not whole:
                self.t.total(check, f"({values.coming()})", self.all if whole else values.part)
        self._finite("check_q" if whole else "check_q + check_p")
        for values, increments in zip(self.sides, names, strict=True):
            self._take(self._pairs(values), values.finishing(increments), values.part)

    def _commit_in_one_pass(self, names: tuple[list[str], list[str]]) -> None:
        """Check the new position and the force, which all new values are made of; then the same."""
        q, p = self.sides
        if self.shape.parts[0].identity:  # one pass: the force, read as positions
            self.t.call(self.shape.parts[0], "F0", "T", "")
            self.t.total("check", "(@Y0 + @T)", q.part)
            self._finite("check")
        else:
            self.t.total("check_q", "@Y0", q.part)
            self.t.total("check_p", "@F0", p.part)
            self._finite("check_q + check_p")
        self.t.vec(["@L0 = hw0*@F0"], p.part)
        for values, increments in zip((p, q), names[::-1], strict=True):
            values.shift()
            self._take(self._pairs(values), values.finishing(increments), values.part)
