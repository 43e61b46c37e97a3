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
from ..exact import Exact, Scalar
from ..exact.linalg import Matrix, Vector, identity
from .embedded import EmbeddedRow
from .entries import check_shape
from .glm import PartitionedGLM

_ZERO, _ONE = Exact(0), Exact(1)


def _combined(first: Scalar, second: Sequence[Scalar]) -> Vector:
    """Return the first V_0 + sum second_l (V_l - V_0)."""
    return (first - sum(second, _ZERO), *second)


def nystrom_weights(b: Vector, b_prime: Vector, *, shared: bool) -> tuple[Vector, Vector]:
    """Return weights of q on the stages P and of p on the stages Q, for b and b' on the slopes g.

    They are those of ``q + h q' + h^2 sum b_i g_i`` and of ``q' + h sum b'_i g_i``; ``shared`` says
    whether g sees q', so that Q_i and P_i are evaluated together.
    """
    s = len(b)
    if not shared:
        return _combined(_ONE, b), b_prime
    return (*_combined(_ONE, b), *((_ZERO,) * s)), (*((_ZERO,) * (s + 1)), *b_prime)


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
    below_q = tuple(_combined(x, row) for x, row in zip(c, A, strict=True))
    below_p = ((_ZERO,) * s, *identity(s))
    if A_prime is not None:
        nothing = (_ZERO,) * (2 * s + 1)
        below_q = ((nothing,) * (s + 1)) + tuple((*row, *((_ZERO,) * s)) for row in below_q)
        below_p = tuple((*((_ZERO,) * (s + 1)), *row) for row in (*below_p, *A_prime))
    weights = nystrom_weights(b, b_prime, shared=shared)
    one = ((_ONE,),)
    return PartitionedGLM(
        below_q, one * len(below_q), (weights[0],), one,
        below_p, one * len(below_p), (weights[1],), one,
        separable=not shared,
        embedded=tuple(
            EmbeddedRow(name, nystrom_weights(x, y, shared=shared)) for name, x, y in embedded
        ),
    )  # fmt: skip
