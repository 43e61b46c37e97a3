"""What the kernel finds of structure: symplectic, G-symplectic and symmetric methods."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..errors import ExactnessError
from ..exact import linalg
from ..exact.linalg import Matrix
from ..method.preconsistency import preconsistency_vector
from ..theory.coefficients import difference
from ..theory.starting_series import NoOrderOne, NotPreconsistent, Prepared
from ..theory.symmetry import symmetry_as_given
from ..theory.symplectic import find_forms, form_identities, quadratic_value
from .algebra import (
    all_of,
    full_rank,
    is_exact,
    vanishes,
)
from .ranges import Known


class FormRules:
    """A part of :class:`~glmref.prove.kernel.Kernel`."""

    if TYPE_CHECKING:
        blocks: dict[str, tuple[Matrix, Matrix, Matrix, Matrix]]
        is_pair: bool
        shared: bool
        exact: bool
        one_step: bool
        method: Any
        _components: dict[str, Prepared]

    # -- forms -------------------------------------------------------------------------------------

    def _symplectic(self, witness: Mapping[str, Any]) -> Known:
        """Decide b_i a_ij + b_j a_ji = b_i b_j (Sanz-Serna; Lasagni; Suris 1988); pairs: hats.

        Hairer, Lubich, Wanner (2006), theorems VI.4.3 and VI.4.6.
        """
        if not self.one_step:
            return Known(False, True, "a method that carries several values has no symplectic step")
        for _, U, _, V in self.blocks.values():
            ones = [x - 1 for row in (*U, *V) for x in row]
            if vanishes([ones]) is not True:
                raise ExactnessError("U and V of a method that carries one value must be 1")
        if self.is_pair:
            (A, _, (b,), _), (A_hat, _, (b_hat,), _) = self.blocks["f"], self.blocks["k"]
        else:
            A, _, (b,), _ = self.blocks["o"]
            A_hat, b_hat = A, b
        identity = tuple(
            tuple(
                b[i] * A_hat[i][j] + b_hat[j] * A[j][i] - b[i] * b_hat[j] for j in range(len(b_hat))
            )
            for i in range(len(b))
        )
        answers = [vanishes(identity)]
        if self.shared:
            answers.append(vanishes([difference(b, b_hat)]))
        return Known(all_of(answers), self.exact)

    def _g_symplectic(self, witness: Mapping[str, Any]) -> Known:
        """Judge whether some (G, D) satisfies the identities and u^* G u is not 0.

        Butcher and Hewitt, Numer. Algorithms 51 (2009) 33. A given or proposed form is checked.
        Where none is given and none works, all forms are looked for (:func:`.find_forms`).
        """
        vectors = [
            preconsistency_vector(c) if is_exact(c.U, c.V) else None for c in self.method.components
        ]
        if any(x is None for x in vectors):
            if all(is_exact(b[1], b[3]) for b in self.blocks.values()):
                return Known(False, True, "the method is not preconsistent: no form counts")
            try:
                vectors = [c.u if c.certain else None for c in self._components.values()]
            except NoOrderOne as reason:
                raise ExactnessError(f"the form is not decided: {reason}") from reason
            except NotPreconsistent as reason:
                return Known(False, self.exact, f"not preconsistent, no form counts: {reason}")
            if any(x is None for x in vectors):
                raise ExactnessError("whether V u = u, U u = 1 is not decided within the digits")
        if not all(full_rank((*linalg.sub(V, linalg.identity(len(V))), *U), len(V))
                   for _, U, _, V in self.blocks.values()):  # fmt: skip
            raise ExactnessError("V u = u and U u = 1 do not determine u")
        u, u_hat = vectors[0], vectors[-1]
        assert u is not None
        assert u_hat is not None
        form = witness.get("form")
        if form is not None:
            G, diagonals = form
            identities = form_identities(self.method, G, *diagonals)
            seen = quadratic_value(G, u, u_hat).is_zero()
            answers = [*(vanishes(x) for _, x in identities), None if seen is None else not seen]
            truth = all_of(answers)
            if truth is True or witness.get("given"):
                return Known(truth, self.exact and is_exact(G, diagonals))
        if not self.exact:
            raise ExactnessError("no form was proved or excluded within the digits")
        return Known(not witness.get("none") and find_forms(self.method).principal)

    # -- symmetry ----------------------------------------------------------------------------------

    def _symmetric(self, witness: Mapping[str, Any]) -> Known:
        """Judge whether the method equals its adjoint: :func:`.symmetry_as_given`."""
        found = symmetry_as_given(self.method)
        if found.holds is False and found.exchanges and not all(
            is_exact(*b[1:]) for b in self.blocks.values()
        ):  # fmt: skip
            return Known(None, self.exact, "an exchange of stages was neither proved nor excluded")
        singular = found.holds is False and "singular" in found.witness
        return Known(found.holds, self.exact or singular, found.witness)

    def _symmetric_reduced(self, witness: Mapping[str, Any]) -> Known:
        """Return the same for the method without the values that are never reached or never seen.

        A proposed method with the same A is that method where U V^k B agree for k < r + r' (by
        Cayley and Hamilton then for all k: stages see the same) and where it is itself minimal:
        minimal methods with equal U V^k B differ by a change of basis only (Kalman 1963).
        """
        smaller = witness.get("reduced")
        if smaller is None:
            raise ExactnessError("the method without idle values was not found")
        if len(smaller.A) != len(self.blocks["o"][0]):
            raise ExactnessError(
                "the method has equal or idle stages, which are not taken out here"
            )
        A, U, B, V = self.blocks["o"]
        if vanishes(linalg.sub(A, smaller.A)) is not True:
            raise ExactnessError("the method without idle values has another A")
        left, right = U, smaller.U
        for _ in range(len(V) + len(smaller.V)):
            gap = linalg.sub(linalg.matmul(left, B), linalg.matmul(right, smaller.B))
            if vanishes(gap) is not True:
                raise ExactnessError("the method without idle values is not equivalent")
            left, right = linalg.matmul(left, V), linalg.matmul(right, smaller.V)
        kind: Any = type(self)
        inner = kind(smaller)
        if inner._reducible({}).truth is not False:
            raise ExactnessError("the reduced method is not minimal")
        return replace(inner._symmetric(witness), exact=self.exact)
