"""Classical Runge-Kutta and multistep methods, derived exactly from their nodes.

Runge-Kutta families as (A, b), with nodes in closed form by square roots; Adams methods and
backward differentiation as (alpha, beta), rational. Nothing is typed in but the nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from ..errors import DataError, UsageError
from ..exact import Exact, Scalar, exact
from ..exact.linalg import Matrix, Vector
from .entries import as_vector

Entry = str | int | Fraction | Scalar
_ZERO, _ONE = Exact(0), Exact(1)


def _lagrange(nodes: Sequence[Scalar]) -> list[list[Scalar]]:
    """Coefficients (constant first) of the Lagrange basis polynomials of the nodes."""
    basis: list[list[Scalar]] = []
    for j, node in enumerate(nodes):
        p: list[Scalar] = [_ONE]
        for k, other in enumerate(nodes):
            if k == j:
                continue
            difference = node - other
            if difference.is_zero() is not False:
                raise DataError(f"the nodes {min(j, k) + 1} and {max(j, k) + 1} coincide")
            shifted = [_ZERO, *p]
            p = [(x - other * y) / difference for x, y in zip(shifted, [*p, _ZERO], strict=True)]
        basis.append(p)
    return basis


def _integral(p: Sequence[Scalar], low: Scalar, high: Scalar) -> Scalar:
    total: Scalar = _ZERO
    upper, lower = high, low
    for k, x in enumerate(p):
        total = total + x * (upper - lower) * Fraction(1, k + 1)
        upper, lower = upper * high, lower * low
    return total


def collocation(c: Sequence[Entry]) -> tuple[Matrix, Vector]:
    """Collocation Runge-Kutta method with nodes c: ``a_ij`` integrates l_j to c_i, ``b_j`` to 1.

    Returns
    -------
    tuple[Matrix, Vector]
        A (s, s) and b (s,).

    Raises
    ------
    DataError
        When two nodes coincide.

    References: Hairer, Nørsett and Wanner (1993), section II.7, Theorem 7.7.
    """
    c = as_vector(c, "c")
    basis = _lagrange(c)
    A = tuple(tuple(_integral(p, _ZERO, x) for p in basis) for x in c)
    return A, tuple(_integral(p, _ZERO, _ONE) for p in basis)


def _sqrt(value: int | Fraction | Scalar) -> Scalar:
    return (exact(value) if isinstance(value, int | Fraction) else value).sqrt()


def _symmetric_nodes(positive: Sequence[Scalar], *, middle: bool) -> list[Scalar]:
    """Nodes (1 + x)/2 on [0, 1] of the zeros -x, .., x; the positive half is given, descending."""
    zeros = [-x for x in positive] + ([_ZERO] if middle else []) + list(reversed(positive))
    return [(x + 1) * Fraction(1, 2) for x in zeros]


def _choose(table: Mapping[int, Callable[[], list[Scalar]]], s: int, family: str) -> list[Scalar]:
    if s not in table:
        raise UsageError(
            f"{family} methods are given in closed form for s = {min(table)} to {max(table)} "
            f"stages, got {s}"
        )
    return table[s]()


def _gauss_nodes(s: int) -> list[Scalar]:
    """Zeros of the shifted Legendre polynomial of degree s, by nested square roots."""
    f = Fraction
    return _choose(
        {
            1: lambda: _symmetric_nodes([], middle=True),
            2: lambda: _symmetric_nodes([_sqrt(f(1, 3))], middle=False),
            3: lambda: _symmetric_nodes([_sqrt(f(3, 5))], middle=True),
            4: lambda: _symmetric_nodes(
                [_sqrt(f(3, 7) + sign * f(2, 7) * _sqrt(f(6, 5))) for sign in (1, -1)], middle=False
            ),
            5: lambda: _symmetric_nodes(
                [_sqrt(5 + sign * 2 * _sqrt(f(10, 7))) * f(1, 3) for sign in (1, -1)], middle=True
            ),
        },
        s,
        "Gauss",
    )


def gauss(s: int) -> tuple[Matrix, Vector]:
    """Gauss method with s = 1 to 5 stages, of order 2s: (A, b) over nested square roots.

    References: Butcher, Math. Comp. 18 (1964) 50; Hairer, Nørsett and Wanner (1993), section II.7.
    """
    return collocation(_gauss_nodes(s))


def radau_iia(s: int) -> tuple[Matrix, Vector]:
    """Radau IIA method with s = 1, 2 or 3 stages, of order 2s - 1 (s = 4 needs a cubic).

    References: Ehle (1969); Hairer, Nørsett and Wanner (1996), section IV.5.
    """
    f = Fraction
    nodes = {
        1: lambda: [_ONE],
        2: lambda: [exact(f(1, 3)), _ONE],
        3: lambda: [(4 - _sqrt(6)) * f(1, 10), (4 + _sqrt(6)) * f(1, 10), _ONE],
    }
    return collocation(_choose(nodes, s, "Radau IIA"))  # type: ignore[arg-type]


def _lobatto_nodes(s: int) -> list[Scalar]:
    """Ends and zeros of the derivative of the Legendre polynomial of degree s - 1, on [0, 1]."""
    f = Fraction
    return _choose(
        {
            2: lambda: _symmetric_nodes([_ONE], middle=False),
            3: lambda: _symmetric_nodes([_ONE], middle=True),
            4: lambda: _symmetric_nodes([_ONE, _sqrt(f(1, 5))], middle=False),
            5: lambda: _symmetric_nodes([_ONE, _sqrt(f(3, 7))], middle=True),
            6: lambda: _symmetric_nodes(
                [_ONE, *(_sqrt((7 + sign * 2 * _sqrt(7)) * f(1, 21)) for sign in (1, -1))],
                middle=False,
            ),
        },
        s,
        "Lobatto",
    )


def lobatto_iiia(s: int) -> tuple[Matrix, Vector]:
    """Lobatto IIIA method with s = 2 to 6 stages, of order 2s - 2: collocation.

    References: Ehle (1969); Hairer, Nørsett and Wanner (1996), section IV.5.
    """
    return collocation(_lobatto_nodes(s))


def lobatto_iiib(s: int) -> tuple[Matrix, Vector]:
    """Lobatto IIIB method with s = 2 to 6 stages: ``b_i a_ij + b_j a^A_ji = b_i b_j`` with IIIA.

    References: Ehle (1969); Hairer, Lubich and Wanner (2006), section IV.2.2 and Theorem VI.4.6.
    """
    A, b = lobatto_iiia(s)
    return tuple(tuple(b[j] - b[j] * A[j][i] / b[i] for j in range(s)) for i in range(s)), b


def lobatto_iiic(s: int) -> tuple[Matrix, Vector]:
    """Lobatto IIIC method with s = 2 to 6 stages: ``a_i1 = b_1`` and stage order s - 1.

    References: Chipman, BIT 11 (1971) 384; Hairer, Nørsett and Wanner (1996), section IV.5.
    """
    c = _lobatto_nodes(s)
    b = lobatto_iiia(s)[1]
    basis = _lagrange(c[1:])
    # the column of c_1 = 0 carries b_1; the others integrate what is left of degree below s - 1
    A = tuple((b[0], *(_integral(p, _ZERO, x) - b[0] * p[0] for p in basis)) for x in c)
    return A, b


def _steps(k: int, least: int, most: int, family: str) -> None:
    if not least <= k <= most:
        raise UsageError(f"{family} methods have k = {least} to {most} steps here, got {k}")


def adams_bashforth(k: int) -> tuple[Vector, Vector]:
    """Adams-Bashforth method with k steps, of order k: (alpha, beta), each (k + 1,).

    References: Bashforth and Adams (1883); Hairer, Nørsett and Wanner (1993), section III.1, (1.5).
    """
    _steps(k, 1, 20, "Adams-Bashforth")
    nodes = [exact(m) for m in range(k)]
    beta = [_integral(p, exact(k - 1), exact(k)) for p in _lagrange(nodes)]
    return (*((_ZERO,) * (k - 1)), exact(-1), _ONE), (*beta, _ZERO)


def adams_moulton(k: int) -> tuple[Vector, Vector]:
    """Adams-Moulton method with k steps, of order k + 1 (k = 0: implicit Euler): (alpha, beta).

    References: Hairer, Nørsett and Wanner (1993), section III.1, (1.9).
    """
    _steps(k, 0, 20, "Adams-Moulton")
    if k == 0:
        return (exact(-1), _ONE), (_ZERO, _ONE)
    nodes = [exact(m) for m in range(k + 1)]
    beta = [_integral(p, exact(k - 1), exact(k)) for p in _lagrange(nodes)]
    return (*((_ZERO,) * (k - 1)), exact(-1), _ONE), tuple(beta)


def bdf(k: int) -> tuple[Vector, Vector]:
    """Backward differentiation formula with k steps, of order k, with beta_k = 1: (alpha, beta).

    Zero-stable for k up to 6 only.

    References: Curtiss and Hirschfelder (1952); Hairer, Nørsett and Wanner (1993), section III.1.
    """
    _steps(k, 1, 20, "backward differentiation")
    nodes = [exact(m) for m in range(k + 1)]
    alpha = []
    for p in _lagrange(nodes):  # derivative of the interpolation polynomial at the newest node
        slope = sum((j * x * k ** (j - 1) for j, x in enumerate(p) if j), _ZERO)
        alpha.append(slope)
    return tuple(alpha), (*((_ZERO,) * k), _ONE)
