"""Say what a method is when nothing is claimed: the ``glmref-analysis-1`` record."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from ..catalogue.claims import (
    A_STABLE,
    CONSISTENT,
    DENSE_ORDER,
    EXPLICIT,
    G_SYMPLECTIC,
    L_STABLE,
    NYSTROM_ORDER,
    ORDER,
    ORDER_IDENTITY,
    PARASITISM_FREE,
    PRECONSISTENT,
    STAGE_ORDER,
    SYMMETRIC,
    W_ORDER,
    ZERO_STABLE,
)
from ..catalogue.lookup import method_of, path_of
from ..errors import BudgetError, ExactnessError
from ..exact import Scalar, linalg
from ..exact.expression import shown_number
from ..exact.linalg import Matrix, Vector
from ..findings import Proof
from ..method import Method
from ..system.budget import limited
from ..system.shown import Shown
from ..theory.error_constants import error_norm
from ..theory.order import order_of
from ..theory.periodicity import periodicity
from ..theory.stability_interval import imaginary_interval, real_interval
from .digits import rounded_up
from .facts import Facts
from .kernel import SMALL, Kernel
from .ranges import Range
from .verifier import budget_of, facts_for

FORMAT = "glmref-analysis-1"


@dataclass(frozen=True, repr=False)
class Analysis(Shown):
    """Facts of one method, JSON-ready. ``None`` stands for what could not be decided.

    Attributes
    ----------
    method : str
        Its name.
    stages, values : int or list[int]
        s and r (pairs: of both halves).
    order : int
        The order; with ``principal`` = ``"identity"`` the first value is the solution, with
        ``"free"`` a start and a finish belong to the method.
    order_proved : list[int or None]
        A proved lower and a proved upper bound of it.
    order_identity : int
        Order of the first value taken as the solution.
    order_witness : str
        The tree that decides.
    order_nystrom : int or None
        Of a pair, the order on q' = M^-1 p, p' = k(q).
    consistency_witness : str
        Which row of V u = u, U u = 1 or B 1 + V v = u + v is off.
    error_constants : dict[str, float]
        Residuals at order p + 1 by tree, as floats: what the method gives less the elementary
        weight of the solution.
    error_norm : float
        Euclidean norm of residual / symmetry over these trees (Hairer, Norsett, Wanner 1993,
        section II.1).
    order_parts : list[int] or None
        Of an additive method, the order of each part for y' = f_c(t, y) alone.
    order_embedded : dict[str, int] or None
        Orders of the embedded rows by name.
    order_dense : int or None
        Order of the dense output.
    order_w : int or None
        Of a Rosenbrock method, the order with any matrix in the place of the Jacobian.
    quadrature_constant : float or None
        C in the local error C h^(p+1) y^(p+1) when y' = g(t) is integrated.
    stability : dict[str, Any]
        ``A``, ``L``: whether A- and L-stable. ``real``, ``imaginary``: length of the interval [-x,
        0] and of [0, iy] on which no eigenvalue of M(z) leaves the closed unit disc.
        ``periodicity``: largest y below which all are simple and of modulus one; of a pair on the
        oscillator. ``math.inf`` for a whole half-axis.
    g_symplectic : dict[str, Any]
        ``{"holds", "G", "D"}``.
    symmetric : dict[str, Any]
        ``{"holds", "L", "P"}``.
    growth : list[dict[str, Any]]
        ``[{"eigenvalue", "mu"}, ...]``.
    proof : Proof
        The kind of proof all of this has.
    """

    method: str
    stages: int | list[int]
    values: int | list[int]
    explicit: bool
    implicit_stages: list[int]
    preconsistent: bool | None
    consistent: bool | None
    zero_stable: bool | None
    order: int
    order_proved: list[int | None]
    principal: str
    order_identity: int
    stage_order: int
    order_witness: str
    error_constants: dict[str, float]
    g_symplectic: dict[str, Any]
    symmetric: dict[str, Any]
    growth: list[dict[str, Any]]
    parasitism_free: bool | None
    abscissae: list[str] | None
    proof: Proof
    stability: dict[str, Any]
    order_nystrom: int | None
    consistency_witness: str
    error_norm: float
    quadrature_constant: float | None
    order_parts: list[int] | None = None
    order_embedded: dict[str, int] | None = None
    order_dense: int | None = None
    order_w: int | None = None

    def __repr__(self) -> str:
        return f"<Analysis {self.method or '(unnamed)'}: order {self.order}, {self.proof}>"

    def as_json(self) -> dict[str, Any]:
        """Return the record, with its format, as JSON-ready values."""
        found = {"format": FORMAT, **asdict(self), "proof": str(self.proof)}
        found["stability"] = plain_ends(self.stability)
        for key in ("order_parts", "order_embedded", "order_dense", "order_w"):
            if found[key] is None:  # of methods that have such parts only
                del found[key]
        return found


def plain_ends(stability: Mapping[str, Any]) -> dict[str, Any]:
    """Ends of stability intervals as JSON has them: a whole half-axis is ``"infinity"``."""
    return {key: "infinity" if x == math.inf else x for key, x in stability.items()}


def analyze(method: Method | str | Path, *, budget: float | None = None) -> Analysis:
    """Compute everything there is to know of a method; claims play no part.

    Parameters
    ----------
    method : Method or str or Path
        A GLM or a pair, from a file or made by hand; its name or its file.
    budget : float or None
        Seconds of processor time; by default 60 for a file of the user, no limit else.

    Raises
    ------
    BudgetError
        When they are spent.
    UsageError, DataError
        For a name or a file that cannot be read.
    """
    if isinstance(method, str | Path):
        budget = budget_of(path_of(method), budget)
    method = method_of(method)
    with limited(budget):
        return _analyzed(facts_for(method))


def _shared(facts: Facts) -> dict[str, Any]:
    kernel, m = facts.kernel, facts.method
    order, identity = kernel.range(ORDER.key), kernel.range(ORDER_IDENTITY.key)
    same = order.value == identity.value or facts.is_one_step
    stages = kernel.range(STAGE_ORDER.key)
    constants = facts.classical_order.residuals
    settled = order.lower == order.upper
    return {
        "method": facts.method.name,
        "explicit": facts.truth(EXPLICIT.key) is True,
        "preconsistent": facts.truth(PRECONSISTENT.key),
        "consistent": facts.truth(CONSISTENT.key),
        "zero_stable": facts.truth(ZERO_STABLE.key),
        "order": order.value,
        "order_proved": [order.lower, order.upper],
        "principal": "identity" if same else "free",
        "order_identity": identity.value,
        "stage_order": stages.value,
        "order_witness": "; ".join(
            x for x in (staircase(facts), "" if settled else _open(order), order.sentence) if x
        ),
        "error_constants": {str(t): _real(x) for t, x in constants.items()},
        "parasitism_free": None if m.additive else facts.truth(PARASITISM_FREE.key),
        "proof": facts.proof,
        "consistency_witness": "; ".join(
            dict.fromkeys(x.witness for x in facts.consistencies if x.witness)
        ),
        "error_norm": error_norm(facts.classical_order),
        "order_embedded": _row_orders(kernel),
    }


def _row_orders(kernel: Kernel) -> dict[str, int] | None:
    """Orders of the embedded rows by name; ``None`` without rows, or without the u they need."""
    try:
        return {name: x.range(kernel.row_claim).value for name, x in kernel.row_kernels} or None
    except ExactnessError:
        return None


def _stability(facts: Facts) -> dict[str, Any]:
    """A- and L-stability and the intervals of a single method or of one that is one if linear."""
    return {
        "A": _decided(lambda: facts.truth(A_STABLE.key)),
        "L": _decided(lambda: facts.truth(L_STABLE.key)),
        "real": _decided(lambda: real_interval(facts.linear).end),
        "imaginary": _decided(lambda: imaginary_interval(facts.linear).end),
    }


def _decided(what: Callable[[], Any]) -> Any:
    """The answer to a question of stability; ``None`` where it takes longer than is worth it."""
    try:
        with limited(STABILITY):
            return what()
    except (BudgetError, ExactnessError):
        return None


def _open(order: Range) -> str:
    return f"order {order.lower} is proved"


#: Seconds of processor time for each question of stability.
STABILITY = 2.0
#: A step of the staircase is a jump of the residuals by this factor.
JUMP = 100.0


def staircase(facts: Facts) -> str:
    """How well a rounded tableau satisfies the conditions beyond its proved order.

    Rational numbers of methods that carry one value are evaluated with a bound of all roundings,
    each row of weights for itself and Nystrom methods on second-order systems; the sizes, rounded
    up, are those that a claim ``order-to-digits`` states. Others are measured.

    Returns
    -------
    str
        Such as "order 5 to 2.1e-12, order 3 to 3.2e-17, order 0 exactly"; ``""`` where no order
        beyond the proved one is nearly reached.
    """
    kernel = facts.kernel
    proved = kernel.range(kernel.row_claim).lower
    try:
        sizes = kernel.sizes_to_digits() if facts.kernel.exact else {}
    except ExactnessError:
        sizes = {}
    if not sizes:
        # residuals beyond the range of doubles are infinite, and are as large as any
        near = (x if x < math.inf else sys.float_info.max for x in kernel.nearly())
        return _steps([Fraction(0), *(Fraction(repr(x)) for x in near)], proved)
    lower = {name: x.range(kernel.row_claim).lower for name, x in kernel.row_kernels}
    said = {name: _steps(x, lower.get(name, proved)) for name, x in sizes.items()}
    named = [f"row {name}: {x}" if len(said) > 1 else x for name, x in said.items() if x]
    where = "on second-order systems " if kernel.row_claim == NYSTROM_ORDER.key and named else ""
    return where + "; ".join(named)


def _steps(sizes: Sequence[Fraction], proved: int) -> str:
    """Orders beyond the proved one, each with the largest residual through it, rounded up."""
    steps: list[str] = []
    for n in range(len(sizes) - 2, proved, -1):  # of the last one nothing beyond is known
        if 0 < sizes[n] < SMALL and sizes[n + 1] > JUMP * sizes[n]:
            steps.append(f"order {n} to {rounded_up(sizes[n])}")
    return ", ".join([*steps, f"order {proved} exactly"]) if steps else ""


def _analyzed_sum(facts: Facts) -> Analysis:
    """An additive method: the whole by trees in the colours of its parts, and each part alone."""
    m = facts.method
    nothing = {"holds": None}
    return Analysis(
        **_shared(facts),
        stages=len(m.b) if m.rosenbrock else m.s,
        values=m.r,
        implicit_stages=[i for i, row in enumerate(m.gamma, 1) if row[i - 1].is_zero() is not True]
        if m.rosenbrock
        else list(m.implicit_stages),
        g_symplectic={**nothing, "G": None, "D": None},
        symmetric={**nothing, "L": None, "P": None},
        growth=[],
        abscissae=None,
        stability=_stability(facts) if m.rosenbrock else {},
        order_nystrom=None,
        quadrature_constant=None,
        order_w=facts.kernel.range(W_ORDER.key).value if m.rosenbrock else None,
        order_parts=None
        if m.rosenbrock
        else [order_of(m.part(n), principal="identity").order for n in range(1, m.k + 1)],
    )


def _analyzed(facts: Facts) -> Analysis:
    if facts.method.additive:
        return _analyzed_sum(facts)
    form, symmetry, m = facts.g_symplecticity, facts.symmetry, facts.method
    single = facts.is_single
    stages, values = [len(c.A) for c in m.components], [len(c.V) for c in m.components]
    held = {"holds": facts.truth(SYMMETRIC.key), "L": _matrix(symmetry.L)}
    if not single:
        held["L_hat"] = _matrix(symmetry.L_hat)
    return Analysis(
        **_shared(facts),
        stages=stages[0] if single else stages,
        values=values[0] if single else values,
        implicit_stages=list(m.implicit_stages) if single else [],
        g_symplectic={
            "holds": facts.truth(G_SYMPLECTIC.key),
            "G": _matrix(form.G),
            "D": _vector(form.D)
            if single
            else {"D_P": _vector(form.D_P), "D_Q": _vector(form.D_Q)},
        },
        symmetric=held
        | {"P": _stages(symmetry.P) if single else [_stages(symmetry.P_P), _stages(symmetry.P_Q)]},
        growth=[
            {"eigenvalue": shown_number(g.eigenvalue)}
            | (
                {"mu": shown_number(g.mu) if g.mu is not None else _matrix(g.matrix)}
                if single
                else {"mu_q": _matrix(g.mu_q), "mu_p": _matrix(g.mu_p)}
            )
            for g in facts.parasitism.growths
        ],
        abscissae=_vector(facts.abscissae),
        stability={"periodicity": _decided(lambda: _periodicity(facts))}
        if not single
        else {**_stability(facts), "periodicity": _decided(lambda: _periodicity(facts))},
        order_nystrom=facts.kernel.range(NYSTROM_ORDER.key).value
        if not single and (not m.shared or (m.document or {}).get("class") == "nystrom")
        else None,
        quadrature_constant=_quadrature(facts) if single else None,
        order_dense=facts.kernel.range(DENSE_ORDER.key).value
        if single and m.dense is not None
        else None,
    )


def _periodicity(facts: Facts) -> float | None:
    """The periodicity interval; over published digits, that a form is conserved is proved apart."""
    method = facts.method
    conserving = False
    if not method.is_exact and facts.truth(G_SYMPLECTIC.key) and method.G is not None:
        try:
            linalg.inverse(method.G)
            conserving = True
        except ExactnessError:
            pass
    return periodicity(method, conserving=conserving).value


def _quadrature(facts: Facts) -> float | None:
    found = facts.quadrature_error
    return None if found is None else _real(found[0])


def _real(x: Scalar) -> float:
    return complex(x).real


def _vector(values: Vector | None) -> list[str] | None:
    return None if values is None else [shown_number(x) for x in values]


def _matrix(rows: Matrix | None) -> list[list[str]] | None:
    return None if rows is None else [[shown_number(x) for x in row] for row in rows]


def _stages(order: Sequence[int] | None) -> list[int] | None:
    return None if order is None else [i + 1 for i in order]
