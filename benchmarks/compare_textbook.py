"""The compiled engine beside plain C from the textbook: ``python -m benchmarks.compare_textbook``.

``benchmarks/c/textbook.c`` states each method as a textbook does, in an order of operations of its
own, so that bits differ. Four kinds of it are compiled, with and without compensated sums and with
and without fused operations, each at ``-O3`` and at ``-O2``, of which the faster one counts. The
engine stands beside them with ``arithmetic="strict"`` and
``"fused"``, which both compensate. Processor time of one thread, least of interleaved repetitions.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.compare_c import CONTRACTED, PROBLEMS, Loop, built
from benchmarks.timing import interleaved
from glmref import load, problem
from glmref.engine.kernel import Kernel, prepare
from glmref.engine.reference import stepper
from glmref.engine.start import zero_start
from glmref.method import PartitionedGLM
from glmref.method.component import SEPARABLE

__all__ = ["METHODS", "Row", "measured"]

#: Method -> macro of its C source.
METHODS = {"stormer-verlet": "VERLET", "rk4": "RK4", "gauss-3": "GAUSS", "pair-rkn-6-8b": "PAIR"}
#: Steps of one run.
STEPS = {"kepler": 200_000, "henon-heiles": 200_000, "outer-solar-system": 20_000}
#: Steps after which C and engine are compared.
_CHECKED = 200
#: What is compiled: name -> options beside the optimisation level.
KINDS = {
    "compensated": ("-DCOMPENSATED",),
    "compensated, fused": ("-DCOMPENSATED", CONTRACTED),
    "plain": (),
    "plain, fused": (CONTRACTED,),
}
_NEAR = 1e-9


@dataclass(frozen=True)
class Row:
    """Nanoseconds of one step: ``c`` by the names of :data:`KINDS`, ``engine`` by arithmetic."""

    method: str
    problem: str
    c: dict[str, float]
    engine: dict[str, float]

    @property
    def ratio(self) -> float:
        """Compensated C over the engine, neither fused."""
        return self.c["compensated"] / self.engine["strict"]

    @property
    def fused_ratio(self) -> float:
        """Compensated C over the engine, both fused."""
        return self.c["compensated, fused"] / self.engine["fused"]


def table(pair: PartitionedGLM) -> str:
    """The file ``table.h``: numbers of an explicit pair with V = diag(1, -1)."""

    def rows(name: str, matrix: object) -> str:
        values = [[float(x) for x in row] for row in matrix]  # type: ignore[attr-defined]
        inner = ", ".join("{" + ", ".join(x.hex() for x in row) + "}" for row in values)
        return f"static const double {name}[{len(values)}][{len(values[0])}] = {{{inner}}};\n"

    if pair.r != 2 or [[float(x) for x in row] for row in pair.V] != [[1, 0], [0, -1]]:
        raise ValueError("textbook.c is written for V = diag(1, -1)")
    order = [j for block in pair.stage_blocks(SEPARABLE) for j in block.stages]
    names = [f"QSTAGE({j})" if j < pair.n_Q else f"PSTAGE({j - pair.n_Q})" for j in order]
    return (
        f"enum {{ NQ = {pair.n_Q}, NP = {pair.n_P} }};\n#define STAGES {' '.join(names)}\n"
        + rows("AQ", pair.A) + rows("AP", pair.A_hat) + rows("UQ", pair.U)
        + rows("UP", pair.U_hat) + rows("BQ", pair.B) + rows("BP", pair.B_hat)
    )  # fmt: skip


def measured(name: str, of: str, folder: Path, *, repeats: int = 11) -> Row:
    """Time one method on one problem.

    Raises
    ------
    ArithmeticError
        Where C and engine do not agree.
    """
    macro, parameters, h = PROBLEMS[of]
    subject, method, steps = problem(of, **parameters), load(name), STEPS[of]
    own = folder / f"{name}-{of}"
    own.mkdir()
    if isinstance(method, PartitionedGLM) and name.startswith("pair"):
        (own / "table.h").write_text(table(method), encoding="utf-8")
    engines = {
        arithmetic: prepare(method, subject, h=h, arithmetic=arithmetic, solver="fixed-point")
        for arithmetic in ("strict", "fused")
    }
    start = zero_start(stepper(method, subject), subject.y0)
    slope, out = np.asarray(subject.f(0.0, start[0])), np.zeros(1)

    def by_engine(kernel: Kernel, steps: int = steps) -> np.ndarray:
        state = kernel.state(start, slope, h)
        numbers = (0.0, h, 0, steps, -1, 0)
        kernel.built.kernel(state.work, kernel.shape.par, *numbers, out, 0, state.tally)
        return kernel.values(state)

    def by_c(loop: Loop, steps: int = steps) -> np.ndarray:
        y, par = start.copy(), engines["strict"].shape.values
        if loop(y.ctypes.data, par.ctypes.data, h, steps) < 0:
            raise ArithmeticError(f"C: {name} on {of} did not complete")
        return y

    loops = {
        (kind, level): built("textbook", macro, own, f"-D{METHODS[name]}", level, *options)
        for kind, options in KINDS.items()
        for level in ("-O3", "-O2")
    }
    runs = {key: (lambda loop=loop: by_c(loop)) for key, loop in loops.items()}
    runs |= {key: (lambda kernel=kernel: by_engine(kernel)) for key, kernel in engines.items()}
    expected = by_engine(engines["strict"], _CHECKED)[0]
    for loop in loops.values() if name != "stormer-verlet" else ():  # drifts first there
        if np.abs(by_c(loop, _CHECKED)[0] - expected).max() > _NEAR * np.abs(expected).max():
            raise ArithmeticError(f"C and engine do not agree: {name} on {of}")
    spent = {k: 1e9 * min(v) / steps for k, v in interleaved(runs, repeats).items()}  # type: ignore[arg-type]
    c = {kind: min(spent[kind, level] for level in ("-O3", "-O2")) for kind in KINDS}  # type: ignore[index]
    return Row(name, of, c, {key: spent[key] for key in engines})  # type: ignore[index]


def main() -> None:
    """Print a row for each method and problem, or for those named."""
    wanted = sys.argv[1:]
    heads = ["problem", "method", *KINDS, "engine", "engine, fused", "C / engine", "fused"]
    sys.stdout.write("| " + " | ".join(heads) + " |\n|" + " --- |" * len(heads) + "\n")
    with tempfile.TemporaryDirectory() as folder:
        for of in STEPS:
            for name in METHODS:
                if wanted and not {name, of} & set(wanted):
                    continue
                row = measured(name, of, Path(folder))
                numbers = [*row.c.values(), *row.engine.values()]
                cells = [of, name, *(f"{x:.4g}" for x in numbers)]
                cells += [f"**{row.ratio:.2f}**", f"{row.fused_ratio:.2f}"]
                sys.stdout.write("| " + " | ".join(cells) + " |\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
