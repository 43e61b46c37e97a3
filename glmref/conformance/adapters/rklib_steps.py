"""Fixed-step methods of rklib, around a function with the interface of C.

The folder in the environment variable RKLIB holds ``librklib.a`` and the ``.mod`` files beside it;
the container recipe says how they are made.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from ...errors import UsageError
from .foreign import FORTRAN, Built

_SOURCE = FORTRAN.format(
    used="use rklib_module",
    helpers="""
  subroutine slope_of(me, t, y, out)
    class(rk_class), intent(inout) :: me
    real(c_double), intent(in) :: t, y(:)
    real(c_double), intent(out) :: out(:)
    call slope(t, y, out)
  end subroutine""",
    locals="""
    type(KIND_class) :: method
    real(c_double) :: reached(d)""",
    steps="""
    call method%initialize(int(d), slope_of)
    call method%integrate(t, y(:, 1), h, t + steps * h, reached)
    y(:, 1) = reached
    run = merge(1, 0, method%failed())""",
)
#: Name in the catalogue, or the order that rklib declares -> name in rklib.
KINDS = {
    "euler": "euler", "midpoint-explicit": "midpoint", "heun-2": "heun", "ssp-rk3": "rkssp33",
    "rk4": "rk4", "ralston-4": "rkr4", "cooper-verner-8": "rkcv8",
}  # fmt: skip
DECLARED = {"rks4": 4, "rks5": 5, "rk5": 5, "rkb6": 6, "rk7": 7, "rk8_10": 8, "rk8_12": 8}


class Adapter(Built):
    """``rklib``: methods at constant step size; ``rks5`` and ``rk8_10`` miss their order."""

    methods: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        **{key: {} for key in KINDS},
        **{name: {"order": order} for name, order in DECLARED.items()},
    }

    def __init__(self) -> None:
        place = Path(os.environ.get("RKLIB", "rklib"))
        if not (place / "librklib.a").is_file():
            raise UsageError(
                f"rklib is not there: {place / 'librklib.a'} is missing; set the environment "
                f"variable RKLIB to the folder of librklib.a and its .mod files"
            )
        self.compiler = ("gfortran", "-O1", "-shared", "-fPIC", f"-I{place}")
        self.libraries = (str(place / "librklib.a"),)
        names = KINDS | {name: name for name in DECLARED}
        super().__init__(
            {ours: {"run.f90": _SOURCE.replace("KIND", kind)} for ours, kind in names.items()}
        )
