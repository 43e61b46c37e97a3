"""The compiled engine against hand-written C loops of the same arithmetic, and other bounds.

For three problems and four methods, ``benchmarks/c`` holds the loop as one would write it by hand:
the same operations in the same order, which is checked, since the end states must be equal to the
last bit. Beside it: the force alone as often as the method evaluates it, each evaluation at the
result of the one before; the engine with the stage solver it chooses itself; and the reference
engine (numpy). The compiler gets ``-O3 -march=native`` and, as the engine does no such thing
either, ``-ffp-contract=off``; and ``-fno-math-errno``, which the square root of C needs to be one
instruction.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.timing import interleaved, quartiles, ratios
from glmref.catalogue import load
from glmref.engine.kernel import Kernel, prepare
from glmref.engine.reference import stepper
from glmref.engine.start import zero_start
from glmref.problems import problem
from glmref.problems.model import Problem

__all__ = ["FLAGS", "METHODS", "PROBLEMS", "Row", "compiler", "compiler_version", "measure"]

SOURCES = Path(__file__).parent / "c"
FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-fno-math-errno")

#: Name -> (macro of the C source, parameters, step size).
PROBLEMS: dict[str, tuple[str, dict[str, Any], float]] = {
    "kepler": ("KEPLER", {"eccentricity": "3/5"}, 2 * np.pi / 250),
    "henon-heiles": ("HENON_HEILES", {}, 0.1),
    "outer-solar-system": ("OUTER", {}, 50.0),
}
METHODS = ("rk4", "gauss-3", "g6245", "stormer-verlet")
CHECKED_STEPS = 1000

Loop = Callable[..., int]


@dataclass(frozen=True)
class Row:
    """One method on one problem.

    Attributes
    ----------
        method, problem: what was run. same_bits: whether C and engine end in the same state.
        evaluations: evaluations of the force per step, of the arithmetic that C has as well.
        nanoseconds: name of the competitor -> quartiles of the time of one step; ``force`` is one
            evaluation of the force, ``chosen`` the engine with the solver named in ``solver``.
        c_over_engine: quartiles of the ratio of times; 1 and above: the engine is no slower than C.
        engine_over_force: time of a step over that of its evaluations alone, medians.
        reference_over_engine: how much slower the numpy reference is, medians.
    """

    method: str
    problem: str
    solver: str
    same_bits: bool
    evaluations: float
    nanoseconds: dict[str, tuple[float, float, float]]
    c_over_engine: tuple[float, float, float]
    engine_over_force: float
    reference_over_engine: float


def compiler() -> str | None:
    """Path of a C compiler, or ``None``."""
    return shutil.which("gcc") or shutil.which("cc") or shutil.which("clang")


def compiler_version() -> str:
    """First line of what the compiler says of itself."""
    command = [str(compiler()), "--version"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[
        0
    ]


def built(source: str, macro: str, folder: Path) -> Loop:
    """Compile one loop for one problem: ``run(y, par, h, steps)``, which returns evaluations."""
    library = folder / f"{source}_{macro}.so"
    command = [str(compiler()), *FLAGS, "-shared", "-fPIC", f"-D{macro}", "-o", str(library)]
    subprocess.run([*command, str(SOURCES / f"{source}.c"), "-lm"], check=True)
    run = ctypes.CDLL(str(library)).run
    run.restype = ctypes.c_long
    run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_long]
    return run


class Case:
    """One method on one problem, ready to run in every way."""

    def __init__(self, name: str, of: str, folder: Path) -> None:
        macro, parameters, self.h = PROBLEMS[of]
        self.problem: Problem = problem(of, **parameters)
        self.method = load(name)
        self.kernel = prepare(self.method, self.problem, h=self.h, solver="fixed-point")
        self.chosen = prepare(self.method, self.problem, h=self.h)
        self.loop = built(name.replace("-", "_"), macro, folder)
        self.force = built("bare", macro, folder)
        self.stepper = stepper(self.method, self.problem)
        self.start = zero_start(self.stepper, self.problem.y0)
        self.slope = np.asarray(self.problem.f(0.0, self.start[0]))
        self.out = np.zeros(1)

    def engine(self, kernel: Kernel, steps: int) -> tuple[np.ndarray, int]:
        """All steps in one call of a kernel: values and evaluations."""
        state = kernel.state(self.start, self.slope, self.h)
        outcome = kernel.built.kernel(
            state.work, kernel.shape.values, 0.0, self.h, 0, steps, -1, 0, self.out, 0, state.tally
        )
        if outcome:
            raise ArithmeticError(f"{self.method.name} on {self.problem.name} did not complete")
        return kernel.values(state), int(state.tally[0])

    def c(self, steps: int) -> tuple[np.ndarray, int]:
        """The same by the C loop."""
        y = np.ascontiguousarray(self.kernel.form.into(self.start))
        par = self.kernel.shape.values
        evaluations = self.loop(y.ctypes.data, par.ctypes.data, self.h, steps)
        if evaluations < 0:
            raise ArithmeticError(f"C: {self.method.name} on {self.problem.name} did not complete")
        return self.kernel.form.back(y), evaluations

    def forces(self, count: int) -> None:
        """Evaluate the force ``count`` times in C, each time where the last one led."""
        q = np.array(self.problem.y0[: self.problem.dimension // 2], dtype=float)
        self.force(q.ctypes.data, self.kernel.shape.values.ctypes.data, 2.0**-60, count)

    def reference(self, steps: int) -> None:
        """Take steps with the reference engine."""
        values = self.start
        for n in range(steps):
            values = self.stepper.step(n * self.h, values, self.h).values


def measure(name: str, of: str, folder: Path, *, repeats: int, seconds: float) -> Row:
    """Time one method on one problem; every run takes about ``seconds``."""
    case = Case(name, of, folder)
    ours, theirs = case.engine(case.kernel, CHECKED_STEPS), case.c(CHECKED_STEPS)
    pilot = interleaved({"c": lambda: case.c(CHECKED_STEPS)}, 3)["c"]
    steps = max(CHECKED_STEPS, round(CHECKED_STEPS * seconds / min(pilot)))
    per_step, slow = ours[1] / CHECKED_STEPS, 20
    count = round(steps * per_step)
    spent = interleaved(
        {
            "c": lambda: case.c(steps),
            "engine": lambda: case.engine(case.kernel, steps),
            "chosen": lambda: case.engine(case.chosen, steps),
            "force": lambda: case.forces(count),
            "reference": lambda: case.reference(slow),
        },
        repeats,
    )
    per = {"c": steps, "engine": steps, "chosen": steps, "force": count, "reference": slow}
    scaled = {key: [1e9 * x / per[key] for x in times] for key, times in spent.items()}
    found = {key: quartiles(times) for key, times in scaled.items()}
    return Row(
        method=name,
        problem=of,
        solver=case.chosen.options.solver if case.chosen.form.implicit_stages else "",
        same_bits=bool(np.array_equal(ours[0], theirs[0])) and ours[1] == theirs[1],
        evaluations=per_step,
        nanoseconds=found,
        c_over_engine=quartiles(ratios(spent, "c", "engine")),
        engine_over_force=quartiles(
            [a / (b * per_step) for a, b in zip(scaled["engine"], scaled["force"], strict=True)]
        )[1],
        reference_over_engine=quartiles(ratios(scaled, "reference", "engine"))[1],
    )


def measure_all(*, repeats: int = 15, seconds: float = 0.03) -> list[Row]:
    """Every method on every problem; empty where there is no C compiler."""
    if compiler() is None:
        return []
    with tempfile.TemporaryDirectory() as folder:
        return [
            measure(name, of, Path(folder), repeats=repeats, seconds=seconds)
            for of in PROBLEMS
            for name in METHODS
        ]
