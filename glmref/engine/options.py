"""What to generate in addition to a form of the step and a shape of the right-hand side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Options:
    """What to generate in addition to the form and the shape."""

    compensated: bool = True  #: Compensated summation of the values.
    solver: str = "fixed-point"  #: ``"fixed-point"`` or ``"newton"``.
    target: str = "auto"  #: ``"scalar"``, ``"array"`` or ``"auto"``.
    history: bool = False  #: Whether all values are recorded, not only the solution.
    #: Whether the source is for the interpreter: arithmetic errors end the run by name instead of
    #: raising.
    interpreted: bool = False
    fused: bool = False  #: Whether the compiler may fuse products and sums.
    #: Whether rounds of the fixed point end where the next change would be below rounding.
    quick: bool = False

    @classmethod
    def of(cls, arithmetic: str, **others: Any) -> Options:
        """Return options that an ``arithmetic`` of :func:`.kernel.prepare` stands for."""
        return cls(
            compensated=arithmetic != "naive", fused=arithmetic == "fused",
            quick=arithmetic == "quick", **others,
        )  # fmt: skip
