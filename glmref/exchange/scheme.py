"""What an exported stepper computes: tableaux for start, step and finish in one common form.

Start, step and finish are the same kind of thing. With x the values that come in and x+ those that
go out,

    Y = U x + h A F      F_i = f(Y_i)      x+ = V x + h B F

where U is (s, n), V is (m, n): n = 1 for a starting or finishing method. A pair for q' = f(p),
p' = k(q) has this form too: x stacks the values of q on those of p, stages Q use k and stages P use
f, and

    A = [0 A; A^ 0]   U = [U 0; 0 U^]   B = [0 B; B^ 0]   V = [V 0; 0 V^].

So one routine of some twenty lines serves every method. Where the solution is a combination of
several values (the velocity of a multistep method, say) the tableau is that of the equivalent
method that carries the solution in place of one of them. Stages are numbered in the order in which
they can be computed; stages that nothing reads are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..engine.starting_values import default_passes, renewal_of
from ..engine.tableau import as_balls
from ..errors import UsageError
from ..exact import Scalar, exact, linalg
from ..exact.linalg import Matrix, Vector
from ..method import GLM, PartitionedGLM
from ..method.preconsistency import outputs, preconsistency, stage_times, unit_place
from ..method.rounding import CLOSE
from ..method.stage_order import dependency_blocks

if TYPE_CHECKING:
    from ..method import FinishingMethod, StartingMethod


_ZERO, _ONE = exact(0), exact(1)


@dataclass(frozen=True)
class Table:
    """One tableau of the form in the module's docstring."""

    A: Matrix  #: (s, s).
    U: Matrix  #: (s, n).
    B: Matrix  #: (m, s).
    V: Matrix  #: (m, n).
    c: Vector  #: (s,) abscissae.
    #: The stages in the order of computation: 1 for an explicit stage, -b for b stages that are
    #: solved for together.
    blocks: tuple[int, ...]
    #: (s,) for a pair: 1 where the stage is a Q, at which k is evaluated, else 0.
    half: tuple[int, ...]

    @property
    def s(self) -> int:
        """Number of stages."""
        return len(self.A)

    @property
    def implicit(self) -> bool:
        """Whether an equation has to be solved for some stage."""
        return any(block < 0 for block in self.blocks)


@dataclass(frozen=True)
class Scheme:
    """Everything a stepper needs."""

    pair: bool  #: Whether f and k are given separately.
    #: Numbers of the values that are the solution: one, or one of q and one of p.
    heads: tuple[int, ...]
    step: Table  #: The tableau of one step.
    #: The starting method, or ``None`` where the method is started by ``zero`` and passes.
    start: Table | None
    finish: Table | None  #: The finishing method, or ``None``.
    zero: Matrix  #: (r, heads), the start u y0.
    #: (r, r), the matrix K^-1 of the enhanced start, see :mod:`glmref.engine.starting_values`.
    correct: Matrix
    passes: int  #: Passes of the enhanced start; 0 where ``zero`` is all there is.
    #: Steps after which a long run renews the values from the solution, 0 for never.
    renew: int

    @property
    def r(self) -> int:
        """Number of values carried."""
        return len(self.step.V)

    @property
    def newton(self) -> bool:
        """Whether the stepper has Newton's method."""
        return self.implicit and not self.pair

    @property
    def tables(self) -> tuple[tuple[str, Table], ...]:
        """The tableaux there are, by name."""
        named = (("step", self.step), ("start", self.start), ("finish", self.finish))
        return tuple((name, table) for name, table in named if table is not None)

    @property
    def begins(self) -> str:
        """How values come from the solution: ``started``, ``enhanced`` or ``plain`` (copied)."""
        if self.start is not None:
            return "started"
        copied = self.r == len(self.heads) and not self.passes
        identity = all(
            _vanishes(x - 1) if i == j else _vanishes(x)
            for i, row in enumerate(self.zero)
            for j, x in enumerate(row)
        )
        return "plain" if copied and identity else "enhanced"

    @property
    def implicit(self) -> bool:
        """Whether any tableau has implicit stages."""
        return any(table.implicit for _, table in self.tables)


def _vanishes(x: Scalar) -> bool:
    return x.is_zero() is True or x.magnitude() < CLOSE


def _stacked(first: Matrix, second: Matrix, *, crossed: bool = False) -> Matrix:
    """Return [first 0; 0 second], or [0 first; second 0]."""
    left, right = (len(first[0]) if first else 0), (len(second[0]) if second else 0)
    if crossed:
        top = tuple((_ZERO,) * right + tuple(row) for row in first)
        return top + tuple(tuple(row) + (_ZERO,) * left for row in second)
    top = tuple(tuple(row) + (_ZERO,) * right for row in first)
    return top + tuple((_ZERO,) * left + tuple(row) for row in second)


def _table(
    A: Matrix, U: Matrix, B: Matrix, V: Matrix, c: Vector, half: Sequence[int] = ()
) -> Table:
    """Drop stages that nothing reads and number the others in the order of computation."""
    used = {j for row in B for j, x in enumerate(row) if not _vanishes(x)}
    waiting = list(used)
    while waiting:
        row = A[waiting.pop()]
        more = {j for j, x in enumerate(row) if not _vanishes(x)} - used
        used |= more
        waiting += more
    keep = sorted(used) or [0]
    found = dependency_blocks(len(keep), lambda i, j: not _vanishes(A[keep[i]][keep[j]]))
    order = [keep[i] for block in found for i in block.stages]
    return Table(
        A=tuple(tuple(A[i][j] for j in order) for i in order),
        U=tuple(U[i] for i in order),
        B=tuple(tuple(row[j] for j in order) for row in B),
        V=V,
        c=tuple(c[i] for i in order),
        blocks=tuple(-len(x.stages) if x.implicit else 1 for x in found),
        half=tuple(half[i] for i in order) if half else (0,) * len(order),
    )


def _start_of(start: StartingMethod) -> Table:
    ones = ((_ONE,),) * len(start.A)
    columns = tuple((x,) for x in start.u)
    return _table(start.A, ones, start.B, columns, linalg.row_sums(start.A))


def _finish_of(finish: FinishingMethod) -> Table:
    ones = ((_ONE,),) * len(finish.A)
    return _table(finish.A, ones, (finish.b,), ((_ONE,),), linalg.row_sums(finish.A))


def _zeros(size: int) -> Matrix:
    return ((_ZERO,) * size,) * size


def _zero_start(U: Matrix, V: Matrix) -> Vector:
    u = preconsistency(U, V).u
    if u is None:
        return (_ONE, *((_ZERO,) * (len(V) - 1)))
    return tuple(_ZERO if _vanishes(x) else x for x in u)


def _corrector(U: Matrix, V: Matrix, name: str) -> Matrix:
    """Return K^-1 on the values 2..r with a first row and column of zeros.

    Raises
    ------
    UsageError
        When the first value is not the solution.
    """
    u = preconsistency(U, V).u
    if u is None or (u[0] - 1).is_zero() is False:
        raise UsageError(
            f"{name} carries {len(V)} values and has no starting method, and its first value is "
            f"not the solution (u_1 = 1), so that no start can be made; give its file `starting`"
        )
    V, n = as_balls(V), len(V)
    if n == 1:
        return ((_ZERO,),)
    K = tuple(
        tuple((1 if i == j else 0) - V[i][j] + u[i] * V[0][j] for j in range(1, n))
        for i in range(1, n)
    )
    inverse = linalg.inverse(K)
    return ((_ZERO,) * n, *((_ZERO, *row) for row in inverse))


def scheme_of(method: GLM | PartitionedGLM) -> Scheme:
    """Return the tableaux of a method's stepper.

    Raises
    ------
    UsageError
        For a complex method, and for one that no start is known for.
    """
    if None in map(unit_place, outputs(method.components)):
        method = method.transform(*map(_basis, outputs(method.components)))
    if isinstance(method, PartitionedGLM):
        return _scheme_of_pair(method)
    if not method.is_real:
        raise UsageError(
            f"{method.name or 'the method'} has complex coefficients, and exported steppers "
            f"compute with real numbers; export a real method that is equivalent to it"
        )
    c = stage_times(method)
    several = method.r > 1 and method.starting is None
    return Scheme(
        pair=False,
        heads=(_place(outputs(method.components)[0]),),
        step=_table(method.A, method.U, method.B, method.V, c),
        start=_start_of(method.starting) if method.starting is not None else None,
        finish=_finish_of(method.finishing) if method.finishing is not None else None,
        zero=tuple((x,) for x in _zero_start(method.U, method.V)),
        correct=_corrector(method.U, method.V, method.name or "the method")
        if several
        else _zeros(method.r),
        passes=default_passes(method) if several else 0,
        renew=renewal_of(method),
    )


def _basis(output: Vector) -> Matrix:
    """Return T for which the solution is a value of ``T y``: the identity, one row the output.

    That row stands where the output first has an entry, so that T is nonsingular.
    """
    place = next(k for k, x in enumerate(output) if x.is_zero() is False)
    return tuple(
        tuple(output) if k == place else row for k, row in enumerate(linalg.identity(len(output)))
    )


def _place(output: Vector) -> int:
    """Return which value is the solution."""
    return next(k for k, x in enumerate(output) if not _vanishes(x))


def _scheme_of_pair(pair: PartitionedGLM) -> Scheme:
    reads = outputs(pair.components)
    n = pair.n_Q + pair.n_P
    half = (1,) * pair.n_Q + (0,) * pair.n_P
    step = _table(
        _stacked(pair.A, pair.A_hat, crossed=True),
        _stacked(pair.U, pair.U_hat),
        _stacked(pair.B, pair.B_hat, crossed=True),
        _stacked(pair.V, pair.V_hat),
        (_ZERO,) * n,
        half,
    )
    start = None
    if pair.starting is not None:
        s = pair.starting
        n_q, n_p = s.stages
        start = _table(
            _stacked(s.A, s.A_hat, crossed=True),
            _stacked(((_ONE,),) * n_q, ((_ONE,),) * n_p),
            _stacked(s.B, s.B_hat, crossed=True),
            _stacked(tuple((x,) for x in s.u), tuple((x,) for x in s.u_hat)),
            (_ZERO,) * (n_q + n_p),
            (1,) * n_q + (0,) * n_p,
        )
    several = max(pair.r, pair.r_hat) > 1 and pair.starting is None
    correct = _zeros(pair.r + pair.r_hat)
    if several:
        name = pair.name or "the pair"
        correct = _stacked(
            _corrector(pair.U, pair.V, name), _corrector(pair.U_hat, pair.V_hat, name)
        )
    zero = [_zero_start(pair.U, pair.V), _zero_start(pair.U_hat, pair.V_hat)]
    return Scheme(
        pair=True,
        heads=(_place(reads[0]), pair.r + _place(reads[1])),
        step=step,
        start=start,
        finish=None,
        zero=_stacked(tuple((x,) for x in zero[0]), tuple((x,) for x in zero[1])),
        correct=correct,
        passes=default_passes(pair) if several else 0,
        renew=renewal_of(pair),
    )
