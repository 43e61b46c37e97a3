"""Runge-Kutta-Nystrom methods as partitioned methods, so that all that is known of pairs applies.

``q'' = g(q)`` is ``q' = f(p), p' = k(q)`` with f the identity. The values ``V_0 = p`` and
``V_l = p + h k(Q_l)`` are the stages P; a stage Q is a combination of them, because h k is a
difference of two::

    Q_i = q + c_i h p + h^2 sum a_il g_l = q + h (c_i V_0 + sum a_il (V_l - V_0))

With ``q'' = g(q, q')`` the stages of k are pairs (Q_i, P_i), ``P_i = p + h sum a'_il g_l``, and the
V_l are further stages, at which f alone is evaluated.

References
----------
Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I" (1993), section II.14.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import DataError
from ..exact.linalg import Matrix, Vector
from ..judge import families
from .embedded import EmbeddedRow
from .entries import as_vector, check_shape
from .glm import PartitionedGLM


def nystrom(
    A: Matrix,
    b: Vector,
    b_prime: Vector,
    c: Vector,
    A_prime: Matrix | None = None,
    embedded: Sequence[tuple[str, Vector, Vector]] = (),
) -> PartitionedGLM:
    """Make the pair of a Nystrom method.

    Parameters
    ----------
    A : Matrix (s, s)
        ``Q_i = q + c_i h q' + h^2 sum a_ij g_j``.
    b, b_prime, c : Vector (s,)
        Weights of q and of q', and abscissae.
    A_prime : Matrix (s, s), optional
        ``Q'_i = q' + h sum a'_ij g_j``, where g sees q'.
    embedded : sequence of (name, b, b')
        Further weights.

    Returns
    -------
    PartitionedGLM
        For ``q' = f(p), p' = k(q)`` or, with A', ``p' = k(q, p)``; f linear.

    Raises
    ------
    DataError
        For shapes that do not fit.
    """
    s = len(c)
    for name, row in (("b", b), ("b_prime", b_prime)):
        if len(row) != s:
            raise DataError(f"`{name}` must have s = {s} entries as `c` has, got {len(row)}")
    for name, rows in (("A", A), ("A_prime", A_prime)):
        if rows is not None:
            check_shape(name, rows, s, s, "(s, s)")
    shared = A_prime is not None

    def weights(b: Vector, b_prime: Vector) -> tuple[Vector, ...]:
        return tuple(as_vector(x, "b") for x in families.nystrom_weights(b, b_prime, shared))

    q, p = families.nystrom(A, c, A_prime, weights(b, b_prime))
    return PartitionedGLM(
        *q, *p, separable=not shared,
        embedded=tuple(EmbeddedRow(name, weights(x, y)) for name, x, y in embedded),
    )  # fmt: skip
