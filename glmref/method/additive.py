"""Additive methods as frozen records: k right-hand sides that share values and stages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from ..errors import DataError
from ..exact.linalg import Matrix, Vector
from ..system.arguments import shown
from .base import Own, as_list
from .component import Component, Palette, additive_palette
from .embedded import EmbeddedRow
from .entries import Entry, Rows, as_matrix, as_vector, check_fields, check_shape
from .glm import GLM, check_embedded
from .model import Method
from .starting import StartingMethod

#: As many parts as there are digits to colour trees with.
MAX_PARTS = 9


@dataclass(frozen=True, eq=False, repr=False)
class AdditiveGLM(Own, Method):
    """A method for ``y' = f_1(t, y) + .. + f_k(t, y)``, a tableau for each right-hand side.

    One step is::

        Y = U y + h sum_c A^c f_c(Y)          y+ = V y + h sum_c B^c f_c(Y)

    Implicit-explicit (IMEX) and additive Runge-Kutta methods are r = 1, U = 1, V = 1. A method of
    the GARK family, whose right-hand sides have stages of their own, is written with all its stages
    one after another: the columns of A^c and B^c that belong to stages of other right-hand sides
    are zero.

    Attributes
    ----------
    A : tuple[Matrix, ...]
        k matrices (s, s), stages on stages.
    B : tuple[Matrix, ...]
        k matrices (r, s), stages on values.
    U : Matrix or None
        (s, r), V: (r, r), shared; 1 where they are not given.
    name, claims, source, document, output, embedded
        As in :class:`glmref.GLM`.

    Raises
    ------
    DataError
        For a wrong shape, an entry that cannot be read, or another number of parts than 2 to 9.

    References
    ----------
    Ascher, Ruuth, Spiteri, Appl. Numer. Math. 25 (1997), 151-167; Kennedy, Carpenter, Appl. Numer.
    Math. 44 (2003), 139-181; Sandu, Günther, SIAM J. Numer. Anal. 53 (2015), 17-42.
    """

    A: tuple[Matrix, ...]
    B: tuple[Matrix, ...]
    U: Matrix | None = None  # pyright: ignore[reportAssignmentType]
    V: Matrix | None = None
    name: str = ""
    claims: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    source: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    document: Mapping[str, Any] | None = field(default=None, repr=False)
    output: Vector | None = None
    embedded: tuple[EmbeddedRow, ...] = ()

    additive: ClassVar[bool] = True
    SIZES: ClassVar[Sequence[str]] = ("k", "s", "r")
    #: There is no start of its own, and no quadratic form is looked for.
    starting: ClassVar[StartingMethod | None] = None
    G: ClassVar[Matrix | None] = None

    if TYPE_CHECKING:  # what is taken is wider than what is kept

        def __init__(
            self,
            A: Sequence[Rows],
            B: Sequence[Rows],
            U: Rows | None = None,
            V: Rows | None = None,
            name: str = "",
            claims: Mapping[str, Any] = ...,
            source: Mapping[str, Any] = ...,
            document: Mapping[str, Any] | None = None,
            output: Sequence[Entry] | None = None,
            embedded: tuple[EmbeddedRow, ...] = (),
        ) -> None: ...

    def __post_init__(self) -> None:
        check_fields(self)
        for letter in "AB":
            rows = as_list(getattr(self, letter))
            if isinstance(rows, str) or not isinstance(rows, Sequence):
                raise DataError(f"`{letter}` must be a list of matrices, got {shown(rows)}")
            object.__setattr__(self, letter, rows)
        if not 2 <= len(self.A) == len(self.B) <= MAX_PARTS:
            raise DataError(
                f"an additive method has 2 to {MAX_PARTS} parts with an A and a B each, got "
                f"{len(self.A)} A and {len(self.B)} B"
            )
        for letter in "AB":
            rows = getattr(self, letter)
            found = tuple(as_matrix(x, f"{letter}^{n + 1}") for n, x in enumerate(rows))
            object.__setattr__(self, letter, found)
        s, r = len(self.A[0]), len(self.B[0])
        for letter, size in (("U", s), ("V", r)):
            given = getattr(self, letter)
            matrix = as_matrix([[1] * r] * size if given is None else given, letter)
            object.__setattr__(self, letter, matrix)
            check_shape(letter, matrix, size, r, "(s, r)" if letter == "U" else "(r, r)")
        for n, (A, B) in enumerate(zip(self.A, self.B, strict=True), 1):
            check_shape(f"A^{n}", A, s, s, "(s, s)")
            check_shape(f"B^{n}", B, r, s, "(r, s)")
        if self.output is not None:
            object.__setattr__(self, "output", as_vector(self.output, "output"))
        check_embedded(self)

    @property
    def k(self) -> int:
        """Number of right-hand sides."""
        return len(self.A)

    @property
    def s(self) -> int:
        """Number of stages."""
        return len(self.A[0])

    @property
    def r(self) -> int:
        """Number of values carried from step to step."""
        return len(self.B[0])

    @property
    def palette(self) -> Palette:
        """The digits 1 to k, each below each."""
        return additive_palette(self.k)

    @cached_property
    def components(self) -> tuple[Component, ...]:
        """One for each right-hand side; U, V and the output are the same in all."""
        assert self.U is not None and self.V is not None
        return tuple(
            Component(str(n), A, self.U, B, self.V, self.output)
            for n, (A, B) in enumerate(zip(self.A, self.B, strict=True), 1)
        )

    def weighted(self, B: tuple[Matrix, ...]) -> AdditiveGLM:
        """Return the method with other weights, for one of its embedded rows."""
        return replace(self, B=B, embedded=(), document=None, claims=MappingProxyType({}))

    def part(self, n: int) -> GLM:
        """Return the method that integrates ``y' = f_n(t, y)`` alone, n from 1."""
        c = self.components[n - 1]
        return GLM(c.A, c.U, c.B, c.V, name=f"{self.name}, part {n}", output=c.output)
