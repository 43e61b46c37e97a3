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

from dataclasses import dataclass

from ..engine.starting_values import default_passes, renewal_of
from ..engine.tableau import as_balls
from ..errors import UsageError
from ..exact import Scalar, exact, linalg
from ..exact.linalg import Matrix, Vector
from ..method import GLM, Method, PartitionedGLM
from ..method.component import SEPARABLE
from ..method.preconsistency import outputs, preconsistency, unit_place
from ..method.rounding import CLOSE

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


def _table(method: Method) -> Table:
    """Return the tableau of a method, a start or a finish.

    Stages that nothing reads are left out, and the others numbered in the order of computation.
    """
    parts, pair = method.components, method.parts == 2
    palette = SEPARABLE if pair else None
    stages, values = [len(x.A) for x in parts], [len(x.V[0]) for x in parts]
    A, U, B, V = [], [], [], []
    for k, x in enumerate(parts):
        # the stages of the other half move a half
        first, size = sum(stages[: len(parts) - 1 - k]), sum(stages)
        A += _wide(x.A, first, size)
        B += _wide(x.B, first, size)
        U += _wide(x.U, sum(values[:k]), sum(values))
        V += _wide(x.V, sum(values[:k]), sum(values))
    every, read = method.stage_blocks(palette), method.read_stages(palette)
    blocks = [x for x in every if not read.isdisjoint(x.stages)] or every[:1]
    order = [i for x in blocks for i in x.stages]
    c = (_ZERO,) * sum(stages) if pair else method.times[0]
    return Table(
        A=tuple(tuple(A[i][j] for j in order) for i in order),
        U=tuple(U[i] for i in order),
        B=tuple(tuple(row[j] for j in order) for row in B),
        V=tuple(V),
        c=tuple(c[i] for i in order),
        blocks=tuple(-len(x.stages) if x.implicit else 1 for x in blocks),
        half=tuple(int(pair and i < stages[0]) for i in order),
    )


def _wide(rows: Matrix, left: int, width: int) -> Matrix:
    """Return rows of a width with zeros around these, which begin at ``left``."""
    return tuple(
        (_ZERO,) * left + tuple(row) + (_ZERO,) * (width - left - len(row)) for row in rows
    )


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
    name = method.name or "the method"
    if not method.is_real:
        raise UsageError(
            f"{name} has complex coefficients, and exported steppers compute with real numbers; "
            f"export a real method that is equivalent to it"
        )
    parts, (first, *_) = method.components, (len(x.V) for x in method.components)
    places = [_place(output) for output in outputs(parts)]
    several = method.carried > 1 and method.starting is None
    zero = [tuple((x,) for x in _zero_start(x.U, x.V)) for x in parts]
    correct = [
        _corrector(x.U, x.V, name) if several else linalg.zeros(len(x.V), len(x.V)) for x in parts
    ]
    finishing = getattr(method, "finishing", None)
    return Scheme(
        pair=method.parts == 2,
        heads=tuple(place + k * first for k, place in enumerate(places)),
        step=_table(method),
        start=None if method.starting is None else _table(method.starting),
        finish=None if finishing is None else _table(finishing),
        zero=linalg.block_diagonal(*zero),
        correct=linalg.block_diagonal(*correct),
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
