"""Everything theory knows of one method, computed on demand and at most once.

``verify``, ``analyze``, ``show`` and the report read facts here, so that none of them computes a
thing twice and none computes what it was not asked for.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from math import factorial
from typing import TYPE_CHECKING, Any

from ..exact import Scalar
from ..exact.linalg import Vector
from ..findings import Proof
from ..method import GLM, PartitionedGLM
from ..method.stage_order import pair_blocks

if TYPE_CHECKING:
    from ..theory.consistency import Consistency
    from ..theory.order import OrderResult
    from ..theory.parasitism import PairParasitism, Parasitism
    from ..theory.partitioned_symplectic import PairSymplecticity
    from ..theory.reduction import Reduction
    from ..theory.spectrum import Boundedness
    from ..theory.symmetry import PairSymmetry, Symmetry
    from ..theory.symplectic import GSymplecticity
    from .implications import Implied
    from .kernel import Judgement, Kernel

__all__ = ["Facts", "GLMFacts", "PairFacts", "facts_of"]


class Facts:
    """What both kinds of methods have.

    Args:
        method: the method.
        implied: what the enclosure of its file proves, or ``None``.
    """

    def __init__(self, method: Any, *, implied: Implied | None = None) -> None:
        self.method = method
        self.implied = implied

    @cached_property
    def kernel(self) -> Kernel:
        """The rules that give verdicts about this method."""
        from .kernel import Kernel

        return Kernel(self.method, self.implied)

    @property
    def proof(self) -> Proof:
        """What the record as a whole rests on: exact numbers, an enclosure, or published digits."""
        if self.method.is_exact:
            return Proof.EXACT
        return Proof.MEASURED if self.implied is None else Proof.ENCLOSED

    def judge(self, claim: str, declared: object) -> Judgement:
        """Judge one claim: a finder proposes, the kernel decides."""
        from .finders import proposal_for

        return self.kernel.judge(claim, declared, proposal_for(self, claim))

    def truth(self, claim: str) -> bool | None:
        """Whether a claim that is true or false is true, as far as it is proved."""
        from .finders import proposal_for

        return self.kernel.known(claim, proposal_for(self, claim)).truth

    @property
    def is_one_step(self) -> bool:
        """Whether one value (of each component) is carried."""
        raise NotImplementedError

    @property
    def classical_order(self) -> OrderResult:
        """What users call the order.

        For one-step methods the first value is the solution; what they reach with start and finish
        is their effective order. Methods that carry several values come with a starting method,
        whose principal part is free; it is the identity where that costs no order, and the error
        constants are then those of the solution itself.
        """
        same = self.is_one_step or self.order_identity.order == self.order.order
        return self.order_identity if same else self.order

    order: OrderResult
    order_identity: OrderResult
    consistencies: tuple[Consistency, ...]
    zero_stabilities: tuple[Boundedness, ...]
    g_symplecticity: GSymplecticity | PairSymplecticity
    symmetry: Symmetry | PairSymmetry
    parasitism: Parasitism | PairParasitism
    growth_parameters: tuple[Scalar, ...]
    is_explicit: bool


class GLMFacts(Facts):
    """Facts of a general linear method."""

    method: GLM

    @cached_property
    def consistency(self) -> Consistency:
        """u, v, c, and whether the method is pre-consistent and consistent."""
        from ..theory.consistency import consistency

        return consistency(self.method)

    @cached_property
    def zero_stability(self) -> Boundedness:
        """Whether V is power-bounded."""
        from ..theory.consistency import zero_stability

        return zero_stability(self.method)

    @cached_property
    def order(self) -> OrderResult:
        """Order with a free principal part of the starting series."""
        from ..theory.order import order_of

        return order_of(self.method, principal="free")

    @cached_property
    def order_identity(self) -> OrderResult:
        """Order with the identity as principal part: the first value is the solution."""
        from ..theory.order import order_of

        return order_of(self.method, principal="identity")

    @cached_property
    def g_symplecticity(self) -> GSymplecticity:
        """The forms G and D, those the file gives or those found."""
        from ..theory.symplectic import g_symplectic

        return g_symplectic(self.method)

    @cached_property
    def symmetry(self) -> Symmetry:
        """Time-reversal symmetry with its involutions."""
        from ..theory.symmetry import symmetry

        return symmetry(self.method)

    @cached_property
    def parasitism(self) -> Parasitism:
        """Growth parameters at the unimodular eigenvalues of V."""
        from ..theory.parasitism import growth

        return growth(self.method)

    @cached_property
    def starting_order(self) -> tuple[int, str]:
        """Order to which the file's starting method agrees with the starting series, and why."""
        from ..theory.starting import starting_order

        if self.method.starting is None:
            return 0, "the file gives no starting method"
        found = starting_order(self.method, self.method.starting, known=self.order)
        return found.order, found.witness

    @cached_property
    def finishing_order(self) -> tuple[int, str]:
        """Order to which the file's finishing method undoes its starting method, and why."""
        from ..theory.starting import finishing_order

        if self.method.finishing is None:
            return 0, "the file gives no finishing method"
        found = finishing_order(
            self.method, self.method.finishing, starting=self.method.starting, known=self.order
        )
        return found.order, found.witness

    @property
    def is_explicit(self) -> bool:
        """Whether no stage needs an equation solved."""
        return self.method.is_explicit

    @property
    def is_one_step(self) -> bool:
        """Whether one value is carried."""
        return self.method.r == 1

    @property
    def consistencies(self) -> tuple[Consistency, ...]:
        """The consistency record, as a tuple of one."""
        return (self.consistency,)

    @property
    def zero_stabilities(self) -> tuple[Boundedness, ...]:
        """The zero-stability record, as a tuple of one."""
        return (self.zero_stability,)

    @property
    def abscissae(self) -> Vector | None:
        """C = A 1 + U v, or ``None`` for a method that is not consistent."""
        return self.consistency.c

    @property
    def growth_parameters(self) -> tuple[Scalar, ...]:
        """Mu at each unimodular eigenvalue of V but the principal one, by increasing argument."""
        return tuple(g.mu for g in self.parasitism.growths if g.mu is not None)

    @cached_property
    def quadrature_error(self) -> tuple[Scalar, ...] | None:
        """C in ``C h^(p+1) y^(p+1)``, the local error when y' = g(x) is integrated.

        It belongs to the tree with p leaves at the root: symmetry p!, and the exact value minus
        the method's is the negative residual.
        """
        from ..theory.trees import single, tree

        result = self.classical_order
        bushy = tree([single()] * result.order)
        residual = result.residuals.get(bushy)
        if residual is None:
            return None
        return (residual * Fraction(-1, factorial(result.order)),)

    @cached_property
    def a_stability(self) -> Any:
        """Whether M(z) is power-bounded in the left half-plane."""
        from ..theory.a_stability import a_stability

        return a_stability(self.method)

    @cached_property
    def l_stability(self) -> Any:
        """A-stable, and M(z) tends to a nilpotent matrix as z tends to minus infinity."""
        from ..theory.a_stability import l_stability

        return l_stability(self.method)


class PairFacts(Facts):
    """Facts of a partitioned pair."""

    method: PartitionedGLM

    @property
    def max_order(self) -> int:
        """How far trees are compared: for general systems there are 19,000 of order 8 alone."""
        return 9 if self.method.separable else 8

    @cached_property
    def consistency(self) -> tuple[Consistency, Consistency]:
        """Consistency of the q half and the p half."""
        from ..theory.consistency import pair_consistency

        return pair_consistency(self.method)

    @cached_property
    def zero_stability(self) -> tuple[Boundedness, Boundedness]:
        """Whether V and V^ are power-bounded."""
        from ..method.solution_value import halves
        from ..theory.spectrum import power_bounded

        q, p = halves(self.method)
        return power_bounded(q.V), power_bounded(p.V)

    @cached_property
    def order(self) -> OrderResult:
        """Order of both components, principal parts free."""
        from ..theory.partitioned import pair_order_of

        return pair_order_of(self.method, principal="free", max_order=self.max_order)

    @cached_property
    def order_identity(self) -> OrderResult:
        """Order of both components, principal parts the identity."""
        from ..theory.partitioned import pair_order_of

        return pair_order_of(self.method, principal="identity", max_order=self.max_order)

    @cached_property
    def starting_order(self) -> tuple[int, str]:
        """Order to which the start agrees with the starting series, and why.

        It is the starting method of the file, or (y_0, 0, ..) where the file has none.
        """
        return self._start_against(self.order_identity)

    @cached_property
    def nystrom_starting_order(self) -> tuple[int, str]:
        """The same on second-order systems."""
        from ..theory.nystrom import is_nystrom

        return self._start_against(
            self.nystrom_order, counts=is_nystrom, compared="all trees of second-order systems"
        )

    def _start_against(self, known: OrderResult, **options: Any) -> tuple[int, str]:
        from ..theory.partitioned_starting import pair_starting_order, zero_start_order

        if self.method.starting is None:
            return zero_start_order(known)
        found = pair_starting_order(self.method, self.method.starting, known, **options)
        return found.order, found.witness

    @cached_property
    def nystrom_order(self) -> OrderResult:
        """Order of both components on second-order systems, principal parts the identity."""
        from ..theory.nystrom import nystrom_order_of

        return nystrom_order_of(self.method)

    @cached_property
    def reduction(self) -> Reduction:
        """Which of the values carried are needed."""
        from ..theory.reduction import pair_reduction

        return pair_reduction(self.method)

    @cached_property
    def g_symplecticity(self) -> PairSymplecticity:
        """The bilinear form the two halves conserve together."""
        from ..theory.partitioned_symplectic import pair_symplectic

        return pair_symplectic(self.method)

    @cached_property
    def symmetry(self) -> PairSymmetry:
        """Time-reversal symmetry of the pair."""
        from ..theory.symmetry import pair_symmetry

        return pair_symmetry(self.method)

    @cached_property
    def parasitism(self) -> PairParasitism:
        """Coupled growth parameters."""
        from ..theory.parasitism import pair_growth

        return pair_growth(self.method)

    @property
    def is_one_step(self) -> bool:
        """Whether one value of q and one of p is carried."""
        return self.method.r == self.method.r_hat == 1

    @property
    def consistencies(self) -> tuple[Consistency, ...]:
        """Consistency of both halves."""
        return self.consistency

    @property
    def zero_stabilities(self) -> tuple[Boundedness, ...]:
        """Zero-stability of both halves."""
        return self.zero_stability

    @property
    def abscissae(self) -> None:
        """A pair has two sets of abscissae; none is claimed as one."""

    @property
    def growth_parameters(self) -> tuple[Scalar, ...]:
        """mu_q and mu_p at each shared unimodular eigenvalue, by increasing argument."""
        return tuple(
            x for g in self.parasitism.growths for m in (g.mu_q, g.mu_p) for row in m for x in row
        )

    @cached_property
    def is_explicit(self) -> bool:
        """Whether the stages can be put in an order in which each needs earlier ones only."""
        return not any(block.implicit for block in pair_blocks(self.method))


def facts_of(
    method: GLM | PartitionedGLM, *, implied: Implied | None = None
) -> GLMFacts | PairFacts:
    """Facts of either kind of method."""
    kind = PairFacts if isinstance(method, PartitionedGLM) else GLMFacts
    return kind(method, implied=implied)
