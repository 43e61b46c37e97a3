"""The sweep form of pairs: explicit G-symplectic pairs, from the few numbers that are free.

For a separable system q' = f(p), p' = k(q) a pair of this class is given by weights ``b`` (n_P) and
``c`` (n_Q), columns ``X`` (r, n_P) and ``Y`` (r^, n_Q), ``V`` (r, r), ``V^`` (r^, r^), ``G``
(r, r^), and an order of the stages, a word in the letters P and Q. One step is

    q <- V q;  p <- V^ p;   then, letter by letter:
        P:  q += h b_i x_i f(x_i^T G p)          Q:  p += h c_j y_j k(y_j^T G^T q)

with x_i, y_j the columns of X and Y: no stage equation, no A and no U. With S = X^T G Y this is the
partitioned method

    B  = X diag(b)    U  = Y^T G^T V    a_ji  = b_i S_ij where P_i comes before Q_j, else 0
    B^ = Y diag(c)    U^ = X^T G V^     a^_ij = c_j S_ij where Q_j comes before P_i, else 0

A splitting method of T(p) + V(q) is r = r^ = 1, X and Y ones, V = V^ = G = 1.

**Theorem (G-symplectic by construction).** If ``V^T G V^ = G``, the pair is G-symplectic with
(G, D_P = diag(b), D_Q = diag(c)), whatever X, Y, b and c are. Proof: ``D_P U^ = diag(b) X^T G V^ =
B^T G V^`` and likewise ``D_Q U = B^^T G^T V``; ``(D_P A^ + A^T D_Q)_ij = b_i c_j S_ij``, since of
P_i and Q_j exactly one comes first, and that is ``(B^T G B^)_ij``. Conversely every G-symplectic
pair for separable systems whose stages have an explicit order and whose D_P, D_Q are nonsingular
has this form: the identities are the definitions of U, U^, A and A^ solved for them.

**Theorem (symmetric by construction).** Let the word read the same backwards, let P_P and P_Q
reverse the stages, and let E and E^ be diagonal with entries +-1. If b and c are palindromic,
``X = E X P_P``, ``Y = E^ Y P_Q``, ``E G E^ = G``, ``E V^-1 E = V``, ``E^ V^^-1 E^ = V^`` and
``V^T G V^ = G``, the pair is symmetric with the involutions L = V^-1 E and L^ = V^^-1 E^. Proof:
L^2 = V^-1 (E V^-1 E) = I; L V^-1 L = V^-1 E V^-2 E = V^-1 V^2 = V. ``B = V L B P_P`` is ``X diag(b)
= E X P_P diag(b)``. ``U = P_Q U L V``: since L V = V^-1 E V = V^-2 E, the right side is ``P_Q Y^T
G^T V^-1 E = P_Q Y^T G^T E V = Y^T E^ G^T E V = Y^T G^T V``. ``A + P_Q A P_P = U V^-1 B``: S is
unchanged when both stage sets are reversed, and reversal turns "P_i before Q_j" into "after", so
that the left side is ``S^T diag(b) = Y^T G^T V V^-1 X diag(b)``. The other half in the same way.

**Theorem (growth parameters).** Let V v = z v and V^ v^ = z v^ with |z| = 1 and n = v^^* G^T v not
0. Then v^^* G^T is a left eigenvector of V (from V^T G V^ = G), v^* G one of V^, and the coupled
growth parameters are ``mu_q = sum b_i |x_i^T G v^|^2 / n`` and ``mu_p = sum c_j |y_j^T G^T v|^2 /
conj(n)``: z itself has cancelled. For V = V^ = diag(1, -1), G = diag(1, g), X = (1, w), Y = (1, v)
they are ``g sum b_i w_i^2`` and ``g sum c_j v_j^2``: two conditions on b, w and c, v apart.

References
----------
    Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), theorem VI.4.6, for r = 1;
    Butcher, Habib, Hill, Norton, "The control of parasitism in G-symplectic methods", SIAM J.
    Numer. Anal. 52 (2014), 2440-2465, for the growth parameters of single methods.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from ..errors import DataError
from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector
from .glm import PartitionedGLM

__all__ = ["build", "columns", "pair_sweep_blocks", "stage_word"]

_LONGEST_WORD = 400


def columns(rows: Sequence[Sequence[Any]], size: int) -> Matrix:
    """X (or Y) from its rows 2..r: a first row of ones is put on top."""
    return ((Exact(1),) * size, *(tuple(row) for row in rows))


def stage_word(text: str, n_P: int, n_Q: int) -> tuple[tuple[str, int], ...]:
    """The stages in their order, as pairs (letter, number from 0).

    Raises
    ------
        DataError: when the word has other letters, or not n_P times P and n_Q times Q.
    """
    if len(text) > _LONGEST_WORD or not re.fullmatch(r"[PQ]+", text):
        raise DataError("`stages` must be a word in the letters P and Q, such as 'PQP'")
    if (text.count("P"), text.count("Q")) != (n_P, n_Q):
        raise DataError(
            f"`stages` must have one P for each of the {n_P} entries of `b` and one Q for each of "
            f"the {n_Q} entries of `c`, got {text.count('P')} and {text.count('Q')}"
        )
    seen = {"P": 0, "Q": 0}
    result = []
    for letter in text:
        result.append((letter, seen[letter]))
        seen[letter] += 1
    return tuple(result)


def pair_sweep_blocks(
    b: Sequence[Any],
    X: Matrix,
    c: Sequence[Any],
    Y: Matrix,
    *,
    V: Matrix,
    V_hat: Matrix,
    G: Matrix,
    word: Sequence[tuple[str, int]],
) -> dict[str, Matrix]:
    """Return A, U, B, A_hat, U_hat and B_hat of the sweep form, by name.

    Works for any scalar with the operations of :mod:`glmref.exact`, jets included.

    Args:
        b: (n_P,). X: (r, n_P). c: (n_Q,). Y: (r^, n_Q). V: (r, r). V_hat: (r^, r^). G: (r, r^).
        word: the stages in their order, see :func:`stage_word`.
    """
    T = linalg.transpose
    GY, XG = linalg.matmul(G, Y), linalg.matmul(T(X), G)
    S = linalg.matmul(T(X), GY)
    place = {stage: at for at, stage in enumerate(word)}
    zero = Exact(0)
    n_P, n_Q = range(len(b)), range(len(c))
    A = tuple(
        tuple(b[i] * S[i][j] if place["P", i] < place["Q", j] else zero for i in n_P) for j in n_Q
    )
    A_hat = tuple(
        tuple(c[j] * S[i][j] if place["Q", j] < place["P", i] else zero for j in n_Q) for i in n_P
    )
    return {
        "A": A,
        "U": linalg.matmul(T(GY), V),
        "B": tuple(tuple(x * d for x, d in zip(row, b, strict=True)) for row in X),
        "A_hat": A_hat,
        "U_hat": linalg.matmul(XG, V_hat),
        "B_hat": tuple(tuple(x * d for x, d in zip(row, c, strict=True)) for row in Y),
    }


def build(
    b: Vector,
    c: Vector,
    *,
    w: Matrix = (),
    v: Matrix = (),
    V: Matrix,
    V_hat: Matrix,
    G: Matrix,
    stages: str,
) -> PartitionedGLM:
    """Build the pair of a data file of class ``"pair-sweep"``, with its G, D_P and D_Q.

    Args:
        b: (n_P,) and c: (n_Q,) weights. w: (r - 1, n_P) rows 2..r of X. v: (r^ - 1, n_Q) rows
        2..r^ of Y. V, V_hat, G: as in the module docstring. stages: their order, such as "PQP".

    Raises
    ------
        DataError: for a wrong shape, or when V and V^ do not preserve G.
    """
    r, r_hat = len(w) + 1, len(v) + 1
    shapes: Mapping[str, tuple[Matrix, tuple[int, int]]] = {
        "w": (w or ((),), (r - 1, len(b)) if w else (1, 0)),
        "v": (v or ((),), (r_hat - 1, len(c)) if v else (1, 0)),
        "V": (V, (r, r)),
        "V_hat": (V_hat, (r_hat, r_hat)),
        "G": (G, (r, r_hat)),
    }
    for name, (matrix, shape) in shapes.items():
        if (len(matrix), len(matrix[0])) != shape:
            raise DataError(
                f"`{name}` must have shape {shape}, got ({len(matrix)}, {len(matrix[0])}); "
                f"`w` and `v` have one row for each value carried beyond the first"
            )
    kept = linalg.sub(linalg.matmul(linalg.transpose(V), G, V_hat), G)
    for i, j, x in linalg.entries(kept):
        if x.is_zero() is not True:
            raise DataError(
                f"`V` and `V_hat` must preserve `G` exactly, but V^T G V^ - G is "
                f"{complex(x):.3g} at ({i + 1}, {j + 1}); the sweep form is G-symplectic only then"
            )
    word = stage_word(stages, len(b), len(c))
    X, Y = columns(w, len(b)), columns(v, len(c))
    blocks = pair_sweep_blocks(b, X, c, Y, V=V, V_hat=V_hat, G=G, word=word)
    return PartitionedGLM(
        **blocks,  # pyright: ignore[reportArgumentType]
        V=V,
        V_hat=V_hat,
        G=G,
        D_P=tuple(b),
        D_Q=tuple(c),
        separable=True,
    )
