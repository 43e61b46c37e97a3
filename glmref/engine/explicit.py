"""Generated source for explicit methods with their A, U, B, V: few operations between two forces.

A stage is Y = U y + sum (h a_ij) F_j, with products h a_ij formed once; the error of a value that
compensated summation keeps enters the new value, not the stages, whose rounding is as large. For
q'' = g(q) a Runge-Kutta method needs no stages of the velocity (Nyström's form):

    Q_i = q + h c_i p + h^2 sum (A A)_ij F_j
    q+  = q + h p + h^2 sum (b A)_j F_j,   p+ = p + h sum b_j F_j

What rounding takes from the weights h b_j is of one sign at every step; it is put back as one
multiple of the first slope, which leaves h times as much.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from .positions import SPLITTER, halves
from .stages import StageWriter
from .updates import linear


class ExplicitWriter(StageWriter):
    """Writes the steps of explicit forms."""

    @property
    def direct(self) -> bool:
        """Whether the form is A, U, B, V with explicit stages, and no multistep formula."""
        form = self.form
        if len(form.components) > 1 or form.running or form.implicit_stages or form.ahead:
            return False
        return all(x == 1.0 for x in form.weights)

    @property
    def nystrom(self) -> bool:
        """Whether there are no stages of the velocity: Runge-Kutta on q'' = g(q)."""
        return self.direct and self.form.r == 1 and self.shape.halved and (
            self.shape.parts[0].identity and self.form.U == ((1.0,),) * self.form.s
            and self._exact_weights(0) is not None
        )  # fmt: skip

    def _exact_weights(self, k: int) -> list[Fraction] | None:
        """Return weights of a row with their residue.

        ``None`` for r = 1 where they do not add up to 1.
        """
        rows = zip(self.form.R[k], self.form.R_residue[k], strict=True)
        weights = [Fraction(x) + Fraction(rest) for x, rest in rows]
        return weights if abs(sum(weights) - 1) < Fraction(1, 10**30) else None

    def _combined(self) -> dict[int, Fraction]:
        """Return weights b A of the forces in the new position that are not zero."""
        A, b, s = self.form.M, self._exact_weights(0), range(self.form.s)
        assert b is not None
        sums = {k: sum((b[i] * Fraction(A[i][k]) for i in s), Fraction(0)) for k in s}
        return {k: x for k, x in sums.items() if x}

    # --- coefficients ---------------------------------------------------------------------------

    def _direct_coefficients(self) -> None:
        """Write products with h, and the rounding residuals of those of the weights."""
        form, w = self.form, self.w
        if self.nystrom:
            A = [[Fraction(x) for x in row] for row in form.M]
            s = range(form.s)
            for i in s:
                square = [sum(A[i][j] * A[j][k] for j in s) for k in s]
                if any(A[i]):
                    w(f"hc{i} = h*{float(sum(A[i]))!r}")
                w(*(f"ha{i}_{k} = (h*h)*{float(x)!r}" for k, x in enumerate(square) if x))
            w(*(f"hv_{k} = (h*h)*{float(x)!r}" for k, x in self._combined().items()))
        else:
            for i, row in enumerate(form.M):
                w(*(f"ha{i}_{j} = h*{x!r}" for j, x in enumerate(row) if x))
        for k, row in enumerate(form.R):
            w(*(f"hb{k}_{j} = h*{x!r}" for j, x in enumerate(row) if x))
            if self.options.compensated and any(row):
                self._lost(k)

    def _lost(self, k: int) -> None:
        """Write lo{k}: the sum of exact minus rounded h b_j of a row (Dekker's product)."""
        w = self.w
        w(f"held = {SPLITTER!r}*h", "high = held - (held - h)", "low = h - high", f"lo{k} = 0.0")
        rows = zip(self.form.R[k], self.form.R_residue[k], strict=True)
        for j, (x, rest) in enumerate(rows):
            if x:
                a, b = halves(x)
                w(
                    f"lo{k} = lo{k} + (((high*{a!r} - hb{k}_{j}) + high*{b!r} + low*{a!r})"
                    f" + low*{b!r} + h*{rest!r})"
                )

    # --- stages and values ----------------------------------------------------------------------

    def _direct_stages(self) -> None:
        force, read = self.shape.counted, set[int]()
        if self.nystrom:
            read = set(self._combined()).union(*map(self._earlier, range(self.form.s)))
            # what lies in the p half, read as a part of the q half
            self.t.call(self.shape.parts[0], "y0", "S", "s")
        for block in self.form.blocks:
            (i,) = block.stages
            big, small = self.values.read(self.form.U[i], alone=True)
            z = linear([*big, *small])
            if self.nystrom:
                terms = [f"hc{i}*@S"] if any(self.form.M[i]) else []
                known = self._earlier(i)
                terms += [f"ha{i}_{j}*@T{j}" for j in known]
                source = self._sum(i, z, terms, (force.source, force.source_stop))
                self.t.call(force, source, f"F{i}", f"s{i}")
                if i in read:
                    self.t.call(self.shape.parts[0], f"F{i}", f"T{i}", f"t{i}")
            else:
                terms = [f"ha{i}_{j}*@F{j}" for j, x in enumerate(self.form.M[i]) if x]
                source = self._sum(i, z, terms, self.all)
                for part in self.shape.parts:
                    if part.timed:
                        self._time(i)
                    self.t.call(part, source, f"F{i}", f"s{i}")
            self._count([i])

    def _earlier(self, i: int) -> list[int]:
        """Return stages that stage i of Nyström's form reads."""
        A, s = self.form.M, range(self.form.s)
        return [k for k in s if sum(Fraction(A[i][j]) * Fraction(A[j][k]) for j in s)]

    def _sum(self, i: int, z: str, terms: Sequence[str], part: tuple[int, int]) -> str:
        """Write Y_i = z + terms and return its name; the last term is the one waited for."""
        if not terms and z.startswith("@") and z[1:].isidentifier():
            return z[1:]
        *first, last = terms or [""]
        text = f"({z} + ({' + '.join(first)}))" if first else z
        self.t.vec([f"@Y{i} = {text} + {last}" if last else f"@Y{i} = {z}"], part)
        return f"Y{i}"

    def _direct_values(self) -> None:
        """Write the new values in n{k} and their rounding errors in r{k}."""
        values, form, half = self.values, self.form, self.shape.half
        values.shift()
        for k, row in enumerate(form.R):
            weighted = [f"hb{k}_{j}*@F{j}" for j, x in enumerate(row) if x]
            if not weighted:
                self.t.vec(values.new(k, ""), self.all)
                continue
            if self.options.compensated:
                weighted.insert(0, f"lo{k}*@F{next(j for j, x in enumerate(row) if x)}")
            if not self.nystrom:
                self.t.vec(values.new(k, " + ".join(weighted)), self.all)
                continue
            moved = ["h*@S", *(f"hv_{j}*@T{j}" for j in self._combined())]
            self.t.vec(values.new(k, " + ".join(moved)), (0, half))
            self.t.vec(values.new(k, " + ".join(weighted)), (half, self.shape.dimension))
