"""Steps of the GNU Scientific Library, through its shared library.

``rk4`` of GSL takes two steps of half the size for its error estimate, so that it is no RK4 of one
step; it is claimed with its order.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from .foreign import right_hand_side

_DOUBLES = ctypes.POINTER(ctypes.c_double)
_RHS = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, _DOUBLES, _DOUBLES, ctypes.c_void_p)
#: Name here -> name in GSL.
TYPES = {"cash-karp-5": "rkck", "rkf45-5": "rkf45", "rk4-halved": "rk4", "rk8pd": "rk8pd"}


class _System(ctypes.Structure):
    """``gsl_odeiv2_system``."""

    _fields_ = (
        ("function", _RHS), ("jacobian", ctypes.c_void_p),
        ("dimension", ctypes.c_size_t), ("params", ctypes.c_void_p),
    )  # fmt: skip


def _library() -> Any:
    for blas, name in (("libgslcblas.so.0", f"libgsl.so.{n}") for n in (28, 27, 25)):
        try:
            ctypes.CDLL(blas, ctypes.RTLD_GLOBAL)
            return ctypes.CDLL(name)
        except OSError:
            continue
    raise RuntimeError("the shared library libgsl is not installed")


class Adapter:
    """``gsl_odeiv2_step``: rkck, rkf45, rk4 and rk8pd."""

    methods = {  # noqa: RUF012
        "cash-karp-5": {}, "rkf45-5": {}, "rk4-halved": {"order": 4}, "rk8pd": {"order": 8},
    }  # fmt: skip

    def __init__(self) -> None:
        self.gsl = _library()
        self.gsl.gsl_odeiv2_step_alloc.restype = ctypes.c_void_p
        self.gsl.gsl_odeiv2_step_alloc.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
        self.gsl.gsl_odeiv2_step_free.argtypes = [ctypes.c_void_p]
        self.gsl.gsl_odeiv2_step_apply.argtypes = [
            ctypes.c_void_p, ctypes.c_double, ctypes.c_double, _DOUBLES, _DOUBLES, _DOUBLES,
            _DOUBLES, ctypes.POINTER(_System),
        ]  # fmt: skip

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step, from a stepper made for it."""
        end, error = np.array(y, dtype=float), np.zeros(len(y))
        kind = ctypes.c_void_p.in_dll(self.gsl, f"gsl_odeiv2_step_{TYPES[method]}")
        system = _System(right_hand_side(problem, _RHS), None, len(end), None)
        stepper = self.gsl.gsl_odeiv2_step_alloc(kind, len(end))
        try:
            status = self.gsl.gsl_odeiv2_step_apply(
                stepper, t, h, end.ctypes.data_as(_DOUBLES), error.ctypes.data_as(_DOUBLES),
                None, None, ctypes.byref(system),
            )  # fmt: skip
        finally:
            self.gsl.gsl_odeiv2_step_free(stepper)
        if status:
            raise ArithmeticError(f"gsl_odeiv2_step_apply returned {status}")
        return end
