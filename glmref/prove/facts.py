"""Everything theory knows of one method, computed on demand and at most once.

``verify``, ``analyze``, ``show`` and the report read facts here, so that none of them computes a
thing twice and none computes what it was not asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from math import factorial
from typing import TYPE_CHECKING, Any

from ..catalogue.claims import CLAIMS, CONSISTENT, G_SYMPLECTIC, ORDER, ORDER_IDENTITY
from ..errors import ExactnessError
from ..exact import Scalar, linalg
from ..exact.linalg import Vector
from ..findings import Proof, Verdict
from ..judge.claims import concerns
from ..method import Method
from ..method.digits import within_digits
from ..theory.consistency import consistency
from ..theory.equivalence import reduce
from ..theory.parasitism import growth
from ..theory.reduction import reduction
from ..theory.spectrum import power_bounded, unimodular_eigenvalues
from ..theory.symmetry import symmetry
from ..theory.symplectic import g_symplectic
from ..theory.trees import Tree, single, tree
from .beside import BESIDE, known_beside
from .certificate import Shared, certificates_of
from .finders import proposal_for
from .kernel import Found, Kernel
from .ranges import Known
from .verdicts import Judgement, explained, judged

if TYPE_CHECKING:
    from ..theory.consistency import Consistency
    from ..theory.parasitism import Parasitism
    from ..theory.reduction import Reduction
    from ..theory.spectrum import Boundedness
    from ..theory.symmetry import Symmetry
    from ..theory.symplectic import GSymplecticity
    from .implications import Implied


class Facts:
    """Facts of one method.

    Parameters
    ----------
    method : Any
        The method.
    implied : Implied or None
        What the enclosure of its file proves, or ``None``.
    """

    def __init__(self, method: Any, *, implied: Implied | None = None) -> None:
        self.method = method
        self.implied = implied

    @cached_property
    def kernel(self) -> Kernel:
        """The rules that give verdicts about this method."""
        return Kernel(self.method, self.implied, self.shared.judged)

    @cached_property
    def nominal(self) -> Facts:
        """The facts that orders are taken from: of rounded decimals those within their digits."""
        rounded = within_digits(self.method) if self.method.is_exact else None
        if rounded is None:
            return self
        near, claim = facts_of(rounded), self.kernel.row_claim
        return near if near.kernel.range(claim).value > self.kernel.range(claim).value else self

    @property
    def proof(self) -> Proof:
        """What the record as a whole rests on: exact numbers, an enclosure, or published digits."""
        if self.method.is_exact:
            return Proof.EXACT
        return Proof.MEASURED if self.implied is None else Proof.ENCLOSED

    def find(self, claim: str, declared: object) -> Found:
        """Find whether an order is the one declared: a proposal to the judge."""
        return self.kernel.find(claim, declared)

    def judge(self, claim: str, declared: object) -> Judgement:
        """Judge one claim: certificates are proposed, and the judge decides."""
        if CLAIMS[claim].type in (int, dict):
            found = self.find(claim, declared)
            if found.truth is None:
                return judged(found, [""])
            return judged(found, certificates_of(self, claim, declared, found))
        answer = self._either_way(claim, declared, first=True)
        if answer.verdict is Verdict.OPEN:
            return answer
        truth = (answer.verdict is Verdict.HOLDS) == (declared is not False)
        return explained(answer, *proposal_for(self, claim).explain(truth, answer.certificate))

    def _either_way(self, claim: str, declared: object, first: bool) -> Judgement:
        """Ask the judge whether what is declared holds or fails: the other where it refuses one."""
        proof = Proof.EXACT if self._is_exact(claim) else Proof.ENCLOSED
        proposal, answers = proposal_for(self, claim), {}
        for holds in (first, not first):
            value = declared == holds if isinstance(declared, bool) else proposal.value
            found = Found(holds, proof, value, 0.0, "")
            answers[holds] = judged(found, certificates_of(self, claim, declared, found))
            if answers[holds].verdict is not Verdict.OPEN:
                return answers[holds]
        # why not, and why not the contrary
        reasons = dict.fromkeys(answers[holds].reason for holds in (True, False))
        return explained(answers[True], "; ".join(reasons), 0.0)

    @cached_property
    def shared(self) -> Shared:
        """What the certificates about the method share."""
        return Shared(self)

    def _is_exact(self, claim: str) -> bool:
        """Tell whether a claim that is true or false is about exact numbers."""
        G, diagonals = self.method.G, self.method.diagonals
        if claim == G_SYMPLECTIC.key and G is not None:
            given = [d for d in diagonals if d is not None]
            return self.kernel.exact and linalg.is_exact(G, given)
        return self.kernel.exact and (claim not in BESIDE or known_beside(self, claim).exact)

    def known(self, claim: str) -> Known:
        """Return whether a claim that is true or false is true, and why it is open.

        What is no claim of a Rosenbrock method is known of its linear form.
        """
        if self.method.rosenbrock and not concerns(claim, "rosenbrock"):
            if claim == CONSISTENT.key and self.kernel.range(ORDER.key).lower:
                return Known(True, self.kernel.exact)  # b 1 = 1, which order 1 says
            return facts_of(self.linear).known(claim)
        answer = self._either_way(claim, True, first=proposal_for(self, claim).likely())
        truth = {Verdict.HOLDS: True, Verdict.FAILS: False}.get(answer.verdict)
        return Known(truth, answer.proof is Proof.EXACT, answer.reason)

    def truth(self, claim: str) -> bool | None:
        """Return whether a claim that is true or false is true, as far as it is proved."""
        return self.known(claim).truth

    @property
    def is_single(self) -> bool:
        """Whether the method has one component."""
        return len(self.method.components) == 1

    @property
    def is_one_step(self) -> bool:
        """Whether one value (of each component) is carried."""
        return self.method.is_one_step

    @cached_property
    def consistencies(self) -> tuple[Consistency, ...]:
        """u, v, c of each component, and whether it is pre-consistent and consistent."""
        return tuple(consistency(c) for c in self.method.components)

    @cached_property
    def zero_stabilities(self) -> tuple[Boundedness, ...]:
        """Whether the V of each component is power-bounded."""
        return tuple(power_bounded(c.V) for c in self.method.components)

    @property
    def abscissae(self) -> Vector | None:
        """C = A 1 + U v; ``None`` for a method that is not consistent, or partitioned.

        Those of an additive method are the c of each part, one part after another. A partitioned
        method has two sets of abscissae; none is claimed as one.
        """
        found = [x.c for x in self.consistencies]
        if not (self.is_single or self.method.additive) or None in found:
            return None
        return tuple(x for c in found if c is not None for x in c)

    @cached_property
    def local_error(self) -> Mapping[Tree, Scalar]:
        """Residuals of the trees of order p + 1, p the order.

        For one-step methods the first value is the solution. Methods that carry several values come
        with a starting method, whose principal part is free; it is the identity where that costs no
        order, and the error constants are then those of the solution itself.
        """
        order, identity = (self.kernel.range(x.key).value for x in (ORDER, ORDER_IDENTITY))
        return self.kernel.residuals(free=not (self.is_one_step or order == identity))

    @cached_property
    def g_symplecticity(self) -> GSymplecticity:
        """The form G with its diagonals, that of the file or one found."""
        return g_symplectic(self.method)

    @cached_property
    def symmetry(self) -> Symmetry:
        """Time-reversal symmetry with its involutions."""
        return symmetry(self.method)

    @cached_property
    def parasitism(self) -> Parasitism:
        """Growth parameters at the unimodular eigenvalues of V."""
        return growth(self.method)

    @cached_property
    def eigen(self) -> Mapping[str, Any]:
        """Return the eigenvalues of V of modulus 1 by colour as a witness, or why they are open."""
        try:
            return {c.colour: [e.value for e in unimodular_eigenvalues(c.V)]
                    for c in self.method.components}  # fmt: skip
        except ExactnessError as error:
            return {"why": f"the growth parameters are open: {error}"}

    @property
    def growth_parameters(self) -> tuple[Scalar, ...]:
        """Growth parameters by increasing argument of the eigenvalue.

        Mu at each unimodular eigenvalue of V but the principal one; of a partitioned method mu_q
        and mu_p at each that V and V^ share, or, where its stages are shared and no eigenvalue but
        1, mu_qq at each of V and then mu_pp at each of V^.
        """
        growths = self.parasitism.growths
        if self.is_single:
            return tuple(g.mu for g in growths if g.mu is not None)
        return tuple(x for g in growths for m in g.listed.values() for row in m for x in row)

    @cached_property
    def reduction(self) -> Reduction:
        """Which of the values carried are needed."""
        return reduction(self.method)

    @cached_property
    def quadrature_error(self) -> tuple[Scalar, ...] | None:
        """C in ``C h^(p+1) y^(p+1)``, the local error when y' = g(x) is integrated.

        It belongs to the tree with p leaves at the root: symmetry p!, and the exact value minus
        the method's is the negative residual.
        """
        p = self.kernel.range(ORDER.key).value
        residual = self.local_error.get(tree([single()] * p))
        return None if residual is None else (residual * Fraction(-1, factorial(p)),)

    @cached_property
    def reduced(self) -> Any:
        """The method without idle and equal stages, values unseen or out of reach."""
        return reduce(self.method)

    @property
    def linear(self) -> Any:
        """The method that is meant for stability on linear systems."""
        return self.method.linear_form if self.method.rosenbrock else self.method


def facts_of(method: Method, *, implied: Implied | None = None) -> Facts:
    """Return facts of a method of any kind."""
    return Facts(method, implied=implied)
