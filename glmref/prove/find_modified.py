"""What the kernel finds of the modified equation of the underlying one-step method."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..errors import ExactnessError, UsageError
from ..exact import Scalar
from ..exact.linalg import Matrix
from ..theory.backward import (
    LARGEST_CONJUGATE,
    Reach,
    conjugacy,
    energy_reach,
    hamiltonian_reach,
)
from ..theory.coefficients import is_zero
from ..theory.second_order import second_order
from ..theory.series import Series
from ..theory.starting_series import NotPreconsistent
from ..theory.trees import single
from ..theory.underlying import UnderlyingMethod
from .ranges import Range

#: Orders through which trees are taken, one after another until a condition fails.
_THROUGH = (3, 5, 7, LARGEST_CONJUGATE)


class ModifiedRules:
    """A part of :class:`~glmref.prove.kernel.Kernel`."""

    if TYPE_CHECKING:
        method: Any
        exact: bool
        blocks: dict[str, tuple[Matrix, Matrix, Matrix, Matrix]]

    @cached_property
    def _underlying(self) -> UnderlyingMethod:
        if not self.exact or "o" not in self.blocks:
            raise ExactnessError("modified equations of exact methods of one component are judged")
        try:
            return UnderlyingMethod.of_method(self.method)
        except (NotPreconsistent, UsageError) as error:
            raise ExactnessError(f"there is no underlying one-step method: {error}") from error

    def _reached(self, find: Callable[[Series], Reach]) -> Range:
        """Return bounds of the order through which the modified field has a property."""
        for order in _THROUGH:
            field = self._underlying.through(order).field
            if is_zero(field[single()] - 1) is not True:
                raise ExactnessError("the method is not consistent")
            found = find(field)
            if found.fails:
                reason = f"order {found.order + 1} fails at {found.witness}"
                return Range(found.order, found.order, reason=reason, value=found.order)
        return Range(LARGEST_CONJUGATE, None, value=LARGEST_CONJUGATE)

    @cached_property
    def _hamiltonian_to_order(self) -> Range:
        """The modified field is Hamiltonian: Hairer, Lubich, Wanner (2006), section IX.9."""
        return self._reached(hamiltonian_reach)

    @cached_property
    def _energy_order(self) -> Range:
        """The modified field preserves H: Celledoni, McLachlan, Owren, Quispel (2010)."""
        return self._reached(energy_reach)

    @cached_property
    def _conjugate_symplectic_order(self) -> Range:
        """In some variables the modified field is Hamiltonian: Hairer, Zbinden (2013)."""
        return self._reached(lambda field: conjugacy(field).reach)

    @cached_property
    def invariants(self) -> tuple[Scalar, ...]:
        """I1 and I3 at one eigenvalue of V of modulus 1 other than 1 after the other."""
        found = second_order(self.method, self._underlying)
        return tuple(y for x in found for y in (x.I1, x.I3))
