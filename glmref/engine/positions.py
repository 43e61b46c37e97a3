"""Generated source for rounds on the positions alone, on q'' = g(q).

:class:`SingleRounds` writes those of a single stage, :class:`PositionRounds` those of a Gauss
method. In the mu-form a round of the latter waits for the velocities P_k = p + sum mu_kj L_j and
for the positions Q_i = q + sum mu_ik h b_k P_k. Here the two sums are one,

    Q_i = q + (h c_i p + h^2 sum_j d_ij b_j F_j),    d_ij = sum_k mu_ik b_k mu_kj,

with one product from force to position, and the new position is a sum of the same kind. Rounded
h^2 d_ij b_j, h c_i and h b_k would move Q_i by less than its last bit, but to one side at every
step, which is a drift of what the mu-form conserves. What they lost is put back: a correction,
formed once a step from the predicted forces while the first one is evaluated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from .emit import ScalarTarget, Target
from .forms import StepForm
from .options import Options
from .shape import Shape
from .updates import balanced, linear

#: z and a of each stage, see :mod:`.stages`.
Bases = dict[int, tuple[str, str]]
#: For each stage the terms of its first guess, see :meth:`.stages.StageWriter._prediction`.
Guesses = Sequence[Sequence[tuple[int, bool, float]]]

SPLITTER = 2.0**27 + 1  # Veltkamp's: halves of a double


def halves(x: float) -> tuple[float, float]:
    """Return a double as the sum of two with half as many digits, whose products are exact."""
    high = SPLITTER * x - (SPLITTER * x - x)
    return high, x - high


def split(name: str) -> list[str]:
    """Return the source of the halves ``high`` and ``low`` of a number."""
    whole = f"held - (held - {name})"
    return [f"held = {SPLITTER!r}*{name}", f"high = {whole}", f"low = {name} - high"]


def exact_product(product: str, lost: str, a: str, b: str) -> list[str]:
    """Return the source of a product and of what its rounding lost (Dekker)."""
    rest = f"(((upper*high - {product}) + upper*low + lower*high) + lower*low)"
    return [
        *split(a), "upper = high", "lower = low", *split(b), f"{product} = {a}*{b}",
        f"{lost} = {rest}",
    ]  # fmt: skip


def _split(x: Fraction) -> tuple[float, float]:
    return float(x), float(x - Fraction(float(x)))


class PositionRounds:
    """Writes what a kernel with rounds on the positions needs besides other kernels.

    Vectors: H{j} is the force of stage j, as its last round left it; S and E are the velocity and
    its rounding error and T{j} the force H{j}, all three read as positions; b{i} is what Q_i has
    besides q and the sum, as the first round takes it, v{i}
    the same with what rounding lost, and g what the new position has besides q and its sum.
    """

    def __init__(self, form: StepForm, shape: Shape, options: Options, target: Target) -> None:
        self.form, self.shape, self.options, self.t = form, shape, options, target
        weights, s = [Fraction(x) for x in form.weights], range(form.s)
        mu = [[Fraction(x) for x in row] for row in form.M]
        #: Coefficients of the h b_k P_k in each Q_i, and in the new position.
        self.rows = [*mu, [Fraction(1)] * form.s]
        zero = Fraction(0)
        self.c = [_split(sum((row[k] * weights[k] for k in s), zero)) for row in self.rows]
        self.d = [
            [_split(sum((row[k] * weights[k] * mu[k][j] for k in s), zero)) for j in s]
            for row in self.rows
        ]

    @staticmethod
    def fits(form: StepForm, shape: Shape, options: Options) -> bool:
        """Return whether the form is a Gauss method's, and the system q'' = g(q)."""
        return (
            form.kind == "mu"
            and form.U == ((1.0,),) * form.s
            and (form.R, form.V) == (((1.0,) * form.s,), ((1.0,),))
            and options.solver == "fixed-point"
            and shape.halved
            and shape.parts[0].identity
            and [block.implicit for block in form.blocks] == [True]
        )

    def predict(self, guesses: Guesses) -> None:
        """Write H from the increments of the step before; see :meth:`.StageWriter._prediction`."""
        half = self.shape.half
        rows = [[f"hp{i}_{j}*@L{j}" for j, *_ in row] for i, row in enumerate(guesses)]
        lines = [f"@H{i} = {' + '.join(row)}" for i, row in enumerate(rows)]
        self.t.vec(lines, (half, 2 * half))

    def coefficients(self, guesses: Callable[[], Guesses]) -> None:
        """Write once a call: products with h, their rounding residuals and those of c and d.

        The form is exact for the weights hw as they are rounded, so these are what hd stands for:
        hd_ij F_j is sum_k mu_ik hw_k mu_kj L_j up to m_ij F_j.
        """
        w, n = self.t.w, self.form.s

        def lost(product: str, x: float) -> str:
            a, b = halves(x)
            return f"(((high*{a!r} - {product}) + high*{b!r} + low*{a!r}) + low*{b!r})"

        for i, row in enumerate(guesses()):
            w(*(f"hp{i}_{j} = {x!r}/hw{i}" for j, _, x in row))
        w(*split("h"))
        w(*(f"r{k} = -{lost(f'hw{k}', weight)}" for k, weight in enumerate(self.form.weights)))
        for i, row in enumerate(self.rows):
            c, rest = self.c[i]
            mend = " + ".join(f"{float(x)!r}*r{k}" for k, x in enumerate(row) if x)
            w(f"hc{i} = h*{c!r}", f"m{i} = ({lost(f'hc{i}', c)} + h*{rest!r}) + ({mend})")
        for j in range(n):
            w(*exact_product(f"hh{j}", f"lost{j}", "h", f"hw{j}"), *split(f"hh{j}"))
            for i, row in enumerate(self.rows):
                d, rest = self.d[i][j]
                terms = [(float(x * self.rows[k][j]), f"r{k}") for k, x in enumerate(row)]
                w(f"hd{i}_{j} = hh{j}*{d!r}")
                w(
                    f"m{i}_{j} = ({lost(f'hd{i}_{j}', d)} + lost{j}*{d!r})"
                    f" + hw{j}*(h*{rest!r} + ({linear(terms)}))"
                )

    def _views(self, names: Sequence[tuple[str, str]]) -> None:
        """Read velocity parts of vectors as positions: pairs (vector, its name here)."""
        for source, name in names:
            self.t.local[name] = range(self.shape.half)
            self.t.call(self.shape.parts[0], source, name, "")

    def _slopes(self) -> None:
        """Write T from H."""
        self._views([(f"H{j}", f"T{j}") for j in range(self.form.s)])

    def _sum(self, i: int, *others: str) -> str:
        """Return the others and the forces that Q_i takes, by halves."""
        terms = [f"hd{i}_{j}*@T{j}" for j in range(self.form.s)]
        return balanced([(1.0, term) for term in [*terms, *others]])

    def bases(self, stages: Sequence[int], bases: Bases) -> None:
        """Write b, v and g from the values and the predicted forces."""
        kept, n = self.options.compensated, self.form.s
        self._views([("y0", "S"), *([("e0", "E")] if kept else [])])
        self._slopes()
        lines = []
        for i in range(n + 1):
            terms = [f"m{i}*@S", *([f"hc{i}*@E"] if kept else [])]
            # to e first, beside which it is not lost
            lost = " + ".join([*terms, *(f"m{i}_{j}*@T{j}" for j in range(n))])
            lost = f"@e0 + ({lost})" if kept else lost
            if i == n:
                lines.append(f"@g = {lost}")
                continue
            lines += [f"@b{i} = {'@e0 + ' if kept else ''}hc{i}*@S"]
            lines += [f"@v{i} = ({lost}) + hc{i}*@S"]
        self.t.vec(lines, (0, self.shape.half))

    def stage_values(self, stages: Sequence[int], name: str, base: str) -> None:
        """Write Q_i into the vectors of this name, from b or v."""
        self._slopes()
        lines = [f"@{name}{i} = @y0 + ({self._sum(i, f'@{base}{i}')})" for i in stages]
        self.t.vec(lines, (0, self.shape.half))

    def after_first(self) -> None:
        """Take v in later rounds; b is theirs in the source."""
        lines = [f"@b{i} = @v{i}" for i in range(self.form.s)]
        if isinstance(self.t, ScalarTarget):
            self.t.vec(lines, (0, self.shape.half))
            return
        with self.t.w.block("if rounds == 1:"):
            self.t.vec(lines, (0, self.shape.half))

    def commit(self) -> None:
        """Write the new positions n0 and their rounding errors r0.

        The corrections are smaller than the last bit of the sum u0 that they enter: what u0 does
        not hold of them goes to the error, and so into the next step.
        """
        self._views([("y0", "S")])
        self._slopes()
        n = self.form.s
        lines = [f"@A = hc{n}*@S + ({self._sum(n)})", "@u0 = @g + @A", "@n0 = @y0 + @u0"]
        if self.options.compensated:
            lines.append("@r0 = (@u0 - (@n0 - @y0)) + (@g - (@u0 - @A))")
        self.t.local["A"] = range(self.shape.half)
        self.t.vec(lines, (0, self.shape.half))


class SingleRounds:
    """Writes the rounds of a single stage: Q = b + k F, b = z + (a + m (h w (z' + a'))).

    z and a are the base of Q, z' and a' that of P, m the stage's own coefficient and k = (m h w)^2,
    so that a product and a sum lie between a force and the next position. That k is rounded moves Q
    by a multiple of the force there, which changes neither the symplectic form, for the derivative
    of the force is symmetric, nor the momenta of a force that conserves them. b and the increments,
    formed once, have the operations and coefficients of other kernels.

    Vectors: H{i} is the force as the last round left it.
    """

    def __init__(self, form: StepForm, shape: Shape, options: Options, target: Target) -> None:
        self.form, self.t, self.velocity = form, target, shape.parts[0]
        self.half = half = shape.half
        target.local |= {"T": range(half), "W": range(half, 2 * half)}

    @staticmethod
    def fits(form: StepForm, shape: Shape, options: Options) -> bool:
        """Return whether implicit stages stand alone, and the system is q'' = g(q)."""
        return (
            len(form.components) == 1
            and all(len(block.stages) == 1 for block in form.blocks)
            and options.solver == "fixed-point"
            and shape.halved
            and shape.parts[0].identity
        )

    def coefficients(self, guesses: Callable[[], Guesses]) -> None:
        """Write once a call: k, and what makes a force of an increment."""
        for i in (i for b in self.form.blocks if b.implicit for i in b.stages):
            m = self.form.M[i][i]
            self.t.w(f"ih{i} = 1.0/hw{i}", f"k{i} = ({m!r}*hw{i})*({m!r}*hw{i})")

    def bases(self, stages: Sequence[int], bases: Bases) -> None:
        """Write H from the predicted increment, and b."""
        (i,) = stages
        z, a = bases[i]
        half, small = self.half, [x for x in (a,) if x != "0.0"]
        lines = [f"@H{i} = ih{i}*@L{i}", f"@W = {' + '.join([z, *small])}"]
        self.t.vec(lines, (half, 2 * half))
        self._view("W")
        small.append(f"{self.form.M[i][i]!r}*(hw{i}*@T)")
        self.t.vec([f"@b{i} = {z} + ({' + '.join(small)})"], (0, half))

    def stage_values(self, stages: Sequence[int], name: str, base: str) -> None:
        """Write Q into the vector of this name."""
        (i,) = stages
        self._view(f"H{i}")
        self.t.vec([f"@{name}{i} = @b{i} + k{i}*@T"], (0, self.half))

    def _view(self, source: str) -> None:
        """Read velocity parts as positions, into T."""
        self.t.call(self.velocity, source, "T", "")
