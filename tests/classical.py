"""Classical Runge-Kutta and multistep methods, derived exactly from their nodes.

Runge-Kutta families as (A, b), with nodes in closed form by square roots; Adams methods and
backward differentiation as (alpha, beta), rational. Nothing is typed in but the nodes.

References: Hairer, Nørsett and Wanner, "Solving Ordinary Differential Equations I" (1993), sections
II.7 and III.1; Hairer and Wanner, "Solving Ordinary Differential Equations II" (1996), sections
IV.5 and V.6; Hairer, Lubich and Wanner (2006), section IV.2.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from glmref.exact import Exact, Scalar, exact
from glmref.exact.linalg import Matrix, Vector
from glmref.method.entries import Entries, as_vector

_ZERO, _ONE = Exact(0), Exact(1)


def _lagrange(nodes: Sequence[Scalar]) -> list[list[Scalar]]:
    """Coefficients (constant first) of the Lagrange basis polynomials of the nodes."""
    basis: list[list[Scalar]] = []
    for j, node in enumerate(nodes):
        p: list[Scalar] = [_ONE]
        for other in (*nodes[:j], *nodes[j + 1 :]):
            shifted = [_ZERO, *p]
            p = [
                (x - other * y) / (node - other) for x, y in zip(shifted, [*p, _ZERO], strict=True)
            ]
        basis.append(p)
    return basis


def _integral(p: Sequence[Scalar], low: Scalar, high: Scalar) -> Scalar:
    terms = (x * (high ** (k + 1) - low ** (k + 1)) / (k + 1) for k, x in enumerate(p))
    return sum(terms, _ZERO)


def collocation(c: Sequence[Scalar]) -> tuple[Matrix, Vector]:
    """Collocation method with nodes c: ``a_ij`` integrates l_j to c_i, ``b_j`` to 1."""
    basis = _lagrange(c)
    A = tuple(tuple(_integral(p, _ZERO, x) for p in basis) for x in c)
    return A, tuple(_integral(p, _ZERO, _ONE) for p in basis)


def _root(value: int | str | Scalar) -> Scalar:
    return (exact(Fraction(value)) if isinstance(value, int | str) else value).sqrt()


def _symmetric_nodes(positive: Sequence[Scalar], *, middle: bool) -> list[Scalar]:
    """Nodes (1 + x)/2 on [0, 1] of the zeros -x, .., x; the positive half is given, descending."""
    zeros = [-x for x in positive] + ([_ZERO] if middle else []) + list(reversed(positive))
    return [(x + 1) * Fraction(1, 2) for x in zeros]


def gauss(s: int) -> tuple[Matrix, Vector]:
    """Gauss method with s = 1 to 5 stages, of order 2s."""
    positive = {
        1: [],
        2: [_root("1/3")],
        3: [_root("3/5")],
        4: [_root(Fraction(3, 7) + sign * Fraction(2, 7) * _root("6/5")) for sign in (1, -1)],
        5: [_root(5 + sign * 2 * _root("10/7")) / 3 for sign in (1, -1)],
    }[s]
    return collocation(_symmetric_nodes(positive, middle=s % 2 == 1))


def radau_iia(s: int) -> tuple[Matrix, Vector]:
    """Radau IIA method with s = 1, 2 or 3 stages, of order 2s - 1."""
    root = _root(6)
    return collocation(
        {1: [_ONE], 2: [_ONE / 3, _ONE], 3: [(4 - root) / 10, (4 + root) / 10, _ONE]}[s]
    )


def _lobatto_nodes(s: int) -> list[Scalar]:
    """Ends and zeros of the derivative of the Legendre polynomial of degree s - 1, on [0, 1]."""
    inner = {
        2: [],
        3: [],
        4: [_root("1/5")],
        5: [_root("3/7")],
        6: [_root((7 + sign * 2 * _root(7)) / 21) for sign in (1, -1)],
    }[s]
    return _symmetric_nodes([_ONE, *inner], middle=s % 2 == 1)


def lobatto_iiia(s: int) -> tuple[Matrix, Vector]:
    """Lobatto IIIA method with s = 2 to 6 stages, of order 2s - 2: collocation."""
    return collocation(_lobatto_nodes(s))


def lobatto_iiib(s: int) -> tuple[Matrix, Vector]:
    """Lobatto IIIB method with s = 2 to 6 stages: ``b_i a_ij + b_j a^A_ji = b_i b_j`` with IIIA."""
    A, b = lobatto_iiia(s)
    return tuple(tuple(b[j] - b[j] * A[j][i] / b[i] for j in range(s)) for i in range(s)), b


def lobatto_iiic(s: int) -> tuple[Matrix, Vector]:
    """Lobatto IIIC method with s = 2 to 6 stages: ``a_i1 = b_1`` and stage order s - 1."""
    c = _lobatto_nodes(s)
    b = lobatto_iiia(s)[1]
    basis = _lagrange(c[1:])
    # the column of c_1 = 0 carries b_1; the others integrate what is left of degree below s - 1
    A = tuple((b[0], *(_integral(p, _ZERO, x) - b[0] * p[0] for p in basis)) for x in c)
    return A, b


def _adams(k: int, nodes: int) -> tuple[Vector, list[Scalar]]:
    basis = _lagrange([exact(m) for m in range(nodes)])
    alpha = (*((_ZERO,) * (k - 1)), exact(-1), _ONE)
    return alpha, [_integral(p, exact(k - 1), exact(k)) for p in basis]


def adams_bashforth(k: int) -> tuple[Vector, Vector]:
    """Adams-Bashforth method with k steps, of order k: (alpha, beta), each (k + 1,)."""
    alpha, beta = _adams(k, k)
    return alpha, (*beta, _ZERO)


def adams_moulton(k: int) -> tuple[Vector, Vector]:
    """Adams-Moulton method with k steps, of order k + 1 (k = 0: implicit Euler): (alpha, beta)."""
    alpha, beta = _adams(k, k + 1)
    return alpha, tuple(beta) if k else (_ZERO, _ONE)


def bdf(k: int) -> tuple[Vector, Vector]:
    """Backward differentiation formula with k steps, of order k, with beta_k = 1: (alpha, beta)."""
    # derivative of the interpolation polynomial at the newest node
    alpha = (
        sum((j * x * k ** (j - 1) for j, x in enumerate(p) if j), _ZERO)
        for p in _lagrange([exact(m) for m in range(k + 1)])
    )
    return tuple(alpha), (*((_ZERO,) * k), _ONE)


def one_leg_twin(alpha: Entries, beta: Entries) -> tuple[Vector, Vector]:
    """One-leg twin of a multistep method: scaled so that ``sum beta_m = 1``."""
    a, b = as_vector(alpha, "alpha"), as_vector(beta, "beta")
    total = sum(b, _ZERO)
    return tuple(x / total for x in a), tuple(x / total for x in b)
