"""Time-reversal symmetry: the method equals its adjoint, up to an exchange of stages and of values.

With an involution L on the values and an involutive permutation P of the stages,

    L^2 = I     L V^-1 L = V     B = V L B P     U = P U L V     A + P A P = U V^-1 B

so that ``M_(-h)(L M_h(x)) = L x``. ``B = L_out B P`` alone, with the *output* involution
L_out = V L, proves nothing: methods pass it for which no L exists. Both L and P are found here. The
last condition has no L in it and selects P. Where ``L^2 = I`` the second condition reads
``V L = L V^-1``, and then ``(P U V^k) L = U V^(-1-k)`` for every k: a linear system that fixes L as
far as the stages see the values. L^2 = I is checked, never assumed.

For a pair the two halves have involutions L and L^, and the stages P and Q are exchanged among
themselves: forward and backward sweep change places.

Public names::

    adjoint(m) -> GLM
    symmetry_residual(m, L, P) -> list of (name, Matrix)
    check_symmetry(m, L, P) -> Symmetry        symmetry(m) -> Symmetry
    is_symmetric(m) -> bool | None
    pair_symmetry(pair) -> PairSymmetry        is_pair_symmetric(pair) -> bool | None
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice, product

from ..errors import ExactnessError
from ..exact import Exact, exact, linalg
from ..exact.linalg import Matrix
from ..method import GLM, PartitionedGLM
from ..method.solution_value import Blocks, halves
from .affine import independent_rows, solve_affine
from .equivalence import reduce
from .involutions import Relation, involutions
from .symplectic import judge_identities

__all__ = [
    "PairSymmetry",
    "Symmetry",
    "adjoint",
    "check_symmetry",
    "is_pair_symmetric",
    "is_symmetric",
    "pair_symmetry",
    "symmetry",
    "symmetry_residual",
]

#: At most so many stage permutations are tried; only methods with many equal stages have more.
MAX_PERMUTATIONS = 200

Named = list[tuple[str, Matrix]]


@dataclass(frozen=True, eq=False)
class Symmetry:
    """Whether a method is symmetric, and under which involutions.

    Attributes
    ----------
        holds: the decision; ``None`` where balls, or a search that ended, leave it open.
        L: (r, r) involution of the values, or ``None``. Where the method failed it is the only
            matrix that the linear conditions allow, if there is one.
        P: (s,) stages: stage i is exchanged with stage P[i], from 0; or ``None``.
        residual: largest entry of the conditions, 0.0 when all hold exactly.
        witness: one sentence naming the condition that fails, or ``""``.
        reduced: whether L and P belong to the reduced method (:func:`equivalence.reduce`), as for a
            multistep method that carries derivatives it could do without.
    """

    holds: bool | None
    L: Matrix | None = None
    P: tuple[int, ...] | None = None
    residual: float = 0.0
    witness: str = ""
    reduced: bool = False


@dataclass(frozen=True, eq=False)
class PairSymmetry:
    """Whether a pair is symmetric.

    Attributes
    ----------
        holds: the decision; ``None`` where it is open.
        L, L_hat: involutions of the q and p values, or ``None``.
        P_P, P_Q: how the stages P and the stages Q are exchanged, from 0, or ``None``.
        residual, witness: as in :class:`Symmetry`.
    """

    holds: bool | None
    L: Matrix | None = None
    L_hat: Matrix | None = None
    P_P: tuple[int, ...] | None = None
    P_Q: tuple[int, ...] | None = None
    residual: float = 0.0
    witness: str = ""


@dataclass(frozen=True, eq=False)
class _Half:
    """One method with what the conditions need of it."""

    A: Matrix
    U: Matrix
    B: Matrix
    V: Matrix
    V_inverse: Matrix
    U_back: Matrix  # U V^-1
    B_back: Matrix  # V^-1 B
    exchange: Matrix  # U V^-1 B
    hat: str = ""


def _half(m: GLM | Blocks, hat: str = "") -> _Half:
    back = linalg.inverse(m.V)
    U_back = linalg.matmul(m.U, back)
    return _Half(
        m.A, m.U, m.B, m.V, back, U_back, linalg.matmul(back, m.B), linalg.matmul(U_back, m.B), hat
    )


def adjoint(m: GLM) -> GLM:
    """Adjoint method: the inverse of one step with -h; ``A* = U V^-1 B - A`` and so on.

    Raises
    ------
        ExactnessError: when V is singular.

    References: Butcher, "B-Series" (2021), section 7.6; Khan (2018), section 2.3.1, corrected.
    """
    half = _half(m)
    return m.bare(A=linalg.sub(half.exchange, m.A), U=half.U_back, B=half.B_back, V=half.V_inverse)


def _permuted(rows: Matrix, order: Sequence[int]) -> Matrix:
    return tuple(rows[i] for i in order)


def _columns_permuted(rows: Matrix, order: Sequence[int]) -> Matrix:
    return tuple(tuple(row[j] for j in order) for row in rows)


def _stage_residual(half: _Half, rows: Sequence[int], columns: Sequence[int]) -> Matrix:
    exchanged = _columns_permuted(_permuted(half.A, rows), columns)
    return linalg.sub(linalg.add(half.A, exchanged), half.exchange)


def _value_residuals(half: _Half, L: Matrix, rows: Sequence[int], columns: Sequence[int]) -> Named:
    x = half.hat
    V_L = linalg.matmul(half.V, L)
    L_V = linalg.matmul(L, half.V)
    return [
        (f"L{x} L{x} - I", linalg.sub(linalg.matmul(L, L), linalg.identity(len(L)))),
        (
            f"L{x} V{x}^-1 L{x} - V{x}",
            linalg.sub(linalg.matmul(L, half.V_inverse, L), half.V),
        ),
        (
            f"B{x} - V{x} L{x} B{x} P",
            linalg.sub(half.B, linalg.matmul(V_L, _columns_permuted(half.B, columns))),
        ),
        (
            f"U{x} - P U{x} L{x} V{x}",
            linalg.sub(half.U, linalg.matmul(_permuted(half.U, rows), L_V)),
        ),
    ]


def symmetry_residual(m: GLM, L: Matrix, P: Sequence[int]) -> Named:
    """All five conditions, left minus right, each with its name.

    Args:
        m: a method with nonsingular V. L: (r, r). P: (s,) permutation, from 0.

    References: Butcher, "B-Series" (2021), Definition 7.6A; Khan (2018), equations (2.10) to
    (2.12), corrected.
    """
    half = _half(m)
    first = ("A + P A P - U V^-1 B", _stage_residual(half, P, P))
    return [first, *_value_residuals(half, L, P, P)]


def _observed_L(half: _Half, rows: Sequence[int]) -> Matrix | None:
    """Solve ``(P U V^k) L = U V^(-1-k)`` for L, k = 0, 1, .. until the rows determine it."""
    left, right = list(_permuted(half.U, rows)), list(half.U_back)
    r = len(half.V)
    for _ in range(r):
        chosen = independent_rows(tuple(left), r)
        if len(chosen) == r:
            a = tuple(left[i] for i in chosen)
            return linalg.solve(a, tuple(right[i] for i in chosen))
        s = len(half.U)
        left += linalg.matmul(tuple(left[-s:]), half.V)
        right += linalg.matmul(tuple(right[-s:]), half.V_inverse)
    return None


def _all_L(half: _Half, rows: Sequence[int], columns: Sequence[int]) -> list[Matrix]:
    """Candidates for L where the stages do not see all values: the conditions, taken together.

    The affine solutions are walked with factors 0, 1 and -1; none is a proof of absence.
    """
    r = len(half.V)
    equations: list[tuple[Exact, ...]] = []
    right: list[Exact] = []

    def add(coefficients: dict[tuple[int, int], object], value: object) -> None:
        row: list = [exact(0)] * (r * r)
        for (a, b), x in coefficients.items():
            row[a * r + b] = row[a * r + b] + x
        equations.append(tuple(row))
        right.append(value)  # type: ignore[arg-type]

    for (i, u), k in product(enumerate(_permuted(half.U, rows)), range(r)):
        add({(a, k): u[a] for a in range(r)}, half.U_back[i][k])
    B = _columns_permuted(half.B, columns)
    for a, j in product(range(r), range(len(B[0]))):
        add({(a, b): B[b][j] for b in range(r)}, half.B_back[a][j])
    for a, k in product(range(r), repeat=2):  # V L - L V^-1 = 0
        coefficients: dict = {}
        for b in range(r):
            coefficients[(b, k)] = coefficients.get((b, k), exact(0)) + half.V[a][b]
            coefficients[(a, b)] = coefficients.get((a, b), exact(0)) - half.V_inverse[b][k]
        add(coefficients, exact(0))
    solution = solve_affine(tuple(equations), tuple(right))
    if solution.failed is not None:
        return []
    found: list[Matrix] = []
    for factors in islice(product((0, 1, -1), repeat=len(solution.directions)), 81):
        flat = list(solution.point)
        for t, direction in zip(factors, solution.directions, strict=True):
            flat = [x + t * y for x, y in zip(flat, direction, strict=True)]
        found.append(tuple(tuple(flat[a * r : a * r + r]) for a in range(r)))
    return found


def _judge_half(
    half: _Half, rows: Sequence[int], columns: Sequence[int]
) -> tuple[bool | None, Matrix | None, float, str]:
    """Find L for one half and given permutations: decision, L, residual, witness."""
    L = _observed_L(half, rows)
    candidates = [L] if L is not None else _all_L(half, rows, columns)
    if not candidates:
        return False, None, 0.0, f"no matrix L{half.hat} satisfies the linear conditions"
    first = None
    for candidate in candidates:
        judged = judge_identities(_value_residuals(half, candidate, rows, columns))
        if judged[0] is True:
            return True, candidate, 0.0, ""
        first = first or (judged[0], candidate, *judged[1:])
    assert first is not None
    if L is None and first[0] is False:
        return None, first[1], first[2], "the values that no stage sees leave L open"
    if first[0] is False:
        text = f"the linear conditions allow one matrix L{half.hat} only, and {first[3]}"
        return False, first[1], first[2], text
    return first


def check_symmetry(m: GLM, L: Matrix, P: Sequence[int]) -> Symmetry:
    """Check given involutions: all five conditions and that P is an involution."""
    if any(P[P[i]] != i for i in range(m.s)):
        return Symmetry(False, L, tuple(P), 1.0, "P is not an involution")
    holds, size, witness = judge_identities(symmetry_residual(m, L, P))
    return Symmetry(holds, L, tuple(P), size, witness)


def _symmetry_as_given(m: GLM) -> Symmetry:
    try:
        half = _half(m)
    except ExactnessError as error:
        singular = "rank" in str(error)
        text = "V is singular: no step can be reversed" if singular else str(error)
        return Symmetry(False if singular else None, witness=text)
    relation = Relation(half.A, half.exchange, 0, 0)
    best: Symmetry | None = None
    for P in islice(involutions([relation], (0,) * m.s), MAX_PERMUTATIONS):
        holds, L, size, witness = _judge_half(half, P, P)
        if holds is True:  # with balls the condition on the stages may still be open
            stage_holds, size, witness = judge_identities(
                [("A + P A P - U V^-1 B", _stage_residual(half, P, P))]
            )
            holds = stage_holds
        found = Symmetry(holds, L, P, size, witness)
        if holds is True or (holds is None and not m.is_exact):
            return found  # no other exchange of stages can decide more about balls
        best = _better(best, found)
    if best is not None:
        return best
    reversal = tuple(range(m.s - 1, -1, -1))
    _, size, witness = judge_identities(
        [("A + P A P - U V^-1 B", _stage_residual(half, reversal, reversal))]
    )
    return Symmetry(
        False, None, None, size, f"no exchange of stages P works; for the reversal {witness}"
    )


def _better(best, found):  # type: ignore[no-untyped-def]
    """Prefer an open finding to a failed one, else the earlier one."""
    return found if best is None or (best.holds is False and found.holds is None) else best


def symmetry(m: GLM) -> Symmetry:
    """Decide time-reversal symmetry, finding L and P.

    A method that is not symmetric as it stands, but has values or stages without influence, is
    tried again without them.

    References: Butcher, "B-Series" (2021), section 7.6; Khan (2018), section 2.3.1, corrected.
    """
    found = _symmetry_as_given(m)
    if found.holds is True or not m.is_exact:
        return found
    smaller = reduce(m)
    if (smaller.s, smaller.r) == (m.s, m.r):
        return found
    second = _symmetry_as_given(smaller)
    if second.holds is False and found.holds is False:
        return found
    return replace(second, reduced=True)


def is_symmetric(m: GLM) -> bool | None:
    """Whether the method is symmetric; ``None`` where it is open."""
    return symmetry(m).holds


def pair_symmetry(pair: PartitionedGLM) -> PairSymmetry:
    """Decide time-reversal symmetry of a pair, finding both involutions and the exchanges.

    Where the stages are shared (systems that are not separable) P and Q stages are exchanged alike.
    """
    try:
        q, p = (_half(h, hat) for h, hat in zip(halves(pair), ("", "^"), strict=True))
    except ExactnessError:
        return PairSymmetry(False, witness="V or V^ is singular: no step can be reversed")
    n_q, n_p = pair.n_Q, pair.n_P
    offset = n_q if pair.separable else 0
    kinds = (0,) * n_q + (1,) * n_p if pair.separable else (0,) * n_q
    relations = [Relation(q.A, q.exchange, 0, offset), Relation(p.A, p.exchange, offset, 0)]

    def split(both: tuple[int, ...]) -> tuple[tuple[int, ...], tuple[int, ...]]:
        if pair.separable:
            return both[:n_q], tuple(i - n_q for i in both[n_q:])
        return both, both

    best: PairSymmetry | None = None
    for both in islice(involutions(relations, kinds), MAX_PERMUTATIONS):
        found = _pair_at(q, p, *split(both))
        if found.holds is True or (found.holds is None and not pair.is_exact):
            return found
        best = _better(best, found)
    if best is not None:
        return best
    P_Q, P_P = tuple(range(n_q - 1, -1, -1)), tuple(range(n_p - 1, -1, -1))
    _, size, witness = judge_identities(_pair_stage_residuals(q, p, P_Q, P_P))
    return PairSymmetry(
        False, residual=size, witness=f"no exchange of stages works; for the reversal {witness}"
    )


def _pair_stage_residuals(q: _Half, p: _Half, P_Q: Sequence[int], P_P: Sequence[int]) -> Named:
    return [
        ("A + P_Q A P_P - U V^-1 B", _stage_residual(q, P_Q, P_P)),
        ("A^ + P_P A^ P_Q - U^ V^^-1 B^", _stage_residual(p, P_P, P_Q)),
    ]


def _pair_at(q: _Half, p: _Half, P_Q: tuple[int, ...], P_P: tuple[int, ...]) -> PairSymmetry:
    stages = judge_identities(_pair_stage_residuals(q, p, P_Q, P_P))
    first = _judge_half(q, P_Q, P_P)
    second = _judge_half(p, P_P, P_Q)
    verdicts = (stages[0], first[0], second[0])
    holds = False if False in verdicts else None if None in verdicts else True
    sizes = (stages[1], first[2], second[2])
    witnesses = (stages[2], first[3], second[3])
    witness = witnesses[verdicts.index(holds)]
    return PairSymmetry(holds, first[1], second[1], P_P, P_Q, max(sizes), witness)


def is_pair_symmetric(pair: PartitionedGLM) -> bool | None:
    """Whether the pair is symmetric; ``None`` where it is open."""
    return pair_symmetry(pair).holds
