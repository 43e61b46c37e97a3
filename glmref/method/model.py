"""What a method of k components is, whatever its class: what theory, proofs and engines read."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector
from . import preconsistency, stage_order
from .component import ROOTED, Component, Palette
from .embedded import EmbeddedRow

#: Of a pair: its colours, and what is appended to the names of the fields of each.
PAIR: Mapping[str, str] = MappingProxyType({"f": "", "k": "_hat"})


class Method:
    """A method of k components: what theory, proofs, engines and suites read.

    The public faces are :class:`glmref.method.GLM` (k = 1),
    :class:`glmref.method.PartitionedGLM` (k = 2) and :class:`glmref.method.AdditiveGLM`.
    """

    #: Colours of the components and what is appended to A, U, B, V in the names of their fields.
    LETTERS: ClassVar[Mapping[str, str]] = MappingProxyType({"o": ""})
    #: Whether the components share values and stages and their right-hand sides are summed.
    additive: ClassVar[bool] = False
    #: Whether it is a Rosenbrock method, written as an additive one.
    rosenbrock: ClassVar[bool] = False
    #: Which systems it is for, where trees of its palette vanish on them; see ``theory.nystrom``.
    system: str = ""
    #: Further weights on its stages.
    embedded: tuple[EmbeddedRow, ...] = ()

    if TYPE_CHECKING:  # fields of the classes below; starts and finishes have fewer
        name: str
        claims: Mapping[str, Any]
        source: Mapping[str, Any]
        document: Mapping[str, Any] | None
        starting: Any
        G: Matrix | None

    @property
    def finishing(self) -> Any:
        """Finishing method; ``None`` where the outputs are the solution."""
        return None

    @property
    def in_time(self) -> Method:
        """The method for systems in which time occurs."""
        return self

    def weighted(self, B: tuple[Matrix, ...]) -> Method:
        """Return the method with other weights, for one of its embedded rows."""
        raise NotImplementedError

    def with_row(self, row: EmbeddedRow) -> Method:
        """Return the method with an embedded row in the place of that of the solution."""
        return self.weighted(row.solution(self.weights))

    @property
    def weights(self) -> tuple[Vector, ...]:
        """First row of B of each component: b of a method that carries one value."""
        return tuple(c.B[0] for c in self.components)

    @property
    def diagonals(self) -> tuple[Vector | None, ...]:
        """The diagonals that go with G, in their order; ``None`` where one is not given."""
        return ()

    @cached_property
    def components(self) -> tuple[Component, ...]:
        """The components, in the order of the palette."""
        return tuple(
            Component(
                colour,
                **{letter: getattr(self, letter + hat) for letter in "AUBV"},
                output=getattr(self, f"output{hat}", None),
            )
            for colour, hat in self.LETTERS.items()
        )

    @property
    def palette(self) -> Palette:
        """At the stages of which components each right-hand side is evaluated."""
        return ROOTED

    @property
    def shared(self) -> bool:
        """Whether all right-hand sides are evaluated at the same stages."""
        return stage_order.is_shared(self.palette)

    @property
    def parts(self) -> int:
        """Number of equal parts of the state that have values of their own: 2 for y = (q, p)."""
        return 1 if self.additive else len(self.components)

    @property
    def carriers(self) -> tuple[Component, ...]:
        """The components whose values are carried: one for each part of the state."""
        return self.components[: self.parts]

    @property
    def times(self) -> tuple[Vector, ...]:
        """Where in a step the stages of each part stand, in steps.

        Zeros for y = (q, p) where Q_i and P_i are apart: these systems have no time.
        """
        if self.parts > 1 and self.shared:
            return tuple(preconsistency.stage_times(c) for c in self.components)
        if self.parts > 1:
            return tuple((Exact(0),) * len(c.U) for c in self.components)
        return (preconsistency.stage_times(self.components[0]),)

    @property
    def carried(self) -> int:
        """Number of rows that hold the values: the largest r of a component."""
        return max(len(c.V) for c in self.components)

    @property
    def is_one_step(self) -> bool:
        """Whether one value (of each component) is carried."""
        return self.carried == 1

    @property
    def is_exact(self) -> bool:
        """Whether every coefficient is exact (no published decimal among them)."""
        return all(c.is_exact for c in self.components)

    @property
    def is_real(self) -> bool:
        """Whether every coefficient is real."""
        return all(
            x.is_real() for c in self.components for m in c.matrices for row in m for x in row
        )

    def stage_blocks(self, palette: Palette | None = None) -> tuple[stage_order.StageBlock, ...]:
        """Return stages in an order in which they can be computed: see :mod:`.stage_order`.

        Parameters
        ----------
        palette : at which stages the right-hand sides are evaluated; by default those of the
            method. On a separable problem a method made for all systems needs fewer.
        """
        return stage_order.stage_blocks(self.components, palette or self.palette)

    def read_stages(self, palette: Palette | None = None) -> frozenset[int]:
        """Return the stages that a value reads, also through others: see :meth:`stage_blocks`."""
        return stage_order.read_stages(self.components, palette or self.palette)

    @property
    def implicit_stages(self) -> tuple[int, ...]:
        """Numbers (from 1) of the stages that need an equation solved, however they are numbered.

        Those that need themselves, directly or through others.
        """
        coupled = [block.stages for block in self.stage_blocks() if block.implicit]
        return tuple(sorted(i + 1 for stages in coupled for i in stages))

    @property
    def is_diagonally_implicit(self) -> bool:
        """Whether every A is lower triangular (explicit methods included)."""
        return all(linalg.is_lower_triangular(c.A) for c in self.components)

    @cached_property
    def is_explicit(self) -> bool:
        """Whether no stage needs an equation solved."""
        return not self.implicit_stages
