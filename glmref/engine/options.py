"""What to generate in addition to a form of the step and a shape of the right-hand side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

#: Change of a stage, relative to the state, that quick rounds leave undone.
QUICK = 2.0**-50


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
    quick: float = 0.0  #: The change at whose prediction rounds of the fixed point end, if not 0.

    @classmethod
    def of(cls, arithmetic: str, **others: Any) -> Options:
        """Return options that an ``arithmetic`` of :func:`.kernel.prepare` stands for."""
        return cls(
            compensated=arithmetic != "naive", fused=arithmetic == "fused",
            quick=QUICK if arithmetic == "quick" else 0.0, **others,
        )  # fmt: skip
