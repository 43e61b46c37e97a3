"""The steppers that ``glmref convert`` writes, compiled or imported as they are."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ...exchange.export import export
from ...exchange.steppers import identifier
from .foreign import CPP, FORTRAN, Built

_C = """
#include "stepper.c"
int run(NAME_rhs f, void *data, int d, double t, double h, long steps, double *y) {
  return NAME_integrate(f, data, d, t, h, steps, y);
}
"""
_CPP = CPP.format(
    includes='#include "stepper.hpp"',
    steps="""
    const auto g = [&](double s, const Vector &x) {
      Vector k(x.size());
      f(s, x.data(), k.data(), data);
      return k;
    };
    const Vector end = NAME::integrate(g, t, h, steps, Vector(y, y + d));
    std::copy(end.begin(), end.end(), y);""",
)
_RUST = """
mod stepper;
type Rhs = extern "C" fn(f64, *const f64, *mut f64, *mut u8);
#[no_mangle]
pub extern "C" fn run(
    f: Rhs, data: *mut u8, d: i32, t: f64, h: f64, steps: i64, y: *mut f64,
) -> i32 {
    let y = unsafe { std::slice::from_raw_parts_mut(y, d as usize) };
    let g = |s: f64, x: &[f64], out: &mut [f64]| f(s, x.as_ptr(), out.as_mut_ptr(), data);
    match stepper::integrate(&g, t, h, steps as u64, y) {
        Ok(end) => { y.copy_from_slice(&end); 0 }
        Err(_) => 1,
    }
}
"""


_FORTRAN = "include 'stepper.f90'" + FORTRAN.format(
    used="use NAME, only: integrate",
    helpers="",
    locals="integer :: status",
    steps="call integrate(slope, t, h, int(steps), y, status)\n    run = status",
)


class _Exported(Built):
    """Explicit Runge-Kutta methods, as functions of a source file."""

    methods = ("rk4", "dormand-prince-5", "merson-4")
    language: ClassVar[str]
    stepper: ClassVar[str]
    main: ClassVar[tuple[str, str]]  #: Name and text of the file around the stepper.

    def __init__(self) -> None:
        file, text = self.main
        super().__init__(
            {
                name: {
                    file: text.replace("NAME", identifier(name)),
                    self.stepper: export(name, to=self.language),
                }
                for name in self.methods
            }
        )


class InC(_Exported):
    """C."""

    compiler = ("gcc", "-std=c99", "-O1", "-shared", "-fPIC")
    language, stepper, main = "c", "stepper.c", ("run.c", _C)


class InCpp(_Exported):
    """C++."""

    compiler = ("g++", "-std=c++11", "-O1", "-shared", "-fPIC")
    language, stepper = "c++", "stepper.hpp"
    main = ("run.cpp", _CPP)


class InFortran(_Exported):
    """Fortran."""

    compiler = ("gfortran", "-std=f2008", "-O1", "-shared", "-fPIC")
    language, stepper, main = "fortran", "stepper.f90", ("run.f90", _FORTRAN)


class InRust(_Exported):
    """Rust."""

    compiler = ("rustc", "--edition=2021", "-O", "--crate-type=cdylib")
    language, stepper, main = "rust", "stepper.rs", ("run.rs", _RUST)


class InJulia:
    """Julia, through juliacall."""

    methods = _Exported.methods

    def __init__(self) -> None:
        from juliacall import Main  # pyright: ignore[reportMissingImports]

        self._modules = {name: Main.seval(export(name, to="julia")) for name in self.methods}

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step."""

        def f(s: float, x: Any) -> np.ndarray:
            return np.array(problem.f(s, np.array(x)))

        return np.array(self._modules[method].integrate(f, t, h, 1, np.array(y)))


class InPython:
    """Python."""

    methods = _Exported.methods

    def __init__(self) -> None:
        self._modules: dict[str, dict[str, Any]] = {}
        for name in self.methods:
            self._modules[name] = {}
            exec(export(name, to="python"), self._modules[name])

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step."""

        def f(s: float, x: Any) -> list[float]:
            return list(problem.f(s, np.array(x)))

        return np.array(self._modules[method]["integrate"](f, t, h, 1, list(y)))
