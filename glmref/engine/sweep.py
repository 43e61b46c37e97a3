"""The sweep form of G-symplectic methods, rounded so that it stays exactly G-symplectic.

For lower triangular A with G and D, w = D, R = B D^-1, U = R^T G, and M only on the diagonal,
because each L_i is added to x = V y before the next stage is formed (:mod:`.forms`). Each update
changes <x, x>_G by exactly 2 <Y_i, L_i>, whatever R was rounded to, if

    U = R^T G      2 M_ii = R_i^T G R_i      V^T G V = G

hold for the rounded numbers. So V is put into an integral basis where it has one, and
:func:`_nudge` picks roundings of R for which the first two hold to about 1e-20.

Of a partitioned method for q' = dq(p), p' = dp(q), with stages Q where dp is evaluated and P where
dq is, L = h d k(Q) and L = h d f(P), the sweep is

    x = V q;  z = V^ p;   at Q_j:  z += w^_j L, L from Q_j = w^_j . x
                          at P_i:  x += w_i L,  L from P_i = w_i . z

In a basis where the bilinear form is the identity it changes <x, z> by exactly Q . L or L . P for
any rounded w, w^, and needs neither A nor U.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import UsageError
from ..exact import Scalar, ball, exact, linalg
from ..exact.linalg import Matrix
from ..method import GLM, PartitionedGLM
from ..method.component import SEPARABLE
from ..method.preconsistency import preconsistency_vector, stage_times
from ..method.rounding import CLOSE
from ..method.stage_order import StageBlock
from ..system.arguments import one_of
from .forms import (
    Row,
    Rows,
    StepForm,
    all_vanish,
    consistent_weights,
    failing,
    float_rows,
    floats,
    is_symplectic_rk,
    large,
    mu_form,
    scaled_rows,
    standard_form,
    vanishes,
)
from .tableau import as_balls

FORMS = ("sweep", "mu", "standard")

#: Roundings up to this many units in the last place away are tried by :func:`_nudge`.
_REACH = {1: 500, 2: 150, 3: 30}

#: Directions tried for the basis of a turning pair of values until the identities hold well enough.
_TILTS = (Fraction(0), Fraction(3, 7), Fraction(-2, 5), Fraction(5, 4))
_SMALL_DEFECT = Fraction(1, 2**66)
_GOOD_ENOUGH = 2.0**-68


def step_form(method: Any, form: str = "auto") -> StepForm:
    """Choose and compute the form a kernel steps in: one of :data:`FORMS`, else the first to apply.

    Raises
    ------
    UsageError
        When the form asked for does not apply, saying why.
    """
    name = method.name or "the method"
    if not method.is_real:
        raise UsageError(
            f'{name} has complex coefficients; give its real form or use engine="reference"'
        )
    one_of("form", form, ("auto", *FORMS))
    if form in ("auto", "sweep"):
        reason = _sweep_obstacle(method)
        if not reason:
            return (_sweep if method.parts == 1 else _dual_sweep)(method)
        if form == "sweep":
            raise UsageError(f"{name} has no sweep form: {reason}")
    if form in ("auto", "mu"):
        if method.parts == 1 and is_symplectic_rk(method):
            return mu_form(method)
        if form == "mu":
            raise UsageError(
                f"{name} has no mu-form: it is not a symplectic Runge-Kutta method with nonzero "
                f"weights"
            )
    found = standard_form(method)
    return found if method.parts == 1 else merged_multistep(found, method)


def _bilinear(method: Any) -> tuple[Matrix, Sequence[Sequence[Scalar]]] | None:
    """Return G and D at the stages of each component: as given, or 1 and weights of one value."""
    given = [method.D] if method.parts == 1 else [method.D_Q, method.D_P]
    known = [D for D in given if D is not None]
    if method.G is not None and len(known) == len(given):
        return method.G, known
    if all(len(c.V) == 1 for c in method.components):
        # the weights at the stages of a component are those that move the other one
        return ((exact(1),),), [c.B[0] for c in method.components[::-1]]
    return None


def _sweep_obstacle(method: Any) -> str:
    """Return why the method has no sweep form, or ``""``.

    The identities are tested in ball arithmetic on the coefficients as given: a file whose G or D
    is wrong is stepped with its own A and U, never with others.
    """
    pair = method.parts == 2
    if pair and any(block.implicit for block in method.stage_blocks(SEPARABLE)):
        return "its stages depend on each other"
    if not pair and not linalg.is_lower_triangular(method.A):
        return "A is not lower triangular"
    found = _bilinear(method)
    if found is None:
        return "G, D_P and D_Q are not given" if pair else "G and D are not given"
    if len(method.components[0].V) != len(method.components[-1].V):
        return "the numbers of values of q and p differ"
    G, D = as_balls(found[0]), [[ball(x) for x in row] for row in found[1]]
    D_Q, D_P = D[0], D[-1]
    if any(vanishes(x) for x in (*D_Q, *D_P)):
        return "D has a zero"
    if not all(x.is_real() for row in found[0] for x in row):
        return "G is not real"
    first, last = method.components[0], method.components[-1]
    (A, U, B, V), (A_, U_, B_, V_) = (map(as_balls, c.matrices) for c in (first, last))
    T, product = linalg.transpose, linalg.matmul
    left = linalg.add(scaled_rows(D_P, A_), T(scaled_rows(D_Q, A)))
    defects = [
        linalg.sub(product(T(V), G, V_), G),
        linalg.sub(scaled_rows(D_P, U_), product(T(B), G, V_)),
        linalg.sub(scaled_rows(D_Q, U), product(T(B_), T(G), V)),
        linalg.sub(left, product(T(B), G, B_)),
    ]
    names = ["V^T G V = G", "D U = B^T G V", "D U = B^T G^T V", "D A + A^T D = B^T G B"]
    if pair:
        names = ["V^T G V^ = G", "D_P U^ = B^T G V^", "D_Q U = B^^T G^T V"]
        names.append("D_P A^ + A^T D_Q = B^T G B^")
    return failing(dict(zip(names, defects, strict=True)))


# --- the basis in which V is integral -----------------------------------------------------------


def _near_integer(x: Scalar) -> int | None:
    nearest = round(float(x))
    return nearest if (x - nearest).magnitude() < CLOSE else None


def _components(*patterns: Matrix) -> list[list[int]]:
    """Return index sets that the matrices do not couple."""
    r = len(patterns[0])
    label = list(range(r))
    for p in patterns:
        for i, j, x in linalg.entries(p):
            if x.magnitude() > CLOSE:
                old, new = max(label[i], label[j]), min(label[i], label[j])
                label = [new if k == old else k for k in label]
    return [[i for i in range(r) if label[i] == k] for k in sorted(set(label))]


def _block_basis(V: Matrix, G: Matrix, index: list[int], tilt: Fraction) -> Matrix:
    """Return a basis where the block of V is integral and that of G dyadic, if there is one.

    One value: scaled so that G = +-1. Two values turning by 60, 90 or 120 degrees: p and V p with
    p = (1, tilt), for which V^T G V = G gives G = <p, p>_G [[1, trace/2], [trace/2, 1]]. A block
    whose V is integral already is only scaled.
    """
    v = tuple(tuple(V[i][j] for j in index) for i in index)
    g = tuple(tuple(G[i][j] for j in index) for i in index)
    size = len(index)
    integral = all(_near_integer(x) is not None for row in v for x in row)
    # eigenvalues 1 and -1 have trace 0 too, and an eigenvector p would be its own V p
    turning = size == 2 and _near_integer(v[0][0] + v[1][1]) in (-1, 0, 1) and (
        _near_integer(v[0][0] * v[1][1] - v[0][1] * v[1][0]) == 1
    )  # fmt: skip
    if turning and (tilt or not integral):
        p = (exact(1), exact(tilt))
        scale = linalg.dot(p, linalg.matvec(g, p))
        turned = linalg.matvec(v, p)
        columns: Matrix = tuple(zip(p, turned, strict=True))
    elif integral:
        scale = next((x for row in g for x in row if x.magnitude() > CLOSE), exact(1))
        columns = linalg.identity(size)
    else:
        return linalg.identity(size)
    if scale.magnitude() < CLOSE:
        return linalg.identity(size)
    if (scale * scale - 1).magnitude() < CLOSE:
        return columns
    return linalg.scale(1 / ball(scale if float(scale) > 0 else -scale).sqrt(), columns)


def integral_basis(V: Matrix, G: Matrix, tilt: Fraction = Fraction(0)) -> Matrix:
    """Return the matrix whose columns are the new basis, see :func:`_block_basis`."""
    r = len(V)
    columns: list[list[Scalar]] = [[exact(0)] * r for _ in range(r)]
    for index in _components(V, G):
        block = _block_basis(V, G, index, tilt)
        for a, i in enumerate(index):
            for b, j in enumerate(index):
                columns[i][j] = block[a][b]
    return tuple(tuple(row) for row in columns)


# --- the sweep ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Rounded:
    """A sweep in double precision in one basis: rows omega_i, their halves of <omega, omega>_G."""

    back: Matrix
    to_form: Matrix
    V: tuple[tuple[Fraction, ...], ...]
    G: tuple[tuple[Fraction, ...], ...]
    omega: list[list[Fraction]]
    half: list[float]
    residue: list[Fraction]

    @property
    def defect(self) -> Fraction:
        """Largest difference between a half norm and the double that stands for it."""
        return max(abs(x) for x in self.residue)


def _rounded(method: GLM, G0: Matrix, D: Sequence[Scalar], tilt: Fraction) -> _Rounded:
    V0 = as_balls(method.V)
    back = integral_basis(V0, G0, tilt)
    to_form = linalg.inverse(back)
    V = _snapped(linalg.matmul(to_form, V0, back))
    G = _snapped(linalg.matmul(linalg.transpose(back), G0, back))
    B = linalg.matmul(to_form, as_balls(method.B))
    omega, half, residue = [], [], []
    for i in range(method.s):
        explicit = method.A[i][i].is_zero() is True
        row = _nudge([row[i] / D[i] for row in B], G, explicit)
        exact_half = _norm(G, row) / 2
        half.append(0.0 if explicit else float(exact_half))
        omega.append(row)
        residue.append(exact_half - Fraction(half[-1]))
    return _Rounded(back, to_form, V, G, omega, half, residue)


def _sweep(method: GLM) -> StepForm:
    found = _bilinear(method)
    assert found is not None
    G0, D = as_balls(found[0]), [ball(x) for x in found[1][0]]
    candidates = []
    for tilt in _TILTS:
        candidates.append(_rounded(method, G0, D, tilt))
        if candidates[-1].defect < _SMALL_DEFECT:
            break
    x = min(candidates, key=lambda candidate: candidate.defect)
    s, r = method.s, method.r
    u = preconsistency_vector(method)
    rows = Rows(
        U=tuple(tuple(float(_dot(g, w)) for g in x.G) for w in x.omega),
        M=tuple(tuple(x.half[i] if i == j else 0.0 for j in range(s)) for i in range(s)),
        weights=consistent_weights([float(d) for d in D], [float(w[0]) for w in x.omega]),
        V=tuple(tuple(float(e) for e in row) for row in x.V),
        R=tuple(tuple(float(w[k]) for w in x.omega) for k in range(r)),
        R_residue=((0.0,) * s,) * r,
        large=large(None if u is None else linalg.matvec(x.to_form, u), r),
        to_form=float_rows(x.to_form), from_form=float_rows(x.back),
    )  # fmt: skip
    return StepForm(
        kind="sweep", running=True, components=(rows,),
        blocks=tuple(StageBlock((i,), x.half[i] != 0.0) for i in range(s)),
        c=floats(stage_times(method)),
        G=tuple(tuple(float(e) for e in row) for row in x.G),
        M_residue=tuple(float(e) if abs(e) > _SMALL_DEFECT else 0.0 for e in x.residue),
    )  # fmt: skip


def _snapped(matrix: Matrix) -> tuple[tuple[Fraction, ...], ...]:
    """Return multiples of 1/4 where the entry is one (to :data:`CLOSE`), else nearest doubles."""
    return tuple(tuple(_snap(x) for x in row) for row in matrix)


def _snap(x: Scalar) -> Fraction:
    quarter = _near_integer(4 * x)
    return Fraction(float(x)) if quarter is None else Fraction(quarter, 4)


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _norm(G: tuple[tuple[Fraction, ...], ...], row: Sequence[Fraction]) -> Fraction:
    return _dot([_dot(g, row) for g in G], row)


def _nudge(
    row: Sequence[Scalar], G: tuple[tuple[Fraction, ...], ...], explicit: bool
) -> list[Fraction]:
    """Round one row omega of R^T so that the sweep's identities hold for the rounded numbers.

    ``omega^T G`` must be representable, and ``omega^T G omega / 2`` must be a double (zero for an
    explicit stage): a rounding error there has the same sign at every step and is the linear drift
    that compensated summation cannot remove. Roundings within :data:`_REACH` units are searched for
    the one that comes nearest, typically within 1e-20.
    """
    r = range(len(G))
    snapped = [_snap(x) for x in row]
    image = [_snap(sum((x * y for x, y in zip(row, g, strict=True)), exact(0))) for g in G]
    omega, units = [], []
    for k in r:
        coupled = [m for m in r if m != k and G[k][m]]
        # values that G couples share a grid on which omega and omega^T G are representable
        sizes = [abs(snapped[m]) for m in (k, *coupled)]
        sizes += [2 * abs(image[m]) for m in (k, *coupled) if coupled]
        unit = Fraction(math.ulp(float(max(sizes))))
        # what is a short fraction stays, and so do the zeros of omega^T G
        fixed = snapped[k].denominator <= 4 or not all(image[m] for m in (k, *coupled))
        short = snapped[k].denominator <= 4
        omega.append(snapped[k] if short else round(snapped[k] / unit) * unit)
        units.append(Fraction(0) if fixed else unit)
    for k in r:
        if not image[k] and omega[k]:
            # an indefinite form may have a zero on its diagonal: then another value makes up for it
            at = k if G[k][k] else max(r, key=lambda m: abs(G[k][m]))
            omega[at] -= _dot(G[k], omega) / G[k][at]
    free = sorted((k for k in r if units[k]), key=lambda k: units[k])[: len(_REACH)]
    if free:
        half = _norm(G, omega) / 2
        grid = Fraction(0) if explicit else Fraction(math.ulp(float(half)))
        slopes = [_dot(G[k], omega) * units[k] for k in free]
        for k, n in zip(free, _best_shift(half, slopes, grid, _REACH[len(free)]), strict=True):
            omega[k] += n * units[k]
    return omega


def _best_shift(
    value: Fraction, slopes: list[Fraction], grid: Fraction, reach: int
) -> tuple[int, ...]:
    """Return integers n within ``reach`` that bring ``value + n . slopes`` nearest to the grid."""
    offset = value if not grid else value - Fraction(float(value))
    axis = np.arange(-reach, reach + 1)
    total = np.full((1,) * len(slopes), float(offset))
    for k, slope in enumerate(slopes):
        shape = [1] * len(slopes)
        shape[k] = -1
        total = total + (axis * float(slope)).reshape(shape)
    distance = np.abs(total)
    if grid:
        unit = float(grid)
        distance = np.abs(total - unit * np.round(total / unit))
    # of those that are good enough the smallest shift
    size = sum(np.square(a) for a in np.ix_(*[axis] * len(slopes)))
    cost = np.maximum(distance, _GOOD_ENOUGH) + _GOOD_ENOUGH * 1e-6 * size
    place = np.unravel_index(np.argmin(cost), cost.shape)
    return tuple(int(axis[i]) for i in place)


# --- two components -----------------------------------------------------------------------------


def _dual_sweep(pair: PartitionedGLM) -> StepForm:
    """Return the sweep of a partitioned method, which needs neither A nor U."""
    found = _bilinear(pair)
    assert found is not None
    G, (D_Q, D_P) = as_balls(found[0]), [[ball(x) for x in D] for D in found[1]]
    # q in a basis where V is integral (unscaled: the form pairs q with p), p in the dual one
    back = integral_basis(as_balls(pair.V), linalg.identity(pair.r))
    to_q, to_p = linalg.inverse(back), linalg.matmul(linalg.transpose(back), G)
    bases = ((to_q, back), (to_p, linalg.inverse(to_p)))
    updates = [
        float_rows(tuple(
            tuple(x / d for x, d in zip(row, D, strict=True))
            for row in linalg.matmul(to, as_balls(c.B))
        ))
        for (to, _), c, D in zip(bases, pair.components, (D_P, D_Q), strict=True)
    ]  # fmt: skip
    components = []
    for k, ((to, of), c, D) in enumerate(zip(bases, pair.components, (D_Q, D_P), strict=True)):
        u, moved, n = preconsistency_vector(c), len(updates[k][0]), len(D)
        components.append(Rows(
            U=tuple(zip(*updates[1 - k], strict=True)), M=((0.0,) * moved,) * n, weights=floats(D),
            V=float_rows(linalg.matmul(to, as_balls(c.V), of)), R=updates[k],
            R_residue=((0.0,) * moved,) * len(c.V),
            large=large(None if u is None else linalg.matvec(to, u), len(c.V)),
            to_form=float_rows(to), from_form=float_rows(of),
        ))  # fmt: skip
    return merged(StepForm("sweep", True, tuple(components), pair.stage_blocks(SEPARABLE)))


def merged(form: StepForm) -> StepForm:
    """Put the last update of p of a step and the first one of the next together, where both are.

    The step then begins with an update of q, and what it carries is p + kick h dp(q): one operation
    less for every component, and a shorter chain from step to step. Positions are those of the
    method, up to rounding; p is read by taking the kick back.
    """
    bases = [basis for one in form.components for basis in (one.to_form, one.from_form)]
    if not form.reuses_force or any(basis != ((1.0,),) for basis in bases):
        return form
    q, p = form.components
    first, last = form.blocks[0].stages[0], form.blocks[-1].stages[0]
    kick = q.weights[first]
    if q.weights[last] != kick or first != 0 or set(p.R[0]) != {1.0}:
        return form
    weights = tuple(w + kick if j == last else w for j, w in enumerate(q.weights))
    return _without_first(form, replace(q, weights=weights), p, (kick,))


def _without_first(form: StepForm, q: Rows, p: Rows, kick: Row) -> StepForm:
    """Return the form without its first stage Q, whose force is in the values that are carried."""

    def rest(rows: tuple[Row, ...]) -> tuple[Row, ...]:
        return tuple(row[1:] for row in rows)

    q = replace(q, U=q.U[1:], M=q.M[1:], weights=q.weights[1:])
    p = replace(p, M=rest(p.M), R=rest(p.R), R_residue=rest(p.R_residue))
    blocks = tuple(replace(b, stages=tuple(j - 1 for j in b.stages)) for b in form.blocks[1:])
    return replace(form, components=(q, p), blocks=blocks, kick=kick)


def merged_multistep(form: StepForm, pair: PartitionedGLM) -> StepForm:
    """Do :func:`merged` for one value of q and several of p, as in a symmetric multistep method.

    Let k be what the last force adds to the values of p. Where the first one adds V^ k to them, and
    U^ k to every stage P, the values p + k h dp(q) are carried by V^ and 2 k h dp(q) alone, and
    the stages P are read from them as they stand: a step is a rotation and a kick.
    """
    q, p = form.components
    if len(p.V) == 1 or not form.reuses_force:
        return form
    first, last = form.blocks[0].stages[0], form.blocks[-1].stages[0]
    A, U, B, V = map(as_balls, pair.components[1].matrices)
    k = tuple((row[last],) for row in B)
    begins = linalg.sub(linalg.matmul(V, k), tuple((row[first],) for row in B))
    read = linalg.sub(linalg.matmul(U, k), tuple((row[first],) for row in A))
    kick = tuple(row[last] for row in p.R)
    exactly = not any(row[last] for row in p.R_residue)
    if first != 0 or not exactly or not all_vanish(begins) or not all_vanish(read):
        return form
    R = tuple((*row[:last], 2 * row[last], *row[last + 1 :]) for row in p.R)
    return _without_first(form, q, replace(p, R=R), kick)
