"""The sweep form of G-symplectic methods, rounded so that it stays exactly G-symplectic.

For lower triangular A with G and D, w = D, R = B D^-1, U = R^T G, and M only on the diagonal,
because each L_i is added to x = V y before the next stage is formed (:mod:`.forms`). Each update
changes <x, x>_G by exactly 2 <Y_i, L_i>, whatever R was rounded to, if

    U = R^T G      2 M_ii = R_i^T G R_i      V^T G V = G

hold for the rounded numbers. So V is put into an integral basis where it has one, and
:func:`_nudge` picks roundings of R for which the first two hold to about 1e-20.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..errors import UsageError
from ..exact import Scalar, ball, exact, linalg
from ..exact.linalg import Matrix
from ..method import GLM
from ..method.solution_value import preconsistency_vector, stage_times
from ..method.stage_order import StageBlock
from .forms import (
    CLOSE,
    StepForm,
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


def step_form(method: GLM, form: str = "auto") -> StepForm:
    """Choose and compute the form a kernel steps in.

    Parameters
    ----------
    method : GLM
        Real GLM.
    form : str
        One of :data:`FORMS`, or ``"auto"``: the first of them that applies.

    Raises
    ------
    UsageError
        When the form asked for does not apply, saying why.
    """
    if not method.is_real:
        raise UsageError(
            f"{method.name or 'the method'} has complex coefficients; give its real form or use "
            f'engine="reference"'
        )
    if form not in ("auto", *FORMS):
        raise UsageError(f"`form` must be auto, {', '.join(FORMS)}, got {form!r}")
    if form in ("auto", "sweep"):
        reason = _sweep_obstacle(method)
        if not reason:
            return _sweep(method)
        if form == "sweep":
            raise UsageError(f"{method.name or 'the method'} has no sweep form: {reason}")
    if form in ("auto", "mu"):
        if is_symplectic_rk(method):
            return mu_form(method)
        if form == "mu":
            raise UsageError(
                f"{method.name or 'the method'} has no mu-form: it is not a symplectic "
                f"Runge-Kutta method with nonzero weights"
            )
    return standard_form(method)


def _quadratic_form(method: GLM) -> tuple[Matrix, Sequence[Scalar]] | None:
    """(G, D) of the method: as its file gives it, or (1, b) for one value."""
    if method.G is not None and method.D is not None:
        return method.G, method.D
    if method.r == 1:
        return ((exact(1),),), method.B[0]
    return None


def _sweep_obstacle(method: GLM) -> str:
    """Return why the method has no sweep form, or ``""``.

    The identities are tested in ball arithmetic on the coefficients as given: a file whose G or D
    is wrong is stepped with its own A and U, never with others.
    """
    if not linalg.is_lower_triangular(method.A):
        return "A is not lower triangular"
    pair = _quadratic_form(method)
    if pair is None:
        return "G and D are not given"
    G, D = as_balls(pair[0]), tuple(ball(x) for x in pair[1])
    if any(vanishes(x) for x in D):
        return "D has a zero"
    if not all(x.is_real() for row in pair[0] for x in row):
        return "G is not real"
    A, U, B, V = (as_balls(x) for x in (method.A, method.U, method.B, method.V))
    Bt, Vt = linalg.transpose(B), linalg.transpose(V)
    DA, DU = scaled_rows(D, A), scaled_rows(D, U)
    checks = {
        "G = V^T G V": linalg.sub(G, linalg.matmul(Vt, G, V)),
        "D U = B^T G V": linalg.sub(DU, linalg.matmul(Bt, G, V)),
        "D A + A^T D = B^T G B": linalg.sub(
            linalg.add(DA, linalg.transpose(DA)), linalg.matmul(Bt, G, B)
        ),
    }
    return failing(checks)


# --- the basis in which V is integral -----------------------------------------------------------


def _near_integer(x: Scalar) -> int | None:
    nearest = round(float(x))
    return nearest if (x - nearest).magnitude() < CLOSE else None


def _components(*patterns: Matrix) -> list[list[int]]:
    """Index sets that the matrices do not couple."""
    r = len(patterns[0])
    label = list(range(r))
    for p in patterns:
        for i, j, x in linalg.entries(p):
            if x.magnitude() > CLOSE:
                old, new = max(label[i], label[j]), min(label[i], label[j])
                label = [new if k == old else k for k in label]
    return [[i for i in range(r) if label[i] == k] for k in sorted(set(label))]


def _block_basis(V: Matrix, G: Matrix, index: list[int], tilt: Fraction) -> Matrix:
    """Columns of a basis in which the block of V is integral and that of G dyadic, if there is one.

    One value: scaled so that G = +-1. Two values turning by 60, 90 or 120 degrees: p and V p with
    p = (1, tilt), for which V^T G V = G gives G = <p, p>_G [[1, trace/2], [trace/2, 1]]. A block
    whose V is integral already is only scaled.
    """
    v = tuple(tuple(V[i][j] for j in index) for i in index)
    g = tuple(tuple(G[i][j] for j in index) for i in index)
    size = len(index)
    integral = all(_near_integer(x) is not None for row in v for x in row)
    if size == 2 and _near_integer(v[0][0] + v[1][1]) in (-1, 0, 1) and (tilt or not integral):
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
    """Matrix whose columns are the new basis, see :func:`_block_basis`."""
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
    pair = _quadratic_form(method)
    assert pair is not None
    G0, D = as_balls(pair[0]), [ball(x) for x in pair[1]]
    candidates = []
    for tilt in _TILTS:
        candidates.append(_rounded(method, G0, D, tilt))
        if candidates[-1].defect < _SMALL_DEFECT:
            break
    x = min(candidates, key=lambda candidate: candidate.defect)
    s, r = method.s, method.r
    u = preconsistency_vector(method)
    return StepForm(
        kind="sweep", s=s, r=r, running=True,
        U=tuple(tuple(float(_dot(g, w)) for g in x.G) for w in x.omega),
        M=tuple(tuple(x.half[i] if i == j else 0.0 for j in range(s)) for i in range(s)),
        R=tuple(tuple(float(w[k]) for w in x.omega) for k in range(r)),
        V=tuple(tuple(float(e) for e in row) for row in x.V),
        weights=consistent_weights([float(d) for d in D], [float(w[0]) for w in x.omega]),
        R_residue=((0.0,) * s,) * r,
        c=floats(stage_times(method)),
        blocks=tuple(StageBlock((i,), x.half[i] != 0.0) for i in range(s)),
        large=large(None if u is None else linalg.matvec(x.to_form, u), r),
        to_form=float_rows(x.to_form), from_form=float_rows(x.back),
        exact_V=all(e.denominator == 1 for row in x.V for e in row),
        G=tuple(tuple(float(e) for e in row) for row in x.G),
        M_residue=tuple(float(e) if abs(e) > _SMALL_DEFECT else 0.0 for e in x.residue),
    )  # fmt: skip


def _snapped(matrix: Matrix) -> tuple[tuple[Fraction, ...], ...]:
    """Multiples of 1/4 where the entry is one (to :data:`CLOSE`), else the nearest double."""
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
    """Integers n within ``reach`` that bring ``value + n . slopes`` nearest to a grid point."""
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
