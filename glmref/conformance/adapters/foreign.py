"""Integrators behind a C interface: a shared library that a compiler makes of a few lines."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

_DOUBLES = ctypes.POINTER(ctypes.c_double)
#: f(t, y, out, data) of C.
RHS = ctypes.CFUNCTYPE(None, ctypes.c_double, _DOUBLES, _DOUBLES, ctypes.c_void_p)


#: A function of C around Fortran, to be filled in by ``str.format``.
FORTRAN = """
module board_run
  use, intrinsic :: iso_c_binding
  {used}
  implicit none
  abstract interface
    subroutine right_hand_side(t, y, out, given) bind(c)
      import c_double, c_ptr
      real(c_double), value :: t
      real(c_double), intent(in) :: y(*)
      real(c_double), intent(out) :: out(*)
      type(c_ptr), value :: given
    end subroutine
  end interface
  procedure(right_hand_side), pointer, save :: called => null()
  type(c_ptr), save :: given
contains
  subroutine slope(t, y, out)
    real(c_double), intent(in) :: t, y(:)
    real(c_double), intent(out) :: out(:)
    call called(t, y, out, given)
  end subroutine
  {helpers}
  integer(c_int) function run(f, data, d, t, h, steps, y) bind(c)
    type(c_funptr), value :: f
    type(c_ptr), value :: data
    integer(c_int), value :: d
    real(c_double), value :: t, h
    integer(c_long), value :: steps
    real(c_double), intent(inout) :: y(d, 1)
    {locals}
    call c_f_procpointer(f, called)
    given = data
    {steps}
  end function
end module
"""


#: The same around C++, whose exceptions become the status 1.
CPP = """
{includes}
#include <algorithm>
#include <vector>
typedef std::vector<double> Vector;
typedef void (*rhs)(double, const double *, double *, void *);
extern "C" int run(rhs f, void *data, int d, double t, double h, long steps, double *y) {{
  try {{
    {steps}
    return 0;
  }} catch (...) {{
    return 1;
  }}
}}
"""


def right_hand_side(problem: Any, kind: Any = RHS) -> Any:
    """Return a function of C that evaluates the right-hand side; it must outlive its calls."""
    d = problem.dimension

    def f(t: float, y: Any, out: Any, _: Any) -> int:
        result = np.ctypeslib.as_array(out, (d,))
        result[:] = problem.f(t, np.ctypeslib.as_array(y, (d,)))
        return 0

    return kind(f)


class Built:
    """Methods that are functions ``run(f, data, d, t, h, steps, y)`` of shared libraries.

    The function takes steps from y in place, and returns 0. ``sources`` gives for each method the
    files to be compiled, the main one first, and the text of each.
    """

    compiler: Sequence[str]  #: The command; ``-o LIBRARY FILE`` and the libraries are appended.
    libraries: Sequence[str] = ()  #: What is linked, as words of the compiler.
    methods: Sequence[str] | Mapping[str, Mapping[str, object]]  #: As of every adapter.

    def __init__(self, sources: Mapping[str, Mapping[str, str]]) -> None:
        if shutil.which(self.compiler[0]) is None:
            raise RuntimeError(f"the compiler {self.compiler[0]} is not installed")
        self._folder = TemporaryDirectory()
        self._built = {name: self._build(name, files) for name, files in sources.items()}

    def _build(self, method: str, files: Mapping[str, str]) -> Any:
        place = Path(self._folder.name, method)
        place.mkdir()
        for name, text in files.items():
            (place / name).write_text(text, encoding="utf-8")
        library = place / "run.so"
        done = subprocess.run(
            [*self.compiler, "-o", str(library), next(iter(files)), *self.libraries],
            cwd=place, capture_output=True, text=True, check=False,
        )  # fmt: skip
        if done.returncode:
            first = next((x for x in done.stderr.splitlines() if "error" in x), "no message")
            raise RuntimeError(f"{self.compiler[0]} does not compile {method}: {first}")
        run = ctypes.CDLL(str(library)).run
        run.argtypes = [RHS, ctypes.c_void_p, ctypes.c_int, ctypes.c_double, ctypes.c_double]
        run.argtypes += [ctypes.c_long, _DOUBLES]
        return run

    def _run(
        self, method: str, problem: Any, t: float, y: np.ndarray, h: float, steps: int
    ) -> np.ndarray:
        end, f = np.array(y, dtype=float), right_hand_side(problem)
        pointer = end.ctypes.data_as(_DOUBLES)
        status = self._built[method](f, None, len(end), t, h, steps, pointer)
        if status:
            raise ArithmeticError(f"the function returned {status}")
        return end

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step."""
        return self._run(method, problem, t, y, h, 1)

    def close(self) -> None:
        """Delete what was compiled."""
        self._folder.cleanup()
