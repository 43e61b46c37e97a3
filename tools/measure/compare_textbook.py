"""The engine beside plain C: ``python -m tools.measure.compare_textbook [--write] [NAME ...]``.

``tools/measure/c/textbook.c`` states each method by its formulas, in an order of operations of its
own, so that bits differ; its author had not read the engine, but for that of ``g6245-w3``. Names
are of methods and problems; ``--write`` puts the table of all of them into the ``README.md`` of
this folder. Four kinds of it are compiled, with and without compensated sums and fused operations,
each at ``-O3`` and at ``-O2``, of which the faster one counts. The engine stands beside them with
``arithmetic="strict"`` and ``"fused"``, which both compensate. Processor time of one thread, least
of interleaved repetitions, of the loop over steps alone: the runs are so long that the call
itself, some ten microseconds on the side of the engine, is below a hundredth.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from campaigns import pages
from glmref import load, problem
from glmref.engine.kernel import Kernel, State, prepare
from glmref.engine.reference import stepper
from glmref.engine.starting_values import starting_values
from glmref.exact import Scalar
from glmref.method import GLM, PartitionedGLM
from glmref.method.component import SEPARABLE
from tools.measure.compare_c import CONTRACTED, PROBLEMS, Loop, built
from tools.measure.timing import interleaved

#: Method -> macro of its C source.
METHODS = {
    "stormer-verlet": "VERLET",
    "rk4": "RK4",
    "gauss-3": "GAUSS",
    "pair-rkn-6-8b": "PAIR",
    "multistep-rkn-8": "MULTISTEP",
    "multistep-rkn-10": "MULTISTEP",
    "multistep-rkn-12": "MULTISTEP",
    "multivalue-rkn-10": "TWO_KICKS",
    "multivalue-rkn-12": "TWO_KICKS",
    "g6245-w3": "GLM",
}
#: Steps of one run.
STEPS = {"kepler": 500_000, "henon-heiles": 500_000, "outer-solar-system": 50_000}
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
PAGE = Path(__file__).with_name("README.md")


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


def rows(name: str, matrix: object) -> str:
    """Return a matrix as a constant of C."""
    values = [[float(x) for x in row] for row in matrix]  # type: ignore[attr-defined]
    inner = ", ".join("{" + ", ".join(x.hex() for x in row) + "}" for row in values)
    return f"static const double {name}[{len(values)}][{len(values[0])}] = {{{inner}}};\n"


def glm_table(method: GLM) -> str:
    """Write ``table.h``: numbers of a general linear method, no stage after those it reads."""
    if not all(x.is_zero() for i, row in enumerate(method.A) for x in row[i + 1 :]):
        raise ValueError("textbook.c is written for stages one after the other")
    times = ", ".join(float(x).hex() for x in method.times[0])
    return (
        f"enum {{ S = {method.s}, R = {method.r} }};\nstatic const double C[S] = {{{times}}};\n"
        + "".join(rows(letter, getattr(method, letter)) for letter in "AUBV")
    )


def table(pair: PartitionedGLM) -> str:
    """Return the file ``table.h``: numbers of an explicit pair with V = diag(1, -1)."""
    if pair.r != 2 or [[float(x) for x in row] for row in pair.V] != [[1, 0], [0, -1]]:
        raise ValueError("textbook.c is written for V = diag(1, -1)")
    order = [j for block in pair.stage_blocks(SEPARABLE) for j in block.stages]
    names = [f"QSTAGE({j})" if j < pair.n_Q else f"PSTAGE({j - pair.n_Q})" for j in order]
    return (
        f"enum {{ NQ = {pair.n_Q}, NP = {pair.n_P} }};\n#define STAGES {' '.join(names)}\n"
        + rows("AQ", pair.A) + rows("AP", pair.A_hat) + rows("UQ", pair.U)
        + rows("UP", pair.U_hat) + rows("BQ", pair.B) + rows("BP", pair.B_hat)
    )  # fmt: skip


def multistep_table(method: PartitionedGLM) -> str:
    """Write ``table.h``: numbers of a multistep method of :mod:`glmref.derive.multistep`."""
    places = range(1, method.r_hat, 2)
    return pairs_of_roots(
        TWICE=[method.V_hat[j][j] for j in places],
        ALPHA=[method.U_hat[0][j] for j in places],
    )


def two_kicks_table(method: PartitionedGLM) -> str:
    """Return the file ``table.h``: numbers of a :class:`glmref.derive.multistep.TwoKicks`."""
    places = range(1, method.r_hat, 2)
    first, kicks, V = method.U_hat[0], method.B_hat, method.V_hat
    weight = float(2 * kicks[0][2]).hex()
    return f"static const double W = {weight};\n" + pairs_of_roots(
        TWICE=[V[j][j] for j in places],
        FIRST_X=[first[j] for j in places],
        FIRST_Z=[first[j + 1] for j in places],
        # the second drift is the mirror image of the first
        SECOND_X=[first[j] for j in places],
        SECOND_Z=[-(V[j][j] * first[j] + first[j + 1]) for j in places],
        KICK_X=[kicks[j][1] for j in places],
        KICK_Z=[kicks[j + 1][1] for j in places],
    )


def pairs_of_roots(**numbers: Sequence[Scalar]) -> str:
    """Return arrays of C with one number for each pair, and how many pairs there are."""
    rows = (
        f"static const double {key}[PAIRS] = {{{', '.join(float(x).hex() for x in found)}}};\n"
        for key, found in numbers.items()
    )
    count = len(next(iter(numbers.values())))
    return f"enum {{ PAIRS = {count} }};\n{''.join(rows)}"


#: Macro of a C source -> what writes its numbers.
TABLES: dict[str, Callable[[Any], str]] = {
    "PAIR": table,
    "MULTISTEP": multistep_table,
    "TWO_KICKS": two_kicks_table,
    "GLM": glm_table,
}


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
    written = TABLES.get(METHODS[name])
    if written is not None:
        (own / "table.h").write_text(written(method), encoding="utf-8")
    engines = {
        arithmetic: prepare(method, subject, h=h, arithmetic=arithmetic, solver="fixed-point")
        for arithmetic in ("strict", "fused")
    }
    start = starting_values(
        stepper(method, subject),
        "zero" if name.startswith("pair") else None,
        t=0.0,
        y0=np.asarray(subject.y0),
        h=h,
    ).values
    slope, out = np.asarray(subject.f(0.0, start[0])), np.zeros(1)

    def by_engine(kernel: Kernel, steps: int = steps) -> State:
        state = kernel.state(start, slope, h)
        numbers = (0.0, h, 0, steps, -1, 0)
        kernel.built.kernel(state.work, kernel.shape.par, *numbers, out, 0, state.tally)
        return state

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
    strict = engines["strict"]
    expected = strict.values(by_engine(strict, _CHECKED))[0]
    for loop in loops.values() if name != "stormer-verlet" else ():  # drifts first there
        if np.abs(by_c(loop, _CHECKED)[0] - expected).max() > _NEAR * np.abs(expected).max():
            raise ArithmeticError(f"C and engine do not agree: {name} on {of}")
    spent = {k: 1e9 * min(v) / steps for k, v in interleaved(runs, repeats).items()}  # type: ignore[arg-type]
    c = {kind: min(spent[kind, level] for level in ("-O3", "-O2")) for kind in KINDS}  # type: ignore[index]
    return Row(name, of, c, {key: spent[key] for key in engines})  # type: ignore[index]


HEADS = (
    "problem", "method", "C, comp.", "C, comp., fma", "C", "C, fma", "engine", "engine, fused",
    "C / engine", "both fused",
)  # fmt: skip


def line(row: Row) -> str:
    """Return a row of the table."""
    numbers = [f"{x:.4g}" for x in (*row.c.values(), *row.engine.values())]
    cells = [row.problem, row.method, *numbers, f"**{row.ratio:.2f}**", f"{row.fused_ratio:.2f}"]
    return f"| {' | '.join(cells)} |"


def main(wanted: Sequence[str] = (), *, write: bool = False) -> None:
    """Print a row for each method and problem, or for those named."""
    lines = [f"| {' | '.join(HEADS)} |", f"|{' --- |' * len(HEADS)}"]
    sys.stdout.write("\n".join(lines) + "\n")
    with tempfile.TemporaryDirectory() as folder:
        for of in STEPS:
            for name in METHODS:
                if wanted and not {name, of} & set(wanted):
                    continue
                lines.append(line(measured(name, of, Path(folder))))
                sys.stdout.write(lines[-1] + "\n")
                sys.stdout.flush()
    if write:
        pages.write({PAGE: {"textbook": lambda: "\n".join(lines)}})


if __name__ == "__main__":
    names = [name for name in sys.argv[1:] if name != "--write"]
    main(names, write="--write" in sys.argv and not names)
