"""Further weights on the stages of a method: embedded solutions, from which errors are estimated.

References
----------
Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I" (1993), section II.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..exact import linalg
from ..exact.linalg import Matrix, Vector


def quoted(name: str) -> str:
    """Return the name of a row in a message, however long it is."""
    text = repr(name)
    return text if len(text) <= 60 else f"{text[:57]}..."


@dataclass(frozen=True)
class EmbeddedRow:
    """One embedded row."""

    name: str  #: What its claims call it.
    weights: tuple[Vector, ...]  #: For each component of the method one weight for each stage.
    #: Whether these are the weights of the error estimate itself, ``b`` less those of the embedded
    #: solution, instead of the latter.
    difference: bool = False
    #: Of a method that carries several values one weight for each of them: the embedded solution is
    #: ``h weights F + values y``.
    values: Vector | None = None

    def other(self, b: Sequence[Vector]) -> tuple[Matrix, ...]:
        """Return b less the weights: those of the estimate, or of the solution where given."""
        return tuple(
            (tuple(x - y for x, y in zip(row, own, strict=True)),)
            for row, own in zip(b, self.weights, strict=True)
        )

    def solution(self, b: Sequence[Vector]) -> tuple[Matrix, ...]:
        """Return B (1, s) of the embedded solution, for each component."""
        return self.other(b) if self.difference else tuple((x,) for x in self.weights)

    def estimate(self, b: Sequence[Vector]) -> tuple[Matrix, ...]:
        """Return weights (1, s) of the error estimate, for each component."""
        return tuple((x,) for x in self.weights) if self.difference else self.other(b)

    def permuted(self, *orders: Sequence[int]) -> EmbeddedRow:
        """Return the row for stages in another order, one order for each component."""
        moved = tuple(
            tuple(row[j] for j in order) for row, order in zip(self.weights, orders, strict=True)
        )
        return EmbeddedRow(self.name, moved, self.difference, self.values)

    def transformed(self, back: Matrix) -> EmbeddedRow:
        """Return the row for values ``T y``, ``back`` the inverse of T."""
        if self.values is None:
            return self
        (values,) = linalg.matmul((self.values,), back)
        return EmbeddedRow(self.name, self.weights, self.difference, values)
