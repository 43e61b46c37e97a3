"""The sweep form: diagonally implicit G-symplectic methods, from the few numbers that are free.

A method of this class is given by ``D`` (s numbers), ``X`` (r, s), ``V`` and ``G`` (r, r); then

    B = X diag(D)      U = X^* G V      a_ij = d_j (X^* G X)_ij  for j < i,  half of it for j = i

and a_ij = 0 for j > i. One step needs neither A nor U:

    w = V y
    for i = 1..s:  solve L = h f(x_i^* G (w + d_i x_i L / 2));  w += d_i x_i L
    y+ = w

with x_i the i-th column of X.

**Theorem (G-symplectic by construction).** If ``V^* G V = G``, D is real and G Hermitian, the
method is G-symplectic with (G, D), whatever X and D are.  Proof: write S = X^* G X.  ``D U = D
X^* G V = B^* G V``; ``(D A)_ij = d_i d_j S_ij`` below the diagonal and half of it on the
diagonal, so ``D A + A^* D = D S D = B^* G B``.  Conversely a G-symplectic method with lower
triangular A, a real diagonal of A and nonsingular real D has this form: ``D U = B^* G V`` gives U,
and ``D A + A^* D = B^* G B`` gives A below the diagonal and the real part of it on the diagonal,
which the identity leaves open otherwise.

**Theorem (symmetric by construction).** Let P reverse the stages and let E = diag(+-1). If ``P D
P = D``, ``X = E X P``, ``E G E = G``, ``E V^-1 E = V`` and ``V^* G V = G``, the method is
symmetric with stage reversal P and the involution L = V^-1 E, so that ``V L = E``.  Proof: L^2 =
V^-1 (E V^-1 E) = V^-1 V = I and L V^-1 L = V^-1 (E V^-2 E) = V^-1 V^2 = V.  ``B = V L B P`` is
``X D = E X D P``.  ``U = P U L V``: since L V = V^-1 E V = V^-1 (V^-1 E) = V^-2 E, P U L V = P
X^* G V V^-2 E = X^* E G V^-1 E = X^* G E V^-1 E = X^* G V. ``A + P A P = U V^-1 B``: S = P S P,
so with A = (lower part of S, half its diagonal) D the left side is S D = X^* G V V^-1 X D.

**Theorem (growth parameters).** With the identities above, let ``V v = z v``, |z| = 1, ``v^* G
v`` not 0.  Then ``v^* G`` is a left eigenvector (from V^* G V = G) and the growth parameter of z
is the real number ``mu = z^-1 (v^* G B U v) / (v^* G v) = sum_i d_i |x_i^* G v|^2 / (v^* G v)``:
z itself has cancelled.

References
----------
    Khan (2018), equations (3.10) to (3.15); Butcher, Habib, Hill, Norton, "The control of
    parasitism in G-symplectic methods", SIAM J. Numer. Anal. 52 (2014), 2440-2465.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction
from typing import Any

from ..errors import DataError
from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector
from .glm import GLM

__all__ = ["build", "explicit_stages", "sweep_blocks"]


def explicit_stages(enclosure: object, s: int) -> frozenset[int]:
    """Stages (from 1) whose diagonal entry is zero by an equation ``explicit I`` of the file.

    The pattern of such a file is palindromic, so that stage ``s + 1 - I`` is explicit as well.
    """
    equations = enclosure.get("equations", ()) if isinstance(enclosure, Mapping) else ()
    names = (str(x) for x in equations) if isinstance(equations, list | tuple) else ()
    stages = {int(x.split()[1]) for x in names if re.fullmatch(r"explicit \d{1,3}", x)}
    return frozenset(stages | {s + 1 - i for i in stages})


def sweep_blocks(
    D: Sequence[Any],
    X: Matrix,
    V: Matrix,
    G: Matrix,
    *,
    explicit: Collection[int] = (),
) -> tuple[Matrix, Matrix, Matrix]:
    """Return A, U and B of the sweep form.

    Works for any scalar with the operations of :mod:`glmref.exact`, jets included.

    Args:
        D: (s,) diagonal. X: (r, s). V: (r, r). G: (r, r) Hermitian.
        explicit: numbers (from 1) of the stages whose diagonal entry is known to be zero; it is
            then written as an exact zero, not as a ball around it.
    """
    GX = linalg.matmul(G, X)
    X_star = linalg.conjugate_transpose(X)
    products = linalg.matmul(X_star, GX)
    zero, half = Exact(0), Fraction(1, 2)
    A = tuple(
        tuple(
            zero
            if j > i or (j == i and i + 1 in explicit)
            else products[i][j] * D[j] * (half if j == i else 1)
            for j in range(len(D))
        )
        for i in range(len(D))
    )
    U = linalg.matmul(linalg.conjugate_transpose(GX), V)  # G is Hermitian: (G X)^* = X^* G
    B = tuple(tuple(x * d for x, d in zip(row, D, strict=True)) for row in X)
    return A, U, B


def build(
    D: Vector,
    X: Matrix,
    V: Matrix,
    G: Matrix,
    *,
    explicit: Collection[int] = (),
) -> GLM:
    """Build the method of a data file of class ``"sweep"``, with its G and D.

    Raises
    ------
        DataError: for a wrong shape, or when V does not preserve G.
    """
    r, s = len(X), len(D)
    for name, matrix, shape in (("X", X, (r, s)), ("V", V, (r, r)), ("G", G, (r, r))):
        if (len(matrix), len(matrix[0])) != shape:
            raise DataError(
                f"`{name}` must have shape {shape}, got ({len(matrix)}, {len(matrix[0])})"
            )
    kept = linalg.sub(linalg.matmul(linalg.conjugate_transpose(V), G, V), G)
    for i, j, x in linalg.entries(kept):
        if x.is_zero() is not True:
            raise DataError(
                f"`V` must preserve `G` exactly, but V^* G V - G is {complex(x):.3g} at "
                f"({i + 1}, {j + 1}); the sweep form is G-symplectic only then"
            )
    A, U, B = sweep_blocks(D, X, V, G, explicit=explicit)
    return GLM(A=A, U=U, B=B, V=V, G=G, D=D)
