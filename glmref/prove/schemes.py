"""Orders of Runge-Kutta-like schemes, each put as a system of coloured stages the kernel knows.

The conditions are those of :class:`glmref.theory.starting_series.StartingSeries`. A scheme says
only which matrix stands below a vertex of each colour, which weights are above it, and which
coloured trees its systems have:

*Runge-Kutta*, c = A 1: one colour.

*c given apart*, c != A 1: ``y' = f(t, y)``, ``t' = 1``. A vertex t is a leaf and its stages are
t_n + c_i h, so that the matrix below it has row sums c.

*Additive*, ``y' = f1(y) + .. + fk(y)`` with shared stages: k colours that all mix
(Kennedy, Carpenter 2003, section 2; Sandu, Guenther 2015). Nystrom, Rosenbrock and W-methods and
splittings have the trees of the systems of their methods, see :attr:`.method.Method.system`.

*Dense output* b(theta), a polynomial: ``b(theta) Phi(t) = theta^|t| / gamma(t)``, power by power.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from itertools import count, islice
from typing import Any

from ..errors import BudgetError
from ..exact import Exact, Scalar
from ..exact.judging import as_numbers, as_scalar, fast_judge
from ..exact.linalg import Matrix, Vector, row_sums, transpose
from ..method import Method
from ..method.component import Palette
from ..system.budget import limited, spend
from ..theory.coefficients import first_nonzero, is_zero
from ..theory.starting_series import StartingSeries, component, tableau
from ..theory.trees import Tree, counted, trees
from .digits import staircase_of
from .kernel import HIGHEST

_ZERO, _ONE = Exact(0), Exact(1)
#: Largest order that is looked at, by the number of colours.
LARGEST = {1: 12, 2: 8, 3: 6, 4: 5}
#: Seconds of processor time for the orders beyond 12.
HIGH = 90.0


@dataclass(frozen=True)
class Scheme:
    """A scheme as coloured stages."""

    palette: Palette  #: Colours with the colours their children may have.
    blocks: Mapping[str, tuple[Matrix, Vector]]  #: (A, b) by colour.
    roots: str  #: Colours whose trees are conditions.
    #: Which trees the systems have, or ``None`` for all.
    counts: Callable[[Tree], bool] | None = None
    #: Pattern and replacement that write a tree for a reader.
    written: tuple[tuple[str, str], ...] = ()
    #: The scheme on ``y' = f(y)``, where time is a colour of its own.
    autonomous: Scheme | None = None
    #: (s, d), ``b_i(theta) = sum_m dense[i][m] theta^(m + 1)`` in the place of b, or ``None``.
    dense: Matrix | None = None

    @property
    def is_exact(self) -> bool:
        """Whether all numbers are exact."""
        rows = [row for A, b in self.blocks.values() for row in (*A, b)]
        return all(isinstance(x, Exact) for row in (*rows, *(self.dense or ())) for x in row)

    def in_balls(self) -> Scheme:
        """Return the same with numbers in balls, for questions about the size of a residual."""

        def balls(row: Vector) -> Vector:
            return tuple(x.ball() if isinstance(x, Exact) else x for x in row)

        blocks = {k: (tuple(map(balls, A)), balls(b)) for k, (A, b) in self.blocks.items()}
        plain, dense = self.autonomous and self.autonomous.in_balls(), self.dense
        dense = None if dense is None else tuple(map(balls, dense))
        return replace(self, blocks=blocks, autonomous=plain, dense=dense)

    def text(self, tree: str) -> str:
        """Write a tree in the notation of the documentation."""
        for pattern, by in self.written:
            tree = re.sub(pattern, by, tree)
        return tree


@dataclass(frozen=True)
class Reach:
    """How far the conditions of a scheme hold.

    Attributes
    ----------
    proved : int
        All conditions through this order hold exactly.
    sizes : tuple[float, ...]
        For each order the largest residual of its conditions, 0.0 where all are zero.
    trees : tuple[str, ...]
        For each order the tree with that residual, ``""`` where all are zero.
    first : tuple[str, ...]
        For each order the first tree whose residual certainly is not zero.
    refuted : int or None
        The first order with a residual that is certainly not zero, or ``None``.
    exact : bool
        Whether all numbers are exact.
    residuals : tuple[Mapping[str, Scalar], ...]
        For each order the residuals by tree.
    """

    proved: int
    sizes: tuple[float, ...]
    trees: tuple[str, ...]
    refuted: int | None
    exact: bool
    first: tuple[str, ...] = ()
    residuals: tuple[Mapping[str, Scalar], ...] = ()

    def to(self, tolerance: float) -> int:
        """Return the order that holds with residuals of at most a size."""
        bad = (n for n, x in enumerate(self.sizes) if x > tolerance)
        return next(bad, len(self.sizes))

    def size(self, order: int) -> float:
        """Return the largest residual through an order."""
        return max(self.sizes[:order], default=0.0)

    def staircase(self) -> str:
        """Return such as ``"order 4 to 2.1e-12, order 2 exactly"``; what is coarser is left out."""
        worst = [min(self.size(n), 1.0) for n in range(len(self.sizes) + 1)]
        steps = staircase_of([Fraction(repr(x)) for x in (*worst, 1.0)], self.proved)
        return ", ".join([*steps, f"order {self.proved} exactly"])


def reach(scheme: Scheme, most: int, *, stop: float = float("inf"), high: bool = False) -> Reach:
    """Evaluate the conditions of a scheme, order by order.

    Parameters
    ----------
    scheme : Scheme
        The scheme.
    most : int
        The last order; cut to :data:`LARGEST`, or with ``high`` to 14.
    stop : float
        No order is looked at after one with a larger residual.
    high : bool
        Whether one colour goes through order 14, which takes a minute; it heeds a budget.

    Returns
    -------
    Reach
        How far they hold; trees in the notation of the documentation.
    """
    largest = LARGEST.get(len(scheme.palette), 4)
    high = high and len(scheme.palette) == 1

    def counts(t: Tree) -> bool:
        if high:
            spend()  # tens of thousands of trees
        return scheme.counts is None or scheme.counts(t)

    sizes, worst, first, residuals = [], [], [], []
    proved, refuted = 0, None
    last = min(most, HIGHEST if high else largest)
    for n, conditions in enumerate(islice(_conditions(scheme, counts), last), 1):
        level = {str(t): x for t, x in conditions if t.colour in scheme.roots}
        answers = {t: x.is_zero() for t, x in level.items()}
        if refuted is None and False in answers.values():
            refuted = n
        if proved == n - 1 and all(x is True for x in answers.values()):
            proved = n
        size = {t: x.magnitude() for t, x in level.items() if answers[t] is not True}
        at = max(size, key=size.__getitem__, default="")
        sizes.append(size.get(at, 0.0))
        worst.append(scheme.text(at))
        first.append(scheme.text(next((t for t, x in answers.items() if x is False), "")))
        residuals.append(level)
        if sizes[-1] > stop:
            break
    return Reach(proved, tuple(sizes), tuple(worst), refuted, scheme.is_exact, tuple(first),
                 tuple(residuals))  # fmt: skip


def _conditions(
    scheme: Scheme, counts: Callable[[Tree], bool]
) -> Iterator[list[tuple[Tree, Scalar]]]:
    """Yield for one order after the other its trees with the residuals of their conditions."""
    if scheme.dense is not None:
        columns, gaps = as_numbers(transpose(scheme.dense)), fast_judge().rules_rows.dense_gaps
        series = tableau({c: (A, (b,)) for c, (A, b) in scheme.blocks.items()})
        for n in count(1):
            level = filter(counts, trees(n, scheme.palette))
            yield [(t, _largest(gaps(columns, series, t.judged))) for t in level]
    one = ((_ONE,),)
    components = {c: component(A, one * len(A), (b,), one) for c, (A, b) in scheme.blocks.items()}
    series = StartingSeries(components, scheme.palette, free=False, counts=counts)
    while True:
        yield [(t, first_nonzero(series.residual(t))) for t in series.advance()]


def _largest(values: Iterable[Any]) -> Scalar:
    """Return the largest number of the judge, one that is certainly not zero where there is one."""
    return max(map(as_scalar, values), key=lambda x: (x.is_zero() is False, x.magnitude()))


def further(found: Reach, scheme: Scheme, declared: int) -> Reach:
    """Look beyond order 12 where a method of one colour declares more, if :data:`HIGH` suffices."""
    if len(scheme.palette) != 1 or not len(found.sizes) == LARGEST[1] < declared:
        return found
    try:
        with limited(HIGH):
            return reach(scheme, declared, high=True)
    except BudgetError:
        return found  # what was looked at is said


# --- schemes ------------------------------------------------------------------------------------


def _sums_to(A: Matrix, c: Sequence[Scalar]) -> bool:
    return all(is_zero(x - y) is True for x, y in zip(row_sums(A), c, strict=True))


def _with_sums(c: Sequence[Scalar]) -> Matrix:
    """Return a matrix with the row sums c."""
    return tuple((x, *((_ZERO,) * (len(c) - 1))) for x in c)


def _first(s: int) -> Vector:
    return (_ONE, *((_ZERO,) * (s - 1)))


def runge_kutta(
    A: Matrix, b: Vector, c: Sequence[Scalar] | None = None, *, apart: bool = False
) -> Scheme:
    """Return the scheme of A (s, s), b (s,), and c (s,) where not A 1 or ``apart``."""
    plain = Scheme({"o": "o"}, {"o": (A, b)}, "o")
    if c is None or (not apart and _sums_to(A, c)):
        return plain
    return Scheme(
        {"f": "ft", "t": ""},
        {"f": (A, b), "t": (_with_sums(c), _first(len(c)))},
        "f",
        autonomous=plain,
    )


def low_storage(A: Vector, B: Vector, c: Sequence[Scalar] | None = None) -> Scheme:
    """Make a scheme of dU = A_i dU + h f(U), U = U + B_i dU, A_1 = 0: Williamson (1980)."""
    s = len(B)
    rows: list[list[Scalar]] = [[_ZERO] * s]
    for i in range(s):
        row, factor = list(rows[-1]), B[i]
        for j in range(i, -1, -1):
            row[j] = row[j] + factor
            factor = factor * A[j]
        rows.append(row)
    return runge_kutta(tuple(map(tuple, rows[:s])), tuple(rows[s]), c, apart=True)


def shu_osher(alpha: Matrix, beta: Matrix, c: Sequence[Scalar] | None = None) -> Scheme:
    """Make a scheme of y_i = sum alpha_ij y_j + h beta_ij f(y_j), j < i: Shu, Osher (1988).

    Row i of alpha and beta (s, s) gives y_i from y_0, .., y_{i-1}; y_s is the new value.
    """
    s = len(alpha)
    rows: list[list[Scalar]] = [[_ZERO] * s]
    for a, b in zip(alpha, beta, strict=True):
        row = list(b)
        for x, before in zip(a, rows, strict=False):
            row = [y + x * z for y, z in zip(row, before, strict=True)]
        rows.append(row)
    return runge_kutta(tuple(map(tuple, rows[:s])), tuple(rows[s]), c, apart=True)


def additive(
    parts: Sequence[tuple[Matrix, Vector]], c: Sequence[Sequence[Scalar] | None] = ()
) -> Scheme:
    """Return the scheme of parts (A, b) on shared stages.

    Colours are ``1``, ``2``, .. in their order.

    With c given, the time that part k sees is that of ``c[k]``; it is a colour of its own where it
    differs from A 1.
    """
    names = "123456789"[: len(parts)]
    blocks = dict(zip(names, parts, strict=True))
    times: dict[str, str] = {}
    for name, (A, _), given in zip(
        names, parts, [*c, *[None] * (len(parts) - len(c))], strict=True
    ):
        if given is not None and not _sums_to(A, given):
            time = "abcdefghi"[int(name) - 1]
            times[name] = time
            blocks[time] = (_with_sums(given), _first(len(given)))
    palette = dict.fromkeys(times.values(), "") | {x: times.get(x, "") + names for x in names}
    return Scheme(palette, blocks, names)


def general_linear(A: Matrix, rows: Sequence[Vector]) -> Scheme:
    """Make a scheme of a general linear method with V S = S and U S = 1, started with S y.

    ``Y = h A F + U S y``, ``w (S y + h B F) = y + h w B F`` for each w with w S = 1: the method has
    order p, from the start S y on, exactly if the weights w B of r such w that are independent
    satisfy all conditions through p.

    Parameters
    ----------
    A : matrix (s, s)
    rows : r vectors (s,)
        The weights w B.
    """
    names = "opqrstuvwxyz"[: len(rows)]
    return Scheme(
        dict.fromkeys(names, "o"),
        {x: (A, b) for x, b in zip(names, rows, strict=True)},
        names,
        None,
        ((f"[{names}]", "o"),),
    )


@cache
def _leaves_alike(t: Tree) -> bool:
    """Tell whether all leaves have the colour 1: of f - J and J they have the same condition."""
    return all(map(_leaves_alike, t.children)) if t.children else t.colour == "1"


#: How trees of Rosenbrock methods are written, by the system: with any J, a vertex f or J.
_WRITTEN = {
    "rosenbrock": ((r"[12]\[", "["), (r"[12]", "o")),
    "w": (("1", "f"), ("2", "J")),
}


def scheme_of(method: Method, *, roots: str = "", nystrom: bool = False) -> Scheme:
    """Return the scheme of a method that carries one value of each component.

    Parameters
    ----------
    method : Method
        Where time is no component of its own.
    roots : str
        Colours whose trees are conditions; all by default.
    nystrom : bool
        Whether only the trees of second-order systems count.
    """
    palette, system = method.palette, "nystrom" if nystrom else method.system
    if nystrom:  # where f has no child f
        palette = {**palette, "f": "k"}
    counts = counted(system)
    return Scheme(
        palette,
        {x.colour: (x.A, x.B[0]) for x in method.components},
        roots or "".join(palette),
        (lambda t: _leaves_alike(t) and counts(t)) if system in _WRITTEN else counts,
        _WRITTEN.get(system, ()),
    )
