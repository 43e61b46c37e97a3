"""The compiled engine against hand-written C loops of the same arithmetic, and other bounds.

``tools/measure/c`` holds each loop as one would write it by hand: the same operations in the same
order, which is checked, since the end states must be equal to the last bit. Pairs and splittings
share one loop, ``sweep.c``, with a table of stages that is printed from the method's data. Beside
it: the force alone as often as the method evaluates it, each evaluation at the result of the one
before; the engine with the stage solver it chooses itself; and the reference engine (numpy). The
compiler gets ``-march=native`` and, as the engine does no such thing either, ``-ffp-contract=off``;
``-fno-math-errno``, which the square root of C needs to be one instruction; and ``-O3`` or ``-O2``,
whichever makes the loop faster. The same source is compiled once more with contraction, where a
product and a sum become one operation, and then stands beside the engine's ``arithmetic="fused"``.
"""

from __future__ import annotations

import ctypes
import shutil
import statistics
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from glmref.catalogue.lookup import load
from glmref.engine.forms import StepForm
from glmref.engine.kernel import Kernel, prepare
from glmref.engine.reference import stepper
from glmref.engine.starting_values import zero_start
from glmref.problems import problem
from glmref.problems.model import Problem
from tools.measure.timing import interleaved, quartiles, ratios

SOURCES = Path(__file__).parent / "c"
FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-fno-math-errno")

#: Name -> (macro of the C source, parameters, step size).
PROBLEMS: dict[str, tuple[str, dict[str, Any], float]] = {
    "kepler": ("KEPLER", {"eccentricity": "3/5"}, 2 * np.pi / 250),
    "henon-heiles": ("HENON_HEILES", {}, 0.1),
    "outer-solar-system": ("OUTER", {}, 50.0),
    "pendulum": ("PENDULUM", {}, 0.1),
}
METHODS = ("rk4", "gauss-3", "g6245", "stormer-verlet")
#: Explicit pairs and splittings, which share one loop in C.
SWEEPS = ("pair-4-6", "pair-6-8", "pair-rkn-6-8b", "yoshida-verlet-6", "blanes-moan-rkn-6-14")
CHECKED_STEPS = 1000
PILOT_STEPS = 5000
#: Optimisation levels that are tried; later options of the compiler overrule :data:`FLAGS`.
LEVELS = ("-O3", "-O2")
CONTRACTED = "-ffp-contract=fast"

Loop = Callable[..., int]


@dataclass(frozen=True)
class Row:
    """One method on one problem."""

    #: What was run.
    method: str
    problem: str
    solver: str
    level: str  #: Optimisation level of the C loop, the better one.
    same_bits: bool  #: Whether C and engine end in the same state.
    evaluations: float  #: Evaluations of the force per step, of the arithmetic that C has as well.
    #: Name of the competitor -> quartiles of the time of one step; ``force`` is one evaluation of
    #: the force, ``chosen`` the engine with the solver named in ``solver``, ``contracted`` the C
    #: loop compiled with contraction, ``fused`` the engine with it.
    nanoseconds: dict[str, tuple[float, float, float]]
    #: Quartiles of the ratio of times; 1 and above: the engine is no slower than C.
    c_over_engine: tuple[float, float, float]
    contracted_over_fused: tuple[float, float, float]  #: The same for both with contraction.
    engine_over_force: float  #: Time of a step over that of its evaluations alone, medians.
    reference_over_engine: float  #: How much slower the numpy reference is, medians.


def compiler() -> str | None:
    """Return the path of a C compiler, or ``None``."""
    return shutil.which("gcc") or shutil.which("cc") or shutil.which("clang")


def compiler_version() -> str:
    """Return the first line of what the compiler says of itself."""
    command = [str(compiler()), "--version"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[
        0
    ]


def built(source: str, macro: str, folder: Path, *options: str) -> Loop:
    """Compile one loop for one problem: ``run(y, par, h, steps)``, which returns evaluations.

    The library lies in the folder; a file ``table.h`` in it is what the source includes by that
    name. The options of the compiler come after :data:`FLAGS`.
    """
    library = folder / f"{source}{''.join(options)}.so"  # a library is loaded once by its path
    command = [str(compiler()), *FLAGS, *options, "-shared", "-fPIC", f"-D{macro}", f"-I{folder}"]
    subprocess.run([*command, "-o", str(library), str(SOURCES / f"{source}.c"), "-lm"], check=True)
    run = ctypes.CDLL(str(library)).run
    run.restype = ctypes.c_long
    run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_long]
    return run


def fastest(
    source: str, macro: str, folder: Path, run: Callable[[int, Loop], object]
) -> tuple[Loop, str, float]:
    """Compile a loop at every level: the fastest, its level, and its seconds per step."""
    loops = {level: built(source, macro, folder, level) for level in LEVELS}
    runs = {level: partial(run, PILOT_STEPS, loop) for level, loop in loops.items()}
    spent = {level: statistics.median(times) for level, times in interleaved(runs, 9).items()}
    level = min(LEVELS, key=lambda x: spent[x])
    return loops[level], level, spent[level] / PILOT_STEPS


def sweep_table(form: StepForm) -> str:
    """Return the file ``table.h`` for ``sweep.c``: the stages of a pair, numbers in hexadecimal.

    Raises
    ------
    ValueError
        For a pair that ``sweep.c`` is not written for.
    """
    signs = ((1.0,),) if form.r == 1 else ((1.0, 0.0), (0.0, -1.0))
    q, p = form.components
    ones = all(U[0] == 1.0 for U in q.U + p.U)
    if form.kind != "sweep" or form.keeps_force or not q.V == p.V == signs or not ones:
        raise ValueError("sweep.c is written for V = 1 or diag(1, -1) and first couplings of one")
    stages = []
    for block in form.blocks:
        (node,) = block.stages
        k, i = form.place(node)
        half, coupling = form.components[k], form.components[k].U[i][1] if form.r == 2 else 0.0
        stages.append(f"{'QP'[k]}({i}, {half.weights[i].hex()}, {coupling.hex()})")
    return f"#define VALUES {form.r}\n#define TABLE " + " \\\n    ".join(stages) + "\n"


class Case:
    """One method on one problem, ready to run in every way."""

    def __init__(self, name: str, of: str, folder: Path) -> None:
        macro, parameters, self.h = PROBLEMS[of]
        self.problem: Problem = problem(of, **parameters)
        self.method = load(name)
        self.kernel = prepare(self.method, self.problem, h=self.h, solver="fixed-point")
        self.chosen = prepare(self.method, self.problem, h=self.h)
        self.fused = prepare(
            self.method, self.problem, h=self.h, solver="fixed-point", arithmetic="fused"
        )
        own = folder / f"{name}-{of}"
        own.mkdir()
        source = name.replace("-", "_")
        if name in SWEEPS:
            source = "sweep"
            (own / "table.h").write_text(sweep_table(self.kernel.form), encoding="utf-8")
        self.stepper = stepper(self.method, self.problem)
        self.start = zero_start(self.stepper, self.problem.y0)
        self.force, _, _ = fastest("bare", macro, own, self.forces)
        self.loop, self.level, self.seconds = fastest(source, macro, own, self.c)
        self.contracted = built(source, macro, own, self.level, CONTRACTED)
        self.slope = np.asarray(self.problem.f(0.0, self.start[0]))
        self.out = np.zeros(1)

    def engine(self, kernel: Kernel, steps: int) -> tuple[np.ndarray, int]:
        """Return all steps in one call of a kernel: values and evaluations."""
        state = kernel.state(self.start, self.slope, self.h)
        outcome = kernel.built.kernel(
            state.work, kernel.shape.values, 0.0, self.h, 0, steps, -1, 0, self.out, 0, state.tally
        )
        if outcome:
            raise ArithmeticError(f"{self.method.name} on {self.problem.name} did not complete")
        return kernel.values(state), int(state.tally[0])

    def c(self, steps: int, loop: Loop | None = None) -> tuple[np.ndarray, int]:
        """Return the same by the C loop, or by another one."""
        y = np.ascontiguousarray(self.kernel.form.into(self.start))
        par = self.kernel.shape.values
        evaluations = (loop or self.loop)(y.ctypes.data, par.ctypes.data, self.h, steps)
        if evaluations < 0:
            raise ArithmeticError(f"C: {self.method.name} on {self.problem.name} did not complete")
        return self.kernel.form.back(y), evaluations

    def forces(self, count: int, loop: Loop | None = None) -> None:
        """Evaluate the force ``count`` times in C, each time where the last one led."""
        q = np.array(self.problem.y0[: self.problem.dimension // 2], dtype=float)
        (loop or self.force)(q.ctypes.data, self.kernel.shape.values.ctypes.data, 2.0**-60, count)

    def reference(self, steps: int) -> None:
        """Take steps with the reference engine."""
        values = self.start
        for n in range(steps):
            values = self.stepper.step(n * self.h, values, self.h).values


def measure(name: str, of: str, folder: Path, *, repeats: int, seconds: float) -> Row:
    """Time one method on one problem; every run takes about ``seconds``."""
    case = Case(name, of, folder)
    ours, theirs = case.engine(case.kernel, CHECKED_STEPS), case.c(CHECKED_STEPS)
    steps = max(CHECKED_STEPS, round(seconds / case.seconds))
    per_step, slow = ours[1] / CHECKED_STEPS, 20
    count = round(steps * per_step)
    spent = interleaved(
        {
            "c": lambda: case.c(steps),
            "contracted": lambda: case.c(steps, case.contracted),
            "engine": lambda: case.engine(case.kernel, steps),
            "fused": lambda: case.engine(case.fused, steps),
            "chosen": lambda: case.engine(case.chosen, steps),
            "force": lambda: case.forces(count),
            "reference": lambda: case.reference(slow),
        },
        repeats,
    )
    per = dict.fromkeys(spent, steps) | {"force": count, "reference": slow}
    scaled = {key: [1e9 * x / per[key] for x in times] for key, times in spent.items()}
    found = {key: quartiles(times) for key, times in scaled.items()}
    return Row(
        method=name,
        problem=of,
        solver=case.chosen.options.solver if case.chosen.form.implicit_stages else "",
        level=case.level,
        same_bits=bool(np.array_equal(ours[0], theirs[0])) and ours[1] == theirs[1],
        evaluations=per_step,
        nanoseconds=found,
        c_over_engine=quartiles(ratios(spent, "c", "engine")),
        contracted_over_fused=quartiles(ratios(spent, "contracted", "fused")),
        engine_over_force=quartiles(
            [a / (b * per_step) for a, b in zip(scaled["engine"], scaled["force"], strict=True)]
        )[1],
        reference_over_engine=quartiles(ratios(scaled, "reference", "engine"))[1],
    )


def measure_all(*, repeats: int = 15, seconds: float = 0.03) -> list[Row]:
    """Return every method on the first three problems; empty where there is no C compiler."""
    return _rows([(name, of) for of in list(PROBLEMS)[:3] for name in METHODS], repeats, seconds)


def measure_sweeps(*, repeats: int = 15, seconds: float = 0.03) -> list[Row]:
    """Return pairs and splittings on all problems; empty where there is no C compiler."""
    return _rows([(name, of) for of in PROBLEMS for name in SWEEPS], repeats, seconds)


def _rows(cases: Sequence[tuple[str, str]], repeats: int, seconds: float) -> list[Row]:
    if compiler() is None:
        return []
    with tempfile.TemporaryDirectory() as folder:
        return [
            measure(name, of, Path(folder), repeats=repeats, seconds=seconds) for name, of in cases
        ]
