"""Growth of parasitic components, at every eigenvalue of V of modulus one other than the principal.

Near an eigenvalue zeta with left and right eigenvectors w, v (w v = 1) the carried values hold a
component that grows like ``phi' = mu f'(y) phi`` with ``mu = zeta^-1 w B U v``. A method whose
growth parameters are all zero is free of parasitism, to first order in h.

For a pair ``q' = f(p), p' = k(q)`` the components at a common eigenvalue are coupled:
``phi_q' = mu_q f' phi_p, phi_p' = mu_p k' phi_q``, with ``mu_q = zeta^-1 w B U^ v^`` and
``mu_p = zeta^-1 w^ B^ U v``; both are asked to be zero. Where the stages are shared, f and k may
depend on both variables, and ``mu_qq = zeta^-1 w B U v``, ``mu_pp = zeta^-1 w^ B^ U^ v^`` count
too; at an eigenvalue of one V only, one of these is all there is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector
from ..method import GLM, Method
from ..method.preconsistency import preconsistency_vector
from . import polynomials as poly
from .residuals import verdict_of
from .residues import both_ways, residues
from .spectrum import brief, eigenvectors, unimodular_eigenvalues


@dataclass(frozen=True, eq=False)
class Growth:
    """Growth at one eigenvalue."""

    eigenvalue: Exact  #: Zeta, of modulus one; of several components, one that their V share.
    multiplicity: int  #: Of zeta; beyond the principal component where zeta = 1.
    #: Growth matrices ``zeta^-1 W B U X`` in bases of eigenvectors, (multiplicity, multiplicity),
    #: by name: ``mu`` of a single method, ``mu_q`` and ``mu_p`` of a partitioned one, with
    #: ``mu_qq`` and ``mu_pp`` where its stages are shared.
    matrices: Mapping[str, Matrix]

    @property
    def matrix(self) -> Matrix:
        """The growth matrix of a single method, ``mu_q`` of a partitioned one."""
        return next(iter(self.matrices.values()))

    @property
    def listed(self) -> Mapping[str, Matrix]:
        """The matrices that a claim lists: where an eigenvalue is shared, how each half feeds."""
        coupled = {name: self.matrices[name] for name in ("mu_q", "mu_p") if name in self.matrices}
        return coupled or self.matrices

    @property
    def mu(self) -> Scalar | None:
        """The growth parameter: that matrix where it is one number, else ``None``."""
        return self.matrix[0][0] if self.multiplicity == 1 else None


@dataclass(frozen=True, eq=False)
class Parasitism:
    """Growth at all parasitic eigenvalues, by increasing argument in (0, 2 pi)."""

    #: Whether every growth parameter is zero; ``None`` where that is not decided.
    free: bool | None
    #: One record for each eigenvalue; a multiple eigenvalue 1 comes first. Of a pair whose halves
    #: share the stages and no eigenvalue but 1 those of q, and then those of p.
    growths: tuple[Growth, ...] = ()
    residual: float = 0.0  #: Largest growth parameter, 0.0 when free.
    #: One sentence naming the eigenvalue that grows, or why the question is open.
    witness: str = ""


def _growth_matrix(
    zeta: Scalar, left: list[Vector], B: Matrix, U: Matrix, right: list[Vector]
) -> Matrix:
    inner = linalg.matmul(tuple(left), B)
    columns = [linalg.matvec(U, v) for v in right]
    return tuple(tuple(linalg.dot(row, column) / zeta for column in columns) for row in inner)


def _without_principal(m: GLM, left: list[Vector], matrix: Matrix) -> Matrix:
    """Return the growth matrix at 1 with the principal eigenvector, u, taken out.

    An inconsistent method may have none: its growth matrix then has not the eigenvalue 1.
    """
    u = preconsistency_vector(m)
    if u is None or poly.evaluate(poly.characteristic(matrix), 1).is_zero() is False:
        return matrix
    # in the scaled basis u has coordinates w_i u; replace one basis vector by u, then drop it
    x = [linalg.dot(w, u) for w in left]
    at = next(i for i, y in enumerate(x) if y.is_zero() is False)
    rest = [i for i in range(len(left)) if i != at]
    return tuple(tuple(matrix[i][j] - x[i] / x[at] * matrix[at][j] for j in rest) for i in rest)


def _growth_at(m: Method, zeta: Exact) -> Growth:
    """Return growth at an eigenvalue that all V share: how components feed each other, or all."""
    vectors = {c.colour: eigenvectors(c.V, zeta) for c in m.components}
    by_colour = {c.colour: c for c in m.components}
    f, *others = m.palette
    pairs = {"mu": (f, f)}
    for k in others:
        pairs = {"mu_q": (f, k), "mu_p": (k, f)}
        if m.shared:
            pairs |= {"mu_qq": (f, f), "mu_pp": (k, k)}
    found = {
        name: _growth_matrix(zeta, vectors[a][0], by_colour[a].B, by_colour[b].U, vectors[b][1])
        for name, (a, b) in pairs.items()
    }
    if not others and (zeta - 1).is_zero():
        found["mu"] = _without_principal(cast("GLM", m), vectors[f][0], found["mu"])
    return Growth(zeta, len(next(iter(found.values()))), found)


def _parasitic(V: Matrix) -> list[Exact]:
    """Return eigenvalues of modulus one but 1.

    Raises
    ------
    ExactnessError
        For a multiple eigenvalue 1.
    """
    found = unimodular_eigenvalues(V)
    if any(e.multiplicity > 1 and (e.value - 1).is_zero() for e in found):
        raise ExactnessError("1 is a multiple eigenvalue of V, which is not supported for pairs")
    return [e.value for e in found if not (e.value - 1).is_zero()]


def _growths(m: Method) -> tuple[tuple[Growth, ...], str]:
    """Return growth at each eigenvalue, and why the question is still open, or ``""``."""
    if len(m.components) == 1:
        one = cast("GLM", m)
        found = [
            e
            for e in unimodular_eigenvalues(one.V)
            if e.multiplicity > 1 or not (e.value - 1).is_zero()
        ]
        return tuple(_growth_at(one, e.value) for e in found), ""
    if not m.shared and poly.share_only_one(*(poly.characteristic(c.V) for c in m.components)):
        return (), ""
    if (halves := residues(m)) is not None:
        return tuple(
            Growth(x.eigenvalues[n], 1, {name: ((x.mu,),)})
            for name, half in zip(("mu_qq", "mu_pp"), halves.values(), strict=True)
            for x, n in both_ways(half)
        ), ""
    q, p = (_parasitic(c.V) for c in m.components)
    common = [z for z in q if any((z - x).is_zero() for x in p)]
    growths = tuple(_growth_at(m, zeta) for zeta in common)
    if m.shared and len(common) < max(len(q), len(p)):
        return growths, (
            "V and V^ have different eigenvalues and the stages are shared: not supported"
        )
    return growths, ""


def growth(m: Method) -> Parasitism:
    """Return growth parameters at all eigenvalues of V on the unit circle but the principal one.

    A component at an eigenvalue that only one half of a partitioned method has meets no partner at
    first order in h, unless the stages are shared: then its growth within that half counts.

    Parameters
    ----------
    m : Method
        A single or a partitioned method whose V are exact; A, U and B may be balls.

    References: Butcher, Habib, Hill and Norton, SIAM J. Numer. Anal. 52 (2014) 2440.
    """
    try:
        growths, why = _growths(m)
    except ExactnessError as error:
        return Parasitism(None, witness=f"the growth parameters are open: {error}")
    free: bool | None = True
    residual, witness = 0.0, ""
    for g in growths:
        at = f"at the eigenvalue {brief(g.eigenvalue)} of V"
        for name, matrix in g.matrices.items():
            verdict = verdict_of(matrix)
            if verdict.residual > residual:
                residual = verdict.residual
                if name == "mu":
                    sure = f"is {residual:.6g}"
                    size = sure if verdict.holds is False else f"may be up to {residual:.3g}"
                    witness = f"the growth parameter {at} {size} in size"
                else:
                    size = "is" if verdict.holds is False else "may be up to"
                    witness = f"{name} {size} {residual:.6g} in size {at}"
            if free is not False and verdict.holds is not True:
                free = verdict.holds
    if why and free is not False:  # growth at one eigenvalue decides, whatever the others do
        return Parasitism(None, growths, witness=why)
    return Parasitism(free, growths, residual, "" if free else witness)
