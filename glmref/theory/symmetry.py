"""Time-reversal symmetry: the method equals its adjoint, up to an exchange of stages and of values.

With an involution L on the values and an involutive permutation P of the stages,

    L^2 = I     L V^-1 L = V     B = V L B P     U = P U L V     A + P A P = U V^-1 B

so that ``M_(-h)(L M_h(x)) = L x``. ``B = L_out B P`` alone, with the *output* involution
L_out = V L, proves nothing: methods pass it for which no L exists. Both L and P are found here. The
last condition has no L in it and selects P. Where ``L^2 = I`` the second condition reads
``V L = L V^-1``, and then ``(P U V^k) L = U V^(-1-k)`` for every k: a linear system that fixes L as
far as the stages see the values. L^2 = I is checked, never assumed.

A method of several components has an involution of the values for each, the conditions with its own
blocks, and the stages of each are exchanged among themselves: of a partitioned method on separable
systems, forward and backward sweep change places. Shared stages are exchanged alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import islice, product
from typing import Any, cast

from ..errors import ExactnessError
from ..exact import Exact, linalg
from ..exact.judging import as_numbers, consulted, fast_judge, inward, outward
from ..exact.linalg import Matrix, independent_rows, solve_affine
from ..judge.refusals import Refused
from ..method import GLM, Component, Method
from ..method.stage_order import offsets
from ..system.budget import spend
from .equivalence import reduce
from .judged import judged_component, judged_parts
from .symplectic import judge_identities

#: At most so many stage permutations are tried; only methods with many equal stages have more.
MAX_PERMUTATIONS = 200

Named = list[tuple[str, Matrix]]


@dataclass(frozen=True, eq=False)
class Symmetry:
    """Whether a method is symmetric, and under which involutions."""

    #: The decision; ``None`` where balls, or a search that ended, leave it open.
    holds: bool | None
    #: (r, r) involution of the values of each component, by colour, or ``None``. Where the method
    #: failed it is the only matrix that the linear conditions allow, if there is one.
    involutions: Mapping[str, Matrix | None] = field(default_factory=dict)
    #: How the stages of each component are exchanged, by colour: stage i with stage P[i], from 0.
    #: Empty where there is none.
    exchanges: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    residual: float = 0.0  #: Largest entry of the conditions, 0.0 when all hold exactly.
    witness: str = ""  #: One sentence naming the condition that fails, or ``""``.
    #: Whether L and P belong to the reduced method (:func:`equivalence.reduce`), as for a multistep
    #: method that carries derivatives it could do without.
    reduced: bool = False

    @property
    def L(self) -> Matrix | None:
        """Involution of the first component: of q, or of a single method."""
        return next(iter(self.involutions.values()), None)

    @property
    def P(self) -> tuple[int, ...] | None:
        """Exchange of the stages of the first component: Q, or of a single method."""
        return next(iter(self.exchanges.values()), None)


@dataclass(frozen=True, eq=False)
class _Half:
    """One method with what the conditions need of it."""

    c: GLM | Component
    m: Any  # the component in the judge's numbers
    back: Matrix  # V^-1
    U_back: Matrix  # U V^-1
    hat: str = ""


def _half(c: GLM | Component) -> _Half:
    hat = "^" if isinstance(c, Component) and c.colour == "k" else ""
    back = linalg.inverse(c.V)
    return _Half(c, judged_component(c), back, linalg.matmul(c.U, back), hat)


def _turned(half: _Half, L: Matrix, rows: Sequence[int], columns: Sequence[int]) -> Any:
    """Return what of a reversal must vanish, as the judge has it."""
    space = inward([half.back, L])
    turned = fast_judge().rules_symmetry.Turned
    return turned(half.m, *space, list(columns), list(rows))


def _value_residuals(half: _Half, L: Matrix, rows: Sequence[int], columns: Sequence[int]) -> Named:
    x = half.hat
    with consulted():
        found = _turned(half, L, rows, columns)
        return [
            (f"L{x} L{x} - I", outward(found.of_L())),
            (f"L{x} V{x}^-1 L{x} - V{x}", outward(found.of_V())),
            (f"B{x} - V{x} L{x} B{x} P", outward(found.of_B())),
            (f"U{x} - P U{x} L{x} V{x}", outward(found.of_U())),
        ]


def _observed_L(half: _Half, rows: Sequence[int]) -> Matrix | None:
    """Solve ``(P U V^k) L = U V^(-1-k)`` for L, k = 0, 1, .. until the rows determine it."""
    left, right = [half.c.U[i] for i in rows], list(half.U_back)
    r = len(half.c.V)
    for _ in range(r):
        chosen = independent_rows(tuple(left), r)
        if len(chosen) == r:
            a = tuple(left[i] for i in chosen)
            return linalg.solve(a, tuple(right[i] for i in chosen))
        s = len(half.c.U)
        left += linalg.matmul(tuple(left[-s:]), half.c.V)
        right += linalg.matmul(tuple(right[-s:]), half.back)
    return None


def _all_L(half: _Half, rows: Sequence[int], columns: Sequence[int]) -> tuple[list[Matrix], bool]:
    """Return candidates for L where the stages do not see all values: all conditions together.

    The affine solutions are walked with factors 0, 1 and -1; none is a proof of absence. The second
    result tells whether no other L satisfies the conditions than the one given.
    """
    with consulted() as judge:
        back = as_numbers(half.back)
        equations, right = outward(judge.rules_symmetry.conditions(half.m, back, rows, columns))
    solution = solve_affine(equations, right)
    if solution.failed is not None:
        return [], True
    found: list[Matrix] = []
    r = len(half.c.V)
    for factors in islice(product((0, 1, -1), repeat=len(solution.directions)), 81):
        flat = list(solution.point)
        for t, direction in zip(factors, solution.directions, strict=True):
            flat = [x + t * y for x, y in zip(flat, direction, strict=True)]
        found.append(tuple(tuple(flat[a * r : a * r + r]) for a in range(r)))
    return found, not solution.directions


def _judge_half(
    half: _Half, rows: Sequence[int], columns: Sequence[int]
) -> tuple[bool | None, Matrix | None, float, str]:
    """Find L for one half and given permutations: decision, L, residual, witness."""
    L = _observed_L(half, rows)
    candidates, only = ([L], True) if L is not None else _all_L(half, rows, columns)
    if not candidates:
        return False, None, 0.0, f"no matrix L{half.hat} satisfies the linear conditions"
    first = None
    for candidate in candidates:
        judged = judge_identities(_value_residuals(half, candidate, rows, columns))
        if judged[0] is True:
            return True, candidate, 0.0, ""
        first = first or (judged[0], candidate, *judged[1:])
    assert first is not None
    if not only and first[0] is False:
        return None, first[1], first[2], "the values that no stage sees leave L open"
    if first[0] is False:
        text = f"the linear conditions allow one matrix L{half.hat} only, and {first[3]}"
        return False, first[1], first[2], text
    return first


@lru_cache(maxsize=4)
def symmetry_as_given(m: Method) -> Symmetry:
    """Decide the symmetry of a method with all its values and stages: see :func:`symmetry`."""
    try:
        halves = [_half(c) for c in m.components]
    except ExactnessError as error:
        entries = [x for c in m.components for row in c.V for x in row]
        singular = all(isinstance(x, Exact) for x in entries)  # balls may not decide it
        which = "V" if len(m.components) == 1 else "V or V^"
        text = f"{which} is singular: no step can be reversed" if singular else str(error)
        return Symmetry(False if singular else None, witness=text)
    colours = list(m.palette)
    first, sizes = offsets(m.components, m.palette), {c.colour: len(c.A) for c in m.components}
    best: Symmetry | None = None
    for tried, order in enumerate(involutions(m)):
        if tried == MAX_PERMUTATIONS or order is None:
            return Symmetry(None, witness="the search for an exchange of stages was cut off")
        exchanges = {
            c: tuple(i - first[c] for i in order[first[c] : first[c] + sizes[c]]) for c in colours
        }
        found = _at(m, halves, exchanges)
        if found.holds is True or (found.holds is None and not m.is_exact):
            return found  # no other exchange of stages can decide more about balls
        best = _better(best, found)
    if best is not None:
        return best
    reversal = {c: tuple(range(n)[::-1]) for c, n in sizes.items()}
    _, size, witness = judge_identities(_stage_residuals(m, halves, reversal))
    what = "P" if len(colours) == 1 else ""
    text = f"no exchange of stages {what} works; for the reversal {witness}".replace("  ", " ")
    return Symmetry(False, residual=size, witness=text)


def involutions(m: Method) -> Iterator[list[int] | None]:
    """Yield the exchanges of stages that A may have, as the judge finds them; None beyond limits.

    They are places in a common numbering of all stages.
    """
    with consulted() as judge:
        found = judge.rules_symmetry.Search(judged_parts(m)).found()
    order: list[int] | None = []
    while order is not None:
        spend()
        with consulted():
            try:
                order = next(found)
            except StopIteration:
                return
            except Refused:
                order = None
        yield order


def _stage_residuals(
    m: Method, halves: Sequence[_Half], exchanges: Mapping[str, Sequence[int]]
) -> Named:
    """Return ``A + P A P' - U V^-1 B`` of each component, P and P' its exchange and its slopes'."""
    found: Named = []
    for c, x in zip(m.components, halves, strict=True):
        P, Q, h = ("P", "P", "") if len(halves) == 1 else ("P_Q", "P_P", x.hat)
        P, Q = (Q, P) if h else (P, Q)
        name = f"A{h} + {P} A{h} {Q} - U{h} V{h}^-1 B{h}"
        columns = exchanges[m.palette[c.colour][0]]
        with consulted():
            gap = _turned(x, (), exchanges[c.colour], columns).of_A()
            found.append((name, outward(gap)))
    return found


def _at(m: Method, halves: Sequence[_Half], exchanges: Mapping[str, tuple[int, ...]]) -> Symmetry:
    """Return what given exchanges of stages make of the conditions."""
    found = [
        _judge_half(x, exchanges[c.colour], exchanges[m.palette[c.colour][0]])
        for c, x in zip(m.components, halves, strict=True)
    ]
    judged = [(holds, size, witness) for holds, _, size, witness in found]
    if len(judged) > 1 or judged[0][0] is True:  # with balls the stages may still be open
        stages = judge_identities(_stage_residuals(m, halves, exchanges))
        judged = [stages, *judged] if len(judged) > 1 else [stages]
    verdicts = [holds for holds, _, _ in judged]
    holds = False if False in verdicts else None if None in verdicts else True
    return Symmetry(
        holds,
        {c: L for c, (_, L, _, _) in zip(m.palette, found, strict=True)},
        exchanges,
        max(size for _, size, _ in judged),
        judged[verdicts.index(holds)][2],
    )


def _better(best, found):  # type: ignore[no-untyped-def]
    """Prefer an open finding to a failed one, else the earlier one."""
    return found if best is None or (best.holds is False and found.holds is None) else best


def symmetry(m: Method) -> Symmetry:
    """Decide time-reversal symmetry, finding L and P for each component.

    A single method that is not symmetric as it stands, but has values or stages without influence,
    is tried again without them.

    References: Butcher, "B-Series" (2021), section 7.6; Khan (2018), section 2.3.1, corrected.
    """
    found = symmetry_as_given(m)
    if found.holds is True or not m.is_exact or len(m.components) > 1:
        return found
    m = cast("GLM", m)
    smaller = reduce(m)
    if (smaller.s, smaller.r) == (m.s, m.r):
        return found
    second = symmetry_as_given(smaller)
    if second.holds is False and found.holds is False:
        return found
    return replace(second, reduced=True)
