"""Families of methods as general linear methods: their matrices are those that the judge has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..errors import DataError
from ..exact import Exact
from ..exact.linalg import Vector
from ..judge import families
from ..system.arguments import one_of
from .embedded import EmbeddedRow
from .entries import Entries, Rows, as_matrix, as_vector
from .glm import GLM, PartitionedGLM

_ZERO = Exact(0)


def runge_kutta(A: Rows, b: Entries, name: str = "", *, embedded: Any = None) -> GLM:
    """Return the Runge-Kutta method as the GLM with r = 1, U = 1, V = 1.

    Parameters
    ----------
    A, b : Rows and Entries
        (s, s) and (s,).
    embedded : Entries or mapping or sequence, optional
        Weights (s,) of a further solution, which estimates errors; or several by their names.

    Raises
    ------
    DataError
        For a wrong shape or an entry that cannot be read.

    References: Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section
    502.
    """
    A, b = as_matrix(A, "A"), as_vector(b, "b")
    _check_length("b", b, len(A))
    rows = {} if embedded is None else embedded
    rows = rows if isinstance(rows, Mapping) else {"embedded": rows}
    return GLM(
        *families.runge_kutta(A, b), name=name,
        embedded=tuple(
            EmbeddedRow(str(k), (as_vector(row, f"embedded {k}"),)) for k, row in rows.items()
        ),
    )  # fmt: skip


def _check_length(letter: str, values: Sequence[object], size: int) -> None:
    if len(values) != size:
        raise DataError(
            f"`{letter}` must have {size} entries, one for each stage, got {len(values)}"
        )


def _multistep(alpha: Entries, beta: Entries) -> tuple[Vector, Vector]:
    """Check the coefficients of a multistep method and divide by ``alpha_k``."""
    alpha, beta = as_vector(alpha, "alpha"), as_vector(beta, "beta")
    if len(alpha) != len(beta) or len(alpha) < 2:
        raise DataError(
            f"`alpha` and `beta` must both have k + 1 entries, k at least 1, "
            f"got {len(alpha)} and {len(beta)}"
        )
    lead = alpha[-1]
    if lead.is_zero() is not False:
        raise DataError(
            f"`alpha[{len(alpha)}]` must not be zero: it multiplies the new value, and alpha[1] "
            f"the oldest"
        )
    if all(x.is_zero() is True for x in beta):
        raise DataError("`beta` must have an entry other than zero")
    if not _is_consistent(alpha, beta) and _is_consistent(alpha[::-1], beta[::-1]):
        raise DataError(
            "`alpha` and `beta` are consistent in reversed order only: alpha[1] and beta[1] belong "
            "to the oldest value, the last entries to the new one; turn both round"
        )
    # a ball is true even where it is zero, and zeros decide which values are carried
    a, b = (tuple(_ZERO if x.vanishes() else x / lead for x in row) for row in (alpha, beta))
    return a, b


def _is_consistent(alpha: Vector, beta: Vector) -> bool:
    """Return whether rho(1) = 0 and rho'(1) = sigma(1) for certain."""
    slope = sum((m * x for m, x in enumerate(alpha)), _ZERO)
    gaps = (sum(alpha, _ZERO), slope - sum(beta, _ZERO))
    return all(x.is_zero() is True for x in gaps)


def linear_multistep(alpha: Entries, beta: Entries, name: str = "") -> GLM:
    """Make the multistep method ``sum alpha_m y_(n+m) = h sum beta_m f_(n+m)`` a GLM with s = 1.

    The values carried are ``y_(n+k-1), y_(n+k-2), ..`` as far back as alpha reaches, then ``h f``
    as far back as beta reaches. An implicit method has the stage ``Y = y_(n+k)`` and carries
    ``h f_(n+k-1), ..``; an explicit one has the stage ``Y = y_(n+k-1)`` (A = 0), so that its newest
    derivative is the one evaluated and ``h f_(n+k-2), ..`` are carried. Either way f is evaluated
    once in a step, and u is 1 on the y values and 0 on the h f values.

    Parameters
    ----------
    alpha, beta : Entries
        (k + 1,), index m multiplies y_(n+m) and f_(n+m).

    Raises
    ------
    DataError
        For unequal lengths or alpha_k = 0.

    References: Butcher (2016), section 502; Burrage and Butcher, BIT 20 (1980) 185.
    """
    a, b = _multistep(alpha, beta)
    return GLM(*families.linear_multistep(a, b), name=name, multistep=(a, b))


def one_leg(alpha: Entries, beta: Entries, name: str = "") -> GLM:
    """Make ``sum alpha_m y_(n+m) = h f(sum beta_m y_(n+m))`` a GLM with s = 1, r = k.

    The values carried are ``y_(n+k-1), .., y_n``. Consistency asks for ``sum beta_m = 1``:
    :func:`one_leg_twin` scales a multistep method to that.

    Raises
    ------
    DataError
        For unequal lengths or alpha_k = 0.

    References: Dahlquist, Lecture Notes in Mathematics 506 (1976) 60; Hairer, Nørsett and Wanner,
    "Solving Ordinary Differential Equations II" (1996), section V.6.
    """
    a, _ = _multistep(alpha, beta)
    leg, lead = as_vector(beta, "beta"), as_vector(alpha, "alpha")[-1]
    return GLM(*families.one_leg(a, leg, 1 / lead), name=name)


def partitioned_runge_kutta(
    A: Rows,
    b: Entries,
    A_hat: Rows,
    b_hat: Entries,
    name: str = "",
) -> PartitionedGLM:
    """Return a pair of Runge-Kutta methods: (A, b) for q acts on f, (A_hat, b_hat) for p acts on k.

    Raises
    ------
    DataError
        For a wrong shape or an entry that cannot be read.

    References: Hairer, Lubich and Wanner, "Geometric Numerical Integration" (2006), section II.2.1.
    """
    q, p = runge_kutta(A, b), runge_kutta(A_hat, b_hat)
    _check_length("b_hat", p.B[0], q.s)
    return PartitionedGLM(q.A, q.U, q.B, q.V, p.A, p.U, p.B, p.V, name=name)


def splitting(a: Entries, b: Entries, first: str = "q", name: str = "") -> PartitionedGLM:
    """Return the splitting ``q += a_i h f(p)``, ``p += b_j h k(q)`` in turn, as a pair.

    Parameters
    ----------
    a : Entries
        Weights of the updates of q, one stage P each.
    b : Entries
        Weights of the updates of p, one stage Q each.
    first : str
        ``"q"`` or ``"p"``, the variable that is updated first.

    Raises
    ------
    DataError
        When the numbers of weights do not alternate.

    References: Hairer, Lubich and Wanner (2006), section II.5.
    """
    a, b = as_vector(a, "a"), as_vector(b, "b")
    one_of("first", first, ("q", "p"), DataError)
    leading, following = (a, b) if first == "q" else (b, a)
    if len(leading) - len(following) not in (0, 1):
        raise DataError(
            f"updates must alternate beginning with {first!r}, but `a` has {len(a)} entries and "
            f"`b` has {len(b)}; `{'a' if first == 'q' else 'b'}` needs as many as the other or one "
            f"more"
        )
    q, p = families.splitting(a, b, first)
    return PartitionedGLM(*q, *p, separable=True, name=name)


def composition(base: GLM, gamma: Entries, name: str = "") -> GLM:
    """Compose a one-step method with itself, with steps ``gamma_1 h, gamma_2 h, ..``.

    Parameters
    ----------
    base : GLM
        A method with r = 1 and V = 1, such as a Runge-Kutta method.
    gamma : Entries
        Fractions of h, the first one applied first.

    Raises
    ------
    DataError
        When the base carries more than one value.

    References: Yoshida, Phys. Lett. A 150 (1990) 262; Hairer, Lubich and Wanner (2006), V.3.
    """
    gamma = as_vector(gamma, "gamma")
    if base.r != 1:
        raise DataError(f"only a one-step method can be composed, and the base has r = {base.r}")
    return GLM(*families.composition(base.A, base.B[0], gamma), name=name)
