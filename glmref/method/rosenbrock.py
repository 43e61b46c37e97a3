"""Rosenbrock and W-methods: a matrix J in the place of what Newton's method would solve with.

``k_i = h f(y + sum alpha_ij k_j) + h J sum gamma_ij k_j``, ``y+ = y + sum b_i k_i``.

Written as ``y' = (f(y) - J y) + J y`` it is an additive method: f - J is evaluated at stages made
with alpha, and J at stages made with alpha + gamma; the slopes k are the sums of both. So its trees
are those of an additive method of two parts. J is linear, so that a vertex 2 has at most one
child; and where J is the Jacobian the first derivative of f - J vanishes, so that a vertex 1 has
never exactly one.

References
----------
Hairer, Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.7.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar

from ..errors import DataError
from ..exact.linalg import Matrix, Vector, add
from ..judge import families
from .additive import AdditiveGLM
from .embedded import EmbeddedRow, quoted
from .entries import as_matrix, check_shape
from .families import runge_kutta
from .glm import GLM


@dataclass(frozen=True, eq=False, repr=False)
class RosenbrockGLM(AdditiveGLM):
    """A Rosenbrock method with s stages, as the additive method of 2 s stages that it is.

    Attributes
    ----------
        alpha, gamma: (s, s). b: (s,).
        system: ``"rosenbrock"`` with the exact Jacobian, ``"w"`` with any matrix.
        Others as in :class:`~glmref.method.AdditiveGLM`.

    Raises
    ------
    DataError
        For shapes that do not fit.
    """

    alpha: Matrix = ()
    gamma: Matrix = ()
    b: Vector = ()
    system: str = field(default="rosenbrock")

    rosenbrock: ClassVar[bool] = True

    @classmethod
    def of(
        cls,
        alpha: Matrix,
        gamma: Matrix,
        b: Vector,
        embedded: tuple[tuple[str, Vector], ...] = (),
        **more: Any,
    ) -> RosenbrockGLM:
        """Make the method of alpha (s, s), gamma (s, s), b (s,) and embedded weights by name."""
        s = len(b)
        check_shape("alpha", alpha, s, s, "(s, s)")
        check_shape("gamma", gamma, s, s, "(s, s)")
        for name, row in embedded:
            if len(row) != s:
                raise DataError(
                    f"`embedded` {quoted(name)} must have s = {s} entries, got {len(row)}"
                )
        parts = families.rosenbrock(alpha, add(alpha, gamma), b)

        def weights(row: Vector) -> Matrix:
            return as_matrix(families.rosenbrock_weights(row), "b")

        return cls(
            A=tuple(as_matrix(x.A, "A") for x in parts),
            B=tuple(as_matrix(x.B, "B") for x in parts),
            embedded=tuple(EmbeddedRow(name, weights(row)) for name, row in embedded),
            alpha=alpha, gamma=gamma, b=b, **more,
        )  # fmt: skip

    def with_any_matrix(self) -> RosenbrockGLM:
        """Return the same method where J is any matrix."""
        kept = {x.name: getattr(self, x.name) for x in fields(self)}
        return RosenbrockGLM(**{**kept, "system": "w", "document": None})

    @property
    def linear_form(self) -> GLM:
        """The Runge-Kutta method alpha + gamma, b: what it is on linear systems."""
        form = runge_kutta(add(self.alpha, self.gamma), self.b, self.name)
        return form if self.document is None else replace(form, document=_linear(self.document))


#: What a document says of its numbers.
_NUMBERS = ("format", "name", "digits", "unknowns", "constants")


def _linear(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document of the Runge-Kutta method alpha + gamma, b, its sums written out."""
    A = [
        [f"({x})+({y})" for x, y in zip(*rows, strict=True)]
        for rows in zip(document["alpha"], document["gamma"], strict=True)
    ]
    kept = {key: document[key] for key in _NUMBERS if key in document}
    return {**kept, "class": "rk", "A": A, "b": document["b"]}
