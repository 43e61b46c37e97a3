"""Say what a method is when nothing is claimed: the ``glmref-analysis-1`` record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ..catalogue.claims import (
    CONSISTENT,
    EXPLICIT,
    G_SYMPLECTIC,
    ORDER,
    ORDER_IDENTITY,
    PARASITISM_FREE,
    PRECONSISTENT,
    STAGE_ORDER,
    SYMMETRIC,
    ZERO_STABLE,
)
from ..exact import Scalar
from ..exact.expression import shown_number
from ..exact.linalg import Matrix, Vector
from ..findings import Proof
from ..method import GLM, PartitionedGLM
from ..prove.facts import GLMFacts, PairFacts
from ..prove.kernel import Range
from ..system.budget import limited

__all__ = ["FORMAT", "Analysis", "analyze"]

FORMAT = "glmref-analysis-1"


@dataclass(frozen=True)
class Analysis:
    """Facts of one method, JSON-ready. ``None`` stands for what could not be decided.

    Attributes
    ----------
        method: its name. stages, values: s and r (pairs: of both halves).
        order: the order; with ``principal`` = ``"identity"`` the first value is the solution,
            with ``"free"`` a start and a finish belong to the method.
        order_proved: a proved lower and a proved upper bound of it.
        order_identity: order of the first value taken as the solution.
        order_witness: the tree that decides.
        error_constants: residuals at order p + 1 by tree, as floats.
        g_symplectic: ``{"holds", "G", "D"}``. symmetric: ``{"holds", "L", "P"}``.
        growth: ``[{"eigenvalue", "mu"}, ...]``.
        proof: the kind of proof all of this has.
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

    def as_json(self) -> dict[str, Any]:
        """Return the record, with its format, as JSON-ready values."""
        return {"format": FORMAT, **asdict(self), "proof": str(self.proof)}


def analyze(method: GLM | PartitionedGLM, *, budget: float | None = None) -> Analysis:
    """Compute everything there is to know of a method; claims play no part.

    Args:
        method: a GLM or a pair, from a file or made by hand.
        budget: seconds of processor time, no limit by default.

    Raises
    ------
        BudgetError: when they are spent.
    """
    from .verifier import facts_for

    with limited(budget):
        facts = facts_for(method)
        if isinstance(facts, PairFacts):
            return _analyze_pair(facts)
        assert isinstance(facts, GLMFacts)
        return _analyze_glm(facts)


def _shared(facts: GLMFacts | PairFacts) -> dict[str, Any]:
    kernel = facts.kernel
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
        "parasitism_free": facts.truth(PARASITISM_FREE.key),
        "proof": facts.proof,
    }


def _open(order: Range) -> str:
    return f"order {order.lower} is proved"


#: A residual below this may be a rounding; a step of the staircase is a jump by this factor.
SMALL, JUMP = 1e-3, 100.0


def staircase(facts: GLMFacts | PairFacts) -> str:
    """How well a rounded tableau satisfies the conditions beyond its proved order: measured.

    Returns
    -------
        Such as "order 5 to 2e-12, order 3 to 3e-17, order 0 exactly"; ``""`` where no order beyond
        the proved one is nearly reached.
    """
    kernel = facts.kernel
    proved = kernel.range(ORDER.key).lower
    sizes = kernel.nearly(most=proved + 8)
    steps: list[str] = []
    for n in range(len(sizes), proved, -1):
        beyond = sizes[n] if n < len(sizes) else float("inf")
        if 0 < sizes[n - 1] < SMALL and beyond > JUMP * sizes[n - 1]:
            steps.append(f"order {n} to {sizes[n - 1]:.1e}")
    return ", ".join([*steps, f"order {proved} exactly"]) if steps else ""


def _analyze_glm(facts: GLMFacts) -> Analysis:
    form, symmetry = facts.g_symplecticity, facts.symmetry
    held = facts.truth(SYMMETRIC.key)
    return Analysis(
        **_shared(facts),
        stages=facts.method.s,
        values=facts.method.r,
        implicit_stages=list(facts.method.implicit_stages),
        g_symplectic={
            "holds": facts.truth(G_SYMPLECTIC.key),
            "G": _matrix(form.G),
            "D": _vector(form.D),
        },
        symmetric={
            "holds": held,
            "L": _matrix(symmetry.L),
            "P": None if symmetry.P is None else [i + 1 for i in symmetry.P],
        },
        growth=[
            {
                "eigenvalue": shown_number(g.eigenvalue),
                "mu": shown_number(g.mu) if g.mu is not None else _matrix(g.matrix),
            }
            for g in facts.parasitism.growths
        ],
        abscissae=_vector(facts.abscissae),
    )


def _analyze_pair(facts: PairFacts) -> Analysis:
    form, symmetry, pair = facts.g_symplecticity, facts.symmetry, facts.method
    return Analysis(
        **_shared(facts),
        stages=[pair.n_Q, pair.n_P],
        values=[pair.r, pair.r_hat],
        implicit_stages=[],
        g_symplectic={
            "holds": facts.truth(G_SYMPLECTIC.key),
            "G": _matrix(form.G),
            "D": {"D_P": _vector(form.D_P), "D_Q": _vector(form.D_Q)},
        },
        symmetric={
            "holds": facts.truth(SYMMETRIC.key),
            "L": _matrix(symmetry.L),
            "L_hat": _matrix(symmetry.L_hat),
            "P": [_stages(symmetry.P_P), _stages(symmetry.P_Q)],
        },
        growth=[
            {
                "eigenvalue": shown_number(g.eigenvalue),
                "mu_q": _matrix(g.mu_q),
                "mu_p": _matrix(g.mu_p),
            }
            for g in facts.parasitism.growths
        ],
        abscissae=None,
    )


def _real(x: Scalar) -> float:
    return complex(x).real


def _vector(values: Vector | None) -> list[str] | None:
    return None if values is None else [shown_number(x) for x in values]


def _matrix(rows: Matrix | None) -> list[list[str]] | None:
    return None if rows is None else [[shown_number(x) for x in row] for row in rows]


def _stages(order: Sequence[int] | None) -> list[int] | None:
    return None if order is None else [i + 1 for i in order]
